#include "hil/periph/mcu.h"

#include <stddef.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/periph/options.h"
#include "hil/periph/flash.h"
#include "hil/periph/rcc.h"

#define ALWAYS_CLOCKED     HIL_RCC_BUS_COUNT
#define ANY_ADC_CLOCK_MASK 0x700u

/* Peripherals: addresses from RM0090 table 1, enable and reset bits from 7.3.5 to 7.3.14. */
static const struct part {
    uint32_t base;
    /* number of identical units; their addresses are a kilobyte apart, their enable bits
     * adjacent */
    unsigned unit_count;
    unsigned unit;
    size_t device; /* offset in struct hil_mcu */
    uint32_t (*read)(void *device, unsigned unit, uint32_t offset);
    void (*write)(void *device, unsigned unit, uint32_t offset, uint32_t value);
    void (*reset)(void *device, unsigned unit);
    enum hil_rcc_bus bus;
    uint8_t bit;
    bool allows_narrow_writes;
} parts[] = {
#define PART(base, alike, unit, device, access, reset, bus, bit, narrow)                           \
    {                                                                                              \
        base, alike, unit, offsetof(struct hil_mcu, device), access##_read, access##_write, reset, \
            bus, bit, narrow                                                                       \
    }
    PART(0x40000000u, 1, 0, tim, hil_tim, hil_tim_reset, HIL_RCC_APB1, 0, false),
    PART(0x40000800u, 1, 1, tim, hil_tim, hil_tim_reset, HIL_RCC_APB1, 2, false),
    PART(0x40003000u, 1, 0, iwdg, hil_iwdg, NULL, ALWAYS_CLOCKED, 0, false),
    PART(0x40003800u, 1, 0, spi, hil_spi, hil_spi_reset, HIL_RCC_APB1, 14, true),
    PART(0x40005400u, 1, 0, i2c, hil_i2c, hil_i2c_reset, HIL_RCC_APB1, 21, false),
    PART(0x40006400u, 1, 0, can, hil_can, hil_can_reset, HIL_RCC_APB1, 25, false),
    PART(0x40007000u, 1, 0, rcc, hil_pwr, NULL, HIL_RCC_APB1, 28, false),
    PART(0x40011000u, 1, 1, usart, hil_usart, hil_usart_reset, HIL_RCC_APB2, 4, true),
    PART(0x40011400u, 1, 6, usart, hil_usart, hil_usart_reset, HIL_RCC_APB2, 5, true),
    PART(0x40012000u, 1, 0, adc, hil_adc, hil_adc_reset, HIL_RCC_APB2, 8, false),
    PART(0x40013800u, 1, 0, flash, hil_syscfg, hil_syscfg_reset, HIL_RCC_APB2, 14, false),
    PART(0x40014800u, 1, 0, tim11, hil_tim11, hil_tim11_reset, HIL_RCC_APB2, 18, false),
    PART(0x40020000u, 9, 0, gpio, hil_gpio, hil_gpio_reset_port, HIL_RCC_AHB1, 0, true),
    PART(0x40023800u, 1, 0, rcc, hil_rcc, NULL, ALWAYS_CLOCKED, 0, false),
    PART(0x40023c00u, 1, 0, flash, hil_flash_if, NULL, ALWAYS_CLOCKED, 0, false),
    PART(0x40026000u, 2, 0, dma, hil_dma, hil_dma_reset, HIL_RCC_AHB1, 21, false),
#undef PART
};

#define PART_COUNT (sizeof parts / sizeof parts[0])

/* Reads device id, unique id, flash size and option bytes in system memory. */
static uint32_t read_system_memory(void *device, uint32_t address)
{
    const struct hil_mcu *mcu = device;
    switch (address & ~3u) {
    /* the identification of the boot loader is the byte at address ...de (AN2606) */
    case 0x1fff77dcu: return HIL_ROM_VERSION << 16 | 0xff00ffffu;
    case 0x1fff7a10u: return mcu->options->uid[0];
    case 0x1fff7a14u: return mcu->options->uid[1];
    case 0x1fff7a18u: return mcu->options->uid[2];
    case 0x1fff7a20u: /* flash size in KiB in the upper half, which is address ...22 */
        return mcu->options->type->flash_kib << 16 | 0xffffu;
    case 0x1fffc000u:
    case 0x1fffc004u:
    case 0x1fffc008u:
    case 0x1fffc00cu: return hil_flash_option_word(&mcu->flash, (address & 0xcu) / 4u);
    default:
        /* the one-time area and its locks are as delivered by the factory */
        if (address - 0x1fff7800u < 0x210u)
            return 0xffffffffu;
        return hil_bus_refuse_register(mcu->core);
    }
}

