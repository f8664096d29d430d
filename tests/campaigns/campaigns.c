/* campaigns FOLDER SERIES...: the scoreboard of the series of the report: observed | predicted |
 * verdict | where the parameters come from, a row each on stdout, a page of each in FOLDER. SEEDS=n
 * plays so many runways (the files' number else). A series that awaits something is not played.
 *
 * Exit: 0, whatever the verdicts are; 3 files; 5 a runway could not be played to its end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/campaign/facts.h"
#include "host/campaign/page.h"
#include "host/base/output.h"

#define LEAST_SEEDS 16

static double clock_s(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Largest movement in a landing: over all of them the mean of the medians, and the most. */
static void print_movements(const struct campaign *c, const struct campaign_summary *s)
{
    double sum = 0.0, most = 0.0;
    size_t waved = 0;
    for (size_t i = 0; i < c->landing_count; i++) {
        sum += s->landing[i].peak_in.middle / (double)c->landing_count;
        most = s->landing[i].peak_in.high > most ? s->landing[i].peak_in.high : most;
        waved += s->landing[i].waved;
    }
    printf("; %.2f in per landing, up to %.2f; low waves in %zu of %zu landings", sum, most, waved,
           s->landings);
}

static void print_torn(const struct campaign *c, const struct campaign_summary *s)
{
    const char *between = "; joints torn in landing ";
    for (size_t i = 0; i < c->landing_count; i++) {
        if (s->landing[i].torn == 0)
            continue;
        printf("%s%zu (%zux)", between, i + 1, s->landing[i].torn);
        between = ", ";
    }
}

/* "landing 4 (3x), 5 (12x), none (1x); station 66.6 (63.7 to 79.1); zone 54 (41 to 70) mats
 * before". */
static void print_predicted(const struct campaign *c, const struct campaign_summary *s)
{
    const char *between = "landing ";
    for (size_t i = 0; i < c->landing_count; i++) {
        if (s->landing[i].buckled == 0)
            continue;
        printf("%s%zu (%zux)", between, i + 1, s->landing[i].buckled);
        between = ", ";
    }
    if (s->survived > 0)
        printf("%s (%zux)", s->survived == s->runways ? "never" : ", none", s->survived);
    if (s->station_ft.count > 0)
        printf("; station %.0f (%.0f to %.0f)", s->station_ft.middle, s->station_ft.low,
               s->station_ft.high);
    if (s->zone_before.count > 0)
        printf("; the landing before: %.2f in (%.2f to %.2f), zone %.0f mats (%.0f to %.0f)",
               s->peak_before_in.middle, s->peak_before_in.low, s->peak_before_in.high,
               s->zone_before.middle, s->zone_before.low, s->zone_before.high);
    else if (s->survived == s->runways)
        print_movements(c, s);
    print_torn(c, s);
}

static void print_verdict(const struct campaign *c, const struct campaign_run *runs,
                          const struct campaign_summary *s)
{
    size_t agree = campaign_agree(c, runs);
    if (c->observed_landing == 0)
        printf("nothing to compare with");
    else if (s->runways < LEAST_SEEDS)
        printf("too few runways: %zu of %zu agree", agree, s->runways);
    else
        printf("%s: %zu of %zu agree (%s%s), %.0f needed",
               (double)agree >= c->needed * (double)s->runways ? "yes" : "NO", agree, s->runways,
               c->observed_landing < 0 ? "never" : "landing",
               c->observed_landing < 0 ? ""
               : c->within > 0         ? " within one"
                                       : "",
               c->needed * (double)s->runways);
    if (c->afterwards[0])
        printf("; with what was put in afterwards");
}

/* What the report tells besides: a row each below the series. */
static void print_facts(const struct campaign *c, const struct campaign_summary *s)
{
    for (size_t i = 0; i < c->fact_count; i++) {
        const struct campaign_fact_summary *fact = &s->fact[i];
        char range[64];
        facts_range_text(&c->facts[i], range, sizeof range);
        printf("| - %s | %s: %s | ", c->name, c->facts[i].says, range);
        if (fact->value.count == 0)
            printf("none has it | ");
        else
            printf("%.3g (%.3g to %.3g)%s | ", fact->value.middle, fact->value.low,
                   fact->value.high,
                   fact->value.count < s->runways ? ", of those that have it" : "");
        if (s->runways < LEAST_SEEDS)
            printf("too few runways: %zu of %zu agree | |\n", fact->agree, s->runways);
        else
            printf("%s: %zu of %zu agree, %.0f needed | |\n", fact->enough ? "yes" : "NO",
                   fact->agree, s->runways, c->facts[i].needed * (double)s->runways);
    }
}

