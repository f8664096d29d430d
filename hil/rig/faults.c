#include "hil/rig/faults.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "hil/chips/tmp112.h"
#include "hil/chips/w25q.h"
#include "hil/core/core.h"
#include "hil/core/cpu.h"
#include "hil/core/elf.h"
#include "hil/core/event.h"
#include "hil/core/file_place.h"
#include "hil/core/stuck.h"
#include "hil/core/time.h"
#include "hil/periph/can.h"
#include "hil/periph/i2c.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"
#include "hil/rig/camera.h"
#include "hil/rig/lines.h"
#include "hil/rig/supply.h"

#define tell(dev, fault, ...) \
    hil_fault_tell((dev)->core, (dev)->options->log, (fault)->file_line, __VA_ARGS__)

static void schedule(struct hil_faults_device *dev)
{
    struct hil_faults *faults = dev->state;
    uint64_t next = HIL_NEVER;
    for (unsigned i = 0; i < faults->count; i++) {
        if (faults->due_ps[i] < next)
            next = faults->due_ps[i];
    }
    hil_event_set_ps(dev->core, HIL_EVENT_FAULT, next);
}

/* --- triggers --- */

/* Beyond the last switch that opens: the parabola through the last three. HIL_NEVER: it stops
 * before. */
static uint64_t coasting_ps(const struct hil_run *run, double station_ft)
{
    double x[3] = {0}, t[3] = {0};
    unsigned n = 0;
    for (unsigned i = HIL_RUN_SWITCHES; i-- > 0 && n < 3;) {
        if (run->switch_open_ps[i] == HIL_RUN_NEVER)
            continue;
        x[n] = run->switch_ft[i];
        t[n++] = (double)run->switch_open_ps[i] * 1e-12;
    }
    if (n < 3)
        return HIL_NEVER;
    double late_ft_s = (x[0] - x[1]) / (t[0] - t[1]), early_ft_s = (x[1] - x[2]) / (t[1] - t[2]);
    /* Newton's divided differences */
    double half_a_ft_s2 = (late_ft_s - early_ft_s) / (t[0] - t[2]);
    double v_ft_s = late_ft_s + half_a_ft_s2 * (t[0] - t[1]);
    double root = v_ft_s * v_ft_s + 4.0 * half_a_ft_s2 * (station_ft - x[0]);
    if (root < 0.0)
        return HIL_NEVER;
    return (uint64_t)((t[0] + 2.0 * (station_ft - x[0]) / (v_ft_s + sqrt(root))) * 1e12);
}

/* When the gear passes a station: between two switches that open, in a straight line. HIL_NEVER: it
 * does not. */
static uint64_t station_ps(const struct hil_run *run, double station_ft)
{
    int before = -1;
    for (int i = 0; i < (int)HIL_RUN_SWITCHES; i++) {
        if (run->switch_open_ps[i] == HIL_RUN_NEVER)
            continue;
        if (run->switch_ft[i] == station_ft)
            return run->switch_open_ps[i];
        if (run->switch_ft[i] > station_ft) {
            if (before < 0)
                return HIL_NEVER;
            double part = (station_ft - run->switch_ft[before]) /
                          (run->switch_ft[i] - run->switch_ft[before]);
            uint64_t from = run->switch_open_ps[before];
            return from + (uint64_t)(part * (double)(run->switch_open_ps[i] - from));
        }
        before = i;
    }
    return coasting_ps(run, station_ft);
}

/* A counted thing has happened for the n-th time. */
static void reached(struct hil_faults_device *dev, enum hil_trigger trigger, uint64_t n)
{
    struct hil_faults *faults = dev->state;
    bool any = false;
    for (unsigned i = 0; i < faults->count; i++) {
        const struct hil_fault *fault = &faults->fault[i];
        if (fault->trigger != trigger || fault->n != n || faults->over[i])
            continue;
        faults->due_ps[i] = hil_now_ps(dev->core) + fault->delay_ps;
        any = true;
    }
    if (any)
        schedule(dev);
}

void hil_faults_flash_operation(void *device)
{
    struct hil_faults_device *dev = device;
    reached(dev, HIL_AT_FLASH, ++dev->state->flash_operations);
}

void hil_faults_nor_operation(void *device)
{
    struct hil_faults_device *dev = device;
    reached(dev, HIL_AT_NOR, ++dev->state->nor_operations);
}

