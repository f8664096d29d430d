#include "host/link/slcan.h"

#include <linux/can/error.h>
#include <stdio.h>

#define BEL '\a'

/* Flags of the answer to F. */
#define STATUS_RX_FULL     0x01u
#define STATUS_TX_FULL     0x02u
#define STATUS_WARNING     0x04u
#define STATUS_OVERRUN     0x08u
#define STATUS_PASSIVE     0x20u
#define STATUS_ARBITRATION 0x40u
#define STATUS_BUS_ERROR   0x80u

/* `digits` hexadecimal digits at `*at`, which moves on. */
static bool take_hex(const char **at, const char *end, unsigned digits, uint32_t *value)
{
    *value = 0;
    if (end - *at < (ptrdiff_t)digits)
        return false;
    for (unsigned i = 0; i < digits; i++, (*at)++) {
        char c = **at;
        uint32_t digit;
        if (c >= '0' && c <= '9')
            digit = (uint32_t)(c - '0');
        else if (c >= 'A' && c <= 'F')
            digit = (uint32_t)(c - 'A') + 10;
        else if (c >= 'a' && c <= 'f')
            digit = (uint32_t)(c - 'a') + 10;
        else
            return false;
        *value = *value << 4 | digit;
    }
    return true;
}

static bool take_frame(struct slcan_parser *parser)
{
    const char *at = parser->line + 1, *end = parser->line + parser->length;
    bool wide = parser->line[0] == 'T' || parser->line[0] == 'R';
    bool remote = parser->line[0] == 'r' || parser->line[0] == 'R';
    struct link_frame *frame = &parser->frame;
    uint32_t id, length, value;
    *frame = (struct link_frame){0};
    if (!take_hex(&at, end, wide ? 8 : 3, &id) || id > (wide ? 0x1fffffffu : 0x7ffu) ||
        !take_hex(&at, end, 1, &length) || length > 8)
        return false;
    frame->id = id | (wide ? LINK_ID_EXTENDED : 0) | (remote ? LINK_ID_REMOTE : 0);
    frame->length = (uint8_t)length;
    for (unsigned i = 0; i < length && !remote; i++) {
        if (!take_hex(&at, end, 2, &value))
            return false;
        frame->data[i] = (uint8_t)value;
    }
    parser->stamp_ms = SLCAN_STAMP_NONE;
    if (at == end)
        return true;
    if (!take_hex(&at, end, 4, &value) || value >= SLCAN_STAMP_WRAP_MS)
        return false;
    parser->stamp_ms = value;
    return at == end;
}

static enum slcan_kind take_line(struct slcan_parser *parser)
{
    const char *at = parser->line + 1, *end = parser->line + parser->length;
    uint32_t value;
    if (parser->length == 0)
        return SLCAN_DONE;
    switch (parser->line[0]) {
    case 't':
    case 'T':
    case 'r':
    case 'R': return take_frame(parser) ? SLCAN_FRAME : SLCAN_GARBLED;
    case 'z':
    case 'Z': return parser->length == 1 ? SLCAN_DONE : SLCAN_GARBLED;
    case 'F':
        if (parser->length != 3 || !take_hex(&at, end, 2, &value))
            return SLCAN_GARBLED;
        parser->status = (uint8_t)value;
        return SLCAN_STATUS;
    case 'V':
    case 'v':
    case 'N': return SLCAN_ANSWER;
    default: return SLCAN_GARBLED;
    }
}

enum slcan_kind slcan_push(struct slcan_parser *parser, char c)
{
    if (c == '\r') {
        enum slcan_kind kind = parser->overlong ? SLCAN_GARBLED : take_line(parser);
        parser->length = 0;
        parser->overlong = false;
        return kind;
    }
    /* BEL ends a line too; what stood before it was cut off. */
    if (c == BEL) {
        bool clean = parser->length == 0 && !parser->overlong;
        parser->length = 0;
        parser->overlong = false;
        return clean ? SLCAN_REFUSED : SLCAN_GARBLED;
    }
    if (parser->length == sizeof parser->line)
        parser->overlong = true;
    else
        parser->line[parser->length++] = c;
    return SLCAN_MORE;
}

size_t slcan_print(const struct link_frame *frame, char out[SLCAN_LINE_MAX])
{
    bool wide = (frame->id & LINK_ID_EXTENDED) != 0;
    bool remote = (frame->id & LINK_ID_REMOTE) != 0;
    uint32_t id = frame->id & (wide ? 0x1fffffffu : 0x7ffu);
    char kind = remote ? (wide ? 'R' : 'r') : (wide ? 'T' : 't');
    unsigned count = frame->length > 8 ? 8 : frame->length;
    int length = snprintf(out, SLCAN_LINE_MAX, "%c%0*X%u", kind, wide ? 8 : 3, (unsigned)id, count);
    for (unsigned i = 0; i < count && !remote; i++)
        length += snprintf(out + length, SLCAN_LINE_MAX - (size_t)length, "%02X", frame->data[i]);
    length += snprintf(out + length, SLCAN_LINE_MAX - (size_t)length, "\r");
    return (size_t)length;
}

bool slcan_status_frame(uint8_t status, struct link_frame *frame)
{
    uint8_t controller = 0;
    *frame = (struct link_frame){.id = LINK_ID_ERROR, .length = CAN_ERR_DLC};
    if (status & (STATUS_RX_FULL | STATUS_OVERRUN))
        controller |= CAN_ERR_CRTL_RX_OVERFLOW;
    if (status & STATUS_TX_FULL)
        controller |= CAN_ERR_CRTL_TX_OVERFLOW;
    /* The flags do not say which of the two counters it is. */
    if (status & STATUS_WARNING)
        controller |= CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING;
    if (status & STATUS_PASSIVE)
        controller |= CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
    if (controller)
        frame->id |= CAN_ERR_CRTL;
    frame->data[1] = controller;
    if (status & STATUS_ARBITRATION)
        frame->id |= CAN_ERR_LOSTARB;
    if (status & STATUS_BUS_ERROR)
        frame->id |= CAN_ERR_BUSERROR;
    return frame->id != LINK_ID_ERROR;
}

/* The stamp without wraps: the adapter's clock has gone on by its difference, and by as many whole
 * minutes as the host's clock says. */
static uint64_t unwrap(const struct slcan_clock *clock, unsigned stamp_ms, uint64_t host_us)
{
    uint64_t step_us = (stamp_ms + SLCAN_STAMP_WRAP_MS - clock->stamp_ms) % SLCAN_STAMP_WRAP_MS *
                       1000u;
    uint64_t wrap_us = SLCAN_STAMP_WRAP_MS * 1000u;
    uint64_t host_step_us = host_us > clock->host_us ? host_us - clock->host_us : 0;
    uint64_t wraps = host_step_us > step_us ? (host_step_us - step_us + wrap_us / 2) / wrap_us : 0;
    return clock->adapter_us + step_us + wraps * wrap_us;
}

uint64_t slcan_time(struct slcan_clock *clock, unsigned stamp_ms, uint64_t host_us)
{
    if (stamp_ms == SLCAN_STAMP_NONE)
        return host_us;
    clock->adapter_us = clock->clock.known ? unwrap(clock, stamp_ms, host_us) : stamp_ms * 1000u;
    clock->stamp_ms = stamp_ms;
    clock->host_us = host_us;
    return adapter_clock_time(&clock->clock, clock->adapter_us, host_us);
}
