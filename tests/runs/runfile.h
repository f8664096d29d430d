/* Run file: writes a synthetic landing as the text that the emulated board's rig plays back.
 *
 *   matrig-run 1
 *   provenance TEXT | landing N | duration_s S | touchdown STATION_FT T_S | truth NAME VALUE
 *   switch POSITION NOMINAL_FT TRUE_FT T_OPEN_S|-        T_OPEN_S with nine decimals
 *   transducer CHANNEL STATION_FT | gage CHANNEL STATION_FT BAND
 *   gap_in ... | gap_end_in ...                          421 numbers in lines of up to ten
 *   brake T_S | wheel T_S                                edge on PB10, on PB11; in order of time
 *   command T_S can|serial NAME [ARGUMENTS]              in order of time
 *   samples COUNT RATE_HZ        then COUNT rows of 22 integers: eight displacements in 1e-5 in and
 *                                fourteen tensions in 0.01 lb; a row xN: the row before, N times
 *                                more
 *   end CRC                      zlib's CRC-32 of every byte before this line, eight hex digits
 *
 * The whole text is built in memory and written at once, by rename, so a file is whole or not
 * there. */
#ifndef MATRIG_TESTS_RUNS_RUNFILE_H
#define MATRIG_TESTS_RUNS_RUNFILE_H

#include <stdbool.h>
#include <stddef.h>

#define SYN_RUN_BYTES_MAX   (4u << 20)
#define SYN_SAMPLE_CHANNELS 22

struct syn_run {
    size_t used;
    bool full;        /* text was lost: the run must not be written */
    unsigned repeats; /* rows equal to `row` not yet written */
    bool has_row;
    long row[SYN_SAMPLE_CHANNELS];
    char text[SYN_RUN_BYTES_MAX];
};

void syn_run_clear(struct syn_run *run);

/* printf onto the end of the text. */
void syn_run_add(struct syn_run *run, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* `count` numbers, ten a line, each line starting with the keyword. */
void syn_run_numbers(struct syn_run *run, const char *keyword, const double *values, int count);

/* One sample row; equal rows are gathered. */
void syn_run_sample(struct syn_run *run, const long *row);

/* Close with the checksum and write the file. false: errno says why (EFBIG: more text than
 * SYN_RUN_BYTES_MAX). */
bool syn_run_write(struct syn_run *run, const char *path);

#endif
