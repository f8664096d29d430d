#include "host/report/report.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <sha2.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "common/version.h"
#include "host/base/assets.h"
#include "host/base/html.h"
#include "host/base/output.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"
#include "host/survey/survey.h"

#define ITEM_TEXTS_MAX  3u /* maximum number of texts that a fact lists */
#define RUNS_LISTED_MAX 6u /* maximum number of RUNs that a line lists before "and 12 more" */
#define SECONDS_PER_DAY 86400

/* ---- all pages ---- */

static const char *const scripts[] = {"/dygraph.js", "/charts.js"};

static void write_asset(FILE *out, const char *path)
{
    const struct asset *asset = asset_find(path);
    fwrite(asset->bytes, 1, (size_t)(asset->end - asset->bytes), out);
}

/* Writes the content security policy: the page loads nothing and runs only its own scripts. */
static void write_security_policy(FILE *out)
{
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Init(&hash);
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++) {
        const struct asset *asset = asset_find(scripts[i]);
        SHA256Update(&hash, (const uint8_t *)asset->bytes, (size_t)(asset->end - asset->bytes));
    }
    SHA256Final(sum, &hash);
    fputs(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
        "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; script-src 'sha256-",
        out);
    html_write_base64(out, sum, sizeof sum);
    fputs("'\">", out);
}

const char *report_database_name(const struct report *report)
{
    return strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path;
}

/* Returns the number of landings of emulated boards. Sets of[i] to true for these landings (`of`
 * NULL: not needed). */
static size_t count_emulated(const struct report *report, bool *of)
{
    size_t count = 0;
    for (size_t i = 0; i < report->landings; i++) {
        count += report->facts[i].is_emulated;
        if (of)
            of[i] = report->facts[i].is_emulated;
    }
    return count;
}

static void write_page_head(FILE *out, const struct report *report)
{
    fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<meta name=\"color-scheme\" content=\"light dark\">",
          out);
    write_security_policy(out);
    fputs("<title>", out);
    if (report->run)
        fprintf(out, "RUN %lld, ", (long long)report->run);
    html_write_text(out, report_database_name(report));
    fputs(" \xc2\xb7 matrig report</title>\n<style>", out);
    write_asset(out, "/dygraph.css");
    write_asset(out, "/report.css");
    if (count_emulated(report, NULL)) /* a note that appears on every printed sheet */
        fputs("@page{@top-center{content:\"EMULATED BOARD, SYNTHETIC DATA\";font:bold 9pt "
              "sans-serif}}",
              out);
    fputs("</style></head>\n<body>", out);
}

static void write_page_foot(FILE *out)
{
    fputs("<script>", out);
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++)
        write_asset(out, scripts[i]);
    fputs("</script>\n</body></html>\n", out);
}

void report_write_answer(struct answer *answer, FILE *out)
{
    answer_print_html(answer, out);
    answer_free(answer);
}

/* ---- the front: the main facts. An unknown fact names the command that enters it ---- */

static void begin_item(FILE *out, const char *term)
{
    fprintf(out, "<div><dt>%s</dt><dd>", term);
}

static void end_item(FILE *out)
{
    fputs("</dd></div>\n", out);
}

/* Writes a missing value: "not entered", and the command that enters it. */
static void write_missing_value(FILE *out, const char *word, const char *how)
{
    fprintf(out, "%s <small>", word);
    html_write_text(out, how);
    fputs("</small>", out);
}

/* A text that landings have; each different text is listed once, in the order of the landings. */
struct text_item {
    const char *term;
    size_t offset; /* offset of a string in struct report_facts */
    const char *entry_command;
};

static void write_text_item(const struct report *report, const struct text_item *row, FILE *out)
{
    const char *named[ITEM_TEXTS_MAX];
    size_t count = 0, others = 0;
    begin_item(out, row->term);
    for (size_t i = 0; i < report->landings; i++) {
        const char *value = (const char *)&report->facts[i] + row->offset;
        bool known = !value[0];
        for (size_t k = 0; k < count && !known; k++)
            known = strcmp(named[k], value) == 0;
        if (known)
            continue;
        if (count < ITEM_TEXTS_MAX)
            named[count++] = value;
        else
            others = 1;
    }
    for (size_t k = 0; k < count; k++) {
        fputs(k ? "; " : "", out);
        html_write_text(out, named[k]);
    }
    fputs(others ? "; and others" : "", out);
    if (count == 0)
        write_missing_value(out, "not entered", row->entry_command);
    end_item(out);
}

