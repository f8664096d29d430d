/* Files that come with matrig, in the folder that it was built in or where `make install` puts
 * them. */
#ifndef MATRIG_HOST_BASE_DATA_DIR_H
#define MATRIG_HOST_BASE_DATA_DIR_H

#include <stddef.h>

enum data_file {
    DATA_BOARD,    /* matrig-board, beside matrig */
    DATA_FIRMWARE, /* matrig.elf */
    DATA_RUNWAY,   /* scene of the model runway */
    DATA_RUNS,     /* folder of the recorded landings */
    PLACE_DEMO     /* script of matrig demo */
};

/* Looked for beside the program, then in ../share/matrig from there. When it is not found: the
 * first of these places, so that opening it gives the error. */
void data_dir_find(enum data_file what, char *path, size_t size);

/* The firmware image of a board, likewise: zg's is DATA_FIRMWARE, others lie beside it in a folder
 * of their name ("discovery"). */
void data_dir_find_firmware(const char *board, char *path, size_t size);

/* The path of matrig: of the running program, or what data_dir_set_program was given. "matrig" when
 * neither is known. */
void data_dir_program(char *path, size_t size);
/* matrig starts matrig-study: its data is looked for from matrig's place. The text stays the
 * caller's. */
void data_dir_set_program(const char *path);

#endif
