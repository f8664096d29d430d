/* An answer for people at a terminal. */
#include <math.h>
#include <string.h>

#include "host/base/answer_items.h"
#include "host/base/wrap.h"

#define WIDTH     100      /* of a terminal that people have */
#define LABEL     13       /* the least width of the labels of facts */
#define NORMAL_95 1.959964 /* half a 95 % interval of a normal distribution, in standard errors */

static int number(const struct answer_item *item, double value, bool plus, char *text, size_t size)
{
    if (!isfinite(value))
        return snprintf(text, size, "%s", isnan(value) ? "-" : value < 0 ? "-inf" : "inf");
    if (item->fact.bounded && value >= 999.5)
        return snprintf(text, size, ">999");
    if (item->decimals < 0)
        /* no -0 */
        return snprintf(text, size, plus ? "%+.*g" : "%.*g", -item->decimals, value + 0.0);
    return snprintf(text, size, plus ? "%+.*f" : "%.*f", item->decimals,
                    unit_tidy(value, pow(10.0, -item->decimals)));
}

void answer_cell(const struct answer_item *item, const char *plus_minus,
                 char text[static ANSWER_CELL])
{
    int length = 0;
    text[0] = '\0';
    switch (item->kind) {
    case ANSWER_VALUE:
    case ANSWER_ESTIMATE:
        length = number(item, item->value, item->fact.plus, text, ANSWER_CELL);
        break;
    case ANSWER_COUNT:
        if (item->count == ANSWER_UNKNOWN)
            snprintf(text, ANSWER_CELL, "-");
        else
            snprintf(text, ANSWER_CELL, "%lld", (long long)item->count);
        break;
    case ANSWER_FLAG: snprintf(text, ANSWER_CELL, "%s", item->count ? "yes" : "no"); break;
    default: snprintf(text, ANSWER_CELL, "%s", item->words ? item->words : "");
    }
    if (item->kind == ANSWER_ESTIMATE && isfinite(item->value) && !isnan(item->error)) {
        length += snprintf(text + length, (size_t)(ANSWER_CELL - length), "%s", plus_minus);
        number(item, item->error, false, text + length, (size_t)(ANSWER_CELL - length));
    }
}

void answer_line(const struct answer_item *item, const char *plus_minus,
                 char text[static ANSWER_CELL])
{
    const char *unit = item->unit && isfinite(item->value) ? item->unit->text : "";
    char interval[80] = "";
    answer_cell(item, plus_minus, text);
    if (item->fact.interval && isfinite(item->error))
        snprintf(interval, sizeof interval, " (95 %%: %.*f to %.*f)", item->decimals,
                 item->value - NORMAL_95 * item->error, item->decimals,
                 item->value + NORMAL_95 * item->error);
    size_t length = strlen(text);
    snprintf(text + length, ANSWER_CELL - length, "%s%s%s%s%s", unit[0] ? " " : "", unit, interval,
             item->fact.end ? item->fact.end : "", item->remark ? item->remark : "");
}

/* ---- tables ---- */

static bool is_cell(const struct answer_item *item)
{
    return !answer_is_group(item->kind) && item->label && item->label[0];
}

size_t answer_columns(const struct answer *answer, size_t table, size_t *column, size_t most)
{
    size_t count = 0, end = answer_after(answer, table);
    for (size_t row = table + 1; row + 1 < end; row = answer_after(answer, row)) {
        /* a new column stands after the one before it in its row */
        size_t place = 0, to = answer_after(answer, row);
        for (size_t i = row + 1; i < to; i++) {
            size_t c = 0;
            if (!is_cell(&answer->item[i]))
                continue;
            while (c < count && strcmp(answer->item[column[c]].label, answer->item[i].label) != 0)
                c++;
            if (c == count && count < most) {
                memmove(column + place + 1, column + place, (count++ - place) * sizeof *column);
                column[c = place] = i;
            } else if (c < count && !answer->item[column[c]].unit)
                column[c] = i; /* a row without the value has no unit */
            place = c + 1;
        }
    }
    return count;
}

const struct answer_item *answer_in_row(const struct answer *answer, size_t row, const char *label)
{
    size_t end = answer_after(answer, row);
    for (size_t i = row + 1; i < end; i++) {
        if (is_cell(&answer->item[i]) && (!label || strcmp(answer->item[i].label, label) == 0))
            return &answer->item[i];
    }
    return NULL;
}

/* Line `line` of a column's head: the parts of its label, then its unit. False: there is none. */
static bool head_line(const struct answer_item *column, size_t line, size_t lines,
                      char text[static ANSWER_CELL])
{
    const char *part = column->label;
    size_t parts = 1, unit = column->unit && column->unit->text[0];
    for (const char *at = part; (at = strchr(at, '|')); at++)
        parts++;
    text[0] = '\0';
    if (line + parts + unit < lines) /* heads end at the same line */
        return false;
    line -= lines - parts - unit;
    if (line >= parts)
        return snprintf(text, ANSWER_CELL, "%s", column->unit->text) > 0;
    for (; line > 0; line--)
        part = strchr(part, '|') + 1;
    snprintf(text, ANSWER_CELL, "%.*s", (int)strcspn(part, "|"), part);
    return true;
}

static size_t head_lines(const struct answer_item *column)
{
    size_t lines = column->unit && column->unit->text[0] ? 2 : 1;
    for (const char *at = column->label; (at = strchr(at, '|')); at++)
        lines++;
    return lines;
}

