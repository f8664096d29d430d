#include "hil/periph/spi.h"

#include "hil/core/core.h"
#include "hil/periph/dma.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"

#define CR1                  0x00u
#define SR                   0x08u
#define DR                   0x0cu
#define CR1_CPHA             (1u << 0)
#define CR1_CPOL             (1u << 1)
#define CR1_MSTR             (1u << 2)
#define CR1_SPE              (1u << 6)
#define CR1_SSI              (1u << 8)
#define CR1_SSM              (1u << 9)
#define CR1_FIXED_WHILE_BUSY (CR1_CPHA | CR1_CPOL | CR1_MSTR | CR1_SPE | 0x38u)
#define CR2_RXDMAEN          (1u << 0)
#define CR2_TXDMAEN          (1u << 1)
#define SR_RXNE              (1u << 0)
#define SR_TXE               (1u << 1)
#define SR_OVR               (1u << 6)
#define SR_BSY               (1u << 7)
#define DATA_REGISTER        0x4000380cu
#define PORT_B               1u
#define MISO_PIN             14u
#define DMA_GROUP_BYTES      64u /* maximum number of bytes that one event transfers by DMA */

/* RM0090 table 42: SPI2_RX stream 3 channel 0, SPI2_TX stream 4 channel 0. */
static const struct hil_dma_request receive_request = {0, 3, 0, DATA_REGISTER, false};
static const struct hil_dma_request send_request = {0, 4, 0, DATA_REGISTER, true};

static uint64_t get_byte_cycles(const struct hil_spi_device *dev)
{
    unsigned br = dev->state->cr1 >> 3 & 7u;
    return 8u * (uint64_t)(2u << br) * hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB1);
}

double hil_spi_clock_period_ns(const struct hil_spi_device *dev)
{
    return (double)get_byte_cycles(dev) / 8.0 * 1e9 / (double)dev->core->state.clock.hclk_hz;
}

static bool is_enabled(const struct hil_spi *spi)
{
    return (spi->cr1 & (CR1_SPE | CR1_MSTR)) == (CR1_SPE | CR1_MSTR);
}

static uint32_t get_status_flags(const struct hil_spi *spi)
{
    return spi->sr | (spi->is_buffer_full ? 0 : SR_TXE) |
           (spi->is_buffer_full || spi->is_shifting ? SR_BSY : 0);
}

static bool is_connected(const struct hil_spi_device *dev)
{
    for (unsigned pin = 13; pin < 16; pin++) {
        if (hil_gpio_alternate_function(dev->gpio, PORT_B, pin) != 5)
            return false;
    }
    return true;
}

/* Fills the transmit buffer from DMA if enabled. */
static void fill_transmit_buffer(struct hil_spi_device *dev)
{
    struct hil_spi *spi = dev->state;
    if (is_enabled(spi) && !spi->is_buffer_full && (spi->cr2 & CR2_TXDMAEN) &&
        hil_dma_items_until_flag(dev->dma, &send_request))
        spi->is_buffer_full = hil_dma_read_items(dev->dma, &send_request, &spi->buffered_byte, 1);
}

static void shift_byte(struct hil_spi_device *dev, uint64_t at)
{
    struct hil_spi *spi = dev->state;
    if (spi->is_shifting || !spi->is_buffer_full || !is_enabled(spi))
        return;
    spi->shifted_byte = spi->buffered_byte;
    spi->is_buffer_full = false;
    spi->is_shifting = true;
    spi->shift_end_cycle = at + get_byte_cycles(dev);
}

static void receive_byte(struct hil_spi_device *dev, uint8_t byte)
{
    struct hil_spi *spi = dev->state;
    bool driven = spi->is_selected && is_connected(dev) &&
                  dev->slave.is_driving(dev->slave.context);
    if (spi->sr & SR_RXNE) { /* overrun: the byte in DR stays, and the new one is lost (28.3.10) */
        spi->sr |= SR_OVR;
        spi->is_dr_read = false;
        return;
    }
    if ((spi->cr2 & CR2_RXDMAEN) && hil_dma_items_until_flag(dev->dma, &receive_request)) {
        uint16_t value = byte;
        hil_dma_write_items(dev->dma, &receive_request, &value, 1);
        return;
    }
    spi->dr = byte;
    spi->is_dr_floating = !driven && !hil_gpio_has_defined_level(dev->gpio, PORT_B, MISO_PIN);
    spi->sr |= SR_RXNE;
}

