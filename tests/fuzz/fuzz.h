/* What the fuzz targets share. A target is a function from bytes to nothing that must not crash,
 * hang or grow, whatever the bytes: LLVMFuzzerTestOneInput, called by libFuzzer (`make fuzz`) or by
 * replay.c with what tests/fuzz/corpus holds (`make test`). */
#ifndef MATRIG_TESTS_FUZZ_FUZZ_H
#define MATRIG_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The bytes as a file of this name in a folder of this process, for readers that take a path. The
 * path lives until the next call. */
const char *fuzz_file(const char *name, const uint8_t *data, size_t size);

/* A campaign in memory, its transaction begun; the same for a while, for making one takes longer
 * than most inputs do. */
struct store *fuzz_store(void);

/* Ends the process: what was found is kept. */
#define FUZZ_REQUIRE(condition) \
    do {                        \
        if (!(condition))       \
            __builtin_trap();   \
    } while (0)

#endif
