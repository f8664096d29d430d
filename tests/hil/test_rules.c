/* Rules of time and electricity: what the firmware does to pins against what the chips around the
 * board demand. */
#include <unicorn/unicorn.h>

#include "hil/periph/adc.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"
#include "hil/core/elf.h"
#include "tests/hil/ear.h"

#define OLD_ELF      "build/tests/old/339b9da.elf"
#define PORT_B       1u
#define CYCLE_PS     62500 /* of 16 MHz */
#define USED_SECTORS 4u    /* erased in half a second */
/* a case of the image, with nothing plugged in: PB3 is open */
#define UNPLUGGED    51u
#define FED          60u
#define ERASED       61u

/* --- the time of a store --- */

/* Moments of the stores to port B that move PB12, by hil_access_timestamp. */
static struct stores {
    struct hil_board *board;
    bool was_high;
    unsigned count;
    struct hil_timestamp moment[64];
} stores;

static void note_store(void *context, unsigned port)
{
    struct stores *s = context;
    bool high = hil_board_pin_level(s->board, PORT_B, 12);
    if (port != PORT_B)
        return;
    struct hil_timestamp at = hil_access_timestamp(&s->board->core);
    if (high != s->was_high && s->count < 64)
        s->moment[s->count++] = at;
    s->was_high = high;
}

/* An image that stores at known distances, each store once, and one that is not made. */
TEST(each_store_has_the_time_of_its_instruction)
{
    static const unsigned high_cycles[] = {5, 1, 4, 30};
    struct hil_options options;
    hil_options_default(&options);
    options.has_adc_noise = false;
    struct hil_board *board = bench_board("pins", &options);
    stores = (struct stores){.board = board, .was_high = hil_board_pin_level(board, PORT_B, 12)};
    board->mcu.gpio.on_store = note_store;
    board->mcu.gpio.store_context = &stores;
    bench_run(board, HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 0), 1);
    assert_int_equal(stores.count, 9); /* low, then four times high and low */
    for (unsigned i = 0; i < 4; i++) {
        const struct hil_timestamp *rose = &stores.moment[1 + 2 * i], *fell = rose + 1;
        assert_int_equal(fell->ps - rose->ps, high_cycles[i] * CYCLE_PS);
    }
    assert_int_equal(stores.moment[4].pc - stores.moment[3].pc, 2);
    hil_board_destroy(board);
}

/* The first access behind a clock's enabling is looked at by its rule, and then by those of pins:
 * both ask for its time. In case 33 two NOPs (0xbf00) lie between. */
TEST(one_access_has_one_time)
{
    struct hil_options options;
    uint32_t nops = 0;
    hil_options_default(&options);
    struct hil_board *board = bench_board("rules", &options);
    stores = (struct stores){.board = board, .was_high = !hil_board_pin_level(board, PORT_B, 12)};
    board->mcu.gpio.on_store = note_store;
    board->mcu.gpio.store_context = &stores;
    bench_control(board, 0, 33);
    bench_run(board, HIL_PS_PER_MS);
    assert_int_equal(board->state.mcu.rules.tally[HIL_RULE_CLOCK_ENABLE].measurement_count, 1);
    assert_int_equal(stores.count, 1);
    assert_int_equal(hil_board_peek(board, stores.moment[0].pc - 4u, &nops, 4), MR_OK);
    assert_int_equal(nops, 0xbf00bf00u);
    assert_true(stores.moment[0].ps > 0);
    hil_board_destroy(board);
}

/* What a hook on every instruction of flash sees, against what hil_access_timestamp says. */
static struct witness {
    struct hil_board *board;
    uint32_t pc;
    unsigned stores, wrong_pc, wrong_time;
} witness;

static void witness_instruction(uc_engine *uc, uint64_t pc, uint32_t size, void *user)
{
    struct witness *w = user;
    (void)uc;
    (void)size;
    w->pc = (uint32_t)pc;
}

