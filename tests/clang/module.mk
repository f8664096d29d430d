# The programs as clang builds them, in a folder of their own. Of tests and studies only the warnings count, which need no optimiser.
clang = -s B=$(B)/clang CC=clang WERROR=-Werror CFLAGS=-O2 TEST_CFLAGS=-O0
.PHONY: test-clang
test-clang: in-build $(B)/.clang-packages all $(B)/tests/conformance/images/places.elf ## tests | all programs built by clang, without a warning: outputs equal to the usual compiler's byte by byte
	@$(MAKE) $(clang) $(patsubst $(B)/%,$(B)/clang/%,$(programs) $(studies)) test-programs
	@tests/run-all.sh tests/clang/same-outputs.sh
