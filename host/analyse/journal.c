#include "host/analyse/journal.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/units.h"
#include "host/survey/show.h"

void journal_text_answer(struct answer *answer, const char *name, const char *label,
                         const char *text)
{
    if (text[0])
        answer_words(answer, name, label, "%s", text);
    else
        answer_none(answer, name, label, "");
}

void journal_observation_answer(const struct store_observation *o, struct answer *answer)
{
    answer_words(answer, "kind", "seen", "%s", o->kind);
    answer_count(answer, "id", "no", o->id);
    answer_flag(answer, "withdrawn", o->withdrawn ? "withdrawn" : NULL, o->withdrawn);
    answer_value(answer, "station", "station", UNIT_STATION, o->station_ft, 1)->digits = 7;
    answer_count(answer, "panels", "panels", o->panels);
    answer_value(answer, "height", "height", UNIT_DISPLACEMENT, o->height_in, 2);
    journal_text_answer(answer, "side", "side", o->side);
    journal_text_answer(answer, "form", "form", o->form);
    answer_value(answer, "time", "after touchdown", UNIT_TIME, o->time_s, 2);
    journal_text_answer(answer, "who", "by", o->who);
    journal_text_answer(answer, "note", "note", o->note);
    answer_count(answer, "made_us", NULL, o->made_us);
}

/* What a field is called and what it is, for people: a quantity with --si in SI units. */
static void field_answer(const struct store_change *c, struct answer *answer)
{
    static const struct {
        const char *field, *bare;
        enum unit_kind kind;
    } quantities[] = {{"weight_lb", "weight", UNIT_TENSION},
                      {"touchdown_ft", "touchdown", UNIT_STATION}};
    for (size_t i = 0; i < 2; i++) {
        const struct unit *unit = unit_of(quantities[i].kind, true);
        if (!answer_in_si(answer) || strcmp(c->field, quantities[i].field) != 0)
            continue;
        answer_words(answer, NULL, "what", "%s_%s", quantities[i].bare, unit->suffix);
        if (c->was[0])
            answer_words(answer, NULL, "was", "%.6g", unit->factor * strtod(c->was, NULL));
        answer_words(answer, NULL, "is", "%.6g", unit->factor * strtod(c->value, NULL));
        return;
    }
    answer_words(answer, NULL, "what", "%s", c->field);
    journal_text_answer(answer, NULL, "was", c->was);
    answer_words(answer, NULL, "is", "%s", c->value);
}

void journal_change_answer(const struct store_change *c, struct answer *answer)
{
    char when[40];
    survey_time_text(c->made_us, when, sizeof when);
    answer_words(answer, NULL, "when", "%s", when);
    journal_text_answer(answer, "who", "by", c->who);
    field_answer(c, answer);
    answer_words(answer, "field", NULL, "%s", c->field);
    journal_text_answer(answer, "was", NULL, c->was);
    answer_words(answer, "value", NULL, "%s", c->value);
    journal_text_answer(answer, "reason", "why", c->reason);
    answer_count(answer, "made_us", NULL, c->made_us);
}
