/* What the firmware promises to each fault of its own (hil/README.md has the table): detected,
 * counted, told and recovered from, within the times stated there, which are virtual and so the
 * same on any machine. */
#include <math.h>

#include "common/fault.h"
#include "hil/board/board.h"
#include "hil/core/elf.h"
#include "tests/hil/ear.h"

#define HANG      0xe7feu /* b . */
#define RETURN    0x4770u /* bx lr */
#define UNDEFINED 0xde00u /* udf #0 */
#define PE        4u

static double now_s(const struct ear *ear)
{
    return (double)hil_board_now_ps(ear->board) * 1e-12;
}

/* Runs until the message has come once more; returns when. */
static double until_heard(struct ear *ear, unsigned link, uint16_t id, double within_s)
{
    unsigned before = ear->heard[link][id];
    double end_s = now_s(ear) + within_s;
    while (ear->heard[link][id] == before) {
        if (now_s(ear) >= end_s)
            fail_msg("no message 0x%03x within %g s", id, within_s);
        ear_until(ear, now_s(ear) + 1e-3);
    }
    return now_s(ear);
}

#define GET(ear, link, name, NAME)                                                             \
    ({                                                                                         \
        struct mr_##name message_;                                                             \
        assert_true((ear)->heard[link][MR_ID_##NAME] > 0);                                     \
        assert_int_equal(                                                                      \
            mr_##name##_get(&message_, (ear)->last[link][MR_ID_##NAME], MR_MESSAGE_BYTES_MAX), \
            MR_OK);                                                                            \
        message_;                                                                              \
    })

static uint32_t symbol(const char *name)
{
    uint32_t address = 0;
    if (hil_elf_find_symbol(EAR_ELF, name, &address) != MR_OK)
        fail_msg("no symbol %s in %s", name, EAR_ELF);
    return address;
}

/* Other code in place of a function's beginning; returns what was there. */
static void patch(struct ear *ear, uint32_t address, const uint16_t *code, size_t n,
                  uint16_t *before)
{
    if (before)
        assert_int_equal(hil_board_peek(ear->board, address, before, 2 * n), MR_OK);
    assert_int_equal(hil_board_poke(ear->board, address, code, 2 * n), MR_OK);
}

/* Runs until the board has been reset once more; returns when. */
static double until_reset(struct ear *ear, double within_s)
{
    uint64_t before = hil_board_counters(ear->board)->resets;
    double end_s = now_s(ear) + within_s;
    while (hil_board_counters(ear->board)->resets == before) {
        if (now_s(ear) >= end_s)
            fail_msg("no reset within %g s", within_s);
        ear_until(ear, now_s(ear) + 1e-4);
    }
    return now_s(ear);
}

static int8_t answer(struct ear *ear, unsigned code, uint16_t tag)
{
    ear_command(ear, EAR_SERIAL, code, 0, tag);
    until_heard(ear, EAR_SERIAL, MR_ID_ACK, 0.05);
    struct mr_ack ack = GET(ear, EAR_SERIAL, ack, ACK);
    assert_int_equal(ack.tag, tag);
    assert_int_equal(ack.code, code);
    return ack.status;
}

/* ---- tasks ---- */

/* A part hangs: reset within 0.75 s (0.2 s until it is late, 0.5 s of the watchdog since the last
 * feed), and told which, and where, within 1 s of the restart. */
TEST(a_part_that_hangs_is_named)
{
    static const uint16_t hang[] = {HANG};
    uint16_t before[1];
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("blackbox_poll");
    ear_until(ear, 0.6);
    patch(ear, place, hang, 1, before);
    double reset_s = until_reset(ear, 0.75);
    assert_true(reset_s - 0.6 > 0.45);
    patch(ear, place, before, 1, NULL);
    ear_until(ear, reset_s + 1.0);
    uint32_t faults = ear_faults(ear, EAR_CAN);
    assert_int_equal(faults, EAR_BIT(WATCHDOG_RESET) | EAR_BIT(TASK_LATE));
    assert_int_equal(ear->fault[MR_FAULT_TASK_LATE].detail, MR_TASK_BOX);
    struct mr_restarts restarts = GET(ear, EAR_CAN, restarts, RESTARTS);
    assert_int_equal(restarts.restarts, 1);
    assert_int_equal(restarts.in_row, 1);
    assert_int_equal(restarts.late_task, MR_TASK_BOX);
    assert_int_equal(restarts.late_pc, place);
    assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause & 8u, 8u);
    ear_close(ear);
}

/* A part is left out while all else goes on: told before the watchdog comes, and after it. */
TEST(a_part_that_is_left_out_is_named)
{
    static const uint16_t leave[] = {RETURN};
    uint16_t before[1];
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("healthlink_tick");
    ear_until(ear, 0.6);
    patch(ear, place, leave, 1, before);
    ear_until(ear, 0.6 + 0.99);
    assert_int_equal(ear->fault[MR_FAULT_TASK_LATE].count, 0);
    ear_until(ear, 0.6 + 1.15); /* its limit is 1 s; faults are told each 0.1 s */
    assert_int_equal(ear->fault[MR_FAULT_TASK_LATE].detail, MR_TASK_UPKEEP);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    double reset_s = until_reset(ear, 0.5);
    patch(ear, place, before, 1, NULL);
    ear_until(ear, reset_s + 1.0);
    assert_int_equal(GET(ear, EAR_SERIAL, restarts, RESTARTS).late_task, MR_TASK_UPKEEP);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), EAR_BIT(WATCHDOG_RESET) | EAR_BIT(TASK_LATE));
    ear_close(ear);
}

