/* What people said of the landings: series, notes, corrections, voided landings, waves and breaks. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/store/store_journal.h"
#include "host/store/store_recalibrate.h"
#include "host/survey/show.h"
#include "host/base/units.h"

/* Tables of the section, each opened with its first row. */
struct tables {
    FILE *out;
    bool si, open;
};

static void open_table(struct tables *t, const char *title, const char *const *heads)
{
    if (!t->open) {
        fprintf(t->out, "<h3>%s</h3>\n", title);
        html_table(t->out, heads);
    }
    t->open = true;
}

static void close_table(struct tables *t)
{
    if (t->open)
        fputs("</tbody></table></div>\n", t->out);
    t->open = false;
}

static enum mr_status series_rows(struct store *store, const struct store_landing *landings, size_t count, struct tables *t,
                                  struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        struct store_series series;
        char reason[STORE_JOURNAL_TEXT];
        bool is_void, recalibrated = false;
        status = store_series_of(store, &landings[i], &series, error);
        if (status == MR_OK)
            status = store_is_void(store, landings[i].id, &is_void, reason, error);
        if (status == MR_OK)
            status = store_is_recalibrated(store, landings[i].id, &recalibrated, error);
        if (status != MR_OK || (!series.name[0] && !series.pattern[0] && !series.runway[0] && !series.modification[0] && !is_void && !recalibrated))
            continue;
        open_table(t, "Series and validity", (const char *const[]){"RUN", "landing", "series", "runway", "pattern", "modification", "counts", NULL});
        fputs("<tr>", t->out);
        html_cell(t->out, "%lld", (long long)landings[i].id);
        html_cell(t->out, "%lld", (long long)landings[i].board_landing);
        html_cell(t->out, "%s", series.name);
        html_cell(t->out, "%s", series.runway);
        html_cell(t->out, "%s", series.pattern);
        html_cell(t->out, "%s", series.modification);
        if (is_void) {
            fputs("<td class=\"warn\">void: ", t->out);
            html_text(t->out, reason);
            fputs("</td>", t->out);
        } else {
            html_cell(t->out, "%s", recalibrated ? "yes; with a corrected calibration" : "yes");
        }
        fputs("</tr>\n", t->out);
    }
    close_table(t);
    return status;
}

static void optional(FILE *out, double value, int decimals)
{
    if (isnan(value))
        html_cell(out, "-");
    else
        html_number(out, value, decimals);
}

static enum mr_status observation_rows(struct store *store, int64_t run, struct tables *t, struct error *error)
{
    const struct unit *station = unit_of(UNIT_STATION, t->si), *length = unit_of(UNIT_DISPLACEMENT, t->si);
    struct store_observation *rows = NULL;
    size_t count = 0;
    char at[40], high[40];
    snprintf(at, sizeof at, "station, %s", station->text);
    snprintf(high, sizeof high, "height, %s", length->text);
    enum mr_status status = store_observations(store, run, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        const struct store_observation *o = &rows[i];
        if (o->withdrawn)
            continue;
        open_table(t, "Waves and breaks", (const char *const[]){"RUN", "seen", at, "panels", high, "side", "form", "after touchdown, s", "by", "note", NULL});
        fputs("<tr>", t->out);
        html_cell(t->out, "%lld", (long long)run);
        html_cell(t->out, "%s", o->kind);
        optional(t->out, o->station_ft * station->factor, 1);
        optional(t->out, o->panels == STORE_NONE ? (double)NAN : (double)o->panels, 0);
        optional(t->out, o->height_in * length->factor, 2);
        html_cell(t->out, "%s", o->side);
        html_cell(t->out, "%s", o->form);
        optional(t->out, o->time_s, 2);
        html_cell(t->out, "%s", o->who);
        html_cell(t->out, "%s", o->note);
        fputs("</tr>\n", t->out);
    }
    free(rows);
    return status;
}

static enum mr_status change_rows(struct store *store, int64_t run, struct tables *t, struct error *error)
{
    struct store_change *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_changes(store, run, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        const struct store_change *c = &rows[i];
        char when[40];
        open_table(t, "Notes and corrections", (const char *const[]){"RUN", "when", "by", "what", "was", "is", "why", NULL});
        survey_time_text(c->made_us, when, sizeof when);
        fputs("<tr>", t->out);
        html_cell(t->out, "%lld", (long long)run);
        html_cell(t->out, "%s", when);
        html_cell(t->out, "%s", c->who);
        html_cell(t->out, "%s", c->field);
        html_cell(t->out, "%s", c->was);
        html_cell(t->out, "%s", c->value);
        html_cell(t->out, "%s", c->reason);
        fputs("</tr>\n", t->out);
    }
    free(rows);
    return status;
}

/* Leaves one landing, where the page is of one; how many there are then. */
static size_t only(struct store_landing *landings, size_t count, int64_t run)
{
    for (size_t i = 0; i < count && run; i++) {
        if (landings[i].id == run) {
            landings[0] = landings[i];
            return 1;
        }
    }
    return run ? 0 : count;
}

enum mr_status campaign_journal(const struct report *report, FILE *out, struct error *error)
{
    struct store *store = report->store;
    struct store_landing *landings = NULL;
    size_t count = 0;
    struct tables t = {out, report->si, false};
    enum mr_status status = store_landings(store, &landings, &count, error);
    count = only(landings, count, report->run);
    if (status == MR_OK)
        status = series_rows(store, landings, count, &t, error);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = observation_rows(store, landings[i].id, &t, error);
    close_table(&t);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = change_rows(store, landings[i].id, &t, error);
    close_table(&t);
    free(landings);
    return status;
}
