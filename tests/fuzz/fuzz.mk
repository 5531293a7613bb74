# Fuzzing. A fuzz_NAME.c is a target: LLVMFuzzerTestOneInput over the whole
# program as a library, in a build of its own in $(B)/fuzz. All targets are one
# program, linked once, in which the name that starts it is the target's. With clang
# the targets fuzz; without it gcc builds them to run the corpora only.

TIME ?= 60
FUZZ := $(wildcard tests/fuzz/fuzz_*.c)
FUZZ_BIN := $(FUZZ:tests/fuzz/%.c=$(B)/%)
FUZZ_OBJ := $(FUZZ:tests/fuzz/%.c=$(B)/targets/%.o)
CLANG ?= $(firstword $(foreach c,clang clang-14,$(shell command -v $(c))))

.PHONY: fuzz fuzz-build fuzz-bin

# (for the corpora alone, optimised code would take longer to compile than it saves)
FUZZ_DIR ?= $(B)/fuzz
FUZZ_OPT ?= -O0
fuzz: $(B)/glarepp $(BRIDGES) ## runs each fuzz target TIME seconds (needs clang), two at a time
	@$(MAKE) --no-print-directory FUZZ_DIR=$(B)/fuzz-fast FUZZ_OPT=-O1 fuzz-build
	@tests/fuzz/run.sh $(B)/fuzz-fast $(TIME)

# clang may be installed without libFuzzer, which is a package of its own
FUZZ_CC = $(shell echo 'int LLVMFuzzerTestOneInput(const char *d, long n) \
            { return !d && n; }' | $(or $(CLANG),false) -fsanitize=fuzzer -xc \
            -o /dev/null - 2>/dev/null && echo $(CLANG) || echo $(CC))
fuzz-build:
	@cc="$(FUZZ_CC)"; case $${cc##*/} in \
	clang*) cover=-fsanitize=fuzzer-no-link; main=-fsanitize=fuzzer; warn="$(WARN)" ;; \
	*) cover=; main=tests/fuzz/run_corpus.c; warn="-Wall -Werror" ;; esac; \
	$(MAKE) --no-print-directory B=$(FUZZ_DIR) CC="$$cc" OPT=$(FUZZ_OPT) WARN="$$warn" \
	    CFLAGS=-g1 FUZZ_MAIN="$$main" \
	    SAN="-fsanitize=address,undefined -fno-sanitize-recover=all $$cover" \
	    fuzz-bin

fuzz-bin: $(FUZZ_BIN)

# (each target's function is named as its file)
$(B)/targets/%.o: tests/fuzz/%.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -Itests/fuzz -DLLVMFuzzerTestOneInput=$* -MMD -MP \
	    -c -o $@ $<
-include $(FUZZ_OBJ:.o=.d)

$(B)/targets/list.c: tests/fuzz/fuzz.mk $(wildcard tests/fuzz)
	@mkdir -p $(@D)
	@{ echo '#include "harness.h"'; \
	   for t in $(FUZZ:tests/fuzz/%.c=%); do \
	       echo "int $$t(const uint8_t *data, size_t size);"; done; \
	   echo 'const struct fuzz_target fuzz_targets[] = {'; \
	   for t in $(FUZZ:tests/fuzz/%.c=%); do \
	       echo "    {\"$$t\", $$t},"; done; \
	   echo '    {0, 0},'; echo '};'; } >$@

$(B)/targets/all: $(B)/targets/list.c tests/fuzz/harness.c tests/fuzz/run_corpus.c \
                  tests/fuzz/harness.h $(FUZZ_OBJ) $(LIB_OBJ)
	$(CC) $(ALL_CFLAGS) -Itests/fuzz $(LINK) $(FUZZ_MAIN) -o $@ $< \
	    tests/fuzz/harness.c $(FUZZ_OBJ) $(LIB_OBJ) $(LIBS)

$(FUZZ_BIN): $(B)/targets/all
	@ln -f $< $@
