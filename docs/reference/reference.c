/* reference: writes the pages of docs/reference into a folder. usage: reference FOLDER, in the root
 * of the sources. */
#include "docs/reference/reference.h"

#include <limits.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

void reference_head(FILE *out, const char *title, const char *source)
{
    fprintf(out, "# %s\n\n<!-- Made by `make reference`. Do not edit this page: edit %s. -->\n\n",
            title, source);
}

void reference_cell(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '|')
            fputc('\\', out);
        if (*text == '<')
            fputs("&lt;", out);
        else
            fputc(*text == '\n' ? ' ' : *text, out);
    }
}

static bool is_bar(const char *line, size_t at)
{
    return line[at] == '|' && (at == 0 || line[at - 1] != '\\');
}

/* Copies a page; the rows of tables without blanks beside their bars. */
static void copy_page(FILE *out, const char *page)
{
    for (const char *line = page, *next; *line; line = next) {
        next = line + strcspn(line, "\n") + 1;
        for (size_t i = 0; line + i < next; i++) {
            size_t blanks = line[0] == '|' ? strspn(line + i, " ") : 0;
            if (blanks > 0 && (is_bar(line, i - 1) || is_bar(line, i + blanks)))
                i += blanks;
            fputc(line[i], out);
        }
    }
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*write)(FILE *out);
    } pages[] = {
        {"commands", reference_commands},
        {"messages", reference_messages},
        {"configuration", reference_configuration},
        {"scene", reference_scene},
        {"campaign", reference_campaign},
        {"pins", reference_pins},
        {"exit-codes", reference_exit_codes},
        {"bring-up", reference_bringup},
        {"units", reference_units},
    };
    if (argc != 2) {
        fputs("usage: reference FOLDER\n", stderr);
        return 2;
    }
    for (size_t i = 0; i < sizeof pages / sizeof pages[0]; i++) {
        char path[PATH_MAX], *text = NULL;
        size_t length = 0;
        FILE *page = open_memstream(&text, &length);
        pages[i].write(page);
        fclose(page);
        snprintf(path, sizeof path, "%s/%s.md", argv[1], pages[i].name);
        FILE *out = fopen(path, "w");
        if (!out) {
            fprintf(stderr, "reference: cannot write %s; does the folder exist?\n", path);
            return 3;
        }
        copy_page(out, text);
        free(text);
        if (fclose(out) != 0) {
            fprintf(stderr, "reference: cannot write %s; is the disk full?\n", path);
            return 3;
        }
    }
    return 0;
}
