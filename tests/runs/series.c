/* The standard series; see series.h. */
#include "tests/runs/series.h"

#include <math.h>
#include <string.h>

#define IN_PER_FT 12.0

/* Runway and gear, model scale. */
/* designed joint slack; what is drawn beyond SYN_SLACK_FT lies hooked, at it */
#define GAP_MAX_IN      0.036
#define GRIT_MAX_LB     20.0
#define GEAR_WEIGHT_LB  1300.0
/* of the gear's inertia force, on the lead axle over the strip */
#define LEAD_AXLE_SHARE (1.0 / 12.0)
#define TYRE_PATCH_FT   (1.1 / 12.0) /* 0.05 in deflection under a wheel of about 3 in radius */
#define TOUCHDOWN_FT    3.0
#define TOUCHDOWN_S     1.62
#define AFTER_STOP_MS   3000
#define FREEZE_FT_S     1e-6 /* slower everywhere than this for FREEZE_MS: at rest */
#define FREEZE_MS       50
#define REACH_IN        0.005

/* Rig. */
#define SWITCH_ERROR_FT         (0.02 / 12.0)
#define SURVEY_READING_ERROR_IN 0.005
#define WITNESS_ARM_FT          5.0
#define WITNESS_LB_IN           60.0
#define WITNESS_LAG_S           0.010

static const double brake_speed_ft_s[SYN_LANDINGS] = {28.0, 28.0, 28.0, 28.0, 35.5, 35.5, 35.5};
static const double brake_first_ft_s2[SYN_LANDINGS] = {4.0, 4.0, 4.3, 4.6, 6.6, 6.5, 8.5};
static const double brake_last_ft_s2[SYN_LANDINGS] = {4.0, 4.0, 4.3, 4.6, 9.2, 6.5, 8.5};
static const double brake_bend_from_s[SYN_LANDINGS] = {0.0, 0.0, 0.0, 0.0, 1.2, 0.0, 0.0};
static const double brake_bend_to_s[SYN_LANDINGS] = {0.0, 0.0, 0.0, 0.0, 3.6, 0.0, 0.0};
static const double ripple[SYN_RIPPLES] = {0.007, 0.005, 0.004};
static const double ripple_hz[SYN_RIPPLES] = {0.83, 2.3, 5.1};

enum stream {
    STREAM_GAP = 1,
    STREAM_GRIT,
    STREAM_SWITCH,
    STREAM_TENSION,
    STREAM_RIPPLE = 100,
    STREAM_SURVEY = 200
};

/* Random numbers: a counter run through a 64-bit mixing function (multiply, xor-shift), one counter
 * per stream. */
struct draw {
    uint64_t key;
    uint64_t counter;
};

static uint64_t mixed(uint64_t x)
{
    x ^= x >> 32;
    x *= 0xD6E8FEB86659FD93u;
    x ^= x >> 32;
    x *= 0xD6E8FEB86659FD93u;
    return x ^ (x >> 32);
}

static struct draw draw_from(uint64_t seed, int stream)
{
    struct draw draw = {mixed(mixed(seed + 0x9E3779B97F4A7C15u) + (uint64_t)stream), 0};

    return draw;
}

static double draw_uniform(struct draw *draw) /* 0 to below 1 */
{
    uint64_t bits = mixed(draw->key + 0x9E3779B97F4A7C15u * ++draw->counter);

    return (double)(bits >> 11) * 0x1p-53;
}

/* Sum of twelve uniform numbers: standard deviation 1, never beyond 6, and no logarithm. */
static double draw_normal(struct draw *draw)
{
    double sum = -6.0;

    for (int i = 0; i < 12; i++)
        sum += draw_uniform(draw);
    return sum;
}

