/* The bring-up image: a small program that reports the state of a new board on the serial port,
 * with the firmware's own drivers. It prints a whole report at power on and whenever `print_report`
 * is typed; then it accepts commands. Two tests end in a reset, after which the report continues.
 * docs/howto/bring-up.md shows its use, docs/reference/bring-up.md the meaning of each line.
 *
 * Every wait is bounded and feeds the watchdog; an absent part has the value `none`. */
#include <string.h>

#include "common/catalogue.h"
#include "common/crc32.h"
#include "common/fault.h"
#include "common/predictor.h"
#include "common/wire.h"
#include "firmware/bringup/print.h"
#include "firmware/config.h"
#include "firmware/f407/drivers.h"

extern const uint8_t program_start[]; /* linker script */
extern uint32_t stack_bottom[];

/* ---- chip ---- */

/* Identity of the chip (RM0090 38.6.1, 39), image, cause of the start, option bytes (3.6.1). The
 * F407 cannot report its package, which is printed on the chip. */
/* Option bytes: half-words with their complements. */
#define OPTIONS_LOW      (*(reg32 *)0x1fffc000u)
#define OPTIONS_HIGH     (*(reg32 *)0x1fffc008u)
/* flash size in KiB, in the upper half of the word */
#define FLASH_SIZE_WORD  (*(reg32 *)0x1fff7a20u)
#define OPTCR_WDG_SW     (1u << 5)
#define OPTCR_NRST_STOP  (1u << 6)
#define OPTCR_NRST_STDBY (1u << 7)

static const char *get_image_word(uint8_t state)
{
    return state == MR_IMAGE_INTACT ? "good" : state == MR_IMAGE_NO_HEADER ? "none" : "damaged";
}

static void append_hex_digits(char *out, uint32_t value)
{
    for (unsigned i = 0; i < 8; i++)
        out[i] = "0123456789ABCDEF"[value >> (28u - 4u * i) & 15u];
}

static void print_identity(void)
{
    struct board_identity identity;
    char digits[25] = "";
    board_identify(&identity);
    for (unsigned i = 0; i < 3; i++)
        append_hex_digits(digits + 8u * i, identity.uid[i]);
    print_word("uid", digits, "id");
    print_word("board", mr_board_by_number(identity.board)->name, "name");
    print_hex("image_crc", identity.image_crc, "crc");
    print_word("image", get_image_word(identity.image_state), "state");
}

static void print_chip(void)
{
    struct board_identity identity;
    board_identify(&identity);
    print_hex("chip", DBGMCU_IDCODE & 0xfffu, "id");
    print_hex("revision", DBGMCU_IDCODE >> 16, "id");
    /* prefetch does not work on revision A of the F405 and F407 (ES0182) */
    bool broken = (DBGMCU_IDCODE & 0xfffu) == 0x413u && DBGMCU_IDCODE >> 16 == 0x1000u;
    print_word("prefetch", broken ? "broken" : "works", "state");
    print_hex("core", SCB_CPUID, "id");
    print_missing("package", "id");
    print_number("flash", (int32_t)(FLASH_SIZE_WORD >> 16), "KiB");
    print_hex("reset_cause", identity.reset_cause, "bits");
    print_word("clock", identity.clock_source == MR_CLOCK_CRYSTAL ? "crystal" : "internal_pll",
               "source");
}

static bool is_option_word_consistent(uint32_t word, uint32_t register_half, uint32_t mask)
{
    uint32_t half = word & 0xffffu;
    return (half ^ word >> 16) == 0xffffu && (half & mask) == (register_half & mask);
}

static void print_options(void)
{
    uint32_t optcr = FLASH_OPTCR;
    bool same = is_option_word_consistent(OPTIONS_LOW, optcr, 0xffecu) &&
                is_option_word_consistent(OPTIONS_HIGH, optcr >> 16, 0xfffu);
    print_hex("read_protection", optcr >> 8 & 0xffu, "byte");
    print_number("brown_out", (int32_t)(3u - (optcr >> 2 & 3u)), "level");
    print_word("watchdog_option", optcr & OPTCR_WDG_SW ? "software" : "hardware", "start");
    print_number("stop_resets", !(optcr & OPTCR_NRST_STOP) + !(optcr & OPTCR_NRST_STDBY), "modes");
    /* on chips with 512 KiB the other bits are reserved (RM0390 3.8.7) */
    uint32_t sectors = FLASH_SIZE_WORD >> 16 > 512u ? 0xfffu : 0xffu;
    print_hex("write_protected", ~(optcr >> 16) & sectors, "sectors");
    print_word("options_stored", same ? "as_loaded" : "differ", "state");
}

/* ---- clocks ---- */

/* Compares the clocks. The crystal was compared with the internal oscillator at start (clock.c);
 * the watchdog test measures the internal low-speed one. This part compares core cycles, SysTick
 * and timers, whose rates must be whole multiples of each other, the offset between the timers, and
 * the phase of the conversions in the scan. RM0090 18.3.15 (TIM4 starts TIM2), 13.8 (DMA). */
