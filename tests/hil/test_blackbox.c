/* The black box on the emulated board: the firmware as it is, its driver, and a W25Q128 that takes
 * its time and tears. */
#include "common/boxpage.h"
#include "hil/chips/w25q.h"
#include "tests/hil/ear.h"
#include "tests/hil/snapshot.h"
#include "tests/long.h"

#define BLOCKS_MAX 20000u
#define PAGES_MAX  4000u

struct witness {
    struct ear *ear;
    struct mr_block *heard; /* by index; as serial told them */
    uint8_t *known;
};

static uint8_t pages[PAGES_MAX][MR_BOXPAGE_BYTES], whole[PAGES_MAX][MR_BOXPAGE_BYTES],
    present[PAGES_MAX];

static void witness_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct witness *witness = ctx;
    for (size_t i = 0; i < n; i++) {
        unsigned before = witness->ear->blocks;
        ear_serial(witness->ear, t_ps, bytes + i, 1);
        const struct mr_block *block = &witness->ear->block;
        if (witness->ear->blocks != before && block->index < BLOCKS_MAX) {
            witness->heard[block->index] = *block;
            witness->known[block->index] = 1;
        }
    }
}

static void witness_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    ear_can(((struct witness *)ctx)->ear, t_ps, frame);
}

static void witness_open(struct witness *witness, struct ear *ear)
{
    struct hil_callbacks callbacks = {witness, witness_can, witness_serial};
    witness->ear = ear;
    witness->heard = calloc(BLOCKS_MAX, sizeof *witness->heard);
    witness->known = calloc(BLOCKS_MAX, 1);
    assert_true(witness->heard && witness->known);
    hil_board_set_callbacks(ear->board, &callbacks);
}

static void witness_close(struct witness *witness)
{
    free(witness->heard);
    free(witness->known);
    ear_close(witness->ear);
}

/* A record's pages straight from the memory's cells, from page `from` on: a fresh memory is written
 * in order. */
static size_t take_pages(const struct hil_board *board, uint32_t from, uint16_t record)
{
    size_t count = 0;
    memset(present, 0, sizeof present);
    for (; count < PAGES_MAX; count++) {
        struct mr_boxpage_header header;
        assert_int_equal(hil_w25q_peek(&board->w25q, (uint32_t)(from + count) * MR_BOXPAGE_BYTES,
                                       pages[count], MR_BOXPAGE_BYTES),
                         MR_OK);
        if (mr_boxpage_check(pages[count], &header) != MR_OK || header.record != record)
            break;
        present[count] = 1;
    }
    return count;
}

struct board_report {
    uint32_t first, next;
    unsigned blocks, edges, config;
};

static struct board_report check_pages(size_t count, const struct witness *witness)
{
    struct mr_box_reader reader;
    struct mr_record record;
    struct board_report told = {0};
    mr_box_reader_begin(&reader, pages[0], present, count);
    while (mr_box_reader_next(&reader, &record) == MR_OK) {
        if (record.kind == MR_RECORD_MESSAGE) {
            told.edges += record.id == MR_ID_EDGE;
            told.config += record.id == MR_ID_CHANNEL || record.id == MR_ID_SWITCH_PLACE;
            continue;
        }
        if (!told.blocks)
            told.first = told.next = record.block.index;
        assert_int_equal(record.block.index, told.next);
        if (witness && witness->known[record.block.index])
            assert_memory_equal(&record.block, &witness->heard[record.block.index],
                                sizeof record.block);
        told.next++;
        told.blocks++;
    }
    return told;
}

static void check_end(size_t count, const struct board_report *told)
{
    struct mr_boxpage_header header;
    struct mr_boxpage_end end;
    assert_true(count > 2);
    assert_int_equal(mr_boxpage_check(pages[count - 1], &header), MR_OK);
    assert_int_equal(header.kind, MR_BOXPAGE_END);
    mr_boxpage_get_end(pages[count - 1], &end);
    assert_int_equal(end.lost_blocks, 0);
    assert_int_equal(end.lost_messages, 0);
    assert_int_equal(end.stored_blocks, told->blocks);
}

