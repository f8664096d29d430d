/* The slow log against a memory that tears, wears and fails, beside the black box: rows are what
 * was measured or are not there. */
#include "tests/firmware/fake_i2c.h"
#include "tests/firmware/fake_nor.h"
#include "tests/firmware/play.h"

#include "firmware/health.h"
#include "firmware/norshare.h"

#define FIRST_BYTE (NOR_SECTORS * NOR_SECTOR)
#define ROWS_MAX   4000u

static struct blackbox box;
static struct slowlog row_log;
static struct runwaystore runway;
static struct predict predict; /* does not run */
static float slack_in[MR_SEGMENTS];
static uint32_t now;
static bool quiet;

static struct mr_slowrow told[ROWS_MAX]; /* as the links bring them */
static unsigned told_count, ends;
static struct mr_slow_end last_end;
static struct mr_slowrow_reader reader;

static void ms_passes(void)
{
    uint16_t id;
    uint8_t payload[MR_MESSAGE_MAX];
    for (unsigned i = 0; i < 4; i++) {
        norshare_poll(&(struct norshare){&box, &row_log, &runway, &predict, slack_in}, now, quiet);
        fake_nor.now_us += 250;
    }
    for (unsigned i = 0; i < APP_SLOW_PARTS; i++) {
        size_t length = slowlog_take_part(&row_log, &id, payload);
        if (length && id == MR_ID_SLOW_END) {
            ends++;
            assert_int_equal(mr_slow_end_get(&last_end, payload, length), MR_OK);
        } else if (length && mr_slowrow_take(&reader, id, payload, length) == MR_OK) {
            assert_true(told_count < ROWS_MAX);
            told[told_count++] = reader.row;
        }
    }
}

/* What a minute measures follows from its block: any row can be checked. */
static float displacement(uint32_t block, unsigned i)
{
    return 0.001f * (float)(block / 60000u % 500u) - 0.01f * (float)i;
}
static float tension(uint32_t block, unsigned i)
{
    return 50.0f + (float)(block / 60000u % 40u) + (float)i;
}
static float celsius(uint32_t block)
{
    return 20.0f - 0.0625f * (float)(block / 60000u % 600u);
}

static void check_row(const struct mr_slowrow *row)
{
    assert_int_equal(row->block % 60000, 0);
    assert_true(row->temperature_c == celsius(row->block));
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_near(row->displacement_in[i], displacement(row->block, i), 0.00006);
    for (unsigned i = 0; i < MR_GAGES; i++)
        assert_near(row->tension_lb[i], tension(row->block, i), 0.011);
}

/* The last blocks of each minute are enough: the firmware's time is the index of the block. */
static void minutes(unsigned count)
{
    while (count--) {
        uint32_t end = now - now % 60000u + 60000u;
        for (uint32_t block = end - 20; block <= end + 40 && !fake_nor.dark; block++) {
            float in[MR_TRANSDUCERS], lb[MR_GAGES];
            now = block;
            for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
                in[i] = displacement(end, i);
            for (unsigned i = 0; i < MR_GAGES; i++)
                lb[i] = tension(end, i);
            slowlog_block(&row_log, &(struct slowlog_block){now, in, lb, celsius(end), 0, true});
            ms_passes();
        }
    }
}

static void boot(void)
{
    fake_nor_power();
    now = 0;
    quiet = true;
    reader.parts = 0;
    blackbox_start(&box);
    slowlog_start(&row_log);
}

static void settle(void)
{
    for (unsigned n = 0; n < 20000 && (!row_log.scanned || box.state == BLACKBOX_SCANNING); n++)
        ms_passes();
    assert_true(row_log.scanned);
}

static int fresh(void **state)
{
    (void)state;
    fake_nor_reset();
    told_count = ends = 0;
    boot();
    settle();
    return 0;
}

static unsigned read_all(uint32_t from)
{
    told_count = ends = 0;
    assert_int_equal(slowlog_read(&row_log, from), MR_OK);
    for (unsigned n = 0; n < 100000 && !ends; n++)
        ms_passes();
    assert_int_equal(ends, 1);
    for (unsigned i = 0; i < told_count; i++)
        check_row(&told[i]);
    return told_count;
}

