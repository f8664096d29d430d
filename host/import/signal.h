/* A number in a CAN frame: where its bits lie and what they mean, as DBC files count bits. Pure. */
#ifndef MATRIG_HOST_IMPORT_SIGNAL_H
#define MATRIG_HOST_IMPORT_SIGNAL_H

#include <stdbool.h>
#include <stddef.h>

#include "host/link/link.h"

struct import_signal {
    uint32_t id; /* LINK_ID_EXTENDED included */
    /* bits 0: no signal. start_bit: lowest bit (little-endian), or highest (big-endian), as DBC
     * counts */
    unsigned start_bit, bits;
    bool is_signed, big_endian, is_float;
};

/* The bits lie within `length` bytes. */
bool signal_fits(const struct import_signal *signal, unsigned length);
/* False: another frame, or a shorter one. */
bool signal_value(const struct import_signal *signal, const struct link_frame *frame,
                  double *value);

#endif
