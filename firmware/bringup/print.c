#include "firmware/bringup/print.h"

#include <string.h>

#include "common/crc32.h"
#include "firmware/f407/drivers.h"

#define LINE_BYTES      80u
/* time limit for sending; uart.c sends its ring of 8 KiB in 0.7 s */
#define SEND_TIMEOUT_US 2000000u
#define LAST_BYTES_US   200u /* two bytes last 174 us */

/* Not cleared at a reset. print_begin overwrites the random content that it has at power on. */
static struct {
    uint32_t lines, crc;
    char section[12];
} line_text __attribute__((section(".noinit")));

struct line {
    char bytes[LINE_BYTES];
    size_t length;
};

static void put_char(struct line *line, char c)
{
    if (line->length < LINE_BYTES - 1u) /* keep room for the newline */
        line->bytes[line->length++] = c;
}

static void put_text(struct line *line, const char *word)
{
    while (*word)
        put_char(line, *word++);
}

static void put_lower(struct line *line, const char *word)
{
    for (; *word; word++)
        put_char(line, *word >= 'A' && *word <= 'Z' ? (char)(*word + 'a' - 'A') : *word);
}

static void put_digits(struct line *line, uint32_t value, unsigned least)
{
    char digits[10];
    unsigned count = 0;
    for (; value || count < least; value /= 10u)
        digits[count++] = (char)('0' + value % 10u);
    while (count)
        put_char(line, digits[--count]);
}

static void put_hex(struct line *line, uint32_t value, unsigned least)
{
    unsigned digits = 8;
    while (digits > least && !(value >> (4u * (digits - 1u))))
        digits--;
    while (digits--)
        put_char(line, "0123456789abcdef"[value >> (4u * digits) & 15u]);
}

static uint32_t put_sign(struct line *line, int32_t value)
{
    if (value < 0)
        put_char(line, '-');
    return value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
}

static void send_line(struct line *line)
{
    uint32_t start = cycle_timer_now();
    line->bytes[line->length++] = '\n';
    while (!board_serial_send((const uint8_t *)line->bytes, line->length) &&
           !cycle_timer_has_passed(start, SEND_TIMEOUT_US)) {
    }
}

/* Sends a line and includes it in the section's line count and CRC. */
static void send_counted(struct line *line)
{
    send_line(line);
    line_text.crc = mr_crc32(line_text.crc, (const uint8_t *)line->bytes, line->length);
    line_text.lines++;
}

static void end_line(struct line *line, const char *unit)
{
    put_char(line, ' ');
    put_text(line, unit);
    send_counted(line);
}

static struct line begin_line(const char *what, const char *whose)
{
    struct line line = {.length = 0};
    put_text(&line, what);
    put_lower(&line, whose);
    put_char(&line, ' ');
    return line;
}

void print_begin(const char *section)
{
    struct line line = {.length = 0};
    memset(&line_text, 0, sizeof line_text);
    strncpy(line_text.section, section, sizeof line_text.section - 1u);
    put_text(&line, "begin ");
    put_text(&line, line_text.section);
    put_char(&line, ' ');
    put_digits(&line, PRINT_FORMAT, 1);
    send_counted(&line);
    line_text.lines = 0;
}

void print_end(void)
{
    struct line line = {.length = 0};
    put_text(&line, "end ");
    put_text(&line, line_text.section);
    put_char(&line, ' ');
    put_digits(&line, line_text.lines, 1);
    put_char(&line, ' ');
    put_hex(&line, line_text.crc, 8);
    send_line(&line);
}

void print_number(const char *name, int32_t value, const char *unit)
{
    struct line line = begin_line(name, "");
    put_digits(&line, put_sign(&line, value), 1);
    end_line(&line, unit);
}

void print_named_milli(const char *what, const char *whose, int32_t thousandths, const char *unit)
{
    struct line line = begin_line(what, whose);
    uint32_t size = put_sign(&line, thousandths);
    put_digits(&line, size / 1000u, 1);
    put_char(&line, '.');
    put_digits(&line, size % 1000u, 3);
    end_line(&line, unit);
}

void print_milli(const char *name, int32_t thousandths, const char *unit)
{
    print_named_milli(name, "", thousandths, unit);
}

void print_hex(const char *name, uint32_t value, const char *unit)
{
    struct line line = begin_line(name, "");
    put_text(&line, "0x");
    put_hex(&line, value, 1);
    end_line(&line, unit);
}

void print_word(const char *name, const char *word, const char *unit)
{
    struct line line = begin_line(name, "");
    put_text(&line, word);
    end_line(&line, unit);
}

void print_missing(const char *name, const char *unit)
{
    print_word(name, "none", unit);
}

void print_text(const char *words)
{
    struct line line = {.length = 0};
    put_text(&line, words);
    send_line(&line);
}

void print_flush(void)
{
    uint32_t start = cycle_timer_now();
    while (!uart_is_sent() && !cycle_timer_has_passed(start, SEND_TIMEOUT_US)) {
    }
    cycle_timer_wait(LAST_BYTES_US);
}

/* ---- bounded waits ---- */

void cycle_timer_start(void)
{
    SCB_DEMCR |= SCB_DEMCR_TRCENA;
    DWT_CTRL |= DWT_CTRL_CYCCNTENA;
}

bool cycle_timer_has_passed(uint32_t start, uint32_t us)
{
    watchdog_feed();
    return cycle_timer_elapsed(start) / CYCLE_TIMER_MHZ >= us;
}

void cycle_timer_wait(uint32_t us)
{
    uint32_t start = cycle_timer_now();
    while (!cycle_timer_has_passed(start, us)) {
    }
}
