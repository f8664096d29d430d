/* waves: how well bow waves are foretold before touchdown. See README.md, "Bow waves before
 * touchdown".
 *
 *   waves FOLDER fit                      the law's constants (host/advise/waves.c) and calibration
 *   waves FOLDER score FROM COUNT [N]     series FROM .. FROM + COUNT - 1 of the planar truth, 700
 *                                         or higher; with N members in the planar model besides
 *
 * Known before touchdown are a survey, friction told, the speed, and a plan of the mean
 * deceleration; the landings before teach (advised.h), and raised no wave: a wave ends a series.
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/advise/waves.h"
#include "host/base/ordered.h"
#include "tests/score/advised.h"

#define BUMP_FT      0.0036 /* irregularity told: the largest of this truth's ground */
#define RIDGE        1e-3
#define MOST_SIDES   6
#define RULE_INPUTS  6
#define BOOTSTRAPS   1000u
#define FIRST_SCORED 700u
#define LANDINGS     4000u

/* Series that constants are of, and those of them that calibrate. */
static const struct {
    unsigned from, to;
    bool calibrates;
} trained[] = {{0, 250, false}, {250, 310, true}, {540, 600, true}};

enum { EXACT, OFF_10, OFF_25, HARDEST_TOLD, PLANS };
static const double plan_error[PLANS] = {0.0, 0.1, 0.25, 0.0};
static const char *const plan_names[PLANS] = {"plan exact", "plan 10 % off", "plan 25 % off",
                                              "plan exact, its hardest deceleration told"};

enum { BY_ADVICE, BY_RULE, BY_PLAN, BY_SHARE, BY_PLAYED, WAYS };
static const char *const way_names[WAYS] = {
    "advice, 64 members", "logistic of plan, friction, count, speed, survey",
    "planned deceleration", "advice that does not know that mats stood", "members, planar model"};

/* One landing by one plan. */
struct told {
    unsigned series, landing;
    bool wave;
    double by[WAYS];
    double rule[RULE_INPUTS];
    double law[ADVISE_WAVE_INPUTS]; /* of the true share: nobody is told it */
};

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

/* --- logistic regression --- */

/* Inverts a symmetric, positive matrix in place. */
static void invert(double a[MOST_SIDES][MOST_SIDES], unsigned n)
{
    for (unsigned k = 0; k < n; k++) {
        double pivot = a[k][k];
        a[k][k] = 1.0;
        for (unsigned j = 0; j < n; j++)
            a[k][j] /= pivot;
        for (unsigned i = 0; i < n; i++) {
            double by = a[i][k];
            if (i == k)
                continue;
            a[i][k] = 0.0;
            for (unsigned j = 0; j < n; j++)
                a[i][j] -= by * a[k][j];
        }
    }
}

static double dot(const double *a, const double *b, unsigned n)
{
    double sum = 0.0;
    for (unsigned k = 0; k < n; k++)
        sum += a[k] * b[k];
    return sum;
}

static double chance_at(double odds)
{
    return 1.0 / (1.0 + exp(-odds));
}

/* By Newton's steps, slightly drawn to 0; `input` gives a landing's n. The covariance is left in
 * `spread`. */
static void fit(const struct told *told, size_t count, unsigned n,
                const double *(*input)(const struct told *), double *weight,
                double spread[MOST_SIDES][MOST_SIDES])
{
    memset(weight, 0, n * sizeof *weight);
    for (unsigned round = 0; round < 40; round++) {
        double b[MOST_SIDES] = {0.0}, most = 0.0;
        memset(spread, 0, MOST_SIDES * sizeof *spread);
        for (unsigned k = 0; k < n; k++) {
            spread[k][k] = RIDGE;
            b[k] = -RIDGE * weight[k];
        }
        for (size_t i = 0; i < count; i++) {
            const double *x = input(&told[i]);
            double p = chance_at(dot(weight, x, n));
            for (unsigned k = 0; k < n; k++) {
                b[k] += (told[i].wave - p) * x[k];
                for (unsigned j = 0; j < n; j++)
                    spread[k][j] += p * (1.0 - p) * x[k] * x[j];
            }
        }
        invert(spread, n);
        for (unsigned k = 0; k < n; k++)
            most = fmax(most, fabs(dot(spread[k], b, n)));
        for (unsigned k = 0; k < n; k++)
            weight[k] += dot(spread[k], b, n) * fmin(1.0, 3.0 / fmax(most, 1e-12));
    }
}

static const double *law_of(const struct told *told)
{
    return told->law;
}

static const double *rule_of(const struct told *told)
{
    return told->rule;
}

/* --- a series --- */

struct work {
    const char *folder;
    struct told *told[PLANS];
    size_t count;
    unsigned played; /* members */
};

