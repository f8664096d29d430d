#include "host/analyse/summary_held.h"

static bool any(const struct store_held *held)
{
    int64_t sum_us = 0;
    for (int cause = 0; cause < STORE_HELD_CAUSES; cause++)
        sum_us += held->us[cause];
    return sum_us > 0;
}

void summary_held_print(const struct store_held *held, FILE *out)
{
    bool first = true;
    if (!any(held))
        return;
    fprintf(out, "  %-13s ", "writing");
    for (int cause = 0; cause < STORE_HELD_CAUSES; cause++) {
        if (held->us[cause] == 0)
            continue;
        fprintf(out, "%s%s for %.1f s", first ? "" : ", ", store_held_text((enum store_held_cause)cause), (double)held->us[cause] / 1e6);
        first = false;
    }
    fprintf(out, "; what came waited in a queue, %.0f %% full at most\n", (double)held->permille / 10.0);
}

json_t *summary_held_json(const struct store_held *held)
{
    static const char *const names[STORE_HELD_CAUSES] = {"lock", "slow_disk", "full_disk", "failing_disk"};
    if (!any(held))
        return json_null();
    json_t *object = json_pack("{sf}", "queue_percent", (double)held->permille / 10.0);
    for (int cause = 0; cause < STORE_HELD_CAUSES; cause++) {
        char key[40];
        snprintf(key, sizeof key, "%s_s", names[cause]);
        if (held->us[cause])
            json_object_set_new(object, key, json_real((double)held->us[cause] / 1e6));
    }
    return object;
}
