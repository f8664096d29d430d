/* The black box against a memory that tears, wears and fails: what reads back is what was given, up
 * to where the power went. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/boxpage.h"
#include "firmware/blackbox.h"
#include "firmware/health.h"
#include "tests/cmocka_all.h"
#include "tests/firmware/fake_nor.h"

#define SENT      40000u
#define PAGES_MAX 8000u

static struct blackbox box;
static struct mr_block sent[SENT]; /* by index modulo SENT */
static uint32_t index_now, random_state;
static bool white; /* codes that do not pack */

static uint8_t pages[PAGES_MAX][MR_BOXPAGE_BYTES], present[PAGES_MAX];
static size_t page_count, pages_told;

static uint32_t draw(uint32_t below)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)random_state * below >> 32);
}

static struct mr_block *make_block(uint32_t index)
{
    struct mr_block *block = &sent[index % SENT];
    *block = (struct mr_block){.index = index, .tick = 2352u + 84000u * index};
    for (unsigned i = 0; i < 32; i++) {
        uint32_t codes = i < 16 ? 4 : 8;
        uint32_t sum = white ? draw(codes * 4095 + 1) : codes * 2000 + draw(20);
        uint16_t *value = i < 8  ? &block->forward_sum[i]
                        : i < 16 ? &block->reversed_sum[i - 8]
                                 : &block->sum[i - 16];
        *value = (uint16_t)sum;
    }
    return block;
}

static void ms_passes(void)
{
    for (unsigned i = 0; i < 4; i++) {
        blackbox_poll(&box, index_now);
        fake_nor.now_us += 250;
    }
}

static void play(unsigned blocks)
{
    while (blocks--) {
        blackbox_on_block(&box, make_block(index_now));
        index_now++;
        ms_passes();
    }
}

static void boot(void)
{
    fake_nor_power();
    blackbox_start(&box);
}

static bool get_ready(unsigned limit_ms)
{
    while (blackbox_check_ready(&box) != MR_OK && limit_ms--)
        ms_passes(), index_now++;
    return blackbox_check_ready(&box) == MR_OK;
}

static int fresh(void **state)
{
    (void)state;
    fake_nor_reset();
    random_state = 1;
    white = false;
    index_now = 0;
    boot();
    return get_ready(1000) ? 0 : -1;
}

static void configuration(unsigned i, uint8_t payload[8])
{
    for (unsigned k = 0; k < 8; k++)
        payload[k] = (uint8_t)(i * 8 + k);
}

#define CONFIG_MESSAGES 120u

static void arm(uint16_t landing)
{
    blackbox_arm(&box, &(struct mr_boxpage_start_page){
                           .landing = landing, .armed_block = index_now, .config_crc = 0x1234});
    for (unsigned i = 0; i < CONFIG_MESSAGES; i++) {
        uint8_t payload[8];
        configuration(i, payload);
        blackbox_record_configuration(&box, (uint16_t)(0x1f5 + i % 4), payload, 8);
    }
}

/* A landing of `blocks` after the first edge, `before` blocks after arming. Returns its record. */
static uint16_t land(uint16_t landing, unsigned before, unsigned blocks)
{
    uint16_t record = box.next_record;
    arm(landing);
    play(before);
    blackbox_trigger(&box, index_now);
    for (unsigned n = 0; n < blocks; n += 100) {
        blackbox_record_message(&box, 0x090, (const uint8_t *)&index_now, 4);
        play(blocks - n < 100 ? blocks - n : 100);
    }
    blackbox_finish(&box);
    for (unsigned n = 0; box.state == MR_BOX_CLOSING && n < 2000 && !fake_nor.dark; n++)
        play(1);
    return record;
}

