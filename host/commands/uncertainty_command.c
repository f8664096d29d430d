/* The command matrig uncertainty: prints the uncertainty budget of each channel. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/channels.h"
#include "host/analyse/measured_load.h"
#include "host/base/answer.h"
#include "host/board/certificates.h"
#include "host/board/config_text.h"
#include "host/calibrate/budget.h"
#include "host/calibrate/jump.h"
#include "host/calibrate/points.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/store/store_readiness.h"
#include "host/store/store_journal.h"

struct request {
    const struct cli *cli;
    const char *words[2]; /* operands DB and CHANNEL */
    const char *at_text, *config;
    double hours, kelvin;
    int64_t run;
    int channel; /* index of the channel; -1: all */
    /* reading for which the budget is computed; NaN: the peak, or a third of the range without a
     * landing */
    double at_value;
};

/* Data from which the budgets are computed. */
struct budget_input {
    struct mr_config config;
    bool is_config_known;
    int64_t run; /* RUN of the landing; 0: only a configuration is used */
    struct measured_landing measured;
    struct certificates certificates;
};

struct channel_budget {
    unsigned index;
    struct mr_channel_config channel;
    double value; /* reading for which the budget is computed, inches or pounds */
    struct budget budget;
    const struct store_certificate *certificate; /* NULL: the channel has no certificate */
};

static enum unit_kind find_unit_kind(const struct channel_budget *one)
{
    return one->index < MR_TRANSDUCERS ? UNIT_DISPLACEMENT : UNIT_TENSION;
}

/* ---- from the campaign ---- */

static void load_landing(struct store *store, const struct request *r, struct budget_input *s)
{
    struct store_landing *rows = NULL;
    struct error unread = {0};
    char *text = NULL;
    size_t count = 0;
    store_landings_get(store, &rows, &count, fatal);
    s->run = r->run ? r->run : count ? rows[count - 1].id : 0;
    store_find_run(store, &s->run, fatal);
    free(rows);
    if (!s->run)
        error_set(
            fatal, MR_UNKNOWN,
            "no landing yet: %s; run matrig board config get -o rig.cfg and give --config rig.cfg",
            r->words[0]);
    measured_load(store, s->run, &s->measured, fatal);
    if (s->measured.landing.config_crc != STORE_NONE)
        store_configuration_get(store, (uint32_t)s->measured.landing.config_crc, &text, fatal);
    s->is_config_known = text && config_text_read(text, "", &s->config, &unread) == MR_OK;
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
        if (s->measured.recalibrated_channels >> i & 1 && !s->config.channel[i].calibrated_day)
            s->config.channel[i].calibrated_day = 1;
    free(text);
}

static void load_budget_input(const struct request *r, struct budget_input *s)
{
    struct store *store = program_open_campaign(r->words[0], STORE_READ);
    char uid[25] = "";
    s->is_config_known = r->config != NULL;
    if (r->config)
        config_text_load(r->config, &s->config, fatal);
    else
        load_landing(store, r, s);
    store_newest_board_get(store, uid, fatal);
    certificates_read(store, s->run ? s->measured.landing.board_uid : uid, &s->certificates, fatal);
}

/* ---- one channel ---- */

/* Returns the conditions of a reading in the landing, for the error budget: the peak in the
 * summary, or `at_value`. */
static struct mr_error_conditions set_landing_conditions(const struct budget_input *s,
                                                         double at_value,
                                                         struct channel_budget *one)
{
    const struct measured_channel *channel = &s->measured.channel[one->index];
    one->channel = channel->config;
    one->channel.calibrated_day = s->config.channel[one->index].calibrated_day;
    memcpy(one->channel.serial, s->config.channel[one->index].serial, sizeof one->channel.serial);
    one->value = isnan(at_value) ? channel->peak : at_value;
    return measured_error_conditions(&s->measured, channel, one->value,
                                     measured_peak_sample_count(channel));
}