/* A board that is reset again and again stops measuring after five times, and only speaks; it
 * warns. A command brings it back. */
TEST(a_row_of_resets_ends)
{
    static const uint16_t hang[] = {HANG};
    uint16_t before[1];
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("mr_block_from_scans"); /* of an interrupt that masks supervision */
    ear_until(ear, 0.6);
    patch(ear, place, hang, 1, before);
    for (unsigned i = 0; i < 5; i++)
        until_reset(ear, 0.75);
    double quiet_s = now_s(ear);
    assert_true(quiet_s < 0.6 + 5 * 0.6);
    ear_until(ear, quiet_s + 3.0);
    assert_int_equal(hil_board_counters(ear->board)->watchdog_resets, 5);
    struct mr_restarts restarts = GET(ear, EAR_CAN, restarts, RESTARTS);
    assert_int_equal(restarts.in_row, 5);
    assert_false(hil_board_pin_level(ear->board, PE, 0));
    patch(ear, place, before, 1, NULL);
    assert_int_equal(answer(ear, MR_COMMAND_RESET, 4), MR_OK);
    double reset_s = until_reset(ear, 0.1);
    ear_until(ear, reset_s + 1.0);
    restarts = GET(ear, EAR_CAN, restarts, RESTARTS);
    assert_int_equal(restarts.in_row, 0);
    assert_int_equal(restarts.restarts, 5);
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    assert_true(hil_board_pin_level(ear->board, PE, 0));
    ear_close(ear);
}

/* Ten good seconds end a row. */
TEST(good_seconds_end_a_row)
{
    static const uint16_t hang[] = {HANG};
    uint16_t before[1];
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("blackbox_poll");
    for (unsigned i = 1; i <= 2; i++) {
        ear_until(ear, now_s(ear) + 11.0);
        patch(ear, place, hang, 1, before);
        until_reset(ear, 0.75);
        patch(ear, place, before, 1, NULL);
    }
    ear_until(ear, now_s(ear) + 1.0);
    assert_int_equal(GET(ear, EAR_CAN, restarts, RESTARTS).in_row, 1);
    assert_int_equal(GET(ear, EAR_CAN, restarts, RESTARTS).restarts, 2);
    ear_close(ear);
}

/* A board without scans has nothing to take: it speaks, obeys, and is not reset. */
TEST(a_board_without_scans_is_not_reset)
{
    static const uint16_t leave[] = {RETURN};
    struct ear *ear = ear_open(NULL, 0);
    patch(ear, symbol("scan_prepare"), leave, 1, NULL);
    ear_until(ear, 5.0);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    assert_int_equal(ear->blocks, 0);
    assert_true(ear->heard[EAR_SERIAL][MR_ID_HEALTH] >= 4);
    /* the patch itself is seen: the program is not the one that was made */
    assert_int_equal(ear_faults(ear, EAR_SERIAL) & ~EAR_BIT(SELFTEST), EAR_BIT(SCAN_STALL));
    assert_int_equal(answer(ear, MR_COMMAND_MARK, 3), MR_OK);
    ear_close(ear);
}

