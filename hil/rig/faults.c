#include "hil/rig/faults.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "hil/board/machine.h"

_Static_assert(sizeof(struct hil_can_frame) <= 24, "a held frame has 24 bytes");

static const char *const line_names[HIL_LINES] = {"CAN out", "CAN in", "serial out", "serial in"};
static const char *const kind_names[HIL_LINE_FAULTS] = {"dropped",      "repeated",           "corrupted",
                                                       "delayed",      "with a bad stop bit", "with noise"};

__attribute__((format(printf, 3, 4))) static void tell(struct hil_board *board, unsigned file_line,
                                                       const char *format, ...)
{
    char text[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    board->state.counters.faults_injected++;
    hil_trace(board, "fault: %s", text);
    if (!board->options.log)
        return;
    uint64_t t_ns = hil_board_now_ps(board) / HIL_NS_PS;
    fprintf(board->options.log, "fault at %llu.%09llu s: %s", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u), text);
    if (file_line)
        fprintf(board->options.log, " (line %u)", file_line);
    fputc('\n', board->options.log);
}

void hil_faults_init(struct hil_board *board)
{
    board->state.faults.random = board->options.seed ^ 0xfa0175eedull;
    for (unsigned i = 0; i < HIL_FAULTS_MAX; i++)
        board->state.faults.due_ps[i] = HIL_NEVER;
    board->state.faults.bytes_ps = HIL_NEVER;
}

uint32_t hil_faults_random(struct hil_board *board, uint32_t bound)
{
    return (uint32_t)((hil_random(&board->state.faults.random) >> 32) * bound >> 32);
}

static void schedule(struct hil_board *board)
{
    struct hil_faults *faults = &board->state.faults;
    uint64_t next = HIL_NEVER;
    for (unsigned i = 0; i < faults->count; i++) {
        if (faults->due_ps[i] < next)
            next = faults->due_ps[i];
    }
    hil_event_set_ps(board, HIL_EVENT_FAULT, next);
}

static void schedule_late(struct hil_board *board)
{
    struct hil_faults *faults = &board->state.faults;
    uint64_t next = faults->bytes_ps;
    for (unsigned i = 0; i < faults->held_count; i++) {
        if (faults->held_ps[i] < next)
            next = faults->held_ps[i];
    }
    hil_event_set_ps(board, HIL_EVENT_LATE, next);
}

/* --- triggers --- */

/* Beyond the last switch that opens: the parabola through the last three. HIL_NEVER: it stops before. */
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
    double half_a_ft_s2 = (late_ft_s - early_ft_s) / (t[0] - t[2]); /* Newton's divided differences */
    double v_ft_s = late_ft_s + half_a_ft_s2 * (t[0] - t[1]);
    double root = v_ft_s * v_ft_s + 4.0 * half_a_ft_s2 * (station_ft - x[0]);
    if (root < 0.0)
        return HIL_NEVER;
    return (uint64_t)((t[0] + 2.0 * (station_ft - x[0]) / (v_ft_s + sqrt(root))) * 1e12);
}

/* When the gear passes a station: between two switches that open, in a straight line. HIL_NEVER: it does not. */
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
            double part = (station_ft - run->switch_ft[before]) / (run->switch_ft[i] - run->switch_ft[before]);
            uint64_t from = run->switch_open_ps[before];
            return from + (uint64_t)(part * (double)(run->switch_open_ps[i] - from));
        }
        before = i;
    }
    return coasting_ps(run, station_ft);
}

/* A counted thing has happened for the n-th time. */
static void reached(struct hil_board *board, enum hil_trigger trigger, uint64_t n)
{
    struct hil_faults *faults = &board->state.faults;
    bool any = false;
    for (unsigned i = 0; i < faults->count; i++) {
        const struct hil_fault *fault = &faults->fault[i];
        if (fault->trigger != trigger || fault->n != n || faults->over[i])
            continue;
        faults->due_ps[i] = hil_board_now_ps(board) + fault->delay_ps;
        any = true;
    }
    if (any)
        schedule(board);
}

