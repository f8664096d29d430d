#include "firmware/keystore.h"

#include <string.h>

#include "common/command.h"
#include "common/crc32.h"
#include "common/wire.h"
#include "firmware/health.h"

/* Steps in the order of a start, then of a change. */
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

#define MARK         0x594b524du /* "MRKY" */
#define CHECKED      (12u + MR_KEY_BYTES)
#define RECORD       (CHECKED + 4u) /* MARK again follows the record */
#define TRIES        3u
#define POLLS        20000u
#define BITS         8u
#define BITS_A_PAGE  (NOR_PAGE * BITS)
#define STARTS_MOST  ((NOR_PAGES_PER_SECTOR - 1u) * BITS_A_PAGE)
#define FAULT_DETAIL 7u /* detail of MR_FAULT_NOR_FAILED */

static uint32_t address_of(unsigned copy, unsigned page)
{
    return (KEY_FIRST_SECTOR + copy) * NOR_SECTOR + page * NOR_PAGE;
}

void keystore_start(struct keystore *store)
{
    memset(store, 0, sizeof *store);
    store->state = MR_KEY_NOT_READ;
    store->copy = KEY_COPIES;
    store->step = STEP_READ;
}

void keystore_follow(struct keystore *store, bool memory)
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

static void known(struct keystore *store, enum mr_key_state state)
{
    store->state = state;
    store->step = STEP_NONE;
    if (store->stale) {
        store->at = 1u - store->copy;
        store->step = STEP_WIPE;
    }
    if (state == MR_KEY_DAMAGED)
        health_count(MR_FAULT_NOR_FAILED, FAULT_DETAIL);
}

/* Makes the record in `buffer` the key in force. */
static void take_record(struct keystore *store, unsigned copy)
{
    const uint8_t *p = store->buffer + 4;
    store->copy = copy;
    store->change = mr_get_u32(&p);
    store->starts = 0;
    store->set = mr_get_u32(&p) != 0;
    memcpy(store->key, p, MR_KEY_BYTES);
}

static bool is_whole(const uint8_t *record)
{
    const uint8_t *crc = record + CHECKED;
    return mr_crc32(0, record, CHECKED) == mr_get_u32(&crc);
}

/* Checks a copy. A damaged one is read again: the error may be in the transfer, not in the
 * memory. */
static void check_copy(struct keystore *store)
{
    const uint8_t *p = store->buffer;
    const uint8_t *behind = store->buffer + RECORD;
    bool first = mr_get_u32(&p) == MARK, marked = mr_get_u32(&behind) == MARK || first;
    bool whole = first && is_whole(store->buffer);
    store->damaged |= marked && !whole;
    if (!whole && ++store->tries < TRIES)
        return;
    store->tries = 0;
    store->stale = whole && store->copy != KEY_COPIES;
    if (whole && (store->copy == KEY_COPIES || mr_get_u32(&p) > store->change))
        take_record(store, store->at);
    if (++store->at < KEY_COPIES)
        return;
    store->at = store->copy;
    store->page = 1;
    if (store->set)
        store->step = STEP_COUNT;
    else
        known(store, store->damaged && store->copy == KEY_COPIES ? MR_KEY_DAMAGED : MR_KEY_OPEN);
}

/* Finds the last bit that is 0. A bit torn by a power loss may read as either. */
static void count_page(struct keystore *store)
{
    for (unsigned i = 0; i < NOR_PAGE; i++) {
        unsigned zeros = ~store->buffer[i] & 0xffu;
        if (zeros)
            store->starts = (store->page - 1u) * BITS_A_PAGE + i * BITS + BITS -
                            ((unsigned)__builtin_clz(zeros) - 24u);
    }
    if (++store->page < NOR_PAGES_PER_SECTOR)
        return;
    if (store->starts >= STARTS_MOST) {
        known(store, MR_KEY_DAMAGED);
        return;
    }
    store->step = STEP_MARK;
    store->page = 1u + store->starts / BITS_A_PAGE;
}

/* Byte with the bit of this start. */
static uint8_t *byte_of_start(struct keystore *store)
{
    return &store->buffer[store->starts % BITS_A_PAGE / BITS];
}

static uint8_t mask_of_start(const struct keystore *store)
{
    return (uint8_t)(1u << store->starts % BITS);
}

static void check_mark(struct keystore *store)
{
    bool marked = !(*byte_of_start(store) & mask_of_start(store));
    store->step = STEP_MARK;
    if (marked)
        store->starts++;
    if (marked || ++store->tries == TRIES)
        known(store, marked ? MR_KEY_SET : MR_KEY_DAMAGED);
}

/* ---- a change ---- */

static void write_record(struct keystore *store)
{
    bool set = store->answer.code == MR_COMMAND_KEY_SET;
    memset(store->buffer, 0xff, sizeof store->buffer);
    uint8_t *p = mr_put_u32(mr_put_u32(mr_put_u32(store->buffer, MARK), store->change + 1u), set);
    memset(p, 0, MR_KEY_BYTES);
    if (set)
        memcpy(p, store->staged, MR_KEY_BYTES);
    mr_put_u32(mr_put_u32(store->buffer + CHECKED, mr_crc32(0, store->buffer, CHECKED)), MARK);
}

