#include "hil/rig/runfile.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "common/crc32.h"
#include "common/decimal.h"
#include "hil/core/file_place.h"

#define FILE_MAX     (256u * 1024u * 1024u)
#define SAMPLES_MAX  4000000u
#define COMMANDS_MAX 10000u

#define refuse(r, ...) hil_file_refuse(&(r)->at, __VA_ARGS__)

struct reader {
    struct hil_file_place at; /* line: the present one */
    char *bytes;              /* the whole file, 0 after it */
    size_t size;
    char *next; /* line to come */
    char *line; /* present line, its end replaced by 0 */
    struct hil_run *run;
    unsigned switches, transducers, gages, gaps, gaps_end;
    bool has_duration, has_samples, ended;
};

static bool next_line(struct reader *r)
{
    if (r->next >= r->bytes + r->size)
        return false;
    r->line = r->next;
    r->at.line++;
    char *end = memchr(r->line, '\n', (size_t)(r->bytes + r->size - r->line));
    if (end) {
        *end = '\0';
        r->next = end + 1;
    } else {
        r->next = r->bytes + r->size;
    }
    return true;
}

/* Next word of the line, ended by 0; NULL at its end. */
static char *word(char **p)
{
    while (**p == ' ' || **p == '\t' || **p == '\r')
        (*p)++;
    if (!**p)
        return NULL;
    char *start = *p;
    while (**p && **p != ' ' && **p != '\t' && **p != '\r')
        (*p)++;
    if (**p)
        *(*p)++ = '\0';
    return start;
}

static bool number(char **p, double *value)
{
    char *text = word(p);
    const char *end;
    if (!text)
        return false;
    *value = mr_decimal_read(text, &end);
    return *end == '\0' && isfinite(*value);
}

static bool whole(char **p, long low, long high, long *value)
{
    char *text = word(p);
    char *end;
    if (!text)
        return false;
    errno = 0;
    *value = strtol(text, &end, 10);
    return *end == '\0' && end != text && !errno && *value >= low && *value <= high;
}

/* Seconds with up to 12 decimals, exactly, as picoseconds; up to 10^6 s. */
static bool time_ps(char **p, uint64_t *t_ps)
{
    char *text = word(p);
    uint64_t value = 0;
    unsigned digits = 0;
    if (!text || *text < '0' || *text > '9')
        return false;
    for (; *text >= '0' && *text <= '9'; text++) {
        value = value * 10u + (uint64_t)(*text - '0');
        if (value > 1000000u)
            return false;
    }
    if (*text == '.')
        text++;
    for (; *text >= '0' && *text <= '9' && digits < 12; text++, digits++)
        value = value * 10u + (uint64_t)(*text - '0');
    for (; digits < 12; digits++)
        value *= 10u;
    *t_ps = value;
    return *text == '\0';
}

static enum mr_status at_end(const struct reader *r, char *p, const char *what)
{
    return word(&p) ? refuse(r, MR_MALFORMED, "words left over after %s", what) : MR_OK;
}

static enum mr_status read_switch(struct reader *r, char *p)
{
    long position;
    double nominal_ft;
    uint64_t *open_ps;
    if (!whole(&p, 1, HIL_RUN_SWITCHES, &position) || (unsigned)position != r->switches + 1u)
        return refuse(r, MR_MALFORMED, "switch %u of %u expected here", r->switches + 1u,
                      HIL_RUN_SWITCHES);
    open_ps = &r->run->switch_open_ps[position - 1];
    if (!number(&p, &nominal_ft) || !number(&p, &r->run->switch_ft[position - 1]))
        return refuse(r, MR_MALFORMED,
                      "`switch <position> <nominal_ft> <true_ft> <t_open_s or ->` expected");
    while (*p == ' ')
        p++;
    if (*p == '-') {
        *open_ps = HIL_RUN_NEVER;
        p++;
    } else if (!time_ps(&p, open_ps)) {
        return refuse(r, MR_MALFORMED, "time at which switch %ld opens expected: seconds, or -",
                      position);
    }
    r->switches++;
    return at_end(r, p, "switch");
}

