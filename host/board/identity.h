/* What a board says about itself and its image, over serial: hello and what follows it, once a second. */
#ifndef MATRIG_HOST_BOARD_IDENTITY_H
#define MATRIG_HOST_BOARD_IDENTITY_H

#include "common/catalogue.h"
#include "common/framing.h"
#include "common/image.h"
#include "host/link/link.h"

struct identity {
    struct mr_hello hello;
    uint32_t uid[3];
    uint32_t image_crc; /* of the program, as the board computed it at start */
    bool commit_known;  /* it told these two as well */
    struct mr_image_commit commit;
    struct mr_image_header header;
};

struct identity_talk {
    struct link *link; /* the caller's */
    struct mr_deframer deframer;
    uint16_t seq;
    bool hello, image; /* came */
    struct identity identity;
    struct mr_ack ack;
    bool acknowledged;
};

void identity_begin(struct identity_talk *talk, struct link *link);
/* Listens until all of it came, at most timeout_ms. MR_OK; MR_TIMEOUT without setting `error`: no board said hello; else the
 * link's error. The layout in hello is the caller's to look at. */
enum mr_status identity_listen(struct identity_talk *talk, unsigned timeout_ms, struct error *error);
/* Sends a command and waits for its answer, at most timeout_ms. `*answer`: what the board answered. MR_TIMEOUT: nothing. */
enum mr_status identity_order(struct identity_talk *talk, uint8_t code, unsigned timeout_ms, enum mr_status *answer, struct error *error);

/* Does the board run this image, whole? Else `why` says in what they differ. */
bool identity_runs(const struct identity *identity, const struct mr_image *image, char *why, size_t size);

#endif
