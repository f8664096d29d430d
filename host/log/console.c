/* Output of matrig log for its user: link faults, landings, progress, and a summary of the session
 * at the end. This file also starts the process that writes the page of --page, and processes typed
 * commands. */
#include "host/log/logger.h"

#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/advise/arming.h"
#include "host/analyse/brief.h"
#include "host/base/monotonic_clock.h"
#include "host/base/process.h"
#include "host/board/arm_client.h"
#include "host/store/store_journal.h"

#define PROGRESS_PERIOD_US       200000u
#define QUEUE_SHOWN_MIN_PERMILLE 10u
/* three times the 1 s between two hellos of a board */
#define NO_BOARD_TIMEOUT_US      3000000u
#define NOTE_PERIOD_US           1000000u /* the same fault is reported at most once per second */

static bool logger_has_received_hello(const struct logger *logger)
{
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    return p.hello_received;
}

void logger_clear_progress(const struct logger *logger)
{
    if (!logger->cli->quiet && cli_is_stderr_terminal())
        fputs("\r\033[K", stderr);
}

void logger_note_link_faults(struct logger *logger, unsigned link)
{
    const struct link_counters *counters = &logger->counters[link];
    uint64_t now_us = monotonic_us();
    for (unsigned i = 0; i < LINK_FAULT_COUNT; i++) {
        uint64_t more = counters->fault_count[i] - logger->reported_fault_count[link][i];
        bool lately = logger->last_fault_report_us[link][i] != 0 &&
                      now_us - logger->last_fault_report_us[link][i] < NOTE_PERIOD_US;
        /* the count may have decreased: after a rollback the data is processed again, and the count
         * increases again */
        if (counters->fault_count[i] <= logger->reported_fault_count[link][i] || lately)
            continue;
        logger_clear_progress(logger);
        logger->reported_fault_count[link][i] = counters->fault_count[i];
        logger->last_fault_report_us[link][i] = now_us;
        cli_note(logger->cli, "%s: %s: %llu", link_get_spec(logger->link[link]), link_fault_text(i),
                 (unsigned long long)more);
    }
}

static enum mr_status set_different_boards_error(const struct logger *logger, struct error *error)
{
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    if (!p.is_other_board_on_can)
        return MR_OK;
    return error_set(error, MR_IO,
                     "CAN and serial line have different boards: CAN base 0x%03x has %s, the "
                     "serial line has %s; swap the serial lines or the bases: %s, %s",
                     logger->can_base, p.can_uid, p.serial_uid,
                     link_get_spec(logger->link[LINK_CAN]),
                     link_get_spec(logger->link[LINK_SERIAL]));
}

void logger_note_different_boards(struct logger *logger)
{
    struct error error = {0};
    if (logger->different_boards_reported || set_different_boards_error(logger, &error) == MR_OK)
        return;
    logger->different_boards_reported = true;
    logger_clear_progress(logger);
    cli_note(logger->cli, "%s", error.text);
}

/* Notes another board on the bus: first a hello of this version at another base, then the identity
 * at that base. */
void logger_note_other_board(struct logger *logger, const struct link_frame *frame)
{
    struct mr_message message;
    if (logger->other_board_reported ||
        (frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR)) != 0 ||
        mr_message_find((uint16_t)link_id_from_bus(frame->id, logger->can_base)))
        return;
    if (logger->other_board_seen && frame->length == 8 &&
        frame->id == (uint32_t)MR_ID_BOARD_UID + logger->other_board_base) {
        logger->other_board_reported = true;
        logger_clear_progress(logger);
        cli_note(logger->cli,
                 "another board sends on this bus and is not logged: base 0x%03x of %s",
                 logger->other_board_base, link_get_spec(logger->link[LINK_CAN]));
    } else if (frame->id >= MR_ID_HELLO && frame->id - MR_ID_HELLO <= MR_CAN_BASE_MAX &&
               mr_message_decode(&message, MR_ID_HELLO, frame->data, frame->length) == MR_OK &&
               message.as.hello.layout == MR_LAYOUT) {
        logger->other_board_seen = true;
        logger->other_board_base = (uint16_t)(frame->id - MR_ID_HELLO);
    }
}

/* Warns of a landing that is already in the campaign, probably because a recording was logged
 * twice. */
