/* The command matrig board ... bringup [report|brown-out|rom]: reads the lines that the bring-up
 * image prints and compares them with their limits. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/answer.h"
#include "host/base/xmalloc.h"
#include "host/board/bringup.h"
#include "host/commands/commands.h"

#define VALUE_TEXT_SIZE 160

struct request {
    const struct cli *cli;
    const char *serial;
};

/* ---- printing ---- */

static json_t *value_to_json(const struct bringup_line *line)
{
    if (!line || line->is_absent)
        return json_null();
    return isnan(line->number) || strncmp(line->value, "0x", 2) == 0 ? json_string(line->value)
                                                                     : json_real(line->number);
}

static json_t *line_to_json(const struct bringup_result *j)
{
    const struct bringup_limit *limit = j->limit;
    json_t *json = json_pack(
        "{ssssss?sosbssss}", "name", j->name, "verdict", bringup_verdict_text(j->verdict), "unit",
        j->line ? j->line->unit : NULL, "value", value_to_json(j->line), "said", j->line != NULL,
        "source", limit ? limit->source : "", "advice", limit && j->verdict ? limit->advice : "");
    if (limit && !limit->words) {
        json_object_set_new(json, "least", cli_json_number(j->min, 15));
        json_object_set_new(json, "most", cli_json_number(j->max, 15));
    }
    if (limit && limit->words && *limit->words)
        json_object_set_new(json, "words", json_string(limit->words));
    return json;
}

/* Writes the limits of a value, in hexadecimal or decimal as the value itself. */
static void format_limits(const struct bringup_result *j, char out[VALUE_TEXT_SIZE])
{
    const struct bringup_limit *limit = j->limit;
    bool hexadecimal = j->line && strncmp(j->line->value, "0x", 2) == 0;
    if (!limit || (limit->words && !*limit->words) ||
        (!limit->words && (limit->verdict_if_outside == BRINGUP_OK || isnan(j->min))))
        *out = 0;
    else if (limit->words)
        snprintf(out, VALUE_TEXT_SIZE, "%s", limit->words);
    else if (hexadecimal && j->min == j->max)
        snprintf(out, VALUE_TEXT_SIZE, "0x%x", (unsigned)j->min);
    else if (hexadecimal)
        snprintf(out, VALUE_TEXT_SIZE, "0x%x to 0x%x", (unsigned)j->min, (unsigned)j->max);
    else if (j->min == j->max)
        snprintf(out, VALUE_TEXT_SIZE, "%.10g", j->min);
    else
        snprintf(out, VALUE_TEXT_SIZE, "%.10g to %.10g", j->min, j->max);
}

/* Returns the number of consecutive lines, from `at` on, that belong to one group and are within
 * their limits. */
static size_t find_group_size(const struct bringup_result *results, size_t count, size_t at)
{
    size_t n = 1;
    if (!results[at].limit || !bringup_limit_is_group(results[at].limit) || results[at].verdict ||
        results[at].line->is_absent)
        return 1;
    while (at + n < count && results[at + n].limit == results[at].limit &&
           !results[at + n].verdict && results[at + n].line &&
           strcmp(results[at + n].line->unit, results[at].line->unit) == 0)
        n++;
    return n;
}

static void format_value(const struct bringup_result *results, size_t group,
                         char out[VALUE_TEXT_SIZE])
{
    const struct bringup_line *least = results->line, *most = results->line;
    for (size_t i = 1; i < group; i++) {
        least = results[i].line->number < least->number ? results[i].line : least;
        most = results[i].line->number > most->number ? results[i].line : most;
    }
    if (!results->line)
        snprintf(out, VALUE_TEXT_SIZE, "not reported");
    else if (group > 1)
        snprintf(out, VALUE_TEXT_SIZE, "%s to %s %s", least->value, most->value, least->unit);
    else
        snprintf(out, VALUE_TEXT_SIZE, "%s %s", least->value, least->unit);
}

static void print_row(struct answer *answer, const struct bringup_result *j, size_t group)
{
    char value[VALUE_TEXT_SIZE], limits[VALUE_TEXT_SIZE], name[VALUE_TEXT_SIZE];
    format_value(j, group, value);
    format_limits(j, limits);
    if (group > 1)
        snprintf(name, sizeof name, "%s (%zu)", j->limit->name, group);
    else
        snprintf(name, sizeof name, "%s", j->name);
    answer_open_row(answer);
    answer_add_text(answer, NULL, "verdict", "%s", bringup_verdict_text(j->verdict));
    answer_add_text(answer, NULL, "line", "%s", name);
    answer_add_text(answer, NULL, "value", "%s", value);
    answer_add_text(answer, NULL, "should be", "%s", limits);
}

