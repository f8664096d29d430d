#include "hil/periph/usart.h"

#include <string.h>

#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/periph/options.h"
#include "hil/periph/dma.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"

#define SR                 0x00u
#define DR                 0x04u
#define CR1                0x0cu
#define SR_PE              1u
#define SR_FE              2u
#define SR_NF              4u
#define SR_ORE             8u
#define SR_IDLE            16u
#define SR_RXNE            32u
#define SR_TC              64u
#define SR_TXE             128u
#define CR1_RE             4u
#define CR1_TE             8u
#define CR1_UE             (1u << 13)
#define CR1_OVER8          (1u << 15)
#define CR1_PEIE           (1u << 8)
#define CR1_PS             (1u << 9)
#define CR1_PCE            (1u << 10)
#define CR1_M              (1u << 12)
#define CR3_EIE            1u
#define CR3_DMAR           64u
#define CR3_ONEBIT         0x800u
#define CR3_DMAT           128u
#define GARBLED_BYTE_VALUE 0u /* received byte if the settings of the two ends differ */

/* USART1 and USART6: RM0090 table 1 (addresses), 43 (requests), 61 (interrupts). */
static const struct unit_numbers {
    uint32_t data_register;
    enum hil_irq irq;
    uint8_t dma_channel;    /* channel of DMA2's streams */
    uint8_t receive_stream; /* stream of DMA2 that receives; stream 2 is the other possible one */
} usart1 = {0x40011004u, HIL_IRQ_USART1, 4, 5}, usart6 = {0x40011404u, HIL_IRQ_USART6, 5, 1};

static const struct unit_numbers *get_unit_numbers(const struct hil_usart_device *dev)
{
    return dev->options->type->usart == 6 ? &usart6 : &usart1;
}

static struct hil_dma_request get_send_request(const struct hil_usart_device *dev)
{
    const struct unit_numbers *own = get_unit_numbers(dev);
    return (struct hil_dma_request){1, 7, own->dma_channel, own->data_register, true};
}

static struct hil_dma_request get_receive_request(const struct hil_usart_device *dev)
{
    const struct unit_numbers *own = get_unit_numbers(dev);
    uint32_t cr = dev->dma->state[1].stream[own->receive_stream].cr;
    unsigned stream = (cr & 1u) && (cr >> 25 & 7u) == own->dma_channel ? own->receive_stream : 2;
    return (struct hil_dma_request){1, stream, own->dma_channel, own->data_register, false};
}

static bool is_pin_connected(const struct hil_usart_device *dev, struct hil_pin_location place)
{
    return hil_gpio_alternate_function(dev->gpio, place.port, place.pin) ==
           dev->options->type->serial_alternate_function;
}

/* HCLK cycles of one bit; 0 if no rate is set. */
static uint64_t get_bit_cycles(const struct hil_usart_device *dev)
{
    const struct hil_usart *u = dev->state;
    uint32_t clocks = (u->cr1 & CR1_OVER8) ? (u->brr >> 4) * 8u + (u->brr & 7u) : u->brr;
    return (uint64_t)clocks * hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB2);
}

static enum hil_parity get_parity(const struct hil_usart *u)
{
    return !(u->cr1 & CR1_PCE) ? HIL_PARITY_NONE
         : (u->cr1 & CR1_PS)   ? HIL_PARITY_ODD
                               : HIL_PARITY_EVEN;
}

static enum hil_parity get_host_parity(const struct hil_usart_device *dev)
{
    return dev->options->host_parity_follows_board ? get_parity(dev->state)
                                                   : dev->options->host_parity;
}

static unsigned get_bits_per_frame(enum hil_parity parity)
{
    return parity == HIL_PARITY_NONE ? 10u : 11u;
}

/* Returns the levels of a byte's frame in order of transmission, the first in bit 0: start, data,
 * parity, stop. */
static uint32_t get_frame_levels(uint8_t byte, enum hil_parity parity)
{
    uint32_t bits = (uint32_t)byte << 1;
    bool odd_ones = (__builtin_popcount(byte) & 1) != 0;
    if (parity == HIL_PARITY_NONE)
        return bits | 1u << 9;
    return bits | (uint32_t)(odd_ones != (parity == HIL_PARITY_ODD)) << 9 | 1u << 10;
}

static uint64_t get_sent_frame_bits(const struct hil_usart_device *dev)
{
    return get_bits_per_frame(get_parity(dev->state));
}

/* True if the settings of the other end match the programmed ones: the same parity, and a rate
 * within 2 %. (A receiver tolerates 3.3 %, RM0090 table 142, including the other end's error and
 * that of its divider.) */
