/* The key of a board on this computer: 64 hexadecimal digits in matrig/UID.key below
 * $XDG_CONFIG_HOME, ~/.config when that is not set, which its owner alone may read. */
#ifndef MATRIG_HOST_BOARD_KEYFILE_H
#define MATRIG_HOST_BOARD_KEYFILE_H

#include <stddef.h>
#include <stdint.h>

#include "common/proof.h"
#include "host/base/error.h"

#define KEYFILE_PATH 4096u

/* Where the key of the board `uid` (24 digits) is. */
void keyfile_path(const char *uid, char path[KEYFILE_PATH]);
/* The proof of a command (common/proof.h) by that key; `words`: the same identity, as the board
 * sends it. MR_UNKNOWN: there is no key; MR_IO: it cannot be read, or others may read it;
 * MR_MALFORMED. */
enum mr_status keyfile_prove(const char *uid, const uint32_t words[3],
                             const uint8_t nonce[MR_PROOF_BYTES],
                             const uint8_t command[MR_COMMAND_BYTES], uint8_t proof[MR_PROOF_BYTES],
                             struct error *error);
/* Draws a new key and writes it beside the one that holds; then keyfile_keep puts it in its place,
 * or keyfile_drop removes it. */
enum mr_status keyfile_draw(const char *uid, uint8_t key[MR_KEY_BYTES], struct error *error);
enum mr_status keyfile_keep(const char *uid, struct error *error);
void keyfile_drop(const char *uid);

#endif