static void a_night(void **state)
{
    (void)state;
    health_count(MR_FAULT_CAN_BUS_OFF, 0);
    minutes(12 * 60);
    assert_int_equal(told_count, 720); /* each as it was made */
    for (unsigned i = 0; i < 720; i++) {
        assert_int_equal(told[i].seq, i + 1);
        assert_int_equal(told[i].block, 60000 * (i + 1));
        assert_int_equal(told[i].boot, 1);
        assert_int_equal(told[i].faults, 1u << MR_FAULT_CAN_BUS_OFF);
        check_row(&told[i]);
    }
    assert_int_equal(read_all(0), 720);
    assert_int_equal(last_end.next_seq, 721);
    assert_int_equal(last_end.rows, 720);
    assert_int_equal(read_all(700), 21); /* resumed */
    assert_int_equal(told[0].seq, 700);
    assert_int_equal(read_all(721), 0);

    boot(); /* the supply went and came */
    settle();
    minutes(2);
    assert_int_equal(read_all(719), 4);
    assert_int_equal(told[1].boot, 1);
    assert_int_equal(told[2].boot, 2);
    assert_int_equal(told[3].seq, 722);
    assert_int_equal(told[3].block, 120000);
}

/* The oldest sectors go, 26.7 hours stay; and the black box's sectors are never touched. */
static void the_ring_goes_round(void **state)
{
    (void)state;
    uint64_t least = UINT64_MAX;
    for (unsigned hour = 0; hour < 80; hour++) {
        told_count = 0;
        minutes(60);
        if (hour >= 40 && slowlog_rows(&row_log) < least)
            least = slowlog_rows(&row_log);
    }
    print_message("# at least %llu rows held\n", (unsigned long long)least);
    assert_in_range(least, 25 * 64, 26 * 64);
    unsigned rows = read_all(0);
    assert_int_equal(rows, slowlog_rows(&row_log));
    for (unsigned i = 0; i < rows; i++)
        assert_int_equal(told[i].seq, 4800 - rows + 1 + i);
    for (uint32_t i = 0; i < FIRST_BYTE; i++)
        assert_int_equal(fake_nor.cell[i], 0xff);
    assert_int_equal(fake_nor.overwritten, 0);
    boot();
    settle();
    assert_int_equal(read_all(0), rows);
}

/* Rows are told in order, none is wrong and all that were kept before the power went are there. */
static void power_cuts(unsigned before, unsigned operations)
{
    static uint8_t image[SLOWLOG_SECTORS * NOR_SECTOR];
    minutes(before);
    memcpy(image, fake_nor.cell + FIRST_BYTE, sizeof image);
    for (unsigned cut = 1; cut <= operations; cut++) {
        for (unsigned permille = 0; permille <= 1000; permille += 250) {
            memset(fake_nor.cell, 0xff, sizeof fake_nor.cell);
            memcpy(fake_nor.cell + FIRST_BYTE, image, sizeof image);
            boot();
            settle();
            unsigned held = read_all(0);
            uint32_t first = told[0].seq, last = told[held - 1].seq;
            told_count = 0;
            fake_nor.operations = 0;
            fake_nor.cut_at = cut;
            fake_nor.cut_permille = permille;
            minutes(6);
            assert_true(fake_nor.dark);
            uint32_t kept = told_count ? told[told_count - 1].seq : last;
            if (row_log.has_news || row_log.part != MR_SLOWROW_PARTS)
                kept++; /* verified, and being told */
            boot();
            settle();
            unsigned rows = read_all(0);
            assert_true(rows > 0);
            assert_true(told[0].seq <= first + 64); /* a sector that was being erased, no more */
            for (unsigned i = 1; i < rows; i++)
                assert_true(told[i].seq >= told[i - 1].seq + (told[i].seq > first + 64));
            /* the last may have been complete when it went */
            assert_in_range(told[rows - 1].seq, kept, kept + 1);
            minutes(70); /* and it goes on, over the next end of a sector */
            assert_int_equal(told[told_count - 1].seq, told[rows - 1].seq + 70);
            assert_int_equal(fake_nor.overwritten, 0); /* nothing over what was torn */
        }
    }
}

static void the_power_goes_at_any_operation_of_rows(void **state)
{
    (void)state;
    power_cuts(10, 5);
}

/* Where the ring has gone round: the first operations are the erase ahead, then rows across the end
 * of a sector. */
