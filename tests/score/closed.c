/* closed: what a brake release would have come to. See README.md, "Brake release, closed loop".
 *
 *   closed FOLDER KIND FROM COUNT [share]   series FROM .. FROM + COUNT - 1; KIND: chain, late,
 *                                           elastic, planar; share: of the thrust that the strip
 *                                           bears, measured within 3 %. The table on stdout
 *
 * Each landing is played to the board's predictor, its risk and its brake release at several limits
 * (survey, transducers at 40 to 110 ft, plan and chart told, the plan off by 10 % rms). Where the
 * release is asked for, the landing is computed again from the same joints, braked from 50 ms after
 * the request on by no more than what the circuit leaves:
 *
 *   released  bearing drag alone, 4 to 6 ft/s2 (drawn by series; report 2.7.1)
 *   reduced   what a pressure reducer leaves that was set before the landing to the least braking
 *             that stops the planned speed with 5 ft of runway left
 *   eased     what the board asks for: the least that does so from there on
 *   pulsed    the same in the mean, by a valve that lets the brake go ten times a second
 *
 * Landings before it in the series are as they were. Beside these stands what nobody can do better
 * with the same means: all landings with a wave, and no others, eased 0.5 s after touchdown.
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/onboard/release.h"
#include "host/base/ordered.h"
#include "tests/score/advised.h"

#define TOUCHDOWN_FT 3.0f
#define RUNWAY_FT    ((float)(SCORE_MATS * SCORE_MAT_FT))
#define SPARE_FT     5.0f
#define DRAG_FT_S2   4.0f /* configured */
#define DELAY_S      0.05
#define PERFECT_S    0.5
#define PULSE_S      0.1
#define LANDINGS     2000u
#define LIMITS       7
static const float limits[LIMITS] = {0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f};
enum way { RELEASED, REDUCED, EASED, PULSED, WAYS };
static const char *const way_names[WAYS] = {"released", "reduced", "eased", "pulsed"};

struct tally {
    unsigned asked, refused, zones, waves, needless, made, off;
    double added_ft[LANDINGS];
    unsigned added;
};

/* What came of one landing at one limit. */
struct request {
    float asked_s, level_ft_s2; /* NaN: never asked for */
    bool refused;
};

struct loop {
    const struct score_truth *truth;
    struct advised_chart chart[SCORE_LANDINGS];
    struct mr_risk_state risk;
    struct release release[WAYS][LIMITS];
    struct landing state;
    struct request request[SCORE_LANDINGS][WAYS][LIMITS];
    unsigned landing;
};

static struct advised_told told = {
    .view = SCORE_SURVEYED, .friction_times = 1.0, .plan_error = 0.1, .harder = 1.0};

static void on_look(void *ctx, const struct score_look *look)
{
    (void)ctx;
    (void)look;
}

static void on_armed(void *ctx, const struct mr_predictor *predictor,
                     const struct score_landing *landing)
{
    struct loop *l = ctx;
    struct mr_risk_plan plan;
    l->landing = landing->number - 1u;
    advised_draw_plan(landing, l->truth->series.number, &told, &plan);
    advised_chart_put(&l->chart[l->landing], ADVISED_ROWS, &plan);
    mr_risk_arm(&l->risk, &plan, predictor, TOUCHDOWN_FT);
    landing_start(&l->state);
    l->state.state = LANDING_LANDING;
    float reduced_ft_s2 = 0.5f * plan.speed_ft_s * plan.speed_ft_s /
                          (RUNWAY_FT - SPARE_FT - TOUCHDOWN_FT);
    for (unsigned w = 0; w < WAYS; w++) {
        for (unsigned i = 0; i < LIMITS; i++) {
            const struct release_settings settings = {
                .lamp_limit = NAN,
                .release_limit = limits[i],
                .hold_blocks = 20.0f,
                .most_blocks = 20000.0f,
                .coasting_ft_s2 = w == REDUCED && reduced_ft_s2 > DRAG_FT_S2 ? reduced_ft_s2
                                                                             : DRAG_FT_S2,
                .spare_ft = SPARE_FT,
                .crystal = 1.0f,
                .eases = w == EASED || w == PULSED ? 1.0f : 0.0f};
            release_arm(&l->release[w][i], &settings, 0);
            l->request[l->landing][w][i] = (struct request){.asked_s = NAN, .level_ft_s2 = NAN};
        }
    }
}

