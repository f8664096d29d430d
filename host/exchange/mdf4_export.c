#include "host/exchange/export.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <math.h>
#include <md5.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/measured.h"
#include "host/analyse/summary.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"
#include "host/link/timemap.h"

/* Writes MDF4, measurement data in ASAM's MDF 4.10 format. The file is built in memory and written
 * at once.
 *
 * A file consists of blocks that link to each other by address: header (HD) and file history (FH);
 * for each table a data group (DG), a channel group (CG), channels (CN), their texts (TX, MD) and
 * the rows (DT); attached files (AT). Layouts follow the base part of the standard. Bus logging
 * follows the associated standard for it: a channel CAN_DataFrame that is composed of parts.
 *
 * One table is open at a time: mdf4_begin_table, mdf4_add_channel for each column, mdf4_add_row for
 * each row, mdf4_end_table. */

struct mdf4 {
    uint8_t *content; /* content of the file so far */
    size_t length, capacity;
    uint64_t header_block, last_group;
    uint64_t data_group, rows_block, last_channel; /* addresses of blocks of the open table */
    uint64_t channel_group;
    uint64_t parent_channel; /* the channels added next are parts of this one; 0: none */
    uint64_t last_part;
    uint64_t row_count;
    unsigned row_bytes, invalidation_bytes;
};

enum mdf4_type { MDF4_UNSIGNED = 0, MDF4_SIGNED = 2, MDF4_REAL = 4, MDF4_BYTES = 10 };

struct mdf4_add_channel {
    const char *name, *unit, *comment; /* unit and comment may be NULL */
    enum mdf4_type type;
    unsigned offset, bytes; /* position and size in the row, bytes */
    bool is_time_channel;   /* the column is the time in seconds, the table's master channel */
    /* number of the column's bit in the invalidation bytes, from 1; 0: always valid */
    unsigned invalid_bit;
    bool has_parts;      /* the channels added next are its parts */
    uint64_t attachment; /* attached file that describes the channel; 0: none */
};

/* bytes of a block's head: "##XX", 4 reserved, u64 length, u64 number of links */
#define MDF4_BLOCK_HEADER_BYTES 24u

#define MDF4_CG_BUS_EVENT       2u
#define MDF4_CG_PLAIN_BUS_EVENT 4u
#define MDF4_CN_TYPE_MASTER     2u
#define MDF4_CN_SYNC_TIME       1u
#define MDF4_CN_INVALIDATION    2u
#define MDF4_CN_BUS_EVENT       0x400u
#define MDF4_SOURCE_BUS         2u
#define MDF4_BUS_CAN            2u
#define MDF4_AT_EMBEDDED        1u
#define MDF4_AT_MD5             4u

/* index of each link in its block; link 0 leads to the next block of the same kind */
enum {
    MDF4_HD_FIRST_DG,
    MDF4_HD_FIRST_FH,
    MDF4_HD_FIRST_CH,
    MDF4_HD_FIRST_AT,
    MDF4_HD_FIRST_EV,
    MDF4_HD_COMMENT,
    MDF4_HD_LINK_COUNT
};
enum { MDF4_FH_NEXT, MDF4_FH_COMMENT, MDF4_FH_LINK_COUNT };
enum { MDF4_DG_NEXT, MDF4_DG_FIRST_CG, MDF4_DG_DATA, MDF4_DG_COMMENT, MDF4_DG_LINK_COUNT };
enum {
    MDF4_CG_NEXT,
    MDF4_CG_FIRST_CN,
    MDF4_CG_NAME,
    MDF4_CG_SOURCE,
    MDF4_CG_FIRST_SR,
    MDF4_CG_COMMENT,
    MDF4_CG_LINK_COUNT
};
enum {
    MDF4_CN_NEXT,
    MDF4_CN_PARTS,
    MDF4_CN_NAME,
    MDF4_CN_SOURCE,
    MDF4_CN_CONVERSION,
    MDF4_CN_DATA,
    MDF4_CN_UNIT,
    MDF4_CN_COMMENT,
    MDF4_CN_LINK_COUNT
};
enum { MDF4_SI_NAME, MDF4_SI_PATH, MDF4_SI_COMMENT, MDF4_SI_LINK_COUNT };
enum { MDF4_AT_NEXT, MDF4_AT_NAME, MDF4_AT_MIME, MDF4_AT_COMMENT, MDF4_AT_LINK_COUNT };
#define MDF4_CG_CYCLES 8u /* offset of the number of rows */