static void attach_part(struct hil_mcu *mcu, const struct part *part, unsigned n)
{
    void *device = (char *)mcu + part->device;
    struct hil_peripheral peripheral = {
        .base = part->base + 0x400u * n,
        .unit = part->unit + n,
        .read = part->read,
        .write = part->write,
        .allows_narrow_writes = part->allows_narrow_writes,
        .unchanged_bits = part->write == hil_gpio_write ? hil_gpio_unchanged_bits : NULL,
        .device = device,
    };
    if (part->bus != ALWAYS_CLOCKED) {
        unsigned bit = part->bit + n;
        peripheral.clock_enables = hil_rcc_clock_enables(&mcu->rcc, part->bus);
        peripheral.clock_mask = device == &mcu->adc ? ANY_ADC_CLOCK_MASK : 1u << bit;
        mcu->rcc.reset_lines[part->bus][bit] = (struct hil_reset_line){part->reset, device,
                                                                       peripheral.unit};
    }
    hil_bus_attach(mcu->core, &peripheral);
}

static void attach_to_bus(struct hil_mcu *mcu)
{
    for (unsigned i = 0; i < PART_COUNT; i++) {
        const struct part *part = &parts[i];
        if (part->write == hil_usart_write && part->unit != mcu->options->type->usart)
            continue; /* nothing is connected to the other USART */
        for (unsigned n = 0; n < part->unit_count; n++)
            attach_part(mcu, part, n);
    }
    mcu->core->bus.system_memory = (struct hil_system_memory){read_system_memory, mcu};
}

static void attach_to_events(struct hil_mcu *mcu)
{
    const struct {
        enum hil_event_slot slot;
        void (*handler)(void *device, uint64_t at);
        void *device;
    } wires[] = {
        {HIL_EVENT_HSE, hil_rcc_hse_event, &mcu->rcc},
        {HIL_EVENT_PLL, hil_rcc_pll_event, &mcu->rcc},
        {HIL_EVENT_LSI, hil_rcc_lsi_event, &mcu->rcc},
        {HIL_EVENT_FLASH, hil_flash_event, &mcu->flash},
        {HIL_EVENT_ADC1, hil_adc1_event, &mcu->adc},
        {HIL_EVENT_ADC3, hil_adc3_event, &mcu->adc},
        {HIL_EVENT_TIM4, hil_tim4_event, &mcu->tim},
        {HIL_EVENT_TIM2, hil_tim2_event, &mcu->tim},
        {HIL_EVENT_SPI, hil_spi_advance, &mcu->spi},
        {HIL_EVENT_I2C, hil_i2c_event, &mcu->i2c},
        {HIL_EVENT_CAN, hil_can_event, &mcu->can},
        {HIL_EVENT_CAN_OTHER_NODE, hil_can_other_node_event, &mcu->can},
        {HIL_EVENT_USART_TX, hil_usart_advance, &mcu->usart},
        {HIL_EVENT_USART_RX, hil_usart_rx_event, &mcu->usart},
        {HIL_EVENT_IWDG, hil_iwdg_event, &mcu->iwdg},
    };
    for (unsigned i = 0; i < sizeof wires / sizeof wires[0]; i++)
        hil_event_connect(mcu->core, wires[i].slot, wires[i].handler, wires[i].device);
}

/* Connects pins to alternate functions (data sheet table 9) and to peripherals that watch pins. */
static void attach_to_pins(struct hil_mcu *mcu)
{
    struct hil_gpio_device *gpio = &mcu->gpio;
    /* PD12, TIM4_CH1 */
    mcu->pin[0] = (struct hil_pin){&mcu->tim, 2, 0, hil_tim4_output, NULL};
    /* PD13, TIM4_CH2 */
    mcu->pin[1] = (struct hil_pin){&mcu->tim, 2, 1, hil_tim4_output, NULL};
    const struct hil_board_type *type = mcu->options->type;
    /* output of the serial link */
    mcu->pin[2] = (struct hil_pin){NULL, type->serial_alternate_function, 0,
                                   hil_gpio_level_always_high, NULL};
    /* PD1, CAN1_TX: recessive */
    mcu->pin[3] = (struct hil_pin){NULL, 9, 0, hil_gpio_level_always_high, NULL};
    for (unsigned i = 0; i < HIL_CAPTURE_CHANNELS; i++) {
        const struct hil_capture_pin *pin = &hil_capture_pins[i];
        mcu->pin[4 + i] = (struct hil_pin){&mcu->tim, 1, i, NULL, hil_tim2_input_edge};
        gpio->alternate_pins[pin->port][pin->pin] = &mcu->pin[4 + i];
    }
    gpio->alternate_pins[3][12] = &mcu->pin[0];
    gpio->alternate_pins[3][13] = &mcu->pin[1];
    gpio->alternate_pins[type->serial_out_pin.port][type->serial_out_pin.pin] = &mcu->pin[2];
    gpio->alternate_pins[3][1] = &mcu->pin[3];
    mcu->serial_in_pin = (struct hil_pin){&mcu->usart, -1, 0, hil_usart_line_in, NULL};
    /* input of the serial link */
    gpio->external_pins[type->serial_in_pin.port][type->serial_in_pin.pin] = &mcu->serial_in_pin;
    hil_gpio_add_listener(gpio, hil_spi_on_pins_changed, &mcu->spi);
    hil_gpio_add_listener(gpio, hil_i2c_on_lines_changed, &mcu->i2c);
}

