/* Breaks one rule of time or electricity after the other (hil/periph/rules.def), or keeps it by a
 * little: control[0] says which, control[1] how much it waits where a time is asked. SPI2 as in
 * nor.c. results[0] is 1 when it came to its end, results[1] the failure of the clock. */
#include "tests/hil/images/image.h"

#define AHB1ENR  REG(0x40023830u)
#define APB1ENR  REG(0x40023840u)
#define ACR      REG(0x40023c00u)
#define CFGR     REG(0x40023808u)
#define CR1      REG(0x40003800u)
#define SR       REG(0x40003808u)
#define DR       REG(0x4000380cu)
#define MODER_B  REG(0x40020400u)
#define OTYPER_B REG(0x40020404u)
#define SPEED_B  REG(0x40020408u)
#define PULL_B   REG(0x4002040cu)
#define BSRR_B   REG(0x40020418u)
#define IDR_E    REG(0x40021010u)
#define SELECT   (1u << 28)
#define DESELECT (1u << 12)
#define SCL      6u
#define SDA      7u

static void wait_cycles(uint32_t n) /* at least */
{
    for (n /= 3; n; n--)
        __asm__ volatile("nop");
}

static void wait_us(uint32_t us)
{
    wait_cycles(us * 168u);
}

static void start_pins(uint32_t speed)
{
    AHB1ENR |= 2u | 1u << 4;
    (void)AHB1ENR;
    APB1ENR |= 1u << 14;
    (void)APB1ENR;
    BSRR_B = DESELECT;
    SPEED_B = (SPEED_B & 0x00ffffffu) | speed * 0x55000000u;
    PULL_B |= 1u << 28;
    MODER_B = (MODER_B & 0x00ffffffu) | 0xa9000000u;
    REG(0x40020424u) = 0x55500000u;
    CR1 = 1u << 9 | 1u << 8 | 1u << 2;
    CR1 |= 1u << 6;
}

static void send(uint8_t byte)
{
    DR = byte;
    while (!(SR & 1u))
        ;
    (void)DR;
}

static void end(void)
{
    while (SR & 0x80u)
        ;
    wait_cycles(12);
    BSRR_B = DESELECT;
}

static void command(const uint8_t *bytes, unsigned n)
{
    BSRR_B = SELECT;
    for (unsigned i = 0; i < n; i++)
        send(bytes[i]);
    end();
}

static const uint8_t read_status[2] = {5, 0}, read[5] = {3, 0, 0, 0, 0}, wake[1] = {0xab},
                     sleep[1] = {0xb9}, enable_reset[1] = {0x66}, reset_chip[1] = {0x99},
                     write_enable[1] = {6};

/* High for as few cycles as can be. */
static __attribute__((noinline)) void reselect(void)
{
    __asm__ volatile("str %0, [%2]\n str %1, [%2]"
                     :
                     : "r"(DESELECT), "r"(SELECT), "r"(0x40020418u)
                     : "memory");
}

static void two_commands(const uint8_t *bytes, unsigned n)
{
    command(bytes, n);
    wait_us(1);
    BSRR_B = SELECT;
    for (unsigned i = 0; i < n; i++)
        send(bytes[i]);
    while (SR & 0x80u)
        ;
    reselect();
    for (unsigned i = 0; i < n; i++)
        send(bytes[i]);
    end();
}

/* The line falls when SCK already runs. */
static __attribute__((noinline)) void late_select(void)
{
    __asm__ volatile("str %0, [%1]\n nop\n nop\n str %2, [%3]"
                     :
                     : "r"(5u), "r"(0x4000380cu), "r"(SELECT), "r"(0x40020418u)
                     : "memory");
    end();
}

/* Deselected so many rounds after the store that begins a byte, at SCK of 164 kHz. */
static __attribute__((noinline)) void early_deselect(uint32_t rounds)
{
    CR1 &= ~(1u << 6);
    CR1 |= 7u << 3;
    CR1 |= 1u << 6;
    __asm__ volatile("str %[low], [%[bsrr]]\n"
                     "str %[byte], [%[dr]]\n"
                     "1: subs %[n], #1\n bne 1b\n"
                     "str %[high], [%[bsrr]]\n"
                     : [n] "+r"(rounds)
                     : [low] "r"(SELECT), [high] "r"(DESELECT), [byte] "r"(5u),
                       [dr] "r"(0x4000380cu), [bsrr] "r"(0x40020418u)
                     : "memory", "cc");
    while (SR & 0x80u)
        ;
}

