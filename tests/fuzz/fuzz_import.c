/* Mapping files with the tables and logs that they are for: what is before the first NUL is the
 * mapping, the rest the file. What can be read goes into a campaign in memory; a landing whose
 * record is long next to its samples is left out there. */
#include <math.h>
#include <string.h>

#include "host/exchange/import.h"
#include "tests/fuzz/fuzz.h"

#define LANDING_S 0.3

static bool is_short(const struct mapping *mapping)
{
    for (size_t c = 0; c < mapping->channel_count; c++) {
        const struct series *s = &mapping->channel[c].series;
        for (size_t i = 0; i < s->count; i++)
            FUZZ_REQUIRE(isfinite(s->time_s[i]) && (i == 0 || s->time_s[i] > s->time_s[i - 1]));
        if (s->count && !(s->time_s[s->count - 1] - s->time_s[0] < LANDING_S))
            return false;
    }
    return true;
}

static void import(const uint8_t *data, size_t size, struct mapping *mapping)
{
    const struct cli cli = {.quiet = true};
    const struct import_request request = {.cli = &cli, .path = "table"};
    const struct textfile file = {.text = (char *)(uintptr_t)data, .length = size};
    struct import_result result = {0};
    struct error error = {0};
    enum mr_status status = mapping->reads_signals
                              ? import_read_signals(&file, &request, mapping, &result, &error)
                              : csv_read(file.text, size, request.path, mapping, &result.row_count,
                                         &result.parsed, &error);
    if (status == MR_OK && is_short(mapping))
        status = import_landing(fuzz_store(), mapping, &request, &result, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct mapping mapping;
    struct error error = {0};
    const uint8_t *mark = memchr(data, 0, size);
    size_t head = mark ? (size_t)(mark - data) : size;
    if (mapping_parse((const char *)data, head, "mapping", &mapping, &error) == MR_OK)
        import(mark ? mark + 1 : data, mark ? size - head - 1 : 0, &mapping);
    else
        FUZZ_REQUIRE(error.text[0]);
    mapping_free(&mapping);
    return 0;
}
