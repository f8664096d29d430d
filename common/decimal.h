/* Numbers as people write them: the one reader for options, files and what is typed.
 *
 *     [blanks] [+|-] digits [. digits] [(e|E) [+|-] digits]        also ".5" and "5."
 *
 * Decimal only: no hexadecimal, inf or nan. What stands behind is the caller's: a unit, an end. */
#ifndef MATRIG_COMMON_DECIMAL_H
#define MATRIG_COMMON_DECIMAL_H

/* `*end`: behind the number; `text` itself when there is none, and the value is 0. Too large:
 * infinite. */
double mr_decimal_read(const char *text, const char **end);

#endif
