#include "hil/periph/can.h"

#include <string.h>

#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/periph/canbits.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"

#define MCR               0x000u
#define MSR               0x004u
#define TSR               0x008u
#define RF0R              0x00cu
#define RF1R              0x010u
#define ESR               0x018u
#define BTR               0x01cu
#define MAILBOXES         0x180u
#define FIFOS             0x1b0u
#define FMR               0x200u
#define FA1R              0x21cu
#define FILTER_BANKS      0x240u
#define MCR_RESET         0x8000u
#define TSR_STATUS        0xff000000u /* CODE, TME, LOW */
#define RFR_FMP           3u
#define RFR_RFOM          32u
#define FMR_FINIT         1u
#define MCR_INRQ          1u
#define MCR_SLEEP         2u
#define MCR_TXFP          4u
#define MCR_ABOM          64u
#define MSR_INAK          1u
#define MSR_SLAK          2u
#define BTR_LBKM          (1u << 30)
#define BTR_SILM          (1u << 31)
#define TIR_TXRQ          1u
#define RFR_FULL          8u
#define RFR_FOVR          16u
#define LEC_STUFF         1u
#define LEC_FORM          2u
#define LEC_BIT_RECESSIVE 4u
#define LEC_CRC           6u
/* while the bus is dominant, a node adds 8 to its error count every eight bits */
#define JAM_STEP_BITS     8u
#define LEC_ACK           3u
#define LEC_BIT_DOMINANT  5u
#define SUSPEND_BITS      8u /* additional wait of an error-passive node before it transmits */
#define JOIN_BUS_BITS     11u
/* duration of leaving the bus; the manual gives none, but HAL and libopencm3 wait, too */
#define LEAVE_BUS_BITS    2u
#define RECOVERY_BITS     (128u * 11u)

static uint64_t get_bit_cycles(const struct hil_can_device *dev)
{
    uint32_t btr = dev->state->btr;
    uint32_t quanta = 1u + (btr >> 16 & 15u) + 1u + (btr >> 20 & 7u) + 1u;
    return (uint64_t)quanta * ((btr & 0x3ffu) + 1u) * hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB1);
}

static uint32_t get_esr(const struct hil_can *c)
{
    uint32_t tec = c->is_bus_off ? 0xffu : c->tec > 255 ? 255 : c->tec;
    bool warning = c->tec >= 96 || c->rec >= 96, passive = c->tec > 127 || c->rec > 127;
    uint32_t flags = (uint32_t)(warning || c->is_bus_off) | (uint32_t)(passive || c->is_bus_off)
                                                                << 1;
    return flags | (uint32_t)c->is_bus_off << 2 | c->esr | tec << 16 |
           (c->rec > 255 ? 255u : c->rec) << 24;
}

static bool is_mailbox_empty(const struct hil_can *c, unsigned m)
{
    return !(c->mailbox[m].tir & TIR_TXRQ);
}

static void get_mailbox_frame(const struct hil_can_mailbox *m, struct hil_can_frame *frame)
{
    *frame = (struct hil_can_frame){
        .is_extended = (m->tir & 4u) != 0,
        .is_remote = (m->tir & 2u) != 0,
        .id = (m->tir & 4u) ? m->tir >> 3 : m->tir >> 21,
        .length = (uint8_t)((m->tdtr & 15u) > 8 ? 8 : m->tdtr & 15u),
    };
    for (unsigned i = 0; i < sizeof frame->data && i < frame->length; i++)
        frame->data[i] = (uint8_t)((i < 4 ? m->tdlr : m->tdhr) >> (8u * (i & 3u)));
}

/* True if mailbox a is sent before mailbox b. */
static bool is_sent_first(const struct hil_can *c, unsigned a, unsigned b)
{
    if (c->mcr & MCR_TXFP)
        return c->mailbox[a].request_number < c->mailbox[b].request_number;
    struct hil_can_frame fa, fb;
    get_mailbox_frame(&c->mailbox[a], &fa);
    get_mailbox_frame(&c->mailbox[b], &fb);
    return hil_can_arbitration_value(&fa) < hil_can_arbitration_value(&fb);
}