static bool do_settings_match(const struct hil_usart_device *dev)
{
    uint64_t bit = get_bit_cycles(dev);
    if (!bit)
        return false;
    double rate = (double)dev->core->state.clock.hclk_hz / (double)bit;
    double ratio = rate / dev->options->host_baud;
    return ratio > 0.98 && ratio < 1.02 && get_host_parity(dev) == get_parity(dev->state);
}

static bool is_sending(const struct hil_usart *u)
{
    return (u->cr1 & (CR1_UE | CR1_TE)) == (CR1_UE | CR1_TE) && u->brr;
}

static uint32_t get_status_flags(const struct hil_usart *u)
{
    return u->sr | (u->is_dr_full ? 0 : SR_TXE);
}

static void update_irq(struct hil_usart_device *dev)
{
    const struct hil_usart *u = dev->state;
    uint32_t sr = get_status_flags(u);
    /* TXEIE, TCIE, RXNEIE, IDLEIE have the bit positions of their flags. */
    uint32_t line = sr & u->cr1 & (SR_TXE | SR_TC | SR_RXNE | SR_IDLE);
    line |= (u->cr1 & SR_RXNE) ? sr & SR_ORE : 0;
    line |= (u->cr1 & CR1_PEIE) ? sr & SR_PE : 0;
    line |= (u->cr3 & CR3_EIE) && (u->cr3 & CR3_DMAR) ? sr & (SR_ORE | SR_FE | SR_NF) : 0;
    hil_irq_set_line(dev->core, get_unit_numbers(dev)->irq, (u->cr1 & CR1_UE) && line != 0);
}

static void pass_sent_bytes(struct hil_usart_device *dev, uint64_t at)
{
    struct hil_usart *u = dev->state;
    if (!u->output_count)
        return;
    bool connected = is_pin_connected(dev, dev->options->type->serial_out_pin);
    uint64_t at_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (connected && do_settings_match(dev)) {
        dev->core->state.counters.serial_bytes_out += u->output_count;
        dev->line_calls.serial_out(dev->line_calls.context, at_ps, u->output, u->output_count);
    } else {
        dev->core->state.counters.serial_bytes_garbled += u->output_count;
        memset(u->output, GARBLED_BYTE_VALUE, u->output_count);
        if (connected)
            dev->line_calls.serial_out(dev->line_calls.context, at_ps, u->output, u->output_count);
    }
    u->output_count = 0;
}

/* Fills DR from DMA if enabled. */
static void fill_dr(struct hil_usart_device *dev)
{
    struct hil_usart *u = dev->state;
    struct hil_dma_request request = get_send_request(dev);
    if (!u->is_dr_full && (u->cr3 & CR3_DMAT) && hil_dma_items_until_flag(dev->dma, &request))
        u->is_dr_full = hil_dma_read_items(dev->dma, &request, &u->buffered_byte, 1);
}

/* Moves DR to the shift register at cycle `at` if the shift register is free. */
static void shift_byte(struct hil_usart_device *dev, uint64_t at)
{
    struct hil_usart *u = dev->state;
    if (u->is_shifting || !u->is_dr_full)
        return;
    u->shifted_byte = u->buffered_byte;
    u->is_dr_full = false;
    u->is_shifting = true;
    u->shift_end_cycle = at + get_sent_frame_bits(dev) * get_bit_cycles(dev);
}

static void begin_byte(struct hil_usart_device *dev, uint64_t at)
{
    if (!is_sending(dev->state))
        return;
    fill_dr(dev);
    shift_byte(dev, at);
    fill_dr(dev);
}

static void schedule_send_end(struct hil_usart_device *dev)
{
    const struct hil_usart *u = dev->state;
    uint64_t next = HIL_NEVER;
    if (u->is_shifting) {
        uint32_t n = 0;
        struct hil_dma_request request = get_send_request(dev);
        if (u->is_dr_full && (u->cr3 & CR3_DMAT))
            n = hil_dma_items_until_flag(dev->dma, &request);
        if (n > HIL_USART_DMA_BYTES_MAX)
            n = HIL_USART_DMA_BYTES_MAX;
        /* The n-th item from now reaches DR when the present byte and n - 1 more bytes have been
         * sent. */
        next = u->shift_end_cycle +
               (uint64_t)(n > 1 ? n - 1 : 0) * get_sent_frame_bits(dev) * get_bit_cycles(dev);
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_USART_TX, next);
}

