#include "host/board/board_health.h"

#include <stdlib.h>
#include <string.h>

#include "host/board/healthtalk.h"
#include "host/board/image_symbols.h"

static const char *const brown_out[] = {"off", "2.2 V", "2.5 V", "2.8 V"};

static const char *brown_out_text(unsigned level)
{
    return level < sizeof brown_out / sizeof brown_out[0] ? brown_out[level] : "unknown";
}

static void cause_text(unsigned cause, char *out, size_t size)
{
    static const char *const names[] = {"power", "pin", "software", "watchdog", "low power", "brown-out"};
    size_t n = 0;
    out[0] = '\0';
    for (unsigned i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (cause >> i & 1u && n < size)
            n += (size_t)snprintf(out + n, size - n, "%s%s", n ? ", " : "", names[i]);
    }
}

static void print_health(const struct healthtalk *talk, const struct mr_symbols *symbols)
{
    char text[160];
    cause_text(talk->hello.reset_cause, text, sizeof text);
    printf("last reset     %s; %u restarts that nobody asked for since power on, %u in a row%s\n", text, talk->restarts.restarts,
           talk->restarts.in_row, talk->restarts.in_row >= 5 ? ": it only speaks, give it `reset`" : "");
    if (talk->restarts.late_task) {
        crash_place(talk->restarts.late_pc, symbols, text, sizeof text);
        printf("watchdog       %s did not run in its time; the processor was at %s\n", mr_task_text(talk->restarts.late_task), text);
    }
    printf("brown-out      %s\n", brown_out_text(talk->restarts.brown_out));
    printf("stack          %u of %u bytes used at most\n", talk->upkeep.stack_used, talk->upkeep.stack_size);
    printf("memories       RAM gone through %u times, program %u times, idle\n", talk->upkeep.ram_tested, talk->upkeep.flash_checked);
    printf("CAN            %s; TEC %u, REC %u, %u %s (last %.2f s)\n", mr_can_state_text(talk->alarm.state), talk->alarm.tec,
           talk->alarm.rec, talk->alarm.outages, talk->alarm.outages == 1 ? "outage" : "outages", (double)talk->alarm.outage_s);
    printf("CAN dropped    %u queue full, %u bus-off, %u nothing passed, %u silent\n", talk->drops.queue_full, talk->drops.bus_off,
           talk->drops.timeout, talk->drops.silent);
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        const struct mr_fault *fault = &talk->fault[i];
        const char *which = i == MR_FAULT_SELFTEST    ? mr_self_test_text(fault->detail)
                            : i == MR_FAULT_TASK_LATE ? mr_task_text(fault->detail)
                                                      : "";
        if (fault->count)
            printf("fault          %s [%u], %u times%s%s\n", mr_fault_text(i), fault->detail, fault->count, *which ? ": " : "", which);
    }
    if (talk->crashed)
        crash_print(&talk->crash, symbols, stdout);
}

static json_t *health_json(const struct healthtalk *talk, const struct mr_symbols *symbols)
{
    json_t *faults = json_array();
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (talk->fault[i].count)
            json_array_append_new(faults, json_pack("{sisisiss}", "code", (int)i, "detail", talk->fault[i].detail, "count",
                                                    talk->fault[i].count, "text", mr_fault_text(i)));
    }
    return json_pack(
        "{sisisisssisisisisisssisisisisisisoso?}", "reset_cause", talk->hello.reset_cause, "restarts", talk->restarts.restarts,
        "in_row", talk->restarts.in_row, "brown_out", brown_out_text(talk->restarts.brown_out), "late_task",
        talk->restarts.late_task, "stack_used", talk->upkeep.stack_used, "stack_size", talk->upkeep.stack_size, "ram_tested",
        talk->upkeep.ram_tested, "flash_checked", talk->upkeep.flash_checked, "can", mr_can_state_text(talk->alarm.state), "can_tec",
        talk->alarm.tec, "can_outages", talk->alarm.outages, "dropped_queue_full", talk->drops.queue_full, "dropped_bus_off",
        talk->drops.bus_off, "dropped_timeout", talk->drops.timeout, "dropped_silent", talk->drops.silent, "faults", faults, "crash",
        talk->crashed ? crash_json(&talk->crash, symbols) : NULL);
}

static int tell_health(const struct healthtalk *talk, const struct mr_symbols *symbols, const struct cli *cli)
{
    int exit_code = talk->health.faults ? 1 : 0;
    if (cli->json)
        return cli_print_json(health_json(talk, symbols), exit_code);
    print_health(talk, symbols);
    return exit_code;
}

static int tell_test(const struct mr_self_test *test, const struct cli *cli)
{
    int exit_code = test->failed ? 1 : 0;
    if (cli->json)
        return cli_print_json(json_pack("{sisi}", "done", test->done, "failed", test->failed), exit_code);
    for (unsigned i = 0; i < MR_SELF_TEST_COUNT; i++) {
        if (test->done >> i & 1u)
            printf("%-6s %s\n", test->failed >> i & 1u ? "FAILED" : "good", mr_self_test_text(i));
    }
    return exit_code;
}

bool board_health_verb(const char *word)
{
    return strcmp(word, "health") == 0 || strcmp(word, "self-test") == 0 || strcmp(word, "reset") == 0;
}

int board_health(const char *serial, const char *verb, const char *elf, const struct cli *cli)
{
    struct error error = {0};
    struct dialogue dialogue = {0};
    struct mr_symbols symbols;
    struct healthtalk *talk = calloc(1, sizeof *talk);
    int exit_code;
    if (!talk)
        abort();
    enum mr_status status = image_symbols_read(&symbols, elf, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, NULL, serial, &error);
    if (status == MR_OK)
        status = healthtalk_begin(talk, &dialogue, &error);
    if (status == MR_OK)
        status = strcmp(verb, "health") == 0      ? healthtalk_hear(talk, &error)
                 : strcmp(verb, "self-test") == 0 ? healthtalk_self_test(talk, &error)
                                                  : healthtalk_reset(talk, &error);
    if (status != MR_OK)
        exit_code = cli_fail(&error);
    else if (strcmp(verb, "health") == 0)
        exit_code = tell_health(talk, &symbols, cli);
    else if (strcmp(verb, "self-test") == 0)
        exit_code = tell_test(&talk->test, cli);
    else
        exit_code = cli->json ? cli_print_json(json_pack("{sb}", "restarted", 1), 0) : 0;
    dialogue_close(&dialogue);
    image_symbols_free(&symbols);
    free(talk);
    return exit_code;
}