/* ---- processor faults ---- */

static unsigned take_crash(const struct ear *ear, unsigned link, uint32_t word[MR_CRASH_ITEM_COUNT],
                           uint16_t *age)
{
    unsigned told = 0;
    for (unsigned i = 0; i < ear->said_count[link]; i++) {
        struct mr_crash crash;
        if (ear->said[link][i].id != MR_ID_CRASH)
            continue;
        assert_int_equal(mr_crash_get(&crash, ear->said[link][i].payload, MR_MESSAGE_BYTES_MAX),
                         MR_OK);
        assert_int_equal(crash.items, MR_CRASH_ITEM_COUNT);
        assert_int_equal(crash.item, told % MR_CRASH_ITEM_COUNT);
        word[crash.item] = crash.value;
        *age = crash.age;
        told++;
    }
    return told;
}

/* Each register gets a value of its own, those from `first` to r7 are pushed, and an instruction is
 * met that there is not. */
static void check_processor_fault(unsigned first)
{
    const uint16_t code[] = {0x2010, 0x2121, 0x2232, 0x2343, 0x2454, 0x2565, 0x2676,
                             0x2787, /* movs r0..r7, #... */
                             /* mov r8, r4; r9, r5; r10, r6; r11, r7; r12, r0 */
                             0x46a0, 0x46a9, 0x46b2, 0x46bb, 0x4684,
                             (uint16_t)(0xb400u | (0xffu << first & 0xffu)), UNDEFINED};
    static const uint32_t expected[13] = {0x10, 0x21, 0x32, 0x43, 0x54, 0x65, 0x76,
                                          0x87, 0x54, 0x65, 0x76, 0x87, 0x10};
    uint16_t before[COUNT_OF(code)];
    uint32_t word[MR_CRASH_ITEM_COUNT] = {0};
    uint16_t age = 99;
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("healthlink_send_regular");
    ear_until(ear, 0.6);
    /* the newest told: up to 100 before */
    uint32_t block = GET(ear, EAR_SERIAL, clock, CLOCK).block;
    patch(ear, place, code, COUNT_OF(code), before);
    double reset_s = until_reset(ear, 0.003); /* the next block, and 13 us to write it down */
    patch(ear, place, before, COUNT_OF(code), NULL);
    assert_int_equal(hil_board_counters(ear->board)->last_fault_pc,
                     place + 2 * (COUNT_OF(code) - 1));
    ear->listens = true;
    ear_until(ear, reset_s + 0.1);
    assert_int_equal(take_crash(ear, EAR_CAN, word, &age), MR_CRASH_ITEM_COUNT);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), MR_CRASH_ITEM_COUNT);
    assert_int_equal(age, 0);
    assert_int_equal(word[MR_CRASH_KIND], MR_CRASH_USAGE);
    for (unsigned i = 0; i < 13; i++)
        assert_int_equal(word[MR_CRASH_R0 + i], expected[i]);
    assert_int_equal(word[MR_CRASH_PC], place + 2 * (COUNT_OF(code) - 1));
    assert_int_equal(word[MR_CRASH_CFSR], 1u << 16); /* UNDEFINSTR: PM0214 4.4.10 */
    /* FORCED: the handler of usage faults is off */
    assert_int_equal(word[MR_CRASH_HFSR], 1u << 30);
    assert_int_equal(word[MR_CRASH_EXCEPTION], 3);
    assert_int_equal(word[MR_CRASH_XPSR] & 0x1ffu, 0); /* in the main loop */
    assert_int_equal(word[MR_CRASH_TASK], MR_TASK_TELEMETRY);
    assert_in_range(word[MR_CRASH_BLOCK], block, block + 101);
    assert_in_range(word[MR_CRASH_SP], symbol("stack_bottom"), symbol("stack_top"));
    /* the processor aligns its frame to 8 bytes: PM0214 2.3.7 */
    assert_int_equal(word[MR_CRASH_XPSR] >> 9 & 1u, first % 2);
    for (unsigned i = 0; first + i < 8; i++)
        assert_int_equal(word[MR_CRASH_STACK_FIRST + i], expected[first + i]);
    assert_int_equal(word[MR_CRASH_IMAGE], GET(ear, EAR_CAN, board_image, BOARD_IMAGE).image_crc);
    ear_until(ear, reset_s + 0.5);
    assert_int_equal(ear->fault[MR_FAULT_HARD_FAULT].detail, MR_CRASH_USAGE);
    assert_int_equal(ear->fault[MR_FAULT_HARD_FAULT].count, 1);

    /* again on command, and after a restart that somebody asked for: then only on command, as an
     * old one */
    assert_int_equal(answer(ear, MR_COMMAND_STATE, 1), MR_OK);
    ear_until(ear, now_s(ear) + 0.2);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), 2 * MR_CRASH_ITEM_COUNT);
    assert_int_equal(answer(ear, MR_COMMAND_RESET, 2), MR_OK);
    until_reset(ear, 0.1);
    ear_until(ear, now_s(ear) + 0.5);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), 2 * MR_CRASH_ITEM_COUNT);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), 0);
    assert_int_equal(answer(ear, MR_COMMAND_STATE, 3), MR_OK);
    ear_until(ear, now_s(ear) + 0.2);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), 3 * MR_CRASH_ITEM_COUNT);
    assert_int_equal(age, 1);
    assert_int_equal(word[MR_CRASH_PC], place + 2 * (COUNT_OF(code) - 1));
    ear_close(ear);
}

