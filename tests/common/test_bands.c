/* Bands: the figures of appendix C's closed form, each finding on its own signature, silence on
 * landings without damage, and how many of the damaged ones are recognised. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/bands.h"
#include "common/channels.h"
#include "tests/common/band_chain.h"
#include "tests/cmocka_all.h"

#define STEP_MS 4

static struct mr_channel_config gage[MR_GAGES];
static struct mr_band_config band[MR_CONFIG_BANDS];
static struct mr_bands bands;
static struct mr_band_finding found[64];
static unsigned finds;

static void keep(unsigned count)
{
    for (unsigned i = 0; i < count && finds < 64; i++)
        found[finds++] = bands.finding[i];
}

/* A rig: `count` gages of band 1 at these stations. */
static void set_up(const double *station_ft, unsigned count, float pretension_lb)
{
    memset(gage, 0, sizeof gage);
    memset(band, 0, sizeof band);
    for (unsigned i = 0; i < count; i++)
        gage[i] = (struct mr_channel_config){.kind = MR_KIND_TENSION,
                                             .number = (uint8_t)(i + 1),
                                             .band = 1,
                                             .station_ft = (float)station_ft[i],
                                             .unit_per_code = 1.0f,
                                             .zero_error = 0.5f,
                                             .gain_error = 0.01f};
    band[0].pretension_lb = pretension_lb;
    finds = 0;
    mr_bands_arm(&bands, gage, band);
}

static void play(const double *lb, unsigned count, unsigned steps, bool quiet, double wheel_ft)
{
    static uint32_t block;
    float tension_lb[MR_GAGES];
    for (unsigned i = 0; i < MR_GAGES; i++)
        tension_lb[i] = i < count ? (float)lb[i] : NAN;
    for (unsigned s = 0; s < steps; s++) {
        block += STEP_MS;
        keep(mr_bands_update(&bands, tension_lb, quiet, (float)wheel_ft, block));
    }
}

static unsigned findings_of(unsigned reason)
{
    unsigned count = 0;
    for (unsigned i = 0; i < finds; i++)
        count += found[i].reason == reason;
    return count;
}

/* C.6 and C.7 by hand: KL/AE = 1, a = 1/4, R = 60: dT_n = -60 * 1.25 / 3 = -25, dT_(n-1) = 60 *
 * 1.75 / 3 = 35. */
TEST(figures_are_those_of_appendix_c)
{
    static const double station_ft[] = {20.0, 80.0};
    static const double at_rest[] = {100.0, 100.0}, pushed[] = {135.0, 75.0},
                        left[] = {103.0, 99.0};
    struct mr_band_summary figures;
    set_up(station_ft, 2, 100.0f);
    play(at_rest, 2, 150, true, (double)NAN);
    for (int s = 1; s <= 50; s++) /* over 200 ms, as the gear comes */
        play((const double[]){100.0 + 0.7 * s, 100.0 - 0.5 * s}, 2, 1, false, 30.0);
    play(pushed, 2, 100, false, 30.0);
    for (int s = 1; s <= 50; s++)
        play((const double[]){135.0 - 0.64 * s, 75.0 + 0.48 * s}, 2, 1, false, 60.0);
    play(left, 2, 200, false, 60.0);
    mr_bands_end(&bands);
    mr_bands_get_summary(&bands, 0, &figures);
    assert_int_equal(finds, 0);
    assert_int_equal(figures.gage_count, 2);
    assert_near(figures.before_lb, 100.0, 1e-4);
    assert_near(figures.spread_lb, 0.0, 1e-4);
    assert_near(figures.min.tension_lb, 75.0, 1e-4);
    assert_int_equal(figures.min.gage, 2);
    assert_near(figures.max.tension_lb, 135.0, 1e-4);
    assert_int_equal(figures.max.gage, 1);
    assert_near(figures.after_lb, 101.0, 1e-4);
    assert_near(figures.change_lb, 1.0, 1e-4);
    /* zero 0.5 lb, gain 1 %: of the mean of two sqrt(2 (0.25 + 1)) / 2; of the change only the
     * gain's, 1 % of +3 and of -1 */
    assert_near(figures.before_error_lb, 0.790569, 1e-4);
    assert_near(figures.change_error_lb, 0.0158114, 1e-4);
    assert_near(figures.min_error_lb, sqrt(0.25 + 0.75 * 0.75), 1e-4);
    assert_near(figures.max_error_lb, sqrt(0.25 + 1.35 * 1.35), 1e-4);
    mr_bands_get_summary(&bands, 1, &figures);
    assert_int_equal(figures.gage_count, 0);
    assert_true(isnan(figures.before_lb) && isnan(figures.min.tension_lb) &&
                isnan(figures.change_lb));
}

