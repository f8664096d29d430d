#include "host/survey/plan.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/units.h"

static const char *const kinds[] = {"gap", "station", "across", "diagonal"};
static const char *const patterns[] = {"standard", "diagonal"};
static const char *const edge_words[] = {"left", "both", "none"};

static void add(struct survey_plan *plan, enum survey_kind kind, unsigned line, unsigned place)
{
    plan->item[plan->count++] = (struct survey_item){kind, line, place};
}

static bool has_stations(enum survey_pattern pattern, enum survey_edges edges, unsigned line)
{
    if (pattern == SURVEY_PATTERN_DIAGONAL)
        return true;
    return (line == 1 && edges != SURVEY_EDGE_NONE) ||
           (line == SURVEY_LINES && edges == SURVEY_EDGE_BOTH);
}

static void add_station(struct survey_plan *plan, enum survey_edges edges, unsigned line,
                        unsigned station)
{
    if (!has_stations(plan->pattern, edges, line))
        return;
    add(plan, SURVEY_STATION, line, station);
    if (plan->pattern == SURVEY_PATTERN_DIAGONAL)
        add(plan, SURVEY_ACROSS, line, station);
}

/* Downfield: each station before the span that begins behind it. */
static void walk_down(struct survey_plan *plan, enum survey_edges edges, unsigned line)
{
    unsigned station = 0;
    for (unsigned span = 0; span < SURVEY_SPANS; span++) {
        double begins_ft = survey_item_ft(&(struct survey_item){SURVEY_GAP, line, span});
        while (station < SURVEY_STATIONS && SURVEY_STATION_FT * station <= begins_ft + 1e-6)
            add_station(plan, edges, line, station++);
        add(plan, SURVEY_GAP, line, span);
    }
    while (station < SURVEY_STATIONS)
        add_station(plan, edges, line, station++);
}

void survey_plan_make(struct survey_plan *plan, enum survey_pattern pattern,
                      enum survey_edges edges)
{
    plan->pattern = pattern;
    plan->count = 0;
    for (unsigned line = 1; line <= SURVEY_LINES; line++) {
        size_t first = plan->count;
        walk_down(plan, edges, line);
        for (size_t i = first, j = plan->count; line % 2 == 0 && i + 1 < j; i++) { /* back up */
            struct survey_item item = plan->item[i];
            plan->item[i] = plan->item[--j];
            plan->item[j] = item;
        }
    }
    for (unsigned line = 1; pattern == SURVEY_PATTERN_DIAGONAL && line <= SURVEY_DIAGONALS;
         line++) {
        for (unsigned i = 0; i < SURVEY_DIAGONAL_SPANS; i++)
            add(plan, SURVEY_DIAGONAL, line, line % 2 ? i : SURVEY_DIAGONAL_SPANS - 1u - i);
    }
}

int survey_plan_find(const struct survey_plan *plan, const struct survey_item *item)
{
    for (size_t i = 0; i < plan->count; i++) {
        const struct survey_item *p = &plan->item[i];
        if (p->kind == item->kind && p->line == item->line && p->place == item->place)
            return (int)i;
    }
    return -1;
}

static bool find_word(const char *const *words, unsigned count, const char *text, unsigned *found)
{
    for (*found = 0; *found < count; ++*found) {
        if (strcmp(words[*found], text) == 0)
            return true;
    }
    return false;
}

const char *survey_kind_text(enum survey_kind kind)
{
    return (unsigned)kind < SURVEY_KINDS ? kinds[kind] : "unknown";
}

const char *survey_pattern_text(enum survey_pattern pattern)
{
    return patterns[pattern == SURVEY_PATTERN_DIAGONAL];
}

const char *survey_edges_text(enum survey_edges edges)
{
    return (unsigned)edges < 3 ? edge_words[edges] : "unknown";
}

bool survey_kind_parse(const char *text, enum survey_kind *kind)
{
    unsigned i;
    bool found = find_word(kinds, SURVEY_KINDS, text, &i);
    *kind = (enum survey_kind)i;
    return found;
}

bool survey_pattern_parse(const char *text, enum survey_pattern *pattern)
{
    unsigned i;
    bool found = find_word(patterns, 2, text, &i);
    *pattern = (enum survey_pattern)i;
    return found;
}

bool survey_edges_parse(const char *text, enum survey_edges *edges)
{
    unsigned i;
    bool found = find_word(edge_words, 3, text, &i);
    *edges = (enum survey_edges)i;
    return found;
}

double survey_line_in(unsigned line)
{
    static const double from_left_in[SURVEY_LINES] = {12.0, SURVEY_WIDTH_IN / 2 - 36.0,
                                                      SURVEY_WIDTH_IN / 2, SURVEY_WIDTH_IN - 12.0};
    return from_left_in[line - 1];
}

const char *survey_line_text(unsigned line)
{
    static const char *const text[SURVEY_LINES] = {
        "12 in from the left edge", "36 in left of the centreline", "near the centreline",
        "12 in from the right edge"};
    return line >= 1 && line <= SURVEY_LINES ? text[line - 1] : "unknown";
}

double survey_item_ft(const struct survey_item *item)
{
    switch (item->kind) {
    case SURVEY_GAP: return SURVEY_SPAN_FT * item->place;
    case SURVEY_STATION:
    case SURVEY_ACROSS: return SURVEY_STATION_FT * item->place;
    default: return (double)NAN;
    }
}

void survey_item_text(const struct survey_item *item, bool si, char *out, size_t size)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    double at = survey_item_ft(item) * station->factor;
    if (item->kind == SURVEY_GAP)
        snprintf(out, size, "line %u (%s), mats %u to %u, station %.1f %s", item->line,
                 survey_line_text(item->line), item->place * MR_MATS_PER_SEGMENT + 1,
                 (item->place + 1) * MR_MATS_PER_SEGMENT, at, station->text);
    else if (item->kind == SURVEY_DIAGONAL)
        snprintf(out, size, "45 degree line %u, span %u of %u from the left", item->line,
                 item->place + 1, SURVEY_DIAGONAL_SPANS);
    else
        snprintf(out, size, "%s %.1f %s, line %u (%s)",
                 item->kind == SURVEY_STATION ? "station" : "across at station", at, station->text,
                 item->line, survey_line_text(item->line));
}

double survey_item_nominal_in(const struct survey_item *item)
{
    return item->kind == SURVEY_GAP || item->kind == SURVEY_DIAGONAL ? SURVEY_SPACING_IN
                                                                     : (double)NAN;
}

double survey_item_limit_in(const struct survey_item *item)
{
    return item->kind == SURVEY_GAP || item->kind == SURVEY_DIAGONAL ? SURVEY_SPAN_CHANGE_IN
                                                                     : SURVEY_MOVE_IN;
}
