/* The application's own health, on a fake board: which task is late, what CAN's state is called,
 * what a self-test concludes. */
#include "tests/firmware/play.h"

#include "common/fault.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "tests/firmware/fake_nor.h"

static void tick_all_but(enum mr_task left_out, unsigned ticks)
{
    for (unsigned i = 0; i < ticks; i++) {
        for (unsigned task = 1; task < MR_TASK_COUNT; task++) {
            if (task != left_out)
                tasks_done((enum mr_task)task);
        }
        tasks_tick(0x08001234);
    }
}

/* Each task has a limit of its own, in ticks: one more is too many, and it is named; when it comes
 * round, that is well again. */
TEST_IN(each_task_has_its_limit, start, NULL)
{
    /* 0.2, 0.3 and 1 s */
    static const unsigned limit[MR_TASK_COUNT] = {0, 20, 30, 30, 30, 30, 30, 20, 100, 30};
    for (unsigned task = 1; task < MR_TASK_COUNT; task++) {
        uint16_t before = health_get_count(MR_FAULT_TASK_LATE);
        tasks_start();
        tasks_begin(MR_TASK_BOX);
        fake.late_task = 99;
        tick_all_but((enum mr_task)task, limit[task]);
        assert_true(tasks_are_healthy());
        assert_int_equal(fake.late_task, 99);
        tick_all_but((enum mr_task)task, 1);
        assert_false(tasks_are_healthy());
        /* when the loop itself stands, it stands in the part that runs */
        assert_int_equal(fake.late_task, task == MR_TASK_LOOP ? MR_TASK_BOX : task);
        assert_int_equal(fake.late_pc, 0x08001234);
        tick_all_but((enum mr_task)task, 300);
        assert_int_equal(health_get_count(MR_FAULT_TASK_LATE), before + 1); /* once */
        tasks_done((enum mr_task)task);
        tasks_tick(0);
        assert_true(tasks_are_healthy());
        assert_int_equal(fake.late_task, 0);
    }
}

TEST_IN(ten_good_seconds_are_noted_once, start, NULL)
{
    tasks_start();
    fake.good_notes = 0;
    tick_all_but((enum mr_task)0, 999);
    assert_int_equal(fake.good_notes, 0);
    tick_all_but((enum mr_task)0, 1000);
    assert_int_equal(fake.good_notes, 1);
    tasks_start(); /* a late task in between: counted anew */
    tick_all_but((enum mr_task)0, 800);
    tick_all_but(MR_TASK_BOX, 150);
    tick_all_but((enum mr_task)0, 998);
    assert_int_equal(fake.good_notes, 1);
    tick_all_but((enum mr_task)0, 2);
    assert_int_equal(fake.good_notes, 2);
}

/* A loop that is driven as main.c drives it is well, with blocks and without. */
TEST_IN(a_living_loop_is_well, start, NULL)
{
    tasks_start();
    for (unsigned i = 0; i < 300; i++) {
        play(10);
        app_supervise(&app);
        tasks_done(MR_TASK_LOOP);
        tasks_tick(0);
        assert_true(tasks_are_healthy());
    }
    for (unsigned i = 0; i < 300; i++) { /* no more blocks */
        app_poll(&app);
        app_supervise(&app);
        tasks_done(MR_TASK_LOOP);
        tasks_tick(0);
        assert_true(tasks_are_healthy());
    }
}

static enum mr_can_state can_state_after(struct board_can_errors errors, unsigned ticks)
{
    struct canwatch watch;
    canwatch_start(&watch, false);
    fake.can_errors = errors;
    for (unsigned i = 0; i < ticks; i++)
        canwatch_tick(&watch);
    memset(&fake.can_errors, 0, sizeof fake.can_errors);
    return watch.state;
}

