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
#include "hil/board/board.h"
#include "hil/core/state.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"

#define STALL_S 30.0

/* Beside enum hil_parity, in the order of the option's words. */
enum { PARITY_BOARD = 3, PARITY_NOT_GIVEN };

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
    *value = strncmp(text, "0x", 2) == 0 ? (double)strtoul(text, (char **)(uintptr_t)&end, 16)
                                         : mr_decimal_read(text, &end);
    return end != text && !*end && *value >= low && *value <= high;
}

/* Numbers between commas, of which the first must be there; how many, 0: none. */
static unsigned parse_list(const char *text, double value[3])
{
    for (unsigned n = 0; n < 3; n++) {
        const char *end;
        value[n] = mr_decimal_read(text, &end);
        if (end == text || (*end && *end != ','))
            return 0;
        if (!*end)
            return n + 1;
        text = end + 1;
    }
    return 0;
}

/* Which of "a|b|c" is it? -1: none. */
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

/* stop, count, off, or the rules that only count. */
static bool parse_rules(struct hil_arguments *a, const char *text)
{
    static const char some[] = "count:";
    int word = parse_word(text, "stop|count|off");
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

/* Degrees, and degrees per hour behind a comma. */
static bool parse_temperature(struct hil_arguments *a, const char *text)
{
    double value[3] = {(double)NAN, 0.0, 0.0};
    unsigned n = strcmp(text, "none") == 0 ? 1 : parse_list(text, value);
    a->options.temperature_c = value[0];
    a->options.temperature_c_per_h = value[1];
    return (n == 1 || n == 2) && !(value[0] < -60.0 || value[0] > 150.0) &&
           fabs(value[1]) <= 1000.0;
}

/* HZ[,DELAY_MS[,JITTER_US]] */
static bool parse_camera(struct hil_arguments *a, const char *text)
{
    double value[3] = {0.0, 0.0, 0.0};
    if (!parse_list(text, value))
        return false;
    a->options.camera_hz = value[0];
    a->options.camera_delay_ps = (uint64_t)(value[1] * (double)HIL_MS_PS);
    a->options.camera_jitter_ps = (uint64_t)(value[2] * (double)HIL_US_PS);
    return value[0] >= 0.01 && value[0] <= 1e5 && value[1] >= 0.0 && value[1] <= 1e6 &&
           value[2] >= 0.0 && value[2] <= 1e6;
}

static bool parse_board(struct hil_arguments *a, const char *text)
{
    a->options.type = hil_board_type_named(text);
    a->board_given = a->options.type != NULL;
    return a->board_given;
}

static bool parse_seed(struct hil_arguments *a, const char *text)
{
    char *end;
    errno = 0;
    a->options.seed = strtoull(text, &end, 10);
    return end != text && !*end && !errno && text[0] != '-';
}

static bool parse_board_seed(struct hil_arguments *a, const char *text)
{
    uint64_t seed = a->options.seed;
    bool good = a->options.board_drawn = parse_seed(a, text);
    a->options.board_seed = a->options.seed;
    a->options.seed = seed;
    return good;
}

/* ---- options and help ---- */

/* What an option is, and where it goes. FLAG: without a value; WORD: by its place in `words`; OWN:
 * by a function. */
enum kind { FLAG, TEXT, REAL, UNSIGNED, SIGNED, WORD, OWN };

static const struct option {
    const char *name, *value; /* value: what the help calls it */
    enum kind kind;
    size_t place;      /* in struct hil_arguments */
    double low, high;  /* of a number */
    const char *words; /* "a|b|c" */
    bool (*parse)(struct hil_arguments *a, const char *text);
    const char *help;
} options[] = {
#define AT(member) offsetof(struct hil_arguments, member)
#define OF_TEXT(name, value, member, help)                    \
    {                                                         \
        name, value, TEXT, AT(member), 0, 0, NULL, NULL, help \
    }
#define OF_FLAG(name, member, help)                        \
    {                                                      \
        name, "", FLAG, AT(member), 0, 0, NULL, NULL, help \
    }
#define OF_NUMBER(name, value, kind, member, low, high, help)      \
    {                                                              \
        name, value, kind, AT(member), low, high, NULL, NULL, help \
    }
#define OF_WORD(name, value, member, words, help)              \
    {                                                          \
        name, value, WORD, AT(member), 0, 0, words, NULL, help \
    }
#define OF_OWN(name, value, parse, help)             \
    {                                                \
        name, value, OWN, 0, 0, 0, NULL, parse, help \
    }
    OF_TEXT("--elf", "F", elf, "firmware image (ELF); else the one that came with matrig-board"),
    OF_OWN("--board", "B", parse_board,
           "which board it is, by the name in common/boards.def: zg, discovery ...; else\n"
           "what the image says (default zg)"),
    OF_TEXT("--can", "LINK", can,
            "unix:PATH (16-byte frames), file:PATH (candump -L text) or none"),
    OF_TEXT("--serial", "LINK", serial,
            "unix:PATH (bytes), file:PATH, pty:PATH (a terminal that any program opens) or none"),
    OF_NUMBER("--can-base", "N", UNSIGNED, options.can_base, 0, MR_CAN_BASE_MOST,
              "the base of the board's CAN identifiers, as its configuration has it (default 0): "
              "CAN commands of\n"
              "the run file or record are sent to it"),
    OF_WORD("--parity", "P", parity, "none|even|odd|board",
            "of the serial line's other end: none, even, odd or board (what the board has);\n"
            "default none, pty: board, for Linux keeps no parity for pseudo-terminals"),
    OF_NUMBER("--baud", "N", UNSIGNED, options.host_baud, 1200, 10e6,
              "rate of the serial line's other end (default 2000000; pty: what is set there)"),
    OF_TEXT("--rig", "RUNFILE", rig,
            "what the rig does: a matrig-run file; without it nothing moves"),
    OF_TEXT("--replay", "FILE", replay,
            "instead of a rig, a recorded landing: a matrig-replay file, which matrig replay "
            "writes"),
    OF_WORD("--speed", "S", speed, "max|real",
            "max: at full speed, waiting for a slow host (default); real: by the wall clock, "
            "dropping"),
    OF_OWN("--camera", "HZ[,DELAY_MS[,JITTER_US]]", parse_camera,
           "a film camera: triggered by PE2, after DELAY_MS (default 0) it gives a pulse\n"
           "a frame on PB3"),
    OF_NUMBER("--for", "S", REAL, for_s, 1e-6, HIL_FOREVER_S,
              "seconds of virtual time (default: the run file's duration, or until a signal)"),
    OF_OWN("--seed", "N", parse_seed, "of converter noise (default 1)"),
    OF_NUMBER("--vdda", "V", REAL, options.vdda_v, 2.7, 3.6,
              "supply of converters and staircase, 2.7 to 3.6 (default: the board's); what is\n"
              "relative to it: hil/README.md"),
    OF_OWN("--board-seed", "N", parse_board_seed,
           "draw the board's electronics (gains, zeros, noise, INL, kick, resistors) from the "
           "spread of the\n"
           "reference circuits; the same N, the same board (default: the ideal board)"),
    OF_NUMBER("--hse", "HZ", UNSIGNED, options.hse_hz, 0, 26e6,
              "crystal, 0: it does not start (default 8000000)"),
    OF_NUMBER("--hsi-ppm", "N", SIGNED, options.hsi_error_ppm, -50000, 50000,
              "error of the internal oscillator (default 0)"),
    OF_NUMBER("--lsi", "HZ", UNSIGNED, options.lsi_hz, 17000, 47000,
              "watchdog clock, 17000 to 47000 (default 32000)"),
    OF_TEXT("--flash", "FILE", flash,
            "content of the flash: read if it is there, written at the end; --elf then goes over "
            "it,\n"
            "sparing the sectors it does not use"),
    OF_TEXT("--nor", "FILE", nor, "the same for the black box's memory"),
    OF_OWN("--temperature", "C[,C/h]", parse_temperature,
           "of the mat, in degrees and how fast it rises, or none: no thermometer (default 20)"),
    OF_FLAG("--bare", options.bare,
            "nothing is plugged in where the rig is: the lines of one-shot, lamp and camera are "
            "open"),
    OF_FLAG("--left-on", options.left_on,
            "start as after a jump, without a reset: PLL and clocks on, as a debugger leaves them"),
    OF_FLAG("--boot0", options.boot0,
            "start the boot ROM (AN3155 on the serial line) instead of the firmware"),
    OF_WORD("--times", "T", options.cell_times, "spread|typical|max",
            "of flash and NOR operations: spread (drawn, default), typical or max"),
    OF_TEXT("--faults", "FILE", faults,
            "what goes wrong and when: a matrig-faults file (hil/README.md); told on stderr"),
    OF_FLAG("--alignment", options.watch_alignment,
            "fault on unaligned multiple and double transfers, as silicon does; slower"),
    OF_OWN("--rules", "R", parse_rules,
           "what a broken rule of time or electricity at the pins does: stop (default), count,\n"
           "count:NAME,... (of these alone), or off: they are not looked at"),
    OF_TEXT("--margins", "FILE", margins,
            "what was measured of each rule: how often, the nearest to its number, where"),
    OF_FLAG("--trace", trace, "tell exceptions and unusual events on stderr"),
    OF_TEXT("--gdb", "PORT", gdb,
            "listen for gdb on this port of 127.0.0.1 (0: any; it is told) or at unix:PATH, and "
            "wait for it"),
    OF_TEXT("--vcd", "FILE", vcd,
            "trace of pins, converters, links, exceptions and sleep, for GTKWave and "
            "others"),
    OF_TEXT("--profile", "FILE", profile, "instructions by function"),
    OF_NUMBER("--stall", "S", REAL, stall_s, 0.001, 86400,
              "end when a host does not read for S seconds (default 30)"),
    OF_NUMBER("--wall-limit", "S", REAL, wall_limit_s, 0, 1e6,
              "end after S seconds of wall clock (default 600 more than the run's own length; "
              "none\n"
              "for a run without end or with --gdb)"),
#undef AT
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

void hil_arguments_help(void)
{
    puts("usage: matrig-board [--elf F] [--can LINK] [--serial LINK] [--rig RUNFILE] [options]\n"
         "       matrig-board --flash F | --boot0 [options]\n"
         "The STM32F407 board in virtual time, running the firmware image F unmodified.");
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        print_item(options[i].name, options[i].value, options[i].help);
    print_item("--version", "", "print the version, and end");
    puts("A unix: link is listened on; virtual time starts when a host has connected to each, and "
         "gdb, within 30 s. At\n"
         "full speed it stands still when nobody has had the pty: open for 50 ms, for at most 30 "
         "s.\n"
         "Exit: 0 ok, 2 usage, 3 link, board or firmware failed, 4 malformed or truncated input.");
}

static enum mr_status refuse_board(const char *text)
{
    char names[200] = "";
    for (unsigned i = 0; hil_board_type_of(i); i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), " %s",
                 hil_board_type_name(hil_board_type_of(i)));
    return refuse("--board cannot be `%s`; there are:%s", text, names);
}

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
    int word = option->kind == WORD ? parse_word(text, option->words) : 0;
    bool is_number = option->kind == REAL || option->kind == UNSIGNED || option->kind == SIGNED;
    if (word < 0 || (is_number && !parse_number(text, option->low, option->high, &value)))
        return false;
    switch (option->kind) {
    case FLAG: *(bool *)place = true; break;
    case TEXT: *(const char **)place = text; break;
    case REAL: *(double *)place = value; break;
    case UNSIGNED: *(uint32_t *)place = (uint32_t)value; break;
    case SIGNED: *(int32_t *)place = (int32_t)value; break;
    case WORD: *(unsigned *)place = (unsigned)word; break;
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
                                .parity = PARITY_NOT_GIVEN,
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
    if (a->parity == PARITY_NOT_GIVEN)
        a->parity = strncmp(a->serial, "pty:", 4) == 0 ? PARITY_BOARD : HIL_PARITY_NONE;
    a->options.host_parity_follows = a->parity == PARITY_BOARD;
    a->options.host_parity = a->parity == PARITY_BOARD ? HIL_PARITY_NONE
                                                       : (enum hil_parity)a->parity;
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

/* The path of a link or file; NULL: it has none. */
static const char *path_of(const char *text)
{
    if (!text || strcmp(text, "none") == 0)
        return NULL;
    return strncmp(text, "unix:", 5) == 0 || strncmp(text, "file:", 5) == 0 ? text + 5
         : strncmp(text, "pty:", 4) == 0                                    ? text + 4
                                                                            : text;
}

/* By name, or as two names of one file, but a device. */
static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    bool there = stat(a, &one) == 0;
    if (there && S_ISCHR(one.st_mode))
        return false;
    return strcmp(a, b) == 0 || (there && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
                                 one.st_ino == other.st_ino);
}

enum { READ_ONLY = 4, RECORDS = 7, MEMORIES = 10, PATHS = 12 };

enum mr_status hil_arguments_check_paths(const struct hil_arguments *a)
{
    const struct {
        const char *option, *path;
    } given[PATHS] = {
        {"--elf", a->elf},
        {"--rig", a->rig},
        {"--replay", a->replay},
        {"--faults", a->faults},
        {"--can", path_of(a->can)},
        {"--serial", path_of(a->serial)},
        {"--gdb", a->gdb && strncmp(a->gdb, "unix:", 5) == 0 ? path_of(a->gdb) : NULL},
        {"--vcd", a->vcd},
        {"--profile", a->profile},
        {"--margins", a->margins},
        {"--flash", a->flash},
        {"--nor", a->nor},
    };
    for (unsigned i = READ_ONLY; i < PATHS; i++) {
        for (unsigned k = 0; given[i].path && k < i; k++) {
            if (given[k].path && same_file(given[i].path, given[k].path))
                return refuse("%s and %s are both %s; give each its own", given[k].option,
                              given[i].option, given[i].path);
        }
        if (given[i].path && i >= RECORDS && i < MEMORIES && hil_is_precious(given[i].path))
            return refuse("%s would overwrite a database or a program: %s; give another file",
                          given[i].option, given[i].path);
    }
    return MR_OK;
}
