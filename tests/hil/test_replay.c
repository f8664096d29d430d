/* Replay's parts: codes that have given sums and counts, and the file's parser. The whole of it:
 * tests/cli/replay.sh. */
#include "common/crc32.h"
#include "hil/rig/replay.h"
#include "tests/hil/bench.h"

static uint32_t seed = 12345;

static uint16_t random_below(unsigned n)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint16_t)((seed >> 8) % n);
}

/* Any code; often one at or next to a limit of saturation. */
static uint16_t random_code(void)
{
    static const uint16_t edges[] = {0, 7, 8, 9, 10, 4085, 4086, 4087, 4088, 4095};
    return random_below(3) ? random_below(4096) : edges[random_below(10)];
}

/* What the board would sum from the codes. */
static void sum_up(const struct hil_block_codes *codes, struct mr_block *block)
{
    uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
        adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS];
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            transducers[scan][i] = codes->transducer[scan % 2][i][scan / 2];
        for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
            adc1[scan][i] = codes->adc1[i][scan];
    }
    mr_block_from_scans(block, block->index, block->tick, transducers, adc1);
}

TEST(any_block_has_codes)
{
    for (unsigned round = 0; round < 20000; round++) {
        uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
            adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS];
        struct mr_block wanted, got = {.index = round, .tick = 7};
        struct hil_block_codes codes;
        unsigned channel;
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
            for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
                transducers[scan][i] = random_code();
            for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
                adc1[scan][i] = random_code();
        }
        mr_block_from_scans(&wanted, round, 7, transducers, adc1);
        assert_true(hil_codes_from_block(&wanted, &codes, &channel));
        sum_up(&codes, &got);
        assert_memory_equal(&got, &wanted, sizeof got);
    }
}

/* Eight codes, none counted as saturated, cannot add up to less than 8 * 9 or more than 8 *
 * 4086. */
TEST(impossible_blocks_have_none)
{
    struct mr_block block = {0};
    struct hil_block_codes codes;
    unsigned channel;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        block.forward_sum[i] = block.reversed_sum[i] = 4 * 2000;
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
        block.sum[i] = 8 * 9;
    assert_true(hil_codes_from_block(&block, &codes, &channel));
    block.sum[3] = 8 * 9 - 1;
    assert_false(hil_codes_from_block(&block, &codes, &channel));
    assert_int_equal(channel, MR_TRANSDUCERS + 3);
    block.low_count[MR_TRANSDUCERS + 3] = 1; /* one of them at 8 */
    assert_true(hil_codes_from_block(&block, &codes, &channel));
    block.sum[3] = 8 * 4086 + 1;
    assert_false(hil_codes_from_block(&block, &codes, &channel));
    block.low_count[MR_TRANSDUCERS + 3] = 0;
    block.high_count[MR_TRANSDUCERS + 3] = 1;
    assert_true(hil_codes_from_block(&block, &codes, &channel));
    block.forward_sum[5] = 4 * 9 - 1;
    /* one low code forward, one high code backward, or none at all */
    block.reversed_sum[5] = 4 * 4086 + 1;
    assert_false(hil_codes_from_block(&block, &codes, &channel));
    assert_int_equal(channel, 5);
    block.low_count[5] = block.high_count[5] = 1;
    assert_true(hil_codes_from_block(&block, &codes, &channel));
    assert_in_range(codes.transducer[0][5][0], 0, 8);
    assert_in_range(codes.transducer[1][5][0], 4087, 4095);
}

/* ---- the file ---- */

static char text[4096];

static const char *block_line(uint32_t index, uint32_t tick)
{
    static char line[300];
    struct mr_block block = {.index = index, .tick = tick};
    uint8_t record[MR_BLOCK_BYTES_MAX];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        block.forward_sum[i] = block.reversed_sum[i] = 8000;
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
        block.sum[i] = 16000;
    size_t length = mr_block_encode(&block, record);
    int n = snprintf(line, sizeof line, "block ");
    for (size_t i = 0; i < length; i++)
        n += snprintf(line + n, sizeof line - (size_t)n, "%02x", record[i]);
    snprintf(line + n, sizeof line - (size_t)n, "\n");
    return line;
}

