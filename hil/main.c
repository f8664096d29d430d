/* matrig-board: the emulated board as a program. Runs one session: a board, its links, and the
 * progress of its virtual time. See --help. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/canbase.h"
#include "common/decimal.h"
#include "common/symbols.h"
#include "common/version.h"
#include "hil/board/board.h"
#include "hil/core/elf.h"
#include "hil/core/state.h"
#include "hil/core/wall.h"
#include "hil/debug/debug.h"
#include "hil/debug/gdb.h"
#include "hil/debug/profile.h"
#include "hil/debug/vcd.h"
#include "hil/link/wire_link.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"
#include "hil/rig/faults.h"
#include "hil/rig/replay.h"
#include "hil/rig/runfile.h"

#define DEFAULT_STALL_S 30.0
#define ENDLESS_RUN_S   100000.0

/* Strings point into argv. */
struct arguments {
    const char *elf, *can, *serial, *rig, *replay, *flash, *nor, *faults, *gdb, *vcd, *profile,
        *margins;
    bool is_board_given, trace;
    unsigned parity;                    /* the parity, as index of its word in the option */
    unsigned speed;                     /* 0: max; 1: real */
    unsigned gdb_time;                  /* 1: time continues while gdb holds the board */
    double run_duration_s;              /* 0: not given */
    double stall_limit_s, wall_limit_s; /* wall_limit_s: 0: no limit; negative: not given */
    struct hil_options options;
};

/* Values in addition to those of enum hil_parity, in the order of the option's words. */
enum { PARITY_AS_BOARD = 3, PARITY_NOT_GIVEN };

#define refuse(...) (print_error(__VA_ARGS__), MR_USAGE)

