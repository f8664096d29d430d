/* A wire from one part to another: who is told, and by which call. The part at the near end knows
 * nothing of the far end, so that a peripheral does not know the board it sits on. */
#ifndef MATRIG_HIL_CALL_H
#define MATRIG_HIL_CALL_H

struct hil_call {
    void (*call)(void *who); /* NULL: nobody is there */
    void *who;
};

static inline void hil_call(const struct hil_call *wire)
{
    if (wire->call)
        wire->call(wire->who);
}

#endif
