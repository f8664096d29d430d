#include "host/replay/input.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/closure.h"
#include "common/command.h"
#include "common/crc32.h"
#include "host/base/xmalloc.h"

/* Range of the block in which a replay is armed. A record that is armed later than ARMED_BLOCK_MAX
 * is shifted to an earlier block, one that is armed before ARMED_BLOCK_MIN to a later block,
 * because zeros, survey and runway are entered before arming. The shift is in whole seconds, so
 * that the board's periodic actions, which depend on the block index, repeat. */
#define ARMED_BLOCK_MAX        20000
#define ARMED_BLOCK_MIN        450
#define BLOCKS_PER_S           1000
/* First block of the schedule before arming: one zero per block, then one survey segment every
 * second block, then one runway word per block. */
#define FIRST_COMMAND_BLOCK    40
#define COMMANDS_PER_BLOCK_MAX 4u
#define HELLO_CLOCK_INTERNAL   1 /* value of the clock field in the message hello */
#define RUNWAY_COMMAND_TAG     10000u
#define CHART_COMMAND_TAG      20000u
#define CHART_COMMAND_BLOCK    415u /* block after the last word of a runway */

/* ---- the board's messages ---- */

struct message_loader {
    struct board_messages *answers;
    int link;
    /* block of the newest change of landing state on the link; while the board is idle, few other
     * messages contain a time */
    int64_t state_block;
    size_t capacity; /* number of entries allocated in `block` */
    int64_t run;
    const char *path;
    struct error *error;
};

static void handle_board_type(struct board_messages *answers, uint32_t id, const uint8_t *data,
                              size_t length)
{
    struct mr_config_state state;
    if (id != MR_ID_CONFIG_STATE || mr_config_state_get(&state, data, length) != MR_OK)
        return;
    answers->board_type = state.board;
    answers->is_board_known = true;
}

static enum mr_status handle_frame(void *context, const struct store_frame *frame)
{
    struct message_loader *loading = context;
    struct board_messages *answers = loading->answers;
    size_t *count = &answers->message_count[loading->link];
    const struct mr_message_info *info = frame->id < 0x800 ? mr_message_find((uint16_t)frame->id)
                                                           : NULL;
    if (frame->direction != 0 || !info || info->direction == MR_DIRECTION_HOST ||
        info->length != frame->length)
        return MR_OK; /* a message of another program, or a command */
    xlist_grow(&answers->message[loading->link], *count, sizeof(struct board_message));
    struct board_message *answer = &answers->message[loading->link][(*count)++];
    *answer = (struct board_message){
        .info = info, .block = frame->board_us == STORE_NONE ? -1 : frame->board_us / 1000};
    memcpy(answer->data, frame->data, frame->length);
    if (info->id == MR_ID_LANDING) {
        struct mr_landing landing;
        mr_landing_get(&landing, answer->data, info->length);
        if ((int64_t)landing.block > loading->state_block)
            loading->state_block = landing.block;
    }
    if (answer->block < loading->state_block)
        answer->block = loading->state_block;
    handle_board_type(answers, info->id, answer->data, info->length);
    if (info->id == MR_ID_HELLO) {
        struct mr_hello hello;
        mr_hello_get(&hello, answer->data, info->length);
        if (hello.layout != MR_LAYOUT)
            return error_set(loading->error, MR_VERSION,
                             "the record uses layout %u, but this matrig uses layout %u: RUN %lld "
                             "of %s; use the matrig version that recorded the landing",
                             hello.layout, MR_LAYOUT, (long long)loading->run, loading->path);
    }
    return MR_OK;
}

static enum mr_status handle_block(void *context, const uint8_t *record, size_t length, int link)
{
    (void)link;
    struct message_loader *loading = context;
    struct board_messages *answers = loading->answers;
    if (answers->block_count == loading->capacity)
        return error_set(loading->error, MR_MALFORMED,
                         "the campaign changed while it was read: RUN %lld of %s; wait until no "
                         "program writes to the campaign",
                         (long long)loading->run, loading->path);
    if (mr_block_decode(&answers->block[answers->block_count], record, length) != MR_OK)
        return error_set(
            loading->error, MR_MALFORMED,
            "block record %zu is damaged: RUN %lld of %s; use a different copy of the campaign",
            answers->block_count + 1, (long long)loading->run, loading->path);
    answers->block_count++;
    return MR_OK;
}

