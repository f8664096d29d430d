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
ARM_CFLAGS ?= -O2 -g
WERROR := $(if $(filter file,$(origin CFLAGS)),-Werror)

WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wundef -Wshadow -Wstrict-prototypes -Wmissing-prototypes $(WERROR)
# No fused multiply-add on any side: host and board must round alike. No errno from sqrt: it is one instruction.
OUR_FLAGS := -std=c11 $(WARNINGS) -ffp-contract=off -fno-math-errno -I. -MMD -MP
HOST_FLAGS = $(CPPFLAGS) $(CFLAGS) $(OUR_FLAGS) -D_GNU_SOURCE $(COVERAGE)
ARM_CPU := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
ARM_FLAGS := $(ARM_CFLAGS) $(OUR_FLAGS) $(ARM_CPU) -ffreestanding -ffunction-sections -fdata-sections

objects = $(patsubst %.c,$(B)/$(1)/%.o,$(2))
# A program of what it depends on: $(call link,LIBRARIES)
link = $(CC) $(CFLAGS) $(LDFLAGS) -Wl,--start-group $(filter %.o %.a,$^) -Wl,--end-group $(1) -o $@

.PHONY: help
help: ## every day | list the targets
	@awk -f tests/house/help.awk $(filter-out %.d,$(MAKEFILE_LIST))

.PHONY: all
all: ## every day | build firmware images, matrig, matrig-study and matrig-board

include packages.mk
include $(addsuffix /module.mk,common hil host host/live firmware tests docs $(sort $(patsubst %/module.mk,%,$(wildcard tests/*/module.mk))))

all: $(images) $(B)/firmware/stack.txt $(programs) $(studies) $(manuals)

.PHONY: have-port
have-port:
	@[ -n "$(PORT)" ] || { echo "which board? Give its serial port: make flash PORT=/dev/ttyUSB0" >&2; exit 2; }
.PHONY: flash
flash: have-port $(images) $(B)/matrig ## every day | PORT=/dev/ttyUSB0: program a board through its boot ROM
	@$(B)/matrig flash $(if $(findstring :,$(firstword $(subst /, ,$(PORT)))),,serial:)$(PORT) $(firmware) $(FLASH_OPTIONS)

PREFIX ?= /usr/local
installed := $(DESTDIR)$(PREFIX)
.PHONY: install
install: all ## every day | PREFIX=/usr/local DESTDIR=: programs, firmware images, scenes, man page, completion, licences
	install -d $(addprefix $(installed)/,bin libexec/matrig share/man/man1 share/bash-completion/completions share/matrig/scenes share/doc/matrig)
	install -m 755 $(programs) $(installed)/bin
	install -m 755 $(studies) $(installed)/libexec/matrig
	install -m 644 $(images) $(installed)/share/matrig
	install -m 644 host/scenes/*.json $(installed)/share/matrig/scenes
	install -m 644 $(B)/matrig.1 $(installed)/share/man/man1
	install -m 644 $(B)/matrig.bash $(installed)/share/bash-completion/completions/matrig
	install -m 644 LICENSE $(installed)/share/doc/matrig
	install -m 644 $(dir $(uplot))../LICENSE $(installed)/share/doc/matrig/LICENSE.uPlot
	install -m 644 docs/licences.md $(installed)/share/doc/matrig/LICENCES.md
.PHONY: uninstall
uninstall: ## every day | PREFIX=/usr/local DESTDIR=: take away what install put there
	rm -f $(addprefix $(installed)/bin/,$(notdir $(programs))) $(installed)/share/man/man1/matrig.1 \
		$(installed)/share/bash-completion/completions/matrig
	rm -rf $(addprefix $(installed)/,libexec/matrig share/matrig share/doc/matrig)

.PHONY: demo
demo: $(firmware) $(programs) ## every day | play a landing to the emulated board, log it, compare it, report it: build/demo/report.html
	@tests/demo.sh

.PHONY: clean
clean: ## every day | remove build/
	rm -rf $(B)

.SECONDARY:
# Beside them lie builds of other compilers and a whole Debian, whose folders end in .d too.
-include $(shell find $(addprefix $(B)/,arm firmware host tests) -name '*.d' -type f 2>/dev/null)
