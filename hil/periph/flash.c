#include "hil/periph/flash.h"

#include <string.h>

#include "hil/core/core.h"
#include "hil/core/cpu.h"
#include "hil/core/nvic.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"

#define ACR               0x00u
#define KEYR              0x04u
#define OPTKEYR           0x08u
#define SR                0x0cu
#define CR                0x10u
#define ACR_LATENCY       7u
#define ACR_RESETS        0x1800u /* ICRST, DCRST */
#define ACR_DCEN          0x400u
#define ACR_DCRST         0x1000u
#define KEY1              0x45670123u
#define KEY2              0xcdef89abu
#define OPTKEY1           0x08192a3bu
#define OPTKEY2           0x4c5d6e7fu
#define SR_EOP            (1u << 0)
#define SR_OPERR          (1u << 1)
#define SR_WRPERR         (1u << 4)
#define SR_PGAERR         (1u << 5)
#define SR_PGPERR         (1u << 6)
#define SR_PGSERR         (1u << 7)
#define SR_CLEARABLE      0xf3u
#define SR_BSY            (1u << 16)
#define CR_PG             (1u << 0)
#define CR_SER            (1u << 1)
#define CR_MER            (1u << 2)
#define CR_STRT           (1u << 16)
#define CR_EOPIE          (1u << 24)
#define CR_ERRIE          (1u << 25)
#define CR_LOCK           (1u << 31)
#define OPTCR_LOCK        (1u << 0)
#define OPTCR_STRT        (1u << 1)
#define OPTIONS_FIXED     0x0fff0020u /* nWRP, WDG_SW: fixed at their factory values */
#define OPTCR_OPTION_BITS 0x0fffffecu
#define OPTIONS_ERASED    0x0fffffecu /* protection byte 0xff: level 1 */
#define PROGRAM_ROW_BYTES 16u
#define PSIZE_NEEDS_VPP   3u /* value of PSIZE for x64, which needs VPP */

/* State of an unlocking sequence. */
enum { KEY_STEP_LOCKED, KEY_STEP_ONE_KEY, KEY_STEP_UNLOCKED, KEY_STEP_BLOCKED };

static const uint32_t sector_starts[HIL_FLASH_SECTORS + 1] = {
    0x00000, 0x04000, 0x08000, 0x0c000, 0x10000, 0x20000,  0x40000,
    0x60000, 0x80000, 0xa0000, 0xc0000, 0xe0000, 0x100000,
};

/* DS8626, flash memory programming: typical and maximum by parallelism x8, x16, x32. */
struct operation_times {
    uint32_t typical_us[3], maximum_us[3];
};
static const struct operation_times program_time = {{16, 16, 16}, {100, 100, 100}};
static const struct operation_times erase_16k_time = {{400000, 300000, 250000},
                                                      {800000, 600000, 500000}};
static const struct operation_times erase_64k_time = {{1200000, 700000, 550000},
                                                      {2400000, 1400000, 1100000}};
static const struct operation_times erase_128k_time = {{2000000, 1300000, 1000000},
                                                       {4000000, 2600000, 2000000}};
static const struct operation_times erase_all_time = {{16000000, 11000000, 8000000},
                                                      {32000000, 22000000, 16000000}};

uint32_t hil_flash_sector_start(unsigned sector)
{
    return sector_starts[sector];
}

uint64_t hil_cell_operation_ps(enum hil_cell_times times, uint32_t typical_us, uint32_t maximum_us,
                               uint64_t *random)
{
    /* drawn in every mode, so that later random numbers do not depend on the mode */
    double u = mr_splitmix64_uniform(random);
    if (times != HIL_TIMES_RANDOM)
        return (times == HIL_TIMES_TYPICAL ? typical_us : maximum_us) * 1000000ull;
    u *= u;
    u *= u;
    u *= u;
    return (uint64_t)((typical_us + (maximum_us - typical_us) * u) * 1e6);
}

