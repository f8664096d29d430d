#include "host/live/terminal.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <time.h>

#include "host/base/units.h"

#define COLUMNS_LEAST 40u
#define COLUMNS_MOST  300u
#define WIDE          132u /* three columns of readings with their least and most; */
#define MIDDLE        56u  /* three without; less: two */
#define ROOMY         64u  /* a zone's place and time on one line */
#define SILENT_US     1000000
#define DAY_US        86400000000
#define RUNWAY_FT     120.0

static const char reset[] = "\033[0m", bold[] = "\033[1m", alarm_[] = "\033[1;30;43m",
                  bad[] = "\033[1;31m";

/* A screen being drawn, line by line. */
struct canvas {
    FILE *out;
    const struct live_screen *screen;
    unsigned columns, line;
};

/* One line, cut at the width; `look` is an ANSI sequence that is not counted, NULL: none. Lines
 * beyond the screen are left out. */
static void line(struct canvas *canvas, const char *look, const char *format, ...)
{
    char text[COLUMNS_MOST + 1];
    va_list arguments;
    if (canvas->line + 1 >= canvas->screen->rows)
        return;
    va_start(arguments, format);
    vsnprintf(text, canvas->columns + 1 < sizeof text ? canvas->columns + 1 : sizeof text, format,
              arguments);
    va_end(arguments);
    for (char *p = text; *p; p++) { /* names of files may hold anything */
        if ((unsigned char)*p < 0x20 || (unsigned char)*p == 0x7f)
            *p = '?';
    }
    bool dressed = look && canvas->screen->colour;
    fprintf(canvas->out, "%s%s%s\033[K\n", dressed ? look : "", text, dressed ? reset : "");
    canvas->line++;
}

/* "35.49", or a dash of the same kind when it is not known. */
static const char *value_text(double value, const struct unit *unit, int decimals, char out[24])
{
    if (isfinite(value))
        snprintf(out, 24, "%.*f", decimals, unit_tidy(value * unit->factor, pow(10.0, -decimals)));
    else
        snprintf(out, 24, "-");
    return out;
}

static void board_text(const struct live_model *model, int64_t now_us, char *out, size_t size)
{
    int64_t heard_us = live_model_heard_us(model);
    unsigned faults = 0;
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++)
        faults += model->health_known && (model->health.faults >> i & 1u);
    if (!heard_us)
        snprintf(out, size, "waiting for a board");
    else if (now_us - heard_us > DAY_US) /* also of a log that has no times of day */
        snprintf(out, size, "!! SILENT for more than a day");
    else if (now_us - heard_us > SILENT_US)
        snprintf(out, size, "!! SILENT for %.1f s", (double)(now_us - heard_us) / 1e6);
    else if (faults)
        snprintf(out, size, "alive, %u fault%s", faults, faults == 1 ? "" : "s");
    else
        snprintf(out, size, "alive");
}

static void place_text(const struct live_zone *zone, bool si, char *out, size_t size)
{
    const struct unit *ft = unit_of(UNIT_STATION, si);
    char from[24], to[24];
    if (zone->block < 0 || zone->mats == 0)
        snprintf(out, size, "none");
    else
        snprintf(out, size, "%u mats closed, %s to %s %s", zone->mats,
                 value_text(zone->start_ft, ft, 1, from), value_text(zone->end_ft, ft, 1, to),
                 ft->text);
}

static void lead_text(const struct live_zone *zone, char *out, size_t size)
{
    if (zone->lead_s == 0.0)
        snprintf(out, size, "the wheel is at it");
    else if (isfinite(zone->lead_s))
        snprintf(out, size, "wheel there in %.2f s", zone->lead_s);
    else
        snprintf(out, size, "no time to it known");
}

/* Place and time on one line. */
static void zone_text(const struct live_zone *zone, bool si, char *out, size_t size)
{
    char place[70], lead[40];
    bool any = zone->block >= 0 && zone->mats > 0;
    place_text(zone, si, place, sizeof place);
    lead_text(zone, lead, sizeof lead);
    snprintf(out, size, "%s%s%s", place, any ? ", " : "", any ? lead : "");
}

