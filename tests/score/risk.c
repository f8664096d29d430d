/* risk: how good the risk is that the board states during a landing (common/risk.h). See README.md,
 * "Risk during the landing".
 *
 *   risk FOLDER charts KIND FROM COUNT   what `matrig advise` says before the landings of series
 *                                        FROM .. FROM + COUNT - 1, kept in FOLDER; KIND: chain,
 *                                        late, elastic
 *   risk FOLDER fit                      weights for common/risk_weights.def on stdout, from series
 *                                        100 to 249, chain and late
 *   risk FOLDER score KIND FROM COUNT [PLAN]   the table, on series that did not make the weights;
 *                                        PLAN: rms error of the plan, 0.1
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/risk.h"
#include "tests/score/advised.h"

#define FIT_FROM   100u
#define FIT_COUNT  150u
#define PLAN_ERROR 0.1
#define TOUCHDOWN  3.0f
#define ROWS       2
#define SAMPLES    1500000u
#define BOOTSTRAPS 400u
#define VIEWS      6u

/* What is given to the board. */
enum mode { BY_NOTHING, BY_PLAN, BY_CHART, MODES };
/* Ranks that cost nothing more than the board has today. */
enum other { COMING, KINEMATIC, BRAKING, PRIOR, OTHERS };
enum when { BEFORE, HALF, ONE, TWO, WHENS };
static const double when_s[WHENS] = {-0.05, 0.5, 1.0, 2.0};

struct sample {
    float input[MR_RISK_INPUTS], risk, other[OTHERS];
    float since_s, until_s; /* from touchdown; to the event, NaN: none */
    uint16_t series;
    uint8_t landing, view, mode, set;
};

struct chart {
    double mean_ft_s2[ROWS], odds[ROWS], half_ft[ROWS];
};

static struct sample *sample;
static size_t samples;

static const struct {
    const char *name;
    enum score_kind kind;
} kinds[] = {{"chain", SCORE_CHAIN}, {"late", SCORE_LATE}, {"elastic", SCORE_ELASTIC}};

static const char *name_of(enum score_kind kind)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (kinds[i].kind == kind)
            return kinds[i].name;
    }
    return "planar";
}

/* --- plans and charts --- */

/* As the plan was told: off by a factor, and in when it changes. */
static void draw_plan(const struct score_landing *landing, uint32_t series, double error,
                      struct mr_risk_plan *plan)
{
    uint64_t state = 0x91a40000u + 8u * series + landing->number;
    double factor = fmin(fmax(1.0 + error * score_normal(&state), 0.5), 1.6),
           bend = fmin(fmax(1.0 + error * score_normal(&state), 0.5), 1.6);
    mr_risk_plan_clear(plan);
    plan->landings = (float)(landing->number - 1u);
    plan->speed_ft_s =
        (float)(landing->speed_ft_s * fmin(fmax(1.0 + 0.01 * score_normal(&state), 0.9), 1.1));
    for (unsigned i = 0; i < SCORE_KNOTS; i++) {
        plan->knot_s[i] = landing->knot_s[i] * (float)bend;
        plan->knot_ft_s2[i] = landing->knot_ft_s2[i] * (float)factor;
    }
}

static double plan_ft_s2(const struct mr_risk_plan *plan, double t_s)
{
    const float *t = plan->knot_s, *a = plan->knot_ft_s2;
    if (t_s <= (double)t[0])
        return (double)a[0];
    for (unsigned i = 1; i < SCORE_KNOTS; i++) {
        if (t_s < (double)t[i])
            return (double)a[i - 1] +
                   (double)(a[i] - a[i - 1]) * (t_s - (double)t[i - 1]) / (double)(t[i] - t[i - 1]);
    }
    return (double)a[SCORE_KNOTS - 1];
}

static double plan_mean_ft_s2(const struct mr_risk_plan *plan)
{
    double v_ft_s = (double)plan->speed_ft_s, way_ft = 0.0;
    for (double t_s = 0.0; v_ft_s > 0.0 && t_s < 60.0; t_s += 1e-3) {
        way_ft += v_ft_s * 1e-3;
        v_ft_s -= 1e-3 * plan_ft_s2(plan, t_s);
    }
    return 0.5 * (double)plan->speed_ft_s * (double)plan->speed_ft_s / way_ft;
}

