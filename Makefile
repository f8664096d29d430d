# matrig: firmware, host tool, emulated board and their tests. `make help` lists the targets.

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules

B := build
ARM ?= arm-none-eabi-

WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wundef -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Werror
# No fused multiply-add on any side: host and board must round alike. No errno from sqrt: it is one instruction.
COMMON_FLAGS := -std=c11 -O2 -g $(WARNINGS) -ffp-contract=off -fno-math-errno -I. -MMD -MP
HOST_FLAGS := $(COMMON_FLAGS) -D_GNU_SOURCE $(COVERAGE)
ARM_CPU := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
ARM_FLAGS := $(COMMON_FLAGS) $(ARM_CPU) -ffreestanding -ffunction-sections -fdata-sections

# What Debian 12 must have: to build and play the demo, beyond that for studies (matrig-study), and to test.
DEMO_PACKAGES := gcc-arm-none-eabi libnewlib-arm-none-eabi libunicorn-dev libsqlite3-dev libjansson-dev \
	libserialport-dev libmd-dev zlib1g-dev libmicrohttpd-dev libc6-dev
STUDY_PACKAGES := $(DEMO_PACKAGES) libsundials-dev libgsl-dev
TEST_PACKAGES := $(STUDY_PACKAGES) libcmocka-dev qemu-system-arm can-utils sqlite3 \
	gdb-multiarch gtkwave stm32flash python3 groff-base gnuplot-nox $(if $(shell command -v npm),,npm)
COVERAGE_PACKAGES := $(TEST_PACKAGES) gcovr
FUZZ_PACKAGES := $(TEST_PACKAGES) clang
# And to decode a candump log beside matrig.
BENCH_PACKAGES := $(TEST_PACKAGES) python3-can
# To drive the pages in a browser.
BROWSER_PACKAGES := $(TEST_PACKAGES) chromium python3
# And to test in a Debian without anything.
BARE_PACKAGES := debootstrap iproute2 util-linux
# And to test real Linux links, in a guest.
LINUX_PACKAGES := $(TEST_PACKAGES) qemu-system-x86 busybox-static iproute2 slurmctld slurmd slurm-client munge parallel

