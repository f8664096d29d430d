/* Lines of text, 8N1 at SAY_BAUD:
 *
 *     begin SECTION FORMAT
 *     NAME VALUE UNIT            value: a number, 0x and hexadecimal digits, a word, or none
 *     ...
 *     end SECTION LINES CRC      lines in between; CRC-32 (common/crc32.h), eight hexadecimal
 *                                digits, of all bytes from `begin` to the newline before `end`
 *
 * so that a reader sees what is cut off or damaged. Lines and CRC go on through a reset. */
#ifndef MATRIG_FIRMWARE_BRINGUP_SAY_H
#define MATRIG_FIRMWARE_BRINGUP_SAY_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/f407/regs.h"

#define SAY_BAUD   115200u
#define SAY_FORMAT 1

void say_begin(const char *section);
void say_end(void);

void say_number(const char *name, int32_t value, const char *unit);
/* A thousandth is the least digit: 2013 is printed as 2.013. */
void say_milli(const char *name, int32_t thousandths, const char *unit);
void say_hex(const char *name, uint32_t value, const char *unit);
void say_word(const char *name, const char *word, const char *unit);
/* The same with a name of two parts; upper case is printed in lower case. */
void say_milli_of(const char *what, const char *whose, int32_t thousandths, const char *unit);
/* `name` has no value: the part is absent, or did not answer. */
void say_none(const char *name, const char *unit);

/* A line for people, outside sections. */
void say_text(const char *text);
/* Until all has left; bounded. */
void say_flush(void);

/* ---- pace ---- */

/* Time by the core's cycle counter, which goes as long as the core does: bounds of all waits here.
 * It wraps after 25 s at 168 MHz. PM0214 has no DWT; ARMv7-M C1.8. */

#define PACE_MHZ 168u

void pace_start(void);

static inline uint32_t pace_begin(void)
{
    return DWT_CYCCNT;
}
static inline uint32_t pace_cycles(uint32_t begun)
{
    return DWT_CYCCNT - begun;
}
/* So many microseconds have passed, 20 s at most. Feeds the watchdog. */
bool pace_passed(uint32_t begun, uint32_t us);
void pace_wait(uint32_t us);

#endif