TEST_IN(the_states_of_can, start, NULL)
{
    assert_int_equal(can_state_after((struct board_can_errors){0}, 5), MR_CAN_GOOD);
    assert_int_equal(can_state_after((struct board_can_errors){.tec = 96}, 5), MR_CAN_WARNING);
    assert_int_equal(can_state_after((struct board_can_errors){.rec = 96}, 5), MR_CAN_WARNING);
    assert_int_equal(
        can_state_after((struct board_can_errors){.tec = 130, .is_passive = true, .last_error = 3},
                        5),
        MR_CAN_PASSIVE);
    assert_int_equal(can_state_after(
                         (struct board_can_errors){
                             .tec = 128, .is_passive = true, .last_error = 3, .is_pending = true},
                         2),
                     MR_CAN_UNPLUGGED);
    assert_int_equal(can_state_after(
                         (struct board_can_errors){
                             .tec = 128, .is_passive = true, .last_error = 5, .is_pending = true},
                         2),
                     MR_CAN_STUCK);
    assert_int_equal(can_state_after((struct board_can_errors){.is_pending = true}, 1),
                     MR_CAN_GOOD);
    assert_int_equal(can_state_after((struct board_can_errors){.is_pending = true}, 2),
                     MR_CAN_STUCK);
    assert_int_equal(can_state_after((struct board_can_errors){.is_bus_off = true}, 1), MR_CAN_OFF);
    assert_int_equal(can_state_after((struct board_can_errors){.is_missing = true}, 1),
                     MR_CAN_MISSING);
}

/* Nothing passes for 0.1 s: what waits is dropped, one frame is left to the controller, and only
 * when it has passed are there more. */
TEST_IN(stale_frames_are_dropped, start, NULL)
{
    struct canwatch watch;
    canwatch_start(&watch, false);
    fake.clears = 0;
    fake.can_errors = (struct board_can_errors){
        .is_passive = true, .last_error = 3, .tec = 128, .is_pending = true};
    for (unsigned i = 0; i < 9; i++)
        assert_false(canwatch_tick(&watch).must_send_probe);
    assert_int_equal(fake.clears, 0);
    assert_true(canwatch_is_accepting(&watch));
    canwatch_tick(&watch);
    assert_int_equal(fake.clears, 1);
    assert_false(canwatch_is_accepting(&watch));
    fake.can_errors.removed_count = 17; /* mailboxes too */
    assert_false(canwatch_tick(&watch).must_send_probe);
    fake.can_errors.is_pending = false;
    assert_true(canwatch_tick(&watch).must_send_probe);
    fake.can_errors.is_pending = true;
    for (unsigned i = 0; i < 88; i++)
        assert_false(canwatch_tick(&watch).has_outage_ended);
    assert_false(canwatch_is_accepting(&watch));
    fake.can_errors = (struct board_can_errors){.removed_count = 17, .sent_count = 1};
    struct canwatch_changes news = canwatch_tick(&watch);
    assert_true(news.has_outage_ended && news.has_state_changed);
    assert_true(canwatch_is_accepting(&watch));
    assert_int_equal(watch.drop_count.timeout, 17 + 2);
    struct mr_can_alarm alarm = canwatch_get_alarm(&watch);
    assert_int_equal(alarm.state, MR_CAN_GOOD);
    assert_int_equal(alarm.outages, 1);
    assert_near(alarm.outage_s, 1.0, 0.011);
    assert_int_equal(fake.clears, 1);
    memset(&fake.can_errors, 0, sizeof fake.can_errors);
}

/* Out of bus-off ten times a second at most. */
TEST_IN(bus_off_is_left_slowly, start, NULL)
{
    struct canwatch watch;
    canwatch_start(&watch, false);
    fake.rejoins = 0;
    fake.can_errors = (struct board_can_errors){.is_bus_off = true, .is_pending = true};
    for (unsigned i = 0; i < 100; i++)
        canwatch_tick(&watch);
    assert_int_equal(fake.rejoins, 10);
    fake.rejoins = 0;
    for (unsigned i = 0; i < 100; i++) { /* it comes and goes at every look */
        fake.can_errors.is_bus_off = i % 2;
        canwatch_tick(&watch);
    }
    assert_in_range(fake.rejoins, 8, 10);
    fake.can_errors.removed_count = 70000;
    canwatch_tick(&watch);
    assert_int_equal(watch.drop_count.bus_off, UINT16_MAX);
    assert_int_equal(watch.state, MR_CAN_OFF); /* until something passes */
    memset(&fake.can_errors, 0, sizeof fake.can_errors);
}