/* Returns the conditions of a reading of a board with this configuration, for the error budget. */
static struct mr_error_conditions set_nominal_conditions(const struct request *r,
                                                         const struct budget_input *s,
                                                         struct channel_budget *one)
{
    one->channel = s->config.channel[one->index];
    bool movement = one->channel.kind == MR_KIND_DISPLACEMENT;
    one->value = isnan(r->at_value) ? (double)one->channel.high / 3.0 : r->at_value;
    return (struct mr_error_conditions){
        .value = (float)one->value,
        .noise = (float)budget_default_noise_codes() * fabsf(one->channel.unit_per_code),
        .averaged_blocks = 1.0f,
        .baseline_blocks = movement ? (float)MEASURED_BASELINE_BLOCKS : 0.0f,
        .hours = movement ? 0.0f : (float)r->hours,
        .reference_error = s->config.channel[MR_REFERENCE].gain_error};
}

static bool make_budget(const struct request *r, const struct budget_input *s, unsigned index,
                        struct channel_budget *one)
{
    *one = (struct channel_budget){.index = index};
    if (r->channel >= 0 && r->channel != (int)index)
        return false;
    struct budget_case of = {.temperature_half_range_k = r->kelvin,
                             .certificate_expanded_uncertainty = (double)NAN};
    of.reading = s->run ? set_landing_conditions(s, r->at_value, one)
                        : set_nominal_conditions(r, s, one);
    if (!mr_channel_is_sensor(&one->channel))
        return false;
    of.channel = &one->channel;
    if (s->certificates.is_known[index]) {
        one->certificate = &s->certificates.certificate[index];
        of.certificate_coverage_factor = one->certificate->coverage_factor;
        of.certificate_expanded_uncertainty = certificates_compute_uncertainty(one->certificate,
                                                                               one->value) *
                                              of.certificate_coverage_factor;
    }
    if (s->is_config_known && s->config.site[0].mat_length_ft > 0.0f) {
        of.station_error_ft = (double)s->config.site[0].switch_error_ft;
        of.slope_max_in_ft =
            (double)(s->config.predict[0].slack_in / s->config.site[0].mat_length_ft);
    }
    budget_compute(&of, &one->budget);
    return true;
}

/* ---- output ---- */

static void add_certificate(struct answer *answer, const struct channel_budget *one)
{
    char text[CERTIFICATES_TEXT_SIZE] =
        "no certificate: the budget does not include its uncertainty";
    enum certificate_state state = CERTIFICATE_VALID;
    if (one->certificate) {
        state = certificates_check_state(one->certificate, &one->channel, (int64_t)time(NULL));
        certificates_state_text(one->certificate, state, &one->channel, text);
    }
    struct answer_style *fact = answer_add_text(answer, "certificate", "certificate", "%s", text);
    fact->is_warning = state != CERTIFICATE_VALID;
    answer_add_text_or_missing(answer, "certificate_number", NULL,
                               one->certificate ? one->certificate->number : "", NULL);
}

static void add_sums(struct answer *answer, const struct channel_budget *one)
{
    enum unit_kind kind = find_unit_kind(one);
    const struct budget *b = &one->budget;
    answer_add_value(answer, "stated", "stated error", kind, b->stated_error, -3);
    answer_add_value(answer, "combined", "combined", kind, b->combined_uncertainty, -3);
    answer_add_value(answer, "coverage_factor", "k", UNIT_NUMBER, b->coverage_factor, 3);
    answer_add_value(answer, "expanded", "expanded (95 %)", kind, b->expanded_uncertainty, -3);
    add_certificate(answer, one);
}

