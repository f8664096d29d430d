#include "host/collect/backfill.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/boxpage.h"
#include "common/catalogue.h"
#include "host/collect/collect.h"
#include "host/collect/collect_state.h"
#include "host/base/xmalloc.h"

/* the black box counts as a third kind of link, besides CAN and serial */
#define BLACK_BOX_LINK ((enum link_kind)STORE_LINK_BLACK_BOX)
_Static_assert(1 << STORE_LINK_BLACK_BOX == BACKFILL_LINK_BIT,
               "the link number of the black box equals the mark of its rows");

/* A collector for one landing, which receives the messages of the record. */
struct box_collector {
    struct collector collector;
    struct link_state side;
    struct landing_slot slot;
};

static enum mr_status find_landing(struct store *store, const struct mr_boxpage_start_page *start,
                                   const char *uid, int64_t *run, struct error *error)
{
    struct store_landing *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_landings_get(store, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (rows[i].board_landing == start->landing && strcmp(rows[i].board_uid, uid) == 0 &&
            (rows[i].armed_block == STORE_NONE ||
             rows[i].armed_block == (int64_t)start->armed_block))
            *run = rows[i].id;
    }
    free(rows);
    return status;
}

static enum mr_status create_landing(struct store *store, int64_t session,
                                     const struct mr_boxpage_start_page *start, const char *uid,
                                     int64_t *run, struct error *error)
{
    struct store_landing landing = {
        .session = session,
        .board_landing = start->landing,
        .armed_block = start->armed_block,
        .armed_us = (int64_t)link_now_us(),
        .state = MR_LANDING_ARMED,
        .image_crc = start->image_crc,
        .config_crc = start->config_crc,
        .clock_source = start->clock_source,
        .touchdown_ft = (double)NAN,
        .switch_error_ft = (double)NAN,
    };
    snprintf(landing.board_uid, sizeof landing.board_uid, "%s", uid);
    snprintf(landing.firmware, sizeof landing.firmware, "%u.%u.%u", start->firmware[0],
             start->firmware[1], start->firmware[2]);
    enum mr_status status = store_landing_add(store, &landing, error);
    *run = landing.id;
    return status;
}

/* Begins to process the messages of the black box in the session and boot of the landing, as if a
 * link had delivered them. Rows that the log already has are marked and not added again. */
static void begin_box_collector(struct box_collector *m, struct store *store,
                                const struct store_landing *landing)
{
    *m = (struct box_collector){
        .collector = {.store = store,
                      .session = landing->session,
                      .reported = {.hello_known = true, .identity = *landing}},
        .side = {.kind = BLACK_BOX_LINK, .boot = landing->boot},
        .slot = {.row = *landing}};
    m->side.current_landing = &m->slot;
}

/* Applies the newest state of the record. If the log already has the end of the landing, the
 * landing stays ended. */
static enum mr_status apply_newest_state(struct box_collector *m, const struct mr_record *record,
                                         bool made, struct error *error)
{
    struct store_landing *row = &m->slot.row;
    struct mr_landing landing;
    if (mr_landing_get(&landing, record->payload, record->length) != MR_OK ||
        landing.landing != row->board_landing)
        return MR_OK;
    if (made || (row->state != MR_LANDING_IDLE && row->state != MR_LANDING_DONE))
        row->state = landing.state;
    enum mr_status status = store_landing_put(m->collector.store, row, error);
    return status == MR_OK && landing.cause
             ? collect_put_state_event(&m->collector, &m->side, &landing, link_now_us(), error)
             : status;
}

static enum mr_status handle_message(struct box_collector *m, const struct mr_record *record,
                                     bool made, struct error *error)
{
    struct mr_message message;
    if (record->id == MR_ID_LANDING)
        return apply_newest_state(m, record, made, error);
    if (mr_message_decode(&message, record->id, record->payload, record->length) != MR_OK)
        return MR_OK;
    const struct collector_event event = {.link = m->side.kind,
                                          .message = &message,
                                          .host_us = link_now_us(),
                                          .board_us = STORE_NONE};
    return collect_message(&m->collector, &m->side, &event, error);
}

