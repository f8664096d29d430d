/* matrig-board: the emulated board as a program. See --help. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hil/board/board.h"
#include "hil/board/cellfile.h"
#include "hil/rig/faults.h"
#include "hil/debug/gdb.h"
#include "hil/debug/hang.h"
#include "hil/debug/profile.h"
#include "hil/core/registers.h"
#include "hil/rig/replay.h"
#include "hil/symbols.h"
#include "hil/debug/vcd.h"
#include "hil/core/wall.h"
#include "hil/link/wire_link.h"

#define CONNECT_MS 30000
#define STALL_S 30.0
#define HANG_S 5.0
#define WALL_LIMIT_S 600.0               /* of a run that has an end, beyond its length */
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
    "  --baud N         rate of the serial line's other end (default 2000000; pty: what is set there)\n"
    "  --rig RUNFILE    what the rig does: a matrig-run file; without it nothing moves\n"
    "  --replay FILE    instead of a rig, a recorded landing: a matrig-replay file, which matrig replay writes\n"
    "  --speed max|real at full speed, waiting for a slow host (default); by the wall clock, dropping\n"
    "  --camera HZ[,DELAY_MS[,JITTER_US]]  a film camera: triggered by PE2, after DELAY_MS (default 0) it gives a pulse\n"
    "                   a frame on PB3\n"
    "  --for S          seconds of virtual time (default: the run file's duration, or until a signal)\n"
    "  --seed N         of converter noise (default 1)\n"
    "  --hse HZ         crystal, 0: it does not start (default 8000000)\n"
    "  --hsi-ppm N      error of the internal oscillator (default 0)\n"
    "  --lsi HZ         watchdog clock, 17000 to 47000 (default 32000)\n"
    "  --flash FILE     content of the flash: read if it is there, written at the end; --elf then goes over it,\n"
    "                   sparing the sectors it does not use\n"
    "  --nor FILE       the same for the black box's memory\n"
    "  --temperature C[,C/h]  of the mat, in degrees and how fast it rises, or none: no thermometer (default 20)\n"
    "  --boot0          start the boot ROM (AN3155 on the serial line) instead of the firmware\n"
    "  --times T        of flash and NOR operations: spread (drawn, default), typical or max\n"
    "  --faults FILE    what goes wrong and when: a matrig-faults file (hil/README.md); told on stderr\n"
    "  --alignment      fault on unaligned multiple and double transfers, as silicon does; slower\n"
    "  --not-modelled   print what of the chip is not modelled, and end\n"
    "  --trace          tell exceptions and unusual events on stderr\n"
    "  --gdb PORT       listen for gdb on this port of 127.0.0.1 (0: any; it is told) or at unix:PATH, and wait for it\n"
    "  --vcd FILE       trace of pins, converters, links, exceptions, sleep and functions, for GTKWave and others\n"
    "  --vcd-functions A,B,...  functions to trace (default: the main ones)\n"
    "  --profile FILE   instructions by function, level and kind\n"
    "  --hang S         end when the firmware hangs for S seconds of virtual time (default 5, 0: never)\n"
    "  --stall S        end when a host does not read for S seconds (default 30)\n"
    "  --wall-limit S   end after S seconds of wall clock (default 600 more than the run's own length; none\n"
    "                   for a run without end or with --gdb)\n"
    "A unix: link is listened on; virtual time starts when a host has connected to each, and gdb, within 30 s. At\n"
    "full speed it stands still when nobody has had the pty: open for 50 ms, for at most 30 s.\n"
    "Exit: 0 ok, 2 usage, 3 link, board or firmware failed, 4 malformed or truncated input.\n";

struct arguments {
    const char *elf, *can, *serial, *rig, *replay, *flash, *nor, *faults, *gdb, *vcd, *vcd_functions, *profile;
    bool parity_given;
    bool real;
    double for_s; /* 0: not given */
    double hang_s, stall_s, wall_limit_s; /* wall_limit_s 0: none; negative: not given */
    struct hil_options options;
};

struct session {
    struct hil_link can, serial;
    struct hil_board *board;
    uint64_t host_seen_ps; /* when the pty: was last in use */
    struct hil_symbols symbols;
    struct hil_hang hang;
    struct hil_pace pace;
    struct hil_gdb gdb;
    FILE *profile;
    int stall_ms;
    bool real;
};

static volatile int stop_asked; /* 1: by a signal, HIL_WALL_STOP: the wall-clock limit */

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

/* Degrees, and degrees per hour behind a comma. */
static bool parse_temperature(struct arguments *a, const char *text)
{
    char *end;
    a->options.temperature_c = (double)NAN;
    a->options.temperature_c_per_h = 0.0;
    if (strcmp(text, "none") == 0)
        return true;
    a->options.temperature_c = strtod(text, &end);
    if (end == text || !(a->options.temperature_c >= -60.0 && a->options.temperature_c <= 150.0))
        return false;
    return !*end || (*end == ',' && parse_number(end + 1, -1000, 1000, &a->options.temperature_c_per_h));
}

