/* The board's key in two sectors of the black box's memory, and the number of starts with this key,
 * which makes the nonces different after each start.
 *
 * A copy is a page with mark, number of the change, a flag for a key, the key, CRC-32, and the mark
 * again. Because of the second mark, damage to the only copy is not mistaken for a missing key,
 * which would permit all commands. The pages after it count starts, one bit each. A change is
 * written into the unused copy and read back; then the old copy is erased. One copy is therefore
 * intact after a power failure at any time, and an old key is never restored. The state is DAMAGED
 * if there is a marked copy but no intact one, or if the starts can no longer be counted (after
 * 30,720 starts). No operator's command is then executed until a key is set or cleared. Without a
 * memory there is no key.
 *
 * Nothing is written while a landing is recorded, and no landing is armed during a write. Pure
 * except for the calls of board.h. */
#ifndef MATRIG_FIRMWARE_KEYSTORE_H
#define MATRIG_FIRMWARE_KEYSTORE_H

#include "common/proof.h"
#include "firmware/board.h"

struct keystore {
    enum mr_key_state state;
    uint8_t key[MR_KEY_BYTES];
    uint32_t change_number; /* times that the key was set or cleared */
    /* starts with this key, including this one; 0: the key was set after the start */
    uint32_t start_count;

    uint8_t staged_key[MR_KEY_BYTES]; /* words received by messages key_word */
    uint8_t received_words;           /* bit n: word n has been received */
    uint16_t tag;

    bool is_set;         /* the valid copy contains a key */
    unsigned valid_copy; /* the valid copy; KEY_COPIES: none */
    unsigned step, target_copy, page, tries;
    bool is_in_progress;   /* the memory is executing an operation of this module */
    bool has_damaged_copy; /* a copy is damaged */
    /* a power failure prevented erasing the old copy, which must be erased now */
    bool has_stale_copy;
    struct mr_ack answer; /* answer to the key-set or key-clear in progress; code 0: none */
    bool has_answer;
    uint8_t buffer[NOR_PAGE_BYTES];
};

void keystore_start(struct keystore *store);
/* Sets whether the store has a memory. A key that has been read stays active until the next
 * start. */
void keystore_set_memory(struct keystore *store, bool memory);
/* Reads the copies before the first block; takes at most 5 ms with a key, 1 ms without. */
void keystore_check(struct keystore *store);
/* Continues an operation in progress. Returns true if it still uses the memory. */
bool keystore_poll(struct keystore *store);
/* Begins the next operation. Returns false if there is none. */
bool keystore_begin(struct keystore *store);
/* True while the key is being written. */
bool keystore_is_writing(const struct keystore *store);

/* Stages a word of a new key. */
void keystore_put_word(struct keystore *store, const uint8_t *payload, size_t length);
/* Executes key-set and key-clear. MR_OK: begun; keystore_get_answer returns the result later. */
enum mr_status keystore_process_command(struct keystore *store, const struct mr_command *command);
/* Returns the result of a finished key-set or key-clear, once. */
bool keystore_get_answer(struct keystore *store, struct mr_ack *answer);

#endif
