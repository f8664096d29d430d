/* The command matrig compare: compares one measured landing, or a series, with simulated landings
 * (host/compare/). */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/analyse/measured.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/compare/show.h"
#include "host/compare/landing.h"
#include "host/base/output.h"
#include "host/base/data_dir.h"
#include "host/base/command.h"
#include "host/store/store_journal.h"

struct request {
    const char *db, *scene, *series, *output, *limits_path;
    int64_t run; /* RUN of the landing; 0: a series is compared */
    /* number of simulated runways; 0: as many as the file of the series defines */
    int64_t seeds;
    double rms_limit_in; /* largest rms difference, in; NaN: no limit */
    bool include_voided, all;
    struct compare_limits limits;
    char runway[500];
};

/* True if the word is a file name; false if it is the number of a landing. */
static bool is_file(const char *word)
{
    size_t length = strlen(word);
    return (length > 5 && strcmp(word + length - 5, ".json") == 0) ||
           (!isdigit((unsigned char)word[0]) && access(word, F_OK) == 0);
}

/* Reads the operands: DB RUN [FILE], DB FILE, or DB with --series. FILE may also be the value of
 * --scene. */
static void read_words(const char *const words[3], struct request *request)
{
    request->db = words[0];
    const char *file = words[1] && is_file(words[1]) ? words[1] : words[2];
    if (!words[1] && !request->series && !request->scene)
        error_set(fatal, MR_USAGE,
                  "argument missing: matrig compare needs DB RUN, DB FILE or DB --series NAME; see "
                  "matrig compare --help");
    if (words[1] && file != words[1])
        parse_run(words[1], &request->run, fatal);
    if (file == words[1] && words[2])
        error_set(fatal, MR_USAGE,
                  "unexpected argument: '%s' of compare; see matrig compare --help", words[2]);
    if (request->run && request->series)
        error_set(fatal, MR_USAGE,
                  "RUN and --series exclude each other: %s and --series %s; give only one",
                  words[1], request->series);
    if (!request->run && (request->output || request->include_voided))
        error_set(fatal, MR_USAGE, "%s works only for a single landing; give the RUN of a landing",
                  request->output ? "-o" : "--void");
    if (file && request->scene)
        error_set(fatal, MR_USAGE, "two scenes given: %s and --scene %s; give only one", file,
                  request->scene);
    request->scene = file ? file : request->scene;
    if (!request->scene) {
        data_dir_find(DATA_RUNWAY_SCENE, request->runway, sizeof request->runway);
        request->scene = request->runway;
    }
}

static void read_request(int argc, char **argv, const struct cli *cli, struct request *request)
{
    const char *words[3];
    memset(request, 0, sizeof *request);
    command_parse(&command_compare, argc, argv, cli, request, words, fatal);
    read_words(words, request);
    if (!isnan(request->rms_limit_in))
        compare_limits_add(&request->limits, "channels.*.rms_in", request->rms_limit_in);
    output_check(request->output, request->scene, fatal);
    output_check_not_input(request->output, request->limits_path, fatal);
    if (request->limits_path)
        compare_limits_load(&request->limits, request->limits_path, fatal);
}

static void write_csv(const struct request *request, const struct compare_landing *landing, bool si)
{
    struct output output;
    output_begin(&output, request->output, fatal);
    compare_write_csv(output.file, landing, si);
    output_end(&output, fatal);
}

/* Prints the answer. If a limit is exceeded, reports an error afterwards. */
static int print_verdict(const struct compare_verdict *verdict, struct answer *answer,
                         const struct cli *cli)
{
    struct error error = {0};
    int exit_code = answer_print(cli, answer, 0);
    if (verdict->failed_limit_count > 1)
        error_set(&error, MR_LIMIT, "%s; and %zu more of %zu limits fail", verdict->worst_failure,
                  verdict->failed_limit_count - 1, verdict->checked_limit_count);
    else if (verdict->failed_limit_count)
        error_set(&error, MR_LIMIT, "%s; see the table above, or change the limits",
                  verdict->worst_failure);
    return exit_code == 0 && verdict->failed_limit_count ? cli_fail(&error) : exit_code;
}

