/* board.h on the STM32F407: start-up sequence, identity, sleep, supervision tick. */
#include "common/crc32.h"
#include "common/version.h"
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define SUPERVISION_HZ 100u

static struct board_identity identity;
static bool is_quiet;
static volatile bool has_tick_passed;
static uint32_t asleep_ticks, load_since_tick;

/* ---- image ---- */

/* Header of this image, and the check that the flash content is the image that was built. */

extern const uint8_t program_start[], program_end[]; /* linker script */

/* firmware/stamp/stamp.c fills in the values that are unknown before linking. Only that program
 * uses this object; the board reads the header from flash. */
__attribute__((section(".header"), used)) static const struct {
    uint32_t magic;
    uint16_t format, bytes;
    const uint8_t *start, *end;
    uint32_t program_crc;
    uint8_t major, minor, patch, changed;
    uint32_t commit;
    uint16_t commit_more, board;
    uint32_t header_crc;
} header = {
    .magic = MR_IMAGE_MAGIC,
    .format = MR_IMAGE_FORMAT,
    .bytes = MR_IMAGE_BYTES,
    .start = program_start,
    .end = program_end,
    .major = FIRMWARE_MAJOR,
    .minor = FIRMWARE_MINOR,
    .patch = FIRMWARE_PATCH,
    .board = BOARD_NUMBER,
};
_Static_assert(sizeof header == MR_IMAGE_BYTES,
               "the layout of the header is that of common/image.h");

static uint8_t check_image(struct mr_image *image, uint32_t *crc)
{
    enum mr_status status = mr_image_decode(image, (const uint8_t *)MR_FLASH);
    *crc = mr_crc32(0, program_start, (size_t)(program_end - program_start));
    if (status == MR_UNKNOWN || status == MR_VERSION)
        return MR_IMAGE_NO_HEADER;
    if (status != MR_OK)
        return MR_IMAGE_HEADER_DAMAGED;
    return image->program_crc == *crc ? MR_IMAGE_INTACT : MR_IMAGE_PROGRAM_DAMAGED;
}

bool board_image_check(bool *good)
{
    struct mr_image image;
    uint32_t crc;
    uint8_t state = check_image(&image, &crc);
    *good = state == MR_IMAGE_INTACT;
    return state != MR_IMAGE_NO_HEADER;
}

/* ---- start ---- */

static uint8_t read_reset_cause(void)
{
    uint32_t csr = RCC->CSR;
    RCC->CSR |= RCC_CSR_RMVF;
    if (csr & RCC_CSR_IWDGRSTF)
        health_count_fault(MR_FAULT_WATCHDOG_RESET, 0);
    return (uint8_t)((csr & RCC_CSR_PORRSTF ? 1u : 0u) | (csr & RCC_CSR_PINRSTF ? 2u : 0u) |
                     (csr & RCC_CSR_SFTRSTF ? 4u : 0u) | (csr & RCC_CSR_IWDGRSTF ? 8u : 0u) |
                     (csr & RCC_CSR_LPWRRSTF ? 16u : 0u) | (csr & RCC_CSR_BORRSTF ? 32u : 0u));
}

static void start_supervision(void)
{
    SYST_RVR = 168000000u / SUPERVISION_HZ - 1;
    SYST_CVR = 0;
    SCB_SHPR[11] = PRIORITY_SUPERVISION << 4; /* SysTick is system handler 15; SHPR begins at 4 */
    /* enabled, with interrupt, from the processor clock */
    SYST_CSR = 7u;
}

void board_start(void)
{
    watchdog_start(); /* start it before anything that could hang */
    identity.reset_cause = read_reset_cause();
    is_quiet = fault_read_record(identity.reset_cause);
    clock_reset();
    /* Set outputs before starting the crystal, which may take 100 ms, because outputs float until
     * then. */
    pins_configure();
    enum mr_clock_source clock = clock_start(!fault_has_crystal_stopped_twice());
    memory_start();
    identity.clock_source = (uint8_t)clock;
    identity.board = BOARD_NUMBER;
    identity.image_state = check_image(&identity.image, &identity.image_crc);

    fault_set_image_crc(identity.image_crc);
    memory_set_image_crc(identity.image_crc);

    for (unsigned i = 0; i < 3; i++)
        identity.uid[i] = UID[i];

    uart_start();
    if (clock == MR_CLOCK_CRYSTAL)
        can_start();
    if (!is_quiet) {
        capture_start();
        scan_prepare();
        nor_start();
    }
    start_supervision();
    watchdog_feed();
}

void board_identify(struct board_identity *out)
{
    *out = identity;
}

uint32_t board_input_mask(void)
{
    return BOARD_INPUTS;
}

uint32_t board_supply_mv(void)
{
    return BOARD_SUPPLY_MV;
}

void board_set_warning(bool warning)
{
    warning |= is_quiet;
    pin_write(PIN_WARNING, !warning);
}

void board_set_shunts(bool on)
{
    pin_write(PIN_SHUNTS, on);
}

bool board_has_lamp_current(void)
{
    return !pin_read(PIN_LAMP);
}

void board_watchdog_feed(void)
{
    watchdog_feed();
}

