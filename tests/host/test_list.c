/* Lists that grow one by one: host/base/xmalloc.h. */
#include <stdlib.h>

#include "host/base/xmalloc.h"
#include "tests/cmocka_all.h"

TEST(keeps_what_it_has)
{
    uint32_t *list = NULL;
    for (size_t count = 0; count < 3000; count++) {
        assert_true(list_grow(&list, count, sizeof *list));
        list[count] = (uint32_t)(7 * count);
    }
    for (size_t i = 0; i < 3000; i++)
        assert_int_equal(list[i], 7 * i);
    free(list);
}

/* Elements may be taken off its end, and others added. */
TEST(grows_again_from_less)
{
    uint8_t *list = NULL;
    size_t count = 0;
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
TEST(without_memory_stays)
{
    uint8_t *list = NULL;
    assert_true(list_grow(&list, 0, sizeof *list));
    list[0] = 9;
    assert_false(list_grow(&list, 1, SIZE_MAX / 4));
    assert_non_null(list);
    assert_int_equal(list[0], 9);
    free(list);
}
