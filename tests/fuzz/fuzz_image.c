/* Firmware images: ELF, binary; the first byte chooses the name. */
#include "host/board/imagefile.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[] = {"image.elf", "image.bin"};
    struct imagefile image;
    struct error error = {0};
    if (size < 1)
        return 0;
    if (imagefile_read(fuzz_file(names[data[0] % 2u], data + 1, size - 1), &image, &error) != MR_OK)
        FUZZ_REQUIRE(error.text[0]);
    imagefile_free(&image);
    return 0;
}