static void answer(struct keystore *store, enum mr_status status)
{
    store->step = STEP_NONE;
    store->answer.status = (int8_t)status;
    store->answered = store->answer.code != MR_COMMAND_NONE; /* a start has no command to answer */
    store->received = 0;
    memset(store->staged, 0, sizeof store->staged);
}

static bool is_as_written(struct keystore *store)
{
    const uint8_t *p = store->buffer + 4;
    bool set = store->answer.code == MR_COMMAND_KEY_SET;
    return is_whole(store->buffer) && mr_get_u32(&p) == store->change + 1u &&
           mr_get_u32(&p) == set && (!set || memcmp(p, store->staged, MR_KEY_BYTES) == 0);
}

static void verify(struct keystore *store)
{
    if (is_as_written(store)) {
        unsigned old = 1u - store->at;
        take_record(store, store->at);
        store->state = store->set ? MR_KEY_SET : MR_KEY_OPEN;
        store->at = old;
        store->step = STEP_WIPE;
    } else if (++store->tries < TRIES) {
        store->step = STEP_ERASE;
    } else {
        health_count(MR_FAULT_NOR_FAILED, FAULT_DETAIL);
        answer(store, MR_IO);
    }
}

/* ---- the memory ---- */

static void next_step(struct keystore *store)
{
    switch ((enum step)store->step) {
    case STEP_READ: check_copy(store); break;
    case STEP_COUNT: count_page(store); break;
    case STEP_MARK: store->step = STEP_CHECK; break;
    case STEP_CHECK: check_mark(store); break;
    case STEP_ERASE: store->step = STEP_PROGRAM; break;
    case STEP_PROGRAM: store->step = STEP_VERIFY; break;
    case STEP_VERIFY: verify(store); break;
    case STEP_WIPE: answer(store, MR_OK); break;
    default: break;
    }
}

static void forget_memory(struct keystore *store)
{
    if (store->answer.code && !store->answered)
        answer(store, MR_IO);
    store->step = STEP_NONE;
    keystore_follow(store, false);
}

bool keystore_busy(struct keystore *store)
{
    if (!store->under_way)
        return false;
    enum nor_status status = nor_poll();
    if (status == NOR_BUSY)
        return true;
    store->under_way = false;
    if (status == NOR_MISSING || status == NOR_STUCK)
        forget_memory(store);
    else
        next_step(store); /* reading back shows whether it succeeded */
    return false;
}

bool keystore_begin(struct keystore *store)
{
    bool of_starts = store->step >= STEP_COUNT && store->step <= STEP_CHECK;
    uint32_t address = address_of(store->at, of_starts ? store->page : 0);
    if (store->step == STEP_NONE)
        return false;
    /* at a start the chip may still be busy with an operation that a reset interrupted */
    enum nor_status status = nor_poll();
    if (status == NOR_MISSING || status == NOR_STUCK)
        forget_memory(store);
    if (status != NOR_IDLE && status != NOR_FAILED)
        return false;
    store->under_way = true;
    if (store->step == STEP_ERASE || store->step == STEP_WIPE) {
        nor_begin_erase(address);
    } else if (store->step == STEP_MARK) {
        memset(store->buffer, 0xff, sizeof store->buffer);
        *byte_of_start(store) = (uint8_t)(0xffu ^ mask_of_start(store));
        nor_begin_program(address, store->buffer);
    } else if (store->step == STEP_PROGRAM) {
        write_record(store);
        nor_begin_program(address, store->buffer);
    } else {
        nor_begin_read(address, store->buffer, NOR_PAGE);
    }
    return true;
}

void keystore_check(struct keystore *store)
{
    for (unsigned polls = 0; polls < POLLS && store->state == MR_KEY_NOT_READ; polls++) {
        if (!keystore_busy(store))
            keystore_begin(store);
    }
}

bool keystore_writing(const struct keystore *store)
{
    return store->step >= STEP_ERASE;
}

/* ---- commands ---- */

void keystore_word(struct keystore *store, const uint8_t *payload, size_t length)
{
    struct mr_key_word word;
    if (mr_key_word_get(&word, payload, length) != MR_OK || word.index >= MR_KEY_WORDS ||
        keystore_writing(store))
        return;
    if (word.tag != store->tag)
        store->received = 0;
    store->tag = word.tag;
    store->received = (uint8_t)(store->received | 1u << word.index);
    mr_put_u32(store->staged + 4u * word.index, word.value);
}

enum mr_status keystore_execute(struct keystore *store, const struct mr_command *command)
{
    bool set = command->code == MR_COMMAND_KEY_SET;
    if (store->state == MR_KEY_NO_MEMORY)
        return MR_IO;
    if (store->state == MR_KEY_NOT_READ || keystore_writing(store))
        return MR_WAIT;
    if (set && store->received != (1u << MR_KEY_WORDS) - 1u)
        return MR_TOO_FEW;
    if (set && mr_crc32(0, store->staged, MR_KEY_BYTES) != (uint32_t)command->argument)
        return MR_CRC;
    store->answer = (struct mr_ack){.code = command->code, .tag = command->tag};
    store->answered = false;
    store->at = store->copy == 0 ? 1 : 0;
    store->tries = 0;
    store->step = STEP_ERASE;
    return MR_OK;
}

bool keystore_answer(struct keystore *store, struct mr_ack *answer)
{
    if (!store->answered)
        return false;
    *answer = store->answer;
    store->answer.code = MR_COMMAND_NONE;
    store->answered = false;
    return true;
}
