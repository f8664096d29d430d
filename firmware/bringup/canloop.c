/* The CAN controller's frames to itself, silent: the pins stay recessive. Its driver sends and
 * receives them, at the bit rate of the firmware; it stays so, for the bus is others'. RM0090
 * 32.4.4 (loop back with silent mode). */
#include "common/catalogue.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define FRAMES   100u
#define POLLS    100000u
#define FRAME_US 2000u /* a frame takes 0.13 ms */

/* Init mode, a new BTR, and out of it. */
static bool set_mode(uint32_t bits)
{
    CAN1->MCR = CAN_MCR_INRQ | CAN_MCR_TXFP;
    unsigned polls = 0;
    while (!(CAN1->MSR & CAN_MSR_INAK) && polls < POLLS)
        polls++;
    if (polls == POLLS)
        return false;
    CAN1->BTR = (CAN1->BTR & ~(CAN_BTR_LBKM | CAN_BTR_SILM)) | bits;
    CAN1->MCR = CAN_MCR_TXFP;
    for (polls = 0; (CAN1->MSR & CAN_MSR_INAK) && polls < POLLS;)
        polls++;
    return polls < POLLS;
}

static bool comes_back(const struct board_can_frame *sent)
{
    struct board_can_frame got = {0};
    uint32_t begun = pace_begin();
    if (!board_can_send(sent))
        return false;
    while (!board_can_receive(&got)) {
        if (pace_passed(begun, FRAME_US))
            return false;
    }
    bool same = got.id == sent->id && got.length == sent->length;
    for (unsigned i = 0; i < sent->length; i++)
        same &= got.data[i] == sent->data[i];
    return same;
}

void bringup_can(void)
{
    struct board_can_errors errors;
    /* alternating bits: no stuff bit among the data. Of an id that the driver's filter lets in. */
    struct board_can_frame frame = {.id = MR_ID_COMMAND, .length = 8};
    board_can_state(&errors);
    board_can_move(0);
    if (errors.missing || !set_mode(CAN_BTR_LBKM | CAN_BTR_SILM)) {
        say_none("can_frames", "frames");
        say_none("can_frame", "us");
        return;
    }
    uint32_t good = 0, cycles = 0;
    for (unsigned n = 0; n < FRAMES; n++) {
        for (unsigned i = 0; i < 8; i++)
            frame.data[i] = n & 1u ? 0x55u : 0xaau;
        uint32_t begun = pace_begin();
        good += comes_back(&frame);
        cycles += pace_cycles(begun);
    }
    board_can_state(&errors);
    say_number("can_frames", (int32_t)good, "frames");
    say_milli("can_frame", (int32_t)((uint64_t)cycles * 1000u / (FRAMES * pace_hclk_mhz())), "us");
    say_number("can_errors", errors.tec + errors.rec, "count");
}
