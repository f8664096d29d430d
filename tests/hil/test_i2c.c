/* I2C1 and the thermometer behind it, register by register: sequences and flags of RM0090 27.3.3
 * (master, figures of transmission and of reception of one, two and more bytes), times from CCR
 * (27.6.8), and the TMP112's own table of readings (SBOS473, 12-bit format). */
#include <math.h>

#include "hil/board/board.h"
#include "hil/core/bus.h"
#include "hil/core/cpu.h"
#include "hil/periph/rules.h"
#include "hil/rig/faults.h"
#include "tests/hil/bench.h"

#define CR1    0x40005400u
#define CR2    0x40005404u
#define DR     0x40005410u
#define SR1    0x40005414u
#define SR2    0x40005418u
#define CCR    0x4000541cu
#define TRISE  0x40005420u
#define PORT_B 0x40020400u
enum { PE = 1, START = 1 << 8, STOP = 1 << 9, ACK = 1 << 10, POS = 1 << 11, SWRST = 1 << 15 };
enum { SB = 1, ADDR = 2, BTF = 4, RXNE = 0x40, TXE = 0x80, BERR = 0x100, ARLO = 0x200, AF = 0x400 };
enum { MSL = 1, BUSY = 2, TRA = 4 };
#define WRITE_48 0x90u
#define READ_48  0x91u

static struct hil_board *board;

static uint32_t get(uint32_t address)
{
    return hil_bus_read(&board->core, address, 4);
}
static void put(uint32_t address, uint32_t value)
{
    hil_bus_write(&board->core, address, 4, value);
}
static void pass_us(uint64_t us)
{
    (void)hil_board_run_until(board, hil_board_now_ps(board) + us * HIL_PS_PER_US);
}

/* Open-drain pins that are I2C1's, PCLK1 16 MHz (HSI), 100 kHz: CCR 80. */
static void configure_i2c(void)
{
    put(PORT_B + 0x04, 0xc0);
    put(PORT_B + 0x20, 0x44000000);
    put(PORT_B, (0x280u & ~0xf000u) | 0xa000u);
    put(CR2, 16);
    put(CCR, 80);
    put(TRISE, 17);
    put(CR1, PE);
}

static struct hil_board *sleeping(double temperature_c)
{
    static const uint16_t loop[] = {0xbf30, 0xe7fd}; /* wfi; b . - 2 */
    static const uint32_t vectors[] = {0x20010000u, 0x08000101u};
    struct hil_options options;
    hil_options_default(&options);
    options.temperature_c = temperature_c;
    options.cell_times = HIL_TIMES_TYPICAL;
    /* the times that these tests work out are those of 100 kHz */
    options.counted_rules = 1u << HIL_RULE_REPEATED_START;
    board = bench_board("wild", &options);
    assert_int_equal(hil_board_poke(board, 0x08000000u, vectors, sizeof vectors), MR_OK);
    assert_int_equal(hil_board_poke(board, 0x08000100u, loop, sizeof loop), MR_OK);
    hil_cpu_reset(&board->core);
    put(0x40023830u, get(0x40023830u) | 2u);
    put(0x40023840u, get(0x40023840u) | 1u << 21);
    configure_i2c();
    return board;
}

static int wake(void **state)
{
    (void)state;
    sleeping(25.0);
    pass_us(100000);
    return 0;
}

static int put_away(void **state)
{
    (void)state;
    hil_board_destroy(board);
    return 0;
}

static void is_flag(uint32_t flags, uint32_t sr2)
{
    uint32_t sr1 = get(SR1);
    if ((sr1 & 0xdf4fu) != (flags & ~(uint32_t)TXE))
        fail_msg("SR1 0x%x, not 0x%x: %s", (unsigned)sr1, (unsigned)flags,
                 hil_board_failure_reason(board));
    assert_int_equal(get(SR2) & 7u, sr2);
}

static void start_and_address(uint8_t byte, uint32_t flag)
{
    put(CR1, get(CR1) | START);
    pass_us(15);
    is_flag(SB, MSL | BUSY);
    put(DR, byte);
    pass_us(85); /* nine periods of 10 us are not over */
    assert_int_equal(get(SR1) & (SB | flag), 0);
    pass_us(10);
    assert_int_equal(get(SR1) & (SB | ADDR | AF), flag);
}

static void stop(void)
{
    put(CR1, get(CR1) | STOP);
    pass_us(15);
    assert_int_equal(get(CR1) & STOP, 0);
    assert_int_equal(get(SR2) & 7u, 0);
}

