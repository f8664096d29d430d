/* foresight: how good it is what matrig says of a landing before touchdown and during it, on truths
 * that are not its own and with knowledge that is off. See README.md, "Foresight".
 *
 *   foresight FOLDER learn                      what the baselines are fitted on: facts of series
 *                                               100 to 249, kept in FOLDER
 *   foresight FOLDER play FROM COUNT [ROW]...   what is said of the landings of series FROM ..
 *                                               FROM + COUNT - 1, kept in FOLDER; all rows or some
 *   foresight FOLDER table FROM COUNT           tables on stdout, a diagram a row in FOLDER, of
 *                                               what was played
 *   foresight FOLDER odds FROM COUNT OTHER COUNT ROW   the log odds that would have held for series
 *                                               FROM and on, and how they hold for OTHER and on
 *
 * Exit: 0; 2 usage; 3 files; 5 a series failed. */
#include "tests/score/foresight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
const struct foresight_row foresight_rows[FORESIGHT_ROWS] = {
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
    l->event_s = score_event_s(landing);
    l->slack_ft = slack_ft(l);
    advised_draw_plan(landing, l->truth->series.number, &l->row->told, &l->plan);
    l->plan.landings = (float)predictor->landings;
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
                       const struct mr_risk_said *said, float coming_mats, float *fact)
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
    struct mr_risk_said said, planned, nothing;
    unsigned when = 0;
    double since_s = 1e-3 * ms - l->landing->touchdown_s;
    mr_risk_block(&l->board, predictor, input);
    mr_risk_block(&l->planned, predictor, input);
    mr_risk_block(&l->nothing, predictor, input);
    if (ms % SCORE_LOOK_MS || ms / SCORE_LOOK_MS >= l->landing->looks || 1e-3 * ms >= l->event_s)
        return;
    while (when < WHENS && fabs(since_s - when_s[when]) > 1e-6)
        when++;
    if (when == WHENS)
        return;
    mr_predictor_zone(predictor, &zone);
    mr_risk_say(&l->board, predictor, &zone, &said);
    mr_risk_say(&l->planned, predictor, &zone, &planned);
    mr_risk_say(&l->nothing, predictor, &zone, &nothing);
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
    take_facts(l, predictor, &said, (float)zone.coming_mats, s->fact);
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

static bool draw(const char *folder, const struct foresight_row *row,
                 const struct foresight_moment *moment)
{
    char path[512];
    snprintf(path, sizeof path, "%s/foresight-%s.svg", folder, row->name);
    struct error error = {0};
    if (foresight_draw(path, row, moment, &error) != MR_OK) {
        fprintf(stderr, "foresight: %s\n", error.text);
        return false;
    }
    return true;
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
        code = foresight_recall(&list, &learned, (enum foresight_when)w, &moment[w]) ? 0 : 5;
    if (*played && !code) {
        printf("%s: %s; %u series from %u on\n", row->name, row->text, list.series, from);
        code = draw(folder, row, moment) ? 0 : 3;
    }
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
        foresight_print_areas, foresight_print_held, foresight_print_missed};
    for (unsigned p = 0; p < sizeof print / sizeof print[0] && !code; p++) {
        printf("\n");
        print[p](NULL, NULL);
        for (unsigned i = 0; i < FORESIGHT_ROWS; i++) {
            if (played[i])
                print[p](&foresight_rows[i], moment[i]);
        }
    }
    for (unsigned i = 0; i < FORESIGHT_ROWS * WHENS; i++)
        foresight_forget(&moment[i / WHENS][i % WHENS]);
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
        shares->input[2 * shares->count + 1] = (float)advise_odds((double)list.said[i].share);
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
    double weight[2], today[2] = {logit(advise_calibrated(0.5, true)), 0.0};
    today[1] = (logit(advise_calibrated(0.9, true)) - today[0]) / advise_odds(0.9);
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