static bool make_charts(const struct score_truth *truth, struct chart *chart)
{
    static const double factors[ROWS] = {0.85, 1.2};
    struct advise_members members = {0};
    struct advised_known known[SCORE_LANDINGS];
    double log_ratio[SCORE_LANDINGS];
    uint64_t facts = 0xc4a70000u + truth->series.number;
    memset(known, 0, sizeof known);
    for (unsigned i = 0; i < truth->series.landings; i++) {
        struct mr_risk_plan plan;
        draw_plan(&truth->landing[i], truth->series.number, PLAN_ERROR, &plan);
        known[i].plan_ft_s2 = plan_mean_ft_s2(&plan);
        known[i].true_ft_s2 = advised_mean_ft_s2(&truth->landing[i], truth->series.touchdown_ft);
        known[i].profile.count = SCORE_KNOTS;
        for (unsigned k = 0; k < SCORE_KNOTS; k++) {
            known[i].profile.t_s[k] = (double)plan.knot_s[k];
            known[i].profile.factor[k] = (double)plan.knot_ft_s2[k] / known[i].plan_ft_s2;
        }
        advised_read(&truth->landing[i], &facts, &known[i]);
        log_ratio[i] = log(known[i].true_ft_s2 / known[i].plan_ft_s2);
    }
    bool good = advised_begin(&members, &truth->series);
    for (unsigned i = 0; good && i < truth->series.landings; i++) {
        struct advise_plan plan;
        struct advise_row row;
        advised_plan(&plan, &truth->landing[i], &known[i], log_ratio, i);
        for (unsigned r = 0; good && r < ROWS; r++) {
            double mean_ft_s2 = factors[r] * known[i].plan_ft_s2;
            good = advised_say(&members, &plan, &known[i], mean_ft_s2, &row);
            chart[i].mean_ft_s2[r] = mean_ft_s2;
            chart[i].odds[r] = log(row.zone.p / (1.0 - row.zone.p));
            chart[i].half_ft[r] = row.half_ft;
        }
        if (good && i + 1 < truth->series.landings)
            good = advised_teach(&members, &truth->landing[i], &known[i], &known[i + 1]);
    }
    advise_members_free(&members);
    return good;
}

static void chart_path(char *path, size_t size, const char *folder, enum score_kind kind,
                       uint32_t number)
{
    snprintf(path, size, "%s/chart-%s-%u.bin", folder, name_of(kind), number);
}

static bool read_charts(const char *folder, enum score_kind kind, uint32_t number,
                        struct chart *chart)
{
    char path[512];
    chart_path(path, sizeof path, folder, kind, number);
    FILE *file = fopen(path, "rb");
    bool good = file && fread(chart, sizeof *chart, SCORE_LANDINGS, file) == SCORE_LANDINGS;
    if (file)
        fclose(file);
    return good;
}

static int charts(const char *folder, enum score_kind kind, unsigned from, unsigned count)
{
    static struct score_truth truth;
    for (unsigned n = from; n < from + count; n++) {
        struct chart chart[SCORE_LANDINGS];
        char path[512];
        if (read_charts(folder, kind, n, chart))
            continue;
        memset(chart, 0, sizeof chart);
        if (!score_truth_get(&truth, n, kind, folder) || !make_charts(&truth, chart))
            return 5;
        chart_path(path, sizeof path, folder, kind, n);
        FILE *file = fopen(path, "wb");
        if (!file || fwrite(chart, sizeof *chart, SCORE_LANDINGS, file) != SCORE_LANDINGS ||
            fclose(file))
            return 5;
    }
    return 0;
}

/* --- playing --- */

struct listener {
    const struct score_truth *truth;
    const struct score_landing *landing;
    const struct chart *chart; /* NULL: none */
    double plan_error;
    unsigned view;
    struct mr_risk_state risk[MODES];
    float event_s, prior;
    unsigned modes;
};

static void on_look(void *ctx, const struct score_look *look)
{
    (void)ctx;
    (void)look;
}

static void on_outcome(void *ctx, const struct score_outcome *outcome)
{
    (void)ctx;
    (void)outcome;
}

