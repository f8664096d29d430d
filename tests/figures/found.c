#include "tests/figures/found.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
static const char *const groups[SEARCH_GROUPS] = {"all", "displacements alone", "waves alone"};

enum mr_status found_load(struct found *found, const char *path, struct error *error)
{
    json_error_t wrong;
    json_t *root = json_load_file(path, 0, &wrong);
    *found =
        (struct found){.readings = (size_t)json_integer_value(json_object_get(root, "readings"))};
    bool whole = root != NULL && found->readings > 0;
    for (int g = 0; g < SEARCH_GROUPS; g++) {
        for (int i = 0; i < INPUTS; i++) {
            json_t *value = json_object_get(json_object_get(root, groups[g]), inputs[i].name);
            whole = whole && json_is_number(value);
            found->best[g].value[i] = json_number_value(value);
        }
    }
    json_t *met = json_object_get(root, "met");
    whole = whole && json_array_size(met) == fact_count;
    for (size_t f = 0; f < fact_count; f++)
        found->met[f] = (size_t)json_integer_value(json_array_get(met, f));
    json_decref(root);
    return whole ? MR_OK
                 : error_set(error, MR_MALFORMED,
                             "%s: not the readings of these inputs; restore it with git", path);
}

const struct fact *sheet_make(struct sheet *sheet, const struct found *found)
{
    const struct fact *missed = NULL;
    *sheet = (struct sheet){0};
    sheet->rstar = (struct playing){.reading = reading_rstar(), .fine = true};
    sheet->best = (struct playing){.reading = found->best[SEARCH_ALL], .fine = true};
    for (int g = SEARCH_MOVES; g < SEARCH_GROUPS; g++)
        sheet->alone[g] = (struct playing){.reading = found->best[g], .fine = true};
    for (size_t i = 0; i < fact_count; i++) {
        const struct fact *fact = &facts[i];
        struct sheet_row *row = &sheet->row[i];
        row->rstar = fact_value(fact, &sheet->rstar);
        row->best = fact_value(fact, &sheet->best);
        row->alone = fact_value(fact,
                                &sheet->alone[fact_moves(fact) ? SEARCH_MOVES : SEARCH_LIFTS]);
        double off = fact_miss(fact, row->rstar), best = fact_miss(fact, row->best);
        sheet->score_rstar += log1p(off * off);
        sheet->score_best += log1p(best * best);
        if (fact->held && !fact_met(fact, row->rstar) && !missed)
            missed = fact;
    }
    return missed;
}

static void asked_text(char *text, size_t room, const struct fact *fact)
{
    if (fact->stated > 0)
        snprintf(text, room, "%.4g", fact->stated);
    else if (fact->low > 0 && fact->high > 0)
        snprintf(text, room, "%.4g to %.4g", fact->low, fact->high);
    else if (fact->low > 0)
        snprintf(text, room, "at least %.4g", fact->low);
    else
        snprintf(text, room, "at most %.4g", fact->high);
}

static void value_text(char *text, size_t room, double value)
{
    if (isnan(value))
        snprintf(text, room, "-");
    else if (value != 0 && fabs(value) < 1e-4)
        snprintf(text, room, "%.1e", value);
    else
        snprintf(text, room, "%.3g", value);
}

/* A reading that is about reproduced is not said to be: the verdict is the bounds'. */
static const char *verdict(const struct fact *fact, const struct sheet_row *row)
{
    bool rstar = fact_met(fact, row->rstar), best = fact_met(fact, row->best);
    if (rstar && best)
        return "both";
    if (rstar || best)
        return rstar ? "R*" : "best";
    return fact_met(fact, row->alone) ? "alone" : "no";
}

void sheet_print(FILE *out, const struct sheet *sheet, const struct found *found)
{
    static const char *const heads[] = {"#",    "figure", "section", "the text",      "text", "R*",
                                        "best", "alone",  "share",   "reproduced by", NULL};
    int rstar = 0, best = 0;
    for (int k = 0; heads[k]; k++)
        fprintf(out, "| %s %s", heads[k], heads[k + 1] ? "" : "|\n");
    for (int k = 0; heads[k]; k++)
        fprintf(out, "|---%s", heads[k + 1] ? "" : "|\n");
    for (size_t i = 0; i < fact_count; i++) {
        const struct fact *fact = &facts[i];
        const struct sheet_row *row = &sheet->row[i];
        char cell[10][160];
        snprintf(cell[0], sizeof cell[0], "%zu", i + 1);
        snprintf(cell[1], sizeof cell[1], "%s", fact->figure);
        snprintf(cell[2], sizeof cell[2], "%s", fact->section);
        snprintf(cell[3], sizeof cell[3], "%s", fact->text);
        asked_text(cell[4], sizeof cell[4], fact);
        value_text(cell[5], sizeof cell[5], row->rstar);
        value_text(cell[6], sizeof cell[6], row->best);
        value_text(cell[7], sizeof cell[7], row->alone);
        snprintf(cell[8], sizeof cell[8], "%.1f %%",
                 100.0 * (double)found->met[i] / (double)found->readings);
        snprintf(cell[9], sizeof cell[9], "%s", verdict(fact, row));
        rstar += fact_met(fact, row->rstar);
        best += fact_met(fact, row->best);
        for (int k = 0; k < 10; k++)
            fprintf(out, "| %s %s", cell[k], k == 9 ? "|\n" : "");
    }
    fputc('\n', out);
    fprintf(out,
            "Of %zu rows R* reproduces %d (score %.1f) and the best reading %d (score %.1f). The "
            "ensemble: %zu readings.",
            fact_count, rstar, sheet->score_rstar, best, sheet->score_best, found->readings);
    fputc('\n', out);
}
