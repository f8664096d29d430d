/* Words as a POSIX shell takes them. */
#ifndef MATRIG_HOST_BASE_SHELL_H
#define MATRIG_HOST_BASE_SHELL_H

#include <stdio.h>

/* The text in quotes, whatever is in it: one word of a shell. */
void shell_quote(FILE *out, const char *text);

#endif
