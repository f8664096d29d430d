/* A survey of the gage points of the mat: plan, readings, sheet, result, and surveys of a
 * campaign. */
#ifndef MATRIG_HOST_SURVEY_SURVEY_H
#define MATRIG_HOST_SURVEY_SURVEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "common/closure.h"
#include "host/base/error.h"
#include "host/base/quantity.h"
#include "host/store/store_journal.h"

/* The items of a gage survey: what is read, where, and in which order (report 2.7.2, 5.3).
 *
 * Gage points are punched into the mats every ten mats along four lines: 12 in from each edge, near
 * the centreline, and 36 in left of it. A reading is the distance between two neighbouring points
 * of a line, 33.5 in by design; its change is the sum of the changes of ten openings. Stations are
 * marked every 10 ft along the side of the runway: the reading is how far the mark on the mat is
 * downfield of that of the station. For a diagonal lay, the plan has stations at all four lines,
 * their distances across the runway from a fixed line along it, and seven lines of points at 45
 * degrees, at right angles to the joints.
 *
 * The reader walks down one line and back along the next one, and reads each station when passing
 * it. Pure functions, no I/O. Units are inches and feet. */
#define SURVEY_LINES              4u
#define SURVEY_SPANS              MR_SEGMENTS
#define SURVEY_POINTS             (SURVEY_SPANS + 1u)
#define SURVEY_STATIONS           13u /* one every 10 ft from 0 to 120 ft */
#define SURVEY_STATION_SPACING_FT 10.0
#define SURVEY_DIAGONALS          7u
#define SURVEY_DIAGONAL_SPANS     7u /* 14 ft of width at 45 degrees are 7 spans of 33.5 in */
#define SURVEY_ITEMS_MAX                                    \
    (SURVEY_LINES * (SURVEY_SPANS + 2u * SURVEY_STATIONS) + \
     SURVEY_DIAGONALS * SURVEY_DIAGONAL_SPANS)

#define SURVEY_SPAN_LENGTH_FT        (MR_MATS_PER_SEGMENT * 2.0 / 7.0) /* ten mats */
#define SURVEY_RUNWAY_WIDTH_IN       168.0 /* about 14 ft (report 2.6) */
#define SURVEY_POINT_SPACING_IN      33.5  /* distance between gage points */
#define SURVEY_JOINT_MOVEMENT_IN     0.036 /* designed movement of a joint (report 2.7.2) */
/* limit of a span's change: the sum of ten joints */
#define SURVEY_SPAN_CHANGE_MAX_IN    (SURVEY_JOINT_MOVEMENT_IN * MR_MATS_PER_SEGMENT)
/* largest plausible movement of a station between two surveys; beyond it, the reading must be
 * repeated */
#define SURVEY_STATION_CHANGE_MAX_IN 1.0

enum survey_item_kind {
    SURVEY_ITEM_GAP,
    SURVEY_ITEM_STATION,
    SURVEY_ITEM_ACROSS,
    SURVEY_ITEM_DIAGONAL,
    SURVEY_ITEM_KIND_COUNT
};
/* Lines at which stations are read. SURVEY_EDGE_DIAGONAL: all lines, with the distances across and
 * the lines at 45 degrees. */
enum survey_edges {
    SURVEY_EDGE_LEFT,
    SURVEY_EDGE_BOTH,
    SURVEY_EDGE_NONE,
    SURVEY_EDGE_DIAGONAL,
    SURVEY_EDGES_COUNT
};

struct survey_item {
    enum survey_item_kind kind;
    /* number of the line, from 1: left edge, 36 in left of the centreline, near the centreline,
     * right edge; 45-degree lines are counted from upfield */
    unsigned line;
    unsigned index; /* index of the span or station, from 0 */
};

struct survey_plan {
    size_t count;
    struct survey_item item[SURVEY_ITEMS_MAX];
};

void survey_plan_init(struct survey_plan *plan, enum survey_edges edges);
/* Returns the index of an item in the plan, or -1. */
int survey_plan_find(const struct survey_plan *plan, const struct survey_item *item);

/* Names of kinds and edges: "gap", "station"; "left", "both", "none". */
extern const char *const survey_item_kind_text[SURVEY_ITEM_KIND_COUNT],
    *const survey_edges_text[SURVEY_EDGES_COUNT];
bool survey_edges_parse(const char *text, enum survey_edges *edges);

/* returns the distance of a line from the left edge, inches */
double survey_line_offset_in(unsigned line);
const char *survey_describe_line(unsigned line); /* "36 in left of the centreline" */
/* Describes an item: "line 2 (36 in left of the centreline), mats 121 to 130, station 34.3 ft". */
void survey_item_format(const struct survey_item *item, bool si, char *out, size_t size);
double survey_item_limit_in(const struct survey_item *item);

