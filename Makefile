# glarepp: build, test, install. `make help` lists the targets.
#
# Objects go to build/; nothing is written beside the sources.

VERSION := 0.1.0
PREFIX ?= /usr/local
DESTDIR ?=
B ?= build
CC ?= cc
CXX ?= c++
AR ?= ar
PKG_CONFIG ?= pkg-config

PACKAGES := OpenEXR libpng libdeflate jansson fftw3f fftw3
pc = $(shell $(PKG_CONFIG) $(1) $(2) 2>/dev/null)

WARN := -Wall -Wextra -Wconversion -Werror
OPT ?= -O3
DEFS := -D_GNU_SOURCE -DGP_VERSION='"$(VERSION)"' \
        -DGP_BRIDGE_DIR='"$(PREFIX)/lib/glarepp"'
CFLAGS ?= -g
ALL_CFLAGS = -std=c11 $(OPT) -fno-trapping-math -fno-math-errno -Wno-psabi $(WARN) $(CFLAGS) $(DEFS) -fopenmp -Isrc -I$(B) \
             $(call pc,--cflags,$(PACKAGES)) $(SAN)
# OpenEXRCore alone: OpenEXR.pc would bring the C++ library along
LIBS = -lOpenEXRCore $(call pc,--libs,libpng libdeflate jansson) -lm -ldl
LINK = -fopenmp -Wl,--as-needed $(SAN)

# -- what there is ------------------------------------------------------------

ROOMS := core gl io glare tone app
SRC := $(foreach r,$(ROOMS),$(wildcard src/$(r)/*.c))
HDR := $(foreach r,$(ROOMS),$(wildcard src/$(r)/*.h))
SHADERS := $(wildcard src/gl/shaders/*)
BRIDGE_SRC := $(wildcard src/io/*.cpp)
UNIT := $(wildcard tests/unit/test_*.c)

OBJ := $(SRC:src/%.c=$(B)/%.o) $(B)/gl/shaders.o
LIB_OBJ := $(filter-out $(B)/app/main.o,$(OBJ))
BRIDGES := $(if $(BRIDGE_SRC),$(B)/glarepp-oiio.so)
UNIT_BIN := $(UNIT:tests/unit/%.c=$(B)/tests/%)

.PHONY: all help demo check check-asan check-ubsan check-valgrind check-headers \
        check-rooms check-size check-man unit bench man install uninstall deps \
        clean compile_commands
all: $(B)/glarepp $(BRIDGES) man

help: ## lists the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 18

# -- build --------------------------------------------------------------------

$(B)/glarepp: $(OBJ)
	$(CC) $(LINK) -o $@ $^ $(LIBS)

$(B)/%.o: src/%.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

# GLSL stays in real files; this lists their bytes for the program
$(B)/gl/shaders.c: $(SHADERS) Makefile
	@mkdir -p $(@D)
	@{ echo '#include "gl/shaders.h"'; \
	   echo 'const struct gp_shader_file gp_shader_files[] = {'; \
	   for f in $(SHADERS); do \
	     printf '{"%s", (const char[]) {' "$${f##*/}"; \
	     od -An -v -tx1 $$f | sed 's/ \([0-9a-f]*\)/0x\1,/g'; \
	     echo '0}},'; done; echo '{0, 0}};'; } > $@

$(B)/gl/shaders.o: $(B)/gl/shaders.c
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

# C++ lives in this one shared object, opened only when a file needs it
$(B)/glarepp-oiio.so: $(BRIDGE_SRC) src/io/oiio.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(OPT) -Wall -Wextra -Werror $(CFLAGS) -fPIC -shared \
	    -Isrc -fvisibility=hidden -o $@ $(BRIDGE_SRC) \
	    $(call pc,--cflags --libs,OpenImageIO)

$(B)/tests/%: tests/unit/%.c $(LIB_OBJ) $(wildcard tests/unit/*.h)
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -Itests/unit $(call pc,--cflags,cmocka) $(LINK) -o $@ \
	    $< $(LIB_OBJ) $(LIBS) $(call pc,--libs,cmocka)

-include $(OBJ:.o=.d)

# -- the man page ---------------------------------------------------------------

$(B)/glarepp.1: man/glarepp.1.in man/splice.awk $(B)/glarepp
	$(B)/glarepp --help-man | awk -f man/splice.awk - $< > $@.tmp
	mv $@.tmp $@

man: $(B)/glarepp.1 ## makes man/glarepp.1 from the option table and the .in file
	cmp -s $< man/glarepp.1 || cp $< man/glarepp.1

check-man: $(B)/glarepp.1 ## man page, --help and parser agree; the page is not stale
	man/check.sh $(B)/glarepp $< man/glarepp.1

clean: ## removes build/
	rm -rf $(B) compile_commands.json
