#include "host/link/can_error.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <stdarg.h>
#include <stdio.h>

struct name {
    uint8_t value;
    const char *text;
};

static const struct name controller[] = {
    {CAN_ERR_CRTL_RX_OVERFLOW, "receive overflow in the controller"},
    {CAN_ERR_CRTL_TX_OVERFLOW, "transmit overflow in the controller"},
    {CAN_ERR_CRTL_RX_WARNING, "error warning (receiving)"},
    {CAN_ERR_CRTL_TX_WARNING, "error warning (transmitting)"},
    {CAN_ERR_CRTL_RX_PASSIVE, "error passive (receiving)"},
    {CAN_ERR_CRTL_TX_PASSIVE, "error passive (transmitting)"},
    {CAN_ERR_CRTL_ACTIVE, "error active again"},
};

static const struct name protocol[] = {
    {CAN_ERR_PROT_BIT, "bit error"},
    {CAN_ERR_PROT_FORM, "form error"},
    {CAN_ERR_PROT_STUFF, "bit stuffing error"},
    {CAN_ERR_PROT_BIT0, "cannot send dominant bits"},
    {CAN_ERR_PROT_BIT1, "cannot send recessive bits"},
    {CAN_ERR_PROT_OVERLOAD, "bus overload"},
    {CAN_ERR_PROT_ACTIVE, "active error announced"},
    {CAN_ERR_PROT_TX, "while transmitting"},
};

static const struct name location[] = {
    {CAN_ERR_PROT_LOC_SOF, "start of frame"},
    {CAN_ERR_PROT_LOC_ID28_21, "identifier bits 28 to 21"},
    {CAN_ERR_PROT_LOC_ID20_18, "identifier bits 20 to 18"},
    {CAN_ERR_PROT_LOC_SRTR, "substitute remote bit"},
    {CAN_ERR_PROT_LOC_IDE, "identifier extension bit"},
    {CAN_ERR_PROT_LOC_ID17_13, "identifier bits 17 to 13"},
    {CAN_ERR_PROT_LOC_ID12_05, "identifier bits 12 to 5"},
    {CAN_ERR_PROT_LOC_ID04_00, "identifier bits 4 to 0"},
    {CAN_ERR_PROT_LOC_RTR, "remote bit"},
    {CAN_ERR_PROT_LOC_RES1, "reserved bit 1"},
    {CAN_ERR_PROT_LOC_RES0, "reserved bit 0"},
    {CAN_ERR_PROT_LOC_DLC, "length"},
    {CAN_ERR_PROT_LOC_DATA, "data"},
    {CAN_ERR_PROT_LOC_CRC_SEQ, "checksum"},
    {CAN_ERR_PROT_LOC_CRC_DEL, "checksum delimiter"},
    {CAN_ERR_PROT_LOC_ACK, "acknowledge slot"},
    {CAN_ERR_PROT_LOC_ACK_DEL, "acknowledge delimiter"},
    {CAN_ERR_PROT_LOC_EOF, "end of frame"},
    {CAN_ERR_PROT_LOC_INTERM, "intermission"},
};

/* Transceiver faults: CANH in the low half of the byte, CANL in the high half. */
static const struct name wires[] = {
    {CAN_ERR_TRX_CANH_NO_WIRE, "CANH not connected"},
    {CAN_ERR_TRX_CANH_SHORT_TO_BAT, "CANH shorted to battery"},
    {CAN_ERR_TRX_CANH_SHORT_TO_VCC, "CANH shorted to supply"},
    {CAN_ERR_TRX_CANH_SHORT_TO_GND, "CANH shorted to ground"},
    {CAN_ERR_TRX_CANL_NO_WIRE, "CANL not connected"},
    {CAN_ERR_TRX_CANL_SHORT_TO_BAT, "CANL shorted to battery"},
    {CAN_ERR_TRX_CANL_SHORT_TO_VCC, "CANL shorted to supply"},
    {CAN_ERR_TRX_CANL_SHORT_TO_GND, "CANL shorted to ground"},
    {CAN_ERR_TRX_CANL_SHORT_TO_CANH, "CANL shorted to CANH"},
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const char *name_of(const struct name *names, size_t count, unsigned value)
{
    for (size_t i = 0; i < count; i++) {
        if (names[i].value == value)
            return names[i].text;
    }
    return NULL;
}

static uint32_t controller_troubles(uint8_t state)
{
    uint32_t troubles = 0;
    if (state & CAN_ERR_CRTL_RX_OVERFLOW)
        troubles |= 1u << LINK_RX_OVERFLOW;
    if (state & CAN_ERR_CRTL_TX_OVERFLOW)
        troubles |= 1u << LINK_TX_OVERFLOW;
    if (state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING))
        troubles |= 1u << LINK_ERROR_WARNING;
    if (state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE))
        troubles |= 1u << LINK_ERROR_PASSIVE;
    if (state & CAN_ERR_CRTL_ACTIVE)
        troubles |= 1u << LINK_ERROR_ACTIVE;
    return troubles;
}

