/* Certificates of the sensors of a board: which one holds for each channel, and whether it holds
 * today.
 *
 * Of the certificates of a channel the one calibrated last holds; of two of one day the one entered
 * later. A certificate holds through its due day.
 *
 * A date on a certificate has no time zone, and the zone of this computer may be wrong. So a
 * certificate is valid while the due day is not over anywhere on Earth (UTC+14 is ahead of all),
 * and overdue once it is over everywhere (UTC-12 is behind all). In the 26 hours between it is
 * neither: whoever stands at the rig looks at a calendar. */
#ifndef MATRIG_HOST_CERTIFICATES_H
#define MATRIG_HOST_CERTIFICATES_H

#include "common/config.h"
#include "host/store/store_certificates.h"

#define CERTIFICATES_AHEAD_S  (14 * 3600) /* the first zone's clocks, before UTC */
#define CERTIFICATES_BEHIND_S (12 * 3600) /* the last zone's, behind it */

enum certificate_state {
    CERTIFICATE_VALID,
    CERTIFICATE_DUE_NOW, /* its last day is over somewhere, not everywhere */
    CERTIFICATE_OVERDUE,
    CERTIFICATE_AHEAD,  /* calibrated on a day that has begun nowhere: a clock is wrong */
    CERTIFICATE_ANOTHER /* of another sensor than the board's configuration names */
};

struct certificates {
    bool required;                         /* the campaign demands one of each channel */
    bool known[MR_TRANSDUCERS + MR_GAGES]; /* there is one that was not taken back */
    struct store_certificate of[MR_TRANSDUCERS + MR_GAGES];
};

enum mr_status certificates_read(struct store *store, const char *board_uid,
                                 struct certificates *certificates, struct error *error);
/* The one of channel `index` that holds among `rows`; NULL: none. */
const struct store_certificate *certificates_find(const struct store_certificate *rows,
                                                  size_t count, unsigned index);
/* `channel`: as the board is configured, or NULL: the sensor is not compared. `now_s`: Unix
 * time. */
enum certificate_state certificates_state(const struct store_certificate *certificate,
                                          const struct mr_channel_config *channel, int64_t now_s);
/* The last day that has begun anywhere, from 1970-01-01. */
int64_t certificates_newest_day(int64_t now_s);
/* "valid until 2027-03-01", "overdue since 2027-03-02", ... */
#define CERTIFICATES_TEXT 160
void certificates_text(const struct store_certificate *certificate, enum certificate_state state,
                       const struct mr_channel_config *channel, char out[CERTIFICATES_TEXT]);

/* The factor by which an interval that holds with this probability, in percent, is wider than a
 * standard uncertainty of a normal distribution. */
double certificates_factor(double percent);
/* Standard uncertainty where the reading is `value`, in or lb; NaN: the certificate has none. */
double certificates_standard(const struct store_certificate *certificate, double value);

#endif