/* Prints one line on stderr, with the program's name. */
__attribute__((format(printf, 1, 2))) static void print_error(const char *format, ...)
{
    va_list arguments;
    fputs("matrig-board: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

/* Whole numbers may also be hexadecimal, such as 0x190. */
static bool parse_number(const char *text, bool whole, double low, double high, double *value)
{
    const char *end;
    *value = whole && strncmp(text, "0x", 2) == 0
               ? (double)strtoul(text, (char **)(uintptr_t)&end, 16)
               : mr_decimal_parse(text, &end);
    return end != text && !*end && *value >= low && *value <= high;
}

/* Parses up to three numbers between commas. Returns their count; 0 if the first is missing. */
static unsigned parse_list(const char *text, double value[3])
{
    for (unsigned n = 0; n < 3; n++) {
        const char *end;
        value[n] = mr_decimal_parse(text, &end);
        if (end == text || (*end && *end != ','))
            return 0;
        if (!*end)
            return n + 1;
        text = end + 1;
    }
    return 0;
}

/* Index of a word in "a|b|c", or -1. */
static int parse_word(const char *text, const char *words)
{
    size_t length = strlen(text);
    for (int i = 0; length; i++, words++) {
        size_t n = strcspn(words, "|");
        if (n == length && strncmp(words, text, n) == 0)
            return i;
        words += n;
        if (!*words)
            break;
    }
    return -1;
}

/* Accepts stop, count, off, or a list of rules whose violations are only counted. */
static bool parse_rules(struct arguments *a, const char *text)
{
    static const char some[] = "count:";
    int word = parse_word(text, "stop|count|off");
    a->options.rules_mode = word > 0 ? (enum hil_rules_mode)word : HIL_RULES_STOP;
    a->options.counted_rules = 0;
    if (word >= 0)
        return true;
    if (strncmp(text, some, sizeof some - 1) != 0)
        return false;
    for (text += sizeof some - 1;; text++) {
        size_t length = strcspn(text, ",");
        enum hil_rule rule = hil_rule_by_name(text, length);
        if (rule == HIL_RULE_COUNT)
            return false;
        a->options.counted_rules |= 1u << rule;
        text += length;
        if (!*text)
            return true;
    }
}

/* Parses the temperature in degrees, optionally followed by a comma and degrees per hour. */
static bool parse_temperature(struct arguments *a, const char *text)
{
    double value[3] = {(double)NAN, 0.0, 0.0};
    unsigned n = strcmp(text, "none") == 0 ? 1 : parse_list(text, value);
    a->options.temperature_c = value[0];
    a->options.temperature_c_per_h = value[1];
    return (n == 1 || n == 2) && !(value[0] < -60.0 || value[0] > 150.0) &&
           fabs(value[1]) <= 1000.0;
}

/* Parses HZ[,DELAY_MS[,JITTER_US]]. */
static bool parse_camera(struct arguments *a, const char *text)
{
    double value[3] = {0.0, 0.0, 0.0};
    if (!parse_list(text, value))
        return false;
    a->options.camera_hz = value[0];
    a->options.camera_delay_ps = (uint64_t)(value[1] * (double)HIL_PS_PER_MS);
    a->options.camera_jitter_ps = (uint64_t)(value[2] * (double)HIL_PS_PER_US);
    return value[0] >= 0.01 && value[0] <= 1e5 && value[1] >= 0.0 && value[1] <= 1e6 &&
           value[2] >= 0.0 && value[2] <= 1e6;
}

static bool parse_board(struct arguments *a, const char *text)
{
    a->options.type = hil_board_type_by_name(text);
    a->is_board_given = a->options.type != NULL;
    return a->is_board_given;
}

static bool parse_seed(struct arguments *a, const char *text)
{
    char *end;
    errno = 0;
    a->options.noise_seed = strtoull(text, &end, 10);
    return end != text && !*end && !errno && text[0] != '-';
}

static bool parse_board_seed(struct arguments *a, const char *text)
{
    uint64_t seed = a->options.noise_seed;
    bool good = a->options.has_random_tolerances = parse_seed(a, text);
    a->options.tolerance_seed = a->options.noise_seed;
    a->options.noise_seed = seed;
    return good;
}

/* ---- options and help ---- */

/* An option and the member that it sets. FLAG: no value; WORD: index in `words`; PARSED: parsed by
 * a function. */
enum kind { KIND_FLAG, KIND_TEXT, KIND_REAL, KIND_UNSIGNED, KIND_SIGNED, KIND_WORD, KIND_PARSED };

static const struct option {
    const char *name, *value; /* value: name of the option's value in the help */
    enum kind kind;
    size_t offset;     /* offset in struct arguments */
    double low, high;  /* range of a number */
    const char *words; /* the words of a WORD: "a|b|c" */
    bool (*parse)(struct arguments *a, const char *text);
    const char *help;
} options[] = {
#define ARGUMENT_OFFSET(member) offsetof(struct arguments, member)
#define OPTION(...) \
    {               \
        __VA_ARGS__ \
    }
#define TEXT_OPTION(name, value, member, help) \
    OPTION(name, value, KIND_TEXT, ARGUMENT_OFFSET(member), 0, 0, NULL, NULL, help)
#define FLAG_OPTION(name, member, help) \
    OPTION(name, "", KIND_FLAG, ARGUMENT_OFFSET(member), 0, 0, NULL, NULL, help)
#define NUMBER_OPTION(name, value, kind, member, low, high, help) \
    OPTION(name, value, kind, ARGUMENT_OFFSET(member), low, high, NULL, NULL, help)
#define WORD_OPTION(name, value, member, words, help) \
    OPTION(name, value, KIND_WORD, ARGUMENT_OFFSET(member), 0, 0, words, NULL, help)
#define PARSED_OPTION(name, value, parse, help) \
    OPTION(name, value, KIND_PARSED, 0, 0, 0, NULL, parse, help)
    TEXT_OPTION("--elf", "F", elf,
                "firmware image (ELF); default: the one installed with matrig-board"),
    PARSED_OPTION("--board", "B", parse_board,
                  "type of the board: zg, discovery or nucleo446 (common/boards.def); default: the "
                  "board of\nthe image, or zg without an image"),
    TEXT_OPTION("--can", "LINK", can,
                "unix:PATH (16-byte frames), file:PATH (candump -L text) or none"),
    TEXT_OPTION(
        "--serial", "LINK", serial,
        "unix:PATH (bytes), file:PATH, pty:PATH (a terminal that any program can open) or none"),
    NUMBER_OPTION(
        "--can-base", "N", KIND_UNSIGNED, options.can_id_base, 0, MR_CAN_BASE_MAX,
        "base of the board's CAN identifiers; default: 0. CAN commands of the run file or record\n"
        "are sent to this base"),
    WORD_OPTION("--parity", "P", parity, "none|even|odd|board",
                "parity at the other end of the serial line: none, even, odd or board (as on the "
                "board);\ndefault: none; for a pty: link, board"),
    NUMBER_OPTION("--baud", "N", KIND_UNSIGNED, options.host_baud, 1200, 10e6,
                  "bit rate at the other end of the serial line; default: 2000000; for a pty: "
                  "link, the\nrate set at the terminal"),
    TEXT_OPTION("--rig", "RUNFILE", rig,
                "run file (matrig-run format) that moves the rig; default: nothing moves"),
    TEXT_OPTION("--replay", "FILE", replay,
                "recorded landing (matrig-replay format, written by matrig replay) that drives the "
                "pins\ninstead of a rig"),
    WORD_OPTION(
        "--speed", "S", speed, "max|real",
        "max: as fast as possible, waits for a slow host; real: real time, drops data that a slow\n"
        "host does not read; default: max"),
    PARSED_OPTION(
        "--camera", "HZ[,DELAY_MS[,JITTER_US]]", parse_camera,
        "film camera with HZ frames per second: triggered by PE2, sends a pulse per frame on PB3,\n"
        "the first after DELAY_MS; each frame varies by up to +-JITTER_US (defaults: 0)"),
    NUMBER_OPTION(
        "--for", "S", KIND_REAL, run_duration_s, 1e-6, ENDLESS_RUN_S,
        "run for S seconds of virtual time; default: the duration of the run file, or until "
        "a signal"),
    PARSED_OPTION("--seed", "N", parse_seed, "seed of the converter noise; default: 1"),
    NUMBER_OPTION("--vdda", "V", KIND_REAL, options.vdda_v, 2.7, 3.6,
                  "supply of converters and staircase, 2.7 to 3.6; default: the board's (effects: "
                  "hil/README.md)"),
    PARSED_OPTION(
        "--board-seed", "N", parse_board_seed,
        "seed of the component tolerances (gains, zeros, noise, INL, kickback, resistors) of "
        "the\nreference circuits; default: ideal electronics"),
    NUMBER_OPTION("--hse", "HZ", KIND_UNSIGNED, options.hse_hz, 0, 26e6,
                  "crystal frequency; 0: the crystal does not start; default: 8000000"),
    NUMBER_OPTION("--hsi-ppm", "N", KIND_SIGNED, options.hsi_error_ppm, -50000, 50000,
                  "error of the internal oscillator in ppm; default: 0"),
    NUMBER_OPTION(
        "--cpi", "X", KIND_REAL, options.cycles_per_instruction, 1, 16,
        "virtual cycles per instruction, 1 to 16, including wait states and bus; default: 1"),
    NUMBER_OPTION("--lsi", "HZ", KIND_UNSIGNED, options.lsi_hz, 17000, 47000,
                  "frequency of the watchdog clock, 17000 to 47000; default: 32000"),
    TEXT_OPTION(
        "--flash", "FILE", flash,
        "file with the content of the flash: read at the start if it exists, written at the end.\n"
        "--elf overwrites the sectors that the image uses"),
    TEXT_OPTION(
        "--nor", "FILE", nor,
        "file with the content of the black box's memory, which is read and written like --flash"),
    PARSED_OPTION("--temperature", "C[,C/h]", parse_temperature,
                  "mat temperature and its rise per hour; none: no thermometer; default: 20"),
    FLAG_OPTION("--jumper", options.is_jumper_fitted, "fit the maintenance jumper"),
    FLAG_OPTION("--bare", options.has_no_rig,
                "leave the rig unplugged: the lines of one-shot, lamp and camera are open"),
    FLAG_OPTION("--left-on", options.has_clocks_left_on,
                "start without a reset, with PLL and clocks on, as after a debugger"),
    FLAG_OPTION("--boot0", options.is_boot0_high,
                "start the boot ROM (AN3155 on the serial line) instead of the firmware"),
    WORD_OPTION(
        "--times", "T", options.cell_times, "spread|typical|max",
        "times of flash and NOR operations: spread (random), typical or max; default: spread"),
    TEXT_OPTION("--faults", "FILE", faults,
                "faults to inject (matrig-faults file, hil/README.md); each is reported on stderr"),
    FLAG_OPTION(
        "--alignment", options.is_alignment_checked,
        "raise a fault on unaligned multiple and double transfers, as the hardware does; makes "
        "the\nemulation slower"),
    PARSED_OPTION("--rules", "R", parse_rules,
                  "action when a timing or electrical rule at the pins is violated: stop, count, "
                  "off, or\ncount:NAME,... (count these rules, stop on others); default: stop"),
    TEXT_OPTION("--margins", "FILE", margins,
                "write the number of checks of each rule, and its smallest margin with the place"),
    FLAG_OPTION("--trace", trace, "report exceptions and unusual events on stderr"),
    TEXT_OPTION("--gdb", "PORT", gdb,
                "wait for gdb on this port of 127.0.0.1 (0: any free port, which is printed) or at "
                "unix:PATH"),
    WORD_OPTION("--gdb-time", "T", gdb_time, "stands|runs",
                "virtual time while gdb halts the board: stands, or runs in real time. If time "
                "runs, links\nand converters continue; timers and watchdog stop if DBGMCU is set "
                "so; default: stands"),
    TEXT_OPTION(
        "--vcd", "FILE", vcd,
        "write a trace of pins, converters, links, exceptions and sleep, for GTKWave and others"),
    TEXT_OPTION("--profile", "FILE", profile, "write the number of instructions per function"),
    NUMBER_OPTION("--stall", "S", KIND_REAL, stall_limit_s, 0.001, 86400,
                  "end when a host does not read for S seconds; default: 30"),
    NUMBER_OPTION(
        "--wall-limit", "S", KIND_REAL, wall_limit_s, 0, 1e6,
        "end after S seconds of wall clock; default: the run's length plus 600; no limit for a\n"
        "run without end or with --gdb"),
#undef ARGUMENT_OFFSET
};

static void print_item(const char *name, const char *value, const char *text)
{
    int width = printf("  %s%s%s", name, *value ? " " : "", value);
    printf("%*s", width < 18 ? 19 - width : 2, "");
    for (; *text; text++) {
        putchar(*text);
        if (*text == '\n')
            printf("%19s", "");
    }
    putchar('\n');
}

static void print_help(void)
{
    puts("usage: matrig-board [--elf F] [--can LINK] [--serial LINK] [--rig RUNFILE] [options]\n   "
         "    matrig-board --flash F | --boot0 [options]\nEmulates the STM32F407 board in virtual "
         "time with the unmodified firmware image F.");
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        print_item(options[i].name, options[i].value, options[i].help);
    print_item("--version", "", "print the version and exit");
    puts("The board starts when each link of type unix has a connection and, with --gdb, gdb has\n"
         "connected; with --speed max, also when a link of type pty has been open for 50 ms. The\n"
         "board waits for each of these at most 30 s.\n"
         "Exit: 0 ok, 2 usage, 3 link, board or firmware failed, 4 malformed or truncated input.");
}

static enum mr_status refuse_board(const char *text)
{
    char names[200] = "";
    for (unsigned i = 0; hil_board_type_by_number(i); i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), " %s",
                 hil_board_type_name(hil_board_type_by_number(i)));
    return refuse("--board cannot be `%s`; there are:%s", text, names);
}

static const struct option *find_option(const char *name)
{
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (strcmp(options[i].name, name) == 0)
            return &options[i];
    }
    return NULL;
}

