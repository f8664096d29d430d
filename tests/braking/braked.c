/* braked: one landing with the edge of its brake and the pulses of a wheel, drawn from a number;
 * for tests/cli/braking.sh. The mats do not move.
 *
 *   braked SEED RUNFILE     also prints the truth, a value a word:
 *                           onset_s slip locked_s locks deceleration_ft_s2 thrust_lb first_lock_s
 *
 * The gear rolls at a constant speed to the edge of the brake; its deceleration then rises to that
 * drawn within 30 ms, and by a quarter more while the wheel is locked. The wheel slips by a
 * constant share, and locks up to three times, each within 0 to 60 ms, the last time in some
 * landings until the stop. Radius, switches and the places of the pulses around the wheel deviate
 * as stated. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/runs/runfile.h"

#define STEP_S       2e-5
#define ARMED_S      0.8
#define START_S      1.2 /* the gear is at START_FT */
#define START_FT     (-4.0)
#define TOUCHDOWN_FT 3.0
#define PULSES       8 /* as tests/variant/wheel.h */
#define RADIUS_FT    0.292
#define RADIUS_ERROR 0.0015
#define SWITCH_ERROR 0.00096
#define AXLE_LB      (1300.0 / 12.0)
#define G_FT_S2      32.174
#define LOCKS        3

static struct syn_run run;
static uint64_t state;

static double uniform(double low, double high)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    uint64_t x = (state ^ state >> 29) * 0xbf58476d1ce4e5b9u;
    return low + (high - low) * (double)((x ^ x >> 32) >> 11) * 0x1p-53;
}

static double normal(double error)
{
    return error * sqrt(-2.0 * log(1.0 - uniform(0.0, 1.0))) * cos(2.0 * M_PI * uniform(0.0, 1.0));
}

struct lock {
    double from_s, to_s, slows_s, regains_s;
};

struct landing {
    double speed_ft_s, onset_s, deceleration_ft_s2, slip, share;
    double radius_ft, phase, place[PULSES]; /* of a pulse around the wheel, in pulses */
    int locks;
    struct lock lock[LOCKS];
    /* results */
    double touchdown_s, stop_s, stop_ft, rolled_ft, edge_ft, edge_speed_ft_s;
    double open_s[24], at_ft[24];
    double pulse_s[4000];
    int pulses;
};

static void draw(struct landing *l)
{
    l->speed_ft_s = uniform(26.0, 40.0);
    l->touchdown_s = START_S + (TOUCHDOWN_FT - START_FT) / l->speed_ft_s;
    l->onset_s = uniform(0.0, 1.0) < 0.8 ? uniform(0.0, 0.05) : uniform(0.05, 0.4);
    l->deceleration_ft_s2 = uniform(l->speed_ft_s * l->speed_ft_s / 170.0, 14.0);
    l->slip = uniform(0.02, 0.2);
    l->share = uniform(0.7, 1.3);
    l->radius_ft = RADIUS_FT + normal(RADIUS_ERROR);
    l->phase = uniform(0.0, 1.0);
    for (int i = 0; i < PULSES; i++)
        l->place[i] = uniform(-0.01, 0.01);
    for (int i = 0; i < 24; i++)
        l->at_ft[i] = -2.5 + 5.0 * i + normal(SWITCH_ERROR);
    double stop_s = l->speed_ft_s / l->deceleration_ft_s2, from_s = l->onset_s + 0.2;
    int wanted = (int)uniform(0.0, LOCKS + 0.999);
    while (l->locks < wanted) {
        struct lock *lock = &l->lock[l->locks];
        lock->from_s = from_s + uniform(0.1, 0.5);
        lock->to_s = lock->from_s + uniform(0.2, 0.6);
        lock->slows_s = uniform(0.0, 1.0) < 0.3 ? 0.0 : uniform(0.0, 0.06);
        lock->regains_s = uniform(0.0, 0.06);
        if (lock->to_s > 0.55 * stop_s)
            break;
        l->locks++;
        from_s = lock->to_s + 0.25;
        if (l->locks == wanted && uniform(0.0, 1.0) < 0.3)
            lock->to_s = (double)INFINITY;
    }
}

/* Share of its free speed that the wheel has, besides slip. */
static double turning(const struct landing *l, double t_s)
{
    double share = 1.0;
    for (int i = 0; i < l->locks; i++) {
        const struct lock *k = &l->lock[i];
        double slows = t_s >= k->from_s ? 0.0
                     : k->slows_s > 0.0 ? (k->from_s - t_s) / k->slows_s
                                        : 1.0;
        double regains = t_s <= k->to_s     ? 0.0
                       : k->regains_s > 0.0 ? (t_s - k->to_s) / k->regains_s
                                            : 1.0;
        share = fmin(share, fmax(slows, regains));
    }
    return share;
}