/* The rivet of the closed form lets go: dT_n and dT_(n-1) end at once, and the lengths still add
 * up: the sum of C.5 stays. */
TEST(a_rivet_that_lets_go_is_a_pullout)
{
    static const double station_ft[] = {20.0, 80.0};
    set_up(station_ft, 2, 100.0f);
    play((const double[]){100.0, 100.0}, 2, 150, true, (double)NAN);
    for (int s = 1; s <= 50; s++)
        play((const double[]){100.0 + 0.7 * s, 100.0 - 0.5 * s}, 2, 1, false, 30.0);
    play((const double[]){100.0, 100.0}, 2, 300, false, 30.0);
    mr_bands_end(&bands);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_PULLOUT);
    assert_int_equal(found[0].gage, 1);
    assert_int_equal(found[0].other_gage, 2);
    assert_int_equal(found[0].band, 1);
    assert_near(found[0].value_lb, 60.0, 3.0); /* R; the gear's own ramp is taken off */
}

/* The middle gage drops by 24 lb, the others less; `ms` later all gain. */
static void slip(unsigned ms, double recovered_lb)
{
    static const double station_ft[] = {20.0, 50.0, 80.0};
    set_up(station_ft, 3, 100.0f);
    play((const double[]){100.0, 100.0, 100.0}, 3, 150, true, (double)NAN);
    play((const double[]){100.0, 98.0, 99.0}, 3, 20, false, 10.0);
    play((const double[]){90.0, 74.0, 94.0}, 3, ms / STEP_MS, false, 10.0);
    if (ms < 100)
        play((const double[]){90.0 + recovered_lb, 74.0 + recovered_lb, 94.0 + recovered_lb}, 3, 1,
             false, 30.0);
    for (int k = 1; k <= 100; k++) /* as the gear brings it */
        play((const double[]){90.0 + recovered_lb * k / 100, 74.0 + recovered_lb * k / 100,
                              94.0 + recovered_lb * k / 100},
             3, ms < 100 ? 0 : 1, false, 40.0);
    play((const double[]){90.0 + recovered_lb, 74.0 + recovered_lb, 94.0 + recovered_lb}, 3, 100,
         false, 40.0);
    mr_bands_end(&bands);
}

TEST(a_drop_that_stays_is_a_slip)
{
    slip(400, 20.0);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_SLIP);
    assert_int_equal(found[0].gage, 2);
    /* it dropped more than gage 3: the connection is on its side */
    assert_int_equal(found[0].other_gage, 1);
    assert_near(found[0].value_lb, 24.0, 0.5);
}

TEST(a_drop_that_comes_back_is_none)
{
    slip(32, 12.0);
    assert_int_equal(finds, 0);
}

TEST(a_drop_at_one_gage_is_a_step_and_a_rise_a_load_that_moved_on)
{
    static const double station_ft[] = {20.0, 50.0, 80.0};
    set_up(station_ft, 3, 100.0f);
    play((const double[]){100.0, 100.0, 100.0}, 3, 150, true, (double)NAN);
    play((const double[]){99.0, 88.0, 100.0}, 3, 100, true, (double)NAN);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_STEP);
    assert_int_equal(found[0].gage, 2);
    assert_near(found[0].value_lb, -12.0, 1e-3);
    /* no band gains tension by growing longer */
    play((const double[]){100.0, 98.0, 101.0}, 3, 100, true, (double)NAN);
    assert_int_equal(finds, 2);
    assert_int_equal(found[1].reason, MR_BAND_PULLOUT);
    assert_int_equal(found[1].gage, 2);
    assert_int_equal(found[1].other_gage, 0);
}

