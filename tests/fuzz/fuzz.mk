# Fuzzing. A fuzz_NAME.c is a target: LLVMFuzzerTestOneInput over the whole
# program as a library, in a build of its own in $(B)/fuzz. With clang the
# targets fuzz; without it gcc builds them to run the corpora only.

TIME ?= 60
FUZZ := $(wildcard tests/fuzz/fuzz_*.c)
FUZZ_BIN := $(FUZZ:tests/fuzz/%.c=$(B)/%)
CLANG ?= $(firstword $(foreach c,clang clang-14,$(shell command -v $(c))))

.PHONY: fuzz fuzz-build fuzz-bin

# (for the corpora alone, optimised code would take longer to compile than it saves)
FUZZ_DIR ?= $(B)/fuzz
FUZZ_OPT ?= -O0
fuzz: ## runs each fuzz target TIME seconds (needs clang), two at a time
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

$(B)/fuzz_%: tests/fuzz/fuzz_%.c tests/fuzz/harness.c tests/fuzz/run_corpus.c \
             tests/fuzz/harness.h $(LIB_OBJ)
	$(CC) $(ALL_CFLAGS) -Itests/fuzz $(LINK) $(FUZZ_MAIN) -o $@ $< \
	    tests/fuzz/harness.c $(LIB_OBJ) $(LIBS)
