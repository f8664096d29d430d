/* The man page. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/version.h"
#include "host/base/help.h"
#include "host/base/help_page.h"

/* Text as roff takes it: nothing in it is a request or an escape, a hyphen can be copied into a
 * shell. Blanks become one. */
static void text(const char *from, size_t length)
{
    static const char special[] = "\\-'\"^~`";
    static const char *const written[] = {"\\e",   "\\-",   "\\(aq", "\\(dq",
                                          "\\(ha", "\\(ti", "\\(ga"};
    bool blank = false, begun = false;
    for (size_t i = 0; i < length; i++) {
        char c = from[i];
        if (c == ' ' || c == '\n') {
            blank = begun;
            continue;
        }
        if (blank)
            putchar(' ');
        if (!begun && (c == '.' || c == '\''))
            fputs("\\&", stdout);
        blank = false;
        begun = true;
        const char *at = c ? strchr(special, c) : NULL;
        if (at)
            fputs(written[at - special], stdout);
        else
            putchar(c);
    }
}

static void bold(const char *from, size_t length)
{
    fputs("\\fB", stdout);
    text(from, length);
    fputs("\\fR", stdout);
}

/* Text that may end with an example, which gets a paragraph of its own. */
static void text_line(const char *line, size_t length)
{
    static const char example[] = "Example:";
    const char *at = memmem(line, length, example, sizeof example - 1);
    size_t before = at ? (size_t)(at - line) : length;
    if (before > 0) {
        text(line, before);
        putchar('\n');
    }
    if (!at)
        return;
    puts(".PP\nExample:\n.PP");
    const char *from = at + sizeof example - 1, *end = line + length;
    if (from == end)
        return; /* on the lines that follow */
    puts(".nf");
    while (from < end) { /* several stand on lines of their own */
        const char *next = memmem(from, (size_t)(end - from), "; matrig ", 9);
        fputs("    ", stdout);
        bold(from, (size_t)((next ? next : end) - from));
        putchar('\n');
        from = next ? next + 2 : end;
    }
    puts(".fi");
}

static size_t blanks(const char *line, size_t length)
{
    size_t count = 0;
    while (count < length && line[count] == ' ')
        count++;
    return count;
}

/* Rows of a list begin a line of their own. */
static void item(const struct help_row *row)
{
    puts(".TP");
    bold(row->term, strlen(row->term));
    putchar('\n');
    for (const char *line = row->text; *line;) {
        size_t length = strcspn(line, "\n"), indent = blanks(line, length);
        if (line != row->text &&
            (line[indent] == '-' || memmem(line + indent, length - indent, "  ", 2)))
            puts(".br");
        text_line(line, length);
        line += length + (line[length] == '\n');
    }
}

struct place_in {
    bool plain;   /* in a paragraph */
    bool example; /* in an example: its lines are commands */
};

static void prose_line(struct place_in *in, const char *line, size_t length)
{
    size_t indent = blanks(line, length);
    if (length == 0) {
        in->plain = in->example = false;
    } else if (in->example && indent > 0) { /* one more line of it */
        puts(".nf");
        fputs("    ", stdout);
        bold(line, length);
        puts("\n.fi");
    } else {
        if (indent == 0 && !in->plain && strncmp(line, "Example:", 8) != 0) /* which has its own */
            puts(".PP");
        else if (indent > 0 &&
                 (line[indent] == '-' || memmem(line + indent, length - indent, "  ", 2)))
            puts(".br"); /* a row of a list */
        in->plain = indent == 0;
        in->example = indent == 0 && memmem(line, length, "Example:", 8);
        text_line(line, length);
    }
}

