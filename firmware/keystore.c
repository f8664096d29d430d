#include "firmware/keystore.h"

#include <string.h>

#include "common/command.h"
#include "common/crc32.h"
#include "common/wire.h"
#include "firmware/health.h"

/* Steps of the store, in the order of a start and then of a change. */
enum step {
    STEP_NONE,
    STEP_READ,
    STEP_COUNT,
    STEP_MARK,
    STEP_CHECK,
    STEP_ERASE,
    STEP_PROGRAM,
    STEP_VERIFY,
    STEP_WIPE
};

#define RECORD_MARK   0x594b524du /* "MRKY" */
#define CHECKED_BYTES (12u + MR_KEY_BYTES)
/* size of a record, including the second RECORD_MARK at its end */
#define RECORD_BYTES  (CHECKED_BYTES + 4u)
#define TRIES_MAX     3u
#define POLLS_MAX     20000u
#define BITS_PER_BYTE 8u
#define BITS_PER_PAGE (NOR_PAGE_BYTES * BITS_PER_BYTE)
#define STARTS_MAX    ((NOR_PAGES_PER_SECTOR - 1u) * BITS_PER_PAGE)
#define FAULT_DETAIL  7u /* detail of MR_FAULT_NOR_FAILED for this module */

static uint32_t get_address(unsigned copy, unsigned page)
{
    return (KEY_FIRST_SECTOR + copy) * NOR_SECTOR_BYTES + page * NOR_PAGE_BYTES;
}

void keystore_start(struct keystore *store)
{
    memset(store, 0, sizeof *store);
    store->state = MR_KEY_NOT_READ;
    store->valid_copy = KEY_COPIES;
    store->step = STEP_READ;
}

void keystore_set_memory(struct keystore *store, bool memory)
{
    bool read = store->state != MR_KEY_NOT_READ && store->state != MR_KEY_NO_MEMORY;
    if (read || memory == (store->state == MR_KEY_NOT_READ))
        return;
    keystore_start(store);
    if (!memory) {
        store->state = MR_KEY_NO_MEMORY;
        store->step = STEP_NONE;
    }
}

/* ---- start: read both copies, count the starts, mark this one ---- */

static void set_key_state(struct keystore *store, enum mr_key_state state)
{
    store->state = state;
    store->step = STEP_NONE;
    if (store->has_stale_copy) {
        store->target_copy = 1u - store->valid_copy;
        store->step = STEP_WIPE;
    }
    if (state == MR_KEY_DAMAGED)
        health_count_fault(MR_FAULT_NOR_FAILED, FAULT_DETAIL);
}

/* Makes the record in `buffer` the active key. */
static void use_record(struct keystore *store, unsigned copy)
{
    const uint8_t *p = store->buffer + 4;
    store->valid_copy = copy;
    store->change_number = mr_get_u32(&p);
    store->start_count = 0;
    store->is_set = mr_get_u32(&p) != 0;
    memcpy(store->key, p, MR_KEY_BYTES);
}

static bool is_valid_record(const uint8_t *record)
{
    const uint8_t *crc = record + CHECKED_BYTES;
    return mr_crc32(0, record, CHECKED_BYTES) == mr_get_u32(&crc);
}

/* Checks a copy. A damaged one is read again: the error may be in the transfer, not in the
 * memory. */
static void check_copy(struct keystore *store)
{
    const uint8_t *p = store->buffer;
    const uint8_t *behind = store->buffer + RECORD_BYTES;
    bool first = mr_get_u32(&p) == RECORD_MARK,
         marked = mr_get_u32(&behind) == RECORD_MARK || first;
    bool whole = first && is_valid_record(store->buffer);
    store->has_damaged_copy |= marked && !whole;
    if (!whole && ++store->tries < TRIES_MAX)
        return;
    store->tries = 0;
    store->has_stale_copy = whole && store->valid_copy != KEY_COPIES;
    if (whole && (store->valid_copy == KEY_COPIES || mr_get_u32(&p) > store->change_number))
        use_record(store, store->target_copy);
    if (++store->target_copy < KEY_COPIES)
        return;
    store->target_copy = store->valid_copy;
    store->page = 1;
    if (store->is_set)
        store->step = STEP_COUNT;
    else
        set_key_state(store, store->has_damaged_copy && store->valid_copy == KEY_COPIES
                                 ? MR_KEY_DAMAGED
                                 : MR_KEY_NONE);
}

