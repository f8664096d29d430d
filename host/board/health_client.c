#include "host/board/health_client.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "host/base/answer.h"

/* ---- crash ---- */

#define ALL_CRASH_WORDS ((1ull << MR_CRASH_ITEM_COUNT) - 1u)

bool crash_receive(struct crash_report *report, const struct mr_crash *message)
{
    if (message->item >= MR_CRASH_ITEM_COUNT || message->items != MR_CRASH_ITEM_COUNT)
        return false;
    if (message->item == 0 ||
        message->age != report->restart_count) /* this word is the first of a new report */
        *report = (struct crash_report){.restart_count = message->age};
    bool whole = report->present_bits == ALL_CRASH_WORDS;
    report->word[message->item] = message->value;
    report->present_bits |= 1ull << message->item;
    return !whole && report->present_bits == ALL_CRASH_WORDS;
}

void crash_format_summary(const struct crash_report *report, char *out, size_t size)
{
    const uint32_t *word = report->word;
    char running[64] = "";
    if (word[MR_CRASH_TASK])
        snprintf(running, sizeof running, ", in %s", mr_task_text(word[MR_CRASH_TASK]));
    snprintf(out, size, "the board restarted after a%s %s at 0x%08x%s in block %u",
             report->restart_count ? "n earlier" : "", mr_crash_kind_text(word[MR_CRASH_KIND]),
             (unsigned)word[MR_CRASH_PC], running, (unsigned)word[MR_CRASH_BLOCK]);
}

/* Adds the report of a crash: headline, registers and stack. */
static void add_crash(const struct crash_report *report, struct answer *answer)
{
    char text[300], label[20];
    answer_open_group(answer, "crash", "");
    crash_format_summary(report, text, sizeof text);
    answer_add_sentence(answer, "text", "%s", text);
    answer_add_count(answer, "age", NULL, report->restart_count);
    answer_add_text(answer, "kind", NULL, "%s", mr_crash_kind_text(report->word[MR_CRASH_KIND]));
    answer_add_text(answer, NULL, "called from", "0x%08x", (unsigned)report->word[MR_CRASH_LR]);
    answer_add_text(answer, NULL, "image", "%08x", (unsigned)report->word[MR_CRASH_IMAGE]);
    answer_open_group(answer, "words", "registers");
    for (unsigned i = 0; i < MR_CRASH_STACK_FIRST; i++) {
        answer_add_count(answer, mr_crash_item_name(i), NULL, report->word[i]);
        if (i >= MR_CRASH_R0)
            answer_add_text(answer, NULL, mr_crash_item_name(i), "%08x", (unsigned)report->word[i]);
    }
    answer_close_group(answer);
    answer_open_list(answer, "stack", NULL);
    for (unsigned i = 0; i < MR_CRASH_STACK_WORDS; i++)
        answer_add_count(answer, NULL, NULL, report->word[MR_CRASH_STACK_FIRST + i]);
    answer_close_group(answer);
    answer_open_group(answer, NULL, "stack, starting at sp");
    for (unsigned i = 0; i < MR_CRASH_STACK_WORDS; i++) {
        snprintf(label, sizeof label, "sp + %u", 4 * i);
        answer_add_text(answer, NULL, label, "0x%08x",
                        (unsigned)report->word[MR_CRASH_STACK_FIRST + i]);
    }
    answer_close_group(answer);
    answer_close_group(answer);
}

/* ---- commands ---- */

#define ANSWER_TIMEOUT_S DIALOGUE_ANSWER_TIMEOUT_S

#define HANDLE_MESSAGE(name, into, flag)                  \
    if (mr_##name##_get(&(into), bytes, length) == MR_OK) \
        flag = true;                                      \
    break

/* Discards received values. Used after a restart and before a new request. */
static void discard_state(struct health_client *client)
{
    client->restarts_known = client->upkeep_known = client->alarm_known = client->drops_known =
        client->health_known = false;
    client->crash_reported = false;
    client->crash = (struct crash_report){0};
    memset(client->fault, 0, sizeof client->fault);
}

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct health_client *client = context;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_fault fault;
    struct mr_crash crash;
    struct mr_self_test test;
    (void)error;
    switch (message->id) {
    case MR_ID_HELLO:
        if (mr_hello_get(&client->hello, bytes, length) != MR_OK)
            break;
        client->hello_count++;
        if (message->seq == 0)
            discard_state(client);
        break;
    case MR_ID_FAULT:
        if (mr_fault_get(&fault, bytes, length) == MR_OK && fault.code < MR_FAULT_COUNT)
            client->fault[fault.code] = fault;
        break;
    case MR_ID_SELF_TEST:
        if (mr_self_test_get(&test, bytes, length) == MR_OK &&
            test.tag == dialogue_tag(client->dialogue)) {
            client->self_test = test;
            client->self_test_done = true;
        }
        break;
    case MR_ID_CRASH:
        if (mr_crash_get(&crash, bytes, length) == MR_OK)
            client->crash_reported |= crash_receive(&client->crash, &crash);
        break;
    case MR_ID_RESTARTS: HANDLE_MESSAGE(restarts, client->restarts, client->restarts_known);
    case MR_ID_UPKEEP: HANDLE_MESSAGE(upkeep, client->upkeep, client->upkeep_known);
    case MR_ID_CAN_ALARM: HANDLE_MESSAGE(can_alarm, client->alarm, client->alarm_known);
    case MR_ID_CAN_DROPS: HANDLE_MESSAGE(can_drops, client->drops, client->drops_known);
    case MR_ID_HEALTH: HANDLE_MESSAGE(health, client->health, client->health_known);
    default: break;
    }
    return MR_OK;
}

