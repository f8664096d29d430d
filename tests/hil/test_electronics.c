/* Electricity of the rig: what is relative to what, the supply from 3.0 to 3.6 V, and boards that
 * are drawn from the figures of the circuits. Expected values are worked out from the figures or
 * counted in the truth of the run, not taken from the rig. */
#include <math.h>

#include "common/channels.h"
#include "common/fault.h"
#include "firmware/config.h"
#include "hil/periph/options.h"
#include "hil/rig/electronics.h"
#include "host/calibrate/fit.h"
#include "tests/hil/ear.h"
#include "tests/long.h"

/* What landing 5 becomes at a supply. */
struct heard {
    unsigned named, misnamed, edges;
    uint32_t tick[HIL_RUN_SWITCHES];
    unsigned blocks, missing, wrong, other;
    uint32_t reference_faults;
};

/* Each reading of a block against the truth of the run in the 40 ms around the time it came, a
 * hundredth of an inch and 2 lb beside it; or missing. */
static void judge_block(const struct ear *ear, double now_s, struct heard *heard)
{
    float ratio = mr_reference_ratio(&config.channel[MR_REFERENCE], &ear->block);
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++) {
        struct mr_reading reading = mr_channel_read(&config.channel[c], &ear->block, c, ratio);
        double beside = c < MR_TRANSDUCERS ? 0.01 : 2.0, least = (double)INFINITY,
               most = -(double)INFINITY;
        for (int ms = -35; ms <= 5; ms++) {
            double truth = hil_run_get_true_value(&ear->run, c, now_s + 1e-3 * ms);
            least = fmin(least, truth);
            most = fmax(most, truth);
        }
        double value = (double)reading.value;
        if (reading.validity == MR_INVALID_REFERENCE)
            heard->missing++;
        else if (reading.validity != MR_VALID)
            heard->other++;
        else if (value < least - beside || value > most + beside)
            heard->wrong++;
    }
}

