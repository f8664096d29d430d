#include "host/sweep/sweep_submit.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/output.h"
#include "host/base/place.h"
#include "host/base/shell.h"

/* What the script starts: matrig, also when this is matrig-study. */
static enum mr_status own_path(char path[PATH_MAX], struct error *error)
{
    place_program(path, PATH_MAX);
    if (path[0] != '/')
        return error_set(error, MR_IO, "cannot tell where matrig is: /proc/self/exe; mount /proc");
    return MR_OK;
}

static enum mr_status absolute(const char *path, char out[PATH_MAX], struct error *error)
{
    char folder[PATH_MAX] = "";
    if (path[0] != '/' && !getcwd(folder, sizeof folder))
        return error_set(error, MR_IO,
                         "cannot tell the folder (%s): .; change to one that is there",
                         strerror(errno));
    if (snprintf(out, PATH_MAX, "%s%s%s", folder, path[0] == '/' ? "" : "/", path) >= PATH_MAX)
        return error_set(error, MR_TOO_LONG, "path too long: %.100s...; move the files", path);
    return MR_OK;
}

static void write_sweep(FILE *file, const char *program, const char *study, const char *results,
                        const struct sweep_submission *s)
{
    shell_quote(file, program);
    fputs(" --quiet sweep ", file);
    shell_quote(file, study);
    fputs(" -o ", file);
    shell_quote(file, results);
    if (s->timeout) {
        fputs(" --timeout ", file);
        shell_quote(file, s->timeout);
    }
}

static void write_slurm(FILE *file, const char *program, const char *study, const char *results,
                        const struct sweep_submission *s)
{
    fputs("#!/bin/bash\n# Written by matrig sweep --slurm. Each task may be killed or requeued at "
          "any time: it goes on where it was.\n"
          "#SBATCH --job-name=matrig-sweep\n",
          file);
    fprintf(
        file,
        "#SBATCH --array=1-%u\n#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=1\n#SBATCH --requeue\n",
        s->shards);
    if (s->with && *s->with)
        fprintf(file, "#SBATCH %s\n", s->with);
    fputs("exec ", file);
    write_sweep(file, program, study, results, s);
    fprintf(file, " -j 1 --shard \"$SLURM_ARRAY_TASK_ID/%u\"\n", s->shards);
}

static void write_parallel(FILE *file, const char *program, const char *study, const char *results,
                           const struct sweep_submission *s)
{
    fputs("#!/bin/bash\n# Written by matrig sweep --parallel. May be killed and run again: it goes "
          "on where it was.\n",
          file);
    fprintf(file, "seq %u | parallel --will-cite --quote --jobs %u %s ", s->shards, s->jobs,
            s->with ? s->with : "");
    write_sweep(file, program, study, results, s);
    fprintf(file, " -j 1 --shard '{}/%u'\n", s->shards);
}

static enum mr_status write_script(struct sweep_submission *s, struct error *error)
{
    char program[PATH_MAX], study[PATH_MAX], results[PATH_MAX];
    if (own_path(program, error) != MR_OK || absolute(s->study, study, error) != MR_OK ||
        absolute(s->results, results, error) != MR_OK)
        return error->status;
    snprintf(s->script, sizeof s->script, "%s.%s", s->results,
             s->engine == SWEEP_SLURM ? "slurm" : "parallel");
    struct output output;
    if (output_begin(&output, s->script, s->force, error) != MR_OK)
        return error->status;
    output.executable = true;
    if (s->engine == SWEEP_SLURM)
        write_slurm(output.file, program, study, results, s);
    else
        write_parallel(output.file, program, study, results, s);
    return output_end(&output, error);
}

/* Runs a program; its standard output's first line is kept. Ctrl-C reaches the program too: it is
 * waited for. */