static void note_repeated_landing(struct logger *logger, int64_t run)
{
    struct error why = {0};
    int64_t twin = 0;
    if (store_find_duplicate(logger->store, run, &twin, &why) != MR_OK || twin == 0)
        return;
    logger_clear_progress(logger);
    cli_note(logger->cli,
             "RUN %lld is the same landing as RUN %lld: board, number and switches are equal; to "
             "void the duplicate: matrig landing %s %lld --void --reason TEXT",
             (long long)run, (long long)twin, store_path(logger->store), (long long)run);
}

/* ---- summary of a landing, within 10 s after the stop and without a command ----
 *
 * The summary is printed when a landing ends, or when its links fall silent during it. The page of
 * --page is updated in a separate process, which reads the campaign from disk. */

#define LANDING_SILENCE_MIN_US 4000000u
#define PAGE_TIMEOUT_S         60.0

/* Returns true, once per landing, if no data has arrived for LANDING_SILENCE_MIN_US while the gear
 * moves. */
static bool is_landing_silent(struct logger *logger, const struct collector_progress *progress)
{
    uint64_t now_us = monotonic_us();
    if (progress->newest_block != logger->silence_check_block || logger->silent_since_us == 0) {
        logger->silence_check_block = progress->newest_block;
        logger->silent_since_us = now_us;
    }
    if (!progress->run || progress->edge_count == 0 || progress->run == logger->silent_run ||
        now_us - logger->silent_since_us < LANDING_SILENCE_MIN_US)
        return false;
    logger->silent_run = progress->run;
    return true;
}

static void write_page(struct logger *logger)
{
    const char *const words[] = {
        "/proc/self/exe",  "--quiet", "--si", "report", logger->db_path, "-o",
        logger->page_path, NULL};
    const char *const plain[] = {"/proc/self/exe",  "--quiet", "report", logger->db_path, "-o",
                                 logger->page_path, NULL};
    struct error error = {0};
    if (!logger->page_path)
        return;
    logger->page_outdated = logger->page_process != 0;
    if (logger->page_outdated)
        return;
    const int streams[3] = {-1, open("/dev/null", O_WRONLY | O_CLOEXEC), -1};
    if (process_start(logger->cli->si ? words : plain, streams, &logger->page_process, &error) !=
        MR_OK)
        /* if the page cannot be written, the log still succeeds; its summary is printed anyway */
        logger->page_process = 0;
    close(streams[1]);
}

void logger_update_page(struct logger *logger, bool end)
{
    int status;
    while (logger->page_process) {
        if (end)
            process_wait(logger->page_process, PAGE_TIMEOUT_S, &status);
        else if (waitpid(logger->page_process, &status, WNOHANG) == 0)
            return;
        logger->page_process = 0;
        if (logger->page_outdated)
            write_page(logger);
    }
}

void logger_set_nonblocking(struct logger *logger, bool on)
{
    for (int i = 0; i < 2; i++) {
        int fd = STDOUT_FILENO + i, other = -1;
        struct stat info;
        char path[40];
        snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
        if (!on && logger->original_output[i] > 0) {
            dup2(logger->original_output[i], fd);
            close(logger->original_output[i]);
            logger->original_output[i] = 0;
        } else if (on && fstat(fd, &info) == 0 &&
                   (S_ISFIFO(info.st_mode) || (S_ISCHR(info.st_mode) && isatty(fd)))) {
            /* Opens the output again for O_NONBLOCK: the inherited descriptor is shared with the
             * parent process, which the flag would affect too. */
            other = open(path, O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
        }
        if (other < 0)
            continue;
        logger->original_output[i] = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        if (logger->original_output[i] > 0)
            dup2(other, fd);
        close(other);
    }
}

void logger_print_pending(struct logger *logger)
{
    size_t written_bytes = 0;
    if (logger->pending_output_length == 0)
        return;
    if (logger->original_output[0] > 0) {
        ssize_t count = write(STDOUT_FILENO, logger->pending_output, logger->pending_output_length);
        written_bytes = count > 0 ? (size_t)count : 0;
    } else {
        written_bytes = logger->pending_output_length;
        fwrite(logger->pending_output, 1, written_bytes, stdout);
        fflush(stdout);
    }
    logger->pending_output_length -= written_bytes;
    memmove(logger->pending_output, logger->pending_output + written_bytes,
            logger->pending_output_length);
}

static void report_summary(struct logger *logger, const struct summary *summary)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    if (out) {
        brief_print(store_path(logger->store), summary, logger->prints_full_summaries,
                    logger->cli->si, out);
        fclose(out);
    }
    char *all = realloc(logger->pending_output, logger->pending_output_length + length + 1);
    if (all && text) {
        memcpy(all + logger->pending_output_length, text, length);
        logger->pending_output_length += length;
    }
    logger->pending_output = all ? all : logger->pending_output;
    free(text);
    logger_print_pending(logger);
}

