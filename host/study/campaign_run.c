/* matrig study FILE: a series of landings on an ensemble of runways. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/campaign/facts.h"
#include "host/campaign/page.h"
#include "host/campaign/result_json.h"
#include "host/commands/campaign_command.h"
#include "host/commands/commands.h"
#include "host/base/output.h"
#include "host/study/studies.h"

#define PROGRESS_S 1.0

struct progress {
    const struct cli *cli;
    double begin_s, next_s;
    bool drawn;
};

static double clock_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void tell_progress(void *ctx, size_t done, size_t of)
{
    struct progress *p = ctx;
    double now_s = clock_s(), left_s = (now_s - p->begin_s) / (double)done * (double)(of - done);
    if (p->cli->quiet || now_s < p->next_s || done == of)
        return;
    fprintf(stderr, cli_terminal() ? "\rmatrig: study: %zu of %zu runways, about %.0f s left  " : "matrig: study: %zu of %zu runways, about %.0f s left\n",
            done, of, left_s);
    p->drawn = cli_terminal();
    p->next_s = now_s + PROGRESS_S;
}

static bool ends_in(const char *path, const char *end)
{
    size_t length = strlen(path), part = strlen(end);
    return length > part && strcmp(path + length - part, end) == 0;
}

static enum mr_status read_request(int argc, char **argv, const struct cli *cli, struct campaign_request *request, struct error *error)
{
    if (command_parse(&command_campaign, argc, argv, cli, request, &request->path, error) != MR_OK)
        return error->status;
    if (request->page && !ends_in(request->page, ".html") && !ends_in(request->page, ".svg"))
        return error_set(error, MR_USAGE, "unknown kind of file: -o %s; give one that ends in .html or .svg", request->page);
    if (output_check(request->page, request->force, request->path, error) != MR_OK)
        return error->status;
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!request->jobs)
        request->jobs = cores > 0 && cores < CAMPAIGN_JOBS_MAX ? cores : 1;
    return MR_OK;
}

static void spread_cell(const struct campaign_spread *s, int decimals, double unit)
{
    char text[48] = "-";
    if (s->count > 0)
        snprintf(text, sizeof text, "%.*f (%.*f-%.*f)", decimals, unit * s->middle, decimals, unit * s->low, decimals,
                 unit * s->high);
    printf(" %-19s", text);
}

static void print_landings(const struct campaign *c, const struct campaign_summary *s, const struct cli *cli)
{
    double ft = cli->si ? 0.3048 : 1.0, in = cli->si ? 25.4 : 1.0;
    printf("  median (5 to 95 %%) over runways; %s\n", cli->si ? "m, mm" : "ft, in");
    printf("  %-7s %-7s %-19s %-19s %-19s %-19s %6s %6s %7s %4s\n", "landing", "runways", "stop", "largest movement",
           "reach ahead", "closed zone, mats", "planar", "waves", "buckled", "torn");
    for (size_t i = 0; i < c->landing_count; i++) {
        const struct campaign_landing_summary *l = &s->landing[i];
        if (l->played == 0)
            break;
        printf("  %-7zu %-7zu", i + 1, l->played);
        spread_cell(&l->stop_ft, 1, ft);
        spread_cell(&l->peak_in, 2, in);
        spread_cell(&l->reach_ft, 1, ft);
        spread_cell(&l->zone_mats, 0, 1.0);
        printf(" %6zu %6zu %7zu %4zu%s\n", l->planar, l->waved, l->buckled, l->torn,
               c->landings[i].modified ? "  modified before it" : "");
    }
}

static void print_stations(const struct campaign *c, const struct campaign_summary *s, const struct cli *cli)
{
    double ft = cli->si ? 0.3048 : 1.0, in = cli->si ? 25.4 : 1.0;
    printf("  movement in all, %s, median, at station, %s:\n  landing", cli->si ? "mm" : "in", cli->si ? "m" : "ft");
    for (size_t k = 0; k < c->station_count; k++)
        printf(" %6.1f", ft * c->stations_ft[k]);
    putchar('\n');
    for (size_t i = 0; i < c->landing_count && s->landing[i].played > 0; i++) {
        printf("  %-7zu", i + 1);
        for (size_t k = 0; k < c->station_count; k++)
            printf(" %6.2f", in * s->landing[i].total_in[k].middle);
        putchar('\n');
    }
}

static void print_verdict(const struct campaign *c, const struct campaign_run *runs, const struct campaign_summary *s,
                          const struct cli *cli)
{
    double ft = cli->si ? 0.3048 : 1.0;
    printf("  of %zu runways %zu buckled", s->runways, s->runways - s->survived);
    for (size_t i = 0; i < c->landing_count; i++) {
        if (s->landing[i].buckled > 0)
            printf(", %zu in landing %zu", s->landing[i].buckled, i + 1);
    }
    if (s->station_ft.count > 0)
        printf("; station %.1f (%.1f-%.1f)", ft * s->station_ft.middle, ft * s->station_ft.low, ft * s->station_ft.high);
    putchar('\n');
    if (c->observed[0])
        printf("  observed: %s\n", c->observed);
    if (c->basis[0])
        printf("  parameters: %s\n", c->basis);
    if (c->afterwards[0])
        printf("  put in afterwards, so no prediction: %s\n", c->afterwards);
    if (c->awaits[0])
        printf("  NOT A RESULT: awaits %s\n", c->awaits);
    for (size_t i = 0; i < c->seeds; i++) {
        if (runs[i].error.status != MR_OK)
            printf("  failed: seed %llu, landing %zu: %s\n", (unsigned long long)runs[i].seed, runs[i].played + 1,
                   runs[i].error.text);
    }
}

/* What else was seen, in the file's units. */
static void print_facts(const struct campaign *c, const struct campaign_summary *s)
{
    for (size_t i = 0; i < c->fact_count; i++) {
        const struct campaign_fact_summary *fact = &s->fact[i];
        char range[64], value[80] = "none";
        facts_range_text(&c->facts[i], range, sizeof range);
        if (fact->value.count > 0)
            snprintf(value, sizeof value, "%.3g (%.3g-%.3g)", fact->value.middle, fact->value.low, fact->value.high);
        printf("  %s %s: seen %s, predicted %s; %zu of %zu runways agree\n", fact->enough ? "agrees " : "DIFFERS", c->facts[i].says,
               range, value, fact->agree, s->runways);
    }
}

