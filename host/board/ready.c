#include "host/board/ready.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/channels.h"
#include "common/crash.h"
#include "common/gain.h"
#include "common/staircase.h"
#include "host/base/units.h"
#include "host/base/answer.h"
#include "host/board/gage_client.h"
#include "host/calibrate/jump.h"

#define MB 1e6
/* Every rig has these to be tested; and these have a name of their own when they are good. */
#define SELF_TESTS_ALWAYS \
    (1u << MR_SELF_TEST_RAM | 1u << MR_SELF_TEST_FLASH | 1u << MR_SELF_TEST_REFERENCE)
#define SELF_TESTS_NAMED \
    (SELF_TESTS_ALWAYS | 1u << MR_SELF_TEST_EXCITATION | 1u << MR_SELF_TEST_NOR)

/* ---- the report ---- */

static void limit(struct ready_check *check, const char *text)
{
    snprintf(check->limit, sizeof check->limit, "%s", text);
}

/* What to do about it, unless it is go. */
static void advise(struct ready_check *check, const char *text)
{
    if (check->verdict != READY_GO)
        snprintf(check->advice, sizeof check->advice, "%s", text);
}

const char *ready_text(enum ready_verdict verdict)
{
    static const char *const text[] = {
        [READY_GO] = "GO",
        [READY_NO_GO] = "NO-GO",
        [READY_NOT_DONE] = "not done",
        [READY_TOLD] = "told",
    };
    return text[verdict];
}

struct ready_check *ready_add(struct ready_report *report, enum ready_verdict verdict,
                              const char *name, const char *format, ...)
{
    static struct ready_check beyond;
    struct ready_check *check = report->count < READY_CHECKS ? &report->check[report->count++]
                                                             : &beyond;
    va_list arguments;
    memset(check, 0, sizeof *check);
    check->verdict = verdict;
    snprintf(check->name, sizeof check->name, "%s", name);
    va_start(arguments, format);
    vsnprintf(check->value, sizeof check->value, format, arguments);
    va_end(arguments);
    return check;
}

enum ready_verdict ready_verdict(const struct ready_report *report)
{
    return ready_count(report, READY_NO_GO) || report->count == 0 ? READY_NO_GO : READY_GO;
}

unsigned ready_count(const struct ready_report *report, enum ready_verdict verdict)
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
                                                ready_text(c->verdict), "value", c->value, "limit",
                                                c->limit, "advice", c->advice));
    }
    return checks;
}

#define VALUES        29u /* the column in which what was found begins */
#define COLUMNS_LEAST 60u

static void print_check(const struct ready_check *c, unsigned columns, FILE *out)
{
    char text[sizeof c->value + sizeof c->limit + 8], head[VALUES + 20];
    snprintf(text, sizeof text, "%s%s%s%s", c->value, c->limit[0] ? "  [" : "", c->limit,
             c->limit[0] ? "]" : "");
    snprintf(head, sizeof head, "%-8s  %-17s ", ready_text(c->verdict), c->name);
    fputs(head, out);
    wrap_print(text, strlen(head), VALUES, columns, out);
    if (!c->advice[0])
        return;
    fprintf(out, "%*s->", (int)VALUES, "");
    wrap_print(c->advice, VALUES + 2, VALUES + 3, columns, out);
}

static void print_verdict(const struct ready_report *report, double took_s, unsigned columns,
                          FILE *out)
{
    unsigned no_go = ready_count(report, READY_NO_GO), open = ready_count(report, READY_NOT_DONE);
    unsigned checks = report->count - ready_count(report, READY_TOLD);
    char text[READY_CHECKS * 24 + 120];
    size_t used = (size_t)snprintf(text, sizeof text, "%s after %.1f s",
                                   ready_text(ready_verdict(report)), took_s);
    const char *before = ": ";
    for (unsigned i = 0; i < report->count && used < sizeof text; i++) {
        if (report->check[i].verdict != READY_NO_GO)
            continue;
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", before,
                                 report->check[i].name);
        before = ", ";
    }
    used += (size_t)snprintf(text + used, sizeof text - used, "%s%u of %u checks are go",
                             no_go ? "; " : ": ", checks - no_go - open, checks);
    if (open)
        snprintf(text + used, sizeof text - used, ", %u not done", open);
    wrap_print(text, 0, 0, columns, out);
}

void ready_print(const struct ready_report *report, double took_s, unsigned columns, FILE *out)
{
    columns = columns < COLUMNS_LEAST ? COLUMNS_LEAST : columns;
    for (unsigned i = 0; i < report->count; i++)
        print_check(&report->check[i], columns, out);
    print_verdict(report, took_s, columns, out);
}

/* ---- calibration and certificates ---- */

