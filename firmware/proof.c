#include "firmware/proof.h"

#include <string.h>

#include "common/wire.h"

void proof_store(struct proof *proof, bool by_serial, const uint8_t *payload, size_t length)
{
    if (length != MR_PROOF_BYTES)
        return;
    memcpy(proof->link[by_serial].proof, payload, MR_PROOF_BYTES);
    proof->link[by_serial].is_received = true;
}

/* Compares in constant time, so that the time does not reveal how much of a wrong proof is
 * right. */
static bool is_equal(const uint8_t *a, const uint8_t *b)
{
    volatile uint8_t differs = 0;
    for (unsigned i = 0; i < MR_PROOF_BYTES; i++)
        differs = (uint8_t)(differs | (a[i] ^ b[i]));
    return !differs;
}

/* Makes a new nonce. Proofs made with the old one are no longer valid. */
static void renew_nonce(struct proof *proof, const struct keystore *store,
                        struct telemetry *telemetry)
{
    const uint32_t numbers[3] = {store->change_number, store->start_count, ++proof->nonce_count};
    const uint8_t *p = proof->nonce;
    proof->link[0].is_received = proof->link[1].is_received = false;
    proof->is_nonce_valid = store->state == MR_KEY_SET;
    if (!proof->is_nonce_valid)
        return;
    mr_proof_compute_nonce(proof->nonce, store->key, numbers);
    uint32_t low = mr_get_u32(&p);
    TELEMETRY_SEND(telemetry, TO_LINKS, nonce, NONCE, .low = low, .high = mr_get_u32(&p));
}

enum mr_status proof_check(struct proof *proof, const struct keystore *store,
                           struct telemetry *telemetry, bool by_serial,
                           const uint8_t payload[MR_COMMAND_BYTES])
{
    uint8_t wanted[MR_PROOF_BYTES];
    if (store->state == MR_KEY_NONE || store->state == MR_KEY_NO_MEMORY)
        return MR_OK;
    if (store->state == MR_KEY_NOT_READ)
        return MR_WAIT;
    if (!proof->is_nonce_valid || !proof->link[by_serial].is_received)
        return MR_PROOF;
    if (proof->link[by_serial].lock_seconds)
        return MR_LOCKOUT;
    mr_proof_compute(wanted, store->key, proof->nonce, payload, telemetry->identity.uid);
    if (is_equal(wanted, proof->link[by_serial].proof)) {
        proof->link[by_serial].failures = 0;
        renew_nonce(proof, store, telemetry);
        return MR_OK;
    }
    if (proof->refused_count < UINT16_MAX)
        proof->refused_count++;
    if (++proof->link[by_serial].failures == PROOF_FAILURES_MAX) {
        proof->link[by_serial].failures = 0;
        proof->link[by_serial].lock_seconds = PROOF_LOCK_SECONDS;
    }
    return MR_PROOF;
}

void proof_on_second(struct proof *proof, const struct keystore *store, struct telemetry *telemetry)
{
    for (unsigned link = 0; link < 2; link++) {
        if (proof->link[link].lock_seconds)
            proof->link[link].lock_seconds--;
    }
    renew_nonce(proof, store, telemetry);
}
