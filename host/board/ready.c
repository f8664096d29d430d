#include "host/board/ready.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/channels.h"
#include "common/command.h"
#include "common/fault.h"
#include "common/gain.h"
#include "common/staircase.h"
#include "host/base/answer.h"
#include "host/base/units.h"
#include "host/board/config_text.h"
#include "host/calibrate/jump.h"

#define BYTES_PER_MB 1e6
/* REQUIRED: self-tests that every rig has. LISTED_IF_PASSED: self-tests that are named in the value
 * only if passed. */
#define SELF_TESTS_REQUIRED \
    (1u << MR_SELF_TEST_RAM | 1u << MR_SELF_TEST_FLASH | 1u << MR_SELF_TEST_REFERENCE)
#define SELF_TESTS_LISTED_IF_PASSED \
    (SELF_TESTS_REQUIRED | 1u << MR_SELF_TEST_EXCITATION | 1u << MR_SELF_TEST_NOR)

/* ---- the report ---- */

const char *ready_verdict_text(enum ready_verdict verdict)
{
    static const char *const text[] = {
        [READY_GO] = "GO",
        [READY_NO_GO] = "NO-GO",
        [READY_NOT_DONE] = "not done",
    };
    return text[verdict];
}

void ready_add_check(struct ready_report *report, enum ready_verdict verdict, const char *name,
                     const char *limit, const char *advice, const char *format, ...)
{
    if (report->count == READY_CHECKS_MAX)
        return;
    struct ready_check *check = &report->check[report->count++];
    va_list arguments;
    *check = (struct ready_check){.verdict = verdict};
    snprintf(check->name, sizeof check->name, "%s", name);
    snprintf(check->limit, sizeof check->limit, "%s", limit ? limit : "");
    snprintf(check->advice, sizeof check->advice, "%s",
             advice && verdict != READY_GO ? advice : "");
    va_start(arguments, format);
    vsnprintf(check->value, sizeof check->value, format, arguments);
    va_end(arguments);
}

static enum ready_verdict verdict_if(bool good)
{
    return good ? READY_GO : READY_NO_GO;
}

static void append_text(char *out, size_t size, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void append_text(char *out, size_t size, const char *format, ...)
{
    size_t at = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + at, size - at, format, arguments);
    va_end(arguments);
}

enum ready_verdict ready_verdict(const struct ready_report *report)
{
    return verdict_if(report->count && !ready_count_checks(report, READY_NO_GO));
}

unsigned ready_count_checks(const struct ready_report *report, enum ready_verdict verdict)
{
    unsigned count = 0;
    for (unsigned i = 0; i < report->count; i++)
        count += report->check[i].verdict == verdict;
    return count;
}

json_t *ready_json(const struct ready_report *report)
{
    json_t *checks = json_array();
    for (unsigned i = 0; i < report->count; i++) {
        const struct ready_check *c = &report->check[i];
        json_array_append_new(checks, json_pack("{ssssssssss}", "name", c->name, "verdict",
                                                ready_verdict_text(c->verdict), "value", c->value,
                                                "limit", c->limit, "advice", c->advice));
    }
    return checks;
}

#define VALUE_COLUMN 29u /* column in which the values begin */
#define COLUMNS_MIN  60u

static void print_check(const struct ready_check *c, unsigned columns, FILE *out)
{
    char text[sizeof c->value + sizeof c->limit + 8], head[VALUE_COLUMN + 20];
    snprintf(text, sizeof text, "%s%s%s%s", c->value, c->limit[0] ? "  [" : "", c->limit,
             c->limit[0] ? "]" : "");
    snprintf(head, sizeof head, "%-8s  %-17s ", ready_verdict_text(c->verdict), c->name);
    fputs(head, out);
    text_print_wrapped(text, strlen(head), VALUE_COLUMN, columns, out);
    if (!c->advice[0])
        return;
    fprintf(out, "%*s->", (int)VALUE_COLUMN, "");
    text_print_wrapped(c->advice, VALUE_COLUMN + 2, VALUE_COLUMN + 3, columns, out);
}

