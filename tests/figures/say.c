/* What a search says of the inputs, and of facts that exclude each other. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/base/output.h"
#include "tests/figures/found.h"

#define LEAST_CLOSEST 10  /* readings that speak for a fact: those that meet it, or the closest */
#define PULL          4.0 /* standard errors of their mean: 27 x 40 of them by chance give 0.07 */
#define EXPECTED      8.0 /* readings that would meet both of two facts, were they apart */
#define FEWER         4.0 /* times fewer that do */
#define PAIRS         12

static const struct search *sorted_search;
static size_t sorted_fact;

static double trial_miss(const struct search *search, size_t i, size_t fact)
{
    double value = search->ensemble[i].value[fact];
    return fact_met(&facts[fact], value) ? 0 : 1 + fact_miss(&facts[fact], value);
}

static int by_miss(const void *a, const void *b)
{
    double x = trial_miss(sorted_search, *(const size_t *)a, sorted_fact),
           y = trial_miss(sorted_search, *(const size_t *)b, sorted_fact);
    return (x > y) - (x < y);
}

/* The readings that speak for a fact, first in `order`; returns how many. */
static size_t closest(const struct search *search, size_t fact, size_t *order)
{
    size_t met = 0;
    for (size_t i = 0; i < search->count; i++) {
        order[i] = i;
        met += trial_miss(search, i, fact) == 0;
    }
    sorted_search = search;
    sorted_fact = fact;
    qsort(order, search->count, sizeof *order, by_miss);
    size_t few = search->count / 20 > LEAST_CLOSEST ? search->count / 20 : LEAST_CLOSEST;
    return met > few ? met : few < search->count ? few : search->count;
}

/* How far the mean of an input, over the readings that speak for a fact, lies from the middle of
 * its range, in standard errors. */
static double pull(const struct search *search, int in, const size_t *order, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += search->ensemble[order[i]].part[in] - 0.5;
    return sum / (double)count * sqrt(12.0 * (double)count);
}

/* A choice of four is no range: which of its options the readings are most at. */
static double favour(const struct search *search, int in, const size_t *order, size_t count,
                     int option, double options)
{
    double sum = 0, share = 1 / options;
    for (size_t i = 0; i < count; i++)
        sum += (int)input_value((enum input_id)in, search->ensemble[order[i]].part[in]) == option;
    return (sum / (double)count - share) / sqrt(share * (1 - share) / (double)count);
}

static void print_value(FILE *out, int in, double value)
{
    if (inputs[in].kind == INPUT_CHOICE)
        fprintf(out, "%s", inputs[in].options[(int)value]);
    else
        fprintf(out, "%.3g", value);
}

/* Where the walks were: 10 to 90 % and the middle; of a choice the share of each option. */
static void print_walked(FILE *out, const struct search *search, int in)
{
    size_t count = search->walked_count;
    if (inputs[in].kind == INPUT_CHOICE) {
        for (int o = 0; o < (int)inputs[in].high; o++) {
            size_t there = 0;
            for (size_t i = 0; i < count; i++)
                there += (int)input_value((enum input_id)in, search->walked[i].part[in]) == o;
            fprintf(out, "%s%s %.0f %%", o ? ", " : "", inputs[in].options[o],
                    100.0 * (double)there / (double)count);
        }
        return;
    }
    double *sorted = calloc(count + 1, sizeof *sorted);
    for (size_t i = 0; sorted && i < count; i++)
        sorted[i] = input_value((enum input_id)in, search->walked[i].part[in]);
    if (sorted && count > 0) {
        sort_numbers(sorted, count);
        fprintf(out, "%.3g (%.3g to %.3g)", sorted[count / 2], sorted[count / 10],
                sorted[count - 1 - count / 10]);
    }
    free(sorted);
}

static void print_pulls(FILE *out, const struct search *search, int in, int sign)
{
    size_t *order = calloc(search->count, sizeof *order);
    bool any = false;
    double options = inputs[in].kind == INPUT_CHOICE ? inputs[in].high : 0;
    for (size_t f = 0; order && f < fact_count; f++) {
        size_t count = closest(search, f, order);
        if (options > 2) {
            for (int o = 0; sign > 0 && o < (int)options; o++) {
                if (favour(search, in, order, count, o, options) > PULL) {
                    fprintf(out, "%s%zu: %s", any ? ", " : "", f + 1, inputs[in].options[o]);
                    any = true;
                }
            }
        } else if (sign * pull(search, in, order, count) > PULL) {
            fprintf(out, "%s%zu", any ? ", " : "", f + 1);
            any = true;
        }
    }
    free(order);
}

