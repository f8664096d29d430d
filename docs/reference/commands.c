#include <stdlib.h>
#include <string.h>

#include "docs/reference/reference.h"
#include "host/base/help.h"
#include "host/base/xmalloc.h"
#include "host/commands/commands.h"

/* In a cell. A line that begins with blanks stands as it is, on a line of its own. */
static void write_text(FILE *out, const char *text)
{
    bool is_broken = false;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n"), blanks = strspn(line, " ");
        bool is_code = blanks > 0;
        size_t skipped = blanks < 2 ? blanks : 2;
        char *part = xasprintf("%.*s", (int)(length - skipped), line + skipped);
        if (line != text)
            fputs(is_code || is_broken ? "<br>" : " ", out);
        fputs(is_code ? "`" : "", out);
        reference_cell(out, part);
        fputs(is_code ? "`" : "", out);
        free(part);
        is_broken = is_code;
        line += length + (line[length] == '\n');
    }
}

/* Paragraphs; an example, up to an empty line, is a block. */
static void write_prose(FILE *out, const char *text)
{
    bool is_example = false;
    text += strspn(text, "\n");
    if (strncmp(text, "Example", 7) != 0)
        fputc('\n', out);
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n");
        if (!is_example && strncmp(line, "Example", 7) == 0) {
            fputs("\n```text\n", out);
            is_example = true;
        } else if (is_example && length == 0) {
            fputs("```\n", out);
            is_example = false;
        }
        fprintf(out, "%.*s\n", (int)length, line);
        line += length + (line[length] == '\n');
    }
    if (is_example)
        fputs("```\n", out);
}

static void write_row(FILE *out, const struct help_row *row, bool *in_table)
{
    if (!row->term) {
        write_prose(out, row->text);
        *in_table = false;
        return;
    }
    if (!*in_table)
        fputs("\n| | |\n|---|---|\n", out);
    fputs("| `", out);
    reference_cell(out, row->term);
    fputs("` | ", out);
    write_text(out, row->text);
    fputs(" |\n", out);
    *in_table = true;
}

static void write_command(FILE *out, const struct command *command)
{
    struct help_page page = help_page_make(command);
    bool in_table = false;
    fprintf(out, "\n### matrig %s\n\n%s.\n\n```text\nmatrig %s %s\n```\n", command->name,
            command->summary, command->name, command->words);
    for (size_t i = 0; i < page.rows; i++)
        write_row(out, &page.row[i], &in_table);
    help_page_free(&page);
}

void reference_commands(FILE *out)
{
    reference_head(out, "Commands",
                   "the descriptors in `host/commands/`, which `matrig COMMAND --help` prints too");
    fputs("Put these options before the command:\n\n| | |\n|---|---|\n", out);
    for (size_t i = 0; i < command_matrig.count; i++) {
        const struct command_part *part = &command_matrig.parts[i];
        if (part->text)
            fprintf(out, "| `%s` | %s |\n", part->option.name, part->text);
    }
    for (size_t i = 0; i < command_table.count; i++) {
        const struct command_entry *entry = &command_table.commands[i];
        if (i == 0 || entry->group != entry[-1].group)
            fprintf(out, "\n## %s\n", help_group_title(entry->group));
        write_command(out, entry->command);
    }
}
