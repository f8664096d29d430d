/* A third of the time of a run, given back.
 *
 * At each store to RAM, Unicorn 2.0.1 (Debian 12) builds a tree of page locks and throws it away, although the
 * locks do nothing: one thread runs it. Its next version returns NULL there instead (its pull request 1838), and
 * so do the first two. Then it looks for translated code to forget under the store; there is none as long as
 * nothing has run from RAM, and the third does not look before.
 *
 * They have the names of exported functions of the library, whose own calls come here first; a later version
 * that no longer makes these calls is served no worse. */
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdint.h>

#include "hil/cpu.h"

struct page_collection;
struct uc_struct;
typedef void invalidate(struct uc_struct *uc, struct page_collection *pages, uint64_t start, int length,
                        uintptr_t from);

struct page_collection *page_collection_lock_arm(struct uc_struct *uc, uint64_t start, uint64_t end);
void page_collection_unlock_arm(struct page_collection *set);
invalidate tb_invalidate_phys_page_fast_arm;

static atomic_bool code_in_ram; /* of any board of this process, for good */
static invalidate *forget_code_under;

void hil_cpu_expect_no_code_in_ram(void)
{
    if (!forget_code_under)
        *(void **)&forget_code_under = dlsym(RTLD_NEXT, "tb_invalidate_phys_page_fast_arm");
}

void hil_cpu_code_in_ram(void) { atomic_store_explicit(&code_in_ram, true, memory_order_relaxed); }

struct page_collection *page_collection_lock_arm(struct uc_struct *uc, uint64_t start, uint64_t end)
{
    (void)uc;
    (void)start;
    (void)end;
    return 0;
}

void page_collection_unlock_arm(struct page_collection *set) { (void)set; }

void tb_invalidate_phys_page_fast_arm(struct uc_struct *uc, struct page_collection *pages, uint64_t start, int length,
                                      uintptr_t from)
{
    if (atomic_load_explicit(&code_in_ram, memory_order_relaxed))
        forget_code_under(uc, pages, start, length, from);
}
