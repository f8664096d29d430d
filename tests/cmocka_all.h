/* cmocka with the headers it wants before itself. */
#ifndef MATRIG_TESTS_CMOCKA_ALL_H
#define MATRIG_TESTS_CMOCKA_ALL_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* TEST(name) { ... } is a test, TEST_IN one with its own set-up and teardown; tests/main.c runs
 * them in the order of their lines. TESTS_BETWEEN: set-up before the first, teardown after
 * the last. */
struct unit_test {
    unsigned line;
    struct CMUnitTest test;
};
#define TEST(name) TEST_IN(name, NULL, NULL)
#define TEST_IN(name, setup, teardown)                                                            \
    static void name(void **fixture);                                                             \
    static const struct unit_test name##_test = {__LINE__, {#name, name, setup, teardown, NULL}}; \
    static const struct unit_test *const name##_entry                                             \
        __attribute__((used, section("unit_tests"))) = &name##_test;                              \
    static void name(void **fixture __attribute__((unused)))
#define TESTS_BETWEEN(setup, teardown) \
    CMFixtureFunction tests_setup = setup, tests_teardown = teardown
extern CMFixtureFunction tests_setup, tests_teardown;

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
