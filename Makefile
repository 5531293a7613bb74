# SPDX-License-Identifier: Apache-2.0
# glarepp: build, install. `make help` lists the targets; those that test, measure and
# lint are in tests/Makefile. V=1 prints whole commands.
#
# Objects are in build/; only the man page and compile_commands.json are written
# beside the sources.

VERSION := 0.1.0
PREFIX ?= /usr/local
LIB ?= lib# below PREFIX
DESTDIR ?=
B ?= build
CC ?= cc
CXX ?= c++
AR ?= ar
PKG_CONFIG ?= pkg-config

PACKAGES := OpenEXR libpng libdeflate jansson
pc = $(shell $(PKG_CONFIG) $(1) $(2) 2>/dev/null)

WARN := -Wall -Wextra -Wconversion -Werror
OPT ?= -O3
# binaries do not contain the build folder: the same source makes the same
# program anywhere
HERE := -fdebug-prefix-map=$(CURDIR)=. -fdebug-prefix-map=$(B)/=build/
DEFS := -D_GNU_SOURCE -DGP_VERSION='"$(VERSION)"' \
        -DGP_BRIDGE_DIR='"$(PREFIX)/lib/glarepp"'
# (lines for traces, but no variables: CFLAGS=-g has these, and takes longer)
CFLAGS ?= -g1
# (hidden code that may lie anywhere serves programs, archive and shared library: a
# default run takes as long as with -fPIE)
ALL_CFLAGS = -std=c11 $(OPT) -ffp-contract=off -fno-trapping-math -fno-math-errno -Wno-psabi -fPIC -fvisibility=hidden $(WARN) $(CFLAGS) $(HERE) \
             $(HARDEN_CC) $(DEFS) -pthread -Isrc -I$(B) $(call pc,--cflags,$(PACKAGES)) $(SAN)
CXX_FLAGS = -std=c++17 $(OPT) -Wall -Wextra -Werror $(HERE) $(HARDEN_CXX) -Isrc
# only OpenEXRCore: OpenEXR.pc would link the C++ library too
LIBS = -lOpenEXRCore $(call pc,--libs,libpng libdeflate jansson) -lm -ldl $(SAN_LIBS)
LINK = -pthread -Wl,--as-needed $(SAN) $(HARDEN_LINK)

# $(call say,WHAT,FILE): starts a recipe's line, which is printed whole with V=1
say = $(if $(V),,@printf '%-4s %s\n' '$(1)' '$(2)';)
compile = @mkdir -p $(@D)$(newline)$(call say,CC,$<)$(CC) $(ALL_CFLAGS) $(1) -MMD -MP -c -o $@ $<
define newline


endef

# -- hardening ----------------------------------------------------------------

# $(call takes,COMPILER,LANGUAGE,FLAGS): those that it accepts, each tried by itself
takes = $(shell for f in $(3); do \
    echo 'int main(void) { return 0; }' | $(1) -Werror $(OPT) $$f \
        -include stdio.h -x $(2) -o /dev/null - >/dev/null 2>&1 && echo $$f; \
    done)
# Fortified calls need optimised code, and hide faults from sanitizers. With a
# compiler that cannot do level 3, glibc's headers are an error of the preprocessor
HARDEN_FLAGS := -fstack-protector-strong -fstack-clash-protection \
              -fcf-protection -mbranch-protection=standard
FORTIFY = $(if $(filter -O0,$(OPT) $(CFLAGS)),,-U_FORTIFY_SOURCE \
    $(lastword -D_FORTIFY_SOURCE=2 $(call takes,$(1),$(2),-D_FORTIFY_SOURCE=3)))
harden = $(if $(SAN),,$(call takes,$(1),$(2),$(HARDEN_FLAGS)) $(FORTIFY))
# (the compiler is asked once, by the first recipe)
HARDEN_CC = $(eval HARDEN_CC := $$(call harden,$$(CC),c))$(HARDEN_CC)
HARDEN_CXX = $(eval HARDEN_CXX := $$(call harden,$$(CXX),c++))$(HARDEN_CXX)
HARDEN_SO := $(if $(SAN),,-Wl,-z,relro,-z,now,-z,noexecstack)
HARDEN_LINK = $(if $(SAN),,-pie $(HARDEN_SO))

# -- files --------------------------------------------------------------------

