#include "host/exchange/import.h"

#include <errno.h>
#include <math.h>
#include <sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"
#include "host/collect/collect.h"

/* ---- files ---- */

enum mr_status textfile_open(const char *path, struct textfile *file, struct error *error)
{
    size_t room = 0, count;
    char *text = NULL;
    *file = (struct textfile){0};
    FILE *stream = fopen(path, "r");
    if (!stream)
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path", strerror(errno),
                         path);
    do {
        room = room ? 2 * room : 65536;
        text = xrealloc(text, room);
        count = fread(text + file->length, 1, room - file->length, stream);
        file->length += count;
    } while (file->length == room);
    file->text = text;
    int failed = ferror(stream) ? errno : 0; /* opening a folder succeeds, but reading it fails */
    fclose(stream);
    if (failed)
        return error_set(error, MR_IO, "cannot read (%s): %s; check the file", strerror(failed),
                         path);
    SHA2_CTX sha;
    SHA256Init(&sha);
    SHA256Update(&sha, (const uint8_t *)file->text, file->length);
    SHA256End(&sha, file->sha256);
    return MR_OK;
}

void textfile_close(struct textfile *file)
{
    free(file->text);
    file->text = NULL;
}

bool candump_log_next(struct candump_log *log, const struct textfile *file, const char **at,
                      struct candump_line *line)
{
    const char *end = file->text + file->length;
    while (*at < end) {
        const char *text = *at, *newline = memchr(text, '\n', (size_t)(end - text));
        *at = newline ? newline + 1 : end;
        if (candump_log_parse_line(log, text, (size_t)((newline ? newline : end) - text),
                                   newline != NULL, line))
            return true;
    }
    return false;
}

/* ---- times ---- */

#define TIME_STEP_MAX_S 60.0
#define TIME_MAX_S      1e12 /* a time after the year 30000 */

/* Returns the reason why a time is not accepted; NULL: it continues after last_s (NaN: no time
 * yet). A pause above TIME_STEP_MAX_S is an error: one wrong digit must not invalidate all later
 * rows. */
static const char *check_time(double time_s, double last_s)
{
    return !(fabs(time_s) <= TIME_MAX_S) ? "impossible time"
         : time_s <= last_s              ? "the time is not later than in the row before"
         : time_s - last_s > TIME_STEP_MAX_S
             ? "the time is more than a minute later than in the row before"
             : NULL;
}

/* ---- a table ---- */

#define FIELDS_MAX       1024u
#define NUMBER_CHARS_MAX 64u

struct csv_field {
    const char *start;
    size_t length;
};

struct csv_table {
    const char *position, *end;
    const char *path;
    struct mapping *mapping;
    struct parse_result *result;
    size_t line_number;
    struct csv_field field[FIELDS_MAX];
    /* number of fields of this line, and of columns of the header (without one, of the first
     * row) */
    size_t field_count, column_count;
    double last_s; /* time of the last accepted row, s; NaN: none */
    size_t row_count;
    struct {
        /* the last consecutive header lines that look like rows: line number of the first, number
         * of lines */
        size_t line, count;
        double time_s; /* time of the last of these lines */
    } number_header;
};

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static struct csv_field trim_field(const char *from, const char *to)
{
    while (from < to && is_blank(*from))
        from++;
    while (to > from && is_blank(to[-1]))
        to--;
    if (to - from >= 2 && *from == '"' && to[-1] == '"') {
        from++;
        to--;
    }
    return (struct csv_field){from, (size_t)(to - from)};
}

/* Splits a line into fields, ignoring separators within quotes. Returns false if there are too many
 * fields. */
static bool split_fields(struct csv_table *t, const char *line, size_t length)
{
    const char *from = line, *end = line + length;
    bool quoted = false;
    t->field_count = 0;
    for (const char *p = line;; p++) {
        if (p < end && *p == '"')
            quoted = !quoted;
        if (p < end && (quoted || *p != t->mapping->separator))
            continue;
        if (t->field_count == FIELDS_MAX)
            return false;
        t->field[t->field_count++] = trim_field(from, p);
        from = p + 1;
        if (p == end)
            return true;
    }
}

/* Reads the next line that is not a comment. Skips blank lines unless `blanks`. Sets `whole` to
 * whether the line ends with a newline. */
