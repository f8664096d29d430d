/* matrig gages: zero and shunt calibration of a board's channels, and what a bridge should be configured as. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/bridge.h"
#include "common/command.h"
#include "common/framing.h"
#include "host/analyse/bands.h"
#include "host/board/listen.h"
#include "host/cli.h"
#include "host/link/link.h"

#define ANSWER_S 10.0 /* a shunt calibration takes 0.9 s; hello comes once a second */
#define TAG 0x6a67u

struct talk {
    struct link *link;
    struct mr_deframer deframer;
    bool hello, acknowledged;
    struct mr_ack ack;
    struct mr_shunt_result shunt[MR_GAGES];
    struct mr_shunt_check check[MR_GAGES];
    unsigned shunts;
    struct mr_zero_result zero[MR_CHANNELS];
    unsigned zeros;
};

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static enum mr_status take_frame(void *context, const struct mr_frame *frame, struct error *error)
{
    struct talk *talk = context;
    const uint8_t *bytes = frame->payload;
    size_t length = frame->length;
    struct mr_ack ack;
    struct mr_shunt_check check;
    switch (frame->type) {
    case MR_ID_HELLO:
        if (listen_hello(talk->link, bytes, length, error) != MR_OK)
            return MR_VERSION;
        talk->hello = true;
        break;
    case MR_ID_ACK:
        if (mr_ack_get(&ack, bytes, length) == MR_OK && ack.tag == TAG) {
            talk->ack = ack;
            talk->acknowledged = true;
        }
        break;
    case MR_ID_SHUNT:
        talk->shunts = 0;
        break;
    case MR_ID_SHUNT_RESULT:
        if (talk->shunts < MR_GAGES && mr_shunt_result_get(&talk->shunt[talk->shunts], bytes, length) == MR_OK)
            talk->check[talk->shunts++] = (struct mr_shunt_check){.expected_lb = NAN, .change_lb = NAN, .zero_change_lb = NAN};
        break;
    case MR_ID_SHUNT_CHECK:
        if (talk->shunts && mr_shunt_check_get(&check, bytes, length) == MR_OK && check.gage == talk->shunt[talk->shunts - 1].gage)
            talk->check[talk->shunts - 1] = check;
        break;
    case MR_ID_ZERO_RESULT:
        if (talk->zeros < MR_CHANNELS && mr_zero_result_get(&talk->zero[talk->zeros], bytes, length) == MR_OK)
            talk->zeros++;
        break;
    default:
        break;
    }
    return MR_OK;
}

/* What comes within a tenth of a second. */
static enum mr_status listen(struct talk *talk, struct error *error)
{
    return listen_tenth(talk->link, &talk->deframer, take_frame, talk, error);
}

static enum mr_status wait_for(struct talk *talk, const bool *what, const char *name, struct error *error)
{
    enum mr_status status = MR_OK;
    double until_s = now_s() + ANSWER_S;
    while (status == MR_OK && !*what && now_s() < until_s)
        status = listen(talk, error);
    if (status == MR_OK && !*what)
        status = error_set(error, MR_TIMEOUT, "the board did not %s within %.0f s: %s; is it powered, are its scans running?", name,
                           ANSWER_S, link_spec(talk->link));
    return status;
}

static enum mr_status order(struct talk *talk, unsigned code, int32_t argument, struct error *error)
{
    struct mr_command command = {.code = (uint8_t)code, .tag = TAG, .argument = argument};
    uint8_t payload[MR_MESSAGE_MAX], frame[MR_FRAME_MAX];
    size_t length = mr_command_put(&command, payload);
    enum mr_status status = wait_for(talk, &talk->hello, "say hello", error);
    if (status == MR_OK)
        status = link_send_bytes(talk->link, frame, mr_frame_encode(0, MR_ID_COMMAND, payload, length, frame), error);
    if (status == MR_OK)
        status = wait_for(talk, &talk->acknowledged, "answer", error);
    if (status != MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW, "the board is armed, in a landing, or calibrating: %s; disarm it, or wait",
                         link_spec(talk->link));
    if (talk->ack.status != MR_OK && talk->ack.status != MR_LIMIT)
        return error_set(error, (enum mr_status)talk->ack.status, "the board refused %s (%s): %s; see matrig gages --help",
                         mr_command_name(code), mr_status_text((enum mr_status)talk->ack.status), link_spec(talk->link));
    return MR_OK;
}