static void print_advice(struct answer *answer, const struct bringup_result *results, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct bringup_result *j = &results[i];
        if (!j->verdict)
            continue;
        const char *what =
            !j->limit
                ? "unknown line of the board's report; the bring-up image may be of another version"
                : j->limit->advice;
        answer_add_sentence(answer, NULL, "%s: %s: %s%s%s%s", bringup_verdict_text(j->verdict),
                            j->name, what, j->limit && *j->limit->source ? " [" : "",
                            j->limit ? j->limit->source : "",
                            j->limit && *j->limit->source ? "]" : "");
    }
}

/* Prints the result of every line. The JSON has each line; the table combines consecutive lines of
 * a group that are within their limits. */
static int check_values(const struct request *request, const struct bringup *b)
{
    static struct bringup_result results[BRINGUP_RESULTS_MAX];
    size_t count = bringup_check_limits(b, results), verdicts[BRINGUP_WRONG + 1] = {0};
    enum bringup_verdict worst = bringup_worst_verdict(results, count);
    const struct bringup_line *uid = bringup_find(b, "uid");
    json_t *lines = json_array();
    struct answer *answer = answer_new(request->cli->si);
    for (size_t i = 0; i < count; i++) {
        verdicts[results[i].verdict]++;
        json_array_append_new(lines, line_to_json(&results[i]));
    }
    answer_add_text(answer, "section", NULL, "%s", b->section);
    answer_add_text_or_missing(answer, "board", NULL, uid ? uid->value : NULL, NULL);
    answer_add_text(answer, "verdict", NULL, "%s", bringup_verdict_text(worst));
    answer_add_json(answer, "lines", lines);
    answer_open_table(answer, NULL, b->section);
    for (size_t i = 0; i < count;) {
        size_t group = find_group_size(results, count, i);
        print_row(answer, &results[i], group);
        i += group;
    }
    answer_close_group(answer);
    print_advice(answer, results, count);
    answer_add_sentence(answer, NULL, "%zu lines ok, %zu to be checked, %zu wrong",
                        verdicts[BRINGUP_OK], verdicts[BRINGUP_SUSPECT], verdicts[BRINGUP_WRONG]);
    return answer_print(request->cli, answer,
                        worst == BRINGUP_WRONG ? mr_status_exit_code(MR_LIMIT) : 0);
}

/* ---- the board ---- */

static int start_boot_rom(const struct request *request, struct link *link, struct error *error)
{
    if (bringup_start_rom(link, error) != MR_OK)
        return cli_fail(error);
    if (request->cli->json)
        return cli_print_json(json_pack("{ss}", "started", "rom"), 0);
    puts("the boot ROM is running: flash the next image");
    return 0;
}

static int run_sections(const struct request *request, const char *section)
{
    struct error error = {0};
    struct link *link = NULL;
    struct bringup *b = xcalloc(1, sizeof *b);
    int exit_code;
    enum mr_status status = link_open(request->serial, LINK_SERIAL, &link, &error);
    if (status == MR_OK && strcmp(section, "rom") == 0)
        exit_code = start_boot_rom(request, link, &error);
    else if (status == MR_OK && bringup_request(b, link, section, &error) == MR_OK)
        exit_code = check_values(request, b);
    else
        exit_code = cli_fail(&error);
    link_close(link);
    bringup_free(b);
    free(b);
    return exit_code;
}

static bool is_section(const char *word)
{
    static const char *const sections[] = {BRINGUP_SECTION_NAMES, "rom"};
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++) {
        if (strcmp(word, sections[i]) == 0)
            return true;
    }
    return false;
}

static int bringup_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct request r = {.cli = cli};
    command_parse(&command_board_bringup, argc, argv, cli, &r, words, fatal);
    const char *section = words[1] ? words[1] : "report";
    if (strcmp(words[0], "bringup") != 0)
        error_set(fatal, MR_USAGE, "unknown action: '%s'; give matrig board bringup", words[0]);
    if (!is_section(section))
        error_set(fatal, MR_USAGE, "unknown action of bringup: '%s'; give report, brown-out or rom",
                  section);
    if (!r.serial)
        error_set(fatal, MR_USAGE,
                  "no link: matrig board needs --serial LINK; see matrig board --help");
    if (strcmp(section, "rom") == 0 && strncmp(r.serial, "file:", 5) == 0)
        error_set(fatal, MR_USAGE, "the link is a file: %s; give the link of a board", r.serial);
    return run_sections(&r, section);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD("bringup",
              "check the output of a new board's bring-up image (make bringup; 115200 baud) "
              "against limits: each line is ok, look or wrong, with advice. LINK may be file:F, "
              "saved by a terminal program. brown-out sets the brown-out level for the board's "
              "supply; rom starts the boot ROM for the next image. Exit 1 when a line is wrong.\n  "
              "matrig board --serial serial:/dev/ttyUSB0 bringup"),
    OPTION_TEXT("--serial", "LINK", serial, NULL),
};

const struct command command_board_bringup = {
    "board",
    bringup_command,
    "bringup [report|brown-out|rom]",
    "bring-up of a new board",
    COMMAND_PARTS(parts),
    {1, 2, "bringup [report|brown-out|rom]"},
};
