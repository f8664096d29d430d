/* matrig landing: what people say of a landing, with its history; matrig series: what the landings belong to. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/cli.h"
#include "host/collect/collect.h"
#include "host/link/link.h"
#include "host/run.h"
#include "host/store/store_journal.h"
#include "host/survey/show.h"
#include "host/units.h"

/* What can be corrected: texts, or numbers within limits. */
static const struct field {
    const char *name;
    bool number;
    double low, high;
} fields[] = {
    {"touchdown_ft", true, 0.0, 120.0}, {"weight_lb", true, 1.0, 1e5}, {"pattern", false, 0, 0},
    {"modification", false, 0, 0},      {"runway", false, 0, 0},       {"series", false, 0, 0},
};
#define FIELDS (sizeof fields / sizeof fields[0])

struct request {
    const struct cli *cli;
    const char *words[2];
    int64_t run; /* 0: all */
    const char *who, *note, *correct, *reason, *observe, *station, *panels, *height, *side, *at, *form, *withdraw;
    bool make_void, unvoid;
};

static const char *author(const char *who)
{
    return who ? who : getenv("USER") ? getenv("USER") : "";
}

static void fill(char *into, size_t size, const char *text)
{
    snprintf(into, size, "%.*s", (int)size - 1, text ? text : "");
}

/* ---- adding ---- */

static enum mr_status change(const struct request *r, struct store *store, const char *field, const char *value, struct error *error)
{
    struct store_change row = {.run = r->run, .made_us = (int64_t)link_now_us()};
    if (strlen(value) >= sizeof row.value || (r->reason && strlen(r->reason) >= sizeof row.reason))
        return error_set(error, MR_TOO_LONG, "text too long: %s of RUN %lld; %d characters at most", field, (long long)r->run,
                         STORE_JOURNAL_TEXT - 1);
    fill(row.who, sizeof row.who, author(r->who));
    fill(row.field, sizeof row.field, field);
    fill(row.value, sizeof row.value, value);
    fill(row.reason, sizeof row.reason, r->reason);
    return store_change_add(store, &row, error);
}

static enum mr_status correct(const struct request *r, struct store *store, struct error *error)
{
    char name[24];
    double number;
    const char *value = strchr(r->correct, '=');
    size_t length = value ? (size_t)(value - r->correct) : 0;
    const struct field *field = NULL;
    for (size_t i = 0; i < FIELDS; i++) {
        if (strlen(fields[i].name) == length && strncmp(fields[i].name, r->correct, length) == 0)
            field = &fields[i];
    }
    if (!field || !value[1])
        return error_set(error, MR_USAGE,
                         "nothing to correct: '%s'; FIELD=VALUE with touchdown_ft, weight_lb, pattern, modification, runway or series",
                         r->correct);
    snprintf(name, sizeof name, "%s", field->name);
    enum mr_status status = field->number ? cli_number(value + 1, name, field->low, field->high, &number, error) : MR_OK;
    if (status == MR_OK && strcmp(name, "series") == 0) {
        struct store_series *rows;
        size_t count;
        bool there = false;
        status = store_series_all(store, &rows, &count, error);
        for (size_t i = 0; i < count; i++)
            there |= strcmp(rows[i].name, value + 1) == 0;
        free(rows);
        if (status == MR_OK && !there)
            status = error_set(error, MR_UNKNOWN, "no series '%s': %s; matrig series DB lists them", value + 1, r->words[0]);
    }
    return status == MR_OK ? change(r, store, name, value + 1, error) : status;
}

static bool one_of(const char *text, const char *const *words)
{
    for (; *words; words++) {
        if (strcmp(text, *words) == 0)
            return true;
    }
    return false;
}