static int find_next_mailbox(const struct hil_can *c)
{
    int best = -1;
    for (unsigned m = 0; m < 3; m++) {
        if (!is_mailbox_empty(c, m) && (best < 0 || is_sent_first(c, m, (unsigned)best)))
            best = (int)m;
    }
    return best;
}

static uint32_t get_tsr(const struct hil_can *c)
{
    uint32_t value = c->tsr;
    unsigned empty = 0, code = 3, last = 0;
    for (unsigned m = 0; m < 3; m++) {
        if (is_mailbox_empty(c, m)) {
            value |= 1u << (26 + m);
            empty++;
            if (code == 3)
                code = m;
        } else if (is_mailbox_empty(c, last) || !is_sent_first(c, m, last)) {
            last = m; /* pending mailbox with the lowest priority */
        }
    }
    if (empty < 2) /* LOW is set only if at least two mailboxes are pending */
        value |= 1u << (29 + last);
    return value | (empty ? code : last) << 24;
}

static void update_irq(struct hil_can_device *dev)
{
    struct hil_can *c = dev->state;
    bool tx = (c->ier & 1u) && (c->tsr & 0x010101u);
    hil_irq_set_line(dev->core, HIL_IRQ_CAN1_TX, tx);
    hil_irq_set_line(dev->core, HIL_IRQ_CAN1_RX0, (c->ier & 2u) && c->fifo_count[0]);
}

static bool is_on_bus(const struct hil_can *c)
{
    return !(c->msr & (MSR_INAK | MSR_SLAK)) && c->phase < HIL_CAN_JOINING;
}

static void drop_other_node_frame(struct hil_can *c)
{
    c->other_node_queue_head = (c->other_node_queue_head + 1u) % HIL_CAN_QUEUE_LENGTH;
    c->other_node_queue_count--;
}

/* Returns the effective state of the bus for the board's transmitter, which includes a wrong bit
 * rate or pins that are not switched to CAN: both destroy every frame. */
static enum hil_can_bus get_effective_bus_state(const struct hil_can_device *dev)
{
    enum hil_can_bus bus = dev->options->can_bus;
    double rate = (double)dev->core->state.clock.hclk_hz / (double)get_bit_cycles(dev);
    double ratio = rate / HIL_CAN_OTHER_NODE_HZ;
    if (hil_gpio_alternate_function(dev->gpio, 3, 0) != 9 ||
        hil_gpio_alternate_function(dev->gpio, 3, 1) != 9)
        return HIL_CAN_SHORTED;
    /* Nodes whose rates differ by more than about 1 % lose synchronisation within the longest run
     * without an edge. */
    if (bus == HIL_CAN_CONNECTED && (ratio < 0.99 || ratio > 1.01))
        return HIL_CAN_SHORTED;
    return bus;
}

static void enter_phase(struct hil_can_device *dev, enum hil_can_phase phase, uint64_t from,
                        uint64_t bits)
{
    dev->state->phase = phase;
    hil_event_set_cycle(dev->core, HIL_EVENT_CAN, from + bits * get_bit_cycles(dev));
}

/* True if the other node has a frame to send. First applies the faults of the line to this
 * frame. */