TEST_IN(a_silent_board_counts_what_it_does_not_say, start, NULL)
{
    struct canwatch watch;
    canwatch_start(&watch, true);
    assert_false(canwatch_is_accepting(&watch));
    assert_int_equal(watch.drop_count.silent, 1);
    fake.can_errors.is_bus_off = true;
    assert_false(canwatch_tick(&watch).has_become_off);
    assert_int_equal(watch.state, MR_CAN_SILENT);
    memset(&fake.can_errors, 0, sizeof fake.can_errors);
}

/* Blocks and supervision, 10 blocks a tick, until the self-test has said its result. */
static struct mr_self_test test_until_result(unsigned ticks)
{
    struct mr_self_test result = {0};
    fake.sent_count = 0;
    command("self-test");
    for (unsigned i = 0; i < ticks && !last_frame(MR_ID_SELF_TEST); i++) {
        play(10);
        app_supervise(&app);
    }
    GET_LAST(self_test, SELF_TEST, &result);
    return result;
}

TEST_IN(a_self_test_concludes, start, NULL)
{
    fake_nor_reset();
    struct mr_self_test result = test_until_result(40);
    assert_int_equal(result.done, 0x7f);
    assert_int_equal(result.failed, 0);
    assert_false(fake.warning);
    fake.lamp_broken = true;
    fake.upkeep.is_ram_bad = true;
    fake.upkeep.is_flash_bad = true;
    fake.image_known = fake.image_bad = true;
    fake_nor.present = false;
    result = test_until_result(40);
    assert_int_equal(result.failed, 1u << MR_SELF_TEST_RAM | 1u << MR_SELF_TEST_FLASH |
                                        1u << MR_SELF_TEST_NOR | 1u << MR_SELF_TEST_LAMP_ON |
                                        1u << MR_SELF_TEST_IMAGE);
    assert_int_equal(result.done, 0x17f);
}

/* Without blocks, nobody knows of reference and excitation: they are not done, and the test ends
 * all the same. */
TEST_IN(what_cannot_be_tested_is_not_done, start, NULL)
{
    struct mr_self_test result = {0};
    fake_nor_reset();
    command("self-test");
    play(1);
    for (unsigned i = 0; i < 500 && !last_frame(MR_ID_SELF_TEST); i++) {
        app_poll(&app);
        app_supervise(&app);
    }
    GET_LAST(self_test, SELF_TEST, &result);
    assert_int_equal(result.done & (1u << MR_SELF_TEST_REFERENCE | 1u << MR_SELF_TEST_EXCITATION),
                     0);
    assert_int_equal(result.failed, 0);
}

/* Polarity faults that come meanwhile fail the excitation. */
TEST_IN(a_wrong_polarity_fails_the_excitation, start, NULL)
{
    fake_nor_reset();
    fake.sent_count = 0;
    command("self-test");
    play(10);
    health_count_fault(MR_FAULT_POLARITY, 3);
    struct mr_self_test result = {0};
    for (unsigned i = 0; i < 40 && !last_frame(MR_ID_SELF_TEST); i++) {
        play(10);
        app_supervise(&app);
    }
    GET_LAST(self_test, SELF_TEST, &result);
    assert_int_equal(result.failed, 1u << MR_SELF_TEST_EXCITATION);
}

TEST_IN(a_reset_waits_for_its_answer, start, NULL)
{
    fake_nor.present = false; /* armed without */
    app_start(&app);
    command("reset");
    play(1);
    for (unsigned i = 0; i < 4; i++)
        app_supervise(&app);
    assert_int_equal(fake.resets, 0);
    app_supervise(&app);
    assert_int_equal(fake.resets, 1);
    command("arm 1");
    play(1);
    command("reset");
    play(1);
    struct mr_ack ack;
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    command("disarm"); /* armed while the reset is due: the landing goes first */
    command("reset");
    play(1);
    command("arm 2");
    play(1);
    for (unsigned i = 0; i < 10; i++)
        app_supervise(&app);
    assert_int_equal(fake.resets, 1);
}

