/* Insides of matrig log: what it holds while it collects. logger.c does the work, tell.c talks to
 * the user, watch.c tells while they wait. Its loop is host/commands/log_command.c.
 *
 * Each link has a thread that reads it into a queue (host/link/queue.h). One thread takes from the
 * queues and writes: the store and the collectors are its alone. The third kind looks on (watch.h).
 *
 * One log logs one board; its links are numbered by their kind. */
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

/* Commands on standard input. */
struct typed {
    bool on, terminal;
    bool ended;     /* there is no more to read */
    char text[256]; /* read, and not yet obeyed */
    size_t length;
    struct mr_command command; /* the one asked about, or sent */
    bool asked;                /* whether it is meant; `yes` is waited for */
    bool sent;                 /* its answer is waited for until until_us */
    bool answered;             /* and is there: */
    enum mr_status answer;
    uint16_t tag; /* of the last one */
    uint64_t until_us;
    uint64_t hold_us; /* no progress is drawn until then, over what is being typed */
};

struct logger {
    const struct cli *cli;
    struct store *store;
    struct collector *collector; /* NULL until the session begins */
    uint16_t base;               /* of the board on CAN */
    const char *db, *page;       /* page: NULL, none is written */
    pid_t page_child;            /* writes it; 0: none */
    bool page_again;             /* another one is due after it */
    int64_t silent_block;        /* the newest, */
    uint64_t silent_us;          /* and since when; 0: not begun */
    int64_t silent_run;          /* the landing whose silence was told */
    uint64_t asked_us;           /* for the configuration; 0: not, or a landing came in between */
    unsigned asks;               /* since the beginning or the last landing */
    bool exchanged_told;         /* that CAN and serial are two boards */
    bool other_heard;            /* a hello at other_base, of another board */
    uint16_t other_base;
    bool other_told; /* that there is another board */
    struct link *link[LINK_KINDS];
    bool open[LINK_KINDS];
    /* of a recording, not drained: poll need not see what waits inside the link */
    bool more[LINK_KINDS];
    struct link_reader *reader[LINK_KINDS];    /* NULL: not used */
    int news;                                  /* eventfd: something is in a queue */
    struct link_counters counters[LINK_KINDS]; /* as of what was taken */
    bool troubled[LINK_KINDS];                 /* they have changed, and nobody has taken notice */
    uint64_t noted[LINK_KINDS][LINK_TROUBLES]; /* of them, seen by the user */
    uint64_t noted_us[LINK_KINDS][LINK_TROUBLES];
    struct watch watch;
    bool in_transaction;
    uint64_t begun_us;
    uint64_t commit_us;   /* the last one took so long */
    uint64_t again_us;    /* until then nothing is written: the campaign took nothing */
    char saved[4096];     /* the campaign was taken away, and is here now; "": not */
    char taken[9000];     /* what became of the one that was named, in a sentence */
    char lost_before[40]; /* what came before that time of day is not in it; "": all is */
    bool refilled;        /* the queues give all that they have kept once more */
    bool emptied;         /* what was logged is no longer in it */
    bool followed;        /* the watch knows the campaign with its journal */
    uint64_t rescue_us;   /* when saving was tried */
    uint64_t shown_us;
    bool mute[LINK_KINDS];   /* nothing can be sent on it */
    double wait_s;           /* for a device that went away */
    const char *ended_by;    /* NULL: going on */
    bool hurried;            /* the end was asked for twice */
    uint64_t signalled_us;   /* when it was asked for first; 0: not yet */
    struct error link_error; /* the first link that broke; logging went on with the other */
    json_t *landings;
    char *unsaid; /* of the summaries: what standard output has not taken; NULL: never anything */
    size_t unsaid_length;
    int output[2];          /* standard output and error as they were, while logger_hasty; 0: not */
    bool all;               /* the whole summary of a landing */
    unsigned shown;         /* landings summarised */
    char newest[80];        /* of them, for people */
    struct live live;       /* of --live; else all zero */
    int64_t clock_ahead_us; /* the time of day of the monotonic clock; 0: not looked at yet */
    uint64_t unheard_us;    /* from when on it is told that no board is heard; 0: not begun */
    bool unheard_told;
    uint64_t live_us;              /* when the board was asked to be live; 0: not yet */
    bool met;                      /* who answered was told */
    uint64_t turn_us;              /* of the look for messages before this one */
    int64_t heard[LINK_KINDS];     /* messages, by then */
    uint64_t heard_us[LINK_KINDS]; /* when they became more; 0: never */
    bool silent, lost[LINK_KINDS]; /* the silence of all, of one alone was told */
    struct typed typed;
    struct collector_own own;      /* commands that it gave */
    uint8_t nonce[MR_PROOF_BYTES]; /* of which the proof of the last order was made */
};