static enum mr_status load_summary(struct logger *logger, int64_t run, struct summary *summary,
                                   struct error *error)
{
    return summary_load(logger->store, run, summary, error)
             ?: summary_load_outcome(logger->store, summary, error);
}

static void show_outcome_live(struct logger *logger, const struct summary *summary)
{
    char line[OUTCOME_LINE_SIZE], words[OUTCOME_LINE_SIZE + 40];
    snprintf(words, sizeof words, "RUN %lld: %s", (long long)summary->measured.landing.id,
             outcome_record_format_line(&summary->outcome, line));
    live_hub_add_outcome(logger->live.hub, words);
}

enum mr_status logger_show_finished_landings(struct logger *logger, struct error *error)
{
    int64_t run;
    while ((run = collector_pop_finished_run(logger->collector)) != 0) {
        struct summary summary;
        struct error why = {0};
        enum mr_status status = logger_commit(logger, error);
        if (status != MR_OK)
            return status;
        if (load_summary(logger, run, &summary, &why) != MR_OK) {
            /* A failed summary does not end the log: a summary can be printed later, but data that
             * is not received now is lost. */
            cli_note(logger->cli, "no summary of RUN %lld: %s", (long long)run, why.text);
            summary_free(&summary);
            continue;
        }
        if (logger->cli->json) {
            json_array_append_new(logger->landings_json,
                                  summary_to_json(&summary, logger->cli->si));
        } else {
            report_summary(logger, &summary);
        }
        if (logger->live.hub)
            show_outcome_live(logger, &summary);
        snprintf(logger->newest_landing, sizeof logger->newest_landing, "landing %lld (RUN %lld)",
                 (long long)summary.measured.landing.board_landing, (long long)run);
        summary_free(&summary);
        note_repeated_landing(logger, run);
        logger->shown_landing_count++;
        write_page(logger);
    }
    return MR_OK;
}

/* Prints a summary of the data received so far if the links fall silent during a landing. */
enum mr_status logger_show_silent_landing(struct logger *logger, struct error *error)
{
    struct collector_progress progress;
    struct summary summary;
    logger_update_page(logger, false);
    collector_get_progress(logger->collector, &progress);
    if (!is_landing_silent(logger, &progress))
        return MR_OK;
    cli_note(logger->cli,
             "the board sends no more data of RUN %lld: check the board and its cables; the data "
             "received so far is stored",
             (long long)progress.run);
    struct error why = {0};
    enum mr_status status = logger_commit(logger, error);
    if (status != MR_OK)
        return status;
    if (load_summary(logger, progress.run, &summary, &why) != MR_OK) {
        cli_note(logger->cli, "no summary of RUN %lld: %s", (long long)progress.run, why.text);
    } else if (!logger->cli->json) {
        report_summary(logger, &summary);
    }
    summary_free(&summary);
    write_page(logger);
    return MR_OK;
}

/* Reports crashes and CAN alarms of the board without a request from the user. */
void logger_note_health(struct logger *logger)
{
    char text[300];
    const struct crash_report *crash = collector_pop_crash(logger->collector);
    const struct mr_can_alarm *alarm = collector_pop_alarm(logger->collector);
    if (crash || alarm)
        logger_clear_progress(logger);
    if (crash) {
        crash_format_summary(crash, text, sizeof text);
        cli_note(logger->cli, "%s", text);
    }
    if (alarm && alarm->state > MR_CAN_GOOD)
        cli_note(logger->cli, "the board reports the CAN state: %s (TEC %u)",
                 mr_can_state_text(alarm->state), alarm->tec);
    else if (alarm && alarm->outages)
        cli_note(
            logger->cli, "the board reports that CAN works again after %.2f s; %u %s since reset",
            (double)alarm->outage_s, alarm->outages, alarm->outages == 1 ? "outage" : "outages");
}

