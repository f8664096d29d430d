/* matrig board: the black box of a board: what it holds, reading a record out, giving its space
 * back. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "host/base/answer.h"
#include "host/board/health_client.h"
#include "host/board/box_client.h"
#include "host/board/config_client.h"
#include "host/board/config_text.h"
#include "host/collect/boxfill.h"
#include "host/base/help.h"
#include "host/commands/commands.h"
#include "host/board/imagefile.h"
#include "host/board/identity.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"

#define KIND_S 1.2 /* within which a board says its kind: once a second */

struct request {
    const struct cli *cli;
    const char *serial, *db, *image, *elf;
    int64_t run;
};

static void record_answer(const struct box_client_record *r, struct answer *answer)
{
    answer_count(answer, "record", "record", r->record.record);
    answer_count(answer, "landing", "landing", r->record.landing);
    answer_count(answer, "pages", "pages", r->record.pages);
    answer_flag(answer, "complete", NULL, r->record.complete);
    answer_count(answer, "first_block", NULL, (int64_t)r->span.first_block);
    answer_count(answer, "blocks", NULL, r->span.blocks);
    answer_value(answer, NULL, "lasts", UNIT_TIME,
                 r->record.complete ? (double)r->span.blocks / 1000.0 : (double)NAN, 3);
    answer_count(answer, "lost", "blocks lost", r->span.lost);
    answer_words(answer, NULL, "its end", "%s",
                 r->record.complete ? "closed" : "not closed: the power went");
}

static int list(const struct request *request, const struct box_client *talk)
{
    struct answer *answer = answer_new(request->cli->si);
    answer_words(answer, "state", "black box", "%s", mr_box_condition_text(talk->state.state));
    answer_count(answer, NULL, "sectors", talk->space.sectors);
    answer_count(answer, "ready_sectors", "erased", talk->state.ready);
    answer_count(answer, "reserve_sectors", "a landing needs", talk->state.reserve);
    answer_count(answer, "dirty_sectors", "to be erased", talk->space.dirty);
    answer_count(answer, "bad_sectors", "bad", talk->space.bad);
    answer_value(answer, "wear", "erases each", UNIT_NUMBER, (double)talk->space.wear, 2);
    answer_value(answer, "wait", NULL, UNIT_TIME, (double)talk->state.wait_s, 1);
    answer_table(answer, "records", "");
    for (size_t i = 0; i < talk->count; i++) {
        answer_row(answer);
        record_answer(&talk->records[i], answer);
    }
    answer_close(answer);
    return answer_show(request->cli, answer, 0);
}

static int tell_read(const struct request *request, const struct box_client_record *r,
                     size_t absent, const struct boxfill *filled)
{
    struct answer *answer = answer_new(request->cli->si);
    record_answer(r, answer);
    answer_count(answer, "absent_pages", "not read", (int64_t)absent)->end = " pages";
    answer_words(answer, "db", NULL, "%s", request->db);
    answer_count(answer, "run", "RUN", filled->run)->end = filled->made ? " (new)" : NULL;
    answer_flag(answer, "new_landing", NULL, filled->made);
    answer_count(answer, "filled_blocks", "filled", filled->filled_blocks)->end =
        " blocks from the black box";
    answer_count(answer, "filled_edges", "filled edges", filled->filled_edges);
    answer_count(answer, "absent_blocks", "absent", filled->absent_blocks)->end =
        " blocks, there too";
    return answer_show(request->cli, answer, absent ? mr_status_exit_code(MR_LIMIT) : 0);
}

/* The record names the configuration that it was recorded by; the board tells it as long as it is
 * in force. Without it only replay does worse, so what fails here is told and no more. */
