/* Golden landings: what the board was given, and what it said, as text by name in engineering
 * units.
 *
 * Nothing in these files depends on the wire: no identifier, no offset, no scale, no layout number.
 * A file that was recorded before a message was repacked is still the truth afterwards. Both files
 * are gzip.
 *
 * LANDING.vN.given.gz, what the board took in (also what hil/rig/replay.h wants):
 *
 *     matrig-golden-given 1
 *     uid W W W                              identity of the board, 8 hex digits each
 *     crystal 1                              0: the crystal did not start
 *     config N                               the configuration: N lines by name, with units
 *                                            (host/board/config_text.h)
 *     survey BLOCK TAG SEGMENT INCHES        a command by name, with its argument in the unit that
 *                                            people use
 *     runway BLOCK TAG SCALE LANDINGS MATS   the predictor's runway when armed; then the openings
 *                                            of its joints
 *     joints_in O O O ...                    inches
 *     zero BLOCK TAG CHANNEL CODE            a measured zero, codes
 *     command BLOCK TAG NAME INDEX ARGUMENT  any other
 *     edge TICK                              a switch; TICK and film frames in 1/84 us since TIM2
 *                                            began
 *     frame TICK
 *     blocks FIRST TICK COUNT ABSENT         block records, 1 ms each: index and tick of the first,
 *                                            mask of channels not fitted
 *     D D D ...                              sums of codes: 8 transducers forward, 8 reversed, 14
 *                                            gages, staircase, reference; each the change since the
 *                                            row before; then `lC:N` and `hC:N`, saturated codes of
 *                                            channel C
 *     end
 *
 * LANDING.vN.said.gz, what it said, each message by its name:
 *
 *     matrig-golden-said 1
 *     message LINK NAME ROWS own|near        LINK serial or CAN; own: a message tells its own block
 *     field NAME STEP UNIT                   STEP is the field's resolution when recorded; 0:
 *                                            single precision
 *     A V V V ...                            A: block, as the change since the row before; a value
 *                                            for each field; - is missing
 *     end */
#ifndef MATRIG_TESTS_GOLDEN_GOLDEN_H
#define MATRIG_TESTS_GOLDEN_GOLDEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/predictor.h"

#define GOLDEN_FIELDS 8u
#define GOLDEN_NAME   48u

enum golden_link { GOLDEN_SERIAL, GOLDEN_CAN, GOLDEN_LINKS };
extern const char *const golden_link_text[GOLDEN_LINKS];

struct golden_command {
    long block;
    unsigned tag, index;
    char name[GOLDEN_NAME];
    double argument; /* survey: in; zero: codes; else as sent */
};

struct golden_given {
    uint32_t uid[3];
    int crystal;
    char *config; /* text */
    struct golden_command *command;
    size_t commands;
    bool has_runway;
    long runway_block;
    unsigned runway_tag;
    struct mr_predictor_state runway;
    uint64_t *edge, *frame;
    size_t edges, frames;
    struct mr_block *block;
    size_t blocks;
};

struct golden_field {
    char name[GOLDEN_NAME], unit[24];
    double step;
};

struct golden_row {
    long at;
    double value[GOLDEN_FIELDS];
};

struct golden_kind { /* one message on one link */
    enum golden_link link;
    char name[GOLDEN_NAME];
    bool own_block;
    struct golden_field field[GOLDEN_FIELDS];
    unsigned fields;
    struct golden_row *row;
    size_t rows;
};

struct golden_said {
    struct golden_kind *kind;
    size_t kinds;
};

/* All of these end the program with a line on stderr when a file cannot be read, written or
 * understood (exit codes 3 and 4). */
__attribute__((format(printf, 2, 3), noreturn)) void golden_fail(int code, const char *format, ...);
void *golden_grow(void *array, size_t count, size_t size); /* room for one more */

/* From a campaign, by way of a replay file at `scratch_path`. */
void given_take(struct golden_given *given, const char *db, long run, const char *scratch_path);
void given_write(const struct golden_given *given, const char *path);
void given_read(struct golden_given *given, const char *path);
void given_replay(const struct golden_given *given, const char *replay_path);
/* The built-in configuration as text, which the landing must have been recorded under; into copy A
 * of the board's flash. */
char *given_config_take(uint32_t crc);
void given_config_flash(const char *given, const char *flash_path);

/* From what matrig-board left of its links. Block records must come back as they were given: false,
 * and a line on stdout, when not. */
bool said_take(struct golden_said *said, const struct golden_given *given, const char *can_path,
               const char *serial_path);
void said_write(const struct golden_said *said, const char *path);
void said_read(struct golden_said *said, const char *path);
/* Tells what differs, the first in time first. How many message fields do. `brief`: their names
 * alone. */
unsigned said_compare(const struct golden_said *was, const struct golden_said *is, bool brief);

/* Why a field is not compared; NULL: it is. `field` NULL: the whole message. */
const char *golden_excluded(const char *message, const char *field);
void golden_tell_excluded(void);

#endif
