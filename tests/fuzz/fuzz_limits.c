/* Files of limits for matrig compare. */
#include "host/compare/show.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct compare_limits limits = {NULL};
    struct compare_verdict verdict = {0};
    struct compare_figures figures = {
        .run = 1, .channel_count = 1, .channel = {{.number = 1, .is_compared = true}}};
    struct error error = {0};
    if (compare_limits_load(&limits, fuzz_file("limits.json", data, size), &error) == MR_OK) {
        compare_check(&figures, &limits, &verdict);
        FUZZ_REQUIRE(!verdict.failed_limit_count == !verdict.worst_failure[0]);
    } else {
        FUZZ_REQUIRE(error.text[0]);
    }
    compare_limits_free(&limits);
    return 0;
}
