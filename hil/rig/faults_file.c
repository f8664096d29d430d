/* The text form of faults; its grammar is in hil/rig/faults.h. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "hil/core/elf.h"
#include "hil/core/file_place.h"
#include "hil/core/time.h"
#include "hil/rig/faults.h"

#define LINE_MAX_BYTES 256
#define WORDS_MAX      16
#define SECONDS_MAX    1e6

#define refuse(r, ...) hil_file_refuse(&(r)->at, __VA_ARGS__)

struct reader {
    struct hil_file_place at; /* line: the present one */
    const char *elf;
    char *word[WORDS_MAX + 1]; /* NULL after the last */
    unsigned words, next;
    struct hil_fault_script *script;
    bool has_version;
};

/* At the end of a line what no word can be, for it has spaces. */
static const char *peek(const struct reader *r)
{
    return r->next < r->words ? r->word[r->next] : "end of line";
}

static bool take(struct reader *r, const char *word)
{
    if (strcmp(peek(r), word) != 0)
        return false;
    r->next++;
    return true;
}

static bool number(struct reader *r, double low, double high, double *value)
{
    const char *end;
    const char *text = peek(r);
    *value = mr_decimal_read(text, &end);
    if (end == text || *end || !(*value >= low && *value <= high))
        return false;
    r->next++;
    return true;
}

static bool whole(struct reader *r, uint64_t low, uint64_t high, uint64_t *value)
{
    char *end;
    const char *text = peek(r);
    errno = 0;
    *value = isdigit((unsigned char)*text) ? strtoull(text, &end, 0) : 0;
    if (!isdigit((unsigned char)*text) || *end || errno || *value < low || *value > high)
        return false;
    r->next++;
    return true;
}

/* One of the words of a list; -1: none of them. */
static int one_of(struct reader *r, const char *const *list, unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        if (take(r, list[i]))
            return (int)i;
    }
    return -1;
}

static bool duration(struct reader *r, double unit_ps, uint64_t *t_ps)
{
    double value;
    if (!number(r, 1.0 / unit_ps, SECONDS_MAX * 1e12 / unit_ps, &value)) /* from 1 ps */
        return false;
    *t_ps = (uint64_t)(value * unit_ps + 0.5);
    return true;
}

static enum mr_status read_trigger(struct reader *r, struct hil_fault *f)
{
    static const char *const names[] = {"at", "station", "frame", "flash", "nor"};
    double value;
    int trigger = one_of(r, names, 5);
    if (trigger < 0)
        return refuse(r, MR_MALFORMED,
                      "`%s` is no trigger; at, station, frame, flash or nor begins a line",
                      peek(r));
    f->trigger = (enum hil_trigger)trigger;
    if (f->trigger == HIL_AT_TIME) {
        if (!number(r, 0.0, SECONDS_MAX, &value))
            return refuse(r, MR_MALFORMED, "`at` needs a time in seconds, 0 to 1000000, not `%s`",
                          peek(r));
        f->t_ps = (uint64_t)(value * 1e12 + 0.5);
    } else if (f->trigger == HIL_AT_STATION) {
        if (!number(r, -1000.0, 10000.0, &f->station_ft))
            return refuse(r, MR_MALFORMED, "`station` needs a station in feet, not `%s`", peek(r));
    } else if (!whole(r, 1, UINT32_MAX, &f->n)) {
        return refuse(r, MR_MALFORMED, "`%s` needs a count from 1, not `%s`", names[trigger],
                      peek(r));
    }
    if (take(r, "+") && !duration(r, 1e6, &f->delay_ps))
        return refuse(r, MR_MALFORMED, "`+` needs a time in microseconds above 0, not `%s`",
                      peek(r));
    return MR_OK;
}