/* An edge is told each 0.1 s at most: none is passed over in 10 ms. */
static void take_edge(const struct ear *ear, struct heard *heard)
{
    struct mr_edge edge;
    assert_int_equal(mr_edge_get(&edge, ear->last[EAR_CAN][MR_ID_EDGE], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    assert_in_range(heard->edges, 0, HIL_RUN_SWITCHES - 1);
    heard->tick[heard->edges++] = edge.tick;
    heard->named += edge.position == heard->edges;
    heard->misnamed += edge.position && edge.position != heard->edges;
}

static void play_at(double vdda_v, double until_s, struct heard *heard)
{
    struct hil_options options = ear_options();
    options.vdda_v = vdda_v;
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, 5);
    memset(heard, 0, sizeof *heard);
    for (double t_s = 0.9; t_s < until_s; t_s += 0.01) {
        unsigned blocks = ear->blocks, edges = ear->heard[EAR_CAN][MR_ID_EDGE];
        ear_until(ear, t_s);
        heard->blocks += ear->blocks > blocks;
        if (ear->blocks > blocks)
            judge_block(ear, t_s, heard);
        assert_in_range(ear->heard[EAR_CAN][MR_ID_EDGE] - edges, 0, 1);
        if (ear->heard[EAR_CAN][MR_ID_EDGE] > edges)
            take_edge(ear, heard);
    }
    heard->reference_faults = ear->fault[MR_FAULT_REFERENCE].count;
    ear_close(ear);
}

/* Two percent of 3.3 V either way: 3.235 to 3.367 V. Inside all is as at 3.3 V; beyond it every
 * reading that is relative to the reference is missing, that is told, and switches and speeds go
 * on. */
TEST(the_supply_from_3_0_to_3_6_V)
{
    static const double supplies[] = {3.3, 3.0, 3.1, 3.22, 3.24, 3.36, 3.38, 3.5, 3.6};
    struct heard at_nominal, heard;
    printf("# VDDA V | switches named, wrongly | readings missing, wrong | fault REFERENCE\n");
    for (unsigned i = 0; i < sizeof supplies / sizeof supplies[0]; i++) {
        play_at(supplies[i], 3.6, &heard);
        if (i == 0)
            at_nominal = heard;
        double off = fabs(supplies[i] / 3.3 - 1.0);
        unsigned readings = heard.blocks * (MR_TRANSDUCERS + MR_GAGES);
        printf("# %.2f | %u, %u | %u, %u of %u | %u\n", supplies[i], heard.named, heard.misnamed,
               heard.missing, heard.wrong, readings, (unsigned)heard.reference_faults);
        assert_true(heard.blocks > 200);
        assert_int_equal(heard.wrong, 0);
        assert_int_equal(heard.other, 0);
        assert_int_equal(heard.misnamed, 0);
        assert_int_equal(heard.named, at_nominal.named);
        assert_memory_equal(heard.tick, at_nominal.tick, sizeof heard.tick); /* times: to nothing */
        assert_int_equal(heard.missing, off > 0.02 ? readings : 0);
        assert_true((heard.reference_faults > 0) == (off > 0.02));
    }
    assert_in_range(at_nominal.named, 10, 24);
}

/* ---- a drawn board, played ---- */

/* One drawn board on the emulated rig: its 24 switches open one after the other, its zeros are
 * measured by command, then each transducer and gage is taken through known values, as a
 * calibration does, and through others in between, at which the calibration is judged.
 *
 * The board runs the firmware's image; what is taken is what it says on its serial line. The
 * straight line is matrig calibrate's own (host/calibrate/fit.h). */

#define FIRST_OPENS_S 0.25
#define OPENS_EACH_S  0.025 /* edges nearer than 10 ms can be one contact's */
#define SWITCHES_S    0.9   /* all have opened and are told */
#define ZERO_S        0.95
#define LEVELS_S      1.4
#define LEVEL_S       0.4
#define HOLD_S        0.28 /* of a level, the rest is the way to the next */
#define RATE_HZ       10.0
#define CALIBRATED    5u
#define LEVELS        9u
#define FULL_IN       2.8
#define FULL_LB       400.0

struct board_channel {
    double zeroed;     /* in or lb: what it reads at 0 once the zero was measured by command */
    double left_worst; /* calibrated: largest error at the values in between */
    bool valid;        /* at every value */
};

struct board_outcome {
    unsigned named, unnamed, misnamed; /* of 24 switches */
    bool zero_taken;                   /* the command zero was answered with ok */
    struct board_channel channel[HIL_RUN_COLUMNS];
};

struct board_request {
    uint64_t seed;
    double vdda_v;
    const struct hil_circuit_figures *figures; /* NULL: the reference circuits' */
    bool only_switches;
};

/* Parts of the full value: five to calibrate with, four in between. */
static const double level[LEVELS] = {0.0, 0.25, 0.5, 0.75, 1.0, 0.125, 0.375, 0.625, 0.875};

struct play {
    const struct board_request *request;
    struct board_outcome *outcome;
    struct hil_board *board;
    struct mr_deframer deframer;
    struct mr_config zeroed; /* the configuration with the zeros that were measured */
    unsigned edges;
    double now_s;
    unsigned blocks[LEVELS];
    double code[LEVELS][HIL_RUN_COLUMNS]; /* sums, times the reference's ratio */
    unsigned invalid[HIL_RUN_COLUMNS];
};

/* 3.24 to 3.36 V, evenly, by seed. */
static double board_vdda_v(uint64_t seed)
{
    uint64_t random = seed * 0x2545f4914f6cdd1dull + 11u;
    return 3.24 + 0.12 * mr_splitmix64_uniform(&random);
}

static double full(unsigned channel)
{
    return channel < HIL_RUN_TRANSDUCERS ? FULL_IN : FULL_LB;
}

static bool make_run(struct hil_run *run, const struct board_request *request)
{
    bool only_switches = request->only_switches;
    *run = (struct hil_run){.duration_s = 10.0, .sample_rate_hz = RATE_HZ, .sample_count = 1};
    if (!only_switches)
        run->sample_count = (size_t)((LEVELS_S + LEVELS * LEVEL_S) * RATE_HZ) + 1u;
    run->samples = calloc(run->sample_count, sizeof *run->samples);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run->switch_open_ps[i] = (uint64_t)((FIRST_OPENS_S + OPENS_EACH_S * i) * 1e12);
    for (size_t row = 0; run->samples && row < run->sample_count; row++) {
        double since_s = (double)row / RATE_HZ - LEVELS_S + 0.5 / RATE_HZ;
        if (since_s < 0.0)
            continue;
        double part =
            level[since_s / LEVEL_S < LEVELS ? (unsigned)(since_s / LEVEL_S) : LEVELS - 1u];
        for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++)
            run->samples[row][c] =
                (int32_t)lround(part * full(c) * (c < HIL_RUN_TRANSDUCERS ? 1e5 : 1e2));
    }
    return run->samples != NULL;
}

