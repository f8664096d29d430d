#include "host/base/answer.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/base/xmalloc.h"

/* An answer is a list of items of these kinds. answer.c collects them; the printers read them. */
enum answer_kind {
    ANSWER_VALUE,
    ANSWER_ESTIMATE,
    ANSWER_COUNT,
    ANSWER_FLAG,
    ANSWER_TEXT,
    ANSWER_SENTENCE,
    ANSWER_MISSING_VALUE,
    ANSWER_JSON,
    ANSWER_OPEN_GROUP,
    ANSWER_OPEN_LIST,
    ANSWER_OPEN_TABLE,
    ANSWER_CLOSE_GROUP
};

struct answer_item {
    struct answer_style
        style; /* must be the first member: a pointer to it is cast to answer_item */
    enum answer_kind kind;
    char *name, *label; /* owned; NULL name: not in the JSON; NULL label: only in the JSON */
    const struct unit *unit;
    double value, error; /* converted to the printed unit */
    const struct unit *json_unit;
    double json_value, json_error;
    int decimals;
    int64_t count;
    char *words;
    char *remark; /* text after the value, for people only; NULL: none */
    json_t *json;
};

struct answer {
    struct answer_item *item;
    size_t count;
    bool is_si, keeps_units;
    unsigned open_group_count; /* number of groups not yet closed */
    /* bit d is set while the group at depth d has an open row; that row is at depth d + 1 */
    uint64_t open_row_bits;
};

static bool opens_group(enum answer_kind kind)
{
    return kind == ANSWER_OPEN_GROUP || kind == ANSWER_OPEN_LIST || kind == ANSWER_OPEN_TABLE;
}

/* Returns the index of the first item after item `i` and, if it is a group, after its contents. */
static size_t index_after_item(const struct answer *answer, size_t i)
{
    size_t depth = 0;
    do {
        depth += opens_group(answer->item[i].kind);
        depth -= depth > 0 && answer->item[i].kind == ANSWER_CLOSE_GROUP;
        i++;
    } while (depth > 0 && i < answer->count);
    return i;
}

/* A group without facts is printed without heading and columns. */
static bool is_group_empty(const struct answer *answer, size_t i)
{
    return opens_group(answer->item[i].kind) && index_after_item(answer, i) <= i + 2;
}

#define CELL_TEXT_SIZE 1200 /* bytes of the longest text in a table cell */
#define COLUMNS_MAX    80   /* columns of a printed table: enough for all stations */

#define DEFAULT_JSON_DIGITS 6

struct answer *answer_new(bool si)
{
    struct answer *answer = xcalloc(1, sizeof *answer);
    answer->is_si = si;
    return answer;
}