void ready_print(const struct ready_report *report, double duration_s, unsigned columns, FILE *out)
{
    unsigned no_go = ready_count_checks(report, READY_NO_GO),
             open = ready_count_checks(report, READY_NOT_DONE);
    char text[READY_CHECKS_MAX * 24 + 120];
    const char *before = ": ";
    columns = columns < COLUMNS_MIN ? COLUMNS_MIN : columns;
    snprintf(text, sizeof text, "%s%s after %.1f s", ready_verdict_text(ready_verdict(report)),
             !no_go && report->is_uncalibrated ? ", UNCALIBRATED" : "", duration_s);
    for (unsigned i = 0; i < report->count; i++) {
        print_check(&report->check[i], columns, out);
        if (report->check[i].verdict != READY_NO_GO)
            continue;
        append_text(text, sizeof text, "%s%s", before, report->check[i].name);
        before = ", ";
    }
    append_text(text, sizeof text, "%s%u of %u checks passed", no_go ? "; " : ": ",
                report->count - no_go - open, report->count);
    if (open)
        append_text(text, sizeof text, ", %u not done", open);
    text_print_wrapped(text, 0, 0, columns, out);
}

/* ---- calibration and certificates ---- */

static void write_channel_name(const struct mr_channel_config *channel, char out[20])
{
    snprintf(out, 20, channel->kind == MR_KIND_DISPLACEMENT ? "transducer %u" : "gage %u",
             channel->number);
}

static void check_calibration_dates(const struct ready_inputs *f, struct ready_report *report)
{
    static const char limit[] = "expires_day after today";
    unsigned never = (unsigned)__builtin_popcount(config_text_undated_channels(&f->config)),
             sensors = 0, expired = 0;
    char text[120] = "", name[20];
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        if (!mr_channel_is_sensor(channel))
            continue;
        sensors++;
        if (!channel->expires_day || channel->expires_day > f->today_day)
            continue;
        write_channel_name(channel, name);
        append_text(text, sizeof text, "%s%s", expired++ ? ", " : "", name);
    }
    report->is_uncalibrated = never > 0;
    if (expired)
        ready_add_check(report, READY_NO_GO, "calibration", limit,
                        "calibrate these sensors, then send the new values and dates with matrig "
                        "board config set",
                        "expired: %s", text);
    else if (never)
        ready_add_check(
            report, READY_NOT_DONE, "calibration", NULL,
            "run matrig calibrate CHANNEL; until then every record is marked UNCALIBRATED",
            "UNCALIBRATED: %u of %u sensors have no calibration date", never, sensors);
    else if (sensors)
        ready_add_check(report, READY_GO, "calibration", limit, NULL, "%u sensors, none expired",
                        sensors);
}

/* Checks the gains: older firmware may have stored a gain that is refused today. */
static void check_gains(const struct ready_inputs *f, struct ready_report *report)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        char name[20], input[8], mistake[80];
        if (!mr_channel_is_sensor(channel) || channel->unit_per_code == 0.0f ||
            mr_gain_check(channel) == MR_RULE_NONE)
            continue;
        jump_channel_name(i, input);
        snprintf(name, sizeof name, "calibration %s", input);
        jump_write_mistake_hint(channel, mistake, sizeof mistake);
        ready_add_check(report, READY_NO_GO, name, NULL,
                        "check the configuration with matrig board config get and config check, or "
                        "calibrate the channel again",
                        "%.4g %s per code: no sensor of the rig has such a gain%s",
                        (double)mr_channel_gain(channel), i < MR_TRANSDUCERS ? "in" : "lb",
                        mistake);
    }
}

/* Checks the bridge zeros. A zero is valid only for the temperature and the trim at which it was
 * measured. It must be measured before the landing, with the bands slack. */
static void check_zeros(const struct ready_inputs *f, struct ready_report *report)
{
    char is[UNIT_TEXT_SIZE];
    unsigned gages = 0, measured = 0;
    float worst_lb = 0.0f;
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (f->config.channel[i].kind != MR_KIND_TENSION || !(f->zero_received_bits >> i & 1u))
            continue;
        gages++;
        if (f->zero_measured_bits >> i & 1u)
            measured++;
        else
            worst_lb = fmaxf(worst_lb, f->config.channel[i].zero_error);
    }
    if (gages && measured == gages)
        ready_add_check(report, READY_GO, "gage zeros", NULL, NULL,
                        "all %u gages measured since reset", gages);
    else if (gages)
        ready_add_check(
            report, READY_NOT_DONE, "gage zeros", NULL,
            "slacken the bands and run matrig board zero 2; configured zeros are valid only for "
            "trimmed bridges",
            "the zeros of %u of %u gages were not measured since reset; the configured zeros are "
            "used, +- %s",
            gages - measured, gages, unit_value_text(UNIT_TENSION, f->si, (double)worst_lb, 1, is));
}

