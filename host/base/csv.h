/* Lines of comma-separated values (RFC 4180). */
#ifndef MATRIG_HOST_BASE_CSV_H
#define MATRIG_HOST_BASE_CSV_H

#include <stddef.h>
#include <stdio.h>

/* Writes a cell, quoted where it must be; the caller writes commas and ends of lines. */
void csv_write_cell(FILE *out, const char *text);

/* Splits a line into cells in place, without its end; quoted cells lose their quotes. Returns the
 * number of cells, at most `most`. */
size_t csv_split(char *line, char *cell[], size_t most);

#endif