SRC := $(sort $(shell find src -name '*.c'))
HDR := $(sort $(shell find src -name '*.h'))
SHADERS := $(wildcard src/gl/shaders/*)
OIIO_SRC := $(wildcard src/io/oiio/*.cpp)
OCIO_SRC := src/tone/ocio_bridge.cpp
BRIDGES := $(B)/glarepp-oiio $(B)/glarepp-ocio.so

OBJ := $(SRC:src/%.c=$(B)/%.o) $(B)/gl/shaders.o $(B)/cli/page/text.o
ROOM_OBJ := $(filter-out %/main.o,$(OBJ))
LIB_ROOMS := api compare core gl glare scene sun tone
LIB_OBJ := $(filter $(LIB_ROOMS:%=$(B)/%/%),$(OBJ))
LIBRARY := $(B)/libglarepp.a $(B)/libglarepp.so.0

.PHONY: all help demo man install uninstall deb deps clean
all: $(B)/glarepp $(LIBRARY) $(BRIDGES) man compile_commands.json ## first: builds the program, its bridges and the man page

# `## GROUP: what` after a target's name is its line here
help: ## first: lists the targets; make TARGET V=1 prints whole commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { split($$2, w, ": "); \
	    t[w[1]] = t[w[1]] sprintf("  %-16s%s\n", $$1, substr($$2, length(w[1]) + 3)) } \
	    END { n = split("first test lint measure install", g, " "); \
	    for (i = 1; i <= n; i++) printf("%s%s:\n%s", i > 1 ? "\n" : "", g[i], t[g[i]]) }' \
	    $(filter %Makefile,$(MAKEFILE_LIST))

# -- build --------------------------------------------------------------------

$(B)/glarepp: $(filter-out $(LIB_OBJ),$(OBJ)) $(B)/libglarepp.a
	$(call say,LD,$@)$(CC) $(LINK) -o $@ $^ $(LIBS)

$(B)/%.o: src/%.c
	$(compile)

# The bytes of the GLSL files, for the program
$(B)/gl/shaders.c: $(SHADERS) Makefile
	@mkdir -p $(@D)
	@{ echo '#include "gl/gl_priv.h"'; \
	   echo 'const struct gp_shader_file gp_shader_files[] = {'; \
	   for f in $(SHADERS); do \
	     printf '{"%s", (const char[]) {' "$${f##*/}"; \
	     od -An -v -tx1 $$f | sed 's/ \([0-9a-f]*\)/0x\1,/g'; \
	     echo '0}},'; done; echo '{0, 0}};'; } > $@

# The text of pages before and after what they show, with style, script and the hashes
# that allow these two and nothing else
PAGE := $(addprefix src/cli/page/page.,html css js)
$(B)/cli/page/text.c: $(PAGE) src/cli/page/page.awk Makefile
	@mkdir -p $(@D)
	@LC_ALL=C awk -f src/cli/page/page.awk -v css="$$(sha256sum <src/cli/page/page.css)" \
	    -v js="$$(sha256sum <src/cli/page/page.js)" src/cli/page/page.html >$@.tmp
	@mv $@.tmp $@

$(B)/gl/shaders.o $(B)/cli/page/text.o: $(B)/%.o: $(B)/%.c
	$(compile)

-include $(OBJ:.o=.d)

# The library is all rooms that its header opens. What glarepp.h declares between
# `#pragma GCC visibility push(default)` and pop is what the shared library shows. (The
# map hides what gcc shows of functions in copies for several processors.)
$(B)/libglarepp.a: $(LIB_OBJ)
	@rm -f $@
	$(call say,AR,$@)$(AR) rcs $@ $^

$(B)/libglarepp.so.0: $(LIB_OBJ)
	$(call say,LD,$@)$(CC) -shared -Wl,-soname,$(@F) $(if $(SAN),,-Wl,-z,defs) \
	    -Wl,--version-script=src/api/libglarepp.map -pthread -Wl,--as-needed $(SAN) $(HARDEN_SO) \
	    -o $@ $^ $(call pc,--libs,jansson) -lm -ldl

# C++ is in a helper program and a shared object, which are started and opened only
# when needed. The helper is built without sanitizers: it exists to contain
# OpenImageIO's faults; its files are compiled as one, as its headers take 3 s each time
$(B)/glarepp-oiio: $(OIIO_SRC) src/io/oiio/protocol.h
	@mkdir -p $(@D)
	$(call say,CXX,$@)$(CXX) $(CXX_FLAGS) $(filter-out $(COUNTED),$(CFLAGS)) -fPIE -pie $(HARDEN_SO) -pthread \
	    -o $@ $(addprefix -include ,$(wordlist 2,9,$(OIIO_SRC))) $(firstword $(OIIO_SRC)) \
	    $(call pc,--cflags --libs,OpenImageIO)

$(B)/glarepp-ocio.so: $(OCIO_SRC) src/tone/ocio_bridge.h src/core/status.h src/glarepp.h
	@mkdir -p $(@D)
	$(call say,CXX,$@)$(CXX) $(CXX_FLAGS) $(CFLAGS) -fPIC -shared $(HARDEN_SO) -fvisibility=hidden \
	    -o $@ $(OCIO_SRC) $(call pc,--cflags --libs,OpenColorIO)

# -- the man page ---------------------------------------------------------------

$(B)/table: $(B)/glarepp
	@$< --help-table >$@

$(B)/glarepp.1: man/glarepp.1.in man/page.awk $(B)/table
	@LC_ALL=C awk -f man/page.awk $(B)/table $< >$@.tmp
	@mv $@.tmp $@

man: $(B)/glarepp.1 ## install: makes man/glarepp.1 from the option table and the .in file
	@cmp -s $< man/glarepp.1 || cp $< man/glarepp.1

# -- the two commands ---------------------------------------------------------

