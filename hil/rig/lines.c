#include "hil/rig/lines.h"

#include <stdarg.h>
#include <string.h>

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/state.h"
#include "hil/periph/cells.h"
#include "hil/periph/options.h"

_Static_assert(sizeof(struct hil_can_frame) <= 24, "a held frame has 24 bytes");

static const char *const line_names[HIL_LINES] = {"CAN out", "CAN in", "serial out", "serial in"};
static const char *const kind_names[HIL_LINE_FAULTS] = {
    "dropped", "repeated", "corrupted", "delayed", "with a bad stop bit", "with noise"};

static uint32_t random_below(void *device, uint32_t bound)
{
    struct hil_lines_device *dev = device;
    return (uint32_t)((hil_random(&dev->state->random) >> 32) * bound >> 32);
}

static void schedule_late(struct hil_lines_device *dev)
{
    struct hil_lines *lines = dev->state;
    uint64_t next = lines->bytes_ps;
    for (unsigned i = 0; i < lines->held_count; i++) {
        if (lines->held_ps[i] < next)
            next = lines->held_ps[i];
    }
    hil_event_set_ps(dev->core, HIL_EVENT_LATE, next);
}

static bool suffers(void *device, enum hil_line line, enum hil_line_fault kind, const char *what,
                    uint32_t number)
{
    struct hil_lines_device *dev = device;
    struct hil_line_effect *effect = &dev->state->effect[line][kind];
    if (!effect->left)
        return false;
    if (effect->probability < 1.0 &&
        (double)random_below(dev, 1u << 30) >= effect->probability * 0x1p30)
        return false;
    if (effect->left != HIL_FAULT_ALL)
        effect->left--;
    hil_fault_tell(dev->core, dev->options->log, effect->file_line, "%s: %s 0x%02x %s",
                   line_names[line], what, (unsigned)number, kind_names[kind]);
    return true;
}

static uint64_t delay_ps(const void *device, enum hil_line line)
{
    const struct hil_lines_device *dev = device;
    return dev->state->effect[line][HIL_DELAY].duration_ps;
}

static void give_frame(struct hil_lines_device *dev, uint64_t t_ps,
                       const struct hil_can_frame *frame)
{
    if (dev->callbacks.on_can_frame)
        dev->callbacks.on_can_frame(dev->callbacks.ctx, t_ps, frame);
}

static void can_out(void *device, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    hil_call(&dev->frame_sent);
    if (dev->pin_callbacks.on_can_frame)
        dev->pin_callbacks.on_can_frame(dev->pin_callbacks.ctx, t_ps, frame);
    if (suffers(dev, HIL_CAN_OUT, HIL_DROP, "frame", frame->id))
        return;
    if (lines->held_count < HIL_FAULT_HELD &&
        suffers(dev, HIL_CAN_OUT, HIL_DELAY, "frame", frame->id)) {
        memcpy(lines->held_frame[lines->held_count], frame, sizeof *frame);
        lines->held_ps[lines->held_count++] = t_ps + delay_ps(dev, HIL_CAN_OUT);
        schedule_late(dev);
        return;
    }
    give_frame(dev, t_ps, frame);
    if (suffers(dev, HIL_CAN_OUT, HIL_REPEAT, "frame", frame->id))
        give_frame(dev, t_ps, frame);
}

static void send_bytes(struct hil_lines_device *dev, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    if (n && dev->callbacks.on_serial_bytes)
        dev->callbacks.on_serial_bytes(dev->callbacks.ctx, t_ps, bytes, n);
}

static void release_bytes(struct hil_lines_device *dev, uint64_t t_ps)
{
    struct hil_lines *lines = dev->state;
    send_bytes(dev, t_ps, lines->bytes, lines->bytes_count);
    lines->bytes_ps = HIL_NEVER;
    lines->bytes_count = 0;
}