static enum mr_status observe(const struct request *r, struct store *store, struct error *error)
{
    struct store_observation row = {.run = r->run, .made_us = (int64_t)link_now_us(), .station_ft = (double)NAN, .height_in = (double)NAN,
                                    .time_s = (double)NAN, .panels = STORE_NONE};
    double panels = (double)NAN, to_ft = r->cli->si ? 1.0 / 0.3048 : 1.0, to_in = r->cli->si ? 1.0 / 25.4 : 1.0;
    enum mr_status status = MR_OK;
    if (!one_of(r->observe, (const char *const[]){"wave", "break", "other", NULL}))
        return error_set(error, MR_USAGE, "not seen before: '%s'; --observe wave, break or other", r->observe);
    if (r->side && !one_of(r->side, (const char *const[]){"left", "right", "centre", "across", NULL}))
        return error_set(error, MR_USAGE, "not a side: '%s'; left, right, centre or across", r->side);
    if (r->station)
        status = cli_number(r->station, "--station", 0.0, 120.0 / to_ft, &row.station_ft, error);
    if (status == MR_OK && r->panels)
        status = cli_number(r->panels, "--panels", 1.0, 420.0, &panels, error);
    if (status == MR_OK && r->panels && panels != floor(panels))
        status = error_set(error, MR_USAGE, "not a number of panels: '%s'; write a whole number", r->panels);
    if (status == MR_OK && r->height)
        status = cli_number(r->height, "--height", 0.0, 36.0 / to_in, &row.height_in, error);
    if (status == MR_OK && r->at)
        status = cli_number(r->at, "--at", -60.0, 600.0, &row.time_s, error);
    if (status == MR_OK && !r->station && !r->note)
        status = error_set(error, MR_USAGE, "where was it? --observe needs --station or --note; see matrig landing --help");
    if (status == MR_OK && r->note && strlen(r->note) >= sizeof row.note)
        status = error_set(error, MR_TOO_LONG, "text too long: the note of RUN %lld; %d characters at most", (long long)r->run,
                           STORE_JOURNAL_TEXT - 1);
    if (status != MR_OK)
        return status;
    row.station_ft *= to_ft;
    row.height_in *= to_in;
    row.panels = isnan(panels) ? STORE_NONE : (int64_t)panels;
    fill(row.kind, sizeof row.kind, r->observe);
    fill(row.who, sizeof row.who, author(r->who));
    fill(row.side, sizeof row.side, r->side);
    fill(row.form, sizeof row.form, r->form);
    fill(row.note, sizeof row.note, r->note);
    return store_observation_add(store, &row, error);
}

static enum mr_status add(const struct request *r, struct store *store, struct error *error)
{
    struct store_landing landing;
    int64_t id = 0;
    bool is_void;
    enum mr_status status = store_landing_get(store, r->run, &landing, error);
    if (status == MR_OK && (r->make_void || r->unvoid)) {
        status = store_is_void(store, r->run, &is_void, NULL, error);
        if (status == MR_OK && is_void == r->make_void)
            status = error_set(error, MR_NOT_NOW, "RUN %lld is %s already: %s; nothing changed", (long long)r->run,
                               is_void ? "void" : "not void", r->words[0]);
        return status == MR_OK ? change(r, store, "void", r->make_void ? "yes" : "no", error) : status;
    }
    if (status == MR_OK && r->correct)
        return correct(r, store, error);
    if (status == MR_OK && r->observe)
        return observe(r, store, error);
    if (status == MR_OK && r->withdraw) {
        double number = 0.0;
        status = cli_number(r->withdraw, "--withdraw", 1.0, 1e9, &number, error);
        id = (int64_t)number;
        return status == MR_OK
                   ? store_observation_withdraw(store, r->run, id, (int64_t)link_now_us(), author(r->who), r->reason ? r->reason : "", error)
                   : status;
    }
    return status == MR_OK ? change(r, store, "note", r->note, error) : status;
}

/* ---- showing ---- */

struct journal {
    struct store_landing landing;
    struct store_series series;
    struct store_change *change;
    size_t changes;
    struct store_observation *observation;
    size_t observations;
    bool is_void;
};

