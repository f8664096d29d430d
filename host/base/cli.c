#include "host/base/cli.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "common/decimal.h"

int cli_fail(const struct error *error)
{
    bool colour = cli_colour();
    fprintf(stderr, "%smatrig:%s %s\n", colour ? "\033[31m" : "", colour ? "\033[0m" : "",
            error->text);
    return mr_status_exit_code(error->status);
}

enum mr_status cli_number(const char *text, const char *what, double low, double high,
                          double *value, struct error *error)
{
    const char *end;
    double number = mr_decimal_read(text, &end);
    if (end == text || *end != '\0' || !isfinite(number))
        return error_set(error, MR_USAGE, "not a number: '%s' for %s; write digits such as %g",
                         text, what, low > 1.0 ? low : 1.0);
    if (number < low || number > high)
        return error_set(error, MR_USAGE, "out of range: %s for %s; allowed is %g to %g", text,
                         what, low, high);
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

unsigned cli_columns(void)
{
    struct winsize size = {0};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
        return 100;
    return size.ws_col;
}

int cli_fail_output(void)
{
    fputs("matrig: cannot write the result: standard output; check where it goes\n", stderr);
    return mr_status_exit_code(MR_IO);
}

int cli_print_json(json_t *object, int exit_code)
{
    int failed = json_dumpf(object, stdout, JSON_COMPACT | JSON_REAL_PRECISION(15));
    json_decref(object);
    if (failed || putchar('\n') == EOF || fflush(stdout) != 0)
        return cli_fail_output();
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