static void channel_name(const struct mr_channel_config *channel, char *out, size_t size)
{
    if (channel->kind == MR_KIND_DISPLACEMENT)
        snprintf(out, size, "transducer %u", channel->number);
    else if (channel->kind == MR_KIND_TENSION)
        snprintf(out, size, "gage %u", channel->number);
    else
        snprintf(out, size, "%s", channel->kind == MR_KIND_STAIRCASE ? "staircase" : "reference");
}

static void judge_days(const struct ready_facts *f, struct ready_report *report)
{
    unsigned never = 0, sensors = 0, expired = 0;
    char text[120] = "", name[20];
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        if (!mr_channel_measures(channel))
            continue;
        sensors++;
        never += channel->calibrated_day == 0;
        if (!channel->expires_day || channel->expires_day > f->today_day)
            continue;
        channel_name(channel, name, sizeof name);
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s%s", expired++ ? ", " : "", name);
    }
    if (sensors == 0)
        return;
    if (expired) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "calibration", "expired: %s", text);
        limit(c, "expires_day after today");
        advise(c, "calibrate, then matrig board config set with the new values and dates");
    } else if (never) {
        advise(ready_add(report, READY_NOT_DONE, "calibration",
                         "%u of %u sensors have no date of calibration", never, sensors),
               "put calibrated_day and expires_day into the configuration");
    } else {
        limit(ready_add(report, READY_GO, "calibration", "%u sensors, none expired", sensors),
              "expires_day after today");
    }
}

/* A board of an older firmware may hold a gain that is refused today. */
static void judge_possible(const struct ready_facts *f, struct ready_report *report)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        char name[20], input[8], mistake[80];
        if (!mr_channel_measures(channel) || channel->unit_per_code == 0.0f ||
            mr_gain_check(channel) == MR_RULE_NONE)
            continue;
        jump_channel(i, input);
        snprintf(name, sizeof name, "calibration %s", input);
        mistake_text(channel, mistake, sizeof mistake);
        struct ready_check *c = ready_add(
            report, READY_NO_GO, name, "%.4g %s per code: no sensor of the rig has such a gain%s",
            (double)mr_channel_gain(channel), i < MR_TRANSDUCERS ? "in" : "lb", mistake);
        advise(c, "matrig board config get and check say more; calibrate the channel anew");
    }
}

static void judge_calibration(const struct ready_facts *f, struct ready_report *report)
{
    judge_days(f, report);
    judge_possible(f, report);
}

/* A bridge's zero holds for the temperature and the trim it was set at; before a landing somebody
 * measures it with the bands slack. */
static void judge_zeros(const struct ready_facts *f, struct ready_report *report)
{
    char is[UNIT_TEXT];
    unsigned gages = 0, measured = 0;
    float worst_lb = 0.0f;
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (f->config.channel[i].kind != MR_KIND_TENSION || !(f->zero_told >> i & 1u))
            continue;
        gages++;
        if (f->zero_measured >> i & 1u)
            measured++;
        else
            worst_lb = fmaxf(worst_lb, f->config.channel[i].zero_error);
    }
    if (!gages)
        return;
    if (measured == gages) {
        ready_add(report, READY_GO, "gage zeros", "all %u measured since reset", gages);
        return;
    }
    struct ready_check *c =
        ready_add(report, READY_NOT_DONE, "gage zeros",
                  "%u of %u not measured since reset: as configured, +- %s", gages - measured,
                  gages, unit_value_text(UNIT_TENSION, f->si, (double)worst_lb, 1, is));
    advise(c, "that holds where bridges are trimmed; with the bands slack: matrig board zero 2");
}

static void judge_certificate(const struct ready_facts *f, unsigned i, const char *channel,
                              struct ready_report *report)
{
    char name[20], text[CERTIFICATES_TEXT];
    const struct store_certificate *certificate = &f->certificates.of[i];
    enum certificate_state state = certificates_state(certificate, &f->config.channel[i], f->now_s);
    certificates_text(certificate, state, &f->config.channel[i], text);
    snprintf(name, sizeof name, "certificate %s", channel);
    struct ready_check *c = ready_add(
        report, state == CERTIFICATE_VALID ? READY_GO : READY_NO_GO, name, "%s: No. %s%s%s", text,
        certificate->number, certificate->laboratory[0] ? ", " : "", certificate->laboratory);
    advise(c,
           state == CERTIFICATE_OVERDUE
               ? "have the sensor calibrated; matrig calibrate CHANNEL --db DB --certificate ... "
                 "enters its new certificate"
               : "enter the certificate of the sensor that is fitted, or put its serial number "
                 "into the configuration");
}

void ready_judge_certificates(const struct ready_facts *f, struct ready_report *report)
{
    unsigned without = 0, sensors = 0;
    char text[200] = "", name[8];
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (!mr_channel_measures(&f->config.channel[i]))
            continue;
        sensors++;
        jump_channel(i, name);
        if (f->certificates.known[i]) {
            judge_certificate(f, i, name, report);
            continue;
        }
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s%s", without++ ? ", " : "", name);
    }
    if (without)
        ready_add(report, READY_TOLD, "certificates", "none is entered of %s",
                  without == sensors ? "any sensor" : text);
}