static void check_certificate(const struct ready_inputs *f, unsigned i, const char *channel,
                              struct ready_report *report)
{
    char name[20], text[CERTIFICATES_TEXT_SIZE];
    const struct store_certificate *certificate = &f->certificates.certificate[i];
    enum certificate_state state = certificates_check_state(certificate, &f->config.channel[i],
                                                            f->now_s);
    certificates_state_text(certificate, state, &f->config.channel[i], text);
    snprintf(name, sizeof name, "certificate %s", channel);
    ready_add_check(
        report, verdict_if(state == CERTIFICATE_VALID), name, NULL,
        state == CERTIFICATE_OVERDUE
            ? "have the sensor calibrated, then run matrig calibrate CHANNEL --certificate"
            : "enter the certificate or the serial number of the fitted sensor",
        "%s: No. %s%s%s", text, certificate->number, certificate->laboratory[0] ? ", " : "",
        certificate->laboratory);
}

void ready_check_certificates(const struct ready_inputs *f, struct ready_report *report)
{
    unsigned without = 0, sensors = 0;
    char text[200] = "", name[8];
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (!mr_channel_is_sensor(&f->config.channel[i]))
            continue;
        sensors++;
        jump_channel_name(i, name);
        if (f->certificates.is_known[i])
            check_certificate(f, i, name, report);
        else
            append_text(text, sizeof text, "%s%s", without++ ? ", " : "", name);
    }
    if (without)
        ready_add_check(report, READY_NOT_DONE, "certificates", NULL, NULL, "no certificate for %s",
                        without == sensors ? "any sensor" : text);
}

/* ---- image and configuration ---- */

static void check_image(const struct ready_inputs *f, struct ready_report *report)
{
    const struct identity *id = &f->identity;
    char runs[MR_IMAGE_COMMIT_TEXT] = "unknown", why[200] = "", limit[80] = "";
    bool whole = id->commit_known && id->commit.state == MR_IMAGE_INTACT,
         compared = f->has_previous_landing && f->previous_image_crc != STORE_NONE;
    enum ready_verdict verdict = !whole ? READY_NO_GO
                               : f->image
                                   ? verdict_if(identity_is_running(id, f->image, why, sizeof why))
                               : !compared
                                   ? READY_NOT_DONE
                                   : verdict_if(f->previous_image_crc == (int64_t)id->image_crc);
    if (id->commit_known)
        mr_image_commit_text(id->commit.commit, id->commit.commit_more, id->commit.changed != 0,
                             runs);
    if (f->image)
        snprintf(limit, sizeof limit, "image %08x, of %.50s", (unsigned)f->image->program_crc,
                 f->image_path);
    else if (compared)
        snprintf(limit, sizeof limit, "image %08x, as in RUN %lld", (unsigned)f->previous_image_crc,
                 (long long)f->previous_run);
    ready_add_check(
        report, verdict, "firmware", limit,
        !whole ? "flash the firmware again: matrig flash LINK IMAGE"
        : f->image
            ? "the board runs a different image: flash the image with matrig flash LINK IMAGE"
        : verdict == READY_NOT_DONE ? "the campaign has no landing of this board: give --image FILE"
                                    : "the image differs from that landing: flash that image, or "
                                      "confirm the present one with --image FILE",
        "%u.%u.%u, commit %s, image %08x, %s", id->hello.major, id->hello.minor, id->hello.patch,
        runs, (unsigned)id->image_crc,
        mr_image_state_text(id->commit_known ? id->commit.state : (unsigned)MR_IMAGE_NO_HEADER));
}

/* Returns the configuration CRC that the board should report. */
static uint32_t get_expected_crc(const struct ready_inputs *f)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    if (!f->expected_config)
        return f->expected_crc;
    struct mr_config wanted = *f->expected_config;
    wanted.site[0].revision = f->config.site[0].revision;
    return mr_config_encode(&wanted, image);
}

static void check_configuration(const struct ready_inputs *f, struct ready_report *report)
{
    char limit[80] = "";
    bool compared = f->has_expected_crc ||
                    (f->has_previous_landing && f->previous_config_crc != STORE_NONE);
    uint32_t wanted = f->has_expected_crc ? get_expected_crc(f) : (uint32_t)f->previous_config_crc;
    if (f->has_expected_crc)
        snprintf(limit, sizeof limit, "CRC %08x, as given", (unsigned)wanted);
    else if (compared)
        snprintf(limit, sizeof limit, "CRC %08x, as in RUN %lld", (unsigned)wanted,
                 (long long)f->previous_run);
    ready_add_check(
        report, compared ? verdict_if(wanted == f->config_crc) : READY_NOT_DONE, "configuration",
        limit,
        compared ? "send the right configuration with config set, or confirm the present one with "
                   "--expect-config"
                 : "the campaign has no landing of this board: give --expect-config FILE",
        "CRC %08x, revision %u, %s", (unsigned)f->config_crc, (unsigned)f->config.site[0].revision,
        mr_config_source_text(f->config_state.source));
}

