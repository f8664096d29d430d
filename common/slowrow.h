/* A row of the slow log, as it stands in the memory. Little-endian, 64 bytes:
 *
 *     seq u32 | block u32 | faults u32 | temperature i16 | displacement[8] i16 | tension[14] i16 |
 *     boot u8 | state u8 | CRC-32 u32
 *
 * in the resolutions of the messages slow_row, slow_state, slow_displacement and slow_tension; the
 * CRC is that of everything before it. A row travels as MR_SLOWROW_PARTS of those messages, in
 * order. */
#ifndef MATRIG_COMMON_SLOWROW_H
#define MATRIG_COMMON_SLOWROW_H

#include "common/block.h"
#include "common/catalogue.h"

#define MR_SLOWROW       64u
#define MR_SLOWROW_PARTS 10u

struct mr_slowrow {
    uint32_t seq;   /* counts on for ever, from 1; 0: not kept */
    uint32_t block; /* of its boot */
    uint32_t faults;
    float temperature_c;                   /* NaN: missing; likewise the others */
    float displacement_in[MR_TRANSDUCERS]; /* means */
    float tension_lb[MR_GAGES];
    uint8_t boot, state; /* as in the message slow_state */
};

void mr_slowrow_put(const struct mr_slowrow *row, uint8_t bytes[MR_SLOWROW]);
/* MR_OK; MR_TOO_FEW: erased, all ones; MR_CRC: neither erased nor a whole row. */
enum mr_status mr_slowrow_get(struct mr_slowrow *row, const uint8_t bytes[MR_SLOWROW]);

/* The identifier and payload of part `part`, from 0. Returns the payload's length. */
size_t mr_slowrow_part(const struct mr_slowrow *row, unsigned part, uint16_t *id,
                       uint8_t payload[MR_MESSAGE_MAX]);

/* Puts parts together that come in order; one that is lost loses its row. Zero is the beginning. */
struct mr_slowrow_reader {
    struct mr_slowrow row;
    unsigned parts;
};
/* MR_OK: `reader->row` is whole; MR_TOO_FEW: not yet; MR_UNKNOWN: no part of a row, or none that
 * follows. */
enum mr_status mr_slowrow_take(struct mr_slowrow_reader *reader, uint16_t id,
                               const uint8_t *payload, size_t length);

#endif