static void record_landing(unsigned landing, enum hil_cell_times times)
{
    struct hil_options options = ear_options();
    struct witness witness;
    options.cell_times = times;
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, landing);
    witness_open(&witness, ear);
    ear_until(ear, ear->run.duration_s);
    struct mr_landing state;
    assert_int_equal(mr_landing_get(&state, ear->last[EAR_CAN][MR_ID_LANDING], 8), MR_OK);
    size_t count = take_pages(ear->board, 0, 1);
    memcpy(whole, pages, sizeof whole);
    struct board_report told = check_pages(count, &witness);
    struct mr_boxpage_start_page start;
    mr_boxpage_get_start(pages[0], &start);
    check_end(count, &told);
    assert_int_equal(start.landing, landing);
    assert_int_equal(told.edges, ear->heard[EAR_SERIAL][MR_ID_EDGE]);
    assert_int_equal(told.config, 48);
    /* what was before: here back to the ring's length */
    assert_true(told.first < start.trigger_block - 500);
    assert_int_equal(ear->serial_lost, 0);
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    print_message("# landing %u: %u blocks from %u ms before the first edge, %.1f kB/s of pages; "
                  "block alone %.1f bytes\n",
                  landing, told.blocks, start.trigger_block - told.first,
                  (double)count * 256.0 / told.blocks, (double)(count - 8) * 244.0 / told.blocks);
    assert_true((double)count * 256.0 / told.blocks < 60.0);
    witness_close(&witness);
}

TEST(landings_are_store_contextle)
{
    record_landing(1, HIL_TIMES_RANDOM);
    record_landing(4, HIL_TIMES_RANDOM);
}

/* CAN, serial and the memory all busy, each page taking 3 ms: nothing is lost anywhere. */
TEST(the_slowest_memory_loses_no_sample)
{
    record_landing(5, HIL_TIMES_MAXIMUM);
}

static bool heard_record(const struct ear *ear, uint16_t number, struct mr_box_record *record)
{
    for (unsigned i = 0; i < ear->said_count[EAR_SERIAL]; i++) {
        const struct ear_said *said = &ear->said[EAR_SERIAL][i];
        if (said->id == MR_ID_BOX_RECORD && mr_box_record_get(record, said->payload, 8) == MR_OK &&
            record->record == number)
            return true;
    }
    return false;
}

/* One fork: cut in the memory's next operation, then what is left, and the next landing on what
 * edges remain. */
static bool cut_here(const struct ear *base, unsigned permille)
{
    struct ear *ear = calloc(1, sizeof *ear);
    assert_non_null(ear);
    mr_deframer_init(&ear->deframer);
    ear_attach(ear, snapshot_fork(base->board));
    uint64_t done = ear->board->state.w25q.operation_count;
    bench_cut_at(ear->board, true, 1, permille);
    double now_s = (double)hil_board_now_ps(ear->board) * 1e-12, limit_s = now_s + 0.2;
    for (; hil_board_counters(ear->board)->power_cuts == 0; now_s += 0.001) {
        assert_true(now_s < limit_s);
        ear_until(ear, now_s);
    }
    ear_until(ear, now_s + 0.2);
    ear->heard[EAR_SERIAL][MR_ID_EDGE] = 0; /* those before the cut */
    ear->listens = true;
    ear_command(ear, EAR_SERIAL, MR_COMMAND_BOX_LIST, 0, 7);
    ear_until(ear, now_s + 0.22);
    struct mr_box_record listed = {0};
    assert_true(heard_record(ear, 1, &listed));
    size_t count = take_pages(ear->board, 0, 1);
    assert_in_range(count, done, done + 1); /* the torn one may by chance be whole */
    assert_int_equal(listed.pages, count);
    assert_int_equal(listed.complete, 0);
    assert_memory_equal(pages, whole, count * MR_BOXPAGE_BYTES);
    check_pages(count, NULL);
    unsigned edges_before = ear->heard[EAR_SERIAL][MR_ID_EDGE]; /* of the landing that was cut */
    ear_command(ear, EAR_SERIAL, MR_COMMAND_ARM, 9, 8);
    ear_until(ear, now_s + 0.7);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_DISARM, 0, 9);
    ear_until(ear, now_s + 0.9);
    struct mr_ack ack;
    assert_int_equal(mr_ack_get(&ack, ear->last[EAR_SERIAL][MR_ID_ACK], 8), MR_OK);
    assert_int_equal(ack.status, MR_OK);
    /* It begins in the sector after the torn page, or in its own when it was the first there and is
     * erased again by now. */
    count = done % 16 == 0 ? take_pages(ear->board, (uint32_t)done, 2) : 0;
    if (!count)
        count = take_pages(ear->board, (uint32_t)(done / 16 + 1) * 16, 2);
    bool landed = count > 0;
    /* a landing begins with the second edge */
    assert_true(landed || ear->heard[EAR_SERIAL][MR_ID_EDGE] - edges_before < 2);
    if (landed) {
        struct mr_boxpage_start_page start;
        mr_boxpage_get_start(pages[0], &start);
        assert_int_equal(start.landing, 9);
        struct board_report told = check_pages(count, NULL);
        check_end(count, &told);
        assert_true(told.blocks > 100);
    }
    hil_board_destroy(ear->board);
    free(ear);
    return landed;
}