/* Read a record out as the host does, from page `from` on, over what is there. */
static void fetch(uint16_t record, uint32_t from)
{
    uint16_t of, page;
    uint8_t part;
    const uint8_t *bytes;
    if (!from) {
        memset(present, 0, sizeof present);
        page_count = 0;
    }
    assert_int_equal(blackbox_read(&box, record, from), MR_OK);
    for (unsigned n = 0; n < 100000; n++) {
        enum blackbox_part what = blackbox_get_part(&box, &of, &page, &part, &bytes);
        if (what == BLACKBOX_PART_END) {
            pages_told = page;
            return;
        }
        if (what == BLACKBOX_PART_READY) {
            assert_int_equal(of, record);
            assert_true(page < PAGES_MAX);
            memcpy(pages[page] + BLACKBOX_PART_BYTES * part, bytes, BLACKBOX_PART_BYTES);
            if (part == 1) {
                struct mr_boxpage_header header;
                assert_int_equal(mr_boxpage_check(pages[page], &header), MR_OK);
                assert_int_equal(header.record, record);
                present[page] = 1;
                page_count = page + 1u;
            }
        }
        ms_passes();
    }
    fail_msg("reading never ended");
}

struct board_report {
    unsigned blocks, notes, config;
    uint32_t first, next;
};

/* What the pages say, block for block what was sent and without a hole; configuration first. */
static struct board_report check_pages(void)
{
    struct mr_box_reader reader;
    struct mr_record record;
    struct board_report told = {0};
    mr_box_reader_begin(&reader, pages[0], present, page_count);
    while (mr_box_reader_next(&reader, &record) == MR_OK) {
        if (record.kind == MR_RECORD_BLOCK) {
            if (!told.blocks)
                told.first = told.next = record.block.index;
            assert_int_equal(record.block.index, told.next);
            assert_memory_equal(&record.block, &sent[record.block.index % SENT],
                                sizeof record.block);
            told.next++;
            told.blocks++;
        } else if (record.id == 0x090) {
            told.notes++;
        } else {
            uint8_t payload[8];
            configuration(told.config, payload);
            assert_int_equal(told.blocks, 0);
            assert_memory_equal(record.payload, payload, 8);
            told.config++;
        }
    }
    return told;
}

static void check_whole(uint16_t record, uint16_t landing, unsigned blocks, uint32_t trigger)
{
    fetch(record, 0);
    struct board_report told = check_pages();
    struct mr_boxpage_header header;
    struct mr_boxpage_start_page start;
    struct mr_boxpage_end end;
    assert_int_equal(pages_told, page_count);
    assert_int_equal(mr_boxpage_check(pages[0], &header), MR_OK);
    assert_int_equal(header.kind, MR_BOXPAGE_START);
    mr_boxpage_get_start(pages[0], &start);
    assert_int_equal(start.landing, landing);
    assert_int_equal(start.trigger_block, trigger);
    assert_int_equal(mr_boxpage_check(pages[page_count - 1], &header), MR_OK);
    assert_int_equal(header.kind, MR_BOXPAGE_END);
    mr_boxpage_get_end(pages[page_count - 1], &end);
    assert_int_equal(end.lost_blocks, 0);
    assert_int_equal(end.stored_blocks, told.blocks);
    assert_int_equal(end.first_block, told.first);
    assert_int_equal(told.next, trigger + blocks);
    assert_true(told.first <= trigger);
    assert_int_equal(told.notes, (blocks + 99) / 100);
    assert_int_equal(told.config, CONFIG_MESSAGES);
}

TEST_IN(a_landing_comes_back_with_what_was_before, fresh, NULL)
{
    play(3000); /* nothing is armed: none of it is kept */
    uint32_t trigger = index_now + 2000;
    uint16_t record = land(5, 2000, 2500);
    check_whole(record, 5, 2500, trigger);
    struct board_report told = check_pages();
    assert_in_range(trigger - told.first, 900, 1400); /* the ring's worth of quiet blocks */
    white = true;
    trigger = index_now + 900;
    record = land(6, 900, 500);
    check_whole(record, 6, 500, trigger);
    told = check_pages();
    /* 112 pages of 244 bytes, 58.25 a block, from a key on */
    assert_in_range(trigger - told.first, 390, 475);
    trigger = index_now + 300;
    record = land(7, 300, 500);
    check_whole(record, 7, 500, trigger);
    told = check_pages();
    assert_int_equal(trigger - told.first, 300); /* from arming on, when that is not long ago */
    fetch(record, 40);                           /* resumed */
    assert_true(present[40] && present[41]);
}

