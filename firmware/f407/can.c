/* CAN1 at 1 Mbit/s: 42 MHz / 3 = 14 quanta a bit, sample point after 12 (85.7 %). RM0090 32.7
 * (modes, bit timing), 32.9.
 *
 * Frames are sent in queue order (TXFP), so the count in can_health is exactly the number of frames
 * before it. Software ends bus-off when firmware/canwatch.c requests it: automatic recovery (ABOM)
 * would disturb a shorted bus 400 times a second.
 *
 * Identifiers include the base (common/canbase.h) in the send queue and the controller; everywhere
 * else they are those of the catalogue. */
#include "firmware/f407/drivers.h"
#include "firmware/f407/queue.h"
#include "firmware/health.h"
#include "common/canbase.h"

#define TX_QUEUE_FRAMES 256u
#define RX_QUEUE_FRAMES 64u
#define ALL_EMPTY       (CAN_TSR_TME(0) | CAN_TSR_TME(1) | CAN_TSR_TME(2))
#define INIT_POLLS      100000u
/* mark in the identifier of a sync frame while it is in the queue */
#define SYNC_MARK       0x8000u
#define BIT_TIMING      (1u << 20 | 10u << 16 | 2u) /* TS2 2, TS1 11, prescaler 3, SJW 1 */

static struct board_can_frame tx_ring[TX_QUEUE_FRAMES], rx_ring[RX_QUEUE_FRAMES];
static struct queue tx_queue, rx_queue;
static bool is_running;
static volatile uint16_t can_base; /* base of the identifiers on the bus */
/* Number of frames that have left their mailboxes, and of frames that mailboxes aborted on
 * request. */
static volatile uint32_t sent_frames, aborted_frames;
static uint32_t cleared_frames; /* number of waiting frames that were dropped */

/* The sync frame: its block, its mailbox (3: none), and the tick when it was sent. */
static volatile uint32_t sync_block, sync_tick;
static volatile unsigned sync_mailbox = 3;
static volatile bool has_sync_frame_left;

static bool wait_init_ack(void)
{
    for (unsigned polls = 0; polls < INIT_POLLS; polls++) {
        if (CAN1->MSR & CAN_MSR_INAK)
            return true;
    }
    return false;
}

void can_start(void)
{
    CAN1->MCR = CAN_MCR_INRQ | CAN_MCR_TXFP; /* clears SLEEP */
    if (!wait_init_ack()) {
        health_count_fault(MR_FAULT_CAN_MISSING, 0);
        return;
    }
    CAN1->BTR = BIT_TIMING;
    CAN1->FMR |= CAN_FMR_FINIT; /* filters stay off until board_can_set_base sets the identifiers */
    CAN1->FM1R = 3u;            /* banks 0 and 1: identifier lists */
    CAN1->FS1R = 3u;            /* filters of 32 bits */
    CAN1->FFA1R = 0;            /* accepted frames go to FIFO 0 */
    CAN1->IER = CAN_IER_TMEIE | CAN_IER_FMPIE0;
    irq_enable(IRQ_CAN1_TX, PRIORITY_CAN);
    irq_enable(IRQ_CAN1_RX0, PRIORITY_CAN);
    is_running = true;
}

/* Changes the filters, with FINIT set. Reception stops for less than a microsecond; a frame that
 * ends in this time is lost. Earlier frames have already been read from the FIFO by the interrupt,
 * with the old base. RM0090 32.7.4. Filters survive bus-off and recovery. */
void board_can_set_base(uint16_t to)
{
    if (!is_running)
        return;
    CAN1->FMR |= CAN_FMR_FINIT;
    CAN1->filter[0][0] = (uint32_t)mr_can_id_to_bus(MR_ID_COMMAND, to) << 21;
    CAN1->filter[0][1] = (uint32_t)mr_can_id_to_bus(MR_ID_CONFIG_WORD, to) << 21;
    CAN1->filter[1][0] = CAN1->filter[1][1] = (uint32_t)mr_can_id_to_bus(MR_ID_PROOF, to) << 21;
    CAN1->FA1R = 3u;
    can_base = to;
    CAN1->FMR &= ~CAN_FMR_FINIT;
    /* Leave init mode. After that, the controller joins the bus after 11 recessive bits and holds
     * frames until then. Do not wait for it, because the bus may be shorted now and repaired
     * later. */
    CAN1->MCR = CAN_MCR_TXFP;
}

static uint32_t get_data_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* Returns the mailboxes that may be filled. A mailbox that has sent its frame but whose interrupt
 * has not run yet is excluded: a new request would clear RQCP and lose the time of the frame
 * (RM0090 32.9.3). */
static uint32_t find_free_mailboxes(void)
{
    uint32_t tsr = CAN1->TSR, empty = tsr >> 26 & 7u;
    for (unsigned mailbox = 0; mailbox < 3; mailbox++) {
        if (tsr & CAN_TSR_RQCP(mailbox))
            empty &= ~(1u << mailbox);
    }
    return empty;
}

/* Fills free mailboxes from the queue. Call with interrupts masked, or from the CAN interrupt. */
static void fill_mailboxes(void)
{
    while (queue_filled(&tx_queue)) {
        uint32_t empty = find_free_mailboxes();
        if (!empty)
            return;
        unsigned mailbox = (unsigned)__builtin_ctz(empty);
        const struct board_can_frame *frame = &tx_ring[tx_queue.removed % TX_QUEUE_FRAMES];
        CAN1->tx[mailbox].TDTR = frame->length;
        CAN1->tx[mailbox].TDLR = get_data_word(frame->data);
        CAN1->tx[mailbox].TDHR = get_data_word(frame->data + 4);
        if (frame->id & SYNC_MARK) {
            sync_block = get_data_word(frame->data);
            sync_mailbox = mailbox;
            has_sync_frame_left = false;
        }
        CAN1->tx[mailbox].TIR = (frame->id & MR_CAN_ID_MAX) << 21 | CAN_TIR_TXRQ;
        queue_remove(&tx_queue, 1);
    }
}

