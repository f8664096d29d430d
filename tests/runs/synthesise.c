/* synthesise: makes the committed landings of this folder anew, and those between them. See
 * README.md.
 *
 *   synthesise OUTPUT_DIR [SEED [STEPS_PER_MS [LANDINGS]]]
 *                                                 landing1.run to landing7.run, or the first
 *                                                 of them; a table on stdout
 *   synthesise --check [SEED [STEPS_PER_MS]]      writes no file: each landing again with half the
 *                                                 step, and how far apart
 *   synthesise --mats LANDING [SEED]              every mat and joint at the end of a landing, for
 *                                                 plotting
 *
 * Exit: 0; 1 a check failed; 2 usage; 3 a file could not be written; 5 the numerics failed. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/runs/runfile.h"
#include "tests/runs/series.h"

#define SEED         67u
#define STEPS_PER_MS 40
#define PATH_BYTES   4096
#define BALANCE_LB_S 1e-3 /* what equations solved to 2e-5 lb may leave over 10 s; 1e-7 is usual */
#define CONVERGED_IN 0.02 /* between a step and its half; see README.md */

static struct syn_series series;
static struct syn_landing landing;
static struct syn_run run;

static void add_zone(const char *when, const struct syn_zone *zone)
{
    syn_run_add(&run, "truth zone_at_%s_mats %d\n", when, zone->mats);
    syn_run_add(&run, "truth zone_at_%s_start_station_ft %.6f\n", when, zone->start_ft);
    syn_run_add(&run, "truth zone_at_%s_end_station_ft %.6f\n", when, zone->end_ft);
    syn_run_add(&run, "truth closed_joints_at_%s %d\n", when, zone->closed_joints);
}

static void add_truth(void)
{
    const struct syn_gear *gear = &landing.gear;
    double wheel_at_zone_s = -1.0;
    bool found = landing.ahead_first_s >= 0.0;

    if (landing.zone_start.mats > 0 && landing.zone_start.start_ft > gear->touchdown_ft)
        (void)syn_gear_crosses(gear, landing.zone_start.start_ft, &wheel_at_zone_s);
    syn_run_add(&run, "truth touchdown_speed_ft_s %.9f\n", gear->speed_ft_s);
    syn_run_add(&run, "truth mean_deceleration_ft_s2 %.9f\n",
                gear->speed_ft_s / (gear->stop_s - gear->touchdown_s));
    syn_run_add(&run, "truth stop_station_ft %.9f\n", gear->stop_ft);
    syn_run_add(&run, "truth stop_t_s %.9f\n", gear->stop_s);
    for (int i = 0; i < SYN_TRANSDUCERS; i++) {
        double peak = 0.0;

        for (int k = 0; k < landing.samples; k++)
            peak = fmax(peak, fabs(landing.displacement_in[k][i]));
        syn_run_add(&run, "truth peak_displacement_in_%d %.5f\n", i + 1, peak);
    }
    for (int i = 0; i < SYN_GAGES; i++) {
        double change = 0.0;

        for (int k = 0; k < landing.samples; k++)
            change = fmax(change, fabs(landing.tension_lb[k][i] - landing.tension_lb[0][i]));
        syn_run_add(&run, "truth peak_tension_change_lb_%d %.2f\n", i + 1, change);
    }
    syn_run_add(&run, "truth peak_any_mat_in %.5f\n", landing.peak_any_in);
    syn_run_add(&run, "truth peak_any_mat_station_ft %.6f\n", landing.peak_any_ft);
    syn_run_add(&run, "truth reach_median_ft %.3f\n", landing.reach_median_ft);
    syn_run_add(&run, "truth reach_max_ft %.3f\n", landing.reach_max_ft);
    syn_run_add(&run, "truth thrust_impulse_lb_s %.6f\n", landing.thrust_impulse_lb_s);
    add_zone("start", &landing.zone_start);
    add_zone("end", &landing.zone_end);
    syn_run_add(&run,
                "# first zone of %d closed mats or more ahead of the rolling wheel; all -1: none\n",
                SYN_ZONE_AHEAD_MATS);
    syn_run_add(&run, "truth zone_ahead_first_t_s %.3f\n", landing.ahead_first_s);
    syn_run_add(&run, "truth zone_ahead_first_wheel_ft %.6f\n",
                found ? landing.ahead_first_wheel_ft : -1.0);
    syn_run_add(&run, "truth zone_ahead_first_start_station_ft %.6f\n",
                found ? landing.ahead_first.start_ft : -1.0);
    syn_run_add(&run, "truth zone_ahead_first_end_station_ft %.6f\n",
                found ? landing.ahead_first.end_ft : -1.0);
    syn_run_add(&run, "truth zone_ahead_longest_mats %d\n", landing.ahead_longest_mats);
    syn_run_add(&run, "# when the wheel reaches the start of the zone it finds; -1: it does not, "
                      "or there is none ahead\n");
    syn_run_add(&run, "truth wheel_at_zone_at_start_t_s %.9f\n", wheel_at_zone_s);
    if (landing.number > SYN_AGAINST) /* the first five keep their bytes */
        syn_run_add(&run, "truth wheel_at_50_mats_t_s %.3f\n", landing.at_zone_s);
}

