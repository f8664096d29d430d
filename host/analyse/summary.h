/* Summary of a landing: what `matrig log` prints at its end and `matrig report` puts at its
 * head. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_H
#define MATRIG_HOST_ANALYSE_SUMMARY_H

#include <jansson.h>
#include <stdio.h>

#include "host/analyse/bands.h"
#include "host/analyse/film.h"
#include "host/analyse/foresight.h"
#include "host/analyse/summary_mean.h"
#include "host/analyse/summary_ready.h"
#include "host/analyse/zones.h"
#include "host/link/link.h"
#include "host/store/store_import.h"
#include "host/store/store_log.h"

/* Half width of a 95 % interval in standard errors: positions of switches are taken as normal with
 * known spread. */
#define SUMMARY_95 1.959964

struct summary_link {
    bool used;
    int64_t received;               /* frames in the landing */
    int64_t lost;                   /* frames the board sent and nobody received */
    int64_t dropped;                /* frames the board says it could not queue */
    int64_t trouble[LINK_TROUBLES]; /* what the link itself saw */
    /* the link fell silent in the landing, or never spoke: losses cannot be counted */
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
    struct store_time_map clock; /* the best of the links; refusal says if it is one at all */
    bool clock_known;
    /* after the block that decided the first warning was complete; NaN: not known */
    double warning_received_s[LINK_KINDS];
    struct store_fault *fault;
    size_t faults;
    struct store_fault *switch_event; /* what the board found wrong with switches */
    size_t switch_events;
    struct store_fault *channel_event; /* and what of channels, in order of time */
    size_t channel_events;
    struct store_mean mean[MR_QUANTITIES]; /* of what the board tells again and again */
    struct summary_ready ready[SUMMARY_READY_KINDS];
    struct store_held held; /* while it was logged */
};

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary,
                            struct error *error);
void summary_free(struct summary *summary); /* also after an error */

/* "RUN 5: landing 5, done" */
#define SUMMARY_HEADING 80
void summary_heading(const struct summary *summary, char out[SUMMARY_HEADING]);
/* All of it, under its heading; and parts of it that a page shows in sections of their own: */
void summary_answer(const struct summary *summary, struct answer *answer);
/* what it came to, and who recorded it */
void summary_facts_answer(const struct summary *summary, struct answer *answer);
/* the first warning */
void summary_zone_answer(const struct summary *summary, struct answer *answer);
/* clock, film, links, gaps, faults */
void summary_health_answer(const struct summary *summary, struct answer *answer);
/* The channels of a kind as a table, and the facts of a row of it. */
void summary_channels_answer(const struct measured *measured, enum mr_channel_kind kind,
                             const char *label, struct answer *answer);
void summary_channel_answer(const struct measured *measured, const struct measured_channel *channel,
                            struct answer *answer);

/* summary_answer as text (false: `out` cannot be written) and as JSON (the caller's). */
bool summary_print(const struct summary *summary, bool si, FILE *out);
json_t *summary_json(const struct summary *summary, bool si);
const char *summary_link_name(int link);
/* "bus off 1, no acknowledgement 12" of LINK_TROUBLES counts; "" when all are 0. */
void summary_troubles(const int64_t *trouble, char *out, size_t size);
/* The same as an object: {"bus off": 1, ...}. The caller owns it. */
json_t *summary_troubles_json(const int64_t *trouble);

#endif
