/* The core under a debugger: it does the same as without, holds where asked, shows and takes
 * registers and memory. */
#include "hil/core/bus.h"
#include "hil/core/elf.h"
#include "hil/debug/debug.h"
#include "tests/hil/bench.h"
#include "tests/hil/snapshot.h"

#define SRAM       0x20000000u
#define SRAM_BYTES 0x20000u
#define FIRMWARE   "build/firmware/matrig.elf"

static struct hil_board *firmware_board(void)
{
    struct hil_options options;
    hil_options_default(&options);
    struct hil_board *board = hil_board_create(&options);
    if (hil_board_load_elf(board, FIRMWARE) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(board));
    return board;
}

static void assert_same(struct hil_board *a, struct hil_board *b)
{
    static uint8_t of_a[SRAM_BYTES], of_b[SRAM_BYTES];
    assert_int_equal(hil_now_cycle(&a->core), hil_now_cycle(&b->core));
    assert_memory_equal(hil_board_counters(a), hil_board_counters(b), sizeof(struct hil_counters));
    hil_board_peek(a, SRAM, of_a, sizeof of_a);
    hil_board_peek(b, SRAM, of_b, sizeof of_b);
    assert_memory_equal(of_a, of_b, sizeof of_a);
    for (unsigned i = 0; i <= 17; i++)
        assert_int_equal(hil_cpu_register(&a->core, i), hil_cpu_register(&b->core, i));
}

/* Single steps all the way: as the board runs alone, to the last bit. */
static void stepped_equals_run(struct hil_board *alone, struct hil_board *stepped, uint64_t from_ps,
                               uint64_t to_ps, unsigned at_least)
{
    struct hil_debug debug;
    unsigned steps = 0;
    bench_run(alone, from_ps);
    bench_run(stepped, from_ps);
    hil_debug_attach(stepped, &debug);
    for (; hil_board_now_ps(stepped) < to_ps; steps++) {
        hil_debug_step(stepped);
        bench_run(stepped, to_ps);
    }
    assert_in_range(steps, at_least, UINT32_MAX);
    hil_debug_detach(stepped);
    bench_run(stepped, to_ps + 5 * HIL_PS_PER_MS); /* a block it was in is finished */
    bench_run(alone, to_ps + 5 * HIL_PS_PER_MS);
    assert_same(alone, stepped);
}

TEST(test_steps_change_nothing)
{
    static const char *const images[] = {"core", "serial", "canbus"};
    for (unsigned i = 0; i < sizeof images / sizeof images[0]; i++) {
        struct hil_board *alone = bench_board(images[i], NULL),
                         *stepped = bench_board(images[i], NULL);
        stepped_equals_run(alone, stepped, 0, HIL_PS_PER_MS / 4, 500);
        hil_board_destroy(alone);
        hil_board_destroy(stepped);
    }
    /* a loop that is always awake: an interrupt shows where its blocks end, also those it was
     * stepped through before */
    struct hil_board *alone = bench_board("hang_loop", NULL),
                     *stepped = bench_board("hang_loop", NULL);
    stepped_equals_run(alone, stepped, 11 * HIL_PS_PER_MS, 12 * HIL_PS_PER_MS, 5000);
    hil_board_destroy(alone);
    hil_board_destroy(stepped);
    alone = firmware_board();
    stepped = firmware_board();
    stepped_equals_run(alone, stepped, 20 * HIL_PS_PER_MS, 23 * HIL_PS_PER_MS, 10000);
    hil_board_destroy(alone);
    hil_board_destroy(stepped);
}

static uint32_t function_at(const char *name)
{
    struct mr_symbols symbols;
    char error[256];
    assert_int_equal(hil_symbols_read(&symbols, FIRMWARE, error, sizeof error), MR_OK);
    const struct mr_symbol *symbol = mr_symbols_by_name(&symbols, name);
    assert_non_null(symbol);
    uint32_t address = symbol->address;
    hil_symbols_free(&symbols);
    return address;
}

/* Breakpoints at every other halfword of a function that each scan calls, most of them inside
 * blocks: it holds at each instruction that it comes to, and the run stays what it is. */
