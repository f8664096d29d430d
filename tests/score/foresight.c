/* foresight: how good it is what matrig says of a landing before touchdown and during it, on truths
 * that are not its own and with knowledge that is off. See README.md, "Foresight".
 *
 *   foresight FOLDER learn                      what the baselines are fitted on: facts of series
 *                                               100 to 249, kept in FOLDER
 *   foresight FOLDER play FROM COUNT [ROW]...   what is said of the landings of series FROM ..
 *                                               FROM + COUNT - 1, kept in FOLDER; all rows or some
 *   foresight FOLDER table FROM COUNT           tables on stdout, of what was played
 *   foresight FOLDER odds FROM COUNT OTHER COUNT ROW   the log odds that would have held for series
 *                                               FROM and on, and how they hold for OTHER and on
 *
 * Exit: 0; 2 usage; 3 files; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/score/advised.h"
#include "tests/score/stats.h"

/* Of a landing: before touchdown, and so long after it. */
enum foresight_when { BEFORE, HALF, ONE, TWO, WHENS };

/* What is known without a model of the runway, and the board's zone to come; about 1 in size. */
enum foresight_fact {
    FACT_ONE,
    FACT_PLAN,      /* planned mean deceleration */
    FACT_HARDEST,   /* the hardest that is planned */
    FACT_BRAKING,   /* measured */
    FACT_COUNT,     /* of landings */
    FACT_KINEMATIC, /* zone closed by transducers and survey alone */
    FACT_SPEED,     /* now; before touchdown planned */
    FACT_FRICTION,  /* told */
    FACT_COMING,    /* zone to come by the board's predictor */
    FACT_SLACK,     /* surveyed, sum of the runway; 0: none */
    FACTS
};

/* Who says how probable an event is. */
enum foresight_by {
    BY_ENSEMBLE, /* of `matrig advise`: before touchdown, and never changed */
    BY_BOARD,    /* the board's risk, with plan and chart */
    BY_COMBINED, /* logistic rule of all facts */
    BY_PLANNED,  /* the board's risk with a plan alone, */
    BY_NOTHING,  /* and with neither */
    BY_FACT      /* and on: of one of them each */
};

struct foresight_said {
    float fact[FACTS];
    /* NaN: not said; share: of the members, as counted */
    float ensemble, share, board, planned, nothing;
    float until_s; /* to the event; NaN: none comes */
    uint16_t series;
    uint8_t landing, when;
};

/* A row of the score: what is perturbed. */
struct foresight_row {
    const char *name, *text;
    enum score_kind kind;
    struct advised_told told;
};
#define FORESIGHT_ROWS 15u

struct foresight_list {
    struct foresight_said *said;
    size_t count;
    uint32_t series; /* so many */
};

/* Landings of a row that are still at risk at a moment, as they are scored: the event is half a
 * second away or more. */
struct foresight_moment {
    size_t count, events;
    float *by[BY_FACT + FACTS]; /* probabilities; climatology stands in FACT_ONE's place */
    bool *event;
    uint16_t *series;
};

#define VERSION    1u
#define LEARN_FROM 100u
#define LEARN_OF   150u
#define TOUCHDOWN  3.0f
#define ZONE_MATS  50.0f
#define AT_PLAN    1u /* the factor that is 1 */

static const double factors[ADVISED_ROWS] = {0.8, 1.0, 1.35};
static const double when_s[WHENS] = {-0.05, 0.5, 1.0, 2.0};

#define SURVEYED SCORE_SURVEYED
/* told: survey and transducers, friction over what is told otherwise, rms error of the plan, braked
 * so many times harder than planned, share of the thrust measured */
