#include "host/sweep/sweep_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/report/page.h"
#include "host/sweep/sweep_influences.h"
#include "host/sweep/sweep_plot.h"

#define ROWS_MAX      2000 /* of the table of all cases */
#define REASONS_MAX   40   /* different ones that are told */
#define PIVOT_MAX     16   /* columns */
#define LEAST_SAMPLES 10   /* for a rank correlation */

/* ---- cells ---- */

static void json_cell(FILE *out, const json_t *value)
{
    if (!value || json_is_null(value)) {
        fputs("<td class=\"n\">&ndash;</td>", out);
    } else if (json_is_string(value)) {
        html_cell(out, "%s", json_string_value(value));
    } else if (json_is_boolean(value)) {
        html_cell(out, "%s", json_is_true(value) ? "yes" : "no");
    } else if (json_is_number(value)) {
        fprintf(out, "<td class=\"n\">%.6g</td>", json_number_value(value));
    } else {
        char *text = json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(6));
        html_cell(out, "%s", text ? text : "");
        free(text);
    }
}

static const json_t *find_of(const struct table_row *row, const char *key)
{
    return json_object_get(json_object_get(row->line, "find"), key);
}

/* "4300 to 4320", "at most 1000", "above 48000" */
static void threshold_cell(FILE *out, const struct table_row *row)
{
    const char *verdict = json_string_value(find_of(row, "verdict"));
    double low = sweep_table_number(find_of(row, "low")),
           high = sweep_table_number(find_of(row, "high"));
    if (!verdict)
        fputs("<td class=\"n\">&ndash;</td>", out);
    else if (strcmp(verdict, "none") == 0)
        html_cell(out, "above %.6g", low);
    else if (strcmp(verdict, "at_most") == 0)
        html_cell(out, "at most %.6g", high);
    else
        html_cell(out, "%.6g to %.6g", low, high);
}

static void head_cell(FILE *out, const char *text)
{
    fputs("<th>", out);
    html_text(out, text);
    fputs("</th>", out);
}

static void open_table(FILE *out)
{
    fputs("<div class=\"scroll\"><table><thead><tr>", out);
}

static void close_table(FILE *out)
{
    fputs("</tbody></table></div>\n", out);
}

/* ---- what is done ---- */

static double core_seconds(const struct sweep_table *table)
{
    double sum = 0.0;
    for (size_t i = 0; i < table->count; i++) {
        double ms = sweep_table_number(json_object_get(table->rows[i].line, "cpu_ms"));
        sum += isnan(ms) ? 0.0 : ms / 1000.0;
    }
    return sum;
}

static void search_fact(FILE *out, const struct sweep_study *study)
{
    const struct sweep_find *f = &study->find;
    html_fact(out, "search", "smallest %s from %.6g to %.6g at which %s is %s %.6g", f->key.name,
              f->key.range.from, f->key.range.to, f->field, f->below ? "below" : "above", f->level);
    html_fact(out, "how it is searched",
              "%u even parts upwards, then halved to %.3g of the value; a part that is beyond and "
              "back again "
              "is not seen",
              f->scan, f->tolerance);
}

static void facts(FILE *out, const struct sweep_table *table)
{
    fputs("<dl>", out);
    html_fact(out, "cases with a result", "%zu", table->count - table->failed);
    html_fact(out, "failed", "%zu", table->failed);
    if (table->study.cases) {
        html_fact(out, "missing", "%zu of %zu", table->missing, table->study.cases);
        const char *base = json_string_value(json_object_get(table->study.root, "_base_file"));
        const char *name = json_string_value(json_object_get(table->study.base, "name"));
        const char *slash = base ? strrchr(base, '/') : NULL;
        html_fact(out, "base", "%s",
                  slash  ? slash + 1
                  : base ? base
                  : name ? name
                         : "in the sweep");
        if (table->study.points)
            html_fact(out, "indices of sensitivity", "%zu points, %zu samples of each combination",
                      table->study.points, table->study.samples);
        else if (table->study.samples > 1)
            html_fact(out, "Latin hypercube", "%zu samples", table->study.samples);
        if (table->study.find.wanted)
            search_fact(out, &table->study);
    } else {
        html_fact(out, "missing", "not known: the copy of the sweep is not beside the results");
    }
    if (table->repeated)
        html_fact(out, "repeated lines left out", "%zu", table->repeated);
    html_fact(out, "computed", "%.1f core seconds", core_seconds(table));
    fputs("</dl>\n", out);
}

