/* matrig board ... config: a board's configuration as text: reading it, changing it, checking a file. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/configtalk.h"
#include "host/board/configtext.h"
#include "host/cli.h"

struct request {
    const struct cli *cli;
    const char *can, *serial, *file, *output;
};

struct session {
    struct link *link;
    struct configtalk talk;
    struct mr_config config; /* in force */
    uint32_t crc;
};

static const char *source_text(unsigned source)
{
    static const char *const text[] = {"built in", "copy A", "copy B"};
    return source < sizeof text / sizeof text[0] ? text[source] : "unknown";
}

static const char *copy_text(unsigned copy)
{
    return copy == 0 ? "whole" : copy == 255 ? "empty" : mr_status_text((enum mr_status)-(int)copy);
}

/* The copy that is not in force and not simply empty: why not. */
static void note_damage(const struct cli *cli, const struct mr_config_state *state)
{
    if (state->copy_a != 0 && state->copy_a != 255)
        cli_note(cli, "copy A in the board's flash is damaged: %s", copy_text(state->copy_a));
    if (state->copy_b != 0 && state->copy_b != 255)
        cli_note(cli, "copy B in the board's flash is damaged: %s", copy_text(state->copy_b));
}

static enum mr_status open_session(const struct request *request, struct session *session, struct error *error)
{
    enum link_kind kind = request->serial ? LINK_SERIAL : LINK_CAN;
    memset(session, 0, sizeof *session);
    enum mr_status status = link_open(request->serial ? request->serial : request->can, kind, &session->link, error);
    if (status == MR_OK)
        status = configtalk_begin(&session->talk, session->link, kind, error);
    if (status == MR_OK)
        status = configtalk_get(&session->talk, &session->config, &session->crc, error);
    return status;
}

static enum mr_status write_file(const char *path, const char *text, struct error *error)
{
    FILE *file = fopen(path, "wb");
    bool written = file && fputs(text, file) >= 0;
    if ((file && fclose(file) != 0) || !written)
        return error_set(error, MR_IO, "cannot be written: %s; is there room, and may you?", path);
    return MR_OK;
}

static int get(const struct request *request, struct error *error)
{
    static struct session session;
    int exit_code = 0;
    enum mr_status status = open_session(request, &session, error);
    const struct mr_config_state *state = &session.talk.state;
    char *text = status == MR_OK ? configtext_write(&session.config) : NULL;
    if (status == MR_OK && request->output)
        status = write_file(request->output, text, error);
    if (status == MR_OK) {
        note_damage(request->cli, state);
        if (request->cli->json)
            exit_code = cli_print_json(json_pack("{sIsIssssssss}", "revision", (json_int_t)session.config.site[0].revision, "crc",
                                                 (json_int_t)session.crc, "source", source_text(state->source), "copy_a",
                                                 copy_text(state->copy_a), "copy_b", copy_text(state->copy_b), "text", text), 0);
        else if (request->output)
            printf("%s: revision %u, CRC %08x, %s\n", request->output, session.config.site[0].revision, session.crc,
                   source_text(state->source));
        else
            fputs(text, stdout);
    } else {
        exit_code = cli_fail(error);
    }
    free(text);
    link_close(session.link);
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
               json_string_value(json_object_get(change, "old")), json_string_value(json_object_get(change, "new")));
}

/* Sends `wanted` and sees that it is there. */
static enum mr_status change(struct session *session, const struct mr_config *wanted, struct error *error)
{
    static struct mr_config back;
    static uint8_t image[MR_CONFIG_IMAGE];
    uint32_t crc;
    enum mr_status status = configtalk_set(&session->talk, wanted, error);
    if (status == MR_OK)
        status = configtalk_get(&session->talk, &back, &crc, error);
    if (status == MR_OK && crc != mr_config_encode(wanted, image))
        return error_set(error, MR_CRC, "what reads back is not what was sent, CRC %08x: %s; read it again", crc, link_spec(session->link));
    session->crc = crc;
    return status;
}