/* ---- readings ---- */

void ready_measure(const struct mr_config *config, const struct mr_block *blocks, unsigned count,
                   unsigned c, struct ready_channel *channel)
{
    double sum = 0.0, code_sum = 0.0, square = 0.0;
    unsigned valid = 0;
    *channel = (struct ready_channel){.mean = NAN, .noise_codes = NAN};
    for (unsigned i = 0; i < count; i++) {
        struct mr_reading reading =
            mr_channel_read(&config->channel[c], &blocks[i], c,
                            mr_channels_ratio(&config->channel[MR_REFERENCE], &blocks[i]));
        channel->blocks++;
        if (reading.validity != MR_VALID) {
            channel->invalid++;
            channel->validity = reading.validity;
            continue;
        }
        valid++;
        sum += (double)reading.value;
        code_sum += (double)reading.code;
    }
    if (!valid)
        return;
    channel->mean = (float)(sum / valid);
    for (unsigned i = 0; i < count; i++) {
        struct mr_reading reading =
            mr_channel_read(&config->channel[c], &blocks[i], c,
                            mr_channels_ratio(&config->channel[MR_REFERENCE], &blocks[i]));
        double off = (double)reading.code - code_sum / valid;
        square += reading.validity == MR_VALID ? off * off : 0.0;
    }
    if (valid > 1)
        channel->noise_codes = (float)sqrt(square / (valid - 1));
}

/* ---- who it is and what it runs ---- */

static void judge_image(const struct ready_facts *f, struct ready_report *report)
{
    char runs[MR_IMAGE_COMMIT_TEXT] = "unknown", why[200] = "";
    const struct mr_hello *hello = &f->identity.hello;
    bool whole = f->identity.commit_known && f->identity.commit.state == MR_IMAGE_GOOD;
    bool as_before = f->before && f->before_image == (int64_t)f->identity.image_crc;
    enum ready_verdict verdict = READY_GO;
    if (f->identity.commit_known)
        mr_image_commit_text(f->identity.commit.commit, f->identity.commit.commit_more,
                             f->identity.commit.changed != 0, runs);
    if (!whole)
        verdict = READY_NO_GO;
    else if (f->image)
        verdict = identity_runs(&f->identity, f->image, why, sizeof why) ? READY_GO : READY_NO_GO;
    else if (!f->before || f->before_image == STORE_NONE)
        verdict = READY_NOT_DONE;
    else if (!as_before)
        verdict = READY_NO_GO;
    struct ready_check *c =
        ready_add(report, verdict, "firmware", "%u.%u.%u, commit %s, image %08x, %s", hello->major,
                  hello->minor, hello->patch, runs, (unsigned)f->identity.image_crc,
                  mr_image_state_text(f->identity.commit_known ? f->identity.commit.state
                                                               : (unsigned)MR_IMAGE_NONE));
    if (f->image)
        snprintf(c->limit, sizeof c->limit, "image %08x, of %.50s", (unsigned)f->image->program_crc,
                 f->image_path);
    else if (f->before && f->before_image != STORE_NONE)
        snprintf(c->limit, sizeof c->limit, "image %08x, as RUN %lld had",
                 (unsigned)f->before_image, (long long)f->before_run);
    advise(c, !whole                      ? "flash it again: matrig flash LINK IMAGE"
              : f->image                  ? "not the image that was given: matrig flash LINK IMAGE"
              : verdict == READY_NOT_DONE ? "nothing to compare with: the campaign has no landing "
                                            "of this board; --image FILE compares"
                                          : "another image than that landing's: flash that one, or "
                                            "say --image FILE if it is meant");
}

/* What the board's CRC must be, to be configured as was asked for. */
static uint32_t expected_crc(const struct ready_facts *f)
{
    static uint8_t image[MR_CONFIG_IMAGE];
    if (!f->expected_config || !f->config_known)
        return f->expected_crc;
    struct mr_config wanted = *f->expected_config;
    wanted.site[0].revision = f->config.site[0].revision;
    return mr_config_encode(&wanted, image);
}

