#include "host/survey/show.h"

#include <math.h>
#include <time.h>

#include "host/base/cli.h"
#include "host/base/units.h"

#define Z_95 1.96

void survey_time_text(int64_t host_us, char *out, size_t size)
{
    time_t seconds = (time_t)(host_us / 1000000);
    struct tm when;
    gmtime_r(&seconds, &when);
    strftime(out, size, "%Y-%m-%d %H:%M UTC", &when);
}

const char *survey_bow_verdict(const struct survey_found *found)
{
    double bow_in = fabs(found->worst_bow_in);
    if (isnan(bow_in))
        return "not known";
    if (bow_in > SURVEY_BOW_LIMIT_IN)
        return "beyond";
    return bow_in + Z_95 * found->worst_bow_error_in > SURVEY_BOW_LIMIT_IN ? "perhaps beyond" : "within";
}

/* A number of `width`, a dash when it is not known. */
static void cell(FILE *out, double value, int width, int decimals, bool sign)
{
    if (isnan(value))
        fprintf(out, "  %*s", width, "-");
    else if (sign)
        fprintf(out, "  %+*.*f", width, decimals, value);
    else
        fprintf(out, "  %*.*f", width, decimals, value);
}

static void show_head(FILE *out, const struct survey *survey)
{
    const struct store_gage_survey *row = &survey->row;
    char when[40];
    survey_time_text(row->made_us, when, sizeof when);
    fprintf(out, "survey %lld, %s pattern, begun %s%s%s", (long long)row->id, row->pattern, when, row->who[0] ? " by " : "", row->who);
    if (row->after_run != STORE_NONE)
        fprintf(out, ", after RUN %lld", (long long)row->after_run);
    fprintf(out, ": %zu of %zu read, %zu confirmed, %s\n", survey_desk_read(&survey->desk), survey->desk.plan.count, survey->confirmed,
            row->ended_us == STORE_NONE ? "goes on" : "ended");
    if (row->note[0])
        fprintf(out, "  %s\n", row->note);
}

static void show_spans(FILE *out, const struct survey *survey, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    int decimals = si ? 2 : 4;
    bool changed = found->previous != 0;
    fprintf(out, "%s of ten mats, %s, lines 1 to 4, and the opening of the joints\n", changed ? "opening (+) and closing (-)" : "distance of the gage points",
            length->text);
    fprintf(out, "%8s  %8s  %8s  %8s  %8s  %8s  %8s\n", station->text, "line 1", "line 2", "line 3", "line 4", "opening", "error");
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        bool any = false;
        for (unsigned line = 0; line < SURVEY_LINES; line++)
            any |= !isnan(survey->readings.gap_in[line][k]);
        if (!any)
            continue;
        fprintf(out, "%8.1f", SURVEY_SPAN_FT * k * station->factor);
        for (unsigned line = 0; line < SURVEY_LINES; line++)
            cell(out, (changed ? found->since_previous.change.gap_in : survey->readings.gap_in)[line][k] * length->factor, 8, decimals, changed);
        cell(out, found->slack.segment[k].value_in * length->factor, 8, decimals, false);
        cell(out, found->slack.segment[k].error_in * length->factor, 8, decimals, false);
        fputc('\n', out);
    }
    if (changed)
        fprintf(out, "a change is known to %.4f %s (standard error)\n", found->since_previous.change.error_in * length->factor, length->text);
}

static void show_stations(FILE *out, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    bool told = false;
    for (unsigned line = 0; found->previous && line < SURVEY_LINES; line++) {
        for (unsigned s = 0; s < SURVEY_STATIONS; s++) {
            double moved_in = found->since_previous.change.station_in[line][s], away_in = found->since_previous.change.across_in[line][s];
            if (isnan(moved_in) && isnan(away_in))
                continue;
            if (!told)
                fprintf(out, "stations: movement since survey %lld, %s +- %.4f\n", (long long)found->previous, length->text,
                        found->since_previous.station_error_in * length->factor);
            told = true;
            fprintf(out, "%8.1f  line %u  downfield", SURVEY_STATION_FT * s * station->factor, line + 1);
            cell(out, moved_in * length->factor, 8, 3, true);
            if (!isnan(away_in)) {
                fprintf(out, "  across");
                cell(out, away_in * length->factor, 8, 3, true);
            }
            fputc('\n', out);
        }
    }
}

static void show_diagonals(FILE *out, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    for (unsigned line = 0; found->previous && line < SURVEY_DIAGONALS; line++) {
        bool any = false;
        for (unsigned k = 0; k < SURVEY_DIAGONAL_SPANS; k++)
            any |= !isnan(found->since_previous.change.diagonal_in[line][k]);
        if (!any)
            continue;
        fprintf(out, "45 degree line %u, opening of ten mats, %s:", line + 1, length->text);
        for (unsigned k = 0; k < SURVEY_DIAGONAL_SPANS; k++)
            cell(out, found->since_previous.change.diagonal_in[line][k] * length->factor, 8, si ? 2 : 4, true);
        fputc('\n', out);
    }
}

