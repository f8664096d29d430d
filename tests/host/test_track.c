/* The gear's track against truth: seeded landings whose motion is a closed form, and such whose
 * brake ripples besides. How often does the stated 95 % interval of the station hold? frame numbers
 * against films that lack pulses. */
#include <stdio.h>
#include <string.h>

#include "host/analyse/track.h"
#include "tests/common/seeded_landing.h"
#include "tests/cmocka_all.h"

#define LANDINGS  500u
#define MOMENTS   20u /* of each landing */
#define SPREAD_IN (0.02 * 0.57735)

/* Displacement by a ripple of the deceleration that begins with it: its second integral from
 * touchdown on. */
static double ripple_deviation_ft(double amplitude_ft_s2, double hz, double turn, double since_s)
{
    double w = 6.283185307179586 * hz, phase = 6.283185307179586 * turn;
    if (since_s <= 0.0 || amplitude_ft_s2 == 0.0)
        return 0.0;
    /* integral twice of sin(w t + phase) */
    return -amplitude_ft_s2 *
           ((sin(phase) - sin(w * since_s + phase)) / (w * w) + since_s * cos(phase) / w);
}

struct case_ {
    struct seeded_landing landing;
    double ripple_ft_s2, hz, turn;
};

static double truth_ft(const struct case_ *c, double t_s)
{
    return seeded_station(&c->landing, t_s) +
           ripple_deviation_ft(c->ripple_ft_s2, c->hz, c->turn, t_s - SEEDED_TOUCHDOWN_S);
}