static double deceleration(const struct landing *l, double t_s)
{
    double rise = fmin(fmax((t_s - l->onset_s) / 0.03, 0.0), 1.0);
    return l->deceleration_ft_s2 * rise * (turning(l, t_s) > 0.0 ? 1.0 : 1.25);
}

/* Times since touchdown inside, of the run outside. */
static void roll(struct landing *l)
{
    double x = START_FT, v = l->speed_ft_s, turned = l->phase, rolled = 0.0;
    double per_pulse_ft = 2.0 * M_PI * l->radius_ft / PULSES;
    int next = 0, pulse = 1;
    for (int i = 0; i < 24; i++)
        l->open_s[i] = -1.0;
    for (double t = START_S - l->touchdown_s; v > 0.0; t += STEP_S) {
        double a = deceleration(l, t + 0.5 * STEP_S),
               slip_rise = fmin(fmax((t - l->onset_s) / 0.05, 0.0), 1.0);
        double dx = v * STEP_S - 0.5 * a * STEP_S * STEP_S;
        double dr = dx * (1.0 - l->slip * slip_rise) * turning(l, t + 0.5 * STEP_S);
        if (t < l->onset_s) {
            l->edge_ft = x + v * (l->onset_s - t);
            l->edge_speed_ft_s = v;
            rolled = -dr * (l->onset_s - t) / STEP_S;
        }
        for (; next < 24 && x + dx >= l->at_ft[next]; next++)
            l->open_s[next] = t + STEP_S * (l->at_ft[next] - x) / dx;
        for (double at; at = pulse + l->place[pulse % PULSES], turned + dr / per_pulse_ft >= at;
             pulse++)
            l->pulse_s[l->pulses++] = t + STEP_S * (at - turned) * per_pulse_ft / dr;
        x += dx;
        rolled += dr;
        turned += dr / per_pulse_ft;
        v -= a * STEP_S;
        l->stop_s = t;
    }
    l->stop_ft = x;
    l->rolled_ft = rolled;
}

static bool write_run(const struct landing *l, unsigned long seed, const char *path)
{
    static const long nothing[SYN_SAMPLE_CHANNELS] = {[8] = 10000, 10000, 10000, 10000, 10000,
                                                      10000,       10000, 6000,  6000,  6000,
                                                      6000,        6000,  6000,  6000};
    double zero_s = l->touchdown_s;
    syn_run_clear(&run);
    syn_run_add(&run, "matrig-run 1\nprovenance synthetic: braked landing of seed %lu\n", seed);
    syn_run_add(&run, "duration_s %.3f\n", zero_s + l->stop_s + 3.5);
    for (int i = 0; i < 24; i++) {
        syn_run_add(&run, "switch %d %.1f %.6f ", i + 1, -2.5 + 5.0 * i, l->at_ft[i]);
        if (l->open_s[i] > -1.0)
            syn_run_add(&run, "%.9f\n", zero_s + l->open_s[i]);
        else
            syn_run_add(&run, "-\n");
    }
    syn_run_add(&run, "brake %.9f\n", zero_s + l->onset_s);
    for (int i = 0; i < l->pulses; i++)
        syn_run_add(&run, "wheel %.9f\n", zero_s + l->pulse_s[i]);
    syn_run_add(&run, "command %.3f can arm 1\n", ARMED_S);
    syn_run_add(&run, "samples 1 1000\n");
    syn_run_sample(&run, nothing);
    return syn_run_write(&run, path);
}

int main(int argc, char **argv)
{
    static struct landing l;
    if (argc != 3) {
        fprintf(stderr, "usage: braked SEED RUNFILE\n");
        return 2;
    }
    unsigned long seed = strtoul(argv[1], NULL, 10);
    state = seed * 0x9e3779b97f4a7c15u + 1u;
    draw(&l);
    roll(&l);
    double locked_s = 0.0, mean_ft_s2 = l.edge_speed_ft_s / (l.stop_s - l.onset_s);
    for (int i = 0; i < l.locks; i++)
        locked_s += fmin(l.lock[i].to_s, l.stop_s) - l.lock[i].from_s;
    if (!write_run(&l, seed, argv[2])) {
        perror(argv[2]);
        return 3;
    }
    printf("%.9f %.9f %.9f %d %.9f %.9f %.9f\n", l.onset_s,
           1.0 - l.rolled_ft / (l.stop_ft - l.edge_ft), locked_s, l.locks, mean_ft_s2,
           l.share * AXLE_LB * mean_ft_s2 / G_FT_S2, l.locks ? l.lock[0].from_s : -1.0);
    return 0;
}