static int compare_one_landing(struct store *store, const struct request *request,
                               struct compare_model *model, const struct cli *cli)
{
    struct compare_landing landing;
    struct compare_verdict verdict = {0};
    struct answer *answer = answer_new(cli->si);
    store_check_not_void(store, request->run, request->include_voided, fatal);
    compare_run_landing(store, request->run, model, 0, &landing, fatal);
    if (request->output)
        write_csv(request, &landing, cli->si);
    compare_check(&landing.figures, &request->limits, &verdict);
    if (cli->json || request->all)
        compare_to_answer(&landing.figures, &verdict, answer);
    else
        compare_add_summary(&landing.figures, &verdict, answer);
    measured_print_excluded(&landing.measured, cli);
    compare_landing_free(&landing);
    return print_verdict(&verdict, answer, cli);
}

static void show_progress(void *ctx, size_t done, size_t total)
{
    const struct cli *cli = ctx;
    if (!cli->quiet && cli_is_stderr_terminal())
        fprintf(stderr, "\r%zu of %zu landings%s", done, total, done == total ? "\n" : "");
}

static int compare_all_landings(struct store *store, const struct request *request,
                                struct compare_model *model, const struct cli *cli)
{
    struct compare_series set;
    struct answer *answer = answer_new(cli->si);
    struct cli for_progress = *cli;
    compare_series_run(store, request->series, model, show_progress, &for_progress, &set, fatal);
    compare_series_check(&set, &request->limits);
    compare_series_to_answer(&set, answer);
    struct compare_verdict verdict = set.verdict;
    compare_series_free(&set);
    return print_verdict(&verdict, answer, cli);
}

static int compare_command(int argc, char **argv, const struct cli *cli)
{
    struct request request;
    struct compare_model model;
    read_request(argc, argv, cli, &request);
    struct error cannot = {0};
    bool stored = access(request.db, F_OK) != 0 ||
                  store_check_writable(request.db, &cannot) == MR_OK;
    struct store *store = program_open_campaign(request.db, stored ? STORE_OPEN : STORE_READ);
    store_find_run(store, &request.run, fatal);
    compare_model_load(&model, request.scene, (size_t)request.seeds, fatal);
    model.is_storing_disabled = !stored;
    if (!stored)
        cli_note(cli, "the comparison was not stored: %s", cannot.text);
    int exit_code = request.run ? compare_one_landing(store, &request, &model, cli)
                                : compare_all_landings(store, &request, &model, cli);
    compare_model_free(&model);
    compare_limits_free(&request.limits);
    return exit_code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB RUN", "campaign database and number of a landing"),
    HELP_ITEM("FILE",
              "scene or study file; default: the model runway. A study file describes an ensemble "
              "of runways, so the simulation has a spread. Without RUN, all landings are compared "
              "in order; each landing starts with the runway at the end of the preceding one"),
    OPTION_TEXT("--scene", "S", scene, "same as FILE"),
    OPTION_TEXT("--series", "NAME", series,
                "compare only the landings of this series (matrig landing --series); default: all "
                "landings"),
    OPTION_TEXT(
        "--limits", "F", limits_path,
        "file of limits. Each limit names a value by its path in the JSON result. A limit is the "
        "largest allowed magnitude; for share and within, it is the smallest allowed value. Exit 1 "
        "when a limit is violated:\n  {\"channels.*.rms_in\": 0.05, \"channels.3.rms_in\": 0.1,\n  "
        " \"zones.*.overlap_simulated.share\": 0.5, \"series.within\": 0.8}"),
    OPTION_NUMBER("--limit", "IN", rms_limit_in, "in", 0.0, 1e6, (double)NAN,
                  "exit 1 when the rms difference of a channel exceeds IN inches"),
    OPTION_INTEGER("--seeds", "N", seeds, 1.0, SERIES_SEEDS_MAX, 0.0,
                   "number of seeds (runways); default: the number in the study file"),
    OPTION_TEXT("-o", "F.csv", output,
                "for one landing: write measured and simulated values every millisecond"),
    OPTION_FLAG("--all", all, "for one landing: also print each transducer and each zone"),
    OPTION_FLAG("--void", include_voided, "include a voided landing (matrig landing)"),
    HELP_EXAMPLE("matrig compare campaign.db 5 --limits limits.json\n"
                 "         matrig compare campaign.db host/landing_series/series/standard.json"),
};

const struct command command_compare = {
    "compare",
    compare_command,
    "DB RUN [FILE | --scene S] [--limits F] [--limit IN] [--seeds N] [-o F.csv] [--all] "
    "[--void]\nDB FILE [--series NAME]\nDB --series NAME",
    "compare measurement and simulation of a landing or a series",
    COMMAND_PARTS(parts),
    {1, 3, "DB RUN"},
};
