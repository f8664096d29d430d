/* The command matrig advise: computes the probability that the wheel reaches a zone of 50 closed
 * mats in the next landing (host/advise). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/quantity.h"
#include "host/base/xmalloc.h"
#include "host/advise/advise.h"
#include "host/analyse/inspection.h"
#include "host/analyse/rig.h"
#include "host/board/runway_client.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/commands/annotation.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"

#define NUMBER_NOT_GIVEN (double)NAN

struct request {
    const char *db;
    struct advise_request advise;
    double limit_percent;
    const char *profile, *who, *serial, *temperature, *release;
    bool keep_runway, load;
};

/* Parses the first `length` characters, such as "4ft/s2". A number without a unit is in the unit
 * `bare`. */
static bool parse_profile_number(const char *text, size_t length, const char *bare,
                                 const char *unit, double *value)
{
    char word[40];
    struct quantity_error wrong;
    if (length >= sizeof word)
        return false;
    memcpy(word, text, length);
    word[length] = '\0';
    return quantity_parse(word, unit, bare, value, &wrong);
}

/* Reads a braking profile: "0:4,2:8" is a deceleration of 4 at touchdown (0 s) that changes
 * linearly to 8 at 2 s. */
static void read_profile(const char *text, bool si, struct advise_profile *profile)
{
    double last_s = -1.0;
    bool more = true;
    for (const char *at = text; more;) {
        size_t length = strcspn(at, ","), colon = strcspn(at, ":,");
        double t_s = 0.0, a = 0.0;
        if (colon >= length || !parse_profile_number(at, colon, "s", "s", &t_s) ||
            !parse_profile_number(at + colon + 1, length - colon - 1, si ? "m/s2" : "ft/s2",
                                  "ft/s2", &a) ||
            !(a >= 0.0 && a <= 60.0) || !(t_s > last_s && t_s <= 60.0))
            error_set(fatal, MR_USAGE,
                      "not a profile: '%s' for --profile; give pairs of time and deceleration, "
                      "such as 0s:4ft/s2,2s:8ft/s2, with ascending times from 0 to 60 s and "
                      "decelerations of 0 to 60 ft/s2",
                      text);
        if (profile->point_count == ADVISE_PROFILE_MAX)
            error_set(fatal, MR_USAGE,
                      "too many points: --profile has more than %u points; leave some out",
                      ADVISE_PROFILE_MAX);
        profile->t_s[profile->point_count] = last_s = t_s;
        profile->factor[profile->point_count++] = a;
        more = at[length] == ',';
        at += length + more;
    }
}

/* Number of landings on the runway for which the advice is computed, including the last landing. A
 * chart is valid only for a runway with this number. */
static unsigned count_landings(struct store *store, const struct advise *advise)
{
    struct mr_predictor_state state;
    const struct history *past = &advise->history;
    int64_t source;
    bool there = false;
    if (past->landing_count)
        store_runway_get(store, past->landing[past->landing_count - 1].run, &state, &source, &there,
                         fatal);
    if (!there)
        error_set(fatal, MR_TOO_FEW,
                  "runway unknown: the last landing of the campaign does not record the runway of "
                  "the board, so a chart cannot be loaded; log a landing with this board first");
    return state.landing_count + 1u;
}

/* Begins to load the advice into the board. Called before the advice is computed, because the
 * computation is useless if the board has a different runway. */
static void open_runway_client(const struct request *r, struct store *store,
                               const struct advise *advise, struct runway_client *talk)
{
    runway_client_begin(talk, dialogue_open_for_command(NULL, r->serial), fatal);
    runway_client_read(talk, fatal);
    unsigned landings = count_landings(store, advise);
    if (talk->state.landing_count != landings)
        error_set(
            fatal, MR_VERSION,
            "runways differ: the board's runway includes %u landings, but the runway of the advice "
            "includes %u: %s; log or fetch the missing landings, then repeat matrig advise",
            talk->state.landing_count, landings, r->serial);
}

/* ---- relations of the rig, fitted to the recorded conditions of its landings ---- */

/* A quantity that is predicted from the condition `field` of a landing. The relation is fitted to
 * earlier landings in which the condition `filter_field` was `filter_choice`. */
struct rig_relation {
    const char *option, *name, *label; /* name and label of the prediction */
    /* names and choice in the records: "temperature_f", "brake", "none" */
    const char *field, *filter_field, *filter_choice;
    /* unit of the prediction. A speed is predicted by a line through its square */
    enum unit_kind unit;
};

#define RELATION_LANDINGS_MIN 3

/* Predicts a quantity. Called before the advice is computed, which takes minutes. Returns the
 * number of landings used. */
