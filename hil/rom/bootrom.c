/* The boot ROM of the emulated board: a program in system memory with the AN3155 protocol on USART1
 * (PA9, PA10), compatible with the STM32F407's boot loader version 3.1. It runs on the emulated
 * core and reaches flash, option bytes and line only through the emulated registers, so their
 * locks, times and errors apply to it as to any firmware.
 *
 * It starts after a reset with BOOT0 high, or by a jump to the vectors at 0x1FFF0000 (stack
 * pointer, entry) from firmware that has returned clock, interrupts and peripherals to their reset
 * state. Like the original it does not change VTOR. It measures the rate of the first byte, 0x7F,
 * with SysTick; the original is specified for 1200 to 115200 Baud; this one also works somewhat
 * above that.
 *
 * Differences from ST's: no CAN2, USB and USART3; flash is always programmed x32 where alignment
 * allows, otherwise x8; no commands for write protection; Write Memory cannot write option
 * bytes. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define REG(address)  (*(volatile uint32_t *)(address))
#define RCC_CR        REG(0x40023800u)
#define RCC_PLLCFGR   REG(0x40023804u)
#define RCC_CFGR      REG(0x40023808u)
#define RCC_AHB1ENR   REG(0x40023830u)
#define RCC_APB2ENR   REG(0x40023844u)
#define FLASH_ACR     REG(0x40023c00u)
#define FLASH_KEYR    REG(0x40023c04u)
#define FLASH_OPTKEYR REG(0x40023c08u)
#define FLASH_SR      REG(0x40023c0cu)
#define FLASH_CR      REG(0x40023c10u)
#define FLASH_OPTCR   REG(0x40023c14u)
#define GPIOA_MODER   REG(0x40020000u)
#define GPIOA_IDR     REG(0x40020010u)
#define GPIOA_PUPDR   REG(0x4002000cu)
#define GPIOA_AFRH    REG(0x40020024u)
#define USART1_SR     REG(0x40011000u)
#define USART1_DR     REG(0x40011004u)
#define USART1_BRR    REG(0x40011008u)
#define USART1_CR1    REG(0x4001100cu)
#define IWDG_KR       REG(0x40003000u)
#define IWDG_PR       REG(0x40003004u)
#define IWDG_SR       REG(0x4000300cu)
#define SYST_CSR      REG(0xe000e010u)
#define SYST_RVR      REG(0xe000e014u)
#define SYST_CVR      REG(0xe000e018u)
#define NVIC_ISER(n)  REG(0xe000e100u + 4u * (n))
#define NVIC_ICER(n)  REG(0xe000e180u + 4u * (n))
#define NVIC_ICPR(n)  REG(0xe000e280u + 4u * (n))
#define SCB_ICSR      REG(0xe000ed04u)
#define SCB_AIRCR     REG(0xe000ed0cu)

#define PROTOCOL_VERSION 0x31u
#define ACK              0x79u
#define NACK             0x1fu
#define RXNE             0x20u
#define TXE              0x80u
#define TC               0x40u
#define LINE_ERRORS      0x0fu /* parity, framing, noise, overrun */
#define BSY              (1u << 16)
#define STRT             (1u << 16)
#define EOPIE            (1u << 24)
#define PSIZE_X32        (2u << 8)
#define RX_PIN           (1u << 10)
#define FLASH_BEGIN      0x08000000u
#define FLASH_END        0x08100000u
/* first address of RAM that programs may use; the variables of this program are below it */
#define RAM_BEGIN        0x20002000u
#define RAM_END          0x20020000u
#define SYSTEM_BEGIN     0x1fff0000u
#define SYSTEM_END       0x1fff7000u
#define SECTOR_COUNT     12u

static bool has_line_error; /* a byte was received with an error since the flag was cleared */

void reset(void) __attribute__((noreturn));
extern uint32_t stack_top[];
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*entry)(void);
} vectors = {stack_top, reset};

static void feed_watchdog(void)
{
    IWDG_KR = 0xaaaa;
}

/* Sleeps until an interrupt is pending: a byte, the end of a flash operation, or half a second of
 * SysTick. */
static void sleep_until_interrupt(void)
{
    __asm__ volatile("wfi");
    feed_watchdog();
    NVIC_ICPR(0) = 1u << 4;
    NVIC_ICPR(1) = 1u << 5;
    SCB_ICSR = 1u << 25; /* clear the pending SysTick interrupt */
}

static uint8_t receive_byte(void)
{
    while (!(USART1_SR & RXNE))
        sleep_until_interrupt();
    has_line_error |= (USART1_SR & LINE_ERRORS) != 0;
    return (uint8_t)USART1_DR; /* bit 8 is the parity bit */
}