/* Returns 64 independent bits, each 1 with probability permille / 1000. For each of the ten binary
 * digits of the probability, beginning with the lowest, the result so far is combined with a random
 * word: by OR if the digit is 1, by AND if it is 0. */
static uint64_t draw_biased_bits(unsigned permille, uint64_t *random)
{
    unsigned p = permille * 1024u / 1000u;
    uint64_t bits = 0;
    for (unsigned digit = 0; digit < 10; digit++) {
        uint64_t word = mr_splitmix64(random);
        bits = (p >> digit & 1u) ? bits | word : bits & word;
    }
    return bits;
}

void hil_cells_change_partly(uint8_t *cells, const uint8_t *target, size_t n, unsigned permille,
                             uint64_t *random)
{
    uint64_t changes = 0;
    for (size_t i = 0; i < n; i++) {
        if (i % 8u == 0)
            changes = permille >= 1000 ? UINT64_MAX : draw_biased_bits(permille, random);
        uint8_t mask = (uint8_t)(changes >> (8u * (i % 8u)));
        cells[i] = (uint8_t)((cells[i] & ~mask) | ((target ? target[i] : 0xffu) & mask));
    }
}

static unsigned get_protection_level(uint32_t options)
{
    uint8_t rdp = (uint8_t)(options >> 8);
    return rdp == 0xaa ? 0 : rdp == 0xcc ? 2 : 1;
}

uint32_t hil_flash_option_word(const struct hil_flash_device *dev, unsigned word)
{
    uint32_t options = dev->state->option_bytes;
    uint32_t half = word == 0 ? options & 0xffecu : word == 2 ? options >> 16 & 0xfffu : 0xffffu;
    return word % 2u ? 0xffffffffu : (~half & 0xffffu) << 16 | half;
}

static void update_irq(struct hil_flash_device *dev)
{
    const struct hil_flash *flash = dev->state;
    bool end = (flash->cr & CR_EOPIE) && (flash->sr & SR_EOP);
    bool error = (flash->cr & CR_ERRIE) && (flash->sr & SR_OPERR);
    hil_irq_set_line(dev->core, HIL_IRQ_FLASH, end || error);
}

/* Sets the error flags of a refused request, and counts and reports it. */
static void set_error_flag(struct hil_flash_device *dev, uint32_t error, const char *why,
                           uint32_t address)
{
    struct hil_flash *flash = dev->state;
    flash->sr |= error | (error && (flash->cr & CR_ERRIE) ? SR_OPERR : 0);
    dev->core->state.counters.flash_errors++;
    hil_trace(dev->core, "flash: %s at 0x%08x, SR 0x%x", why, (unsigned)address,
              (unsigned)flash->sr);
    update_irq(dev);
}

static void begin_operation(struct hil_flash_device *dev, enum hil_flash_operation operation,
                            const struct operation_times *duration)
{
    struct hil_flash *flash = dev->state;
    unsigned width = flash->cr >> 8 & 3u;
    uint64_t now_ps = hil_now_ps(dev->core);
    if (width == PSIZE_NEEDS_VPP) {
        hil_bus_refuse(dev->core,
                       "PSIZE x64 needs an external supply on VPP, which this board does not have");
        return;
    }
    flash->operation = operation;
    dev->core->state.bank.is_busy = true;
    dev->core->state.bank.is_erasing = operation > HIL_FLASH_PROGRAM;
    flash->operation_count++;
    flash->begin_ps = now_ps;
    flash->end_ps = now_ps +
                    hil_cell_operation_ps(dev->options->cell_times, duration->typical_us[width],
                                          duration->maximum_us[width], &flash->random_state);
    flash->sr |= SR_BSY;
    hil_event_set_ps(dev->core, HIL_EVENT_FLASH, flash->end_ps);
    hil_callback_invoke(&dev->on_operation_begin);
    hil_core_request_check(dev->core);
}

