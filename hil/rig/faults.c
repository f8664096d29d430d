#include "hil/rig/faults.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "hil/chips/tmp112.h"
#include "hil/chips/w25q.h"
#include "hil/core/core.h"
#include "hil/core/cpu.h"
#include "hil/core/elf.h"
#include "hil/core/file_place.h"
#include "hil/periph/can.h"
#include "hil/periph/flash.h"
#include "hil/periph/i2c.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"
#include "hil/rig/rig.h"

/* ---- the two links ---- */

/* Reports a fault that fired, or a frame or byte that it affected: writes a line with the virtual
 * time to log and trace, and counts it. `log` NULL: no log. `file_line`: line in the fault file, or
 * 0. */
__attribute__((format(printf, 4, 5))) static void fault_report(struct hil_core *core, FILE *log,
                                                               unsigned file_line,
                                                               const char *format, ...)
{
    char text[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    core->state.counters.faults_injected++;
    hil_trace(core, "fault: %s", text);
    if (!log)
        return;
    uint64_t t_ns = hil_now_ps(core) / HIL_PS_PER_NS;
    fprintf(log, "fault at %llu.%09llu s: %s", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u), text);
    if (file_line)
        fprintf(log, " (line %u)", file_line);
    fputc('\n', log);
}

_Static_assert(sizeof(struct hil_can_frame) <= 24, "a held frame has 24 bytes");

static const char *const line_names[HIL_LINE_COUNT] = {"CAN out", "CAN in", "serial out",
                                                       "serial in"};
static const char *const kind_names[HIL_LINE_FAULT_COUNT] = {
    "dropped", "repeated", "corrupted", "delayed", "with a bad stop bit", "with noise"};

static uint32_t draw_number_below(void *device, uint32_t bound)
{
    struct hil_lines_device *dev = device;
    return (uint32_t)((mr_splitmix64(&dev->state->random_state) >> 32) * bound >> 32);
}

static void schedule_delayed_bytes(struct hil_lines_device *dev)
{
    struct hil_lines *lines = dev->state;
    uint64_t next = lines->delayed_bytes_due_ps;
    for (unsigned i = 0; i < lines->delayed_frame_count; i++) {
        if (lines->delayed_frame_due_ps[i] < next)
            next = lines->delayed_frame_due_ps[i];
    }
    hil_event_set_ps(dev->core, HIL_EVENT_DELAYED_OUTPUT, next);
}

static bool apply_line_fault(void *device, enum hil_line line, enum hil_line_fault kind,
                             const char *what, uint32_t number)
{
    struct hil_lines_device *dev = device;
    struct hil_line_effect *effect = &dev->state->effect[line][kind];
    if (!effect->remaining_units)
        return false;
    if (effect->probability < 1.0 &&
        (double)draw_number_below(dev, 1u << 30) >= effect->probability * 0x1p30)
        return false;
    if (effect->remaining_units != HIL_FAULT_NO_LIMIT)
        effect->remaining_units--;
    fault_report(dev->core, dev->options->fault_log, effect->file_line, "%s: %s 0x%02x %s",
                 line_names[line], what, (unsigned)number, kind_names[kind]);
    return true;
}

static uint64_t delay_ps(const void *device, enum hil_line line)
{
    const struct hil_lines_device *dev = device;
    return dev->state->effect[line][HIL_LINE_DELAY].duration_ps;
}

static void deliver_frame(struct hil_lines_device *dev, uint64_t t_ps,
                          const struct hil_can_frame *frame)
{
    if (dev->callbacks.on_can_frame)
        dev->callbacks.on_can_frame(dev->callbacks.context, t_ps, frame);
}

static void can_out(void *device, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    hil_callback_invoke(&dev->on_frame_sent);
    if (dev->pin_callbacks.on_can_frame)
        dev->pin_callbacks.on_can_frame(dev->pin_callbacks.context, t_ps, frame);
    if (apply_line_fault(dev, HIL_CAN_OUT, HIL_LINE_DROP, "frame", frame->id))
        return;
    if (lines->delayed_frame_count < HIL_FAULT_DELAYED_FRAMES_MAX &&
        apply_line_fault(dev, HIL_CAN_OUT, HIL_LINE_DELAY, "frame", frame->id)) {
        memcpy(lines->delayed_frame[lines->delayed_frame_count], frame, sizeof *frame);
        lines->delayed_frame_due_ps[lines->delayed_frame_count++] = t_ps +
                                                                    delay_ps(dev, HIL_CAN_OUT);
        schedule_delayed_bytes(dev);
        return;
    }
    deliver_frame(dev, t_ps, frame);
    if (apply_line_fault(dev, HIL_CAN_OUT, HIL_LINE_REPEAT, "frame", frame->id))
        deliver_frame(dev, t_ps, frame);
}

static void send_bytes(struct hil_lines_device *dev, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    if (n && dev->callbacks.on_serial_bytes)
        dev->callbacks.on_serial_bytes(dev->callbacks.context, t_ps, bytes, n);
}