static bool set_option(struct arguments *a, const struct option *option, const char *text)
{
    char *place = (char *)a + option->offset;
    double value = 0.0;
    int word = option->kind == KIND_WORD ? parse_word(text, option->words) : 0;
    bool is_number = option->kind == KIND_REAL || option->kind == KIND_UNSIGNED ||
                     option->kind == KIND_SIGNED;
    if (word < 0 || (is_number && !parse_number(text, option->kind == KIND_UNSIGNED, option->low,
                                                option->high, &value)))
        return false;
    switch (option->kind) {
    case KIND_FLAG: *(bool *)place = true; break;
    case KIND_TEXT: *(const char **)place = text; break;
    case KIND_REAL: *(double *)place = value; break;
    case KIND_UNSIGNED: *(uint32_t *)place = (uint32_t)value; break;
    case KIND_SIGNED: *(int32_t *)place = (int32_t)value; break;
    case KIND_WORD: *(unsigned *)place = (unsigned)word; break;
    case KIND_PARSED: return option->parse(a, text);
    }
    return true;
}

/* Finds the image installed with the program: in the build or installation directory. */
static bool find_installed_image(const struct hil_board_type *type, const char **elf)
{
    static const char *const places[] = {"firmware", "../share/matrig"};
    static char path[PATH_MAX];
    char program[PATH_MAX - 80];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    const char *slash = length > 0 ? memrchr(program, '/', (size_t)length) : NULL;
    for (size_t i = 0; slash && i < sizeof places / sizeof places[0]; i++) {
        snprintf(path, PATH_MAX, "%.*s/%s/%s%smatrig.elf", (int)(slash - program), program,
                 places[i], type->number ? hil_board_type_name(type) : "", type->number ? "/" : "");
        if (access(path, R_OK) == 0) {
            *elf = path;
            return true;
        }
    }
    return false;
}

