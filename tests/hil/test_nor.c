/* SPI2 and the W25Q128JV through a test image (images/nor.c). Commands, times and wraps are those
 * of the data sheet; at 21 MHz (42 / 2) a byte takes 8 bits = 64 cycles of 168 MHz. */
#include "hil/board/board.h"
#include "tests/hil/bench.h"
#include "tests/hil/snapshot.h"

#include "hil/chips/w25q.h"
#include "hil/rig/faults.h"

enum { POLLED, BY_DMA, CUT_BYTE, UNREAD };
#define MS_20 (20u * HIL_PS_PER_MS)

static struct hil_board *nor_board_seeded(enum hil_cell_times times, uint64_t seed)
{
    struct hil_options options;
    hil_options_default(&options);
    options.cell_times = times;
    options.noise_seed = seed;
    struct hil_board *board = bench_board("nor", &options);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 0), 1);
    assert_int_equal(bench_result(board, 9), 2); /* SPI_SR after reset: TXE */
    return board;
}

static struct hil_board *nor_board(void)
{
    return nor_board_seeded(HIL_TIMES_TYPICAL, 1);
}

static void wait_ps(struct hil_board *board, uint64_t t_ps)
{
    bench_run(board, hil_board_now_ps(board) + t_ps);
}

/* One transaction; what came back replaces `bytes`. */
static void transact(struct hil_board *board, unsigned way, uint32_t cr1, uint8_t *bytes, size_t n)
{
    uint32_t turn = bench_result(board, 0);
    assert_int_equal(hil_board_poke(board, bench_result(board, 4), bytes, n), MR_OK);
    bench_control(board, 1, (uint32_t)n);
    bench_control(board, 2, way);
    bench_control(board, 3, cr1);
    assert_int_equal(hil_usart_inject(&board->mcu.usart, (const uint8_t *)"x", 1), MR_OK);
    wait_ps(board, 5 * HIL_PS_PER_US + n * 380 * HIL_PS_PER_NS);
    for (unsigned i = 0; i < 1000 && bench_result(board, 0) == turn; i++)
        wait_ps(board, HIL_PS_PER_US);
    assert_int_equal(bench_result(board, 0), turn + 1);
    assert_int_equal(hil_board_peek(board, bench_result(board, 5), bytes, n), MR_OK);
}

static void command(struct hil_board *board, uint8_t code)
{
    transact(board, POLLED, 0, &code, 1);
}

static uint8_t status(struct hil_board *board, uint8_t which)
{
    uint8_t bytes[2] = {which, 0};
    transact(board, POLLED, 0, bytes, 2);
    return bytes[1];
}

static void address(uint8_t *bytes, uint8_t code, uint32_t at)
{
    bytes[0] = code;
    bytes[1] = (uint8_t)(at >> 16);
    bytes[2] = (uint8_t)(at >> 8);
    bytes[3] = (uint8_t)at;
}

static void addressed(struct hil_board *board, uint8_t code, uint32_t at, const uint8_t *data,
                      size_t n)
{
    uint8_t bytes[400];
    address(bytes, code, at);
    if (n)
        memcpy(bytes + 4, data, n);
    command(board, 0x06);
    transact(board, POLLED, 0, bytes, n + 4);
}

static void read_back(struct hil_board *board, uint32_t at, uint8_t *data, size_t n)
{
    uint8_t bytes[400] = {0};
    address(bytes, 0x03, at);
    transact(board, BY_DMA, 0, bytes, n + 4);
    memcpy(data, bytes + 4, n);
}

static void assert_cells(const struct hil_board *board, uint32_t at, const uint8_t *expected,
                         size_t n)
{
    uint8_t cells[HIL_NOR_SECTOR_BYTES];
    assert_int_equal(hil_w25q_peek(&board->w25q, at, cells, n), MR_OK);
    assert_memory_equal(cells, expected, n);
}

TEST(test_identity)
{
    struct hil_board *board = nor_board();
    uint8_t jedec[4] = {0x9f};
    transact(board, POLLED, 0, jedec, sizeof jedec);
    assert_memory_equal(jedec + 1, "\xef\x40\x18", 3);
    assert_int_equal(status(board, 0x05), 0);
    hil_board_destroy(board);
}

