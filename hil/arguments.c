#include "hil/arguments.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hil/board/precious.h"
#include "hil/core/time.h"

#define STALL_S 30.0
#define HANG_S 5.0

const char hil_help[] =
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

void hil_complain(const char *format, ...)
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

static bool parse_parity(struct hil_arguments *a, const char *text)
{
    static const char *const words[] = {"none", "even", "odd", "board"};
    int word = parse_word(text, words, 4);
    a->parity_given = true;
    a->options.host_parity_follows = word == 3;
    a->options.host_parity = word > 0 && word < 3 ? (enum hil_parity)word : HIL_PARITY_NONE;
    return word >= 0;
}

static bool parse_times(struct hil_arguments *a, const char *text)
{
    static const char *const words[] = {"spread", "typical", "max"};
    int word = parse_word(text, words, 3);
    a->options.cell_times = word > 0 ? (enum hil_cell_times)word : HIL_TIMES_SPREAD;
    return word >= 0;
}

/* Degrees, and degrees per hour behind a comma. */
static bool parse_temperature(struct hil_arguments *a, const char *text)
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

static enum mr_status parse_option(struct hil_arguments *a, const char *name, const char *text)
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
        ok = parse_number(text, 1e-6, HIL_FOREVER_S, &a->for_s);
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
        ok = parse_number(text, 0, HIL_FOREVER_S, &a->hang_s);
    } else if (strcmp(name, "--stall") == 0) {
        ok = parse_number(text, 0.001, 86400, &a->stall_s);
    } else if (strcmp(name, "--wall-limit") == 0) {
        ok = parse_number(text, 0, 1e6, &a->wall_limit_s);
    } else {
        hil_complain("unknown option %s; matrig-board --help lists them", name);
        return MR_USAGE;
    }
    if (!ok)
        hil_complain("%s cannot be `%s`; see matrig-board --help", name, text);
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

enum mr_status hil_arguments_parse(struct hil_arguments *a, int argc, char **argv)
{
    *a = (struct hil_arguments){.can = "none", .serial = "none", .hang_s = HANG_S, .stall_s = STALL_S,
                            .wall_limit_s = -1.0};
    hil_options_default(&a->options);
    a->options.log = stderr;
    for (int i = 1; i < argc; i++) {
        if (is_repeated(argv, i)) {
            hil_complain("%s is given twice; give it once", argv[i]);
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
            hil_complain("what is `%s`? Everything is given by options; see matrig-board --help", argv[i]);
            return MR_USAGE;
        }
        if (i + 1 == argc) {
            hil_complain("%s needs a value, or is no option; see matrig-board --help", argv[i]);
            return MR_USAGE;
        }
        enum mr_status status = parse_option(a, argv[i], argv[i + 1]);
        if (status != MR_OK)
            return status;
        i++;
    }
    if (!a->elf && !a->flash && !a->options.boot0) {
        hil_complain("which firmware? Give --elf FILE; see matrig-board --help");
        return MR_USAGE;
    }
    if (a->rig && a->replay) {
        hil_complain("--rig and --replay cannot be given together: the pins are either a rig's or a record's");
        return MR_USAGE;
    }
    if (!a->parity_given)
        a->options.host_parity_follows = strncmp(a->serial, "pty:", 4) == 0;
    return MR_OK;
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

enum mr_status hil_arguments_check_paths(const struct hil_arguments *a)
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
                hil_complain("%s and %s are both %s; give each its own", given[k].option, given[i].option, path[i]);
                return MR_USAGE;
            }
        }
        if ((given[i].text == a->vcd || given[i].text == a->profile) && path[i][0] && hil_is_precious(path[i])) {
            hil_complain("%s would overwrite a database or a program: %s; give another file", given[i].option, path[i]);
            return MR_USAGE;
        }
    }
    return MR_OK;
}
