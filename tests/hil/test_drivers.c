/* The firmware's drivers on the emulated board: what each line of them is for, shown by what
 * happens without it. The faults below are put straight into the peripherals' state, as a
 * disturbance would. */
#include <math.h>

#include "hil/core/elf.h"
#include "hil/core/nvic.h"
#include "tests/hil/ear.h"
#include "tests/hil/snapshot.h"

#define TICKS_PER_S     84e6
#define TRIGGER_TICK    2352u
#define TICKS_PER_BLOCK 84000u
#define BLOCK_S         1e-3

/* One reversal of the excitation missed: from then on plus is minus. The board says so. */
TEST(a_missed_reversal_is_told)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.5);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), 0);
    struct hil_tim *tim4 = &ear->board->state.mcu.tim[HIL_TIM4];
    tim4->reference_level[0] = !tim4->reference_level[0];
    tim4->reference_level[1] = !tim4->reference_level[1];
    hil_gpio_notify_listeners(&ear->board->mcu.gpio, hil_now_cycle(&ear->board->core));
    ear_until(ear, 0.8);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(POLARITY));
    assert_true(ear->fault[MR_FAULT_POLARITY].count > 100); /* every block since */
    ear_close(ear);
}

/* A code of ADC3 lost: all transducers after it would be taken for their neighbours. Not one such
 * block is given out. */
TEST(a_lost_code_shifts_no_channel)
{
    struct ear *ear = ear_open(NULL, 0);
    for (unsigned i = 0; i < HIL_RUN_TRANSDUCERS; i++)
        ear->run.samples[0][i] = 10000 * ((int32_t)i + 1); /* 0.1 in, 0.2 in, ... */
    ear_until(ear, 0.3);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1);
    ear_until(ear, 0.5);
    struct mr_block good = ear->block;
    unsigned before = ear->blocks;
    assert_true(before > 150);
    struct hil_dma_stream *stream = &ear->board->state.mcu.dma[1].stream[1];
    assert_int_equal(stream->cr >> 25, 2); /* ADC3's */
    stream->ndtr = stream->ndtr > 1 ? stream->ndtr - 1 : 64;
    for (double t_s = 0.5; t_s < 1.2; t_s += BLOCK_S) {
        ear_until(ear, t_s + BLOCK_S);
        for (unsigned i = 0; i < HIL_RUN_TRANSDUCERS; i++) {
            assert_near(ear->block.forward_sum[i], good.forward_sum[i], 8);
            assert_near(ear->block.reversed_sum[i], good.reversed_sum[i], 8);
        }
    }
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(SCAN_OVERRUN));
    assert_int_equal(ear->fault[MR_FAULT_SCAN_OVERRUN].detail, 3);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(SCAN_STALL)); /* started again */
    assert_true(ear->blocks > before + 500);
    ear_close(ear);
}

static bool on_both_links(uint16_t id)
{
    const struct mr_message_info *info = mr_message_find(id);
    return info && info->direction == MR_DIRECTION_BOTH;
}

static void check_order_of_frames(struct ear *ear, double from_s)
{
    ear_until(ear, from_s);
    ear->listens = true;
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1); /* a burst of the whole configuration */
    ear_until(ear, from_s + 0.5);
    ear->listens = false;
    unsigned n = 0;
    unsigned from = 0; /* serial and CAN may stand a message apart at the beginning */
    while (from < 4 && memcmp(&ear->said[EAR_SERIAL][from], &ear->said[EAR_CAN][0],
                              sizeof(struct ear_said)) != 0)
        from++;
    for (unsigned c = 0, s = from; c < ear->said_count[EAR_CAN]; c++) {
        const struct ear_said *can = &ear->said[EAR_CAN][c];
        if (!on_both_links(can->id))
            continue;
        if (s == ear->said_count[EAR_SERIAL])
            break;
        const struct ear_said *serial = &ear->said[EAR_SERIAL][s++];
        if (can->id == MR_ID_CAN_HEALTH || can->id == MR_ID_SERIAL_HEALTH ||
            can->id == MR_ID_MESSAGE_COUNT) {
            assert_int_equal(serial->id, can->id);
            continue;
        }
        if (can->id != serial->id ||
            memcmp(can->payload, serial->payload, MR_MESSAGE_BYTES_MAX) != 0)
            fail_msg("message %u: 0x%03x on CAN, 0x%03x on serial", n, can->id, serial->id);
        n++;
    }
    assert_true(n > 100);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* More frames wait than there are mailboxes: they still leave as they were queued, for can_health
 * counts on it. */
