/* Register layouts against two sources that neither firmware nor emulator was written from
 * (tests/conformance/registers.txt, and st.txt, which st.py makes of ST's own header): every
 * register, bit and interrupt number in the drivers' header, and what the emulated board has at
 * those addresses. */
#include <ctype.h>
#include <inttypes.h>

#include "hil/board/board.h"
#include "hil/core/bus.h"
#include "hil/core/cpu.h"
#include "tests/hil/bench.h"

/* The header casts addresses of a 32-bit chip; nothing is read through them here. */
#pragma GCC diagnostic ignored "-Wint-to-pointer-cast"
#include "firmware/f407/regs.h"

#define FACTS_MAX 1000

struct fact {
    char kind[8], name[40];
    uint32_t value;
    bool st; /* of st.txt */
};

static struct fact facts[FACTS_MAX];
static size_t fact_count;

static void read_table(const char *path, bool st)
{
    char line[200], kind[8], a[40], b[40];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        struct fact *fact = &facts[fact_count];
        if (line[0] == '#' || line[0] == '\n')
            continue;
        assert_true(fact_count < FACTS_MAX);
        if (sscanf(line, "%7s %39s %39s", kind, a, b) != 3)
            fail_msg("%s: %s", path, line);
        fact->st = st;
        bool offset = strcmp(kind, "offset") == 0;
        memcpy(fact->kind, kind, sizeof kind);
        if (offset)
            snprintf(fact->name, sizeof fact->name, "%.18s.%.18s", a, b);
        else
            memcpy(fact->name, a, sizeof a);
        if (strcmp(kind, "own") != 0 &&
            sscanf(line, offset ? "%*s %*s %*s %" SCNi32 : "%*s %*s %" SCNi32,
                   (int32_t *)&fact->value) != 1)
            fail_msg("%s: %s", path, line);
        fact_count++;
    }
    fclose(file);
}

static int read_facts(void **state)
{
    (void)state;
    read_table("tests/conformance/registers.txt", false);
    read_table("tests/conformance/st.txt", true);
    assert_true(fact_count > 500);
    return 0;
}

static struct fact *find_of(bool st, const char *kind, const char *name)
{
    for (size_t i = 0; i < fact_count; i++) {
        if (facts[i].st == st && strcmp(facts[i].kind, kind) == 0 &&
            strcmp(facts[i].name, name) == 0)
            return &facts[i];
    }
    return NULL;
}

static struct fact *find(const char *kind, const char *name)
{
    return find_of(false, kind, name);
}

static uint32_t value_of(const char *kind, const char *name)
{
    const struct fact *fact = find(kind, name);
    if (!fact)
        fail_msg("registers.txt has no %s %s", kind, name);
    return fact->value;
}

static unsigned compared, compared_st, different;

static void compare(const char *kind, const char *name, uint32_t firmware)
{
    const struct fact *fact = find(kind, name), *st = find_of(true, kind, name);
    compared++;
    compared_st += st != NULL;
    if (st && st->value != firmware) {
        different++;
        print_error("%s %s is 0x%x in regs.h and 0x%x in ST's header\n", kind, name,
                    (unsigned)firmware, (unsigned)st->value);
    }
    if (!fact && (st || find("own", name)))
        return;
    if (!fact) {
        different++;
        print_error("registers.txt has no %s %s (0x%x in regs.h): add it from the source it names, "
                    "or as `own` with a reason\n",
                    kind, name, (unsigned)firmware);
    } else if (fact->value != firmware) {
        different++;
        print_error("%s %s is 0x%x in regs.h and 0x%x in registers.txt\n", kind, name,
                    (unsigned)firmware, (unsigned)fact->value);
    }
}

/* An address if it is known as one, else bits. */
static void compare_number(const char *name, uint32_t firmware)
{
    compare(find("base", name) ? "base" : "bits", name, firmware);
}

/* can_regs.MCR is CAN.MCR, dma_stream_regs.CR is DMA_STREAM.CR. */
static void compare_field(const char *type, const char *name, size_t offset)
{
    char full[80];
    size_t n = strlen(type) - strlen("_regs");
    for (size_t i = 0; i < n; i++)
        full[i] = (char)toupper((unsigned char)type[i]);
    snprintf(full + n, sizeof full - n, ".%s", name);
    compare("offset", full, (uint32_t)offset);
}