uint32_t can_error_troubles(const struct link_frame *frame)
{
    static const struct {
        uint32_t class_bit;
        enum link_trouble trouble;
    } classes[] = {
        {CAN_ERR_BUSOFF, LINK_BUS_OFF},
        {CAN_ERR_RESTARTED, LINK_RESTARTED},
        {CAN_ERR_ACK, LINK_NO_ACK},
        {CAN_ERR_LOSTARB, LINK_ARBITRATION_LOST},
        {CAN_ERR_PROT, LINK_PROTOCOL_ERROR},
        {CAN_ERR_BUSERROR, LINK_BUS_ERROR},
        {CAN_ERR_TX_TIMEOUT, LINK_TX_TIMEOUT},
        {CAN_ERR_TRX, LINK_TRANSCEIVER},
    };
    uint32_t troubles = 0;
    for (size_t i = 0; i < COUNT(classes); i++) {
        if (frame->id & classes[i].class_bit)
            troubles |= 1u << classes[i].trouble;
    }
    if (frame->id & CAN_ERR_CRTL)
        troubles |= controller_troubles(frame->data[1]);
    return troubles ? troubles : 1u << LINK_OTHER_ERROR;
}

/* Text that grows by parts, "; " between them. */
struct text {
    char *out;
    size_t used;
};

__attribute__((format(printf, 2, 3))) static void add(struct text *text, const char *format, ...)
{
    va_list arguments;
    if (text->used > 0 && text->used + 2 < CAN_ERROR_TEXT_MAX)
        text->used += (size_t)snprintf(text->out + text->used, CAN_ERROR_TEXT_MAX - text->used,
                                       "; ");
    va_start(arguments, format);
    int length = vsnprintf(text->out + text->used, CAN_ERROR_TEXT_MAX - text->used, format,
                           arguments);
    va_end(arguments);
    text->used += length > 0 ? (size_t)length : 0;
    if (text->used >= CAN_ERROR_TEXT_MAX)
        text->used = CAN_ERROR_TEXT_MAX - 1;
}

static void add_bits(struct text *text, const struct name *names, size_t count, uint8_t bits,
                     const char *otherwise)
{
    if (bits == 0)
        add(text, "%s", otherwise);
    for (size_t i = 0; i < count; i++) {
        if (bits & names[i].value)
            add(text, "%s", names[i].text);
    }
}

static void add_transceiver(struct text *text, uint8_t state)
{
    const char *high = name_of(wires, COUNT(wires), state & 0x0fu);
    const char *low = name_of(wires, COUNT(wires), state & 0xf0u);
    if (high)
        add(text, "%s", high);
    if (low)
        add(text, "%s", low);
    if (!high && !low)
        add(text, "transceiver fault");
}

void can_error_text(const struct link_frame *frame, char out[CAN_ERROR_TEXT_MAX])
{
    struct text text = {out, 0};
    const uint8_t *data = frame->data;
    out[0] = '\0';
    if (frame->id & CAN_ERR_BUSOFF)
        add(&text, "bus off");
    if (frame->id & CAN_ERR_RESTARTED)
        add(&text, "restarted after bus off");
    if (frame->id & CAN_ERR_CRTL)
        add_bits(&text, controller, COUNT(controller), data[1], "controller trouble");
    if (frame->id & CAN_ERR_ACK)
        add(&text, "no acknowledgement");
    if (frame->id & CAN_ERR_LOSTARB && data[0])
        add(&text, "arbitration lost in bit %u", data[0]);
    else if (frame->id & CAN_ERR_LOSTARB)
        add(&text, "arbitration lost");
    if (frame->id & CAN_ERR_PROT) {
        add_bits(&text, protocol, COUNT(protocol), data[2], "protocol error");
        const char *where = name_of(location, COUNT(location), data[3]);
        if (where)
            add(&text, "in the %s", where);
    }
    if (frame->id & CAN_ERR_TRX)
        add_transceiver(&text, data[4]);
    if (frame->id & CAN_ERR_BUSERROR)
        add(&text, "bus error");
    if (frame->id & CAN_ERR_TX_TIMEOUT)
        add(&text, "transmit timeout");
    if (text.used == 0)
        add(&text, "error of unknown class %05X",
            (unsigned)(frame->id & CAN_ERR_MASK & ~CAN_ERR_CNT));
    if (frame->id & CAN_ERR_CNT)
        add(&text, "error counters: transmit %u, receive %u", data[6], data[7]);
}
