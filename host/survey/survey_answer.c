#include "host/survey/survey_answer.h"

#include <math.h>
#include <time.h>

#include "host/base/answer.h"
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
    return bow_in + Z_95 * found->worst_bow_error_in > SURVEY_BOW_LIMIT_IN ? "perhaps beyond"
                                                                           : "within";
}

static void head(const struct survey *survey, struct answer *answer)
{
    const struct store_gage_survey *row = &survey->row;
    bool ended = row->ended_us != STORE_NONE;
    char when[40];
    survey_time_text(row->made_us, when, sizeof when);
    answer_count(answer, "survey", "survey", row->id)->end = ended ? ", ended" : ", goes on";
    answer_flag(answer, "ended", NULL, ended);
    answer_words(answer, NULL, "begun", "%s%s%s", when, row->who[0] ? " by " : "", row->who);
    if (row->after_run == STORE_NONE)
        answer_none(answer, "after_run", NULL, NULL);
    else
        answer_count(answer, "after_run", "after RUN", row->after_run);
    answer_words(answer, NULL, "read", "%zu of %zu, %zu confirmed", survey_desk_read(&survey->desk),
                 survey->desk.plan.count, survey->confirmed);
    answer_count(answer, "read", NULL, (int64_t)survey_desk_read(&survey->desk));
    answer_count(answer, "of", NULL, (int64_t)survey->desk.plan.count);
    answer_count(answer, "confirmed", NULL, (int64_t)survey->confirmed);
    answer_words(answer, "note", row->note[0] ? "note" : NULL, "%s", row->note);
}

static const char *const line_names[SURVEY_LINES] = {"line 1", "line 2", "line 3", "line 4"};

/* For people; in the JSON are all places, read or not (matrices). */
static void spans(const struct survey *survey, const struct survey_found *found,
                  struct answer *answer)
{
    bool changed = found->previous != 0;
    answer_table(answer, NULL,
                 changed
                     ? "opening (+) and closing (-) of ten mats since the survey before, and the "
                       "opening of their joints"
                     : "distance of the gage points of ten mats, and the opening of their joints");
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        bool any = false;
        for (unsigned line = 0; line < SURVEY_LINES; line++)
            any |= !isnan(survey->readings.gap_in[line][k]);
        if (!any)
            continue;
        answer_row(answer);
        answer_value(answer, NULL, "at", UNIT_STATION, SURVEY_SPAN_FT * k, 1);
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            double gap_in = (changed ? found->since_previous.change.gap_in
                                     : survey->readings.gap_in)[line][k];
            answer_value(answer, NULL, line_names[line], UNIT_DISPLACEMENT, gap_in, 4)->plus =
                changed;
        }
        answer_estimate(answer, NULL, "opening", UNIT_DISPLACEMENT,
                        found->slack.segment[k].value_in, found->slack.segment[k].error_in, 4);
    }
    answer_close(answer);
    if (changed)
        answer_value(answer, NULL, "error of a change", UNIT_DISPLACEMENT,
                     found->since_previous.change.error_in, 4);
}

static void stations(const struct survey_found *found, struct answer *answer)
{
    answer_table(answer, NULL, "movement at the stations since the survey before");
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (unsigned s = 0; s < SURVEY_STATIONS; s++) {
            double moved_in = found->since_previous.change.station_in[line][s];
            double error_in = found->since_previous.station_error_in;
            if (isnan(moved_in))
                continue;
            answer_row(answer);
            answer_value(answer, NULL, "at", UNIT_STATION, SURVEY_STATION_FT * s, 1);
            answer_words(answer, NULL, "of", "%s", line_names[line]);
            answer_estimate(answer, NULL, "downfield", UNIT_DISPLACEMENT, moved_in, error_in, 3)
                ->plus = true;
        }
    }
    answer_close(answer);
}

