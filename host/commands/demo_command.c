/* matrig demo: recorded landings on the emulated board, logged, compared and reported, each by the
 * program that a user would start. */
#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "host/base/place.h"
#include "host/base/process.h"
#include "host/base/scratch.h"
#include "host/base/steady.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/replay/board.h"

#define FOLDER    "matrig-demo"
#define PROGRAM_S 600.0 /* a landing takes seconds; a computer may be busy */
#define ENDING_S  60.0  /* after the board has ended: what logs it */
#define POLL_NS   5000000
#define WORDS_MAX 24

/* Of the standard series (tests/runs/README.md): two gentle ones, and one with a warning. */
static const int landings[] = {1, 4, 5};
#define LANDINGS (sizeof landings / sizeof landings[0])

struct demo {
    const struct cli *cli;
    const char *folder;
    struct replay_board board;
    char program[PATH_MAX], elf[PATH_MAX], matrig[PATH_MAX], runs[PATH_MAX];
    char sockets[SCRATCH_PATH], can[SCRATCH_PATH + 20], serial[SCRATCH_PATH + 20];
    char db[PATH_MAX], page[PATH_MAX];
    json_t *told[LANDINGS], *report; /* with --json: what the programs answered */
    double log_s[LANDINGS], compare_s[LANDINGS], report_s;
};

static volatile sig_atomic_t stopped;

static void on_signal(int number)
{
    (void)number;
    stopped = 1;
}

/* ---- programs ---- */

/* `said` NULL: its standard output is ours. */
static enum mr_status start_matrig(const struct demo *demo, const char *const words[], FILE *said,
                                   pid_t *child, struct error *error)
{
    const char *all[WORDS_MAX] = {demo->matrig};
    size_t count = 1 + program_options(all + 1, demo->cli);
    for (size_t i = 0; words[i]; i++)
        all[count++] = words[i];
    fflush(NULL);
    return process_start(all, (const int[]){-1, said ? fileno(said) : -1, -1}, child, error);
}

/* How it ended; `name` is what a user would call it. */
static enum mr_status judge(const char *name, int status, struct error *error)
{
    if (stopped)
        return error_set(error, MR_IO,
                         "interrupted: matrig demo; what was logged stays; name a new folder to "
                         "start once more");
    if (WIFSIGNALED(status))
        return error_set(error, MR_IO, "%s was ended by signal %d: matrig demo; try again", name,
                         WTERMSIG(status));
    if (WEXITSTATUS(status) != 0)
        return error_set(error, MR_IO,
                         "%s ended with exit code %d: matrig demo; its own message stands above",
                         name, WEXITSTATUS(status));
    return MR_OK;
}

static enum mr_status wait_for(const char *name, pid_t child, double limit_s, struct error *error)
{
    double until_s = steady_s() + limit_s;
    int status = 0;
    while (!process_ended(child, &status)) {
        if (stopped || steady_s() > until_s) {
            process_stop(child, ENDING_S);
            return stopped ? judge(name, 0, error)
                           : error_set(error, MR_TIMEOUT,
                                       "%s did not end within %.0f s: matrig demo; is this "
                                       "computer overloaded?",
                                       name, limit_s);
        }
        nanosleep(&(struct timespec){.tv_nsec = POLL_NS}, NULL);
    }
    return judge(name, status, error);
}

/* With --json: where a program's answer goes, and the answer. */
static FILE *listen_to(const struct demo *demo)
{
    return demo->cli->json ? tmpfile() : NULL;
}

static json_t *answer_of(FILE *said)
{
    json_t *answer = NULL;
    if (said) {
        rewind(said);
        answer = json_loadf(said, 0, NULL);
        fclose(said);
    }
    return answer ? answer : json_null();
}

/* Runs matrig with these words; `*answer` is the caller's. */
static enum mr_status run_matrig(const struct demo *demo, const char *name,
                                 const char *const words[], double *took_s, json_t **answer,
                                 struct error *error)
{
    pid_t child;
    FILE *said = listen_to(demo);
    double begun_s = steady_s();
    enum mr_status status = start_matrig(demo, words, said, &child, error);
    if (status == MR_OK)
        status = wait_for(name, child, PROGRAM_S, error);
    *took_s = steady_s() - begun_s;
    *answer = answer_of(said);
    return status;
}