static enum mr_status journal_get(struct store *store, int64_t run, struct journal *j, struct error *error)
{
    memset(j, 0, sizeof *j);
    enum mr_status status = store_landing_get(store, run, &j->landing, error);
    if (status == MR_OK)
        status = store_series_of(store, &j->landing, &j->series, error);
    if (status == MR_OK)
        status = store_changes(store, run, &j->change, &j->changes, error);
    if (status == MR_OK)
        status = store_observations(store, run, &j->observation, &j->observations, error);
    return status == MR_OK ? store_is_void(store, run, &j->is_void, NULL, error) : status;
}

static void journal_free(struct journal *j)
{
    free(j->change);
    free(j->observation);
}

static const char *none_if_empty(const char *text)
{
    return text[0] ? text : "-";
}

static void print_observation(const struct store_observation *o, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si), *length = unit_of(UNIT_DISPLACEMENT, si);
    printf("  %-5s %lld ", o->kind, (long long)o->id);
    if (!isnan(o->station_ft))
        printf(" station %.1f %s", o->station_ft * station->factor, station->text);
    if (o->panels != STORE_NONE)
        printf(", %lld panels", (long long)o->panels);
    if (!isnan(o->height_in))
        printf(", %.2f %s high", o->height_in * length->factor, length->text);
    if (o->side[0])
        printf(", %s", o->side);
    if (o->form[0])
        printf(", %s", o->form);
    if (!isnan(o->time_s))
        printf(", %.2f s after touchdown", o->time_s);
    if (o->note[0])
        printf(": %s", o->note);
    puts(o->withdrawn ? " (withdrawn)" : "");
}

static void print_journal(const struct journal *j, bool si)
{
    char when[40];
    printf("RUN %lld: landing %lld, %s%s, series %s, runway %s, pattern %s, modification %s\n", (long long)j->landing.id,
           (long long)j->landing.board_landing, collector_state_text((unsigned)j->landing.state), j->is_void ? ", VOID" : "",
           none_if_empty(j->series.name), none_if_empty(j->series.runway), none_if_empty(j->series.pattern),
           none_if_empty(j->series.modification));
    for (size_t i = 0; i < j->observations; i++)
        print_observation(&j->observation[i], si);
    for (size_t i = 0; i < j->changes; i++) {
        const struct store_change *c = &j->change[i];
        survey_time_text(c->made_us, when, sizeof when);
        printf("  %s %s  ", when, none_if_empty(c->who));
        if (strcmp(c->field, "note") == 0)
            printf("note: %s", c->value);
        else if (strcmp(c->field, "void") == 0)
            printf("%s", strcmp(c->value, "yes") == 0 ? "void" : "not void any more");
        else
            printf("%s %s, was %s", c->field, c->value, none_if_empty(c->was));
        printf("%s%s%s\n", c->reason[0] ? " (" : "", c->reason, c->reason[0] ? ")" : "");
    }
}

static json_t *text_json(const char *text)
{
    return text[0] ? json_string(text) : json_null();
}

static json_t *journal_json(const struct journal *j, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si), *length = unit_of(UNIT_DISPLACEMENT, si);
    json_t *changes = json_array(), *observations = json_array();
    for (size_t i = 0; i < j->changes; i++) {
        const struct store_change *c = &j->change[i];
        json_array_append_new(changes, json_pack("{sIsosssossso}", "made_us", (json_int_t)c->made_us, "who", text_json(c->who), "field",
                                                 c->field, "was", text_json(c->was), "value", c->value, "reason", text_json(c->reason)));
    }
    for (size_t i = 0; i < j->observations; i++) {
        const struct store_observation *o = &j->observation[i];
        char at[20], high[20];
        snprintf(at, sizeof at, "station_%s", station->suffix);
        snprintf(high, sizeof high, "height_%s", length->suffix);
        json_array_append_new(observations,
                              json_pack("{sIsIsosssosososososososb}", "id", (json_int_t)o->id, "made_us", (json_int_t)o->made_us, "who",
                                        text_json(o->who), "kind", o->kind, "side", text_json(o->side), at,
                                        cli_json_number(o->station_ft * station->factor, 7), "panels",
                                        o->panels == STORE_NONE ? json_null() : json_integer(o->panels), high,
                                        cli_json_number(o->height_in * length->factor, 6), "time_s", cli_json_number(o->time_s, 6), "form",
                                        text_json(o->form), "note", text_json(o->note), "withdrawn", o->withdrawn));
    }
    return json_pack("{sIsIsbsosososososo}", "run", (json_int_t)j->landing.id, "landing", (json_int_t)j->landing.board_landing, "void",
                     j->is_void, "series", text_json(j->series.name), "runway", text_json(j->series.runway), "pattern",
                     text_json(j->series.pattern), "modification", text_json(j->series.modification), "observations", observations, "changes",
                     changes);
}

