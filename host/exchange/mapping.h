/* A mapping of the columns of another instrument's table, or of the signals in its CAN frames, to
 * matrig's channels: a JSON file. `matrig import --help` explains its keys. `header_lines` is the
 * number of lines above the first row, including blank lines but not comments. A column is given by
 * its name in the last header line, or by its number from 1. value = (number in the file * scale +
 * offset) in `unit`. An 8-digit id is an extended identifier.
 *
 * Without "align", time 0 is touchdown of the landing given with --like; without --like, the table
 * keeps its own time. */
#ifndef MATRIG_HOST_EXCHANGE_MAPPING_H
#define MATRIG_HOST_EXCHANGE_MAPPING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/link/link.h"

#define MAPPING_CHANNELS_MAX 100u
#define MAPPING_NAME_SIZE    80u
#define MAPPING_MISSING_MAX  16u

/* A number in a CAN frame: the position of its bits, counted as in DBC files. */
struct import_signal {
    uint32_t id; /* includes LINK_ID_EXTENDED */
    /* bits 0: no signal. start_bit: lowest bit (little-endian) or highest bit (big-endian), counted
     * as in DBC files. */
    unsigned start_bit, bit_count;
    bool is_signed, is_big_endian, is_float;
};

/* Samples of one column in file order, without the missing ones. */
struct series {
    double *time_s, *value; /* time in the file, s; value in ft, inches or pounds */
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
    unsigned number; /* number of the transducer, gage or switch */
    /* name of the column; empty: the column is given by number, or the channel is a signal */
    char column_name[MAPPING_NAME_SIZE];
    unsigned column_index; /* column number, from 1; 0: the column is given by its name */
    struct import_signal signal;
    double scale, offset; /* conversion of the file's numbers to the report's unit */
    double threshold;
    bool is_falling_edge;
    double station_ft;     /* NaN: the mapping does not give it */
    double standard_error; /* standard error, in the report's unit; NaN: not given */
    struct series series;
};

struct mapping {
    bool reads_signals; /* true: signals of CAN frames; false: columns of a table */
    char separator, decimal_mark, comment_char; /* comment_char '\0': the table has no comments */
    unsigned header_lines;
    char missing_words[MAPPING_MISSING_MAX][16];
    size_t missing_word_count;
    bool may_lack_newline; /* the last line may lack a newline */
    char time_column[MAPPING_NAME_SIZE];
    unsigned time_column_index;
    double time_unit_s, time_shift_s;
    /* Longest time between samples; a longer one means missing data. NaN: one and a half times the
     * usual time. */
    double gap_min_s;
    double touchdown_ft, switch_error_ft; /* NaN: the mapping does not give them */
    struct mapping_channel channel[MAPPING_CHANNELS_MAX];
    size_t channel_count;
    char *json_text; /* the mapping as JSON, for storage in the campaign */
};

/* Parses a mapping. `path`: for error messages. MR_MALFORMED: `error` has the position. The caller
 * releases it with mapping_free, also after an error. */
enum mr_status mapping_parse(const char *text, size_t length, const char *path,
                             struct mapping *mapping, struct error *error);
void mapping_free(struct mapping *mapping);

/* True if all bits of the signal are within the first `length` bytes. */
bool signal_fits_frame(const struct import_signal *signal, unsigned length);
/* Extracts the signal. Returns false for another frame, or for a frame that is too short. */
bool signal_extract_value(const struct import_signal *signal, const struct link_frame *frame,
                          double *value);

#define MAPPING_VALUE_MAX 1e30 /* A float can hold this value, and a double its square. */
/* Converts a number of the file to the report's unit. */
double mapping_convert_value(const struct mapping_channel *channel, double read);
void series_add_sample(struct series *series, double time_s, double value);

#endif