/* Makes permille / 1000 of the changes of the operation in progress. */
static void change_cells_partly(struct hil_flash_device *dev, unsigned permille)
{
    struct hil_flash *flash = dev->state;
    uint8_t *cells = dev->core->memory->flash + flash->address;
    uint8_t target[4];
    switch (flash->operation) {
    case HIL_FLASH_PROGRAM:
        for (unsigned i = 0; i < flash->size; i++)
            target[i] = (uint8_t)(cells[i] & flash->value >> (8u * i));
        hil_cells_change_partly(cells, target, flash->size, permille, &flash->random_state);
        break;
    case HIL_FLASH_ERASE_SECTOR:
    case HIL_FLASH_ERASE_ALL:
        hil_cells_change_partly(cells, NULL, flash->size, permille, &flash->random_state);
        break;
    case HIL_FLASH_WRITE_OPTIONS:
        /* changing the protection from level 1 to 0 erases everything */
        if (get_protection_level(flash->option_bytes) == 1 &&
            get_protection_level(flash->value) == 0)
            hil_cells_change_partly(dev->core->memory->flash, NULL, HIL_FLASH_SIZE, permille,
                                    &flash->random_state);
        flash->option_bytes = permille >= 1000 ? flash->value : OPTIONS_ERASED;
        break;
    case HIL_FLASH_IDLE: return;
    }
    if (flash->operation == HIL_FLASH_PROGRAM)
        hil_cpu_discard_range(dev->core, HIL_FLASH_BASE + flash->address, flash->size);
    else
        hil_cpu_discard_code(dev->core);
}

static void stop_operation(struct hil_flash_device *dev)
{
    struct hil_flash *flash = dev->state;
    flash->operation = HIL_FLASH_IDLE;
    dev->core->state.bank.is_busy = dev->core->state.bank.is_erasing = false;
    flash->sr &= ~SR_BSY;
    flash->cr &= ~CR_STRT;
    flash->optcr &= ~OPTCR_STRT;
    hil_event_set_ps(dev->core, HIL_EVENT_FLASH, HIL_NEVER);
}

void hil_flash_event(void *device, uint64_t at)
{
    struct hil_flash_device *dev = device;
    struct hil_flash *flash = dev->state;
    (void)at;
    change_cells_partly(dev, 1000);
    for (unsigned i = 0; flash->operation > HIL_FLASH_PROGRAM && i < HIL_FLASH_SECTORS; i++) {
        bool erased = sector_starts[i] - flash->address < flash->size;
        if (erased && (dev->rcc->state->flash_acr & ACR_DCEN) && hil_rules_are_checked(dev->rules))
            dev->core->state.bank.stale_sectors |= (uint16_t)(1u << i);
    }
    stop_operation(dev);
    if (flash->cr & CR_EOPIE)
        flash->sr |= SR_EOP;
    update_irq(dev);
    hil_callback_invoke(&dev->on_bank_ready);
}

/* Stalls the bus until the present operation has ended. */
static void wait_for_operation_end(struct hil_flash_device *dev)
{
    struct hil_clock *clock = &dev->core->state.clock;
    if (!dev->core->state.bank.is_busy)
        return;
    uint64_t end = hil_clock_cycle_at_ps(clock, dev->state->end_ps);
    if (end > clock->now_cycle) {
        dev->core->state.counters.flash_stall_cycles += end - clock->now_cycle;
        clock->now_cycle = end;
    }
    hil_flash_event(dev, end);
}

static unsigned find_sector(uint32_t offset)
{
    unsigned sector = 0;
    while (sector_starts[sector + 1] <= offset)
        sector++;
    return sector;
}

