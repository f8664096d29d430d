#include "host/report/page.h"

#include <math.h>
#include <string.h>

#include "common/fault.h"
#include "host/collect.h"
#include "host/report/bands_page.h"
#include "host/report/html.h"
#include "host/runway.h"
#include "host/units.h"

/* Colours: blue, orange, green and so on of equal weight, tellable apart without red against green; the dark
 * set is the same hues lighter. */
static const char style[] =
    ":root{--paper:#fff;--ink:#1b1f24;--soft:#59636e;--rule:#d5dae0;--grid:#e8ebef;--panel:#f6f8fa;"
    "--a:#0b62c4;--b:#c2570c;--c:#6a3fb5;--d:#0a7d5a;--e:#a8256f;--f:#7a6a00;--closed:#c9702c;"
    "--warn:#b3261e}"
    "@media (prefers-color-scheme:dark){:root{--paper:#12161b;--ink:#e4e8ec;--soft:#9aa5b1;"
    "--rule:#39424d;--grid:#262d36;--panel:#1a2028;--a:#6cb2ff;--b:#ff9d57;--c:#bfa0ff;--d:#4fd0a4;"
    "--e:#f58cc6;--f:#d8c84a;--closed:#d58445;--warn:#ff7b72}}"
    "@media print{:root{--paper:#fff;--ink:#000;--soft:#444;--rule:#bbb;--grid:#e5e5e5;--panel:#fff;"
    "--a:#0b62c4;--b:#c2570c;--c:#6a3fb5;--d:#0a7d5a;--e:#a8256f;--f:#7a6a00;--closed:#c9702c;"
    "--warn:#b3261e}section{break-before:page}figure,table,dl{break-inside:avoid}"
    "body{max-width:none;margin:0}}*{box-sizing:border-box}"
    "body{background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,sans-serif;"
    "max-width:1100px;margin:0 auto;padding:24px 20px 60px}h1{font-size:26px;margin:0 0 4px}"
    "h2{font-size:21px;margin:44px 0 6px;padding-top:14px;border-top:1px solid var(--rule)}"
    "h3{font-size:16px;margin:26px 0 6px}p{margin:6px 0;color:var(--soft);max-width:90ch}"
    "p.say{color:var(--ink)}.scroll{overflow-x:auto}"
    "table{border-collapse:collapse;font-size:13.5px;font-variant-numeric:tabular-nums;width:100%}"
    "th{text-align:left;font-weight:600;color:var(--soft);border-bottom:1px solid var(--rule);"
    "padding:4px 10px 4px 0;vertical-align:bottom}"
    "td{border-bottom:1px solid var(--grid);padding:4px 10px 4px 0;vertical-align:top}"
    "td.n{white-space:nowrap}"
    "dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(235px,1fr));gap:10px 18px;"
    "background:var(--panel);border:1px solid var(--rule);border-radius:6px;padding:14px 16px;"
    "margin:12px 0}dt{font-size:12px;color:var(--soft)}dd{margin:0;font-variant-numeric:tabular-nums;overflow-wrap:anywhere}"
    "figure{margin:14px 0}figcaption{color:var(--soft);font-size:13px}a{color:var(--a)}"
    ".warn{color:var(--warn);font-weight:600}"
    "svg{width:100%;height:auto;display:block;font:11px system-ui,sans-serif}"
    ".grid{stroke:var(--grid);fill:none}.frame{fill:none;stroke:var(--rule)}.tick{fill:var(--soft)}"
    ".label{fill:var(--soft);font-size:12px}.name{fill:var(--ink);font-size:12px;font-weight:600}"
    ".line{fill:none;stroke-width:1.5;stroke-linejoin:round}.a{stroke:var(--a)}.b{stroke:var(--b)}"
    ".c{stroke:var(--c)}.sim{stroke:var(--b);stroke-dasharray:5 3}.dot{stroke:none}"
    ".dot.a{fill:var(--a)}.dot.b{fill:var(--b)}.dot.c{fill:var(--c)}"
    ".band{fill:var(--a);opacity:.2;stroke:none}"
    ".mark{stroke:var(--soft);stroke-dasharray:2 3;fill:none}.closed{fill:var(--closed);opacity:.6}"
    ".behind{fill:var(--closed);opacity:.2}.warned{fill:var(--warn);opacity:.45}"
    ".sensor{fill:var(--d)}.key{stroke-width:9;opacity:.6}.key.closed{stroke:var(--closed)}"
    ".key.behind{stroke:var(--closed);opacity:.25}.key.warned{stroke:var(--warn);opacity:.5}"
    ".key.sensor{stroke:var(--d);opacity:1}.s0{stroke:var(--a)}.s1{stroke:var(--b)}"
    ".s2{stroke:var(--c)}.s3{stroke:var(--d)}.s4{stroke:var(--e)}.s5{stroke:var(--f)}"
    ".dot.s0{fill:var(--a)}.dot.s1{fill:var(--b)}.dot.s2{fill:var(--c)}.dot.s3{fill:var(--d)}"
    ".dot.s4{fill:var(--e)}.dot.s5{fill:var(--f)}";