/* Four words on the stack, and five, which leave it unaligned. */
TEST(a_processor_fault_leaves_its_registers_and_stack)
{
    check_processor_fault(4);
    check_processor_fault(3);
}

/* A power cut ends the memory of it: noise in RAM is not told as a fault. */
TEST(a_power_cut_forgets_the_fault)
{
    static const uint16_t code[] = {UNDEFINED};
    uint16_t before[1];
    uint32_t word[MR_CRASH_ITEM_COUNT];
    uint16_t age;
    struct ear *ear = ear_open(NULL, 0);
    uint32_t place = symbol("healthlink_send_regular");
    ear_until(ear, 0.6);
    patch(ear, place, code, 1, before);
    until_reset(ear, 0.003);
    patch(ear, place, before, 1, NULL);
    ear_until(ear, 1.0);
    hil_supply_cut(&ear->board->supply);
    ear->listens = true;
    ear_until(ear, 1.5);
    assert_int_equal(answer(ear, MR_COMMAND_STATE, 1), MR_OK);
    ear_until(ear, 2.5);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), 0);
    assert_int_equal(GET(ear, EAR_SERIAL, restarts, RESTARTS).restarts, 0);
    ear_close(ear);
}

/* ---- memories ---- */

/* One bit of RAM that sticks is found within a round of the idle board: 3 s for each 16 KiB, 21 s
 * in all. */
TEST(a_stuck_bit_of_ram_is_found)
{
    static const char *const places[] = {"config+100 7 1", "app+3000 30 0"};
    for (unsigned i = 0; i < COUNT_OF(places); i++) {
        struct ear *ear = ear_open(NULL, 0);
        char order[80];
        ear_until(ear, 1.0);
        snprintf(order, sizeof order, "at 1.1 stick %s", places[i]);
        ear_order(ear, order);
        ear_until(ear, 1.1 + 21.0);
        assert_int_equal(ear->fault[MR_FAULT_SELFTEST].detail, MR_SELF_TEST_RAM);
        assert_int_equal(ear_faults(ear, EAR_CAN), EAR_BIT(SELFTEST));
        ear_close(ear);
    }
}

TEST(buffers_of_dma_are_tested_at_start)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.3 stick adc1_code+5 3 1");
    ear_until(ear, 0.35);
    assert_int_equal(answer(ear, MR_COMMAND_RESET, 2), MR_OK);
    double reset_s = until_reset(ear, 0.1);
    ear_until(ear, reset_s + 0.5);
    assert_int_equal(ear->fault[MR_FAULT_SELFTEST].detail, MR_SELF_TEST_RAM);
    ear_close(ear);
}

/* A bit of the program turns over: found within two rounds of its checksum, 2 x 20 s, and stays
 * found. */
TEST(a_changed_program_is_found)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 1 flip limit_ticks+1 0"); /* a limit of 0.20 s becomes 0.21 s */
    ear_until(ear, 41.0);
    assert_int_equal(ear->fault[MR_FAULT_SELFTEST].detail, MR_SELF_TEST_FLASH);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), EAR_BIT(SELFTEST));
    ear_close(ear);
}

/* Sound memories are gone through again and again, without a fault; the stack never goes deeper
 * than the call graph allows. */
