/* What a report is made from, and its sections. */
#ifndef MATRIG_HOST_REPORT_REPORT_H
#define MATRIG_HOST_REPORT_REPORT_H

#include <stdio.h>

#include "common/config.h"
#include "host/analyse/record.h"
#include "host/analyse/summary.h"
#include "host/base/answer.h"
#include "host/compare/figures.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"

#define REPORT_BANDS 4u
#define REPORT_HASH  65u /* SHA-256 in hexadecimal digits, and NUL */

/* A landing with its series: one at a time is in memory. */
struct report_landing {
    struct summary summary;
    struct zones_closure survey;
    struct store_series series; /* id 0: none */
    struct store_motion *motion;
    size_t motions;
    struct store_prediction *prediction;
    size_t predictions;
    struct store_simulation *simulation; /* of the newest comparison */
    size_t simulations;
    struct store_simulation_head head; /* of the same */
    struct mr_config *config;         /* the board's whole configuration; NULL: it was never read */
    double *station_ft;               /* of the lead wheel at each sample; NULL: not known */
    struct compare_figures *compared; /* the newest comparison, from what is measured now; NULL */
};

/* What can go wrong in a landing; bits of report_facts.wrong, in the order of wrong_text. */
enum report_wrong {
    REPORT_WAVE = 1,     /* seen by a person */
    REPORT_BREAK = 2,    /* likewise */
    REPORT_MISSED = 4,   /* a zone without a warning, or one after it */
    REPORT_FALSE = 8,    /* a warning without a zone */
    REPORT_TORN = 16,    /* its first edges are missing */
    REPORT_NO_STOP = 32, /* no speed, or no stop */
    REPORT_CHANNEL = 64, /* a transducer or gage that was not valid to the end */
    REPORT_FAULT = 128,  /* of the board */
    REPORT_LOST = 256,   /* frames, or a silent link */
    REPORT_NO_GO = 512   /* by the check before it */
};
#define REPORT_WRONGS 10u

/* What the front of a report says of a landing. Feet, pounds, inches, seconds; NaN: not known. */
struct report_facts {
    struct store_landing landing;
    struct store_series series; /* id 0: none */
    char can_link[200], serial_link[200], site[40];
    enum measured_source source;
    bool torn, fitted, config_read, emulated;
    const char *orders; /* who could give them: mr_key_state_text; NULL: not told */
    const char *marks;  /* measured_marks */
    int64_t recalibrated;
    size_t gates, switches, surveyed, statements;
    struct mr_estimate speed_ft_s, deceleration_ft_s2, stop_ft;
    struct report_moved {
        double station_ft, peak, error, end, end_error;
    } moved[MR_TRANSDUCERS];
    /* mean over the gages of the band of least and most against before */
    struct report_band {
        double fell_lb, rose_lb, fell_error_lb, rose_error_lb;
        size_t gages;
    } band[REPORT_BANDS];
    struct zone_warning warning;
    bool unheard; /* a warning may have come that nobody heard */
    struct report_zone {
        int64_t mats; /* 0: none */
        double start_ft, end_ft;
    } longest, last;       /* that the board reported */
    int64_t worst_verdict; /* STORE_NONE: none */
    uint64_t closed;       /* bit s: segment s, by survey and transducers, at the end */
    int64_t lost;
    struct report_compared {
        char against[120];
        size_t channels;
        struct compare_mean mean; /* channels 0: not compared */
        struct compare_overlap longest, longest_board, rest;
        double error_in;
    } compared;
    char calibration[REPORT_HASH]; /* the same: the same calibration */
    struct mr_estimate weight_lb;  /* as corrected (matrig landing) */
    unsigned wrong;
    struct record_row record;
    char why[120]; /* that record.why points to */
};

struct report {
    const char *path; /* of the database */
    struct store *store;
    struct store_landing *row; /* of the landings in it */
    struct report_facts *facts;
    size_t landings, voided; /* voided: left out */
    struct record record;
    struct store_slow *slow;
    size_t slow_rows;
    int64_t run; /* the only one; 0: all */
    bool si;
    struct answer *calibrations; /* receives a table for each other calibration */
    struct error *error;         /* of page_write: what a section could not read */
};

/* Landing report->run, or all of the campaign that count, or with `voided` all there are, without
 * reading them. The caller frees with report_free, also after an error. */
enum mr_status report_begin(struct report *report, bool voided, struct error *error);
void report_free(struct report *report);
/* Reads landing `at` of report->row, its facts into report->facts; the caller frees it with
 * report_landing_free, also after an error. */
enum mr_status report_landing_load(struct report *report, size_t at, struct report_landing *landing,
                                   struct error *error);
void report_landing_free(struct report_landing *landing);

/* "a wave was seen" of the bit `1 << i`. Static storage. */
const char *report_wrong_text(unsigned i);
/* The transducer that moved furthest, either way; NULL: none has a peak. */
const struct report_moved *report_largest_movement(const struct report_facts *facts);

/* What is to be read under a heading. Where nothing was written, the heading is left out too. The
 * last of each list has no `write`. */
extern const struct report_section { /* of the campaign, in the order of the page */
    const char *id, *title;
    void (*write)(const struct report *report, FILE *out);
    size_t least; /* landings that it takes */
} report_sections[];
extern const struct report_part { /* of each landing */
    const char *title;
    void (*write)(const struct report *report, const struct report_landing *landing, FILE *out);
} report_parts[];

/* The database's name without its folder. */
const char *report_name(const struct report *report);

/* An answer on the page; frees the answer. */
void report_answer(struct answer *answer, FILE *out);

/* Calibrations of a landing, as a table under a heading. */
void provenance_calibration(const struct report_landing *landing, struct answer *answer);

/* ---- the page ---- */

/* All of a report that report_begin has begun. Reads one landing after the other; nothing is
 * written when one cannot be read. Fails with a section's error. */
enum mr_status page_write(struct report *report, FILE *out, struct error *error);

#endif