static void release_delayed_bytes(struct hil_lines_device *dev, uint64_t t_ps)
{
    struct hil_lines *lines = dev->state;
    send_bytes(dev, t_ps, lines->delayed_bytes, lines->delayed_byte_count);
    lines->delayed_bytes_due_ps = HIL_NEVER;
    lines->delayed_byte_count = 0;
}

static void deliver_bytes(struct hil_lines_device *dev, uint64_t t_ps, const uint8_t *bytes,
                          size_t n)
{
    struct hil_lines *lines = dev->state;
    if (lines->delayed_byte_count + n > HIL_FAULT_DELAYED_BYTES_MAX)
        release_delayed_bytes(dev, t_ps);
    if (lines->delayed_bytes_due_ps == HIL_NEVER) {
        send_bytes(dev, t_ps, bytes, n);
        return;
    }
    /* append after the bytes that are already delayed */
    memcpy(lines->delayed_bytes + lines->delayed_byte_count, bytes, n);
    lines->delayed_byte_count += (uint32_t)n;
}

static void serial_out(void *device, uint64_t t_ps, uint8_t *bytes, size_t n)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    size_t from = 0; /* first byte that is not delivered yet */
    bool any = false;
    if (dev->pin_callbacks.on_serial_bytes)
        dev->pin_callbacks.on_serial_bytes(dev->pin_callbacks.context, t_ps, bytes, n);
    for (unsigned kind = 0; kind < HIL_LINE_FRAMING; kind++)
        any |= lines->effect[HIL_SERIAL_OUT][kind].remaining_units != 0;
    for (size_t i = 0; any && i < n; i++) {
        if (apply_line_fault(dev, HIL_SERIAL_OUT, HIL_LINE_DROP, "byte", bytes[i])) {
            deliver_bytes(dev, t_ps, bytes + from, i - from);
            from = i + 1;
            continue;
        }
        if (lines->delayed_bytes_due_ps == HIL_NEVER &&
            apply_line_fault(dev, HIL_SERIAL_OUT, HIL_LINE_DELAY, "byte", bytes[i])) {
            deliver_bytes(dev, t_ps, bytes + from, i - from);
            from = i;
            lines->delayed_bytes_due_ps = t_ps + delay_ps(dev, HIL_SERIAL_OUT);
            schedule_delayed_bytes(dev);
        }
        if (apply_line_fault(dev, HIL_SERIAL_OUT, HIL_LINE_CORRUPT, "byte", bytes[i]))
            bytes[i] = (uint8_t)(bytes[i] ^ 1u << draw_number_below(dev, 8));
        if (apply_line_fault(dev, HIL_SERIAL_OUT, HIL_LINE_REPEAT, "byte", bytes[i])) {
            deliver_bytes(dev, t_ps, bytes + from, i + 1 - from);
            from = i;
        }
    }
    deliver_bytes(dev, t_ps, bytes + from, n - from);
}

static void on_delayed_output_due(void *device, uint64_t at)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    for (unsigned i = 0; i < lines->delayed_frame_count;) {
        if (lines->delayed_frame_due_ps[i] > now_ps) {
            i++;
            continue;
        }
        struct hil_can_frame frame;
        memcpy(&frame, lines->delayed_frame[i], sizeof frame);
        lines->delayed_frame_count--;
        memmove(&lines->delayed_frame_due_ps[i], &lines->delayed_frame_due_ps[i + 1],
                (lines->delayed_frame_count - i) * sizeof lines->delayed_frame_due_ps[0]);
        memmove(&lines->delayed_frame[i], &lines->delayed_frame[i + 1],
                (lines->delayed_frame_count - i) * sizeof lines->delayed_frame[0]);
        deliver_frame(dev, now_ps, &frame);
    }
    if (lines->delayed_bytes_due_ps <= now_ps)
        release_delayed_bytes(dev, now_ps);
    schedule_delayed_bytes(dev);
}

static void seed_lines(struct hil_lines_device *dev, uint64_t seed)
{
    dev->state->random_state = seed ^ 0xfa0175eedull;
}

void hil_lines_init(struct hil_lines_device *dev, uint64_t seed)
{
    seed_lines(dev, seed);
    dev->state->delayed_bytes_due_ps = HIL_NEVER;
    hil_event_connect(dev->core, HIL_EVENT_DELAYED_OUTPUT, on_delayed_output_due, dev);
}

struct hil_line_calls hil_lines_calls(struct hil_lines_device *dev)
{
    return (struct hil_line_calls){dev,     apply_line_fault, delay_ps, draw_number_below,
                                   can_out, serial_out};
}

/* ---- the supply ---- */

#define CSR_BROWN_OUT      (1u << 25)
#define POWER_DOWN_RESET_V 1.68

void hil_supply_cut(struct hil_supply_device *dev)
{
    struct hil_core *core = dev->core;
    core->state.counters.power_cuts++;
    hil_trace(core, "power cut");
    hil_flash_interrupt_operation(dev->flash);
    hil_w25q_power_off(dev->nor);
    hil_tmp112_power_on(dev->thermometer);
    core->reset.has_lost_power = core->reset.is_requested = true;
    core->reset.csr_flags = HIL_CSR_POWER_ON;
    hil_core_request_check(core);
}

