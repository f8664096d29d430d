#include "host/exchange/readings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "host/base/xmalloc.h"
#include "host/exchange/import.h"
#include "host/exchange/mapping.h"

/* ---- a candump log ---- */

void candump_log_start(struct candump_log *log, const char *text, size_t length,
                       const char *interface)
{
    *log = (struct candump_log){.text = text,
                                .end = text + length,
                                .at = text,
                                .interface = interface,
                                .interface_length = interface ? strlen(interface) : 0};
}

/* What to call it: CAN FD has its own mark. */
static const char *reason(const char *text, size_t length)
{
    return memmem(text, length, "##", 2) ? "a CAN FD frame; matrig's bus has none"
                                         : "no line of `candump -L`";
}

static bool here(const struct candump_log *log, const struct candump_line *line)
{
    return !log->interface || (line->interface_length == log->interface_length &&
                               memcmp(line->interface, log->interface, log->interface_length) == 0);
}

bool candump_log_next(struct candump_log *log, struct candump_line *line)
{
    while (log->at < log->end) {
        const char *text = log->at;
        const char *newline = memchr(text, '\n', (size_t)(log->end - text));
        size_t length = (size_t)((newline ? newline : log->end) - text);
        log->at = newline ? newline + 1 : log->end;
        log->line++;
        if (length == 0)
            continue;
        enum mr_status status = candump_parse_line(text, length, line);
        if (!newline) { /* a whole frame may be the beginning of a longer one */
            verdict_set(&log->verdict, MR_TRUNCATED, log->line, length + 1,
                        "the log ends inside a line");
            return false;
        }
        if (status != MR_OK) {
            log->verdict.bad_lines++;
            verdict_set(&log->verdict, MR_MALFORMED, log->line, line->column, reason(text, length));
            continue;
        }
        if (here(log, line))
            return true;
        log->elsewhere++;
    }
    return false;
}

/* ---- strays ---- */

/* Rows of a table, or frames of a log, whose time lies far from that of the others: one wrong digit
 * of a time makes a record that is hours long. Rows without a pause of STRAY_PAUSE_S are a group; a
 * group is stray when it is small beside the largest. */
#define STRAY_PAUSE_S     60.0
#define STRAY_TIME_MOST_S 1e12 /* beyond the year 30000: no clock shows it */

struct stray {
    struct stray_group {
        double first_s, last_s;
        double before_s;   /* the last but one; first_s when there is one row alone */
        size_t line, rows; /* line: of the first row */
    } * group;
    size_t groups;
};
#define FEW_ROWS 2u
#define SHARE    100u /* more than a hundredth of the largest group is a part of the record */

static void stray_add(struct stray *stray, double time_s, size_t line)
{
    struct stray_group *last = stray->groups ? &stray->group[stray->groups - 1] : NULL;
    if (last && time_s - last->last_s <= STRAY_PAUSE_S) {
        last->before_s = last->last_s;
        last->last_s = time_s;
        last->rows++;
        return;
    }
    xlist_grow(&stray->group, stray->groups, sizeof *stray->group);
    stray->group[stray->groups++] = (struct stray_group){time_s, time_s, time_s, line, 1};
}

static void stray_take_back(struct stray *stray)
{
    struct stray_group *last = stray->groups ? &stray->group[stray->groups - 1] : NULL;
    if (!last)
        return;
    last->last_s = last->before_s;
    if (--last->rows == 0)
        stray->groups--;
}

static void cut_group(struct series *series, const struct stray_group *group)
{
    size_t from = 0, to;
    while (from < series->count && series->time_s[from] < group->first_s)
        from++;
    for (to = from; to < series->count && series->time_s[to] <= group->last_s; to++)
        continue;
    size_t rest = series->count - to;
    if (to == from)
        return;
    memmove(series->time_s + from, series->time_s + to, rest * sizeof *series->time_s);
    memmove(series->value + from, series->value + to, rest * sizeof *series->value);
    series->count = from + rest;
}

static size_t stray_cut(const struct stray *stray, struct mapping_channel *channel, size_t channels,
                        struct verdict *verdict)
{
    size_t most = 0, rows = 0;
    for (size_t g = 0; g < stray->groups; g++)
        most = stray->group[g].rows > most ? stray->group[g].rows : most;
    for (size_t g = 0; g < stray->groups; g++) {
        const struct stray_group *group = &stray->group[g];
        if (group->rows == most || (group->rows > FEW_ROWS && group->rows > most / SHARE))
            continue;
        for (size_t c = 0; c < channels; c++)
            cut_group(&channel[c].series, group);
        rows += group->rows;
        verdict_set(verdict, MR_MALFORMED, group->line, 1,
                    "the time is more than a minute from the others");
    }
    verdict->bad_lines += rows;
    return rows;
}

