#include "hil/arguments.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/canbase.h"
#include "common/decimal.h"
#include "hil/board/precious.h"
#include "hil/core/state.h"
#include "hil/periph/board_type.h"
#include "hil/periph/rules.h"

#define STALL_S 30.0
#define HANG_S  5.0

const char hil_help[] =
    "usage: matrig-board [--elf F] [--can LINK] [--serial LINK] [--rig RUNFILE] [options]\n"
    "       matrig-board --flash F | --boot0 [options]\n"
    "The STM32F407 board in virtual time, running the firmware image F unmodified.\n"
    "  --elf F          firmware image (ELF); else the one that came with matrig-board\n"
    "  --board B        which board it is, by the name in common/boards.def: zg, discovery ...; "
    "else\n"
    "                   what the image says (default zg)\n"
    "  --can LINK       unix:PATH (16-byte frames), file:PATH (candump -L text) or none\n"
    "  --serial LINK    unix:PATH (bytes), file:PATH, pty:PATH (a terminal that any program opens) "
    "or none\n"
    "  --can-base N     the base of the board's CAN identifiers, as its configuration has it "
    "(default 0): CAN commands of\n"
    "                   the run file or record are sent to it\n"
    "  --parity P       of the serial line's other end: none, even, odd or board (what the board "
    "has);\n"
    "                   default none, pty: board, for Linux keeps no parity for pseudo-terminals\n"
    "  --baud N         rate of the serial line's other end (default 2000000; pty: what is set "
    "there)\n"
    "  --rig RUNFILE    what the rig does: a matrig-run file; without it nothing moves\n"
    "  --replay FILE    instead of a rig, a recorded landing: a matrig-replay file, which matrig "
    "replay writes\n"
    "  --speed S        max: at full speed, waiting for a slow host (default); real: by the wall "
    "clock, dropping\n"
    "  --camera HZ[,DELAY_MS[,JITTER_US]]  a film camera: triggered by PE2, after DELAY_MS "
    "(default 0) it gives a pulse\n"
    "                   a frame on PB3\n"
    "  --for S          seconds of virtual time (default: the longest run file's duration, or "
    "until a signal)\n"
    "  --seed N         of converter noise (default 1)\n"
    "  --vdda V         supply of converters and staircase, 2.7 to 3.6 (default: the board's); "
    "what is\n"
    "                   relative to it: hil/README.md\n"
    "  --board-seed N   draw the board's electronics (gains, zeros, noise, INL, kick, resistors) "
    "from "
    "the spread of the\n"
    "                   reference circuits; the same N, the same board (default: the ideal board)\n"
    "  --hse HZ         crystal, 0: it does not start (default 8000000)\n"
    "  --hsi-ppm N      error of the internal oscillator (default 0)\n"
    "  --lsi HZ         watchdog clock, 17000 to 47000 (default 32000)\n"
    "  --flash FILE     content of the flash: read if it is there, written at the end; --elf then "
    "goes over it,\n"
    "                   sparing the sectors it does not use\n"
    "  --nor FILE       the same for the black box's memory\n"
    "  --temperature C[,C/h]  of the mat, in degrees and how fast it rises, or none: no "
    "thermometer (default 20)\n"
    "  --bare           nothing is plugged in where the rig is: the lines of one-shot, lamp and "
    "camera "
    "are open\n"
    "  --left-on        start as after a jump, without a reset: PLL and clocks on, as a debugger "
    "leaves them\n"
    "  --boot0          start the boot ROM (AN3155 on the serial line) instead of the firmware\n"
    "  --times T        of flash and NOR operations: spread (drawn, default), typical or max\n"
    "  --faults FILE    what goes wrong and when: a matrig-faults file (hil/README.md); told on "
    "stderr\n"
    "  --alignment      fault on unaligned multiple and double transfers, as silicon does; slower\n"
    "  --rules R        what a broken rule of time or electricity at the pins does: stop "
    "(default), "
    "count,\n"
    "                   count:NAME,... (of these alone), or off: they are not looked at\n"
    "  --margins FILE   what was measured of each rule: how often, the nearest to its number, "
    "where\n"
    "  --not-modelled   print what of the chip is not modelled, and end\n"
    "  --version        print the version, and end\n"
    "  --trace          tell exceptions and unusual events on stderr\n"
    "  --gdb PORT       listen for gdb on this port of 127.0.0.1 (0: any; it is told) or at "
    "unix:PATH, and wait for it\n"
    "  --vcd FILE       trace of pins, converters, links, exceptions, sleep and functions, for "
    "GTKWave and others\n"
    "  --vcd-functions A,B,...  functions to trace (default: the main ones)\n"
    "  --profile FILE   instructions by function, level and kind\n"
    "  --force          a file of --margins, --profile or --vcd takes the place of one that is not "
    "of its kind\n"
    "  --hang S         end when the firmware hangs for S seconds of virtual time (default 5, 0: "
    "never)\n"
    "  --stall S        end when a host does not read for S seconds (default 30)\n"
    "  --wall-limit S   end after S seconds of wall clock (default 600 more than the run's own "
    "length; none\n"
    "                   for a run without end or with --gdb)\n"
    "A unix: link is listened on; virtual time starts when a host has connected to each, and gdb, "
    "within 30 s. At\n"
    "full speed it stands still when nobody has had the pty: open for 50 ms, for at most 30 s.\n"
    "Exit: 0 ok, 2 usage, 3 link, board or firmware failed, 4 malformed or truncated input.\n";

