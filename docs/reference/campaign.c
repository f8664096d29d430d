/* The tables of a campaign. Columns come from tables.def as the program has them; what a table or a
 * column means stands in comments beside its row there, and these are read from the file. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "docs/reference/reference.h"

#define LINES_MAX 1000
#define LINE_MAX  400

/* A file of the table, line by line. */
struct source {
    char line[LINES_MAX][LINE_MAX];
    size_t count;
};

static void read_source(struct source *source, const char *path)
{
    FILE *in = fopen(path, "r");
    if (!in) {
        fprintf(stderr, "reference: cannot open %s; run this in the root of the sources\n", path);
        exit(3);
    }
    while (source->count < LINES_MAX && fgets(source->line[source->count], LINE_MAX, in))
        source->count++;
    fclose(in);
}

/* The sources, read once. */
static const struct source *sources(void)
{
    static struct source both;
    if (both.count == 0) {
        read_source(&both, "host/store/tables.def");
        read_source(&both, "host/store/tables_journal.def");
    }
    return &both;
}

/* The line of a table or a column; the number of lines when there is none. */
static size_t find_table(const char *row)
{
    char table[100];
    snprintf(table, sizeof table, "TABLE(%s,", row);
    size_t i = 0;
    while (i < sources()->count && strncmp(sources()->line[i], table, strlen(table)) != 0)
        i++;
    return i;
}

static size_t find_column(const char *row, const char *name)
{
    char column[100];
    if (strcmp(name, "id") == 0)
        snprintf(column, sizeof column, "ID(%s", row);
    else
        snprintf(column, sizeof column, "(%s, %s", row, name);
    for (size_t i = 0; i < sources()->count; i++) {
        const char *line = sources()->line[i], *at = strstr(line, column);
        if (line[0] == ' ' && at && (at[strlen(column)] == ',' || at[strlen(column)] == ')'))
            return i;
    }
    return sources()->count;
}

/* What stands between the comment's marks, without the marks' lines; false: the line has no
 * comment. */
static bool comment_in(const char *line, char *text, size_t size)
{
    const char *from = strstr(line, "/* "), *to = strstr(line, " */");
    if (!from || !to || to < from)
        return false;
    snprintf(text, size, "%.*s", (int)(to - from - 3), from + 3);
    return true;
}

/* A comment that ends on the line before, of one line or more. */
static bool comment_before(size_t row, char *text, size_t size)
{
    size_t first = row;
    if (row == 0 || !strstr(sources()->line[row - 1], "*/"))
        return false;
    do
        first--;
    while (first > 0 && !strstr(sources()->line[first], "/*"));
    const char *line = sources()->line[first];
    if (line[strspn(line, " ")] != '/') /* it is that of another row */
        return false;
    text[0] = '\0';
    for (size_t i = first; i < row; i++) {
        const char *from = sources()->line[i] + strspn(sources()->line[i], " /*");
        const char *to = strstr(from, "*/");
        size_t length = to ? (size_t)(to - from) : strcspn(from, "\n");
        while (length > 0 && from[length - 1] == ' ')
            length--;
        size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%.*s", used ? " " : "", (int)length, from);
    }
    return strncmp(text, "----", 4) != 0; /* a heading of several tables */
}

/* C's words for a missing value are NULL in the database. */
static void write_text(FILE *out, const char *text)
{
    static const char *const missing[] = {"STORE_NONE", "NaN"};
    for (const char *at = text; *at;) {
        size_t used = 0;
        for (size_t i = 0; i < sizeof missing / sizeof missing[0]; i++) {
            if (strncmp(at, missing[i], strlen(missing[i])) == 0)
                used = strlen(missing[i]);
        }
        const char one[] = {*at, '\0'};
        reference_cell(out, used > 0 ? "NULL" : one);
        at += used > 0 ? used : 1;
    }
}

static bool comment_of(size_t at, char *text, size_t size)
{
    return at < sources()->count &&
           (comment_in(sources()->line[at], text, size) || comment_before(at, text, size));
}

/* The columns of the table that are written after it: those with a description have a row each. */
#define COLUMNS_MAX 50

static struct {
    const char *row, *table;
    const char *column[COLUMNS_MAX];
    size_t columns;
} open_table;

static void write_table(FILE *out)
{
    char text[1000];
    if (!open_table.table)
        return;
    fprintf(out, "| **%s** | ", open_table.table);
    if (comment_of(find_table(open_table.row), text, sizeof text))
        write_text(out, text);
    fputs(" |\n", out);
    for (size_t i = 0; i < open_table.columns; i++) {
        if (!comment_of(find_column(open_table.row, open_table.column[i]), text, sizeof text))
            continue;
        fprintf(out, "| `%s` | ", open_table.column[i]);
        write_text(out, text);
        fputs(" |\n", out);
    }
    open_table.table = NULL;
}

static void begin_table(const char *row, const char *table)
{
    open_table.row = row;
    open_table.table = table;
    open_table.columns = 0;
}

static void add_column(const char *column)
{
    if (open_table.table && open_table.columns < COLUMNS_MAX)
        open_table.column[open_table.columns++] = column;
}

void reference_campaign(FILE *out)
{
    reference_head(out, "The campaign database",
                   "`host/store/tables.def` and `host/store/tables_journal.def`");
    fputs(
        "A campaign is one SQLite file. Each bold name is a table of this file. The rows below it "
        "explain columns, if the name is not enough. `sqlite3 campaign.db .schema` prints all "
        "columns with types, keys and constraints.\n\n"
        "- `id` is the primary key. `session`, `landing`, `survey` and `simulation` are the `id` "
        "of a row in `sessions`, `landings`, `surveys` or `gage_surveys`, and `simulations`. In "
        "commands, RUN is the `id` of a landing.\n"
        "- A table of [messages](messages.md) has a column for each field. A column name ends with "
        "the unit.\n"
        "- Columns ending in `_us` are times in microseconds. Board times count from the first "
        "scan; host times (`host_us`, `made_us`, `started_us`, `taken_us`) count from 1970. "
        "`block` is "
        "the index of a block (one millisecond of acquisition). `tick` is a count of timer TIM2 "
        "(84 MHz).\n"
        "- NULL means missing. `links` is a set of bits: 1 CAN, 2 serial. `boot` counts restarts "
        "of the board in the session. `idx` is the channel, from 0. `who` is a login name.\n\n"
        "| Table, column | Contents |\n|---|---|\n",
        out);
#define TABLE(row, table)              begin_table(#row, #table);
#define NO_VIEWS                       /* the rows of a query are no table */
#define OWNER(row, column, constraint) add_column(#column);
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) \
    add_column(#column);
#define COMPUTED(row, declaration, field, read)
#define TABLE_END(row, key, put) write_table(out);
#define INDEX_OR_TRIGGER(sql)
#include "host/store/tables.def"
#undef TABLE
#undef VIEW
#undef OWNER
#undef COLUMN
#undef COMPUTED
#undef TABLE_END
#undef INDEX_OR_TRIGGER
}