/* ---- clock ---- */

static void check_board_clock(const struct ready_inputs *f, struct ready_report *report)
{
    char limit[20];
    unsigned source = f->identity.hello.clock_source;
    const struct timemap_fit *t = &f->time_fit;
    ready_add_check(report, verdict_if(source == 0), "clock", "crystal",
                    "reset the board, or replace its crystal; until then speeds have 1 % error and "
                    "CAN is silent",
                    "%s", mr_clock_source_text(source));
    snprintf(limit, sizeof limit, "%.0f ppm", READY_CLOCK_ERROR_MAX_PPM);
    if (t->refusal == TIMEMAP_OK)
        ready_add_check(
            report,
            verdict_if(fabs(t->rate_ppm.value) - t->rate_ppm.half_width <=
                       READY_CLOCK_ERROR_MAX_PPM),
            "time of day", limit,
            "check the programs that set this computer's clock, and check the board's crystal",
            "board %+.0f +- %.0f ppm, from %zu messages",
            unit_round_to_zero(t->rate_ppm.value, 1.0), t->rate_ppm.half_width, t->pair_count);
    else
        ready_add_check(report, READY_NOT_DONE, "time of day", NULL, NULL, "%s",
                        timemap_refusal_text((unsigned)t->refusal));
}

static void check_key(const struct ready_inputs *f, struct ready_report *report)
{
    const struct identity *who = &f->identity;
    ready_add_check(
        report, !who->key_known ? READY_NOT_DONE : verdict_if(who->key.state != MR_KEY_DAMAGED),
        "orders", NULL, "fit the maintenance jumper and run matrig board key new or key clear",
        "%s", who->key_known ? mr_key_state_text(who->key.state) : "not reported");
}

/* Checks the brown-out reset. The factory setting, off, is accepted, because supply dips are
 * rare. */
static void check_brown_out(const struct ready_inputs *f, struct ready_report *report)
{
    bool set = f->restarts.brown_out > 0;
    if (f->restarts_known)
        ready_add_check(
            report, set ? READY_GO : READY_NOT_DONE, "brown-out reset", "on",
            "set the brown-out level once with the bring-up image (matrig board bringup "
            "brown-out), because the processor is unreliable below 2.7 V",
            set ? "below %s" : "%s, the factory setting", mr_brown_out_text(f->restarts.brown_out));
}

/* ---- channels ---- */

void ready_summarize_channel(const struct mr_config *config, const struct mr_block *blocks,
                             unsigned count, unsigned c, struct ready_channel *channel)
{
    double sum = 0.0, code_sum = 0.0, square = 0.0;
    *channel = (struct ready_channel){.block_count = count, .mean = NAN, .noise_codes = NAN};
    for (unsigned pass = 0; pass < 2; pass++) {
        double valid = count - channel->invalid_count;
        for (unsigned i = 0; i < count; i++) {
            struct mr_reading reading =
                mr_channel_read(&config->channel[c], &blocks[i], c,
                                mr_reference_ratio(&config->channel[MR_REFERENCE], &blocks[i]));
            if (pass && reading.validity == MR_VALID) {
                double off = (double)reading.code - code_sum / valid;
                square += off * off;
            } else if (!pass && reading.validity == MR_VALID) {
                sum += (double)reading.value;
                code_sum += (double)reading.code;
            } else if (!pass) {
                channel->invalid_count++;
                channel->validity = reading.validity;
            }
        }
    }
    unsigned valid = count - channel->invalid_count;
    if (valid)
        channel->mean = (float)(sum / valid);
    if (valid > 1)
        channel->noise_codes = (float)sqrt(square / (valid - 1));
}

/* Formats a value with its tolerance, for example "100 +- 25 lb". */
static const char *format_tolerance(const struct ready_inputs *f, float wanted_lb, float by_lb,
                                    char out[UNIT_TEXT_SIZE])
{
    char by[UNIT_TEXT_SIZE];
    const struct unit *unit = unit_get(UNIT_TENSION, f->si);
    snprintf(out, UNIT_TEXT_SIZE, "%.0f +- %.20s", (double)wanted_lb * unit->factor,
             unit_value_text(UNIT_TENSION, f->si, (double)by_lb, 0, by));
    return out;
}