#define refuse(...) (hil_complain(__VA_ARGS__), MR_USAGE)

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
    const char *end;
    *value = mr_decimal_read(text, &end);
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

/* stop, count, off, or the rules that only count. */
static bool parse_rules(struct hil_arguments *a, const char *text)
{
    static const char *const words[] = {"stop", "count", "off"};
    static const char some[] = "count:";
    int word = parse_word(text, words, 3);
    a->options.rules = word > 0 ? (enum hil_rules_mode)word : HIL_RULES_STOP;
    a->options.rules_counted = 0;
    if (word >= 0)
        return true;
    if (strncmp(text, some, sizeof some - 1) != 0)
        return false;
    for (text += sizeof some - 1;; text++) {
        size_t length = strcspn(text, ",");
        enum hil_rule rule = hil_rule_named(text, length);
        if (rule == HIL_RULES)
            return false;
        a->options.rules_counted |= 1u << rule;
        text += length;
        if (!*text)
            return true;
    }
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
    const char *end;
    a->options.temperature_c = (double)NAN;
    a->options.temperature_c_per_h = 0.0;
    if (strcmp(text, "none") == 0)
        return true;
    a->options.temperature_c = mr_decimal_read(text, &end);
    if (end == text || !(a->options.temperature_c >= -60.0 && a->options.temperature_c <= 150.0))
        return false;
    return !*end ||
           (*end == ',' && parse_number(end + 1, -1000, 1000, &a->options.temperature_c_per_h));
}

/* HZ[,DELAY_MS[,JITTER_US]] */
static bool parse_camera(struct hil_arguments *a, const char *text)
{
    double value[3] = {0.0, 0.0, 0.0};
    const double most[3] = {1e5, 1e6, 1e6};
    for (unsigned i = 0; i < 3; i++) {
        const char *end;
        value[i] = mr_decimal_read(text, &end);
        if (end == text || (*end && *end != ',') ||
            !(value[i] >= (i ? 0.0 : 0.01) && value[i] <= most[i]))
            return false;
        text = end + 1;
        if (*end)
            continue;
        a->options.camera_hz = value[0];
        a->options.camera_delay_ps = (uint64_t)(value[1] * (double)HIL_MS_PS);
        a->options.camera_jitter_ps = (uint64_t)(value[2] * (double)HIL_US_PS);
        return true;
    }
    return false;
}

static bool parse_board(struct hil_arguments *a, const char *text)
{
    a->options.type = hil_board_type_named(text);
    a->board_given = a->options.type != NULL;
    return a->board_given;
}

static enum mr_status refuse_board(const char *text)
{
    char names[200] = "";
    for (unsigned i = 0; hil_board_type_of(i); i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), " %s",
                 hil_board_type_name(hil_board_type_of(i)));
    return refuse("--board cannot be `%s`; there are:%s", text, names);
}