static enum mr_status read_bit(struct reader *r, struct hil_fault *f, enum hil_action action)
{
    char name[LINE_MAX_BYTES];
    uint64_t value, offset = 0;
    uint32_t base = 0;
    f->action = action;
    if (isdigit((unsigned char)*peek(r))) {
        if (!whole(r, 0, UINT32_MAX, &value))
            return refuse(r, MR_MALFORMED,
                          "`%s` is no address: 0x20001234, SYMBOL or SYMBOL+OFFSET", peek(r));
        base = (uint32_t)value;
    } else {
        snprintf(name, sizeof name, "%s", peek(r));
        char *plus = strchr(name, '+');
        char *end = plus;
        if (plus) {
            *plus = '\0';
            offset = strtoull(plus + 1, &end, 0);
        }
        if (r->next == r->words || !*name ||
            (plus && (!isdigit((unsigned char)plus[1]) || *end || offset > 0xffffff)))
            return refuse(r, MR_MALFORMED, "`%s` is no place: 0x20001234, SYMBOL or SYMBOL+OFFSET",
                          peek(r));
        enum mr_status status = r->elf ? hil_elf_symbol(r->elf, name, &base) : MR_UNKNOWN;
        if (status != MR_OK)
            return refuse(r, MR_UNKNOWN, "%s has no symbol `%s`; `nm` lists those it has",
                          r->elf ? r->elf : "no image", name);
        r->next++;
    }
    f->address = base + (uint32_t)offset;
    if (!whole(r, 0, 31, &value))
        return refuse(r, MR_MALFORMED,
                      "`flip` and `stick` need a bit, 0 to 31, after the place, not `%s`", peek(r));
    f->bit = (uint32_t)value;
    if (action == HIL_FAULT_STICK && !whole(r, 0, 1, &value))
        return refuse(r, MR_MALFORMED, "at which level does it stick, 0 or 1? Not at `%s`",
                      peek(r));
    f->on = value != 0;
    return MR_OK;
}

/* The next word is a choice of this action; else `wrong` says what there is. */
static enum mr_status choose(struct reader *r, struct hil_fault *f, enum hil_action action,
                             const char *const *list, const char *wrong)
{
    unsigned n = 0;
    while (list[n])
        n++;
    int choice = one_of(r, list, n);
    if (choice < 0)
        return refuse(r, MR_MALFORMED, "`%s` is no %s", peek(r), wrong);
    f->action = action;
    f->choice = (unsigned)choice;
    return MR_OK;
}

static enum mr_status read_crystal(struct reader *r, struct hil_fault *f)
{
    f->action = HIL_FAULT_CRYSTAL;
    f->on = take(r, "start");
    return f->on || take(r, "stop")
             ? MR_OK
             : refuse(r, MR_MALFORMED, "`%s`: a crystal can `stop` or `start`", peek(r));
}

static enum mr_status read_power(struct reader *r, struct hil_fault *f, bool brown_out)
{
    f->action = brown_out ? HIL_FAULT_BROWN_OUT : HIL_FAULT_POWER_CUT;
    if (brown_out && !number(r, 0.0, 3.6, &f->volts))
        return refuse(r, MR_MALFORMED, "`brown-out` needs volts, 0 to 3.6, not `%s`", peek(r));
    if (!duration(r, 1e9, &f->duration_ps))
        return refuse(r, MR_MALFORMED, "a power fault needs milliseconds above 0, not `%s`",
                      peek(r));
    return MR_OK;
}

static enum mr_status read_line(struct reader *r, struct hil_fault *f, bool serial)
{
    static const char *const ways[] = {"out", "in"};
    static const char *const kinds[] = {"drop", "repeat", "corrupt", "delay", "framing", "noise"};
    uint64_t count = HIL_FAULT_ALL;
    int way = one_of(r, ways, 2);
    if (way < 0)
        return refuse(r, MR_MALFORMED, "`%s` is no direction: out (from the board) or in", peek(r));
    int kind = one_of(r, kinds, serial && way == 1 ? 6 : 4);
    if (kind < 0)
        return refuse(r, MR_MALFORMED,
                      "`%s` is no fault of that line: drop, repeat, corrupt, delay%s", peek(r),
                      serial && way == 1 ? ", framing, noise" : "");
    if (!take(r, "all") && !whole(r, 1, UINT32_MAX - 1u, &count))
        return refuse(r, MR_MALFORMED, "how many? A count from 1, or `all`, not `%s`", peek(r));
    f->action = HIL_FAULT_LINE;
    f->line = (enum hil_line)(2 * serial + way);
    f->choice = (unsigned)kind;
    f->count = (uint32_t)count;
    f->probability = 1.0;
    f->duration_ps = HIL_MS_PS;
    if (take(r, "p") && (!number(r, 1e-9, 1.0, &f->probability)))
        return refuse(r, MR_MALFORMED, "`p` needs a probability above 0, at most 1, not `%s`",
                      peek(r));
    if (take(r, "us") && !duration(r, 1e6, &f->duration_ps))
        return refuse(r, MR_MALFORMED, "`us` needs microseconds above 0, not `%s`", peek(r));
    return MR_OK;
}

