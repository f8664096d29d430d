#include "host/export/mdf4.h"

#include <md5.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_HEAD 24u /* "##XX", 4 reserved, u64 length, u64 count of links */

#define CG_BUS_EVENT       2u
#define CG_PLAIN_BUS_EVENT 4u
#define CN_TYPE_MASTER     2u
#define CN_SYNC_TIME       1u
#define CN_INVALIDATION    2u
#define CN_BUS_EVENT       0x400u
#define SOURCE_BUS         2u
#define BUS_CAN            2u
#define AT_EMBEDDED        1u
#define AT_MD5             4u

/* Links by position in their blocks. */
enum { HD_FIRST_DG, HD_FIRST_FH, HD_FIRST_CH, HD_FIRST_AT, HD_FIRST_EV, HD_COMMENT, HD_LINKS };
enum { FH_NEXT, FH_COMMENT, FH_LINKS };
enum { DG_NEXT, DG_FIRST_CG, DG_DATA, DG_COMMENT, DG_LINKS };
enum { CG_NEXT, CG_FIRST_CN, CG_NAME, CG_SOURCE, CG_FIRST_SR, CG_COMMENT, CG_LINKS };
enum {
    CN_NEXT,
    CN_PARTS,
    CN_NAME,
    CN_SOURCE,
    CN_CONVERSION,
    CN_DATA,
    CN_UNIT,
    CN_COMMENT,
    CN_LINKS
};
enum { SI_NAME, SI_PATH, SI_COMMENT, SI_LINKS };
enum { AT_NEXT, AT_NAME, AT_MIME, AT_COMMENT, AT_LINKS };
#define CG_CYCLES 8u /* place of the number of rows in its data */

/* ---- bytes ---- */

