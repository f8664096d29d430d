/* The command matrig sweep: lists the cases of a sweep, runs some of them, and collects their
 * results. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/output.h"
#include "host/commands/commands.h"
#include "host/commands/studies.h"
#include "host/sweep/sweep_table.h"

static void check_options(const struct sweep_request *r)
{
    if (r->cases && r->table)
        error_set(
            fatal, MR_USAGE,
            "--cases and --table exclude each other; run the cases first, then make the table");
    if (r->output && !r->cases && !r->table)
        error_set(fatal, MR_USAGE, "-o works only with --cases or --table; give one of them");
    if (r->words[1] && !r->table)
        error_set(fatal, MR_USAGE, "unexpected argument: '%s' of sweep; result files need --table",
                  r->words[1]);
    if (r->table && !r->words[1])
        error_set(fatal, MR_USAGE,
                  "argument missing: matrig sweep FILE --table needs the result files R.jsonl...");
    output_check(r->output, r->words[0], fatal);
}

/* Reads the first and last case, "N..M" or "N", counted from 1. If N or M is beyond the last case,
 * uses the last case, so that all tasks of a cluster can have the same size. */
static void read_cases(const char *text, size_t cases, size_t *first, size_t *end)
{
    char *after;
    unsigned long long low = strtoull(text, &after, 10), high = low;
    bool good = *text >= '0' && *text <= '9';
    if (good && strncmp(after, "..", 2) == 0) {
        const char *last = after + 2;
        good = *last >= '0' && *last <= '9';
        high = strtoull(last, &after, 10);
    }
    if (!good || *after != '\0')
        error_set(fatal, MR_USAGE, "not a range of cases: --cases %s; give N..M, or N", text);
    if (low < 1 || low > cases || high < low)
        error_set(fatal, MR_USAGE, "--cases %s is out of range; give cases from 1 to %zu", text,
                  cases);
    *first = (size_t)low - 1;
    *end = high < cases ? (size_t)high : cases;
}

/* Prints a line immediately; with --json, adds it to the object `all` instead. */
static void write_line(json_t *line, json_t *all, FILE *out)
{
    if (all) {
        json_array_append_new(all, line);
        return;
    }
    json_dumpf(line, out, JSON_COMPACT | JSON_REAL_PRECISION(15));
    fputc('\n', out);
    json_decref(line);
}

static int print_all_lines(json_t *all)
{
    return all ? cli_print_json(json_pack("{s:o}", "cases", all), 0) : 0;
}

static int run_cases(const struct sweep_request *r, const struct sweep *sweep,
                     const struct cli *cli)
{
    size_t first = 0, end = 0, failed = 0;
    struct output output;
    read_cases(r->cases, sweep->case_count, &first, &end);
    output_begin(&output, r->output, fatal);
    json_t *all = cli->json && !r->output ? json_array() : NULL;
    for (size_t i = first; i < end; i++) {
        json_t *line = sweep_make_line(sweep, i,
                                       sweep_run_case(sweep, i, sweep_get_simulator(sweep)));
        failed += strcmp(json_string_value(json_object_get(line, "status")), "ok") != 0;
        write_line(line, all, output.file);
    }
    int code = print_all_lines(all);
    output_end(&output, fatal);
    if (!r->output)
        return code;
    struct answer *answer = answer_new(cli->si);
    answer_add_count(answer, "cases", "cases", (int64_t)(end - first));
    answer_add_count(answer, "failed", "failed", (int64_t)failed);
    answer_add_text(answer, "results", "results", "%s", r->output);
    return answer_print(cli, answer, 0);
}

static int list_cases(const struct sweep *sweep, const struct cli *cli)
{
    json_t *all = cli->json ? json_array() : NULL;
    for (size_t i = 0; i < sweep->case_count; i++)
        write_line(json_pack("{s:I,s:o}", "case", (json_int_t)i + 1, "values",
                             sweep_case_values(sweep, i)),
                   all, stdout);
    return print_all_lines(all);
}

static int show_table(const struct sweep_request *r, const struct sweep *sweep,
                      const struct cli *cli)
{
    struct sweep_table table;
    struct output output;
    sweep_table_load(&table, sweep, r->words + 1, fatal);
    if (r->output) {
        output_begin(&output, r->output, fatal);
        sweep_table_write_csv(&table, output.file);
        output_end(&output, fatal);
    }
    struct answer *answer = sweep_table_to_answer(&table, !r->output);
    int code = table.missing_count ? mr_status_exit_code(MR_LIMIT) : 0;
    sweep_table_free(&table);
    return answer_print(cli, answer, code);
}

int sweep_command(int argc, char **argv, const struct cli *cli)
{
    struct sweep_request request = {.cases = NULL};
    struct sweep sweep;
    command_parse(&command_sweep, argc, argv, cli, &request, request.words, fatal);
    check_options(&request);
    sweep_load(&sweep, request.words[0], fatal);
    int code = request.table ? show_table(&request, &sweep, cli)
             : request.cases ? run_cases(&request, &sweep, cli)
                             : list_cases(&sweep, cli);
    sweep_free(&sweep);
    return code;
}
