/* What a landing came to, and who recorded it. */
#include "host/analyse/measured_source.h"
#include "host/collect/collect.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static void fact_estimate(FILE *out, const char *term, struct mr_estimate value, const struct unit *unit,
                          int decimals)
{
    double v = value.value * unit->factor;
    double e = value.error * unit->factor;
    html_fact(out, term, "%.*f \xc2\xb1 %.*f %s (95 %%: %.*f to %.*f)", decimals, v, decimals, e, unit->text,
              decimals, v - SUMMARY_95 * e, decimals, v + SUMMARY_95 * e);
}

enum mr_status landing_facts(const struct report *report, const struct report_landing *landing, FILE *out, struct error *error)
{
    const struct summary *summary = &landing->summary;
    const struct measured *measured = &summary->measured;
    const struct store_landing *row = &measured->landing;
    const bool si = report->si;
    char text[200], source[MEASURED_SOURCE_TEXT];
    (void)error;
    fputs("<dl>\n", out);
    for (size_t i = 0; doubts_line(&measured->doubts, i, text); i++)
        html_fact(out, measured->doubts.doubtful || measured->doubts.torn ? "doubtful" : "strangers", "%s", text);
    if (measured->fit_status == MR_OK) {
        fact_estimate(out, "touchdown speed", measured->summary.touchdown_speed_ft_s, unit_of(UNIT_SPEED, si),
                      3);
        fact_estimate(out, "mean deceleration", measured->summary.mean_deceleration_ft_s2,
                      unit_of(UNIT_DECELERATION, si), 3);
        fact_estimate(out, "stop", measured->summary.stop_station_ft, unit_of(UNIT_STATION, si), 3);
        html_fact(out, "touchdown to rest", "%.3f s",
                  measured->summary.stop_t_s.value - measured->summary.touchdown_t_s.value);
    } else if (measured->fit_status == MR_TRUNCATED) {
        fact_estimate(out, "touchdown speed", measured->summary.touchdown_speed_ft_s, unit_of(UNIT_SPEED, si),
                      3);
        html_fact(out, "stop", "not known: the record ends while the gear moves");
    } else {
        html_fact(out, "motion", "not known: %s",
                  measured->doubts.torn ? "the landing is torn, its first edges never came" : mr_status_text(measured->fit_status));
    }
    summary_switches(measured, text, sizeof text);
    html_fact(out, "switches", "%s", text);
    for (size_t i = 0; i < summary->switch_events; i++) {
        summary_switch_event(&summary->switch_event[i], text, sizeof text);
        html_fact(out, "damage", "%s", text);
    }
    for (size_t i = 0; i < summary->channel_events; i++) {
        if (summary_channel_event(summary, i, si, text, sizeof text))
            html_fact(out, "damage", "%s", text);
    }
    for (size_t i = 0; foresight_line(&summary->foresight, measured, i, si, text, sizeof text); i++)
        html_fact(out, "foresight", "%s", text);
    measured_source_text(measured, source);
    html_fact(out, "readings from", "%s", source);
    html_fact(out, "state", "%s", mr_landing_state_text((unsigned)row->state));
    html_fact(out, "board", "%s", row->board_uid[0] ? row->board_uid : "unknown");
    html_fact(out, "firmware", "%s, image %08llx, commit %s", row->firmware[0] ? row->firmware : "unknown",
              row->image_crc == STORE_NONE ? 0ull : (unsigned long long)row->image_crc,
              row->image_commit[0] ? row->image_commit : "unknown");
    html_fact(out, "clock", "%s",
              row->clock_source == STORE_NONE ? "not known"
              : row->clock_source > 0         ? "internal oscillator: 1 % in every speed"
                                              : "crystal");
    if (summary->imported) {
        html_fact(out, "imported from", "%s (%s, %lld bytes, SHA-256 %s)", summary->import.file, summary->import.format,
                  (long long)summary->import.bytes, summary->import.sha256);
        html_fact(out, "the file", "%s", summary->import.verdict);
    }
    html_fact(out, "recorded over", "CAN %s, serial %s",
              summary->session.can_link[0] ? summary->session.can_link : "not used",
              summary->session.serial_link[0] ? summary->session.serial_link : "not used");
    html_fact(out, "survey", "%zu of %u segments", landing->survey.surveyed, MR_SEGMENTS);
    fputs("</dl>\n", out);
    return MR_OK;
}
