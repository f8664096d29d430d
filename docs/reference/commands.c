#include <string.h>

#include "docs/reference/reference.h"
#include "host/base/help.h"
#include "host/commands/commands.h"

/* Lines that begin with blanks, and examples, stand as they are. */
static bool is_plain(const char *text)
{
    return strncmp(text, "Example", 7) != 0 && !strstr(text, "\n ") && !strstr(text, "Example:") &&
           text[0] != ' ';
}

static void write_row(FILE *out, const struct help_row *row, bool *in_table)
{
    if (row->term) {
        if (!*in_table)
            fputs("\n| | |\n|---|---|\n", out);
        fputs("| `", out);
        reference_cell(out, row->term);
        fputs("` | ", out);
        reference_cell(out, row->text);
        fputs(" |\n", out);
        *in_table = true;
        return;
    }
    *in_table = false;
    if (is_plain(row->text))
        fprintf(out, "\n%s", row->text);
    else
        fprintf(out, "\n```text\n%s```\n", row->text);
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
    fputs("These options stand before the command:\n\n| | |\n|---|---|\n", out);
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
