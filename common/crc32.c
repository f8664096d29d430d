#include "common/crc32.h"

#include "common/wire.h"

/* Entry i of a table is the register after byte i has been shifted through the reflected
 * polynomial, followed by no or one zero byte. Because this is linear, an entry is the sum (XOR) of
 * the entries of its bits. */
#define TABLE_ENTRY(i, b0, b1, b2, b3, b4, b5, b6, b7)                               \
    (((i)&1 ? b0 : 0u) ^ ((i)&2 ? b1 : 0u) ^ ((i)&4 ? b2 : 0u) ^ ((i)&8 ? b3 : 0u) ^ \
     ((i)&16 ? b4 : 0u) ^ ((i)&32 ? b5 : 0u) ^ ((i)&64 ? b6 : 0u) ^ ((i)&128 ? b7 : 0u))
#define ENTRIES_4(i, ...)                                           \
    TABLE_ENTRY(i, __VA_ARGS__), TABLE_ENTRY((i) + 1, __VA_ARGS__), \
        TABLE_ENTRY((i) + 2, __VA_ARGS__), TABLE_ENTRY((i) + 3, __VA_ARGS__)
#define ENTRIES_16(i, ...)                                                                       \
    ENTRIES_4(i, __VA_ARGS__), ENTRIES_4((i) + 4, __VA_ARGS__), ENTRIES_4((i) + 8, __VA_ARGS__), \
        ENTRIES_4((i) + 12, __VA_ARGS__)
#define ENTRIES_64(i, ...)                                         \
    ENTRIES_16(i, __VA_ARGS__), ENTRIES_16((i) + 16, __VA_ARGS__), \
        ENTRIES_16((i) + 32, __VA_ARGS__), ENTRIES_16((i) + 48, __VA_ARGS__)
#define CRC_TABLE(...)                                                                         \
    {                                                                                          \
        ENTRIES_64(0, __VA_ARGS__), ENTRIES_64(64, __VA_ARGS__), ENTRIES_64(128, __VA_ARGS__), \
            ENTRIES_64(192, __VA_ARGS__)                                                       \
    }

static const uint32_t crc_table[2][256] = {
    CRC_TABLE(0x77073096u, 0xee0e612cu, 0x076dc419u, 0x0edb8832u, 0x1db71064u, 0x3b6e20c8u,
              0x76dc4190u, 0xedb88320u),
    CRC_TABLE(0x191b3141u, 0x32366282u, 0x646cc504u, 0xc8d98a08u, 0x4ac21251u, 0x958424a2u,
              0xf0794f05u, 0x3b83984bu),
};

uint32_t mr_crc32(uint32_t crc, const uint8_t *bytes, size_t length)
{
    crc = ~crc;
    for (; length >= 2; length -= 2) {
        /* Two bytes are processed at a time: the board checks 100 kB per second, and its own image
         * at start. Processing four bytes at a time would need 1.5 times the flash and save a
         * thousandth of the processor time. */
        crc ^= mr_get_u16(&bytes);
        crc = crc >> 16 ^ crc_table[1][crc & 0xffu] ^ crc_table[0][crc >> 8 & 0xffu];
    }
    for (; length; length--)
        crc = crc >> 8 ^ crc_table[0][(crc ^ *bytes++) & 0xffu];
    return ~crc;
}