static enum mr_status read_transducer(struct reader *r, char *p)
{
    long channel;
    if (!whole(&p, 1, HIL_RUN_TRANSDUCERS, &channel) || (unsigned)channel != r->transducers + 1u ||
        !number(&p, &r->run->transducer_ft[channel - 1]))
        return refuse(r, MR_MALFORMED, "`transducer %u <station_ft>` expected",
                      r->transducers + 1u);
    r->transducers++;
    return at_end(r, p, "transducer");
}

static enum mr_status read_gage(struct reader *r, char *p)
{
    long channel, band;
    if (!whole(&p, 1, HIL_RUN_GAGES, &channel) || (unsigned)channel != r->gages + 1u ||
        !number(&p, &r->run->gage_ft[channel - 1]) || !whole(&p, 0, 255, &band))
        return refuse(r, MR_MALFORMED, "`gage %u <station_ft> <band>` expected", r->gages + 1u);
    r->run->gage_band[channel - 1] = (unsigned)band;
    r->gages++;
    return at_end(r, p, "gage");
}

static enum mr_status read_gaps(struct reader *r, char *p, double *gap_in, unsigned *count)
{
    char *text;
    while ((text = word(&p)) != NULL) {
        const char *end;
        double value = mr_decimal_read(text, &end);
        if (*end || !isfinite(value))
            return refuse(r, MR_MALFORMED, "`%s` is no joint gap in inches", text);
        if (*count == HIL_RUN_JOINTS)
            return refuse(r, MR_MALFORMED, "more than %u joint gaps", HIL_RUN_JOINTS);
        gap_in[(*count)++] = value;
    }
    return MR_OK;
}

static enum mr_status read_command(struct reader *r, char *p)
{
    struct hil_run *run = r->run;
    struct hil_run_command command = {0};
    if (!time_ps(&p, &command.t_ps))
        return refuse(r, MR_MALFORMED, "`command <t_s> <can or serial> <name> ...` expected");
    if (run->command_count && command.t_ps < run->commands[run->command_count - 1].t_ps)
        return refuse(r, MR_MALFORMED, "commands must be in order of time");
    const char *link = word(&p);
    if (!link || (strcmp(link, "can") != 0 && strcmp(link, "serial") != 0))
        return refuse(r, MR_MALFORMED, "a command comes by `can` or `serial`, not `%s`",
                      link ? link : "");
    command.serial = link[0] == 's';
    if (run->command_count == COMMANDS_MAX)
        return refuse(r, MR_TOO_LONG, "more than %u commands", COMMANDS_MAX);
    if (mr_command_parse(p, (uint16_t)(run->command_count + 1u), &command.message) != MR_OK)
        return refuse(r, MR_MALFORMED, "`%s` is no command", p);
    struct hil_run_command *grown = realloc(run->commands,
                                            (run->command_count + 1u) * sizeof *grown);
    if (!grown)
        return refuse(r, MR_IO, "no memory for its commands");
    run->commands = grown;
    run->commands[run->command_count++] = command;
    return MR_OK;
}

/* One row of samples: 22 integers. */
static enum mr_status read_row(struct reader *r, int32_t row[HIL_RUN_COLUMNS])
{
    const char *p = r->line;
    for (unsigned i = 0; i < HIL_RUN_COLUMNS; i++) {
        char *end;
        errno = 0;
        long value = strtol(p, &end, 10);
        if (end == p || errno || value > INT32_MAX || value < INT32_MIN)
            return refuse(r, MR_MALFORMED, "a row of %u integers, or xN, expected",
                          HIL_RUN_COLUMNS);
        row[i] = (int32_t)value;
        p = end;
    }
    while (*p == ' ' || *p == '\r')
        p++;
    return *p ? refuse(r, MR_MALFORMED, "more than %u numbers in a row", HIL_RUN_COLUMNS) : MR_OK;
}

