#include "firmware/blackbox_parts.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/health.h"

/* pages of the ring: 8 of configuration at 4 ms each, 58 bytes per ms meanwhile, twice over */
#define SLACK       16u
#define SLACK_ERASE 112u /* 400 ms of the same, and those */

static void open_page(struct blackbox_writer *writer, uint8_t *page)
{
    memset(page, 0, MR_BOXPAGE);
    page[MR_BOXPAGE_KIND] = MR_BOXPAGE_LIVE | MR_BOXPAGE_STREAM;
    page[MR_BOXPAGE_FIRST] = MR_BOXPAGE_NO_FIRST;
    writer->page = page;
    writer->bit = 0;
    writer->held = 0;
}

static void open_ring_page(struct blackbox *box)
{
    if (blackbox_is_rolling(box) && box->put - box->got == BLACKBOX_RING)
        box->got++;
    if (box->put % BLACKBOX_KEY_PAGES == 0)
        box->key_due = true;
    box->key_valid[box->put % BLACKBOX_RING] = false;
    open_page(&box->stream, box->ring[box->put % BLACKBOX_RING]);
}

void blackbox_begin_ring(struct blackbox *box)
{
    box->put = 0;
    box->got = 0;
    box->pack.keyed = false;
    open_ring_page(box);
    box->stream.page[MR_BOXPAGE_FIRST] = 0;
}

/* Room for one more record of the stream: it may need the page after the open one. */
static bool has_room(const struct blackbox *box)
{
    return blackbox_is_rolling(box) || box->put + 1 - box->got < BLACKBOX_RING;
}

static void close_page(struct blackbox *box, struct blackbox_writer *writer)
{
    if (writer == &box->stream) {
        box->put++;
        open_ring_page(box);
    } else if (++box->config_put < BLACKBOX_CONFIG) {
        open_page(writer, box->config[box->config_put]);
    } else {
        box->configuring = false;
    }
}

_Static_assert(MR_BOXPAGE_PAYLOAD % 4u == 0, "no word crosses the end of a page");

/* By words: `bits` holds whole ones, zeroes beyond `count`. */
static void append(struct blackbox *box, struct blackbox_writer *writer, const uint8_t *bits,
                   size_t count)
{
    while (count) {
        unsigned n = count < 32 ? (unsigned)count : 32u, held = writer->bit % 32u;
        uint32_t word = mr_get_u32(&bits);
        count -= n;
        writer->held |= word << held;
        writer->bit += n;
        if (held + n < 32)
            continue;
        unsigned end = writer->bit / 32u;
        mr_put_u32(writer->page + MR_BOXPAGE_HEADER + 4u * (end - 1), writer->held);
        if (end == MR_BOXPAGE_PAYLOAD / 4u) {
            close_page(box, writer);
            writer->bit = held + n - 32;
        }
        writer->held = word >> 1 >> (31 - held); /* by 32 when nothing was held */
    }
}

/* The end tag, and ones to the end of the page. */
void blackbox_flush(struct blackbox *box, struct blackbox_writer *writer)
{
    static const uint8_t end_tag[4] = {3};
    append(box, writer, end_tag, MR_PACK_TAG_BITS);
    uint8_t ones[4];
    unsigned left = (32u - writer->bit % 32u) % 32u; /* of a word */
    mr_put_u32(ones, (1u << left) - 1u);
    append(box, writer, ones, left);
    if (writer->bit) {
        memset(writer->page + MR_BOXPAGE_HEADER + writer->bit / 8, 0xff,
               MR_BOXPAGE_PAYLOAD - writer->bit / 8);
        close_page(box, writer);
    }
}

