/* Authorises operators' commands: sends nonces, and checks the proofs sent with commands
 * (common/proof.h).
 *
 * A nonce is valid until a correct proof uses it, or for a second. A wrong proof does not end the
 * nonce; otherwise anybody could prevent commands by sending wrong proofs. After every third wrong
 * proof in a row on a link, no proof on that link is checked for a second. A flood of wrong proofs
 * therefore costs no more time than three proofs per second and does not block the other link.
 * Commands without a proof are not counted. */
#ifndef MATRIG_FIRMWARE_PROOF_H
#define MATRIG_FIRMWARE_PROOF_H

#include "firmware/keystore.h"
#include "firmware/telemetry.h"

#define PROOF_FAILURES_MAX 3u
/* number of nonces until the link is unlocked; two, because the second in progress does not
 * count */
#define PROOF_LOCK_SECONDS 2u

struct proof {
    uint8_t nonce[MR_PROOF_BYTES];
    bool is_nonce_valid;    /* the nonce may be used */
    uint32_t nonce_count;   /* number of nonces since start */
    uint16_t refused_count; /* number of wrong proofs */
    struct {
        uint8_t proof[MR_PROOF_BYTES];
        bool is_received;
        uint8_t failures, lock_seconds;
    } link[2]; /* links: CAN, serial */
};

/* Stores the message `proof` for the next operator's command on the same link. */
void proof_store(struct proof *proof, bool by_serial, const uint8_t *payload, size_t length);
/* Checks whether the operator's command in `payload` may be executed. MR_OK: yes; the proof is used
 * up, and the next nonce is sent. MR_PROOF: no proof, or a wrong one; MR_LOCKOUT: the link is
 * locked after wrong proofs; MR_WAIT: the key is being read. */
enum mr_status proof_check(struct proof *proof, const struct keystore *store,
                           struct telemetry *telemetry, bool by_serial,
                           const uint8_t payload[MR_COMMAND_BYTES]);
/* Call once per second. */
void proof_on_second(struct proof *proof, const struct keystore *store,
                     struct telemetry *telemetry);

#endif