static void fact_estimate(FILE *out, const char *term, struct mr_estimate value, const struct unit *unit,
                          int decimals)
{
    double v = value.value * unit->factor;
    double e = value.error * unit->factor;
    html_fact(out, term, "%.*f \xc2\xb1 %.*f %s (95 %%: %.*f to %.*f)", decimals, v, decimals, e, unit->text,
              decimals, v - SUMMARY_95 * e, decimals, v + SUMMARY_95 * e);
}

/* ---- campaign ---- */

static double worst_rms_in(const struct report_landing *landing)
{
    double worst = (double)NAN;
    for (size_t i = 0; i < landing->simulations; i++)
        worst = fmax(worst, landing->simulation[i].rms_in);
    return worst;
}

static const struct measured_channel *largest_movement(const struct measured *measured)
{
    const struct measured_channel *largest = NULL;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind == MR_KIND_DISPLACEMENT && !isnan(channel->peak) &&
            (!largest || fabs(channel->peak) > fabs(largest->peak)))
            largest = channel;
    }
    return largest;
}

static void campaign_row(FILE *out, const struct report_landing *landing, bool si)
{
    const struct summary *summary = &landing->summary;
    const struct measured *measured = &summary->measured;
    const struct zone_warning *warning = &summary->zones.warning;
    const struct measured_channel *largest = largest_movement(measured);
    bool fitted = measured->fit_status == MR_OK;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    const struct mr_estimate speed = fitted ? measured->summary.touchdown_speed_ft_s : none;
    const struct mr_estimate deceleration = fitted ? measured->summary.mean_deceleration_ft_s2 : none;
    double station = unit_of(UNIT_STATION, si)->factor;
    fprintf(out, "<tr><td><a href=\"#run%lld\">%lld</a></td>", (long long)measured->landing.id,
            (long long)measured->landing.id);
    html_cell(out, "%lld, %s", (long long)measured->landing.board_landing,
              collector_state_text((unsigned)measured->landing.state));
    html_cell(out, "%zu of %zu", measured->gates, measured->switches);
    html_estimate(out, speed.value * unit_of(UNIT_SPEED, si)->factor,
                  speed.error * unit_of(UNIT_SPEED, si)->factor, 3);
    html_estimate(out, deceleration.value * unit_of(UNIT_DECELERATION, si)->factor,
                  deceleration.error * unit_of(UNIT_DECELERATION, si)->factor, 3);
    html_number(out, fitted ? station * measured->summary.stop_station_ft.value : (double)NAN, 1);
    if (largest)
        html_cell(out, "%.3f at %.0f", largest->peak * unit_of(UNIT_DISPLACEMENT, si)->factor,
                  station * (double)largest->config.station_ft);
    else
        html_number(out, (double)NAN, 0);
    if (warning->warned)
        fprintf(out, "<td class=\"warn\">%.1f to %.1f</td>", station * warning->start_ft,
                station * warning->end_ft);
    else
        html_cell(out, "none");
    html_cell(out, "%lld", (long long)(summary->link[LINK_CAN].lost + summary->link[LINK_SERIAL].lost));
    html_number(out, worst_rms_in(landing) * unit_of(UNIT_DISPLACEMENT, si)->factor, 3);
    fputs("</tr>\n", out);
}

