#include "tests/figures/search.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SEED        1973u
#define WALKS       5 /* R*, the best of displacements alone, and the best of the ensemble */
#define BURN        3 /* 1 / share of a walk that is not kept */
#define DESCENT     3 /* 1 / share of the steps that go downhill from the best */
#define MOST_INPUTS 4 /* changed in one step */
#define REFLECT(x)  ((x) < 0 ? -(x) : (x) > 1 ? 2 - (x) : (x))

bool search_has(enum search_group group, const struct fact *fact)
{
    return group == SEARCH_ALL || (group == SEARCH_MOVES) == fact_moves(fact);
}

struct reading trial_reading(const struct trial *trial)
{
    struct reading reading;
    for (int i = 0; i < INPUTS; i++)
        reading.value[i] = input_value((enum input_id)i, trial->part[i]);
    return reading;
}

double search_score(struct playing *playing, enum search_group group, double most, double *value)
{
    double score = 0;
    for (size_t i = 0; i < fact_count; i++)
        value[i] = (double)NAN;
    for (size_t i = 0; i < fact_count && score <= most; i++) {
        if (!search_has(group, &facts[i]))
            continue;
        value[i] = fact_value(&facts[i], playing);
        double miss = fact_miss(&facts[i], value[i]);
        score += log1p(miss * miss);
    }
    return score;
}

static void play_trial(struct search *search, struct trial *trial, enum search_group group,
                       double most)
{
    struct playing playing = {.reading = trial_reading(trial)};
    trial->score = search_score(&playing, group, most, trial->value);
    search->played++;
}

static void lay_hypercube(struct search *search, uint64_t *state)
{
    for (int in = 0; in < INPUTS; in++) {
        for (size_t i = 0; i < search->count; i++) {
            size_t other = (size_t)(uniform_next(state) * (double)(i + 1));
            search->ensemble[i].part[in] = search->ensemble[other].part[in];
            search->ensemble[other].part[in] = ((double)i + uniform_next(state)) /
                                               (double)search->count;
        }
    }
}

static double group_score(const struct trial *trial, enum search_group group)
{
    double score = 0;
    for (size_t i = 0; i < fact_count; i++) {
        double miss = search_has(group, &facts[i]) ? fact_miss(&facts[i], trial->value[i]) : 0;
        score += log1p(miss * miss);
    }
    return score;
}

static void step_from(const struct trial *at, struct trial *next, uint64_t *state)
{
    static const double widths[] = {0.01, 0.04, 0.15, 0.5};
    double width = widths[(int)(4 * uniform_next(state))];
    int changes = 1 + (int)(MOST_INPUTS * uniform_next(state));
    *next = *at;
    for (int c = 0; c < changes; c++) {
        int in = (int)(INPUTS * uniform_next(state));
        enum input_kind kind = inputs[in].kind;
        double free = uniform_next(state);
        double near = at->part[in] + width * (2 * uniform_next(state) - 1);
        next->part[in] = kind == INPUT_CHOICE ? free : REFLECT(near);
    }
}

static void keep_top(struct search *search, const struct trial *trial)
{
    int place = SEARCH_TOP;
    while (place > 0 && trial->score < search->top[place - 1].score)
        place--;
    if (place == SEARCH_TOP)
        return;
    for (int k = SEARCH_TOP - 1; k > place; k--)
        search->top[k] = search->top[k - 1];
    search->top[place] = *trial;
}

/* The best of the best, by the accurate method: near the longest step a wave that is about to fall
 * may stand. */
static void choose_best(struct search *search)
{
    double least = HUGE_VAL;
    for (int k = 0; k < SEARCH_TOP && search->top[k].score < HUGE_VAL; k++) {
        struct playing playing = {.reading = trial_reading(&search->top[k]), .fine = true};
        struct trial exact = search->top[k];
        exact.score = search_score(&playing, SEARCH_ALL, least, exact.value);
        if (exact.score < least) {
            least = exact.score;
            search->best[SEARCH_ALL] = exact;
        }
    }
    fprintf(stderr, "all facts, by the accurate method: best %.2f\n", least);
}

