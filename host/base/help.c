#include "host/base/help.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/status.h"
#include "common/version.h"
#include "host/base/xmalloc.h"
#include "host/base/quantity.h"
#include "host/base/answer.h"

#define LINE_WIDTH 100 /* characters; same width as the output of commands */
#define TERM_WIDTH_MAX \
    14 /* characters of the longest term that shares its line with the help text */

const char *help_group_title(enum command_group group)
{
    static const char *const titles[] = {
#define COMMAND_GROUP(name, title) title,
        COMMAND_GROUPS(COMMAND_GROUP)
#undef COMMAND_GROUP
    };
    return titles[group];
}

/* Prints the usage line, then the options that are allowed before every command. `words` has one
 * line per alternative. */
static void print_usage(const char *command, const char *words)
{
    for (const char *line = words; *line;) {
        size_t length = strcspn(line, "\n");
        fputs(line == words ? "Usage: matrig" : "   or: matrig", stdout);
        for (size_t i = 0; line == words && i < command_matrig.part_count; i++) {
            if (command_matrig.parts[i].text)
                printf(" [%s]", command_matrig.parts[i].option.name);
        }
        printf("%s%s %.*s\n", command[0] ? " " : "", command, (int)length, line);
        line += length + (line[length] == '\n');
    }
}

void help_print_overview(const struct command_table *table)
{
    print_usage("", command_matrig.usage);
    putchar('\n');
    for (size_t i = 0; i < table->count; i++) {
        const struct command_entry *entry = &table->commands[i];
        if (i == 0 || entry->group != entry[-1].group)
            printf("%s%s\n", i > 0 ? "\n" : "", help_group_title(entry->group));
        printf("  %-9s %s\n", entry->command->name, entry->command->summary);
    }
    puts("\nOptions before the command");
    for (size_t i = 0; i < command_matrig.part_count; i++) {
        const struct command_part *part = &command_matrig.parts[i];
        if (part->text)
            printf("  %-9s %s\n", part->option.name, part->text);
    }
    puts("  --version\n"
         "\n"
         "Exit codes");
#define EXIT_ROW(code, text) "  " #code "         " text "\n"
    puts(MR_EXIT_TABLE(
        EXIT_ROW) "\nmatrig COMMAND --help describes a command, with an example; man matrig "
                  "describes all commands.\nA number may have a unit: 15mm, '2.5 kN', "
                  "12m/s.\nNO_COLOR=1 turns off colours.\n\nExample: matrig log --can can:can0 "
                  "--serial serial:/dev/ttyUSB0 --db campaign.db && matrig report campaign.db");
}

void help_print_command(const struct command *command)
{
    char *text = help_page_text(command);
    print_usage(command->name, command->usage);
    printf("\n%s.\n\n%s", command->summary, text);
    free(text);
}

void help_print_version(const struct cli *cli)
{
    if (cli->json)
        cli_print_json(json_pack("{s:s}", "version", VERSION_TEXT), 0);
    else
        puts("matrig " VERSION_TEXT);
}

const struct command *help_find(const struct command_table *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++) {
        const struct command_entry *entry = &table->commands[i];
        if (strcmp(entry->command->name, name) == 0)
            return entry->command;
    }
    return NULL;
}

/* ---- unknown command ---- */

/* Copies of the first words of all terms. They must exist as long as the suggestion, which may
 * point to one of them. */
#define FIRST_WORDS_MAX 40
struct option_first_words {
    char word[FIRST_WORDS_MAX][20];
    size_t count;
};

static void suggest_words(const struct command *command, struct option_first_words *words,
                          struct spell_suggest *near)
{
    for (size_t i = 0; i < command->part_count; i++) {
        const struct command_part *part = &command->parts[i];
        if (part->included)
            suggest_words(part->included, words, near);
        if (!part->is_fixed_word || words->count == FIRST_WORDS_MAX)
            continue;
        char *copy = words->word[words->count++];
        snprintf(copy, sizeof words->word[0], "%.*s", (int)strcspn(part->term, " "), part->term);
        spell_suggest_add(near, copy);
    }
}

