/* What surveys say: opening and closing of joints, movement of the mat, in-plane bow, slack for the
 * predictor. All with standard errors.
 *
 * Change of a span: this reading less that of another survey; positive: ten joints have opened.
 * Movement u of the gage points along a line: the change of each span is u(k+1) - u(k), a station's
 * mark says u there (between two points: in proportion), and both are weighed by their errors
 * (least squares; a span that was not read counts as a change of 0 +- the most that ten joints can
 * do). A line without stations moves with line 1 at its upfield end, where the runway is held.
 * In-plane bow of a row of mats: how far lines 2 and 3 stand from the straight line between the
 * edges (downfield positive), counted from the first survey, when the rows were laid straight; the
 * prototype's end connectors break beyond 11 in (report 4.1), a seventh of it here. Lines are taken
 * to err independently.
 *
 * Slack of a span: reading less the distance with all joints closed, not below 0; of a segment the
 * mean of the lines that were read. Inches; NaN: not known. Pure. */
#ifndef MATRIG_HOST_SURVEY_RESULT_H
#define MATRIG_HOST_SURVEY_RESULT_H

#include "host/survey/plan.h"

#define SURVEY_BOW_LIMIT_IN     (11.0 / 7.0)
/* standard error of a caliper's reading, when nothing better is known */
#define SURVEY_ERROR_IN         0.005
#define SURVEY_STATION_ERROR_IN 0.02 /* of a mark against a station, by a scale */

/* Readings by place; NaN: not read. */
struct survey_readings {
    double gap_in[SURVEY_LINES][SURVEY_SPANS];
    double station_in[SURVEY_LINES][SURVEY_STATIONS];
    double across_in[SURVEY_LINES][SURVEY_STATIONS];
    double diagonal_in[SURVEY_DIAGONALS][SURVEY_DIAGONAL_SPANS];
    double error_in;
};

struct survey_estimate {
    double value_in, error_in;
};

/* One survey against another. */
struct survey_change {
    struct survey_readings change; /* error_in: that of a change of a span */
    double station_error_in;       /* of a change of a station or of a distance across */
    struct survey_estimate moved[SURVEY_LINES][SURVEY_POINTS];
    struct survey_estimate bow[SURVEY_POINTS];
    size_t compared; /* readings that both have */
};

struct survey_slack {
    struct survey_estimate segment[SURVEY_SPANS];
    unsigned lines[SURVEY_SPANS]; /* of which it is the mean */
    size_t surveyed;
};

void survey_readings_init(struct survey_readings *readings);
double *survey_reading_at(struct survey_readings *readings, const struct survey_item *item);
void survey_change(const struct survey_readings *now, const struct survey_readings *before,
                   struct survey_change *change);
void survey_slack(const struct survey_readings *now, double closed_in, struct survey_slack *slack);

#endif