void logger_note_answers(struct logger *logger)
{
    struct collector_answer order;
    while (collector_pop_answer(logger->collector, &order)) {
        struct typed_commands *typed = &logger->typed;
        enum mr_status status = (enum mr_status)order.ack.status;
        bool is_typed = order.is_own && typed->is_sent && order.ack.tag == typed->command.tag &&
                        order.ack.code == typed->command.code;
        char more[60] = "", words[300];
        if (is_typed && status == MR_PROOF && monotonic_us() < typed->deadline_us &&
            logger_repeat_command(logger))
            continue;
        if (is_typed) { /* typed_commands_update reports the outcome of a typed command */
            typed->is_answered = true;
            typed->answer = status;
            continue;
        }
        if (order.repeat_count)
            snprintf(more, sizeof more, " (and %u earlier times)", order.repeat_count);
        snprintf(words, sizeof words, "%s \"%s\"; the board %s%s%s",
                 order.is_own ? "the live page sent" : "another program sent",
                 mr_command_name(order.ack.code), status == MR_OK ? "executed it" : "refused it: ",
                 status == MR_OK ? "" : mr_status_text(status), more);
        logger_clear_progress(logger);
        cli_note(logger->cli, "%s", words);
        if (logger->live.hub && !order.is_own)
            live_hub_add_notice(logger->live.hub, words);
    }
}

void logger_show_progress(struct logger *logger, bool last)
{
    if (logger->cli->quiet || !cli_is_stderr_terminal() ||
        monotonic_us() < logger->typed.typing_hold_until_us ||
        (!last && monotonic_us() - logger->progress_shown_us < PROGRESS_PERIOD_US))
        return;
    char queue[40] = "";
    struct collector_progress p;
    unsigned permille = watch_fill_permille(&logger->watch);
    logger->progress_shown_us = monotonic_us();
    collector_get_progress(logger->collector, &p);
    const char *state = p.run            ? mr_landing_state_text(p.landing_state)
                      : p.hello_received ? "no landing"
                                         : "waiting for a board";
    if (permille >= QUEUE_SHOWN_MIN_PERMILLE)
        snprintf(queue, sizeof queue, "  queue %u %% full", permille / 10);
    fprintf(stderr,
            "\r%s %8.3f s  %u switches  CAN %lld frames, %lld lost  serial %lld frames, %lld "
            "lost%s \033[K%s",
            state, p.newest_block < 0 ? 0.0 : (double)p.newest_block / 1000.0, p.edge_count,
            (long long)p.counts[LINK_CAN].received, (long long)p.counts[LINK_CAN].lost,
            (long long)p.counts[LINK_SERIAL].received, (long long)p.counts[LINK_SERIAL].lost, queue,
            last ? "\n" : "");
}

/* Returns the diagnosis of the first link that received anything. Called if no board was
 * identified. */
static enum diagnosis diagnose_links(const struct logger *logger, const struct link **link)
{
    char text[DIAGNOSIS_TEXT_SIZE];
    enum diagnosis diagnosis = DIAGNOSIS_SILENT;
    for (int kind = LINK_KINDS - 1; kind >= 0 && diagnosis == DIAGNOSIS_SILENT; kind--) {
        const struct link *one = logger->link[kind];
        if (!one)
            continue;
        *link = one;
        diagnosis = link_diagnose(*link, text);
    }
    return diagnosis;
}

enum mr_status logger_check_received(const struct logger *logger, struct error *error)
{
    struct collector_progress p;
    const struct link *link = NULL, *can = logger->link[LINK_CAN],
                      *serial = logger->link[LINK_SERIAL];
    collector_get_progress(logger->collector, &p);
    const struct store_link_counts *c = p.counts;
    bool line = serial && link_counters(serial)->rx.baud != 0;
    if (p.hello_received)
        return set_different_boards_error(logger, error);
    const char *and = can && serial ? " and " : "";
    if (c[LINK_CAN].foreign > 0 || (!line && c[LINK_SERIAL].bad + c[LINK_SERIAL].foreign > 0)) {
        if (c[LINK_CAN].received + c[LINK_SERIAL].received == 0)
            return error_set(error, MR_MALFORMED,
                             "no data from a matrig board: %s%s%s; check that the link leads to "
                             "the board and that the bit rate is right",
                             can ? link_get_spec(can) : "", and,
                             serial ? link_get_spec(serial) : "");
    }
    diagnose_links(logger, &link);
    return link_set_no_board_error(link, error);
}

/* Reports once, for each open link, that no board has been received for a while. */
void logger_note_missing_board(struct logger *logger)
{
    char text[DIAGNOSIS_TEXT_SIZE];
    uint64_t now_us = monotonic_us();
    if (logger->no_board_deadline_us == 0)
        logger->no_board_deadline_us = now_us + NO_BOARD_TIMEOUT_US;
    if (now_us < logger->no_board_deadline_us || logger->no_board_reported)
        return;
    logger->no_board_reported = true;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (!logger->is_link_open[link] || logger_has_received_hello(logger))
            continue;
        link_diagnose(logger->link[link], text);
        logger_clear_progress(logger);
        cli_note(logger->cli, "%s", text);
    }
}

