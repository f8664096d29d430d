/* The stored configuration on the emulated board: the firmware as it is, its flash driver, and a
 * flash that stands still, takes its time and tears. */
#include "common/config.h"
#include "common/wire.h"
#include "hil/board/board.h"
#include "hil/core/bus.h"
#include "tests/hil/ear.h"
#include "tests/hil/snapshot.h"

#define COPY(n) (0x08008000u + 0x4000u * (n))
#define POINTS  24u

static struct mr_config now;
static uint8_t image[MR_CONFIG_IMAGE_BYTES];
static uint16_t tag = 500;

static double time_s(const struct ear *ear)
{
    return (double)hil_board_now_ps(ear->board) * 1e-12;
}

static void pass(struct ear *ear, double s)
{
    ear_until(ear, time_s(ear) + s);
}

static struct mr_ack last_ack(const struct ear *ear, unsigned link)
{
    struct mr_ack ack = {0};
    assert_int_equal(mr_ack_get(&ack, ear->last[link][MR_ID_ACK], MR_MESSAGE_BYTES_MAX), MR_OK);
    assert_int_equal(ack.tag, tag);
    return ack;
}

/* What is in force, as the board tells it, over CAN. */
static void read_out(struct ear *ear, struct mr_config *config)
{
    uint8_t told[MR_CONFIG_IMAGE_BYTES];
    unsigned words = 0;
    ear->listens = true;
    ear->said_count[EAR_CAN] = ear->said_count[EAR_SERIAL] = 0;
    ear_command(ear, EAR_CAN, MR_COMMAND_CONFIG_READ, 0, ++tag);
    pass(ear, 0.5);
    assert_int_equal(last_ack(ear, EAR_CAN).status, MR_OK);
    for (unsigned i = 0; i < ear->said_count[EAR_SERIAL]; i++)
        /* only the link that asked */
        assert_int_not_equal(ear->said[EAR_SERIAL][i].id, MR_ID_CONFIG_IMAGE);
    for (unsigned i = 0; i < ear->said_count[EAR_CAN]; i++) {
        const struct ear_said *said = &ear->said[EAR_CAN][i];
        struct mr_config_image word;
        if (said->id != MR_ID_CONFIG_IMAGE)
            continue;
        assert_int_equal(mr_config_image_get(&word, said->payload, MR_MESSAGE_BYTES_MAX), MR_OK);
        assert_int_equal(word.offset, words++);
        assert_true(word.offset < MR_CONFIG_WORDS);
        mr_put_u32(told + 4 * word.offset, word.value);
    }
    assert_int_equal(words, MR_CONFIG_WORDS);
    assert_int_equal(mr_config_decode(told, sizeof told, config), MR_OK);
}

static void send_words(struct ear *ear)
{
    for (unsigned i = 0; i < MR_CONFIG_WORDS; i++) {
        struct hil_can_frame frame = {.id = MR_ID_CONFIG_WORD, .length = 8};
        const uint8_t *p = image + 4 * i;
        struct mr_config_word word = {.offset = (uint16_t)i, .tag = tag, .value = mr_get_u32(&p)};
        mr_config_word_put(&word, frame.data);
        assert_int_equal(hil_can_inject(&ear->board->mcu.can, &frame), MR_OK);
        if (i % 16 == 15)
            pass(ear, 0.012);
    }
    pass(ear, 0.012);
}

/* The next revision, staged. Returns its CRC. */
static uint32_t stage(struct ear *ear, struct mr_config *next)
{
    *next = now;
    next->site[0].revision++;
    next->site[0].touchdown_ft += 0.5f;
    next->gate[23].station_ft += 0.125f;
    uint32_t crc = mr_config_encode(next, image);
    tag++;
    send_words(ear);
    return crc;
}

static void change(struct ear *ear)
{
    struct mr_config next;
    uint32_t crc = stage(ear, &next);
    ear_command(ear, EAR_CAN, MR_COMMAND_CONFIG_APPLY, (int32_t)crc, tag);
    pass(ear, 0.75);
    assert_int_equal(last_ack(ear, EAR_CAN).status, MR_OK);
    now = next;
}

static uint32_t told_crc(const struct ear *ear)
{
    struct mr_board_config told;
    assert_int_equal(mr_board_config_get(&told, ear->last[EAR_CAN][MR_ID_BOARD_CONFIG], 8), MR_OK);
    return told.config_crc;
}

