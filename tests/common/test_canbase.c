/* Identifiers on the bus: there and back, and the bases that docs/howto/configure.md says go
 * together. */
#include "common/canbase.h"
#include "tests/cmocka_all.h"

TEST(they_come_back_whatever_the_base)
{
    assert_int_equal(mr_can_id_to_bus(MR_ID_HELLO, 0x190), 0x380);
    assert_int_equal(mr_can_id_to_bus(MR_ID_COMMAND, 0x190), 0x590);
    for (unsigned base = 0; base < 0x800; base++) {
        for (unsigned id = 0; id < 0x800; id += 7) {
            unsigned on_bus = mr_can_id_to_bus((uint16_t)id, (uint16_t)base);
            assert_true(on_bus < 0x800);
            assert_int_equal(mr_can_id_from_bus((uint16_t)on_bus, (uint16_t)base), id);
        }
    }
}

/* Identifiers that a board at one of them shares with a board at another. */
static unsigned shared(const unsigned *bases, unsigned n)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue_messages(&count);
    unsigned used[0x800] = {0}, twice = 0;
    for (unsigned b = 0; b < n; b++) {
        for (size_t i = 0; i < count; i++) {
            assert_true(messages[i].id + bases[b] < 0x800); /* in 11 bits */
            twice += used[messages[i].id + bases[b]]++ != 0;
        }
    }
    return twice;
}

TEST(three_boards_share_no_identifier)
{
    assert_int_equal(shared((const unsigned[]){0, 400, 960}, 3), 0);
    assert_true(shared((const unsigned[]){0, 16}, 2) > 0);
}
