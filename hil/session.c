#include "hil/session.h"

#include <string.h>

#define CONNECT_MS    30000
#define SLICE_MAX_PS  (5ull * HIL_MS_PS) /* between looks at the sockets, at full speed */
#define SLICE_REAL_PS (1ull * HIL_MS_PS) /* and at the wall clock */
#define HOST_AWAY_PS  (50ull * HIL_MS_PS)

volatile int hil_stop_asked;

enum mr_status hil_told(enum mr_status status, const char *why)
{
    if (status != MR_OK)
        hil_complain("%s", why);
    return status;
}

static void on_can_frame(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct hil_session *session = ctx;
    hil_link_put_frame(&session->can, t_ps, frame);
}

static void on_serial_bytes(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct hil_session *session = ctx;
    (void)t_ps;
    hil_link_put_bytes(&session->serial, bytes, n);
}

static enum mr_status flush_links(struct hil_session *session, int stall_ms)
{
    char error[256];
    enum mr_status status = hil_link_flush(&session->can, stall_ms, &hil_stop_asked, error,
                                           sizeof error);
    if (status == MR_OK)
        status = hil_link_flush(&session->serial, stall_ms, &hil_stop_asked, error, sizeof error);
    return status == MR_CLOSED ? MR_OK : hil_told(status, error);
}

/* At full speed the board waits for whoever opens the other end of its pty: next, but not before it
 * has had the time to start, or to restart after the last one. */
static bool host_is_there(struct hil_session *session, uint64_t t_ps)
{
    char error[256];
    if (session->serial.type != HIL_LINK_PTY)
        return true;
    if (!session->serial.hung_up)
        session->host_seen_ps = t_ps;
    if (t_ps < session->host_seen_ps + HOST_AWAY_PS)
        return true;
    enum mr_status status = hil_link_accept(&session->serial, CONNECT_MS, &hil_stop_asked, error,
                                            sizeof error);
    return hil_stop_asked ? status == MR_OK : hil_told(status, error) == MR_OK;
}

static enum mr_status look_for_hang(struct hil_session *session)
{
    char text[256];
    if (hil_debug_holds(session->board) ||
        !hil_hang_look(&session->hang, session->board, &session->symbols, text, sizeof text))
        return MR_OK;
    hil_complain("stopped at %.6f s: %s", (double)hil_board_now_ps(session->board) * 1e-12, text);
    return MR_HALTED;
}

/* Run to t_ps or to where a debugger holds the board. */
static enum mr_status advance(struct hil_session *session, uint64_t t_ps)
{
    enum mr_status status = hil_board_run_until(session->board, t_ps);
    if (status != MR_OK)
        hil_complain("stopped at %.6f s: %s", (double)hil_board_now_ps(session->board) * 1e-12,
                     hil_board_reason(session->board));
    return status == MR_OK ? look_for_hang(session) : status;
}

static enum mr_status play_to(struct hil_session *session, uint64_t t_ps)
{
    enum mr_status status;
    bool alive;
    do {
        status = advance(session, t_ps);
        enum mr_status flushed = flush_links(session, session->real ? 0 : session->stall_ms);
        if (status == MR_OK)
            status = flushed;
        double held_s = hil_wall_s();
        alive = hil_gdb_serve(&session->gdb, status, &hil_stop_asked);
        /* time stood still on both clocks; without gdb 1000 times nothing are 80 ppm */
        if (session->gdb.listener >= 0)
            session->pace.began_s += hil_wall_s() - held_s;
        if (!alive)
            hil_stop_asked = 1;
    } while (status == MR_OK && !hil_stop_asked && hil_board_now_ps(session->board) < t_ps);
    return status;
}

enum mr_status hil_session_play(struct hil_session *session, double duration_s)
{
    bool real = session->real;
    uint64_t end_ps = (uint64_t)(duration_s * 1e12 + 0.5);
    uint64_t slice_ps = real ? SLICE_REAL_PS : SLICE_MAX_PS;
    enum mr_status status = MR_OK;
    session->pace.began_s = hil_wall_s();
    session->can.drops = session->serial.drops = real;
    for (uint64_t t_ps = 0; t_ps < end_ps && !hil_stop_asked && status == MR_OK;) {
        if (!real && !host_is_there(session, t_ps)) {
            status = hil_stop_asked ? MR_OK : MR_TIMEOUT;
            break;
        }
        t_ps = t_ps + slice_ps < end_ps ? t_ps + slice_ps : end_ps;
        if (real)
            hil_pace_wait(&session->pace, t_ps, &hil_stop_asked);
        hil_link_receive(&session->can, session->board);
        hil_link_receive(&session->serial, session->board);
        status = play_to(session, t_ps);
        if (real)
            hil_pace_done(&session->pace, t_ps);
    }
    /* What waits at the end is given its time at either speed. */
    enum mr_status flushed = flush_links(session, session->stall_ms);
    if (status == MR_OK && hil_stop_asked == HIL_WALL_STOP) {
        hil_complain("the limit of wall-clock time ended the run at %.3f s of virtual time; give "
                     "more with --wall-limit S",
                     (double)hil_board_now_ps(session->board) * 1e-12);
        status = MR_TIMEOUT;
    }
    return status == MR_OK ? flushed : status;
}

void hil_session_summarise(const struct hil_session *session, double took_s)
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
static enum mr_status accept_hosts(struct hil_session *session, char *error, size_t size)
{
    enum mr_status status = hil_link_accept(&session->can, CONNECT_MS, &hil_stop_asked, error,
                                            size);
    if (status == MR_OK && session->serial.type != HIL_LINK_PTY)
        status = hil_link_accept(&session->serial, CONNECT_MS, &hil_stop_asked, error, size);
    if (status == MR_OK)
        status = hil_gdb_accept(&session->gdb, session->board, CONNECT_MS, &hil_stop_asked, error,
                                size);
    return status;
}

enum mr_status hil_session_open(struct hil_session *session)
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
    if (hil_stop_asked == HIL_WALL_STOP)
        hil_complain("the limit of wall-clock time came while links were opened; is there a host? "
                     "--wall-limit S gives more");
    else if (!hil_stop_asked)
        hil_told(status, error);
    return status;
}

void hil_session_close(struct hil_session *session, enum mr_status status)
{
    hil_gdb_close(&session->gdb, mr_status_exit_code(status));
    hil_link_close(&session->can);
    hil_link_close(&session->serial);
    hil_symbols_free(&session->symbols);
    hil_board_destroy(session->board);
    hil_run_free(&session->rig);
    hil_replay_free(&session->replay);
}
