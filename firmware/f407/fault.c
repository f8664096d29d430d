/* A processor fault stores its registers and resets; the next start counts and reports it.
 * Unrequested restarts are counted through resets: after QUIET_RESTARTS_MIN in a row the board
 * starts without scans and black box and only communicates. PM0214 2.3.7 (frames), 2.4.4
 * (faults). */
#include <string.h>

#include "common/fault.h"
#include "common/crc32.h"
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define QUIET_RESTARTS_MIN 5u
#define CRYSTAL_STOPS_MAX  2u
#define FRAME_WORDS        8u  /* r0-r3, r12, lr, pc, xpsr */
#define FRAME_FP_WORDS     26u /* size of a frame that also has s0-s15, fpscr and a reserved word */
#define XPSR_ALIGNED       (1u << 9)
#define IPSR_MASK          0x1ffu

extern uint32_t stack_bottom[], stack_top[]; /* linker script */

/* Not cleared at start, so it survives a reset. At power on RAM contains random values, and the CRC
 * does not match. */
static struct {
    uint32_t words[MR_CRASH_ITEM_COUNT];
    uint32_t age;
    uint32_t is_new;
    uint32_t crc;
} crash_record __attribute__((section(".noinit")));

static struct {
    uint8_t restarts, consecutive, late_task, crystal_stops;
    uint32_t late_pc;
    uint32_t image_crc;
    uint32_t crc;
} restart_record __attribute__((section(".noinit")));

static struct board_restart last_restart;

/* r4 to r11 at the fault, stored by processor_fault. */
static uint32_t fault_registers[8] __attribute__((section(".noinit"), used));

static uint32_t compute_words_crc(const void *words, size_t bytes)
{
    return mr_crc32(0, words, bytes);
}

static void seal_crash_record(void)
{
    crash_record.crc = compute_words_crc(&crash_record, offsetof(__typeof__(crash_record), crc));
}

static void seal_restart_record(void)
{
    restart_record.crc = compute_words_crc(&restart_record,
                                           offsetof(__typeof__(restart_record), crc));
}

static void reset_chip(void)
{
    __asm volatile("dsb" ::: "memory");
    SCB_AIRCR = 0x05fa0004u; /* system reset request */
    for (;;) {
    }
}

void processor_fault(void);
void fault_store(const uint32_t *frame, uint32_t exc_return);

/* If the stack pointer is outside the stack, the handler continues at the stack's top. */
__attribute__((naked)) void processor_fault(void)
{
    __asm volatile("ldr r3, =fault_registers\n\t"
                   "stmia r3, {r4-r11}\n\t"
                   "mrs r0, msp\n\t"
                   "mov r1, lr\n\t"
                   "ldr r3, =stack_top\n\t"
                   "ldr r2, =stack_bottom + 256\n\t"
                   "cmp r0, r2\n\t"
                   "blo 1f\n\t"
                   "cmp r0, r3\n\t"
                   "blo 2f\n"
                   "1:\tmsr msp, r3\n"
                   "2:\tldr r2, =fault_store\n\t"
                   "bx r2\n\t"
                   ".ltorg");
}

static uint32_t get_crash_kind(uint32_t exception, uint32_t cfsr)
{
    if (RCC->CIR & RCC_CIR_CSSF) /* the clock security system also raises an NMI */
        return MR_CRASH_CRYSTAL;
    if (exception >= 16)
        return MR_CRASH_UNEXPECTED;
    return cfsr & 0xffu   ? MR_CRASH_MEMORY
         : cfsr & 0xff00u ? MR_CRASH_BUS
         : cfsr >> 16     ? MR_CRASH_USAGE
                          : MR_CRASH_OTHER;
}

static bool is_on_stack(const uint32_t *from, unsigned words)
{
    return from >= stack_bottom && from <= stack_top && (unsigned)(stack_top - from) >= words;
}