void hil_faults_flash_operation(struct hil_board *board)
{
    reached(board, HIL_AT_FLASH, ++board->state.faults.flash_operations);
}

void hil_faults_nor_operation(struct hil_board *board)
{
    reached(board, HIL_AT_NOR, ++board->state.faults.nor_operations);
}

void hil_faults_can_sent(struct hil_board *board, uint64_t frames) { reached(board, HIL_AT_FRAME, frames); }

/* --- actions --- */

static void flip(struct hil_board *board, const struct hil_fault *fault)
{
    uint32_t address = fault->address + fault->bit / 8u;
    uint8_t byte = 0;
    if (hil_board_peek(board, address, &byte, 1) != MR_OK)
        return; /* checked when it was ordered */
    uint8_t after = (uint8_t)(byte ^ 1u << (fault->bit % 8u));
    (void)hil_board_poke(board, address, &after, 1);
    tell(board, fault->file_line, "bit %u at 0x%08x turned over: 0x%02x to 0x%02x", (unsigned)fault->bit,
         (unsigned)fault->address, byte, after);
}

static void set_line(struct hil_board *board, const struct hil_fault *fault)
{
    board->state.faults.effect[fault->line][fault->choice] = (struct hil_line_effect){
        fault->count, fault->probability, fault->duration_ps, fault->file_line};
    char count[16] = "all";
    if (fault->count != HIL_FAULT_ALL)
        snprintf(count, sizeof count, "%u", (unsigned)fault->count);
    tell(board, fault->file_line, "%s: from now on %s %s with probability %g", line_names[fault->line], count,
         kind_names[fault->choice], fault->probability);
}

static void fail_channel(struct hil_board *board, const struct hil_fault *fault)
{
    static const char *const states[] = {"mended", "sticks", "saturated high", "saturated low", "open"};
    static const char *const single[] = {"staircase", "reference"};
    hil_rig_fail(board, fault->index, (enum hil_channel_fault)fault->choice);
    if (fault->index < 22)
        tell(board, fault->file_line, "%s %u %s", fault->index < 8 ? "transducer" : "gage",
             (unsigned)(fault->index < 8 ? fault->index + 1 : fault->index - 7), states[fault->choice]);
    else
        tell(board, fault->file_line, "%s %s", single[fault->index - 22], states[fault->choice]);
}

static void fail_nor(struct hil_board *board, const struct hil_fault *fault)
{
    struct hil_nor_faults *nor = &board->state.nor_faults;
    static const char *const texts[] = {"NOR filled", "NOR dead", "NOR mended", "NOR page programs fail",
                                        "NOR erases fail"};
    switch ((enum hil_nor_fault)fault->choice) {
    case HIL_NOR_FILL:
        nor->fill_requested = true;
        break;
    case HIL_NOR_DEAD:
        nor->dead = true;
        break;
    case HIL_NOR_MEND:
        *nor = (struct hil_nor_faults){0};
        break;
    case HIL_NOR_FAIL_PROGRAM:
        nor->fail_program = fault->count;
        break;
    case HIL_NOR_FAIL_ERASE:
        nor->fail_erase = fault->count;
        break;
    }
    tell(board, fault->file_line, "%s", texts[fault->choice]);
}

static void fail_thermometer(struct hil_board *board, const struct hil_fault *fault)
{
    struct hil_tmp112 *chip = &board->state.tmp112;
    static const char *const texts[] = {"does not answer", "holds SDA low", "hangs within a byte", "holds SCL low at its next byte", "mended"};
    switch ((enum hil_thermometer_fault)fault->choice) {
    case HIL_THERMOMETER_DEAD:
        chip->dead = true;
        break;
    case HIL_THERMOMETER_STUCK:
        chip->stuck = true;
        break;
    case HIL_THERMOMETER_HANG:
        chip->hung_clocks = 9;
        break;
    case HIL_THERMOMETER_STRETCH:
        chip->stretch_ps = fault->duration_ps;
        break;
    case HIL_THERMOMETER_MEND:
        chip->dead = chip->stuck = false;
        chip->hung_clocks = 0;
        break;
    }
    tell(board, fault->file_line, "thermometer %s", texts[fault->choice]);
    hil_i2c_lines_changed(board, hil_now(board));
}

