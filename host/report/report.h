/* The data of a report, and its sections. */
#ifndef MATRIG_HOST_REPORT_REPORT_H
#define MATRIG_HOST_REPORT_REPORT_H

#include <stdio.h>

#include "common/config.h"
#include "host/analyse/inspection.h"
#include "host/analyse/outcome.h"
#include "host/analyse/summary.h"
#include "host/base/answer.h"
#include "host/compare/figures.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"

#define REPORT_BANDS_MAX 4u
#define REPORT_HASH_SIZE 65u /* bytes of a SHA-256 in hexadecimal digits, with terminating zero */

/* A landing with its samples. Only one landing at a time is in memory. */
struct report_landing {
    struct summary summary;
    struct zones_slack survey;
    struct store_series series; /* series of the landing; id 0: none */
    struct store_motion *motion;
    size_t motion_count;
    struct store_prediction *prediction;
    size_t prediction_count;
    struct store_simulation *simulation; /* channels of the newest comparison */
    size_t simulation_count;
    struct store_simulation_summary simulation_summary; /* common data of the newest comparison */
    struct mr_config *config; /* configuration of the board; NULL: it was never read */
    double *station_ft;       /* station of the lead wheel at each sample; NULL: not known */
    /* figures of the newest comparison, computed again with the present calibration; NULL: none */
    struct compare_figures *comparison;
};

/* Problems of a landing: bits of report_facts.problems, in the order of report_problem_text. */
enum report_problem {
    REPORT_OBSERVED_WAVE = 1,    /* wave observed by a person */
    REPORT_OBSERVED_BREAK = 2,   /* break observed by a person */
    REPORT_MISSED_WARNING = 4,   /* zone without a warning, or with a late warning */
    REPORT_FALSE_WARNING = 8,    /* warning without a zone */
    REPORT_MISSING_EDGES = 16,   /* first edges missing */
    REPORT_UNKNOWN_STOP = 32,    /* speed or stop not known */
    REPORT_INVALID_CHANNEL = 64, /* transducer or gage not valid to the end */
    REPORT_BOARD_FAULT = 128,    /* fault of the board */
    REPORT_LOST_FRAMES = 256,    /* lost frames, or a silent link */
    REPORT_CHECK_NO_GO = 512     /* no-go in the check before the landing */
};
#define REPORT_PROBLEM_COUNT 10u

/* Facts of a landing for the front page. Units are feet, pounds, inches and seconds; NaN: not
 * known. */
struct report_facts {
    struct store_landing landing;
    struct store_series series; /* series of the landing; id 0: none */
    char can_link[200], serial_link[200], site[40];
    enum measured_source source;
    bool is_incomplete, has_motion_fit, has_config, is_emulated;
    const char *command_rights; /* who may send commands: mr_key_state_text; NULL: not reported */
    const char *quality_text;   /* marks of the landing, from measured_quality_text */
    int64_t recalibrated_channels;
    size_t gate_count, switch_count, surveyed_segment_count, zone_report_count;
    size_t sensor_count,
        /* number of channels that measure, and of those with a serial number */
        serial_number_count;
    struct mr_estimate speed_ft_s, deceleration_ft_s2, stop_ft;
    struct report_movement {
        double station_ft, peak_in, peak_error_in, end_in, end_error_in;
    } movement[MR_TRANSDUCERS];
    /* means over the gages of a band: tension, largest fall and largest rise from the tension
     * before the landing */
    struct report_band {
        double fall_lb, rise_lb, tension_fall_error_lb, tension_rise_error_lb;
        size_t gage_count;
    } band[REPORT_BANDS_MAX];
    struct zone_warning warning;
    bool may_have_missed_warning; /* the board may have sent a warning that was not received */
    struct report_zone {
        int64_t mats; /* length of the zone; 0: no zone */
        double start_ft, end_ft;
        double start_error_ft, end_error_ft; /* standard errors; NaN: not known */
    } longest_zone, last_zone;               /* zones that the board reported */
    struct report_zone longest_warned_zone;  /* longest zone while the warning was on */
    int64_t worst_predictor_verdict;         /* worst verdict of the predictor; STORE_NONE: none */
    /* bit s: segment s is closed at the end, according to survey and transducers */
    uint64_t closed_segments;
    int64_t lost_frames;
    struct report_comparison {
        char compared_with[120];
        size_t channel_count;
        /* means over the transducers; channel_count 0: not compared */
        struct compare_channel_means mean;
        struct compare_overlap at_longest_zone, board_at_longest_zone, at_rest;
        double solver_error_in;
    } comparison;
    /* digest of the calibration, equal for equal calibrations */
    char calibration_hash[REPORT_HASH_SIZE];
    struct mr_estimate weight_lb; /* weight as entered by the user (matrig landing) */
    unsigned problems;
    struct outcome_record_row warning_record;
    char outcome_reason[120]; /* text of warning_record.unknown_reason */
};