static bool has_received_hellos(const void *context)
{
    const struct health_client *client = context;
    return client->hello_count >= client->required_hello_count;
}

static void wait_for_hello(struct health_client *client, unsigned hellos)
{
    client->required_hello_count = hellos;
    if (dialogue_wait_until(client->dialogue, has_received_hellos, client, ANSWER_TIMEOUT_S,
                            fatal) == MR_TIMEOUT)
        dialogue_set_no_hello_error(client->dialogue, fatal);
}

static void send_command(struct health_client *client, uint8_t code)
{
    dialogue_execute(client->dialogue,
                     &(struct dialogue_command){.code = code, .answer_timeout_s = ANSWER_TIMEOUT_S},
                     "a landing is armed or in progress", fatal);
}

static bool has_all_messages(const void *context)
{
    const struct health_client *client = context;
    return client->restarts_known && client->upkeep_known && client->alarm_known &&
           client->drops_known && client->health_known;
}

/* Receives everything that the board reports each second, and the report of a processor fault. */
static void health_client_receive(struct health_client *client)
{
    discard_state(client);
    send_command(client, MR_COMMAND_STATE);
    /* Between two hellos the board reports everything once. */
    wait_for_hello(client, client->hello_count + 2);
    if (dialogue_wait_until(client->dialogue, has_all_messages, client, ANSWER_TIMEOUT_S, fatal) ==
        MR_TIMEOUT)
        error_set(
            fatal, MR_TIMEOUT,
            "the board did not report its health: %s; use firmware and matrig of the same version",
            dialogue_spec(client->dialogue));
}

static void health_client_self_test(struct health_client *client)
{
    send_command(client, MR_COMMAND_SELF_TEST);
    if (dialogue_wait_until(client->dialogue, dialogue_is_flag_set, &client->self_test_done,
                            ANSWER_TIMEOUT_S, fatal) == MR_TIMEOUT)
        error_set(fatal, MR_TIMEOUT, "the self-test timed out: %s; reset the board",
                  dialogue_spec(client->dialogue));
}

static void health_client_reset(struct health_client *client)
{
    send_command(client, MR_COMMAND_RESET);
    unsigned hellos = client->hello_count;
    double until_s = dialogue_now_s(client->dialogue) + ANSWER_TIMEOUT_S;
    /* ignore a hello sent before the reset: it has the cause of an earlier reset */
    while (dialogue_now_s(client->dialogue) < until_s) {
        wait_for_hello(client, ++hellos);
        if ((client->hello.reset_cause & 5u) == 4u)
            return;
    }
    error_set(fatal, MR_TIMEOUT, "the board did not restart: %s; power-cycle the board",
              dialogue_spec(client->dialogue));
}

/* ---- matrig board health ---- */

void health_reset_text(int64_t cause, char *out, size_t size)
{
    size_t n = 0;
    out[0] = '\0';
    for (unsigned bit = MR_RESET_POWER; bit <= MR_RESET_BROWN_OUT; bit <<= 1) {
        if (cause & bit && n < size)
            n += (size_t)snprintf(out + n, size - n, "%s%s", n ? ", " : "",
                                  mr_reset_cause_text(bit));
    }
}

static void add_faults(const struct health_client *client, struct answer *answer)
{
    answer_open_table(answer, "faults", "faults");
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        const struct mr_fault *fault = &client->fault[i];
        const char *which = i == MR_FAULT_SELFTEST  ? mr_self_test_text(fault->detail)
                          : i == MR_FAULT_TASK_LATE ? mr_task_text(fault->detail)
                                                    : "";
        if (!fault->count)
            continue;
        answer_open_row(answer);
        answer_add_count(answer, "code", NULL, i);
        answer_add_text(answer, "text", "fault", "%s", mr_fault_text(i));
        answer_add_count(answer, "detail", "detail", fault->detail);
        answer_add_count(answer, "count", "times", fault->count);
        if (*which)
            answer_add_text(answer, NULL, "which", "%s", which);
    }
    answer_close_group(answer);
}

