/* Summary of a landing: what `matrig log` prints at its end and `matrig report` puts at its head, as text and
 * as JSON. */
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

/* Half width of a 95 % interval in standard errors: positions of switches are taken as normal with known
 * spread. */
#define SUMMARY_95 1.959964

struct summary_link {
    bool used;
    int64_t received; /* frames in the landing */
    int64_t lost;     /* frames the board sent and nobody received */
    int64_t dropped;  /* frames the board says it could not queue */
    int64_t trouble[LINK_TROUBLES]; /* what the link itself saw */
    bool silent;      /* the link fell silent in the landing, or never spoke: losses cannot be counted */
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
    double warning_received_s[LINK_KINDS]; /* after the block that decided the first warning was complete; NaN: not known */
    struct store_fault *fault;
    size_t faults;
    struct store_fault *switch_event; /* what the board found wrong with switches */
    size_t switch_events;
    struct store_fault *channel_event; /* and what of channels, in order of time */
    size_t channel_events;
    struct store_result result; /* the board's own fit */
    bool result_known;
    struct store_mean mean[MR_QUANTITIES]; /* of what the board tells again and again */
    struct summary_ready ready[SUMMARY_READY_KINDS];
    struct store_held held; /* while it was logged */
};

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary, struct error *error);
void summary_free(struct summary *summary); /* also after an error */

void summary_print(const struct summary *summary, bool si, FILE *out);
json_t *summary_json(const struct summary *summary, bool si);
/* "all 24 seen" or "22 of 24 seen, missing 3, 17; 1 edges not named". */
void summary_switches(const struct measured *measured, char *out, size_t size);
/* "switch 7 did not open though the gear passed it", with how many times where more than once. */
void summary_switch_event(const struct store_fault *event, char *out, size_t size);
/* "transducer 4 (70.0 ft): stuck, from 2.345 s on" or "... to 3.456 s"; false: event `i` says that a channel is valid again,
 * which the line of what was wrong with it says already. */
bool summary_channel_event(const struct summary *summary, size_t i, bool si, char *out, size_t size);
/* One line for a gap: "serial lost 12 frames between block 400 and 412". */
void summary_gap(const struct store_gap *gap, char *out, size_t size);
const char *summary_link_name(int link);
/* "bus off 1, no acknowledgement 12" of LINK_TROUBLES counts; "" when all are 0. */
void summary_troubles(const int64_t *trouble, char *out, size_t size);
/* The same as an object: {"bus off": 1, ...}. The caller owns it. */
json_t *summary_troubles_json(const int64_t *trouble);

#endif
