#include "hil/core/map.h"

#include <unicorn/unicorn.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/engine.h"

/* Memory that stores do not change. Only a later change of its protection makes Unicorn discard a
 * store that the memory hook has taken; as mapped, it would carry it out. */
static void map_read_only(struct hil_core *core, uint32_t base, uint32_t size, const uint8_t *bytes,
                          bool readable)
{
    uint32_t protection = readable ? UC_PROT_READ | UC_PROT_EXEC : UC_PROT_EXEC;
    hil_must(
        uc_mem_map_ptr(core->uc, base, size, protection | UC_PROT_WRITE, (void *)(uintptr_t)bytes),
        "mapping flash or ROM");
    hil_must(uc_mem_protect(core->uc, base, size, protection), "protecting flash or ROM");
}

/* What is at address 0: flash, or after BOOT0 the ROM. */
static void map_zero(struct hil_core *core, bool rom, bool readable)
{
    core->engine.rom_at_zero = rom;
    if (rom)
        map_read_only(core, 0, HIL_ROM_SIZE, hil_bootrom_image, true);
    else
        map_read_only(core, 0, HIL_FLASH_SIZE, core->memory->flash, readable);
}

static void unmap_zero(struct hil_core *core)
{
    hil_must(uc_mem_unmap(core->uc, 0, core->engine.rom_at_zero ? HIL_ROM_SIZE : HIL_FLASH_SIZE),
             "unmapping address 0");
}

/* While an erase runs beside code in RAM, reads of flash must be caught, for they wait. Mapping
 * anew is the one way that empties the core's address cache; it takes too long (a millisecond) to
 * do it for single words. */
void hil_map_guard_flash(struct hil_core *core, bool guarded)
{
    if (core->engine.flash_guarded == guarded)
        return;
    core->engine.flash_guarded = guarded;
    unmap_zero(core);
    hil_must(uc_mem_unmap(core->uc, HIL_FLASH_BASE, HIL_FLASH_SIZE), "unmapping flash");
    map_zero(core, core->engine.rom_at_zero, !guarded);
    map_read_only(core, HIL_FLASH_BASE, HIL_FLASH_SIZE, core->memory->flash, !guarded);
}

/* Make address 0 what the state says. */
void hil_map_follow_boot_pin(struct hil_core *core)
{
    if (core->engine.rom_at_zero == core->state.bank.boot_rom)
        return;
    unmap_zero(core);
    map_zero(core, core->state.bank.boot_rom, !core->engine.flash_guarded);
}

bool hil_map_is_flash(const struct hil_core *core, uint32_t address)
{
    return address - HIL_FLASH_BASE < HIL_FLASH_SIZE ||
           (address < HIL_FLASH_SIZE && !core->engine.rom_at_zero);
}

static bool on_invalid_memory(uc_engine *uc, uc_mem_type type, uint64_t address, int size,
                              int64_t value, void *user)
{
    struct hil_core *core = user;
    (void)uc;
    if (type == UC_MEM_WRITE_PROT && hil_map_is_flash(core, (uint32_t)address)) {
        /* the memory itself does not change now */
        if (core->engine.split_bytes) {
            core->engine.split_bytes--;
            return true;
        }
        core->bank.store(core->bank.who, (uint32_t)address, (unsigned)size, (uint64_t)value);
        if (address % (unsigned)size) /* Unicorn comes again with each byte */
            core->engine.split_bytes = (unsigned)size;
        return true;
    }
    if (type == UC_MEM_READ_PROT && core->engine.flash_guarded &&
        hil_map_is_flash(core, (uint32_t)address)) {
        core->bank.wait(core->bank.who);
        return true;
    }
    core->engine.bad_address = (uint32_t)address;
    core->engine.bad_size = (uint32_t)size;
    return false;
}

static void issue(const struct hil_region *region, uint64_t offset)
{
    region->core->bus.issued = region->base + (uint32_t)offset;
    region->core->bus.issues++;
}

static uint64_t on_mmio_read(uc_engine *uc, uint64_t offset, unsigned size, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    issue(region, offset);
    return hil_bus_read(region->core, region->base + (uint32_t)offset, size);
}

static void on_mmio_write(uc_engine *uc, uint64_t offset, unsigned size, uint64_t value, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    issue(region, offset);
    hil_bus_write(region->core, region->base + (uint32_t)offset, size, (uint32_t)value);
    const struct hil_onlookers *lookers = &region->core->onlookers;
    if (lookers->tracer)
        lookers->tracer->sample(lookers->tracer_who, hil_now(region->core));
}

void hil_map_create(struct hil_core *core)
{
    /* Address ranges that answer to loads and stores but are no memory (RM0090 2.3, ARMv7-M
     * B3.1). What lies between the option bytes and SRAM is reserved: a bus fault, which is what a
     * stack that overflows meets. */
    static const struct {
        uint32_t base, size;
    } ranges[HIL_REGIONS] = {
        {0x1fff7000u, 0x00006000u}, /* above the boot ROM: OTP, unique id, option bytes */
        {0x22000000u, 0x02000000u}, /* SRAM bit-band alias */
        {0x40000000u, 0x02000000u}, /* APB1, APB2, AHB1 */
        {0x42000000u, 0x02000000u}, /* their bit-band alias */
        {0x50000000u, 0x10000000u}, /* AHB2 */
        {0xa0000000u, 0x00001000u}, /* FSMC registers */
        {0xe0000000u, 0x00100000u}, /* private peripheral bus */
    };
    map_zero(core, false, true);
    map_read_only(core, HIL_FLASH_BASE, HIL_FLASH_SIZE, core->memory->flash, true);
    map_read_only(core, HIL_ROM_BASE, HIL_ROM_SIZE, hil_bootrom_image, true);
    hil_must(
        uc_mem_map_ptr(core->uc, HIL_SRAM_BASE, HIL_SRAM_SIZE, UC_PROT_ALL, core->memory->sram),
        "mapping SRAM");
    if (!core->no_ccm)
        hil_must(uc_mem_map_ptr(core->uc, HIL_CCM_BASE, HIL_CCM_SIZE, UC_PROT_READ | UC_PROT_WRITE,
                                core->memory->ccm),
                 "mapping CCM");
    for (unsigned i = 0; i < HIL_REGIONS; i++) {
        core->engine.regions[i] = (struct hil_region){core, ranges[i].base};
        hil_must(uc_mmio_map(core->uc, ranges[i].base, ranges[i].size, on_mmio_read,
                             &core->engine.regions[i], on_mmio_write, &core->engine.regions[i]),
                 "mapping peripherals");
    }
    uc_hook hook;
    hil_must(uc_hook_add(core->uc, &hook, UC_HOOK_MEM_INVALID, (void *)(uintptr_t)on_invalid_memory,
                         core, 1, 0),
             "memory hook");
}