static void act(struct hil_board *board, const struct hil_fault *fault)
{
    static const char *const lamp[] = {"mended", "broken", "shorted"};
    static const char *const bus[] = {"connected", "unplugged", "shorted", "held dominant"};
    double ms = (double)fault->duration_ps / (double)HIL_MS_PS;
    switch (fault->action) {
    case HIL_FAULT_POWER_CUT:
        tell(board, fault->file_line, "power cut for %g ms", ms);
        hil_board_power_off(board, fault->duration_ps);
        break;
    case HIL_FAULT_BROWN_OUT:
        tell(board, fault->file_line, "supply at %g V for %g ms", fault->volts, ms);
        hil_board_brown_out(board, fault->volts, fault->duration_ps);
        break;
    case HIL_FAULT_CRYSTAL:
        tell(board, fault->file_line, "crystal %s", fault->on ? "starts" : "stops");
        hil_rcc_crystal(board, fault->on);
        break;
    case HIL_FAULT_FLIP:
        flip(board, fault);
        break;
    case HIL_FAULT_BUS:
        tell(board, fault->file_line, "CAN bus %s", bus[fault->choice]);
        hil_board_set_can_bus(board, (enum hil_can_bus)fault->choice);
        break;
    case HIL_FAULT_LINE:
        set_line(board, fault);
        break;
    case HIL_FAULT_CHANNEL:
        fail_channel(board, fault);
        break;
    case HIL_FAULT_SKIP:
        tell(board, fault->file_line, "switch %u will not open", (unsigned)fault->index + 1u);
        hil_rig_skip(board, fault->index);
        break;
    case HIL_FAULT_BOUNCE:
        tell(board, fault->file_line, "switch %u will bounce %u times", (unsigned)fault->index + 1u,
             (unsigned)fault->count);
        hil_rig_bounce(board, fault->index, fault->count, fault->duration_ps);
        break;
    case HIL_FAULT_CAMERA:
        tell(board, fault->file_line, "the camera gives no pulse for %u frames", (unsigned)fault->count);
        hil_camera_skip(board, fault->count);
        break;
    case HIL_FAULT_NOR:
        fail_nor(board, fault);
        break;
    case HIL_FAULT_DRIFT:
        tell(board, fault->file_line, "gage %u drifts: gain %g, offset %g lb", (unsigned)fault->index + 1u, fault->gain,
             fault->offset_lb);
        hil_rig_drift(board, fault->index, fault->gain, fault->offset_lb);
        break;
    case HIL_FAULT_THERMOMETER:
        fail_thermometer(board, fault);
        break;
    case HIL_FAULT_STICK:
        (void)hil_stuck_add(board, fault->address, fault->bit, fault->on);
        tell(board, fault->file_line, "bit %u at 0x%08x sticks at %d", (unsigned)fault->bit, (unsigned)fault->address, fault->on);
        break;
    case HIL_FAULT_LAMP:
        board->state.rig.lamp = (uint8_t)fault->choice;
        tell(board, fault->file_line, "warning lamp %s", lamp[fault->choice]);
        break;
    }
}

void hil_faults_event(struct hil_board *board, uint64_t at)
{
    struct hil_faults *faults = &board->state.faults;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    for (unsigned i = 0; i < faults->count; i++) {
        if (faults->due_ps[i] > now_ps)
            continue;
        faults->due_ps[i] = HIL_NEVER;
        faults->over[i] = true;
        act(board, &faults->fault[i]);
    }
    schedule(board);
}

