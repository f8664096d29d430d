/* Texts that people add to landings, series and advice, as the campaign keeps them. */
#ifndef MATRIG_HOST_COMMANDS_ANNOTATION_H
#define MATRIG_HOST_COMMANDS_ANNOTATION_H

#include <stddef.h>

/* The author: `who`, the value of --who; NULL: $USER, else the login name, "" when that is unknown.
 * Not released. */
const char *annotation_who(const char *who);
/* Copies what fits into `size` bytes; NULL is "". */
void annotation_copy(char *into, size_t size, const char *text);
/* "-" for an empty text. */
const char *text_or_dash(const char *text);

#endif