TEST(test_breaks_change_nothing)
{
    const uint64_t end_ps = 40 * HIL_PS_PER_MS;
    struct hil_debug debug;
    struct hil_board *alone = firmware_board(), *broken = firmware_board();
    uint32_t address = function_at("mr_block_from_scans");
    unsigned held = 0, at_first = 0;
    hil_debug_attach(broken, &debug);
    for (uint32_t i = 0; i < HIL_BREAKPOINTS_MAX; i++)
        assert_int_equal(hil_debug_set_breakpoint(broken, address + 2u * i, true), MR_OK);
    assert_int_equal(hil_debug_set_breakpoint(broken, address + 4u, true),
                     MR_OK); /* is there already */
    assert_int_equal(hil_debug_set_breakpoint(broken, address + 2u * HIL_BREAKPOINTS_MAX, true),
                     MR_FULL);
    hil_debug_run(broken);
    for (; hil_board_now_ps(broken) < end_ps; held++) {
        bench_run(broken, end_ps);
        if (!hil_debug_is_holding(broken))
            break;
        assert_int_equal(debug.hold_reason, HIL_HOLD_BREAKPOINT);
        assert_in_range(hil_cpu_register(&broken->core, 15) & ~1u, address,
                        address + 2u * HIL_BREAKPOINTS_MAX);
        at_first += (hil_cpu_register(&broken->core, 15) & ~1u) == address;
        hil_debug_run(broken);
    }
    assert_in_range(held, 1000, 1000000);
    bench_run(alone, end_ps);
    /* one block of eight scans each */
    assert_int_equal(at_first, hil_board_counters(alone)->adc_scans[0] / 8);
    assert_same(alone, broken);
    hil_debug_detach(broken);
    hil_board_destroy(alone);
    hil_board_destroy(broken);
}

/* Watched: the word at the top of the stack region that main's frame uses is written and read; the
 * instruction told is one that stores there. */
TEST(test_watchpoints)
{
    struct hil_debug debug;
    struct hil_board *board = firmware_board();
    uint32_t before, after, address = 0;
    bench_run(board, 20 * HIL_PS_PER_MS);
    uint32_t dma_start = 0, dma_end = 0;
    assert_int_equal(hil_elf_find_symbol("build/firmware/matrig.elf", "dma_start", &dma_start),
                     MR_OK);
    assert_int_equal(hil_elf_find_symbol("build/firmware/matrig.elf", "dma_end", &dma_end), MR_OK);
    /* a word that changes: the first one of RAM that differs a millisecond later */
    struct hil_board *later = snapshot_fork(board);
    bench_run(later, 22 * HIL_PS_PER_MS);
    for (uint32_t at = SRAM + 0x1068u; !address && at < SRAM + 0x10000u; at += 4) {
        bool by_dma = at >= dma_start && at < dma_end; /* which watchpoints do not see */
        if (!by_dma && bench_word(board, at) != bench_word(later, at))
            address = at;
    }
    assert_int_not_equal(address, 0);
    hil_debug_attach(board, &debug);
    assert_int_equal(hil_debug_set_watchpoint(board, HIL_WATCH_WRITE, address, 4, true), MR_OK);
    before = bench_word(board, address);
    do {
        hil_debug_run(board);
        bench_run(board, 22 * HIL_PS_PER_MS);
        after = bench_word(board, address);
    } while (hil_debug_is_holding(board) && after == before);
    assert_int_equal(debug.hold_reason, HIL_HOLD_WATCHPOINT);
    assert_in_range(debug.hit_address, address, address + 3);
    assert_in_range(debug.hit_pc, 0x08010000u, 0x08040000u);
    assert_int_not_equal(after, before);
    assert_int_equal(hil_debug_set_watchpoint(board, HIL_WATCH_WRITE, address, 4, false), MR_OK);
    for (unsigned i = 0; i < HIL_WATCHPOINTS_MAX; i++)
        assert_int_equal(hil_debug_set_watchpoint(board, HIL_WATCH_READ, SRAM + 4u * i, 4, true),
                         MR_OK);
    assert_int_equal(hil_debug_set_watchpoint(board, HIL_WATCH_READ, SRAM + 0x100u, 4, true),
                     MR_FULL);
    hil_debug_detach(board);
    bench_run(board, 30 * HIL_PS_PER_MS);
    bench_run(later, 30 * HIL_PS_PER_MS);
    assert_same(board, later);
    hil_board_destroy(board);
    hil_board_destroy(later);
}

/* Blocks whose registers, when an access is reported, fit another instruction of the block too.
 * Each is run with r0 at a word and r1 at another, which is accessed at `offset`. */
