#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/score/score.h"

#define RESAMPLES 1000
#define OVERLAP   0.5

static const char *const rank_names[SCORE_RANKS] = {"predictor", "thrust alone", "landing count",
                                                    "kinematic", "thrust, later"};

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double quantile(float *values, size_t count, double part)
{
    if (!count)
        return (double)NAN;
    qsort(values, count, sizeof *values, by_value);
    return (double)values[(size_t)(part * (double)(count - 1) + 0.5)];
}

static int mats_of(struct score_zone zone)
{
    return zone.last - zone.first;
}

static bool same(struct score_zone a, struct score_zone b)
{
    int low = a.first > b.first ? a.first : b.first, high = a.last < b.last ? a.last : b.last;
    int shorter = mats_of(a) < mats_of(b) ? mats_of(a) : mats_of(b);
    return shorter > 0 && high - low >= OVERLAP * shorter;
}

static const char *view_name(unsigned view)
{
    static const char *const names[SCORE_VIEWS] = {"no survey, 40-110", "survey, 40-110",
                                                   "no survey, 10-70", "survey, 10-70"};
    return names[view];
}

/* Of the looks whose ends are compared. */
static bool compared(const struct score_look *l)
{
    return l->method == SCORE_PREDICTOR && mats_of(l->truth) >= SCORE_ZONE_MATS &&
           same(l->truth, l->said);
}

static float off_mats(const struct score_look *l, bool end)
{
    return fabsf((float)(end ? l->said.last - l->truth.last : l->said.first - l->truth.first));
}

/* 95 % point over 1.96 of a class; 0: no looks. */
static double calibrate(const struct score_look *looks, size_t count, bool end, unsigned class)
{
    float *off = malloc((count + 1) * sizeof *off);
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        if (compared(&looks[i]) && looks[i].series < SCORE_TRAINED &&
            (end ? looks[i].end_class : looks[i].start_class) == class)
            off[n++] = off_mats(&looks[i], end);
    }
    double error_mats = n ? (quantile(off, n, 0.95) + 0.5) / 1.96 : 0.0;
    printf("    %s class %2u: %6.2f mats, of %zu looks\n", end ? "end" : "start", class, error_mats,
           n);
    free(off);
    return error_mats;
}

/* view SCORE_VIEWS: all of them. */
static void print_held(const struct score_look *looks, size_t count, unsigned view, bool end,
                       const double *error_mats)
{
    size_t n = 0, held = 0;
    for (size_t i = 0; i < count; i++) {
        const struct score_look *l = &looks[i];
        if (!compared(l) || l->series < SCORE_TRAINED || (view < SCORE_VIEWS && l->view != view))
            continue;
        n++;
        held += (double)off_mats(l, end) <=
                1.96 * error_mats[end ? l->end_class : l->start_class] + 1e-6;
    }
    printf(" %s %5.1f %%", end ? "end" : "start", 100.0 * (double)held / (double)n);
}

/* 95 % point of the errors in what is stated now. */
static double wider(const struct score_look *looks, size_t count, bool end, unsigned class,
                    bool held_out)
{
    float *part = malloc((count + 1) * sizeof *part);
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        const struct score_look *l = &looks[i];
        if (!compared(l) || (l->series >= SCORE_TRAINED) != held_out ||
            (class < MR_PREDICTOR_END_CLASSES && (end ? l->end_class : l->start_class) != class))
            continue;
        part[n++] = off_mats(l, end) / (1.96f * (end ? l->end_error : l->start_error));
    }
    double by = quantile(part, n, 0.95);
    free(part);
    return by;
}

