/* matrig-board: the emulated board as a program. See --help. */
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "hil/board.h"
#include "hil/cellfile.h"
#include "hil/faults.h"
#include "hil/registers.h"
#include "hil/replay.h"
#include "hil/wire_link.h"

#define CONNECT_MS 30000
#define STALL_MS 30000
#define SLICE_MAX_PS (5ull * HIL_MS_PS)  /* between looks at the sockets, at full speed */
#define SLICE_REAL_PS (1ull * HIL_MS_PS) /* and at the wall clock */
#define HOST_AWAY_PS (50ull * HIL_MS_PS)
#define FOREVER_S 100000.0

static const char help[] =
    "usage: matrig-board --elf F [--can LINK] [--serial LINK] [--rig RUNFILE] [options]\n"
    "       matrig-board --flash F | --boot0 [options]\n"
    "The STM32F407 board in virtual time, running the firmware image F unmodified.\n"
    "  --elf F          firmware image (ELF)\n"
    "  --can LINK       unix:PATH (16-byte frames), file:PATH (candump -L text) or none\n"
    "  --serial LINK    unix:PATH (bytes), file:PATH, pty:PATH (a terminal that any program opens) or none\n"
    "  --parity P       of the serial line's other end: none, even, odd or board (what the board has);\n"
    "                   default none, pty: board, for Linux keeps no parity for pseudo-terminals\n"
    "  --rig RUNFILE    what the rig does: a matrig-run file; without it nothing moves\n"
    "  --replay FILE    instead of a rig, a recorded landing: a matrig-replay file, which matrig replay writes\n"
    "  --speed max|real at full speed, waiting for a slow host (default); by the wall clock, dropping\n"
    "  --for S          seconds of virtual time (default: the run file's duration, or until a signal)\n"
    "  --seed N         of converter noise (default 1)\n"
    "  --hse HZ         crystal, 0: it does not start (default 8000000)\n"
    "  --hsi-ppm N      error of the internal oscillator (default 0)\n"
    "  --lsi HZ         watchdog clock, 17000 to 47000 (default 32000)\n"
    "  --flash FILE     content of the flash: read if it is there, written at the end; --elf then goes over it,\n"
    "                   sparing the sectors it does not use\n"
    "  --nor FILE       the same for the black box's memory\n"
    "  --boot0          start the boot ROM (AN3155 on the serial line) instead of the firmware\n"
    "  --times T        of flash and NOR operations: spread (drawn, default), typical or max\n"
    "  --faults FILE    what goes wrong and when: a matrig-faults file (hil/README.md); told on stderr\n"
    "  --alignment      fault on unaligned multiple and double transfers, as silicon does; slower\n"
    "  --not-modelled   print what of the chip is not modelled, and end\n"
    "  --trace          tell exceptions and unusual events on stderr\n"
    "A unix: link is listened on; virtual time starts when a host has connected to each, within 30 s. At full\n"
    "speed it stands still when nobody has had the pty: open for 50 ms, for at most 30 s.\n"
    "Exit: 0 ok, 2 usage, 3 link, board or firmware failed, 4 malformed or truncated input.\n";

struct arguments {
    const char *elf, *can, *serial, *rig, *replay, *flash, *nor, *faults;
    bool parity_given;
    bool real;
    double for_s; /* 0: not given */
    struct hil_options options;
};

struct session {
    struct hil_link can, serial;
    struct hil_board *board;
    uint64_t host_seen_ps; /* when the pty: was last in use */
};

static volatile int stop_asked;

static void on_signal(int number)
{
    (void)number;
    stop_asked = 1;
}

__attribute__((format(printf, 1, 2))) static void complain(const char *format, ...)
{
    va_list arguments;
    fputs("matrig-board: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static bool parse_number(const char *text, double low, double high, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && !*end && *value >= low && *value <= high;
}

/* Which of the words is it? -1: none. */
static int parse_word(const char *text, const char *const words[], int n)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(text, words[i]) == 0)
            return i;
    }
    return -1;
}

static bool parse_parity(struct arguments *a, const char *text)
{
    static const char *const words[] = {"none", "even", "odd", "board"};
    int word = parse_word(text, words, 4);
    a->parity_given = true;
    a->options.host_parity_follows = word == 3;
    a->options.host_parity = word > 0 && word < 3 ? (enum hil_parity)word : HIL_PARITY_NONE;
    return word >= 0;
}