static void check_channel_readings(const struct ready_inputs *f, unsigned i,
                                   struct ready_report *report)
{
    const struct mr_channel_config *channel = &f->config.channel[i];
    const struct ready_channel *m = &f->channel[i];
    bool transducer = channel->kind == MR_KIND_DISPLACEMENT, open = m->validity == MR_INVALID_OPEN,
         noisy = m->noise_codes > READY_NOISE_MAX_CODES;
    char name[20], is[UNIT_TEXT_SIZE], most[UNIT_TEXT_SIZE], limit[80] = "";
    write_channel_name(channel, name);
    if (m->invalid_count || isnan(m->mean)) {
        ready_add_check(
            report, READY_NO_GO, name, "all valid",
            open ? "check the connector and wiring of this sensor"
            : m->validity == MR_INVALID_REFERENCE
                ? "check the converter's supply, because the reference voltage is out of range"
            : m->validity == MR_INVALID_RANGE ? "move the transducer back into its range"
                                              : "check the wiring and excitation of this sensor",
            "%s, %u of %u readings not valid",
            !transducer && open ? "bridge open" : mr_validity_text(m->validity), m->invalid_count,
            m->block_count);
        return;
    }
    float wanted_lb = channel->band ? f->config.band[channel->band - 1].pretension_lb : 0.0f;
    bool off = transducer ? fabsf(m->mean) > READY_REST_MAX_IN
                          : wanted_lb > 0.0f && fabsf(m->mean - wanted_lb) >
                                                    READY_GAGE_PRETENSION_TOLERANCE * wanted_lb;
    if (transducer)
        unit_value_text(UNIT_DISPLACEMENT, f->si, (double)READY_REST_MAX_IN, 2, most);
    else if (wanted_lb > 0.0f)
        format_tolerance(f, wanted_lb, READY_GAGE_PRETENSION_TOLERANCE * wanted_lb, most);
    if (transducer || wanted_lb > 0.0f)
        snprintf(limit, sizeof limit, "%s, ", most);
    append_text(limit, sizeof limit, "%.0f codes", (double)READY_NOISE_MAX_CODES);
    if (transducer)
        unit_signed_text(UNIT_DISPLACEMENT, f->si, (double)m->mean, 4, is);
    else
        unit_value_text(UNIT_TENSION, f->si, (double)m->mean, 1, is);
    ready_add_check(
        report, verdict_if(!off && !noisy), name, limit,
        !off         ? "noise is too high: check shield and ground of this sensor"
        : transducer ? "push the mat back, or measure the zero: matrig board zero 1"
                     : "check that the band is tight and straight, then check the zero of the gage",
        "%s%s, noise %.2f codes", is, transducer ? " from its zero" : "", (double)m->noise_codes);
}

static void check_band(const struct ready_inputs *f, unsigned band, struct ready_report *report)
{
    float wanted_lb = f->config.band[band - 1].pretension_lb, sum = 0.0f;
    unsigned gages = 0;
    char name[20], is[UNIT_TEXT_SIZE], limit[UNIT_TEXT_SIZE];
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (f->config.channel[i].kind == MR_KIND_TENSION && f->config.channel[i].band == band &&
            !isnan(f->channel[i].mean) && f->channel[i].block_count) {
            sum += f->channel[i].mean;
            gages++;
        }
    }
    if (wanted_lb <= 0.0f || !gages)
        return;
    float mean = sum / (float)gages;
    snprintf(name, sizeof name, "band %u", band);
    ready_add_check(
        report, verdict_if(fabsf(mean - wanted_lb) <= READY_PRETENSION_TOLERANCE * wanted_lb), name,
        format_tolerance(f, wanted_lb, READY_PRETENSION_TOLERANCE * wanted_lb, limit),
        mean < wanted_lb ? "tension the band" : "slacken the band",
        "pretension %s, mean of %u gages",
        unit_value_text(UNIT_TENSION, f->si, (double)mean, 1, is), gages);
}

