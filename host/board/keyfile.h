/* The key of a board on this computer: 64 hexadecimal digits in the file matrig/UID.key in
 * $XDG_CONFIG_HOME (default: ~/.config), which only its owner may read. */
#ifndef MATRIG_HOST_BOARD_KEYFILE_H
#define MATRIG_HOST_BOARD_KEYFILE_H

#include <stddef.h>
#include <stdint.h>

#include "common/proof.h"
#include "host/base/error.h"

#define KEYFILE_PATH_SIZE 4096u

/* Writes the path of the key file of the board `uid` (24 digits). */
void keyfile_path(const char *uid, char path[KEYFILE_PATH_SIZE]);
/* Computes the proof of a command (common/proof.h) with the board's key. `words`: the identity
 * `uid` as the board sends it. MR_UNKNOWN: there is no key. MR_IO: the key cannot be read, or other
 * users may read it. MR_MALFORMED: the file is not a key. */
enum mr_status keyfile_compute_proof(const char *uid, const uint32_t words[3],
                                     const uint8_t nonce[MR_PROOF_BYTES],
                                     const uint8_t command[MR_COMMAND_BYTES],
                                     uint8_t proof[MR_PROOF_BYTES], struct error *error);
/* keyfile_generate makes a new key and writes it to a second file. The current key stays active
 * until keyfile_activate replaces it with the new key; keyfile_discard_new removes the new key. */
enum mr_status keyfile_generate(const char *uid, uint8_t key[MR_KEY_BYTES], struct error *error);
enum mr_status keyfile_activate(const char *uid, struct error *error);
void keyfile_discard_new(const char *uid);

#endif
