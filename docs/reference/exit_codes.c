#include <ctype.h>

#include "common/status.h"
#include "docs/reference/reference.h"

/* The kind is the name in small letters, as programs read it. */
static void row(FILE *out, const char *name, const char *text)
{
    fputs("| | `", out);
    for (const char *c = name + 3; *c; c++)
        fputc(*c == '_' ? '-' : tolower((unsigned char)*c), out);
    fprintf(out, "` | `%s` | %s |\n", name, text);
}

void reference_exit_codes(FILE *out)
{
    static const struct {
        const char *name, *text;
        int exit_code;
    } statuses[] = {
#define ROW(name, value, exit_code, text) {#name, text, exit_code},
        MR_STATUS_TABLE(ROW)
#undef ROW
    };
    static const char *const meanings[] = {"success",
                                           "a comparison failed or a limit was not met",
                                           "wrong usage",
                                           "input, output or a device failed",
                                           "malformed or truncated input",
                                           "numerical failure"};
    reference_head(out, "Exit codes", "the table of statuses in `common/status.h`");
    fputs(
        "Every `matrig` command ends with one of these codes. It prints an error as one line on "
        "standard error, with cause and remedy. With `--json`, the object on standard output also "
        "contains `error` (the line), `kind` (second column) and `exit` (the code).\n\n"
        "| Exit code | Kind | Status | Meaning |\n|--:|---|---|---|\n",
        out);
    for (int code = 0; code < (int)(sizeof meanings / sizeof meanings[0]); code++) {
        fprintf(out, "| **%d** | | | **%s** |\n", code, meanings[code]);
        for (size_t i = 0; i < sizeof statuses / sizeof statuses[0]; i++) {
            if (statuses[i].exit_code == code)
                row(out, statuses[i].name, statuses[i].text);
        }
    }
}