static void send(const uint8_t *bytes, unsigned n)
{
    start_and_address(WRITE_48, ADDR);
    assert_int_equal(get(SR2) & 7u, MSL | BUSY | TRA);
    assert_int_equal(get(SR1) & (ADDR | TXE), TXE);
    for (unsigned i = 0; i < n; i++) {
        put(DR, bytes[i]);
        assert_int_equal(get(SR1) & (BTF | TXE), TXE); /* it is in the shift register */
        pass_us(95);
        assert_int_equal(get(SR1) & (BTF | TXE | AF), BTF | TXE);
    }
}

/* Two bytes by the manual's method: POS before, ACK off before ADDR is cleared, both read at
 * BTF. */
static uint16_t receive_two(void)
{
    put(CR1, get(CR1) | ACK | POS);
    start_and_address(READ_48, ADDR);
    put(CR1, get(CR1) & ~(uint32_t)ACK);
    assert_int_equal(get(SR2) & 7u, MSL | BUSY);
    pass_us(95);
    assert_int_equal(get(SR1) & (RXNE | BTF), RXNE);
    pass_us(95);
    assert_int_equal(get(SR1) & (RXNE | BTF), RXNE | BTF);
    put(CR1, get(CR1) | STOP);
    uint32_t first = get(DR);
    uint32_t second = get(DR);
    pass_us(15);
    assert_int_equal(get(SR1) & (RXNE | BTF), 0);
    assert_int_equal(get(SR2) & 7u, 0);
    put(CR1, PE);
    return (uint16_t)(first << 8 | second);
}

static uint16_t read_register(uint8_t pointer)
{
    send(&pointer, 1);
    return receive_two(); /* begins with a repeated start */
}

/* SBOS473, 12-bit temperature data format. */
static const struct {
    double temperature_c;
    uint16_t counts;
} format[] = {{128.0, 0x7ff},   {127.9375, 0x7ff}, {100.0, 0x640}, {80.0, 0x500},   {75.0, 0x4b0},
              {50.0, 0x320},    {25.0, 0x190},     {0.25, 0x004},  {0.0625, 0x001}, {0.0, 0x000},
              {-0.0625, 0xfff}, {-0.25, 0xffc},    {-25.0, 0xe70}, {-55.0, 0xc90}};

TEST(readings_are_the_data_sheets)
{
    for (size_t i = 0; i < sizeof format / sizeof format[0]; i++) {
        sleeping(format[i].temperature_c);
        pass_us(27000);
        assert_int_equal(read_register(0), format[i].counts << 4);
        hil_board_destroy(board);
    }
}

TEST(it_reads_zero_until_the_first_conversion)
{
    sleeping(25.0);
    assert_int_equal(read_register(1), 0x60a0); /* power-up value */
    assert_int_equal(read_register(0), 0);
    pass_us(26000);
    assert_int_equal(read_register(0), 0x1900);
    hil_board_destroy(board);
}

TEST_IN(one_shot, wake, put_away)
{
    static const uint8_t shut_down[] = {1, 0x61, 0xa0}, once[] = {1, 0xe1, 0xa0};
    send(shut_down, 3);
    stop();
    board->options.temperature_c = -10.0;
    pass_us(500000); /* nothing converts */
    assert_int_equal(read_register(0), 0x1900);
    send(once, 3);
    stop();
    assert_int_equal(read_register(1), 0x61a0);
    pass_us(27000);
    assert_int_equal(read_register(1), 0xe1a0);
    assert_int_equal(read_register(0), 0xf600);
}

TEST_IN(nobody_answers_elsewhere, wake, put_away)
{
    start_and_address(0x49u << 1, AF);
    assert_int_equal(get(SR2) & 7u, MSL | BUSY | TRA);
    put(SR1, ~(uint32_t)AF);
    assert_int_equal(get(SR1) & AF, 0);
    stop();
    start_and_address(WRITE_48, ADDR);
    (void)get(SR2);
    stop();
    assert_string_equal(hil_board_failure_reason(board), "");
}

