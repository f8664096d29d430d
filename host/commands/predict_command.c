/* matrig predict: the predictor (common/predictor.h) on recorded landings, from their readings and
 * edges; what the joints have become is carried from one to the next. */
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
#include "host/base/answer.h"
#include "host/base/run.h"
#include "host/store/store_journal.h"
#include "host/base/units.h"

#define CHANGED_MATS 5 /* less is no news */
#define RUNS_MAX     1000
#define DIGITS       17 /* all that a double has */

/* The model rig: what the report gives, and what reproduces its movements
 * (tests/runs/README.md). */
static const struct mr_predictor_config rig = {
    .chain = {.mats = 420,
              .mat_length_ft = 2.0f / 7.0f,
              .mass_slug = 0.466f / 32.174f,
              .friction_lb = 0.5f * 0.466f,
              .kl_lb_ft = 2.9e5f,
              .cl_lb_s_ft = 5.0f,
              .slack_ft = 0.0025f,
              .step_s = 1e-3f / 6.0f},
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
    /* that the board was armed with; recorded: the record has it; resumed: it was begun with */
    struct mr_predictor_state runway;
    bool recorded, resumed;
    /* From the landing before: */
    bool carried, forgets; /* forgets: the board has a predictor itself */
    struct mr_predictor_state state;
    float slack_in[MR_SEGMENTS];
    size_t fresh;   /* segments surveyed since */
    char board[25]; /* its uid; empty: not known */
    bool differ;    /* the board said something else than what follows from a record */
};

/* as the heading of the table explains */
static const char *const reasons[] = {"", ", ahead", ", growing", ", pressed"};

/* The segments that were surveyed since the landing before. A board with a predictor forgets a
 * survey with the landing that uses it up; one without keeps a reading until there is another, so
 * what is the same to the last digit is no news. */
static void take_survey(struct predict *predict)
{
    float sum_in[MR_SEGMENTS];
    predict->fresh = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float slack_in = predict->survey.slack_in[s], before_in = predict->slack_in[s];
        bool stale = predict->carried && !predict->forgets &&
                     !(slack_in < before_in || slack_in > before_in || isnan(before_in));
        sum_in[s] = stale ? NAN : slack_in;
        predict->fresh += isnan(sum_in[s]) ? 0u : 1u;
        predict->slack_in[s] = slack_in;
    }
    mr_predictor_survey(&predict->predictor, sum_in);
}

/* The runway that the board was armed with, where the record has it: what a landing before this one
 * left, which the record of this one alone cannot tell. Its survey is in it. */
static bool take_runway(struct predict *predict)
{
    float sum_in[MR_SEGMENTS];
    if (predict->carried || !predict->recorded ||
        mr_predictor_load(&predict->predictor, &predict->runway) != MR_OK)
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
        parameters.station_ft[i] = channel->kind == MR_KIND_DISPLACEMENT ? channel->station_ft
                                                                         : NAN;
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
    return now->verdict != last->verdict || now->level != last->level ||
           now->basis != last->basis || labs((long)now->mats - (long)last->mats) >= CHANGED_MATS ||
           labs((long)now->coming_mats - (long)last->coming_mats) >= CHANGED_MATS;
}

/* With its standard error; none is stated where there is no zone, nor of a kinematic one. */
static void end_answer(struct answer *answer, const char *name, const char *label,
                       const struct mr_predictor_zone *zone, float at_ft, float error_ft)
{
    double value_ft = zone->mats ? (double)at_ft : (double)NAN;
    answer_estimate(answer, name, label, UNIT_STATION, value_ft,
                    zone->mats ? (double)error_ft : (double)NAN, 1)
        ->digits = DIGITS;
}

