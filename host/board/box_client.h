/* Talking to a board's black box over serial: its records, one of them page by page, freeing. */
#ifndef MATRIG_HOST_BOARD_BOX_CLIENT_H
#define MATRIG_HOST_BOARD_BOX_CLIENT_H

#include "common/boxpage.h"
#include "common/catalogue.h"
#include "host/board/dialogue.h"

#define BOX_CLIENT_RECORDS 256u

struct box_client_record {
    struct mr_box_record record;
    struct mr_box_span span;
};

struct box_client {
    struct dialogue *dialogue;
    bool state_known, space_known;
    struct mr_box_state state;
    struct mr_box_space space;
    struct box_client_record records[BOX_CLIENT_RECORDS];
    size_t count;
    bool listed;
    /* being read out */
    uint16_t reading;
    uint8_t (*pages)[MR_BOXPAGE];
    uint8_t *present;
    size_t page_count, parts;
    uint8_t half[MR_BOXPAGE / 2];
    uint32_t half_page; /* whose first half stands in `half` */
    bool ended;
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits until the board says hello. Statuses
 * as dialogue_hello. */
enum mr_status box_client_begin(struct box_client *talk, struct dialogue *dialogue,
                                struct error *error);
/* Fills state, space and records. MR_TIMEOUT, or what the board answered. */
enum mr_status box_client_list(struct box_client *talk, struct error *error);
/* Pages of a listed record; those `present` are not asked for again, those that cannot be read stay
 * absent. Both arrays have room for record.pages. */
enum mr_status box_client_read(struct box_client *talk, const struct box_client_record *record,
                               uint8_t (*pages)[MR_BOXPAGE], uint8_t *present, struct error *error);
enum mr_status box_client_free(struct box_client *talk, uint16_t record, struct error *error);

#endif
