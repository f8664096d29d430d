#include "host/campaign/failures.h"

#include <stdbool.h>

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
                  const double *met_ft, int met, double failure_ft[CAMPAIGN_FAILURES_MAX])
{
    int count = 0;
    size_t first = 0;
    for (size_t j = 2; j <= nodes && count < CAMPAIGN_FAILURES_MAX; j++) {
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
