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

#include "host/ensemble/chains.h"
#include "tests/score/score.h"

#define MEMBERS     64
#define BATCHES     (MEMBERS / CHAINS_LANES)
#define STEP_S      (1e-3 / 6.0)
#define LOOK_STEPS  300u /* 50 ms */
#define SETTLE      6u
#define ONSET_S     0.06
#define AFTER_S     0.1
#define PLAN_ERROR  0.1
#define SPEED_ERROR 0.01
#define TOUCHDOWN   3.0
#define SLACK_FT    0.0025
#define GAP_MOST_FT 0.003
#define THETAS      3 /* logarithms of share, friction, mean resistance */
#define STATIONS    7 /* 40 to 100 ft */
#define READING_IN  0.003
#define MODEL_SHARE 0.15 /* what the chain does not explain of a movement */
#define INFLATION   1.1
#define TRAINED     200u /* series that the rule is fitted on */
#define FEATURES    5
#define BOOTSTRAPS  1000u

struct member {
    double theta[THETAS];
    float gap_ft[SCORE_JOINTS], grit_lb[SCORE_JOINTS]; /* grit: of mean 1 */
    double moved_in[STATIONS];
};

struct braking {
    double speed_ft_s, mean_ft_s2;
};

/* One landing as it is ranked. */
struct ranked {
    unsigned series, landing;
    bool event;
    double probability;
    double feature[FEATURES]; /* 1, plan, told friction, count, slack surveyed; scaled */
};

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static void draw_members(struct member *members, const struct score_series *series, uint64_t *state)
{
    for (unsigned m = 0; m < MEMBERS; m++) {
        struct member *member = &members[m];
        member->theta[0] = log(0.7 + 0.6 * score_uniform(state));
        member->theta[1] = log(series->told_friction) + 0.1 * score_normal(state);
        member->theta[2] = log(10.0) - 0.6 + score_uniform(state);
        for (unsigned j = 0; j < SCORE_JOINTS; j++) {
            member->gap_ft[j] = (float)fmin(GAP_MOST_FT * score_uniform(state), SLACK_FT);
            member->grit_lb[j] = (float)(2.0 * score_uniform(state));
        }
    }
}

/* Ten openings get the surveyed sum: all smaller by a factor, or all nearer to the slack by one. */
static void take_survey(struct member *member, const double *sum_ft)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float *gap_ft = member->gap_ft + MR_MATS_PER_SEGMENT * s;
        double most_ft = MR_MATS_PER_SEGMENT * SLACK_FT, had_ft = 0.0,
               sum = clamp(sum_ft[s], 0.0, most_ft);
        for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++)
            had_ft += (double)gap_ft[j];
        for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++) {
            double g = (double)gap_ft[j];
            if (had_ft >= sum)
                g *= had_ft > 0.0 ? sum / had_ft : 0.0;
            else
                g = SLACK_FT - (SLACK_FT - g) * (most_ft - sum) / (most_ft - had_ft);
            gap_ft[j] = (float)g;
        }
    }
}

static struct chains *start(const struct member *member)
{
    static float grit_lb[CHAINS_LANES][SCORE_JOINTS];
    struct mr_chain_params params[CHAINS_LANES];
    const float *gap[CHAINS_LANES], *grit[CHAINS_LANES];
    enum mr_status status;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        double mean_lb = exp(member[k].theta[2]);
        params[k] =
            (struct mr_chain_params){.mats = SCORE_MATS,
                                     .mat_length_ft = (float)SCORE_MAT_FT,
                                     .mass_slug = 0.466f / 32.174f,
                                     .friction_lb = (float)(0.466 * exp(member[k].theta[1])),
                                     .kl_lb_ft = 2.9e5f,
                                     .cl_lb_s_ft = 5.0f,
                                     .slack_ft = (float)SLACK_FT,
                                     .step_s = (float)STEP_S};
        for (unsigned j = 0; j < SCORE_JOINTS; j++)
            grit_lb[k][j] = (float)(mean_lb * (double)member[k].grit_lb[j]);
        gap[k] = member[k].gap_ft;
        grit[k] = grit_lb[k];
    }
    struct chains *chains = chains_new(params, gap, grit, &status);
    if (!chains)
        abort();
    return chains;
}

