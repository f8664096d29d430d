/* Board time against wide arithmetic: a clock of 128 bits that never wraps makes the blocks and
 * captures. */
#include "common/block.h"
#include "tests/cmocka_all.h"

#define HOURS            1000u
#define TICKS_PER_S      84000000u
#define HALF_ROUND_TICKS 2147483648u /* 25.5 s */

typedef __int128 wide;

static uint64_t state = 20;

static uint64_t draw(uint64_t below)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (state >> 20) % below;
}

TEST(a_capture_is_placed_exactly_however_long_ago_the_origin_was_learnt)
{
    for (unsigned round = 0; round < 200000; round++) {
        /* of block 0, on a clock that started long ago */
        wide begin = (wide)draw(1ull << 33);
        wide block = (wide)draw(HOURS * 3600000ull);
        /* another block, hours away: all between may be lost */
        wide learnt = (wide)draw(HOURS * 3600000ull);
        wide ticks = block * 84000 + (wide)draw(2ull * HALF_ROUND_TICKS) - (wide)HALF_ROUND_TICKS;
        uint32_t origin = mr_boardtime_origin_tick((uint32_t)learnt,
                                                   (uint32_t)(begin + learnt * 84000));
        assert_int_equal(origin, (uint32_t)begin);
        assert_int_equal(mr_boardtime_block_tick(origin, (uint32_t)block),
                         (uint32_t)(begin + block * 84000));
        assert_true(mr_boardtime_unwrap(origin, (uint32_t)block, (uint32_t)(begin + ticks)) ==
                    ticks);
    }
}

/* Samples, edges and frames of six hours, told in order with losses of up to 20 s, never go
 * backward and never repeat. */
TEST(time_only_goes_forward_over_wraps_and_losses)
{
    uint32_t origin = 2352;
    wide block = 0;
    int64_t last_ticks = -1;
    unsigned wraps = 0;
    while (block < 6 * 3600000) {
        wide ticks = block * 84000 + (wide)draw(84000);
        uint32_t tick = (uint32_t)(2352 + ticks);
        int64_t found = mr_boardtime_unwrap(origin, (uint32_t)block, tick);
        assert_true(found == ticks && found > last_ticks);
        wraps += (2352 + (wide)last_ticks) >> 32 != (2352 + ticks) >> 32;
        last_ticks = found;
        block += 1 + (wide)(draw(10) ? draw(400) : draw(20000));
    }
    assert_true(wraps >= 6 * 3600 / 52);
}

/* By hand: 84 ticks are a microsecond; the counter comes round after 4294967296 / 84 us. */
TEST(known_moments)
{
    assert_int_equal(mr_boardtime_unwrap(2352, 0, 2352), 0);
    assert_int_equal(mr_boardtime_unwrap(2352, 0, 2351), -1);
    assert_int_equal(mr_boardtime_unwrap(2352, 51130, 2352 + 51130u * 84000u), 4294920000);
    /* 4294967296 + 1000 - 2352 */
    assert_int_equal(mr_boardtime_unwrap(2352, 51131, 1000), 4294965944);
    assert_true(mr_boardtime_unwrap(0, UINT32_MAX, UINT32_MAX * 84000u + 5u) ==
                (int64_t)UINT32_MAX * 84000 + 5);
}