/* The numbers that an advisory is about; empty: they did not come. */
static void advice_text(const struct live_verdict *verdict, bool si, char *out, size_t size)
{
    const struct unit *ft = unit_of(UNIT_STATION, si), *lb = unit_of(UNIT_TENSION, si);
    char at[24], compression[24], critical[24];
    out[0] = '\0';
    if (verdict->said.reason == MR_PREDICTOR_COMPRESSION && verdict->press_known)
        snprintf(out, size, ": %s of %s %s",
                 value_text((double)verdict->press.compression_lb, lb, 0, compression),
                 value_text((double)verdict->press.critical_lb, lb, 0, critical), lb->text);
    else if (verdict->said.reason != MR_PREDICTOR_COMPRESSION && verdict->coming_known)
        snprintf(out, size, ": %u mats, the wheel then at %s %s", verdict->coming.mats,
                 value_text((double)verdict->coming.wheel_ft, ft, 1, at), ft->text);
}

static void gear_text(const struct live_model *model, bool si, char *out, size_t size)
{
    const struct unit *ft = unit_of(UNIT_STATION, si), *speed = unit_of(UNIT_SPEED, si);
    const struct mr_touchdown *touchdown = &model->touchdown;
    char at[24], fast[24], error[24];
    const int decimals = si ? 3 : 2;
    value_text(live_model_gear_ft(model), ft, 1, at);
    if (model->stop_known && model->touchdown_known)
        snprintf(out, size, "%s %s, at rest; touchdown %s +- %s %s, %u switches", at, ft->text,
                 value_text((double)touchdown->speed_ft_s, speed, decimals, fast),
                 value_text((double)touchdown->speed_error_ft_s, speed, decimals, error),
                 speed->text, model->edges);
    else if (model->stop_known)
        snprintf(out, size, "%s %s, at rest, %u switches", at, ft->text, model->edges);
    else if (isfinite(model->speed_ft_s))
        snprintf(out, size, "%s %s, %s %s at the last switch, %u switches", at, ft->text,
                 value_text((double)model->speed_ft_s, speed, 2, fast), speed->text, model->edges);
    else
        snprintf(out, size, "%s %s, no speed yet, %u switches", at, ft->text, model->edges);
}

static const char *state_text(const struct live_model *model)
{
    return model->state_known ? mr_landing_state_text(model->state) : "unknown";
}

void live_terminal_line(FILE *out, const struct live_model *model, int64_t now_us, bool si)
{
    char board[60], gear[80], zone[130], advice[60], advised[160] = "", risk[40] = "";
    const struct store_link_counts *can = &model->link[LINK_CAN].counts,
                                   *serial = &model->link[LINK_SERIAL].counts;
    board_text(model, now_us, board, sizeof board);
    gear_text(model, si, gear, sizeof gear);
    zone_text(&model->zone, si, zone, sizeof zone);
    advice_text(&model->verdict, si, advice, sizeof advice);
    if (live_model_advised(model) && !model->warning.on)
        snprintf(advised, sizeof advised, "advisory: %s%s, ",
                 mr_predictor_reason_text(model->verdict.said.reason), advice);
    if (model->risk.block >= 0 && isfinite(model->risk.said.risk))
        snprintf(risk, sizeof risk, "  risk %.2f%s", (double)model->risk.said.risk,
                 model->risk.release_block >= 0 && model->risk.release.state == MR_RELEASE_ASKED
                     ? ", RELEASE"
                     : "");
    fprintf(
        out,
        "%.1f s  board %s  %s %u  gear %s  %s%s%s%s  CAN %lld lost %lld  serial %lld lost %lld\n",
        (double)live_model_block(model) / 1000.0, board, state_text(model), model->landing, gear,
        advised, model->warning.on ? "WARNING: " : "zone ", zone, risk, (long long)can->received,
        (long long)can->lost, (long long)serial->received, (long long)serial->lost);
}

/* ---- the runway ---- */

static unsigned column_of(double ft, unsigned width)
{
    double at = ft / RUNWAY_FT * (double)(width - 1);
    return !(at > 0.0) ? 0u : at > (double)(width - 1) ? width - 1 : (unsigned)lround(at);
}

/* 'W' the gear's wheel, '#' closed mats, '-' the rest; transducers above, switches below, passed
 * ones as '|'. */
