#include "common/proof.h"

#include <string.h>

#include "common/blake2s.h"
#include "common/wire.h"

#define NUMBERS_BYTES 12u

static void put_numbers(uint8_t *p, const uint32_t numbers[3])
{
    for (unsigned i = 0; i < 3; i++)
        p = mr_put_u32(p, numbers[i]);
}

void mr_proof_compute(uint8_t proof[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                      const uint8_t nonce[MR_PROOF_BYTES], const uint8_t command[MR_COMMAND_BYTES],
                      const uint32_t uid[3])
{
    uint8_t bytes[MR_PROOF_BYTES + MR_COMMAND_BYTES + NUMBERS_BYTES];
    memcpy(bytes, nonce, MR_PROOF_BYTES);
    memcpy(bytes + MR_PROOF_BYTES, command, MR_COMMAND_BYTES);
    put_numbers(bytes + MR_PROOF_BYTES + MR_COMMAND_BYTES, uid);
    mr_blake2s(proof, MR_PROOF_BYTES, key, MR_KEY_BYTES, bytes, sizeof bytes);
}

/* Computes a nonce. A nonce is the hash of fewer bytes than a proof, so that no nonce is a valid
 * proof. */
void mr_proof_compute_nonce(uint8_t nonce[MR_PROOF_BYTES], const uint8_t key[MR_KEY_BYTES],
                            const uint32_t numbers[3])
{
    uint8_t bytes[NUMBERS_BYTES];
    put_numbers(bytes, numbers);
    mr_blake2s(nonce, MR_PROOF_BYTES, key, MR_KEY_BYTES, bytes, sizeof bytes);
}