TEST(slack_needs_a_wheel_behind_and_more_than_a_moment)
{
    static const double station_ft[] = {20.0, 80.0};
    set_up(station_ft, 2, 100.0f);
    play((const double[]){100.0, 100.0}, 2, 150, true, (double)NAN);
    for (int s = 1; s <= 91; s++)
        play((const double[]){100.0 + s, 100.0 - s}, 2, 1, false, 30.0);
    play((const double[]){191.0, 9.0}, 2, 1, false, 30.0); /* the second step below a tenth: 8 ms */
    play((const double[]){190.0, 11.0}, 2, 1, false, 30.0);
    assert_int_equal(finds, 0);
    play((const double[]){190.0, 9.5}, 2, 3, false, 30.0);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_SLACK);
    assert_int_equal(found[0].gage, 2);
    assert_near(found[0].value_lb, 9.5, 1e-3);
    for (int s = 1; s <= 181; s++)
        play((const double[]){190.0 - s, 9.5}, 2, 1, false, 30.0);
    play((const double[]){9.0, 9.5}, 2, 3, false, 30.0); /* behind the wheel */
    assert_int_equal(finds, 2);
    assert_int_equal(found[1].reason, MR_BAND_LOOSE);
    assert_int_equal(found[1].gage, 1);
}

TEST(unequal_tension_at_rest_is_named)
{
    static const double station_ft[] = {20.0, 50.0, 80.0};
    set_up(station_ft, 3, 100.0f);
    /* 20 % of 100 and three errors of 0.5 lb and 1 % each: a little over 24 lb is allowed */
    play((const double[]){88.0, 100.0, 112.0}, 3, 200, true, (double)NAN);
    assert_int_equal(finds, 0);
    set_up(station_ft, 3, 100.0f);
    play((const double[]){112.0, 102.0, 86.0}, 3, 200, true, (double)NAN);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_UNEQUAL);
    assert_int_equal(found[0].gage, 3);
    assert_int_equal(found[0].other_gage, 1);
    assert_near(found[0].value_lb, 26.0, 1e-3);
}

TEST(overload_is_told_once)
{
    static const double station_ft[] = {20.0};
    set_up(station_ft, 1, 100.0f);
    band[0].yield_lb = 300.0f;
    mr_bands_arm(&bands, gage, band);
    for (int s = 0; s <= 205; s++)
        play((const double[]){100.0 + s}, 1, 1, false, 30.0);
    assert_int_equal(findings_of(MR_BAND_OVERLOAD), 1);
    assert_near(found[0].value_lb, 300.0, 1e-3);
}

TEST(a_gage_without_a_reading_takes_no_part)
{
    static const double station_ft[] = {20.0, 50.0, 80.0};
    struct mr_band_summary figures;
    set_up(station_ft, 3, 100.0f);
    play((const double[]){100.0, (double)NAN, 104.0}, 3, 150, true, (double)NAN);
    play((const double[]){101.0, (double)NAN, 103.0}, 3, 150, false, 50.0);
    mr_bands_end(&bands);
    mr_bands_get_summary(&bands, 0, &figures);
    assert_int_equal(finds, 0);
    assert_int_equal(figures.gage_count, 2);
    assert_near(figures.before_lb, 102.0, 1e-4);
    assert_near(figures.max.tension_lb, 103.0, 1e-4);
}

TEST(a_band_that_is_not_configured_is_not_watched)
{
    static const double station_ft[] = {20.0, 80.0};
    set_up(station_ft, 2, 0.0f);
    play((const double[]){0.0, 0.0}, 2, 200, false, 10.0);
    assert_false(bands.is_active);
    assert_int_equal(finds, 0);
}