void can1_tx_irq(void);
void can1_tx_irq(void)
{
    uint32_t now = TIM2->CNT;
    uint32_t tsr = CAN1->TSR;
    /* Clear only the flags that were read: a mailbox that finishes in the meantime causes the next
     * interrupt, with its own time. */
    for (unsigned mailbox = 0; mailbox < 3; mailbox++) {
        bool left = (tsr & CAN_TSR_TXOK(mailbox)) != 0;
        if (!(tsr & CAN_TSR_RQCP(mailbox)))
            continue;
        CAN1->TSR = CAN_TSR_RQCP(mailbox);
        if (left)
            sent_frames++;
        else
            aborted_frames++;
        if (sync_mailbox == mailbox) {
            has_sync_frame_left = left;
            sync_tick = now;
            sync_mailbox = 3;
        }
    }
    fill_mailboxes();
    irq_end();
}

void can1_rx0_irq(void);
void can1_rx0_irq(void)
{
    if (CAN1->RF0R & CAN_RF0R_FOVR) {
        CAN1->RF0R = CAN_RF0R_FOVR;
        health_count_fault(MR_FAULT_CAN_RX_OVERRUN, 0);
    }
    /* At most three frames are stored; the limit prevents a stuck count from blocking the
     * processor. While a frame is being released, the count is still the old one; frames that
     * remain cause the next interrupt. */
    for (unsigned n = 0; n < 3; n++) {
        uint32_t fifo = CAN1->RF0R;
        if (!(fifo & CAN_RF0R_FMP) || fifo & CAN_RF0R_RFOM)
            break;
        if (queue_filled(&rx_queue) < RX_QUEUE_FRAMES) {
            struct board_can_frame *frame = &rx_ring[rx_queue.added % RX_QUEUE_FRAMES];
            uint32_t low = CAN1->rx[0].RDLR, high = CAN1->rx[0].RDHR;
            frame->id = mr_can_id_from_bus((uint16_t)(CAN1->rx[0].RIR >> 21), can_base);
            frame->length = (uint8_t)(CAN1->rx[0].RDTR & 15u);
            if (frame->length > 8)
                frame->length = 8;
            for (unsigned i = 0; i < 4; i++) {
                frame->data[i] = (uint8_t)(low >> (8 * i));
                frame->data[4 + i] = (uint8_t)(high >> (8 * i));
            }
            queue_add(&rx_queue, 1);
        } else {
            health_count_fault(MR_FAULT_CAN_RX_OVERRUN, 1);
        }
        CAN1->RF0R = CAN_RF0R_RFOM;
    }
    irq_end();
}

bool board_can_send(const struct board_can_frame *frame)
{
    if (!is_running || queue_filled(&tx_queue) == TX_QUEUE_FRAMES)
        return false;
    struct board_can_frame *queued = &tx_ring[tx_queue.added % TX_QUEUE_FRAMES];
    *queued = *frame;
    queued->id = mr_can_id_to_bus(frame->id, can_base);
    if (frame->id == MR_ID_SYNC)
        queued->id |= SYNC_MARK;
    uint32_t mask = irq_mask();
    queue_add(&tx_queue, 1);
    fill_mailboxes();
    irq_restore(mask);
    return true;
}

unsigned board_can_waiting(void)
{
    return queue_filled(&tx_queue);
}

bool board_can_receive(struct board_can_frame *frame)
{
    if (!queue_filled(&rx_queue))
        return false;
    *frame = rx_ring[rx_queue.removed % RX_QUEUE_FRAMES];
    queue_remove(&rx_queue, 1);
    return true;
}

bool board_can_sync_tick(uint32_t block, uint32_t *tick)
{
    uint32_t mask = irq_mask();
    bool left = has_sync_frame_left && sync_block == block;
    *tick = sync_tick;
    irq_restore(mask);
    return left;
}

void board_can_clear(void)
{
    if (!is_running)
        return;
    uint32_t mask = irq_mask();
    cleared_frames += queue_filled(&tx_queue);
    queue_remove(&tx_queue, queue_filled(&tx_queue));
    CAN1->TSR = CAN_TSR_ABRQ(0) | CAN_TSR_ABRQ(1) | CAN_TSR_ABRQ(2);
    irq_restore(mask);
}

void board_can_leave_bus_off(bool begin)
{
    if (is_running)
        CAN1->MCR = CAN_MCR_TXFP | (begin ? CAN_MCR_INRQ : 0);
}

void board_can_get_errors(struct board_can_errors *errors)
{
    uint32_t esr = is_running ? CAN1->ESR : 0;
    errors->is_missing = !is_running;
    errors->last_error = (uint8_t)(esr >> 4 & 7u);
    errors->is_pending = is_running && (queue_filled(&tx_queue) || (~CAN1->TSR & ALL_EMPTY) != 0);
    errors->sent_count = sent_frames;
    errors->removed_count = cleared_frames + aborted_frames;
    errors->tec = (uint8_t)(esr >> 16);
    errors->rec = (uint8_t)(esr >> 24);
    errors->is_passive = (esr & CAN_ESR_EPVF) != 0;
    errors->is_bus_off = (esr & CAN_ESR_BOFF) != 0;
}