/* --- ordering --- */

static enum mr_status refuse(struct hil_board *board, const struct hil_fault *fault, enum mr_status status,
                             const char *why)
{
    char place[24] = "";
    if (fault->file_line)
        snprintf(place, sizeof place, "line %u: ", fault->file_line);
    snprintf(board->reason, sizeof board->reason, "%s%s", place, why);
    return status;
}

/* Out of range, or NULL. */
static const char *wrong_argument(const struct hil_board *board, const struct hil_fault *f)
{
    uint8_t byte;
    switch (f->action) {
    case HIL_FAULT_FLIP:
        return f->bit > 31 || hil_board_peek(board, f->address + f->bit / 8u, &byte, 1) != MR_OK
                   ? "flip: no flash or RAM at that address" : NULL;
    case HIL_FAULT_BUS:
        return f->choice > HIL_CAN_DOMINANT ? "no such state of the bus" : NULL;
    case HIL_FAULT_LINE:
        if (f->line >= HIL_LINES || f->choice >= HIL_LINE_FAULTS || f->count == 0
            || !(f->probability > 0.0 && f->probability <= 1.0))
            return "a line fault needs a line, a kind, a count and a probability above 0, at most 1";
        return f->choice >= HIL_FRAMING && f->line != HIL_SERIAL_IN ? "framing and noise: only of serial in" : NULL;
    case HIL_FAULT_CHANNEL:
        return f->index > 23 || f->choice > HIL_CHANNEL_OPEN ? "no such channel" : NULL;
    case HIL_FAULT_CAMERA:
        return f->count ? NULL : "so many frames from 1";
    case HIL_FAULT_SKIP:
        return f->index >= HIL_RUN_SWITCHES ? "no such switch" : NULL;
    case HIL_FAULT_BOUNCE:
        return f->index >= HIL_RUN_SWITCHES || f->count == 0 || f->count > 255 || f->duration_ps < 2 * HIL_US_PS
                   ? "a bounce needs a switch, 1 to 255 times, at least 2 us apart" : NULL;
    case HIL_FAULT_NOR:
        return f->choice > HIL_NOR_FAIL_ERASE ? "no such fault of the NOR" : NULL;
    case HIL_FAULT_DRIFT:
        return f->index >= HIL_RUN_GAGES || !(f->gain > 0.0 && f->gain <= 10.0) || !(fabs(f->offset_lb) <= 1000.0)
                   ? "a drift needs a gage, a gain above 0 and an offset within 1000 lb" : NULL;
    case HIL_FAULT_THERMOMETER:
        return f->choice > HIL_THERMOMETER_MEND ? "no such fault of the thermometer" : NULL;
    case HIL_FAULT_STICK:
        return f->bit > 31 || !hil_board_memory(board, f->address + f->bit / 8u, 1, true) ? "stick: no RAM at that address" : NULL;
    case HIL_FAULT_LAMP:
        return f->choice > HIL_LAMP_SHORTED ? "no such state of the lamp" : NULL;
    case HIL_FAULT_POWER_CUT:
    case HIL_FAULT_BROWN_OUT:
        return f->duration_ps == 0 ? "a power fault needs a duration" : NULL;
    case HIL_FAULT_CRYSTAL:
        break;
    }
    return NULL;
}

static uint64_t counted(const struct hil_board *board, enum hil_trigger trigger)
{
    const struct hil_faults *faults = &board->state.faults;
    return trigger == HIL_AT_FRAME   ? board->state.counters.can_frames_out
           : trigger == HIL_AT_FLASH ? faults->flash_operations
                                     : faults->nor_operations;
}

