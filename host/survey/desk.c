#include "host/survey/desk.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#define AGAIN_IN   0.015  /* three reading errors: a repeated reading is the same */
#define READING_IN 2000.0 /* nobody has a longer caliper or runway */

static const char *skip_space(const char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    return text;
}

static bool is_end(const char *text)
{
    return *skip_space(text) == '\0';
}

/* Some calipers type a comma for the point. */
static bool parse_number(const char *text, bool si, double *value_in, struct quantity_wrong *wrong)
{
    char line[80];
    size_t digits = strspn(text, "+-.,0123456789"); /* no caliper writes powers of ten */
    if (strlen(text) >= sizeof line || digits == 0 || toupper((unsigned char)text[digits]) == 'E')
        return false;
    memcpy(line, text, strlen(text) + 1);
    char *comma = strchr(line, ',');
    if (comma)
        *comma = '.';
    return quantity_parse(line, "in", si ? "mm" : "in", value_in, wrong) &&
           fabs(*value_in) <= READING_IN;
}

void survey_entry_parse(const char *line, bool si, struct survey_entry *entry)
{
    static const struct {
        char letter;
        enum survey_word word;
    } words[] = {{'s', SURVEY_SKIP},    {'u', SURVEY_UNDO}, {'b', SURVEY_BACK},
                 {'f', SURVEY_FORWARD}, {'q', SURVEY_QUIT}, {'?', SURVEY_HELP}};
    const char *text = skip_space(line);
    *entry = (struct survey_entry){.word = SURVEY_NONSENSE, .value_in = (double)NAN};
    if (*text == '\0')
        entry->word = SURVEY_NOTHING;
    else if (parse_number(text, si, &entry->value_in, &entry->wrong))
        entry->word = SURVEY_NUMBER;
    else if (*text == 'n' && isspace((unsigned char)text[1]) && !is_end(text + 1)) {
        entry->word = SURVEY_NOTE;
        entry->note = skip_space(text + 1);
    }
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (*text == words[i].letter && is_end(text + 1))
            entry->word = words[i].word;
    }
}

void survey_desk_init(struct survey_desk *desk, enum survey_pattern pattern,
                      enum survey_edges edges)
{
    memset(desk, 0, sizeof *desk);
    survey_plan_make(&desk->plan, pattern, edges);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        desk->value_in[i] = desk->previous_in[i] = (double)NAN;
}

static void forget(struct survey_desk *desk, size_t item)
{
    size_t kept = 0;
    for (size_t i = 0; i < desk->lasts; i++) {
        if (desk->last[i] != item)
            desk->last[kept++] = desk->last[i];
    }
    desk->lasts = kept;
}

void survey_desk_restore(struct survey_desk *desk, size_t item, double value_in, bool skipped)
{
    forget(desk, item);
    desk->value_in[item] = value_in;
    desk->skipped[item] = skipped;
    if (!isnan(value_in) || skipped)
        desk->last[desk->lasts++] = item;
}

void survey_desk_next(struct survey_desk *desk, size_t from)
{
    size_t count = desk->plan.count;
    desk->doubted = false;
    for (size_t step = 0; step < count; step++) {
        size_t item = (from + step) % count;
        if (isnan(desk->value_in[item]) && !desk->skipped[item]) {
            desk->at = item;
            return;
        }
    }
    desk->at = count;
}

double survey_desk_expected_in(const struct survey_desk *desk, size_t item)
{
    return isnan(desk->previous_in[item]) ? survey_item_nominal_in(&desk->plan.item[item])
                                          : desk->previous_in[item];
}

static enum survey_outcome take_number(struct survey_desk *desk, double value_in, size_t *item)
{
    size_t at = desk->at;
    if (at == desk->plan.count)
        return SURVEY_REFUSED;
    double expected_in = survey_desk_expected_in(desk, at);
    /* false: nothing to expect */
    bool beyond = fabs(value_in - expected_in) > survey_item_limit_in(&desk->plan.item[at]) + 1e-9;
    bool again = desk->doubted && fabs(value_in - desk->doubted_in) <= AGAIN_IN;
    *item = at;
    if (beyond && !again) {
        desk->doubted = true;
        desk->doubted_in = value_in;
        return SURVEY_DOUBTED;
    }
    survey_desk_restore(desk, at, value_in, false);
    survey_desk_next(desk, at);
    return beyond ? SURVEY_CONFIRMED : SURVEY_KEPT;
}

static enum survey_outcome undo(struct survey_desk *desk, size_t *item)
{
    if (desk->doubted) { /* the doubtful one is not kept: forget it */
        desk->doubted = false;
        return SURVEY_MOVED;
    }
    if (desk->lasts == 0)
        return SURVEY_REFUSED;
    *item = desk->last[desk->lasts - 1];
    survey_desk_restore(desk, *item, (double)NAN, false);
    desk->at = *item;
    return SURVEY_UNDONE;
}

enum survey_outcome survey_desk_take(struct survey_desk *desk, const struct survey_entry *entry,
                                     size_t *item)
{
    *item = desk->at;
    switch (entry->word) {
    case SURVEY_NUMBER: return take_number(desk, entry->value_in, item);
    case SURVEY_SKIP:
        if (desk->at == desk->plan.count)
            return SURVEY_REFUSED;
        survey_desk_restore(desk, desk->at, (double)NAN, true);
        survey_desk_next(desk, desk->at);
        return SURVEY_SKIPPED;
    case SURVEY_UNDO: return undo(desk, item);
    case SURVEY_BACK:
        if (desk->at == 0)
            return SURVEY_REFUSED;
        desk->at--;
        desk->doubted = false;
        return SURVEY_MOVED;
    case SURVEY_FORWARD:
        if (desk->at + 1 >= desk->plan.count)
            return SURVEY_REFUSED;
        desk->at++;
        desk->doubted = false;
        return SURVEY_MOVED;
    case SURVEY_NOTE:
        if (desk->lasts == 0)
            return SURVEY_REFUSED;
        *item = desk->last[desk->lasts - 1];
        return SURVEY_NOTED;
    default: return SURVEY_REFUSED;
    }
}

size_t survey_desk_read(const struct survey_desk *desk)
{
    size_t read = 0;
    for (size_t i = 0; i < desk->plan.count; i++)
        read += isnan(desk->value_in[i]) ? 0u : 1u;
    return read;
}
