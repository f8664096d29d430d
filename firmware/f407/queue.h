/* How far a ring between an interrupt and the main loop is filled: one side alone puts, the other
 * alone takes. Counts of all that was ever put and taken; an entry is at its count modulo the size,
 * a power of two. The fences keep an entry's own loads and stores on their side of the count that
 * gives it away: of the compiler alone, for both sides are the one core. */
#ifndef MATRIG_FIRMWARE_F407_QUEUE_H
#define MATRIG_FIRMWARE_F407_QUEUE_H

#include <stdint.h>

#define QUEUE_FENCE() __asm volatile("" ::: "memory")

struct queue {
    volatile uint32_t put, taken;
};

static inline uint32_t queue_filled(const struct queue *queue)
{
    uint32_t filled = queue->put - queue->taken;
    QUEUE_FENCE();
    return filled;
}

static inline void queue_put(struct queue *queue, uint32_t entries)
{
    QUEUE_FENCE();
    queue->put += entries;
}

static inline void queue_take(struct queue *queue, uint32_t entries)
{
    QUEUE_FENCE();
    queue->taken += entries;
}

#endif