static bool is_other_node_ready(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (c->other_node_waits_until_ps > now_ps)
        return false;
    if (c->other_node_waits_until_ps) { /* the delay of the frame by a fault has ended */
        c->other_node_waits_until_ps = 0;
        return true;
    }
    while (c->other_node_queue_count &&
           dev->line_calls.has_fault(dev->line_calls.context, HIL_CAN_IN, HIL_LINE_DROP, "frame",
                                     c->other_node_queue[c->other_node_queue_head].id))
        drop_other_node_frame(c);
    if (!c->other_node_queue_count ||
        !dev->line_calls.has_fault(dev->line_calls.context, HIL_CAN_IN, HIL_LINE_DELAY, "frame",
                                   c->other_node_queue[c->other_node_queue_head].id))
        return c->other_node_queue_count != 0;
    c->other_node_waits_until_ps = now_ps +
                                   dev->line_calls.delay_ps(dev->line_calls.context, HIL_CAN_IN);
    hil_event_set_ps(dev->core, HIL_EVENT_CAN_OTHER_NODE, c->other_node_waits_until_ps);
    return false;
}

/* If the bus is free, starts the frame that wins arbitration. */
static void try_start_frame(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    if (c->phase != HIL_CAN_IDLE || !is_on_bus(c))
        return;
    bool loopback = (c->btr & BTR_LBKM) != 0, silent = (c->btr & BTR_SILM) != 0;
    enum hil_can_bus bus = get_effective_bus_state(dev);
    int mine = silent && !loopback ? -1 : find_next_mailbox(c);
    if (!loopback && dev->options->can_bus == HIL_CAN_DOMINANT)
        return;
    bool other = c->other_node_queue_count && bus == HIL_CAN_CONNECTED && !silent && !loopback &&
                 is_other_node_ready(dev, at);
    struct hil_can_frame frame;
    if (mine >= 0)
        get_mailbox_frame(&c->mailbox[mine], &frame);
    if (other &&
        (mine < 0 || hil_can_arbitration_value(&c->other_node_queue[c->other_node_queue_head]) <
                         hil_can_arbitration_value(&frame))) {
        if (mine >= 0) { /* the board's mailbox lost arbitration */
            c->tsr |= 4u << (8u * (unsigned)mine);
        }
        c->sender = HIL_CAN_SENDER_OTHER_NODE;
        c->is_frame_destroyed =
            dev->line_calls.has_fault(dev->line_calls.context, HIL_CAN_IN, HIL_LINE_CORRUPT,
                                      "frame", c->other_node_queue[c->other_node_queue_head].id);
        enter_phase(dev, HIL_CAN_FRAME, at,
                    hil_can_frame_bits(&c->other_node_queue[c->other_node_queue_head]).length -
                        (c->is_frame_destroyed ? HIL_CAN_TAIL_BITS - HIL_CAN_ERROR_BITS : 0u));
        update_irq(dev);
        return;
    }
    if (mine < 0)
        return;
    struct hil_can_bits bits = hil_can_frame_bits(&frame);
    unsigned length = bits.length;
    if (!loopback && bus == HIL_CAN_UNPLUGGED)
        /* the ACK slot stays recessive */
        length = bits.length - HIL_CAN_TAIL_BITS + 2u + HIL_CAN_ERROR_BITS;
    else if (!loopback && bus == HIL_CAN_SHORTED)
        /* the error is detected at the start of frame, which reads back wrong */
        length = 1u + HIL_CAN_ERROR_BITS;
    c->sender = (int8_t)mine;
    c->is_abort_requested = false;
    c->is_frame_destroyed = !loopback && bus == HIL_CAN_CONNECTED &&
                            dev->line_calls.has_fault(dev->line_calls.context, HIL_CAN_OUT,
                                                      HIL_LINE_CORRUPT, "frame", frame.id);
    if (c->is_frame_destroyed) /* on a CRC error, an error flag and a delimiter follow */
        length = bits.length - HIL_CAN_TAIL_BITS + HIL_CAN_ERROR_BITS;
    enter_phase(dev, HIL_CAN_FRAME, at, length);
}

void hil_can_other_node_event(void *device, uint64_t at)
{
    try_start_frame(device, at);
}

/* Enters a state that ends after a number of recessive bits in a row. It cannot end while the bus
 * is held dominant. */
static void enter_recessive_wait(struct hil_can_device *dev, enum hil_can_phase phase,
                                 uint64_t from, uint64_t bits)
{
    enter_phase(dev, phase, from, bits);
    if (dev->options->can_bus == HIL_CAN_DOMINANT)
        hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
}

