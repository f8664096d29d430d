#include "hil/core/bus.h"

#include <string.h>

#include "hil/board/machine.h"
#include "hil/core/registers.h"

struct peripheral {
    uint32_t base;
    const char *name;
    unsigned unit;
    uint32_t (*read)(struct hil_board *board, unsigned unit, uint32_t offset);
    void (*write)(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
    uint8_t clock;      /* hil_rcc_enabled: register and bit */
    uint8_t clock_bit;
    bool narrow;        /* byte and halfword writes are modelled */
};

/* Boundary addresses of RM0090 table 1, enable bits of 7.3.10 to 7.3.14. Each occupies one kilobyte. */
static const struct peripheral peripherals[] = {
    {0x40000000u, "TIM2", 0, hil_tim_read, hil_tim_write, HIL_RCC_APB1, 0, false},
    {0x40000800u, "TIM4", 1, hil_tim_read, hil_tim_write, HIL_RCC_APB1, 2, false},
    {0x40003000u, "IWDG", 0, hil_iwdg_read, hil_iwdg_write, HIL_RCC_ALWAYS, 0, false},
    {0x40003800u, "SPI2", 0, hil_spi_read, hil_spi_write, HIL_RCC_APB1, 14, true},
    {0x40005400u, "I2C1", 0, hil_i2c_read, hil_i2c_write, HIL_RCC_APB1, 21, false},
    {0x40006400u, "CAN1", 0, hil_can_read, hil_can_write, HIL_RCC_APB1, 25, false},
    {0x40007000u, "PWR", 0, hil_pwr_read, hil_pwr_write, HIL_RCC_APB1, 28, false},
    {0x40011000u, "USART1", 0, hil_usart_read, hil_usart_write, HIL_RCC_APB2, 4, true},
    {0x40012000u, "ADC", 0, hil_adc_read, hil_adc_write, HIL_RCC_ANY_ADC, 0, false},
    {0x40020000u, "GPIOA", 0, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 0, true},
    {0x40020400u, "GPIOB", 1, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 1, true},
    {0x40020800u, "GPIOC", 2, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 2, true},
    {0x40020c00u, "GPIOD", 3, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 3, true},
    {0x40021000u, "GPIOE", 4, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 4, true},
    {0x40021400u, "GPIOF", 5, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 5, true},
    {0x40021800u, "GPIOG", 6, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 6, true},
    {0x40021c00u, "GPIOH", 7, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 7, true},
    {0x40022000u, "GPIOI", 8, hil_gpio_read, hil_gpio_write, HIL_RCC_AHB1, 8, true},
    {0x40023800u, "RCC", 0, hil_rcc_read, hil_rcc_write, HIL_RCC_ALWAYS, 0, false},
    {0x40023c00u, "FLASH", 0, hil_flash_if_read, hil_flash_if_write, HIL_RCC_ALWAYS, 0, false},
    {0x40026000u, "DMA1", 0, hil_dma_read, hil_dma_write, HIL_RCC_AHB1, 21, false},
    {0x40026400u, "DMA2", 1, hil_dma_read, hil_dma_write, HIL_RCC_AHB1, 22, false},
};

#define PAGES (sizeof ((struct hil_board *)0)->peripheral_of)
#define NO_PERIPHERAL 0xffu
_Static_assert(sizeof peripherals / sizeof peripherals[0] <= HIL_PERIPHERALS_MAX, "room in registers_of");


void hil_bus_init(struct hil_board *board)
{
    memset(board->peripheral_of, NO_PERIPHERAL, sizeof board->peripheral_of);
    for (unsigned i = 0; i < sizeof peripherals / sizeof peripherals[0]; i++) {
        board->peripheral_of[(peripherals[i].base - 0x40000000u) >> 10] = (uint8_t)i;
        board->registers_of[i] = hil_registers_of(peripherals[i].base);
    }
}

static bool may_go_on(struct hil_board *board, const struct hil_register *r, bool write, uint32_t value)
{
    if (!r) {
        hil_bus_no_register(board);
        return false;
    }
    const char *objection = write ? hil_register_objection(r, value) : NULL;
    if (!objection)
        return true;
    hil_bus_refuse(board, objection);
    return false;
}

/* May the access go on, by the table of registers? A peripheral without a table decides itself. */
static bool is_modelled(struct hil_board *board, const struct peripheral *p, uint32_t offset, bool write, uint32_t value)
{
    const struct hil_register_set *set = board->registers_of[p - peripherals];
    if (!set)
        return true;
    const struct hil_register **r = &board->register_at[p - peripherals][offset / 4u % HIL_REGISTER_WORDS];
    if (!*r)
        *r = hil_register_at(set, offset);
    return may_go_on(board, *r, write, value);
}

static bool is_core_modelled(struct hil_board *board, uint32_t offset, bool write, uint32_t value)
{
    return may_go_on(board, hil_register_at(hil_registers_of(0xe000e000u), offset), write, value);
}

static const struct peripheral *find(const struct hil_board *board, uint32_t address)
{
    uint32_t page = (address - 0x40000000u) >> 10;
    uint8_t i = page < PAGES ? board->peripheral_of[page] : NO_PERIPHERAL;
    return i == NO_PERIPHERAL ? NULL : &peripherals[i];
}

bool hil_bus_has(uint32_t base)
{
    for (unsigned i = 0; i < sizeof peripherals / sizeof peripherals[0]; i++) {
        if (peripherals[i].base == base)
            return true;
    }
    return false;
}

static void stop(struct hil_board *board, const char *why, const char *what)
{
    struct hil_access current = board->access;
    const struct peripheral *p = find(board, current.address);
    unsigned pc = (unsigned)hil_cpu_access_pc(board, current.address, current.write);
    char place[32] = "";
    if (p)
        snprintf(place, sizeof place, " (%s + 0x%x)", p->name, (unsigned)(current.address - p->base));
    hil_board_stop(board, MR_UNMODELLED, "%s %s of %u bytes at 0x%08x%s, PC 0x%08x%s%s", why,
                   current.write ? "write" : "read", current.size, (unsigned)current.address, place, pc,
                   what ? ": " : "", what ? what : "");
}

uint32_t hil_bus_refuse(struct hil_board *board, const char *what)
{
    stop(board, "unmodelled", what);
    return 0;
}

uint32_t hil_bus_no_register(struct hil_board *board)
{
    stop(board, "unmodelled", NULL);
    return 0;
}

static uint32_t lane(uint32_t value, uint32_t address, unsigned size)
{
    value >>= 8u * (address & 3u);
    return size == 1 ? value & 0xffu : size == 2 ? value & 0xffffu : value;
}

/* Device id, unique id and flash size of system memory; debug registers that firmware asks for. */
static uint32_t read_system_memory(struct hil_board *board, uint32_t address)
{
    switch (address & ~3u) {
    case 0x1fff77dcu: /* boot loader identification is the byte at ...de (AN2606) */
        return HIL_ROM_VERSION << 16 | 0xff00ffffu;
    case 0x1fff7a10u:
        return board->options.uid[0];
    case 0x1fff7a14u:
        return board->options.uid[1];
    case 0x1fff7a18u:
        return board->options.uid[2];
    case 0x1fff7a20u: /* flash size in KiB is the upper half: address ...22 */
        return (HIL_FLASH_SIZE / 1024u) << 16 | 0xffffu;
    case 0x1fffc000u:
    case 0x1fffc004u:
    case 0x1fffc008u:
    case 0x1fffc00cu:
        return hil_flash_option_word(board, (address & 0xcu) / 4u);
    default:
        if (address - 0x1fff7800u < 0x210u) /* one-time area with its locks: factory new */
            return 0xffffffffu;
        return hil_bus_no_register(board);
    }
}

static bool clock_is_on(struct hil_board *board, const struct peripheral *p)
{
    if (hil_rcc_enabled(board, p->clock, p->clock_bit))
        return true;
    stop(board, "clock of the peripheral is off:", NULL);
    return false;
}

static uint32_t bit_band_target(uint32_t address, unsigned *bit)
{
    uint32_t base = (address & 0xf0000000u);
    uint32_t offset = address & 0x01ffffffu;
    *bit = offset >> 2 & 7u;
    return base + (offset >> 5);
}

static uint32_t bit_band_read(struct hil_board *board, uint32_t address)
{
    unsigned bit;
    uint32_t target = bit_band_target(address, &bit);
    const uint8_t *memory = hil_board_memory(board, target, 1, false);
    if (memory)
        return *memory >> bit & 1u;
    return hil_bus_read(board, target & ~3u, 4) >> (8u * (target & 3u) + bit) & 1u;
}

static void bit_band_write(struct hil_board *board, uint32_t address, uint32_t value)
{
    unsigned bit;
    uint32_t target = bit_band_target(address, &bit);
    uint8_t *memory = hil_board_memory(board, target, 1, true);
    if (memory) {
        *memory = (uint8_t)((*memory & ~(1u << bit)) | (value & 1u) << bit);
        return;
    }
    uint32_t mask = 1u << (8u * (target & 3u) + bit);
    uint32_t word = hil_bus_read(board, target & ~3u, 4);
    hil_bus_write(board, target & ~3u, 4, (value & 1u) ? word | mask : word & ~mask);
}

/* What a narrow write leaves in the rest of the word: the register's own bits in GPIO, nothing in
 * registers where a written 0 means nothing (BSRR) or that are no wider (USART). */
static uint32_t other_lanes(struct hil_board *board, const struct peripheral *p, uint32_t offset)
{
    return p->write == hil_gpio_write && offset != HIL_GPIO_BSRR ? p->read(board, p->unit, offset) : 0;
}

uint32_t hil_bus_read(struct hil_board *board, uint32_t address, unsigned size)
{
    if (address - 0x22000000u < 0x02000000u || address - 0x42000000u < 0x02000000u)
        return bit_band_read(board, address);
    board->access = (struct hil_access){address, size, false};
    if (address - 0x40000000u < 0x00080000u) {
        const struct peripheral *p = find(board, address);
        if (!p)
            return hil_bus_no_register(board);
        if (!clock_is_on(board, p) || !is_modelled(board, p, (address - p->base) & ~3u, false, 0))
            return 0;
        return lane(p->read(board, p->unit, (address - p->base) & ~3u), address, size);
    }
    if ((address & ~0xfffu) == 0xe000e000u
        && !is_core_modelled(board, address & 0xffcu, false, 0))
        return 0;
    if (address - 0xe0000000u < 0x00100000u)
        return hil_scb_read(board, address, size);
    if (address - 0x1fff0000u < 0x00010000u)
        return lane(read_system_memory(board, address), address, size);
    return hil_bus_no_register(board);
}

void hil_bus_write(struct hil_board *board, uint32_t address, unsigned size, uint32_t value)
{
    if (address - 0x22000000u < 0x02000000u || address - 0x42000000u < 0x02000000u) {
        bit_band_write(board, address, value);
        return;
    }
    board->access = (struct hil_access){address, size, true};
    if (address - 0x40000000u < 0x00080000u) {
        const struct peripheral *p = find(board, address);
        if (!p) {
            hil_bus_no_register(board);
            return;
        }
        if (!clock_is_on(board, p))
            return;
        uint32_t offset = address - p->base;
        if (size == 4 && !(offset & 3u)) {
            if (!is_modelled(board, p, offset, true, value))
                return;
            p->write(board, p->unit, offset, value);
            return;
        }
        if (!p->narrow) {
            hil_bus_refuse(board, "this register is only modelled for word writes");
            return;
        }
        uint32_t mask = (size == 1 ? 0xffu : 0xffffu) << (8u * (offset & 3u));
        uint32_t shifted = value << (8u * (offset & 3u)) & mask;
        uint32_t rest = other_lanes(board, p, offset & ~3u) & ~mask;
        if (!is_modelled(board, p, offset & ~3u, true, rest | shifted))
            return;
        p->write(board, p->unit, offset & ~3u, rest | shifted);
        return;
    }
    if ((address & ~0xfffu) == 0xe000e000u && size == 4 && !(address & 3u)
        && !is_core_modelled(board, address & 0xffcu, true, value))
        return;
    if (address - 0xe0000000u < 0x00100000u) {
        hil_scb_write(board, address, size, value);
        return;
    }
    hil_bus_no_register(board);
}
