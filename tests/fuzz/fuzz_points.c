/* Files of points of a calibration, of a transducer and of a gage. What is taken has finite
 * numbers, and no sign in the file that could scale a unit. */
#include <math.h>
#include <string.h>

#include "host/calibrate/points.h"
#include "tests/fuzz/fuzz.h"

/* Outside of comments; behind a zero byte a line is not read. */
static bool has_scale(const char *text, size_t size)
{
    if (memchr(text, '\0', size))
        return false;
    for (const char *end = text + size; text < end;) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((newline ? newline : end) - text);
        bool comment = memchr(text, '#', length) != NULL;
        for (size_t i = 0; !comment && i < length; i++) {
            if (strchr("/*^%", text[i]))
                return true;
        }
        text += length + 1;
    }
    return false;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct calibrate_points points;
    const char *path = fuzz_file("points.csv", data, size);
    for (int i = 0; i < 2; i++) {
        struct error error = {0};
        enum unit_kind kind = i ? UNIT_TENSION : UNIT_DISPLACEMENT;
        enum mr_status status = calibrate_points_read(path, kind, &points, &error);
        FUZZ_REQUIRE(status == MR_OK || error.text[0]);
        FUZZ_REQUIRE(points.count <= CALIBRATE_POINTS_MAX);
        if (status != MR_OK)
            continue;
        FUZZ_REQUIRE(!has_scale((const char *)data, size));
        for (size_t k = 0; k < points.count; k++)
            FUZZ_REQUIRE(isfinite(points.point[k].value) && isfinite(points.point[k].code));
    }
    return 0;
}