static enum mr_status load_blocks(struct store *store, struct message_loader *loading)
{
    int64_t count;
    enum mr_status status = store_blocks_count(store, loading->run, &count, loading->error);
    if (status != MR_OK || count == 0)
        return status;
    loading->capacity = (size_t)count;
    loading->answers->block = xcalloc(loading->capacity, sizeof *loading->answers->block);
    return store_blocks_for_each(store, loading->run, handle_block, loading, loading->error);
}

enum mr_status board_messages_load(struct store *store, int64_t run, struct board_messages *answers,
                                   struct error *error)
{
    struct message_loader loading = {
        .answers = answers, .run = run, .path = store_path(store), .error = error};
    *answers = (struct board_messages){0};
    enum mr_status status = store_landing_get(store, run, &answers->landing, error);
    for (int link = 0; link < LINK_KINDS && status == MR_OK; link++) {
        loading.link = link;
        loading.state_block = -1;
        status = store_frames_for_each(store, run, link, handle_frame, &loading, error);
    }
    if (status == MR_OK)
        status = load_blocks(store, &loading);
    if (status != MR_OK)
        board_messages_free(answers);
    return status;
}

void board_messages_free(struct board_messages *answers)
{
    for (int link = 0; link < LINK_KINDS; link++)
        free(answers->message[link]);
    free(answers->block);
    *answers = (struct board_messages){0};
}

/* ---- the input file ---- */

struct replay_writer {
    FILE *file;
    uint32_t crc;
};

__attribute__((format(printf, 2, 3))) static void write_line(struct replay_writer *writer,
                                                             const char *format, ...)
{
    char line[2 * MR_BLOCK_BYTES_MAX + 40];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    writer->crc = mr_crc32(writer->crc, (const uint8_t *)line, (size_t)length);
    fputs(line, writer->file);
}

/* ---- checks ---- */

struct record_gaps {
    int64_t first_gap_start, first_gap_end; /* range of the first gap */
    int64_t total_blocks;                   /* total length of all gaps; 0: none */
};

static void add_gap(struct record_gaps *record_gaps, int64_t from, int64_t to)
{
    if (!record_gaps->total_blocks) {
        record_gaps->first_gap_start = from;
        record_gaps->first_gap_end = to;
    }
    record_gaps->total_blocks += to - from + 1;
}

static enum mr_status check_complete(const struct board_messages *recorded, const char *path,
                                     struct error *error)
{
    const struct store_landing *landing = &recorded->landing;
    struct record_gaps record_gaps = {0};
    if (recorded->block_count == 0)
        return error_set(
            error, MR_TRUNCATED,
            "no block records: RUN %lld of %s; replay a landing that was logged over serial",
            (long long)landing->id, path);
    if (landing->armed_block == STORE_NONE)
        return error_set(error, MR_TRUNCATED,
                         "the record begins after the arming: RUN %lld of %s; to replay a landing, "
                         "start the log before you arm the board",
                         (long long)landing->id, path);
    if (landing->clock_source > HELLO_CLOCK_INTERNAL)
        return error_set(error, MR_NOT_NOW,
                         "the board ran without PLL and measured nothing: RUN %lld of %s; replay a "
                         "different landing",
                         (long long)landing->id, path);
    if ((int64_t)recorded->block[0].index > landing->armed_block)
        add_gap(&record_gaps, landing->armed_block, (int64_t)recorded->block[0].index - 1);
    for (size_t i = 1; i < recorded->block_count; i++) {
        if (recorded->block[i].index != recorded->block[i - 1].index + 1u)
            add_gap(&record_gaps, (int64_t)recorded->block[i - 1].index + 1,
                    (int64_t)recorded->block[i].index - 1);
    }
    if (record_gaps.total_blocks)
        return error_set(error, MR_TRUNCATED,
                         "the record lacks %lld blocks: RUN %lld of %s, first blocks %lld to %lld "
                         "(%.3f s to %.3f s); complete the landing from the black box",
                         (long long)record_gaps.total_blocks, (long long)landing->id, path,
                         (long long)record_gaps.first_gap_start,
                         (long long)record_gaps.first_gap_end,
                         (double)record_gaps.first_gap_start / 1e3,
                         (double)(record_gaps.first_gap_end + 1) / 1e3);
    return MR_OK;
}

