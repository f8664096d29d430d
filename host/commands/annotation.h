/* Texts that people add to landings, series and advice, as stored in the campaign. */
#ifndef MATRIG_HOST_COMMANDS_ANNOTATION_H
#define MATRIG_HOST_COMMANDS_ANNOTATION_H

#include <stddef.h>

/* The author: `who`, the value of --who; NULL: $USER, otherwise the login name, or "" if it is
 * unknown. The caller does not free it. */
const char *annotation_author(const char *who);
/* Copies the text, cut to `size` bytes; NULL is copied as "". */
void annotation_copy(char *into, size_t size, const char *text);
/* Returns the text, or "-" if it is empty. */
const char *text_or_dash(const char *text);

#endif
