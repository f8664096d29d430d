/* matrig report: the campaign as one page, with plots. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/cli.h"
#include "host/output.h"
#include "host/report/journal_page.h"
#include "host/report/page.h"
#include "host/report/survey_page.h"
#include "host/store/store_journal.h"
#include "host/sweep/sweep_page.h"

/* demo/campaign.db -> demo/campaign.html */
static void default_path(const char *db, char *out, size_t size)
{
    const char *slash = strrchr(db, '/');
    const char *dot = strrchr(db, '.');
    int stem = dot && (!slash || dot > slash + 1) ? (int)(dot - db) : (int)strlen(db);
    snprintf(out, size, "%.*s.html", stem, db);
}

static enum mr_status load_landing(struct store *store, int64_t run, struct report_landing *landing,
                                   struct error *error)
{
    enum mr_status status = summary_load(store, run, &landing->summary, error);
    if (status == MR_OK)
        status = zones_load_survey(store, run, &landing->survey, error);
    if (status == MR_OK)
        status = store_motions(store, run, &landing->motion, &landing->motions, error);
    if (status == MR_OK)
        status = store_simulations(store, run, &landing->simulation, &landing->simulations, error);
    if (status == MR_OK)
        status = store_simulation_head(store, run, &landing->head, error);
    return status;
}

static void free_landings(struct report_landing *landings, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        summary_free(&landings[i].summary);
        free(landings[i].motion);
        store_simulations_free(landings[i].simulation, landings[i].simulations);
        free(landings[i].head.segments_in);
    }
    free(landings);
}

/* Voided landings are left out unless `voided`. */
static enum mr_status load(struct store *store, bool voided, struct report_landing **landings, size_t *count,
                           struct error *error)
{
    struct store_landing *rows;
    size_t wanted;
    enum mr_status status = store_landings(store, &rows, &wanted, error);
    if (status != MR_OK)
        return status;
    *landings = calloc(wanted ? wanted : 1, sizeof **landings);
    if (!*landings)
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs", wanted);
    for (size_t i = 0; i < wanted && status == MR_OK; i++) {
        bool is_void = false;
        status = store_is_void(store, rows[i].id, &is_void, NULL, error);
        if (status == MR_OK && (voided || !is_void))
            status = load_landing(store, rows[i].id, &(*landings)[(*count)++], error);
    }
    free(rows);
    return status;
}

static json_t *report_json(const char *path, const struct report_landing *landings, size_t count, bool si)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, summary_json(&landings[i].summary, si));
    return json_pack("{ssso}", "file", path, "landings", list);
}

/* Sections that are loaded and written by themselves; the caller frees it. */
static char *sections(struct store *store, bool si, struct error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        abort();
    if (journal_page(store, si, out, error) == MR_OK)
        survey_page(store, si, out, error);
    fclose(out);
    return text;
}

/* Lines of JSON instead of a database: results of a sweep. */
static bool is_sweep(const char *path)
{
    size_t length = strlen(path);
    FILE *file = fopen(path, "r");
    int first = file ? fgetc(file) : EOF;
    if (file)
        fclose(file);
    return first == '{' || (length > 6 && strcmp(path + length - 6, ".jsonl") == 0);
}

static int report_sweep(const char *results, const char *path, const struct cli *cli)
{
    struct sweep_table table;
    struct error error = {0};
    char made_path[1000];
    int exit_code = 0;
    if (sweep_table_load(&table, results, &error) != MR_OK)
        return cli_fail(&error);
    if (!path) {
        default_path(results, made_path, sizeof made_path);
        path = made_path;
    }
    FILE *out = output_open(path, &error);
    if (out) {
        sweep_page_write(out, strrchr(results, '/') ? strrchr(results, '/') + 1 : results, &table);
        output_close(out, path, &error);
    }
    if (error.status == MR_OK && cli->json)
        exit_code = cli_print_json(sweep_table_json(&table), 0);
    else if (error.status == MR_OK)
        cli_note(cli, "%zu cases in %s", table.count, path);
    sweep_table_free(&table);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}

int report_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1] = {NULL}, *path = NULL;
    bool voided = false;
    const struct cli_option options[] = {{"-o", &path, NULL}, {"--void", NULL, &voided}};
    char made_path[1000];
    struct error error = {0};
    struct store *store = NULL;
    struct report_landing *landings = NULL;
    struct store_slow *slow = NULL;
    size_t count = 0, slow_count = 0;
    enum mr_status status = cli_parse(argc, argv, options, 2, words, 1, 1, "DB", &error);
    if (status == MR_OK && is_sweep(words[0]))
        return report_sweep(words[0], path, cli);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &store, &error);
    if (status == MR_OK)
        status = load(store, voided, &landings, &count, &error);
    if (status == MR_OK)
        status = store_slow_rows(store, NULL, &slow, &slow_count, &error);
    char *more = status == MR_OK ? sections(store, cli->si, &error) : NULL;
    status = error.status;
    store_close(store);
    if (status == MR_OK && !path) {
        default_path(words[0], made_path, sizeof made_path);
        path = made_path;
    }
    FILE *out = status == MR_OK ? output_open(path, &error) : NULL;
    if (out) {
        const char *name = strrchr(words[0], '/') ? strrchr(words[0], '/') + 1 : words[0];
        page_write(out, name, landings, count, slow, slow_count, more, cli->si);
        output_close(out, path, &error);
    }
    int exit_code = 0;
    if (error.status == MR_OK && cli->json)
        exit_code = cli_print_json(report_json(path, landings, count, cli->si), 0);
    else if (error.status == MR_OK)
        cli_note(cli, "%zu landing%s in %s", count, count == 1 ? "" : "s", path);
    free_landings(landings, count);
    free(slow);
    free(more);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}