common_src := $(wildcard common/*.c common/onboard/*.c)
app_src := $(filter-out firmware/main.c,$(wildcard firmware/*.c))
hil_rooms := core periph chips rig board link debug
hil_src := $(filter-out hil/main.c,$(wildcard hil/*.c $(hil_rooms:%=hil/%/*.c)))
# The predictor and what it is made of, for the programs that have it alone.
predictor_parts := $(basename $(wildcard common/predictor*.c)) common/zonescan common/matchain common/closure
host_src := $(filter-out host/main.c host/study/% %/cvode.c %/error_study.c,$(wildcard host/*.c host/*/*.c host/*/*/*.c))
# What needs GSL or SUNDIALS, and the commands that matrig-study runs for matrig (host/commands/study_start.h).
study_src := $(filter-out host/study/main.c,$(wildcard host/study/*.c host/study/*/*.c)) $(filter %/cvode.c %/error_study.c,$(wildcard host/sim/*.c host/sim/*/*.c))
arm_src := $(common_src) $(wildcard firmware/*.c firmware/f407/*.c)
runs_src := $(wildcard tests/runs/*.c)
figures_src := $(wildcard tests/figures/*.c)
bench_src := $(wildcard tests/bench/*.c)
error_report_src := $(wildcard tests/error_report/*.c)
stability_src := $(wildcard tests/stability/*.c)
score_src := $(wildcard tests/score/*.c)
fit_cheap_src := tests/fit/cheap.c
campaigns_src := $(wildcard tests/campaigns/*.c)
identity_src := $(wildcard tests/identity/*.c) tests/score/truth.c tests/runs/runfile.c
golden_src := $(wildcard tests/golden/*.c)
campaign_figures_src := $(wildcard tests/campaign_figures/*.c)
series := $(addprefix host/campaign/series/,$(addsuffix .json,standard friction control_mild control_fresh bands_preliminary \
	bands_detailed diagonal cleats stiffeners dyess))
reference_src := $(addprefix tests/sim_reference/,scene.c model.c march.c)

objects = $(patsubst %.c,$(B)/$(1)/%.o,$(2))
tests_of = $(patsubst %.c,$(B)/%,$(wildcard tests/$(1)/test_*.c tests/$(1)/onboard/test_*.c))

common_lib := $(B)/host/libcommon.a
hil_lib := $(B)/host/libhil.a
host_lib := $(B)/host/libhost.a
app_lib := $(B)/host/libapp.a
study_lib := $(B)/host/libstudy.a
study_objects := $(call objects,host,$(study_src))
# What matrig-study has beyond matrig. cvode as an object: the solver is there when it is linked (host/sim/solvers/stepper.h).
study_parts := $(filter %/cvode.o,$(study_objects)) $(study_lib)
# Unicorn is GPL-2.0: only matrig-board and the tests of hil link it, never matrig. libserialport is LGPL-3.0-or-later, GSL
# GPL-3.0-or-later: the tests of host link them, of the programs matrig the former and matrig-study both, never matrig-board (GPL-2.0 and
# 3.0 do not go together).
HIL_LIBS := -lunicorn -lm
HOST_LIBS := -lsqlite3 -ljansson -lmicrohttpd -lserialport -lmd -lz -lm
STUDY_LIBS := -lsundials_cvode -lsundials_nvecserial -lsundials_sunmatrixband -lsundials_sunlinsolband -lgsl -lgslcblas $(HOST_LIBS)

firmware := $(B)/firmware/matrig.elf
images := $(firmware) $(firmware:.elf=.hex) $(firmware:.elf=.bin) $(B)/firmware/vectors.bin $(B)/firmware/program.bin
programs := $(B)/matrig $(B)/matrig-board
studies := $(B)/matrig-study
manuals := $(B)/matrig.1 $(B)/matrig.bash
test_images := $(patsubst %.c,$(B)/%.elf,$(wildcard tests/hil/images/*.c tests/conformance/images/*.c))
# Of the host, with what matrig-study has.
study_tests := error_study fit fit_surveyed fit_verdict sim_extremes sim_ground_damping sim_growth sim_model sim_planar
tests := $(foreach part,common firmware hil host sim_reference,$(call tests_of,$(part)))
variants := $(patsubst %.h,$(B)/%.elf,$(wildcard tests/variant/*.h))
test_programs := $(B)/tests/runs/synthesise $(B)/tests/figures/figures $(B)/tests/error_report/error-report \
	$(B)/tests/stability/stability $(B)/tests/score/score $(B)/tests/campaigns/campaigns $(B)/tests/identity/draw \
	$(B)/tests/campaign_figures/campaign-figures $(B)/tests/pilot/pilot $(B)/tests/golden/golden $(B)/tests/soak/soak $(B)/tests/soak_host/sender $(B)/tests/link/faults.so $(B)/tests/link/longlanding

# A parser of DBC files that is not ours.
candied := build/npm-exchange/node_modules/candied/package.json
fuzz_targets := $(patsubst tests/fuzz/fuzz_%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
fuzz_programs := $(patsubst %,$(B)/tests/fuzz/fuzz_%,$(fuzz_targets))

.PHONY: help
help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' Makefile

.PHONY: deps
deps: $(B)/.demo-packages $(B)/.test-packages ## install what is missing (Debian packages)

.PHONY: all
all: $(images) $(B)/firmware/stack.txt $(programs) $(studies) $(manuals) ## build firmware images, matrig, matrig-study and matrig-board

.PHONY: have-port
have-port:
	@[ -n "$(PORT)" ] || { echo "which board? Give its serial port: make flash PORT=/dev/ttyUSB0" >&2; exit 2; }
.PHONY: flash
flash: have-port $(images) $(B)/matrig ## program a board through its boot ROM: make flash PORT=/dev/ttyUSB0
	@$(B)/matrig flash $(if $(findstring :,$(firstword $(subst /, ,$(PORT)))),,serial:)$(PORT) $(firmware) $(FLASH_OPTIONS)

.PHONY: golden
golden: all $(B)/tests/golden/golden ## keep what today's image says to the golden landings as a new version (FIRST=1: all anew): tests/golden
	@FIRST=$(FIRST) tests/golden/record.sh

PREFIX ?= /usr/local
installed := $(DESTDIR)$(PREFIX)
.PHONY: install
install: all ## PREFIX=/usr/local DESTDIR=: programs, firmware images, scenes, man page, completion, licences
	install -d $(addprefix $(installed)/,bin libexec/matrig share/man/man1 share/bash-completion/completions share/matrig/scenes share/doc/matrig)
	install -m 755 $(programs) $(installed)/bin
	install -m 755 $(studies) $(installed)/libexec/matrig
	install -m 644 $(firmware) $(firmware:.elf=.hex) $(firmware:.elf=.bin) $(installed)/share/matrig
	install -m 644 host/scenes/*.json $(installed)/share/matrig/scenes
	install -m 644 $(B)/matrig.1 $(installed)/share/man/man1
	install -m 644 $(B)/matrig.bash $(installed)/share/bash-completion/completions/matrig
	install -m 644 LICENSE $(installed)/share/doc/matrig
	install -m 644 $(dir $(uplot))../LICENSE $(installed)/share/doc/matrig/LICENSE.uPlot
	sed -n '/^## Licence/,/^## [^L]/p' README.md >$(installed)/share/doc/matrig/LICENCES.md
.PHONY: uninstall
uninstall: ## PREFIX=/usr/local DESTDIR=: take away what install put there
	rm -f $(addprefix $(installed)/bin/,$(notdir $(programs))) $(installed)/share/man/man1/matrig.1 \
		$(installed)/share/bash-completion/completions/matrig
	rm -rf $(addprefix $(installed)/,libexec/matrig share/matrig share/doc/matrig)

.PHONY: demo
demo: $(firmware) $(programs) ## play a landing to the emulated board, log it, compare it, report it: build/demo/report.html
	@tests/demo.sh

.PHONY: test
test: $(B)/.test-packages all $(candied) $(tests) $(test_images) $(variants) $(test_programs) $(fuzz_programs) ## unit tests, emulated-board tests, command-line tests
	@tests/run-all.sh $(tests) $(filter-out tests/cli/tap.sh,$(sort $(wildcard tests/cli/*.sh)))

.PHONY: test-linux
test-linux: $(B)/.linux-packages all $(B)/tests/linux/bridge ## real Linux CAN and serial, in a QEMU guest: frames sent, received, lost; sweeps through Slurm and GNU parallel
	@tests/run-all.sh tests/linux/slurm.sh
	@tests/linux/run.sh

.PHONY: test-bare
test-bare: $(B)/.bare-packages ## BUSY=0: make test in a bare Debian: no root, a path with spaces, TERM=dumb, LANG=C, no network, no names; needs root
	@tests/bare.sh

.PHONY: npm-files
npm-files:
	@echo $(uplot) $(candied)

.PHONY: test-day
test-day: $(B)/.test-packages all ## the test day of README.md, line by line, on the emulated board: build/day
	@tests/run-all.sh tests/test-day.sh

.PHONY: test-browser
test-browser: $(B)/.browser-packages all ## live view and report in headless Chromium: values, warning within 200 ms, nothing from elsewhere
	@tests/browser/run.sh

.PHONY: bench
bench: $(B)/.bench-packages all $(variants) $(B)/tests/bench/sim_bench $(B)/tests/exchange/decode $(B)/tests/fit/coverage $(filter $(B)/tests/hil/images/mix_%,$(test_images)) ## timings, as ratios within one run
	@tests/bench.sh
	@tests/exchange/bench.sh

.PHONY: coverage
coverage: $(B)/.coverage-packages ## branches of common/ and of the firmware above board.h that their tests take: build/coverage/branches.txt
	@$(MAKE) -s B=$(B)/coverage CC="$(CC) --coverage" COVERAGE="-O0 -Wno-error" coverage-programs
	@tests/coverage.sh $(B)/coverage

.PHONY: coverage-programs
coverage-programs: $(call tests_of,common) $(call tests_of,firmware) $(B)/tests/host/test_matchain $(B)/tests/host/test_zonescan $(B)/tests/host/test_predictor $(B)/tests/host/test_predictor_extremes

.PHONY: runs
runs: $(B)/tests/runs/synthesise ## synthesise the recorded landings again and compare them with those in tests/runs
	@mkdir -p $(B)/runs
	$(B)/tests/runs/synthesise $(B)/runs
	@for run in tests/runs/*.run; do cmp $$run $(B)/runs/$$(basename $$run) && echo "$$run: the same" || exit 1; done

.PHONY: figures
figures: $(B)/tests/figures/figures ## figures 3.6 to 3.12 of the 1973 report, redrawn, with a table: build/figures/figures.html
	@mkdir -p $(B)/figures
	$(B)/tests/figures/figures $(B)/figures

.PHONY: error-report
error-report: $(B)/tests/error_report/error-report ## every solver's error against its run time, seven scenes: build/error-report/index.html
	@mkdir -p $(B)/error-report
	$(B)/tests/error_report/error-report $(B)/error-report

.PHONY: stability
stability: $(B)/tests/stability/stability ## 2,000 scenes and 5,000 landings, every answer checked by a second method: build/stability/table.csv, landings.csv
	@mkdir -p $(B)/stability
	$(B)/tests/stability/stability $(B)/stability | tee $(B)/stability/summary.txt
	$(B)/tests/stability/stability --fixed $(B)/stability | tee $(B)/stability/landings.txt

.PHONY: score
score: $(B)/tests/score/score ## the predictor on seeded landings that are not its model, 1,500 in all: build/score/table.txt
	@mkdir -p $(B)/score
	$(B)/tests/score/score $(B)/score $(or $(FROM),0) $(or $(SERIES),500) | tee $(B)/score/table.txt

.PHONY: identity
identity: all $(B)/tests/identity/draw ## LANDINGS=20 SEED=1: the board's statements against the host's, bit for bit, on seeded landings
	@LANDINGS=$(or $(LANDINGS),20) SEED=$(or $(SEED),1) tests/cli/identity.sh

.PHONY: series
series: all $(B)/tests/runs/synthesise ## landings 1 to 5 of the standard series on the emulated board, its runway kept: said | observed 1973 | true
	@mkdir -p $(B)/runs
	@[ -e $(B)/runs/landing5.run ] || $(B)/tests/runs/synthesise $(B)/runs >$(B)/runs/table.txt
	@tests/series.sh | tee $(B)/runs/series.txt

.PHONY: report-series
report-series: all $(B)/tests/runs/synthesise ## the same five landings with surveys, compared, on one page: build/report-series/report.html
	@mkdir -p $(B)/runs
	@[ -e $(B)/runs/landing5.run ] || $(B)/tests/runs/synthesise $(B)/runs >$(B)/runs/table.txt
	@tests/report_series.sh

.PHONY: campaign-figures
campaign-figures: $(B)/tests/campaign_figures/campaign-figures $(B)/matrig ## SEEDS=4: figures 4.1 to 5.12 from the series: build/campaign-figures/figures.html
	@mkdir -p $(B)/campaign-figures
	$(B)/matrig scale host/campaign/series/standard.json -o $(B)/campaign-figures/standard_prototype.json >$(B)/campaign-figures/scale.txt
	$(B)/tests/campaign_figures/campaign-figures $(B)/campaign-figures $(or $(SEEDS),4)

.PHONY: pilot
pilot: $(B)/tests/pilot/pilot ## SEEDS=8: the pilot study's six results (report B.3), observed | computed | verdict: build/pilot.md
	$(B)/tests/pilot/pilot $(or $(SEEDS),8) | tee $(B)/pilot.md

.PHONY: campaigns
campaigns: $(B)/tests/campaigns/campaigns ## SEEDS=16: the report's series of landings, observed | predicted | verdict: build/campaigns/table.md
	@mkdir -p $(B)/campaigns
	SEEDS=$(SEEDS) $(B)/tests/campaigns/campaigns $(B)/campaigns $(series) | tee $(B)/campaigns/table.md

.PHONY: budget
budget: all ## what each task of the firmware costs in a landing, on the emulated board: build/budget/budget.txt
	@tests/budget.sh

.PHONY: soak
soak: $(B)/tests/soak/soak $(firmware) ## HOURS=1 SEED=1: virtual time with random faults; sent = received + declared lost, per message
	@mkdir -p $(B)/soak
	$(B)/tests/soak/soak $(or $(HOURS),1) $(or $(SEED),1) $(B)/soak | tee $(B)/soak/summary.txt

.PHONY: soak-host
soak-host: $(B)/tests/soak_host/sender $(B)/matrig ## HOURS=1 or SECONDS=: a full CAN bus and 2 Mbaud into one campaign: lost, memory, processor
	@mkdir -p $(B)/soak_host
	@tests/soak_host/run.sh $(or $(SECONDS),$(shell echo $$(($(or $(HOURS),1) * 3600)))) $(B)/soak_host | tee $(B)/soak_host/summary.txt

.PHONY: clean
clean: ## remove build/
	rm -rf $(B)

# --- packages: checked offline, installed only when missing ---
define install_packages
@mkdir -p $(B)
@missing=""; for p in $(1); do \
	dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$p"; done; \
if [ -n "$$missing" ]; then \
	run="apt-get install -y --no-install-recommends$$missing"; \
	if [ "$$(id -u)" = 0 ]; then as=""; \
	elif sudo -n true 2>/dev/null; then as="sudo "; \
	else echo "matrig needs packages that only root can install. Run:  apt-get update && $$run" >&2; exit 2; fi; \
	echo "installing:$$missing"; \
	$$as apt-get update -qq && DEBIAN_FRONTEND=noninteractive $$as $$run >$(B)/packages.log 2>&1 || \
		{ tail -n 5 $(B)/packages.log >&2; echo "installing failed; see $(B)/packages.log, or run:  $$as$$run" >&2; exit 2; }; \
fi
@touch $@
endef

$(B)/.demo-packages:
	$(call install_packages,$(DEMO_PACKAGES))
$(B)/.study-packages: $(B)/.demo-packages
	$(call install_packages,$(STUDY_PACKAGES))
$(B)/.test-packages: $(B)/.study-packages
	$(call install_packages,$(TEST_PACKAGES))
$(B)/.bench-packages: $(B)/.test-packages
	$(call install_packages,$(BENCH_PACKAGES))
$(B)/.browser-packages: $(B)/.test-packages
	$(call install_packages,$(BROWSER_PACKAGES))
$(B)/.bare-packages:
	$(call install_packages,$(BARE_PACKAGES))
$(B)/.linux-packages: $(B)/.test-packages
	$(call install_packages,$(LINUX_PACKAGES))
$(B)/.coverage-packages: $(B)/.test-packages
	$(call install_packages,$(COVERAGE_PACKAGES))
$(B)/.fuzz-packages: $(B)/.test-packages
	$(call install_packages,$(FUZZ_PACKAGES))

# --- host side ---
# The solvers' loops run over several mats at a time: O3 lets the compiler use vector instructions, without changing a
# result; the exceptions' flags are not looked at.
$(B)/host/host/sim/%.o: HOST_FLAGS += -O3 -fno-trapping-math
# GSL's element access inline, without range checks: the bootstrap of a fit is made of it.
$(B)/host/host/study/fit/%.o: HOST_FLAGS += -DHAVE_INLINE -DGSL_RANGE_CHECK_OFF
$(study_objects): | $(B)/.study-packages
$(B)/host/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(CC) $(HOST_FLAGS) -c $< -o $@

$(common_lib): $(call objects,host,$(common_src))
$(hil_lib): $(call objects,host,$(hil_src))
$(host_lib): $(call objects,host,$(host_src))
$(app_lib): $(call objects,host,$(app_src))
$(study_lib): $(filter-out %/cvode.o,$(study_objects))
$(common_lib) $(hil_lib) $(host_lib) $(app_lib) $(study_lib):
	@rm -f $@
	$(AR) rcs $@ $^

$(B)/matrig: $(B)/host/host/main.o $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/matrig-study: $(B)/host/host/study/main.o $(study_parts) $(host_lib) $(common_lib)
	$(CC) $^ $(STUDY_LIBS) -o $@
$(B)/matrig-board: $(B)/host/hil/main.o $(hil_lib) $(common_lib)
	$(CC) $^ $(HIL_LIBS) -o $@

# Man page and completion, from the table that --help prints. Dated by the commit.
$(B)/matrig.1: $(B)/matrig
	SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct 2>/dev/null) $< help --man >$@
$(B)/matrig.bash: $(B)/matrig
	$< help --bash >$@

# The boot ROM of the emulated board: a small program of its own, carried by matrig-board as bytes.
$(B)/hil/bootrom.elf: hil/rom/bootrom.c hil/rom/bootrom.ld | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(ARM)gcc -std=c11 -Os -g -Wall -Wextra -Werror -mcpu=cortex-m4 -mthumb -ffreestanding -nostdlib \
		-fno-tree-loop-distribute-patterns -T hil/rom/bootrom.ld $< -o $@
$(B)/hil/bootrom.bin: $(B)/hil/bootrom.elf
	$(ARM)objcopy -O binary --gap-fill 0xff --pad-to 0x1fff7000 $< $@
$(B)/host/hil/core/bootrom.o: HOST_FLAGS += -Wa,-I$(B)/hil
$(B)/host/hil/core/bootrom.o: $(B)/hil/bootrom.bin

# --- the live page: uPlot of the version and checksum in package-lock.json, carried by matrig as bytes ---
uplot := build/npm/node_modules/uplot/dist/uPlot.iife.min.js
$(uplot): host/live/page/package.json host/live/page/package-lock.json host/live/page/fetch.sh | $(B)/.demo-packages
	@sh host/live/page/fetch.sh build/npm
	@touch $@
$(B)/host/host/live/assets.o: $(uplot) $(wildcard host/live/page/live.*)

# --- tests only: a DBC parser that is not ours ---
$(candied): tests/exchange/package.json tests/exchange/package-lock.json | $(B)/.test-packages
	@mkdir -p build/npm-exchange
	@cp $^ build/npm-exchange/
	@cd build/npm-exchange && npm ci --ignore-scripts --no-audit --no-fund --omit-lockfile-registry-resolved --cache ./cache >npm.log 2>&1 || \
		{ grep -i err npm.log | head -n 3 >&2; echo "cannot fetch candied by npm; see build/npm-exchange/npm.log; it needs a network once" >&2; exit 2; }
	@touch $@

# --- firmware ---
$(B)/arm/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(ARM)gcc $(ARM_FLAGS) -fcallgraph-info=su -c $< -o $@

# From which commit, written anew only when it is another one: nothing else of time or place is in an image.
commit := $(B)/firmware/commit
stamp := $(B)/host/firmware/stamp/stamp
.PHONY: always
$(commit): always
	@mkdir -p $(@D)
	@commit=$$(git describe --always --dirty --abbrev=12 --exclude='*' 2>/dev/null || echo unknown); \
		[ "$$commit" = "$$(cat $@ 2>/dev/null)" ] || echo "$$commit" >$@
$(stamp): $(B)/host/firmware/stamp/stamp.o $(common_lib)
	$(CC) $^ -o $@

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

# Images of other rigs, for tests: the one source of the firmware that a variant is about, compiled after a header that includes what it changes
# and defines some of it anew (tests/variant, one file each, which says why).
variant_source = $(or $(variant_source_$(1)),firmware/config)
variant_source_rest := common/onboard/landing
variant_source_changing := firmware/main
# A header that changes nothing is an error: what it defines has another name by now.
$(B)/tests/variant/%.elf: tests/variant/%.h $(firmware) $(firmware:.elf=.bin)
	@mkdir -p $(@D)
	$(ARM)gcc $(ARM_FLAGS) -include $< -c $(call variant_source,$*).c -o $(@:.elf=.o)
	$(ARM)gcc $(ARM_CPU) -nostartfiles --specs=nano.specs -T firmware/f407/matrig.ld -Wl,--gc-sections \
		$(patsubst $(B)/arm/$(call variant_source,$*).o,$(@:.elf=.o),$(call objects,arm,$(arm_src))) -lm -o $@
	$(stamp) $@ $$(cat $(commit))
	@$(ARM)objcopy -O binary --gap-fill 0xff $@ $(@:.elf=.bin)
	@! cmp -s $(@:.elf=.bin) $(firmware:.elf=.bin) || { echo "$<: the image is the firmware as it is; what should differ?" >&2; exit 1; }

# --- tests ---
$(B)/tests/%.o: tests/%.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(CC) $(HOST_FLAGS) -c $< -o $@

# What the drivers' register header defines, for the comparison of layouts.
$(B)/tests/hil/registers.inc: firmware/f407/regs.h tests/conformance/registers.awk
	@mkdir -p $(@D)
	awk -f tests/conformance/registers.awk $< >$@
$(B)/tests/hil/test_layouts.o: $(B)/tests/hil/registers.inc
$(B)/tests/hil/test_layouts.o: HOST_FLAGS += -I$(B)/tests/hil

$(call tests_of,common): $(B)/tests/common/%: $(B)/tests/common/%.o $(common_lib)
	$(CC) $^ -lcmocka -lz -lm -o $@
$(call tests_of,firmware): $(B)/tests/firmware/test_%: $(B)/tests/firmware/test_%.o $(B)/tests/firmware/fake_board.o $(B)/tests/firmware/fake_nor.o $(B)/tests/firmware/fake_flash.o $(B)/tests/firmware/fake_i2c.o $(app_lib) $(common_lib)
	$(CC) $^ -lcmocka -lm -o $@
$(call tests_of,hil): $(B)/tests/hil/test_%: $(B)/tests/hil/test_%.o $(hil_lib) $(common_lib)
	$(CC) -Wl,--start-group $^ -Wl,--end-group -lcmocka $(HIL_LIBS) -o $@
# What they run: the images, and the program for the test of its command line. Order alone: a new image needs no new linking.
$(call tests_of,hil): | $(firmware) $(test_images) $(variants) $(B)/matrig-board
# The application on the host too, to say when a warning was due.
$(B)/tests/hil/test_warning: $(B)/tests/firmware/fake_board.o $(B)/tests/firmware/fake_nor.o $(B)/tests/firmware/fake_flash.o $(B)/tests/firmware/fake_i2c.o $(app_lib)
$(call tests_of,host): $(B)/tests/host/test_%: $(B)/tests/host/test_%.o $(host_lib) $(common_lib)
	$(CC) -Wl,--start-group $^ -Wl,--end-group -lcmocka $(if $(filter $(study_lib),$^),$(STUDY_LIBS),$(HOST_LIBS)) -o $@
$(patsubst %,$(B)/tests/host/test_%,$(study_tests)): $(study_parts)
# The predictor with every float a double, its other names hidden: both kinds go into one program.
double_objects := $(patsubst %,$(B)/tests/double/%.o,$(predictor_parts) tests/double/double)
$(double_objects): $(B)/tests/double/%.o: %.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(CC) $(HOST_FLAGS) -Wno-double-promotion -Dfloat=double -D__builtin_sqrtf=__builtin_sqrt -c $< -o $@
$(B)/tests/double/double.o: $(double_objects)
	$(LD) -r $^ -o $@
	objcopy $(foreach name,start block displacement_ft size,--keep-global-symbol=double_$(name)) $@
$(B)/tests/host/test_predictor_double: $(B)/tests/double/double.o
$(B)/tests/runs/synthesise: $(patsubst %.c,$(B)/%.o,$(runs_src))
	$(CC) $^ -lm -o $@
$(call tests_of,sim_reference): $(B)/tests/sim_reference/test_%: $(B)/tests/sim_reference/test_%.o \
		$(patsubst %.c,$(B)/%.o,$(reference_src)) $(host_lib) $(common_lib)
	$(CC) $^ -lcmocka $(HOST_LIBS) -o $@
$(B)/tests/figures/figures: $(patsubst %.c,$(B)/%.o,$(figures_src)) $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/bench/sim_bench: $(patsubst %.c,$(B)/%.o,$(bench_src)) $(study_parts) $(host_lib) $(common_lib)
	$(CC) $^ $(STUDY_LIBS) -o $@
$(B)/tests/error_report/error-report: $(patsubst %.c,$(B)/%.o,$(error_report_src)) $(study_parts) $(host_lib) $(common_lib)
	$(CC) $^ $(STUDY_LIBS) -o $@
$(B)/tests/stability/stability: $(patsubst %.c,$(B)/%.o,$(stability_src) $(reference_src)) $(study_parts) $(host_lib) $(common_lib)
	$(CC) $^ $(STUDY_LIBS) -o $@
$(B)/tests/score/score: $(patsubst %.c,$(B)/%.o,$(score_src)) $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/host/test_fit: $(patsubst %.c,$(B)/%.o,$(fit_cheap_src))
$(B)/tests/fit/coverage: $(B)/tests/fit/coverage.o $(patsubst %.c,$(B)/%.o,$(fit_cheap_src)) $(study_parts) $(host_lib) $(common_lib)
	$(CC) $^ $(STUDY_LIBS) -o $@
$(B)/tests/campaign_figures/campaign-figures: $(patsubst %.c,$(B)/%.o,$(campaign_figures_src)) $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
# With the configuration that is built into the firmware: a recording says what of it was given.
$(B)/tests/golden/golden: $(patsubst %.c,$(B)/%.o,$(golden_src)) $(B)/host/firmware/config.o $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/pilot/pilot: $(B)/tests/pilot/pilot.o $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/identity/draw: $(patsubst %.c,$(B)/%.o,$(identity_src)) $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/campaigns/campaigns: $(patsubst %.c,$(B)/%.o,$(campaigns_src)) $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
$(B)/tests/exchange/decode: $(B)/tests/exchange/decode.o $(host_lib) $(common_lib)
	$(CC) $^ $(HOST_LIBS) -o $@
# The host's accounting alone: matrig's libraries and Unicorn do not go into one program.
$(B)/tests/soak/soak: $(B)/tests/soak/soak.o $(B)/host/host/collect/account.o $(B)/host/host/collect/timebase.o $(hil_lib) $(common_lib)
	$(CC) $^ $(HIL_LIBS) -o $@
$(B)/tests/link/longlanding: $(B)/tests/link/longlanding.o $(B)/host/host/link/candump.o $(common_lib)
	$(CC) $^ -lm -o $@
# For LD_PRELOAD: clocks that jump or run fast, a full disk.
$(B)/tests/link/faults.so: tests/link/faults.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(CC) -std=c11 -O2 -Wall -Wextra -Werror -shared -fPIC $< -ldl -o $@
$(B)/tests/soak_host/sender: $(B)/tests/soak_host/sender.o $(B)/host/hil/periph/canbits.o $(B)/host/host/link/candump.o $(common_lib)
	$(CC) $^ -lm -o $@
$(B)/tests/linux/bridge: $(B)/tests/linux/bridge.o $(B)/host/hil/periph/canbits.o
	$(CC) $^ -o $@
$(B)/tests/sim_reference/reference: $(B)/tests/sim_reference/reference.o $(patsubst %.c,$(B)/%.o,$(reference_src))
	$(CC) $^ -ljansson -lm -o $@
$(B)/tests/hil/images/%.elf: tests/hil/images/%.c tests/hil/images/image.ld tests/hil/images/image.h | $(B)/.test-packages
	@mkdir -p $(@D)
	$(ARM)gcc -std=c11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -nostdlib -I. -T tests/hil/images/image.ld $< -lgcc -o $@
# The predictor as the firmware has it.
$(B)/tests/hil/images/predictor_cost.elf: tests/hil/images/predictor_cost.c tests/hil/images/image.ld tests/hil/images/image.h \
		$(patsubst %,$(B)/arm/%.o,$(predictor_parts))
	@mkdir -p $(@D)
	$(ARM)gcc -std=c11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -fno-tree-loop-distribute-patterns -nostdlib -I. \
		-T tests/hil/images/image.ld $(filter %.c %.o,$^) -lgcc -o $@

$(B)/tests/conformance/images/%.elf: tests/conformance/images/%.c $(wildcard tests/conformance/images/*.h) tests/conformance/images/image.ld | $(B)/.test-packages
	@mkdir -p $(@D)
	$(ARM)gcc -std=gnu11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -fno-tree-loop-distribute-patterns -nostdlib \
		-T tests/conformance/images/image.ld $< -lgcc -o $@

# --- fuzzing ---
# Parsers with sanitizers and libFuzzer, in a folder of their own, look for inputs (make fuzz); as they are, they are given what was
# found before (make test): a second build with sanitizers would take as long as all other tests.
SANITIZE := -fsanitize=address,undefined -fno-sanitize-recover=all

.PHONY: fuzz
fuzz: $(B)/.fuzz-packages ## SECONDS=600 PARSERS="candump ...": every parser, bytes by libFuzzer, with sanitizers: build/fuzz/table.txt
	@$(MAKE) -s B=$(B)/fuzz CC="clang $(SANITIZE) -fsanitize=fuzzer-no-link" COVERAGE="-O1 -Wno-error" FUZZ_MAIN=-fsanitize=fuzzer \
		$(patsubst %,$(B)/fuzz/tests/fuzz/fuzz_%,$(fuzz_targets))
	@tests/fuzz/run.sh $(B)/fuzz $(or $(SECONDS),600) $(or $(PARSERS),$(fuzz_targets))

FUZZ_MAIN = $(B)/tests/fuzz/replay.o
$(fuzz_programs): | $(B)/tests/fuzz/replay.o
$(patsubst %,$(B)/tests/fuzz/fuzz_%,$(filter-out board,$(fuzz_targets))): $(B)/tests/fuzz/fuzz_%: $(B)/tests/fuzz/fuzz_%.o $(B)/tests/fuzz/file.o $(B)/tests/fuzz/store.o $(host_lib) $(common_lib)
	$(CC) $^ $(FUZZ_MAIN) $(HOST_LIBS) -o $@
$(B)/tests/fuzz/fuzz_board: $(B)/tests/fuzz/fuzz_board.o $(B)/tests/fuzz/file.o $(hil_lib) $(common_lib)
	$(CC) -Wl,--start-group $^ -Wl,--end-group $(FUZZ_MAIN) $(HIL_LIBS) -o $@

.SECONDARY:
# build/bare holds a whole Debian, whose folders end in .d too.
-include $(shell find $(B) -path $(B)/bare -prune -o -name '*.d' -type f -print 2>/dev/null)
