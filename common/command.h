/* Commands to the board, by name: what the host sends, what a run file scripts, what the firmware
 * obeys.
 *
 * A command is one `command` message (catalogue.def); this table gives its codes, names and the
 * meaning of its argument. */
#ifndef MATRIG_COMMON_COMMAND_H
#define MATRIG_COMMON_COMMAND_H

#include "common/catalogue.h"

/*        NAME     code  text      index          argument per unit, meaning */
/* clang-format off */
#define MR_COMMAND_TABLE(X)                                                                        \
    X(STATE,        1,  "state",   0, 1,     "say hello, state and the whole configuration")       \
    X(ARM,          2,  "arm",     0, 1, "arm for a landing; argument: its number, 0 counts on")   \
    X(DISARM,       3,  "disarm",  0, 1,     "back to idle")                                       \
    X(MARK,         4,  "mark",    0, 1,     "mark this moment; argument: a number")               \
    X(SURVEY,       5,  "survey",  1, 10000, "index: segment from 0; argument: its slack, 0.0001 " \
      "in")                                                                                        \
    X(BOOTROM,      6,  "bootrom", 0, 1, "restart into the boot ROM, for flashing; not from arm "  \
      "to done")                                                                                   \
    X(RESET,        7,  "reset",   0, 1,     "restart; not from arm to done")                      \
    X(SELF_TEST,    8,  "self-test", 0, 1, "memory, reference, excitation, black box, warning "    \
      "lamp; not from arm to done")                                                                \
    X(ZERO,         9, "zero",    0, 1, "mean of 256 blocks is the zero: 0 all, 1 transducers, 2 " \
      "gages; refused when one moves; idle. Index n from 1: the argument's bits, IEEE 754, are "   \
      "the zero of channel n - 1")                                                                 \
    X(SHUNT,       10, "shunt",   0, 1,     "shunt calibration of the gages, 0.9 s; idle")         \
    X(CONFIG_APPLY, 11, "config-apply", 0, 1, "take the configuration sent before into force; "    \
      "argument: its CRC; not from arm to done")                                                   \
    X(CONFIG_READ, 12, "config-read", 0, 1, "tell the configuration in force; argument: word to "  \
      "begin at; not from arm to done")                                                            \
    X(CAMERA,      13, "camera",  0, 1,     "trigger the camera")                                  \
    X(LIVE,        14, "live",    0, 1, "tell edges, and a block record each 20 ms on serial, "    \
      "for so many seconds, 60 at most; 0: no more; idle")                                         \
    X(BACKLOG,     15, "backlog", 0, 1, "so many blocks waited for the predictor, as in the "      \
      "landing that is replayed; no ack when taken")                                               \
    X(BOX_LIST,    16, "box-list", 0, 1,     "tell the records of the black box")                  \
    X(BOX_READ,    17, "box-read", 0, 1, "read one out over serial; argument: its number * 32768 " \
      "+ page to begin at; idle")                                                                  \
    X(BOX_FREE,    18, "box-free", 0, 1, "give a record's space back; argument: its number; idle") \
    X(RUNWAY_FORGET, 20, "runway-forget", 0, 1, "the predictor's runway is one that nobody has "   \
      "measured; not from arm to done")                                                            \
    X(RUNWAY_READ, 21, "runway-read", 0, 1,  "tell the predictor's runway; not from arm to done")  \
    X(RUNWAY_JOINTS, 22, "runway-joints", 1, 1, "index n: openings of joints 2 n + 1, lower 16 "   \
      "bits of the argument, and 2 n + 2, 0.01 mil, of a runway to be taken; not from arm to "     \
      "done")                                                                                      \
    X(RUNWAY_WORD, 23, "runway-word", 1, 1, "of a runway to be taken, index 0: bits of the "       \
      "resistance found, IEEE 754; 1: landings; 2: opening of joint 513, 0.01 mil; not from arm "  \
      "to done")                                                                                   \
    X(RUNWAY_TAKE, 24, "runway-take", 0, 1, "take the runway given before; argument: its CRC-32; " \
      "not from arm to done")                                                                      \
    X(CHART_WORD,  25, "chart-word", 1, 1, "index: number of a chart and plan to be taken; "       \
      "argument: its bits, IEEE 754; numbers that are not given are missing; not from arm to "     \
      "done")                                                                                      \
    X(CHART_TAKE,  26, "chart-take", 0, 1, "take the chart given before, for the landing to come; "\
      "argument: its CRC-32; not from arm to done")                                                \
    X(CHART_FORGET, 27, "chart-forget", 0, 1, "no chart and no plan; not from arm to done")
/* clang-format on */

enum mr_command_code {
#define MR_COMMAND_ENUM(NAME, code, text, indexed, per_unit, meaning) MR_COMMAND_##NAME = (code),
    MR_COMMAND_TABLE(MR_COMMAND_ENUM)
#undef MR_COMMAND_ENUM
};

/* Parse one command as people write it: `arm 5`, `survey 12 0.305` (segment, inches), `mark 1`,
 * `state`. Numbers are in the units a person uses; a missing argument is 0. `tag` goes into the
 * message. MR_OK; MR_UNKNOWN: no such command; MR_USAGE: words missing, left over, not a number or
 * out of range. */
enum mr_status mr_command_parse(const char *words, uint16_t tag, struct mr_command *command);

/* Name of a command code, or "unknown". Static storage. */
const char *mr_command_name(unsigned code);

#endif
