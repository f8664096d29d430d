#include "host/analyse/journal.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/units.h"
#include "host/survey/survey.h"

void journal_add_observation(const struct store_observation *o, struct answer *answer)
{
    answer_add_text(answer, "kind", "observed", "%s", o->kind);
    answer_add_count(answer, "id", "no", o->id);
    answer_add_flag(answer, "withdrawn", o->withdrawn ? "withdrawn" : NULL, o->withdrawn);
    answer_add_value(answer, "station", "station", UNIT_STATION, o->station_ft, 1)->digits = 7;
    answer_add_count(answer, "panels", "panels", o->panels);
    answer_add_value(answer, "height", "height", UNIT_DISPLACEMENT, o->height_in, 2);
    answer_add_text_or_missing(answer, "side", "side", o->side, "");
    answer_add_text_or_missing(answer, "form", "form", o->form, "");
    answer_add_value(answer, "time", "after touchdown", UNIT_TIME, o->time_s, 2);
    answer_add_text_or_missing(answer, "who", "by", o->who, "");
    answer_add_text_or_missing(answer, "note", "note", o->note, "");
    answer_add_count(answer, "made_us", NULL, o->made_us);
}

/* Prints the name and the value of a field; quantities in SI units with --si. */
static void add_changed_field(const struct store_change *c, struct answer *answer)
{
    static const struct {
        const char *field, *name;
        enum unit_kind kind;
    } quantities[] = {{"weight_lb", "weight", UNIT_TENSION},
                      {"touchdown_ft", "touchdown", UNIT_STATION}};
    for (size_t i = 0; i < 2; i++) {
        const struct unit *unit = unit_get(quantities[i].kind, true);
        if (!answer_is_si(answer) || strcmp(c->field, quantities[i].field) != 0)
            continue;
        answer_add_text(answer, NULL, "field", "%s_%s", quantities[i].name, unit->suffix);
        if (c->was[0])
            answer_add_text(answer, NULL, "was", "%.6g", unit->factor * strtod(c->was, NULL));
        answer_add_text(answer, NULL, "value", "%.6g", unit->factor * strtod(c->value, NULL));
        return;
    }
    answer_add_text(answer, NULL, "field", "%s", c->field);
    answer_add_text_or_missing(answer, NULL, "was", c->was, "");
    answer_add_text(answer, NULL, "value", "%s", c->value);
}

void journal_add_change(const struct store_change *c, struct answer *answer)
{
    char when[40];
    survey_format_time(c->made_us, when, sizeof when);
    answer_add_text(answer, NULL, "when", "%s", when);
    answer_add_text_or_missing(answer, "who", "by", c->who, "");
    add_changed_field(c, answer);
    answer_add_text(answer, "field", NULL, "%s", c->field);
    answer_add_text_or_missing(answer, "was", NULL, c->was, "");
    answer_add_text(answer, "value", NULL, "%s", c->value);
    answer_add_text_or_missing(answer, "reason", "why", c->reason, "");
    answer_add_count(answer, "made_us", NULL, c->made_us);
}

enum mr_status journal_load(struct store *store, const struct store_landing *landing,
                            struct journal *j, struct error *error)
{
    memset(j, 0, sizeof *j);
    return store_landing_series_get(store, landing, &j->series, error) ?:
           store_changes_get(store, landing->id, &j->change, &j->change_count, error) ?:
           store_observations_get(store, landing->id, &j->observation, &j->observation_count,
                                  error) ?:
           store_is_void(store, landing->id, &j->is_void, j->void_reason, error);
}

void journal_free(struct journal *j)
{
    free(j->change);
    free(j->observation);
}

void journal_add_tables(const struct journal *j, struct answer *answer)
{
    answer_open_table(answer, "observations", "waves and breaks");
    for (size_t i = 0; i < j->observation_count; i++) {
        answer_open_row(answer);
        journal_add_observation(&j->observation[i], answer);
    }
    answer_close_group(answer);
    answer_open_table(answer, "changes", "notes and corrections");
    for (size_t i = 0; i < j->change_count; i++) {
        answer_open_row(answer);
        journal_add_change(&j->change[i], answer);
    }
    answer_close_group(answer);
}
