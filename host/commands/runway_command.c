/* matrig board runway: what a board's predictor knows of the runway: show it, give it one from a
 * file, make it forget. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/answer.h"
#include "host/board/runway_client.h"
#include "host/commands/commands.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"

#define HMIL_PER_IN 100000.0
#define ACROSS      7u   /* slacks in a row of the table */
#define CLOSED_HMIL 200u /* 0.002 in, as the predictor has it */

/* --- what is printed --- */

static const char *copy_text(unsigned copy, char out[40])
{
    if (copy == MR_RUNWAY_WHOLE || copy >= MR_RUNWAY_UNREAD)
        return mr_runway_copy_text(copy);
    snprintf(out, 40, "damaged (%s)", mr_status_text((enum mr_status) - (int)copy));
    return out;
}

static double sum_in(const struct mr_predictor_state *state, unsigned segment)
{
    unsigned sum = 0;
    for (unsigned j = 10 * segment; j < 10 * segment + 10 && j <= state->mats; j++)
        sum += state->gap_hmil[j];
    return sum / HMIL_PER_IN;
}

static unsigned closed_of(const struct mr_predictor_state *state)
{
    unsigned closed = 0;
    for (unsigned j = 0; j <= state->mats; j++)
        closed += state->gap_hmil[j] <= CLOSED_HMIL;
    return closed;
}

static int print(const struct runway_client *talk, const struct cli *cli)
{
    const struct mr_predictor_state *state = &talk->state;
    const struct mr_runway_store *stored = &talk->stored;
    struct answer *answer = answer_new(cli->si);
    char a[40], b[40];
    answer_words(answer, "source", "runway", "%s", mr_runway_source_text(stored->source));
    answer_count(answer, "mats", "mats", state->mats);
    answer_count(answer, "landings", "landings", state->landings);
    answer_value(answer, "resistance", "resistance", UNIT_NUMBER, (double)state->scale, 2)->end =
        " of the closing resistance configured";
    answer_count(answer, "crc", NULL, (int64_t)stored->crc);
    answer_words(answer, NULL, "CRC", "%08x", (unsigned)stored->crc);
    answer_words(answer, "copy_a", "copy A", "%s", copy_text(stored->copy_a, a));
    answer_words(answer, "copy_b", "copy B", "%s", copy_text(stored->copy_b, b));
    answer_count(answer, "closed_joints", NULL, closed_of(state));
    answer_words(answer, NULL, "joints", "%u of %u closed to 0.002 in", closed_of(state),
                 state->mats + 1u);
    answer_list(answer, "gap_in", NULL);
    for (unsigned j = 0; j <= state->mats; j++)
        answer_value(answer, NULL, NULL, UNIT_NUMBER, state->gap_hmil[j] / HMIL_PER_IN, 5);
    answer_close(answer);
    answer_table(answer, NULL, "openings of ten joints in a row, from the first that is named on");
    for (unsigned s = 0; 10 * s <= state->mats; s += ACROSS) {
        answer_row(answer);
        answer_count(answer, NULL, "joint", 10 * s + 1);
        for (unsigned i = 0; i < ACROSS && 10 * (s + i) <= state->mats; i++) {
            char label[12];
            snprintf(label, sizeof label, "+%u", 10 * i);
            answer_value(answer, NULL, label, UNIT_DISPLACEMENT, sum_in(state, s + i), 4);
        }
    }
    answer_close(answer);
    return answer_show(cli, answer, 0);
}

static enum mr_status write_file(const char *path, const struct mr_predictor_state *state,
                                 struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    FILE *file = output.file;
    fprintf(file,
            "# A board's runway: openings of its joints in inches, upfield first. matrig board "
            "runway load gives it to a board.\n"
            "mats %u\nlandings %u\nresistance %.9g\n",
            state->mats, state->landings, (double)state->scale);
    for (unsigned j = 0; j <= state->mats; j++)
        fprintf(file, "joint %u %.5f\n", j + 1u, state->gap_hmil[j] / HMIL_PER_IN);
    return output_end(&output, error);
}

/* One line of the file; false: it is none. */
static bool take_line(const char *line, struct mr_predictor_state *state, bool *given)
{
    unsigned number;
    double value;
    char rest;
    if (line[0] == '#' || strspn(line, " \t\r\n") == strlen(line))
        return true;
    if (sscanf(line, "mats %u %c", &number, &rest) == 1 && number >= 1 && number <= MR_CHAIN_MATS)
        return state->mats = (uint16_t)number, true;
    if (sscanf(line, "landings %u %c", &number, &rest) == 1 && number <= UINT16_MAX)
        return state->landings = (uint16_t)number, true;
    if (sscanf(line, "resistance %lf %c", &value, &rest) == 1 && isfinite(value))
        return state->scale = (float)value, true;
    struct quantity_wrong wrong;
    int used = 0;
    if (sscanf(line, "joint %u %n", &number, &used) != 1 || !used || number < 1 ||
        number > MR_RUNWAY_JOINTS || !quantity_parse(line + used, "in", NULL, &value, &wrong) ||
        !(value >= 0.0 && value * HMIL_PER_IN <= UINT16_MAX) || given[number - 1u])
        return false;
    given[number - 1u] = true;
    state->gap_hmil[number - 1u] = (uint16_t)lround(value * HMIL_PER_IN);
    return true;
}