static void cut_supply_for(struct hil_supply_device *dev, uint64_t duration_ps)
{
    hil_supply_cut(dev);
    dev->core->reset.end_ps = hil_now_ps(dev->core) + duration_ps;
}

/* Supply voltage at which the chip resets: typical value for a falling supply (DS8626, embedded
 * reset and power control block). */
static double get_brown_out_volts(const struct hil_supply_device *dev)
{
    static const double level[4] = {2.83, 2.50, 2.19,
                                    POWER_DOWN_RESET_V}; /* indexed by OPTCR.BOR_LEV; 3: off */
    return level[dev->flash->state->option_bytes >> 2 & 3u];
}

static void dip_supply(struct hil_supply_device *dev, double volts, uint64_t duration_ps)
{
    /* HCLK in Hz per wait state, depending on the supply voltage (RM0090 table 10). */
    double hz_by_wait_state = volts >= 2.7 ? 30e6
                            : volts >= 2.4 ? 24e6
                            : volts >= 2.1 ? 22e6
                                           : 20e6;
    if (volts < POWER_DOWN_RESET_V) {
        cut_supply_for(dev, duration_ps);
    } else if (volts < get_brown_out_volts(dev)) {
        hil_core_request_reset(dev->core, CSR_BROWN_OUT);
        dev->core->reset.end_ps = hil_now_ps(dev->core) + duration_ps;
    } else if (volts < 1.8 || dev->core->state.clock.hclk_hz >
                                  hz_by_wait_state * ((dev->rcc->state->flash_acr & 7u) + 1u)) {
        hil_core_stop(dev->core, MR_HALTED,
                      "a supply of %.2f V is too low for HCLK %u Hz with %u wait states, and the "
                      "option bytes reset the chip only below %.2f V",
                      volts, (unsigned)dev->core->state.clock.hclk_hz,
                      (unsigned)(dev->rcc->state->flash_acr & 7u), get_brown_out_volts(dev));
    }
}

static void on_supply_return(void *device, uint64_t at)
{
    struct hil_supply_device *dev = device;
    (void)at;
    dev->state->is_held_in_reset = false;
    hil_w25q_power_on(dev->nor);
    hil_trace(dev->core, "reset released");
}

void hil_supply_hold_reset(struct hil_supply_device *dev)
{
    struct hil_reset *reset = &dev->core->reset;
    dev->state->is_held_in_reset = reset->end_ps > hil_now_ps(dev->core);
    if (dev->state->is_held_in_reset)
        hil_event_set_ps(dev->core, HIL_EVENT_POWER, reset->end_ps);
    reset->end_ps = 0;
}

void hil_supply_create(struct hil_supply_device *dev)
{
    hil_event_connect(dev->core, HIL_EVENT_POWER, on_supply_return, dev);
}

/* ---- faults ---- */

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

/* Time when the gear passes a station, interpolated between two switches that open. HIL_NEVER if
 * the station is not between two. */
static uint64_t find_station_ps(const struct hil_run *run, double station_ft)
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
    return HIL_NEVER;
}

/* Called at the n-th event of a counted kind: schedules the faults that wait for it. */
static void schedule_waiting_faults(struct hil_faults_device *dev, enum hil_fault_trigger trigger,
                                    uint64_t n)
{
    struct hil_faults *faults = dev->state;
    bool any = false;
    for (unsigned i = 0; i < faults->count; i++) {
        const struct hil_fault *fault = &faults->fault[i];
        if (fault->trigger != trigger || fault->event_number != n || faults->is_finished[i])
            continue;
        faults->due_ps[i] = hil_now_ps(dev->core) + fault->delay_ps;
        any = true;
    }
    if (any)
        schedule(dev);
}

void hil_faults_on_flash_operation(void *device)
{
    struct hil_faults_device *dev = device;
    schedule_waiting_faults(dev, HIL_TRIGGER_FLASH_OPERATION, ++dev->state->flash_operation_count);
}

void hil_faults_on_nor_operation(void *device)
{
    struct hil_faults_device *dev = device;
    schedule_waiting_faults(dev, HIL_TRIGGER_NOR_OPERATION, ++dev->state->nor_operation_count);
}

void hil_faults_on_can_sent(void *device)
{
    struct hil_faults_device *dev = device;
    schedule_waiting_faults(dev, HIL_TRIGGER_CAN_FRAME, dev->core->state.counters.can_frames_out);
}

/* --- actions --- */

static void flip_bit(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    uint32_t address = fault->address + fault->bit / 8u;
    uint8_t byte = 0;
    if (hil_memory_peek(dev->core, address, &byte, 1) != MR_OK)
        return; /* cannot fail, because the address was checked when the fault was added */
    byte = (uint8_t)(byte ^ 1u << (fault->bit % 8u));
    (void)hil_cpu_poke(dev->core, address, &byte, 1);
}