/* ---- commands ---- */

struct command_row {
    int64_t block;
    struct mr_command message;
};
struct command_list {
    /* a list without fixed limit, because other programs may have sent any number of commands */
    struct command_row *row;
    size_t count;
    bool is_armed, has_ended;
};

static bool add_command(struct command_list *commands, int64_t block, struct mr_command message)
{
    if (!list_grow(&commands->row, commands->count, sizeof *commands->row))
        return false;
    commands->row[commands->count].block = block;
    commands->row[commands->count++].message = message;
    return true;
}

/* Returns the link with more answers to commands; serial if the numbers are equal. */
static enum link_kind find_command_link(const struct board_messages *recorded)
{
    size_t acks[LINK_KINDS] = {0, 0};
    for (int link = 0; link < LINK_KINDS; link++) {
        for (size_t i = 0; i < recorded->message_count[link]; i++)
            acks[link] += recorded->message[link][i].info->id == MR_ID_ACK;
    }
    return acks[LINK_CAN] > acks[LINK_SERIAL] ? LINK_CAN : LINK_SERIAL;
}

/* Finds the argument of a command, from the answers of the board. For the command that sets a mark,
 * the number is in the message before the answer. */
static int32_t get_command_argument(const struct board_messages *recorded, const struct mr_ack *ack,
                                    const struct mr_mark *mark)
{
    if (ack->status == MR_USAGE)
        return -1;
    if (ack->code == MR_COMMAND_ARM)
        return (int32_t)recorded->landing.board_landing;
    return ack->code == MR_COMMAND_MARK ? (int32_t)mark->number : 0;
}

/* Collects the commands from their answers. If a command ends the landing, its answer arrives after
 * the end, so the command is derived from the landing's state instead. */
static bool collect_commands(const struct board_messages *recorded, struct command_list *commands)
{
    enum link_kind link = find_command_link(recorded);
    struct mr_mark mark = {0};
    struct mr_landing last = {0};
    bool fits = true;
    for (size_t i = 0; i < recorded->message_count[link]; i++) {
        const struct board_message *answer = &recorded->message[link][i];
        if (answer->info->id == MR_ID_MARK)
            mr_mark_get(&mark, answer->data, answer->info->length);
        if (answer->info->id == MR_ID_LANDING)
            mr_landing_get(&last, answer->data, answer->info->length);
        if (answer->info->id == MR_ID_BACKLOG) {
            struct mr_backlog backlog;
            mr_backlog_get(&backlog, answer->data, answer->info->length);
            fits = add_command(commands, backlog.block,
                               (struct mr_command){.code = MR_COMMAND_BACKLOG,
                                                   .argument = backlog.waiting}) &&
                   fits;
        }
        if (answer->info->id != MR_ID_ACK)
            continue;
        struct mr_ack ack;
        mr_ack_get(&ack, answer->data, answer->info->length);
        if ((int64_t)ack.block < recorded->landing.armed_block)
            continue;
        struct mr_command message = {.code = ack.code,
                                     .tag = ack.tag,
                                     .argument = get_command_argument(recorded, &ack, &mark)};
        /* the board refused this command because of its key; the replayed board has no key and
         * would execute it */
        if (mr_status_is_sender_refused(ack.status))
            message.code = MR_COMMAND_INVALID;
        commands->is_armed |= ack.code == MR_COMMAND_ARM && ack.status == MR_OK;
        fits = add_command(commands, ack.block, message) && fits;
    }
    if (last.state == MR_LANDING_IDLE && last.cause == MR_LANDING_BY_COMMAND &&
        recorded->message_count[link])
        fits = add_command(commands, last.block, (struct mr_command){.code = MR_COMMAND_DISARM}) &&
               fits;
    return fits;
}