/* ---- failures ---- */

struct reason {
    const char *status, *text;
    const struct table_row *first;
    size_t count;
};

static size_t group_reasons(const struct sweep_table *table, struct reason *reasons)
{
    size_t count = 0;
    for (size_t i = 0; i < table->count; i++) {
        const char *status = sweep_table_status(&table->rows[i]);
        const char *text = json_string_value(json_object_get(table->rows[i].line, "reason"));
        size_t k = 0;
        if (strcmp(status, "ok") == 0)
            continue;
        while (k < count && (strcmp(reasons[k].status, status) != 0 ||
                             strcmp(reasons[k].text, text ? text : "") != 0))
            k++;
        if (k == REASONS_MAX)
            continue;
        if (k == count)
            reasons[count++] = (struct reason){status, text ? text : "", &table->rows[i], 0};
        reasons[k].count++;
    }
    return count;
}

static void failures(FILE *out, const struct sweep_table *table)
{
    static const char *const heads[] = {"status", "cases", "reason", "first of them", NULL};
    struct reason reasons[REASONS_MAX];
    size_t count = group_reasons(table, reasons), told = 0;
    if (count == 0)
        return;
    fputs("<h2>Failed cases</h2>\n", out);
    html_table(out, heads);
    for (size_t k = 0; k < count; k++) {
        char *values = json_dumps(json_object_get(reasons[k].first->line, "values"),
                                  JSON_COMPACT | JSON_REAL_PRECISION(6));
        fputs("<tr>", out);
        html_cell(out, "%s", reasons[k].status);
        html_cell(out, "%zu", reasons[k].count);
        html_cell(out, "%s", reasons[k].text);
        html_cell(out, "%s", values ? values : "");
        fputs("</tr>\n", out);
        free(values);
        told += reasons[k].count;
    }
    close_table(out);
    if (told < table->failed)
        fprintf(out, "<p>%zu more failed for other reasons; see the table of all cases.</p>\n",
                table->failed - told);
}

/* ---- tables ---- */

static const struct table_row *row_at(const struct sweep_table *table,
                                      const struct sweep_levels *levels, size_t i, size_t k)
{
    for (size_t r = 0; r < table->count; r++) {
        if (json_equal(sweep_table_value(&table->rows[r], levels[0].key), levels[0].value[i]) &&
            json_equal(sweep_table_value(&table->rows[r], levels[1].key), levels[1].value[k]))
            return &table->rows[r];
    }
    return NULL;
}

/* Two stepped keys: a quantity across both. */
static void pivot(FILE *out, const struct sweep_table *table, const struct sweep_levels *levels,
                  const struct sweep_quantity *quantity)
{
    char label[200], corner[200];
    sweep_key_label(table, levels[0].key, corner);
    sweep_key_label(table, levels[1].key, label);
    open_table(out);
    fputs("<th>", out);
    html_text(out, corner);
    fputs(" \\ ", out);
    html_text(out, label);
    fputs("</th>", out);
    for (size_t k = 0; k < levels[1].count; k++) {
        sweep_value_text(levels[1].value[k], label, sizeof label);
        head_cell(out, label);
    }
    fputs("</tr></thead><tbody>\n", out);
    for (size_t i = 0; i < levels[0].count; i++) {
        fputs("<tr>", out);
        json_cell(out, levels[0].value[i]);
        for (size_t k = 0; k < levels[1].count; k++) {
            const struct table_row *row = row_at(table, levels, i, k);
            if (row && strcmp(sweep_table_status(row), "ok") != 0)
                html_cell(out, "%s", sweep_table_status(row));
            else if (row && !quantity->field)
                threshold_cell(out, row);
            else
                json_cell(out, row ? sweep_table_field(row, quantity->field) : NULL);
        }
        fputs("</tr>\n", out);
    }
    close_table(out);
}