static enum mr_status write_page(const char *folder, const char *path, const struct campaign *c,
                                 const struct campaign_run *runs, const struct campaign_summary *s,
                                 struct error *error)
{
    char name[1024];
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path,
               *dot = strrchr(base, '.');
    snprintf(name, sizeof name, "%s/%.*s.html", folder,
             (int)(dot ? dot - base : (long)strlen(base)), base);
    struct output output;
    if (output_begin(&output, name, true, error) != MR_OK)
        return error->status;
    campaign_page(output.file, c, runs, s);
    return output_end(&output, error);
}

static int score(const char *folder, const char *path)
{
    struct error error = {0};
    struct campaign campaign;
    struct campaign_summary summary = {0};
    if (campaign_load(&campaign, path, &error) != MR_OK) {
        fprintf(stderr, "campaigns: %s\n", error.text);
        return 3;
    }
    if (campaign.awaits[0]) {
        printf("| %s | %s | not run | awaits %s | %s |\n", campaign.name, campaign.observed,
               campaign.awaits, campaign.basis);
        campaign_free(&campaign);
        return 0;
    }
    const char *seeds = getenv("SEEDS");
    if (seeds && atoi(seeds) > 0 && atoi(seeds) <= CAMPAIGN_SEEDS_MAX)
        campaign.seeds = (size_t)atoi(seeds);
    struct campaign_run *runs = calloc(campaign.seeds, sizeof *runs);
    double begin_s = clock_s(CLOCK_MONOTONIC), begin_cpu_s = clock_s(CLOCK_PROCESS_CPUTIME_ID);
    if (!runs)
        error_set(&error, MR_FULL, "out of memory: %zu seeds", campaign.seeds);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (runs &&
        campaign_ensemble(&campaign, cores > 0 ? (int)cores : 1, false, NULL, NULL, runs, &error) ==
            MR_OK &&
        campaign_summarise(&summary, &campaign, runs, &error) == MR_OK) {
        printf("| %s | %s | %zu runways: ", campaign.name, campaign.observed, summary.runways);
        print_predicted(&campaign, &summary);
        printf(" | ");
        print_verdict(&campaign, runs, &summary);
        printf(" | %s%s%s |\n", campaign.basis, campaign.afterwards[0] ? "; AFTERWARDS: " : "",
               campaign.afterwards);
        print_facts(&campaign, &summary);
        fprintf(stderr, "%s: %zu runways, %.1f s, %.1f s of processor time\n", campaign.name,
                campaign.seeds, clock_s(CLOCK_MONOTONIC) - begin_s,
                clock_s(CLOCK_PROCESS_CPUTIME_ID) - begin_cpu_s);
        write_page(folder, path, &campaign, runs, &summary, &error);
    }
    int code = error.status != MR_OK ? 3 : summary.failed > 0 ? 5 : 0;
    for (size_t i = 0; runs && i < campaign.seeds; i++) {
        if (runs[i].error.status != MR_OK)
            fprintf(stderr, "campaigns: %s: seed %llu: %s\n", path,
                    (unsigned long long)runs[i].seed, runs[i].error.text);
        campaign_run_free(&runs[i]);
    }
    if (error.status != MR_OK)
        fprintf(stderr, "campaigns: %s\n", error.text);
    campaign_summary_free(&summary);
    free(runs);
    campaign_free(&campaign);
    return code;
}

int main(int argc, char **argv)
{
    int code = 0;
    if (argc < 3) {
        fputs("usage: campaigns FOLDER SERIES.json...\n", stderr);
        return 2;
    }
    puts("| series | observed | predicted: median (5 to 95 %) | verdict | parameters "
         "|\n|---|---|---|---|---|");
    for (int i = 2; i < argc; i++) {
        int one = score(argv[1], argv[i]);
        code = one > code ? one : code;
        fflush(stdout);
    }
    return code;
}
