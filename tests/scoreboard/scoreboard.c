/* scoreboard SERIES...: the scoreboard of the series of the report on both grounds: observed
 * | weightless gear | elastic ground, a row each for the series and for each of its facts on
 * stdout, then where the parameters come from. SEEDS=n plays so many
 * runways (the files' number else), FIRST=n from that seed on: fresh ones. A series that awaits
 * something is not played.
 *
 * Exit: 0, whatever the verdicts are; 3 files; 5 a runway could not be played to its end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/base/statistics.h"
#include "tests/scoreboard/facts.h"

#define LEAST_SEEDS 16

static double clock_s(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Largest movement in a landing: over all of them the mean of the medians, and the most. */
static void print_movements(const struct landing_series *c, const struct series_summary *s)
{
    double sum = 0.0, most = 0.0;
    size_t waved = 0, played = 0;
    for (size_t i = 0; i < c->landing_count; i++) {
        sum += s->landing[i].peak_movement_in.median / (double)c->landing_count;
        most = s->landing[i].peak_movement_in.high > most ? s->landing[i].peak_movement_in.high
                                                          : most;
        waved += s->landing[i].wave_count;
        played += s->landing[i].runway_count;
    }
    printf("; %.2f in per landing, up to %.2f; low waves in %zu of %zu landings", sum, most, waved,
           played);
}

static void print_torn(const struct landing_series *c, const struct series_summary *s)
{
    const char *between = "; joints torn in landing ";
    for (size_t i = 0; i < c->landing_count; i++) {
        if (s->landing[i].torn_count == 0)
            continue;
        printf("%s%zu (%zux)", between, i + 1, s->landing[i].torn_count);
        between = ", ";
    }
}

/* "landing 4 (3x), 5 (12x), none (1x); station 66.6 (63.7 to 79.1); zone 54 (41 to 70) mats
 * before". */
static void print_predicted(const struct landing_series *c, const struct series_summary *s)
{
    const char *between = "landing ";
    for (size_t i = 0; i < c->landing_count; i++) {
        if (s->landing[i].buckled_count == 0)
            continue;
        printf("%s%zu (%zux)", between, i + 1, s->landing[i].buckled_count);
        between = ", ";
    }
    if (s->survived_count > 0)
        printf("%s (%zux)", s->survived_count == s->runway_count ? "never" : ", none",
               s->survived_count);
    if (s->buckle_station_ft.count > 0)
        printf("; station %.0f (%.0f to %.0f)", s->buckle_station_ft.median,
               s->buckle_station_ft.low, s->buckle_station_ft.high);
    if (s->zone_mats_before_buckle.count > 0)
        printf("; the landing before: %.2f in (%.2f to %.2f), zone %.0f mats (%.0f to %.0f)",
               s->peak_before_buckle_in.median, s->peak_before_buckle_in.low,
               s->peak_before_buckle_in.high, s->zone_mats_before_buckle.median,
               s->zone_mats_before_buckle.low, s->zone_mats_before_buckle.high);
    else if (s->survived_count == s->runway_count)
        print_movements(c, s);
    print_torn(c, s);
}

/* A series on one ground. */
struct played {
    struct landing_series series;
    struct facts facts;
    struct series_run *runs;
    struct series_summary summary;
    double cpu_s;
};

/* "yes: 30 of 32 (80 to 98 %)". */
static void print_share(size_t agree, size_t runways, double needed)
{
    struct proportion_interval w = compute_proportion_interval(agree, runways);
    if (runways < LEAST_SEEDS)
        printf("few runways: ");
    else
        printf((double)agree >= needed * (double)runways ? "yes: " : "**NO**: ");
    printf("%zu of %zu (%.0f to %.0f %%)", agree, runways, 100.0 * w.low, 100.0 * w.high);
}

static void print_memory_test(const struct played *p)
{
    const struct landing_series *c = &p->series;
    double bits = series_log_score_bits(c, &p->facts, p->runs);
    print_predicted(c, &p->summary);
    if (p->facts.observed_landing == 0) {
        printf("; nothing to compare with");
        return;
    }
    printf("; ");
    print_share(series_agree(c, &p->facts, p->runs), p->summary.runway_count, p->facts.needed);
    printf(", %.2g bits", bits);
}

static void print_value(const struct played *p, size_t i)
{
    const struct facts *facts = &p->facts;
    struct series_fact_summary fact = facts_summarise(&p->series, &facts->fact[i], p->runs);
    if (fact.value.count == 0)
        printf("none has it");
    else
        printf("%.3g (%.3g to %.3g)%s", fact.value.median, fact.value.low, fact.value.high,
               fact.value.count < p->summary.runway_count ? " of those that have it" : "");
    printf("; ");
    print_share(fact.agree, p->summary.runway_count, facts->fact[i].needed);
}

