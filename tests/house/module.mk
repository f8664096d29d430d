# How the sources look, and what an editor wants to know of them.
c_files = $(shell find common firmware hil host docs tests -name '*.[ch]' -not -path '*/node_modules/*')

.PHONY: format
format: $(B)/.test-packages ## every day | lay out the C files as .clang-format says, in the source tree
	clang-format -i $(c_files)

.PHONY: compile-commands
compile-commands: $(B)/.test-packages ## every day | how each C file is compiled, for editors and analysers: compile_commands.json, in the source tree
	@$(MAKE) -Bnk V=1 all $(tests) 2>/dev/null | python3 tests/house/compile_commands.py "$(CURDIR)" >compile_commands.json

# What is compiled for this computer: the programs, their tests and studies. Not the board's: drivers, boot ROM, test images.
for_this_computer = $(filter-out firmware/main.c firmware/f407/% firmware/bringup/% hil/rom/% tests/hil/images/% tests/conformance/images/%,$(filter %.c,$(c_files)))
.PHONY: objects
objects: $(patsubst %.c,$(B)/host/%.o,$(filter-out tests/%,$(for_this_computer))) $(patsubst %.c,$(B)/%.o,$(filter tests/%,$(for_this_computer)))

cppcheck_options := -q --std=c11 --enable=warning,portability,performance,information \
	--suppress=missingInclude --suppressions-list=tests/house/cppcheck.txt --error-exitcode=1 -I.
# What a compiler warns of depends on the compiler and on how much it optimises. Compiled by the build's own rules; nothing is linked.
LEVELS ?= 0 1 3
.PHONY: lint
lint: in-build $(B)/.clang-packages ## tests | LEVELS="0 1 3": every C file with gcc at these levels and with clang, the board's too, and cppcheck: no warning
	@for level in $(LEVELS); do $(MAKE) -s B=$(B)/lint/O$$level CFLAGS=-O$$level WERROR=-Werror objects || exit; done
	@$(MAKE) $(clang) objects
	@clang --target=arm-none-eabi -isystem firmware/libc $(filter-out -MMD -MP,$(OUR_FLAGS)) -Werror $(ARM_CPU) -ffreestanding -fsyntax-only $(arm_src)
	@for board in $(boards); do clang --target=arm-none-eabi -isystem firmware/libc $(filter-out -MMD -MP,$(OUR_FLAGS)) -Werror $(ARM_CPU) \
		-ffreestanding -fsyntax-only -DBOARD_FILE="\"firmware/boards/$$board.def\"" $(driver_src) $(bringup_src) || exit; done
	@cppcheck $(cppcheck_options) common firmware hil
	@tests/run-all.sh tests/house/lint-finds.sh