static enum mr_status fill_block(struct store *store, int64_t session, const struct mr_block *block,
                                 struct backfill *result, struct error *error)
{
    uint8_t bytes[MR_BLOCK_BYTES_MAX];
    int64_t known = -1;
    result->block_count++;
    enum mr_status status = store_find_block_within(store, result->run, block->index, block->index,
                                                    &known, error);
    if (status != MR_OK || known >= 0)
        return status;
    result->filled_blocks++;
    return store_block_put(store, session, 0, result->run, STORE_LINK_BLACK_BOX, block->index,
                           (int64_t)link_now_us(), bytes, mr_block_encode(block, bytes), error);
}

static enum mr_status count_edges(struct store *store, int64_t run, int64_t *edges,
                                  struct error *error)
{
    struct store_edge *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_edges_get(store, run, &rows, &count, error);
    free(rows);
    *edges = (int64_t)count;
    return status;
}

static enum mr_status fill_landing(struct store *store, int64_t session,
                                   struct mr_box_reader *reader, struct backfill *result,
                                   struct error *error)
{
    struct mr_record record;
    struct box_collector *messages = xmalloc(sizeof *messages);
    struct store_landing landing;
    int64_t first = 0, newest = 0, edges = 0, more = 0;
    enum mr_status status = store_landing_get(store, result->run, &landing, error);
    if (status == MR_OK)
        status = count_edges(store, result->run, &edges, error);
    if (status == MR_OK)
        begin_box_collector(messages, store, &landing);
    while (status == MR_OK && mr_box_reader_next(reader, &record) == MR_OK) {
        if (record.kind != MR_RECORD_BLOCK) {
            status = handle_message(messages, &record, result->is_new_landing, error);
            continue;
        }
        newest = record.block.index;
        first = result->block_count ? first : newest;
        timebase_apply_clock(&messages->side.timebase, record.block.index, record.block.tick);
        status = fill_block(store, session, &record.block, result, error);
    }
    free(messages);
    if (status == MR_OK)
        status = count_edges(store, result->run, &more, error);
    result->filled_edges = more - edges;
    if (result->block_count)
        result->missing_blocks = newest - first + 1 - result->block_count;
    return status;
}

enum mr_status backfill_store_record(struct store *store, const char *link, int64_t run,
                                     const uint8_t (*pages)[MR_BOXPAGE_BYTES],
                                     const uint8_t *present, size_t count, struct backfill *result,
                                     struct error *error)
{
    struct mr_boxpage_header header = {0};
    struct mr_boxpage_start_page start;
    struct mr_box_reader reader;
    struct store_session session = {.started_us = (int64_t)link_now_us(), .serial_link = link};
    char uid[25];
    if (!count || !present[0] || mr_boxpage_check(pages[0], &header) != MR_OK ||
        header.kind != MR_BOXPAGE_START)
        return error_set(
            error, MR_MALFORMED,
            "the record cannot be assigned to a landing, because its first page is missing: %s",
            link);
    mr_boxpage_get_start(pages[0], &start);
    if (start.layout != MR_LAYOUT)
        return error_set(error, MR_VERSION,
                         "the record uses layout %u, but this matrig uses layout %u: %s; use the "
                         "matrig version that belongs to that firmware",
                         start.layout, MR_LAYOUT, link);
    snprintf(uid, sizeof uid, "%08X%08X%08X", start.uid[0], start.uid[1], start.uid[2]);
    *result = (struct backfill){.run = run};
    enum mr_status status = run ? MR_OK : find_landing(store, &start, uid, &result->run, error);
    if (status == MR_OK)
        status = store_begin(store, error);
    if (status == MR_OK)
        status = store_session_add(store, &session, error);
    result->is_new_landing = status == MR_OK && !result->run;
    if (result->is_new_landing)
        status = create_landing(store, session.id, &start, uid, &result->run, error);
    mr_box_reader_begin(&reader, pages[0], present, count);
    if (status == MR_OK)
        status = fill_landing(store, session.id, &reader, result, error);
    if (status == MR_OK)
        status =
            store_event_put(store,
                            &(struct store_event){.session = session.id,
                                                  .run = result->run,
                                                  .kind = "blackbox",
                                                  .board_us = 1000 * (int64_t)start.trigger_block,
                                                  .host_us = (int64_t)link_now_us(),
                                                  .code = header.record,
                                                  .detail = result->filled_blocks,
                                                  .value = result->missing_blocks,
                                                  .links = BACKFILL_LINK_BIT},
                            error);
    if (status == MR_OK)
        status = store_session_end(store, session.id, (int64_t)link_now_us(), "black box", error);
    if (status == MR_OK)
        status = store_commit(store, error);
    return status;
}
