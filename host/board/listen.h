/* Listening to a board over a link's serial bytes, for commands that ask it something and wait for the answer. */
#ifndef MATRIG_HOST_LISTEN_H
#define MATRIG_HOST_LISTEN_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/framing.h"
#include "host/link/link.h"

/* What to do with a frame; anything but MR_OK ends the listening. */
typedef enum mr_status listen_frame(void *context, const struct mr_frame *frame, struct error *error);

/* Gives each whole frame that comes within a tenth of a second to `take`. MR_OK also when none came; MR_CLOSED, MR_IO; what `take`
 * returned. */
enum mr_status listen_tenth(struct link *link, struct mr_deframer *deframer, listen_frame *take, void *context,
                            struct error *error);

/* The same over a link of either kind, for what is asked over CAN as well as over serial: each message to `take`. */
typedef enum mr_status listen_message(void *context, uint32_t id, const uint8_t *payload, size_t length, struct error *error);
enum mr_status listen_either(struct link *link, enum link_kind kind, struct mr_deframer *deframer, listen_message *take, void *context,
                             struct error *error);
/* Sends a message over either; `*seq` counts serial frames. */
enum mr_status listen_send(struct link *link, enum link_kind kind, uint16_t *seq, uint16_t id, const uint8_t *payload, size_t length,
                           struct error *error);

/* MR_OK: the hello is of a board that speaks this matrig's layout, or broken; else MR_VERSION. */
enum mr_status listen_hello(const struct link *link, const uint8_t *bytes, size_t length, struct error *error);

/* Whether this is the answer to the command of that tag; into `ack` then. */
bool listen_ack(const uint8_t *bytes, size_t length, uint16_t tag, struct mr_ack *ack);

/* For deadlines, seconds: never jumps. */
double listen_now_s(void);

#endif
