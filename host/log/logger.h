/* Internal data of matrig log. logger.c moves data from the links to the campaign, console.c prints
 * to the user and reads typed commands, watch.c reports while the writing thread waits. The main
 * loop is in host/commands/log_command.c.
 *
 * Each link has a thread that reads it into a queue (host/link/queue.h). One thread reads the
 * queues and writes to the campaign; only this thread uses the store and the collectors. A third
 * thread watches the writing thread (watch.h).
 *
 * One log records one board; its links are indexed by their kind. */
#ifndef MATRIG_HOST_LOG_LOGGER_H
#define MATRIG_HOST_LOG_LOGGER_H

#include "common/command.h"
#include "common/proof.h"
#include "host/board/health_client.h"
#include "host/base/cli.h"
#include "host/collect/collect.h"
#include "host/live/server.h"
#include "host/link/queue.h"
#include "host/log/watch.h"

/* Commands that the user types at standard input. */
struct typed_commands {
    bool is_enabled, is_terminal;
    bool input_ended; /* standard input has ended */
    char text[256];   /* text read but not yet processed */
    size_t text_length;
    struct mr_command command; /* the command to be confirmed, or the command that was sent */
    bool needs_confirmation;   /* the user must confirm the command with `yes` */
    bool is_sent;              /* the command was sent; its answer is awaited until deadline_us */
    bool is_answered;          /* the answer was received and is in `answer` */
    enum mr_status answer;
    uint16_t tag; /* tag of the last command */
    uint64_t deadline_us;
    /* no progress line is drawn until this time, because the user is typing */
    uint64_t typing_hold_until_us;
};

struct logger {
    const struct cli *cli;
    struct store *store;
    struct collector *collector;     /* NULL until the session begins */
    uint16_t can_base;               /* base of the board on CAN */
    const char *db_path, *page_path; /* page_path: path of the page of --page; NULL: none */
    pid_t page_process;              /* process that writes the page; 0: none */
    bool page_outdated;              /* the page must be written once more after that process */
    int64_t silence_check_block;     /* newest block when silence was last checked */
    /* time since which the newest block has not changed; 0: not started */
    uint64_t silent_since_us;
    int64_t silent_run; /* landing for which silence was last reported */
    /* time of the last request for the configuration; 0: none since the beginning or the last
     * landing */
    uint64_t config_request_us;
    unsigned config_requests; /* number of requests since the beginning or the last landing */
    /* the user was informed that CAN and serial have different boards */
    bool different_boards_reported;
    bool other_board_seen; /* a hello of another board was received at other_board_base */
    uint16_t other_board_base;
    bool other_board_reported; /* the user was informed of the other board */
    struct link *link[LINK_KINDS];
    bool is_link_open[LINK_KINDS];
    /* the link is a recording and may have buffered more data, where poll does not see it */
    bool has_buffered_data[LINK_KINDS];
    struct link_reader *reader[LINK_KINDS];    /* NULL: the link is not used */
    int event_fd;                              /* eventfd, written when a queue has a new item */
    struct link_counters counters[LINK_KINDS]; /* counters at the last item read */
    bool faults_changed[LINK_KINDS]; /* the counters have changed since they were last processed */
    uint64_t reported_fault_count[LINK_KINDS]
                                 /* error counts that were last reported to the user */
                                 [LINK_FAULT_COUNT];
    uint64_t last_fault_report_us[LINK_KINDS]
                                 /* time at which each error was last reported to the user */
                                 [LINK_FAULT_COUNT];
    struct watch watch;
    bool in_transaction;
    uint64_t transaction_begun_us;
    uint64_t commit_duration_us; /* duration of the last commit */
    /* time before which nothing is written, because the store refused a write */
    uint64_t next_write_us;
    /* path where the campaign was saved after its file was removed; "": not removed */
    char saved_path[4096];
    char file_problem_text[9000]; /* what happened to the original file: a sentence for the user */
    /* time of day before which data is missing; "": the campaign is complete */
    char data_missing_until[40];
    /* the queues were rewound, so that all items they kept are read again */
    bool queues_rewound;
    bool campaign_lost;         /* the campaign no longer contains the data logged so far */
    bool is_file_watched;       /* the watch thread knows the campaign and its journal */
    uint64_t rescue_attempt_us; /* time of the last attempt to save the campaign */
    uint64_t progress_shown_us;
    bool rejects_data[LINK_KINDS]; /* the link does not accept data */
    double absence_max_s;          /* how long to wait for a device that disappeared, s */
    const char *ended_by;          /* reason for the end; NULL: still running */
    bool end_requested_twice;      /* the end was requested twice */
    uint64_t end_request_us;       /* time of the first request to end; 0: none yet */
    /* error of the first link that failed while logging continued with the other one */
    struct error link_error;
    json_t *landings_json;
    /* text of summaries that could not be printed yet; NULL: never any */
    char *pending_output;
    size_t pending_output_length;
    /* original standard output and standard error during logger_set_nonblocking; 0: not active */
    int original_output[2];
    bool prints_full_summaries;   /* print the full summary of each landing */
    unsigned shown_landing_count; /* number of landings whose summary was printed */
    char newest_landing[80];      /* the landing whose summary was printed last, as text */
    struct live live;             /* the live page, if --live was given; otherwise all zero */
    int64_t wall_clock_offset_us; /* time of day minus the monotonic clock; 0: not determined yet */
    /* time at which to report that no board was identified; 0: not started */
    uint64_t no_board_deadline_us;
    bool no_board_reported;
    uint64_t live_request_us;   /* time of the last request for live readings; 0: none yet */
    bool board_reported;        /* the user was informed which board was identified */
    uint64_t presence_check_us; /* time at which the numbers of messages were last checked */
    int64_t last_message_count[LINK_KINDS]; /* numbers of messages at that check */
    /* time at which the number last increased; 0: never */
    uint64_t last_message_us[LINK_KINDS];
    /* silence was reported to the user: of all links, of each link */
    bool silence_reported, link_silence_reported[LINK_KINDS];
    struct typed_commands typed;
    struct collector_own_commands own_commands; /* commands that this program sent */
    uint8_t last_command_nonce[MR_PROOF_BYTES]; /* nonce in the proof of the last command */
};