static void begin_recovery(struct hil_can_device *dev, uint64_t at, bool by_itself)
{
    dev->state->phase = HIL_CAN_BUS_OFF;
    hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
    if (by_itself)
        enter_recessive_wait(dev, HIL_CAN_BUS_OFF, at, RECOVERY_BITS);
}

/* Counts eight more dominant bits while the bus is jammed. An error-passive receiver stops
 * counting. */
static void end_jammed_frame(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    bool transmits = c->sender >= 0 && c->sender != HIL_CAN_SENDER_OTHER_NODE;
    c->esr = (transmits ? LEC_BIT_RECESSIVE : LEC_STUFF) << 4;
    *(transmits ? &c->tec : &c->rec) += 8u;
    hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
    if (c->tec > 255) {
        c->is_bus_off = true;
        c->tec = 0;
        hil_trace(dev->core, "CAN bus-off");
        begin_recovery(dev, at, (c->mcr & MCR_ABOM) != 0);
    } else if (transmits || c->rec <= 127) {
        enter_phase(dev, HIL_CAN_JAMMED, at, JAM_STEP_BITS);
    }
}

static void end_mailbox(struct hil_can_device *dev, unsigned m, uint32_t flags)
{
    struct hil_can *c = dev->state;
    c->mailbox[m].tir &= ~TIR_TXRQ;
    c->tsr = (c->tsr & ~(0xfu << (8u * m))) | (flags | 1u) << (8u * m);
    update_irq(dev);
}

/* --- acceptance filters (32.7.4): banks of 32 bits, mask or list --- */

/* The identifier register of a frame, in the format of mailboxes and filters. */
static uint32_t make_identifier_word(const struct hil_can_frame *f)
{
    return (f->is_extended ? f->id << 3 | 4u : f->id << 21) | (uint32_t)f->is_remote << 1;
}

bool hil_can_match_filters(const struct hil_can *can, const struct hil_can_frame *frame,
                           unsigned *fifo, unsigned *match)
{
    unsigned number[2] = {0, 0}; /* number of filters so far, per FIFO; inactive banks count too */
    unsigned banks = can->fmr >> 8 & 0x3fu;
    uint32_t word = make_identifier_word(frame);
    bool found = false;
    if (can->fmr & FMR_FINIT) /* nothing is received while filters are being written */
        return false;
    for (unsigned i = 0; i < banks && i < HIL_CAN_FILTER_BANKS; i++) {
        bool list = (can->fm1r >> i & 1u) != 0;
        uint32_t off_a = (word ^ can->filter[i][0]) & ~1u, off_b = (word ^ can->filter[i][1]) & ~1u;
        bool matches = list ? !off_a || !off_b : !(off_a & can->filter[i][1]);
        unsigned to = can->ffa1r >> i & 1u, n = number[to];
        number[to] += list ? 2 : 1;
        if (!(can->fa1r >> i & 1u) || !matches || (found && !list))
            continue;
        *fifo = to;
        *match = n + (list && off_a);
        found = true;
        if (list) /* a list match takes precedence over a mask match */
            break;
    }
    return found;
}

static void receive_frame(struct hil_can_device *dev, const struct hil_can_frame *frame)
{
    struct hil_can *c = dev->state;
    unsigned f, match;
    if (!hil_can_match_filters(c, frame, &f, &match)) {
        dev->core->state.counters.can_frames_filtered++;
        return;
    }
    struct hil_can_received_frame r = {
        .rir = make_identifier_word(frame),
        .rdtr = frame->length | match << 8,
    };
    for (unsigned i = 0; i < frame->length; i++)
        *(i < 4 ? &r.rdlr : &r.rdhr) |= (uint32_t)frame->data[i] << (8u * (i & 3u));
    if (c->fifo_count[f] == 3) {
        c->rfr[f] |= RFR_FOVR;
        c->fifo[f][2] = r; /* the frame overwrites the last one */
    } else {
        c->fifo[f][c->fifo_count[f]++] = r;
        if (c->fifo_count[f] == 3)
            c->rfr[f] |= RFR_FULL;
    }
    update_irq(dev);
}