static bool read_next_line(struct csv_table *t, bool blanks, const char **line, size_t *length,
                           bool *whole)
{
    while (t->position < t->end) {
        const char *newline = memchr(t->position, '\n', (size_t)(t->end - t->position));
        *line = t->position;
        *length = (size_t)((newline ? newline : t->end) - t->position);
        *whole = newline != NULL;
        t->position = newline ? newline + 1 : t->end;
        t->line_number++;
        size_t text_length = *length;
        while (text_length && is_blank((*line)[text_length - 1]))
            text_length--;
        if (text_length ? !t->mapping->comment_char || **line != t->mapping->comment_char : blanks)
            return true;
    }
    return false;
}

static unsigned find_column_by_name(const struct csv_table *t, const char *name)
{
    for (size_t i = 0; i < t->field_count; i++) {
        if (t->field[i].length == strlen(name) &&
            memcmp(t->field[i].start, name, t->field[i].length) == 0)
            return (unsigned)i + 1;
    }
    return 0;
}

static enum mr_status find_column(const struct csv_table *t, const char *name, unsigned *place,
                                  struct error *error)
{
    if (!*place)
        *place = find_column_by_name(t, name);
    if (*place && *place <= FIELDS_MAX)
        return MR_OK;
    return error_set(error, MR_MALFORMED,
                     "no column '%s': %s line %zu; the mapping must use the name in the header%s",
                     name, t->path, t->line_number,
                     t->mapping->header_lines
                         ? "; header_lines includes blank lines, but not comments"
                         : ", or give the number of the column if header_lines is not given");
}

/* Parses a number. For a missing value returns true and sets NaN. Returns false if the field is not
 * a number. */
static bool parse_number(const struct mapping *m, struct csv_field field, double *value)
{
    char digits[NUMBER_CHARS_MAX];
    *value = (double)NAN;
    if (field.length == 0)
        return true;
    for (size_t i = 0; i < m->missing_word_count; i++) {
        if (strlen(m->missing_words[i]) == field.length &&
            memcmp(m->missing_words[i], field.start, field.length) == 0)
            return true;
    }
    if (field.length >= sizeof digits)
        return false;
    for (size_t i = 0; i < field.length; i++) {
        char c = field.start[i];
        if (c == '\0' || (!strchr("0123456789+-eE", c) && c != m->decimal_mark))
            return false;
        digits[i] = c == m->decimal_mark ? '.' : c;
    }
    digits[field.length] = '\0';
    const char *end;
    *value = mr_decimal_parse(digits, &end);
    return *end == '\0' && isfinite(*value);
}

/* True if all columns that the mapping gives by position are numbers. */
static bool is_data_row(const struct csv_table *t, double *time_s)
{
    const struct mapping *m = t->mapping;
    double value;
    if (!m->time_column_index || m->time_column_index > t->field_count ||
        !parse_number(m, t->field[m->time_column_index - 1], time_s) || isnan(*time_s))
        return false;
    for (size_t c = 0; c < m->channel_count; c++) {
        unsigned place = m->channel[c].column_index;
        if (!place || place > t->field_count || !parse_number(m, t->field[place - 1], &value))
            return false;
    }
    *time_s *= m->time_unit_s;
    return true;
}

static enum mr_status parse_header(struct csv_table *t, struct error *error)
{
    struct mapping *m = t->mapping;
    const char *line;
    size_t length;
    bool whole;
    t->position += utf8_bom_length(t->position, (size_t)(t->end - t->position));
    for (unsigned i = 0; i < m->header_lines; i++) {
        if (!read_next_line(t, true, &line, &length, &whole))
            return error_set(error, MR_MALFORMED,
                             "the file has only %u of %u header lines: %s line %zu; correct "
                             "header_lines in the mapping",
                             i, m->header_lines, t->path, t->line_number);
        if (!split_fields(t, line, length))
            return error_set(error, MR_MALFORMED,
                             "more than %u columns: %s line %zu; check that the separator is '%c'",
                             FIELDS_MAX, t->path, t->line_number, m->separator);
        bool row = is_data_row(t, &t->number_header.time_s);
        t->number_header.line = row && t->number_header.count ? t->number_header.line
                                                              : t->line_number;
        t->number_header.count = row ? t->number_header.count + 1 : 0;
    }
    bool blank_line = t->field_count == 1 && t->field[0].length == 0;
    t->column_count = m->header_lines && !t->number_header.count && !blank_line ? t->field_count
                                                                                : 0;
    enum mr_status status = find_column(t, m->time_column, &m->time_column_index, error);
    for (size_t c = 0; c < m->channel_count && status == MR_OK; c++)
        status = find_column(t, m->channel[c].column_name, &m->channel[c].column_index, error);
    return status;
}

