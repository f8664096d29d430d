/* matrig predict: the predictor (common/predictor.h) on recorded landings, from their readings and edges; what the joints have become is
 * carried from one to the next. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/onboard/predict_feed.h"
#include "common/predictor.h"
#include "host/analyse/gear.h"
#include "host/analyse/measured_source.h"
#include "host/analyse/predict_again.h"
#include "host/analyse/zones.h"
#include "host/commands/commands.h"
#include "host/base/run.h"
#include "host/store/store_journal.h"
#include "host/base/units.h"

#define CHANGED_MATS 5     /* less is no news */
#define RUNS_MAX 1000

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
    struct known_gear gear;
    json_t *rows;
    struct mr_predictor_state runway; /* that the board was armed with; recorded: the record has it; resumed: it was begun with */
    bool recorded, resumed;
    /* From the landing before: */
    bool carried, forgets; /* forgets: the board has a predictor itself */
    struct mr_predictor_state state;
    float slack_in[MR_SEGMENTS];
    size_t fresh; /* segments surveyed since */
    char board[25]; /* its uid; empty: not known */
    bool differ;  /* the board said something else than what follows from a record */
};

static const char *const reasons[] = {"", "zone ahead", "zone growing", "compression"};

/* The segments that were surveyed since the landing before. A board with a predictor forgets a survey with the landing that uses it up; one
 * without keeps a reading until there is another, so what is the same to the last digit is no news. */
static void take_survey(struct predict *predict)
{
    float sum_in[MR_SEGMENTS];
    predict->fresh = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float slack_in = predict->survey.slack_in[s], before_in = predict->slack_in[s];
        bool stale = predict->carried && !predict->forgets && !(slack_in < before_in || slack_in > before_in || isnan(before_in));
        sum_in[s] = stale ? NAN : slack_in;
        predict->fresh += isnan(sum_in[s]) ? 0u : 1u;
        predict->slack_in[s] = slack_in;
    }
    mr_predictor_survey(&predict->predictor, sum_in);
}

/* The runway that the board was armed with, where the record has it: what a landing before this one left, which the record of this one
 * alone cannot tell. Its survey is in it. */
static bool take_runway(struct predict *predict)
{
    float sum_in[MR_SEGMENTS];
    if (predict->carried || !predict->recorded || mr_predictor_load(&predict->predictor, &predict->runway) != MR_OK)
        return false;
    predict->fresh = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        sum_in[s] = predict->slack_in[s] = predict->survey.slack_in[s];
        predict->fresh += isnan(sum_in[s]) ? 0u : 1u;
    }
    mr_predictor_surveyed(&predict->predictor, sum_in);
    return true;
}

static enum mr_status prepare(struct predict *predict, struct error *error)
{
    struct mr_predictor_config parameters = rig;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct mr_channel_config *channel = &predict->measured.channel[i].config;
        parameters.station_ft[i] = channel->kind == MR_KIND_DISPLACEMENT ? channel->station_ft : NAN;
    }
    enum mr_status status = mr_predictor_start(&predict->predictor, &parameters);
    if (status == MR_OK && predict->carried)
        status = mr_predictor_load(&predict->predictor, &predict->state);
    if (status != MR_OK)
        return error_set(error, status, "the predictor refuses its parameters; this is a defect");
    predict->resumed = take_runway(predict);
    if (!predict->resumed)
        take_survey(predict);
    mr_predictor_arm(&predict->predictor);
    return MR_OK;
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

/* Half a 95 % interval; none is stated where there is no zone, nor of a kinematic one. */
static void error_text(double error, char text[16])
{
    snprintf(text, 16, isnan(error) ? "-" : "%.1f", 1.96 * error);
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
                                        (double)zone->compression_lb, "verdict", mr_predictor_verdict_text(zone->verdict), "level", (int)zone->level,
                                        "basis", (int)zone->basis));
        return;
    }
    char coming[16] = "-", start[16], end[16];
    double ft = unit_of(UNIT_STATION, cli->si)->factor, lb = unit_of(UNIT_TENSION, cli->si)->factor;
    error_text(ft * (double)zone->start_error_ft, start);
    error_text(ft * (double)zone->end_error_ft, end);
    if (zone->coming_mats)
        snprintf(coming, sizeof coming, "%.1f", ft * (double)zone->coming_ft);
    printf("%7.3f %7.1f %6u %6.1f +- %-4s %6.1f +- %-4s %7u %7s %7.1f  %-8s %s%s%s\n", t_s, ft * (double)wheel_ft, zone->mats,
           ft * (double)zone->start_ft, start, ft * (double)zone->end_ft, end, zone->coming_mats, coming,
           lb * (double)zone->compression_lb, mr_predictor_verdict_text(zone->verdict), reasons[zone->reason],
           zone->basis & MR_PREDICTOR_BLIND ? " (blind)" : "", zone->mats && !(zone->basis & MR_PREDICTOR_BRACKETED) ? " (inferred)" : "");
}

