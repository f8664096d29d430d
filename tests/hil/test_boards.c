/* Each board's own image on the emulated board of that name, and on no other: chip, package, clock
 * and what is soldered to its pins. */
#include "common/image.h"
#include "firmware/boards/tables.h"
#include "hil/board/board.h"
#include "hil/core/bus.h"
#include "hil/periph/options.h"
#include "tests/cmocka_all.h"
#include "tests/hil/bench.h"

#define RCC_PLLCFGR 0x40023804u
#define GPIOF_MODER 0x40021400u
#define IDCODE      0xe0042000u
#define FLASH_SIZE  0x1fff7a20u
#define START_PS    (300u * HIL_PS_PER_MS)

static const char *const names[] = {"zg", "discovery", "nucleo446"};
#define BOARDS (sizeof names / sizeof names[0])

static const char *image_of(const char *name)
{
    static char path[80];
    snprintf(path, sizeof path, "build/firmware/%s%smatrig.elf", strcmp(name, "zg") ? name : "",
             strcmp(name, "zg") ? "/" : "");
    return path;
}

static struct hil_board *power_on(const struct hil_board_type *type)
{
    struct hil_options options;
    hil_options_default(&options);
    options.has_adc_noise = false;
    options.type = type;
    return hil_board_create(&options);
}

static struct hil_board *run(const struct hil_board_type *type, const char *name)
{
    struct hil_board *board = power_on(type);
    if (hil_board_load_elf(board, image_of(name)) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(board));
    bench_run(board, START_PS);
    return board;
}

static bool level(const struct hil_board *board, char port, unsigned pin)
{
    return hil_board_pin_level(board, (unsigned)(port - 'A'), pin);
}

TEST(an_image_runs_on_its_own_board_alone)
{
    for (size_t i = 0; i < BOARDS; i++) {
        const struct hil_board_type *told = NULL;
        char error[200];
        assert_int_equal(
            hil_board_type_from_files(image_of(names[i]), NULL, &told, error, sizeof error), MR_OK);
        assert_ptr_equal(told, hil_board_type_by_name(names[i]));
        for (size_t k = 0; k < BOARDS; k++) {
            struct hil_board *board = power_on(hil_board_type_by_name(names[k]));
            assert_int_equal(hil_board_load_elf(board, image_of(names[i])),
                             i == k ? MR_OK : MR_VERSION);
            if (i != k)
                assert_non_null(strstr(hil_board_failure_reason(board), names[i]));
            hil_board_destroy(board);
        }
    }
    assert_null(hil_board_type_by_name("nosuch"));
    assert_null(hil_board_type_by_number(99));
}

TEST(so_does_a_flash_file)
{
    uint8_t erased[64];
    memset(erased, 0xff, sizeof erased);
    for (size_t i = 0; i < BOARDS; i++) {
        struct hil_board *own = run(hil_board_type_by_name(names[i]), names[i]);
        const char *path = bench_scratch("boards.flash", own->core.memory->flash, HIL_FLASH_SIZE);
        for (size_t k = 0; k < BOARDS; k++) {
            struct hil_board *board = power_on(hil_board_type_by_name(names[k]));
            assert_int_equal(hil_board_load_flash(board, path), i == k ? MR_OK : MR_VERSION);
            if (i != k)
                assert_non_null(strstr(hil_board_failure_reason(board), names[i]));
            hil_board_destroy(board);
        }
        hil_board_destroy(own);
    }
    struct hil_board *board = power_on(hil_board_type_by_name("discovery"));
    assert_int_equal(hil_board_load_flash(board, bench_scratch("boards.flash", erased, 64)),
                     MR_HALTED); /* nothing there to run, for nobody */
    hil_board_destroy(board);
}

/* common/memory.def, from which images are linked, against the emulated board's own. */
TEST(each_has_the_memory_that_its_images_take_it_to_have)
{
    for (size_t i = 0; i < BOARDS; i++) {
        struct hil_board *board = power_on(hil_board_type_by_name(names[i]));
        const struct board_table *table =
            board_table_by_number((unsigned)mr_board_number_by_name(names[i]));
        const struct board_region *program = board_region_by_name(table, "PROGRAM"),
                                  *ram = board_region_by_name(table, "RAM"),
                                  *ccm = board_region_by_name(table, "CCM");
        unsigned long at = HIL_FLASH_BASE;
        for (size_t n = 0; n < 3; n++) { /* vectors, configuration, program: no gap */
            assert_int_equal(table->region[n].start, at);
            at += table->region[n].bytes;
        }
        assert_ptr_equal(program, &table->region[2]);
        assert_int_equal(at - HIL_FLASH_BASE, 1024ul * board->options.type->flash_kib);
        assert_int_equal(ram->start, HIL_SRAM_BASE);
        assert_int_equal(ram->bytes, HIL_SRAM_SIZE);
        assert_int_equal(ccm->start, HIL_CCM_BASE);
        assert_int_equal(ccm->bytes, board->core.has_no_ccm ? 0 : HIL_CCM_SIZE);
        hil_board_destroy(board);
    }
}

