#include "common/boxpage.h"

#include <string.h>

#include "common/crc32.h"
#include "common/wire.h"

#define CRC_OFFSET (MR_BOXPAGE_BYTES - 4u)

static uint32_t compute_page_crc(const uint8_t page[MR_BOXPAGE_BYTES])
{
    uint8_t kind = page[MR_BOXPAGE_KIND_OFFSET] | MR_BOXPAGE_NOT_FREED;
    uint32_t crc = mr_crc32(0, page, MR_BOXPAGE_KIND_OFFSET);
    crc = mr_crc32(crc, &kind, 1);
    return mr_crc32(crc, page + MR_BOXPAGE_FIRST_OFFSET, CRC_OFFSET - MR_BOXPAGE_FIRST_OFFSET);
}

void mr_boxpage_seal(uint8_t page[MR_BOXPAGE_BYTES], uint32_t seq, uint16_t record)
{
    mr_put_u16(mr_put_u32(page, seq), record);
    page[MR_BOXPAGE_KIND_OFFSET] |= MR_BOXPAGE_NOT_FREED;
    mr_put_u32(page + CRC_OFFSET, compute_page_crc(page));
}

enum mr_status mr_boxpage_check(const uint8_t page[MR_BOXPAGE_BYTES],
                                struct mr_boxpage_header *header)
{
    const uint8_t *p = page;
    const uint8_t *crc = page + CRC_OFFSET;
    size_t i = 0;
    while (i < MR_BOXPAGE_BYTES && page[i] == 0xff)
        i++;
    if (i == MR_BOXPAGE_BYTES)
        return MR_TOO_FEW;
    if (mr_get_u32(&crc) != compute_page_crc(page))
        return MR_CRC;
    header->seq = mr_get_u32(&p);
    header->record = mr_get_u16(&p);
    uint8_t kind = mr_get_u8(&p);
    header->kind = kind & (uint8_t)~MR_BOXPAGE_NOT_FREED;
    header->is_freed = !(kind & MR_BOXPAGE_NOT_FREED);
    header->first_record_byte = mr_get_u8(&p);
    return header->kind >= MR_BOXPAGE_START && header->kind <= MR_BOXPAGE_END ? MR_OK : MR_CRC;
}

static uint8_t *begin_page(uint8_t page[MR_BOXPAGE_BYTES], enum mr_boxpage_kind kind)
{
    memset(page, 0xff, MR_BOXPAGE_BYTES);
    page[MR_BOXPAGE_KIND_OFFSET] = (uint8_t)(MR_BOXPAGE_NOT_FREED | kind);
    return page + MR_BOXPAGE_HEADER_BYTES;
}

void mr_boxpage_put_start(uint8_t page[MR_BOXPAGE_BYTES], const struct mr_boxpage_start_page *start)
{
    uint8_t *p = begin_page(page, MR_BOXPAGE_START);
    p = mr_put_u16(mr_put_u16(p, start->layout), start->landing);
    p = mr_put_u32(mr_put_u32(p, start->armed_block), start->trigger_block);
    for (unsigned i = 0; i < 3; i++)
        p = mr_put_u32(p, start->uid[i]);
    p = mr_put_u32(mr_put_u32(p, start->image_crc), start->config_crc);
    for (unsigned i = 0; i < 3; i++)
        p = mr_put_u8(p, start->firmware[i]);
    mr_put_u8(p, start->clock_source);
}

void mr_boxpage_get_start(const uint8_t page[MR_BOXPAGE_BYTES], struct mr_boxpage_start_page *start)
{
    const uint8_t *p = page + MR_BOXPAGE_HEADER_BYTES;
    start->layout = mr_get_u16(&p);
    start->landing = mr_get_u16(&p);
    start->armed_block = mr_get_u32(&p);
    start->trigger_block = mr_get_u32(&p);
    for (unsigned i = 0; i < 3; i++)
        start->uid[i] = mr_get_u32(&p);
    start->image_crc = mr_get_u32(&p);
    start->config_crc = mr_get_u32(&p);
    for (unsigned i = 0; i < 3; i++)
        start->firmware[i] = mr_get_u8(&p);
    start->clock_source = mr_get_u8(&p);
}

