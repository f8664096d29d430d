/* Rows of a table, or frames of a log, whose time lies far from that of the others: one wrong digit
 * of a time makes a record that is hours long. Rows without a pause of STRAY_PAUSE_S are a group; a
 * group is stray when it is small beside the largest. Pure but for its memory. */
#ifndef MATRIG_HOST_IMPORT_STRAY_H
#define MATRIG_HOST_IMPORT_STRAY_H

#include "host/import/mapping.h"
#include "host/import/textfile.h"

#define STRAY_PAUSE_S     60.0
#define STRAY_TIME_MOST_S 1e12 /* beyond the year 30000: no clock shows it */

struct stray {
    struct stray_group {
        double first_s, last_s;
        double before_s;   /* the last but one; first_s when there is one row alone */
        size_t line, rows; /* line: of the first row */
    } * group;
    size_t groups;
};

/* A row's time, later than that of the last one. MR_FULL. */
enum mr_status stray_add(struct stray *stray, double time_s, size_t line);
/* The last row was none. */
void stray_take_back(struct stray *stray);
/* Takes what is stray out of the series of these channels; the verdict names the first and counts
 * all. How many rows. */
size_t stray_cut(const struct stray *stray, struct mapping_channel *channel, size_t channels,
                 struct verdict *verdict);
void stray_free(struct stray *stray);

#endif
