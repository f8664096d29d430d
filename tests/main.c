/* Runs a program's tests (TEST, tests/cmocka_all.h). */
#include <errno.h>
#include <stdlib.h>

#include "tests/cmocka_all.h"

/* Where a program has none of its own. */
CMFixtureFunction tests_setup __attribute__((weak)) = NULL;
CMFixtureFunction tests_teardown __attribute__((weak)) = NULL;

extern const struct unit_test *__start_unit_tests[] __attribute__((weak));
extern const struct unit_test *__stop_unit_tests[] __attribute__((weak));

static int by_line(const void *left, const void *right)
{
    const struct unit_test *const *a = left, *const *b = right;
    return (int)(*a)->line - (int)(*b)->line;
}

int __attribute__((weak)) main(void)
{
    size_t count = (size_t)(__stop_unit_tests - __start_unit_tests);
    const struct unit_test **sorted = calloc(count, sizeof *sorted);
    struct CMUnitTest *tests = calloc(count, sizeof *tests);
    if (!sorted || !tests)
        return 1;
    for (size_t i = 0; i < count; i++)
        sorted[i] = __start_unit_tests[i];
    qsort(sorted, count, sizeof *sorted, by_line);
    for (size_t i = 0; i < count; i++)
        tests[i] = sorted[i]->test;
    int failed = _cmocka_run_group_tests(program_invocation_short_name, tests, count, tests_setup,
                                         tests_teardown);
    free(tests);
    free(sorted);
    return failed;
}
