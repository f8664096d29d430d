#include "firmware/health.h"

#include "firmware/board.h"

static volatile struct health_counter counters[MR_FAULT_COUNT];
static volatile uint32_t current_block;

_Static_assert(MR_FAULT_COUNT <= 32, "health.faults has one bit per fault");

void health_count_fault(enum mr_fault_code fault, uint8_t detail)
{
    volatile struct health_counter *counter = &counters[fault];
    if (counter->count < UINT16_MAX)
        counter->count++;
    counter->detail = detail;
    counter->block = current_block;
    counter->changed = 1;
}

void health_set_block(uint32_t block)
{
    current_block = block;
}

uint16_t health_get_count(enum mr_fault_code fault)
{
    return counters[fault].count;
}

uint32_t health_get_block(void)
{
    return current_block;
}

uint32_t health_get_faults(void)
{
    uint32_t faults = 0;
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (counters[i].count)
            faults |= 1u << i;
    }
    return faults;
}

struct health_counter health_get_counter(enum mr_fault_code fault)
{
    volatile struct health_counter *counter = &counters[fault];
    /* Clear the flag first: a fault that an interrupt counts after this is then reported again and
     * not lost. */
    uint8_t changed = counter->changed;
    counter->changed = 0;
    return (struct health_counter){.count = counter->count,
                                   .detail = counter->detail,
                                   .changed = changed,
                                   .block = counter->block};
}

/* ---- tasks ---- */

static const uint8_t limit_ticks[MR_TASK_COUNT] = {
#define LIMIT(NAME, number, limit, text) [number] = (limit),
    MR_TASK_TABLE(LIMIT)
#undef LIMIT
};

static volatile uint8_t age_ticks[MR_TASK_COUNT];
static volatile bool is_any_task_late;
static uint32_t healthy_ticks;

/* Not cleared at start. The complement shows whether the content is valid: at power on, RAM
 * contains random values. */
static volatile struct {
    uint32_t task, complement;
} running_task __attribute__((section(".noinit")));

void tasks_begin(enum mr_task task)
{
    running_task.task = task;
    running_task.complement = ~(uint32_t)task;
}

void tasks_done(enum mr_task task)
{
    age_ticks[task] = 0;
}

enum mr_task tasks_current(void)
{
    uint32_t task = running_task.task;
    return task < MR_TASK_COUNT && running_task.complement == ~task ? (enum mr_task)task
                                                                    : (enum mr_task)0;
}

void tasks_start(void)
{
    for (unsigned task = 0; task < MR_TASK_COUNT; task++)
        age_ticks[task] = 0;
    is_any_task_late = false;
    healthy_ticks = 0;
    tasks_begin(MR_TASK_LOOP);
}

/* Returns the first late task in table order; 0: none is late. */
static unsigned find_late_task(void)
{
    unsigned found = 0;
    for (unsigned task = 1; task < MR_TASK_COUNT; task++) {
        if (age_ticks[task] < UINT8_MAX)
            age_ticks[task]++;
        if (age_ticks[task] > limit_ticks[task] && !found)
            found = task;
    }
    return found;
}

void tasks_tick(uint32_t pc)
{
    unsigned task = find_late_task();
    if (task && !is_any_task_late) {
        /* if the main loop itself is late, the task that is running is the cause */
        unsigned blamed = task == MR_TASK_LOOP && tasks_current() ? (unsigned)tasks_current()
                                                                  : task;
        health_count_fault(MR_FAULT_TASK_LATE, (uint8_t)blamed);
        board_record_late_task((uint8_t)blamed, pc);
    } else if (!task && is_any_task_late) {
        board_record_late_task(0, 0);
    }
    is_any_task_late = task != 0;
    healthy_ticks = is_any_task_late ? 0 : healthy_ticks + 1;
    if (healthy_ticks == TASKS_GOOD_TICKS)
        board_reset_restart_count();
}

bool tasks_are_healthy(void)
{
    return !is_any_task_late;
}