/* A survey in progress: the current item, the typed entry, and doubtful readings. Pure functions:
 * the caller stores the readings.
 *
 * An entry is a number and Enter, as a caliper sends it ("33.512", "33.512 in", "851.2 mm"; any
 * unit of length; a comma is refused, because 33,512 may be thousands), or a word:
 *
 *     s        skip this one
 *     b        back by one
 *     u        undo the last reading, and ask for it again
 *     n TEXT   a note on the last reading
 *     q        quit; the survey can be resumed
 *     ?        these words */
enum survey_entry_kind {
    SURVEY_ENTRY_NUMBER,
    SURVEY_ENTRY_SKIP,
    SURVEY_ENTRY_UNDO,
    SURVEY_ENTRY_BACK,
    SURVEY_ENTRY_NOTE,
    SURVEY_ENTRY_QUIT,
    SURVEY_ENTRY_HELP,
    SURVEY_ENTRY_EMPTY, /* an empty line */
    SURVEY_ENTRY_INVALID,
};

struct survey_entry {
    enum survey_entry_kind kind;
    double value_in;  /* for SURVEY_ENTRY_NUMBER */
    const char *note; /* for SURVEY_ENTRY_NOTE: the text, inside the parsed line */
    /* for SURVEY_ENTRY_INVALID: why a number is invalid; empty: the text is not a number */
    struct quantity_error error;
};

/* Parses an entry. A number without a unit is in inches, or in millimetres with `si`. */
void survey_entry_parse(const char *line, bool si, struct survey_entry *entry);

struct survey_progress {
    struct survey_plan plan;
    double value_in[SURVEY_ITEMS_MAX]; /* reading of each item; NaN: not read */
    bool is_skipped[SURVEY_ITEMS_MAX];
    double previous_in[SURVEY_ITEMS_MAX]; /* readings of the previous survey; NaN: none */
    /* current item; plan.count if all items are read or skipped */
    size_t current_item;
    size_t history[SURVEY_ITEMS_MAX]; /* items in the order in which they were read, for undo */
    size_t history_count;
    /* the last value was doubtful; entering the same value again confirms it */
    bool has_doubtful_value;
    double doubtful_value_in;
};

enum survey_entry_outcome {
    SURVEY_OUTCOME_STORED,       /* `item` has a new value */
    SURVEY_OUTCOME_CONFIRMED,    /* the doubtful value was entered again */
    SURVEY_OUTCOME_DOUBTFUL,     /* the value is doubtful and must be entered again */
    SURVEY_OUTCOME_SKIPPED,      /* `item` was skipped */
    SURVEY_OUTCOME_UNDONE,       /* the value of `item` was removed */
    SURVEY_OUTCOME_ITEM_CHANGED, /* the current item changed */
    SURVEY_OUTCOME_NOTED,        /* the note belongs to `item` */
    /* the entry could not be applied: nothing to undo, no item before the first, or invalid */
    SURVEY_OUTCOME_REFUSED,
};

/* Starts a survey without readings; previous_in is NaN. */
void survey_progress_init(struct survey_progress *progress, enum survey_edges edges);
/* Moves to the next item, from `from` on, that is neither read nor skipped; after the last item,
 * continues at the first. */
void survey_progress_move_to_next(struct survey_progress *progress, size_t from);
/* Applies an entry other than quit, help and an empty line. Sets `item` to the item that the entry
 * changed. */
enum survey_entry_outcome survey_progress_apply(struct survey_progress *progress,
                                                const struct survey_entry *entry, size_t *item);
/* Returns the value with which a reading is compared: that of the previous survey, or else the
 * design value; NaN: none. */
double survey_progress_expected_in(const struct survey_progress *progress, size_t item);
size_t survey_progress_count_read(
    const struct survey_progress *progress); /* returns the number of items with a value */

/* A survey as a sheet: a CSV file in the order of reading, which is printed and filled in by hand,
 * or filled in with another program and then read.
 *
 *     kind,line,place,reading_in,previous_in,where,note
 *     gap,1,0,33.512,33.508,"line 1 (...), mats 1 to 10, station 0.0 ft",
 *
 * Columns are recognised by their names: kind, line, place and reading_in or reading_mm are
 * required, note is optional, other columns are ignored. A row without a reading is skipped. */
#define SURVEY_NOTE_SIZE 200u

struct survey_sheet {
    double value_in[SURVEY_ITEMS_MAX]; /* readings by index in the plan; NaN: none */
    char note[SURVEY_ITEMS_MAX][SURVEY_NOTE_SIZE];
    size_t reading_count;
};

