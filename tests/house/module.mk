# How the sources look, and what an editor wants to know of them.
c_files = $(shell find common firmware hil host docs tests -name '*.[ch]' -not -path '*/node_modules/*')

.PHONY: format
format: $(B)/.test-packages ## every day | lay out the C files as .clang-format says
	clang-format -i $(c_files)

.PHONY: compile-commands
compile-commands: $(B)/.test-packages ## every day | how each C file is compiled, for editors and analysers: compile_commands.json
	@$(MAKE) -Bnk all $(tests) 2>/dev/null | python3 tests/house/compile_commands.py "$(CURDIR)" >compile_commands.json