TEST_IN(a_loss_is_told, fresh, NULL)
{
    white = true;
    arm(1);
    play(100);
    uint32_t trigger = index_now;
    blackbox_trigger(&box, trigger);
    play(200);
    fake_nor.program_us = 900000; /* the memory does not keep up */
    play(1500);
    fake_nor.program_us = 700;
    play(1000);
    index_now += 7; /* and the board loses some itself */
    play(100);
    uint32_t end_block = index_now;
    blackbox_finish(&box);
    for (unsigned n = 0; n < 1000; n++)
        ms_passes();
    const struct blackbox_record *record = blackbox_record_at(&box, 0);
    assert_true(record->is_complete);
    fetch(record->record, 0);
    struct mr_box_reader reader;
    struct mr_record r;
    uint32_t blocks = 0;
    mr_box_reader_begin(&reader, pages[0], present, page_count);
    while (mr_box_reader_next(&reader, &r) == MR_OK) {
        if (r.kind == MR_RECORD_BLOCK) {
            assert_memory_equal(&r.block, &sent[r.block.index % SENT], sizeof r.block);
            blocks++;
        }
    }
    assert_int_equal(record->stored_blocks, blocks);
    assert_int_equal(record->lost_blocks, end_block - record->first_block - blocks);
    assert_in_range(record->lost_blocks, 500, 1500);
    assert_true(health_get_counter(MR_FAULT_BOX_LOST).count > 0);
}

TEST_IN(nothing_is_erased_from_arm_to_done, fresh, NULL)
{
    for (unsigned i = 0; i < 3000; i++) /* a memory full of something else */
        fake_nor.cell[i * NOR_SECTOR_BYTES + 17] = 0x55, fake_nor.cell[i * NOR_SECTOR_BYTES] = 0;
    for (unsigned i = 3000; i < 4000; i++)
        fake_nor.cell[i * NOR_SECTOR_BYTES] = 0x11;
    boot();
    while (box.state == MR_BOX_SCANNING) {
        assert_int_equal(blackbox_check_ready(&box), MR_WAIT);
        ms_passes(), index_now++;
    }
    assert_int_equal(blackbox_check_ready(&box), MR_WAIT);
    float wait_s = blackbox_wait_s(&box);
    assert_true(wait_s > 10.0f && wait_s < 25.0f); /* 224 sectors of 60 ms */
    for (unsigned n = 0; n < 4000; n++)
        ms_passes(), index_now++;
    assert_true(blackbox_wait_s(&box) < wait_s - 3.0f);
    assert_true(get_ready(30000));
    assert_true(blackbox_wait_s(&box) == 0.0f);
    uint64_t erases = fake_nor.erases;
    arm(9);
    play(500);
    assert_in_range(fake_nor.erases - erases, 0, 1); /* one was on its way */
    erases = fake_nor.erases;
    blackbox_trigger(&box, index_now);
    play(2000);
    assert_int_equal(fake_nor.erases, erases);
    blackbox_finish(&box);
    play(2000);
    assert_true(fake_nor.erases > erases);
}

TEST_IN(the_worst_times_lose_nothing, fresh, NULL)
{
    white = true;
    fake_nor.program_us = 3000;
    play(1000);
    uint32_t trigger = index_now + 100;
    uint16_t record = land(2, 100, 20000);
    check_whole(record, 2, 20000, trigger);
    assert_int_equal(fake_nor.overwritten, 0);
}

