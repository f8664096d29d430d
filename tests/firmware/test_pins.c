/* The rows of each board against ST's pin databases (tests/conformance/pins*.txt) and against what
 * else is soldered to its pins (tests/conformance/soldered.txt), from which neither the rows nor
 * the emulated board were written. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/image.h"
#include "firmware/boards/tables.h"
#include "tests/cmocka_all.h"

#define LINE_MAX 500
#define SOLDERED "tests/conformance/soldered.txt"

/* The database of a chip, by its device id. */
static const char *database_of(unsigned chip)
{
    static char path[60];
    snprintf(path, sizeof path, "tests/conformance/pins-%03x.txt", chip);
    return path;
}

/* Number of a package's column in the database, from 1; 0: it has none. */
static unsigned column_of(const struct mr_board *board)
{
    char line[LINE_MAX];
    unsigned column = 0;
    FILE *file = fopen(database_of(board->chip), "r");
    assert_non_null(file);
    while (!column && fgets(line, sizeof line, file)) {
        if (strncmp(line, "# PIN ", 6) != 0)
            continue;
        unsigned n = 0;
        for (char *word = strtok(line + 6, " \n"); word && !column; word = strtok(NULL, " \n")) {
            n++;
            column = strcmp(word, board->package) == 0 ? n : 0;
        }
    }
    fclose(file);
    return column;
}

/* What the database says of a pin, from its first position on; NULL: it has none such. */
static const char *look_up(const struct mr_board *board, const struct board_row *row)
{
    static char line[LINE_MAX];
    char name[8];
    const char *found = NULL;
    FILE *file = fopen(database_of(board->chip), "r");
    assert_non_null(file);
    snprintf(name, sizeof name, "P%c%u ", row->port, row->pin);
    while (!found && fgets(line, sizeof line, file)) {
        if (strncmp(line, name, strlen(name)) == 0)
            found = line + strlen(name);
    }
    fclose(file);
    line[strcspn(line, "\n")] = ' ';
    return found;
}

static unsigned position(const char *columns, unsigned column)
{
    char *end = NULL;
    unsigned long place = 0;
    for (unsigned i = 0; i < column; i++, columns = end)
        place = strtoul(columns, &end, 10);
    return (unsigned)place;
}

/* NULL, or what is wrong with a row on a board. */
static const char *wrong_with(const struct mr_board *board, const struct board_row *row)
{
    static char why[LINE_MAX + 100];
    char wanted[40];
    const char *line = look_up(board, row);
    if (!line || position(line, column_of(board)) == 0) {
        snprintf(why, sizeof why, "%s: %s of the %s has no P%c%u", row->signal, board->package,
                 board->part, row->port, row->pin);
        return why;
    }
    if (row->kind == BOARD_ROW_ANALOGUE)
        snprintf(wanted, sizeof wanted, " %s ", row->function);
    else
        snprintf(wanted, sizeof wanted, " %s:%u ", row->function, row->number);
    if (!row->function[0] || strstr(line, wanted))
        return NULL;
    snprintf(why, sizeof why, "%s: P%c%u has no%s: %s", row->signal, row->port, row->pin, wanted,
             line);
    return why;
}

static const struct board_table *next_board(unsigned *number, const struct mr_board **board)
{
    *board = mr_board_by_number(*number);
    return *board ? board_table_by_number((*number)++) : NULL;
}

#define EACH_BOARD(board, table)                                                    \
    const struct mr_board *board;                                                   \
    unsigned boards_told = 0;                                                       \
    for (const struct board_table *table = next_board(&boards_told, &board); table; \
         table = next_board(&boards_told, &board))

TEST(each_pin_does_what_it_can)
{
    EACH_BOARD(board, table)
    {
        assert_true(column_of(board) > 0);
        for (size_t i = 0; i < table->row_count; i++) {
            const char *why = wrong_with(board, &table->row[i]);
            if (why)
                fail_msg("%s: %s", board->name, why);
        }
        print_message("# %s: %zu pins\n", board->name, table->row_count);
    }
    assert_true(boards_told >= 2);
}

/* The rows of one board on the chip of another: what is wrong with them is known. */
TEST(a_pin_that_is_not_there_is_found)
{
    const struct board_table *zg = board_table_by_number(MR_BOARD_ZG);
    unsigned missing = 0;
    for (size_t i = 0; i < zg->row_count; i++)
        missing += wrong_with(mr_board_by_number(MR_BOARD_DISCOVERY), &zg->row[i]) != NULL;
    assert_int_equal(missing, 8); /* PF3 to PF10: LQFP100 has no port F */
    const struct board_row serial = {BOARD_ROW_FUNCTION, 'C', 6, "USART6_TX", 7, "NONE", "X", ""};
    assert_non_null(wrong_with(mr_board_by_number(MR_BOARD_DISCOVERY), &serial)); /* it is 8 */
    const struct board_row input = {BOARD_ROW_ANALOGUE, 'C', 4, "ADC3_IN14", 0, "NONE", "X", ""};
    assert_non_null(wrong_with(mr_board_by_number(MR_BOARD_ZG), &input)); /* ADC1 and ADC2 alone */
}

