#include "firmware/healthlink.h"

#include "common/channels.h"
#include "firmware/board.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/schedule.h"

/* ---- self-test ---- */

/* Smallest sum for a transducer with excitation: at its mechanical zero it reads 62 codes, without
 * excitation 0. The sum has four scans of each polarity. */
#define DRIVEN_SUM_MIN (8 * 8)

static void record_result(struct selftest *test, enum mr_self_test_number number, bool good)
{
    if (test->done_tests >> number & 1u)
        return;
    test->done_tests = (uint16_t)(test->done_tests | 1u << number);
    if (good)
        return;
    test->failed_tests = (uint16_t)(test->failed_tests | 1u << number);
    health_count_fault(MR_FAULT_SELFTEST, (uint8_t)number);
}

enum mr_status healthlink_self_test(struct healthlink *link, uint16_t tag)
{
    struct selftest *test = &link->test;
    struct board_background_tests upkeep;
    bool good;
    if (test->is_running)
        return MR_WAIT;
    board_restart_memory_test();
    board_get_background_tests(&upkeep);
    *test = (struct selftest){.is_running = true,
                              .tag = tag,
                              .ram_test_count = upkeep.ram_test_count,
                              .flash_check_count = upkeep.flash_check_count,
                              .polarity_faults = health_get_count(MR_FAULT_POLARITY)};
    if (board_image_check(&good))
        record_result(test, MR_SELF_TEST_IMAGE, good);
    board_set_warning(true);
    return MR_OK;
}

static void check_memories(struct selftest *test)
{
    struct board_background_tests upkeep;
    board_get_background_tests(&upkeep);
    if (upkeep.ram_test_count != test->ram_test_count)
        record_result(test, MR_SELF_TEST_RAM, !upkeep.is_ram_bad);
    if (upkeep.flash_check_count != test->flash_check_count)
        record_result(test, MR_SELF_TEST_FLASH, !upkeep.is_flash_bad);
    enum nor_status nor = config.site[0].black_box ? nor_identify() : NOR_BUSY;
    if (nor != NOR_BUSY)
        record_result(test, MR_SELF_TEST_NOR, nor == NOR_IDLE);
}

static void check_lamp(struct selftest *test)
{
    if (test->ticks == SELFTEST_LAMP_TICKS) {
        record_result(test, MR_SELF_TEST_LAMP_ON, board_has_lamp_current());
        board_set_warning(false);
    } else if (test->ticks == SELFTEST_LAMP_TICKS + SELFTEST_DARK_TICKS) {
        record_result(test, MR_SELF_TEST_LAMP_OFF, !board_has_lamp_current());
    }
}

static bool has_transducers(void)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (config.channel[i].kind == MR_KIND_DISPLACEMENT)
            return true;
    }
    return false;
}

/* Returns the tests that apply to this board and its configuration. */
static uint16_t find_applicable_tests(const struct selftest *test)
{
    unsigned tests = 1u << MR_SELF_TEST_RAM | 1u << MR_SELF_TEST_FLASH |
                     1u << MR_SELF_TEST_REFERENCE | 1u << MR_SELF_TEST_LAMP_ON |
                     1u << MR_SELF_TEST_LAMP_OFF;
    tests |= has_transducers() ? 1u << MR_SELF_TEST_EXCITATION : 0;
    tests |= config.site[0].black_box ? 1u << MR_SELF_TEST_NOR : 0;
    return (uint16_t)(tests | test->done_tests);
}

static void end_self_test(struct selftest *test, struct telemetry *telemetry)
{
    test->is_running = false;
    TELEMETRY_SEND(telemetry, TO_LINKS, self_test, SELF_TEST, .done = test->done_tests,
                   .failed = test->failed_tests, .tag = test->tag);
}

static void tick_self_test(struct selftest *test, struct telemetry *telemetry)
{
    if (!test->is_running)
        return;
    test->ticks++;
    check_lamp(test);
    check_memories(test);
    if (test->done_tests == find_applicable_tests(test) || test->ticks >= SELFTEST_LIMIT_TICKS)
        end_self_test(test, telemetry);
}

void healthlink_on_block(struct healthlink *link, const struct mr_block *block)
{
    struct selftest *test = &link->test;
    if (!test->is_running || test->blocks >= SELFTEST_BLOCKS)
        return;
    test->is_reference_bad |=
        __builtin_isnan(mr_reference_ratio(&config.channel[MR_REFERENCE], block));
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        int difference = (int)block->forward_sum[i] - (int)block->reversed_sum[i];
        if (config.channel[i].kind == MR_KIND_DISPLACEMENT &&
            (difference > DRIVEN_SUM_MIN || difference < -DRIVEN_SUM_MIN))
            test->is_excited = true;
    }
    if (++test->blocks < SELFTEST_BLOCKS)
        return;
    record_result(test, MR_SELF_TEST_REFERENCE, !test->is_reference_bad);
    if (has_transducers())
        record_result(test, MR_SELF_TEST_EXCITATION,
                      test->is_excited &&
                          health_get_count(MR_FAULT_POLARITY) == test->polarity_faults);
}

