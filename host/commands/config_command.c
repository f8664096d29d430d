/* The command matrig board ... config: reads, changes and checks the configuration of a board as
 * text. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "host/base/monotonic_clock.h"
#include "host/board/config_client.h"
#include "host/board/config_text.h"
#include "host/calibrate/jump.h"
#include "host/commands/commands.h"
#include "host/base/output.h"

#define BASE_SEARCH_S 2.0 /* search time, s; a board sends a hello once a second */

struct request {
    const struct cli *cli;
    const char *can, *serial, *file, *output;
    bool force;
};

struct session {
    struct dialogue *dialogue;
    struct config_client client;
    struct mr_config config; /* the configuration that the board uses */
    uint32_t crc;
};

static const char *config_copy_text(unsigned copy)
{
    return copy == 0   ? "intact"
         : copy == 255 ? "empty"
                       : mr_status_text((enum mr_status) - (int)copy);
}

/* Prints a note if a copy of the configuration in flash is damaged. An empty copy is not
 * damaged. */
static void warn_damaged_copy(const struct cli *cli, const struct mr_config_state *state)
{
    if (state->copy_a != 0 && state->copy_a != 255)
        cli_note(cli, "copy A of the configuration in the board's flash is damaged: %s",
                 config_copy_text(state->copy_a));
    if (state->copy_b != 0 && state->copy_b != 255)
        cli_note(cli, "copy B of the configuration in the board's flash is damaged: %s",
                 config_copy_text(state->copy_b));
}

/* Prints a note if the board's configuration is invalid. Older firmware may have accepted it. */
static void warn_invalid_config(const struct cli *cli, const struct mr_config *config)
{
    struct mr_config_violation reason;
    char why[500];
    if (mr_config_check(config, &reason) == MR_OK)
        return;
    config_text_reason(config, &reason, why, sizeof why);
    cli_note(cli, "the configuration of the board is invalid: %s", why);
}

static void open_session(const struct request *request, struct session *session)
{
    memset(session, 0, sizeof *session);
    /* if both links are given, commands are sent over serial, and CAN is only used to find other
     * boards */
    session->dialogue = dialogue_open_for_command(request->serial ? NULL : request->can,
                                                  request->serial);
    config_client_begin(&session->client, session->dialogue, fatal);
    config_client_get(&session->client, &session->config, &session->crc, fatal);
}

static int run_get(const struct request *request)
{
    static struct session session;
    int exit_code = 0;
    output_check_new(request->output, request->force, fatal);
    output_check(request->output, NULL, fatal);
    open_session(request, &session);
    const struct mr_config_state *state = &session.client.state;
    char *text = config_text_write(&session.config);
    if (request->output)
        output_write_bytes(request->output, text, strlen(text), fatal);
    warn_damaged_copy(request->cli, state);
    warn_invalid_config(request->cli, &session.config);
    if (request->cli->json)
        exit_code = cli_print_json(json_pack("{sIsIssssssss}", "revision",
                                             (json_int_t)session.config.site[0].revision, "crc",
                                             (json_int_t)session.crc, "source",
                                             mr_config_source_text(state->source), "copy_a",
                                             config_copy_text(state->copy_a), "copy_b",
                                             config_copy_text(state->copy_b), "text", text),
                                   0);
    else if (request->output)
        printf("%s: revision %u, CRC %08x, %s\n", request->output, session.config.site[0].revision,
               session.crc, mr_config_source_text(state->source));
    else
        fputs(text, stdout);
    free(text);
    return exit_code;
}

static void add_change(void *context, const char *field, const char *old, const char *new)
{
    json_array_append_new(context, json_pack("{ssssss}", "field", field, "old", old, "new", new));
}

static void show_changes(const json_t *changes)
{
    size_t i;
    json_t *change;
    json_array_foreach(changes, i, change)
        printf("%s: %s -> %s\n", json_string_value(json_object_get(change, "field")),
               json_string_value(json_object_get(change, "old")),
               json_string_value(json_object_get(change, "new")));
}