static void fail_nor(struct hil_nor_fault_requests *nor, const struct hil_fault *fault)
{
    switch ((enum hil_nor_fault)fault->variant) {
    case HIL_NOR_FILL: nor->is_fill_requested = true; break;
    case HIL_NOR_DEAD: nor->is_dead = true; break;
    case HIL_NOR_REPAIR: *nor = (struct hil_nor_fault_requests){0}; break;
    case HIL_NOR_STUCK: nor->is_always_busy = true; break;
    case HIL_NOR_FAIL_PROGRAM: nor->failing_program_count = fault->count; break;
    case HIL_NOR_FAIL_ERASE: nor->failing_erase_count = fault->count; break;
    case HIL_NOR_HANG: nor->hanging_operation_count = fault->count; break;
    }
}

static void fail_thermometer(struct hil_tmp112 *chip, const struct hil_fault *fault)
{
    switch ((enum hil_thermometer_fault)fault->variant) {
    case HIL_THERMOMETER_DEAD: chip->is_dead = true; break;
    case HIL_THERMOMETER_STUCK: chip->bus_faults.is_sda_stuck = true; break;
    case HIL_THERMOMETER_HANG: chip->bus_faults.clocks_until_release = 9; break;
    case HIL_THERMOMETER_BERR: chip->bus_faults.has_false_error = true; break;
    case HIL_THERMOMETER_STRETCH: chip->bus_faults.stretch_ps = fault->duration_ps; break;
    case HIL_THERMOMETER_REPAIR:
        chip->is_dead = chip->bus_faults.is_sda_stuck = false;
        chip->bus_faults.clocks_until_release = 0;
        break;
    }
}

static void apply_fault(struct hil_faults_device *dev, const struct hil_fault *f)
{
    fault_report(dev->core, dev->options->fault_log, f->file_line, "%s", f->action_text);
    switch (f->action) {
    case HIL_FAULT_POWER_CUT: cut_supply_for(dev->supply, f->duration_ps); break;
    case HIL_FAULT_BROWN_OUT: dip_supply(dev->supply, f->volts, f->duration_ps); break;
    case HIL_FAULT_CRYSTAL: hil_rcc_set_crystal(dev->rcc, f->variant); break;
    case HIL_FAULT_BIT_FLIP: flip_bit(dev, f); break;
    case HIL_FAULT_STUCK_BIT:
        (void)hil_stuck_bit_add(dev->core, f->address, f->bit, f->variant);
        break;
    case HIL_FAULT_CAN_BUS: hil_can_set_bus(dev->can, (enum hil_can_bus)f->variant); break;
    case HIL_FAULT_LINE:
        dev->lines->state->effect[f->line][f->variant] =
            (struct hil_line_effect){f->count, f->probability, f->duration_ps, f->file_line};
        break;
    case HIL_FAULT_CHANNEL:
        hil_rig_set_channel_fault(dev->rig, f->target_index, (enum hil_channel_fault)f->variant);
        break;
    case HIL_FAULT_SWITCH_SKIP: hil_rig_skip_switch(dev->rig, f->target_index); break;
    case HIL_FAULT_SWITCH_BOUNCE:
        hil_rig_bounce_switch(dev->rig, f->target_index, f->count, f->duration_ps);
        break;
    case HIL_FAULT_CAMERA: hil_camera_skip_frames(dev->camera, f->count); break;
    case HIL_FAULT_NOR: fail_nor(dev->nor, f); break;
    case HIL_FAULT_GAGE_DRIFT:
        hil_rig_set_gage_drift(dev->rig, f->target_index, f->gain, f->offset_lb);
        break;
    case HIL_FAULT_THERMOMETER:
        fail_thermometer(dev->thermometer, f);
        hil_i2c_on_lines_changed(dev->i2c, hil_now_cycle(dev->core));
        break;
    case HIL_FAULT_LAMP: hil_rig_set_lamp_fault(dev->rig, (enum hil_lamp_fault)f->variant); break;
    }
}

static void on_fault_due(void *device, uint64_t at)
{
    struct hil_faults_device *dev = device;
    struct hil_faults *faults = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    for (unsigned i = 0; i < faults->count; i++) {
        if (faults->due_ps[i] > now_ps)
            continue;
        faults->due_ps[i] = HIL_NEVER;
        faults->is_finished[i] = true;
        apply_fault(dev, &faults->fault[i]);
    }
    schedule(dev);
}

/* --- adding faults --- */

static enum mr_status refuse_fault(struct hil_faults_device *dev, const struct hil_fault *fault,
                                   enum mr_status status, const char *why)
{
    char place[24] = "";
    if (fault->file_line)
        snprintf(place, sizeof place, "line %u: ", fault->file_line);
    snprintf(dev->core->failure_reason, sizeof dev->core->failure_reason, "%s%s", place, why);
    return status;
}

static uint64_t get_event_count(const struct hil_faults_device *dev, enum hil_fault_trigger trigger)
{
    const struct hil_faults *faults = dev->state;
    return trigger == HIL_TRIGGER_CAN_FRAME       ? dev->core->state.counters.can_frames_out
         : trigger == HIL_TRIGGER_FLASH_OPERATION ? faults->flash_operation_count
                                                  : faults->nor_operation_count;
}