TEST(sound_memories_pass_and_the_stack_fits)
{
    unsigned bound = 0, size = 0;
    char line[256];
    FILE *file = fopen("build/firmware/stack.txt", "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        (void)(sscanf(line, "worst case %u bytes of %u", &bound, &size) == 2);
    fclose(file);
    struct ear *ear = ear_open(NULL, 5);
    ear_until(ear, ear->run.duration_s + 46.0);
    struct mr_upkeep upkeep = GET(ear, EAR_SERIAL, upkeep, UPKEEP);
    print_message("# stack %u bytes used of %u, bound %u; RAM tested %u times, program %u times\n",
                  upkeep.stack_used, upkeep.stack_size, bound, upkeep.ram_tested,
                  upkeep.flash_checked);
    assert_int_equal(upkeep.stack_size, size);
    assert_in_range(upkeep.stack_used, 800, bound);
    assert_true(upkeep.ram_tested >= 2);
    assert_true(upkeep.flash_checked >= 1);
    assert_int_equal(ear_faults(ear, EAR_SERIAL), 0);
    ear_close(ear);
}

/* ---- the command self-test ---- */

#define ALL_TESTS 0x7fu

static struct mr_self_test self_test(struct ear *ear, double within_s)
{
    assert_int_equal(answer(ear, MR_COMMAND_SELF_TEST, 321), MR_OK);
    until_heard(ear, EAR_SERIAL, MR_ID_SELF_TEST, within_s);
    struct mr_self_test result = GET(ear, EAR_SERIAL, self_test, SELF_TEST);
    assert_int_equal(result.tag, 321);
    return result;
}

TEST(a_sound_board_passes_its_self_test)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 2.0);
    assert_true(hil_board_pin_level(ear->board, PE, 0));
    assert_int_equal(answer(ear, MR_COMMAND_SELF_TEST, 321), MR_OK);
    double lit_s = now_s(ear);
    unsigned heard = ear->heard[EAR_CAN][MR_ID_SELF_TEST];
    assert_false(hil_board_pin_level(ear->board, PE, 0));
    while (!hil_board_pin_level(ear->board, PE, 0))
        ear_until(ear, now_s(ear) + 1e-3);
    assert_near(now_s(ear) - lit_s, 0.2, 0.015);
    while (ear->heard[EAR_CAN][MR_ID_SELF_TEST] == heard && now_s(ear) < lit_s + 1.0)
        ear_until(ear, now_s(ear) + 1e-3);
    print_message("# self-test done after %.3f s\n", now_s(ear) - lit_s);
    struct mr_self_test result = GET(ear, EAR_CAN, self_test, SELF_TEST);
    assert_int_equal(result.done & ALL_TESTS, ALL_TESTS);
    assert_int_equal(result.failed, 0);
    ear_until(ear, now_s(ear) + 0.2);
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    ear_close(ear);
}

TEST(a_self_test_names_what_fails)
{
    static const struct {
        const char *order;
        unsigned which;
    } cases[] = {
        {"at 2 lamp broken", MR_SELF_TEST_LAMP_ON},
        {"at 2 lamp shorted", MR_SELF_TEST_LAMP_OFF},
        {"at 2 reference open", MR_SELF_TEST_REFERENCE},
        {"at 2 nor dead", MR_SELF_TEST_NOR},
        {"at 2 stick config+200 0 1", MR_SELF_TEST_RAM},
        {"at 2 flip limit_ticks+1 0", MR_SELF_TEST_FLASH}, /* and so IMAGE */
        {"at 2 transducer 1 open\nat 2 transducer 2 open\nat 2 transducer 3 open\nat 2 transducer "
         "4 open\n"
         "at 2 transducer 5 open\nat 2 transducer 6 open\nat 2 transducer 7 open\nat 2 transducer "
         "8 open",
         MR_SELF_TEST_EXCITATION},
    };
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        struct ear *ear = ear_open(NULL, 0);
        ear_order(ear, cases[i].order);
        ear_until(ear, 2.01);
        struct mr_self_test result = self_test(ear, 1.0);
        unsigned failed = 1u << cases[i].which;
        if (cases[i].which == MR_SELF_TEST_FLASH)
            failed |= 1u << MR_SELF_TEST_IMAGE;
        if ((result.done & ALL_TESTS) != ALL_TESTS || result.failed != failed)
            fail_msg("%s: done 0x%x, failed 0x%x", cases[i].order, result.done, result.failed);
        ear_until(ear, now_s(ear) + 0.15);
        assert_true(ear_faults(ear, EAR_SERIAL) & EAR_BIT(SELFTEST));
        ear_close(ear);
    }
}

