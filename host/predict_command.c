/* matrig predict: the predictor (common/predictor.h) on a recorded landing, from its readings and edges. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/gates.h"
#include "common/predictor.h"
#include "host/analyse/zones.h"
#include "host/cli.h"
#include "host/run.h"
#include "host/store/store_journal.h"

#define EDGE_KNOWN_S 0.005 /* after it, an edge has its name (common/switches.h) */
#define CHANGED_MATS 5     /* less is no news */

/* The model rig: what the report gives, and what reproduces its movements (tests/runs/README.md). */
static const struct mr_predictor_config rig = {
    .chain = {.mats = 420, .mat_length_ft = 2.0f / 7.0f, .mass_slug = 0.466f / 32.174f, .friction_lb = 0.5f * 0.466f,
              .kl_lb_ft = 2.9e5f, .cl_lb_s_ft = 5.0f, .slack_ft = 0.0025f, .step_s = 1e-3f / 6.0f},
    .grit_lb = 10.0f,
    .thrust_lb_per_g = 1300.0f / 12.0f,
    .deceleration_ft_s2 = 5.0f,
    .bump_ft = 0.0036f,
    .mat_weight_lb = 0.466f,
    .updates_per_block = 1u << 20,
    .level = MR_PREDICTOR_FULL,
};

struct predict {
    struct measured measured;
    struct zones_closure survey;
    struct zones zones; /* what the board said */
    struct mr_predictor predictor;
    size_t gates, beyond; /* so far */
    struct mr_motion_estimate motion;
    bool known;
    json_t *rows;
};

static const char *const verdicts[] = {"quiet", "advisory", "warning"};
static const char *const reasons[] = {"", "zone ahead", "zone growing", "compression"};

static enum mr_status prepare(struct predict *predict, struct error *error)
{
    struct mr_predictor_config config = rig;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct mr_channel_config *channel = &predict->measured.channel[i].config;
        config.station_ft[i] = channel->kind == MR_KIND_DISPLACEMENT ? channel->station_ft : NAN;
    }
    enum mr_status status = mr_predictor_start(&predict->predictor, &config);
    if (status != MR_OK)
        return error_set(error, status, "the predictor refuses its parameters; this is a defect");
    mr_predictor_survey(&predict->predictor, predict->survey.slack_in);
    mr_predictor_arm(&predict->predictor);
    return MR_OK;
}

/* The gear as the board knew it at t_s: an estimate at each gate, carried on. */
static void tell_motion(struct predict *predict, double t_s, struct mr_predictor_input *input)
{
    const struct measured *measured = &predict->measured;
    size_t before = predict->gates;
    while (predict->gates < measured->gates && measured->gate[predict->gates].t_s + EDGE_KNOWN_S <= t_s)
        predict->beyond += measured->gate[predict->gates++].station_ft >= measured->landing.touchdown_ft;
    if (predict->gates != before) {
        size_t skip = predict->beyond >= 2 ? predict->gates - predict->beyond : 0;
        predict->known = mr_gates_now(measured->gate + skip, predict->gates - skip, measured->landing.switch_error_ft,
                                      &predict->motion) == MR_OK;
    }
    if (!predict->known)
        return;
    double v = predict->motion.speed_ft_s.value, a = predict->motion.deceleration_ft_s2.value;
    input->braking_known = predict->beyond >= 3 && !isnan(a);
    a = isnan(a) ? 0.0 : a;
    double since_s = t_s - predict->motion.t_s;
    if (a > 0.0 && since_s > v / a)
        since_s = v / a;
    input->wheel_ft = (float)(predict->motion.position_ft.value + (v - 0.5 * a * since_s) * since_s);
    input->speed_ft_s = (float)(v - a * since_s);
    input->deceleration_ft_s2 = (float)a;
    input->on_runway = (double)input->wheel_ft >= measured->landing.touchdown_ft;
}

static bool news(const struct mr_predictor_zone *now, const struct mr_predictor_zone *last)
{
    return now->verdict != last->verdict || now->level != last->level || now->basis != last->basis ||
           labs((long)now->mats - (long)last->mats) >= CHANGED_MATS ||
           labs((long)now->coming_mats - (long)last->coming_mats) >= CHANGED_MATS;
}

static json_t *number(double value)
{
    return isnan(value) ? json_null() : json_real(value);
}

static void tell(struct predict *predict, double t_s, const struct mr_predictor_zone *zone, const struct cli *cli)
{
    float wheel_ft = predict->predictor.wheel_ft;
    if (cli->json) {
        json_array_append_new(predict->rows,
                              json_pack("{s:f, s:o, s:i, s:o, s:o, s:i, s:o, s:f, s:s, s:i, s:i}", "t_s", t_s, "wheel_ft",
                                        number((double)wheel_ft), "mats", (int)zone->mats, "start_ft",
                                        zone->mats ? json_real((double)zone->start_ft) : json_null(), "end_ft",
                                        zone->mats ? json_real((double)zone->end_ft) : json_null(), "coming_mats",
                                        (int)zone->coming_mats, "coming_ft", number((double)zone->coming_ft), "compression_lb",
                                        (double)zone->compression_lb, "verdict", verdicts[zone->verdict], "level", (int)zone->level,
                                        "basis", (int)zone->basis));
        return;
    }
    char coming[16] = "-";
    if (zone->coming_mats)
        snprintf(coming, sizeof coming, "%.1f", (double)zone->coming_ft);
    printf("%7.3f %7.1f %6u %6.1f +- %-4.1f %6.1f +- %-4.1f %7u %7s %7.1f  %-8s %s%s%s\n", t_s, (double)wheel_ft, zone->mats,
           (double)zone->start_ft, 1.96 * (double)zone->start_error_ft, (double)zone->end_ft, 1.96 * (double)zone->end_error_ft,
           zone->coming_mats, coming, (double)zone->compression_lb, verdicts[zone->verdict], reasons[zone->reason],
           zone->basis & MR_PREDICTOR_BLIND ? " (blind)" : "", zone->mats && !(zone->basis & MR_PREDICTOR_BRACKETED) ? " (inferred)" : "");
}