static void build_rig(struct syn_rig *rig, uint64_t seed)
{
    static const double gage_ft[SYN_GAGES / 2] = {15.0, 30.0, 45.0, 55.0, 65.0, 75.0, 85.0};
    static const double band_lb[2] = {100.0, 60.0};
    struct draw placing = draw_from(seed, STREAM_SWITCH);
    struct draw tension = draw_from(seed, STREAM_TENSION);

    for (int i = 0; i < SYN_SWITCHES; i++) {
        rig->switch_nominal_ft[i] = -2.5 + 5.0 * i; /* the first on the approach track */
        rig->switch_true_ft[i] = rig->switch_nominal_ft[i] +
                                 SWITCH_ERROR_FT * (2.0 * draw_uniform(&placing) - 1.0);
    }
    for (int i = 0; i < SYN_TRANSDUCERS; i++)
        rig->transducer_ft[i] = 40.0 + 10.0 * i;
    for (int i = 0; i < SYN_GAGES; i++) {
        int band = i / (SYN_GAGES / 2);

        rig->gage_ft[i] = gage_ft[i % (SYN_GAGES / 2)];
        rig->gage_band[i] = band + 1;
        rig->pretension_lb[i] = band_lb[band] + 2.0 * draw_normal(&tension);
    }
}

void syn_series_start(struct syn_series *series, uint64_t seed, int steps_per_ms)
{
    struct draw gap = draw_from(seed, STREAM_GAP);
    struct draw grit = draw_from(seed, STREAM_GRIT);

    memset(series, 0, sizeof *series);
    series->seed = seed;
    series->steps_per_ms = steps_per_ms;
    build_rig(&series->rig, seed);
    for (int j = 1; j <= SYN_JOINTS; j++) {
        series->chain.gap_ft[j] = fmin(GAP_MAX_IN * draw_uniform(&gap) / IN_PER_FT, SYN_SLACK_FT);
        series->chain.grit_lb[j] = GRIT_MAX_LB * draw_uniform(&grit);
    }
    syn_chain_mark(&series->chain);
}

static void set_gear(struct syn_gear *gear, uint64_t seed, int number)
{
    struct draw draw = draw_from(seed, STREAM_RIPPLE + number);

    memset(gear, 0, sizeof *gear);
    gear->touchdown_ft = TOUCHDOWN_FT;
    gear->touchdown_s = TOUCHDOWN_S;
    gear->speed_ft_s = brake_speed_ft_s[number - 1];
    gear->first_ft_s2 = brake_first_ft_s2[number - 1];
    gear->last_ft_s2 = brake_last_ft_s2[number - 1];
    gear->bend_from_s = brake_bend_from_s[number - 1];
    gear->bend_to_s = brake_bend_to_s[number - 1];
    for (int i = 0; i < SYN_RIPPLES; i++) {
        gear->ripple[i] = ripple[i];
        gear->ripple_hz[i] = ripple_hz[i];
        gear->ripple_turn[i] = draw_uniform(&draw);
    }
}

static void read_survey(struct syn_landing *landing, uint64_t seed)
{
    struct draw draw = draw_from(seed, STREAM_SURVEY + landing->number);

    for (int s = 0; s < SYN_SEGMENTS; s++) {
        double sum = SURVEY_READING_ERROR_IN * draw_normal(&draw);

        for (int j = 0; j < SYN_JOINTS_PER_SEGMENT; j++)
            sum += landing->gap_in[SYN_JOINTS_PER_SEGMENT * s + j];
        landing->survey_in[s] = sum > 0.0 ? floor(1000.0 * sum + 0.5) / 1000.0 : 0.0;
    }
}

/* Witness bands: tension each gage would show, before its lag, from the stretch of the mat around
 * it. */
static void witness(const struct syn_rig *rig, const double *u_ft, double *tension_lb)
{
    for (int i = 0; i < SYN_GAGES; i++) {
        double ahead = u_ft[syn_chain_mat_at(rig->gage_ft[i] + WITNESS_ARM_FT)];
        double behind = u_ft[syn_chain_mat_at(rig->gage_ft[i] - WITNESS_ARM_FT)];

        tension_lb[i] = fmax(0.0,
                             rig->pretension_lb[i] + WITNESS_LB_IN * IN_PER_FT * (ahead - behind));
    }
}

/* Watches every mat over a landing. */
struct watch {
    double reach_ft[SYN_MATS + 1]; /* < 0: not moved */
    double peak_ft;
    int peak_mat;
};

static void look(struct watch *watch, const double *u_ft, double wheel_ft)
{
    for (int n = 1; n <= SYN_MATS; n++) {
        double mat_ft = (n - 0.5) * SYN_MAT_FT;

        if (fabs(u_ft[n]) > watch->peak_ft) {
            watch->peak_ft = fabs(u_ft[n]);
            watch->peak_mat = n;
        }
        if (watch->reach_ft[n] < 0.0 && u_ft[n] * IN_PER_FT >= REACH_IN && mat_ft > TOUCHDOWN_FT)
            watch->reach_ft[n] = fmax(0.0, mat_ft - wheel_ft);
    }
}

