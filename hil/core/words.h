/* Registers of a peripheral by name and by offset: word[offset / 4] is the register that is named
 * at that place. A register that keeps nothing, and a place without a register, has a name too and
 * stays 0. */
#ifndef MATRIG_HIL_WORDS_H
#define MATRIG_HIL_WORDS_H

#include <stdint.h>

#define HIL_WORDS(word, ...)                                          \
    union {                                                           \
        struct {                                                      \
            uint32_t __VA_ARGS__;                                     \
        };                                                            \
        uint32_t word[sizeof(struct { uint32_t __VA_ARGS__; }) / 4u]; \
    }

#endif