static size_t column_width(const struct answer *answer, size_t table,
                           const struct answer_item *column)
{
    char text[ANSWER_CELL];
    size_t width = 1, lines = head_lines(column), end = answer_after(answer, table);
    for (size_t line = 0; line < lines; line++) {
        head_line(column, line, lines, text);
        size_t head = wrap_width(text, strlen(text));
        width = head > width ? head : width;
    }
    for (size_t row = table + 1; row + 1 < end; row = answer_after(answer, row)) {
        const struct answer_item *item = answer_in_row(answer, row, column->label);
        if (!item)
            continue;
        answer_cell(item, " +- ", text);
        size_t cell = wrap_width(text, strlen(text));
        width = cell > width ? cell : width;
    }
    return width;
}

/* Blanks are owed until something follows them, so that no line ends in them. */
static void print_padded(const char *text, size_t width, bool left, size_t *owed, FILE *out)
{
    size_t own = wrap_width(text, strlen(text)), gap = own < width ? width - own : 0;
    *owed += 2 + (left ? 0 : gap);
    if (own > 0) {
        fprintf(out, "%*s%s", (int)*owed, "", text);
        *owed = 0;
    }
    *owed += left ? gap : 0;
}

struct block {
    const struct answer_item *column[ANSWER_COLUMNS];
    size_t width[ANSWER_COLUMNS];
    size_t count;
};

static bool is_left(const struct answer_item *column)
{
    return column->kind == ANSWER_WORDS || column->kind == ANSWER_NONE ||
           column->kind == ANSWER_SENTENCE;
}

static void print_block(const struct answer *answer, size_t table, const struct block *block,
                        size_t indent, FILE *out)
{
    char text[ANSWER_CELL];
    size_t lines = 0, end = answer_after(answer, table);
    for (size_t c = 0; c < block->count; c++) {
        size_t own = head_lines(block->column[c]);
        lines = own > lines ? own : lines;
    }
    for (size_t line = 0; line < lines; line++) {
        size_t owed = indent;
        for (size_t c = 0; c < block->count; c++) {
            head_line(block->column[c], line, lines, text);
            print_padded(text, block->width[c], is_left(block->column[c]), &owed, out);
        }
        fputc('\n', out);
    }
    for (size_t row = table + 1; row + 1 < end; row = answer_after(answer, row)) {
        size_t owed = indent;
        if (!answer_in_row(answer, row, NULL))
            continue;
        for (size_t c = 0; c < block->count; c++) {
            const struct answer_item *item = answer_in_row(answer, row, block->column[c]->label);
            text[0] = '\0';
            if (item)
                answer_cell(item, " +- ", text);
            print_padded(text, block->width[c], is_left(block->column[c]), &owed, out);
        }
        fputc('\n', out);
    }
}

static void print_table(const struct answer *answer, size_t table, size_t indent, FILE *out)
{
    size_t index[ANSWER_COLUMNS], columns = answer_columns(answer, table, index, ANSWER_COLUMNS),
                                  done = 0;
    struct block block = {0};
    size_t used = indent;
    while (done < columns) {
        const struct answer_item *column = &answer->item[index[done]];
        size_t width = column_width(answer, table, column);
        if (block.count > 1 && used + 2 + width > WIDTH) {
            /* the rest below, beside the first column again */
            print_block(answer, table, &block, indent, out);
            used = indent + 2 + block.width[0];
            block.count = 1;
        }
        block.column[block.count] = column;
        block.width[block.count++] = width;
        used += 2 + width;
        done++;
    }
    if (block.count > 0)
        print_block(answer, table, &block, indent, out);
}

/* ---- facts ---- */

static void print_fact(const struct answer_item *item, const char *label, int indent, size_t labels,
                       FILE *out)
{
    char text[ANSWER_CELL];
    if (item->kind == ANSWER_SENTENCE) {
        wrap_print(item->words ? item->words : "", 0, (size_t)indent, WIDTH, out);
        return;
    }
    answer_line(item, " +- ", text);
    fprintf(out, "%*s%s%*s %s\n", indent, "", label,
            (int)(labels - wrap_width(label, strlen(label))), "", text);
}

/* The labels' column: facts of groups without a heading stand in it, too. */
static size_t labels_width(const struct answer *answer, size_t from, size_t to)
{
    size_t labels = LABEL;
    for (size_t i = from; i < to; i = answer_after(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        size_t width = 0;
        if (item->label && !answer_is_group(item->kind))
            width = wrap_width(item->label, strlen(item->label));
        else if (item->label && item->kind != ANSWER_TABLE && !item->label[0])
            width = labels_width(answer, i + 1, answer_after(answer, i));
        labels = width > labels ? width : labels;
    }
    return labels;
}

static void print_items(const struct answer *answer, size_t from, size_t to, int indent,
                        size_t labels, FILE *out)
{
    const char *before = "";
    for (size_t i = from; i < to; i = answer_after(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        bool group = answer_is_group(item->kind);
        size_t end = answer_after(answer, i);
        if (!item->label || answer_is_empty(answer, i))
            continue;
        if (group && item->label[0])
            fprintf(out, "%*s%s\n", indent, "", item->label);
        if (group && item->kind == ANSWER_TABLE)
            print_table(answer, i, (size_t)indent, out);
        else if (group && item->label[0])
            print_items(answer, i + 1, end, indent + 2, labels_width(answer, i + 1, end), out);
        else if (group)
            print_items(answer, i + 1, end, indent, labels, out);
        else
            print_fact(item, strcmp(item->label, before) == 0 ? "" : item->label, indent, labels,
                       out);
        before = group ? "" : item->label;
    }
}

bool answer_text(const struct answer *answer, FILE *out)
{
    if (!answer || answer->failed)
        return false;
    print_items(answer, 0, answer->count, 0, labels_width(answer, 0, answer->count), out);
    return !ferror(out);
}
