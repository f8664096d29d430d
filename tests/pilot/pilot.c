/* pilot [SEEDS]: the six results of the pilot study (report B.3) as cases: observed | computed |
 * verdict. 8 runways each when not said otherwise; campaigns of host/landing_series/pilot.
 *
 * Exit: 0, whatever the verdicts are; 2 usage; 3 files; 5 a runway could not be played. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "host/base/statistics.h"
#include "host/landing_series/ensemble.h"

#define FT_S_PER_MPH (5280.0 / 3600.0)
#define SPEEDS       3
#define STOP_FROM_FT 9.4 /* of result 6: every speed stops there, so that speed alone differs */
#define STOP_TO_FT   12.0
#define CRESTS_MAX   4096

static const double mph[SPEEDS] = {2.5, 5.0, 10.0};

/* What an ensemble did. */
struct tally {
    /* ahead: buckled without the wheel having met the wave */
    size_t runways, landings, buckled, ahead, low_waves;
    size_t crests;
    double crest_ft[CRESTS_MAX], ahead_mats[CRESTS_MAX];
    double most_rise_in;
};

static enum mr_status play(struct tally *t, const char *name, size_t seeds, double speed_ft_s,
                           struct error *error)
{
    char path[200];
    struct landing_series c;
    *t = (struct tally){0};
    snprintf(path, sizeof path, "host/landing_series/pilot/%s.json", name);
    if (series_load(&c, path, error) != MR_OK)
        return error->status;
    c.seed_count = seeds;
    for (size_t i = 0; speed_ft_s > 0.0 && i < c.landing_count; i++) {
        double stopping_distance_ft = speed_ft_s * speed_ft_s /
                                      (2.0 * c.landings[i].deceleration_ft_s2.low);
        c.landings[i].speed_ft_s = (struct series_range){speed_ft_s, speed_ft_s};
        c.landings[i].touchdown_ft = (struct series_range){STOP_FROM_FT - stopping_distance_ft,
                                                           STOP_TO_FT - stopping_distance_ft};
    }
    struct series_run *runs = calloc(seeds, sizeof *runs);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!runs)
        error_set(error, MR_FULL, "out of memory: %zu seeds", seeds);
    else
        series_simulate_all(&c, cores > 0 ? (unsigned)cores : 1, NULL, NULL, runs);
    for (size_t i = 0; runs && i < seeds; i++) {
        if (runs[i].error.status != MR_OK)
            *error = runs[i].error;
        t->runways++;
        t->buckled += runs[i].buckled_landing > 0;
        for (size_t k = 0; k < runs[i].simulated_landing_count; k++) {
            const struct series_outcome *o = &runs[i].outcomes[k];
            t->landings++;
            t->low_waves += o->wave_count > 0 && !o->is_buckled;
            t->ahead += o->is_buckled && o->wave_encounter_count == 0;
            t->most_rise_in = fmax(t->most_rise_in, o->wave_rise_in);
            if (o->first_buckle_station_ft > 0.0 && t->crests < CRESTS_MAX) {
                t->crest_ft[t->crests] = o->first_buckle_station_ft;
                t->ahead_mats[t->crests++] = o->first_buckle_ahead_mats;
            }
        }
        series_run_free(&runs[i]);
    }
    free(runs);
    series_free(&c);
    return error->status;
}

static double middle(double *values, size_t count)
{
    sort_numbers(values, count);
    return count > 0 ? 0.5 * (values[(count - 1) / 2] + values[count / 2]) : (double)NAN;
}

static size_t within(const double *values, size_t count, double low, double high)
{
    size_t inside = 0;
    for (size_t i = 0; i < count; i++)
        inside += values[i] >= low && values[i] <= high;
    return inside;
}

static const char *verdict(bool agrees)
{
    return agrees ? "agrees" : "DIFFERS";
}