void hil_flash_load(void *device, uint32_t address)
{
    struct hil_flash_device *dev = device;
    struct hil_instruction place = {.pc = dev->core->state.cpu.block_address};
    wait_for_operation_end(dev);
    unsigned sector = find_sector(address % HIL_FLASH_SIZE);
    if (!(dev->core->state.bank.stale_sectors >> sector & 1u))
        return;
    (void)hil_translator_find_instruction(&dev->core->engine.translator, address, &place);
    hil_rules_record_violation(dev->rules, HIL_RULE_STALE_CACHE, place.pc, "sector %u at 0x%08x",
                               sector, (unsigned)address);
}

/* Called when an operation is interrupted: its cells remain partly changed. */
void hil_flash_interrupt_operation(struct hil_flash_device *dev)
{
    const struct hil_flash *flash = dev->state;
    uint64_t now_ps = hil_now_ps(dev->core);
    if (!dev->core->state.bank.is_busy)
        return;
    uint64_t done_ps = now_ps < flash->end_ps ? now_ps - flash->begin_ps
                                              : flash->end_ps - flash->begin_ps;
    unsigned permille = (unsigned)(done_ps * 1000u / (flash->end_ps - flash->begin_ps));
    hil_trace(dev->core,
              "flash: operation %llu was interrupted after %u thousandths of its duration",
              (unsigned long long)flash->operation_count, permille);
    change_cells_partly(dev, permille);
    stop_operation(dev);
}

void hil_flash_create(struct hil_flash_device *dev)
{
    *dev->state = (struct hil_flash){
        .option_bytes = HIL_FLASH_OPTIONS_FACTORY,
        .random_state = dev->options->noise_seed ^ 0xf1a50000f1a5ull,
    };
}

static bool is_boot_rom_selected(const struct hil_flash_device *dev)
{
    return dev->options->is_boot0_high && get_protection_level(dev->state->option_bytes) != 2;
}

void hil_flash_reset(struct hil_flash_device *dev)
{
    struct hil_flash *flash = dev->state;
    /* a reset interrupts the operation (RM0090 3.6: "If a device reset occurs ... the contents are
     * not guaranteed") */
    hil_flash_interrupt_operation(dev);
    flash->sr = 0;
    flash->cr = CR_LOCK;
    flash->optcr = flash->option_bytes | OPTCR_LOCK;
    flash->key_step = flash->option_key_step = KEY_STEP_LOCKED;
    dev->core->state.bank.is_boot_rom_mapped = is_boot_rom_selected(dev);
    dev->core->state.bank.stale_sectors = 0;
    if ((flash->option_bytes & OPTIONS_FIXED) != OPTIONS_FIXED)
        hil_core_stop(dev->core, MR_UNMODELLED,
                      "option bytes 0x%08x turn on the hardware watchdog or write protection, "
                      "which are not modelled",
                      (unsigned)flash->option_bytes);
    update_irq(dev);
}

static void program_cells(struct hil_flash_device *dev, uint32_t offset, unsigned size,
                          uint32_t value)
{
    struct hil_flash *flash = dev->state;
    uint32_t address = HIL_FLASH_BASE + offset;
    wait_for_operation_end(dev); /* a second write stalls the bus until the first has ended */
    if (!(flash->cr & CR_PG)) {
        set_error_flag(dev, SR_PGSERR, "store to flash without CR.PG", address);
    } else if (offset % PROGRAM_ROW_BYTES + size > PROGRAM_ROW_BYTES) {
        set_error_flag(dev, SR_PGAERR, "write across the boundary of a row of 128 bits", address);
    } else if (size != 1u << (flash->cr >> 8 & 3u) || offset % size) {
        set_error_flag(dev, SR_PGPERR, "store of a width other than PSIZE", address);
    } else {
        flash->address = offset;
        flash->value = value;
        flash->size = size;
        begin_operation(dev, HIL_FLASH_PROGRAM, &program_time);
    }
}