static double crossing_s(const struct case_ *c, double station_ft)
{
    double low = 0.0, high = c->landing.stop_s - 0.05;
    if (truth_ft(c, high) < station_ft)
        return (double)NAN;
    for (int i = 0; i < 80; i++) {
        double middle = 0.5 * (low + high);
        if (truth_ft(c, middle) < station_ft)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* As measured_load leaves it. */
static bool measure(const struct case_ *c, struct measured_landing *m)
{
    memset(m, 0, sizeof *m);
    m->landing.touchdown_ft = SEEDED_TOUCHDOWN_FT;
    m->landing.switch_error_ft = SPREAD_IN / 12.0;
    for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
        double t_s = isnan(c->landing.open_s[i]) ? (double)NAN
                                                 : crossing_s(c, c->landing.placed_ft[i]);
        if (!isnan(t_s))
            m->gate[m->gate_count++] = (struct mr_gate){t_s, -2.5 + 5.0 * i};
    }
    for (int turn = 0; turn < 2; turn++) { /* the second time with touchdown as the origin */
        m->fit_status = mr_gates_summarise(m->gate, m->gate_count, SEEDED_TOUCHDOWN_FT,
                                           m->landing.switch_error_ft, &m->summary);
        if (m->fit_status != MR_OK)
            return false;
        double shift_s = turn ? 0.0 : m->summary.touchdown_t_s.value;
        for (size_t i = 0; i < m->gate_count; i++)
            m->gate[i].t_s -= shift_s;
        m->t0_us += (int64_t)llround(shift_s * 1e9); /* nanoseconds here */
    }
    m->is_t0_touchdown = true;
    return true;
}

static double difference(double (*of)(const struct case_ *, double), const struct case_ *c,
                         double t_s, double h_s)
{
    return (of(c, t_s + h_s) - of(c, t_s - h_s)) / (2.0 * h_s);
}
static double truth_speed_ft_s(const struct case_ *c, double t_s)
{
    return difference(truth_ft, c, t_s, 1e-4);
}

struct held {
    unsigned inside, seen;
    double error, true_error;
};
static void see(struct held *held, struct mr_estimate said, double truth)
{
    if (isnan(said.value))
        return;
    held->seen++;
    held->inside += fabs(said.value - truth) <= 1.959964 * said.error;
    held->error += said.error;
    held->true_error += fabs(said.value - truth);
}
static void tell(const char *name, const char *what, const struct held *held, double least,
                 double most)
{
    printf("# %-12s %-12s %.2f %% of %u inside, mean error stated %.5f, true %.5f\n", name, what,
           100.0 * held->inside / held->seen, held->seen, held->error / held->seen,
           held->true_error / held->seen);
    assert_true(held->inside >= least * held->seen);
    assert_true(held->inside <= most * held->seen);
}

/* Share of moments at which the 95 % interval holds: of the station, from `least` to `most`; of
 * speed and deceleration, at least so much (the deceleration is without ripple). The limits of the
 * speed were set afterwards. */
static void check(const char *name, double most_ripple, double least_hz, double least, double most,
                  double least_speed, double least_deceleration)
{
    struct held station = {0}, speed = {0}, early = {0}, residual = {0}, late = {0},
                deceleration = {0};
    unsigned landings = 0;
    for (uint64_t seed = 1; landings < LANDINGS; seed++) {
        struct case_ c = {0};
        struct measured_landing m;
        static struct track track;
        uint64_t state = seed * 77777u;
        seeded_draw(&c.landing, seed, SPREAD_IN);
        c.ripple_ft_s2 = most_ripple * seeded_uniform(&state) * c.landing.deceleration_ft_s2;
        c.hz = least_hz * (1.0 + 4.0 * seeded_uniform(&state));
        c.turn = seeded_uniform(&state);
        if (!measure(&c, &m) || m.gate_count < 8)
            continue;
        landings++;
        track_make(&m, &track);
        assert_true(track.has_gates);
        double first_s = (double)m.t0_us * 1e-9, last_s = m.gate[m.gate_count - 1].t_s + first_s;
        for (size_t i = 1; i + 1 < track.gate_count; i++)
            see(&residual, track_compute_residual_ft(&track, i), 0.0);
        for (unsigned i = 0; i < MOMENTS; i++) {
            double late_s = last_s + (c.landing.stop_s - last_s) * seeded_uniform(&state);
            see(&late, track_compute_speed(&track, late_s - first_s), truth_speed_ft_s(&c, late_s));
            double t_s = SEEDED_TOUCHDOWN_S + 0.05 +
                         (last_s - SEEDED_TOUCHDOWN_S - 0.05) * seeded_uniform(&state);
            see(&station, track_compute_station(&track, t_s - first_s), truth_ft(&c, t_s));
            assert_near(track_station_ft(&track, t_s - first_s),
                        track_compute_station(&track, t_s - first_s).value, 1e-9);
            see(t_s - first_s < track.first_gate.t_s ? &early : &speed,
                track_compute_speed(&track, t_s - first_s), truth_speed_ft_s(&c, t_s));
            see(&deceleration, track_compute_deceleration(&track, t_s - first_s),
                -difference(truth_speed_ft_s, &c, t_s, 1e-3));
        }
    }
    /* beyond the last gate; what changes there is not seen */
    tell(name, "late speed", &late, most_ripple > 0.05 ? 0.0 : 0.9, 1.0);
    tell(name, "residual", &residual, 0.92, 1.0);
    tell(name, "station", &station, least, most);
    tell(name, "early speed", &early, 0.92, 1.0); /* while the brake rises */
    tell(name, "speed", &speed, least_speed, 1.0);
    tell(name, "deceleration", &deceleration, least_deceleration, 1.0);
}

TEST(motion_is_within_its_intervals)
{
    /* wider than need be: that it is so even is not taken for granted */
    check("even braking", 0.0, 0.5, 0.935, 1.0, 0.935, 0.935);
    check("1 % ripple", 0.01, 0.5, 0.935, 0.965, 0.935, 0.0); /* as in tests/runs */
    check("10 % ripple", 0.1, 0.5, 0.92, 0.965, 0.89, 0.0);
    check("slow change", 0.3, 0.05, 0.92, 0.97, 0.92, 0.92); /* of braking, 0.05 to 0.25 Hz */
}

TEST(frames_are_numbered_by_the_gaps_in_time)
{
    static double t_us[2000];
    static int64_t number[2000], truth[2000];
    uint64_t random = 3;
    for (unsigned round = 0; round < 200; round++) {
        double now_us = 5e7 * seeded_uniform(&random), hz = 64.0 + 136.0 * seeded_uniform(&random);
        size_t count = 0;
        for (int64_t frame = 1; frame <= 900; frame++) {
            double drift = 1.0 + 0.1 * (double)frame / 900.0; /* the camera runs up by a tenth */
            now_us += 1e6 / (hz * drift);
            bool given = seeded_uniform(&random) > 0.03 && (frame < 300 || frame > 303);
            if (!given && count)
                continue;
            truth[count] = frame;
            t_us[count++] = now_us + 600.0 * (seeded_uniform(&random) - 0.5);
        }
        film_compute_frame_numbers(t_us, count, number);
        for (size_t i = 0; i < count; i++)
            assert_int_equal(number[i], truth[i] - truth[0] + 1);
    }
    film_compute_frame_numbers(t_us, 0, number);
    film_compute_frame_numbers(t_us, 1, number);
    assert_int_equal(number[0], 1);
}