static void fail_transmission(struct hil_can_device *dev, unsigned m, enum hil_can_bus bus,
                              uint64_t at)
{
    struct hil_can *c = dev->state;
    bool passive = c->tec > 127;
    dev->core->state.counters.can_errors++;
    uint32_t lec = c->is_frame_destroyed                      ? LEC_BIT_RECESSIVE
                 : dev->options->can_bus == HIL_CAN_CONNECTED ? LEC_FORM
                                                              : LEC_BIT_DOMINANT;
    c->esr = (bus == HIL_CAN_UNPLUGGED ? LEC_ACK : lec) << 4;
    /* exception 1 of fault confinement: the count stays if this is the only node on the bus */
    if (!(bus == HIL_CAN_UNPLUGGED && passive))
        c->tec += 8;
    if (c->is_abort_requested)
        end_mailbox(dev, m, 8u);
    else
        c->tsr |= 8u << (8u * m);
    if (c->tec > 255) {
        c->is_bus_off = true;
        c->tec = 0;
        hil_trace(dev->core, "CAN bus-off");
        begin_recovery(dev, at, (c->mcr & MCR_ABOM) != 0);
    } else {
        enter_phase(dev, HIL_CAN_INTERMISSION, at,
                    HIL_CAN_INTERMISSION_BITS + (c->tec > 127 ? SUSPEND_BITS : 0));
    }
}

static void end_frame(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    struct hil_can_frame frame;
    if (c->sender == HIL_CAN_SENDER_OTHER_NODE &&
        c->is_frame_destroyed) { /* the other node repeats its frame */
        dev->core->state.counters.can_errors++;
        c->esr = LEC_CRC << 4;
        c->rec++;
        enter_phase(dev, HIL_CAN_INTERMISSION, at, HIL_CAN_INTERMISSION_BITS);
        return;
    }
    if (c->sender == HIL_CAN_SENDER_OTHER_NODE) {
        frame = c->other_node_queue[c->other_node_queue_head];
        c->is_frame_repeated = !c->is_frame_repeated &&
                               dev->line_calls.has_fault(dev->line_calls.context, HIL_CAN_IN,
                                                         HIL_LINE_REPEAT, "frame", frame.id);
        if (!c->is_frame_repeated)
            drop_other_node_frame(c);
        dev->core->state.counters.can_frames_in++;
        c->esr = 0;
        c->rec = c->rec > 127 ? 120 : c->rec ? c->rec - 1 : 0;
        enter_phase(dev, HIL_CAN_INTERMISSION, at, HIL_CAN_INTERMISSION_BITS);
        receive_frame(dev, &frame);
        return;
    }
    unsigned m = (unsigned)c->sender;
    bool loopback = (c->btr & BTR_LBKM) != 0, silent = (c->btr & BTR_SILM) != 0;
    enum hil_can_bus bus = get_effective_bus_state(dev);
    if (!loopback && (bus != HIL_CAN_CONNECTED || c->is_frame_destroyed)) {
        fail_transmission(dev, m, bus, at);
        return;
    }
    get_mailbox_frame(&c->mailbox[m], &frame);
    c->esr = 0;
    if (c->tec)
        c->tec--;
    end_mailbox(dev, m, 2u);
    enter_phase(dev, HIL_CAN_INTERMISSION, at, HIL_CAN_INTERMISSION_BITS);
    if (loopback)
        receive_frame(dev, &frame);
    if (!silent && bus == HIL_CAN_CONNECTED) {
        dev->core->state.counters.can_frames_out++;
        dev->line_calls.can_out(dev->line_calls.context,
                                hil_clock_ps_at_cycle(&dev->core->state.clock, at), &frame);
    }
}