/* All blocks from arming on; the block of the first warning, STORE_NONE: none. Looks fall into the blocks in which the board looks, and
 * bear the board's stamp: the beginning of the block. */
static int64_t run_all(struct predict *predict, const struct cli *cli)
{
    const struct measured *measured = &predict->measured;
    struct mr_predictor_zone zone, last = {.level = MR_PREDICTOR_KINEMATIC};
    int64_t warned_block = STORE_NONE;
    for (size_t sample = 0; sample < measured->samples; sample++) {
        struct mr_predictor_input input;
        int64_t block = measured->first_block + (int64_t)sample;
        double t_s = measured_time_s(measured, sample);
        if (measured->landing.armed_block != STORE_NONE && block < measured->landing.armed_block)
            continue;
        gear_take(&predict->gear, measured->gate, measured->gates, measured->landing.touchdown_ft, measured->landing.switch_error_ft, t_s);
        gear_tell(&predict->gear, measured->landing.touchdown_ft, t_s, &input);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            const struct measured_channel *channel = &measured->channel[i];
            input.displacement_in[i] =
                channel->config.kind == MR_KIND_DISPLACEMENT ? (float)measured_value(channel, sample) : NAN;
        }
        mr_predictor_block(&predict->predictor, &input);
        if (block % PREDICT_LOOK_BLOCKS != 0)
            continue;
        mr_predictor_zone(&predict->predictor, &zone);
        if (zone.verdict == MR_PREDICTOR_WARNING && warned_block == STORE_NONE)
            warned_block = block;
        bool changed = zone.verdict != last.verdict || zone.level != last.level;
        if (!changed && (block % PREDICT_SAY_BLOCKS != 0 || !news(&zone, &last)))
            continue;
        tell(predict, measured_block_s(measured, block), &zone, cli);
        last = zone;
    }
    return warned_block;
}

/* The first warning twice: as this predictor has it from the readings, and as the board decided it. */
struct first_warning {
    int64_t block, board_block; /* STORE_NONE: none */
    double t_s, board_s;
};

static struct first_warning first_warning(const struct predict *predict, int64_t block)
{
    const struct zone_warning *board = &predict->zones.warning;
    return (struct first_warning){
        .block = block,
        .board_block = board->warned ? board->block : STORE_NONE,
        .t_s = block == STORE_NONE ? (double)NAN : measured_block_s(&predict->measured, block),
        .board_s = board->warned ? board->t_s : (double)NAN,
    };
}

static json_t *block_json(int64_t block)
{
    return block == STORE_NONE ? json_null() : json_integer(block);
}

static json_t *conclude_json(const struct predict *predict, const struct first_warning *first, const struct mr_predictor_zone *left)
{
    json_t *object = json_pack("{s:i, s:O, s:o, s:o, s:i, s:i, s:f, s:o}", "run", (int)predict->measured.landing.id, "statements",
                               predict->rows, "first_warning_s", number(first->t_s), "board_first_warning_s", number(first->board_s),
                               "mat_updates", (int)predict->predictor.updates, "segments_surveyed", (int)predict->fresh, "resistance_scale",
                               (double)predict->predictor.scale, "left",
                               left->mats ? json_pack("{s:i, s:f, s:f, s:i}", "mats", (int)left->mats, "start_ft", (double)left->start_ft,
                                                      "end_ft", (double)left->end_ft, "closed_joints", (int)left->closed_joints)
                                          : json_null());
    char doubt[DOUBTS_TEXT];
    doubts_headline(&predict->measured.doubts, doubt);
    json_object_set_new(object, "doubtful", doubt[0] ? json_string(doubt) : json_null());
    json_object_set_new(object, "first_warning_block", block_json(first->block));
    json_object_set_new(object, "board_first_warning_block", block_json(first->board_block));
    json_object_set_new(object, "t0_is_touchdown", json_boolean(predict->measured.t0_is_touchdown));
    json_object_set_new(object, "board_runway", json_boolean(predict->resumed));
    return object;
}

/* Which clock, and why two first warnings may differ. */
static void tell_first(const struct predict *predict, const struct first_warning *first)
{
    if (predict->resumed)
        printf("begun with the runway that the board was armed with\n");
    if (isnan(first->t_s))
        printf("predictor: no warning");
    else
        printf("predictor: first warning at %.3f s", first->t_s);
    if (isnan(first->board_s))
        printf("; board: none");
    else
        printf("; board: at %.3f s", first->board_s);
    if (!isnan(first->board_s))
        printf(" (decided in block %lld)", (long long)first->board_block);
    if (!isnan(first->t_s) || !isnan(first->board_s))
        printf("; seconds after %s, by the board's clock", predict->measured.t0_is_touchdown ? "touchdown" : "the first switch or arming");
    if (first->block != first->board_block)
        printf("; two computations: this one has all the time it wants and the usual parameters, the board's is computed again below");
}

