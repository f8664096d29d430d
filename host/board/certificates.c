#include "host/board/certificates.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/base/xmalloc.h"
#include "host/board/config_text.h"
#include "host/calibrate/points.h"
#include "host/store/store_readiness.h"

#define S_PER_DAY 86400

enum mr_status certificates_read(struct store *store, const char *board_uid,
                                 struct certificates *certificates, struct error *error)
{
    struct store_certificate *rows = NULL;
    size_t count = 0;
    memset(certificates, 0, sizeof *certificates);
    enum mr_status status = store_certificates_get(store, board_uid, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].index < 0 || rows[i].index >= (int64_t)(MR_TRANSDUCERS + MR_GAGES))
            continue;
        certificates->is_known[rows[i].index] = true;
        certificates->certificate[rows[i].index] = rows[i];
    }
    free(rows);
    return status;
}

/* ---- entry ---- */

static bool parse_date(const char *text, int64_t *day)
{
    uint32_t days;
    if (!config_date_parse(text, &days) || text[CONFIG_DATE_SIZE - 1] != '\0')
        return false;
    *day = days;
    return true;
}

static bool parse_uncertainty(const char *text, struct store_certificate *row)
{
    bool movement = row->index < (int64_t)MR_TRANSDUCERS;
    const char *unit = movement ? "in" : "lb";
    size_t length = strlen(text);
    char bare[40];
    double value;
    struct quantity_error wrong;
    bool relative = length > 1 && text[length - 1] == '%';
    if (length >= sizeof bare)
        return false;
    snprintf(bare, sizeof bare, "%.*s", (int)(length - relative), text);
    if (!(relative ? quantity_parse(bare, NULL, NULL, &value, &wrong)
                   : calibrate_value_parse(bare, movement ? UNIT_DISPLACEMENT : UNIT_TENSION,
                                           unit_word_find(unit, 2), &value, &wrong)) ||
        !(value > 0.0 && value <= (relative ? 50.0 : 1000.0)))
        return false;
    row->expanded = relative ? (double)NAN : value;
    row->expanded_rel = relative ? value / 100.0 : (double)NAN;
    return true;
}

static bool parse_coverage(const char *text, struct store_certificate *row)
{
    struct quantity_error wrong;
    return quantity_parse(text, NULL, NULL, &row->coverage_factor, &wrong) &&
           row->coverage_factor >= 0.5 && row->coverage_factor <= 5.0;
}

static bool parse_text(const char *text, char *into, size_t size)
{
    snprintf(into, size, "%s", text);
    return text[0] && strlen(text) < size;
}

static bool parse_field(const char *name, const char *value, struct store_certificate *row,
                        unsigned *seen)
{
    static const char *const names[] = {"number", "laboratory",  "calibrated",
                                        "due",    "uncertainty", "coverage"};
    unsigned i = 0;
    while (i < 6 && strcmp(names[i], name) != 0)
        i++;
    *seen |= 1u << i;
    switch (i) {
    case 0: return parse_text(value, row->number, sizeof row->number);
    case 1: return parse_text(value, row->laboratory, sizeof row->laboratory);
    case 2:
        return parse_date(value, &row->calibrated_day) &&
               row->calibrated_day <= (int64_t)(time(NULL) / S_PER_DAY) + 1;
    case 3:
        row->due_day = STORE_NONE;
        return strcmp(value, "never") == 0 ||
               (parse_date(value, &row->due_day) && row->due_day >= row->calibrated_day);
    case 4: return parse_uncertainty(value, row);
    case 5: return parse_coverage(value, row);
    default: return false;
    }
}

enum mr_status certificates_parse(const char *text, struct store_certificate *row,
                                  struct error *error)
{
    char *copy = xstrdup(text), *rest = NULL;
    /* bit n: key n was given. Bit 1 (laboratory) is set from the start, because it is optional. */
    unsigned seen = 2;
    for (char *part = strtok_r(copy, ",", &rest); part && error->status == MR_OK;
         part = strtok_r(NULL, ",", &rest)) {
        char *equals = strchr(part, '=');
        part += strspn(part, " ");
        if (equals)
            *equals = '\0';
        if (!equals || !parse_field(part, equals + 1, row, &seen))
            error_set(error, MR_USAGE,
                      "--certificate cannot have the value '%s%s%s'; give number=N, "
                      "calibrated=DATE, due=DATE (not before calibrated) or due=never, "
                      "uncertainty=U (0.05mm, 0.4%%), coverage=K (2), laboratory=L",
                      part, equals ? "=" : "", equals ? equals + 1 : "");
    }
    free(copy);
    if (error->status == MR_OK && seen != 63)
        return error_set(error, MR_USAGE,
                         "--certificate is incomplete: '%s'; give number, calibrated, due, "
                         "uncertainty and coverage",
                         text);
    return error->status;
}

/* ---- state ---- */

enum certificate_state certificates_check_state(const struct store_certificate *certificate,
                                                const struct mr_channel_config *channel,
                                                int64_t now_s)
{
    if (channel->serial[0] && certificate->sensor[0] &&
        (strlen(certificate->sensor) > sizeof channel->serial ||
         strncmp(certificate->sensor, channel->serial, sizeof channel->serial) != 0))
        return CERTIFICATE_OTHER_SENSOR;
    return certificate->due_day == STORE_NONE || now_s / S_PER_DAY <= certificate->due_day
             ? CERTIFICATE_VALID
             : CERTIFICATE_OVERDUE;
}

void certificates_state_text(const struct store_certificate *certificate,
                             enum certificate_state state, const struct mr_channel_config *channel,
                             char out[CERTIFICATES_TEXT_SIZE])
{
    char date[CONFIG_DATE_SIZE] = "";
    if (certificate->due_day != STORE_NONE)
        config_date_text((uint32_t)certificate->due_day + (state == CERTIFICATE_OVERDUE), date);
    if (state == CERTIFICATE_OTHER_SENSOR)
        snprintf(out, CERTIFICATES_TEXT_SIZE,
                 "the certificate is for sensor %s, but the board has sensor %.*s",
                 certificate->sensor, (int)sizeof channel->serial, channel->serial);
    else
        snprintf(out, CERTIFICATES_TEXT_SIZE, "%s%s",
                 state == CERTIFICATE_OVERDUE ? "overdue since "
                 : date[0]                    ? "valid until "
                                              : "valid, no due date",
                 date);
}

double certificates_compute_uncertainty(const struct store_certificate *certificate, double value)
{
    double expanded = !isnan(certificate->expanded) ? certificate->expanded
                                                    : certificate->expanded_rel * fabs(value);
    return expanded / certificate->coverage_factor;
}
