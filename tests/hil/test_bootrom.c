/* The boot ROM over the emulated line: AN3155 as a host speaks it. What the chip must answer is in
 * the note's tables; version 0x31, chip id 0x413, bytes 8E1, ACK 0x79, NACK 0x1F. */
#include "hil/board/board.h"
#include "tests/hil/bench.h"

#include "common/command.h"

#define ACK      0x79
#define NACK     0x1f
#define FLASH    0x08000000u
#define SECTOR_1 0x08004000u

struct host {
    struct hil_board *board;
    uint8_t bytes[512];
    size_t count, taken;
};

static void hear(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct host *host = ctx;
    (void)t_ps;
    for (size_t i = 0; i < n && host->count < sizeof host->bytes; i++)
        host->bytes[host->count++] = bytes[i];
}

static void wait_ps(struct host *host, uint64_t t_ps)
{
    bench_run(host->board, hil_board_now_ps(host->board) + t_ps);
}

static void send(struct host *host, const uint8_t *bytes, size_t n)
{
    host->count = host->taken = 0;
    assert_int_equal(hil_usart_inject(&host->board->mcu.usart, bytes, n), MR_OK);
}

/* Next byte from the chip within a time; -1: none. */
static int next_within(struct host *host, uint64_t limit_ms)
{
    for (uint64_t us = 0; us < limit_ms * 1000 && host->taken == host->count; us += 200)
        wait_ps(host, 200 * HIL_PS_PER_US);
    return host->taken < host->count ? host->bytes[host->taken++] : -1;
}

static int next(struct host *host)
{
    return next_within(host, 100);
}

/* Bytes with their XOR behind (a single byte: its complement). */
static int checked(struct host *host, const uint8_t *bytes, size_t n, uint64_t limit_ms)
{
    uint8_t out[300], sum = n == 1 ? 0xff : 0;
    for (size_t i = 0; i < n; i++)
        sum ^= out[i] = bytes[i];
    out[n] = sum;
    send(host, out, n + 1);
    return next_within(host, limit_ms);
}

static int command(struct host *host, uint8_t code)
{
    return checked(host, &code, 1, 100);
}

static int address(struct host *host, uint32_t at)
{
    const uint8_t bytes[4] = {(uint8_t)(at >> 24), (uint8_t)(at >> 16), (uint8_t)(at >> 8),
                              (uint8_t)at};
    return checked(host, bytes, 4, 100);
}

static int write_memory(struct host *host, uint32_t at, const uint8_t *data, size_t n)
{
    uint8_t bytes[257];
    if (command(host, 0x31) != ACK)
        return -2;
    int answer = address(host, at);
    if (answer != ACK)
        return answer;
    bytes[0] = (uint8_t)(n - 1);
    memcpy(bytes + 1, data, n);
    return checked(host, bytes, n + 1, 1000);
}

static int read_memory(struct host *host, uint32_t at, uint8_t *data, size_t n)
{
    if (command(host, 0x11) != ACK)
        return -2;
    int answer = address(host, at);
    if (answer != ACK)
        return answer;
    answer = command(host, (uint8_t)(n - 1));
    for (size_t i = 0; answer == ACK && i < n; i++) {
        int byte = next(host);
        assert_true(byte >= 0);
        data[i] = (uint8_t)byte;
    }
    return answer;
}

static int erase(struct host *host, const uint8_t *list, size_t n)
{
    if (command(host, 0x44) != ACK)
        return -2;
    return checked(host, list, n, 40000);
}

static void sync_host(struct host *host)
{
    static const uint8_t sync = 0x7f;
    send(host, &sync, 1);
    assert_int_equal(next(host), ACK);
}

static struct host *chip(const char *image, uint32_t baud, enum hil_parity parity)
{
    struct host *host = calloc(1, sizeof *host);
    struct hil_options options;
    hil_options_default(&options);
    options.cell_times = HIL_TIMES_TYPICAL;
    options.is_boot0_high = true;
    options.host_baud = baud;
    options.host_parity = parity;
    host->board = image ? bench_board(image, &options) : hil_board_create(&options);
    struct hil_callbacks callbacks = {host, NULL, hear};
    hil_board_set_callbacks(host->board, &callbacks);
    wait_ps(host, HIL_PS_PER_MS);
    return host;
}

