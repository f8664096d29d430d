#include "host/day/desk.h"

#include <ctype.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include "host/base/place.h"
#include "host/base/process.h"

static void stay(int signal)
{
    (void)signal;
}

void desk_begin(void)
{
    /* a handler, for what is ignored would stay so in the programs that are started */
    const struct sigaction action = {.sa_handler = stay, .sa_flags = SA_RESTART};
    sigaction(SIGINT, &action, NULL);
    setvbuf(stdout, NULL, _IOLBF, 0); /* in order with what the programs say */
}

/* One byte; nothing is kept back, for the next program reads what is typed next. */
static bool take_byte(char *byte)
{
    ssize_t got;
    do
        got = read(STDIN_FILENO, byte, 1);
    while (got < 0 && errno == EINTR);
    return got == 1;
}

bool desk_line(char *line, size_t size)
{
    size_t length = 0;
    char byte;
    while (take_byte(&byte)) {
        if (byte == '\n') {
            line[length] = '\0';
            return true;
        }
        if (length + 1 < size && byte != '\r')
            line[length++] = byte;
    }
    line[length] = '\0';
    return false;
}

static int elsewhere = -1;

void desk_listen(int keys)
{
    elsewhere = keys;
}

void desk_forget(void)
{
    char byte;
    while (elsewhere >= 0 && read(elsewhere, &byte, 1) == 1)
        ;
}

/* 0: nothing came; 1: at the keyboard; 2: elsewhere, then *byte is it. */
static int wait_for_key(int within_ms, char *byte)
{
    struct pollfd polled[] = {{.fd = STDIN_FILENO, .events = POLLIN},
                              {.fd = elsewhere, .events = POLLIN}};
    int got;
    do
        got = poll(polled, 2, within_ms);
    while (got < 0 && errno == EINTR && within_ms < 0);
    if (got > 0 && polled[1].revents && read(elsewhere, byte, 1) == 1)
        return 2;
    return got > 0 && polled[0].revents ? 1 : 0;
}

char desk_key(int within_ms)
{
    char line[80], byte = DESK_END;
    struct termios was, raw;
    if (tcgetattr(STDIN_FILENO, &was) != 0) { /* no terminal */
        int from = wait_for_key(within_ms, &byte);
        if (from != 1)
            return from ? byte : 0;
        if (!desk_line(line, sizeof line))
            return DESK_END;
        return line[0] ? (char)tolower((unsigned char)line[0]) : DESK_ENTER;
    }
    raw = was;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO | ISIG);
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
    int from = wait_for_key(within_ms, &byte);
    if (from == 1 && (!take_byte(&byte) || byte == 3 || byte == 4)) /* Ctrl-C, Ctrl-D */
        byte = DESK_END;
    tcsetattr(STDIN_FILENO, TCSANOW, &was);
    if (!from)
        return 0;
    return byte == '\r' ? DESK_ENTER : (char)tolower((unsigned char)byte);
}

void desk_command_begin(struct desk_command *command, const char *name)
{
    static char program[4096];
    place_program(program, sizeof program);
    *command = (struct desk_command){.words = {program, name}, .count = 2};
}

void desk_command_add(struct desk_command *command, const char *word)
{
    if (command->count + 1 < DESK_WORDS)
        command->words[command->count++] = word;
}

void desk_command_option(struct desk_command *command, const char *option, const char *value)
{
    if (!value || !value[0])
        return;
    desk_command_add(command, option);
    desk_command_add(command, value);
}

const char *desk_command_text(const struct desk_command *command, char *out, size_t size)
{
    size_t at = (size_t)snprintf(out, size, "matrig");
    for (size_t i = 1; i < command->count && at < size; i++) {
        bool plain = command->words[i][0] != '\0' &&
                     strcspn(command->words[i], " '\"$&;()<>|*?\\") == strlen(command->words[i]);
        at += (size_t)snprintf(out + at, size - at, plain ? " %s" : " '%s'", command->words[i]);
    }
    return out;
}

int desk_run(const struct desk_command *command, struct error *error)
{
    static const int streams[3] = {-1, -1, -1};
    pid_t child;
    int status = 0;
    if (process_start(command->words, streams, &child, error) != MR_OK)
        return -1;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