/* ---- the landings of tests/runs ---- */

/* What the bands see of a landing of tests/runs; 2 MB: on the heap. */
struct run {
    double first_edge_s, gage_ft[MR_GAGES];
    int band[MR_GAGES], samples;
    long row[16000][MR_TRANSDUCERS + MR_GAGES];
};

/* Rows as they stand; "xN" repeats the last one so often. */
static void load_rows(struct run *run, FILE *file, int count)
{
    char line[512];
    while (run->samples < count && fgets(line, sizeof line, file)) {
        char *at = line;
        int times = line[0] == 'x' ? atoi(line + 1) : 0;
        for (unsigned c = 0; !times && c < MR_TRANSDUCERS + MR_GAGES; c++)
            run->row[run->samples][c] = strtol(at, &at, 10);
        for (int n = 0; n < times; n++)
            memcpy(run->row[run->samples + n], run->row[run->samples - 1], sizeof run->row[0]);
        run->samples += times ? times : 1;
    }
}

static struct run *load(int number)
{
    char line[512];
    int i, n, count;
    double at_ft, open_s;
    struct run *run = calloc(1, sizeof *run);
    snprintf(line, sizeof line, "tests/runs/landing%d.run", number);
    FILE *file = fopen(line, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "switch %d %*f %*f %lf", &i, &open_s) == 2) {
            run->first_edge_s = i == 1 ? open_s : run->first_edge_s;
        } else if (sscanf(line, "gage %d %lf %d", &i, &at_ft, &n) == 3) {
            run->gage_ft[i - 1] = at_ft;
            run->band[i - 1] = n;
        } else if (sscanf(line, "samples %d", &count) == 1) {
            load_rows(run, file, count);
        }
    }
    fclose(file);
    assert_true(run->samples > 4000 && run->first_edge_s > 0.0);
    return run;
}

TEST(the_recorded_landings_raise_nothing)
{
    static const int landings[] = {1, 4, 5};
    for (unsigned l = 0; l < 3; l++) {
        struct run *run = load(landings[l]);
        double least = 1e9;
        struct mr_band_summary figures;
        memset(gage, 0, sizeof gage);
        memset(band, 0, sizeof band);
        finds = 0;
        for (unsigned i = 0; i < MR_GAGES; i++)
            gage[i] = (struct mr_channel_config){.kind = MR_KIND_TENSION,
                                                 .number = (uint8_t)(i + 1),
                                                 .band = (uint8_t)run->band[i],
                                                 .station_ft = (float)run->gage_ft[i]};
        band[0].pretension_lb = band[1].pretension_lb = 100.0f;
        mr_bands_arm(&bands, gage, band);
        for (int k = 0; k + 4 <= run->samples; k += 4) {
            float tension_lb[MR_GAGES];
            bool quiet = (double)k * 1e-3 < run->first_edge_s;
            for (unsigned i = 0; i < MR_GAGES; i++) {
                double sum = 0.0;
                for (int s = k; s < k + 4; s++)
                    sum += (double)run->row[s][MR_TRANSDUCERS + i] * 0.01;
                tension_lb[i] = (float)(sum / 4.0);
                if (!quiet && run->band[i] == 1)
                    least = fmin(least, sum / 4.0);
            }
            keep(mr_bands_update(&bands, tension_lb, quiet, quiet ? NAN : 0.0f, (uint32_t)k + 3u));
        }
        mr_bands_end(&bands);
        mr_bands_get_summary(&bands, 0, &figures);
        printf("# landing %d: band 1 %.1f lb before, least %.1f at gage %u, most %.1f at gage %u, "
               "after %.1f\n",
               landings[l], (double)figures.before_lb, (double)figures.min.tension_lb,
               figures.min.gage, (double)figures.max.tension_lb, figures.max.gage,
               (double)figures.after_lb);
        assert_int_equal(finds, 0);
        assert_near(figures.min.tension_lb, least, 1e-3);
        free(run);
    }
}