static void put_key(struct blackbox *box, const struct mr_block *block)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    append(box, &box->stream, bits, mr_pack_padding(box->stream.bit % 8, bits));
    unsigned slot = box->put % BLACKBOX_RING;
    if (box->stream.page[MR_BOXPAGE_FIRST] == MR_BOXPAGE_NO_FIRST)
        box->stream.page[MR_BOXPAGE_FIRST] = (uint8_t)(box->stream.bit / 8);
    if (!box->key_valid[slot]) {
        box->key_valid[slot] = true;
        box->key_block[slot] = block->index;
        box->key_stored[slot] = box->stored;
    }
    if (box->first_open) {
        box->first_open = false;
        box->end.first_block = block->index;
        box->first_stored = box->stored;
    }
    append(box, &box->stream, bits, mr_pack_key(&box->pack, block, bits));
    box->key_due = false;
}

void blackbox_block(struct blackbox *box, const struct mr_block *block)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->armed || (!blackbox_is_rolling(box) && box->state != BLACKBOX_RECORDING))
        return;
    box->last_block = block->index;
    if (!has_room(box)) {
        health_count(MR_FAULT_BOX_LOST, 0);
        return;
    }
    if (box->key_due || !mr_pack_follows(&box->pack, block))
        put_key(box, block);
    append(box, &box->stream, bits, mr_pack_block(&box->pack, block, bits));
    box->stored++;
}

void blackbox_note(struct blackbox *box, uint16_t id, const uint8_t *payload, size_t length)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->armed || (!blackbox_is_rolling(box) && box->state != BLACKBOX_RECORDING))
        return;
    if (!has_room(box)) {
        box->end.notes_lost++;
        health_count(MR_FAULT_BOX_LOST, 1);
        return;
    }
    append(box, &box->stream, bits, mr_pack_message(id, payload, length, bits));
}

void blackbox_arm(struct blackbox *box, const struct mr_boxpage_start *start)
{
    if (blackbox_is_rolling(box))
        blackbox_begin_ring(box);
    box->armed = true;
    box->reading = -1;
    box->start = *start;
    box->config_put = 1;
    open_page(&box->meta, box->config[1]);
    box->meta.page[MR_BOXPAGE_FIRST] = 0;
    box->configuring = true;
}

void blackbox_configure(struct blackbox *box, uint16_t id, const uint8_t *payload, size_t length)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->configuring)
        return;
    size_t count = mr_pack_message(id, payload, length, bits);
    unsigned left = (BLACKBOX_CONFIG - box->config_put) * MR_BOXPAGE_PAYLOAD * 8u - box->meta.bit;
    if (count + MR_PACK_TAG_BITS + 32u <= left) {
        /* the end tag, and a word that flush may close the page with */
        append(box, &box->meta, bits, count);
        return;
    }
    health_count(MR_FAULT_BOX_LOST, 1);
    /* what is there ends as it should: a reader would go on with the stream's bits otherwise */
    blackbox_flush(box, &box->meta);
    box->configuring = false;
}

/* What precedes the first key in the ring cannot be read: it is left out. So is what would leave no
 * room for the blocks that come while the configuration is written, and while an erase that began
 * before arming ends. */
void blackbox_begin_at_key(struct blackbox *box)
{
    uint32_t slack = box->waits || box->job == JOB_ERASE || box->job == JOB_LOOK ? SLACK_ERASE
                                                                                 : SLACK;
    if (box->put + slack - box->got > BLACKBOX_RING)
        box->got = box->put + slack - BLACKBOX_RING;
    while (box->got != box->put &&
           box->ring[box->got % BLACKBOX_RING][MR_BOXPAGE_FIRST] == MR_BOXPAGE_NO_FIRST)
        box->got++;
    uint32_t keyed = box->got;
    while (keyed != box->put && !box->key_valid[keyed % BLACKBOX_RING])
        keyed++;
    unsigned slot = keyed % BLACKBOX_RING;
    box->first_open = !box->key_valid[slot];
    box->key_due |= box->first_open;
    box->end = (struct mr_boxpage_end){.first_block = box->key_block[slot]};
    box->first_stored = box->key_stored[slot];
}
