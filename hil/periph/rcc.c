#include "hil/periph/rcc.h"

#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"

#define HSE_START_PS (2ull * HIL_PS_PER_MS)
#define PLL_LOCK_PS  (200ull * HIL_PS_PER_US)
#define LSI_START_PS (40ull * HIL_PS_PER_US)
#define HSI_HZ       16000000u

#define RCC_BASE        0x40023800u
#define CR              0x00u
#define PLLCFGR         0x04u
#define CFGR            0x08u
#define CIR             0x0cu
#define AHB1RSTR        0x10u
#define AHB1ENR         0x30u
#define APB1ENR         0x40u
#define APB2ENR         0x44u
#define APB1RSTR        0x20u
#define APB2RSTR        0x24u
#define CSR             0x74u
#define CR_HSION        (1u << 0)
#define CR_HSIRDY       (1u << 1)
#define CR_HSEON        (1u << 16)
#define CR_HSERDY       (1u << 17)
#define CR_HSEBYP       (1u << 18)
#define CR_CSSON        (1u << 19)
#define CIR_CSSF        0x80u
#define CR_PLLON        (1u << 24)
#define CR_PLLRDY       (1u << 25)
#define CR_WRITABLE     0x010d00f9u
#define PLLCFGR_SRC_HSE (1u << 22)
#define CFGR_SWS        0x0000000cu
#define CSR_LSION       1u
#define CSR_LSIRDY      2u
#define CSR_RMVF        (1u << 24)
#define CSR_FLAGS       0xfe000000u

enum { SOURCE_HSI, SOURCE_HSE, SOURCE_PLL };

void hil_rcc_reset(struct hil_rcc_device *dev, uint32_t csr_flags)
{
    struct hil_rcc *rcc = dev->state;
    dev->core->state.clock.is_stopped = false;
    uint32_t flags = (rcc->csr & CSR_FLAGS) | csr_flags;
    *rcc = (struct hil_rcc){.pwr_cr = 1u << 14, .has_crystal_failed = rcc->has_crystal_failed};
    hil_registers_reset(RCC_BASE, 0, rcc->word, sizeof rcc->word / 4u);
    rcc->csr = flags;
    hil_nvic_set_line(dev->core, HIL_EXC_NMI, false);
    hil_event_set_ps(dev->core, HIL_EVENT_HSE, HIL_NEVER);
    hil_event_set_ps(dev->core, HIL_EVENT_PLL, HIL_NEVER);
    hil_event_set_ps(dev->core, HIL_EVENT_LSI, HIL_NEVER);
    hil_core_set_hclk(dev->core,
                      (uint32_t)(HSI_HZ + (int64_t)HSI_HZ * dev->options->hsi_error_ppm / 1000000));
}

const uint32_t *hil_rcc_clock_enables(const struct hil_rcc_device *dev, enum hil_rcc_bus bus)
{
    const struct hil_rcc *rcc = dev->state;
    return bus == HIL_RCC_AHB1 ? &rcc->ahb1enr
         : bus == HIL_RCC_APB1 ? &rcc->apb1enr
                               : &rcc->apb2enr;
}

bool hil_rcc_is_clock_on(const struct hil_rcc_device *dev, enum hil_rcc_bus bus, unsigned bit)
{
    return (*hil_rcc_clock_enables(dev, bus) >> bit & 1u) != 0;
}

uint32_t hil_rcc_pclk_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus)
{
    uint32_t ppre = dev->state->cfgr >> (bus == HIL_RCC_APB1 ? 10 : 13) & 7u;
    return (ppre & 4u) ? 2u << (ppre & 3u) : 1u;
}

/* If PCLK is divided, timers run at twice PCLK. */
uint32_t hil_rcc_timer_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus)
{
    uint32_t divider = hil_rcc_pclk_divider(dev, bus);
    return divider == 1 ? 1 : divider / 2;
}

static uint32_t get_hpre_divider(uint32_t hpre)
{
    static const uint16_t by[8] = {2, 4, 8, 16, 64, 128, 256, 512};
    return (hpre & 8u) ? by[hpre & 7u] : 1u;
}

static void halt_on_clock_setting(struct hil_rcc_device *dev, const char *what)
{
    hil_core_stop(dev->core, MR_HALTED,
                  "clock setting that the chip does not support: %s (RCC_CR 0x%08x, PLLCFGR "
                  "0x%08x, CFGR 0x%08x)",
                  what, (unsigned)dev->state->cr, (unsigned)dev->state->pllcfgr,
                  (unsigned)dev->state->cfgr);
}