/* The gates that the wheel has come to. */
static void open_gates(struct loop *l, float t_s)
{
    const struct score_landing *landing = &l->truth->landing[l->landing];
    struct mr_passage *passage = &l->state.passage;
    passage->state = MR_PASSAGE_ROLLING;
    passage->gates = l->state.gates_on_track = 0;
    for (unsigned i = 0; i < landing->edges && landing->edge_s[i] <= t_s; i++) {
        passage->gate[passage->gates++].station_ft = (double)landing->edge_ft[i];
        l->state.gates_on_track += landing->edge_ft[i] < TOUCHDOWN_FT;
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
    open_gates(l, 1e-3f * (float)ms);
    mr_predictor_zone(predictor, &zone);
    mr_risk_say(&l->risk, predictor, &zone, &said);
    for (unsigned w = 0; w < WAYS; w++) {
        for (unsigned i = 0; i < LIMITS; i++) {
            struct release *release = &l->release[w][i];
            struct request *request = &l->request[l->landing][w][i];
            (void)release_look(release, predictor, &zone, &said, &l->state, ms);
            request->refused |= release->state == MR_RELEASE_REFUSED;
            if (!release_asked(release) || !isnan(request->asked_s))
                continue;
            request->asked_s = (float)(1e-3 * ms);
            request->level_ft_s2 = w == RELEASED || isnan(release->ease_ft_s2)
                                     ? release->settings.coasting_ft_s2
                                     : release->ease_ft_s2;
        }
    }
}

static void on_outcome(void *ctx, const struct score_outcome *outcome)
{
    (void)ctx;
    (void)outcome;
}

static struct tally tally[WAYS][LIMITS], perfect;
static unsigned landings, zones, waves, harmless;

/* The landing again; what it was is `zone`, `wave`. */
static void play_again(const struct loop *l, enum score_kind kind, unsigned i,
                       const struct score_before *before, const struct score_release *release,
                       struct tally *t)
{
    static struct score_landing again;
    const struct score_landing *landing = &l->truth->landing[i];
    bool zone = !isnan(score_event_s(landing)), wave = !isnan(landing->wave_s);
    t->asked++;
    t->needless += !zone && !wave;
    if (!score_truth_released(&l->truth->series, kind, landing->number, before, release, &again))
        return;
    bool zone_again = !isnan(score_event_s(&again)), wave_again = !isnan(again.wave_s);
    t->zones += zone && !zone_again;
    t->waves += wave && !wave_again;
    t->made += (!zone && zone_again) || (!wave && wave_again);
    t->off += again.stop_ft > (double)RUNWAY_FT;
    if (t->added < LANDINGS)
        t->added_ft[t->added++] = again.stop_ft - landing->stop_ft;
}

static void judge(const struct loop *l, enum score_kind kind, unsigned i,
                  const struct score_before *before, double drag_ft_s2)
{
    const struct score_landing *landing = &l->truth->landing[i];
    bool zone = !isnan(score_event_s(landing)), wave = !isnan(landing->wave_s);
    double known_s = landing->touchdown_s + PERFECT_S;
    landings++;
    zones += zone;
    waves += wave;
    harmless += !zone && !wave;
    for (unsigned w = 0; w < WAYS; w++) {
        for (unsigned k = 0; k < LIMITS; k++) {
            const struct request *r = &l->request[i][w][k];
            tally[w][k].refused += r->refused && isnan(r->asked_s);
            const struct score_release release = {
                .from_s = (double)r->asked_s + DELAY_S,
                .most_ft_s2 = w == RELEASED ? drag_ft_s2 : fmax((double)r->level_ft_s2, drag_ft_s2),
                .pulse_s = w == PULSED ? PULSE_S : 0.0,
                .drag_ft_s2 = drag_ft_s2};
            if (!isnan(r->asked_s))
                play_again(l, kind, i, before, &release, &tally[w][k]);
        }
    }
    unsigned look = (unsigned)(1e3 * known_s / SCORE_LOOK_MS);
    if (wave && look < landing->looks) {
        double v = (double)landing->speed_at_ft_s[look];
        const struct score_release release = {
            .from_s = known_s,
            .most_ft_s2 = 0.5 * v * v /
                          ((double)(RUNWAY_FT - SPARE_FT) - (double)landing->wheel_ft[look])};
        play_again(l, kind, i, before, &release, &perfect);
    }
}

static void print(const char *name, double limit, struct tally *t)
{
    order_numbers(t->added_ft, t->added);
    printf("| %s | %.2f | %u | %u of %u | %u of %u | %u of %u | %u | %u | %u | %.1f, %.1f |\n",
           name, limit, t->asked, t->waves, waves, t->zones, zones, t->needless, harmless, t->made,
           t->off, t->refused, t->added ? t->added_ft[t->added / 2] : (double)NAN,
           t->added ? t->added_ft[t->added * 9u / 10u] : (double)NAN);
}

int main(int argc, char **argv)
{
    static struct score_truth truth;
    static struct score_before before[SCORE_LANDINGS];
    static struct loop l;
    static const double factors[ADVISED_ROWS] = {0.7, 1.0, 1.4};
    told.share = argc == 6 && strcmp(argv[5], "share") == 0;
    enum score_kind kind = argc == 5 || told.share ? score_kind_find(argv[2]) : SCORE_KINDS;
    if (kind == SCORE_KINDS || atoi(argv[3]) < 0 || atoi(argv[4]) < 1) {
        fprintf(stderr,
                "closed: usage: closed FOLDER chain|planar|elastic|late FROM COUNT [share]\n");
        return 2;
    }
    unsigned from = (unsigned)atoi(argv[3]), count = (unsigned)atoi(argv[4]);
    for (unsigned n = from; n < from + count; n++) {
        const struct score_sink sink = {on_look, on_outcome, on_armed, on_block, &l};
        uint64_t state = 0xd4a60000u + n;
        double drag_ft_s2 = 4.0 + 2.0 * score_uniform(&state);
        if (!score_truth_compute(&truth, n, kind, before) ||
            !advised_charts(&truth, &told, factors, ADVISED_ROWS, l.chart))
            return 5;
        l.truth = &truth;
        score_play(&truth, SCORE_SURVEYED, 0, &sink);
        for (unsigned i = 0; i < truth.series.landings; i++)
            judge(&l, kind, i, &before[i], drag_ft_s2);
    }
    printf("%s, series %u to %u: %u landings, %u with a zone of 50 mats, %u with a wave, %u "
           "harmless\n\n",
           argv[2], from, from + count - 1u, landings, zones, waves, harmless);
    printf(
        "| circuit | limit | asked | waves avoided | zones avoided | needless of harmless | made "
        "worse | off the runway | refused, never asked | added way, median and 90 %%, ft |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (unsigned w = 0; w < WAYS; w++) {
        for (unsigned k = 0; k < LIMITS; k++)
            print(way_names[w], (double)limits[k], &tally[w][k]);
    }
    print("eased, told which", (double)NAN, &perfect);
    return 0;
}
