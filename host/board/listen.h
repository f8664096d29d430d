/* Listening to a board over a link's serial bytes, for commands that ask it something and wait for the answer. */
#ifndef MATRIG_HOST_LISTEN_H
#define MATRIG_HOST_LISTEN_H

#include "common/framing.h"
#include "host/link/link.h"

/* What to do with a frame; anything but MR_OK ends the listening. */
typedef enum mr_status listen_frame(void *context, const struct mr_frame *frame, struct error *error);

/* Gives each whole frame that comes within a tenth of a second to `take`. MR_OK also when none came; MR_CLOSED, MR_IO; what `take`
 * returned. */
enum mr_status listen_tenth(struct link *link, struct mr_deframer *deframer, listen_frame *take, void *context,
                            struct error *error);

/* MR_OK: the hello is of a board that speaks this matrig's layout, or broken; else MR_VERSION. */
enum mr_status listen_hello(const struct link *link, const uint8_t *bytes, size_t length, struct error *error);

#endif