TEST(frames_leave_in_their_order)
{
    check_order_of_frames(ear_open(NULL, 0), 0.3001);
}

/* The recovery from bus-off writes the mode again. */
TEST(frames_leave_in_their_order_after_bus_off)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.1 bus short\nat 0.3 bus connect");
    ear_until(ear, 0.7);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_BUS_OFF));
    check_order_of_frames(ear, 0.7001);
}

/* Only commands, proofs and words of a configuration pass the filter: of all 2048 identifiers with
 * every other frame format, three. */
TEST(only_commands_pass_the_filter)
{
    struct ear *ear = ear_open(NULL, 0);
    double t_s = 0.2;
    ear_until(ear, t_s);
    for (uint32_t id = 0; id < 2048; id++) {
        for (unsigned form = 0; form < 3; form++) { /* data, remote, extended */
            struct hil_can_frame frame = {
                .id = form == 2 ? id << 18 : id, .is_extended = form == 2, .is_remote = form == 1};
            while (hil_can_inject(&ear->board->mcu.can, &frame) == MR_FULL)
                ear_until(ear, t_s += 2e-3);
        }
    }
    ear_until(ear, t_s += 0.1);
    const struct hil_counters *counters = hil_board_counters(ear->board);
    assert_int_equal(counters->can_frames_in, 3 * 2048);
    assert_int_equal(counters->can_frames_filtered, 3 * 2048 - 3);
    ear_close(ear);
}

/* Wires touch: bus-off. Apart again: within 0.12 s (a try each 0.1 s) the board is back, says how
 * long it was away, and its count of what it sent is right: what waited for more than 0.1 s, and
 * what came later, was dropped and counted. */
TEST(bus_off_is_left_again)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 bus short\nat 0.9 bus connect");
    ear_until(ear, 0.5);
    unsigned before = ear->can_frames;
    ear_until(ear, 0.9);
    assert_int_equal(ear->can_frames, before);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_BUS_OFF));
    ear_until(ear, 1.02);
    assert_true(ear->can_frames > before);
    ear_until(ear, 1.5);
    assert_true(ear_faults(ear, EAR_CAN) & EAR_BIT(CAN_BUS_OFF)); /* told on CAN afterwards */
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* The bus is held dominant from power on: the controller cannot leave initialisation. The firmware
 * does not wait for it, and takes part when the bus is free. */
TEST(a_dominant_bus_does_not_hold_the_start)
{
    struct hil_options options = ear_options();
    options.can_bus = HIL_CAN_DOMINANT;
    struct ear *ear = ear_open(&options, 0);
    ear_until(ear, 0.05);
    assert_true(ear->heard[EAR_SERIAL][MR_ID_HELLO] > 0);
    ear_until(ear, 0.4);
    assert_int_equal(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_MISSING), 0);
    assert_true(ear->board->state.mcu.can.msr & 1u); /* INAK is still set */
    assert_int_equal(ear->can_frames, 0);
    hil_can_set_bus(&ear->board->mcu.can, HIL_CAN_CONNECTED);
    ear_until(ear, 0.41);
    assert_true(ear->can_frames > 0);
    ear_until(ear, 0.8);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* No crystal, and the internal oscillator 0.9 % fast: everything 0.9 % fast and no more, serial
 * understood, CAN silent. */
TEST(without_a_crystal_the_internal_oscillator_serves)
{
    struct hil_options options = ear_options();
    options.hse_hz = 0;
    options.hsi_error_ppm = 9000;
    struct ear *ear = ear_open(&options, 0);
    ear_until(ear, 1.0);
    assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source, 1);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CLOCK_FALLBACK));
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 169512000);
    assert_int_equal(ear->can_frames, 0);
    assert_int_equal(ear->serial_refused_count, 0);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_SILENT));
    struct mr_clock from, to;
    mr_clock_get(&from, ear->last[EAR_SERIAL][MR_ID_CLOCK], MR_MESSAGE_BYTES_MAX);
    ear_until(ear, 2.0);
    mr_clock_get(&to, ear->last[EAR_SERIAL][MR_ID_CLOCK], MR_MESSAGE_BYTES_MAX);
    /* messages come every 100 blocks: 991 or 1009 ms */
    assert_int_equal(to.block - from.block, 1000);
    ear_close(ear);
}

