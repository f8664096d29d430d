/* matrig fit: parameters of the runway from the landings of a campaign. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/commands/studies.h"
#include "host/base/output.h"
#include "host/base/plot.h"
#include "host/base/quantity.h"
#include "host/base/data_dir.h"
#include "host/base/command.h"
#include "host/base/progress.h"
#include "host/study/fit/campaign.h"
#include "host/study/fit/print.h"

_Static_assert(FIT_LEAST_DRAWS == FIT_DRAWS_LEAST, "the option and the fit agree");

static enum mr_status read_request(int argc, char **argv, const struct cli *cli,
                                   struct fit_request *request, struct error *error)
{
    if (command_parse(&command_fit, argc, argv, cli, request, request->words, error) != MR_OK)
        return error->status;
    if (!request->scene) {
        data_dir_find(DATA_RUNWAY, request->model_runway, sizeof request->model_runway);
        request->scene = request->model_runway;
    }
    if (plot_check(request->plot, request->scene, error) != MR_OK)
        return error->status;
    if (request->plot && request->out_scene && strcmp(request->plot, request->out_scene) == 0)
        return error_set(error, MR_USAGE, "one file for two things: --plot and -o %s; give two",
                         request->plot);
    if (output_keep(request->out_scene, request->force, error) != MR_OK)
        return error->status;
    return output_check(request->out_scene, request->scene, error);
}

static int key_of(const char *name, size_t length)
{
    for (int k = 0; k < FIT_KEYS; k++) {
        if (strlen(fit_names[k].key) == length && strncmp(fit_names[k].key, name, length) == 0)
            return k;
    }
    return -1;
}

static enum mr_status unknown_key(const char *option, const char *name, size_t length,
                                  struct error *error)
{
    return error_set(error, MR_USAGE,
                     "unknown parameter: '%.*s' for %s; give gap, grit, f, share, KL", (int)length,
                     name, option);
}

/* "gap,f": these are fitted, the others stay at their priors' values. */
static enum mr_status set_fitted(const char *text, struct fit_landings *list, struct error *error)
{
    for (int k = 0; k < FIT_KEYS && text; k++)
        list->parameter[k].fitted = false;
    while (text) {
        size_t length = strcspn(text, ",");
        int key = key_of(text, length);
        if (key < 0)
            return unknown_key("--fit", text, length, error);
        list->parameter[key].fitted = true;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return MR_OK;
}

/* "=0.4mm:0.1mm", of the first `length` characters. */
static bool read_prior(const char *text, size_t length, const char *unit, double *value,
                       double *spread)
{
    char word[80];
    struct quantity_wrong wrong;
    if (*text != '=' || length >= sizeof word)
        return false;
    snprintf(word, sizeof word, "%.*s", (int)length - 1, text + 1);
    char *colon = strchr(word, ':');
    if (!colon)
        return false;
    *colon = '\0';
    return quantity_parse(word, unit, NULL, value, &wrong) &&
           quantity_parse(colon + 1, unit, NULL, spread, &wrong) && *value > 0.0 && *spread > 0.0 &&
         *spread <= 3.0 * *value;
}

/* "f=0.5:0.02,KL=2.9e5:3e4": value and standard error. */
static enum mr_status set_priors(const char *text, struct fit_landings *list, struct error *error)
{
    bool given[FIT_KEYS] = {false};
    while (text) {
        size_t length = strcspn(text, "=,"), whole = strcspn(text, ",");
        int key = key_of(text, length);
        double value, spread;
        if (key < 0)
            return unknown_key("--prior", text, length, error);
        if (!read_prior(text + length, whole - length, fit_names[key].unit, &value, &spread))
            return error_set(error, MR_USAGE,
                             "no prior: '%.*s'; give NAME=VALUE:ERROR, both above 0 and in %s, as "
                             "f=0.5:0.02",
                             (int)whole, text,
                             *fit_names[key].unit ? fit_names[key].unit : "no unit");
        if (given[key])
            return error_set(error, MR_USAGE, "given twice: %s in --prior; leave one out",
                             fit_names[key].key);
        given[key] = true;
        list->parameter[key].value = value;
        list->parameter[key].spread = spread / value;
        text = text[whole] == ',' ? text + whole + 1 : NULL;
    }
    return MR_OK;
}

/* All landings of the campaign, those without a known motion left out with a note. */
static enum mr_status add_all(struct store *store, const struct fit_request *request,
                              const struct cli *cli, struct fit_landings *list, struct error *error)
{
    struct store_landing *rows;
    size_t count;
    if (store_landings(store, &rows, &count, error) != MR_OK)
        return error->status;
    struct error last = {0};
    size_t left_out = 0;
    for (size_t i = 0; i < count && error->status == MR_OK; i++) {
        struct error why = {0};
        enum mr_status status = fit_campaign_add(store, rows[i].id, request->scene, list, &why);
        if (status == MR_TOO_FEW || status == MR_TRUNCATED) {
            last = why;
            left_out++;
        } else if (status != MR_OK) {
            error_set(error, status, "%s", why.text);
        }
    }
    free(rows);
    if (error->status == MR_OK && list->count == 0)
        error_set(error, left_out ? last.status : MR_TOO_FEW, "no landing to fit: %s: %s",
                  request->words[0],
                  left_out
                      ? last.text
                      : "it has none; log one with at least 3 switches, a stop and a transducer");
    else if (left_out)
        cli_note(cli, "landings left out: %zu; the last one: %s", left_out, last.text);
    return error->status;
}

/* A landing that counts twice would halve what it says it does not know. */
static enum mr_status add_named(struct store *store, const struct fit_request *request,
                                struct fit_landings *list, struct error *error)
{
    int64_t runs[FIT_RUNS_MAX];
    for (size_t i = 0; i < FIT_RUNS_MAX && request->words[i + 1]; i++) {
        if (run_parse(request->words[i + 1], &runs[i], error) != MR_OK)
            return error->status;
        for (size_t k = 0; k < i; k++) {
            if (runs[k] == runs[i])
                return error_set(error, MR_USAGE, "given twice: RUN %s; leave one out",
                                 request->words[i + 1]);
        }
        if (fit_campaign_add(store, runs[i], request->scene, list, error) != MR_OK)
            return error->status;
    }
    return MR_OK;
}

static enum mr_status load(const struct fit_request *request, const struct cli *cli,
                           struct fit_landings *list, struct error *error)
{
    struct store *store = NULL;
    struct sim_scene scene;
    if (store_open(request->words[0], STORE_OPEN, &store, error) != MR_OK)
        return error->status;
    if (sim_scene_load(&scene, request->scene, error) == MR_OK) {
        fit_landings_begin(list, &scene);
        sim_scene_free(&scene);
        add_named(store, request, list, error);
        if (error->status == MR_OK && !request->words[1])
            add_all(store, request, cli, list, error);
    }
    store_close(store);
    if (error->status == MR_OK) {
        fit_campaign_set_gap(list);
        set_fitted(request->fitted, list, error);
    }
    return error->status == MR_OK ? set_priors(request->prior, list, error) : error->status;
}

static bool show_progress(void *progress, unsigned round, size_t done, size_t of)
{
    progress_at(progress, "round %u is at %zu of %zu data sets", round + 1, done, of);
    return true;
}

int fit_command(int argc, char **argv, const struct cli *cli)
{
    struct fit_request request = {0};
    struct fit_landings list = {0};
    struct fit_answer answer = {0};
    struct misfit misfit = {0};
    struct error error = {0};
    int exit_code = 0;
    if (read_request(argc, argv, cli, &request, &error) == MR_OK &&
        load(&request, cli, &list, &error) == MR_OK) {
        struct fit_model model = fit_landings_model(&list);
        struct progress progress;
        struct fit_options options = {.draws = (size_t)request.draws,
                                      .threads = (unsigned)request.threads,
                                      .seed = (uint64_t)request.seed,
                                      .max_s = request.max_s,
                                      .go_on = show_progress,
                                      .go_on_context = &progress};
        progress_begin(&progress, "fit", "fewer --draws", cli->quiet);
        if (fit_run(&model, list.measured, &options, &answer, &error) == MR_OK)
            misfit = misfit_check(&list, &answer, (uint64_t)request.seed);
        progress_end(&progress);
    }
    if (error.status == MR_OK && request.plot)
        fit_write_plot(&list, &answer, &misfit, request.plot, &error);
    if (error.status == MR_OK && request.out_scene)
        fit_write_scene(&list, &answer, request.scene, request.out_scene, &error);
    if (error.status == MR_OK)
        exit_code = answer_show(cli, fit_described(&list, &answer, &misfit, cli->si),
                                misfit.cannot ? 1 : 0);
    fit_free(&answer);
    fit_landings_free(&list);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}
