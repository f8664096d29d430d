/* Files that are part of matrig, in the folder where it was built or where `make install` puts
 * them. */
#ifndef MATRIG_HOST_BASE_DATA_DIR_H
#define MATRIG_HOST_BASE_DATA_DIR_H

#include <stddef.h>

enum data_file {
    DATA_BOARD_PROGRAM,     /* the program matrig-board, in the folder of matrig */
    DATA_FIRMWARE,          /* matrig.elf, the firmware image */
    DATA_RUNWAY_SCENE,      /* scene of the model runway */
    DATA_RECORDED_LANDINGS, /* folder of the recorded landings */
    DATA_DEMO_SCRIPT        /* script of matrig demo */
};

/* Finds a file in the folder of the program, or else in ../share/matrig relative to that folder. If
 * both are missing, returns the first path, so that opening it reports the error. */
void data_dir_find(enum data_file what, char *path, size_t size);

/* As data_dir_find, for the firmware image of a board. Board zg has DATA_FIRMWARE; images of other
 * boards are in a subfolder with the board's name ("discovery"). */
void data_dir_find_firmware(const char *board, char *path, size_t size);

/* Writes the path of matrig: the path passed to data_dir_set_program, or that of the running
 * program. "matrig" if neither is known. */
void data_dir_program_path(char *path, size_t size);
/* Sets the path of matrig. For matrig-study, a separate program, which uses the data of matrig. The
 * caller keeps the text. */
void data_dir_set_program(const char *path);

#endif
