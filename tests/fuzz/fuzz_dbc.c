/* DBC files as matrig import reads them: the signal "M.S", and what it makes of a frame. */
#include <math.h>
#include <string.h>

#include "host/import/signal.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct import_signal signal = {0};
    struct error error = {0};
    double value;
    if (signal_from_dbc_text((const char *)data, size, "x.dbc", "M.S", &signal, &error) != MR_OK) {
        FUZZ_REQUIRE(error.text[0]);
        return 0;
    }
    FUZZ_REQUIRE(signal_fits(&signal, 8));
    struct link_frame frame = {.id = signal.id, .length = 8};
    memcpy(frame.data, data, size < 8 ? size : 8);
    if (signal_value(&signal, &frame, &value))
        FUZZ_REQUIRE(isfinite(value));
    return 0;
}