static void send_byte(uint8_t byte)
{
    while (!(USART1_SR & TXE))
        ;
    USART1_DR = byte;
}

static void send_bytes(const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        send_byte(bytes[i]);
}

static bool send_ack_or_nack(bool good)
{
    send_byte(good ? ACK : NACK);
    return good;
}

/* Switches to 24 MHz through the PLL from the internal oscillator. */
static void set_fast_clock(void)
{
    RCC_CR |= 1u;
    while (!(RCC_CR & 2u))
        ;
    RCC_CFGR = 0;
    while (RCC_CFGR & 0xcu)
        ;
    RCC_CR &= ~(1u << 24);
    /* PLL settings: 16 MHz / 16 * 192 / 8 */
    RCC_PLLCFGR = 2u << 28 | 16u | 192u << 6 | 3u << 16 | 4u << 24;
    RCC_CR |= 1u << 24;
    while (!(RCC_CR & 1u << 25))
        ;
    FLASH_ACR = 0;
    RCC_CFGR = 2;
    while ((RCC_CFGR & 0xcu) != 8u)
        ;
}

static void set_slow_clock(void)
{
    RCC_CFGR = 0;
    while (RCC_CFGR & 0xcu)
        ;
    RCC_CR = 0x83;
    RCC_PLLCFGR = 0x24003010;
}

static uint32_t wait_for_rx_level(bool high)
{
    uint32_t wanted = high ? RX_PIN : 0;
    while ((GPIOA_IDR & RX_PIN) != wanted) {
        if (SCB_ICSR & 1u << 26) { /* SysTick has wrapped */
            SCB_ICSR = 1u << 25;
            feed_watchdog();
        }
    }
    return SYST_CVR;
}

/* Cycles between two readings of SysTick, a 24-bit down counter. */
static uint32_t count_cycles_between(uint32_t from, uint32_t to)
{
    return (from - to) & 0xffffffu;
}

/* Measures a bit of 0x7F on the line: low for the start bit, high for seven bits, low for one. The
 * falling edges are eight bits apart. */
static uint32_t measure_bit_cycles(void)
{
    for (;;) {
        wait_for_rx_level(true);
        uint32_t fall = wait_for_rx_level(false);
        uint32_t rise = wait_for_rx_level(true);
        uint32_t again = wait_for_rx_level(false);
        uint32_t start = count_cycles_between(fall, rise),
                 eight = count_cycles_between(fall, again);
        wait_for_rx_level(true);
        if (start * 8u > eight / 2u && start * 8u < eight * 3u / 2u && eight >= 8u * 16u)
            return (eight + 4u) / 8u;
    }
}

static void open_serial_line(void)
{
    RCC_AHB1ENR |= 1u;
    RCC_APB2ENR |= 1u << 4;
    USART1_CR1 = 0;
    GPIOA_PUPDR = (GPIOA_PUPDR & ~(3u << 20)) | 1u << 20;
    GPIOA_MODER &= ~(3u << 20);
    SYST_CSR = 0;
    SYST_RVR = 0xffffff;
    SYST_CVR = 0;
    SYST_CSR = 7;
    uint32_t bit = measure_bit_cycles();
    GPIOA_AFRH = (GPIOA_AFRH & ~0xff0u) | 0x770u;
    GPIOA_MODER = (GPIOA_MODER & ~(0xfu << 18)) | 0xau << 18;
    USART1_BRR = bit;
    USART1_CR1 = 1u << 13 | 1u << 12 | 1u << 10 | RXNE | 0xcu; /* 8E1 */
    SYST_RVR = 12000000;
    SYST_CVR = 0;
    NVIC_ISER(1) = 1u << 5;
    NVIC_ISER(0) = 1u << 4;
}

/* Resets the peripherals that this program has used. */
static void close_serial_line(void)
{
    while (!(USART1_SR & TC))
        ;
    USART1_CR1 = 0;
    USART1_BRR = 0;
    SYST_CSR = 0;
    SYST_RVR = 0;
    NVIC_ICER(0) = 1u << 4;
    NVIC_ICER(1) = 1u << 5;
    NVIC_ICPR(0) = 1u << 4;
    NVIC_ICPR(1) = 1u << 5;
    SCB_ICSR = 1u << 25;
    GPIOA_MODER = 0xa8000000u;
    GPIOA_PUPDR = 0x64000000u;
    GPIOA_AFRH = 0;
    RCC_APB2ENR = 0;
    RCC_AHB1ENR = 0x00100000u;
    set_slow_clock();
}

__attribute__((noreturn)) static void reset_system(void)
{
    while (!(USART1_SR & TC))
        ;
    SCB_AIRCR = 0x05fa0004u;
    for (;;)
        ;
}