/* Reset and self-test keep off a landing; arming ends a self-test, and the lamp with it. */
TEST(a_landing_is_not_disturbed)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 3.0);
    assert_int_equal(answer(ear, MR_COMMAND_SELF_TEST, 1), MR_OK);
    assert_int_equal(answer(ear, MR_COMMAND_SELF_TEST, 2), MR_WAIT);
    ear_until(ear, 3.05);
    assert_false(hil_board_pin_level(ear->board, PE, 0));
    assert_int_equal(answer(ear, MR_COMMAND_ARM, 3), MR_OK);
    ear_until(ear, now_s(ear) + 0.05);
    assert_true(hil_board_pin_level(ear->board, PE, 0));
    assert_int_equal(GET(ear, EAR_SERIAL, self_test, SELF_TEST).tag, 1);
    assert_int_equal(GET(ear, EAR_SERIAL, self_test, SELF_TEST).done & 1u << MR_SELF_TEST_LAMP_OFF,
                     0);
    assert_int_equal(answer(ear, MR_COMMAND_SELF_TEST, 4), MR_NOT_NOW);
    assert_int_equal(answer(ear, MR_COMMAND_RESET, 5), MR_NOT_NOW);
    ear_until(ear, now_s(ear) + 0.5);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    assert_true(hil_board_pin_level(ear->board, PE, 0));
    assert_int_equal(answer(ear, MR_COMMAND_DISARM, 6), MR_OK);
    assert_int_equal(answer(ear, MR_COMMAND_RESET, 7), MR_OK);
    double asked_s = now_s(ear);
    assert_true(until_reset(ear, 0.1) - asked_s < 0.06);
    ear_until(ear, now_s(ear) + 0.8);
    assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause, 2 | 4); /* pin, software */
    ear_close(ear);
}

/* ---- the warning output is fail-safe ---- */

TEST(a_dead_board_warns)
{
    struct ear *ear = ear_open(NULL, 0);
    double boots_s = 0.0;
    while (hil_rig_has_lamp_current(&ear->board->rig) && boots_s < 0.1) {
        /* from power on until it is known to be well */
        boots_s += 1e-3;
        ear_until(ear, boots_s);
    }
    print_message("# warns for %.0f ms of its start\n", 1e3 * boots_s);
    assert_in_range((unsigned)(1e6 * boots_s), 5000, 20000);
    ear_order(ear, "at 0.5 power-cut 30\nat 1.0 crystal stop");
    ear_until(ear, 0.499);
    assert_false(hil_rig_has_lamp_current(&ear->board->rig));
    ear_until(ear, 0.501);
    assert_true(hil_rig_has_lamp_current(&ear->board->rig)); /* no supply */
    ear_until(ear, 0.56);
    assert_false(hil_rig_has_lamp_current(&ear->board->rig));
    ear_until(ear, 1.01);
    assert_true(hil_rig_has_lamp_current(&ear->board->rig)); /* reset, and starting */
    ear_until(ear, 1.1);
    assert_false(hil_rig_has_lamp_current(&ear->board->rig));
    ear_close(ear);
}

/* ---- CAN ---- */

static struct mr_can_alarm can_alarm(const struct ear *ear, unsigned link)
{
    return GET(ear, link, can_alarm, CAN_ALARM);
}

/* Unplugged: told on serial within 30 ms as what it is, with TEC 128 and never bus-off. Plugged in
 * again: the alarm is the first frame, within 0.7 ms; 20 ms later the board has said how long it
 * was and what was dropped, and the counts agree. */
