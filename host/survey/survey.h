/* A survey of the gage points of the mat: plan, readings, sheet, result, and surveys
 * of a campaign. */
#ifndef MATRIG_HOST_SURVEY_SURVEY_H
#define MATRIG_HOST_SURVEY_SURVEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "common/closure.h"
#include "host/base/error.h"
#include "host/base/quantity.h"
#include "host/store/store_journal.h"

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
/* Where stations are read; a diagonal lay: at all lines, with across and the 45 degree lines. */
enum survey_edges {
    SURVEY_EDGE_LEFT,
    SURVEY_EDGE_BOTH,
    SURVEY_EDGE_NONE,
    SURVEY_EDGE_DIAGONAL,
    SURVEY_EDGES
};

struct survey_item {
    enum survey_kind kind;
    /* from 1: left edge, 36 in left of the centreline, near it, right edge; of the 45 degree lines
     * from upfield on */
    unsigned line;
    unsigned place; /* span or station, from 0 */
};

struct survey_plan {
    size_t count;
    struct survey_item item[SURVEY_ITEMS_MAX];
};

void survey_plan_make(struct survey_plan *plan, enum survey_edges edges);
/* Place of an item in the plan, or -1. */
int survey_plan_find(const struct survey_plan *plan, const struct survey_item *item);

/* "gap", "station"; "left", "both", "none". */
extern const char *const survey_kind_text[SURVEY_KINDS], *const survey_edges_text[SURVEY_EDGES];
bool survey_edges_parse(const char *text, enum survey_edges *edges);

double survey_line_in(unsigned line);        /* from the left edge */
const char *survey_line_text(unsigned line); /* "36 in left of the centreline" */
/* "line 2 (36 in left of the centreline), mats 121 to 130, station 34.3 ft" */
void survey_item_text(const struct survey_item *item, bool si, char *out, size_t size);
double survey_item_limit_in(const struct survey_item *item);

/* A survey being taken: what is asked next, what was typed, what is doubted. Pure: who keeps the
 * readings is the caller.
 *
 * A line is a number and Enter, as a caliper types it ("33.512", "33.512 in", "851.2 mm"; any unit
 * of a length; a comma is none: 33,512 may be thousands), or a word:
 *
 *     s        skip this one
 *     b        back by one
 *     u        undo the last reading, and ask for it again
 *     n TEXT   a note on the last reading
 *     q        quit; the survey can be resumed
 *     ?        these words */
enum survey_word {
    SURVEY_NUMBER,
    SURVEY_SKIP,
    SURVEY_UNDO,
    SURVEY_BACK,
    SURVEY_NOTE,
    SURVEY_QUIT,
    SURVEY_HELP,
    SURVEY_NOTHING, /* an empty line */
    SURVEY_NONSENSE,
};

struct survey_entry {
    enum survey_word word;
    double value_in;             /* SURVEY_NUMBER */
    const char *note;            /* SURVEY_NOTE: inside the line that was parsed */
    struct quantity_wrong wrong; /* SURVEY_NONSENSE: why a number is none; empty: it is no number */
};

/* A number without a unit is in inches, millimetres with `si`. */
void survey_entry_parse(const char *line, bool si, struct survey_entry *entry);

struct survey_desk {
    struct survey_plan plan;
    double value_in[SURVEY_ITEMS_MAX]; /* NaN: not read */
    bool skipped[SURVEY_ITEMS_MAX];
    double previous_in[SURVEY_ITEMS_MAX]; /* of the survey before; NaN: none */
    size_t at;                            /* asked now; plan.count: all is read or skipped */
    size_t last[SURVEY_ITEMS_MAX];        /* items in the order in which they were read, for undo */
    size_t lasts;
    bool doubted; /* the same again keeps it */
    double doubted_in;
};

enum survey_outcome {
    SURVEY_KEPT,      /* `item` has a new value */
    SURVEY_CONFIRMED, /* the same, after a doubt */
    SURVEY_DOUBTED,   /* type it again */
    SURVEY_SKIPPED,   /* `item` is left out */
    SURVEY_UNDONE,    /* `item` has no value any more */
    SURVEY_MOVED,     /* another item is asked for */
    SURVEY_NOTED,     /* the note belongs to `item` */
    SURVEY_REFUSED,   /* nothing to undo, back from the first, nonsense */
};

/* Nothing read yet; previous_in NaN. */
void survey_desk_init(struct survey_desk *desk, enum survey_edges edges);
/* To the first item from `from` on that is neither read nor skipped; then from the beginning. */
void survey_desk_next(struct survey_desk *desk, size_t from);
/* Takes an entry other than quit, help and nothing. `item`: which one it was about. */
enum survey_outcome survey_desk_take(struct survey_desk *desk, const struct survey_entry *entry,
                                     size_t *item);
/* What the reading is compared with: of the survey before, else as designed; NaN: nothing. */
double survey_desk_expected_in(const struct survey_desk *desk, size_t item);
size_t survey_desk_read(const struct survey_desk *desk); /* how many have a value */

/* A survey as a sheet: CSV in walking order, to be printed and written on, or filled in elsewhere
 * and read in.
 *
 *     kind,line,place,reading_in,previous_in,where,note
 *     gap,1,0,33.512,33.508,"line 1 (...), mats 1 to 10, station 0.0 ft",
 *
 * Read in by the names of its columns: kind, line, place and reading_in or reading_mm are needed,
 * note is taken, others are left. A row without a reading is no reading. */
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
void survey_change(const struct survey_readings *now, const struct survey_readings *before,
                   struct survey_change *change);
void survey_slack(const struct survey_readings *now, double closed_in, struct survey_slack *slack);

/* Surveys of a campaign: which one goes on, its readings at their places, what it is compared
 * with. */
struct survey {
    struct store_gage_survey row;
    struct survey_desk desk; /* values, skipped ones, those of the survey before */
    size_t confirmed;        /* readings that were doubted and typed again */
    struct survey_readings readings;
};

/* What a survey comes to. `previous` and `first` are ids, 0: there is none before it. */
struct survey_found {
    int64_t previous, first;
    struct survey_change since_previous, since_first;
    struct survey_slack slack;
    double worst_bow_in, worst_bow_error_in; /* since the first; NaN: not known */
    double worst_bow_ft;
};

/* Survey `id`, 0: the newest. MR_UNKNOWN: no such survey. */
enum mr_status survey_get(struct store *store, int64_t id, struct survey *survey,
                          struct error *error);
/* The newest one that goes on; *found false: none. */
enum mr_status survey_get_open(struct store *store, struct survey *survey, bool *found,
                               struct error *error);
enum mr_status survey_find(struct store *store, const struct survey *survey,
                           struct survey_found *found, struct error *error);
/* What the newest one comes to that was begun between two moments and tells of segments; *there
 * false: none. */
enum mr_status survey_find_between(struct store *store, int64_t from_us, int64_t to_us,
                                   struct survey_found *found, bool *there, struct error *error);

/* "within", "perhaps beyond" (its 95 % interval reaches over it), "beyond", "not known" */
const char *survey_bow_verdict(const struct survey_found *found);
/* "2026-11-22 01:48 UTC"; "no date" before this: the board's time, of a recording without times. */
#define SURVEY_DATED_US INT64_C(946684800000000) /* 2000-01-01 */
void survey_time_text(int64_t host_us, char *out, size_t size);

#endif
