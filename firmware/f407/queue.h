/* Fill level of a ring buffer between an interrupt and the main loop: only one of them adds
 * entries, and only the other one removes them. `put` and `taken` count all entries since the
 * start; an entry is at its count modulo the size, which is a power of two. The fences prevent the
 * loads and stores of an entry from moving across the update of the count that hands the entry
 * over. A compiler fence is sufficient, because both sides run on one core. */
#ifndef MATRIG_FIRMWARE_F407_QUEUE_H
#define MATRIG_FIRMWARE_F407_QUEUE_H

#include <stdint.h>

#define QUEUE_FENCE() __asm volatile("" ::: "memory")

struct queue {
    volatile uint32_t added, removed;
};

static inline uint32_t queue_filled(const struct queue *queue)
{
    uint32_t filled = queue->added - queue->removed;
    QUEUE_FENCE();
    return filled;
}

static inline void queue_add(struct queue *queue, uint32_t entries)
{
    QUEUE_FENCE();
    queue->added += entries;
}

static inline void queue_remove(struct queue *queue, uint32_t entries)
{
    QUEUE_FENCE();
    queue->removed += entries;
}

#endif
