/* Every kind of fault of hil/rig/faults.h, in the words of a fault file, and the answer that the
 * firmware promises to it (common/fault.h, catalogue.def, channels.h). The log says each fault with
 * its time. */
#include <math.h>

#include "common/image.h"
#include "hil/core/elf.h"
#include "tests/hil/ear.h"

static uint16_t invalid_displacements(const struct ear *ear)
{
    struct mr_displacement_7_8 message;
    mr_displacement_7_8_get(&message, ear->last[EAR_CAN][MR_ID_DISPLACEMENT_7_8],
                            MR_MESSAGE_BYTES_MAX);
    return message.invalid;
}

static uint16_t invalid_tensions(const struct ear *ear)
{
    struct mr_tension_13_14 message;
    mr_tension_13_14_get(&message, ear->last[EAR_CAN][MR_ID_TENSION_13_14], MR_MESSAGE_BYTES_MAX);
    return message.invalid;
}

static struct mr_can_health can_health(const struct ear *ear, unsigned link)
{
    struct mr_can_health health;
    mr_can_health_get(&health, ear->last[link][MR_ID_CAN_HEALTH], MR_MESSAGE_BYTES_MAX);
    return health;
}

/* --- power --- */

TEST(a_power_cut_starts_again_from_nothing)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 power-cut 20");
    ear_until(ear, 0.499);
    unsigned frames = ear->can_frames;
    ear_until(ear, 0.52); /* nothing while it is off, nor in the 2 ms that the crystal takes */
    assert_in_range(ear->can_frames, frames, frames + 4);
    ear_until(ear, 1.0);
    /* power (1), pin (2), brown-out (32: RM0090 sets it with every power-on) */
    assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause, 1 | 2 | 32);
    /* noise in RAM is not taken for a note of a processor fault */
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    ear_logged(ear, "fault at 0.5000000");
    ear_logged(ear, "power-cut 20 (line 2)");
    ear_close(ear);
}

TEST(a_brown_out_is_named)
{
    struct ear *ear = ear_open(NULL, 0);
    ear->board->state.mcu.flash.option_bytes &= ~0xcu; /* level 3: 2.83 V */
    ear_order(ear, "at 0.5 brown-out 2.6 5");
    ear_until(ear, 1.1);
    assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause, 2 | 32);
    assert_int_equal(hil_board_counters(ear->board)->resets, 1);
    ear_close(ear);
}

/* With the level off, as delivered, silicon would go on at 168 MHz on 2.6 V, beyond its data sheet:
 * the run ends. At 2.8 V it may. Below the power-down level it is a power cut. */
TEST(a_brown_out_without_reset_ends_the_run)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.1 brown-out 2.8 5\nat 0.2 brown-out 1.5 5\nat 0.5 brown-out 2.6 5");
    ear_until(ear, 0.19);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    ear_until(ear, 0.4);
    assert_int_equal(hil_board_counters(ear->board)->power_cuts, 1);
    assert_int_equal(hil_board_run_until(ear->board, HIL_PS_PER_S), MR_HALTED);
    assert_non_null(strstr(hil_board_failure_reason(ear->board), "2.60 V"));
    ear_close(ear);
}

/* --- crystal --- */

/* It stops in flight: clock security resets at once, and the board goes on from the internal
 * oscillator, CAN silent. */
TEST(a_crystal_that_stops_is_replaced)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 crystal stop");
    ear_until(ear, 0.5002); /* what it was is written down first, at 16 MHz */
    assert_int_equal(hil_board_counters(ear->board)->resets, 1);
    ear_until(ear, 1.4);
    assert_int_equal(hil_board_counters(ear->board)->watchdog_resets, 0);
    assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source, 1);
    uint32_t faults = ear_faults(ear, EAR_SERIAL);
    assert_int_equal(faults, EAR_BIT(CLOCK_FALLBACK) | EAR_BIT(CAN_SILENT) | EAR_BIT(HARD_FAULT));
    assert_int_equal(ear->fault[MR_FAULT_HARD_FAULT].detail, 5);
    ear_close(ear);
}

/* It stops and is back before the board has given it up: the start finds it. */
TEST(a_crystal_that_comes_back_is_used)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 crystal stop\nat 0.51 crystal start");
    ear_until(ear, 1.2);
    assert_int_equal(ear_hello(ear, EAR_CAN).clock_source, 0);
    assert_int_equal(ear_faults(ear, EAR_CAN), EAR_BIT(HARD_FAULT));
    ear_close(ear);
}

