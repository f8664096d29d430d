/* matrig sweep: studies over many scenes, in processes of their own. */
#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/steady.h"
#include "host/commands/commands.h"
#include "host/commands/sweep_command.h"
#include "host/base/output.h"
#include "host/study/studies.h"
#include "host/sweep/sweep_pool.h"
#include "host/sweep/sweep_share.h"
#include "host/sweep/sweep_submit.h"

#define PROGRESS_S 0.5

static volatile sig_atomic_t stopped;

static void on_stop(int number)
{
    (void)number;
    stopped = 1;
}

static void catch_stop(void)
{
    struct sigaction action = {.sa_handler = on_stop};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

/* ---- the command line ---- */

/* Processors that this process may use: what Slurm or taskset left it. */
static unsigned processors(void)
{
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? (unsigned)CPU_COUNT(&set) : 1;
}

/* study.json -> study.jsonl */
static enum mr_status results_path(struct sweep_request *r, const char *output, struct error *error)
{
    const char *from = output ? output : r->study;
    size_t length = strlen(from);
    if (!output && length > 5 && strcmp(from + length - 5, ".json") == 0)
        length -= 5;
    if (!output && length > 6 && strcmp(from + length - 6, ".study") == 0)
        length -= 6; /* the copy beside results: its results */
    if (length + 7 > sizeof r->results)
        return error_set(error, MR_TOO_LONG, "path too long: %.100s...; give a shorter one", from);
    snprintf(r->results, sizeof r->results, "%.*s%s", (int)length, from, output ? "" : ".jsonl");
    if (strcmp(r->results, r->study) == 0)
        return error_set(error, MR_USAGE,
                         "would overwrite the sweep: %s; give another file with -o", r->study);
    return MR_OK;
}

static enum mr_status check_together(const struct sweep_request *r, struct error *error)
{
    bool submits = r->slurm || r->parallel;
    if (r->slurm + r->parallel + r->gather + r->list > 1)
        return error_set(
            error, MR_USAGE,
            "too much at once: matrig sweep; give one of --slurm, --parallel, --gather, --list");
    if ((submits || r->gather || r->list) && (r->shard_text || r->retry))
        return error_set(error, MR_USAGE,
                         "do not go together: --%s with --slurm, --parallel, --gather or --list; "
                         "run it on its own",
                         r->shard_text ? "shard" : "retry");
    if (!submits && (r->shards || r->with))
        return error_set(error, MR_USAGE, "alone: --%s; it goes with --slurm or --parallel",
                         r->shards ? "shards" : "with");
    if (r->no_wait && !r->slurm)
        return error_set(error, MR_USAGE, "alone: --no-wait; it goes with --slurm");
    if (r->parts && !r->gather)
        return error_set(error, MR_USAGE,
                         "one word too many: '%s' of sweep; see matrig sweep --help", r->words[1]);
    if (r->with && strchr(r->with, '\n'))
        return error_set(error, MR_USAGE, "more than one line: --with; write the options on one");
    return MR_OK;
}

static enum mr_status read_request(int argc, char **argv, const struct cli *cli,
                                   struct sweep_request *r, struct error *error)
{
    if (command_parse(&command_sweep, argc, argv, cli, r, r->words, error) != MR_OK)
        return error->status;
    r->study = r->words[0];
    while (r->words[1 + r->parts])
        r->parts++;
    if (results_path(r, r->output, error) != MR_OK || check_together(r, error) != MR_OK)
        return error->status;
    if (!r->jobs)
        r->jobs = processors();
    if (!r->shards)
        r->shards = r->slurm ? 16 : 4 * r->jobs;
    if (r->slurm || r->parallel || r->gather || r->list)
        return MR_OK; /* within a job array too these are about the whole study */
    return sweep_shard_read(&r->shard, r->shard_text, error);
}

/* ---- the copy of the study ---- */

static bool same_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    size_t length = strlen(text), at = 0;
    int c;
    while ((c = fgetc(file)) != EOF && at < length && c == (unsigned char)text[at])
        at++;
    bool same = c == EOF && at == length;
    fclose(file);
    return same;
}

