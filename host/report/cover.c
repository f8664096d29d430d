/* The head of the page: what a reader looks for first. What is not known says so, with the command
 * that enters it; nothing stands in its place. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/base/html.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"
#include "host/report/report.h"

#define NAMED_MOST 3u              /* texts of a fact, and */
#define RUNS_MOST  6u              /* RUNs that a line names, before "and 12 more" */
#define DATED_US   946684800000000 /* 2000-01-01: a time before it is none of day */

/* ---- a fact ---- */

static void begin_fact(FILE *out, const char *term)
{
    fprintf(out, "<div><dt>%s</dt><dd>", term);
}

static void end_fact(FILE *out)
{
    fputs("</dd></div>\n", out);
}

/* "not entered", and the command that enters it. */
static void missing(FILE *out, const char *word, const char *how)
{
    fprintf(out, "%s <small>", word);
    html_text(out, how);
    fputs("</small>", out);
}

/* Texts of the landings, each once, in their order. */
struct text_row {
    const char *term;
    size_t offset; /* of a string in struct report_facts */
    const char *how;
};

static void text_fact(const struct report *report, const struct text_row *row, FILE *out)
{
    const char *named[NAMED_MOST];
    size_t count = 0, others = 0;
    begin_fact(out, row->term);
    for (size_t i = 0; i < report->landings; i++) {
        const char *value = (const char *)&report->facts[i] + row->offset;
        bool known = !value[0];
        for (size_t k = 0; k < count && !known; k++)
            known = strcmp(named[k], value) == 0;
        if (known)
            continue;
        if (count < NAMED_MOST)
            named[count++] = value;
        else
            others = 1;
    }
    for (size_t k = 0; k < count; k++) {
        fputs(k ? "; " : "", out);
        html_text(out, named[k]);
    }
    fputs(others ? "; and others" : "", out);
    if (count == 0)
        missing(out, "not entered", row->how);
    end_fact(out);
}

/* ---- when ---- */

static void day_text(int64_t us, char out[20])
{
    time_t second = (time_t)(us / 1000000);
    struct tm utc;
    out[0] = '\0';
    if (gmtime_r(&second, &utc))
        strftime(out, 20, "%Y-%m-%d", &utc);
}

static void date_fact(const struct report *report, FILE *out)
{
    int64_t first_us = INT64_MAX, last_us = INT64_MIN;
    char first[20], last[20];
    begin_fact(out, "date (UTC)");
    for (size_t i = 0; i < report->landings; i++) {
        int64_t us = report->facts[i].landing.armed_us;
        if (us < DATED_US)
            continue;
        first_us = us < first_us ? us : first_us;
        last_us = us > last_us ? us : last_us;
    }
    if (last_us >= DATED_US) {
        day_text(first_us, first);
        day_text(last_us, last);
        html_text(out, first);
        if (strcmp(first, last) != 0) {
            fputs(" to ", out);
            html_text(out, last);
        }
    } else if (report->landings) {
        missing(out, "not known", "read from a recording that has no times of day");
    } else {
        fputs("no landing", out);
    }
    end_fact(out);
}

/* ---- how many, and which ---- */

static void runs_text(const struct report *report, const bool *of, FILE *out)
{
    size_t named = 0, count = 0;
    for (size_t i = 0; i < report->landings; i++) {
        if (!of[i] || ++count > RUNS_MOST)
            continue;
        fprintf(out, "%s<a href=\"#run%lld\">%lld</a>", named++ ? ", " : "RUN ",
                (long long)report->facts[i].landing.id, (long long)report->facts[i].landing.id);
    }
    if (count > RUNS_MOST)
        fprintf(out, " and %zu more", count - RUNS_MOST);
}

static void landings_fact(const struct report *report, FILE *out)
{
    begin_fact(out, "landings");
    fprintf(out, "%zu", report->landings);
    if (report->landings) {
        int64_t first = report->facts[0].landing.id,
                last = report->facts[report->landings - 1].landing.id;
        fprintf(out, first == last ? ": RUN %lld" : ": RUN %lld to %lld", (long long)first,
                (long long)last);
    }
    if (report->voided)
        fprintf(out, "; %zu that %s void left out", report->voided,
                report->voided == 1 ? "is" : "are");
    end_fact(out);
}

/* ---- numbers ---- */