/* One that starts each time and stops again: after the second crash the internal oscillator serves,
 * and that is told. Whoever asks for a restart has it tried again. */
TEST(a_crystal_that_stops_again_and_again_is_given_up)
{
    struct ear *ear = ear_open(NULL, 0);
    for (unsigned n = 0; n < 20; n++) {
        char order[80];
        snprintf(order, sizeof order, "at %.2f crystal stop\nat %.3f crystal start", 0.3 + 0.25 * n,
                 0.301 + 0.25 * n);
        ear_order(ear, order);
    }
    ear_until(ear, 6.0);
    assert_int_equal(hil_board_counters(ear->board)->resets, 2);
    assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source, MR_CLOCK_INTERNAL_PLL);
    assert_int_equal(ear_faults(ear, EAR_SERIAL),
                     EAR_BIT(CLOCK_FALLBACK) | EAR_BIT(CAN_SILENT) | EAR_BIT(HARD_FAULT));
    assert_int_equal(ear->fault[MR_FAULT_CLOCK_FALLBACK].detail, 255);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_RESET, 0, 1);
    ear_until(ear, 7.5);
    assert_int_equal(hil_board_counters(ear->board)->resets, 3);
    assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source, MR_CLOCK_CRYSTAL);
    ear_close(ear);
}

/* An image without clock security: instructions and scans stand still, physical time does not, and
 * both go on when the crystal has started again, 2 ms after it can. */
TEST(without_clock_security_the_clock_stands_still)
{
    struct hil_run run;
    struct hil_board *board = bench_board("scan", NULL);
    still_run(&run, 1.0);
    hil_board_attach_rig(board, &run);
    const struct hil_counters *counters = hil_board_counters(board);
    struct hil_fault stop = {.trigger_ps = 10 * HIL_PS_PER_MS, .action = HIL_FAULT_CRYSTAL};
    struct hil_fault start = {
        .trigger_ps = 20 * HIL_PS_PER_MS, .action = HIL_FAULT_CRYSTAL, .variant = 1};
    assert_int_equal(hil_faults_add(&board->faults, &stop), MR_OK);
    assert_int_equal(hil_faults_add(&board->faults, &start), MR_OK);
    bench_run(board, 10 * HIL_PS_PER_MS + 10 * HIL_PS_PER_US);
    uint64_t instructions = counters->instructions, scans = counters->adc_scans[HIL_ADC1];
    bench_run(board, 21 * HIL_PS_PER_MS);
    assert_int_equal(hil_board_now_ps(board) / HIL_PS_PER_US, 21000);
    assert_int_equal(counters->instructions, instructions);
    assert_int_equal(counters->adc_scans[HIL_ADC1], scans);
    bench_run(board, 32 * HIL_PS_PER_MS);
    assert_in_range(counters->adc_scans[HIL_ADC1], scans + 79, scans + 81); /* 10 ms at 8 kHz */
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* And with a watchdog on its own oscillator: the reset comes in its time (the firmware before it
 * secured its clock). */
TEST(the_watchdog_outlives_the_clock)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.3);
    ear->board->state.mcu.rcc.cr &= ~(1u << 19); /* CSSON */
    ear_order(ear, "at 0.3005 crystal stop");
    ear_until(ear, 0.3005 + 501.0 * 32.0 / 32000.0 - 0.011);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    ear_until(ear, 1.5);
    assert_int_equal(hil_board_counters(ear->board)->watchdog_resets, 1);
    assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source, 1);
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(WATCHDOG_RESET));
    ear_close(ear);
}

/* --- bits --- */

static unsigned image_state(const struct ear *ear)
{
    struct mr_image_commit commit;
    assert_int_equal(
        mr_image_commit_get(&commit, ear->last[EAR_CAN][MR_ID_IMAGE_COMMIT], MR_MESSAGE_BYTES_MAX),
        MR_OK);
    return commit.state;
}

