#include "host/analyse/journal.h"

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

void journal_change_answer(const struct store_change *c, struct answer *answer)
{
    char when[40];
    survey_time_text(c->made_us, when, sizeof when);
    answer_words(answer, NULL, "when", "%s", when);
    journal_text_answer(answer, "who", "by", c->who);
    answer_words(answer, "field", "what", "%s", c->field);
    journal_text_answer(answer, "was", "was", c->was);
    answer_words(answer, "value", "is", "%s", c->value);
    journal_text_answer(answer, "reason", "why", c->reason);
    answer_count(answer, "made_us", NULL, c->made_us);
}
