/* matrig study FILE: a series of landings on an ensemble of runways. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/steady.h"
#include "host/base/underway.h"
#include "host/campaign/page.h"
#include "host/campaign/campaign_answer.h"
#include "host/commands/campaign_command.h"
#include "host/commands/commands.h"
#include "host/base/output.h"
#include "host/study/studies.h"

#define PROGRESS_S 1.0

struct progress {
    const struct cli *cli;
    double begin_s, next_s;
    bool drawn;
    struct underway *underway; /* for when no runway is done for long */
};

static void tell_progress(void *ctx, size_t done, size_t of)
{
    struct progress *p = ctx;
    double now_s = steady_s(), left_s = (now_s - p->begin_s) / (double)done * (double)(of - done);
    underway_at(p->underway, "%zu of %zu runways are done", done, of);
    if (p->cli->quiet || now_s < p->next_s || done == of)
        return;
    fprintf(stderr,
            cli_terminal() ? "\rmatrig: study: %zu of %zu runways, about %.0f s left  "
                           : "matrig: study: %zu of %zu runways, about %.0f s left\n",
            done, of, left_s);
    underway_said(p->underway);
    p->drawn = cli_terminal();
    p->next_s = now_s + PROGRESS_S;
}

static bool ends_in(const char *path, const char *end)
{
    size_t length = strlen(path), part = strlen(end);
    return length > part && strcmp(path + length - part, end) == 0;
}

static enum mr_status read_request(int argc, char **argv, const struct cli *cli,
                                   struct campaign_request *request, struct error *error)
{
    if (command_parse(&command_campaign, argc, argv, cli, request, &request->path, error) != MR_OK)
        return error->status;
    if (request->page && !ends_in(request->page, ".html") && !ends_in(request->page, ".svg"))
        return error_set(error, MR_USAGE,
                         "unknown kind of file: -o %s; give one that ends in .html or .svg",
                         request->page);
    if (output_check(request->page, request->force, request->path, error) != MR_OK)
        return error->status;
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!request->jobs)
        request->jobs = cores > 0 && cores < CAMPAIGN_JOBS_MAX ? cores : 1;
    return MR_OK;
}

static enum mr_status write_page(const char *path, bool force, const struct campaign *c,
                                 const struct campaign_run *runs, const struct campaign_summary *s,
                                 struct error *error)
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
static enum mr_status check(const struct campaign *c, const struct campaign_request *request,
                            const struct campaign_run *runs, const struct cli *cli,
                            struct campaign_difference *apart, struct underway *underway,
                            struct error *error)
{
    struct campaign whole = *c;
    struct progress progress = {
        .cli = cli, .begin_s = steady_s(), .next_s = steady_s() + PROGRESS_S, .underway = underway};
    underway_at(underway, "runways are played again in full; none is done");
    struct campaign_run *again = calloc(c->seeds, sizeof *again);
    whole.skip_share = -1.0;
    if (!again)
        return error_set(error, MR_FULL, "out of memory: %zu seeds; give fewer", c->seeds);
    if (campaign_ensemble(&whole, (int)request->jobs, true, tell_progress, &progress, again,
                          error) == MR_OK)
        *apart = campaign_compare(c, runs, again);
    for (size_t i = 0; i < c->seeds; i++)
        campaign_run_free(&again[i]);
    free(again);
    return error->status;
}

static int finish(const struct campaign *c, const struct campaign_request *request,
                  const struct campaign_run *runs, const struct cli *cli, struct underway *underway,
                  struct error *error)
{
    struct campaign_summary summary;
    struct campaign_difference apart;
    int code = 0;
    if (campaign_summarise(&summary, c, runs, error) != MR_OK) {
        underway_end(underway);
        return cli_fail(error);
    }
    bool checked = request->check && check(c, request, runs, cli, &apart, underway, error) == MR_OK;
    underway_end(underway);
    if (error->status == MR_OK && request->page)
        write_page(request->page, request->force, c, runs, &summary, error);
    if (error->status == MR_OK && summary.failed > 0)
        error_set(error, MR_NUMERICS,
                  "%zu of %zu runways could not be played to their end: %s; see what failed",
                  summary.failed, c->seeds, request->path);
    if (error->status != MR_OK)
        code = cli_fail(error);
    code = answer_show(cli, campaign_answer(c, runs, &summary, checked ? &apart : NULL, cli->si),
                       code);
    campaign_summary_free(&summary);
    return code;
}

int campaign_command(int argc, char **argv, const struct cli *cli)
{
    struct error error = {0};
    struct campaign_request request = {0};
    struct campaign campaign;
    struct underway underway;
    struct progress progress = {.cli = cli,
                                .begin_s = steady_s(),
                                .next_s = steady_s() + PROGRESS_S,
                                .underway = &underway};
    if (read_request(argc, argv, cli, &request, &error) != MR_OK ||
        campaign_load_on(&campaign, request.path, request.ground, &error) != MR_OK)
        return cli_fail(&error);
    campaign.parting = campaign.parting || request.parting;
    if (request.seeds)
        campaign.seeds = (size_t)request.seeds;
    struct campaign_run *runs = calloc(campaign.seeds, sizeof *runs);
    int code = 0;
    underway_begin(&underway, "study", "fewer --seeds", cli->quiet);
    underway_at(&underway, "none of %zu runways is done", campaign.seeds);
    if (!runs)
        error_set(&error, MR_FULL, "out of memory: %zu seeds; give fewer", campaign.seeds);
    else
        campaign_ensemble(&campaign, (int)request.jobs, request.no_prune, tell_progress, &progress,
                          runs, &error);
    if (progress.drawn)
        fputc('\n', stderr);
    if (error.status == MR_OK) {
        code = finish(&campaign, &request, runs, cli, &underway, &error);
    } else {
        underway_end(&underway);
        code = cli_fail(&error);
    }
    for (size_t i = 0; runs && i < campaign.seeds; i++)
        campaign_run_free(&runs[i]);
    free(runs);
    campaign_free(&campaign);
    return code;
}
