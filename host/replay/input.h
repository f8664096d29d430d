/* A recorded landing: the board's messages and block records, and the replay input with which an
 * emulated board must reproduce them. */
#ifndef MATRIG_HOST_REPLAY_INPUT_H
#define MATRIG_HOST_REPLAY_INPUT_H

#include <stdbool.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/link/link.h"
#include "host/store/store.h"

/* One message of the board in a recorded landing. */
struct board_message {
    const struct mr_message_info *info;
    /* block of the message, or else the newest block of the link when it was received; -1: not
     * known */
    int64_t block;
    uint8_t data[MR_MESSAGE_BYTES_MAX];
};

struct board_messages {
    struct store_landing landing;
    struct board_message *message[LINK_KINDS]; /* messages in order of reception */
    size_t message_count[LINK_KINDS];
    struct mr_block *block; /* block records, ascending by index */
    size_t block_count;
    unsigned board_type; /* type of the board: common/boards.def */
    bool is_board_known; /* the record names the board */
};

/* Loads the messages and blocks of a landing. MR_MALFORMED: an invalid record. MR_VERSION: a board
 * with another layout. Release with board_messages_free. */
enum mr_status board_messages_load(struct store *store, int64_t run, struct board_messages *answers,
                                   struct error *error);
void board_messages_free(struct board_messages *answers);

/* Input of a board during a recorded landing, reconstructed from its messages: its block records,
 * the edges and film frames that it reported, and the commands that it acknowledged. It is written
 * as a replay file for the emulated board (`matrig-replay 1`: one line per command, edge, film
 * frame and block; hil/rig/replay.h generates the signals).
 *
 * Some input is not recorded and is therefore generated. Before arming, the survey is entered
 * segment by segment, measured zeros are set (channel_zero of the landing lists them with their
 * values), and the predictor's runway is set to its state at arming. Blocks before the first record
 * get the data of the first record. A record that begins long after the board's start is shifted to
 * earlier blocks by whole seconds, because the board's periodic actions repeat every second. */
struct replay_input {
    int64_t shift_blocks; /* block n of the replay is block n + shift_blocks of the record */
    int64_t first_block;  /* first block of the record */
    int64_t last_block;
    int64_t armed_block;
    size_t edge_count;
    size_t film_frame_count; /* number of film frames */
    /* number of commands; each is sent in the block in which the board executed it */
    size_t command_count;
    size_t survey_segment_count; /* number of segments entered before arming */
    bool has_runway;             /* the replay sets the predictor's runway to its state at arming */
    size_t measured_zero_count;  /* number of measured zeros set before arming */
    bool uses_crystal;
};

/* Writes the replay file. MR_TOO_FEW: there are no block records, or logging started during the
 * landing. MR_TRUNCATED: the record has gaps; `error` has their times. MR_NOT_NOW: the board had no
 * time base. */
enum mr_status replay_input_write(struct store *store, const struct board_messages *recorded,
                                  const char *path, struct replay_input *input,
                                  struct error *error);

#endif