static void wait_for_flash(void)
{
    while (FLASH_SR & BSY)
        sleep_until_interrupt();
    FLASH_SR = 0xf3;
}

static void unlock_flash(void)
{
    FLASH_SR = 0xf3;
    FLASH_KEYR = 0x45670123u;
    FLASH_KEYR = 0xcdef89abu;
}

static void lock_flash(void)
{
    FLASH_CR = 1u << 31;
}

static void erase_flash(uint32_t what)
{
    FLASH_CR = what | PSIZE_X32 | EOPIE;
    FLASH_CR = what | PSIZE_X32 | EOPIE | STRT;
    wait_for_flash();
}

static void program_flash(uint32_t address, const uint8_t *bytes, size_t n)
{
    unlock_flash();
    for (size_t i = 0; i < n;) {
        bool word = ((address + i) & 3u) == 0 && n - i >= 4;
        FLASH_CR = (word ? PSIZE_X32 : 0) | EOPIE | 1u;
        if (word)
            REG(address + i) = (uint32_t)bytes[i] | (uint32_t)bytes[i + 1] << 8 |
                               (uint32_t)bytes[i + 2] << 16 | (uint32_t)bytes[i + 3] << 24;
        else
            *(volatile uint8_t *)(address + i) = bytes[i];
        wait_for_flash();
        i += word ? 4 : 1;
    }
    lock_flash();
}

static uint8_t read_protection_byte(void)
{
    return (uint8_t)(FLASH_OPTCR >> 8);
}

static void program_options(uint32_t clear, uint32_t set)
{
    FLASH_OPTKEYR = 0x08192a3bu;
    FLASH_OPTKEYR = 0x4c5d6e7fu;
    uint32_t value = (FLASH_OPTCR & ~(clear | 3u)) | set;
    FLASH_OPTCR = value;
    FLASH_OPTCR = value | 2u;
    while (FLASH_SR & BSY)
        sleep_until_interrupt();
}

static bool is_in_range(uint32_t address, uint32_t begin, uint32_t end, uint32_t n)
{
    return address >= begin && address < end && n <= end - address;
}

static bool is_in_flash(uint32_t address, uint32_t n)
{
    return is_in_range(address, FLASH_BEGIN, FLASH_END, n);
}
static bool is_in_ram(uint32_t address, uint32_t n)
{
    return is_in_range(address, RAM_BEGIN, RAM_END, n);
}

/* Receives an address: four bytes, most significant first, and their XOR. The caller answers. */
static bool receive_address(uint32_t *address)
{
    uint8_t sum = 0;
    *address = 0;
    has_line_error = false;
    for (unsigned i = 0; i < 4; i++) {
        uint8_t byte = receive_byte();
        *address = *address << 8 | byte;
        sum ^= byte;
    }
    return receive_byte() == sum && !has_line_error;
}

static const uint8_t reply_to_get[] = {
    9, PROTOCOL_VERSION, 0x00, 0x01, 0x02, 0x11, 0x21, 0x31, 0x44, 0x82, 0x92};
static const uint8_t reply_to_get_version[] = {PROTOCOL_VERSION, 0, 0};
static const uint8_t reply_to_get_id[] = {1, 0x04, 0x13};

static void send_reply(const uint8_t *reply, size_t n)
{
    send_ack_or_nack(true);
    send_bytes(reply, n);
    send_ack_or_nack(true);
}

static void command_read(void)
{
    uint32_t address;
    send_ack_or_nack(true);
    bool good = receive_address(&address);
    good = good && (is_in_flash(address, 1) || is_in_ram(address, 1) ||
                    is_in_range(address, SYSTEM_BEGIN, SYSTEM_END, 1));
    if (!send_ack_or_nack(good))
        return;
    uint8_t n = receive_byte(), complement = receive_byte();
    good = (uint8_t)(n ^ complement) == 0xff && !has_line_error;
    good = good && (is_in_flash(address, n + 1u) || is_in_ram(address, n + 1u) ||
                    is_in_range(address, SYSTEM_BEGIN, SYSTEM_END, n + 1u));
    if (send_ack_or_nack(good))
        send_bytes((const uint8_t *)address, n + 1u);
}

/* Starts a program as a reset does: main stack pointer from the first word, PC from the second,
 * interrupts on. */
__attribute__((noreturn)) static void start_program(uint32_t address)
{
    uint32_t stack = REG(address), entry = REG(address + 4u);
    close_serial_line();
    __asm__ volatile("msr msp, %0\n cpsie i\n bx %1" : : "r"(stack), "r"(entry | 1u) : "memory");
    for (;;)
        ;
}