/* ---- dates ---- */

static void format_day(int64_t us, char out[20])
{
    time_t second = (time_t)(us / 1000000);
    struct tm utc;
    out[0] = '\0';
    if (gmtime_r(&second, &utc))
        strftime(out, 20, "%Y-%m-%d", &utc);
}

/* Prints the local time of this computer, which the laboratory's book uses. */
static void write_local_time(int64_t first_us, int64_t last_us, FILE *out)
{
    const time_t first_s = (time_t)(first_us / 1000000), last_s = (time_t)(last_us / 1000000);
    struct tm local;
    char from[20] = "", to[60] = "";
    if (localtime_r(&first_s, &local))
        strftime(from, sizeof from, "%H:%M", &local);
    if (localtime_r(&last_s, &local))
        strftime(to, sizeof to, "%H:%M (UTC%z)", &local);
    fprintf(out, " <small>armed, local time: %s to %s</small>", from, to);
}

static void write_date_item(const struct report *report, FILE *out)
{
    int64_t first_us = INT64_MAX, last_us = INT64_MIN;
    char first[20], last[20];
    begin_item(out, "date (UTC)");
    for (size_t i = 0; i < report->landings; i++) {
        int64_t us = report->facts[i].landing.armed_us;
        if (us < SURVEY_EARLIEST_DATE_US)
            continue;
        first_us = us < first_us ? us : first_us;
        last_us = us > last_us ? us : last_us;
    }
    if (last_us >= SURVEY_EARLIEST_DATE_US) {
        format_day(first_us, first);
        format_day(last_us, last);
        html_write_text(out, first);
        if (strcmp(first, last) != 0) {
            fputs(" to ", out);
            html_write_text(out, last);
        }
        write_local_time(first_us, last_us, out);
    } else if (report->landings) {
        write_missing_value(out, "not known", "the recording contains no times of day");
    } else {
        fputs("no landing", out);
    }
    end_item(out);
}

/* ---- lists of RUNs ---- */

void report_write_runs(const struct report *report, const bool *of, FILE *out)
{
    size_t named = 0, count = 0;
    for (size_t i = 0; i < report->landings; i++) {
        if (!of[i] || ++count > RUNS_LISTED_MAX)
            continue;
        fprintf(out, "%s<a href=\"#run%lld\">%lld</a>", named++ ? ", " : "RUN ",
                (long long)report->facts[i].landing.id, (long long)report->facts[i].landing.id);
    }
    if (count > RUNS_LISTED_MAX)
        fprintf(out, " and %zu more", count - RUNS_LISTED_MAX);
}

static void write_landings_item(const struct report *report, FILE *out)
{
    begin_item(out, "landings");
    fprintf(out, "%zu", report->landings);
    if (report->landings) {
        int64_t first = report->facts[0].landing.id,
                last = report->facts[report->landings - 1].landing.id;
        fprintf(out, first == last ? ": RUN %lld" : ": RUN %lld to %lld", (long long)first,
                (long long)last);
    }
    if (report->voided_landings)
        fprintf(out, "; %zu void landing%s left out", report->voided_landings,
                report->voided_landings == 1 ? "" : "s");
    end_item(out);
}

/* ---- numbers ---- */

/* A number that landings have: "35.49 +- 0.02 ft/s" for one landing; for several, "28.00 to 35.49
 * ft/s" with the largest error, and how many are not known. */
struct number_item {
    const char *term;
    size_t offset; /* offset of a struct mr_estimate in struct report_facts */
    enum unit_kind kind;
    int decimals;
    const char *unknown, *entry_command;
};