static void witness_store(void *context, unsigned port)
{
    struct witness *w = context;
    const struct hil_core *core = &w->board->core;
    struct hil_timestamp stamp = hil_access_timestamp(&w->board->core);
    unsigned before = 0;
    (void)port;
    for (uint32_t at = core->state.cpu.block_address; at < w->pc; before++) {
        uint16_t opcode;
        memcpy(&opcode, core->memory->flash + (at - HIL_FLASH_BASE), 2);
        at += opcode >= 0xe800u ? 4 : 2;
    }
    w->stores++;
    w->wrong_pc += stamp.pc != w->pc;
    w->wrong_time += stamp.ps !=
                     hil_clock_ps_at_cycle(&core->state.clock, hil_now_cycle(core) + before);
}

/* Everything that the black box does: looks for its chip, reads, erases a used chip, programs
 * through a landing, tells itself. */
static struct ear *black_box(const struct hil_options *options)
{
    static uint8_t used[HIL_NOR_SECTOR_BYTES];
    struct ear *ear = ear_open(options, 5);
    memset(used, 0x5a, sizeof used);
    for (uint32_t sector = 0; sector < USED_SECTORS; sector++)
        hil_w25q_poke(&ear->board->w25q, sector * HIL_NOR_SECTOR_BYTES, used, sizeof used);
    return ear;
}

static void work(struct ear *ear)
{
    ear_until(ear, 1.0);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_SELF_TEST, 0, 1);
    ear_until(ear, 3.0);
}

TEST(a_hook_on_every_instruction_says_the_same)
{
    uc_hook hook;
    struct ear *ear = black_box(NULL);
    witness = (struct witness){.board = ear->board};
    ear->board->mcu.gpio.on_store = witness_store;
    ear->board->mcu.gpio.store_context = &witness;
    assert_int_equal(uc_hook_add(ear->board->core.uc, &hook, UC_HOOK_CODE,
                                 (void *)(uintptr_t)witness_instruction, &witness, HIL_FLASH_BASE,
                                 HIL_FLASH_BASE + HIL_FLASH_SIZE - 1u),
                     UC_ERR_OK);
    work(ear);
    print_message("# %u stores to ports, %u at another instruction, %u at another time\n",
                  witness.stores, witness.wrong_pc, witness.wrong_time);
    assert_true(witness.stores > 5000);
    assert_int_equal(witness.wrong_pc, 0);
    assert_int_equal(witness.wrong_time, 0);
    ear_close(ear);
}

/* --- the firmware --- */

static const struct hil_rule_tally *tally(const struct ear *ear, enum hil_rule rule)
{
    return &ear->board->state.mcu.rules.tally[rule];
}

static void check_margins(const struct ear *ear, const char *when)
{
    static const struct {
        enum hil_rule rule;
        uint64_t judged_at_least;
    } wanted[] = {
        {HIL_RULE_SELECT_HIGH, 500},      {HIL_RULE_SELECT_HIGH_READS, 1000},
        {HIL_RULE_SELECT_TO_CLOCK, 1000}, {HIL_RULE_CLOCK_TO_DESELECT, 1000},
        {HIL_RULE_CLOCK_SLEW, 1000},      {HIL_RULE_RELEASE, 1},
        {HIL_RULE_POWER_TO_SELECT, 1},    {HIL_RULE_POWER_TO_WRITE, 5},
        {HIL_RULE_CLOCK_ENABLE, 1},       {HIL_RULE_WAIT_STATES, 1},
        {HIL_RULE_FLOATING, 1},
    };
    print_message("# %s:\n", when);
    hil_rules_print_tallies(&ear->board->mcu.rules, stdout);
    assert_int_equal(ear->board->state.mcu.rules.unlocated_edge_count, 0);
    for (unsigned i = 0; i < sizeof wanted / sizeof wanted[0]; i++)
        assert_true(tally(ear, wanted[i].rule)->measurement_count >= wanted[i].judged_at_least);
    for (unsigned i = 0; i < HIL_RULE_COUNT; i++)
        assert_int_equal(tally(ear, i)->violation_count, 0);
}