static void add_places(void)
{
    const struct syn_rig *rig = &series.rig;

    for (int i = 0; i < SYN_SWITCHES; i++) {
        double t_s;

        syn_run_add(&run, "switch %d %.1f %.6f ", i + 1, rig->switch_nominal_ft[i],
                    rig->switch_true_ft[i]);
        if (syn_gear_crosses(&landing.gear, rig->switch_true_ft[i], &t_s))
            syn_run_add(&run, "%.9f\n", t_s);
        else
            syn_run_add(&run, "-\n");
    }
    for (int i = 0; i < SYN_TRANSDUCERS; i++)
        syn_run_add(&run, "transducer %d %.1f\n", i + 1, rig->transducer_ft[i]);
    for (int i = 0; i < SYN_GAGES; i++)
        syn_run_add(&run, "gage %d %.1f %d\n", i + 1, rig->gage_ft[i], rig->gage_band[i]);
}

static void add_commands(void)
{
    for (int s = 0; s < SYN_SEGMENTS; s++)
        syn_run_add(&run, "command %.3f serial survey %d %.3f\n", 0.300 + 0.002 * s, s,
                    landing.survey_in[s]);
    syn_run_add(&run, "command 0.800 can arm %d\n", landing.number);
    syn_run_add(&run, "command %.3f serial mark 1\n", landing.gear.stop_s + 1.0);
    syn_run_add(&run, "command %.3f can disarm\n", landing.duration_ms / 1000.0 - 0.3);
}

static void add_samples(void)
{
    syn_run_add(&run, "samples %d %d\n", landing.samples, SYN_RATE_HZ);
    for (int k = 0; k < landing.samples; k++) {
        long row[SYN_SAMPLE_CHANNELS];

        for (int i = 0; i < SYN_TRANSDUCERS; i++)
            row[i] = lround(landing.displacement_in[k][i] * 1e5);
        for (int i = 0; i < SYN_GAGES; i++)
            row[SYN_TRANSDUCERS + i] = lround(landing.tension_lb[k][i] * 100.0);
        syn_run_sample(&run, row);
    }
}

static const char *braked_otherwise(void)
{
    return landing.number == SYN_AGAINST + 1 ? " (landing 5 braked as advised)"
         : landing.number > SYN_AGAINST      ? " (landing 5 braked evenly and hard)"
                                             : "";
}

static bool write_landing(const char *folder)
{
    char path[PATH_BYTES];

    if (snprintf(path, sizeof path, "%s/landing%d.run", folder, landing.number) >=
        (int)sizeof path) {
        errno = ENAMETOOLONG;
        return false;
    }
    syn_run_clear(&run);
    syn_run_add(&run, "matrig-run 1\n");
    syn_run_add(
        &run,
        "# made by tests/runs/synthesise.c; tests/runs/README.md says from what. Do not edit: "
        "make it again.\n");
    syn_run_add(&run,
                "provenance synthetic: simulated landing %d of the standard series%s, seed %" PRIu64
                ", step %.3g s; not a measurement; the bands are witnesses that hold nothing\n",
                landing.number, braked_otherwise(), series.seed, 0.001 / series.steps_per_ms);
    syn_run_add(&run, "landing %d\n", landing.number);
    syn_run_add(&run, "duration_s %.3f\n", landing.duration_ms / 1000.0);
    syn_run_add(&run, "touchdown %.6f %.9f\n", landing.gear.touchdown_ft, landing.gear.touchdown_s);
    add_truth();
    add_places();
    syn_run_numbers(&run, "gap_in", landing.gap_in, SYN_JOINTS);
    syn_run_numbers(&run, "gap_end_in", landing.gap_end_in, SYN_JOINTS);
    add_commands();
    add_samples();
    return syn_run_write(&run, path);
}

/* Land, and refuse a landing whose momentum does not balance. */
static bool land(int number)
{
    if (!syn_series_land(&series, number, &landing)) {
        fprintf(stderr,
                "synthesise: landing %d: the numerics failed, or nothing came to rest; try a "
                "smaller step\n",
                number);
        return false;
    }
    if (!(fabs(landing.balance_lb_s) <= BALANCE_LB_S)) {
        fprintf(stderr,
                "synthesise: landing %d: momentum is off by %g lb s (limit %g): a defect of the "
                "integrator\n",
                number, landing.balance_lb_s, BALANCE_LB_S);
        return false;
    }
    return true;
}

