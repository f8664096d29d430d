/* Calibration certificates of a board's sensors, as rows of the campaign's table `certificates`.
 * Rows are only added. For each channel the certificate entered last applies, up to and including
 * its due day (UTC). */
#ifndef MATRIG_HOST_BOARD_CERTIFICATES_H
#define MATRIG_HOST_BOARD_CERTIFICATES_H

#include "common/config.h"
#include "host/store/store.h"

enum certificate_state {
    CERTIFICATE_VALID,
    CERTIFICATE_OVERDUE,
    CERTIFICATE_OTHER_SENSOR /* issued for a sensor that the configuration does not name */
};

struct certificates {
    bool is_known[MR_TRANSDUCERS + MR_GAGES];
    struct store_certificate certificate[MR_TRANSDUCERS + MR_GAGES];
};

enum mr_status certificates_read(struct store *store, const char *board_uid,
                                 struct certificates *certificates, struct error *error);
/* Parses the text that a person enters: "number=2026-4711, laboratory=Metrology Lab,
 * calibrated=2026-03-02, due=2027-03-01, uncertainty=0.4%, coverage=2". `laboratory` is optional;
 * `due` may be "never"; `uncertainty` is the expanded uncertainty: a length or force with its unit,
 * or percent of the reading. `coverage` is its coverage factor. Sets all fields of `row` except
 * board, sensor and time; the caller sets row->index. MR_USAGE: the text is invalid. */
enum mr_status certificates_parse(const char *text, struct store_certificate *row,
                                  struct error *error);
/* Compares a certificate with its channel in the board's configuration at the Unix time `now_s`. */
enum certificate_state certificates_check_state(const struct store_certificate *certificate,
                                                const struct mr_channel_config *channel,
                                                int64_t now_s);
/* Writes the state as text: "valid until 2027-03-01", "overdue since 2027-03-02", ... */
#define CERTIFICATES_TEXT_SIZE 160
void certificates_state_text(const struct store_certificate *certificate,
                             enum certificate_state state, const struct mr_channel_config *channel,
                             char out[CERTIFICATES_TEXT_SIZE]);

/* Returns the standard uncertainty at the reading `value`, in or lb. */
double certificates_compute_uncertainty(const struct store_certificate *certificate, double value);

#endif