/* Counts the starts: finds the last bit that is 0. A bit whose programming was interrupted by a
 * power failure may read as 0 or 1. */
static void count_starts(struct keystore *store)
{
    for (unsigned i = 0; i < NOR_PAGE_BYTES; i++) {
        unsigned zeros = ~store->buffer[i] & 0xffu;
        if (zeros)
            store->start_count = (store->page - 1u) * BITS_PER_PAGE + i * BITS_PER_BYTE +
                                 BITS_PER_BYTE - ((unsigned)__builtin_clz(zeros) - 24u);
    }
    if (++store->page < NOR_PAGES_PER_SECTOR)
        return;
    if (store->start_count >= STARTS_MAX) {
        set_key_state(store, MR_KEY_DAMAGED);
        return;
    }
    store->step = STEP_MARK;
    store->page = 1u + store->start_count / BITS_PER_PAGE;
}

/* Byte with the bit of this start. */
static uint8_t *get_start_byte(struct keystore *store)
{
    return &store->buffer[store->start_count % BITS_PER_PAGE / BITS_PER_BYTE];
}

static uint8_t get_start_mask(const struct keystore *store)
{
    return (uint8_t)(1u << store->start_count % BITS_PER_BYTE);
}

static void check_mark(struct keystore *store)
{
    bool marked = !(*get_start_byte(store) & get_start_mask(store));
    store->step = STEP_MARK;
    if (marked)
        store->start_count++;
    if (marked || ++store->tries == TRIES_MAX)
        set_key_state(store, marked ? MR_KEY_SET : MR_KEY_DAMAGED);
}

/* ---- a change ---- */

static void write_record(struct keystore *store)
{
    bool set = store->answer.code == MR_COMMAND_KEY_SET;
    memset(store->buffer, 0xff, sizeof store->buffer);
    uint8_t *p = mr_put_u32(
        mr_put_u32(mr_put_u32(store->buffer, RECORD_MARK), store->change_number + 1u), set);
    memset(p, 0, MR_KEY_BYTES);
    if (set)
        memcpy(p, store->staged_key, MR_KEY_BYTES);
    mr_put_u32(mr_put_u32(store->buffer + CHECKED_BYTES, mr_crc32(0, store->buffer, CHECKED_BYTES)),
               RECORD_MARK);
}

static void set_answer(struct keystore *store, enum mr_status status)
{
    store->step = STEP_NONE;
    store->answer.status = (int8_t)status;
    store->has_answer = store->answer.code !=
                        MR_COMMAND_INVALID; /* no command to answer: this is a start */
    store->received_words = 0;
    memset(store->staged_key, 0, sizeof store->staged_key);
}

static bool is_written_correctly(struct keystore *store)
{
    const uint8_t *p = store->buffer + 4;
    bool set = store->answer.code == MR_COMMAND_KEY_SET;
    return is_valid_record(store->buffer) && mr_get_u32(&p) == store->change_number + 1u &&
           mr_get_u32(&p) == set && (!set || memcmp(p, store->staged_key, MR_KEY_BYTES) == 0);
}

static void verify_record(struct keystore *store)
{
    if (is_written_correctly(store)) {
        unsigned old = 1u - store->target_copy;
        use_record(store, store->target_copy);
        store->state = store->is_set ? MR_KEY_SET : MR_KEY_NONE;
        store->target_copy = old;
        store->step = STEP_WIPE;
    } else if (++store->tries < TRIES_MAX) {
        store->step = STEP_ERASE;
    } else {
        health_count_fault(MR_FAULT_NOR_FAILED, FAULT_DETAIL);
        set_answer(store, MR_IO);
    }
}

/* ---- the memory ---- */