TEST(the_firmware_keeps_every_rule)
{
    struct ear *ear = black_box(NULL);
    work(ear);
    check_margins(ear, "crystal");
    /* select() waits for 60 ns by a clock that may be 4.5 % fast, 11 cycles of 168 MHz at least */
    assert_in_range((uint64_t)tally(ear, HIL_RULE_SELECT_HIGH)->worst_ns, 55, 200);
    ear_close(ear);
}

/* The internal oscillator, 1 % fast here; its data sheet allows 4.5 % (ACC_HSI). */
TEST(also_on_the_internal_oscillator)
{
    struct hil_options options = ear_options();
    options.hse_hz = 0;
    options.hsi_error_ppm = 10000;
    struct ear *ear = black_box(&options);
    work(ear);
    check_margins(ear, "internal oscillator");
    const struct hil_rule_tally *high = tally(ear, HIL_RULE_SELECT_HIGH);
    double at_fastest_ns = (high->worst_ns + high->slew_ns) * 1.01 / 1.045 - high->slew_ns;
    print_message("# %.1f ns when that oscillator is 4.5 %% fast\n", at_fastest_ns);
    assert_true(at_fastest_ns >= high->limit_ns);
    ear_close(ear);
}

TEST(holding_rules_changes_nothing)
{
    static const enum hil_rules_mode modes[] = {HIL_RULES_STOP, HIL_RULES_COUNT, HIL_RULES_OFF};
    struct ear *ear[3];
    for (unsigned i = 0; i < 3; i++) {
        struct hil_options options = ear_options();
        options.rules_mode = modes[i];
        ear[i] = black_box(&options);
        work(ear[i]);
        assert_int_equal(hil_now_cycle(&ear[i]->board->core), hil_now_cycle(&ear[0]->board->core));
        assert_memory_equal(hil_board_counters(ear[i]->board), hil_board_counters(ear[0]->board),
                            sizeof(struct hil_counters));
        assert_memory_equal(ear[i]->heard, ear[0]->heard, sizeof ear[0]->heard);
        assert_memory_equal(ear[i]->last, ear[0]->last, sizeof ear[0]->last);
    }
    assert_int_equal(tally(ear[2], HIL_RULE_SELECT_HIGH)->measurement_count, 0);
    for (unsigned i = 0; i < 3; i++)
        ear_close(ear[i]);
}

/* --- the image of 339b9da --- */

static struct hil_board *old_board(uint32_t counted, const struct hil_run *run)
{
    struct hil_options options = ear_options();
    options.counted_rules = counted;
    struct hil_board *board = hil_board_create(&options);
    if (hil_board_load_elf(board, OLD_ELF) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(board));
    hil_board_attach_rig(board, run);
    return board;
}

static void assert_stopped_by(struct hil_board *board, const char *rule, const char *function,
                              const char *measured)
{
    char wanted[80];
    snprintf(wanted, sizeof wanted, "rule %s: ", rule);
    assert_int_equal(hil_board_run_until(board, 3 * HIL_PS_PER_S), MR_HALTED);
    print_message("# %s\n", hil_board_failure_reason(board));
    if (strncmp(hil_board_failure_reason(board), wanted, strlen(wanted)) != 0 ||
        !strstr(hil_board_failure_reason(board), function) ||
        !strstr(hil_board_failure_reason(board), measured))
        fail_msg("%s, %s, %s: %s", rule, function, measured, hil_board_failure_reason(board));
    hil_board_destroy(board);
}

#define COUNTED(rule) (1u << HIL_RULE_##rule)