static void begin_byte(struct hil_spi_device *dev, uint64_t at)
{
    fill_transmit_buffer(dev);
    shift_byte(dev, at);
    fill_transmit_buffer(dev);
}

/* --- rules of the select line and the clock --- */

/* Returns the time of the first rise of SCK: it is in the middle of a bit, because the chip
 * requires mode 0 or 3. */
static struct hil_timestamp get_first_clock_rise(const struct hil_spi_device *dev,
                                                 struct hil_timestamp begin)
{
    begin.ps += (uint64_t)(hil_spi_clock_period_ns(dev) / 2.0 * 1e3);
    return begin;
}

/* Checks the clock when a store begins a byte. */
static void check_byte_begin(struct hil_spi_device *dev)
{
    struct hil_spi *spi = dev->state;
    const struct hil_rules_edges *select = hil_rules_get_edges(dev->rules, HIL_RULES_MEMORY_SELECT);
    if (!spi->is_selected || spi->has_byte_begun || !hil_rules_are_checked(dev->rules))
        return;
    struct hil_timestamp begin = hil_access_timestamp(dev->core);
    if (!begin.ps)
        return;
    spi->has_byte_begun = true;
    hil_rules_check_interval(dev->rules, HIL_RULE_SELECT_TO_CLOCK, select->last_fall,
                             get_first_clock_rise(dev, begin));
    hil_rules_check_time(dev->rules, HIL_RULE_CLOCK_SLEW, hil_spi_clock_period_ns(dev),
                         hil_rules_min_period_ns(dev->rules, PORT_B, 13), begin.pc);
}

/* Checks a fall of the select line while a byte is being sent. */
static void check_select_timing(struct hil_spi_device *dev)
{
    struct hil_spi *spi = dev->state;
    const struct hil_rules_edges *select = hil_rules_get_edges(dev->rules, HIL_RULES_MEMORY_SELECT);
    spi->has_byte_begun = spi->is_shifting;
    if (spi->is_shifting)
        hil_rules_check_interval(
            dev->rules, HIL_RULE_SELECT_TO_CLOCK, select->last_fall,
            get_first_clock_rise(dev, hil_timestamp_at_cycle(dev->core, spi->shift_end_cycle -
                                                                            get_byte_cycles(dev))));
}

/* Checks the rise of the select line. The rule does not apply before the last clock of a byte: the
 * chip then drops the incomplete byte. */
static void check_deselect_timing(struct hil_spi_device *dev)
{
    struct hil_spi *spi = dev->state;
    const struct hil_rules_edges *select = hil_rules_get_edges(dev->rules, HIL_RULES_MEMORY_SELECT);
    struct hil_timestamp last =
        hil_timestamp_at_cycle(dev->core, spi->shift_end_cycle - get_byte_cycles(dev) / 16u);
    if (spi->has_byte_begun && (!spi->is_shifting || select->last_rise.ps >= last.ps))
        hil_rules_check_interval(dev->rules, HIL_RULE_CLOCK_TO_DESELECT, last, select->last_rise);
}

/* Schedules the end of the next byte that has a visible effect, such as a flag of a DMA stream or
 * an interrupt. */
static void schedule_byte_end(struct hil_spi_device *dev)
{
    const struct hil_spi *spi = dev->state;
    uint64_t next = HIL_NEVER;
    if (spi->is_shifting) {
        uint32_t n = 1;
        if (spi->is_buffer_full && (spi->cr2 & CR2_TXDMAEN)) {
            n = hil_dma_items_until_flag(dev->dma, &send_request);
            if (n > DMA_GROUP_BYTES)
                n = DMA_GROUP_BYTES;
            if (spi->cr2 & CR2_RXDMAEN) {
                uint32_t in = hil_dma_items_until_flag(dev->dma, &receive_request);
                n = in < n ? in : n;
            }
        }
        next = spi->shift_end_cycle + (uint64_t)(n > 1 ? n - 1 : 0) * get_byte_cycles(dev);
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_SPI, next);
}

