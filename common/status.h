/* Status codes shared by board, emulated board and host.
 *
 * 0 is success; errors are negative, so a count or a length can share the return value. Each status
 * has one text (mr_status_text) and one process exit code (mr_status_exit_code), so a failure has
 * the same text and exit code in every program. Run-time faults of the board are counters (message
 * `health`), not statuses. */
#ifndef MATRIG_COMMON_STATUS_H
#define MATRIG_COMMON_STATUS_H

/*        name             value  exit  text */
/* clang-format off */
#define MR_STATUS_TABLE(X)                                                                       \
    X(MR_OK,                 0,   0,   "ok")                                                     \
    X(MR_LIMIT,             -1,   1,   "a comparison failed or a limit was not met")             \
    X(MR_USAGE,             -2,   2,   "wrong usage")                                            \
    X(MR_IO,                -3,   3,   "input or output failed")                                 \
    X(MR_TIMEOUT,           -4,   3,   "nothing received within the time allowed")               \
    X(MR_CLOSED,            -5,   3,   "the other side closed the link")                         \
    X(MR_MALFORMED,         -6,   4,   "malformed input")                                        \
    X(MR_TRUNCATED,         -7,   4,   "input ends too early")                                   \
    X(MR_CRC,               -8,   4,   "checksum does not match")                                \
    X(MR_VERSION,           -9,   4,   "made by a different version")                            \
    X(MR_TOO_LONG,         -10,   4,   "longer than the format allows")                          \
    X(MR_NUMERICS,         -11,   5,   "a calculation was refused or failed")                    \
    X(MR_TOO_FEW,          -12,   5,   "too few values for a result")                            \
    X(MR_NOT_NOW,          -13,   2,   "not allowed in the present state")                       \
    X(MR_UNKNOWN,          -14,   2,   "unknown name or number")                                 \
    X(MR_FULL,             -15,   3,   "no room left")                                           \
    X(MR_UNMODELLED,       -16,   3,   "the emulated board does not model this")                 \
    X(MR_HALTED,           -17,   3,   "the processor has halted")                               \
    X(MR_WAIT,             -18,   3,   "not ready yet: try again later")                         \
    X(MR_CABLE,            -19,   2,   "only over serial, or over CAN with the maintenance jumper")\
    X(MR_JUMPER,           -20,   2,   "only over serial and with the maintenance jumper")       \
    X(MR_REPLAY,           -21,   2,   "accepted only in a replay")                              \
    X(MR_PROOF,            -22,   2,   "the command needs the board's key")                      \
    X(MR_LOCKOUT,          -23,   2,   "too many wrong proofs on this link: wait a second")
/* clang-format on */

enum mr_status {
#define MR_STATUS_ENUM(name, value, exit_code, text) name = (value),
    MR_STATUS_TABLE(MR_STATUS_ENUM)
#undef MR_STATUS_ENUM
};

/* Exit codes of the programs, and what each means. */
#define MR_EXIT_TABLE(X)                               \
    X(0, "success")                                    \
    X(1, "a comparison failed or a limit was not met") \
    X(2, "wrong usage")                                \
    X(3, "input, output or a device failed")           \
    X(4, "malformed or truncated input")               \
    X(5, "a calculation was refused or failed")

/* Text of a status, without capital or full stop; "unknown status" for a value not in the table.
 * Static storage. */
const char *mr_status_text(enum mr_status status);

/* Process exit code of a status, 0..5 (docs/reference/exit-codes.md); 3 for a value not in the
 * table. */
int mr_status_exit_code(enum mr_status status);

#endif