/* Sends the configuration `wanted`, reads it back and compares both. */
static enum mr_status send_configuration(struct session *session, const struct mr_config *wanted,
                                         struct error *error)
{
    static struct mr_config back;
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    uint32_t crc;
    enum mr_status status = config_client_set(&session->client, wanted, error)
                              ?: config_client_get(&session->client, &back, &crc, error);
    if (status == MR_OK && crc != mr_config_encode(wanted, image))
        return error_set(error, MR_CRC,
                         "the board stored a different configuration (CRC %08x) than the one sent: "
                         "%s; send the configuration again",
                         crc, dialogue_spec(session->dialogue));
    session->crc = crc;
    return status;
}

/* Compares the new gain of each channel with its present gain. Refuses a jump unless --force is
 * given. */
static void check_gain_changes(const struct request *request, const struct mr_config *old,
                               const struct mr_config *new)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        char name[8], what[JUMP_TEXT_SIZE];
        if (!jump_find(&old->channel[i], &new->channel[i], what))
            continue;
        jump_channel_name(i, name);
        if (!request->force)
            error_set(fatal, MR_LIMIT,
                      "%s: %s, compared with the board: %s; check the calibration of that channel; "
                      "if the change is intended, send it with --force",
                      name, what, request->file);
        cli_note(request->cli, "%s: %s, compared with the board", name, what);
    }
}

/* ---- another base on CAN ---- */

/* True if a board sends a hello with this CAN base. */
static bool is_board_at_base(struct link *link, uint16_t base)
{
    const double until_s = monotonic_s() + BASE_SEARCH_S;
    struct link_frame frame;
    struct mr_message message;
    struct error error = {0};
    while (monotonic_s() < until_s) {
        enum mr_status status = link_receive_frame(link, &frame, &error);
        uint32_t id = status == MR_OK ? link_id_from_bus(frame.id, base) : UINT32_MAX;
        struct pollfd ready = {.fd = link_fd(link), .events = POLLIN};
        if (id == MR_ID_HELLO &&
            mr_message_decode(&message, MR_ID_HELLO, frame.data, frame.length) == MR_OK)
            return true;
        if (status == MR_TOO_FEW)
            poll(&ready, 1, 50);
        else if (status != MR_OK)
            break;
    }
    return false;
}

/* Refuses a CAN base that another board on the bus already uses. */
static void find_board_base(const struct request *request, struct session *session, uint16_t base)
{
    struct link *own = NULL;
    if (!request->can)
        return;
    if (request->serial)
        link_open(request->can, LINK_CAN, &own, fatal);
    struct link *link = own ? own : dialogue_link(session->dialogue);
    uint16_t before = link_base(link);
    link_set_base(link, base);
    bool taken = is_board_at_base(link, base);
    link_set_base(link, before);
    link_close(own);
    if (taken)
        error_set(fatal, MR_LIMIT,
                  "another board already uses base 0x%03x of %s; give this board a different base",
                  base, request->can);
}

/* Writes the LINK by which the board can be reached on CAN after the change. */
static void format_link_at_base(const struct request *request, uint16_t base,
                                char out[LINK_SPEC_SIZE])
{
    uint16_t old;
    struct error error = {0};
    char spec[LINK_SPEC_SIZE - sizeof ",base=0x000"];
    snprintf(spec, sizeof spec, "%s", request->can ? request->can : "LINK");
    (void)link_split_base(spec, &old, &error);
    snprintf(out, LINK_SPEC_SIZE, "%s,base=0x%03x", spec, base);
}