/* Beside the results, so that they say what they are of, and so that a study edited later does not
 * change what shards run. Put there by a rename: shards that begin together write the same. */
static enum mr_status keep_study(const struct sweep_study *study, const char *results, bool force,
                                 char *path, struct error *error)
{
    sweep_study_path(results, path);
    char *text = json_dumps(study->root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    if (!text)
        return error_set(error, MR_FULL, "out of memory: %s; use a smaller base", path);
    if (!same_text(path, text))
        output_bytes(path, force, text, strlen(text), error);
    free(text);
    return error->status;
}

/* ---- what is said ---- */

struct progress {
    const struct cli *cli;
    size_t before, failed, share;
    double begun_s, next_s;
    bool drawn;
};

static void show(void *ctx, size_t done, size_t failed)
{
    struct progress *p = ctx;
    double now = steady_s();
    if (p->cli->quiet || !cli_terminal() || now < p->next_s)
        return;
    double left_s = (now - p->begun_s) / (double)done * (double)(p->share - p->before - done);
    fprintf(stderr, "\rmatrig: sweep: %zu of %zu cases, %zu failed, %.0f s left   ",
            p->before + done, p->share, p->failed + failed, left_s);
    p->drawn = true;
    p->next_s = now + PROGRESS_S;
}

struct outcome {
    size_t share, before, run, failed, missing, twice, torn;
    double took_s;
    char path[SWEEP_PATH_MAX + 40];
    struct sweep_gathered gathered;
    bool gathers;
};

static int print_outcome(const struct sweep_request *r, const struct sweep_study *study,
                         const struct outcome *o, const struct cli *cli)
{
    int code = o->missing ? mr_status_exit_code(MR_LIMIT) : 0;
    if (o->torn)
        cli_note(cli, "%s: a torn last line of %zu bytes was taken off; its case is done again",
                 o->path, o->torn);
    if (o->twice)
        cli_note(cli, "%s: %zu lines repeat a case; the first counts", o->path, o->twice);
    if (o->gathered.differ)
        cli_note(cli, "%zu cases differ between two files (%s for one): the first is kept",
                 o->gathered.differ, o->gathered.differs);
    if (cli->json) {
        json_t *object = json_pack("{s:s,s:I,s:I,s:I,s:I,s:I,s:I,s:s,s:o}", "study", r->study,
                                   "cases", (json_int_t)study->cases, "share", (json_int_t)o->share,
                                   "before", (json_int_t)o->before, "run", (json_int_t)o->run,
                                   "failed", (json_int_t)o->failed, "missing",
                                   (json_int_t)o->missing, "results", o->path, "took_s",
                                   cli_json_number(o->took_s, 6));
        if (r->shard.n)
            json_object_set_new(object, "shard", json_sprintf("%u/%u", r->shard.i, r->shard.n));
        if (o->gathers) {
            json_object_set_new(object, "gathered", json_integer((json_int_t)o->gathered.added));
            json_object_set_new(object, "differ", json_integer((json_int_t)o->gathered.differ));
        }
        return cli_print_json(object, code);
    }
    printf("%s: ", r->study);
    if (r->shard.n)
        printf("shard %u/%u, %zu of %zu cases: ", r->shard.i, r->shard.n, o->share, study->cases);
    else
        printf("%zu cases: ", study->cases);
    if (o->gathers)
        printf("%zu gathered from %zu files", o->gathered.added, o->gathered.parts);
    else
        printf("%zu done before, %zu run in %.1f s", o->before, o->run, o->took_s);
    printf(", %zu failed, %zu missing: %s\n", o->failed, o->missing, o->path);
    if (stopped)
        cli_note(cli, "stopped; the same command goes on");
    return code;
}

/* ---- a run ---- */

static bool is_ok(void *ctx, const json_t *line)
{
    (void)ctx;
    return strcmp(json_string_value(json_object_get(line, "status")), "ok") == 0;
}

static size_t *to_do(const struct sweep_request *r, const struct sweep_study *study,
                     const struct sweep_done *done, struct outcome *o, size_t *count)
{
    size_t *todo = calloc(study->cases, sizeof *todo);
    *count = 0;
    for (size_t i = 0; todo && i < study->cases; i++) {
        if (!sweep_shard_has(&r->shard, i))
            continue;
        o->share++;
        if (done->done[i])
            o->before++;
        else
            todo[(*count)++] = i;
    }
    return todo;
}

static enum mr_status run_cases(const struct sweep_request *r, const struct sweep_study *study,
                                struct sweep_results *results, const struct sweep_done *done,
                                struct outcome *o, const struct cli *cli, struct error *error)
{
    size_t count, *todo = to_do(r, study, done, o, &count);
    struct progress progress = {
        .cli = cli, .before = o->before, .share = o->share, .begun_s = steady_s()};
    struct sweep_pool pool = {.study = study,
                              .simulate = sweep_simulation(study->kind),
                              .results = results,
                              .todo = todo,
                              .count = count,
                              .jobs = (unsigned)r->jobs,
                              .timeout_s = r->timeout_s > 0.0 ? r->timeout_s : study->timeout_s,
                              .stop = &stopped,
                              .progress = show,
                              .progress_ctx = &progress};
    if (!todo)
        return error_set(error, MR_FULL, "out of memory: %zu cases; split the sweep", study->cases);
    progress.next_s = progress.begun_s + PROGRESS_S;
    sweep_pool_run(&pool, error);
    if (progress.drawn)
        fputc('\n', stderr);
    o->run = pool.done;
    o->failed += pool.failed;
    o->missing = o->share - o->before - o->run;
    o->took_s = steady_s() - progress.begun_s;
    free(todo);
    return error->status;
}

static enum mr_status run_share(const struct sweep_request *r, const struct sweep_study *study,
                                struct outcome *o, const struct cli *cli, struct error *error)
{
    struct sweep_results results;
    struct sweep_done done = {.retry = r->retry};
    char copy[SWEEP_PATH_MAX + 40];
    sweep_shard_path(r->results, &r->shard, o->path);
    if (sweep_results_open(&results, o->path, error) != MR_OK)
        return error->status;
    o->torn = results.torn;
    if (r->retry)
        sweep_results_rewrite(&results, is_ok, NULL, error);
    if (error->status == MR_OK &&
        sweep_done_load(&done, study, &results, r->results, error) == MR_OK &&
        keep_study(study, r->results, r->force, copy, error) == MR_OK) {
        o->failed = done.failed;
        o->twice = done.twice;
        run_cases(r, study, &results, &done, o, cli, error);
    }
    free(done.done);
    sweep_results_close(&results);
    return error->status;
}

static enum mr_status gather(const struct sweep_request *r, const struct sweep_study *study,
                             struct outcome *o, struct error *error)
{
    struct sweep_results results;
    struct sweep_done done = {0}, after = {0};
    snprintf(o->path, sizeof o->path, "%s", r->results);
    for (size_t i = 0; i < r->parts; i++) {
        if (access(r->words[1 + i], R_OK) != 0)
            return error_set(error, MR_IO, "cannot open (%s): %s; check path and rights",
                             strerror(errno), r->words[1 + i]);
    }
    if (sweep_results_open(&results, r->results, error) != MR_OK)
        return error->status;
    o->torn = results.torn;
    o->gathers = true;
    done.study = study;
    if (sweep_gather(&results, &done, r->results, r->parts ? r->words + 1 : NULL, r->parts,
                     &o->gathered, error) == MR_OK &&
        sweep_done_load(&after, study, &results, r->results, error) == MR_OK) {
        o->share = study->cases;
        o->failed = after.failed;
        o->twice = after.twice;
        o->missing = study->cases - after.count;
    }
    free(after.done);
    sweep_results_close(&results);
    return error->status;
}

static enum mr_status submit(const struct sweep_request *r, const struct sweep_study *study,
                             struct outcome *o, const struct cli *cli, struct error *error)
{
    char copy[SWEEP_PATH_MAX + 40];
    unsigned shards = (size_t)r->shards < study->cases ? (unsigned)r->shards
                                                       : (unsigned)study->cases;
    char timeout[32];
    snprintf(timeout, sizeof timeout, "%.17g", r->timeout_s);
    struct sweep_submission s = {.engine = r->slurm ? SWEEP_SLURM : SWEEP_PARALLEL,
                                 .study = copy,
                                 .results = r->results,
                                 .shards = shards,
                                 .jobs = (unsigned)r->jobs,
                                 .with = r->with,
                                 .timeout = r->timeout_s > 0.0 ? timeout : NULL,
                                 .no_wait = r->no_wait,
                                 .force = r->force};
    double begun_s = steady_s();
    if (gather(r, study, o, error) != MR_OK)
        return error->status; /* results of another study */
    if (o->missing == 0) {
        cli_note(cli, "nothing is missing: %s", r->results);
        return MR_OK;
    }
    if (keep_study(study, r->results, r->force, copy, error) != MR_OK ||
        sweep_submit(&s, error) != MR_OK)
        return error->status;
    if (r->slurm)
        cli_note(cli, "Slurm job %s, %u shards, by %s%s", s.job, shards, s.script,
                 r->no_wait ? "; the results are gathered when it has ended" : "");
    if (r->no_wait)
        return MR_OK;
    if (stopped && r->slurm)
        cli_note(cli,
                 "no longer waiting; job %s goes on: gather later with --gather, or scancel %s",
                 s.job, s.job);
    gather(r, study, o, error);
    o->took_s = steady_s() - begun_s;
    if (error->status == MR_OK && o->missing)
        cli_note(cli, "exit %d of %s: see %s; the same command goes on", s.exit_code,
                 r->slurm ? "sbatch" : "parallel", s.script);
    return error->status;
}

/* ---- without running ---- */

static json_t *list_case(const struct sweep_study *study, size_t i)
{
    char id[SWEEP_ID_SIZE];
    sweep_id_text(study->ids[i], id);
    return json_pack("{s:s,s:o}", "case", id, "values", sweep_study_values(study, i));
}

static int list_cases(const struct sweep_study *study, const struct cli *cli)
{
    if (cli->json) {
        json_t *list = json_array();
        for (size_t i = 0; i < study->cases; i++)
            json_array_append_new(list, list_case(study, i));
        return cli_print_json(json_pack("{s:o}", "cases", list), 0);
    }
    for (size_t i = 0; i < study->cases; i++) {
        json_t *line = list_case(study, i);
        json_dumpf(line, stdout, JSON_COMPACT | JSON_REAL_PRECISION(15));
        putchar('\n');
        json_decref(line);
    }
    return 0;
}

int sweep_command(int argc, char **argv, const struct cli *cli)
{
    struct sweep_request request = {0};
    struct sweep_study study;
    struct outcome outcome = {0};
    struct error error = {0};
    if (read_request(argc, argv, cli, &request, &error) != MR_OK ||
        sweep_study_load(&study, request.study, &error) != MR_OK)
        return cli_fail(&error);
    int code = 0;
    if (request.list) {
        code = list_cases(&study, cli);
        sweep_study_free(&study);
        return code;
    }
    catch_stop();
    if (request.slurm || request.parallel)
        submit(&request, &study, &outcome, cli, &error);
    else if (request.gather)
        gather(&request, &study, &outcome, &error);
    else
        run_share(&request, &study, &outcome, cli, &error);
    if (error.status != MR_OK)
        code = cli_fail(&error);
    else if (!request.no_wait)
        code = print_outcome(&request, &study, &outcome, cli);
    sweep_study_free(&study);
    return code;
}
