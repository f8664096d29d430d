/* closed: what a brake release would have come to. See README.md, "Brake release, closed loop".
 *
 *   closed FOLDER KIND FROM COUNT   series FROM .. FROM + COUNT - 1; KIND: chain, late, elastic,
 *                                   planar. The table on stdout
 *
 * Each landing is played to the board's predictor, its risk and its brake release at several limits
 * (survey, transducers at 40 to 110 ft, the plan told with 10 % rms). Where the release is asked
 * for, the landing is computed again from the same joints: 50 ms after the request it is braked by
 * bearing drag alone, 4 to 6 ft/s2 (drawn by series; report 2.7.1). Landings before it in the
 * series are as they were.
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/onboard/release.h"
#include "tests/score/score.h"

#define TOUCHDOWN  3.0f
#define DELAY_S    0.05
#define PLAN_ERROR 0.1
#define LIMITS     6
static const float limits[LIMITS] = {0.3f, 0.5f, 0.7f, 0.8f, 0.9f, 0.95f};

struct tally {
    unsigned asked, refused, avoided, avoided_waves, needless, made;
    double added_ft[4000];
    unsigned added;
};

struct loop {
    const struct score_truth *truth;
    const struct score_landing *landing;
    struct mr_risk_state risk;
    struct release release[LIMITS];
    struct landing state;
    float asked_s[LIMITS];
    bool refused[LIMITS];
    /* of each landing */
    float all_asked_s[SCORE_LANDINGS][LIMITS];
    bool all_refused[SCORE_LANDINGS][LIMITS];
};

static void on_look(void *ctx, const struct score_look *look)
{
    (void)ctx;
    (void)look;
}

static void draw_plan(const struct score_landing *landing, uint32_t series,
                      struct mr_risk_plan *plan)
{
    uint64_t state = 0x91a40000u + 8u * series + landing->number;
    double factor = fmin(fmax(1.0 + PLAN_ERROR * score_normal(&state), 0.5), 1.6),
           bend = fmin(fmax(1.0 + PLAN_ERROR * score_normal(&state), 0.5), 1.6);
    mr_risk_plan_clear(plan);
    plan->speed_ft_s = (float)landing->speed_ft_s;
    for (unsigned i = 0; i < SCORE_KNOTS; i++) {
        plan->knot_s[i] = landing->knot_s[i] * (float)bend;
        plan->knot_ft_s2[i] = landing->knot_ft_s2[i] * (float)factor;
    }
}

static void on_armed(void *ctx, const struct mr_predictor *predictor,
                     const struct score_landing *landing)
{
    struct loop *l = ctx;
    struct mr_risk_plan plan;
    draw_plan(landing, l->truth->series.number, &plan);
    l->landing = landing;
    mr_risk_arm(&l->risk, &plan, predictor, TOUCHDOWN);
    landing_start(&l->state);
    l->state.state = LANDING_LANDING;
    for (unsigned i = 0; i < LIMITS; i++) {
        const struct release_settings settings = {.lamp_limit = NAN,
                                                  .release_limit = limits[i],
                                                  .hold_blocks = 100.0f,
                                                  .most_blocks = 20000.0f,
                                                  .coasting_ft_s2 = 4.0f,
                                                  .spare_ft = 5.0f,
                                                  .crystal = 1.0f};
        release_arm(&l->release[i], &settings, 0);
        l->asked_s[i] = NAN;
        l->refused[i] = false;
    }
}

static void on_block(void *ctx, const struct mr_predictor *predictor,
                     const struct mr_predictor_input *input, unsigned ms)
{
    struct loop *l = ctx;
    struct mr_predictor_zone zone;
    struct mr_risk_said said;
    mr_risk_block(&l->risk, predictor, input);
    if (ms % 10)
        return;
    mr_predictor_zone(predictor, &zone);
    mr_risk_say(&l->risk, predictor, &zone, &said);
    for (unsigned i = 0; i < LIMITS; i++) {
        (void)release_look(&l->release[i], predictor, &zone, &said, &l->state, ms);
        if (release_asked(&l->release[i]) && isnan(l->asked_s[i]))
            l->asked_s[i] = (float)(1e-3 * ms);
        l->refused[i] |= l->release[i].state == MR_RELEASE_REFUSED;
    }
}

