/* The run file: the physical truth of one landing as text (`matrig-run 1`), read once and then
 * constant. Lines with truth that the board must not know (touchdown, transducer, gage, gap_in ...)
 * are ignored.
 *
 * Truth is linear between samples and constant before the first and after the last sample.
 * Displacements are in inches, downfield positive; tensions are in pounds. Times are seconds of
 * virtual time since power on. */
#ifndef MATRIG_HIL_RUNFILE_H
#define MATRIG_HIL_RUNFILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/status.h"
#include "hil/core/file_place.h"

#define HIL_RUN_SWITCHES              24u
#define HIL_RUN_TRANSDUCERS           8u
#define HIL_RUN_GAGES                 14u
#define HIL_RUN_COLUMNS               (HIL_RUN_TRANSDUCERS + HIL_RUN_GAGES)
#define HIL_RUN_TRAINS                2u /* brake, wheel */
#define HIL_RUN_FIRST_CAPTURE_CHANNEL 2u /* capture channel of the first train (hil_capture_pins) */
#define HIL_RUN_NEVER                 UINT64_MAX

/* The pulses on one input. The unit of their times depends on the file. */
struct hil_pulse_train {
    uint64_t *rise_times; /* times of the rising edges, in ascending order */
    size_t pulse_count;
};

struct hil_pulse_train_state {
    uint32_t next_pulse; /* next pulse */
    bool is_high;
};

/* Returns the time of the next edge of the input, rising or falling, for pulses of this width;
 * HIL_RUN_NEVER: there is none. */
uint64_t hil_pulse_train_next_edge(const struct hil_pulse_train *train,
                                   const struct hil_pulse_train_state *state, uint64_t width);
/* Moves the state past the next edge. */
void hil_pulse_train_pass_edge(struct hil_pulse_train_state *state);

struct hil_run_command {
    uint64_t t_ps;
    bool is_sent_by_serial; /* true: sent by serial; false: by CAN */
    /* message with its tag: 1 for the first command of the file, then 2, 3, ... */
    struct mr_command message;
};

struct hil_run {
    double duration_s;
    unsigned switch_count; /* number in the file; always HIL_RUN_SWITCHES */
    /* indexed by position - 1; HIL_RUN_NEVER: the switch does not open */
    uint64_t switch_open_ps[HIL_RUN_SWITCHES];
    double switch_ft[HIL_RUN_SWITCHES];                 /* true station of the switch */
    struct hil_pulse_train pulse_train[HIL_RUN_TRAINS]; /* brake, wheel; times in ps */
    size_t command_count;
    struct hil_run_command *commands; /* commands in order of time */
    double sample_rate_hz;
    size_t sample_count; /* at least 1 */
    /* samples: 8 displacements in 1e-5 in, then 14 tensions in 0.01 lb */
    int32_t (*samples)[HIL_RUN_COLUMNS];
};

/* Reads a file. On failure no memory remains allocated, and `error` (size bytes) describes the
 * fault with file and line. MR_OK; MR_IO: cannot be read; MR_MALFORMED, MR_TRUNCATED, MR_CRC,
 * MR_VERSION: not a complete run file of version 1. */
enum mr_status hil_run_read(const char *path, struct hil_run *run, char *error, size_t size);

/* Frees the memory owned by the run; the struct itself belongs to the caller. */
void hil_run_free(struct hil_run *run);

/* Returns the true value at `t_s`. Columns 0 to 7: displacement in inches; 8 to 21: tension in
 * pounds. */
double hil_run_get_true_value(const struct hil_run *run, unsigned column, double t_s);

/* A text file whose first line contains its kind and version, and whose last line is `end` with the
 * CRC-32 of everything before it. */
struct hil_text_file {
    struct hil_file_context context; /* context.line: number of the present line */
    char *bytes, *next;              /* the caller must free `bytes`, also after a failure */
    size_t size;
};

/* Reads a file of this kind ("matrig-run"); `context` must be set. MR_OK, MR_IO, MR_MALFORMED,
 * MR_VERSION, MR_TRUNCATED, MR_CRC, MR_TOO_LONG. */
enum mr_status hil_text_file_open(struct hil_text_file *record, const char *kind);
/* Returns the next line without its newline. Blank lines and lines that begin with # are skipped.
 * NULL: no more lines. */
char *hil_text_file_next_line(struct hil_text_file *record);
/* Makes room for one more element in an array of `count` elements of `size` bytes and returns it.
 * Aborts if there is no memory, as the board does. */
void *hil_array_grow(void *array, size_t count, size_t size);

#endif
