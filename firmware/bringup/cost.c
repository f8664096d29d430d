/* Cycles of the firmware's tasks. They run one after the other, a block's work in each round, so
 * that each finds the flash's caches (1 KiB) as the others left them, as in the firmware.
 * Interrupts are masked while one runs. */
#include <string.h>

#include "common/blockpack.h"
#include "common/boardtime.h"
#include "common/channels.h"
#include "common/crc32.h"
#include "common/framing.h"
#include "common/onboard/landing.h"
#include "common/predictor.h"
#include "common/catalogue.h"
#include "common/wire.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/channels.h"
#include "firmware/config.h"
#include "firmware/f407/drivers.h"

#define COST_ROUNDS  600u
#define TRIGGER_TICK 2352u
#define FIRST_INDEX  1000u
#define SPEED_FT_S   33.0f
#define BRAKING      8.0f  /* ft/s2 */
#define START_FT     -5.0f /* before the first switch */
#define GATES        (sizeof config.gate / sizeof config.gate[0])

enum task {
#define TASK(name, instructions, divides, text) TASK_##name,
#include "firmware/bringup/tasks.def"
    TASKS
};

/* What the tasks work on. */
static struct {
    uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS];
    uint16_t others[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS];
    struct mr_block block;
    struct channels channels;
    float readings[MR_WATCHED];
    struct mr_pack pack;
    uint8_t packed[MR_PACK_BYTES_MAX], page[256], record[MR_BLOCK_BYTES_MAX], frame[MR_FRAME_MAX];
    uint8_t message[MR_MESSAGE_MAX];
    volatile uint32_t crc;
    struct landing landing;
    unsigned gates; /* that the wheel has passed */
    uint32_t edge;
    unsigned edges;
    struct mr_predictor predictor;
    struct mr_predictor_config configuration;
    struct mr_predictor_input input;
} at;
static uint64_t spent[TASKS];

/* Codes that change as a converter's noise does. */
static void fill_codes(uint32_t round)
{
    uint32_t random = round * 2654435761u + 12345u;
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        for (unsigned i = 0; i < MR_TRANSDUCERS + MR_ADC1_CHANNELS; i++) {
            random = random * 1664525u + 1013904223u;
            uint16_t code = (uint16_t)(1000u + 64u * i + (random >> 29));
            if (i < MR_TRANSDUCERS)
                at.transducers[scan][i] = scan % 2u ? (uint16_t)(4096u - code) : code;
            else
                at.others[scan][i - MR_TRANSDUCERS] = code;
        }
        at.others[scan][MR_ADC1_REFERENCE] = 3103u;
    }
}

static float wheel_ft(uint32_t round)
{
    return START_FT + SPEED_FT_S * 1e-3f * (float)round;
}

/* The switch that the wheel passes in this round, if one; the staircase's code so far. */
static float pass_gates(uint32_t round)
{
    float code = config.channel[MR_TRANSDUCERS + MR_ADC1_STAIRCASE].zero_code;
    at.edges = 0;
    if (at.gates < GATES && wheel_ft(round) >= mr_config_gate_ft(&config, at.gates)) {
        at.gates++;
        at.edges = 1;
        at.edge = mr_boardtime_tick(TRIGGER_TICK, FIRST_INDEX + round);
    }
    for (unsigned i = 0; i < at.gates; i++)
        code += (float)config.gate[i].step_codes;
    return code;
}

static void look_ahead(uint32_t round)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        float ahead_ft = at.configuration.station_ft[i] - wheel_ft(round);
        at.input.displacement_in[i] = ahead_ft > 15.0f ? 0.0f : MR_NAN;
    }
    at.input.wheel_ft = wheel_ft(round) + 8.0f; /* on the runway from the first round on */
    at.input.speed_ft_s = SPEED_FT_S - BRAKING * 1e-3f * (float)round;
    at.input.deceleration_ft_s2 = BRAKING;
    at.input.braking_known = at.input.on_runway = true;
}

static void run_block(uint32_t round)
{
    mr_block_from_scans(&at.block, FIRST_INDEX + round,
                        mr_boardtime_tick(TRIGGER_TICK, FIRST_INDEX + round), at.transducers,
                        at.others);
}

static void run_read(uint32_t round)
{
    (void)round;
    float ratio = mr_channels_ratio(&config.channel[MR_TRANSDUCERS + MR_ADC1_REFERENCE], &at.block);
    for (unsigned c = 0; c < MR_WATCHED; c++)
        at.readings[c] = channels_read(&at.channels, &at.block, c, ratio);
}