/* Streams of DMA1 serve SPI2, those of DMA2 the converters and the USART (RM0090 tables 42, 43). */
static void attach_to_dma(struct hil_mcu *mcu)
{
    mcu->dma.client[0][0] = (struct hil_dma_client){&mcu->spi, hil_spi_advance,
                                                    hil_spi_on_dma_enabled};
    mcu->dma.client[1][0] = (struct hil_dma_client){&mcu->adc, hil_adc_advance, NULL};
    mcu->dma.client[1][1] = (struct hil_dma_client){&mcu->usart, hil_usart_advance,
                                                    hil_usart_on_dma_enabled};
}

void hil_mcu_create(struct hil_mcu *mcu, struct hil_core *core, struct hil_options *options,
                    struct hil_mcu_state *state)
{
#define CONCATENATE(part, of)                                                               \
    (mcu->part.core = core, mcu->part.options = options, mcu->part.rcc = &mcu->rcc,         \
     mcu->part.dma = &mcu->dma, mcu->part.gpio = &mcu->gpio, mcu->part.rules = &mcu->rules, \
     mcu->part.state = of)
    mcu->core = core;
    mcu->options = options;
    CONCATENATE(rcc, &state->rcc);
    CONCATENATE(flash, &state->flash);
    CONCATENATE(gpio, &state->gpio);
    CONCATENATE(tim, state->tim);
    CONCATENATE(dma, state->dma);
    CONCATENATE(adc, state->adc);
    CONCATENATE(usart, &state->usart);
    CONCATENATE(spi, &state->spi);
    CONCATENATE(i2c, &state->i2c);
    CONCATENATE(can, &state->can);
    CONCATENATE(iwdg, &state->iwdg);
    CONCATENATE(tim11, &state->tim11);
    CONCATENATE(rules, &state->rules);
#undef CONCATENATE
    mcu->adc.ccr = &state->adc_ccr;
    mcu->tim.adc = &mcu->adc;
    mcu->gpio.on_store = hil_rules_on_store;
    mcu->gpio.on_floating_read = hil_rules_check_floating;
    mcu->gpio.store_context = mcu->gpio.floating_context = &mcu->rules;
    mcu->flash.on_bank_ready = (struct hil_callback){hil_dma_on_flash_ready, &mcu->dma};
    core->bank_calls = (struct hil_bank_calls){&mcu->flash, hil_flash_store, hil_flash_load};
    attach_to_bus(mcu);
    attach_to_events(mcu);
    attach_to_pins(mcu);
    attach_to_dma(mcu);
}

void hil_mcu_reset(struct hil_mcu *mcu, uint32_t csr_flags)
{
    hil_flash_reset(&mcu->flash);
    hil_rcc_reset(&mcu->rcc, csr_flags);
    /* Reset the converters before their DMA streams; in the other order they would report an
     * overrun. */
    hil_adc_reset(&mcu->adc, 0);
    for (unsigned unit = 0; unit < 2; unit++) {
        hil_dma_reset(&mcu->dma, unit);
        hil_tim_reset(&mcu->tim, unit);
    }
    hil_usart_reset(&mcu->usart, 0);
    hil_spi_reset(&mcu->spi, 0);
    hil_i2c_reset(&mcu->i2c, 0);
    hil_can_reset(&mcu->can, 0);
    hil_iwdg_reset(&mcu->iwdg);
    hil_tim11_reset(&mcu->tim11, 0);
    for (unsigned port = 0; port < HIL_GPIO_PORTS; port++)
        hil_gpio_reset_port(&mcu->gpio, port);
    hil_rules_reset(&mcu->rules);
}