/* HZ[,DELAY_MS[,JITTER_US]] */
static bool parse_camera(struct hil_options *options, const char *text)
{
    double value[3] = {0.0, 0.0, 0.0};
    const double most[3] = {1e5, 1e6, 1e6};
    for (unsigned i = 0; i < 3; i++) {
        char *end;
        value[i] = strtod(text, &end);
        if (end == text || (*end && *end != ',') || !(value[i] >= (i ? 0.0 : 0.01) && value[i] <= most[i]))
            return false;
        text = end + 1;
        if (*end)
            continue;
        options->camera_hz = value[0];
        options->camera_delay_ps = (uint64_t)(value[1] * (double)HIL_MS_PS);
        options->camera_jitter_ps = (uint64_t)(value[2] * (double)HIL_US_PS);
        return true;
    }
    return false;
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
    } else if (strcmp(name, "--temperature") == 0) {
        ok = parse_temperature(a, text);
    } else if (strcmp(name, "--baud") == 0) {
        ok = parse_number(text, 1200, 10e6, &value);
        a->options.host_baud = (uint32_t)value;
    } else if (strcmp(name, "--times") == 0) {
        ok = parse_times(a, text);
    } else if (strcmp(name, "--faults") == 0) {
        a->faults = text;
    } else if (strcmp(name, "--speed") == 0) {
        a->real = strcmp(text, "real") == 0;
        ok = a->real || strcmp(text, "max") == 0;
    } else if (strcmp(name, "--camera") == 0) {
        ok = parse_camera(&a->options, text);
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
    } else if (strcmp(name, "--gdb") == 0) {
        a->gdb = text;
    } else if (strcmp(name, "--vcd") == 0) {
        a->vcd = text;
    } else if (strcmp(name, "--vcd-functions") == 0) {
        a->vcd_functions = text;
    } else if (strcmp(name, "--profile") == 0) {
        a->profile = text;
    } else if (strcmp(name, "--hang") == 0) {
        ok = parse_number(text, 0, FOREVER_S, &a->hang_s);
    } else if (strcmp(name, "--stall") == 0) {
        ok = parse_number(text, 0.001, 86400, &a->stall_s);
    } else if (strcmp(name, "--wall-limit") == 0) {
        ok = parse_number(text, 0, 1e6, &a->wall_limit_s);
    } else {
        complain("unknown option %s; matrig-board --help lists them", name);
        return MR_USAGE;
    }
    if (!ok)
        complain("%s cannot be `%s`; see matrig-board --help", name, text);
    return ok ? MR_OK : MR_USAGE;
}

static bool takes_no_value(const char *name) { return strcmp(name, "--trace") == 0 || strcmp(name, "--boot0") == 0 ||
                                                     strcmp(name, "--alignment") == 0; }

/* The option at argv[i] is there a second time. */
static bool is_repeated(char **argv, int i)
{
    for (int k = 1; k < i; k += takes_no_value(argv[k]) ? 1 : 2) {
        if (strcmp(argv[k], argv[i]) == 0)
            return true;
    }
    return false;
}

static enum mr_status parse_arguments(struct arguments *a, int argc, char **argv)
{
    *a = (struct arguments){.can = "none", .serial = "none", .hang_s = HANG_S, .stall_s = STALL_S,
                            .wall_limit_s = -1.0};
    hil_options_default(&a->options);
    a->options.log = stderr;
    for (int i = 1; i < argc; i++) {
        if (is_repeated(argv, i)) {
            complain("%s is given twice; give it once", argv[i]);
            return MR_USAGE;
        }
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

/* Run to t_ps or to where a debugger holds the board; the firmware must not hang then. */
static enum mr_status advance(struct session *session, uint64_t t_ps)
{
    char text[256];
    enum mr_status status = hil_board_run_until(session->board, t_ps);
    double now_s = (double)hil_board_now_ps(session->board) * 1e-12;
    if (status != MR_OK) {
        complain("stopped at %.6f s: %s", now_s, hil_board_reason(session->board));
    } else if (!hil_debug_holds(session->board) && hil_hang_look(&session->hang, session->board, &session->symbols, text, sizeof text)) {
        complain("stopped at %.6f s: %s", now_s, text);
        status = MR_HALTED;
    }
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
        if (session->gdb.listener >= 0) /* time stood still on both clocks; without gdb 1000 times nothing are 80 ppm */
            session->pace.began_s += hil_wall_s() - held_s;
        if (!alive)
            stop_asked = 1;
    } while (status == MR_OK && !stop_asked && hil_board_now_ps(session->board) < t_ps);
    return status;
}

static enum mr_status play(struct session *session, double duration_s)
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
        complain("the limit of wall-clock time ended the run at %.3f s of virtual time; give more with --wall-limit S",
                 (double)hil_board_now_ps(session->board) * 1e-12);
        status = MR_TIMEOUT;
    }
    return status == MR_OK ? flushed : status;
}

