/* Figures of two series against the closed form of functions that are known: shifted, scaled and
 * noisy copies. */
#include <math.h>
#include <string.h>

#include "host/compare/figures.h"
#include "tests/cmocka_all.h"

#define N    4000u
#define DT_S 0.001
struct pair {
    double m[N], s[N], um[N], us[N], ut[N];
    struct signal signal;
};

static void make(struct pair *p, double (*measured)(double), double (*simulated)(double),
                 double noise)
{
    for (size_t i = 0; i < N; i++) {
        double t_s = (double)i * DT_S;
        p->m[i] = measured(t_s);
        p->s[i] = simulated(t_s);
        p->um[i] = p->us[i] = 0.003; /* together 0.003 sqrt(2) */
        p->ut[i] = 0.0;
    }
    p->signal = (struct signal){N, 0.0, DT_S, p->m, p->s, p->um, p->us, p->ut, noise};
}

/* A movement as mats make it: 0.8 in, risen within about a second; and copies. */
static double rise(double t_s)
{
    return 0.4 * (1.0 + tanh((t_s - 2.0) / 0.2));
}
static double raised(double t_s)
{
    return rise(t_s) + 0.05;
}
static double later(double t_s)
{
    return rise(t_s - 0.0725);
}
static double larger(double t_s)
{
    return 1.25 * rise(t_s);
}
static double fallen(double t_s)
{
    return -rise(t_s);
}
static double sine(double t_s)
{
    return sin(2.0 * M_PI * t_s);
}
static double cosine(double t_s)
{
    return cos(2.0 * M_PI * t_s);
}

static struct pair pair;

TEST(the_same_differs_by_nothing)
{
    struct signal_figures f;
    make(&pair, rise, rise, 0.0);
    signal_compute_figures(&pair.signal, &f);
    assert_int_equal(f.compared_sample_count, N);
    assert_near(f.bias, 0.0, 0.0);
    assert_near(f.rms, 0.0, 0.0);
    assert_near(f.rms_per_error, 0.0, 0.0);
}

TEST(an_offset_is_the_bias)
{
    struct signal_figures f;
    make(&pair, raised, rise, 0.001);
    signal_compute_figures(&pair.signal, &f);
    assert_near(f.bias, 0.05, 1e-12);
    assert_near(f.rms, 0.05, 1e-12);
    assert_near(f.rms_per_error, 0.05 / (0.003 * sqrt(2.0)), 1e-9);
    /* noise averages out over the samples, the rest does not */
    assert_near(f.bias_error, sqrt(2.0 * 0.003 * 0.003 - 1e-6 + 1e-6 / N), 1e-9);
    assert_near(f.peak_measured.value - f.peak_simulated.value, 0.05, 1e-9);
}

TEST(a_scale_is_in_rms_and_peak)
{
    struct signal_figures f;
    double sum = 0.0, squares = 0.0;
    make(&pair, larger, rise, 0.0);
    for (size_t i = 0; i < N; i++) {
        sum += 0.25 * pair.s[i];
        squares += 0.0625 * pair.s[i] * pair.s[i];
    }
    signal_compute_figures(&pair.signal, &f);
    /* closed form of the mean, and of (1 + tanh)^2 = 2 (1 + tanh) - (1 - tanh^2): 2 - 2 w / 4 s, w
     * = 0.2 */
    assert_near(f.bias, 0.25 * 0.8 * 0.5, 2e-4);
    assert_near(f.bias, sum / N, 1e-12);
    assert_near(f.rms, sqrt(squares / N), 1e-12);
    assert_near(f.rms, 0.25 * 0.4 * sqrt(2.0 - 0.1), 2e-4);
    assert_near(f.peak_measured.value, 1.0, 1e-6);
    assert_near(f.peak_simulated.value, 0.8, 1e-6);
    /* 10 % of the own peak is at the same time, tanh((t - 2)/0.2) = -0.8, whatever the scale */
    assert_near(f.arrival_measured.t_s, 2.0 + 0.2 * atanh(-0.8), 2e-4);
    assert_near(f.arrival_simulated.t_s, f.arrival_measured.t_s, 1e-9);
}

TEST(a_delay_is_a_later_arrival)
{
    struct signal_figures f;
    make(&pair, later, rise, 0.0);
    signal_compute_figures(&pair.signal, &f);
    assert_near(f.arrival_measured.t_s - f.arrival_simulated.t_s, 0.0725, 1e-6);
}