void answer_keep_units(struct answer *answer)
{
    answer->keeps_units = true;
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

bool answer_is_si(const struct answer *answer)
{
    return answer->is_si;
}

static struct answer_item *add_item(struct answer *answer, enum answer_kind kind, const char *name,
                                    const char *label)
{
    xlist_grow(&answer->item, answer->count, sizeof *answer->item);
    struct answer_item *item = &answer->item[answer->count++];
    *item = (struct answer_item){
        .kind = kind, .style.digits = DEFAULT_JSON_DIGITS, .error = (double)NAN};
    item->name = name ? xstrdup(name) : NULL;
    item->label = label ? xstrdup(label) : NULL;
    return item;
}

static char *format_text(const char *format, va_list arguments)
{
    char text[CELL_TEXT_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    return xstrdup(text);
}

struct answer_style *answer_add_value(struct answer *answer, const char *name, const char *label,
                                      enum unit_kind unit, double value, int decimals)
{
    struct answer_item *item = add_item(answer, ANSWER_VALUE, name, label);
    const struct unit *shown = unit_get(unit, answer->is_si);
    item->unit = shown;
    item->value = value * shown->factor;
    item->json_unit = answer->keeps_units ? unit_get_json(unit) : shown;
    item->json_value = value * item->json_unit->factor;
    item->decimals = decimals;
    if (decimals >= 0)
        item->decimals = unit_decimals(unit, answer->is_si, decimals);
    return &item->style;
}

struct answer_style *answer_add_estimate(struct answer *answer, const char *name, const char *label,
                                         enum unit_kind unit, double value, double error,
                                         int decimals)
{
    struct answer_style *style = answer_add_value(answer, name, label, unit, value, decimals);
    /* `fact` is the first member of answer_item */
    struct answer_item *item = (struct answer_item *)style;
    item->kind = ANSWER_ESTIMATE;
    item->error = error * item->unit->factor;
    item->json_error = error * item->json_unit->factor;
    return style;
}

struct answer_style *answer_add_count(struct answer *answer, const char *name, const char *label,
                                      int64_t count)
{
    struct answer_item *item = add_item(answer, ANSWER_COUNT, name, label);
    item->count = count;
    return &item->style;
}

void answer_add_flag(struct answer *answer, const char *name, const char *label, bool yes)
{
    add_item(answer, ANSWER_FLAG, name, label)->count = yes;
}

struct answer_style *answer_add_text(struct answer *answer, const char *name, const char *label,
                                     const char *format, ...)
{
    struct answer_item *item = add_item(answer, ANSWER_TEXT, name, label);
    va_list arguments;
    va_start(arguments, format);
    item->words = format_text(format, arguments);
    va_end(arguments);
    return &item->style;
}

void answer_add_sentence(struct answer *answer, const char *name, const char *format, ...)
{
    struct answer_item *item = add_item(answer, ANSWER_SENTENCE, name, "");
    va_list arguments;
    va_start(arguments, format);
    item->words = format_text(format, arguments);
    va_end(arguments);
}

void answer_append_remark(struct answer *answer, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    answer->item[answer->count - 1].remark = format_text(format, arguments);
    va_end(arguments);
}

void answer_add_missing_value(struct answer *answer, const char *name, const char *label,
                              const char *why)
{
    add_item(answer, ANSWER_MISSING_VALUE, name, label)->words = why ? xstrdup(why) : NULL;
}

void answer_add_text_or_missing(struct answer *answer, const char *name, const char *label,
                                const char *text, const char *why)
{
    if (text && text[0])
        answer_add_text(answer, name, label, "%s", text);
    else
        answer_add_missing_value(answer, name, label, why);
}

void answer_add_json(struct answer *answer, const char *name, json_t *json)
{
    add_item(answer, ANSWER_JSON, name, NULL)->json = json;
}

static void open_group(struct answer *answer, enum answer_kind kind, const char *name,
                       const char *label)
{
    add_item(answer, kind, name, label);
    answer->open_row_bits &= ~(1ull << ++answer->open_group_count);
}

static void close_group(struct answer *answer)
{
    add_item(answer, ANSWER_CLOSE_GROUP, NULL, NULL);
    answer->open_group_count--;
}

void answer_open_group(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_OPEN_GROUP, name, label);
}

void answer_open_list(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_OPEN_LIST, name, label);
}

void answer_open_table(struct answer *answer, const char *name, const char *label)
{
    open_group(answer, ANSWER_OPEN_TABLE, name, label);
}

/* True if the innermost open group is a row of a table or list. */
static bool is_in_row(const struct answer *answer)
{
    return answer->open_group_count > 0 &&
           answer->open_row_bits >> (answer->open_group_count - 1) & 1u;
}

void answer_open_row(struct answer *answer)
{
    if (is_in_row(answer))
        close_group(answer);
    answer->open_row_bits |= 1ull << answer->open_group_count;
    open_group(answer, ANSWER_OPEN_GROUP, NULL, NULL);
}

void answer_close_group(struct answer *answer)
{
    if (is_in_row(answer))
        close_group(answer);
    close_group(answer);
}

json_t *answer_make_json_and_free(struct answer *answer)
{
    json_t *json = answer_make_json(answer);
    answer_free(answer);
    return json;
}

int answer_print(const struct cli *cli, struct answer *answer, int code)
{
    if (cli->json) {
        json_t *json = answer_make_json_and_free(answer);
        return cli_print_json(json, code);
    }
    bool shown = answer_print_text(answer, stdout) && fflush(stdout) == 0;
    answer_free(answer);
    return shown ? code : cli_report_output_failure();
}

