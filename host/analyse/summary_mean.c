#include "host/analyse/summary_mean.h"

#include <math.h>

#include "host/base/cli.h"

enum mr_status summary_mean_load(struct store *store, int64_t run, struct store_mean *mean, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_QUANTITIES && status == MR_OK; i++)
        status = store_mean_get(store, run, (enum mr_quantity)i, &mean[i], error);
    return status;
}

void summary_mean_text(unsigned quantity, const struct store_mean *mean, bool plain, char out[SUMMARY_MEAN_TEXT])
{
    const struct mr_quantity_info *info = mr_quantity_at(quantity);
    const char *unit = info->unit;
    char error[24] = "";
    while (plain && (unsigned char)*unit >= 0x80) /* the degree */
        unit++;
    if (!isnan(mean->error))
        snprintf(error, sizeof error, " %s %.*f", plain ? "+-" : "\xc2\xb1", info->decimals, mean->error);
    snprintf(out, SUMMARY_MEAN_TEXT, "%.*f%s %s", info->decimals, mean->mean, error, unit);
}

void summary_mean_print(const struct store_mean *mean, FILE *out)
{
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *info = mr_quantity_at(i);
        char text[SUMMARY_MEAN_TEXT];
        summary_mean_text(i, &mean[i], true, text);
        if (mean[i].readings)
            fprintf(out, "  %-13s %s, %lld of %lld readings\n", info->name, text, (long long)mean[i].readings, (long long)mean[i].told);
        else if (mean[i].told)
            fprintf(out, "  %-13s none of %lld readings came; %s\n", info->name, (long long)mean[i].told, info->why);
    }
}

void summary_mean_json(const struct store_mean *mean, json_t *object)
{
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *info = mr_quantity_at(i);
        if (!mean[i].readings)
            continue;
        json_object_set_new(object, info->key, cli_json_number(mean[i].mean, 6));
        if (!isnan(mean[i].error))
            json_object_set_new(object, info->error_key, cli_json_number(mean[i].error, 4));
    }
}