/* ---- presence of the board ----
 *
 * A board sends a hello and the state of its landing every second on each link. */

/* time after which silence of all links is reported; with the period of the checks, within 2 s */
#define ALL_LINKS_SILENCE_MIN_US 1700000u
#define ONE_LINK_SILENCE_MIN_US  4000000u /* time after which silence of one link is reported */
/* after a pause of this program of at least this length, unread data may be waiting */
#define PROCESS_PAUSE_MIN_US     500000u

static void update_message_counts(struct logger *logger, const struct collector_progress *p,
                                  uint64_t now_us)
{
    bool stood = now_us - logger->presence_check_us > PROCESS_PAUSE_MIN_US ||
                 watch_refusal_start_us(&logger->watch) != 0;
    logger->presence_check_us = now_us;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        bool more = p->counts[link].received != logger->last_message_count[link];
        bool waits = logger->is_link_open[link] &&
                     link_queue_has_unread(link_reader_queue(logger->reader[link]));
        logger->last_message_count[link] = p->counts[link].received;
        if (more ||
            (logger->last_message_us[link] && !logger->silence_reported && (stood || waits)))
            logger->last_message_us[link] = now_us;
    }
}

static uint64_t find_newest_message_us(const struct logger *logger)
{
    uint64_t can_us = logger->last_message_us[LINK_CAN],
             serial_us = logger->last_message_us[LINK_SERIAL];
    return can_us > serial_us ? can_us : serial_us;
}

uint64_t logger_next_silence_check_us(const struct logger *logger)
{
    return logger->board_reported && !logger->silence_reported
             ? find_newest_message_us(logger) + ALL_LINKS_SILENCE_MIN_US
             : UINT64_MAX;
}

/* Writes the state of a landing: "idle, waiting to be armed", "armed, landing 7". */
static void write_state_text(const struct mr_landing *landing, char *out, size_t size)
{
    if (landing->state == MR_LANDING_IDLE || landing->state == MR_LANDING_DONE)
        snprintf(out, size, "%s, waiting to be armed", mr_landing_state_text(landing->state));
    else
        snprintf(out, size, "%s, landing %u", mr_landing_state_text(landing->state),
                 landing->landing);
}

static void note_silence(struct logger *logger, const char *state, uint64_t now_us)
{
    uint64_t newest = find_newest_message_us(logger);
    bool now_silent = now_us - newest >= ALL_LINKS_SILENCE_MIN_US;
    if (now_silent != logger->silence_reported) {
        logger_clear_progress(logger);
        if (now_silent)
            cli_note(logger->cli,
                     "the board is SILENT: no data for %.1f s, last state %s; check power and "
                     "cables, because no data is recorded until the board sends again",
                     (double)(now_us - newest) / 1e6, state);
        else
            cli_note(logger->cli, "the board sends again: %s", state);
    }
    /* the links may return one after the other, so each link gets the full time limit again */
    for (unsigned link = 0; link < LINK_KINDS && logger->silence_reported && !now_silent; link++)
        logger->last_message_us[link] = logger->last_message_us[link] ? now_us : 0;
    logger->silence_reported = now_silent;
    for (unsigned link = 0; link < LINK_KINDS && !now_silent; link++) {
        bool lost = logger->last_message_us[link] &&
                    now_us - logger->last_message_us[link] >= ONE_LINK_SILENCE_MIN_US;
        if (lost != logger->link_silence_reported[link]) {
            logger_clear_progress(logger);
            cli_note(logger->cli,
                     lost ? "%s receives no more data, but the other link does: check the cable of "
                            "the silent link"
                          : "%s: data from the board is received again",
                     link_get_spec(logger->link[link]));
        }
        logger->link_silence_reported[link] = lost;
    }
}

