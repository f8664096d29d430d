#include "firmware/runwaystore.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/health.h"

enum step { STEP_NONE, STEP_READ, STEP_READ_AGAIN, STEP_ERASE, STEP_PROGRAM, STEP_VERIFY };

#define COPY_PAGES ((MR_RUNWAY_IMAGE_BYTES + NOR_PAGE_BYTES - 1u) / NOR_PAGE_BYTES)
#define TRIES_MAX  3u

_Static_assert(COPY_PAGES <= NOR_PAGES_PER_SECTOR, "each copy fits into one sector");

static uint32_t get_address(unsigned copy, unsigned page)
{
    return (RUNWAY_FIRST_SECTOR + copy) * NOR_SECTOR_BYTES + page * NOR_PAGE_BYTES;
}

static unsigned get_page_length(unsigned page)
{
    unsigned left = MR_RUNWAY_IMAGE_BYTES - page * NOR_PAGE_BYTES;
    return left < NOR_PAGE_BYTES ? left : NOR_PAGE_BYTES;
}

void runwaystore_start(struct runwaystore *store)
{
    memset(store, 0, sizeof *store);
    memset(store->copy_state, (int)RUNWAYSTORE_NOT_READ, sizeof store->copy_state);
    store->step = STEP_READ;
}

void runwaystore_set_memory(struct runwaystore *store, bool memory)
{
    if (memory == !store->has_no_memory)
        return;
    runwaystore_start(store);
    store->has_no_memory = !memory;
    if (!memory)
        memset(store->copy_state, (int)RUNWAYSTORE_NO_MEMORY, sizeof store->copy_state);
}

static bool is_damaged(uint8_t copy)
{
    return copy != (uint8_t)MR_OK && copy < RUNWAYSTORE_NOT_READ;
}

/* Returns the newest intact copy; RUNWAY_COPIES if there is none. */
static unsigned find_newest_copy(const struct runwaystore *store)
{
    bool a = store->copy_state[0] == MR_OK, b = store->copy_state[1] == MR_OK;
    if (a && b)
        return (int32_t)(store->sequence[1] - store->sequence[0]) > 0 ? 1 : 0;
    return a ? 0 : b ? 1 : RUNWAY_COPIES;
}

/* Checks a copy that was read. A damaged copy is read again, because the error may be in the
 * transfer and not in the memory. */
static void check_copy(struct runwaystore *store, struct predict *predict)
{
    /* predict->state may be used here, because nothing is armed before the runway is loaded */
    struct mr_predictor_state *state = &predict->state;
    enum mr_status status = mr_runway_decode(state, &store->sequence[store->step_copy],
                                             store->image);
    store->copy_state[store->step_copy] = mr_is_blank(store->image, MR_RUNWAY_IMAGE_BYTES)
                                            ? RUNWAYSTORE_BLANK
                                            : (uint8_t)-status;
    store->page = 0;
    if (is_damaged(store->copy_state[store->step_copy]) && ++store->tries < TRIES_MAX)
        return;
    store->tries = 0;
    if (++store->step_copy < RUNWAY_COPIES)
        return;
    store->step_copy = find_newest_copy(store);
    store->step = STEP_READ_AGAIN;
    if (store->step_copy < RUNWAY_COPIES)
        return;
    store->step = STEP_NONE;
    store->is_loaded = true;
    if (is_damaged(store->copy_state[0]) || is_damaged(store->copy_state[1]))
        health_count_fault(MR_FAULT_NOR_FAILED, RUNWAYSTORE_FAULT_DETAIL);
}

/* Loads the newest whole copy, unless it belongs to another runway. */
static void load_newest(struct runwaystore *store, struct predict *predict, const float *slack_in)
{
    enum mr_status status = mr_runway_decode(&predict->state, &store->sequence[store->step_copy],
                                             store->image);
    if (status == MR_OK)
        status = predict_load(predict, store->step_copy ? MR_RUNWAY_COPY_B : MR_RUNWAY_COPY_A,
                              slack_in);
    if (status != MR_OK)
        store->copy_state[store->step_copy] = (uint8_t)-status;
    store->step = STEP_NONE;
    store->is_loaded = true;
}

static void next_page(struct runwaystore *store)
{
    if (store->step == STEP_ERASE) {
        store->step = STEP_PROGRAM;
        store->page = 1;
    } else if (store->step == STEP_PROGRAM) {
        store->step = store->page == 0 ? STEP_VERIFY : STEP_PROGRAM;
        store->page = store->page == 0 || store->page + 1u == COPY_PAGES ? 0 : store->page + 1u;
    } else {
        store->page++;
    }
}

