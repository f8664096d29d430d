#include "host/sweep/sweep_pool.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/steady.h"

#define JOBS_MAX 1024
#define SYNC_S   1.0
#define WAKE_MS  500 /* at least so often `stop` and the clock are looked at */

struct worker {
    pid_t process; /* 0: free */
    int pipe;
    size_t index;
    double begun_s;
    char *text; /* what it said so far */
    size_t length, room;
    double cpu_ms; /* when it has ended */
};

/* ---- in the child ---- */

static bool say(int fd, const char *text)
{
    for (size_t left = strlen(text); left > 0;) {
        ssize_t put = write(fd, text, left);
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return false;
        text += put;
        left -= (size_t)put;
    }
    return true;
}

static void run_child(const struct sweep_pool *pool, size_t index, int out, pid_t parent)
{
    struct rlimit no_core = {0, 0};
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) /* it died before the line above */
        _exit(1);
    signal(SIGINT, SIG_IGN); /* the parent ends its children */
    static const int own[] = {SIGTERM, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        signal(own[i], SIG_DFL); /* a crash ends it, whatever the parent does with signals */
    setrlimit(RLIMIT_CORE, &no_core);
    close(pool->results->fd);
    json_t *outcome = sweep_case_run(pool->study, index, pool->simulate);
    char *text = json_dumps(outcome, JSON_COMPACT | JSON_REAL_PRECISION(15));
    _exit(text && say(out, text) ? 0 : 1);
}

/* ---- in the parent ---- */

static enum mr_status start(const struct sweep_pool *pool, struct worker *worker, size_t index,
                            struct error *error)
{
    int ends[2];
    pid_t parent = getpid();
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(error, MR_IO, "cannot make a pipe (%s): case %zu; lower -j",
                         strerror(errno), index);
    pid_t process = fork();
    if (process < 0) {
        close(ends[0]);
        close(ends[1]);
        return error_set(error, MR_IO, "cannot start a process (%s): case %zu; lower -j",
                         strerror(errno), index);
    }
    if (process == 0) {
        close(ends[0]);
        run_child(pool, index, ends[1], parent);
    }
    close(ends[1]);
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    *worker =
        (struct worker){.process = process, .pipe = ends[0], .index = index, .begun_s = steady_s()};
    return MR_OK;
}

/* Takes what there is to read; true at the end. */
static bool listen_to(struct worker *worker)
{
    for (;;) {
        if (worker->length + 1 >= worker->room) {
            size_t room = worker->room ? 2 * worker->room : 4096;
            char *larger = realloc(worker->text, room);
            if (!larger)
                return true;
            worker->text = larger;
            worker->room = room;
        }
        ssize_t got = read(worker->pipe, worker->text + worker->length,
                           worker->room - worker->length - 1);
        if (got > 0)
            worker->length += (size_t)got;
        else if (got < 0 && errno == EINTR)
            continue;
        else
            return got == 0 || errno != EAGAIN;
    }
}