void score_calibrate(const struct score_look *looks, size_t count)
{
    double start_mats[MR_PREDICTOR_START_CLASSES], end_mats[MR_PREDICTOR_END_CLASSES];
    printf("\n95 %% points of the errors, and half a mat, over 1.96: series below %d\n",
           SCORE_TRAINED);
    for (unsigned class = 0; class < MR_PREDICTOR_START_CLASSES; class ++)
        start_mats[class] = calibrate(looks, count, false, class);
    for (unsigned class = 0; class < MR_PREDICTOR_END_CLASSES; class ++)
        end_mats[class] = calibrate(looks, count, true, class);
    printf("they hold in series from %d on:\n", SCORE_TRAINED);
    for (unsigned view = 0; view <= SCORE_VIEWS; view++) {
        printf("    %-20s", view < SCORE_VIEWS ? view_name(view) : "all views");
        print_held(looks, count, view, false, start_mats);
        print_held(looks, count, view, true, end_mats);
        printf("\n");
    }
    printf("what is stated now would hold in 95 %% if it were times: start %.3f, end %.3f (series "
           "from %d on %.3f, %.3f); end by class",
           wider(looks, count, false, MR_PREDICTOR_END_CLASSES, false),
           wider(looks, count, true, MR_PREDICTOR_END_CLASSES, false), SCORE_TRAINED,
           wider(looks, count, false, MR_PREDICTOR_END_CLASSES, true),
           wider(looks, count, true, MR_PREDICTOR_END_CLASSES, true));
    for (unsigned class = 0; class < MR_PREDICTOR_END_CLASSES; class ++)
        printf(" %.3f", wider(looks, count, true, class, false));
    printf("\n");
}

struct rank_value {
    float rank;
    bool event;
};

static int by_rank(const void *a, const void *b)
{
    float x = ((const struct rank_value *)a)->rank, y = ((const struct rank_value *)b)->rank;
    return (x > y) - (x < y);
}

double score_auc(const float *rank, const bool *event, size_t count)
{
    struct rank_value *sorted = calloc(count ? count : 1, sizeof *sorted);
    double sum = 0.0, events = 0.0, others = 0.0;
    for (size_t i = 0; i < count; i++)
        sorted[i] = (struct rank_value){rank[i], event[i]};
    qsort(sorted, count, sizeof *sorted, by_rank);
    for (size_t i = 0; i < count;) {
        double here = 0.0, quiet = 0.0;
        float value = sorted[i].rank;
        for (; i < count && !(sorted[i].rank > value); i++) {
            here += sorted[i].event;
            quiet += !sorted[i].event;
        }
        sum += here * (others + 0.5 * quiet);
        events += here;
        others += quiet;
    }
    free(sorted);
    return events > 0.0 && others > 0.0 ? sum / (events * others) : (double)NAN;
}