static void write_number_item(const struct report *report, const struct number_item *row, FILE *out)
{
    const struct unit *unit = unit_get(row->kind, report->si);
    const int d = row->decimals;
    double low = (double)INFINITY, high = -(double)INFINITY, error = (double)NAN;
    size_t known = 0;
    begin_item(out, row->term);
    for (size_t i = 0; i < report->landings; i++) {
        struct mr_estimate value;
        memcpy(&value, (const char *)&report->facts[i] + row->offset, sizeof value);
        if (!isfinite(value.value))
            continue;
        known++;
        error = fmax(error, unit->factor * value.error);
        low = fmin(low, unit->factor * value.value);
        high = fmax(high, unit->factor * value.value);
    }
    if (known == 0)
        write_missing_value(out, row->unknown, row->entry_command);
    else if (high - low < 0.5 * pow(10.0, -d))
        fprintf(out, "%.*f", d, low);
    else
        fprintf(out, "%.*f to %.*f", d, low, d, high);
    if (known == 1 && isfinite(error))
        fprintf(out, " &plusmn; %.*f", d, error);
    if (known) {
        fputc(' ', out);
        html_write_text(out, unit->text);
    }
    if (known > 1 && isfinite(error))
        fprintf(out, " <small>each &plusmn; %.*f or less</small>", d, error);
    if (known && known < report->landings)
        fprintf(out, " <small>unknown for %zu</small>", report->landings - known);
    end_item(out);
}

static void write_movement_item(const struct report *report, FILE *out)
{
    const struct report_movement *largest = NULL;
    int64_t run = 0;
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, report->si);
    const int decimals = unit_decimals(UNIT_DISPLACEMENT, report->si, 3);
    char text[UNIT_TEXT_SIZE];
    begin_item(out, "largest movement");
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_movement *moved = report_find_largest_movement(&report->facts[i]);
        if (!moved || (largest && fabs(moved->peak_in) <= fabs(largest->peak_in)))
            continue;
        largest = moved;
        run = report->facts[i].landing.id;
    }
    if (largest) {
        fprintf(out, "%.*f &plusmn; %.*f&nbsp;%s at&nbsp;%s", decimals,
                length->factor * largest->peak_in, decimals,
                length->factor * largest->peak_error_in, length->text,
                unit_value_text(UNIT_STATION, report->si, largest->station_ft, 0, text));
        if (!report->run)
            fprintf(out, ", RUN %lld", (long long)run);
    } else {
        fputs("not known: no transducer has a peak", out);
    }
    end_item(out);
}

/* ---- zones and outcomes ---- */

/* "76 mats, 86.3 +- 0.2 to 108.0 +- 2.8 ft" */
static void write_zone(const struct report_zone *zone, bool si, FILE *out)
{
    const struct unit *station = unit_get(UNIT_STATION, si);
    const double end_ft[] = {zone->start_ft, zone->end_ft},
                 error_ft[] = {zone->start_error_ft, zone->end_error_ft};
    fprintf(out, "%lld mats, ", (long long)zone->mats);
    for (int i = 0; i < 2; i++) {
        fprintf(out, "%s%.1f", i ? " to " : "", station->factor * end_ft[i]);
        if (isfinite(error_ft[i]))
            fprintf(out, "&nbsp;&plusmn;&nbsp;%.1f", station->factor * error_ft[i]);
    }
    fprintf(out, "&nbsp;%s", station->text);
}

static void write_zones_item(const struct report *report, bool *of, FILE *out)
{
    const struct report_facts *longest = NULL;
    size_t warned = 0, unheard = 0, watched = 0;
    begin_item(out, "zone warned of");
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        of[i] = facts->warning.has_warning;
        warned += of[i];
        watched += facts->source != MEASURED_IMPORT;
        unheard += !of[i] && facts->source != MEASURED_IMPORT && facts->may_have_missed_warning;
        if (of[i] &&
            (!longest || facts->longest_warned_zone.mats > longest->longest_warned_zone.mats))
            longest = facts;
    }
    if (watched == 0)
        fputs("not known, because no board recorded the landing", out);
    else if (warned == 0)
        fputs("none", out);
    else if (!report->run) {
        fprintf(out, "in %zu of %zu landings: ", warned, report->landings);
        report_write_runs(report, of, out);
    }
    if (longest && longest->longest_warned_zone.mats > 0) {
        fputs(report->run ? "" : "; longest zone ", out);
        write_zone(&longest->longest_warned_zone, report->si, out);
    }
    if (unheard)
        fprintf(out, " <small>landings in which the log may have missed a warning: %zu</small>",
                unheard);
    end_item(out);
}

