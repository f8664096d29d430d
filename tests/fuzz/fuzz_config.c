/* Configurations as text. What is accepted is written and read again as the same. */
#include <stdlib.h>
#include <string.h>

#include "host/board/config_text.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct mr_config config, again;
    struct error error = {0};
    char *text = malloc(size + 1);
    FUZZ_REQUIRE(text);
    memcpy(text, data, size);
    text[size] = '\0';
    if (config_text_read(text, "fuzz", &config, &error) == MR_OK) {
        char *written = config_text_write(&config);
        FUZZ_REQUIRE(written && config_text_read(written, "fuzz", &again, &error) == MR_OK);
        uint8_t one[MR_CONFIG_IMAGE_BYTES], two[MR_CONFIG_IMAGE_BYTES];
        mr_config_encode(&config, one);
        mr_config_encode(&again, two);
        FUZZ_REQUIRE(memcmp(one, two, sizeof one) == 0);
        free(written);
    } else {
        FUZZ_REQUIRE(error.text[0]);
    }
    free(text);
    return 0;
}
