/* Does the interval of the uncertainty budget hold? Drawn calibrations and landings
 * against the budget's expanded uncertainty, and against the stated error alone.
 *
 * usage: study DRAWS [--without SOURCE]     a table; exit 1 when an interval holds in less than
 *                                           93.5 or more than 97 % of the draws. SOURCE:
 *                                           certificate or temperature, left out of the sum
 *
 * Drawn are calibrations and landings of one transducer and one gage, from volts: a board of the
 * reference circuits, a sensor with a curve, a laboratory whose standard is off, a calibration
 * through points, another temperature, and then a landing. What is wrong in the end is known,
 * because the truth is.
 *
 * Nothing of the drawing knows the uncertainty budget (host/calibrate/budget.h), which is held
 * against it. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "common/config.h"
#include "common/splitmix.h"
#include "firmware/config.h"
#include "hil/periph/options.h"
#include "hil/rig/electronics.h"
#include "host/base/statistics.h"
#include "host/calibrate/budget.h"
#include "host/calibrate/fit.h"

/* What is drawn beside the board, which hil/rig/electronics.c draws. */
struct draw_setting {
    double laboratory_rel; /* standard: the scale of its standard, common to all points */
    double setting;        /* standard: of one known value, in or lb, by chance each time */
    double kelvin;         /* the landing is so much warmer or colder at most, evenly */
    double least, most;    /* of the landing's true value, in or lb, evenly */
    double known_most;     /* points from 0 to this, up and down */
    unsigned steps;
};

struct drawn {
    struct mr_channel_config channel;   /* as matrig calibrate made it */
    struct mr_error_conditions reading; /* how the landing was read */
    double value, truth;                /* in or lb: movement, or tension */
};

/* The transducer d3, or the gage t2. The configuration's reference and curve are the built-in
 * ones. */
enum draw_kind { DRAW_TRANSDUCER, DRAW_GAGE };

#define TWO_PI        6.28318530717958647693
#define TRANSDUCER    2u /* d3 */
#define GAGE          1u /* t2 */
#define POINT_BLOCKS  40u
#define REST_BLOCKS   200u
#define HOURS         1.0 /* since the gage's zero, as the temperature went */
/* of hil/rig/rig.c: what the ideal board's sensors give */
#define REFERENCE_V   2.5
#define MID_V         1.65
#define ZERO_V        0.050
#define V_PER_IN      0.5
#define GAGE_ZERO_V   0.400
#define GAGE_V_PER_LB 0.005
#define CODES         4096.0

struct rig {
    enum draw_kind kind;
    struct hil_electronics board;
    uint64_t chance;
    double warmer_k;
    double curve, phase, wave; /* of the sensor, in or lb, and its length */
};

static double normal(uint64_t *chance)
{
    double u = 1.0 - mr_splitmix64_uniform(chance), v = mr_splitmix64_uniform(chance);
    return sqrt(-2.0 * log(u)) * cos(TWO_PI * v);
}

static double evenly(uint64_t *chance, double low, double high)
{
    return low + (high - low) * mr_splitmix64_uniform(chance);
}

/* ---- volts to codes ---- */

static double convert(struct rig *rig, unsigned unit, unsigned source, double volts)
{
    const struct hil_adc_errors *adc = &rig->board.adc_errors;
    double code = hil_adc_code_with_errors(adc, unit, volts / rig->board.vdda_v * CODES) +
                  HIL_ADC_NOISE_LSB * adc->noise_ratio[source] * normal(&rig->chance);
    return fmin(fmax(floor(code + 0.5), 0.0), CODES - 1.0);
}

static double sensor(const struct rig *rig, double truth)
{
    return truth + rig->curve * (sin(TWO_PI * truth / rig->wave + rig->phase) - sin(rig->phase));
}

static double reference(const struct rig *rig)
{
    return rig->board.reference_ratio * (1.0 + rig->board.reference_drift_per_k * rig->warmer_k);
}

static double transducer_volts(const struct rig *rig, double truth, double polarity)
{
    const struct hil_electronics *e = &rig->board;
    double swing = ZERO_V + V_PER_IN * (sensor(rig, truth) + e->transducer_zero_in[TRANSDUCER]);
    swing *= e->transducer_gain[TRANSDUCER] + e->transducer_gain_per_k * rig->warmer_k;
    return (MID_V + e->transducer_mid_v[TRANSDUCER] + polarity * swing) * reference(rig);
}

static double gage_volts(const struct rig *rig, double truth)
{
    const struct hil_electronics *e = &rig->board;
    double lb = sensor(rig, truth) * e->gage_gain[GAGE] + e->gage_zero_lb[GAGE] +
                e->gage_drift_lb_k[GAGE] * rig->warmer_k;
    return (GAGE_ZERO_V + GAGE_V_PER_LB * lb) * reference(rig);
}

