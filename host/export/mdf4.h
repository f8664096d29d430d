/* MDF4: measurement data as ASAM's MDF 4.10 has it, put together in memory and written in one
 * piece.
 *
 * A file is a row of blocks that name each other by their addresses: header (HD), its history (FH),
 * per table a data group (DG), a channel group (CG), its channels (CN), their texts (TX, MD) and
 * the rows (DT); attached files (AT). Layouts are those of the standard's base part, bus logging
 * those of its associated standard: a channel CAN_DataFrame with its parts.
 *
 * One table is open at a time: mdf4_table, mdf4_channel for each column, mdf4_row for each row,
 * mdf4_table_end. Memory that runs short is kept in mind until mdf4_write, which then fails. */
#ifndef MATRIG_HOST_MDF4_H
#define MATRIG_HOST_MDF4_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/base/error.h"

struct mdf4 {
    uint8_t *bytes; /* the file so far; NULL after memory ran short */
    size_t length, room;
    bool full;
    uint64_t header, last_group, last_attachment;
    uint64_t group, rows_block, last_channel; /* of the table that is open */
    uint64_t channel_group;
    uint64_t part_of; /* channel whose parts follow; 0: none */
    uint64_t last_part;
    uint64_t rows;
    unsigned row_bytes, invalid_bytes;
};

enum mdf4_type { MDF4_UNSIGNED = 0, MDF4_SIGNED = 2, MDF4_REAL = 4, MDF4_BYTES = 10 };

struct mdf4_channel {
    const char *name, *unit, *comment; /* unit, comment: NULL, none */
    enum mdf4_type type;
    unsigned offset, bytes; /* in the row */
    bool is_time;           /* the master of the table: seconds */
    int invalid_bit;        /* in the invalidation bytes; -1: always valid */
    bool has_parts;         /* the channels up to mdf4_parts_end are its parts */
    uint64_t attachment;    /* a file that describes it; 0: none */
};

/* `start_ns`: Unix time of second 0. `comment`: what is in the file. */
void mdf4_start(struct mdf4 *file, uint64_t start_ns, const char *comment,
                const char *tool_version);
/* An attached file. Returns its address. */
uint64_t mdf4_attach(struct mdf4 *file, const char *name, const char *mime_type, const void *bytes,
                     size_t length);
/* `can_channel` 0: a table of readings; else frames of that CAN bus. Rows have row_bytes, then
 * invalid_bytes with a bit for each channel that has one. */
void mdf4_table(struct mdf4 *file, const char *name, const char *comment, unsigned row_bytes,
                unsigned invalid_bytes, unsigned can_channel);
void mdf4_channel(struct mdf4 *file, const struct mdf4_channel *channel);
void mdf4_parts_end(struct mdf4 *file);
/* row_bytes + invalid_bytes. The first row ends the channels. */
void mdf4_row(struct mdf4 *file, const uint8_t *row);
void mdf4_table_end(struct mdf4 *file);

/* Writes and releases. MR_FULL when memory ran short; the caller checks the stream. */
enum mr_status mdf4_write(struct mdf4 *file, FILE *out, struct error *error);

#endif
