/* Half of the time of a run, given back.
 *
 * Unicorn 2.0.1 (Debian 12) sends every store to RAM through its slow path, to look for translated
 * code that the store changes; it never notices that a page has none, as QEMU does, and later
 * versions do (its pull requests 1838, 2031). Here pages of RAM are told to be free of code
 * (`tlb_set_dirty`) when they come into its translation buffer, until the board first runs code
 * from RAM; from then on every store of that board is looked at again. And the locks around that
 * look, which build a tree for each store and lock nothing in a single thread, are left out, as in
 * the next version.
 *
 * The functions have the names of exported ones of the library, whose own uses of them come here
 * first. A version without them is served no worse: then nobody calls these. */
#include <dlfcn.h>
#include <stdint.h>

#include "hil/core/stores.h"
#include "hil/core/state.h"

struct CPUState;
struct page_collection;
struct uc_struct;
typedef bool fill(struct CPUState *core, uint64_t address, int size, unsigned access, int mmu_index,
                  bool probe, uintptr_t from);
typedef void set_dirty(struct CPUState *core, uint32_t address);
typedef void flush(struct CPUState *core);

struct page_collection *page_collection_lock_arm(struct uc_struct *uc, uint64_t start,
                                                 uint64_t end);
void page_collection_unlock_arm(struct page_collection *set);
fill arm_cpu_tlb_fill_arm;

static fill *library_fill;
static set_dirty *library_set_dirty;
static flush *library_flush;
static _Thread_local struct hil_stores *running; /* of the board that this thread runs */

void hil_stores_start(struct hil_stores *stores)
{
    *stores = (struct hil_stores){0};
    *(void **)&library_fill = dlsym(RTLD_NEXT, "arm_cpu_tlb_fill_arm");
    *(void **)&library_set_dirty = dlsym(RTLD_NEXT, "tlb_set_dirty_arm");
    *(void **)&library_flush = dlsym(RTLD_NEXT, "tlb_flush_arm");
}

void hil_stores_run(struct hil_stores *stores)
{
    running = stores;
}

void hil_stores_meet_code(struct hil_stores *stores)
{
    if (stores->code_in_ram)
        return;
    stores->code_in_ram = true;
    if (stores->core && library_flush)
        library_flush(stores->core); /* every page comes again, now as one that may have code */
}

bool arm_cpu_tlb_fill_arm(struct CPUState *core, uint64_t address, int size, unsigned access,
                          int mmu_index, bool probe, uintptr_t from)
{
    bool filled = library_fill(core, address, size, access, mmu_index, probe, from);
    if (!filled || !running)
        return filled;
    running->core = core;
    /* Flash stays on the slow path: there stores are refused. */
    bool ram = address - HIL_SRAM_BASE < HIL_SRAM_SIZE || address - HIL_CCM_BASE < HIL_CCM_SIZE;
    if (ram && !running->code_in_ram && library_set_dirty && library_flush)
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
