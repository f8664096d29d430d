/* Where on a CAN bus boards are, as people write it. Which boards share identifiers is counted here
 * from the identifiers of docs/reference/messages.md, by hand. */
#include <stdio.h>
#include <string.h>

#include "host/link/link.h"
#include "tests/host/scratch.h"

TEST(bases_of_links)
{
    static const struct {
        const char *given, *link;
        unsigned count;
        uint16_t base[LINK_BOARDS];
        const char *text;
    } cases[] = {
        {"can0", "can0", 1, {0}, ""},
        {"can0@0x190", "can0", 1, {400}, "@0x190"},
        {"can:can0:board@400", "can:can0:board", 1, {400}, "@0x190"},
        {"can:can0:board@0X3C0", "can:can0:board", 1, {960}, "@0x3c0"},
        {"unix:bus.sock@0,0x190", "unix:bus.sock", 2, {0, 400}, "@0x000,0x190"},
        {"can0@0x3c0,0,0x190", "can0", 3, {960, 0, 400}, "@0x3c0,0x000,0x190"},
        {"can0@1022", "can0", 1, {1022}, "@0x3fe"},
        /* names, not bases */
        {"file:me@home.log", "file:me@home.log", 1, {0}, ""},
        {"me@", "me@", 1, {0}, ""},
        {"file:build/test-tmp/a@1", "file:build/test-tmp/a@1", 1, {0}, ""},
        {"build/test-tmp/a@1", "build/test-tmp/a@1", 1, {0}, ""},
    };
    scratch_begin();
    FILE *file = fopen("build/test-tmp/a@1", "w");
    assert_non_null(file);
    fclose(file);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char spec[200], text[LINK_BASES_TEXT];
        struct link_bases bases;
        struct error error = {0};
        snprintf(spec, sizeof spec, "%s", cases[i].given);
        assert_int_equal(link_take_bases(spec, &bases, &error), MR_OK);
        assert_string_equal(spec, cases[i].link);
        assert_int_equal(bases.count, cases[i].count);
        assert_memory_equal(bases.base, cases[i].base, bases.count * sizeof bases.base[0]);
        link_bases_text(&bases, text);
        assert_string_equal(text, cases[i].text);
    }
    remove("build/test-tmp/a@1");
}

TEST(refused_bases)
{
    static const struct {
        const char *given, *names;
    } cases[] = {
        {"can0@0x3ff", "base 0x3ff: can0@0x3ff; 0x3fe at most"},
        {"can0@1023", "0x3fe at most"},
        {"can0@0x", "no base of CAN identifiers: '0x' of can0@0x"},
        {"can0@12ab", "'12ab'"},
        {"can0@0,", "''"},
        {"can0@0,0x190,0x3c0,0x3e0,0x3f0", "more than 4 boards"},
        /* 0x080 + 0x080 is 0x100 + 0 */
        {"can0@0,0x80", "share identifiers (0x100)"},
        {"can0@0x190,0x190", "share identifiers (0x200)"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char spec[200];
        struct link_bases bases;
        struct error error = {0};
        snprintf(spec, sizeof spec, "%s", cases[i].given);
        assert_int_equal(link_take_bases(spec, &bases, &error), MR_USAGE);
        assert_error(&error, MR_USAGE, cases[i].names);
    }
}

/* A base moves every message within 11 bits, and back; what is below comes out beyond the
 * catalogue. */
TEST(there_and_back)
{
    assert_int_equal(mr_can_to_bus(0x400, 0x190), 0x590);
    assert_int_equal(mr_can_from_bus(0x590, 0x190), 0x400);
    assert_int_equal(mr_can_from_bus(0x080, 0x190), 0x6f0);
    for (uint16_t id = 0; id <= 0x7ff; id++) {
        uint16_t of_board = mr_can_from_bus(id, MR_CAN_BASE_MOST);
        assert_int_equal(mr_can_to_bus(of_board, MR_CAN_BASE_MOST), id);
        assert_true(id >= MR_CAN_BASE_MOST || !mr_message_find(of_board));
    }
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);
    assert_int_equal(messages[count - 1].id + MR_CAN_BASE_MOST, 0x7ff);
}