static void stray_free(struct stray *stray)
{
    free(stray->group);
    *stray = (struct stray){0};
}

/* ---- a table ---- */

#define FIELDS_MAX 1024u
#define NUMBER_MAX 64u

struct field {
    const char *at;
    size_t length;
};

struct table {
    const char *at, *end;
    const char *path;
    struct mapping *mapping;
    struct verdict *verdict;
    size_t line;
    struct field field[FIELDS_MAX];
    size_t fields, columns;  /* of this line; of the header, else of the first row */
    double last_s, before_s; /* of the last row taken, and of the one before it */
    size_t last_line;
    size_t rows;
    struct stray stray;
    struct {
        /* the last header lines that read as rows: the first of them, and how many */
        size_t line, count;
        double time_s; /* of the last of them */
    } eaten;
};

static bool blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static struct field trimmed(const char *from, const char *to)
{
    while (from < to && blank(*from))
        from++;
    while (to > from && blank(to[-1]))
        to--;
    if (to - from >= 2 && *from == '"' && to[-1] == '"') {
        from++;
        to--;
    }
    return (struct field){from, (size_t)(to - from)};
}

/* Into fields; a separator within quotes is none. False: too many. */
static bool split(struct table *t, const char *line, size_t length)
{
    const char *from = line, *end = line + length;
    bool quoted = false;
    t->fields = 0;
    for (const char *p = line;; p++) {
        if (p < end && *p == '"')
            quoted = !quoted;
        if (p < end && (quoted || *p != t->mapping->separator))
            continue;
        if (t->fields == FIELDS_MAX)
            return false;
        t->field[t->fields++] = trimmed(from, p);
        from = p + 1;
        if (p == end)
            return true;
    }
}

/* The next line that is no comment and, unless `blanks`, says something. `whole`: it ends with a
 * newline. */
static bool next_line(struct table *t, bool blanks, const char **line, size_t *length, bool *whole)
{
    while (t->at < t->end) {
        const char *newline = memchr(t->at, '\n', (size_t)(t->end - t->at));
        *line = t->at;
        *length = (size_t)((newline ? newline : t->end) - t->at);
        *whole = newline != NULL;
        t->at = newline ? newline + 1 : t->end;
        t->line++;
        size_t said = *length;
        while (said && blank((*line)[said - 1]))
            said--;
        if (said ? !t->mapping->comment || **line != t->mapping->comment : blanks)
            return true;
    }
    return false;
}

static unsigned find_name(const struct table *t, const char *name)
{
    for (size_t i = 0; i < t->fields; i++) {
        if (t->field[i].length == strlen(name) &&
            memcmp(t->field[i].at, name, t->field[i].length) == 0)
            return (unsigned)i + 1;
    }
    return 0;
}

static enum mr_status find_column(const struct table *t, const char *name, unsigned *place,
                                  struct error *error)
{
    if (!*place)
        *place = find_name(t, name);
    if (*place && *place <= FIELDS_MAX)
        return MR_OK;
    return error_set(error, MR_MALFORMED,
                     "no column '%s': %s line %zu; the mapping must name it as the header does%s",
                     name, t->path, t->line,
                     t->mapping->header_lines ? "; header_lines counts blank lines, and no comments"
                                              : ", or number it, without header_lines");
}

/* NaN and true: missing. False: no number. */
static bool take_number(const struct mapping *m, struct field field, double *value)
{
    char digits[NUMBER_MAX];
    *value = (double)NAN;
    if (field.length == 0)
        return true;
    for (size_t i = 0; i < m->missing_count; i++) {
        if (strlen(m->missing[i]) == field.length &&
            memcmp(m->missing[i], field.at, field.length) == 0)
            return true;
    }
    if (field.length >= sizeof digits)
        return false;
    for (size_t i = 0; i < field.length; i++) {
        char c = field.at[i];
        if (c == '\0' || (!strchr("0123456789+-eE", c) && c != m->decimal))
            return false;
        digits[i] = c == m->decimal ? '.' : c;
    }
    digits[field.length] = '\0';
    const char *end;
    *value = mr_decimal_read(digits, &end);
    return *end == '\0' && isfinite(*value);
}

/* All of the mapping's columns that are counted are numbers. */
static bool reads_as_row(const struct table *t, double *time_s)
{
    const struct mapping *m = t->mapping;
    double value;
    if (!m->time_place || m->time_place > t->fields ||
        !take_number(m, t->field[m->time_place - 1], time_s) || isnan(*time_s))
        return false;
    for (size_t c = 0; c < m->channels; c++) {
        unsigned place = m->channel[c].place;
        if (!place || place > t->fields || !take_number(m, t->field[place - 1], &value))
            return false;
    }
    *time_s *= m->time_unit_s;
    return true;
}

