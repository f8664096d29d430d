/* Replaces internals of Unicorn 2.0.1 (Debian 12) for which it has no interface.
 *
 * Speed: this saves half of the time of a run. Unicorn executes every store to RAM through its slow
 * path, to look for translated code that the store changes. Unlike QEMU and later versions (pull
 * requests 1838, 2031), it does not recognise pages without code. Here RAM pages are marked free of
 * code (`tlb_set_dirty`) when they enter the translation buffer. Once the board runs code from RAM,
 * every store of that board is checked again. The locks around the check cost time at every store
 * and are useless in a single thread; they are omitted here, as in the next version of Unicorn.
 *
 * Instruction of an access: Unicorn's hooks report an access with PC at the start of the block and
 * ITSTATE 0. For each access that is not plain memory, translated code calls a function
 * `helper_...` with the host address of the call. For each block, the translator has a table that
 * gives the instruction for a host address; it uses the table to restore PC and ITSTATE after a
 * fault (`cpu_restore_state`). The replacements here store the host address, and read the table
 * without restoring the registers.
 *
 * End of a block: after a store that faults, Unicorn runs the block to its end, including all
 * instructions after the store; after a load it leaves the block (`cpu_loop_exit`). Here it leaves
 * after every abandoned access.
 *
 * The functions have the names of functions exported by the library, so the library's own calls
 * reach these first. With a Unicorn version that lacks those names, these functions are never
 * called, and the instruction of an access is not known; everything else works. */
#include <dlfcn.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "hil/core/translator.h"
#include "hil/core/state.h"

struct CPUARMState;
struct CPUState;
struct TranslationBlock;
struct page_collection;
struct uc_struct;
typedef bool tlb_fill_function(struct CPUState *core, uint64_t address, int size, unsigned access,
                               int mmu_index, bool probe, uintptr_t from);
typedef void set_dirty_function(struct CPUState *core, uint32_t address);
typedef void flush_function(struct CPUState *core);
typedef bool restore_function(struct CPUState *core, uintptr_t from, bool will_exit);
typedef void loop_exit_function(struct CPUState *core, uintptr_t from);
typedef void restore_to_function(struct CPUARMState *state, struct TranslationBlock *block,
                                 uint32_t *data);

struct page_collection *page_collection_lock_arm(struct uc_struct *uc, uint64_t start,
                                                 uint64_t end);
void page_collection_unlock_arm(struct page_collection *set);
tlb_fill_function arm_cpu_tlb_fill_arm;
restore_to_function restore_state_to_opc_arm;

static tlb_fill_function *library_tlb_fill;
static set_dirty_function *library_set_dirty;
static flush_function *library_flush;
static restore_function *library_restore;
static restore_to_function *library_restore_state_to_opc;
static loop_exit_function *library_loop_exit;
/* translator of the board that this thread runs */
static _Thread_local struct hil_translator *running_translator;

/* Where library_restore stores the instruction that it finds; NULL: it restores the registers as
 * usual. */
static _Thread_local struct hil_instruction *found_instruction;

/* Unicorn's functions for loads and stores on the slow path. */
#define LOADS(X)                          \
    X(uintptr_t, helper_ret_ldub_mmu_arm) \
    X(uintptr_t, helper_le_lduw_mmu_arm)  \
    X(uintptr_t, helper_le_ldul_mmu_arm)  \
    X(uint64_t, helper_le_ldq_mmu_arm)
#define STORES(X)                      \
    X(uint8_t, helper_ret_stb_mmu_arm) \
    X(uint16_t, helper_le_stw_mmu_arm) \
    X(uint32_t, helper_le_stl_mmu_arm) \
    X(uint64_t, helper_le_stq_mmu_arm)
#define DECLARE_LOAD(type, name)                                                         \
    typedef type name##_type(struct CPUARMState *state, uint32_t address, unsigned kind, \
                             uintptr_t from);                                            \
    name##_type name;                                                                    \
    static name##_type *library_##name;
#define DECLARE_STORE(type, name)                                                     \
    typedef void name##_type(struct CPUARMState *state, uint32_t address, type value, \
                             unsigned kind, uintptr_t from);                          \
    name##_type name;                                                                 \
    static name##_type *library_##name;
LOADS(DECLARE_LOAD)
STORES(DECLARE_STORE)

void hil_translator_start(struct hil_translator *translator)
{
    *translator = (struct hil_translator){0};
    *(void **)&library_tlb_fill = dlsym(RTLD_NEXT, "arm_cpu_tlb_fill_arm");
    *(void **)&library_set_dirty = dlsym(RTLD_NEXT, "tlb_set_dirty_arm");
    *(void **)&library_flush = dlsym(RTLD_NEXT, "tlb_flush_arm");
    *(void **)&library_restore = dlsym(RTLD_NEXT, "cpu_restore_state_arm");
    *(void **)&library_restore_state_to_opc = dlsym(RTLD_NEXT, "restore_state_to_opc_arm");
    *(void **)&library_loop_exit = dlsym(RTLD_NEXT, "cpu_loop_exit_restore_arm");
#define FIND_LIBRARY_FUNCTION(type, name) *(void **)&library_##name = dlsym(RTLD_NEXT, #name);
    LOADS(FIND_LIBRARY_FUNCTION)
    STORES(FIND_LIBRARY_FUNCTION)
}