/* ---- landings of the chain ---- */

enum damage { NONE, SPLICE, END, RIVET, DAMAGES };

struct trial {
    struct chain chain;
    uint64_t seed;
    enum damage damage;
    double at_s, share; /* when, and of the rivets or segments which */
    int place;
    double visible_lb;           /* what the damage changed in the segments of the gages, most */
    double load_lb;              /* of the rivet */
    int gage_behind, gage_ahead; /* around the place, from 1; 0: none */
    double least_lb;             /* truth, ahead of the wheel */
};

static const double chain_gage_ft[] = {15.0, 30.0, 45.0, 55.0, 65.0, 75.0, 85.0};

static void draw(struct trial *t, uint64_t seed, enum damage damage)
{
    memset(t, 0, sizeof *t);
    t->seed = 1000u * seed + 7u;
    t->damage = damage;
    uint64_t *s = &t->seed;
    /* every 10th or 20th row of 2/7 ft */
    t->chain.spacing_ft = chain_uniform(s, 0.0, 1.0) < 0.5 ? 20.0 / 7.0 : 40.0 / 7.0;
    t->chain.rivets = (int)(CHAIN_LENGTH_FT / t->chain.spacing_ft - 0.01);
    t->chain.spring_lb_in = chain_uniform(s, 50.0, 400.0);
    /* some of the first go slack */
    t->chain.pretension_lb = chain_uniform(s, damage == NONE ? 50.0 : 100.0, 150.0);
    for (int j = 0; j <= t->chain.rivets; j++)
        t->chain.tight_lb[j] = 3.0 * chain_normal(s);
    t->chain.friction_lb = chain_uniform(s, 0.5, 4.0);
    t->chain.hold_lb_in = chain_uniform(s, 200.0, 2000.0);
    t->at_s = chain_uniform(s, 0.9, 3.5);
    t->share = chain_uniform(s, 0.0, 1.0);
}

static void damage_now(struct trial *t, double wheel_ft, double force_lb, double slip_in)
{
    struct chain *c = &t->chain;
    double before[7];
    for (int g = 0; g < 7; g++)
        before[g] = chain_at(c, chain_gage_ft[g]);
    if (t->damage == END)
        t->place = t->share < 0.5 ? 0 : c->rivets;
    else if (t->damage == SPLICE)
        t->place = (int)(t->share * (c->rivets + 1)) % (c->rivets + 1);
    else /* of those that the gear loads now, the most loaded between two gages */
        for (int j = 0; j < c->rivets; j++) {
            bool between = chain_rivet_ft(c, j) > chain_gage_ft[0] &&
                           chain_rivet_ft(c, j) < chain_gage_ft[6];
            if (between && fabs(c->push_lb[j]) > t->load_lb) {
                t->load_lb = fabs(c->push_lb[j]);
                t->place = j;
            }
        }
    double place_ft = t->damage == RIVET ? chain_rivet_ft(c, t->place)
                                         : (t->place + 0.5) * c->spacing_ft;
    for (int g = 0; g < 7; g++) {
        if (chain_gage_ft[g] <= place_ft)
            t->gage_behind = g + 1;
        else if (!t->gage_ahead)
            t->gage_ahead = g + 1;
    }
    if (t->damage == RIVET)
        c->out[t->place] = true;
    else
        c->slip_in[t->place] = slip_in;
    struct chain copy = *c;
    chain_settle(&copy, wheel_ft, force_lb);
    for (int g = 0; g < 7; g++)
        t->visible_lb = fmax(t->visible_lb, fabs(chain_at(&copy, chain_gage_ft[g]) - before[g]));
}

/* Arms, rests 0.7 s, lands at 3 ft with 28 to 40 ft/s, brakes at 5 to 11 ft/s2, stops, rests 1
 * s. */
