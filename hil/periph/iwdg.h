/* Independent watchdog (RM0090 21), clocked by the LSI, which is anywhere from 17 to 47 kHz. */
#ifndef MATRIG_HIL_IWDG_H
#define MATRIG_HIL_IWDG_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

struct hil_iwdg {
    uint32_t pr, rlr;
    bool unlocked, running;
    uint64_t pr_until_ps;  /* SR.PVU and SR.RVU: a written value takes up to five LSI cycles to arrive */
    uint64_t rlr_until_ps;
};

void hil_iwdg_reset(struct hil_board *board);
uint32_t hil_iwdg_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_iwdg_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_iwdg_event(struct hil_board *board, uint64_t at);

#endif
