/* A table of numbers as other programs write it, by a mapping. Pure. */
#ifndef MATRIG_HOST_IMPORT_CSV_H
#define MATRIG_HOST_IMPORT_CSV_H

#include "host/import/mapping.h"
#include "host/import/textfile.h"

/* Fills the series of the mapping's channels. A line that is no row is passed over; the verdict
 * names the first. MR_MALFORMED: a column is not there, no row is good, or more than one in ten is
 * not. `rows`: taken. */
enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct verdict *verdict, struct error *error);

#endif
