/* A survey as a sheet: CSV in walking order, to be printed and written on, or filled in elsewhere
 * and read in.
 *
 *     kind,line,place,reading_in,previous_in,where,note
 *     gap,1,0,33.512,33.508,"line 1 (...), mats 1 to 10, station 0.0 ft",
 *
 * Read in by the names of its columns: kind, line, place and reading_in or reading_mm are needed,
 * note is taken, others are left. A row without a reading is no reading. */
#ifndef MATRIG_HOST_SURVEY_SHEET_H
#define MATRIG_HOST_SURVEY_SHEET_H

#include <stdio.h>

#include "host/survey/desk.h"

#define SURVEY_NOTE_MAX 200u

struct survey_sheet {
    double value_in[SURVEY_ITEMS_MAX]; /* by place in the plan; NaN: none */
    char note[SURVEY_ITEMS_MAX][SURVEY_NOTE_MAX];
    size_t count;
};

void survey_sheet_write(FILE *out, const struct survey_desk *desk, bool si);
/* MR_IO: cannot be opened; MR_MALFORMED: names line and cause; nothing of it should be taken
 * then. */
enum mr_status survey_sheet_read(const char *path, const struct survey_plan *plan,
                                 struct survey_sheet *sheet, struct error *error);

#endif
