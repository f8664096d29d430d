/* Lines of comma-separated values (RFC 4180). */
#ifndef MATRIG_HOST_BASE_CSV_H
#define MATRIG_HOST_BASE_CSV_H

#include <stddef.h>
#include <stdio.h>

/* Writes a cell, with quotes if the text needs them. The caller writes commas and ends of lines. */
void csv_write_cell(FILE *out, const char *text);

/* Splits a line in place into cells and removes their quotes and the end of the line. A carriage
 * return before the end stays in its cell, so that no text is lost. Returns the number of cells, at
 * most `most`; 0: a quote is not closed in this line. */
size_t csv_split(char *line, char separator, char *cell[], size_t most);

#endif