static bool parse_speed(struct hil_arguments *a, const char *text)
{
    a->real = strcmp(text, "real") == 0;
    return a->real || strcmp(text, "max") == 0;
}

static bool parse_whole(const char *text, uint64_t *value)
{
    char *end;
    errno = 0;
    *value = strtoull(text, &end, 10);
    return end != text && !*end && !errno && text[0] != '-';
}

static bool parse_seed(struct hil_arguments *a, const char *text)
{
    return parse_whole(text, &a->options.seed);
}

static bool parse_board_seed(struct hil_arguments *a, const char *text)
{
    a->options.board_drawn = true;
    return parse_whole(text, &a->options.board_seed);
}

/* 400 or 0x190 */
static bool parse_can_base(struct hil_arguments *a, const char *text)
{
    char *end;
    unsigned long base = strtoul(text, &end, strncmp(text, "0x", 2) == 0 ? 16 : 10);
    a->options.can_base = (uint32_t)base;
    return end != text && !*end && text[0] != '-' && base <= MR_CAN_BASE_MOST;
}

static bool parse_hse(struct hil_arguments *a, const char *text)
{
    double hz;
    bool ok = parse_number(text, 0, 26e6, &hz) && (hz >= 4e6 || hz < 1);
    a->options.hse_hz = ok ? (uint32_t)hz : 0;
    return ok;
}

/* What an option is, and where it goes. FLAG: without a value; OWN: by a function. */
enum kind { FLAG, TEXT, REAL, UNSIGNED, SIGNED, OWN };

static const struct option {
    const char *name;
    enum kind kind;
    size_t place;     /* in struct hil_arguments */
    double low, high; /* of a number */
    bool (*parse)(struct hil_arguments *a, const char *text);
} options[] = {
#define AT(member) offsetof(struct hil_arguments, member)
    {"--elf", TEXT, AT(elf), 0, 0, NULL},
    {"--can", TEXT, AT(can), 0, 0, NULL},
    {"--serial", TEXT, AT(serial), 0, 0, NULL},
    {"--rig", TEXT, AT(rig), 0, 0, NULL},
    {"--replay", TEXT, AT(replay), 0, 0, NULL},
    {"--flash", TEXT, AT(flash), 0, 0, NULL},
    {"--nor", TEXT, AT(nor), 0, 0, NULL},
    {"--faults", TEXT, AT(faults), 0, 0, NULL},
    {"--gdb", TEXT, AT(gdb), 0, 0, NULL},
    {"--vcd", TEXT, AT(vcd), 0, 0, NULL},
    {"--vcd-functions", TEXT, AT(vcd_functions), 0, 0, NULL},
    {"--profile", TEXT, AT(profile), 0, 0, NULL},
    {"--margins", TEXT, AT(margins), 0, 0, NULL},
    {"--baud", UNSIGNED, AT(options.host_baud), 1200, 10e6, NULL},
    {"--can-base", OWN, 0, 0, 0, parse_can_base},
    {"--lsi", UNSIGNED, AT(options.lsi_hz), 17000, 47000, NULL},
    {"--hsi-ppm", SIGNED, AT(options.hsi_error_ppm), -50000, 50000, NULL},
    {"--vdda", REAL, AT(options.vdda_v), 2.7, 3.6, NULL},
    {"--for", REAL, AT(for_s), 1e-6, HIL_FOREVER_S, NULL},
    {"--hang", REAL, AT(hang_s), 0, HIL_FOREVER_S, NULL},
    {"--stall", REAL, AT(stall_s), 0.001, 86400, NULL},
    {"--wall-limit", REAL, AT(wall_limit_s), 0, 1e6, NULL},
    {"--board", OWN, 0, 0, 0, parse_board},
    {"--parity", OWN, 0, 0, 0, parse_parity},
    {"--temperature", OWN, 0, 0, 0, parse_temperature},
    {"--times", OWN, 0, 0, 0, parse_times},
    {"--rules", OWN, 0, 0, 0, parse_rules},
    {"--speed", OWN, 0, 0, 0, parse_speed},
    {"--camera", OWN, 0, 0, 0, parse_camera},
    {"--seed", OWN, 0, 0, 0, parse_seed},
    {"--board-seed", OWN, 0, 0, 0, parse_board_seed},
    {"--hse", OWN, 0, 0, 0, parse_hse},
    {"--alignment", FLAG, AT(options.watch_alignment), 0, 0, NULL},
    {"--bare", FLAG, AT(options.bare), 0, 0, NULL},
    {"--left-on", FLAG, AT(options.left_on), 0, 0, NULL},
    {"--boot0", FLAG, AT(options.boot0), 0, 0, NULL},
    {"--trace", FLAG, AT(trace), 0, 0, NULL},
    {"--force", FLAG, AT(force), 0, 0, NULL},
#undef AT
};

