#include "hil/periph/dma.h"

#include <string.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/nvic.h"

#define LIFCR                  0x08u
#define STREAMS                0x10u /* offset of the registers of stream 0 */
#define STREAM_BYTES           0x18u
#define CR                     0x00u
#define FCR                    0x14u
#define CR_EN                  1u
#define CR_CIRC                0x100u
#define CR_MINC                0x400u
#define FCR_RESET              0x21u
/* Flags of one stream in LISR/HISR, before shifting. DMEIF and FEIF are never set here. */
#define FLAG_TRANSFER_ERROR    8u
#define FLAG_HALF_TRANSFER     16u
#define FLAG_TRANSFER_COMPLETE 32u
#define FLAG_ALL               0x3du

static unsigned get_flag_shift(unsigned stream)
{
    static const uint8_t shift[4] = {0, 6, 16, 22};
    return shift[stream & 3u];
}

static uint32_t get_stream_flags(const struct hil_dma *dma, unsigned stream)
{
    return dma->isr[stream / 4u] >> get_flag_shift(stream) & FLAG_ALL;
}

static void update_irq(struct hil_dma_device *dev, unsigned unit, unsigned stream)
{
    static const uint8_t irq[2][8] = {{11, 12, 13, 14, 15, 16, 17, 47},
                                      {56, 57, 58, 59, 60, 68, 69, 70}};
    const struct hil_dma *dma = &dev->state[unit];
    uint32_t cr = dma->stream[stream].cr;
    uint32_t enabled = (cr & 2u ? 4u : 0) | (cr & 4u ? FLAG_TRANSFER_ERROR : 0) |
                       (cr & 8u ? FLAG_HALF_TRANSFER : 0);
    enabled |= (cr & 16u ? FLAG_TRANSFER_COMPLETE : 0) | (dma->stream[stream].fcr & 0x80u ? 1u : 0);
    hil_irq_set_line(dev->core, irq[unit][stream], (get_stream_flags(dma, stream) & enabled) != 0);
}

static void raise_flag(struct hil_dma_device *dev, unsigned unit, unsigned stream, uint32_t flag)
{
    dev->state[unit].isr[stream / 4u] |= flag << get_flag_shift(stream);
    update_irq(dev, unit, stream);
}

static void stop_after_error(struct hil_dma_device *dev, unsigned unit, unsigned stream,
                             uint32_t address)
{
    dev->state[unit].stream[stream].cr &= ~CR_EN;
    hil_trace(dev->core, "DMA%u stream %u has a transfer error at 0x%08x", unit + 1, stream,
              (unsigned)address);
    raise_flag(dev, unit, stream, FLAG_TRANSFER_ERROR);
}

/* Finds memory that DMA can access: SRAM, and flash for reading; not the CCM. */
static uint8_t *find_memory(struct hil_dma_device *dev, uint32_t address, uint32_t n, bool write)
{
    if (address - HIL_CCM_BASE < HIL_CCM_SIZE || address < HIL_FLASH_SIZE)
        return NULL;
    return hil_memory_at(dev->core, address, n, write);
}

static uint32_t get_item_bytes(const struct hil_dma_stream *s)
{
    return 1u << (s->cr >> 11 & 3u);
}

static void count_transferred_items(struct hil_dma_device *dev, unsigned unit, unsigned stream,
                                    uint32_t n)
{
    struct hil_dma_stream *s = &dev->state[unit].stream[stream];
    uint32_t half = s->reload_count / 2u;
    uint32_t before = s->ndtr;
    s->ndtr -= n;
    if (before > s->reload_count - half && s->ndtr <= s->reload_count - half)
        raise_flag(dev, unit, stream, FLAG_HALF_TRANSFER);
    if (s->ndtr == 0) {
        if (s->cr & CR_CIRC)
            s->ndtr = s->reload_count;
        else
            s->cr &= ~CR_EN;
        raise_flag(dev, unit, stream, FLAG_TRANSFER_COMPLETE);
    }
}

static struct hil_dma_stream *get_request_stream(struct hil_dma_device *dev,
                                                 const struct hil_dma_request *r)
{
    return &dev->state[r->controller].stream[r->stream];
}

