#include "common/fault.h"

const char *mr_fault_text(unsigned fault)
{
    switch (fault) {
#define MR_FAULT_CASE(NAME, number, text) case number: return text;
        MR_FAULT_TABLE(MR_FAULT_CASE)
#undef MR_FAULT_CASE
    default: return "unknown fault";
    }
}