static void command_go(void)
{
    uint32_t address;
    send_ack_or_nack(true);
    bool good = receive_address(&address);
    if (send_ack_or_nack(good && !(address & 3u) &&
                         (is_in_flash(address, 8) || is_in_ram(address, 8))))
        start_program(address);
}

static void command_write(void)
{
    static uint8_t data[256];
    uint32_t address;
    send_ack_or_nack(true);
    bool good = receive_address(&address);
    if (!send_ack_or_nack(good && (is_in_flash(address, 1) || is_in_ram(address, 1))))
        return;
    uint8_t n = receive_byte(), sum = n;
    for (unsigned i = 0; i <= n; i++) {
        data[i] = receive_byte();
        sum ^= data[i];
    }
    good = receive_byte() == sum && !has_line_error;
    if (good && is_in_flash(address, n + 1u))
        program_flash(address, data, n + 1u);
    else if (good && is_in_ram(address, n + 1u))
        for (unsigned i = 0; i <= n; i++)
            *(volatile uint8_t *)(address + i) = data[i];
    else
        good = false;
    send_ack_or_nack(good);
}

static uint16_t receive_halfword(uint8_t *sum)
{
    uint8_t high = receive_byte(), low = receive_byte();
    *sum ^= high ^ low;
    return (uint16_t)(high << 8 | low);
}

/* Extended erase: a count minus one and that many sector numbers, or 0xFFFF for everything. There
 * is one bank, so the codes for single banks are refused. */
static void command_erase(void)
{
    uint8_t sectors[SECTOR_COUNT], sum = 0;
    bool good = true;
    send_ack_or_nack(true);
    has_line_error = false;
    uint16_t n = receive_halfword(&sum);
    if (n < 0xfff0u) {
        for (unsigned i = 0; i <= n; i++) {
            uint16_t sector = receive_halfword(&sum);
            good = good && sector < SECTOR_COUNT && i < SECTOR_COUNT;
            if (good)
                sectors[i] = (uint8_t)sector;
        }
    }
    good = receive_byte() == sum && !has_line_error && good && (n < 0xfff0u || n == 0xffffu);
    if (good) {
        unlock_flash();
        if (n == 0xffffu)
            erase_flash(1u << 2);
        for (unsigned i = 0; n < 0xfff0u && i <= n; i++)
            erase_flash((uint32_t)sectors[i] << 3 | 1u << 1);
        lock_flash();
    }
    send_ack_or_nack(good);
}

static void change_options(uint32_t clear, uint32_t set)
{
    send_ack_or_nack(true);
    program_options(clear, set);
    send_ack_or_nack(true);
    reset_system();
}

/* Sets the protection to level 0; the hardware erases everything first. */
static void command_readout_unprotect(void)
{
    send_ack_or_nack(true);
    if (read_protection_byte() == 0xaa) {
        unlock_flash();
        erase_flash(1u << 2);
        lock_flash();
    } else {
        program_options(0xffu << 8, 0xaau << 8);
    }
    send_ack_or_nack(true);
    reset_system();
}

/* Commands available at protection level 1 (AN3155, table of commands, note 2). */
static bool is_always_allowed(uint8_t command)
{
    return command <= 0x02 || command == 0x92;
}

static void execute_command(uint8_t command)
{
    if (read_protection_byte() != 0xaa && !is_always_allowed(command)) {
        send_ack_or_nack(false);
        return;
    }
    switch (command) {
    case 0x00: send_reply(reply_to_get, sizeof reply_to_get); break;
    case 0x01: send_reply(reply_to_get_version, sizeof reply_to_get_version); break;
    case 0x02: send_reply(reply_to_get_id, sizeof reply_to_get_id); break;
    case 0x11: command_read(); break;
    case 0x21: command_go(); break;
    case 0x31: command_write(); break;
    case 0x44: command_erase(); break;
    case 0x82: change_options(0xffu << 8, 0x55u << 8); break; /* command "readout protect" */
    case 0x92: command_readout_unprotect(); break;
    default: send_ack_or_nack(false); break;
    }
}

void reset(void)
{
    __asm__ volatile("cpsid i");
    IWDG_KR = 0x5555;
    IWDG_PR = 7;
    for (unsigned polls = 0; IWDG_SR && polls < 10000u; polls++)
        ;
    feed_watchdog();
    has_line_error = false;
    set_fast_clock();
    open_serial_line();
    send_ack_or_nack(true);
    for (;;) {
        has_line_error = false;
        uint8_t command = receive_byte(), complement = receive_byte();
        if ((uint8_t)(command ^ complement) == 0xff && !has_line_error)
            execute_command(command);
        else
            send_ack_or_nack(false);
    }
}