static json_t *crashed(int status)
{
    if (WIFSIGNALED(status))
        return json_pack(
            "{s:s,s:o}", "status", "crashed", "reason",
            json_sprintf("ended by signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status))));
    return json_pack("{s:s,s:o}", "status", "crashed", "reason",
                     json_sprintf("ended without a result, exit code %d", WEXITSTATUS(status)));
}

/* Ends it if it still runs, and makes what is recorded of it. */
static json_t *outcome_of(struct worker *worker, bool late, double timeout_s)
{
    struct rusage used = {0};
    int status = 0;
    if (late)
        kill(worker->process, SIGKILL);
    while (wait4(worker->process, &status, 0, &used) < 0 && errno == EINTR)
        ;
    worker->cpu_ms = 1e3 * (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                     1e-3 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    json_t *outcome = NULL;
    if (late)
        outcome = json_pack("{s:s,s:o}", "status", "timeout", "reason",
                            json_sprintf("not done after %g s", timeout_s));
    else if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        outcome = json_loadb(worker->text ? worker->text : "", worker->length, 0, NULL);
    return outcome ? outcome : crashed(status);
}

static enum mr_status record(struct sweep_pool *pool, struct worker *worker, json_t *outcome,
                             struct error *error)
{
    char id[SWEEP_ID_SIZE];
    sweep_id_text(pool->study->ids[worker->index], id);
    json_t *line = json_pack("{s:s,s:o}", "case", id, "values",
                             sweep_study_values(pool->study, worker->index));
    json_object_update(line, outcome);
    json_object_set_new(line, "cpu_ms", json_real(worker->cpu_ms));
    char *text = json_dumps(line, JSON_COMPACT | JSON_REAL_PRECISION(15));
    if (!text)
        error_set(error, MR_FULL, "out of memory: case %s; ask for fewer outputs", id);
    else
        sweep_results_append(pool->results, text, error);
    const char *status = json_string_value(json_object_get(outcome, "status"));
    if (error->status == MR_OK) {
        pool->done++;
        pool->failed += !status || strcmp(status, "ok") != 0;
    }
    free(text);
    json_decref(line);
    return error->status;
}

static void release(struct worker *worker)
{
    close(worker->pipe);
    free(worker->text);
    *worker = (struct worker){0};
}

static enum mr_status finish(struct sweep_pool *pool, struct worker *worker, bool late,
                             struct error *error)
{
    json_t *outcome = outcome_of(worker, late, pool->timeout_s);
    record(pool, worker, outcome, error);
    json_decref(outcome);
    release(worker);
    if (error->status == MR_OK && pool->progress)
        pool->progress(pool->progress_ctx, pool->done, pool->failed);
    return error->status;
}

static int wait_ms(const struct sweep_pool *pool, const struct worker *workers)
{
    double wait_s = WAKE_MS / 1000.0, now_s = steady_s();
    for (unsigned i = 0; i < pool->jobs; i++) {
        if (workers[i].process)
            wait_s = fmin(wait_s, workers[i].begun_s + pool->timeout_s - now_s);
    }
    return (int)ceil(1000.0 * fmax(wait_s, 0.0));
}

static enum mr_status serve(struct sweep_pool *pool, struct worker *workers, struct pollfd *polled,
                            struct error *error)
{
    for (unsigned i = 0; i < pool->jobs; i++)
        polled[i] = (struct pollfd){.fd = workers[i].process ? workers[i].pipe : -1,
                                    .events = POLLIN};
    poll(polled, pool->jobs, wait_ms(pool, workers));
    for (unsigned i = 0; i < pool->jobs && !*pool->stop; i++) {
        if (!workers[i].process)
            continue;
        bool ended = (polled[i].revents & (POLLIN | POLLHUP | POLLERR)) && listen_to(&workers[i]);
        bool late = !ended && steady_s() - workers[i].begun_s >= pool->timeout_s;
        if ((ended || late) && finish(pool, &workers[i], late, error) != MR_OK)
            break;
    }
    return error->status;
}

static void end_all(struct worker *workers, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (!workers[i].process)
            continue;
        kill(workers[i].process, SIGKILL);
        while (waitpid(workers[i].process, NULL, 0) < 0 && errno == EINTR)
            ;
        release(&workers[i]);
    }
}

static enum mr_status run(struct sweep_pool *pool, struct worker *workers, struct pollfd *polled,
                          struct error *error)
{
    size_t next = 0, done_before = pool->done;
    double synced_s = steady_s();
    while (!*pool->stop && error->status == MR_OK && pool->done - done_before < pool->count) {
        for (unsigned i = 0; i < pool->jobs && next < pool->count && error->status == MR_OK; i++) {
            if (!workers[i].process && start(pool, &workers[i], pool->todo[next], error) == MR_OK)
                next++;
        }
        if (error->status == MR_OK)
            serve(pool, workers, polled, error);
        if (error->status == MR_OK && steady_s() - synced_s >= SYNC_S) {
            sweep_results_sync(pool->results, error);
            synced_s = steady_s();
        }
    }
    end_all(workers, pool->jobs);
    return error->status == MR_OK ? sweep_results_sync(pool->results, error) : error->status;
}

enum mr_status sweep_pool_run(struct sweep_pool *pool, struct error *error)
{
    if (pool->jobs > JOBS_MAX)
        pool->jobs = JOBS_MAX;
    struct worker *workers = calloc(pool->jobs, sizeof *workers);
    struct pollfd *polled = calloc(pool->jobs, sizeof *polled);
    if (!workers || !polled)
        error_set(error, MR_FULL, "out of memory: %u processes; lower -j", pool->jobs);
    else
        run(pool, workers, polled, error);
    free(workers);
    free(polled);
    return error->status;
}
