#include "common/boxread.h"

#include <string.h>

#define PAGE_BITS (MR_BOXPAGE_PAYLOAD * 8u)

void mr_boxread_begin(struct mr_boxread *reader, const uint8_t *pages, const uint8_t *present,
                      size_t count)
{
    memset(reader, 0, sizeof *reader);
    reader->pages = pages;
    reader->present = present;
    reader->count = count;
}

static const uint8_t *stream_page(const struct mr_boxread *reader, size_t i)
{
    const uint8_t *page = reader->pages + i * MR_BOXPAGE;
    bool there = i < reader->count && reader->present[i] &&
                 (page[MR_BOXPAGE_KIND] | MR_BOXPAGE_LIVE) == (MR_BOXPAGE_LIVE | MR_BOXPAGE_STREAM);
    return there ? page : NULL;
}

static bool find_step(struct mr_boxread *reader)
{
    for (; reader->page < reader->count; reader->page++) {
        const uint8_t *page = stream_page(reader, reader->page);
        if (page && page[MR_BOXPAGE_FIRST] < MR_BOXPAGE_PAYLOAD) {
            reader->bit = 8u * page[MR_BOXPAGE_FIRST];
            reader->pack.keyed = false;
            reader->in_step = true;
            return true;
        }
    }
    return false;
}

static void lose_step(struct mr_boxread *reader, size_t pages)
{
    reader->page += pages;
    reader->in_step = false;
}

enum mr_status mr_boxread_next(struct mr_boxread *reader, struct mr_record *record)
{
    uint8_t window[2 * MR_BOXPAGE_PAYLOAD]; /* no record is longer than a page */
    for (;;) {
        if (!reader->in_step && !find_step(reader))
            return MR_TOO_FEW;
        const uint8_t *page = stream_page(reader, reader->page);
        if (!page) {
            lose_step(reader, 0);
            continue;
        }
        const uint8_t *next = stream_page(reader, reader->page + 1);
        memcpy(window, page + MR_BOXPAGE_HEADER, MR_BOXPAGE_PAYLOAD);
        if (next)
            memcpy(window + MR_BOXPAGE_PAYLOAD, next + MR_BOXPAGE_HEADER, MR_BOXPAGE_PAYLOAD);
        size_t at = reader->bit;
        enum mr_status status = mr_unpack(&reader->pack, window, next ? 2 * PAGE_BITS : PAGE_BITS,
                                          &at, record);
        if (status != MR_OK) {
            lose_step(reader, 1);
            continue;
        }
        if (record->kind == MR_RECORD_END) {
            lose_step(reader, (at - 1) / PAGE_BITS + 1);
            continue;
        }
        reader->page += at / PAGE_BITS;
        reader->bit = at % PAGE_BITS;
        if (record->kind != MR_RECORD_OTHER)
            return MR_OK;
    }
}
