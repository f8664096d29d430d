#include "hil/core/registers.h"

/* clang-format off */
#define REG_ROW(access, offset, count, stride, loose, name, reset, plain, action, status,        \
    partly, refused, what)                                                                       \
    {offset, count, stride, access, loose, #name, reset, plain, action, status, partly, refused, \
     what},
#define REG(access, offset, count, stride, name, ...) \
    REG_ROW(access, offset, count, stride, false, name, __VA_ARGS__)
#define LOOSE(access, offset, count, stride, name, ...) \
    REG_ROW(access, offset, count, stride, true, name, __VA_ARGS__)
#define SET(name, peripheral, base) static const struct hil_register name##_registers[] = {
#define END(name) };
/* clang-format on */
#include "hil/core/registers.def"
#undef REG
#undef LOOSE
#undef SET
#undef END

static const struct hil_register_set sets[] = {
#define REG(...)
#define LOOSE(...)
#define SET(name, peripheral, base) \
    {peripheral, base, name##_registers, sizeof name##_registers / sizeof name##_registers[0]},
#define END(name)
#include "hil/core/registers.def"
#undef REG
#undef LOOSE
#undef SET
#undef END
};

#define SETS (sizeof sets / sizeof sets[0])

/* Peripherals of the chip by RM0090 table 1, for the list of those that are not there at all. */
static const struct {
    const char *name;
    uint32_t base;
} chip[] = {
    {"TIM2", 0x40000000u},        {"TIM3", 0x40000400u},
    {"TIM4", 0x40000800u},        {"TIM5", 0x40000c00u},
    {"TIM6", 0x40001000u},        {"TIM7", 0x40001400u},
    {"TIM12", 0x40001800u},       {"TIM13", 0x40001c00u},
    {"TIM14", 0x40002000u},       {"RTC and backup registers", 0x40002800u},
    {"WWDG", 0x40002c00u},        {"IWDG", 0x40003000u},
    {"I2S2ext", 0x40003400u},     {"SPI2", 0x40003800u},
    {"SPI3", 0x40003c00u},        {"I2S3ext", 0x40004000u},
    {"USART2", 0x40004400u},      {"USART3", 0x40004800u},
    {"UART4", 0x40004c00u},       {"UART5", 0x40005000u},
    {"I2C1", 0x40005400u},        {"I2C2", 0x40005800u},
    {"I2C3", 0x40005c00u},        {"CAN1", 0x40006400u},
    {"CAN2", 0x40006800u},        {"PWR", 0x40007000u},
    {"DAC", 0x40007400u},         {"TIM1", 0x40010000u},
    {"TIM8", 0x40010400u},        {"USART1", 0x40011000u},
    {"USART6", 0x40011400u},      {"ADC", 0x40012000u},
    {"SDIO", 0x40012c00u},        {"SPI1", 0x40013000u},
    {"SYSCFG", 0x40013800u},      {"EXTI", 0x40013c00u},
    {"TIM9", 0x40014000u},        {"TIM10", 0x40014400u},
    {"TIM11", 0x40014800u},       {"CRC", 0x40023000u},
    {"backup SRAM", 0x40024000u}, {"Ethernet", 0x40028000u},
    {"USB OTG HS", 0x40040000u},  {"USB OTG FS", 0x50000000u},
    {"DCMI", 0x50050000u},        {"RNG", 0x50060800u},
    {"FSMC", 0xa0000000u},
};

/* What no register shows. The peripherals' headers say more. */
static const char *const behaviour[] = {
    "core: cycles; an instruction takes one (silicon differs by up to two), exception entry 12, "
    "return 10",
    "core: memory protection unit, ITM, ETM, breakpoints of the FPB, lazy stacking (registers are "
    "stacked at once)",
    "core: DIV_0_TRP; it is kept, but a division by zero gives 0",
    "core: imprecise bus faults (all are precise); late arrival of an exception during stacking",
    "DMA: FIFO, bursts, double buffers, priorities and bus load; a direct mode error cannot arise",
    "TIM: trigger and synchronisation delays of one or two timer clocks",
    "ADC: errors of gain and offset, crosstalk, source impedance; calibration of the stabilisation "
    "time",
    "CAN: two nodes, frames as a whole; resynchronisation is a limit of 1 % between the rates",
    "USART: edges on the pins; a rate more than 3 % off is garbage",
    "SPI: edges on the pins; the memory behind it is one W25Q",
    "I2C: edges on the pins; the chip behind it is one TMP112, which sees clocks, starts and stops "
    "of a program that drives the pins, no bytes",
    "IWDG: option for the hardware watchdog; LSI constant over a run",
    "RCC: CCM answers without its clock too",
    "RCC: a crystal that stops without clock security stops the clock (silicon's PLL drifts); HSE "
    "bypass",
    "PWR: stop and standby, voltage detector; a dip of the supply does not reach the converters",
};

const struct hil_register_set *hil_registers_all(size_t *count)
{
    *count = SETS;
    return sets;
}

const struct hil_register_set *hil_registers_of(uint32_t base)
{
    for (size_t i = 0; i < SETS; i++) {
        if (sets[i].base == base)
            return &sets[i];
    }
    return NULL;
}

const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset)
{
    for (size_t i = 0; i < set->count; i++) {
        const struct hil_register *r = &set->all[i];
        uint32_t from = offset - r->offset;
        if (offset >= r->offset && from % r->stride == 0 && from / r->stride < r->count)
            return r;
    }
    return NULL;
}

