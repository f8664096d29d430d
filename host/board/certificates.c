#include "host/board/certificates.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/configplace.h"

#define DAY_S 86400

static int64_t day_of(int64_t s)
{
    return s / DAY_S - (s % DAY_S < 0);
}

int64_t certificates_newest_day(int64_t now_s)
{
    return day_of(now_s + CERTIFICATES_AHEAD_S);
}

const struct store_certificate *certificates_find(const struct store_certificate *rows,
                                                  size_t count, unsigned index)
{
    const struct store_certificate *found = NULL;
    for (size_t i = 0; i < count; i++) {
        const struct store_certificate *row = &rows[i];
        if (row->index == (int64_t)index && !row->gone && row->withdraws == STORE_NONE &&
            (!found || row->calibrated_day >= found->calibrated_day))
            found = row;
    }
    return found;
}

enum mr_status certificates_read(struct store *store, const char *board_uid,
                                 struct certificates *certificates, struct error *error)
{
    struct store_certificate *rows = NULL;
    size_t count = 0;
    memset(certificates, 0, sizeof *certificates);
    enum mr_status status = store_certificates(store, board_uid, &rows, &count, error);
    if (status == MR_OK)
        status = store_certificates_required(store, &certificates->required, error);
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES && status == MR_OK; i++) {
        const struct store_certificate *found = certificates_find(rows, count, i);
        certificates->known[i] = found != NULL;
        if (found)
            certificates->of[i] = *found;
    }
    free(rows);
    return status;
}

/* Both say which sensor it is, and they differ. */
static bool another(const struct store_certificate *certificate,
                    const struct mr_channel_config *channel)
{
    return channel && channel->serial[0] && certificate->sensor[0] &&
           (strlen(certificate->sensor) > sizeof channel->serial ||
            strncmp(certificate->sensor, channel->serial, sizeof channel->serial) != 0);
}

enum certificate_state certificates_state(const struct store_certificate *certificate,
                                          const struct mr_channel_config *channel, int64_t now_s)
{
    int64_t newest = certificates_newest_day(now_s), oldest = day_of(now_s - CERTIFICATES_BEHIND_S);
    if (another(certificate, channel))
        return CERTIFICATE_ANOTHER;
    if (certificate->calibrated_day > newest)
        return CERTIFICATE_AHEAD;
    if (certificate->due_day == STORE_NONE || newest <= certificate->due_day)
        return CERTIFICATE_VALID;
    return oldest > certificate->due_day ? CERTIFICATE_OVERDUE : CERTIFICATE_DUE_NOW;
}

void certificates_text(const struct store_certificate *certificate, enum certificate_state state,
                       const struct mr_channel_config *channel, char out[CERTIFICATES_TEXT])
{
    char due[CONFIGPLACE_DATE] = "", over[CONFIGPLACE_DATE] = "", made[CONFIGPLACE_DATE] = "";
    if (certificate->due_day != STORE_NONE) {
        configplace_date_text((uint32_t)certificate->due_day, due);
        configplace_date_text((uint32_t)certificate->due_day + 1u, over);
    }
    if (certificate->calibrated_day != STORE_NONE)
        configplace_date_text((uint32_t)certificate->calibrated_day, made);
    switch (state) {
    case CERTIFICATE_VALID:
        snprintf(out, CERTIFICATES_TEXT, "%s%s", due[0] ? "valid until " : "valid, no due date",
                 due);
        break;
    case CERTIFICATE_DUE_NOW:
        snprintf(out, CERTIFICATES_TEXT, "valid until %s, which is today or was yesterday", due);
        break;
    case CERTIFICATE_OVERDUE: snprintf(out, CERTIFICATES_TEXT, "overdue since %s", over); break;
    case CERTIFICATE_AHEAD:
        snprintf(out, CERTIFICATES_TEXT, "calibrated on %s, a day to come", made);
        break;
    case CERTIFICATE_ANOTHER:
        snprintf(out, CERTIFICATES_TEXT, "of sensor %s; the board has %.*s", certificate->sensor,
                 (int)sizeof channel->serial, channel->serial);
        break;
    }
}

double certificates_factor(double percent)
{
    double low = 0.0, high = 10.0;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        *(100.0 * erf(middle / sqrt(2.0)) < percent ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

double certificates_standard(const struct store_certificate *certificate, double value)
{
    double expanded = !isnan(certificate->expanded) ? certificate->expanded
                                                    : certificate->expanded_rel * fabs(value);
    return expanded / certificate->coverage_factor;
}