static struct host *chip_ready(const char *image)
{
    struct host *host = chip(image, 115200, HIL_PARITY_EVEN);
    sync_host(host);
    return host;
}

static void done(struct host *host)
{
    hil_board_destroy(host->board);
    free(host);
}

static void expect(struct host *host, const char *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        assert_int_equal(next(host), (uint8_t)bytes[i]);
    assert_int_equal(next_within(host, 2), -1);
}

TEST(test_identity)
{
    struct host *host = chip_ready(NULL);
    assert_int_equal(command(host, 0x00), ACK);
    expect(host, "\x09\x31\x00\x01\x02\x11\x21\x31\x44\x82\x92\x79", 12);
    assert_int_equal(command(host, 0x01), ACK);
    expect(host, "\x31\x00\x00\x79", 4);
    assert_int_equal(command(host, 0x02), ACK);
    expect(host, "\x01\x04\x13\x79", 4);
    assert_int_equal(command(host, 0x43), NACK); /* the old erase: this chip has the extended one */
    send(host, (const uint8_t *)"\x00\x00", 2);  /* no complement */
    assert_int_equal(next(host), NACK);
    done(host);
}

TEST(test_rates)
{
    static const uint32_t good[] = {1200, 9600, 57600, 115200, 230400, 460800};
    for (unsigned i = 0; i < sizeof good / sizeof good[0]; i++) {
        struct host *host = chip(NULL, good[i], HIL_PARITY_EVEN);
        sync_host(host);
        assert_int_equal(command(host, 0x02), ACK);
        expect(host, "\x01\x04\x13\x79", 4);
        done(host);
    }
    /* 8N1: nothing that a host would take for an answer to a command, whose bytes have the wrong
     * parity or none */
    struct host *host = chip(NULL, 115200, HIL_PARITY_NONE);
    send(host, (const uint8_t *)"\x7f", 1);
    wait_ps(host, 2 * HIL_PS_PER_MS);
    assert_int_not_equal(command(host, 0x02), ACK);
    done(host);
}

