/* Frames of other instruments in a candump log: their signals, by a mapping. */
#include <math.h>

#include "host/import/candump_log.h"
#include "host/import/import.h"
#include "host/import/mapping.h"
#include "host/import/stray.h"

struct signals {
    struct candump_log log;
    struct mapping *mapping;
    struct stray stray[MAPPING_CHANNELS];
    size_t last_line[MAPPING_CHANNELS]; /* of the last sample of each */
};

static void bad(struct signals *s, size_t line, const char *what)
{
    s->log.verdict.bad_lines++;
    verdict_set(&s->log.verdict, MR_MALFORMED, line, 1, what);
}

/* A log is in order; of two samples of one time the first counts. The sample before was wrong if
 * this one goes on from the one before that: one bad stamp must not cost all that follow. */
static bool goes_on(struct signals *s, size_t c, double time_s)
{
    struct series *series = &s->mapping->channel[c].series;
    size_t count = series->count;
    if (count == 0 || time_s > series->time_s[count - 1])
        return true;
    if (time_s == series->time_s[count - 1] || (count > 1 && time_s <= series->time_s[count - 2])) {
        bad(s, s->log.line, "the time does not go on");
        return false;
    }
    bad(s, s->last_line[c], "the time jumps");
    stray_take_back(&s->stray[c]);
    series->count--;
    return true;
}

/* `*taken`: a sample more. */
static enum mr_status take_sample(struct signals *s, size_t c, double time_s, double read,
                                  bool *taken)
{
    struct mapping_channel *channel = &s->mapping->channel[c];
    double value = mapping_value(channel, read);
    if (!(fabs(value) <= MAPPING_VALUE_MOST)) {
        bad(s, s->log.line, "a value that no instrument reads");
        return MR_OK;
    }
    if (!goes_on(s, c, time_s))
        return MR_OK;
    *taken = true;
    s->last_line[c] = s->log.line;
    enum mr_status status = stray_add(&s->stray[c], time_s, s->log.line);
    return status == MR_OK ? series_add(&channel->series, time_s, value) : status;
}

static enum mr_status take_frame(struct signals *s, const struct link_frame *frame, double time_s,
                                 size_t *rows)
{
    bool taken = false;
    double value;
    enum mr_status status = MR_OK;
    for (size_t c = 0; c < s->mapping->channels && status == MR_OK; c++) {
        if (signal_value(&s->mapping->channel[c].signal, frame, &value))
            status = take_sample(s, c, time_s, value, &taken);
    }
    *rows += taken;
    return status;
}

static void cut_strays(struct signals *s)
{
    for (size_t c = 0; c < s->mapping->channels; c++) {
        stray_cut(&s->stray[c], &s->mapping->channel[c], 1, &s->log.verdict);
        stray_free(&s->stray[c]);
    }
}

enum mr_status import_read_signals(const struct textfile *file,
                                   const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error)
{
    struct signals s = {.mapping = mapping};
    struct candump_line line;
    uint64_t first_us = 0;
    size_t frames = 0;
    enum mr_status status = MR_OK;
    candump_log_start(&s.log, file->text, file->length, request->interface);
    while (status == MR_OK && candump_log_next(&s.log, &line)) {
        first_us = frames++ ? first_us : line.frame.host_us;
        double time_s = 1e-6 * (double)(int64_t)(line.frame.host_us - first_us) *
                        mapping->time_unit_s;
        if (fabs(time_s) > STRAY_TIME_MOST_S)
            bad(&s, s.log.line, "a time that no clock shows");
        else
            status = take_frame(&s, &line.frame, time_s, &result->rows);
    }
    cut_strays(&s);
    result->verdict = s.log.verdict;
    result->elsewhere = s.log.elsewhere;
    if (status == MR_FULL)
        return error_set(error, status, "no memory: %s line %zu; import it in parts", request->path,
                         s.log.line);
    if (result->rows == 0)
        return error_set(
            error, MR_MALFORMED,
            "none of the mapping's signals in %zu frames: %s; see its ids, and --interface", frames,
            request->path);
    return MR_OK;
}