uint32_t hil_dma_items_until_flag(struct hil_dma_device *dev, const struct hil_dma_request *r)
{
    const struct hil_dma_stream *s = get_request_stream(dev, r);
    uint32_t direction = s->cr >> 6 & 3u;
    if (!(s->cr & CR_EN) || (s->cr >> 25 & 7u) != r->channel ||
        direction != (r->is_from_memory ? 1u : 0u))
        return 0;
    if (s->par != r->peripheral_address) {
        hil_core_stop(
            dev->core, MR_UNMODELLED,
            "DMA%u stream %u serves a request from the register at 0x%08x, but PAR is 0x%08x",
            r->controller + 1, r->stream, (unsigned)r->peripheral_address, (unsigned)s->par);
        return 0;
    }
    if (r->is_from_memory && hil_memory_is_stalled(dev->core, s->m0ar))
        dev->state[r->controller].is_waiting_for_flash = true;
    if (dev->state[r->controller].is_waiting_for_flash)
        return 0;
    uint32_t to_half = s->reload_count - s->reload_count / 2u;
    return s->ndtr > to_half ? s->ndtr - to_half : s->ndtr;
}

/* Returns the address on this computer of the next n items; NULL after a transfer error. */
static uint8_t *find_next_items_memory(struct hil_dma_device *dev, const struct hil_dma_request *r,
                                       uint32_t n)
{
    struct hil_dma_stream *s = get_request_stream(dev, r);
    uint32_t bytes = get_item_bytes(s);
    uint32_t done = (s->cr & CR_MINC) ? s->reload_count - s->ndtr : 0;
    uint32_t span = (s->cr & CR_MINC) ? n * bytes : bytes;
    uint32_t address = (s->m0ar & ~(bytes - 1u)) + done * bytes;
    uint8_t *memory = find_memory(dev, address, span, !r->is_from_memory);
    if (!memory)
        stop_after_error(dev, r->controller, r->stream, address);
    return memory;
}

void hil_dma_write_items(struct hil_dma_device *dev, const struct hil_dma_request *r,
                         const uint16_t *values, uint32_t n)
{
    const struct hil_dma_stream *s = get_request_stream(dev, r);
    uint32_t bytes = get_item_bytes(s);
    uint8_t *memory = find_next_items_memory(dev, r, n);
    if (!memory)
        return;
    /* true for nearly all transfers: halfwords with incrementing addresses */
    bool halves = bytes == sizeof values[0] && (s->cr & CR_MINC);
    if (halves)
        memcpy(memory, values, n * sizeof values[0]);
    for (uint32_t i = 0; i < n && !halves; i++) {
        uint8_t *p = memory + ((s->cr & CR_MINC) ? i * bytes : 0);
        uint32_t value = values[i];
        for (uint32_t b = 0; b < bytes; b++)
            p[b] = (uint8_t)(value >> (8u * b));
    }
    count_transferred_items(dev, r->controller, r->stream, n);
}

bool hil_dma_read_items(struct hil_dma_device *dev, const struct hil_dma_request *r,
                        uint8_t *values, uint32_t n)
{
    const struct hil_dma_stream *s = get_request_stream(dev, r);
    uint32_t bytes = get_item_bytes(s);
    const uint8_t *memory = find_next_items_memory(dev, r, n);
    if (!memory)
        return false;
    for (uint32_t i = 0; i < n; i++)
        values[i] = memory[(s->cr & CR_MINC) ? i * bytes : 0];
    count_transferred_items(dev, r->controller, r->stream, n);
    return true;
}

void hil_dma_move_register(struct hil_dma_device *dev, unsigned controller, unsigned stream,
                           unsigned channel)
{
    struct hil_dma_stream *s = &dev->state[controller].stream[stream];
    struct hil_dma_request r = {controller, stream, channel, s->par, false};
    if (!hil_dma_items_until_flag(dev, &r))
        return; /* not served: the flag stays set, and the next capture is an overrun */
    uint32_t value = hil_bus_read(dev->core, s->par, get_item_bytes(s));
    uint8_t *memory = find_next_items_memory(dev, &r, 1);
    if (!memory)
        return;
    for (uint32_t b = 0; b < get_item_bytes(s); b++)
        memory[b] = (uint8_t)(value >> (8u * b));
    count_transferred_items(dev, controller, stream, 1);
}