static void write_outcome_counts_item(const struct report *report, FILE *out)
{
    static const enum warning_outcome verdict_order[] = {
        WARNING_HIT,         WARNING_LATE,          WARNING_MISS,
        WARNING_FALSE_ALARM, WARNING_TRUE_NEGATIVE, WARNING_OUTCOME_UNKNOWN};
    size_t count[WARNING_OUTCOME_COUNT] = {0};
    char outcome[OUTCOME_TEXT_SIZE], lead[OUTCOME_LEAD_TIME_SIZE];
    bool any = false;
    begin_item(out, report->run ? "outcome" : "warnings by outcome");
    for (size_t i = 0; i < report->landings; i++) {
        enum warning_outcome verdict = report->facts[i].warning_record.warning_outcome;
        count[verdict < WARNING_OUTCOME_COUNT ? verdict : WARNING_OUTCOME_UNKNOWN]++;
    }
    for (size_t k = 0; k < sizeof verdict_order / sizeof verdict_order[0]; k++) {
        if (count[verdict_order[k]] == 0)
            continue;
        fputs(any ? "; " : "", out);
        if (!report->run)
            fprintf(out, "%zu ", count[verdict_order[k]]);
        fputs(report->run ? outcome_record_format_outcome(&report->facts[0].warning_record, outcome)
                          : warning_outcome_text(verdict_order[k]),
              out);
        any = true;
    }
    for (size_t i = 0; i < report->landings; i++) {
        const struct outcome_record_row *row = &report->facts[i].warning_record;
        if (outcome_record_is_marginal(row))
            fprintf(
                out,
                " <small>RUN %lld reached %lld \xc2\xb1 %d mats: within the standard error of the "
                "limit (%d mats)</small>",
                (long long)row->run, (long long)row->outcome.longest_mats, ZONES_ERROR_MATS,
                OUTCOME_MIN_ZONE_MATS);
        else if (row->lead_time_low_s < 0.0 && row->lead_time_high_s > 0.0)
            fprintf(out,
                    " <small>RUN %lld: lead time about %s, so the warning may have been late or in "
                    "time</small>",
                    (long long)row->run, outcome_record_format_lead_time(row, false, lead));
    }
    if (report->landings && count[WARNING_OUTCOME_UNKNOWN] == report->landings && report->run)
        write_missing_value(out, "", report->facts[0].outcome_reason);
    else if (report->landings && count[WARNING_OUTCOME_UNKNOWN] == report->landings)
        write_missing_value(out, "",
                            "survey the mat between landings; matrig landing DB RUN --observe");
    if (!any)
        fputs("no landing", out);
    end_item(out);
}

/* ---- problems ---- */

static void write_problems_item(const struct report *report, bool *of, FILE *out)
{
    unsigned all = 0;
    for (size_t i = 0; i < report->landings; i++)
        all |= report->facts[i].problems;
    fprintf(out, "<div class=\"wide%s\"><dt>what went wrong</dt><dd>", all ? " wrong" : "");
    for (unsigned w = 0; w < REPORT_PROBLEM_COUNT; w++) {
        if (!(all & 1u << w))
            continue;
        for (size_t i = 0; i < report->landings; i++)
            of[i] = report->facts[i].problems & 1u << w;
        fprintf(out, "<span>%s", report_problem_text(w));
        if (!report->run) {
            fputs(": ", out);
            report_write_runs(report, of, out);
        }
        fputs("</span>", out);
    }
    if (!all)
        fputs(report->landings ? "nothing recorded" : "no landing", out);
    end_item(out);
}

/* ---- the whole front ---- */

#define ITEM_OFFSET(member) offsetof(struct report_facts, member)

