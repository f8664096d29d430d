/* matrig import: files of other programs into the campaign. What each kind of file needs, and what
 * came of it. */
#ifndef MATRIG_HOST_EXCHANGE_IMPORT_H
#define MATRIG_HOST_EXCHANGE_IMPORT_H

#include "host/base/cli.h"
#include "host/exchange/textfile.h"
#include "host/store/store_import.h"

#define IMPORT_RUNS_MAX 1000u

struct import_request {
    const struct cli *cli;
    const char *path;
    const char *interface; /* of a candump log; NULL: its only one */
    uint16_t base;         /* of the board on it (common/canbase.h) */
    int64_t like;          /* RUN whose gear and survey it shares; 0: none */
};

struct import_result {
    struct verdict verdict;
    int64_t session;
    int64_t run[IMPORT_RUNS_MAX];
    size_t runs;
    size_t rows;      /* taken: frames, or rows of a table */
    size_t elsewhere; /* frames of other interfaces */
    struct store_link_counts counts;
};

#define IMPORT_INTERFACE 64u
/* There is a frame in it, of the interface asked for: else MR_MALFORMED, MR_USAGE. `name`: the
 * interface to take. */
enum mr_status import_candump_check(const struct textfile *file,
                                    const struct import_request *request,
                                    char name[IMPORT_INTERFACE], struct error *error);
/* Frames of our own boards: landings as if they had been logged. The store is open; transactions
 * are made here. */
enum mr_status import_candump(struct store *store, const struct textfile *file,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

#endif