static void run_pack(uint32_t round)
{
    if (round == 0)
        mr_pack_key(&at.pack, &at.block, at.packed);
    mr_pack_block(&at.pack, &at.block, at.packed);
}

static void run_crc(uint32_t round)
{
    (void)round;
    at.crc = mr_crc32(0, at.page, sizeof at.page);
}

static void run_frame(uint32_t round)
{
    size_t length = mr_block_put(&at.block, at.record);
    mr_frame_encode((uint16_t)round, MR_ID_BLOCK, at.record, length, at.frame);
}

static void run_series(uint32_t round)
{
    for (unsigned n = 0; n < MR_SERIES_PACKS; n++) {
        const struct mr_series_pack *pack = mr_series_pack_at(n);
        const float *readings = at.readings + (pack->series ? MR_TRANSDUCERS : 0);
        mr_series_pack_put(pack, readings, FIRST_INDEX + round, at.message);
    }
}

static float staircase_code;

static void run_landing(uint32_t round)
{
    uint32_t tick = mr_boardtime_tick(TRIGGER_TICK, FIRST_INDEX + round);
    landing_block(&at.landing, &config, FIRST_INDEX + round, tick, staircase_code, &at.edge,
                  at.edges);
}

static void run_predict(uint32_t round)
{
    (void)round;
    mr_predictor_block(&at.predictor, &at.input);
}

static bool prepare(void)
{
    memset(&at, 0, sizeof at);
    memset(spent, 0, sizeof spent);
    channels_start(&at.channels);
    channels_arm(&at.channels, FIRST_INDEX);
    landing_start(&at.landing);
    landing_arm(&at.landing, 1, FIRST_INDEX);
    mr_config_predictor(&config, &at.configuration);
    at.configuration.updates_per_block = 1u << 20; /* every mat, whatever it costs */
    if (mr_predictor_start(&at.predictor, &at.configuration) != MR_OK)
        return false;
    mr_predictor_arm(&at.predictor);
    return true;
}

static void play_round(uint32_t round)
{
    fill_codes(round);
    staircase_code = pass_gates(round);
    look_ahead(round);
    watchdog_feed();
#define TASK(name, instructions, divides, text)   \
    {                                             \
        uint32_t mask = irq_mask();               \
        uint32_t begun = pace_begin();            \
        run_##name(round);                        \
        spent[TASK_##name] += pace_cycles(begun); \
        irq_restore(mask);                        \
    }
#include "firmware/bringup/tasks.def"
}

static void say_task(const char *name, enum task task, uint32_t instructions, uint32_t divides)
{
    uint32_t assumed = (3u * instructions + 25u * divides) / 2u;
    uint32_t cycles = (uint32_t)(spent[task] / COST_ROUNDS);
    say_number_of("cycles_", name, (int32_t)cycles, "cycles");
    say_number_of("assumed_", name, (int32_t)assumed, "cycles");
    say_milli_of("of_budget_", name, (int32_t)((uint64_t)cycles * 1000u / assumed), "ratio");
}

void bringup_prefetch(bool on)
{
    if (on)
        FLASH_ACR |= FLASH_ACR_PRFTEN;
    else
        FLASH_ACR &= ~FLASH_ACR_PRFTEN;
    __asm volatile("dsb\n\tisb" ::: "memory");
}

static bool play(void)
{
    if (!prepare())
        return false;
    for (uint32_t round = 0; round < COST_ROUNDS; round++)
        play_round(round);
    return true;
}

void bringup_cost(void)
{
    if (!play()) {
        say_none("cycles", "cycles");
        return;
    }
#define TASK(name, instructions, divides, text) say_task(#name, TASK_##name, instructions, divides);
#include "firmware/bringup/tasks.def"
    uint32_t updates = at.predictor.updates;
    say_number("gates_passed", (int32_t)at.gates, "switches");
    say_number("mat_updates", (int32_t)(updates / COST_ROUNDS), "in_a_block");
    say_milli("cycles_update", (int32_t)(updates ? spent[TASK_predict] * 1000u / updates : 0),
              "cycles");
    bringup_prefetch(false);
    (void)play();
    bringup_prefetch(true);
    say_number("cycles_without_prefetch_predict", (int32_t)(spent[TASK_predict] / COST_ROUNDS),
               "cycles");
}