static void tell(const struct predict *predict, double t_s, const struct mr_predictor_zone *zone,
                 struct answer *answer)
{
    const bool si = answer_in_si(answer); /* to a newton and a tenth of a metre: the columns fit */
    answer_row(answer);
    answer_value(answer, "t", "time", UNIT_TIME, t_s, 3)->digits = DIGITS;
    answer_value(answer, "wheel", "wheel", UNIT_STATION, (double)predict->predictor.wheel_ft, 1)
        ->digits = DIGITS;
    answer_count(answer, "mats", "mats", zone->mats);
    end_answer(answer, "start", "start", zone, zone->start_ft, zone->start_error_ft);
    end_answer(answer, "end", "end", zone, zone->end_ft, zone->end_error_ft);
    answer_count(answer, "coming_mats", "next|mats", zone->coming_mats);
    answer_value(answer, "coming", "next|at", UNIT_STATION,
                 zone->coming_mats ? (double)zone->coming_ft : (double)NAN, si ? 0 : 1)
        ->digits = DIGITS;
    answer_value(answer, "compression", "push", UNIT_TENSION, (double)zone->compression_lb,
                 si ? 0 : 1)
        ->digits = DIGITS;
    answer_words(answer, "verdict", NULL, "%s", mr_predictor_verdict_text(zone->verdict));
    answer_words(answer, NULL, "verdict", "%s%s", mr_predictor_verdict_text(zone->verdict),
                 reasons[zone->reason]);
    /* who is blind infers all */
    answer_words(answer, NULL, "basis", "%s",
                 zone->basis & MR_PREDICTOR_BLIND                        ? "blind"
                 : zone->mats && !(zone->basis & MR_PREDICTOR_BRACKETED) ? "inferred"
                                                                         : "");
    answer_count(answer, "level", NULL, zone->level);
    answer_count(answer, "basis", NULL, zone->basis);
}

/* All blocks from arming on; the block of the first warning, STORE_NONE: none. Looks fall into the
 * blocks in which the board looks, and bear the board's stamp: the beginning of the block. */
static int64_t run_all(struct predict *predict, struct answer *answer)
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
        gear_take(&predict->gear, measured->gate, measured->gates, measured->landing.touchdown_ft,
                  measured->landing.switch_error_ft, t_s);
        gear_tell(&predict->gear, measured->landing.touchdown_ft, t_s, &input);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            const struct measured_channel *channel = &measured->channel[i];
            input.displacement_in[i] = channel->config.kind == MR_KIND_DISPLACEMENT
                                         ? (float)measured_value(channel, sample)
                                         : NAN;
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
        tell(predict, measured_block_s(measured, block), &zone, answer);
        last = zone;
    }
    return warned_block;
}

/* The first warning twice: as this predictor has it from the readings, and as the board decided
 * it. */
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

/* Which clock, and why two first warnings may differ. */
static void first_answer(const struct predict *predict, const struct first_warning *first,
                         struct answer *answer)
{
    const char *clock = predict->measured.t0_is_touchdown
                          ? "touchdown, by the board's clock"
                          : "the first switch or arming, by the board's clock";
    char quiet[ZONES_QUIET], doubt[ZONES_HEARD_TEXT];
    if (predict->resumed)
        answer_words(answer, NULL, "begun with", "the runway that the board was armed with");
    if (isnan(first->t_s))
        answer_words(answer, NULL, "predictor", "no warning");
    else
        answer_words(answer, NULL, "predictor", "first warning at %.3f s after %s", first->t_s,
                     clock);
    zones_quiet_text(&predict->zones, quiet);
    if (isnan(first->board_s))
        answer_words(answer, NULL, "board", "%s", quiet);
    else
        answer_words(answer, NULL, "board",
                     "first warning at %.3f s after %s; decided in block %lld", first->board_s,
                     clock, (long long)first->board_block);
    if (zones_earlier_text(&predict->zones, doubt))
        answer_words(answer, NULL, "board", "an earlier one may have come: %s", doubt)->warn = true;
    if (first->block != first->board_block)
        answer_words(answer, NULL, "board",
                     "two computations: the predictor's has all the time it wants and the usual "
                     "parameters, the board's is computed again below");
    answer_value(answer, "first_warning_s", NULL, UNIT_NUMBER, first->t_s, 3)->digits = DIGITS;
    answer_value(answer, "board_first_warning_s", NULL, UNIT_NUMBER, first->board_s, 3)->digits =
        DIGITS;
    answer_count(answer, "first_warning_block", NULL, first->block);
    answer_count(answer, "board_first_warning_block", NULL, first->board_block);
    answer_flag(answer, "t0_is_touchdown", NULL, predict->measured.t0_is_touchdown);
    answer_flag(answer, "board_runway", NULL, predict->resumed);
}

static void left_answer(const struct mr_predictor_zone *left, bool stopped, struct answer *answer)
{
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    if (!left->mats) {
        answer_none(answer, "left", NULL, "");
        return;
    }
    answer_words(answer, NULL, "left",
                 "ahead of %s: %u mats closed, stations %.1f to %.1f %s, %u closed joints",
                 stopped ? "the stop" : "the gear when the record ends", left->mats,
                 station->factor * (double)left->start_ft, station->factor * (double)left->end_ft,
                 station->text, left->closed_joints);
    answer_open(answer, "left", NULL);
    answer_count(answer, "mats", NULL, left->mats);
    answer_value(answer, "start", NULL, UNIT_STATION, (double)left->start_ft, 1)->digits = DIGITS;
    answer_value(answer, "end", NULL, UNIT_STATION, (double)left->end_ft, 1)->digits = DIGITS;
    answer_count(answer, "closed_joints", NULL, left->closed_joints);
    answer_close(answer);
}