static const struct place {
    uint16_t code[8];
    uint32_t offset;
    enum hil_watch_kind kind;
} places[] = {
    /* str r2, [r0]; mov r0, r1; str r2, [r0]; b . */
    {{0x6002, 0x4608, 0x6002, 0xe7fe}, 4, HIL_WATCH_WRITE},
    /* ldr r3, [r0]; mov r0, r1; ldr r3, [r0], #4; b . */
    {{0x6803, 0x4608, 0xf850, 0x3b04, 0xe7fe}, 4, HIL_WATCH_READ},
    /* cmp r0, r0; it ne; strne r2, [r1]; str r2, [r1]; b . */
    {{0x4280, 0xbf18, 0x600a, 0x600a, 0xe7fe}, 6, HIL_WATCH_WRITE},
    /* cmp r0, r0; ite ne; ldrne r3, [r1]; ldreq r3, [r1]; b . */
    {{0x4280, 0xbf14, 0x680b, 0x680b, 0xe7fe}, 6, HIL_WATCH_READ},
};

static void run_place(struct hil_board *board, struct hil_debug *debug, const struct place *place,
                      uint32_t other)
{
    hil_debug_attach(board, debug);
    assert_int_equal(hil_board_poke(board, 0x20010000u, place->code, sizeof place->code), MR_OK);
    hil_debug_write_register(board, 0, 0x20011000u);
    hil_debug_write_register(board, 1, other);
    hil_debug_write_register(board, HIL_REG_PC, 0x20010000u);
}

TEST(test_watchpoints_name_the_instruction)
{
    for (unsigned i = 0; i < sizeof places / sizeof places[0]; i++) {
        struct hil_debug debug;
        struct hil_board *board = firmware_board();
        run_place(board, &debug, &places[i], 0x20011100u);
        assert_int_equal(hil_debug_set_watchpoint(board, places[i].kind, 0x20011100u, 4, true),
                         MR_OK);
        hil_debug_run(board);
        bench_run(board, HIL_PS_PER_MS);
        assert_int_equal(debug.hold_reason, HIL_HOLD_WATCHPOINT);
        assert_int_equal(debug.hit_address, 0x20011100u);
        assert_int_equal(debug.hit_pc, 0x20010000u + places[i].offset);
        /* the next one, which has not run */
        assert_int_equal(hil_debug_read_register(board, HIL_REG_PC),
                         debug.hit_pc + (i == 1 ? 4u : 2u));
        hil_board_destroy(board);
    }
}

/* Two stores of a block to one word: it holds behind each, with its value. */
TEST(test_watchpoints_hold_behind_each_access)
{
    /* str r0, [r1]; str r2, [r1]; adds r0, #1; b . */
    static const struct place place = {{0x6008, 0x600a, 0x3001, 0xe7fe}, 0, HIL_WATCH_WRITE};
    struct hil_debug debug;
    struct hil_board *board = firmware_board();
    run_place(board, &debug, &place, 0x20011100u);
    hil_debug_write_register(board, 2, 5);
    assert_int_equal(hil_debug_set_watchpoint(board, HIL_WATCH_WRITE, 0x20011100u, 4, true), MR_OK);
    for (unsigned i = 0; i < 2; i++) {
        hil_debug_run(board);
        bench_run(board, HIL_PS_PER_MS);
        assert_int_equal(debug.hold_reason, HIL_HOLD_WATCHPOINT);
        assert_int_equal(bench_word(board, 0x20011100u), i ? 5 : 0x20011000u);
        assert_int_equal(hil_debug_read_register(board, HIL_REG_PC), 0x20010002u + 2u * i);
        assert_int_equal(hil_debug_read_register(board, 0), 0x20011000u);
    }
    hil_board_destroy(board);
}

/* A watched access is made once: each store to the transmitter is a byte. */
TEST(test_watchpoints_of_a_peripheral_change_nothing)
{
    const uint64_t end_ps = HIL_PS_PER_MS;
    struct hil_debug debug;
    const char *image = "../../conformance/images/core";
    struct hil_board *alone = bench_board(image, NULL), *watched = bench_board(image, NULL);
    unsigned held = 0;
    hil_debug_attach(watched, &debug);
    /* SR and DR of USART1 */
    assert_int_equal(hil_debug_set_watchpoint(watched, HIL_WATCH_ACCESS, 0x40011000u, 8, true),
                     MR_OK);
    do {
        hil_debug_run(watched);
        bench_run(watched, end_ps);
    } while (hil_debug_is_holding(watched) && ++held);
    assert_in_range(held, 20, 100000);
    hil_debug_detach(watched);
    bench_run(watched, end_ps + HIL_PS_PER_MS);
    bench_run(alone, end_ps + HIL_PS_PER_MS);
    assert_in_range(hil_board_counters(alone)->serial_bytes_out, 100, 1000);
    assert_same(alone, watched);
    hil_board_destroy(alone);
    hil_board_destroy(watched);
}

