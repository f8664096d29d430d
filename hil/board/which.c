#include "hil/board/which.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/image.h"
#include "hil/core/elf.h"
#include "hil/core/memory.h"
#include "hil/periph/board_type.h"

enum mr_status hil_which_head(const uint8_t *flash, const struct hil_board_type **type, char *error,
                              size_t size)
{
    struct mr_image image;
    enum mr_status status = mr_image_get(&image, flash);
    if (status != MR_OK && status != MR_CRC) /* damaged, it says so all the same */
        return MR_OK;
    const struct hil_board_type *found = hil_board_type_of(image.board);
    if (!found) {
        snprintf(error, size,
                 "the image is for board %u, which this matrig-board does not know; take the one "
                 "that came with the image",
                 image.board);
        return MR_VERSION;
    }
    *type = found;
    return MR_OK;
}

static bool read_elf(const char *path, struct hil_memory *memory)
{
    char unused[256];
    return path && hil_elf_load(path, memory, unused, sizeof unused) == MR_OK;
}

static bool read_flash(const char *path, struct hil_memory *memory)
{
    FILE *file = path ? fopen(path, "rb") : NULL;
    size_t n = file ? fread(memory->flash, 1, MR_IMAGE_HEAD, file) : 0;
    if (file)
        fclose(file);
    return n == MR_IMAGE_HEAD;
}

enum mr_status hil_which_files(const char *elf, const char *flash,
                               const struct hil_board_type **type, char *error, size_t size)
{
    struct hil_memory *memory = calloc(1, sizeof *memory);
    enum mr_status status = MR_OK;
    if (!memory)
        abort();
    if (read_elf(elf, memory) || (!elf && read_flash(flash, memory)))
        status = hil_which_head(memory->flash, type, error, size);
    free(memory);
    return status;
}
