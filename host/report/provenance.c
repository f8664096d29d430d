/* Where it all comes from: tool, database, boards, configurations, calibrations, links, records,
 * and a hash of what was drawn. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "common/version.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/survey/survey_answer.h"

#define DAY_S 86400

/* Of SOURCE_DATE_EPOCH where it is set, so that the same page can be made again. */
static int64_t now_us(void)
{
    const char *fixed = getenv("SOURCE_DATE_EPOCH");
    return 1000000 * (fixed ? strtoll(fixed, NULL, 10) : (int64_t)time(NULL));
}

static void general(const struct report *report, const char *drawn, FILE *out)
{
    char when[40];
    struct stat file;
    const char *name = strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path;
    survey_time_text(now_us(), when, sizeof when);
    fputs("<dl>\n", out);
    html_fact(out, "made by", "matrig " VERSION_TEXT);
    html_fact(out, "made", "%s", when);
    html_fact(out, "database", "%s, version %d", name, STORE_VERSION);
    if (stat(report->path, &file) == 0)
        html_fact(out, "its size", "%lld bytes", (long long)file.st_size);
    html_fact(out, "SHA-256 of the page, <main> to </main>", "%s", drawn);
    fputs("</dl>\n", out);
}

static void landing_row(const struct report_facts *facts, FILE *out)
{
    const struct store_landing *row = &facts->landing;
    char when[40];
    survey_time_text(row->armed_us, when, sizeof when);
    fputs("<tr>", out);
    html_cell(out, "%lld", (long long)row->id);
    html_cell(out, "%s", when);
    html_cell(out, "%s", row->board_uid[0] ? row->board_uid : "unknown");
    html_cell(out, "%s, %08llx, %s", row->firmware[0] ? row->firmware : "unknown",
              row->image_crc == STORE_NONE ? 0ull : (unsigned long long)row->image_crc,
              row->image_commit[0] ? row->image_commit : "unknown");
    if (row->config_crc == STORE_NONE)
        html_cell(out, "unknown");
    else
        html_cell(out, "%08llx%s", (unsigned long long)row->config_crc,
                  facts->config_read ? "" : ", not read");
    html_cell(out, "CAN %s; serial %s", facts->can_link[0] ? facts->can_link : "not used",
              facts->serial_link[0] ? facts->serial_link : "not used");
    html_cell(out, "%zu of %u segments", facts->surveyed, MR_SEGMENTS);
    fprintf(out, "<td class=\"hash\">%s</td></tr>\n",
            facts->records[0] ? facts->records : "no block records");
}

static void landings(const struct report *report, FILE *out)
{
    if (report->landings == 0)
        return;
    fputs("<h3>Landings</h3>\n", out);
    html_table(out, (const char *const[]){"RUN", "armed", "board",
                                          "firmware, CRC-32 of its image, commit",
                                          "configuration, CRC-32", "links", "survey",
                                          "SHA-256 of its block records", NULL});
    for (size_t i = 0; i < report->landings; i++)
        landing_row(&report->facts[i], out);
    fputs("</tbody></table></div>\n", out);
}

static void day_cell(FILE *out, uint32_t day, bool expired)
{
    time_t second = (time_t)day * DAY_S;
    struct tm utc;
    char text[20];
    if (day == 0) {
        html_cell(out, "never");
        return;
    }
    gmtime_r(&second, &utc);
    strftime(text, sizeof text, "%Y-%m-%d", &utc);
    fprintf(out, "<td%s>%s%s</td>", expired ? " class=\"warn\"" : "", text,
            expired ? ", before the landing" : "");
}

/* Sensor and dates are in the configuration that the board was asked for, if it was. */
static void sensor_cells(FILE *out, const struct mr_channel_config *told, int64_t used_day)
{
    if (!told) {
        fputs("<td colspan=\"3\">configuration not read</td>", out);
        return;
    }
    html_cell(out, "%.*s", (int)sizeof told->serial,
              told->serial[0] ? told->serial : "not entered");
    day_cell(out, told->calibrated_day, false);
    day_cell(out, told->expires_day, told->expires_day && (int64_t)told->expires_day <= used_day);
}

/* As the landing is read with. */
static void calibrations(const struct report_landing *landing, FILE *out)
{
    const struct measured *measured = &landing->summary.measured;
    html_table(out, (const char *const[]){"channel", "sensor", "calibrated", "expires",
                                          "in or lb per code", "its error, %",
                                          "error of the zero, in or lb", NULL});
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        const struct mr_channel_config *channel = &measured->channel[i].config;
        if (!mr_channel_measures(channel))
            continue;
        fputs("<tr>", out);
        html_cell(out, "%s %u", channel->kind == MR_KIND_DISPLACEMENT ? "transducer" : "gage",
                  channel->number);
        sensor_cells(out, landing->config ? &landing->config->channel[i] : NULL,
                     measured->landing.armed_us / 1000000 / DAY_S);
        html_cell(out, "%.9g", (double)channel->unit_per_code);
        html_number(out, 100.0 * (double)channel->gain_error, 3);
        html_number(out, (double)channel->zero_error, 4);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

void provenance_calibration(const struct report_landing *landing, FILE *out)
{
    fprintf(out, "<h3>Calibration from RUN %lld on</h3>\n<p>",
            (long long)landing->summary.measured.landing.id);
    if (landing->config) {
        const struct mr_site_config *site = &landing->config->site[0];
        char name[sizeof site->name + 1];
        snprintf(name, sizeof name, "%.*s", (int)sizeof site->name, site->name);
        fputs("Configuration ", out);
        html_text(out, name);
        fprintf(out, ", revision %u.</p>\n", site->revision);
    } else {
        fputs("The board's configuration was not read (matrig log asks for it, where the link "
              "goes both ways).</p>\n",
              out);
    }
    calibrations(landing, out);
}

/* What of the landings is read with another calibration than it was recorded with. */
static void recalibrated(const struct report *report, FILE *out)
{
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].recalibrated)
            fprintf(out,
                    "<p class=\"say\">RUN %lld is read with a corrected calibration; what was in "
                    "force is kept in the campaign.</p>\n",
                    (long long)report->facts[i].landing.id);
    }
}

void provenance_write(const struct report *report, const char *drawn, const char *calibrations,
                      FILE *out)
{
    fputs("<section id=\"provenance\"><h2>Provenance</h2>\n", out);
    general(report, drawn, out);
    landings(report, out);
    fputs(calibrations, out);
    recalibrated(report, out);
    fputs("</section>\n", out);
}