TEST(the_drivers_have_the_same_layouts)
{
    compared = compared_st = different = 0;
#define ADDRESS(what) ((uint32_t)(uintptr_t)(what))
#define LVALUE(name)  compare_number(#name, ADDRESS(&name));
#define NUMBER(name)  compare_number(#name, ADDRESS(name));
#define MACRO(name)
#define FIELD(type, name) compare_field(#type, #name, offsetof(struct type, name));
#define IRQ(name)         compare("irq", &(#name)[strlen("IRQ_")], (uint32_t)name);
#include "registers.inc"
    compare("offset", "DMA.stream", offsetof(struct dma_regs, stream));
    compare("offset", "DMA_STREAM.size", sizeof(struct dma_stream_regs));
    compare("offset", "CAN.tx", offsetof(struct can_regs, tx));
    compare("offset", "CAN.rx", offsetof(struct can_regs, rx));
    compare("offset", "CAN.filter", offsetof(struct can_regs, filter));
    compare("bits", "DMA_CR_PRIORITY(1)", DMA_CR_PRIORITY(1));
    compare("bits", "DMA_CR_PRIORITY(3)", DMA_CR_PRIORITY(3));
    compare("bits", "DMA_CR_CHANNEL(1)", DMA_CR_CHANNEL(1));
    compare("bits", "DMA_CR_CHANNEL(7)", DMA_CR_CHANNEL(7));
    compare("bits", "CAN_TSR_RQCP(0)", CAN_TSR_RQCP(0));
    compare("bits", "CAN_TSR_RQCP(1)", CAN_TSR_RQCP(1));
    compare("bits", "CAN_TSR_RQCP(2)", CAN_TSR_RQCP(2));
    print_message("# %u definitions of the drivers compared, %u with ST's header too\n", compared,
                  compared_st);
    assert_int_equal(different, 0);
    assert_true(compared > 190 && compared_st > 250);
}

/* ---- the emulated board ---- */

static struct hil_board *board;

static uint32_t at(const char *peripheral, const char *kind, const char *name)
{
    char full[80];
    snprintf(full, sizeof full, "%s.%s", kind, name);
    return value_of("base", peripheral) + value_of("offset", full);
}

static uint32_t get(uint32_t address)
{
    uint32_t value = hil_bus_read(&board->core, address, 4);
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_US);
    return value;
}

static void set(uint32_t address, uint32_t value)
{
    hil_bus_write(&board->core, address, 4, value);
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_US);
}

/* A board whose program sleeps, with the clock of everything on. */
static int wake(void **state)
{
    (void)state;
    static const uint16_t loop[] = {0xbf30, 0xe7fd}; /* wfi; b . - 2 */
    static const uint32_t vectors[] = {0x20010000u, 0x08000101u};
    board = bench_board("wild", NULL); /* any image: the loop takes its place */
    assert_int_equal(hil_board_poke(board, 0x08000000u, vectors, sizeof vectors), MR_OK);
    assert_int_equal(hil_board_poke(board, 0x08000100u, loop, sizeof loop), MR_OK);
    hil_cpu_reset(&board->core);
    set(at("RCC", "RCC", "AHB1ENR"), value_of("bits", "RCC_AHB1ENR_GPIO_A_TO_F") |
                                         value_of("bits", "RCC_AHB1ENR_DMA1") |
                                         value_of("bits", "RCC_AHB1ENR_DMA2"));
    set(at("RCC", "RCC", "APB1ENR"),
        value_of("bits", "RCC_APB1ENR_TIM2") | value_of("bits", "RCC_APB1ENR_TIM4") |
            value_of("bits", "RCC_APB1ENR_I2C1") | value_of("bits", "RCC_APB1ENR_CAN1") |
            value_of("bits", "RCC_APB1ENR_PWR"));
    set(at("RCC", "RCC", "APB2ENR"), value_of("bits", "RCC_APB2ENR_USART1") |
                                         value_of("bits", "RCC_APB2ENR_ADC1") |
                                         value_of("bits", "RCC_APB2ENR_ADC3"));
    assert_string_equal(hil_board_failure_reason(board), "");
    return 0;
}

static int put_away(void **state)
{
    (void)state;
    hil_board_destroy(board);
    return 0;
}