enum mr_status hil_faults_add(struct hil_faults_device *dev, const struct hil_fault *fault)
{
    struct hil_faults *faults = dev->state;
    uint64_t due_ps = HIL_NEVER;
    if ((fault->action == HIL_FAULT_BIT_FLIP || fault->action == HIL_FAULT_STUCK_BIT) &&
        !hil_memory_at(dev->core, fault->address + fault->bit / 8u, 1,
                       fault->action == HIL_FAULT_STUCK_BIT))
        return refuse_fault(dev, fault, MR_USAGE, "that address has no memory of that kind");
    if (faults->count == HIL_FAULTS_MAX)
        return refuse_fault(dev, fault, MR_FULL, "more than 64 faults");
    if (fault->trigger == HIL_TRIGGER_TIME) {
        due_ps = fault->trigger_ps + fault->delay_ps;
        if (due_ps < hil_now_ps(dev->core))
            return refuse_fault(dev, fault, MR_USAGE, "that time is in the past");
    } else if (fault->trigger == HIL_TRIGGER_STATION) {
        uint64_t t_ps = dev->rig->run ? find_station_ps(dev->rig->run, fault->station_ft)
                                      : HIL_NEVER;
        if (t_ps == HIL_NEVER)
            return refuse_fault(
                dev, fault, MR_UNKNOWN,
                dev->rig->run
                    ? "that station is not between two switches that the gear passes in this run"
                    : "the trigger station needs a run file: give --rig");
        due_ps = t_ps + fault->delay_ps;
    } else if (fault->event_number <= get_event_count(dev, fault->trigger)) {
        return refuse_fault(dev, fault, MR_USAGE,
                            fault->event_number ? "the count has already passed this number"
                                                : "counts begin at 1");
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
    seed_lines(dev->lines, script->seed);
    for (size_t i = 0; i < script->count && status == MR_OK; i++)
        status = hil_faults_add(dev, &script->fault[i]);
    return status;
}

void hil_faults_report_pending(const struct hil_faults_device *dev)
{
    const struct hil_faults *faults = dev->state;
    for (unsigned i = 0; i < faults->count && dev->options->fault_log; i++) {
        if (!faults->is_finished[i])
            fprintf(dev->options->fault_log,
                    "the fault of line %u did not occur, because the run ended earlier\n",
                    faults->fault[i].file_line);
    }
}

void hil_faults_create(struct hil_faults_device *dev)
{
    for (unsigned i = 0; i < HIL_FAULTS_MAX; i++)
        dev->state->due_ps[i] = HIL_NEVER;
    hil_event_connect(dev->core, HIL_EVENT_FAULT, on_fault_due, dev);
}

/* ---- text form ---- */

#define LINE_MAX_BYTES 256
#define WORDS_MAX      16

#define refuse_text(r, ...) hil_file_refuse(&(r)->place, __VA_ARGS__)

/* A number in a line: its name, its member and its range. ORDINAL: counted from 1; PS: a time, with
 * its factor to picoseconds. */
enum kind { INTEGER32, INTEGER64, REAL, ORDINAL, PS, ADDRESS };

static const struct number_field {
    const char *name;
    enum kind kind;
    size_t offset; /* offset in struct hil_fault */
    double low, high, ps;
} number_fields[] = {
#define FAULT_OFFSET(member) offsetof(struct hil_fault, member)
    {"S", PS, FAULT_OFFSET(trigger_ps), 0.0, 1e6, 1e12},
    {"FT", REAL, FAULT_OFFSET(station_ft), -1000.0, 10000.0, 0.0},
    {"N", INTEGER64, FAULT_OFFSET(event_number), 1.0, UINT32_MAX, 0.0},
    {"DELAY_US", PS, FAULT_OFFSET(delay_ps), 1e-6, 1e12, 1e6},
    {"MS", PS, FAULT_OFFSET(duration_ps), 1e-9, 1e9, 1e9},
    {"US", PS, FAULT_OFFSET(duration_ps), 1e-6, 1e12, 1e6},
    {"APART_US", PS, FAULT_OFFSET(duration_ps), 2.0, 1e12, 1e6},
    {"VOLTS", REAL, FAULT_OFFSET(volts), 0.0, 3.6, 0.0},
    {"PLACE", ADDRESS, FAULT_OFFSET(address), 0.0, 0.0, 0.0},
    {"BIT", INTEGER32, FAULT_OFFSET(bit), 0.0, 31.0, 0.0},
    {"COUNT", INTEGER32, FAULT_OFFSET(count), 1.0, UINT32_MAX - 1.0, 0.0},
    {"TIMES", INTEGER32, FAULT_OFFSET(count), 1.0, 255.0, 0.0},
    {"P", REAL, FAULT_OFFSET(probability), 1e-9, 1.0, 0.0},
    {"TRANSDUCER", ORDINAL, FAULT_OFFSET(target_index), 1.0, HIL_RUN_TRANSDUCERS, 0.0},
    {"GAGE", ORDINAL, FAULT_OFFSET(target_index), 1.0, HIL_RUN_GAGES, 0.0},
    {"SWITCH", ORDINAL, FAULT_OFFSET(target_index), 1.0, HIL_RUN_SWITCHES, 0.0},
    {"GAIN", REAL, FAULT_OFFSET(gain), 1e-3, 10.0, 0.0},
    {"LB", REAL, FAULT_OFFSET(offset_lb), -1000.0, 1000.0, 0.0},
#undef FAULT_OFFSET
};

/* Indexed by enum hil_fault_trigger. */
static const char *const triggers[] = {"at S [+ DELAY_US]", "station FT [+ DELAY_US]",
                                       "frame N [+ DELAY_US]", "flash N [+ DELAY_US]",
                                       "nor N [+ DELAY_US]"};

/* Patterns of a line, each with its initial fault. For alternatives separated by |, the index of
 * the given word is added to `variant`; a number of kind ORDINAL is added to `target_index`. */
#define CHANNEL_WORDS "mend|stick|high|low|open"
#define LINE_FAULT(on_line)                                            \
    {                                                                  \
        .action = HIL_FAULT_LINE, .line = on_line, .probability = 1.0, \
        .duration_ps = HIL_PS_PER_MS                                   \
    }
static const struct action {
    const char *pattern;
    struct hil_fault fault;
} actions[] = {
    {"power-cut MS", {.action = HIL_FAULT_POWER_CUT}},
    {"brown-out VOLTS MS", {.action = HIL_FAULT_BROWN_OUT}},
    {"crystal stop|start", {.action = HIL_FAULT_CRYSTAL}},
    {"flip PLACE BIT", {.action = HIL_FAULT_BIT_FLIP}},
    {"stick PLACE BIT 0|1", {.action = HIL_FAULT_STUCK_BIT}},
    {"lamp mend|broken|shorted", {.action = HIL_FAULT_LAMP}},
    {"bus connect|unplug|short|dominant", {.action = HIL_FAULT_CAN_BUS}},
    {"can out drop|repeat|corrupt|delay COUNT [p P] [us US]", LINE_FAULT(HIL_CAN_OUT)},
    {"can in drop|repeat|corrupt|delay COUNT [p P] [us US]", LINE_FAULT(HIL_CAN_IN)},
    {"serial out drop|repeat|corrupt|delay COUNT [p P] [us US]", LINE_FAULT(HIL_SERIAL_OUT)},
    {"serial in drop|repeat|corrupt|delay|framing|noise COUNT [p P] [us US]",
     LINE_FAULT(HIL_SERIAL_IN)},
    {"transducer TRANSDUCER " CHANNEL_WORDS, {.action = HIL_FAULT_CHANNEL}},
    {"gage GAGE " CHANNEL_WORDS,
     {.action = HIL_FAULT_CHANNEL, .target_index = HIL_RUN_TRANSDUCERS}},
    {"gage GAGE drift GAIN LB", {.action = HIL_FAULT_GAGE_DRIFT}},
    {"staircase " CHANNEL_WORDS, {.action = HIL_FAULT_CHANNEL, .target_index = HIL_RUN_COLUMNS}},
    {"reference " CHANNEL_WORDS,
     {.action = HIL_FAULT_CHANNEL, .target_index = HIL_RUN_COLUMNS + 1u}},
    {"switch SWITCH skip", {.action = HIL_FAULT_SWITCH_SKIP}},
    {"switch SWITCH bounce TIMES APART_US", {.action = HIL_FAULT_SWITCH_BOUNCE}},
    {"camera skip COUNT", {.action = HIL_FAULT_CAMERA}},
    {"nor fill|dead|mend|stuck", {.action = HIL_FAULT_NOR}},
    {"nor fail-program COUNT", {.action = HIL_FAULT_NOR, .variant = HIL_NOR_FAIL_PROGRAM}},
    {"nor fail-erase COUNT", {.action = HIL_FAULT_NOR, .variant = HIL_NOR_FAIL_ERASE}},
    {"nor hang COUNT", {.action = HIL_FAULT_NOR, .variant = HIL_NOR_HANG}},
    {"thermometer dead|stuck|hang|mend|berr", {.action = HIL_FAULT_THERMOMETER}},
    {"thermometer stretch MS",
     {.action = HIL_FAULT_THERMOMETER, .variant = HIL_THERMOMETER_STRETCH}},
};
#define ACTION_COUNT (sizeof actions / sizeof actions[0])

struct reader {
    struct hil_file_context place; /* line: number of the current line */
    const char *elf;
    char *word[WORDS_MAX];
    unsigned word_count, next_word;
    unsigned farthest_mismatch; /* index of the last word up to which any pattern has matched */
    const char *missing_symbol; /* symbol that the fault file names and the image does not have */
};

/* Returns word i, or "end of line", which contains spaces and therefore equals no word. */
static const char *get_word(const struct reader *r, unsigned i)
{
    return i < r->word_count ? r->word[i] : "end of line";
}

static const struct number_field *find_number_field(const char *name, size_t length)
{
    for (size_t i = 0; i < sizeof number_fields / sizeof number_fields[0]; i++) {
        if (strlen(number_fields[i].name) == length &&
            strncmp(number_fields[i].name, name, length) == 0)
            return &number_fields[i];
    }
    return NULL;
}

/* Accepts 0x20001234, SYMBOL or SYMBOL+OFFSET. */
static bool match_address(struct reader *r, const char *word, uint32_t *address)
{
    char name[LINE_MAX_BYTES], *end;
    unsigned long offset = 0;
    if (r->next_word == r->word_count)
        return false;
    if (isdigit((unsigned char)*word)) {
        *address = (uint32_t)strtoul(word, &end, 0);
        return !*end;
    }
    snprintf(name, sizeof name, "%s", word);
    char *plus = strchr(name, '+');
    if (plus) {
        *plus = '\0';
        offset = strtoul(plus + 1, &end, 0);
        if (!isdigit((unsigned char)plus[1]) || *end || offset > 0xffffff)
            return false;
    }
    if (!r->elf || hil_elf_find_symbol(r->elf, name, address) != MR_OK) {
        r->missing_symbol = word;
        return false;
    }
    *address += (uint32_t)offset;
    return true;
}

static bool match_number(struct reader *r, const struct number_field *slot, struct hil_fault *f)
{
    const char *text = get_word(r, r->next_word), *end;
    char *at = (char *)f + slot->offset;
    if (slot->kind == ADDRESS)
        return match_address(r, text, (uint32_t *)(void *)at);
    bool all = strcmp(slot->name, "COUNT") == 0 && strcmp(text, "all") == 0;
    double value = all ? slot->low : mr_decimal_parse(text, &end);
    if (!all && (end == text || *end || !(value >= slot->low && value <= slot->high)))
        return false;
    if (slot->kind != REAL && slot->kind != PS && value != floor(value))
        return false;
    switch (slot->kind) {
    case INTEGER32: *(uint32_t *)(void *)at = all ? HIL_FAULT_NO_LIMIT : (uint32_t)value; break;
    case INTEGER64: *(uint64_t *)(void *)at = (uint64_t)value; break;
    case REAL: *(double *)(void *)at = value; break;
    case ORDINAL: *(uint32_t *)(void *)at += (uint32_t)value - 1u; break;
    case PS: *(uint64_t *)(void *)at = (uint64_t)(value * slot->ps + 0.5); break;
    case ADDRESS: break;
    }
    return true;
}

/* Matches one of the words between | and adds its index to `variant`. */
static bool match_word(const char *wanted, const char *word, unsigned *choice)
{
    size_t length = strlen(word);
    for (unsigned i = 0;; i++, wanted++) {
        size_t n = strcspn(wanted, "|");
        if (n == length && strncmp(wanted, word, n) == 0) {
            *choice += i;
            return true;
        }
        wanted += n;
        if (!*wanted)
            return false;
    }
}

/* Matches the words from r->next_word on against a pattern. Returns false, with r->next_word
 * unchanged, if it does not match. */
static bool match_pattern(struct reader *r, const char *pattern, struct hil_fault *f)
{
    char copy[128], *save;
    unsigned began = r->next_word;
    snprintf(copy, sizeof copy, "%s", pattern);
    for (char *want = strtok_r(copy, " ]", &save); want; want = strtok_r(NULL, " ]", &save)) {
        if (*want == '[') { /* brackets enclose an optional word with its number */
            char *number = strtok_r(NULL, " ]", &save);
            if (strcmp(get_word(r, r->next_word), want + 1) != 0)
                continue;
            want = number;
            r->next_word++;
        }
        const struct number_field *slot = find_number_field(want, strlen(want));
        if (slot ? match_number(r, slot, f)
                 : match_word(want, get_word(r, r->next_word), &f->variant)) {
            r->next_word++;
            continue;
        }
        r->farthest_mismatch = r->next_word > r->farthest_mismatch ? r->next_word
                                                                   : r->farthest_mismatch;
        r->next_word = began;
        return false;
    }
    return true;
}

/* Appends a pattern and the ranges of its numbers, such as "gage GAGE(1 to 14) drift ...". */
static void format_pattern(char *out, size_t size, const char *pattern)
{
    size_t used = strlen(out);
    used += (size_t)snprintf(out + used, size - used, "%s", used ? ", or " : "");
    while (*pattern && used + 1 < size) {
        size_t n = strcspn(pattern, " ]");
        const struct number_field *slot = find_number_field(pattern, n);
        used += (size_t)snprintf(out + used, size - used, "%.*s", (int)n, pattern);
        if (slot && slot->kind != ADDRESS && used < size)
            used += (size_t)snprintf(out + used, size - used, "(%.4g to %.4g)", slot->low,
                                     slot->high);
        pattern += n;
        if (*pattern && used + 1 < size) {
            out[used++] = *pattern++;
            out[used] = '\0';
        }
    }
}

/* Reports the first word that does not fit, and the words that would fit. */
static enum mr_status refuse_action(const struct reader *r)
{
    char known[600] = "";
    const char *first = get_word(r, r->next_word);
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        size_t n = strcspn(actions[i].pattern, " ");
        if (strlen(first) == n && strncmp(actions[i].pattern, first, n) == 0)
            format_pattern(known, sizeof known, actions[i].pattern);
    }
    if (known[0])
        return refuse_text(r, MR_MALFORMED, "`%s` does not fit: %s",
                           get_word(r, r->farthest_mismatch), known);
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        size_t n = strcspn(actions[i].pattern, " "), used = strlen(known);
        if (i == 0 || strncmp(actions[i - 1].pattern, actions[i].pattern, n + 1) != 0)
            snprintf(known + used, sizeof known - used, "%s%.*s", i ? ", " : "", (int)n,
                     actions[i].pattern);
    }
    return refuse_text(r, MR_MALFORMED, "`%s` is not an action; give one of %s", first, known);
}