void logger_check_board_presence(struct logger *logger)
{
    struct collector_progress p;
    uint64_t now_us = monotonic_us();
    char state[80];
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link] &&
            (!logger->is_link_open[link] || link_is_from_recording(logger->link[link])))
            return;
    }
    collector_get_progress(logger->collector, &p);
    update_message_counts(logger, &p, now_us);
    if (!p.landing || !p.board_uid[0])
        return;
    write_state_text(p.landing, state, sizeof state);
    if (logger->board_reported) {
        note_silence(logger, state, now_us);
        return;
    }
    logger->board_reported = true;
    logger_clear_progress(logger);
    const bool both = logger->last_message_us[LINK_CAN] && logger->last_message_us[LINK_SERIAL];
    cli_note(logger->cli, "board %s, firmware %s, on %s: %s", p.board_uid, p.firmware,
             both                                ? "CAN and serial"
             : logger->last_message_us[LINK_CAN] ? "CAN"
                                                 : "serial",
             state);
}

/* Adds, for each message, the number that the board counted and the link did not receive in the
 * whole session. */
static void add_missing_messages(int kind, const int64_t missing[MR_MESSAGE_COUNT],
                                 struct answer *answer)
{
    char text[1000] = "";
    size_t used = 0;
    answer_open_group(answer, "missing", "");
    for (unsigned place = 0; place < MR_MESSAGE_COUNT; place++) {
        if (missing[place] == 0)
            continue;
        answer_add_count(answer, mr_message_name(place), NULL, missing[place]);
        if (used < sizeof text)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s %s %lld", used ? "," : "",
                                     mr_message_name(place), (long long)missing[place]);
    }
    if (used)
        answer_add_sentence(answer, NULL, "messages missed on %s in this session:%s",
                            summary_link_name(kind), text);
    answer_close_group(answer);
}

static void add_link_to_answer(const struct logger *logger, unsigned link,
                               const struct collector_progress *p, struct answer *answer)
{
    enum link_kind kind = (enum link_kind)link;
    const struct store_link_counts *c = &p->counts[kind];
    int64_t fault[LINK_FAULT_COUNT];
    char line[400];
    for (unsigned i = 0; i < LINK_FAULT_COUNT; i++)
        fault[i] = (int64_t)logger->counters[link].fault_count[i];
    summary_format_link_errors(fault, line, sizeof line);
    answer_open_group(answer, kind == LINK_CAN ? "can" : "serial", "");
    answer_add_count(answer, "received", NULL, c->received);
    answer_add_count(answer, "lost", NULL, c->lost);
    answer_add_count(answer, "dropped", NULL, c->dropped);
    answer_add_count(answer, "bad", NULL, c->bad);
    answer_add_count(answer, "foreign", NULL, c->foreign);
    add_missing_messages((int)kind, p->missing_count[kind], answer);
    answer_add_json(answer, "troubles", summary_link_errors_to_json(fault));
    if (line[0])
        answer_add_sentence(answer, NULL, "%s link in this session: %s",
                            summary_link_name((int)kind), line);
    const uint64_t elsewhere = link_counters(logger->link[link])->other_interface_frames;
    if (elsewhere) {
        answer_add_count(answer, "other_interfaces", NULL, (int64_t)elsewhere);
        answer_add_sentence(answer, NULL, "frames of other buses that were not logged: %llu",
                            (unsigned long long)elsewhere);
    }
    if (kind == LINK_CAN && p->frames_before_log >= 0)
        answer_add_count(answer, "before_logging", NULL, p->frames_before_log);
    answer_close_group(answer);
}

static void add_board_to_answer(const struct logger *logger, struct answer *answer)
{
    const struct link *link = NULL;
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    answer_add_count(answer, "session", NULL, collector_get_session(logger->collector));
    answer_add_count(answer, "base", NULL, logger->can_base);
    answer_open_group(answer, "links", "");
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        if (logger->link[kind])
            add_link_to_answer(logger, (unsigned)kind, &p, answer);
    }
    answer_close_group(answer);
    answer_add_text_or_missing(
        answer, "unheard", NULL,
        p.hello_received ? NULL : diagnosis_name(diagnose_links(logger, &link)), NULL);
}

int logger_show_session(struct logger *logger, const char *db, const struct error *error, int code)
{
    struct answer *answer = answer_new(logger->cli->si);
    char held[300];
    watch_session_text(&logger->watch, held, sizeof held);
    answer_add_json(answer, "db", json_string(logger->saved_path[0] ? logger->saved_path : db));
    answer_add_text(answer, "ended_by", NULL, "%s", logger->ended_by);
    add_board_to_answer(logger, answer);
    answer_add_json(answer, "queue", watch_json(&logger->watch));
    if (held[0])
        answer_add_sentence(answer, NULL, "delays in writing the campaign in this session: %s",
                            held);
    answer_add_json(answer, "landings", json_incref(logger->landings_json));
    answer_add_text_or_missing(answer, "error", NULL, error->text, NULL);
    int shown = answer_print(logger->cli, answer, code);
    return logger->cli->json ? shown : code;
}