/* Returns the output frequency of the PLL for a source frequency. Stops the run if it is outside
 * the limits of the data sheet. */
static uint32_t compute_pll_hz(struct hil_rcc_device *dev, uint32_t source_hz)
{
    uint32_t cfg = dev->state->pllcfgr;
    uint32_t m = cfg & 0x3fu, n = cfg >> 6 & 0x1ffu, p = 2u * ((cfg >> 16 & 3u) + 1u);
    if (m < 2 || n < 50 || n > 432) {
        halt_on_clock_setting(dev, "PLL factor M or N is not allowed");
        return HSI_HZ;
    }
    uint64_t vco = (uint64_t)source_hz * n / m;
    if (source_hz / m < 950000u || source_hz / m > 2100000u)
        halt_on_clock_setting(dev, "the PLL input must have 1 to 2 MHz");
    if (vco < 100000000u || vco > 436000000u)
        halt_on_clock_setting(dev, "the VCO must have 100 to 432 MHz");
    return (uint32_t)(vco / p);
}

/* Returns the frequency of HCLK from CR, PLLCFGR and CFGR.SWS: the true or (`nominal`) the nominal
 * one, without the error of the HSI. */
static uint32_t compute_hclk_hz(struct hil_rcc_device *dev, bool nominal)
{
    struct hil_rcc *rcc = dev->state;
    int64_t error = nominal ? 0 : (int64_t)HSI_HZ * dev->options->hsi_error_ppm / 1000000;
    uint32_t hsi = (uint32_t)(HSI_HZ + error);
    uint32_t hz = hsi;
    switch (rcc->cfgr >> 2 & 3u) {
    case SOURCE_HSE: hz = dev->options->hse_hz; break;
    case SOURCE_PLL:
        hz = compute_pll_hz(dev, (rcc->pllcfgr & PLLCFGR_SRC_HSE) ? dev->options->hse_hz : hsi);
        break;
    default: break;
    }
    return hz / get_hpre_divider(rcc->cfgr >> 4 & 15u);
}

static void check_clock_limits(struct hil_rcc_device *dev)
{
    uint32_t nominal = compute_hclk_hz(dev, true);
    if (nominal > hil_rcc_max_hclk_hz(dev->state))
        halt_on_clock_setting(dev,
                              "HCLK exceeds the limit that FLASH_ACR.LATENCY and PWR_CR.VOS set");
    if (nominal / hil_rcc_pclk_divider(dev, HIL_RCC_APB1) > 42000000u)
        halt_on_clock_setting(dev, "PCLK1 above 42 MHz");
    if (nominal / hil_rcc_pclk_divider(dev, HIL_RCC_APB2) > 84000000u)
        halt_on_clock_setting(dev, "PCLK2 above 84 MHz");
    hil_core_set_hclk(dev->core, compute_hclk_hz(dev, false));
}

void hil_rcc_leave_clocks_on(struct hil_rcc_device *dev)
{
    struct hil_rcc *rcc = dev->state;
    rcc->cr |= CR_HSEON | CR_HSERDY | CR_PLLON | CR_PLLRDY;
    rcc->pllcfgr = 2u << 28 | 7u << 24 | PLLCFGR_SRC_HSE | 168u << 6 | 4u;
    rcc->cfgr = 4u << 13 | 5u << 10 | SOURCE_PLL << 2 | SOURCE_PLL;
    rcc->ahb1enr |= 0x1ffu;
    rcc->apb1enr |= 0x1ffu;
    rcc->flash_acr |= 5u;
    check_clock_limits(dev);
}

/* Switches to the clock source that SW requests; SWS shows it as soon as the source is ready. */
static void switch_hclk_source(struct hil_rcc_device *dev)
{
    static const uint32_t ready[3] = {CR_HSIRDY, CR_HSERDY, CR_PLLRDY};
    struct hil_rcc *rcc = dev->state;
    uint32_t wanted = rcc->cfgr & 3u;
    if (wanted < 3 && (rcc->cr & ready[wanted]))
        rcc->cfgr = (rcc->cfgr & ~CFGR_SWS) | wanted << 2;
    check_clock_limits(dev);
}

static bool is_hclk_from_crystal(const struct hil_rcc *rcc)
{
    uint32_t source = rcc->cfgr >> 2 & 3u;
    return source == SOURCE_HSE || (source == SOURCE_PLL && (rcc->pllcfgr & PLLCFGR_SRC_HSE));
}