/* A bit of a vector that nobody takes, of the header: both are below the header's own CRC. */
TEST(a_bit_of_vectors_or_header_is_told)
{
    static const char *const flips[] = {"at 0.8 flip 0x08000184 5\nat 0.9 power-cut 1",
                                        "at 0.8 flip 0x08000218 0\nat 0.9 power-cut 1"};
    for (unsigned i = 0; i < 2; i++) {
        struct ear *ear = ear_open(NULL, 0);
        ear_order(ear, flips[i]);
        ear_until(ear, 1.6);
        assert_int_equal(image_state(ear), MR_IMAGE_HEADER_DAMAGED);
        ear_close(ear);
    }
}

/* A bit of the program, where nothing goes: the image is no longer the one that was flashed, and
 * the next hello says so. */
TEST(a_bit_of_flash_changes_the_image)
{
    struct ear *ear = ear_open(NULL, 0);
    struct mr_board_image before, after;
    ear_until(ear, 0.7);
    mr_board_image_get(&before, ear->last[EAR_CAN][MR_ID_BOARD_IMAGE], MR_MESSAGE_BYTES_MAX);
    assert_int_equal(image_state(ear), MR_IMAGE_INTACT);
    ear_order(ear, "at 0.8 flip processor_fault+4 0\nat 0.9 power-cut 1");
    ear_until(ear, 1.6);
    mr_board_image_get(&after, ear->last[EAR_CAN][MR_ID_BOARD_IMAGE], MR_MESSAGE_BYTES_MAX);
    assert_int_not_equal(after.image_crc, before.image_crc);
    assert_int_equal(after.uid2, before.uid2);
    assert_int_equal(image_state(ear), MR_IMAGE_PROGRAM_DAMAGED);
    ear_close(ear);
}

/* The vector of SysTick loses its Thumb bit: a processor fault, which resets. */
TEST(a_bit_of_the_vectors_is_a_processor_fault)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.3 flip 0x0800003c 0\nat 0.305 + 6000 flip 0x0800003c 0");
    ear_until(ear, 0.9);
    assert_true(hil_board_counters(ear->board)->fault_exceptions >= 1);
    assert_true(hil_board_counters(ear->board)->resets >= 1);
    assert_true(ear_faults(ear, EAR_CAN) & EAR_BIT(HARD_FAULT));
    assert_int_equal(ear->fault[MR_FAULT_HARD_FAULT].detail, 3); /* usage fault */
    ear_close(ear);
}

/* A bit of RAM: the CAN driver forgets that it runs. What it cannot send is counted, and told on
 * serial. */
TEST(a_bit_of_ram_is_survived)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.3);
    ear_order(ear, "at 0.4 flip is_running 0");
    ear_until(ear, 1.2);
    ear_logged(ear, "flip is_running 0 (line 2)");
    assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_QUEUE_FULL));
    assert_true(can_health(ear, EAR_SERIAL).dropped > 50);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    ear_close(ear);
}

/* --- frames --- */

/* Lost between the board and the host: the board counts what it sent, so the host sees how many are
 * missing. */
TEST(dropped_frames_are_missed)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 can out drop 5");
    ear_until(ear, 1.0);
    assert_int_equal(ear->can_sent, ear->can_at_health + 5);
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    ear_close(ear);
}

TEST(repeated_frames_are_too_many)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 can out repeat 5");
    ear_until(ear, 1.0);
    assert_int_equal(ear->can_sent + 5, ear->can_at_health);
    ear_close(ear);
}

/* Destroyed on the wire: sent again, so nothing is missing; TEC shows it, 8 up each, 1 down for
 * each that passes. */
TEST(corrupted_frames_are_sent_again)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "frame 40 can out corrupt 10");
    ear_until(ear, 0.35);
    ear_until(ear, 0.7);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    assert_int_equal(hil_board_counters(ear->board)->can_errors, 10);
    ear_logged(ear, "CAN out: frame 0x");
    ear_close(ear);
}

/* 17 in a row: TEC 8 * 17 = 136, beyond 127: error passive, told with its TEC as far as it has come
 * down since. */
TEST(many_corrupted_frames_make_it_passive)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.44);
    unsigned frames = ear->can_frames;
    ear_order(ear, "at 0.4400001 can out corrupt 17");
    while (hil_board_counters(ear->board)->can_errors < 17)
        ear_until(ear, (double)hil_board_now_ps(ear->board) * 1e-12 + 1e-5);
    assert_int_equal(ear->can_frames, frames);
    assert_int_equal(ear->board->state.mcu.can.tec, 136);
    ear_until(ear, 0.7);
    assert_true(can_health(ear, EAR_CAN).tec > 0 && can_health(ear, EAR_CAN).tec < 136);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* Frames held back 50 ms come after others that were sent later; none is lost. */