static void notify_enabled(const struct hil_dma_device *dev, unsigned unit)
{
    for (unsigned i = 0; i < HIL_DMA_CLIENTS_MAX; i++) {
        const struct hil_dma_client *client = &dev->client[unit][i];
        if (client->on_enabled)
            client->on_enabled(client->context);
    }
}

void hil_dma_on_flash_ready(void *device)
{
    struct hil_dma_device *dev = device;
    struct hil_dma *dma = dev->state;
    for (unsigned unit = 2; unit-- > 0;) {
        if (!dma[unit].is_waiting_for_flash)
            continue;
        dma[unit].is_waiting_for_flash = false;
        notify_enabled(dev, unit);
    }
}

void hil_dma_reset(void *device, unsigned unit)
{
    struct hil_dma_device *dev = device;
    struct hil_dma *dma = &dev->state[unit];
    *dma = (struct hil_dma){0};
    for (unsigned i = 0; i < 8; i++) {
        dma->stream[i].fcr = FCR_RESET;
        update_irq(dev, unit, i);
    }
}

/* Updates the transfers of a controller to the present before its registers are read. */
static void advance_clients(struct hil_dma_device *dev, unsigned unit)
{
    for (unsigned i = 0; i < HIL_DMA_CLIENTS_MAX; i++) {
        const struct hil_dma_client *client = &dev->client[unit][i];
        if (client->advance)
            client->advance(client->context, hil_now_cycle(dev->core));
    }
}

uint32_t hil_dma_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_dma_device *dev = device;
    struct hil_dma *dma = &dev->state[unit];
    advance_clients(dev, unit);
    if (offset < STREAMS) /* LIFCR and HIFCR cannot be read */
        return offset < LIFCR ? dma->isr[offset / 4u] : 0;
    return dma->stream[(offset - STREAMS) / STREAM_BYTES]
        .word[(offset - STREAMS) % STREAM_BYTES / 4u];
}

static void enable_stream(struct hil_dma_device *dev, unsigned unit, unsigned stream)
{
    struct hil_dma *dma = &dev->state[unit];
    struct hil_dma_stream *s = &dma->stream[stream];
    if (get_stream_flags(dma, stream) ||
        s->ndtr == 0) { /* as on hardware, the stream does not start (10.3.17) */
        hil_trace(dev->core, "DMA%u stream %u not enabled: flags 0x%x, NDTR %u", unit + 1, stream,
                  (unsigned)get_stream_flags(dma, stream), (unsigned)s->ndtr);
        return;
    }
    s->cr |= CR_EN;
    s->reload_count = s->ndtr;
    notify_enabled(dev, unit);
}

static void write_cr(struct hil_dma_device *dev, unsigned unit, unsigned stream, uint32_t value)
{
    struct hil_dma_stream *s = &dev->state[unit].stream[stream];
    bool was_on = (s->cr & CR_EN) != 0;
    if (was_on) { /* while a stream runs, only its enable bits can be changed */
        s->cr = (s->cr & ~0x1fu) | (value & 0x1fu);
        if (!(value & CR_EN))
            /* the stream was suspended: TC shows that the last item has been moved (10.3.14) */
            raise_flag(dev, unit, stream, FLAG_TRANSFER_COMPLETE);
    } else {
        s->cr = value & ~CR_EN;
        if (value & CR_EN)
            enable_stream(dev, unit, stream);
    }
    update_irq(dev, unit, stream);
}

void hil_dma_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_dma_device *dev = device;
    struct hil_dma *dma = &dev->state[unit];
    advance_clients(dev, unit);
    if (offset < STREAMS) {
        unsigned high = (offset - LIFCR) / 4u;
        dma->isr[high] &= ~value;
        for (unsigned i = 0; i < 4; i++)
            update_irq(dev, unit, 4u * high + i);
        return;
    }
    unsigned stream = (offset - STREAMS) / STREAM_BYTES;
    uint32_t at = (offset - STREAMS) % STREAM_BYTES;
    struct hil_dma_stream *s = &dma->stream[stream];
    if (at == CR)
        write_cr(dev, unit, stream, value);
    else if (at == FCR)
        s->fcr = (s->fcr & 0x38u) | (value & 0x83u);
    else if (s->cr & CR_EN)
        hil_trace(dev->core, "DMA%u stream %u is on: write to offset 0x%x ignored", unit + 1,
                  stream, (unsigned)offset);
    else
        s->word[at / 4u] = value;
}