#define INTERNAL_KHZ      16000u
#define CRYSTAL_KHZ       8000u
/* duration of the comparison, shorter than SysTick's period of 10 ms */
#define SPAN_US           5000u
#define SCAN_TICKS        10500u
#define CONVERSION_US     1000u
#define NEWEST_TIMEOUT_US 100000u /* time to wait for one new block */
#define ADC1_STREAM       4u

static void print_crystal(void)
{
    uint32_t khz = clock_crystal_khz();
    if (!khz) {
        print_missing("crystal", "kHz");
        print_missing("internal", "kHz");
        return;
    }
    /* Only the ratio is known, so each of the two values assumes that the other clock is exact. */
    print_number("crystal", (int32_t)khz, "kHz");
    print_number("internal", (int32_t)(INTERNAL_KHZ * CRYSTAL_KHZ / khz), "kHz");
}

static uint32_t get_systick_since(uint32_t value)
{
    uint32_t now = SYST_CVR;
    return value >= now ? value - now : value + SYST_RVR + 1u - now;
}

static void print_clock_rates(void)
{
    uint32_t mask = irq_mask();
    uint32_t tick = TIM2->CNT, systick = SYST_CVR, begun = cycle_timer_now();
    cycle_timer_wait(SPAN_US);
    uint32_t ticks = TIM2->CNT - tick, systicks = get_systick_since(systick),
             cycles = cycle_timer_elapsed(begun);
    irq_restore(mask);
    if (ticks == 0) {
        print_missing("cycles_per_tick", "ratio");
        print_missing("systick_per_tick", "ratio");
        return;
    }
    print_milli("cycles_per_tick", (int32_t)((uint64_t)cycles * 1000u / ticks), "ratio");
    print_milli("systick_per_tick", (int32_t)((uint64_t)systicks * 1000u / ticks), "ratio");
}

/* Drops the queued blocks and returns the next one that ends. */
static bool get_newest_block(struct mr_block *block)
{
    uint32_t begun = cycle_timer_now();
    while (board_block_get(block)) {
    }
    while (!board_block_get(block)) {
        if (cycle_timer_has_passed(begun, NEWEST_TIMEOUT_US))
            return false;
    }
    return true;
}

/* Prints TIM2 minus TIM4 within a scan; TIM2 is read between two reads of TIM4. TIM2 wraps after 51
 * s, which is not a whole number of scans, so the ticks since the start are computed from the block
 * index. */
static void print_timers(void)
{
    struct mr_block block;
    bool come = get_newest_block(&block);
    uint32_t mask = irq_mask();
    uint32_t before = TIM4->CNT, between = TIM2->CNT, after = TIM4->CNT;
    irq_restore(mask);
    if (!come || between == 0) {
        print_missing("timer_offset", "ticks");
        return;
    }
    uint32_t width = (after + SCAN_TICKS - before) % SCAN_TICKS;
    uint32_t middle = (before + width / 2u) % SCAN_TICKS;
    uint64_t ticks = (uint64_t)mr_boardtime_unwrap(0, block.index, between);
    int32_t offset = (int32_t)((ticks + SCAN_TICKS - middle) % SCAN_TICKS);
    print_number("timer_offset",
                 offset > (int32_t)SCAN_TICKS / 2 ? offset - (int32_t)SCAN_TICKS : offset, "ticks");
}

/* Waits for the next conversion of converter 1 and returns TIM4's count. */
static bool wait_for_conversion(uint32_t *tick)
{
    uint32_t begun = cycle_timer_now(), left = DMA2->stream[ADC1_STREAM].NDTR;
    while (DMA2->stream[ADC1_STREAM].NDTR == left) {
        if (cycle_timer_has_passed(begun, CONVERSION_US))
            return false;
    }
    *tick = TIM4->CNT;
    return true;
}

static void print_conversions(void)
{
    uint32_t first = SCAN_TICKS, last = 0, tick;
    uint32_t mask = irq_mask();
    bool come = true;
    for (unsigned n = 0; come && n < 32; n++) {
        come = wait_for_conversion(&tick);
        if (n == 0)
            continue; /* ignore the first wait, which may have begun after its conversion */
        first = come && tick < first ? tick : first;
        last = come && tick > last ? tick : last;
    }
    irq_restore(mask);
    if (!come) {
        print_missing("conversion_first", "ticks");
        print_missing("conversion_last", "ticks");
        return;
    }
    print_number("conversion_first", (int32_t)first, "ticks");
    print_number("conversion_last", (int32_t)last, "ticks");
}

static void print_clocks(void)
{
    print_crystal();
    print_clock_rates();
    print_timers();
    print_conversions();
}

/* ---- noise ---- */