static void print_result(const struct campaign *c, const struct campaign_run *runs, const struct campaign_summary *s,
                         const struct cli *cli)
{
    printf("%s: %zu landings on %zu runways (seeds %llu to %llu), %d mats\n", c->name, c->landing_count, c->seeds,
           (unsigned long long)c->first_seed, (unsigned long long)(c->first_seed + c->seeds - 1),
           c->landings[0].scene.mats);
    print_landings(c, s, cli);
    print_stations(c, s, cli);
    print_verdict(c, runs, s, cli);
    print_facts(c, s);
    printf("  computed: %zu landings, %zu of them with the planar engine too; %.1f s of the chain, %.1f s planar\n",
           s->landings, s->planar, 1e-3 * s->ms_chain, 1e-3 * s->ms_planar);
}

static enum mr_status write_page(const char *path, bool force, const struct campaign *c, const struct campaign_run *runs,
                                 const struct campaign_summary *s, struct error *error)
{
    struct output output;
    if (output_begin(&output, path, force, error) != MR_OK)
        return error->status;
    if (ends_in(path, ".svg"))
        campaign_picture(output.file, c, runs, s, true);
    else
        campaign_page(output.file, c, runs, s);
    return output_end(&output, error);
}

/* Once more with every mat integrated and the planar engine in every landing. */
static enum mr_status check(const struct campaign *c, const struct campaign_request *request, const struct campaign_run *runs,
                            const struct cli *cli, struct campaign_difference *apart, struct error *error)
{
    struct campaign whole = *c;
    struct progress progress = {.cli = cli, .begin_s = clock_s(), .next_s = clock_s() + PROGRESS_S};
    struct campaign_run *again = calloc(c->seeds, sizeof *again);
    whole.skip_share = -1.0;
    if (!again)
        return error_set(error, MR_FULL, "out of memory: %zu seeds; give fewer", c->seeds);
    if (campaign_ensemble(&whole, (int)request->jobs, true, tell_progress, &progress, again, error) == MR_OK) {
        double ms = 0.0, all_ms = 0.0;
        *apart = campaign_compare(c, runs, again);
        for (size_t i = 0; i < c->seeds; i++) {
            ms += runs[i].ms;
            all_ms += again[i].ms;
        }
        if (!cli->json)
            printf("  check, everything computed: %.1f times the time; %zu runways with another outcome; movements differ "
                   "by at most %.2g in before a runway's first wave, %.2g in after it\n",
                   all_ms / ms, apart->outcomes, apart->movement_in, apart->waved_in);
    }
    for (size_t i = 0; i < c->seeds; i++)
        campaign_run_free(&again[i]);
    free(again);
    return error->status;
}

static int finish(const struct campaign *c, const struct campaign_request *request, const struct campaign_run *runs,
                  const struct cli *cli, struct error *error)
{
    struct campaign_summary summary;
    struct campaign_difference apart;
    int code = 0;
    if (campaign_summarise(&summary, c, runs, error) != MR_OK)
        return cli_fail(error);
    if (!cli->json)
        print_result(c, runs, &summary, cli);
    if (request->check)
        check(c, request, runs, cli, &apart, error);
    if (error->status == MR_OK && request->page)
        write_page(request->page, request->force, c, runs, &summary, error);
    if (error->status == MR_OK && summary.failed > 0)
        error_set(error, MR_NUMERICS, "%zu of %zu runways could not be played to their end: %s; see what failed", summary.failed,
                  c->seeds, request->path);
    if (error->status != MR_OK)
        code = cli_fail(error);
    if (cli->json)
        code = cli_print_json(campaign_json(c, runs, &summary, request->check && error->status == MR_OK ? &apart : NULL), code);
    campaign_summary_free(&summary);
    return code;
}

int campaign_command(int argc, char **argv, const struct cli *cli)
{
    struct error error = {0};
    struct campaign_request request = {0};
    struct campaign campaign;
    struct progress progress = {.cli = cli, .begin_s = clock_s(), .next_s = clock_s() + PROGRESS_S};
    if (read_request(argc, argv, cli, &request, &error) != MR_OK || campaign_load(&campaign, request.path, &error) != MR_OK)
        return cli_fail(&error);
    if (request.seeds)
        campaign.seeds = (size_t)request.seeds;
    struct campaign_run *runs = calloc(campaign.seeds, sizeof *runs);
    int code = 0;
    if (!runs)
        error_set(&error, MR_FULL, "out of memory: %zu seeds; give fewer", campaign.seeds);
    else
        campaign_ensemble(&campaign, (int)request.jobs, request.no_prune, tell_progress, &progress, runs, &error);
    if (progress.drawn)
        fputc('\n', stderr);
    code = error.status == MR_OK ? finish(&campaign, &request, runs, cli, &error) : cli_fail(&error);
    for (size_t i = 0; runs && i < campaign.seeds; i++)
        campaign_run_free(&runs[i]);
    free(runs);
    campaign_free(&campaign);
    return code;
}
