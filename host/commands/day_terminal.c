/* Keyboard input of the command matrig day, and the starting of commands. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>

#include "host/base/cli.h"
#include "host/base/data_dir.h"
#include "host/base/process.h"
#include "host/base/xmalloc.h"
#include "host/commands/day.h"

/* ---- the keyboard ---- */

bool day_ask(const char *question, char *line, size_t size)
{
    bool whole;
    do {
        printf("%s", question);
        fflush(stdout);
        if (!fgets(line, (int)size, stdin))
            return false;
        whole = strchr(line, '\n') || feof(stdin);
        for (int c = 0; !whole && c != '\n' && c != EOF;)
            c = getchar();
        if (!whole)
            printf("input too long: give at most %zu characters\n", size - 2);
    } while (!whole);
    size_t from = strspn(line, " \t\r\n"), length = strlen(line);
    while (length > from && strchr(" \t\r\n", line[length - 1]))
        length--;
    line[length] = '\0';
    memmove(line, line + from, length - from + 1);
    return strcmp(line, "q") != 0;
}

void day_print_error(struct error *error)
{
    if (error->status != MR_OK)
        cli_fail(error);
    *error = (struct error){0};
}

/* ---- commands ---- */

void day_add_word(struct command_line *line, const char *word)
{
    if (line->count + 1 < DAY_WORDS_MAX)
        line->words[line->count++] = word;
}

void day_add_option(struct command_line *line, const char *option, const char *value)
{
    if (value && value[0]) {
        day_add_word(line, option);
        day_add_word(line, value);
    }
}

struct command_line day_make_command_line(const char *command, const char *word)
{
    static char program[4096];
    data_dir_program_path(program, sizeof program);
    return (struct command_line){.words = {program, command, word}, .count = word ? 3 : 2};
}

char *day_format_command_line(const struct command_line *line)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                "0123456789_@%+=:,./-";
    char *text;
    size_t length;
    FILE *file = xopen_memstream(&text, &length);
    fputs("matrig", file);
    for (size_t i = 1; i < line->count; i++) {
        const char *word = line->words[i];
        fputc(' ', file);
        if (word[0] && strspn(word, plain) == strlen(word))
            fputs(word, file);
        else
            shell_quote(file, word);
    }
    fclose(file);
    return text;
}

static void ignore_signal(int number)
{
    (void)number;
}

bool day_run_command_line(const struct command_line *line, struct error *error)
{
    static const int streams[3] = {-1, -1, -1};
    /* Use a handler instead of SIG_IGN, which the command would inherit. */
    const struct sigaction action = {.sa_handler = ignore_signal, .sa_flags = SA_RESTART};
    struct sigaction was;
    char *text = day_format_command_line(line);
    pid_t child;
    int status = 0;
    printf("$ %s\n", text);
    fflush(stdout);
    free(text);
    sigaction(SIGINT, &action, &was);
    if (process_start(line->words, streams, &child, error) == MR_OK) {
        while (waitpid(child, &status, 0) < 0 && errno == EINTR)
            ;
    } else {
        status = -1;
    }
    sigaction(SIGINT, &was, NULL);
    if (WIFEXITED(status) && WEXITSTATUS(status) > 1)
        printf("the command failed (exit %d); its message is above\n", WEXITSTATUS(status));
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}
