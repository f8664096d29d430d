#include "host/import/signal.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/import/textfile.h"

#define LINE_MAX_DBC 1000u

/* Bit n of the signal from its lowest: its place in the frame. Big-endian signals begin at their
 * highest bit and go on at bit 7 of the next byte. */
static unsigned place_of(const struct import_signal *signal, unsigned n)
{
    if (!signal->big_endian)
        return signal->start_bit + n;
    unsigned from_top = signal->bits - 1 - n;
    unsigned in_order = (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + from_top;
    return (in_order / 8) * 8 + (7 - in_order % 8);
}

bool signal_fits(const struct import_signal *signal, unsigned length)
{
    if (signal->bits == 0 || signal->bits > 64 || signal->start_bit > 63 ||
        (signal->is_float && signal->bits != 32 && signal->bits != 64))
        return false;
    return signal->big_endian
             ? (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + signal->bits <=
                   8 * length
             : signal->start_bit + signal->bits <= 8 * length;
}

bool signal_value(const struct import_signal *signal, const struct link_frame *frame, double *value)
{
    uint64_t raw = 0;
    if (frame->id != signal->id || !signal_fits(signal, frame->length))
        return false;
    for (unsigned n = 0; n < signal->bits; n++) {
        unsigned bit = place_of(signal, n);
        raw |= (uint64_t)(frame->data[bit / 8] >> (bit % 8) & 1u) << n;
    }
    if (signal->is_float && signal->bits == 32) {
        float single;
        uint32_t low = (uint32_t)raw;
        memcpy(&single, &low, sizeof single);
        *value = (double)single;
    } else if (signal->is_float) {
        memcpy(value, &raw, sizeof *value);
    } else if (signal->is_signed && raw >> (signal->bits - 1) & 1u) {
        if (signal->bits < 64)
            raw |= ~0ull << signal->bits;
        *value = (double)(int64_t)raw;
    } else {
        *value = (double)raw;
    }
    *value = *value * signal->factor + signal->offset;
    return isfinite(*value);
}

/* ---- DBC ---- */

struct dbc_place {
    char message[64], signal[64]; /* wanted */
    uint32_t id;                  /* of the message that goes on */
    unsigned length;
    bool inside, found;
};

/* BO_ 801 Name: 8 Sender. False: not well formed. */
static bool take_message(const char *line, struct dbc_place *at)
{
    unsigned long id;
    char name[64];
    if (sscanf(line, " BO_ %lu %63[^: ] : %u", &id, name, &at->length) != 3 || id > 0xffffffffUL ||
        at->length > 64)
        return false;
    at->inside = strcmp(name, at->message) == 0;
    at->id = (uint32_t)id & 0x1fffffffu;
    if (id & LINK_ID_EXTENDED)
        at->id |= LINK_ID_EXTENDED;
    return true;
}

/* SG_ Name : 0|16@1- (0.1,0) [0|100] "mm" Receiver. MR_TOO_FEW: another signal. */
static enum mr_status take_signal(const char *line, struct dbc_place *at,
                                  struct import_signal *signal)
{
    char name[64], multiplex[8] = "", order, sign;
    int head = 0;
    struct import_signal s = {.id = at->id};
    if (sscanf(line, " SG_ %63[^: ] %n", name, &head) != 1)
        return MR_MALFORMED;
    if (line[head] != ':' && sscanf(line + head, "%7[Mm0-9]", multiplex) != 1)
        return MR_MALFORMED;
    const char *colon = strchr(line + head, ':');
    s.unit[0] = '\0';
    if (!colon || sscanf(colon, ": %u|%u@%c%c (%lf,%lf) [%*[^]]] \"%15[^\"]", &s.start_bit, &s.bits,
                         &order, &sign, &s.factor, &s.offset, s.unit) < 6)
        return MR_MALFORMED;
    if (strcmp(name, at->signal) != 0 || !at->inside)
        return MR_TOO_FEW;
    if (multiplex[0])
        return MR_USAGE;
    s.big_endian = order == '0';
    s.is_signed = sign == '-';
    if ((order != '0' && order != '1') || (sign != '-' && sign != '+') ||
        !signal_fits(&s, at->length) || !isfinite(s.factor) || !isfinite(s.offset))
        return MR_MALFORMED;
    *signal = s;
    at->found = true;
    return MR_OK;
}

/* SIG_VALTYPE_ 801 Name : 1; is a single, 2 a double. */
static void take_type(const char *line, const struct dbc_place *at, struct import_signal *signal)
{
    unsigned long id;
    char name[64];
    unsigned type;
    if (at->found && sscanf(line, "SIG_VALTYPE_ %lu %63[^: ] : %u", &id, name, &type) == 3 &&
        strcmp(name, at->signal) == 0 && (uint32_t)(id & 0x1fffffffu) == (signal->id & 0x1fffffffu))
        signal->is_float = type == 1 || type == 2;
}

static enum mr_status take_line(const char *line, struct dbc_place *at,
                                struct import_signal *signal)
{
    while (isspace((unsigned char)*line))
        line++;
    if (strncmp(line, "BO_ ", 4) == 0)
        return take_message(line, at) ? MR_TOO_FEW : MR_MALFORMED;
    if (strncmp(line, "SG_ ", 4) == 0)
        return take_signal(line, at, signal);
    if (strncmp(line, "SIG_VALTYPE_ ", 13) == 0)
        take_type(line, at, signal);
    return MR_TOO_FEW;
}

enum mr_status signal_from_dbc_text(const char *text, size_t length, const char *path,
                                    const char *name, struct import_signal *signal,
                                    struct error *error)
{
    struct dbc_place at = {0};
    const char *end = text + length;
    if (sscanf(name, "%63[^.].%63s", at.message, at.signal) != 2)
        return error_set(error, MR_USAGE, "no signal: '%s'; write it as Message.Signal of %s", name,
                         path);
    for (size_t number = 1; text < end; number++) {
        char line[LINE_MAX_DBC];
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        size_t count = (size_t)((newline ? newline : end) - text);
        snprintf(line, sizeof line, "%.*s", (int)(count < sizeof line ? count : sizeof line - 1),
                 text);
        enum mr_status status = take_line(line, &at, signal);
        if (status == MR_MALFORMED)
            return error_set(error, status, "no line of a DBC file: %s line %zu; mend it", path,
                             number);
        if (status == MR_USAGE)
            return error_set(error, status,
                             "a multiplexed signal: %s line %zu, %s; export one that is not", path,
                             number, name);
        text += count + 1;
    }
    if (at.found && !signal_fits(signal, 8))
        return error_set(error, MR_MALFORMED,
                         "not in a frame of 8 bytes: %s of %s; CAN FD is not understood", name,
                         path);
    return at.found ? MR_OK
                    : error_set(error, MR_UNKNOWN,
                                "no such signal: %s in %s; write it as Message.Signal", name, path);
}

enum mr_status signal_from_dbc(const char *path, const char *name, struct import_signal *signal,
                               struct error *error)
{
    struct textfile file;
    enum mr_status status = textfile_open(path, &file, error);
    if (status == MR_OK)
        status = signal_from_dbc_text(file.text, file.length, path, name, signal, error);
    textfile_close(&file);
    return status;
}