void survey_sheet_write(FILE *out, const struct survey_progress *progress, bool si);
/* Reads a sheet. MR_IO: it cannot be opened. MR_MALFORMED: `error` has line and cause; the values
 * must not be used. */
enum mr_status survey_sheet_read(const char *path, const struct survey_plan *plan,
                                 struct survey_sheet *sheet, struct error *error);

/* Results of surveys: opening and closing of joints, movement of the mat, in-plane bow, slack for
 * the predictor. All have standard errors.
 *
 * Change of a span: this reading minus that of the other survey; positive: ten joints have opened.
 * Movement u of the gage points along a line: the change of each span is u(k+1) - u(k), and a
 * station's mark gives u at that station (between two points: interpolated linearly). The movements
 * are fitted to spans and stations by weighted least squares; a span that was not read counts as a
 * change of 0 +- the limit for ten joints. The upfield end of a line without stations is assumed to
 * move as that of line 1, because the runway is held there. In-plane bow of a row of mats: distance
 * of lines 2 and 3 from the straight line between the edges (downfield positive), relative to the
 * first survey, when the rows were laid straight. The end connectors of the prototype break beyond
 * a bow of 11 in (report 4.1), which is 11/7 in on the model. Errors of different lines are assumed
 * independent.
 *
 * Slack of a span: reading minus the distance with all joints closed, not below 0; slack of a
 * segment: mean over the lines that were read. Units are inches; NaN: not known. Pure functions. */
#define SURVEY_BOW_LIMIT_IN     (11.0 / 7.0)
/* standard error of a caliper's reading, if no better value is known */
#define SURVEY_READING_ERROR_IN 0.005
/* standard error of a mark's distance from a station, read by a scale */
#define SURVEY_STATION_ERROR_IN 0.02

/* Readings by place, in; NaN: not read. */
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

/* Changes from one survey to another. */
struct survey_change {
    struct survey_readings change; /* changes; error_in: standard error of the change of a span */
    double station_error_in; /* standard error of a change of a station or of a distance across */
    struct survey_estimate movement[SURVEY_LINES][SURVEY_POINTS];
    struct survey_estimate bow[SURVEY_POINTS];
    size_t compared_reading_count; /* number of readings that both surveys have */
};

struct survey_slack {
    struct survey_estimate segment[SURVEY_SPANS];
    /* number of lines of which each segment's value is the mean */
    unsigned line_count[SURVEY_SPANS];
    size_t surveyed_segment_count;
};

void survey_readings_init(struct survey_readings *readings);
void survey_compute_change(const struct survey_readings *now, const struct survey_readings *before,
                           struct survey_change *change);
void survey_compute_slack(const struct survey_readings *now, double closed_in,
                          struct survey_slack *slack);

/* A survey of a campaign: its row, its readings by index in the plan, and the values of the
 * previous survey. */
struct survey {
    struct store_gage_survey row;
    struct survey_progress progress; /* values, skipped items, and values of the previous survey */
    size_t confirmed_readings;       /* number of doubtful readings that were confirmed */
    struct survey_readings readings;
};

/* Results of a survey. `previous` and `first` are ids; 0: there is no earlier survey. */
struct survey_results {
    int64_t previous_survey, first_survey;
    struct survey_change since_previous, since_first;
    struct survey_slack slack;
    /* largest bow since the first survey, and its station; NaN: not known */
    double worst_bow_in, worst_bow_error_in;
    double worst_bow_station_ft;
};

/* Loads survey `id`; 0: the newest. MR_UNKNOWN: there is no such survey. */
enum mr_status survey_load(struct store *store, int64_t id, struct survey *survey,
                           struct error *error);
/* Loads the newest unfinished survey; *found is false if there is none. */
enum mr_status survey_load_unfinished(struct store *store, struct survey *survey, bool *found,
                                      struct error *error);
enum mr_status survey_evaluate(struct store *store, const struct survey *survey,
                               struct survey_results *found, struct error *error);
/* Evaluates the newest survey that was started between two times and has readings of segments;
 * *exists is false if there is none. */
enum mr_status survey_evaluate_between(struct store *store, int64_t from_us, int64_t to_us,
                                       struct survey_results *found, bool *exists,
                                       struct error *error);

/* Returns the verdict on the bow: "within", "perhaps beyond" (the limit lies in the bow's 95 %
 * interval), "beyond", "not known". */
const char *survey_describe_bow(const struct survey_results *found);
/* Writes a time: "2026-11-22 01:48 UTC"; "no date" for times before SURVEY_EARLIEST_DATE_US, which
 * are board times of a recording without times of day. */
#define SURVEY_EARLIEST_DATE_US INT64_C(946684800000000) /* 2000-01-01 */
void survey_format_time(int64_t host_us, char *out, size_t size);

#endif
