# The images of the boards, and what of the application the host's tests link.
app_src := $(filter-out firmware/main.c,$(wildcard firmware/*.c))
app_lib := $(B)/host/libapp.a

# Boards: a file each in firmware/boards, a line each in common/boards.def. Only the drivers know which one they are for; start-up does not.
boards := zg discovery nucleo446
BOARD ?= zg
ifneq ($(words $(BOARD)) $(filter $(BOARD),$(boards)),1 $(strip $(BOARD)))
$(error BOARD=$(BOARD): there is no such board; there are: $(boards))
endif
# What no image needs stays with the host.
arm_src := $(filter-out common/command.c common/decimal.c common/quantity.c common/symbols.c,$(common_src)) $(wildcard firmware/*.c) firmware/f407/startup.c firmware/libc/libc.c
driver_src := $(filter-out $(arm_src),$(wildcard firmware/f407/*.c))
for_board = -DBOARD_FILE='"firmware/boards/$(1).def"'
# Objects and folder of a board's image.
board_objects = $(call objects,arm,$(arm_src)) $(call objects,arm/$(1),$(driver_src))
board_folder = $(B)/firmware$(if $(filter-out zg,$(1)),/$(1))
board_elf = $(call board_folder,$(1))/matrig.elf
firmware := $(call board_elf,zg)
chosen := $(call board_elf,$(BOARD))
# What flash tools take.
image_files = $(1) $(1:.elf=.hex) $(1:.elf=.bin) $(dir $(1))vectors.bin $(dir $(1))program.bin
# The bring-up image: the same drivers and tasks, with a program of its own (firmware/bringup).
bringup_src := $(wildcard firmware/bringup/*.c)
bringup_objects = $(filter-out %/firmware/main.o,$(call board_objects,$(1))) $(call objects,arm/$(1),$(bringup_src))
bringup_elf = $(call board_folder,$(1))/bringup.elf
images := $(foreach board,$(boards),$(call image_files,$(call board_elf,$(board))) $(call bringup_elf,$(board)))

# The rows of all boards, for pages and tests.
board_tables := $(B)/host/firmware/boards/tables.o

$(app_lib): $(call objects,host,$(app_src))
# Where all is for size, what firmware/hot.txt has is for speed, at the level that it gives.
hot = $(if $(filter -Os,$(ARM_CFLAGS)),$(shell awk '$$3 == "$(1)" {print $$2}' firmware/hot.txt))
define hot_rule
$(foreach folder,arm $(boards:%=arm/%),$(patsubst %,$(B)/$(folder)/%.o,$(call hot,$(1)))): ARM_FLAGS += $(1)
endef
$(foreach level,-O2 -O3,$(if $(call hot,$(level)),$(eval $(call hot_rule,$(level)))))
# The compiler would make calls of memset and memcpy of what these are.
$(B)/arm/firmware/libc/libc.o: ARM_FLAGS += -fno-tree-loop-distribute-patterns -fno-builtin
$(B)/arm/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc $(ARM_FLAGS) -fcallgraph-info=su -c $< -o $@
define driver_rule
$(B)/arm/$(1)/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $$(@D)
	$$(call say,CC,$$<)$(ARM)gcc $$(ARM_FLAGS) $(call for_board,$(1)) -fcallgraph-info=su -c $$< -o $$@
endef
$(foreach board,$(boards),$(eval $(call driver_rule,$(board))))

# From which commit, written anew only when it is another one: nothing else of time or place is in an image.
commit := $(B)/firmware/commit
# It runs where the image is built.
BUILD_CC ?= $(CC)
stamp := $(B)/firmware/stamp
.PHONY: always
$(commit): always
	@mkdir -p $(@D)
	@commit=$${COMMIT:-$$(git describe --always --dirty --abbrev=12 --exclude='*' 2>/dev/null || echo unknown)}; \
		[ "$$commit" = "$$(cat $@ 2>/dev/null)" ] || echo "$$commit" >$@
$(stamp): firmware/stamp/stamp.c common/boards.def common/memory.def common/crc32.c common/image.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(BUILD_CC) -O2 $(OUR_FLAGS) $(filter %.c,$^) -o $@

link_image = $(ARM)gcc $(ARM_CPU) -nostdlib -T $(call board_folder,$(1))/matrig.ld -Wl,--gc-sections
define image_rule
$(call board_folder,$(1))/matrig.ld: firmware/f407/matrig.ld common/memory.def $(wildcard firmware/boards/*.def) | $(B)/.demo-packages
	@mkdir -p $$(@D)
	$$(call say,GEN,$$@)$(ARM)gcc -E -P -x c -I. $(call for_board,$(1)) $$< -o $$@
$(call board_elf,$(1)): $(call board_objects,$(1))
$(call bringup_elf,$(1)): $(call bringup_objects,$(1))
$(call board_elf,$(1)) $(call bringup_elf,$(1)): $(call board_folder,$(1))/matrig.ld $(stamp) $(commit)
	@mkdir -p $$(@D)
	$$(call say,LD,$$@)$(link_image) -Wl,-Map=$$(@:.elf=.map) $$(filter %.o,$$^) -lgcc -o $$@
	$(Q)$(stamp) $$@ $$$$(cat $(commit))
endef
$(foreach board,$(boards),$(eval $(call image_rule,$(board))))
.PHONY: bringup
bringup: $(call bringup_elf,$(BOARD)) ## every day | BOARD=zg: the image that a new board runs first (docs/howto/bring-up.md)
%.hex: %.elf
	$(call say,BIN,$@)$(ARM)objcopy -O ihex $< $@
%.bin: %.elf
	$(call say,BIN,$@)$(ARM)objcopy -O binary --gap-fill 0xff $< $@
# The same in two parts, 0x08000000 and 0x08010000, for tools that would erase the configuration between them.
%/vectors.bin: %/matrig.elf
	$(call say,BIN,$@)$(ARM)objcopy -O binary --gap-fill 0xff -j .vectors $< $@
%/program.bin: %/matrig.elf
	$(call say,BIN,$@)$(ARM)objcopy -O binary --gap-fill 0xff -R .vectors $< $@

# Worst-case stack from the compiler's own figures; fails when it does not fit its region.
%/stack.txt: %/matrig.elf firmware/f407/stack.awk
	@$(ARM)nm $< | awk -v elf=$< -f firmware/f407/stack.awk - \
		$(patsubst %.o,%.ci,$(call board_objects,$(or $(filter $(notdir $*),$(boards)),zg))) >$@ || { cat $@; exit 1; }
stacks := $(foreach board,$(boards),$(call board_folder,$(board))/stack.txt)