static void draw_runway(struct canvas *canvas, const struct live_model *model, bool si)
{
    char sensors[COLUMNS_MOST + 1], mats[COLUMNS_MOST + 1], switches[COLUMNS_MOST + 1];
    const struct unit *ft = unit_of(UNIT_STATION, si);
    unsigned width = canvas->columns - 2;
    memset(sensors, ' ', width);
    memset(mats, '-', width);
    memset(switches, ' ', width);
    sensors[width] = mats[width] = switches[width] = '\0';
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (model->channel_known[i] && mr_channel_measures(&model->channel[i]))
            sensors[column_of((double)model->channel[i].station_ft, width)] = (char)('1' + i);
    }
    for (unsigned i = 0; i < STORE_SWITCHES_MAX; i++) {
        if (model->switch_known[i])
            switches[column_of((double)model->switch_ft[i], width)] = model->opened >> i & 1u ? '|'
                                                                                              : '.';
    }
    if (model->zone.block >= 0 && model->zone.mats > 0) {
        unsigned first = column_of(model->zone.start_ft, width),
                 last = column_of(model->zone.end_ft, width);
        memset(mats + first, '#', last - first + 1);
    }
    if (isfinite(live_model_gear_ft(model)))
        mats[column_of(live_model_gear_ft(model), width)] = 'W';
    line(canvas, NULL, " %s", sensors);
    line(canvas, bold, "[%s]", mats);
    line(canvas, NULL, " %s", switches);
    line(canvas, NULL, " 0 to %.0f %s; W wheel, # closed mats, 1-8 transducers, . switch, | passed",
         RUNWAY_FT * ft->factor, ft->text);
}

/* ---- readings ---- */

/* "D1    40.0 ft    0.4003 in [-0.0036, 0.4041]": newest, least and most since arming; or name and
 * newest alone. */
static void reading_text(const struct live_model *model, unsigned index, bool si, bool all,
                         char *out, size_t size)
{
    const struct live_reading *r = &model->reading[index];
    bool displacement = index < MR_TRANSDUCERS;
    const struct unit *unit = unit_of(displacement ? UNIT_DISPLACEMENT : UNIT_TENSION, si),
                      *ft = unit_of(UNIT_STATION, si);
    int decimals = displacement ? (si ? 2 : 4) : (si ? 0 : 1);
    char value[24], least[24], most[24], at[24];
    char name = displacement ? 'D' : 'T';
    unsigned number = displacement ? index + 1 : index - MR_TRANSDUCERS + 1;
    const char *why = live_model_reading_text(model, index);
    const char *said = *why ? why : value_text((double)r->value, unit, decimals, value);
    double station_ft = model->channel_known[index] ? (double)model->channel[index].station_ft
                                                    : (double)NAN;
    if (all)
        snprintf(out, size, "%c%-2u %6s %s %9s %s [%s, %s]", name, number,
                 value_text(station_ft, ft, 1, at), ft->text, said, unit->text,
                 value_text((double)r->least, unit, decimals, least),
                 value_text((double)r->most, unit, decimals, most));
    else
        snprintf(out, size, "%c%-2u %9s %s", name, number, said, unit->text);
}

static bool fitted(const struct live_model *model, unsigned index)
{
    return !model->channel_known[index] || mr_channel_measures(&model->channel[index]);
}

/* Displacements, and tensions beside them in two columns; in one when the screen is narrow. */
static void draw_readings(struct canvas *canvas, const struct live_model *model, bool si)
{
    char text[3][120];
    bool all = canvas->columns + 1 >= WIDE, two = canvas->columns + 1 < MIDDLE;
    unsigned rows = two ? MR_GAGES : MR_TRANSDUCERS, half = two ? MR_GAGES : MR_GAGES / 2;
    line(
        canvas, bold,
        all ? " displacement [least, most since arming]          tension [least, most since arming]"
            : " displacement, tension");
    for (unsigned row = 0; row < rows; row++) {
        const unsigned index[3] = {row < MR_TRANSDUCERS ? row : LIVE_CHANNELS,
                                   row < half ? MR_TRANSDUCERS + row : LIVE_CHANNELS,
                                   !two && row < half ? MR_TRANSDUCERS + half + row
                                                      : LIVE_CHANNELS};
        for (unsigned i = 0; i < 3; i++) {
            text[i][0] = '\0';
            if (index[i] < LIVE_CHANNELS && fitted(model, index[i]))
                reading_text(model, index[i], si, all, text[i], sizeof text[i]);
        }
        if (text[0][0] || text[1][0] || text[2][0])
            line(canvas, NULL, all ? " %-46s %-42s %s" : " %-17s %-16s %s", text[0], text[1],
                 text[2]);
    }
}

