/* The configuration that the board was given: as text by name and unit, and from that into its
 * flash. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/config.h"
#include "host/board/config_text.h"
#include "tests/golden/golden.h"

#define FLASH_PLACE 0x8000u /* of copy A: sector 2 */
#define REVISION    1u      /* of a stored one; 0 is built in */

char *given_config_take(uint32_t crc)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    struct mr_config own = config;
    if (mr_config_encode(&own, image) != crc)
        golden_fail(
            4,
            "recorded under another configuration than the one that is built in; record with that");
    own.site[0].revision = REVISION;
    char *text = config_text_write(&own);
    if (!text)
        golden_fail(3, "no memory");
    return text;
}

/* The line of `text` that sets the same field as `line`; NULL: none. */
static const char *same_field(const char *text, const char *line)
{
    size_t length = strcspn(line, "= \n");
    for (; *text; text += strcspn(text, "\n"), text += *text == '\n') {
        if (strncmp(text, line, length) == 0 && strcspn(text, "= \n") == length)
            return text;
    }
    return NULL;
}

static bool is_setting(const char *line)
{
    return line[0] != '#' && line[0] != '\n';
}

/* Today's text, with the values that were given. A field that has come since keeps the value that
 * is built in. */
static char *merge(const char *given, const char *today)
{
    char *out = malloc(strlen(given) + strlen(today) + 1), *end = out;
    if (!out)
        golden_fail(3, "no memory");
    for (const char *line = given; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (is_setting(line) && !same_field(today, line))
            golden_fail(4,
                        "the configuration has no field `%.*s` any more: record what is given anew",
                        (int)strcspn(line, "= \n"), line);
    }
    for (const char *line = today; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        const char *from = is_setting(line) ? same_field(given, line) : NULL;
        from = from ? from : line;
        size_t length = strcspn(from, "\n");
        memcpy(end, from, length);
        end += length;
        *end++ = '\n';
    }
    *end = '\0';
    return out;
}

void given_config_flash(const char *given, const char *flash_path)
{
    static uint8_t flash[FLASH_PLACE + MR_CONFIG_IMAGE_BYTES];
    struct mr_config stored;
    struct error error = {0};
    char *today = config_text_write(&config), *text = merge(given, today ? today : "");
    if (config_text_read(text, "the configuration that was given", &stored, &error) != MR_OK)
        golden_fail(4, "%s", error.text);
    memset(flash, 0xff, sizeof flash);
    mr_config_encode(&stored, flash + FLASH_PLACE);
    FILE *file = fopen(flash_path, "wb");
    if (!file || fwrite(flash, sizeof flash, 1, file) != 1 || fclose(file) != 0)
        golden_fail(3, "cannot write %s: %s", flash_path, strerror(errno));
    free(text);
    free(today);
}