/* The same where the access ends the run: RTC is not modelled. */
TEST(test_refusals_name_the_instruction)
{
    for (unsigned i = 0; i < sizeof places / sizeof places[0]; i++) {
        struct hil_debug debug;
        char pc[32];
        struct hil_board *board = firmware_board();
        run_place(board, &debug, &places[i], 0x40002800u);
        hil_debug_detach(board);
        assert_int_equal(hil_board_run_until(board, HIL_PS_PER_MS), MR_UNMODELLED);
        snprintf(pc, sizeof pc, "0x40002800, PC 0x%08x",
                 (unsigned)(0x20010000u + places[i].offset));
        if (!strstr(hil_board_failure_reason(board), pc))
            fail_msg("`%s` is not in the reason: %s", pc, hil_board_failure_reason(board));
        assert_int_equal(hil_cpu_register(&board->core, 15) & ~1u, 0x20010000u + places[i].offset);
        hil_board_destroy(board);
    }
}

/* Looking at a register that reading changes (TIM2's capture clears its flag, SysTick's its own)
 * changes nothing. */
TEST(test_looking_changes_nothing)
{
    uint8_t bytes[4];
    struct hil_debug debug;
    struct hil_board *board = firmware_board();
    bench_run(board, 30 * HIL_PS_PER_MS + 9 * HIL_PS_PER_MS / 10);
    struct hil_board *alone = snapshot_fork(board);
    hil_debug_attach(board, &debug);
    assert_int_equal(hil_debug_read(board, 0xe000e010u, bytes, 4), MR_OK);
    uint8_t first = bytes[2];
    assert_int_equal(hil_debug_read(board, 0xe000e010u, bytes, 4), MR_OK);
    assert_int_equal(bytes[2], first);
    assert_int_equal(first & 1u, 1); /* COUNTFLAG: SysTick has come to 0 since start */
    assert_int_equal(hil_debug_read(board, 0x40000034u, bytes, 4), MR_OK);
    assert_int_equal(hil_debug_read(board, 0x30000000u, bytes, 4), MR_UNKNOWN);
    assert_int_equal(hil_debug_read(board, 0x400fff00u, bytes, 4), MR_UNKNOWN);
    assert_int_equal(hil_debug_write(board, 0x400fff00u, bytes, 4), MR_UNKNOWN);
    hil_debug_detach(board);
    bench_run(board, 40 * HIL_PS_PER_MS);
    bench_run(alone, 40 * HIL_PS_PER_MS);
    assert_same(board, alone);
    hil_board_destroy(board);
    hil_board_destroy(alone);
}

/* PC set elsewhere leaves the block: time counts what was run, and the code there runs. */
TEST(test_registers)
{
    struct hil_debug debug;
    struct hil_board *board = firmware_board();
    uint32_t address = function_at("mr_block_from_scans"), other = function_at("mr_crc32");
    hil_debug_attach(board, &debug);
    assert_int_equal(hil_debug_set_breakpoint(board, address + 4u, true), MR_OK);
    hil_debug_run(board);
    bench_run(board, 20 * HIL_PS_PER_MS);
    assert_int_equal(hil_debug_read_register(board, HIL_REG_PC), address + 4u);
    uint64_t instructions = hil_board_counters(board)->instructions;
    for (unsigned i = 0; i < HIL_REG_COUNT; i++) {
        if (i == HIL_REG_PC || (i >= HIL_REG_XPSR && i < HIL_REG_D0) || i == 13)
            continue;
        uint64_t value = i >= HIL_REG_D0 && i < HIL_REG_FPSCR ? 0x123456789abcdef0u + i
                                                              : 0x10000000u * (i % 8u);
        hil_debug_write_register(board, i, value);
        assert_int_equal(hil_debug_read_register(board, i), value);
    }
    hil_debug_write_register(board, HIL_REG_XPSR, 0xa0000000u);
    assert_int_equal(hil_debug_read_register(board, HIL_REG_XPSR) >> 27, 0xa0000000u >> 27);
    /* still in the handler */
    assert_int_equal(hil_debug_read_register(board, HIL_REG_XPSR) & 0x1ffu, 16 + 60);
    hil_debug_write_register(board, HIL_REG_PC, other);
    assert_in_range(hil_board_counters(board)->instructions - instructions, 1, 2);
    assert_int_equal(hil_debug_set_breakpoint(board, other + 2u, true), MR_OK);
    hil_debug_run(board);
    bench_run(board, 21 * HIL_PS_PER_MS);
    assert_int_equal(hil_debug_read_register(board, HIL_REG_PC) & ~3u, (other + 2u) & ~3u);
    hil_board_destroy(board);
}

