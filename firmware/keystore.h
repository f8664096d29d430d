/* The board's key in two sectors of the black box's memory, and how often the board was started
 * with it, which makes its nonces new ones after each start.
 *
 * A copy is a page: mark, number of the change, whether there is a key, the key, CRC-32, and the
 * mark again, or a loss in the only one would open the bus. The pages behind it count starts, a
 * bit each. A change is written into the copy that does not hold, read back, and then the old copy
 * is erased: whenever the power goes, one copy is whole, and a key that was changed does not come
 * back. A copy with a mark that is not whole, none other being so, is DAMAGED, as is a key whose
 * starts can no longer be counted (30,720 of them): then no operator's order is obeyed until a key
 * is set or cleared. Without a memory there is no key.
 *
 * Nothing is written while a landing is recorded, nor armed while something is written. Pure but
 * for the calls of board.h. */
#ifndef MATRIG_FIRMWARE_KEYSTORE_H
#define MATRIG_FIRMWARE_KEYSTORE_H

#include "common/proof.h"
#include "firmware/board.h"

struct keystore {
    enum mr_key_state state;
    uint8_t key[MR_KEY_BYTES];
    uint32_t change; /* times that it was set or cleared */
    uint32_t starts; /* with this key, this one included; 0: it was set since */

    uint8_t staged[MR_KEY_BYTES]; /* of key_word */
    uint8_t received;             /* bit n: word n */
    uint16_t tag;

    bool set;      /* the copy that holds has a key */
    unsigned copy; /* that holds, KEY_COPIES: none */
    unsigned step, at, page, tries;
    bool under_way;       /* the memory has an operation of ours */
    bool damaged;         /* a copy is */
    bool stale;           /* the power went before the old copy was erased: that is still to do */
    struct mr_ack answer; /* to key-set or key-clear, which is being done; code 0: none */
    bool answered;
    uint8_t buffer[NOR_PAGE];
};

void keystore_start(struct keystore *store);
/* Whether there is a memory, now. A key that was read stays in force until the next start. */
void keystore_follow(struct keystore *store, bool memory);
/* Read what there is before the first block: 5 ms at most with a key, 1 ms without. */
void keystore_look(struct keystore *store);
/* An operation that was begun: go on with it; true: it still holds the memory. */
bool keystore_busy(struct keystore *store);
/* Begin the next one; false: there is none. */
bool keystore_begin(struct keystore *store);
/* It is being written. */
bool keystore_writing(const struct keystore *store);

/* A word of a new key. */
void keystore_word(struct keystore *store, const uint8_t *payload, size_t length);
/* key-set and key-clear. MR_OK: begun, keystore_answer follows. */
enum mr_status keystore_obey(struct keystore *store, const struct mr_command *command);
/* What came of it, once. */
bool keystore_answer(struct keystore *store, struct mr_ack *answer);

#endif
