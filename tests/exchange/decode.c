/* How fast a candump log is decoded into memory: every frame into an array, every value of the
 * catalogue's messages into another. usage: decode LOG; prints frames, values and frames a second
 * of processor time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/catalogue.h"
#include "common/wire.h"
#include "host/exchange/import.h"

/* characters of the shortest line there is: (0.0) c 123#, and a newline, less some */
#define LINE_LEAST 20u

static double processor_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* What a tool does that knows the signals: place, size, sign, factor. */
static double value_of(const struct mr_field_info *field, const uint8_t *data)
{
    const uint8_t *p = data + field->offset;
    double factor = field->per_unit > 0.0f ? 1.0 / (double)field->per_unit : 1.0;
    switch (field->type) {
    case MR_WIRE_u8: return (double)*p;
    case MR_WIRE_i8: return (double)(int8_t)*p;
    case MR_WIRE_u16: return factor * (double)mr_get_u16(&p);
    case MR_WIRE_i16: return factor * (double)(int16_t)mr_get_u16(&p);
    case MR_WIRE_u32: return (double)mr_get_u32(&p);
    case MR_WIRE_i32: return (double)(int32_t)mr_get_u32(&p);
    default: break;
    }
    uint32_t bits = mr_get_u32(&p);
    float real;
    memcpy(&real, &bits, sizeof real);
    return (double)real;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    struct textfile file;
    struct candump_log log;
    struct candump_line line;
    size_t frames = 0, values = 0;
    static const struct mr_message_info *info[0x800];
    for (unsigned id = 0; id < 0x800; id++)
        info[id] = mr_message_find((uint16_t)id);
    if (argc != 2 || textfile_open(argv[1], &file, &error) != MR_OK) {
        fprintf(stderr, "usage: decode LOG %s\n", error.text);
        return 2;
    }
    double begun_s = processor_s();
    struct link_frame *frame = malloc((file.length / LINE_LEAST + 1) * sizeof *frame);
    double *value = malloc((file.length / LINE_LEAST + 1) * 4 * sizeof *value);
    candump_log_start(&log, file.text, file.length, NULL);
    while (frame && value && candump_log_next(&log, &line)) {
        frame[frames++] = line.frame;
        const struct mr_message_info *m = line.frame.id < 0x800 ? info[line.frame.id] : NULL;
        for (unsigned f = 0; m && f < m->field_count && m->length == line.frame.length &&
                             values < 4 * (file.length / LINE_LEAST);
             f++)
            value[values++] = value_of(&m->fields[f], line.frame.data);
    }
    double took_s = processor_s() - begun_s, sum = 0.0;
    for (size_t i = 0; value && i < values; i++)
        sum += isfinite(value[i]) ? value[i] : 0.0;
    printf("%zu %zu %.0f %g\n", frames, values, (double)frames / took_s, sum);
    free(frame);
    free(value);
    textfile_close(&file);
    return log.verdict.status == MR_OK ? 0 : 1;
}
