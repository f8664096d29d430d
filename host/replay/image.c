#include "host/replay/image.h"

#include "common/image.h"
#include "host/base/data_dir.h"
#include "host/board/imagefile.h"

void replay_image_of(const struct answers *recorded, char *path, size_t size)
{
    const struct mr_board *board = mr_board_of(recorded->board);
    if (board)
        data_dir_find_firmware(board->name, path, size);
    else
        data_dir_find(DATA_FIRMWARE, path, size);
}

void replay_image_find(struct store *store, int64_t run, char *path, size_t size)
{
    struct answers recorded;
    answers_load_board(store, run, &recorded);
    replay_image_of(&recorded, path, size);
}

static const char *name_of(unsigned number)
{
    const struct mr_board *board = mr_board_of(number);
    return board ? board->name : "one that this matrig does not know";
}

enum mr_status replay_image_check(const char *path, const struct answers *recorded,
                                  struct error *error)
{
    struct imagefile image = {0};
    struct error refused = {0};
    enum mr_status status = MR_OK;
    if (imagefile_read(path, &image, &refused) == MR_OK && image.stamped && recorded->board_told &&
        image.header.board != recorded->board)
        status = error_set(error, MR_VERSION,
                           "the landing was recorded by board %s, and the image is for %s: %s; "
                           "leave --elf out, or give an image of that board",
                           name_of(recorded->board), name_of(image.header.board), path);
    imagefile_free(&image);
    return status;
}
