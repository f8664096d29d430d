/* What the columns of another instrument's table, or the signals in its CAN frames, are to matrig:
 * a JSON file.
 * (matrig import --help has its keys). `header_lines` counts the lines above the rows as an editor
 * does, blank ones too, but no comments. A column is named as the last of them names it, or counted
 * from 1. value = (what stands there * scale + offset) in `unit`; an 8-digit id is an extended one.
 *
 * Without "align" time 0 is touchdown of the landing that it is put beside (--like); without that
 * landing the table has its own time. */
#ifndef MATRIG_HOST_EXCHANGE_MAPPING_H
#define MATRIG_HOST_EXCHANGE_MAPPING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/link/link.h"

#define MAPPING_CHANNELS 100u
#define MAPPING_NAME     80u
#define MAPPING_WORDS    16u

/* A number in a CAN frame: where its bits lie, as DBC files count bits. */
struct import_signal {
    uint32_t id; /* LINK_ID_EXTENDED included */
    /* bits 0: no signal. start_bit: lowest bit (little-endian), or highest (big-endian), as DBC
     * counts */
    unsigned start_bit, bits;
    bool is_signed, big_endian, is_float;
};

/* Samples of one column as they come: those that are missing are not there. */
struct series {
    double *time_s, *value; /* in the file's time, and in ft, in or lb */
    size_t count;
};

enum mapping_role {
    MAPPING_DISPLACEMENT,
    MAPPING_TENSION,
    MAPPING_GEAR,
    MAPPING_SWITCH,
    MAPPING_ALIGN
};

struct mapping_channel {
    enum mapping_role role;
    unsigned number;           /* of the transducer, gage or switch */
    char column[MAPPING_NAME]; /* empty: it is counted, or a signal */
    unsigned place;            /* of the column, from 1; 0: to be found by its name */
    struct import_signal signal;
    double scale, offset; /* to the report's unit */
    double threshold;
    bool falling;
    double station_ft; /* NaN: not told */
    double error;      /* standard error, in the report's unit; NaN: not told */
    struct series series;
};

struct mapping {
    bool signals;                     /* of CAN frames; else columns of a table */
    char separator, decimal, comment; /* comment '\0': none */
    unsigned header_lines;
    char missing[MAPPING_WORDS][16];
    size_t missing_count;
    bool last_line_open; /* the last line needs no newline */
    char time_column[MAPPING_NAME];
    unsigned time_place;
    double time_unit_s, shift_s;
    /* between samples; a larger one is missing data. NaN: one and a half of the usual */
    double gap_s;
    double touchdown_ft, switch_error_ft; /* NaN: not told */
    struct mapping_channel channel[MAPPING_CHANNELS];
    size_t channels;
    char *text; /* as JSON, what the campaign keeps */
};

/* `path`: for errors. MR_MALFORMED: says where. The caller releases it with mapping_free, also
 * after an error. */
enum mr_status mapping_parse(const char *text, size_t length, const char *path,
                             struct mapping *mapping, struct error *error);
void mapping_free(struct mapping *mapping);

/* The bits lie within `length` bytes. */
bool signal_fits(const struct import_signal *signal, unsigned length);
/* False: another frame, or a shorter one. */
bool signal_value(const struct import_signal *signal, const struct link_frame *frame,
                  double *value);

#define MAPPING_VALUE_MOST 1e30 /* a float holds it, and a double its square */
/* What stands in the file, in the report's unit. */
double mapping_value(const struct mapping_channel *channel, double read);
void series_add(struct series *series, double time_s, double value);

#endif