static enum mr_status read_samples(struct reader *r, char *p)
{
    struct hil_run *run = r->run;
    long count;
    if (r->has_samples)
        return refuse(r, MR_MALFORMED, "a second table of samples");
    if (!whole(&p, 1, SAMPLES_MAX, &count) || !number(&p, &run->rate_hz) || run->rate_hz <= 0.0)
        return refuse(r, MR_MALFORMED, "`samples <count 1..%u> <rate_hz>` expected", SAMPLES_MAX);
    run->samples = calloc((size_t)count, sizeof *run->samples);
    if (!run->samples)
        return refuse(r, MR_IO, "no memory for %ld samples", count);
    while (run->sample_count < (size_t)count) {
        if (!next_line(r))
            return refuse(r, MR_TRUNCATED, "the file ends after %zu of %ld samples",
                          run->sample_count, count);
        if (r->line[0] == '#')
            continue;
        if (r->line[0] == 'x') {
            char *q = r->line + 1;
            long repeat;
            if (!run->sample_count || !whole(&q, 1, count, &repeat) || word(&q) ||
                (size_t)repeat > (size_t)count - run->sample_count)
                return refuse(r, MR_MALFORMED,
                              "`%s` does not repeat a row that is there, within the %ld samples",
                              r->line, count);
            for (; repeat; repeat--, run->sample_count++)
                memcpy(run->samples[run->sample_count], run->samples[run->sample_count - 1],
                       sizeof *run->samples);
            continue;
        }
        enum mr_status status = read_row(r, run->samples[run->sample_count]);
        if (status != MR_OK)
            return status;
        run->sample_count++;
    }
    r->has_samples = true;
    return MR_OK;
}

static enum mr_status read_end(struct reader *r, char *p, uint32_t crc)
{
    const char *text = word(&p);
    char *end;
    unsigned long stated = text ? strtoul(text, &end, 16) : 0;
    if (!text || *end || strlen(text) != 8)
        return refuse(r, MR_MALFORMED, "`end <crc32, 8 hex digits>` expected");
    if (stated != crc)
        return refuse(r, MR_CRC, "checksum is %08x but the file says %s: it was changed or damaged",
                      (unsigned)crc, text);
    if (r->next < r->bytes + r->size)
        return refuse(r, MR_MALFORMED, "text after `end`");
    r->ended = true;
    return MR_OK;
}

static enum mr_status read_line(struct reader *r, uint32_t crc)
{
    struct hil_run *run = r->run;
    char *p = r->line;
    long landing;
    double value;
    const char *keyword = word(&p);
    if (!keyword || keyword[0] == '#' || strcmp(keyword, "provenance") == 0)
        return MR_OK;
    if (strcmp(keyword, "landing") == 0) {
        if (!whole(&p, 0, 65535, &landing))
            return refuse(r, MR_MALFORMED, "`landing <n>` expected");
        run->landing = (unsigned)landing;
        return at_end(r, p, keyword);
    }
    if (strcmp(keyword, "duration_s") == 0) {
        if (!number(&p, &run->duration_s) || run->duration_s <= 0.0 || run->duration_s > 1e6)
            return refuse(r, MR_MALFORMED, "`duration_s <seconds>` expected");
        r->has_duration = true;
        return at_end(r, p, keyword);
    }
    if (strcmp(keyword, "touchdown") == 0) {
        if (!number(&p, &run->touchdown_ft) || !number(&p, &run->touchdown_s))
            return refuse(r, MR_MALFORMED, "`touchdown <station_ft> <t_s>` expected");
        return at_end(r, p, keyword);
    }
    if (strcmp(keyword, "truth") == 0) /* for those who compare; the board must not know it */
        return word(&p) && number(&p, &value)
                 ? at_end(r, p, keyword)
                 : refuse(r, MR_MALFORMED, "`truth <name> <value>` expected");
    if (strcmp(keyword, "switch") == 0)
        return read_switch(r, p);
    if (strcmp(keyword, "transducer") == 0)
        return read_transducer(r, p);
    if (strcmp(keyword, "gage") == 0)
        return read_gage(r, p);
    if (strcmp(keyword, "gap_in") == 0)
        return read_gaps(r, p, run->gap_in, &r->gaps);
    if (strcmp(keyword, "gap_end_in") == 0)
        return read_gaps(r, p, run->gap_end_in, &r->gaps_end);
    if (strcmp(keyword, "command") == 0)
        return read_command(r, p);
    if (strcmp(keyword, "samples") == 0)
        return read_samples(r, p);
    if (strcmp(keyword, "end") == 0)
        return read_end(r, p, crc);
    return refuse(r, MR_MALFORMED, "unknown keyword `%s`", keyword);
}