/* Level and noise of each input, with and without flash prefetch, because prefetch can disturb the
 * converters (AN4073). The core executes code from flash during the measurement, as during a
 * prediction.
 *
 * Noise of one conversion from the sums of 8, or 4, codes in block records. The difference of two
 * blocks has twice the variance of a sum and is not affected by drift. The noise is assumed to be
 * white; hum is therefore overestimated. */
#define BLOCK_COUNT    400u
#define SKIPPED_BLOCKS 20u /* number of blocks to skip, because the queue may hold them */
#define BLOCK_US       5000u
#define BUSY_BYTES     512u
#define REFERENCE_MV   2500u
#define SUPPLY_MAX_MV  3700u

static struct {
    struct mr_block last_block;
    uint32_t difference_count;
    uint64_t square_sums[MR_BLOCK_SUMS];
    uint32_t sums[MR_BLOCK_SUMS];
} noise_sums;

/* Waits for the next block without sleeping. */
static bool wait_for_block(struct mr_block *block)
{
    uint32_t begun = cycle_timer_now(), at = 0;
    volatile uint32_t crc = 0;
    while (!board_block_get(block)) {
        crc = mr_crc32(crc, program_start + at, BUSY_BYTES);
        at = (at + BUSY_BYTES) % 32768u;
        if (cycle_timer_has_passed(begun, BLOCK_US))
            return false;
    }
    return true;
}

static void add_differences(const struct mr_block *block)
{
    bool follows = noise_sums.last_block.index + 1u == block->index;
    for (unsigned i = 0; follows && i < MR_BLOCK_SUMS; i++) {
        int32_t difference = block->sums[i] - noise_sums.last_block.sums[i];
        noise_sums.square_sums[i] += (uint64_t)((int64_t)difference * difference);
        noise_sums.sums[i] += block->sums[i];
    }
    noise_sums.difference_count += follows;
    noise_sums.last_block = *block;
}

static bool measure_noise(void)
{
    struct mr_block block;
    memset(&noise_sums, 0, sizeof noise_sums);
    for (unsigned n = 0; n < SKIPPED_BLOCKS; n++) {
        if (!wait_for_block(&block))
            return false;
    }
    /* an index that no block follows, so that the first block adds no difference */
    noise_sums.last_block.index = block.index - 2u;
    for (unsigned n = 0; n < BLOCK_COUNT; n++) {
        if (!wait_for_block(&block))
            return false;
        add_differences(&block);
    }
    return noise_sums.difference_count > BLOCK_COUNT / 2u;
}

static uint32_t compute_integer_sqrt(uint64_t of)
{
    uint64_t r = 0;
    for (uint64_t bit = 1ull << 31; bit; bit >>= 1) {
        if ((r | bit) * (r | bit) <= of)
            r |= bit;
    }
    return (uint32_t)r;
}

/* Noise of one conversion in thousandths of a code, from sums of `codes` codes. */
static int32_t compute_noise_milli(unsigned sum, unsigned codes)
{
    return (int32_t)compute_integer_sqrt(noise_sums.square_sums[sum] * 1000000u /
                                         (2u * codes * noise_sums.difference_count));
}

static int32_t compute_level_milli(unsigned sum, unsigned codes)
{
    return (int32_t)((uint64_t)noise_sums.sums[sum] * 1000u /
                     (codes * noise_sums.difference_count));
}

static void print_channel(const char *what, unsigned channel, const char *signal, bool level)
{
    bool transducer = channel < MR_TRANSDUCERS;
    /* for transducers: the sums with forward excitation */
    unsigned sum = transducer ? channel : channel + MR_TRANSDUCERS;
    unsigned codes = transducer ? MR_SCANS_PER_BLOCK / 2u : MR_SCANS_PER_BLOCK;
    if (level)
        print_named_milli(what, signal, compute_level_milli(sum, codes), "codes");
    else
        print_named_milli(what, signal, compute_noise_milli(sum, codes), "codes");
}

static void print_channels(const char *what, bool level)
{
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) \
    print_channel(what, BOARD_##SIGNAL, #SIGNAL, level);
#include "firmware/boards/pins.def"
}

/* Computes the supply of the converters from the 2.500 V reference. Returns 0 if the result exceeds
 * the limit of the chip, which means that there is no reference. */
static uint32_t compute_supply_mv(void)
{
    uint32_t sum = noise_sums.sums[2u * MR_TRANSDUCERS + MR_ADC1_REFERENCE];
    uint32_t codes = MR_SCANS_PER_BLOCK * noise_sums.difference_count;
    uint32_t mv = sum ? (uint32_t)((uint64_t)REFERENCE_MV * 4096u * codes / sum) : 0;
    return mv <= SUPPLY_MAX_MV ? mv : 0;
}

/* Prints the supply and its deviation from the board's nominal supply. Both matter for the
 * staircase: it is read relative to the converters' supply, and its circuit is powered by the
 * board's supply. */
