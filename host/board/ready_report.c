/* The checks that a readiness report holds. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "host/board/ready.h"

const char *ready_text(enum ready_verdict verdict)
{
    return verdict == READY_GO ? "GO" : verdict == READY_NO_GO ? "NO-GO" : "not done";
}

struct ready_check *ready_add(struct ready_report *report, enum ready_verdict verdict,
                              const char *name, const char *format, ...)
{
    static struct ready_check beyond;
    struct ready_check *check = report->count < READY_CHECKS ? &report->check[report->count++]
                                                             : &beyond;
    va_list arguments;
    memset(check, 0, sizeof *check);
    check->verdict = verdict;
    snprintf(check->name, sizeof check->name, "%s", name);
    va_start(arguments, format);
    vsnprintf(check->value, sizeof check->value, format, arguments);
    va_end(arguments);
    return check;
}

enum ready_verdict ready_verdict(const struct ready_report *report)
{
    return ready_count(report, READY_NO_GO) || report->count == 0 ? READY_NO_GO : READY_GO;
}

unsigned ready_count(const struct ready_report *report, enum ready_verdict verdict)
{
    unsigned count = 0;
    for (unsigned i = 0; i < report->count; i++)
        count += report->check[i].verdict == verdict;
    return count;
}

json_t *ready_json(const struct ready_report *report)
{
    json_t *checks = json_array();
    for (unsigned i = 0; i < report->count; i++) {
        const struct ready_check *c = &report->check[i];
        json_array_append_new(checks, json_pack("{ssssssssss}", "name", c->name, "verdict",
                                                ready_text(c->verdict), "value", c->value, "limit",
                                                c->limit, "advice", c->advice));
    }
    return checks;
}