void hil_flash_store(void *device, uint32_t address, unsigned size, uint64_t value)
{
    struct hil_flash_device *dev = device;
    uint32_t offset = address < HIL_FLASH_SIZE ? address : address - HIL_FLASH_BASE;
    program_cells(dev, offset, size == 8 ? 4 : size, (uint32_t)value);
    if (size == 8) /* eight bytes are two words on the bus */
        program_cells(dev, offset + 4u, 4, (uint32_t)(value >> 32));
}

static void erase_cells(struct hil_flash_device *dev)
{
    struct hil_flash *flash = dev->state;
    unsigned sector = flash->cr >> 3 & 15u;
    bool all = (flash->cr & CR_MER) != 0;
    if (all == ((flash->cr & CR_SER) != 0)) {
        /* With both bits set, neither operation is performed (3.6.3); with none, there is nothing
         * to start. */
        set_error_flag(dev, 0, "STRT is set while SER and MER are both set or both clear",
                       HIL_FLASH_BASE);
        flash->cr &= ~CR_STRT;
        return;
    }
    if (!all && (sector >= HIL_FLASH_SECTORS ||
                 sector_starts[sector] >= dev->options->type->flash_kib * 1024u)) {
        hil_bus_refuse(dev->core, "sector number beyond the last sector of this flash");
        return;
    }
    flash->address = all ? 0 : sector_starts[sector];
    flash->size = all ? HIL_FLASH_SIZE : sector_starts[sector + 1] - sector_starts[sector];
    begin_operation(dev, all ? HIL_FLASH_ERASE_ALL : HIL_FLASH_ERASE_SECTOR,
                    all           ? &erase_all_time
                    : sector < 4  ? &erase_16k_time
                    : sector == 4 ? &erase_64k_time
                                  : &erase_128k_time);
}

static void write_cr(struct hil_flash_device *dev, uint32_t value)
{
    struct hil_flash *flash = dev->state;
    wait_for_operation_end(dev); /* a write while BSY is set stalls the bus */
    if (flash->cr & CR_LOCK) {
        hil_trace(dev->core, "flash: FLASH_CR is locked, so the value 0x%08x is ignored",
                  (unsigned)value);
        return;
    }
    flash->cr = value;
    if (value & CR_LOCK)
        flash->key_step = KEY_STEP_LOCKED;
    if (value & CR_STRT)
        erase_cells(dev);
    update_irq(dev);
}

static void write_optcr(struct hil_flash_device *dev, uint32_t value)
{
    struct hil_flash *flash = dev->state;
    wait_for_operation_end(dev);
    if (flash->optcr & OPTCR_LOCK) {
        hil_trace(dev->core, "flash: FLASH_OPTCR is locked, so the value 0x%08x is ignored",
                  (unsigned)value);
        return;
    }
    flash->optcr = value & (OPTCR_OPTION_BITS | OPTCR_LOCK);
    if (value & OPTCR_LOCK)
        flash->option_key_step = KEY_STEP_LOCKED;
    if (!(value & OPTCR_STRT))
        return;
    if (get_protection_level(flash->option_bytes) == 2) { /* level 2 is permanent (3.7.3) */
        set_error_flag(dev, SR_WRPERR, "change of the option bytes at protection level 2",
                       0x1fffc000u);
        return;
    }
    if ((value & OPTIONS_FIXED) != OPTIONS_FIXED) {
        hil_bus_refuse(dev->core, "write protection and hardware watchdog by option bytes");
        return;
    }
    bool regression = get_protection_level(flash->option_bytes) == 1 &&
                      get_protection_level(value) == 0;
    flash->value = value & OPTCR_OPTION_BITS;
    flash->optcr |= OPTCR_STRT;
    /* The data sheet gives no time for option bytes, so the time of a 16 KiB sector is used. */
    begin_operation(dev, HIL_FLASH_WRITE_OPTIONS, regression ? &erase_all_time : &erase_16k_time);
}

/* Checks one key of a sequence. Returns true if the register is now unlocked. A wrong key locks it
 * until the next reset. */