/* ---- what came ---- */

static void print_change(float lb)
{
    if (isnan(lb))
        printf("  %11s", "-");
    else
        printf("  %+11.3f", (double)lb);
}

static void print_shunts(const struct talk *talk)
{
    printf("gage  found, lb  of, lb  noise, lb   change, lb  at rest, lb\n");
    for (unsigned i = 0; i < talk->shunts; i++) {
        const struct mr_shunt_result *r = &talk->shunt[i];
        const struct mr_shunt_check *c = &talk->check[i];
        printf("%4u  %9.3f  %6.2f  %9.3f", r->gage, (double)r->span_lb, (double)c->expected_lb, (double)r->noise_lb);
        print_change(c->change_lb);
        print_change(c->zero_change_lb);
        printf("  %s\n", bands_verdict_text(r->verdict));
    }
}

static const char *zero_text(unsigned verdict)
{
    static const char *const text[] = {"good", "not valid", "it moves", "far from the configured zero: is its band tensioned?"};
    return verdict < 4 ? text[verdict] : "unknown";
}

static void print_zeros(const struct talk *talk)
{
    for (unsigned i = 0; i < talk->zeros; i++) {
        const struct mr_zero_result *z = &talk->zero[i];
        bool tension = z->index >= MR_TRANSDUCERS;
        printf("%s %2u  %9.3f codes  spread %6.2f  %s\n", tension ? "gage      " : "transducer",
               tension ? z->index - MR_TRANSDUCERS + 1u : z->index + 1u, (double)z->zero_code, (double)z->spread_codes,
               zero_text(z->verdict));
    }
    printf(talk->ack.status == MR_OK ? "these are the zeros now, until the board is reset or configured anew\n" : "no zero was taken\n");
}

static json_t *results_json(const struct talk *talk)
{
    json_t *shunts = json_array(), *zeros = json_array();
    for (unsigned i = 0; i < talk->shunts; i++) {
        const struct mr_shunt_result *r = &talk->shunt[i];
        const struct mr_shunt_check *c = &talk->check[i];
        json_array_append_new(shunts, json_pack("{sisssosososo}", "gage", r->gage, "verdict", bands_verdict_text(r->verdict), "span_lb",
                                                cli_json_number((double)r->span_lb, 7), "expected_lb",
                                                cli_json_number((double)c->expected_lb, 5), "noise_lb",
                                                cli_json_number((double)r->noise_lb, 4), "change_lb",
                                                cli_json_number((double)c->change_lb, 4)));
    }
    for (unsigned i = 0; i < talk->zeros; i++) {
        const struct mr_zero_result *z = &talk->zero[i];
        json_array_append_new(zeros, json_pack("{sisssoso}", "channel", z->index, "verdict", zero_text(z->verdict), "zero_code",
                                               cli_json_number((double)z->zero_code, 7), "spread_codes",
                                               cli_json_number((double)z->spread_codes, 4)));
    }
    return json_pack("{sbsoso}", "good", talk->ack.status == MR_OK, "shunts", shunts, "zeros", zeros);
}

static int talk_to_board(const struct cli *cli, const char *serial, unsigned code, int32_t argument)
{
    struct error error = {0};
    struct talk *talk = calloc(1, sizeof *talk);
    if (!talk)
        abort();
    mr_deframer_init(&talk->deframer);
    enum mr_status status = link_open(serial, LINK_SERIAL, &talk->link, &error);
    if (status == MR_OK)
        status = order(talk, code, argument, &error);
    link_close(talk->link);
    int exit_code = status != MR_OK ? cli_fail(&error) : talk->ack.status == MR_OK ? 0 : mr_status_exit_code(MR_LIMIT);
    if (status == MR_OK && cli->json)
        exit_code = cli_print_json(results_json(talk), exit_code);
    else if (status == MR_OK && code == MR_COMMAND_SHUNT)
        print_shunts(talk);
    else if (status == MR_OK)
        print_zeros(talk);
    free(talk);
    return exit_code;
}

/* ---- a bridge ---- */

struct bridge_option {
    const char *name, *text, *what;
    double *value, low, high;
};

