#include "host/replay/board.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/image.h"
#include "host/base/data_dir.h"
#include "host/base/process.h"
#include "host/base/xmalloc.h"
#include "host/board/imagefile.h"
#include "host/collect/collect.h"

/* Smallest limit for the real duration of a run. Virtual time always advances, so even a board that
 * hangs reaches the end of the run; the limit is for computers that stall. */
#define RUN_TIMEOUT_MIN_S         60.0
#define RUN_TIMEOUT_PER_VIRTUAL_S 10.0
#define BYTES_PER_READ_MAX        65536
#define FRAMES_PER_READ_MAX       1024

enum { FILE_REPLAY, FILE_CAN, FILE_SERIAL, FILE_BOARD_TEXT, FILE_FLASH, REPLAY_FILE_COUNT };

/* Link texts of the files in the directory: "file:" and the path. */
struct replay_paths {
    char link[REPLAY_FILE_COUNT][320];
};

static void make_paths(struct replay_paths *paths, const char *directory)
{
    static const char *const names[REPLAY_FILE_COUNT] = {"replay.txt", "can.log", "serial.bin",
                                                         "board.txt", "flash.bin"};
    for (unsigned i = 0; i < REPLAY_FILE_COUNT; i++)
        snprintf(paths->link[i], sizeof paths->link[i], "file:%s/%s", directory, names[i]);
}

static const char *get_file_path(const struct replay_paths *paths, unsigned file)
{
    return paths->link[file] + 5;
}