static void case_row(FILE *out, const struct sweep_table *table, const struct table_row *row)
{
    const char *reason = json_string_value(json_object_get(row->line, "reason"));
    fputs("<tr>", out);
    json_cell(out, json_object_get(row->line, "case"));
    for (size_t k = 0; k < json_array_size(table->keys); k++)
        json_cell(out, sweep_table_value(row, json_string_value(json_array_get(table->keys, k))));
    html_cell(out, "%s%s%s", sweep_table_status(row), reason ? ": " : "", reason ? reason : "");
    if (table->finds) {
        threshold_cell(out, row);
        json_cell(out, find_of(row, "field_low"));
        json_cell(out, find_of(row, "field_high"));
        json_cell(out, find_of(row, "runs"));
    }
    for (size_t k = 0; k < json_array_size(table->fields); k++)
        json_cell(out, sweep_table_field(row, json_string_value(json_array_get(table->fields, k))));
    fputs("</tr>\n", out);
}

static void all_cases(FILE *out, const struct sweep_table *table)
{
    size_t shown = table->count < ROWS_MAX ? table->count : ROWS_MAX;
    fputs("<h2>All cases</h2>\n", out);
    if (shown < table->count)
        fprintf(out, "<p>The first %zu of %zu; all are in the results file.</p>\n", shown,
                table->count);
    open_table(out);
    head_cell(out, "case");
    for (size_t k = 0; k < json_array_size(table->keys); k++)
        head_cell(out, json_string_value(json_array_get(table->keys, k)));
    head_cell(out, "status");
    if (table->finds) {
        head_cell(out, "threshold");
        head_cell(out, "field below it");
        head_cell(out, "field at it");
        head_cell(out, "runs");
    }
    for (size_t k = 0; k < json_array_size(table->fields); k++)
        head_cell(out, json_string_value(json_array_get(table->fields, k)));
    fputs("</tr></thead><tbody>\n", out);
    for (size_t i = 0; i < shown; i++)
        case_row(out, table, &table->rows[i]);
    close_table(out);
}

/* ---- which sampled key matters ---- */

struct ranked {
    double value;
    size_t row;
};

static int by_number(const void *a, const void *b)
{
    double x = ((const struct ranked *)a)->value, y = ((const struct ranked *)b)->value;
    return x < y ? -1 : x > y;
}

/* Ranks from 0, equal values share their mean rank. */
static void rank(const double *values, size_t count, double *ranks, struct ranked *work)
{
    for (size_t i = 0; i < count; i++)
        work[i] = (struct ranked){values[i], i};
    qsort(work, count, sizeof *work, by_number);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && !(work[end].value > work[i].value); end++)
            ;
        for (size_t k = i; k < end; k++)
            ranks[work[k].row] = 0.5 * (double)(i + end - 1);
    }
}

static double correlation(const double *a, const double *b, size_t count)
{
    double mean = 0.5 * (double)(count - 1), ab = 0.0, aa = 0.0, bb = 0.0;
    for (size_t i = 0; i < count; i++) {
        ab += (a[i] - mean) * (b[i] - mean);
        aa += (a[i] - mean) * (a[i] - mean);
        bb += (b[i] - mean) * (b[i] - mean);
    }
    return aa > 0.0 && bb > 0.0 ? ab / sqrt(aa * bb) : (double)NAN;
}

/* Spearman's rank correlation over the cases that have both. `work` has room for 4 numbers and a
 * rank a row. */
static double spearman(const struct sweep_table *table, const char *key,
                       const struct sweep_quantity *quantity, double *work, struct ranked *order,
                       size_t *count)
{
    double *x = work, *y = x + table->count, *rx = y + table->count, *ry = rx + table->count;
    *count = 0;
    for (size_t i = 0; i < table->count; i++) {
        double a = sweep_table_number(sweep_table_value(&table->rows[i], key)),
               b = sweep_quantity_of(&table->rows[i], quantity, NULL);
        if (isnan(a) || isnan(b))
            continue;
        x[*count] = a;
        y[(*count)++] = b;
    }
    if (*count < LEAST_SAMPLES)
        return (double)NAN;
    rank(x, *count, rx, order);
    rank(y, *count, ry, order);
    return correlation(rx, ry, *count);
}