static void print_rows(const struct played *weightless, const struct played *elastic)
{
    const struct landing_series *c = &weightless->series;
    printf("| %s | %s | ", c->name, c->observed);
    print_memory_test(weightless);
    printf(" | ");
    print_memory_test(elastic);
    puts(" |");
    for (size_t i = 0; i < weightless->facts.count; i++) {
        char range[64];
        facts_range_text(&weightless->facts.fact[i], range, sizeof range);
        printf("| - | %s: %s | ", weightless->facts.fact[i].says, range);
        print_value(weightless, i);
        printf(" | ");
        print_value(elastic, i);
        puts(" |");
    }
}

static size_t number_of(const char *name, size_t otherwise, long most)
{
    const char *text = getenv(name);
    long number = text ? atol(text) : 0;
    return number > 0 && number <= most ? (size_t)number : otherwise;
}

static int play(struct played *p, const char *path, const char *ground)
{
    struct error error = {0};
    *p = (struct played){0};
    json_t *root = json_load_file(path, 0, NULL);
    if (series_load_on_ground(&p->series, path, ground, &error) == MR_OK &&
        facts_read(path, root, &p->series, &p->facts, &error) != MR_OK)
        series_free(&p->series);
    json_decref(root);
    if (error.status != MR_OK) {
        fprintf(stderr, "scoreboard: %s\n", error.text);
        return 3;
    }
    struct landing_series *c = &p->series;
    c->seed_count = number_of("SEEDS", c->seed_count, SERIES_SEEDS_MAX);
    c->first_seed = number_of("FIRST", (size_t)c->first_seed, 1000000000);
    p->runs = calloc(c->seed_count, sizeof *p->runs);
    double begin_s = clock_s(CLOCK_MONOTONIC), begin_cpu_s = clock_s(CLOCK_PROCESS_CPUTIME_ID);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!p->runs)
        error_set(&error, MR_FULL, "out of memory: %zu seeds", c->seed_count);
    else {
        series_simulate_all(c, cores > 0 ? (unsigned)cores : 1, NULL, NULL, p->runs);
        series_summarise(&p->summary, c, p->runs);
    }
    p->cpu_s = clock_s(CLOCK_PROCESS_CPUTIME_ID) - begin_cpu_s;
    fprintf(stderr, "%s, %s: %zu runways from seed %llu, %.1f s, %.1f s of processor time\n",
            c->name, ground, c->seed_count, (unsigned long long)c->first_seed,
            clock_s(CLOCK_MONOTONIC) - begin_s, p->cpu_s);
    for (size_t i = 0; p->runs && i < c->seed_count; i++) {
        if (p->runs[i].error.status != MR_OK)
            fprintf(stderr, "scoreboard: %s: seed %llu: %s\n", path,
                    (unsigned long long)p->runs[i].seed, p->runs[i].error.text);
    }
    if (error.status != MR_OK)
        fprintf(stderr, "scoreboard: %s\n", error.text);
    return error.status != MR_OK ? 3 : p->summary.failed_count > 0 ? 5 : 0;
}

static void drop(struct played *p)
{
    for (size_t i = 0; p->runs && i < p->series.seed_count; i++)
        series_run_free(&p->runs[i]);
    free(p->runs);
    series_summary_free(&p->summary);
    series_free(&p->series);
}

/* Where the parameters come from, kept until the table is out. */
static void note_basis(FILE *notes, const struct played *weightless, const struct played *elastic)
{
    const struct landing_series *c = &weightless->series;
    fprintf(notes, "| %s | %s%s%s | %zu from %llu | %.0f, %.0f |\n", c->name, c->basis,
            c->changes_after_outcome[0] ? "; AFTERWARDS: " : "", c->changes_after_outcome,
            c->seed_count, (unsigned long long)c->first_seed, weightless->cpu_s, elastic->cpu_s);
}

static int score(const char *path, FILE *notes)
{
    struct played weightless, elastic = {0};
    int code = play(&weightless, path, "weightless"), other = 0;
    if (code != 3) {
        other = play(&elastic, path, "elastic");
        if (other != 3) {
            print_rows(&weightless, &elastic);
            note_basis(notes, &weightless, &elastic);
        }
        drop(&elastic);
    }
    drop(&weightless);
    return code > other ? code : other;
}

int main(int argc, char **argv)
{
    int code = 0;
    char text[512];
    if (argc < 2) {
        fputs("usage: campaigns SERIES.json...\n", stderr);
        return 2;
    }
    FILE *notes = tmpfile();
    if (!notes) {
        perror("scoreboard: no temporary file");
        return 3;
    }
    puts("| series | observed, with the report's section | weightless gear: median (5 to 95 %); "
         "agree (95 % interval), log score | elastic ground, AFTERWARDS: likewise |\n"
         "|---|---|---|---|");
    for (int i = 1; i < argc; i++) {
        int one = score(argv[i], notes);
        code = one > code ? one : code;
        fflush(stdout);
    }
    puts("\n| series | parameters | seeds | processor s, weightless and elastic "
         "|\n|---|---|---|---|");
    rewind(notes);
    while (fgets(text, sizeof text, notes))
        fputs(text, stdout);
    fclose(notes);
    return code;
}