static enum mr_status read_fault(struct reader *r, struct hil_fault *fault)
{
    struct hil_fault when = {0};
    unsigned trigger = 0;
    while (trigger < 5 && !match_pattern(r, triggers[trigger], &when))
        trigger++;
    if (trigger == 5)
        return refuse_text(r, MR_MALFORMED,
                           "`%s`: begin the line with at S, station FT, frame N, flash N or nor N, "
                           "optionally followed by + DELAY_US",
                           get_word(r, r->farthest_mismatch));
    unsigned first = r->next_word;
    for (size_t i = 0; i < ACTION_COUNT && !r->missing_symbol; i++) {
        *fault = actions[i].fault;
        if (!match_pattern(r, actions[i].pattern, fault))
            continue;
        if (r->next_word < r->word_count)
            return refuse_text(r, MR_MALFORMED, "unexpected word `%s`", get_word(r, r->next_word));
        fault->trigger = (enum hil_fault_trigger)trigger;
        fault->trigger_ps = when.trigger_ps;
        fault->event_number = when.event_number;
        fault->station_ft = when.station_ft;
        fault->delay_ps = when.delay_ps;
        fault->file_line = r->place.line;
        for (size_t k = first, used = 0; k < r->word_count && used < sizeof fault->action_text; k++)
            used += (size_t)snprintf(fault->action_text + used, sizeof fault->action_text - used,
                                     "%s%s", k > first ? " " : "", r->word[k]);
        return MR_OK;
    }
    return r->missing_symbol
             ? refuse_text(r, MR_UNKNOWN, "%s has no symbol `%s`; list its symbols with `nm`",
                           r->elf ? r->elf : "no image", r->missing_symbol)
             : refuse_action(r);
}