static void put(uint8_t *at, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* Room for so many bytes more, or NULL. */
static uint8_t *grow(struct mdf4 *file, size_t bytes)
{
    if (file->full)
        return NULL;
    if (file->length + bytes > file->room) {
        size_t room = 2 * (file->length + bytes) + 65536;
        uint8_t *larger = realloc(file->bytes, room);
        if (!larger) {
            file->full = true;
            return NULL;
        }
        file->bytes = larger;
        file->room = room;
    }
    uint8_t *at = file->bytes + file->length;
    memset(at, 0, bytes);
    file->length += bytes;
    return at;
}

/* Blocks begin at multiples of eight. */
static void align(struct mdf4 *file)
{
    grow(file, (8 - file->length % 8) % 8);
}

/* A block with its links and data; `more` bytes may follow, which its length counts. Returns its
 * address. */
static uint64_t block(struct mdf4 *file, const char *id, const uint64_t *links, unsigned link_count,
                      const uint8_t *data, size_t data_bytes, const void *more, size_t more_bytes)
{
    align(file);
    uint64_t address = file->length,
             length = BLOCK_HEAD + 8u * link_count + data_bytes + more_bytes;
    uint8_t *at = grow(file, length);
    if (!at)
        return 0;
    memcpy(at, "##", 2);
    memcpy(at + 2, id, 2);
    put(at + 8, length, 8);
    put(at + 16, link_count, 8);
    at += BLOCK_HEAD;
    for (unsigned i = 0; i < link_count; i++, at += 8)
        put(at, links[i], 8);
    if (data_bytes)
        memcpy(at, data, data_bytes);
    if (more_bytes)
        memcpy(at + data_bytes, more, more_bytes);
    return address;
}

static uint64_t text_block(struct mdf4 *file, const char *id, const char *text)
{
    return text ? block(file, id, NULL, 0, NULL, 0, text, strlen(text) + 1) : 0;
}

static void set_link(struct mdf4 *file, uint64_t address, unsigned link, uint64_t to)
{
    if (!file->full)
        put(file->bytes + address + BLOCK_HEAD + 8u * link, to, 8);
}

/* Text for an MD block: its one element of XML with what XML gives a meaning written as it asks. */
static uint64_t comment_block(struct mdf4 *file, const char *element, const char *text,
                              const char *more)
{
    if (!text)
        return 0;
    size_t room = 6 * strlen(text) + strlen(more) + 128;
    char *xml = malloc(room);
    if (!xml) {
        file->full = true;
        return 0;
    }
    size_t n = (size_t)snprintf(xml, room, "<%s><TX>", element);
    for (const char *c = text; *c; c++) {
        const char *as = *c == '<' ? "&lt;" : *c == '>' ? "&gt;" : *c == '&' ? "&amp;" : NULL;
        n += as ? (size_t)snprintf(xml + n, room - n, "%s", as)
                : (size_t)snprintf(xml + n, room - n, "%c", *c);
    }
    snprintf(xml + n, room - n, "</TX>%s</%s>", more, element);
    uint64_t address = text_block(file, "MD", xml);
    free(xml);
    return address;
}

/* ---- file ---- */

static uint64_t history(struct mdf4 *file, uint64_t start_ns, const char *tool_version)
{
    uint64_t links[FH_LINKS] = {0};
    uint8_t data[16] = {0};
    char tool[128];
    snprintf(
        tool, sizeof tool,
        "<tool_id>matrig</tool_id><tool_vendor>matrig</tool_vendor><tool_version>%s</tool_version>",
        tool_version);
    links[FH_COMMENT] = comment_block(file, "FHcomment", "exported", tool);
    put(data, start_ns, 8);
    return block(file, "FH", links, FH_LINKS, data, sizeof data, NULL, 0);
}

void mdf4_start(struct mdf4 *file, uint64_t start_ns, const char *comment, const char *tool_version)
{
    memset(file, 0, sizeof *file);
    uint8_t *id = grow(file, 64);
    if (id) {
        memcpy(id, "MDF     4.10    matrig  ", 24);
        put(id + 28, 410, 2);
    }
    uint64_t links[HD_LINKS] = {0};
    uint8_t data[32] = {0};
    put(data, start_ns, 8);
    /* at 64: readers go there */
    file->header = block(file, "HD", links, HD_LINKS, data, sizeof data, NULL, 0);
    set_link(file, file->header, HD_FIRST_FH, history(file, start_ns, tool_version));
    set_link(file, file->header, HD_COMMENT, comment_block(file, "HDcomment", comment, ""));
}

uint64_t mdf4_attach(struct mdf4 *file, const char *name, const char *mime_type, const void *bytes,
                     size_t length)
{
    uint64_t links[AT_LINKS] = {0};
    uint8_t data[40] = {0};
    links[AT_NAME] = text_block(file, "TX", name);
    links[AT_MIME] = text_block(file, "TX", mime_type);
    put(data, AT_EMBEDDED | AT_MD5, 2);
    MD5_CTX md5;
    MD5Init(&md5);
    MD5Update(&md5, bytes, length);
    MD5Final(data + 8, &md5);
    put(data + 24, length, 8);
    put(data + 32, length, 8);
    uint64_t address = block(file, "AT", links, AT_LINKS, data, sizeof data, bytes, length);
    if (file->last_attachment)
        set_link(file, file->last_attachment, AT_NEXT, address);
    else
        set_link(file, file->header, HD_FIRST_AT, address);
    file->last_attachment = address;
    return address;
}

static uint64_t can_source(struct mdf4 *file, unsigned can_channel)
{
    uint64_t links[SI_LINKS] = {0};
    const uint8_t data[8] = {SOURCE_BUS, BUS_CAN};
    char name[16], number[96];
    snprintf(name, sizeof name, "CAN%u", can_channel);
    snprintf(number, sizeof number,
             "<common_properties><e name=\"ChannelNo\" type=\"integer\">%u</e></common_properties>",
             can_channel);
    links[SI_NAME] = text_block(file, "TX", name);
    links[SI_PATH] = text_block(file, "TX", name);
    links[SI_COMMENT] = comment_block(file, "SIcomment", name, number);
    return block(file, "SI", links, SI_LINKS, data, sizeof data, NULL, 0);
}

void mdf4_table(struct mdf4 *file, const char *name, const char *comment, unsigned row_bytes,
                unsigned invalid_bytes, unsigned can_channel)
{
    uint64_t links[DG_LINKS] = {0}, group[CG_LINKS] = {0};
    uint8_t data[32] = {0};
    /* a table of one kind of rows: no record ids */
    file->group = block(file, "DG", links, DG_LINKS, data, 8, NULL, 0);
    if (file->last_group)
        set_link(file, file->last_group, DG_NEXT, file->group);
    else
        set_link(file, file->header, HD_FIRST_DG, file->group);
    file->last_group = file->group;
    group[CG_NAME] = text_block(file, "TX", name);
    group[CG_SOURCE] = can_channel ? can_source(file, can_channel) : 0;
    group[CG_COMMENT] = comment_block(file, "CGcomment", comment, "");
    put(data + 16, can_channel ? CG_BUS_EVENT | CG_PLAIN_BUS_EVENT : 0u, 2);
    put(data + 18, '.', 2); /* between the names of a channel and its part */
    put(data + 24, row_bytes, 4);
    put(data + 28, invalid_bytes, 4);
    file->channel_group = block(file, "CG", group, CG_LINKS, data, sizeof data, NULL, 0);
    set_link(file, file->group, DG_FIRST_CG, file->channel_group);
    file->last_channel = file->rows_block = file->part_of = file->rows = 0;
    file->row_bytes = row_bytes;
    file->invalid_bytes = invalid_bytes;
}

static void hang_channel(struct mdf4 *file, uint64_t address)
{
    if (file->part_of && !file->last_part)
        set_link(file, file->part_of, CN_PARTS, address);
    else if (file->part_of)
        set_link(file, file->last_part, CN_NEXT, address);
    else if (file->last_channel)
        set_link(file, file->last_channel, CN_NEXT, address);
    else
        set_link(file, file->channel_group, CG_FIRST_CN, address);
    if (file->part_of)
        file->last_part = address;
    else
        file->last_channel = address;
}

void mdf4_channel(struct mdf4 *file, const struct mdf4_channel *channel)
{
    uint64_t links[CN_LINKS + 1] = {0};
    uint8_t data[72] = {0};
    links[CN_NAME] = text_block(file, "TX", channel->name);
    links[CN_UNIT] = text_block(file, "TX", channel->unit);
    links[CN_COMMENT] = comment_block(file, "CNcomment", channel->comment, "");
    links[CN_LINKS] = channel->attachment;
    data[0] = channel->is_time ? CN_TYPE_MASTER : 0;
    data[1] = channel->is_time ? CN_SYNC_TIME : 0;
    data[2] = (uint8_t)channel->type;
    put(data + 4, channel->offset, 4);
    put(data + 8, 8u * channel->bytes, 4);
    put(data + 12,
        (channel->invalid_bit >= 0 ? CN_INVALIDATION : 0u) |
            (channel->has_parts || file->part_of ? CN_BUS_EVENT : 0u),
        4);
    put(data + 16, channel->invalid_bit >= 0 ? (unsigned)channel->invalid_bit : 0u, 4);
    put(data + 22, channel->attachment ? 1u : 0u, 2);
    uint64_t address = block(file, "CN", links, CN_LINKS + (channel->attachment ? 1u : 0u), data,
                             sizeof data, NULL, 0);
    hang_channel(file, address);
    if (channel->has_parts) {
        file->part_of = address;
        file->last_part = 0;
    }
}

void mdf4_parts_end(struct mdf4 *file)
{
    file->part_of = 0;
}

void mdf4_row(struct mdf4 *file, const uint8_t *row)
{
    size_t bytes = file->row_bytes + file->invalid_bytes;
    if (!file->rows_block) {
        file->rows_block = block(file, "DT", NULL, 0, NULL, 0, NULL, 0);
        set_link(file, file->group, DG_DATA, file->rows_block);
    }
    uint8_t *at = grow(file, bytes);
    if (at)
        memcpy(at, row, bytes);
    file->rows++;
}

void mdf4_table_end(struct mdf4 *file)
{
    if (file->full)
        return;
    put(file->bytes + file->channel_group + BLOCK_HEAD + 8u * CG_LINKS + CG_CYCLES, file->rows, 8);
    if (file->rows_block)
        put(file->bytes + file->rows_block + 8,
            BLOCK_HEAD + file->rows * (file->row_bytes + file->invalid_bytes), 8);
}

enum mr_status mdf4_write(struct mdf4 *file, FILE *out, struct error *error)
{
    align(file);
    enum mr_status status = MR_OK;
    if (file->full)
        status =
            error_set(error, MR_FULL,
                      "out of memory: an MDF4 file is put together in memory; export CSV instead");
    else
        fwrite(file->bytes, 1, file->length, out);
    free(file->bytes);
    memset(file, 0, sizeof *file);
    return status;
}