static enum mr_status read_file(const char *path, struct mr_predictor_state *state,
                                struct error *error)
{
    bool given[MR_RUNWAY_JOINTS] = {false};
    char line[200];
    unsigned number = 0, joints = 0;
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO,
                         "cannot be read (%s): %s; matrig board runway -o FILE makes one",
                         strerror(errno), path);
    *state = (struct mr_predictor_state){.scale = 1.0f};
    enum mr_status status = MR_OK;
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        number++;
        if (!take_line(line, state, given))
            status = error_set(error, MR_MALFORMED,
                               "no line of a runway: `%.*s`: %s:%u; joint NUMBER INCHES (or with a "
                               "unit: 2 mm), each once",
                               (int)strcspn(line, "\r\n"), line, path, number);
    }
    fclose(file);
    for (unsigned j = 0; j < MR_RUNWAY_JOINTS; j++)
        joints += given[j];
    if (status == MR_OK && (state->mats == 0 || joints != state->mats + 1u))
        status = error_set(
            error, MR_MALFORMED,
            "%u joints of %u mats: %s; it must say its mats, and each joint from 1 to mats + 1",
            joints, state->mats, path);
    return status;
}

/* `state`: to be given. */
static enum mr_status do_verb(struct runway_client *talk, struct dialogue *dialogue,
                              const char *verb, const struct mr_predictor_state *state,
                              const char *out, struct error *error)
{
    enum mr_status status = runway_client_begin(talk, dialogue, error);
    if (status == MR_OK && strcmp(verb, "load") == 0)
        status = runway_client_give(talk, state, error);
    if (status == MR_OK && strcmp(verb, "forget") == 0)
        status = runway_client_forget(talk, error);
    if (status == MR_OK)
        status = runway_client_read(talk, error);
    return status == MR_OK && out ? write_file(out, &talk->state, error) : status;
}

struct request {
    const char *serial, *out;
    bool force;
};

static int runway_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[3];
    struct request r = {0};
    struct mr_predictor_state state;
    struct error error = {0};
    enum mr_status status = command_parse(&command_board_runway, argc, argv, cli, &r, words,
                                          &error);
    const char *verb = status == MR_OK && words[1] ? words[1] : "show";
    bool load = strcmp(verb, "load") == 0;
    if (status == MR_OK && strcmp(words[0], "runway") != 0)
        status = error_set(&error, MR_USAGE,
                           "one thing at a time: '%s' and runway; see matrig board --help",
                           words[0]);
    if (status == MR_OK && !load && strcmp(verb, "show") != 0 && strcmp(verb, "forget") != 0)
        status = error_set(&error, MR_USAGE,
                           "not show, load or forget: '%s'; see matrig board --help", verb);
    if (status == MR_OK && load != (words[2] != NULL))
        status = error_set(&error, MR_USAGE,
                           load ? "which runway? matrig board runway load needs a FILE"
                                : "a FILE is load's: '%s'",
                           words[2]);
    if (status == MR_OK && !r.serial)
        status =
            error_set(&error, MR_USAGE,
                      "no link: matrig board runway needs --serial LINK; see matrig board --help");
    if (status == MR_OK && load)
        status = read_file(words[2], &state, &error);
    if (status == MR_OK)
        status = output_keep(r.out, r.force, &error);
    if (status == MR_OK)
        status = output_check(r.out, words[2], &error);
    if (status != MR_OK)
        return cli_fail(&error);
    struct dialogue dialogue;
    struct runway_client *talk = xcalloc(1, sizeof *talk);
    status = dialogue_open(&dialogue, NULL, r.serial, &error);
    if (status == MR_OK)
        status = do_verb(talk, &dialogue, verb, &state, r.out, &error);
    dialogue_close(&dialogue);
    int exit_code = status == MR_OK ? print(talk, cli) : cli_fail(&error);
    free(talk);
    return exit_code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD("runway", "what the board's predictor knows of the runway: landings, joints, where "
                        "it comes from; -o writes it to a file.\n"
                        "load F gives the board that of a file, forget: nobody has measured it. "
                        "Not from arm to done.\n"
                        "matrig board --serial serial:/dev/ttyUSB0 runway -o before.txt"),
    OPTION_TEXT("--serial", "LINK", serial, NULL),
    OPTION_TEXT("-o", "FILE", out, NULL),
    OPTION_FLAG("--force", force, NULL),
};

/* Of matrig board. */
const struct command command_board_runway = {
    "board",
    runway_command,
    "runway [show|load FILE|forget]",
    "what the predictor knows of the runway",
    COMMAND_PARTS(parts),
    {1, 3, "runway [show|load FILE|forget]"},
};