void hil_spi_advance(void *device, uint64_t at)
{
    struct hil_spi_device *dev = device;
    struct hil_spi *spi = dev->state;
    if (!spi->is_shifting || spi->shift_end_cycle > at)
        return;
    bool connected = is_connected(dev);
    while (spi->is_shifting && spi->shift_end_cycle <= at) {
        uint64_t end = spi->shift_end_cycle;
        receive_byte(dev, connected && spi->is_selected
                              ? dev->slave.exchange(dev->slave.context, spi->shifted_byte, end)
                              : 0xff);
        spi->is_shifting = false;
        begin_byte(dev, end);
    }
    schedule_byte_end(dev);
}

void hil_spi_on_dma_enabled(void *device)
{
    struct hil_spi_device *dev = device;
    bool shifting = dev->state->is_shifting;
    begin_byte(dev, hil_now_cycle(dev->core));
    if (!shifting && dev->state->is_shifting)
        check_byte_begin(dev);
    schedule_byte_end(dev);
}

void hil_spi_on_pins_changed(void *device, uint64_t at)
{
    struct hil_spi_device *dev = device;
    struct hil_spi *spi = dev->state;
    bool selected = !hil_gpio_level(dev->gpio, PORT_B, 12);
    if (selected == spi->is_selected)
        return;
    hil_spi_advance(dev, at);
    bool in_byte = spi->is_shifting && at > spi->shift_end_cycle - get_byte_cycles(dev);
    spi->is_selected = selected;
    if (selected) {
        check_select_timing(dev);
        dev->slave.select(dev->slave.context, at);
    } else {
        check_deselect_timing(dev);
        dev->slave.deselect(dev->slave.context, at, in_byte);
    }
}

void hil_spi_reset(void *device, unsigned unit)
{
    struct hil_spi_device *dev = device;
    (void)unit;
    bool selected = dev->state->is_selected;
    *dev->state = (struct hil_spi){.is_selected = selected};
    hil_event_set_cycle(dev->core, HIL_EVENT_SPI, HIL_NEVER);
}

uint32_t hil_spi_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_spi_device *dev = device;
    struct hil_spi *spi = dev->state;
    (void)unit;
    hil_spi_advance(dev, hil_now_cycle(dev->core));
    uint32_t value = offset == SR ? get_status_flags(spi) : spi->word[offset / 4u];
    if (offset == SR) {
        if (spi->is_dr_read)
            spi->sr &= ~SR_OVR;
        spi->is_dr_read = false;
    } else if (offset == DR) {
        if (spi->is_dr_floating && (spi->sr & SR_RXNE))
            hil_rules_check_unknown(dev->rules, "PB14, SPI2_MISO,", value, 0xffu);
        spi->sr &= ~SR_RXNE;
        spi->is_dr_read = true;
    }
    return value;
}

static void write_cr1(struct hil_spi_device *dev, uint32_t value)
{
    struct hil_spi *spi = dev->state;
    if ((spi->is_shifting || spi->is_buffer_full) && ((value ^ spi->cr1) & CR1_FIXED_WHILE_BUSY))
        hil_bus_refuse(dev->core, "settings are changed while BSY is set");
    if ((value & CR1_SPE) && !(value & CR1_MSTR))
        hil_bus_refuse(dev->core, "slave mode");
    if ((value & CR1_SPE) && !(value & CR1_SSM))
        hil_bus_refuse(dev->core, "NSS managed by hardware");
    if ((value & CR1_SPE) && !(value & CR1_SSI))
        hil_bus_refuse(dev->core, "SSI is low in a master, which is a mode fault");
    if ((value & CR1_SPE) && !(value & CR1_CPOL) != !(value & CR1_CPHA))
        hil_bus_refuse(dev->core, "CPOL and CPHA differ: the memory samples at the wrong edge");
    spi->cr1 = value;
}

void hil_spi_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_spi_device *dev = device;
    struct hil_spi *spi = dev->state;
    uint64_t now = hil_now_cycle(dev->core);
    (void)unit;
    hil_spi_advance(dev, now);
    bool shifting = spi->is_shifting;
    switch (offset) {
    case CR1: write_cr1(dev, value); break;
    case SR: /* SR is read-only here; CRCERR is never set */ break;
    case DR: /* as on hardware, a byte that was not sent yet is replaced */
        spi->buffered_byte = (uint8_t)value;
        spi->is_buffer_full = true;
        break;
    default: spi->word[offset / 4u] = value; break;
    }
    begin_byte(dev, now);
    if (!shifting && spi->is_shifting)
        check_byte_begin(dev);
    schedule_byte_end(dev);
}