void logger_end_live(struct logger *logger, const struct error *error)
{
    char why[sizeof error->text + 40];
    if (error->status != MR_OK)
        snprintf(why, sizeof why, "Log ended: %s", error->text);
    else if (logger->shown_landing_count == 0)
        snprintf(why, sizeof why, "Log ended normally, no landing was armed");
    else if (logger->shown_landing_count == 1)
        snprintf(why, sizeof why, "Log ended normally, %s saved", logger->newest_landing);
    else
        snprintf(why, sizeof why, "Log ended normally, %u landings saved, the last is %s",
                 logger->shown_landing_count, logger->newest_landing);
    live_close(&logger->live, why);
}

/* ---- typed commands: `arm [N]` and `disarm`, one per line ----
 *
 * Before it arms, and before it ends a landing in progress, it asks for confirmation. */

#define ANSWER_TIMEOUT_US  (1000000u * ARM_CLIENT_ANSWER_TIMEOUT_S)
#define CONFIRM_TIMEOUT_US 30000000u /* time limit for the user's confirmation of a command */
#define TYPING_HOLD_US     15000000u

/* reply to an unknown command */
#define COMMAND_HELP "type arm [N] (0 to 65535; default: the next number), or disarm"

void typed_commands_begin(struct typed_commands *typed, bool commands, bool listen)
{
    typed->is_terminal = isatty(STDIN_FILENO) == 1;
    typed->is_enabled = !listen && (commands || typed->is_terminal);
    /* start value that another program is unlikely to use as its tag */
    typed->tag = (uint16_t)(link_now_us() / 1000u);
    if (typed->is_enabled)
        /* otherwise a log in the background would be stopped when it reads the terminal */
        signal(SIGTTIN, SIG_IGN);
}

int typed_commands_fd(const struct typed_commands *typed)
{
    bool background = typed->is_terminal && tcgetpgrp(STDIN_FILENO) != getpgrp();
    return typed->is_enabled && !typed->input_ended && !background &&
                   typed->text_length < sizeof typed->text
             ? STDIN_FILENO
             : -1;
}

void typed_commands_read(struct typed_commands *typed)
{
    ssize_t length = read(STDIN_FILENO, typed->text + typed->text_length,
                          sizeof typed->text - typed->text_length);
    if (length > 0)
        typed->text_length += (size_t)length;
    else
        typed->input_ended = true;
}

/* Prints a reply to a typed command, even with --quiet. */
__attribute__((format(printf, 2, 3))) static void print_reply(const struct logger *logger,
                                                              const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    logger_clear_progress(logger);
    fputs("matrig: ", stderr);
    vfprintf(stderr, format, arguments);
    fflush(stderr);
    va_end(arguments);
}

/* Removes the first line from the buffer. Returns false if there is no complete line. */
static bool read_line(struct typed_commands *typed, char line[sizeof typed->text])
{
    char *end = memchr(typed->text, '\n', typed->text_length);
    size_t length = end ? (size_t)(end - typed->text) : typed->text_length;
    if (!end && typed->text_length < sizeof typed->text)
        return false; /* ignore an incomplete line at the end of the input */
    if (!end) {       /* the line is longer than any command */
        memcpy(line, typed->text, length - 1);
        line[length - 1] = '\0';
        typed->text_length = 0;
        return true;
    }
    memcpy(line, typed->text, length);
    line[length] = '\0';
    typed->text_length -= length + 1;
    memmove(typed->text, end + 1, typed->text_length);
    return true;
}

static void send_command(struct logger *logger)
{
    struct typed_commands *typed = &logger->typed;
    typed->command.tag = ++typed->tag;
    typed->needs_confirmation = false;
    typed->typing_hold_until_us = 0;
    typed->deadline_us = monotonic_us() + ANSWER_TIMEOUT_US;
    typed->is_answered = false;
    typed->is_sent = logger_send(logger, &typed->command, false);
    if (!typed->is_sent)
        print_reply(logger, "cannot send %s, because no link accepts commands\n",
                    mr_command_name(typed->command.code));
}

static void handle_command(struct logger *logger, const char *line);

/* Processes the reply to a request for confirmation. If it is a new command instead of `yes`,
 * executes that command. */
