/* What people say of landings and series: texts as they are kept and shown. */
#ifndef MATRIG_HOST_COMMANDS_SAID_H
#define MATRIG_HOST_COMMANDS_SAID_H

#include <jansson.h>
#include <stddef.h>

#include "host/base/answer.h"

/* Who says so: `who`, the value of --who; NULL: the user, "" when that is unknown. Not released. */
const char *said_by(const char *who);
/* Copies what fits into `size` bytes; NULL is "". */
void said_fill(char *into, size_t size, const char *text);
/* "-" for nothing. */
const char *said_or_dash(const char *text);
/* A string, null for nothing; the caller releases it. */
json_t *said_json(const char *text);
/* The text; for nothing null, and a dash for people. */
void said_answer(struct answer *answer, const char *name, const char *label, const char *text);

#endif