static void poke_code(struct ear *ear, const char *symbol, uint16_t code, uint16_t *before)
{
    uint32_t address = 0;
    assert_int_equal(hil_elf_find_symbol(EAR_ELF, symbol, &address), MR_OK);
    if (before)
        assert_int_equal(hil_board_peek(ear->board, address, before, 2), MR_OK);
    assert_int_equal(hil_board_poke(ear->board, address, &code, 2), MR_OK);
}

/* The main loop hangs (branch to itself) while interrupts go on: 500 periods of LSI / 32 after the
 * last feeding, at most a supervision tick before the hang, the watchdog resets; the next start
 * says so. */
TEST(a_hang_ends_in_a_reset)
{
    static const uint32_t lsi_hz[] = {17000, 32000, 47000};
    for (unsigned i = 0; i < COUNT_OF(lsi_hz); i++) {
        struct hil_options options = ear_options();
        uint16_t before;
        options.lsi_hz = lsi_hz[i];
        struct ear *ear = ear_open(&options, 0);
        ear_until(ear, 0.3);
        poke_code(ear, "app_poll", 0xe7fe, &before);
        double timeout_s = 501.0 * 32.0 / lsi_hz[i];
        ear_until(ear, 0.3 + timeout_s - 0.011);
        assert_int_equal(hil_board_counters(ear->board)->resets, 0);
        ear_until(ear, 0.3 + timeout_s + 0.001);
        assert_int_equal(hil_board_counters(ear->board)->watchdog_resets, 1);
        poke_code(ear, "app_poll", before, NULL);
        ear_until(ear, 0.3 + timeout_s + 0.4);
        assert_int_equal(hil_board_counters(ear->board)->resets, 1);
        assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause & 8u, 8u);
        assert_true(ear_faults(ear, EAR_CAN) & EAR_BIT(WATCHDOG_RESET));
        ear_close(ear);
    }
}

/* Physical time of scan 0's trigger, from the timer that everything runs by. */
static double scan_zero_s(const struct hil_board *board)
{
    const struct hil_tim *tim2 = &board->state.mcu.tim[HIL_TIM2];
    return (double)hil_clock_ps_at_cycle(&board->core.state.clock, tim2->base_cycle) * 1e-12 -
           tim2->base_count / TICKS_PER_S + TRIGGER_TICK / TICKS_PER_S;
}

