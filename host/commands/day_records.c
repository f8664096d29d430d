/* Questions of the command matrig day for records of a landing (host/store/records.def). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/commands/day.h"

/* Asks for a record, one question per field. An empty line keeps the value in `last`, "-" removes
 * it; at a first field without such a value an empty line ends the questions for the kind, as q
 * does. Values of questions that were not asked are not kept. `again`: the record `last` was
 * refused and is asked for again. Returns false when the questions for the kind have ended. */
static bool ask_record(const char *db, int64_t run, const struct inspection_kind *kind,
                       const json_t *last, bool again, struct error *error)
{
    static char word[INSPECTION_FIELDS_MAX][INSPECTION_TEXT_SIZE + 80];
    size_t words = 0, answers = 0;
    char run_text[24], was[INSPECTION_TEXT_SIZE], value[INSPECTION_TEXT_SIZE];
    struct command_line line = day_make_command_line("record", db);
    json_t *one = json_object(), *values = json_object();
    bool goes_on = true;
    snprintf(run_text, sizeof run_text, "%lld", (long long)run);
    day_add_word(&line, kind->name);
    day_add_word(&line, run_text);
    for (const struct inspection_field *field = kind->field; field->name; field++) {
        const char *unit = field->choices ? field->choices : inspection_get_unit(field, false);
        const char *choice = field->required_choice
                               ? json_string_value(json_object_get(values, field->required_choice))
                               : "";
        if (field->type >= INSPECTION_DIGEST || !choice || strcmp(choice, "open") == 0)
            continue;
        bool ends = field == kind->field && !inspection_is_single(kind);
        inspection_format_value(field, field->is_copied_from_last || again ? last : NULL, was);
        char *question = xasprintf("%s: %s%s%s (Enter: %s%s): ", kind->description,
                                   field->description, *unit ? ", " : "", unit,
                                   was[0] ? was
                                   : ends ? "no further entry"
                                          : "no answer",
                                   was[0] ? ", -: no value" : "");
        while (goes_on) {
            day_print_error(error);
            json_object_clear(one);
            goes_on = day_ask(question, value, sizeof value) && (!ends || value[0] || was[0]);
            snprintf(word[words], sizeof word[0], "%s=%s", field->name,
                     !goes_on || strcmp(value, "-") == 0 ? ""
                     : value[0]                          ? value
                                                         : was);
            if (!goes_on || inspection_parse_field(kind, word[words], one, error) == MR_OK)
                break;
        }
        free(question);
        if (!goes_on)
            snprintf(word[words], sizeof word[0], "%s=", field->name);
        else
            json_object_update(values, one);
        answers += goes_on && (value[0] || was[0]);
        if (was[0] || (goes_on && value[0]) || (again && field->is_copied_from_last))
            day_add_word(&line, word[words++]);
    }
    if (answers > 0 && !day_run_command_line(&line, error) && goes_on)
        goes_on = ask_record(db, run, kind, values, true, error);
    json_decref(values);
    json_decref(one);
    return goes_on;
}

void day_ask_records(struct store *store, const char *db, int64_t run, struct error *error)
{
    struct inspections all;
    inspection_load(store, &all, fatal);
    for (const struct inspection_kind *kind = inspection_kinds; kind->name; kind++) {
        const struct inspection *last = inspection_find_newest(&all, kind, run);
        if (kind->place != INSPECTION_LANDING || !last ||
            (inspection_is_single(kind) && last->row.run == run))
            continue;
        while (ask_record(db, run, kind, last->values, false, error) && !inspection_is_single(kind))
            ;
    }
    inspection_free(&all);
}
