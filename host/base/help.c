#include "host/base/help.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/version.h"
#include "host/base/help_page.h"

const char *help_group_title(enum command_group group)
{
    static const char *const titles[] = {
#define COMMAND_GROUP(name, title) title,
        COMMAND_GROUPS(COMMAND_GROUP)
#undef COMMAND_GROUP
    };
    return titles[group];
}

/* With the options that may stand before every command. */
static void print_usage(const char *words)
{
    fputs("usage: matrig", stdout);
    for (size_t i = 0; i < command_matrig.count; i++) {
        if (command_matrig.parts[i].text)
            printf(" [%s]", command_matrig.parts[i].option.name);
    }
    printf(" %s\n", words);
}

void help_overview(const struct command_table *table)
{
    print_usage(command_matrig.words);
    putchar('\n');
    for (size_t i = 0; i < table->count; i++) {
        const struct command_entry *entry = &table->commands[i];
        if (i == 0 || entry->group != entry[-1].group)
            printf("%s%s\n", i > 0 ? "\n" : "", help_group_title(entry->group));
        printf("  %-9s %s\n", entry->command->name, entry->command->summary);
    }
    puts("\nBefore the command");
    for (size_t i = 0; i < command_matrig.count; i++) {
        const struct command_part *part = &command_matrig.parts[i];
        if (part->text)
            printf("  %-9s %s\n", part->option.name, part->text);
    }
    puts("  --version\n"
         "\n"
         "matrig COMMAND --help tells more about a command, with an example; man matrig has it "
         "all.\n"
         "A number may have its unit behind it: 15mm, '2.5 kN', 12m/s. Any unit of its kind is "
         "read, another is refused.\n"
         "matrig help --bash prints the completion of bash.\n"
         "Exit: 0 ok, 1 a comparison or limit failed, 2 usage, 3 input/output or device,\n"
         "4 malformed or truncated input, 5 numerics refused or failed.\n"
         "NO_COLOR=1 turns colours off.\n"
         "\n"
         "Example: matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db && "
         "matrig report campaign.db");
}

void help_command(const struct command *command)
{
    char *text = help_page_text(command);
    char *words = NULL;
    if (asprintf(&words, "%s %s", command->name, command->words) < 0)
        abort();
    print_usage(words);
    printf("\n%s.\n\n%s", command->summary, text);
    free(words);
    free(text);
}

void help_version(const struct cli *cli)
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

/* ---- a command that is none ---- */

/* Words that people use for a command. */
static const struct {
    const char *word, *command;
} others[] = {{"record", "log"},  {"list", "show"},    {"info", "show"},
              {"view", "show"},   {"plot", "report"},  {"play", "replay"},
              {"check", "ready"}, {"status", "board"}, {"note", "landing"}};

/* Whether the term ("config get") begins with the word. */
static bool begins_with(const char *term, const char *word)
{
    size_t length = strlen(word);
    return term && length && strncmp(term, word, length) == 0 &&
           (term[length] == '\0' || term[length] == ' ');
}

static bool has_word(const struct command *command, const char *word)
{
    for (size_t i = 0; i < command->count; i++) {
        const struct command_part *part = &command->parts[i];
        if ((part->word && begins_with(part->term, word)) ||
            (part->with && has_word(part->with, word)))
            return true;
    }
    return false;
}

/* The terms' first words, in `copies`: what is near is one of them. */
#define WORDS 40
struct words {
    char copy[WORDS][20];
    size_t count;
};

static void try_words(const struct command *command, struct words *words, struct near *near)
{
    for (size_t i = 0; i < command->count; i++) {
        const struct command_part *part = &command->parts[i];
        if (part->with)
            try_words(part->with, words, near);
        if (!part->word || words->count == WORDS)
            continue;
        char *copy = words->copy[words->count++];
        snprintf(copy, sizeof words->copy[0], "%.*s", (int)strcspn(part->term, " "), part->term);
        near_try(near, copy);
    }
}

void help_near_word(const struct command *command, const char *word, char out[static NEAR_TEXT])
{
    struct words words = {.count = 0};
    struct near near;
    near_begin(&near, word);
    try_words(command, &words, &near);
    near_text(&near, out);
}

static const struct command *find_by_word(const struct command_table *table, const char *word)
{
    for (size_t i = 0; i < table->count; i++) {
        if (has_word(table->commands[i].command, word))
            return table->commands[i].command;
    }
    return NULL;
}

enum mr_status help_unknown(const struct command_table *table, const char *word,
                            struct error *error)
{
    struct near near;
    char text[NEAR_TEXT];
    const struct command *owner = find_by_word(table, word);
    near_begin(&near, word);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (strcmp(others[i].word, word) != 0)
            continue;
        near_try(&near, near.word = others[i].command);
        owner = NULL;
    }
    for (size_t i = 0; i < table->count; i++)
        near_try(&near, table->commands[i].command->name);
    near_text(&near, text);
    if (owner)
        return error_set(error, MR_UNKNOWN,
                         "unknown command: '%s' is a word of matrig %s; see matrig %s --help", word,
                         owner->name, owner->name);
    if (access(word, F_OK) == 0 && !near.best)
        return error_set(error, MR_UNKNOWN,
                         "a file, no command: '%s'; matrig show %s says what a campaign holds",
                         word, word);
    return error_set(error, MR_UNKNOWN, "unknown command: '%s'%s%s see matrig --help", word, text,
                     text[0] ? "" : ";");
}

/* The table for a program. */
static int print_json(const struct command_table *table, const struct command *only)
{
    json_t *list = json_array();
    for (size_t i = 0; i < table->count; i++) {
        const struct command *c = table->commands[i].command;
        char *text = help_page_text(c);
        if (!only || only == c)
            json_array_append_new(list,
                                  json_pack("{s:s,s:s,s:s,s:s}", "name", c->name, "words", c->words,
                                            "summary", c->summary, "details", text));
        free(text);
    }
    return cli_print_json(json_pack("{s:o}", "commands", list), 0);
}

struct request {
    bool bash, help;
};

#define VALUES struct request
static const struct command_part parts[] = {
    OPTION_FLAG("--bash", bash, "completion for bash"),
    OPTION_FLAG("--help", help, NULL),
};
static const struct command help_itself = {
    "help",    NULL, "[COMMAND | --bash]", "what matrig can do", COMMAND_PARTS(parts),
    {0, 1, ""}};

int help_words(int argc, char **argv, const struct command_table *table, const struct cli *cli)
{
    struct error error = {0};
    struct request request = {0};
    const char *words[1] = {NULL};
    const struct command *command = NULL;
    if (command_parse(&help_itself, argc, argv, cli, &request, words, &error) != MR_OK)
        return cli_fail(&error);
    if (words[0])
        command = help_find(table, words[0]);
    if (words[0] && !command)
        help_unknown(table, words[0], &error);
    else if (request.bash && command)
        error_set(&error, MR_USAGE,
                  "too much at once: matrig help; give a command or --bash");
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (request.bash)
        help_bash(table);
    else if (cli->json)
        return print_json(table, command);
    else if (command)
        help_command(command);
    else
        help_overview(table);
    return 0;
}
