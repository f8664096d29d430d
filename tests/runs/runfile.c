/* Writing run files; see runfile.h. */
#include "tests/runs/runfile.h"

#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define PATH_BYTES 4096

void syn_run_clear(struct syn_run *run)
{
    run->used = 0;
    run->full = false;
    run->repeats = 0;
    run->has_row = false;
}

void syn_run_add(struct syn_run *run, const char *format, ...)
{
    size_t room = sizeof run->text - run->used;
    va_list arguments;
    int length;

    va_start(arguments, format);
    length = vsnprintf(run->text + run->used, room, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= room)
        run->full = true;
    else
        run->used += (size_t)length;
}

void syn_run_numbers(struct syn_run *run, const char *keyword, const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        if (i % 10 == 0)
            syn_run_add(run, "%s%s", i == 0 ? "" : "\n", keyword);
        syn_run_add(run, " %.7f", values[i]);
    }
    syn_run_add(run, "\n");
}

static void flush_repeats(struct syn_run *run)
{
    if (run->repeats > 0)
        syn_run_add(run, "x%u\n", run->repeats);
    run->repeats = 0;
}

void syn_run_sample(struct syn_run *run, const long *row)
{
    if (run->has_row && memcmp(run->row, row, sizeof run->row) == 0) {
        run->repeats++;
        return;
    }
    flush_repeats(run);
    for (int i = 0; i < SYN_SAMPLE_CHANNELS; i++)
        syn_run_add(run, "%s%ld", i == 0 ? "" : " ", row[i]);
    syn_run_add(run, "\n");
    memcpy(run->row, row, sizeof run->row);
    run->has_row = true;
}

/* CRC-32 of IEEE 802.3, bit by bit: polynomial 0x04C11DB7 reflected, start and final xor all
 * ones. */
static uint32_t crc32_of(const char *bytes, size_t count)
{
    uint32_t crc = UINT32_MAX;

    for (size_t i = 0; i < count; i++) {
        crc ^= (unsigned char)bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

bool syn_run_write(struct syn_run *run, const char *path)
{
    char beside[PATH_BYTES];
    FILE *file;
    bool written;

    flush_repeats(run);
    syn_run_add(run, "end %08x\n", (unsigned)crc32_of(run->text, run->used));
    if (run->full) {
        errno = EFBIG;
        return false;
    }
    if (snprintf(beside, sizeof beside, "%s.part", path) >= (int)sizeof beside) {
        errno = ENAMETOOLONG;
        return false;
    }
    file = fopen(beside, "wb");
    if (file == NULL)
        return false;
    written = fwrite(run->text, 1, run->used, file) == run->used;
    if (fclose(file) != 0)
        written = false;
    if (!written || rename(beside, path) != 0) {
        int reason = errno;

        (void)remove(beside);
        errno = reason;
        return false;
    }
    return true;
}
