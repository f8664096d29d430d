/* ablations PARTS.json SERIES.json:LANDING...: what each part of elastic ground does, a row of a
 * table on stdout for each change that PARTS.json lists (host/landing_series/ablations/parts.json), and
 * for each series two columns: the largest movement in the landings before LANDING, median and 5 to
 * 95 %, and on how many runways LANDING buckles, with Wilson's 95 % interval. SEEDS=n plays so many
 * runways (16), FIRST=n from that seed on (10001).
 *
 * Exit: 0; 2 usage; 3 files; 5 a runway could not be played to its end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/statistics.h"
#include "host/landing_series/summary.h"

static size_t number_of(const char *name, size_t otherwise, long most)
{
    const char *text = getenv(name);
    long number = text ? atol(text) : 0;
    return number > 0 && number <= most ? (size_t)number : otherwise;
}

/* The series with a part changed. */
static enum mr_status load(struct landing_series *series, const char *path, const json_t *part,
                           struct error *error)
{
    json_error_t where;
    json_t *root = json_load_file(path, 0, &where);
    if (!root)
        return error_set(error, MR_IO, "cannot read %s: %s; check the path", path, where.text);
    json_t *elastic = series_elastic_json(path, root, error);
    if (elastic) {
        json_t *changed = json_deep_copy(elastic);
        json_object_update(changed, json_object_get(part, "elastic"));
        json_object_set_new(root, "elastic", changed);
        json_object_set_new(root, "ground", json_string("elastic"));
        json_object_update(root, json_object_get(part, "study"));
        series_from_json(series, path, root, error);
        json_decref(elastic);
    } else if (error->status == MR_OK) {
        error_set(error, MR_MALFORMED, "no elastic ground: %s; give elastic", path);
    }
    json_decref(root);
    return error->status;
}

static void print_movements(const struct series_summary *s, size_t landings)
{
    for (size_t i = 0; i < landings && s->landing[i].played > 0; i++) {
        const struct series_spread *in = &s->landing[i].peak_in;
        printf("%s%.2f (%.2f to %.2f)", i > 0 ? ", " : "", in->middle, in->low, in->high);
    }
}

static void print_buckled(const struct landing_series *c, const struct series_summary *s,
                          size_t landing)
{
    size_t count = s->landing[landing - 1].buckled;
    struct wilson w = wilson_of(count, s->runways);
    printf("%zu of %zu (%.0f to %.0f %%)", count, s->runways, 100.0 * w.low, 100.0 * w.high);
    for (size_t i = 0; i < c->landing_count; i++) {
        if (i + 1 != landing && s->landing[i].buckled > 0)
            printf("; in landing %zu: %zu", i + 1, s->landing[i].buckled);
    }
    if (s->survived > 0)
        printf("; never: %zu", s->survived);
}

/* The two columns of a series. Exit status. */
static int play(const char *path, size_t landing, const json_t *part)
{
    struct landing_series c = {0};
    struct series_summary summary = {0};
    struct error error = {0};
    if (load(&c, path, part, &error) != MR_OK) {
        fprintf(stderr, "ablations: %s\n", error.text);
        return 3;
    }
    c.seeds = number_of("SEEDS", 16, SERIES_SEEDS_MAX);
    c.first_seed = number_of("FIRST", 10001, 1000000000);
    struct series_run *runs = calloc(c.seeds, sizeof *runs);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!runs)
        error_set(&error, MR_FULL, "out of memory: %zu seeds", c.seeds);
    else if (landing < 1 || landing > c.landing_count)
        error_set(&error, MR_USAGE, "no landing %zu: %s; give one of %zu", landing, path,
                  c.landing_count);
    else {
        series_ensemble(&c, cores > 0 ? (int)cores : 1, false, NULL, NULL, runs);
        series_summarise(&summary, &c, runs);
    }
    if (error.status == MR_OK) {
        printf(" | ");
        print_movements(&summary, landing - 1);
        printf(" | ");
        print_buckled(&c, &summary, landing);
        fflush(stdout);
    } else {
        fprintf(stderr, "ablations: %s\n", error.text);
    }
    int code = error.status != MR_OK ? 3 : summary.failed > 0 ? 5 : 0;
    for (size_t i = 0; runs && i < c.seeds; i++)
        series_run_free(&runs[i]);
    free(runs);
    series_summary_free(&summary);
    series_free(&c);
    return code;
}

/* "FILE:LANDING"; the landing, and FILE to `path`. 0: it is not one. */
static size_t split(const char *word, char *path, size_t size)
{
    const char *colon = strrchr(word, ':');
    long landing = colon ? atol(colon + 1) : 0;
    if (landing < 1 || (size_t)(colon - word) >= size)
        return 0;
    snprintf(path, size, "%.*s", (int)(colon - word), word);
    return (size_t)landing;
}

int main(int argc, char **argv)
{
    char path[1024];
    json_error_t where;
    int code = 0;
    for (int i = 2; i < argc; i++) {
        if (split(argv[i], path, sizeof path) == 0)
            argc = 0;
    }
    if (argc < 3) {
        fputs("usage: ablations PARTS.json SERIES.json:LANDING...\n", stderr);
        return 2;
    }
    json_t *root = json_load_file(argv[1], 0, &where), *part;
    if (!root) {
        fprintf(stderr, "ablations: cannot read %s: %s\n", argv[1], where.text);
        return 3;
    }
    printf("| elastic ground");
    for (int i = 2; i < argc; i++) {
        size_t landing = split(argv[i], path, sizeof path);
        const char *slash = strrchr(path, '/');
        printf(" | %.*s: movement in each landing before %zu, in | buckles in landing %zu",
               (int)strcspn(slash ? slash + 1 : path, "."), slash ? slash + 1 : path, landing,
               landing);
    }
    printf(" |\n|---");
    for (int i = 2; i < argc; i++)
        printf("|---|---");
    puts("|");
    size_t at;
    json_array_foreach(json_object_get(root, "parts"), at, part)
    {
        const char *says = json_string_value(json_object_get(part, "says"));
        printf("| %s", says ? says : "");
        for (int i = 2; i < argc; i++) {
            size_t landing = split(argv[i], path, sizeof path);
            int one = play(path, landing, part);
            code = one > code ? one : code;
        }
        puts(" |");
    }
    json_decref(root);
    return code;
}
