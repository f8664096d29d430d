/* matrig-board: the emulated board as a program, and a run of it: its board, its links, and how
 * time goes on for it. See --help. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/symbols.h"
#include "common/version.h"
#include "hil/arguments.h"
#include "hil/board/board.h"
#include "hil/core/wall.h"
#include "hil/debug/debug.h"
#include "hil/debug/gdb.h"
#include "hil/debug/profile.h"
#include "hil/debug/vcd.h"
#include "hil/link/wire_link.h"
#include "hil/rig/faults.h"
#include "hil/rig/replay.h"
#include "hil/rig/runfile.h"
#include "hil/core/elf.h"

#define WALL_LIMIT_S  600.0 /* of a run that has an end, beyond its length */
#define CONNECT_MS    30000
#define SLICE_MAX_PS  (5ull * HIL_MS_PS) /* between looks at the sockets, at full speed */
#define SLICE_REAL_PS (1ull * HIL_MS_PS) /* and at the wall clock */
#define HOST_AWAY_PS  (50ull * HIL_MS_PS)

struct session {
    const struct hil_arguments *a;
    struct hil_board *board;
    struct hil_link can, serial;
    uint64_t host_seen_ps; /* when the pty: was last in use */
    struct mr_symbols symbols;
    struct hil_run rig;
    struct hil_replay replay;
    struct hil_pace pace;
    struct hil_gdb gdb;
    FILE *profile, *margins;
    int stall_ms;
    bool real;
};

/* 1: by a signal, HIL_WALL_STOP: the wall-clock limit. */
static volatile int stop_asked;

/* Says why, if there is something to say. */
static enum mr_status told(enum mr_status status, const char *why)
{
    if (status != MR_OK)
        hil_complain("%s", why);
    return status;
}

static void on_can_frame(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct session *session = ctx;
    hil_link_put_frame(&session->can, t_ps, frame);
}

static void on_serial_bytes(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct session *session = ctx;
    (void)t_ps;
    hil_link_put_bytes(&session->serial, bytes, n);
}

static enum mr_status flush_links(struct session *session, int stall_ms)
{
    char error[256];
    enum mr_status status = hil_link_flush(&session->can, stall_ms, &stop_asked, error,
                                           sizeof error);
    if (status == MR_OK)
        status = hil_link_flush(&session->serial, stall_ms, &stop_asked, error, sizeof error);
    return status == MR_CLOSED ? MR_OK : told(status, error);
}

/* At full speed the board waits for whoever opens the other end of its pty: next, but not before it
 * has had the time to start, or to restart after the last one. */
static bool host_is_there(struct session *session, uint64_t t_ps)
{
    char error[256];
    if (session->serial.type != HIL_LINK_PTY)
        return true;
    if (!session->serial.hung_up)
        session->host_seen_ps = t_ps;
    if (t_ps < session->host_seen_ps + HOST_AWAY_PS)
        return true;
    enum mr_status status = hil_link_accept(&session->serial, CONNECT_MS, &stop_asked, error,
                                            sizeof error);
    return stop_asked ? status == MR_OK : told(status, error) == MR_OK;
}

/* Run to t_ps or to where a debugger holds the board. */
static enum mr_status advance(struct session *session, uint64_t t_ps)
{
    enum mr_status status = hil_board_run_until(session->board, t_ps);
    if (status != MR_OK)
        hil_complain("stopped at %.6f s: %s", (double)hil_board_now_ps(session->board) * 1e-12,
                     hil_board_reason(session->board));
    return status;
}

static enum mr_status play_to(struct session *session, uint64_t t_ps)
{
    enum mr_status status;
    bool alive;
    do {
        status = advance(session, t_ps);
        enum mr_status flushed = flush_links(session, session->real ? 0 : session->stall_ms);
        if (status == MR_OK)
            status = flushed;
        double held_s = hil_wall_s();
        alive = hil_gdb_serve(&session->gdb, status, &stop_asked);
        /* time stood still on both clocks; without gdb 1000 times nothing are 80 ppm */
        if (session->gdb.listener >= 0)
            session->pace.began_s += hil_wall_s() - held_s;
        if (!alive)
            stop_asked = 1;
    } while (status == MR_OK && !stop_asked && hil_board_now_ps(session->board) < t_ps);
    return status;
}