void fault_store(const uint32_t *frame, uint32_t exc_return)
{
    static const uint8_t stacked[FRAME_WORDS] = {MR_CRASH_R0, MR_CRASH_R1,  MR_CRASH_R2,
                                                 MR_CRASH_R3, MR_CRASH_R12, MR_CRASH_LR,
                                                 MR_CRASH_PC, MR_CRASH_XPSR};
    uint32_t *word = crash_record.words;
    uint32_t exception;
    __asm volatile("mrs %0, ipsr" : "=r"(exception));
    memset(word, 0, sizeof crash_record.words);
    word[MR_CRASH_CFSR] = SCB_CFSR;
    word[MR_CRASH_HFSR] = SCB_HFSR;
    word[MR_CRASH_MMFAR] = SCB_MMFAR;
    word[MR_CRASH_BFAR] = SCB_BFAR;
    word[MR_CRASH_EXCEPTION] = exception & IPSR_MASK;
    word[MR_CRASH_KIND] = get_crash_kind(exception & IPSR_MASK, word[MR_CRASH_CFSR]);
    word[MR_CRASH_BLOCK] = health_get_block();
    word[MR_CRASH_TASK] = tasks_current();
    word[MR_CRASH_IMAGE] = restart_record.image_crc;
    memcpy(&word[MR_CRASH_R4], fault_registers, sizeof fault_registers);
    word[MR_CRASH_SP] = (uint32_t)(uintptr_t)frame;
    if (is_on_stack(frame, FRAME_WORDS)) {
        for (unsigned i = 0; i < FRAME_WORDS; i++)
            word[stacked[i]] = frame[i];
        const uint32_t *below = frame + (exc_return & 0x10u ? FRAME_WORDS : FRAME_FP_WORDS) +
                                (frame[7] & XPSR_ALIGNED ? 1 : 0);
        word[MR_CRASH_SP] = (uint32_t)(uintptr_t)below;
        for (unsigned i = 0; i < MR_CRASH_STACK_WORDS && is_on_stack(below + i, 1); i++)
            word[MR_CRASH_STACK_FIRST + i] = below[i];
    }
    crash_record.age = 0;
    crash_record.is_new = 1;
    seal_crash_record();
    reset_chip();
}

/* BOR_LEV: 3 is off, 2 is level 1, 0 is level 3. RM0090 3.9.10 */
static uint8_t get_brown_out_level(void)
{
    return (uint8_t)(3u - (FLASH_OPTCR >> 2 & 3u));
}

static void load_crash_record(void)
{
    if (crash_record.crc !=
        compute_words_crc(&crash_record, offsetof(__typeof__(crash_record), crc))) {
        memset(&crash_record, 0, sizeof crash_record);
        return;
    }
    if (crash_record.is_new)
        health_count_fault(MR_FAULT_HARD_FAULT, (uint8_t)crash_record.words[MR_CRASH_KIND]);
    else if (crash_record.age < UINT16_MAX)
        crash_record.age++;
    last_restart.crash = crash_record.words[MR_CRASH_KIND] ? crash_record.words : NULL;
    last_restart.crash_age = (uint16_t)crash_record.age;
}

bool fault_read_record(uint8_t cause)
{
    bool by_watchdog = (cause & 8u) != 0;
    if (restart_record.crc !=
        compute_words_crc(&restart_record, offsetof(__typeof__(restart_record), crc)))
        memset(&restart_record, 0, sizeof restart_record);
    load_crash_record();
    last_restart.brown_out = get_brown_out_level();
    if (by_watchdog) {
        last_restart.late_task = restart_record.late_task ? restart_record.late_task
                                                          : (uint8_t)tasks_current();
        last_restart.late_pc = restart_record.late_pc;
        health_count_fault(MR_FAULT_TASK_LATE, last_restart.late_task);
    }
    if (by_watchdog || crash_record.is_new) {
        restart_record.restarts =
            (uint8_t)(restart_record.restarts + (restart_record.restarts < UINT8_MAX));
        restart_record.consecutive =
            (uint8_t)(restart_record.consecutive + (restart_record.consecutive < UINT8_MAX));
    } else {
        /* the restart was due to power, the reset button or a command, so the counts start anew */
        restart_record.consecutive = restart_record.crystal_stops = 0;
    }
    if (crash_record.is_new && crash_record.words[MR_CRASH_KIND] == MR_CRASH_CRYSTAL)
        restart_record.crystal_stops =
            (uint8_t)(restart_record.crystal_stops + (restart_record.crystal_stops < UINT8_MAX));
    crash_record.is_new = 0;
    seal_crash_record();
    restart_record.late_task = 0;
    restart_record.late_pc = 0;
    last_restart.restarts = restart_record.restarts;
    last_restart.consecutive = restart_record.consecutive;
    last_restart.is_safe_mode = restart_record.consecutive >= QUIET_RESTARTS_MIN;
    seal_restart_record();
    tasks_start();
    return last_restart.is_safe_mode;
}

bool fault_has_crystal_stopped_twice(void)
{
    return restart_record.crystal_stops >= CRYSTAL_STOPS_MAX;
}

void fault_set_image_crc(uint32_t crc)
{
    restart_record.image_crc = crc;
    seal_restart_record();
}

void board_get_restart(struct board_restart *out)
{
    *out = last_restart;
}

void board_record_late_task(uint8_t task, uint32_t pc)
{
    restart_record.late_task = task;
    restart_record.late_pc = pc;
    seal_restart_record();
}

void board_reset_restart_count(void)
{
    restart_record.consecutive = 0;
    seal_restart_record();
}

void board_reset(void)
{
    reset_chip();
}