static void fill(unsigned least)
{
    unsigned landings = 0;
    uint32_t trigger[BLACKBOX_RECORDS_MAX];
    while (blackbox_check_ready(&box) == MR_OK && landings < BLACKBOX_RECORDS_MAX) {
        trigger[landings] = index_now + 1600;
        /* 10 s with what was before */
        land((uint16_t)(100 + landings), 1600, 10000 - (white ? 440 : 950));
        landings++;
    }
    assert_int_equal(blackbox_check_ready(&box), MR_FULL);
    assert_true(isnan(blackbox_wait_s(&box)));
    assert_in_range(landings, least, BLACKBOX_RECORDS_MAX);
    print_message("%u landings of 10 s, %u sectors left\n", landings, box.ready_sectors);
    assert_int_equal(fake_nor.overwritten, 0);
    boot();
    while (box.state == MR_BOX_SCANNING)
        ms_passes();
    for (unsigned i = 0; i < landings; i++) {
        /* block contents: the last ones, which the test still knows */
        const struct blackbox_record *record = blackbox_record_at(&box, i);
        assert_non_null(record);
        if (!record->is_complete || record->lost_blocks)
            fail_msg("record %u: complete %d, %u blocks from %u, %u lost", record->record,
                     record->is_complete, record->stored_blocks, record->first_block,
                     record->lost_blocks);
        assert_int_equal(record->landing, 100 + record->record - 1);
        assert_true(record->stored_blocks >= 9800);
    }
    check_whole((uint16_t)landings, (uint16_t)(100 + landings - 1), 10000 - (white ? 440 : 950),
                trigger[landings - 1]);
    /* free the third: its space comes back, all others stay */
    uint16_t third = 3;
    unsigned ready = box.ready_sectors;
    assert_int_equal(blackbox_free(&box, third), MR_OK);
    for (unsigned n = 0; n < 30000; n++)
        ms_passes(), index_now++;
    assert_in_range(box.ready_sectors - ready, 60, 155);
    assert_int_equal(blackbox_free(&box, third), MR_UNKNOWN);
    boot();
    while (box.state == MR_BOX_SCANNING)
        ms_passes();
    unsigned left = 0;
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX; i++)
        left += blackbox_record_at(&box, i) != NULL;
    assert_int_equal(left, landings - 1);
}

TEST_IN(it_holds_26_landings_that_do_not_pack, fresh, NULL)
{
    white = true;
    play(600);
    fill(26);
}

TEST_IN(it_holds_as_many_real_ones_as_it_has_places, fresh, NULL)
{
    play(2000);
    fill(50);
}

/* A short landing, cut off in each operation of the memory at several points of it. */
TEST_IN(the_power_goes_at_every_operation, fresh, NULL)
{
    static uint8_t whole[PAGES_MAX][MR_BOXPAGE_BYTES];
    static const unsigned at[] = {0, 300, 700, 999};
    uint64_t operations = fake_nor.operations;
    land(7, 300, 400);
    operations = fake_nor.operations - operations;
    fetch(1, 0);
    memcpy(whole, pages, sizeof whole);
    size_t whole_count = page_count;
    assert_int_equal(whole_count, operations);
    assert_in_range(operations, 40, 400);
    for (uint64_t n = 1; n <= operations; n++) {
        for (unsigned i = 0; i < COUNT_OF(at); i++) {
            fresh(NULL);
            random_state = 1;
            fake_nor.random = (uint32_t)(n * 4 + i);
            fake_nor.cut_at = fake_nor.operations + n;
            fake_nor.cut_permille = at[i];
            land(7, 300, 400);
            assert_true(fake_nor.dark);
            uint32_t before = index_now;
            boot();
            assert_true(get_ready(1000));
            const struct blackbox_record *record = blackbox_record_at(&box, 0);
            size_t kept = 0;
            if (record) {
                fetch(1, 0);
                kept = page_count;
                assert_memory_equal(pages, whole, kept * MR_BOXPAGE_BYTES);
                for (size_t p = 0; p < kept; p++)
                    assert_int_equal(present[p], 1);
                assert_int_equal(record->is_complete, kept == whole_count);
                check_pages();
            }
            assert_in_range(kept, n - 1, n); /* the torn one may by chance be whole */
            uint32_t trigger = index_now = before + 1000;
            land(8, 0, 300);
            check_whole(record ? 2 : 1, 8, 300, trigger);
            assert_int_equal(fake_nor.overwritten, 0);
        }
    }
}