TEST(the_power_goes_at_many_points)
{
    const unsigned points = tests_take(12, 100);
    struct hil_options options = ear_options();
    struct ear *ear = ear_open(&options, 5);
    unsigned landed = 0, cuts = 0;
    ear_until(ear, ear->run.duration_s);
    size_t total = take_pages(ear->board, 0, 1);
    memcpy(whole, pages, sizeof whole);
    ear_close(ear);
    ear = ear_open(&options, 5);
    double t_s = 0.5;
    for (; cuts < points; t_s += 0.001) {
        ear_until(ear, t_s);
        if (ear->board->state.w25q.operation_count < 1 + cuts * (total - 2) / points)
            continue;
        landed += cut_here(ear, cuts * 137u % 1000u);
        cuts++;
    }
    ear_close(ear);
    print_message("# %u cuts over %zu pages, %u with another landing recorded after\n", cuts, total,
                  landed);
    assert_true(landed > points / 3);
}

static struct mr_box_state box_state(const struct ear *ear)
{
    struct mr_box_state state = {0};
    assert_int_equal(
        mr_box_state_get(&state, ear->last[EAR_SERIAL][MR_ID_BOX_STATE], MR_MESSAGE_BYTES_MAX),
        MR_OK);
    return state;
}

/* The third page of the fourth sector never ends to be programmed: the record continues in the
 * fifth sector, and lacks nothing. */
TEST(a_page_that_stays_busy_costs_the_rest_of_its_sector)
{
    enum { HANGS = 3 * 16 + 2, NEXT = 4 * 16 };
    struct hil_options options = ear_options();
    struct ear *ear = ear_open(&options, 5);
    ear_order(ear, "nor 50 nor hang 1");
    ear_until(ear, ear->run.duration_s);
    size_t count = take_pages(ear->board, 0, 1);
    assert_int_equal(count, HANGS);
    memcpy(whole, pages, sizeof whole);
    count = take_pages(ear->board, NEXT, 1);
    assert_true(count > 100);
    memmove(pages[HANGS], pages[0], count * MR_BOXPAGE_BYTES);
    memcpy(pages[0], whole[0], HANGS * MR_BOXPAGE_BYTES);
    memset(present, 1, count += HANGS);
    struct board_report told = check_pages(count, NULL);
    check_end(count, &told);
    assert_int_equal(told.edges, ear->heard[EAR_SERIAL][MR_ID_EDGE]);
    assert_int_equal(ear->fault[MR_FAULT_NOR_FAILED].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_NOR_FAILED].detail, 1);
    ear_close(ear);
}

/* The same for an erase: the others are erased. */
TEST(a_sector_that_stays_busy_is_left_out)
{
    static const uint8_t used = 0x55;
    struct ear *ear = ear_open(NULL, 0);
    for (uint32_t sector = 5; sector < 8; sector++)
        hil_w25q_poke(&ear->board->w25q, sector * HIL_NOR_SECTOR_BYTES, &used, 1);
    ear_order(ear, "at 0 nor hang 1");
    ear_until(ear, 9.0);
    for (uint32_t sector = 5; sector < 8; sector++) {
        uint8_t cell;
        hil_w25q_peek(&ear->board->w25q, sector * HIL_NOR_SECTOR_BYTES, &cell, 1);
        if (sector > 5)
            assert_int_equal(cell, 0xff);
    }
    assert_int_equal(ear->fault[MR_FAULT_NOR_FAILED].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_NOR_FAILED].detail, 2);
    assert_int_equal(box_state(ear).state, MR_BOX_READY);
    ear_close(ear);
}

/* At the start: an operation from before, which a reset of the chip ends; a chip that nothing ends
 * has failed, it is not absent. */
TEST(a_chip_that_is_busy_at_the_start_is_not_absent)
{
    struct ear *ear = ear_open(NULL, 0);
    struct hil_w25q *chip = &ear->board->state.w25q;
    chip->operation_command = 0x20;
    chip->cell_count = HIL_NOR_SECTOR_BYTES;
    chip->status = 3;
    chip->operation_end_ps = HIL_NEVER;
    ear_until(ear, 5.5);
    assert_int_equal(box_state(ear).state, MR_BOX_SCANNING);
    ear_until(ear, 9.0);
    assert_int_equal(box_state(ear).state, MR_BOX_READY);
    assert_int_equal(ear_faults(ear, EAR_SERIAL) & (EAR_BIT(NOR_FAILED) | EAR_BIT(NOR_MISSING)), 0);
    ear_close(ear);

    ear = ear_open(NULL, 0);
    ear_order(ear, "at 0 nor stuck");
    ear_until(ear, 9.0);
    assert_int_equal(box_state(ear).state, MR_BOX_FAILED);
    assert_int_equal(ear_faults(ear, EAR_SERIAL) & (EAR_BIT(NOR_FAILED) | EAR_BIT(NOR_MISSING)),
                     EAR_BIT(NOR_FAILED));
    assert_int_equal(ear->fault[MR_FAULT_NOR_FAILED].detail, 5);
    ear_close(ear);
}
