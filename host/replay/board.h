/* The emulated board as a child process. It runs a replay file. Its messages are stored in a
 * database in memory, as if they had been logged. matrig does not link the emulator. */
#ifndef MATRIG_HOST_REPLAY_BOARD_H
#define MATRIG_HOST_REPLAY_BOARD_H

#include <stdbool.h>

#include "host/replay/input.h"

struct replay_board {
    const char *program; /* path of matrig-board */
    const char *elf_path;
    bool is_real_time;
    /* the directory contains flash.bin, the board's flash without the image */
    bool has_flash_file;
    uint16_t can_base; /* base of the board on CAN, from its configuration */
    double duration_s; /* approximate virtual duration, which determines the time limit */
};

/* Checks that program and image exist; otherwise MR_IO. */
enum mr_status replay_board_check(const struct replay_board *board, struct error *error);

/* Runs a replay. `directory` is for temporary files and already has replay.txt; the board adds
 * can.log, serial.bin and board.txt, and the caller removes all. `*answers` is a new database with
 * the landing that the board reported, `*run` the landing's RUN. MR_IO: the board stopped.
 * MR_TIMEOUT: the board took too long. MR_TRUNCATED: the board reported no landing. */
enum mr_status replay_board_run(const struct replay_board *board, const char *directory,
                                struct store **answers, int64_t *run, struct error *error);

/* Writes the path of matrig's firmware image for the board that recorded the landing. If the record
 * does not name the board, it is the image of board zg. */
void replay_image_path(const struct board_messages *recorded, char *path, size_t size);
/* As replay_image_path, for a landing whose messages are not loaded. */
void replay_find_image_path(struct store *store, int64_t run, char *path, size_t size);
/* Checks that the image is for the board that recorded the landing; otherwise MR_VERSION. A file
 * that is not a matrig image is accepted here; the emulated board refuses it. */
enum mr_status replay_image_check(const char *path, const struct board_messages *recorded,
                                  struct error *error);

#endif