static void handle_confirmation(struct logger *logger, const char *line)
{
    struct typed_commands *typed = &logger->typed;
    char word[4] = "", more = '\0';
    if (sscanf(line, " %3s %c", word, &more) == 1 && strcmp(word, "yes") == 0) {
        send_command(logger);
        return;
    }
    typed->needs_confirmation = false;
    typed->typing_hold_until_us = 0;
    print_reply(logger, "not confirmed (the answer was not yes): nothing was sent\n");
    if (mr_command_parse(line, 0, &typed->command) == MR_OK)
        handle_command(logger, line);
}

/* Returns the state of a landing in progress as text; NULL: none. */
static const char *get_recorded_state_text(const struct logger *logger)
{
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    return arm_client_is_recording(p.landing_state) && p.run
             ? mr_landing_state_text(p.landing_state)
             : NULL;
}

static void handle_command(struct logger *logger, const char *line)
{
    struct typed_commands *typed = &logger->typed;
    if (line[strspn(line, " \t\r")] == '\0') {
        typed->typing_hold_until_us = monotonic_us() + TYPING_HOLD_US;
        print_reply(logger, "%s: ", COMMAND_HELP);
        return;
    }
    typed->typing_hold_until_us = 0;
    if (mr_command_parse(line, 0, &typed->command) != MR_OK ||
        (typed->command.code != MR_COMMAND_ARM &&
         (typed->command.code != MR_COMMAND_DISARM || typed->command.argument != 0)) ||
        typed->command.argument < 0 || typed->command.argument > ARM_CLIENT_LANDING_MAX) {
        print_reply(logger, "not a command: '%.40s'; %s\n", line, COMMAND_HELP);
        return;
    }
    bool arm = typed->command.code == MR_COMMAND_ARM;
    char doubts[ARMING_TEXT_SIZE] = "";
    const char *recording = get_recorded_state_text(logger);
    if (!arm && !recording) {
        send_command(logger);
        return;
    }
    typed->needs_confirmation = true;
    if (arm)
        arming_write_warnings(logger->store, (int64_t)link_now_us(), doubts);
    for (char *at = doubts, *end; *at; at = end + (*end == '\n')) {
        end = at + strcspn(at, "\n");
        print_reply(logger, "%.*s\n", (int)(end - at), at);
    }
    typed->deadline_us = typed->typing_hold_until_us = monotonic_us() + CONFIRM_TIMEOUT_US;
    if (!arm)
        print_reply(
            logger,
            "disarm the board? Its state is %s; the recording then ends. Type yes: ", recording);
    else if (typed->command.argument)
        print_reply(logger,
                    "arm the board for landing %d? It records until the gear has stopped and the "
                    "mat is at rest. Type yes: ",
                    typed->command.argument);
    else
        print_reply(logger, "arm the board for the next landing? It records until the gear has "
                            "stopped and the mat is at rest. Type yes: ");
}

/* Reports the outcome of the sent command. */
static void report_answer(struct logger *logger)
{
    struct typed_commands *typed = &logger->typed;
    const char *name = mr_command_name(typed->command.code);
    if (typed->is_answered) {
        typed->is_sent = false;
        if (typed->answer == MR_OK)
            print_reply(logger, "%sed\n", name);
        else
            print_reply(logger, "%s refused: %s\n", name, arm_client_refusal_text(typed->answer));
    } else if (monotonic_us() > typed->deadline_us) {
        typed->is_sent = false;
        print_reply(
            logger,
            "the board did not answer `%s` within 3 s; before you try again, check its state\n",
            name);
    }
}

void typed_commands_update(struct logger *logger)
{
    struct typed_commands *typed = &logger->typed;
    char line[sizeof typed->text];
    if (!typed->is_enabled)
        return;
    /* the store is refusing data, so the answer may still be in the queue */
    if (typed->is_sent && watch_refusal_start_us(&logger->watch))
        typed->deadline_us = monotonic_us() + ANSWER_TIMEOUT_US;
    if (typed->is_sent)
        report_answer(logger);
    if (typed->needs_confirmation && monotonic_us() > typed->deadline_us)
        handle_confirmation(logger, "");
    bool has_board = logger_has_received_hello(logger);
    /* Commands from a script wait until a board is there; a user at a terminal gets a message
     * instead. */
    bool has_no_board = !has_board && !typed->is_terminal;
    if (typed->is_sent || has_no_board || !read_line(typed, line))
        return;
    if (typed->needs_confirmation)
        handle_confirmation(logger, line);
    else if (!has_board)
        print_reply(logger, "no hello from a board yet: nothing was sent\n");
    else
        handle_command(logger, line);
}
