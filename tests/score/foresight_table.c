#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/score/foresight.h"

#define RIDGE     1.0
#define FACT(f)   (BY_FACT + (unsigned)(f))
#define MANY      50u /* a fifth of so many landings is to hold */
#define HOLDS     0.05
#define BRIER     0.12
#define PERTURBED 0.80

const char *const foresight_when_names[WHENS] = {"before", "0.5 s", "1 s", "2 s"};
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

static bool take_facts(const struct foresight_list *list, enum foresight_when when,
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

bool foresight_recall(const struct foresight_list *list, const struct foresight_list *learned,
                      enum foresight_when when, struct foresight_moment *moment)
{
    struct facts facts;
    double all[FACTS], alone[FACTS][2] = {{0.0}};
    bool good = take_facts(learned, when, &facts);
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

void foresight_forget(struct foresight_moment *moment)
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

void foresight_print_areas(const struct foresight_row *row, const struct foresight_moment *moment)
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
               row->name, foresight_when_names[w], m->count, m->events, ensemble.area, ensemble.low,
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

void foresight_print_held(const struct foresight_row *row, const struct foresight_moment *moment)
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
            printf("| %s, %s, %s | %.3f; %.3f | %.3f | %.3f | %.3f |", row->name,
                   foresight_when_names[w], names[by], held.brier, rate.brier, held.reliability,
                   held.resolution, held.uncertainty);
            print_bins(&held);
        }
    }
}

void foresight_print_missed(const struct foresight_row *row, const struct foresight_moment *moment)
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
            printf("%s, %s: area %.3f, not %.2f\n", row->name, foresight_when_names[w], lead.area,
                   aim);
        if (plain && w == BEFORE && lead.low <= 0.0)
            printf("%s, %s: its lead may be 0: %+.3f to %+.3f\n", row->name,
                   foresight_when_names[w], lead.low, lead.high);
        if (lead.high < 0.0)
            printf("%s, %s: behind the combined baseline, %+.3f to %+.3f\n", row->name,
                   foresight_when_names[w], lead.low, lead.high);
        if (held.brier > BRIER)
            printf("%s, %s: Brier score %.3f, not %.2f\n", row->name, foresight_when_names[w],
                   held.brier, BRIER);
        for (unsigned b = 0; b < STATS_BINS; b++) {
            if (held.count[b] >= MANY && fabs(held.said[b] - held.seen[b]) > HOLDS)
                printf("%s, %s: said %.2f, seen %.2f in %u landings\n", row->name,
                       foresight_when_names[w], held.said[b], held.seen[b], held.count[b]);
        }
    }
}
