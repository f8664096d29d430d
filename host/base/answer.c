#include "host/base/answer.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/answer_items.h"
#include "host/base/list.h"

#define DIGITS 6
#define WORDS  1200

struct answer *answer_new(bool si)
{
    struct answer *answer = calloc(1, sizeof *answer);
    if (answer)
        answer->si = si;
    return answer;
}

void answer_as_given(struct answer *answer)
{
    if (answer)
        answer->as_given = true;
}

void answer_free(struct answer *answer)
{
    if (!answer)
        return;
    for (size_t i = 0; i < answer->count; i++) {
        free(answer->item[i].name);
        free(answer->item[i].label);
        free(answer->item[i].words);
        free(answer->item[i].remark);
        json_decref(answer->item[i].json);
    }
    free(answer->item);
    free(answer);
}

bool answer_in_si(const struct answer *answer)
{
    return answer && answer->si;
}

static bool copy(char **to, const char *text)
{
    *to = text ? strdup(text) : NULL;
    return *to || !text;
}

/* Never NULL: a fact without room is refined in vain. */
static struct answer_item *add(struct answer *answer, enum answer_kind kind, const char *name,
                               const char *label)
{
    static struct answer_item beyond;
    struct answer_item *item = &beyond;
    if (answer && !answer->failed)
        answer->failed = !list_grow(&answer->item, answer->count, sizeof *answer->item);
    bool kept = answer && !answer->failed;
    if (kept)
        item = &answer->item[answer->count++];
    *item = (struct answer_item){.kind = kind, .fact.digits = DIGITS, .error = (double)NAN};
    if (kept && !(copy(&item->name, name) && copy(&item->label, label)))
        answer->failed = true;
    return item;
}

static void set_words(struct answer *answer, char **words, const char *format, va_list arguments)
{
    char text[WORDS];
    vsnprintf(text, sizeof text, format, arguments);
    if (answer && !answer->failed && !copy(words, text))
        answer->failed = true;
}

struct answer_fact *answer_value(struct answer *answer, const char *name, const char *label,
                                 enum unit_kind unit, double value, int decimals)
{
    struct answer_item *item = add(answer, ANSWER_VALUE, name, label);
    const struct unit *shown = unit_of(unit, answer && answer->si);
    item->unit = shown;
    item->value = value * shown->factor;
    item->json_unit = answer && answer->as_given ? unit_given(unit) : shown;
    item->json_value = value * item->json_unit->factor;
    item->decimals = decimals;
    if (decimals >= 0)
        item->decimals = unit_decimals(unit, answer && answer->si, decimals);
    return &item->fact;
}

struct answer_fact *answer_estimate(struct answer *answer, const char *name, const char *label,
                                    enum unit_kind unit, double value, double error, int decimals)
{
    struct answer_fact *fact = answer_value(answer, name, label, unit, value, decimals);
    struct answer_item *item = (struct answer_item *)fact; /* its first member */
    item->kind = ANSWER_ESTIMATE;
    item->error = error * item->unit->factor;
    item->json_error = error * item->json_unit->factor;
    return fact;
}

struct answer_fact *answer_count(struct answer *answer, const char *name, const char *label,
                                 int64_t count)
{
    struct answer_item *item = add(answer, ANSWER_COUNT, name, label);
    item->count = count;
    return &item->fact;
}

void answer_flag(struct answer *answer, const char *name, const char *label, bool yes)
{
    add(answer, ANSWER_FLAG, name, label)->count = yes;
}

struct answer_fact *answer_words(struct answer *answer, const char *name, const char *label,
                                 const char *format, ...)
{
    struct answer_item *item = add(answer, ANSWER_WORDS, name, label);
    va_list arguments;
    va_start(arguments, format);
    set_words(answer, &item->words, format, arguments);
    va_end(arguments);
    return &item->fact;
}

void answer_sentence(struct answer *answer, const char *name, const char *format, ...)
{
    struct answer_item *item = add(answer, ANSWER_SENTENCE, name, "");
    va_list arguments;
    va_start(arguments, format);
    set_words(answer, &item->words, format, arguments);
    va_end(arguments);
}

void answer_remark(struct answer *answer, const char *format, ...)
{
    va_list arguments;
    if (!answer || answer->failed || answer->count == 0)
        return;
    va_start(arguments, format);
    set_words(answer, &answer->item[answer->count - 1].remark, format, arguments);
    va_end(arguments);
}

void answer_none(struct answer *answer, const char *name, const char *label, const char *why)
{
    struct answer_item *item = add(answer, ANSWER_NONE, name, label);
    if (answer && !answer->failed && !copy(&item->words, why))
        answer->failed = true;
}

void answer_words_or_none(struct answer *answer, const char *name, const char *label,
                          const char *text, const char *why)
{
    if (text && text[0])
        answer_words(answer, name, label, "%s", text);
    else
        answer_none(answer, name, label, why);
}

void answer_json_value(struct answer *answer, const char *name, json_t *json)
{
    if (answer && !json)
        answer->failed = true;
    struct answer_item *item = add(answer, ANSWER_JSON, name, NULL);
    if (answer && !answer->failed)
        item->json = json;
    else
        json_decref(json);
}

static void open_group(struct answer *answer, enum answer_kind kind, const char *name,
                       const char *label)
{
    add(answer, kind, name, label);
    if (answer)
        answer->rows &= ~(1ull << ++answer->depth);
}

static void close_group(struct answer *answer)
{
    add(answer, ANSWER_CLOSE, NULL, NULL);
    if (answer)
        answer->depth--;
}

void answer_open(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_OPEN, name, label);
}

void answer_list(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_LIST, name, label);
}

void answer_table(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_TABLE, name, label);
}

/* What is open: a row, of the group around it. */
static bool in_row(const struct answer *answer)
{
    return answer && answer->depth > 0 && answer->rows >> (answer->depth - 1) & 1u;
}

void answer_row(struct answer *answer)
{
    if (in_row(answer))
        close_group(answer);
    if (answer)
        answer->rows |= 1ull << answer->depth;
    open_group(answer, ANSWER_OPEN, NULL, NULL);
}

void answer_close(struct answer *answer)
{
    if (in_row(answer))
        close_group(answer);
    close_group(answer);
}

size_t answer_after(const struct answer *answer, size_t i)
{
    size_t depth = 0;
    do {
        depth += answer_is_group(answer->item[i].kind);
        depth -= depth > 0 && answer->item[i].kind == ANSWER_CLOSE;
        i++;
    } while (depth > 0 && i < answer->count);
    return i;
}

json_t *answer_into_json(struct answer *answer)
{
    json_t *json = answer_json(answer);
    answer_free(answer);
    return json;
}

int answer_show(const struct cli *cli, struct answer *answer, int code)
{
    if (cli->json) {
        json_t *json = answer_into_json(answer);
        return json ? cli_print_json(json, code) : cli_fail_output();
    }
    bool shown = answer_text(answer, stdout) && fflush(stdout) == 0;
    answer_free(answer);
    return shown ? code : cli_fail_output();
}

int answer_end(const struct cli *cli, struct answer *answer, int code, const struct error *error)
{
    if (error->status == MR_OK)
        return answer_show(cli, answer, code);
    answer_free(answer);
    return cli_fail(error);
}
