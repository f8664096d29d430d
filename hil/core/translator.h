/* Access to Unicorn's internal translator: speeds up stores to RAM, and finds the instruction of a
 * translated block that makes the access in progress. See translator.c. */
#ifndef MATRIG_HIL_TRANSLATOR_H
#define MATRIG_HIL_TRANSLATOR_H

#include <stdbool.h>
#include <stdint.h>

struct CPUState;

struct hil_translator {
    bool has_code_in_ram;
    struct CPUState *cpu_state; /* Unicorn's CPU state; NULL: not known yet */
    struct hil_translated_access {
        uint32_t address;
        /* position of the access in the translated code; 0: no access is in progress */
        uintptr_t code_address;
    } access;
    bool is_instruction_abandoned; /* the instruction that makes the access must not be continued */
};

/* Initialises the translator of a new processor. */
void hil_translator_start(struct hil_translator *translator);
/* Sets the processor that runs in this thread (NULL: none). Returns the previous one. */
struct hil_translator *hil_translator_select(struct hil_translator *translator);
/* Call when the processor executes code in RAM. */
void hil_translator_check_ram_stores(struct hil_translator *translator);
/* An instruction, and ITSTATE at its beginning. */
struct hil_instruction {
    uint32_t pc, itstate;
};
/* Returns the instruction that is accessing `address`. Returns false if the core makes no access,
 * or one to a different address. */
bool hil_translator_find_instruction(const struct hil_translator *translator, uint32_t address,
                                     struct hil_instruction *place);
/* True if the core is making an access at which the translated code can be left. */
bool hil_translator_can_leave_code(const struct hil_translator *translator);
/* Leaves the translated code before the access, or after it if the access was abandoned. The
 * processor is then at the instruction that makes the access, and Unicorn returns if a stop was
 * requested. */
__attribute__((noreturn)) void hil_translator_leave_code(const struct hil_translator *translator);

#endif
