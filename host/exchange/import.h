/* matrig import: files of other programs into the campaign. Candump logs of our own boards, and
 * readings of other instruments by a mapping: a table of numbers as other programs write it, or the
 * signals of CAN frames in a candump log. A line that is none is passed over and counted; the
 * verdict names the first. */
#ifndef MATRIG_HOST_EXCHANGE_IMPORT_H
#define MATRIG_HOST_EXCHANGE_IMPORT_H

#include "host/base/cli.h"
#include "host/exchange/mapping.h"
#include "host/link/candump.h"
#include "host/store/store.h"

/* A whole file as text, with its SHA-256. */
struct textfile {
    char *text; /* no final zero */
    size_t length;
    char sha256[65];
};

/* MR_IO: cannot be read. Release with textfile_close, also after an error. */
enum mr_status textfile_open(const char *path, struct textfile *file, struct error *error);
void textfile_close(struct textfile *file);

#define IMPORT_RUNS_MAX 1000u

struct import_request {
    const struct cli *cli;
    const char *path;
    uint16_t base;         /* of the board on it (common/canbase.h) */
    int64_t like;          /* RUN whose gear and survey it shares; 0: none */
    const char *interface; /* of a log of several buses; NULL: on which the board speaks */
};

struct import_result {
    struct verdict verdict;
    int64_t session;
    int64_t run[IMPORT_RUNS_MAX];
    size_t runs;
    size_t rows;                 /* taken: frames, or rows of a table */
    char bus[CANDUMP_INTERFACE]; /* whose frames are taken; "": a table */
    uint64_t elsewhere;          /* frames of other interfaces */
    int64_t trouble[LINK_TROUBLES];
    struct store_link_counts counts;
};

/* There is a frame in it, else MR_MALFORMED; sets the result's bus. MR_USAGE: boards speak on
 * several. */
enum mr_status import_candump_check(const struct textfile *file,
                                    const struct import_request *request,
                                    struct import_result *result, struct error *error);
/* Frames of our own boards: landings as if they had been logged. A transaction is
 * open; it is committed now and then. */
enum mr_status import_candump(struct store *store, const struct textfile *file,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

/* Fills the series of the mapping's channels. A line that is no row is passed over; the verdict
 * names the first. MR_MALFORMED: a column is not there, no row is good, or more than one in ten is
 * not. `rows`: taken. */
enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct verdict *verdict, struct error *error);

/* The next frame to be taken of a candump log in memory; `at`: where it goes on. */
bool candump_log_next(struct candump_log *log, const struct textfile *file, const char **at,
                      struct candump_line *line);

/* Frames of other instruments: the mapping's series from a candump log, times in s since its first
 * frame. MR_MALFORMED: none of them is in it. */
enum mr_status import_read_signals(const struct textfile *file,
                                   const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error);

/* The series of the mapping as one landing of a session of its own, in the transaction that is
 * open. By 1 ms blocks: faster samples as their mean over a block, slower ones by straight lines
 * between them; a gap stays one. With request->like the gear, switches, survey and configuration
 * are that landing's, and time is its time. MR_MALFORMED: nothing to put in a landing, or more than
 * an hour; MR_USAGE. */
enum mr_status import_landing(struct store *store, struct mapping *mapping,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

/* One channel by blocks, its time in us of the board: reading[i] is that of block first + i; NaN:
 * missing. `usual_us`: between samples. Pure, for tests. */
void import_resample(const struct series *series, double base_us, double usual_us, double gap_us,
                     int64_t first, size_t blocks, float *reading);

#endif
