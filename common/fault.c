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