static enum mr_status read_text(const char *lines, bool with_end, char *error,
                                struct hil_replay *replay)
{
    snprintf(text, sizeof text, "matrig-replay 1\n%s", lines);
    size_t n = strlen(text);
    if (with_end)
        snprintf(text + n, sizeof text - n, "end %08x\n",
                 (unsigned)mr_crc32(0, (const uint8_t *)text, n));
    return hil_replay_read(bench_scratch("test.replay", text, strlen(text)), replay, error, 300);
}

TEST(a_whole_file_is_read)
{
    char lines[2000], error[300] = "";
    struct hil_replay replay;
    int n = snprintf(lines, sizeof lines,
                     "# made up\nuid 00000001 0000000a ffffffff\ncrystal 0\n"
                     "command 40 5 3 1 3050\ncommand 50 2 0 7 -1\nedge 5000\nedge "
                     "4294967296000\nframe 84000\nframe 168000\n");
    for (unsigned i = 0; i < 3; i++)
        n += snprintf(lines + n, sizeof lines - (size_t)n, "%s",
                      block_line(51130 + i, (51130u + i) * 84000u + 2352u));
    assert_int_equal(read_text(lines, true, error, &replay), MR_OK);
    assert_true(replay.has_uid);
    assert_int_equal(replay.uid[1], 10);
    assert_false(replay.has_crystal);
    assert_int_equal(replay.command_count, 2);
    assert_int_equal(replay.commands[0].message.index, 3);
    assert_int_equal(replay.commands[0].message.argument, 3050);
    assert_int_equal(replay.commands[1].block, 50);
    assert_int_equal(replay.commands[1].message.tag, 7);
    assert_int_equal(replay.commands[1].message.argument, -1);
    assert_int_equal(replay.edge_count, 2);
    assert_true(replay.edge_ticks[1] == 4294967296000u);
    assert_int_equal(replay.pulse_train[0].pulse_count, 2);
    assert_int_equal(replay.pulse_train[0].rise_times[1], 168000);
    /* TIM2 has wrapped between the first and the last of them */
    assert_int_equal(replay.block_count, 3);
    assert_int_equal(replay.block0_tick, 2352);
    assert_int_equal(replay.blocks[2].index, 51132);
    hil_replay_free(&replay);
}

static void refused(const char *lines, bool with_end, enum mr_status status, const char *part)
{
    char error[300] = "";
    struct hil_replay replay;
    assert_int_equal(read_text(lines, with_end, error, &replay), status);
    if (!strstr(error, part))
        fail_msg("`%s` should say `%s`", error, part);
    assert_null(replay.blocks);
}

TEST(what_is_none_is_refused)
{
    char lines[2000];
    refused("crystal 1\n", true, MR_MALFORMED, "no block records");
    refused("crystal 2\n", true, MR_MALFORMED, "test.replay:2: unknown line");
    refused("edge 70\nedge 70\n", true, MR_MALFORMED,
            "test.replay:3: expected ticks in ascending order");
    refused("frame 70\nframe 84069\n", true, MR_MALFORMED, "at least 84000 apart");
    refused("command 7 1 0 0 0\ncommand 6 1 0 0 0\n", true, MR_MALFORMED, "with blocks in order");
    refused("block 00zz\n", true, MR_MALFORMED, "not a block record of this layout");
    refused("block 0011\n", true, MR_MALFORMED, "not a block record of this layout");
    refused(block_line(5, 2352), true, MR_MALFORMED, "block 5 cannot begin at tick 2352");
    snprintf(lines, sizeof lines, "%s", block_line(5, 5 * 84000 + 2352));
    snprintf(lines + strlen(lines), sizeof lines - strlen(lines), "%s",
             block_line(7, 7 * 84000 + 2352));
    refused(lines, true, MR_MALFORMED, "block 7 is not the successor of block 5");
    refused(block_line(5, 5 * 84000 + 2352), false, MR_TRUNCATED, "the file has no `end` line");
}