int answer_print_or_fail(const struct cli *cli, struct answer *answer, int code,
                         const struct error *error)
{
    if (error->status == MR_OK)
        return answer_print(cli, answer, code);
    answer_free(answer);
    return cli_fail(error);
}

/* ---- printed answer ---- */
#define TERMINAL_COLUMNS 100 /* characters in a line of a common terminal */
#define LABEL_WIDTH_MIN  13  /* smallest width of the label column, characters */
/* Half-width of a 95 % interval of a normal distribution, in standard deviations */
#define Z_95             1.959964

static int format_number(const struct answer_item *item, double value, bool plus, char *text,
                         size_t size)
{
    if (!isfinite(value))
        return snprintf(text, size, "%s", isnan(value) ? "-" : value < 0 ? "-inf" : "inf");
    if (item->style.is_capped && value >= 999.5)
        return snprintf(text, size, ">999");
    if (item->decimals < 0)
        /* adding 0.0 changes -0.0 to 0.0, so that "-0" is never printed */
        return snprintf(text, size, plus ? "%+.*g" : "%.*g", -item->decimals, value + 0.0);
    return snprintf(text, size, plus ? "%+.*f" : "%.*f", item->decimals,
                    unit_round_to_zero(value, pow(10.0, -item->decimals)));
}

static void format_cell(const struct answer_item *item, const char *plus_minus,
                        char text[static CELL_TEXT_SIZE])
{
    int length = 0;
    text[0] = '\0';
    switch (item->kind) {
    case ANSWER_VALUE:
    case ANSWER_ESTIMATE:
        length = format_number(item, item->value, item->style.shows_sign, text, CELL_TEXT_SIZE);
        break;
    case ANSWER_COUNT:
        if (item->count == ANSWER_COUNT_UNKNOWN)
            snprintf(text, CELL_TEXT_SIZE, "-");
        else
            snprintf(text, CELL_TEXT_SIZE, "%lld", (long long)item->count);
        break;
    case ANSWER_FLAG: snprintf(text, CELL_TEXT_SIZE, "%s", item->count ? "yes" : "no"); break;
    default: snprintf(text, CELL_TEXT_SIZE, "%s", item->words ? item->words : "");
    }
    if (item->kind == ANSWER_ESTIMATE && isfinite(item->value) && !isnan(item->error)) {
        length += snprintf(text + length, (size_t)(CELL_TEXT_SIZE - length), "%s", plus_minus);
        format_number(item, item->error, false, text + length, (size_t)(CELL_TEXT_SIZE - length));
    }
}

static void format_line(const struct answer_item *item, const char *plus_minus,
                        char text[static CELL_TEXT_SIZE])
{
    const char *unit = item->unit && isfinite(item->value) ? item->unit->text : "";
    char interval[80] = "";
    format_cell(item, plus_minus, text);
    if (item->style.shows_interval && isfinite(item->error))
        snprintf(interval, sizeof interval, " (95 %%: %.*f to %.*f)", item->decimals,
                 item->value - Z_95 * item->error, item->decimals,
                 item->value + Z_95 * item->error);
    size_t length = strlen(text);
    snprintf(text + length, CELL_TEXT_SIZE - length, "%s%s%s%s%s", unit[0] ? " " : "", unit,
             interval, item->style.suffix ? item->style.suffix : "",
             item->remark ? item->remark : "");
}

/* ---- tables ---- */

static bool is_cell(const struct answer_item *item)
{
    return !opens_group(item->kind) && item->label && item->label[0];
}

static size_t find_columns(const struct answer *answer, size_t table, size_t *column, size_t most)
{
    size_t count = 0, end = index_after_item(answer, table);
    for (size_t row = table + 1; row + 1 < end; row = index_after_item(answer, row)) {
        /* Place a new column after the previous column of the same row. */
        size_t place = 0, to = index_after_item(answer, row);
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
                /* Take the unit from this row: a row without the value has no unit. */
                column[c] = i;
            place = c + 1;
        }
    }
    return count;
}

static const struct answer_item *find_cell(const struct answer *answer, size_t row,
                                           const char *label)
{
    size_t end = index_after_item(answer, row);
    for (size_t i = row + 1; i < end; i++) {
        if (is_cell(&answer->item[i]) && (!label || strcmp(answer->item[i].label, label) == 0))
            return &answer->item[i];
    }
    return NULL;
}