/* Clock security system: switches to HSI before the core misses a clock edge. */
static void switch_to_hsi(struct hil_rcc_device *dev)
{
    struct hil_rcc *rcc = dev->state;
    bool feeds = is_hclk_from_crystal(rcc);
    rcc->cr &= ~(CR_HSEON | CR_CSSON);
    rcc->cir |= CIR_CSSF;
    if (feeds) {
        rcc->cr = (rcc->cr | CR_HSION | CR_HSIRDY) & ~(CR_PLLON | CR_PLLRDY);
        rcc->cfgr &= ~(CFGR_SWS | 3u);
        hil_event_set_ps(dev->core, HIL_EVENT_PLL, HIL_NEVER);
        check_clock_limits(dev);
    }
    hil_nvic_set_line(dev->core, HIL_EXC_NMI, true);
}

/* True if the HSE runs. A crystal needs the oscillator, an external clock needs the bypass; other
 * combinations are not reliable (RM0090 7.2.1). */
static bool is_hse_running(const struct hil_rcc_device *dev)
{
    bool bypassed = (dev->state->cr & CR_HSEBYP) != 0;
    return dev->options->hse_hz && !dev->state->has_crystal_failed &&
           bypassed == dev->options->type->has_clock_bypass;
}

void hil_rcc_set_crystal(struct hil_rcc_device *dev, bool on)
{
    struct hil_rcc *rcc = dev->state;
    rcc->has_crystal_failed = !on;
    if (on) {
        if ((rcc->cr & CR_HSEON) && !(rcc->cr & CR_HSERDY) && is_hse_running(dev))
            hil_event_set_ps(dev->core, HIL_EVENT_HSE, hil_now_ps(dev->core) + HSE_START_PS);
        return;
    }
    hil_event_set_ps(dev->core, HIL_EVENT_HSE, HIL_NEVER);
    if (!(rcc->cr & CR_HSERDY))
        return;
    rcc->cr &= ~CR_HSERDY;
    if (rcc->cr & CR_CSSON) {
        switch_to_hsi(dev);
    } else if (is_hclk_from_crystal(rcc)) {
        dev->core->state.clock.is_stopped = true;
        hil_trace(dev->core, "no clock");
        hil_core_request_check(dev->core);
    }
}

void hil_rcc_hse_event(void *device, uint64_t at)
{
    struct hil_rcc_device *dev = device;
    (void)at;
    dev->state->cr |= CR_HSERDY;
    dev->core->state.clock.is_stopped = false;
    switch_hclk_source(dev);
}

void hil_rcc_pll_event(void *device, uint64_t at)
{
    struct hil_rcc_device *dev = device;
    (void)at;
    dev->state->cr |= CR_PLLRDY;
    switch_hclk_source(dev);
}

void hil_rcc_lsi_event(void *device, uint64_t at)
{
    struct hil_rcc_device *dev = device;
    (void)at;
    dev->state->csr |= CSR_LSIRDY;
}

static void start_lsi(struct hil_rcc_device *dev)
{
    dev->state->csr |= CSR_LSION;
    if (!(dev->state->csr & CSR_LSIRDY))
        hil_event_set_ps(dev->core, HIL_EVENT_LSI, hil_now_ps(dev->core) + LSI_START_PS);
}

static void write_cr(struct hil_rcc_device *dev, uint32_t value)
{
    struct hil_rcc *rcc = dev->state;
    uint64_t now_ps = hil_now_ps(dev->core);
    uint32_t source = rcc->cfgr >> 2 & 3u;
    uint32_t keep = source == SOURCE_HSI ? CR_HSION : source == SOURCE_HSE ? CR_HSEON : CR_PLLON;
    if (source == SOURCE_PLL)
        keep |= (rcc->pllcfgr & PLLCFGR_SRC_HSE) ? CR_HSEON : CR_HSION;
    uint32_t before = rcc->cr;
    /* keep the enable bit of a clock that is in use: it cannot be switched off */
    uint32_t after = (before & ~CR_WRITABLE) | (value & CR_WRITABLE) | keep;
    uint32_t rising = after & ~before;
    if (rising & CR_HSION)
        after |= CR_HSIRDY;
    if (!(after & CR_HSION))
        after &= ~CR_HSIRDY;
    rcc->cr = after;
    if ((rising & CR_HSEON) && is_hse_running(dev))
        hil_event_set_ps(dev->core, HIL_EVENT_HSE, now_ps + HSE_START_PS);
    if (!(after & CR_HSEON)) {
        rcc->cr &= ~CR_HSERDY;
        hil_event_set_ps(dev->core, HIL_EVENT_HSE, HIL_NEVER);
    }
    if (rising & CR_PLLON) {
        bool fed = (rcc->pllcfgr & PLLCFGR_SRC_HSE) ? (rcc->cr & CR_HSERDY) != 0
                                                    : (rcc->cr & CR_HSIRDY) != 0;
        if (fed)
            hil_event_set_ps(dev->core, HIL_EVENT_PLL, now_ps + PLL_LOCK_PS);
    }
    if (!(after & CR_PLLON)) {
        rcc->cr &= ~CR_PLLRDY;
        hil_event_set_ps(dev->core, HIL_EVENT_PLL, HIL_NEVER);
    }
}

