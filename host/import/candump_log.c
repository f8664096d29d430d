#include "host/import/candump_log.h"

#include <string.h>

void candump_log_start(struct candump_log *log, const char *text, size_t length,
                       const char *interface)
{
    *log = (struct candump_log){.text = text,
                                .end = text + length,
                                .at = text,
                                .interface = interface,
                                .interface_length = interface ? strlen(interface) : 0};
}

/* What to call it: CAN FD has its own mark. */
static const char *reason(const char *text, size_t length)
{
    return memmem(text, length, "##", 2) ? "a CAN FD frame; matrig's bus has none"
                                         : "no line of `candump -L`";
}

static bool here(const struct candump_log *log, const struct candump_line *line)
{
    return !log->interface || (line->interface_length == log->interface_length &&
                               memcmp(line->interface, log->interface, log->interface_length) == 0);
}

bool candump_log_next(struct candump_log *log, struct candump_line *line)
{
    while (log->at < log->end) {
        const char *text = log->at;
        const char *newline = memchr(text, '\n', (size_t)(log->end - text));
        size_t length = (size_t)((newline ? newline : log->end) - text);
        log->at = newline ? newline + 1 : log->end;
        log->line++;
        if (length == 0)
            continue;
        enum mr_status status = candump_parse_line(text, length, line);
        if (!newline) { /* a whole frame may be the beginning of a longer one */
            verdict_set(&log->verdict, MR_TRUNCATED, log->line, length + 1,
                        "the log ends inside a line");
            return false;
        }
        if (status != MR_OK) {
            log->verdict.bad_lines++;
            verdict_set(&log->verdict, MR_MALFORMED, log->line, line->column, reason(text, length));
            continue;
        }
        if (here(log, line))
            return true;
        log->elsewhere++;
    }
    return false;
}