static void print_row(void)
{
    printf("%7d %8.2f %8.3f %8.2f %8.3f %6.1f %8.1f %8.1f %6d %6d   %5.1f-%5.1f %6d %8.3f %10.1e "
           "%6.1f "
           "%6lu\n",
           landing.number, landing.gear.stop_ft, landing.gear.stop_s,
           landing.gear.speed_ft_s / (landing.gear.stop_s - landing.gear.touchdown_s),
           landing.peak_any_in, landing.peak_any_ft, landing.reach_median_ft, landing.reach_max_ft,
           landing.zone_start.mats, landing.zone_end.mats, landing.zone_end.start_ft,
           landing.zone_end.end_ft, landing.zone_end.closed_joints,
           landing.at_zone_s < 0.0 ? -1.0 : landing.at_zone_s - landing.gear.touchdown_s,
           landing.balance_lb_s, landing.iterations_per_step, landing.hard_steps);
}

static int make_runs(const char *folder, uint64_t seed, int steps_per_ms, int last)
{
    syn_series_start(&series, seed, steps_per_ms);
    printf("landing  stop_ft   stop_s decel_f/s peak_in  at_ft reach_med reach_max zone_0 zone_1   "
           "stations  "
           "  closed  at_50_s"
           "    balance   iter   hard\n");
    for (int number = 1; number <= last; number++) {
        if (!land(number))
            return 5;
        print_row();
        if (!write_landing(folder)) {
            fprintf(stderr, "synthesise: %s/landing%d.run: %s; name a folder that can be written\n",
                    folder, number, strerror(errno));
            return 3;
        }
    }
    return 0;
}

/* Each landing from the same start with the step and with its half. */
static int check_all(uint64_t seed, int steps_per_ms)
{
    static struct syn_landing coarse;
    static struct syn_chain start;
    bool good = true;

    syn_series_start(&series, seed, steps_per_ms);
    for (int number = 1; number <= SYN_LANDINGS; number++) {
        double apart = 0.0, square = 0.0, gap_apart = 0.0;

        start = series.chain;
        series.steps_per_ms = 2 * steps_per_ms;
        if (!land(number))
            return 5;
        coarse = landing;
        series.chain = start;
        series.steps_per_ms = steps_per_ms;
        if (!land(number))
            return 5;
        for (int k = 0; k < landing.samples; k++)
            for (int i = 0; i < SYN_TRANSDUCERS; i++) {
                double difference = landing.displacement_in[k][i] - coarse.displacement_in[k][i];

                apart = fmax(apart, fabs(difference));
                square += difference * difference;
            }
        for (int j = 0; j < SYN_JOINTS; j++)
            gap_apart = fmax(gap_apart, fabs(landing.gap_end_in[j] - coarse.gap_end_in[j]));
        printf("landing %d: half the step moves a transducer by at most %.5f in, rms %.5f in, a "
               "final gap by "
               "%.5f in, "
               "zone %d and %d mats\n",
               number, apart, sqrt(square / (landing.samples * SYN_TRANSDUCERS)), gap_apart,
               landing.zone_end.mats, coarse.zone_end.mats);
        good = good && apart <= CONVERGED_IN;
    }
    return good ? 0 : 1;
}

static int print_mats(int last, uint64_t seed)
{
    syn_series_start(&series, seed, STEPS_PER_MS);
    for (int number = 1; number <= last; number++)
        if (!land(number))
            return 5;
    printf("# joint station_ft gap_in gap_end_in grit_lb u_end_in\n");
    for (int j = 1, k = 0; j <= SYN_JOINTS; j++, k++) {
        static double u_in;

        u_in += landing.gap_end_in[k] - landing.gap_in[k];
        printf("%d %.4f %.6f %.6f %.3f %.5f\n", j, k * SYN_MAT_FT, landing.gap_in[k],
               landing.gap_end_in[k], series.chain.grit_lb[j], u_in);
    }
    return 0;
}

static bool number_from(const char *text, uint64_t low, uint64_t high, uint64_t *value)
{
    char *end;

    errno = 0;
    *value = strtoull(text, &end, 10);
    return errno == 0 && text[0] >= '0' && text[0] <= '9' && *end == '\0' && *value >= low &&
         *value <= high;
}

int main(int argc, char **argv)
{
    uint64_t seed = SEED, steps = STEPS_PER_MS, last = SYN_LANDINGS;
    bool mats = argc > 1 && strcmp(argv[1], "--mats") == 0;
    int at = mats ? 3 : 2;

    if (argc < at || argc > (mats ? 4 : 5) ||
        (mats && !number_from(argv[2], 1, SYN_LANDINGS, &last)) ||
        (argc > at && !number_from(argv[at], 0, UINT64_MAX, &seed)) ||
        (argc > at + 1 && !number_from(argv[at + 1], 4, 1000, &steps)) ||
        (argc > at + 2 && !number_from(argv[at + 2], 1, SYN_LANDINGS, &last))) {
        fprintf(
            stderr,
            "synthesise: usage: synthesise OUTPUT_DIR|--check [SEED [STEPS_PER_MS [LANDINGS]]], "
            "or --mats LANDING [SEED]\n");
        return 2;
    }
    if (mats)
        return print_mats((int)last, seed);
    if (strcmp(argv[1], "--check") == 0)
        return check_all(seed, (int)steps);
    return make_runs(argv[1], seed, (int)steps, (int)last);
}