/* Registers of the modelled peripherals that are there to be read: all but these. */
TEST_IN(every_register_is_where_it_should_be, wake, put_away)
{
    static const struct {
        const char *base, *kind;
    } units[] = {{"RCC", "RCC"},      {"GPIOA", "GPIO"}, {"GPIOF", "GPIO"}, {"TIM2", "TIM"},
                 {"TIM4", "TIM"},     {"ADC1", "ADC"},   {"ADC3", "ADC"},   {"CAN1", "CAN"},
                 {"USART1", "USART"}, {"IWDG", "IWDG"},  {"PWR", "PWR"},    {"I2C1", "I2C"}};
    /* write-only, structs, or refused by name: backup domain, pin locks, injected channels, smart
     * card */
    static const char *const without[] = {"RCC.BDCR", "GPIO.BSRR",  "GPIO.LCKR",
                                          "ADC.JOFR", "ADC.JDR",    "CAN.tx",
                                          "CAN.rx",   "CAN.filter", "USART.GTPR"};
    unsigned read = 0;
    for (size_t u = 0; u < sizeof units / sizeof units[0]; u++) {
        size_t n = strlen(units[u].kind);
        for (size_t i = 0; i < fact_count; i++) {
            bool skip = strcmp(facts[i].kind, "offset") != 0 ||
                        strncmp(facts[i].name, units[u].kind, n) != 0 || facts[i].name[n] != '.';
            for (size_t k = 0; k < sizeof without / sizeof without[0]; k++)
                skip = skip || strcmp(facts[i].name, without[k]) == 0;
            if (skip)
                continue;
            (void)get(value_of("base", units[u].base) + facts[i].value);
            if (hil_board_failure_reason(board)[0])
                fail_msg("%s of %s: %s", facts[i].name, units[u].base,
                         hil_board_failure_reason(board));
            read++;
        }
    }
    print_message("# %u registers of the emulated board read\n", read);
    assert_true(read > 100);
}

TEST_IN(what_is_reserved_stops_the_board, wake, put_away)
{
    (void)get(value_of("base", "RCC") + 0x1c);
    assert_non_null(
        strstr(hil_board_failure_reason(board), "unmodelled read of 4 bytes at 0x4002381c"));
}

/* What a register does when its bits are set as the table says. */
TEST_IN(bits_do_what_they_should, wake, put_away)
{
    uint32_t cr = at("RCC", "RCC", "CR"), odr = at("GPIOE", "GPIO", "ODR"),
             tim2 = value_of("base", "TIM2");
    assert_int_equal(
        get(cr) & (value_of("bits", "RCC_CR_HSION") | value_of("bits", "RCC_CR_HSIRDY")), 3);
    set(cr, get(cr) | value_of("bits", "RCC_CR_HSEON"));
    hil_board_run_until(board, hil_board_now_ps(board) + 20 * HIL_PS_PER_MS);
    assert_true(get(cr) & value_of("bits", "RCC_CR_HSERDY"));
    set(cr, get(cr) | value_of("bits", "RCC_CR_PLLON"));
    hil_board_run_until(board, hil_board_now_ps(board) + 20 * HIL_PS_PER_MS);
    assert_true(get(cr) & value_of("bits", "RCC_CR_PLLRDY"));
    assert_true(get(at("RCC", "RCC", "CSR")) & value_of("bits", "RCC_CSR_PORRSTF"));
    set(at("RCC", "RCC", "CSR"), value_of("bits", "RCC_CSR_RMVF"));
    assert_int_equal(get(at("RCC", "RCC", "CSR")) & 0xfe000000u, 0);

    set(at("GPIOE", "GPIO", "MODER"), 1);
    set(at("GPIOE", "GPIO", "BSRR"), 1);
    assert_int_equal(get(odr), 1);
    assert_int_equal(get(at("GPIOE", "GPIO", "IDR")) & 1u, 1);
    assert_true(hil_board_pin_level(board, 4, 0));
    set(at("GPIOE", "GPIO", "BSRR"), 0x10000);
    assert_int_equal(get(odr), 0);

    set(tim2 + value_of("offset", "TIM.ARR"), 99);
    set(tim2 + value_of("offset", "TIM.EGR"), value_of("bits", "TIM_EGR_UG"));
    assert_true(get(tim2 + value_of("offset", "TIM.SR")) & value_of("bits", "TIM_SR_UIF"));
    set(tim2 + value_of("offset", "TIM.SR"), 0);
    set(tim2 + value_of("offset", "TIM.CR1"), value_of("bits", "TIM_CR1_CEN"));
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_MS);
    assert_true(get(tim2 + value_of("offset", "TIM.SR")) & value_of("bits", "TIM_SR_UIF"));
    assert_in_range(get(tim2 + value_of("offset", "TIM.CNT")), 0, 99);

    set(at("I2C1", "I2C", "CR2"), 16);
    set(at("I2C1", "I2C", "CCR"), 80);
    set(at("I2C1", "I2C", "TRISE"), 17); /* 1,000 ns at 16 MHz */
    set(at("GPIOB", "GPIO", "AFR"), 0x44000000);
    set(at("GPIOB", "GPIO", "MODER"), 0xa000);
    set(at("I2C1", "I2C", "CR1"), value_of("bits", "I2C_CR1_PE"));
    set(at("I2C1", "I2C", "CR1"),
        value_of("bits", "I2C_CR1_PE") | value_of("bits", "I2C_CR1_START"));
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_MS);
    assert_int_equal(get(at("I2C1", "I2C", "SR1")), value_of("bits", "I2C_SR1_SB"));
    assert_int_equal(get(at("I2C1", "I2C", "SR2")),
                     value_of("bits", "I2C_SR2_MSL") | value_of("bits", "I2C_SR2_BUSY"));
    set(at("I2C1", "I2C", "CR1"), value_of("bits", "I2C_CR1_SWRST"));
    assert_int_equal(get(at("I2C1", "I2C", "SR2")), 0);

    assert_int_equal(get(at("USART1", "USART", "SR")),
                     value_of("bits", "USART_SR_TXE") | value_of("bits", "USART_SR_TC"));

    set(at("CAN1", "CAN", "MCR"), value_of("bits", "CAN_MCR_INRQ"));
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_MS);
    assert_int_equal(get(at("CAN1", "CAN", "MSR")) &
                         (value_of("bits", "CAN_MSR_INAK") | value_of("bits", "CAN_MSR_SLAK")),
                     value_of("bits", "CAN_MSR_INAK"));
    assert_int_equal(get(at("CAN1", "CAN", "TSR")) & 0x1c000000u,
                     value_of("bits", "CAN_TSR_TME(0)") | value_of("bits", "CAN_TSR_TME(1)") |
                         value_of("bits", "CAN_TSR_TME(2)"));
    assert_string_equal(hil_board_failure_reason(board), "");
}

