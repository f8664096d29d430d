/* Candump logs of matrig's own boards: through the collector, as matrig log takes them. */
#include <stdio.h>

#include "host/collect/collect.h"
#include "host/exchange/import.h"

/* Another process may want to write: it waits 5 s. */
#define COMMIT_US     200000u
#define FRAMES_A_LOOK 4096u

/* Its first frame's interface is the one that is meant. */
enum mr_status import_candump_check(const struct textfile *file,
                                    const struct import_request *request,
                                    char name[IMPORT_INTERFACE], struct error *error)
{
    struct candump_log log;
    struct candump_line line;
    candump_log_start(&log, file->text, file->length, NULL);
    if (!candump_log_next(&log, &line))
        return error_set(error, MR_MALFORMED,
                         "no frame in it: %s line %zu, column %zu; give a log that `candump -L` "
                         "wrote, or a table with "
                         "--map",
                         request->path, log.verdict.line ? log.verdict.line : 1,
                         log.verdict.column ? log.verdict.column : 1);
    snprintf(name, IMPORT_INTERFACE, "%.*s", (int)line.interface_length, line.interface);
    return MR_OK;
}

static enum mr_status take_finished(struct collector *collector, struct import_result *result)
{
    int64_t run;
    while ((run = collector_take_finished(collector)) != 0) {
        if (result->runs < IMPORT_RUNS_MAX)
            result->run[result->runs++] = run;
    }
    return MR_OK;
}

static enum mr_status commit_and_go_on(struct store *store, struct collector *collector,
                                       uint64_t *begun_us, struct error *error)
{
    enum mr_status status = collector_put_counts(collector, error);
    if (status == MR_OK)
        status = store_commit(store, error);
    if (status == MR_OK)
        status = store_begin(store, error);
    *begun_us = link_now_us();
    return status;
}

static enum mr_status take_frames(struct store *store, struct collector *collector,
                                  struct candump_log *log, struct import_result *result,
                                  struct error *error)
{
    struct candump_line line;
    uint64_t begun_us = link_now_us();
    enum mr_status status = MR_OK;
    while (status == MR_OK && candump_log_next(log, &line)) {
        status = collector_frame(collector, &line.frame, error);
        if (++result->rows % FRAMES_A_LOOK != 0 || status != MR_OK)
            continue;
        take_finished(collector, result);
        if (link_now_us() - begun_us >= COMMIT_US)
            status = commit_and_go_on(store, collector, &begun_us, error);
    }
    return status;
}

static enum mr_status end(struct store *store, struct collector *collector, struct candump_log *log,
                          struct import_result *result, enum mr_status status, struct error *error)
{
    struct error late = {0};
    struct collector_progress progress;
    enum mr_status ended = collector_end(collector, status == MR_OK ? "end" : "error", &late);
    take_finished(collector, result);
    collector_progress(collector, &progress);
    result->counts = progress.counts[LINK_CAN];
    result->counts.bad = (int64_t)log->verdict.bad_lines;
    if (ended == MR_OK)
        ended = store_link_put(store, result->session, LINK_CAN, &result->counts, &late);
    return ended == MR_OK || status != MR_OK ? status : error_set(error, ended, "%s", late.text);
}

enum mr_status import_candump(struct store *store, const struct textfile *file,
                              const struct import_request *request, struct import_result *result,
                              struct error *error)
{
    char interface[IMPORT_INTERFACE], spec[500];
    struct candump_log log;
    struct collector *collector = NULL;
    snprintf(spec, sizeof spec, "import:%s", request->path);
    enum mr_status status = import_candump_check(file, request, interface, error);
    if (status == MR_OK)
        status = collector_open(store, spec, request->base, NULL, &collector, error);
    if (status != MR_OK)
        return status;
    result->session = collector_session(collector);
    candump_log_start(&log, file->text, file->length, interface);
    status = take_frames(store, collector, &log, result, error);
    status = end(store, collector, &log, result, status, error);
    result->verdict = log.verdict;
    result->elsewhere = log.elsewhere;
    collector_close(collector);
    return status; /* the caller says of which file, and commits */
}