TEST(delayed_frames_are_overtaken)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    ear->listens = true;
    ear_order(ear, "at 0.601 can out delay 30 p 0.3 us 50000");
    ear_until(ear, 1.4);
    ear->listens = false;
    ear_until(ear, 2.5);
    unsigned last = 0, overtaken = 0; /* place on serial, where the order is the board's own */
    for (unsigned i = 0; i < ear->said_count[EAR_CAN]; i++) {
        for (unsigned k = 0; k < ear->said_count[EAR_SERIAL]; k++) {
            if (memcmp(&ear->said[EAR_CAN][i], &ear->said[EAR_SERIAL][k],
                       sizeof(struct ear_said)) != 0)
                continue;
            overtaken += k < last;
            last = k;
            break;
        }
    }
    assert_true(overtaken > 3);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_logged(ear, "delayed");
    ear_close(ear);
}

/* Commands: one that does not come is not answered, one that comes twice is answered twice, one
 * destroyed on the wire is sent again by its sender and answered once. */
TEST(commands_by_can)
{
    static const struct {
        const char *order;
        unsigned acks;
    } cases[] = {
        {"at 0.3 can in drop 1", 0},
        {"at 0.3 can in repeat 1", 2},
        {"at 0.3 can in corrupt 3", 1},
        {"at 0.3 can in delay 1 us 50000", 1},
    };
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        struct ear *ear = ear_open(NULL, 0);
        ear_order(ear, cases[i].order);
        ear_until(ear, 0.35);
        ear_command(ear, EAR_CAN, MR_COMMAND_MARK, 7, 77);
        ear_until(ear, 0.39);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_ACK], i == 3 ? 0 : cases[i].acks);
        ear_until(ear, 0.6);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_ACK], cases[i].acks);
        if (i == 2)
            assert_int_equal(ear->board->state.mcu.can.rec, 2); /* three errors, one good frame */
        ear_close(ear);
    }
}

/* --- bytes --- */

TEST(bytes_from_the_board)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "seed 3\nat 0.5 serial out corrupt 3 p 0.05\nat 1.5 serial out drop 2 p 0.05\n"
                   "at 2.5 serial out repeat 2 p 0.05\nat 3.5 serial out delay 1 us 20000");
    ear_until(ear, 0.5);
    assert_int_equal(ear->serial_refused_count, 0);
    ear_until(ear, 1.5);
    unsigned bad = ear->serial_refused_count;
    /* refused by its checksum; one more when the end of a frame was hit */
    assert_in_range(bad, 1, 4);
    ear_until(ear, 2.5);
    assert_true(ear->serial_refused_count > bad);
    bad = ear->serial_refused_count;
    ear_until(ear, 3.5);
    assert_true(ear->serial_refused_count > bad);
    bad = ear->serial_refused_count;
    uint64_t last_ps = ear->last_ps[EAR_SERIAL];
    ear_until(ear, 3.512);
    assert_int_equal(ear->last_ps[EAR_SERIAL], last_ps); /* held back */
    ear_until(ear, 4.0);
    assert_int_equal(ear->serial_refused_count, bad); /* late, but whole */
    assert_true(ear->serial_lost >= 3);               /* the numbers of the frames say how many */
    ear_close(ear);
}

TEST(bytes_to_the_board)
{
    static const struct {
        const char *order;
        unsigned acks;
        bool refused;
    } cases[] = {
        {"at 0.3 serial in corrupt 1", 0, true},  {"at 0.3 serial in drop 1", 0, true},
        {"at 0.3 serial in repeat 1", 0, true},   {"at 0.3 serial in delay 1 us 10000", 1, false},
        {"at 0.3 serial in noise 3", 1, false},   /* two of three samples were right: the byte is */
        {"at 0.3 serial in framing 1", 1, false}, /* the frame's checksum decides */
    };
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        struct ear *ear = ear_open(NULL, 0);
        ear_order(ear, cases[i].order);
        ear_until(ear, 0.35);
        ear_command(ear, EAR_SERIAL, MR_COMMAND_MARK, 7, 77);
        ear_until(ear, 0.6);
        if (ear->heard[EAR_SERIAL][MR_ID_ACK] != cases[i].acks)
            fail_msg("%s: %u answers", cases[i].order, ear->heard[EAR_SERIAL][MR_ID_ACK]);
        assert_int_equal((ear_faults(ear, EAR_SERIAL) & EAR_BIT(SERIAL_BAD_FRAME)) != 0,
                         cases[i].refused);
        ear_close(ear);
    }
}

