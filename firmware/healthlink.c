#include "firmware/healthlink.h"

#include "common/command.h"
#include "firmware/health.h"
#include "firmware/schedule.h"
#include "firmware/tasks.h"

void healthlink_start(struct healthlink *link)
{
    bool good;
    *link = (struct healthlink){.crash_next = MR_CRASH_ITEMS};
    board_restarted(&link->restart);
    if (link->restart.crash && link->restart.crash_age == 0)
        link->crash_next = 0;
    if (board_image_check(&good) && !good)
        health_count(MR_FAULT_SELFTEST, MR_SELF_TEST_IMAGE);
}

void healthlink_tell_crash(struct healthlink *link)
{
    link->crash_next = link->restart.crash ? 0 : MR_CRASH_ITEMS;
}

enum mr_status healthlink_obey(struct healthlink *link, const struct mr_command *command, bool idle)
{
    if (!idle)
        return MR_NOT_NOW;
    if (command->code == MR_COMMAND_SELF_TEST)
        return selftest_begin(&link->test, command->tag);
    link->ticks_to_reset = HEALTHLINK_RESET_TICKS;
    return MR_OK;
}

void healthlink_arm(struct healthlink *link, struct telemetry *telemetry)
{
    struct mr_self_test result;
    if (selftest_stop(&link->test, &result))
        TELL_THIS(telemetry, TO_LINKS, self_test, SELF_TEST, &result);
}

void healthlink_block(struct healthlink *link, const struct mr_block *block)
{
    selftest_block(&link->test, block);
}

static void send_alarm(struct telemetry *telemetry, unsigned sinks)
{
    struct mr_can_alarm alarm = canwatch_alarm(&telemetry->can);
    TELL_THIS(telemetry, sinks, can_alarm, CAN_ALARM, &alarm);
}

static void send_upkeep(struct telemetry *telemetry)
{
    struct board_upkeep upkeep;
    board_upkeep_state(&upkeep);
    struct mr_upkeep message = {.stack_used = upkeep.stack_used,
                                .stack_size = upkeep.stack_size,
                                .ram_tested = upkeep.ram_rounds,
                                .flash_checked = upkeep.flash_rounds};
    TELL_THIS(telemetry, TO_LINKS, upkeep, UPKEEP, &message);
}

static void send_restarts(const struct board_restart *restart, struct telemetry *telemetry)
{
    struct mr_restarts message = {.restarts = restart->restarts,
                                  .in_row = restart->in_row,
                                  .brown_out = restart->brown_out,
                                  .late_task = restart->late_task,
                                  .late_pc = restart->late_pc};
    TELL_THIS(telemetry, TO_LINKS, restarts, RESTARTS, &message);
}

static void send_crash(struct healthlink *link, struct telemetry *telemetry)
{
    struct mr_crash message = {.item = (uint8_t)link->crash_next,
                               .items = MR_CRASH_ITEMS,
                               .age = link->restart.crash_age,
                               .value = link->restart.crash[link->crash_next]};
    TELL_THIS(telemetry, TO_LINKS, crash, CRASH, &message);
    link->crash_next++;
}

void healthlink_regular(struct healthlink *link, struct telemetry *telemetry, uint32_t index)
{
    if (DUE(ALARM, index))
        send_alarm(telemetry, TO_LINKS);
    if (DUE(DROPS, index))
        TELL_THIS(telemetry, TO_LINKS, can_drops, CAN_DROPS, &telemetry->can.drops);
    if (DUE(UPKEEP, index))
        send_upkeep(telemetry);
    if (DUE(RESTARTS, index))
        send_restarts(&link->restart, telemetry);
    if (link->crash_next < MR_CRASH_ITEMS)
        send_crash(link, telemetry);
}

void healthlink_idle(struct healthlink *link)
{
    for (unsigned i = 0; link->test.running && i < HEALTHLINK_SLICES; i++)
        board_upkeep();
}

static void watch_can(struct telemetry *telemetry)
{
    uint8_t payload[MR_MESSAGE_MAX];
    struct canwatch_news news = canwatch_tick(&telemetry->can);
    if (news.passive)
        health_count(MR_FAULT_CAN_PASSIVE, telemetry->can.errors.tec);
    if (news.off)
        health_count(MR_FAULT_CAN_BUS_OFF, telemetry->can.errors.tec);
    if (news.probe) {
        struct mr_can_alarm alarm = canwatch_alarm(&telemetry->can);
        telemetry_probe(telemetry, MR_ID_CAN_ALARM, payload, mr_can_alarm_put(&alarm, payload));
    }
    if (news.back) {
        send_alarm(telemetry, TO_LINKS);
        TELL_THIS(telemetry, TO_LINKS, can_drops, CAN_DROPS, &telemetry->can.drops);
    } else if (news.changed) {
        send_alarm(telemetry, TO_SERIAL);
    }
}

void healthlink_tick(struct healthlink *link, struct telemetry *telemetry, bool idle)
{
    struct mr_self_test result;
    watch_can(telemetry);
    if (selftest_tick(&link->test, &result))
        TELL_THIS(telemetry, TO_LINKS, self_test, SELF_TEST, &result);
    if (idle && !link->test.running && DUE(TESTS, ++link->ticks))
        board_upkeep();
    tasks_done(MR_TASK_UPKEEP);
    if (link->ticks_to_reset && --link->ticks_to_reset == 0 && idle)
        board_reset();
}
