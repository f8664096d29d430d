/* How well the measured outcome of a landing (host/analyse/outcome.h: survey before and
 * transducers) agrees with the truth, in landings that are not the model of the board. Two views:
 * transducers at 40 to 110 ft and at 10 to 70 ft.
 *
 * build/tests/score/outcome FOLDER FROM SERIES [KIND...]
 *
 * Exit: 0; 2 usage. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/closure.h"
#include "host/analyse/outcome.h"
#include "host/base/statistics.h"
#include "tests/score/score.h"

#define MEAN_NOISE_IN 0.0004 /* of a moving mean over 0.02 s */
#define GAIN_ERROR    0.001
#define LANDINGS_MAX  20000

struct counts {
    unsigned hits, misses, false_hits, silences, timed, covered;
    size_t lengths;
    double length_error[LANDINGS_MAX];
};

static struct reached_zone measure(const struct score_landing *landing, bool upfield,
                                   uint64_t *state)
{
    float station_ft[MR_TRANSDUCERS], slack_in[MR_SEGMENTS], left_in[MR_SEGMENTS],
        reading_in[MR_TRANSDUCERS];
    double gain[MR_TRANSDUCERS];
    struct reached_zone reach;
    reached_zone_init(&reach);
    score_read_survey(landing, slack_in, state);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        station_ft[i] = upfield ? 10.0f * (float)(i + 1) : 40.0f + 10.0f * (float)i;
        gain[i] = 1.0 + GAIN_ERROR * score_normal(state);
    }
    for (unsigned k = 0; k < landing->looks; k++) {
        double t_s = 1e-3 * SCORE_LOOK_MS * k, wheel_ft = (double)landing->wheel_ft[k];
        unsigned row = k * SCORE_LOOK_MS / SCORE_ROW_MS;
        struct mr_closure_zone zone;
        if (!((double)landing->speed_at_ft_s[k] > SCORE_SLOW_FT_S) || !(wheel_ft > 0.0) ||
            row >= landing->rows || t_s > (double)landing->wave_s)
            continue;
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            double u_in = (double)landing->u_in[row][(unsigned)(station_ft[i] / 10.0f + 0.5f) - 1u];
            reading_in[i] = upfield && i == 7 /* 10 to 70 ft are seven */
                              ? NAN
                              : (float)(u_in * gain[i] + MEAN_NOISE_IN * score_normal(state));
        }
        struct mr_closure_input input = {station_ft, reading_in, slack_in, (float)wheel_ft};
        mr_closure_find_zone(&input, &zone, left_in);
        zones_find_longest_zone(slack_in, left_in, wheel_ft, REACHED_ZONE_DISTANCE_MAX_FT, &zone);
        reached_zone_update(&reach, t_s, wheel_ft, &zone);
    }
    return reach;
}

static void count(const struct score_landing *landing, const struct reached_zone *reach,
                  struct counts *counts)
{
    int16_t true_mats;
    const double look_s = 1e-3 * SCORE_LOOK_MS, event_s = score_event_s(landing, &true_mats),
                 *said_s = reach->reached_t_s;
    bool said = !isnan(said_s[REACHED_ZONE_BEST]);
    counts->hits += !isnan(event_s) && said;
    counts->misses += !isnan(event_s) && !said;
    counts->false_hits += isnan(event_s) && said;
    counts->silences += isnan(event_s) && !said;
    if (!isnan(event_s) && said) {
        counts->timed++;
        counts->covered += event_s > said_s[REACHED_ZONE_EARLIEST] - 1.01 * look_s &&
                           !(event_s > said_s[REACHED_ZONE_LATEST] + 1.01 * look_s);
    }
    if (true_mats >= 25 && true_mats <= 80 && counts->lengths < LANDINGS_MAX)
        counts->length_error[counts->lengths++] = (double)reach->longest_mats - true_mats;
}

static void print(const char *kind, bool upfield, struct counts *c)
{
    size_t n = c->lengths, within = 0, within_3 = 0;
    if (n == 0 || c->timed == 0)
        return;
    sort_numbers(c->length_error, n);
    for (size_t i = 0; i < n; i++) {
        within += fabs(c->length_error[i]) <= ZONES_ERROR_MATS;
        within_3 += fabs(c->length_error[i]) <= 3 * ZONES_ERROR_MATS;
    }
    printf("| %s | %s | %u, %u | %u, %u | %+.0f | %.0f, %.0f | %.0f |\n", kind,
           upfield ? "10 to 70" : "40 to 110", c->hits, c->misses, c->false_hits, c->silences,
           c->length_error[n / 2], 100.0 * (double)within / (double)n,
           100.0 * (double)within_3 / (double)n, 100.0 * c->covered / c->timed);
}

int main(int argc, char **argv)
{
    static struct score_truth truth;
    static struct counts counts[2];
    static char all[] = "chain", *standard[] = {all};
    if (argc < 4) {
        fputs("usage: outcome FOLDER FROM SERIES [KIND...]\n", stderr);
        return 2;
    }
    uint32_t from = (uint32_t)atoi(argv[2]), series = (uint32_t)atoi(argv[3]);
    char **kinds = argc > 4 ? argv + 4 : standard;
    printf("| Truth | Transducers (ft) | Reached: said, missed | Not reached: said, not said | "
           "Length: "
           "median error (mats) | within %d, %d mats (%%) | Time in its interval (%%) |\n"
           "|---|---|--:|--:|--:|--:|--:|\n",
           ZONES_ERROR_MATS, 3 * ZONES_ERROR_MATS);
    for (int k = 0; k < (argc > 4 ? argc - 4 : 1); k++) {
        counts[0] = counts[1] = (struct counts){0};
        enum score_kind kind = score_kind_find(kinds[k]);
        for (uint32_t n = from; n < from + series; n++) {
            if (kind == SCORE_KINDS)
                return 2;
            if (!score_truth_get(&truth, n, kind, argv[1]))
                continue; /* told; a truth that is not known to its own error counts for nothing */
            for (uint32_t i = 0; i < truth.series.landings; i++) {
                for (unsigned upfield = 0; upfield < 2; upfield++) {
                    uint64_t state = 1000u * n + 10u * i + upfield;
                    struct reached_zone reach = measure(&truth.landing[i], upfield == 1, &state);
                    count(&truth.landing[i], &reach, &counts[upfield]);
                }
            }
        }
        print(kinds[k], false, &counts[0]);
        print(kinds[k], true, &counts[1]);
    }
    return 0;
}