static enum mr_status take_header(struct table *t, struct error *error)
{
    struct mapping *m = t->mapping;
    const char *line;
    size_t length;
    bool whole;
    if (t->end - t->at >= 3 && memcmp(t->at, "\xef\xbb\xbf", 3) == 0) /* a mark of UTF-8 */
        t->at += 3;
    for (unsigned i = 0; i < m->header_lines; i++) {
        if (!next_line(t, true, &line, &length, &whole))
            return error_set(
                error, MR_MALFORMED,
                "only %u of %u header lines: %s line %zu; see the mapping's header_lines", i,
                m->header_lines, t->path, t->line);
        if (!split(t, line, length))
            return error_set(error, MR_MALFORMED,
                             "more than %u columns: %s line %zu; is the separator '%c'?",
                             FIELDS_MAX, t->path, t->line, m->separator);
        bool row = reads_as_row(t, &t->eaten.time_s);
        t->eaten.line = row && t->eaten.count ? t->eaten.line : t->line;
        t->eaten.count = row ? t->eaten.count + 1 : 0;
    }
    bool blank_line = t->fields == 1 && t->field[0].length == 0;
    t->columns = m->header_lines && !t->eaten.count && !blank_line ? t->fields : 0;
    enum mr_status status = find_column(t, m->time_column, &m->time_place, error);
    for (size_t c = 0; c < m->channels && status == MR_OK; c++)
        status = find_column(t, m->channel[c].column, &m->channel[c].place, error);
    return status;
}

static bool bad(struct table *t, const char *line, const char *at, bool whole, const char *what)
{
    if (whole)
        t->verdict->bad_lines++;
    verdict_set(t->verdict, whole ? MR_MALFORMED : MR_TRUNCATED, t->line, (size_t)(at - line) + 1,
                whole ? what : "the file ends inside a line");
    return false;
}

/* The row before was wrong if this one goes on from the one before that: one bad time must not cost
 * all that follow. */
static bool take_back(struct table *t, double time_s)
{
    if (!(time_s > t->before_s) || t->rows == 0)
        return false;
    for (size_t c = 0; c < t->mapping->channels; c++) {
        struct series *series = &t->mapping->channel[c].series;
        series->count -= series->count && series->time_s[series->count - 1] == t->last_s;
    }
    stray_take_back(&t->stray);
    t->verdict->bad_lines++;
    t->rows--;
    verdict_set(t->verdict, MR_MALFORMED, t->last_line, 1, "the time jumps");
    t->last_s = t->before_s;
    return true;
}

/* All numbers of the line before any is taken: a bad line gives none. */
static bool check_row(struct table *t, const char *line, size_t length, bool whole, double *time_s)
{
    const struct mapping *m = t->mapping;
    double value;
    if (!split(t, line, length))
        return bad(t, line, line, whole, "too many columns");
    if (!t->columns)
        t->columns = t->fields;
    if (t->fields != t->columns)
        return bad(t, line, t->fields < t->columns ? line + length : t->field[t->columns].at, whole,
                   t->fields < t->columns ? "fewer columns than the header has"
                                          : "more columns than the header has");
    if (!whole && !m->last_line_open)
        return bad(t, line, line + length, false, NULL);
    if (m->time_place > t->fields)
        return bad(t, line, line + length, whole, "no column of time");
    if (!take_number(m, t->field[m->time_place - 1], &value) || isnan(value))
        return bad(t, line, t->field[m->time_place - 1].at, whole, "no time");
    *time_s = value * m->time_unit_s;
    if (fabs(*time_s) > STRAY_TIME_MOST_S)
        return bad(t, line, t->field[m->time_place - 1].at, whole, "a time that no clock shows");
    if (!(*time_s > t->last_s) && !take_back(t, *time_s))
        return bad(t, line, t->field[m->time_place - 1].at, whole, "the time does not go on");
    for (size_t c = 0; c < m->channels; c++) {
        unsigned place = m->channel[c].place;
        if (place > t->fields || !take_number(m, t->field[place - 1], &value))
            return bad(t, line, place > t->fields ? line + length : t->field[place - 1].at, whole,
                       "no number");
        if (fabs(mapping_value(&m->channel[c], value)) > MAPPING_VALUE_MOST)
            return bad(t, line, t->field[place - 1].at, whole, "a value that no instrument reads");
    }
    return true;
}

