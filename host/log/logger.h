/* Insides of matrig log: what it holds while it collects, and its parts: links.c (what comes), orders.c (what is asked of the board),
 * typed.c (commands on standard input), tell.c (what the user is told). Its loop is host/log_command.c. */
#ifndef MATRIG_HOST_LOG_LOGGER_H
#define MATRIG_HOST_LOG_LOGGER_H

#include "common/command.h"
#include "host/board/crash.h"
#include "host/cli.h"
#include "host/collect/collect.h"
#include "host/collect/quicklook.h"
#include "host/live/live.h"
#include "host/log/typed.h"

struct logger {
    const struct cli *cli;
    struct store *store;
    struct link *link[LINK_KINDS];
    bool open[LINK_KINDS];
    bool more[LINK_KINDS]; /* not drained: poll need not see what waits inside the link */
    struct collector *collector;
    uint64_t troubles[LINK_KINDS];              /* of the link's, taken */
    uint64_t noted[LINK_KINDS][LINK_TROUBLES];  /* of them, seen by the user */
    uint64_t noted_us[LINK_KINDS][LINK_TROUBLES];
    int64_t strangers[LINK_KINDS];  /* frames not the board's, seen by the user */
    uint16_t stranger_id[LINK_KINDS];
    uint64_t strangers_us;          /* when they were last */
    struct hil_symbols symbols; /* of --elf; none without it */
    bool in_transaction;
    uint64_t begun_us;
    uint64_t shown_us;
    uint64_t asked_us;       /* for the configuration; 0: not, or a landing came in between */
    unsigned asks;           /* since the beginning or the last landing */
    bool mute[LINK_KINDS];   /* nothing can be sent on it */
    double wait_s;           /* for a device that went away */
    const char *ended_by;    /* NULL: going on */
    struct error link_error; /* the first link that broke; logging went on with the other */
    json_t *landings;
    unsigned shown; /* landings summarised */
    struct quicklook look;
    struct live live; /* of --live; else all zero */
    int64_t clock_ahead_us; /* the time of day of the monotonic clock; 0: not looked at yet */
    uint64_t unheard_us; /* from when on it is told that no board is heard; 0: not begun */
    bool unheard_told;
    uint64_t live_us; /* when the board was asked to be live; 0: not yet */
    uint64_t channels_us; /* when the live view asked for the channels, */
    unsigned channel_asks; /* and how often */
    struct typed typed; /* commands on standard input */
};

uint64_t logger_now_us(void); /* for deadlines: never jumps */

/* ---- links.c ---- */

/* The transaction that is open around all that is written. Committing none is MR_OK. */
enum mr_status logger_begin(struct logger *logger, struct error *error);
enum mr_status logger_commit(struct logger *logger, struct error *error);
/* Keeps the links in order: a device that went away comes back, or ends its link. */
enum mr_status logger_service_links(struct logger *logger, struct error *error);
/* What waits there, a turn's worth. A link that breaks is ended, and is no error. */
enum mr_status logger_receive_can(struct logger *logger, struct error *error);
enum mr_status logger_receive_serial(struct logger *logger, struct error *error);
/* Leaves of two links that are ready the one that is behind in board time. */
void logger_keep_in_step(const struct logger *logger, bool ready[LINK_KINDS]);

/* ---- orders.c ---- */

/* Sends it over serial when that can be, else over CAN; false: over neither. `unasked`: nobody waits for it, so a link that does not
 * take it is not tried again. */
bool logger_send(struct logger *logger, const struct mr_command *command, bool unasked);
void logger_ask_for_configuration(struct logger *logger);
/* The live view: events that are due, and what its viewers ask of the board. */
void logger_serve_live(struct logger *logger);

/* ---- tell.c ---- */

/* Takes the progress away before a line goes to stderr. */
void logger_clear_progress(const struct logger *logger);
/* Troubles of a link that are new, `text` (may be NULL) in place of their own. */
void logger_note_troubles(struct logger *logger, enum link_kind kind, const char *text);
void logger_note_unheard(struct logger *logger);
void logger_note_strangers(struct logger *logger);
enum mr_status logger_show_finished(struct logger *logger, struct error *error);
enum mr_status logger_show_silent(struct logger *logger, struct error *error);
void logger_note_health(struct logger *logger);
void logger_show_progress(struct logger *logger, bool last);
/* Nobody spoke, or nobody that matrig understands. */
enum mr_status logger_check_heard(const struct logger *logger, const char *can, const char *serial, struct error *error);
/* Of the whole session. */
void logger_show_troubles(const struct logger *logger);
json_t *logger_json(const struct logger *logger, const char *db, const struct error *error);

#endif