static bool refuse_line(struct csv_table *t, const char *line, const char *at, bool whole,
                        const char *what)
{
    if (whole)
        t->result->bad_lines++;
    parse_result_set(t->result, whole ? MR_MALFORMED : MR_TRUNCATED, t->line_number,
                     (size_t)(at - line) + 1, whole ? what : "the file ends within a line");
    return false;
}

/* Checks all numbers of a line before any is used, so that no value of a bad line is used. */
static bool check_row(struct csv_table *t, const char *line, size_t length, bool whole,
                      double *time_s)
{
    const struct mapping *m = t->mapping;
    double value;
    if (!split_fields(t, line, length))
        return refuse_line(t, line, line, whole, "too many columns");
    if (!t->column_count)
        t->column_count = t->field_count;
    if (t->field_count != t->column_count)
        return refuse_line(
            t, line,
            t->field_count < t->column_count ? line + length : t->field[t->column_count].start,
            whole,
            t->field_count < t->column_count ? "the row has fewer columns than the header"
                                             : "the row has more columns than the header");
    if (!whole && !m->may_lack_newline)
        return refuse_line(t, line, line + length, false, NULL);
    if (m->time_column_index > t->field_count)
        return refuse_line(t, line, line + length, whole, "no time column");
    if (!parse_number(m, t->field[m->time_column_index - 1], &value) || isnan(value))
        return refuse_line(t, line, t->field[m->time_column_index - 1].start, whole, "no time");
    *time_s = value * m->time_unit_s;
    const char *wrong = check_time(*time_s, t->last_s);
    if (wrong)
        return refuse_line(t, line, t->field[m->time_column_index - 1].start, whole, wrong);
    for (size_t c = 0; c < m->channel_count; c++) {
        unsigned place = m->channel[c].column_index;
        if (place > t->field_count || !parse_number(m, t->field[place - 1], &value))
            return refuse_line(t, line,
                               place > t->field_count ? line + length : t->field[place - 1].start,
                               whole, "no number");
        if (fabs(mapping_convert_value(&m->channel[c], value)) > MAPPING_VALUE_MAX)
            return refuse_line(t, line, t->field[place - 1].start, whole, "impossible value");
    }
    return true;
}

/* Warns if the times in header lines continue in the rows: then header_lines is too large and rows
 * are lost. */
static void check_header_times(struct csv_table *t, double first_s, double second_s)
{
    double before_s = first_s - t->number_header.time_s;
    if (!t->number_header.count || !(before_s > 0.0 && before_s <= 1.5 * (second_s - first_s)))
        return;
    t->result->bad_lines += t->number_header.count;
    parse_result_set(t->result, MR_MALFORMED, t->number_header.line, 1,
                     "a data row is within the header lines; correct header_lines");
}

static void add_row(struct csv_table *t, double time_s)
{
    struct mapping *m = t->mapping;
    if (t->row_count == 1)
        check_header_times(t, t->last_s, time_s);
    t->last_s = time_s;
    t->row_count++;
    for (size_t c = 0; c < m->channel_count; c++) {
        struct mapping_channel *channel = &m->channel[c];
        double value;
        parse_number(m, t->field[channel->column_index - 1], &value);
        if (!isnan(value))
            series_add_sample(&channel->series, time_s, mapping_convert_value(channel, value));
    }
}

enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct parse_result *parse_outcome, struct error *error)
{
    struct csv_table t = {.position = text,
                          .end = text + length,
                          .path = path,
                          .mapping = mapping,
                          .result = parse_outcome,
                          .last_s = (double)NAN};
    const char *line;
    double time_s = (double)NAN;
    bool whole;
    enum mr_status status = parse_header(&t, error);
    while (status == MR_OK && read_next_line(&t, false, &line, &length, &whole)) {
        if (check_row(&t, line, length, whole, &time_s))
            add_row(&t, time_s);
    }
    *rows = t.row_count;
    if (status == MR_OK && (t.row_count == 0 || parse_outcome->bad_lines > t.row_count / 9))
        return error_set(error, MR_MALFORMED,
                         "%zu rows are valid and %zu are invalid: %s line %zu, column %zu: %s; "
                         "check that the mapping fits the file",
                         t.row_count, parse_outcome->bad_lines, path, parse_outcome->line,
                         parse_outcome->column,
                         parse_outcome->fault_text ? parse_outcome->fault_text : "no rows");
    return status;
}

