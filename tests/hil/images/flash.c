/* The flash interface, one exercise each, chosen by control[0]; at 16 MHz from the internal
 * oscillator. */
#include "tests/hil/images/image.h"

#define KEYR     REG(0x40023c04u)
#define OPTKEYR  REG(0x40023c08u)
#define SR       REG(0x40023c0cu)
#define CR       REG(0x40023c10u)
#define OPTCR    REG(0x40023c14u)
#define CYCLES   REG(0xe0001004u)
#define BSY      (1u << 16)
#define STRT     (1u << 16)
#define PSIZE(n) ((n) << 8)
#define SECTOR_1 0x08004000u
#define SECTOR_2 0x08008000u

static uint32_t ram_code[64];

void systick(void)
{
    results[40]++;
}
void irq4(void)
{
    results[41]++;
    results[42] = SR;
    SR = 0xf3;
}

static void unlock(void)
{
    KEYR = 0x45670123u;
    KEYR = 0xcdef89abu;
}

static void wait(void)
{
    while (SR & BSY)
        ;
}

static void locks(void)
{
    results[1] = CR;
    KEYR = 0x45670123u;
    results[2] = CR;
    CR = 1; /* still locked: ignored */
    results[3] = CR;
    KEYR = 0xcdef89abu;
    CR = 1;
    results[4] = CR;
    CR = 1u << 31;
    results[5] = CR;
    unlock();
    results[6] = CR;
    CR = 1u << 31;
    KEYR = 0x45670123u;
    KEYR = 0xcdef89aau; /* wrong: closed until the next reset */
    unlock();
    results[7] = CR;
    OPTKEYR = 0x4c5d6e7fu; /* wrong order */
    OPTKEYR = 0x08192a3bu;
    OPTKEYR = 0x4c5d6e7fu;
    results[8] = OPTCR;
}

static void program(void)
{
    volatile uint32_t *word = (volatile uint32_t *)SECTOR_1;
    unlock();
    CR = PSIZE(2) | 1u;
    results[1] = CYCLES;
    word[0] = 0x12345678u;
    wait();
    results[2] = CYCLES;
    results[3] = word[0];
    word[0] = 0xffff0000u; /* no cell goes back to 1 */
    wait();
    results[4] = word[0];
    results[5] = SR;
    /* without waiting: the bus holds each store until the one before it is done */
    word[1] = 0x11111111u;
    word[2] = 0x22222222u;
    word[3] = 0x33333333u;
    wait();
    results[6] = CYCLES;
    results[7] = word[1];
    results[8] = word[2];
    results[9] = word[3];
    CR = PSIZE(0) | 1u;
    *(volatile uint8_t *)(SECTOR_1 + 17u) = 0xa5;
    wait();
    CR = PSIZE(1) | 1u;
    *(volatile uint16_t *)(SECTOR_1 + 18u) = 0x5aa5;
    wait();
    results[10] = word[4];
    results[11] = SR;
}

static void mistakes(void)
{
    unlock();
    REG(SECTOR_1) = 0; /* PG is not set */
    results[1] = SR;
    SR = 0xf3;
    results[2] = SR;
    CR = PSIZE(2) | 1u;
    *(volatile uint8_t *)SECTOR_1 = 0; /* a byte with x32 */
    results[3] = SR;
    SR = 1u << 6;
    *(volatile uint32_t *)(SECTOR_1 + 14u) = 0; /* across a row */
    results[4] = SR;
    SR = 0xf3;
    CR = 1u << 25 | 1u; /* ERRIE, x8 */
    enable_irq(4);
    REG(SECTOR_1) = 0;
    __asm__ volatile("isb");
    results[5] = REG(SECTOR_1);
    CR = 1u << 1 | 1u << 2; /* SER and MER */
    CR = 1u << 1 | 1u << 2 | STRT;
    results[6] = CR;
    results[7] = SR;
}

static void erase(void)
{
    unlock();
    enable_irq(4);
    REG(0xe000e014u) = 15999; /* SysTick each millisecond */
    REG(0xe000e018u) = 0;
    REG(0xe000e010u) = 7;
    CR = PSIZE(control[1]) | control[2] << 3 | 1u << 1 | 1u << 24;
    results[1] = CYCLES;
    CR |= STRT;
    __asm__ volatile("dsb");
    while (SR & BSY)
        results[3]++;
    results[2] = CYCLES;
    results[4] = CR;
    results[5] = results[40];
}

/* Erases sector 1 and polls; runs from a copy in RAM. */
__attribute__((noinline, section(".text.poll"))) static void poll(volatile uint32_t *into,
                                                                  uint32_t read_flash)
{
    CR = PSIZE(2) | 1u << 3 | 1u << 1;
    into[1] = CYCLES;
    CR |= STRT;
    if (read_flash) {
        into[6] = REG(SECTOR_2);
        into[7] = SR;
    }
    while (SR & BSY)
        into[3]++;
    into[2] = CYCLES;
}

static void erase_from_ram(void)
{
    const uint32_t *from = (const uint32_t *)((uintptr_t)poll & ~1u);
    for (unsigned i = 0; i < 64; i++)
        ram_code[i] = from[i];
    unlock();
    void (*run)(volatile uint32_t *,
                uint32_t) = (void (*)(volatile uint32_t *, uint32_t))((uintptr_t)ram_code | 1u);
    run(results, control[2]);
}

static void options(void)
{
    results[1] = OPTCR;
    results[2] = REG(0x1fffc000u);
    results[3] = REG(0x1fffc008u);
    if (control[1]) {
        OPTKEYR = 0x08192a3bu;
        OPTKEYR = 0x4c5d6e7fu;
        OPTCR = control[1] & ~3u;
        OPTCR |= 2u;
        wait();
        results[4] = OPTCR;
    }
}

static void words(void)
{
    unlock();
    if (control[1]) {
        CR = PSIZE(2) | 1u << 3 | 1u << 1 | STRT;
        wait();
    }
    CR = PSIZE(2) | 1u;
    for (unsigned i = 0; i < 64; i++) {
        REG(SECTOR_1 + 4u * i) = 0x5a000000u + i;
        wait();
    }
}

int main(void)
{
    results[0]++; /* starts */
    REG(0xe000edfcu) |= 1u << 24;
    REG(0xe0001000u) |= 1u;
    switch (control[0]) {
    case 1: locks(); break;
    case 2: program(); break;
    case 3: mistakes(); break;
    case 4: erase(); break;
    case 5: erase_from_ram(); break;
    case 6: options(); break;
    case 7: words(); break;
    default: break;
    }
    results[43] = 0x600d;
    return 0;
}