void help_suggest_word(const struct command *command, const char *word,
                       char out[static SPELL_SUGGEST_TEXT_SIZE])
{
    struct option_first_words words = {.count = 0};
    struct spell_suggest near;
    spell_suggest_begin(&near, word);
    suggest_words(command, &words, &near);
    spell_suggest_text(&near, out);
}

enum mr_status help_refuse_unknown(const struct command_table *table, const char *word,
                                   struct error *error)
{
    struct spell_suggest near;
    char text[SPELL_SUGGEST_TEXT_SIZE];
    spell_suggest_begin(&near, word);
    for (size_t i = 0; i < table->count; i++)
        spell_suggest_add(&near, table->commands[i].command->name);
    spell_suggest_text(&near, text);
    if (access(word, F_OK) == 0 && !near.best)
        return error_set(
            error, MR_UNKNOWN,
            "a file, not a command: '%s'; matrig show %s lists the landings of a campaign", word,
            word);
    return error_set(error, MR_UNKNOWN, "unknown command: '%s'%s%s see matrig --help", word, text,
                     text[0] ? "" : ";");
}

static int print_json(const struct command_table *table, const struct command *only)
{
    json_t *list = json_array();
    for (size_t i = 0; i < table->count; i++) {
        const struct command *c = table->commands[i].command;
        char *text = help_page_text(c);
        if (!only || only == c)
            json_array_append_new(list,
                                  json_pack("{s:s,s:s,s:s,s:s}", "name", c->name, "words", c->usage,
                                            "summary", c->summary, "details", text));
        free(text);
    }
    return cli_print_json(json_pack("{s:o}", "commands", list), 0);
}

static const struct command command_help = {"help", NULL, "[COMMAND]", "list of the commands",
                                            NULL,   0,    {0, 1, ""}};

int help_run(int argc, char **argv, const struct command_table *table, const struct cli *cli)
{
    struct error error = {0};
    const char *words[1] = {NULL};
    const struct command *command = NULL;
    if (command_parse(&command_help, argc, argv, cli, NULL, words, &error) != MR_OK)
        return cli_fail(&error);
    if (words[0])
        command = help_find(table, words[0]);
    if (words[0] && !command)
        help_refuse_unknown(table, words[0], &error);
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (cli->json)
        return print_json(table, command);
    else if (command)
        help_print_command(command);
    else
        help_print_overview(table);
    return 0;
}

void help_for_each_part(const struct command *command,
                        void (*each)(void *context, const struct command_part *part), void *context)
{
    for (size_t i = 0; i < command->part_count; i++) {
        if (command->parts[i].included)
            help_for_each_part(command->parts[i].included, each, context);
        else
            each(context, &command->parts[i]);
    }
}

/* Prints the text with {low}, {high} and {standard} replaced by numbers. */
static void write_text(FILE *out, const struct command_part *part)
{
    const struct command_option *option = &part->option;
    const struct {
        const char *name;
        double value;
    } numbers[] = {
        {"{low}", option->low}, {"{high}", option->high}, {"{standard}", option->default_value}};
    for (const char *at = part->text; *at;) {
        size_t used = 0;
        for (size_t i = 0; option->name && i < sizeof numbers / sizeof numbers[0]; i++) {
            if (strncmp(at, numbers[i].name, strlen(numbers[i].name)) == 0) {
                fprintf(out, "%.9g", numbers[i].value);
                used = strlen(numbers[i].name);
            }
        }
        if (used == 0)
            fputc(*at, out);
        at += used ? used : 1;
    }
}

/* Prints the unit that applies to a number without a unit. */
static void write_unit(FILE *out, const struct command_option *option)
{
    if (option->kind != OPTION_IS_NUMBER || !quantity_kind_find(option->unit))
        return;
    fprintf(out, " (unit: %s", option->unit);
    if (option->unit_si)
        fprintf(out, ", with --si %s", option->unit_si);
    fputc(')', out);
}

