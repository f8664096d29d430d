/* Text in lines that fit a terminal. */
#ifndef MATRIG_HOST_BASE_WRAP_H
#define MATRIG_HOST_BASE_WRAP_H

#include <stddef.h>
#include <stdio.h>

/* The words of `text`, a blank between two, and a newline at the end. `column` characters stand in
 * the first line already; the others begin after `indent` blanks, and so does the first one when
 * `column` is 0. A word that is longer than a line has one of its own. Counts characters of
 * UTF-8. */
void wrap_print(const char *text, size_t column, size_t indent, size_t width, FILE *out);
/* Characters, not bytes. */
size_t wrap_width(const char *text, size_t bytes);

#endif