void hil_faults_can_sent(void *device)
{
    struct hil_faults_device *dev = device;
    reached(dev, HIL_AT_FRAME, dev->core->state.counters.can_frames_out);
}

/* --- actions --- */

static void flip(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    uint32_t address = fault->address + fault->bit / 8u;
    uint8_t byte = 0;
    if (hil_memory_peek(dev->core, address, &byte, 1) != MR_OK)
        return; /* checked when it was ordered */
    uint8_t after = (uint8_t)(byte ^ 1u << (fault->bit % 8u));
    (void)hil_cpu_poke(dev->core, address, &after, 1);
    tell(dev, fault, "bit %u at 0x%08x turned over: 0x%02x to 0x%02x", (unsigned)fault->bit,
         (unsigned)fault->address, byte, after);
}

static void fail_channel(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    static const char *const states[] = {"mended", "sticks", "saturated high", "saturated low",
                                         "open"};
    static const char *const single[] = {"staircase", "reference"};
    hil_rig_fail(dev->rig, fault->index, (enum hil_channel_fault)fault->choice);
    if (fault->index < 22)
        tell(dev, fault, "%s %u %s", fault->index < 8 ? "transducer" : "gage",
             (unsigned)(fault->index < 8 ? fault->index + 1 : fault->index - 7),
             states[fault->choice]);
    else
        tell(dev, fault, "%s %s", single[fault->index - 22], states[fault->choice]);
}

static void fail_nor(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    struct hil_nor_orders *nor = dev->nor;
    static const char *const texts[] = {"NOR filled", "NOR dead", "NOR mended",
                                        "NOR page programs fail", "NOR erases fail"};
    switch ((enum hil_nor_fault)fault->choice) {
    case HIL_NOR_FILL: nor->fill_requested = true; break;
    case HIL_NOR_DEAD: nor->dead = true; break;
    case HIL_NOR_MEND: *nor = (struct hil_nor_orders){0}; break;
    case HIL_NOR_FAIL_PROGRAM: nor->fail_program = fault->count; break;
    case HIL_NOR_FAIL_ERASE: nor->fail_erase = fault->count; break;
    }
    tell(dev, fault, "%s", texts[fault->choice]);
}

static void fail_thermometer(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    struct hil_tmp112 *chip = dev->thermometer;
    static const char *const texts[] = {"does not answer", "holds SDA low", "hangs within a byte",
                                        "holds SCL low at its next byte", "mended"};
    switch ((enum hil_thermometer_fault)fault->choice) {
    case HIL_THERMOMETER_DEAD: chip->dead = true; break;
    case HIL_THERMOMETER_STUCK: chip->hold.stuck = true; break;
    case HIL_THERMOMETER_HANG: chip->hold.hung_clocks = 9; break;
    case HIL_THERMOMETER_STRETCH: chip->hold.stretch_ps = fault->duration_ps; break;
    case HIL_THERMOMETER_MEND:
        chip->dead = chip->hold.stuck = false;
        chip->hold.hung_clocks = 0;
        break;
    }
    tell(dev, fault, "thermometer %s", texts[fault->choice]);
    hil_i2c_lines_changed(dev->i2c, hil_now(dev->core));
}