/* --- bus --- */

TEST(an_unplugged_bus_is_told)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 bus unplug\nat 0.9 bus connect");
    ear_until(ear, 0.9);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), EAR_BIT(CAN_PASSIVE));
    assert_int_equal(can_health(ear, EAR_SERIAL).tec, 128);
    ear_until(ear, 1.5);
    assert_int_equal(ear->fault[MR_FAULT_CAN_PASSIVE].detail, 128);
    /* what waited in the queue came afterwards */
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* Held dominant in flight: a transmitter counts to bus-off; free again, it comes back after 128 x
 * 11 bits. */
TEST(a_dominant_bus_is_told_and_left)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.2);
    char order[64];
    snprintf(order, sizeof order, "frame %llu bus dominant",
             (unsigned long long)hil_board_counters(ear->board)->can_frames_out + 20u);
    ear_order(ear, order);
    ear_order(ear, "at 0.9 bus connect");
    ear_until(ear, 0.89);
    assert_true(ear_faults(ear, EAR_SERIAL) & (EAR_BIT(CAN_BUS_OFF) | EAR_BIT(CAN_PASSIVE)));
    unsigned frames = ear->can_frames;
    ear_until(ear, 0.9);
    assert_int_equal(ear->can_frames, frames);
    ear_until(ear, 1.5);
    assert_true(ear->can_frames > frames);
    ear_close(ear);
}

/* --- channels --- */

TEST(channels_that_fail_are_missing)
{
    static const struct {
        const char *what;
        uint16_t displacements, tensions;
    } cases[] = {
        {"transducer 3 open", 1u << 2, 0}, {"transducer 8 high", 1u << 7, 0},
        {"transducer 1 low", 1u << 0, 0},  {"gage 5 open", 0, 1u << 4},
        {"gage 14 high", 0, 1u << 13},     {"gage 1 low", 0, 1u << 0},
        {"reference high", 0xff, 0x3fff},  {"reference open", 0xff, 0x3fff},
        {"transducer 2 stick", 0, 0},      {"staircase open", 0, 0},
    };
    struct ear *ear = ear_open(NULL, 0);
    double t_s = 0.4;
    ear_until(ear, t_s);
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        char order[160], name[64];
        snprintf(name, sizeof name, "%s", cases[i].what);
        *strrchr(name, ' ') = '\0';
        snprintf(order, sizeof order, "at %.6f %s\nat %.6f %s mend", t_s + 0.001, cases[i].what,
                 t_s + 0.25, name);
        ear_order(ear, order);
        ear_until(ear, t_s + 0.25);
        if (invalid_displacements(ear) != cases[i].displacements ||
            invalid_tensions(ear) != cases[i].tensions)
            fail_msg("%s: missing 0x%x, 0x%x", cases[i].what, invalid_displacements(ear),
                     invalid_tensions(ear));
        t_s += 0.5;
        ear_until(ear, t_s);
        assert_int_equal(invalid_displacements(ear), 0);
        assert_int_equal(invalid_tensions(ear), 0);
    }
    assert_int_equal(ear_faults(ear, EAR_CAN), EAR_BIT(REFERENCE) | EAR_BIT(CHANNEL));
    ear_close(ear);
}

/* --- switches --- */

/* The staircase gone: no edge can be named, and the board says that it has no speed. */
TEST(without_the_staircase_there_is_no_speed)
{
    struct ear *ear = ear_open(NULL, 5);
    ear_order(ear, "at 0.5 staircase low");
    ear_until(ear, ear->run.duration_s);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_TOUCHDOWN], 0);
    /* each edge is told, and that it had no step */
    assert_true(ear->heard[EAR_CAN][MR_ID_EDGE] > 15);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_SWITCH_EVENT], ear->heard[EAR_CAN][MR_ID_EDGE]);
    ear_close(ear);
}

