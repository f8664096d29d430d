#include "host/base/help_page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/list.h"
#include "host/base/quantity.h"

#define LINE_MOST 80 /* of a line of text that has room for a unit */
#define TERM_MOST 14 /* of an item whose text begins on the same line */

void help_each_part(const struct command *command,
                    void (*each)(void *context, const struct command_part *part), void *context)
{
    for (size_t i = 0; i < command->count; i++) {
        if (command->parts[i].with)
            help_each_part(command->parts[i].with, each, context);
        else
            each(context, &command->parts[i]);
    }
}

/* {low}, {high} and {standard} as numbers, the rest as it is. */
static void put_text(FILE *out, const struct command_part *part)
{
    const struct command_option *option = &part->option;
    const struct {
        const char *name;
        double value;
    } numbers[] = {
        {"{low}", option->low}, {"{high}", option->high}, {"{standard}", option->standard}};
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

/* Of a quantity: what a bare number is in. In a line of its own where the last one is full. */
static void put_unit(FILE *out, const struct command_part *part)
{
    const struct command_option *option = &part->option;
    if (option->kind != OPTION_IS_NUMBER || !quantity_kind_of(option->unit))
        return;
    const char *last = strrchr(part->text, '\n');
    size_t length = strlen(last ? last + 1 : part->text);
    fprintf(out, "%s(%s", length < LINE_MOST ? " " : "\n", option->unit);
    if (option->unit_si)
        fprintf(out, ", with --si %s", option->unit_si);
    fputs("; or with a unit)", out);
}

static char *made_text(const struct command_part *part, const char *before)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        abort();
    fputs(before, out);
    put_text(out, part);
    put_unit(out, part);
    size_t written = strlen(part->text);
    bool prose = !part->term && !part->option.name;
    if (!prose || written == 0 || part->text[written - 1] != ' ') /* else the line goes on */
        fputc('\n', out);
    if (fclose(out) != 0)
        abort();
    return text;
}

static char *made_term(const struct command_part *part)
{
    char *term = NULL;
    const char *argument = part->option.argument;
    int length = part->term        ? asprintf(&term, "%s", part->term)
               : part->option.name ? asprintf(&term, "%s%s%s", part->option.name,
                                              argument ? " " : "", argument ? argument : "")
                                   : 0;
    if (length < 0)
        abort();
    return term;
}

static void add_row(void *context, const struct command_part *part)
{
    struct help_page *page = context;
    if (!part->text)
        return;
    char *term = made_term(part);
    char *text = made_text(part, !part->example          ? ""
                                 : part->text[0] == '\n' ? "Example:"
                                                         : "Example: ");
    struct help_row *last = page->rows ? &page->row[page->rows - 1] : NULL;
    if (!term && last && !last->term) { /* prose goes on */
        char *both = NULL;
        if (asprintf(&both, "%s%s", last->text, text) < 0)
            abort();
        free(last->text);
        free(text);
        last->text = both;
        return;
    }
    if (!list_grow(&page->row, page->rows, sizeof *page->row))
        abort();
    page->row[page->rows++] = (struct help_row){term, text};
}

struct help_page help_page_make(const struct command *command)
{
    struct help_page page = {NULL, 0};
    help_each_part(command, add_row, &page);
    return page;
}

void help_page_free(struct help_page *page)
{
    for (size_t i = 0; i < page->rows; i++) {
        free(page->row[i].term);
        free(page->row[i].text);
    }
    free(page->row);
    *page = (struct help_page){NULL, 0};
}

static void put_item(FILE *out, const struct help_row *row)
{
    int column = HELP_TEXT_COLUMN;
    if (strlen(row->term) > TERM_MOST)
        fprintf(out, "  %s\n%*s", row->term, column, "");
    else
        fprintf(out, "  %-*s ", TERM_MOST, row->term);
    for (const char *line = row->text; *line;) {
        size_t length = strcspn(line, "\n");
        fprintf(out, "%*s%.*s\n", line == row->text ? 0 : column, "", (int)length, line);
        line += length + (line[length] == '\n');
    }
}

char *help_page_text(const struct command *command)
{
    struct help_page page = help_page_make(command);
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        abort();
    for (size_t i = 0; i < page.rows; i++) {
        if (page.row[i].term)
            put_item(out, &page.row[i]);
        else
            fputs(page.row[i].text, out);
    }
    if (fclose(out) != 0)
        abort();
    help_page_free(&page);
    return text;
}
