/* Place: files that come with matrig, in the folder that it was built in or where `make install`
 * puts them. */
#ifndef MATRIG_HOST_BASE_PLACE_H
#define MATRIG_HOST_BASE_PLACE_H

#include <stddef.h>

enum place {
    PLACE_BOARD,    /* matrig-board, beside matrig */
    PLACE_FIRMWARE, /* matrig.elf */
    PLACE_RUNWAY,   /* scene of the model runway */
    PLACE_RUNS,     /* folder of the recorded landings */
    PLACE_DEMO      /* script of matrig demo */
};

/* Looked for beside the program, then in ../share/matrig from there, then in the folders for data
 * of the XDG Base Directory Specification ($XDG_DATA_HOME, $XDG_DATA_DIRS). When it is nowhere:
 * where it was looked for first, so that opening it says so. */
void place_find(enum place what, char *path, size_t size);

/* The firmware image of a board, likewise: zg's is PLACE_FIRMWARE, others lie beside it in a folder
 * of their name ("discovery"). */
void place_find_firmware(const char *board, char *path, size_t size);

/* The path of matrig: of the running program, or what place_set_program was given. "matrig" when
 * neither is known. */
void place_program(char *path, size_t size);
/* matrig-study is started by matrig: what comes with matrig is looked for from matrig's place. The
 * text stays the caller's. */
void place_set_program(const char *path);

#endif