static void conclude(struct syn_landing *landing, struct watch *watch, const double *u_ft)
{
    int count = 0;

    landing->peak_any_in = watch->peak_ft * IN_PER_FT;
    landing->peak_any_ft = (watch->peak_mat - 0.5) * SYN_MAT_FT;
    landing->final_any_in = 0.0;
    for (int n = 1; n <= SYN_MATS; n++) {
        double reach = watch->reach_ft[n];
        int k = count;

        landing->final_any_in = fmax(landing->final_any_in, fabs(u_ft[n]) * IN_PER_FT);
        if (reach < 0.0)
            continue;
        for (; k > 0 && watch->reach_ft[k - 1] > reach;
             k--) /* sorted in place: entry k is behind n already */
            watch->reach_ft[k] = watch->reach_ft[k - 1];
        watch->reach_ft[k] = reach;
        count++;
    }
    landing->reach_median_ft = count > 0 ? watch->reach_ft[count / 2] : 0.0;
    landing->reach_max_ft = count > 0 ? watch->reach_ft[count - 1] : 0.0;
}

static void take_gaps(const struct syn_chain *chain, double *gap_in)
{
    for (int j = 1; j <= SYN_JOINTS; j++)
        gap_in[j - 1] = chain->gap_ft[j] * IN_PER_FT;
}

/* The closed zone ahead of the wheel, once a millisecond while it rolls. */
static void look_ahead(struct syn_landing *landing, const struct syn_chain *chain, double t_s,
                       double wheel_ft)
{
    struct syn_zone zone;

    syn_chain_zone(chain, SYN_CLOSED_IN / IN_PER_FT, wheel_ft, &zone);
    if (zone.mats >= SYN_FULL_MATS && zone.start_ft - wheel_ft < SYN_AT_ZONE_FT &&
        landing->at_zone_s < 0.0)
        landing->at_zone_s = t_s;
    if (zone.mats > landing->ahead_longest_mats)
        landing->ahead_longest_mats = zone.mats;
    if (zone.mats >= SYN_ZONE_AHEAD_MATS && landing->ahead_first_s < 0.0) {
        landing->ahead_first = zone;
        landing->ahead_first_s = t_s;
        landing->ahead_first_wheel_ft = wheel_ft;
    }
}

/* One step of the chain under the gear at the middle of the step. */
static bool advance(struct syn_chain *chain, const struct syn_gear *gear, double middle_s,
                    double step_s)
{
    struct syn_gear_motion motion = syn_gear_at(gear, middle_s);
    struct syn_thrust thrust = {GEAR_WEIGHT_LB * LEAD_AXLE_SHARE * motion.a_ft_s2 /
                                    SYN_GRAVITY_FT_S2,
                                motion.x_ft, TYRE_PATCH_FT};

    return syn_chain_step(chain, &thrust, step_s);
}

/* Clears what is gathered over a landing and takes down its start. false: the gear does not stop in
 * time. */
static bool begin(struct syn_series *series, int number, struct syn_landing *landing,
                  struct watch *watch)
{
    landing->number = number;
    set_gear(&landing->gear, series->seed, number);
    if (!syn_gear_brake(&landing->gear))
        return false;
    landing->duration_ms = (int)ceil(landing->gear.stop_s * 1000.0) + AFTER_STOP_MS;
    landing->samples = landing->duration_ms + 1;
    if (landing->samples > SYN_SAMPLES_MAX)
        return false;
    syn_chain_mark(&series->chain);
    take_gaps(&series->chain, landing->gap_in);
    read_survey(landing, series->seed);
    syn_chain_zone(&series->chain, SYN_CLOSED_IN / IN_PER_FT, 0.0, &landing->zone_start);
    memset(&landing->ahead_first, 0, sizeof landing->ahead_first);
    landing->ahead_first_s = -1.0;
    landing->ahead_first_wheel_ft = 0.0;
    landing->ahead_longest_mats = 0;
    landing->at_zone_s = -1.0;
    for (int n = 0; n <= SYN_MATS; n++)
        watch->reach_ft[n] = -1.0;
    watch->peak_ft = 0.0;
    watch->peak_mat = 1;
    return true;
}