TEST_IN(one_byte_and_three, wake, put_away)
{
    uint8_t pointer = 2;
    send(&pointer, 1);
    start_and_address(READ_48, ADDR); /* ACK is off */
    (void)get(SR2);
    put(CR1, get(CR1) | STOP);
    pass_us(110);
    assert_int_equal(get(SR1) & (RXNE | BTF), RXNE);
    assert_int_equal(get(SR2) & 7u, 0);
    assert_int_equal(get(DR), 0x4b); /* low limit, 75 C */

    put(CR1, PE | ACK);
    start_and_address(READ_48, ADDR);
    (void)get(SR2);
    pass_us(185); /* two bytes: the clock waits */
    assert_int_equal(get(SR1) & (RXNE | BTF), RXNE | BTF);
    pass_us(1000);
    put(CR1, PE);
    assert_int_equal(get(DR), 0x4b);
    put(CR1, PE | STOP);
    assert_int_equal(get(DR), 0x00);
    pass_us(110);
    assert_int_equal(get(SR1) & (RXNE | BTF), RXNE);
    assert_int_equal(get(DR), 0x4b); /* its two bytes over again */
    assert_int_equal(get(SR2) & 7u, 0);
    assert_string_equal(hil_board_failure_reason(board), "");
}

static void fault(enum hil_thermometer_fault choice, uint64_t duration_ps)
{
    struct hil_fault f = {.trigger = HIL_TRIGGER_TIME,
                          .trigger_ps = hil_board_now_ps(board),
                          .action = HIL_FAULT_THERMOMETER,
                          .variant = choice,
                          .duration_ps = duration_ps};
    assert_int_equal(hil_faults_add(&board->faults, &f), MR_OK);
    pass_us(1);
}

TEST_IN(it_is_dead, wake, put_away)
{
    fault(HIL_THERMOMETER_DEAD, 0);
    start_and_address(WRITE_48, AF);
    stop();
    fault(HIL_THERMOMETER_REPAIR, 0);
    pass_us(10);
    put(SR1, 0);
    assert_int_equal(read_register(0), 0x1900);
}

TEST_IN(a_stuck_line, wake, put_away)
{
    fault(HIL_THERMOMETER_STUCK, 0);
    assert_int_equal(get(SR2) & 7u, BUSY);
    assert_int_equal(get(PORT_B + 0x10) & 0xc0u, 0x40); /* SCL high, SDA low */
    put(CR1, PE | START);
    pass_us(1000);
    assert_int_equal(get(SR1) & SB, 0); /* waits for a free bus */
    put(CR1, SWRST);
    assert_int_equal(get(CR2), 0);
    put(CR1, 0);
    configure_i2c();
    assert_int_equal(get(SR2) & BUSY, BUSY);
    fault(HIL_THERMOMETER_REPAIR, 0); /* SDA rises while SCL is high: a stop */
    assert_int_equal(get(SR2) & BUSY, 0);
    assert_int_equal(read_register(0), 0x1900);

    start_and_address(WRITE_48, ADDR); /* in mid transfer: the first 1 is lost */
    (void)get(SR2);
    put(DR, 0x01);
    pass_us(20);
    fault(HIL_THERMOMETER_STUCK, 0);
    pass_us(100);
    assert_int_equal(get(SR1) & (ARLO | BTF | TXE), ARLO);
    assert_int_equal(get(SR2) & 7u, BUSY);
    assert_string_equal(hil_board_failure_reason(board), "");
}

/* As outputs: so many clocks, then a stop. */
static void bang(unsigned clocks)
{
    put(PORT_B + 0x18, 0xc0);
    put(PORT_B, (0x280u & ~0xf000u) | 0x5000u);
    for (unsigned i = 0; i < clocks; i++) {
        put(PORT_B + 0x18, 0x400000);
        put(PORT_B + 0x18, 0x40);
    }
    put(PORT_B + 0x18, 0x400000);
    put(PORT_B + 0x18, 0x800000);
    put(PORT_B + 0x18, 0x40);
    put(PORT_B + 0x18, 0x80);
}

TEST_IN(nine_clocks_free_a_chip_that_hangs, wake, put_away)
{
    fault(HIL_THERMOMETER_HANG, 0);
    bang(7); /* and the one of the stop */
    assert_int_equal(get(PORT_B + 0x10) & 0xc0u, 0x40);
    bang(0);
    assert_int_equal(get(PORT_B + 0x10) & 0xc0u, 0xc0);
    put(CR1, SWRST);
    put(CR1, 0);
    configure_i2c();
    assert_int_equal(get(SR2) & BUSY, 0);
    assert_int_equal(read_register(0), 0x1900);
}

