/* Computes the proof that the sender of a command has the board's key. Board and host use the same
 * code.
 *
 * While a key is set, the board sends a nonce; it changes every second and after each correct
 * proof. The sender sends the message `proof`, followed by the message `command`. The proof is 8
 * bytes of keyed BLAKE2s (RFC 7693) over the nonce, the bytes of the command and the chip's unique
 * identifier, so it is valid once, for one command to one board. */
#ifndef MATRIG_COMMON_PROOF_H
#define MATRIG_COMMON_PROOF_H

#include <stdint.h>

#define MR_KEY_BYTES     32u
#define MR_KEY_WORDS     (MR_KEY_BYTES / 4u)
#define MR_PROOF_BYTES   8u /* bytes of a proof and of a nonce */
#define MR_COMMAND_BYTES 8u

/* `nonce` and `command` are the bytes of the messages; `uid` is the identifier that the board
 * reports. */
void mr_proof_compute(uint8_t proof[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                      const uint8_t nonce[MR_PROOF_BYTES], const uint8_t command[MR_COMMAND_BYTES],
                      const uint32_t uid[3]);

/* Computes a nonce of the board. The same `numbers` must never be used twice with one key. Nonces
 * cannot be predicted without the key. If they could, an impostor posing as the board could obtain
 * the proof of a later command in advance. */
void mr_proof_compute_nonce(uint8_t nonce[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                            const uint32_t numbers[3]);

#endif