static void add_rows(struct answer *answer, const struct channel_budget *one)
{
    const struct budget *b = &one->budget;
    bool transducer = one->index < MR_TRANSDUCERS;
    answer_open_table(answer, "budget", "");
    for (enum budget_source s = 0; s < BUDGET_SOURCE_COUNT; s++) {
        const struct budget_row *row = &b->row[s];
        double share = row->contribution / b->combined_uncertainty;
        answer_open_row(answer);
        answer_add_text(answer, "source", NULL, "%s", budget_source_name(s));
        answer_add_text(answer, NULL, "source", "%s", budget_source_label(s));
        answer_add_flag(answer, "stated", NULL, s < BUDGET_STATED_COUNT);
        answer_add_text(answer, NULL, "part", "%s", s < BUDGET_STATED_COUNT ? "stated" : "added");
        answer_add_value(answer, "input", "x", UNIT_NUMBER, row->input, -3);
        answer_add_text(answer, "input_unit", "unit", "%s", budget_input_unit(s, transducer));
        answer_add_text(answer, "distribution", "distribution", "%s", budget_distribution(s));
        answer_add_value(answer, "divisor", "divisor", UNIT_NUMBER, row->divisor, 3);
        answer_add_value(answer, "standard", "u(x)", UNIT_NUMBER, row->standard_uncertainty, -3);
        answer_add_value(answer, "sensitivity", "c", UNIT_NUMBER, row->sensitivity, -3);
        answer_add_value(answer, "contribution", "c u(x)", find_unit_kind(one), row->contribution,
                         -3);
        answer_add_value(answer, NULL, "share, %", UNIT_NUMBER, 100.0 * share * share, 1);
    }
    answer_close_group(answer);
}

static void add_head(struct answer *answer, const struct channel_budget *one)
{
    char channel[8];
    jump_channel_name(one->index, channel);
    answer_add_text(answer, "channel", "channel", "%s", channel);
    answer_add_text_or_missing(answer, "sensor", "sensor",
                               one->channel.serial[0] ? one->channel.serial : "", "-");
    answer_add_value(answer, "reading", "reading", find_unit_kind(one), one->value,
                     find_unit_kind(one) == UNIT_DISPLACEMENT ? 4 : 2);
}

/* Adds all results of one channel to the answer. */
static void add_budget(struct answer *answer, const struct channel_budget *one)
{
    add_head(answer, one);
    add_rows(answer, one);
    add_sums(answer, one);
}

static void add_legend(struct answer *answer)
{
    answer_add_sentence(answer, NULL,
                        "The stated error is the standard error given with every reading: the "
                        "repeatability of the calibration. The combined uncertainty is the root "
                        "sum square of all rows, with certificate, position and temperature. The "
                        "expanded uncertainty is k times the combined one (95 %% interval).");
}

/* Adds the rows and sums of a budget. Text shows only the sums. */
static void add_table(const struct request *r, const struct budget_input *s, const char *name,
                      unsigned from, unsigned to, struct answer *answer)
{
    struct channel_budget one;
    answer_open_table(answer, name, "");
    for (unsigned i = from; i < to; i++) {
        if (!make_budget(r, s, i, &one))
            continue;
        struct answer *rows = answer_new(false);
        add_rows(rows, &one);
        json_t *made = answer_make_json_and_free(rows);
        answer_open_row(answer);
        add_head(answer, &one);
        add_sums(answer, &one);
        answer_add_json(answer, "budget", json_incref(json_object_get(made, "budget")));
        json_decref(made);
    }
    answer_close_group(answer);
}

static void add_tables(const struct request *r, const struct budget_input *s, struct answer *answer)
{
    add_table(r, s, "displacements", 0, MR_TRANSDUCERS, answer);
    add_table(r, s, "tensions", MR_TRANSDUCERS, MR_TRANSDUCERS + MR_GAGES, answer);
}

/* ---- the command line ---- */

