#include "host/analyse/summary_held.h"

#include <stdio.h>
#include <string.h>

static bool any(const struct store_held *held)
{
    int64_t sum_us = 0;
    for (int cause = 0; cause < STORE_HELD_CAUSES; cause++)
        sum_us += held->us[cause];
    return sum_us > 0;
}

void summary_held_answer(const struct store_held *held, struct answer *answer)
{
    static const char *const names[STORE_HELD_CAUSES] = {"lock_s", "slow_disk_s", "full_disk_s",
                                                         "failing_disk_s"};
    char text[300] = "";
    if (!any(held)) {
        answer_none(answer, "held", NULL, "");
        return;
    }
    answer_open(answer, "held", "");
    for (int cause = 0; cause < STORE_HELD_CAUSES; cause++) {
        size_t used = strlen(text);
        if (held->us[cause] == 0)
            continue;
        snprintf(text + used, sizeof text - used, "%s%s for %.1f s", used ? ", " : "",
                 store_held_text((enum store_held_cause)cause), (double)held->us[cause] / 1e6);
        answer_value(answer, names[cause], NULL, UNIT_NUMBER, (double)held->us[cause] / 1e6, 1)
            ->digits = 12;
    }
    answer_words(answer, NULL, "writing", "%s; what came waited in a queue, %.0f %% full at most",
                 text, (double)held->permille / 10.0);
    answer_value(answer, "queue_percent", NULL, UNIT_NUMBER, (double)held->permille / 10.0, 1);
    answer_close(answer);
}
