/* The checks that a readiness report holds. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "host/base/wrap.h"
#include "host/board/ready.h"

const char *ready_text(enum ready_verdict verdict)
{
    static const char *const text[] = {
        [READY_GO] = "GO",
        [READY_NO_GO] = "NO-GO",
        [READY_NOT_DONE] = "not done",
        [READY_TOLD] = "told",
    };
    return text[verdict];
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

#define VALUES        29u /* the column in which what was found begins */
#define COLUMNS_LEAST 60u

static void print_check(const struct ready_check *c, unsigned columns, FILE *out)
{
    char text[sizeof c->value + sizeof c->limit + 8], head[VALUES + 20];
    snprintf(text, sizeof text, "%s%s%s%s", c->value, c->limit[0] ? "  [" : "", c->limit,
             c->limit[0] ? "]" : "");
    snprintf(head, sizeof head, "%-8s  %-17s ", ready_text(c->verdict), c->name);
    fputs(head, out);
    wrap_print(text, strlen(head), VALUES, columns, out);
    if (!c->advice[0])
        return;
    fprintf(out, "%*s->", (int)VALUES, "");
    wrap_print(c->advice, VALUES + 2, VALUES + 3, columns, out);
}

static void print_verdict(const struct ready_report *report, double took_s, unsigned columns,
                          FILE *out)
{
    unsigned no_go = ready_count(report, READY_NO_GO), open = ready_count(report, READY_NOT_DONE);
    unsigned checks = report->count - ready_count(report, READY_TOLD);
    char text[READY_CHECKS * 24 + 120];
    size_t used = (size_t)snprintf(text, sizeof text, "%s after %.1f s",
                                   ready_text(ready_verdict(report)), took_s);
    const char *before = ": ";
    for (unsigned i = 0; i < report->count && used < sizeof text; i++) {
        if (report->check[i].verdict != READY_NO_GO)
            continue;
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", before,
                                 report->check[i].name);
        before = ", ";
    }
    used += (size_t)snprintf(text + used, sizeof text - used, "%s%u of %u checks are go",
                             no_go ? "; " : ": ", checks - no_go - open, checks);
    if (open)
        snprintf(text + used, sizeof text - used, ", %u not done", open);
    wrap_print(text, 0, 0, columns, out);
}

void ready_print(const struct ready_report *report, double took_s, unsigned columns, FILE *out)
{
    columns = columns < COLUMNS_LEAST ? COLUMNS_LEAST : columns;
    for (unsigned i = 0; i < report->count; i++)
        print_check(&report->check[i], columns, out);
    print_verdict(report, took_s, columns, out);
}
