# Parsers with sanitizers and libFuzzer, in a folder of their own, look for inputs (make fuzz); as they are, they are given what was
# found before (make test): a second build with sanitizers would take as long as all other tests.
fuzz_targets := $(patsubst tests/fuzz/fuzz_%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
fuzz_programs := $(patsubst %,$(B)/tests/fuzz/fuzz_%,$(fuzz_targets))
test-programs: $(fuzz_programs)
SANITIZE := -fsanitize=address,undefined -fno-sanitize-recover=all
# How they are compiled to be run. To see that all of it compiles and links, FUZZ_CFLAGS=-O0 takes a fifteenth of the time; libFuzzer refuses to
# run that.
FUZZ_CFLAGS ?= -O1 $(SANITIZE) -fsanitize=fuzzer-no-link

.PHONY: fuzz-programs
fuzz-programs: $(B)/.clang-packages
	@$(MAKE) -s B=$(B)/fuzz CC=clang COVERAGE="$(FUZZ_CFLAGS) -Wno-error" FUZZ_MAIN="$(SANITIZE) -fsanitize=fuzzer" \
		$(patsubst %,$(B)/fuzz/tests/fuzz/fuzz_%,$(fuzz_targets))
.PHONY: fuzz
fuzz: fuzz-programs ## longer | SECONDS=600 PARSERS="candump ...": every parser, bytes by libFuzzer, with sanitizers: build/fuzz/table.txt
	@tests/fuzz/run.sh $(B)/fuzz $(or $(SECONDS),600) $(or $(PARSERS),$(fuzz_targets))

FUZZ_MAIN = $(B)/tests/fuzz/replay.o
$(fuzz_programs): | $(B)/tests/fuzz/replay.o
$(patsubst %,$(B)/tests/fuzz/fuzz_%,$(filter-out board,$(fuzz_targets))): $(B)/tests/fuzz/fuzz_%: $(B)/tests/fuzz/fuzz_%.o $(B)/tests/fuzz/file.o $(B)/tests/fuzz/store.o $(host_lib) $(common_lib)
	$(call link,$(FUZZ_MAIN) $(HOST_LIBS))
$(B)/tests/fuzz/fuzz_board: $(B)/tests/fuzz/fuzz_board.o $(B)/tests/fuzz/file.o $(hil_lib) $(common_lib)
	$(call link,$(FUZZ_MAIN) $(HIL_LIBS))