static enum mr_status read_script_line(struct reader *r, struct hil_fault_script *script)
{
    char *end;
    if (strcmp(r->word[0], "seed") != 0)
        return script->count == HIL_FAULTS_MAX
                 ? refuse_text(r, MR_FULL, "more than %u faults; leave some out", HIL_FAULTS_MAX)
                 : read_fault(r, &script->fault[script->count++]);
    script->seed = strtoull(get_word(r, 1), &end, 10);
    return r->word_count == 2 && isdigit((unsigned char)*r->word[1]) && !*end
             ? MR_OK
             : refuse_text(r, MR_MALFORMED,
                           "`seed` must be followed by a whole number, not by `%s`",
                           get_word(r, 1));
}

static void split_words(struct reader *r, char *line)
{
    r->word_count = r->next_word = r->farthest_mismatch = 0;
    line[strcspn(line, "#\r\n")] = '\0';
    for (char *save, *word = strtok_r(line, " \t", &save); word && r->word_count < WORDS_MAX;
         word = strtok_r(NULL, " \t", &save))
        r->word[r->word_count++] = word;
}

enum mr_status hil_faults_read(const char *path, const char *elf, struct hil_fault_script *script,
                               char *error, size_t size)
{
    struct reader r = {.place = {path, 0, error, size}, .elf = elf};
    char line[LINE_MAX_BYTES];
    enum mr_status status = MR_OK;
    bool has_version = false;
    *script = (struct hil_fault_script){.seed = 1};
    FILE *file = fopen(path, "r");
    if (!file)
        return refuse_text(&r, MR_IO, "%s; give a fault file (format: hil/rig/faults.h)",
                           strerror(errno));
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        r.place.line++;
        split_words(&r, line);
        if (!r.word_count)
            continue;
        if (has_version)
            status = read_script_line(&r, script);
        else if (r.word_count != 2 || strcmp(r.word[0], "matrig-faults") != 0)
            break;
        else if (strcmp(r.word[1], "1") != 0)
            status = refuse_text(
                &r, MR_VERSION, "the fault file has version `%s`, but this program reads version 1",
                r.word[1]);
        has_version = true;
    }
    fclose(file);
    return status != MR_OK || has_version
             ? status
             : refuse_text(&r, MR_MALFORMED,
                           "not a fault file: its first line must be `matrig-faults 1`");
}