/* The gear of a lane, `t_s` after touchdown: brakes with an onset, then evenly. */
struct gear {
    double speed_ft_s, braking_ft_s2, thrust_lb, at_ft;
};

static void roll(struct gear *gear, double t_s, unsigned *mat, float *thrust_lb)
{
    double part = fmin(t_s / ONSET_S, 1.0), a = part * part * (3.0 - 2.0 * part);
    *mat = (unsigned)(gear->at_ft / SCORE_MAT_FT) + 1u;
    *thrust_lb = gear->speed_ft_s > 0.0 ? (float)(gear->thrust_lb * a) : 0.0f;
    gear->at_ft += fmax(gear->speed_ft_s, 0.0) * STEP_S;
    gear->speed_ft_s -= gear->braking_ft_s2 * a * STEP_S;
}

static bool at_zone(const struct chains *chains, unsigned lane, const struct gear *gear)
{
    uint16_t gap_hmil[SCORE_JOINTS];
    if (!(gear->speed_ft_s > SCORE_SLOW_FT_S))
        return false;
    for (unsigned j = 0; j < SCORE_JOINTS; j++)
        gap_hmil[j] = (uint16_t)fmin(
            fmax(12e5 * (double)chains_opening_ft(chains, lane, j + 1u), 0.0) + 0.5, 65535.0);
    struct score_zone zone = score_longest(gap_hmil, gear->at_ft);
    return zone.last - zone.first >= SCORE_EVENT_MATS &&
           zone.first * SCORE_MAT_FT - gear->at_ft < SCORE_EVENT_FT;
}

/* Runs eight members through a landing; how many come to a zone. Their joints are left as they were
 * unless `keeps`. */
static unsigned land(struct member *member, const struct braking *braking, bool keeps)
{
    struct chains *chains = start(member);
    struct gear gear[CHAINS_LANES];
    bool met[CHAINS_LANES] = {false};
    unsigned mat[CHAINS_LANES], events = 0;
    float thrust_lb[CHAINS_LANES];
    double longest_s = 0.0;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        double a = braking[k].mean_ft_s2;
        gear[k] = (struct gear){braking[k].speed_ft_s, a,
                                exp(member[k].theta[0]) * 1300.0 / 12.0 * a / 32.174, TOUCHDOWN};
        longest_s = fmax(longest_s, braking[k].speed_ft_s / a + ONSET_S + AFTER_S);
    }
    for (unsigned step = 0; (double)step * STEP_S < longest_s; step++) {
        for (unsigned k = 0; k < CHAINS_LANES; k++)
            roll(&gear[k], (double)step * STEP_S, &mat[k], &thrust_lb[k]);
        chains_step(chains, mat, thrust_lb);
        if (step % SETTLE == SETTLE - 1u)
            chains_settle(chains);
        for (unsigned k = 0; step % LOOK_STEPS == 0 && k < CHAINS_LANES; k++)
            met[k] = met[k] || at_zone(chains, k, &gear[k]);
    }
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        events += met[k];
        for (unsigned i = 0; i < STATIONS; i++)
            member[k].moved_in[i] = 12.0 * (double)chains_displacement_ft(
                                               chains, k,
                                               (unsigned)((40.0 + 10.0 * i) / SCORE_MAT_FT) + 1u);
        for (unsigned j = 0; keeps && j < SCORE_JOINTS; j++)
            member[k].gap_ft[j] = (float)clamp((double)chains_opening_ft(chains, k, j + 1u), 0.0,
                                               SLACK_FT);
    }
    chains_free(chains);
    return events;
}