static void conclude(const struct predict *predict, const struct first_warning *first,
                     const struct mr_predictor_zone *left, struct answer *answer)
{
    first_answer(predict, first, answer);
    answer_count(answer, "segments_surveyed", "surveyed", (int64_t)predict->fresh);
    answer_value(answer, "resistance_scale", NULL, UNIT_NUMBER, (double)predict->predictor.scale, 2)
        ->digits = DIGITS;
    answer_words(answer, NULL, "resistance", "of closing joints: %.2f of the one assumed",
                 (double)predict->predictor.scale);
    answer_count(answer, "mat_updates", "mat updates", predict->predictor.updates);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (predict->predictor.doubt[i] > MR_PREDICTOR_MISSING)
            answer_words(answer, NULL, "left out", "transducer %u: it %s", i + 1u,
                         predict->predictor.doubt[i] == MR_PREDICTOR_DRIFTS
                             ? "drifted"
                             : "disagreed with the model");
    }
    left_answer(left, predict->measured.fit_status == MR_OK, answer);
}

/* A field that was left open is NaN on the wire. */
static void field_text(double value, char out[static 40])
{
    if (isnan(value))
        snprintf(out, 40, "nothing");
    else
        snprintf(out, 40, "%.10g", value);
}

/* Did the board say what follows from its record, bit by bit? */
static void again_words(const struct predict_again *again, struct answer *answer)
{
    static const char label[] = "again";
    char said[40], made[40];
    field_text(again->first.said, said);
    field_text(again->first.made, made);
    if (again->possible && again->lacks_block != STORE_NONE)
        answer_words(answer, NULL, label, "computed again up to block %lld, which the record lacks",
                     (long long)again->lacks_block);
    if (again->lost)
        answer_words(answer, NULL, label,
                     "not compared: %zu fields or statements that were lost on the way",
                     again->lost);
    if (!again->possible)
        answer_words(answer, NULL, label,
                     "the board's own run cannot be computed again: the record lacks %s",
                     again->lacks);
    else if (!again->differ)
        answer_words(answer, NULL, label,
                     "computed again from the record: %zu statements of the board, %zu fields, all "
                     "the same to the last bit",
                     again->said, again->fields);
    else
        answer_words(answer, NULL, label,
                     "computed again from the record: %zu of %zu fields of %zu statements DIFFER; "
                     "first block %lld, %s: board %s, host %s",
                     again->differ, again->fields, again->made, (long long)again->first.block,
                     again->first.field, said, made);
}

static void again_answer(const struct predict_again *again, struct answer *answer)
{
    again_words(again, answer);
    answer_open(answer, "again", NULL);
    answer_flag(answer, "possible", NULL, again->possible);
    answer_count(answer, "statements", NULL, (int64_t)again->said);
    answer_count(answer, "fields", NULL, (int64_t)again->fields);
    answer_count(answer, "differ", NULL, (int64_t)again->differ);
    answer_count(answer, "backlogs", NULL, (int64_t)again->backlogs);
    answer_count(answer, "first_warning_block", NULL, again->warned_block);
    answer_count(answer, "lost", NULL, (int64_t)again->lost);
    answer_count(answer, "lacks_block", NULL, again->lacks_block);
    answer_words_or_none(answer, "lacks", NULL, again->lacks, NULL);
    if (again->differ) {
        answer_open(answer, "first", NULL);
        answer_count(answer, "block", NULL, again->first.block);
        answer_words(answer, "field", NULL, "%s", again->first.field);
        answer_value(answer, "board", NULL, UNIT_NUMBER, again->first.said, 6)->digits = DIGITS;
        answer_value(answer, "host", NULL, UNIT_NUMBER, again->first.made, 6)->digits = DIGITS;
        answer_close(answer);
    } else {
        answer_none(answer, "first", NULL, "");
    }
    answer_close(answer);
}