static enum mr_status parse_argument(struct arguments *a, int argc, char **argv)
{
    bool given[sizeof options / sizeof options[0]] = {false};
    *a = (struct arguments){.can = "none",
                            .serial = "none",
                            .parity = PARITY_NOT_GIVEN,
                            .stall_limit_s = DEFAULT_STALL_S,
                            .wall_limit_s = -1.0};
    hil_options_default(&a->options);
    a->options.fault_log = stderr;
    for (int i = 1; i < argc; i++) {
        const struct option *option = find_option(argv[i]);
        if (option && given[option - options])
            return refuse("%s is given twice; give it once", argv[i]);
        if (strncmp(argv[i], "--", 2) != 0)
            return refuse("unexpected argument `%s`; matrig-board takes only options, see "
                          "matrig-board --help",
                          argv[i]);
        if (i + 1 == argc && !(option && option->kind == KIND_FLAG))
            return refuse("%s needs a value, or is an unknown option; see matrig-board --help",
                          argv[i]);
        if (!option)
            return refuse("unknown option %s; matrig-board --help lists them", argv[i]);
        given[option - options] = true;
        bool is_set = set_option(a, option, argv[i + 1]);
        if (!is_set && option->parse == parse_board)
            return refuse_board(argv[i + 1]);
        if (!is_set)
            return refuse("%s cannot be `%s`; see matrig-board --help", argv[i], argv[i + 1]);
        i += option->kind != KIND_FLAG;
    }
    a->options.trace = a->trace ? stderr : NULL;
    return MR_OK;
}

static enum mr_status check_arguments(struct arguments *a)
{
    if (!a->elf && !a->flash && !a->options.is_boot0_high &&
        !find_installed_image(a->options.type, &a->elf))
        return refuse(
            "no firmware image next to matrig-board or in ../share/matrig; give --elf FILE");
    if (a->options.has_no_rig && a->rig)
        return refuse(
            "--bare and --rig cannot be given together: --bare emulates a board without a rig");
    if (a->rig && a->replay)
        return refuse("--rig and --replay cannot be given together: the pins follow either a rig "
                      "or a record");
    if (a->parity == PARITY_NOT_GIVEN)
        a->parity = strncmp(a->serial, "pty:", 4) == 0 ? PARITY_AS_BOARD : HIL_PARITY_NONE;
    a->options.host_parity_follows_board = a->parity == PARITY_AS_BOARD;
    a->options.host_parity = a->parity == PARITY_AS_BOARD ? HIL_PARITY_NONE
                                                          : (enum hil_parity)a->parity;
    return MR_OK;
}

