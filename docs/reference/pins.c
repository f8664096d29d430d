/* Pins of each board. Where each is on the package comes from ST's pin database, as the
 * test of the tables has it. */
#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "docs/reference/reference.h"
#include "firmware/boards/tables.h"

#define PLACES   "tests/conformance/pins-%03x.txt"
#define LINE_MAX 500

/* The word of number `n`, from 0, of a line; NULL: it has not so many. */
static const char *word_of(char *line, unsigned n)
{
    char *word = strtok(line, " \n");
    while (word && n--)
        word = strtok(NULL, " \n");
    return word;
}

static FILE *open_places(const struct mr_board *board)
{
    char path[60];
    snprintf(path, sizeof path, PLACES, board->chip);
    FILE *in = fopen(path, "r");
    if (!in) {
        fprintf(stderr, "reference: cannot open %s; run this in the root of the sources\n", path);
        exit(3);
    }
    return in;
}

/* The package's column, counted with the pin's name. */
static unsigned column_of(const struct mr_board *board)
{
    char line[LINE_MAX], copy[LINE_MAX];
    unsigned column = 0;
    FILE *in = open_places(board);
    while (!column && fgets(line, sizeof line, in)) {
        for (unsigned n = 2; strncmp(line, "# PIN ", 6) == 0 && n < 10 && !column; n++) {
            memcpy(copy, line, sizeof copy);
            const char *word = word_of(copy, n);
            if (word && strcmp(word, board->package) == 0)
                column = n - 1;
        }
    }
    fclose(in);
    return column;
}

static unsigned place_of(const struct mr_board *board, const struct board_row *row, unsigned column)
{
    char line[LINE_MAX], name[8];
    unsigned place = 0;
    FILE *in = open_places(board);
    snprintf(name, sizeof name, "P%c%u ", row->port, row->pin);
    while (!place && fgets(line, sizeof line, in)) {
        const char *word = strncmp(line, name, strlen(name)) == 0 ? word_of(line, column) : NULL;
        place = word ? (unsigned)strtoul(word, NULL, 10) : 0;
    }
    fclose(in);
    return place;
}

static void print_use(FILE *out, const struct board_row *row)
{
    switch (row->kind) {
    case BOARD_ROW_ANALOGUE: fprintf(out, "%s", row->function); break;
    case BOARD_ROW_FUNCTION: fprintf(out, "%s (%u)", row->function, row->number); break;
    case BOARD_ROW_OUTPUT:
        fprintf(out, "output, initially %s", row->number ? "high" : "low");
        break;
    case BOARD_ROW_INPUT: fputs("input", out); break;
    }
    fputs(strcmp(row->pull, "UP") == 0 ? ", pull-up" : "", out);
}

static const struct board_row *row_of(const struct board_table *table, const char *signal)
{
    for (size_t i = 0; i < table->row_count; i++) {
        if (strcmp(table->row[i].signal, signal) == 0)
            return &table->row[i];
    }
    return NULL;
}

#define CELL_MAX 200

/* Pin and use of a signal on a board; empty: the board does not have it. */
static void cell_of(unsigned board, const struct board_row *row, char cell[static CELL_MAX])
{
    const struct board_row *own = row_of(board_table_by_number(board), row->signal);
    FILE *out = fmemopen(cell, CELL_MAX, "w");
    if (own) {
        fprintf(out, "P%c%u, %u: ", own->port, own->pin,
                place_of(mr_board_by_number(board), own, column_of(mr_board_by_number(board))));
        print_use(out, own);
        if (strcmp(own->text, row->text) != 0)
            fprintf(out, " (%s)", own->text);
    } else {
        cell[0] = '\0';
    }
    fclose(out);
}

/* The column of a board: the first board with the same package. */
static unsigned shared_column(unsigned board)
{
    unsigned first = 0;
    while (strcmp(mr_board_by_number(first)->package, mr_board_by_number(board)->package) != 0)
        first++;
    return first;
}

static bool has_board(unsigned board)
{
    return mr_board_by_number(board) && board_table_by_number(board);
}

/* "transducer 1" of TRANSDUCER_1 */
static bool repeats_name(const struct board_row *row)
{
    size_t i = 0;
    while (row->text[i] &&
           (row->text[i] == ' ' ? '_' : toupper((unsigned char)row->text[i])) == row->signal[i])
        i++;
    return row->text[i] == '\0' && row->signal[i] == '\0';
}

/* The row of a signal in the table of all boards. In a shared column, a board is named where it
 * differs. */
static void print_signal(FILE *out, const struct board_row *row)
{
    char cell[CELL_MAX], other[CELL_MAX];
    fprintf(out, "| %s | %s |", row->signal, repeats_name(row) ? "" : row->text);
    for (unsigned i = 0; has_board(i); i++) {
        if (shared_column(i) != i)
            continue;
        cell_of(i, row, cell);
        fprintf(out, "%s%s", cell[0] ? " " : "", cell);
        for (unsigned k = i + 1; has_board(k); k++) {
            cell_of(k, row, other);
            if (shared_column(k) == i && strcmp(cell, other) != 0)
                fprintf(out, "; %s %s", mr_board_by_number(k)->name, other);
        }
        fputs(" |", out);
    }
    fputs("\n", out);
}

static bool had_before(unsigned board, const char *signal)
{
    for (unsigned i = 0; i < board; i++) {
        if (row_of(board_table_by_number(i), signal))
            return true;
    }
    return false;
}

void reference_pins(FILE *out)
{
    unsigned columns = 0;
    const struct board_table *table;
    reference_head(out, "Pins", "`firmware/boards/`");
    fputs("All pins float until the firmware configures them, 10 ms after a reset. If a "
          "signal needs a defined level earlier, a resistor outside the chip sets the level. Chip, "
          "supply and other parts of each board: [boards](../howto/boards.md).\n\n"
          "Each cell shows the pin, its number on the package, and the use (in brackets: number "
          "of the alternate function). `pull-up` in a pin column is the pull-up inside the "
          "chip.\n\n| Signal | Purpose |",
          out);
    for (unsigned i = 0; has_board(i); i++) {
        if (shared_column(i) != i)
            continue;
        fprintf(out, " %s", mr_board_by_number(i)->name);
        for (unsigned k = i + 1; has_board(k); k++) {
            if (shared_column(k) == i)
                fprintf(out, ", %s", mr_board_by_number(k)->name);
        }
        fprintf(out, " (%s) |", mr_board_by_number(i)->package);
        columns++;
    }
    fputs("\n|---|---|", out);
    for (; columns > 0; columns--)
        fputs("---|", out);
    fputs("\n", out);
    for (unsigned i = 0; (table = board_table_by_number(i)); i++) {
        for (size_t n = 0; n < table->row_count; n++) {
            if (!had_before(i, table->row[n].signal))
                print_signal(out, &table->row[n]);
        }
    }
}
