/* matrig-board: the emulated board as a program. See --help. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/version.h"
#include "hil/arguments.h"
#include "hil/board/board.h"
#include "hil/core/registers.h"
#include "hil/core/wall.h"
#include "hil/debug/profile.h"
#include "hil/debug/vcd.h"
#include "hil/rig/faults.h"
#include "hil/session.h"
#include "hil/symbols.h"

#define WALL_LIMIT_S 600.0 /* of a run that has an end, beyond its length */

static void on_signal(int number)
{
    (void)number;
    hil_stop_asked = 1;
}

static void tell_rules(const struct hil_session *session)
{
    uint64_t times;
    unsigned broken = hil_board_rules_counted(session->board, &times);
    if (broken)
        hil_complain("%u %s broken, %llu %s in all%s", broken, broken == 1 ? "rule" : "rules",
                     (unsigned long long)times, times == 1 ? "time" : "times",
                     session->a->margins ? "" : "; --margins FILE says which");
}

static double duration_of(const struct hil_session *session)
{
    const struct hil_arguments *a = session->a;
    double length_s = a->for_s > 0 ? a->for_s
                    : a->rig       ? session->rig.duration_s
                    : a->replay    ? hil_replay_duration_s(&session->replay)
                                   : 0.0;
    return length_s > 0 ? length_s : HIL_FOREVER_S;
}

static enum mr_status load_memories(struct hil_board *board, const struct hil_arguments *a)
{
    enum mr_status status = MR_OK;
    if (a->flash)
        status = hil_board_load_flash(board, a->flash);
    /* what was in the file need not start, nor be for this board */
    if (a->elf && (status == MR_OK || status == MR_HALTED || status == MR_VERSION))
        status = a->flash ? hil_board_load_elf_sparing(board, a->elf)
                          : hil_board_load_elf(board, a->elf);
    if (a->nor && status == MR_OK)
        status = hil_board_load_nor(board, a->nor);
    return status;
}

/* However the run ended. */
static enum mr_status save_memories(struct hil_board *board, const struct hil_arguments *a,
                                    enum mr_status status)
{
    enum mr_status saved = MR_OK;
    if (a->flash)
        saved = hil_board_save_flash(board, a->flash);
    if (a->nor && saved == MR_OK)
        saved = hil_board_save_nor(board, a->nor);
    hil_told(saved, hil_board_reason(board));
    return status == MR_OK ? saved : status;
}

static enum mr_status order_faults(const struct hil_session *session)
{
    static struct hil_fault_script script;
    const struct hil_arguments *a = session->a;
    char error[512];
    enum mr_status status = hil_faults_read(a->faults, a->elf, &script, error, sizeof error);
    if (hil_told(status, error) != MR_OK)
        return status;
    status = hil_board_add_faults(session->board, &script);
    if (status != MR_OK)
        hil_complain("%s: %s", a->faults, hil_board_reason(session->board));
    return status;
}

/* A run that has an end gets a generous limit, so that it ends whatever happens. */
static void start_wall_limit(const struct hil_arguments *a, double duration_s)
{
    double limit_s = a->wall_limit_s;
    if (limit_s < 0)
        limit_s = duration_s < HIL_FOREVER_S && !a->gdb
                    ? WALL_LIMIT_S + (a->real ? duration_s : 0.0)
                    : 0.0;
    hil_wall_limit(limit_s, &hil_stop_asked);
}

static enum mr_status open_record(const char *option, const char *path, FILE **file)
{
    if (!path || (*file = fopen(path, "w")))
        return MR_OK;
    hil_complain("%s: cannot write %s: %s; give another file", option, path, strerror(errno));
    return MR_IO;
}

static enum mr_status close_record(const char *option, const char *path, FILE *file, bool failed)
{
    failed |= fclose(file) != 0;
    if (!failed)
        return MR_OK;
    hil_complain("%s: cannot write all of %s: %s; make room or give another file", option, path,
                 strerror(errno));
    return MR_IO;
}

static enum mr_status open_records(struct hil_session *session, const struct hil_arguments *a)
{
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = open_record("--profile", a->profile, &session->profile);
    if (status == MR_OK)
        status = open_record("--margins", a->margins, &session->margins);
    if (status != MR_OK)
        return status;
    if (a->profile)
        hil_profile_begin(board);
    return a->vcd ? hil_told(hil_vcd_open(board, a->vcd, a->vcd_functions, &session->symbols, error,
                                          sizeof error),
                             error)
                  : MR_OK;
}

