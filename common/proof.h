/* The proof that who gives an order has the board's key: what board and host compute alike.
 *
 * While a key is set the board tells a nonce, another one each second and after each proof that was
 * right. Who orders sends the message `proof` and behind it the message `command`: 8 bytes of keyed
 * BLAKE2s (RFC 7693) over the nonce, the command's bytes and the chip's identity. So a proof is for
 * one command to one board, once. */
#ifndef MATRIG_COMMON_PROOF_H
#define MATRIG_COMMON_PROOF_H

#include <stdint.h>

#define MR_KEY_BYTES     32u
#define MR_KEY_WORDS     (MR_KEY_BYTES / 4u)
#define MR_PROOF_BYTES   8u /* of a proof, and of a nonce */
#define MR_COMMAND_BYTES 8u

/* `nonce` and `command` are the bytes of the messages, `uid` the words that the board tells. */
void mr_proof_make(uint8_t proof[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                   const uint8_t nonce[MR_PROOF_BYTES], const uint8_t command[MR_COMMAND_BYTES],
                   const uint32_t uid[3]);

/* The board's nonces: never the same numbers twice under one key, and nobody without it knows the
 * next one, or he could have an order to come proven by who takes him for the board. */
void mr_proof_nonce(uint8_t nonce[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                    const uint32_t numbers[3]);

#endif
