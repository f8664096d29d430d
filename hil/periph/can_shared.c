/* bxCAN on a bus that several boards share: what the bus asks of it and tells it. */
#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/periph/can.h"

#define MCR_NART 16u
#define BTR_LBKM (1u << 30)
#define BTR_SILM (1u << 31)

void hil_can_ask(struct hil_can_device *dev, unsigned m, uint64_t at)
{
    struct hil_can *c = dev->state;
    c->phase = HIL_CAN_ASKING;
    c->sender = (int8_t)m;
    c->asked_cycle = at;
    c->abort_current = false;
}

bool hil_can_asks(const struct hil_can_device *dev, uint64_t *since_ps, struct hil_can_frame *frame)
{
    const struct hil_can *c = dev->state;
    if (c->phase != HIL_CAN_ASKING)
        return false;
    *since_ps = hil_clock_ps(&dev->core->state.clock, c->asked_cycle);
    hil_can_mailbox_frame(&c->mailbox[c->sender], frame);
    return true;
}

bool hil_can_hears(const struct hil_can_device *dev)
{
    const struct hil_can *c = dev->state;
    return c->phase == HIL_CAN_ASKING ||
           (hil_can_on_bus(c) && c->phase != HIL_CAN_FRAME && !(c->btr & BTR_LBKM) &&
            hil_can_bus_seen(dev) == HIL_CAN_CONNECTED);
}

bool hil_can_acknowledges(const struct hil_can_device *dev)
{
    return hil_can_hears(dev) && !(dev->state->btr & BTR_SILM);
}

uint64_t hil_can_begin(struct hil_can_device *dev, uint64_t start_ps, unsigned bits, bool spoiled)
{
    struct hil_can *c = dev->state;
    const struct hil_clock *clock = &dev->core->state.clock;
    uint64_t end = hil_clock_cycle(clock, start_ps) + bits * hil_can_bit_cycles(dev);
    c->phase = HIL_CAN_FRAME;
    c->spoiled = spoiled;
    c->on_shared = true;
    hil_event_set_cycle(dev->core, HIL_EVENT_CAN, end);
    return hil_clock_ps(clock, end);
}

void hil_can_collide(struct hil_can_device *dev, uint64_t end_ps)
{
    struct hil_can *c = dev->state;
    c->phase = HIL_CAN_FRAME;
    c->spoiled = c->on_shared = true;
    hil_event_set_ps(dev->core, HIL_EVENT_CAN, end_ps);
}

void hil_can_listen(struct hil_can_device *dev, const struct hil_can_frame *frame, uint64_t end_ps,
                    bool spoiled, bool lost)
{
    struct hil_can *c = dev->state;
    if (c->phase == HIL_CAN_ASKING) {
        unsigned m = (unsigned)c->sender;
        uint32_t flags = lost ? 4u : 0u;
        if (c->abort_current || (lost && (c->mcr & MCR_NART)))
            hil_can_mailbox_done(dev, m, flags);
        else
            c->tsr |= flags << (8u * m);
    }
    c->phase = HIL_CAN_FRAME;
    c->sender = HIL_CAN_OTHER_NODE;
    c->spoiled = spoiled;
    c->on_shared = true;
    c->abort_current = c->repeated = false;
    c->queue[0] = *frame;
    c->queue_head = 0;
    c->queue_count = 1;
    hil_event_set_ps(dev->core, HIL_EVENT_CAN, end_ps);
    hil_can_update_irq(dev);
}

void hil_can_listen_cut(struct hil_can_device *dev, uint64_t end_ps)
{
    struct hil_can *c = dev->state;
    if (c->phase != HIL_CAN_FRAME || !c->on_shared || c->sender != HIL_CAN_OTHER_NODE)
        return;
    c->spoiled = true;
    hil_event_set_ps(dev->core, HIL_EVENT_CAN, end_ps);
}
