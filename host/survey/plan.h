/* What a gage survey of the mat reads, where, and in which order it is walked (report 2.7.2, 5.3).
 *
 * Gage points are punched into the mats every ten mats along four lines: 12 in from each edge, near
 * the centreline, 36 in left of it. A reading is the distance between two neighbouring points of a
 * line, 33.5 in as designed; its change is what ten joints have opened. Stations are marked every
 * 10 ft beside the runway: how far the mat's mark stands downfield of the station's. For a
 * diagonal lay there are stations at all four lines, their distance from a fixed line beside
 * the runway (across), and seven lines of points at 45 degrees, at right angles to the joints.
 *
 * A plan goes down one line and back up the next, with the stations as they are passed. Pure: no
 * I/O. Inches and feet. */
#ifndef MATRIG_HOST_SURVEY_PLAN_H
#define MATRIG_HOST_SURVEY_PLAN_H

#include <stdbool.h>
#include <stddef.h>

#include "common/closure.h"
#include "host/base/error.h"

#define SURVEY_LINES          4u
#define SURVEY_SPANS          MR_SEGMENTS
#define SURVEY_POINTS         (SURVEY_SPANS + 1u)
#define SURVEY_STATIONS       13u /* 0 to 120 ft */
#define SURVEY_STATION_FT     10.0
#define SURVEY_DIAGONALS      7u
#define SURVEY_DIAGONAL_SPANS 7u /* 14 ft of width at 45 degrees are 7 spans of 33.5 in */
#define SURVEY_ITEMS_MAX                                    \
    (SURVEY_LINES * (SURVEY_SPANS + 2u * SURVEY_STATIONS) + \
     SURVEY_DIAGONALS * SURVEY_DIAGONAL_SPANS)

#define SURVEY_SPAN_FT        (MR_MATS_PER_SEGMENT * 2.0 / 7.0) /* ten mats */
#define SURVEY_WIDTH_IN       168.0                             /* about 14 ft (report 2.6) */
#define SURVEY_SPACING_IN     33.5                              /* between gage points */
#define SURVEY_JOINT_IN       0.036 /* designed movement of a joint (report 2.7.2) */
/* more than ten joints can do */
#define SURVEY_SPAN_CHANGE_IN (SURVEY_JOINT_IN * MR_MATS_PER_SEGMENT)
#define SURVEY_MOVE_IN        1.0 /* of a station between two surveys: beyond it, asked again */

enum survey_kind { SURVEY_GAP, SURVEY_STATION, SURVEY_ACROSS, SURVEY_DIAGONAL, SURVEY_KINDS };
enum survey_pattern { SURVEY_STANDARD, SURVEY_PATTERN_DIAGONAL };
enum survey_edges { SURVEY_EDGE_LEFT, SURVEY_EDGE_BOTH, SURVEY_EDGE_NONE };

struct survey_item {
    enum survey_kind kind;
    /* from 1: left edge, 36 in left of the centreline, near it, right edge; of the 45 degree lines
     * from upfield on */
    unsigned line;
    unsigned place; /* span or station, from 0 */
};

struct survey_plan {
    enum survey_pattern pattern;
    size_t count;
    struct survey_item item[SURVEY_ITEMS_MAX];
};

void survey_plan_make(struct survey_plan *plan, enum survey_pattern pattern,
                      enum survey_edges edges);
/* Place of an item in the plan, or -1. */
int survey_plan_find(const struct survey_plan *plan, const struct survey_item *item);

/* "gap", "station", "across", "diagonal"; "standard", "diagonal"; "left", "both", "none". Static
 * storage. */
const char *survey_kind_text(enum survey_kind kind);
const char *survey_pattern_text(enum survey_pattern pattern);
const char *survey_edges_text(enum survey_edges edges);
bool survey_kind_parse(const char *text, enum survey_kind *kind);
bool survey_pattern_parse(const char *text, enum survey_pattern *pattern);
bool survey_edges_parse(const char *text, enum survey_edges *edges);

double survey_line_in(unsigned line);        /* from the left edge */
const char *survey_line_text(unsigned line); /* "36 in left of the centreline" */
/* station where it begins; NaN for a 45 degree line */
double survey_item_ft(const struct survey_item *item);
/* "line 2 (36 in left of the centreline), mats 121 to 130, station 34.3 ft" */
void survey_item_text(const struct survey_item *item, bool si, char *out, size_t size);
/* What a first reading should be about (NaN: anything), and the change that is asked about. */
double survey_item_nominal_in(const struct survey_item *item);
double survey_item_limit_in(const struct survey_item *item);

#endif