static enum mr_status parse_arguments(struct arguments *a, int argc, char **argv)
{
    if (argc == 1)
        return refuse("nothing to do: give a landing with --rig, links with --can and --serial, or "
                      "an image with --elf; see matrig-board --help");
    enum mr_status status = parse_argument(a, argc, argv);
    return status == MR_OK ? check_arguments(a) : status;
}

/* Makes the checks that depend on the board type. */
static enum mr_status check_board(const struct arguments *a)
{
    if (a->options.is_boot0_high && !a->options.type->is_rom_on_serial)
        return refuse("--boot0: the boot ROM of board %s cannot be reached on its serial link; "
                      "program this board through its ST-LINK",
                      hil_board_type_name(a->options.type));
    return MR_OK;
}

/* ---- paths: refuse outputs that would overwrite a file in use ---- */

/* Returns the path of a link or file; NULL if it has none. */
static const char *find_link_path(const char *text)
{
    if (!text || strcmp(text, "none") == 0)
        return NULL;
    return strncmp(text, "unix:", 5) == 0 || strncmp(text, "file:", 5) == 0 ? text + 5
         : strncmp(text, "pty:", 4) == 0                                    ? text + 4
                                                                            : text;
}

/* True if two paths are the same file; always false for devices. */
static bool is_same_file(const char *a, const char *b)
{
    struct stat one, other;
    bool there = stat(a, &one) == 0;
    if (there && S_ISCHR(one.st_mode))
        return false;
    return strcmp(a, b) == 0 || (there && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
                                 one.st_ino == other.st_ino);
}

enum { FIRST_RECORD_PATH = 4, FIRST_MEMORY_PATH = 7, MEMORY_PATHS_END = 10, PATH_COUNT = 12 };

/* Refuses an output file that is also an input or another output, unless it is a device, and one
 * that would replace a campaign or a program. */
static enum mr_status check_paths(const struct arguments *a)
{
    const struct {
        const char *option, *path;
    } given[PATH_COUNT] = {
        {"--elf", a->elf},
        {"--rig", a->rig},
        {"--replay", a->replay},
        {"--faults", a->faults},
        {"--can", find_link_path(a->can)},
        {"--serial", find_link_path(a->serial)},
        {"--gdb", a->gdb && strncmp(a->gdb, "unix:", 5) == 0 ? find_link_path(a->gdb) : NULL},
        {"--vcd", a->vcd},
        {"--profile", a->profile},
        {"--margins", a->margins},
        {"--flash", a->flash},
        {"--nor", a->nor},
    };
    for (unsigned i = FIRST_RECORD_PATH; i < PATH_COUNT; i++) {
        for (unsigned k = 0; given[i].path && k < i; k++) {
            if (given[k].path && is_same_file(given[i].path, given[k].path))
                return refuse("%s and %s have the same file %s; give two different files",
                              given[k].option, given[i].option, given[i].path);
        }
        if (given[i].path && i >= FIRST_MEMORY_PATH && i < MEMORY_PATHS_END &&
            hil_is_protected_file(given[i].path))
            return refuse("%s would overwrite a database or a program: %s; give a different file",
                          given[i].option, given[i].path);
    }
    return MR_OK;
}

/* ---- a run ---- */

/* wall-clock time limit of a run, in addition to its virtual duration, s */
#define DEFAULT_WALL_LIMIT_S 600.0
#define CONNECT_TIMEOUT_MS   30000
/* virtual time between polls of the sockets, at full speed */
#define SLICE_MAX_PS         (5ull * HIL_PS_PER_MS)
/* in real time: virtual time between two waits for the wall clock and polls of the sockets */
#define SLICE_REAL_PS        (1ull * HIL_PS_PER_MS)
#define HOST_AWAY_PS         (50ull * HIL_PS_PER_MS)

struct session {
    const struct arguments *a;
    struct hil_board *board;
    struct hil_link can, serial;
    uint64_t last_host_activity_ps; /* time when a host last used the pty */
    struct mr_symbols symbols;
    struct hil_run rig;
    struct hil_replay replay;
    struct hil_pace pace;
    struct hil_gdb gdb;
    FILE *profile, *margins;
    int stall_ms;
    bool is_real_time;
};

/* 1: stopped by a signal; HIL_STOP_BY_WALL_LIMIT: by the wall-clock limit. */
static volatile int stop_request;

/* Prints the reason of a failure. */
static enum mr_status report_failure(enum mr_status status, const char *why)
{
    if (status != MR_OK)
        print_error("%s", why);
    return status;
}

static void on_can_frame(void *context, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct session *session = context;
    hil_link_put_frame(&session->can, t_ps, frame);
}

static void on_serial_bytes(void *context, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct session *session = context;
    (void)t_ps;
    hil_link_put_bytes(&session->serial, bytes, n);
}