/* The witness bands' gages: what they show, and what they showed before the lag at the last
 * step. */
struct gages {
    double tension_lb[SYN_GAGES];
    double raw_lb[SYN_GAGES];
};

/* First-order lag by the trapezoidal rule. */
static void follow(struct gages *gages, const struct syn_rig *rig, const double *u_ft,
                   double step_s)
{
    double old_share = (2.0 * WITNESS_LAG_S - step_s) / (2.0 * WITNESS_LAG_S + step_s);
    double new_share = step_s / (2.0 * WITNESS_LAG_S + step_s);
    double raw_lb[SYN_GAGES];

    witness(rig, u_ft, raw_lb);
    for (int i = 0; i < SYN_GAGES; i++)
        gages->tension_lb[i] = old_share * gages->tension_lb[i] +
                               new_share * (gages->raw_lb[i] + raw_lb[i]);
    memcpy(gages->raw_lb, raw_lb, sizeof raw_lb);
}

/* A millisecond from t_s on; u_ft is brought up to date. */
static bool run_millisecond(struct syn_series *series, const struct syn_gear *gear, double t_s,
                            bool at_rest, double *u_ft, struct gages *gages)
{
    double step_s = 0.001 / series->steps_per_ms;

    for (int k = 0; k < series->steps_per_ms; k++) {
        if (!at_rest && !advance(&series->chain, gear, t_s + (k + 0.5) * step_s, step_s))
            return false;
        syn_chain_displacement(&series->chain, u_ft);
        follow(gages, &series->rig, u_ft, step_s);
    }
    return true;
}

bool syn_series_land(struct syn_series *series, int number, struct syn_landing *landing)
{
    static struct watch watch;
    struct syn_chain *chain = &series->chain;
    struct gages gages;
    double u_ft[SYN_MATS + 2];
    int still_ms = 0;

    if (number == SYN_AGAINST)
        series->before_against = *chain;
    if (number > SYN_AGAINST)
        *chain = series->before_against;
    if (!begin(series, number, landing, &watch))
        return false;
    syn_chain_displacement(chain, u_ft);
    witness(&series->rig, u_ft, gages.raw_lb);
    memcpy(gages.tension_lb, gages.raw_lb, sizeof gages.raw_lb);
    for (int ms = 0; ms < landing->samples; ms++) {
        double t_s = ms / 1000.0;
        double next_s = (ms + 1) / 1000.0;
        double wheel_ft = syn_gear_at(&landing->gear, next_s).x_ft;
        bool at_rest = next_s < TOUCHDOWN_S - 0.001 || still_ms >= FREEZE_MS;

        for (int i = 0; i < SYN_TRANSDUCERS; i++) {
            int mat = syn_chain_mat_at(series->rig.transducer_ft[i]);

            landing->displacement_in[ms][i] = u_ft[mat] * IN_PER_FT;
        }
        memcpy(landing->tension_lb[ms], gages.tension_lb, sizeof gages.tension_lb);
        if (!run_millisecond(series, &landing->gear, t_s, at_rest, u_ft, &gages))
            return false;
        if (!at_rest)
            look(&watch, u_ft, wheel_ft);
        if (next_s >= TOUCHDOWN_S && next_s <= landing->gear.stop_s)
            look_ahead(landing, chain, next_s, wheel_ft);
        if (t_s > landing->gear.stop_s)
            still_ms = syn_chain_fastest(chain) < FREEZE_FT_S ? still_ms + 1 : 0;
    }
    if (still_ms < FREEZE_MS)
        return false;
    conclude(landing, &watch, u_ft);
    take_gaps(chain, landing->gap_end_in);
    syn_chain_zone(chain, SYN_CLOSED_IN / IN_PER_FT, 0.0, &landing->zone_end);
    landing->iterations_per_step = (double)chain->iterations / (double)chain->steps;
    landing->hard_steps = chain->hard_steps;
    landing->thrust_impulse_lb_s = chain->thrust_impulse_lb_s;
    landing->balance_lb_s = chain->thrust_impulse_lb_s - chain->friction_impulse_lb_s -
                            chain->end_impulse_lb_s;
    return true;
}