static bool parse_times(struct arguments *a, const char *text)
{
    static const char *const words[] = {"spread", "typical", "max"};
    int word = parse_word(text, words, 3);
    a->options.cell_times = word > 0 ? (enum hil_cell_times)word : HIL_TIMES_SPREAD;
    return word >= 0;
}

static enum mr_status parse_option(struct arguments *a, const char *name, const char *text)
{
    double value = 0.0;
    bool ok = true;
    if (strcmp(name, "--elf") == 0) {
        a->elf = text;
    } else if (strcmp(name, "--can") == 0) {
        a->can = text;
    } else if (strcmp(name, "--serial") == 0) {
        a->serial = text;
    } else if (strcmp(name, "--rig") == 0) {
        a->rig = text;
    } else if (strcmp(name, "--replay") == 0) {
        a->replay = text;
    } else if (strcmp(name, "--flash") == 0) {
        a->flash = text;
    } else if (strcmp(name, "--nor") == 0) {
        a->nor = text;
    } else if (strcmp(name, "--parity") == 0) {
        ok = parse_parity(a, text);
    } else if (strcmp(name, "--times") == 0) {
        ok = parse_times(a, text);
    } else if (strcmp(name, "--faults") == 0) {
        a->faults = text;
    } else if (strcmp(name, "--speed") == 0) {
        a->real = strcmp(text, "real") == 0;
        ok = a->real || strcmp(text, "max") == 0;
    } else if (strcmp(name, "--for") == 0) {
        ok = parse_number(text, 1e-6, FOREVER_S, &a->for_s);
    } else if (strcmp(name, "--seed") == 0) {
        char *end;
        errno = 0;
        a->options.seed = strtoull(text, &end, 10);
        ok = end != text && !*end && !errno && text[0] != '-';
    } else if (strcmp(name, "--hse") == 0) {
        ok = parse_number(text, 0, 26e6, &value) && (value >= 4e6 || value < 1);
        a->options.hse_hz = (uint32_t)value;
    } else if (strcmp(name, "--hsi-ppm") == 0) {
        ok = parse_number(text, -50000, 50000, &value);
        a->options.hsi_error_ppm = (int32_t)value;
    } else if (strcmp(name, "--lsi") == 0) {
        ok = parse_number(text, 17000, 47000, &value);
        a->options.lsi_hz = (uint32_t)value;
    } else {
        complain("unknown option %s; see matrig-board --help", name);
        return MR_USAGE;
    }
    if (!ok)
        complain("%s cannot be `%s`; see matrig-board --help", name, text);
    return ok ? MR_OK : MR_USAGE;
}

static enum mr_status parse_arguments(struct arguments *a, int argc, char **argv)
{
    *a = (struct arguments){.can = "none", .serial = "none"};
    hil_options_default(&a->options);
    a->options.log = stderr;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--alignment") == 0) {
            a->options.watch_alignment = true;
            continue;
        }
        if (strcmp(argv[i], "--trace") == 0) {
            a->options.trace = stderr;
            continue;
        }
        if (strcmp(argv[i], "--boot0") == 0) {
            a->options.boot0 = true;
            continue;
        }
        if (strncmp(argv[i], "--", 2) != 0) {
            complain("what is `%s`? Everything is given by options; see matrig-board --help", argv[i]);
            return MR_USAGE;
        }
        if (i + 1 == argc) {
            complain("%s needs a value, or is no option; see matrig-board --help", argv[i]);
            return MR_USAGE;
        }
        enum mr_status status = parse_option(a, argv[i], argv[i + 1]);
        if (status != MR_OK)
            return status;
        i++;
    }
    if (!a->elf && !a->flash && !a->options.boot0) {
        complain("which firmware? Give --elf FILE; see matrig-board --help");
        return MR_USAGE;
    }
    if (a->rig && a->replay) {
        complain("--rig and --replay cannot be given together: the pins are either a rig's or a record's");
        return MR_USAGE;
    }
    if (!a->parity_given)
        a->options.host_parity_follows = strncmp(a->serial, "pty:", 4) == 0;
    return MR_OK;
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

