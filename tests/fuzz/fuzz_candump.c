/* Lines of a candump log. What is taken for a frame must come out of the printer and go in again as
 * the same. */
#include <string.h>

#include "host/link/candump.h"
#include "tests/fuzz/fuzz.h"

static void parse(const char *line, size_t length)
{
    struct link_frame frame, again;
    char text[CANDUMP_LINE_SIZE];
    if (candump_parse(line, length, &frame) != MR_OK || frame.length > 8)
        return;
    size_t printed = candump_write_line(&frame, text);
    FUZZ_REQUIRE(printed > 0 && printed < sizeof text && text[printed - 1] == '\n');
    FUZZ_REQUIRE(candump_parse(text, printed - 1, &again) == MR_OK);
    FUZZ_REQUIRE(again.id == frame.id && again.length == frame.length &&
                 again.host_us == frame.host_us);
    FUZZ_REQUIRE(memcmp(again.data, frame.data, frame.length) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *line = (const char *)data, *end = line + size;
    while (line < end) {
        const char *newline = memchr(line, '\n', (size_t)(end - line));
        size_t length = (size_t)((newline ? newline : end) - line);
        parse(line, length);
        line += length + 1;
    }
    return 0;
}