static enum mr_status flush_links(struct session *session, int stall_ms)
{
    char error[256];
    enum mr_status status = hil_link_flush(&session->can, stall_ms, &stop_request, error,
                                           sizeof error);
    if (status == MR_OK)
        status = hil_link_flush(&session->serial, stall_ms, &stop_request, error, sizeof error);
    return status == MR_CLOSED ? MR_OK : report_failure(status, error);
}

/* At full speed, waits while no program has had the pty open for HOST_AWAY_PS, so that a program
 * can start or restart. Returns false if the wait failed or was stopped. */
static bool is_host_present(struct session *session, uint64_t t_ps)
{
    char error[256];
    if (session->serial.transport != HIL_LINK_PTY)
        return true;
    if (!session->serial.has_host_closed)
        session->last_host_activity_ps = t_ps;
    if (t_ps < session->last_host_activity_ps + HOST_AWAY_PS)
        return true;
    enum mr_status status = hil_link_accept(&session->serial, CONNECT_TIMEOUT_MS, &stop_request,
                                            error, sizeof error);
    return stop_request ? status == MR_OK : report_failure(status, error) == MR_OK;
}

/* Runs until t_ps or until the debugger holds the board. */
static enum mr_status run_until(struct session *session, uint64_t t_ps)
{
    enum mr_status status = hil_board_run_until(session->board, t_ps);
    if (status != MR_OK)
        print_error("stopped at %.6f s: %s", (double)hil_board_now_ps(session->board) * 1e-12,
                    hil_board_failure_reason(session->board));
    return status;
}

static enum mr_status run_with_debugger(struct session *session, uint64_t t_ps)
{
    enum mr_status status;
    bool alive;
    do {
        status = run_until(session, t_ps);
        enum mr_status flushed = flush_links(session,
                                             session->is_real_time ? 0 : session->stall_ms);
        if (status == MR_OK)
            status = flushed;
        double held_s = hil_wall_clock_s();
        alive = hil_gdb_serve(&session->gdb, status, &stop_request);
        /* Measure the time for which gdb holds the board, which the pacing must ignore. Not without
         * gdb: rounding would add an error of 80 ppm. */
        if (session->gdb.listener >= 0 && !session->gdb.is_time_running)
            session->pace.start_s += hil_wall_clock_s() - held_s;
        if (!alive)
            stop_request = 1;
    } while (status == MR_OK && !stop_request && hil_board_now_ps(session->board) < t_ps);
    return status;
}

static enum mr_status run_board_session(struct session *session, double duration_s)
{
    bool real = session->is_real_time;
    uint64_t end_ps = (uint64_t)(duration_s * 1e12 + 0.5);
    uint64_t slice_ps = real ? SLICE_REAL_PS : SLICE_MAX_PS;
    enum mr_status status = MR_OK;
    session->pace.start_s = hil_wall_clock_s();
    session->can.drops_when_full = session->serial.drops_when_full = real;
    for (uint64_t t_ps = 0; t_ps < end_ps && !stop_request && status == MR_OK;) {
        if (!real && !is_host_present(session, t_ps)) {
            status = stop_request ? MR_OK : MR_TIMEOUT;
            break;
        }
        t_ps = t_ps + slice_ps < end_ps ? t_ps + slice_ps : end_ps;
        if (real)
            hil_pace_wait(&session->pace, t_ps, &stop_request);
        hil_link_receive(&session->can, session->board);
        hil_link_receive(&session->serial, session->board);
        status = run_with_debugger(session, t_ps);
        if (real)
            hil_pace_record(&session->pace, t_ps);
    }
    /* At full and at real speed, the last output may take up to the stall time. */
    enum mr_status flushed = flush_links(session, session->stall_ms);
    if (status == MR_OK && stop_request == HIL_STOP_BY_WALL_LIMIT) {
        print_error("the wall-clock limit ended the run at %.3f s of virtual time; for a longer "
                    "limit, give --wall-limit S",
                    (double)hil_board_now_ps(session->board) * 1e-12);
        status = MR_TIMEOUT;
    }
    return status == MR_OK ? flushed : status;
}

/* Prints a one-line summary of the run on stderr. */
static void summarise_session(const struct session *session, double took_s)
{
    const struct hil_counters *c = hil_board_counters(session->board);
    double virtual_s = (double)hil_board_now_ps(session->board) * 1e-12;
    char pace[96] = "";
    if (session->is_real_time)
        snprintf(pace, sizeof pace, ", at most %.1f ms late, %.1f ms after the first second",
                 1e3 * session->pace.max_delay_s, 1e3 * session->pace.max_delay_after_start_s);
    fprintf(
        stderr,
        "matrig-board: %.3f s virtual in %.3f s wall (%.1f x%s), %llu instructions, CAN %llu out "
        "%llu in, "
        "serial %llu bytes out %llu in, dropped %llu frames %llu bytes, resets %llu, faults %llu\n",
        virtual_s, took_s, took_s > 0 ? virtual_s / took_s : 0.0, pace,
        (unsigned long long)c->instructions, (unsigned long long)c->can_frames_out,
        (unsigned long long)c->can_frames_in, (unsigned long long)c->serial_bytes_out,
        (unsigned long long)c->serial_bytes_in,
        (unsigned long long)(session->can.dropped_count + c->can_frames_in_dropped),
        (unsigned long long)(session->serial.dropped_count + c->serial_bytes_in_dropped),
        (unsigned long long)c->resets, (unsigned long long)c->fault_exceptions);
}