static void act(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    static const char *const lamp[] = {"mended", "broken", "shorted"};
    static const char *const bus[] = {"connected", "unplugged", "shorted", "held dominant"};
    double ms = (double)fault->duration_ps / (double)HIL_MS_PS;
    switch (fault->action) {
    case HIL_FAULT_POWER_CUT:
        tell(dev, fault, "power cut for %g ms", ms);
        hil_supply_off(dev->supply, fault->duration_ps);
        break;
    case HIL_FAULT_BROWN_OUT:
        tell(dev, fault, "supply at %g V for %g ms", fault->volts, ms);
        hil_supply_dip(dev->supply, fault->volts, fault->duration_ps);
        break;
    case HIL_FAULT_CRYSTAL:
        tell(dev, fault, "crystal %s", fault->on ? "starts" : "stops");
        hil_rcc_crystal(dev->rcc, fault->on);
        break;
    case HIL_FAULT_FLIP: flip(dev, fault); break;
    case HIL_FAULT_BUS:
        tell(dev, fault, "CAN bus %s", bus[fault->choice]);
        hil_can_set_bus(dev->can, (enum hil_can_bus)fault->choice);
        break;
    case HIL_FAULT_LINE:
        hil_lines_order(dev->lines, fault->line, (enum hil_line_fault)fault->choice,
                        &(struct hil_line_effect){fault->count, fault->probability,
                                                  fault->duration_ps, fault->file_line});
        break;
    case HIL_FAULT_CHANNEL: fail_channel(dev, fault); break;
    case HIL_FAULT_SKIP:
        tell(dev, fault, "switch %u will not open", (unsigned)fault->index + 1u);
        hil_rig_skip(dev->rig, fault->index);
        break;
    case HIL_FAULT_BOUNCE:
        tell(dev, fault, "switch %u will bounce %u times", (unsigned)fault->index + 1u,
             (unsigned)fault->count);
        hil_rig_bounce(dev->rig, fault->index, fault->count, fault->duration_ps);
        break;
    case HIL_FAULT_CAMERA:
        tell(dev, fault, "the camera gives no pulse for %u frames", (unsigned)fault->count);
        hil_camera_skip(dev->camera, fault->count);
        break;
    case HIL_FAULT_NOR: fail_nor(dev, fault); break;
    case HIL_FAULT_DRIFT:
        tell(dev, fault, "gage %u drifts: gain %g, offset %g lb", (unsigned)fault->index + 1u,
             fault->gain, fault->offset_lb);
        hil_rig_drift(dev->rig, fault->index, fault->gain, fault->offset_lb);
        break;
    case HIL_FAULT_THERMOMETER: fail_thermometer(dev, fault); break;
    case HIL_FAULT_STICK:
        (void)hil_stuck_add(dev->core, fault->address, fault->bit, fault->on);
        tell(dev, fault, "bit %u at 0x%08x sticks at %d", (unsigned)fault->bit,
             (unsigned)fault->address, fault->on);
        break;
    case HIL_FAULT_LAMP:
        hil_rig_lamp(dev->rig, (enum hil_lamp)fault->choice);
        tell(dev, fault, "warning lamp %s", lamp[fault->choice]);
        break;
    }
}

static void on_due(void *device, uint64_t at)
{
    struct hil_faults_device *dev = device;
    struct hil_faults *faults = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    for (unsigned i = 0; i < faults->count; i++) {
        if (faults->due_ps[i] > now_ps)
            continue;
        faults->due_ps[i] = HIL_NEVER;
        faults->over[i] = true;
        act(dev, &faults->fault[i]);
    }
    schedule(dev);
}

/* --- ordering --- */

static enum mr_status refuse(struct hil_faults_device *dev, const struct hil_fault *fault,
                             enum mr_status status, const char *why)
{
    char place[24] = "";
    if (fault->file_line)
        snprintf(place, sizeof place, "line %u: ", fault->file_line);
    snprintf(dev->core->reason, sizeof dev->core->reason, "%s%s", place, why);
    return status;
}

/* Out of range, or NULL. */
static const char *wrong_argument(const struct hil_faults_device *dev, const struct hil_fault *f)
{
    uint8_t byte;
    switch (f->action) {
    case HIL_FAULT_FLIP:
        return f->bit > 31 ||
                       hil_memory_peek(dev->core, f->address + f->bit / 8u, &byte, 1) != MR_OK
                 ? "flip: no flash or RAM at that address"
                 : NULL;
    case HIL_FAULT_BUS: return f->choice > HIL_CAN_DOMINANT ? "no such state of the bus" : NULL;
    case HIL_FAULT_LINE:
        if (f->line >= HIL_LINES || f->choice >= HIL_LINE_FAULTS || f->count == 0 ||
            !(f->probability > 0.0 && f->probability <= 1.0))
            return "a line fault needs a line, a kind, a count and a probability above 0, at most "
                   "1";
        return f->choice >= HIL_FRAMING && f->line != HIL_SERIAL_IN
                 ? "framing and noise: only of serial in"
                 : NULL;
    case HIL_FAULT_CHANNEL:
        return f->index > 23 || f->choice > HIL_CHANNEL_OPEN ? "no such channel" : NULL;
    case HIL_FAULT_CAMERA: return f->count ? NULL : "so many frames from 1";
    case HIL_FAULT_SKIP: return f->index >= HIL_RUN_SWITCHES ? "no such switch" : NULL;
    case HIL_FAULT_BOUNCE:
        return f->index >= HIL_RUN_SWITCHES || f->count == 0 || f->count > 255 ||
                       f->duration_ps < 2 * HIL_US_PS
                 ? "a bounce needs a switch, 1 to 255 times, at least 2 us apart"
                 : NULL;
    case HIL_FAULT_NOR: return f->choice > HIL_NOR_FAIL_ERASE ? "no such fault of the NOR" : NULL;
    case HIL_FAULT_DRIFT:
        return f->index >= HIL_RUN_GAGES || !(f->gain > 0.0 && f->gain <= 10.0) ||
                       !(fabs(f->offset_lb) <= 1000.0)
                 ? "a drift needs a gage, a gain above 0 and an offset within 1000 lb"
                 : NULL;
    case HIL_FAULT_THERMOMETER:
        return f->choice > HIL_THERMOMETER_MEND ? "no such fault of the thermometer" : NULL;
    case HIL_FAULT_STICK:
        return f->bit > 31 || !hil_memory_at(dev->core, f->address + f->bit / 8u, 1, true)
                 ? "stick: no RAM at that address"
                 : NULL;
    case HIL_FAULT_LAMP: return f->choice > HIL_LAMP_SHORTED ? "no such state of the lamp" : NULL;
    case HIL_FAULT_POWER_CUT:
    case HIL_FAULT_BROWN_OUT: return f->duration_ps == 0 ? "a power fault needs a duration" : NULL;
    case HIL_FAULT_CRYSTAL: break;
    }
    return NULL;
}