static enum mr_status keep_configuration(const struct request *request, struct box_client *talk,
                                         struct store *store, int64_t run, struct error *error)
{
    static struct config_client other;
    static struct mr_config config;
    struct store_landing landing;
    struct error why = {0};
    char *text = NULL;
    uint32_t crc = 0;
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status == MR_OK && landing.config_crc != STORE_NONE)
        status = store_configuration_get(store, (uint32_t)landing.config_crc, &text, error);
    bool there = text != NULL || landing.config_crc == STORE_NONE;
    free(text);
    if (status != MR_OK || there)
        return status;
    if (config_client_begin(&other, talk->dialogue, &why) == MR_OK)
        (void)config_client_get(&other, &config, &crc, &why);
    if (why.status == MR_OK && crc == (uint32_t)landing.config_crc) {
        text = config_text_write(&config);
        status = store_configuration_put(store, crc, text, error);
        free(text);
    } else {
        cli_note(request->cli, "the configuration of the landing, CRC %08x, is not to be had: %s",
                 (unsigned)landing.config_crc,
                 why.status == MR_OK ? "the board has another one by now; replay will differ"
                                     : why.text);
    }
    return status;
}

static int read_record(const struct request *request, struct box_client *talk, uint16_t number,
                       struct error *error)
{
    const struct box_client_record *r = NULL;
    struct boxfill filled = {0};
    for (size_t i = 0; i < talk->count; i++) {
        if (talk->records[i].record.record == number)
            r = &talk->records[i];
    }
    if (!r) {
        error_set(error, MR_UNKNOWN, "no record %u in the black box: %s; see matrig board list",
                  number, request->serial);
        return cli_fail(error);
    }
    size_t count = r->record.pages, absent = 0;
    uint8_t(*pages)[MR_BOXPAGE] = xcalloc(count + 1, MR_BOXPAGE);
    uint8_t *present = xcalloc(count + 1, 1);
    enum mr_status status = box_client_read(talk, r, pages, present, error);
    for (size_t i = 0; i < count; i++)
        absent += !present[i];
    struct store *store = NULL;
    if (status == MR_OK)
        status = store_open(request->db, STORE_CREATE, &store, error);
    if (status == MR_OK)
        status = boxfill(store, request->serial, request->run, (const uint8_t(*)[MR_BOXPAGE])pages,
                         present, count, &filled, error);
    if (status == MR_OK)
        status = keep_configuration(request, talk, store, filled.run, error);
    store_close(store);
    free(pages);
    free(present);
    return status == MR_OK ? tell_read(request, r, absent, &filled) : cli_fail(error);
}

static int talk_to_board(const struct request *request, const char *verb, uint16_t number,
                         struct error *error)
{
    struct dialogue dialogue;
    struct box_client *talk = xcalloc(1, sizeof *talk);
    int exit_code;
    enum mr_status status = dialogue_open(&dialogue, NULL, request->serial, error);
    if (status == MR_OK)
        status = box_client_begin(talk, &dialogue, error);
    if (status == MR_OK)
        status = strcmp(verb, "free") == 0 ? box_client_free(talk, number, error)
                                           : box_client_list(talk, error);
    if (status != MR_OK)
        exit_code = cli_fail(error);
    else if (strcmp(verb, "read") == 0)
        exit_code = read_record(request, talk, number, error);
    else if (strcmp(verb, "list") == 0)
        exit_code = list(request, talk);
    else
        exit_code = request->cli->json ? cli_print_json(json_pack("{si}", "freed", number), 0) : 0;
    dialogue_close(&dialogue);
    free(talk);
    return exit_code;
}

/* ---- which board, and which image it runs ---- */

static int print_identity(const struct request *request, const struct identity *identity,
                          const struct imagefile *image)
{
    const struct mr_hello *hello = &identity->hello;
    char commit[MR_IMAGE_COMMIT_TEXT] = "unknown", uid[IDENTITY_UID_TEXT], version[12],
         why[200] = "";
    bool same = image && identity_runs(identity, &image->header, why, sizeof why);
    unsigned state = identity->commit_known ? identity->commit.state : (unsigned)MR_IMAGE_NONE;
    int exit_code = (image && !same) || state != MR_IMAGE_GOOD ? mr_status_exit_code(MR_LIMIT) : 0;
    if (identity->commit_known)
        mr_image_commit_text(identity->commit.commit, identity->commit.commit_more,
                             identity->commit.changed != 0, commit);
    identity_uid_text(identity, uid);
    snprintf(version, sizeof version, "%u.%u.%u", hello->major, hello->minor, hello->patch);
    struct answer *answer = answer_new(request->cli->si);
    answer_words(answer, "board", "board", "%s", uid);
    if (identity->board_known && mr_board_of(identity->board))
        answer_words(answer, "kind", "kind of board", "%s", mr_board_of(identity->board)->name);
    else
        answer_none(answer, "kind", NULL, NULL);
    answer_words(answer, "firmware", "firmware", "%s", version);
    answer_words(answer, "commit", "commit", "%s", commit);
    answer_count(answer, "image_crc", NULL, identity->image_crc);
    answer_words(answer, NULL, "program", "%08x", (unsigned)identity->image_crc);
    answer_words(answer, "image", "image", "%s", mr_image_state_text(state));
    if (image) {
        answer_open(answer, "compared", "");
        answer_words(answer, "file", "compared", "%s", image->path);
        answer_flag(answer, "same", "it runs that", same);
        answer_words(answer, "difference", same ? NULL : "difference", "%s", why);
        answer_close(answer);
    } else
        answer_none(answer, "compared", NULL, NULL);
    return answer_show(request->cli, answer, exit_code);
}

