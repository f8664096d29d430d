/* Parser for decimal numbers in text, used for all options, files and typed input.
 *
 *     [blanks] [+|-] digits [. digits] [(e|E) [+|-] digits]        also ".5" and "5."
 *
 * Hexadecimal, inf and nan are not accepted. The caller checks the text after the number (a unit,
 * the end of the line). */
#ifndef MATRIG_COMMON_DECIMAL_H
#define MATRIG_COMMON_DECIMAL_H

/* Returns the number, and in `*end` the position after it. Without a number, `*end` is `text` and
 * the value is 0. A number too large for a double is returned as infinity. */
double mr_decimal_parse(const char *text, const char **end);

#endif