static void land(struct trial *t)
{
    struct chain *c = &t->chain;
    uint64_t *s = &t->seed;
    double a = chain_uniform(s, 5.0, 11.0),
           v = fmin(chain_uniform(s, 28.0, 40.0), sqrt(2.0 * a * 105.0));
    /* R of C.1, four bands */
    double weight_lb = chain_uniform(s, 1220.0, 1500.0), force_lb = weight_lb * a / 32.174 / 4.0;
    double slip_in = chain_uniform(s, 0.1, 0.4), onset_s = chain_uniform(s, 0.05, 0.15);
    double stop_s = 0.7 + v / a;
    bool damaged = false;
    set_up(chain_gage_ft, 7, (float)c->pretension_lb);
    t->least_lb = 1e9;
    for (double t_s = 0.0; t_s < stop_s + 1.0; t_s += 0.004) {
        double sum[7] = {0.0}, lb[7], wheel_ft = (double)NAN;
        for (int half = 0; half < 2; half++) {
            double now_s = t_s + 0.002 * half, since = fmin(now_s, stop_s) - 0.7;
            double ramp = fmin(1.0, fmax(0.0, since / onset_s)) *
                          fmin(1.0, fmax(0.0, 1.0 - (now_s - stop_s) / 0.1));
            wheel_ft = 3.0 + (v - 0.5 * a * fmax(0.0, since)) * since;
            if (!damaged && t->damage != NONE && now_s >= t->at_s) {
                damaged = true;
                damage_now(t, wheel_ft, ramp * force_lb, slip_in);
            }
            chain_settle(c, wheel_ft, ramp * force_lb);
            for (int g = 0; g < 7; g++) {
                sum[g] += chain_at(c, chain_gage_ft[g]);
                if (chain_gage_ft[g] > wheel_ft)
                    t->least_lb = fmin(t->least_lb, chain_at(c, chain_gage_ft[g]));
            }
        }
        for (int g = 0; g < 7; g++) /* 2 codes rms each, 32 of them; and some mains hum */
            lb[g] = 0.5 * sum[g] + 0.057 * chain_normal(s) + 0.1 * sin(6.2832 * 60.0 * t_s + g);
        play(lb, 7, 1, t_s < 0.55, t_s < 0.55 ? (double)NAN : wheel_ft);
    }
    mr_bands_end(&bands);
}

TEST(landings_without_damage_raise_nothing)
{
    enum { LANDINGS = 300 };
    unsigned false_alarms = 0, slack_true = 0, slack_told = 0, slack_wrong = 0;
    for (unsigned seed = 1; seed <= LANDINGS; seed++) {
        struct trial t;
        draw(&t, seed, NONE);
        land(&t);
        unsigned slack = findings_of(MR_BAND_SLACK);
        for (unsigned i = 0; i < finds; i++) {
            if (found[i].reason != MR_BAND_SLACK)
                printf("# seed %u: %s, gage %u, %.1f lb, block %u\n", seed,
                       mr_band_reason_text(found[i].reason), found[i].gage,
                       (double)found[i].value_lb, (unsigned)found[i].block);
        }
        false_alarms += finds - slack;
        slack_true += t.least_lb < 0.9 * 0.10 * t.chain.pretension_lb;
        slack_told += slack > 0;
        slack_wrong += slack && t.least_lb > 1.1 * 0.10 * t.chain.pretension_lb;
    }
    printf("# %d landings without damage: %u false alarms; slack in %u by the chain, told in %u, "
           "wrongly in %u\n",
           LANDINGS, false_alarms, slack_true, slack_told, slack_wrong);
    assert_int_equal(false_alarms, 0);
    assert_int_equal(slack_wrong, 0);
    assert_true(slack_told >= slack_true);
}

/* Counts how the damage was named, where it changed a gage by 10 lb; what changed less is counted
 * apart. */
