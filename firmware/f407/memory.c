/* Memory tests: tests RAM in use and the program in small steps while idle, and measures the depth
 * of the stack.
 *
 * RAM in use is tested four words at a time, in registers alone and with interrupts masked, by
 * March C- (van de Goor 1991: up w0; up r0 w1; up r1 w0; down r0 w1; down r1 w0; r0) with two data
 * patterns; then the content is restored. This detects bits that are stuck or coupled within the
 * four words, but not faults of address lines. DMA buffers are tested once, at start, because DMA
 * cannot be masked. */
#include <string.h>

#include "common/fault.h"
#include "common/crc32.h"
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define STACK_PATTERN     0x5afe57acu
#define WINDOW_WORDS      4u
#define SLICE_WINDOWS     8u
#define FLASH_SLICE_BYTES 128u
/* an active stream may write up to this number of bytes after its address */
#define DMA_REACH_BYTES   1024u
#define STREAM_COUNT      16u

/* linker script */
extern uint32_t stack_bottom[], stack_top[], dma_start[], dma_end[], ram_used_end[];
extern const uint8_t program_start[], program_end[];

static struct board_background_tests upkeep;
static uint32_t *next_window;          /* next window to be tested */
static const uint8_t *next_flash_byte; /* next byte for the checksum of the program */
static uint32_t flash_crc, image_crc;

/* Returns the bits of four words that failed. The test may cover the stack itself, so it uses only
 * registers; the stack content is restored before it is used. */
static __attribute__((naked, noinline)) uint32_t march_test(__attribute__((unused)) uint32_t *words,
                                                            __attribute__((unused))
                                                            uint32_t background)
{
#define MARCH_ELEMENT(offset, expected, written)                                             \
    "ldr r8, [r0, #" #offset "]\n\t eor r8, " #expected "\n\t orr r12, r8\n\t str " #written \
    ", [r0, #" #offset "]\n\t"
    __asm volatile(
        "push {r4-r8, lr}\n\t"
        "mrs r3, primask\n\t"
        "cpsid i\n\t"
        "ldmia r0, {r4-r7}\n\t"
        "mvn r2, r1\n\t"
        "mov r12, #0\n\t"
        "str r1, [r0]\n\t str r1, [r0, #4]\n\t str r1, [r0, #8]\n\t str r1, [r0, "
        "#12]\n\t" MARCH_ELEMENT(0, r1, r2) MARCH_ELEMENT(4, r1, r2) MARCH_ELEMENT(8, r1, r2)
            MARCH_ELEMENT(12, r1, r2) MARCH_ELEMENT(0, r2, r1) MARCH_ELEMENT(4, r2, r1)
                MARCH_ELEMENT(8, r2, r1) MARCH_ELEMENT(12, r2, r1) MARCH_ELEMENT(12, r1, r2)
                    MARCH_ELEMENT(8, r1, r2) MARCH_ELEMENT(4, r1, r2) MARCH_ELEMENT(0, r1, r2)
                        MARCH_ELEMENT(12, r2, r1) MARCH_ELEMENT(8, r2, r1) MARCH_ELEMENT(4, r2, r1)
                            MARCH_ELEMENT(0, r2, r1) MARCH_ELEMENT(0, r1, r4)
                                MARCH_ELEMENT(4, r1, r5) MARCH_ELEMENT(8, r1, r6)
                                    MARCH_ELEMENT(12, r1, r7) "msr primask, r3\n\t"
                                                              "mov r0, r12\n\t"
                                                              "pop {r4-r8, pc}");
#undef MARCH_ELEMENT
}

static void fail_ram(const uint32_t *words)
{
    if (!upkeep.is_ram_bad)
        upkeep.bad_address = (uint32_t)(uintptr_t)words;
    upkeep.is_ram_bad = true;
    health_count_fault(MR_FAULT_SELFTEST, MR_SELF_TEST_RAM);
}

static bool is_window_good(uint32_t *words)
{
    return (march_test(words, 0x00000000u) | march_test(words, 0x55555555u)) == 0;
}

void memory_start(void)
{
    uint32_t *sp;
    __asm volatile("mov %0, sp" : "=r"(sp));
    for (volatile uint32_t *p = stack_bottom; p < sp - 16; p++)
        *p = STACK_PATTERN;
    for (uint32_t *p = dma_start; p < dma_end; p += WINDOW_WORDS) {
        if (!is_window_good(p))
            fail_ram(p);
    }
    board_restart_memory_test();
}

void memory_set_image_crc(uint32_t crc)
{
    image_crc = crc;
}

/* Stores the addresses that active streams write to or read from, and returns their number. During
 * the test, no other stream can start, except one with a DMA buffer, because streams are started by
 * the main loop, which runs the test. */
static unsigned find_active_streams(uint32_t address[STREAM_COUNT])
{
    unsigned count = 0;
    for (unsigned i = 0; i < STREAM_COUNT; i++) {
        const struct dma_stream_regs *stream = &(i < 8 ? DMA1 : DMA2)->stream[i % 8];
        uint32_t cr = stream->CR;
        if (cr & DMA_CR_EN && cr & DMA_CR_MINC)
            address[count++] = stream->M0AR;
    }
    return count;
}

static bool is_used_by_dma(const uint32_t *words, const uint32_t *address, unsigned count)
{
    uint32_t place = (uint32_t)(uintptr_t)words;
    if (words >= dma_start && words < dma_end)
        return true;
    for (unsigned i = 0; i < count; i++) {
        if (place + 4u * WINDOW_WORDS > address[i] && place < address[i] + DMA_REACH_BYTES)
            return true;
    }
    return false;
}

static void test_ram(void)
{
    uint32_t address[STREAM_COUNT];
    unsigned count = find_active_streams(address);
    for (unsigned i = 0; i < SLICE_WINDOWS; i++) {
        if (!is_used_by_dma(next_window, address, count) && !is_window_good(next_window))
            fail_ram(next_window);
        next_window += WINDOW_WORDS;
        if (next_window >= ram_used_end) {
            next_window = stack_bottom;
            upkeep.ram_test_count =
                (uint16_t)(upkeep.ram_test_count + (upkeep.ram_test_count < UINT16_MAX));
        }
    }
}

static void check_flash(void)
{
    size_t left = (size_t)(program_end - next_flash_byte);
    size_t length = left < FLASH_SLICE_BYTES ? left : FLASH_SLICE_BYTES;
    flash_crc = mr_crc32(flash_crc, next_flash_byte, length);
    next_flash_byte += length;
    if (next_flash_byte < program_end)
        return;
    if (flash_crc != image_crc) {
        upkeep.is_flash_bad = true;
        health_count_fault(MR_FAULT_SELFTEST, MR_SELF_TEST_FLASH);
    }
    upkeep.flash_check_count =
        (uint16_t)(upkeep.flash_check_count + (upkeep.flash_check_count < UINT16_MAX));
    next_flash_byte = program_start;
    flash_crc = 0;
}

void board_check_memory(void)
{
    test_ram();
    check_flash();
}

void board_restart_memory_test(void)
{
    next_window = stack_bottom;
    next_flash_byte = program_start;
    flash_crc = 0;
}

void board_get_background_tests(struct board_background_tests *out)
{
    const uint32_t *p = stack_bottom;
    while (p < stack_top && *p == STACK_PATTERN)
        p++;
    upkeep.stack_used = (uint16_t)(4 * (stack_top - p));
    upkeep.stack_size = (uint16_t)(4 * (stack_top - stack_bottom));
    *out = upkeep;
}