static double wall_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void sleep_until(double t_s)
{
    struct timespec t = {.tv_sec = (time_t)t_s};
    t.tv_nsec = (long)((t_s - (double)t.tv_sec) * 1e9);
    while (!stop_asked && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR)
        continue;
}

static enum mr_status flush_links(struct session *session, int stall_ms)
{
    char error[256];
    enum mr_status status = hil_link_flush(&session->can, stall_ms, &stop_asked, error, sizeof error);
    if (status == MR_OK)
        status = hil_link_flush(&session->serial, stall_ms, &stop_asked, error, sizeof error);
    if (status != MR_OK && status != MR_CLOSED)
        complain("%s", error);
    return status == MR_CLOSED ? MR_OK : status;
}

/* At full speed the board waits for whoever opens the other end of its pty: next, but not before it has had the time to
 * start, or to restart after the last one. */
static bool host_is_there(struct session *session, uint64_t t_ps)
{
    char error[256];
    if (session->serial.type != HIL_LINK_PTY)
        return true;
    if (!session->serial.hung_up)
        session->host_seen_ps = t_ps;
    if (t_ps < session->host_seen_ps + HOST_AWAY_PS)
        return true;
    enum mr_status status = hil_link_accept(&session->serial, CONNECT_MS, &stop_asked, error, sizeof error);
    if (status != MR_OK && !stop_asked)
        complain("%s", error);
    return status == MR_OK;
}

static enum mr_status play(struct session *session, double duration_s, bool real)
{
    uint64_t end_ps = (uint64_t)(duration_s * 1e12 + 0.5);
    uint64_t slice_ps = real ? SLICE_REAL_PS : SLICE_MAX_PS;
    double began_s = wall_s();
    enum mr_status status = MR_OK;
    session->can.drops = session->serial.drops = real;
    for (uint64_t t_ps = 0; t_ps < end_ps && !stop_asked && status == MR_OK;) {
        if (!real && !host_is_there(session, t_ps)) {
            status = stop_asked ? MR_OK : MR_TIMEOUT;
            break;
        }
        hil_link_receive(&session->can, session->board);
        hil_link_receive(&session->serial, session->board);
        t_ps = t_ps + slice_ps < end_ps ? t_ps + slice_ps : end_ps;
        status = hil_board_run_until(session->board, t_ps);
        if (status != MR_OK)
            complain("stopped at %.6f s: %s", (double)hil_board_now_ps(session->board) * 1e-12,
                     hil_board_reason(session->board));
        enum mr_status flushed = flush_links(session, real ? 0 : STALL_MS);
        if (status == MR_OK)
            status = flushed;
        if (real)
            sleep_until(began_s + (double)t_ps * 1e-12);
    }
    /* What waits at the end is given its time at either speed. */
    enum mr_status flushed = flush_links(session, STALL_MS);
    return status == MR_OK ? flushed : status;
}

static void summarise(const struct session *session, double took_s)
{
    const struct hil_counters *c = hil_board_counters(session->board);
    double virtual_s = (double)hil_board_now_ps(session->board) * 1e-12;
    fprintf(stderr,
            "matrig-board: %.3f s virtual in %.3f s wall (%.1f x), %llu instructions, CAN %llu out %llu in, "
            "serial %llu bytes out %llu in, dropped %llu frames %llu bytes, resets %llu, faults %llu\n",
            virtual_s, took_s, took_s > 0 ? virtual_s / took_s : 0.0, (unsigned long long)c->instructions,
            (unsigned long long)c->can_frames_out, (unsigned long long)c->can_frames_in,
            (unsigned long long)c->serial_bytes_out, (unsigned long long)c->serial_bytes_in,
            (unsigned long long)(session->can.dropped + c->can_in_dropped),
            (unsigned long long)(session->serial.dropped + c->serial_in_dropped),
                (unsigned long long)c->resets,
            (unsigned long long)c->faults);
}

static enum mr_status open_links(struct session *session, const struct arguments *a)
{
    char error[512];
    enum mr_status status = hil_link_open(&session->can, HIL_LINK_CAN, a->can, error, sizeof error);
    if (status == MR_OK)
        status = hil_link_open(&session->serial, HIL_LINK_SERIAL, a->serial, error, sizeof error);
    if (status == MR_OK)
        status = hil_link_accept(&session->can, CONNECT_MS, &stop_asked, error, sizeof error);
    if (status == MR_OK && session->serial.type != HIL_LINK_PTY) /* one who opens a terminal may come and go */
        status = hil_link_accept(&session->serial, CONNECT_MS, &stop_asked, error, sizeof error);
    if (status != MR_OK && !stop_asked)
        complain("%s", error);
    return status;
}

