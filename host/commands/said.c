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

json_t *said_json(const char *text)
{
    return text[0] ? json_string(text) : json_null();
}

void said_answer(struct answer *answer, const char *name, const char *label, const char *text)
{
    if (text[0])
        answer_words(answer, name, label, "%s", text);
    else
        answer_none(answer, name, label, "-");
}
