/* The command matrig board, with subcommands for identity, black box, health, zeros, runway and
 * arming of a board. Configuration and bring-up have files of their own. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "common/boxpage.h"
#include "common/catalogue.h"
#include "common/command.h"
#include "common/crc32.h"
#include "common/wire.h"
#include "host/base/answer.h"
#include "host/base/help.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"
#include "host/board/arm_client.h"
#include "host/board/config_client.h"
#include "host/board/config_text.h"
#include "host/board/gage_client.h"
#include "host/board/health_client.h"
#include "host/board/imagefile.h"
#include "host/board/keyfile.h"
#include "host/board/runway_client.h"
#include "host/collect/backfill.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"

#define BOX_READ_ROUNDS_MAX 6 /* how many times missing pages are requested */
#define BOX_PAGE_BITS       15u
/* the board sends its identity and the state of its key once a second */
#define IDENTITY_TIMEOUT_S  1.2
/* Erasing the memory twice takes 0.8 s, or 6 s if it fails three times. */
#define KEY_TIMEOUT_S       20.0
#define HMIL_PER_IN         100000.0
#define OPENINGS_PER_ROW    7u /* joint openings in one row of the table */
#define CLOSED_OPENING_MAX_HMIL \
    200u /* 0.002 in: the predictor regards a smaller opening as closed */

struct request {
    const struct cli *cli;
    const char *serial, *can, *db, *image, *out;
    const char *words[3]; /* subcommand and its arguments */
    int64_t run;
    int32_t number; /* numeric argument of the subcommand; 0: none */
    bool force;
    struct mr_predictor_state runway; /* contents of the runway file to load */
};

/* ---- black box ---- */

#define BOX_CLIENT_RECORDS_MAX 256u

struct box_client_record {
    struct mr_box_record record;
    struct mr_box_span span;
};

struct box_client {
    struct dialogue *dialogue;
    bool state_known, space_known;
    struct mr_box_state state;
    struct mr_box_space space;
    struct box_client_record records[BOX_CLIENT_RECORDS_MAX];
    size_t count;
    bool is_list_complete;
    /* record that is being read */
    uint16_t record_number;
    uint8_t (*pages)[MR_BOXPAGE_BYTES];
    uint8_t *is_page_present;
    size_t page_count, received_parts;
    uint8_t half_page_bytes[MR_BOXPAGE_BYTES / 2];
    uint32_t half_page_number; /* page whose first half is in half_page_bytes */
    bool has_transfer_ended;
};

static void handle_page_part(struct box_client *client, const uint8_t *payload)
{
    const uint8_t *p = payload;
    uint16_t record = mr_get_u16(&p);
    uint16_t page = mr_get_u16(&p);
    uint8_t part = mr_get_u8(&p);
    struct mr_boxpage_header header;
    uint8_t whole[MR_BOXPAGE_BYTES];
    if (!client->pages || record != client->record_number || page >= client->page_count)
        return;
    client->received_parts++;
    if (part == 0) {
        memcpy(client->half_page_bytes, p + 1, sizeof client->half_page_bytes);
        client->half_page_number = page;
    } else if (part == 1 && client->half_page_number == page) {
        memcpy(whole, client->half_page_bytes, sizeof client->half_page_bytes);
        memcpy(whole + sizeof client->half_page_bytes, p + 1, sizeof client->half_page_bytes);
        if (mr_boxpage_check(whole, &header) == MR_OK && header.record == record) {
            memcpy(client->pages[page], whole, sizeof whole);
            client->is_page_present[page] = 1;
        }
    }
}