void hil_usart_advance(void *device, uint64_t at)
{
    struct hil_usart_device *dev = device;
    struct hil_usart *u = dev->state;
    uint64_t last = at;
    bool moved = false;
    while (u->is_shifting && u->shift_end_cycle <= at) {
        last = u->shift_end_cycle;
        u->output[u->output_count++] = u->shifted_byte;
        if (u->output_count == sizeof u->output)
            pass_sent_bytes(dev, last);
        u->is_shifting = false;
        moved = true;
        shift_byte(dev, last);
        fill_dr(dev);
        if (!u->is_shifting)
            u->sr |= SR_TC;
    }
    if (!moved)
        return;
    pass_sent_bytes(dev, last);
    update_irq(dev);
    schedule_send_end(dev);
}

void hil_usart_on_dma_enabled(void *device)
{
    struct hil_usart_device *dev = device;
    begin_byte(dev, hil_now_cycle(dev->core));
    update_irq(dev);
    schedule_send_end(dev);
}

static uint64_t get_host_frame_ps(const struct hil_usart_device *dev)
{
    return get_bits_per_frame(get_host_parity(dev)) * HIL_PS_PER_S / dev->options->host_baud;
}

static void receive_frame(struct hil_usart_device *dev, uint16_t value, uint32_t errors)
{
    struct hil_usart *u = dev->state;
    if (u->sr & SR_RXNE) {
        u->sr |= SR_ORE;
        return;
    }
    u->dr = value;
    u->sr |= SR_RXNE | errors;
    dev->core->state.counters.serial_bytes_in++;
    struct hil_dma_request request = get_receive_request(dev);
    if ((u->cr3 & CR3_DMAR) && hil_dma_items_until_flag(dev->dma, &request)) {
        u->sr &= ~SR_RXNE;
        hil_dma_write_items(dev->dma, &request, &value, 1);
    }
}

/* Receives a byte; `errors` are the error flags with which it is received (30.6.1). */
static void receive_byte(struct hil_usart_device *dev, uint8_t byte, uint32_t errors)
{
    struct hil_usart *u = dev->state;
    if ((u->cr1 & (CR1_UE | CR1_RE)) != (CR1_UE | CR1_RE) ||
        !is_pin_connected(dev, dev->options->type->serial_in_pin) || !u->brr)
        return;
    if (!do_settings_match(dev)) {
        receive_frame(dev, GARBLED_BYTE_VALUE, errors | SR_FE);
        return;
    }
    uint32_t parity_bit = get_parity(u) == HIL_PARITY_NONE
                            ? 0
                            : get_frame_levels(byte, get_parity(u)) >> 1 & 0x100u;
    receive_frame(dev, (uint16_t)(parity_bit | byte), errors);
}

bool hil_usart_line_in(const void *device, unsigned channel, bool *drives)
{
    const struct hil_usart_device *dev = device;
    const struct hil_usart *u = dev->state;
    uint64_t end_ps = dev->core->state.events.due_ps[HIL_EVENT_USART_RX],
             now_ps = hil_now_ps(dev->core);
    uint64_t frame_ps = get_host_frame_ps(dev);
    (void)channel;
    *drives = true;
    if (!u->input_queue_count || end_ps == HIL_NEVER || now_ps >= end_ps ||
        now_ps + frame_ps < end_ps)
        return true;
    uint64_t bit = (now_ps + frame_ps - end_ps) * dev->options->host_baud / HIL_PS_PER_S;
    return (get_frame_levels(u->input_queue[u->input_queue_head], get_host_parity(dev)) >> bit &
            1u) != 0;
}

/* Receives a byte at the end of the line, after the faults of the line were applied. */
static void receive_from_line(struct hil_usart_device *dev, uint8_t byte)
{
    struct hil_usart *u = dev->state;
    uint32_t errors = 0;
    if (dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN, HIL_LINE_DROP, "byte",
                                  byte))
        return;
    if (dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN, HIL_LINE_CORRUPT, "byte",
                                  byte))
        byte = (uint8_t)(byte ^ 1u << dev->line_calls.random(dev->line_calls.context, 8));
    if (dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN, HIL_LINE_FRAMING, "byte",
                                  byte))
        errors |= SR_FE;
    if (dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN, HIL_LINE_NOISE, "byte",
                                  byte) &&
        !(u->cr3 & CR3_ONEBIT))
        errors |= SR_NF;
    receive_byte(dev, byte, errors);
}

