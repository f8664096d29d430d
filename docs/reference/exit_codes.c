#include <ctype.h>
#include <stdbool.h>
#include <string.h>

#include "common/status.h"
#include "docs/reference/reference.h"

#define EXIT_CODE_MAX 5

struct status {
    const char *name, *text;
    int value, exit_code;
};

/* The kind is the name in small letters, as programs read it. */
static void write_status(FILE *out, const struct status *status, bool is_first)
{
    fputs("| ", out);
    if (is_first)
        fprintf(out, "%d ", status->exit_code);
    fputs("| `", out);
    for (const char *c = status->name + strlen("MR_"); *c; c++)
        fputc(*c == '_' ? '-' : tolower((unsigned char)*c), out);
    fprintf(out, "` | %d | %s |\n", status->value, status->text);
}

void reference_exit_codes(FILE *out)
{
    static const struct status statuses[] = {
#define ROW(name, value, exit_code, text) {#name, text, value, exit_code},
        MR_STATUS_TABLE(ROW)
#undef ROW
    };
    reference_head(out, "Exit codes", "the table of statuses in `common/status.h`");
    fputs("The exit code of a `matrig` command shows the result; the kind of an error shows the "
          "reason. An error is one line on standard error, with cause and remedy. With "
          "`--json`, the object on standard output also contains `error` (the line), `kind` and "
          "`exit` (the exit code). Messages of the board contain the status code.\n\n"
          "| Exit code | Kind | Status code | Meaning |\n|--:|---|--:|---|\n",
          out);
    for (int code = 0; code <= EXIT_CODE_MAX; code++) {
        bool is_first = true;
        for (size_t i = 0; i < sizeof statuses / sizeof statuses[0]; i++) {
            if (statuses[i].exit_code != code)
                continue;
            write_status(out, &statuses[i], is_first);
            is_first = false;
        }
    }
}