static void summarise(const struct session *session, double took_s)
{
    const struct hil_counters *c = hil_board_counters(session->board);
    double virtual_s = (double)hil_board_now_ps(session->board) * 1e-12;
    char pace[96] = "";
    if (session->real)
        snprintf(pace, sizeof pace, ", at most %.1f ms late, %.1f after the first second", 1e3 * session->pace.late_s,
                 1e3 * session->pace.late_started_s);
    fprintf(stderr,
            "matrig-board: %.3f s virtual in %.3f s wall (%.1f x%s), %llu instructions, CAN %llu out %llu in, "
            "serial %llu bytes out %llu in, dropped %llu frames %llu bytes, resets %llu, faults %llu\n",
            virtual_s, took_s, took_s > 0 ? virtual_s / took_s : 0.0, pace,
            (unsigned long long)c->instructions,
            (unsigned long long)c->can_frames_out, (unsigned long long)c->can_frames_in,
            (unsigned long long)c->serial_bytes_out, (unsigned long long)c->serial_bytes_in,
            (unsigned long long)(session->can.dropped + c->can_in_dropped),
            (unsigned long long)(session->serial.dropped + c->serial_in_dropped),
            (unsigned long long)c->resets, (unsigned long long)c->faults);
}

/* The path of a link or file with everything that can be resolved resolved; false: it has none. */
static bool canonical(const char *text, char *out)
{
    char folder[PATH_MAX], resolved[PATH_MAX];
    const char *path = !text || strcmp(text, "none") == 0 ? NULL
                       : strncmp(text, "unix:", 5) == 0 || strncmp(text, "file:", 5) == 0 ? text + 5
                       : strncmp(text, "pty:", 4) == 0                                    ? text + 4
                                                                                          : text;
    if (!path || strlen(path) >= sizeof folder)
        return false;
    if (realpath(path, out))
        return true;
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    if (!realpath(folder, resolved))
        return false;
    return snprintf(out, PATH_MAX, "%s/%s", resolved, slash ? slash + 1 : path) < PATH_MAX;
}

/* By name, or as two names of one file. */
static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    return strcmp(a, b) == 0 || (stat(a, &one) == 0 && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
                                 one.st_ino == other.st_ino);
}

/* What is written must not be what is read or written elsewhere; devices may be. A record takes the place of no
 * campaign. */
static enum mr_status check_paths(const struct arguments *a)
{
    const struct {
        const char *option, *text;
    } given[] = {{"--elf", a->elf}, {"--rig", a->rig}, {"--replay", a->replay}, {"--faults", a->faults}, {"--can", a->can},
                 {"--serial", a->serial}, {"--gdb", a->gdb && strncmp(a->gdb, "unix:", 5) == 0 ? a->gdb : NULL},
                 {"--vcd", a->vcd}, {"--profile", a->profile}, {"--flash", a->flash}, {"--nor", a->nor}};
    enum { READ_ONLY = 4, GIVEN = sizeof given / sizeof given[0] };
    char path[GIVEN][PATH_MAX];
    for (unsigned i = 0; i < GIVEN; i++) {
        struct stat st;
        if (!canonical(given[i].text, path[i]) || (stat(path[i], &st) == 0 && S_ISCHR(st.st_mode)))
            path[i][0] = '\0';
        for (unsigned k = 0; i >= READ_ONLY && k < i; k++) {
            if (path[i][0] && path[k][0] && same_file(path[i], path[k])) {
                complain("%s and %s are both %s; give each its own", given[k].option, given[i].option, path[i]);
                return MR_USAGE;
            }
        }
        if ((given[i].text == a->vcd || given[i].text == a->profile) && path[i][0] && hil_is_precious(path[i])) {
            complain("%s would overwrite a database or a program: %s; give another file", given[i].option, path[i]);
            return MR_USAGE;
        }
    }
    return MR_OK;
}