static char *make_text(const struct command_part *part, const char *before)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = xopen_memstream(&text, &length);
    fputs(before, out);
    write_text(out, part);
    write_unit(out, &part->option);
    size_t written = strlen(part->text);
    bool prose = !part->term && !part->option.name;
    /* no line break here: a line that ends with a blank is continued */
    if (!prose || written == 0 || part->text[written - 1] != ' ')
        fputc('\n', out);
    if (fclose(out) != 0)
        abort();
    return text;
}

static char *make_term(const struct command_part *part)
{
    const char *argument = part->option.argument;
    if (part->term)
        return xstrdup(part->term);
    if (part->option.name)
        return xasprintf("%s%s%s", part->option.name, argument ? " " : "",
                         argument ? argument : "");
    return NULL;
}

static void add_row(void *context, const struct command_part *part)
{
    struct help_page *page = context;
    if (!part->text)
        return;
    char *term = make_term(part);
    char *text = make_text(part, !part->is_example       ? ""
                                 : part->text[0] == '\n' ? "Example:"
                                                         : "Example: ");
    struct help_row *last = page->row_count ? &page->row[page->row_count - 1] : NULL;
    if (!term && last && !last->term) { /* consecutive rows without a term are joined to one text */
        char *both = xasprintf("%s%s", last->text, text);
        free(last->text);
        free(text);
        last->text = both;
        return;
    }
    if (!list_grow(&page->row, page->row_count, sizeof *page->row))
        abort();
    page->row[page->row_count++] = (struct help_row){term, text};
}

struct help_page help_page_make(const struct command *command)
{
    struct help_page page = {NULL, 0};
    help_for_each_part(command, add_row, &page);
    return page;
}

void help_page_free(struct help_page *page)
{
    for (size_t i = 0; i < page->row_count; i++) {
        free(page->row[i].term);
        free(page->row[i].text);
    }
    free(page->row);
    *page = (struct help_page){NULL, 0};
}

/* Writes lines of text, wrapped and indented. The first begins at `column` of its line. A line that
 * begins with a blank and the lines of an example, up to an empty line, are printed unchanged. */
static void write_lines(FILE *out, const char *text, size_t column, size_t indent)
{
    bool is_example = false;
    for (const char *line = text; *line; column = 0) {
        size_t length = strcspn(line, "\n");
        is_example = length > 0 && (is_example || strncmp(line, "Example", 7) == 0);
        if (is_example || length == 0 || line[0] == ' ') {
            fprintf(out, "%*s%.*s\n", (int)(length > 0 ? indent - column : 0), "", (int)length,
                    line);
        } else {
            char *copy = xasprintf("%.*s", (int)length, line);
            text_print_wrapped(copy, column, indent, LINE_WIDTH, out);
            free(copy);
        }
        line += length + (line[length] == '\n');
    }
}

static void write_item(FILE *out, const struct help_row *row)
{
    bool is_long = strlen(row->term) > TERM_WIDTH_MAX;
    if (is_long)
        fprintf(out, "  %s\n", row->term);
    else
        fprintf(out, "  %-*s", TERM_WIDTH_MAX, row->term);
    write_lines(out, row->text, is_long ? 0 : HELP_TEXT_COLUMN - 1, HELP_TEXT_COLUMN);
}

char *help_page_text(const struct command *command)
{
    struct help_page page = help_page_make(command);
    char *text = NULL;
    size_t length = 0;
    FILE *out = xopen_memstream(&text, &length);
    for (size_t i = 0; i < page.row_count; i++) {
        if (page.row[i].term)
            write_item(out, &page.row[i]);
        else
            write_lines(out, page.row[i].text, 0, 0);
    }
    if (fclose(out) != 0)
        abort();
    help_page_free(&page);
    return text;
}