/* ---- frames of other instruments ---- */

/* Returns true if a sample was added. Of two samples with the same time the first is used. */
static bool add_sample(struct candump_log *log, struct mapping_channel *channel, double time_s,
                       double read)
{
    struct series *series = &channel->series;
    double value = mapping_convert_value(channel, read);
    const char *wrong = check_time(time_s,
                                   series->count ? series->time_s[series->count - 1] : (double)NAN);
    if (!wrong && !(fabs(value) <= MAPPING_VALUE_MAX))
        wrong = "impossible value";
    if (!wrong) {
        series_add_sample(series, time_s, value);
        return true;
    }
    log->result.bad_lines++;
    parse_result_set(&log->result, MR_MALFORMED, log->line_number, 1, wrong);
    return false;
}

/* True if a channel has a signal in the frame. */
static bool has_signal(const struct mapping *mapping, const struct link_frame *frame)
{
    double value;
    for (size_t c = 0; c < mapping->channel_count; c++) {
        if (signal_extract_value(&mapping->channel[c].signal, frame, &value))
            return true;
    }
    return false;
}

/* Finds the interface that carries signals of the mapping; the request names one if there are
 * several. */
static enum mr_status find_signals(const struct textfile *file,
                                   const struct import_request *request,
                                   const struct mapping *mapping, char name[CANDUMP_INTERFACE_SIZE],
                                   struct error *error)
{
    struct candump_log log = {0};
    struct candump_line line;
    const char *at = file->text;
    snprintf(name, CANDUMP_INTERFACE_SIZE, "%s", request->interface ? request->interface : "");
    while (!request->interface && candump_log_next(&log, file, &at, &line)) {
        if (!has_signal(mapping, &line.frame) || candump_is_from_interface(&line, name))
            continue;
        if (name[0])
            return error_set(error, MR_USAGE,
                             "the signals of the mapping are on both %s and %.*s: %s line %zu; "
                             "select one interface (such as --interface %s)",
                             name, (int)line.interface_length, line.interface, request->path,
                             log.line_number, name);
        snprintf(name, CANDUMP_INTERFACE_SIZE, "%.*s", (int)line.interface_length, line.interface);
    }
    return MR_OK;
}

enum mr_status import_read_signals(const struct textfile *file,
                                   const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error)
{
    struct candump_log log = {0};
    struct candump_line line;
    const char *at = file->text;
    uint64_t first_us = 0;
    size_t frames = 0;
    double value;
    if (find_signals(file, request, mapping, log.interface, error) != MR_OK)
        return error->status;
    memcpy(result->bus, log.interface, sizeof result->bus);
    while (candump_log_next(&log, file, &at, &line)) {
        bool has_sample = false;
        first_us = frames++ ? first_us : line.frame.host_us;
        double time_s = 1e-6 * (double)(int64_t)(line.frame.host_us - first_us) *
                        mapping->time_unit_s;
        for (size_t c = 0; c < mapping->channel_count; c++)
            has_sample |= signal_extract_value(&mapping->channel[c].signal, &line.frame, &value) &&
                          add_sample(&log, &mapping->channel[c], time_s, value);
        result->row_count += has_sample;
    }
    result->parsed = log.result;
    result->other_interface_frames = log.other_interface_frames;
    if (result->row_count == 0)
        return error_set(error, MR_MALFORMED,
                         "none of the signals in the mapping is in the %zu frames: %s; check the "
                         "ids in the mapping",
                         frames, request->path);
    return MR_OK;
}

/* ---- logs of matrig boards, imported through the collector like matrig log ---- */

/* Time between commits. It is short, because another process that writes waits at most 5 s. */
#define COMMIT_PERIOD_US        200000u
#define FRAMES_PER_COMMIT_CHECK 4096u