/* Enters initialisation or sleep if MCR requests it and no frame is in progress. */
static void update_mode(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    if (c->phase == HIL_CAN_FRAME)
        return;
    if (c->phase == HIL_CAN_LEAVING && !(c->mcr & MCR_INRQ))
        c->phase = HIL_CAN_IDLE;
    if (c->mcr & MCR_SLEEP) {
        if (!(c->msr & MSR_INAK) || !(c->mcr & MCR_INRQ)) {
            c->msr = (c->msr & ~MSR_INAK) | MSR_SLAK;
            c->phase = HIL_CAN_IDLE;
            hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
        }
        return;
    }
    if ((c->mcr & MCR_INRQ) && !(c->msr & MSR_INAK)) {
        if (c->phase != HIL_CAN_LEAVING)
            enter_phase(dev, HIL_CAN_LEAVING, at, LEAVE_BUS_BITS);
    } else if (c->mcr & MCR_INRQ) {
        c->phase = HIL_CAN_IDLE;
        hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
    } else if ((c->msr & (MSR_INAK | MSR_SLAK)) && c->phase < HIL_CAN_JOINING) {
        if (c->is_bus_off)
            begin_recovery(dev, at, true);
        else
            enter_recessive_wait(dev, HIL_CAN_JOINING, at, JOIN_BUS_BITS);
    }
}

void hil_can_event(void *device, uint64_t at)
{
    struct hil_can_device *dev = device;
    struct hil_can *c = dev->state;
    switch (c->phase) {
    case HIL_CAN_FRAME: end_frame(dev, at); break;
    case HIL_CAN_BUS_OFF:
        c->is_bus_off = false;
        c->tec = c->rec = 0;
        hil_trace(dev->core, "CAN recovered from bus-off");
        /* fall through */
    case HIL_CAN_JOINING:
        c->msr &= ~(MSR_INAK | MSR_SLAK);
        c->phase = HIL_CAN_IDLE;
        break;
    case HIL_CAN_JAMMED: end_jammed_frame(dev, at); return;
    case HIL_CAN_LEAVING:
        c->msr = (c->msr & ~MSR_SLAK) | MSR_INAK;
        c->phase = HIL_CAN_IDLE;
        return;
    default: c->phase = HIL_CAN_IDLE; break;
    }
    update_mode(dev, at);
    try_start_frame(dev, at);
}

enum mr_status hil_can_inject(struct hil_can_device *dev, const struct hil_can_frame *frame)
{
    struct hil_can *c = dev->state;
    if (c->other_node_queue_count == HIL_CAN_QUEUE_LENGTH) {
        dev->core->state.counters.can_frames_in_dropped++;
        return MR_FULL;
    }
    c->other_node_queue[(c->other_node_queue_head + c->other_node_queue_count) %
                        HIL_CAN_QUEUE_LENGTH] = *frame;
    c->other_node_queue_count++;
    try_start_frame(dev, hil_now_cycle(dev->core));
    return MR_OK;
}

/* Makes the bus dominant. The frame in progress is destroyed, and the nodes detect an error. */
static void begin_jam(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    if (c->phase == HIL_CAN_JOINING || c->phase == HIL_CAN_BUS_OFF) {
        hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
        return;
    }
    if (!is_on_bus(c) || (c->btr & BTR_LBKM))
        return;
    if (c->phase == HIL_CAN_FRAME && c->sender != HIL_CAN_SENDER_OTHER_NODE)
        dev->core->state.counters.can_errors++;
    else
        c->sender = -1;
    enter_phase(dev, HIL_CAN_JAMMED, at, JAM_STEP_BITS);
}

