#include "host/cli.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int cli_fail(const struct error *error)
{
    bool colour = cli_colour();
    fprintf(stderr, "%smatrig:%s %s\n", colour ? "\033[31m" : "", colour ? "\033[0m" : "", error->text);
    return mr_status_exit_code(error->status);
}

static const struct cli_option *find_option(const struct cli_option *options, size_t count, const char *word,
                                            const char **attached)
{
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    *attached = equals ? equals + 1 : NULL;
    for (size_t i = 0; i < count; i++) {
        if (strlen(options[i].name) == length && strncmp(options[i].name, word, length) == 0)
            return &options[i];
    }
    /* -j4 and -oFILE, as make and cc take them */
    for (size_t i = 0; i < count && word[0] == '-' && word[1] != '-' && word[1] && word[2]; i++) {
        if (options[i].name[1] == word[1] && !options[i].name[2] && !options[i].flag) {
            *attached = word + 2;
            return &options[i];
        }
    }
    return NULL;
}

static enum mr_status unknown_option(const char *command, const char *word, struct error *error)
{
    static const char *const global[] = {"--json", "--quiet", "--si"};
    for (size_t i = 0; i < sizeof global / sizeof global[0]; i++) {
        if (strcmp(word, global[i]) == 0)
            return error_set(
                error, MR_USAGE,
                "option in the wrong place: '%s' after %s; put it before the command: matrig %s %s", word,
                command, word, command);
    }
    return error_set(error, MR_USAGE, "unknown option: '%s' of %s; see matrig %s --help", word, command,
                     command);
}

enum mr_status cli_parse(int argc, char **argv, const struct cli_option *options, size_t option_count,
                         const char **words, size_t least, size_t most, const char *names,
                         struct error *error)
{
    size_t count = 0;
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i];
        if (word[0] != '-' || word[1] == '\0') {
            if (count == most)
                return error_set(error, MR_USAGE, "one word too many: '%s' of %s; see matrig %s --help", word,
                                 argv[0], argv[0]);
            words[count++] = word;
            continue;
        }
        const char *attached;
        const struct cli_option *option = find_option(options, option_count, word, &attached);
        if (!option)
            return unknown_option(argv[0], word, error);
        if (option->flag) {
            if (attached)
                return error_set(error, MR_USAGE, "option takes no value: '%s' of %s; leave the value out",
                                 word, argv[0]);
            *option->flag = true;
            continue;
        }
        if (*option->value)
            return error_set(error, MR_USAGE, "option given twice: %s of %s; give it once", option->name,
                             argv[0]);
        if (!attached && i + 1 == argc)
            return error_set(error, MR_USAGE, "option without its value: %s of %s; see matrig %s --help",
                             option->name, argv[0], argv[0]);
        *option->value = attached ? attached : argv[++i];
    }
    if (count < least)
        return error_set(error, MR_USAGE, "something is missing: matrig %s needs %s; see matrig %s --help",
                         argv[0], names, argv[0]);
    return MR_OK;
}

enum mr_status cli_number(const char *text, const char *what, double low, double high, double *value,
                          struct error *error)
{
    char *end;
    double number = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(number))
        return error_set(error, MR_USAGE, "not a number: '%s' for %s; write digits such as %g", text, what,
                         low > 1.0 ? low : 1.0);
    if (number < low || number > high)
        return error_set(error, MR_USAGE, "out of range: %s for %s; allowed is %g to %g", text, what, low,
                         high);
    *value = number;
    return MR_OK;
}

void cli_note(const struct cli *cli, const char *format, ...)
{
    if (cli->quiet)
        return;
    va_list arguments;
    va_start(arguments, format);
    fputs("matrig: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

bool cli_terminal(void)
{
    const char *terminal = getenv("TERM");
    return isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;
}

bool cli_colour(void)
{
    const char *no_colour = getenv("NO_COLOR");
    return cli_terminal() && !(no_colour && no_colour[0]);
}

int cli_print_json(json_t *object, int exit_code)
{
    int failed = json_dumpf(object, stdout, JSON_COMPACT | JSON_REAL_PRECISION(15));
    json_decref(object);
    if (failed || putchar('\n') == EOF || fflush(stdout) != 0) {
        fputs("matrig: cannot write the result: standard output; check where it goes\n", stderr);
        return mr_status_exit_code(MR_IO);
    }
    return exit_code;
}

json_t *cli_json_number(double value, int digits)
{
    char text[40];
    if (!isfinite(value))
        return json_null();
    snprintf(text, sizeof text, "%.*g", digits, value);
    return json_real(strtod(text, NULL));
}
