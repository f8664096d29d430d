/* Divisions, roots and names of functions against binutils' objdump and nm, which share
 * nothing with ours. */
#include <inttypes.h>

#include "hil/debug/profile.h"
#include "tests/hil/bench.h"

#define FIRMWARE "build/firmware/matrig.elf"

TEST(test_slow_instructions)
{
    unsigned seen = 0, count = 0;
    char line[256];
    FILE *dump = popen("arm-none-eabi-objdump -d " FIRMWARE " build/tests/hil/images/core.elf",
                       "r");
    assert_non_null(dump);
    while (fgets(line, sizeof line, dump)) {
        unsigned first = 0, second = 0;
        char mnemonic[32];
        /* `ADDRESS:\tHHHH HHHH \tmnemonic\toperands`; data in the code are `.word` */
        const char *codes = strstr(line, ":\t"), *text = codes ? strchr(codes + 2, '\t') : NULL;
        if (!text || text - codes > 16 || sscanf(text, " %31s", mnemonic) != 1)
            continue;
        char digits[16] = "";
        memcpy(digits, codes + 2, (size_t)(text - codes - 2));
        if (sscanf(digits, "%x %x", &first, &second) < 1 || first > 0xffffu)
            continue;
        if (mnemonic[0] == '.' || strcmp(mnemonic, "@") == 0)
            continue;
        bool slow = strncmp(mnemonic, "vdiv", 4) == 0 || strncmp(mnemonic, "vsqrt", 5) == 0;
        bool got = first >= 0xe800u &&
                   hil_profile_is_slow_instruction((uint16_t)first, (uint16_t)second);
        if (got != slow)
            fail_msg("%s is taken otherwise", line);
        seen += slow;
        count++;
    }
    assert_int_equal(pclose(dump), 0);
    assert_in_range(count, 5000, 1000000);
    assert_in_range(seen, 2, count);
}

TEST(test_names)
{
    struct mr_symbols symbols;
    char error[256], line[256];
    unsigned count = 0;
    assert_int_equal(hil_symbols_read(&symbols, FIRMWARE, error, sizeof error), MR_OK);
    FILE *nm = popen("arm-none-eabi-nm -S " FIRMWARE, "r");
    assert_non_null(nm);
    while (fgets(line, sizeof line, nm)) {
        unsigned address, size;
        char type, name[128];
        if (sscanf(line, "%x %x %c %127s", &address, &size, &type, name) != 4 ||
            (type != 'T' && type != 't'))
            continue;
        const struct mr_symbol *symbol = mr_symbols_by_address(&symbols, address);
        /* an object in .text, or a name inside another function */
        if (!symbol || symbol->address != address)
            continue;
        assert_ptr_equal(mr_symbols_by_address(&symbols, address + symbol->size - 2u), symbol);
        if (strcmp(symbol->name, name) == 0) {
            assert_in_range(symbol->size, 2, size);
            /* two files may have a function of the name */
            assert_string_equal(mr_symbols_by_name(&symbols, name)->name, name);
            count++;
        }
    }
    assert_int_equal(pclose(nm), 0);
    assert_in_range(count, 150, 1000);
    assert_null(mr_symbols_by_address(&symbols, 0x20000000u));
    assert_null(mr_symbols_by_address(&symbols, 0));
    assert_null(mr_symbols_by_name(&symbols, "no_such_function"));
    hil_symbols_free(&symbols);
}

TEST(test_damaged_images)
{
    static uint8_t bytes[1u << 21];
    struct mr_symbols symbols;
    char error[256];
    FILE *file = fopen(FIRMWARE, "rb");
    assert_non_null(file);
    size_t n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_in_range(n, 10000, sizeof bytes - 1);
    assert_int_equal(hil_symbols_read(&symbols, "build/nowhere.elf", error, sizeof error), MR_IO);
    hil_symbols_free(&symbols);
    assert_int_equal(hil_symbols_read(&symbols, "Makefile", error, sizeof error), MR_MALFORMED);
    hil_symbols_free(&symbols);
    /* cut anywhere: an answer or a refusal, never a read beyond the end */
    for (size_t cut = 0; cut < n; cut += cut < 100 ? 1 : n / 60) {
        const char *path = bench_scratch("cut.elf", bytes, cut);
        enum mr_status status = hil_symbols_read(&symbols, path, error, sizeof error);
        assert_int_not_equal(status, MR_OK);
        hil_symbols_free(&symbols);
    }
}
