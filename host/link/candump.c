#include "host/link/candump.h"

#include <stdio.h>
#include <string.h>

struct text_cursor {
    const char *position;
    const char *end;
};

/* value of a hexadecimal digit, plus 1; 0: not a digit */
static const uint8_t hex_value_plus_1[256] = {
    ['0'] = 1,  ['1'] = 2,  ['2'] = 3,  ['3'] = 4,  ['4'] = 5,  ['5'] = 6,  ['6'] = 7,  ['7'] = 8,
    ['8'] = 9,  ['9'] = 10, ['A'] = 11, ['B'] = 12, ['C'] = 13, ['D'] = 14, ['E'] = 15, ['F'] = 16,
    ['a'] = 11, ['b'] = 12, ['c'] = 13, ['d'] = 14, ['e'] = 15, ['f'] = 16};

/* Returns the value of a hexadecimal digit; a result above 15 means that the character is not a
 * digit. */
static uint32_t parse_hex_digit(char c)
{
    return hex_value_plus_1[(uint8_t)c] - 1u;
}

static bool accept_char(struct text_cursor *at, char c)
{
    if (at->position == at->end || *at->position != c)
        return false;
    at->position++;
    return true;
}

/* Skips blanks: some programs align the fields with them. */
static bool skip_blanks(struct text_cursor *at)
{
    const char *from = at->position;
    while (accept_char(at, ' ') || accept_char(at, '\t'))
        ;
    return at->position > from;
}

/* Parses decimal digits and returns their number. */
static unsigned parse_decimal(struct text_cursor *at, uint64_t *value)
{
    unsigned digits = 0;
    *value = 0;
    for (; at->position < at->end && *at->position >= '0' && *at->position <= '9' && digits < 18;
         at->position++, digits++)
        *value = *value * 10 + (uint64_t)(*at->position - '0');
    return digits;
}

static bool parse_time(struct text_cursor *at, uint64_t *us)
{
    uint64_t seconds, fraction;
    if (!accept_char(at, '(') || parse_decimal(at, &seconds) == 0 || seconds > 0xffffffffffull ||
        !accept_char(at, '.'))
        return false;
    unsigned digits = parse_decimal(at, &fraction);
    if (digits == 0 || digits > 9 || !accept_char(at, ')'))
        return false;
    for (; digits < 6; digits++)
        fraction *= 10;
    for (; digits > 6; digits--)
        fraction /= 10;
    *us = seconds * 1000000u + fraction;
    return true;
}

static bool parse_id(struct text_cursor *at, uint32_t *id)
{
    uint32_t value = 0;
    unsigned digits = 0;
    for (; at->position < at->end && parse_hex_digit(*at->position) < 16; at->position++) {
        if (++digits > 8)
            return false;
        value = value << 4 | parse_hex_digit(*at->position);
    }
    if (digits == 3 && value <= 0x7ff)
        *id = value;
    else if (digits == 8 && value & LINK_ID_ERROR && value <= (LINK_ID_ERROR | 0x1fffffff))
        *id = value;
    else if (digits == 8 && value <= 0x1fffffff)
        *id = value | LINK_ID_EXTENDED;
    else
        return false;
    return true;
}

static bool parse_data(struct text_cursor *at, struct link_frame *frame)
{
    frame->length = 0;
    memset(frame->data, 0, sizeof frame->data);
    if (!(frame->id & LINK_ID_ERROR) && accept_char(at, 'R')) {
        frame->id |= LINK_ID_REMOTE;
        if (at->position < at->end && *at->position >= '0' && *at->position <= '8')
            frame->length = (uint8_t)(*at->position++ - '0');
        return true;
    }
    while (at->position < at->end && !strchr(" \t\r_", *at->position)) {
        if (frame->length == 8 || at->end - at->position < 2)
            return false;
        uint32_t high = parse_hex_digit(at->position[0]);
        uint32_t low = parse_hex_digit(at->position[1]);
        if ((high | low) > 15)
            return false;
        frame->data[frame->length++] = (uint8_t)(high << 4 | low);
        at->position += 2;
    }
    return true;
}

/* Skips a length code above 8 ("_9" to "_F"), which is allowed only after 8 bytes. */
static bool parse_length_code(struct text_cursor *at, const struct link_frame *frame)
{
    if (!accept_char(at, '_'))
        return true;
    uint32_t code = at->position < at->end ? parse_hex_digit(*at->position) : 0;
    if (frame->length != 8 || code < 9 || code > 15)
        return false;
    at->position++;
    return true;
}