/* ---- logger.c ---- */

/* True if a signal to end was received; a second signal makes the end faster. */
bool logger_has_end_signal(struct logger *logger, int signals);
/* Processes items of the link's queue, up to the limit of one turn. Ends a link that fails, without
 * returning an error. */
enum mr_status logger_process_queue(struct logger *logger, unsigned link, struct error *error);
/* If both links are ready, keeps only the one that is behind in board time. */
void logger_select_lagging_link(const struct logger *logger, bool ready[LINK_KINDS]);
/* Begin and commit the transaction that encloses all writes. Committing without a transaction is
 * MR_OK. */
enum mr_status logger_begin_transaction(struct logger *logger, struct error *error);
enum mr_status logger_commit(struct logger *logger, struct error *error);
/* True if the transaction must be committed now: received data must be on disk within 100 ms. */
bool logger_is_commit_due(struct logger *logger);
/* Call after an error. If the store refused for a temporary reason, rolls back, clears the error
 * and sets next_write_us to the time of the next try. Otherwise returns the error's status. */
enum mr_status logger_wait_for_store(struct logger *logger, struct error *error);
/* If the campaign's file was moved or removed, saves the campaign in the same folder and continues
 * in the saved file. If its content was replaced, starts a new campaign in the same folder with the
 * data that the queues have kept. */
enum mr_status logger_rescue_campaign(struct logger *logger, struct error *error);
/* Writes the content of the queues and the end of the session. If the campaign does not accept it
 * in time, starts a new campaign in the same folder with all data that the queues have kept. */
enum mr_status logger_end_session(struct logger *logger, int signals, struct error *error);
/* Closes the store. If another program has overwritten the file, reports that, makes sure that the
 * journal does not remain with the new file, and returns false. */
bool logger_close_store(struct logger *logger);
/* Sends a command to the board, over serial if possible, otherwise over CAN; returns false if
 * neither works. `is_automatic`: the program and not the user sends it; a link that fails is then
 * not used for such commands again. */
bool logger_send(struct logger *logger, const struct mr_command *command, bool is_automatic);
/* Sends a refused typed command again if a newer nonce shows that another program's command came
 * first. Returns false if it was not sent. */
bool logger_repeat_command(struct logger *logger);
void logger_request_configuration(struct logger *logger);
/* Serves the live page: sends waiting events to its viewers, and the viewers' commands to the
 * board. */
void logger_send_live_command(struct logger *logger);

/* ---- console.c ---- */

/* Makes standard output and standard error non-blocking, or blocking again, so that a stopped
 * terminal or a hanging connection cannot delay writing. Text of summaries that could not be
 * printed is printed later; other text is lost. */
void logger_set_nonblocking(struct logger *logger, bool on);
/* Prints the summaries that are still unprinted, as far as standard output accepts them; waits for
 * standard output unless it is non-blocking. */
void logger_print_pending(struct logger *logger);

/* Clears the progress line before a line is printed on stderr. */
void logger_clear_progress(const struct logger *logger);
/* Reports new errors of a link. */
void logger_note_link_faults(struct logger *logger, unsigned link);
void logger_note_missing_board(struct logger *logger);
/* Reports for a real board: which board was identified, that it or one of its links has fallen
 * silent, and that it sends again. */
void logger_check_board_presence(struct logger *logger);
/* Returns the time at which silence must be reported next; UINT64_MAX: none. */
uint64_t logger_next_silence_check_us(const struct logger *logger);
/* Reports, once, that the board on serial is not the board on CAN. */
void logger_note_different_boards(struct logger *logger);
enum mr_status logger_show_finished_landings(struct logger *logger, struct error *error);
enum mr_status logger_show_silent_landing(struct logger *logger, struct error *error);
void logger_note_health(struct logger *logger);
/* Reports commands that the board executed or refused, from any sender. */
void logger_note_answers(struct logger *logger);
void logger_show_progress(struct logger *logger, bool last);
/* Reports, once, that another board sends hello on the bus. */
void logger_note_other_board(struct logger *logger, const struct link_frame *frame);
/* Sets an error if no board was identified on the links. */
enum mr_status logger_check_received(const struct logger *logger, struct error *error);
/* Prints the totals of the session, within and outside of landings. Returns `code`; with --json,
 * the exit code of a failed output. In text mode a failed output is no error, because the user may
 * have closed the terminal. */
int logger_show_session(struct logger *logger, const char *db, const struct error *error, int code);

/* Sends the reason for the end to the viewers of the live page. */
void logger_end_live(struct logger *logger, const struct error *error);
/* Checks whether the process that writes the page has ended. `end`: waits for it, at most a
 * minute. */
void logger_update_page(struct logger *logger, bool end);

/* `commands`: reads commands even if standard input is not a terminal. `listen`: never reads
 * commands. */
void typed_commands_begin(struct typed_commands *typed, bool commands, bool listen);
/* Returns the descriptor to wait for before typed_commands_read; -1: none. */
int typed_commands_fd(const struct typed_commands *typed);
void typed_commands_read(struct typed_commands *typed);
/* Processes one typed line, and the answer to the previous command. Call it every turn of the main
 * loop. */
void typed_commands_update(struct logger *logger);

#endif
