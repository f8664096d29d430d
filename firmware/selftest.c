#include "firmware/selftest.h"

#include "common/channels.h"
#include "firmware/board.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/nor.h"

/* A driven transducer at its mechanical zero reads 62 codes, one that is not driven none. Sums of
 * four scans of each polarity. */
#define DRIVEN_SUM (8 * 8)

static void conclude(struct selftest *test, enum mr_self_test_number number, bool good)
{
    if (test->done >> number & 1u)
        return;
    test->done = (uint16_t)(test->done | 1u << number);
    if (good)
        return;
    test->failed = (uint16_t)(test->failed | 1u << number);
    health_count(MR_FAULT_SELFTEST, (uint8_t)number);
}

enum mr_status selftest_begin(struct selftest *test, uint16_t tag)
{
    struct board_upkeep upkeep;
    bool good;
    if (test->running)
        return MR_WAIT;
    board_upkeep_restart();
    board_upkeep_state(&upkeep);
    *test = (struct selftest){.running = true,
                              .tag = tag,
                              .ram_rounds = upkeep.ram_rounds,
                              .flash_rounds = upkeep.flash_rounds,
                              .polarity_faults = health_counted(MR_FAULT_POLARITY)};
    if (board_image_check(&good))
        conclude(test, MR_SELF_TEST_IMAGE, good);
    board_warn(true);
    return MR_OK;
}

static void look_at_memories(struct selftest *test)
{
    struct board_upkeep upkeep;
    board_upkeep_state(&upkeep);
    if (upkeep.ram_rounds != test->ram_rounds)
        conclude(test, MR_SELF_TEST_RAM, !upkeep.ram_bad);
    if (upkeep.flash_rounds != test->flash_rounds)
        conclude(test, MR_SELF_TEST_FLASH, !upkeep.flash_bad);
    enum nor_status nor = config.site[0].black_box ? nor_identify() : NOR_BUSY;
    if (nor != NOR_BUSY)
        conclude(test, MR_SELF_TEST_NOR, nor == NOR_IDLE);
}

static void look_at_lamp(struct selftest *test)
{
    if (test->ticks == SELFTEST_LAMP_TICKS) {
        conclude(test, MR_SELF_TEST_LAMP_ON, board_lamp_draws());
        board_warn(false);
    } else if (test->ticks == SELFTEST_LAMP_TICKS + SELFTEST_DARK_TICKS) {
        conclude(test, MR_SELF_TEST_LAMP_OFF, !board_lamp_draws());
    }
}

static bool has_transducers(void)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (config.channel[i].kind == MR_KIND_DISPLACEMENT)
            return true;
    }
    return false;
}

/* What this board and its configuration have. */
static uint16_t wanted(const struct selftest *test)
{
    unsigned tests = 1u << MR_SELF_TEST_RAM | 1u << MR_SELF_TEST_FLASH |
                     1u << MR_SELF_TEST_REFERENCE | 1u << MR_SELF_TEST_LAMP_ON |
                     1u << MR_SELF_TEST_LAMP_OFF;
    tests |= has_transducers() ? 1u << MR_SELF_TEST_EXCITATION : 0;
    tests |= config.site[0].black_box ? 1u << MR_SELF_TEST_NOR : 0;
    return (uint16_t)(tests | test->done);
}

static struct mr_self_test result_of(const struct selftest *test)
{
    return (struct mr_self_test){.done = test->done, .failed = test->failed, .tag = test->tag};
}

bool selftest_tick(struct selftest *test, struct mr_self_test *result)
{
    if (!test->running)
        return false;
    test->ticks++;
    look_at_lamp(test);
    look_at_memories(test);
    if (test->done != wanted(test) && test->ticks < SELFTEST_LIMIT_TICKS)
        return false;
    test->running = false;
    *result = result_of(test);
    return true;
}

void selftest_block(struct selftest *test, const struct mr_block *block)
{
    if (!test->running || test->blocks >= SELFTEST_BLOCKS)
        return;
    test->reference_bad |= __builtin_isnan(mr_channels_ratio(&config.channel[MR_REFERENCE], block));
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        int difference = (int)block->plus[i] - (int)block->minus[i];
        if (config.channel[i].kind == MR_KIND_DISPLACEMENT &&
            (difference > DRIVEN_SUM || difference < -DRIVEN_SUM))
            test->excited = true;
    }
    if (++test->blocks < SELFTEST_BLOCKS)
        return;
    conclude(test, MR_SELF_TEST_REFERENCE, !test->reference_bad);
    if (has_transducers())
        conclude(test, MR_SELF_TEST_EXCITATION,
                 test->excited && health_counted(MR_FAULT_POLARITY) == test->polarity_faults);
}

bool selftest_stop(struct selftest *test, struct mr_self_test *result)
{
    if (!test->running)
        return false;
    test->running = false;
    *result = result_of(test);
    return true;
}