static void on_armed(void *ctx, const struct mr_predictor *predictor,
                     const struct score_landing *landing)
{
    struct listener *l = ctx;
    struct mr_risk_plan plan;
    l->landing = landing;
    l->event_s = (float)score_event_s(landing);
    draw_plan(landing, l->truth->series.number, l->plan_error, &plan);
    plan.landings = (float)predictor->landings;
    l->modes = l->chart && l->view & SCORE_SURVEYED ? MODES : BY_CHART;
    mr_risk_arm(&l->risk[BY_NOTHING], NULL, predictor, TOUCHDOWN);
    mr_risk_arm(&l->risk[BY_PLAN], &plan, predictor, TOUCHDOWN);
    l->prior = NAN;
    if (l->modes == MODES) {
        const struct chart *chart = &l->chart[landing->number - 1u];
        for (unsigned r = 0; r < ROWS; r++) {
            plan.row_ft_s2[r] = (float)chart->mean_ft_s2[r];
            plan.row_odds[r] = (float)chart->odds[r];
            plan.row_ft[r] = (float)chart->half_ft[r];
        }
        l->prior = (plan.row_odds[0] + plan.row_odds[1]) / 2.0f;
        mr_risk_arm(&l->risk[BY_CHART], &plan, predictor, TOUCHDOWN);
    }
}

static void on_block(void *ctx, const struct mr_predictor *predictor,
                     const struct mr_predictor_input *input, unsigned ms)
{
    struct listener *l = ctx;
    struct mr_predictor_zone zone;
    double t_s = 1e-3 * ms;
    for (unsigned m = 0; m < l->modes; m++)
        mr_risk_block(&l->risk[m], predictor, input);
    if (ms % SCORE_LOOK_MS || ms / SCORE_LOOK_MS >= l->landing->looks || t_s >= (double)l->event_s)
        return;
    mr_predictor_zone(predictor, &zone);
    for (unsigned m = 0; m < l->modes && samples < SAMPLES; m++) {
        struct mr_risk_said said;
        struct mr_closure_zone closed;
        float left_in[MR_SEGMENTS];
        mr_risk_say(&l->risk[m], predictor, &zone, &said);
        if (said.basis & MR_RISK_STOPPED)
            continue;
        mr_predictor_find_kinematic(predictor, &closed, left_in);
        struct sample *s = &sample[samples++];
        *s = (struct sample){.risk = said.risk,
                             .other = {(float)zone.coming_mats, (float)closed.mats,
                                       predictor->deceleration_ft_s2, l->prior},
                             .since_s = (float)(t_s - l->landing->touchdown_s),
                             .until_s = l->event_s - (float)t_s,
                             .series = (uint16_t)l->truth->series.number,
                             .landing = (uint8_t)l->landing->number,
                             .view = (uint8_t)l->view,
                             .mode = (uint8_t)m,
                             .set = (uint8_t)said.set};
        memcpy(s->input, said.input, sizeof s->input);
    }
}

static bool play(const char *folder, enum score_kind kind, unsigned from, unsigned count,
                 double plan_error, unsigned views)
{
    static struct score_truth truth;
    for (unsigned n = from; n < from + count; n++) {
        struct chart chart[SCORE_LANDINGS];
        struct listener l = {.truth = &truth, .plan_error = plan_error};
        const struct score_sink sink = {on_look, on_outcome, on_armed, on_block, &l};
        if (!score_truth_get(&truth, n, kind, folder))
            return false;
        l.chart = read_charts(folder, kind, n, chart) ? chart : NULL;
        for (unsigned view = 0; view < views; view++) {
            l.view = view;
            score_play(&truth, view, 0, &sink);
        }
    }
    return true;
}

/* --- fitting --- */