static void campaign(FILE *out, const struct report_landing *landings, size_t count, bool si)
{
    char heads[7][60];
    snprintf(heads[0], sizeof heads[0], "touchdown speed, %s", unit_of(UNIT_SPEED, si)->text);
    snprintf(heads[1], sizeof heads[1], "mean deceleration, %s", unit_of(UNIT_DECELERATION, si)->text);
    snprintf(heads[2], sizeof heads[2], "stop, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[3], sizeof heads[3], "largest movement, %s at %s", unit_of(UNIT_DISPLACEMENT, si)->text,
             unit_of(UNIT_STATION, si)->text);
    snprintf(heads[4], sizeof heads[4], "zone warned of, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[5], sizeof heads[5], "worst rms against simulation, %s",
             unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out, (const char *const[]){"RUN", "landing", "switches", heads[0], heads[1], heads[2],
                                          heads[3], heads[4], "frames lost", heads[5], NULL});
    for (size_t i = 0; i < count; i++)
        campaign_row(out, &landings[i], si);
    fputs("</tbody></table></div>\n", out);
    fputs("<p>&plusmn; is one standard error.</p>\n", out);
    if (count > 1) {
        fputs("<figure>", out);
        plot_campaign(out, landings, count, si);
        fputs("<figcaption>Peak movement of each landing by station.</figcaption></figure>\n", out);
    }
}

/* ---- one landing ---- */

static void facts(FILE *out, const struct report_landing *landing, bool si)
{
    static const char *const sources[] = {"no readings came", "serial block records, 1 kHz",
                                          "CAN messages: displacements 500 Hz, tensions 250 Hz", "a file of another instrument"};
    const struct summary *summary = &landing->summary;
    const struct measured *measured = &summary->measured;
    const struct store_landing *row = &measured->landing;
    char text[200];
    fputs("<dl>\n", out);
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
        html_fact(out, "motion", "not known: %s", mr_status_text(measured->fit_status));
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
    html_fact(out, "readings from", "%s", sources[measured->source]);
    html_fact(out, "state", "%s", collector_state_text((unsigned)row->state));
    html_fact(out, "board", "%s", row->board_uid[0] ? row->board_uid : "unknown");
    html_fact(out, "firmware", "%s, image %08llx, commit %s", row->firmware[0] ? row->firmware : "unknown",
              row->image_crc == STORE_NONE ? 0ull : (unsigned long long)row->image_crc,
              row->image_commit[0] ? row->image_commit : "unknown");
    html_fact(out, "clock", "%s",
              row->clock_source > 0 ? "internal oscillator: 1 % in every speed" : "crystal");
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
}

static void zone_words(FILE *out, const struct zone_warning *w, bool since_touchdown, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    if (!w->warned) {
        fputs("<p class=\"say\">No warning was raised.</p>\n", out);
        return;
    }
    fprintf(
        out,
        "<p class=\"say\"><span class=\"warn\">Warned</span> %.3f s %s %s of %lld closed mats between"
        " stations %.1f and %.1f %s",
        fabs(w->t_s), w->t_s < 0.0 ? "before" : "after",
        since_touchdown ? "touchdown" : "the first switch or arming", (long long)w->mats, w->start_ft * station->factor,
        w->end_ft * station->factor, station->text);
    if (w->inferred_percent > 0)
        fprintf(out, " (%lld %% of it inferred from the survey alone)", (long long)w->inferred_percent);
    if (w->reached)
        fprintf(out, ". The wheel came there %.3f s later", w->true_lead_s);
    else
        fputs(". The wheel did not come there in the record", out);
    if (w->reason != STORE_NONE) {
        fprintf(out, ". Because %s", runway_reason_text((unsigned)w->reason));
        if (w->coming_mats > 0)
            fprintf(out, ": %lld mats before the wheel at station %.1f %s", (long long)w->coming_mats, w->coming_wheel_ft * station->factor,
                    station->text);
        if (!isnan(w->coming_after_s))
            fprintf(out, ", where it was %.3f s later", w->coming_after_s);
        if (!isnan(w->start_error_ft))
            fprintf(out, "; the ends are good to %.1f and %.1f %s (95 %%: twice that)", w->start_error_ft * station->factor,
                    w->end_error_ft * station->factor, station->text);
    }
    if (!isnan(w->lead_s)) {
        fprintf(out, ". The first lead time given was %.3f s, to station %.1f %s, at %.3f s", w->lead_s,
                w->lead_start_ft * station->factor, station->text, w->lead_t_s);
        if (isnan(w->lead_became_s))
            fputs("; the wheel did not come there in the record", out);
        else
            fprintf(out, "; it took %.3f s", w->lead_became_s);
    }
    fprintf(out, ". At its longest: %lld mats, %.1f to %.1f %s.</p>\n", (long long)w->most_mats,
            w->most_start_ft * station->factor, w->most_end_ft * station->factor, station->text);
}