void say_inputs(FILE *out, const struct search *search)
{
    const struct reading best = trial_reading(&search->best[SEARCH_ALL]);
    fputs(
        "| input | open where | searched | R* | best | the walks: middle (10 to 90 %) | up, or to "
        "the second choice: rows | down: rows |\n|---|---|---|---|---|---|---|---|\n",
        out);
    for (int in = 0; in < INPUTS; in++) {
        fprintf(out, "| %s | %s | ", inputs[in].name, inputs[in].open);
        if (inputs[in].kind == INPUT_CHOICE)
            for (int o = 0; o < (int)inputs[in].high; o++)
                fprintf(out, "%s%s", o ? ", " : "", inputs[in].options[o]);
        else
            fprintf(out, "%.5g to %.5g", inputs[in].low, inputs[in].high);
        fputs(" | ", out);
        print_value(out, in, inputs[in].rstar);
        fputs(" | ", out);
        print_value(out, in, best.value[in]);
        fputs(" | ", out);
        print_walked(out, search, in);
        fputs(" | ", out);
        print_pulls(out, search, in, 1);
        fputs(" | ", out);
        print_pulls(out, search, in, -1);
        fputs(" |\n", out);
    }
}

struct pair {
    size_t a, b, both;
    double expected;
};

static int by_contradiction(const void *a, const void *b)
{
    const struct pair *x = a, *y = b;
    double p = (double)x->both / x->expected, q = (double)y->both / y->expected;
    return p != q ? (p > q) - (p < q) : (y->expected > x->expected) - (y->expected < x->expected);
}

void say_pairs(FILE *out, const struct search *search)
{
    struct pair *pairs = calloc(fact_count * fact_count, sizeof *pairs);
    const struct found found = found_of(search);
    size_t count = 0;
    for (size_t a = 0; pairs && a < fact_count; a++) {
        for (size_t b = a + 1; b < fact_count; b++) {
            struct pair pair = {
                a, b, 0, (double)found.met[a] * (double)found.met[b] / (double)search->count};
            for (size_t i = 0; i < search->count; i++)
                pair.both += fact_met(&facts[a], search->ensemble[i].value[a]) &&
                             fact_met(&facts[b], search->ensemble[i].value[b]);
            if (pair.expected >= EXPECTED && FEWER * (double)pair.both <= pair.expected)
                pairs[count++] = pair;
        }
    }
    if (pairs)
        qsort(pairs, count, sizeof *pairs, by_contradiction);
    fputs(
        "| rows | meet the first | the second | both | were they apart |\n|---|---|---|---|---|\n",
        out);
    for (size_t i = 0; i < count && i < PAIRS; i++)
        fprintf(out, "| %zu and %zu | %zu | %zu | %zu | %.0f |\n", pairs[i].a + 1, pairs[i].b + 1,
                found.met[pairs[i].a], found.met[pairs[i].b], pairs[i].both, pairs[i].expected);
    fprintf(out, "\n%zu pairs of %zu.\n", count, fact_count * (fact_count - 1) / 2);
    free(pairs);
}

#define MOST_PAGE 200000

/* The text of a file, or none; the caller frees it. */
static char *read_whole(const char *path)
{
    char *text = calloc(1, MOST_PAGE);
    FILE *in = fopen(path, "rb");
    if (text && in)
        text[fread(text, 1, MOST_PAGE - 1, in)] = '\0';
    if (in)
        fclose(in);
    return text;
}

enum mr_status page_put(const char *path, const char *name,
                        void (*write)(FILE *out, const void *what), const void *what,
                        struct error *error)
{
    char mark[80], last[80];
    char *text = read_whole(path);
    snprintf(mark, sizeof mark, "<!-- %s: ", name);
    snprintf(last, sizeof last, "<!-- end of %s -->", name);
    char *begin = text ? strstr(text, mark) : NULL;
    char *line = begin ? strchr(begin, '\n') : NULL;
    char *end = line ? strstr(line, last) : NULL;
    if (!end) {
        free(text);
        return error_set(error, MR_MALFORMED, "%s: no marks of %s", path, name);
    }
    struct output output;
    if (output_begin(&output, path, error) == MR_OK) {
        fwrite(text, 1, (size_t)(line + 1 - text), output.file);
        write(output.file, what);
        fputs(end, output.file);
        output_end(&output, error);
    }
    free(text);
    return error->status;
}
