#include "host/analyse/brief.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/units.h"

static void add_prediction(const struct summary *summary, struct answer *answer)
{
    const struct zone_warning *w = &summary->zones.warning;
    const bool si = answer_is_si(answer);
    char wheel[UNIT_TEXT_SIZE];
    if (!w->has_warning || w->predicted_mats <= 0 || isnan(w->predicted_wheel_ft))
        return;
    unit_value_text(UNIT_STATION, si, w->predicted_wheel_ft, 1, wheel);
    answer_add_text(answer, NULL, "predicted", "%lld closed mats with the wheel at %s",
                    (long long)w->predicted_mats, wheel);
}

static void add_motion(const struct measured_landing *measured, struct answer *answer)
{
    const struct mr_gates_summary *fit = &measured->summary;
    char reason[MEASURED_REASON_SIZE];
    if (measured->fit_status == MR_OK || measured->fit_status == MR_TRUNCATED)
        answer_add_estimate(answer, NULL, "touchdown", UNIT_SPEED, fit->touchdown_speed_ft_s.value,
                            fit->touchdown_speed_ft_s.error, 3);
    else
        answer_add_text(answer, NULL, "motion", "not known: %s",
                        mr_status_text(measured->fit_status));
    if (measured->fit_status == MR_TRUNCATED) {
        measured_format_unknown_stop(measured, reason);
        answer_add_text(answer, NULL, "stop", "not known: %s", reason);
    }
    if (measured->fit_status != MR_OK)
        return;
    answer_add_estimate(answer, NULL, "deceleration", UNIT_DECELERATION,
                        fit->mean_deceleration_ft_s2.value, fit->mean_deceleration_ft_s2.error, 3);
    answer_add_estimate(answer, NULL, "stop", UNIT_STATION, fit->stop_station_ft.value,
                        fit->stop_station_ft.error, 3);
    answer_append_remark(answer, ", %.2f s after touchdown",
                         fit->stop_t_s.value - fit->touchdown_t_s.value);
}

/* Adds the peak of the channel that moved most. */
static void add_movement(const struct measured_landing *measured, struct answer *answer)
{
    const struct measured_channel *most = NULL;
    char station[UNIT_TEXT_SIZE];
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind == MR_KIND_DISPLACEMENT && isfinite(channel->peak) &&
            (!most || fabs(channel->peak) > fabs(most->peak)))
            most = channel;
    }
    if (!most)
        return;
    unit_value_text(UNIT_STATION, answer_is_si(answer), (double)most->config.station_ft, 1,
                    station);
    answer_add_estimate(answer, NULL, "movement", UNIT_DISPLACEMENT, most->peak, most->peak_error,
                        3);
    answer_append_remark(answer, " at most, at %s", station);
}

/* Adds the band gages with the smallest and the largest tension. */
static void add_tension(const struct measured_landing *measured, struct answer *answer)
{
    const struct measured_channel *low = NULL, *high = NULL;
    char least[UNIT_TEXT_SIZE], most[UNIT_TEXT_SIZE], at_least[UNIT_TEXT_SIZE],
        at_most[UNIT_TEXT_SIZE];
    const bool si = answer_is_si(answer);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION)
            continue;
        if (isfinite(channel->low) && (!low || channel->low < low->low))
            low = channel;
        if (isfinite(channel->high) && (!high || channel->high > high->high))
            high = channel;
    }
    if (!low || !high)
        return;
    unit_value_text(UNIT_TENSION, si, low->low, 1, least);
    unit_value_text(UNIT_TENSION, si, high->high, 1, most);
    unit_value_text(UNIT_STATION, si, (double)low->config.station_ft, 1, at_least);
    unit_value_text(UNIT_STATION, si, (double)high->config.station_ft, 1, at_most);
    answer_add_text(answer, NULL, "tension", "%s at %s to %s at %s", least, at_least, most,
                    at_most);
}

/* Adds the missing switches and the number of lost frames. */
static void add_data_quality(const struct summary *summary, struct answer *answer)
{
    char switches[200], lost[200] = "";
    summary_format_switches(&summary->measured, switches, sizeof switches);
    answer_add_text(answer, NULL, "switches", "%s", switches);
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct summary_link *link = &summary->link[kind];
        size_t used = strlen(lost);
        if (link->is_used)
            snprintf(lost + used, sizeof lost - used, "%s lost %lld of %lld frames%s, ",
                     summary_link_name(kind), (long long)link->lost_frames,
                     (long long)(link->received_frames + link->lost_frames),
                     link->was_silent ? " and was silent for a time" : "");
    }
    answer_add_text(answer, NULL, "data", "%s%zu gap%s, %zu fault%s", lost, summary->gap_count,
                    summary->gap_count == 1 ? "" : "s", summary->fault_count,
                    summary->fault_count == 1 ? "" : "s");
    if (summary->channel_event_count)
        answer_add_text(answer, NULL, "channels", "validity of a channel changed %zu times",
                        summary->channel_event_count);
}

bool brief_print(const char *db, const struct summary *summary, bool all, bool si, FILE *out)
{
    struct answer *answer = answer_new(si);
    char heading[SUMMARY_HEADING_SIZE];
    if (all) {
        summary_to_answer(summary, answer);
    } else {
        summary_format_heading(summary, heading);
        answer_open_group(answer, NULL, heading);
        summary_add_alerts(summary, answer);
        zones_add_warning_status(&summary->zones, summary->measured.source != MEASURED_IMPORT,
                                 answer);
        add_prediction(summary, answer);
        outcome_record_add_outcome(&summary->outcome, answer);
        add_motion(&summary->measured, answer);
        add_movement(&summary->measured, answer);
        add_tension(&summary->measured, answer);
        add_data_quality(summary, answer);
        answer_add_text(answer, NULL, "more", "matrig show %s %lld", db,
                        (long long)summary->measured.landing.id);
        answer_close_group(answer);
    }
    bool printed = answer_print_text(answer, out);
    answer_free(answer);
    return printed;
}
