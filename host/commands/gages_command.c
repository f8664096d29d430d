/* matrig gages: zero and shunt calibration of a board's channels, and what a bridge should be
 * configured as. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/bridge.h"
#include "common/command.h"
#include "host/base/answer.h"
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
    struct gage_client *talk = calloc(1, sizeof *talk);
    if (!talk)
        abort();
    enum mr_status status = dialogue_open(&dialogue, NULL, serial, &error);
    if (status == MR_OK)
        status = gage_client_order(talk, &dialogue, code, argument, &error);
    dialogue_close(&dialogue);
    int exit_code = status == MR_OK ? tell(cli, talk, code) : cli_fail(&error);
    free(talk);
    return exit_code;
}

/* ---- a bridge ---- */

struct request {
    const char *serial;
    struct mr_bridge bridge; /* NaN: not given */
};

struct bridge_number {
    const char *option, *what;
    double *value, standard; /* NaN: it must be given */
};

static int tell_bridge(const struct cli *cli, const struct mr_bridge *bridge)
{
    double lb_per_code = mr_bridge_lb_per_code(bridge), shunt_lb = mr_bridge_shunt_lb(bridge);
    struct answer *answer = answer_new(cli->si);
    answer_value(answer, "lb_per_code", "gain", UNIT_NUMBER, lb_per_code, 6)->end = " lb per code";
    answer_value(answer, NULL, "amplifier", UNIT_NUMBER,
                 1e3 * MR_ADC_V / MR_ADC_CODES / lb_per_code, 5)
        ->end = " mV per lb behind it";
    if (isnan(shunt_lb))
        answer_none(answer, "shunt_lb", NULL, NULL);
    else
        answer_value(answer, "shunt_lb", "the shunt", UNIT_NUMBER, shunt_lb, 2)->end =
            " lb, for which it stands";
    return answer_show(cli, answer, 0);
}

/* What is not given gets its standard, or is missing; of another word than bridge nothing may be
 * given. */
static enum mr_status check_bridge(struct mr_bridge *bridge, const char *word, bool physics,
                                   struct error *error)
{
    const struct bridge_number number[] = {
        {"--excitation", "the excitation, V", &bridge->excitation_v, (double)NAN},
        {"--gain", "the amplifier's gain", &bridge->amplifier_gain, (double)NAN},
        {"--gage-factor", "the gage factor", &bridge->gage_factor, (double)NAN},
        {"--area", "the band's cross section, in2", &bridge->area_in2, (double)NAN},
        {"--arms", "the active arms", &bridge->arms, 1.0},
        {"--modulus", "the modulus, psi", &bridge->modulus_psi, 29e6},
        {"--ohm", "the gages' resistance, ohm", &bridge->gage_ohm, 350.0},
        {"--shunt", "the shunt, ohm", &bridge->shunt_ohm, 0.0},
    };
    for (size_t i = 0; i < sizeof number / sizeof number[0]; i++) {
        if (!isnan(*number[i].value) && !physics)
            return error_set(error, MR_USAGE,
                             "%s is bridge's: matrig gages %s; see matrig gages --help",
                             number[i].option, word);
        if (!isnan(*number[i].value))
            continue;
        if (physics && isnan(number[i].standard))
            return error_set(error, MR_USAGE, "%s is missing: matrig gages bridge needs %s",
                             number[i].what, number[i].option);
        *number[i].value = number[i].standard;
    }
    return MR_OK;
}