static void judge_configuration(const struct ready_facts *f, struct ready_report *report)
{
    bool compared = f->crc_expected || (f->before && f->before_config != STORE_NONE);
    uint32_t wanted = f->crc_expected ? expected_crc(f) : (uint32_t)f->before_config;
    if (!f->config_known) {
        advise(ready_add(report, READY_NO_GO, "configuration", "the board did not tell it"),
               "try again; is the serial link sound?");
        return;
    }
    enum ready_verdict verdict = !compared               ? READY_NOT_DONE
                               : wanted == f->config_crc ? READY_GO
                                                         : READY_NO_GO;
    struct ready_check *c = ready_add(
        report, verdict, "configuration", "CRC %08x, revision %u, %s", (unsigned)f->config_crc,
        (unsigned)f->config.site[0].revision,
        f->config_state_known ? mr_config_source_text(f->config_state.source) : "source not told");
    if (f->crc_expected)
        snprintf(c->limit, sizeof c->limit, "CRC %08x, as given", (unsigned)wanted);
    else if (compared)
        snprintf(c->limit, sizeof c->limit, "CRC %08x, as RUN %lld had", (unsigned)wanted,
                 (long long)f->before_run);
    advise(c, verdict == READY_NOT_DONE ? "nothing to compare with: the campaign has no landing of "
                                          "this board; --expect-config compares"
                                        : "compare: matrig board config get; send the right one "
                                          "with config set, or say --expect-config if it is meant");
}

/* ---- clock ---- */

static void judge_clock(const struct ready_facts *f, struct ready_report *report)
{
    unsigned source = f->identity.hello.clock_source;
    struct ready_check *c = ready_add(report, source == 0 ? READY_GO : READY_NO_GO, "clock", "%s",
                                      mr_clock_source_text(source));
    limit(c, "crystal");
    advise(c, "speeds are 1 % uncertain, CAN is silent: reset the board; change its crystal");
    const struct timemap_fit *t = &f->time;
    if (t->refusal == TIMEMAP_GOOD) {
        bool good = fabs(t->fast_ppm.value) - t->fast_ppm.half <= READY_CLOCK_PPM;
        c = ready_add(report, good ? READY_GO : READY_NO_GO, "time of day",
                      "board %+.0f +- %.0f ppm, from %zu messages",
                      unit_tidy(t->fast_ppm.value, 1.0), t->fast_ppm.half, t->pairs);
        snprintf(c->limit, sizeof c->limit, "%.0f ppm", READY_CLOCK_PPM);
        advise(c, "is this computer's clock being set? else the board's crystal is off");
    } else {
        advise(ready_add(report, READY_NOT_DONE, "time of day", "%s",
                         timemap_refusal_text((unsigned)t->refusal)),
               "");
    }
}

/* Off as from the factory it is no no-go: a supply that dips is rare, and was so before. */
static void judge_brown_out(const struct ready_facts *f, struct ready_report *report)
{
    if (!f->restarts_known)
        return;
    bool set = f->restarts.brown_out > 0;
    struct ready_check *c = ready_add(report, set ? READY_GO : READY_NOT_DONE, "brown-out reset",
                                      set ? "below %s" : "%s, as from the factory",
                                      mr_brown_out_text(f->restarts.brown_out));
    limit(c, "on");
    advise(c, "below 2.7 V the processor does what it likes: set it once, with the bring-up image "
              "(matrig board bringup brown-out)");
}

/* ---- channels ---- */

static void judge_invalid(const struct ready_channel *m, const char *name, bool bridge,
                          struct ready_report *report)
{
    bool open = m->validity == MR_INVALID_OPEN;
    struct ready_check *c = ready_add(
        report, READY_NO_GO, name, "%s, %u of %u readings not valid",
        bridge && open ? "bridge open" : mr_validity_text(m->validity), m->invalid, m->blocks);
    limit(c, "all valid");
    advise(c, open ? "look at its plug and leads"
              : m->validity == MR_INVALID_REFERENCE
                  ? "the reference voltage is out of range: look at the converter's supply"
              : m->validity == MR_INVALID_RANGE
                  ? "beyond what it can measure: set it back to its zero"
                  : "look at its wiring and excitation");
}

/* "100 +- 25 lb" */
static const char *within_text(const struct ready_facts *f, float wanted_lb, float by_lb,
                               char out[UNIT_TEXT])
{
    char by[UNIT_TEXT];
    const struct unit *unit = unit_of(UNIT_TENSION, f->si);
    snprintf(out, UNIT_TEXT, "%.0f +- %.20s", (double)wanted_lb * unit->factor,
             unit_value_text(UNIT_TENSION, f->si, (double)by_lb, 0, by));
    return out;
}