static void print_supply(void)
{
    uint32_t mv = compute_supply_mv();
    if (mv == 0) {
        print_missing("supply", "V");
        print_missing("supply_error", "ratio");
        return;
    }
    print_milli("supply", (int32_t)mv, "V");
    print_milli("supply_error", ((int32_t)mv - BOARD_SUPPLY_MV) * 1000 / BOARD_SUPPLY_MV, "ratio");
}

static void print_noise(void)
{
    if (!measure_noise()) {
        print_missing("noise", "codes");
        return;
    }
    print_supply();
    print_channels("level_", true);
    print_channels("noise_", false);
}

/* ---- cost of the predictor ---- */

/* Measures the cycles of the predictor for one block of a landing at 8 ft/s2. For comparison: the
 * budget assumes 1.5 cycles per instruction and 12.5 more for a division or root (tests/budget.sh).
 * INSTRUCTIONS is the mean per block over COST_ROUNDS, counted on the emulated board, where the
 * cycle counter counts instructions. */
#define COST_ROUNDS            600u
#define INSTRUCTIONS_PER_BLOCK 41581u
#define DIVISIONS_PER_BLOCK    35u
#define SPEED_FT_S             33.0f
#define BRAKING_FT_S2          8.0f /* deceleration, ft/s2 */
#define START_FT               3.0f /* station of the wheel in the first round, beyond touchdown */

static void make_predictor_input(const struct mr_predictor_config *started, uint32_t round,
                                 struct mr_predictor_input *input)
{
    *input =
        (struct mr_predictor_input){.wheel_ft = START_FT + SPEED_FT_S * 1e-3f * (float)round,
                                    .speed_ft_s = SPEED_FT_S - BRAKING_FT_S2 * 1e-3f * (float)round,
                                    .deceleration_ft_s2 = BRAKING_FT_S2,
                                    .is_braking_known = true,
                                    .is_on_runway = true};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        float ahead_ft = started->station_ft[i] - input->wheel_ft;
        input->displacement_in[i] = ahead_ft > 7.0f ? 0.0f : MR_NAN;
    }
}

static void print_predictor_cost(void)
{
    static struct mr_predictor predictor;
    struct mr_predictor_config started;
    struct mr_predictor_input input;
    const uint32_t assumed = (3u * INSTRUCTIONS_PER_BLOCK + 25u * DIVISIONS_PER_BLOCK) / 2u;
    uint64_t spent = 0;
    mr_config_get_predictor(&config, &started);
    started.updates_per_block = 1u << 20; /* so large that the full level is always used */
    if (mr_predictor_start(&predictor, &started) != MR_OK) {
        print_missing("cycles_predict", "cycles");
        return;
    }
    mr_predictor_arm(&predictor);
    for (uint32_t round = 0; round < COST_ROUNDS; round++) {
        make_predictor_input(&started, round, &input);
        watchdog_feed();
        uint32_t mask = irq_mask(), begun = cycle_timer_now();
        mr_predictor_on_block(&predictor, &input);
        spent += cycle_timer_elapsed(begun);
        irq_restore(mask);
    }
    uint32_t cycles = (uint32_t)(spent / COST_ROUNDS), updates = predictor.updates;
    print_number("cycles_predict", (int32_t)cycles, "cycles");
    print_milli("of_budget_predict", (int32_t)((uint64_t)cycles * 1000u / assumed), "ratio");
    print_number("mat_updates", (int32_t)(updates / COST_ROUNDS), "in_a_block");
    print_milli("cycles_update", (int32_t)(updates ? spent * 1000u / updates : 0), "cycles");
}

/* ---- can ---- */

/* Tests the CAN controller, which sends frames to itself. In silent mode its pin stays recessive,
 * so other nodes are not disturbed. The firmware's driver sends and receives at the firmware's bit
 * rate. The controller stays silent afterwards. RM0090 32.4.4 (loop back combined with silent
 * mode). */
#define FRAME_COUNT 100u
#define MODE_POLLS  100000u
#define FRAME_US    2000u /* a frame lasts 0.13 ms */

/* Enters init mode, sets mode bits in BTR, and leaves init mode. */
static bool set_mode(uint32_t bits)
{
    CAN1->MCR = CAN_MCR_INRQ | CAN_MCR_TXFP;
    unsigned polls = 0;
    while (!(CAN1->MSR & CAN_MSR_INAK) && polls < MODE_POLLS)
        polls++;
    if (polls == MODE_POLLS)
        return false;
    CAN1->BTR = (CAN1->BTR & ~(CAN_BTR_LBKM | CAN_BTR_SILM)) | bits;
    CAN1->MCR = CAN_MCR_TXFP;
    for (polls = 0; (CAN1->MSR & CAN_MSR_INAK) && polls < MODE_POLLS;)
        polls++;
    return polls < MODE_POLLS;
}