static void next_step(struct keystore *store)
{
    switch ((enum step)store->step) {
    case STEP_READ: check_copy(store); break;
    case STEP_COUNT: count_starts(store); break;
    case STEP_MARK: store->step = STEP_CHECK; break;
    case STEP_CHECK: check_mark(store); break;
    case STEP_ERASE: store->step = STEP_PROGRAM; break;
    case STEP_PROGRAM: store->step = STEP_VERIFY; break;
    case STEP_VERIFY: verify_record(store); break;
    case STEP_WIPE: set_answer(store, MR_OK); break;
    default: break;
    }
}

static void discard_copies(struct keystore *store)
{
    if (store->answer.code && !store->has_answer)
        set_answer(store, MR_IO);
    store->step = STEP_NONE;
    keystore_set_memory(store, false);
}

bool keystore_poll(struct keystore *store)
{
    if (!store->is_in_progress)
        return false;
    enum nor_status status = nor_poll();
    if (status == NOR_BUSY)
        return true;
    store->is_in_progress = false;
    if (status == NOR_MISSING || status == NOR_STUCK)
        discard_copies(store);
    else
        next_step(store); /* continue in any case: reading back shows whether it was successful */
    return false;
}

bool keystore_begin(struct keystore *store)
{
    bool of_starts = store->step >= STEP_COUNT && store->step <= STEP_CHECK;
    uint32_t address = get_address(store->target_copy, of_starts ? store->page : 0);
    if (store->step == STEP_NONE)
        return false;
    /* At start, the chip may still be busy with an operation that a reset interrupted. */
    enum nor_status status = nor_poll();
    if (status == NOR_MISSING || status == NOR_STUCK)
        discard_copies(store);
    if (status != NOR_IDLE && status != NOR_FAILED)
        return false;
    store->is_in_progress = true;
    if (store->step == STEP_ERASE || store->step == STEP_WIPE) {
        nor_begin_erase(address);
    } else if (store->step == STEP_MARK) {
        memset(store->buffer, 0xff, sizeof store->buffer);
        *get_start_byte(store) = (uint8_t)(0xffu ^ get_start_mask(store));
        nor_begin_program(address, store->buffer);
    } else if (store->step == STEP_PROGRAM) {
        write_record(store);
        nor_begin_program(address, store->buffer);
    } else {
        nor_begin_read(address, store->buffer, NOR_PAGE_BYTES);
    }
    return true;
}

void keystore_check(struct keystore *store)
{
    for (unsigned polls = 0; polls < POLLS_MAX && store->state == MR_KEY_NOT_READ; polls++) {
        if (!keystore_poll(store))
            keystore_begin(store);
    }
}

bool keystore_is_writing(const struct keystore *store)
{
    return store->step >= STEP_ERASE;
}

/* ---- commands ---- */

void keystore_put_word(struct keystore *store, const uint8_t *payload, size_t length)
{
    struct mr_key_word word;
    if (mr_key_word_get(&word, payload, length) != MR_OK || word.index >= MR_KEY_WORDS ||
        keystore_is_writing(store))
        return;
    if (word.tag != store->tag)
        store->received_words = 0;
    store->tag = word.tag;
    store->received_words = (uint8_t)(store->received_words | 1u << word.index);
    mr_put_u32(store->staged_key + 4u * word.index, word.value);
}

enum mr_status keystore_process_command(struct keystore *store, const struct mr_command *command)
{
    bool set = command->code == MR_COMMAND_KEY_SET;
    if (store->state == MR_KEY_NO_MEMORY)
        return MR_IO;
    if (store->state == MR_KEY_NOT_READ || keystore_is_writing(store))
        return MR_WAIT;
    if (set && store->received_words != (1u << MR_KEY_WORDS) - 1u)
        return MR_TOO_FEW;
    if (set && mr_crc32(0, store->staged_key, MR_KEY_BYTES) != (uint32_t)command->argument)
        return MR_CRC;
    store->answer = (struct mr_ack){.code = command->code, .tag = command->tag};
    store->has_answer = false;
    store->target_copy = store->valid_copy == 0 ? 1 : 0;
    store->tries = 0;
    store->step = STEP_ERASE;
    return MR_OK;
}

bool keystore_get_answer(struct keystore *store, struct mr_ack *answer)
{
    if (!store->has_answer)
        return false;
    *answer = store->answer;
    store->answer.code = MR_COMMAND_INVALID;
    store->has_answer = false;
    return true;
}