static int gages_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    const char *words[2];
    struct error error = {0};
    double what = 0.0;
    enum mr_status status = command_parse(&command_gages, argc, argv, cli, &r, words, &error);
    bool zero = status == MR_OK && strcmp(words[0], "zero") == 0,
         shunt = status == MR_OK && strcmp(words[0], "shunt") == 0;
    bool physics = status == MR_OK && strcmp(words[0], "bridge") == 0;
    if (status == MR_OK && !zero && !shunt && !physics)
        status = error_set(&error, MR_USAGE,
                           "not zero, shunt or bridge: '%s'; see matrig gages --help", words[0]);
    if (status == MR_OK && words[1] && !zero)
        status = error_set(&error, MR_USAGE, "%s takes no number: '%s'; see matrig gages --help",
                           words[0], words[1]);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "what to zero", 0, 2, &what, &error);
    if (status == MR_OK && what != floor(what))
        status = error_set(&error, MR_USAGE,
                           "what to zero: '%s'; 1 transducers, 2 gages, 0 or nothing both",
                           words[1]);
    if (status == MR_OK && !physics && !r.serial)
        status = error_set(&error, MR_USAGE,
                           "no link: matrig gages %s needs --serial LINK; see matrig gages --help",
                           words[0]);
    if (status == MR_OK)
        status = check_bridge(&r.bridge, words[0], physics, &error);
    if (status != MR_OK)
        return cli_fail(&error);
    return physics ? tell_bridge(cli, &r.bridge)
                   : talk_to_board(cli, r.serial, zero ? MR_COMMAND_ZERO : MR_COMMAND_SHUNT,
                                   (int32_t)what);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD(
        "zero [1|2]",
        "mean of a quarter of a second is the zero of all channels, of the transducers (1) or the "
        "gages (2), until\n"
        "reset. None is taken when one moves, is not valid, or is a gage under tension: exit 1"),
    HELP_WORD("shunt", "shunt calibration of the gages, a second; exit 1 when one is not good. "
                       "matrig log on the board's CAN\n"
                       "keeps it: the calibrations before and after a landing give its drift"),
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); the board must be idle, or done "
                "with a landing"),
    HELP_WORD("bridge", "what channel.unit_per_code and channel.shunt_lb should be, from"),
    HELP_NOTE("    --excitation V, --gain G (of the amplifier), --gage-factor F, --area IN2 (of "
              "the band)\n"
              "    --arms N     1 one gage along the band (the default), 2 two along it, 2.6 and "
              "two across it\n"
              "    --modulus PSI (29e6), --ohm R of a gage (350), --shunt OHM. In pounds, as the "
              "configuration has it, also with --si"),
    HELP_EXAMPLE("matrig gages zero 1 --serial serial:/dev/ttyUSB0; matrig gages bridge "
                 "--excitation 5 --gain 200 --gage-factor 2.1 --area 0.0625"),
    OPTION_NUMBER("--excitation", "V", bridge.excitation_v, "V", 0.01, 100.0, (double)NAN, NULL),
    OPTION_NUMBER("--gain", "G", bridge.amplifier_gain, NULL, 0.01, 1e6, (double)NAN, NULL),
    OPTION_NUMBER("--gage-factor", "F", bridge.gage_factor, NULL, 0.01, 1000.0, (double)NAN, NULL),
    OPTION_NUMBER("--area", "IN2", bridge.area_in2, "in2", 1e-6, 1000.0, (double)NAN, NULL),
    OPTION_NUMBER("--arms", "N", bridge.arms, NULL, 0.1, 4.0, (double)NAN, NULL),
    OPTION_NUMBER("--modulus", "PSI", bridge.modulus_psi, "psi", 1e3, 1e9, (double)NAN, NULL),
    OPTION_NUMBER("--ohm", "R", bridge.gage_ohm, "ohm", 1.0, 1e6, (double)NAN, NULL),
    OPTION_NUMBER("--shunt", "OHM", bridge.shunt_ohm, "ohm", 1.0, 1e9, (double)NAN, NULL),
};

const struct command command_gages = {
    "gages",
    gages_command,
    "zero [1|2] --serial LINK | shunt --serial LINK | bridge --excitation V --gain G ...",
    "zero and shunt calibration; pounds per code of a bridge",
    COMMAND_PARTS(parts),
    {1, 2, "zero [1|2] | shunt | bridge"},
};
