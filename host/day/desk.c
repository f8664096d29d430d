#include "host/day/desk.h"

#include <ctype.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include "host/base/place.h"
#include "host/base/process.h"
#include "host/base/shell.h"

static struct termios cooked; /* as the terminal was */
static volatile sig_atomic_t is_raw;

static void stay(int number)
{
    (void)number;
}

/* The terminal is given back as it was. */
static void leave(int number)
{
    if (is_raw)
        tcsetattr(STDIN_FILENO, TCSANOW, &cooked);
    signal(number, SIG_DFL);
    raise(number);
}

void desk_begin(void)
{
    /* a handler, for what is ignored would stay so in the programs that are started */
    const struct sigaction action = {.sa_handler = stay, .sa_flags = SA_RESTART};
    const struct sigaction end = {.sa_handler = leave};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &end, NULL);
    sigaction(SIGHUP, &end, NULL);
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

bool desk_line(char *line, size_t size, bool *whole)
{
    size_t length = 0;
    char byte;
    *whole = true;
    while (take_byte(&byte)) {
        if (byte == '\n') {
            line[length] = '\0';
            return true;
        }
        if (byte == '\r')
            continue;
        *whole &= length + 1 < size;
        if (length + 1 < size)
            line[length++] = byte;
    }
    line[length] = '\0';
    return false;
}

/* At a terminal: forgets what was typed ahead. True: there was something. */
static bool flush(void)
{
    struct pollfd polled = {.fd = STDIN_FILENO, .events = POLLIN};
    bool any = isatty(STDIN_FILENO) == 1 && poll(&polled, 1, 0) > 0;
    if (any)
        tcflush(STDIN_FILENO, TCIFLUSH);
    return any;
}

bool desk_ask(const char *question, char *answer, size_t size)
{
    bool whole, good;
    do {
        printf("%s", question);
        fflush(stdout);
        good = desk_line(answer, size, &whole);
        if (!whole)
            printf("too long: at most %zu characters\n", size - 1);
    } while (good && !whole);
    if (flush()) /* the rest of a paste is no key */
        printf("one line is taken; what was typed behind it is not\n");
    size_t from = strspn(answer, " \t"), length = strlen(answer);
    while (length > from && (answer[length - 1] == ' ' || answer[length - 1] == '\t'))
        length--;
    answer[length] = '\0';
    memmove(answer, answer + from, length - from + 1);
    return good && whole;
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
    struct termios raw;
    bool whole;
    if (tcgetattr(STDIN_FILENO, &cooked) != 0) { /* no terminal */
        int from = wait_for_key(within_ms, &byte);
        if (from != 1)
            return from ? byte : 0;
        if (!desk_line(line, sizeof line, &whole))
            return DESK_END;
        return line[0] ? (char)tolower((unsigned char)line[0]) : DESK_ENTER;
    }
    raw = cooked;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO | ISIG);
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    is_raw = 1;
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
    int from = wait_for_key(within_ms, &byte);
    if (from == 1 && (!take_byte(&byte) || byte == 3 || byte == 4)) /* Ctrl-C, Ctrl-D */
        byte = DESK_END;
    tcsetattr(STDIN_FILENO, TCSANOW, &cooked);
    is_raw = 0;
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
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                "0123456789_@%+=:,./-";
    FILE *file = fmemopen(out, size, "w");
    if (!file)
        abort();
    fputs("matrig", file);
    for (size_t i = 1; i < command->count; i++) {
        const char *word = command->words[i];
        fputc(' ', file);
        if (word[0] && strspn(word, plain) == strlen(word))
            fputs(word, file);
        else
            shell_quote(file, word);
    }
    fclose(file);
    out[size - 1] = '\0'; /* a text that fills it has no end yet */
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
