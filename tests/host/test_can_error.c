/* CAN error frames in words. The frames are numbers from the kernel's documentation of error frames
 * (Documentation/networking/can.rst and the comments of linux/can/error.h), written out by hand. */
#include "host/link/can.h"
#include "tests/host/scratch.h"

#define BIT(trouble) (1u << (trouble))

static const struct {
    uint32_t id;
    uint8_t data[8];
    uint32_t troubles;
    const char *text;
} cases[] = {
    {0x20000040, {0}, BIT(LINK_BUS_OFF), "bus off"},
    {0x20000100, {0}, BIT(LINK_RESTARTED), "restarted after bus off"},
    {0x20000004, {0, 0x01}, BIT(LINK_RX_OVERFLOW), "receive overflow in the controller"},
    {0x20000004, {0, 0x02}, BIT(LINK_TX_OVERFLOW), "transmit overflow in the controller"},
    {0x20000004, {0, 0x04}, BIT(LINK_ERROR_WARNING), "error warning (receiving)"},
    {0x20000004, {0, 0x08}, BIT(LINK_ERROR_WARNING), "error warning (transmitting)"},
    {0x20000004, {0, 0x10}, BIT(LINK_ERROR_PASSIVE), "error passive (receiving)"},
    {0x20000004, {0, 0x20}, BIT(LINK_ERROR_PASSIVE), "error passive (transmitting)"},
    {0x20000004, {0, 0x40}, BIT(LINK_ERROR_ACTIVE), "error active again"},
    {0x20000004, {0}, BIT(LINK_OTHER_ERROR), "controller trouble"},
    {0x20000020, {0}, BIT(LINK_NO_ACK), "no acknowledgement"},
    {0x20000002, {0}, BIT(LINK_ARBITRATION_LOST), "arbitration lost"},
    {0x20000002, {11}, BIT(LINK_ARBITRATION_LOST), "arbitration lost in bit 11"},
    {0x20000008, {0, 0, 0x04, 0x0a}, BIT(LINK_PROTOCOL_ERROR), "bit stuffing error; in the data"},
    {0x20000008,
     {0, 0, 0x82, 0x18},
     BIT(LINK_PROTOCOL_ERROR),
     "form error; while transmitting; in the checksum delimiter"},
    {0x20000008, {0, 0, 0x00, 0x00}, BIT(LINK_PROTOCOL_ERROR), "protocol error"},
    {0x20000088,
     {0, 0, 0x90, 0x19},
     BIT(LINK_PROTOCOL_ERROR) | BIT(LINK_BUS_ERROR),
     "cannot send recessive bits; while transmitting; in the acknowledge slot; bus error"},
    {0x20000010, {0, 0, 0, 0, 0x04}, BIT(LINK_TRANSCEIVER), "CANH not connected"},
    {0x20000010,
     {0, 0, 0, 0, 0x77},
     BIT(LINK_TRANSCEIVER),
     "CANH shorted to ground; CANL shorted to ground"},
    {0x20000010, {0, 0, 0, 0, 0x80}, BIT(LINK_TRANSCEIVER), "CANL shorted to CANH"},
    {0x20000010, {0}, BIT(LINK_TRANSCEIVER), "transceiver fault"},
    {0x20000001, {0}, BIT(LINK_TX_TIMEOUT), "transmit timeout"},
    {0x20000204,
     {0, 0x30, 0, 0, 0, 0, 136, 127},
     BIT(LINK_ERROR_PASSIVE),
     "error passive (receiving); error passive (transmitting); error counters: transmit 136, "
     "receive 127"},
    /* counters that are not announced are not shown: older kernels leave other things there */
    {0x20000040, {0, 0, 0, 0, 0, 0, 9, 9}, BIT(LINK_BUS_OFF), "bus off"},
    /* nothing that is known */
    {0x20000800, {0}, BIT(LINK_OTHER_ERROR), "error of unknown class 00800"},
};

TEST(every_class_in_words)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct link_frame frame = {.id = cases[i].id, .length = 8};
        char text[CAN_ERROR_TEXT_MAX];
        memcpy(frame.data, cases[i].data, 8);
        can_error_text(&frame, text);
        assert_string_equal(text, cases[i].text);
        assert_int_equal(can_error_troubles(&frame), cases[i].troubles);
    }
}

/* Whatever comes, there is a text, and it ends; even with everything in one frame. */
TEST(any_frame_has_a_text)
{
    uint32_t seed = 1;
    for (unsigned i = 0; i < 200000; i++) {
        struct link_frame frame = {.length = 8};
        char text[CAN_ERROR_TEXT_MAX + 1];
        for (unsigned b = 0; b < 8; b++) {
            seed = seed * 1664525u + 1013904223u;
            frame.data[b] = i == 0 ? 0xff : (uint8_t)(seed >> 24);
        }
        frame.id = LINK_ID_ERROR | (i == 0 ? 0x1fffffffu : seed >> 3);
        text[CAN_ERROR_TEXT_MAX] = '#';
        can_error_text(&frame, text);
        assert_true(text[0] != '\0');
        assert_non_null(memchr(text, '\0', CAN_ERROR_TEXT_MAX));
        assert_int_equal(text[CAN_ERROR_TEXT_MAX], '#');
        assert_true(can_error_troubles(&frame) != 0);
        assert_true(can_error_troubles(&frame) < BIT(LINK_QUEUE_LOST));
    }
}

TEST(troubles_have_texts)
{
    assert_string_equal(link_trouble_text(LINK_BUS_OFF), "bus off");
    assert_string_equal(link_trouble_text(LINK_BACK), "came back");
    assert_string_equal(link_trouble_text(LINK_TROUBLES), "unknown trouble");
    /* These numbers are in campaign files. */
    assert_int_equal(LINK_BUS_OFF, 0);
    assert_int_equal(LINK_QUEUE_LOST, 14);
    assert_int_equal(LINK_BACK, 18);
}