/* Freeing and erasing, cut off likewise: what was not freed stays whole, and all space comes
 * back. */
TEST_IN(the_power_goes_while_space_is_made, fresh, NULL)
{
    static const unsigned at[] = {0, 500, 999};
    for (uint64_t n = 1; n <= 14; n++) {
        for (unsigned i = 0; i < COUNT_OF(at); i++) {
            fresh(NULL);
            white = true;
            land(1, 300, 300);
            uint32_t trigger = index_now + 10;
            land(2, 10, 400);
            assert_int_equal(blackbox_free(&box, 1), MR_OK);
            fake_nor.random = (uint32_t)(n * 4 + i);
            fake_nor.cut_at = fake_nor.operations + n;
            fake_nor.cut_permille = at[i];
            for (unsigned ms = 0; ms < 3000 && !fake_nor.dark; ms++)
                ms_passes(), index_now++;
            boot();
            assert_true(get_ready(1000));
            check_whole(2, 2, 400, trigger);
            bool first_is_there = false;
            for (unsigned r = 0; r < BLACKBOX_RECORDS_MAX; r++)
                first_is_there |= blackbox_record_at(&box, r) &&
                                  blackbox_record_at(&box, r)->record == 1;
            if (first_is_there) {
                assert_int_equal(n, 1); /* the mark was not made: all of it is still there */
                fetch(1, 0);
                assert_true(check_pages().blocks >= 300);
                assert_int_equal(blackbox_free(&box, 1), MR_OK);
            }
            for (unsigned ms = 0; ms < 3000; ms++)
                ms_passes(), index_now++;
            assert_int_equal(box.dirty_sectors, 0);
            assert_int_equal(box.bad_sectors, 0);
            check_whole(2, 2, 400, trigger);
        }
    }
}

TEST_IN(bad_blocks_cost_space_only, fresh, NULL)
{
    static const unsigned kinds[] = {FAKE_NOR_PROGRAM_ERROR, FAKE_NOR_PROGRAM_SILENT,
                                     FAKE_NOR_READ_ERROR};
    for (unsigned i = 0; i < COUNT_OF(kinds); i++) {
        fresh(NULL);
        white = true;
        fake_nor.faults = kinds[i];
        /* from the middle of a sector to the middle of another */
        fake_nor.from = 2 * NOR_SECTOR_BYTES + 5 * NOR_PAGE_BYTES;
        fake_nor.to = 9 * NOR_SECTOR_BYTES + 3 * NOR_PAGE_BYTES;
        uint32_t trigger = index_now + 50;
        unsigned failed = health_get_counter(MR_FAULT_NOR_FAILED).count;
        uint16_t record = land(3, 50, 3000);
        assert_int_equal(health_get_counter(MR_FAULT_NOR_FAILED).count - failed, 8);
        check_whole(record, 3, 3000, trigger);
        fake_nor.faults = 0;
        boot();
        assert_true(get_ready(1000));
        check_whole(record, 3, 3000, trigger);
    }
}

/* 64 pages in a row that fail are the end of the memory; 80 with sound ones in between are not. */
TEST_IN(pages_that_fail_apart_are_not_in_a_row, fresh, NULL)
{
    arm(1);
    blackbox_trigger(&box, index_now);
    play(500);
    fake_nor.to = FAKE_NOR_SIZE;
    unsigned failed = health_get_counter(MR_FAULT_NOR_FAILED).count;
    for (unsigned n = 1; n <= 80; n++) {
        fake_nor.faults = FAKE_NOR_PROGRAM_SILENT;
        for (unsigned ms = 0;
             ms < 100 && health_get_counter(MR_FAULT_NOR_FAILED).count < failed + n; ms++)
            play(1);
        fake_nor.faults = 0;
        play(20);
    }
    assert_int_equal(health_get_counter(MR_FAULT_NOR_FAILED).count, failed + 80);
    assert_int_equal(box.state, MR_BOX_RECORDING);
}