/* ---- the landings ---- */

/* What the board told: with --quiet only when something went wrong. */
static void pass_on(FILE *told, bool wanted)
{
    char line[400];
    if (!told)
        return;
    rewind(told);
    while (wanted && fgets(line, sizeof line, told))
        fputs(line, stderr);
    fclose(told);
}

/* The board plays, matrig log collects, at the same time. */
static enum mr_status play(struct demo *demo, size_t i, json_t **answer, struct error *error)
{
    char run[PATH_MAX + 30];
    pid_t board = -1;
    snprintf(run, sizeof run, "%s/landing%d.run", demo->runs, landings[i]);
    if (access(run, R_OK) != 0)
        return error_set(error, MR_IO,
                         "no recorded landing (%s): %s; make install puts it there, the package "
                         "matrig has it",
                         strerror(errno), run);
    const char *const board_words[] = {demo->board.program,
                                       "--elf",
                                       demo->board.elf,
                                       "--can",
                                       demo->can,
                                       "--serial",
                                       demo->serial,
                                       "--rig",
                                       run,
                                       "--speed",
                                       "max",
                                       NULL};
    const char *const log_words[] = {"log",        "--can", demo->can, "--serial",
                                     demo->serial, "--db",  demo->db,  NULL};
    FILE *told = demo->cli->quiet ? tmpfile() : NULL;
    if (process_start(board_words, (const int[]){-1, -1, told ? fileno(told) : -1}, &board,
                      error) == MR_OK &&
        run_matrig(demo, "matrig log", log_words, &demo->log_s[i], answer, error) == MR_OK)
        wait_for("matrig-board", board, ENDING_S, error);
    else if (board > 0)
        process_stop(board, ENDING_S);
    pass_on(told, error->status != MR_OK);
    return error->status;
}

static void say(const struct demo *demo, const char *format, int number)
{
    if (!demo->cli->json)
        printf(format, number);
}

static enum mr_status show_landing(struct demo *demo, size_t i, struct error *error)
{
    char run[12];
    json_t *logged = json_null(), *compared = json_null();
    snprintf(run, sizeof run, "%zu", i + 1);
    const char *const words[] = {"compare", demo->db, run, NULL};
    say(demo, "== Landing %d of the standard series (synthetic) on the emulated board\n",
        landings[i]);
    enum mr_status status = play(demo, i, &logged, error);
    if (status == MR_OK)
        status = run_matrig(demo, "matrig compare", words, &demo->compare_s[i], &compared, error);
    demo->told[i] = json_pack("{si,si,so,so,so,so}", "landing", landings[i], "run", (int)i + 1,
                              "log", logged, "compare", compared, "log_s",
                              cli_json_number(demo->log_s[i], 4), "compare_s",
                              cli_json_number(demo->compare_s[i], 4));
    return status;
}

static enum mr_status show_all(struct demo *demo, struct error *error)
{
    const char *const words[] = {"report", demo->db, "-o", demo->page, NULL};
    for (size_t i = 0; i < LANDINGS; i++) {
        if (show_landing(demo, i, error) != MR_OK)
            return error->status;
    }
    return run_matrig(demo, "matrig report", words, &demo->report_s, &demo->report, error);
}

/* ---- its folder ---- */

/* A campaign that is there is somebody's: it gets no landings of the demo. */
static enum mr_status make_folder(struct demo *demo, struct error *error)
{
    int db = snprintf(demo->db, sizeof demo->db, "%s/campaign.db", demo->folder);
    int page = snprintf(demo->page, sizeof demo->page, "%s/report.html", demo->folder);
    if (db >= (int)sizeof demo->db || page >= (int)sizeof demo->page)
        return error_set(error, MR_USAGE, "the path is too long: %s; name another folder",
                         demo->folder);
    if (mkdir(demo->folder, 0777) != 0 && errno != EEXIST)
        return error_set(error, MR_IO, "cannot make the folder (%s): %s; name another one",
                         strerror(errno), demo->folder);
    const char *there = access(demo->db, F_OK) == 0   ? demo->db
                      : access(demo->page, F_OK) == 0 ? demo->page
                                                      : NULL;
    if (there)
        return error_set(error, MR_USAGE, "there is one already: %s; name a new folder", there);
    return MR_OK;
}