/* "28.00 to 35.49 ft/s", of one landing with its error; and of how many it is not known. */
struct number_row {
    const char *term;
    size_t offset; /* of a struct mr_estimate in struct report_facts */
    enum unit_kind kind;
    int decimals;
    const char *unknown, *how;
};

static void number_fact(const struct report *report, const struct number_row *row, FILE *out)
{
    const struct unit *unit = unit_of(row->kind, report->si);
    const int d = row->decimals;
    double low = (double)INFINITY, high = -(double)INFINITY, error = (double)NAN;
    size_t known = 0;
    begin_fact(out, row->term);
    for (size_t i = 0; i < report->landings; i++) {
        struct mr_estimate value;
        memcpy(&value, (const char *)&report->facts[i] + row->offset, sizeof value);
        if (!isfinite(value.value))
            continue;
        known++;
        error = unit->factor * value.error;
        low = fmin(low, unit->factor * value.value);
        high = fmax(high, unit->factor * value.value);
    }
    if (known == 0)
        missing(out, row->unknown, row->how);
    else if (known == 1 && isfinite(error))
        fprintf(out, "%.*f &plusmn; %.*f %s", d, low, d, error, unit->text);
    else if (high - low < 0.5 * pow(10.0, -d))
        fprintf(out, "%.*f %s", d, low, unit->text);
    else
        fprintf(out, "%.*f to %.*f %s", d, low, d, high, unit->text);
    if (known && known < report->landings)
        fprintf(out, " <small>not known of %zu</small>", report->landings - known);
    end_fact(out);
}

static void movement_fact(const struct report *report, FILE *out)
{
    const struct report_moved *largest = NULL;
    int64_t run = 0;
    char text[UNIT_TEXT];
    begin_fact(out, "largest movement");
    for (size_t i = 0; i < report->landings; i++) {
        for (unsigned k = 0; k < MR_TRANSDUCERS; k++) {
            const struct report_moved *moved = &report->facts[i].moved[k];
            if (isnan(moved->peak) || (largest && fabs(moved->peak) <= fabs(largest->peak)))
                continue;
            largest = moved;
            run = report->facts[i].landing.id;
        }
    }
    if (largest) {
        fputs(unit_value_text(UNIT_DISPLACEMENT, report->si, largest->peak, 3, text), out);
        fprintf(out, " at %s",
                unit_value_text(UNIT_STATION, report->si, largest->station_ft, 0, text));
        if (!report->run)
            fprintf(out, ", RUN %lld", (long long)run);
    } else {
        fputs("not known: no transducer has a peak", out);
    }
    end_fact(out);
}

/* ---- zones and verdicts ---- */

static void zones_fact(const struct report *report, bool *of, FILE *out)
{
    const struct report_facts *longest = NULL;
    const double station = unit_of(UNIT_STATION, report->si)->factor;
    size_t warned = 0, unheard = 0, watched = 0;
    begin_fact(out, "zones warned of");
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        of[i] = facts->warning.warned;
        warned += of[i];
        watched += facts->source != MEASURED_IMPORT;
        unheard += !of[i] && facts->source != MEASURED_IMPORT && facts->unheard;
        if (of[i] && (!longest || facts->warning.most_mats > longest->warning.most_mats))
            longest = facts;
    }
    if (watched == 0)
        fputs("no board watched", out);
    else if (warned == 0)
        fputs("none", out);
    else if (!report->run) {
        fprintf(out, "in %zu of %zu landings: ", warned, report->landings);
        runs_text(report, of, out);
    }
    if (longest)
        fprintf(out, "%s%lld mats, %.1f to %.1f %s", report->run ? "" : "; longest ",
                (long long)longest->warning.most_mats, station * longest->warning.most_start_ft,
                station * longest->warning.most_end_ft, unit_of(UNIT_STATION, report->si)->text);
    if (unheard)
        fprintf(out, " <small>in %zu more a warning may have been missed by the log</small>",
                unheard);
    end_fact(out);
}