static enum mr_status read_channel(struct reader *r, struct hil_fault *f, unsigned first,
                                   unsigned count)
{
    static const char *const fails[] = {"mend", "stick", "high", "low", "open"};
    uint64_t number_of = 1;
    if (count > 1 && !whole(r, 1, count, &number_of))
        return refuse(r, MR_MALFORMED, "a number from 1 to %u is needed, not `%s`", count, peek(r));
    if (first == HIL_RUN_TRANSDUCERS && count == HIL_RUN_GAGES && take(r, "drift")) {
        f->action = HIL_FAULT_DRIFT;
        f->index = (uint32_t)number_of - 1u;
        if (!number(r, 1e-3, 10.0, &f->gain) || !number(r, -1000.0, 1000.0, &f->offset_lb))
            return refuse(r, MR_MALFORMED,
                          "`drift` needs a gain, 0.001 to 10, and an offset in pounds, not `%s`",
                          peek(r));
        return MR_OK;
    }
    int fail = one_of(r, fails, 5);
    if (fail < 0)
        return refuse(r, MR_MALFORMED,
                      "`%s` is no fault of a channel: stick, high, low, open, mend%s", peek(r),
                      count == HIL_RUN_GAGES ? ", drift" : "");
    f->action = HIL_FAULT_CHANNEL;
    f->index = first + (uint32_t)number_of - 1u;
    f->choice = (unsigned)fail;
    return MR_OK;
}

static enum mr_status read_switch(struct reader *r, struct hil_fault *f)
{
    uint64_t position, times;
    if (!whole(r, 1, HIL_RUN_SWITCHES, &position))
        return refuse(r, MR_MALFORMED, "`switch` needs a position, 1 to %u, not `%s`",
                      HIL_RUN_SWITCHES, peek(r));
    f->index = (uint32_t)position - 1u;
    f->action = HIL_FAULT_SKIP;
    if (take(r, "skip"))
        return MR_OK;
    f->action = HIL_FAULT_BOUNCE;
    if (!take(r, "bounce"))
        return refuse(r, MR_MALFORMED, "`%s` is no fault of a switch: skip or bounce", peek(r));
    if (!whole(r, 1, 255, &times) || !duration(r, 1e6, &f->duration_ps))
        return refuse(r, MR_MALFORMED,
                      "`bounce` needs a count, 1 to 255, and microseconds, not `%s`", peek(r));
    f->count = (uint32_t)times;
    return MR_OK;
}

static enum mr_status read_nor(struct reader *r, struct hil_fault *f)
{
    static const char *const kinds[] = {"fill", "dead", "mend", "fail-program", "fail-erase", NULL};
    uint64_t count = 1;
    enum mr_status status = choose(r, f, HIL_FAULT_NOR, kinds,
                                   "fault of the NOR: fill, dead, mend, fail-program, fail-erase");
    if (status == MR_OK && f->choice >= HIL_NOR_FAIL_PROGRAM && !whole(r, 1, UINT32_MAX, &count))
        return refuse(r, MR_MALFORMED, "how many operations fail? A count from 1, not `%s`",
                      peek(r));
    f->count = (uint32_t)count;
    return status;
}

static enum mr_status read_thermometer(struct reader *r, struct hil_fault *f)
{
    static const char *const kinds[] = {"dead", "stuck", "hang", "stretch", "mend", NULL};
    enum mr_status status = choose(r, f, HIL_FAULT_THERMOMETER, kinds,
                                   "fault of the thermometer: dead, stuck, hang, stretch, mend");
    if (status == MR_OK && f->choice == HIL_THERMOMETER_STRETCH &&
        !duration(r, 1e9, &f->duration_ps))
        return refuse(r, MR_MALFORMED, "`stretch` needs milliseconds above 0, not `%s`", peek(r));
    return status;
}

static enum mr_status read_camera(struct reader *r, struct hil_fault *f)
{
    uint64_t frames;
    if (!take(r, "skip") || !whole(r, 1, UINT32_MAX, &frames))
        return refuse(r, MR_MALFORMED, "`camera skip` and a count of frames from 1, not `%s`",
                      peek(r));
    f->action = HIL_FAULT_CAMERA;
    f->count = (uint32_t)frames;
    return MR_OK;
}

