/* matrig report: the campaign as one page, with plots. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "host/cli.h"
#include "host/output.h"
#include "host/report/page.h"
#include "host/sweep/sweep_page.h"

/* demo/campaign.db -> demo/campaign.html */
static void default_path(const char *db, char *out, size_t size)
{
    const char *slash = strrchr(db, '/');
    const char *dot = strrchr(db, '.');
    int stem = dot && (!slash || dot > slash + 1) ? (int)(dot - db) : (int)strlen(db);
    snprintf(out, size, "%.*s.html", stem, db);
}

static json_t *report_json(const char *path, const struct report *report)
{
    json_t *list = json_array();
    for (size_t i = 0; i < report->landings; i++)
        json_array_append_new(list, summary_json(&report->landing[i].summary, report->si));
    return json_pack("{ssso}", "file", path, "landings", list);
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

static int report_sweep(const char *results, const char *path, bool force, const struct cli *cli)
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
    struct output output;
    if (output_not_input(path, results, &error) == MR_OK && output_begin(&output, path, force, &error) == MR_OK) {
        sweep_page_write(output.file, strrchr(results, '/') ? strrchr(results, '/') + 1 : results, &table);
        output_end(&output, &error);
    }
    if (error.status == MR_OK && cli->json)
        exit_code = cli_print_json(sweep_table_json(&table), 0);
    else if (error.status == MR_OK)
        cli_note(cli, "%zu cases in %s", table.count, path);
    sweep_table_free(&table);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}

/* 0: all landings. */
static enum mr_status read_run(const char *text, int64_t *run, struct error *error)
{
    double value = 0.0;
    enum mr_status status = text ? cli_number(text, "--run", 1.0, 1e9, &value, error) : MR_OK;
    *run = (int64_t)value;
    if (status == MR_OK && (double)*run < value)
        return error_set(error, MR_USAGE, "--run %s: a RUN is a whole number; matrig landing DB lists them", text);
    return status;
}

/* Nothing is written unless all of it could be made. */
static enum mr_status write_page(const struct report *report, const char *path, bool force, struct error *error)
{
    char *text = NULL;
    size_t length = 0;
    enum mr_status status = page_write(report, &text, &length, error);
    if (status == MR_OK)
        output_bytes(path, force, text, length, error);
    free(text);
    return error->status;
}

int report_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1] = {NULL}, *path = NULL, *film = NULL, *run_text = NULL;
    bool voided = false, force = false;
    const struct cli_option options[] = {{"-o", &path, NULL}, {"--run", &run_text, NULL}, {"--film", &film, NULL}, {"--void", NULL, &voided},
                                         {"--force", NULL, &force}};
    char made_path[1000];
    struct error error = {0};
    struct report report = {.si = cli->si};
    struct stat folder;
    int exit_code = 0;
    enum mr_status status = cli_parse(argc, argv, options, 5, words, 1, 1, "DB", &error);
    if (status == MR_OK)
        status = read_run(run_text, &report.run, &error);
    if (status == MR_OK && is_sweep(words[0]))
        return report_sweep(words[0], path, force, cli);
    if (status == MR_OK && film && (stat(film, &folder) != 0 || !S_ISDIR(folder.st_mode)))
        status = error_set(&error, MR_IO, "cannot read the film's folder: %s; --film names a folder with a folder of pictures for each RUN", film);
    report.path = words[0];
    report.film = film;
    if (status == MR_OK && !path) {
        default_path(words[0], made_path, sizeof made_path);
        path = made_path;
    }
    if (status == MR_OK)
        status = output_check(path, force, words[0], &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &report.store, &error);
    if (status == MR_OK && report.run)
        status = store_refuse_void(report.store, report.run, voided, &error);
    if (status == MR_OK)
        status = report_load(&report, voided, &error);
    if (status == MR_OK)
        status = write_page(&report, path, force, &error);
    if (status == MR_OK && cli->json)
        exit_code = cli_print_json(report_json(path, &report), 0);
    else if (status == MR_OK)
        cli_note(cli, "%zu landing%s in %s", report.landings, report.landings == 1 ? "" : "s", path);
    report_free(&report);
    store_close(report.store);
    return status != MR_OK ? cli_fail(&error) : exit_code;
}