static int tell_identity(const struct request *request, struct error *error)
{
    struct imagefile image = {0};
    struct dialogue dialogue = {0};
    int exit_code;
    enum mr_status status = request->image ? imagefile_read(request->image, &image, error) : MR_OK;
    if (status == MR_OK && request->image && !image.stamped)
        status = error_set(error, MR_UNKNOWN,
                           "an image without matrig's header: %s; nothing to compare with",
                           request->image);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, NULL, request->serial, error);
    if (status == MR_OK)
        status = dialogue_who(&dialogue, DIALOGUE_HELLO_S, error);
    if (status == MR_TIMEOUT)
        status = dialogue_no_hello(&dialogue, error);
    struct error late = {0}; /* an old board does not say which kind it is */
    if (status == MR_OK)
        (void)dialogue_until(&dialogue, dialogue_flag, &dialogue.identity.board_known, KIND_S,
                             &late);
    exit_code = status == MR_OK
                  ? print_identity(request, &dialogue.identity, request->image ? &image : NULL)
                  : cli_fail(error);
    dialogue_close(&dialogue);
    if (request->image)
        imagefile_free(&image);
    return exit_code;
}

/* What each verb takes beside --serial. */
struct verb {
    const char *name;
    bool number, file, db, elf;
};

static const struct verb verbs[] = {
    {.name = "list"},
    {.name = "read", .number = true, .db = true},
    {.name = "free", .number = true},
    {.name = "health", .elf = true},
    {.name = "self-test"},
    {.name = "reset"},
};

static const struct verb *find_verb(const char *name)
{
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++) {
        if (strcmp(verbs[i].name, name) == 0)
            return &verbs[i];
    }
    return NULL;
}

static enum mr_status check_request(const struct request *request, const struct verb *verb,
                                    const char *number, struct error *error)
{
    static const struct verb none = {.name = ""};
    const char *name = verb ? verb->name : "";
    if (!verb)
        verb = &none;
    if (number && !verb->number)
        return error_set(error, MR_USAGE, "%s takes no number: '%s'; see matrig board --help", name,
                         number);
    if (!number && verb->number)
        return error_set(error, MR_USAGE,
                         "which record? matrig board %s needs its number, see matrig board list",
                         name);
    if (!request->serial)
        return error_set(error, MR_USAGE,
                         "no link: matrig board needs --serial LINK; see matrig board --help");
    if (request->image && verb != &none)
        return error_set(error, MR_USAGE,
                         "--image is compared with the board's alone: leave '%s' out", name);
    if (request->run && !(verb->number && verb->db))
        return error_set(error, MR_USAGE, "--run is read's: matrig board %s", name);
    if (request->db && !verb->db)
        return error_set(error, MR_USAGE, "--db is read's: matrig board %s", name);
    if (request->elf && !verb->elf)
        return error_set(error, MR_USAGE, "--elf is health's: matrig board %s", name);
    if (verb->number && verb->db && !request->db)
        return error_set(error, MR_USAGE, "nowhere to put it: matrig board %s needs --db DB", name);
    return MR_OK;
}