static double hardest_ft_s2(const struct score_landing *landing)
{
    return (double)fmaxf(landing->knot_ft_s2[0], landing->knot_ft_s2[SCORE_KNOTS - 1]);
}

static void tell_profile(const struct score_landing *landing, double mean_ft_s2,
                         struct advise_profile *profile)
{
    profile->count = SCORE_KNOTS;
    for (unsigned i = 0; i < SCORE_KNOTS; i++) {
        profile->t_s[i] = (double)landing->knot_s[i];
        profile->factor[i] = (double)landing->knot_ft_s2[i] / mean_ft_s2;
    }
}

static void take_facts(struct told *told, unsigned plan, const struct score_series *series,
                       const struct score_landing *landing, const struct advised_known *known,
                       const struct advise_runway *runway)
{
    double slack_ft = 0.0,
           planned = plan == HARDEST_TOLD ? hardest_ft_s2(landing) : known->plan_ft_s2;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack_ft += known->sum_in[s] / 12.0;
    *told = (struct told){.series = series->number,
                          .landing = landing->number,
                          .wave = !isnan(landing->wave_s),
                          .by[BY_PLAN] = planned,
                          .rule = {1.0, log(planned / 6.0), series->told_friction / 0.6 - 1.0,
                                   landing->number / 3.0, log(landing->speed_ft_s / 32.0),
                                   slack_ft}};
    advise_wave_inputs(series->thrust_share * runway->thrust_lb_per_g * known->true_ft_s2 /
                           ADVISE_G_FT_S2,
                       advise_wave_critical_lb(runway), landing->speed_ft_s, told->law);
}

static double played_share(const struct advise_members *members, const struct advise_plan *plan,
                           unsigned count)
{
    struct advise_row row = {.mean_ft_s2 = plan->mean_ft_s2};
    struct error error = {0};
    size_t played;
    return advise_waves_played(members, plan, count, &row, 1, 0, &played, &error) == MR_OK
             ? row.played.p
             : (double)NAN;
}

/* What is said before landing `i`, by all plans. */
static bool say(struct work *work, const struct score_truth *truth, struct advise_members *members,
                struct advised_known known[PLANS][SCORE_LANDINGS], unsigned i)
{
    const struct score_landing *landing = &truth->landing[i];
    struct advise_braking stood[SCORE_LANDINGS];
    double log_ratio[SCORE_LANDINGS];
    for (unsigned k = 0; k < i; k++)
        stood[k] = (struct advise_braking){.speed_ft_s = truth->landing[k].speed_ft_s,
                                           .mean_ft_s2 = known[EXACT][k].true_ft_s2};
    for (unsigned p = 0; p < PLANS; p++) {
        struct advise_plan plan;
        struct advise_row row[2];
        struct told *told = &work->told[p][work->count + i];
        for (unsigned k = 0; k < i; k++)
            log_ratio[k] = log(known[p][k].true_ft_s2 / known[p][k].plan_ft_s2);
        advised_plan(&plan, landing, &known[p][i], log_ratio, i);
        row[0] = row[1] = (struct advise_row){.mean_ft_s2 = plan.mean_ft_s2};
        if (!advise_waves(members, &plan, stood, i, &row[0], 1) ||
            !advise_waves(members, &plan, stood, 0, &row[1], 1))
            return false;
        told->by[BY_ADVICE] = row[0].wave.p;
        told->by[BY_SHARE] = row[1].wave.p;
        if (work->played && p == OFF_10)
            told->by[BY_PLAYED] = played_share(members, &plan, work->played);
    }
    return true;
}

/* All landings of a series; `facts_alone`: nothing is taught or said. */
static bool play(struct work *work, const struct score_truth *truth, bool facts_alone)
{
    static struct advised_known known[PLANS][SCORE_LANDINGS];
    const struct score_series *series = &truth->series;
    struct advise_members members = {0};
    uint64_t facts = 0xbef00000u + series->number;
    bool good = advised_begin(&members, series, false);
    members.runway.bump_ft = BUMP_FT;
    memset(known, 0, sizeof known);
    for (unsigned i = 0; good && i < series->landings; i++) {
        const struct score_landing *landing = &truth->landing[i];
        double off = score_normal(&facts);
        struct advised_known read = {
            .true_ft_s2 = advised_mean_ft_s2(landing, series->touchdown_ft)};
        advised_read(landing, &facts, &read);
        for (unsigned p = 0; p < PLANS; p++) {
            known[p][i] = read;
            known[p][i].plan_ft_s2 = read.true_ft_s2 * clamp(1.0 + plan_error[p] * off, 0.6, 1.5);
            take_facts(&work->told[p][work->count + i], p, series, landing, &known[p][i],
                       &members.runway);
        }
        tell_profile(landing, read.true_ft_s2, &known[HARDEST_TOLD][i].profile);
    }
    for (unsigned i = 0; good && !facts_alone && i < series->landings; i++) {
        advise_survey(&members, known[EXACT][i].sum_in, 0.005);
        good = say(work, truth, &members, known, i) &&
               (i + 1 == series->landings || advised_teach(&members, &truth->landing[i],
                                                           &known[EXACT][i], &known[EXACT][i + 1]));
    }
    work->count += series->landings;
    advise_members_free(&members);
    return good;
}