static void channel_table(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    char heads[3][60];
    snprintf(heads[0], sizeof heads[0], "station, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[1], sizeof heads[1], "peak measured, %s", unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out, (const char *const[]){"transducer", heads[0], heads[1], "peak simulated",
                                          "rms difference", "end measured", "end simulated", "valid", NULL});
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        const struct store_simulation *row = NULL;
        for (size_t i = 0; i < landing->simulations; i++)
            row = landing->simulation[i].number == number ? &landing->simulation[i] : row;
        fputs("<tr>", out);
        html_cell(out, "%u", number);
        html_number(out, (double)channel->config.station_ft * unit_of(UNIT_STATION, si)->factor, 1);
        html_estimate(out, channel->peak * length, channel->error * length, 4);
        html_estimate(out, row ? row->peak_simulated_in * length : (double)NAN,
                      row ? row->peak_simulated_error_in * length : 0.0, 4);
        html_number(out, row ? row->rms_in * length : (double)NAN, 4);
        html_number(out, channel->end * length, 4);
        html_number(out, row ? row->end_simulated_in * length : (double)NAN, 4);
        html_cell(out, "%.1f %%",
                  measured->samples ? 100.0 * (double)channel->valid / (double)measured->samples : 0.0);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void gage_table(FILE *out, const struct measured *measured, bool si)
{
    double force = unit_of(UNIT_TENSION, si)->factor;
    char heads[2][60];
    snprintf(heads[0], sizeof heads[0], "station, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[1], sizeof heads[1], "before, %s", unit_of(UNIT_TENSION, si)->text);
    html_table(out, (const char *const[]){"gage", "band", heads[0], heads[1], "least", "most", "at the end",
                                          "valid", NULL});
    for (unsigned number = 1; number <= MR_GAGES; number++) {
        int c = measured_find(measured, MR_KIND_TENSION, number);
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        fputs("<tr>", out);
        html_cell(out, "%u", number);
        html_cell(out, "%u", channel->config.band);
        html_number(out, (double)channel->config.station_ft * unit_of(UNIT_STATION, si)->factor, 1);
        html_number(out, channel->baseline * force, 1);
        html_estimate(out, channel->low * force, channel->low_error * force, 2);
        html_estimate(out, channel->high * force, channel->high_error * force, 2);
        html_number(out, channel->end * force, 1);
        html_cell(out, "%.1f %%",
                  measured->samples ? 100.0 * (double)channel->valid / (double)measured->samples : 0.0);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void losses(FILE *out, const struct summary *summary)
{
    html_table(out, (const char *const[]){"link", "frames received", "lost", "not sent by the board", NULL});
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct summary_link *link = &summary->link[kind];
        fputs("<tr>", out);
        html_cell(out, "%s", summary_link_name(kind));
        if (link->used) {
            html_cell(out, "%lld", (long long)link->received);
            html_cell(out, "%lld%s", (long long)link->lost, link->silent ? ", silent in part" : "");
            html_cell(out, "%lld", (long long)link->dropped);
        } else {
            fputs("<td colspan=\"3\">not used</td>", out);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
    for (size_t i = 0; i < summary->gaps; i++) {
        char line[160];
        summary_gap(&summary->gap[i], line, sizeof line);
        fputs("<p class=\"say\">Gap: ", out);
        html_text(out, line);
        fputs(".</p>\n", out);
    }
    if (summary->gaps == 0)
        fputs("<p>No gaps.</p>\n", out);
    const struct measured_check *check = &summary->measured.check;
    if (check->compared)
        fprintf(out,
                "<p>%zu values that came over CAN were held against the serial block records: %zu differ by "
                "more than a"
                " digit of the wire.</p>\n",
                check->compared, check->different);
    if (summary->faults == 0)
        fputs("<p>No faults were reported.</p>\n", out);
    for (size_t i = 0; i < summary->faults; i++) {
        fputs("<p class=\"say\">Fault: ", out);
        html_text(out, mr_fault_text((unsigned)summary->fault[i].code));
        fprintf(out, " [%lld], %lld times.</p>\n", (long long)summary->fault[i].detail,
                (long long)summary->fault[i].count);
    }
}

/* What had been looked at before the landing. */
static void readiness(FILE *out, const struct summary *summary)
{
    char text[460];
    for (int kind = 0; kind < SUMMARY_READY_KINDS; kind++) {
        if (!summary->ready[kind].known)
            continue;
        summary_ready_text(&summary->ready[kind], text, sizeof text);
        fprintf(out, "<p%s>%s: ", summary->ready[kind].go ? "" : " class=\"say\"", kind == 0 ? "Ready" : "Walk test");
        html_text(out, text);
        fputs(".</p>\n", out);
    }
}

static void figure(FILE *out, const char *head, void (*plot)(FILE *, const struct report_landing *, bool),
                   const struct report_landing *landing, bool si, const char *caption)
{
    fprintf(out, "<h3>%s</h3><figure>", head);
    plot(out, landing, si);
    fprintf(out, "<figcaption>%s</figcaption></figure>\n", caption);
}

static void landing_section(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    fprintf(out, "<section id=\"run%lld\"><h2>RUN %lld: landing %lld</h2>\n", (long long)measured->landing.id,
            (long long)measured->landing.id, (long long)measured->landing.board_landing);
    facts(out, landing, si);
    if (measured->source == MEASURED_IMPORT)
        fputs("<p class=\"say\">No board watched for zones: the readings are another instrument's.</p>\n", out);
    else
        zone_words(out, &landing->summary.zones.warning, measured->t0_is_touchdown, si);
    if (measured->fit_status == MR_OK && measured->samples > 0) {
        figure(out, "Speed", plot_speed, landing, si,
               "From the switches; their places are the only measure of length.");
        figure(out, "Movement of the mat", plot_displacements, landing, si,
               "Downfield is positive, since the mean of the half second before the first switch opened.");
        figure(out, "Zone map", plot_zones, landing, si,
               "Closed segments are found here from survey and transducers, the zone warned of is what the "
               "board said.");
        figure(out, "Band tensions", plot_tensions, landing, si, "As read.");
    }
    if (measured->samples > 0) {
        fputs("<h3>Transducers</h3>\n", out);
        channel_table(out, landing, si);
        fprintf(out,
                "<p>Peaks are extremes of an %d ms moving mean; &plusmn; is one standard error, calibration "
                "and noise together, or the simulation's own estimate%s.</p>\n",
                MEASURED_WINDOW, landing->simulations ? "" : ". No comparison has been run: matrig compare");
        fputs("<h3>Gages</h3>\n", out);
        gage_table(out, measured, si);
        bands_page(&landing->summary.bands, measured, si, out);
    }
    readiness(out, &landing->summary);
    fputs("<h3>Losses and faults</h3>\n", out);
    losses(out, &landing->summary);
    fputs("</section>\n", out);
}

/* Nothing when there is nothing to draw. */
static void slow_section(FILE *out, const struct store_slow *slow, size_t count, bool si)
{
    char *picture = NULL;
    size_t size = 0;
    FILE *into = open_memstream(&picture, &size);
    if (!into)
        abort();
    bool drawn = plot_slow(into, slow, count, si);
    fclose(into);
    if (drawn)
        fprintf(out, "<section id=\"slow\"><h2>Between the landings</h2><figure>%s<figcaption>The slow log, a row a minute: each transducer "
                "(its number at the right) against its first row, the mean of the gages, the mat's temperature.</figcaption></figure></section>\n", picture);
    free(picture);
}

void page_head(FILE *out, const char *title)
{
    fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<meta name=\"color-scheme\" content=\"light dark\"><title>",
          out);
    html_text(out, title);
    fputs("</title>\n<style>", out);
    fputs(style, out);
    fputs("</style></head>\n<body>", out);
}

void page_write(FILE *out, const char *name, const struct report_landing *landings, size_t count,
                const struct store_slow *slow, size_t slow_count, const char *more, bool si)
{
    page_head(out, name);
    fputs("<h1>Campaign report</h1>\n<p>", out);
    html_text(out, name);
    fprintf(out, ": %zu landing%s on the model landing-mat runway.</p>\n", count, count == 1 ? "" : "s");
    if (count > 0)
        campaign(out, landings, count, si);
    slow_section(out, slow, slow_count, si);
    fputs(more, out);
    for (size_t i = 0; i < count; i++)
        landing_section(out, &landings[i], si);
    fputs("</body></html>\n", out);
}