static enum mr_status handle_blackbox_message(void *context, const struct dialogue_message *message,
                                              struct error *error)
{
    struct box_client *client = context;
    struct mr_box_end end;
    struct mr_box_record record;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    (void)error;
    switch (message->id) {
    case MR_ID_BOX_STATE:
        client->state_known |= mr_box_state_get(&client->state, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_SPACE:
        client->space_known |= mr_box_space_get(&client->space, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_RECORD:
        if (mr_box_record_get(&record, bytes, length) != MR_OK)
            break;
        if (!record.record)
            client->is_list_complete = true;
        else if (client->count < BOX_CLIENT_RECORDS_MAX)
            client->records[client->count++].record = record;
        break;
    case MR_ID_BOX_SPAN:
        if (client->count)
            (void)mr_box_span_get(&client->records[client->count - 1].span, bytes, length);
        break;
    case MR_ID_BOX_PART:
        if (length == MR_BOX_PART_BYTES)
            handle_page_part(client, bytes);
        break;
    case MR_ID_BOX_END:
        client->has_transfer_ended |= mr_box_end_get(&end, bytes, length) == MR_OK &&
                                      end.record == client->record_number;
        break;
    default: break;
    }
    return MR_OK;
}

static void box_client_begin(struct box_client *client, struct dialogue *dialogue)
{
    memset(client, 0, sizeof *client);
    client->dialogue = dialogue;
    client->half_page_number = UINT32_MAX;
    dialogue_subscribe(dialogue, handle_blackbox_message, client);
    dialogue_wait_for_hello(dialogue, NULL, NULL, fatal);
}

/* Sends a command, and repeats it while the board answers MR_WAIT. */
static void send_box_command(struct box_client *client, uint8_t code, int32_t argument)
{
    struct dialogue *dialogue = client->dialogue;
    const struct dialogue_command order = {
        .code = code, .argument = argument, .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S};
    struct mr_ack ack;
    double until_s = dialogue_now_s(dialogue) + DIALOGUE_ANSWER_TIMEOUT_S;
    enum mr_status status = dialogue_send_command(dialogue, &order, &ack, fatal);
    while (status == MR_OK && ack.status == MR_WAIT && dialogue_now_s(dialogue) < until_s)
        status = dialogue_receive(dialogue, DIALOGUE_RECEIVE_MAX_S, fatal)
                   ?: dialogue_send_command(dialogue, &order, &ack, fatal);
    if (status == MR_TIMEOUT)
        dialogue_set_no_answer_error(dialogue, code, fatal);
    if (ack.status == MR_UNKNOWN)
        error_set(fatal, MR_UNKNOWN,
                  "the black box has no such record: %s; list the records with matrig board list",
                  dialogue_spec(dialogue));
    if (ack.status != MR_OK)
        dialogue_set_refusal_error(
            dialogue, &ack, "a landing is armed or in progress, or the board has no black box",
            fatal);
}

/* Requests state, free space and the list of records. A timeout or a refusal ends the program. */
static void box_client_list_records(struct box_client *client)
{
    client->count = 0;
    client->is_list_complete = false;
    send_box_command(client, MR_COMMAND_BOX_LIST, 0);
    if (dialogue_wait_until(client->dialogue, dialogue_is_flag_set, &client->is_list_complete,
                            DIALOGUE_ANSWER_TIMEOUT_S, fatal) == MR_TIMEOUT)
        error_set(fatal, MR_TIMEOUT, "the list of records timed out: %s; try again",
                  dialogue_spec(client->dialogue));
}

static size_t find_first_missing_page(const struct box_client *client)
{
    size_t page = 0;
    while (page < client->page_count && client->is_page_present[page])
        page++;
    return page;
}

/* Reads the pages of a listed record, except those marked in `is_page_present`. Pages that cannot
 * be read stay unmarked. Both arrays have room for record.pages. */
static void box_client_read_record(struct box_client *client,
                                   const struct box_client_record *record,
                                   uint8_t (*pages)[MR_BOXPAGE_BYTES], uint8_t *present)
{
    client->record_number = record->record.record;
    client->pages = pages;
    client->is_page_present = present;
    client->page_count = record->record.pages;
    for (int round = 0;
         round < BOX_READ_ROUNDS_MAX && find_first_missing_page(client) < client->page_count;
         round++) {
        client->has_transfer_ended = false;
        send_box_command(client, MR_COMMAND_BOX_READ,
                         (int32_t)((uint32_t)client->record_number << BOX_PAGE_BITS |
                                   find_first_missing_page(client)));
        /* the next round requests the pages that are still missing */
        dialogue_wait_while_receiving(client->dialogue, dialogue_is_flag_set,
                                      &client->has_transfer_ended, &client->received_parts,
                                      DIALOGUE_ANSWER_TIMEOUT_S, fatal);
    }
    client->pages = NULL;
}

static void add_record(const struct box_client_record *r, struct answer *answer)
{
    answer_add_count(answer, "record", "record", r->record.record);
    answer_add_count(answer, "landing", "landing", r->record.landing);
    answer_add_count(answer, "pages", "pages", r->record.pages);
    answer_add_flag(answer, "complete", NULL, r->record.complete);
    answer_add_count(answer, "first_block", NULL, (int64_t)r->span.first_block);
    answer_add_count(answer, "blocks", NULL, r->span.blocks);
    answer_add_value(answer, NULL, "duration", UNIT_TIME,
                     r->record.complete ? (double)r->span.blocks / 1000.0 : (double)NAN, 3);
    answer_add_count(answer, "lost", "blocks lost", r->span.lost);
    answer_add_text(answer, NULL, "end", "%s",
                    r->record.complete ? "closed" : "not closed: power was lost");
}

static int list_records(const struct request *request, const struct box_client *client)
{
    struct answer *answer = answer_new(request->cli->si);
    answer_add_text(answer, "state", "black box", "%s", mr_box_condition_text(client->state.state));
    answer_add_count(answer, NULL, "sectors", client->space.sectors);
    answer_add_count(answer, "ready_sectors", "erased", client->state.ready);
    answer_add_count(answer, "reserve_sectors", "needed for arming", client->state.reserve);
    answer_add_count(answer, "dirty_sectors", "not yet erased", client->space.dirty);
    answer_add_count(answer, "bad_sectors", "bad", client->space.bad);
    answer_add_value(answer, "wear", "erases per sector", UNIT_NUMBER, (double)client->space.wear,
                     2);
    answer_add_value(answer, "wait", NULL, UNIT_TIME, (double)client->state.wait_s, 1);
    answer_open_table(answer, "records", "");
    for (size_t i = 0; i < client->count; i++) {
        answer_open_row(answer);
        add_record(&client->records[i], answer);
    }
    answer_close_group(answer);
    return answer_print(request->cli, answer, 0);
}

static int report_record(const struct request *request, const struct box_client_record *r,
                         size_t absent, const struct backfill *filled)
{
    struct answer *answer = answer_new(request->cli->si);
    add_record(r, answer);
    answer_add_count(answer, "absent_pages", "not read", (int64_t)absent)->suffix = " pages";
    answer_add_text(answer, "db", NULL, "%s", request->db);
    answer_add_count(answer, "run", "RUN", filled->run)->suffix = filled->is_new_landing ? " (new)"
                                                                                         : NULL;
    answer_add_flag(answer, "new_landing", NULL, filled->is_new_landing);
    answer_add_count(answer, "filled_blocks", "blocks added", filled->filled_blocks)->suffix =
        " from the black box";
    answer_add_count(answer, "filled_edges", "edges added", filled->filled_edges);
    answer_add_count(answer, "absent_blocks", "blocks missing", filled->missing_blocks)->suffix =
        " (missing in the black box, too)";
    return answer_print(request->cli, answer, absent ? mr_status_exit_code(MR_LIMIT) : 0);
}

/* Stores the configuration under which the record was made, if it is still the board's
 * configuration. Only replay needs it, so a failure is only printed. */
static void store_configuration(const struct request *request, struct box_client *client,
                                struct store *store, int64_t run)
{
    static struct config_client other;
    static struct mr_config config;
    struct store_landing landing;
    struct error why = {0};
    char *text = NULL;
    uint32_t crc = 0;
    store_landing_get(store, run, &landing, fatal);
    if (landing.config_crc == STORE_NONE)
        return;
    store_configuration_get(store, (uint32_t)landing.config_crc, &text, fatal);
    bool there = text != NULL;
    free(text);
    if (there)
        return;
    if (config_client_begin(&other, client->dialogue, &why) == MR_OK)
        (void)config_client_get(&other, &config, &crc, &why);
    if (why.status == MR_OK && crc == (uint32_t)landing.config_crc) {
        text = config_text_write(&config);
        store_configuration_put(store, crc, text, fatal);
        free(text);
    } else {
        cli_note(request->cli, "cannot read the configuration of the landing (CRC %08x): %s",
                 (unsigned)landing.config_crc,
                 why.status == MR_OK
                     ? "the board now has a different configuration, so a replay will differ"
                     : why.text);
    }
}

static int read_record(const struct request *request, struct box_client *client)
{
    const struct box_client_record *r = NULL;
    struct backfill filled = {0};
    for (size_t i = 0; i < client->count; i++) {
        if (client->records[i].record.record == request->number)
            r = &client->records[i];
    }
    if (!r) {
        error_set(fatal, MR_UNKNOWN,
                  "no record %d in the black box: %s; list the records with matrig board list",
                  (int)request->number, request->serial);
        return 0;
    }
    size_t count = r->record.pages, absent = 0;
    uint8_t(*pages)[MR_BOXPAGE_BYTES] = xcalloc(count + 1, MR_BOXPAGE_BYTES);
    uint8_t *present = xcalloc(count + 1, 1);
    box_client_read_record(client, r, pages, present);
    for (size_t i = 0; i < count; i++)
        absent += !present[i];
    struct store *store = program_open_or_create_campaign(request->cli, request->db);
    int64_t run = request->run;
    store_find_run(store, &run, fatal);
    backfill_store_record(store, request->serial, run, (const uint8_t(*)[MR_BOXPAGE_BYTES])pages,
                          present, count, &filled, fatal);
    store_configuration(request, client, store, filled.run);
    free(pages);
    free(present);
    return report_record(request, r, absent, &filled);
}

static int run_box(const struct request *request, struct dialogue *dialogue)
{
    static struct box_client client;
    const char *subcommand = request->words[0];
    box_client_begin(&client, dialogue);
    if (strcmp(subcommand, "free") == 0) {
        send_box_command(&client, MR_COMMAND_BOX_FREE, request->number);
        return request->cli->json
                 ? cli_print_json(json_pack("{si}", "freed", (int)request->number), 0)
                 : 0;
    }
    box_client_list_records(&client);
    return strcmp(subcommand, "read") == 0 ? read_record(request, &client)
                                           : list_records(request, &client);
}

/* ---- which board, and which image it runs ---- */

static int print_identity(const struct request *request, const struct identity *identity,
                          const struct imagefile *image)
{
    const struct mr_hello *hello = &identity->hello;
    char commit[MR_IMAGE_COMMIT_TEXT] = "unknown", uid[IDENTITY_UID_SIZE], version[12],
         why[200] = "";
    bool same = image && identity_is_running(identity, &image->header, why, sizeof why);
    unsigned state = identity->commit_known ? identity->commit.state : (unsigned)MR_IMAGE_NO_HEADER;
    int exit_code = (image && !same) || state != MR_IMAGE_INTACT ? mr_status_exit_code(MR_LIMIT)
                                                                 : 0;
    if (identity->commit_known)
        mr_image_commit_text(identity->commit.commit, identity->commit.commit_more,
                             identity->commit.changed != 0, commit);
    identity_uid_text(identity, uid);
    snprintf(version, sizeof version, "%u.%u.%u", hello->major, hello->minor, hello->patch);
    struct answer *answer = answer_new(request->cli->si);
    answer_add_text(answer, "board", "board", "%s", uid);
    if (identity->board_known && mr_board_by_number(identity->board_type))
        answer_add_text(answer, "kind", "kind of board", "%s",
                        mr_board_by_number(identity->board_type)->name);
    else
        answer_add_missing_value(answer, "kind", NULL, NULL);
    answer_add_text(answer, "firmware", "firmware", "%s", version);
    answer_add_text(answer, "commit", "commit", "%s", commit);
    answer_add_count(answer, "image_crc", NULL, identity->image_crc);
    answer_add_text(answer, NULL, "program", "%08x", (unsigned)identity->image_crc);
    answer_add_text(answer, "image", "image", "%s", mr_image_state_text(state));
    if (identity->key_known)
        answer_add_text(answer, "orders", "orders", "%s", mr_key_state_text(identity->key.state));
    else
        answer_add_missing_value(answer, "orders", NULL, NULL);
    if (image) {
        answer_open_group(answer, "compared", "");
        answer_add_text(answer, "file", "compared", "%s", image->path);
        answer_add_flag(answer, "same", "running this image", same);
        answer_add_text(answer, "difference", same ? NULL : "difference", "%s", why);
        answer_close_group(answer);
    } else
        answer_add_missing_value(answer, "compared", NULL, NULL);
    return answer_print(request->cli, answer, exit_code);
}

static int report_identity(const struct request *request, struct dialogue *dialogue)
{
    struct imagefile image = {0};
    if (request->image)
        imagefile_read(request->image, &image, fatal);
    if (request->image && !image.has_header)
        error_set(fatal, MR_UNKNOWN,
                  "the image has no matrig header: %s; give an image built by matrig",
                  request->image);
    if (dialogue_wait_for_identity(dialogue, DIALOGUE_HELLO_TIMEOUT_S, fatal) == MR_TIMEOUT)
        dialogue_set_no_hello_error(dialogue, fatal);
    struct error late = {0}; /* ignore an error: older firmware does not send the board type */
    (void)dialogue_wait_until(dialogue, dialogue_is_flag_set, &dialogue->identity.key_known,
                              IDENTITY_TIMEOUT_S, &late);
    int exit_code = print_identity(request, &dialogue->identity, request->image ? &image : NULL);
    if (request->image)
        imagefile_free(&image);
    return exit_code;
}

/* ---- zero and shunt calibration ---- */

static void add_shunts(const struct gage_client *client, struct answer *answer)
{
    answer_open_table(answer, "shunts", "");
    for (unsigned i = 0; i < client->shunts.count; i++) {
        const struct mr_shunt_result *r = &client->shunts.result[i];
        const struct mr_shunt_check *c = &client->shunts.check[i];
        answer_open_row(answer);
        answer_add_count(answer, "gage", "gage", r->gage);
        answer_add_value(answer, "span", "span", UNIT_TENSION, (double)r->span_lb, 3)->digits = 7;
        answer_add_value(answer, "expected", "expected", UNIT_TENSION, (double)c->expected_lb, 2);
        answer_add_value(answer, "noise", "noise", UNIT_TENSION, (double)r->noise_lb, 3);
        answer_add_value(answer, "change", "change", UNIT_TENSION, (double)c->change_lb, 3)
            ->shows_sign = true;
        answer_add_value(answer, NULL, "at rest", UNIT_TENSION, (double)c->zero_change_lb, 3)
            ->shows_sign = true;
        answer_add_text(answer, "verdict", "verdict", "%s", shunts_verdict_text(r->verdict));
    }
    answer_close_group(answer);
}

static void add_zeros(const struct gage_client *client, struct answer *answer)
{
    answer_open_table(answer, "zeros", "");
    for (unsigned i = 0; i < client->zero_count; i++) {
        const struct mr_zero_result *z = &client->zero[i];
        bool tension = z->index >= MR_TRANSDUCERS;
        answer_open_row(answer);
        answer_add_text(answer, NULL, "channel", "%s %u", tension ? "gage" : "transducer",
                        tension ? z->index - MR_TRANSDUCERS + 1u : z->index + 1u);
        answer_add_count(answer, "channel", NULL, z->index);
        answer_add_value(answer, "zero_code", "zero, codes", UNIT_NUMBER, (double)z->zero_code, 3)
            ->digits = 7;
        answer_add_value(answer, "spread_codes", "spread, codes", UNIT_NUMBER,
                         (double)z->spread_codes, 2);
        answer_add_text(answer, "verdict", "verdict", "%s", mr_zero_verdict_text(z->verdict));
    }
    answer_close_group(answer);
}

static int run_gages(const struct request *request, struct dialogue *dialogue)
{
    static struct gage_client client;
    bool zero = strcmp(request->words[0], "zero") == 0;
    gage_client_send(&client, dialogue, zero ? MR_COMMAND_ZERO : MR_COMMAND_SHUNT, request->number,
                     fatal);
    bool good = client.ack.status == MR_OK;
    struct answer *answer = answer_new(request->cli->si);
    answer_add_flag(answer, "good", NULL, good);
    add_shunts(&client, answer);
    add_zeros(&client, answer);
    if (zero)
        answer_add_sentence(answer, NULL,
                            good ? "these zeros are active until the board is reset or reconfigured"
                                 : "no zero was measured");
    return answer_print(request->cli, answer, good ? 0 : mr_status_exit_code(MR_LIMIT));
}

/* ---- arm and disarm ---- */

static json_t *arm_to_json(const char *word, const struct arm_client *client,
                           const struct error *error)
{
    json_t *json = json_pack("{sssb}", "command", word, "done", error->status == MR_OK);
    json_object_set_new(json, "state",
                        client->landing_known
                            ? json_string(mr_landing_state_text(client->landing.state))
                            : json_null());
    json_object_set_new(json, "landing",
                        client->landing_known ? json_integer(client->landing.landing)
                                              : json_null());
    json_object_set_new(json, "error",
                        error->status == MR_OK ? json_null() : json_string(error->text));
    return json;
}

/* Arms or disarms the board. */
static int run_arm(const struct request *request, struct dialogue *dialogue)
{
    struct error error = {0};
    struct arm_client client = {0};
    bool arms = strcmp(request->words[0], "arm") == 0;
    if (!cli_confirm(
            arms ? "Arm the board? It records until the gear has stopped and the mat is at rest."
                 : "Disarm the board? The recording then ends."))
        error_set(fatal, MR_USAGE, "not confirmed (the answer was not yes): nothing was sent");
    enum mr_status status = arm_client_begin(&client, dialogue, &error)
                              ?: arm_client_send(&client, arms ? MR_COMMAND_ARM : MR_COMMAND_DISARM,
                                                 request->number, &error);
    int exit_code = status == MR_OK ? 0 : cli_fail(&error);
    if (request->cli->json)
        return cli_print_json(arm_to_json(request->words[0], &client, &error), exit_code);
    if (status == MR_OK && arms)
        printf("armed for landing %u: the board records until the gear has stopped and the mat is "
               "at rest\n",
               client.landing.landing);
    else if (status == MR_OK)
        puts("disarmed: the board is idle");
    return exit_code;
}

/* ---- runway state of the predictor ---- */

static const char *runway_copy_text(unsigned copy, char out[40])
{
    if (copy == MR_RUNWAY_COPY_INTACT || copy >= MR_RUNWAY_NOT_READ)
        return mr_runway_copy_text(copy);
    snprintf(out, 40, "damaged (%s)", mr_status_text((enum mr_status) - (int)copy));
    return out;
}

static double segment_opening_in(const struct mr_predictor_state *state, unsigned segment)
{
    unsigned sum = 0;
    for (unsigned j = 10 * segment; j < 10 * segment + 10 && j <= state->mats; j++)
        sum += state->gap_counts[j];
    return sum / HMIL_PER_IN;
}

static unsigned count_closed_joints(const struct mr_predictor_state *state)
{
    unsigned closed = 0;
    for (unsigned j = 0; j <= state->mats; j++)
        closed += state->gap_counts[j] <= CLOSED_OPENING_MAX_HMIL;
    return closed;
}

static int print_runway(const struct runway_client *client, const struct cli *cli)
{
    const struct mr_predictor_state *state = &client->state;
    const struct mr_runway_store *stored = &client->stored;
    struct answer *answer = answer_new(cli->si);
    char a[40], b[40];
    answer_add_text(answer, "source", "runway", "%s", mr_runway_source_text(stored->source));
    answer_add_count(answer, "mats", "mats", state->mats);
    answer_add_count(answer, "landings", "landings", state->landing_count);
    answer_add_value(answer, "resistance", "resistance", UNIT_NUMBER,
                     (double)state->resistance_scale, 2)
        ->suffix = " times the configured closing resistance";
    answer_add_count(answer, "crc", NULL, (int64_t)stored->crc);
    answer_add_text(answer, NULL, "CRC", "%08x", (unsigned)stored->crc);
    answer_add_text(answer, "copy_a", "copy A", "%s", runway_copy_text(stored->copy_a, a));
    answer_add_text(answer, "copy_b", "copy B", "%s", runway_copy_text(stored->copy_b, b));
    answer_add_count(answer, "closed_joints", NULL, count_closed_joints(state));
    answer_add_text(answer, NULL, "joints", "%u of %u closed to within 0.002 in",
                    count_closed_joints(state), state->mats + 1u);
    answer_open_list(answer, "gap_in", NULL);
    for (unsigned j = 0; j <= state->mats; j++)
        answer_add_value(answer, NULL, NULL, UNIT_NUMBER, state->gap_counts[j] / HMIL_PER_IN, 5);
    answer_close_group(answer);
    answer_open_table(
        answer, NULL,
        "opening of each joint; the first column is the number of the first joint in the row");
    for (unsigned s = 0; 10 * s <= state->mats; s += OPENINGS_PER_ROW) {
        answer_open_row(answer);
        answer_add_count(answer, NULL, "joint", 10 * s + 1);
        for (unsigned i = 0; i < OPENINGS_PER_ROW && 10 * (s + i) <= state->mats; i++) {
            char label[12];
            snprintf(label, sizeof label, "+%u", 10 * i);
            answer_add_value(answer, NULL, label, UNIT_DISPLACEMENT,
                             segment_opening_in(state, s + i), 4);
        }
    }
    answer_close_group(answer);
    return answer_print(cli, answer, 0);
}

static void write_runway(const char *path, const struct mr_predictor_state *state)
{
    struct output output;
    output_begin(&output, path, fatal);
    FILE *file = output.file;
    fprintf(file,
            "# Runway of a board: openings of its joints in inches, upfield first. To load it into "
            "a board: matrig board runway load\nmats %u\nlandings %u\nresistance %.9g\n",
            state->mats, state->landing_count, (double)state->resistance_scale);
    for (unsigned j = 0; j <= state->mats; j++)
        fprintf(file, "joint %u %.5f\n", j + 1u, state->gap_counts[j] / HMIL_PER_IN);
    output_end(&output, fatal);
}

/* Reads one line of a runway file. Returns false if the line is not valid. */
static bool parse_runway_line(const char *line, struct mr_predictor_state *state, bool *given)
{
    unsigned number;
    double value;
    char rest;
    if (line[0] == '#' || strspn(line, " \t\r\n") == strlen(line))
        return true;
    if (sscanf(line, "mats %u %c", &number, &rest) == 1 && number >= 1 && number <= MR_CHAIN_MATS)
        return state->mats = (uint16_t)number, true;
    if (sscanf(line, "landings %u %c", &number, &rest) == 1 && number <= UINT16_MAX)
        return state->landing_count = (uint16_t)number, true;
    if (sscanf(line, "resistance %lf %c", &value, &rest) == 1 && isfinite(value))
        return state->resistance_scale = (float)value, true;
    struct quantity_error wrong;
    int used = 0;
    if (sscanf(line, "joint %u %n", &number, &used) != 1 || !used || number < 1 ||
        number > MR_RUNWAY_JOINTS || !quantity_parse(line + used, "in", NULL, &value, &wrong) ||
        !(value >= 0.0 && value * HMIL_PER_IN <= UINT16_MAX) || given[number - 1u])
        return false;
    given[number - 1u] = true;
    state->gap_counts[number - 1u] = (uint16_t)lround(value * HMIL_PER_IN);
    return true;
}

static void read_runway(const char *path, struct mr_predictor_state *state)
{
    bool given[MR_RUNWAY_JOINTS] = {false};
    char line[200];
    unsigned number = 0, joints = 0;
    FILE *file = fopen(path, "r");
    if (!file) {
        error_set(fatal, MR_IO,
                  "cannot be read (%s): %s; give a file that matrig board runway -o FILE wrote",
                  strerror(errno), path);
        return;
    }
    *state = (struct mr_predictor_state){.resistance_scale = 1.0f};
    while (fgets(line, sizeof line, file)) {
        number++;
        if (!parse_runway_line(line, state, given))
            error_set(fatal, MR_MALFORMED,
                      "not a line of a runway: `%.*s`: %s:%u; write joint NUMBER INCHES (or with a "
                      "unit: 2 mm), each joint once",
                      (int)strcspn(line, "\r\n"), line, path, number);
    }
    fclose(file);
    for (unsigned j = 0; j < MR_RUNWAY_JOINTS; j++)
        joints += given[j];
    if (state->mats == 0 || joints != state->mats + 1u)
        error_set(fatal, MR_MALFORMED,
                  "the runway is incomplete, with %u joints and %u mats: %s; give mats, and each "
                  "joint from 1 to mats + 1",
                  joints, state->mats, path);
}

static void check_runway(struct request *r)
{
    const char *subcommand = r->words[1] ? r->words[1] : "show", *file = r->words[2];
    bool load = strcmp(subcommand, "load") == 0;
    if (!load && strcmp(subcommand, "show") != 0 && strcmp(subcommand, "forget") != 0)
        error_set(fatal, MR_USAGE, "unknown action of runway: '%s'; give show, load or forget",
                  subcommand);
    if (load != (file != NULL))
        error_set(fatal, MR_USAGE,
                  load ? "no file to load; give matrig board runway load FILE"
                       : "unexpected file: '%s'; only the action load reads a file",
                  file);
    if (file)
        read_runway(file, &r->runway);
    output_check_new(r->out, r->force, fatal);
    output_check(r->out, file, fatal);
}

static int run_runway(const struct request *request, struct dialogue *dialogue)
{
    static struct runway_client client;
    runway_client_begin(&client, dialogue, fatal);
    if (request->words[2])
        runway_client_load(&client, &request->runway, fatal);
    else if (request->words[1] && strcmp(request->words[1], "forget") == 0)
        runway_client_discard(&client, fatal);
    runway_client_read(&client, fatal);
    if (request->out)
        write_runway(request->out, &client.state);
    return print_runway(&client, request->cli);
}

/* ---- the key for signed commands ---- */

static void send_key(struct dialogue *dialogue, const uint8_t key[MR_KEY_BYTES])
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    uint16_t tag = dialogue_next_tag(dialogue);
    for (unsigned i = 0; i < MR_KEY_WORDS; i++) {
        const uint8_t *p = key + 4 * i;
        const struct mr_key_word word = {.index = (uint8_t)i, .tag = tag, .value = mr_get_u32(&p)};
        dialogue_send(dialogue, MR_ID_KEY_WORD, payload, mr_key_word_put(&word, payload), fatal);
    }
}

/* Sets or removes the arming key of the board. `new` replaces the key by a new random key; `clear`
 * removes it. */
static int set_key(const struct request *request, struct dialogue *dialogue)
{
    const struct identity *who = &dialogue->identity;
    bool new = request->words[1] && strcmp(request->words[1], "new") == 0;
    char uid[IDENTITY_UID_SIZE], path[KEYFILE_PATH_SIZE];
    uint8_t key[MR_KEY_BYTES] = {0};
    struct error error = {0};
    struct dialogue_command order = {.code = new ? MR_COMMAND_KEY_SET : MR_COMMAND_KEY_CLEAR,
                                     .answer_timeout_s = KEY_TIMEOUT_S};
    if (!new && (!request->words[1] || strcmp(request->words[1], "clear") != 0))
        error_set(fatal, MR_USAGE, "unknown action of key%s%s%s; give key new or key clear",
                  request->words[1] ? ": '" : "", request->words[1] ? request->words[1] : "",
                  request->words[1] ? "'" : "");
    dialogue_wait_for_hello(dialogue, dialogue_is_flag_set, &who->key_known, fatal);
    if (who->key.state == MR_KEY_NO_MEMORY)
        error_set(fatal, MR_IO,
                  "this board has no memory for a key: %s; send commands without a key",
                  dialogue_spec(dialogue));
    identity_uid_text(who, uid);
    if (new) {
        keyfile_generate(uid, key, fatal);
        order.argument = (int32_t)mr_crc32(0, key, sizeof key);
        send_key(dialogue, key);
    }
    double until_s = dialogue_now_s(dialogue) + KEY_TIMEOUT_S;
    enum mr_status status; /* any status other than MR_OK: the black box is using the memory */
    do {
        error = (struct error){0};
        status = dialogue_receive(dialogue, DIALOGUE_RECEIVE_MAX_S, &error)
                   ?: dialogue_execute(dialogue, &order, "a landing is armed or in progress",
                                       &error);
    } while (status == MR_WAIT && dialogue_now_s(dialogue) < until_s);
    if (status != MR_OK) {
        keyfile_discard_new(uid);
        error_set(fatal, error.status, "%s%s", error.text,
                  new && !dialogue->is_answered ? "; the board may have the new key, but this "
                                                  "computer did not store it: repeat key new"
                                                : "");
    }
    if (new)
        keyfile_activate(uid, fatal);
    keyfile_path(uid, path);
    struct answer *answer = answer_new(request->cli->si);
    answer_add_text(answer, "board", "board", "%s", uid);
    answer_add_text(answer, "key", "key", "%s", new ? "set" : "cleared");
    if (new)
        answer_add_text(answer, "file", "key file", "%s", path);
    return answer_print(request->cli, answer, 0);
}

/* ---- the command line ---- */

static int run_health(const struct request *request, struct dialogue *dialogue)
{
    return health_print_report(dialogue, request->words[0], request->cli);
}

enum { ALLOWS_CAN = 1, ALLOWS_DB = 2, ALLOWS_IMAGE = 4, ALLOWS_OUT = 8 };

static const struct subcommand {
    const char *name;
    unsigned options;        /* options that this subcommand allows besides --serial */
    unsigned words_max;      /* largest number of arguments after the subcommand */
    const char *number_name; /* name of the numeric argument, for errors; NULL: there is none */
    double min, max;         /* limits of the numeric argument; min 1: the argument is required */
    int (*run)(const struct request *request, struct dialogue *dialogue);
} subcommands[] = {
    {.name = "", .options = ALLOWS_IMAGE, .run = report_identity},
    {.name = "list", .run = run_box},
    {"read", ALLOWS_DB, 1, "the record", 1.0, 65535.0, run_box},
    {"free", 0, 1, "the record", 1.0, 65535.0, run_box},
    {.name = "health", .run = run_health},
    {.name = "self-test", .run = run_health},
    {.name = "reset", .run = run_health},
    {"zero", 0, 1, "zero number", 0.0, 2.0, run_gages},
    {.name = "shunt", .run = run_gages},
    {"arm", ALLOWS_CAN, 1, "the landing", 0.0, ARM_CLIENT_LANDING_MAX, run_arm},
    {.name = "disarm", .options = ALLOWS_CAN, .run = run_arm},
    {.name = "runway", .options = ALLOWS_OUT, .words_max = 2, .run = run_runway},
    {.name = "key", .words_max = 1, .run = set_key},
};

static const struct subcommand *find_subcommand(const char *word)
{
    char near[SPELL_SUGGEST_TEXT_SIZE];
    for (size_t i = 0; i < sizeof subcommands / sizeof subcommands[0]; i++) {
        if (strcmp(subcommands[i].name, word ? word : "") == 0)
            return &subcommands[i];
    }
    help_suggest_word(&command_board, word, near);
    error_set(fatal, MR_UNKNOWN,
              "unknown word after matrig board: '%s'%s%s see matrig board --help", word, near,
              near[0] ? "" : ";");
    return NULL;
}

static void check_options(struct request *r, const struct subcommand *subcommand)
{
    const struct {
        bool given;
        unsigned option;
        const char *name, *allowed_use;
    } options[] = {
        {r->can != NULL, ALLOWS_CAN, "--can", "works only with arm, disarm and config"},
        {r->db || r->run, ALLOWS_DB, r->db ? "--db" : "--run", "only for read"},
        {r->image != NULL, ALLOWS_IMAGE, "--image",
         "works only with matrig board without an action"},
        {r->out || r->force, ALLOWS_OUT, r->out ? "-o" : "--force",
         "works only with the actions runway and config"},
    };
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (options[i].given && !(subcommand->options & options[i].option))
            error_set(fatal, MR_USAGE, "%s is %s: matrig board %s", options[i].name,
                      options[i].allowed_use, subcommand->name);
    }
    if (r->can && r->serial)
        error_set(fatal, MR_USAGE,
                  "two links given: matrig board %s uses only one; leave out --can or --serial",
                  subcommand->name);
    if (!r->can && !r->serial)
        error_set(fatal, MR_USAGE,
                  "no link: matrig board %s%sneeds %s--serial LINK; see matrig board --help",
                  subcommand->name, subcommand->name[0] ? " " : "",
                  subcommand->options & ALLOWS_CAN ? "--can LINK or " : "");
    if (strncmp(r->can ? r->can : r->serial, "file:", 5) == 0 && subcommand->run == run_arm)
        error_set(fatal, MR_USAGE, "the link is a file: %s; give the link of a board",
                  r->can ? r->can : r->serial);
    if (subcommand->options & ALLOWS_DB && !r->db)
        error_set(fatal, MR_USAGE, "no campaign: matrig board %s needs --db DB", subcommand->name);
    if (subcommand->run == run_runway)
        check_runway(r);
}

