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
    struct hil_member *member = ctx;
    hil_link_put_frame(member->can, t_ps, frame);
}

static void on_serial_bytes(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct hil_member *member = ctx;
    (void)t_ps;
    hil_link_put_bytes(&member->serial, bytes, n);
}

static enum mr_status flush_links(struct hil_session *session, int stall_ms)
{
    char error[256];
    enum mr_status status = hil_link_flush(&session->can, stall_ms, &hil_stop_asked, error,
                                           sizeof error);
    for (unsigned i = 0; i < session->members && status == MR_OK; i++)
        status = hil_link_flush(&session->member[i].serial, stall_ms, &hil_stop_asked, error,
                                sizeof error);
    return status == MR_CLOSED ? MR_OK : hil_told(status, error);
}

/* At full speed the board waits for whoever opens the other end of its pty: next, but not before it
 * has had the time to start, or to restart after the last one. */
static bool host_is_there(struct hil_member *member, uint64_t t_ps)
{
    char error[256];
    if (member->serial.type != HIL_LINK_PTY)
        return true;
    if (!member->serial.hung_up)
        member->host_seen_ps = t_ps;
    if (t_ps < member->host_seen_ps + HOST_AWAY_PS)
        return true;
    enum mr_status status = hil_link_accept(&member->serial, CONNECT_MS, &hil_stop_asked, error,
                                            sizeof error);
    return hil_stop_asked ? status == MR_OK : hil_told(status, error) == MR_OK;
}

static bool hosts_are_there(struct hil_session *session, uint64_t t_ps)
{
    for (unsigned i = 0; i < session->members; i++) {
        if (!host_is_there(&session->member[i], t_ps))
            return false;
    }
    return true;
}

static uint64_t now_ps(const struct hil_session *session)
{
    return session->bus ? hil_canbus_now_ps(session->bus)
                        : hil_board_now_ps(session->member[0].board);
}

/* The firmware of none must hang. */
static enum mr_status look_for_hang(struct hil_member *member)
{
    char text[256];
    if (hil_debug_holds(member->board) ||
        !hil_hang_look(&member->hang, member->board, &member->symbols, text, sizeof text))
        return MR_OK;
    hil_complain("%sstopped at %.6f s: %s", member->name,
                 (double)hil_board_now_ps(member->board) * 1e-12, text);
    return MR_HALTED;
}

/* Run to t_ps or to where a debugger holds the board. */
static enum mr_status advance(struct hil_session *session, uint64_t t_ps)
{
    unsigned stopped = 0;
    enum mr_status status = session->bus ? hil_canbus_run_until(session->bus, t_ps, &stopped)
                                         : hil_board_run_until(session->member[0].board, t_ps);
    const struct hil_member *member = &session->member[stopped];
    if (status != MR_OK)
        hil_complain("%sstopped at %.6f s: %s", member->name,
                     (double)hil_board_now_ps(member->board) * 1e-12,
                     hil_board_reason(member->board));
    for (unsigned i = 0; i < session->members && status == MR_OK; i++)
        status = look_for_hang(&session->member[i]);
    return status;
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
    } while (status == MR_OK && !hil_stop_asked && now_ps(session) < t_ps);
    return status;
}

/* What hosts have sent. A frame from the link of the bus is given to any of its boards. */
static void receive(struct hil_session *session)
{
    hil_link_receive(&session->can, session->member[0].board);
    for (unsigned i = 0; i < session->members; i++)
        hil_link_receive(&session->member[i].serial, session->member[i].board);
}

enum mr_status hil_session_play(struct hil_session *session, double duration_s)
{
    bool real = session->real;
    uint64_t end_ps = (uint64_t)(duration_s * 1e12 + 0.5);
    uint64_t slice_ps = real ? SLICE_REAL_PS : SLICE_MAX_PS;
    enum mr_status status = MR_OK;
    session->pace.began_s = hil_wall_s();
    session->can.drops = real;
    for (unsigned i = 0; i < session->members; i++)
        session->member[i].serial.drops = real;
    for (uint64_t t_ps = 0; t_ps < end_ps && !hil_stop_asked && status == MR_OK;) {
        if (!real && !hosts_are_there(session, t_ps)) {
            status = hil_stop_asked ? MR_OK : MR_TIMEOUT;
            break;
        }
        t_ps = t_ps + slice_ps < end_ps ? t_ps + slice_ps : end_ps;
        if (real)
            hil_pace_wait(&session->pace, t_ps, &hil_stop_asked);
        receive(session);
        status = play_to(session, t_ps);
        if (real)
            hil_pace_done(&session->pace, t_ps);
    }
    /* What waits at the end is given its time at either speed. */
    enum mr_status flushed = flush_links(session, session->stall_ms);
    if (status == MR_OK && hil_stop_asked == HIL_WALL_STOP) {
        hil_complain("the limit of wall-clock time ended the run at %.3f s of virtual time; give "
                     "more with --wall-limit S",
                     (double)now_ps(session) * 1e-12);
        status = MR_TIMEOUT;
    }
    return status == MR_OK ? flushed : status;
}