/* The index that the board gives the newest block, and its tick, are those of its moment. */
static void assert_in_place(struct ear *ear, double zero_s)
{
    struct mr_clock clock;
    double now_s = (double)hil_board_now_ps(ear->board) * 1e-12;
    assert_int_equal(mr_clock_get(&clock, ear->last[EAR_SERIAL][MR_ID_CLOCK], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    assert_int_equal(clock.tick, TRIGGER_TICK + clock.block * TICKS_PER_BLOCK);
    /* the message is at most 100 blocks old, and was sent when its block was complete */
    double block_s = zero_s + (double)clock.block * BLOCK_S;
    assert_true(now_s - block_s < 0.104 && now_s - block_s > BLOCK_S);
    /* and the scans of a block lie within it: just before its first trigger the DMA stands at a
     * half */
    ear_until(ear, zero_s + (floor((now_s - zero_s) / BLOCK_S) + 2.0) * BLOCK_S - 5e-6);
    assert_int_equal(
        ear->board->state.mcu.dma[1].stream[4].ndtr % (MR_SCANS_PER_BLOCK * MR_ADC1_CHANNELS), 0);
    assert_false(ear->board->state.mcu.adc[HIL_ADC1].is_sequence_running);
}

/* A converter overruns and stops: blocks come again within 0.1 s, in their old places, also after
 * TIM2 has wrapped. */
static void stall(struct ear *ear, double at_s, double zero_s)
{
    ear_until(ear, at_s);
    uint16_t stalls = ear->fault[MR_FAULT_SCAN_STALL].count;
    struct hil_adc *adc = &ear->board->state.mcu.adc[HIL_ADC1];
    adc->sr |= 0x20u; /* OVR */
    adc->is_sequence_running = false;
    ear_until(ear, at_s + 0.35);
    assert_int_equal(ear->fault[MR_FAULT_SCAN_STALL].count, stalls + 1);
    assert_in_place(ear, zero_s);
}

/* Landing 5, so much later. Where the mat is does not matter here. */
static void delay_landing(struct hil_run *run, double by_s)
{
    uint64_t by_ps = (uint64_t)(by_s * 1e12);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run->switch_open_ps[i] += run->switch_open_ps[i] == HIL_RUN_NEVER ? 0 : by_ps;
    for (size_t i = 0; i < run->command_count; i++)
        run->commands[i].t_ps += by_ps;
}

/* The restart just after the wrap, where a difference of ticks taken the wrong way would be 51 s
 * wrong: in a second board that goes on from the first. */
static void stall_in_a_fork(const struct ear *ear, double zero_s)
{
    struct ear *other = malloc(sizeof *other);
    assert_non_null(other);
    *other = *ear;
    ear_attach(other, snapshot_fork(ear->board));
    stall(other, 51.2, zero_s);
    stall(other, 52.0, zero_s);
    hil_board_destroy(other->board);
    free(other);
}

/* 103 s of one board: stalls before and after TIM2's wraps (every 51.13 s), and a landing across
 * the first. */
TEST(time_goes_on_across_the_wrap)
{
    struct ear *ear = ear_open(NULL, 5);
    ear_until(ear, 0.05);
    double zero_s = scan_zero_s(ear->board);
    double wraps_s = zero_s - TRIGGER_TICK / TICKS_PER_S + 4294967296.0 / TICKS_PER_S;
    /* the 6th switch opens 0.2 ms before the wrap, in a block that ends after it */
    const double by_s = wraps_s - 0.2e-3 - (double)ear->run.switch_open_ps[5] * 1e-12;
    delay_landing(&ear->run, by_s);
    hil_board_attach_rig(ear->board, &ear->run);
    stall(ear, 10.0, zero_s);
    assert_true((double)ear->run.switch_open_ps[0] * 1e-12 < wraps_s - 0.1);
    ear_until(ear, by_s);
    stall_in_a_fork(ear, zero_s);
    ear_until(ear, by_s + 9.2);
    struct mr_touchdown touchdown;
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_TOUCHDOWN], 1);
    mr_touchdown_get(&touchdown, ear->last[EAR_CAN][MR_ID_TOUCHDOWN], MR_MESSAGE_BYTES_MAX);
    assert_near(touchdown.speed_ft_s, 35.5, 0.002 * 35.5); /* truth of landing5.run */
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_EDGE],
                     hil_board_counters(ear->board)->switches_opened);
    stall(ear, 103.0, zero_s);
    ear_close(ear);
}

static void hold_back(struct ear *ear, unsigned interrupt, bool held)
{
    struct hil_core *core = &ear->board->core;
    unsigned exception = 16u + interrupt;
    uint32_t bit = 1u << exception % 32u, *word = &core->state.nvic.enabled[exception / 32u];
    *word = held ? *word & ~bit : *word | bit;
    hil_nvic_update(core);
}

/* A mailbox that is done is empty, but filled again before its interrupt has run it loses RQCP
 * (RM0090 32.9.3): that frame is not counted, and the next one's time is taken for the sync
 * frame's. The window is a handful of instructions; a handler that comes late makes it some
 * milliseconds: more frames than there are mailboxes. */
TEST(each_frame_that_leaves_is_seen)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.3);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1);
    for (double t_s = 0.4; t_s < 4.0; t_s += 0.01) {
        ear_until(ear, t_s);
        hold_back(ear, HIL_IRQ_CAN1_TX, true);
        ear_until(ear, t_s + 4.0 * BLOCK_S);
        hold_back(ear, HIL_IRQ_CAN1_TX, false);
    }
    assert_true(ear->can_frames > 1000);
    assert_int_equal(hil_board_counters(ear->board)->can_mailboxes_refilled, 0);
    ear_close(ear);
}

/* --- who interrupts whom --- */

#define DMA2_STREAM1 57u
#define DMA2_STREAM4 60u

struct nesting {
    struct hil_core *core;
    bool inside;
    unsigned made, scan_in_can;
};

static bool is_active(const struct hil_nvic *nvic, unsigned interrupt)
{
    return nvic->active[(16u + interrupt) / 32u] >> (16u + interrupt) % 32u & 1u;
}

