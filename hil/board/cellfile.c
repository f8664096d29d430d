#include "hil/board/cellfile.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hil/board/parts.h"
#include "hil/board/precious.h"

#define OPTION_BYTES 16u

static enum mr_status fail(struct hil_board *board, enum mr_status status, const char *path,
                           const char *why)
{
    snprintf(board->core.reason, sizeof board->core.reason, "%s: %s", path, why);
    return status;
}

/* What no memory holds: an Intel HEX, a run file, a note. UTF-8 has no 0xff; erased cells are
 * that. */
static bool is_text(const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (bytes[i] == 0xff || bytes[i] == 0x7f || !bytes[i] ||
            (bytes[i] < ' ' && !strchr("\t\n\r", bytes[i])))
            return false;
    }
    return n > 0;
}

/* Can the file take the place of `path` at the end? Said before the run, not after it. */
static enum mr_status check_place(struct hil_board *board, const char *path)
{
    char folder[PATH_MAX];
    struct stat st;
    const char *slash = strrchr(path, '/');
    if (stat(path, &st) == 0 && !S_ISREG(st.st_mode))
        return fail(board, MR_USAGE, path,
                    "no regular file, and one would take its place; give another");
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    if (access(folder, W_OK | X_OK) == 0)
        return MR_OK;
    snprintf(board->core.reason, sizeof board->core.reason,
             "%s: cannot write there at the end: %s; give another path", path, strerror(errno));
    return MR_IO;
}

/* Up to `room` bytes of a file; *n 0 and MR_OK when there is none. */
static enum mr_status read_file(struct hil_board *board, const char *path, uint8_t *bytes,
                                size_t room, size_t *n)
{
    *n = 0;
    enum mr_status status = check_place(board, path);
    if (status != MR_OK)
        return status;
    if (hil_is_precious(path))
        return fail(board, MR_MALFORMED, path,
                    "a database or a program, to be overwritten; give another");
    FILE *file = fopen(path, "rb");
    if (!file)
        return errno == ENOENT ? MR_OK : fail(board, MR_IO, path, strerror(errno));
    *n = fread(bytes, 1, room, file);
    bool failed = ferror(file) != 0, more = fgetc(file) != EOF;
    fclose(file);
    if (failed)
        return fail(board, MR_IO, path, "cannot be read; give another");
    if (more)
        return fail(board, MR_MALFORMED, path,
                    "larger than the memory it is to fill; give another");
    if (is_text(bytes, *n))
        return fail(board, MR_MALFORMED, path,
                    "a text, to be overwritten; give a .bin, or a path where nothing is");
    return MR_OK;
}

static enum mr_status write_file(struct hil_board *board, const char *path, const uint8_t *bytes,
                                 size_t n)
{
    char resolved[PATH_MAX], beside[PATH_MAX];
    const char *told = path;
    if (realpath(path, resolved)) /* what a symbolic link names is replaced, not the link */
        path = resolved;
    if ((size_t)snprintf(beside, sizeof beside, "%s.new", path) >= sizeof beside)
        return fail(board, MR_IO, told, "path too long; give a shorter one");
    FILE *file = fopen(beside, "wb");
    if (!file)
        return fail(board, MR_IO, told, strerror(errno));
    bool good = fwrite(bytes, 1, n, file) == n;
    good = fclose(file) == 0 && good;
    if (good && rename(beside, path) == 0)
        return MR_OK;
    remove(beside);
    return fail(board, MR_IO, told, "cannot be written; make room or give another");
}

static uint8_t *must_allocate(size_t n)
{
    uint8_t *bytes = malloc(n);
    if (!bytes)
        abort();
    return bytes;
}

static bool take_options(struct hil_board *board, const uint8_t *bytes)
{
    uint16_t half[8];
    for (unsigned i = 0; i < 8; i++)
        half[i] = (uint16_t)(bytes[2 * i] | bytes[2 * i + 1] << 8);
    if ((half[0] ^ half[1]) != 0xffff || (half[4] ^ half[5]) != 0xffff)
        return false;
    board->state.mcu.flash.options = half[0] | (uint32_t)(half[4] & 0xfffu) << 16;
    return true;
}

enum mr_status hil_board_load_flash(struct hil_board *board, const char *path)
{
    uint8_t *bytes = must_allocate(HIL_FLASH_SIZE + OPTION_BYTES);
    size_t n;
    memset(bytes, 0xff, HIL_FLASH_SIZE);
    enum mr_status status = read_file(board, path, bytes, HIL_FLASH_SIZE + OPTION_BYTES, &n);
    if (status == MR_OK && n > HIL_FLASH_SIZE &&
        (n != HIL_FLASH_SIZE + OPTION_BYTES || !take_options(board, bytes + HIL_FLASH_SIZE)))
        status = fail(board, MR_MALFORMED, path,
                      "no flash file: what follows the first MiB is no option bytes; give another");
    if (status == MR_OK && n) {
        memcpy(board->core.memory->flash, bytes, HIL_FLASH_SIZE);
        status = hil_board_fits(board, path);
    }
    if (status == MR_OK)
        status = hil_board_restart(board);
    free(bytes);
    return status;
}

enum mr_status hil_board_save_flash(struct hil_board *board, const char *path)
{
    uint8_t *bytes = must_allocate(HIL_FLASH_SIZE + OPTION_BYTES);
    bool factory = board->state.mcu.flash.options == HIL_FLASH_OPTIONS_FACTORY;
    memcpy(bytes, board->core.memory->flash, HIL_FLASH_SIZE);
    for (unsigned i = 0; i < OPTION_BYTES; i++)
        bytes[HIL_FLASH_SIZE + i] = (uint8_t)(hil_flash_option_word(&board->mcu.flash, i / 4u) >>
                                              (8u * (i % 4u)));
    enum mr_status status = write_file(board, path, bytes,
                                       HIL_FLASH_SIZE + (factory ? 0 : OPTION_BYTES));
    free(bytes);
    return status;
}

enum mr_status hil_board_load_nor(struct hil_board *board, const char *path)
{
    uint8_t *bytes = must_allocate(HIL_NOR_SIZE);
    size_t n;
    enum mr_status status = read_file(board, path, bytes, HIL_NOR_SIZE, &n);
    if (status == MR_OK)
        status = hil_w25q_poke(&board->w25q, 0, bytes, n);
    free(bytes);
    return status;
}

enum mr_status hil_board_save_nor(struct hil_board *board, const char *path)
{
    uint8_t *bytes = must_allocate(HIL_NOR_SIZE);
    enum mr_status status = hil_w25q_peek(&board->w25q, 0, bytes, HIL_NOR_SIZE);
    if (status == MR_OK)
        status = write_file(board, path, bytes, HIL_NOR_SIZE);
    free(bytes);
    return status;
}

enum mr_status hil_board_load_elf_sparing(struct hil_board *board, const char *path)
{
    uint8_t *old = must_allocate(HIL_FLASH_SIZE), *flash = board->core.memory->flash;
    memcpy(old, flash, HIL_FLASH_SIZE);
    enum mr_status status = hil_board_load_elf(board, path);
    for (unsigned sector = 0; status == MR_OK && sector < HIL_FLASH_SECTORS; sector++) {
        uint32_t at = hil_flash_sector_start(sector), end = hil_flash_sector_start(sector + 1),
                 i = at;
        while (i < end && flash[i] == 0xff)
            i++;
        if (i == end)
            memcpy(flash + at, old + at, end - at);
    }
    free(old);
    return status;
}