static void check_words(struct request *r, const struct subcommand *subcommand)
{
    double number = 0.0;
    const char *word = r->words[1];
    if (r->words[1 + subcommand->words_max])
        error_set(fatal, MR_USAGE, "%s takes no %s: '%s'; see matrig board --help",
                  subcommand->name, subcommand->words_max ? "more" : "number",
                  r->words[1 + subcommand->words_max]);
    if (subcommand->number_name && !word && subcommand->min > 0.0)
        error_set(
            fatal, MR_USAGE,
            "no record number given for matrig board %s; list the records with matrig board list",
            subcommand->name);
    if (!subcommand->number_name || !word)
        return;
    cli_parse_number(word, subcommand->number_name, subcommand->min, subcommand->max, &number,
                     fatal);
    r->number = (int32_t)number;
    if (number != floor(number))
        error_set(fatal, MR_USAGE, "%s must be a whole number, not '%s'; see matrig board --help",
                  subcommand->number_name, word);
}

static int board_command(int argc, char **argv, const struct cli *cli)
{
    static struct request request;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "config") == 0)
            return command_board_config.run(argc, argv, cli);
        if (strcmp(argv[i], "bringup") == 0)
            return command_board_bringup.run(argc, argv, cli);
    }
    request.cli = cli;
    command_parse(&command_board, argc, argv, cli, &request, request.words, fatal);
    const struct subcommand *subcommand = find_subcommand(request.words[0]);
    check_words(&request, subcommand);
    check_options(&request, subcommand);
    return subcommand->run(&request, dialogue_open_for_command(request.can, request.serial));
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); the board must be idle"),
    HELP_ITEM("(no command)",
              "show version, commit, CRC and integrity of the firmware; --image FILE (.elf or "
              ".bin) compares it with a file. Exit 1 when the image differs or is damaged"),
    HELP_WORD("list", "list the records of the black box and its free space"),
    HELP_WORD("read N",
              "read record N of the black box. With --db DB, the data that the campaign lacks is "
              "added to landing RUN; default: the landing with the same board, number and time of "
              "arming, created if missing. Exit 1 when a page cannot be read"),
    HELP_WORD("free N", "free the space of record N; only freed records are overwritten"),
    HELP_INCLUDE(command_board_config),
    HELP_WORD("runway",
              "show the predictor's runway: landings, joints, origin; -o writes the runway to a "
              "file. runway load F sends a file to the board; runway forget resets the runway to "
              "unknown. The board refuses load and forget while a landing is armed or in progress. "
              "Example:\n  matrig board --serial serial:/dev/ttyUSB0 runway -o before.txt"),
    HELP_WORD("arm [LANDING]",
              "arm the board for landing LANDING; default: the next number. --can works while "
              "matrig log uses the interface, --serial only when no other program uses the port. "
              "Exit 2: refused in the present state. Exit 3: not ready (try again), or no answer "
              "within 3 s. Example:\n  matrig board --can can:can0 arm 7"),
    HELP_WORD("disarm", "return the board to idle, even during a recording"),
    HELP_WORD("zero [1|2]",
              "measure the zeros of all channels (1: only the transducers; 2: only the gages), as "
              "means over 0.25 s. They are valid until a reset. If a reading moves or is not "
              "valid, or a gage is under tension, the zeros stay unchanged (exit 1)"),
    HELP_WORD("shunt", "shunt calibration of the gages (1 s). If matrig log is running on CAN, it "
                       "stores the result; calibrations before and after a landing show the drift. "
                       "Exit 1 when a result is outside its limits"),
    HELP_WORD("key new|clear",
              "set or clear the key for operator commands (arm, disarm, zero, shunt, survey, "
              "runway, chart). The maintenance jumper must be fitted. matrig stores the key for "
              "this user and uses it automatically"),
    HELP_INCLUDE(command_board_bringup),
    HELP_WORD("health",
              "show restarts and their causes, the state of memories, stack and CAN, faults, and "
              "the processor's state at a fault (to find the function, run arm-none-eabi-addr2line "
              "-pfe IMAGE.elf ADDRESS). Exit 1 when there is a fault"),
    HELP_WORD("self-test", "test memories, reference, excitation, black box and warning lamp. Exit "
                           "1 when a test fails"),
    HELP_WORD("reset", "restart the board"),
    HELP_EXAMPLE("matrig board --serial serial:/dev/ttyUSB0 read 3 --db campaign.db"),
    OPTION_TEXT("--can", "LINK", can, NULL),
    OPTION_TEXT("-o", "FILE", out, NULL),
    OPTION_FLAG("--force", force, NULL),
    OPTION_TEXT("--db", "DB", db, NULL),
    OPTION_RUN("--run", "RUN", run, NULL),
    OPTION_TEXT("--image", "FILE", image, NULL),
};

const struct command command_board = {
    "board",
    board_command,
    "--serial LINK [--image FILE]\n--serial LINK list | read N [--db DB [--run RUN]] | free "
    "N\n(--serial LINK | --can LINK) config get|set|check [-o F] [--force]\n--serial LINK runway "
    "[show|load F|forget] [-o F]\n(--serial LINK | --can LINK) arm [LANDING] | disarm\n--serial "
    "LINK "
    "zero [1|2] | shunt | health | self-test | reset | key new|clear\n--serial LINK bringup "
    "[report|brown-out|rom]",
    "bring-up, firmware, black box, configuration, runway and health of a board",
    COMMAND_PARTS(parts),
    {0, 3,
     "list|read N|free N|config|runway|arm|disarm|zero|shunt|bringup|health|self-test|reset|key"},
};