static enum mr_status read_action(struct reader *r, struct hil_fault *f)
{
    static const char *const bus[] = {"connect", "unplug", "short", "dominant", NULL};
    static const char *const lamp[] = {"mend", "broken", "shorted", NULL};
    if (take(r, "power-cut"))
        return read_power(r, f, false);
    if (take(r, "brown-out"))
        return read_power(r, f, true);
    if (take(r, "flip"))
        return read_bit(r, f, HIL_FAULT_FLIP);
    if (take(r, "stick"))
        return read_bit(r, f, HIL_FAULT_STICK);
    if (take(r, "lamp"))
        return choose(r, f, HIL_FAULT_LAMP, lamp, "state of the lamp: broken, shorted, mend");
    if (take(r, "can"))
        return read_line(r, f, false);
    if (take(r, "serial"))
        return read_line(r, f, true);
    if (take(r, "transducer"))
        return read_channel(r, f, 0, HIL_RUN_TRANSDUCERS);
    if (take(r, "gage"))
        return read_channel(r, f, HIL_RUN_TRANSDUCERS, HIL_RUN_GAGES);
    if (take(r, "staircase"))
        return read_channel(r, f, HIL_RUN_COLUMNS, 1);
    if (take(r, "reference"))
        return read_channel(r, f, HIL_RUN_COLUMNS + 1u, 1);
    if (take(r, "switch"))
        return read_switch(r, f);
    if (take(r, "camera"))
        return read_camera(r, f);
    if (take(r, "nor"))
        return read_nor(r, f);
    if (take(r, "thermometer"))
        return read_thermometer(r, f);
    if (take(r, "bus"))
        return choose(r, f, HIL_FAULT_BUS, bus,
                      "state of the bus: connect, unplug, short, dominant");
    if (take(r, "crystal"))
        return read_crystal(r, f);
    return refuse(r, MR_MALFORMED,
                  "`%s` is no action: power-cut, brown-out, crystal, flip, stick, lamp, bus, can, "
                  "serial, transducer, gage, staircase, "
                  "reference, switch, camera, nor or thermometer",
                  peek(r));
}

static enum mr_status read_words(struct reader *r)
{
    struct hil_fault fault = {.file_line = r->at.line};
    if (!r->has_version) {
        if (!take(r, "matrig-faults") || r->words != 2)
            return refuse(r, MR_MALFORMED,
                          "not a fault file: its first line must be `matrig-faults 1`");
        if (!take(r, "1"))
            return refuse(r, MR_VERSION,
                          "version `%s` of the fault file; this program reads version 1", peek(r));
        r->has_version = true;
        return MR_OK;
    }
    enum mr_status status = MR_OK;
    if (take(r, "seed")) {
        if (!whole(r, 0, UINT64_MAX, &r->script->seed))
            return refuse(r, MR_MALFORMED, "`seed` needs a whole number, not `%s`", peek(r));
    } else {
        status = read_trigger(r, &fault);
        if (status == MR_OK)
            status = read_action(r, &fault);
        if (status == MR_OK && r->script->count == HIL_FAULTS_MAX)
            return refuse(r, MR_FULL, "more than %u faults; leave some out", HIL_FAULTS_MAX);
        if (status == MR_OK)
            r->script->fault[r->script->count++] = fault;
    }
    if (status == MR_OK && r->next < r->words)
        return refuse(r, MR_MALFORMED, "`%s` is one word too many here", peek(r));
    return status;
}

static enum mr_status read_text(struct reader *r, char *line)
{
    r->words = r->next = 0;
    line[strcspn(line, "#\r\n")] = '\0';
    for (char *save, *word = strtok_r(line, " \t", &save); word;
         word = strtok_r(NULL, " \t", &save)) {
        if (r->words == WORDS_MAX)
            return refuse(r, MR_MALFORMED, "more than %u words in a line", WORDS_MAX);
        r->word[r->words++] = word;
    }
    return r->words ? read_words(r) : MR_OK;
}

enum mr_status hil_faults_read(const char *path, const char *elf, struct hil_fault_script *script,
                               char *error, size_t size)
{
    struct reader r = {.at = {path, 0, error, size}, .elf = elf, .script = script};
    char line[LINE_MAX_BYTES];
    enum mr_status status = MR_OK;
    *script = (struct hil_fault_script){.seed = 1};
    FILE *file = fopen(path, "r");
    if (!file)
        return refuse(&r, MR_IO,
                      "%s; give a file of faults (hil/rig/faults.h says how it is written)",
                      strerror(errno));
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        r.at.line++;
        if (!strchr(line, '\n') && !feof(file))
            status = refuse(&r, MR_MALFORMED, "a line of more than %u bytes", LINE_MAX_BYTES - 2);
        else
            status = read_text(&r, line);
    }
    bool failed = ferror(file) != 0;
    fclose(file);
    if (status == MR_OK && (failed || !r.has_version)) {
        r.at.line = 0;
        status = failed ? refuse(&r, MR_IO, "cannot be read")
                        : refuse(&r, MR_MALFORMED,
                                 "not a fault file: its first line must be `matrig-faults 1`");
    }
    return status;
}
