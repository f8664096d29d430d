#include "host/commands/said.h"

#include <stdio.h>
#include <stdlib.h>

const char *said_by(const char *who)
{
    return who ? who : getenv("USER") ? getenv("USER") : "";
}

void said_fill(char *into, size_t size, const char *text)
{
    snprintf(into, size, "%.*s", (int)size - 1, text ? text : "");
}

const char *said_or_dash(const char *text)
{
    return text[0] ? text : "-";
}