static void write_cir(struct hil_rcc_device *dev, uint32_t value)
{
    dev->state->cir &= ~(value >> 16 & CIR_CSSF);
    hil_nvic_set_line(dev->core, HIL_EXC_NMI, (dev->state->cir & CIR_CSSF) != 0);
}

/* --- rules of the microcontroller --- */

static bool is_dsb_opcode(const uint8_t *code)
{
    return code[0] == 0xbf && code[1] == 0xf3 && (code[2] & 0xf0u) == 0x40u && code[3] == 0x8f;
}

/* True if there is a DSB between two instructions, which is one of the workarounds in the errata
 * sheet. */
static bool has_barrier_between(const struct hil_core *core, uint32_t from, uint32_t to)
{
    const uint8_t *code = hil_memory_at(core, from, to - from, false);
    for (uint32_t i = 0; code && i + 4 <= to - from; i += 2) {
        if (is_dsb_opcode(code + i))
            return true;
    }
    return false;
}

/* Checks accesses only within the block that enabled the clock, because the branch at its end takes
 * enough cycles. (With APB at a quarter of HCLK it may not; such cases are not detected.) */
static void check_new_clock_access(void *context)
{
    struct hil_rcc_device *dev = context;
    const struct hil_rcc_new_clock fresh = dev->new_clock;
    dev->core->bus.new_clocks.clock_enables = NULL;
    if (fresh.block_cycle != hil_now_cycle(dev->core))
        return;
    struct hil_timestamp access = hil_access_timestamp(dev->core);
    unsigned between = hil_count_instructions(dev->core, fresh.store_pc, access.pc);
    if (!between || between > fresh.required_cycles ||
        has_barrier_between(dev->core, fresh.store_pc, access.pc))
        hil_rules_record_pass(dev->rules, HIL_RULE_CLOCK_ENABLE);
    else
        hil_rules_record_violation(dev->rules, HIL_RULE_CLOCK_ENABLE, access.pc,
                                   "first access only %u instructions after the store at 0x%08x; "
                                   "required: %u cycles, a read-back or a DSB in between",
                                   between - 1u, (unsigned)fresh.store_pc, fresh.required_cycles);
}

/* Records clocks that were just enabled. A peripheral responds two AHB cycles after its clock is
 * enabled; on APB, 1 + the prescaler. */
static void record_new_clock(struct hil_rcc_device *dev, uint32_t offset, uint32_t rising)
{
    struct hil_timestamp at = hil_access_timestamp(dev->core);
    if (!rising || !hil_rules_are_checked(dev->rules))
        return;
    dev->new_clock = (struct hil_rcc_new_clock){
        .store_pc = at.pc,
        .block_cycle = hil_now_cycle(dev->core),
        .required_cycles = offset == AHB1ENR ? 2u
                         : offset == APB1ENR ? 1u + hil_rcc_pclk_divider(dev, HIL_RCC_APB1)
                                             : 1u + hil_rcc_pclk_divider(dev, HIL_RCC_APB2),
    };
    dev->core->bus.new_clocks = (struct hil_new_clocks){
        .clock_enables = &dev->state->word[offset / 4u],
        .clock_mask = rising,
        .on_first_access = check_new_clock_access,
        .context = dev,
    };
}

/* Checks that the firmware has read back new wait states before HCLK rises. */
static void check_wait_states(struct hil_rcc_device *dev, uint32_t before_hz)
{
    struct hil_rcc *rcc = dev->state;
    if (compute_hclk_hz(dev, true) <= before_hz || !hil_rules_are_checked(dev->rules))
        return;
    if (rcc->is_latency_unread)
        hil_rules_record_violation(
            dev->rules, HIL_RULE_WAIT_STATES, hil_access_timestamp(dev->core).pc,
            "HCLK rises from %u to %u Hz, but FLASH_ACR was not read back after the write",
            (unsigned)before_hz, (unsigned)compute_hclk_hz(dev, true));
    else
        hil_rules_record_pass(dev->rules, HIL_RULE_WAIT_STATES);
}