/* AN2606: device ids; what RM0090 and RM0390 say of the flash size register. */
TEST(each_chip_says_what_it_is)
{
    static const struct {
        uint32_t id, kib;
    } wanted[BOARDS] = {{0x413, 1024}, {0x413, 1024}, {0x421, 512}};
    for (size_t i = 0; i < BOARDS; i++) {
        struct hil_board *board = run(hil_board_type_by_name(names[i]), names[i]);
        const struct mr_board *told =
            mr_board_by_number((unsigned)mr_board_number_by_name(names[i]));
        assert_int_equal(hil_bus_read(&board->core, IDCODE, 4) & 0xfffu, wanted[i].id);
        assert_int_equal(hil_bus_read(&board->core, FLASH_SIZE, 4) >> 16, wanted[i].kib);
        assert_int_equal(told->chip, wanted[i].id);
        assert_int_equal(board->core.state.clock.hclk_hz, 168000000);
        assert_true(hil_bus_read(&board->core, RCC_PLLCFGR, 4) >> 22 & 1u); /* from OSC_IN */
        assert_true(hil_board_counters(board)->serial_bytes_out > 100);
        assert_int_equal(hil_board_counters(board)->serial_bytes_garbled, 0);
        assert_true(hil_board_counters(board)->can_frames_out > 10);
        hil_board_destroy(board);
    }
}

/* A crystal in place of the ST-LINK's clock, and the other way round: the internal oscillator. */
TEST(what_feeds_the_clock_matters)
{
    for (size_t i = 0; i < BOARDS; i++) {
        struct hil_board_type other = *hil_board_type_by_name(names[i]);
        other.has_clock_bypass = !other.has_clock_bypass;
        struct hil_board *board = run(&other, names[i]);
        assert_false(hil_bus_read(&board->core, RCC_PLLCFGR, 4) >> 22 & 1u);
        assert_int_equal(board->core.state.clock.hclk_hz, 168000000);
        hil_board_destroy(board);
    }
}

TEST(a_pin_that_the_package_lacks_stops_the_run)
{
    for (size_t i = 0; i < BOARDS; i++) {
        struct hil_board *board = run(hil_board_type_by_name(names[i]), names[i]);
        hil_bus_write(&board->core, 0x40023830u, 4,
                      hil_bus_read(&board->core, 0x40023830u, 4) | 1u << 5);
        hil_bus_write(&board->core, GPIOF_MODER, 4, 3u << 6);
        bool stopped = board->core.is_stopped;
        assert_int_equal(stopped, strcmp(names[i], "discovery") == 0);
        if (stopped)
            assert_non_null(strstr(hil_board_failure_reason(board), "PF3"));
        hil_board_destroy(board);
    }
}

/* UM1472: the motion sensor is not selected, the audio converter stays in reset, the USB socket has
 * no power. While the sensor's select floats it has PA6, gage 3's. */
TEST(the_discovery_keeps_its_own_chips_off)
{
    const struct hil_board_type *type = hil_board_type_by_name("discovery");
    const int gage_3 = 8 + 3 - 1;
    struct hil_board *board = power_on(type);
    assert_true(hil_rig_channel_volts(&board->rig, gage_3, 0) < 1e-9);
    hil_board_destroy(board);
    board = run(type, "discovery");
    assert_true(level(board, 'E', 3));
    assert_false(level(board, 'D', 4));
    assert_true(level(board, 'C', 0));
    assert_true(level(board, 'E', 4)); /* lamp off: nothing warns */
    assert_true(level(board, 'B', 12));
    double volts = hil_rig_channel_volts(&board->rig, gage_3, hil_now_cycle(&board->core));
    assert_true(volts > 0.39 && volts < 0.41); /* no tension: 0.4 V */
    hil_board_destroy(board);
}
