/* SLCAN: the text that LAWICEL CANUSB adapters and many others speak on a serial port. Each line
 * ends with CR.
 *
 *     t1232A1B2          data frame, 11-bit identifier 123, length 2, bytes A1 B2
 *     T1F334455111       extended identifier 1F334455, length 1, byte 11
 *     r1238  R1F3344558  remote frames, with the length they ask for
 *     ...EA5F            with time stamps on (Z1): milliseconds, 0000 to EA5F, then 0000 again
 *     z  Z  (empty)      a command was done;  BEL instead of CR: it was not
 *     F00                answer to F: status flags
 *
 * Pure. Source: LAWICEL CANUSB manual, version 1.0. */
#ifndef MATRIG_HOST_LINK_SLCAN_H
#define MATRIG_HOST_LINK_SLCAN_H

#include <stddef.h>

#include "host/link/adapter_clock.h"
#include "host/link/link.h"

#define SLCAN_LINE_MAX      32u     /* T, 8 of identifier, length, 16 of data, 4 of time, CR */
#define SLCAN_STAMP_NONE    0xffffu /* no time stamp */
#define SLCAN_STAMP_WRAP_MS 60000u
#define SLCAN_STATUS_LOST   0x09u /* status flags of lost frames: receive FIFO full, data overrun */

enum slcan_kind {
    SLCAN_MORE,    /* the line goes on */
    SLCAN_FRAME,   /* `frame` but for its time, and `stamp_ms` */
    SLCAN_DONE,    /* a command was done: empty line, z or Z */
    SLCAN_REFUSED, /* BEL */
    SLCAN_STATUS,  /* `status` flags */
    SLCAN_ANSWER,  /* another answer: version, serial number */
    SLCAN_GARBLED, /* no line of the protocol: characters were lost, or it is no adapter */
};

struct slcan_parser {
    char line[SLCAN_LINE_MAX];
    size_t length;
    bool overlong; /* skipping to the end of a line that is too long */
    struct link_frame frame;
    unsigned stamp_ms;
    uint8_t status;
};

/* Next character. A zeroed parser is ready. */
enum slcan_kind slcan_push(struct slcan_parser *parser, char c);

/* The line of a frame with CR and final zero, without time stamp; returns its length. */
size_t slcan_print(const struct link_frame *frame, char out[SLCAN_LINE_MAX]);

/* Status flags as a CAN error frame (host/link/can_error.h), its time excepted. False: nothing is
 * wrong. */
bool slcan_status_frame(uint8_t status, struct link_frame *frame);

/* The adapter's clock (host/link/adapter_clock.h), which begins again each minute. */
struct slcan_clock {
    unsigned stamp_ms;
    uint64_t adapter_us; /* time stamp without wraps */
    uint64_t host_us;    /* when it came */
    struct adapter_clock clock;
};

/* Host time of a frame with this stamp that came at `host_us`, by a clock that is never set; never
 * later than that. */
uint64_t slcan_time(struct slcan_clock *clock, unsigned stamp_ms, uint64_t host_us);

#endif
