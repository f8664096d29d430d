/* What the name of a column says, in the first line of a file of points (points.h). A name is
 * understood wholly or not at all: what could change a unit would make every value another one.
 *
 *     mm    load (lb)    d3_mm    Weg in mm    true value [kN]    ADC counts
 *
 * A name holds words: of a unit, of codes, and words that describe (value, load, reference ...:
 * column.c lists them), d1 to d8, t1 to t14, ch1 ... and adc1 ... among them. A word that matrig
 * does not know is a description only beside codes, or beside a unit that stands in brackets or
 * behind `in`. Digits, / * ^ % and other signs, words of scale (half, tenths, kilo, per, thou) and
 * units that matrig does not convert (daN, kip, um) are never passed over. */
#ifndef MATRIG_HOST_CALIBRATE_COLUMN_H
#define MATRIG_HOST_CALIBRATE_COLUMN_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/units.h"

#define COLUMN_ODD 40u

struct column {
    bool codes, volts;
    const struct unit_word *unit; /* NULL: none */
    bool units;                   /* more than one, or one beside codes */
    char odd[COLUMN_ODD];         /* the first word or sign that cannot be placed; "": all can */
};

void column_read(const char *text, size_t length, struct column *column);

#endif