/* Words of a fault go out one a block, once; on the command state again; an old one only then. */
TEST_IN(a_crash_is_told, start, NULL)
{
    static uint32_t word[MR_CRASH_ITEM_COUNT] = {3, 77};
    struct mr_crash crash;
    command("state");
    play(50);
    assert_int_equal(count_frames(MR_ID_CRASH), 0); /* there has been none */
    fake.restart = (struct board_restart){.crash = word};
    app_start(&app);
    play(MR_CRASH_ITEM_COUNT + 10);
    assert_int_equal(count_frames(MR_ID_CRASH), MR_CRASH_ITEM_COUNT);
    GET_LAST(crash, CRASH, &crash);
    assert_int_equal(crash.item, MR_CRASH_ITEM_COUNT - 1);
    command("state");
    play(MR_CRASH_ITEM_COUNT + 10);
    assert_int_equal(count_frames(MR_ID_CRASH), 2 * MR_CRASH_ITEM_COUNT);
    fake.restart.crash_age = 4;
    fake.sent_count = 0;
    app_start(&app);
    play(MR_CRASH_ITEM_COUNT + 10);
    assert_int_equal(count_frames(MR_ID_CRASH), 0);
    command("state");
    play(MR_CRASH_ITEM_COUNT + 10);
    assert_int_equal(count_frames(MR_ID_CRASH), MR_CRASH_ITEM_COUNT);
}

/* What is not fitted is not tested: neither excitation nor black box, and a second test at the same
 * time is refused. */
TEST_IN(what_is_not_fitted_is_not_tested, start, NULL)
{
    struct mr_config full = config;
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++)
        config.channel[c].kind = 0;
    config.site[0].black_box = 0;
    start(NULL);
    struct mr_ack ack;
    command("self-test");
    command("self-test");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.tag, 2);
    assert_int_equal(ack.status, MR_WAIT);
    for (unsigned i = 0; i < 40 && !last_frame(MR_ID_SELF_TEST); i++) {
        play(10);
        app_supervise(&app);
    }
    struct mr_self_test result = {0};
    GET_LAST(self_test, SELF_TEST, &result);
    config = full;
    assert_int_equal(result.tag, 1);
    assert_int_equal(result.failed, 0);
    assert_int_equal(result.done, 0x7f & ~(1u << MR_SELF_TEST_EXCITATION | 1u << MR_SELF_TEST_NOR));
}

/* At 0.1 in below its mechanical zero of 50 mV a transducer gives no signal of either polarity: as
 * if none were driven. Beyond it the sign is the other one, and that is a signal. */
TEST_IN(transducers_without_a_signal_fail_the_excitation, start, NULL)
{
    fake_nor_reset();
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        moved_in[i] = -0.1f;
    assert_int_equal(test_until_result(40).failed, 1u << MR_SELF_TEST_EXCITATION);
    moved_in[4] = -0.2f;
    assert_int_equal(test_until_result(40).failed, 0);
}

/* Arming does not wait for it: what was not done by then stays undone, and that is told. */
TEST_IN(arming_breaks_a_self_test_off, start, NULL)
{
    struct mr_self_test result;
    fake_nor.present = false;
    start(NULL);
    command("self-test");
    play(5);
    assert_true(fake.warning); /* the lamp is being tried */
    command("arm 3");
    play(1);
    GET_LAST(self_test, SELF_TEST, &result);
    assert_int_equal(result.done & (1u << MR_SELF_TEST_LAMP_ON | 1u << MR_SELF_TEST_REFERENCE), 0);
    assert_int_equal(app.landing.state, MR_LANDING_ARMED);
    assert_false(fake.warning);
}

