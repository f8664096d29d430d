#include "host/base/run.h"

#include <errno.h>
#include <stdlib.h>

enum mr_status run_parse(const char *text, int64_t *run, struct error *error)
{
    char *end;
    errno = 0;
    long long value = strtoll(text, &end, 10);
    if (end == text || *end != '\0' || errno != 0 || value < 1)
        return error_set(error, MR_USAGE, "not a RUN: '%s'; write the number of a landing, from 1",
                         text);
    *run = value;
    return MR_OK;
}
