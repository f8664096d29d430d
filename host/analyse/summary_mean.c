#include "host/analyse/summary_mean.h"

#include <math.h>

enum mr_status summary_mean_load(struct store *store, int64_t run, struct store_mean *mean,
                                 struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_QUANTITIES && status == MR_OK; i++)
        status = store_mean_get(store, run, (enum mr_quantity)i, &mean[i], error);
    return status;
}

void summary_mean_answer(const struct store_mean *mean, struct answer *answer)
{
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *info = mr_quantity_at(i);
        const struct store_mean *m = &mean[i];
        const char *unit = info->unit;
        while ((unsigned char)*unit >= 0x80) /* the degree */
            unit++;
        if (!m->readings && m->told)
            answer_words(answer, NULL, info->name, "none of %lld readings came; %s",
                         (long long)m->told, info->why);
        if (!m->readings)
            continue;
        answer_estimate(answer, NULL, info->name, UNIT_NUMBER, m->mean, m->error, info->decimals);
        answer_remark(answer, " %s, %lld of %lld readings", unit, (long long)m->readings,
                      (long long)m->told);
        answer_value(answer, info->key, NULL, UNIT_NUMBER, m->mean, info->decimals);
        if (!isnan(m->error))
            answer_value(answer, info->error_key, NULL, UNIT_NUMBER, m->error, info->decimals)
                ->digits = 4;
    }
}