static void the_power_goes_at_an_erase(void **state)
{
    (void)state;
    told_count = 0;
    for (unsigned i = 0; i < 32; i++) {
        told_count = 0;
        minutes(64);
    }
    told_count = 0;
    power_cuts(61, 7);
}

static void bad_places_are_passed_over(void **state)
{
    static const unsigned faults[] = {FAKE_NOR_PROGRAM_SILENT, FAKE_NOR_PROGRAM_ERROR};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        fresh(state);
        fake_nor.faults = faults[i];
        fake_nor.from = FIRST_BYTE + 256;
        fake_nor.to = FIRST_BYTE + 512;
        minutes(20);
        assert_int_equal(told_count, 20);
        assert_int_equal(read_all(0), 20);
        assert_int_equal(told[19].seq, 20);
    }
}

/* A memory that takes nothing any more: the row of that minute is lost, told as a fault, and its
 * number with it; the next is kept. */
static void a_row_that_finds_no_place_is_lost_alone(void **state)
{
    (void)state;
    minutes(5);
    uint16_t before = health_counted(MR_FAULT_NOR_FAILED);
    fake_nor.faults = FAKE_NOR_PROGRAM_SILENT;
    fake_nor.to = FAKE_NOR_SIZE;
    minutes(1);
    assert_int_equal(told_count, 5);
    assert_int_equal(health_counted(MR_FAULT_NOR_FAILED), before + 1);
    fake_nor.faults = 0;
    minutes(5);
    assert_int_equal(read_all(0), 10);
    for (unsigned i = 0; i < 10; i++)
        assert_int_equal(told[i].seq, i < 5 ? i + 1 : i + 2);
}

static void a_sector_that_does_not_erase_is_left_out(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 32; i++) {
        told_count = 0;
        minutes(64);
    }
    fake_nor.faults = FAKE_NOR_ERASE_SILENT;
    fake_nor.from = FIRST_BYTE + 10 * NOR_SECTOR;
    fake_nor.to = FIRST_BYTE + 11 * NOR_SECTOR;
    uint32_t seq = row_log.next_seq;
    for (unsigned i = 0; i < 32; i++) {
        told_count = 0;
        minutes(64);
    }
    assert_int_equal(row_log.next_seq, seq + 32 * 64);
    assert_int_equal(row_log.bad, 1u << 10);
    told_count = 0;
    unsigned rows = read_all(seq);
    assert_true(rows >= 24 * 64);
}

/* Nothing is erased while a landing is armed, for four hours of it, and rows go on. */
static void standing_armed(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 33; i++) {
        told_count = 0;
        minutes(64);
    }
    uint64_t erases = fake_nor.erases;
    told_count = 0;
    box.armed = true;
    for (unsigned i = 0; i < 240; i++) {
        quiet = false;
        minutes(1);
    }
    assert_int_equal(told_count, 240);
    assert_int_equal(fake_nor.erases, erases);
    quiet = true;
    box.armed = false;
    minutes(1);
    ms_passes();
    assert_true(fake_nor.erases > erases);
}

/* A configuration without the black box leaves the memory alone: rows are told at once, as without
 * one. */
static void rows_are_told_without_the_box(void **state)
{
    (void)state;
    uint16_t failed = health_counted(MR_FAULT_NOR_FAILED);
    blackbox_leave_out(&box);
    minutes(6);
    assert_int_equal(told_count, 6);
    assert_int_equal(told[5].seq, 0);
    assert_int_equal(health_counted(MR_FAULT_NOR_FAILED), failed);
    assert_int_equal(slowlog_read(&row_log, 1), MR_NOT_NOW);
    blackbox_start(&box);
    minutes(2);
    assert_int_equal(told_count, 8);
    assert_int_not_equal(told[7].seq, 0);
}

/* The box erases for minutes: rows wait, and are told when it lets go; one too many shows as a
 * number that is missing. */
static void the_box_goes_first(void **state)
{
    (void)state;
    minutes(1);
    box.state = BLACKBOX_RECORDING; /* it would write if it had a page */
    box.end_written = false;
    uint64_t operations = fake_nor.operations;
    minutes(4);
    assert_int_equal(fake_nor.operations, operations);
    assert_int_equal(told_count, 1);
    box.state = BLACKBOX_ROLLING;
    for (unsigned n = 0; n < 100; n++)
        ms_passes();
    assert_int_equal(told_count, 5);
    box.state = BLACKBOX_RECORDING;
    minutes(6);
    box.state = BLACKBOX_ROLLING;
    for (unsigned n = 0; n < 100; n++)
        ms_passes();
    assert_int_equal(told_count, 9);
    assert_int_equal(told[4].seq, 5);
    assert_int_equal(told[5].seq, 8); /* 6 and 7 found no room */
    assert_int_equal(told[8].seq, 11);
}

