#include "hil/core/registers.h"

/* clang-format off */
#define ROW(loose, access, offset, count, stride, name, reset, plain, action, status, partly, \
    refused, what)                                                                            \
    {offset, count, stride, access, loose, #name, reset, plain, action, status, partly, refused, \
     what},
#define REG(access, offset, count, stride, name, ...) \
    ROW(false, access, offset, count, stride, name, __VA_ARGS__)
#define LOOSE(access, offset, count, stride, name, ...) \
    ROW(true, access, offset, count, stride, name, __VA_ARGS__)
#define SET(name, peripheral, base) {peripheral, base, (const struct hil_register[]){
#define END(set)                    {.name = NULL}}},
static const struct hil_register_set sets[] = {
#include "hil/core/registers.def"
};
/* clang-format on */
#define SETS (sizeof sets / sizeof sets[0])

const struct hil_register_set *hil_registers_all(size_t *count)
{
    *count = SETS;
    return sets;
}

const struct hil_register_set *hil_registers_of(uint32_t base)
{
    for (size_t i = 0; i < SETS; i++) {
        if (sets[i].base == base)
            return &sets[i];
    }
    return NULL;
}

const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset)
{
    for (const struct hil_register *r = set->all; r->name; r++) {
        uint32_t from = offset - r->offset;
        if (offset >= r->offset && from % r->stride == 0 && from / r->stride < r->count)
            return r;
    }
    return NULL;
}

const char *hil_register_objection(const struct hil_register *r, uint32_t value)
{
    uint32_t changed = value ^ r->reset;
    if (r->access == 'r')
        return "the register is read-only: silicon ignores the write";
    if (changed & r->refused)
        return r->what;
    if (!r->loose && (changed & ~(r->plain | r->action | r->status | r->partly)))
        return "a reserved bit is changed: it must be kept at its reset value";
    return NULL;
}

void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct hil_register *r = hil_register_at(hil_registers_of(base),
                                                       offset + 4u * (uint32_t)i);
        word[i] = r ? r->reset : 0;
    }
}