/* ---- bytes ---- */

static void encode_integer(uint8_t *at, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* Extends the file by `bytes`. */
static uint8_t *extend_file(struct mdf4 *file, size_t bytes)
{
    if (file->length + bytes > file->capacity) {
        file->capacity = 2 * (file->length + bytes) + 65536;
        file->content = xrealloc(file->content, file->capacity);
    }
    uint8_t *at = file->content + file->length;
    memset(at, 0, bytes);
    file->length += bytes;
    return at;
}

/* Pads the file: blocks start at multiples of eight bytes. */
static void align_block(struct mdf4 *file)
{
    extend_file(file, (8 - file->length % 8) % 8);
}

/* Appends a block with links and data. The stored length includes `more` bytes, which the caller
 * adds later. Returns the address. */
static uint64_t append_block(struct mdf4 *file, const char *id, const uint64_t *links,
                             unsigned link_count, const uint8_t *data, size_t data_bytes,
                             const void *more, size_t more_bytes)
{
    align_block(file);
    uint64_t address = file->length,
             length = MDF4_BLOCK_HEADER_BYTES + 8u * link_count + data_bytes + more_bytes;
    uint8_t *at = extend_file(file, length);
    memcpy(at, "##", 2);
    memcpy(at + 2, id, 2);
    encode_integer(at + 8, length, 8);
    encode_integer(at + 16, link_count, 8);
    at += MDF4_BLOCK_HEADER_BYTES;
    for (unsigned i = 0; i < link_count; i++, at += 8)
        encode_integer(at, links[i], 8);
    if (data_bytes)
        memcpy(at, data, data_bytes);
    if (more_bytes)
        memcpy(at + data_bytes, more, more_bytes);
    return address;
}

static uint64_t append_text(struct mdf4 *file, const char *id, const char *text)
{
    return text ? append_block(file, id, NULL, 0, NULL, 0, text, strlen(text) + 1) : 0;
}

static void set_link(struct mdf4 *file, uint64_t address, unsigned link, uint64_t to)
{
    encode_integer(file->content + address + MDF4_BLOCK_HEADER_BYTES + 8u * link, to, 8);
}

/* Writes an MD block: one XML element with escaped text. */
static uint64_t append_comment(struct mdf4 *file, const char *element, const char *text,
                               const char *more)
{
    if (!text)
        return 0;
    size_t room = 6 * strlen(text) + strlen(more) + 128;
    char *xml = xmalloc(room);
    size_t n = (size_t)snprintf(xml, room, "<%s><TX>", element);
    for (const char *c = text; *c; c++) {
        const char *as = *c == '<' ? "&lt;" : *c == '>' ? "&gt;" : *c == '&' ? "&amp;" : NULL;
        n += as ? (size_t)snprintf(xml + n, room - n, "%s", as)
                : (size_t)snprintf(xml + n, room - n, "%c", *c);
    }
    snprintf(xml + n, room - n, "</TX>%s</%s>", more, element);
    uint64_t address = append_text(file, "MD", xml);
    free(xml);
    return address;
}

/* ---- file ---- */

static uint64_t append_history(struct mdf4 *file, uint64_t start_ns, const char *tool_version)
{
    uint64_t links[MDF4_FH_LINK_COUNT] = {0};
    uint8_t data[16] = {0};
    char tool[128];
    snprintf(
        tool, sizeof tool,
        "<tool_id>matrig</tool_id><tool_vendor>matrig</tool_vendor><tool_version>%s</tool_version>",
        tool_version);
    links[MDF4_FH_COMMENT] = append_comment(file, "FHcomment", "exported", tool);
    encode_integer(data, start_ns, 8);
    return append_block(file, "FH", links, MDF4_FH_LINK_COUNT, data, sizeof data, NULL, 0);
}

static void mdf4_begin(struct mdf4 *file, uint64_t start_ns, const char *comment,
                       const char *tool_version)
{
    memset(file, 0, sizeof *file);
    uint8_t *id = extend_file(file, 64);
    memcpy(id, "MDF     4.10    matrig  ", 24);
    encode_integer(id + 28, 410, 2);
    uint64_t links[MDF4_HD_LINK_COUNT] = {0};
    uint8_t data[32] = {0};
    encode_integer(data, start_ns, 8);
    /* the HD block must be at address 64, where readers expect it */
    file->header_block = append_block(file, "HD", links, MDF4_HD_LINK_COUNT, data, sizeof data,
                                      NULL, 0);
    set_link(file, file->header_block, MDF4_HD_FIRST_FH,
             append_history(file, start_ns, tool_version));
    set_link(file, file->header_block, MDF4_HD_COMMENT,
             append_comment(file, "HDcomment", comment, ""));
}

/* Links a block to the last one of its kind, or, if it is the first, to its parent. */
static void link_block(struct mdf4 *file, uint64_t *last, uint64_t first_of, unsigned first_link,
                       uint64_t address)
{
    set_link(file, *last ? *last : first_of, *last ? 0 : first_link, address);
    *last = address;
}

static uint64_t mdf4_attach(struct mdf4 *file, const char *name, const char *mime_type,
                            const void *bytes, size_t length)
{
    uint64_t links[MDF4_AT_LINK_COUNT] = {0};
    uint8_t data[40] = {0};
    links[MDF4_AT_NAME] = append_text(file, "TX", name);
    links[MDF4_AT_MIME] = append_text(file, "TX", mime_type);
    encode_integer(data, MDF4_AT_EMBEDDED | MDF4_AT_MD5, 2);
    MD5_CTX md5;
    MD5Init(&md5);
    MD5Update(&md5, bytes, length);
    MD5Final(data + 8, &md5);
    encode_integer(data + 24, length, 8);
    encode_integer(data + 32, length, 8);
    uint64_t address = append_block(file, "AT", links, MDF4_AT_LINK_COUNT, data, sizeof data, bytes,
                                    length);
    set_link(file, file->header_block, MDF4_HD_FIRST_AT, address);
    return address;
}

static uint64_t append_can_source(struct mdf4 *file, unsigned can_channel)
{
    uint64_t links[MDF4_SI_LINK_COUNT] = {0};
    const uint8_t data[8] = {MDF4_SOURCE_BUS, MDF4_BUS_CAN};
    char name[16], number[96];
    snprintf(name, sizeof name, "CAN%u", can_channel);
    snprintf(number, sizeof number,
             "<common_properties><e name=\"ChannelNo\" type=\"integer\">%u</e></common_properties>",
             can_channel);
    links[MDF4_SI_NAME] = append_text(file, "TX", name);
    links[MDF4_SI_PATH] = append_text(file, "TX", name);
    links[MDF4_SI_COMMENT] = append_comment(file, "SIcomment", name, number);
    return append_block(file, "SI", links, MDF4_SI_LINK_COUNT, data, sizeof data, NULL, 0);
}

static void mdf4_begin_table(struct mdf4 *file, const char *name, const char *comment,
                             unsigned row_bytes, unsigned invalid_bytes, unsigned can_channel)
{
    uint64_t links[MDF4_DG_LINK_COUNT] = {0}, group[MDF4_CG_LINK_COUNT] = {0};
    uint8_t data[32] = {0};
    /* no record ids, because all rows of a table are of one kind */
    file->data_group = append_block(file, "DG", links, MDF4_DG_LINK_COUNT, data, 8, NULL, 0);
    link_block(file, &file->last_group, file->header_block, MDF4_HD_FIRST_DG, file->data_group);
    group[MDF4_CG_NAME] = append_text(file, "TX", name);
    group[MDF4_CG_SOURCE] = can_channel ? append_can_source(file, can_channel) : 0;
    group[MDF4_CG_COMMENT] = append_comment(file, "CGcomment", comment, "");
    encode_integer(data + 16, can_channel ? MDF4_CG_BUS_EVENT | MDF4_CG_PLAIN_BUS_EVENT : 0u, 2);
    encode_integer(data + 18, '.', 2); /* character between the names of channel and part */
    encode_integer(data + 24, row_bytes, 4);
    encode_integer(data + 28, invalid_bytes, 4);
    file->channel_group = append_block(file, "CG", group, MDF4_CG_LINK_COUNT, data, sizeof data,
                                       NULL, 0);
    set_link(file, file->data_group, MDF4_DG_FIRST_CG, file->channel_group);
    file->last_channel = file->rows_block = file->parent_channel = file->last_part =
        file->row_count = 0;
    file->row_bytes = row_bytes;
    file->invalidation_bytes = invalid_bytes;
}

static void mdf4_add_channel(struct mdf4 *file, const struct mdf4_add_channel *channel)
{
    uint64_t links[MDF4_CN_LINK_COUNT + 1] = {0};
    uint8_t data[72] = {0};
    links[MDF4_CN_NAME] = append_text(file, "TX", channel->name);
    links[MDF4_CN_UNIT] = append_text(file, "TX", channel->unit);
    links[MDF4_CN_COMMENT] = append_comment(file, "CNcomment", channel->comment, "");
    links[MDF4_CN_LINK_COUNT] = channel->attachment;
    data[0] = channel->is_time_channel ? MDF4_CN_TYPE_MASTER : 0;
    data[1] = channel->is_time_channel ? MDF4_CN_SYNC_TIME : 0;
    data[2] = (uint8_t)channel->type;
    encode_integer(data + 4, channel->offset, 4);
    encode_integer(data + 8, 8u * channel->bytes, 4);
    encode_integer(data + 12,
                   (channel->invalid_bit ? MDF4_CN_INVALIDATION : 0u) |
                       (channel->has_parts || file->parent_channel ? MDF4_CN_BUS_EVENT : 0u),
                   4);
    encode_integer(data + 16, channel->invalid_bit ? channel->invalid_bit - 1 : 0u, 4);
    encode_integer(data + 22, channel->attachment ? 1u : 0u, 2);
    uint64_t address = append_block(file, "CN", links,
                                    MDF4_CN_LINK_COUNT + (channel->attachment ? 1u : 0u), data,
                                    sizeof data, NULL, 0);
    if (file->parent_channel)
        link_block(file, &file->last_part, file->parent_channel, MDF4_CN_PARTS, address);
    else
        link_block(file, &file->last_channel, file->channel_group, MDF4_CG_FIRST_CN, address);
    if (channel->has_parts)
        file->parent_channel = address;
}

static void mdf4_add_row(struct mdf4 *file, const uint8_t *row)
{
    size_t bytes = file->row_bytes + file->invalidation_bytes;
    if (!file->rows_block) {
        file->rows_block = append_block(file, "DT", NULL, 0, NULL, 0, NULL, 0);
        set_link(file, file->data_group, MDF4_DG_DATA, file->rows_block);
    }
    uint8_t *at = extend_file(file, bytes);
    memcpy(at, row, bytes);
    file->row_count++;
}

static void mdf4_end_table(struct mdf4 *file)
{
    encode_integer(file->content + file->channel_group + MDF4_BLOCK_HEADER_BYTES +
                       8u * MDF4_CG_LINK_COUNT + MDF4_CG_CYCLES,
                   file->row_count, 8);
    if (file->rows_block)
        encode_integer(file->content + file->rows_block + 8,
                       MDF4_BLOCK_HEADER_BYTES +
                           file->row_count * (file->row_bytes + file->invalidation_bytes),
                       8);
}

static void mdf4_write(struct mdf4 *file, FILE *out)
{
    align_block(file);
    fwrite(file->content, 1, file->length, out);
    free(file->content);
}

/* ---- a landing ---- */

/* columns before the readings: time, time since touchdown, gear, speed. They have 8 bytes each,
 * readings 4 */
#define READING_FIXED_COLUMNS 4u
#define FRAME_ROW_BYTES       24u
/* largest number of microseconds that a double represents exactly */
#define TIME_STAMP_MAX_US     9e15

/* kinds of CAN frames; each kind has a separate table */
enum frame_kind { FRAME_DATA, FRAME_REMOTE, FRAME_ERROR, FRAME_KIND_COUNT };
static const char *const frame_kind_names[FRAME_KIND_COUNT] = {"CAN_DataFrame", "CAN_RemoteFrame",
                                                               "CAN_ErrorFrame"};

struct export_context {
    const struct summary *summary;
    struct mdf4 *file;
    uint16_t can_base; /* CAN base of the board */
    int64_t zero_us;   /* board time of second 0 */
    long row_count;
    enum frame_kind kind;               /* kind of the frames that are being written */
    long frame_count[FRAME_KIND_COUNT]; /* number of frames of each kind */
};

/* ---- readings ---- */

static const struct unit *get_channel_unit(const struct measured_channel *channel, bool si)
{
    return unit_get(channel->config.kind == MR_KIND_DISPLACEMENT ? UNIT_DISPLACEMENT : UNIT_TENSION,
                    si);
}

static void describe_reading(struct export_context *place, const struct measured_channel *channel,
                             unsigned column, bool si)
{
    const struct measured_landing *measured = &place->summary->measured;
    bool moves = channel->config.kind == MR_KIND_DISPLACEMENT;
    double factor = get_channel_unit(channel, si)->factor;
    double one = measured_standard_error(measured, channel, channel->peak, 1.0);
    char name[32], comment[200];
    snprintf(name, sizeof name, "%s_%u", moves ? "displacement" : "tension",
             channel->config.number);
    int n = snprintf(comment, sizeof comment,
                     moves ? "station %.*f %s; downfield is positive; relative to the mean at rest"
                           : "band tension",
                     3, (double)channel->config.station_ft * unit_get(UNIT_STATION, si)->factor,
                     unit_get(UNIT_STATION, si)->text);
    if (!isnan(one))
        snprintf(comment + n, sizeof comment - (size_t)n,
                 "; standard error of one reading, at the peak: %.4g %s", one * factor,
                 get_channel_unit(channel, si)->text);
    mdf4_add_channel(place->file,
                     &(struct mdf4_add_channel){.name = name,
                                                .unit = get_channel_unit(channel, si)->text,
                                                .comment = comment,
                                                .type = MDF4_REAL,
                                                .offset = 8 * READING_FIXED_COLUMNS + 4 * column,
                                                .bytes = 4,
                                                .invalid_bit = READING_FIXED_COLUMNS + column + 1});
}

static void describe_readings(struct export_context *place,
                              const struct measured_channel **channels, unsigned count, bool si)
{
    const struct measured_landing *measured = &place->summary->measured;
    const char *since = measured->is_t0_touchdown ? "since_touchdown"
                      : measured->gate_count      ? "since_first_edge"
                                                  : "since_arming";
    const struct mdf4_add_channel before[READING_FIXED_COLUMNS] = {
        {.name = "time",
         .unit = "s",
         .comment = "time at the middle of the 1 ms block",
         .type = MDF4_REAL,
         .is_time_channel = true},
        {.name = since, .unit = "s", .type = MDF4_REAL},
        {.name = "gear_station",
         .unit = unit_get(UNIT_STATION, si)->text,
         .comment = "speed of the main bogie's lead wheel, from the fit",
         .type = MDF4_REAL,
         .invalid_bit = 3},
        {.name = "gear_speed",
         .unit = unit_get(UNIT_SPEED, si)->text,
         .type = MDF4_REAL,
         .invalid_bit = 4}};
    char source[MEASURED_SOURCE_SIZE], torn[MEASURED_MISSING_START_SIZE],
        comment[MEASURED_SOURCE_SIZE + MEASURED_MISSING_START_SIZE + 100];
    measured_format_source(measured, source);
    measured_format_missing_start(measured, torn);
    snprintf(comment, sizeof comment,
             "readings, one row per millisecond, from %s; invalid readings are marked%s%s", source,
             torn[0] ? "; " : "", torn);
    mdf4_begin_table(place->file, "readings", comment, 8 * READING_FIXED_COLUMNS + 4 * count,
                     (READING_FIXED_COLUMNS + count + 7) / 8, 0);
    for (unsigned i = 0; i < READING_FIXED_COLUMNS; i++) {
        struct mdf4_add_channel column = before[i];
        column.offset = 8 * i;
        column.bytes = 8;
        mdf4_add_channel(place->file, &column);
    }
    for (unsigned c = 0; c < count; c++)
        describe_reading(place, channels[c], c, si);
}

static void mark_invalid(uint8_t *row, unsigned row_bytes, unsigned bit)
{
    row[row_bytes + bit / 8] |= (uint8_t)(1u << bit % 8);
}

static void append_reading_row(struct export_context *place,
                               const struct measured_channel **channels, unsigned count,
                               size_t sample, bool si)
{
    const struct measured_landing *measured = &place->summary->measured;
    uint8_t row[8 * READING_FIXED_COLUMNS + 4 * MR_CHANNELS + 8] = {0};
    unsigned row_bytes = 8 * READING_FIXED_COLUMNS + 4 * count;
    double t_s = measured_time_s(measured, sample), unused;
    double values[READING_FIXED_COLUMNS] = {
        t_s + (double)(measured->t0_us - place->zero_us) / 1e6, t_s,
        measured_station_ft(measured, t_s) * unit_get(UNIT_STATION, si)->factor,
        measured_speed_ft_s(measured, t_s, &unused) * unit_get(UNIT_SPEED, si)->factor};
    for (unsigned i = 0; i < READING_FIXED_COLUMNS; i++) {
        if (isnan(values[i]))
            mark_invalid(row, row_bytes, i);
        else /* no conversion: x86 and ARM store doubles in the byte order of the file */
            memcpy(row + 8 * i, &values[i], 8);
    }
    for (unsigned c = 0; c < count; c++) {
        float value = (float)(measured_value(channels[c], sample) *
                              get_channel_unit(channels[c], si)->factor);
        if (isnan(value))
            mark_invalid(row, row_bytes, READING_FIXED_COLUMNS + c);
        else
            memcpy(row + 8 * READING_FIXED_COLUMNS + 4 * c, &value, 4);
    }
    mdf4_add_row(place->file, row);
    place->row_count++;
}

static void append_readings(struct export_context *place, bool si)
{
    const struct measured_landing *measured = &place->summary->measured;
    const struct measured_channel *channels[MR_CHANNELS];
    unsigned count = (unsigned)measured_list_channels(measured, channels);
    if (measured->source == MEASURED_NO_SOURCE || measured->samples == 0)
        return;
    describe_readings(place, channels, count, si);
    for (size_t i = 0; i < measured->samples; i++)
        append_reading_row(place, channels, count, i, si);
    mdf4_end_table(place->file);
}

/* ---- frames ---- */

static enum frame_kind find_frame_kind(const struct store_frame *frame)
{
    return frame->id & LINK_ID_ERROR  ? FRAME_ERROR
         : frame->id & LINK_ID_REMOTE ? FRAME_REMOTE
                                      : FRAME_DATA;
}

/* Returns the number of the error type in the standard; 0: other. */
static uint8_t get_bus_error_type(const struct store_frame *frame)
{
    enum {
        MDF4_ERROR_OTHER,
        MDF4_ERROR_BIT,
        MDF4_ERROR_FORM,
        MDF4_ERROR_STUFFING,
        MDF4_ERROR_CRC,
        MDF4_ERROR_ACK
    };
    static const uint8_t by_bit[] = {MDF4_ERROR_BIT, MDF4_ERROR_FORM, MDF4_ERROR_STUFFING,
                                     MDF4_ERROR_BIT,
                                     MDF4_ERROR_BIT}; /* types by the bits of CAN_ERR_PROT_... */
    if (frame->id & CAN_ERR_ACK)
        return MDF4_ERROR_ACK;
    if (!(frame->id & CAN_ERR_PROT) || frame->length < 4)
        return MDF4_ERROR_OTHER;
    if (frame->data[3] == CAN_ERR_PROT_LOC_CRC_SEQ)
        return MDF4_ERROR_CRC;
    for (unsigned bit = 0; bit < sizeof by_bit; bit++) {
        if (frame->data[2] & 1u << bit)
            return by_bit[bit];
    }
    return MDF4_ERROR_OTHER;
}

static enum mr_status append_frame(void *context, const struct store_frame *frame)
{
    struct export_context *place = context;
    uint8_t row[FRAME_ROW_BYTES] = {0};
    if (frame->board_us == STORE_NONE || frame->length > 8)
        return MR_OK;
    place->frame_count[find_frame_kind(frame)]++;
    if (find_frame_kind(frame) != place->kind)
        return MR_OK;
    double t_s = (double)(frame->board_us - place->zero_us) / 1e6;
    memcpy(row, &t_s, 8);
    row[8] = 1; /* bus number */
    if (place->kind == FRAME_ERROR) {
        row[9] = get_bus_error_type(frame);
    } else {
        encode_integer(row + 9, link_id_to_bus(frame->id, place->can_base) & CAN_EFF_MASK, 4);
        row[13] = (frame->id & LINK_ID_EXTENDED) != 0;
        row[14] = (uint8_t)frame->length;
    }
    if (place->kind == FRAME_DATA) {
        row[15] = (uint8_t)frame->length;
        memcpy(row + 16, frame->data, frame->length);
    }
    mdf4_add_row(place->file, row);
    place->row_count++;
    return MR_OK;
}

static void describe_frames(struct mdf4 *file, enum frame_kind kind, uint64_t dbc)
{
    static const struct {
        const char *name;
        unsigned offset, bytes;
        unsigned kinds; /* bit mask of frame kinds with this field */
    } parts[] = {{"BusChannel", 8, 1, 7}, {"ErrorType", 9, 1, 4}, {"ID", 9, 4, 3},
                 {"IDE", 13, 1, 3},       {"DLC", 14, 1, 3},      {"DataLength", 15, 1, 1},
                 {"DataBytes", 16, 8, 1}};
    static const char *const comments[FRAME_KIND_COUNT] = {
        "frames of the board's CAN bus as received",
        "remote frames of the board's CAN bus; each requests DLC bytes and contains no data",
        "errors of the board's CAN bus, as reported by the adapter"};
    const char *name = frame_kind_names[kind];
    mdf4_begin_table(file, name, comments[kind], FRAME_ROW_BYTES, 0, 1);
    mdf4_add_channel(file, &(struct mdf4_add_channel){.name = "Timestamp",
                                                      .unit = "s",
                                                      .type = MDF4_REAL,
                                                      .bytes = 8,
                                                      .is_time_channel = true});
    mdf4_add_channel(file, &(struct mdf4_add_channel){.name = name,
                                                      .type = MDF4_BYTES,
                                                      .offset = 8,
                                                      .bytes = FRAME_ROW_BYTES - 8,
                                                      .has_parts = true,
                                                      .attachment = kind == FRAME_DATA ? dbc : 0});
    for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        char whole[40];
        snprintf(whole, sizeof whole, "%s.%s", name, parts[i].name);
        if (parts[i].kinds & 1u << kind)
            mdf4_add_channel(file, &(struct mdf4_add_channel){
                                       .name = whole,
                                       .type = parts[i].bytes == 8 ? MDF4_BYTES : MDF4_UNSIGNED,
                                       .offset = parts[i].offset,
                                       .bytes = parts[i].bytes});
    }
}