/* Opens a log with at least one frame. The caller closes the link. */
static enum mr_status open_log(const struct textfile *file, const struct import_request *request,
                               struct link **link, struct error *error)
{
    enum mr_status status = link_open_text(file->text, file->length, request->path,
                                           request->can_base, request->interface, link, error);
    if (status == MR_OK && !link_candump(*link)->interface[0])
        status = error_set(error, MR_MALFORMED,
                           "no frames: %s is empty; give a log that `candump -L` wrote",
                           request->path);
    return status;
}

enum mr_status import_candump_check(const struct textfile *file,
                                    const struct import_request *request,
                                    struct import_result *result, struct error *error)
{
    struct link *link = NULL;
    enum mr_status status = open_log(file, request, &link, error);
    if (status == MR_OK)
        memcpy(result->bus, link_candump(link)->interface, sizeof result->bus);
    link_close(link);
    return status;
}

static enum mr_status add_finished_landings(struct collector *collector,
                                            struct import_result *result)
{
    int64_t run;
    while ((run = collector_pop_finished_run(collector)) != 0) {
        if (result->run_count < IMPORT_RUNS_MAX)
            result->runs[result->run_count++] = run;
    }
    return MR_OK;
}

static enum mr_status commit_and_begin(struct store *store, struct collector *collector,
                                       uint64_t *begun_us, struct error *error)
{
    enum mr_status status = collector_store_counts(collector, error);
    status = status ?: store_commit(store, error) ?: store_begin(store, error);
    *begun_us = link_now_us();
    return status;
}

static enum mr_status import_frames(struct store *store, struct collector *collector,
                                    struct link *link, struct import_result *result,
                                    struct error *error)
{
    struct link_frame frame;
    struct error ended = {0};
    uint64_t begun_us = link_now_us(), reported_troubles = 0;
    enum mr_status status = MR_OK;
    for (;;) {
        bool more = link_receive_frame(link, &frame, &ended) == MR_OK;
        const struct link_counters *counters = link_counters(link);
        if (reported_troubles != counters->fault_total + counters->bad_lines)
            status = collector_count_link_faults(collector, LINK_CAN, counters, error);
        reported_troubles = counters->fault_total + counters->bad_lines;
        if (status == MR_OK && more)
            status = collector_receive_frame(collector, &frame, error);
        if (status != MR_OK || !more)
            return status; /* the caller stores the error as result of the log */
        if (++result->row_count % FRAMES_PER_COMMIT_CHECK != 0)
            continue;
        add_finished_landings(collector, result);
        if (link_now_us() - begun_us >= COMMIT_PERIOD_US)
            status = commit_and_begin(store, collector, &begun_us, error);
    }
}

static enum mr_status end_session(struct store *store, struct collector *collector,
                                  struct import_result *result, enum mr_status status,
                                  struct error *error)
{
    struct error late = {0};
    struct collector_progress progress;
    enum mr_status ended = collector_end(collector, status == MR_OK ? "end" : "error", &late);
    add_finished_landings(collector, result);
    collector_get_progress(collector, &progress);
    result->counts = progress.counts[LINK_CAN];
    if (ended == MR_OK)
        ended = store_link_put(store, result->session, LINK_CAN, &result->counts, &late);
    return ended == MR_OK || status != MR_OK ? status : error_set(error, ended, "%s", late.text);
}

enum mr_status import_candump(struct store *store, const struct textfile *file,
                              const struct import_request *request, struct import_result *result,
                              struct error *error)
{
    char spec[500];
    struct link *link = NULL;
    struct collector *collector = NULL;
    snprintf(spec, sizeof spec, "import:%s", request->path);
    enum mr_status status = open_log(file, request, &link, error)
                              ?: collector_open(store, spec, request->can_base, NULL, &collector,
                                                error);
    if (status == MR_OK) {
        result->session = collector_get_session(collector);
        status = import_frames(store, collector, link, result, error);
        status = end_session(store, collector, result, status, error);
        result->parsed = link_candump(link)->result;
        result->other_interface_frames = link_candump(link)->other_interface_frames;
        for (unsigned i = 0; i < LINK_FAULT_COUNT; i++)
            result->link_fault_count[i] = (int64_t)link_counters(link)->fault_count[i];
    }
    collector_close(collector);
    link_close(link);
    return status; /* the caller adds the file name and commits */
}