static void judge_channel(const struct ready_facts *f, unsigned i, struct ready_report *report)
{
    const struct mr_channel_config *channel = &f->config.channel[i];
    const struct ready_channel *m = &f->channel[i];
    char name[20];
    channel_name(channel, name, sizeof name);
    if (m->blocks == 0) {
        advise(ready_add(report, READY_NOT_DONE, name, "no readings came"), "");
        return;
    }
    if (m->invalid || isnan(m->mean)) {
        judge_invalid(m, name, channel->kind == MR_KIND_TENSION, report);
        return;
    }
    bool noisy = m->noise_codes > READY_NOISE_CODES;
    char is[UNIT_TEXT], most[UNIT_TEXT];
    if (channel->kind == MR_KIND_DISPLACEMENT) {
        bool off = fabsf(m->mean) > READY_ZERO_IN;
        struct ready_check *c =
            ready_add(report, off || noisy ? READY_NO_GO : READY_GO, name,
                      "%s from its zero, noise %.2f codes",
                      unit_signed_text(UNIT_DISPLACEMENT, f->si, (double)m->mean, 4, is),
                      (double)m->noise_codes);
        snprintf(c->limit, sizeof c->limit, "%s, %.0f codes",
                 unit_value_text(UNIT_DISPLACEMENT, f->si, (double)READY_ZERO_IN, 2, most),
                 (double)READY_NOISE_CODES);
        advise(c, off ? "push the mat back, or take the zero: matrig board zero 1"
                      : "noise: look at its screen and ground");
        return;
    }
    float wanted_lb = channel->band ? f->config.band[channel->band - 1].pretension_lb : 0.0f;
    bool off = wanted_lb > 0.0f && fabsf(m->mean - wanted_lb) > READY_GAGE_PRETENSION * wanted_lb;
    struct ready_check *c = ready_add(
        report, off || noisy ? READY_NO_GO : READY_GO, name, "%s, noise %.2f codes",
        unit_value_text(UNIT_TENSION, f->si, (double)m->mean, 1, is), (double)m->noise_codes);
    if (wanted_lb > 0.0f)
        snprintf(c->limit, sizeof c->limit, "%s, %.0f codes",
                 within_text(f, wanted_lb, READY_GAGE_PRETENSION * wanted_lb, most),
                 (double)READY_NOISE_CODES);
    else
        snprintf(c->limit, sizeof c->limit, "%.0f codes", (double)READY_NOISE_CODES);
    advise(c, off ? "is the band slack or unequal there? else its zero is off"
                  : "noise: look at its screen and ground");
}

static void judge_band(const struct ready_facts *f, unsigned band, struct ready_report *report)
{
    float wanted_lb = f->config.band[band - 1].pretension_lb, sum = 0.0f;
    unsigned gages = 0;
    char name[20], is[UNIT_TEXT];
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (f->config.channel[i].kind == MR_KIND_TENSION && f->config.channel[i].band == band &&
            !isnan(f->channel[i].mean) && f->channel[i].blocks) {
            sum += f->channel[i].mean;
            gages++;
        }
    }
    if (wanted_lb <= 0.0f || !gages)
        return;
    float mean = sum / (float)gages;
    snprintf(name, sizeof name, "band %u", band);
    struct ready_check *c = ready_add(
        report, fabsf(mean - wanted_lb) <= READY_PRETENSION * wanted_lb ? READY_GO : READY_NO_GO,
        name, "pretension %s, mean of %u gages",
        unit_value_text(UNIT_TENSION, f->si, (double)mean, 1, is), gages);
    snprintf(c->limit, sizeof c->limit, "%s",
             within_text(f, wanted_lb, READY_PRETENSION * wanted_lb, is));
    advise(c, mean < wanted_lb ? "tension the band" : "slacken the band");
}

static void judge_shunts(const struct ready_facts *f, struct ready_report *report)
{
    bool any = false;
    for (unsigned i = 0; i < MR_GAGES; i++)
        any |= f->config.channel[MR_TRANSDUCERS + i].kind == MR_KIND_TENSION &&
               f->config.channel[MR_TRANSDUCERS + i].shunt_lb > 0.0f;
    if (!any)
        return;
    if (!f->shunt_done || f->shunts.count == 0) {
        advise(
            ready_add(report, READY_NO_GO, "shunt calibration", "%s",
                      f->shunt_done ? mr_status_text(f->shunt_status) : "the board did not answer"),
            "the board must be idle; try again");
        return;
    }
    char text[READY_VALUE - 40] = "", is[UNIT_TEXT], of[UNIT_TEXT];
    unsigned bad = 0, compared = 0;
    float worst = 0.0f;
    for (unsigned i = 0; i < f->shunts.count; i++) {
        const struct mr_shunt_result *r = &f->shunts.result[i];
        float before = r->gage >= 1 && r->gage <= MR_GAGES ? f->before_span_lb[r->gage - 1] : NAN;
        float change = r->span_lb - before;
        bool drifted = !isnan(change) &&
                       fabsf(change) > READY_SHUNT_DRIFT * fabsf(before) + 3.0f * r->noise_lb;
        size_t at = strlen(text);
        compared += isnan(change) ? 0u : 1u;
        if (!isnan(change) && fabsf(change) > fabsf(worst))
            worst = change;
        if (r->verdict == MR_SHUNT_GOOD && !drifted)
            continue;
        if (r->verdict != MR_SHUNT_GOOD)
            snprintf(text + at, sizeof text - at, "%sgage %u %s (%s of %s)", bad ? ", " : "",
                     r->gage, shunts_verdict_text(r->verdict),
                     unit_value_text(UNIT_TENSION, f->si, (double)r->span_lb, 2, is),
                     unit_value_text(UNIT_TENSION, f->si, (double)f->shunts.check[i].expected_lb, 2,
                                     of));
        else
            snprintf(text + at, sizeof text - at, "%sgage %u drifted by %s", bad ? ", " : "",
                     r->gage, unit_signed_text(UNIT_TENSION, f->si, (double)change, 2, is));
        bad++;
    }
    struct ready_check *c = bad ? ready_add(report, READY_NO_GO, "shunt calibration", "%s", text)
                                : ready_add(report, READY_GO, "shunt calibration", "%u gages good",
                                            f->shunts.count);
    size_t at = strlen(c->value);
    if (!bad && compared)
        snprintf(c->value + at, sizeof c->value - at, "; since the last one %s at most",
                 unit_signed_text(UNIT_TENSION, f->si, (double)worst, 3, is));
    else if (!bad)
        snprintf(c->value + at, sizeof c->value - at, "; no earlier one is kept");
    limit(c, "1 % and three errors");
    advise(c, "look at that bridge and its amplifier; matrig board shunt tells more");
}