/* Formats line `line` of a column head: the parts of the label, then the unit. Returns false if the
 * line is empty. */
static bool format_heading_line(const struct answer_item *column, size_t line, size_t lines,
                                char text[static CELL_TEXT_SIZE])
{
    const char *part = column->label;
    size_t parts = 1, unit = column->unit && column->unit->text[0];
    for (const char *at = part; (at = strchr(at, '|')); at++)
        parts++;
    text[0] = '\0';
    if (line + parts + unit < lines) /* heads are aligned at the bottom: all end on the last line */
        return false;
    line -= lines - parts - unit;
    if (line >= parts)
        return snprintf(text, CELL_TEXT_SIZE, "%s", column->unit->text) > 0;
    for (; line > 0; line--)
        part = strchr(part, '|') + 1;
    snprintf(text, CELL_TEXT_SIZE, "%.*s", (int)strcspn(part, "|"), part);
    return true;
}

static size_t count_heading_lines(const struct answer_item *column)
{
    size_t lines = column->unit && column->unit->text[0] ? 2 : 1;
    for (const char *at = column->label; (at = strchr(at, '|')); at++)
        lines++;
    return lines;
}

static size_t compute_column_width(const struct answer *answer, size_t table,
                                   const struct answer_item *column)
{
    char text[CELL_TEXT_SIZE];
    size_t width = 1, lines = count_heading_lines(column), end = index_after_item(answer, table);
    for (size_t line = 0; line < lines; line++) {
        format_heading_line(column, line, lines, text);
        size_t head = text_count_characters(text, strlen(text));
        width = head > width ? head : width;
    }
    for (size_t row = table + 1; row + 1 < end; row = index_after_item(answer, row)) {
        const struct answer_item *item = find_cell(answer, row, column->label);
        if (!item)
            continue;
        format_cell(item, " +- ", text);
        size_t cell = text_count_characters(text, strlen(text));
        width = cell > width ? cell : width;
    }
    return width;
}

/* Prints pending spaces only if text follows, so that no line ends in spaces. */
static void print_padded(const char *text, size_t width, bool left, size_t *pending, FILE *out)
{
    size_t own = text_count_characters(text, strlen(text)), gap = own < width ? width - own : 0;
    *pending += 2 + (left ? 0 : gap);
    if (own > 0) {
        fprintf(out, "%*s%s", (int)*pending, "", text);
        *pending = 0;
    }
    *pending += left ? gap : 0;
}

struct column_block {
    const struct answer_item *column[COLUMNS_MAX];
    size_t width[COLUMNS_MAX];
    size_t count;
};

static bool is_left_aligned(const struct answer_item *column)
{
    return !column->style.is_number &&
           (column->kind == ANSWER_TEXT || column->kind == ANSWER_MISSING_VALUE ||
            column->kind == ANSWER_SENTENCE);
}

static bool shows_number(const struct answer_item *item)
{
    return item->kind <= ANSWER_COUNT || item->style.is_number;
}

static void print_column_block(const struct answer *answer, size_t table,
                               const struct column_block *block, size_t indent, FILE *out)
{
    char text[CELL_TEXT_SIZE];
    size_t lines = 0, end = index_after_item(answer, table);
    for (size_t c = 0; c < block->count; c++) {
        size_t own = count_heading_lines(block->column[c]);
        lines = own > lines ? own : lines;
    }
    for (size_t line = 0; line < lines; line++) {
        size_t owed = indent;
        for (size_t c = 0; c < block->count; c++) {
            format_heading_line(block->column[c], line, lines, text);
            print_padded(text, block->width[c], is_left_aligned(block->column[c]), &owed, out);
        }
        fputc('\n', out);
    }
    for (size_t row = table + 1; row + 1 < end; row = index_after_item(answer, row)) {
        size_t owed = indent;
        if (!find_cell(answer, row, NULL))
            continue;
        for (size_t c = 0; c < block->count; c++) {
            const struct answer_item *item = find_cell(answer, row, block->column[c]->label);
            text[0] = '\0';
            if (item)
                format_cell(item, " +- ", text);
            print_padded(text, block->width[c], is_left_aligned(block->column[c]), &owed, out);
        }
        fputc('\n', out);
    }
}