void hil_usart_rx_event(void *device, uint64_t at)
{
    struct hil_usart_device *dev = device;
    struct hil_usart *u = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (u->input_queue_count) {
        uint8_t byte = u->input_queue[u->input_queue_head];
        if (!u->is_delay_over && dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN,
                                                           HIL_LINE_DELAY, "byte", byte)) {
            u->is_delay_over = true;
            hil_event_set_ps(dev->core, HIL_EVENT_USART_RX,
                             now_ps +
                                 dev->line_calls.delay_ps(dev->line_calls.context, HIL_SERIAL_IN));
            return;
        }
        u->is_delay_over = false;
        if (!dev->line_calls.has_fault(dev->line_calls.context, HIL_SERIAL_IN, HIL_LINE_REPEAT,
                                       "byte", byte)) {
            u->input_queue_head = (u->input_queue_head + 1u) % HIL_USART_QUEUE_LENGTH;
            u->input_queue_count--;
        }
        if (now_ps >= u->receiver_enabled_ps + get_host_frame_ps(dev))
            receive_from_line(dev, byte);
        u->is_idle_event_next = u->input_queue_count == 0;
        hil_event_set_ps(dev->core, HIL_EVENT_USART_RX, now_ps + get_host_frame_ps(dev));
    } else if (u->is_idle_event_next) {
        u->is_idle_event_next = false;
        if ((u->cr1 & (CR1_UE | CR1_RE)) == (CR1_UE | CR1_RE))
            u->sr |= SR_IDLE;
    }
    update_irq(dev);
}

enum mr_status hil_usart_inject(struct hil_usart_device *dev, const uint8_t *bytes, size_t n)
{
    struct hil_usart *u = dev->state;
    bool quiet = u->input_queue_count == 0;
    size_t taken = 0;
    for (; taken < n && u->input_queue_count < HIL_USART_QUEUE_LENGTH; taken++) {
        u->input_queue[(u->input_queue_head + u->input_queue_count) % HIL_USART_QUEUE_LENGTH] =
            bytes[taken];
        u->input_queue_count++;
    }
    dev->core->state.counters.serial_bytes_in_dropped += n - taken;
    if (quiet && taken) {
        u->is_idle_event_next = false;
        hil_event_set_ps(dev->core, HIL_EVENT_USART_RX,
                         hil_now_ps(dev->core) + get_host_frame_ps(dev));
    }
    return taken == n ? MR_OK : MR_FULL;
}

size_t hil_usart_free_space(const struct hil_usart_device *dev)
{
    return HIL_USART_QUEUE_LENGTH - dev->state->input_queue_count;
}

void hil_usart_reset(void *device, unsigned unit)
{
    struct hil_usart_device *dev = device;
    (void)unit;
    struct hil_usart *u = dev->state;
    u->sr = SR_TC;
    u->brr = u->cr1 = u->cr2 = u->cr3 = 0;
    u->is_sr_read = u->is_dr_full = u->is_shifting = false;
    u->output_count = 0;
    hil_event_set_cycle(dev->core, HIL_EVENT_USART_TX, HIL_NEVER);
    update_irq(dev);
}

uint32_t hil_usart_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_usart_device *dev = device;
    struct hil_usart *u = dev->state;
    (void)unit;
    hil_usart_advance(dev, hil_now_cycle(dev->core));
    if (offset == SR) {
        u->is_sr_read = true;
        return get_status_flags(u);
    }
    if (offset == DR) {
        u->sr &= ~SR_RXNE;
        if (u->is_sr_read)
            u->sr &= ~(SR_IDLE | SR_ORE | SR_NF | SR_FE | SR_PE);
        u->is_sr_read = false;
        update_irq(dev);
    }
    return u->word[offset / 4u];
}

void hil_usart_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_usart_device *dev = device;
    struct hil_usart *u = dev->state;
    uint64_t now = hil_now_cycle(dev->core);
    (void)unit;
    hil_usart_advance(dev, now);
    switch (offset) {
    case SR: /* RXNE and TC are cleared by writing 0 */ u->sr &= value | ~(SR_RXNE | SR_TC); break;
    case DR:
        if (u->is_sr_read)
            u->sr &= ~SR_TC;
        u->is_sr_read = false;
        if (is_sending(u)) {
            u->buffered_byte = (uint8_t)value;
            u->is_dr_full = true;
        }
        break;
    case CR1:
        if (!(value & CR1_PCE) != !(value & CR1_M))
            hil_bus_refuse(dev->core, "break, mute, and frames other than 8N1, 8E1 and 8O1");
        if ((value & ~u->cr1) & (CR1_UE | CR1_RE))
            u->receiver_enabled_ps = hil_now_ps(dev->core);
        u->cr1 = value;
        break;
    default: u->word[offset / 4u] = value; break;
    }
    begin_byte(dev, now);
    update_irq(dev);
    schedule_send_end(dev);
}