/* Writes the main numbers: speed, deceleration, stop, movement and zone. */
static void write_main_numbers(const struct report *report, bool *of, FILE *out)
{
    static const struct number_item numbers[] = {
        {"touchdown speed", ITEM_OFFSET(speed_ft_s), UNIT_SPEED, 3, "not known",
         "too few switches"},
        {"mean deceleration", ITEM_OFFSET(deceleration_ft_s2), UNIT_DECELERATION, 3, "not known",
         "too few switches"},
        {"stop", ITEM_OFFSET(stop_ft), UNIT_STATION, 3, "not known", "too few switches"},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        write_number_item(report, &numbers[i], out);
    write_movement_item(report, out);
    write_zones_item(report, of, out);
}

static void write_outcome_sentence(const struct report_facts *facts, FILE *out)
{
    char outcome[OUTCOME_TEXT_SIZE], evidence[OUTCOME_TEXT_SIZE], advice[OUTCOME_ADVICE_SIZE];
    fputs("<p class=\"outcome\"><strong>Outcome: ", out);
    html_write_text(out, outcome_record_format_outcome(&facts->warning_record, outcome));
    fputs(".</strong> ", out);
    outcome_record_format_evidence(&facts->warning_record, evidence);
    evidence[0] = (char)toupper((unsigned char)evidence[0]);
    html_write_text(out, evidence);
    fputc('.', out);
    if (facts->warning_record.has_advice)
        fprintf(out, " Advice before it: %s.",
                outcome_record_format_advice(&facts->warning_record, advice));
    fputs("</p>\n", out);
}

/* Writes a banner if landings are from emulated boards, which shows that the page is not about a
 * test. */
static void write_emulated_banner(const struct report *report, FILE *out)
{
    bool *of = xcalloc(report->landings + 1, sizeof *of);
    size_t count = count_emulated(report, of);
    if (count) {
        fputs("<p class=\"emulated\"><strong>Emulated board, synthetic data.</strong> No hardware "
              "and no mat was involved",
              out);
        if (count < report->landings) {
            fputs(" in ", out);
            report_write_runs(report, of, out);
        }
        fputs(".</p>\n", out);
    }
    free(of);
}

/* Writes the outcome and the main numbers of one landing. The front page shows them for all
 * landings. */
static void write_landing_summary(const struct report *report, struct report_facts *facts,
                                  FILE *out)
{
    bool of[1];
    struct report one = *report;
    one.facts = facts;
    one.landings = 1;
    one.run = facts->landing.id;
    write_outcome_sentence(facts, out);
    if (report->run) /* not here: the front page has these numbers */
        return;
    fputs("<dl class=\"first\">\n", out);
    write_main_numbers(&one, of, out);
    fputs("</dl>\n", out);
}

static void write_sensors_item(const struct report *report, FILE *out)
{
    const struct report_facts *facts = &report->facts[report->landings ? report->landings - 1 : 0];
    begin_item(out, "sensor serial numbers");
    if (report->landings && facts->serial_number_count)
        fprintf(out, "%zu of %zu: <a href=\"#provenance\">Provenance</a>",
                facts->serial_number_count, facts->sensor_count);
    else
        write_missing_value(out, "not entered", "serial of each channel in the configuration");
    end_item(out);
}

static void write_item_list(const struct report *report, bool *of, FILE *out)
{
    bool read = false;
    for (size_t i = 0; i < report->landings; i++)
        read |= report->facts[i].has_config;
    const struct text_item texts[] = {
        {"place", ITEM_OFFSET(site),
         read ? "site.name of the configuration" : "site.name; the configuration was not read"},
        {"runway", ITEM_OFFSET(series.runway), "matrig landing DB --series NAME --runway"},
        {"series", ITEM_OFFSET(series.name), "matrig landing DB --series NAME"},
        {"pattern", ITEM_OFFSET(series.pattern), "matrig landing DB --series NAME --pattern"},
        {"modification", ITEM_OFFSET(series.modification),
         "matrig landing DB --series NAME --modification"},
        {"operator", ITEM_OFFSET(series.who), "matrig landing DB --series NAME --who"},
    };
    static const struct number_item weight = {
        "gear weight", ITEM_OFFSET(weight_lb),
        UNIT_TENSION,  1,
        "not entered", "matrig landing DB RUN --correct weight_lb=POUNDS --reason TEXT"};
    fputs("<dl class=\"first\">\n", out);
    write_date_item(report, out);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (i == 3)
            write_landings_item(report, out);
        write_text_item(report, &texts[i], out);
    }
    write_number_item(report, &weight, out);
    write_main_numbers(report, of, out);
    write_outcome_counts_item(report, out);
    write_problems_item(report, of, out);
    write_sensors_item(report, out);
    fputs("</dl>\n", out);
}