static enum mr_status prepare(struct demo *demo, struct error *error)
{
    place_find(PLACE_BOARD, demo->program, sizeof demo->program);
    place_find(PLACE_FIRMWARE, demo->elf, sizeof demo->elf);
    place_find(PLACE_RUNS, demo->runs, sizeof demo->runs);
    place_program(demo->matrig, sizeof demo->matrig);
    if (!demo->board.program)
        demo->board.program = demo->program;
    if (!demo->board.elf)
        demo->board.elf = demo->elf;
    if (replay_board_check(&demo->board, error) != MR_OK || make_folder(demo, error) != MR_OK ||
        scratch_make(demo->sockets, "demo", error) != MR_OK)
        return error->status;
    snprintf(demo->can, sizeof demo->can, "unix:%s/can", demo->sockets);
    snprintf(demo->serial, sizeof demo->serial, "unix:%s/serial", demo->sockets);
    return MR_OK;
}

/* ---- what it comes to ---- */

static int show_json(struct demo *demo)
{
    json_t *list = json_array();
    for (size_t i = 0; i < LANDINGS; i++)
        json_array_append(list, demo->told[i]);
    return cli_print_json(json_pack("{ss,ss,ss,so,sO,so}", "folder", demo->folder, "campaign",
                                    demo->db, "page", demo->page, "landings", list, "report",
                                    demo->report, "report_s", cli_json_number(demo->report_s, 4)),
                          0);
}

static int show_text(const struct demo *demo)
{
    puts("== Run times");
    for (size_t i = 0; i < LANDINGS; i++)
        printf("play and log landing %-13d %7.2f s\ncompare landing %-18d %7.2f s\n", landings[i],
               demo->log_s[i], landings[i], demo->compare_s[i]);
    printf("%-34s %7.2f s\n", "report", demo->report_s);
    printf("Look at %s; the campaign is %s.\n", demo->page, demo->db);
    return 0;
}

static int demo_command(int argc, char **argv, const struct cli *cli)
{
    static const char *const sockets[] = {"can", "serial"};
    struct demo *demo = calloc(1, sizeof *demo);
    struct error error = {0};
    struct sigaction action = {.sa_handler = on_signal};
    int exit_code = 0;
    if (!demo)
        return error_set(&error, MR_FULL, "no memory: demo; close other programs"),
               cli_fail(&error);
    demo->cli = cli;
    if (command_parse(&command_demo, argc, argv, cli, demo, &demo->folder, &error) == MR_OK) {
        if (!demo->folder)
            demo->folder = FOLDER;
        sigaction(SIGINT, &action, NULL);
        sigaction(SIGTERM, &action, NULL);
        if (prepare(demo, &error) == MR_OK)
            show_all(demo, &error);
    }
    if (error.status != MR_OK)
        exit_code = cli_fail(&error);
    else
        exit_code = cli->json ? show_json(demo) : show_text(demo);
    scratch_remove(demo->sockets, sockets, sizeof sockets / sizeof sockets[0]);
    for (size_t i = 0; i < LANDINGS; i++)
        json_decref(demo->told[i]);
    json_decref(demo->report);
    free(demo);
    return exit_code;
}

#define VALUES struct demo
static const struct command_part parts[] = {
    HELP_ITEM("DIR", "folder for campaign.db and report.html, made when it does not exist; else "
                     "./" FOLDER ".\n"
                     "A campaign that is there is left alone, with exit code 2"),
    OPTION_TEXT("--elf", "F", board.elf, "firmware image; else the one that came with matrig"),
    OPTION_TEXT("--board", "F", board.program,
                "the emulated board; else matrig-board beside matrig"),
    HELP_NOTE("Landings 1, 4 and 5 of the standard series, which are synthetic. Each is played by "
              "matrig-board, logged over CAN and\n"
              "serial by matrig log, compared with the simulation by matrig compare; matrig report "
              "makes the page. Of landing 5\n"
              "the board warns. No hardware and no network are needed."),
    HELP_EXAMPLE("matrig demo first"),
};

const struct command command_demo = {
    "demo",
    demo_command,
    "[DIR] [--elf F] [--board F]",
    "three landings on the emulated board: played, logged, compared, reported",
    COMMAND_PARTS(parts),
    {0, 1, "DIR"},
};