/* Switches that open add to the staircase and stay open until they are set. */
static void judge_switches(const struct ready_facts *f, struct ready_report *report)
{
    const unsigned i = MR_TRANSDUCERS + MR_ADC1_STAIRCASE;
    uint16_t steps[MR_CONFIG_SWITCHES];
    if (f->config.channel[i].kind != MR_KIND_STAIRCASE || f->channel[i].blocks == 0)
        return;
    for (unsigned s = 0; s < MR_CONFIG_SWITCHES; s++)
        steps[s] = f->config.gate[s].step_codes;
    float level = f->channel[i].mean - f->config.channel[i].zero_code;
    unsigned one = mr_staircase_name(level, steps, MR_CONFIG_SWITCHES, 0);
    bool closed = fabsf(level) < READY_LATCH_CODES;
    const double codes = unit_tidy((double)level, 0.1);
    struct ready_check *c;
    if (closed)
        c = ready_add(report, READY_GO, "switches",
                      "all closed: staircase %.1f codes from its zero", codes);
    else if (one)
        c = ready_add(report, READY_NO_GO, "switches", "switch %u is open: staircase %.1f codes",
                      one, codes);
    else
        c = ready_add(report, READY_NO_GO, "switches", "staircase %.1f codes from its zero: %s",
                      codes, level > 0.0f ? "switches are open" : "it cannot be so low");
    snprintf(c->limit, sizeof c->limit, "%.0f codes", (double)READY_LATCH_CODES);
    advise(c, level > 0.0f ? "set the switches along the runway"
                           : "look at the staircase's lead and supply");
}

static void judge_channels(const struct ready_facts *f, struct ready_report *report)
{
    if (f->blocks == 0) {
        advise(ready_add(report, READY_NO_GO, "readings", "no block records came"),
               "the board must be idle, with its scans running: matrig board health");
        return;
    }
    bool good = f->blocks_lost == 0 && f->blocks >= READY_BLOCKS / 2;
    struct ready_check *c = ready_add(report, good ? READY_GO : READY_NO_GO, "readings",
                                      "%u blocks looked at, %u lost by the board", f->blocks,
                                      f->blocks_lost);
    snprintf(c->limit, sizeof c->limit, "%u or more, none lost", READY_BLOCKS / 2);
    advise(c, "matrig board health says what it counts");
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (mr_channel_measures(&f->config.channel[i]))
            judge_channel(f, i, report);
    }
    for (unsigned band = 1; band <= MR_CONFIG_BANDS; band++)
        judge_band(f, band, report);
    judge_switches(f, report);
}

/* ---- the board's own ---- */

static void judge_box(const struct ready_facts *f, struct ready_report *report)
{
    struct ready_check *c;
    if (f->config_known && !f->config.site[0].black_box) {
        advise(ready_add(report, READY_NOT_DONE, "black box", "none, by the configuration"), "");
        return;
    }
    if (!f->box_known) {
        advise(ready_add(report, READY_NO_GO, "black box", "the board did not tell of it"),
               "try again; is the serial link sound?");
        return;
    }
    const char *state = f->box.state == MR_BOX_MISSING ? "no memory answers"
                                                       : mr_box_condition_text(f->box.state);
    bool good = f->box.state == MR_BOX_READY && f->box.wait_s == 0.0f;
    char wait[60] = "";
    if (isnan(f->box.wait_s))
        snprintf(wait, sizeof wait, ", no room before records are freed");
    else if (f->box.wait_s > 0.0f)
        snprintf(wait, sizeof wait, ", %.1f s until a landing may be armed", (double)f->box.wait_s);
    c = ready_add(report, good ? READY_GO : READY_NO_GO, "black box",
                  "%s%s, %u sectors erased, %u bad, %u records not freed", state, wait,
                  f->box.ready, f->space.bad, f->box.records);
    snprintf(c->limit, sizeof c->limit, "ready, %u sectors", f->box.reserve);
    advise(c, f->box.state != MR_BOX_READY && f->box.state != MR_BOX_LOOKING
                  ? "look at the memory on SPI2; without it: site.black_box = 0"
              : isnan(f->box.wait_s) ? "matrig board read N, then free N"
                                     : "wait, it erases by itself");
}