uint32_t hil_rcc_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_rcc_device *dev = device;
    (void)unit;
    if (dev->core->bus.new_clocks.clock_enables ==
        /* reading back is another workaround of the errata sheet */
        &dev->state->word[offset / 4u]) {
        dev->core->bus.new_clocks.clock_enables = NULL;
        hil_rules_record_pass(dev->rules, HIL_RULE_CLOCK_ENABLE);
    }
    return dev->state->word[offset / 4u];
}

static void reset_lines(struct hil_rcc_device *dev, enum hil_rcc_bus bus, uint32_t bits)
{
    for (unsigned bit = 0; bit < 32; bit++) {
        const struct hil_reset_line *line = &dev->reset_lines[bus][bit];
        if ((bits >> bit & 1u) && line->reset)
            line->reset(line->device, line->unit);
    }
}

static void write_csr(struct hil_rcc_device *dev, uint32_t value)
{
    struct hil_rcc *rcc = dev->state;
    if (value & CSR_RMVF)
        rcc->csr &= ~CSR_FLAGS;
    if (value & CSR_LSION) {
        start_lsi(dev);
    } else if (!rcc->is_watchdog_running) {
        rcc->csr &= ~(CSR_LSION | CSR_LSIRDY);
        hil_event_set_ps(dev->core, HIL_EVENT_LSI, HIL_NEVER);
    }
}

void hil_rcc_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_rcc_device *dev = device;
    struct hil_rcc *rcc = dev->state;
    uint32_t before_hz = offset == CFGR ? compute_hclk_hz(dev, true) : 0;
    (void)unit;
    switch (offset) {
    case CR: write_cr(dev, value); break;
    case CFGR:
        rcc->cfgr = (rcc->cfgr & CFGR_SWS) | (value & ~CFGR_SWS);
        switch_hclk_source(dev);
        check_wait_states(dev, before_hz);
        break;
    case AHB1ENR:
    case APB1ENR:
    case APB2ENR:
        record_new_clock(dev, offset, value & ~rcc->word[offset / 4u]);
        rcc->word[offset / 4u] = value;
        break;
    case CIR: write_cir(dev, value); break;
    case AHB1RSTR: /* the reset of a peripheral ends at once */
        reset_lines(dev, HIL_RCC_AHB1, value);
        break;
    case APB1RSTR: reset_lines(dev, HIL_RCC_APB1, value); break;
    case APB2RSTR: reset_lines(dev, HIL_RCC_APB2, value); break;
    case CSR: write_csr(dev, value); break;
    default:
        if (offset == PLLCFGR && (rcc->cr & CR_PLLON))
            hil_bus_refuse(dev->core,
                           "PLLCFGR is written while the PLL is on: the chip ignores the write");
        rcc->word[offset / 4u] = value;
        break;
    }
}

/* ---- power ---- */

/* Power control. The voltage scale and the wait states of flash limit HCLK. */

#define ACR_LATENCY             7u
#define PWR_VOS                 (1u << 14)
#define VOLTAGE_SCALE_SETTLE_US 40u /* settling time of the voltage scaling */

uint32_t hil_rcc_max_hclk_hz(const struct hil_rcc *rcc)
{
    /* RM0090 table 10, 2.7 to 3.6 V: 30 MHz per wait state; table 22: scale 2 up to 144 MHz. */
    uint32_t flash_hz = 30000000u * ((rcc->flash_acr & ACR_LATENCY) + 1u);
    uint32_t core_hz = (rcc->pwr_cr & PWR_VOS) ? 168000000u : 144000000u;
    return flash_hz < core_hz ? flash_hz : core_hz;
}

uint32_t hil_pwr_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_rcc_device *dev = device;
    const struct hil_rcc *rcc = dev->state;
    (void)unit;
    return offset == 0
             ? rcc->pwr_cr
             : (uint32_t)(hil_now_cycle(dev->core) >= rcc->voltage_scale_ready_cycle) << 14;
}

void hil_pwr_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_rcc_device *dev = device;
    struct hil_rcc *rcc = dev->state;
    (void)unit;
    if (offset == 4)
        return; /* registers.def defines this register; it has only status bits */
    if ((value ^ rcc->pwr_cr) & PWR_VOS)
        rcc->voltage_scale_ready_cycle = hil_now_cycle(dev->core) +
                                         (uint64_t)dev->core->state.clock.hclk_hz / 1000000u *
                                             VOLTAGE_SCALE_SETTLE_US;
    rcc->pwr_cr = value;
}

