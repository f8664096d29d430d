#include "host/board/readykept.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/cli.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"

/* The spans that the last `matrig ready` of this board kept. */
static void take_spans(const char *checks, float span_lb[MR_GAGES])
{
    json_t *object = json_loads(checks, 0, NULL), *spans = json_object_get(object, "spans_lb");
    for (unsigned i = 0; i < MR_GAGES; i++) {
        json_t *span = json_array_get(spans, i);
        if (json_is_number(span))
            span_lb[i] = (float)json_number_value(span);
    }
    json_decref(object);
}

/* The newest advice that was kept for the landing to come; one of before the newest landing was for
 * that. */
static enum mr_status take_advice(struct store *store, int64_t newest_run, struct ready_facts *f,
                                  struct error *error)
{
    struct store_advice *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_advices(store, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (rows[i].after_run != newest_run)
            continue;
        snprintf(f->advice, sizeof f->advice, "%s: %s", rows[i].verdict, rows[i].reason);
        f->advised_against = strcmp(rows[i].verdict, "against") == 0;
    }
    free(rows);
    return status;
}

enum mr_status readykept_look_back(struct store *store, struct ready_facts *f, struct error *error)
{
    char uid[IDENTITY_UID_TEXT];
    struct store_landing *rows = NULL;
    struct store_readiness last;
    size_t count = 0;
    bool found = false;
    int64_t kept_us = STORE_NONE;
    identity_uid_text(&f->identity, uid);
    enum mr_status status = store_landings(store, &rows, &count, error);
    if (status == MR_OK && count)
        status = take_advice(store, rows[count - 1].id, f, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (strcmp(rows[i].board_uid, uid) != 0)
            continue;
        f->before = true;
        f->before_run = rows[i].id;
        f->before_image = rows[i].image_crc;
        f->before_config = rows[i].config_crc;
    }
    free(rows);
    if (status == MR_OK)
        status = store_board_spans(store, uid, f->before_span_lb, &kept_us, error);
    if (status == MR_OK)
        status = store_readiness_get(store, uid, "ready", (int64_t)link_now_us(), false, &last,
                                     &found, error);
    if (status == MR_OK && found && last.made_us > kept_us)
        take_spans(last.checks, f->before_span_lb);
    if (status == MR_OK && found)
        free(last.checks);
    if (status == MR_OK)
        status = calibrationpast_read(store, uid, &f->past, error);
    if (status == MR_OK)
        status = certificates_read(store, uid, &f->certificates, error);
    return status;
}

enum mr_status readykept_save(struct store *store, const struct identity *identity,
                              const char *kind, const struct ready_report *report,
                              const struct ready_facts *f, int64_t made_us, struct error *error)
{
    char uid[IDENTITY_UID_TEXT];
    json_t *spans = json_array();
    struct store_readiness row = {.made_us = made_us};
    for (unsigned gage = 1; f && gage <= MR_GAGES; gage++) {
        double span_lb = (double)NAN;
        for (unsigned i = 0; i < f->shunts.count; i++) {
            if (f->shunts.result[i].gage == gage)
                span_lb = (double)f->shunts.result[i].span_lb;
        }
        json_array_append_new(spans, cli_json_number(span_lb, 7));
    }
    json_t *object = json_pack("{soso}", "checks", ready_json(report), "spans_lb", spans);
    if (f && f->config_known)
        json_object_set_new(object, "calibration", calibrationpast_json(&f->config, UINT32_MAX));
    row.checks = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    if (!row.checks)
        abort();
    snprintf(row.verdict, sizeof row.verdict, "%s",
             ready_verdict(report) == READY_GO ? "go" : "no-go");
    identity_uid_text(identity, uid);
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = store_readiness_put(store, uid, kind, &row, error);
    if (status == MR_OK)
        status = store_commit(store, error);
    free(row.checks);
    return status;
}