static void summarise_board(const struct hil_session *session, const struct hil_member *member,
                            double took_s)
{
    const struct hil_counters *c = hil_board_counters(member->board);
    double virtual_s = (double)hil_board_now_ps(member->board) * 1e-12;
    /* of the link that all share, the first board tells */
    uint64_t can_dropped = member == session->member ? session->can.dropped : 0;
    char pace[96] = "";
    if (session->real)
        snprintf(pace, sizeof pace, ", at most %.1f ms late, %.1f after the first second",
                 1e3 * session->pace.late_s, 1e3 * session->pace.late_started_s);
    fprintf(
        stderr,
        "matrig-board: %s%.3f s virtual in %.3f s wall (%.1f x%s), %llu instructions, CAN %llu out "
        "%llu in, "
        "serial %llu bytes out %llu in, dropped %llu frames %llu bytes, resets %llu, faults %llu\n",
        member->name, virtual_s, took_s, took_s > 0 ? virtual_s / took_s : 0.0, pace,
        (unsigned long long)c->instructions, (unsigned long long)c->can_frames_out,
        (unsigned long long)c->can_frames_in, (unsigned long long)c->serial_bytes_out,
        (unsigned long long)c->serial_bytes_in,
        (unsigned long long)(can_dropped + c->can_in_dropped),
        (unsigned long long)(member->serial.dropped + c->serial_in_dropped),
        (unsigned long long)c->resets, (unsigned long long)c->faults);
}

static void summarise_bus(const struct hil_canbus *bus)
{
    const struct hil_canbus_counts *c = hil_canbus_counts(bus);
    uint64_t whole_ps = hil_canbus_now_ps(bus);
    fprintf(stderr, "matrig-board: CAN bus: %llu frames, load %.1f %%, bad %llu\n",
            (unsigned long long)c->frames,
            whole_ps ? 100.0 * (double)c->busy_ps / (double)whole_ps : 0.0,
            (unsigned long long)c->bad);
    if (c->collisions)
        hil_complain("CAN bus: %llu times two boards sent the same identifier at the same time, "
                     "with other data; give each its own identifiers",
                     (unsigned long long)c->collisions);
}

void hil_session_summarise(const struct hil_session *session, double took_s)
{
    for (unsigned i = 0; i < session->members; i++)
        summarise_board(session, &session->member[i], took_s);
    if (session->bus)
        summarise_bus(session->bus);
}

/* Nobody has to be at a link that is no socket; one who opens a terminal may come and go. */
static enum mr_status accept_hosts(struct hil_session *session, char *error, size_t size)
{
    enum mr_status status = hil_link_accept(&session->can, CONNECT_MS, &hil_stop_asked, error,
                                            size);
    for (unsigned i = 0; i < session->members && status == MR_OK; i++) {
        if (session->member[i].serial.type != HIL_LINK_PTY)
            status = hil_link_accept(&session->member[i].serial, CONNECT_MS, &hil_stop_asked, error,
                                     size);
    }
    if (status == MR_OK)
        status = hil_gdb_accept(&session->gdb, session->member[0].board, CONNECT_MS,
                                &hil_stop_asked, error, size);
    return status;
}

enum mr_status hil_session_open(struct hil_session *session)
{
    const struct hil_arguments *a = session->member[0].a;
    char error[512];
    enum mr_status status = hil_link_open(&session->can, HIL_LINK_CAN, a->can, error, sizeof error);
    for (unsigned i = 0; i < session->members; i++) {
        struct hil_member *member = &session->member[i];
        struct hil_callbacks callbacks = {member, on_can_frame, on_serial_bytes};
        member->can = &session->can;
        hil_board_set_callbacks(member->board, &callbacks);
        if (status == MR_OK)
            status = hil_link_open(&member->serial, HIL_LINK_SERIAL, member->a->serial, error,
                                   sizeof error);
    }
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
    for (unsigned i = 0; i < session->members; i++) {
        struct hil_member *member = &session->member[i];
        hil_link_close(&member->serial);
        hil_symbols_free(&member->symbols);
        hil_board_destroy(member->board);
        hil_run_free(&member->rig);
        hil_replay_free(&member->replay);
    }
    hil_canbus_destroy(session->bus);
}
