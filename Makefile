# matrig: firmware, host tool, emulated board and their tests. `make help` lists the targets.
#
# Each folder says in its module.mk what it builds. Here: how anything is compiled and linked, what is installed, the targets of every day.

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules

B := build
ifneq ($(words $(B)),1)
$(error B="$(B)": give a folder without blanks)
endif
ARM ?= arm-none-eabi-

# Yours to set: CC, CPPFLAGS, CFLAGS, LDFLAGS, ARM_CFLAGS. What a compiler warns of depends on its flags: with yours a warning does not end
# the build.
CFLAGS ?= -O2 -g
ARM_CFLAGS ?= -Os -g
WERROR := $(if $(filter file,$(origin CFLAGS)),-Werror)

WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wundef -Wshadow -Wstrict-prototypes -Wmissing-prototypes $(WERROR)
# No fused multiply-add on any side: host and board must round alike. No errno from sqrt: it is one instruction.
OUR_FLAGS := -std=c11 $(WARNINGS) -ffp-contract=off -fno-math-errno -I. -MMD -MP
HOST_FLAGS = $(CPPFLAGS) $(CFLAGS) $(OUR_FLAGS) -D_GNU_SOURCE
ARM_CPU := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
ARM_FLAGS := $(ARM_CFLAGS) $(OUR_FLAGS) $(ARM_CPU) -ffreestanding -isystem firmware/libc -ffunction-sections -fdata-sections

# When these sources are of: the commit's time, or SOURCE_DATE_EPOCH; from which commit: COMMIT, where there is no git.
epoch = $(or $(SOURCE_DATE_EPOCH),$(shell git log -1 --format=%ct 2>/dev/null || echo 0))
export COMMIT

# What is built, a line each: CC host/main.c. The commands themselves: make V=1.
Q := $(if $(V),,@)
quiet := $(V)$(findstring s,$(filter-out -%,$(firstword $(MAKEFLAGS))))
say = $(if $(quiet),,@printf '%-3s %s\n' $(1) $(2);)

objects = $(patsubst %.c,$(B)/$(1)/%.o,$(2))
# A program of what it depends on: $(call link,LIBRARIES)
link = $(call say,LD,$@)$(CC) $(CFLAGS) $(LDFLAGS) -Wl,--start-group $(filter %.o %.a,$^) -Wl,--end-group $(1) -o $@

.PHONY: help
help: ## every day | list the targets
	@awk -f tests/house/help.awk $(filter-out %.d,$(MAKEFILE_LIST))

.PHONY: all
all: ## every day | build firmware images, matrig, matrig-study and matrig-board

include packages.mk
include $(addsuffix /module.mk,common hil host host/base firmware tests docs $(sort $(patsubst %/module.mk,%,$(wildcard tests/*/module.mk))))

all: $(images) $(stacks) $(board_tables) $(programs) $(studies) $(manuals)

.PHONY: have-port
have-port:
	@grep -q 'FACT(IS_ROM_ON_SERIAL, 1,' firmware/boards/$(BOARD).def || { echo "the boot ROM of the board $(BOARD) does not listen at its serial link: docs/howto/boards.md has the line for its ST-LINK" >&2; exit 2; }
	@[ -n "$(PORT)" ] || { echo "which board? Give its serial port: make flash PORT=/dev/ttyUSB0" >&2; exit 2; }
.PHONY: flash
flash: have-port $(chosen) $(B)/matrig ## every day | PORT=/dev/ttyUSB0 BOARD=zg: program a board through its boot ROM
	@$(B)/matrig flash $(if $(findstring :,$(firstword $(subst /, ,$(PORT)))),,serial:)$(PORT) $(chosen) $(FLASH_OPTIONS)

PREFIX ?= /usr/local
installed := $(DESTDIR)$(PREFIX)
# What is installed, a FOLDER:FILE each, or FOLDER/NAME:FILE where it gets another name. Documentation keeps the folders of the sources, so its links hold.
documentation := README.md LICENSE $(wildcard docs/*.md docs/*/*.md docs/pictures/* hil/*.md host/*/*.md host/*/*/*.md tests/*/*.md \
	host/*/*.png host/*/*/*.png)
put = $(foreach file,$(2),$(1)/$(notdir $(file)):$(file))
install_list = $(call put,bin,$(programs)) $(call put,libexec/matrig,$(studies)) $(foreach board,$(boards),$(call put,share/matrig$(if $(filter-out zg,$(board)),/$(board)),$(call image_files,$(call board_elf,$(board))) $(call bringup_elf,$(board)))) \
	$(call put,share/matrig/scenes,$(wildcard host/scenes/*.json)) $(call put,share/matrig/series,$(wildcard host/landing_series/series/*.json)) \
	$(call put,share/matrig,host/demo.sh) $(call put,share/matrig/runs,$(wildcard tests/runs/*.run) hil/rest.run) \
	$(call put,share/man/man1,$(filter %.1,$(manuals))) \
	$(foreach file,$(documentation),share/doc/matrig/$(file):$(file)) \
	share/doc/matrig/LICENCES.md:docs/licences.md share/doc/matrig/LICENSE.dygraphs:$(dygraphs_licence)
# Folders that hold nothing else.
install_own := libexec/matrig share/matrig share/doc/matrig
.PHONY: install
install: all ## every day | PREFIX=/usr/local DESTDIR=: programs, firmware images, scenes, landings, man pages, documentation, licences
	@set -e; for pair in $(install_list); do mode=644; \
		case $$pair in bin/*|libexec/*|*.sh:*) mode=755;; esac; install -D -m $$mode "$${pair#*:}" "$(installed)/$${pair%%:*}"; done
.PHONY: uninstall
uninstall: ## every day | PREFIX=/usr/local DESTDIR=: take away what install put there
	@for pair in $(install_list); do rm -f "$(installed)/$${pair%%:*}"; done
	@for folder in $(install_own); do rm -rf "$(installed)/$$folder"; done

.PHONY: deb
deb: in-build $(B)/.deb-packages ## longer | Debian packages matrig, matrig-board, matrig-study of the sources as they stand: build/deb
	@debian/build.sh

.PHONY: demo
demo: $(chosen) $(programs) ## every day | BOARD=zg: a day on the emulated board, 3 to 4 min on two slow cores: landings, survey, advice, a warning: build/demo/report.html
	@rm -rf $(B)/demo
	@$(B)/matrig demo $(B)/demo --elf $(chosen)

.PHONY: clean
clean: ## every day | remove build/
	rm -rf $(B)

.SECONDARY:
# Beside them lie builds of other compilers and a whole Debian, whose folders end in .d too.
-include $(shell find $(addprefix $(B)/,arm firmware host tests) -name '*.d' -type f 2>/dev/null)