static bool play_all(struct work *work, unsigned from, unsigned to, bool facts_alone)
{
    static struct score_truth truth;
    for (unsigned n = from; n < to; n++) {
        if (work->count + SCORE_LANDINGS > LANDINGS ||
            !score_truth_get(&truth, n, SCORE_PLANAR, work->folder) ||
            !play(work, &truth, facts_alone))
            return false;
    }
    return true;
}

static bool play_trained(struct work *work, bool calibrates)
{
    for (unsigned i = 0; i < sizeof trained / sizeof trained[0]; i++) {
        if ((!calibrates || trained[i].calibrates) &&
            !play_all(work, trained[i].from, trained[i].to, !calibrates))
            return false;
    }
    return true;
}

/* --- tables --- */

static double area(const struct told *told, size_t count, unsigned from, const unsigned *times,
                   unsigned way, bool later)
{
    static float rank[20 * LANDINGS];
    static bool event[20 * LANDINGS];
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        for (unsigned t = 0; t < (times ? times[told[i].series - from] : 1u); t++) {
            if ((later && told[i].landing == 1) || n == 20 * LANDINGS || isnan(told[i].by[way]))
                continue;
            rank[n] = (float)told[i].by[way];
            event[n++] = told[i].wave;
        }
    }
    return score_auc(rank, event, n);
}

static void print_areas(const struct told *told, size_t count, unsigned from, unsigned series,
                        unsigned ways, bool later)
{
    static double lead[WAYS][BOOTSTRAPS];
    unsigned *times = calloc(series, sizeof *times);
    uint64_t state = 0xb0075000u;
    double own = area(told, count, from, NULL, BY_ADVICE, later);
    for (unsigned d = 0; times && d < BOOTSTRAPS; d++) {
        memset(times, 0, series * sizeof *times);
        for (unsigned s = 0; s < series; s++)
            times[(unsigned)(score_uniform(&state) * series)]++;
        double drawn = area(told, count, from, times, BY_ADVICE, later);
        for (unsigned w = 1; w < ways; w++)
            lead[w][d] = drawn - area(told, count, from, times, w, later);
    }
    for (unsigned w = 0; w < ways; w++) {
        double all = area(told, count, from, NULL, w, later);
        printf("  %-50s %.3f", way_names[w], all);
        if (w) {
            order_numbers(lead[w], BOOTSTRAPS);
            printf("   advice's lead %+.3f (%+.3f to %+.3f)", own - all, lead[w][BOOTSTRAPS / 40],
                   lead[w][BOOTSTRAPS - BOOTSTRAPS / 40 - 1]);
        }
        printf("\n");
    }
    free(times);
}

static void print_reliability(const struct told *told, size_t count, bool played)
{
    double said[5] = {0}, seen[5] = {0}, brier[WAYS] = {0}, events = 0.0;
    unsigned n[5] = {0};
    for (size_t i = 0; i < count; i++) {
        unsigned bin = (unsigned)fmin(5.0 * told[i].by[BY_ADVICE], 4.0);
        for (unsigned w = 0; w < WAYS; w++)
            brier[w] += pow(told[i].by[w] - told[i].wave, 2.0) / (double)count;
        said[bin] += told[i].by[BY_ADVICE];
        seen[bin] += told[i].wave;
        n[bin]++;
        events += told[i].wave / (double)count;
    }
    printf("  said, seen, landings:");
    for (unsigned b = 0; b < 5; b++)
        printf("%s %.2f %.2f %u", b ? ";" : "", n[b] ? said[b] / n[b] : (double)NAN,
               n[b] ? seen[b] / n[b] : (double)NAN, n[b]);
    printf("\n  Brier: advice %.3f, logistic %.3f, climatology %.3f", brier[BY_ADVICE],
           brier[BY_RULE], events * (1.0 - events));
    if (played)
        printf(", planar model %.3f", brier[BY_PLAYED]);
    printf("\n");
}

/* --- commands --- */

static const double *odds_of(const struct told *told)
{
    static double input[2];
    input[0] = 1.0;
    input[1] = log(told->by[BY_ADVICE] / (1.0 - told->by[BY_ADVICE]));
    return input;
}

/* Plays the series that constants are of, and fits each plan's rule to them. */
static bool fit_rules(struct work *work, double rule[PLANS][MOST_SIDES])
{
    double spread[MOST_SIDES][MOST_SIDES];
    if (!play_trained(work, false))
        return false;
    for (unsigned p = 0; p < PLANS; p++)
        fit(work->told[p], work->count, RULE_INPUTS, rule_of, rule[p], spread);
    return true;
}