static int run_set(const struct request *request)
{
    static struct session session;
    static struct mr_config wanted;
    struct error error = {0};
    int exit_code = 0;
    json_t *changes = json_array();
    config_text_load(request->file, &wanted, fatal);
    open_session(request, &session);
    uint32_t revision = session.config.site[0].revision, own_revision = wanted.site[0].revision;
    wanted.site[0].revision = revision;
    unsigned count = config_text_compare(&session.config, &wanted, add_change, changes);
    if (count && own_revision != revision)
        error_set(fatal, MR_LIMIT,
                  "the file is based on revision %u, but the board has revision %u: %s; get and "
                  "edit the present configuration, or set site.revision = %u to overwrite it",
                  own_revision, revision, request->file, revision);
    uint16_t base = wanted.site[0].can_base;
    bool moves = count && base != session.config.site[0].can_base;
    char at_base[LINK_SPEC_SIZE];
    format_link_at_base(request, base, at_base);
    if (count)
        check_gain_changes(request, &session.config, &wanted);
    if (moves)
        find_board_base(request, &session, base);
    if (count) {
        wanted.site[0].revision = revision + 1;
        if (!request->cli->json)
            show_changes(changes);
        fflush(stdout);
        enum mr_status status = send_configuration(&session, &wanted, &error);
        if (status == MR_TIMEOUT && moves && !request->serial)
            cli_note(request->cli, "the board may already use its new base: %s", at_base);
        if (status != MR_OK)
            return cli_fail(&error);
    }
    if (request->cli->json) {
        exit_code = cli_print_json(
            json_pack("{sIsIsOsi}", "revision", (json_int_t)wanted.site[0].revision, "crc",
                      (json_int_t)session.crc, "changes", changes, "can_base", base),
            0);
    } else {
        printf(count ? "%u field%s changed, stored and read back: revision %u, CRC %08x\n"
                     : "the board already has this configuration, %u field%s changed: revision %u, "
                       "CRC %08x\n",
               count, count == 1 ? "" : "s", wanted.site[0].revision, session.crc);
        if (moves)
            printf("the board now uses %s\n", at_base);
    }
    json_decref(changes);
    return exit_code;
}

static int run_check(const struct request *request)
{
    static struct mr_config config;
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    config_text_load(request->file, &config, fatal);
    uint32_t crc = mr_config_encode(&config, image);
    if (request->cli->json)
        return cli_print_json(json_pack("{sIsI}", "revision", (json_int_t)config.site[0].revision,
                                        "crc", (json_int_t)crc),
                              0);
    printf("%s: valid, revision %u, CRC %08x\n", request->file, config.site[0].revision, crc);
    return 0;
}

static int config_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    const char *words[3];
    command_parse(&command_board_config, argc, argv, cli, &request, words, fatal);
    const char *verb = words[1];
    bool is_get = strcmp(verb, "get") == 0, is_set = strcmp(verb, "set") == 0,
         is_check = strcmp(verb, "check") == 0;
    request.file = words[2];
    if (!is_get && !is_set && !is_check)
        error_set(fatal, MR_USAGE, "unknown action of config: '%s'; give get, set or check", verb);
    if (is_get == (request.file != NULL))
        error_set(fatal, MR_USAGE,
                  is_get ? "unexpected argument: '%s' of config get; name the output file with -o "
                           "FILE, see matrig board --help"
                         : "no file: matrig board config %s needs a FILE; see matrig board --help",
                  is_get ? request.file : verb);
    if (request.output && !is_get)
        error_set(fatal, MR_USAGE,
                  "-o works only with config get: matrig board config %s; leave -o out", verb);
    if (!is_check && !request.can == !request.serial && !(is_set && request.can))
        error_set(fatal, MR_USAGE,
                  "matrig board config %s needs one link, either --serial LINK or --can LINK; see "
                  "matrig board --help",
                  verb);
    if (is_check && (request.can || request.serial))
        error_set(fatal, MR_USAGE, "config check uses no board: leave out --can and --serial");
    return is_get ? run_get(&request) : is_set ? run_set(&request) : run_check(&request);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_WORD(
        "config get",
        "print the active configuration; -o writes it to a file. Works over --can or --serial"),
    HELP_WORD(
        "config set F",
        "check F, show the changes, send F and verify that the board stored F. The board refuses a "
        "configuration while a landing is armed or in progress, and over CAN without the "
        "maintenance jumper. A gain that changes by more than 10 % needs --force. In a first "
        "calibration, and with a new serial number, this limit is a factor of 1.5 (transducer) or "
        "5 (gage). With --can, a CAN base that another board uses is refused"),
    HELP_WORD("config check F", "check F without a board"),
    OPTION_TEXT("--can", "LINK", can, NULL),
    OPTION_TEXT("--serial", "LINK", serial, NULL),
    OPTION_TEXT("-o", "F.cfg", output, NULL),
    OPTION_FLAG("--force", force, NULL),
};

const struct command command_board_config = {
    "board",
    config_command,
    "config get|set FILE|check FILE",
    "the configuration",
    COMMAND_PARTS(parts),
    {2, 3, "config get|set FILE|check FILE"},
};
