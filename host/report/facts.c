/* What the front of a report says of a landing, from the landing. */
#include <math.h>
#include <sha2.h>
#include <stdlib.h>
#include <string.h>

#include "host/report/report.h"

const char *report_wrong_text(unsigned i)
{
    static const char *const text[REPORT_WRONGS] = {
        "a wave was seen",
        "a break was seen",
        "a zone came without a warning, or before it",
        "a warning, and no zone came",
        "its first edges are missing",
        "its numbers are doubtful: other senders on CAN",
        "speed or stop is not known",
        "a transducer or gage was not valid",
        "the board told of a fault",
        "frames were lost, or a link was silent",
        "the check before it said NO-GO",
    };
    return i < REPORT_WRONGS ? text[i] : "";
}

/* ---- movement and tension ---- */

static void take_moved(const struct measured *measured, struct report_facts *facts)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, i + 1);
        const double none = (double)NAN;
        facts->moved[i] = (struct report_moved){none, none, none, none, none};
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        facts->moved[i] = (struct report_moved){(double)channel->config.station_ft, channel->peak,
                                                channel->error, channel->end, channel->end_error};
    }
}

static void take_bands(const struct measured *measured, struct report_facts *facts)
{
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        unsigned band = channel->config.band;
        if (channel->config.kind != MR_KIND_TENSION || band == 0 || band > REPORT_BANDS ||
            isnan(channel->baseline) || isnan(channel->low))
            continue;
        struct report_band *change = &facts->band[band - 1];
        change->fell_lb += channel->low - channel->baseline;
        change->rose_lb += channel->high - channel->baseline;
        change->gages++;
    }
    for (unsigned b = 0; b < REPORT_BANDS; b++) {
        double gages = facts->band[b].gages ? (double)facts->band[b].gages : (double)NAN;
        facts->band[b].fell_lb /= gages;
        facts->band[b].rose_lb /= gages;
    }
}

/* ---- zones ---- */

static struct report_zone zone_of(const struct store_zone *row)
{
    return row && row->mats > 0 ? (struct report_zone){row->mats, row->start_ft, row->end_ft}
                                : (struct report_zone){0, (double)NAN, (double)NAN};
}

static void take_zones(const struct report_landing *landing, struct report_facts *facts)
{
    const struct measured *measured = &landing->summary.measured;
    const struct zones *zones = &landing->summary.zones;
    const struct store_zone *longest = NULL;
    char why[ZONES_HEARD_TEXT];
    facts->statements = zones->count;
    facts->warning = zones->warning;
    facts->unheard = zones_heard_doubt(&zones->heard, (double)INFINITY, why);
    for (size_t i = 0; i < zones->count; i++) {
        if (zones->row[i].mats > 0 && (!longest || zones->row[i].mats > longest->mats))
            longest = &zones->row[i];
    }
    facts->longest = zone_of(longest);
    facts->last = zone_of(zones->count ? &zones->row[zones->count - 1] : NULL);
    facts->worst_verdict = STORE_NONE;
    for (size_t i = 0; i < landing->predictions; i++) {
        if (landing->prediction[i].verdict > facts->worst_verdict)
            facts->worst_verdict = landing->prediction[i].verdict;
    }
    if (measured->samples == 0)
        return;
    float remaining_in[MR_SEGMENTS];
    struct mr_closure_zone zone;
    zones_closed(measured, &landing->survey, measured->samples - 1, remaining_in, &zone);
    for (unsigned s = 0; s < MR_SEGMENTS && s < 64; s++)
        facts->closed |= remaining_in[s] < MR_CLOSURE_OPEN_IN ? 1ull << s : 0ull;
}

/* ---- comparison ---- */

static struct compare_overlap overlap_of(const struct compare_zones *zones, bool rest, bool board)
{
    const struct compare_zone_moment *moment = compare_moment_of(zones, rest);
    return !moment ? (struct compare_overlap){.known = false}
         : board   ? moment->board
                   : moment->simulated;
}