/* A change stops sampling, once, for as long as the sector takes; that is told, and nothing else
 * happens: not even with the slowest erase and the fastest watchdog, which would be through in 0.34
 * s. */
TEST(a_change_costs_blocks_and_nothing_else)
{
    static const struct {
        enum hil_cell_times times;
        uint32_t lsi_hz;
        double least_s, most_s;
    } cases[] = {{HIL_TIMES_MAXIMUM, 47000, 0.5, 0.7}, {HIL_TIMES_TYPICAL, 17000, 0.25, 0.3}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct hil_options options = ear_options();
        options.cell_times = cases[i].times;
        options.lsi_hz = cases[i].lsi_hz;
        struct ear *ear = ear_open(&options, 0);
        struct mr_health health;
        struct mr_clock clock;
        ear_until(ear, 1.5);
        read_out(ear, &now);
        for (unsigned round = 1; round <= 2; round++) {
            uint8_t stored[MR_CONFIG_IMAGE_BYTES];
            change(ear);
            pass(ear, 0.2);
            assert_int_equal(hil_board_peek(ear->board, COPY(round - 1), stored, sizeof stored),
                             MR_OK);
            assert_memory_equal(stored, image, sizeof image);
            assert_int_equal(told_crc(ear), mr_config_encode(&now, image));
            assert_int_equal(mr_health_get(&health, ear->last[EAR_CAN][MR_ID_HEALTH], 8), MR_OK);
            assert_true(health.blocks_lost >= round * cases[i].least_s * 1000.0);
            assert_true(health.blocks_lost <= round * cases[i].most_s * 1000.0);
            assert_int_equal(health.faults, 0);
            /* blocks keep their place on the clock: the first trigger of block n is at 2352 + 84000
             * n */
            assert_int_equal(mr_clock_get(&clock, ear->last[EAR_CAN][MR_ID_CLOCK], 8), MR_OK);
            assert_int_equal(clock.tick, 2352u + 84000u * clock.block);
        }
        struct mr_config back;
        read_out(ear, &back);
        assert_int_equal(mr_config_encode(&back, image), mr_config_encode(&now, image));
        assert_int_equal(hil_board_counters(ear->board)->resets, 0);
        assert_int_equal(hil_board_counters(ear->board)->flash_errors, 0);
        /* afterwards the flash is locked (FLASH_CR), and the watchdog has half a second again
         * (IWDG_RLR, LSI / 32): RM0090 3.9.7, 21.4.3 */
        assert_int_equal(hil_bus_read(&ear->board->core, 0x40023c10u, 4) >> 31, 1);
        assert_int_equal(hil_bus_read(&ear->board->core, 0x40003008u, 4), 500);
        print_message("# %s: %u blocks lost in two changes\n",
                      i ? "typical times" : "longest times", health.blocks_lost);
        ear_close(ear);
    }
}

/* A page of the other memory is being programmed when the change begins, and half a second later it
 * seems to take for ever: the memory is neither slow nor gone. Several moments, each in a fork. */
TEST(a_change_is_not_the_time_of_the_other_memory)
{
    struct hil_options options = ear_options();
    unsigned tried = 0;
    options.cell_times = HIL_TIMES_MAXIMUM;
    struct ear *ear = ear_open(&options, 0), *fork = malloc(sizeof *fork);
    struct mr_config next;
    assert_non_null(fork);
    ear_until(ear, 1.0);
    read_out(ear, &now);
    uint32_t crc = stage(ear, &next);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_RUNWAY_FORGET, 0, 1); /* the runway is stored anew */
    for (unsigned step = 0; step < 15000 && tried < 8; step++) {
        pass(ear, 200e-6);
        const struct hil_w25q *nor = &ear->board->state.w25q;
        double left_ms = ((double)nor->operation_end_ps - (double)hil_board_now_ps(ear->board)) *
                         1e-9;
        if (nor->operation_command != 0x02 || left_ms < 1.0 + 0.2 * tried)
            continue;
        *fork = *ear;
        ear_attach(fork, snapshot_fork(ear->board));
        ear_command(fork, EAR_CAN, MR_COMMAND_CONFIG_APPLY, (int32_t)crc, tag);
        pass(fork, 1.0);
        assert_int_equal(last_ack(fork, EAR_CAN).status, MR_OK);
        assert_int_equal(ear_faults(fork, EAR_CAN), 0);
        hil_board_destroy(fork->board);
        tried++;
    }
    assert_int_equal(tried, 8);
    free(fork);
    ear_close(ear);
}