static enum mr_status check_complete(const struct reader *r)
{
    if (!r->ended)
        return refuse(r, MR_TRUNCATED, "the file ends without its `end` line");
    if (!r->has_duration || !r->has_samples)
        return refuse(r, MR_MALFORMED, "no %s", r->has_duration ? "samples" : "duration_s");
    if (r->switches != HIL_RUN_SWITCHES || r->transducers != HIL_RUN_TRANSDUCERS ||
        r->gages != HIL_RUN_GAGES)
        return refuse(r, MR_MALFORMED,
                      "has %u switches, %u transducers, %u gages; needs %u, %u, %u", r->switches,
                      r->transducers, r->gages, HIL_RUN_SWITCHES, HIL_RUN_TRANSDUCERS,
                      HIL_RUN_GAGES);
    if (r->gaps != HIL_RUN_JOINTS || r->gaps_end != HIL_RUN_JOINTS)
        return refuse(r, MR_MALFORMED, "has %u and %u joint gaps; needs %u of each", r->gaps,
                      r->gaps_end, HIL_RUN_JOINTS);
    return MR_OK;
}

/* CRC-32 of everything before the last line that begins with `end `; 0 without one. */
static uint32_t checksum(const struct reader *r)
{
    for (size_t i = r->size; i >= 5; i--) {
        if (memcmp(r->bytes + i - 5, "\nend ", 5) == 0)
            return mr_crc32(0, (const uint8_t *)r->bytes, i - 4);
    }
    return 0;
}

static enum mr_status parse(struct reader *r)
{
    enum mr_status status = hil_file_read(&r->at, FILE_MAX, "give a matrig-run file", &r->bytes,
                                          &r->size);
    long version;
    if (status != MR_OK)
        return status;
    r->next = r->bytes;
    uint32_t crc = checksum(r); /* before lines and words are cut in place */
    char *p = NULL;
    if (!next_line(r) || strncmp(p = r->line, "matrig-run ", 11) != 0)
        return refuse(r, MR_MALFORMED, "not a run file: it does not begin with `matrig-run 1`");
    p += 11;
    if (!whole(&p, 0, 1000000, &version) || version != 1)
        return refuse(r, MR_VERSION, "run file of version `%s`; this program reads version 1",
                      r->line + 11);
    while (status == MR_OK && !r->ended && next_line(r))
        status = read_line(r, crc);
    return status == MR_OK ? check_complete(r) : status;
}

enum mr_status hil_run_read(const char *path, struct hil_run *run, char *error, size_t size)
{
    *run = (struct hil_run){0};
    struct reader r = {.at = {path, 0, error, size}, .run = run};
    enum mr_status status = parse(&r);
    free(r.bytes);
    if (status != MR_OK)
        hil_run_free(run);
    return status;
}

void hil_run_free(struct hil_run *run)
{
    free(run->commands);
    free(run->samples);
    *run = (struct hil_run){0};
}

double hil_run_truth(const struct hil_run *run, unsigned column, double t_s)
{
    double unit = column < HIL_RUN_TRANSDUCERS ? 1e-5 : 1e-2;
    double place = t_s * run->rate_hz;
    size_t last = run->sample_count - 1u;
    if (place <= 0.0)
        return unit * run->samples[0][column];
    if (place >= (double)last)
        return unit * run->samples[last][column];
    size_t i = (size_t)place;
    double fraction = place - (double)i;
    double a = run->samples[i][column], b = run->samples[i + 1u][column];
    return unit * (a + (b - a) * fraction);
}
