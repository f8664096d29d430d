/* The wall clock of matrig-board: pacing, and a limit that ends a run which does not end by
 * itself. */
#ifndef MATRIG_HIL_WALL_H
#define MATRIG_HIL_WALL_H

#include <stdint.h>

/* Seconds and milliseconds of a clock that never jumps. */
double hil_wall_s(void);
int64_t hil_wall_ms(void);

/* Virtual time tied to the wall clock. A piece of virtual time is run when the wall clock has
 * passed its end, so nothing leaves the board early; how late the end was, at worst, is kept. */
#define HIL_PACE_START_S 1.0

struct hil_pace {
    double began_s; /* wall clock at virtual time 0 */
    double late_s;  /* of the latest piece so far */
    /* of those after HIL_PACE_START_S: at power-on the emulator translates and the board scans */
    double late_started_s;
};

/* Wait until the wall clock shows virtual time t_ps; `*stop` ends it. */
void hil_pace_wait(const struct hil_pace *pace, uint64_t t_ps, const volatile int *stop);
/* The piece that ended at t_ps is done. */
void hil_pace_done(struct hil_pace *pace, uint64_t t_ps);

/* After limit_s of wall clock set *stop to HIL_WALL_STOP; if the process is still there
 * HIL_WALL_GRACE_S later (it waits for an event that does not occur, or virtual time stands still),
 * print a message and exit with 3. 0: none. */
#define HIL_WALL_STOP    2
#define HIL_WALL_GRACE_S 5
void hil_wall_limit(double limit_s, volatile int *stop);

#endif