static void print_table(const struct answer *answer, size_t table, size_t indent, FILE *out)
{
    size_t index[COLUMNS_MAX], columns = find_columns(answer, table, index, COLUMNS_MAX), done = 0;
    struct column_block block = {0};
    size_t used = indent;
    while (done < columns) {
        const struct answer_item *column = &answer->item[index[done]];
        size_t width = compute_column_width(answer, table, column);
        if (block.count > 1 && used + 2 + width > TERMINAL_COLUMNS) {
            /* Print the columns so far. The remaining columns follow in a new table below, with the
             * first column repeated. */
            print_column_block(answer, table, &block, indent, out);
            used = indent + 2 + block.width[0];
            block.count = 1;
        }
        block.column[block.count] = column;
        block.width[block.count++] = width;
        used += 2 + width;
        done++;
    }
    if (block.count > 0)
        print_column_block(answer, table, &block, indent, out);
}

/* ---- facts ---- */

static void print_value(const struct answer_item *item, const char *label, int indent,
                        size_t labels, FILE *out)
{
    char text[CELL_TEXT_SIZE];
    if (item->kind == ANSWER_SENTENCE) {
        text_print_wrapped(item->words ? item->words : "", 0, (size_t)indent, TERMINAL_COLUMNS,
                           out);
        return;
    }
    format_line(item, " +- ", text);
    fprintf(out, "%*s%s%*s %s\n", indent, "", label,
            (int)(labels - text_count_characters(label, strlen(label))), "", text);
}