/* An erase of the log is known to the box, which begins its landing with as much room as beside one
 * of its own. */
static void an_erase_under_way_is_told_to_the_box(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 28; i++) {
        told_count = 0;
        minutes(64);
    }
    bool seen = false;
    for (unsigned n = 0; n < 200 && !seen; n++) {
        if (n % 3 == 0)
            minutes(1);
        for (unsigned k = 0; k < 50 && !seen; k++) {
            ms_passes();
            seen = slowlog_erasing(&row_log);
            assert_int_equal(box.waits, seen);
        }
    }
    assert_true(seen);
}

/* Through the application: none during a landing, one as soon as it is over; numbers from the pins'
 * codes. */
static void rows_of_the_application(void **state)
{
    (void)state;
    fake_nor_reset();
    fake_nor.present = false;
    start(state);
    fake_i2c_reset();
    fake_i2c.temperature = 0xff80; /* -0.5 C */
    moved_in[2] = 0.1875f;         /* 3/16 in overnight */
    play(2000);
    index_now = 54000;
    play(6200);
    assert_int_equal(count_frames(MR_ID_SLOW_ROW), 1);
    memset(&reader, 0, sizeof reader);
    unsigned rows = 0;
    for (size_t i = 0; i < fake.sent_count; i++)
        rows += mr_slowrow_take(&reader, fake.sent[i].id, fake.sent[i].data, fake.sent[i].length) ==
                MR_OK;
    assert_int_equal(rows, 1);
    assert_int_equal(reader.row.seq, 0); /* there is no memory to keep it */
    assert_int_equal(reader.row.block, 60000);
    assert_true((double)reader.row.temperature_c == -0.5);
    assert_near(reader.row.displacement_in[2], 0.1875, 0.0006);
    assert_near(reader.row.displacement_in[0], 0.0, 0.0006);
    assert_near(reader.row.tension_lb[13], 113.0, 0.1);

    index_now = 115000;
    command("arm 5");
    play(1);
    touchdown_s = 116.0;
    (void)fly(124.5);
    assert_int_equal(app.landing.state, LANDING_DONE);
    assert_int_equal(count_frames(MR_ID_SLOW_ROW), 1);
    play(4200);
    assert_int_equal(count_frames(MR_ID_SLOW_ROW), 2);
    struct mr_slow_state slow;
    GET_LAST(slow_state, SLOW_STATE, &slow);
    assert_int_equal(slow.state >> 6, 2);
}

static void commands(void **state)
{
    struct mr_ack ack;
    (void)state;
    fake_nor_reset();
    start(state);
    fake_i2c_reset();
    command("slow-read 1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_WAIT);
    play(3000);
    command("slow-read -1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_USAGE);
    command("slow-read 1");
    play(2000);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_OK);
    assert_int_equal(count_frames(MR_ID_SLOW_END), 1);
    command("arm 1");
    command("slow-read 1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    fake_nor.present = false;
    start(state);
    command("slow-read 1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_night, fresh),
        cmocka_unit_test_setup(the_ring_goes_round, fresh),
        cmocka_unit_test_setup(the_power_goes_at_any_operation_of_rows, fresh),
        cmocka_unit_test_setup(the_power_goes_at_an_erase, fresh),
        cmocka_unit_test(bad_places_are_passed_over),
        cmocka_unit_test_setup(a_sector_that_does_not_erase_is_left_out, fresh),
        cmocka_unit_test_setup(standing_armed, fresh),
        cmocka_unit_test_setup(rows_are_told_without_the_box, fresh),
        cmocka_unit_test_setup(the_box_goes_first, fresh),
        cmocka_unit_test_setup(an_erase_under_way_is_told_to_the_box, fresh),
        cmocka_unit_test(rows_of_the_application),
        cmocka_unit_test(commands),
        cmocka_unit_test_setup(a_row_that_finds_no_place_is_lost_alone, fresh),
    };
    return cmocka_run_group_tests_name("firmware/slowlog", tests, NULL, NULL);
}