/* ---- what the board says ---- */

static void count_edge(struct play *play, const struct mr_edge *edge)
{
    struct board_outcome *outcome = play->outcome;
    unsigned i = play->edges++;
    if (edge->position == i + 1u)
        outcome->named++;
    else if (edge->position)
        outcome->misnamed++;
}

static void take_block(struct play *play, const struct mr_block *block)
{
    double since_s = play->now_s - LEVELS_S;
    if (since_s < 0.0 || play->request->only_switches)
        return;
    unsigned at = (unsigned)(since_s / LEVEL_S);
    double within_s = since_s - at * LEVEL_S;
    if (at >= LEVELS || within_s < 0.01 || within_s > HOLD_S)
        return;
    float ratio = mr_reference_ratio(&config.channel[MR_REFERENCE], block);
    play->blocks[at]++;
    for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++) {
        struct mr_reading reading = mr_channel_read(&config.channel[c], block, c, ratio);
        play->invalid[c] += reading.validity != MR_VALID;
        play->code[at][c] += (double)(reading.code * ratio);
    }
}

static void take_frame(struct play *play, const struct mr_frame *frame)
{
    struct mr_edge edge;
    struct mr_zero_result zero;
    struct mr_ack ack;
    struct mr_block block;
    if (frame->type == MR_ID_EDGE && mr_edge_get(&edge, frame->payload, frame->length) == MR_OK)
        count_edge(play, &edge);
    else if (frame->type == MR_ID_ZERO_RESULT &&
             mr_zero_result_get(&zero, frame->payload, frame->length) == MR_OK &&
             zero.index < HIL_RUN_COLUMNS)
        play->zeroed.channel[zero.index].zero_code = zero.zero_code;
    else if (frame->type == MR_ID_ACK && mr_ack_get(&ack, frame->payload, frame->length) == MR_OK &&
             ack.code == MR_COMMAND_ZERO)
        play->outcome->zero_taken = ack.status == MR_OK;
    else if (frame->type == MR_ID_BLOCK &&
             mr_block_decode(&block, frame->payload, frame->length) == MR_OK)
        take_block(play, &block);
}

static void on_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct play *play = ctx;
    struct mr_frame frame;
    play->now_s = (double)t_ps * 1e-12;
    for (size_t i = 0; i < n; i++) {
        if (mr_deframer_push(&play->deframer, bytes[i], &frame) == MR_OK)
            take_frame(play, &frame);
    }
}

/* ---- the run ---- */

static void order(struct play *play, unsigned code, int32_t argument)
{
    struct mr_command command = {.code = (uint8_t)code, .argument = argument, .tag = 1};
    uint8_t payload[MR_MESSAGE_BYTES_MAX], bytes[MR_FRAME_BYTES_MAX];
    size_t n = mr_command_put(&command, payload);
    (void)hil_usart_inject(&play->board->mcu.usart, bytes,
                           mr_frame_encode((uint16_t)code, MR_ID_COMMAND, payload, n, bytes));
}