/* ---- health on the links ---- */

void healthlink_start(struct healthlink *link)
{
    struct board_identity identity;
    *link = (struct healthlink){.next_crash_word = MR_CRASH_ITEM_COUNT};
    board_identify(&identity);
    board_get_restart(&link->restart);
    if (link->restart.crash && link->restart.crash_age == 0)
        link->next_crash_word = 0;
    if (identity.image_state == MR_IMAGE_HEADER_DAMAGED ||
        identity.image_state == MR_IMAGE_PROGRAM_DAMAGED)
        health_count_fault(MR_FAULT_SELFTEST, MR_SELF_TEST_IMAGE);
}

void healthlink_report_crash(struct healthlink *link)
{
    link->next_crash_word = link->restart.crash ? 0 : MR_CRASH_ITEM_COUNT;
}

void healthlink_schedule_restart(struct healthlink *link)
{
    link->ticks_to_reset = HEALTHLINK_RESET_TICKS;
}

void healthlink_arm(struct healthlink *link, struct telemetry *telemetry)
{
    if (link->test.is_running)
        end_self_test(&link->test, telemetry);
}

static void send_alarm(struct telemetry *telemetry, unsigned sinks)
{
    struct mr_can_alarm alarm = canwatch_get_alarm(&telemetry->can);
    TELEMETRY_SEND_MESSAGE(telemetry, sinks, can_alarm, CAN_ALARM, &alarm);
}

static void send_upkeep(struct telemetry *telemetry)
{
    struct board_background_tests upkeep;
    board_get_background_tests(&upkeep);
    TELEMETRY_SEND(telemetry, TO_LINKS, upkeep, UPKEEP, .stack_used = upkeep.stack_used,
                   .stack_size = upkeep.stack_size, .ram_tested = upkeep.ram_test_count,
                   .flash_checked = upkeep.flash_check_count);
}

static void send_restarts(const struct board_restart *restart, struct telemetry *telemetry)
{
    TELEMETRY_SEND(telemetry, TO_LINKS, restarts, RESTARTS, .restarts = restart->restarts,
                   .in_row = restart->consecutive, .brown_out = restart->brown_out,
                   .late_task = restart->late_task, .late_pc = restart->late_pc);
}

static void send_crash(struct healthlink *link, struct telemetry *telemetry)
{
    TELEMETRY_SEND(telemetry, TO_LINKS, crash, CRASH, .item = (uint8_t)link->next_crash_word,
                   .items = MR_CRASH_ITEM_COUNT, .age = link->restart.crash_age,
                   .value = link->restart.crash[link->next_crash_word]);
    link->next_crash_word++;
}

void healthlink_send_regular(struct healthlink *link, struct telemetry *telemetry, uint32_t index)
{
    if (DUE(ALARM, index))
        send_alarm(telemetry, TO_LINKS);
    if (DUE(DROPS, index))
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, can_drops, CAN_DROPS,
                               &telemetry->can.drop_count);
    if (DUE(UPKEEP, index))
        send_upkeep(telemetry);
    if (DUE(RESTARTS, index))
        send_restarts(&link->restart, telemetry);
    if (link->next_crash_word < MR_CRASH_ITEM_COUNT)
        send_crash(link, telemetry);
}

void healthlink_run_idle(struct healthlink *link)
{
    for (unsigned i = 0; link->test.is_running && i < HEALTHLINK_SLICES; i++)
        board_check_memory();
}

static void supervise_can(struct telemetry *telemetry)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    struct canwatch_changes changes = canwatch_tick(&telemetry->can);
    if (changes.has_become_passive)
        health_count_fault(MR_FAULT_CAN_PASSIVE, telemetry->can.errors.tec);
    if (changes.has_become_off)
        health_count_fault(MR_FAULT_CAN_BUS_OFF, telemetry->can.errors.tec);
    if (changes.must_send_probe) {
        struct mr_can_alarm alarm = canwatch_get_alarm(&telemetry->can);
        telemetry_send_probe(telemetry, MR_ID_CAN_ALARM, payload,
                             mr_can_alarm_put(&alarm, payload));
    }
    if (changes.has_outage_ended) {
        send_alarm(telemetry, TO_LINKS);
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, can_drops, CAN_DROPS,
                               &telemetry->can.drop_count);
    } else if (changes.has_state_changed) {
        send_alarm(telemetry, TO_SERIAL);
    }
}

void healthlink_tick(struct healthlink *link, struct telemetry *telemetry, bool idle)
{
    supervise_can(telemetry);
    tick_self_test(&link->test, telemetry);
    if (idle && !link->test.is_running && DUE(TESTS, ++link->ticks))
        board_check_memory();
    tasks_done(MR_TASK_UPKEEP);
    if (link->ticks_to_reset && --link->ticks_to_reset == 0 && idle)
        board_reset();
}