static void conclude(const struct predict *predict, const struct first_warning *first, const struct mr_predictor_zone *left, const struct cli *cli)
{
    const struct unit *station = unit_of(UNIT_STATION, cli->si);
    tell_first(predict, first);
    printf(". Segments surveyed: %zu. Closing resistance found: %.2f of the one assumed. Mat updates: %.2f million.\n", predict->fresh,
           (double)predict->predictor.scale, (double)predict->predictor.updates / 1e6);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (predict->predictor.doubt[i] > MR_PREDICTOR_MISSING)
            printf("transducer %u was left out: it %s\n", i + 1u,
                   predict->predictor.doubt[i] == MR_PREDICTOR_DRIFTS ? "drifted" : "disagreed with the model");
    }
    if (left->mats)
        printf("left ahead of the stop: %u mats closed, stations %.1f to %.1f %s, %u closed joints\n", left->mats,
               station->factor * (double)left->start_ft, station->factor * (double)left->end_ft, station->text, left->closed_joints);
}

static void tell_lost(const struct predict_again *again)
{
    if (again->possible && again->lacks_block != STORE_NONE)
        printf("computed again up to block %lld, which the record lacks\n", (long long)again->lacks_block);
    if (again->lost)
        printf("not compared: %zu fields or statements that were lost on the way\n", again->lost);
}

/* Did the board say what follows from its record, bit by bit? */
static void tell_again(const struct predict_again *again)
{
    if (!again->possible)
        printf("the board's own run cannot be computed again: the record lacks %s\n", again->lacks);
    else if (!again->differ)
        printf("computed again from the record: %zu statements of the board, %zu fields, all the same to the last bit\n", again->said,
               again->fields);
    else
        printf("computed again from the record: %zu of %zu fields of %zu statements DIFFER; first block %lld, %s: board %.10g, host %.10g\n",
               again->differ, again->fields, again->made, (long long)again->first.block, again->first.field, again->first.said,
               again->first.made);
}

static json_t *again_json(const struct predict_again *again)
{
    json_t *object = json_pack("{s:b, s:i, s:i, s:i, s:i}", "possible", again->possible, "statements", (int)again->said, "fields",
                               (int)again->fields, "differ", (int)again->differ, "backlogs", (int)again->backlogs);
    json_object_set_new(object, "first_warning_block", block_json(again->warned_block));
    json_object_set_new(object, "lost", json_integer((json_int_t)again->lost));
    json_object_set_new(object, "lacks_block", again->lacks_block == STORE_NONE ? json_null() : json_integer((json_int_t)again->lacks_block));
    json_object_set_new(object, "lacks", again->lacks ? json_string(again->lacks) : json_null());
    json_object_set_new(object, "first",
                        again->differ ? json_pack("{s:I, s:s, s:o, s:o}", "block", (json_int_t)again->first.block, "field", again->first.field,
                                                  "board", number(again->first.said), "host", number(again->first.made))
                                      : json_null());
    return object;
}

/* One landing. `results`: NULL, or where its object goes. */
static enum mr_status predict_run(struct predict *predict, struct store *store, int64_t run, json_t *results, const struct cli *cli,
                                  struct error *error)
{
    struct mr_predictor_zone left;
    struct predict_again again;
    int64_t source;
    predict->gear = (struct known_gear){0};
    predict->rows = json_array();
    enum mr_status status = measured_load(store, run, &predict->measured, error);
    measured_aside_note(&predict->measured, cli);
    if (status == MR_OK && predict->measured.source == MEASURED_NOTHING)
        status = error_set(error, MR_USAGE, "no readings: RUN %lld has neither blocks nor displacements", (long long)run);
    const char *board = predict->measured.landing.board_uid;
    if (status == MR_OK && board[0] && predict->board[0] && strcmp(board, predict->board) != 0)
        status = error_set(error, MR_USAGE, "RUN %lld is of board %s, those before of %s: give the landings of one runway", (long long)run,
                           board, predict->board);
    if (status == MR_OK && board[0])
        memcpy(predict->board, board, sizeof predict->board);
    if (status == MR_OK)
        status = zones_load_survey(store, run, &predict->survey, error);
    if (status == MR_OK)
        status = zones_load(store, &predict->measured, &predict->zones, error);
    if (status == MR_OK)
        status = store_runway_get(store, run, &predict->runway, &source, &predict->recorded, error);
    predict->forgets = predict->recorded;
    if (status == MR_OK)
        status = prepare(predict, error);
    if (status == MR_OK) {
        char doubt[DOUBTS_TEXT];
        doubts_headline(&predict->measured.doubts, doubt);
        if (!results && doubt[0])
            printf("RUN %lld %s\n", (long long)run, doubt);
        if (!results)
            puts(cli->si ? "    t_s   wheel   mats   start_m           end_m       coming    at_m press_N   verdict"
                         : "    t_s   wheel   mats   start_ft          end_ft      coming   at_ft press_lb  verdict");
        struct first_warning first = first_warning(predict, run_all(predict, cli));
        mr_predictor_zone(&predict->predictor, &left);
        status = predict_again(store, run, &again, error);
        if (results) {
            json_t *object = conclude_json(predict, &first, &left);
            json_object_set_new(object, "again", again_json(&again));
            json_array_append_new(results, object);
        } else {
            conclude(predict, &first, &left, cli);
            tell_lost(&again);
            tell_again(&again);
        }
        predict->differ |= again.differ > 0;
        mr_predictor_fold(&predict->predictor);
        mr_predictor_save(&predict->predictor, &predict->state);
        predict->carried = true;
    }
    json_decref(predict->rows);
    zones_free(&predict->zones);
    measured_free(&predict->measured);
    memset(&predict->zones, 0, sizeof predict->zones);
    memset(&predict->measured, 0, sizeof predict->measured);
    return status;
}

