/* matrig fit: parameters of the runway from the landings of a campaign. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/commands/commands.h"
#include "host/study/fit/campaign.h"
#include "host/study/fit/print.h"
#include "host/output.h"
#include "host/place.h"
#include "host/run.h"

#define RUNS_MAX 20
#define PRIORS_MAX FIT_KEYS

struct request {
    const char *words[1 + RUNS_MAX];
    const char *scene, *fitted, *prior, *plot, *out_scene;
    bool force;
    struct fit_options options;
    int64_t draws, seed, threads; /* threads 0: as many as processors */
    char model_runway[500];
};

static enum mr_status read_request(int argc, char **argv, const struct cli *cli, struct request *request, struct error *error)
{
    if (command_parse(&command_fit, argc, argv, cli, request, request->words, error) != MR_OK)
        return error->status;
    request->options.draws = (size_t)request->draws;
    request->options.seed = (uint64_t)request->seed;
    request->options.threads = (unsigned)request->threads;
    if (!request->scene) {
        place_find(PLACE_RUNWAY, request->model_runway, sizeof request->model_runway);
        request->scene = request->model_runway;
    }
    if (output_check(request->plot, request->force, request->scene, error) != MR_OK)
        return error->status;
    if (request->plot && request->out_scene && strcmp(request->plot, request->out_scene) == 0)
        return error_set(error, MR_USAGE, "one file for two things: --plot and -o %s; give two", request->plot);
    return output_check(request->out_scene, request->force, request->scene, error);
}

static int key_of(const char *name, size_t length)
{
    for (int k = 0; k < FIT_KEYS; k++) {
        if (strlen(fit_names[k].key) == length && strncmp(fit_names[k].key, name, length) == 0)
            return k;
    }
    return -1;
}

static enum mr_status unknown_key(const char *option, const char *name, size_t length, struct error *error)
{
    return error_set(error, MR_USAGE, "unknown parameter: '%.*s' for %s; give gap, grit, f, share, KL", (int)length, name, option);
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

/* "f=0.5:0.02,KL=2.9e5:3e4": value and standard error. */
static enum mr_status set_priors(const char *text, struct fit_landings *list, struct error *error)
{
    bool given[FIT_KEYS] = {false};
    while (text) {
        size_t length = strcspn(text, "=,"), whole = strcspn(text, ",");
        int key = key_of(text, length), used = 0;
        double value, spread;
        if (key < 0)
            return unknown_key("--prior", text, length, error);
        if (text[length] != '=' || sscanf(text + length, "=%lf:%lf%n", &value, &spread, &used) != 2 || length + (size_t)used != whole ||
            !(value > 0.0) || !(spread > 0.0) || !isfinite(value) || !(spread <= 3.0 * value))
            return error_set(error, MR_USAGE, "no prior: '%.*s'; give NAME=VALUE:ERROR, both above 0, as f=0.5:0.02", (int)whole, text);
        if (given[key])
            return error_set(error, MR_USAGE, "given twice: %s in --prior; leave one out", fit_names[key].key);
        given[key] = true;
        list->parameter[key].value = value;
        list->parameter[key].spread = spread / value;
        text = text[whole] == ',' ? text + whole + 1 : NULL;
    }
    return MR_OK;
}

/* All landings of the campaign, those without a known motion left out with a note. */
static enum mr_status add_all(struct store *store, const struct request *request, const struct cli *cli, struct fit_landings *list,
                              struct error *error)
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
        error_set(error, left_out ? last.status : MR_TOO_FEW, "no landing to fit: %s: %s", request->words[0],
                  left_out ? last.text : "it has none; log one with at least 3 switches, a stop and a transducer");
    else if (left_out)
        cli_note(cli, "landings left out: %zu; the last one: %s", left_out, last.text);
    return error->status;
}