/* Writes the zeros that were measured before the landing, exactly. Configured zeros are part of the
 * flash content. */
static void write_zero_lines(struct replay_writer *writer, const struct board_messages *recorded,
                             struct replay_input *input)
{
    struct mr_channel_zero zero[MR_CHANNELS] = {{0}};
    for (int link = 0; link < LINK_KINDS; link++) {
        for (size_t i = 0; i < recorded->message_count[link]; i++) {
            const struct board_message *answer = &recorded->message[link][i];
            struct mr_channel_zero each;
            if (answer->info->id == MR_ID_CHANNEL_ZERO &&
                mr_channel_zero_get(&each, answer->data, answer->info->length) == MR_OK &&
                each.index < MR_CHANNELS)
                zero[each.index] = each;
        }
    }
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        int32_t bits;
        memcpy(&bits, &zero[i].zero_code, sizeof bits);
        if (!zero[i].measured)
            continue;
        write_line(writer, "command %zu %d %u %zu %" PRId32 "\n",
                   FIRST_COMMAND_BLOCK + input->measured_zero_count, MR_COMMAND_ZERO, i + 1,
                   MR_SEGMENTS + 1u + input->measured_zero_count, bits);
        input->measured_zero_count++;
    }
}

/* Writes the runway state at arming. If the database has none, the replay begins with a new runway,
 * to which the survey is applied. */
static enum mr_status write_runway_lines(struct replay_writer *writer, struct store *store,
                                         const struct board_messages *recorded,
                                         struct replay_input *input, struct error *error)
{
    struct mr_predictor_state state;
    int64_t source;
    enum mr_status status = store_runway_get(store, recorded->landing.id, &state, &source,
                                             &input->has_runway, error);
    if (status != MR_OK || !input->has_runway)
        return status;
    size_t block = FIRST_COMMAND_BLOCK + input->measured_zero_count +
                   2 * input->survey_segment_count;
    for (unsigned i = 0; i < MR_RUNWAY_WORD_COUNT; i++)
        write_line(writer, "command %zu %d %u %u %" PRId32 "\n", block++, MR_COMMAND_RUNWAY_WORD, i,
                   RUNWAY_COMMAND_TAG + i, mr_runway_make_word_argument(&state, i));
    for (unsigned i = 0; i < 256 && 2 * i <= state.mats; i++)
        write_line(writer, "command %zu %d %u %u %" PRId32 "\n", block++, MR_COMMAND_RUNWAY_JOINTS,
                   i, RUNWAY_COMMAND_TAG + MR_RUNWAY_WORD_COUNT + i,
                   mr_runway_make_joints_argument(&state, i));
    write_line(writer, "command %zu %d 0 %u %" PRId32 "\n", block, MR_COMMAND_RUNWAY_TAKE,
               RUNWAY_COMMAND_TAG - 1u, (int32_t)mr_runway_crc(&state));
    return MR_OK;
}

/* Writes the risk chart and the plan that the board had at arming, if any: the last ones before
 * it. */
static enum mr_status write_chart_lines(struct replay_writer *writer, struct store *store,
                                        const struct board_messages *recorded, struct error *error)
{
    struct mr_risk_plan plan;
    float lamp_limit;
    size_t items, block = CHART_COMMAND_BLOCK, words = 0;
    enum mr_status status = store_risk_plan_get(store, recorded->landing.id, &plan, &lamp_limit,
                                                &items, error);
    if (status != MR_OK || isnan(plan.speed_ft_s))
        return status;
    for (unsigned i = 0; i < MR_RISK_PLAN_ITEM_COUNT; i++) {
        float value = mr_risk_plan_get_item(&plan, i);
        int32_t bits;
        memcpy(&bits, &value, sizeof bits);
        if (isnan(value))
            continue;
        write_line(writer, "command %zu %d %u %u %" PRId32 "\n",
                   block + words++ / COMMANDS_PER_BLOCK_MAX, MR_COMMAND_CHART_WORD, i,
                   CHART_COMMAND_TAG + i, bits);
    }
    write_line(writer, "command %zu %d 0 %u %" PRId32 "\n",
               block + words / COMMANDS_PER_BLOCK_MAX + 1u, MR_COMMAND_CHART_TAKE,
               CHART_COMMAND_TAG - 1u, (int32_t)mr_risk_plan_crc(&plan));
    return MR_OK;
}