static void recognise(enum damage damage, const char *name, double *rate, double *noticed)
{
    enum { LANDINGS = 120 };
    unsigned visible = 0, right = 0, beside = 0, step = 0, wrong = 0, silent = 0, weak = 0,
             weak_named = 0;
    unsigned name_right = damage == RIVET ? MR_BAND_PULLOUT : MR_BAND_SLIP,
             name_wrong = damage == RIVET ? MR_BAND_SLIP : MR_BAND_PULLOUT;
    for (unsigned seed = 1; seed <= LANDINGS; seed++) {
        struct trial t;
        draw(&t, seed, damage);
        land(&t);
        const struct mr_band_finding *first = NULL;
        for (unsigned i = 0; i < finds && !first; i++)
            first = found[i].reason != MR_BAND_SLACK && found[i].reason != MR_BAND_LOOSE ? &found[i]
                                                                                         : NULL;
        if (t.visible_lb < 10.0) {
            weak++;
            weak_named += first != NULL;
            continue;
        }
        visible++;
        silent += !first;
        right += first && first->reason == name_right;
        step += first && first->reason == MR_BAND_STEP;
        wrong += first && first->reason == name_wrong;
        beside += first && (first->gage == t.gage_behind || first->gage == t.gage_ahead);
    }
    *rate = (double)right / visible;
    *noticed = 1.0 - (double)silent / visible;
    printf("# %s, changing a gage by 10 lb or more: of %u, %u named right (%.0f %%), %u only a "
           "step, %u wrong, %u not noticed; gage "
           "beside it in %u. Of %u weaker ones %u noticed\n",
           name, visible, right, 100.0 * *rate, step, wrong, silent, beside, weak, weak_named);
}

TEST(damage_is_recognised)
{
    double rate, noticed;
    recognise(SPLICE, "splice slips", &rate, &noticed);
    assert_true(rate > 0.85 && noticed > 0.95);
    recognise(END, "end connection slips", &rate, &noticed);
    assert_true(rate > 0.85 && noticed > 0.95);
    recognise(RIVET, "rivet pulls out", &rate, &noticed);
    assert_true(rate > 0.5 && noticed > 0.9);
}

/* A rig's table need not go along the runway, and a gage may have no station: the neighbours are
 * those by station. */
TEST(neighbours_are_those_by_station)
{
    static const double station_ft[] = {85.0, 20.0, (double)NAN, 50.0, 5.0};
    set_up(station_ft, 5, 100.0f);
    play((const double[]){100.0, 100.0, 100.0, 100.0, 100.0}, 5, 150, true, (double)NAN);
    for (int s = 1; s <= 50; s++)
        play((const double[]){100.0, 100.0 + 0.7 * s, 100.0, 100.0 - 0.5 * s, 100.0}, 5, 1, false,
             30.0);
    play((const double[]){100.0, 100.0, 100.0, 100.0, 100.0}, 5, 300, false, 30.0);
    mr_bands_end(&bands);
    assert_int_equal(finds, 1);
    assert_int_equal(found[0].reason, MR_BAND_PULLOUT);
    assert_int_equal(found[0].gage, 2);
    assert_int_equal(found[0].other_gage, 4);
    assert_near(found[0].value_lb, 60.0, 3.0);
}

/* The slip of slip() with a gage before the others that has no reading, then one behind them. */
TEST(a_slip_is_seen_beside_a_gage_without_a_reading)
{
    static const double station_ft[2][4] = {{20.0, 50.0, 80.0, 10.0}, {20.0, 50.0, 80.0, 95.0}};
    for (unsigned n = 0; n < 2; n++) {
        set_up(station_ft[n], 4, 100.0f);
        play((const double[]){100.0, 100.0, 100.0, (double)NAN}, 4, 150, true, (double)NAN);
        play((const double[]){100.0, 98.0, 99.0, (double)NAN}, 4, 20, false, 5.0);
        play((const double[]){90.0, 74.0, 94.0, (double)NAN}, 4, 100, false, 5.0);
        mr_bands_end(&bands);
        assert_int_equal(finds, 1);
        assert_int_equal(found[0].reason, MR_BAND_SLIP);
        assert_int_equal(found[0].gage, 2);
        assert_near(found[0].value_lb, 24.0, 0.5);
    }
}

