/* Registers of bxCAN (RM0090 32.9). */
#include "hil/core/core.h"
#include "hil/core/access.h"
#include "hil/periph/can.h"

#define MCR       0x000u
#define MSR       0x004u
#define TSR       0x008u
#define RF0R      0x00cu
#define RF1R      0x010u
#define ESR       0x018u
#define BTR       0x01cu
#define MAILBOXES 0x180u
#define FIFOS     0x1b0u
#define FMR       0x200u
#define FA1R      0x21cu
#define BANKS     0x240u
#define MCR_RESET 0x8000u
#define MSR_INAK  1u
#define TIR_TXRQ  1u
#define RFR_FULL  8u
#define RFR_FOVR  16u
#define RFR_RFOM  32u

static bool is_mailbox(uint32_t offset)
{
    return offset >= MAILBOXES && offset < FIFOS;
}

static uint32_t *mailbox_register(struct hil_can *c, uint32_t offset)
{
    return &c->mailbox[(offset - MAILBOXES) / 16u].word[offset / 4u % 4u];
}

static uint32_t *filter_register(struct hil_can *c, uint32_t offset)
{
    return offset < BANKS ? &c->filter_word[(offset - FMR) / 4u]
                          : &c->filter[(offset - BANKS) / 8u][offset / 4u % 2u];
}

uint32_t hil_can_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_can_device *dev = device;
    struct hil_can *c = dev->state;
    bool in_frame = c->phase == HIL_CAN_FRAME;
    (void)unit;
    if (is_mailbox(offset))
        return *mailbox_register(c, offset);
    if (offset >= FMR)
        return *filter_register(c, offset);
    if (offset >= FIFOS)
        return c->fifo[(offset - FIFOS) / 16u][0].word[offset / 4u % 4u];
    switch (offset) {
    case MSR: /* RX and SAMP: the pin, recessive between frames */
        return c->msr | 0xc00u | (uint32_t)(in_frame && c->sender != HIL_CAN_OTHER_NODE) << 8 |
               (uint32_t)(in_frame && c->sender == HIL_CAN_OTHER_NODE) << 9;
    case TSR: return hil_can_tsr(c);
    case RF0R:
    case RF1R: return c->word[offset / 4u] | c->fifo_count[(offset - RF0R) / 4u];
    case ESR: return hil_can_esr(c);
    default: return c->word[offset / 4u];
    }
}

static void tsr_write(struct hil_can_device *dev, uint32_t value)
{
    struct hil_can *c = dev->state;
    for (unsigned m = 0; m < 3; m++) {
        uint32_t bits = value >> (8u * m);
        if (bits & 1u) /* RQCP clears its companions too */
            c->tsr &= ~(0xfu << (8u * m));
        if ((bits & 0x80u) && !hil_can_mailbox_empty(c, m)) { /* ABRQ */
            bool begun = c->phase == HIL_CAN_FRAME;
            if (begun && c->sender == (int)m)
                c->abort_current = true;
            else
                hil_can_mailbox_done(dev, m, 0);
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

static void mailbox_write(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    unsigned m = (offset - MAILBOXES) / 16u;
    if (!hil_can_mailbox_empty(c, m)) {
        hil_trace(dev->core, "CAN mailbox %u is pending: write ignored", m);
        return;
    }
    *mailbox_register(c, offset) = value;
    if (offset % 16u == 0 && (value & TIR_TXRQ)) {
        c->mailbox[m].order = c->orders++;
        dev->core->state.counters.can_ends_unseen += c->tsr >> (8u * m) & 1u;
        c->tsr &= ~(0xfu << (8u * m));
        hil_can_try_start(dev, hil_now(dev->core));
    }
}

static void filter_write(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    bool initialising = (c->fmr & 1u) != 0;
    if (offset > FMR && offset < FA1R && !initialising)
        hil_bus_refuse(
            dev->core,
            "filter mode, scale or FIFO outside filter initialisation: silicon ignores it");
    if (offset >= BANKS && !initialising && (c->fa1r >> (offset - BANKS) / 8u & 1u))
        hil_bus_refuse(dev->core, "the bank of an active filter: silicon ignores it");
    if (offset == FA1R && (value & ~c->fs1r))
        hil_bus_refuse(dev->core, "a filter of 16 bits");
    *filter_register(c, offset) = value;
}

static void control_write(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    switch (offset) {
    case MCR:
        c->mcr = value;
        hil_can_update_mode(dev, hil_now(dev->core));
        break;
    case MSR: /* ERRI, WKUI, SLAKI are cleared by writing 1 */ c->msr &= ~(value & 0x1cu); break;
    case TSR: tsr_write(dev, value); break;
    case RF0R:
    case RF1R: release_fifo(c, (offset - RF0R) / 4u, value); break;
    case ESR: /* LEC can be set by software, to see it change */ c->esr = value & 0x70u; break;
    default:
        if (offset == BTR && !(c->msr & MSR_INAK))
            hil_bus_refuse(dev->core, "BTR outside initialisation: silicon ignores it");
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
    if (is_mailbox(offset))
        mailbox_write(dev, offset, value);
    else if (offset >= FMR)
        filter_write(dev, offset, value);
    else
        control_write(dev, offset, value);
    hil_can_update_irq(dev);
}
