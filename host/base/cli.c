#include "host/base/cli.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/decimal.h"
#include "host/base/xmalloc.h"

#define STACK_BYTES (768u * 1024u)
/* Bytes of stack reserved for arguments, environment and the calls so far. */
#define STACK_LIMIT (1024u * 1024u)
#define PAGE_BYTES  4096u

/* --json was given; a JSON object was printed */
static bool json_requested, json_printed;
static struct error first_error;

/* Returns the text as a JSON string. If the text is not UTF-8 (a file name may not be), each
 * non-ASCII byte is replaced by '?'. */
static json_t *text_to_json(const char *text)
{
    char ascii[sizeof((struct error *)0)->text];
    json_t *json = json_string(text);
    if (json)
        return json;
    snprintf(ascii, sizeof ascii, "%s", text);
    for (char *c = ascii; *c; c++) {
        if ((unsigned char)*c > 0x7e)
            *c = '?';
    }
    return json_string(ascii);
}

void cli_fill_termination_signals(sigset_t *set)
{
    struct sigaction hangup;
    sigemptyset(set);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGTERM);
    if (sigaction(SIGHUP, NULL, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
        sigaddset(set, SIGHUP);
}

__attribute__((noinline)) static void touch_stack_pages(void)
{
    volatile char stack[STACK_BYTES];
    for (size_t i = sizeof stack; i > 0; i -= PAGE_BYTES)
        stack[i - PAGE_BYTES] = 0;
}

/* Touches as much stack as the deepest command needs. If the stack could not grow later, the
 * program would end without a message; here it can report the lack of memory. */
static void reserve_stack(void)
{
    struct rlimit limit = {STACK_LIMIT, STACK_LIMIT};
    getrlimit(RLIMIT_STACK, &limit);
    if (limit.rlim_max < STACK_LIMIT)
        error_set(fatal, MR_FULL,
                  "stack too small: the limit is %llu kB, but matrig needs %u kB; run ulimit -s %u",
                  (unsigned long long)limit.rlim_max / 1024, STACK_LIMIT / 1024,
                  STACK_LIMIT / 1024);
    if (limit.rlim_cur < STACK_LIMIT) {
        limit.rlim_cur = STACK_LIMIT;
        setrlimit(RLIMIT_STACK, &limit);
    }
    free(xmalloc(STACK_LIMIT)); /* ends the program with a message if memory is insufficient */
    touch_stack_pages();
}

void cli_begin(const struct cli *cli)
{
    signal(SIGXFSZ, SIG_IGN);
    json_requested = cli->json;
    reserve_stack();
}

static bool is_stderr_coloured(void)
{
    const char *no_colour = getenv("NO_COLOR");
    return cli_is_stderr_terminal() && !(no_colour && no_colour[0]);
}

int cli_fail(const struct error *error)
{
    bool colour = is_stderr_coloured();
    fprintf(stderr, "%smatrig:%s %s\n", colour ? "\033[31m" : "", colour ? "\033[0m" : "",
            error->text);
    if (first_error.status == MR_OK)
        first_error = *error;
    return mr_status_exit_code(error->status);
}

/* Adds kind and exit code of the error to `object`, and the error text unless `object` has one. */
static void add_error(json_t *object)
{
    char kind[ERROR_KIND_SIZE];
    if (first_error.status == MR_OK)
        return;
    error_kind_text(first_error.status, kind);
    if (!json_is_string(json_object_get(object, "error")))
        json_object_set_new(object, "error", text_to_json(first_error.text));
    json_object_set_new(object, "kind", json_string(kind));
    json_object_set_new(object, "exit", json_integer(mr_status_exit_code(first_error.status)));
}

static void end_with_error(const struct error *error)
{
    exit(cli_end(cli_fail(error)));
}
struct error *const fatal = &(struct error){.end_program = end_with_error};

int cli_end(int exit_code)
{
    if (json_requested && !json_printed && first_error.status != MR_OK)
        return cli_print_json(json_object(), exit_code);
    return exit_code;
}

enum mr_status cli_parse_number(const char *text, const char *what, double low, double high,
                                double *value, struct error *error)
{
    const char *end;
    double number = mr_decimal_parse(text, &end);
    if (end == text || *end != '\0' || !isfinite(number))
        return error_set(error, MR_USAGE, "not a number: '%s' for %s; write digits such as %g",
                         text, what, low > 1.0 ? low : 1.0);
    if (number < low || number > high)
        return error_set(error, MR_USAGE, "out of range: %s for %s; allowed: %g to %g", text, what,
                         low, high);
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

bool cli_confirm(const char *format, ...)
{
    char line[80] = "";
    va_list arguments;
    if (!isatty(STDIN_FILENO) || !isatty(STDERR_FILENO))
        return true;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputs(" yes: ", stderr);
    return fgets(line, sizeof line, stdin) && strcmp(line, "yes\n") == 0;
}

bool cli_is_stderr_terminal(void)
{
    const char *terminal = getenv("TERM");
    return isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;
}

unsigned cli_terminal_columns(void)
{
    struct winsize size = {0};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
        return 100;
    return size.ws_col;
}

int cli_report_output_failure(void)
{
    fputs("matrig: cannot write the result to standard output; check the pipe, file or disk\n",
          stderr);
    return mr_status_exit_code(MR_IO);
}

int cli_print_json(json_t *object, int exit_code)
{
    json_printed = true;
    add_error(object);
    bool bad = json_dumpf(object, stdout, JSON_COMPACT | JSON_REAL_PRECISION(15)) != 0;
    json_decref(object);
    if (bad || putchar('\n') == EOF || fflush(stdout) != 0)
        return cli_report_output_failure();
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
