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
#include "hil/board/cellfile.h"
#include "hil/board/which.h"
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

static void tell_rules(const struct hil_member *member)
{
    uint64_t times;
    unsigned broken = hil_board_rules_counted(member->board, &times);
    if (broken)
        hil_complain("%s%u %s broken, %llu %s in all%s", member->name, broken,
                     broken == 1 ? "rule" : "rules", (unsigned long long)times,
                     times == 1 ? "time" : "times",
                     member->a->margins ? "" : "; --margins FILE says which");
}

static double length_of(const struct hil_member *member)
{
    const struct hil_arguments *a = member->a;
    return a->rig    ? member->rig.duration_s
         : a->replay ? hil_replay_duration_s(&member->replay)
                     : 0.0;
}

/* As long as the longest that is played. */
static double duration_of(const struct hil_session *session)
{
    double longest_s = session->member[0].a->for_s;
    for (unsigned i = 0; i < session->members && !(session->member[0].a->for_s > 0); i++) {
        double length_s = length_of(&session->member[i]);
        longest_s = length_s > longest_s ? length_s : longest_s;
    }
    return longest_s > 0 ? longest_s : HIL_FOREVER_S;
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

/* What a fault of one board's links would do to the others is not modelled for all of them. */
static enum mr_status fits_shared_bus(const char *path, const struct hil_fault_script *script)
{
    for (size_t i = 0; i < script->count; i++) {
        const struct hil_fault *fault = &script->fault[i];
        bool holds = fault->action == HIL_FAULT_BUS &&
                     (fault->choice == HIL_CAN_SHORTED || fault->choice == HIL_CAN_DOMINANT);
        bool host = fault->action == HIL_FAULT_LINE && fault->line == HIL_CAN_IN &&
                    fault->choice != HIL_CORRUPT;
        if (!holds && !host)
            continue;
        hil_complain("%s: line %u: with --and a bus can be unplugged, and CAN frames in can be "
                     "corrupted, nothing else; leave the line out, or run the board alone",
                     path, fault->file_line);
        return MR_USAGE;
    }
    return MR_OK;
}

static enum mr_status order_faults(const struct hil_member *member, bool shared)
{
    static struct hil_fault_script script;
    const struct hil_arguments *a = member->a;
    char error[512];
    enum mr_status status = hil_faults_read(a->faults, a->elf, &script, error, sizeof error);
    if (hil_told(status, error) != MR_OK)
        return status;
    if (shared && (status = fits_shared_bus(a->faults, &script)) != MR_OK)
        return status;
    status = hil_board_add_faults(member->board, &script);
    if (status != MR_OK)
        hil_complain("%s: %s", a->faults, hil_board_reason(member->board));
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
    struct hil_board *board = session->member[0].board;
    char error[512];
    enum mr_status status = open_record("--profile", a->profile, &session->profile);
    if (status == MR_OK)
        status = open_record("--margins", a->margins, &session->margins);
    if (status != MR_OK)
        return status;
    if (a->profile)
        hil_profile_begin(board);
    return a->vcd ? hil_told(hil_vcd_open(board, a->vcd, a->vcd_functions,
                                          &session->member[0].symbols, error, sizeof error),
                             error)
                  : MR_OK;
}

static enum mr_status close_records(struct hil_session *session, const struct hil_arguments *a)
{
    struct hil_board *board = session->member[0].board;
    char error[512];
    enum mr_status status = hil_told(hil_vcd_close(board, error, sizeof error), error), closed;
    if (session->margins) {
        hil_board_print_rules(board, session->margins);
        closed = close_record("--margins", a->margins, session->margins, false);
        status = status == MR_OK ? closed : status;
    }
    if (session->profile) {
        bool failed = hil_profile_print(board, &session->member[0].symbols, session->profile) !=
                      MR_OK;
        closed = close_record("--profile", a->profile, session->profile, failed);
        status = status == MR_OK ? closed : status;
    }
    return status;
}

/* A board with its memories, its rig and its faults, as it is before power comes. */
static enum mr_status prepare(struct hil_session *session, struct hil_member *member)
{
    const struct hil_arguments *a = member->a;
    struct hil_board *board = member->board;
    char error[512];
    enum mr_status status = hil_told(load_memories(board, a), hil_board_reason(board));
    if (status == MR_OK && a->elf)
        status = hil_told(hil_symbols_read(&member->symbols, a->elf, error, sizeof error), error);
    if (status != MR_OK)
        return status;
    hil_board_attach_rig(board, a->rig ? &member->rig : NULL);
    if (a->replay)
        hil_board_attach_replay(board, &member->replay);
    if (session->bus && (status = hil_canbus_join(session->bus, board)) != MR_OK)
        hil_complain("%sits chip has the identity of one before it: no two chips have the same; "
                     "give another --board-seed, or another record",
                     member->name);
    if (status == MR_OK && a->faults)
        status = order_faults(member, session->bus != NULL);
    hil_hang_start(&member->hang, a->hang_s);
    return status;
}

static enum mr_status run(struct hil_session *session)
{
    const struct hil_arguments *a = session->member[0].a;
    enum mr_status status = MR_OK, saved;
    for (unsigned i = 0; i < session->members && status == MR_OK; i++)
        status = prepare(session, &session->member[i]);
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
    for (unsigned i = 0; i < session->members; i++) {
        hil_board_tell_faults_left(session->member[i].board);
        tell_rules(&session->member[i]);
    }
    hil_session_summarise(session, took_s);
    if (status == MR_OK)
        status = closed;
    for (unsigned i = 0; i < session->members; i++) {
        saved = save_memories(session->member[i].board, session->member[i].a, status);
        status = status == MR_OK ? saved : status;
    }
    return status;
}

/* The files that say what is played, and which board it is. */
static enum mr_status read_files(struct hil_member *member, struct hil_arguments *a)
{
    char error[512];
    enum mr_status status = MR_OK;
    if (a->rig)
        status = hil_told(hil_run_read(a->rig, &member->rig, error, sizeof error), error);
    else if (a->replay)
        status = hil_told(hil_replay_read(a->replay, &member->replay, error, sizeof error), error);
    return status;
}

static enum mr_status make_board(struct hil_member *member, struct hil_arguments *a)
{
    char error[512];
    if (!a->board_given &&
        hil_told(hil_which_files(a->elf, a->flash, &a->options.type, error, sizeof error), error) !=
            MR_OK)
        return MR_VERSION;
    enum mr_status status = hil_arguments_check_board(a);
    if (status == MR_OK)
        member->board = hil_board_create(&a->options);
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
    static struct hil_arguments a[HIL_CANBUS_BOARDS];
    static struct hil_session session = {.can = {.listener = -1, .fd = -1},
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
    enum mr_status status = hil_arguments_parse(a, &session.members, argc, argv);
    if (status == MR_OK)
        status = hil_arguments_check_paths(a, session.members);
    for (unsigned i = 0; i < session.members; i++) {
        struct hil_member *member = &session.member[i];
        member->a = &a[i];
        member->serial.listener = member->serial.fd = -1;
        if (session.members > 1)
            snprintf(member->name, sizeof member->name, "board %u: ", i + 1);
        a[i].options.name = member->name;
        if (status == MR_OK)
            status = read_files(member, &a[i]);
    }
    if (status != MR_OK)
        return mr_status_exit_code(status);
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    for (unsigned i = 0; i < session.members; i++) {
        status = make_board(&session.member[i], &a[i]);
        if (status != MR_OK)
            return mr_status_exit_code(status);
    }
    if (session.members > 1)
        session.bus = hil_canbus_create();
    status = run(&session);
    hil_session_close(&session, status);
    return mr_status_exit_code(status);
}
