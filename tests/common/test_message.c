#include "common/catalogue.h"

#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"

/* 41.2 ft * 500 = 20600 = 0x5078, 35.5 ft/s * 1000 = 0x8aac, missing = 0x8000: worked out by
 * hand. */
TEST(a_message_is_read_into_its_own_member)
{
    const uint8_t motion[8] = {0x78, 0x50, 0xac, 0x8a, 0x00, 0x80, 0x34, 0x12};
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, MR_ID_MOTION, motion, 8), MR_OK);
    assert_int_equal(message.index, MR_INDEX_MOTION);
    assert_string_equal(message.info->name, "motion");
    assert_near(message.as.motion.position_ft, 41.2, 0.001);
    assert_near(message.as.motion.speed_ft_s, 35.5, 0.001);
    assert_true(isnan(message.as.motion.deceleration_ft_s2));
    assert_int_equal(message.block16, 0x1234);
    assert_memory_equal(message.payload, motion, 8);
}

TEST(what_has_no_block16_says_so)
{
    const uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, MR_ID_CLOCK, bytes, 8), MR_OK);
    assert_int_equal(message.block16, -1);
    /* at_block16 is about another moment */
    assert_int_equal(mr_message_decode(&message, MR_ID_BAND_EVENT, bytes, 8), MR_OK);
    assert_int_equal(message.block16, -1);
}

TEST(another_length_or_identifier_is_refused)
{
    const uint8_t bytes[9] = {0};
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, MR_ID_MOTION, bytes, 7), MR_TRUNCATED);
    assert_int_equal(mr_message_decode(&message, MR_ID_MOTION, bytes, 9), MR_TOO_LONG);
    assert_int_equal(mr_message_decode(&message, 0x7ff, bytes, 8), MR_UNKNOWN);
    assert_int_equal(mr_message_decode(&message, MR_ID_BLOCK, bytes, 8), MR_UNKNOWN);
}

/* Bytes that are read and put again by the message's own functions are the same: `as` holds each
 * message. */
TEST(every_message_is_read)
{
    uint8_t bytes[MR_MESSAGE_BYTES_MAX], again[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = 0; i < sizeof bytes; i++)
        bytes[i] = (uint8_t)(17 * i + 3);
    unsigned count = 0;
    struct mr_message message;
#define MESSAGE(name, NAME, id, direction, text)                                                  \
    assert_int_equal(mr_message_decode(&message, id, bytes, mr_message_find(id)->length), MR_OK); \
    assert_int_equal(mr_##name##_put(&message.as.name, again), message.info->length);             \
    assert_memory_equal(again, bytes, message.info->length);                                      \
    count++;
#include "common/catalogue.def"
    assert_int_equal(count, MR_INDEX_BLOCK);
}

/* A campaign's event is of the block that its message is of. */
TEST(the_block_is_all_of_it_or_its_low_bits)
{
    struct mr_message message;
    const uint8_t bytes[8] = {1, 2, 3, 4, 0x78, 0x56, 0x34, 0x12};
    assert_int_equal(mr_message_decode(&message, MR_ID_LANDING, bytes, 8), MR_OK);
    assert_int_equal(message.block, 0x12345678);
    assert_int_equal(message.block16, -1);
    assert_int_equal(mr_message_decode(&message, MR_ID_MOTION, bytes, 8), MR_OK);
    assert_int_equal(message.block, -1);
    assert_int_equal(message.block16, 0x1234);
    /* the newest block, not that of what it tells */
    assert_int_equal(mr_message_decode(&message, MR_ID_CLOCK, bytes, 8), MR_OK);
    assert_int_equal(message.block, -1);
#define EVENT(name, NAME, kind, code, detail, value)                              \
    assert_int_equal(mr_message_decode(&message, MR_ID_##NAME, bytes, 8), MR_OK); \
    assert_true(message.block >= 0 || message.block16 >= 0);
#include "common/catalogue.def"
}