/* What stops it, and what would stop it next. All functions named are of nor.c but clock_start. */
TEST(the_old_image_is_stopped)
{
    struct hil_run still = {0};
    still_run(&still, EAR_STILL_S);
    uint32_t counted = COUNTED(WAIT_STATES);
    assert_stopped_by(old_board(0, &still), "WAIT_STATES", "clock_start", "FLASH_ACR");
    assert_stopped_by(old_board(counted, &still), "SELECT_TO_CLOCK", "nor_start",
                      "100 ns of slew subtracted");
    counted |= COUNTED(SELECT_TO_CLOCK);
    assert_stopped_by(old_board(counted, &still), "SELECT_HIGH", "from nor_start",
                      "7.1 ns (100 ns of slew subtracted), required 50.0");
    counted |= COUNTED(SELECT_HIGH);
    assert_stopped_by(old_board(counted, &still), "RELEASE", "from nor_start", "required 3000.0");
    counted |= COUNTED(RELEASE);
    struct hil_board *dead = old_board(counted, &still);
    dead->state.nor_fault_requests.is_dead = true;
    assert_stopped_by(dead, "FLOATING", "look_for_chip", "PB14");
    hil_run_free(&still);
}

/* A reading by somebody else found -76 ns of 50 on this pin (issue 18). */
TEST(and_its_worst_pulse_is_what_others_found)
{
    struct hil_options options = ear_options();
    struct hil_run run = {0};
    char error[256];
    options.rules_mode = HIL_RULES_COUNT;
    assert_int_equal(hil_run_read("tests/runs/landing5.run", &run, error, sizeof error), MR_OK);
    struct hil_board *board = hil_board_create(&options);
    assert_int_equal(hil_board_load_elf(board, OLD_ELF), MR_OK);
    hil_board_attach_rig(board, &run);
    bench_run(board, 3 * HIL_PS_PER_S);
    const struct hil_rule_tally *high = &board->state.mcu.rules.tally[HIL_RULE_SELECT_HIGH];
    print_message("# %llu of %llu too short, worst %.1f ns\n",
                  (unsigned long long)high->violation_count,
                  (unsigned long long)high->measurement_count, high->worst_ns);
    assert_true(high->violation_count > 250);
    assert_near(high->worst_ns, -76.0, 0.5);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* --- each rule broken by an image --- */

static struct hil_board *run_image(uint32_t which, uint32_t wait, uint32_t counted)
{
    struct hil_options options;
    hil_options_default(&options);
    options.counted_rules = counted;
    options.cell_times = HIL_TIMES_TYPICAL;
    options.has_no_rig = which == UNPLUGGED;
    struct hil_board *board = bench_board("rules", &options);
    bench_control(board, 0, which);
    bench_control(board, 1, wait);
    (void)hil_board_run_until(board, (which == ERASED ? 300 : 20) * HIL_PS_PER_MS);
    return board;
}

TEST(each_rule_stops_who_breaks_it)
{
    static const struct {
        uint32_t which, wait;
        const char *rule; /* NULL: it goes through */
        const char *measured;
    } cases[] = {
        {0, 0, NULL, NULL},
        {1, 0, "SELECT_HIGH", ": measured 2.0 ns (4 ns of slew subtracted), required 50.0"},
        {2, 0, "SELECT_HIGH_READS", ": measured 2.0 ns (4 ns of slew subtracted), required 10.0"},
        {3, 0, "SELECT_TO_CLOCK", "required 5.0"},
        {5, 0, "CLOCK_SLEW", "125.0 ns, required 250.0"},
        {6, 1, "RELEASE", "required 3000.0"},
        {6, 4, NULL, NULL},
        {7, 1, "POWER_DOWN", "required 3000.0"},
        {7, 4, NULL, NULL},
        {8, 10, "RESTART", "required 30000.0"},
        {8, 31, NULL, NULL},
        {9, 0, "POWER_TO_SELECT", "required 20000.0"},
        {10, 0, "POWER_TO_WRITE", "required 5000000.0"},
        {20, 0, NULL, NULL},
        {21, 0, "SCL_LOW", "required 1300.0"},
        {22, 0, "SCL_HIGH", "(1000 ns of slew subtracted), required 600.0"},
        {23, 0, "BUS_FREE", "(1000 ns of slew subtracted), required 600.0"},
        {30, 0, "CLOCK_ENABLE", "0 instructions after the store"},
        {31, 0, "CLOCK_ENABLE", "required: 2 cycles"},
        {32, 0, NULL, NULL},
        {33, 0, NULL, NULL},
        {34, 0, "WAIT_STATES", "from 16000000 to 168000000 Hz"},
        {40, 0, NULL, NULL},
        {41, 0, "FLOATING", "PE15 is an input, but nothing drives or pulls it"},
        {42, 0, "FLOATING", "P"},
        {43, 0, NULL, NULL},
        {44, 0, "FLOATING", "PE15"},
        {45, 0, NULL, NULL},
        {47, 0, "FLOATING", "PE15"},
        /* at 8 MHz: 2.5 / (8e6 * 4e-12 * 14 ln 2) - 6000 = 2051 Ohm; at 3 clocks and 8 MHz it is
         * enough for 1 k */
        {50, 0, NULL, NULL},
        {UNPLUGGED, 0, "FLOATING", "TIM2 captures edges of PB3, but nothing drives or pulls it"},
        {UNPLUGGED, 1, NULL, NULL}, /* pulled inside */
        {UNPLUGGED, 2, NULL, NULL},
        {52, 0, NULL, NULL},
        {FED, 0, "WATCHDOG_UPDATE", "RVU is set"},
        {FED, 1, NULL, NULL},
        {ERASED, 0, "STALE_CACHE", "sector 1 at 0x08004000"},
        {ERASED, 1, NULL, NULL},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_board *board = run_image(cases[i].which, cases[i].wait, 0);
        const char *reason = hil_board_failure_reason(board);
        char rule[40];
        print_message("# %u: %s\n", (unsigned)cases[i].which, reason);
        if (!cases[i].rule) {
            if (bench_result(board, 0) != 1 || reason[0])
                fail_msg("case %u does not come to its end: %s", (unsigned)cases[i].which, reason);
        } else {
            snprintf(rule, sizeof rule, "rule %s: ", cases[i].rule);
            if (strncmp(reason, rule, strlen(rule)) != 0 || !strstr(reason, cases[i].measured))
                fail_msg("case %u, %s, %s: %s", (unsigned)cases[i].which, rule, cases[i].measured,
                         reason);
        }
        hil_board_destroy(board);
    }
}

/* Reads of one place are judged no more when so many did no harm; in new code, and after a reset or
 * a restore, all are new. */
TEST(what_was_judged_is_forgotten)
{
    const uint32_t one = 1;
    for (unsigned by_reset = 0; by_reset < 2; by_reset++) {
        struct hil_board *board = run_image(46, 0, 0);
        assert_string_equal(hil_board_failure_reason(board), "");
        if (by_reset) {
            memcpy(board->core.memory->sram + 4u * (BENCH_CONTROL + 1u), &one, sizeof one);
            bench_run(board, 21 * HIL_PS_PER_MS);
            hil_board_reset(board);
        } else {
            bench_control(board, 1, one);
        }
        assert_int_equal(hil_board_run_until(board, 41 * HIL_PS_PER_MS), MR_HALTED);
        assert_non_null(strstr(hil_board_failure_reason(board), "rule FLOATING: "));
        hil_board_destroy(board);
    }
}

/* SCK of 164 kHz: its last rise in a byte is half a period before the end, 512 cycles of 168 MHz.
 * Deselected sooner, the chip drops the byte; later than 3 ns behind it, the byte is good. Between
 * there is one cycle. */
TEST(the_last_clock_is_held_for_3_ns)
{
    unsigned stopped = 0, judged = 0, dropped = 0;
    for (uint32_t rounds = 3820; rounds < 3850; rounds++) {
        struct hil_board *board = run_image(4, rounds, 0);
        bool is_stopped = strncmp(hil_board_failure_reason(board),
                                  "rule CLOCK_TO_DESELECT: ", 24) == 0;
        uint64_t n = board->state.mcu.rules.tally[HIL_RULE_CLOCK_TO_DESELECT].measurement_count;
        stopped += is_stopped;
        judged += !is_stopped && n == 2; /* this one, and the status read behind it */
        dropped += !is_stopped && n == 1;
        hil_board_destroy(board);
    }
    print_message("# deselected in steps of 2 cycles: %u dropped, %u stopped, %u in time\n",
                  dropped, stopped, judged);
    assert_true(dropped > 0 && judged > 0);
    assert_in_range(stopped, 0, 1);
}

static double ten_kilohm(const void *context, int source)
{
    (void)context;
    (void)source;
    return 10000.0;
}

/* The data sheet's equation with its own numbers, worked out by hand: 3 clocks of 30 MHz cannot do
 * even 0 Ohm, and what the firmware uses, 112 of 21 MHz, takes 130 kOhm. */
TEST(a_converter_samples_long_enough_for_its_source)
{
    assert_near(hil_adc_max_source_ohm(3, 8e6), 2.5 / (8e6 * 4e-12 * 9.70406) - 6000.0, 0.5);
    assert_near(hil_adc_max_source_ohm(112, 21e6), 130786.0, 1.0);
    assert_true(hil_adc_max_source_ohm(3, 30e6) < 0.0);
    struct hil_board *board = run_image(50, 0, 0);
    assert_int_equal(board->state.mcu.rules.tally[HIL_RULE_SAMPLING].measurement_count, 1);
    hil_board_destroy(board);

    struct hil_options options;
    hil_options_default(&options);
    board = bench_board("rules", &options);
    board->mcu.adc.analogue.source_ohm = ten_kilohm;
    bench_control(board, 0, 50);
    assert_int_equal(hil_board_run_until(board, 20 * HIL_PS_PER_MS), MR_HALTED);
    print_message("# %s\n", hil_board_failure_reason(board));
    assert_non_null(
        strstr(hil_board_failure_reason(board),
               "rule SAMPLING: a converter samples too briefly for the resistance of its source: "
               "the source at input 0 of ADC1 has 10000 Ohm, but sampling for 3 clocks of 8.0 MHz "
               "allows only 2051 Ohm"));
    hil_board_destroy(board);

    board = bench_board("rules", NULL);
    bench_control(board, 0, 50);
    bench_control(board, 3, 1);
    assert_int_equal(hil_board_run_until(board, 20 * HIL_PS_PER_MS), MR_HALTED);
    assert_non_null(strstr(hil_board_failure_reason(board), "rule CONVERTER_ON: "));
    hil_board_destroy(board);
}

/* 3 clocks of 2 MHz take 26 kOhm, of 8 MHz 2: what was right at the first conversion is not when a
 * prescaler of 4 is gone, of APB2 or of HCLK, and a timer starts the next: no register of the
 * converter is written in between. */
TEST(a_faster_clock_is_another_window)
{
    static const uint32_t by_4[] = {5u << 13, 9u << 4};
    for (unsigned i = 0; i < 2; i++) {
        struct hil_board *board = bench_board("rules", NULL);
        board->mcu.adc.analogue.source_ohm = ten_kilohm;
        bench_control(board, 0, 50);
        bench_control(board, 2, by_4[i]);
        bench_run(board, 20 * HIL_PS_PER_MS);
        assert_int_equal(bench_result(board, 0), 1);
        board->state.mcu.adc[0].cr2 |= 1u << 28; /* EXTEN: rising edges of TIM1_CH1 */
        hil_adc_trigger(&board->mcu.adc, 0, true, hil_now_cycle(&board->core));
        assert_int_equal(hil_board_run_until(board, 21 * HIL_PS_PER_MS), MR_HALTED);
        assert_non_null(
            strstr(hil_board_failure_reason(board), "3 clocks of 8.0 MHz allows only 2051"));
        assert_int_equal(board->state.mcu.rules.tally[HIL_RULE_SAMPLING].measurement_count, 2);
        hil_board_destroy(board);
    }
}

TEST(a_rule_that_only_counts_lets_it_go_on)
{
    struct hil_board *board = run_image(1, 0, COUNTED(SELECT_HIGH));
    assert_int_equal(bench_result(board, 0), 1);
    assert_int_equal(board->state.mcu.rules.tally[HIL_RULE_SELECT_HIGH].violation_count, 1);
    uint64_t times;
    assert_int_equal(hil_rules_count_violated(&board->mcu.rules, &times), 1);
    assert_int_equal(times, 1);
    assert_near(board->state.mcu.rules.tally[HIL_RULE_SELECT_HIGH].worst_ns, 1e9 / 168e6 - 4.0,
                0.01);
    hil_board_destroy(board);
}

/* --- nothing plugged in --- */

/* A board on the desk: TIM2 captures edges of PA15, and no one-shot is there. */
TEST(a_bare_board_is_not_driven_by_noise)
{
    struct hil_options options = ear_options();
    options.has_no_rig = true;
    struct ear *ear = ear_open(&options, 0);
    ear_until(ear, 2.0);
    assert_int_equal(hil_board_pin_level(ear->board, 0, 15), 1);
    assert_int_equal(tally(ear, HIL_RULE_FLOATING)->violation_count, 0);
    assert_true(ear->heard[EAR_CAN][MR_ID_HEALTH] > 10);
    ear_close(ear);
}

/* --- what is pulled outside --- */

/* What the pins of a board promise: "external pull-up". */
struct promise {
    unsigned port, pin;
    const char *text;
};

#define FUNCTION(port, pin, number, signal, pull, SIGNAL, text) {(#port)[0] - 'A', pin, text},
#define OUTPUT(port, pin, first, pull, SIGNAL, text)            {(#port)[0] - 'A', pin, text},
#define INPUT(port, pin, pull, SIGNAL, text)                    {(#port)[0] - 'A', pin, text},
static const struct promise zg[] = {
#define BOARD_FILE "firmware/boards/zg.def"
#include "firmware/boards/pins.def"
};
#define FUNCTION(port, pin, number, signal, pull, SIGNAL, text) {(#port)[0] - 'A', pin, text},
#define OUTPUT(port, pin, first, pull, SIGNAL, text)            {(#port)[0] - 'A', pin, text},
#define INPUT(port, pin, pull, SIGNAL, text)                    {(#port)[0] - 'A', pin, text},
static const struct promise discovery[] = {
#undef BOARD_FILE
#define BOARD_FILE "firmware/boards/discovery.def"
#include "firmware/boards/pins.def"
};
#define FUNCTION(port, pin, number, signal, pull, SIGNAL, text) {(#port)[0] - 'A', pin, text},
#define OUTPUT(port, pin, first, pull, SIGNAL, text)            {(#port)[0] - 'A', pin, text},
#define INPUT(port, pin, pull, SIGNAL, text)                    {(#port)[0] - 'A', pin, text},
static const struct promise nucleo446[] = {
#undef BOARD_FILE
#define BOARD_FILE "firmware/boards/nucleo446.def"
#include "firmware/boards/pins.def"
};

/* The list of resistors of each board, which the emulator has on its own, is what its pins say. */
TEST(resistors_are_where_the_pins_say)
{
#define BOARD(name)                               \
    {                                             \
#name, name, sizeof name / sizeof name[0] \
    }
    static const struct {
        const char *name;
        const struct promise *row;
        size_t rows;
    } boards[] = {BOARD(zg), BOARD(discovery), BOARD(nucleo446)};
    for (size_t b = 0; b < sizeof boards / sizeof boards[0]; b++) {
        uint16_t up[HIL_GPIO_PORTS] = {0}, down[HIL_GPIO_PORTS] = {0};
        struct hil_options options;
        hil_options_default(&options);
        options.type = hil_board_type_by_name(boards[b].name);
        struct hil_board *board = hil_board_create(&options);
        for (size_t i = 0; i < boards[b].rows; i++) {
            const struct promise *row = &boards[b].row[i];
            uint16_t bit = (uint16_t)(1u << row->pin);
            if (strstr(row->text, "external pull-up"))
                up[row->port] |= bit;
            if (strstr(row->text, "external pull-down"))
                down[row->port] |= bit;
        }
        assert_memory_equal(board->mcu.gpio.pull_up_pins, up, sizeof up);
        assert_memory_equal(board->mcu.gpio.pull_down_pins, down, sizeof down);
        hil_board_destroy(board);
    }
}