static void print_zones(const struct score_look *looks, size_t count)
{
    float *start = malloc(count * sizeof *start), *end = malloc(count * sizeof *end);
    printf("zone ends, mats (true zones of %d and more, every %d ms while the wheel rolls)\n",
           SCORE_ZONE_MATS, SCORE_LOOK_MS);
    printf("%-20s %-10s %7s | start: median  90 %% | end: median  90 %%  bias | missed  false | 95 "
           "%% holds: start   end\n",
           "view", "method", "zones");
    size_t all = 0, all_start = 0, all_end = 0;
    for (unsigned view = 0; view < SCORE_VIEWS; view++) {
        for (unsigned method = 0; method < SCORE_METHODS; method++) {
            size_t matched = 0, zones = 0, said = 0, missed = 0, falsely = 0, stated = 0,
                   held_start = 0, held_end = 0;
            double bias = 0.0;
            for (size_t i = 0; i < count; i++) {
                const struct score_look *l = &looks[i];
                if (l->view != view || l->method != method)
                    continue;
                bool true_one = mats_of(l->truth) >= SCORE_ZONE_MATS,
                     both = same(l->truth, l->said);
                zones += true_one;
                said += mats_of(l->said) >= SCORE_ZONE_MATS;
                missed += true_one && !both;
                falsely += mats_of(l->said) >= SCORE_ZONE_MATS &&
                           !(both && 2 * mats_of(l->truth) >= mats_of(l->said));
                if (!true_one || !both)
                    continue;
                float off_start = (float)(l->said.first - l->truth.first),
                      off_end = (float)(l->said.last - l->truth.last);
                start[matched] = fabsf(off_start);
                end[matched++] = fabsf(off_end);
                bias += (double)off_end;
                if (isnan(l->end_error) || l->series < SCORE_TRAINED)
                    continue;
                stated++;
                held_start += fabsf(off_start) <= 1.96f * l->start_error;
                held_end += fabsf(off_end) <= 1.96f * l->end_error;
            }
            printf("%-20s %-10s %7zu | %13.0f %5.0f | %11.0f %5.0f %5.1f | %5.1f%% %5.1f%%",
                   view_name(view), method == SCORE_PREDICTOR ? "predictor" : "kinematic", zones,
                   quantile(start, matched, 0.5), quantile(start, matched, 0.9),
                   quantile(end, matched, 0.5), quantile(end, matched, 0.9), bias / (double)matched,
                   100.0 * (double)missed / (double)zones, 100.0 * (double)falsely / (double)said);
            if (stated)
                printf(" | %17.1f%% %5.1f%%", 100.0 * (double)held_start / (double)stated,
                       100.0 * (double)held_end / (double)stated);
            printf("\n");
            all += stated;
            all_start += held_start;
            all_end += held_end;
        }
    }
    printf("all views, series from %d on: 95 %% intervals hold at the start in %.1f %%, at the end "
           "in %.1f %%\n",
           SCORE_TRAINED, 100.0 * (double)all_start / (double)all,
           100.0 * (double)all_end / (double)all);
    free(start);
    free(end);
}

static void print_warnings(const struct score_outcome *outcomes, size_t count)
{
    float *lead = malloc((count + 1) * sizeof *lead);
    printf("\nwarnings (event: the wheel within %.0f ft of a zone of %d compressed mats or more)\n",
           SCORE_EVENT_FT, SCORE_EVENT_MATS);
    printf("%-20s %-10s %8s %7s | %5s %6s (with a true zone below %d mats) | lead: median s, part "
           "of events warned %.1f s before\n",
           "view", "method", "landings", "events", "hit", "false", SCORE_ZONE_MATS, SCORE_AHEAD_S);
    for (unsigned view = 0; view < SCORE_VIEWS; view++) {
        for (unsigned method = 0; method < SCORE_METHODS; method++) {
            size_t landings = 0, events = 0, hits = 0, alarms = 0, early = 0, far = 0;
            for (size_t i = 0; i < count; i++) {
                const struct score_outcome *o = &outcomes[i];
                if (o->view != view)
                    continue;
                landings++;
                if (isnan(o->event_s)) {
                    alarms += isnan(o->warned_s[method]) ? 0 : 1;
                    far += !isnan(o->warned_s[method]) && o->most_mats < SCORE_ZONE_MATS ? 1 : 0;
                    continue;
                }
                events++;
                if (isnan(o->warned_s[method]))
                    continue;
                lead[hits++] = o->event_s - o->warned_s[method];
                early += (double)(o->event_s - o->warned_s[method]) >= SCORE_AHEAD_S;
            }
            printf("%-20s %-10s %8zu %7zu | %4.0f%% %5.0f%% (%3.0f%%) | %6.2f %13.0f%%\n",
                   view_name(view), method == SCORE_PREDICTOR ? "predictor" : "kinematic", landings,
                   events, 100.0 * (double)hits / (double)events,
                   100.0 * (double)alarms / (double)(landings - events),
                   100.0 * (double)far / (double)(landings - events), quantile(lead, hits, 0.5),
                   100.0 * (double)early / (double)events);
        }
    }
    free(lead);
}

/* Landings as they are ranked: `series` rises. */
struct ranked {
    float *own, *other;
    bool *event;
    uint16_t *series;
    size_t count;
};