static void give_bytes(struct hil_lines_device *dev, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct hil_lines *lines = dev->state;
    if (lines->bytes_count + n > HIL_FAULT_BYTES)
        release_bytes(dev, t_ps);
    if (lines->bytes_ps == HIL_NEVER) {
        send_bytes(dev, t_ps, bytes, n);
        return;
    }
    memcpy(lines->bytes + lines->bytes_count, bytes, n); /* behind those that are late */
    lines->bytes_count += (uint32_t)n;
}

static void serial_out(void *device, uint64_t t_ps, uint8_t *bytes, size_t n)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    size_t from = 0; /* not given yet */
    bool any = false;
    if (dev->pin_callbacks.on_serial_bytes)
        dev->pin_callbacks.on_serial_bytes(dev->pin_callbacks.ctx, t_ps, bytes, n);
    for (unsigned kind = 0; kind < HIL_FRAMING; kind++)
        any |= lines->effect[HIL_SERIAL_OUT][kind].left != 0;
    for (size_t i = 0; any && i < n; i++) {
        if (suffers(dev, HIL_SERIAL_OUT, HIL_DROP, "byte", bytes[i])) {
            give_bytes(dev, t_ps, bytes + from, i - from);
            from = i + 1;
            continue;
        }
        if (lines->bytes_ps == HIL_NEVER &&
            suffers(dev, HIL_SERIAL_OUT, HIL_DELAY, "byte", bytes[i])) {
            give_bytes(dev, t_ps, bytes + from, i - from);
            from = i;
            lines->bytes_ps = t_ps + delay_ps(dev, HIL_SERIAL_OUT);
            schedule_late(dev);
        }
        if (suffers(dev, HIL_SERIAL_OUT, HIL_CORRUPT, "byte", bytes[i]))
            bytes[i] = (uint8_t)(bytes[i] ^ 1u << random_below(dev, 8));
        if (suffers(dev, HIL_SERIAL_OUT, HIL_REPEAT, "byte", bytes[i])) {
            give_bytes(dev, t_ps, bytes + from, i + 1 - from);
            from = i;
        }
    }
    give_bytes(dev, t_ps, bytes + from, n - from);
}

static void on_late(void *device, uint64_t at)
{
    struct hil_lines_device *dev = device;
    struct hil_lines *lines = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    for (unsigned i = 0; i < lines->held_count;) {
        if (lines->held_ps[i] > now_ps) {
            i++;
            continue;
        }
        struct hil_can_frame frame;
        memcpy(&frame, lines->held_frame[i], sizeof frame);
        lines->held_count--;
        memmove(&lines->held_ps[i], &lines->held_ps[i + 1],
                (lines->held_count - i) * sizeof lines->held_ps[0]);
        memmove(&lines->held_frame[i], &lines->held_frame[i + 1],
                (lines->held_count - i) * sizeof lines->held_frame[0]);
        give_frame(dev, now_ps, &frame);
    }
    if (lines->bytes_ps <= now_ps)
        release_bytes(dev, now_ps);
    schedule_late(dev);
}

void hil_lines_order(struct hil_lines_device *dev, enum hil_line line, enum hil_line_fault kind,
                     const struct hil_line_effect *effect)
{
    dev->state->effect[line][kind] = *effect;
}

void hil_lines_seed(struct hil_lines_device *dev, uint64_t seed)
{
    dev->state->random = seed ^ 0xfa0175eedull;
}

void hil_lines_create(struct hil_lines_device *dev, uint64_t seed)
{
    hil_lines_seed(dev, seed);
    dev->state->bytes_ps = HIL_NEVER;
    hil_event_wire(dev->core, HIL_EVENT_LATE, on_late, dev);
}

struct hil_wire hil_lines_wire(struct hil_lines_device *dev)
{
    return (struct hil_wire){dev, suffers, delay_ps, random_below, can_out, serial_out};
}

/* ---- the line that reports a fault ---- */

void hil_fault_tell(struct hil_core *core, FILE *log, unsigned file_line, const char *format, ...)
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
    uint64_t t_ns = hil_now_ps(core) / HIL_NS_PS;
    fprintf(log, "fault at %llu.%09llu s: %s", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u), text);
    if (file_line)
        fprintf(log, " (line %u)", file_line);
    fputc('\n', log);
}
