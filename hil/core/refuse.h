/* Refusals: an access that nothing models ends the run, and says which. */
#ifndef MATRIG_HIL_REFUSE_H
#define MATRIG_HIL_REFUSE_H

#include <stdint.h>

struct hil_core;

/* Called by a peripheral that is asked for something it does not model, with what it is: "TIM4:
 * centre-aligned mode". Returns 0, so that a read can return it; the run stops. */
uint32_t hil_bus_refuse(struct hil_core *core, const char *what);
/* The same for a register that is not modelled. */
uint32_t hil_bus_no_register(struct hil_core *core);
/* The run stops at the access in progress: `why`, what it is, and `what` (NULL: no more to say). */
void hil_bus_stop(struct hil_core *core, const char *why, const char *what);

#endif