static bool is_loopback_received(const struct board_can_frame *sent)
{
    struct board_can_frame got = {0};
    uint32_t begun = cycle_timer_now();
    if (!board_can_send(sent))
        return false;
    while (!board_can_receive(&got)) {
        if (cycle_timer_has_passed(begun, FRAME_US))
            return false;
    }
    bool same = got.id == sent->id && got.length == sent->length;
    for (unsigned i = 0; i < sent->length; i++)
        same &= got.data[i] == sent->data[i];
    return same;
}

static void print_can(void)
{
    struct board_can_errors errors;
    /* Alternating bits, so that the data needs no stuff bits. MR_ID_COMMAND passes the driver's
     * filter. */
    struct board_can_frame frame = {.id = MR_ID_COMMAND, .length = 8};
    board_can_get_errors(&errors);
    board_can_set_base(0);
    if (errors.is_missing || !set_mode(CAN_BTR_LBKM | CAN_BTR_SILM)) {
        print_missing("can_frames", "frames");
        print_missing("can_frame", "us");
        return;
    }
    uint32_t good = 0, cycles = 0;
    for (unsigned n = 0; n < FRAME_COUNT; n++) {
        for (unsigned i = 0; i < 8; i++)
            frame.data[i] = n & 1u ? 0x55u : 0xaau;
        uint32_t begun = cycle_timer_now();
        good += is_loopback_received(&frame);
        cycles += cycle_timer_elapsed(begun);
    }
    board_can_get_errors(&errors);
    print_number("can_frames", (int32_t)good, "frames");
    print_milli("can_frame", (int32_t)((uint64_t)cycles * 1000u / (FRAME_COUNT * CYCLE_TIMER_MHZ)),
                "us");
    print_number("can_errors", errors.tec + errors.rec, "count");
}

/* ---- memory ---- */

/* Identifies the black box's memory, then erases, programs and verifies a sector several times. It
 * uses an empty sector of the black box, which is empty again afterwards; records and runway are
 * not changed. A sector endures 100,000 erases (W25Q128JV rev. F 9.6). */
/* maximum number of polls, 9 s or more: nor.c ends an erase after 6 s */
#define POLLS_MAX        9000u
#define TICKS_PER_US     84u
/* number of sectors searched for an empty one, from the black box's last one downwards */
#define SEARCHED_SECTORS 256u
#define NO_SECTOR        UINT32_MAX
#define ROUND_COUNT      3u

static uint8_t written[NOR_PAGE_BYTES] DMA_BUFFER, read_back[NOR_PAGE_BYTES] DMA_BUFFER;

struct flash_test_result {
    uint32_t round_count, mismatch_count, failure_count;
    /* sums and maxima of the durations */
    uint32_t erase_us, erase_max_us, program_us, program_max_us;
};

/* Sleeps until the next block or supervision tick, between two polls. Durations are measured with
 * TIM2, because the core's cycle counter stops during sleep. */
static void sleep_until_interrupt(void)
{
    struct mr_block block;
    watchdog_feed();
    while (board_block_get(&block)) {
    }
    (void)board_sleep();
}

/* Waits for the end of an operation and returns its duration. Returns false if it failed. */
static bool wait_for_end(uint32_t *us)
{
    uint32_t begun = TIM2->CNT;
    enum nor_status status = nor_poll();
    for (unsigned n = 0; status == NOR_BUSY && n < POLLS_MAX; n++) {
        sleep_until_interrupt();
        status = nor_poll();
    }
    *us = (TIM2->CNT - begun) / TICKS_PER_US;
    return status == NOR_IDLE;
}

static bool read_page(uint32_t address)
{
    uint32_t us;
    nor_begin_read(address, read_back, NOR_PAGE_BYTES);
    return wait_for_end(&us);
}

static bool is_blank(uint32_t sector)
{
    for (uint32_t n = 0; n < NOR_PAGES_PER_SECTOR; n++) {
        if (!read_page(sector * NOR_SECTOR_BYTES + n * NOR_PAGE_BYTES))
            return false;
        for (unsigned i = 0; i < NOR_PAGE_BYTES; i++) {
            if (read_back[i] != 0xffu)
                return false;
        }
    }
    return true;
}

static uint32_t find_blank_sector(void)
{
    for (uint32_t sector = NOR_SECTORS - 1u; sector >= NOR_SECTORS - SEARCHED_SECTORS; sector--) {
        if (is_blank(sector))
            return sector;
    }
    return NO_SECTOR;
}

static bool erase_sector(uint32_t sector, struct flash_test_result *o)
{
    uint32_t us;
    nor_begin_erase(sector * NOR_SECTOR_BYTES);
    bool done = wait_for_end(&us);
    o->erase_us += us;
    o->erase_max_us = us > o->erase_max_us ? us : o->erase_max_us;
    o->failure_count += !done;
    return done;
}

