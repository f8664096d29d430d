/* The C library's functions of the image against this computer's, sqrt bit by bit. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define memcpy  own_memcpy
#define memmove own_memmove
#define memset  own_memset
#define memcmp  own_memcmp
#define strcmp  own_strcmp
#define strncpy own_strncpy
#define sqrt    own_sqrt
void *memcpy(void *restrict to, const void *restrict from, size_t length);
void *memmove(void *to, const void *from, size_t length);
void *memset(void *to, int byte, size_t length);
int memcmp(const void *a, const void *b, size_t length);
int strcmp(const char *a, const char *b);
char *strncpy(char *restrict to, const char *restrict from, size_t length);
double sqrt(double x);
#include "firmware/libc/libc.c"
#undef memcpy
#undef memmove
#undef memset
#undef memcmp
#undef strcmp
#undef strncpy
#undef sqrt

static void same_root(double x)
{
    double own = own_sqrt(x), host = sqrt(x);
    if (isnan(host))
        assert_true(isnan(own));
    else
        assert_memory_equal(&own, &host, sizeof own);
}

TEST(roots_are_the_same_bits)
{
    static const double special[] = {0.0,
                                     -0.0,
                                     1.0,
                                     2.0,
                                     0.25,
                                     -1.0,
                                     5e-324,
                                     2.2250738585072009e-308,
                                     1.7976931348623157e308,
                                     (double)INFINITY,
                                     -(double)INFINITY,
                                     (double)NAN};
    uint64_t bits = UINT64_C(88172645463325252);
    for (size_t i = 0; i < sizeof special / sizeof special[0]; i++)
        same_root(special[i]);
    for (unsigned i = 0; i < 1000000; i++) {
        double x;
        bits ^= bits << 13;
        bits ^= bits >> 7;
        bits ^= bits << 17;
        uint64_t one = i % 7 == 0 ? bits & (INFINITE_EXPONENT - 1u) >> 11
                                  : bits & ~(UINT64_C(1) << 63);
        memcpy(&x, &one, sizeof x);
        same_root(x);
    }
}

/* At every alignment and each length about the steps of the loops. */
TEST(memory_is_moved)
{
    uint8_t from[128], own[128], host[128];
    for (unsigned i = 0; i < sizeof from; i++)
        from[i] = (uint8_t)(37u * i + 11u);
    for (size_t at = 0; at < 8; at++) {
        for (size_t to = 0; to < 8; to++) {
            for (size_t length = 0; length < 70; length++) {
                memcpy(own, from, sizeof own);
                memcpy(host, from, sizeof host);
                assert_ptr_equal(own_memcpy(own + to, from + at, length), own + to);
                memcpy(host + to, from + at, length);
                assert_memory_equal(own, host, sizeof own);
                assert_ptr_equal(own_memmove(own + to, own + at, length), own + to);
                memmove(host + to, host + at, length);
                assert_memory_equal(own, host, sizeof own);
                assert_ptr_equal(own_memset(own + to, (int)(0x80u + at), length), own + to);
                memset(host + to, (int)(0x80u + at), length);
                assert_memory_equal(own, host, sizeof own);
            }
        }
    }
    assert_true(own_memcmp("abc", "abd", 3) < 0 && own_memcmp("abd", "abc", 3) > 0);
    assert_int_equal(own_memcmp("abc", "abd", 2), 0);
    assert_true(own_memcmp("\x80", "\x7f", 1) > 0);
}

TEST(words_are_compared_and_copied)
{
    char own[8], host[8];
    assert_int_equal(own_strcmp("rom", "rom"), 0);
    assert_true(own_strcmp("rom", "romx") < 0 && own_strcmp("s", "rom") > 0);
    assert_true(own_strcmp("\x80", "a") > 0);
    for (size_t length = 0; length <= sizeof own; length++) {
        memset(own, 'x', sizeof own);
        memset(host, 'x', sizeof host);
        assert_ptr_equal(own_strncpy(own, "memory", length), own);
        memcpy(host, "memory\0", length < 7 ? length : 7);
        if (length == sizeof host)
            host[7] = '\0';
        assert_memory_equal(own, host, sizeof own);
    }
}
