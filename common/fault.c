#include "common/fault.h"

/* case of a switch statement that returns the text of a table row */
#define TEXT(NAME, number, text) \
    case number:                 \
        return text;
#define TEXT_OF_TASK(NAME, number, limit, text) TEXT(NAME, number, text)
#define TEXTS(function, TABLE, row, unknown) \
    const char *function(unsigned number)    \
    {                                        \
        switch (number) {                    \
            TABLE(row)                       \
        default: return unknown;             \
        }                                    \
    }
TEXTS(mr_fault_text, MR_FAULT_TABLE, TEXT, "unknown fault")
TEXTS(mr_crash_kind_text, MR_CRASH_KIND_TABLE, TEXT, "unknown fault")
TEXTS(mr_task_text, MR_TASK_TABLE, TEXT_OF_TASK, "unknown task")
TEXTS(mr_self_test_text, MR_SELF_TEST_TABLE, TEXT, "unknown self-test")
TEXTS(mr_can_state_text, MR_CAN_STATE_TABLE, TEXT, "unknown state")

const char *mr_crash_item_name(unsigned item)
{
    static const char *const names[] = {
#define MR_CRASH_NAME(NAME, text) text,
        MR_CRASH_TABLE(MR_CRASH_NAME)
#undef MR_CRASH_NAME
    };
    if (item < MR_CRASH_STACK_FIRST)
        return names[item];
    return item < MR_CRASH_ITEM_COUNT ? "stack" : "unknown word";
}
