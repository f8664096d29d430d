/* Bands of a landing: figures, findings, shunt calibrations. Nothing where the board told
 * nothing. */
#include "host/report/report.h"

enum mr_status landing_bands(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    const struct bands_summary *bands = &landing->summary.bands;
    struct answer *answer = answer_new(report->si);
    (void)error;
    bands_answer(bands, &landing->summary.measured, answer);
    bands_shunts_answer(bands, true, answer);
    report_answer(answer, out);
    return MR_OK;
}