/* Byte time by prescaler, polled and by DMA; overrun; the wrong clock mode. */
TEST(test_spi)
{
    uint8_t bytes[300] = {0x9f};
    struct hil_board *board = nor_board();
    for (uint32_t br = 0; br < 4; br++) {
        transact(board, BY_DMA, br << 3, bytes, sizeof bytes);
        assert_in_range(bench_result(board, 1), sizeof bytes * (64u << br),
                        sizeof bytes * (64u << br) + 150u);
        bytes[0] = 0x9f;
    }
    transact(board, BY_DMA, 3, bytes, 4); /* CPOL and CPHA: mode 3 */
    assert_memory_equal(bytes + 1, "\xef\x40\x18", 3);

    uint8_t three[3] = {0x05, 0, 0};
    transact(board, UNREAD, 0, three, 3);
    assert_int_equal(bench_result(board, 2), 0x43); /* OVR, TXE, RXNE */
    assert_int_equal(bench_result(board, 6), 0xff); /* the first byte received stays */
    assert_int_equal(bench_result(board, 7), 0x42);
    assert_int_equal(bench_result(board, 8), 0x02);
    bench_control(board, 1, 4);
    bench_control(board, 2, POLLED);
    bench_control(board, 3, 1); /* CPHA alone */
    uint8_t jedec = 0x9f;
    assert_int_equal(hil_board_poke(board, bench_result(board, 4), &jedec, 1), MR_OK);
    assert_int_equal(hil_usart_inject(&board->mcu.usart, &jedec, 1), MR_OK);
    assert_int_equal(hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_MS),
                     MR_UNMODELLED);
    assert_non_null(strstr(hil_board_failure_reason(board), "CPOL and CPHA differ"));
    hil_board_destroy(board);
}

/* Programming: needs WEL, takes 0.7 ms (to 3), clears WEL, turns 1 into 0 only, wraps in its
 * page. */
TEST(test_program)
{
    static const uint8_t data[4] = {0x11, 0x22, 0x33, 0x44}, over[4] = {0xf0, 0x0f, 0xff, 0x00};
    uint8_t bytes[8] = {0x02, 0x01, 0x02, 0x03, 0x55}, page[264], expected[256];
    struct hil_board *board = nor_board();
    transact(board, POLLED, 0, bytes, 5); /* not write-enabled */
    assert_int_equal(status(board, 0x05), 0);
    assert_int_equal(board->state.w25q.operation_count, 0);
    command(board, 0x06);
    assert_int_equal(status(board, 0x05), 2);

    addressed(board, 0x02, 0x010203, data, 4);
    assert_int_equal(status(board, 0x05), 3);
    wait_ps(board, 600 * HIL_PS_PER_US);
    assert_int_equal(status(board, 0x05) & 1u, 1);
    wait_ps(board, 100 * HIL_PS_PER_US);
    assert_int_equal(status(board, 0x05), 0);
    assert_cells(board, 0x010203, data, 4);
    addressed(board, 0x02, 0x010203, over, 4);
    wait_ps(board, HIL_PS_PER_MS);
    assert_cells(board, 0x010203, (const uint8_t *)"\x10\x02\x33\x00", 4);

    /* 260 bytes from 0xf0 of a page: the last four replace the first ones, all inside the page */
    for (unsigned i = 0; i < 260; i++)
        page[i] = (uint8_t)(i * 7u);
    memset(expected, 0xff, sizeof expected);
    for (unsigned i = 0; i < 260; i++)
        expected[(0xf0u + i) % 256u] = page[i];
    addressed(board, 0x02, 0x0300f0, page, 260);
    wait_ps(board, HIL_PS_PER_MS);
    assert_cells(board, 0x030000, expected, 256);
    assert_cells(board, 0x030100, (const uint8_t *)"\xff\xff\xff\xff", 4);

    /* wraps to the begin of the last page, not of the chip */
    addressed(board, 0x02, 0xfffffe, data, 4);
    wait_ps(board, HIL_PS_PER_MS);
    assert_cells(board, 0xffff00, (const uint8_t *)"\x33\x44", 2);
    read_back(board, 0xfffffe, bytes, 3); /* reading wraps to address 0 */
    assert_memory_equal(bytes, "\x11\x22\xff", 3);
    hil_board_destroy(board);
}

/* While BUSY nothing but status is heard; a deselect inside a byte, or an erase of another length,
 * does nothing. */