/* `downhill`: only to less; else as Metropolis. */
static void walk(struct search *search, struct trial at, enum search_group group, size_t steps,
                 bool downhill, uint64_t *state)
{
    struct trial *best = &search->best[group];
    for (size_t k = 0; k < steps; k++) {
        struct trial next;
        step_from(&at, &next, state);
        double luck = -log(fmax(uniform_next(state), 1e-300));
        double most = at.score + (downhill ? 0 : luck);
        play_trial(search, &next, group, most);
        if (next.score <= most)
            at = next;
        if (at.score < best->score)
            *best = at;
        if (group == SEARCH_ALL && next.score == at.score)
            keep_top(search, &at);
        if (group == SEARCH_ALL && !downhill && k >= steps / BURN &&
            search->walked_count < search->walked_room)
            search->walked[search->walked_count++] = at;
    }
}

static void take_starts(const struct search *search, enum search_group group,
                        struct trial starts[WALKS])
{
    double above = -1; /* the best, then the next */
    const struct reading rstar = reading_rstar();
    struct playing playing = {.reading = rstar};
    for (int i = 0; i < INPUTS; i++)
        starts[0].part[i] = input_part((enum input_id)i, rstar.value[i]);
    starts[0].score = search_score(&playing, group, HUGE_VAL, starts[0].value);
    int first = 1;
    if (group == SEARCH_ALL) {
        playing = (struct playing){.reading = trial_reading(&search->best[SEARCH_MOVES])};
        starts[first] = search->best[SEARCH_MOVES];
        starts[first].score = search_score(&playing, group, HUGE_VAL, starts[first].value);
        first++;
    }
    for (int w = first; w < WALKS; w++) {
        double least = HUGE_VAL;
        for (size_t i = 0; i < search->count; i++) {
            double score = group_score(&search->ensemble[i], group);
            if (score > above && score < least) {
                least = score;
                starts[w] = search->ensemble[i];
            }
        }
        starts[w].score = above = least;
    }
}

static void refine(struct search *search, enum search_group group, size_t steps)
{
    struct trial starts[WALKS] = {0};
    uint64_t state = SEED + 1 + (uint64_t)group;
    take_starts(search, group, starts);
    search->best[group].score = HUGE_VAL;
    for (int w = 0; w < WALKS; w++) {
        if (starts[w].score < search->best[group].score)
            search->best[group] = starts[w];
    }
    size_t down = steps / DESCENT;
    for (int w = 0; w < WALKS; w++)
        walk(search, starts[w], group, (steps - down) / WALKS, false, &state);
    walk(search, search->best[group], group, down, true, &state);
    fprintf(stderr, "%s: R* %.2f, best %.2f\n",
            group == SEARCH_ALL     ? "all facts"
            : group == SEARCH_MOVES ? "displacements alone"
                                    : "waves alone",
            starts[0].score, search->best[group].score);
}

enum mr_status search_run(struct search *search, size_t count, struct error *error)
{
    uint64_t state = SEED;
    *search = (struct search){.count = count, .walked_room = 2 * count};
    search->ensemble = calloc(count, sizeof *search->ensemble);
    search->walked = calloc(2 * count, sizeof *search->walked);
    if (!search->ensemble || !search->walked)
        return error_set(error, MR_FULL, "out of memory: %zu readings", count);
    lay_hypercube(search, &state);
    for (size_t i = 0; i < count; i++)
        play_trial(search, &search->ensemble[i], SEARCH_ALL, HUGE_VAL);
    refine(search, SEARCH_MOVES, 6 * count); /* cheaper: five scenes of 26 */
    refine(search, SEARCH_LIFTS, count);
    for (int k = 0; k < SEARCH_TOP; k++)
        search->top[k].score = HUGE_VAL;
    refine(search, SEARCH_ALL, 3 * count);
    choose_best(search);
    return MR_OK;
}

void search_free(struct search *search)
{
    free(search->ensemble);
    free(search->walked);
    *search = (struct search){0};
}