static enum mr_status write_command_lines(struct replay_writer *writer, struct store *store,
                                          const struct board_messages *recorded,
                                          struct replay_input *input, struct error *error)
{
    struct command_list commands = {0};
    struct store_segment *segment;
    size_t segments;
    enum mr_status status = store_segments_get(store, recorded->landing.id, &segment, &segments,
                                               error);
    if (status != MR_OK)
        return status;
    write_zero_lines(writer, recorded, input);
    for (size_t i = 0; i < segments; i++) {
        if (isnan(segment[i].slack_in))
            continue;
        write_line(writer, "command %zu %d %lld %zu %ld\n",
                   FIRST_COMMAND_BLOCK + input->measured_zero_count +
                       2 * input->survey_segment_count,
                   MR_COMMAND_SURVEY, (long long)segment[i].segment,
                   input->survey_segment_count + 1, lround(segment[i].slack_in * 10000.0));
        input->survey_segment_count++;
    }
    free(segment);
    status = write_runway_lines(writer, store, recorded, input, error);
    if (status == MR_OK)
        status = write_chart_lines(writer, store, recorded, error);
    if (status != MR_OK)
        return status;
    bool fits = collect_commands(recorded, &commands);
    if (!commands.is_armed)
        write_line(writer, "command %lld %d 0 0 %lld\n",
                   (long long)(input->armed_block - input->shift_blocks), MR_COMMAND_ARM,
                   (long long)recorded->landing.board_landing);
    for (size_t i = 0; i < commands.count; i++) {
        const struct mr_command *message = &commands.row[i].message;
        write_line(writer, "command %lld %u %u %u %" PRId32 "\n",
                   (long long)(commands.row[i].block - input->shift_blocks), message->code,
                   message->index, message->tag, message->argument);
        fits = fits && (i < COMMANDS_PER_BLOCK_MAX ||
                        commands.row[i - COMMANDS_PER_BLOCK_MAX].block != commands.row[i].block);
    }
    input->command_count = commands.count;
    free(commands.row);
    return fits ? MR_OK
                : error_set(error, MR_MALFORMED,
                            "the record has more commands than the board accepts: RUN %lld of %s; "
                            "use a different copy of the campaign",
                            (long long)recorded->landing.id, store_path(store));
}

/* ---- edges ---- */

/* Returns the number of ticks from the start of TIM2 in the replay to a capture. The board time of
 * the capture gives the number of wraps of the counter. */
static uint64_t compute_capture_tick(double board_us, int64_t tick, const struct mr_block *first,
                                     int64_t shift_blocks)
{
    uint32_t origin = mr_boardtime_origin_tick(first->index, first->tick);
    uint32_t near_block = isnan(board_us) ? first->index : (uint32_t)(board_us / 1000.0);
    int64_t ticks = mr_boardtime_unwrap(origin, near_block, (uint32_t)tick) -
                    shift_blocks * (int64_t)MR_TICKS_PER_BLOCK;
    /* at the beginning of block 0, TIM2 has the value of the origin */
    return (uint64_t)(origin + ticks);
}

/* Writes switch edges, film frames, and edges of brake and wheel since arming, in order of time.
 * Captures that the board rejected as noise are not included. */