TEST(test_ignored)
{
    static const uint8_t data[2] = {0x12, 0x34};
    uint8_t jedec[4] = {0x9f}, bytes[8] = {0x02, 0, 0x10, 0, 0xaa, 0xbb}, erase[5] = {0x20};
    struct hil_board *board = nor_board();
    addressed(board, 0x02, 0, data, 2);
    transact(board, POLLED, 0, jedec, 4);
    assert_memory_equal(jedec + 1, "\xff\xff\xff", 3);
    addressed(board, 0x02, 0x100, data, 2);
    wait_ps(board, HIL_PS_PER_MS);
    assert_int_equal(board->state.w25q.operation_count, 1);
    command(board, 0x06);
    transact(board, CUT_BYTE, 0, bytes, 6);
    assert_int_equal(status(board, 0x05), 2); /* write-enabled still, and idle */
    transact(board, POLLED, 0, erase, 5);
    assert_int_equal(status(board, 0x05), 2);
    assert_int_equal(board->state.w25q.operation_count, 1);
    command(board, 0xb9); /* power-down: only the release is heard */
    jedec[0] = 0x9f;
    transact(board, POLLED, 0, jedec, 4);
    assert_memory_equal(jedec + 1, "\xff\xff\xff", 3);
    command(board, 0xab);
    jedec[0] = 0x9f;
    transact(board, POLLED, 0, jedec, 4);
    assert_memory_equal(jedec + 1, "\xef\x40\x18", 3);
    hil_board_destroy(board);
}

/* An erase: what it reaches, and typical and maximum time in ms. */
TEST(test_erase)
{
    static const uint8_t zero = 0, erased = 0xff;
    for (unsigned maximum = 0; maximum < 2; maximum++) {
        uint32_t base = 0x120000, ms = maximum ? 400 : 45;
        struct hil_board *board = nor_board_seeded(maximum ? HIL_TIMES_MAXIMUM : HIL_TIMES_TYPICAL,
                                                   1);
        const uint32_t at[4] = {base - 1, base, base + 0xfff, base + 0x1000};
        for (unsigned k = 0; k < 4; k++)
            hil_w25q_poke(&board->w25q, at[k], &zero, 1);
        addressed(board, 0x20, base + 0x321, NULL, 0);
        wait_ps(board, ms * HIL_PS_PER_MS - 20 * HIL_PS_PER_US);
        assert_int_equal(status(board, 0x05), 3);
        wait_ps(board, 20 * HIL_PS_PER_US);
        assert_int_equal(status(board, 0x05), 0);
        for (unsigned k = 0; k < 4; k++)
            assert_cells(board, at[k], k == 0 || k == 3 ? &zero : &erased, 1);
        hil_board_destroy(board);
    }
}

/* 99h resets behind 66h alone. */
TEST(test_reset)
{
    struct hil_board *board = nor_board();
    command(board, 0x06);
    command(board, 0x99);
    wait_ps(board, 30 * HIL_PS_PER_US); /* tRST */
    assert_int_equal(status(board, 0x05), 2);
    command(board, 0x66);
    command(board, 0x99);
    wait_ps(board, 30 * HIL_PS_PER_US);
    assert_int_equal(status(board, 0x05), 0);
    hil_board_destroy(board);
}

/* Times lie in the data sheet's range, mostly near typical, the same for the same seed. */
TEST(test_spread)
{
    uint64_t us[2] = {0};
    for (unsigned run = 0; run < 2; run++) {
        struct hil_board *board = nor_board_seeded(HIL_TIMES_RANDOM, 11);
        for (unsigned i = 0; i < 20; i++) {
            addressed(board, 0x02, 256 * i, (const uint8_t *)"x", 1);
            uint64_t begin_ps = hil_board_now_ps(board);
            while (status(board, 0x05) & 1u)
                wait_ps(board, 20 * HIL_PS_PER_US);
            uint64_t took_us = (hil_board_now_ps(board) - begin_ps) / HIL_PS_PER_US;
            assert_in_range(took_us, 690, 3030);
            us[run] += took_us;
        }
        hil_board_destroy(board);
    }
    assert_int_equal(us[0], us[1]);
    assert_in_range(us[0], 20 * 700, 20 * 1700);
}

/* A power cut in the 3rd page leaves two whole pages and part of the third; in an erase, part of
 * the old bits. */
