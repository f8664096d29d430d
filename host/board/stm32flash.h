/* A board in its chip's boot ROM, programmed by stm32flash (a program of its own, Debian's package
 * stm32flash), which talks AN3155 with it.
 *
 * An image goes into flash in parts: first sector 0 gets a few instructions that start the boot
 * ROM, then the program is written, at last vectors and header. A board that loses its power or its
 * cable in between starts into the boot ROM, and the whole is done again. stm32flash reads each
 * part back and erases its sectors alone, so the configuration is kept. */
#ifndef MATRIG_HOST_BOARD_STM32FLASH_H
#define MATRIG_HOST_BOARD_STM32FLASH_H

#include <stdbool.h>

#include "host/board/imagefile.h"

#define STM32FLASH_BAUD 115200 /* the boot ROM promises no more: AN3155 */

struct stm32flash {
    const char *tty;  /* the port's path; no other program may have it open */
    const char *spec; /* the LINK, for errors */
    int baud;
    bool pts; /* a pseudo-terminal, which keeps no parity */
    /* Percent of a part; may be NULL. */
    void (*progress)(void *context, const char *part, double percent);
    void *context;
};

/* The id of the chip whose boot ROM answers. MR_TIMEOUT: none does; MR_IO: no stm32flash. */
enum mr_status stm32flash_chip(const struct stm32flash *to, unsigned *chip, struct error *error);

/* Programs the image, reads it back and starts it. MR_IO. */
enum mr_status stm32flash_program(const struct stm32flash *to, const struct imagefile *image,
                                  struct error *error);

#endif