TEST_IN(sectors_that_do_not_erase_are_left, fresh, NULL)
{
    static const unsigned kinds[] = {FAKE_NOR_ERASE_ERROR, FAKE_NOR_ERASE_SILENT};
    for (unsigned i = 0; i < COUNT_OF(kinds); i++) {
        fresh(NULL);
        white = true;
        uint16_t record = land(3, 50, 1000);
        unsigned ready = box.ready_sectors;
        fake_nor.faults = kinds[i];
        fake_nor.from = 2 * NOR_SECTOR_BYTES;
        fake_nor.to = 5 * NOR_SECTOR_BYTES;
        assert_int_equal(blackbox_free(&box, record), MR_OK);
        for (unsigned ms = 0; ms < 40000; ms++)
            ms_passes(), index_now++;
        assert_int_equal(box.bad_sectors, 3);
        assert_true(box.ready_sectors > ready);
        assert_int_equal(blackbox_check_ready(&box), MR_OK);
        uint32_t trigger = index_now;
        record = land(4, 0, 2000);
        check_whole(record, 4, 2000, trigger);
    }
}

TEST_IN(without_a_chip_landings_go_on, fresh, NULL)
{
    fake_nor.present = false;
    boot();
    assert_int_equal(box.state, MR_BOX_MISSING);
    assert_int_equal(blackbox_check_ready(&box), MR_OK);
    arm(1);
    play(10);
    blackbox_trigger(&box, index_now);
    play(10);
    blackbox_finish(&box);
    assert_int_equal(blackbox_read(&box, 1, 0), MR_NOT_NOW);
    assert_int_equal(blackbox_free(&box, 1), MR_NOT_NOW);
    fake_nor.present = true; /* it goes in the middle of a landing */
    boot();
    assert_true(get_ready(1000));
    arm(1);
    blackbox_trigger(&box, index_now);
    play(100);
    fake_nor.present = false;
    play(100);
    assert_int_equal(box.state, MR_BOX_MISSING);
    fake_nor.present = true; /* or holds nothing any more */
    fake_nor_reset();
    boot();
    assert_true(get_ready(1000));
    fake_nor.faults = FAKE_NOR_PROGRAM_SILENT;
    fake_nor.to = FAKE_NOR_SIZE;
    land(1, 10, 2000);
    assert_int_equal(box.state, MR_BOX_FAILED);
    assert_int_equal(blackbox_check_ready(&box), MR_OK);
}

TEST_IN(an_armed_landing_that_is_called_off_leaves_nothing, fresh, NULL)
{
    uint64_t operations = fake_nor.operations;
    arm(1);
    play(2000);
    blackbox_finish(&box);
    play(100);
    assert_int_equal(fake_nor.operations, operations);
    assert_int_equal(blackbox_read(&box, 1, 0), MR_UNKNOWN);
    arm(2);
    assert_int_equal(blackbox_read(&box, 1, 0), MR_NOT_NOW);
    blackbox_finish(&box);
}

static unsigned records_there(void)
{
    unsigned count = 0;
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX + 1;
         i++) /* beyond the last place there is none */
        count += blackbox_record_at(&box, i) != NULL;
    return count;
}

/* 64 places: then it is full however much space is left, and a landing that begins all the same is
 * not recorded over another. */
TEST_IN(it_has_64_places, fresh, NULL)
{
    for (unsigned n = 1; n <= BLACKBOX_RECORDS_MAX; n++) {
        assert_int_equal(blackbox_check_ready(&box), MR_OK);
        assert_int_equal(land((uint16_t)n, 0, 20), n);
    }
    assert_int_equal(blackbox_check_ready(&box), MR_FULL);
    assert_true(isnan(blackbox_wait_s(&box)));
    assert_int_equal(records_there(), BLACKBOX_RECORDS_MAX);
    uint64_t operations = fake_nor.operations;
    land(65, 0, 100);
    assert_int_equal(fake_nor.operations, operations);
    assert_int_equal(records_there(), BLACKBOX_RECORDS_MAX);
    assert_int_equal(blackbox_free(&box, 7), MR_OK);
    assert_int_equal(blackbox_check_ready(&box), MR_WAIT);
    assert_true(blackbox_wait_s(&box) > 0.0f);
    assert_true(get_ready(1000));
    uint32_t trigger = index_now;
    uint16_t record = land(66, 0, 200);
    check_whole(record, 66, 200, trigger);
}