static void take_compared(const struct report_landing *landing, struct report_facts *facts,
                          struct error *error)
{
    struct compare_figures *figures = malloc(sizeof *figures);
    struct report_compared *compared = &facts->compared;
    facts->worst_rms_in = (double)NAN;
    for (size_t i = 0; i < landing->simulations; i++)
        facts->worst_rms_in = fmax(facts->worst_rms_in, landing->simulation[i].rms_in);
    if (!figures)
        abort();
    if (landing_compared(landing, figures, error)) {
        snprintf(compared->against, sizeof compared->against, "%s", figures->against);
        compared->channels = figures->channels;
        compared->mean = compare_mean_of(figures);
        compared->longest = overlap_of(&figures->zones, false, false);
        compared->longest_board = overlap_of(&figures->zones, false, true);
        compared->rest = overlap_of(&figures->zones, true, false);
        compared->error_in = figures->error_in;
    }
    free(figures);
}

/* ---- what went wrong ---- */

static unsigned wrong_of(const struct summary *summary, const struct report_facts *facts)
{
    unsigned wrong = (facts->torn ? REPORT_TORN : 0u) | (facts->doubtful ? REPORT_DOUBTFUL : 0u) |
                     (facts->fitted ? 0u : REPORT_NO_STOP) | (summary->faults ? REPORT_FAULT : 0u) |
                     (facts->lost ? REPORT_LOST : 0u);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        wrong |= summary->link[kind].used && summary->link[kind].silent ? REPORT_LOST : 0u;
    for (size_t i = 0; i < summary->channel_events; i++)
        wrong |= summary->channel_event[i].code != MR_VALID ? REPORT_CHANNEL : 0u;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &summary->measured.channel[c];
        if (summary->measured.samples && mr_channel_measures(&channel->config) &&
            channel->valid == 0)
            wrong |= REPORT_CHANNEL;
    }
    for (int kind = 0; kind < (int)SUMMARY_READY_KINDS; kind++)
        wrong |= summary->ready[kind].known && !summary->ready[kind].go ? REPORT_NO_GO : 0u;
    return wrong;
}

/* ---- all ---- */

/* The same for landings that are read with the same calibration. */
static void take_calibration(const struct report_landing *landing, struct report_facts *facts)
{
    const struct measured *measured = &landing->summary.measured;
    SHA2_CTX hash;
    SHA256Init(&hash);
    SHA256Update(&hash, (const uint8_t *)&measured->landing.config_crc,
                 sizeof measured->landing.config_crc);
    for (unsigned i = 0; i < MR_CHANNELS; i++)
        SHA256Update(&hash, (const uint8_t *)&measured->channel[i].config.unit_per_code,
                     sizeof measured->channel[i].config.unit_per_code);
    SHA256End(&hash, facts->calibration);
}

static void take_site(const struct report_landing *landing, struct report_facts *facts)
{
    const struct summary *summary = &landing->summary;
    snprintf(facts->can_link, sizeof facts->can_link, "%s", summary->session.can_link);
    snprintf(facts->serial_link, sizeof facts->serial_link, "%s", summary->session.serial_link);
    facts->config_read = landing->config != NULL;
    if (landing->config)
        snprintf(facts->site, sizeof facts->site, "%.*s", (int)sizeof landing->config->site[0].name,
                 landing->config->site[0].name);
}

void report_facts_take(const struct report_landing *landing, struct report_facts *facts,
                       struct error *error)
{
    const struct summary *summary = &landing->summary;
    const struct measured *measured = &summary->measured;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    facts->landing = measured->landing;
    facts->series = landing->series;
    facts->source = measured->source;
    facts->torn = measured->doubts.torn;
    facts->doubtful = measured->doubts.doubtful;
    facts->fitted = measured->fit_status == MR_OK;
    facts->sampled = measured->samples > 0;
    facts->gates = measured->gates;
    facts->switches = measured->switches;
    facts->surveyed = landing->survey.surveyed;
    facts->speed_ft_s = facts->fitted ? measured->summary.touchdown_speed_ft_s : none;
    facts->deceleration_ft_s2 = facts->fitted ? measured->summary.mean_deceleration_ft_s2 : none;
    facts->stop_ft = facts->fitted ? measured->summary.stop_station_ft : none;
    facts->lost = summary->link[LINK_CAN].lost + summary->link[LINK_SERIAL].lost;
    take_moved(measured, facts);
    take_bands(measured, facts);
    take_zones(landing, facts);
    take_compared(landing, facts, error);
    take_calibration(landing, facts);
    take_site(landing, facts);
    facts->wrong = wrong_of(summary, facts);
}