/* --- counted triggers, hooks, sameness --- */

/* Operations of flash and NOR trigger; while idle the firmware has none, so they are begun by hand,
 * when it has looked through its memory. */
TEST(counted_operations_trigger)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear,
              "flash 3 bus unplug\nnor 2 + 500 nor fill\nnor 3 nor fail-program 4\nnor 4 nor dead");
    ear_until(ear, 1.1);
    hil_faults_on_flash_operation(&ear->board->faults);
    hil_faults_on_flash_operation(&ear->board->faults);
    ear_until(ear, 1.101);
    assert_int_equal(ear->board->options.can_bus, HIL_CAN_CONNECTED);
    hil_faults_on_flash_operation(&ear->board->faults);
    ear_until(ear, 1.102);
    assert_int_equal(ear->board->options.can_bus, HIL_CAN_UNPLUGGED);
    const struct hil_nor_fault_requests *nor = &ear->board->state.nor_fault_requests;
    hil_faults_on_nor_operation(&ear->board->faults);
    hil_faults_on_nor_operation(&ear->board->faults);
    ear_until(ear, 1.1024);
    assert_false(nor->is_fill_requested);
    ear_until(ear, 1.1026);
    assert_true(nor->is_fill_requested);
    hil_faults_on_nor_operation(&ear->board->faults);
    hil_faults_on_nor_operation(&ear->board->faults);
    ear_until(ear, 1.11);
    assert_int_equal(nor->failing_program_count, 4);
    assert_true(nor->is_dead);
    ear_close(ear);
}

TEST(same_seed_same_faults)
{
    static const char order[] =
        "at 0.1 can out drop all p 0.1\nat 0.1 serial out corrupt all p 0.01";
    char with_seed[128];
    struct ear *boards[3];
    for (unsigned i = 0; i < 3; i++) {
        boards[i] = ear_open(NULL, 0);
        snprintf(with_seed, sizeof with_seed, "seed %u\n%s", i == 2 ? 6u : 5u, order);
        ear_order(boards[i], with_seed);
        for (unsigned k = 0; k < (i == 1 ? 10u : 1u); k++)
            ear_until(boards[i], 0.5 * (k + 1) / (i == 1 ? 10 : 1));
    }
    assert_true(boards[0]->can_frames > 20);
    assert_string_equal(boards[0]->log, boards[1]->log);
    assert_int_equal(boards[0]->can_frames, boards[1]->can_frames);
    assert_string_not_equal(boards[0]->log, boards[2]->log);
    for (unsigned i = 0; i < 3; i++)
        ear_close(boards[i]);
}

/* Depth of the stack as a board told it last, taken out of what it told. */
static unsigned take_stack_used(struct ear *ear)
{
    struct mr_upkeep upkeep;
    assert_int_equal(
        mr_upkeep_get(&upkeep, ear->last[EAR_SERIAL][MR_ID_UPKEEP], MR_MESSAGE_BYTES_MAX), MR_OK);
    for (unsigned link = 0; link < EAR_LINKS; link++)
        memset(ear->last[link][MR_ID_UPKEEP], 0, 2); /* u16, the first */
    return upkeep.stack_used;
}

/* The firmware makes no unaligned multiple transfer, and watching for one changes nothing but how
 * deep the stack has been: an interrupt comes between two pieces of code that the CPU translates at
 * once, and looking at each instruction cuts them elsewhere. */
TEST(watching_alignment_changes_nothing)
{
    struct hil_options options = ear_options();
    struct ear *plain = ear_open(&options, 5);
    options.is_alignment_checked = true;
    struct ear *watched = ear_open(&options, 5);
    ear_until(plain, 1.5);
    ear_until(watched, 1.5);
    assert_int_equal(hil_board_counters(watched->board)->fault_exceptions, 0);
    assert_int_equal(watched->can_frames, plain->can_frames);
    assert_int_equal(watched->blocks, plain->blocks);
    assert_true(abs((int)take_stack_used(plain) - (int)take_stack_used(watched)) < 100);
    assert_memory_equal(watched->last, plain->last, sizeof plain->last);
    ear_close(plain);
    ear_close(watched);
}