/* Solves a x = b (symmetric, positive) in place by Cholesky's way; b becomes x. */
static void solve(double a[MR_RISK_INPUTS][MR_RISK_INPUTS], double *b)
{
    for (int i = 0; i < (int)MR_RISK_INPUTS; i++) {
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
    for (int i = (int)MR_RISK_INPUTS - 1; i >= 0; i--) {
        for (int k = i + 1; k < (int)MR_RISK_INPUTS; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

/* Logistic regression by Newton's steps, drawn to 0 by a ridge: neighbouring looks tell the same,
 * so that thousands of them are not thousands of landings. */
static void fit_set(unsigned set, double *weight)
{
    memset(weight, 0, MR_RISK_INPUTS * sizeof *weight);
    for (unsigned round = 0; round < 30; round++) {
        double a[MR_RISK_INPUTS][MR_RISK_INPUTS] = {{0}}, b[MR_RISK_INPUTS] = {0};
        for (size_t i = 0; i < samples; i++) {
            const float *x = sample[i].input;
            double sum = 0.0;
            if (sample[i].set != set)
                continue;
            for (unsigned k = 0; k < MR_RISK_INPUTS; k++)
                sum += weight[k] * (double)x[k];
            double p = 1.0 / (1.0 + exp(-sum)), off = !isnan(sample[i].until_s) - p;
            for (unsigned k = 0; k < MR_RISK_INPUTS; k++) {
                b[k] += off * (double)x[k];
                for (unsigned j = 0; j < MR_RISK_INPUTS; j++)
                    a[k][j] += p * (1.0 - p) * (double)x[k] * (double)x[j];
            }
        }
        for (unsigned k = 0; k < MR_RISK_INPUTS; k++) {
            a[k][k] += 10.0;
            b[k] -= 10.0 * weight[k];
        }
        solve(a, b);
        for (unsigned k = 0; k < MR_RISK_INPUTS; k++)
            weight[k] += b[k];
    }
}

static int fit(const char *folder)
{
    if (!play(folder, SCORE_CHAIN, FIT_FROM, FIT_COUNT, PLAN_ERROR, VIEWS) ||
        !play(folder, SCORE_LATE, FIT_FROM, FIT_COUNT, PLAN_ERROR, VIEWS))
        return 5;
    printf(
        "/* Weights of common/risk.c, a row for each set, a column for each input: made by\n"
        " * `build/tests/score/risk build/score fit` (tests/score/README.md), which says on what. "
        "*/\n\n");
    for (unsigned set = 0; set < MR_RISK_SETS; set++) {
        double weight[MR_RISK_INPUTS];
        fit_set(set, weight);
        printf("{");
        for (unsigned k = 0; k < MR_RISK_INPUTS; k++)
            printf("%s%.4ff", k ? ", " : "", weight[k]);
        printf("},\n");
    }
    return 0;
}

/* --- the table --- */

/* The look of a moment: the last one up to it. */
static bool is_at(const struct sample *s, enum when when)
{
    double off = (double)s->since_s - when_s[when];
    return off > -0.026 && off <= 0.0251;
}

/* The samples of a view, a mode and a moment. */
static const struct sample *here[100000];
static size_t heres;

static void gather(unsigned view, enum mode mode, enum when when)
{
    heres = 0;
    for (size_t i = 0; i < samples && heres < sizeof here / sizeof here[0]; i++) {
        const struct sample *s = &sample[i];
        if (s->view == view && s->mode == mode && is_at(s, when))
            here[heres++] = s;
    }
}

/* Area of a rank among those whose event is half a second away at least; `times`: how often each
 * series counts, NULL: once. */
static double area(int other, unsigned from, const unsigned *times)
{
    static float rank[400000];
    static bool event[400000];
    size_t n = 0;
    for (size_t i = 0; i < heres; i++) {
        const struct sample *s = here[i];
        if ((double)s->until_s < 0.5)
            continue;
        for (unsigned t = 0; t < (times ? times[s->series - from] : 1u) && n < 400000; t++) {
            rank[n] = other < 0 ? s->risk : s->other[other];
            rank[n] = isnan(rank[n]) ? 0.0f : rank[n];
            event[n++] = !isnan(s->until_s);
        }
    }
    return score_auc(rank, event, n);
}

static void print_lead(unsigned from, unsigned count)
{
    double lead[BOOTSTRAPS];
    unsigned *times = calloc(count, sizeof *times);
    uint64_t state = 0xb0075000u;
    for (unsigned d = 0; times && d < BOOTSTRAPS; d++) {
        memset(times, 0, count * sizeof *times);
        for (unsigned s = 0; s < count; s++)
            times[(unsigned)(score_uniform(&state) * count)]++;
        lead[d] = area(-1, from, times) - area(COMING, from, times);
        for (unsigned k = d; k > 0 && lead[k] < lead[k - 1]; k--) {
            double swap = lead[k];
            lead[k] = lead[k - 1];
            lead[k - 1] = swap;
        }
    }
    printf("  %+.3f to %+.3f", lead[BOOTSTRAPS / 40], lead[BOOTSTRAPS - BOOTSTRAPS / 40 - 1]);
    free(times);
}

static void print_moment(unsigned view, enum mode mode, enum when when, unsigned from,
                         unsigned count)
{
    double brier = 0.0, said[5] = {0}, seen[5] = {0};
    unsigned n[5] = {0}, all = 0, events = 0;
    gather(view, mode, when);
    for (size_t i = 0; i < heres; i++) {
        const struct sample *s = here[i];
        if (isnan(s->risk))
            continue;
        bool event = !isnan(s->until_s);
        double off = (double)s->risk - event;
        unsigned bin = (unsigned)fmin(5.0 * (double)s->risk, 4.0);
        brier += off * off;
        said[bin] += (double)s->risk;
        seen[bin] += event;
        n[bin]++;
        all++;
        events += event;
    }
    if (!all)
        return;
    double rate = (double)events / all;
    printf("  %u %u  %.3f | %.3f %.3f %.3f %.3f |", all, events, area(-1, from, NULL),
           area(COMING, from, NULL), area(KINEMATIC, from, NULL), area(BRAKING, from, NULL),
           area(PRIOR, from, NULL));
    print_lead(from, count);
    printf(" | Brier %.3f of %.3f |", brier / all, rate * (1.0 - rate));
    for (unsigned b = 0; b < 5; b++)
        printf(" %.2f %.2f %u", n[b] ? said[b] / n[b] : (double)NAN,
               n[b] ? seen[b] / n[b] : (double)NAN, n[b]);
    printf("\n");
}

static int score(const char *folder, enum score_kind kind, unsigned from, unsigned count,
                 double plan_error)
{
    static const char *const views[VIEWS] = {"no survey, 40 to 110", "survey, 40 to 110",
                                             "no survey, 10 to 70",  "survey, 10 to 70",
                                             "no survey, blind",     "survey, blind"},
                             *const modes[MODES] = {"nothing", "plan", "chart"},
                             *const whens[WHENS] = {"before", "0.5 s", "1 s", "2 s"};
    if (!play(folder, kind, from, count, plan_error, VIEWS))
        return 5;
    printf("view, given, when: landings at risk, events; area: risk | zone coming, kinematic, "
           "braking, chart | risk less zone coming, 95 %% | Brier, of climatology | said, seen, "
           "landings in fifths\n");
    for (unsigned view = 0; view < VIEWS; view++) {
        for (unsigned mode = 0; mode < MODES; mode++) {
            for (unsigned when = 0; when < WHENS; when++) {
                printf("%s, %s, %s:", views[view], modes[mode], whens[when]);
                print_moment(view, (enum mode)mode, (enum when)when, from, count);
                printf("\n");
            }
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    enum score_kind kind = SCORE_PLANAR;
    for (size_t i = 0; argc > 3 && i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(argv[3], kinds[i].name) == 0)
            kind = kinds[i].kind;
    }
    sample = calloc(SAMPLES, sizeof *sample);
    if (!sample)
        return 5;
    if (argc == 3 && strcmp(argv[2], "fit") == 0)
        return fit(argv[1]);
    if (argc >= 6 && kind != SCORE_PLANAR && atoi(argv[4]) >= 0 && atoi(argv[5]) > 0) {
        unsigned from = (unsigned)atoi(argv[4]), count = (unsigned)atoi(argv[5]);
        if (strcmp(argv[2], "charts") == 0 && argc == 6)
            return charts(argv[1], kind, from, count);
        if (strcmp(argv[2], "score") == 0)
            return score(argv[1], kind, from, count, argc > 6 ? atof(argv[6]) : PLAN_ERROR);
    }
    fprintf(stderr, "risk: usage: risk FOLDER fit | FOLDER charts|score chain|late|elastic FROM "
                    "COUNT [PLAN]\n");
    return 2;
}