/* ---- the whole ---- */

static void draw_warning(struct canvas *canvas, const struct live_model *model, bool si)
{
    char place[70], lead[40], rule[COLUMNS_MOST + 1];
    const struct live_warning *warning = &model->warning;
    const struct live_zone *zone = warning->on || !warning->since_us ? &model->zone
                                                                     : &warning->zone;
    bool roomy = canvas->columns + 1 >= ROOMY;
    place_text(zone, si, place, sizeof place);
    lead_text(zone, lead, sizeof lead);
    if (!warning->on && live_model_advised(model)) {
        char advice[60];
        advice_text(&model->verdict, si, advice, sizeof advice);
        line(canvas, bold, " advisory, no warning%s", advice);
        line(canvas, NULL, "   %s", mr_predictor_reason_text(model->verdict.said.reason));
    }
    if (!warning->on) {
        if (warning->since_us)
            line(canvas, NULL, " was warned (block %lld), over now: %s",
                 (long long)warning->first_block, place);
        else
            line(canvas, NULL, " no warning; closed ahead: %s", place);
        return;
    }
    memset(rule, '!', canvas->columns);
    rule[canvas->columns] = '\0';
    line(canvas, alarm_, "%s", rule);
    line(canvas, alarm_, "!!! WARNING: JOINTS CLOSED AHEAD%*s", (int)canvas->columns - 32, "!!!");
    line(canvas, alarm_, roomy ? "!!! %s, %s" : "!!! %s", place, lead);
    if (!roomy)
        line(canvas, alarm_, "!!! %s", lead);
    line(canvas, alarm_, "%s", rule);
}

static void draw_links(struct canvas *canvas, const struct live_model *model)
{
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct live_link *link = &model->link[kind];
        bool lossy = link->counts.lost + link->counts.dropped + link->counts.bad > 0;
        if (link->used)
            line(canvas, lossy ? bad : NULL,
                 " %-6s %lld frames, %lld lost, %lld dropped, %lld broken",
                 kind == LINK_CAN ? "CAN" : "serial", (long long)link->counts.received,
                 (long long)link->counts.lost, (long long)link->counts.dropped,
                 (long long)link->counts.bad);
    }
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (model->health_known && model->health.faults >> i & 1u)
            line(canvas, bad, " ! fault: %s (%u times)", mr_fault_text(i), model->fault_count[i]);
    }
}

static void draw_notices(struct canvas *canvas, const struct live_model *model)
{
    for (uint64_t i = model->notices; i > 0 && i + 8 > model->notices; i--) {
        const struct live_notice *notice = &model->notice[(i - 1) % LIVE_NOTICES];
        time_t when = (time_t)(notice->host_us / 1000000);
        struct tm local;
        char clock[12];
        if (i + LIVE_NOTICES < model->notices || !localtime_r(&when, &local))
            return;
        strftime(clock, sizeof clock, "%H:%M:%S", &local);
        line(canvas, NULL, " %s %s%s", clock, notice->severity == LIVE_ALARM ? "! " : "",
             notice->text);
    }
}

void live_terminal_draw(FILE *out, const struct live_model *model, int64_t now_us, const char *db,
                        const struct live_screen *screen)
{
    unsigned columns = screen->columns < COLUMNS_LEAST ? COLUMNS_LEAST
                     : screen->columns > COLUMNS_MOST  ? COLUMNS_MOST
                                                       : screen->columns;
    struct canvas canvas = {.out = out, .screen = screen, .columns = columns - 1};
    char board[60], gear[80];
    board_text(model, now_us, board, sizeof board);
    gear_text(model, screen->si, gear, sizeof gear);
    fputs("\033[H", out);
    draw_warning(&canvas, model, screen->si);
    line(&canvas, strstr(board, "!!") ? bad : bold, " BOARD %s   LANDING %s %u", board,
         state_text(model), model->landing);
    line(&canvas, bold, " GEAR  %s", gear);
    draw_runway(&canvas, model, screen->si);
    draw_links(&canvas, model);
    draw_readings(&canvas, model, screen->si);
    line(&canvas, NULL, " %.1f s board time, %s; Ctrl-C ends",
         (double)live_model_block(model) / 1000.0, db);
    draw_notices(&canvas, model);
    fputs("\033[J", out);
}