/* Fills a page with content that differs for each page and round. */
static void fill_page(uint32_t round, uint32_t number)
{
    uint32_t random = round * 2654435761u + number * 40503u + 1u;
    for (unsigned i = 0; i < NOR_PAGE_BYTES; i++) {
        random = random * 1664525u + 1013904223u;
        written[i] = (uint8_t)(random >> 24);
    }
}

static void write_page(uint32_t address, struct flash_test_result *o)
{
    uint32_t us;
    nor_begin_program(address, written);
    bool done = wait_for_end(&us);
    o->program_us += us;
    o->program_max_us = us > o->program_max_us ? us : o->program_max_us;
    o->failure_count += !done;
    if (!read_page(address) || memcmp(written, read_back, NOR_PAGE_BYTES) != 0)
        o->mismatch_count++;
}

static void test_sector(uint32_t sector, struct flash_test_result *o)
{
    for (uint32_t round = 0; round < ROUND_COUNT && o->failure_count == 0; round++) {
        if (!erase_sector(sector, o))
            break;
        o->mismatch_count += !is_blank(sector);
        for (uint32_t n = 0; n < NOR_PAGES_PER_SECTOR; n++) {
            fill_page(round, n);
            write_page(sector * NOR_SECTOR_BYTES + n * NOR_PAGE_BYTES, o);
        }
        o->round_count++;
    }
    (void)erase_sector(sector, o);
    o->mismatch_count += !is_blank(sector);
}

static void print_memory_test(uint32_t sector, const struct flash_test_result *o)
{
    print_number("memory_sector", (int32_t)sector, "sector");
    print_number("memory_rounds", (int32_t)o->round_count, "rounds");
    print_number("memory_rounds_missing", (int32_t)(ROUND_COUNT - o->round_count), "rounds");
    print_number("memory_wrong", (int32_t)o->mismatch_count, "pages");
    print_number("memory_failed", (int32_t)o->failure_count, "operations");
    uint32_t pages = o->round_count * NOR_PAGES_PER_SECTOR;
    print_number("memory_erase", (int32_t)(o->erase_us / (o->round_count + 1u)), "us");
    print_number("memory_erase_most", (int32_t)o->erase_max_us, "us");
    print_number("memory_program", (int32_t)(pages ? o->program_us / pages : 0), "us");
    print_number("memory_program_most", (int32_t)o->program_max_us, "us");
}

/* True if the memory answers. It may still be busy with an operation from before a reset. */
static bool is_memory_present(void)
{
    uint32_t us;
    return wait_for_end(&us) && nor_identify() == NOR_IDLE;
}

static void print_memory(void)
{
    struct flash_test_result outcome = {0};
    uint32_t sector = NO_SECTOR;
    if (!is_memory_present()) {
        print_missing("memory_id", "id");
        return;
    }
    print_hex("memory_id", nor_read_jedec_id(), "id");
    sector = find_blank_sector();
    if (sector == NO_SECTOR) {
        print_missing("memory_sector", "sector");
        return;
    }
    test_sector(sector, &outcome);
    print_memory_test(sector, &outcome);
}

/* ---- brown-out ---- */

/* Sets the brown-out level; it is off on new chips. At 168 MHz the core needs 2.7 V (data sheet,
 * table 14 with RM0090 5.1.3). The best level is the highest one that the board's supply certainly
 * exceeds: a board whose supply is below the set level never starts again.
 *
 *     level  maximum of the supply voltage at which the chip starts (VBOR1 to VBOR3, rising)
 *     3      2.97 V            set if the supply is 3.15 V or more
 *     2      2.63 V            set if the supply is 2.80 V or more
 *
 * The supply is measured against the 2.500 V reference and must match the board's nominal supply:
 * without a reference the pin would give a random value. RM0090 3.6.2 (option bytes), 3.9.10. */
#define OPTION_KEY_1             0x08192a3bu
#define OPTION_KEY_2             0x4c5d6e7fu
#define OPTCR_OPTLOCK            (1u << 0)
#define OPTCR_OPTSTRT            (1u << 1)
#define OPTCR_BOR_SHIFT          2u
#define OPTCR_BOR                (3u << OPTCR_BOR_SHIFT)
#define OPTCR_RDP                (0xffu << 8)
#define RDP_LEVEL_0              (0xaau << 8)
/* a few seconds; the loop stalls while the flash is busy */
#define OPTION_POLLS             48000000u
#define LEVEL_3_MV               3150u
#define LEVEL_2_MV               2800u
#define SUPPLY_TOLERANCE_PERCENT 5u /* allowed deviation from the board's nominal supply */

static bool is_board_supply(uint32_t mv)
{
    uint32_t off = mv > BOARD_SUPPLY_MV ? mv - BOARD_SUPPLY_MV : BOARD_SUPPLY_MV - mv;
    return off * 100u <= BOARD_SUPPLY_MV * SUPPLY_TOLERANCE_PERCENT;
}

