#include "firmware/canwatch.h"

#include <string.h>

#define LEC_NO_ACKNOWLEDGE  3u
#define ERROR_WARNING_COUNT 96u
#define OUTAGE_TICKS_MAX    65534u

static void add_saturating(uint16_t *counter, uint32_t more)
{
    *counter = more > (uint32_t)(UINT16_MAX - *counter) ? UINT16_MAX : (uint16_t)(*counter + more);
}

void canwatch_start(struct canwatch *watch, bool silent)
{
    memset(watch, 0, sizeof *watch);
    watch->is_silent = silent;
    watch->state = silent ? MR_CAN_SILENT : MR_CAN_GOOD;
}

static enum mr_can_state find_state(const struct canwatch *watch)
{
    const struct board_can_errors *errors = &watch->errors;
    bool stalled = watch->stalled_ticks >= CANWATCH_OUTAGE_TICKS || watch->phase != CANWATCH_UP;
    if (errors->is_missing)
        return MR_CAN_MISSING;
    if (errors->is_bus_off)
        return MR_CAN_OFF;
    if (stalled && watch->state == MR_CAN_OFF)
        /* stay off until a frame has been sent: on a shorted bus, bus-off ends and begins again */
        return MR_CAN_OFF;
    if (stalled)
        return errors->is_passive && errors->last_error == LEC_NO_ACKNOWLEDGE ? MR_CAN_UNPLUGGED
                                                                              : MR_CAN_STUCK;
    if (errors->is_passive)
        return MR_CAN_PASSIVE;
    return errors->tec >= ERROR_WARNING_COUNT || errors->rec >= ERROR_WARNING_COUNT ? MR_CAN_WARNING
                                                                                    : MR_CAN_GOOD;
}

static bool is_outage(enum mr_can_state state)
{
    return state == MR_CAN_UNPLUGGED || state == MR_CAN_STUCK || state == MR_CAN_OFF;
}

static uint16_t *get_current_drops(struct canwatch *watch)
{
    return watch->state == MR_CAN_OFF ? &watch->drop_count.bus_off : &watch->drop_count.timeout;
}

/* Handles the frames that wait during an outage: keeps them at first, then drops them. From then on
 * only the alarm frame is sent, to probe the bus. */
static void end_outage(struct canwatch *watch, bool passed, struct canwatch_changes *changes)
{
    switch (watch->phase) {
    case CANWATCH_UP:
        if (watch->stalled_ticks < CANWATCH_STALE_TICKS)
            break;
        board_can_clear();
        watch->phase = CANWATCH_CLEARING;
        break;
    case CANWATCH_CLEARING:
        if (watch->errors.is_pending)
            break;
        watch->phase = CANWATCH_PROBING;
        changes->must_send_probe = true;
        break;
    case CANWATCH_PROBING:
        if (passed)
            watch->phase = CANWATCH_UP;
        break;
    }
}

static void leave_bus_off(struct canwatch *watch)
{
    if (watch->rejoin_ticks)
        watch->rejoin_ticks--;
    if (watch->is_rejoining) { /* one tick has passed, in which the controller has stopped */
        board_can_leave_bus_off(false);
        watch->is_rejoining = false;
    } else if (watch->errors.is_bus_off && !watch->rejoin_ticks) {
        board_can_leave_bus_off(true);
        watch->is_rejoining = true;
        watch->rejoin_ticks = CANWATCH_REJOIN_TICKS;
    }
}

struct canwatch_changes canwatch_tick(struct canwatch *watch)
{
    struct canwatch_changes changes = {0};
    struct board_can_errors before = watch->errors;
    enum mr_can_state state_before = watch->state;
    if (watch->is_silent)
        return changes;
    board_can_get_errors(&watch->errors);
    bool passed = watch->errors.sent_count != watch->sent_count;
    watch->sent_count = watch->errors.sent_count;
    watch->stalled_ticks = passed || !watch->errors.is_pending ? 0 : watch->stalled_ticks + 1;
    add_saturating(get_current_drops(watch), watch->errors.removed_count - watch->removed_count);
    watch->removed_count = watch->errors.removed_count;
    leave_bus_off(watch);
    end_outage(watch, passed, &changes);
    watch->state = find_state(watch);
    changes.has_state_changed = watch->state != state_before;
    changes.has_become_passive = watch->errors.is_passive && !before.is_passive;
    changes.has_become_off = watch->errors.is_bus_off && !before.is_bus_off;
    if (is_outage(watch->state) && !is_outage(state_before)) {
        add_saturating(&watch->outages, 1);
        watch->outage_ticks = CANWATCH_OUTAGE_TICKS;
    } else if (is_outage(watch->state) && watch->outage_ticks < OUTAGE_TICKS_MAX) {
        watch->outage_ticks++;
    }
    changes.has_outage_ended = is_outage(state_before) && !is_outage(watch->state);
    return changes;
}

bool canwatch_is_accepting(struct canwatch *watch)
{
    if (watch->is_silent)
        add_saturating(&watch->drop_count.silent, 1);
    else if (watch->phase != CANWATCH_UP)
        add_saturating(get_current_drops(watch), 1);
    return !watch->is_silent && watch->phase == CANWATCH_UP;
}

void canwatch_count_queue_full(struct canwatch *watch)
{
    add_saturating(&watch->drop_count.queue_full, 1);
}

struct mr_can_alarm canwatch_get_alarm(const struct canwatch *watch)
{
    return (struct mr_can_alarm){.state = (uint8_t)watch->state,
                                 .last_error = watch->errors.last_error,
                                 .tec = watch->errors.tec,
                                 .rec = watch->errors.rec,
                                 .outages = watch->outages,
                                 .outage_s = (float)watch->outage_ticks / 100.0f};
}