/* Header lines that go on into the rows are rows: header_lines is too large, and they are lost. */
static void judge_header(struct table *t, double first_s, double second_s)
{
    double before_s = first_s - t->eaten.time_s;
    if (!t->eaten.count || !(before_s > 0.0 && before_s <= 1.5 * (second_s - first_s)))
        return;
    t->verdict->bad_lines += t->eaten.count;
    verdict_set(t->verdict, MR_MALFORMED, t->eaten.line, 1,
                "a row among the header lines; see header_lines");
}

static void take_row(struct table *t, double time_s)
{
    struct mapping *m = t->mapping;
    stray_add(&t->stray, time_s, t->line);
    if (t->rows == 1)
        judge_header(t, t->last_s, time_s);
    t->before_s = t->last_s;
    t->last_s = time_s;
    t->last_line = t->line;
    t->rows++;
    for (size_t c = 0; c < m->channels; c++) {
        struct mapping_channel *channel = &m->channel[c];
        double value;
        take_number(m, t->field[channel->place - 1], &value);
        if (!isnan(value))
            series_add(&channel->series, time_s, mapping_value(channel, value));
    }
}

enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct verdict *verdict, struct error *error)
{
    struct table t = {.at = text,
                      .end = text + length,
                      .path = path,
                      .mapping = mapping,
                      .verdict = verdict,
                      .last_s = -(double)INFINITY,
                      .before_s = -(double)INFINITY};
    const char *line;
    double time_s = (double)NAN;
    bool whole;
    enum mr_status status = take_header(&t, error);
    while (status == MR_OK && next_line(&t, false, &line, &length, &whole)) {
        if (check_row(&t, line, length, whole, &time_s))
            take_row(&t, time_s);
    }
    if (status == MR_OK)
        t.rows -= stray_cut(&t.stray, mapping->channel, mapping->channels, verdict);
    stray_free(&t.stray);
    *rows = t.rows;
    if (status == MR_OK && (t.rows == 0 || verdict->bad_lines > t.rows / 9))
        return error_set(error, MR_MALFORMED,
                         "%zu rows are good, %zu are not: %s line %zu, column %zu: %s; does the "
                         "mapping fit the file?",
                         t.rows, verdict->bad_lines, path, verdict->line, verdict->column,
                         verdict->what ? verdict->what : "no row at all");
    return status;
}

/* ---- frames of other instruments ---- */

struct signals {
    struct candump_log log;
    struct mapping *mapping;
    struct stray stray[MAPPING_CHANNELS];
    size_t last_line[MAPPING_CHANNELS]; /* of the last sample of each */
};

static void bad_line(struct signals *s, size_t line, const char *what)
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
        bad_line(s, s->log.line, "the time does not go on");
        return false;
    }
    bad_line(s, s->last_line[c], "the time jumps");
    stray_take_back(&s->stray[c]);
    series->count--;
    return true;
}

/* True: a sample more. */
static bool take_sample(struct signals *s, size_t c, double time_s, double read)
{
    struct mapping_channel *channel = &s->mapping->channel[c];
    double value = mapping_value(channel, read);
    if (!(fabs(value) <= MAPPING_VALUE_MOST)) {
        bad_line(s, s->log.line, "a value that no instrument reads");
        return false;
    }
    if (!goes_on(s, c, time_s))
        return false;
    s->last_line[c] = s->log.line;
    stray_add(&s->stray[c], time_s, s->log.line);
    series_add(&channel->series, time_s, value);
    return true;
}

static bool take_signals(struct signals *s, const struct link_frame *frame, double time_s)
{
    bool taken = false;
    double value;
    for (size_t c = 0; c < s->mapping->channels; c++)
        taken |= signal_value(&s->mapping->channel[c].signal, frame, &value) &&
                 take_sample(s, c, time_s, value);
    return taken;
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
    candump_log_start(&s.log, file->text, file->length, request->interface);
    while (candump_log_next(&s.log, &line)) {
        first_us = frames++ ? first_us : line.frame.host_us;
        double time_s = 1e-6 * (double)(int64_t)(line.frame.host_us - first_us) *
                        mapping->time_unit_s;
        if (fabs(time_s) > STRAY_TIME_MOST_S)
            bad_line(&s, s.log.line, "a time that no clock shows");
        else
            result->rows += take_signals(&s, &line.frame, time_s);
    }
    cut_strays(&s);
    result->verdict = s.log.verdict;
    result->elsewhere = s.log.elsewhere;
    if (result->rows == 0)
        return error_set(
            error, MR_MALFORMED,
            "none of the mapping's signals in %zu frames: %s; see its ids, and --interface", frames,
            request->path);
    return MR_OK;
}