static void print_waves(struct tally *concrete, struct tally *pad)
{
    printf("| 1 | bow waves form on the model | %zu of %zu runways buckle on concrete, %zu of %zu "
           "on the pad | %s |\n",
           concrete->buckled, concrete->runways, pad->buckled, pad->runways,
           verdict(2 * concrete->buckled >= concrete->runways && 2 * pad->buckled >= pad->runways));
    double typical_ft = middle(concrete->crest_ft, concrete->crests), spread_ft = 0.0;
    if (concrete->crests > 0)
        spread_ft = concrete->crest_ft[concrete->crests - 1] - concrete->crest_ft[0];
    printf("| 2 | concrete, more friction above than below: at various locations down the runway | "
           "%zu waves at stations %.1f "
           "to %.1f ft of 17.5 (middle %.1f) | %s: spread over %.0f panels |\n",
           concrete->crests, concrete->crests ? concrete->crest_ft[0] : 0.0,
           concrete->crests ? concrete->crest_ft[concrete->crests - 1] : 0.0, typical_ft,
           verdict(spread_ft > 10 * 3.5 / 12), spread_ft * 12 / 3.5);
    size_t close = within(pad->ahead_mats, pad->crests, 5, 8);
    double ahead = middle(pad->ahead_mats, pad->crests),
           concrete_ahead = middle(concrete->ahead_mats, concrete->crests);
    printf("| 3 | compressible base: in front of and close to the gear | %.1f panels ahead "
           "(middle) on the pad, %.1f on concrete | %s |\n",
           ahead, concrete_ahead, verdict(ahead > 0 && ahead < concrete_ahead));
    printf("| 3 | compressible base: crest usually five to eight panels ahead of the gear | middle "
           "%.1f panels ahead, %zu of %zu "
           "waves within five to eight, %.0f to %.0f | %s |\n",
           ahead, close, pad->crests, pad->crests ? pad->ahead_mats[0] : 0.0,
           pad->crests ? pad->ahead_mats[pad->crests - 1] : 0.0, verdict(ahead >= 5 && ahead <= 8));
}

static enum mr_status print_speeds(size_t seeds, struct error *error)
{
    static struct tally t;
    size_t least = (size_t)-1, most = 0;
    printf("| 6 | speed makes no significant difference up to 10 mph | runways that buckle in 12 "
           "landings that stop at the same places:");
    for (int i = 0; i < SPEEDS; i++) {
        if (play(&t, "concrete", seeds, mph[i] * FT_S_PER_MPH, error) != MR_OK)
            return error->status;
        printf(" %zu of %zu at %.3g mph%s", t.buckled, t.runways, mph[i],
               i + 1 < SPEEDS ? "," : "");
        least = t.buckled < least ? t.buckled : least;
        most = t.buckled > most ? t.buckled : most;
    }
    printf(" | %s: within a quarter of the runways |\n", verdict(4 * (most - least) <= seeds));
    return MR_OK;
}

int main(int argc, char **argv)
{
    static struct tally concrete, pad, grip;
    struct error error = {0};
    size_t seeds = argc > 1 ? (size_t)strtoul(argv[1], NULL, 10) : 8;
    if (seeds < 1 || seeds > 300) {
        fputs("usage: pilot [SEEDS]\n", stderr);
        return 2;
    }
    if (play(&concrete, "concrete", seeds, 0.0, &error) == MR_OK &&
        play(&pad, "pad", seeds, 0.0, &error) == MR_OK &&
        play(&grip, "grip", seeds, 0.0, &error) == MR_OK) {
        printf("| B.3 | observed | computed, %zu runways a case | verdict |\n|---|---|---|---|\n",
               seeds);
        print_waves(&concrete, &pad);
        size_t buckled = concrete.buckled + pad.buckled, ahead = concrete.ahead + pad.ahead;
        printf("| 4 | panels come apart and the wave collapses ahead of the wheels, rather than "
               "being overrun | %zu of %zu that "
               "buckle do so before the wheel meets the wave | %s |\n",
               ahead, buckled, verdict(2 * ahead > buckled));
        printf("| 5 | more friction below than above: no bow wave | %zu of %zu runways buckle, "
               "largest rise %.3f in in %zu landings | %s |\n",
               grip.buckled, grip.runways, grip.most_rise_in, grip.landings,
               verdict(grip.buckled == 0 && grip.low_waves == 0));
        print_speeds(seeds, &error);
    }
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "pilot: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