static void end_jam(struct hil_can_device *dev, uint64_t at)
{
    struct hil_can *c = dev->state;
    if (c->phase == HIL_CAN_JOINING)
        enter_phase(dev, HIL_CAN_JOINING, at, JOIN_BUS_BITS);
    else if (c->phase == HIL_CAN_BUS_OFF && (c->mcr & MCR_ABOM))
        enter_phase(dev, HIL_CAN_BUS_OFF, at, RECOVERY_BITS);
    else if (c->phase == HIL_CAN_JAMMED) /* the time of error delimiter and intermission follows */
        enter_phase(dev, HIL_CAN_INTERMISSION, at, JOIN_BUS_BITS);
}

void hil_can_set_bus(struct hil_can_device *dev, enum hil_can_bus can_bus)
{
    enum hil_can_bus before = dev->options->can_bus;
    uint64_t now = hil_now_cycle(dev->core);
    dev->options->can_bus = can_bus;
    if (can_bus == HIL_CAN_DOMINANT && before != HIL_CAN_DOMINANT)
        begin_jam(dev, now);
    else if (before == HIL_CAN_DOMINANT && can_bus != HIL_CAN_DOMINANT)
        end_jam(dev, now);
    try_start_frame(dev, now);
}

void hil_can_reset(void *device, unsigned unit)
{
    struct hil_can_device *dev = device;
    (void)unit;
    struct hil_can *c = dev->state;
    struct hil_can before = *c;
    *c = (struct hil_can){.mcr = 0x00010002, .msr = MSR_SLAK, .btr = 0x01230000, .fmr = 0x2a1c0e01};
    /* keep the frames queued by the other node, which the board's reset does not affect */
    c->other_node_waits_until_ps = before.other_node_waits_until_ps;
    c->other_node_queue_head = before.other_node_queue_head;
    c->other_node_queue_count = before.other_node_queue_count;
    memcpy(c->other_node_queue, before.other_node_queue, sizeof c->other_node_queue);
    hil_event_set_cycle(dev->core, HIL_EVENT_CAN, HIL_NEVER);
    update_irq(dev);
}

/* --- registers (RM0090 32.9) --- */

static bool is_mailbox_offset(uint32_t offset)
{
    return offset >= MAILBOXES && offset < FIFOS;
}

static uint32_t *get_mailbox_register(struct hil_can *c, uint32_t offset)
{
    return &c->mailbox[(offset - MAILBOXES) / 16u].word[offset / 4u % 4u];
}

static uint32_t *get_filter_register(struct hil_can *c, uint32_t offset)
{
    return offset < FILTER_BANKS ? &c->filter_word[(offset - FMR) / 4u]
                                 : &c->filter[(offset - FILTER_BANKS) / 8u][offset / 4u % 2u];
}

uint32_t hil_can_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_can_device *dev = device;
    struct hil_can *c = dev->state;
    bool in_frame = c->phase == HIL_CAN_FRAME;
    (void)unit;
    if (is_mailbox_offset(offset))
        return *get_mailbox_register(c, offset);
    if (offset >= FMR)
        return *get_filter_register(c, offset);
    if (offset >= FIFOS)
        return c->fifo[(offset - FIFOS) / 16u][0].word[offset / 4u % 4u];
    switch (offset) {
    case MSR: /* RX and SAMP show the level of the pin, which is recessive between frames */
        return c->msr | 0xc00u |
               (uint32_t)(in_frame && c->sender != HIL_CAN_SENDER_OTHER_NODE) << 8 |
               (uint32_t)(in_frame && c->sender == HIL_CAN_SENDER_OTHER_NODE) << 9;
    case TSR: return get_tsr(c);
    case RF0R:
    case RF1R: return c->word[offset / 4u] | c->fifo_count[(offset - RF0R) / 4u];
    case ESR: return get_esr(c);
    default: return c->word[offset / 4u];
    }
}

/* Stops the run if the firmware writes back flags that it read. A flag is cleared by writing 1, so
 * this could clear flags that were set in between. */
static void check_write_of_read_flags(struct hil_can_device *dev, uint32_t status)
{
    if (status)
        hil_bus_refuse(
            dev->core,
            "the value that was read is written back, which clears all flags that are set");
}