TEST(test_power_cut)
{
    uint8_t page[256], cells[HIL_NOR_SECTOR_BYTES] = {0};
    unsigned changed = 0, ones = 0;
    memset(page, 0x0f, sizeof page);
    struct hil_board *board = nor_board();
    bench_cut_at(board, true, 3, 500);
    for (unsigned i = 0; i < 3; i++) {
        addressed(board, 0x02, 256 * i, page, sizeof page);
        wait_ps(board, HIL_PS_PER_MS);
    }
    assert_int_equal(hil_board_counters(board)->power_cuts, 1);
    assert_cells(board, 0, page, sizeof page);
    assert_cells(board, 256, page, sizeof page);
    assert_int_equal(hil_w25q_peek(&board->w25q, 512, cells, 256), MR_OK);
    for (unsigned i = 0; i < 256; i++) {
        assert_int_equal(cells[i] & 0x0f, 0x0f); /* only bits that were to change */
        changed += (unsigned)__builtin_popcount(cells[i] ^ 0xffu);
    }
    assert_in_range(changed, 512 - 90, 512 + 90); /* half of 1024, four sigma 64 */
    hil_board_destroy(board);

    board = nor_board();
    memset(cells, 0, sizeof cells);
    hil_w25q_poke(&board->w25q, 0x5000, cells, sizeof cells);
    addressed(board, 0x20, 0x5000, NULL, 0);
    wait_ps(board, 9 * HIL_PS_PER_MS); /* a fifth of 45 ms */
    hil_supply_cut(&board->supply);
    wait_ps(board, 50 * HIL_PS_PER_MS);
    assert_int_equal(hil_w25q_peek(&board->w25q, 0x5000, cells, sizeof cells), MR_OK);
    for (unsigned i = 0; i < sizeof cells; i++)
        ones += (unsigned)__builtin_popcount(cells[i]);
    assert_in_range(ones, 32768 / 5 - 600, 32768 / 5 + 600);
    hil_board_destroy(board);
}

static void order(struct hil_board *board, enum hil_nor_fault choice, uint32_t count)
{
    struct hil_fault fault = {.trigger = HIL_TRIGGER_TIME,
                              .trigger_ps = hil_board_now_ps(board),
                              .action = HIL_FAULT_NOR,
                              .variant = choice,
                              .count = count};
    if (hil_faults_add(&board->faults, &fault) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(board));
    wait_ps(board, HIL_PS_PER_US);
}

/* By fault script (hil/rig/faults.h): so many operations fail, the chip is dead and
 * mended, or full. */
TEST(test_ordered_faults)
{
    static const uint8_t data = 0x5a, erased = 0xff, zero = 0x00;
    uint8_t jedec[4] = {0x9f};
    struct hil_board *board = nor_board();
    order(board, HIL_NOR_FAIL_PROGRAM, 2);
    for (uint32_t at = 0; at < 0x300; at += 0x100) {
        addressed(board, 0x02, at, &data, 1);
        wait_ps(board, HIL_PS_PER_MS);
        assert_cells(board, at, at < 0x200 ? &erased : &data, 1);
    }
    order(board, HIL_NOR_FAIL_ERASE, 1);
    for (unsigned turn = 0; turn < 2; turn++) {
        addressed(board, 0x20, 0, NULL, 0);
        wait_ps(board, 46 * HIL_PS_PER_MS);
        assert_cells(board, 0x200, turn ? &erased : &data, 1);
    }
    order(board, HIL_NOR_DEAD, 0);
    transact(board, POLLED, 0, jedec, 4);
    assert_memory_equal(jedec + 1, "\xff\xff\xff", 3);
    order(board, HIL_NOR_REPAIR, 0);
    order(board, HIL_NOR_FILL, 0);
    assert_int_equal(status(board, 0x05), 0);
    assert_cells(board, 0, &zero, 1);
    assert_cells(board, 0xffffff, &zero, 1);
    hil_board_destroy(board);
}

/* A fork has the cells too, and restoring takes away what came after. */
TEST(test_snapshot)
{
    static const uint8_t early = 0x12, late = 0x34, erased = 0xff;
    struct hil_board *board = nor_board();
    hil_w25q_poke(&board->w25q, 0xabcdef, &early, 1);
    struct snapshot *snapshot = snapshot_take(board);
    hil_w25q_poke(&board->w25q, 0xabcdef, &late, 1);
    hil_w25q_poke(&board->w25q, 0x100000, &late, 1);
    struct hil_board *copy = snapshot_fork(board);
    assert_cells(copy, 0xabcdef, &late, 1);
    assert_cells(copy, 0x100000, &late, 1);
    snapshot_restore(board, snapshot);
    assert_cells(board, 0xabcdef, &early, 1);
    assert_cells(board, 0x100000, &erased, 1);
    free(snapshot);
    hil_board_destroy(copy);
    hil_board_destroy(board);
}