static void until(struct play *play, double t_s)
{
    bench_run(play->board, (uint64_t)(t_s * 1e12));
}

static void run(struct play *play)
{
    const struct board_request *request = play->request;
    until(play, 0.1);
    order(play, MR_COMMAND_LIVE, 20);
    until(play, SWITCHES_S);
    if (request->only_switches)
        return;
    until(play, ZERO_S);
    order(play, MR_COMMAND_ZERO, 0);
    until(play, LEVELS_S + LEVELS * LEVEL_S);
}

/* ---- what is made of it ---- */

static double value_of(const struct mr_channel_config *channel, double code)
{
    return (code - (double)channel->zero_code) * (double)channel->unit_per_code;
}

static void judge(struct play *play, unsigned c)
{
    struct board_channel *out = &play->outcome->channel[c];
    struct mr_channel_config calibrated = config.channel[c];
    struct calibrate_point points[CALIBRATED];
    struct calibrate_fit fit;
    struct error error = {0};
    double code[LEVELS];
    for (unsigned i = 0; i < LEVELS; i++)
        code[i] = play->code[i][c] / play->blocks[i];
    for (unsigned i = 0; i < CALIBRATED; i++)
        points[i] = (struct calibrate_point){level[i] * full(c), code[i], (double)NAN};
    out->valid = !play->invalid[c];
    out->zeroed = value_of(&play->zeroed.channel[c], code[0]);
    out->left_worst = (double)NAN;
    if (!out->valid ||
        calibrate_fit(points, CALIBRATED, 0.0, false, &calibrated, &fit, &error) != MR_OK)
        return;
    out->left_worst = 0.0;
    for (unsigned i = CALIBRATED; i < LEVELS; i++) {
        double off = value_of(&calibrated, code[i]) - level[i] * full(c);
        out->left_worst = fabs(off) > fabs(out->left_worst) ? off : out->left_worst;
    }
}

static void board_play(const struct board_request *request, struct board_outcome *outcome)
{
    struct play *play = calloc(1, sizeof *play);
    struct hil_options options;
    struct hil_run truth;
    memset(outcome, 0, sizeof *outcome);
    assert_non_null(play);
    assert_true(make_run(&truth, request));
    struct hil_callbacks callbacks = {.context = play, .on_serial_bytes = on_serial};
    *play = (struct play){.request = request, .outcome = outcome, .zeroed = config};
    mr_deframer_init(&play->deframer);
    hil_options_default(&options);
    options.noise_seed = request->seed + 1u;
    options.has_random_tolerances = true;
    options.tolerance_seed = request->seed;
    options.vdda_v = request->vdda_v;
    options.figures = request->figures;
    play->board = hil_board_create(&options);
    hil_board_set_callbacks(play->board, &callbacks);
    assert_int_equal(hil_board_load_elf(play->board, EAR_ELF), MR_OK);
    hil_board_attach_rig(play->board, &truth);
    run(play);
    outcome->unnamed = HIL_RUN_SWITCHES - outcome->named - outcome->misnamed;
    for (unsigned c = 0; !request->only_switches && c < HIL_RUN_COLUMNS; c++)
        judge(play, c);
    hil_board_destroy(play->board);
    hil_run_free(&truth);
    free(play);
}

/* ---- a drawn board ---- */

TEST(a_curve_keeps_its_bounds)
{
    static float curve[HIL_ADC_CODES];
    uint64_t random = 3;
    for (unsigned n = 0; n < 50; n++) {
        double peak = 0.0, jump = 0.0, wanted = n % 2 ? 1.5 : 3.0;
        hil_adc_draw_inl(curve, wanted, &random);
        for (unsigned code = 0; code < HIL_ADC_CODES; code++) {
            peak = fmax(peak, fabs((double)curve[code]));
            jump = code ? fmax(jump, fabs((double)curve[code] - (double)curve[code - 1])) : 0.0;
        }
        assert_near(peak, wanted, 0.02);
        assert_true(jump < 2.05); /* ED, DS8626 table 68 */
        assert_near(curve[0], 0.0, 1e-6);
        assert_near(curve[HIL_ADC_CODES - 1], 0.0, 1e-6);
    }
}