/* Every 10 ft, the nearest gage point. */
static void movement(const struct survey_found *found, struct answer *answer)
{
    answer_table(answer, NULL,
                 "movement downfield since the survey before, and bow since the first");
    for (unsigned s = 0; s < SURVEY_STATIONS && found->since_previous.compared > 0; s++) {
        unsigned k = (unsigned)lround(SURVEY_STATION_FT * s / SURVEY_SPAN_FT);
        answer_row(answer);
        answer_value(answer, NULL, "at", UNIT_STATION, SURVEY_SPAN_FT * k, 1);
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            const struct survey_estimate *u = &found->since_previous.moved[line][k];
            answer_estimate(answer, NULL, line_names[line], UNIT_DISPLACEMENT, u->value_in,
                            u->error_in, 3)
                ->plus = true;
        }
        answer_value(answer, NULL, "bow", UNIT_DISPLACEMENT, found->since_first.bow[k].value_in, 3)
            ->plus = true;
    }
    answer_close(answer);
}

static json_t *estimates(const struct survey_estimate *e, size_t count, double factor)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_pack("[o,o]", cli_json_number(e[i].value_in * factor, 6),
                                              cli_json_number(e[i].error_in * factor, 4)));
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
    json_t *gaps = json_array(), *stations = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        json_array_append_new(gaps, numbers(r->gap_in[line], SURVEY_SPANS, factor));
        json_array_append_new(stations, numbers(r->station_in[line], SURVEY_STATIONS, factor));
    }
    return json_pack("{sososo}", "gap", gaps, "station", stations, "error",
                     cli_json_number(r->error_in * factor, 4));
}

static json_t *moved_json(const struct survey_change *change, double factor)
{
    json_t *lines = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++)
        json_array_append_new(lines, estimates(change->moved[line], SURVEY_POINTS, factor));
    return lines;
}

static void worst_bow(const struct survey_found *found, struct answer *answer)
{
    const bool si = answer_in_si(answer);
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si),
                      *station = unit_of(UNIT_STATION, si);
    double worst = found->worst_bow_in * length->factor,
           error = found->worst_bow_error_in * length->factor;
    double at = found->worst_bow_ft * station->factor, limit = SURVEY_BOW_LIMIT_IN * length->factor;
    const char *verdict = survey_bow_verdict(found);
    if (!found->first)
        answer_sentence(answer, NULL, "first survey: later ones are compared with it");
    else if (isnan(worst))
        answer_sentence(answer, NULL,
                        "in-plane bow: not known, it needs lines 1 and 4, and 2 or 3");
    else
        answer_sentence(answer, NULL,
                        "in-plane bow since survey %lld: at most %+.3f +- %.3f %s, at %.1f %s: %s "
                        "the limit of %.3f %s",
                        (long long)found->first, worst, error, length->text, at, station->text,
                        verdict, limit, length->text);
    if (!found->previous)
        return;
    answer_open(answer, "worst_bow", NULL);
    answer_value(answer, "value", NULL, UNIT_NUMBER, worst, 3);
    answer_value(answer, "error", NULL, UNIT_NUMBER, error, 3)->digits = 4;
    answer_value(answer, "station", NULL, UNIT_NUMBER, at, 1);
    answer_value(answer, "limit", NULL, UNIT_NUMBER, limit, 3);
    answer_words(answer, "verdict", NULL, "%s", verdict);
    answer_close(answer);
}

/* All places, read or not: only in the JSON. */
static void matrices(const struct survey *survey, const struct survey_found *found,
                     struct answer *answer, double factor)
{
    answer_json_value(answer, "readings", readings_json(&survey->readings, factor));
    answer_json_value(answer, "slack", estimates(found->slack.segment, SURVEY_SPANS, factor));
    if (!found->previous)
        return;
    answer_json_value(answer, "change", readings_json(&found->since_previous.change, factor));
    answer_json_value(answer, "moved", moved_json(&found->since_previous, factor));
    answer_json_value(answer, "bow", estimates(found->since_first.bow, SURVEY_POINTS, factor));
}

void survey_answer(const struct survey *survey, const struct survey_found *found,
                   struct answer *answer)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, answer_in_si(answer));
    head(survey, answer);
    answer_words(answer, "length_unit", NULL, "%s", length->text);
    if (found->previous)
        answer_count(answer, "since", "compared with survey", found->previous);
    spans(survey, found, answer);
    if (found->previous) {
        stations(found, answer);
        movement(found, answer);
    }
    matrices(survey, found, answer, length->factor);
    worst_bow(found, answer);
}