/* Waits for hosts on sockets. Other links need no host; a terminal may be opened and closed at any
 * time. */
static enum mr_status accept_hosts(struct session *session, char *error, size_t size)
{
    enum mr_status status = hil_link_accept(&session->can, CONNECT_TIMEOUT_MS, &stop_request, error,
                                            size);
    if (status == MR_OK && session->serial.transport != HIL_LINK_PTY)
        status = hil_link_accept(&session->serial, CONNECT_TIMEOUT_MS, &stop_request, error, size);
    if (status == MR_OK)
        status = hil_gdb_accept(&session->gdb, session->board, CONNECT_TIMEOUT_MS, &stop_request,
                                error, size);
    return status;
}

/* Opens the links and waits for their hosts. MR_CLOSED: the program was stopped while waiting. */
static enum mr_status open_session(struct session *session)
{
    const struct arguments *a = session->a;
    char error[512];
    enum mr_status status = hil_link_open(&session->can, HIL_LINK_CAN, a->can, error, sizeof error);
    struct hil_callbacks callbacks = {session, on_can_frame, on_serial_bytes};
    hil_board_set_callbacks(session->board, &callbacks);
    if (status == MR_OK)
        status = hil_link_open(&session->serial, HIL_LINK_SERIAL, a->serial, error, sizeof error);
    if (status == MR_OK && a->gdb) {
        status = hil_gdb_open(&session->gdb, a->gdb, error, sizeof error);
        session->gdb.is_time_running = a->gdb_time != 0;
        if (status == MR_OK)
            fprintf(stderr, "matrig-board: waiting for gdb: target remote %s\n",
                    session->gdb.address);
    }
    if (status == MR_OK)
        status = accept_hosts(session, error, sizeof error);
    if (stop_request == HIL_STOP_BY_WALL_LIMIT)
        print_error("the wall-clock limit was reached before all links were open; check that a "
                    "host is running, or raise the limit with --wall-limit S");
    else if (!stop_request)
        report_failure(status, error);
    return status;
}

static void close_session(struct session *session, enum mr_status status)
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
    stop_request = 1;
}

static void print_rules(const struct session *session)
{
    uint64_t times;
    unsigned broken = hil_rules_count_violated(&session->board->mcu.rules, &times);
    if (broken)
        print_error("%u %s broken, %llu %s in total%s", broken, broken == 1 ? "rule" : "rules",
                    (unsigned long long)times, times == 1 ? "time" : "times",
                    session->a->margins ? "" : "; to list the rules, give --margins FILE");
}

static double get_run_duration_s(const struct session *session)
{
    const struct arguments *a = session->a;
    double length_s = a->run_duration_s > 0 ? a->run_duration_s
                    : a->rig                ? session->rig.duration_s
                    : a->replay             ? hil_replay_duration_s(&session->replay)
                                            : 0.0;
    return length_s > 0 ? length_s : ENDLESS_RUN_S;
}

static enum mr_status load_memories(struct hil_board *board, const struct arguments *a)
{
    enum mr_status status = MR_OK;
    if (a->flash)
        status = hil_board_load_flash(board, a->flash);
    /* errors in the file's old content do not matter here, because the ELF file replaces it */
    if (a->elf && (status == MR_OK || status == MR_HALTED || status == MR_VERSION))
        status = a->flash ? hil_board_program_elf(board, a->elf)
                          : hil_board_load_elf(board, a->elf);
    if (a->nor && status == MR_OK)
        status = hil_board_load_nor(board, a->nor);
    return status;
}

/* Writes the memories to files, whether or not the run was successful. */
static enum mr_status save_memories(struct hil_board *board, const struct arguments *a,
                                    enum mr_status status)
{
    enum mr_status saved = MR_OK;
    if (a->flash)
        saved = hil_board_save_flash(board, a->flash);
    if (a->nor && saved == MR_OK)
        saved = hil_board_save_nor(board, a->nor);
    report_failure(saved, hil_board_failure_reason(board));
    return status == MR_OK ? saved : status;
}

static enum mr_status add_faults(const struct session *session)
{
    static struct hil_fault_script script;
    const struct arguments *a = session->a;
    char error[512];
    enum mr_status status = hil_faults_read(a->faults, a->elf, &script, error, sizeof error);
    if (report_failure(status, error) != MR_OK)
        return status;
    status = hil_faults_add_all(&session->board->faults, &script);
    if (status != MR_OK)
        print_error("%s: %s", a->faults, hil_board_failure_reason(session->board));
    return status;
}

/* Limits the wall-clock time of a run of known duration, in case it does not end. */
static void start_wall_limit(const struct arguments *a, double duration_s)
{
    double limit_s = a->wall_limit_s;
    if (limit_s < 0)
        limit_s = duration_s < ENDLESS_RUN_S && !a->gdb
                    ? DEFAULT_WALL_LIMIT_S + (a->speed ? duration_s : 0.0)
                    : 0.0;
    hil_wall_clock_set_limit(limit_s, &stop_request);
}

