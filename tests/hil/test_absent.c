/* Rigs that lack channels: images whose configuration leaves them out (Makefile, variants). What
 * they have measures as it does beside all the rest, and what they lack costs nothing. */
#include <math.h>

#include "tests/hil/ear.h"

#define FULL          EAR_ELF
#define VARIANT(name) "build/tests/variant/" name ".elf"
#define BLOCKS_MAX    12000

struct heard {
    struct hil_board *board;
    struct mr_block block[BLOCKS_MAX];
    size_t blocks, block_bytes;
    struct mr_edge edge[32];
    size_t edges;
    struct mr_ack armed;
    struct {
        uint16_t id;
        uint8_t payload[MR_MESSAGE_BYTES_MAX];
    } said[30000]; /* on CAN */
    size_t count;
    struct mr_deframer deframer;
};

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct heard *heard = ctx;
    struct mr_ack ack;
    (void)t_ps;
    assert_true(heard->count < COUNT_OF(heard->said));
    heard->said[heard->count].id = (uint16_t)frame->id;
    memcpy(heard->said[heard->count++].payload, frame->data, MR_MESSAGE_BYTES_MAX);
    if (frame->id == MR_ID_EDGE && heard->edges < COUNT_OF(heard->edge))
        assert_int_equal(mr_edge_get(&heard->edge[heard->edges++], frame->data, frame->length),
                         MR_OK);
    if (frame->id == MR_ID_ACK && mr_ack_get(&ack, frame->data, frame->length) == MR_OK &&
        ack.code == MR_COMMAND_ARM)
        heard->armed = ack;
}

static void on_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct heard *heard = ctx;
    struct mr_frame frame;
    (void)t_ps;
    for (size_t i = 0; i < n; i++) {
        if (mr_deframer_push(&heard->deframer, bytes[i], &frame) != MR_OK ||
            frame.type != MR_ID_BLOCK)
            continue;
        assert_true(heard->blocks < BLOCKS_MAX);
        assert_int_equal(
            mr_block_decode(&heard->block[heard->blocks++], frame.payload, frame.length), MR_OK);
        heard->block_bytes = frame.length;
    }
}

/* A board with `elf`; the caller runs it and closes it. */
static struct heard *open_board(const char *elf)
{
    struct heard *heard = calloc(1, sizeof *heard);
    struct hil_options options = ear_options();
    struct hil_callbacks callbacks = {heard, on_can, on_serial};
    assert_non_null(heard);
    mr_deframer_init(&heard->deframer);
    heard->board = hil_board_create(&options);
    if (hil_board_load_elf(heard->board, elf) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(heard->board));
    hil_board_set_callbacks(heard->board, &callbacks);
    return heard;
}

static void close_board(struct heard *heard)
{
    hil_board_destroy(heard->board);
    free(heard);
}

static struct hil_run landing5;

static struct heard *fly(const char *elf)
{
    struct heard *heard = open_board(elf);
    hil_board_attach_rig(heard->board, &landing5);
    bench_run(heard->board, 9100000000000u);
    assert_true(heard->blocks > 5000);
    return heard;
}

static struct heard *full;