static enum mr_status session_play(struct session *session, double duration_s)
{
    bool real = session->real;
    uint64_t end_ps = (uint64_t)(duration_s * 1e12 + 0.5);
    uint64_t slice_ps = real ? SLICE_REAL_PS : SLICE_MAX_PS;
    enum mr_status status = MR_OK;
    session->pace.began_s = hil_wall_s();
    session->can.drops = session->serial.drops = real;
    for (uint64_t t_ps = 0; t_ps < end_ps && !stop_asked && status == MR_OK;) {
        if (!real && !host_is_there(session, t_ps)) {
            status = stop_asked ? MR_OK : MR_TIMEOUT;
            break;
        }
        t_ps = t_ps + slice_ps < end_ps ? t_ps + slice_ps : end_ps;
        if (real)
            hil_pace_wait(&session->pace, t_ps, &stop_asked);
        hil_link_receive(&session->can, session->board);
        hil_link_receive(&session->serial, session->board);
        status = play_to(session, t_ps);
        if (real)
            hil_pace_done(&session->pace, t_ps);
    }
    /* What waits at the end is given its time at either speed. */
    enum mr_status flushed = flush_links(session, session->stall_ms);
    if (status == MR_OK && stop_asked == HIL_WALL_STOP) {
        hil_complain("the limit of wall-clock time ended the run at %.3f s of virtual time; give "
                     "more with --wall-limit S",
                     (double)hil_board_now_ps(session->board) * 1e-12);
        status = MR_TIMEOUT;
    }
    return status == MR_OK ? flushed : status;
}

/* What the run was, in a line on stderr. */
static void session_summarise(const struct session *session, double took_s)
{
    const struct hil_counters *c = hil_board_counters(session->board);
    double virtual_s = (double)hil_board_now_ps(session->board) * 1e-12;
    char pace[96] = "";
    if (session->real)
        snprintf(pace, sizeof pace, ", at most %.1f ms late, %.1f after the first second",
                 1e3 * session->pace.late_s, 1e3 * session->pace.late_started_s);
    fprintf(
        stderr,
        "matrig-board: %.3f s virtual in %.3f s wall (%.1f x%s), %llu instructions, CAN %llu out "
        "%llu in, "
        "serial %llu bytes out %llu in, dropped %llu frames %llu bytes, resets %llu, faults %llu\n",
        virtual_s, took_s, took_s > 0 ? virtual_s / took_s : 0.0, pace,
        (unsigned long long)c->instructions, (unsigned long long)c->can_frames_out,
        (unsigned long long)c->can_frames_in, (unsigned long long)c->serial_bytes_out,
        (unsigned long long)c->serial_bytes_in,
        (unsigned long long)(session->can.dropped + c->can_in_dropped),
        (unsigned long long)(session->serial.dropped + c->serial_in_dropped),
        (unsigned long long)c->resets, (unsigned long long)c->faults);
}

/* Nobody has to be at a link that is no socket; one who opens a terminal may come and go. */
static enum mr_status accept_hosts(struct session *session, char *error, size_t size)
{
    enum mr_status status = hil_link_accept(&session->can, CONNECT_MS, &stop_asked, error, size);
    if (status == MR_OK && session->serial.type != HIL_LINK_PTY)
        status = hil_link_accept(&session->serial, CONNECT_MS, &stop_asked, error, size);
    if (status == MR_OK)
        status = hil_gdb_accept(&session->gdb, session->board, CONNECT_MS, &stop_asked, error,
                                size);
    return status;
}

/* Open the links and wait for their hosts; MR_CLOSED: it was to stop meanwhile. */
static enum mr_status session_open(struct session *session)
{
    const struct hil_arguments *a = session->a;
    char error[512];
    enum mr_status status = hil_link_open(&session->can, HIL_LINK_CAN, a->can, error, sizeof error);
    struct hil_callbacks callbacks = {session, on_can_frame, on_serial_bytes};
    hil_board_set_callbacks(session->board, &callbacks);
    if (status == MR_OK)
        status = hil_link_open(&session->serial, HIL_LINK_SERIAL, a->serial, error, sizeof error);
    if (status == MR_OK && a->gdb) {
        status = hil_gdb_open(&session->gdb, a->gdb, error, sizeof error);
        if (status == MR_OK)
            fprintf(stderr, "matrig-board: waiting for gdb: target remote %s\n",
                    session->gdb.place);
    }
    if (status == MR_OK)
        status = accept_hosts(session, error, sizeof error);
    if (stop_asked == HIL_WALL_STOP)
        hil_complain("the limit of wall-clock time came while links were opened; is there a host? "
                     "--wall-limit S gives more");
    else if (!stop_asked)
        told(status, error);
    return status;
}