static void verdicts_fact(const struct report *report, FILE *out)
{
    static const enum record_verdict order[] = {RECORD_HIT,   RECORD_LATE,    RECORD_MISS,
                                                RECORD_FALSE, RECORD_SILENCE, RECORD_NOT_KNOWN};
    size_t count[RECORD_VERDICTS] = {0};
    bool any = false;
    begin_fact(out, "warnings by outcome");
    for (size_t i = 0; i < report->landings; i++) {
        enum record_verdict verdict = report->facts[i].record.verdict;
        count[verdict < RECORD_VERDICTS ? verdict : RECORD_NOT_KNOWN]++;
    }
    for (size_t k = 0; k < sizeof order / sizeof order[0]; k++) {
        if (count[order[k]] == 0)
            continue;
        fputs(any ? "; " : "", out);
        if (!report->run)
            fprintf(out, "%zu ", count[order[k]]);
        fputs(record_verdict_text(order[k]), out);
        any = true;
    }
    if (report->landings && count[RECORD_NOT_KNOWN] == report->landings && report->run)
        missing(out, "", report->facts[0].why);
    else if (report->landings && count[RECORD_NOT_KNOWN] == report->landings)
        missing(out, "", "survey the mat between landings; matrig landing DB RUN --observe");
    if (!any)
        fputs("no landing", out);
    end_fact(out);
}

/* ---- what went wrong ---- */

static void wrong_fact(const struct report *report, bool *of, FILE *out)
{
    unsigned all = 0;
    for (size_t i = 0; i < report->landings; i++)
        all |= report->facts[i].wrong;
    fprintf(out, "<div class=\"wide%s\"><dt>what went wrong</dt><dd>", all ? " wrong" : "");
    for (unsigned w = 0; w < REPORT_WRONGS; w++) {
        if (!(all & 1u << w))
            continue;
        for (size_t i = 0; i < report->landings; i++)
            of[i] = report->facts[i].wrong & 1u << w;
        fprintf(out, "<span>%s", report_wrong_text(w));
        if (!report->run) {
            fputs(": ", out);
            runs_text(report, of, out);
        }
        fputs("</span>", out);
    }
    if (!all)
        fputs(report->landings ? "nothing that was recorded" : "no landing", out);
    end_fact(out);
}

/* ---- all of it ---- */

#define AT(member) offsetof(struct report_facts, member)

static void facts(const struct report *report, bool *of, FILE *out)
{
    bool read = false;
    for (size_t i = 0; i < report->landings; i++)
        read |= report->facts[i].config_read;
    const struct text_row texts[] = {
        {"place", AT(site),
         read ? "site.name of the configuration" : "the configuration was not read; its site.name"},
        {"runway", AT(series.runway), "matrig series DB NAME --runway"},
        {"series", AT(series.name), "matrig series DB NAME"},
        {"pattern", AT(series.pattern), "matrig series DB NAME --pattern"},
        {"modification", AT(series.modification), "matrig series DB NAME --modification"},
        {"operator", AT(series.who), "matrig series DB NAME --who"},
    };
    static const struct number_row numbers[] = {
        {"gear weight", AT(weight_lb), UNIT_TENSION, 1, "not entered",
         "matrig landing DB RUN --correct weight_lb=POUNDS"},
        {"touchdown speed", AT(speed_ft_s), UNIT_SPEED, 3, "not known", "too few switches"},
        {"mean deceleration", AT(deceleration_ft_s2), UNIT_DECELERATION, 3, "not known",
         "too few switches"},
        {"stop", AT(stop_ft), UNIT_STATION, 1, "not known", "too few switches"},
    };
    fputs("<dl class=\"first\">\n", out);
    date_fact(report, out);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (i == 3)
            landings_fact(report, out);
        text_fact(report, &texts[i], out);
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        number_fact(report, &numbers[i], out);
    movement_fact(report, out);
    zones_fact(report, of, out);
    verdicts_fact(report, out);
    wrong_fact(report, of, out);
    fputs("</dl>\n", out);
}

void cover_write(const struct report *report, FILE *out)
{
    const char *slash = strrchr(report->path, '/');
    bool *of = xcalloc(report->landings + 1, sizeof *of);
    fputs("<header class=\"cover\"><h1>", out);
    if (report->run)
        fprintf(out, "Landing report: RUN %lld", (long long)report->run);
    else
        fputs("Campaign report", out);
    fputs("</h1>\n<p>", out);
    html_text(out, slash ? slash + 1 : report->path);
    fputs(", on the model landing-mat runway</p>\n", out);
    facts(report, of, out);
    fputs("</header>\n", out);
    free(of);
}
