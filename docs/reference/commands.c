#include <ctype.h>
#include <string.h>

#include "docs/reference/reference.h"
#include "host/base/help.h"
#include "host/commands/commands.h"

/* Text of an item. A line that begins with two blanks is code; several of them are a block. */
static void write_text(FILE *out, const char *text)
{
    enum { START, PROSE, BLOCK, BLOCK_END } was = START;
    for (const char *line = text, *next; *line; line = next) {
        size_t length = strcspn(line, "\n");
        next = line + length + (line[length] == '\n');
        bool is_code = line[0] == ' ', more_code = next[0] == ' ';
        if (is_code && (was == BLOCK || more_code)) {
            fprintf(out, "%s%.*s\n%s", was == BLOCK ? "" : "\n  ```text\n", (int)length, line,
                    more_code ? "" : "  ```\n");
            was = more_code ? BLOCK : BLOCK_END;
        } else {
            fputs(was == START ? "" : was == BLOCK_END ? "  " : " ", out);
            fprintf(out, is_code ? "`%.*s`" : "%.*s", (int)length - (is_code ? 2 : 0),
                    line + (is_code ? 2 : 0));
            was = PROSE;
        }
    }
    fputs(was == BLOCK_END ? "" : "\n", out);
}

/* Paragraphs, without the examples: their lines, up to an empty line, are in --help alone. */
static void write_prose(FILE *out, const char *text)
{
    bool is_example = false;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n");
        is_example = length > 0 &&
                     (is_example || strncmp(line, "Example:", strlen("Example:")) == 0);
        if (length > 0 && !is_example)
            fprintf(out, "\n%.*s\n", (int)length, line);
        line += length + (line[length] == '\n');
    }
}

#define SYNOPSIS_MAX 1000

/* Whether the page has a row for the option that begins `words`. */
static bool has_row(const struct help_page *page, const char *words)
{
    size_t length = strcspn(words, " ]"), i = 0;
    while (i < page->row_count &&
           !(page->row[i].term && strcspn(page->row[i].term, " ") == length &&
             strncmp(page->row[i].term, words, length) == 0))
        i++;
    return i < page->row_count;
}

/* The synopsis without single options in brackets that have a row. */
static void write_synopsis(FILE *out, const struct command *command, const struct help_page *page)
{
    char text[SYNOPSIS_MAX];
    for (const char *line = command->usage; *line;) {
        size_t length = strcspn(line, "\n"), depth = 0, used = 0;
        bool has_options = false;
        for (const char *at = line; at < line + length && used < sizeof text - 1; at++) {
            size_t group = strcspn(at + 1, "[]\n") + 1;
            const char *choice = strstr(at, " | ");
            if (depth == 0 && strncmp(at, "[-", 2) == 0 && at[group] == ']' &&
                !(choice && choice < at + group) && has_row(page, at + 1)) {
                has_options = true;
                at += group;
                used -= used > 0;
                continue;
            }
            depth += *at == '[';
            depth -= *at == ']';
            text[used++] = *at;
        }
        fprintf(out, "    matrig %s %.*s%s\n", command->name, (int)used, text,
                has_options ? " [OPTION...]" : "");
        line += length + (line[length] == '\n');
    }
}

/* Number of the first `commands` commands that have this row. */
static size_t count_row(const struct help_row *row, size_t commands)
{
    size_t count = 0;
    for (size_t i = 0; row->term && i < commands; i++) {
        struct help_page page = help_page_make(command_table.commands[i].command);
        for (size_t n = 0; n < page.row_count; n++)
            count += page.row[n].term && strcmp(page.row[n].term, row->term) == 0 &&
                     strcmp(page.row[n].text, row->text) == 0;
        help_page_free(&page);
    }
    return count;
}

static bool is_common(const struct help_row *row)
{
    return count_row(row, command_table.count) > 1;
}

static void write_item(FILE *out, const struct help_row *row)
{
    fprintf(out, "- `%s`: ", row->term);
    write_text(out, row->text);
}

static void write_command(FILE *out, const struct command *command)
{
    struct help_page page = help_page_make(command);
    bool in_list = false;
    fprintf(out, "\n### matrig %s\n\n%c%s.\n\n", command->name,
            toupper((unsigned char)command->summary[0]), command->summary + 1);
    write_synopsis(out, command, &page);
    for (size_t i = 0; i < page.row_count; i++) {
        const struct help_row *row = &page.row[i];
        if (is_common(row))
            continue;
        if (row->term && !in_list)
            fputc('\n', out);
        in_list = row->term;
        if (row->term)
            write_item(out, row);
        else
            write_prose(out, row->text);
    }
    help_page_free(&page);
}

static void write_common(FILE *out)
{
    for (size_t i = 0; i < command_table.count; i++) {
        struct help_page page = help_page_make(command_table.commands[i].command);
        for (size_t n = 0; n < page.row_count; n++) {
            if (is_common(&page.row[n]) && count_row(&page.row[n], i) == 0)
                write_item(out, &page.row[n]);
        }
        help_page_free(&page);
    }
}

void reference_commands(FILE *out)
{
    reference_head(out, "Commands",
                   "the descriptors in `host/commands/`, which `matrig COMMAND --help` prints too");
    fputs("`matrig COMMAND --help` prints the complete synopsis of a command and an example. Exit "
          "codes: [exit codes](exit-codes.md). Units of numbers: [units](units.md). Options before "
          "the command:\n\n",
          out);
    for (size_t i = 0; i < command_matrig.part_count; i++) {
        const struct command_part *part = &command_matrig.parts[i];
        if (part->text)
            fprintf(out, "- `%s`: %s\n", part->option.name, part->text);
    }
    fputs("\nOperands and options of several commands:\n\n", out);
    write_common(out);
    for (size_t i = 0; i < command_table.count; i++) {
        const struct command_entry *entry = &command_table.commands[i];
        if (i == 0 || entry->group != entry[-1].group)
            fprintf(out, "\n## %s\n", help_group_title(entry->group));
        write_command(out, entry->command);
    }
}
