/* Registers of bxCAN (RM0090 32.9). */
#include "hil/core/core.h"
#include "hil/core/refuse.h"
#include "hil/periph/can.h"

#define MCR_TTCM 128u
#define MCR_RESET 0x8000u
#define MSR_INAK 1u
#define TIR_TXRQ 1u
#define RFR_FULL 8u
#define RFR_FOVR 16u
#define RFR_RFOM 32u
#define OTHER_NODE 3

static uint32_t receive_read(struct hil_can_device *dev, uint32_t offset)
{
    const struct hil_can *c = dev->state;
    const struct hil_can_received *r = &c->fifo[(offset - 0x1b0u) / 16u][0];
    switch (offset & 0xcu) {
    case 0x0:
        return r->rir;
    case 0x4:
        return r->rdtr;
    case 0x8:
        return r->rdlr;
    default:
        return r->rdhr;
    }
}

static uint32_t *mailbox_register(struct hil_can *c, uint32_t offset)
{
    struct hil_can_mailbox *m = &c->mailbox[(offset - 0x180u) / 16u];
    switch (offset & 0xcu) {
    case 0x0:
        return &m->tir;
    case 0x4:
        return &m->tdtr;
    case 0x8:
        return &m->tdlr;
    default:
        return &m->tdhr;
    }
}

uint32_t hil_can_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_can_device *dev = device;
    struct hil_can *c = dev->state;
    (void)unit;
    if (offset >= 0x180 && offset < 0x1b0)
        return *mailbox_register(c, offset);
    if (offset >= 0x1b0 && offset < 0x1d0)
        return receive_read(dev, offset);
    if (offset >= 0x240 && offset < 0x240 + 8 * HIL_CAN_BANKS)
        return c->filter[(offset - 0x240u) / 8u][offset >> 2 & 1u];
    switch (offset) {
    case 0x000:
        return c->mcr;
    case 0x004: /* RX and SAMP: the pin, recessive between frames */
        return c->msr | 0xc00u | (uint32_t)(c->phase == HIL_CAN_FRAME && c->sender != OTHER_NODE) << 8
               | (uint32_t)(c->phase == HIL_CAN_FRAME && c->sender == OTHER_NODE) << 9;
    case 0x008:
        return hil_can_tsr(c);
    case 0x00c: case 0x010:
        return c->rfr[(offset - 0xcu) / 4u] | c->fifo_count[(offset - 0xcu) / 4u];
    case 0x014:
        return c->ier;
    case 0x018:
        return hil_can_esr(c);
    case 0x01c:
        return c->btr;
    case 0x200:
        return c->fmr;
    case 0x204:
        return c->fm1r;
    case 0x20c:
        return c->fs1r;
    case 0x214:
        return c->ffa1r;
    case 0x21c:
        return c->fa1r;
    default:
        return hil_bus_no_register(dev->core);
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
            if (c->phase == HIL_CAN_FRAME && c->sender == (int)m)
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
    unsigned m = (offset - 0x180u) / 16u;
    if (!hil_can_mailbox_empty(c, m)) {
        hil_trace(dev->core, "CAN mailbox %u is pending: write ignored", m);
        return;
    }
    *mailbox_register(c, offset) = value;
    if ((offset & 0xcu) == 0 && (value & TIR_TXRQ)) {
        c->mailbox[m].order = c->orders++;
        c->tsr &= ~(0xfu << (8u * m));
        hil_can_try_start(dev, hil_now(dev->core));
    }
}

static void filter_write(struct hil_can_device *dev, uint32_t offset, uint32_t value)
{
    struct hil_can *c = dev->state;
    bool initialising = (c->fmr & 1u) != 0;
    unsigned bank = (offset - 0x240u) / 8u;
    switch (offset) {
    case 0x200:
        c->fmr = (c->fmr & ~0x3f01u) | (value & 0x3f01u);
        return;
    case 0x21c:
        c->fa1r = value & 0x0fffffffu;
        return;
    case 0x204: case 0x20c: case 0x214:
        if (!initialising)
            hil_bus_refuse(dev->core,
                           "filter mode, scale or FIFO outside filter initialisation: silicon ignores it");
        *(offset == 0x204 ? &c->fm1r : offset == 0x20c ? &c->fs1r : &c->ffa1r) = value & 0x0fffffffu;
        return;
    default:
        break;
    }
    if (offset < 0x240 || bank >= HIL_CAN_BANKS) {
        hil_bus_no_register(dev->core);
        return;
    }
    if (!initialising && (c->fa1r >> bank & 1u))
        hil_bus_refuse(dev->core, "the bank of an active filter: silicon ignores it");
    c->filter[bank][offset >> 2 & 1u] = value;
}

void hil_can_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_can_device *dev = device;
    struct hil_can *c = dev->state;
    (void)unit;
    if (offset >= 0x180 && offset < 0x1b0) {
        mailbox_write(dev, offset, value);
    } else if (offset >= 0x200) {
        filter_write(dev, offset, value);
    } else {
        switch (offset) {
        case 0x000:
            if (value & MCR_RESET) {
                hil_can_reset(dev, 0);
                return;
            }
            if (value & (MCR_TTCM | 32u))
                hil_bus_refuse(dev->core, "time-triggered mode, automatic wake-up");
            c->mcr = value & 0x100ffu;
            hil_can_update_mode(dev, hil_now(dev->core));
            break;
        case 0x004: /* ERRI, WKUI, SLAKI are cleared by writing 1 */
            c->msr &= ~(value & 0x1cu);
            break;
        case 0x008:
            tsr_write(dev, value);
            break;
        case 0x00c: case 0x010:
            release_fifo(c, (offset - 0xcu) / 4u, value);
            break;
        case 0x014:
            c->ier = value & 0x38f7fu;
            break;
        case 0x018: /* LEC can be set by software, to see it change */
            c->esr = value & 0x70u;
            break;
        case 0x01c:
            if (!(c->msr & MSR_INAK))
                hil_bus_refuse(dev->core, "BTR outside initialisation: silicon ignores it");
            c->btr = value & 0xc37f03ffu;
            break;
        default:
            hil_bus_no_register(dev->core);
            return;
        }
    }
    hil_can_update_irq(dev);
}