static const struct option *find(const char *name)
{
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (strcmp(options[i].name, name) == 0)
            return &options[i];
    }
    return NULL;
}

static bool set(struct hil_arguments *a, const struct option *option, const char *text)
{
    char *place = (char *)a + option->place;
    double value = 0.0;
    bool is_number = option->kind == REAL || option->kind == UNSIGNED || option->kind == SIGNED;
    if (is_number && !parse_number(text, option->low, option->high, &value))
        return false;
    switch (option->kind) {
    case FLAG: *(bool *)place = true; break;
    case TEXT: *(const char **)place = text; break;
    case REAL: *(double *)place = value; break;
    case UNSIGNED: *(uint32_t *)place = (uint32_t)value; break;
    case SIGNED: *(int32_t *)place = (int32_t)value; break;
    case OWN: return option->parse(a, text);
    }
    return true;
}

static bool takes_no_value(const char *name)
{
    const struct option *option = find(name);
    return option && option->kind == FLAG;
}

/* The option at argv[i] is there a second time. */
static bool is_repeated(char **argv, int i)
{
    for (int k = 1; k < i; k += takes_no_value(argv[k]) ? 1 : 2) {
        if (strcmp(argv[k], argv[i]) == 0)
            return true;
    }
    return false;
}

/* The image that came with the program: where it was built, or where make install puts it. */
static bool find_image(const struct hil_board_type *type, const char **elf)
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

static enum mr_status parse(struct hil_arguments *a, int argc, char **argv)
{
    *a = (struct hil_arguments){.can = "none",
                                .serial = "none",
                                .hang_s = HANG_S,
                                .stall_s = STALL_S,
                                .wall_limit_s = -1.0};
    hil_options_default(&a->options);
    a->options.log = stderr;
    for (int i = 1; i < argc; i++) {
        if (is_repeated(argv, i))
            return refuse("%s is given twice; give it once", argv[i]);
        if (strncmp(argv[i], "--", 2) != 0)
            return refuse("what is `%s`? Everything is given by options; see matrig-board --help",
                          argv[i]);
        if (i + 1 == argc && !takes_no_value(argv[i]))
            return refuse("%s needs a value, or is no option; see matrig-board --help", argv[i]);
        const struct option *option = find(argv[i]);
        if (!option)
            return refuse("unknown option %s; matrig-board --help lists them", argv[i]);
        bool is_set = set(a, option, argv[i + 1]);
        if (!is_set && option->parse == parse_board)
            return refuse_board(argv[i + 1]);
        if (!is_set)
            return refuse("%s cannot be `%s`; see matrig-board --help", argv[i], argv[i + 1]);
        i += option->kind != FLAG;
    }
    a->options.trace = a->trace ? stderr : NULL;
    return MR_OK;
}

static enum mr_status check(struct hil_arguments *a)
{
    if (!a->elf && !a->flash && !a->options.boot0 && !find_image(a->options.type, &a->elf))
        return refuse("which firmware? None is beside matrig-board, nor in ../share/matrig; give "
                      "--elf FILE");
    if (a->options.bare && a->rig)
        return refuse("--bare and --rig cannot be given together: nothing is plugged in where the "
                      "rig is, or the rig is");
    if (a->rig && a->replay)
        return refuse("--rig and --replay cannot be given together: the pins are either a rig's or "
                      "a record's");
    if (!a->parity_given)
        a->options.host_parity_follows = strncmp(a->serial, "pty:", 4) == 0;
    return MR_OK;
}