static bool parse_line(struct text_cursor *at, struct candump_line *line)
{
    struct link_frame *frame = &line->frame;
    if (!parse_time(at, &frame->host_us) || !skip_blanks(at))
        return false;
    line->interface = at->position;
    while (at->position < at->end && *at->position != ' ' && *at->position != '\t')
        at->position++;
    line->interface_length = (size_t)(at->position - line->interface);
    if (line->interface_length == 0 || !skip_blanks(at) || !parse_id(at, &frame->id) ||
        !accept_char(at, '#') || !parse_data(at, frame) || !parse_length_code(at, frame))
        return false;
    if (skip_blanks(at) && (accept_char(at, 'R') || accept_char(at, 'T')))
        skip_blanks(at);
    accept_char(at, '\r');
    return at->position == at->end;
}

enum mr_status candump_parse_line(const char *text, size_t length, struct candump_line *line)
{
    struct text_cursor at = {text, text + length};
    bool whole = parse_line(&at, line);
    line->error_column = (size_t)(at.position - text) + 1;
    return whole ? MR_OK : MR_MALFORMED;
}

/* ---- a log ---- */

void parse_result_set(struct parse_result *result, enum mr_status status, size_t line,
                      size_t column, const char *what)
{
    if (result->status != MR_OK)
        return;
    result->status = status;
    result->line = line;
    result->column = column;
    result->fault_text = what;
}

void parse_result_text(const struct parse_result *result, char *out, size_t size)
{
    if (result->status == MR_OK) {
        snprintf(out, size, "complete");
        return;
    }
    int n = snprintf(out, size, "%s at line %zu, column %zu: %s",
                     result->status == MR_TRUNCATED ? "truncated" : "malformed", result->line,
                     result->column, result->fault_text);
    if (result->bad_lines && n > 0 && (size_t)n < size)
        snprintf(out + n, size - (size_t)n, "; %zu %s skipped", result->bad_lines,
                 result->bad_lines == 1 ? "line was" : "lines were");
}

bool candump_is_from_interface(const struct candump_line *line, const char *interface)
{
    return line->interface_length == strlen(interface) &&
           memcmp(line->interface, interface, line->interface_length) == 0;
}

bool candump_log_parse_line(struct candump_log *log, const char *text, size_t length, bool whole,
                            struct candump_line *line)
{
    /* Skips text before the first frame: a UTF-8 byte order mark, or candump's "Warning: console
     * output active while logging!". */
    const char *begin = log->line_number++ == 0 ? memchr(text, '(', length) : NULL;
    size_t before = begin ? (size_t)(begin - text) : 0;
    text += before;
    length -= before;
    if (length == 0)
        return false;
    enum mr_status status = candump_parse_line(text, length, line);
    /* without a newline the line may be incomplete, even if its beginning is a valid frame */
    if (!whole) {
        parse_result_set(&log->result, MR_TRUNCATED, log->line_number, before + length + 1,
                         "the log ends within a line");
        return false;
    }
    if (status != MR_OK) {
        log->result.bad_lines++;
        parse_result_set(&log->result, MR_MALFORMED, log->line_number, before + line->error_column,
                         memmem(text, length, "##", 2)
                             ? "the line has a CAN FD frame, which matrig does not read"
                             : "the line is not in the format of `candump -L`");
        return false;
    }
    if (!log->interface[0] || candump_is_from_interface(line, log->interface))
        return true;
    log->other_interface_frames++;
    return false;
}

enum mr_status candump_parse(const char *text, size_t length, struct link_frame *frame)
{
    struct candump_line line;
    enum mr_status status = candump_parse_line(text, length, &line);
    *frame = line.frame;
    return status;
}

size_t candump_write_line(const struct link_frame *frame, char out[CANDUMP_LINE_SIZE])
{
    bool wide = (frame->id & (LINK_ID_EXTENDED | LINK_ID_ERROR)) != 0;
    uint32_t id = frame->id & ~(LINK_ID_EXTENDED | LINK_ID_REMOTE);
    int length = snprintf(out, CANDUMP_LINE_SIZE, "(%010llu.%06llu) can0 %0*X#",
                          (unsigned long long)(frame->host_us / 1000000u),
                          (unsigned long long)(frame->host_us % 1000000u), wide ? 8 : 3,
                          (unsigned)id);
    if (frame->id & LINK_ID_REMOTE) {
        length += snprintf(out + length, CANDUMP_LINE_SIZE - (size_t)length, "R%u", frame->length);
    } else {
        for (unsigned i = 0; i < frame->length; i++)
            length += snprintf(out + length, CANDUMP_LINE_SIZE - (size_t)length, "%02X",
                               frame->data[i]);
    }
    length += snprintf(out + length, CANDUMP_LINE_SIZE - (size_t)length, "\n");
    return (size_t)length;
}