static enum mr_status run_program(char *const *words, char *line, size_t room, int *exit_code,
                                  struct error *error)
{
    int ends[2], status = 0;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(error, MR_IO, "cannot make a pipe (%s): %s; close other programs",
                         strerror(errno), words[0]);
    pid_t process = fork();
    if (process == 0) {
        dup2(ends[1], STDOUT_FILENO);
        execvp(words[0], words);
        _exit(127);
    }
    close(ends[1]);
    FILE *said = process > 0 ? fdopen(ends[0], "r") : NULL;
    if (!said) {
        close(ends[0]);
        return error_set(error, MR_IO, "cannot start (%s): %s; close other programs",
                         strerror(errno), words[0]);
    }
    char rest[256];
    line[0] = '\0';
    if (fgets(line, (int)room, said))
        line[strcspn(line, "\n")] = '\0';
    while (fgets(rest, sizeof rest, said))
        ;
    fclose(said);
    while (waitpid(process, &status, 0) < 0 && errno == EINTR)
        ;
    *exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (*exit_code == 127)
        return error_set(error, MR_IO, "cannot run: %s; install it (Debian: %s), or put it on PATH",
                         words[0], strcmp(words[0], "sbatch") == 0 ? "slurm-client" : "parallel");
    return MR_OK;
}

static enum mr_status submit_array(struct sweep_submission *s, struct error *error)
{
    char log[1200], script[1100];
    snprintf(log, sizeof log, "--output=%s-%%a.log", s->script);
    snprintf(script, sizeof script, "%s", s->script);
    char *words[] = {
        "sbatch", "--parsable", log, s->no_wait ? script : "--wait", s->no_wait ? NULL : script,
        NULL};
    if (run_program(words, s->job, sizeof s->job, &s->exit_code, error) != MR_OK)
        return error->status;
    s->job[strcspn(s->job, ";")] = '\0'; /* after it comes the cluster */
    if (!s->job[0])
        return error_set(error, MR_IO, "sbatch refused (exit %d): %s; see what it said above",
                         s->exit_code, s->script);
    return MR_OK;
}

/* After the array, whatever its end: the results so far in one file. */
static enum mr_status submit_gather(struct sweep_submission *s, struct error *error)
{
    char dependency[80], log[1200], said[80], *wrap = NULL;
    char program[PATH_MAX], study[PATH_MAX], results[PATH_MAX];
    size_t size;
    int code;
    if (own_path(program, error) != MR_OK || absolute(s->study, study, error) != MR_OK ||
        absolute(s->results, results, error) != MR_OK)
        return error->status;
    FILE *file = open_memstream(&wrap, &size);
    if (!file)
        return error_set(error, MR_FULL, "out of memory: %s; close other programs", s->script);
    fputs("--wrap=", file);
    write_sweep(file, program, study, results, s);
    fputs(" --gather", file);
    fclose(file);
    snprintf(dependency, sizeof dependency, "--dependency=afterany:%s", s->job);
    snprintf(log, sizeof log, "--output=%s-gather.log", s->script);
    char *words[] = {"sbatch",     "--parsable", "--job-name=matrig-gather",
                     "--ntasks=1", dependency,   log,
                     wrap,         NULL};
    if (run_program(words, said, sizeof said, &code, error) == MR_OK && code != 0)
        error_set(error, MR_IO,
                  "sbatch refused the gathering (exit %d): job %s; gather with matrig sweep "
                  "--gather later",
                  code, s->job);
    free(wrap);
    return error->status;
}

enum mr_status sweep_submit(struct sweep_submission *s, struct error *error)
{
    char said[80];
    if (write_script(s, error) != MR_OK)
        return error->status;
    if (s->engine == SWEEP_SLURM) {
        if (submit_array(s, error) == MR_OK && s->no_wait)
            submit_gather(s, error);
        return error->status;
    }
    char *words[] = {"bash", s->script, NULL};
    if (run_program(words, said, sizeof said, &s->exit_code, error) == MR_OK && s->exit_code == 127)
        error_set(error, MR_IO,
                  "cannot run: parallel; install it (Debian: parallel), or put it on PATH");
    return error->status;
}
