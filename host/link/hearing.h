/* What a link has heard, before a board is understood on it: how much, whether any of it is a
 * frame, and what rate the sender of a line probably has. A UART that samples at another rate than
 * the sender's sees each bit for longer or shorter: at twice the rate two samples a bit, so that
 * what comes has no zero alone. Nothing of this is looked at once a frame was whole. Pure but for
 * the time, which is given. */
#ifndef MATRIG_HOST_LINK_HEARING_H
#define MATRIG_HOST_LINK_HEARING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/framing.h"

#define HEARING_SAMPLES 10u /* of a byte: start bit, eight of data, stop bit */

struct hearing {
    uint64_t begun_us; /* by the monotonic clock */
    uint64_t bytes;
    uint64_t frames; /* serial: with a good CRC; counting ends with the first */
    uint64_t bad;    /* ends of frames that are none */
    int baud;        /* of the line; 0: it has none */
    /* bytes by their length of low level from the start bit on, from 1 */
    uint64_t lead[HEARING_SAMPLES];
    /* and what is level between two changes inside of bytes, by length, from 1 */
    uint64_t inner[HEARING_SAMPLES];
    struct mr_deframer deframer;
};

void hearing_start(struct hearing *hearing, uint64_t now_us, int baud);
void hearing_bytes(struct hearing *hearing, const uint8_t *bytes, size_t length);

/* How many times slower than this line the sender is, by what came: 1.5 to 8.5; INFINITY: more than
 * that; 1: as fast, or faster; 0: not known, too little came. */
double hearing_times_slower(const struct hearing *hearing);
/* The usual rates that a sender so many times slower than `baud` may have; how many. */
#define HEARING_USUAL 3u
unsigned hearing_usual_near(int baud, double slower, int near[HEARING_USUAL]);
/* The usual rates, the board's own first, 0 after the last. Static storage. */
const int *hearing_usual_bauds(void);

#endif