static bool write_options(uint32_t options)
{
    uint32_t mask = irq_mask(); /* mask interrupts: their handlers are in flash, which is busy */
    watchdog_set_timeout(WATCHDOG_FLASH_COUNTS);
    if (FLASH_OPTCR & OPTCR_OPTLOCK) {
        FLASH_OPTKEYR = OPTION_KEY_1;
        FLASH_OPTKEYR = OPTION_KEY_2;
    }
    FLASH_OPTCR = options;
    FLASH_OPTCR = options | OPTCR_OPTSTRT;
    uint32_t polls = OPTION_POLLS;
    while ((FLASH_SR & FLASH_SR_BSY) && --polls) {
    }
    FLASH_OPTCR |= OPTCR_OPTLOCK;
    watchdog_set_timeout(WATCHDOG_DEFAULT_COUNTS);
    irq_restore(mask);
    return polls > 0 && (FLASH_OPTCR & ~OPTCR_OPTLOCK) == options;
}

static void set_brown_out_level(uint32_t level)
{
    uint32_t before = FLASH_OPTCR & ~(OPTCR_OPTLOCK | OPTCR_OPTSTRT);
    uint32_t wanted = (before & ~OPTCR_BOR) | (3u - level) << OPTCR_BOR_SHIFT;
    /* Not under read protection: an error while changing option bytes could lock the chip. */
    if ((before & OPTCR_RDP) != RDP_LEVEL_0)
        print_word("brown_out_set", "protected", "result");
    else if (before == wanted)
        print_word("brown_out_set", "was_so", "result");
    else
        print_word("brown_out_set", write_options(wanted) ? "written" : "failed", "result");
}

static void set_brown_out(void)
{
    uint32_t mv = measure_noise() ? compute_supply_mv() : 0;
    if (mv)
        print_milli("supply", (int32_t)mv, "V");
    else
        print_missing("supply", "V");
    uint32_t level = mv >= LEVEL_3_MV ? 3u : mv >= LEVEL_2_MV ? 2u : 0u;
    if (mv && !is_board_supply(mv))
        print_word("brown_out_set", "supply_not_the_boards", "result");
    else if (level)
        set_brown_out_level(level);
    else
        print_word("brown_out_set", mv ? "supply_too_low" : "supply_not_known", "result");
    print_number("brown_out", (int32_t)(3u - (FLASH_OPTCR >> OPTCR_BOR_SHIFT & 3u)), "level");
}

/* ---- tests that end in a reset ---- */

/* Tests a stack overflow, and a watchdog that is not fed. After the reset the results are in the
 * fault record (fault.c) and in a count in RAM. */
#define CAUSE_SOFTWARE 4u
#define CAUSE_WATCHDOG 8u
#define STARVED_S      4u
#define TIMEOUT_COUNTS (WATCHDOG_DEFAULT_COUNTS + 1u) /* the count includes 0 (RM0090 table 107) */
#define LSI_DIVIDER    32u
#define CFSR_BFARVALID (1u << 15)
#define CFSR_STKERR    (1u << 12)
#define CFSR_IMPRECISE (1u << 10)

static uint32_t watchdog_timeout_cycles __attribute__((section(".noinit")));

static uint8_t get_reset_cause(void)
{
    struct board_identity identity;
    board_identify(&identity);
    return identity.reset_cause;
}

/* Pushes data with the stack pointer at the bottom of the stack, as a too deep chain of calls
 * would. */
static void overflow_stack(void)
{
    __asm volatile("mov sp, %0\n\tpush {r0-r7}\n\tdsb" : : "r"(stack_bottom) : "memory");
    /* If the overflow is not detected, wait here: the watchdog resets the chip without a fault
     * record. */
    for (;;) {
    }
}

static const char *get_overflow_result(const struct board_restart *restart)
{
    if (!(get_reset_cause() & CAUSE_SOFTWARE) || !restart->crash || restart->crash_age != 0)
        return "no_fault";
    return mr_crash_kind_text(restart->crash[MR_CRASH_KIND])[0] == 'b' ? "bus_fault"
                                                                       : "other_fault";
}

static void print_overflow(void)
{
    struct board_restart restart;
    board_get_restart(&restart);
    const uint32_t *crash = restart.crash;
    print_word("stack_overflow", get_overflow_result(&restart), "caught_by");
    if (!crash || restart.crash_age != 0) {
        print_missing("stack_status", "cfsr");
        print_missing("stack_address", "address");
        return;
    }
    uint32_t cfsr = crash[MR_CRASH_CFSR];
    print_hex("stack_status", cfsr, "cfsr");
    if (cfsr & CFSR_BFARVALID)
        print_hex("stack_address", crash[MR_CRASH_BFAR], "address");
    else
        print_word("stack_address", cfsr & (CFSR_STKERR | CFSR_IMPRECISE) ? "imprecise" : "none",
                   "address");
}