/* Every handler of CAN finds the end of a block waiting as it begins. */
static void note_nesting(void *context)
{
    struct nesting *nesting = context;
    struct hil_nvic *nvic = &nesting->core->state.nvic;
    unsigned scan = 16u + DMA2_STREAM4;
    bool before = nesting->inside;
    nesting->inside = is_active(nvic, HIL_IRQ_CAN1_TX) || is_active(nvic, HIL_IRQ_CAN1_RX0);
    nesting->scan_in_can += nesting->inside && is_active(nvic, DMA2_STREAM4);
    if (!nesting->inside || before)
        return;
    nesting->made++;
    nvic->pending[scan / 32u] |= 1u << scan % 32u;
    hil_nvic_update(nesting->core);
    hil_core_request_check(nesting->core);
}

static void note_nothing(void *context, uint64_t at)
{
    (void)context;
    (void)at;
}

/* A scan that waits for a handler of the links may lose codes: it interrupts them. */
TEST(the_scan_interrupts_can)
{
    static const struct hil_tracer_calls calls = {note_nothing, note_nesting};
    struct ear *ear = ear_open(NULL, 0);
    struct nesting nesting = {.core = &ear->board->core};
    ear_until(ear, 0.3);
    ear->board->core.observers.tracer = &calls;
    ear->board->core.observers.tracer_context = &nesting;
    ear_until(ear, 0.5);
    ear->board->core.observers.tracer = NULL;
    print_message("# %u of %u\n", nesting.scan_in_can, nesting.made);
    assert_true(nesting.made > 10);
    assert_true(nesting.scan_in_can >= nesting.made);
    ear_close(ear);
}

/* Who can wait longer interrupts nobody who cannot: scans (36 us), then CAN (a frame), then memory
 * and serial, and last the supervision, which is late by 10 ms at most. */
TEST(supervision_interrupts_nobody)
{
    enum { DMA1_STREAM3 = 14, DMA2_STREAM7 = 70 };
    static const unsigned order[4][3] = {
        {16 + DMA2_STREAM1, 16 + DMA2_STREAM4, 16 + HIL_IRQ_ADC},
        {16 + HIL_IRQ_CAN1_TX, 16 + HIL_IRQ_CAN1_RX0, 16 + HIL_IRQ_CAN1_RX0},
        {16 + DMA1_STREAM3, 16 + DMA2_STREAM7, 16 + DMA2_STREAM7},
        {HIL_EXC_SYSTICK, HIL_EXC_SYSTICK, HIL_EXC_SYSTICK}};
    struct ear *ear = ear_open(NULL, 0);
    const int16_t *priority = ear->board->core.state.nvic.priority;
    ear_until(ear, 0.05);
    for (unsigned urgent = 0; urgent + 1 < COUNT_OF(order); urgent++) {
        for (unsigned pair = 0; pair < 9; pair++)
            assert_true(priority[order[urgent][pair / 3]] < priority[order[urgent + 1][pair % 3]]);
    }
    ear_close(ear);
}

/* Interrupts masked once for 3.5 ms while a landing goes on, between two switches and over one: the
 * blocks that ended meanwhile are missing, and those after them are in their places, so each edge
 * still finds its step. */
TEST(masked_interrupts_cost_the_blocks_that_they_cover)
{
    for (unsigned over = 0; over < 2; over++) {
        struct ear *ear = ear_open(NULL, 5);
        struct hil_nvic *nvic = &ear->board->core.state.nvic;
        uint32_t enabled[HIL_EXCEPTION_WORDS];
        double sixth_s = (double)ear->run.switch_open_ps[5] * 1e-12;
        ear_until(ear, 0.05);
        double zero_s = scan_zero_s(ear->board);
        ear_until(ear, sixth_s - (over ? 2e-3 : 20e-3));
        memcpy(enabled, nvic->enabled, sizeof enabled);
        memset(nvic->enabled, 0, sizeof enabled);
        hil_nvic_update(&ear->board->core);
        ear_until(ear, sixth_s - (over ? 2e-3 : 20e-3) + 3.5e-3);
        memcpy(nvic->enabled, enabled, sizeof enabled);
        hil_nvic_update(&ear->board->core);
        ear_until(ear, sixth_s + 0.5);
        assert_in_place(ear, zero_s);
        ear_until(ear, ear->run.duration_s);
        struct mr_touchdown touchdown;
        struct mr_stop stop;
        struct mr_health health;
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_TOUCHDOWN], 1);
        mr_touchdown_get(&touchdown, ear->last[EAR_CAN][MR_ID_TOUCHDOWN], MR_MESSAGE_BYTES_MAX);
        assert_near(touchdown.speed_ft_s, 35.5, 0.002 * 35.5); /* truth of landing5.run */
        mr_stop_get(&stop, ear->last[EAR_CAN][MR_ID_STOP], MR_MESSAGE_BYTES_MAX);
        assert_int_equal(stop.switches, hil_board_counters(ear->board)->switches_opened);
        mr_health_get(&health, ear->last[EAR_CAN][MR_ID_HEALTH], MR_MESSAGE_BYTES_MAX);
        assert_in_range(health.blocks_lost, 3, 4); /* ends in 3.5 ms */
        assert_int_equal(ear_faults(ear, EAR_SERIAL), EAR_BIT(SCAN_OVERRUN));
        ear_close(ear);
    }
}

