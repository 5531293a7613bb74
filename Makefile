# glarepp: build, test, install. `make help` lists the targets.
#
# Objects are in build/; only the man page and compile_commands.json are written
# beside the sources.

VERSION := 0.1.0
PREFIX ?= /usr/local
DESTDIR ?=
B ?= build
CC ?= cc
CXX ?= c++
AR ?= ar
PKG_CONFIG ?= pkg-config

PACKAGES := OpenEXR libpng libdeflate zlib jansson fftw3f fftw3
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
ALL_CFLAGS = -std=c11 $(OPT) -fno-trapping-math -fno-math-errno -Wno-psabi $(WARN) $(CFLAGS) $(HERE) $(HARDEN_CC) $(DEFS) -pthread -Isrc -I$(B) \
             $(call pc,--cflags,$(PACKAGES)) $(SAN)
# only OpenEXRCore: OpenEXR.pc would link the C++ library too
LIBS = -lOpenEXRCore $(call pc,--libs,libpng libdeflate zlib jansson) -lm -ldl $(SAN_LIBS)
LINK = -pthread -Wl,--as-needed $(SAN) $(HARDEN_LINK)

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
HARDEN_CC = $(eval HARDEN_CC := $$(call harden,$$(CC),c) $(if $(SAN),,-fPIE))$(HARDEN_CC)
HARDEN_CXX = $(eval HARDEN_CXX := $$(call harden,$$(CXX),c++))$(HARDEN_CXX)
HARDEN_SO := $(if $(SAN),,-Wl,-z,relro,-z,now,-z,noexecstack)
HARDEN_LINK = $(if $(SAN),,-pie $(HARDEN_SO))

# -- files --------------------------------------------------------------------

SRC := $(sort $(shell find src -name '*.c'))
HDR := $(sort $(shell find src -name '*.h'))
SHADERS := $(wildcard src/gl/shaders/*)
BRIDGE_SRC := $(wildcard src/io/oiio/*.cpp)
UNIT := $(wildcard tests/unit/*/*.c)
TEST_SRC := $(sort $(shell find tests -name '*.[ch]' -o -name '*.cpp'))

OBJ := $(SRC:src/%.c=$(B)/%.o) $(B)/gl/shaders.o
LIB_OBJ := $(filter-out $(B)/app/main.o,$(OBJ))
OCIO_SRC := src/tone/ocio_bridge.cpp
BRIDGES := $(B)/glarepp-oiio $(B)/glarepp-ocio.so
HARD := $(wildcard tests/hard/*.c)
UNIT_ROOMS := $(notdir $(patsubst %/,%,$(sort $(dir $(UNIT)))))
UNIT_BIN := $(UNIT_ROOMS:%=$(B)/tests/%) $(B)/tests/hardcases
FAULTS := $(addprefix $(B)/tests/,shim.so environ.so broken_gl.so broken_egl.so)

CHECKS := check-headers check-house check-symbols check-man

.PHONY: all help demo check check-built check-all check-alone check-asan check-ubsan check-tsan tsan check-valgrind \
        coverage coverage-run $(CHECKS) lint lint-clang hardcases mutants gallery bench man install uninstall deb deps clean
all: $(B)/glarepp $(BRIDGES) man compile_commands.json ## builds the program, its bridges and the man page

help: ## lists the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 18

# -- build --------------------------------------------------------------------

$(B)/glarepp: $(OBJ)
	$(CC) $(LINK) -o $@ $^ $(LIBS)

$(B)/%.o: src/%.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

# The bytes of the GLSL files, for the program
$(B)/gl/shaders.c: $(SHADERS) Makefile
	@mkdir -p $(@D)
	@{ echo '#include "gl/gl_priv.h"'; \
	   echo 'const struct gp_shader_file gp_shader_files[] = {'; \
	   for f in $(SHADERS); do \
	     printf '{"%s", (const char[]) {' "$${f##*/}"; \
	     od -An -v -tx1 $$f | sed 's/ \([0-9a-f]*\)/0x\1,/g'; \
	     echo '0}},'; done; echo '{0, 0}};'; } > $@

$(B)/gl/shaders.o: $(B)/gl/shaders.c
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

