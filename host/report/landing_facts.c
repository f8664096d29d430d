/* What a landing came to, and who recorded it. */
#include "host/report/report.h"

enum mr_status landing_facts(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    const struct store_session_row *session = &landing->summary.session;
    struct answer *answer = answer_new(report->si);
    (void)error;
    summary_facts_answer(&landing->summary, answer);
    answer_words(answer, NULL, "recorded over", "CAN %s, serial %s",
                 session->can_link[0] ? session->can_link : "not used",
                 session->serial_link[0] ? session->serial_link : "not used");
    answer_words(answer, NULL, "survey", "%zu of %u segments", landing->survey.surveyed,
                 MR_SEGMENTS);
    report_answer(answer, out);
    return MR_OK;
}