static enum mr_status append_frames(struct export_context *place, struct store *store, int64_t run,
                                    struct error *error)
{
    size_t length = 0;
    char *dbc = NULL;
    FILE *stream = xopen_memstream(&dbc, &length);
    dbc_write(stream, place->can_base);
    fclose(stream);
    uint64_t attached = mdf4_attach(place->file, "matrig.dbc", "application/x-dbc", dbc, length);
    free(dbc);
    enum mr_status status = MR_OK;
    for (unsigned kind = 0; kind < FRAME_KIND_COUNT && status == MR_OK; kind++) {
        place->kind = (enum frame_kind)kind;
        if (kind > 0 && place->frame_count[kind] == 0)
            continue;
        describe_frames(place->file, place->kind, attached);
        memset(place->frame_count, 0, sizeof place->frame_count);
        status = store_frames_for_each(store, run, LINK_CAN, append_frame, place, error);
        mdf4_end_table(place->file);
    }
    return status;
}

/* ---- file ---- */

static enum mr_status find_first_frame(void *context, const struct store_frame *frame)
{
    int64_t *first_us = context;
    if (frame->board_us != STORE_NONE && (*first_us == STORE_NONE || frame->board_us < *first_us))
        *first_us = frame->board_us;
    return MR_OK;
}

