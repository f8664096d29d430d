# The emulated board, matrig-board.
hil_src := $(filter-out hil/main.c,$(wildcard hil/*.c $(patsubst %,hil/%/*.c,core periph chips rig board link debug)))
hil_lib := $(B)/host/libhil.a
# Unicorn is GPL-2.0: only matrig-board and the tests of hil link it, never matrig.
HIL_LIBS := -lunicorn -lm

$(hil_lib): $(call objects,host,$(hil_src))
$(B)/matrig-board: $(B)/host/hil/main.o $(hil_lib) $(common_lib)
	$(call link,$(HIL_LIBS))

$(B)/matrig-board.1: $(B)/matrig-board | $(B)/.study-packages
	$(call man,the board of matrig in virtual time) '$(RUN) $<'

# The boot ROM of the emulated board: a small program of its own, carried by matrig-board as bytes.
$(B)/hil/bootrom.elf: hil/rom/bootrom.c hil/rom/bootrom.ld | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc -std=c11 -Os -g -Wall -Wextra -Werror -mcpu=cortex-m4 -mthumb -ffreestanding -nostdlib \
		-fno-tree-loop-distribute-patterns -T hil/rom/bootrom.ld $< -o $@
$(B)/hil/bootrom.bin: $(B)/hil/bootrom.elf
	$(call say,BIN,$@)$(ARM)objcopy -O binary --gap-fill 0xff --pad-to 0x1fff7000 $< $@
$(B)/host/hil/core/cpu.o: HOST_FLAGS += -Wa,-I$(B)/hil
$(B)/host/hil/core/cpu.o: $(B)/hil/bootrom.bin

# The reference electronics: hil/circuits/circuits.py says what is checked.
.PHONY: circuits
circuits: $(B)/.circuit-packages ## tests | the reference electronics: rules, pins, parts list, drawings, each block simulated (1 min): build/circuits
	@python3 hil/circuits/circuits.py $(B)/circuits
.PHONY: circuits-figures
circuits-figures: $(B)/.circuit-packages ## longer | the same, and figures.def, FIGURES.md, docs/electronics and its drawings made anew
	@python3 hil/circuits/circuits.py --keep $(B)/circuits