void mr_boxpage_put_end(uint8_t page[MR_BOXPAGE_BYTES], const struct mr_boxpage_end *end)
{
    uint8_t *p = begin_page(page, MR_BOXPAGE_END);
    mr_put_u32(mr_put_u32(mr_put_u32(mr_put_u32(p, end->first_block), end->stored_blocks),
                          end->lost_blocks),
               end->lost_messages);
}

void mr_boxpage_get_end(const uint8_t page[MR_BOXPAGE_BYTES], struct mr_boxpage_end *end)
{
    const uint8_t *p = page + MR_BOXPAGE_HEADER_BYTES;
    end->first_block = mr_get_u32(&p);
    end->stored_blocks = mr_get_u32(&p);
    end->lost_blocks = mr_get_u32(&p);
    end->lost_messages = mr_get_u32(&p);
}

/* ---- reading a record ---- */

#define PAGE_BITS (MR_BOXPAGE_PAYLOAD_BYTES * 8u)

void mr_box_reader_begin(struct mr_box_reader *reader, const uint8_t *pages, const uint8_t *present,
                         size_t count)
{
    memset(reader, 0, sizeof *reader);
    reader->pages = pages;
    reader->present = present;
    reader->page_count = count;
}

static const uint8_t *find_stream_page(const struct mr_box_reader *reader, size_t i)
{
    const uint8_t *page = reader->pages + i * MR_BOXPAGE_BYTES;
    bool there = i < reader->page_count && reader->present[i] &&
                 (page[MR_BOXPAGE_KIND_OFFSET] | MR_BOXPAGE_NOT_FREED) ==
                     (MR_BOXPAGE_NOT_FREED | MR_BOXPAGE_STREAM);
    return there ? page : NULL;
}

static bool resynchronise(struct mr_box_reader *reader)
{
    for (; reader->page < reader->page_count; reader->page++) {
        const uint8_t *page = find_stream_page(reader, reader->page);
        if (page && page[MR_BOXPAGE_FIRST_OFFSET] < MR_BOXPAGE_PAYLOAD_BYTES) {
            reader->bit = 8u * page[MR_BOXPAGE_FIRST_OFFSET];
            reader->pack.has_key = false;
            reader->is_synchronised = true;
            return true;
        }
    }
    return false;
}

static void skip_pages(struct mr_box_reader *reader, size_t pages)
{
    reader->page += pages;
    reader->is_synchronised = false;
}

enum mr_status mr_box_reader_next(struct mr_box_reader *reader, struct mr_record *record)
{
    uint8_t window[2 *
                   /* payload of two pages, because a record may begin on one page and end on the
                * next */
                   MR_BOXPAGE_PAYLOAD_BYTES];
    for (;;) {
        if (!reader->is_synchronised && !resynchronise(reader))
            return MR_TOO_FEW;
        const uint8_t *page = find_stream_page(reader, reader->page);
        if (!page) {
            skip_pages(reader, 0);
            continue;
        }
        const uint8_t *next = find_stream_page(reader, reader->page + 1);
        memcpy(window, page + MR_BOXPAGE_HEADER_BYTES, MR_BOXPAGE_PAYLOAD_BYTES);
        if (next)
            memcpy(window + MR_BOXPAGE_PAYLOAD_BYTES, next + MR_BOXPAGE_HEADER_BYTES,
                   MR_BOXPAGE_PAYLOAD_BYTES);
        size_t at = reader->bit;
        enum mr_status status = mr_unpack_record(&reader->pack, window,
                                                 next ? 2 * PAGE_BITS : PAGE_BITS, &at, record);
        if (status != MR_OK) {
            skip_pages(reader, 1);
            continue;
        }
        if (record->kind == MR_RECORD_END) {
            skip_pages(reader, (at - 1) / PAGE_BITS + 1);
            continue;
        }
        reader->page += at / PAGE_BITS;
        reader->bit = at % PAGE_BITS;
        if (record->kind != MR_RECORD_OTHER)
            return MR_OK;
    }
}