static int fly_full(void **state)
{
    (void)state;
    char error[256];
    if (hil_run_read("tests/runs/landing5.run", &landing5, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    full = fly(FULL);
    return 0;
}

static int put_away(void **state)
{
    (void)state;
    close_board(full);
    hil_run_free(&landing5);
    return 0;
}

static size_t count(const struct heard *heard, uint16_t id)
{
    size_t n = 0;
    for (size_t i = 0; i < heard->count; i++)
        n += heard->said[i].id == id;
    return n;
}

static const uint8_t *last(const struct heard *heard, uint16_t id)
{
    for (size_t i = heard->count; i-- > 0;) {
        if (heard->said[i].id == id)
            return heard->said[i].payload;
    }
    fail_msg("no message 0x%03x", id);
    return NULL;
}

static struct mr_touchdown touchdown(const struct heard *heard)
{
    struct mr_touchdown message;
    assert_int_equal(mr_touchdown_get(&message, last(heard, MR_ID_TOUCHDOWN), MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    return message;
}

static uint32_t faults(const struct heard *heard)
{
    struct mr_health health;
    assert_int_equal(mr_health_get(&health, last(heard, MR_ID_HEALTH), MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    return health.faults;
}

static unsigned sequence_length(const struct heard *heard, unsigned unit)
{
    return (heard->board->state.mcu.adc[unit].sqr[0] >> 20 & 15u) + 1u;
}

/* ---- the same landing on the rig ---- */

static void assert_same_landing(const struct heard *some)
{
    struct mr_touchdown a = touchdown(full), b = touchdown(some);
    /* scans begin some microseconds apart, for the images start at another speed: not a digit of
     * the speed depends on it */
    assert_true(fabsf(a.speed_ft_s - b.speed_ft_s) < 0.0005f);
    assert_int_equal(full->edges, some->edges);
    assert_int_equal(faults(some), faults(full));
}

TEST(four_transducers_measure_the_same)
{
    struct heard *four = fly(VARIANT("four"));
    assert_same_landing(four);
    assert_int_equal(sequence_length(full, HIL_ADC1), 16);
    assert_int_equal(sequence_length(full, HIL_ADC3), 8);
    assert_int_equal(sequence_length(four, HIL_ADC1), 2);
    assert_int_equal(sequence_length(four, HIL_ADC3), 4);
    assert_int_equal(full->block_bytes, 78);
    assert_int_equal(four->block_bytes, 8 + 3 + 2 * (4 * 2 + 2) + 3);
    const struct mr_block *a = &full->block[full->blocks - 1], *b = &four->block[four->blocks - 1];
    assert_int_equal(b->absent_channels, 0x3ffff0);
    for (unsigned i = 0; i < 4; i++) { /* at rest again, where the landing left them */
        assert_in_range(a->forward_sum[i] - b->forward_sum[i] + 1, 0, 2);
        assert_in_range(a->reversed_sum[i] - b->reversed_sum[i] + 1, 0, 2);
    }
    assert_int_equal(count(four, MR_ID_DISPLACEMENT_1_3), count(full, MR_ID_DISPLACEMENT_1_3));
    assert_true(count(four, MR_ID_DISPLACEMENT_4_6) > 3000);
    assert_int_equal(count(four, MR_ID_DISPLACEMENT_7_8), 0);
    for (uint16_t id = MR_ID_TENSION_1_3; id <= MR_ID_TENSION_13_14; id++)
        assert_int_equal(count(four, id), 0);
    /* of absent ones: at start, when arming */
    assert_int_equal(count(four, MR_ID_CHANNEL) - count(four, MR_ID_CHANNEL_ZERO), 2 * 18);
    close_board(four);
}

TEST(switches_alone_time_the_landing)
{
    struct heard *bare = fly(VARIANT("switches"));
    assert_same_landing(bare);
    assert_int_equal(sequence_length(bare, HIL_ADC1), 2);
    assert_int_equal(bare->board->state.mcu.adc[HIL_ADC3].cr2, 0);
    assert_int_equal(bare->board->core.state.counters.adc_scans[HIL_ADC3], 0);
    assert_int_equal(bare->block_bytes, 18);
    for (uint16_t id = MR_ID_DISPLACEMENT_1_3; id <= MR_ID_DISPLACEMENT_7_8; id++)
        assert_int_equal(count(bare, id), 0);
    assert_int_equal(count(bare, MR_ID_BOX_STATE), 0);
    assert_true(count(full, MR_ID_BOX_STATE) > 5);
    assert_true(full->board->state.w25q.operation_count > 100);
    assert_int_equal(bare->board->state.w25q.operation_count, 0);
    close_board(bare);
}

/* ---- the same codes, by replay ---- */

/* The record of a landing with all channels, on a board that lacks some: what it has is the
 * record's, sum by sum, and what it says of it is what was said then. */
TEST(sums_are_those_of_the_full_configuration)
{
    struct heard *four = open_board(VARIANT("four"));
    uint64_t edge_tick[32];
    struct hil_replay_command arm = {.block = full->armed.block,
                                     .message = {.code = MR_COMMAND_ARM, .argument = 5, .tag = 1}};
    struct hil_replay replay = {.has_crystal = true,
                                .blocks = full->block,
                                .block_count = full->blocks,
                                .edge_ticks = edge_tick,
                                .edge_count = full->edges,
                                .commands = &arm,
                                .command_count = 1,
                                .block0_tick = 2352};
    assert_int_equal(full->block[full->blocks - 1].index - full->block[0].index + 1, full->blocks);
    for (size_t i = 0; i < full->edges; i++)
        edge_tick[i] = full->edge[i].tick;
    hil_board_attach_replay(four->board, &replay);
    bench_run(four->board, (uint64_t)(hil_replay_duration_s(&replay) * 1e12));

    size_t compared = 0;
    for (size_t i = 0, k = 0; i < full->blocks && k < four->blocks; i++) {
        const struct mr_block *a = &full->block[i], *b = &four->block[k];
        if (a->index != b->index)
            continue;
        k++;
        assert_int_equal(a->tick, b->tick);
        assert_memory_equal(a->forward_sum, b->forward_sum, 4 * sizeof a->forward_sum[0]);
        assert_memory_equal(a->reversed_sum, b->reversed_sum, 4 * sizeof a->reversed_sum[0]);
        assert_memory_equal(a->sum + MR_ADC1_STAIRCASE, b->sum + MR_ADC1_STAIRCASE,
                            2 * sizeof a->sum[0]);
        compared++;
    }
    assert_true(compared + 4 >= full->blocks);

    static const uint16_t equal[] = {MR_ID_TOUCHDOWN,    MR_ID_STOP, MR_ID_MOTION,
                                     MR_ID_MOTION_ERROR, MR_ID_EDGE, MR_ID_DISPLACEMENT_1_3};
    for (size_t n = 0; n < COUNT_OF(equal); n++) {
        size_t k = 0, found = 0;
        for (size_t i = 0; i < full->count; i++) {
            if (full->said[i].id != equal[n])
                continue;
            for (k = 0; k < four->count; k++) {
                if (four->said[k].id == equal[n] &&
                    memcmp(four->said[k].payload, full->said[i].payload, MR_MESSAGE_BYTES_MAX) == 0)
                    break;
            }
            found += k < four->count;
        }
        /* told before and after the record */
        size_t idle = equal[n] == MR_ID_DISPLACEMENT_1_3 ? 20 : 0;
        if (found + idle < count(full, equal[n]) || found == 0)
            fail_msg("0x%03x: %zu of %zu", equal[n], found, count(full, equal[n]));
    }
    close_board(four);
}

/* ---- another configuration while scanning ---- */

/* A rig at rest reads (2048 +- 62) * 4 forward and backward, bridges 8 * 496; any set of channels,
 * 20 times a second. */
TEST(blocks_keep_their_place_when_channels_change)
{
    struct heard *heard = open_board(VARIANT("changing"));
    struct hil_run still;
    uint32_t sets = 0, absent = 0, lost = 0, adc3_longer = 0, without_adc3 = 0;
    still_run(&still, 20.0);
    hil_board_attach_rig(heard->board, &still);
    bench_run(heard->board, 1200000000000u);
    struct mr_command arm = {.code = MR_COMMAND_ARM, .argument = 1, .tag = 1};
    struct hil_can_frame frame = {.id = MR_ID_COMMAND, .length = 8};
    frame.length = (uint8_t)mr_command_put(&arm, frame.data);
    assert_int_equal(hil_can_inject(&heard->board->mcu.can, &frame), MR_OK);
    bench_run(heard->board, 6000000000000u);
    assert_true(heard->blocks > 4500);
    for (size_t i = 0; i < heard->blocks; i++) {
        const struct mr_block *block = &heard->block[i];
        if (i && block->absent_channels != absent) {
            unsigned transducers = 8u -
                                   (unsigned)__builtin_popcount(block->absent_channels & 0xffu);
            unsigned others = 16u - (unsigned)__builtin_popcount(block->absent_channels >> 8);
            sets++;
            adc3_longer += transducers > others;
            without_adc3 += transducers == 0;
        }
        if (i)
            lost += block->index - heard->block[i - 1].index - 1;
        absent = block->absent_channels;
        assert_int_equal(block->tick, 2352u + 84000u * block->index);
        for (unsigned c = 0; c < 22; c++) {
            bool there = !(absent >> c & 1u);
            if (c < 8) {
                assert_in_range(block->forward_sum[c], there ? 8438 : 0, there ? 8442 : 0);
                assert_in_range(block->reversed_sum[c], there ? 7942 : 0, there ? 7946 : 0);
            } else {
                assert_in_range(block->sum[c - 8], there ? 3964 : 0, there ? 3976 : 0);
            }
        }
        assert_in_range(block->sum[MR_ADC1_REFERENCE], 24816, 24832); /* 2.5 V: 8 * 3103 */
    }
    assert_true(sets > 80);
    assert_true(adc3_longer > 10 && without_adc3 == 0);
    assert_true(lost < sets); /* the block that is being filled, or none when it is over already */
    assert_int_equal(faults(heard) & (EAR_BIT(POLARITY) | EAR_BIT(SCAN_OVERRUN) |
                                      EAR_BIT(SCAN_STALL) | EAR_BIT(BLOCK_LATE)),
                     0);
    hil_run_free(&still);
    close_board(heard);
}

TESTS_BETWEEN(fly_full, put_away);
