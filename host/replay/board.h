/* The emulated board as a process: it plays a replay file and leaves what it said, as if logged, in
 * a database in memory. matrig never links the emulator. */
#ifndef MATRIG_HOST_REPLAY_BOARD_H
#define MATRIG_HOST_REPLAY_BOARD_H

#include <stdbool.h>

#include "host/replay/input.h"

struct replay_board {
    const char *program; /* matrig-board */
    const char *elf;
    bool real; /* paced by the wall clock */
    /* flash.bin is in the directory: what the board's flash holds beside the image */
    bool flash;
    uint16_t can_base; /* where it speaks on CAN, by its configuration */
    double duration_s; /* of virtual time, about: bounds the wait */
};

/* MR_IO: program or image is missing. */
enum mr_status replay_board_check(const struct replay_board *board, struct error *error);

/* `directory`: for temporary files, which stay the caller's to remove: replay.txt is there,
 * can.log, serial.bin and board.txt will be. `*answers` is a new database with the landing the
 * board told of, `*run` its number. MR_IO: the board stopped; MR_TIMEOUT; MR_TRUNCATED: it told of
 * no landing. */
enum mr_status replay_board_run(const struct replay_board *board, const char *directory,
                                struct store **answers, int64_t *run, struct error *error);

/* The image that came with matrig for the board that recorded it. Of a record that does not tell
 * its board: zg's. */
void replay_image_of(const struct answers *recorded, char *path, size_t size);
/* The same, of a landing whose answers are not loaded. */
void replay_image_find(struct store *store, int64_t run, char *path, size_t size);
/* MR_VERSION: the image says that it is for another board than the one that recorded it. What is no
 * image of matrig, the board refuses by itself. */
enum mr_status replay_image_check(const char *path, const struct answers *recorded,
                                  struct error *error);

#endif
