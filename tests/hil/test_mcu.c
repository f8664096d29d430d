/* The chip's peripherals on a bare core: no board, no rig, no Unicorn. What is outside are fakes on
 * the wires. */
#include <string.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/nvic.h"
#include "hil/periph/mcu.h"
#include "hil/periph/options.h"
#include "tests/cmocka_all.h"

#define RCC_AHB1ENR  0x40023830u
#define RCC_APB1ENR  0x40023840u
#define RCC_APB2ENR  0x40023844u
#define RCC_APB1RSTR 0x40023820u
#define GPIOA        0x40020000u
#define GPIOB        0x40020400u
#define USART1       0x40011000u
#define SPI2         0x40003800u
#define I2C1         0x40005400u

/* What the fakes have seen. */
static struct {
    uint8_t byte;
    unsigned bytes, selected, deselected, addressed;
    uint64_t t_ps;
    uint8_t exchanged, address;
} seen;

static void take_serial(void *who, uint64_t t_ps, uint8_t *bytes, size_t n)
{
    (void)who;
    seen.byte = bytes[n - 1];
    seen.bytes += (unsigned)n;
    seen.t_ps = t_ps;
}

static bool suffers_nothing(void *who, enum hil_line line, enum hil_line_fault kind,
                            const char *what, uint32_t number)
{
    (void)who, (void)line, (void)kind, (void)what, (void)number;
    return false;
}

static void select_chip(void *who, uint64_t at)
{
    (void)who, (void)at;
    seen.selected++;
}

static void deselect_chip(void *who, uint64_t at, bool in_byte)
{
    (void)who, (void)at, (void)in_byte;
    seen.deselected++;
}

static bool speaks(const void *who)
{
    (void)who;
    return true;
}

static uint8_t exchange(void *who, uint8_t in, uint64_t at)
{
    (void)who, (void)at;
    seen.exchanged = in;
    return (uint8_t)~in;
}

/* A slave at 0x21. */
static bool take_address(void *who, uint8_t byte)
{
    (void)who;
    seen.addressed++;
    seen.address = byte;
    return byte >> 1 == 0x21u;
}

static bool take_byte(void *who, uint8_t byte)
{
    (void)who, (void)byte;
    return true;
}

static uint8_t give_byte(void *who)
{
    (void)who;
    return 0xff;
}

static void ignore(void *who)
{
    (void)who;
}
static bool never(const void *who)
{
    (void)who;
    return false;
}
struct bare {
    struct hil_core core;
    struct hil_options options;
    struct hil_mcu_state state;
    struct hil_mcu mcu;
};

static struct bare *bare;
static struct hil_i2c_hold hold;
static struct hil_memory memory;

static int power_on(void **state)
{
    (void)state;
    memset(&seen, 0, sizeof seen);
    bare = test_calloc(1, sizeof *bare);
    hil_options_default(&bare->options);
    bare->core.memory = &memory;
    hil_event_create(&bare->core);
    hil_systick_create(&bare->core);
    hil_clock_start(&bare->core.state.clock, 16000000);
    hil_bus_create(&bare->core);
    hil_mcu_create(&bare->mcu, &bare->core, &bare->options, &bare->state);
    bare->mcu.usart.wire = bare->mcu.can.wire = (struct hil_wire){.suffers = suffers_nothing,
                                                                  .serial_out = take_serial};
    bare->mcu.spi.slave = (struct hil_spi_slave){NULL, select_chip, deselect_chip, exchange,
                                                 speaks};
    bare->mcu.i2c.slave = (struct hil_i2c_slave){
        .address = take_address,
        .write = take_byte,
        .read = give_byte,
        .stop = ignore,
        .speaks = never,
        .hold = &hold,
    };
    hil_flash_create(&bare->mcu.flash);
    hil_mcu_reset(&bare->mcu, 0);
    return 0;
}

static int power_off(void **state)
{
    (void)state;
    test_free(bare);
    return 0;
}

static void put(uint32_t address, uint32_t value)
{
    hil_bus_write(&bare->core, address, 4, value);
}
static uint32_t get(uint32_t address)
{
    return hil_bus_read(&bare->core, address, 4);
}