/* Solves a x = b (symmetric, positive) in place by Cholesky's way; b becomes x. */
static void solve(double a[STATIONS][STATIONS], double b[STATIONS])
{
    for (int i = 0; i < STATIONS; i++) {
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
    for (int i = STATIONS - 1; i >= 0; i--) {
        for (int k = i + 1; k < STATIONS; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

/* What the transducers say of the parameters. */
static void learn(struct member *members, const double *read_in, uint64_t *state)
{
    double mean_y[STATIONS] = {0}, mean_t[THETAS] = {0};
    double yy[STATIONS][STATIONS] = {{0}}, ty[THETAS][STATIONS] = {{0}}, error_in[STATIONS];
    for (unsigned m = 0; m < MEMBERS; m++) {
        for (int i = 0; i < STATIONS; i++)
            mean_y[i] += members[m].moved_in[i] / MEMBERS;
        for (int t = 0; t < THETAS; t++)
            mean_t[t] += members[m].theta[t] / MEMBERS;
    }
    for (unsigned m = 0; m < MEMBERS; m++) {
        for (int i = 0; i < STATIONS; i++) {
            double y = members[m].moved_in[i] - mean_y[i];
            for (int k = 0; k < STATIONS; k++)
                yy[i][k] += y * (members[m].moved_in[k] - mean_y[k]) / (MEMBERS - 1);
            for (int t = 0; t < THETAS; t++)
                ty[t][i] += y * (members[m].theta[t] - mean_t[t]) / (MEMBERS - 1);
        }
    }
    for (int i = 0; i < STATIONS; i++) {
        error_in[i] = hypot(READING_IN, MODEL_SHARE * fmax(read_in[i], mean_y[i]) + 0.01);
        yy[i][i] += error_in[i] * error_in[i];
    }
    for (unsigned m = 0; m < MEMBERS; m++) {
        double a[STATIONS][STATIONS], b[STATIONS];
        memcpy(a, yy, sizeof a);
        for (int i = 0; i < STATIONS; i++)
            b[i] = read_in[i] + error_in[i] * score_normal(state) - members[m].moved_in[i];
        solve(a, b);
        for (int t = 0; t < THETAS; t++) {
            double moved = 0.0;
            for (int i = 0; i < STATIONS; i++)
                moved += ty[t][i] * b[i];
            members[m].theta[t] += clamp(moved, -0.5, 0.5);
        }
    }
    for (int t = 0; t < THETAS; t++) {
        double mean = 0.0;
        for (unsigned m = 0; m < MEMBERS; m++)
            mean += members[m].theta[t] / MEMBERS;
        for (unsigned m = 0; m < MEMBERS; m++)
            members[m].theta[t] = mean + INFLATION * (members[m].theta[t] - mean);
    }
}

static bool has_event(const struct score_landing *landing)
{
    for (unsigned k = 0; k < landing->looks; k++) {
        double wheel_ft = (double)landing->wheel_ft[k];
        struct score_zone zone = score_longest(landing->gap_hmil[k], wheel_ft);
        if (wheel_ft > 0.0 && zone.first * SCORE_MAT_FT - wheel_ft < SCORE_EVENT_FT &&
            (double)landing->speed_at_ft_s[k] > SCORE_SLOW_FT_S &&
            zone.last - zone.first >= SCORE_EVENT_MATS)
            return true;
    }
    return false;
}

static double mean_braking_ft_s2(const struct score_landing *landing, double touchdown_ft)
{
    return landing->speed_ft_s * landing->speed_ft_s / 2.0 / (landing->stop_ft - touchdown_ft);
}

/* The landing's facts; the event is of its truth. */
static void take_facts(struct ranked *ranked, const struct score_series *series,
                       const struct score_landing *landing, double plan_ft_s2, const double *sum_ft)
{
    double slack_ft = 0.0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack_ft += sum_ft[s];
    *ranked = (struct ranked){.series = series->number,
                              .landing = landing->number,
                              .event = has_event(landing),
                              .feature = {1.0, plan_ft_s2 / 6.0, series->told_friction / 0.6,
                                          landing->number / 3.0, slack_ft}};
}

/* All landings of a series; `members` NULL: facts alone. */
static void play(const struct score_truth *truth, struct member *members, struct ranked *ranked,
                 size_t *count)
{
    const struct score_series *series = &truth->series;
    uint64_t facts = 0xbef00000u + series->number, state = 0xd2a30000u + series->number;
    if (members)
        draw_members(members, series, &state);
    for (unsigned i = 0; i < series->landings; i++) {
        const struct score_landing *landing = &truth->landing[i];
        double sum_ft[MR_SEGMENTS],
            true_ft_s2 = mean_braking_ft_s2(landing, series->touchdown_ft),
            plan_ft_s2 = true_ft_s2 * clamp(1.0 + PLAN_ERROR * score_normal(&facts), 0.6, 1.5);
        struct braking braking[MEMBERS];
        for (unsigned s = 0; s < MR_SEGMENTS; s++) {
            sum_ft[s] = 0.005 / 12.0 * score_normal(&facts);
            for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++)
                sum_ft[s] += (double)landing->gap_in[s * MR_MATS_PER_SEGMENT + j] / 12.0;
        }
        take_facts(&ranked[*count], series, landing, plan_ft_s2, sum_ft);
        for (unsigned m = 0; members && m < MEMBERS; m++) {
            take_survey(&members[m], sum_ft);
            braking[m] = (struct braking){
                landing->speed_ft_s * (1.0 + SPEED_ERROR * score_normal(&state)),
                plan_ft_s2 * clamp(1.0 + PLAN_ERROR * score_normal(&state), 0.6, 1.5)};
        }
        for (unsigned b = 0; members && b < BATCHES; b++)
            ranked[*count].probability += land(members + CHAINS_LANES * b,
                                               braking + CHAINS_LANES * b, false) /
                                          (double)MEMBERS;
        (*count)++;
        if (!members || i + 1 == series->landings)
            continue;
        double read_in[STATIONS];
        for (unsigned s = 0; s < STATIONS; s++)
            read_in[s] = (double)landing->u_in[landing->rows - 1][3 + s] +
                         READING_IN * score_normal(&facts);
        for (unsigned m = 0; m < MEMBERS; m++)
            braking[m] = (struct braking){landing->speed_ft_s, true_ft_s2};
        for (unsigned b = 0; b < BATCHES; b++)
            land(members + CHAINS_LANES * b, braking + CHAINS_LANES * b, true);
        learn(members, read_in, &state);
    }
}

/* Logistic regression by Newton's steps, slightly drawn to 0. */
static void fit_rule(const struct ranked *ranked, size_t count, double *weight)
{
    memset(weight, 0, FEATURES * sizeof *weight);
    for (unsigned round = 0; round < 25; round++) {
        double a[STATIONS][STATIONS] = {{0}}, b[STATIONS] = {0};
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
        for (int k = 0; k < STATIONS; k++) {
            a[k][k] += k < FEATURES ? 1e-3 : 1.0;
            b[k] -= k < FEATURES ? 1e-3 * weight[k] : 0.0;
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

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
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
            qsort(lead[w], BOOTSTRAPS, sizeof lead[w][0], by_size);
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

int main(int argc, char **argv)
{
    static struct score_truth truth;
    static struct member members[MEMBERS];
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
        play(&truth, NULL, ranked, &count);
    }
    fit_rule(ranked, count, weight);
    count = 0;
    for (unsigned n = from; n < from + series && code == 0; n++) {
        code = score_truth_get(&truth, n, kind, argv[1]) ? 0 : 5;
        play(&truth, members, ranked, &count);
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
    free(ranked);
    return 0;
}
