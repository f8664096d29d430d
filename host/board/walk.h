/* The walk test. A person walks along the rig, trips each switch, pushes each transducer's mat and
 * pulls at each gage, in order. The result is a table of checks: one check for each item that did
 * not answer or answered in place of another item, or one check per kind if all items answered in
 * order. Two swapped items give the same result as two items tripped in the wrong order; the text
 * of the check mentions both causes.
 *
 * Pure functions. */
#ifndef MATRIG_HOST_BOARD_WALK_H
#define MATRIG_HOST_BOARD_WALK_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/ready.h"

#define WALK_RESPONSES_MAX 64u /* maximum number of stored responses of each kind */
#define WALK_ITEMS_MAX     32u
#define WALK_CHANNELS_MAX  16u
/* Number of readings in half a second. A movement ends when all channels have been at rest for this
 * time. */
#define WALK_REST_READINGS 25u
/* smallest movement that counts as a push by hand; a mat at rest stays within 0.01 in */
#define WALK_PUSH_MIN_IN   0.05f
#define WALK_PULL_MIN_LB   5.0f

enum walk_item_kind { WALK_SWITCH, WALK_TRANSDUCER, WALK_GAGE, WALK_ITEM_KIND_COUNT };
extern const char *const walk_item_kind_names[WALK_ITEM_KIND_COUNT];

/* Detection of movements by hand. The channel that moved most is the intended one. */
struct walk_motion {
    unsigned channel_count;
    float movement_min; /* smallest movement that counts, in inches or pounds */
    float reading[WALK_REST_READINGS][WALK_CHANNELS_MAX];
    unsigned reading_count;
    float rest_mean[WALK_CHANNELS_MAX], peak[WALK_CHANNELS_MAX];
    bool is_at_rest, is_moving;
};
void walk_motion_start(struct walk_motion *motion, unsigned channels, float limit);
/* Adds the next reading of all channels, one per 20 ms; NaN: not valid. Returns the channel,
 * counted from 1, whose movement has ended; 0: none. */
unsigned walk_motion_add(struct walk_motion *motion, const float *value);

struct walk_response {
    /* number that the board gave the switch, from 1; 0: the edge belongs to no switch */
    unsigned number;
    uint8_t edge_count; /* number of the edge by the board's count */
    double step_codes;  /* voltage step of the edge, in codes */
};
struct walk_test {
    const struct mr_config *config;
    struct walk_response response[WALK_ITEM_KIND_COUNT][WALK_RESPONSES_MAX];
    unsigned response_count[WALK_ITEM_KIND_COUNT], unexpected_event_count;
    struct walk_motion transducers, gages;
    bool is_gage_disturbed; /* a gage moved while a transducer was pushed: the push caused it */
};
void walk_start(struct walk_test *walk, const struct mr_config *config);
/* The walk_add functions add data of the board. They return true if an item answered;
 * walk_add_reading sets `kind` to its kind. */
bool walk_add_edge(struct walk_test *walk, const struct mr_edge *edge);
void walk_add_event(struct walk_test *walk, const struct mr_switch_event *event);
bool walk_add_reading(struct walk_test *walk, const struct mr_block *block,
                      enum walk_item_kind *kind);
/* True if all fitted items answered. */
bool walk_is_complete(const struct walk_test *walk);
void walk_check_responses(const struct walk_test *walk, struct ready_report *report);

#endif