# C++ is in a helper program and a shared object, which are started and opened only
# when needed. The helper is built without sanitizers: it exists to contain
# OpenImageIO's faults; its files are compiled as one, as its headers take 3 s each time
BRIDGE_ONE := $(addprefix -include ,$(wordlist 2,9,$(BRIDGE_SRC))) $(firstword $(BRIDGE_SRC))
$(B)/glarepp-oiio: $(BRIDGE_SRC) src/io/oiio/protocol.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(OPT) -Wall -Wextra -Werror $(filter-out $(COUNTED),$(CFLAGS)) $(HERE) $(HARDEN_CXX) -fPIE -pie \
	    $(HARDEN_SO) -pthread -Isrc -o $@ $(BRIDGE_ONE) \
	    $(call pc,--cflags --libs,OpenImageIO)

$(B)/glarepp-ocio.so: $(OCIO_SRC) src/tone/ocio_bridge.h src/core/status.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(OPT) -Wall -Wextra -Werror $(CFLAGS) $(HERE) $(HARDEN_CXX) -fPIC -shared \
	    $(HARDEN_SO) -Isrc -fvisibility=hidden -o $@ $(OCIO_SRC) \
	    $(call pc,--cflags --libs,OpenColorIO)

# The unit tests: one program a room, its suites the files of its folder
# (tests/unit/unit.h)
FAIL_WRAP := malloc calloc realloc posix_memalign free read pread __read_chk \
             __pread_chk write pwrite fstat rename unlink fchmod ftruncate \
             fdopen memfd_create close open pthread_create sched_getaffinity \
             readlink dlopen dlsym
UNIT_CFLAGS = -Itests/unit -Wno-unused-parameter $(call pc,--cflags,cmocka)
# (tests take a third as long to compile, and their loops are short, but for two
# rooms whose suites have plain forms of their own to compare with)
UNIT_OPT = $(if $(filter -O3,$(OPT)),-O0 -U_FORTIFY_SOURCE)
$(B)/tests/obj/glare/%.o $(B)/tests/obj/scene/%.o: \
    UNIT_OPT = $(if $(filter -O3,$(OPT)),-O1)
UNIT_OBJ := $(UNIT:tests/unit/%.c=$(B)/tests/obj/%.o)
UNIT_COMMON := $(B)/tests/obj/unit.o $(B)/tests/obj/shim.o

$(B)/tests/obj/%.o: tests/unit/%.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) $(UNIT_CFLAGS) $(UNIT_OPT) -MMD -MP -c -o $@ $<
$(B)/tests/obj/shim.o: tests/faults/shim.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) $(UNIT_CFLAGS) $(UNIT_OPT) -DFAIL_WRAPPED -MMD -MP -c \
	    -o $@ $<