/* Arming asks for 288 sectors, room for a landing of 19 s that does not pack (58.25 bytes a block,
 * 3904 in a sector). One that goes on for 30 s keeps its beginning, without a hole, and says that
 * it is not complete. */
TEST_IN(a_landing_longer_than_the_space_keeps_its_beginning, fresh, NULL)
{
    for (unsigned i = 0; i < NOR_SECTORS; i++) {
        if (i < 1000 || i >= 1000 + BLACKBOX_RESERVE_SECTORS)
            fake_nor.cell[i * NOR_SECTOR_BYTES] = 0x11; /* something else, to be erased first */
    }
    boot();
    while (box.state == MR_BOX_SCANNING)
        ms_passes(), index_now++;
    assert_int_equal(box.ready_sectors, BLACKBOX_RESERVE_SECTORS);
    assert_int_equal(blackbox_check_ready(&box), MR_OK);
    white = true;
    uint32_t trigger = index_now;
    uint16_t record = land(5, 0, 30000);
    const struct blackbox_record *there = blackbox_record_at(&box, 0);
    assert_non_null(there);
    assert_false(there->is_complete);
    fetch(record, 0);
    struct board_report told = check_pages(); /* an exact prefix */
    assert_int_equal(told.first, trigger);
    assert_in_range(told.blocks, 19000, 19400);
    assert_true(health_get_counter(MR_FAULT_BOX_LOST).count > 0);
}

/* One page is the start: what does not fit in the others, 244 bytes each, is left out whole, and
 * the landing is kept all the same. A message of 8 bytes takes 84 bits. */
TEST_IN(a_configuration_too_long_is_cut_at_a_message, fresh, NULL)
{
    uint32_t trigger;
    uint16_t record = box.next_record;
    blackbox_arm(&box, &(struct mr_boxpage_start_page){.landing = 3});
    for (unsigned i = 0; i < 1000; i++) {
        uint8_t payload[8];
        configuration(i, payload);
        blackbox_record_configuration(&box, 0x1f5, payload, 8);
    }
    play(50);
    blackbox_trigger(&box, trigger = index_now);
    play(300);
    blackbox_finish(&box);
    assert_int_equal(blackbox_free(&box, record), MR_WAIT); /* its last pages are on their way */
    assert_int_equal(blackbox_check_ready(&box), MR_WAIT);
    play(500);
    fetch(record, 0);
    struct board_report told = check_pages();
    assert_in_range(told.config, (BLACKBOX_CONFIG_PAGES - 1) * 244 * 8 / 84 - 1,
                    (BLACKBOX_CONFIG_PAGES - 1) * 244 * 8 / 84);
    assert_int_equal(told.first, trigger - 50);
    assert_int_equal(told.blocks, 350);
}

/* Freed in the middle of being read: no page of it comes any more, nor an end. */
TEST_IN(freeing_ends_reading, fresh, NULL)
{
    uint16_t of, page, record = land(1, 100, 1000);
    uint8_t part;
    const uint8_t *bytes;
    assert_int_equal(blackbox_read(&box, record, 0), MR_OK);
    for (unsigned n = 0; n < 20; n++)
        ms_passes();
    assert_int_equal(blackbox_get_part(&box, &of, &page, &part, &bytes), BLACKBOX_PART_READY);
    assert_int_equal(blackbox_free(&box, record), MR_OK);
    for (unsigned n = 0; n < 200; n++) {
        ms_passes();
        assert_int_equal(blackbox_get_part(&box, &of, &page, &part, &bytes), BLACKBOX_PART_NONE);
    }
    assert_int_equal(records_there(), 0);
    assert_int_equal(blackbox_read(&box, record, 0), MR_UNKNOWN);
}

/* The mark of a freed record does not hold: the record stays whole, that is a fault, and it can be
 * freed later. */