struct hil_translator *hil_translator_select(struct hil_translator *translator)
{
    struct hil_translator *before = running_translator;
    running_translator = translator;
    /* the last run may have ended inside an access, so clear it */
    if (running_translator && !before) {
        running_translator->access.code_address = 0;
        running_translator->is_instruction_abandoned = false;
    }
    return before;
}

void hil_translator_check_ram_stores(struct hil_translator *translator)
{
    if (translator->has_code_in_ram)
        return;
    translator->has_code_in_ram = true;
    if (translator->cpu_state && library_flush)
        /* flush the buffer: all pages enter it again, now as pages that may contain code */
        library_flush(translator->cpu_state);
}

bool hil_translator_find_instruction(const struct hil_translator *translator, uint32_t address,
                                     struct hil_instruction *place)
{
    /* not possible for an access that may have been split: one of eight bytes, or an unaligned
     * one */
    if (running_translator != translator || !translator->access.code_address ||
        !translator->cpu_state || address - translator->access.address >= 8u || !library_restore ||
        !library_restore_state_to_opc)
        return false;
    found_instruction = place;
    bool found = library_restore(translator->cpu_state, translator->access.code_address, false);
    found_instruction = NULL;
    return found;
}

bool hil_translator_can_leave_code(const struct hil_translator *translator)
{
    return running_translator == translator && translator->access.code_address &&
           translator->cpu_state && library_loop_exit;
}

void hil_translator_leave_code(const struct hil_translator *translator)
{
    library_loop_exit(translator->cpu_state, translator->access.code_address);
    abort(); /* library_loop_exit does not return */
}

/* --- replacements of library functions --- */

bool arm_cpu_tlb_fill_arm(struct CPUState *core, uint64_t address, int size, unsigned access,
                          int mmu_index, bool probe, uintptr_t from)
{
    bool filled = library_tlb_fill(core, address, size, access, mmu_index, probe, from);
    if (!filled || !running_translator)
        return filled;
    running_translator->cpu_state = core;
    /* not for flash, whose stores must be refused on the slow path */
    bool ram = address - HIL_SRAM_BASE < HIL_SRAM_SIZE || address - HIL_CCM_BASE < HIL_CCM_SIZE;
    if (ram && !running_translator->has_code_in_ram && library_set_dirty && library_flush)
        library_set_dirty(core, (uint32_t)address);
    return filled;
}

struct page_collection *page_collection_lock_arm(struct uc_struct *uc, uint64_t start, uint64_t end)
{
    (void)uc;
    (void)start;
    (void)end;
    return 0;
}

void page_collection_unlock_arm(struct page_collection *set)
{
    (void)set;
}

void restore_state_to_opc_arm(struct CPUARMState *state, struct TranslationBlock *block,
                              uint32_t *data)
{
    if (found_instruction)
        *found_instruction = (struct hil_instruction){data[0], data[1]};
    else
        library_restore_state_to_opc(state, block, data);
}

/* Records an access and returns the access in progress: an unaligned access calls this again for
 * each of its parts. */
static struct hil_translated_access begin_translated_access(uint32_t address, uintptr_t from)
{
    struct hil_translated_access outer = {0};
    if (running_translator) {
        outer = running_translator->access;
        running_translator->access = (struct hil_translated_access){address, from};
    }
    return outer;
}

static void end_translated_access(struct hil_translated_access outer)
{
    if (!running_translator)
        return;
    if (running_translator->is_instruction_abandoned && !outer.code_address)
        hil_translator_leave_code(running_translator);
    running_translator->access = outer;
}

#define LOAD(type, name)                                                                  \
    type name(struct CPUARMState *state, uint32_t address, unsigned kind, uintptr_t from) \
    {                                                                                     \
        struct hil_translated_access outer = begin_translated_access(address, from);      \
        type value = library_##name(state, address, kind, from);                          \
        end_translated_access(outer);                                                     \
        return value;                                                                     \
    }
#define STORE(type, name)                                                             \
    void name(struct CPUARMState *state, uint32_t address, type value, unsigned kind, \
              uintptr_t from)                                                         \
    {                                                                                 \
        struct hil_translated_access outer = begin_translated_access(address, from);  \
        library_##name(state, address, value, kind, from);                            \
        end_translated_access(outer);                                                 \
    }
LOADS(LOAD)
STORES(STORE)