static void check_shunts(const struct ready_inputs *f, struct ready_report *report)
{
    static const char name[] = "shunt calibration";
    char text[READY_VALUE_SIZE - 40] = "", is[UNIT_TEXT_SIZE], of[UNIT_TEXT_SIZE];
    unsigned bad = 0, compared = 0;
    float worst = 0.0f;
    bool any = false;
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++)
        any |= f->config.channel[i].kind == MR_KIND_TENSION && f->config.channel[i].shunt_lb > 0.0f;
    if (!any)
        return;
    if (!f->shunt_done || f->shunts.count == 0) {
        ready_add_check(report, READY_NO_GO, name, NULL, "the board must be idle; try again", "%s",
                        f->shunt_done ? mr_status_text(f->shunt_status)
                                      : "the board did not answer");
        return;
    }
    for (unsigned i = 0; i < f->shunts.count; i++) {
        const struct mr_shunt_result *r = &f->shunts.result[i];
        float before = r->gage >= 1 && r->gage <= MR_GAGES ? f->previous_span_lb[r->gage - 1] : NAN;
        float change = r->span_lb - before;
        bool drifted = !isnan(change) &&
                       fabsf(change) > READY_SHUNT_DRIFT_MAX * fabsf(before) + 3.0f * r->noise_lb;
        compared += isnan(change) ? 0u : 1u;
        if (!isnan(change) && fabsf(change) > fabsf(worst))
            worst = change;
        if (r->verdict != MR_SHUNT_GOOD)
            append_text(text, sizeof text, "%sgage %u %s (%s of %s)", bad++ ? ", " : "", r->gage,
                        shunts_verdict_text(r->verdict),
                        unit_value_text(UNIT_TENSION, f->si, (double)r->span_lb, 2, is),
                        unit_value_text(UNIT_TENSION, f->si, (double)f->shunts.check[i].expected_lb,
                                        2, of));
        else if (drifted)
            append_text(text, sizeof text, "%sgage %u drifted by %s", bad++ ? ", " : "", r->gage,
                        unit_signed_text(UNIT_TENSION, f->si, (double)change, 2, is));
    }
    if (!bad)
        snprintf(text, sizeof text, "%u gages good; %s%s%s", f->shunts.count,
                 compared ? "change since the last calibration "
                          : "no earlier calibration is stored",
                 compared ? unit_signed_text(UNIT_TENSION, f->si, (double)worst, 3, is) : "",
                 compared ? " at most" : "");
    ready_add_check(report, verdict_if(!bad), name, "1 % and three standard errors",
                    "check this bridge and its amplifier with matrig board shunt", "%s", text);
}

/* Checks that all switches are closed; an open switch adds its step to the staircase. */
static void check_switches(const struct ready_inputs *f, struct ready_report *report)
{
    const unsigned i = MR_TRANSDUCERS + MR_ADC1_STAIRCASE;
    uint16_t steps[MR_CONFIG_SWITCHES];
    char text[80], limit[20];
    if (f->config.channel[i].kind != MR_KIND_STAIRCASE || f->channel[i].block_count == 0)
        return;
    for (unsigned s = 0; s < MR_CONFIG_SWITCHES; s++)
        steps[s] = f->config.gate[s].step_codes;
    float level = f->channel[i].mean - f->config.channel[i].zero_code;
    unsigned one = mr_staircase_identify(level, steps, MR_CONFIG_SWITCHES, 0);
    bool closed = fabsf(level) < READY_STAIRCASE_MAX_CODES;
    const double codes = unit_round_to_zero((double)level, 0.1);
    if (closed)
        snprintf(text, sizeof text, "all closed: the staircase is %.1f codes from its zero", codes);
    else if (one)
        snprintf(text, sizeof text, "switch %u is open: the staircase is %.1f codes from its zero",
                 one, codes);
    else
        snprintf(text, sizeof text, "the staircase is %.1f codes from its zero: %s", codes,
                 level > 0.0f ? "switches are open" : "lower than possible");
    snprintf(limit, sizeof limit, "%.0f codes", (double)READY_STAIRCASE_MAX_CODES);
    ready_add_check(report, verdict_if(closed), "switches", limit,
                    level > 0.0f ? "close all switches along the runway"
                                 : "check the wiring and supply of the staircase",
                    "%s", text);
}

static void check_channels(const struct ready_inputs *f, struct ready_report *report)
{
    char limit[40];
    if (f->block_count == 0) {
        ready_add_check(
            report, READY_NO_GO, "readings", NULL,
            "bring the board to idle and check with matrig board health that its scans run",
            "no block records were received");
        return;
    }
    snprintf(limit, sizeof limit, "%u or more, none lost", READY_BLOCKS_REQUESTED / 2);
    ready_add_check(
        report,
        verdict_if(f->lost_block_count == 0 && f->block_count >= READY_BLOCKS_REQUESTED / 2),
        "readings", limit, "see matrig board health", "%u blocks checked, %u lost by the board",
        f->block_count, f->lost_block_count);
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (mr_channel_is_sensor(&f->config.channel[i]))
            check_channel_readings(f, i, report);
    }
    for (unsigned band = 1; band <= MR_CONFIG_BANDS; band++)
        check_band(f, band, report);
    check_switches(f, report);
}

/* ---- black box and health ---- */

