#include "host/analyse/summary_ready.h"

#include <stdlib.h>
#include <string.h>

#include "host/store/store_readiness.h"

#define US_PER_MIN 60e6

static const char *summary_ready_kind(int kind)
{
    return kind == 0 ? "ready" : "walk";
}

static void take_no_go(const char *checks, char *out, size_t size)
{
    json_t *object = json_loads(checks, 0, NULL), *check;
    size_t i;
    json_array_foreach(json_object_get(object, "checks"), i, check)
    {
        const char *verdict = json_string_value(json_object_get(check, "verdict"));
        const char *name = json_string_value(json_object_get(check, "name")),
                   *value = json_string_value(json_object_get(check, "value"));
        size_t at = strlen(out);
        if (verdict && name && value && strcmp(verdict, "NO-GO") == 0)
            snprintf(out + at, size - at, "%s%s: %s", at ? "; " : "", name, value);
    }
    json_decref(object);
}

enum mr_status summary_ready_load(struct store *store, const struct store_landing *landing,
                                  struct summary_ready ready[SUMMARY_READY_KINDS],
                                  struct error *error)
{
    enum mr_status status = MR_OK;
    memset(ready, 0, SUMMARY_READY_KINDS * sizeof *ready);
    for (int kind = 0; kind < SUMMARY_READY_KINDS && status == MR_OK && landing->board_uid[0];
         kind++) {
        struct store_readiness row;
        status = store_readiness_get(store, landing->board_uid, summary_ready_kind(kind),
                                     landing->armed_us, true, &row, &ready[kind].known, error);
        if (status != MR_OK || !ready[kind].known)
            continue;
        ready[kind].go = strcmp(row.verdict, "go") == 0;
        ready[kind].before_min = (double)(landing->armed_us - row.made_us) / US_PER_MIN;
        take_no_go(row.checks, ready[kind].no_go, sizeof ready[kind].no_go);
        free(row.checks);
    }
    return status;
}

void summary_ready_answer(const struct summary_ready ready[SUMMARY_READY_KINDS],
                          struct answer *answer)
{
    for (int kind = 0; kind < SUMMARY_READY_KINDS; kind++) {
        const struct summary_ready *r = &ready[kind];
        if (r->known)
            answer_words(answer, NULL, summary_ready_kind(kind), "%s, %.0f min before%s%s",
                         r->go ? "go" : "NO-GO", r->before_min, r->no_go[0] ? ": " : "", r->no_go)
                ->warn = !r->go;
    }
    answer_open(answer, "readiness", NULL);
    for (int kind = 0; kind < SUMMARY_READY_KINDS; kind++) {
        if (!ready[kind].known) {
            answer_none(answer, summary_ready_kind(kind), NULL, "");
            continue;
        }
        answer_open(answer, summary_ready_kind(kind), NULL);
        answer_flag(answer, "go", NULL, ready[kind].go);
        answer_value(answer, "before_min", NULL, UNIT_NUMBER, ready[kind].before_min, 0)->digits =
            4;
        answer_words(answer, "no_go", NULL, "%s", ready[kind].no_go);
        answer_close(answer);
    }
    answer_close(answer);
}