/* Returns the width of the label column, which groups without a heading share. */
static size_t compute_label_width(const struct answer *answer, size_t from, size_t to)
{
    size_t labels = LABEL_WIDTH_MIN;
    for (size_t i = from; i < to; i = index_after_item(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        size_t width = 0;
        if (item->label && !opens_group(item->kind))
            width = text_count_characters(item->label, strlen(item->label));
        else if (item->label && item->kind != ANSWER_OPEN_TABLE && !item->label[0])
            width = compute_label_width(answer, i + 1, index_after_item(answer, i));
        labels = width > labels ? width : labels;
    }
    return labels;
}

static void print_items(const struct answer *answer, size_t from, size_t to, int indent,
                        size_t labels, FILE *out)
{
    const char *before = "";
    for (size_t i = from; i < to; i = index_after_item(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        bool group = opens_group(item->kind);
        size_t end = index_after_item(answer, i);
        if (!item->label || is_group_empty(answer, i))
            continue;
        if (group && item->label[0])
            text_print_wrapped(item->label, 0, (size_t)indent, TERMINAL_COLUMNS, out);
        if (group && item->kind == ANSWER_OPEN_TABLE)
            print_table(answer, i, (size_t)indent, out);
        else if (group && item->label[0])
            print_items(answer, i + 1, end, indent + 2, compute_label_width(answer, i + 1, end),
                        out);
        else if (group)
            print_items(answer, i + 1, end, indent, labels, out);
        else
            print_value(item, strcmp(item->label, before) == 0 ? "" : item->label, indent, labels,
                        out);
        before = group ? "" : item->label;
    }
}

bool answer_print_text(const struct answer *answer, FILE *out)
{
    print_items(answer, 0, answer->count, 0, compute_label_width(answer, 0, answer->count), out);
    return !ferror(out);
}

/* ---- JSON answer ---- */
static void set_json_value(json_t *group, const char *name, json_t *value)
{
    if (json_is_array(group))
        json_array_append_new(group, value);
    else if (name)
        json_object_set_new(group, name, value);
    else
        json_decref(value);
}

/* Stores the number under the key NAME_suffix, or NAME_error_suffix for its standard error. */
static void set_json_number(json_t *group, const struct answer_item *item, const char *what,
                            double value)
{
    char key[120];
    const char *suffix = item->json_unit->suffix;
    snprintf(key, sizeof key, "%s%s%s%s", item->name ? item->name : "", what, suffix[0] ? "_" : "",
             suffix);
    set_json_value(group, item->name ? key : NULL, cli_json_number(value, item->style.digits));
}

static void set_json_items(const struct answer *answer, size_t from, size_t to, json_t *group);

static void set_json_group(const struct answer *answer, size_t i, json_t *group)
{
    const struct answer_item *item = &answer->item[i];
    if (!item->name && !json_is_array(group)) {
        /* The heading is only for printed text. In the JSON its facts belong to the enclosing
         * object. */
        set_json_items(answer, i + 1, index_after_item(answer, i), group);
        return;
    }
    json_t *inner = item->kind == ANSWER_OPEN_GROUP ? json_object() : json_array();
    set_json_items(answer, i + 1, index_after_item(answer, i), inner);
    set_json_value(group, item->name, inner);
}

static void set_json_item(const struct answer_item *item, json_t *group)
{
    if (!item->name && !json_is_array(group))
        return;
    switch (item->kind) {
    case ANSWER_ESTIMATE:
        set_json_number(group, item, "", item->json_value);
        set_json_number(group, item, "_error", item->json_error);
        break;
    case ANSWER_VALUE: set_json_number(group, item, "", item->json_value); break;
    case ANSWER_COUNT:
        set_json_value(group, item->name,
                       item->count == ANSWER_COUNT_UNKNOWN ? json_null()
                                                           : json_integer((json_int_t)item->count));
        break;
    case ANSWER_FLAG: set_json_value(group, item->name, json_boolean(item->count)); break;
    case ANSWER_TEXT:
    case ANSWER_SENTENCE: set_json_value(group, item->name, json_string(item->words)); break;
    case ANSWER_MISSING_VALUE: set_json_value(group, item->name, json_null()); break;
    case ANSWER_JSON: set_json_value(group, item->name, json_incref(item->json)); break;
    default: break;
    }
}

static void set_json_items(const struct answer *answer, size_t from, size_t to, json_t *group)
{
    for (size_t i = from; i < to; i = index_after_item(answer, i)) {
        if (opens_group(answer->item[i].kind))
            set_json_group(answer, i, group);
        else if (answer->item[i].kind == ANSWER_CLOSE_GROUP)
            break;
        else
            set_json_item(&answer->item[i], group);
    }
}

json_t *answer_make_json(const struct answer *answer)
{
    json_t *object = json_object();
    set_json_items(answer, 0, answer->count, object);
    return object;
}

/* ---- HTML answer: facts as <dl>, tables as <table>, headings as <h3> ---- */
/* Length in characters of a long text. A column with such a text may be as narrow as the style
 * sheet allows. */
#define HTML_LONG_TEXT_MIN 40

static bool html_column_has_long_text(const struct answer *answer, size_t table, const char *label)
{
    size_t end = index_after_item(answer, table);
    char text[CELL_TEXT_SIZE];
    for (size_t row = table + 1; row + 1 < end; row = index_after_item(answer, row)) {
        const struct answer_item *item = find_cell(answer, row, label);
        if (!item)
            continue;
        format_cell(item, " \xc2\xb1 ", text);
        if (strlen(text) > HTML_LONG_TEXT_MIN)
            return true;
    }
    return false;
}

static void html_print_table(const struct answer *answer, size_t table, FILE *out)
{
    size_t index[COLUMNS_MAX], columns = find_columns(answer, table, index, COLUMNS_MAX),
                               end = index_after_item(answer, table);
    char text[CELL_TEXT_SIZE];
    fputs("<div class=\"scroll\"><table><thead><tr>", out);
    for (size_t c = 0; c < columns; c++) {
        const struct answer_item *column = &answer->item[index[c]];
        fputs(shows_number(column)                                      ? "<th class=\"n\">"
              : html_column_has_long_text(answer, table, column->label) ? "<th class=\"long\">"
                                                                        : "<th>",
              out);
        for (const char *at = column->label; *at;) {
            size_t length = strcspn(at, "|");
            html_write_bytes(out, at, length);
            at += length;
            if (*at && at++)
                fputc(' ', out);
        }
        if (column->unit && column->unit->text[0]) {
            fputs(" (", out);
            html_write_text(out, column->unit->text);
            fputc(')', out);
        }
        fputs("</th>", out);
    }
    fputs("</tr></thead><tbody>\n", out);
    for (size_t row = table + 1; row + 1 < end; row = index_after_item(answer, row)) {
        if (!find_cell(answer, row, NULL))
            continue;
        fputs("<tr>", out);
        for (size_t c = 0; c < columns; c++) {
            const struct answer_item *item = find_cell(answer, row, answer->item[index[c]].label);
            bool is_number = item && shows_number(item), warns = item && item->style.is_warning;
            text[0] = '\0';
            if (item)
                format_cell(item, " \xc2\xb1 ", text);
            fputs(is_number && warns ? "<td class=\"n warn\">"
                  : is_number        ? "<td class=\"n\">"
                  : warns            ? "<td class=\"warn\">"
                                     : "<td>",
                  out);
            bool run = item && item->style.is_run_number;
            if (run)
                fprintf(out, "<a href=\"#run%s\">", text);
            html_write_text(out, is_number && strcmp(text, "-") == 0 ? "\xe2\x80\x93" : text);
            fputs(run ? "</a></td>" : "</td>", out);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void html_print_value(const struct answer_item *item, FILE *out)
{
    char text[CELL_TEXT_SIZE];
    format_line(item, " \xc2\xb1 ", text);
    fputs("<div><dt>", out);
    html_write_text(out, item->label);
    fputs(item->style.is_warning ? "</dt><dd class=\"warn\">" : "</dt><dd>", out);
    html_write_text(out, text);
    fputs("</dd></div>\n", out);
}

/* Prints facts; consecutive facts share one <dl>. `in_list`: a <dl> is already open. Returns true
 * if a <dl> is open at the end. */
static bool html_print_items(const struct answer *answer, size_t from, size_t to, bool in_list,
                             FILE *out)
{
    for (size_t i = from; i < to; i = index_after_item(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        bool group = opens_group(item->kind), sentence = item->kind == ANSWER_SENTENCE;
        if (!item->label || is_group_empty(answer, i))
            continue;
        if (group && !item->label[0] && item->kind != ANSWER_OPEN_TABLE) {
            in_list = html_print_items(answer, i + 1, index_after_item(answer, i), in_list, out);
            continue;
        }
        if (in_list != !(group || sentence))
            fputs(in_list ? "</dl>\n" : "<dl>\n", out);
        in_list = !(group || sentence);
        if (group && item->label[0]) {
            fputs("<h3>", out);
            html_write_text(out, item->label);
            fputs("</h3>\n", out);
        }
        if (sentence) {
            fputs("<p>", out);
            html_write_text(out, item->words ? item->words : "");
            fputs("</p>\n", out);
        } else if (group && item->kind == ANSWER_OPEN_TABLE)
            html_print_table(answer, i, out);
        else if (group)
            in_list = html_print_items(answer, i + 1, index_after_item(answer, i), false, out);
        else
            html_print_value(item, out);
    }
    return in_list;
}

void answer_print_html(const struct answer *answer, FILE *out)
{
    if (html_print_items(answer, 0, answer->count, false, out))
        fputs("</dl>\n", out);
}

size_t text_count_characters(const char *text, size_t bytes)
{
    size_t width = 0;
    for (size_t i = 0; i < bytes; i++)
        width += ((unsigned char)text[i] & 0xc0) != 0x80;
    return width;
}

void text_print_wrapped(const char *text, size_t column, size_t indent, size_t width, FILE *out)
{
    bool begins = column == 0; /* true until the line has its first word */
    if (begins)
        column = (size_t)fprintf(out, "%*s", (int)indent, "");
    for (text += strspn(text, " "); *text; text += strspn(text, " ")) {
        size_t bytes = strcspn(text, " "), word = text_count_characters(text, bytes);
        if (!begins && column + 1 + word > width) {
            column = (size_t)fprintf(out, "\n%*s", (int)indent, "") - 1;
            begins = true;
        }
        column += (size_t)fprintf(out, begins ? "%.*s" : " %.*s", (int)bytes, text) - bytes + word;
        begins = false;
        text += bytes;
    }
    fputc('\n', out);
}