const char *hil_register_objection(const struct hil_register *r, uint32_t value)
{
    uint32_t changed = value ^ r->reset;
    if (r->access == 'r')
        return "the register is read-only: silicon ignores the write";
    if (changed & r->refused)
        return r->what;
    if (!r->loose && (changed & ~(r->plain | r->action | r->status | r->partly)))
        return "a reserved bit is changed: it must be kept at its reset value";
    return NULL;
}

void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct hil_register *r = hil_register_at(hil_registers_of(base),
                                                       offset + 4u * (uint32_t)i);
        word[i] = r ? r->reset : 0;
    }
}

static void print_bits(FILE *file, uint32_t bits)
{
    const char *between = "";
    for (unsigned bit = 32; bit-- > 0;) {
        unsigned low = bit;
        if (!(bits >> bit & 1u))
            continue;
        while (low && (bits >> (low - 1u) & 1u))
            low--;
        fprintf(file, low == bit ? "%s%u" : "%s%u:%u", between, bit, low);
        between = ",";
        bit = low;
    }
}

static void print_register(FILE *file, const struct hil_register *r)
{
    if (!(r->partly | r->refused))
        return;
    fprintf(file, "  %-10s +0x%03x ", r->name, r->offset);
    if (r->refused) {
        fputs(" refused ", file);
        print_bits(file, r->refused);
    }
    if (r->partly) {
        fputs(" in part ", file);
        print_bits(file, r->partly);
    }
    fprintf(file, ": %s\n", r->what);
}

void hil_registers_print(FILE *file)
{
    fputs("Not modelled: an access ends the run with its address and PC.\nPeripherals:", file);
    const char *between = " ";
    for (size_t i = 0; i < sizeof chip / sizeof chip[0]; i++) {
        if (hil_registers_of(chip[i].base))
            continue;
        fprintf(file, "%s%s", between, chip[i].name);
        between = ", ";
    }
    fputs("\nRegisters and bits (registers of these peripherals that are not in "
          "hil/core/registers.def likewise):\n",
          file);
    for (size_t i = 0; i < SETS; i++) {
        fprintf(file, "%s, %zu kinds of registers modelled\n", sets[i].peripheral, sets[i].count);
        for (size_t k = 0; k < sets[i].count; k++)
            print_register(file, &sets[i].all[k]);
    }
    fputs("Behaviour:\n", file);
    for (size_t i = 0; i < sizeof behaviour / sizeof behaviour[0]; i++)
        fprintf(file, "  %s\n", behaviour[i]);
}