static size_t predict_relation(const struct request *r, struct store *store,
                               const struct inspections *all, const struct rig_relation *relation,
                               const char *given, struct estimate *predicted)
{
    const struct inspection_kind *kind = NULL;
    size_t count = 0;
    if (!given)
        return 0;
    double *x = xcalloc(2 * all->count + 2, sizeof *x), *y = x + all->count + 1;
    json_t *values = json_object();
    char *word = xasprintf("%s=%s", relation->field, given);
    inspection_kind_find("conditions", &kind, fatal);
    inspection_parse_field(kind, word, values, fatal);
    for (size_t i = 0; i < all->count; i++) {
        const struct inspection *entry = &all->entry[i];
        const char *choice =
            json_string_value(json_object_get(entry->values, relation->filter_field));
        struct store_result result = store_blank_result;
        bool found = false, is_void = false;
        x[count] = inspection_get_number(entry->values, relation->field).value;
        if (!inspection_is_valid(entry, kind, 0) || isnan(x[count]) || !choice ||
            strcmp(choice, relation->filter_choice) != 0 ||
            (r->advise.before_run && entry->row.run >= r->advise.before_run))
            continue;
        store_is_void(store, entry->row.run, &is_void, NULL, fatal);
        store_result_get(store, entry->row.run, &result, &found, fatal);
        y[count] = relation->unit == UNIT_SPEED ? result.speed_ft_s : result.deceleration_ft_s2;
        count += found && !is_void && y[count] > 0.0;
    }
    double at = inspection_get_number(values, relation->field).value;
    if (count < RELATION_LANDINGS_MIN)
        error_set(
            fatal, MR_TOO_FEW,
            "too few landings for %s: only %zu landings have %s and %s=%s, but %d are needed; "
            "record these conditions with matrig record %s conditions RUN %s=VALUE %s=%s",
            relation->option, count, relation->field, relation->filter_field,
            relation->filter_choice, RELATION_LANDINGS_MIN, r->db, relation->field,
            relation->filter_field, relation->filter_choice);
    rig_predict_next_landing(x, y, count, at, relation->unit == UNIT_SPEED, predicted, fatal);
    free(x);
    free(word);
    json_decref(values);
    return count;
}

static void add_relation(const struct rig_relation *relation, size_t count,
                         struct estimate predicted, struct answer *answer)
{
    if (!count)
        return;
    answer_add_estimate(answer, relation->name, relation->label, relation->unit, predicted.value,
                        predicted.error, 2);
    answer_append_remark(answer, " in the next landing, from %zu landings", count);
}

static const struct rig_relation relations[] = {{"--temperature", "bearing_drag",
                                                 "drag without brakes", "temperature_f", "brake",
                                                 "none", UNIT_DECELERATION},
                                                {"--release", "coasting_speed", "speed by coasting",
                                                 "release_ft", "drive", "coast", UNIT_SPEED}};

static int run_advise(struct request *r, const struct cli *cli)
{
    static struct advise advise; /* static, because it is too large for the stack */
    struct error error = {0};
    struct answer *answer = answer_new(cli->si);
    struct runway_client talk;
    struct progress progress;
    struct mr_risk_plan plan;
    struct estimate predicted[2];
    const char *const given[2] = {r->temperature, r->release};
    size_t counts[2];
    struct store *store = program_open_campaign(r->db, r->keep_runway ? STORE_OPEN : STORE_READ);
    store_find_run(store, &r->advise.before_run, fatal);
    advise_begin(store, &r->advise, &advise, fatal);
    for (int i = 0; i < 2; i++)
        counts[i] = predict_relation(r, store, &advise.history.inspections, &relations[i], given[i],
                                     &predicted[i]);
    if (r->load)
        open_runway_client(r, store, &advise, &talk);
    progress_begin(&progress, "advise", "fewer --members", cli->quiet);
    advise_compute(&advise, cli->si, &progress, &error);
    progress_end(&progress);
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (r->keep_runway) {
        struct store_advice kept = advise_to_stored_row(&advise, (int64_t)link_now_us());
        annotation_copy(kept.who, sizeof kept.who, annotation_author(r->who));
        store_advice_add(store, &kept, fatal);
    }
    if (r->load) {
        (void)(advise_make_chart(&advise, talk.state.landing_count, &plan, &error)
                   ?: runway_client_send_chart(talk.dialogue, &plan, &error));
    }
    bool failed = error.status != MR_OK; /* print the advice in any case, even if loading failed */
    advise_to_answer(&advise, answer);
    for (int i = 0; i < 2; i++)
        add_relation(&relations[i], counts[i], predicted[i], answer);
    answer_add_flag(answer, "loaded", r->load ? "loaded into the board" : NULL, r->load && !failed);
    int code = advise.verdict == ADVISE_AGAINST ? mr_status_exit_code(MR_LIMIT) : 0;
    advise_free(&advise);
    if (failed && cli->json) /* do not print the error again: the JSON object contains it */
        return answer_print(cli, answer, cli_fail(&error));
    code = answer_print(cli, answer, code);
    return failed ? cli_fail(&error) : code;
}