static void end_writing(struct runwaystore *store, struct predict *predict, bool holds)
{
    store->copy_state[store->step_copy] = holds ? (uint8_t)MR_OK : (uint8_t)-MR_IO;
    if (!holds && ++store->tries < TRIES_MAX) {
        store->step = STEP_ERASE;
        store->page = 0;
        return;
    }
    if (!holds)
        health_count_fault(MR_FAULT_NOR_FAILED, RUNWAYSTORE_FAULT_DETAIL);
    store->step = STEP_NONE;
    store->tries = 0;
    predict_mark_stored(predict, store->crc);
}

/* Handles a page that was read. */
static void handle_page(struct runwaystore *store, struct predict *predict, const float *slack_in)
{
    uint8_t *of_image = store->image + store->page * NOR_PAGE_BYTES;
    unsigned length = get_page_length(store->page);
    if (store->step == STEP_VERIFY && memcmp(of_image, store->buffer, length) != 0) {
        end_writing(store, predict, false);
        return;
    }
    memcpy(of_image, store->buffer, length);
    next_page(store);
    if (store->page < COPY_PAGES)
        return;
    if (store->step == STEP_VERIFY)
        end_writing(store, predict, true);
    else if (store->step == STEP_READ)
        check_copy(store, predict);
    else
        load_newest(store, predict, slack_in);
}

bool runwaystore_poll(struct runwaystore *store, struct predict *predict, const float *slack_in)
{
    if (!store->is_in_progress)
        return false;
    enum nor_status status = nor_poll();
    if (status == NOR_BUSY)
        return true;
    store->is_in_progress = false;
    if (status == NOR_MISSING || status == NOR_STUCK)
        runwaystore_set_memory(store, false);
    else if (store->step == STEP_ERASE || store->step == STEP_PROGRAM)
        next_page(store); /* continue in any case: reading back shows whether it was successful */
    else if (store->step != STEP_NONE)
        handle_page(store, predict, slack_in);
    return false;
}

/* Begins to write the present runway into the older copy. */
static void begin_writing(struct runwaystore *store, struct predict *predict)
{
    unsigned last = find_newest_copy(store);
    uint32_t sequence = last < RUNWAY_COPIES ? store->sequence[last] + 1u : 1u;
    store->step_copy = last == 0 ? 1 : 0;
    store->sequence[store->step_copy] = sequence;
    store->copy_state[store->step_copy] = RUNWAYSTORE_BLANK;
    store->step = STEP_ERASE;
    store->page = 0;
    store->tries = 0;
    mr_runway_encode(predict_get_state(predict), sequence, store->image);
    store->crc = predict->crc;
}

static void begin_operation(struct runwaystore *store)
{
    uint32_t address = get_address(store->step_copy, store->page);
    store->is_in_progress = true;
    if (store->step == STEP_ERASE) {
        nor_begin_erase(address);
    } else if (store->step == STEP_PROGRAM) {
        memset(store->buffer, 0xff, sizeof store->buffer);
        memcpy(store->buffer, store->image + store->page * NOR_PAGE_BYTES,
               get_page_length(store->page));
        nor_begin_program(address, store->buffer);
    } else {
        nor_begin_read(address, store->buffer, get_page_length(store->page));
    }
}

bool runwaystore_begin(struct runwaystore *store, struct predict *predict, bool quiet,
                       uint32_t now_ms)
{
    bool writing = store->step >= STEP_ERASE;
    if (store->has_no_memory || predict->status != MR_OK)
        return false;
    /* stop writing this copy: the next one is written when the board is idle again, with the state
     * of that time */
    if (writing && (!quiet || !predict->is_dirty))
        store->step = STEP_NONE;
    if (store->step == STEP_NONE && store->is_loaded && quiet && predict->is_dirty &&
        now_ms - predict->changed_block >= RUNWAYSTORE_QUIET_BLOCKS)
        begin_writing(store, predict);
    if (store->step == STEP_NONE)
        return false;
    begin_operation(store);
    return true;
}

bool runwaystore_is_erasing(const struct runwaystore *store)
{
    return store->is_in_progress && store->step == STEP_ERASE;
}

bool runwaystore_is_loaded(const struct runwaystore *store)
{
    return store->is_loaded || store->has_no_memory;
}
