#include "host/link/hearing.h"

#include <math.h>
#include <string.h>

#define LEAST_BYTES 100u /* for a judgement */
#define OFTEN       0.05 /* a length that the data has, not one that noise made */
/* So far may the rate be from the one that the lengths say: a byte has fewer of them the slower the
 * sender is. */
#define SURE_TIMES  3.0
#define SURE        1.04
#define UNSURE      1.12

void hearing_start(struct hearing *hearing, uint64_t now_us, int baud)
{
    memset(hearing, 0, sizeof *hearing);
    hearing->begun_us = now_us;
    hearing->baud = baud;
    mr_deframer_init(&hearing->deframer);
}

/* Bit 0: the start bit, then the data, least bit first, as they came over the line. */
static void look_at(struct hearing *hearing, uint8_t byte)
{
    unsigned line = (unsigned)byte << 1, length = 1, level = 0;
    bool first = true;
    for (unsigned i = 1; i < HEARING_SAMPLES - 1; i++) {
        if ((line >> i & 1u) == level) {
            length++;
            continue;
        }
        (first ? hearing->lead : hearing->inner)[length]++;
        first = false;
        level = !level;
        length = 1;
    }
    if (first)
        hearing->lead[HEARING_SAMPLES - 1]++;
}

void hearing_bytes(struct hearing *hearing, const uint8_t *bytes, size_t length)
{
    hearing->bytes += length;
    for (size_t i = 0; i < length && hearing->frames == 0; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&hearing->deframer, bytes[i], &frame);
        hearing->frames += status == MR_OK;
        hearing->bad += status != MR_OK && status != MR_TOO_FEW;
        look_at(hearing, bytes[i]);
    }
}

/* Samples of one bit: the mean of the lengths that are not yet those of two bits. */
static double samples_of_a_bit(const struct hearing *hearing, unsigned shortest)
{
    double samples = 0.0, count = 0.0;
    for (unsigned n = shortest; n < HEARING_SAMPLES - 1 && (double)n <= 1.5 * (double)shortest;
         n++) {
        double times = (double)(hearing->lead[n] + hearing->inner[n]);
        samples += times * (double)n;
        count += times;
    }
    return count > 0.0 ? samples / count : (double)shortest;
}

double hearing_times_slower(const struct hearing *hearing)
{
    uint64_t bytes = 0;
    for (unsigned n = 1; n < HEARING_SAMPLES; n++)
        bytes += hearing->lead[n];
    if (bytes < LEAST_BYTES)
        return 0.0;
    for (unsigned n = 1; n < HEARING_SAMPLES; n++) {
        if ((double)hearing->lead[n] < OFTEN * (double)bytes)
            continue;
        return n == 1                   ? 1.0
             : n == HEARING_SAMPLES - 1 ? (double)INFINITY
                                        : samples_of_a_bit(hearing, n);
    }
    return 0.0;
}

const int *hearing_usual_bauds(void)
{
    static const int bauds[] = {2000000, 115200,  921600, 1000000, 460800, 230400, 500000, 576000,
                                1500000, 3000000, 57600,  38400,   19200,  9600,   0};
    return bauds;
}

unsigned hearing_usual_near(int baud, double slower, int near[HEARING_USUAL])
{
    double sure = slower < SURE_TIMES ? SURE : UNSURE;
    unsigned count = 0;
    for (const int *usual = hearing_usual_bauds(); *usual && count < HEARING_USUAL; usual++) {
        double ratio = (double)baud / slower / (double)*usual;
        if (ratio < sure && ratio > 1.0 / sure)
            near[count++] = *usual;
    }
    return count;
}