static enum mr_status refuse_word(const char *word, struct error *error)
{
    char near[SPELL_SUGGEST_TEXT];
    help_suggest_word(&command_board, word, near);
    return error_set(error, MR_UNKNOWN,
                     "not list, read, free, config, runway, arm, disarm, zero, shunt, "
                     "bringup, health, self-test or reset: '%s'%s%s see matrig board --help",
                     word, near, near[0] ? "" : ";");
}

static int board_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    const char *words[2];
    struct error error = {0};
    double number = 0.0;
    static const struct {
        const char *word;
        const struct command *command;
    } apart[] = {{"config", &command_board_config},   {"runway", &command_board_runway},
                 {"arm", &command_board_arm},         {"disarm", &command_board_arm},
                 {"bringup", &command_board_bringup}, {"zero", &command_board_gages},
                 {"shunt", &command_board_gages}};
    for (int i = 1; i < argc; i++) {
        for (size_t k = 0; k < sizeof apart / sizeof apart[0]; k++) {
            if (strcmp(argv[i], apart[k].word) == 0)
                return apart[k].command->run(argc, argv, cli);
        }
    }
    enum mr_status status = command_parse(&command_board, argc, argv, cli, &request, words, &error);
    const struct verb *verb = status == MR_OK && words[0] ? find_verb(words[0]) : NULL;
    if (status == MR_OK && words[0] && !verb)
        status = refuse_word(words[0], &error);
    if (status == MR_OK)
        status = check_request(&request, verb, words[1], &error);
    if (status == MR_OK && words[1])
        status = cli_number(words[1], "the record", 1, 65535, &number, &error);
    if (status != MR_OK)
        return cli_fail(&error);
    if (!verb)
        return tell_identity(&request, &error);
    if (board_health_verb(verb->name))
        return board_health(request.serial, verb->name, request.elf, cli);
    return talk_to_board(&request, verb->name, (uint16_t)number, &error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); the board must be idle"),
    HELP_ITEM("(no word)",
              "the board, its firmware's version, commit and CRC, and whether the image is whole; "
              "--image FILE (.elf,\n"
              ".hex, .bin) compares it with a file. Exit 1 when it differs or is not whole"),
    HELP_WORD("list", "its records, and how much room there is"),
    HELP_WORD(
        "read N",
        "record N: --db fills what is missing of its landing in a campaign database (the "
        "landing of the same\n"
        "board, number and arming, or RUN; made when there is none). Exit 1 when a page cannot "
        "be read"),
    HELP_WORD("free N", "give its space back; nothing is ever overwritten that was not freed"),
    HELP_WITH(command_board_config),
    HELP_WITH(command_board_runway),
    HELP_WITH(command_board_arm),
    HELP_WITH(command_board_gages),
    HELP_WITH(command_board_bringup),
    HELP_WORD("health", "restarts and their causes, memories, stack, CAN, faults, what a processor "
                        "fault left behind (--elf F names\n"
                        "its functions). Exit 1 when there is a fault"),
    HELP_WORD("self-test", "memories, reference, excitation, black box, warning lamp (it lights "
                           "for 0.2 s). Exit 1 when one fails"),
    HELP_WORD("reset", "restart it"),
    HELP_EXAMPLE("matrig board --serial serial:/dev/ttyUSB0 read 3 --db campaign.db"),
    OPTION_TEXT("--db", "DB", db, NULL),
    OPTION_RUN("--run", "RUN", run, NULL),
    OPTION_TEXT("--elf", "F", elf, NULL),
    OPTION_TEXT("--image", "FILE", image, NULL),
};

const struct command command_board = {
    "board",
    board_command,
    "--serial LINK [--image FILE] | list | read N --db DB [--run RUN] | free "
    "N |\n"
    "                        config get|set|check [-o F] [--force] [--can LINK] | "
    "runway [show|load F|forget] [-o F] |\n"
    "                        arm [LANDING] [--can LINK] | disarm [--can LINK] | zero [1|2] | shunt "
    "| health [--elf F] | "
    "self-test | reset |\n"
    "                        bringup [report|memory|brown-out|rom]",
    "a board: its bring-up, firmware, black box, configuration, runway and health",
    COMMAND_PARTS(parts),
    {0, 2, "list|read N|free N|config|runway|arm|disarm|zero|shunt|bringup|health|self-test|reset"},
};