static struct ranked make_ranked(size_t most)
{
    return (struct ranked){malloc((most + 1) * sizeof(float)), malloc((most + 1) * sizeof(float)),
                           malloc(most + 1), malloc((most + 1) * sizeof(uint16_t)), 0};
}

static void free_ranked(struct ranked *ranked)
{
    free(ranked->own);
    free(ranked->other);
    free(ranked->event);
    free(ranked->series);
}

/* The difference of two areas when whole series are drawn again with replacement. */
static void bootstrap(const struct ranked *of, double *low, double *high)
{
    size_t series_count = 0;
    size_t *begin = malloc((of->count + 1) * sizeof *begin);
    struct ranked drawn = make_ranked(of->count * SCORE_LANDINGS);
    uint64_t state = 0xb007;
    static float differences[RESAMPLES];
    for (size_t i = 0; i < of->count; i++) {
        if (i == 0 || of->series[i] != of->series[i - 1])
            begin[series_count++] = i;
    }
    begin[series_count] = of->count;
    size_t used = 0;
    for (unsigned r = 0; r < RESAMPLES; r++) {
        size_t n = 0;
        for (size_t k = 0; k < series_count; k++) {
            size_t s = (size_t)(score_uniform(&state) * (double)series_count);
            for (size_t i = begin[s]; i < begin[s + 1]; i++, n++) {
                drawn.own[n] = of->own[i];
                drawn.other[n] = of->other[i];
                drawn.event[n] = of->event[i];
            }
        }
        double difference = score_auc(drawn.own, drawn.event, n) -
                            score_auc(drawn.other, drawn.event, n);
        if (!isnan(difference))
            differences[used++] = (float)difference;
    }
    *low = quantile(differences, used, 0.025);
    *high = quantile(differences, used, 0.975);
    free(begin);
    free_ranked(&drawn);
}

/* The area of `other`, and for another rank than the predictor's how much more its own is. */
static void print_area(const struct ranked *ranked, unsigned view, const char *name, bool own)
{
    double area = score_auc(ranked->other, ranked->event, ranked->count), low, high;
    printf("%-20s %-14s %.3f", view_name(view), name, area);
    if (!own) {
        bootstrap(ranked, &low, &high);
        printf("   %+.3f (%+.3f to %+.3f)",
               score_auc(ranked->own, ranked->event, ranked->count) - area, low, high);
    }
    printf("\n");
}

/* `knowable`: without the events that come before anybody can know the braking and still be
 * SCORE_AHEAD_S ahead. */
static void print_ranks(const struct score_outcome *outcomes, size_t count, bool knowable)
{
    struct ranked ranked = make_ranked(count);
    printf("\nranking landings %.1f s before%s: area under the curve, and the predictor's lead "
           "with its 95 %% bootstrap interval\n",
           SCORE_AHEAD_S, knowable ? ", events at least as long after braking is known" : "");
    for (unsigned view = 0; view < SCORE_VIEWS; view++) {
        for (unsigned r = 0; r < SCORE_RANKS; r++) {
            ranked.count = 0;
            for (size_t i = 0; i < count; i++) {
                const struct score_outcome *o = &outcomes[i];
                if (o->view != view || (knowable && !isnan(o->event_s) &&
                                        !((double)(o->event_s - o->known_s) >= SCORE_AHEAD_S)))
                    continue;
                ranked.own[ranked.count] = o->rank[SCORE_BY_PREDICTOR];
                ranked.other[ranked.count] = o->rank[r];
                ranked.event[ranked.count] = !isnan(o->event_s);
                ranked.series[ranked.count++] = o->series;
            }
            print_area(&ranked, view, rank_names[r], r == SCORE_BY_PREDICTOR);
        }
    }
    free_ranked(&ranked);
}

/* Landings with a wave from the others, by what was said until SCORE_AHEAD_S before; without those
 * whose wave comes before anybody can know the braking and still be so long ahead. */
