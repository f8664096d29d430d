/* The table of pins against ST's pin database (tests/conformance/pins.txt), which neither the table
 * nor the emulated board was written from. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_MAX 400

enum kind { ANALOGUE_PIN, FUNCTION_PIN, OUTPUT_PIN, INPUT_PIN, RESERVED_PIN };

static const struct row {
    enum kind kind;
    char port;
    unsigned pin, number;
    const char *signal, *name, *text;
} rows[] = {
#define CONVERTER(converter, input) "ADC" #converter "_IN" #input
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) \
    {ANALOGUE_PIN, #port[0], pin, 0, CONVERTER(converter, input), #SIGNAL, text},
#define FUNCTION(port, pin, number, signal, pull, SIGNAL, text) \
    {FUNCTION_PIN, #port[0], pin, number, signal, #SIGNAL, text},
#define OUTPUT(port, pin, first, pull, SIGNAL, text) \
    {OUTPUT_PIN, #port[0], pin, 0, "", #SIGNAL, text},
#define INPUT(port, pin, pull, SIGNAL, text) {INPUT_PIN, #port[0], pin, 0, "", #SIGNAL, text},
#define RESERVED(port, pin, signal, SIGNAL, text) \
    {RESERVED_PIN, #port[0], pin, 1, signal, #SIGNAL, text},
#include "firmware/boards/zg.def"
};
#define ROWS (sizeof rows / sizeof rows[0])

/* What the database says of a pin; empty: it has none such. */
static void look_up(const struct row *row, char line[LINE_MAX])
{
    char name[8];
    FILE *file = fopen("tests/conformance/pins.txt", "r");
    assert_non_null(file);
    snprintf(name, sizeof name, "P%c%u ", row->port, row->pin);
    while (fgets(line, LINE_MAX, file)) {
        if (strncmp(line, name, strlen(name)) == 0) {
            fclose(file);
            line[strcspn(line, "\n")] = ' ';
            return;
        }
    }
    fclose(file);
    line[0] = '\0';
}

static void each_pin_does_what_it_can(void **state)
{
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        char line[LINE_MAX], wanted[40];
        const struct row *row = &rows[i];
        look_up(row, line);
        if (!line[0])
            fail_msg("%s: there is no P%c%u", row->name, row->port, row->pin);
        if (!row->signal[0])
            continue;
        if (row->kind == ANALOGUE_PIN)
            snprintf(wanted, sizeof wanted, " %s ", row->signal);
        else
            snprintf(wanted, sizeof wanted, " %s:%u ", row->signal, row->number);
        if (!strstr(line, wanted))
            fail_msg("%s: P%c%u has no%s: %s", row->name, row->port, row->pin, wanted, line);
    }
}

/* PA13, PA14: debugger. PH0, PH1: crystal. PA11, PA12: USB of the boot ROM. PC14, PC15: clock. */
static void no_pin_is_given_twice(void **state)
{
    static const char *const taken[] = {"A13", "A14", "H0", "H1", "A11", "A12", "C14", "C15"};
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        char name[8];
        snprintf(name, sizeof name, "%c%u", rows[i].port, rows[i].pin);
        for (size_t k = 0; k < sizeof taken / sizeof taken[0]; k++)
            assert_string_not_equal(name, taken[k]);
        for (size_t k = 0; k < i; k++)
            assert_false(rows[i].port == rows[k].port && rows[i].pin == rows[k].pin);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_pin_does_what_it_can),
        cmocka_unit_test(no_pin_is_given_twice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
