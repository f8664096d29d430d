#include "host/board/bringup_judge.h"

#include <math.h>
#include <string.h>

enum { REPORT = 1, MEMORY = 2, BROWN_OUT = 4, EITHER = REPORT | MEMORY, ALL = 7 };

#define OK            BRINGUP_OK
#define LOOK          BRINGUP_LOOK
#define WRONG         BRINGUP_WRONG
#define SAME          BRINGUP_SAME, 0.0
#define ANY           BRINGUP_ANY, 0.0
#define PLUS(value)   BRINGUP_PLUS, value
#define PERCENT(part) BRINGUP_PERCENT, part

#define LIMIT(section, name, least, most, beyond, none, tolerance, source, advice)
#define WORD(section, name, words, beyond, none, source, advice)
#define OF_BOARD(section, name, fact, beyond, none, source, advice) \
    static double fact##_of(const struct mr_board *board)           \
    {                                                               \
        return board ? (double)board->fact : (double)NAN;           \
    }
#include "host/board/bringup_limits.def"

static const struct bringup_limit limits[] = {
#define LIMIT(section, name, least, most, beyond, none, tolerance, source, advice) \
    {section, name, NULL, least, most, NULL, beyond, none, tolerance, source, advice},
#define WORD(section, name, words, beyond, none, source, advice) \
    {section, name, words, 0.0, 0.0, NULL, beyond, none, SAME, source, advice},
#define OF_BOARD(section, name, fact, beyond, none, source, advice) \
    {section, name, NULL, 0.0, 0.0, fact##_of, beyond, none, SAME, source, advice},
#include "host/board/bringup_limits.def"
};
#define LIMITS (sizeof limits / sizeof limits[0])

static unsigned section_bit(const char *section)
{
    return strcmp(section, "report") == 0 ? REPORT
         : strcmp(section, "memory") == 0 ? MEMORY
                                          : BROWN_OUT;
}

bool bringup_limit_is_group(const struct bringup_limit *limit)
{
    return limit->name[strlen(limit->name) - 1u] == '*';
}

static bool fits(const struct bringup_limit *limit, const char *name)
{
    return bringup_limit_is_group(limit) ? strncmp(limit->name, name, strlen(limit->name) - 1u) == 0
                                         : strcmp(limit->name, name) == 0;
}

/* `none`: of a whole group, too: `noise none` stands for all of noise_... */
static const struct bringup_limit *limit_of(unsigned section, const struct bringup_line *line)
{
    for (size_t i = 0; i < LIMITS; i++) {
        if (limits[i].sections & section &&
            (fits(&limits[i], line->name) ||
             (line->none && strncmp(limits[i].name, line->name, strlen(line->name)) == 0)))
            return &limits[i];
    }
    return NULL;
}

/* One of the words, which stand with blanks between them. */
static bool is_among(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = strstr(words, word); at; at = strstr(at + 1, word)) {
        if ((at == words || at[-1] == ' ') && (at[length] == 0 || at[length] == ' '))
            return true;
    }
    return false;
}

static bool is_within(const struct bringup_judged *j)
{
    const char *words = j->limit->words;
    if (words)
        return !*words || is_among(words, j->line->value);
    return j->line->number >= j->least && j->line->number <= j->most;
}

static bool has_moved(const struct bringup_limit *limit, const struct bringup_line *now,
                      const struct bringup_line *last)
{
    if (limit->tolerance == BRINGUP_ANY)
        return false;
    if (limit->tolerance == BRINGUP_SAME || isnan(now->number) || isnan(last->number))
        return strcmp(now->value, last->value) != 0;
    double may = limit->tolerance == BRINGUP_PLUS ? limit->change
                                                  : limit->change / 100.0 * fabs(last->number);
    return fabs(now->number - last->number) > may;
}

static const struct mr_board *board_of(const struct bringup *now)
{
    const struct bringup_line *line = bringup_find(now, "board");
    int number = line ? mr_board_named(line->value) : -1;
    return number < 0 ? NULL : mr_board_of((unsigned)number);
}

static void judge(struct bringup_judged *j, const struct mr_board *board)
{
    const struct bringup_limit *limit = j->limit;
    if (limit) {
        j->least = limit->of_board ? limit->of_board(board) : limit->least;
        j->most = limit->of_board ? j->least : limit->most;
    }
    j->verdict = !j->limit     ? BRINGUP_LOOK
               : j->line->none ? j->limit->none
               : is_within(j)  ? BRINGUP_OK
                               : j->limit->beyond;
    j->moved = j->limit && j->last && has_moved(j->limit, j->line, j->last);
    if (j->moved && j->verdict == BRINGUP_OK)
        j->verdict = BRINGUP_LOOK;
}

static bool is_said(const struct bringup *now, unsigned section, const struct bringup_limit *limit)
{
    for (size_t i = 0; i < now->lines; i++) {
        if (limit_of(section, &now->line[i]) == limit)
            return true;
    }
    return false;
}

size_t bringup_judge(const struct bringup *now, const struct bringup *last,
                     struct bringup_judged judged[BRINGUP_JUDGED])
{
    unsigned section = section_bit(now->section);
    const struct mr_board *board = board_of(now);
    size_t count = 0;
    for (size_t i = 0; i < now->lines; i++) {
        struct bringup_judged *j = &judged[count++];
        *j = (struct bringup_judged){.name = now->line[i].name,
                                     .line = &now->line[i],
                                     .limit = limit_of(section, &now->line[i]),
                                     .last = last ? bringup_find(last, now->line[i].name) : NULL};
        judge(j, board);
    }
    for (size_t i = 0; i < LIMITS; i++) {
        const struct bringup_limit *limit = &limits[i];
        if (!(limit->sections & section) || limit->none == BRINGUP_OK ||
            is_said(now, section, limit))
            continue;
        judged[count++] =
            (struct bringup_judged){.name = limit->name, .limit = limit, .verdict = limit->none};
    }
    return count;
}

enum bringup_verdict bringup_worst(const struct bringup_judged *judged, size_t count)
{
    enum bringup_verdict worst = BRINGUP_OK;
    for (size_t i = 0; i < count; i++)
        worst = judged[i].verdict > worst ? judged[i].verdict : worst;
    return worst;
}

const char *bringup_verdict_text(enum bringup_verdict verdict)
{
    static const char *const text[] = {"ok", "look", "wrong"};
    return text[verdict];
}
