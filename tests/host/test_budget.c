/* The uncertainty budget: each row by hand from the formulas of the GUM, the stated part against
 * the stated error, and the coverage factor against numbers that another program gave (exact
 * distribution of a normal and a rectangular variable, Python's statistics.NormalDist). */
#include <math.h>

#include "common/channels.h"
#include "host/calibrate/budget.h"
#include "tests/cmocka_all.h"

/* As firmware/config.c has them, or near: a transducer of 620 codes an inch, a gage of 6.2 codes a
 * pound. */
static struct mr_channel_config transducer, gage;
static struct budget_case of;
static struct budget b;

static int fresh(void **state)
{
    (void)state;
    transducer = (struct mr_channel_config){.kind = MR_KIND_DISPLACEMENT,
                                            .unit_per_code = 0.0016f,
                                            .zero_code = 62.0f,
                                            .gain_error = 0.003f,
                                            .zero_error = 0.006f,
                                            .linearity_error = 0.002f,
                                            .drift_error_per_h = 0.002f,
                                            .low = -0.5f,
                                            .high = 3.0f,
                                            .calibrated_day = 20000};
    gage = (struct mr_channel_config){.kind = MR_KIND_TENSION,
                                      .unit_per_code = 0.16f,
                                      .zero_code = 500.0f,
                                      .gain_error = 0.003f,
                                      .zero_error = 0.1f,
                                      .linearity_error = 0.1f,
                                      .drift_error_per_h = 0.5f,
                                      .low = -75.0f,
                                      .high = 575.0f,
                                      .calibrated_day = 20000};
    of = (struct budget_case){.channel = &transducer,
                              .reading = {.value = 1.0f,
                                          .noise = 0.7f * 0.0016f,
                                          .averaged_blocks = 4.0f,
                                          .baseline_blocks = 400.0f,
                                          .reference_error = 0.0003f},
                              .certificate_expanded_uncertainty = 0.004,
                              .certificate_coverage_factor = 2.0,
                              .station_error_ft = 0.001,
                              .slope_max_in_ft = 0.105,
                              .temperature_half_range_k = 10.0};
    return 0;
}

static void use_gage(void)
{
    of.channel = &gage;
    of.reading = (struct mr_error_conditions){.value = 100.0f,
                                              .noise = 0.0f,
                                              .averaged_blocks = 1.0f,
                                              .hours = 2.0f,
                                              .reference_error = 0.0003f};
}

static void is(enum budget_source source, double contribution)
{
    if (fabs(b.row[source].contribution - contribution) > 1e-4 * contribution + 1e-12)
        fail_msg("%s: %.8g, wanted %.8g", budget_source_name(source), b.row[source].contribution,
                 contribution);
}

static void adds_up(void)
{
    double stated = 0.0, all = 0.0;
    for (enum budget_source s = 0; s < BUDGET_SOURCE_COUNT; s++) {
        const struct budget_row *row = &b.row[s];
        assert_near(row->standard_uncertainty, row->input / row->divisor, 1e-12);
        assert_near(row->contribution, fabs(row->sensitivity) * row->standard_uncertainty,
                    1e-9 + 1e-6 * row->contribution);
        all += row->contribution * row->contribution;
        stated += s < BUDGET_STATED_COUNT ? row->contribution * row->contribution : 0.0;
    }
    assert_near(b.combined_uncertainty, sqrt(all), 1e-6 * b.combined_uncertainty);
    assert_near(b.stated_error, sqrt(stated), 1e-6 * b.combined_uncertainty);
    assert_near(b.stated_error, (double)mr_reading_error(of.channel, &of.reading),
                1e-5 * b.combined_uncertainty);
}

TEST_IN(a_movement_by_hand, fresh, NULL)
{
    budget_compute(&of, &b);
    adds_up();
    is(BUDGET_NOISE, 0.00112 * sqrt(1.0 / 4.0 + 1.0 / 400.0));
    is(BUDGET_ROUNDING, 0.0); /* 0.7 codes of noise average it away */
    is(BUDGET_GAIN, 0.003);
    is(BUDGET_ZERO, 0.0); /* of a movement */
    is(BUDGET_DRIFT, 0.0);
    is(BUDGET_LINEARITY, 0.002);
    is(BUDGET_REFERENCE, 0.0003);
    is(BUDGET_CERTIFICATE, 0.002);
    is(BUDGET_BASELINE, 0.002); /* a straight line leaves as much at the zero */
    is(BUDGET_POSITION, 0.000105);
    is(BUDGET_TEMPERATURE, 724.9e-6 * 10.0 / sqrt(3.0)); /* hil/circuits/figures.def */
    assert_near(b.row[BUDGET_NOISE].input, 0.7, 1e-6);
    transducer.points = 4; /* of which the zero is one */
    budget_compute(&of, &b);
    is(BUDGET_BASELINE, 0.0);
    transducer.calibrated_day = 0; /* its stated gain has the temperature */
    budget_compute(&of, &b);
    is(BUDGET_TEMPERATURE, 0.0);
}

TEST_IN(a_tension_by_hand, fresh, NULL)
{
    use_gage();
    of.certificate_expanded_uncertainty = (double)NAN; /* none */
    budget_compute(&of, &b);
    adds_up();
    is(BUDGET_NOISE, 0.0);
    is(BUDGET_ROUNDING, 0.289 * 0.16);
    assert_near(b.row[BUDGET_ROUNDING].divisor, 1.7320508, 1e-6);
    is(BUDGET_GAIN, 0.3);
    is(BUDGET_ZERO, 0.1);
    is(BUDGET_DRIFT, 1.0); /* 2 h */
    is(BUDGET_REFERENCE, 0.0003 * (100.0 + 500.0 * 0.16));
    is(BUDGET_CERTIFICATE, 0.0);
    is(BUDGET_BASELINE, 0.0); /* of an absolute reading */
    is(BUDGET_POSITION, 0.0);
    is(BUDGET_TEMPERATURE, 0.0); /* 0.0835 * 10 / sqrt(3) = 0.48 lb: the stated drift has it */
    assert_near(b.coverage_factor, 1.959964, 1e-3);
    of.reading.hours = 0.0f; /* no drift is stated: the zero alone */
    budget_compute(&of, &b);
    adds_up();
    is(BUDGET_TEMPERATURE, sqrt(0.08353 * 0.08353 * 100.0 / 3.0 - 0.1 * 0.1));
}

/* Share of the variance that is rectangular, and the factor. */
TEST_IN(the_factor_is_of_both_distributions, fresh, NULL)
{
    static const double known[][2] = {{0.0, 1.95996},  {0.25, 1.95214}, {0.5, 1.91742},
                                      {0.75, 1.83556}, {0.9, 1.74384},  {1.0, 1.64545}};
    transducer.gain_error = transducer.linearity_error = 0.0f;
    of.reading.noise = 0.0f;
    of.reading.reference_error = 0.0f;
    transducer.unit_per_code = 1e-12f;
    of.station_error_ft = 0.0;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        of.certificate_expanded_uncertainty = sqrt(1.0 - known[i][0]);
        of.certificate_coverage_factor = 1.0;
        of.temperature_half_range_k = sqrt(3.0 * known[i][0]) / 724.9e-6;
        budget_compute(&of, &b);
        assert_near(b.combined_uncertainty, 1.0, 1e-6);
        assert_near(b.coverage_factor, known[i][1], 2e-3);
        assert_near(b.expanded_uncertainty, b.coverage_factor * b.combined_uncertainty, 1e-12);
    }
}