static void influence(FILE *out, const struct sweep_table *table, const struct sweep_levels *levels,
                      size_t level_count, const struct sweep_quantity *quantity)
{
    static const char *const heads[] = {"key", "rank correlation", "cases", "", NULL};
    double *work = calloc(4 * table->count + 1, sizeof *work);
    struct ranked *order = calloc(table->count + 1, sizeof *order);
    bool open = false;
    for (size_t k = 0; work && order && k < level_count; k++) {
        size_t count;
        if (!levels[k].sampled || !levels[k].numeric)
            continue;
        double r = spearman(table, levels[k].key, quantity, work, order, &count);
        if (isnan(r))
            continue;
        if (!open)
            html_table(out, heads);
        open = true;
        double chance = 1.96 / sqrt((double)count - 1.0);
        fputs("<tr>", out);
        html_cell(out, "%s", levels[k].key);
        html_number(out, r, 3);
        html_cell(out, "%zu", count);
        html_cell(out,
                  fabs(r) > chance ? "beyond chance (%.3f, 95 %%)" : "within chance (%.3f, 95 %%)",
                  chance);
        fputs("</tr>\n", out);
    }
    if (open)
        close_table(out);
    free(work);
    free(order);
}

/* ---- the page ---- */

static bool is_plottable(const struct sweep_table *table, const char *field)
{
    for (size_t i = 0; i < table->count; i++) {
        if (!isnan(sweep_table_number(sweep_table_field(&table->rows[i], field))))
            return true;
    }
    return false;
}

static void quantity_section(FILE *out, const struct sweep_table *table,
                             const struct sweep_levels *levels, size_t level_count,
                             const struct sweep_quantity *quantity)
{
    char label[200];
    sweep_quantity_label(table, quantity, label);
    fputs("<h2>", out);
    label[0] = (char)(label[0] >= 'a' && label[0] <= 'z' && !quantity->field ? label[0] - 32
                                                                             : label[0]);
    html_text(out, label);
    fputs("</h2>\n", out);
    sweep_plot(out, table, levels, level_count, quantity);
    if (table->study.points)
        sweep_influences_write(out, table, quantity);
    else
        influence(out, table, levels, level_count, quantity);
    if (level_count == 2 && !levels[0].sampled && !levels[1].sampled &&
        levels[1].count <= PIVOT_MAX && levels[0].count <= ROWS_MAX)
        pivot(out, table, levels, quantity);
}

void sweep_page_write(FILE *out, const char *name, const struct sweep_table *table)
{
    size_t level_count;
    struct sweep_levels *levels = sweep_levels_of(table, &level_count);
    const char *title = json_string_value(json_object_get(table->study.root, "name"));
    page_head(out, title ? title : name);
    fputs("<h1>", out);
    html_text(out, title ? title : "Sweep");
    fputs("</h1>\n<p>", out);
    html_text(out, name);
    fputs(table->study.kind == SWEEP_CAMPAIGN
              ? ": units are those of the campaign's keys (in their names; of its scene ft, lb, s) "
                "and of its results.</p>\n"
              : ": units are those of the scene keys and of the simulation's results (ft, lb, "
                "s).</p>\n",
          out);
    facts(out, table);
    if (table->finds)
        quantity_section(out, table, levels, level_count, &(struct sweep_quantity){NULL});
    for (size_t k = 0; k < json_array_size(table->fields); k++) {
        struct sweep_quantity quantity = {json_string_value(json_array_get(table->fields, k))};
        if (is_plottable(table, quantity.field))
            quantity_section(out, table, levels, level_count, &quantity);
    }
    failures(out, table);
    all_cases(out, table);
    fputs("</body></html>\n", out);
    sweep_levels_free(levels, level_count);
}

json_t *sweep_table_json(const struct sweep_table *table)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < table->count; i++) {
        json_t *row = json_copy(table->rows[i].line);
        json_object_del(row, "cpu_ms");
        json_array_append_new(rows, row);
    }
    json_t *missing = table->study.cases ? json_integer((json_int_t)table->missing) : json_null();
    json_t *all = json_pack("{s:I,s:I,s:o,s:o}", "cases", (json_int_t)table->count, "failed",
                            (json_int_t)table->failed, "missing", missing, "rows", rows);
    if (table->study.points)
        json_object_set_new(all, "indices", sweep_influences_json(table));
    return all;
}
