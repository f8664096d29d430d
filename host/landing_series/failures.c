#include "host/landing_series/failures.h"

#include <stdbool.h>

#define WAVE_MATS 7 /* of the longest wave that the report saw (5.6) */

static double station_ft(const double *rise_ft, size_t first, size_t last, double length_ft,
                         const double *met_ft, int met)
{
    size_t crest = first;
    for (int i = 0; i < met; i++) {
        double node = met_ft[i] / length_ft + 1.0;
        if (node > (double)first - 0.5 && node < (double)last + 0.5)
            return met_ft[i];
    }
    for (size_t j = first; j <= last; j++)
        crest = rise_ft[j] > rise_ft[crest] ? j : crest;
    return (double)(crest - 1) * length_ft;
}

int failures_find(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                  const double *met_ft, int met, double failure_ft[SERIES_FAILURES_MAX])
{
    int count = 0;
    size_t first = 0;
    for (size_t j = 2; j <= nodes && count < SERIES_FAILURES_MAX; j++) {
        bool high = j < nodes && rise_ft[j] >= limit_ft;
        if (high && first == 0)
            first = j;
        if (high || first == 0)
            continue;
        failure_ft[count++] = station_ft(rise_ft, first, j - 1, length_ft, met_ft, met);
        first = 0;
    }
    return count;
}

int failures_apart(const double *unhinged_s, size_t joints, double length_ft,
                   double failure_ft[SERIES_FAILURES_MAX], double *first_ft)
{
    size_t last = 0, first = 0, earliest = 0; /* of the present failure; of all */
    int count = 0;
    for (size_t j = 1; j <= joints; j++) {
        if (!(unhinged_s[j] > 0.0))
            continue;
        if (last == 0 || j - last > WAVE_MATS) {
            if (count == SERIES_FAILURES_MAX)
                break;
            count++;
            first = j;
        } else if (unhinged_s[j] < unhinged_s[first]) {
            first = j;
        }
        failure_ft[count - 1] = (double)(first - 1) * length_ft;
        if (earliest == 0 || unhinged_s[j] < unhinged_s[earliest])
            earliest = j;
        last = j;
    }
    if (earliest > 0)
        *first_ft = (double)(earliest - 1) * length_ft;
    return count;
}
