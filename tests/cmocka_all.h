/* cmocka with the headers it wants before itself. */
#ifndef MATRIG_TESTS_CMOCKA_ALL_H
#define MATRIG_TESTS_CMOCKA_ALL_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* cmocka 1.1.5 compares floats only in single precision. */
#define assert_near(actual, expected, tolerance)                                         \
    do {                                                                                 \
        double actual_ = (double)(actual), expected_ = (double)(expected);               \
        if (!(actual_ - expected_ <= (tolerance) && expected_ - actual_ <= (tolerance))) \
            fail_msg(#actual " is %.12g, expected %.12g within %g", actual_, expected_,  \
                     (double)(tolerance));                                               \
    } while (0)

#endif
