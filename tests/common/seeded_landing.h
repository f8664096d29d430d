/* Landings drawn from a seed, with their truth: a gear that comes in at constant speed and is
 * braked evenly after a brake that takes time to rise. Crossing times from closed forms and
 * bisection; shares no code with what is tested. */
#ifndef MATRIG_TESTS_COMMON_SEEDED_LANDING_H
#define MATRIG_TESTS_COMMON_SEEDED_LANDING_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "common/splitmix.h"

#define SEEDED_SWITCHES     24
#define SEEDED_TOUCHDOWN_FT 3.0
#define SEEDED_TOUCHDOWN_S  1.0

struct seeded_landing {
    double speed_ft_s, deceleration_ft_s2; /* of the brake when it has risen */
    double rise_s;
    bool straight;                      /* the brake rises as a straight line, else as a quintic */
    double stop_s, stop_ft, mean_ft_s2; /* times on the clock of the touchdown */
    double placed_ft[SEEDED_SWITCHES];  /* where the switches really are */
    double open_s[SEEDED_SWITCHES];     /* NaN: missing, or not reached */
    unsigned bounces[SEEDED_SWITCHES];  /* further openings */
    double bounce_s[SEEDED_SWITCHES];   /* between them */
};

/* SplitMix64 */
static inline double seeded_uniform(uint64_t *state)
{
    return ((double)(mr_splitmix64(state) >> 11) + 0.5) / 9007199254740992.0;
}

static inline double seeded_normal(uint64_t *state)
{
    double radius = sqrt(-2.0 * log(seeded_uniform(state)));
    return radius * cos(6.283185307179586 * seeded_uniform(state));
}

static inline double seeded_station(const struct seeded_landing *landing, double t_s)
{
    double since_s = t_s - SEEDED_TOUCHDOWN_S, tau = landing->rise_s;
    double a = landing->deceleration_ft_s2;
    if (since_s <= 0.0)
        return SEEDED_TOUCHDOWN_FT + landing->speed_ft_s * since_s;
    double u = since_s < tau ? since_s / tau : 1.0;
    double lost = landing->straight ? u * u * u / 6.0
                                    : pow(u, 5) / 2.0 - pow(u, 6) / 2.0 + pow(u, 7) / 7.0;
    double x = SEEDED_TOUCHDOWN_FT + landing->speed_ft_s * since_s - a * tau * tau * lost;
    double beyond_s = since_s - tau;
    if (beyond_s > 0.0)
        x -= 0.5 * a * tau * beyond_s + 0.5 * a * beyond_s * beyond_s;
    return x;
}

static inline double seeded_crossing(const struct seeded_landing *landing, double station_ft)
{
    double low = 0.0, high = landing->stop_s;
    if (station_ft > landing->stop_ft)
        return (double)NAN;
    for (int i = 0; i < 200; i++) {
        double middle = 0.5 * (low + high);
        if (seeded_station(landing, middle) < station_ft)
            low = middle;
        else
            high = middle;
    }
    return high;
}

static inline void seeded_roll(struct seeded_landing *landing)
{
    landing->stop_s = SEEDED_TOUCHDOWN_S + 0.5 * landing->rise_s +
                      landing->speed_ft_s / landing->deceleration_ft_s2;
    landing->stop_ft = seeded_station(landing, landing->stop_s);
    landing->mean_ft_s2 = landing->speed_ft_s / (landing->stop_s - SEEDED_TOUCHDOWN_S);
}

/* 20 to 46 ft/s, 4 to 32 ft/s2; half the rise is 25 ms with a standard deviation of 12 ms; switches
 * every 5 ft from -2.5 ft on with a standard error of `place_in`; each is missing with a
 * probability of up to 0.2, one in ten bounces. */
static inline void seeded_draw(struct seeded_landing *landing, uint64_t seed, double place_in)
{
    uint64_t state = seed * 1000003u + 1973u;
    landing->speed_ft_s = 20.0 + 26.0 * seeded_uniform(&state);
    landing->deceleration_ft_s2 = 4.0 + 28.0 * seeded_uniform(&state);
    do
        landing->rise_s = 2.0 * (0.025 + 0.012 * seeded_normal(&state));
    while (landing->rise_s < 0.002);
    landing->straight = seeded_uniform(&state) < 0.5;
    seeded_roll(landing);
    double missing = 0.2 * seeded_uniform(&state);
    for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
        landing->placed_ft[i] = -2.5 + 5.0 * i + place_in / 12.0 * seeded_normal(&state);
        landing->open_s[i] = seeded_crossing(landing, landing->placed_ft[i]);
        if (seeded_uniform(&state) < missing)
            landing->open_s[i] = (double)NAN;
        landing->bounces[i] = seeded_uniform(&state) < 0.1
                                ? 1 + (unsigned)(3.0 * seeded_uniform(&state))
                                : 0;
        landing->bounce_s[i] = 100e-6 + 1.9e-3 * seeded_uniform(&state);
    }
}

#endif