/* 112 clocks of 21 MHz are 5.3 us, 108 time constants of 7 kOhm and 7 pF: the kick alone is left.
 * Three clocks are 143 ns, 2.92 time constants: 5.4 %. */
TEST(a_short_window_leaves_some_of_the_neighbour)
{
    static struct hil_adc_errors errors;
    errors.source_ohm[3] = 1000.0;
    errors.kickback_share[3] = 1e-4;
    assert_near(hil_adc_remaining_share(&errors, 3, 112.0 / 21e6), 1e-4, 1e-12);
    assert_near(hil_adc_remaining_share(&errors, 3, 3.0 / 21e6), 0.0542 + 1e-4, 2e-4);
}

TEST(a_seed_is_a_board)
{
    static struct hil_electronics one, again, other, ideal;
    struct hil_options options;
    hil_options_default(&options);
    hil_electronics_set_up(&ideal, &options, NULL);
    assert_false(ideal.has_drawn_tolerances);
    options.has_random_tolerances = true;
    options.tolerance_seed = 5;
    hil_electronics_set_up(&one, &options, NULL);
    hil_electronics_set_up(&again, &options, NULL);
    options.tolerance_seed = 6;
    hil_electronics_set_up(&other, &options, NULL);
    assert_memory_equal(&one, &again, sizeof one);
    assert_true(one.gage_gain[0] != other.gage_gain[0]);
    assert_true(one.adc_errors.inl_lsb[0][1000] != other.adc_errors.inl_lsb[0][1000]);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        assert_near(one.step_codes[i], ideal.step_codes[i], 1.0); /* 0.1 % of 248, twice */
}

/* A balance trim that reaches 680 lb: a bridge 500 lb off is trimmed to what is left; one 700 lb
 * off keeps 20. */
TEST(a_trim_reaches_so_far)
{
    assert_near(hil_electronics_trimmed_zero_lb(500.0, 680.0, 0.3), 0.3, 1e-12);
    assert_near(hil_electronics_trimmed_zero_lb(-700.0, 680.0, 0.3), -19.7, 1e-12);
}

static void covers(const char *what, double left, double stated)
{
    printf("# %s: %.4g by the figures, %.4g stated\n", what, left, stated);
    assert_true(stated >= left);
    assert_true(stated < 2.0 * left);
}

/* What the built-in configuration states covers the circuits' figures over 10 degrees either way
 * (evenly: over sqrt(3)), beside what the sensors' own sheets say, 0.5 % evenly. A bridge's zero:
 * trim, drift, the converter's offset and half of its INL. */
TEST(what_is_stated_covers_the_circuits)
{
    const struct mr_channel_config *gage = &config.channel[MR_TRANSDUCERS];
    const double warmer = 10.0 / sqrt(3.0), sheet = 0.005 / sqrt(3.0);
    struct hil_circuit_figures f;
    hil_circuit_figures_set_reference(&f);
    double converter = hypot(f.adc_offset_lsb, 0.5 * f.adc_inl_typical_lsb);
    covers("a bridge's zero before it is measured, lb",
           hypot(hypot(f.gage_trim_residual_lb, f.gage_drift_lb_k * warmer),
                 converter * (double)gage->unit_per_code),
           (double)gage->zero_error);
    double read = hypot(f.reference_read_sd_rel, converter / (double)MR_REFERENCE_CODE);
    covers("a bridge's gain",
           hypot(hypot(sheet, f.gage_gain_sd_rel), hypot(f.gage_excitation_sd_rel, read)),
           (double)gage->gain_error);
    covers("a transducer's gain",
           hypot(hypot(hypot(sheet, f.transducer_gain_sd_rel),
                       f.transducer_cell_ppm_k * 1e-6 * warmer),
                 hypot(f.transducer_excitation_sd_rel, read)),
           (double)config.channel[0].gain_error);
}

