#include "host/commands/annotation.h"

#include <stdio.h>
#include <stdlib.h>

const char *annotation_who(const char *who)
{
    return who ? who : getenv("USER") ? getenv("USER") : "";
}

void annotation_copy(char *into, size_t size, const char *text)
{
    snprintf(into, size, "%.*s", (int)size - 1, text ? text : "");
}

const char *text_or_dash(const char *text)
{
    return text[0] ? text : "-";
}