static double duration_of(const struct arguments *a, const struct hil_run *rig, const struct hil_replay *replay)
{
    return a->for_s > 0 ? a->for_s : a->rig ? rig->duration_s : a->replay ? hil_replay_duration_s(replay) : FOREVER_S;
}

static enum mr_status load_memories(struct hil_board *board, const struct arguments *a)
{
    enum mr_status status = MR_OK;
    if (a->flash)
        status = hil_board_load_flash(board, a->flash);
    if (a->elf && (status == MR_OK || status == MR_HALTED)) /* what was in the file need not start */
        status = a->flash ? hil_board_load_elf_sparing(board, a->elf) : hil_board_load_elf(board, a->elf);
    if (a->nor && status == MR_OK)
        status = hil_board_load_nor(board, a->nor);
    return status;
}

/* However the run ended. */
static enum mr_status save_memories(struct hil_board *board, const struct arguments *a, enum mr_status status)
{
    enum mr_status saved = MR_OK;
    if (a->flash)
        saved = hil_board_save_flash(board, a->flash);
    if (a->nor && saved == MR_OK)
        saved = hil_board_save_nor(board, a->nor);
    if (saved != MR_OK)
        complain("%s", hil_board_reason(board));
    return status == MR_OK ? saved : status;
}

static enum mr_status order_faults(const struct arguments *a, struct hil_board *board)
{
    static struct hil_fault_script script;
    char error[512];
    enum mr_status status = hil_faults_read(a->faults, a->elf, &script, error, sizeof error);
    if (status != MR_OK) {
        complain("%s", error);
        return status;
    }
    status = hil_board_add_faults(board, &script);
    if (status != MR_OK)
        complain("%s: %s", a->faults, hil_board_reason(board));
    return status;
}

static enum mr_status run(const struct arguments *a, struct session *session, const struct hil_run *rig,
                          const struct hil_replay *replay)
{
    struct hil_callbacks callbacks = {session, on_can_frame, on_serial_bytes};
    enum mr_status status = load_memories(session->board, a);
    if (status != MR_OK) {
        complain("%s", hil_board_reason(session->board));
        return status;
    }
    hil_board_set_callbacks(session->board, &callbacks);
    hil_board_attach_rig(session->board, a->rig ? rig : NULL);
    if (a->replay)
        hil_board_attach_replay(session->board, replay);
    if (a->faults) {
        status = order_faults(a, session->board);
        if (status != MR_OK)
            return status;
    }
    status = open_links(session, a);
    if (status != MR_OK)
        return stop_asked ? MR_OK : status;
    double began_s = wall_s();
    status = play(session, duration_of(a, rig, replay), a->real);
    summarise(session, wall_s() - began_s);
    return save_memories(session->board, a, status);
}

int main(int argc, char **argv)
{
    struct arguments a;
    struct session session = {.can = {.listener = -1, .fd = -1}, .serial = {.listener = -1, .fd = -1}};
    struct hil_run rig = {0};
    struct hil_replay replay = {0};
    char error[512];
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            fputs(help, stdout);
            return 0;
        }
        if (strcmp(argv[i], "--not-modelled") == 0) {
            hil_registers_print(stdout);
            return 0;
        }
    }
    enum mr_status status = parse_arguments(&a, argc, argv);
    if (status != MR_OK)
        return mr_status_exit_code(status);
    if (a.rig)
        status = hil_run_read(a.rig, &rig, error, sizeof error);
    else if (a.replay)
        status = hil_replay_read(a.replay, &replay, error, sizeof error);
    if (status != MR_OK) {
        complain("%s", error);
        return mr_status_exit_code(status);
    }
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    session.board = hil_board_create(&a.options);
    status = run(&a, &session, &rig, &replay);
    hil_link_close(&session.can);
    hil_link_close(&session.serial);
    hil_board_destroy(session.board);
    hil_run_free(&rig);
    hil_replay_free(&replay);
    return mr_status_exit_code(status);
}