static void check_black_box(const struct ready_inputs *f, struct ready_report *report)
{
    char wait[60] = "", limit[40];
    const struct mr_box_state *box = &f->box_state;
    if (!f->config.site[0].black_box) {
        ready_add_check(report, READY_NOT_DONE, "black box", NULL, NULL, "not configured");
        return;
    }
    if (!f->box_known) {
        ready_add_check(report, READY_NO_GO, "black box", NULL,
                        "check the serial cable and try again",
                        "the board did not report its black box");
        return;
    }
    if (isnan(box->wait_s))
        snprintf(wait, sizeof wait, ", no room until records are freed");
    else if (box->wait_s > 0.0f)
        snprintf(wait, sizeof wait, ", %.1f s until a landing may be armed", (double)box->wait_s);
    snprintf(limit, sizeof limit, "ready, %u sectors", box->reserve);
    ready_add_check(
        report, verdict_if(box->state == MR_BOX_READY && box->wait_s == 0.0f), "black box", limit,
        box->state != MR_BOX_READY && box->state != MR_BOX_SCANNING
            ? "check the memory on SPI2; if the board has none, set site.black_box = 0"
        : isnan(box->wait_s)
            ? "read the records with matrig board read N, then free them with matrig board free N"
            : "wait until the black box is erased",
        "%s%s, %u sectors erased, %u bad, %u records to free",
        box->state == MR_BOX_MISSING ? "no memory answers" : mr_box_condition_text(box->state),
        wait, box->ready, f->box_space.bad, box->records);
}

static void check_self_test(const struct ready_inputs *f, struct ready_report *report)
{
    const unsigned lamp = (1u << MR_SELF_TEST_LAMP_ON) | (1u << MR_SELF_TEST_LAMP_OFF);
    char text[140] = "";
    unsigned failed = f->self_test.failed & ~lamp,
             undone = SELF_TESTS_REQUIRED & ~(unsigned)f->self_test.done;
    unsigned named = failed ? failed
                   : undone ? undone
                            : f->self_test.done & SELF_TESTS_LISTED_IF_PASSED;
    if (!f->self_test_done) {
        ready_add_check(report, READY_NO_GO, "self-test", NULL,
                        "the board must be idle; try again, or reset the board",
                        "the board did not run the self-test");
        return;
    }
    for (unsigned i = 0; i < MR_SELF_TEST_COUNT; i++) {
        if (named >> i & 1u)
            append_text(text, sizeof text, "%s%s", text[0] ? ", " : "", mr_self_test_text(i));
    }
    ready_add_check(report, verdict_if(!failed && !undone), "self-test", NULL,
                    "find the cause with matrig board self-test and matrig board health", "%s: %s",
                    failed   ? "failed"
                    : undone ? "not tested"
                             : "good",
                    text);
    bool lit = (f->self_test.done & lamp) == lamp && !(f->self_test.failed & lamp);
    ready_add_check(report, verdict_if(lit), "warning lamp", NULL,
                    "check lamp, fuse, driver (PE0) and read-back (PE3)", "%s",
                    lit                                                 ? "lights and goes out"
                    : f->self_test.failed & 1u << MR_SELF_TEST_LAMP_ON  ? "does not light"
                    : f->self_test.failed & 1u << MR_SELF_TEST_LAMP_OFF ? "does not go out"
                                                                        : "not tested");
}

static void check_temperature(const struct ready_inputs *f, struct ready_report *report)
{
    if (!f->config.site[0].thermometer)
        ready_add_check(report, READY_NOT_DONE, "thermometer", NULL, NULL, "not configured");
    else if (f->temperature_known && !isnan(f->temperature.temperature_c))
        ready_add_check(report, READY_GO, "thermometer", NULL, NULL,
                        "%.2f +- %.2f \xc2\xb0"
                        "C",
                        unit_round_to_zero((double)f->temperature.temperature_c, 0.01),
                        (double)f->temperature.error_c);
    else
        ready_add_check(report, READY_NO_GO, "thermometer", NULL,
                        "find the cause with matrig board health; if no thermometer is fitted, set "
                        "site.thermometer = 0",
                        "%s", f->temperature_known ? "no reading" : "not reported");
}

static void check_faults(const struct ready_inputs *f, struct ready_report *report)
{
    char text[READY_VALUE_SIZE - 40] = "";
    unsigned rising = 0, count = 0;
    bool rises[MR_FAULT_COUNT];
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        /* the self-test and the channels have checks of their own */
        rises[i] = f->fault_increase[i] && i != MR_FAULT_SELFTEST && i != MR_FAULT_CHANNEL;
        count += f->fault[i].count != 0;
        rising += rises[i];
    }
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (f->fault[i].count && (!rising || rises[i]))
            append_text(text, sizeof text, "%s%s", text[0] ? "; " : "", mr_fault_text(i));
    }
    ready_add_check(report, verdict_if(!rising), "faults", "no present fault",
                    "see matrig board health", "%s%s",
                    rising  ? "present: "
                    : count ? "no present fault; faults since reset: "
                            : "none since reset",
                    text);
}