/* ADC3 converts one input, DMA2 stream 1 carries it, the flag comes where the table says. */
TEST_IN(converter_and_dma, wake, put_away)
{
    uint32_t stream = value_of("base", "DMA2") + value_of("offset", "DMA.stream") +
                      value_of("offset", "DMA_STREAM.size");
    uint16_t code = 0xffff;
    assert_int_equal(hil_board_poke(board, 0x20000100u, &code, 2), MR_OK);
    set(stream + value_of("offset", "DMA_STREAM.PAR"), at("ADC3", "ADC", "DR"));
    set(stream + value_of("offset", "DMA_STREAM.M0AR"), 0x20000100u);
    set(stream + value_of("offset", "DMA_STREAM.NDTR"), 1);
    set(stream + value_of("offset", "DMA_STREAM.CR"),
        2 * value_of("bits", "DMA_CR_CHANNEL(1)") | value_of("bits", "DMA_CR_PSIZE_16") |
            value_of("bits", "DMA_CR_MSIZE_16") | value_of("bits", "DMA_CR_EN"));
    set(at("ADC3", "ADC", "SQR3"), 9);
    set(at("ADC3", "ADC", "CR2"),
        value_of("bits", "ADC_CR2_ADON") | value_of("bits", "ADC_CR2_DMA"));
    set(at("ADC3", "ADC", "CR2"), value_of("bits", "ADC_CR2_ADON") |
                                      value_of("bits", "ADC_CR2_DMA") |
                                      value_of("bits", "ADC_CR2_SWSTART"));
    hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_MS);
    assert_int_equal(hil_board_peek(board, 0x20000100u, &code, 2), MR_OK);
    assert_in_range(code, 0, 4095);
    assert_int_equal(get(stream + value_of("offset", "DMA_STREAM.NDTR")), 0);
    assert_true(get(value_of("base", "DMA2") + value_of("offset", "DMA.ISR")) &
                value_of("bits", "DMA_FLAG_TCIF") << 6);
    assert_true(get(at("ADC3", "ADC", "SR")) & value_of("bits", "ADC_SR_STRT"));
    assert_string_equal(hil_board_failure_reason(board), "");
}

TESTS_BETWEEN(read_facts, NULL);