enum mr_status hil_board_add_fault(struct hil_board *board, const struct hil_fault *fault)
{
    struct hil_faults *faults = &board->state.faults;
    uint64_t due_ps = HIL_NEVER;
    const char *wrong = wrong_argument(board, fault);
    if (wrong)
        return refuse(board, fault, MR_USAGE, wrong);
    if (faults->count == HIL_FAULTS_MAX)
        return refuse(board, fault, MR_FULL, "more faults than there is room for (64)");
    if (fault->trigger == HIL_AT_TIME) {
        due_ps = fault->t_ps + fault->delay_ps;
        if (due_ps < hil_board_now_ps(board))
            return refuse(board, fault, MR_USAGE, "that moment has passed");
    } else if (fault->trigger == HIL_AT_STATION) {
        uint64_t t_ps = board->run ? station_ps(board->run, fault->station_ft) : HIL_NEVER;
        if (t_ps == HIL_NEVER)
            return refuse(board, fault, MR_UNKNOWN,
                          board->run ? "the gear of this run does not pass that station, or before its first switch"
                                     : "a station needs a run: give --rig");
        due_ps = t_ps + fault->delay_ps;
    } else if (fault->n <= counted(board, fault->trigger)) {
        return refuse(board, fault, MR_USAGE, fault->n ? "that count has been passed" : "counting begins at 1");
    }
    faults->fault[faults->count] = *fault;
    faults->due_ps[faults->count++] = due_ps;
    schedule(board);
    return MR_OK;
}

enum mr_status hil_board_add_faults(struct hil_board *board, const struct hil_fault_script *script)
{
    enum mr_status status = MR_OK;
    board->state.faults.random = script->seed ^ 0xfa0175eedull;
    for (size_t i = 0; i < script->count && status == MR_OK; i++)
        status = hil_board_add_fault(board, &script->fault[i]);
    return status;
}

void hil_faults_tell_rest(const struct hil_board *board)
{
    const struct hil_faults *faults = &board->state.faults;
    for (unsigned i = 0; i < faults->count && board->options.log; i++) {
        if (!faults->over[i])
            fprintf(board->options.log, "fault of line %u did not happen: the run ended before it\n",
                    faults->fault[i].file_line);
    }
}

/* --- lines --- */

bool hil_faults_take(struct hil_board *board, enum hil_line line, enum hil_line_fault kind, const char *what,
                     uint32_t number)
{
    struct hil_line_effect *effect = &board->state.faults.effect[line][kind];
    if (!effect->left)
        return false;
    if (effect->probability < 1.0 && (double)hil_faults_random(board, 1u << 30) >= effect->probability * 0x1p30)
        return false;
    if (effect->left != HIL_FAULT_ALL)
        effect->left--;
    tell(board, effect->file_line, "%s: %s 0x%02x %s", line_names[line], what, (unsigned)number, kind_names[kind]);
    return true;
}

uint64_t hil_faults_delay_ps(const struct hil_board *board, enum hil_line line)
{
    return board->state.faults.effect[line][HIL_DELAY].duration_ps;
}

static void give_frame(struct hil_board *board, uint64_t t_ps, const struct hil_can_frame *frame)
{
    if (board->callbacks.on_can_frame)
        board->callbacks.on_can_frame(board->callbacks.ctx, t_ps, frame);
}

void hil_faults_can_out(struct hil_board *board, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct hil_faults *faults = &board->state.faults;
    if (board->pin_callbacks.on_can_frame)
        board->pin_callbacks.on_can_frame(board->pin_callbacks.ctx, t_ps, frame);
    if (hil_faults_take(board, HIL_CAN_OUT, HIL_DROP, "frame", frame->id))
        return;
    if (faults->held_count < HIL_FAULT_HELD && hil_faults_take(board, HIL_CAN_OUT, HIL_DELAY, "frame", frame->id)) {
        memcpy(faults->held_frame[faults->held_count], frame, sizeof *frame);
        faults->held_ps[faults->held_count++] = t_ps + hil_faults_delay_ps(board, HIL_CAN_OUT);
        schedule_late(board);
        return;
    }
    give_frame(board, t_ps, frame);
    if (hil_faults_take(board, HIL_CAN_OUT, HIL_REPEAT, "frame", frame->id))
        give_frame(board, t_ps, frame);
}