/* Ten boards (make long: a thousand): every switch has its name, every trimmed bridge is inside
 * the amplifier's range, the command zero is taken, and what a calibration leaves is what it says.
 * */
TEST(boards_name_and_measure)
{
    static struct board_outcome o;
    unsigned boards = tests_take(10, 1000), named = 0, inside = 0, edge = 0;
    double zero_lb = 0.0, zero_in = 0.0, worst_lb = 0.0, worst_in = 0.0;
    for (uint64_t seed = 0; seed < boards; seed++) {
        board_play(&(struct board_request){.seed = seed, .vdda_v = board_vdda_v(seed)}, &o);
        assert_int_equal(o.misnamed, 0);
        named += o.named;
        /* at 3.24 and 3.36 V what the reference's own error leaves of the 2 % is 0.18 % */
        if (!o.zero_taken) {
            assert_true(fabs(board_vdda_v(seed) - 3.3) > 0.055);
            edge++;
            continue;
        }
        for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++) {
            bool gage = c >= HIL_RUN_TRANSDUCERS;
            double *zero = gage ? &zero_lb : &zero_in, *worst = gage ? &worst_lb : &worst_in;
            inside += o.channel[c].valid;
            *zero += o.channel[c].zeroed * o.channel[c].zeroed;
            *worst = fmax(*worst, fabs(o.channel[c].left_worst));
        }
    }
    zero_lb = sqrt(zero_lb / ((boards - edge) * HIL_RUN_GAGES));
    zero_in = sqrt(zero_in / ((boards - edge) * HIL_RUN_TRANSDUCERS));
    printf("# %u boards: %u of %u switches named, %u of %u channels inside, %u at the reference's "
           "edge, zeros "
           "%.3f lb, %.5f in rms; calibrated, worst %.2f lb, %.4f in\n",
           boards, named, 24 * boards, inside, HIL_RUN_COLUMNS * boards, edge, zero_lb, zero_in,
           worst_lb, worst_in);
    assert_true(edge <= boards / 50);
    assert_int_equal(inside, HIL_RUN_COLUMNS * (boards - edge));
    assert_true(named >= 24 * boards - boards / 100);
    /* firmware/channels.h states 0.1 lb and 0.0005 in */
    assert_true(zero_lb < 0.1 && zero_in < 0.0005);
    /* the converter's curve, 3 LSB at most: 0.5 lb; half a difference: 0.005 in */
    assert_true(worst_lb < 1.0 && worst_in < 0.006);
}

/* With INL of exactly 1.5 LSB none of 24 switches is misnamed, on any board; with resistors 30
 * times as far off, 3 %, some are: the check can fail. */
TEST(no_switch_is_misnamed_at_typical_inl)
{
    static struct board_outcome o;
    struct hil_circuit_figures f;
    unsigned boards = tests_take(10, 1000), bad = 0;
    hil_circuit_figures_set_reference(&f);
    f.adc_inl_typical_lsb = f.adc_inl_max_lsb = 1.5;
    struct board_request request = {.figures = &f, .only_switches = true};
    for (request.seed = 0; request.seed < boards; request.seed++) {
        request.vdda_v = board_vdda_v(request.seed);
        board_play(&request, &o);
        assert_int_equal(o.misnamed, 0);
        assert_int_equal(o.unnamed, 0);
    }
    f.staircase_resistor_tol_rel = 0.03;
    for (request.seed = 0; request.seed < 5; request.seed++) {
        board_play(&request, &o);
        bad += o.misnamed + o.unnamed;
    }
    assert_true(bad > 0);
}

