/* Frames of other instruments in a candump log: their signals, by a mapping. */
#include "host/import/candump_log.h"
#include "host/import/import.h"
#include "host/import/mapping.h"

enum mr_status import_read_signals(const struct textfile *file, const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error)
{
    struct candump_log log;
    struct candump_line line;
    uint64_t first_us = 0;
    size_t frames = 0;
    enum mr_status status = MR_OK;
    candump_log_start(&log, file->text, file->length, request->interface);
    while (status == MR_OK && candump_log_next(&log, &line)) {
        bool taken = false;
        first_us = frames++ ? first_us : line.frame.host_us;
        double time_s = 1e-6 * (double)(int64_t)(line.frame.host_us - first_us);
        for (size_t c = 0; c < mapping->channels && status == MR_OK; c++) {
            struct mapping_channel *channel = &mapping->channel[c];
            struct series *series = &channel->series;
            double value;
            if (!signal_value(&channel->signal, &line.frame, &value))
                continue;
            if (series->count && time_s <= series->time_s[series->count - 1]) { /* a log is in order; two of one time are one */
                log.verdict.bad_lines++;
                verdict_set(&log.verdict, MR_MALFORMED, log.line, 1, "the time does not go on");
                continue;
            }
            status = series_add(series, time_s * mapping->time_unit_s, value * channel->scale + channel->offset);
            taken = true;
        }
        result->rows += taken;
    }
    result->verdict = log.verdict;
    result->elsewhere = log.elsewhere;
    if (status == MR_FULL)
        return error_set(error, status, "no memory: %s line %zu; import it in parts", request->path, log.line);
    if (result->rows == 0)
        return error_set(error, MR_MALFORMED, "none of the mapping's signals in %zu frames: %s; see its ids, and --interface", frames,
                         request->path);
    return MR_OK;
}