/* A landing after a change is one by the new configuration: stations of all gates moved, and so the
 * stop. */
TEST(a_landing_is_by_the_new_configuration)
{
    struct ear *ear = ear_open(NULL, 0);
    struct mr_switch_place place;
    ear_until(ear, 1.0);
    read_out(ear, &now);
    change(ear);
    pass(ear, 0.2);
    unsigned seen = 0;
    for (unsigned i = 0; i < ear->said_count[EAR_CAN]; i++) {
        const struct ear_said *said = &ear->said[EAR_CAN][i];
        if (said->id == MR_ID_SWITCH_PLACE &&
            mr_switch_place_get(&place, said->payload, 8) == MR_OK && place.position == 24)
            seen = (unsigned)(place.station_ft * 1000.0f + 0.5f);
    }
    assert_int_equal(seen, 112625); /* 112.5 and an eighth */
    ear_close(ear);
}

/* One fork: cut in the n-th flash operation from now. True: the new one is in force after it. */
static bool cut_here(const struct ear *base, const struct mr_config *old,
                     const struct mr_config *new, uint64_t n, unsigned permille)
{
    struct ear *ear = calloc(1, sizeof *ear);
    static uint8_t scratch[MR_CONFIG_IMAGE_BYTES];
    assert_non_null(ear);
    mr_deframer_init(&ear->deframer);
    ear_attach(ear, snapshot_fork(base->board));
    uint32_t old_crc = mr_config_encode(old, scratch), new_crc = mr_config_encode(new, scratch);
    bench_cut_at(ear->board, false, n, permille);
    ear_command(ear, EAR_CAN, MR_COMMAND_CONFIG_APPLY, (int32_t)new_crc, tag);
    pass(ear, 0.9);
    assert_int_equal(hil_board_counters(ear->board)->power_cuts, 1);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_ACK], 0); /* it never came so far as to say so */
    uint32_t crc = told_crc(ear);
    assert_true(crc == old_crc || crc == new_crc);
    struct mr_config back, kept = now;
    read_out(ear, &back);
    assert_int_equal(mr_config_encode(&back, scratch), crc);
    now = back;
    change(ear); /* and the next one goes through */
    pass(ear, 0.1);
    assert_int_equal(told_crc(ear), mr_config_encode(&now, scratch));
    now = kept;
    hil_board_destroy(ear->board);
    free(ear);
    return crc == new_crc;
}

TEST(the_power_goes_at_24_points)
{
    struct ear *ear = ear_open(NULL, 0);
    struct mr_config old, new;
    unsigned news = 0;
    ear_until(ear, 1.0);
    read_out(ear, &now);
    change(ear);
    change(ear); /* both copies are in use */
    old = now;
    stage(ear, &new);
    uint16_t staged = tag;
    for (unsigned i = 0; i < POINTS; i++) {
        /* eight in the erase, twelve over the words, four in the last two */
        uint64_t n = i < 8  ? 1
                   : i < 20 ? 2 + (uint64_t)(i - 8) * MR_CONFIG_WORDS / 12
                            : MR_CONFIG_WORDS + i % 2;
        tag = staged;
        news += cut_here(ear, &old, &new, n, i < 8 ? i * 142u : i * 389u % 1000u);
    }
    print_message("# %u cuts: %u times the new one, %u times the old one, never neither\n", POINTS,
                  news, POINTS - news);
    assert_true(news < 6);
    ear_close(ear);
}

/* A bit of the newer copy falls over: the older one is in force, and the fault says which. */
TEST(a_damaged_copy_is_told)
{
    struct ear *ear = ear_open(NULL, 0);
    struct mr_config first;
    uint8_t byte;
    ear_until(ear, 1.0);
    read_out(ear, &now);
    change(ear);
    first = now;
    change(ear);
    assert_int_equal(hil_board_peek(ear->board, COPY(1) + 777, &byte, 1), MR_OK);
    byte ^= 0x10;
    assert_int_equal(hil_board_poke(ear->board, COPY(1) + 777, &byte, 1), MR_OK);
    hil_supply_cut(&ear->board->supply);
    pass(ear, 1.7);
    assert_int_equal(told_crc(ear), mr_config_encode(&first, image));
    assert_int_equal(ear_faults(ear, EAR_CAN) & EAR_BIT(CONFIG), EAR_BIT(CONFIG));
    assert_int_equal(ear->fault[MR_FAULT_CONFIG].detail, 2);
    ear_close(ear);
}