static void starve_watchdog(void)
{
    (void)irq_mask();
    watchdog_timeout_cycles = 0;
    /* also resets the counter of the watchdog, for the last time */
    watchdog_set_timeout(WATCHDOG_DEFAULT_COUNTS);
    uint32_t begun = cycle_timer_now();
    while (cycle_timer_elapsed(begun) < STARVED_S * 1000000u * CYCLE_TIMER_MHZ)
        watchdog_timeout_cycles = cycle_timer_elapsed(begun);
}

static void print_watchdog(void)
{
    uint32_t us = watchdog_timeout_cycles / CYCLE_TIMER_MHZ;
    if (!(get_reset_cause() & CAUSE_WATCHDOG) || us == 0) {
        print_missing("watchdog", "ms");
        print_missing("low_speed", "kHz");
        return;
    }
    print_milli("watchdog", (int32_t)us, "ms");
    print_milli("low_speed", (int32_t)((uint64_t)TIMEOUT_COUNTS * LSI_DIVIDER * 1000000u / us),
                "kHz");
}

/* ---- report and commands ---- */

#define WORD_BYTES 16u

/* Stage of the report, which survives resets. The complement shows whether it is valid: at power
 * on, RAM contains random values. */
enum stage { STAGE_NONE, STAGE_STACK, STAGE_WATCHDOG };
static struct {
    uint32_t stage, complement;
} stored_stage __attribute__((section(".noinit")));

static void store_stage(enum stage stage)
{
    stored_stage.stage = stage;
    stored_stage.complement = ~(uint32_t)stage;
}

static enum stage read_stage(void)
{
    enum stage stage = stored_stage.complement == ~stored_stage.stage &&
                               stored_stage.stage <= STAGE_WATCHDOG
                         ? (enum stage)stored_stage.stage
                         : STAGE_NONE;
    store_stage(STAGE_NONE);
    return stage;
}

static void begin_section(const char *section)
{
    print_begin(section);
    print_identity();
}

static void end_report(void)
{
    print_end();
    print_text("ready: report, brown-out, rom");
}

static void continue_with_watchdog(void)
{
    print_overflow();
    print_flush();
    store_stage(STAGE_WATCHDOG);
    starve_watchdog();
    print_watchdog(); /* reached only if the watchdog has not reset the chip */
    end_report();
}

static void print_report(void)
{
    begin_section("report");
    print_chip();
    print_options();
    print_clocks();
    print_noise();
    print_predictor_cost();
    print_can();
    print_memory();
    print_flush();
    store_stage(STAGE_STACK);
    overflow_stack();
}

static void start_next_round(enum stage stage)
{
    if (stage == STAGE_STACK) {
        continue_with_watchdog();
    } else if (stage == STAGE_WATCHDOG) {
        print_watchdog();
        end_report();
    } else {
        print_text("matrig bring-up");
        print_report();
    }
}

/* Starts the boot ROM. Refused on boards whose boot ROM does not use this serial port, because it
 * could not be reached. */
static void enter_rom(void)
{
    if (!BOARD_IS_ROM_ON_SERIAL) {
        print_text("the boot ROM does not listen here");
        return;
    }
    print_text("to the boot ROM");
    print_flush();
    board_enter_rom();
}

static void execute_command(const char *word)
{
    if (strcmp(word, "report") == 0) {
        print_report();
    } else if (strcmp(word, "brown-out") == 0) {
        begin_section("brown-out");
        set_brown_out();
        print_end();
    } else if (strcmp(word, "rom") == 0) {
        enter_rom();
    } else if (*word) {
        print_text("not report, brown-out or rom");
    }
}

/* Copies a received line without its end. Returns false if the line is not complete yet. */
static bool read_command_word(char word[WORD_BYTES])
{
    static char line[WORD_BYTES];
    static size_t length;
    uint8_t byte;
    while (board_serial_receive(&byte, 1) == 1) {
        if (byte == '\r' || byte == '\n') {
            memcpy(word, line, WORD_BYTES);
            memset(line, 0, sizeof line);
            length = 0;
            return true;
        }
        if (length < WORD_BYTES - 1u)
            line[length++] = (char)byte;
    }
    return false;
}

int main(void)
{
    struct board_identity identity;
    struct mr_block block;
    char word[WORD_BYTES];
    board_start();
    /* the resets of this program are intended, so they must not count as failures in a row */
    board_reset_restart_count();
    board_identify(&identity);
    cycle_timer_start();
    uart_set_rate(PRINT_BAUD);
    board_scans_configure(board_input_mask());
    start_next_round(read_stage());
    for (;;) {
        watchdog_feed();
        while (board_block_get(&block)) { /* drop waiting blocks, which would prevent sleep */
        }
        (void)board_sleep();
        if (read_command_word(word))
            execute_command(word);
    }
}