static void pass(uint64_t cycles)
{
    bare->core.state.clock.now_cycle += cycles;
    hil_event_run(&bare->core);
}

/* 16 MHz, BRR 8: 2 Mbaud; ten bits take 5 us, 80 cycles. */
TEST_IN(usart_sends_to_whoever_is_on_its_wire, power_on, power_off)
{
    put(RCC_AHB1ENR, 0x00100001);
    put(RCC_APB2ENR, 1u << 4);
    put(GPIOA, 0xa8000000u | 2u << 18);
    put(GPIOA + 0x24, 7u << 4); /* PA9 is USART1_TX */
    put(USART1 + 0x08, 8);
    put(USART1 + 0x0c, 1u << 13 | 1u << 3);
    put(USART1 + 0x04, 'A');
    pass(79);
    assert_int_equal(seen.bytes, 0);
    pass(1);
    assert_int_equal(seen.bytes, 1);
    assert_int_equal(seen.byte, 'A');
    assert_int_equal(seen.t_ps, 5000000);
    assert_false(bare->core.stopped);
}

/* PCLK1 / 2: eight bits take 16 cycles. */
TEST_IN(spi_exchanges_with_any_slave, power_on, power_off)
{
    put(RCC_AHB1ENR, 0x00100002);
    put(RCC_APB1ENR, 1u << 14);
    put(GPIOB + 0x14, 1u << 12);
    put(GPIOB, 0x280u | 1u << 24 | 0xa8000000u); /* PB12 is an output, PB13 to PB15 are SPI2 */
    put(GPIOB + 0x24, 0x55500000);
    unsigned selected = seen.selected, deselected = seen.deselected;
    put(GPIOB + 0x18, 1u << 28);
    assert_int_equal(seen.selected, selected + 1);
    put(SPI2, 1u << 9 | 1u << 8 | 1u << 6 | 1u << 2);
    put(SPI2 + 0x0c, 0x5a);
    pass(16);
    assert_int_equal(seen.exchanged, 0x5a);
    assert_int_equal(get(SPI2 + 0x0c), 0xa5);
    put(GPIOB + 0x18, 1u << 12);
    assert_int_equal(seen.deselected, deselected + 1);
    assert_false(bare->core.stopped);
}

/* A start, an address byte: 100 kHz at 16 MHz, so 80 clocks for each half of a period. */
TEST_IN(i2c_asks_any_slave_for_its_acknowledge, power_on, power_off)
{
    put(RCC_AHB1ENR, 0x00100002);
    put(RCC_APB1ENR, 1u << 21);
    put(GPIOB + 0x0c, 0x5100); /* PB6 and PB7: pulled up */
    put(GPIOB, 0x280u | 0xa000u);
    put(GPIOB + 0x20, 0x44000000);
    put(I2C1 + 0x04, 16);
    put(I2C1 + 0x1c, 80);
    put(I2C1, 1);
    put(I2C1, 1u | 1u << 8);
    pass(160);
    assert_int_equal(get(I2C1 + 0x14) & 1u, 1); /* SB */
    put(I2C1 + 0x10, 0x21u << 1);
    pass(9 * 160);
    assert_int_equal(seen.addressed, 1);
    assert_int_equal(seen.address, 0x42);
    assert_int_equal(get(I2C1 + 0x14) & 0x402u, 2); /* ADDR, no AF */
    assert_false(bare->core.stopped);
}

/* A clock that is off, a reset line: both are the bus's and RCC's, whatever is behind. */
TEST_IN(clocks_and_resets_reach_by_the_bus, power_on, power_off)
{
    put(RCC_APB1ENR, 1u << 14);
    put(SPI2 + 0x04, 0x40);
    assert_int_equal(get(SPI2 + 0x04), 0x40);
    put(RCC_APB1RSTR, 1u << 14);
    assert_int_equal(get(SPI2 + 0x04), 0);
    put(RCC_APB1ENR, 0);
    assert_false(bare->core.stopped);
    assert_int_equal(get(SPI2 + 0x04), 0);
    assert_true(bare->core.stopped);
    assert_non_null(
        strstr(bare->core.reason,
               "clock of the peripheral is off: read of 4 bytes at 0x40003804 (SPI2 + 0x4)"));
}