static void add_health(const struct health_client *client, struct answer *answer)
{
    char text[160];
    health_reset_text(client->hello.reset_cause, text, sizeof text);
    answer_add_text(answer, NULL, "last reset", "%s", text);
    answer_add_count(answer, "reset_cause", NULL, client->hello.reset_cause);
    answer_add_count(answer, "restarts", "restarts", client->restarts.restarts)->suffix =
        " since power-on, without requested restarts";
    answer_add_count(answer, "in_row", "in a row", client->restarts.in_row)->suffix =
        client->restarts.in_row >= 5
            ? ": the board does not measure until it receives the command `reset`"
            : NULL;
    answer_add_count(answer, "late_task", NULL, client->restarts.late_task);
    if (client->restarts.late_task) {
        answer_add_text(
            answer, NULL, "watchdog", "%s missed its deadline; the processor was at 0x%08x",
            mr_task_text(client->restarts.late_task), (unsigned)client->restarts.late_pc);
    }
    answer_add_text(answer, "brown_out", "brown-out", "%s",
                    mr_brown_out_text(client->restarts.brown_out));
    answer_add_count(answer, "stack_used", "stack used", client->upkeep.stack_used)->suffix =
        " bytes at most";
    answer_add_count(answer, "stack_size", "stack", client->upkeep.stack_size)->suffix = " bytes";
    answer_add_count(answer, "ram_tested", "RAM", client->upkeep.ram_tested)->suffix =
        " complete checks while idle";
    answer_add_count(answer, "flash_checked", "program", client->upkeep.flash_checked)->suffix =
        " complete checks while idle";
    answer_add_text(answer, "can", "CAN", "%s", mr_can_state_text(client->alarm.state));
    answer_add_count(answer, "can_tec", "TEC", client->alarm.tec);
    answer_add_count(answer, NULL, "REC", client->alarm.rec);
    answer_add_count(answer, "can_outages", "CAN outages", client->alarm.outages);
    answer_add_value(answer, NULL, "last outage", UNIT_TIME, (double)client->alarm.outage_s, 2);
    answer_open_group(answer, NULL, "CAN frames dropped");
    answer_add_count(answer, "dropped_queue_full", "queue full", client->drops.queue_full);
    answer_add_count(answer, "dropped_bus_off", "bus-off", client->drops.bus_off);
    answer_add_count(answer, "dropped_timeout", "transmission timed out", client->drops.timeout);
    answer_add_count(answer, "dropped_silent", "silent", client->drops.silent);
    answer_close_group(answer);
    add_faults(client, answer);
    if (client->crash_reported)
        add_crash(&client->crash, answer);
    else
        answer_add_missing_value(answer, "crash", NULL, NULL);
}

static void add_test(const struct mr_self_test *test, struct answer *answer)
{
    answer_add_count(answer, "done", NULL, test->done);
    answer_add_count(answer, "failed", NULL, test->failed);
    for (unsigned i = 0; i < MR_SELF_TEST_COUNT; i++) {
        if (test->done >> i & 1u)
            answer_add_text(answer, NULL, mr_self_test_text(i), "%s",
                            test->failed >> i & 1u ? "FAILED" : "good");
    }
}

/* Prints the checks. Returns exit code 1 if the board reports a fault. */
static int print_checks(const char *verb, const struct health_client *client, const struct cli *cli)
{
    struct answer *answer = answer_new(cli->si);
    bool fault = false;
    if (strcmp(verb, "health") == 0) {
        add_health(client, answer);
        fault = client->health.faults != 0;
    } else if (strcmp(verb, "self-test") == 0) {
        add_test(&client->self_test, answer);
        fault = client->self_test.failed != 0;
    } else
        answer_add_flag(answer, "restarted", NULL, true);
    return answer_print(cli, answer, fault ? mr_status_exit_code(MR_LIMIT) : 0);
}

int health_print_report(struct dialogue *dialogue, const char *verb, const struct cli *cli)
{
    static struct health_client client;
    client.dialogue = dialogue;
    dialogue_subscribe(dialogue, handle_message, &client);
    dialogue_wait_for_hello(dialogue, NULL, NULL, fatal);
    if (strcmp(verb, "health") == 0)
        health_client_receive(&client);
    else if (strcmp(verb, "self-test") == 0)
        health_client_self_test(&client);
    else
        health_client_reset(&client);
    return print_checks(verb, &client, cli);
}