/* Finds the earliest board time of the data; STORE_NONE: no data. */
static enum mr_status find_start_us(struct store *store, int64_t run,
                                    const struct measured_landing *measured, int64_t *zero_us,
                                    struct error *error)
{
    *zero_us = STORE_NONE;
    enum mr_status status = store_frames_for_each(store, run, LINK_CAN, find_first_frame, zero_us,
                                                  error);
    if (measured->source == MEASURED_NO_SOURCE || measured->samples == 0)
        return status;
    int64_t first_us = measured->t0_us + (int64_t)floor(1e6 * measured_time_s(measured, 0));
    if (*zero_us == STORE_NONE || first_us < *zero_us)
        *zero_us = first_us;
    return status;
}

/* Returns the Unix time of second 0; 0: unknown or the time map is not usable. */
static uint64_t get_start_ns(const struct summary *summary, int64_t zero_us)
{
    double us = summary_convert_to_time_of_day(summary, (double)zero_us).host_us;
    return us > 0.0 && us < TIME_STAMP_MAX_US ? 1000u * (uint64_t)llround(us) : 0;
}

static void begin_file(struct mdf4 *file, const struct summary *summary, int64_t zero_us,
                       const struct cli *cli)
{
    const struct store_landing *landing = &summary->measured.landing;
    char comment[400], version[32];
    uint64_t start = get_start_ns(summary, zero_us);
    const char *why = summary->is_clock_known
                        ? timemap_refusal_text((unsigned)summary->clock.refusal)
                        : "the board's clock was not tracked";
    if (!start)
        cli_note(cli, "the time of day is unknown, so the file begins in 1970; %s", why);
    snprintf(version, sizeof version, "database version %d", STORE_VERSION);
    snprintf(
        comment, sizeof comment,
        "matrig landing: RUN %lld, landing %lld of board %s%s; second 0 is board time %.6f s%s%s",
        (long long)landing->id, (long long)landing->board_landing, landing->board_uid,
        measured_is_emulated(landing) ? " (emulated, synthetic data)" : "", (double)zero_us / 1e6,
        start ? "" : ", time of day unknown: ", start ? "" : why);
    mdf4_begin(file, start, comment, version);
}

enum mr_status export_mdf4(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                           long *rows, struct error *error)
{
    struct summary summary = {0};
    struct mdf4 file = {0};
    int64_t frames = 0;
    struct export_context place = {.summary = &summary, .file = &file};
    enum mr_status status = summary_load(store, run, &summary, error) ?:
                            store_frames_count(store, run, LINK_CAN, &frames, error) ?:
                            store_can_base_get(store, run, &place.can_base, error) ?:
                            find_start_us(store, run, &summary.measured, &place.zero_us, error);
    if (status == MR_OK && place.zero_us == STORE_NONE)
        status = error_set(
            error, MR_USAGE,
            "nothing to export: RUN %lld of %s has neither readings nor CAN frames with a time",
            (long long)run, store_path(store));
    if (status == MR_OK) {
        begin_file(&file, &summary, place.zero_us, cli);
        append_readings(&place, cli->si);
        if (frames)
            status = append_frames(&place, store, run, error);
        mdf4_write(&file, out);
        *rows = place.row_count;
    }
    summary_free(&summary);
    return status;
}