/* A reset of the chip while it is being read leaves it in the middle of a byte: 0x19 is 00011001,
 * five bits of zeroes and ones to go. */
TEST_IN(a_reset_in_mid_byte_leaves_it_hanging, wake, put_away)
{
    uint8_t pointer = 0;
    send(&pointer, 1);
    put(CR1, PE | ACK);
    start_and_address(READ_48, ADDR);
    (void)get(SR2);
    pass_us(25);
    put(0x40023820u, 1u << 21);
    assert_int_equal(get(PORT_B + 0x10) & 0xc0u, 0x40);
    assert_int_equal(board->state.tmp112.bus_faults.clocks_until_release, 7);
    put(CR1, 0);
    configure_i2c();
    assert_int_equal(get(SR2) & BUSY, BUSY);
}

TEST_IN(a_clock_that_is_held, wake, put_away)
{
    fault(HIL_THERMOMETER_STRETCH, 3 * HIL_PS_PER_MS);
    put(CR1, PE | START);
    pass_us(15);
    put(DR, get(SR1) & SB ? WRITE_48 : 0);
    pass_us(3000);
    assert_int_equal(get(SR1) & ADDR, 0);
    pass_us(100);
    assert_int_equal(get(SR1) & ADDR, ADDR);
}

static void ends_the_run(const char *why)
{
    if (!strstr(hil_board_failure_reason(board), why))
        fail_msg("`%s`, not: %s", hil_board_failure_reason(board), why);
    board->core.is_stopped = false;
    board->core.failure_reason[0] = '\0';
}

TEST_IN(what_the_manual_forbids_ends_the_run, wake, put_away)
{
    put(CCR, 90);
    ends_the_run("only while PE is 0");
    put(CR1, PE | START);
    put(CR1, PE | START | ACK);
    ends_the_run("while START or STOP waits");
    pass_us(15);
    put(CR1, 0);
    ends_the_run("before the end of the communication");
    put(CR1, SWRST);
    put(CR1, 0);
    put(CR2, 42);
    put(CCR, 80);
    put(CR1, PE);
    ends_the_run("FREQ is not PCLK1");
    put(CR1, SWRST);
    put(CR1, 0);
    configure_i2c();
    put(CR1, 0);
    put(TRISE, 5); /* of fast mode */
    put(CR1, PE);
    ends_the_run("TRISE does not");
    (void)get(CR1 + 0x24);
    ends_the_run("I2C1 + 0x24");
}

/* 16 MHz / (2 CCR), or / (3 CCR) in fast mode. */
static void start_at(uint32_t ccr)
{
    put(CR1, SWRST);
    put(CR1, 0);
    configure_i2c();
    put(CR1, 0);
    put(CCR, ccr);
    put(TRISE, ccr & 1u << 15 ? 5 : 17); /* 300 or 1000 ns */
    put(CR1, PE);
    put(CR1, PE | START);
    pass_us(200);
}

static void a_repeated_start(uint32_t ccr)
{
    start_at(ccr);
    put(DR, WRITE_48);
    (void)get(SR1);
    put(DR, WRITE_48);
    pass_us(300);
    (void)get(SR1);
    (void)get(SR2);
    put(DR, 0);
    pass_us(300);
    put(CR1, PE | START);
    pass_us(30);
}

/* ES0182: 88 to 100 kHz in standard mode. TMP112: 400 kHz. */
TEST_IN(clocks_that_the_bus_does_not_allow_end_the_run, wake, put_away)
{
    static const struct {
        uint32_t ccr;
        const char *why; /* NULL: they do not */
    } cases[] = {
        {80, "rule REPEATED_START: a repeated start occurs too early"},
        {90, "SCL of 88.9 kHz"},
        {92, NULL},
        {100, NULL},
        {1u << 15 | 16u, NULL}, /* 333 kHz */
    };
    const struct hil_rule_tally *repeated = board->state.mcu.rules.tally + HIL_RULE_REPEATED_START;
    board->options.counted_rules = 0;
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint64_t judged = repeated->measurement_count;
        a_repeated_start(cases[i].ccr);
        assert_int_equal(repeated->measurement_count, judged + 1);
        if (cases[i].why)
            ends_the_run(cases[i].why);
        assert_string_equal(hil_board_failure_reason(board), "");
    }
    start_at(1u << 15 | 12u);
    ends_the_run(
        "rule SCL_PERIOD: period of SCL at the thermometer: measured 2250.0 ns, required 2500.0");
}