static void print_wave_ranks(const struct score_outcome *outcomes, size_t count)
{
    static const char *const names[SCORE_WAVE_RANKS] = {
        "zone coming", "compression", "thrust alone", "landing count", "kinematic"};
    struct ranked ranked = make_ranked(count);
    for (unsigned view = 0; view < SCORE_VIEWS; view++) {
        for (unsigned r = 0; r < SCORE_WAVE_RANKS; r++) {
            ranked.count = 0;
            for (size_t i = 0; i < count; i++) {
                const struct score_outcome *o = &outcomes[i];
                if (o->view != view ||
                    (!isnan(o->wave_s) && !((double)(o->wave_s - o->known_s) >= SCORE_AHEAD_S)))
                    continue;
                ranked.own[ranked.count] = o->wave_rank[SCORE_WAVE_COMING];
                ranked.other[ranked.count] = o->wave_rank[r];
                ranked.event[ranked.count] = !isnan(o->wave_s);
                ranked.series[ranked.count++] = o->series;
            }
            print_area(&ranked, view, names[r], r == SCORE_WAVE_COMING);
        }
    }
    free_ranked(&ranked);
}

/* Bow waves of a planar truth: what the warning is for. */
static void print_waves(const struct score_outcome *outcomes, size_t count)
{
    size_t waves = 0, none = 0;
    for (size_t i = 0; i < count; i++)
        waves += isnan(outcomes[i].wave_s) ? 0u : 1u;
    if (!waves)
        return;
    printf("\nbow waves\n");
    for (unsigned view = 0; view < SCORE_VIEWS; view++) {
        size_t warned = 0, early = 0, falsely = 0, advised = 0, advised_falsely = 0, knowable = 0;
        waves = none = 0;
        for (size_t i = 0; i < count; i++) {
            const struct score_outcome *o = &outcomes[i];
            if (o->view != view)
                continue;
            bool told = !isnan(o->warned_s[SCORE_PREDICTOR]), wave = !isnan(o->wave_s);
            bool ahead = wave && told &&
                         (double)(o->wave_s - o->warned_s[SCORE_PREDICTOR]) >= SCORE_AHEAD_S;
            waves += wave ? 1u : 0u;
            none += wave ? 0u : 1u;
            advised += wave && !isnan(o->advised_s) ? 1u : 0u;
            advised_falsely += !wave && !isnan(o->advised_s) ? 1u : 0u;
            knowable += wave && (double)(o->wave_s - o->known_s) >= SCORE_AHEAD_S ? 1u : 0u;
            warned += wave && told ? 1u : 0u;
            early += ahead ? 1u : 0u;
            falsely += !wave && told ? 1u : 0u;
        }
        printf("%-20s %zu of %zu landings (%zu with braking known %.1f s before); warned of %zu, "
               "%.1f s before %zu; warnings without one: "
               "%zu of %zu; advisory or warning: %zu, without one %zu\n",
               view_name(view), waves, waves + none, knowable, SCORE_AHEAD_S, warned, SCORE_AHEAD_S,
               early, falsely, none, advised, advised_falsely);
    }
    print_wave_ranks(outcomes, count);
}

static void print_rest(const struct score_outcome *outcomes, size_t count)
{
    size_t doubted = 0;
    double updates = 0.0;
    for (size_t i = 0; i < count; i++) {
        doubted += outcomes[i].doubted;
        updates += (double)outcomes[i].updates;
    }
    printf("\nsound transducers left out: %zu in %zu landings; mat updates a landing: %.0f\n",
           doubted, count, updates / (double)count);
}

void score_print(const struct score_look *looks, size_t look_count,
                 const struct score_outcome *outcomes, size_t outcome_count)
{
    print_zones(looks, look_count);
    print_warnings(outcomes, outcome_count);
    print_ranks(outcomes, outcome_count, false);
    print_ranks(outcomes, outcome_count, true);
    print_waves(outcomes, outcome_count);
    print_rest(outcomes, outcome_count);
}