static enum mr_status open_links(struct session *session, const struct arguments *a)
{
    char error[512];
    enum mr_status status = hil_link_open(&session->can, HIL_LINK_CAN, a->can, error, sizeof error);
    if (status == MR_OK)
        status = hil_link_open(&session->serial, HIL_LINK_SERIAL, a->serial, error, sizeof error);
    if (status == MR_OK && a->gdb) {
        status = hil_gdb_open(&session->gdb, a->gdb, error, sizeof error);
        if (status == MR_OK)
            fprintf(stderr, "matrig-board: waiting for gdb: target remote %s\n", session->gdb.place);
    }
    if (status == MR_OK)
        status = hil_link_accept(&session->can, CONNECT_MS, &stop_asked, error, sizeof error);
    if (status == MR_OK && session->serial.type != HIL_LINK_PTY) /* one who opens a terminal may come and go */
        status = hil_link_accept(&session->serial, CONNECT_MS, &stop_asked, error, sizeof error);
    if (status == MR_OK)
        status = hil_gdb_accept(&session->gdb, session->board, CONNECT_MS, &stop_asked, error, sizeof error);
    if (stop_asked == HIL_WALL_STOP)
        complain("the limit of wall-clock time came while links were opened; is there a host? --wall-limit S gives more");
    else if (status != MR_OK && !stop_asked)
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

/* A run that has an end gets a generous limit, so that it ends whatever happens. */
static void start_wall_limit(const struct arguments *a, double duration_s)
{
    double limit_s = a->wall_limit_s;
    if (limit_s < 0)
        limit_s = duration_s < FOREVER_S && !a->gdb ? WALL_LIMIT_S + (a->real ? duration_s : 0.0) : 0.0;
    hil_wall_limit(limit_s, &stop_asked);
}

static enum mr_status open_records(struct session *session, const struct arguments *a)
{
    char error[512];
    if (a->profile && !(session->profile = fopen(a->profile, "w"))) {
        complain("--profile: cannot write %s: %s; give another file", a->profile, strerror(errno));
        return MR_IO;
    }
    if (a->profile)
        hil_profile_begin(session->board);
    enum mr_status status = a->vcd ? hil_vcd_open(session->board, a->vcd, a->vcd_functions, &session->symbols, error,
                                                  sizeof error)
                                   : MR_OK;
    if (status != MR_OK)
        complain("%s", error);
    return status;
}

static enum mr_status close_records(struct session *session, const struct arguments *a)
{
    char error[512];
    enum mr_status status = hil_vcd_close(session->board, error, sizeof error);
    if (status != MR_OK)
        complain("%s", error);
    if (!session->profile)
        return status;
    bool failed = hil_profile_print(session->board, &session->symbols, session->profile) != MR_OK;
    failed |= fclose(session->profile) != 0;
    if (!failed)
        return status;
    complain("--profile: cannot write all of %s: %s; make room or give another file", a->profile, strerror(errno));
    return MR_IO;
}

static enum mr_status run(const struct arguments *a, struct session *session, const struct hil_run *rig,
                          const struct hil_replay *replay)
{
    struct hil_callbacks callbacks = {session, on_can_frame, on_serial_bytes};
    char error[512];
    enum mr_status status = load_memories(session->board, a);
    if (status != MR_OK) {
        complain("%s", hil_board_reason(session->board));
        return status;
    }
    if (a->elf)
        status = hil_symbols_read(&session->symbols, a->elf, error, sizeof error);
    if (status != MR_OK) {
        complain("%s", error);
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
    hil_hang_start(&session->hang, a->hang_s);
    session->real = a->real;
    session->stall_ms = (int)(a->stall_s * 1e3);
    double duration_s = duration_of(a, rig, replay);
    start_wall_limit(a, duration_s);
    status = open_links(session, a);
    if (status != MR_OK)
        return stop_asked == 1 ? MR_OK : status;
    status = open_records(session, a);
    if (status != MR_OK)
        return status;
    double began_s = hil_wall_s();
    status = play(session, duration_s);
    double took_s = hil_wall_s() - began_s;
    enum mr_status closed = close_records(session, a);
    hil_faults_tell_rest(session->board);
    summarise(session, took_s);
    if (status == MR_OK)
        status = closed;
    return save_memories(session->board, a, status);
}

/* A stream that the caller closed must not become the number of an output file: what is said would go there. */
static void hold_standard_streams(void)
{
    for (int fd = 0; fd < 3; fd++) {
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0)
            exit(3);
    }
}

int main(int argc, char **argv)
{
    struct arguments a;
    struct session session = {.can = {.listener = -1, .fd = -1}, .serial = {.listener = -1, .fd = -1},
                              .gdb = {.listener = -1, .fd = -1}};
    struct hil_run rig = {0};
    struct hil_replay replay = {0};
    char error[512];
    hold_standard_streams();
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
    status = check_paths(&a);
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
    hil_gdb_close(&session.gdb, mr_status_exit_code(status));
    hil_link_close(&session.can);
    hil_link_close(&session.serial);
    hil_symbols_free(&session.symbols);
    hil_board_destroy(session.board);
    hil_run_free(&rig);
    hil_replay_free(&replay);
    return mr_status_exit_code(status);
}