static void check_request(struct request *r)
{
    unsigned index = 0;
    r->channel = -1;
    r->at_value = (double)NAN;
    if (r->words[1] && !jump_channel_find(r->words[1], strlen(r->words[1]), &index))
        error_set(fatal, MR_USAGE, "not a channel: '%s'; give d1 to d%u, or t1 to t%u", r->words[1],
                  MR_TRANSDUCERS, MR_GAGES);
    if (r->words[1])
        r->channel = (int)index;
    if (r->at_text && !r->words[1])
        error_set(fatal, MR_USAGE, "--at needs a CHANNEL; see matrig uncertainty --help");
    if (r->config && r->run)
        error_set(
            fatal, MR_USAGE,
            "--config and --run exclude each other; give only one, see matrig uncertainty --help");
    enum unit_kind kind = index < MR_TRANSDUCERS ? UNIT_DISPLACEMENT : UNIT_TENSION;
    const char *unit = kind == UNIT_DISPLACEMENT ? "in" : "lb";
    struct quantity_error wrong = {"", ""};
    if (r->at_text &&
        (!calibrate_value_parse(r->at_text, kind, unit_word_find(unit, 2), &r->at_value, &wrong) ||
         fabs(r->at_value) > 10000.0))
        error_set(fatal, MR_USAGE,
                  "not a reading: '%s' for --at; give a number in %s, or with its unit", r->at_text,
                  unit);
}

static void report_budgets(const struct request *r, const struct budget_input *s,
                           struct answer *answer)
{
    struct channel_budget one;
    if (r->channel >= 0 && !make_budget(r, s, (unsigned)r->channel, &one))
        error_set(fatal, MR_UNKNOWN, "%s is not fitted: %s; see matrig show", r->words[1],
                  r->config ? r->config : r->words[0]);
    if (s->run)
        answer_add_count(answer, "run", "RUN", s->run);
    answer_add_value(answer, "kelvin", NULL, UNIT_NUMBER, r->kelvin, 3);
    if (r->channel >= 0)
        add_budget(answer, &one);
    else
        add_tables(r, s, answer);
    add_legend(answer);
}

static int uncertainty_command(int argc, char **argv, const struct cli *cli)
{
    static struct budget_input s;
    struct request r = {.cli = cli};
    struct answer *answer = answer_new(cli->si);
    command_parse(&command_uncertainty, argc, argv, cli, &r, r.words, fatal);
    check_request(&r);
    load_budget_input(&r, &s);
    report_budgets(&r, &s, answer);
    measured_free(&s.measured);
    return answer_print(cli, answer, 0);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM(
        "DB",
        "campaign database; the budget is for the newest landing, with each channel at its peak"),
    HELP_ITEM("CHANNEL", "d1 to d8, t1 to t14: print the full budget of this channel; default: the "
                         "combined uncertainty of every channel"),
    OPTION_RUN("--run", "RUN", run, "use this landing instead of the newest"),
    OPTION_TEXT(
        "--config", "F", config,
        "use a configuration instead of a landing, with each channel at a third of its range"),
    OPTION_TEXT("--at", "V", at_text,
                "reading at which the budget is computed, in inches or pounds, or with a unit "
                "(5mm, 300N)"),
    OPTION_NUMBER("--kelvin", "K", kelvin, "K", 0.0, 60.0, 10.0,
                  "largest deviation from the temperature of the calibration; default: {standard}"),
    OPTION_NUMBER(
        "--hours", "H", hours, "h", 0.0, 1000.0, 1.0,
        "with --config: time from zeroing of the gages to the reading; default: {standard}"),
    HELP_NOTE(
        "The budget adds the effects of certificate, position and temperature to the stated error "
        "of each reading. The columns x, u(x) and c are in inches and pounds, even with --si."),
    HELP_EXAMPLE("matrig uncertainty campaign.db d3"),
};

const struct command command_uncertainty = {
    "uncertainty",
    uncertainty_command,
    "DB [CHANNEL [--at V]] [--run RUN | --config F [--hours H]] [--kelvin K]",
    "show the uncertainty budget and the certificate of each channel",
    COMMAND_PARTS(parts),
    {1, 2, "DB [CHANNEL]"},
};
