# The programs as clang builds them, in a folder of their own.
.PHONY: test-clang
test-clang: in-build $(B)/.clang-packages all $(B)/tests/conformance/images/places.elf ## tests | all programs built by clang, without a warning: outputs equal to the usual compiler's byte by byte
	@$(MAKE) -s B=$(B)/clang CC=clang WERROR=-Werror all test-programs
	@tests/run-all.sh tests/clang/same-outputs.sh
