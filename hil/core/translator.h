/* Unicorn's translator from inside: faster stores to RAM, and the instruction of a translated block
 * that makes the access in progress. See translator.c. */
#ifndef MATRIG_HIL_TRANSLATOR_H
#define MATRIG_HIL_TRANSLATOR_H

#include <stdbool.h>
#include <stdint.h>

struct CPUState;

struct hil_translator {
    bool code_in_ram;
    struct CPUState *core; /* Unicorn's; NULL: not met yet */
    struct hil_translated_access {
        uint32_t address;
        uintptr_t from; /* where translated code makes it; 0: no access is in progress */
    } access;
    bool abandoned; /* the instruction that makes it ends there */
};

/* Of a new processor. */
void hil_translator_start(struct hil_translator *translator);
/* This processor runs in this thread now; NULL: none. Returns the one that ran before. */
struct hil_translator *hil_translator_run(struct hil_translator *translator);
/* It runs code from RAM. */
void hil_translator_meet_code(struct hil_translator *translator);
/* An instruction, and ITSTATE as it begins. */
struct hil_place {
    uint32_t pc, itstate;
};
/* The one that accesses `address` now. False: the core makes no access, or one of another
 * address. */
bool hil_translator_place(const struct hil_translator *translator, uint32_t address,
                          struct hil_place *place);
/* Makes the core an access now that translated code can be left at? */
bool hil_translator_can_leave(const struct hil_translator *translator);
/* Leave it, before the access or, for one that was abandoned, behind it: the processor stands at
 * the instruction that makes it, and Unicorn returns if a stop was requested. */
__attribute__((noreturn)) void hil_translator_leave(const struct hil_translator *translator);

#endif
