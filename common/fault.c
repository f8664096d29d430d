#include "common/fault.h"

const char *mr_fault_text(unsigned fault)
{
    switch (fault) {
/* clang-format off */
#define MR_FAULT_CASE(NAME, number, text) case number: return text;
        /* clang-format on */
        MR_FAULT_TABLE(MR_FAULT_CASE)
#undef MR_FAULT_CASE
    default: return "unknown fault";
    }
}

const char *mr_crash_item_name(unsigned item)
{
    static const char *const names[] = {
#define MR_CRASH_NAME(NAME, text) text,
        MR_CRASH_TABLE(MR_CRASH_NAME)
#undef MR_CRASH_NAME
    };
    if (item < MR_CRASH_STACK_FIRST)
        return names[item];
    return item < MR_CRASH_ITEMS ? "stack" : "unknown word";
}

const char *mr_crash_kind_text(unsigned kind)
{
    switch (kind) {
    case MR_CRASH_MEMORY: return "memory fault";
    case MR_CRASH_BUS: return "bus fault";
    case MR_CRASH_USAGE: return "usage fault";
    case MR_CRASH_OTHER: return "processor fault";
    case MR_CRASH_CRYSTAL: return "stop of the crystal";
    case MR_CRASH_UNASKED: return "interrupt that nobody asked for";
    default: return "unknown fault";
    }
}

const char *mr_task_text(unsigned task)
{
    switch (task) {
/* clang-format off */
#define MR_TASK_CASE(NAME, number, limit, text) case number: return text;
        /* clang-format on */
        MR_TASK_TABLE(MR_TASK_CASE)
#undef MR_TASK_CASE
    default: return "unknown task";
    }
}

const char *mr_self_test_text(unsigned test)
{
    switch (test) {
/* clang-format off */
#define MR_SELF_TEST_CASE(NAME, number, text) case number: return text;
        /* clang-format on */
        MR_SELF_TEST_TABLE(MR_SELF_TEST_CASE)
#undef MR_SELF_TEST_CASE
    default: return "unknown self-test";
    }
}

const char *mr_can_state_text(unsigned state)
{
    static const char *const texts[] = {"good",
                                        "many errors",
                                        "error passive",
                                        "nobody acknowledges: unplugged, or no other node",
                                        "nothing passes",
                                        "bus-off",
                                        "silent: the clock is not exact enough",
                                        "missing"};
    return state < sizeof texts / sizeof texts[0] ? texts[state] : "unknown state";
}