static void print_plan(struct work *work, unsigned plan, const double *rule, unsigned from,
                       unsigned series)
{
    struct told *told = work->told[plan];
    bool played = work->played && plan == OFF_10;
    for (size_t i = 0; i < work->count; i++)
        told[i].by[BY_RULE] = chance_at(dot(rule, told[i].rule, RULE_INPUTS));
    printf("%s; area under the curve:\n", plan_names[plan]);
    print_areas(told, work->count, from, series, played ? WAYS : BY_PLAYED, false);
    printf("  from the second landing of a series on:\n");
    print_areas(told, work->count, from, series, played ? WAYS : BY_PLAYED, true);
    print_reliability(told, work->count, played);
}

static int print_fit(struct work *work)
{
    double rule[PLANS][MOST_SIDES], weight[MOST_SIDES], spread[MOST_SIDES][MOST_SIDES];
    if (!fit_rules(work, rule))
        return 5;
    fit(work->told[EXACT], work->count, ADVISE_WAVE_INPUTS, law_of, weight, spread);
    printf("law, %zu landings:", work->count);
    for (unsigned k = 0; k < ADVISE_WAVE_INPUTS; k++)
        printf(" %.3f", weight[k]);
    printf("\ncovariance:");
    for (unsigned k = 0; k < ADVISE_WAVE_INPUTS; k++) {
        for (unsigned j = 0; j < ADVISE_WAVE_INPUTS; j++)
            printf(" %.4f", spread[k][j]);
        printf(";");
    }
    /* thresholds of the mean and of the hardest deceleration, at the usual speed */
    double at = -weight[0] / weight[1];
    for (size_t i = 0; i < work->count; i++)
        work->told[EXACT][i].law[1] +=
            log(work->told[HARDEST_TOLD][i].by[BY_PLAN] / work->told[EXACT][i].by[BY_PLAN]);
    fit(work->told[EXACT], work->count, ADVISE_WAVE_INPUTS, law_of, weight, spread);
    printf("\nof the hardest deceleration:");
    for (unsigned k = 0; k < ADVISE_WAVE_INPUTS; k++)
        printf(" %.3f", weight[k]);
    printf("; its threshold is %.3f times the mean's\n", exp(-weight[0] / weight[1] - at));
    work->count = 0;
    if (!play_trained(work, true))
        return 5;
    for (unsigned p = 0; p < PLANS; p++) {
        print_plan(work, p, rule[p], 250, 350);
        fit(work->told[p], work->count, 2, odds_of, weight, spread);
        printf("  log odds that would have held: %.2f (%.2f) times those said, and %+.2f (%.2f)\n",
               weight[1], sqrt(spread[1][1]), weight[0], sqrt(spread[0][0]));
    }
    return 0;
}

static int print_score(struct work *work, unsigned from, unsigned series)
{
    double rule[PLANS][MOST_SIDES];
    if (!fit_rules(work, rule))
        return 5;
    work->count = 0;
    if (!play_all(work, from, from + series, false))
        return 5;
    size_t waves = 0;
    for (size_t i = 0; i < work->count; i++)
        waves += work->told[EXACT][i].wave;
    printf("bow waves before touchdown: %zu landings of series %u to %u, %zu with a wave\n",
           work->count, from, from + series - 1u, waves);
    for (unsigned p = 0; p < PLANS; p++)
        print_plan(work, p, rule[p], from, series);
    return 0;
}

int main(int argc, char **argv)
{
    struct work work = {.folder = argc > 1 ? argv[1] : NULL};
    bool fits = argc == 3 && strcmp(argv[2], "fit") == 0,
         scores = (argc == 5 || argc == 6) && strcmp(argv[2], "score") == 0;
    int from = scores ? atoi(argv[3]) : 0, series = scores ? atoi(argv[4]) : 0;
    work.played = argc == 6 ? (unsigned)atoi(argv[5]) : 0;
    if (!fits && (from < (int)FIRST_SCORED || from > 60000 || series < 1 || series > 1000)) {
        fprintf(stderr,
                "waves: usage: waves FOLDER fit | waves FOLDER score FROM COUNT [N] (series "
                "FROM, at least 700, and on; N members in the planar model)\n");
        return 2;
    }
    bool room = true;
    for (unsigned p = 0; p < PLANS; p++) {
        work.told[p] = calloc(LANDINGS, sizeof *work.told[p]);
        room = room && work.told[p];
    }
    int code = !room ? 5
             : fits  ? print_fit(&work)
                     : print_score(&work, (unsigned)from, (unsigned)series);
    for (unsigned p = 0; p < PLANS; p++)
        free(work.told[p]);
    return code;
}