TEST_IN(a_landing_armed_meanwhile_keeps_the_board, start, NULL)
{
    fake_nor.present = false;
    start(NULL);
    command("reset");
    command("bootrom");
    command("arm 1");
    play(1);
    for (unsigned i = 0; i < 100; i++) {
        play(10);
        app_supervise(&app);
    }
    assert_int_equal(app.landing.state, MR_LANDING_ARMED);
    assert_int_equal(fake.resets, 0);
    assert_int_equal(fake.rom_entries, 0);
}

/* A program that is not what its header says is a fault from the start on. */
TEST_IN(a_damaged_image_is_a_fault_at_start, start, NULL)
{
    uint16_t before = health_get_count(MR_FAULT_SELFTEST);
    app_start(&app);
    assert_int_equal(health_get_count(MR_FAULT_SELFTEST), before);
    fake.image_state = MR_IMAGE_PROGRAM_DAMAGED;
    app_start(&app);
    assert_int_equal(health_get_count(MR_FAULT_SELFTEST), before + 1);
    unsigned told = 0;
    play(1000); /* each second */
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_fault fault;
        if (fake.sent[i].id == MR_ID_FAULT &&
            mr_fault_get(&fault, fake.sent[i].data, fake.sent[i].length) == MR_OK)
            told += fault.code == MR_FAULT_SELFTEST && fault.detail == MR_SELF_TEST_IMAGE;
    }
    assert_true(told > 0);
}

/* The cable is pulled and plugged in again: one frame asks whether it is back, and when it has
 * passed the alarm is told on CAN. */
TEST_IN(the_alarm_follows_an_outage, start, NULL)
{
    struct mr_can_alarm alarm;
    play(10);
    fake.can_errors = (struct board_can_errors){
        .is_passive = true, .last_error = 3, .tec = 128, .is_pending = true};
    for (unsigned i = 0; i < 20; i++) {
        play(10);
        app_supervise(&app);
    }
    assert_int_equal(app.telemetry.can.state, MR_CAN_UNPLUGGED);
    fake.sent_count = 0;
    fake.can_errors.is_pending = false;
    app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_CAN_ALARM), 1); /* the one that asks */
    assert_int_equal(fake.sent_count, 1);
    fake.can_errors = (struct board_can_errors){.sent_count = 1};
    app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_CAN_ALARM), 2);
    assert_int_equal(count_frames(MR_ID_CAN_DROPS), 1);
    GET_LAST(can_alarm, CAN_ALARM, &alarm);
    assert_int_equal(alarm.state, MR_CAN_GOOD);
    assert_int_equal(alarm.outages, 1);
}

/* Of several tasks that are late the first of the table is named; a loop that stands nowhere known
 * is named itself. */
TEST_IN(of_late_tasks_the_first_is_named, start, NULL)
{
    tasks_start();
    for (unsigned i = 0; i < 120; i++)
        tasks_tick(0x08000000);
    assert_int_equal(fake.late_task, 1);
    tasks_start();
    tasks_begin((enum mr_task)0);
    tick_all_but(MR_TASK_LOOP, 150);
    assert_int_equal(fake.late_task, MR_TASK_LOOP);
    for (unsigned i = 0; i < 600; i++) /* ages end at 255 and do not come round to good */
        tasks_tick(0x08000000);
    assert_false(tasks_are_healthy());
    tasks_begin((enum mr_task)(MR_TASK_COUNT + 5)); /* RAM after power on */
    assert_int_equal(tasks_current(), 0);
    tasks_start();
}

TEST(names_end_where_the_tables_end)
{
    assert_string_equal(mr_crash_item_name(MR_CRASH_PC), "pc");
    assert_string_equal(mr_crash_item_name(MR_CRASH_STACK_FIRST + 3), "stack");
    assert_string_equal(mr_crash_item_name(MR_CRASH_ITEM_COUNT), "unknown word");
    assert_string_equal(mr_crash_kind_text(0), "unknown fault");
    assert_string_equal(mr_task_text(MR_TASK_COUNT), "unknown task");
    assert_string_equal(mr_self_test_text(MR_SELF_TEST_COUNT), "unknown self-test");
    assert_string_equal(mr_can_state_text(MR_CAN_MISSING + 1), "unknown state");
}