/* What is wrong with a line, where, and what is right. */
TEST(mistakes_are_named)
{
    static const struct {
        const char *text;
        enum mr_status status;
        const char *part;
    } cases[] = {
        {"", MR_MALFORMED, "first line must be `matrig-faults 1`"},
        {"faults 1\n", MR_MALFORMED, "not a fault file"},
        {"matrig-faults 2\n", MR_VERSION, ":1: the fault file has version `2`"},
        {"matrig-faults 1\nwhen 3 bus short\n", MR_MALFORMED, ":2: `when`: begin the line with"},
        {"matrig-faults 1\nat x bus short\n", MR_MALFORMED, "`x`"},
        {"matrig-faults 1\n\n# remark\nframe 0 bus short\n", MR_MALFORMED, ":4: `0`"},
        {"matrig-faults 1\nat 1 + 0 bus short\n", MR_MALFORMED, "`0`"},
        {"matrig-faults 1\nat 1 bus loose\n", MR_MALFORMED,
         "`loose` does not fit: bus connect|unplug|short|dominant"},
        {"matrig-faults 1\nat 1 explode\n", MR_MALFORMED,
         "`explode` is not an action; give one of power-cut, br"},
        {"matrig-faults 1\nat 1\n", MR_MALFORMED, "`end of line` is not an action"},
        {"matrig-faults 1\nat 1 can out noise 1\n", MR_MALFORMED, "`noise` does not fit: can out"},
        {"matrig-faults 1\nat 1 can out drop\n", MR_MALFORMED, "`end of line` does not fit"},
        {"matrig-faults 1\nat 1 can out drop 1 p 0\n", MR_MALFORMED, "[p P(1e-09 to 1)]"},
        {"matrig-faults 1\nat 1 gage 3 broken\n", MR_MALFORMED,
         "`broken` does not fit: gage GAGE(1 to 14) mend|stick|high|low|open, or gage GAGE"},
        {"matrig-faults 1\nat 1 switch 2.5 skip\n", MR_MALFORMED, "`2.5` does not fit"},
        {"matrig-faults 1\nat 1 flip\n", MR_MALFORMED, "`end of line` does not fit: flip PLACE"},
        {"matrig-faults 1\nat 1 flip nowhere 1\n", MR_UNKNOWN, "no symbol `nowhere`"},
        {"matrig-faults 1\nat 1 flip config+x 1\n", MR_MALFORMED, "`config+x` does not fit"},
        {"matrig-faults 1\nat 1 bus short now\n", MR_MALFORMED, "unexpected word `now`"},
        {"matrig-faults 1\nat 1 \x1b[31m\n", MR_MALFORMED, "`?[31m` is not an action"},
    };
    static struct hil_fault_script script;
    char error[900];
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        const char *path = bench_scratch("wrong.faults", cases[i].text, strlen(cases[i].text));
        enum mr_status status = hil_faults_read(path, EAR_ELF, &script, error, sizeof error);
        if (status != cases[i].status || !strstr(error, cases[i].part))
            fail_msg("case %u: status %d, said: %s", i, status, error);
    }
    assert_int_equal(hil_faults_read("no-such.faults", NULL, &script, error, sizeof error), MR_IO);
}

TEST(impossible_orders_are_refused)
{
    struct ear *ear = ear_open(NULL, 5);
    struct hil_fault fault = {
        .trigger = HIL_TRIGGER_STATION, .station_ft = 118.0, .action = HIL_FAULT_CAN_BUS};
    /* beyond the last switch that opens */
    assert_int_equal(hil_faults_add(&ear->board->faults, &fault), MR_UNKNOWN);
    fault = (struct hil_fault){.action = HIL_FAULT_BIT_FLIP, .address = 0x20020000};
    assert_int_equal(hil_faults_add(&ear->board->faults, &fault), MR_USAGE);
    fault = (struct hil_fault){.action = HIL_FAULT_CRYSTAL};
    ear_until(ear, 0.01);
    assert_int_equal(hil_faults_add(&ear->board->faults, &fault), MR_USAGE);
    fault.trigger_ps = HIL_PS_PER_S;
    for (unsigned i = 0; i < HIL_FAULTS_MAX; i++)
        assert_int_equal(hil_faults_add(&ear->board->faults, &fault), MR_OK);
    assert_int_equal(hil_faults_add(&ear->board->faults, &fault), MR_FULL);
    ear_close(ear);
}