static void section(const struct command *command)
{
    struct help_page page = help_page_make(command);
    printf(".SS %s\n", command->name);
    bold("matrig", 6);
    putchar(' ');
    bold(command->name, strlen(command->name));
    putchar(' ');
    text(command->words, strlen(command->words));
    puts("\n.PP");
    text(command->summary, strlen(command->summary));
    puts(".");
    for (size_t i = 0; i < page.rows; i++) {
        struct place_in in = {false, false};
        if (page.row[i].term)
            item(&page.row[i]);
        for (const char *line = page.row[i].term ? "" : page.row[i].text; *line;) {
            size_t length = strcspn(line, "\n");
            prose_line(&in, line, length);
            line += length + (line[length] == '\n');
        }
    }
    help_page_free(&page);
}

static void head(void)
{
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    char date[20] = "";
    if (epoch && *epoch) {
        time_t seconds = (time_t)strtoll(epoch, NULL, 10);
        struct tm day;
        if (gmtime_r(&seconds, &day))
            strftime(date, sizeof date, "%Y-%m-%d", &day);
    }
    printf(".\\\" Made by matrig help --man.\n.TH MATRIG 1 \"%s\" \"matrig " VERSION_TEXT
           "\" \"User Commands\"\n",
           date);
    puts(".nh\n.ad l\n.SH NAME\nmatrig \\- instrument for a model landing\\-mat runway");
}

/* The options that stand before the command; those without a text apart. */
static void before(void)
{
    const struct command_part *parts = command_matrig.parts;
    puts(".SH SYNOPSIS");
    bold("matrig", 6);
    for (size_t i = 0; i < command_matrig.count; i++) {
        if (!parts[i].text)
            continue;
        fputs(" [", stdout);
        bold(parts[i].option.name, strlen(parts[i].option.name));
        putchar(']');
    }
    puts(" \\fICOMMAND\\fR ...\n"
         ".SH DESCRIPTION\nLogs landings on a model landing\\-mat runway from a board's CAN bus "
         "and serial line into one campaign file, "
         "simulates the mat, compares, reports and exports.\n"
         ".SH OPTIONS\nThey stand before the command.");
    for (size_t i = 0; i < command_matrig.count; i++) {
        if (!parts[i].text)
            continue;
        puts(".TP");
        bold(parts[i].option.name, strlen(parts[i].option.name));
        printf("\n%c%s.\n", toupper((unsigned char)parts[i].text[0]), parts[i].text + 1);
    }
    puts(".TP\n\\fB\\-\\-version\\fR, \\fB\\-\\-help\\fR\nWhat it is, and what it can do; after a "
         "command: about the command.\n"
         ".SH COMMANDS");
}

static void tail(void)
{
    puts(".SH EXIT STATUS\n"
         ".TP\n0\nOk.\n.TP\n1\nA comparison or limit failed.\n.TP\n2\nUsage.\n.TP\n3\nInput, "
         "output or device.\n"
         ".TP\n4\nMalformed or truncated input.\n.TP\n5\nNumerics refused or failed.\n"
         ".SH ENVIRONMENT\n"
         ".TP\n\\fBNO_COLOR\\fR\nWhen it is set and not empty: no colours.\n"
         ".TP\n\\fBTMPDIR\\fR\nWhere matrig replay and matrig demo put what they share with the "
         "emulated board; else "
         "/tmp.\n"
         ".TP\n\\fBUSER\\fR\nWho says what landing, survey and calibrate note, without \\-\\-who.\n"
         ".TP\n\\fBXDG_DATA_HOME\\fR, \\fBXDG_DATA_DIRS\\fR\nFolders in which matrig/ may hold the "
         "firmware image and the model runway's scene, when they are "
         "neither beside the program nor in ../share/matrig from there.\n"
         ".TP\n\\fBSLURM_ARRAY_TASK_ID\\fR\nWhich shard of a sweep a task does.\n"
         ".SH FILES\nmatrig keeps nothing but in the files that it is given: no settings, no "
         "caches, no history.\n"
         ".SH SEE ALSO\nREADME.md and docs/ of the project, and the README.md of its folders.");
}

void help_man(const struct command_table *table)
{
    head();
    before();
    for (size_t i = 0; i < table->count; i++)
        section(table->commands[i].command);
    tail();
}