void systick(void);
void systick_irq(const uint32_t *frame);
__attribute__((naked)) void systick(void)
{
    __asm volatile("mrs r0, msp\n\tb.w systick_irq");
}

void systick_irq(const uint32_t *frame)
{
    has_tick_passed = true;
    tasks_tick(frame[6]); /* frame[6] is the interrupted program address */
}

bool board_sleep(void)
{
    /* WFI also ends at a pending interrupt while interrupts are masked, so an event that occurs
     * after this check is not missed. */
    uint32_t mask = irq_mask();
    if (!scan_is_block_ready() && !has_tick_passed) {
        uint32_t before = TIM2->CNT;
        __asm volatile("dsb\n\twfi" ::: "memory");
        asleep_ticks += TIM2->CNT - before;
    }
    irq_restore(mask);
    bool passed = has_tick_passed;
    if (passed) /* a tick that occurs from here on is reported by the next call */
        has_tick_passed = false;
    return passed;
}

uint16_t board_load_permille(void)
{
    uint32_t now = TIM2->CNT;
    uint32_t elapsed = now - load_since_tick;
    uint32_t asleep = asleep_ticks;
    asleep_ticks = 0;
    load_since_tick = now;
    if (elapsed < 1000 || asleep > elapsed)
        return 1000;
    return (uint16_t)(1000u - asleep / (elapsed / 1000u));
}

/* ---- watchdog ---- */

/* Independent watchdog: 500 counts of LSI / 32. LSI is 17 to 47 kHz, so 0.34 to 0.94 s. RM0090
 * 21.3. */

#define KEY_UNLOCK   0x5555u
#define KEY_FEED     0xaaaau
#define KEY_START    0xccccu
#define UPDATE_POLLS 100000u /* a register change takes up to five LSI periods */

void watchdog_start(void)
{
    /* a breakpoint must stop the watchdog, and the timers, whose data is not read during it */
    DBGMCU_APB1_FZ |= DBGMCU_APB1_FZ_DBG_IWDG_STOP | DBGMCU_APB1_FZ_DBG_TIM2_STOP |
                      DBGMCU_APB1_FZ_DBG_TIM4_STOP;
    IWDG->KR = KEY_START;
    IWDG->KR = KEY_UNLOCK;
    IWDG->PR = 3u; /* prescaler 32 */
    watchdog_set_timeout(WATCHDOG_DEFAULT_COUNTS);
}

void watchdog_set_timeout(uint32_t counts)
{
    IWDG->KR = KEY_UNLOCK;
    IWDG->RLR = counts;
    for (unsigned polls = 0; IWDG->SR && polls < UPDATE_POLLS; polls++) {
    }
    IWDG->KR = KEY_FEED;
}

void watchdog_feed(void)
{
    IWDG->KR = KEY_FEED;
}

/* ---- boot ROM ---- */

/* Enters the chip's boot ROM. The ROM expects the chip in reset state. This code therefore stores a
 * request in RAM and resets the chip; the start code reads the request before anything else. AN2606
 * 3 (STM32F40x: vectors at 0x1FFF0000). */

#define ROM_VECTORS      0x1fff0000u
#define ROM_REQUEST_MARK 0x21524f4du /* "MOR!" */

/* Not cleared at start. The complement shows whether the content is valid: at power on, RAM
 * contains random values. */
static struct {
    uint32_t valid;
    uint32_t complement;
} rom_request __attribute__((section(".noinit")));

bool board_is_jumper_fitted(void)
{
    return !pin_read(PIN_MAINTENANCE);
}

bool board_is_rom_reachable(void)
{
    return BOARD_IS_ROM_ON_SERIAL;
}

void board_enter_rom(void)
{
    rom_request.valid = ROM_REQUEST_MARK;
    rom_request.complement = ~ROM_REQUEST_MARK;
    __asm volatile("dsb" ::: "memory");
    SCB_AIRCR = 0x05fa0004u; /* system reset request */
    for (;;) {
    }
}

/* True if the boot ROM ran first: with BOOT0 high a reset starts it, because address 0 maps to
 * it. */
static bool has_rom_run(const uint32_t *vectors)
{
    uintptr_t at = 4;
    /* hide the value from gcc, which assumes that an access near address 0 is undefined */
    __asm volatile("" : "+r"(at));
    return *(const volatile uint32_t *)at == vectors[1];
}

void enter_rom_if_requested(void)
{
    const uint32_t *vectors = (const uint32_t *)ROM_VECTORS;
    if (rom_request.valid != ROM_REQUEST_MARK || rom_request.complement != ~ROM_REQUEST_MARK)
        return;
    rom_request.valid = 0;
    /* do not start the boot ROM again: it has run and has started this program */
    if (has_rom_run(vectors))
        return;
    /* The ROM's interrupts (USB, CAN) use the vectors at address 0, because VTOR is 0 after a
     * reset. */
    RCC->APB2ENR |= RCC_APB2ENR_SYSCFG;
    (void)RCC->APB2ENR;
    SYSCFG_MEMRMP = SYSCFG_MEMRMP_MEM_MODE_0;
    __asm volatile("dsb\n\tisb" ::: "memory");
    __asm volatile("msr msp, %0\n\tbx %1" : : "r"(vectors[0]), "r"(vectors[1]) : "memory");
}