# $(call suites,ROOM): the names of its suites
suites = $(basename $(notdir $(wildcard tests/unit/$(1)/*.c)))
define unit_room
$(B)/tests/obj/$(1)_suites.c: Makefile $(wildcard tests/unit/$(1))
	@mkdir -p $$(@D)
	@{ echo '#include "unit.h"'; \
	   for s in $(call suites,$(1)); do \
	       echo "int suite_$$$$s(int argc, char **argv);"; done; \
	   echo 'const struct suite suites[] = {'; \
	   for s in $(call suites,$(1)); do \
	       echo "    {\"$$$$s\", suite_$$$$s},"; done; \
	   echo '    {0, 0},'; echo '};'; } >$$@
$(B)/tests/$(1): $(B)/tests/obj/$(1)_suites.o $(UNIT_COMMON) \
    $(patsubst %,$(B)/tests/obj/$(1)/%.o,$(call suites,$(1))) $(LIB_OBJ) \
    | $(B)/tests/broken_gl.so $(B)/tests/broken_egl.so
	$$(CC) $$(LINK) $(FAIL_WRAP:%=-Wl,--wrap=%) -o $$@ $$^ $$(LIBS) \
	    $$(call pc,--libs,cmocka)
endef
$(foreach r,$(UNIT_ROOMS),$(eval $(call unit_room,$(r))))
$(B)/tests/obj/%_suites.o: $(B)/tests/obj/%_suites.c
	$(CC) $(ALL_CFLAGS) $(UNIT_CFLAGS) -c -o $@ $<
.SECONDARY: $(UNIT_OBJ)
-include $(UNIT_OBJ:.o=.d) $(UNIT_COMMON:.o=.d)

# Libraries that tests preload to make calls fail, and GL libraries that break
$(B)/tests/%.so: tests/faults/%.c tests/faults/blocks.h
	@mkdir -p $(@D)
	$(CC) -std=c11 -O1 $(WARN) $(CFLAGS) -D_GNU_SOURCE -Itests/unit -fPIC -shared \
	    -o $@ $< -ldl

# The hard cases: one program, a file for each family
$(B)/tests/hardcases: $(HARD) $(wildcard tests/hard/*.h tests/unit/*.h) $(LIB_OBJ)
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) $(UNIT_CFLAGS) $(UNIT_OPT) $(LINK) -o $@ \
	    $(filter %.c,$^) $(LIB_OBJ) $(LIBS) $(call pc,--libs,cmocka)

-include $(OBJ:.o=.d)

include tests/fuzz/fuzz.mk
include tests/soak/soak.mk

# -- the man page ---------------------------------------------------------------

$(B)/glarepp.1: man/glarepp.1.in man/splice.awk $(B)/glarepp
	$(B)/glarepp --help-man | awk -f man/splice.awk - $< > $@.tmp
	mv $@.tmp $@

man: $(B)/glarepp.1 ## makes man/glarepp.1 from the option table and the .in file
	cmp -s $< man/glarepp.1 || cp $< man/glarepp.1

check-man: $(B)/glarepp.1 ## checks that man page, --help and parser agree
	man/check.sh $(B)/glarepp $< man/glarepp.1

# -- measuring ----------------------------------------------------------------

$(B)/bench/%: tests/bench/%.c $(LIB_OBJ)
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -fopenmp $(LINK) -o $@ $< $(LIB_OBJ) $(LIBS) \
	    -lfftw3f_omp -lfftw3f -lfftw3

$(B)/bench/split: $(wildcard tests/bench/split_*.h)

# Measures FFTW's plans for the lengths of the engine fft, on an idle machine
known-plans: $(B)/bench/plans ## measures the plans in src/glare/fft/known.c
	$< >$(B)/known.c
	mv $(B)/known.c src/glare/fft/known.c

FRAMES ?= $(B)/bench-frames
bench: all $(B)/bench/stage $(B)/bench/tail $(B)/bench/plain $(B)/bench/pair $(B)/bench/auto $(B)/bench/models $(B)/bench/plans $(B)/bench/split ## measures all speeds of README and manual on this machine
	tests/bench/run.sh $(B) $(FRAMES)

# A program to compare whole processes with: OpenEXR's C++ library and plain FFTW
$(B)/bench/plain: tests/bench/plain.cpp
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -O3 $(CFLAGS) -fopenmp -o $@ $< \
	    $(call pc,--cflags --libs,OpenEXR) -lfftw3f_omp -lfftw3f

gallery: all ## makes man/gallery.md and man/pictures/ again; needs ImageMagick
	man/gallery.sh $(B)/glarepp

# -- the two commands ---------------------------------------------------------

demo: ## installs missing packages, builds, renders the example frames
	@$(MAKE) --no-print-directory deps
	@$(MAKE) --no-print-directory -j$$(nproc) all
	@examples/demo.sh $(B)/glarepp $(B)/demo

check: ## installs missing packages, builds, runs every test
	@$(MAKE) --no-print-directory deps
	@$(MAKE) --no-print-directory -j$$(nproc) check-built
	@$(MAKE) --no-print-directory check-all

# The clone uses the binaries built here: its files get an old date, so that make
# builds nothing. Suites that read no file of the repository or of the data would
# only repeat what make check did
PLACELESS = $(shell grep -LE 'data_path|data_frames|examples/|tests/cli/|man/' $(UNIT) </dev/null)
check-alone: check-built ## runs the quick tests that read files in a clone without data beside it
	@alone=$$(mktemp -d) && trap 'rm -rf "$$alone"' EXIT && \
	    git clone -q . "$$alone/glarepp" && \
	    find "$$alone/glarepp" -type f -exec touch -d 2000-01-01 {} + && \
	    ln -s "$(abspath $(B))" "$$alone/glarepp/build" && \
	    cd "$$alone/glarepp" && GLAREPP_TEST_QUICK=1 \
	        GLAREPP_TEST_SKIP="$(PLACELESS:tests/unit/%.c=%)" tests/run.sh build \
	        "$(filter-out %/hardcases,$(UNIT_BIN:$(B)/%=build/%))" ""

check-built: $(B)/glarepp $(BRIDGES) $(UNIT_BIN) $(FAULTS) fuzz-build compile_commands.json
check-all: check-built
	@tests/run.sh $(B) "$(UNIT_BIN)" "$(CHECKS)"

mutants: check-built ## checks that tests notice 120 changes that would break a promise
	@tests/mutants/run.py $(B) $(ONLY)

hardcases: $(B)/tests/hardcases $(BRIDGES) ## writes the largest error of each hard case to build/hardcases.md
	@$(B)/tests/hardcases >$(B)/hardcases.txt
	@awk -f tests/hard/summary.awk $(B)/hardcases.txt | \
	    cat - $(B)/hardcases.txt >$(B)/hardcases.md
	@echo $(B)/hardcases.md

# The same tests in builds that look for errors of memory and of arithmetic
SAN_MAKE = $(MAKE) --no-print-directory B=$(B)/$(1) OPT=-O1 \
           SAN="-fsanitize=$(2) -fno-omit-frame-pointer -fno-sanitize-recover=all"
# (AddressSanitizer must load C++ exceptions before a bridge throws one. Before gcc
# 14 its leak finder mistakes a thread's late-loaded storage for one of an old glibc
# and dies: google/sanitizers issue 1322; intercept_tls_get_addr=0 avoids it)
check-asan: ## runs the tests under AddressSanitizer
	@SAN_LIBS="-Wl,--no-as-needed -lstdc++" \
	    ASAN_OPTIONS=allocator_may_return_null=1:intercept_tls_get_addr=0 \
	    LSAN_OPTIONS=suppressions=$(CURDIR)/tests/lsan.supp:print_suppressions=0 \
	    GLAREPP_TEST_QUICK=1 $(call SAN_MAKE,asan,address) check-san

# (float division by zero is not checked: it gives Inf, on purpose)
check-ubsan: ## runs the tests under UndefinedBehaviorSanitizer
	@GLAREPP_TEST_QUICK=1 $(call SAN_MAKE,ubsan,undefined \
	    -fsanitize=float-cast-overflow) check-san

# The tests that run several threads, but the hard cases, which would take hours;
# and of these the suites of what threads share, within ten minutes
TSAN_CLI := threads sequence stream farm flight layers views groups sun
TSAN_SUITES := core/parallel core/memory app/flight io/exr_read io/exr_write \
               io/png io/stream glare/direct glare/fft glare/fft_kept glare/bound \
               sun/map sun/exact sun/occluder sun/flare compare/flip tone/tone
TSAN_MAKE = TSAN_OPTIONS="suppressions=$(CURDIR)/tests/tsan.supp \
    die_after_fork=0 allocator_may_return_null=1" GLAREPP_TEST_QUICK=1 \
    $(call SAN_MAKE,tsan,thread) UNIT_BIN="$(1:%=$(B)/tsan/tests/%)" check-san
check-tsan: ## runs the tests of code with threads under ThreadSanitizer
	@$(call TSAN_MAKE,$(UNIT_ROOMS)) SAN_CLI="$(TSAN_CLI)"

tsan: ## runs the suites of what threads share under ThreadSanitizer, in ten minutes
	@GLAREPP_TEST_SKIP="$(filter-out $(TSAN_SUITES),$(UNIT:tests/unit/%.c=%))" \
	    $(call TSAN_MAKE,$(sort $(foreach s,$(TSAN_SUITES),$(firstword $(subst /, ,$(s)))))) \
	    SAN_CLI=no-cli -j$$(nproc)

check-san: $(B)/glarepp $(BRIDGES) $(UNIT_BIN) $(FAULTS)
	@tests/run.sh $(B) "$(UNIT_BIN)" "" "$(SAN_CLI)"

# Each branch of the source counts once: no optimisation, no copies for other CPUs,
# no inlining. kill.t would damage the counters of runs that it kills; harden.t and
# determinism.t test the default build
COUNTED = --coverage -fprofile-update=atomic -DGP_NO_CLONES \
          -Dalways_inline=unused
coverage: ## measures branch and line coverage of src/ by all tests (python3, gcov)
	@$(MAKE) --no-print-directory B=$(B)/cov OPT=-O0 CFLAGS="-g $(COUNTED)" \
	    SAN="$(COUNTED)" FUZZ_MAIN="-fsanitize=address tests/fuzz/run_corpus.c" \
	    coverage-run

FLOORS := 85 core=90 glare=90 io=90
coverage-run: $(B)/glarepp $(BRIDGES) $(UNIT_BIN) $(FAULTS) fuzz-bin
	@mkdir -p $(B)/fuzz && cp $(FUZZ_BIN) $(B)/fuzz # a folder without bridges
	@find $(B) -name '*.gcda' -delete
	@GCOV_ERROR_FILE=$(abspath $(B))/gcov.log GLAREPP_TEST_QUICK=1 FAULT_MANY=1 \
	    tests/run.sh $(B) "$(UNIT_BIN)" "" -kill -harden -determinism; ran=$$?; \
	    tests/tools/coverage.py $(B) $(FLOORS) && exit $$ran

# io/data and the hard cases would take many minutes
VALGRIND = valgrind -q --error-exitcode=99 --leak-check=full \
           --errors-for-leak-kinds=definite --show-leak-kinds=definite \
           --suppressions=$(CURDIR)/tests/valgrind.supp
VALGRIND_CLI := errors layers report stream
check-valgrind: $(B)/glarepp $(BRIDGES) $(UNIT_BIN) $(B)/valgrind/glarepp ## runs the tests under valgrind
	@GLAREPP_TEST_QUICK=1 GLAREPP_TEST_SKIP=io/data GLAREPP_RUN="$(VALGRIND)" \
	    GLAREPP_PROGRAM=$(abspath $(B))/valgrind/glarepp tests/run.sh $(B) \
	    "$(filter-out %/hardcases,$(UNIT_BIN))" \
	    "" $(VALGRIND_CLI)

# A script in place of the program, for the command-line tests
$(B)/valgrind/glarepp: Makefile
	@mkdir -p $(@D)
	@printf '#!/bin/sh\nexec %s %s "$$@"\n' "$(VALGRIND)" \
	    "$(abspath $(B))/glarepp" >$@
	@chmod +x $@

# -- rules of the house -------------------------------------------------------

check-headers: ## compiles each header by itself
	@for h in $(HDR:src/%=%); do \
	    echo "#include \"$$h\"" | $(CC) $(ALL_CFLAGS) -fsyntax-only -xc - || \
	    exit 1; done

check-house: $(OBJ) ## checks rooms, circles, private headers, sizes, subjects
	@tests/tools/house.py . $(B)

check-symbols: $(LIB_OBJ) ## checks that every global symbol starts with gp_
	@! nm -g --defined-only $(LIB_OBJ) | \
	    awk 'NF == 3 && $$3 !~ /^(gp_|\.)/ { print $$3; n++ } END { exit !n }'

# The warnings of clang, over sources, tests and benches, by a build's flags; the fuzz
# targets' objects have them where clang builds those. Headers that most files
# include are parsed once: clang_each FILES,FLAGS,LANGUAGE,HEADER
CLANG_SRC = $(if $(filter clang%,$(notdir $(FUZZ_CC))),src/app/main.c,$(SRC))
define clang_each
$(CLANG) $(2) -x$(3)-header $(4) -o $(B)/$(3).pch && \
printf '%s\n' $(1) | xargs -P2 -n16 \
    $(CLANG) -fsyntax-only $(2) -include-pch $(B)/$(3).pch
endef
CLANG_C = $(call clang_each,$(1),-std=c11 $(WARN) $(DEFS) -Isrc \
          $(call pc,--cflags,$(PACKAGES)) $(2),c,$(3))
CLANG_CXX = $(call clang_each,$(1),-std=c++17 -Wall -Wextra -Werror -Isrc \
            $(patsubst -I%,-isystem%,$(2)),c++,$(3))
lint-clang: fuzz-build
	@test -n "$(CLANG)" || { echo "skipped: no clang"; exit 0; }; \
	$(call CLANG_C,$(CLANG_SRC) $(wildcard tests/bench/*.c tests/fuzz/*.c),\
	    -Itests/fuzz,src/core/status.h) && \
	$(call CLANG_C,$(UNIT) tests/unit/unit.c $(HARD) $(wildcard tests/faults/*.c),\
	    $(UNIT_CFLAGS),tests/unit/unit.h) && \
	$(call CLANG_CXX,$(BRIDGE_SRC),$(call pc,--cflags,OpenImageIO),\
	    -include OpenImageIO/imageio.h src/io/oiio/protocol.h) && \
	$(call CLANG_CXX,$(OCIO_SRC) tests/bench/plain.cpp,\
	    $(call pc,--cflags,OpenColorIO OpenEXR),src/core/status.h)

LINT_SRC := $(SRC) $(BRIDGE_SRC) $(OCIO_SRC)
LINT = @command -v $(1) >/dev/null || { echo "skipped: no $(1)"; exit 0; }; \
       tests/tools/lint.sh
lint: lint-clang compile_commands.json ## runs clang for its warnings, clang-tidy and cppcheck
	$(call LINT,cppcheck) cppcheck $(LINT_SRC)
	$(call LINT,clang-tidy) tidy $(LINT_SRC)

# -- tools and installing -----------------------------------------------------

# ("command" is split as by a shell: the quotes of -DX='"..."' stay)
COMMAND = $(CC) $(ALL_CFLAGS) -c
CXX_COMMAND = $(CXX) -std=c++17 -Isrc $(call pc,--cflags,OpenImageIO OpenEXR OpenColorIO) -c
define json_entry
{"directory":"$(CURDIR)","file":"$(1)","command":"$(subst ",\",$(2)) $(1)"},
endef
compile_commands.json: Makefile $(SRC) $(UNIT)
	$(file >$@,[)
	$(foreach f,$(SRC),$(file >>$@,$(call json_entry,$(f),$(COMMAND))))
	$(foreach f,$(UNIT) $(HARD),$(file >>$@,$(call json_entry,$(f),$(COMMAND) -Itests/unit)))
	$(foreach f,$(BRIDGE_SRC) $(OCIO_SRC),$(file >>$@,$(call json_entry,$(f),$(CXX_COMMAND))))
	@sed -i '$$s/,$$/\n]/' $@

# Each shell's folder of completions
SHELLS := bash zsh fish
BASH_PLACE := share/bash-completion/completions/glarepp
ZSH_PLACE := share/zsh/site-functions/_glarepp
FISH_PLACE := share/fish/vendor_completions.d/glarepp.fish
# Documents, and templates for farms
DOC_PLACE := share/doc/glarepp
TEMPLATES := $(addprefix examples/,slurm.sh openjd.yaml parallel.sh blender_camera.py \
    alley.glb)
LENSES := $(wildcard examples/lenses/*.json)
FLARES := $(wildcard examples/flares/*.json)

$(B)/completions.%: $(B)/glarepp
	$(B)/glarepp help --completion $* > $@.tmp
	mv $@.tmp $@

install: all $(SHELLS:%=$(B)/completions.%) ## installs program, bridges, manual, templates and completions under DESTDIR and PREFIX
	install -d '$(DESTDIR)$(PREFIX)/bin' '$(DESTDIR)$(PREFIX)/lib/glarepp' \
	    '$(DESTDIR)$(PREFIX)/share/man/man1'
	install -D -m 644 $(B)/completions.bash '$(DESTDIR)$(PREFIX)/$(BASH_PLACE)'
	install -D -m 644 $(B)/completions.zsh '$(DESTDIR)$(PREFIX)/$(ZSH_PLACE)'
	install -D -m 644 $(B)/completions.fish '$(DESTDIR)$(PREFIX)/$(FISH_PLACE)'
	install -m 755 $(B)/glarepp '$(DESTDIR)$(PREFIX)/bin/glarepp'
	install -m 755 $(BRIDGES) '$(DESTDIR)$(PREFIX)/lib/glarepp/'
	install -m 644 man/glarepp.1 '$(DESTDIR)$(PREFIX)/share/man/man1/'
	install -d '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/man' \
	    '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/examples/lenses' \
	    '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/examples/flares'
	install -m 644 README.md LICENSE '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/'
	install -m 644 man/*.md '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/man/'
	install -m 644 $(TEMPLATES) '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/examples/'
	install -m 644 $(LENSES) '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/examples/lenses/'
	install -m 644 $(FLARES) '$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/examples/flares/'

uninstall: ## removes the files of install
	rm -f '$(DESTDIR)$(PREFIX)/bin/glarepp' \
	    '$(DESTDIR)$(PREFIX)/lib/glarepp/glarepp-oiio' \
	    '$(DESTDIR)$(PREFIX)/lib/glarepp/glarepp-ocio.so' \
	    '$(DESTDIR)$(PREFIX)/share/man/man1/glarepp.1' \
	    $(patsubst %,'$(DESTDIR)$(PREFIX)/%',$(BASH_PLACE) $(ZSH_PLACE) $(FISH_PLACE)) \
	    $(patsubst %,'$(DESTDIR)$(PREFIX)/$(DOC_PLACE)/%',$(wildcard README.md LICENSE man/*.md) $(TEMPLATES) $(LENSES) $(FLARES))
	-cd '$(DESTDIR)$(PREFIX)' 2>/dev/null && \
	    rmdir lib/glarepp $(DOC_PLACE)/man $(DOC_PLACE)/examples/lenses $(DOC_PLACE)/examples/flares $(DOC_PLACE)/examples $(DOC_PLACE) \
	    2>/dev/null

deb: all ## makes a Debian package in build/
	rm -rf $(B)/deb
	@$(MAKE) --no-print-directory B=$(B) PREFIX=/usr \
	    DESTDIR=$(abspath $(B))/deb install
	.ci/deb.sh $(B)/deb $(VERSION) $(B)

# Packages that a fresh Debian 12 lacks, to build, run and test
DEBIAN := gcc g++ make pkg-config libc6-dev libopenexr-dev libpng-dev zlib1g-dev \
          libdeflate-dev libjansson-dev libfftw3-dev libopenimageio-dev \
          libopencolorio-dev \
          libgl-dev libegl-dev libosmesa6 libegl1 libegl-mesa0 \
          libgl1-mesa-dri \
          libcmocka-dev openimageio-tools openexr mandoc valgrind perl procps \
          dpkg-dev gnuplot-nox \
          python3 python3-numpy python3-scipy python3-openimageio python3-pil
# Packages of a few tests, which are skipped without them
EXTRA := zsh fish parallel slurm-wlm munge python3-yaml clang libclang-rt-14-dev \
         clang-tidy cppcheck
deps: ## installs the Debian packages that are missing
	@command -v dpkg-query >/dev/null || { \
	    echo "deps: this is not Debian; install the equivalents of these packages:"; \
	    echo $(DEBIAN) | fold -s; exit 1; }
	@missing=; for p in $(DEBIAN); do \
	    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || \
	    missing="$$missing $$p"; done; \
	extra=; for p in $(EXTRA); do \
	    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || \
	    extra="$$extra $$p"; done; \
	export DEBIAN_FRONTEND=noninteractive; \
	sudo=; [ "$$(id -u)" = 0 ] || sudo='sudo -E'; \
	[ -z "$$missing$$extra" ] || $$sudo apt-get update -q; \
	[ -z "$$missing" ] || { echo "deps: installing$$missing"; \
	    $$sudo apt-get install -q -y --no-install-recommends $$missing; } && \
	{ [ -z "$$extra" ] || { echo "deps: trying to install$$extra"; \
	    timeout 300 $$sudo apt-get install -q -y --no-install-recommends \
	        $$extra || echo "deps: without$$extra a few tests are skipped"; }; }

clean: ## removes build/
	rm -rf $(B) compile_commands.json