/* All blocks; the first warning's time, NaN: none. */
static double run_all(struct predict *predict, const struct cli *cli)
{
    const struct measured *measured = &predict->measured;
    struct mr_predictor_zone zone, last = {.level = MR_PREDICTOR_KINEMATIC};
    double warned_s = (double)NAN;
    for (size_t sample = 0; sample < measured->samples; sample++) {
        struct mr_predictor_input input = {.wheel_ft = NAN, .speed_ft_s = NAN, .deceleration_ft_s2 = NAN};
        double t_s = measured_time_s(measured, sample);
        tell_motion(predict, t_s, &input);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            const struct measured_channel *channel = &measured->channel[i];
            input.displacement_in[i] =
                channel->config.kind == MR_KIND_DISPLACEMENT ? (float)measured_value(channel, sample) : NAN;
        }
        mr_predictor_block(&predict->predictor, &input);
        if (sample % MR_PREDICTOR_LOOK_BLOCKS != 0)
            continue;
        mr_predictor_zone(&predict->predictor, &zone);
        if (zone.verdict == MR_PREDICTOR_WARNING && isnan(warned_s))
            warned_s = t_s;
        if (!news(&zone, &last))
            continue;
        tell(predict, t_s, &zone, cli);
        last = zone;
    }
    return warned_s;
}

static void conclude(const struct predict *predict, double warned_s, const struct cli *cli)
{
    const struct zone_warning *board = &predict->zones.warning;
    double board_s = board->warned ? board->t_s : (double)NAN;
    if (cli->json) {
        json_t *whole = json_pack("{s:i, s:O, s:o, s:o, s:i, s:f}", "run", (int)predict->measured.landing.id, "statements",
                                  predict->rows, "first_warning_s", number(warned_s), "board_first_warning_s", number(board_s),
                                  "mat_updates", (int)predict->predictor.updates, "resistance_scale",
                                  (double)predict->predictor.scale);
        json_dumpf(whole, stdout, JSON_INDENT(1));
        putchar('\n');
        json_decref(whole);
        return;
    }
    if (isnan(warned_s))
        printf("predictor: no warning");
    else
        printf("predictor: first warning at %.3f s", warned_s);
    if (isnan(board_s))
        printf("; board: none");
    else
        printf("; board: at %.3f s", board_s);
    printf(". Segments surveyed: %zu. Closing resistance found: %.2f of the one assumed. Mat updates: %.2f million.\n",
           predict->survey.surveyed, (double)predict->predictor.scale, (double)predict->predictor.updates / 1e6);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (predict->predictor.doubt[i] > MR_PREDICTOR_MISSING)
            printf("transducer %u was left out: it %s\n", i + 1u,
                   predict->predictor.doubt[i] == MR_PREDICTOR_DRIFTS ? "drifted" : "disagreed with the model");
    }
}

int predict_command(int argc, char **argv, const struct cli *cli)
{
    static struct predict predict; /* some ten kilobytes */
    const char *words[2];
    bool voided = false;
    const struct cli_option options[] = {{"--void", NULL, &voided}};
    struct error error = {0};
    struct store *store = NULL;
    int64_t run;
    enum mr_status status = cli_parse(argc, argv, options, 1, words, 2, 2, "DB RUN", &error);
    if (status == MR_OK)
        status = run_parse(words[1], &run, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &store, &error);
    if (status == MR_OK)
        status = store_refuse_void(store, run, voided, &error);
    if (status != MR_OK) {
        store_close(store);
        return cli_fail(&error);
    }
    memset(&predict, 0, sizeof predict);
    predict.rows = json_array();
    status = measured_load(store, run, &predict.measured, &error);
    if (status == MR_OK && predict.measured.source == MEASURED_NOTHING)
        status = error_set(&error, MR_USAGE, "no readings: RUN %lld of %s has neither blocks nor displacements", (long long)run, words[0]);
    if (status == MR_OK)
        status = zones_load_survey(store, run, &predict.survey, &error);
    if (status == MR_OK)
        status = zones_load(store, &predict.measured, &predict.zones, &error);
    if (status == MR_OK)
        status = prepare(&predict, &error);
    if (status == MR_OK) {
        if (!cli->json)
            printf("    t_s   wheel   mats   start_ft          end_ft      coming   at_ft press_lb  verdict\n");
        conclude(&predict, run_all(&predict, cli), cli);
    }
    json_decref(predict.rows);
    zones_free(&predict.zones);
    measured_free(&predict.measured);
    store_close(store);
    return status == MR_OK ? 0 : cli_fail(&error);
}