static enum mr_status parse_runs(const char *const *words, int64_t *runs, size_t *count, struct error *error)
{
    enum mr_status status = MR_OK;
    for (*count = 0; words[*count] && status == MR_OK; ++*count) {
        status = run_parse(words[*count], &runs[*count], error);
        if (status == MR_OK && *count > 0 && runs[*count] <= runs[*count - 1])
            return error_set(error, MR_USAGE, "out of order: RUN %s after %s; give landings in the order in which they were made",
                             words[*count], words[*count - 1]);
    }
    return status;
}

static int print_results(json_t *results, int exit_code)
{
    json_t *whole = json_array_size(results) == 1 ? json_incref(json_array_get(results, 0)) : json_pack("{s:O}", "runs", results);
    json_decref(results);
    bool failed = json_dumpf(whole, stdout, JSON_INDENT(1)) != 0 || putchar('\n') == EOF || fflush(stdout) != 0;
    json_decref(whole);
    if (failed)
        fputs("matrig: cannot write the result: standard output; check where it goes\n", stderr);
    return failed ? mr_status_exit_code(MR_IO) : exit_code;
}

struct request {
    bool voided;
};

static int predict_command(int argc, char **argv, const struct cli *cli)
{
    static struct predict predict; /* some ten kilobytes */
    static const char *words[RUNS_MAX + 2];
    static int64_t runs[RUNS_MAX];
    struct request r = {0};
    struct error error = {0};
    struct store *store = NULL;
    json_t *results = cli->json ? json_array() : NULL;
    size_t count = 0;
    enum mr_status status = command_parse(&command_predict, argc, argv, cli, &r, words, &error);
    if (status == MR_OK)
        status = parse_runs(words + 1, runs, &count, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &store, &error);
    if (status != MR_OK) {
        json_decref(results);
        return cli_fail(&error);
    }
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (count > 1 && !cli->json)
            printf("%srun %lld\n", i ? "\n" : "", (long long)runs[i]);
        status = store_refuse_void(store, runs[i], r.voided, &error);
        if (status == MR_OK)
            status = predict_run(&predict, store, runs[i], results, cli, &error);
    }
    store_close(store);
    int exit_code = predict.differ ? mr_status_exit_code(MR_LIMIT) : 0;
    if (status == MR_OK && cli->json)
        return print_results(results, exit_code);
    json_decref(results);
    return status == MR_OK ? exit_code : cli_fail(&error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB RUN",
                "campaign database and number of the landing in it, from 1; of several, in order, each begins with\n"
                "what the joints have become in the one before, and with the segments surveyed since:\n"
                "matrig predict campaign.db 1 2 3 4 5"),
    HELP_NOTE("A row for each change: longest closed zone ahead of the wheel with its 95 % intervals, longest zone that the\n"
              "wheel will meet or push together before it stops, compression ahead, verdict. It knows at each time what the\n"
              "board knew then: edges so far, readings so far, the survey, and, where the record has it, the runway that the board\n"
              "was armed with (of several landings for the first). Times are seconds after touchdown by the board's clock, at the\n"
              "beginning of the block that decided, as in log, report and make series."),
    OPTION_FLAG("--void", voided, "also of a landing that was voided"),
    HELP_EXAMPLE("matrig predict campaign.db 5"),
};

const struct command command_predict = {
    "predict", predict_command,
    "DB RUN... [--void]",
    "the predictor of zones and warnings on recorded landings", COMMAND_PARTS(parts), {2, RUNS_MAX + 1, "DB RUN"},
};
