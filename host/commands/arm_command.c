/* matrig board ... arm [LANDING] | disarm: for whoever has a terminal and no live page. */
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "host/board/armtalk.h"
#include "host/cli.h"
#include "host/collect/collect.h"

static json_t *to_json(const char *word, const struct armtalk *talk, const struct error *error)
{
    json_t *json = json_pack("{sssb}", "command", word, "done", error->status == MR_OK);
    json_object_set_new(json, "state", talk->landing_known ? json_string(collector_state_text(talk->landing.state)) : json_null());
    json_object_set_new(json, "landing", talk->landing_known ? json_integer(talk->landing.landing) : json_null());
    json_object_set_new(json, "error", error->status == MR_OK ? json_null() : json_string(error->text));
    return json;
}

static int order(const char *spec, enum link_kind kind, const char *word, int32_t number, const struct cli *cli)
{
    struct armtalk talk = {0};
    struct link *link = NULL;
    struct error error = {0};
    bool arm = strcmp(word, "arm") == 0;
    enum mr_status status = link_open(spec, kind, &link, &error);
    if (status == MR_OK)
        status = armtalk_begin(&talk, link, kind, &error);
    if (status == MR_OK)
        status = armtalk_order(&talk, arm ? MR_COMMAND_ARM : MR_COMMAND_DISARM, number, &error);
    link_close(link);
    int exit_code = status == MR_OK ? 0 : cli_fail(&error);
    if (cli->json)
        return cli_print_json(to_json(word, &talk, &error), exit_code);
    if (status == MR_OK && arm)
        printf("armed for landing %u: the board records until the gear has stopped and the mat is at rest\n", talk.landing.landing);
    else if (status == MR_OK)
        puts("disarmed: the board is idle");
    return exit_code;
}

int arm_command(int argc, char **argv, const struct cli *cli)
{
    const char *can = NULL, *serial = NULL, *words[2] = {NULL, NULL};
    const struct cli_option options[] = {{"--can", &can, NULL}, {"--serial", &serial, NULL}};
    struct error error = {0};
    double number = 0.0;
    enum mr_status status = cli_parse(argc, argv, options, sizeof options / sizeof options[0], words, 1, 2, "arm [LANDING] | disarm", &error);
    bool arm = status == MR_OK && strcmp(words[0], "arm") == 0;
    if (status == MR_OK && !arm && strcmp(words[0], "disarm") != 0)
        status = error_set(&error, MR_USAGE, "not arm [LANDING] or disarm: '%s'; see matrig board --help", words[0]);
    if (status == MR_OK && words[1] && !arm)
        status = error_set(&error, MR_USAGE, "disarm takes no number: '%s'; see matrig board --help", words[1]);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "the landing", 0, ARMTALK_LANDING_MOST, &number, &error);
    if (status == MR_OK && number != (double)(int32_t)number)
        status = error_set(&error, MR_USAGE, "the landing is a whole number: '%s'; 0, or none, counts on", words[1]);
    if (status == MR_OK && !can == !serial)
        status = error_set(&error, MR_USAGE, can ? "--can and --serial: matrig board %s needs one link"
                                                 : "no link: matrig board %s needs --can LINK or --serial LINK; see matrig board --help",
                           words[0]);
    const char *spec = can ? can : serial;
    if (status == MR_OK && (strncmp(spec, "file:", 5) == 0 || strncmp(spec, "paced:", 6) == 0))
        status = error_set(&error, MR_USAGE, "a file is no board: %s; give the link of one", spec);
    if (status != MR_OK)
        return cli_fail(&error);
    return order(spec, can ? LINK_CAN : LINK_SERIAL, words[0], (int32_t)number, cli);
}
