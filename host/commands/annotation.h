/* Notes and author names that people add to landings, series and advice, as the campaign stores
 * them. */
#ifndef MATRIG_HOST_COMMANDS_ANNOTATION_H
#define MATRIG_HOST_COMMANDS_ANNOTATION_H

#include <stddef.h>

/* The author of a note: `who`, the value of --who, which is checked. If it is NULL, $USER or else
 * the login name, or "" if both are unknown. The caller does not free the text. */
const char *annotation_author(const char *who);
/* Copies the text into `into`, cut to `size` bytes. A NULL text is copied as "". */
void annotation_copy(char *into, size_t size, const char *text);
/* Returns the text, or "-" if it is empty. */
const char *text_or_dash(const char *text);

#endif
