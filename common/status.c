#include "common/status.h"

const char *mr_status_text(enum mr_status status)
{
    switch (status) {
/* clang-format off */
#define MR_STATUS_CASE(name, value, exit_code, text) case name: return text;
        /* clang-format on */
        MR_STATUS_TABLE(MR_STATUS_CASE)
#undef MR_STATUS_CASE
    }
    return "unknown status";
}

int mr_status_exit_code(enum mr_status status)
{
    switch (status) {
/* clang-format off */
#define MR_STATUS_CASE(name, value, exit_code, text) case name: return exit_code;
        /* clang-format on */
        MR_STATUS_TABLE(MR_STATUS_CASE)
#undef MR_STATUS_CASE
    }
    return 3;
}