TEST_IN(a_mark_that_does_not_hold_frees_nothing, fresh, NULL)
{
    uint32_t trigger = index_now + 100;
    uint16_t record = land(1, 100, 1000);
    unsigned failed = health_get_counter(MR_FAULT_NOR_FAILED).count;
    fake_nor.faults = FAKE_NOR_PROGRAM_SILENT;
    fake_nor.to = FAKE_NOR_SIZE;
    assert_int_equal(blackbox_free(&box, record), MR_OK);
    assert_int_equal(blackbox_free(&box, record), MR_WAIT); /* one at a time */
    for (unsigned n = 0; n < 100; n++)
        ms_passes();
    assert_int_equal(health_get_counter(MR_FAULT_NOR_FAILED).count, failed + 1);
    check_whole(record, 1, 1000, trigger);
    fake_nor.faults = 0;
    assert_int_equal(blackbox_free(&box, record), MR_OK);
    for (unsigned n = 0; n < 100; n++)
        ms_passes();
    assert_int_equal(records_there(), 0);
}

/* A record's first page cannot be read any more: which landing it was is not known, all its other
 * pages are. */
TEST_IN(an_unreadable_start_page_costs_the_landings_number, fresh, NULL)
{
    uint16_t record = land(9, 100, 1000);
    fetch(record, 0);
    size_t whole = page_count;
    fake_nor.faults = FAKE_NOR_READ_ERROR;
    fake_nor.from = box.records[0].first_sector * NOR_SECTOR_BYTES;
    fake_nor.to = fake_nor.from + NOR_PAGE_BYTES;
    boot();
    assert_true(get_ready(1000));
    assert_non_null(blackbox_record_at(&box, 0));
    assert_int_equal(blackbox_record_at(&box, 0)->record, record);
    assert_int_equal(blackbox_record_at(&box, 0)->landing, 0);
    assert_true(blackbox_record_at(&box, 0)->is_complete);
    fetch(record, 0);
    assert_int_equal(page_count, whole);
    for (size_t i = 0; i < page_count; i++)
        assert_int_equal(present[i], i > 0);
}

/* From a page beyond its end: nothing comes but the end. */
TEST_IN(a_page_beyond_the_end_is_the_end, fresh, NULL)
{
    uint16_t of, page, record = land(1, 100, 1000);
    uint8_t part;
    const uint8_t *bytes;
    fetch(record, 0);
    size_t whole = page_count;
    assert_int_equal(blackbox_read(&box, record, 5000), MR_OK);
    for (unsigned n = 0; n < 1000; n++) {
        enum blackbox_part what = blackbox_get_part(&box, &of, &page, &part, &bytes);
        assert_int_not_equal(what, BLACKBOX_PART_READY);
        if (what == BLACKBOX_PART_END) {
            assert_int_equal(page, whole);
            return;
        }
        ms_passes();
    }
    fail_msg("reading never ended");
}

/* What cannot be read from where the reader was: any page of a record may be missing; then at most
 * the 16 pages to the next key and the page itself are lost with it, and what is told is true. */
TEST_IN(a_missing_page_costs_17_pages, fresh, NULL)
{
    white = true;
    fetch(land(2, 100, 600), 0);
    unsigned whole = check_pages().blocks;
    for (size_t missing = 1; missing < page_count; missing++) {
        struct mr_box_reader reader;
        struct mr_record record;
        unsigned blocks = 0;
        uint32_t last = 0;
        present[missing] = 0;
        mr_box_reader_begin(&reader, pages[0], present, page_count);
        while (mr_box_reader_next(&reader, &record) == MR_OK) {
            if (record.kind != MR_RECORD_BLOCK)
                continue;
            assert_true(blocks == 0 || record.block.index > last);
            assert_memory_equal(&record.block, &sent[record.block.index % SENT],
                                sizeof record.block);
            last = record.block.index;
            blocks++;
        }
        present[missing] = 1;
        assert_in_range(blocks, whole - 17 * 244 / 58 - 2, whole);
    }
}