/* PA13, PA14: debugger. PH0, PH1: crystal. PA11, PA12: USB of the boot ROM. PC14, PC15: clock. */
TEST(no_pin_is_given_twice)
{
    static const char *const taken[] = {"A13", "A14", "H0", "H1", "A11", "A12", "C14", "C15"};
    EACH_BOARD(board, table)
    {
        for (size_t i = 0; i < table->row_count; i++) {
            const struct board_row *row = &table->row[i];
            char name[8];
            snprintf(name, sizeof name, "%c%u", row->port, row->pin);
            for (size_t k = 0; k < sizeof taken / sizeof taken[0]; k++)
                assert_string_not_equal(name, taken[k]);
            for (size_t k = 0; k < i; k++)
                assert_false(row->port == table->row[k].port && row->pin == table->row[k].pin);
        }
    }
}

/* Pins that are used although something else is soldered there, and why that can be. */
static const struct {
    const char *board, *pin, *why;
} shared[] = {
    {"discovery", "PA4", "CS43L22 in reset: its input"},
    {"discovery", "PA5", "LIS302DL not selected: its input"},
    {"discovery", "PA6", "LIS302DL not selected: its output is off"},
    {"discovery", "PA7", "LIS302DL not selected: its input"},
    {"discovery", "PB3", "SWO of the ST-LINK: an input there"},
    {"discovery", "PB6", "CS43L22 in reset, and its pull-up is wanted"},
    {"discovery", "PB10", "microphone's clock: its input"},
    {"discovery", "PC0", "USB power switch: held off by the row itself"},
    {"discovery", "PC7", "CS43L22 in reset: its input"},
    {"discovery", "PD4", "CS43L22's reset: held by the row itself"},
    {"discovery", "PD12", "LED through its resistor"},
    {"discovery", "PD13", "LED through its resistor"},
    {"discovery", "PE3", "LIS302DL's select: held by the row itself"},
    {"nucleo446", "PB0", "LD1: its solder bridge is opened"},
    {"nucleo446", "PB7", "LD2: its solder bridge is opened"},
    {"nucleo446", "PB14", "LD3: its solder bridge is opened"},
};

static bool may_be_shared(const char *board, const char *pin)
{
    for (size_t i = 0; i < sizeof shared / sizeof shared[0]; i++) {
        if (strcmp(shared[i].board, board) == 0 && strcmp(shared[i].pin, pin) == 0)
            return true;
    }
    return false;
}

/* How many of a board's rows lie on soldered pins; what else is there must be known. */
static unsigned rows_on_soldered(const struct mr_board *board, const struct board_table *table)
{
    char line[LINE_MAX], name[20], pin[8];
    unsigned found = 0;
    FILE *file = fopen(SOLDERED, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%19s %7s", name, pin) != 2 || strcmp(name, board->name) != 0)
            continue;
        for (size_t i = 0; i < table->row_count; i++) {
            char used[8];
            snprintf(used, sizeof used, "P%c%u", table->row[i].port, table->row[i].pin);
            if (strcmp(used, pin) != 0)
                continue;
            found++;
            if (!may_be_shared(board->name, pin))
                fail_msg("%s: %s is at %s", board->name, table->row[i].signal, line);
        }
    }
    fclose(file);
    return found;
}

TEST(what_is_soldered_there_is_known)
{
    unsigned known = 0, found = 0;
    EACH_BOARD(board, table)
    {
        found += rows_on_soldered(board, table);
        for (size_t i = 0; i < sizeof shared / sizeof shared[0]; i++)
            known += strcmp(shared[i].board, board->name) == 0;
    }
    assert_int_equal(found, known); /* and nothing is excused that is not used */
    assert_true(found > 10);
}

/* A converter scans transducers on ADC3 and all others on ADC1; staircase and reference are always
 * there; the serial port's rows are those of the port that the facts name. */
TEST(facts_and_rows_agree)
{
    EACH_BOARD(board, table)
    {
        char serial[20];
        unsigned transducers = 0, others = 0, serials = 0;
        snprintf(serial, sizeof serial, "USART%ld_", board_constant_value(table, "SERIAL"));
        for (size_t i = 0; i < table->row_count; i++) {
            const struct board_row *row = &table->row[i];
            bool transducer = strncmp(row->signal, "TRANSDUCER_", 11) == 0;
            serials += strncmp(row->function, serial, strlen(serial)) == 0;
            if (row->kind != BOARD_ROW_ANALOGUE)
                continue;
            assert_int_equal(strncmp(row->function, transducer ? "ADC3_" : "ADC1_", 5), 0);
            *(transducer ? &transducers : &others) += 1;
        }
        assert_int_equal(serials, 2);
        assert_int_equal(board_constant_value(table, "NUMBER"),
                         mr_board_number_by_name(board->name));
        assert_in_range(transducers, 1, MR_TRANSDUCERS);
        assert_in_range(others, 2, MR_ADC1_CHANNELS);
        print_message("# %s: %u transducers, %u gages, staircase, reference\n", board->name,
                      transducers, others - 2);
    }
}
