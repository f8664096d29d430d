/* What the flash and the NOR of a board hold, as files, so that it outlasts the program.
 *
 * A flash file is the 1 MiB from 0x08000000, shorter ones are erased above; when the option bytes
 * are not factory new, their 16 bytes (as at 0x1FFFC000) follow. A NOR file is 16 MiB, likewise. */
#ifndef MATRIG_HIL_CELLFILE_H
#define MATRIG_HIL_CELLFILE_H

#include "common/status.h"
#include "hil/board/board.h"

/* Load; a file that is not there leaves the memory as it is. Flash: the chip is reset, as at power
 * on. MR_IO; MR_MALFORMED: not such a file; MR_VERSION: for another board. hil_board_reason says
 * why. MR_HALTED: nothing in it to run. */
enum mr_status hil_board_load_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_load_nor(struct hil_board *board, const char *path);
/* Write, by way of a file beside it, so that a failure leaves the old one. MR_IO. */
enum mr_status hil_board_save_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_save_nor(struct hil_board *board, const char *path);
/* Load an ELF as a flasher would: sectors that it has nothing in keep their content. As
 * hil_board_load_elf. */
enum mr_status hil_board_load_elf_sparing(struct hil_board *board, const char *path);

#endif