static void write_front_page_content(const struct report *report, FILE *out)
{
    bool *of = xcalloc(report->landings + 1, sizeof *of);
    fputs("<header class=\"cover\"><h1>", out);
    if (report->run)
        fprintf(out, "Landing report: RUN %lld", (long long)report->run);
    else
        fputs("Campaign report", out);
    fputs("</h1>\n<p>", out);
    html_write_text(out, report_database_name(report));
    fputs(", on the model landing-mat runway</p>\n", out);
    write_emulated_banner(report, out);
    write_item_list(report, of, out);
    fputs("</header>\n", out);
    free(of);
}

/* ---- provenance: tool, database, boards, configurations, calibrations, links, records ---- */

/* Returns the time of SOURCE_DATE_EPOCH if it is set, so that the same page can be generated
 * again. */
static int64_t get_time_us(void)
{
    const char *fixed = getenv("SOURCE_DATE_EPOCH");
    return 1000000 * (fixed ? strtoll(fixed, NULL, 10) : (int64_t)time(NULL));
}

static void add_general_facts(const struct report *report, struct answer *answer)
{
    char when[40];
    struct stat file;
    char hash[SHA256_DIGEST_STRING_LENGTH], log[PATH_MAX];
    survey_format_time(get_time_us(), when, sizeof when);
    answer_add_text(answer, NULL, "made by", "matrig " VERSION_TEXT);
    answer_add_text(answer, NULL, "made", "%s", when);
    answer_add_text(answer, NULL, "database", "%s, version %d", report_database_name(report),
                    STORE_VERSION);
    if (stat(report->path, &file) == 0)
        answer_add_text(answer, NULL, "size", "%lld bytes", (long long)file.st_size);
    /* the newest data is in the journal, not in the file */
    snprintf(log, sizeof log, "%s-wal", report->path);
    if (stat(log, &file) == 0 && file.st_size)
        return;
    if (SHA256File(report->path, hash))
        answer_add_text(answer, NULL, "SHA-256", "%s", hash);
    else
        error_set(report->error, MR_IO, "cannot read (%s): %s; check the path and the disk",
                  strerror(errno), report->path);
}

static void add_landing_row(const struct report_facts *facts, struct answer *answer)
{
    const struct store_landing *row = &facts->landing;
    char when[40];
    survey_format_time(row->armed_us, when, sizeof when);
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", row->id);
    answer_add_text(answer, NULL, "armed", "%s", when);
    answer_add_text(answer, NULL, "board", "%s", row->board_uid[0] ? row->board_uid : "unknown");
    answer_add_text(answer, NULL, "firmware, CRC-32 of its image, commit", "%s, %08llx, %s",
                    row->firmware[0] ? row->firmware : "unknown",
                    row->image_crc == STORE_NONE ? 0ull : (unsigned long long)row->image_crc,
                    row->image_commit[0] ? row->image_commit : "unknown");
    if (row->config_crc == STORE_NONE)
        answer_add_text(answer, NULL, "configuration, CRC-32", "unknown");
    else
        answer_add_text(answer, NULL, "configuration, CRC-32", "%08llx%s",
                        (unsigned long long)row->config_crc, facts->has_config ? "" : ", not read");
    answer_add_text(answer, NULL, "links", "CAN %s; serial %s",
                    facts->can_link[0] ? facts->can_link : "not used",
                    facts->serial_link[0] ? facts->serial_link : "not used");
    answer_add_text(answer, NULL, "orders", "%s",
                    facts->command_rights ? facts->command_rights : "not known");
    answer_add_text(answer, NULL, "survey", "%zu of %u segments", facts->surveyed_segment_count,
                    MR_SEGMENTS);
}

static void format_day_number(uint32_t day, char out[20])
{
    format_day((int64_t)day * SECONDS_PER_DAY * 1000000, out);
}

/* Adds the sensor and the dates of a channel, from the configuration that was read from the
 * board. */