static enum mr_status show(const struct request *r, struct store *store, json_t *all, struct error *error)
{
    struct store_landing *rows = NULL;
    struct journal j;
    size_t count = 0;
    enum mr_status status = store_landings(store, &rows, &count, error);
    if (status == MR_OK && r->run) {
        struct store_landing landing;
        status = store_landing_get(store, r->run, &landing, error);
    }
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (r->run && rows[i].id != r->run)
            continue;
        status = journal_get(store, rows[i].id, &j, error);
        if (status == MR_OK && r->cli->json)
            json_array_append_new(all, journal_json(&j, r->cli->si));
        else if (status == MR_OK)
            print_journal(&j, r->cli->si);
        journal_free(&j);
    }
    free(rows);
    return status;
}

static enum mr_status check(struct request *r, struct error *error)
{
    int acts = r->make_void + r->unvoid + (r->correct != NULL) + (r->observe != NULL) + (r->withdraw != NULL) + (r->note && !r->observe);
    bool details = r->station || r->panels || r->height || r->side || r->at || r->form;
    enum mr_status status = r->words[1] ? run_parse(r->words[1], &r->run, error) : MR_OK;
    if (status == MR_OK && acts && !r->run)
        status = error_set(error, MR_USAGE, "which landing? matrig landing DB RUN; see matrig landing --help");
    if (status == MR_OK && acts > 1)
        status = error_set(error, MR_USAGE, "one thing at a time: --note, --correct, --observe, --withdraw, --void or --unvoid; see matrig landing --help");
    if (status == MR_OK && (r->make_void || r->unvoid || r->correct || r->withdraw) && !(r->reason && r->reason[0]))
        status = error_set(error, MR_USAGE, "why? matrig landing needs --reason TEXT with this; who reads it later will ask");
    if (status == MR_OK && r->note && !r->note[0])
        status = error_set(error, MR_USAGE, "an empty note: matrig landing; write what there is to say");
    if (status == MR_OK && details && !r->observe)
        status = error_set(error, MR_USAGE, "--station, --panels, --height, --side, --at and --form go with --observe; see matrig landing --help");
    return status;
}

int landing_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    const struct cli_option options[] = {
        {"--who", &r.who, NULL},         {"--note", &r.note, NULL},       {"--correct", &r.correct, NULL}, {"--reason", &r.reason, NULL},
        {"--observe", &r.observe, NULL}, {"--station", &r.station, NULL}, {"--panels", &r.panels, NULL},   {"--height", &r.height, NULL},
        {"--side", &r.side, NULL},       {"--at", &r.at, NULL},           {"--form", &r.form, NULL},       {"--withdraw", &r.withdraw, NULL},
        {"--void", NULL, &r.make_void},  {"--unvoid", NULL, &r.unvoid}};
    struct error error = {0};
    struct store *store = NULL;
    json_t *all = json_array();
    enum mr_status status = cli_parse(argc, argv, options, sizeof options / sizeof options[0], r.words, 1, 2, "DB [RUN]", &error);
    if (status == MR_OK)
        status = check(&r, &error);
    bool acts = r.note || r.correct || r.observe || r.withdraw || r.make_void || r.unvoid;
    if (status == MR_OK)
        status = store_open(r.words[0], acts ? STORE_OPEN : STORE_READ, &store, &error);
    if (status == MR_OK && acts)
        status = add(&r, store, &error);
    if (status == MR_OK)
        status = show(&r, store, all, &error);
    store_close(store);
    if (status == MR_OK && cli->json)
        return cli_print_json(json_pack("{so}", "landings", all), 0);
    json_decref(all);
    return status == MR_OK ? 0 : cli_fail(&error);
}

