/* before: how well an ensemble of chains ranks landings before touchdown. See README.md, "Before
 * touchdown".
 *
 *   before FOLDER FROM COUNT [planar|elastic]
 *                         series FROM .. FROM + COUNT - 1, truth as score keeps it; the table on
 *                         stdout. The rule it is held against is fitted on series 0 to 199
 *
 * Known before touchdown: a survey, friction told with 10 % rms, the speed, and a plan of the mean
 * deceleration that is met within 10 % rms. Drawn by member: share of the thrust, friction, closing
 * resistance, openings that have the surveyed sums, and how the plan is met. After a landing the
 * members are run again with the braking that it had, and an ensemble Kalman filter takes in where
 * the transducers came to rest (Evensen 1994; perturbed observations, inflated).
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/advise/forecast.h"
#include "host/base/ordered.h"
#include "tests/score/advised.h"

#define PLAN_ERROR 0.1
#define TRAINED    200u /* series that the rule is fitted on */
#define FEATURES   5
#define BOOTSTRAPS 1000u

/* One landing as it is ranked. */
struct ranked {
    unsigned series, landing;
    bool event;
    double probability, odds; /* odds: log odds of the share of members, as counted */
    double feature[FEATURES]; /* 1, plan, told friction, count, slack surveyed; scaled */
};

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