static void add_sensor_facts(const struct mr_channel_config *read, int64_t used_day,
                             struct answer *answer)
{
    char day[20];
    answer_add_text(answer, NULL, "sensor", "%.*s", (int)sizeof read->serial,
                    read->serial[0] ? read->serial : "not entered");
    format_day_number(read->calibrated_day, day);
    answer_add_text(answer, NULL, "calibrated", "%s", read->calibrated_day ? day : "UNCALIBRATED")
        ->is_warning = !read->calibrated_day;
    bool expired = read->expires_day && (int64_t)read->expires_day <= used_day;
    format_day_number(read->expires_day, day);
    answer_add_text(answer, NULL, "expires", "%s%s", read->expires_day ? day : "not stated",
                    expired ? ", before the landing" : "")
        ->is_warning = expired;
}

/* Adds the calibration with which the landing's readings are computed. */
static void add_calibrations(const struct report_landing *landing, struct answer *answer)
{
    const struct measured_landing *measured = &landing->summary.measured;
    answer_open_table(answer, NULL, "");
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        const struct mr_channel_config *channel = &measured->channel[i].config;
        if (!mr_channel_is_sensor(channel))
            continue;
        answer_open_row(answer);
        answer_add_text(answer, NULL, "channel", "%s %u",
                        channel->kind == MR_KIND_DISPLACEMENT ? "transducer" : "gage",
                        channel->number);
        if (landing->config)
            add_sensor_facts(&landing->config->channel[i],
                             measured->landing.armed_us / 1000000 / SECONDS_PER_DAY, answer);
        answer_add_text(answer, NULL, "scale (in or lb per code)", "%.9g",
                        (double)channel->unit_per_code);
        answer_add_value(answer, NULL, "gain error (%)", UNIT_NUMBER,
                         100.0 * (double)channel->gain_error, 3);
        answer_add_value(answer, NULL, "zero error (in or lb)", UNIT_NUMBER,
                         (double)channel->zero_error, 4);
    }
    answer_close_group(answer);
}

void report_add_calibration(const struct report_landing *landing, struct answer *answer)
{
    char heading[60];
    snprintf(heading, sizeof heading, "Calibration from RUN %lld on",
             (long long)landing->summary.measured.landing.id);
    answer_open_group(answer, NULL, heading);
    if (landing->config) {
        const struct mr_site_config *site = &landing->config->site[0];
        answer_add_sentence(answer, NULL, "Configuration %.*s, revision %u.",
                            (int)sizeof site->name, site->name, site->revision);
    } else
        answer_add_sentence(answer, NULL,
                            "The configuration of the board was not read (matrig log reads the "
                            "configuration over a two-way link).");
    add_calibrations(landing, answer);
    answer_close_group(answer);
}

static void write_provenance(const struct report *report, FILE *out)
{
    struct answer *answer = answer_new(report->si);
    fputs("<section id=\"provenance\"><h2>Provenance</h2>\n", out);
    add_general_facts(report, answer);
    answer_open_table(answer, NULL, "Landings");
    for (size_t i = 0; i < report->landings; i++)
        add_landing_row(&report->facts[i], answer);
    answer_close_group(answer);
    report_write_answer(answer, out);
    answer_print_html(report->calibrations, out);
    answer = answer_new(report->si);
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].recalibrated_channels)
            answer_add_sentence(answer, NULL,
                                "RUN %lld uses a corrected calibration; the calibration used for "
                                "recording is kept in the campaign.",
                                (long long)report->facts[i].landing.id);
    }
    report_write_answer(answer, out);
    fputs("</section>\n", out);
}

/* ---- a report ---- */

/* Closes a memory stream and returns its text; NULL: the text is empty. The caller frees it. */
static char *close_memory_stream(FILE *into, char **text, const size_t *size)
{
    fclose(into);
    if (*size)
        return *text;
    free(*text);
    return NULL;
}

static void write_landing(const struct report *report, struct report_facts *facts,
                          const struct report_landing *landing, FILE *out)
{
    char heading[SUMMARY_HEADING_SIZE];
    summary_format_heading(&landing->summary, heading);
    fprintf(out, "<section id=\"run%lld\" class=\"landing\"><h2>%s</h2>\n",
            (long long)landing->summary.measured.landing.id, heading);
    write_landing_summary(report, facts, out);
    for (const struct report_landing_section *part = report_landing_sections; part->write; part++) {
        char *text = NULL;
        size_t size = 0;
        FILE *into = xopen_memstream(&text, &size);
        part->write(report, landing, into);
        text = close_memory_stream(into, &text, &size);
        if (text)
            fprintf(out, "<h3>%s</h3>\n", part->title);
        fputs(text ? text : "", out);
        free(text);
    }
    fputs("</section>\n", out);
}

