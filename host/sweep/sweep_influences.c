#include "host/sweep/sweep_influences.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/html.h"
#include "host/sweep/sweep_indices.h"

/* Of one quantity at one combination of the keys that are stepped through. */
struct cell {
    double *values; /* by block */
    struct sweep_influence *influence;
    size_t used;
    bool good;
};

static size_t sampled_keys(const struct sweep_study *study)
{
    return study->samples / study->points - 2;
}

static struct cell cell_of(const struct sweep_table *table, const struct sweep_quantity *quantity,
                           size_t place)
{
    const struct sweep_study *study = &table->study;
    size_t first = place * study->samples, keys = sampled_keys(study);
    struct cell cell = {.values = calloc(study->samples, sizeof *cell.values),
                        .influence = calloc(keys, sizeof *cell.influence)};
    if (!cell.values || !cell.influence)
        return cell;
    for (size_t i = 0; i < study->samples; i++)
        cell.values[i] = (double)NAN;
    for (size_t i = 0; i < table->count; i++) {
        size_t index = table->rows[i].index;
        if (index >= first && index < first + study->samples)
            cell.values[index - first] = sweep_quantity_of(&table->rows[i], quantity, NULL);
    }
    cell.good = sweep_indices(cell.values, study->points, keys, cell.influence, &cell.used);
    return cell;
}

static void cell_free(struct cell *cell)
{
    free(cell->values);
    free(cell->influence);
}

/* The values of the keys that are stepped through. */
static json_t *place_json(const struct sweep_study *study, size_t place)
{
    json_t *values = sweep_study_values(study, place * study->samples);
    for (size_t i = 0; i < study->axis_count; i++) {
        if (study->axis[i].u)
            json_object_del(values, study->axis[i].name);
    }
    return values;
}

static void index_cells(FILE *out, const struct sweep_index *index)
{
    html_number(out, index->value, 2);
    html_cell(out, "%.2f to %.2f", index->low, index->high);
}

static void write_cell(FILE *out, const struct sweep_table *table, const struct cell *cell,
                       size_t place)
{
    static const char *const heads[] = {"key", "first order", "95 %", "total", "95 %", NULL};
    const struct sweep_study *study = &table->study;
    size_t key = 0;
    if (study->grid > 1) {
        json_t *at = place_json(study, place);
        char *text = json_dumps(at, JSON_COMPACT | JSON_REAL_PRECISION(6));
        fputs("<p>", out);
        html_text(out, text ? text : "");
        fputs("</p>\n", out);
        free(text);
        json_decref(at);
    }
    html_table(out, heads);
    for (size_t i = 0; i < study->axis_count; i++) {
        char label[200];
        if (!study->axis[i].u)
            continue;
        sweep_key_label(table, study->axis[i].name, label);
        fputs("<tr>", out);
        html_cell(out, "%s", label);
        index_cells(out, &cell->influence[key].first);
        index_cells(out, &cell->influence[key].total);
        fputs("</tr>\n", out);
        key++;
    }
    fprintf(
        out,
        "</tbody></table></div>\n<p>Shares of the variance, of %zu points: first order, by this "
        "key alone; total, with all that it does together with others.</p>\n",
        cell->used);
}

void sweep_influences_write(FILE *out, const struct sweep_table *table,
                            const struct sweep_quantity *quantity)
{
    for (size_t place = 0; place < table->study.grid; place++) {
        struct cell cell = cell_of(table, quantity, place);
        if (cell.good)
            write_cell(out, table, &cell, place);
        else
            fprintf(out,
                    "<p>No indices: it varies nowhere, or too few points are complete (%zu).</p>\n",
                    cell.used);
        cell_free(&cell);
    }
}

static json_t *index_json(const struct sweep_index *index)
{
    return json_pack("[f,f,f]", index->value, index->low, index->high);
}

static json_t *cell_json(const struct sweep_study *study, const struct cell *cell, size_t place)
{
    json_t *keys = json_object();
    size_t key = 0;
    for (size_t i = 0; cell->good && i < study->axis_count; i++) {
        if (!study->axis[i].u)
            continue;
        json_object_set_new(keys, study->axis[i].name,
                            json_pack("{s:o,s:o}", "first", index_json(&cell->influence[key].first),
                                      "total", index_json(&cell->influence[key].total)));
        key++;
    }
    return json_pack("{s:o,s:I,s:o}", "at", place_json(study, place), "points",
                     (json_int_t)cell->used, "keys", keys);
}

json_t *sweep_influences_json(const struct sweep_table *table)
{
    json_t *all = json_object();
    for (size_t f = 0; f < json_array_size(table->fields); f++) {
        struct sweep_quantity quantity = {json_string_value(json_array_get(table->fields, f))};
        json_t *cells = json_array();
        for (size_t place = 0; place < table->study.grid; place++) {
            struct cell cell = cell_of(table, &quantity, place);
            json_array_append_new(cells, cell_json(&table->study, &cell, place));
            cell_free(&cell);
        }
        json_object_set_new(all, quantity.field, cells);
    }
    return all;
}
