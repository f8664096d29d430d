#include "hil/rig/runfile.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "common/crc32.h"

#define FILE_MAX_BYTES (256u * 1024u * 1024u)
#define SAMPLES_MAX    4000000u
#define COMMANDS_MAX   10000u
#define PULSES_MAX     100000u

/* ---- records: text with a checksum ---- */

enum mr_status hil_text_file_open(struct hil_text_file *r, const char *kind)
{
    enum mr_status status = hil_file_read(&r->context, FILE_MAX_BYTES,
                                          "give a file that matrig wrote", &r->bytes, &r->size);
    size_t n = strlen(kind), end = r->size;
    uint32_t stated = 0;
    if (status != MR_OK)
        return status;
    if (strncmp(r->bytes, kind, n) != 0 || r->bytes[n] != ' ')
        return hil_file_refuse(&r->context, MR_MALFORMED, "the file does not begin with `%s 1`",
                               kind);
    if (strncmp(r->bytes + n, " 1\n", 3) != 0)
        return hil_file_refuse(&r->context, MR_VERSION,
                               "the file has version `%.*s`, but this program reads version 1",
                               (int)strcspn(r->bytes + n + 1, "\r\n"), r->bytes + n + 1);
    while (end >= 5 && memcmp(r->bytes + end - 5, "\nend ", 5) != 0)
        end--;
    if (end < 5)
        return hil_file_refuse(&r->context, MR_TRUNCATED, "the file has no `end` line");
    if (r->size - end != 9 || sscanf(r->bytes + end, "%8" SCNx32, &stated) != 1)
        return hil_file_refuse(&r->context, MR_MALFORMED,
                               "expected `end <crc32, 8 hex digits>` as the last line");
    uint32_t crc = mr_crc32(0, (const uint8_t *)r->bytes, end - 4);
    if (stated != crc)
        return hil_file_refuse(&r->context, MR_CRC,
                               "the file was changed or damaged, because its checksum is %08x, but "
                               "its `end` line states %08x",
                               (unsigned)crc, (unsigned)stated);
    r->size = end - 4;
    r->bytes[r->size] = '\0';
    r->next = r->bytes + n + 3;
    r->context.line = 1;
    return MR_OK;
}

char *hil_text_file_next_line(struct hil_text_file *r)
{
    while (r->next < r->bytes + r->size) {
        char *line = r->next, *end = strchr(line, '\n');
        if (!end)
            break; /* end here: the text contains a 0 */
        *end = '\0';
        r->next = end + 1;
        r->context.line++;
        if (line[0] && line[0] != '#')
            return line;
    }
    return NULL;
}

void *hil_array_grow(void *array, size_t count, size_t size)
{
    if (count & (count - 1))
        return array; /* the array is full if its count is a power of two */
    array = realloc(array, (count ? 2 * count : 1) * size);
    if (!array)
        abort();
    return array;
}

/* ---- pulse trains ---- */

uint64_t hil_pulse_train_next_edge(const struct hil_pulse_train *train,
                                   const struct hil_pulse_train_state *state, uint64_t width)
{
    if (state->is_high)
        return train->rise_times[state->next_pulse - 1] + width;
    return state->next_pulse < train->pulse_count ? train->rise_times[state->next_pulse]
                                                  : HIL_RUN_NEVER;
}

void hil_pulse_train_pass_edge(struct hil_pulse_train_state *state)
{
    state->is_high = !state->is_high;
    state->next_pulse += state->is_high;
}

/* ---- run files ---- */

#define refuse_file(r, ...) hil_file_refuse(&(r)->context, MR_MALFORMED, __VA_ARGS__)

/* Parses seconds with up to 12 decimals, at most 10^6 s, and converts them exactly to
 * picoseconds. */
