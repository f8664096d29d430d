#include "hil/periph/iwdg.h"

#include "hil/board/machine.h"

#define KEY_RELOAD 0xaaaau
#define KEY_UNLOCK 0x5555u
#define KEY_START 0xccccu
#define CSR_IWDGRSTF (1u << 29)
#define UPDATE_LSI_CYCLES 5u

void hil_iwdg_reset(struct hil_board *board)
{
    board->state.iwdg = (struct hil_iwdg){.rlr = 0xfff};
    hil_event_set_ps(board, HIL_EVENT_IWDG, HIL_NEVER);
}

static uint64_t lsi_ps(const struct hil_board *board, uint64_t lsi_cycles)
{
    return lsi_cycles * HIL_SECOND_PS / board->options.lsi_hz;
}

static void reload(struct hil_board *board)
{
    struct hil_iwdg *w = &board->state.iwdg;
    /* Divider 4 * 2^PR, at most 256; reset when the counter passes 0. */
    uint64_t divider = 4u << (w->pr > 6 ? 6 : w->pr);
    uint64_t timeout_ps = lsi_ps(board, divider * (w->rlr + 1u));
    if (w->running)
        hil_event_set_ps(board, HIL_EVENT_IWDG, hil_board_now_ps(board) + timeout_ps);
}

uint32_t hil_iwdg_read(struct hil_board *board, unsigned unit, uint32_t offset)
{
    struct hil_iwdg *w = &board->state.iwdg;
    uint64_t now = hil_board_now_ps(board);
    (void)unit;
    switch (offset) {
    case 0x00: /* KR reads as 0 */
        return 0;
    case 0x04:
        return w->pr;
    case 0x08:
        return w->rlr;
    case 0x0c:
        return (uint32_t)(now < w->pr_until_ps) | (uint32_t)(now < w->rlr_until_ps) << 1;
    default:
        return hil_bus_no_register(board);
    }
}

static bool may_change(struct hil_board *board, bool updating)
{
    if (!board->state.iwdg.unlocked)
        hil_bus_refuse(board, "the register is locked: silicon ignores the write");
    else if (updating)
        hil_bus_refuse(board, "a value is still on its way (PVU, RVU): silicon ignores the write");
    return board->state.iwdg.unlocked && !updating;
}

void hil_iwdg_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_iwdg *w = &board->state.iwdg;
    uint64_t now = hil_board_now_ps(board);
    (void)unit;
    switch (offset) {
    case 0x00:
        value &= 0xffffu;
        w->unlocked = value == KEY_UNLOCK;
        if (value == KEY_START) {
            if (!w->running) {
                w->running = true;
                hil_rcc_start_lsi(board);
            }
            reload(board);
        } else if (value == KEY_RELOAD) {
            reload(board);
        }
        break;
    case 0x04:
        if (may_change(board, now < w->pr_until_ps)) {
            w->pr = value & 7u;
            w->pr_until_ps = now + lsi_ps(board, UPDATE_LSI_CYCLES);
        }
        break;
    case 0x08:
        if (may_change(board, now < w->rlr_until_ps)) {
            w->rlr = value & 0xfffu;
            w->rlr_until_ps = now + lsi_ps(board, UPDATE_LSI_CYCLES);
        }
        break;
    default:
        hil_bus_no_register(board);
    }
}

void hil_iwdg_event(struct hil_board *board, uint64_t at)
{
    (void)at;
    board->state.counters.watchdog_resets++;
    hil_trace(board, "watchdog expired");
    hil_board_request_reset(board, CSR_IWDGRSTF);
}
