/* matrig board zero, shunt: zero and shunt calibration of a board's channels. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "host/base/answer.h"
#include "host/base/xmalloc.h"
#include "host/board/gage_client.h"
#include "host/commands/commands.h"

/* ---- what came ---- */

static void shunts_answer(const struct gage_client *talk, struct answer *answer)
{
    answer_table(answer, "shunts", "");
    for (unsigned i = 0; i < talk->shunts.count; i++) {
        const struct mr_shunt_result *r = &talk->shunts.result[i];
        const struct mr_shunt_check *c = &talk->shunts.check[i];
        answer_row(answer);
        answer_count(answer, "gage", "gage", r->gage);
        answer_value(answer, "span", "found", UNIT_TENSION, (double)r->span_lb, 3)->digits = 7;
        answer_value(answer, "expected", "of", UNIT_TENSION, (double)c->expected_lb, 2);
        answer_value(answer, "noise", "noise", UNIT_TENSION, (double)r->noise_lb, 3);
        answer_value(answer, "change", "change", UNIT_TENSION, (double)c->change_lb, 3)->plus =
            true;
        answer_value(answer, NULL, "at rest", UNIT_TENSION, (double)c->zero_change_lb, 3)->plus =
            true;
        answer_words(answer, "verdict", "verdict", "%s", shunts_verdict_text(r->verdict));
    }
    answer_close(answer);
}

static void zeros_answer(const struct gage_client *talk, struct answer *answer)
{
    answer_table(answer, "zeros", "");
    for (unsigned i = 0; i < talk->zeros; i++) {
        const struct mr_zero_result *z = &talk->zero[i];
        bool tension = z->index >= MR_TRANSDUCERS;
        answer_row(answer);
        answer_words(answer, NULL, "channel", "%s %u", tension ? "gage" : "transducer",
                     tension ? z->index - MR_TRANSDUCERS + 1u : z->index + 1u);
        answer_count(answer, "channel", NULL, z->index);
        answer_value(answer, "zero_code", "zero, codes", UNIT_NUMBER, (double)z->zero_code, 3)
            ->digits = 7;
        answer_value(answer, "spread_codes", "spread, codes", UNIT_NUMBER, (double)z->spread_codes,
                     2);
        answer_words(answer, "verdict", "verdict", "%s", mr_zero_verdict_text(z->verdict));
    }
    answer_close(answer);
}

static int tell(const struct cli *cli, const struct gage_client *talk, unsigned code)
{
    bool good = talk->ack.status == MR_OK;
    struct answer *answer = answer_new(cli->si);
    answer_flag(answer, "good", NULL, good);
    shunts_answer(talk, answer);
    zeros_answer(talk, answer);
    if (code != MR_COMMAND_SHUNT)
        answer_sentence(answer, NULL,
                        good
                            ? "these are the zeros now, until the board is reset or configured anew"
                            : "no zero was taken");
    return answer_show(cli, answer, good ? 0 : mr_status_exit_code(MR_LIMIT));
}

static int talk_to_board(const struct cli *cli, const char *serial, unsigned code, int32_t argument)
{
    struct error error = {0};
    struct dialogue dialogue;
    struct gage_client *talk = xcalloc(1, sizeof *talk);
    enum mr_status status = dialogue_open(&dialogue, NULL, serial, &error);
    if (status == MR_OK)
        status = gage_client_order(talk, &dialogue, code, argument, &error);
    dialogue_close(&dialogue);
    int exit_code = status == MR_OK ? tell(cli, talk, code) : cli_fail(&error);
    free(talk);
    return exit_code;
}

struct request {
    const char *serial;
};

static int gages_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    const char *words[2];
    struct error error = {0};
    double what = 0.0;
    enum mr_status status = command_parse(&command_board_gages, argc, argv, cli, &r, words, &error);
    bool zero = status == MR_OK && strcmp(words[0], "zero") == 0;
    if (status == MR_OK && words[1] && !zero)
        status = error_set(&error, MR_USAGE, "%s takes no number: '%s'; see matrig board --help",
                           words[0], words[1]);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "what to zero", 0, 2, &what, &error);
    if (status == MR_OK && what != floor(what))
        status = error_set(&error, MR_USAGE,
                           "what to zero: '%s'; 1 transducers, 2 gages, 0 or nothing both",
                           words[1]);
    if (status == MR_OK && !r.serial)
        status = error_set(&error, MR_USAGE,
                           "no link: matrig board %s needs --serial LINK; see matrig board --help",
                           words[0]);
    return status != MR_OK ? cli_fail(&error)
                           : talk_to_board(cli, r.serial, zero ? MR_COMMAND_ZERO : MR_COMMAND_SHUNT,
                                           (int32_t)what);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD("zero [1|2]",
              "mean of a quarter of a second is the zero of all channels, of the transducers (1) "
              "or the gages (2), until\n"
              "reset. None is taken when one moves, is not valid, or is a gage under tension: exit "
              "1"),
    HELP_WORD("shunt", "shunt calibration of the gages, a second; exit 1 when one is not good. "
                       "matrig log on the board's CAN\n"
                       "keeps it: the calibrations before and after a landing give its drift"),
    OPTION_TEXT("--serial", "LINK", serial, NULL),
};

/* Of matrig board. */
const struct command command_board_gages = {
    "board",
    gages_command,
    "zero [1|2] | shunt",
    "zero and shunt calibration",
    COMMAND_PARTS(parts),
    {1, 2, "zero [1|2] | shunt"},
};
