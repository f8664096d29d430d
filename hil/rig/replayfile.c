#include "hil/rig/replayfile.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/crc32.h"
#include "hil/core/file_place.h"
#include "hil/rig/codes.h"

#define LINE_MAX_BYTES 400u /* a block record is 198 hex digits at most */

#define refuse(r, ...) hil_file_refuse(&(r)->at, __VA_ARGS__)

struct reader {
    struct hil_file_place at; /* line: the present one */
    struct hil_replay *replay;
    size_t block_room, edge_room, frame_room, command_room;
};

/* Room for one more element; aborts on lack of memory, as the board itself does. */
static void *grow(void *array, size_t count, size_t *room, size_t size)
{
    if (count < *room)
        return array;
    *room = *room ? 2 * *room : 256;
    array = realloc(array, *room * size);
    if (!array)
        abort();
    return array;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

static enum mr_status read_block(struct reader *r, const char *text)
{
    struct hil_replay *replay = r->replay;
    uint8_t record[MR_BLOCK_BYTES_MAX];
    size_t digits = strlen(text);
    struct mr_block block;
    struct hil_codes codes;
    unsigned channel;
    if (digits % 2 || digits / 2 > sizeof record)
        return refuse(r, MR_MALFORMED, "a block record of %zu hex digits", digits);
    for (size_t i = 0; i < digits; i++) {
        int digit = hex_digit(text[i]);
        if (digit < 0)
            return refuse(r, MR_MALFORMED, "`%c` is no hex digit", text[i]);
        record[i / 2] = (uint8_t)(i % 2 ? record[i / 2] << 4 | digit : digit);
    }
    if (mr_block_get(&block, record, digits / 2) != MR_OK)
        return refuse(r, MR_MALFORMED, "no block record of this layout");
    if (replay->block_count) {
        const struct mr_block *last = &replay->blocks[replay->block_count - 1];
        if (block.index != last->index + 1u || block.tick != last->tick + MR_TICKS_PER_BLOCK)
            return refuse(r, MR_MALFORMED, "block %u does not follow block %u",
                          (unsigned)block.index, (unsigned)last->index);
    } else {
        replay->origin_tick = block.tick - block.index * MR_TICKS_PER_BLOCK;
        if (replay->origin_tick >= MR_TICKS_PER_BLOCK)
            return refuse(r, MR_MALFORMED, "block %u cannot begin at tick %u",
                          (unsigned)block.index, (unsigned)block.tick);
    }
    if (!hil_codes_of(&block, &codes, &channel))
        return refuse(r, MR_MALFORMED,
                      "block %u, channel %u: no codes have this sum and these counts",
                      (unsigned)block.index, channel);
    replay->blocks = grow(replay->blocks, replay->block_count, &r->block_room, sizeof block);
    replay->blocks[replay->block_count++] = block;
    return MR_OK;
}

/* A tick, at least `apart` behind the one before it. */
static enum mr_status read_tick(struct reader *r, const char *text, const char *word,
                                uint64_t apart, const char *order, uint64_t **ticks, size_t *count,
                                size_t *room)
{
    uint64_t tick;
    int end = 0;
    if (sscanf(text, "%" SCNu64 "%n", &tick, &end) != 1 || text[end] ||
        tick > (uint64_t)INT64_MAX / 8u)
        return refuse(r, MR_MALFORMED, "`%s <tick>` expected", word);
    if (*count && tick < (*ticks)[*count - 1] + apart)
        return refuse(r, MR_MALFORMED, "%s", order);
    *ticks = grow(*ticks, *count, room, sizeof tick);
    (*ticks)[(*count)++] = tick;
    return MR_OK;
}

static enum mr_status read_command(struct reader *r, const char *text)
{
    struct hil_replay *replay = r->replay;
    struct hil_replay_command command;
    unsigned code, index, tag;
    int end = 0;
    if (sscanf(text, "%" SCNu32 " %u %u %u %" SCNd32 "%n", &command.block, &code, &index, &tag,
               &command.message.argument, &end) != 5 ||
        text[end] || code > 255 || index > 255 || tag > 65535)
        return refuse(r, MR_MALFORMED,
                      "`command <block> <code> <index> <tag> <argument>` expected");
    command.message.code = (uint8_t)code;
    command.message.index = (uint8_t)index;
    command.message.tag = (uint16_t)tag;
    if (replay->command_count && command.block < replay->commands[replay->command_count - 1].block)
        return refuse(r, MR_MALFORMED, "commands must be in order of time");
    replay->commands = grow(replay->commands, replay->command_count, &r->command_room,
                            sizeof command);
    replay->commands[replay->command_count++] = command;
    return MR_OK;
}

static enum mr_status read_line(struct reader *r, const char *line)
{
    struct hil_replay *replay = r->replay;
    unsigned crystal;
    int end = 0;
    if (line[0] == '#' || line[0] == '\0')
        return MR_OK;
    if (strncmp(line, "block ", 6) == 0)
        return read_block(r, line + 6);
    if (strncmp(line, "edge ", 5) == 0)
        return read_tick(r, line + 5, "edge", 1, "edges must be in order of time",
                         &replay->edge_tick, &replay->edge_count, &r->edge_room);
    if (strncmp(line, "frame ", 6) == 0)
        return read_tick(r, line + 6, "frame", MR_TICKS_PER_BLOCK,
                         "film frames must be in order of time, a millisecond apart",
                         &replay->frame_tick, &replay->frame_count, &r->frame_room);
    if (strncmp(line, "command ", 8) == 0)
        return read_command(r, line + 8);
    if (strncmp(line, "uid ", 4) == 0) {
        if (sscanf(line, "uid %8" SCNx32 " %8" SCNx32 " %8" SCNx32 "%n", &replay->uid[0],
                   &replay->uid[1], &replay->uid[2], &end) != 3 ||
            line[end])
            return refuse(r, MR_MALFORMED, "`uid <word> <word> <word>` expected");
        replay->has_uid = true;
        return MR_OK;
    }
    if (sscanf(line, "crystal %1u%n", &crystal, &end) == 1 && !line[end] && crystal <= 1) {
        replay->crystal = crystal;
        return MR_OK;
    }
    return refuse(r, MR_MALFORMED, "unknown line `%.20s`", line);
}

static enum mr_status read_end(struct reader *r, const char *text, uint32_t crc)
{
    uint32_t stated;
    int end = 0;
    if (sscanf(text, "%8" SCNx32 "%n", &stated, &end) != 1 || text[end])
        return refuse(r, MR_MALFORMED, "`end <crc32>` expected");
    if (stated != crc)
        return refuse(r, MR_CRC,
                      "checksum is %08x but the file says %08x: it was changed or damaged",
                      (unsigned)crc, (unsigned)stated);
    return r->replay->block_count ? MR_OK : refuse(r, MR_MALFORMED, "no block records");
}

static enum mr_status parse(struct reader *r, FILE *file)
{
    char line[LINE_MAX_BYTES];
    uint32_t crc = 0;
    unsigned version;
    while (fgets(line, sizeof line, file)) {
        size_t length = strlen(line);
        r->at.line++;
        if (!length || line[length - 1] != '\n')
            return refuse(r, MR_TRUNCATED, "the file ends inside a line, or the line is too long");
        line[length - 1] = '\0';
        if (r->at.line == 1) {
            if (sscanf(line, "matrig-replay %u", &version) != 1)
                return refuse(r, MR_MALFORMED,
                              "not a replay file: it does not begin with `matrig-replay 1`");
            if (version != 1)
                return refuse(r, MR_VERSION,
                              "replay file of version %u; this program reads version 1", version);
        } else if (strncmp(line, "end ", 4) == 0) {
            return read_end(r, line + 4, crc);
        } else {
            enum mr_status status = read_line(r, line);
            if (status != MR_OK)
                return status;
        }
        line[length - 1] = '\n';
        crc = mr_crc32(crc, (const uint8_t *)line, length);
    }
    return ferror(file)
             ? refuse(r, MR_IO, "cannot be read: %s; give a file that matrig replay wrote",
                      strerror(errno))
             : refuse(r, MR_TRUNCATED, "the file ends without its `end` line");
}

enum mr_status hil_replay_read(const char *path, struct hil_replay *replay, char *error,
                               size_t size)
{
    struct reader reader = {.at = {path, 0, error, size}, .replay = replay};
    *replay = (struct hil_replay){.crystal = true};
    FILE *file = fopen(path, "r");
    if (!file)
        return refuse(&reader, MR_IO, "cannot open the replay file: %s", strerror(errno));
    enum mr_status status = parse(&reader, file);
    fclose(file);
    if (status != MR_OK)
        hil_replay_free(replay);
    return status;
}

void hil_replay_free(struct hil_replay *replay)
{
    free(replay->blocks);
    free(replay->edge_tick);
    free(replay->frame_tick);
    free(replay->commands);
    *replay = (struct hil_replay){0};
}