static void session_close(struct session *session, enum mr_status status)
{
    hil_gdb_close(&session->gdb, mr_status_exit_code(status));
    hil_link_close(&session->can);
    hil_link_close(&session->serial);
    hil_symbols_free(&session->symbols);
    hil_board_destroy(session->board);
    hil_run_free(&session->rig);
    hil_replay_free(&session->replay);
}

static void on_signal(int number)
{
    (void)number;
    stop_asked = 1;
}

static void tell_rules(const struct session *session)
{
    uint64_t times;
    unsigned broken = hil_board_rules_counted(session->board, &times);
    if (broken)
        hil_complain("%u %s broken, %llu %s in all%s", broken, broken == 1 ? "rule" : "rules",
                     (unsigned long long)times, times == 1 ? "time" : "times",
                     session->a->margins ? "" : "; --margins FILE says which");
}

static double duration_of(const struct session *session)
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
    told(saved, hil_board_reason(board));
    return status == MR_OK ? saved : status;
}

static enum mr_status order_faults(const struct session *session)
{
    static struct hil_fault_script script;
    const struct hil_arguments *a = session->a;
    char error[512];
    enum mr_status status = hil_faults_read(a->faults, a->elf, &script, error, sizeof error);
    if (told(status, error) != MR_OK)
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
                    ? WALL_LIMIT_S + (a->speed ? duration_s : 0.0)
                    : 0.0;
    hil_wall_limit(limit_s, &stop_asked);
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

static enum mr_status open_records(struct session *session, const struct hil_arguments *a)
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
    return a->vcd ? told(hil_vcd_open(board, a->vcd, &session->symbols, error, sizeof error), error)
                  : MR_OK;
}

static enum mr_status close_records(struct session *session, const struct hil_arguments *a)
{
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = told(hil_vcd_close(board, error, sizeof error), error), closed;
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
static enum mr_status prepare(struct session *session)
{
    const struct hil_arguments *a = session->a;
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = told(load_memories(board, a), hil_board_reason(board));
    if (status == MR_OK && a->elf)
        status = told(hil_symbols_read(&session->symbols, a->elf, error, sizeof error), error);
    if (status != MR_OK)
        return status;
    hil_board_attach_rig(board, a->rig ? &session->rig : NULL);
    if (a->replay)
        hil_board_attach_replay(board, &session->replay);
    if (a->faults)
        status = order_faults(session);
    return status;
}

static enum mr_status run(struct session *session)
{
    const struct hil_arguments *a = session->a;
    enum mr_status status = prepare(session);
    if (status != MR_OK)
        return status;
    session->real = a->speed != 0;
    session->stall_ms = (int)(a->stall_s * 1e3);
    double duration_s = duration_of(session);
    start_wall_limit(a, duration_s);
    status = session_open(session);
    if (status != MR_OK)
        return stop_asked == 1 ? MR_OK : status;
    status = open_records(session, a);
    if (status != MR_OK)
        return status;
    double began_s = hil_wall_s();
    status = session_play(session, duration_s);
    double took_s = hil_wall_s() - began_s;
    enum mr_status closed = close_records(session, a);
    hil_board_tell_faults_left(session->board);
    tell_rules(session);
    session_summarise(session, took_s);
    if (status == MR_OK)
        status = closed;
    enum mr_status saved = save_memories(session->board, a, status);
    return status == MR_OK ? saved : status;
}

/* The files that say what is played, and which board it is. */
static enum mr_status read_files(struct session *session, struct hil_arguments *a)
{
    char error[512];
    enum mr_status status = MR_OK;
    if (a->rig)
        status = told(hil_run_read(a->rig, &session->rig, error, sizeof error), error);
    else if (a->replay)
        status = told(hil_replay_read(a->replay, &session->replay, error, sizeof error), error);
    return status;
}

static enum mr_status make_board(struct session *session, struct hil_arguments *a)
{
    char error[512];
    if (!a->board_given &&
        told(hil_which_files(a->elf, a->flash, &a->options.type, error, sizeof error), error) !=
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
    static struct session session = {.a = &a,
                                     .can = {.listener = -1, .fd = -1},
                                     .serial = {.listener = -1, .fd = -1},
                                     .gdb = {.listener = -1, .line = {.fd = -1}}};
    hold_standard_streams();
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            hil_arguments_help();
            return 0;
        }
        if (strcmp(argv[i], "--version") == 0) {
            puts("matrig-board " VERSION_TEXT);
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
    session_close(&session, status);
    return mr_status_exit_code(status);
}
