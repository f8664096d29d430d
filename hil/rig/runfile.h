/* The run file: physical truth of one landing as text (`matrig-run 1`), read once, then constant.
 * Lines of truth that the board must not know (touchdown, transducer, gage, gap_in ...) are passed
 * over.
 *
 * Truth between samples is linear; before the first and after the last sample it holds.
 * Displacements are in inches, downfield positive, tensions in pounds. Times are seconds of virtual
 * time since power on. */
#ifndef MATRIG_HIL_RUNFILE_H
#define MATRIG_HIL_RUNFILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/status.h"
#include "hil/core/file_place.h"

#define HIL_RUN_SWITCHES    24u
#define HIL_RUN_TRANSDUCERS 8u
#define HIL_RUN_GAGES       14u
#define HIL_RUN_COLUMNS     (HIL_RUN_TRANSDUCERS + HIL_RUN_GAGES)
#define HIL_RUN_NEVER       UINT64_MAX

struct hil_run_command {
    uint64_t t_ps;
    bool serial;               /* else by CAN */
    struct mr_command message; /* tag: 1 for the first command of the file, then rising */
};

struct hil_run {
    double duration_s;
    unsigned switches; /* read: HIL_RUN_SWITCHES */
    /* by position - 1; HIL_RUN_NEVER: it is not tripped */
    uint64_t switch_open_ps[HIL_RUN_SWITCHES];
    double switch_ft[HIL_RUN_SWITCHES]; /* where it really is */
    size_t command_count;
    struct hil_run_command *commands; /* rising in time */
    double rate_hz;
    size_t sample_count; /* at least 1 */
    /* 1e-5 in for 8 displacements, 0.01 lb for 14 tensions */
    int32_t (*samples)[HIL_RUN_COLUMNS];
};

/* Read a file. On failure nothing is kept and `error` (size bytes) describes the fault, with file
 * and line. MR_IO: cannot be read; MR_MALFORMED, MR_TRUNCATED, MR_CRC, MR_VERSION: not a whole run
 * file of version 1. */
enum mr_status hil_run_read(const char *path, struct hil_run *run, char *error, size_t size);

/* Frees what the run owns; the struct itself is the caller's. */
void hil_run_free(struct hil_run *run);

/* Truth at a time: column 0..7 displacement in inches, 8..21 tension in pounds. */
double hil_run_truth(const struct hil_run *run, unsigned column, double t_s);

/* A text file whose first line is a kind and its version, and whose last is `end` with the CRC-32
 * of everything before it. */
struct hil_record {
    struct hil_file_place at; /* line: the present one */
    char *bytes, *next;       /* bytes: the caller's to free, also after a failure */
    size_t size;
};

/* Read a file of that kind ("matrig-run"), `at` filled in. MR_IO, MR_MALFORMED, MR_VERSION,
 * MR_TRUNCATED, MR_CRC, MR_TOO_LONG. */
enum mr_status hil_record_open(struct hil_record *record, const char *kind);
/* The next line, without its end; blank lines and those that begin with # are skipped. NULL: no
 * more. */
char *hil_record_line(struct hil_record *record);

#endif