static enum mr_status close_records(struct hil_session *session, const struct hil_arguments *a)
{
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = hil_told(hil_vcd_close(board, error, sizeof error), error), closed;
    if (session->margins) {
        hil_board_print_rules(board, session->margins);
        closed = close_record("--margins", a->margins, session->margins, false);
        status = status == MR_OK ? closed : status;
    }
    if (session->profile) {
        bool failed = hil_profile_print(board, &session->symbols, session->profile) != MR_OK;
        closed = close_record("--profile", a->profile, session->profile, failed);
        status = status == MR_OK ? closed : status;
    }
    return status;
}

/* A board with its memories, its rig and its faults, as it is before power comes. */
static enum mr_status prepare(struct hil_session *session)
{
    const struct hil_arguments *a = session->a;
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = hil_told(load_memories(board, a), hil_board_reason(board));
    if (status == MR_OK && a->elf)
        status = hil_told(hil_symbols_read(&session->symbols, a->elf, error, sizeof error), error);
    if (status != MR_OK)
        return status;
    hil_board_attach_rig(board, a->rig ? &session->rig : NULL);
    if (a->replay)
        hil_board_attach_replay(board, &session->replay);
    if (a->faults)
        status = order_faults(session);
    hil_hang_start(&session->hang, a->hang_s);
    return status;
}

static enum mr_status run(struct hil_session *session)
{
    const struct hil_arguments *a = session->a;
    enum mr_status status = prepare(session);
    if (status != MR_OK)
        return status;
    session->real = a->real;
    session->stall_ms = (int)(a->stall_s * 1e3);
    double duration_s = duration_of(session);
    start_wall_limit(a, duration_s);
    status = hil_session_open(session);
    if (status != MR_OK)
        return hil_stop_asked == 1 ? MR_OK : status;
    status = open_records(session, a);
    if (status != MR_OK)
        return status;
    double began_s = hil_wall_s();
    status = hil_session_play(session, duration_s);
    double took_s = hil_wall_s() - began_s;
    enum mr_status closed = close_records(session, a);
    hil_board_tell_faults_left(session->board);
    tell_rules(session);
    hil_session_summarise(session, took_s);
    if (status == MR_OK)
        status = closed;
    enum mr_status saved = save_memories(session->board, a, status);
    return status == MR_OK ? saved : status;
}

/* The files that say what is played, and which board it is. */
static enum mr_status read_files(struct hil_session *session, struct hil_arguments *a)
{
    char error[512];
    enum mr_status status = MR_OK;
    if (a->rig)
        status = hil_told(hil_run_read(a->rig, &session->rig, error, sizeof error), error);
    else if (a->replay)
        status = hil_told(hil_replay_read(a->replay, &session->replay, error, sizeof error), error);
    return status;
}

static enum mr_status make_board(struct hil_session *session, struct hil_arguments *a)
{
    char error[512];
    if (!a->board_given &&
        hil_told(hil_which_files(a->elf, a->flash, &a->options.type, error, sizeof error), error) !=
            MR_OK)
        return MR_VERSION;
    enum mr_status status = hil_arguments_check_board(a);
    if (status == MR_OK)
        session->board = hil_board_create(&a->options);
    return status;
}

/* A stream that the caller closed must not become the number of an output file: what is said would
 * go there. */
static void hold_standard_streams(void)
{
    for (int fd = 0; fd < 3; fd++) {
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0)
            exit(3);
    }
}

int main(int argc, char **argv)
{
    static struct hil_arguments a;
    static struct hil_session session = {.a = &a,
                                         .can = {.listener = -1, .fd = -1},
                                         .serial = {.listener = -1, .fd = -1},
                                         .gdb = {.listener = -1, .line = {.fd = -1}}};
    hold_standard_streams();
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            fputs(hil_help, stdout);
            return 0;
        }
        if (strcmp(argv[i], "--version") == 0) {
            puts("matrig-board " VERSION_TEXT);
            return 0;
        }
        if (strcmp(argv[i], "--not-modelled") == 0) {
            hil_registers_print(stdout);
            return 0;
        }
    }
    enum mr_status status = hil_arguments_parse(&a, argc, argv);
    if (status == MR_OK)
        status = hil_arguments_check_paths(&a);
    if (status == MR_OK)
        status = read_files(&session, &a);
    if (status != MR_OK)
        return mr_status_exit_code(status);
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    status = make_board(&session, &a);
    if (status != MR_OK)
        return mr_status_exit_code(status);
    status = run(&session);
    hil_session_close(&session, status);
    return mr_status_exit_code(status);
}