/* 14 gages overloaded and four bands unequal in one step are 18 findings; 16 are told, the
 * overloads first. */
TEST(no_more_than_16_findings_come_of_one_step)
{
    float tension_lb[MR_GAGES];
    double station_ft[MR_GAGES];
    unsigned count = 0;
    for (unsigned i = 0; i < MR_GAGES; i++)
        station_ft[i] = 5.0 * i;
    set_up(station_ft, MR_GAGES, 100.0f);
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++)
        band[b] = (struct mr_band_config){.pretension_lb = 100.0f, .yield_lb = 300.0f};
    for (unsigned i = 0; i < MR_GAGES; i++)
        gage[i].band = (uint8_t)(1 + i % MR_CONFIG_BANDS);
    mr_bands_arm(&bands, gage, band);
    for (unsigned step = 1; step <= MR_BANDS_GROUP_STEPS; step++) {
        for (unsigned i = 0; i < MR_GAGES; i++)
            tension_lb[i] = step == MR_BANDS_GROUP_STEPS ? 310.0f
                          : i < MR_CONFIG_BANDS          ? 50.0f
                                                         : 150.0f;
        count = mr_bands_update(&bands, tension_lb, true, NAN, 4 * step);
        assert_int_equal(count, step == MR_BANDS_GROUP_STEPS ? MR_BANDS_FINDINGS_MAX : 0);
    }
    for (unsigned n = 0; n < count; n++)
        assert_int_equal(bands.finding[n].reason,
                         n < MR_GAGES ? MR_BAND_OVERLOAD : MR_BAND_UNEQUAL);
}

/* Zeros that have drifted below nothing: a band without tension has no pretension of which 10 %
 * would be slack. */
TEST(a_band_below_zero_is_not_slack_of_nothing)
{
    static const double station_ft[] = {20.0, 80.0};
    struct mr_band_summary figures;
    set_up(station_ft, 2, 5.0f);
    play((const double[]){-0.2, -0.4}, 2, MR_BANDS_GROUP_STEPS, true, (double)NAN);
    unsigned before = findings_of(MR_BAND_LOOSE) + findings_of(MR_BAND_SLACK);
    assert_int_equal(before, 2); /* of the 5 lb that were to be there, 0.5 */
    finds = 0;
    play((const double[]){0.3, 0.1}, 2, 100, false, 30.0);
    play((const double[]){4.3, 4.1}, 2, 100, false, 30.0); /* less than 5 lb is no sudden change */
    mr_bands_end(&bands);
    mr_bands_get_summary(&bands, 0, &figures);
    assert_int_equal(finds, 0);
    assert_near(figures.before_lb, -0.3, 1e-5);
}

TEST(what_a_band_has_now)
{
    static const double station_ft[] = {20.0, 50.0, 80.0, 95.0};
    float least, mean, most, tension_lb[MR_GAGES] = {90.0f, 120.0f, NAN, 700.0f, 800.0f};
    set_up(station_ft, 4, 100.0f);
    gage[3].band = 2;
    assert_int_equal(mr_bands_find_extremes(gage, tension_lb, 0, &least, &mean, &most), 2);
    assert_near(least, 90.0, 0.0);
    assert_near(mean, 105.0, 1e-5);
    assert_near(most, 120.0, 0.0);
    assert_int_equal(mr_bands_find_extremes(gage, tension_lb, 3, &least, &mean, &most), 0);
    assert_true(isnan(least) && isnan(mean) && isnan(most));
}

TEST(every_reason_has_its_own_text)
{
    for (unsigned a = MR_BAND_SLACK; a <= MR_BAND_STEP; a++) {
        assert_string_not_equal(mr_band_reason_text(a), "unknown");
        for (unsigned b = MR_BAND_SLACK; b < a; b++)
            assert_string_not_equal(mr_band_reason_text(a), mr_band_reason_text(b));
    }
    assert_string_equal(mr_band_reason_text(0), "unknown");
}
