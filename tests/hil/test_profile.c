/* Kinds of instructions and names of functions against binutils' objdump and nm, which share
 * nothing with ours. */
#include <inttypes.h>

#include "hil/debug/profile.h"
#include "tests/hil/bench.h"

#define FIRMWARE "build/firmware/matrig.elf"

static bool begins(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static bool one_of(const char *word, const char *const *list)
{
    for (; *list; list++) {
        if (strcmp(word, *list) == 0)
            return true;
    }
    return false;
}

/* Kind by the name that objdump gives the instruction; conditions and width suffixes are cut
 * off. */
static int kind_by_name(const char *mnemonic)
{
    static const char *const branches[] = {"b",    "bl",  "blx", "bx", "cbz",
                                           "cbnz", "tbb", "tbh", NULL};
    static const char *const system[] = {"svc", "udf", "bkpt",  "dsb",   "dmb", "isb",
                                         "msr", "mrs", "cpsid", "cpsie", "nop", "wfi",
                                         "wfe", "sev", "yield", NULL};
    static const char *const multiplies[] = {
        "mul",    "muls",   "mla",   "mls",    "umull",  "smull",  "umlal", "smlal",
        "smulbb", "smlabb", "smmul", "smulbt", "smultb", "smultt", "umaal", NULL};
    static const char *const conditions[] = {"eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc",
                                             "hi", "ls", "ge", "lt", "gt", "le", NULL};
    char name[32], bare[32];
    snprintf(name, sizeof name, "%s", mnemonic);
    name[strcspn(name, ".")] = '\0';
    snprintf(bare, sizeof bare, "%s", name);
    size_t n = strlen(bare);
    if (n > 2 && one_of(bare + n - 2, conditions))
        bare[n - 2] = '\0';
    if (name[0] == 'v') {
        if (begins(name, "vldr") || begins(name, "vldm") || begins(name, "vpop"))
            return HIL_KIND_FP_LOAD;
        if (begins(name, "vstr") || begins(name, "vstm") || begins(name, "vpush"))
            return HIL_KIND_FP_STORE;
        return begins(name, "vdiv") || begins(name, "vsqrt") ? HIL_KIND_FP_SLOW : HIL_KIND_FP;
    }
    if (one_of(name, branches) || (one_of(bare, branches) && !begins(name, "bics")))
        return HIL_KIND_BRANCH;
    if (one_of(name, system))
        return HIL_KIND_SYSTEM;
    if (begins(name, "sdiv") || begins(name, "udiv"))
        return HIL_KIND_DIVIDE;
    if (one_of(name, multiplies) || one_of(bare, multiplies))
        return HIL_KIND_MULTIPLY;
    if (begins(name, "ldr") || begins(name, "ldm") || begins(name, "pop"))
        return HIL_KIND_LOAD;
    if (begins(name, "str") || begins(name, "stm") || begins(name, "push"))
        return HIL_KIND_STORE;
    return HIL_KIND_ALU;
}

TEST(test_kinds)
{
    unsigned seen[HIL_KINDS] = {0}, wrong = 0, count = 0;
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
        int expected = kind_by_name(mnemonic);
        enum hil_kind got = hil_profile_kind((uint16_t)first, (uint16_t)second);
        /* a load or move to PC: either is right */
        bool pc = strstr(line, "pc}") || strstr(line, "\tpc,");
        if ((int)got != expected && !(pc && got == HIL_KIND_BRANCH) && wrong++ < 10)
            print_message("%s is %s here\n", line, hil_profile_kind_name(got));
        seen[expected]++;
        count++;
    }
    assert_int_equal(pclose(dump), 0);
    assert_in_range(count, 5000, 1000000);
    for (unsigned i = 0; i < HIL_KINDS; i++)
        assert_in_range(seen[i], 1, count);
    assert_int_equal(wrong, 0);
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
        const struct mr_symbol *symbol = mr_symbols_at(&symbols, address);
        /* an object in .text, or a name inside another function */
        if (!symbol || symbol->address != address)
            continue;
        assert_ptr_equal(mr_symbols_at(&symbols, address + symbol->size - 2u), symbol);
        if (strcmp(symbol->name, name) == 0) {
            assert_in_range(symbol->size, 2, size);
            assert_ptr_equal(mr_symbols_named(&symbols, name), symbol);
            count++;
        }
    }
    assert_int_equal(pclose(nm), 0);
    assert_in_range(count, 150, 1000);
    assert_null(mr_symbols_at(&symbols, 0x20000000u));
    assert_null(mr_symbols_at(&symbols, 0));
    assert_null(mr_symbols_named(&symbols, "no_such_function"));
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