/* ---- series ---- */

static enum mr_status list_series(const struct cli *cli, struct store *store, json_t *all, struct error *error)
{
    struct store_series *rows = NULL;
    struct store_landing *landings = NULL;
    size_t count = 0, landed = 0;
    enum mr_status status = store_series_all(store, &rows, &count, error);
    if (status == MR_OK)
        status = store_landings(store, &landings, &landed, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        char when[40];
        size_t its = 0;
        for (size_t k = 0; k < landed && status == MR_OK; k++) {
            struct store_series of;
            status = store_series_of(store, &landings[k], &of, error);
            its += of.id == rows[i].id ? 1u : 0u;
        }
        survey_time_text(rows[i].made_us, when, sizeof when);
        if (cli->json)
            json_array_append_new(all, json_pack("{sssosssosososi}", "name", rows[i].name, "who", text_json(rows[i].who), "begun", when, "runway",
                                                 text_json(rows[i].runway), "pattern", text_json(rows[i].pattern), "modification",
                                                 text_json(rows[i].modification), "landings", (int)its));
        else
            printf("%s: begun %s, runway %s, pattern %s, modification %s, %zu landings%s%s\n", rows[i].name, when, none_if_empty(rows[i].runway),
                   none_if_empty(rows[i].pattern), none_if_empty(rows[i].modification), its, rows[i].notes[0] ? ": " : "", rows[i].notes);
    }
    free(rows);
    free(landings);
    return status;
}

static enum mr_status begin_series(const char *db, struct store *store, const struct store_series *series, struct error *error)
{
    struct store_series *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_series_all(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (strcmp(rows[i].name, series->name) == 0)
            status = error_set(error, MR_USAGE, "there is a series '%s' already: %s; give another name", series->name, db);
    }
    free(rows);
    return status == MR_OK ? store_series_add(store, series, error) : status;
}

int series_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2] = {NULL, NULL}, *runway = NULL, *pattern = NULL, *modification = NULL, *notes = NULL, *who = NULL;
    const struct cli_option options[] = {{"--runway", &runway, NULL}, {"--pattern", &pattern, NULL}, {"--modification", &modification, NULL},
                                         {"--notes", &notes, NULL},   {"--who", &who, NULL}};
    struct error error = {0};
    struct store *store = NULL;
    struct store_series series = {.made_us = (int64_t)link_now_us()};
    json_t *all = json_array();
    enum mr_status status = cli_parse(argc, argv, options, 5, words, 1, 2, "DB [NAME]", &error);
    if (status == MR_OK && !words[1] && (runway || pattern || modification || notes))
        status = error_set(&error, MR_USAGE, "which series? matrig series DB NAME; see matrig series --help");
    if (status == MR_OK && words[1] && (!words[1][0] || strlen(words[1]) >= sizeof series.name))
        status = error_set(&error, MR_USAGE, "not a name: '%s'; 1 to %zu characters", words[1], sizeof series.name - 1);
    if (status == MR_OK)
        status = store_open(words[0], words[1] ? STORE_CREATE : STORE_READ, &store, &error);
    fill(series.name, sizeof series.name, words[1]);
    fill(series.who, sizeof series.who, author(who));
    fill(series.runway, sizeof series.runway, runway);
    fill(series.pattern, sizeof series.pattern, pattern);
    fill(series.modification, sizeof series.modification, modification);
    fill(series.notes, sizeof series.notes, notes);
    if (status == MR_OK && words[1])
        status = begin_series(words[0], store, &series, &error);
    if (status == MR_OK)
        status = list_series(cli, store, all, &error);
    store_close(store);
    if (status == MR_OK && cli->json)
        return cli_print_json(json_pack("{so}", "series", all), 0);
    json_decref(all);
    return status == MR_OK ? 0 : cli_fail(&error);
}
