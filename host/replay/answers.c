#include "host/replay/answers.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

struct loading {
    struct answers *answers;
    int link;
    /* block of the newest change of state on the link: while idle, little else tells the time */
    int64_t told;
    size_t room; /* for blocks */
    int64_t run;
    const char *path;
    struct error *error;
};

static void take_board(struct answers *answers, uint32_t id, const uint8_t *data, size_t length)
{
    struct mr_config_state state;
    if (id != MR_ID_CONFIG_STATE || mr_config_state_get(&state, data, length) != MR_OK)
        return;
    answers->board = state.board;
    answers->board_told = true;
}

static enum mr_status take_frame(void *context, const struct store_frame *frame)
{
    struct loading *loading = context;
    struct answers *answers = loading->answers;
    size_t *count = &answers->messages[loading->link];
    const struct mr_message_info *info = frame->id < 0x800 ? mr_message_find((uint16_t)frame->id)
                                                           : NULL;
    if (frame->direction != 0 || !info || info->direction == MR_DIRECTION_HOST ||
        info->length != frame->length)
        return MR_OK; /* somebody else's, or a command */
    xlist_grow(&answers->message[loading->link], *count, sizeof(struct answer));
    struct answer *answer = &answers->message[loading->link][(*count)++];
    *answer = (struct answer){.info = info,
                              .block = frame->board_us == STORE_NONE ? -1 : frame->board_us / 1000};
    memcpy(answer->data, frame->data, frame->length);
    if (info->id == MR_ID_LANDING) {
        struct mr_landing landing;
        mr_landing_get(&landing, answer->data, info->length);
        if ((int64_t)landing.block > loading->told)
            loading->told = landing.block;
    }
    if (answer->block < loading->told)
        answer->block = loading->told;
    take_board(answers, info->id, answer->data, info->length);
    if (info->id == MR_ID_HELLO) {
        struct mr_hello hello;
        mr_hello_get(&hello, answer->data, info->length);
        if (hello.layout != MR_LAYOUT)
            return error_set(loading->error, MR_VERSION,
                             "recorded in layout %u, this matrig has layout %u: RUN %lld of %s; "
                             "use the matrig that recorded it",
                             hello.layout, MR_LAYOUT, (long long)loading->run, loading->path);
    }
    return MR_OK;
}

static enum mr_status take_block(void *context, const uint8_t *record, size_t length, int link)
{
    (void)link;
    struct loading *loading = context;
    struct answers *answers = loading->answers;
    if (answers->blocks == loading->room)
        return error_set(loading->error, MR_MALFORMED,
                         "more block records than counted: RUN %lld of %s; is it being written to?",
                         (long long)loading->run, loading->path);
    if (mr_block_get(&answers->block[answers->blocks], record, length) != MR_OK)
        return error_set(loading->error, MR_MALFORMED,
                         "block record %zu is damaged: RUN %lld of %s; take another copy",
                         answers->blocks + 1, (long long)loading->run, loading->path);
    answers->blocks++;
    return MR_OK;
}

static enum mr_status load_blocks(struct store *store, struct loading *loading)
{
    int64_t count;
    enum mr_status status = store_blocks_count(store, loading->run, &count, loading->error);
    if (status != MR_OK || count == 0)
        return status;
    loading->room = (size_t)count;
    loading->answers->block = xcalloc(loading->room, sizeof *loading->answers->block);
    return store_blocks_each(store, loading->run, take_block, loading, loading->error);
}

enum mr_status answers_load(struct store *store, int64_t run, struct answers *answers,
                            struct error *error)
{
    struct loading loading = {
        .answers = answers, .run = run, .path = store_path(store), .error = error};
    *answers = (struct answers){0};
    enum mr_status status = store_landing_get(store, run, &answers->landing, error);
    for (int link = 0; link < LINK_KINDS && status == MR_OK; link++) {
        loading.link = link;
        loading.told = -1;
        status = store_frames_each(store, run, link, take_frame, &loading, error);
    }
    if (status == MR_OK)
        status = load_blocks(store, &loading);
    if (status != MR_OK)
        answers_free(answers);
    return status;
}

static enum mr_status take_board_frame(void *context, const struct store_frame *frame)
{
    if (frame->direction == 0)
        take_board(context, frame->id, frame->data, frame->length);
    return MR_OK;
}

void answers_load_board(struct store *store, int64_t run, struct answers *answers)
{
    struct error ignored = {0};
    *answers = (struct answers){0};
    for (int link = 0; link < LINK_KINDS; link++)
        (void)store_frames_each(store, run, link, take_board_frame, answers, &ignored);
}

void answers_free(struct answers *answers)
{
    for (int link = 0; link < LINK_KINDS; link++)
        free(answers->message[link]);
    free(answers->block);
    *answers = (struct answers){0};
}