/* One block: eight conversions each, codes times the reference's ratio. */
static double block_code(struct rig *rig, double truth)
{
    double sum = 0.0, read = 0.0;
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        double polarity = scan % 2 ? -1.0 : 1.0;
        if (rig->kind == DRAW_TRANSDUCER)
            sum += polarity * convert(rig, 1, TRANSDUCER, transducer_volts(rig, truth, polarity));
        else
            sum += convert(rig, 0, MR_TRANSDUCERS + GAGE, gage_volts(rig, truth));
        read += convert(rig, 0, MR_REFERENCE,
                        REFERENCE_V * rig->board.reference_reading_ratio * reference(rig));
    }
    return sum / MR_SCANS_PER_BLOCK * (double)MR_REFERENCE_CODE / (read / MR_SCANS_PER_BLOCK);
}

static double mean_code(struct rig *rig, double truth, unsigned blocks, double *spread)
{
    double sum = 0.0, squares = 0.0;
    for (unsigned i = 0; i < blocks; i++) {
        double code = block_code(rig, truth);
        sum += code;
        squares += code * code;
    }
    double mean = sum / blocks;
    if (spread)
        *spread = sqrt(fmax(squares - sum * mean, 0.0) / (blocks - 1.0));
    return mean;
}

/* ---- calibration and landing ---- */

static void calibrate(struct rig *rig, const struct draw_setting *setting, struct drawn *drawn)
{
    struct calibrate_point point[CALIBRATE_POINTS_MAX];
    struct calibrate_fit fit;
    struct error error = {0};
    size_t count = 0;
    double scale = 1.0 + setting->laboratory_rel * normal(&rig->chance);
    for (unsigned i = 0; i < 2u * setting->steps; i++) {
        unsigned step = i < setting->steps ? i : 2u * setting->steps - 1u - i;
        double known = setting->known_most * step / (setting->steps - 1u);
        double truth = known * scale + setting->setting * normal(&rig->chance);
        point[count++] = (struct calibrate_point){
            .value = known, .code = mean_code(rig, truth, POINT_BLOCKS, NULL)};
    }
    if (calibrate_fit(point, count, 0.0, false, &drawn->channel, &fit, &error) != MR_OK) {
        fprintf(stderr, "a drawn calibration failed: %s\n", error.text);
        exit(2);
    }
    drawn->channel.calibrated_day = 1;
}

static double value_of(const struct drawn *drawn, double code)
{
    const struct mr_channel_config *channel = &drawn->channel;
    float straight = ((float)code - channel->zero_code) * channel->unit_per_code;
    return (double)mr_channel_linearise(channel, straight);
}

static void land(struct rig *rig, const struct draw_setting *setting, struct drawn *drawn)
{
    bool movement = rig->kind == DRAW_TRANSDUCER;
    double spread;
    rig->warmer_k = evenly(&rig->chance, -setting->kelvin, setting->kelvin);
    drawn->truth = evenly(&rig->chance, setting->least, setting->most);
    double rest = value_of(drawn,
                           mean_code(rig, movement ? 0.0 : drawn->truth, REST_BLOCKS, &spread));
    drawn->value = value_of(drawn, block_code(rig, drawn->truth)) - (movement ? rest : 0.0);
    drawn->reading = (struct mr_error_conditions){
        .value = (float)drawn->value,
        .noise = (float)spread * fabsf(drawn->channel.unit_per_code),
        .averaged_blocks = 1.0f,
        .baseline_blocks = movement ? (float)REST_BLOCKS : 0.0f,
        .hours = movement ? 0.0f : (float)HOURS,
        .reference_error = config.channel[MR_REFERENCE].gain_error,
    };
}

static void draw(enum draw_kind kind, const struct draw_setting *setting, uint64_t seed,
                 struct drawn *drawn)
{
    struct rig *rig = calloc(1, sizeof *rig);
    struct hil_options options;
    if (!rig)
        abort();
    hil_options_default(&options);
    rig->kind = kind;
    rig->chance = seed * 0x9e6c63d0876a9a99u + kind;
    options.has_random_tolerances = true;
    options.tolerance_seed = seed;
    options.vdda_v = evenly(&rig->chance, 3.24, 3.36);
    hil_electronics_set_up(&rig->board, &options, NULL);
    drawn->channel = config.channel[kind == DRAW_TRANSDUCER ? TRANSDUCER : MR_TRANSDUCERS + GAGE];
    rig->curve = (double)drawn->channel.linearity_error; /* rms over the range */
    rig->phase = evenly(&rig->chance, 0.0, TWO_PI);
    rig->wave = setting->known_most * evenly(&rig->chance, 0.3, 0.9);
    calibrate(rig, setting, drawn);
    land(rig, setting, drawn);
    free(rig);
}