TEST(an_unplugged_cable_is_told_apart)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    ear_order(ear, "at 0.7 bus unplug\nat 3.7 bus connect");
    ear_until(ear, 0.7);
    double told_s = until_heard(ear, EAR_SERIAL, MR_ID_CAN_ALARM, 0.1);
    /* error passive, then nothing passes */
    while (can_alarm(ear, EAR_SERIAL).state != MR_CAN_UNPLUGGED && now_s(ear) < 0.9)
        told_s = until_heard(ear, EAR_SERIAL, MR_ID_CAN_ALARM, 0.1);
    print_message("# unplugged told after %.0f ms\n", 1e3 * (told_s - 0.7));
    assert_true(told_s < 0.7 + 0.05);
    assert_int_equal(can_alarm(ear, EAR_SERIAL).state, MR_CAN_UNPLUGGED);
    ear_until(ear, 3.69);
    assert_int_equal(can_alarm(ear, EAR_SERIAL).tec, 128);
    assert_int_equal(can_alarm(ear, EAR_SERIAL).last_error, 3);
    assert_false(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CAN_BUS_OFF));
    assert_int_equal(ear->fault[MR_FAULT_CAN_PASSIVE].count, 1);
    unsigned frames = ear->can_frames, alarms = ear->heard[EAR_CAN][MR_ID_CAN_ALARM];
    ear_until(ear, 3.7007);
    assert_int_equal(ear->can_frames, frames + 1);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_CAN_ALARM], alarms + 1); /* the first */
    ear_until(ear, 3.72);
    struct mr_can_alarm alarm = can_alarm(ear, EAR_CAN);
    struct mr_can_drops drops = GET(ear, EAR_CAN, can_drops, CAN_DROPS);
    assert_true(alarm.state == MR_CAN_GOOD || alarm.state == MR_CAN_WARNING);
    assert_int_equal(alarm.outages, 1);
    assert_near(alarm.outage_s, 3.0, 0.03);
    assert_int_equal(drops.queue_full + drops.bus_off + drops.silent, 0);
    assert_true(drops.timeout > 100);
    ear_until(ear, 4.5);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    drops = GET(ear, EAR_CAN, can_drops, CAN_DROPS);
    assert_int_equal(GET(ear, EAR_CAN, can_health, CAN_HEALTH).dropped, drops.timeout);
    ear_close(ear);
}

/* For less than 0.1 s: nothing is dropped. */
TEST(a_connector_that_bounces_loses_nothing)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    assert_int_equal(answer(ear, MR_COMMAND_ARM, 1), MR_OK); /* 2000 frames a second */
    ear_order(ear, "at 1 bus unplug\nat 1.06 bus connect\nat 1.3 bus unplug\nat 1.36 bus connect");
    ear_until(ear, 2.5);
    struct mr_can_drops drops = GET(ear, EAR_CAN, can_drops, CAN_DROPS);
    assert_int_equal(drops.queue_full + drops.bus_off + drops.timeout, 0);
    assert_int_equal(can_alarm(ear, EAR_CAN).outages, 2);
    assert_near(can_alarm(ear, EAR_CAN).outage_s, 0.06, 0.02);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* Wires touch: bus-off told on serial within 30 ms; at most ten tries a second of 32 destroyed
 * frames each; apart again: back within 0.12 s, with the alarm. */
TEST(bus_off_is_left_at_a_bounded_rate)
{
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    uint64_t errors = hil_board_counters(ear->board)->can_errors;
    ear_order(ear, "at 0.7 bus short\nat 2.7 bus connect");
    ear_until(ear, 0.7);
    while (can_alarm(ear, EAR_SERIAL).state != MR_CAN_OFF)
        until_heard(ear, EAR_SERIAL, MR_ID_CAN_ALARM, 0.1);
    print_message("# bus-off told after %.0f ms\n", 1e3 * (now_s(ear) - 0.7));
    assert_true(now_s(ear) < 0.7 + 0.06);
    ear_until(ear, 2.69);
    unsigned tries = (unsigned)(hil_board_counters(ear->board)->can_errors - errors) / 32u;
    assert_in_range(tries, 10, 22);
    assert_int_equal(can_alarm(ear, EAR_SERIAL).state, MR_CAN_OFF);
    assert_in_range(ear->fault[MR_FAULT_CAN_BUS_OFF].count, 1, tries);
    unsigned alarms = ear->heard[EAR_CAN][MR_ID_CAN_ALARM];
    ear_until(ear, 2.7 + 0.14);
    assert_true(ear->heard[EAR_CAN][MR_ID_CAN_ALARM] >= alarms + 2);
    assert_near(can_alarm(ear, EAR_CAN).outage_s, 2.05, 0.09);
    struct mr_can_drops drops = GET(ear, EAR_CAN, can_drops, CAN_DROPS);
    assert_true(drops.bus_off > 50);
    assert_int_equal(drops.timeout + drops.queue_full, 0);
    ear_until(ear, 3.5);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    ear_close(ear);
}