static void show_bow(FILE *out, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    if (!found->first) {
        fprintf(out, "first survey of this pattern: later ones are compared with it\n");
        return;
    }
    if (isnan(found->worst_bow_in)) {
        fprintf(out, "in-plane bow: not known, it needs lines 1 and 4, and 2 or 3\n");
        return;
    }
    fprintf(out, "in-plane bow since survey %lld: at most %+.3f +- %.3f %s, at %.1f %s: %s the limit of %.3f %s\n", (long long)found->first,
            found->worst_bow_in * length->factor, found->worst_bow_error_in * length->factor, length->text,
            found->worst_bow_ft * station->factor, station->text, survey_bow_verdict(found), SURVEY_BOW_LIMIT_IN * length->factor,
            length->text);
}

/* Every 10 ft, the nearest gage point. */
static void show_movement(FILE *out, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    if (!found->previous || found->since_previous.compared == 0)
        return;
    fprintf(out, "movement since survey %lld, %s downfield +- standard error, and bow since survey %lld\n", (long long)found->previous,
            length->text, (long long)found->first);
    for (unsigned s = 0; s < SURVEY_STATIONS; s++) {
        unsigned k = (unsigned)lround(SURVEY_STATION_FT * s / SURVEY_SPAN_FT);
        fprintf(out, "%8.1f", SURVEY_SPAN_FT * k * station->factor);
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            const struct survey_estimate *u = &found->since_previous.moved[line][k];
            cell(out, u->value_in * length->factor, 7, 3, true);
            if (!isnan(u->value_in))
                fprintf(out, " +- %.3f", u->error_in * length->factor);
        }
        cell(out, found->since_first.bow[k].value_in * length->factor, 7, 3, true);
        fputc('\n', out);
    }
}

void survey_show(FILE *out, const struct survey *survey, const struct survey_found *found, bool si)
{
    show_head(out, survey);
    show_spans(out, survey, found, si);
    show_stations(out, found, si);
    show_diagonals(out, found, si);
    show_movement(out, found, si);
    show_bow(out, found, si);
}

static json_t *estimates(const struct survey_estimate *e, size_t count, double factor)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_pack("[o,o]", cli_json_number(e[i].value_in * factor, 6), cli_json_number(e[i].error_in * factor, 4)));
    return list;
}

static json_t *numbers(const double *value, size_t count, double factor)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, cli_json_number(value[i] * factor, 7));
    return list;
}

static json_t *readings_json(const struct survey_readings *r, double factor)
{
    json_t *gaps = json_array(), *stations = json_array(), *across = json_array(), *diagonals = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        json_array_append_new(gaps, numbers(r->gap_in[line], SURVEY_SPANS, factor));
        json_array_append_new(stations, numbers(r->station_in[line], SURVEY_STATIONS, factor));
        json_array_append_new(across, numbers(r->across_in[line], SURVEY_STATIONS, factor));
    }
    for (unsigned line = 0; line < SURVEY_DIAGONALS; line++)
        json_array_append_new(diagonals, numbers(r->diagonal_in[line], SURVEY_DIAGONAL_SPANS, factor));
    return json_pack("{sososososo}", "gap", gaps, "station", stations, "across", across, "diagonal", diagonals, "error",
                     cli_json_number(r->error_in * factor, 4));
}

static json_t *moved_json(const struct survey_change *change, double factor)
{
    json_t *lines = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++)
        json_array_append_new(lines, estimates(change->moved[line], SURVEY_POINTS, factor));
    return lines;
}

json_t *survey_json(const struct survey *survey, const struct survey_found *found, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    const struct store_gage_survey *row = &survey->row;
    json_t *o = json_pack("{sIsssssosbsisisisssoso}", "survey", (json_int_t)row->id, "pattern", row->pattern, "length_unit", length->text,
                          "after_run", row->after_run == STORE_NONE ? json_null() : json_integer(row->after_run), "ended",
                          row->ended_us != STORE_NONE, "read", (int)survey_desk_read(&survey->desk), "of", (int)survey->desk.plan.count,
                          "confirmed", (int)survey->confirmed, "note", row->note, "readings", readings_json(&survey->readings, length->factor),
                          "slack", estimates(found->slack.segment, SURVEY_SPANS, length->factor));
    if (found->previous) {
        json_object_set_new(o, "since", json_integer(found->previous));
        json_object_set_new(o, "change", readings_json(&found->since_previous.change, length->factor));
        json_object_set_new(o, "moved", moved_json(&found->since_previous, length->factor));
        json_object_set_new(o, "bow", estimates(found->since_first.bow, SURVEY_POINTS, length->factor));
        json_object_set_new(o, "worst_bow", json_pack("{sososososs}", "value", cli_json_number(found->worst_bow_in * length->factor, 6), "error",
                                                      cli_json_number(found->worst_bow_error_in * length->factor, 4), "station",
                                                      cli_json_number(found->worst_bow_ft * station->factor, 6), "limit",
                                                      cli_json_number(SURVEY_BOW_LIMIT_IN * length->factor, 6), "verdict",
                                                      survey_bow_verdict(found)));
    }
    return o;
}