/* ---- links and computer ---- */

static void check_can(const struct ready_inputs *f, struct ready_report *report)
{
    const uint32_t *serial = f->identity.uid, *can = f->board_on_can.uid;
    char uid[IDENTITY_UID_SIZE], own[IDENTITY_UID_SIZE];
    const char *state = f->alarm_known ? mr_can_state_text(f->alarm.state)
                                       : "the board did not report its CAN state";
    if (!f->is_can_used) {
        ready_add_check(report, READY_NOT_DONE, "CAN", NULL, "give --can LINK to check CAN",
                        "not checked; the board reports: %s", state);
        return;
    }
    /* on a shared bus, messages at this base may come from another board */
    if (f->can_frame_count > 0 && (serial[0] | serial[1]) &&
        (serial[0] != can[0] || serial[1] != can[1])) {
        bool is_identified = (can[0] | can[1]) != 0;
        identity_uid_text(&f->board_on_can, uid);
        identity_uid_text(&f->identity, own);
        ready_add_check(
            report, READY_NO_GO, "CAN", "the board itself",
            "give the CAN base of the board, such as can:can0,base=0x190, or its own serial link",
            "%s at base 0x%03x: the UID is %s on CAN and %s on serial",
            is_identified ? "another board" : "frames not from this board", f->can_base,
            is_identified ? uid : "unknown", own);
        return;
    }
    bool kept_silent = f->alarm_known ? f->alarm.state == MR_CAN_SILENT
                                      : f->identity.hello.clock_source != 0;
    ready_add_check(
        report,
        verdict_if(f->alarm_known && f->alarm.state == MR_CAN_GOOD && f->can_frame_count > 0 &&
                   f->can_lost_count == 0 && f->can_dropped_count == 0),
        "CAN", "good, none lost",
        kept_silent ? "correct the fault of the clock; until then the board sends nothing on CAN"
        : f->can_frame_count == 0 ? "check connector, terminators and bit rate"
                                  : "check the bus and the load of this computer",
        "%s; %lld frames, %lld lost, %lld dropped by the board", state,
        (long long)f->can_frame_count, (long long)f->can_lost_count,
        (long long)f->can_dropped_count);
}

static void check_computer(const struct ready_inputs *f, struct ready_report *report)
{
    char limit[40];
    double wanted = READY_FREE_LANDINGS_MIN * f->bytes_per_landing;
    snprintf(limit, sizeof limit, "%.0f MB: %.0f landings", wanted / BYTES_PER_MB,
             READY_FREE_LANDINGS_MIN);
    ready_add_check(report, verdict_if(f->free_bytes >= wanted), "disk", limit,
                    "free space on the disk of the campaign, or use a different disk",
                    "%.0f MB are free; a landing needs %.1f MB", f->free_bytes / BYTES_PER_MB,
                    f->bytes_per_landing / BYTES_PER_MB);
    ready_add_check(report, verdict_if(!f->database_fault[0]), "database", NULL,
                    "check the access rights and the programs that write to the campaign, or begin "
                    "a new campaign",
                    "%s",
                    f->database_fault[0] ? f->database_fault
                    : f->database_checked
                        ? "writable, all pages intact"
                        : "writable; the pages were not checked, because the file is too large");
}

void ready_check_all(const struct ready_inputs *f, struct ready_report *report)
{
    char uid[IDENTITY_UID_SIZE];
    report->count = 0;
    identity_uid_text(&f->identity, uid);
    ready_add_check(report, READY_GO, "board", NULL, NULL, "%s, idle", uid);
    check_image(f, report);
    check_configuration(f, report);
    check_calibration_dates(f, report);
    check_gains(f, report);
    ready_check_certificates(f, report);
    check_board_clock(f, report);
    check_key(f, report);
    check_brown_out(f, report);
    check_channels(f, report);
    check_zeros(f, report);
    check_shunts(f, report);
    check_black_box(f, report);
    check_self_test(f, report);
    check_temperature(f, report);
    check_faults(f, report);
    check_can(f, report);
    ready_add_check(
        report, verdict_if(!f->serial_lost_count && !f->serial_dropped_count), "serial",
        "none lost", "check the cable and end other programs that keep this computer busy",
        "%lld frames, %lld lost, %lld dropped by the board", (long long)f->serial_frame_count,
        (long long)f->serial_lost_count, (long long)f->serial_dropped_count);
    check_computer(f, report);
}