static const struct foresight_row foresight_rows[FORESIGHT_ROWS] = {
    {"plain", "nothing perturbed; plan off by 10 %", SCORE_CHAIN, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"shut", "runway nearly closed", SCORE_SHUT, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"patchy", "gaps in patches", SCORE_PATCHY, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"heavy", "resistance with a heavy tail", SCORE_HEAVY, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"pulsed", "anti-skid pulses", SCORE_PULSED, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"late", "light, then hard braking", SCORE_LATE, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"elastic",
     "elastic ground, gear with weight",
     SCORE_ELASTIC,
     {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"planar", "planar engine, until a wave", SCORE_PLANAR, {SURVEYED, 1.0, 0.1, 1.0, false}},
    {"friction", "friction told 25 % too high", SCORE_CHAIN, {SURVEYED, 1.25, 0.1, 1.0, false}},
    {"plan", "plan off by 25 %", SCORE_CHAIN, {SURVEYED, 1.0, 0.25, 1.0, false}},
    {"harder", "braked 25 % harder than planned", SCORE_CHAIN, {SURVEYED, 1.0, 0.1, 1.25, false}},
    {"old",
     "no survey since the first landing",
     SCORE_CHAIN,
     {SURVEYED | SCORE_ONCE, 1.0, 0.1, 1.0, false}},
    {"absent", "no survey", SCORE_CHAIN, {0, 1.0, 0.1, 1.0, false}},
    {"half",
     "half of the transducers lost",
     SCORE_CHAIN,
     {SURVEYED | SCORE_HALF, 1.0, 0.1, 1.0, false}},
    {"blind", "all transducers lost", SCORE_CHAIN, {SURVEYED | SCORE_BLIND, 1.0, 0.1, 1.0, false}},
};

#define RIDGE     1.0
#define FACT(f)   (BY_FACT + (unsigned)(f))
#define MANY      50u /* a fifth of so many landings is to hold */
#define HOLDS     0.05
#define BRIER     0.12
#define PERTURBED 0.80

static const char *const when_names[WHENS] = {"before", "0.5 s", "1 s", "2 s"};
static const double aims[WHENS] = {0.93, 0.0, 0.94, 0.0};

/* Still at risk: the event is far enough away to act on, or none comes. */
static bool counts(const struct foresight_said *s, enum foresight_when when)
{
    return s->when == when && !((double)s->until_s < SCORE_AHEAD_S);
}

/* --- the baselines --- */

struct facts {
    float *input; /* FACTS of each */
    bool *event;
    size_t count;
};

static bool gather_facts(const struct foresight_list *list, enum foresight_when when,
                         struct facts *facts)
{
    *facts = (struct facts){.input = calloc(list->count * FACTS + 1, sizeof(float)),
                            .event = calloc(list->count + 1, sizeof(bool))};
    for (size_t i = 0; facts->input && facts->event && i < list->count; i++) {
        if (!counts(&list->said[i], when))
            continue;
        memcpy(facts->input + facts->count * FACTS, list->said[i].fact, sizeof list->said[i].fact);
        facts->event[facts->count++] = !isnan(list->said[i].until_s);
    }
    return facts->input && facts->event;
}

/* A fact alone, and one: a rule that has its sign, and its probability, from what is learned. */
static void fit_alone(const struct facts *facts, unsigned fact, double *weight)
{
    float *input = calloc(2 * facts->count + 1, sizeof *input);
    for (size_t i = 0; input && i < facts->count; i++) {
        input[2 * i] = 1.0f;
        input[2 * i + 1] = fact == FACT_ONE ? 0.0f : facts->input[i * FACTS + fact];
    }
    if (input)
        stats_fit(input, facts->event, facts->count, 2, RIDGE, weight);
    free(input);
}

/* Rules are of what `learned` tells; false: no memory. forget_moment in every case. */
static bool recall_moment(const struct foresight_list *list, const struct foresight_list *learned,
                          enum foresight_when when, struct foresight_moment *moment)
{
    struct facts facts;
    double all[FACTS], alone[FACTS][2] = {{0.0}};
    bool good = gather_facts(learned, when, &facts);
    moment->event = calloc(list->count + 1, sizeof *moment->event);
    moment->series = calloc(list->count + 1, sizeof *moment->series);
    good = good && moment->event && moment->series;
    for (unsigned b = 0; b < FACT(FACTS); b++) {
        moment->by[b] = calloc(list->count + 1, sizeof(float));
        good = good && moment->by[b];
    }
    if (good)
        stats_fit(facts.input, facts.event, facts.count, FACTS, RIDGE, all);
    for (unsigned f = 0; good && f < FACTS; f++)
        fit_alone(&facts, f, alone[f]);
    for (size_t i = 0; good && i < list->count; i++) {
        const struct foresight_said *s = &list->said[i];
        size_t n = moment->count;
        if (!counts(s, when))
            continue;
        moment->by[BY_ENSEMBLE][n] = s->ensemble;
        /* where the board says that it does not know, what was said before stands */
        moment->by[BY_BOARD][n] = isnan(s->board) ? s->ensemble : s->board;
        moment->by[BY_PLANNED][n] = isnan(s->planned) ? 0.5f : s->planned;
        moment->by[BY_NOTHING][n] = isnan(s->nothing) ? 0.5f : s->nothing;
        moment->by[BY_COMBINED][n] = (float)stats_rule(all, s->fact, FACTS);
        for (unsigned f = 0; f < FACTS; f++) {
            const float input[] = {1.0f, f == FACT_ONE ? 0.0f : s->fact[f]};
            moment->by[FACT(f)][n] = (float)stats_rule(alone[f], input, 2);
        }
        moment->event[n] = !isnan(s->until_s);
        moment->events += moment->event[n];
        moment->series[n] = s->series;
        moment->count++;
    }
    free(facts.input);
    free(facts.event);
    return good;
}

static void forget_moment(struct foresight_moment *moment)
{
    for (unsigned b = 0; b < FACT(FACTS); b++)
        free(moment->by[b]);
    free(moment->event);
    free(moment->series);
    *moment = (struct foresight_moment){0};
}

/* --- the tables --- */

/* Whose word it is: before touchdown that of `matrig advise`, then the board's. */
static enum foresight_by own(unsigned when)
{
    return when == BEFORE ? BY_ENSEMBLE : BY_BOARD;
}

static struct stats_lead lead_of(const struct foresight_moment *m, enum foresight_by by)
{
    return stats_lead(m->by[by], m->by[BY_COMBINED], m->event, m->series, m->count);
}

static void print_areas(const struct foresight_row *row, const struct foresight_moment *moment)
{
    static const unsigned alone[] = {BY_PLANNED,           BY_NOTHING,         FACT(FACT_PLAN),
                                     FACT(FACT_HARDEST),   FACT(FACT_BRAKING), FACT(FACT_COUNT),
                                     FACT(FACT_KINEMATIC), FACT(FACT_SPEED),   FACT(FACT_FRICTION),
                                     FACT(FACT_COMING),    FACT(FACT_SLACK)};
    if (!row) {
        printf("Areas under the curve, of landings whose event is %.1f s away or more, or that "
               "have none; in brackets what it leads the combined baseline by (95 %%, whole series "
               "drawn again)\n\n",
               SCORE_AHEAD_S);
        printf("| row, when | landings, events | advise (ensemble) | board | combined | board: "
               "plan alone | nothing given | plan, mean | plan, hardest | braking | count | "
               "kinematic | speed | friction | zone to come | "
               "slack |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
        return;
    }
    for (unsigned w = 0; w < WHENS; w++) {
        const struct foresight_moment *m = &moment[w];
        struct stats_lead ensemble = lead_of(m, BY_ENSEMBLE), board = lead_of(m, BY_BOARD);
        printf("| %s, %s | %zu, %zu | %.3f (%+.3f to %+.3f) | %.3f (%+.3f to %+.3f) | %.3f |",
               row->name, when_names[w], m->count, m->events, ensemble.area, ensemble.low,
               ensemble.high, board.area, board.low, board.high, ensemble.other);
        for (size_t f = 0; f < sizeof alone / sizeof alone[0]; f++)
            printf(" %.2f |", score_auc(m->by[alone[f]], m->event, m->count));
        printf("\n");
    }
}

static void print_bins(const struct stats_held *held)
{
    for (unsigned b = 0; b < STATS_BINS; b++) {
        if (held->count[b])
            printf(" %.2f %.2f %u |", held->said[b], held->seen[b], held->count[b]);
        else
            printf(" - |");
    }
    printf("\n");
}

static void print_held(const struct foresight_row *row, const struct foresight_moment *moment)
{
    static const char *const names[] = {"advise", "board", "combined"};
    if (!row) {
        printf("Brier score: reliability less resolution and with uncertainty, but for what "
               "differs within a fifth. Climatology is the rate of the series that are learned "
               "from. Fifths: said, seen, landings\n\n");
        printf("| row, when, by | Brier; climatology | reliability | resolution | uncertainty | 0 "
               "to .2 | .2 to .4 | .4 to .6 | .6 to .8 | .8 to 1 |\n"
               "|---|---|---|---|---|---|---|---|---|---|\n");
        return;
    }
    for (unsigned w = 0; w < WHENS; w++) {
        for (unsigned by = BY_ENSEMBLE; by <= BY_COMBINED; by++) {
            struct stats_held held, rate;
            stats_held(moment[w].by[by], moment[w].event, moment[w].count, &held);
            stats_held(moment[w].by[FACT(FACT_ONE)], moment[w].event, moment[w].count, &rate);
            printf("| %s, %s, %s | %.3f; %.3f | %.3f | %.3f | %.3f |", row->name, when_names[w],
                   names[by], held.brier, rate.brier, held.reliability, held.resolution,
                   held.uncertainty);
            print_bins(&held);
        }
    }
}

static void print_missed(const struct foresight_row *row, const struct foresight_moment *moment)
{
    if (!row) {
        printf("Aims that are missed\n\n");
        return;
    }
    bool plain = row == &foresight_rows[0];
    for (unsigned w = 0; w < WHENS; w++) {
        const struct foresight_moment *m = &moment[w];
        struct stats_lead lead = lead_of(m, own(w));
        struct stats_held held;
        double aim = plain ? aims[w] : PERTURBED;
        stats_held(m->by[own(w)], m->event, m->count, &held);
        if (lead.area < aim)
            printf("%s, %s: area %.3f, not %.2f\n", row->name, when_names[w], lead.area, aim);
        if (plain && w == BEFORE && lead.low <= 0.0)
            printf("%s, %s: its lead may be 0: %+.3f to %+.3f\n", row->name, when_names[w],
                   lead.low, lead.high);
        if (lead.high < 0.0)
            printf("%s, %s: behind the combined baseline, %+.3f to %+.3f\n", row->name,
                   when_names[w], lead.low, lead.high);
        if (held.brier > BRIER)
            printf("%s, %s: Brier score %.3f, not %.2f\n", row->name, when_names[w], held.brier,
                   BRIER);
        for (unsigned b = 0; b < STATS_BINS; b++) {
            if (held.count[b] >= MANY && fabs(held.said[b] - held.seen[b]) > HOLDS)
                printf("%s, %s: said %.2f, seen %.2f in %u landings\n", row->name, when_names[w],
                       held.said[b], held.seen[b], held.count[b]);
        }
    }
}

/* --- playing --- */

struct listener {
    const struct score_truth *truth;
    const struct score_landing *landing;
    const struct foresight_row *row;
    const struct advised_chart *chart; /* NULL: facts alone */
    struct foresight_list *list;
    struct mr_risk_plan plan;
    struct mr_risk_state board, planned, nothing;
    double event_s;
    float slack_ft;
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

/* The survey as it is known: of before the landing, or of before the first one. */
static float slack_ft(const struct listener *l)
{
    const struct score_landing *read = l->row->told.view & SCORE_ONCE ? &l->truth->landing[0]
                                                                      : l->landing;
    double sum_ft = 0.0;
    for (unsigned j = 0; j < SCORE_JOINTS; j++)
        sum_ft += (double)read->gap_in[j] / 12.0;
    return l->row->told.view & SCORE_SURVEYED ? (float)sum_ft : 0.0f;
}

static void on_armed(void *ctx, const struct mr_predictor *predictor,
                     const struct score_landing *landing)
{
    struct listener *l = ctx;
    l->landing = landing;
    l->event_s = score_event_s(landing, NULL);
    l->slack_ft = slack_ft(l);
    advised_draw_plan(landing, l->truth->series.number, &l->row->told, &l->plan);
    l->plan.landing_count = (float)predictor->landing_count;
    mr_risk_arm(&l->nothing, NULL, predictor, TOUCHDOWN);
    mr_risk_arm(&l->planned, &l->plan, predictor, TOUCHDOWN);
    if (l->chart)
        advised_chart_put(&l->chart[landing->number - 1u], ADVISED_ROWS, &l->plan);
    mr_risk_arm(&l->board, &l->plan, predictor, TOUCHDOWN);
}

static float zones(float mats)
{
    return fminf(mats / ZONE_MATS, 3.0f);
}

static void take_facts(const struct listener *l, const struct mr_predictor *predictor,
                       const struct mr_risk_report *said, float coming_mats, float *fact)
{
    fact[FACT_ONE] = 1.0f;
    fact[FACT_PLAN] = (float)advised_plan_mean_ft_s2(&l->plan) / 6.0f;
    fact[FACT_HARDEST] = (float)advised_plan_hardest_ft_s2(&l->plan) / 6.0f;
    fact[FACT_BRAKING] = predictor->deceleration_ft_s2 / 6.0f;
    fact[FACT_COUNT] = (float)l->landing->number / 3.0f;
    fact[FACT_KINEMATIC] = said->input[MR_RISK_KINEMATIC];
    fact[FACT_SPEED] = (isnan(predictor->speed_ft_s) ? l->plan.speed_ft_s : predictor->speed_ft_s) /
                       30.0f;
    fact[FACT_FRICTION] = (float)l->truth->series.told_friction / 0.6f;
    fact[FACT_COMING] = zones(coming_mats);
    fact[FACT_SLACK] = l->slack_ft;
}

static void on_block(void *ctx, const struct mr_predictor *predictor,
                     const struct mr_predictor_input *input, unsigned ms)
{
    struct listener *l = ctx;
    struct mr_predictor_zone zone;
    struct mr_risk_report said, planned, nothing;
    unsigned when = 0;
    double since_s = 1e-3 * ms - l->landing->touchdown_s;
    mr_risk_on_block(&l->board, predictor, input);
    mr_risk_on_block(&l->planned, predictor, input);
    mr_risk_on_block(&l->nothing, predictor, input);
    if (ms % SCORE_LOOK_MS || ms / SCORE_LOOK_MS >= l->landing->looks || 1e-3 * ms >= l->event_s)
        return;
    while (when < WHENS && fabs(since_s - when_s[when]) > 1e-6)
        when++;
    if (when == WHENS)
        return;
    mr_predictor_get_zone(predictor, &zone);
    mr_risk_compute(&l->board, predictor, &zone, &said);
    mr_risk_compute(&l->planned, predictor, &zone, &planned);
    mr_risk_compute(&l->nothing, predictor, &zone, &nothing);
    if (said.basis & MR_RISK_STOPPED)
        return;
    if (l->row->told.view & SCORE_ONCE && l->landing->number == 1)
        return; /* its survey is new */
    struct foresight_said *s = &l->list->said[l->list->count++];
    const struct advised_chart *chart = l->chart ? &l->chart[l->landing->number - 1u] : NULL;
    *s = (struct foresight_said){.ensemble = chart ? (float)chart->p[AT_PLAN] : NAN,
                                 .share = chart ? (float)chart->share[AT_PLAN] : NAN,
                                 .board = said.risk,
                                 .planned = planned.risk,
                                 .nothing = nothing.risk,
                                 .until_s = (float)(l->event_s - 1e-3 * ms),
                                 .series = (uint16_t)l->truth->series.number,
                                 .landing = (uint8_t)l->landing->number,
                                 .when = (uint8_t)when};
    take_facts(l, predictor, &said, (float)zone.future_mats, s->fact);
}

static bool play_series(const char *folder, const struct foresight_row *row, uint32_t number,
                        bool facts, struct foresight_list *list)
{
    static struct score_truth truth;
    struct advised_chart chart[SCORE_LANDINGS];
    struct listener l = {.truth = &truth, .row = row, .chart = facts ? NULL : chart, .list = list};
    const struct score_sink sink = {on_look, on_outcome, on_armed, on_block, &l};
    if (!score_truth_get(&truth, number, row->kind, folder) ||
        (!facts && !advised_charts(&truth, &row->told, factors, ADVISED_ROWS, chart)))
        return false;
    truth.series.told_friction *= row->told.friction_times;
    score_play(&truth, row->told.view, 0, &sink);
    return true;
}

/* --- files: one a row and series --- */

static void path_of(char *path, size_t size, const char *folder, const char *name, uint32_t series)
{
    snprintf(path, size, "%s/said-%s-%u.bin", folder, name, series);
}

/* Puts what is kept of a series behind what the list has; nothing is kept: nothing. */
static void get_series(const char *folder, const char *name, uint32_t series,
                       struct foresight_list *list)
{
    char path[512];
    uint32_t head[2];
    path_of(path, sizeof path, folder, name, series);
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    size_t room = (size_t)SCORE_LANDINGS * WHENS;
    if (fread(head, sizeof head, 1, file) == 1 && head[0] == VERSION && head[1] <= room) {
        list->count += fread(list->said + list->count, sizeof *list->said, head[1], file);
        list->series++;
    }
    fclose(file);
}

static bool get(const char *folder, const char *name, uint32_t from, uint32_t series,
                struct foresight_list *list)
{
    *list = (struct foresight_list){
        .said = calloc((size_t)series * SCORE_LANDINGS * WHENS + 1u, sizeof *list->said)};
    for (uint32_t n = from; list->said && n < from + series; n++)
        get_series(folder, name, n, list);
    return list->count > 0;
}

static bool put_series(const char *folder, const char *name, uint32_t series,
                       const struct foresight_list *list)
{
    char path[512];
    const uint32_t head[2] = {VERSION, (uint32_t)list->count};
    path_of(path, sizeof path, folder, name, series);
    FILE *file = fopen(path, "wb");
    bool good = file && fwrite(head, sizeof head, 1, file) == 1 &&
                fwrite(list->said, sizeof *list->said, list->count, file) == list->count;
    if ((file && fclose(file)) || !good) {
        fprintf(stderr, "foresight: %s cannot be written; is the disk full?\n", path);
        return false;
    }
    return true;
}

static int play_row(const char *folder, const struct foresight_row *row, const char *name,
                    uint32_t series, bool facts)
{
    static struct foresight_said said[SCORE_LANDINGS * WHENS];
    struct foresight_list list = {.said = said};
    fprintf(stderr, "foresight: series %u, %s\n", series, name);
    if (!play_series(folder, row, series, facts, &list))
        return 5;
    return put_series(folder, name, series, &list) ? 0 : 3;
}

/* --- what is learned, and the tables --- */

/* Baselines are fitted for what of survey and transducers there is: nothing perturbed but that. */
static const char *learned_name(const struct foresight_row *row)
{
    return row->told.view & SCORE_BLIND    ? "learned-blind"
         : row->told.view & SCORE_SURVEYED ? "learned"
                                           : "learned-absent";
}

static int learn(const char *folder)
{
    int code = 0;
    for (unsigned i = 0; i < FORESIGHT_ROWS; i++) {
        const struct foresight_row *row = &foresight_rows[i];
        if (strcmp(row->name, "plain") != 0 && strcmp(row->name, "absent") != 0 &&
            strcmp(row->name, "blind") != 0)
            continue;
        for (uint32_t n = LEARN_FROM; n < LEARN_FROM + LEARN_OF && !code; n++)
            code = play_row(folder, row, learned_name(row), n, true);
    }
    return code;
}

/* The moments of a row, if it was played. */
static int recall(const char *folder, const struct foresight_row *row, uint32_t from,
                  uint32_t series, struct foresight_moment *moment, bool *played)
{
    struct foresight_list list, learned = {0};
    int code = 0;
    *played = get(folder, row->name, from, series, &list);
    if (*played && !get(folder, learned_name(row), LEARN_FROM, LEARN_OF, &learned)) {
        fprintf(stderr, "foresight: %s has no %s; make it: foresight %s learn\n", folder,
                learned_name(row), folder);
        code = 3;
    }
    for (unsigned w = 0; *played && !code && w < WHENS; w++)
        code = recall_moment(&list, &learned, (enum foresight_when)w, &moment[w]) ? 0 : 5;
    if (*played && !code)
        printf("%s: %s; %u series from %u on\n", row->name, row->text, list.series, from);
    free(list.said);
    free(learned.said);
    return code;
}

/* All rows that were played. */
static int print_tables(const char *folder, uint32_t from, uint32_t series)
{
    static struct foresight_moment moment[FORESIGHT_ROWS][WHENS];
    bool played[FORESIGHT_ROWS];
    int code = 0;
    for (unsigned i = 0; i < FORESIGHT_ROWS && !code; i++)
        code = recall(folder, &foresight_rows[i], from, series, moment[i], &played[i]);
    static void (*const print[])(const struct foresight_row *, const struct foresight_moment *) = {
        print_areas, print_held, print_missed};
    for (unsigned p = 0; p < sizeof print / sizeof print[0] && !code; p++) {
        printf("\n");
        print[p](NULL, NULL);
        for (unsigned i = 0; i < FORESIGHT_ROWS; i++) {
            if (played[i])
                print[p](&foresight_rows[i], moment[i]);
        }
    }
    for (unsigned i = 0; i < FORESIGHT_ROWS * WHENS; i++)
        forget_moment(&moment[i / WHENS][i % WHENS]);
    return code;
}

/* Landings before touchdown: the members' share, and what came. */
struct shares {
    float *input; /* 1 and the log odds, of each */
    bool *event;
    size_t count;
};

static bool take_shares(const char *folder, const struct foresight_row *row, uint32_t from,
                        uint32_t series, struct shares *shares)
{
    struct foresight_list list;
    bool good = get(folder, row->name, from, series, &list);
    *shares = (struct shares){.input = calloc(2 * list.count + 1, sizeof(float)),
                              .event = calloc(list.count + 1, sizeof(bool))};
    if (!good)
        fprintf(stderr, "foresight: %s was not played: foresight %s play %u %u %s\n", row->name,
                folder, from, series, row->name);
    good = good && shares->input && shares->event;
    for (size_t i = 0; good && i < list.count; i++) {
        if (list.said[i].when != BEFORE)
            continue;
        shares->input[2 * shares->count] = 1.0f;
        shares->input[2 * shares->count + 1] =
            (float)advise_convert_to_log_odds((double)list.said[i].share);
        shares->event[shares->count++] = !isnan(list.said[i].until_s);
    }
    free(list.said);
    return good;
}

static void print_shares(const struct shares *shares, const char *text, const double *weight)
{
    struct stats_held held;
    float *said = calloc(shares->count + 1, sizeof *said);
    for (size_t i = 0; said && i < shares->count; i++)
        said[i] = (float)stats_rule(weight, shares->input + 2 * i, 2);
    if (said) {
        stats_held(said, shares->event, shares->count, &held);
        printf("%s: %zu landings, log odds %.2f times the members', and %+.2f: Brier score %.3f; "
               "said, seen, landings:",
               text, shares->count, weight[1], weight[0], held.brier);
        for (unsigned b = 0; b < STATS_BINS; b++)
            printf(" %.2f %.2f %u;", held.said[b], held.seen[b], held.count[b]);
        printf("\n");
    }
    free(said);
}

static double logit(double p)
{
    return log(p / (1.0 - p));
}

/* The log odds that would have held for a row, and how they hold in other series. What
 * host/advise/members.c has is this of series 250 to 309. */
static int print_odds(const char *folder, const struct foresight_row *row, const uint32_t from[2],
                      const uint32_t series[2])
{
    struct shares shares[2];
    double weight[2], today[2] = {logit(advise_calibrate_share(0.5, true)), 0.0};
    today[1] = (logit(advise_calibrate_share(0.9, true)) - today[0]) /
               advise_convert_to_log_odds(0.9);
    bool good = take_shares(folder, row, from[0], series[0], &shares[0]);
    good = take_shares(folder, row, from[1], series[1], &shares[1]) && good;
    if (good) {
        stats_fit(shares[0].input, shares[0].event, shares[0].count, 2, 1e-6, weight);
        print_shares(&shares[0], "fitted", weight);
        print_shares(&shares[1], "held today", today);
        print_shares(&shares[1], "held so", weight);
    }
    for (unsigned i = 0; i < 2; i++) {
        free(shares[i].input);
        free(shares[i].event);
    }
    return good ? 0 : 3;
}

static bool is_named(const struct foresight_row *row, char **names, int count)
{
    bool named = count == 0;
    for (int i = 0; i < count; i++)
        named = named || strcmp(names[i], row->name) == 0;
    return named;
}

static int play(const char *folder, uint32_t from, uint32_t series, char **names, int count)
{
    int code = 0, some = 0;
    for (uint32_t n = from; n < from + series && !code; n++) {
        for (unsigned i = 0; i < FORESIGHT_ROWS && !code; i++) {
            const struct foresight_row *row = &foresight_rows[i];
            if (!is_named(row, names, count))
                continue;
            some++;
            code = play_row(folder, row, row->name, n, false);
        }
    }
    if (!some)
        fprintf(stderr, "foresight: no such row\n");
    return some ? code : 2;
}

/* `rest`: other series and the row. */
static int odds(const char *folder, uint32_t from, uint32_t series, char **rest)
{
    const uint32_t froms[2] = {from, (uint32_t)atoi(rest[0])},
                   counts[2] = {series, (uint32_t)atoi(rest[1])};
    for (unsigned i = 0; i < FORESIGHT_ROWS; i++) {
        if (strcmp(foresight_rows[i].name, rest[2]) == 0)
            return print_odds(folder, &foresight_rows[i], froms, counts);
    }
    fprintf(stderr, "foresight: no such row\n");
    return 2;
}

int main(int argc, char **argv)
{
    const char *what = argc > 2 ? argv[2] : "";
    if (argc == 3 && strcmp(what, "learn") == 0)
        return learn(argv[1]);
    if (argc >= 5 && atoi(argv[3]) >= 0 && atoi(argv[4]) > 0 &&
        atoi(argv[3]) + atoi(argv[4]) < 65535) {
        uint32_t from = (uint32_t)atoi(argv[3]), series = (uint32_t)atoi(argv[4]);
        if (argc == 5 && strcmp(what, "table") == 0)
            return print_tables(argv[1], from, series);
        if (argc == 8 && strcmp(what, "odds") == 0)
            return odds(argv[1], from, series, argv + 5);
        if (strcmp(what, "play") == 0)
            return play(argv[1], from, series, argv + 5, argc - 5);
    }
    fprintf(stderr,
            "foresight: usage: foresight FOLDER learn | table FROM COUNT | odds FROM COUNT OTHER "
            "COUNT ROW | play FROM COUNT [ROW]...\n");
    return 2;
}