static enum mr_status write_capture_lines(struct replay_writer *writer, struct store *store,
                                          const struct board_messages *recorded,
                                          struct replay_input *input, struct error *error)
{
    struct store_edge *edge = NULL;
    struct store_film_frame *frame = NULL;
    struct store_braking_edge *braking = NULL;
    size_t brakings = 0;
    const struct mr_block *first = &recorded->block[0];
    int64_t run = recorded->landing.id, shift = input->shift_blocks;
    if (store_edges_get(store, run, &edge, &input->edge_count, error) == MR_OK &&
        store_film_frames_get(store, run, &frame, &input->film_frame_count, error) == MR_OK &&
        store_braking_edges_get(store, run, &braking, &brakings, error) == MR_OK) {
        for (size_t i = 0; i < input->edge_count; i++)
            write_line(writer, "edge %" PRIu64 "\n",
                       compute_capture_tick(edge[i].board_us, edge[i].tick, first, shift));
        for (size_t i = 0; i < input->film_frame_count; i++)
            write_line(writer, "frame %" PRIu64 "\n",
                       compute_capture_tick(frame[i].board_us, frame[i].tick, first, shift));
        for (size_t i = 0; i < brakings; i++)
            write_line(
                writer, "%s %" PRIu64 "\n", braking[i].number ? "wheel" : "brake",
                compute_capture_tick((double)braking[i].board_us, braking[i].tick, first, shift));
    }
    free(edge);
    free(frame);
    free(braking);
    return error->status;
}

/* ---- the file ---- */

static void write_block_line(struct replay_writer *writer, struct mr_block block,
                             int64_t shift_blocks)
{
    uint8_t record[MR_BLOCK_BYTES_MAX];
    char hex[2 * MR_BLOCK_BYTES_MAX + 1];
    block.index -= (uint32_t)shift_blocks;
    block.tick -= (uint32_t)shift_blocks * MR_TICKS_PER_BLOCK;
    size_t length = mr_block_encode(&block, record);
    for (size_t i = 0; i < length; i++)
        snprintf(hex + 2 * i, 3, "%02x", record[i]);
    write_line(writer, "block %s\n", hex);
}

static int64_t shift_blocks(int64_t armed_block)
{
    if (armed_block < ARMED_BLOCK_MIN)
        return -BLOCKS_PER_S;
    return armed_block > ARMED_BLOCK_MAX
             ? (armed_block - ARMED_BLOCK_MIN) / BLOCKS_PER_S * BLOCKS_PER_S
             : 0;
}

static enum mr_status write_replay_lines(struct replay_writer *writer, struct store *store,
                                         const struct board_messages *recorded,
                                         struct replay_input *input, struct error *error)
{
    const struct store_landing *landing = &recorded->landing;
    fputs("matrig-replay 1\n", writer->file);
    writer->crc = mr_crc32(0, (const uint8_t *)"matrig-replay 1\n", 16);
    if (strlen(landing->board_uid) == 24)
        write_line(writer, "uid %.8s %.8s %.8s\n", landing->board_uid, landing->board_uid + 8,
                   landing->board_uid + 16);
    write_line(writer, "crystal %d\n", input->uses_crystal);
    enum mr_status status = write_command_lines(writer, store, recorded, input, error);
    if (status == MR_OK)
        status = write_capture_lines(writer, store, recorded, input, error);
    for (size_t i = 0; status == MR_OK && i < recorded->block_count; i++)
        write_block_line(writer, recorded->block[i], input->shift_blocks);
    fprintf(writer->file, "end %08x\n", (unsigned)writer->crc);
    return status;
}

enum mr_status replay_input_write(struct store *store, const struct board_messages *recorded,
                                  const char *path, struct replay_input *input, struct error *error)
{
    enum mr_status status = check_complete(recorded, store_path(store), error);
    if (status != MR_OK)
        return status;
    *input = (struct replay_input){
        .shift_blocks = shift_blocks(recorded->landing.armed_block),
        .first_block = recorded->block[0].index,
        .last_block = recorded->block[recorded->block_count - 1].index,
        .armed_block = recorded->landing.armed_block,
        .uses_crystal = recorded->landing.clock_source != HELLO_CLOCK_INTERNAL,
    };
    struct replay_writer writer = {.file = fopen(path, "w")};
    if (!writer.file)
        return error_set(error, MR_IO, "cannot write: %s; check the folder for temporary files",
                         path);
    status = write_replay_lines(&writer, store, recorded, input, error);
    int failed = ferror(writer.file);
    failed |= fclose(writer.file);
    if (status == MR_OK && failed)
        status = error_set(error, MR_IO, "cannot write: %s; free space on the disk", path);
    return status;
}
