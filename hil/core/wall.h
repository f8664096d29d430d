/* The wall clock of matrig-board: pacing, and a time limit for runs that would not end. */
#ifndef MATRIG_HIL_WALL_H
#define MATRIG_HIL_WALL_H

#include <stdint.h>

/* Monotonic time, in seconds and milliseconds. */
double hil_wall_clock_s(void);
int64_t hil_wall_clock_ms(void);

/* Pacing of virtual time by the wall clock. A piece of virtual time is run only after the wall
 * clock has passed the end of the piece, so that no output appears too early. The largest delay of
 * an end is recorded. */
#define HIL_PACE_START_S 1.0

struct hil_pace {
    double start_s;     /* wall clock at the start of virtual time */
    double max_delay_s; /* largest delay so far with which a piece ended */
    /* the same after HIL_PACE_START_S; the first pieces take longer, because code is translated and
     * the board scans its memories */
    double max_delay_after_start_s;
};

/* Waits until the wall clock has reached virtual time t_ps; `*stop` ends the wait. */
void hil_pace_wait(const struct hil_pace *pace, uint64_t t_ps, const volatile int *stop);
/* Call when the piece that ends at t_ps has been run. */
void hil_pace_record(struct hil_pace *pace, uint64_t t_ps);

/* Sets *stop to HIL_STOP_BY_WALL_LIMIT after limit_s of wall clock (0: no limit). If the process
 * still runs HIL_WALL_GRACE_S later (it waits for an event that does not occur, or virtual time
 * does not advance), prints a message and exits with 3. */
#define HIL_STOP_BY_WALL_LIMIT 2
#define HIL_WALL_GRACE_S       5
void hil_wall_clock_set_limit(double limit_s, volatile int *stop);

#endif