static void line(unsigned pin, unsigned high)
{
    BSRR_B = high ? 1u << pin : 1u << (pin + 16);
}

/* The thermometer's lines as outputs with open drain. */
static void start_lines(void)
{
    AHB1ENR |= 2u;
    (void)AHB1ENR;
    line(SCL, 1);
    line(SDA, 1);
    OTYPER_B |= 3u << SCL;
    SPEED_B |= 2u << (2 * SCL) | 2u << (2 * SDA);
    MODER_B = (MODER_B & ~(15u << (2 * SCL))) | 5u << (2 * SCL);
}

/* Low and high for so long; then a stop, and a start after `free_us`. */
static void clock_bus(uint32_t low_us, uint32_t high_us, uint32_t free_us)
{
    line(SCL, 0);
    wait_us(low_us);
    line(SCL, 1);
    wait_us(high_us);
    line(SCL, 0);
    line(SDA, 0);
    wait_us(3);
    line(SCL, 1);
    wait_us(3);
    line(SDA, 1);
    wait_us(free_us);
    line(SDA, 0);
}

static __attribute__((noinline)) void access_at_once(uint32_t enable, uint32_t bits,
                                                     uint32_t access)
{
    __asm__ volatile("str %1, [%0]\n str %1, [%2]" : : "r"(enable), "r"(bits), "r"(access));
}
static __attribute__((noinline)) void access_behind_dsb(uint32_t enable, uint32_t bits,
                                                        uint32_t access)
{
    __asm__ volatile("str %1, [%0]\n dsb\n str %1, [%2]" : : "r"(enable), "r"(bits), "r"(access));
}
static __attribute__((noinline)) void access_after_two(uint32_t enable, uint32_t bits,
                                                       uint32_t access)
{
    __asm__ volatile("str %1, [%0]\n nop\n nop\n str %1, [%2]"
                     :
                     : "r"(enable), "r"(bits), "r"(access));
}

/* As clock_168, without reading the wait states back. */
static void clock_unread(void)
{
    REG(0x40023800u) |= 1u << 16;
    while (!(REG(0x40023800u) & 1u << 17))
        ;
    ACR = 0x705;
    REG(0x40023804u) = 2u << 28 | 8u | 336u << 6 | 1u << 22 | 7u << 24;
    REG(0x40023808u) = 5u << 10 | 4u << 13;
    REG(0x40023800u) |= 1u << 24;
    while (!(REG(0x40023800u) & 1u << 25))
        ;
    REG(0x40023808u) |= 2u;
}

static void of_the_memory(uint32_t which)
{
    uint32_t us = control[1];
    switch (which) {
    case 1: two_commands(read_status, 2); break;
    case 2: two_commands(read, 5); break;
    case 3: late_select(); break;
    case 4: early_deselect(control[1]); break;
    case 6:
        command(wake, 1);
        wait_us(us);
        break;
    case 7:
        command(sleep, 1);
        wait_us(us);
        break;
    case 8:
        command(enable_reset, 1);
        wait_us(1);
        command(reset_chip, 1);
        wait_us(us);
        break;
    case 10: command(write_enable, 1); break; /* 2.3 ms after power on */
    default: break;
    }
    wait_us(1);
    command(read_status, 2);
}

static __attribute__((noinline)) uint32_t read_e(void)
{
    return IDR_E;
}

