/* matrig import: files of other programs into the campaign. Candump logs of matrig boards are
 * imported as landings. Readings of other instruments are imported by a mapping, from a table of
 * numbers or from the signals of CAN frames in a candump log. Invalid lines are skipped and
 * counted; the result names the first one. */
#ifndef MATRIG_HOST_EXCHANGE_IMPORT_H
#define MATRIG_HOST_EXCHANGE_IMPORT_H

#include "host/base/cli.h"
#include "host/exchange/mapping.h"
#include "host/link/candump.h"
#include "host/store/store.h"

/* A whole file as text, with its SHA-256. */
struct textfile {
    char *text; /* text of the file, without terminating zero */
    size_t length;
    char sha256[65];
};

/* Reads a whole file. MR_IO: it cannot be read. Release it with textfile_close, also after an
 * error. */
enum mr_status textfile_open(const char *path, struct textfile *file, struct error *error);
void textfile_close(struct textfile *file);

#define IMPORT_RUNS_MAX 1000u

struct import_request {
    const struct cli *cli;
    const char *path;
    uint16_t can_base;    /* base of the board on its bus (common/canbase.h) */
    int64_t template_run; /* RUN whose gear data and survey are used; 0: none */
    /* interface to import if the log has several; NULL: the one on which a board sends */
    const char *interface;
};

struct import_result {
    struct parse_result parsed;
    int64_t session;
    int64_t runs[IMPORT_RUNS_MAX];
    size_t run_count;
    size_t row_count; /* number of imported frames, or of rows of a table */
    /* interface of the imported frames; "": a table was imported */
    char bus[CANDUMP_INTERFACE_SIZE];
    uint64_t other_interface_frames; /* number of frames of other interfaces */
    int64_t link_fault_count[LINK_FAULT_COUNT];
    struct store_link_counts counts;
};

/* Checks that the log has a frame, otherwise MR_MALFORMED, and sets the result's bus. MR_USAGE:
 * boards send on several buses. */
enum mr_status import_candump_check(const struct textfile *file,
                                    const struct import_request *request,
                                    struct import_result *result, struct error *error);
/* Imports frames of matrig boards: landings are stored as if they had been logged. A transaction
 * must be open; it is committed at intervals. */
enum mr_status import_candump(struct store *store, const struct textfile *file,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

/* Reads a table and fills the series of the mapping's channels. Invalid lines are skipped;
 * `verdict` names the first one. MR_MALFORMED: a column is missing, no row is valid, or more than
 * one row in ten is invalid. `rows`: number of rows read. */
enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct parse_result *parse_outcome, struct error *error);

/* Finds the next frame to import in a candump log in memory, and moves `at` to the position after
 * it. */
bool candump_log_next(struct candump_log *log, const struct textfile *file, const char **at,
                      struct candump_line *line);

/* Fills the mapping's series from the signals in a candump log; times are in s since its first
 * frame. MR_MALFORMED: the log has none of the signals. */
enum mr_status import_read_signals(const struct textfile *file,
                                   const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error);

/* Stores the series of the mapping as one landing of a separate session, in the open transaction.
 * Series are resampled to 1 ms blocks: faster samples are averaged over each block, slower samples
 * are interpolated linearly; gaps are kept. If request->like is set, gear, switches, survey,
 * configuration and time base are copied from that landing. MR_MALFORMED: there is no data, or data
 * for more than an hour. MR_USAGE: the request does not fit the landing that `like` names. */
enum mr_status import_landing(struct store *store, struct mapping *mapping,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

/* Resamples one channel to blocks of the board: reading[i] belongs to block first + i; NaN:
 * missing. `sample_period_us`: usual time between samples. Pure function. */
void import_resample(const struct series *series, double base_us, double sample_period_us,
                     double gap_us, int64_t first, size_t blocks, float *reading);

#endif