again = @$(MAKE) --no-print-directory
demo: ## first: installs missing packages, builds, renders the example frames
	$(again) deps
	$(again) -j$$(nproc) all
	@examples/demo.sh $(B)/glarepp $(B)/demo

check: ## first: installs missing packages, builds, runs every test
	$(again) deps
	$(again) -j$$(nproc) check-built
	$(again) check-all

-include tests/Makefile

# -- installing ---------------------------------------------------------------

# FILE=PLACE: what is installed, and where below PREFIX
DOC := share/doc/glarepp
COMPLETIONS := bash=share/bash-completion/completions/glarepp \
    zsh=share/zsh/site-functions/_glarepp fish=share/fish/vendor_completions.d/glarepp.fish
DOCUMENTS := README.md LICENSE $(wildcard man/*.md) \
    $(addprefix examples/,slurm.sh openjd.yaml parallel.sh blender_camera.py alley.glb \
        embed.c embed_many.c blender/README.md blender/glarepp_addon.py) \
    $(wildcard examples/lenses/*.json examples/flares/*.json)
INSTALLED = $(B)/glarepp=bin/glarepp $(foreach f,$(BRIDGES),$(f)=lib/glarepp/$(notdir $(f))) \
    $(COMPLETIONS:%=$(B)/completions.%) man/glarepp.1=share/man/man1/glarepp.1 \
    $(foreach f,$(DOCUMENTS),$(f)=$(DOC)/$(f)) \
    src/glarepp.h=include/glarepp.h $(foreach f,$(LIBRARY),$(f)=$(LIB)/$(notdir $(f))) \
    src/api/glarepp.pc.in=$(LIB)/pkgconfig/glarepp.pc
AT = '$(DESTDIR)$(PREFIX)/$(LIB)'

$(B)/completions.%: man/completions.awk $(B)/table
	@LC_ALL=C awk -v shell=$* -f $^ >$@

install: all $(foreach s,bash zsh fish,$(B)/completions.$(s)) ## first: installs program, manual, templates and completions under DESTDIR and PREFIX
	@set -e; for f in $(INSTALLED); do case $${f#*=} in \
	    bin/* | lib/glarepp/*) mode=755 ;; *) mode=644 ;; esac; \
	    install -D -m $$mode "$${f%%=*}" '$(DESTDIR)$(PREFIX)'/"$${f#*=}"; done; \
	    sed -i 's|@PREFIX@|$(PREFIX)|; s|@LIB@|$(LIB)|; s|@VERSION@|$(VERSION)|' $(AT)/pkgconfig/glarepp.pc; \
    ln -sf libglarepp.so.0 $(AT)/libglarepp.so

uninstall: ## install: removes the files of install
	@for f in $(INSTALLED); do rm -f '$(DESTDIR)$(PREFIX)'/"$${f#*=}"; done; rm -f $(AT)/libglarepp.so
	@-cd '$(DESTDIR)$(PREFIX)' 2>/dev/null && rmdir lib/glarepp \
	    $(DOC)/man $(DOC)/examples/lenses $(DOC)/examples/flares $(DOC)/examples/blender \
	    $(DOC)/examples $(DOC) 2>/dev/null

deb: all ## install: makes the Debian packages in build/
	@rm -rf $(B)/deb
	$(again) B=$(B) PREFIX=/usr DESTDIR=$(abspath $(B))/deb install \
	    LIB=lib/$$(dpkg-architecture -qDEB_HOST_MULTIARCH)
	@.ci/deb.sh $(B)/deb $(VERSION) $(B)

# Packages that a fresh Debian 12 lacks, to build, run and test
DEBIAN := gcc g++ make pkg-config libc6-dev libopenexr-dev libpng-dev \
          libdeflate-dev libjansson-dev libfftw3-dev libopenimageio-dev \
          libopencolorio-dev libgl-dev libegl-dev libosmesa6 libegl1 libegl-mesa0 \
          libgl1-mesa-dri libcmocka-dev openimageio-tools openexr mandoc valgrind \
          perl procps dpkg-dev \
          python3 python3-numpy python3-scipy python3-openimageio python3-pil
# Packages of a few tests, which are skipped without them
EXTRA := zsh fish parallel slurm-wlm munge python3-yaml clang libclang-rt-14-dev \
         clang-tidy clang-format cppcheck lintian strace qemu-user chromium
# (a node that is not Debian's brings npm, and refuses Debian's)
EXTRA += $(if $(shell command -v npm),,npm)
deps: ## install: installs the Debian packages that are missing
	@.ci/deps.sh "$(DEBIAN)" "$(EXTRA)"
	@-$(MAKE) --no-print-directory $(B)/axe.min.js

# The checks of pages for what eyes and screen readers need
AXE := axe-core@4.10.3
$(B)/axe.min.js:
	@mkdir -p $(B)/axe
	@cd $(B)/axe && timeout 60 npm pack --silent $(AXE) >/dev/null 2>&1 && tar -xzf *.tgz && \
	    cp package/axe.min.js .. || echo "deps: without $(AXE) of npm a test is skipped"

clean: ## install: removes build/
	@rm -rf $(B) compile_commands.json