/* ---- the independent watchdog ---- */

#define IWDG_KR                    0x00u
#define IWDG_PR                    0x04u
#define IWDG_SR                    0x0cu
#define IWDG_KEY_RELOAD            0xaaaau
#define IWDG_KEY_UNLOCK            0x5555u
#define IWDG_KEY_START             0xccccu
#define CSR_IWDGRSTF               (1u << 29)
#define REGISTER_UPDATE_LSI_CYCLES 5u

void hil_iwdg_reset(struct hil_iwdg_device *dev)
{
    *dev->state = (struct hil_iwdg){.rlr = 0xfff};
    hil_event_set_ps(dev->core, HIL_EVENT_IWDG, HIL_NEVER);
}

static uint64_t get_lsi_ps(const struct hil_iwdg_device *dev, uint64_t lsi_cycles)
{
    return lsi_cycles * HIL_PS_PER_S / dev->options->lsi_hz;
}

static void reload_watchdog(struct hil_iwdg_device *dev)
{
    struct hil_iwdg *w = dev->state;
    /* Prescaler 4 * 2^PR, at most 256. The chip is reset when the counter passes 0. */
    uint64_t divider = 4u << (w->pr > 6 ? 6 : w->pr);
    uint64_t timeout_ps = get_lsi_ps(dev, divider * (w->rlr + 1u));
    if (w->is_running)
        hil_event_set_ps(dev->core, HIL_EVENT_IWDG, hil_now_ps(dev->core) + timeout_ps);
}

uint32_t hil_iwdg_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_iwdg_device *dev = device;
    struct hil_iwdg *w = dev->state;
    uint64_t now = hil_now_ps(dev->core);
    (void)unit;
    if (offset == IWDG_SR)
        return (uint32_t)(now < w->update_end_ps[0]) | (uint32_t)(now < w->update_end_ps[1]) << 1;
    return w->word[offset / 4u];
}

static bool can_write_register(struct hil_iwdg_device *dev, bool updating)
{
    if (!dev->state->is_unlocked)
        hil_bus_refuse(dev->core, "the register is locked: the chip ignores the write");
    else if (updating)
        hil_bus_refuse(dev->core,
                       "a value is still being transferred (PVU, RVU): the chip ignores the write");
    return dev->state->is_unlocked && !updating;
}

static void write_watchdog_key(struct hil_iwdg_device *dev, uint32_t key)
{
    struct hil_iwdg *w = dev->state;
    w->is_unlocked = key == IWDG_KEY_UNLOCK;
    if (key == IWDG_KEY_START && !w->is_running) {
        w->is_running = true;
        dev->rcc->state->is_watchdog_running = true;
        start_lsi(dev->rcc); /* the watchdog starts LSI itself */
    }
    uint64_t now_ps = hil_now_ps(dev->core);
    if (key == IWDG_KEY_RELOAD && (now_ps < w->update_end_ps[0] || now_ps < w->update_end_ps[1]))
        hil_rules_record_violation(dev->rules, HIL_RULE_WATCHDOG_UPDATE,
                                   hil_access_timestamp(dev->core).pc, "%s is set",
                                   now_ps < w->update_end_ps[0] ? "PVU" : "RVU");
    if (key == IWDG_KEY_START || key == IWDG_KEY_RELOAD)
        reload_watchdog(dev);
}

void hil_iwdg_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_iwdg_device *dev = device;
    struct hil_iwdg *w = dev->state;
    uint64_t now = hil_now_ps(dev->core);
    (void)unit;
    if (offset == IWDG_KR) {
        write_watchdog_key(dev, value & 0xffffu);
        return;
    }
    uint64_t *until_ps = &w->update_end_ps[(offset - IWDG_PR) / 4u];
    if (can_write_register(dev, now < *until_ps)) {
        w->word[offset / 4u] = value;
        *until_ps = now + get_lsi_ps(dev, REGISTER_UPDATE_LSI_CYCLES);
    }
}

void hil_iwdg_event(void *device, uint64_t at)
{
    struct hil_iwdg_device *dev = device;
    (void)at;
    dev->core->state.counters.watchdog_resets++;
    hil_trace(dev->core, "watchdog expired");
    hil_core_request_reset(dev->core, CSR_IWDGRSTF);
}