/* Writes all landings. Each one is freed before the next is loaded. */
static void write_landings(struct report *report, FILE *out)
{
    struct report_landing *landing = xmalloc(sizeof *landing);
    for (size_t i = 0; i < report->landings && report->error->status == MR_OK; i++) {
        if (report_landing_load(report, i, landing, report->error) == MR_OK)
            write_landing(report, &report->facts[i], landing, out);
        report_landing_free(landing);
    }
    free(landing);
}

/* Writes the sections of the campaign, and their entries in the table of contents. */
static void write_sections(const struct report *report, FILE *contents, FILE *body)
{
    for (const struct report_section *s = report_sections; s->write; s++) {
        char *text = NULL;
        size_t size = 0;
        if (report->landings < s->min_landings)
            continue;
        FILE *into = xopen_memstream(&text, &size);
        s->write(report, into);
        text = close_memory_stream(into, &text, &size);
        if (text) {
            fprintf(contents, "<li><a href=\"#%s\">%s</a></li>\n", s->id, s->title);
            fprintf(body, "<section id=\"%s\"><h2>%s</h2>\n%s</section>\n", s->id, s->title, text);
        }
        free(text);
    }
    for (size_t i = 0; i < report->landings; i++) {
        enum warning_outcome verdict = report->facts[i].warning_record.warning_outcome;
        fprintf(contents, "<li><a href=\"#run%lld\">RUN %lld: landing %lld%s%s</a></li>\n",
                (long long)report->row[i].id, (long long)report->row[i].id,
                (long long)report->row[i].board_landing,
                verdict == WARNING_OUTCOME_UNKNOWN ? "" : ", ",
                verdict == WARNING_OUTCOME_UNKNOWN ? "" : warning_outcome_text(verdict));
    }
}

/* Writes the front page, the part of <main> before the landings. The caller frees the text. */
static void write_front_page(const struct report *report, char **text, size_t *length)
{
    char *contents = NULL, *body = NULL;
    size_t contents_size = 0, body_size = 0;
    FILE *out = xopen_memstream(text, length), *list = xopen_memstream(&contents, &contents_size),
         *sections = xopen_memstream(&body, &body_size);
    fputs("<main>", out);
    write_front_page_content(report, out);
    write_sections(report, list, sections);
    fclose(list);
    fclose(sections);
    fprintf(out,
            "<noscript><style>.plots{min-height:0!important}</style><p class=\"say\">The plots "
            "need JavaScript; the tables do not."
            "</p></noscript>\n<nav aria-label=\"contents\"><ul>\n%s<li><a "
            "href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n%s",
            contents, body);
    fclose(out);
    free(contents);
    free(body);
}

enum mr_status report_write_page(struct report *report, FILE *out, struct error *error)
{
    char *front = NULL;
    size_t length = 0;
    /* written first into a file, because the front page, which precedes them, needs their facts */
    FILE *landings = output_open_temporary("the report", error);
    if (!landings)
        return error->status;
    report->error = error;
    report->calibrations = answer_new(report->si);
    write_landings(report, landings);
    if (error->status == MR_OK && !report->run)
        outcome_record_end(report->store, &report->record, error);
    if (error->status == MR_OK)
        write_front_page(report, &front, &length);
    if (error->status == MR_OK) {
        write_page_head(out, report);
        fwrite(front, 1, length, out);
        output_copy_temporary(landings, out);
        fprintf(out,
                "<p>Plots are thinned: each pixel column shows the smallest and the largest "
                "reading. &plusmn; is one standard error (coverage factor k = 1); 95 %% intervals "
                "have k = %.2f. Units: %s.</p>\n</main>",
                SUMMARY_HALF_WIDTH_95,
                report->si ? "SI (without --si: feet, inches and pounds)"
                           : "feet, inches and pounds; matrig --si report writes the page in SI");
        write_provenance(report, out);
        write_page_foot(out);
    }
    answer_free(report->calibrations);
    report->calibrations = NULL;
    fclose(landings);
    free(front);
    return error->status;
}