/* --- against the budget --- */

#define LEAST  93.5
#define MOST   97.0
#define NORMAL 1.959964

static const struct study {
    const char *name, *unit;
    enum draw_kind kind;
    double certificate_rel, factor; /* expanded, of the reading */
    struct draw_setting setting;
} studies[] = {
    {"transducer",
     "in",
     DRAW_TRANSDUCER,
     0.008,
     2.0,
     {.laboratory_rel = 0.004,
      .setting = 0.001,
      .kelvin = 10.0,
      .least = 0.3,
      .most = 2.5,
      .known_most = 2.7,
      .steps = 10}},
    {"gage",
     "lb",
     DRAW_GAGE,
     0.004,
     2.0,
     {.laboratory_rel = 0.002,
      .setting = 0.05,
      .kelvin = 10.0,
      .least = 50.0,
      .most = 350.0,
      .known_most = 400.0,
      .steps = 10}},
};
#define STUDIES (sizeof studies / sizeof studies[0])

struct tally {
    unsigned stated, expanded;
    double squares[BUDGET_SOURCE_COUNT]; /* of the contributions */
    double errors, errors_rel; /* squared; the second in combined standard uncertainties */
};

static void take(const struct study *study, const char *without, uint64_t seed, struct tally *t)
{
    struct drawn drawn;
    struct budget budget;
    draw(study->kind, &study->setting, seed, &drawn);
    bool certificate = !without || strcmp(without, "certificate") != 0,
         temperature = !without || strcmp(without, "temperature") != 0;
    const struct budget_case of = {
        .channel = &drawn.channel,
        .reading = drawn.reading,
        .certificate_expanded_uncertainty = certificate ? study->certificate_rel * fabs(drawn.value)
                                                        : (double)NAN,
        .certificate_coverage_factor = study->factor,
        .temperature_half_range_k = temperature ? study->setting.kelvin : 0.0};
    budget_compute(&of, &budget);
    double off = drawn.value - drawn.truth;
    t->stated += fabs(off) <= NORMAL * budget.stated_error;
    t->expanded += fabs(off) <= budget.expanded_uncertainty;
    t->errors += off * off;
    t->errors_rel += off * off / (budget.combined_uncertainty * budget.combined_uncertainty);
    for (enum budget_source s = 0; s < BUDGET_SOURCE_COUNT; s++)
        t->squares[s] += budget.row[s].contribution * budget.row[s].contribution;
}

static void print_rows(const struct tally *t, unsigned draws)
{
    printf("\n| Contribution (rms) | %s (%s) | %s (%s) |\n|---|--:|--:|\n", studies[0].name,
           studies[0].unit, studies[1].name, studies[1].unit);
    for (enum budget_source s = 0; s < BUDGET_SOURCE_COUNT; s++) {
        printf("| %s |", budget_source_label(s));
        for (size_t i = 0; i < STUDIES; i++)
            printf(" %.2g |", sqrt(t[i].squares[s] / draws));
        printf("\n");
    }
    printf("| true error |");
    for (size_t i = 0; i < STUDIES; i++)
        printf(" %.2g |", sqrt(t[i].errors / draws));
    printf("\n");
}

int main(int argc, char **argv)
{
    unsigned draws = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 0;
    const char *without = argc == 4 && strcmp(argv[2], "--without") == 0 ? argv[3] : NULL;
    struct tally tally[STUDIES] = {0};
    bool held = true;
    if (draws < 1 || draws > 100000 || (argc != 2 && !without)) {
        fputs("usage: study DRAWS [--without certificate|temperature]\n", stderr);
        return 2;
    }
    printf("| Sensor | Draws | Expanded holds (%%) | Wilson 95 %% (%%) | RMS error ÷ combined "
           "error | Stated "
           "holds (%%) |\n|---|--:|--:|--:|--:|--:|\n");
    for (size_t i = 0; i < STUDIES; i++) {
        for (unsigned seed = 1; seed <= draws; seed++)
            take(&studies[i], without, seed, &tally[i]);
        const struct tally *t = &tally[i];
        struct proportion_interval proportion_interval = compute_proportion_interval(t->expanded,
                                                                                     draws);
        double percent = 100.0 * t->expanded / draws;
        printf("| %s | %u | %.1f | %.1f to %.1f | %.2f | %.1f |\n", studies[i].name, draws, percent,
               100.0 * proportion_interval.low, 100.0 * proportion_interval.high,
               sqrt(t->errors_rel / draws), 100.0 * t->stated / draws);
        held &= percent >= LEAST && percent <= MOST;
    }
    print_rows(tally, draws);
    return held ? 0 : 1;
}