static void of_the_chip(uint32_t which)
{
    static volatile uint32_t kept;
    switch (which) {
    case 30: access_at_once(0x40023830u, 2u, 0x40020418u); break;
    case 31: access_at_once(0x40023840u, 1u << 14, 0x40003800u); break;
    case 32: access_behind_dsb(0x40023830u, 2u, 0x40020418u); break;
    case 33: access_after_two(0x40023830u, 2u, 0x40020418u); break;
    case 34: clock_unread(); break;
    default: break;
    }
    if (which < 40)
        return;
    AHB1ENR |= 1u << 4;
    (void)AHB1ENR;
    REG(0x4002100cu) = 1u << 6; /* PE3 is pulled up; the rest floats */
    switch (which) {
    case 40: /* decides by PE3 alone */
        if (IDR_E >> 3 & 1u)
            results[2] = 1;
        break;
    case 41: /* by PE15 */
        if (IDR_E >> 15 & 1u)
            results[2] = 1;
        break;
    case 42: /* keeps everything */ kept = IDR_E; break;
    case 43: /* reads, and drops it */ (void)IDR_E; break;
    case 44: /* reads PE15 until it is high, as if somebody were there */
        while (!(*(volatile uint16_t *)0x40021010u & 1u << 15))
            ;
        break;
    case 45: /* PE15 comes to nothing in the end */ results[2] = (IDR_E & 0x8008u) >> 3 & 1u; break;
    case 46: /* reads on and on, and drops it until it is told to keep it */
        for (;;) {
            uint32_t read = IDR_E;
            if (control[1])
                kept = read;
        }
    case 47: /* PE15, dropped by one caller and kept by another */
        for (unsigned i = 0; i < 100; i++)
            (void)read_e();
        results[2] = read_e() >> 15 & 1u;
        break;
    default: break;
    }
    results[3] = kept;
}

/* ADC1 converts PA0 once, after a window by control[1]: 0 is 3 clocks, 7 is 480. control[2]:
 * bits of CFGR, a prescaler, that are set meanwhile; control[3]: it is not waited for. */
static void convert(void)
{
    CFGR |= control[2];
    AHB1ENR |= 1u;
    (void)AHB1ENR;
    REG(0x40020000u) |= 3u;
    REG(0x40023844u) |= 1u << 8;
    (void)REG(0x40023844u);
    REG(0x40012010u) = control[1];
    REG(0x40012008u) = 1u;
    if (!control[3])
        wait_us(3);
    REG(0x40012008u) = 1u | 1u << 30;
    while (!(REG(0x40012000u) & 2u))
        ;
    (void)REG(0x4001204cu);
    CFGR &= ~control[2];
}

/* The watchdog gets another time; control[1]: it is fed when that has arrived. */
static void feed(void)
{
    REG(0x40003000u) = 0xcccc;
    REG(0x40003000u) = 0x5555;
    REG(0x40003008u) = 0x800;
    while (control[1] && REG(0x4000300cu))
        ;
    REG(0x40003000u) = 0xaaaa;
}

/* Sector 1 is erased beside the data cache and read; control[1]: the cache is reset between. */
static void erase(void)
{
    results[2] = *(volatile uint32_t *)0x08004000u;
    ACR |= 1u << 10;
    REG(0x40023c04u) = 0x45670123u;
    REG(0x40023c04u) = 0xcdef89abu;
    REG(0x40023c10u) = 2u << 8 | 1u << 3 | 2u;
    REG(0x40023c10u) |= 1u << 16;
    while (REG(0x40023c0cu) & 1u << 16)
        ;
    if (control[1]) {
        ACR &= ~(1u << 10);
        ACR |= 1u << 12;
        ACR &= ~(1u << 12);
        ACR |= 1u << 10;
    }
    results[2] = *(volatile uint32_t *)0x08004000u;
}

/* TIM2 captures edges of PB3; control[1]: its pull. */
static void capture(void)
{
    AHB1ENR |= 2u;
    (void)AHB1ENR;
    APB1ENR |= 1u;
    (void)APB1ENR;
    PULL_B = (PULL_B & ~(3u << 6)) | control[1] << 6;
    REG(0x40020420u) |= 1u << 12;
    MODER_B = (MODER_B & ~(3u << 6)) | 2u << 6;
    REG(0x40000018u) = 1u << 8;
    REG(0x40000020u) = 1u << 4;
}

int main(void)
{
    uint32_t which = control[0];
    if (which < 30) {
        results[1] = which == 5 || which == 9 ? 0 : (uint32_t)clock_168();
        if (which < 20)
            start_pins(which == 5 ? 0 : 3);
        else
            start_lines();
    }
    if (which == 9) { /* on the internal oscillator, some microseconds after power on */
        command(read_status, 2);
    } else if (which < 20) {
        of_the_memory(which);
    } else if (which < 30) {
        clock_bus(which == 21 ? 1 : 3, which == 22 ? 1 : 3, which == 23 ? 1 : 3);
    } else if (which < 50) {
        of_the_chip(which);
    } else if (which == 50) {
        convert();
    } else if (which == 60) {
        feed();
    } else if (which == 61) {
        erase();
    } else {
        capture();
    }
    results[0] = 1;
    return 0;
}
