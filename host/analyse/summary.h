/* Summary of a landing: what `matrig log` prints at its end and `matrig report` puts at its
 * head. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_H
#define MATRIG_HOST_ANALYSE_SUMMARY_H

#include <jansson.h>
#include <stdio.h>

#include "common/quantity.h"
#include "host/analyse/bands.h"
#include "host/analyse/track.h"
#include "host/analyse/zones.h"
#include "host/analyse/measured.h"
#include "host/base/answer.h"
#include "host/link/link.h"
#include "host/store/store.h"

/* What `matrig ready` had found before a landing: the newest check and the newest walk of its
 * board, within 12 h before arming. */

#define SUMMARY_READY_KINDS 2

struct summary_ready {
    bool known;
    bool go;
    double before_min; /* minutes before arming */
    char no_go[400];   /* "switch 12: did not answer; ..." */
};

/* Half width of a 95 % interval in standard errors: positions of switches are taken as normal with
 * known spread. */
#define SUMMARY_95 1.959964

struct summary_link {
    bool used;
    int64_t received;               /* frames in the landing */
    int64_t lost;                   /* frames sent by the board and not received */
    int64_t dropped;                /* frames that the board reports as dropped from its queue */
    int64_t trouble[LINK_TROUBLES]; /* what the link itself saw */
    /* the link fell silent in the landing, or was silent from the start: losses cannot be
     * counted */
    bool silent;
};

struct summary {
    struct measured measured;
    struct zones zones;
    struct foresight foresight;
    struct bands_summary bands;
    struct summary_link link[LINK_KINDS];
    struct store_session_row session;
    bool imported; /* the session was an import: */
    struct store_import import;
    struct store_gap *gap;
    size_t gaps;
    struct film film;
    struct store_time_map clock; /* the best of the links; refusal tells whether it is usable */
    bool clock_known;
    struct store_fault *fault;
    size_t faults;
    struct store_fault *switch_event; /* what the board found wrong with switches */
    size_t switch_events;
    struct store_fault *channel_event; /* and what of channels, in order of time */
    size_t channel_events;
    struct store_fault *restart; /* the board began again in it */
    size_t restarts;
    struct store_fault *order; /* of another program, or refused; count: 1 the log's own */
    size_t orders;
    struct store_fault *key;               /* code: enum mr_key_state, then */
    size_t keys;                           /* 0: not reported */
    struct store_mean mean[MR_QUANTITIES]; /* of the messages that the board repeats */
    struct summary_ready ready[SUMMARY_READY_KINDS];
    int64_t twin; /* the earlier RUN that is the same landing; 0: none */
};

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary,
                            struct error *error);
void summary_free(struct summary *summary); /* also after an error */

/* "RUN 5: landing 5, done" */
#define SUMMARY_HEADING 80
void summary_heading(const struct summary *summary, char out[SUMMARY_HEADING]);
/* "uncalibrated" of the JSON: true, false, or null where the configuration was not read. */
void summary_dates_answer(const struct measured *measured, struct answer *answer);
/* All of it, under its heading; and parts of it that a page shows in sections of their own: */
void summary_answer(const struct summary *summary, struct answer *answer);
/* What makes it doubtful: torn, recorded twice, restarted, ordered, not ready. */
void summary_alerts_answer(const struct summary *summary, struct answer *answer);
/* its outcome, and its recorder */
void summary_facts_answer(const struct summary *summary, struct answer *answer);
/* the first warning */
void summary_zone_answer(const struct summary *summary, struct answer *answer);
/* clock, film, links, gaps, faults */
void summary_health_answer(const struct summary *summary, struct answer *answer);
/* The channels of a kind as a table. */
void summary_channels_answer(const struct measured *measured, enum mr_channel_kind kind,
                             const char *label, struct answer *answer);

/* summary_answer as JSON, the caller's. */
json_t *summary_json(const struct summary *summary, bool si);
const char *summary_link_name(int link);
/* "all 24 seen" or "22 of 24 seen, missing 3, 17". */
void summary_switches(const struct measured *measured, char *out, size_t size);
/* "bus off 1, no acknowledgement 12" of LINK_TROUBLES counts; "" when all are 0. */
void summary_troubles(const int64_t *trouble, char *out, size_t size);
/* The same as an object: {"bus off": 1, ...}. The caller owns it. */
json_t *summary_troubles_json(const int64_t *trouble);

/* Sums up the gaps: lost, dropped, silent. */
void summary_count_gaps(const struct store_gap *gaps, size_t count,
                        struct summary_link link[LINK_KINDS]);

/* Of a moment of the board: Unix microseconds and half the 95 % interval; NaN: not known. */
struct summary_moment {
    double host_us;
    double half_us;
};
struct summary_moment summary_time_of_day(const struct summary *summary, double board_us);
/* The same by a landing's clock alone: the best of its links, as summary->clock. `*known` false: no
 * link had one. */
enum mr_status summary_time_clock(struct store *store, int64_t run, struct store_time_map *clock,
                                  bool *known, struct error *error);
struct summary_moment summary_time_by(const struct store_time_map *clock, double board_us);

void summary_time_answer(const struct summary *summary, struct answer *answer);

#endif
