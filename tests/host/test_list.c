/* Lists that grow one by one: host/base/xmalloc.h. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "host/base/xmalloc.h"

static void keeps_what_it_has(void **state)
{
    uint32_t *list = NULL;
    (void)state;
    for (size_t count = 0; count < 3000; count++) {
        assert_true(list_grow(&list, count, sizeof *list));
        list[count] = (uint32_t)(7 * count);
    }
    for (size_t i = 0; i < 3000; i++)
        assert_int_equal(list[i], 7 * i);
    free(list);
}

/* Elements may be taken off its end, and others added. */
static void grows_again_from_less(void **state)
{
    uint8_t *list = NULL;
    size_t count = 0;
    (void)state;
    for (unsigned turn = 0; turn < 200; turn++) {
        for (unsigned i = 0; i < 5; i++) {
            assert_true(list_grow(&list, count, sizeof *list));
            list[count++] = (uint8_t)turn;
        }
        count -= 4;
        assert_int_equal(list[count - 1], (uint8_t)turn);
    }
    free(list);
}

/* More than any computer has: the list stays. */
static void without_memory_stays(void **state)
{
    uint8_t *list = NULL;
    (void)state;
    assert_true(list_grow(&list, 0, sizeof *list));
    list[0] = 9;
    assert_false(list_grow(&list, 1, SIZE_MAX / 4));
    assert_non_null(list);
    assert_int_equal(list[0], 9);
    free(list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_what_it_has),
        cmocka_unit_test(grows_again_from_less),
        cmocka_unit_test(without_memory_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
