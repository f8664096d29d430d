/* What people say of landings and series: texts as they are kept. */
#ifndef MATRIG_HOST_COMMANDS_SAID_H
#define MATRIG_HOST_COMMANDS_SAID_H

#include <stddef.h>

/* Who says so: `who`, the value of --who; NULL: the user, "" when that is unknown. Not released. */
const char *said_by(const char *who);
/* Copies what fits into `size` bytes; NULL is "". */
void said_fill(char *into, size_t size, const char *text);
/* "-" for nothing. */
const char *said_or_dash(const char *text);

#endif
