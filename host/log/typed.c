#include "host/log/typed.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/board/arm_client.h"
#include "host/log/logger.h"
#include "host/base/monotonic_clock.h"

#define ANSWER_US (1000000u * ARM_CLIENT_ANSWER_S)
#define ASKED_US  30000000u /* a question that nobody answers is over */
#define TYPING_US 15000000u
#define HELP      "arm [N], N from 0 to 65535 (none: the board counts on), or disarm"

void typed_begin(struct typed *typed, bool commands, bool listen)
{
    typed->terminal = isatty(STDIN_FILENO) == 1;
    typed->on = !listen && (commands || typed->terminal);
    typed->tag = (uint16_t)(link_now_us() / 1000u); /* not that of who else asks */
    if (typed->on)
        /* in the background nothing is read, and nothing may stop the logging */
        signal(SIGTTIN, SIG_IGN);
}

int typed_fd(const struct typed *typed)
{
    bool background = typed->terminal && tcgetpgrp(STDIN_FILENO) != getpgrp();
    return typed->on && !typed->ended && !background && typed->length < sizeof typed->text
             ? STDIN_FILENO
             : -1;
}

void typed_read(struct typed *typed)
{
    ssize_t length = read(STDIN_FILENO, typed->text + typed->length,
                          sizeof typed->text - typed->length);
    if (length > 0)
        typed->length += (size_t)length;
    else
        typed->ended = true;
}

bool typed_holds(const struct typed *typed, uint64_t now_us)
{
    return now_us < typed->hold_us;
}

/* Somebody asked, so it is said also with --quiet. */
__attribute__((format(printf, 2, 3))) static void say(const struct logger *logger,
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

/* Takes the first line out. False: none is whole. */
static bool take_line(struct typed *typed, char line[sizeof typed->text])
{
    char *end = memchr(typed->text, '\n', typed->length);
    size_t length = end ? (size_t)(end - typed->text) : typed->length;
    if (!end && typed->length < sizeof typed->text)
        return false; /* at the end of the input: a line that was never sent off */
    if (!end) {       /* no command is so long */
        memcpy(line, typed->text, length - 1);
        line[length - 1] = '\0';
        typed->length = 0;
        return true;
    }
    memcpy(line, typed->text, length);
    line[length] = '\0';
    typed->length -= length + 1;
    memmove(typed->text, end + 1, typed->length);
    return true;
}

static void send_it(struct logger *logger)
{
    struct typed *typed = &logger->typed;
    typed->command.tag = ++typed->tag;
    typed->asked = false;
    typed->hold_us = 0;
    typed->until_us = monotonic_us() + ANSWER_US;
    (void)collector_take_answer(logger->collector); /* one that came before is of another */
    typed->sent = logger_send(logger, &typed->command, false);
    if (!typed->sent)
        say(logger, "%s: cannot be sent, no link takes it\n", mr_command_name(typed->command.code));
}

/* `yes` or anything else. */
static void take_reply(struct logger *logger, const char *line)
{
    struct typed *typed = &logger->typed;
    char word[4] = "", more = '\0';
    if (sscanf(line, " %3s %c", word, &more) == 1 && strcmp(word, "yes") == 0) {
        send_it(logger);
        return;
    }
    typed->asked = false;
    typed->hold_us = 0;
    say(logger, "not yes: nothing was sent\n");
}

/* State of a landing that is going on; NULL: none is. */
static const char *what_is_recorded(const struct logger *logger)
{
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    return arm_client_recording(p.state) && p.run ? mr_landing_state_text(p.state) : NULL;
}

static void take_command(struct logger *logger, const char *line)
{
    struct typed *typed = &logger->typed;
    if (line[strspn(line, " \t\r")] == '\0') {
        typed->hold_us = monotonic_us() + TYPING_US;
        say(logger, "%s: ", HELP);
        return;
    }
    typed->hold_us = 0;
    if (mr_command_parse(line, 0, &typed->command) != MR_OK ||
        (typed->command.code != MR_COMMAND_ARM &&
         (typed->command.code != MR_COMMAND_DISARM || typed->command.argument != 0)) ||
        typed->command.argument < 0 || typed->command.argument > ARM_CLIENT_LANDING_MOST) {
        say(logger, "no command: '%.40s'; %s\n", line, HELP);
        return;
    }
    bool arm = typed->command.code == MR_COMMAND_ARM;
    const char *recording = what_is_recorded(logger);
    if (!arm && !recording) {
        send_it(logger);
        return;
    }
    typed->asked = true;
    typed->until_us = typed->hold_us = monotonic_us() + ASKED_US;
    if (!arm)
        say(logger, "disarm? What the board records, it is %s, ends there. yes: ", recording);
    else if (typed->command.argument)
        say(logger,
            "arm for landing %d? The board records until the gear has stopped and the mat is at "
            "rest. yes: ",
            typed->command.argument);
    else
        say(logger, "arm for the next landing? The board records until the gear has stopped and "
                    "the mat is at rest. yes: ");
}

/* What came of the command that was sent. */
static void take_answer(struct logger *logger)
{
    struct typed *typed = &logger->typed;
    const struct mr_ack *answer = collector_take_answer(logger->collector);
    const char *name = mr_command_name(typed->command.code);
    if (answer && answer->tag == typed->command.tag) {
        typed->sent = false;
        if (answer->status == MR_OK)
            say(logger, "%sed\n", name);
        else
            say(logger, "%s refused: %s\n", name,
                arm_client_refusal((enum mr_status)answer->status));
    } else if (monotonic_us() > typed->until_us) {
        typed->sent = false;
        say(logger,
            "the board did not answer `%s` within 3 s; look what state it is in before trying "
            "again\n",
            name);
    }
}

void typed_turn(struct logger *logger)
{
    struct typed *typed = &logger->typed;
    char line[sizeof typed->text];
    if (!typed->on)
        return;
    if (typed->sent && watch_refused_us(&logger->watch)) /* the answer waits in the queue */
        typed->until_us = monotonic_us() + ANSWER_US;
    if (typed->sent)
        take_answer(logger);
    if (typed->asked && monotonic_us() > typed->until_us)
        take_reply(logger, "");
    bool there = logger_heard(logger);
    /* a script's commands wait for the board; who types is told */
    bool nobody = !there && !typed->terminal;
    if (typed->sent || nobody || !take_line(typed, line))
        return;
    if (typed->asked)
        take_reply(logger, line);
    else if (!there)
        say(logger, "no board has said hello yet: nothing was sent\n");
    else
        take_command(logger, line);
}