static bool parse_time_ps(const char *text, uint64_t *t_ps)
{
    uint64_t value = 0;
    unsigned digits = 0;
    if (*text < '0' || *text > '9')
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

static enum mr_status read_switch(struct hil_text_file *r, struct hil_run *run, const char *text)
{
    unsigned position;
    double nominal_ft, true_ft;
    char open[32];
    int end = 0;
    uint64_t open_ps = HIL_RUN_NEVER;
    if (sscanf(text, "%u %lf %lf %31s %n", &position, &nominal_ft, &true_ft, open, &end) != 4 ||
        text[end] || position != run->switch_count + 1u || position > HIL_RUN_SWITCHES ||
        (strcmp(open, "-") != 0 && !parse_time_ps(open, &open_ps)))
        return refuse_file(r, "expected `switch %u <nominal_ft> <true_ft> <t_open_s or ->`",
                           run->switch_count + 1u);
    run->switch_open_ps[run->switch_count] = open_ps;
    run->switch_ft[run->switch_count++] = true_ft;
    return MR_OK;
}

static enum mr_status read_command(struct hil_text_file *r, struct hil_run *run, const char *text)
{
    struct hil_run_command command = {0};
    char time[32], link[8];
    int end = 0;
    if (sscanf(text, "%31s %7s %n", time, link, &end) != 2 || !parse_time_ps(time, &command.t_ps) ||
        (strcmp(link, "can") != 0 && strcmp(link, "serial") != 0))
        return refuse_file(r, "expected `command <t_s> <can or serial> <name> ...`");
    if (run->command_count && command.t_ps < run->commands[run->command_count - 1].t_ps)
        return refuse_file(r, "expected commands in order of time");
    command.is_sent_by_serial = link[0] == 's';
    if (run->command_count == COMMANDS_MAX)
        return refuse_file(r, "more than %u commands", COMMANDS_MAX);
    if (mr_command_parse(text + end, (uint16_t)(run->command_count + 1u), &command.message) !=
        MR_OK)
        return refuse_file(r, "`%s` is not a command", text + end);
    run->commands = hil_array_grow(run->commands, run->command_count, sizeof command);
    run->commands[run->command_count++] = command;
    return MR_OK;
}

static enum mr_status read_pulse(struct hil_text_file *r, struct hil_pulse_train *train,
                                 const char *text)
{
    uint64_t t_ps;
    if (train->pulse_count == PULSES_MAX || !parse_time_ps(text, &t_ps) ||
        (train->pulse_count && t_ps <= train->rise_times[train->pulse_count - 1]))
        return refuse_file(r, "expected up to %u times in ascending order", PULSES_MAX);
    train->rise_times = hil_array_grow(train->rise_times, train->pulse_count, sizeof t_ps);
    train->rise_times[train->pulse_count++] = t_ps;
    return MR_OK;
}

static bool read_row(const char *text, int32_t row[HIL_RUN_COLUMNS])
{
    for (unsigned i = 0; i < HIL_RUN_COLUMNS; i++) {
        char *end;
        errno = 0;
        long value = strtol(text, &end, 10);
        if (end == text || errno || value > INT32_MAX || value < INT32_MIN)
            return false;
        row[i] = (int32_t)value;
        text = end;
    }
    return text[strspn(text, " \r")] == '\0';
}

static enum mr_status read_samples(struct hil_text_file *r, struct hil_run *run, const char *text)
{
    unsigned count, repeat;
    int end = 0;
    if (run->samples || sscanf(text, "%u %lf %n", &count, &run->sample_rate_hz, &end) != 2 ||
        text[end] || count < 1 || count > SAMPLES_MAX ||
        !(run->sample_rate_hz > 0.0 && run->sample_rate_hz <= 1e9))
        return refuse_file(r, "expected only one line `samples <count 1..%u> <rate_hz>`",
                           SAMPLES_MAX);
    run->samples = calloc(count, sizeof *run->samples);
    if (!run->samples)
        abort();
    while (run->sample_count < count) {
        const char *line = hil_text_file_next_line(r);
        if (!line)
            return refuse_file(r, "the file has only %zu of %u samples", run->sample_count, count);
        if (line[0] != 'x') {
            if (!read_row(line, run->samples[run->sample_count++]))
                return refuse_file(r, "expected a row of %u integers, or xN", HIL_RUN_COLUMNS);
            continue;
        }
        if (!run->sample_count || sscanf(line, "x%u %n", &repeat, &end) != 1 || line[end] ||
            repeat > count - run->sample_count)
            return refuse_file(
                r, "`%s` is not a repeat count after a row, or repeats beyond the %u samples", line,
                count);
        for (; repeat; repeat--, run->sample_count++)
            memcpy(run->samples[run->sample_count], run->samples[run->sample_count - 1],
                   sizeof *run->samples);
    }
    return MR_OK;
}

static enum mr_status read_line(struct hil_text_file *r, struct hil_run *run, char *line)
{
    /* keys of true values, which tests compare with the board's results and the board must not
     * know */
    static const char truth[] = " provenance landing touchdown truth transducer gage gap_in "
                                "gap_end_in ";
    char keyword[16] = "", known[20];
    int end = 0;
    sscanf(line, "%15s %n", keyword, &end);
    if (strcmp(keyword, "switch") == 0)
        return read_switch(r, run, line + end);
    if (strcmp(keyword, "command") == 0)
        return read_command(r, run, line + end);
    if (strcmp(keyword, "brake") == 0)
        return read_pulse(r, &run->pulse_train[0], line + end);
    if (strcmp(keyword, "wheel") == 0)
        return read_pulse(r, &run->pulse_train[1], line + end);
    if (strcmp(keyword, "samples") == 0)
        return read_samples(r, run, line + end);
    if (strcmp(keyword, "duration_s") == 0) {
        const char *text = line + end;
        return sscanf(text, "%lf %n", &run->duration_s, &end) == 1 && !text[end] &&
                       run->duration_s > 0.0 && run->duration_s <= 1e6
                 ? MR_OK
                 : refuse_file(r, "expected `duration_s <seconds>`");
    }
    snprintf(known, sizeof known, " %s ", keyword);
    return strstr(truth, known) ? MR_OK : refuse_file(r, "unknown keyword `%s`", keyword);
}

enum mr_status hil_run_read(const char *path, struct hil_run *run, char *error, size_t size)
{
    struct hil_text_file r = {.context = {path, 0, error, size}};
    char *line;
    *run = (struct hil_run){0};
    enum mr_status status = hil_text_file_open(&r, "matrig-run");
    while (status == MR_OK && (line = hil_text_file_next_line(&r)) != NULL)
        status = read_line(&r, run, line);
    if (status == MR_OK &&
        (run->duration_s <= 0.0 || !run->samples || run->switch_count != HIL_RUN_SWITCHES))
        status = refuse_file(
            &r, "the run is incomplete: it has %s duration_s, %s samples and %u of %u switches",
            run->duration_s > 0.0 ? "a" : "no", run->samples ? "its" : "no", run->switch_count,
            HIL_RUN_SWITCHES);
    free(r.bytes);
    if (status != MR_OK)
        hil_run_free(run);
    return status;
}

void hil_run_free(struct hil_run *run)
{
    for (unsigned i = 0; i < HIL_RUN_TRAINS; i++)
        free(run->pulse_train[i].rise_times);
    free(run->commands);
    free(run->samples);
    *run = (struct hil_run){0};
}

double hil_run_get_true_value(const struct hil_run *run, unsigned column, double t_s)
{
    double unit = column < HIL_RUN_TRANSDUCERS ? 1e-5 : 1e-2;
    double place = t_s * run->sample_rate_hz;
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