#define APB1_FZ  0xe0042008u
#define TIM2_CNT 0x40000024u
#define BOTH     5u /* TIM2 and TIM4 */

/* While the core is halted, 3.5 ms: the timers stand still as long as DBGMCU says so, and with them
 * the converters that they trigger; else they go on. A watchdog that does not stop resets. */
TEST(test_time_may_go_on)
{
    struct hil_board *board = firmware_board();
    struct hil_debug debug;
    const struct hil_counters *counters = hil_board_counters(board);
    bench_run(board, HIL_PS_PER_S / 2);
    hil_debug_attach(board, &debug);
    for (uint32_t stops = BOTH;; stops = 0) {
        uint32_t fz = hil_bus_read(&board->core, APB1_FZ, 4);
        hil_bus_write(&board->core, APB1_FZ, 4, (fz & ~BOTH) | stops);
        uint64_t scans = counters->adc_scans[0], instructions = counters->instructions,
                 from_ps = hil_board_now_ps(board);
        uint32_t count = hil_bus_read(&board->core, TIM2_CNT, 4);
        hil_debug_advance(board, from_ps + 7 * HIL_PS_PER_MS / 2);
        assert_near((double)(hil_board_now_ps(board) - from_ps) * 1e-9, 3.5, 1e-4);
        assert_int_equal(counters->instructions, instructions);
        assert_near(hil_bus_read(&board->core, TIM2_CNT, 4) - count, stops ? 0 : 294000, 1);
        assert_near(counters->adc_scans[0] - scans, stops ? 0 : 28, 1); /* one may be under way */
        if (!stops)
            break;
        hil_debug_run(board); /* the next trigger comes, where it was left */
        bench_run(board, hil_board_now_ps(board) + 10 * HIL_PS_PER_MS);
        assert_near(counters->adc_scans[0] - scans, 80, 1);
        hil_debug_hold(board, HIL_HOLD_REQUESTED);
    }
    assert_int_equal(counters->resets, 0);
    hil_debug_advance(board, hil_board_now_ps(board) + 2 * HIL_PS_PER_S); /* the watchdog stops */
    assert_false(board->core.reset.is_requested);
    hil_bus_write(&board->core, APB1_FZ, 4, 0);
    hil_debug_advance(board, hil_board_now_ps(board) + 2 * HIL_PS_PER_S);
    assert_true(board->core.reset.is_requested);
    hil_debug_detach(board);
    bench_run(board, hil_board_now_ps(board) + HIL_PS_PER_MS);
    assert_int_equal(counters->watchdog_resets, 1);
    hil_board_destroy(board);
}

/* BKPT holds under a debugger, and going on steps over it; without one it is a HardFault. */
TEST(test_bkpt)
{
    /* movs r0, #1; bkpt #42; adds r0, #4; b . */
    static const uint16_t code[] = {0x2001, 0xbe2a, 0x3004, 0xe7fe};
    struct hil_debug debug, passing;
    struct hil_board *board = firmware_board(), *alone = firmware_board();
    for (unsigned i = 0; i < 2; i++) {
        struct hil_board *b = i ? alone : board;
        assert_int_equal(hil_board_poke(b, 0x20010000u, code, sizeof code), MR_OK);
        hil_debug_attach(b, i ? &passing : &debug);
        hil_debug_write_register(b, HIL_REG_PC, 0x20010000u);
        if (i)
            hil_debug_detach(b);
        else
            hil_debug_run(b);
        bench_run(b, HIL_PS_PER_MS);
    }
    assert_int_equal(hil_board_counters(alone)->fault_exceptions, 1);
    assert_int_equal(debug.hold_reason, HIL_HOLD_BKPT);
    assert_int_equal(hil_board_counters(board)->fault_exceptions, 0);
    assert_int_equal(hil_debug_read_register(board, HIL_REG_PC), 0x20010002u);
    assert_int_equal(hil_debug_read_register(board, 0), 1);
    hil_debug_run(board);
    bench_run(board, 2 * HIL_PS_PER_MS);
    assert_false(hil_debug_is_holding(board));
    assert_int_equal(hil_debug_read_register(board, 0), 5);
    hil_debug_detach(board);
    hil_board_destroy(board);
    hil_board_destroy(alone);
}
