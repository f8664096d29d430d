/* Telemetry: puts catalogue messages on CAN and serial, and counts what went and what was dropped.
 *
 * Everything a landing needs goes out as it happens; the configuration goes round one item at a time, in a burst when asked
 * for. A full queue drops the message and counts it: telemetry never delays acquisition. */
#ifndef MATRIG_FIRMWARE_TELEMETRY_H
#define MATRIG_FIRMWARE_TELEMETRY_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/closure.h"
#include "common/onboard/landing.h"
#include "firmware/blackbox.h"
#include "firmware/board.h"
#include "firmware/canwatch.h"

struct telemetry {
    struct board_identity identity;
    uint32_t config_crc;
    struct mr_config_state config_state;

    uint16_t serial_seq;
    struct canwatch can;
    uint32_t can_sent; /* queued; of them errors.removed were dropped later */
    uint32_t serial_sent;
    uint16_t serial_dropped;
    uint16_t serial_bad;
    uint16_t blocks_lost;

    uint32_t said[2][MR_PLACES]; /* by link, CAN and serial: times a message was meant for it */
    unsigned count_place;        /* whose count is told next */

    unsigned item;       /* of the configuration, next to go out */
    bool bursting;       /* one item per block, up to the last */

    struct blackbox *box; /* keeps what a landing's record needs; NULL: none */
    bool to_box;          /* what is said now goes to the box alone */
};

enum telemetry_way { TELEMETRY_BOTH, TELEMETRY_CAN, TELEMETRY_SERIAL };

void telemetry_start(struct telemetry *telemetry);
/* A message that is no part of a landing's record. */
void telemetry_send(struct telemetry *telemetry, enum telemetry_way way, uint16_t id, const uint8_t *payload, size_t length);
/* On CAN, whatever its state. */
bool telemetry_probe(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length);

/* The regular messages of one block: clock, health, faults, state, hello, configuration. Sent even without blocks. */
void telemetry_regular(struct telemetry *telemetry, const struct landing *landing, const float *slack_in,
                       uint32_t index, uint32_t tick);
/* Send the whole configuration, one item per block from the next one on, hello first. */
void telemetry_burst(struct telemetry *telemetry, const struct landing *landing);

/* A message that another file has put together, on both links. */
void telemetry_put(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length);
void telemetry_block(struct telemetry *telemetry, const struct mr_block *block);
/* `fitted`: bit i, transducer or gage i is there. Messages without any that is are not sent. */
void telemetry_displacements(struct telemetry *telemetry, const float value_in[MR_TRANSDUCERS], uint32_t fitted, uint32_t index);
void telemetry_tensions(struct telemetry *telemetry, const float value_lb[MR_GAGES], uint32_t fitted, uint32_t index);
void telemetry_state(struct telemetry *telemetry, const struct landing *landing);
void telemetry_edge(struct telemetry *telemetry, const struct mr_edge *edge);
void telemetry_switch(struct telemetry *telemetry, const struct mr_switch_event *event);
void telemetry_pushback(struct telemetry *telemetry, const struct landing *landing, uint32_t index);
void telemetry_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion, uint32_t index);
void telemetry_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary);
void telemetry_channel_event(struct telemetry *telemetry, const struct mr_channel_event *event);
void telemetry_channel_quality(struct telemetry *telemetry, const struct mr_channel_quality *quality);
void telemetry_mark(struct telemetry *telemetry, const struct mr_mark *mark);
void telemetry_sync(struct telemetry *telemetry, const struct mr_sync *sync);
void telemetry_sync_at(struct telemetry *telemetry, const struct mr_sync_at *sync_at);
void telemetry_film_frame(struct telemetry *telemetry, const struct mr_film_frame *frame);
void telemetry_camera(struct telemetry *telemetry, const struct mr_camera *camera);
void telemetry_ack(struct telemetry *telemetry, const struct mr_ack *ack);

/* From now on, what is put goes into the configuration of the box's record alone, if there is a box; or on the links again. */
void telemetry_to_box(struct telemetry *telemetry, bool to_box);
/* The whole configuration, hello and site included, into the box's record of a landing that was armed. */
void telemetry_store_configuration(struct telemetry *telemetry, const struct landing *landing, const float *slack_in);
void telemetry_box(struct telemetry *telemetry, const struct mr_box_state *state, const struct mr_box_space *space);
/* The span is not sent for record 0, the end of the list. */
void telemetry_box_record(struct telemetry *telemetry, const struct mr_box_record *record, const struct mr_box_span *span);
void telemetry_box_end(struct telemetry *telemetry, const struct mr_box_end *end);
void telemetry_box_part(struct telemetry *telemetry, const uint8_t *payload, size_t length);
void telemetry_temperature(struct telemetry *telemetry, float temperature_c, float error_c, uint32_t index);
/* A message of the slow log (slowlog.h). */
void telemetry_slow(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length);

#endif