struct report {
    const char *path; /* path of the database */
    struct store *store;
    struct store_landing *row; /* landings in the report */
    struct report_facts *facts;
    size_t landings, voided_landings; /* voided_landings: number of landings that are left out */
    struct outcome_record record;
    struct inspections records;
    struct store_slow *slow_reading;
    size_t slow_count;
    int64_t run; /* RUN, if the report is about one landing; 0: all landings */
    bool si;
    struct answer *calibrations; /* receives one table for each different calibration */
    struct error *error;         /* error of report_write_page: a section could not read its data */
};

/* Begins a report on landing report->run, or on all landings of the campaign that are not void;
 * with `voided`, on the void ones too. Does not load the landings. The caller frees it with
 * report_free, also after an error. */
enum mr_status report_begin(struct report *report, bool voided, struct error *error);
void report_free(struct report *report);
/* Loads landing `at` of report->row, and writes its facts to report->facts. The caller frees it
 * with report_landing_free, also after an error. */
enum mr_status report_landing_load(struct report *report, size_t at, struct report_landing *landing,
                                   struct error *error);
void report_landing_free(struct report_landing *landing);

/* Returns the text of the problem with the bit `1 << i`: "a wave was seen". Static storage. */
const char *report_problem_text(unsigned i);
/* Returns the transducer with the largest movement in either direction; NULL: none has a peak. */
const struct report_movement *report_find_largest_movement(const struct report_facts *facts);

/* Sections of the page, each with its heading. A section without content is omitted. In the last
 * entry of each list, `write` is NULL. */
extern const struct report_section { /* sections of the campaign, in the order of the page */
    const char *id, *title;
    void (*write)(const struct report *report, FILE *out);
    size_t min_landings; /* number of landings from which on the section is shown */
} report_sections[];
extern const struct report_landing_section { /* parts of each landing */
    const char *title;
    void (*write)(const struct report *report, const struct report_landing *landing, FILE *out);
} report_landing_sections[];

/* Writes the section about surveys of the mat. */
void report_write_surveys(const struct report *report, FILE *out);
/* Writes the crew's records: those of the runway with a map, or those of a landing. */
void report_write_records(const struct report *report, FILE *out);
void report_write_landing_records(const struct report *report, const struct report_landing *landing,
                                  FILE *out);

/* Returns the name of the database without its folder. */
const char *report_database_name(const struct report *report);

/* Writes the landings i with of[i]: "RUN 1, 3 and 12 more", as links. */
void report_write_runs(const struct report *report, const bool *of, FILE *out);

/* Writes an answer to the page, and frees it. */
void report_write_answer(struct answer *answer, FILE *out);

/* Adds the calibrations of a landing as a table under a heading. */
void report_add_calibration(const struct report_landing *landing, struct answer *answer);

/* ---- the page ---- */

/* Writes the whole report; call after report_begin. Loads one landing after the other; if one
 * cannot be loaded, nothing is written. Fails with the error of a section. */
enum mr_status report_write_page(struct report *report, FILE *out, struct error *error);

#endif
