/* Pins of the board. Where each is on the package comes from ST's pin database, as the test of the
 * table has it. */
#include <stdlib.h>
#include <string.h>

#include "docs/reference/reference.h"

#define PLACES   "tests/conformance/pins.txt"
#define LINE_MAX 400

struct row {
    const char *port;
    unsigned pin;
    const char *use, *pull, *name, *text;
};

static const struct row rows[] = {
#define PULLED_NONE ""
#define PULLED_UP   "up"
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) \
    {#port, pin, "ADC" #converter " input " #input, "", #SIGNAL, text},
#define FUNCTION(port, pin, number, signal, pull, SIGNAL, text) \
    {#port, pin, signal " (" #number ")", PULLED_##pull, #SIGNAL, text},
#define OUTPUT(port, pin, first, pull, SIGNAL, text) \
    {#port, pin, first ? "output, first high" : "output, first low", PULLED_##pull, #SIGNAL, text},
#define INPUT(port, pin, pull, SIGNAL, text) {#port, pin, "input", PULLED_##pull, #SIGNAL, text},
#define RESERVED(port, pin, signal, SIGNAL, text) \
    {#port, pin, signal[0] ? "reserved, " signal : "reserved", "", #SIGNAL, text},
#include "firmware/boards/zg.def"
};

static unsigned place_of(const struct row *row)
{
    char line[LINE_MAX], name[8];
    unsigned place = 0;
    FILE *in = fopen(PLACES, "r");
    if (!in) {
        fprintf(stderr, "reference: cannot open %s; run this in the root of the sources\n", PLACES);
        exit(3);
    }
    snprintf(name, sizeof name, "P%s%u ", row->port, row->pin);
    while (!place && fgets(line, sizeof line, in)) {
        if (strncmp(line, name, strlen(name)) == 0)
            place = (unsigned)strtoul(line + strlen(name), NULL, 10);
    }
    fclose(in);
    return place;
}

void reference_pins(FILE *out)
{
    reference_head(out, "Pins", "`firmware/boards/zg.def`");
    fputs("Of the STM32F407ZG, LQFP144. Until the firmware has set its pins (10 ms after a reset) "
          "all of them float: what must be\nat a level then is pulled outside the chip.\n\n"
          "| pin | LQFP144 | use | pulled inside | signal | what |\n|---|---|---|---|---|---|\n",
          out);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct row *row = &rows[i];
        fprintf(out, "| P%s%u | %u | %s | %s | %s | %s |\n", row->port, row->pin, place_of(row),
                row->use, row->pull, row->name, row->text);
    }
}