/* Write, read back, erase: sectors, refusals, checksums. */
TEST(test_memory)
{
    uint8_t data[256], back[256];
    for (unsigned i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(i * 5u + 3u);
    struct host *host = chip_ready(NULL);
    assert_int_equal(write_memory(host, SECTOR_1, data, 256), ACK);
    assert_int_equal(write_memory(host, SECTOR_1 + 0x101, data, 7), ACK); /* not on words */
    assert_int_equal(write_memory(host, 0x20004000, data, 16), ACK);
    assert_int_equal(read_memory(host, SECTOR_1, back, 256), ACK);
    assert_memory_equal(back, data, 256);
    assert_int_equal(read_memory(host, SECTOR_1 + 0x100, back, 9), ACK);
    assert_int_equal(back[0], 0xff);
    assert_memory_equal(back + 1, data, 7);
    assert_int_equal(back[8], 0xff);
    assert_int_equal(read_memory(host, 0x20004000, back, 16), ACK);
    assert_memory_equal(back, data, 16);

    assert_int_equal(write_memory(host, 0x08100000, data, 4), NACK); /* past the end */
    assert_int_equal(write_memory(host, 0x20000000, data, 4), NACK); /* its own RAM */
    assert_int_equal(write_memory(host, 0x080ffffe, data, 4), NACK); /* across the end */
    assert_int_equal(read_memory(host, 0x40023800, back, 4), NACK);
    assert_int_equal(command(host, 0x11), ACK);
    send(host, (const uint8_t *)"\x08\x00\x00\x00\x09", 5); /* wrong sum */
    assert_int_equal(next(host), NACK);
    assert_int_equal(command(host, 0x31), ACK);
    assert_int_equal(address(host, FLASH), ACK);
    send(host,
         (const uint8_t *)"\x03"
                          "abcd"
                          "\x00",
         6);
    assert_int_equal(next(host), NACK);
    assert_int_equal(bench_word(host->board, FLASH), 0xffffffff);

    uint32_t mark = 0;
    hil_board_poke(host->board, FLASH, &mark, 4);
    hil_board_poke(host->board, FLASH + 0x8000, &mark, 4);
    uint64_t begin_ps = hil_board_now_ps(host->board);
    /* sectors 1 and 2 */
    assert_int_equal(erase(host, (const uint8_t *)"\x00\x01\x00\x01\x00\x02", 6), ACK);
    /* twice 250 ms at x32 */
    assert_in_range((hil_board_now_ps(host->board) - begin_ps) / HIL_PS_PER_MS, 500, 510);
    assert_int_equal(bench_word(host->board, SECTOR_1), 0xffffffff);
    assert_int_equal(bench_word(host->board, FLASH + 0x8000), 0xffffffff);
    assert_int_equal(bench_word(host->board, FLASH), 0);
    assert_int_equal(erase(host, (const uint8_t *)"\x00\x00\x00\x0c", 4), NACK); /* no sector 12 */
    assert_int_equal(command(host, 0x44), ACK);
    send(host, (const uint8_t *)"\xff\xfe\x01", 3); /* bank 1: there are no banks */
    assert_int_equal(next(host), NACK);
    assert_int_equal(command(host, 0x44), ACK);
    send(host, (const uint8_t *)"\xff\xff\x00", 3); /* everything */
    assert_int_equal(next_within(host, 8100), ACK);
    assert_int_equal(bench_word(host->board, FLASH), 0xffffffff);
    assert_int_equal(hil_board_counters(host->board)->resets, 0);
    done(host);
}

/* A program that stores 0x600d at 0x20003000 + 4 and the vector table offset behind it: Thumb, by
 * hand.
 *     ldr r0, =0x20003000; movw r1, #0x600d; str r1, [r0, #4]; ldr r2, =0xe000ed08; ldr r2, [r2];
 *     str r2, [r0, #8] b . */
static const uint8_t program[] = {
    0x00, 0x80, 0x01, 0x20, 0x09, 0x00, 0x00, 0x08, 0x04, 0x48, 0x46, 0xf2,
    0x0d, 0x01, 0x41, 0x60, 0x03, 0x4a, 0x12, 0x68, 0x82, 0x60, 0xfe, 0xe7,
    0x00, 0xbf, 0x00, 0xbf, 0x00, 0x30, 0x00, 0x20, 0x08, 0xed, 0x00, 0xe0,
};

TEST(test_go)
{
    struct host *host = chip_ready(NULL);
    assert_int_equal(write_memory(host, FLASH, program, sizeof program), ACK);
    assert_int_equal(command(host, 0x21), ACK);
    assert_int_equal(address(host, 0x30000000), NACK);
    assert_int_equal(command(host, 0x21), ACK);
    assert_int_equal(address(host, FLASH), ACK);
    wait_ps(host, HIL_PS_PER_MS);
    assert_int_equal(bench_word(host->board, 0x20003004), 0x600d);
    /* VTOR is untouched, and at 0 there is the ROM */
    assert_int_equal(bench_word(host->board, 0x20003008), 0);
    assert_int_equal(bench_word(host->board, 4) & ~0xffffu, 0x1fff0000u);
    assert_int_equal(host->board->core.state.clock.hclk_hz, 16000000);
    done(host);
}

static int protect(struct host *host)
{
    int answer = command(host, 0x82);
    return answer == ACK ? next_within(host, 1000) : answer;
}

/* Level 1: only identification and the way back, which erases everything, work. */
TEST(test_readout_protection)
{
    uint8_t back[4];
    struct host *host = chip_ready(NULL);
    assert_int_equal(write_memory(host, FLASH, program, sizeof program), ACK);
    assert_int_equal(protect(host), ACK);
    wait_ps(host, HIL_PS_PER_MS);
    assert_int_equal(hil_board_counters(host->board)->resets, 1);
    sync_host(host); /* after the reset it measures anew */
    static const uint8_t refused[] = {0x11, 0x21, 0x31, 0x44, 0x82};
    for (unsigned i = 0; i < sizeof refused; i++)
        assert_int_equal(command(host, refused[i]), NACK);
    assert_int_equal(command(host, 0x02), ACK);
    expect(host, "\x01\x04\x13\x79", 4);
    assert_int_equal(bench_word(host->board, FLASH), 0x20018000);
    assert_int_equal(command(host, 0x92), ACK);
    assert_int_equal(next_within(host, 20000), ACK);
    wait_ps(host, HIL_PS_PER_MS);
    assert_int_equal(bench_word(host->board, FLASH), 0xffffffff);
    sync_host(host);
    assert_int_equal(read_memory(host, FLASH, back, 4), ACK);
    assert_memory_equal(back, "\xff\xff\xff\xff", 4);
    done(host);
}

/* Firmware that jumps to the vectors of system memory lands there too: the same answers without
 * BOOT0. */
TEST(test_jump)
{
    /* ldr r0, =0x1fff0000; ldr r1, [r0]; msr msp, r1; ldr r1, [r0, #4]; bx r1 */
    static const uint8_t jumper[] = {
        0x00, 0x80, 0x01, 0x20, 0x09, 0x00, 0x00, 0x08, 0x02, 0x48, 0x01, 0x68,
        0x81, 0xf3, 0x08, 0x88, 0x41, 0x68, 0x08, 0x47, 0x00, 0x00, 0xff, 0x1f,
    };
    struct hil_options options;
    struct host host = {0};
    struct hil_callbacks callbacks = {&host, NULL, hear};
    hil_options_default(&options);
    options.host_baud = 57600;
    options.host_parity = HIL_PARITY_EVEN;
    host.board = bench_board("core", &options);
    hil_board_set_callbacks(host.board, &callbacks);
    assert_int_equal(hil_board_poke(host.board, FLASH, jumper, sizeof jumper), MR_OK);
    hil_supply_cut(&host.board->supply);
    wait_ps(&host, HIL_PS_PER_MS);
    sync_host(&host);
    assert_int_equal(command(&host, 0x02), ACK);
    expect(&host, "\x01\x04\x13\x79", 4);
    assert_int_equal(bench_word(host.board, 0), 0x20018000); /* flash stays at 0 */
    hil_board_destroy(host.board);
}

/* The firmware goes there on command, while idle, and everything of it is reset: the ROM answers at
 * another rate. */
TEST(test_command)
{
    struct hil_options options;
    struct host host = {0};
    struct hil_callbacks callbacks = {&host, NULL, hear};
    struct hil_can_frame frame = {.id = MR_ID_COMMAND};
    struct mr_command message;
    hil_options_default(&options);
    options.host_baud = 115200;
    options.host_parity = HIL_PARITY_EVEN;
    host.board = hil_board_create(&options);
    if (hil_board_load_elf(host.board, "build/firmware/matrig.elf") != MR_OK)
        fail_msg("%s", hil_board_failure_reason(host.board));
    hil_board_set_callbacks(host.board, &callbacks);
    wait_ps(&host, 100 * HIL_PS_PER_MS);
    assert_int_equal(mr_command_parse("bootrom", 1, &message), MR_OK);
    frame.length = (uint8_t)mr_command_put(&message, frame.data);
    for (unsigned jumper = 0; jumper < 2; jumper++) { /* PE8 to ground */
        if (jumper)
            hil_gpio_drive(&host.board->mcu.gpio, 4, 8, false, hil_now_cycle(&host.board->core));
        assert_int_equal(hil_can_inject(&host.board->mcu.can, &frame), MR_OK);
        wait_ps(&host, 100 * HIL_PS_PER_MS);
        assert_int_equal(hil_board_counters(host.board)->resets, jumper);
    }
    sync_host(&host);
    assert_int_equal(command(&host, 0x02), ACK);
    expect(&host, "\x01\x04\x13\x79", 4);
    wait_ps(&host, 2 * HIL_PS_PER_S); /* the watchdog does not follow */
    assert_int_equal(command(&host, 0x21), ACK);
    assert_int_equal(address(&host, FLASH), ACK);
    wait_ps(&host, 200 * HIL_PS_PER_MS);
    assert_true(hil_board_counters(host.board)->can_frames_out > 100); /* the firmware again */
    assert_int_equal(hil_board_counters(host.board)->resets, 1);
    hil_board_destroy(host.board);
}