/* Lamp and relay with their times: the board's own test finds nothing. */
TEST(a_drawn_board_passes_its_self_test)
{
    struct hil_options options = ear_options();
    options.has_random_tolerances = true;
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, 0);
    struct mr_self_test test;
    ear_until(ear, 1.5);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_SELF_TEST, 0, 77);
    ear_until(ear, 8.0);
    assert_int_equal(mr_self_test_get(&test, ear->last[EAR_SERIAL][MR_ID_SELF_TEST], 8), MR_OK);
    assert_int_equal(test.tag, 77);
    assert_int_equal(test.failed, 0);
    assert_true(test.done & 1u << MR_SELF_TEST_LAMP_ON);
    ear_close(ear);
}

/* Changes of the lamp's read-back in 20 ms, while pins of the board go on changing. */
static unsigned changes_of_lamp(struct hil_board *board)
{
    const struct hil_pin_location lamp = board->options.type->lamp_sense_pin;
    bool was = hil_gpio_level(&board->mcu.gpio, lamp.port, lamp.pin);
    uint64_t now_ps = hil_board_now_ps(board);
    unsigned changes = 0;
    for (unsigned i = 0; i < 400; i++) {
        assert_int_equal(hil_board_run_until(board, now_ps + i * 50 * HIL_PS_PER_US), MR_OK);
        if (i % 40 == 20)
            hil_gpio_notify_listeners(&board->mcu.gpio, hil_now_cycle(&board->core));
        bool is = hil_gpio_level(&board->mcu.gpio, lamp.port, lamp.pin);
        changes += is != was;
        was = is;
    }
    return changes;
}

/* Not driven, its output warns: the lamp draws. A lamp that breaks is noticed after the read-back's
 * time, once, whatever other pins do then; so is one that was mended. */
TEST(a_lamp_that_breaks_is_noticed_once)
{
    struct hil_options options;
    hil_options_default(&options);
    options.has_random_tolerances = true;
    struct hil_board *board = bench_board("pins", &options);
    (void)changes_of_lamp(board);
    assert_true(board->electronics.lamp_sense_ps > 0);
    hil_rig_set_lamp_fault(&board->rig, HIL_LAMP_BROKEN);
    assert_int_equal(changes_of_lamp(board), 1);
    hil_rig_set_lamp_fault(&board->rig, HIL_LAMP_GOOD);
    assert_int_equal(changes_of_lamp(board), 1);
    hil_board_destroy(board);
}

/* The 24 hexadecimal digits that a campaign files a board under: a thousand seeds, a thousand
 * boards; without a seed the one of ever. */
TEST(a_drawn_board_has_its_own_identity)
{
    enum { BOARDS = 1000 };
    static uint32_t uid[BOARDS][3];
    struct hil_options options, usual;
    hil_options_default(&usual);
    options = usual;
    options.has_random_tolerances = true;
    for (options.tolerance_seed = 0; options.tolerance_seed < BOARDS; options.tolerance_seed++) {
        uint32_t *own = uid[options.tolerance_seed], again[3];
        hil_electronics_chip_uid(options.tolerance_seed, own);
        hil_electronics_chip_uid(options.tolerance_seed, again);
        assert_memory_equal(own, again, sizeof again);
        assert_memory_equal((const uint8_t *)own + 5, "EMU", 3);
        for (uint64_t i = 0; i < options.tolerance_seed; i++)
            assert_memory_not_equal(uid[i], own, sizeof uid[i]);
    }
    assert_memory_equal((const uint8_t *)usual.uid + 5, "EMU", 3);
    options.tolerance_seed = 7;
    struct hil_board *drawn = hil_board_create(&options), *ideal = hil_board_create(&usual);
    assert_memory_equal(drawn->options.uid, uid[7], sizeof uid[7]);
    assert_memory_equal(ideal->options.uid, usual.uid, sizeof usual.uid);
    hil_board_destroy(drawn);
    hil_board_destroy(ideal);
}
