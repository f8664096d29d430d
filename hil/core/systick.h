/* SysTick: 24-bit down counter (ARMv7-M B3.3). The counter is computed when somebody looks; only its zero
 * is an event. */
#ifndef MATRIG_HIL_SYSTICK_H
#define MATRIG_HIL_SYSTICK_H

#include <stdint.h>

struct hil_board;

struct hil_systick {
    uint32_t ctrl;       /* ENABLE, TICKINT, CLKSOURCE, COUNTFLAG (bit 16) */
    uint32_t load;
    uint32_t value;      /* while stopped */
    uint64_t zero_cycle; /* while running: when the counter next becomes 0 */
};

uint32_t hil_systick_read(struct hil_board *board, uint32_t offset);
void hil_systick_write(struct hil_board *board, uint32_t offset, uint32_t value);
void hil_systick_event(struct hil_board *board, uint64_t at);

#endif
