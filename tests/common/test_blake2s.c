/* BLAKE2s against RFC 7693 (appendices B and E) and Python's hashlib. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/blake2s.h"
#include "common/splitmix.h"
#include "tests/cmocka_all.h"

/* RFC 7693, appendix B */
TEST(abc_is_hashed_as_in_appendix_b)
{
    static const uint8_t wanted[32] = {0x50, 0x8c, 0x5e, 0x8c, 0x32, 0x7c, 0x14, 0xe2,
                                       0xe1, 0xa7, 0x2b, 0xa3, 0x4e, 0xeb, 0x45, 0x2f,
                                       0x37, 0x45, 0x8b, 0x20, 0x9e, 0xd6, 0x3a, 0x29,
                                       0x4d, 0x99, 0x9b, 0x4c, 0x86, 0x67, 0x59, 0x82};
    uint8_t out[32];
    mr_blake2s(out, sizeof out, NULL, 0, (const uint8_t *)"abc", 3);
    assert_memory_equal(out, wanted, sizeof wanted);
}

/* RFC 7693, appendix E: bytes of a Fibonacci sequence */
static void selftest_seq(uint8_t *out, size_t length, uint32_t seed)
{
    uint32_t a = 0xdead4badu * seed, b = 1;
    for (size_t i = 0; i < length; i++) {
        uint32_t t = a + b;
        a = b;
        b = t;
        out[i] = (uint8_t)(t >> 24);
    }
}

/* The same, its grand hash: six lengths of messages, four of outputs, with a key and without. */
TEST(the_self_test_of_appendix_e_passes)
{
    static const uint8_t wanted[32] = {0x6a, 0x41, 0x1f, 0x08, 0xce, 0x25, 0xad, 0xcd,
                                       0xfb, 0x02, 0xab, 0xa6, 0x41, 0x45, 0x1c, 0xec,
                                       0x53, 0xc5, 0x98, 0xb2, 0x4f, 0x4f, 0xc7, 0x87,
                                       0xfb, 0xdc, 0x88, 0x79, 0x7f, 0x4c, 0x1d, 0xfe};
    static const size_t outs[4] = {16, 20, 28, 32}, ins[6] = {0, 3, 64, 65, 255, 1024};
    uint8_t in[1024], key[32], out[32], all[4 * 6 * 2 * 32];
    size_t n = 0;
    for (unsigned i = 0; i < 4; i++) {
        for (unsigned j = 0; j < 6; j++) {
            selftest_seq(in, ins[j], (uint32_t)ins[j]);
            mr_blake2s(all + n, outs[i], NULL, 0, in, ins[j]);
            n += outs[i];
            selftest_seq(key, outs[i], (uint32_t)outs[i]);
            mr_blake2s(all + n, outs[i], key, outs[i], in, ins[j]);
            n += outs[i];
        }
    }
    mr_blake2s(out, 32, NULL, 0, all, n);
    assert_memory_equal(out, wanted, sizeof wanted);
}

static void write_hex(FILE *file, const uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++)
        fprintf(file, "%02x", bytes[i]);
    fputc(' ', file);
}

#define DRAWN 2000

/* Drawn lengths of output, key and message; each line is one: output, `-` and key, `-` and
 * message. */
TEST(hashlib_computes_the_same)
{
    static const char check[] =
        "python3 -c 'import hashlib,sys\n"
        "n=0\n"
        "for line in sys.stdin:\n"
        "  out,key,text=line.split()\n"
        "  h=hashlib.blake2s(bytes.fromhex(text[1:]),digest_size=len(out)//2,"
        "key=bytes.fromhex(key[1:]))\n"
        "  assert h.hexdigest()==out,line\n"
        "  n+=1\n"
        "sys.exit(0 if n==2000 else 1)'";
    uint64_t state = 7693;
    uint8_t bytes[32 + 300], out[32];
    FILE *python = popen(check, "w");
    assert_non_null(python);
    for (unsigned n = 0; n < DRAWN; n++) {
        for (size_t i = 0; i < sizeof bytes; i++)
            bytes[i] = (uint8_t)mr_splitmix64(&state);
        size_t out_length = 1 + mr_splitmix64(&state) % 32, key_length = mr_splitmix64(&state) % 33;
        size_t length = mr_splitmix64(&state) % 301;
        mr_blake2s(out, out_length, bytes, key_length, bytes + 32, length);
        write_hex(python, out, out_length);
        fputc('-', python);
        write_hex(python, bytes, key_length);
        fputc('-', python);
        write_hex(python, bytes + 32, length);
        fputc('\n', python);
    }
    assert_int_equal(pclose(python), 0);
}
