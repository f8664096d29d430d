/* Pages of a black-box record: sealed, so that their CRC is right, unless the first byte is odd. */
#include <string.h>

#include "host/collect/backfill.h"
#include "tests/fuzz/fuzz.h"

#define PAGES 16u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t page[PAGES][MR_BOXPAGE_BYTES];
    uint8_t present[PAGES];
    struct backfill result;
    struct error error = {0};
    size_t count = 0;
    if (size < 2)
        return 0;
    memset(page, 0xff, sizeof page);
    for (size_t at = 1; at < size && count < PAGES; count++, at += MR_BOXPAGE_BYTES) {
        memcpy(page[count], data + at, size - at < MR_BOXPAGE_BYTES ? size - at : MR_BOXPAGE_BYTES);
        present[count] = 1;
        if (!(data[0] & 1u))
            mr_boxpage_seal(page[count], (uint32_t)count, 1);
    }
    enum mr_status status = backfill_store_record(fuzz_store(), "serial:fuzz", 0,
                                                  (const uint8_t(*)[MR_BOXPAGE_BYTES])page, present,
                                                  count, &result, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
    return 0;
}
