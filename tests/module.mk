# Unit tests, images for the emulated board, and the targets that run what is here. A study says in its own folder how it is built.
tests_of = $(patsubst %.c,$(B)/%,$(wildcard tests/$(1)/test_*.c tests/$(1)/onboard/test_*.c))
tests := $(foreach part,common firmware hil host sim_reference,$(call tests_of,$(part)))
test_images := $(patsubst %.c,$(B)/%.elf,$(wildcard tests/hil/images/*.c tests/conformance/images/*.c))
variants := $(patsubst %.h,$(B)/%.elf,$(wildcard tests/variant/*.h))

# Tests name their programs and images as build/...
.PHONY: in-build
in-build:
	@[ "$(B)" = build ] || { echo "tests run in build/; leave B=$(B) out" >&2; exit 2; }

.PHONY: test
test: in-build $(B)/.test-packages all $(tests) $(test_images) $(variants) test-programs ## tests | unit tests, emulated-board tests, command-line tests
	@tests/run-all.sh $(tests) $(filter-out tests/cli/tap.sh,$(sort $(wildcard tests/cli/*.sh)))
.PHONY: test-programs
test-programs: # its needs are said where each is built

bench_programs := $(B)/tests/fit/coverage
# What the targets need, built and not run: tests/house/targets.py finds a target of which something is forgotten here.
needed := $(tests) $(test_images) $(variants) $(bench_programs) $(patsubst %,$(B)/tests/%,linux/bridge sim_reference/reference)
.PHONY: build-all
build-all: all $(needed) test-programs coverage-build fuzz-programs ## tests | all programs that any of these targets needs, built and not run

# What has more of the same to check than make test takes the time for (tests/long.h, take in tests/cli/tap.sh).
long_tests := $(B)/tests/hil/test_blackbox $(B)/tests/hil/test_electronics $(B)/tests/hil/test_velocity $(B)/tests/host/test_push $(B)/tests/host/test_sim_extremes $(B)/tests/host/test_sim_planar \
	$(addprefix tests/cli/,braking.sh electronics.sh kth.sh log-hold.sh replay.sh runs.sh soak-host.sh stability.sh strangers.sh)
.PHONY: long
long: in-build $(B)/.test-packages all $(filter $(B)/%,$(long_tests)) $(variants) test-programs ## longer | the checks of make test that have more cases or longer times, with all of them; then make certify (25 min)
	@MATRIG_LONG=1 tests/run-all.sh $(long_tests)
	@python3 tests/certify/certify.py

.PHONY: test-bare
test-bare: $(B)/.bare-packages ## tests | BUSY=0: make test in a bare Debian: no root, a path with spaces, TERM=dumb, LANG=C, no network, no names; needs root
	@tests/bare.sh

.PHONY: test-deb
test-deb: in-build $(B)/.deb-test-packages deb ## tests | TWICE=: the packages in a bare Debian, without sources and network: installed, used, removed without a trace; needs root
	@TWICE=$(TWICE) tests/run-all.sh tests/deb.sh

.PHONY: test-day
test-day: in-build $(B)/.test-packages all ## tests | the test day of docs/howto/test-day.md, line by line, on the emulated board: build/day
	@tests/run-all.sh tests/test-day.sh

.PHONY: test-browser
test-browser: in-build $(B)/.browser-packages all ## tests | live view and report in headless Chromium: values, warning within 200 ms, nothing from elsewhere
	@tests/browser/run.sh

.PHONY: bench
bench: in-build $(B)/.test-packages all $(variants) $(bench_programs) $(filter $(B)/tests/hil/images/mix_%,$(test_images)) ## longer | timings, as ratios within one run
	@tests/bench.sh

.PHONY: coverage
coverage: $(B)/.coverage-packages coverage-build ## longer | branches of common/ and of the firmware above board.h that their tests take: build/coverage/branches.txt
	@tests/coverage.sh $(B)/coverage
.PHONY: coverage-build
coverage-build: $(B)/.test-packages $(host_lib) # of the host as it is: only what the board has in common with it is counted
	@$(MAKE) -s B=$(B)/coverage CC="$(CC) --coverage" COVERAGE="-O0 -g0 -Wno-error" host_lib=$(host_lib) host_src= coverage-programs
.PHONY: coverage-programs
coverage-programs: $(call tests_of,common) $(call tests_of,firmware) $(B)/tests/host/test_zonescan $(B)/tests/host/test_predictor $(B)/tests/host/test_predictor_extremes

.PHONY: series
series: in-build all $(B)/tests/runs/synthesise ## studies | landings 1 to 5 of the standard series on the emulated board, its runway kept: said | observed 1973 | true
	@mkdir -p $(B)/runs
	@[ -e $(B)/runs/landing5.run ] || $(B)/tests/runs/synthesise $(B)/runs >$(B)/runs/table.txt
	@tests/series.sh | tee $(B)/runs/series.txt

.PHONY: budget
budget: in-build all ## studies | what each task of the firmware costs in a landing, on the emulated board: build/budget/budget.txt
	@tests/budget.sh

.PHONY: boards
boards: in-build all ## studies | each board's image: size, channels, what landing 5 and the demo say on the emulated board: build/boards/boards.txt
	@tests/boards.sh $(boards)

$(B)/tests/%.o: tests/%.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(HOST_FLAGS) $(COVERAGE) $(TEST_CFLAGS) -c $< -o $@


# What the drivers' register header defines, for the comparison of layouts.
$(B)/tests/hil/registers.inc: firmware/f407/regs.h tests/conformance/registers.awk
	@mkdir -p $(@D)
	$(call say,GEN,$@)awk -f tests/conformance/registers.awk $< >$@
$(B)/tests/hil/test_layouts.o: $(B)/tests/hil/registers.inc
$(B)/tests/hil/test_layouts.o: HOST_FLAGS += -I$(B)/tests/hil

$(tests): $(B)/tests/main.o
$(call tests_of,common): $(B)/tests/common/%: $(B)/tests/common/%.o $(common_lib)
	$(call link,-lcmocka -lz -lm)
fakes := $(patsubst %,$(B)/tests/firmware/fake_%.o,board nor flash i2c)
$(call tests_of,firmware): $(B)/tests/firmware/test_%: $(B)/tests/firmware/test_%.o $(fakes) $(app_lib) $(common_lib)
	$(call link,-lcmocka -lm)
$(B)/tests/firmware/test_pins $(B)/tests/hil/test_boards: $(board_tables)
$(call tests_of,hil): $(B)/tests/hil/test_%: $(B)/tests/hil/test_%.o $(hil_lib) $(common_lib)
	$(call link,-lcmocka $(HIL_LIBS))
# What they run: the images, and the program for the test of its command line. Order alone: a new image needs no new linking.
$(call tests_of,hil): | $(foreach board,$(boards),$(call board_elf,$(board))) $(test_images) $(variants) $(B)/matrig-board
$(patsubst %,$(B)/tests/hil/test_%,blackbox configuration debug drivers landing nor snapshot): $(B)/tests/hil/snapshot.o
# Images of the past (tests/old/README.md).
$(B)/tests/old/%.elf: tests/old/%.elf.gz
	@mkdir -p $(@D)
	$(call say,GEN,$@)gzip -dc $< >$@
$(B)/tests/hil/test_rules: | $(B)/tests/old/339b9da.elf
test-programs: $(B)/tests/old/339b9da.elf
# The application on the host too: to say when a warning was due; the configuration that is built in.
$(B)/tests/hil/test_warning $(B)/tests/hil/test_canbase: $(fakes) $(app_lib)
$(B)/tests/host/test_series: $(B)/tests/scoreboard/facts.o
$(B)/tests/host/test_chain_reference: $(patsubst %,$(B)/tests/stability/%.o,chain_reference chain_reference_long)
$(call tests_of,host): $(B)/tests/host/test_%: $(B)/tests/host/test_%.o $(host_lib) $(common_lib)
	$(call link,-lcmocka $(if $(filter $(study_lib),$^),$(STUDY_LIBS),$(HOST_LIBS)))
# Of the host, with what matrig-study has.
$(patsubst %,$(B)/tests/host/test_%,error_study fit fit_beside fit_misfit fit_surveyed fit_verdict sim_extremes sim_ground_damping sim_model sim_planar): $(study_parts)

# Images of other rigs, for tests: the one source of the firmware that a variant is about, compiled after a header that includes what it changes
# and defines some of it anew (tests/variant, one file each, which says why).
variant_source = $(or $(variant_source_$(1)),firmware/config)
variant_source_rest := common/onboard/landing
variant_source_changing := firmware/main
# A header that changes nothing is an error: what it defines has another name by now.
$(B)/tests/variant/%.elf: tests/variant/%.h $(firmware) $(firmware:.elf=.bin)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc $(ARM_FLAGS) -include $< -c $(call variant_source,$*).c -o $(@:.elf=.o)
	$(call say,LD,$@)$(call link_image,zg) $(patsubst $(B)/arm/$(call variant_source,$*).o,$(@:.elf=.o),$(call board_objects,zg)) -lgcc -o $@
	$(Q)$(stamp) $@ $$(cat $(commit))
	@$(ARM)objcopy -O binary --gap-fill 0xff $@ $(@:.elf=.bin)
	@! cmp -s $(@:.elf=.bin) $(firmware:.elf=.bin) || { echo "$<: the image is the firmware as it is; what should differ?" >&2; exit 1; }

$(B)/tests/hil/images/%.elf: tests/hil/images/%.c tests/hil/images/image.ld tests/hil/images/image.h | $(B)/.test-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc -std=c11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -nostdlib -I. -T tests/hil/images/image.ld $< -lgcc -o $@
# The predictor as the firmware has it.
$(B)/tests/hil/images/predictor_cost.elf: tests/hil/images/predictor_cost.c tests/hil/images/image.ld tests/hil/images/image.h \
		$(patsubst %,$(B)/arm/%.o,$(predictor_parts))
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc -std=c11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -fno-tree-loop-distribute-patterns -nostdlib -I. \
		-T tests/hil/images/image.ld $(filter %.c %.o,$^) -lgcc -o $@

$(B)/tests/conformance/images/%.elf: tests/conformance/images/%.c $(wildcard tests/conformance/images/*.h) tests/conformance/images/image.ld | $(B)/.test-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(ARM)gcc -std=gnu11 -O2 -g -Wall -Wextra -Werror $(ARM_CPU) -ffreestanding -fno-tree-loop-distribute-patterns -nostdlib \
		-T tests/conformance/images/image.ld $< -lgcc -o $@