enum mr_status hil_arguments_parse(struct hil_arguments *a, int argc, char **argv)
{
    if (argc == 1)
        return refuse("nothing is asked: give a landing with --rig, links with --can and --serial, "
                      "an image with --elf; see matrig-board --help");
    enum mr_status status = parse(a, argc, argv);
    return status == MR_OK ? check(a) : status;
}

enum mr_status hil_arguments_check_board(const struct hil_arguments *a)
{
    if (a->options.boot0 && !a->options.type->rom_hears)
        return refuse("--boot0: the boot ROM of the board %s does not listen at its serial link; "
                      "such a board is programmed through its ST-LINK",
                      hil_board_type_name(a->options.type));
    return MR_OK;
}

/* ---- paths: nothing that is read or written elsewhere is written over ---- */

/* The path of a link or file with everything that can be resolved resolved; false: it has none. */
static bool canonical(const char *text, char *out)
{
    char folder[PATH_MAX], resolved[PATH_MAX];
    const char *path = !text || strcmp(text, "none") == 0                               ? NULL
                     : strncmp(text, "unix:", 5) == 0 || strncmp(text, "file:", 5) == 0 ? text + 5
                     : strncmp(text, "pty:", 4) == 0                                    ? text + 4
                                                                                        : text;
    if (!path || strlen(path) >= sizeof folder)
        return false;
    if (realpath(path, out))
        return true;
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    if (!realpath(folder, resolved))
        return false;
    return snprintf(out, PATH_MAX, "%s/%s", resolved, slash ? slash + 1 : path) < PATH_MAX;
}

/* By name, or as two names of one file. */
static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    return strcmp(a, b) == 0 || (stat(a, &one) == 0 && stat(b, &other) == 0 &&
                                 one.st_dev == other.st_dev && one.st_ino == other.st_ino);
}

/* A record takes the place of one of its kind only; what the first bytes of each are, the files say
 * that write them. */
static enum mr_status check_record(const struct hil_arguments *a, const char *option,
                                   const char *text, const char *path)
{
    const char *head = !text              ? NULL
                     : text == a->vcd     ? "$version matrig-board $end\n"
                     : text == a->profile ? "matrig-board profile: "
                     : text == a->margins ? "rule                  judged "
                                          : NULL;
    if (!head || !path[0])
        return MR_OK;
    if (hil_is_precious(path))
        return refuse("%s would overwrite a database or a program: %s; give another file", option,
                      path);
    if (!a->force && hil_is_another_file(path, head))
        return refuse("%s is there already, and is no record of this kind: %s; give another file, "
                      "or --force to lose this one",
                      option, path);
    return MR_OK;
}

struct named_path {
    const char *option, *text;
    char path[PATH_MAX];
};

/* The path itself, or none for what is not a file of its own. */
static void find_path(struct named_path *named)
{
    struct stat st;
    if (!canonical(named->text, named->path) ||
        (stat(named->path, &st) == 0 && S_ISCHR(st.st_mode)))
        named->path[0] = '\0';
}

enum { READ_ONLY = 4, PATHS = 12 }; /* read, and written too */

enum mr_status hil_arguments_check_paths(const struct hil_arguments *a)
{
    struct named_path given[PATHS] = {
        {"--elf", a->elf, ""},
        {"--rig", a->rig, ""},
        {"--replay", a->replay, ""},
        {"--faults", a->faults, ""},
        {"--can", a->can, ""},
        {"--serial", a->serial, ""},
        {"--gdb", a->gdb && strncmp(a->gdb, "unix:", 5) == 0 ? a->gdb : NULL, ""},
        {"--vcd", a->vcd, ""},
        {"--profile", a->profile, ""},
        {"--margins", a->margins, ""},
        {"--flash", a->flash, ""},
        {"--nor", a->nor, ""},
    };
    for (unsigned i = 0; i < PATHS; i++) {
        find_path(&given[i]);
        for (unsigned k = 0; i >= READ_ONLY && k < i; k++) {
            if (given[i].path[0] && given[k].path[0] && same_file(given[i].path, given[k].path))
                return refuse("%s and %s are both %s; give each its own", given[k].option,
                              given[i].option, given[i].path);
        }
        enum mr_status status = check_record(a, given[i].option, given[i].text, given[i].path);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}
