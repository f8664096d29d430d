#include "common/decimal.h"

#include <stdlib.h>
#include <string.h>

#define DIGITS "0123456789"

static size_t get_sign_length(const char *text)
{
    return *text == '+' || *text == '-';
}

/* Returns the length of the number at `text`; 0 if there is none. */
static size_t get_number_length(const char *text)
{
    size_t n = get_sign_length(text), digits = strspn(text + n, DIGITS);
    n += digits;
    if (text[n] == '.') {
        size_t behind = strspn(text + n + 1, DIGITS);
        digits += behind;
        n += digits ? 1 + behind : 0;
    }
    if (digits && (text[n] == 'e' || text[n] == 'E')) {
        size_t sign = get_sign_length(text + n + 1), power = strspn(text + n + 1 + sign, DIGITS);
        n += power ? 1 + sign + power : 0;
    }
    return digits ? n : 0;
}

double mr_decimal_parse(const char *text, const char **end)
{
    const char *number = text + strspn(text, " \t\n\v\f\r");
    size_t length = get_number_length(number);
    char *read;
    *end = length ? number + length : text;
    if (!length)
        return 0.0;
    double value = strtod(number, &read);
    if (read == *end)
        return value;
    /* strtod has read a hexadecimal number such as "0x10", of which only the 0 is accepted here */
    return *number == '-' ? -0.0 : 0.0;
}
