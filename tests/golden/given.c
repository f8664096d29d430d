/* What the board was given. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "common/command.h"
#include "common/crc32.h"
#include "common/runway.h"
#include "host/replay/input.h"
#include "host/store/store.h"
#include "tests/golden/golden.h"

#define LINE          8192
#define COUNTS_PER_IN 10000.0 /* argument of the command survey */
#define HMIL_PER_IN   1e5
#define HEX_DIGITS    400

static unsigned command_code(const char *name)
{
    for (unsigned code = 1; code < 256; code++) {
        if (strcmp(mr_command_name(code), name) == 0)
            return code;
    }
    golden_fail(4, "there is no command `%s` any more: record what is given anew", name);
}

static float float_of(int32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int32_t bits_of(float value)
{
    int32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static bool is_runway(unsigned code)
{
    return code == MR_COMMAND_RUNWAY_WORD || code == MR_COMMAND_RUNWAY_JOINTS ||
           code == MR_COMMAND_RUNWAY_TAKE;
}

/* ---- taken from a replay file ---- */

static void take_command(struct golden_given *given, const char *line)
{
    struct golden_command command = {0};
    unsigned code;
    int32_t argument;
    if (sscanf(line, "command %ld %u %u %u %" SCNd32, &command.block, &code, &command.index,
               &command.tag, &argument) != 5)
        golden_fail(4, "a command expected: %s", line);
    if (is_runway(code)) {
        if (!given->has_runway) {
            given->runway_block = command.block;
            given->runway_tag = command.tag;
        }
        given->has_runway = true;
        return;
    }
    snprintf(command.name, sizeof command.name, "%s", mr_command_name(code));
    command.argument = argument;
    if (code == MR_COMMAND_SURVEY)
        command.argument = argument / COUNTS_PER_IN;
    if (code == MR_COMMAND_ZERO && command.index)
        command.argument = (double)float_of(argument);
    given->command = golden_grow(given->command, given->commands, sizeof command);
    given->command[given->commands++] = command;
}

static void take_block(struct golden_given *given, const char *hex)
{
    uint8_t record[MR_BLOCK_BYTES_MAX];
    size_t n = 0;
    unsigned byte;
    for (; n < sizeof record && sscanf(hex + 2 * n, "%2x", &byte) == 1; n++)
        record[n] = (uint8_t)byte;
    given->block = golden_grow(given->block, given->blocks, sizeof *given->block);
    if (mr_block_decode(&given->block[given->blocks++], record, n) != MR_OK)
        golden_fail(4, "no block record: %s", hex);
}

static void take_tick(uint64_t **list, size_t *count, const char *text)
{
    *list = golden_grow(*list, *count, sizeof **list);
    (*list)[(*count)++] = strtoull(text, NULL, 10);
}

static void take_lines(struct golden_given *given, const char *path)
{
    char line[LINE];
    FILE *file = fopen(path, "r");
    if (!file || !fgets(line, sizeof line, file) || strcmp(line, "matrig-replay 1\n") != 0)
        golden_fail(4, "not a replay file: %s", path);
    while (fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = '\0';
        if (strncmp(line, "command ", 8) == 0)
            take_command(given, line);
        else if (strncmp(line, "block ", 6) == 0)
            take_block(given, line + 6);
        else if (strncmp(line, "edge ", 5) == 0)
            take_tick(&given->edge, &given->edges, line + 5);
        else if (strncmp(line, "frame ", 6) == 0)
            take_tick(&given->frame, &given->frames, line + 6);
        else if (strncmp(line, "crystal ", 8) == 0)
            given->crystal = atoi(line + 8);
        else if (strncmp(line, "uid ", 4) == 0 &&
                 sscanf(line, "uid %" SCNx32 " %" SCNx32 " %" SCNx32, &given->uid[0],
                        &given->uid[1], &given->uid[2]) != 3)
            golden_fail(4, "%s", line);
    }
    fclose(file);
}

/* What `matrig replay` would give to the board, by name. */
void given_take(struct golden_given *given, const char *db, long run, const char *scratch_path)
{
    struct error error = {0};
    struct store *store = NULL;
    struct board_messages answers = {0};
    struct replay_input input;
    int64_t source;
    bool runway = false;
    *given = (struct golden_given){.crystal = 1};
    enum mr_status status = store_open(db, STORE_READ, &store, &error);
    if (status == MR_OK)
        status = board_messages_load(store, run, &answers, &error);
    if (status == MR_OK)
        status = replay_input_write(store, &answers, scratch_path, &input, &error);
    if (status == MR_OK)
        status = store_runway_get(store, run, &given->runway, &source, &runway, &error);
    if (status != MR_OK)
        golden_fail(4, "%s", error.text);
    if (input.shift_blocks)
        golden_fail(4, "RUN %ld begins too late after the board's start: log it from the start",
                    run);
    given->config = given_config_take((uint32_t)answers.landing.config_crc);
    take_lines(given, scratch_path);
    if (given->has_runway != runway)
        golden_fail(4, "RUN %ld: the runway is given in part", run);
    board_messages_free(&answers);
    store_close(store);
}

/* ---- the golden file ---- */

static void write_block(gzFile file, const struct mr_block *block, const struct mr_block *before)
{
    for (unsigned i = 0; i < MR_BLOCK_SUMS; i++)
        gzprintf(file, "%s%d", i ? " " : "", block->sums[i] - before->sums[i]);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (block->low_count[c])
            gzprintf(file, " l%u:%u", c, block->low_count[c]);
        if (block->high_count[c])
            gzprintf(file, " h%u:%u", c, block->high_count[c]);
    }
    gzprintf(file, "\n");
}

static void write_runway(gzFile file, const struct golden_given *given)
{
    const struct mr_predictor_state *runway = &given->runway;
    gzprintf(file, "runway %ld %u %.9g %u %u\njoints_in", given->runway_block, given->runway_tag,
             (double)runway->resistance_scale, runway->landing_count, runway->mats);
    for (unsigned i = 0; i <= runway->mats; i++)
        gzprintf(file, " %.5f", runway->gap_counts[i] / HMIL_PER_IN);
    gzprintf(file, "\n");
}

static void write_config(gzFile file, const char *text)
{
    unsigned lines = 0;
    for (const char *p = text; *p; p++)
        lines += *p == '\n';
    gzprintf(file, "config %u\n", lines);
    gzputs(file, text);
}

void given_write(const struct golden_given *given, const char *path)
{
    static const struct mr_block none;
    gzFile file = gzopen(path, "wb9");
    if (!file)
        golden_fail(3, "cannot write %s: %s", path, strerror(errno));
    gzprintf(file, "matrig-golden-given 1\nuid %08x %08x %08x\ncrystal %d\n",
             (unsigned)given->uid[0], (unsigned)given->uid[1], (unsigned)given->uid[2],
             given->crystal);
    write_config(file, given->config);
    for (size_t i = 0; i < given->commands; i++) {
        const struct golden_command *c = &given->command[i];
        if (strcmp(c->name, "survey") == 0)
            gzprintf(file, "survey %ld %u %u %.4f\n", c->block, c->tag, c->index, c->argument);
        else if (strcmp(c->name, "zero") == 0 && c->index)
            gzprintf(file, "zero %ld %u %u %.9g\n", c->block, c->tag, c->index, c->argument);
        else
            gzprintf(file, "command %ld %u %s %u %.0f\n", c->block, c->tag, c->name, c->index,
                     c->argument);
    }
    if (given->has_runway)
        write_runway(file, given);
    for (size_t i = 0; i < given->edges; i++)
        gzprintf(file, "edge %" PRIu64 "\n", given->edge[i]);
    for (size_t i = 0; i < given->frames; i++)
        gzprintf(file, "frame %" PRIu64 "\n", given->frame[i]);
    gzprintf(file, "blocks %u %u %zu %06x\n", (unsigned)given->block[0].index,
             (unsigned)given->block[0].tick, given->blocks,
             (unsigned)given->block[0].absent_channels);
    for (size_t i = 0; i < given->blocks; i++)
        write_block(file, &given->block[i], i ? &given->block[i - 1] : &none);
    gzprintf(file, "end\n");
    if (gzclose(file) != Z_OK)
        golden_fail(3, "cannot write %s: is there room?", path);
}

static void read_config(struct golden_given *given, gzFile file, const char *line, const char *path)
{
    char row[LINE];
    size_t length = 0;
    long lines = strtol(line + 7, NULL, 10);
    for (; lines > 0; lines--) {
        if (!gzgets(file, row, sizeof row))
            golden_fail(4, "%s ends in the configuration", path);
        given->config = realloc(given->config, length + strlen(row) + 1);
        if (!given->config)
            golden_fail(3, "no memory");
        strcpy(given->config + length, row);
        length += strlen(row);
    }
}

static void read_joints(struct golden_given *given, char *text)
{
    for (unsigned i = 0; i <= given->runway.mats && i < MR_RUNWAY_JOINTS; i++)
        given->runway.gap_counts[i] = (uint16_t)lround(strtod(text, &text) * HMIL_PER_IN);
}

static void read_block(struct golden_given *given, char *text, uint32_t index, uint32_t tick,
                       uint32_t absent)
{
    given->block = golden_grow(given->block, given->blocks, sizeof *given->block);
    struct mr_block *block = &given->block[given->blocks];
    *block = (struct mr_block){.index = index, .tick = tick, .absent_channels = absent};
    for (unsigned i = 0; i < MR_BLOCK_SUMS; i++)
        block->sums[i] =
            (uint16_t)(strtol(text, &text, 10) + (given->blocks ? block[-1].sums[i] : 0));
    unsigned channel, count;
    char kind;
    int length;
    for (;
         sscanf(text, " %c%u:%u%n", &kind, &channel, &count, &length) == 3 && channel < MR_CHANNELS;
         text += length)
        (kind == 'l' ? block->low_count : block->high_count)[channel] = (uint8_t)count;
    if (text[strspn(text, " \n")])
        golden_fail(4, "block %u: `%s`", (unsigned)index, text);
    given->blocks++;
}

static void read_blocks(struct golden_given *given, gzFile file, const char *line, const char *path)
{
    unsigned first, tick, absent;
    size_t count;
    char row[LINE];
    if (sscanf(line, "blocks %u %u %zu %x", &first, &tick, &count, &absent) != 4)
        golden_fail(4, "%s: %s", path, line);
    for (size_t i = 0; i < count; i++) {
        if (!gzgets(file, row, sizeof row))
            golden_fail(4, "%s ends among its blocks", path);
        read_block(given, row, first + (uint32_t)i, tick + (uint32_t)i * MR_TICKS_PER_BLOCK,
                   absent);
    }
}

static void read_command(struct golden_given *given, const char *line, const char *path)
{
    struct golden_command c = {0};
    if (sscanf(line, "command %ld %u %47s %u %lf", &c.block, &c.tag, c.name, &c.index,
               &c.argument) != 5) {
        if (sscanf(line, "%47s %ld %u %u %lf", c.name, &c.block, &c.tag, &c.index, &c.argument) !=
            5)
            golden_fail(4, "%s: %s", path, line);
    }
    given->command = golden_grow(given->command, given->commands, sizeof c);
    given->command[given->commands++] = c;
}

static void read_runway(struct golden_given *given, gzFile file, const char *line, const char *path)
{
    unsigned landings, mats;
    char row[LINE];
    if (sscanf(line, "runway %ld %u %f %u %u", &given->runway_block, &given->runway_tag,
               &given->runway.resistance_scale, &landings, &mats) != 5 ||
        !gzgets(file, row, sizeof row) || strncmp(row, "joints_in ", 10) != 0 ||
        mats + 1u > MR_RUNWAY_JOINTS)
        golden_fail(4, "%s: %s", path, line);
    given->has_runway = true;
    given->runway.landing_count = (uint16_t)landings;
    given->runway.mats = (uint16_t)mats;
    read_joints(given, row + 10);
}

void given_read(struct golden_given *given, const char *path)
{
    char line[LINE];
    gzFile file = gzopen(path, "rb");
    *given = (struct golden_given){0};
    if (!file || !gzgets(file, line, sizeof line) || strcmp(line, "matrig-golden-given 1\n") != 0)
        golden_fail(file ? 4 : 3, "not a file of what a golden landing was given: %s", path);
    while (gzgets(file, line, sizeof line) && strcmp(line, "end\n") != 0) {
        if (strncmp(line, "survey ", 7) == 0 || strncmp(line, "zero ", 5) == 0 ||
            strncmp(line, "command ", 8) == 0)
            read_command(given, line, path);
        else if (strncmp(line, "config ", 7) == 0)
            read_config(given, file, line, path);
        else if (strncmp(line, "runway ", 7) == 0)
            read_runway(given, file, line, path);
        else if (strncmp(line, "edge ", 5) == 0)
            take_tick(&given->edge, &given->edges, line + 5);
        else if (strncmp(line, "frame ", 6) == 0)
            take_tick(&given->frame, &given->frames, line + 6);
        else if (strncmp(line, "blocks ", 7) == 0)
            read_blocks(given, file, line, path);
        else if (sscanf(line, "crystal %d", &given->crystal) != 1 &&
                 sscanf(line, "uid %" SCNx32 " %" SCNx32 " %" SCNx32, &given->uid[0],
                        &given->uid[1], &given->uid[2]) != 3)
            golden_fail(4, "%s: %s", path, line);
    }
    if (strcmp(line, "end\n") != 0 || !given->blocks || !given->config)
        golden_fail(4, "%s ends early", path);
    gzclose(file);
}

/* ---- the replay file of today ---- */

struct writer {
    FILE *file;
    uint32_t crc;
};

__attribute__((format(printf, 2, 3))) static void put(struct writer *writer, const char *format,
                                                      ...)
{
    char line[HEX_DIGITS];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    writer->crc = mr_crc32(writer->crc, (const uint8_t *)line, (size_t)length);
    fputs(line, writer->file);
}

static void put_runway(struct writer *writer, const struct golden_given *given)
{
    const struct mr_predictor_state *state = &given->runway;
    long block = given->runway_block;
    unsigned tag = given->runway_tag;
    for (unsigned i = 0; i < MR_RUNWAY_WORD_COUNT; i++)
        put(writer, "command %ld %d %u %u %" PRId32 "\n", block++, MR_COMMAND_RUNWAY_WORD, i, tag++,
            mr_runway_make_word_argument(state, i));
    for (unsigned i = 0; i < 256 && 2 * i <= state->mats; i++)
        put(writer, "command %ld %d %u %u %" PRId32 "\n", block++, MR_COMMAND_RUNWAY_JOINTS, i,
            tag++, mr_runway_make_joints_argument(state, i));
    put(writer, "command %ld %d 0 %u %" PRId32 "\n", block, MR_COMMAND_RUNWAY_TAKE,
        given->runway_tag - 1u, (int32_t)mr_runway_crc(state));
}

static void write_command_lines(struct writer *writer, const struct golden_given *given)
{
    bool runway = !given->has_runway;
    for (size_t i = 0; i < given->commands; i++) {
        const struct golden_command *c = &given->command[i];
        unsigned code = command_code(c->name);
        int32_t argument = (int32_t)c->argument;
        if (code == MR_COMMAND_SURVEY)
            argument = (int32_t)lround(c->argument * COUNTS_PER_IN);
        if (code == MR_COMMAND_ZERO && c->index)
            argument = bits_of((float)c->argument);
        if (!runway && c->block >= given->runway_block) { /* commands are in order of time */
            put_runway(writer, given);
            runway = true;
        }
        put(writer, "command %ld %u %u %u %" PRId32 "\n", c->block, code, c->index, c->tag,
            argument);
    }
    if (!runway)
        put_runway(writer, given);
}

void given_replay(const struct golden_given *given, const char *replay_path)
{
    struct writer writer = {.file = fopen(replay_path, "w")};
    if (!writer.file)
        golden_fail(3, "cannot write %s: %s", replay_path, strerror(errno));
    put(&writer, "matrig-replay 1\n");
    put(&writer, "uid %08x %08x %08x\ncrystal %d\n", (unsigned)given->uid[0],
        (unsigned)given->uid[1], (unsigned)given->uid[2], given->crystal);
    write_command_lines(&writer, given);
    for (size_t i = 0; i < given->edges; i++)
        put(&writer, "edge %" PRIu64 "\n", given->edge[i]);
    for (size_t i = 0; i < given->frames; i++)
        put(&writer, "frame %" PRIu64 "\n", given->frame[i]);
    for (size_t i = 0; i < given->blocks; i++) {
        uint8_t record[MR_BLOCK_BYTES_MAX];
        char hex[2 * MR_BLOCK_BYTES_MAX + 1];
        size_t length = mr_block_encode(&given->block[i], record);
        for (size_t k = 0; k < length; k++)
            snprintf(hex + 2 * k, 3, "%02x", record[k]);
        put(&writer, "block %s\n", hex);
    }
    fprintf(writer.file, "end %08x\n", (unsigned)writer.crc);
    if (fclose(writer.file) != 0)
        golden_fail(3, "cannot write %s: %s", replay_path, strerror(errno));
}