static bool check_unlock_key(struct hil_flash_device *dev, uint8_t *step, uint32_t value,
                             uint32_t first, uint32_t second)
{
    if (*step == KEY_STEP_UNLOCKED || *step == KEY_STEP_BLOCKED)
        return false;
    if (value == (*step == KEY_STEP_LOCKED ? first : second)) {
        ++*step;
        return *step == KEY_STEP_UNLOCKED;
    }
    hil_trace(dev->core, "flash: wrong key 0x%08x; the register is locked until a reset",
              (unsigned)value);
    dev->core->state.counters.flash_errors++;
    *step = KEY_STEP_BLOCKED;
    return false;
}

static void write_acr(struct hil_flash_device *dev, uint32_t value)
{
    struct hil_rcc *rcc = dev->rcc->state;
    if ((value & ACR_DCRST) && ((rcc->flash_acr | value) & ACR_DCEN))
        hil_bus_refuse(dev->core, "DCRST is set while the cache is on, so the chip ignores DCRST");
    else if (value & ACR_DCRST)
        dev->core->state.bank.stale_sectors = 0;
    rcc->is_latency_unread |= (value & ACR_LATENCY) > (rcc->flash_acr & ACR_LATENCY);
    rcc->flash_acr = value & ~ACR_RESETS;
    if (dev->core->state.clock.hclk_hz / 100u * 98u > hil_rcc_max_hclk_hz(rcc))
        hil_core_stop(dev->core, MR_HALTED,
                      "FLASH_ACR 0x%x has too few wait states for HCLK at %u Hz, PC 0x%08x",
                      (unsigned)value, (unsigned)dev->core->state.clock.hclk_hz,
                      (unsigned)hil_access_pc(dev->core));
}

uint32_t hil_flash_if_read(void *device, unsigned unit, uint32_t offset)
{
    const struct hil_flash_device *dev = device;
    (void)unit;
    if (offset == ACR)
        dev->rcc->state->is_latency_unread = false;
    return offset == ACR ? dev->rcc->state->flash_acr : dev->state->word[offset / 4u];
}

void hil_flash_if_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_flash_device *dev = device;
    struct hil_flash *flash = dev->state;
    (void)unit;
    switch (offset) {
    case ACR: write_acr(dev, value); break;
    case KEYR:
        if (check_unlock_key(dev, &flash->key_step, value, KEY1, KEY2))
            flash->cr &= ~CR_LOCK;
        break;
    case OPTKEYR:
        if (check_unlock_key(dev, &flash->option_key_step, value, OPTKEY1, OPTKEY2))
            flash->optcr &= ~OPTCR_LOCK;
        break;
    case SR:
        flash->sr &= ~(value & SR_CLEARABLE);
        update_irq(dev);
        break;
    case CR: write_cr(dev, value); break;
    default: write_optcr(dev, value); break;
    }
}

/* ---- syscfg ---- */

/* Memory at address 0 (RM0090 9.2.1): the boot pins select it at reset, SYSCFG_MEMRMP
 * afterwards. */

#define MEMRMP_SYSTEM_MEMORY 1u

void hil_syscfg_reset(void *device, unsigned unit)
{
    const struct hil_flash_device *dev = device;
    hil_syscfg_write(device, unit, 0, is_boot_rom_selected(dev));
}

uint32_t hil_syscfg_read(void *device, unsigned unit, uint32_t offset)
{
    const struct hil_flash_device *dev = device;
    (void)unit, (void)offset;
    return dev->core->state.bank.is_boot_rom_mapped ? MEMRMP_SYSTEM_MEMORY : 0;
}

void hil_syscfg_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    const struct hil_flash_device *dev = device;
    (void)unit, (void)offset;
    dev->core->state.bank.is_boot_rom_mapped = (value & MEMRMP_SYSTEM_MEMORY) != 0;
    hil_cpu_map_boot_memory(dev->core);
}