static int set(const struct request *request, struct error *error)
{
    static struct session session;
    static struct mr_config wanted;
    int exit_code = 0;
    json_t *changes = json_array();
    enum mr_status status = configtext_load(request->file, &wanted, error);
    if (status == MR_OK)
        status = open_session(request, &session, error);
    uint32_t revision = session.config.site[0].revision, own_revision = wanted.site[0].revision;
    wanted.site[0].revision = revision;
    unsigned count = status == MR_OK ? configtext_compare(&session.config, &wanted, add_change, changes) : 0;
    if (status == MR_OK && count && own_revision != revision)
        status = error_set(error, MR_LIMIT,
                           "made from revision %u, but revision %u is in force, changed since: %s; get it again and change that, or set "
                           "site.revision = %u to put this one over it",
                           own_revision, revision, request->file, revision);
    if (status == MR_OK && count) {
        wanted.site[0].revision = revision + 1;
        if (!request->cli->json)
            show_changes(changes);
        fflush(stdout);
        status = change(&session, &wanted, error);
    }
    if (status != MR_OK) {
        exit_code = cli_fail(error);
    } else if (request->cli->json) {
        exit_code = cli_print_json(json_pack("{sIsIsO}", "revision", (json_int_t)wanted.site[0].revision, "crc",
                                             (json_int_t)session.crc, "changes", changes), 0);
    } else {
        printf(count ? "%u field%s changed, stored and read back: revision %u, CRC %08x\n"
                     : "nothing differs, %u field%s changed: revision %u, CRC %08x\n",
               count, count == 1 ? "" : "s", wanted.site[0].revision, session.crc);
    }
    json_decref(changes);
    link_close(session.link);
    return exit_code;
}

static int check(const struct request *request, struct error *error)
{
    static struct mr_config config;
    static uint8_t image[MR_CONFIG_IMAGE];
    if (configtext_load(request->file, &config, error) != MR_OK)
        return cli_fail(error);
    uint32_t crc = mr_config_encode(&config, image);
    if (request->cli->json)
        return cli_print_json(json_pack("{sIsI}", "revision", (json_int_t)config.site[0].revision, "crc", (json_int_t)crc), 0);
    printf("%s: sound, revision %u, CRC %08x\n", request->file, config.site[0].revision, crc);
    return 0;
}

int config_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    const char *words[3] = {NULL, NULL, NULL};
    const struct cli_option options[] = {
        {"--can", &request.can, NULL}, {"--serial", &request.serial, NULL}, {"-o", &request.output, NULL}};
    struct error error = {0};
    enum mr_status status = cli_parse(argc, argv, options, 3, words, 2, 3, "config get|set FILE|check FILE", &error);
    const char *verb = status == MR_OK ? words[1] : "";
    bool is_get = strcmp(verb, "get") == 0, is_set = strcmp(verb, "set") == 0, is_check = strcmp(verb, "check") == 0;
    request.file = words[2];
    if (status == MR_OK && !is_get && !is_set && !is_check)
        status = error_set(&error, MR_USAGE, "not get, set or check: '%s'; see matrig board --help", verb);
    if (status == MR_OK && is_get == (request.file != NULL))
        status = error_set(&error, MR_USAGE, is_get ? "config get takes no word, but -o FILE: '%s'; see matrig board --help"
                                                    : "which file? matrig board config %s needs one; see matrig board --help",
                           is_get ? request.file : verb);
    if (status == MR_OK && request.output && !is_get)
        status = error_set(&error, MR_USAGE, "-o is config get's: matrig board config %s", verb);
    if (status == MR_OK && !is_check && !request.can == !request.serial)
        status = error_set(&error, MR_USAGE, "which link? matrig board config %s needs --serial LINK or --can LINK; see matrig board --help",
                           verb);
    if (status == MR_OK && is_check && (request.can || request.serial))
        status = error_set(&error, MR_USAGE, "config check needs no board: leave --can and --serial away");
    if (status != MR_OK)
        return cli_fail(&error);
    return is_get ? get(&request, &error) : is_set ? set(&request, &error) : check(&request, &error);
}