static uint64_t counted(const struct hil_faults_device *dev, enum hil_trigger trigger)
{
    const struct hil_faults *faults = dev->state;
    return trigger == HIL_AT_FRAME ? dev->core->state.counters.can_frames_out
         : trigger == HIL_AT_FLASH ? faults->flash_operations
                                   : faults->nor_operations;
}

enum mr_status hil_faults_add(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    struct hil_faults *faults = dev->state;
    uint64_t due_ps = HIL_NEVER;
    const char *wrong = wrong_argument(dev, fault);
    if (wrong)
        return refuse(dev, fault, MR_USAGE, wrong);
    if (faults->count == HIL_FAULTS_MAX)
        return refuse(dev, fault, MR_FULL, "more faults than there is room for (64)");
    if (fault->trigger == HIL_AT_TIME) {
        due_ps = fault->t_ps + fault->delay_ps;
        if (due_ps < hil_now_ps(dev->core))
            return refuse(dev, fault, MR_USAGE, "that moment has passed");
    } else if (fault->trigger == HIL_AT_STATION) {
        uint64_t t_ps = dev->rig->run ? station_ps(dev->rig->run, fault->station_ft) : HIL_NEVER;
        if (t_ps == HIL_NEVER)
            return refuse(
                dev, fault, MR_UNKNOWN,
                dev->rig->run
                    ? "the gear of this run does not pass that station, or before its first switch"
                    : "a station needs a run: give --rig");
        due_ps = t_ps + fault->delay_ps;
    } else if (fault->n <= counted(dev, fault->trigger)) {
        return refuse(dev, fault, MR_USAGE,
                      fault->n ? "that count has been passed" : "counting begins at 1");
    }
    faults->fault[faults->count] = *fault;
    faults->due_ps[faults->count++] = due_ps;
    schedule(dev);
    return MR_OK;
}

enum mr_status hil_faults_add_all(struct hil_faults_device *dev,
                                  const struct hil_fault_script *script)
{
    enum mr_status status = MR_OK;
    hil_lines_seed(dev->lines, script->seed);
    for (size_t i = 0; i < script->count && status == MR_OK; i++)
        status = hil_faults_add(dev, &script->fault[i]);
    return status;
}

void hil_faults_tell_rest(const struct hil_faults_device *dev)
{
    const struct hil_faults *faults = dev->state;
    for (unsigned i = 0; i < faults->count && dev->options->log; i++) {
        if (!faults->over[i])
            fprintf(dev->options->log, "fault of line %u did not happen: the run ended before it\n",
                    faults->fault[i].file_line);
    }
}

void hil_faults_create(struct hil_faults_device *dev)
{
    for (unsigned i = 0; i < HIL_FAULTS_MAX; i++)
        dev->state->due_ps[i] = HIL_NEVER;
    hil_event_wire(dev->core, HIL_EVENT_FAULT, on_due, dev);
}

/* ---- faults_file ---- */

/* The text form of faults; its grammar is in hil/rig/faults.h. */

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