static enum mr_status start_board(const struct replay_board *board,
                                  const struct replay_paths *paths, pid_t *child,
                                  struct error *error)
{
    char can_base[20];
    snprintf(can_base, sizeof can_base, "%u", board->can_base);
    const char *const words[] = {board->program,
                                 "--elf",
                                 board->elf_path,
                                 "--can",
                                 paths->link[FILE_CAN],
                                 "--serial",
                                 paths->link[FILE_SERIAL],
                                 "--replay",
                                 get_file_path(paths, FILE_REPLAY),
                                 "--speed",
                                 board->is_real_time ? "real" : "max",
                                 "--can-base",
                                 can_base,
                                 board->has_flash_file ? "--flash" : NULL,
                                 get_file_path(paths, FILE_FLASH),
                                 NULL};
    int output_fd = open(get_file_path(paths, FILE_BOARD_TEXT),
                         O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    int null_fd = open("/dev/null", O_RDWR | O_CLOEXEC);
    if (output_fd < 0 || null_fd < 0)
        error_set(error, MR_IO, "cannot write (%s): %s; free disk space", strerror(errno),
                  get_file_path(paths, FILE_BOARD_TEXT));
    else
        process_start(words, (const int[]){null_fd, null_fd, output_fd}, child, error);
    if (output_fd >= 0)
        close(output_fd);
    if (null_fd >= 0)
        close(null_fd);
    return error->status;
}

/* Reads the last line that the board wrote to its standard error. */
static void read_last_line(const char *path, char *out, size_t size)
{
    char line[400];
    FILE *file = fopen(path, "r");
    out[0] = '\0';
    while (file && fgets(line, sizeof line, file))
        snprintf(out, size, "%.*s", (int)strcspn(line, "\n"), line);
    if (file)
        fclose(file);
}

enum mr_status replay_board_check(const struct replay_board *board, struct error *error)
{
    if (access(board->elf_path, R_OK) != 0)
        return error_set(error, MR_IO,
                         "no firmware image (%s): %s; build the image with make all, install the "
                         "package matrig, or give an image with --elf",
                         strerror(errno), board->elf_path);
    if (access(board->program, X_OK) != 0)
        return error_set(error, MR_IO,
                         "no emulated board (%s): %s; build matrig-board with make all, or install "
                         "the package matrig-board",
                         strerror(errno), board->program);
    return MR_OK;
}

static enum mr_status run_board(const struct replay_board *board, const struct replay_paths *paths,
                                struct error *error)
{
    char output_fd[400];
    int status = 0;
    pid_t child;
    if (start_board(board, paths, &child, error) != MR_OK)
        return error->status;
    double limit_s = RUN_TIMEOUT_MIN_S + RUN_TIMEOUT_PER_VIRTUAL_S * board->duration_s;
    if (!process_wait(child, limit_s, &status))
        return error_set(
            error, MR_TIMEOUT,
            "the emulated board timed out after %.0f s: %s; check the load of this computer",
            limit_s, board->program);
    read_last_line(get_file_path(paths, FILE_BOARD_TEXT), output_fd, sizeof output_fd);
    if (WIFSIGNALED(status))
        return error_set(error, MR_IO, "the emulated board was killed by signal %d: %s; try again",
                         WTERMSIG(status), board->program);
    if (WEXITSTATUS(status) != 0)
        return error_set(
            error, MR_IO,
            "the emulated board failed with exit code %d: %s; message of the board: %s",
            WEXITSTATUS(status), board->elf_path, output_fd[0] ? output_fd : "nothing");
    if (access(get_file_path(paths, FILE_CAN), R_OK) != 0 ||
        access(get_file_path(paths, FILE_SERIAL), R_OK) != 0)
        return error_set(
            error, MR_IO,
            "the emulated board wrote no answers: %s; check that this program is matrig-board",
            board->program);
    return MR_OK;
}

/* Collects the data of both links in order of board time, as `matrig log` does. */
static enum mr_status collect_links(struct collector *collector,
                                    struct link *const link[LINK_KINDS], struct error *error)
{
    bool open[LINK_KINDS] = {true, true};
    uint8_t *bytes = xmalloc(BYTES_PER_READ_MAX);
    enum mr_status status = MR_OK;
    while (status == MR_OK && (open[LINK_CAN] || open[LINK_SERIAL])) {
        bool can = open[LINK_CAN] &&
                   (!open[LINK_SERIAL] || collector_get_lagging_link(collector) == LINK_CAN);
        size_t length;
        uint64_t host_us;
        if (can) {
            struct link_frame frame;
            for (int i = 0; i < FRAMES_PER_READ_MAX && status == MR_OK; i++) {
                status = link_receive_frame(link[LINK_CAN], &frame, error);
                if (status == MR_OK)
                    status = collector_receive_frame(collector, &frame, error);
            }
        } else {
            status = link_receive_bytes(link[LINK_SERIAL], bytes, BYTES_PER_READ_MAX, &length,
                                        &host_us, error);
            if (status == MR_OK)
                status = collector_receive_bytes(collector, bytes, length, host_us, error);
        }
        if (status == MR_CLOSED && error->status == MR_OK) {
            open[can ? LINK_CAN : LINK_SERIAL] = false;
            status = collector_end_link(collector, can ? LINK_CAN : LINK_SERIAL, error);
            if (status == MR_TRUNCATED) {
                /* ignore the error: the run ends at a given time, possibly inside a frame */
                *error = (struct error){0};
                status = MR_OK;
            }
        }
    }
    free(bytes);
    return status;
}

static enum mr_status store_answers(const struct replay_paths *paths, uint16_t can_base,
                                    struct store *store, struct error *error)
{
    struct link *link[LINK_KINDS] = {NULL, NULL};
    struct collector *collector = NULL;
    bool good = link_open(paths->link[FILE_CAN], LINK_CAN, &link[LINK_CAN], error) == MR_OK &&
                link_open(paths->link[FILE_SERIAL], LINK_SERIAL, &link[LINK_SERIAL], error) ==
                    MR_OK &&
                store_begin(store, error) == MR_OK &&
                collector_open(store, paths->link[FILE_CAN], can_base, paths->link[FILE_SERIAL],
                               &collector, error) == MR_OK &&
                collect_links(collector, link, error) == MR_OK &&
                collector_end(collector, "end", error) == MR_OK;
    enum mr_status status = good ? store_commit(store, error) : error->status;
    collector_close(collector);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        link_close(link[kind]);
    return status;
}

enum mr_status replay_board_run(const struct replay_board *board, const char *directory,
                                struct store **answers, int64_t *run, struct error *error)
{
    struct replay_paths paths;
    struct store *store = NULL;
    struct store_landing *landings = NULL;
    size_t count = 0;
    make_paths(&paths, directory);
    enum mr_status status = run_board(board, &paths, error);
    if (status == MR_OK)
        status = store_open(":memory:", STORE_CREATE, &store, error);
    if (status == MR_OK)
        status = store_answers(&paths, board->can_base, store, error);
    if (status == MR_TRUNCATED) {
        /* The board ended normally, so its file does not end inside a frame: this status means that
         * the file has no frames at all. */
        error->status = MR_OK;
        status = error_set(
            error, MR_TRUNCATED,
            "the board sent no frame that matrig can read: %s; use a firmware image of matrig",
            board->elf_path);
    }
    if (status == MR_OK)
        status = store_landings_get(store, &landings, &count, error);
    if (status == MR_OK && count == 0)
        status = error_set(error, MR_TRUNCATED,
                           "the board reported no landing: %s; check that it runs the right "
                           "firmware and that the record begins before the arming",
                           board->elf_path);
    if (status != MR_OK) {
        store_close(store);
        return status;
    }
    *run = landings[0].id;
    *answers = store;
    free(landings);
    return MR_OK;
}

/* ---- the board's image ---- */

void replay_image_path(const struct board_messages *recorded, char *path, size_t size)
{
    const struct mr_board *board = mr_board_by_number(recorded->board_type);
    if (board)
        data_dir_find_firmware(board->name, path, size);
    else
        data_dir_find(DATA_FIRMWARE, path, size);
}

void replay_find_image_path(struct store *store, int64_t run, char *path, size_t size)
{
    struct board_messages recorded;
    struct error unread = {0};
    /* if loading fails, use the image of board zg */
    (void)board_messages_load(store, run, &recorded, &unread);
    replay_image_path(&recorded, path, size);
    board_messages_free(&recorded);
}

static const char *get_board_name(unsigned number)
{
    const struct mr_board *board = mr_board_by_number(number);
    return board ? board->name : "a board unknown to this matrig";
}

enum mr_status replay_image_check(const char *path, const struct board_messages *recorded,
                                  struct error *error)
{
    struct imagefile image = {0};
    struct error refused = {0};
    enum mr_status status = MR_OK;
    if (imagefile_read(path, &image, &refused) == MR_OK && image.has_header &&
        recorded->is_board_known && image.header.board != recorded->board_type)
        status = error_set(error, MR_VERSION,
                           "the landing was recorded by board %s, but the image is for %s: %s; "
                           "leave --elf out, or give an image for the board that recorded it",
                           get_board_name(recorded->board_type), get_board_name(image.header.board),
                           path);
    imagefile_free(&image);
    return status;
}
