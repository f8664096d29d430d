/* Who may give operators' orders: nonces, and the proofs that come with orders (common/proof.h).
 *
 * A nonce holds until a proof of it was right, or for a second. A wrong proof leaves it: else
 * anybody could end it. Each third wrong one in a row on a link costs that link a second, in which
 * no proof is looked at: so a flood of them costs no more time than three a second, and does not
 * close the other link. An order without a proof costs nothing. */
#ifndef MATRIG_FIRMWARE_PROOF_H
#define MATRIG_FIRMWARE_PROOF_H

#include "firmware/keystore.h"
#include "firmware/telemetry.h"

#define PROOF_FAILURES 3u
#define PROOF_LOCKED   2u /* nonces to come: the second that was begun does not count */

struct proof {
    uint8_t nonce[MR_PROOF_BYTES];
    bool valid;       /* the nonce may be used */
    uint32_t nonces;  /* since start */
    uint16_t refused; /* wrong proofs */
    struct {
        uint8_t proof[MR_PROOF_BYTES];
        bool given;
        uint8_t failures, locked;
    } link[2]; /* CAN, serial */
};

/* The message `proof`, for the next operator's order of the same link. */
void proof_take(struct proof *proof, bool by_serial, const uint8_t *payload, size_t length);
/* May the operator's order in `payload` be obeyed? MR_OK: the proof is used up, and the next nonce
 * is told; MR_PROOF: no proof, or a wrong one; MR_LOCKOUT; MR_WAIT: the key is being read. */
enum mr_status proof_check(struct proof *proof, const struct keystore *store,
                           struct telemetry *telemetry, bool by_serial,
                           const uint8_t payload[MR_COMMAND_BYTES]);
/* Once a second. */
void proof_second(struct proof *proof, const struct keystore *store, struct telemetry *telemetry);

#endif
