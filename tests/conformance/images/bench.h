/* What the conformance images share: start, a vector table in RAM, and one line per check on
 * USART1:
 *
 *     name 0xvalue 0xmanual      or      name 0xvalue -      where the manuals leave the value open
 *
 * Written from the ARMv7-M Architecture Reference Manual (DDI 0403E: "ARM"), PM0214 and RM0090, on
 * its own: neither the firmware's nor the emulator's definitions are used. Variables are not
 * initialised. */
#ifndef MATRIG_TESTS_CONFORMANCE_BENCH_H
#define MATRIG_TESTS_CONFORMANCE_BENCH_H

#include <stdint.h>

#define WORD(address) (*(volatile uint32_t *)(address))
#define HALF(address) (*(volatile uint16_t *)(address))
#define BYTE(address) (*(volatile uint8_t *)(address))

/* PM0214 4.4 and 4.6 */
#define ICSR    WORD(0xe000ed04u)
#define VTOR    WORD(0xe000ed08u)
#define AIRCR   WORD(0xe000ed0cu)
#define CCR     WORD(0xe000ed14u)
/* priority of exception n, 4 to 15: SHPR1 is at 0xe000ed18 */
#define SHPR(n) BYTE(0xe000ed14u + (n))
#define SHCSR   WORD(0xe000ed24u)
#define CFSR    WORD(0xe000ed28u)
#define HFSR    WORD(0xe000ed2cu)
#define BFAR    WORD(0xe000ed38u)
#define CPACR   WORD(0xe000ed88u)
#define FPCCR   WORD(0xe000ef34u)
#define FPCAR   WORD(0xe000ef38u)
#define FPDSCR  WORD(0xe000ef3cu)

/* PM0214 4.3: interrupt n */
#define ISER(n) WORD(0xe000e100u + 4u * ((n) / 32u))
#define ICER(n) WORD(0xe000e180u + 4u * ((n) / 32u))
#define ISPR(n) WORD(0xe000e200u + 4u * ((n) / 32u))
#define ICPR(n) WORD(0xe000e280u + 4u * ((n) / 32u))
#define IABR(n) WORD(0xe000e300u + 4u * ((n) / 32u))
#define IPR(n)  BYTE(0xe000e400u + (n))
#define STIR    WORD(0xe000ef00u)
#define BIT(n)  (1u << ((n) % 32u))

/* RM0090 7.3.10, 7.3.14, 8.4, 30.6 */
#define RCC_AHB1ENR WORD(0x40023830u)
#define RCC_APB1ENR WORD(0x40023840u)
#define RCC_APB2ENR WORD(0x40023844u)
#define GPIOA_MODER WORD(0x40020000u)
#define GPIOA_AFRH  WORD(0x40020024u)
#define USART1_SR   WORD(0x40011000u)
#define USART1_DR   WORD(0x40011004u)
#define USART1_BRR  WORD(0x40011008u)
#define USART1_CR1  WORD(0x4001100cu)
#define USART1_CR2  WORD(0x40011010u)
#define USART1_CR3  WORD(0x40011014u)

typedef void (*handler)(void);

int main(void);
void reset(void) __attribute__((noreturn));
static void stray(void);

__attribute__((section(".vectors"), used)) static const handler flash_vectors[16] = {
    (handler)0x20018000,
    (handler)reset,
    stray,
    stray,
    stray,
    stray,
    stray,
    stray,
    0,
    0,
    0,
    stray,
    stray,
    0,
    stray,
    stray,
};
/* 16 exceptions and 82 interrupts: 98 words; a table is aligned to its size, the next power of two
 * (PM0214 4.4.4). */
static handler vectors[98] __attribute__((aligned(512)));

static void put_char(char c)
{
    while (!(USART1_SR & 0x80u)) /* TXE */
        ;
    USART1_DR = (uint8_t)c;
}

static void put_text(const char *text)
{
    while (*text)
        put_char(*text++);
}

static void put_hex(uint32_t value)
{
    put_text("0x");
    for (int shift = 28; shift >= 0; shift -= 4)
        put_char("0123456789abcdef"[value >> shift & 15u]);
}

static __attribute__((unused)) void tell_value(const char *name, uint32_t value)
{
    put_text(name);
    put_char(' ');
    put_hex(value);
}

/* A check whose value the manuals leave open: both machines must agree. */
static __attribute__((unused)) void tell(const char *name, uint32_t value)
{
    tell_value(name, value);
    put_text(" -\n");
}

/* A check whose value the manuals give. */
static __attribute__((unused)) void expect(const char *name, uint32_t value, uint32_t manual)
{
    tell_value(name, value);
    put_char(' ');
    put_hex(manual);
    put_char('\n');
}

/* An exception that no check has asked for ends the image; the lines that are missing tell
 * where. */
static void stray(void)
{
    uint32_t number;
    __asm__ volatile("mrs %0, ipsr" : "=r"(number));
    tell("stray_exception", number);
    tell("stray_cfsr", CFSR);
    for (;;)
        ;
}

void reset(void)
{
    RCC_AHB1ENR = 1u;      /* GPIOA */
    RCC_APB2ENR = 1u << 4; /* USART1 */
    /* PA9, PA10 alternate; PA13 to 15 as after reset */
    GPIOA_MODER = 0xa8000000u | 2u << 18 | 2u << 20;
    GPIOA_AFRH = 7u << 4 | 7u << 8;             /* AF7 */
    USART1_BRR = 1u << 4;                       /* 16 MHz / 8 / 1: 2 Mbaud */
    USART1_CR1 = 1u << 15 | 1u << 13 | 1u << 3; /* OVER8, UE, TE */
    for (unsigned i = 0; i < 98; i++)
        vectors[i] = stray;
    vectors[0] = flash_vectors[0];
    vectors[1] = reset;
    VTOR = (uint32_t)(uintptr_t)vectors;
    __asm__ volatile("dsb\n\tisb");
    main();
    put_text("end\n");
    for (;;)
        __asm__ volatile("wfi");
}

static __attribute__((unused)) void on(unsigned exception, handler f)
{
    vectors[exception] = f;
    __asm__ volatile("dsb" ::: "memory");
}

#define IRQ(n) (16u + (n)) /* exception number of an interrupt */

#endif
