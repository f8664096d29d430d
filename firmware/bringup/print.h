/* Output of text lines on serial, 8N1 at PRINT_BAUD:
 *
 *     begin SECTION FORMAT
 *     NAME VALUE UNIT            value: a number, 0x and hexadecimal digits, a word, or "none"
 *     ...
 *     end SECTION LINES CRC      lines in between; CRC-32 (common/crc32.h), eight hexadecimal
 *                                digits, of all bytes from `begin` to the newline before `end`
 *
 * The line count and the CRC let a reader detect truncated or damaged sections. A section may
 * continue after a reset. */
#ifndef MATRIG_FIRMWARE_BRINGUP_PRINT_H
#define MATRIG_FIRMWARE_BRINGUP_PRINT_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/f407/regs.h"

#define PRINT_BAUD   115200u
#define PRINT_FORMAT 1

/* Begin and end a section. */
void print_begin(const char *section);
void print_end(void);

/* Print a line with a value inside a section. */
void print_number(const char *name, int32_t value, const char *unit);
/* Prints a value given in thousandths: 2013 is printed as 2.013. */
void print_milli(const char *name, int32_t thousandths, const char *unit);
void print_hex(const char *name, uint32_t value, const char *unit);
void print_word(const char *name, const char *word, const char *unit);
/* As print_milli, with a name in two parts; upper case is printed in lower case. */
void print_named_milli(const char *what, const char *whose, int32_t thousandths, const char *unit);
/* Prints that `name` has no value because the part is absent or did not respond. */
void print_missing(const char *name, const char *unit);

/* Prints a line for people, outside sections. */
void print_text(const char *text);
/* Waits until all output has been sent; the wait is bounded. */
void print_flush(void);

/* ---- bounded waits ---- */

/* Time from the core's cycle counter, which counts while the core does not sleep. It limits all
 * waits here and wraps after 25 s at 168 MHz. PM0214 does not describe the DWT; see ARMv7-M
 * C1.8. */

#define CYCLE_TIMER_MHZ 168u

void cycle_timer_start(void);

static inline uint32_t cycle_timer_now(void)
{
    return DWT_CYCCNT;
}
static inline uint32_t cycle_timer_elapsed(uint32_t start)
{
    return DWT_CYCCNT - start;
}
/* True once `us` microseconds (at most 20 s) have passed since `start`. Also resets the counter of
 * the watchdog. */
bool cycle_timer_has_passed(uint32_t start, uint32_t us);
void cycle_timer_wait(uint32_t us);

#endif