TEST(a_quarter_of_a_turn)
{
    struct signal_figures f;
    make(&pair, cosine, sine, 0.0);
    signal_compute_figures(&pair.signal, &f);
    assert_near(f.bias, 0.0, 1e-9);
    assert_near(f.rms, 1.0, 1e-9); /* sqrt(1/2 + 1/2) */
}

TEST(against_the_direction)
{
    struct signal_figures f;
    make(&pair, fallen, rise, 0.0);
    signal_compute_figures(&pair.signal, &f);
    assert_near(f.peak_measured.value, -0.8, 1e-6);
    assert_near(f.arrival_measured.value, -0.08, 1e-7);
    assert_near(f.arrival_measured.t_s, f.arrival_simulated.t_s, 1e-9);
}

/* Error of the crossing: value's error over the slope, 0.08 in at tanh = -0.8: du/dt = 0.4/0.2 (1 -
 * 0.64) = 0.72 in/s. */
TEST(arrival_and_its_error)
{
    struct signal_figures f;
    make(&pair, rise, rise, 0.001);
    for (size_t i = 0; i < N; i++)
        pair.ut[i] = 0.002;
    signal_compute_figures(&pair.signal, &f);
    double noise = 0.001 / sqrt(11.0), u = sqrt(0.003 * 0.003 - 1e-6 + noise * noise),
           grid = DT_S / sqrt(12.0);
    assert_near(f.arrival_measured.t_error_s, sqrt(u * u / (0.72 * 0.72) + 4e-6 + grid * grid),
                5e-5);
    assert_near(f.arrival_simulated.t_error_s, sqrt(9e-6 / (0.72 * 0.72) + grid * grid), 5e-5);
    pair.signal.noise_deviation =
        0.08; /* 5 x 0.08 / sqrt(11) = 0.12 in: it cannot be told from noise */
    signal_compute_figures(&pair.signal, &f);
    assert_true(isnan(f.arrival_measured.t_s));
}

TEST(a_plateau_has_no_sharp_time)
{
    struct signal_figures f;
    make(&pair, rise, sine, 0.01);
    signal_compute_figures(&pair.signal, &f);
    /* within 5 x 0.01 / sqrt(11) = 0.01508 in of 0.8: since tanh((t - 2) / 0.2) = 1 - 0.0377, to
     * the end */
    assert_near(f.peak_measured.t_s, 2.0 + 0.2 * atanh(1.0 - 0.01508 / 0.4), 0.005);
    /* 0.01508 of 1: x = acos(0.98492) = 0.1739 rad = 27.7 ms on either side, the same three turns
     * later */
    assert_near(fmod(f.peak_simulated.t_s + 0.0277, 1.0),
                f.peak_simulated.value > 0.0 ? 0.25 : 0.75, 0.003);
}

TEST(holes_are_left_out)
{
    struct signal_figures f;
    make(&pair, raised, rise, 0.0);
    for (size_t i = 1000; i < 1500; i++)
        pair.m[i] = (double)NAN;
    for (size_t i = 1400; i < 2000; i++)
        pair.s[i] = (double)NAN;
    signal_compute_figures(&pair.signal, &f);
    assert_int_equal(f.compared_sample_count, N - 1000);
    assert_near(f.bias, 0.05, 1e-12);
    assert_near(f.rms, 0.05, 1e-12);
    for (size_t i = 0; i < N; i++)
        pair.m[i] = (double)NAN;
    signal_compute_figures(&pair.signal, &f);
    assert_int_equal(f.compared_sample_count, 0);
}

TEST(normalised_errors)
{
    assert_near(signal_compute_en_score(1.0, 0.03, 0.9, 0.04), 1.0, 1e-12); /* 0.1 / (2 x 0.05) */
    assert_near(signal_compute_en_score(0.9, 0.03, 1.0, 0.04), 1.0, 1e-12);
    assert_near(signal_compute_en_score(1.0, 0.0, 1.0, 0.0), 0.0, 0.0);
    assert_true(isinf(signal_compute_en_score(1.0, 0.0, 2.0, 0.0)));
    assert_true(isnan(signal_compute_en_score((double)NAN, 0.1, 2.0, 0.1)) &&
                isnan(signal_compute_en_score(1.0, 0.1, 2.0, (double)NAN)));
}