/* A landing that counts twice would halve what it says it does not know. */
static enum mr_status add_named(struct store *store, const struct request *request, struct fit_landings *list, struct error *error)
{
    int64_t runs[RUNS_MAX];
    for (size_t i = 0; i < RUNS_MAX && request->words[i + 1]; i++) {
        if (run_parse(request->words[i + 1], &runs[i], error) != MR_OK)
            return error->status;
        for (size_t k = 0; k < i; k++) {
            if (runs[k] == runs[i])
                return error_set(error, MR_USAGE, "given twice: RUN %s; leave one out", request->words[i + 1]);
        }
        if (fit_campaign_add(store, runs[i], request->scene, list, error) != MR_OK)
            return error->status;
    }
    return MR_OK;
}

static enum mr_status load(const struct request *request, const struct cli *cli, struct fit_landings *list, struct error *error)
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

static bool show_progress(void *context, unsigned round, size_t done, size_t of)
{
    (void)context;
    fprintf(stderr, "\rround %u: %zu of %zu data sets ", round + 1, done, of);
    if (done == of)
        fprintf(stderr, "\r\033[K");
    return true;
}

static int fit_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct fit_landings list = {0};
    struct fit_answer answer = {0};
    struct error error = {0};
    int exit_code = 0;
    if (read_request(argc, argv, cli, &request, &error) == MR_OK && load(&request, cli, &list, &error) == MR_OK) {
        struct fit_model model = fit_landings_model(&list);
        if (cli_terminal() && !cli->quiet)
            request.options.go_on = show_progress;
        fit_run(&model, list.measured, &request.options, &answer, &error);
    }
    if (error.status == MR_OK && request.plot)
        fit_write_plot(&list, &answer, request.plot, request.force, &error);
    if (error.status == MR_OK && request.out_scene)
        fit_write_scene(&list, &answer, request.scene, request.out_scene, request.force, &error);
    if (error.status == MR_OK && cli->json)
        exit_code = cli_print_json(fit_json(&list, &answer, cli->si), 0);
    else if (error.status == MR_OK)
        fit_print(&list, &answer, cli->si);
    fit_free(&answer);
    fit_landings_free(&list);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB [RUN...]", "campaign database and landings in it; else all whose motion is known"),
    OPTION_TEXT("--scene", "S", scene,
                "scene file that gives the runway (model chain) and the priors' values; else the model runway"),
    OPTION_TEXT("--fit", "NAMES", fitted,
                "of gap,grit,f,share,KL: these are fitted, the others stay as they are; else all"),
    OPTION_TEXT("--prior", "NAME=V:E,...", prior,
                "what is known beforehand: value and standard error (lb, in, lb/ft). Else grit, KL and an unsurveyed gap are\n"
                "the scene's, known to 50 %, f to 20 %, share 1/12 to 15 %, a surveyed gap the survey's to 3 %"),
    OPTION_WHOLE("--draws", "N", draws, FIT_DRAWS_LEAST, 1e5, 300.0, "simulated data sets a round, at least {low}; else {standard}"),
    OPTION_WHOLE("--seed", "N", seed, 0.0, 1e9, 1.0, "of what is drawn; else {standard}. The same seed gives the same answer"),
    OPTION_WHOLE("-j", "N", threads, 1.0, 64.0, 0.0, "threads; else as many as processors"),
    OPTION_NUMBER("--max-time", "S", options.max_s, "s", 1.0, 1e6, 600.0,
                "else {standard}; an answer that is not settled by then is given and said to be so"),
    OPTION_TEXT("--plot", "F.svg", plot, "residual plots"),
    OPTION_TEXT("-o", "F", out_scene, "the scene with the fitted values"),
    OPTION_FORCE(force),
    HELP_EXAMPLE("matrig fit campaign.db 1 --fit grit,f --prior f=0.5:0.05 --plot fit.svg"),
};

const struct command command_fit = {
    "fit", fit_command,
    "DB [RUN...] [--scene S] [--fit NAMES] [--prior NAME=V:E,...] [--draws N] [--seed N] [-j N] [--max-time S] [--plot F.svg] [-o F] [--force]",
    "gaps, resistance, friction, thrust share and stiffness from landings, with their errors", COMMAND_PARTS(parts), {1, 1 + RUNS_MAX, "DB [RUN...]"},
};