static void on_outcome(void *ctx, const struct score_outcome *outcome)
{
    struct loop *l = ctx;
    memcpy(l->all_asked_s[outcome->landing - 1u], l->asked_s, sizeof l->asked_s);
    memcpy(l->all_refused[outcome->landing - 1u], l->refused, sizeof l->refused);
}

static struct tally tally[LIMITS];
static unsigned landings, zones, waves, harmless;

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void judge(const struct loop *l, enum score_kind kind, unsigned i,
                  const struct score_before *before, double drag_ft_s2)
{
    static struct score_landing again;
    const struct score_landing *landing = &l->truth->landing[i];
    double event_s = score_event_s(landing), wave_s = (double)landing->wave_s, last_s = (double)NAN;
    bool zone = !isnan(event_s), wave = !isnan(wave_s), played = false;
    landings++;
    zones += zone;
    waves += wave;
    harmless += !zone && !wave;
    for (unsigned k = 0; k < LIMITS; k++) {
        struct tally *t = &tally[k];
        double asked_s = (double)l->all_asked_s[i][k];
        t->refused += l->all_refused[i][k] && isnan(asked_s);
        if (isnan(asked_s))
            continue;
        t->asked++;
        t->needless += !zone && !wave;
        if (!played || asked_s > last_s || asked_s < last_s) {
            if (!score_truth_released(&l->truth->series, kind, landing->number, before,
                                      asked_s + DELAY_S, drag_ft_s2, &again))
                continue;
            played = true;
            last_s = asked_s;
        }
        bool zone_again = !isnan(score_event_s(&again)), wave_again = !isnan(again.wave_s);
        t->avoided += zone && !zone_again;
        t->avoided_waves += wave && !wave_again;
        t->made += (!zone && zone_again) || (!wave && wave_again);
        if (t->added < 4000u)
            t->added_ft[t->added++] = again.stop_ft - landing->stop_ft;
    }
}

int main(int argc, char **argv)
{
    static struct score_truth truth;
    static struct score_before before[SCORE_LANDINGS];
    static struct loop l;
    static const char *const names[] = {"chain", "planar", "elastic", "late"};
    unsigned kind = 0;
    while (argc == 5 && kind < 4 && strcmp(argv[2], names[kind]) != 0)
        kind++;
    if (argc != 5 || kind == 4 || atoi(argv[3]) < 0 || atoi(argv[4]) < 1) {
        fprintf(stderr, "closed: usage: closed FOLDER chain|planar|elastic|late FROM COUNT\n");
        return 2;
    }
    unsigned from = (unsigned)atoi(argv[3]), count = (unsigned)atoi(argv[4]);
    for (unsigned n = from; n < from + count; n++) {
        const struct score_sink sink = {on_look, on_outcome, on_armed, on_block, &l};
        uint64_t state = 0xd4a60000u + n;
        double drag_ft_s2 = 4.0 + 2.0 * score_uniform(&state);
        if (!score_truth_compute(&truth, n, (enum score_kind)kind, before))
            return 5;
        l.truth = &truth;
        score_play(&truth, SCORE_SURVEYED, 0, &sink);
        for (unsigned i = 0; i < truth.series.landings; i++)
            judge(&l, (enum score_kind)kind, i, &before[i], drag_ft_s2);
    }
    printf("%s, series %u to %u: %u landings, %u with a zone of 50 mats, %u with a wave, %u "
           "harmless\n",
           names[kind], from, from + count - 1u, landings, zones, waves, harmless);
    printf("limit: asked; zones avoided; waves avoided; needless of harmless; made worse; refused; "
           "added way, median and 90 %%, ft\n");
    for (unsigned k = 0; k < LIMITS; k++) {
        struct tally *t = &tally[k];
        qsort(t->added_ft, t->added, sizeof *t->added_ft, by_size);
        printf("%.2f: %u; %u of %u; %u of %u; %u of %u; %u; %u; %.1f %.1f\n", (double)limits[k],
               t->asked, t->avoided, zones, t->avoided_waves, waves, t->needless, harmless, t->made,
               t->refused, t->added ? t->added_ft[t->added / 2] : (double)NAN,
               t->added ? t->added_ft[t->added * 9u / 10u] : (double)NAN);
    }
    return 0;
}
