# The image of the board, and what of the application the host's tests link.
app_src := $(filter-out firmware/main.c,$(wildcard firmware/*.c))
app_lib := $(B)/host/libapp.a
arm_src := $(common_src) $(wildcard firmware/*.c firmware/f407/*.c)
firmware := $(B)/firmware/matrig.elf
images := $(firmware) $(firmware:.elf=.hex) $(firmware:.elf=.bin) $(B)/firmware/vectors.bin $(B)/firmware/program.bin

$(app_lib): $(call objects,host,$(app_src))
$(B)/arm/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(ARM)gcc $(ARM_FLAGS) -fcallgraph-info=su -c $< -o $@

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
$(stamp): firmware/stamp/stamp.c common/crc32.c common/image.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(BUILD_CC) -O2 $(OUR_FLAGS) $(filter %.c,$^) -o $@

$(firmware): $(call objects,arm,$(arm_src)) firmware/f407/matrig.ld $(stamp) $(commit)
	@mkdir -p $(@D)
	$(ARM)gcc $(ARM_CPU) -nostartfiles --specs=nano.specs -T firmware/f407/matrig.ld -Wl,--gc-sections \
		-Wl,-Map=$(@:.elf=.map) $(filter %.o,$^) -lm -o $@
	$(stamp) $@ $$(cat $(commit))
%.hex: %.elf
	$(ARM)objcopy -O ihex $< $@
%.bin: %.elf
	$(ARM)objcopy -O binary --gap-fill 0xff $< $@
# The same in two parts, 0x08000000 and 0x08010000, for tools that would erase the configuration between them.
$(B)/firmware/vectors.bin: $(firmware)
	$(ARM)objcopy -O binary --gap-fill 0xff -j .vectors $< $@
$(B)/firmware/program.bin: $(firmware)
	$(ARM)objcopy -O binary --gap-fill 0xff -R .vectors $< $@

# Worst-case stack from the compiler's own figures; fails when it does not fit its region.
$(B)/firmware/stack.txt: $(firmware) firmware/f407/stack.awk
	@$(ARM)nm $< | awk -v elf=$< -f firmware/f407/stack.awk - $(patsubst %.o,%.ci,$(call objects,arm,$(arm_src))) >$@ || \
		{ cat $@; exit 1; }