static void send_bytes(struct hil_board *board, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    if (n && board->callbacks.on_serial_bytes)
        board->callbacks.on_serial_bytes(board->callbacks.ctx, t_ps, bytes, n);
}

static void release_bytes(struct hil_board *board, uint64_t t_ps)
{
    struct hil_faults *faults = &board->state.faults;
    send_bytes(board, t_ps, faults->bytes, faults->bytes_count);
    faults->bytes_ps = HIL_NEVER;
    faults->bytes_count = 0;
}

static void give_bytes(struct hil_board *board, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct hil_faults *faults = &board->state.faults;
    if (faults->bytes_count + n > HIL_FAULT_BYTES)
        release_bytes(board, t_ps);
    if (faults->bytes_ps == HIL_NEVER) {
        send_bytes(board, t_ps, bytes, n);
        return;
    }
    memcpy(faults->bytes + faults->bytes_count, bytes, n); /* behind those that are late */
    faults->bytes_count += (uint32_t)n;
}

void hil_faults_serial_out(struct hil_board *board, uint64_t t_ps, uint8_t *bytes, size_t n)
{
    struct hil_faults *faults = &board->state.faults;
    size_t from = 0; /* not given yet */
    bool any = false;
    if (board->pin_callbacks.on_serial_bytes)
        board->pin_callbacks.on_serial_bytes(board->pin_callbacks.ctx, t_ps, bytes, n);
    for (unsigned kind = 0; kind < HIL_FRAMING; kind++)
        any |= faults->effect[HIL_SERIAL_OUT][kind].left != 0;
    for (size_t i = 0; any && i < n; i++) {
        if (hil_faults_take(board, HIL_SERIAL_OUT, HIL_DROP, "byte", bytes[i])) {
            give_bytes(board, t_ps, bytes + from, i - from);
            from = i + 1;
            continue;
        }
        if (faults->bytes_ps == HIL_NEVER && hil_faults_take(board, HIL_SERIAL_OUT, HIL_DELAY, "byte", bytes[i])) {
            give_bytes(board, t_ps, bytes + from, i - from);
            from = i;
            faults->bytes_ps = t_ps + hil_faults_delay_ps(board, HIL_SERIAL_OUT);
            schedule_late(board);
        }
        if (hil_faults_take(board, HIL_SERIAL_OUT, HIL_CORRUPT, "byte", bytes[i]))
            bytes[i] = (uint8_t)(bytes[i] ^ 1u << hil_faults_random(board, 8));
        if (hil_faults_take(board, HIL_SERIAL_OUT, HIL_REPEAT, "byte", bytes[i])) {
            give_bytes(board, t_ps, bytes + from, i + 1 - from);
            from = i;
        }
    }
    give_bytes(board, t_ps, bytes + from, n - from);
}

void hil_faults_late_event(struct hil_board *board, uint64_t at)
{
    struct hil_faults *faults = &board->state.faults;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    for (unsigned i = 0; i < faults->held_count;) {
        if (faults->held_ps[i] > now_ps) {
            i++;
            continue;
        }
        struct hil_can_frame frame;
        memcpy(&frame, faults->held_frame[i], sizeof frame);
        faults->held_count--;
        memmove(&faults->held_ps[i], &faults->held_ps[i + 1], (faults->held_count - i) * sizeof faults->held_ps[0]);
        memmove(&faults->held_frame[i], &faults->held_frame[i + 1],
                (faults->held_count - i) * sizeof faults->held_frame[0]);
        give_frame(board, now_ps, &frame);
    }
    if (faults->bytes_ps <= now_ps)
        release_bytes(board, now_ps);
    schedule_late(board);
}
