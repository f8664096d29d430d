/* What the W25Q128JV demands of its master: its rows of hil/periph/rules.def. */
#ifndef MATRIG_HIL_W25Q_RULES_H
#define MATRIG_HIL_W25Q_RULES_H

#include <stdint.h>

struct hil_rules_device;

/* What its next command is measured from. */
struct hil_w25q_past {
    uint8_t before;    /* the command before, 0: none since power came */
    uint8_t rests;     /* a command that was carried out and wants to be left alone, 0: none */
    uint64_t power_ps; /* when power came */
};

/* A command's first byte is there: only now is it known what its select had to keep. */
void hil_w25q_hold_rules(struct hil_rules_device *rules, const struct hil_w25q_past *past,
                         uint8_t command, double clock_period_ns);

#endif