static void write_tsr(struct hil_can_device *dev, uint32_t value)
{
    struct hil_can *c = dev->state;
    check_write_of_read_flags(dev, value & TSR_STATUS);
    for (unsigned m = 0; m < 3; m++) {
        uint32_t bits = value >> (8u * m);
        if (bits & 1u) /* RQCP also clears TXOK, ALST and TERR */
            c->tsr &= ~(0xfu << (8u * m));
        if ((bits & 0x80u) && !is_mailbox_empty(c, m)) { /* ABRQ */
            bool begun = c->phase == HIL_CAN_FRAME;
            if (begun && c->sender == (int)m)
                c->is_abort_requested = true;
            else
                end_mailbox(dev, m, 0);
        }
    }
}

static void release_fifo(struct hil_can *c, unsigned f, uint32_t value)
{
    c->rfr[f] &= ~(value & (RFR_FULL | RFR_FOVR));
    if ((value & RFR_RFOM) && c->fifo_count[f]) {
        c->fifo_count[f]--;
        c->rfr[f] &= ~RFR_FULL;
        c->fifo[f][0] = c->fifo[f][1];
        c->fifo[f][1] = c->fifo[f][2];
    }
}

static void write_mailbox(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    unsigned m = (offset - MAILBOXES) / 16u;
    if (!is_mailbox_empty(c, m)) {
        hil_trace(dev->core, "CAN mailbox %u is pending, so the chip ignores the write", m);
        return;
    }
    *get_mailbox_register(c, offset) = value;
    if (offset % 16u == 0 && (value & TIR_TXRQ)) {
        c->mailbox[m].request_number = c->request_count++;
        dev->core->state.counters.can_mailboxes_refilled += c->tsr >> (8u * m) & 1u;
        c->tsr &= ~(0xfu << (8u * m));
        try_start_frame(dev, hil_now_cycle(dev->core));
    }
}

static void write_filter(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    bool initialising = (c->fmr & 1u) != 0;
    if (offset > FMR && offset < FA1R && !initialising)
        hil_bus_refuse(dev->core, "filter mode, scale or FIFO is written outside filter "
                                  "initialisation: the chip ignores the write");
    if (offset >= FILTER_BANKS && !initialising && (c->fa1r >> (offset - FILTER_BANKS) / 8u & 1u))
        hil_bus_refuse(dev->core,
                       "the bank of an active filter is written: the chip ignores the write");
    if (offset == FA1R && (value & ~c->fs1r))
        hil_bus_refuse(dev->core, "a 16-bit filter");
    *get_filter_register(c, offset) = value;
}

static void write_control_register(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    switch (offset) {
    case MCR:
        c->mcr = value;
        update_mode(dev, hil_now_cycle(dev->core));
        break;
    case MSR: /* nothing to clear: ERRI, WKUI and SLAKI are never set */ break;
    case TSR: write_tsr(dev, value); break;
    case RF0R:
    case RF1R:
        check_write_of_read_flags(dev, value & RFR_FMP);
        release_fifo(c, (offset - RF0R) / 4u, value);
        break;
    case ESR: /* software may write LEC to detect a later change */ c->esr = value & 0x70u; break;
    default:
        if (offset == BTR && !(c->msr & MSR_INAK))
            hil_bus_refuse(dev->core,
                           "BTR is written outside initialisation: the chip ignores the write");
        c->word[offset / 4u] = value;
        break;
    }
}

void hil_can_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_can_device *dev = device;
    (void)unit;
    if (offset == MCR && (value & MCR_RESET)) {
        hil_can_reset(dev, 0);
        return;
    }
    if (is_mailbox_offset(offset))
        write_mailbox(dev, offset, value);
    else if (offset >= FMR)
        write_filter(dev, offset, value);
    else
        write_control_register(dev, offset, value);
    update_irq(dev);
}