/* Solves a x = b (symmetric, positive) in place by Cholesky's way; b becomes x. */
static void solve(double a[FEATURES][FEATURES], double b[FEATURES])
{
    for (int i = 0; i < FEATURES; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = a[i][j];
            for (int k = 0; k < j; k++)
                sum -= a[i][k] * a[j][k];
            a[i][j] = i == j ? sqrt(fmax(sum, 1e-12)) : sum / a[j][j];
        }
        for (int k = 0; k < i; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (int i = FEATURES - 1; i >= 0; i--) {
        for (int k = i + 1; k < FEATURES; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

/* The landing's facts; the event is of its truth. */
static void take_facts(struct ranked *ranked, const struct score_series *series,
                       const struct score_landing *landing, double plan_ft_s2, const double *sum_in)
{
    double slack_ft = 0.0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack_ft += sum_in[s] / 12.0;
    *ranked = (struct ranked){.series = series->number,
                              .landing = landing->number,
                              .event = !isnan(score_event_s(landing)),
                              .feature = {1.0, plan_ft_s2 / 6.0, series->told_friction / 0.6,
                                          landing->number / 3.0, slack_ft}};
}

/* All landings of a series; `rules`: facts alone. False: it failed. */
static bool play(const struct score_truth *truth, bool rules, struct ranked *ranked, size_t *count)
{
    const struct score_series *series = &truth->series;
    struct advise_members members = {0};
    struct advised_known known[SCORE_LANDINGS];
    double log_ratio[SCORE_LANDINGS];
    uint64_t facts = 0xbef00000u + series->number;
    for (unsigned i = 0; i < series->landings; i++) {
        const struct score_landing *landing = &truth->landing[i];
        struct advised_known *k = &known[i];
        k->true_ft_s2 = advised_mean_ft_s2(landing, series->touchdown_ft);
        k->plan_ft_s2 = k->true_ft_s2 * clamp(1.0 + PLAN_ERROR * score_normal(&facts), 0.6, 1.5);
        advised_read(landing, &facts, k);
        log_ratio[i] = log(k->true_ft_s2 / k->plan_ft_s2);
        take_facts(&ranked[*count + i], series, landing, k->plan_ft_s2, k->sum_in);
    }
    bool good = rules || advised_begin(&members, series);
    for (unsigned i = 0; !rules && good && i < series->landings; i++) {
        struct advise_row row;
        struct advise_plan plan;
        advised_plan(&plan, &truth->landing[i], &known[i], log_ratio, i);
        good = advised_say(&members, &plan, &known[i], known[i].plan_ft_s2, &row) &&
               (i + 1 == series->landings ||
                advised_teach(&members, &truth->landing[i], &known[i], &known[i + 1]));
        ranked[*count + i].probability = row.zone.p;
        ranked[*count + i].odds = advise_odds(row.share);
    }
    *count += series->landings;
    advise_members_free(&members);
    return good;
}

/* Logistic regression by Newton's steps, slightly drawn to 0. */
static void fit_rule(const struct ranked *ranked, size_t count, double *weight)
{
    memset(weight, 0, FEATURES * sizeof *weight);
    for (unsigned round = 0; round < 25; round++) {
        double a[FEATURES][FEATURES] = {{0}}, b[FEATURES] = {0};
        for (size_t i = 0; i < count; i++) {
            const double *x = ranked[i].feature;
            double sum = 0.0;
            for (int k = 0; k < FEATURES; k++)
                sum += weight[k] * x[k];
            double p = 1.0 / (1.0 + exp(-sum));
            for (int k = 0; k < FEATURES; k++) {
                b[k] += (ranked[i].event - p) * x[k];
                for (int j = 0; j < FEATURES; j++)
                    a[k][j] += p * (1.0 - p) * x[k] * x[j];
            }
        }
        for (int k = 0; k < FEATURES; k++) {
            a[k][k] += 1e-3;
            b[k] -= 1e-3 * weight[k];
        }
        solve(a, b);
        for (int k = 0; k < FEATURES; k++)
            weight[k] += b[k];
    }
}

static double rule(const double *weight, const struct ranked *ranked)
{
    double sum = 0.0;
    for (int k = 0; k < FEATURES; k++)
        sum += weight[k] * ranked->feature[k];
    return 1.0 / (1.0 + exp(-sum));
}

enum { BY_ENSEMBLE, BY_RULE, BY_PLAN, WAYS };
static const char *const way_names[WAYS] = {
    "ensemble of 64", "logistic of plan, friction, count, survey", "planned deceleration"};

static double value_of(unsigned way, const struct ranked *ranked, const double *weight)
{
    return way == BY_ENSEMBLE ? ranked->probability
         : way == BY_RULE     ? rule(weight, ranked)
                              : ranked->feature[1];
}

/* Area of the landings of some series, drawn with replacement (`pick`) or all. */
static double area(const struct ranked *ranked, size_t count, unsigned from, const unsigned *times,
                   unsigned way, const double *weight, bool later)
{
    static float rank[200000];
    static bool event[200000];
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        for (unsigned t = 0; t < (times ? times[ranked[i].series - from] : 1u); t++) {
            if ((later && ranked[i].landing == 1) || n == 200000)
                continue;
            rank[n] = (float)value_of(way, &ranked[i], weight);
            event[n++] = ranked[i].event;
        }
    }
    return score_auc(rank, event, n);
}

static void print_areas(const struct ranked *ranked, size_t count, unsigned from, unsigned series,
                        const double *weight, bool later)
{
    static double lead[WAYS][BOOTSTRAPS];
    unsigned *times = calloc(series, sizeof *times);
    uint64_t state = 0xb0075000u;
    for (unsigned d = 0; times && d < BOOTSTRAPS; d++) {
        memset(times, 0, series * sizeof *times);
        for (unsigned s = 0; s < series; s++)
            times[(unsigned)(score_uniform(&state) * series)]++;
        double own = area(ranked, count, from, times, BY_ENSEMBLE, weight, later);
        for (unsigned w = 1; w < WAYS; w++)
            lead[w][d] = own - area(ranked, count, from, times, w, weight, later);
    }
    for (unsigned w = 0; w < WAYS; w++) {
        double all = area(ranked, count, from, NULL, w, weight, later);
        printf("  %-42s %.3f", way_names[w], all);
        if (w) {
            order_numbers(lead[w], BOOTSTRAPS);
            printf("   ensemble's lead %+.3f (%+.3f to %+.3f)",
                   area(ranked, count, from, NULL, BY_ENSEMBLE, weight, later) - all,
                   lead[w][BOOTSTRAPS / 40], lead[w][BOOTSTRAPS - BOOTSTRAPS / 40 - 1]);
        }
        printf("\n");
    }
    free(times);
}

static void print_reliability(const struct ranked *ranked, size_t count, const double *weight)
{
    double said[5] = {0}, seen[5] = {0}, brier[2] = {0}, events = 0.0;
    unsigned n[5] = {0};
    for (size_t i = 0; i < count; i++) {
        unsigned bin = (unsigned)fmin(5.0 * ranked[i].probability, 4.0);
        double off = ranked[i].probability - ranked[i].event,
               rule_off = rule(weight, &ranked[i]) - ranked[i].event;
        said[bin] += ranked[i].probability;
        seen[bin] += ranked[i].event;
        n[bin]++;
        brier[0] += off * off / (double)count;
        brier[1] += rule_off * rule_off / (double)count;
        events += ranked[i].event / (double)count;
    }
    printf("said, seen, landings:");
    for (unsigned b = 0; b < 5; b++)
        printf("%s %.2f %.2f %u", b ? ";" : "", n[b] ? said[b] / n[b] : (double)NAN,
               n[b] ? seen[b] / n[b] : (double)NAN, n[b]);
    printf("\nBrier: ensemble %.3f, logistic %.3f, climatology %.3f\n", brier[0], brier[1],
           events * (1.0 - events));
}

/* The log odds that would have held for these landings: odds_times * odds + odds_more. What
 * host/advise/forecast.c has is this of series 250 to 309. */
static void print_odds(const struct ranked *ranked, size_t count)
{
    double more = 0.0, times = 1.0;
    for (unsigned round = 0; round < 50; round++) {
        double a[3] = {1e-6, 0.0, 1e-6}, b[2] = {0.0, 0.0};
        for (size_t i = 0; i < count; i++) {
            double x = ranked[i].odds, p = 1.0 / (1.0 + exp(-(more + times * x)));
            double w = p * (1.0 - p), off = ranked[i].event - p;
            a[0] += w;
            a[1] += w * x;
            a[2] += w * x * x;
            b[0] += off;
            b[1] += off * x;
        }
        double det = a[0] * a[2] - a[1] * a[1];
        more += clamp((a[2] * b[0] - a[1] * b[1]) / det, -0.2, 0.2);
        times += clamp((a[0] * b[1] - a[1] * b[0]) / det, -0.2, 0.2);
    }
    printf("log odds that would have held: %.2f times the members', and %+.2f\n", times, more);
}

int main(int argc, char **argv)
{
    static struct score_truth truth;
    enum score_kind kind = argc == 5 && strcmp(argv[4], "planar") == 0  ? SCORE_PLANAR
                         : argc == 5 && strcmp(argv[4], "elastic") == 0 ? SCORE_ELASTIC
                                                                        : SCORE_CHAIN;
    if (argc < 4 || argc > 5 || (argc == 5 && kind == SCORE_CHAIN) ||
        atoi(argv[2]) < (int)TRAINED || atoi(argv[3]) < 1 ||
        atoi(argv[2]) + atoi(argv[3]) > 65535) {
        fprintf(stderr,
                "before: usage: before FOLDER FROM COUNT [planar|elastic] (series FROM, at "
                "least %u, and on)\n",
                TRAINED);
        return 2;
    }
    unsigned from = (unsigned)atoi(argv[2]), series = (unsigned)atoi(argv[3]);
    struct ranked *ranked = calloc(SCORE_LANDINGS * (size_t)(series > TRAINED ? series : TRAINED),
                                   sizeof *ranked);
    double weight[FEATURES];
    size_t count = 0, events = 0;
    int code = ranked ? 0 : 5;
    for (unsigned n = 0; n < TRAINED && code == 0; n++) {
        code = score_truth_get(&truth, n, kind, argv[1]) ? 0 : 5;
        play(&truth, true, ranked, &count);
    }
    fit_rule(ranked, count, weight);
    count = 0;
    for (unsigned n = from; n < from + series && code == 0; n++) {
        code = score_truth_get(&truth, n, kind, argv[1]) && play(&truth, false, ranked, &count) ? 0
                                                                                                : 5;
    }
    if (code)
        return code;
    for (size_t i = 0; i < count; i++)
        events += ranked[i].event;
    printf("before touchdown: %zu landings of series %u to %u, %zu events\n", count, from,
           from + series - 1u, events);
    printf("area under the curve, all landings:\n");
    print_areas(ranked, count, from, series, weight, false);
    printf("from the second landing of a series on:\n");
    print_areas(ranked, count, from, series, weight, true);
    print_reliability(ranked, count, weight);
    print_odds(ranked, count);
    free(ranked);
    return 0;
}