/* Returns when it really began: at the end of an instruction. */
static double pulse(struct ear *ear, double at_s, uint64_t cycles)
{
    struct hil_core *core = &ear->board->core;
    ear_until(ear, at_s);
    uint64_t begun = hil_now_cycle(core);
    hil_gpio_drive(&ear->board->mcu.gpio, 0, 15, true, begun);
    bench_run(ear->board, hil_clock_ps_at_cycle(&core->state.clock, begun + cycles));
    hil_gpio_drive(&ear->board->mcu.gpio, 0, 15, false, begun + cycles);
    return (double)hil_clock_ps_at_cycle(&core->state.clock, begun) * 1e-12;
}

/* 83 ns on the line of the edges are noise, 107 ns an edge, in its place to the tick. */
TEST(noise_is_no_edge)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.05);
    double zero_s = scan_zero_s(ear->board) - TRIGGER_TICK / TICKS_PER_S;
    ear_until(ear, 0.3);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1);
    pulse(ear, 0.5, 14);
    ear_until(ear, 0.6);
    assert_int_equal(hil_board_counters(ear->board)->edges_captured, 0);
    double begun_s = pulse(ear, 0.7, 18);
    ear_until(ear, 0.8);
    struct mr_edge edge;
    assert_int_equal(mr_edge_get(&edge, ear->last[EAR_CAN][MR_ID_EDGE], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    assert_near(edge.tick, (begun_s - zero_s) * TICKS_PER_S, 1.0);
    ear_close(ear);
}

/* An edge before the DMA has read the one before it: the capture is overwritten (RM0090 18.4.5,
 * CC1OF). The board reports it once, and the next edge is in its place. */
TEST(an_overwritten_capture_is_reported)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.05);
    double zero_s = scan_zero_s(ear->board) - TRIGGER_TICK / TICKS_PER_S;
    ear_until(ear, 0.3);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1);
    ear->board->state.mcu.tim[HIL_TIM2].sr |= 2u; /* CC1IF: not read yet */
    pulse(ear, 0.5, 40);
    double begun_s = pulse(ear, 0.7, 40);
    ear_until(ear, 2.0);
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].detail, 0);
    struct mr_edge edge;
    assert_int_equal(mr_edge_get(&edge, ear->last[EAR_CAN][MR_ID_EDGE], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    assert_near(edge.tick, (begun_s - zero_s) * TICKS_PER_S, 1.0);
    ear_close(ear);
}

/* A frame was lost because the FIFO was full (RM0090 32.9.3, FOVR0): the board counts it once, not
 * at every frame after it. */
TEST(an_overrun_of_the_can_fifo_is_counted_once)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.3);
    ear->board->state.mcu.can.rfr[0] |= 16u; /* FOVR */
    for (unsigned i = 0; i < 3; i++) {
        ear_command(ear, EAR_CAN, MR_COMMAND_STATE, 0, (uint16_t)(1 + i));
        ear_until(ear, 0.4 + 0.1 * i);
    }
    ear_until(ear, 2.0);
    assert_int_equal(ear->fault[MR_FAULT_CAN_RX_OVERRUN].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_CAN_RX_OVERRUN].detail, 0);
    ear_close(ear);
}

/* For 27 s no block comes, whatever is begun again: an edge of the time before would pass for one
 * to come, and hold up those behind it for 24 s more. */
TEST(an_old_edge_holds_nothing_up)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.5);
    hold_back(ear, DMA2_STREAM4, true);
    pulse(ear, 0.6, 40);
    ear_until(ear, 27.5);
    hold_back(ear, DMA2_STREAM4, false);
    ear_until(ear, 28.5);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(EDGE_OVERRUN));
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].detail, 1);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 1, 1);
    ear_until(ear, 29.0);
    pulse(ear, 29.0, 40);
    ear_until(ear, 29.2);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_EDGE], 1);
    ear_close(ear);
}