static void judge_self_test(const struct ready_facts *f, struct ready_report *report)
{
    const unsigned lamp = (1u << MR_SELF_TEST_LAMP_ON) | (1u << MR_SELF_TEST_LAMP_OFF);
    char text[140] = "";
    unsigned failed = f->test.failed & ~lamp, undone = SELF_TESTS_ALWAYS & ~(unsigned)f->test.done;
    unsigned named = failed ? failed : undone ? undone : f->test.done & SELF_TESTS_NAMED;
    if (!f->tested) {
        advise(ready_add(report, READY_NO_GO, "self-test", "the board did not do it"),
               "the board must be idle; try again, reset it");
        return;
    }
    for (unsigned i = 0; i < MR_SELF_TEST_COUNT; i++) {
        size_t at = strlen(text);
        if (named >> i & 1u)
            snprintf(text + at, sizeof text - at, "%s%s", at ? ", " : "", mr_self_test_text(i));
    }
    struct ready_check *c = failed || undone
                              ? ready_add(report, READY_NO_GO, "self-test", "%s: %s",
                                          failed ? "failed" : "not tested", text)
                              : ready_add(report, READY_GO, "self-test", "good: %s", text);
    advise(c, "matrig board self-test and health tell more");
    bool lit = (f->test.done & lamp) == lamp && !(f->test.failed & lamp);
    c = ready_add(report, lit ? READY_GO : READY_NO_GO, "warning lamp", "%s",
                  lit                                            ? "lights and goes out"
                  : f->test.failed & 1u << MR_SELF_TEST_LAMP_ON  ? "does not light"
                  : f->test.failed & 1u << MR_SELF_TEST_LAMP_OFF ? "does not go out"
                                                                 : "not tested");
    advise(c, "look at lamp, fuse and driver on PE0; the read-back is PE3");
}

static void judge_temperature(const struct ready_facts *f, struct ready_report *report)
{
    if (f->config_known && !f->config.site[0].thermometer) {
        advise(ready_add(report, READY_NOT_DONE, "thermometer", "none, by the configuration"), "");
        return;
    }
    bool good = f->temperature_known && !isnan(f->temperature.temperature_c);
    struct ready_check *c = good ? ready_add(report, READY_GO, "thermometer", "%.2f +- %.2f C",
                                             unit_tidy((double)f->temperature.temperature_c, 0.01),
                                             (double)f->temperature.error_c)
                                 : ready_add(report, READY_NO_GO, "thermometer", "%s",
                                             f->temperature_known ? "no reading" : "not told");
    advise(c, "fault 30 of matrig board health says why; without one: site.thermometer = 0");
}

static void judge_faults(const struct ready_facts *f, struct ready_report *report)
{
    char text[READY_VALUE - 40] = "";
    unsigned rising = 0, count = 0;
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        /* self-test and channels have checks of their own */
        count += f->fault[i].count != 0;
        rising += f->fault_rise[i] != 0 && i != MR_FAULT_SELFTEST && i != MR_FAULT_CHANNEL;
    }
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        size_t at = strlen(text);
        if (f->fault[i].count &&
            (!rising || (f->fault_rise[i] && i != MR_FAULT_SELFTEST && i != MR_FAULT_CHANNEL)))
            snprintf(text + at, sizeof text - at, "%s%s", at ? "; " : "", mr_fault_text(i));
    }
    struct ready_check *c = rising ? ready_add(report, READY_NO_GO, "faults", "going on: %s", text)
                          : count  ? ready_add(report, READY_GO, "faults",
                                               "none goes on; since reset: %s", text)
                                   : ready_add(report, READY_GO, "faults", "none since reset");
    limit(c, "none that goes on");
    advise(c, "matrig board health tells each");
}

/* ---- links and computer ---- */

/* On a bus of several boards what comes at the base given may be another one's. */
static bool is_on_can(const struct ready_facts *f)
{
    const uint32_t *serial = f->identity.uid, *can = f->on_can.uid;
    return (serial[0] | serial[1]) == 0 || (serial[0] == can[0] && serial[1] == can[1]);
}

static void judge_whose_can(const struct ready_facts *f, struct ready_report *report)
{
    char can[IDENTITY_UID_TEXT], serial[IDENTITY_UID_TEXT];
    identity_uid_text(&f->on_can, can);
    identity_uid_text(&f->identity, serial);
    bool told = (f->on_can.uid[0] | f->on_can.uid[1]) != 0;
    struct ready_check *c = ready_add(report, READY_NO_GO, "CAN",
                                      "%s at base 0x%03x: board %s, on serial %s",
                                      told ? "another board" : "others, and not the board,",
                                      f->can_base, told ? can : "unknown", serial);
    limit(c, "the board itself");
    advise(c, "give its base, as can:can0,base=0x190, or its own serial line");
}