static int advise_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    command_parse(&command_advise, argc, argv, cli, &r, &r.db, fatal);
    r.advise.risk_limit = r.limit_percent / 100.0;
    if (r.keep_runway && r.advise.before_run)
        error_set(fatal, MR_USAGE,
                  "--keep and --before exclude each other, because a plan can only be stored for "
                  "the next landing; leave one out");
    if (r.load != (r.serial != NULL))
        error_set(fatal, MR_USAGE,
                  "--load and --serial only work together; give --load --serial LINK");
    if (r.load && r.advise.before_run)
        error_set(fatal, MR_USAGE,
                  "--load and --before exclude each other, because a chart can only be loaded for "
                  "the next landing; leave one out");
    if (r.profile && isfinite(r.advise.deceleration_ft_s2))
        error_set(fatal, MR_USAGE,
                  "--profile and --deceleration exclude each other, because the profile sets the "
                  "mean deceleration; leave one out");
    if (r.profile)
        read_profile(r.profile, cli->si, &r.advise.profile);
    if (r.load && r.advise.profile.point_count > MR_RISK_PLAN_KNOTS)
        error_set(fatal, MR_USAGE,
                  "too many points: --profile has %zu points, but the board (--load) accepts only "
                  "%u; leave some out",
                  r.advise.profile.point_count, MR_RISK_PLAN_KNOTS);
    return run_advise(&r, cli);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database. The advice is for the runway after the last landing; all "
                    "landings of its board update the model"),
    OPTION_NUMBER_SI("--speed", "V", advise.speed_ft_s, "ft/s", "m/s", 5.0, 100.0, NUMBER_NOT_GIVEN,
                     "planned speed at touchdown; default: that of the last landing"),
    OPTION_NUMBER_SI("--deceleration", "A", advise.deceleration_ft_s2, "ft/s2", "m/s2", 0.5, 32.2,
                     NUMBER_NOT_GIVEN,
                     "planned mean deceleration; default: that of the last landing"),
    OPTION_TEXT("--temperature", "T", temperature,
                "predict the deceleration without brakes at this temperature (72, 22degC). Needs "
                "landings with a recorded temperature and brake=none (matrig record)"),
    OPTION_TEXT("--release", "FT", release,
                "predict the touchdown speed of a coasting gear that is released at this height. "
                "Needs landings with a recorded release height (matrig record)"),
    OPTION_TEXT("--profile", "T:A,...", profile,
                "planned deceleration over time, interpolated linearly: 0s:4ft/s2,2s:8ft/s2. The "
                "other rows of the result are for this profile multiplied by a factor"),
    OPTION_NUMBER_SI("--station", "S", advise.touchdown_ft, "ft", "m", 0.0, 200.0, NUMBER_NOT_GIVEN,
                     "planned touchdown station; default: the board's touchdown station"),
    OPTION_NUMBER("--share", "S", advise.thrust_share, NULL, 0.3, 2.0, NUMBER_NOT_GIVEN,
                  "measured ratio of the thrust on the mat strip to axle weight x deceleration / "
                  "g. Give this ratio only if its error is 3 % or less; default: estimated from "
                  "the recorded landings (initially uniform from 0.7 to 1.3)"),
    OPTION_NUMBER("--limit", "PERCENT", limit_percent, NULL, 1.0, 99.0, 100.0 * ADVISE_RISK_LIMIT,
                  "advise against a landing if a zone has this probability or more, in %; "
                  "default: {standard}, because a missed zone costs four times as much as a "
                  "needlessly gentle landing"),
    OPTION_INTEGER(
        "--members", "N", advise.members, (double)ADVISE_MEMBERS_MIN, (double)ADVISE_MEMBERS_MAX,
        (double)ADVISE_MEMBERS_DEFAULT,
        "number of simulated runways in the ensemble, {low} to {high}; default: {standard}"),
    OPTION_INTEGER("--seed", "N", advise.seed, 0.0, 1e9, 1.0,
                   "seed of all random draws; default: {standard}"),
    OPTION_RUN("--before", "RUN", advise.before_run,
               "give the advice for landing RUN from earlier data only"),
    OPTION_FLAG("--keep", keep_runway, "store the plan and the advice in the campaign"),
    OPTION_TEXT("--who", "W", who, "author; default: the user"),
    OPTION_FLAG("--load", load,
                "send the plan and the predicted probabilities (the chart) to the board, which "
                "computes the risk of the next landing from them"),
    OPTION_TEXT("--serial", "LINK", serial, "the board's serial port (see matrig log --help)"),
    HELP_NOTE(
        "The result is clear, caution or against, with the reason. A table shows the probability "
        "of a zone of 50 mats by mean deceleration and station. The last lines show the hardest "
        "braking and the fastest touchdown below the limit. Exit 1: against."),
    HELP_EXAMPLE("matrig advise campaign.db --speed 35ft/s --deceleration 4.5ft/s2"),
};

const struct command command_advise = {
    "advise",
    advise_command,
    "DB [--speed V] [--deceleration A | --profile T:A,...] [--station S] [--share S] [--limit "
    "PERCENT] [--temperature T] [--release FT] [--members N] [--seed N] [--before RUN] [--keep "
    "[--who W]] [--load --serial LINK]",
    "predict the probability of a zone in the next landing, and advise how hard to brake",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