/* What this predictor and the board's say of a landing that was prepared. */
static enum mr_status predict_answer(struct predict *predict, struct store *store,
                                     struct answer *answer, struct error *error)
{
    const int64_t run = predict->measured.landing.id;
    struct mr_predictor_zone left;
    struct predict_again again;
    char doubt[DOUBTS_TEXT], heading[40];
    snprintf(heading, sizeof heading, "RUN %lld", (long long)run);
    answer_open(answer, NULL, heading);
    answer_count(answer, "run", NULL, run);
    doubts_headline(&predict->measured.doubts, doubt);
    if (doubt[0])
        answer_sentence(answer, "doubtful", "%s", doubt);
    else
        answer_none(answer, "doubtful", NULL, "");
    answer_table(answer, "statements",
                 "the longest closed zone ahead, the longest next, and how hard the mats ahead are "
                 "pressed (+- is one standard error)");
    struct first_warning first = first_warning(predict, run_all(predict, answer));
    answer_close(answer);
    mr_predictor_zone(&predict->predictor, &left);
    enum mr_status status = predict_again(store, run, &again, error);
    conclude(predict, &first, &left, answer);
    if (status == MR_OK)
        again_answer(&again, answer);
    answer_close(answer);
    predict->differ |= status == MR_OK && again.differ > 0;
    return status;
}

/* One landing. */
static enum mr_status predict_run(struct predict *predict, struct store *store, int64_t run,
                                  struct answer *answer, const struct cli *cli, struct error *error)
{
    int64_t source;
    predict->gear = (struct known_gear){0};
    enum mr_status status = measured_load(store, run, &predict->measured, error);
    measured_aside_note(&predict->measured, cli);
    if (status == MR_OK && predict->measured.source == MEASURED_NOTHING)
        status = error_set(error, MR_USAGE,
                           "no readings: RUN %lld has neither blocks nor displacements",
                           (long long)run);
    const char *board = predict->measured.landing.board_uid;
    if (status == MR_OK && board[0] && predict->board[0] && strcmp(board, predict->board) != 0)
        status = error_set(
            error, MR_USAGE,
            "RUN %lld is of board %s, those before of %s: give the landings of one runway",
            (long long)run, board, predict->board);
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
        status = predict_answer(predict, store, answer, error);
        mr_predictor_fold(&predict->predictor);
        mr_predictor_save(&predict->predictor, &predict->state);
        predict->carried = true;
    }
    zones_free(&predict->zones);
    measured_free(&predict->measured);
    memset(&predict->zones, 0, sizeof predict->zones);
    memset(&predict->measured, 0, sizeof predict->measured);
    return status;
}

static enum mr_status parse_runs(const char *const *words, int64_t *runs, size_t *count,
                                 struct error *error)
{
    enum mr_status status = MR_OK;
    for (*count = 0; words[*count] && status == MR_OK; ++*count) {
        status = run_parse(words[*count], &runs[*count], error);
        if (status == MR_OK && *count > 0 && runs[*count] <= runs[*count - 1])
            return error_set(
                error, MR_USAGE,
                "out of order: RUN %s after %s; give landings in the order in which they were made",
                words[*count], words[*count - 1]);
    }
    return status;
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
    struct answer *answer = answer_new(cli->si);
    size_t count = 0;
    answer_as_given(answer);
    enum mr_status status = command_parse(&command_predict, argc, argv, cli, &r, words, &error);
    if (status == MR_OK)
        status = parse_runs(words + 1, runs, &count, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &store, &error);
    if (count > 1)
        answer_list(answer, "runs", "");
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        status = store_refuse_void(store, runs[i], r.voided, &error);
        if (status == MR_OK)
            status = predict_run(&predict, store, runs[i], answer, cli, &error);
    }
    store_close(store);
    return answer_end(cli, answer, predict.differ ? mr_status_exit_code(MR_LIMIT) : 0, &error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM(
        "DB RUN",
        "campaign database and number of the landing in it, from 1; of several, in order, each "
        "begins with\n"
        "what the joints have become in the one before, and with the segments surveyed since:\n"
        "matrig predict campaign.db 1 2 3 4 5"),
    HELP_NOTE("A row for each change: longest closed zone ahead of the wheel, its ends with "
              "one standard error, longest zone that the\n"
              "wheel will meet or push together before it stops, compression ahead, verdict. It "
              "knows at each time what the\n"
              "board knew then: edges so far, readings so far, the survey, and, where the record "
              "has it, the runway that the board\n"
              "was armed with (of several landings for the first). Times are seconds after "
              "touchdown by the board's clock, at the\n"
              "beginning of the block that decided, as in log, report and make series."),
    OPTION_FLAG("--void", voided, "also of a landing that was voided"),
    HELP_EXAMPLE("matrig predict campaign.db 5"),
};

const struct command command_predict = {
    "predict",
    predict_command,
    "DB RUN... [--void]",
    "the predictor of zones and warnings on recorded landings",
    COMMAND_PARTS(parts),
    {2, RUNS_MAX + 1, "DB RUN"},
};
