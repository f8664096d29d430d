/* The core's address space: where its memories are mapped, what is at address 0, and the ranges
 * that answer through the bus. */
#ifndef MATRIG_HIL_MAP_H
#define MATRIG_HIL_MAP_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;

/* Map everything. Aborts when Unicorn cannot. */
void hil_map_create(struct hil_core *core);
/* While an erase runs beside code in RAM, reads of flash are caught, for they wait. */
void hil_map_guard_flash(struct hil_core *core, bool guarded);
/* Make address 0 what the state says: flash, or after BOOT0 the ROM. */
void hil_map_follow_boot_pin(struct hil_core *core);
bool hil_map_is_flash(const struct hil_core *core, uint32_t address);

#endif
