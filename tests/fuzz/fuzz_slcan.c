/* What an SLCAN adapter sends. */
#include <string.h>

#include "host/link/slcan.h"
#include "tests/fuzz/fuzz.h"

static void again(const struct link_frame *frame)
{
    struct slcan_parser parser = {0};
    char line[SLCAN_LINE_MAX];
    size_t length = slcan_print(frame, line);
    enum slcan_kind kind = SLCAN_MORE;
    FUZZ_REQUIRE(length < sizeof line);
    for (size_t i = 0; i < length; i++)
        kind = slcan_push(&parser, line[i]);
    FUZZ_REQUIRE(kind == SLCAN_FRAME && parser.frame.id == frame->id &&
                 parser.frame.length == frame->length);
    FUZZ_REQUIRE(memcmp(parser.frame.data, frame->data, frame->length) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct slcan_parser parser = {0};
    struct link_frame error_frame;
    for (size_t i = 0; i < size; i++) {
        enum slcan_kind kind = slcan_push(&parser, (char)data[i]);
        if (kind == SLCAN_FRAME)
            again(&parser.frame);
        else if (kind == SLCAN_STATUS)
            (void)slcan_status_frame(parser.status, &error_frame);
    }
    return 0;
}
