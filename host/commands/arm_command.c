/* matrig board ... arm [LANDING] | disarm: for whoever has a terminal and no live page. */
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "host/board/arm_client.h"
#include "host/commands/commands.h"

static json_t *to_json(const char *word, const struct arm_client *talk, const struct error *error)
{
    json_t *json = json_pack("{sssb}", "command", word, "done", error->status == MR_OK);
    json_object_set_new(json, "state",
                        talk->landing_known
                            ? json_string(mr_landing_state_text(talk->landing.state))
                            : json_null());
    json_object_set_new(json, "landing",
                        talk->landing_known ? json_integer(talk->landing.landing) : json_null());
    json_object_set_new(json, "error",
                        error->status == MR_OK ? json_null() : json_string(error->text));
    return json;
}

static int order(const char *can, const char *serial, const char *word, int32_t number,
                 const struct cli *cli)
{
    struct arm_client talk = {0};
    struct dialogue dialogue;
    struct error error = {0};
    bool arm = strcmp(word, "arm") == 0;
    enum mr_status status = dialogue_open(&dialogue, can, serial, &error);
    if (status == MR_OK)
        status = arm_client_begin(&talk, &dialogue, &error);
    if (status == MR_OK)
        status = arm_client_order(&talk, arm ? MR_COMMAND_ARM : MR_COMMAND_DISARM, number, &error);
    dialogue_close(&dialogue);
    int exit_code = status == MR_OK ? 0 : cli_fail(&error);
    if (cli->json)
        return cli_print_json(to_json(word, &talk, &error), exit_code);
    if (status == MR_OK && arm)
        printf("armed for landing %u: the board records until the gear has stopped and the mat is "
               "at rest\n",
               talk.landing.landing);
    else if (status == MR_OK)
        puts("disarmed: the board is idle");
    return exit_code;
}

struct request {
    const char *can, *serial;
};

static int arm_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct request r = {0};
    struct error error = {0};
    double number = 0.0;
    enum mr_status status = command_parse(&command_board_arm, argc, argv, cli, &r, words, &error);
    bool arm = status == MR_OK && strcmp(words[0], "arm") == 0;
    if (status == MR_OK && !arm && strcmp(words[0], "disarm") != 0)
        status = error_set(&error, MR_USAGE,
                           "not arm [LANDING] or disarm: '%s'; see matrig board --help", words[0]);
    if (status == MR_OK && words[1] && !arm)
        status = error_set(&error, MR_USAGE,
                           "disarm takes no number: '%s'; see matrig board --help", words[1]);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "the landing", 0, ARM_CLIENT_LANDING_MOST, &number, &error);
    if (status == MR_OK && number != (double)(int32_t)number)
        status = error_set(&error, MR_USAGE,
                           "the landing is a whole number: '%s'; 0, or none, counts on", words[1]);
    if (status == MR_OK && !r.can == !r.serial)
        status = error_set(&error, MR_USAGE,
                           r.can ? "--can and --serial: matrig board %s needs one link"
                                 : "no link: matrig board %s needs --can LINK or --serial LINK; "
                                   "see matrig board --help",
                           words[0]);
    const char *spec = r.can ? r.can : r.serial;
    if (status == MR_OK && strncmp(spec, "file:", 5) == 0)
        status = error_set(&error, MR_USAGE, "a file is no board: %s; give the link of one", spec);
    if (status != MR_OK)
        return cli_fail(&error);
    return order(r.can, r.serial, words[0], (int32_t)number, cli);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD("arm [LANDING]", "arm it for a landing, numbered so; without a number, or with 0, it "
                               "counts on. Over --can also while matrig\n"
                               "log holds the same interface; over --serial when nobody else holds "
                               "the port. Exit 2: the board refuses\n"
                               "in its state, 3: not ready, try again, or no answer within 3 s\n"
                               "matrig board --can can:can0 arm 7"),
    HELP_WORD("disarm", "back to idle, whatever is being recorded"),
    OPTION_TEXT("--can", "LINK", can, NULL),
    OPTION_TEXT("--serial", "LINK", serial, NULL),
};

/* Of matrig board. */
const struct command command_board_arm = {
    "board",          arm_command,          "arm [LANDING] | disarm",
    "arm and disarm", COMMAND_PARTS(parts), {1, 2, "arm [LANDING] | disarm"},
};
