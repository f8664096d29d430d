#include "host/board/board_health.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/answer.h"
#include "host/board/healthtalk.h"
#include "host/board/image_symbols.h"

static void cause_text(unsigned cause, char *out, size_t size)
{
    size_t n = 0;
    out[0] = '\0';
    for (unsigned bit = MR_RESET_POWER; bit <= MR_RESET_BROWN_OUT; bit <<= 1) {
        if (cause & bit && n < size)
            n += (size_t)snprintf(out + n, size - n, "%s%s", n ? ", " : "",
                                  mr_reset_cause_text(bit));
    }
}

static void faults_answer(const struct healthtalk *talk, struct answer *answer)
{
    answer_table(answer, "faults", "faults");
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        const struct mr_fault *fault = &talk->fault[i];
        const char *which = i == MR_FAULT_SELFTEST  ? mr_self_test_text(fault->detail)
                          : i == MR_FAULT_TASK_LATE ? mr_task_text(fault->detail)
                                                    : "";
        if (!fault->count)
            continue;
        answer_row(answer);
        answer_count(answer, "code", NULL, i);
        answer_words(answer, "text", "fault", "%s", mr_fault_text(i));
        answer_count(answer, "detail", "detail", fault->detail);
        answer_count(answer, "count", "times", fault->count);
        if (*which)
            answer_words(answer, NULL, "which", "%s", which);
    }
    answer_close(answer);
}

static void health_answer(const struct healthtalk *talk, const struct mr_symbols *symbols,
                          struct answer *answer)
{
    char text[160];
    cause_text(talk->hello.reset_cause, text, sizeof text);
    answer_words(answer, NULL, "last reset", "%s", text);
    answer_count(answer, "reset_cause", NULL, talk->hello.reset_cause);
    answer_count(answer, "restarts", "restarts", talk->restarts.restarts)->end =
        " that nobody asked for since power on";
    answer_count(answer, "in_row", "in a row", talk->restarts.in_row)->end =
        talk->restarts.in_row >= 5 ? ": it only speaks, give it `reset`" : NULL;
    answer_count(answer, "late_task", NULL, talk->restarts.late_task);
    if (talk->restarts.late_task) {
        crash_place(talk->restarts.late_pc, symbols, text, sizeof text);
        answer_words(answer, NULL, "watchdog",
                     "%s did not run in its time; the processor was at %s",
                     mr_task_text(talk->restarts.late_task), text);
    }
    answer_words(answer, "brown_out", "brown-out", "%s",
                 mr_brown_out_text(talk->restarts.brown_out));
    answer_count(answer, "stack_used", "stack used", talk->upkeep.stack_used)->end =
        " bytes at most";
    answer_count(answer, "stack_size", "stack", talk->upkeep.stack_size)->end = " bytes";
    answer_count(answer, "ram_tested", "RAM", talk->upkeep.ram_tested)->end =
        " times gone through, idle";
    answer_count(answer, "flash_checked", "program", talk->upkeep.flash_checked)->end =
        " times gone through, idle";
    answer_words(answer, "can", "CAN", "%s", mr_can_state_text(talk->alarm.state));
    answer_count(answer, "can_tec", "TEC", talk->alarm.tec);
    answer_count(answer, NULL, "REC", talk->alarm.rec);
    answer_count(answer, "can_outages", "CAN outages", talk->alarm.outages);
    answer_value(answer, NULL, "the last", UNIT_TIME, (double)talk->alarm.outage_s, 2);
    answer_open(answer, NULL, "CAN frames dropped");
    answer_count(answer, "dropped_queue_full", "queue full", talk->drops.queue_full);
    answer_count(answer, "dropped_bus_off", "bus-off", talk->drops.bus_off);
    answer_count(answer, "dropped_timeout", "nothing passed", talk->drops.timeout);
    answer_count(answer, "dropped_silent", "silent", talk->drops.silent);
    answer_close(answer);
    faults_answer(talk, answer);
    if (talk->crashed)
        crash_answer(&talk->crash, symbols, answer);
    else
        answer_none(answer, "crash", NULL, NULL);
}

static void test_answer(const struct mr_self_test *test, struct answer *answer)
{
    answer_count(answer, "done", NULL, test->done);
    answer_count(answer, "failed", NULL, test->failed);
    for (unsigned i = 0; i < MR_SELF_TEST_COUNT; i++) {
        if (test->done >> i & 1u)
            answer_words(answer, NULL, mr_self_test_text(i), "%s",
                         test->failed >> i & 1u ? "FAILED" : "good");
    }
}

/* Exit 1: the board found a fault in itself. */
static int tell(const char *verb, const struct healthtalk *talk, const struct mr_symbols *symbols,
                const struct cli *cli)
{
    struct answer *answer = answer_new(cli->si);
    bool fault = false;
    if (strcmp(verb, "health") == 0) {
        health_answer(talk, symbols, answer);
        fault = talk->health.faults != 0;
    } else if (strcmp(verb, "self-test") == 0) {
        test_answer(&talk->test, answer);
        fault = talk->test.failed != 0;
    } else
        answer_flag(answer, "restarted", NULL, true);
    return answer_show(cli, answer, fault ? mr_status_exit_code(MR_LIMIT) : 0);
}

bool board_health_verb(const char *word)
{
    return strcmp(word, "health") == 0 || strcmp(word, "self-test") == 0 ||
           strcmp(word, "reset") == 0;
}

int board_health(const char *serial, const char *verb, const char *elf, const struct cli *cli)
{
    struct error error = {0};
    struct dialogue dialogue = {0};
    struct mr_symbols symbols;
    struct healthtalk *talk = calloc(1, sizeof *talk);
    if (!talk)
        abort();
    enum mr_status status = image_symbols_read(&symbols, elf, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, NULL, serial, &error);
    if (status == MR_OK)
        status = healthtalk_begin(talk, &dialogue, &error);
    if (status == MR_OK)
        status = strcmp(verb, "health") == 0    ? healthtalk_hear(talk, &error)
               : strcmp(verb, "self-test") == 0 ? healthtalk_self_test(talk, &error)
                                                : healthtalk_reset(talk, &error);
    int exit_code = status == MR_OK ? tell(verb, talk, &symbols, cli) : cli_fail(&error);
    dialogue_close(&dialogue);
    image_symbols_free(&symbols);
    free(talk);
    return exit_code;
}