static void judge_can(const struct ready_facts *f, struct ready_report *report)
{
    const char *state = f->alarm_known ? mr_can_state_text(f->alarm.state)
                                       : "the board did not tell";
    bool good = f->alarm_known && f->alarm.state == MR_CAN_GOOD && f->can_frames > 0 &&
                f->can_lost == 0 && f->can_dropped == 0;
    struct ready_check *c;
    if (!f->can_used) {
        advise(ready_add(report, READY_NOT_DONE, "CAN", "not used here; the board says: %s", state),
               "--can LINK listens");
        return;
    }
    if (f->can_frames > 0 && !is_on_can(f)) {
        judge_whose_can(f, report);
        return;
    }
    c = ready_add(report, good ? READY_GO : READY_NO_GO, "CAN",
                  "%s; %lld frames, %lld lost, %lld dropped by the board", state,
                  (long long)f->can_frames, (long long)f->can_lost, (long long)f->can_dropped);
    limit(c, "good, none lost");
    bool kept_silent = f->alarm_known ? f->alarm.state == MR_CAN_SILENT
                                      : f->identity.hello.clock_source != 0;
    advise(c, kept_silent ? "the board keeps CAN silent until its clock is exact: see clock"
              : f->can_frames == 0 ? "look at plug, terminators and bit rate"
                                   : "look at the bus and this computer's load");
}

static void judge_serial(const struct ready_facts *f, struct ready_report *report)
{
    struct ready_check *c =
        ready_add(report, f->serial_lost || f->serial_dropped ? READY_NO_GO : READY_GO, "serial",
                  "%lld frames, %lld lost, %lld dropped by the board", (long long)f->serial_frames,
                  (long long)f->serial_lost, (long long)f->serial_dropped);
    limit(c, "none lost");
    advise(c, "look at the cable and at this computer's load");
}

static void judge_computer(const struct ready_facts *f, struct ready_report *report)
{
    double wanted = READY_LANDINGS * f->landing_bytes;
    struct ready_check *c = ready_add(report, f->free_bytes >= wanted ? READY_GO : READY_NO_GO,
                                      "disk", "%.0f MB free, a landing takes %.1f MB",
                                      f->free_bytes / MB, f->landing_bytes / MB);
    snprintf(c->limit, sizeof c->limit, "%.0f MB: %.0f landings", wanted / MB, READY_LANDINGS);
    advise(c, "make room where the campaign is, or use another disk");
    c = f->database[0] ? ready_add(report, READY_NO_GO, "database", "%s", f->database)
                       : ready_add(report, READY_GO, "database", "writable%s",
                                   f->database_checked ? ", its pages whole"
                                                       : "; too large to be gone through in time");
    advise(c, "may you write there, is another program writing? else begin a new campaign and keep "
              "this one");
}

/* Whether to land so is people's to decide: an advice is told, and makes nothing no-go. */
static void tell_advice(const struct ready_facts *f, struct ready_report *report)
{
    if (!f->advice[0])
        return;
    struct ready_check *c = ready_add(report, READY_TOLD, "advice", "%s", f->advice);
    if (f->advised_against)
        advise(c, "matrig advise has the whole table; whether to land so is yours to decide");
}

void ready_judge(const struct ready_facts *f, struct ready_report *report)
{
    report->count = 0;
    if (!f->hello) {
        advise(ready_add(report, READY_NO_GO, "board", "no hello"),
               "is it powered and connected, at the right rate?");
        judge_computer(f, report);
        return;
    }
    bool busy = f->identity.hello.state != MR_LANDING_IDLE;
    char uid[IDENTITY_UID_TEXT];
    identity_uid_text(&f->identity, uid);
    struct ready_check *c = ready_add(report, busy ? READY_NO_GO : READY_GO, "board",
                                      "%s, layout %u, %s", uid, f->identity.hello.layout,
                                      busy ? "a landing is armed or going on" : "idle");
    snprintf(c->limit, sizeof c->limit, "layout %u, idle", (unsigned)MR_LAYOUT);
    advise(c, "disarm it, or wait until it is done");
    judge_image(f, report);
    judge_configuration(f, report);
    if (f->config_known) {
        judge_calibration(f, report);
        ready_judge_certificates(f, report);
    }
    judge_clock(f, report);
    judge_brown_out(f, report);
    if (f->config_known) {
        judge_channels(f, report);
        judge_zeros(f, report);
        judge_shunts(f, report);
    }
    judge_box(f, report);
    judge_self_test(f, report);
    judge_temperature(f, report);
    judge_faults(f, report);
    judge_can(f, report);
    judge_serial(f, report);
    judge_computer(f, report);
    tell_advice(f, report);
}