static int tell_bridge(const struct cli *cli, const struct mr_bridge *bridge)
{
    double lb_per_code = mr_bridge_lb_per_code(bridge), shunt_lb = mr_bridge_shunt_lb(bridge);
    if (cli->json)
        return cli_print_json(json_pack("{soso}", "lb_per_code", cli_json_number(lb_per_code, 7), "shunt_lb",
                                        cli_json_number(shunt_lb, 7)), 0);
    printf("%.6g lb per code, %.4g mV per lb behind the amplifier\n", lb_per_code, 1e3 * MR_ADC_V / MR_ADC_CODES / lb_per_code);
    if (!isnan(shunt_lb))
        printf("the shunt stands for %.4g lb\n", shunt_lb);
    return 0;
}

int gages_command(int argc, char **argv, const struct cli *cli)
{
    struct mr_bridge bridge = {.arms = 1.0, .modulus_psi = 29e6, .gage_ohm = 350.0, .excitation_v = (double)NAN,
                               .amplifier_gain = (double)NAN, .gage_factor = (double)NAN, .area_in2 = (double)NAN};
    struct bridge_option number[] = {
        {"--excitation", NULL, "the excitation, V", &bridge.excitation_v, 0.01, 100.0},
        {"--gain", NULL, "the amplifier's gain", &bridge.amplifier_gain, 0.01, 1e6},
        {"--gage-factor", NULL, "the gage factor", &bridge.gage_factor, 0.01, 1000.0},
        {"--area", NULL, "the band's cross section, in2", &bridge.area_in2, 1e-6, 1000.0},
        {"--arms", NULL, "the active arms", &bridge.arms, 0.1, 4.0},
        {"--modulus", NULL, "the modulus, psi", &bridge.modulus_psi, 1e3, 1e9},
        {"--ohm", NULL, "the gages' resistance, ohm", &bridge.gage_ohm, 1.0, 1e6},
        {"--shunt", NULL, "the shunt, ohm", &bridge.shunt_ohm, 1.0, 1e9},
    };
    enum { NUMBERS = sizeof number / sizeof number[0], NEEDED = 4 };
    struct cli_option options[NUMBERS + 1];
    const char *serial = NULL, *words[2] = {NULL, NULL};
    struct error error = {0};
    double what = 0.0;
    for (unsigned i = 0; i < NUMBERS; i++)
        options[i] = (struct cli_option){number[i].name, &number[i].text, NULL};
    options[NUMBERS] = (struct cli_option){"--serial", &serial, NULL};
    enum mr_status status = cli_parse(argc, argv, options, NUMBERS + 1, words, 1, 2, "zero [1|2] | shunt | bridge", &error);
    bool zero = status == MR_OK && strcmp(words[0], "zero") == 0, shunt = status == MR_OK && strcmp(words[0], "shunt") == 0;
    bool physics = status == MR_OK && strcmp(words[0], "bridge") == 0;
    if (status == MR_OK && !zero && !shunt && !physics)
        status = error_set(&error, MR_USAGE, "not zero, shunt or bridge: '%s'; see matrig gages --help", words[0]);
    if (status == MR_OK && words[1] && !zero)
        status = error_set(&error, MR_USAGE, "%s takes no number: '%s'; see matrig gages --help", words[0], words[1]);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "what to zero", 0, 2, &what, &error);
    if (status == MR_OK && what != floor(what))
        status = error_set(&error, MR_USAGE, "what to zero: '%s'; 1 transducers, 2 gages, 0 or nothing both", words[1]);
    if (status == MR_OK && !physics && !serial)
        status = error_set(&error, MR_USAGE, "no link: matrig gages %s needs --serial LINK; see matrig gages --help", words[0]);
    for (unsigned i = 0; i < NUMBERS && status == MR_OK; i++) {
        if (number[i].text && !physics)
            status = error_set(&error, MR_USAGE, "%s is bridge's: matrig gages %s; see matrig gages --help", number[i].name, words[0]);
        else if (number[i].text)
            status = cli_number(number[i].text, number[i].what, number[i].low, number[i].high, number[i].value, &error);
        else if (physics && i < NEEDED)
            status = error_set(&error, MR_USAGE, "%s is missing: matrig gages bridge needs %s", number[i].what, number[i].name);
    }
    if (status != MR_OK)
        return cli_fail(&error);
    return physics ? tell_bridge(cli, &bridge)
                   : talk_to_board(cli, serial, zero ? MR_COMMAND_ZERO : MR_COMMAND_SHUNT, (int32_t)what);
}