/* ---- logger.c ---- */

/* A signal that asks for the end came; the second one hurries it. */
bool logger_signalled(struct logger *logger, int signals);
/* What waits in its queue, a turn's worth. A link that breaks is ended, and is no error. */
enum mr_status logger_receive(struct logger *logger, unsigned link, struct error *error);
/* Leaves of two links that are ready the one that is behind in board time. */
void logger_keep_in_step(const struct logger *logger, bool ready[LINK_KINDS]);
/* The transaction that is open around all that is written. Committing none is MR_OK. */
enum mr_status logger_begin(struct logger *logger, struct error *error);
enum mr_status logger_commit(struct logger *logger, struct error *error);
/* It has been open for long enough: what was received is to be on disk within 100 ms. */
bool logger_commit_due(struct logger *logger);
/* After an error: when the store refused for a reason that may pass, takes back and forgets the
 * error: it is tried again at again_us. Else returns the error's status. */
enum mr_status logger_wait_for_store(struct logger *logger, struct error *error);
/* When the campaign is no longer where it was: saves it beside, and goes on there. When it is no
 * longer what it was: begins a new one beside it, with what the queues have kept. */
enum mr_status logger_rescue(struct logger *logger, struct error *error);
/* Writes what is in the queues, and the end of the session. What a campaign does not take in time
 * goes with all that the queues keep into a new one beside it. */
enum mr_status logger_finish(struct logger *logger, int signals, struct error *error);
/* False: somebody has overwritten the campaign since; told, and its journal does not stay with what
 * is there now. */
bool logger_close_store(struct logger *logger);
/* Sends it to the board, over serial when that can be, else over CAN; false: over neither.
 * `unasked`: nobody waits for it, so a link that does not take it is not tried again. */
bool logger_send(struct logger *logger, const struct mr_command *command, bool unasked);
/* The typed order was refused, and its nonce is no longer the newest: another program was first.
 * False: it is not given again. */
bool logger_again(struct logger *logger);
void logger_ask_for_configuration(struct logger *logger);
/* The live view: events that are due, and what its viewers ask of the board. */
void logger_serve_live(struct logger *logger);

/* ---- tell.c ---- */

/* A terminal that was stopped, or whose connection hangs, must not hold up the writing: from now
 * on, or no more, standard output and error take what they can at once. What is left of the
 * summaries is printed later; of the rest it is not said. */
void logger_hasty(struct logger *logger, bool on);
/* What is left of the summaries, as far as standard output takes it; waits for it when it is not
 * hasty. */
void logger_say_rest(struct logger *logger);

/* Takes the progress away before a line goes to stderr. */
void logger_clear_progress(const struct logger *logger);
/* Troubles of a link that are new. */
void logger_note_troubles(struct logger *logger, unsigned link);
void logger_note_unheard(struct logger *logger);
/* Of a board that speaks now, not of a recording: who answered; that it, or one of its links, fell
 * silent, and that it speaks again. */
void logger_note_board(struct logger *logger);
/* When its silence is due; UINT64_MAX: it is not. */
uint64_t logger_silence_due_us(const struct logger *logger);
/* A serial line is not that of the board on CAN: once. */
void logger_note_exchanged(struct logger *logger);
enum mr_status logger_show_finished(struct logger *logger, struct error *error);
enum mr_status logger_show_silent(struct logger *logger, struct error *error);
void logger_note_health(struct logger *logger);
/* Orders that the board obeyed or refused, whoever gave them. */
void logger_note_orders(struct logger *logger);
void logger_show_progress(struct logger *logger, bool last);
/* Another board says hello on the bus: once. */
void logger_note_other(struct logger *logger, const struct link_frame *frame);
/* Nobody spoke, or nobody that matrig understands. */
enum mr_status logger_check_heard(const struct logger *logger, struct error *error);
/* What the whole session came to, in landings and outside. Returns `code`, or with --json the exit
 * code of a failed output: people may have gone away while it logged. */
int logger_show_session(struct logger *logger, const char *db, const struct error *error, int code);

/* What the viewers of the live page are told when all is over. */
void logger_end_live(struct logger *logger, const struct error *error);
/* Looks after the process that writes the page; `end`: waits for it, a minute at most. */
void logger_serve_page(struct logger *logger, bool end);

/* `commands`: also when standard input is no terminal. `listen`: never. */
void typed_begin(struct typed *typed, bool commands, bool listen);
/* To be waited for until it can be read, then typed_read; -1: nothing is. */
int typed_fd(const struct typed *typed);
void typed_read(struct typed *typed);
/* Obeys a line, and looks for the answer of the command before. Every turn. */
void typed_turn(struct logger *logger);

#endif