/* Each cause of a drop has its own count. */
TEST(drops_are_counted_by_cause)
{
    struct hil_options options = ear_options();
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    assert_int_equal(answer(ear, MR_COMMAND_ARM, 1), MR_OK);
    ear_order(ear, "at 1 bus unplug\nat 1.5 bus connect");
    ear_until(ear, 1.0);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_STATE, 0, 9); /* two frames more for each block */
    ear_until(ear, 2.5);
    struct mr_can_drops drops = GET(ear, EAR_CAN, can_drops, CAN_DROPS);
    assert_true(drops.queue_full > 0);
    assert_true(drops.timeout >= 256);
    assert_int_equal(drops.bus_off + drops.silent, 0);
    assert_int_equal(GET(ear, EAR_CAN, can_health, CAN_HEALTH).dropped,
                     drops.queue_full + drops.timeout);
    assert_int_equal(ear->can_sent, ear->can_at_health);
    assert_int_equal(ear->fault[MR_FAULT_CAN_QUEUE_FULL].count, drops.queue_full);
    ear_close(ear);

    options.hse_hz = 0;
    ear = ear_open(&options, 0);
    ear_until(ear, 1.5);
    assert_int_equal(can_alarm(ear, EAR_SERIAL).state, MR_CAN_SILENT);
    assert_true(GET(ear, EAR_SERIAL, can_drops, CAN_DROPS).silent > 100);
    assert_int_equal(ear->can_frames, 0);
    ear_close(ear);
}

/* ---- supply and clock ---- */

/* The level of the option bytes is told (0 off, as delivered); a dip below it resets at once, and
 * the board speaks 30 ms after the supply is back. RAM stays, and no restart is held against the
 * firmware. */
TEST(the_brown_out_level_is_told)
{
    /* RM0090 3.9.10 */
    static const struct {
        uint32_t bits;
        unsigned level;
    } cases[] = {{3, 0}, {2, 1}, {1, 2}, {0, 3}};
    for (unsigned i = 0; i < COUNT_OF(cases); i++) {
        struct ear *ear = ear_open(NULL, 0);
        ear->board->state.mcu.flash.option_bytes =
            (ear->board->state.mcu.flash.option_bytes & ~0xcu) | cases[i].bits << 2;
        hil_supply_cut(&ear->board->supply); /* the options are loaded when power comes */
        ear_until(ear, 0.6);
        assert_int_equal(GET(ear, EAR_CAN, restarts, RESTARTS).brown_out, cases[i].level);
        if (cases[i].level == 3) {
            ear_order(ear, "at 0.7 brown-out 2.6 5");
            /* the reset ends when the supply is back */
            assert_true(until_reset(ear, 0.2) < 0.7061);
            until_heard(ear, EAR_CAN, MR_ID_HELLO, 0.03);
            ear_until(ear, 1.5);
            assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause, 2 | 32);
            assert_int_equal(GET(ear, EAR_CAN, restarts, RESTARTS).restarts, 0);
        }
        ear_close(ear);
    }
}

/* The crystal stops: reset within 0.2 ms, on the internal oscillator it speaks 0.1 s later (most of
 * it waits for the crystal), with what was running when it stopped. */
TEST(clock_security_tells_where)
{
    uint32_t word[MR_CRASH_ITEM_COUNT] = {0};
    uint16_t age;
    struct ear *ear = ear_open(NULL, 0);
    ear_until(ear, 0.6);
    ear_order(ear, "at 0.7 crystal stop");
    assert_true(until_reset(ear, 0.2) < 0.7003);
    ear->listens = true;
    double speaks_s = until_heard(ear, EAR_SERIAL, MR_ID_HELLO, 0.1);
    print_message("# speaks %.0f ms after the crystal stopped\n", 1e3 * (speaks_s - 0.7));
    ear_until(ear, 1.0);
    assert_int_equal(take_crash(ear, EAR_SERIAL, word, &age), MR_CRASH_ITEM_COUNT);
    assert_int_equal(word[MR_CRASH_KIND], MR_CRASH_CRYSTAL);
    assert_int_equal(word[MR_CRASH_EXCEPTION], 2); /* NMI */
    ear_close(ear);
}