static enum mr_status open_record(const char *option, const char *path, FILE **file)
{
    if (!path || (*file = fopen(path, "w")))
        return MR_OK;
    print_error("%s: cannot write %s: %s; give a different file", option, path, strerror(errno));
    return MR_IO;
}

static enum mr_status close_record(const char *option, const char *path, FILE *file, bool failed)
{
    failed |= fclose(file) != 0;
    if (!failed)
        return MR_OK;
    print_error("%s: cannot write all of %s: %s; free disk space or give a different file", option,
                path, strerror(errno));
    return MR_IO;
}

static enum mr_status open_records(struct session *session, const struct arguments *a)
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
    return a->vcd ? report_failure(
                        hil_vcd_open(board, a->vcd, &session->symbols, error, sizeof error), error)
                  : MR_OK;
}

static enum mr_status close_records(struct session *session, const struct arguments *a)
{
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = report_failure(hil_vcd_close(board, error, sizeof error), error),
                   closed;
    if (session->margins) {
        hil_rules_print_tallies(&board->mcu.rules, session->margins);
        closed = close_record("--margins", a->margins, session->margins, false);
        status = status == MR_OK ? closed : status;
    }
    if (session->profile) {
        bool failed = hil_profile_end(board, &session->symbols, session->profile) != MR_OK;
        closed = close_record("--profile", a->profile, session->profile, failed);
        status = status == MR_OK ? closed : status;
    }
    return status;
}

/* Prepares the board before power on: memories, rig and faults. */
static enum mr_status prepare_board(struct session *session)
{
    const struct arguments *a = session->a;
    struct hil_board *board = session->board;
    char error[512];
    enum mr_status status = report_failure(load_memories(board, a),
                                           hil_board_failure_reason(board));
    if (status == MR_OK && a->elf)
        status = report_failure(hil_symbols_read(&session->symbols, a->elf, error, sizeof error),
                                error);
    if (status != MR_OK)
        return status;
    hil_board_attach_rig(board, a->rig ? &session->rig : NULL);
    if (a->replay)
        hil_board_attach_replay(board, &session->replay);
    if (a->faults)
        status = add_faults(session);
    return status;
}

static enum mr_status run_session(struct session *session)
{
    const struct arguments *a = session->a;
    enum mr_status status = prepare_board(session);
    if (status != MR_OK)
        return status;
    session->is_real_time = a->speed != 0;
    session->stall_ms = (int)(a->stall_limit_s * 1e3);
    double duration_s = get_run_duration_s(session);
    start_wall_limit(a, duration_s);
    status = open_session(session);
    if (status != MR_OK)
        return stop_request == 1 ? MR_OK : status;
    status = open_records(session, a);
    if (status != MR_OK)
        return status;
    double began_s = hil_wall_clock_s();
    status = run_board_session(session, duration_s);
    double took_s = hil_wall_clock_s() - began_s;
    enum mr_status closed = close_records(session, a);
    hil_faults_report_pending(&session->board->faults);
    print_rules(session);
    summarise_session(session, took_s);
    if (status == MR_OK)
        status = closed;
    enum mr_status saved = save_memories(session->board, a, status);
    return status == MR_OK ? saved : status;
}

/* Reads the files that determine the run and the board. */
static enum mr_status read_files(struct session *session, struct arguments *a)
{
    char error[512];
    enum mr_status status = MR_OK;
    if (a->rig)
        status = report_failure(hil_run_read(a->rig, &session->rig, error, sizeof error), error);
    else if (a->replay)
        status = report_failure(hil_replay_read(a->replay, &session->replay, error, sizeof error),
                                error);
    return status;
}

static enum mr_status make_board(struct session *session, struct arguments *a)
{
    char error[512];
    if (!a->is_board_given &&
        report_failure(
            hil_board_type_from_files(a->elf, a->flash, &a->options.type, error, sizeof error),
            error) != MR_OK)
        return MR_VERSION;
    enum mr_status status = check_board(a);
    if (status == MR_OK)
        session->board = hil_board_create(&a->options);
    return status;
}

/* Opens standard streams that are closed. Otherwise an output file could get descriptor 2, and
 * messages would be written to it. */
static void open_standard_streams(void)
{
    for (int fd = 0; fd < 3; fd++) {
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0)
            exit(3);
    }
}

int main(int argc, char **argv)
{
    static struct arguments a;
    static struct session session = {.a = &a,
                                     .can = {.listener = -1, .fd = -1},
                                     .serial = {.listener = -1, .fd = -1},
                                     .gdb = {.listener = -1, .connection = {.fd = -1}}};
    open_standard_streams();
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help();
            return 0;
        }
        if (strcmp(argv[i], "--version") == 0) {
            puts("matrig-board " VERSION_TEXT);
            return 0;
        }
    }
    enum mr_status status = parse_arguments(&a, argc, argv);
    if (status == MR_OK)
        status = check_paths(&a);
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
    status = run_session(&session);
    close_session(&session, status);
    return mr_status_exit_code(status);
}
