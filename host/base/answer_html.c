/* An answer on a page: facts as <dl>, tables as <table>, headings as <h3>. */
#include <math.h>

#include "host/base/answer_items.h"
#include "host/base/html.h"

static void print_table(const struct answer *answer, size_t table, FILE *out)
{
    size_t index[ANSWER_COLUMNS], columns = answer_columns(answer, table, index, ANSWER_COLUMNS),
                                  end = answer_after(answer, table);
    char text[ANSWER_CELL];
    fputs("<div class=\"scroll\"><table><thead><tr>", out);
    for (size_t c = 0; c < columns; c++) {
        const struct answer_item *column = &answer->item[index[c]];
        fputs("<th>", out);
        for (const char *at = column->label; *at; at++)
            html_bytes(out, *at == '|' ? " " : at, 1);
        if (column->unit && column->unit->text[0]) {
            fputs(", ", out);
            html_text(out, column->unit->text);
        }
        fputs("</th>", out);
    }
    fputs("</tr></thead><tbody>\n", out);
    for (size_t row = table + 1; row + 1 < end; row = answer_after(answer, row)) {
        if (!answer_in_row(answer, row, NULL))
            continue;
        fputs("<tr>", out);
        for (size_t c = 0; c < columns; c++) {
            const struct answer_item *item = answer_in_row(answer, row,
                                                           answer->item[index[c]].label);
            bool is_number = item && item->kind <= ANSWER_COUNT;
            text[0] = '\0';
            if (item)
                answer_cell(item, " \xc2\xb1 ", text);
            fputs(is_number                 ? "<td class=\"n\">"
                  : item && item->fact.warn ? "<td class=\"warn\">"
                                            : "<td>",
                  out);
            html_text(out, is_number && item->kind != ANSWER_COUNT && isnan(item->value)
                               ? "\xe2\x80\x93"
                               : text);
            fputs("</td>", out);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void print_fact(const struct answer_item *item, FILE *out)
{
    char text[ANSWER_CELL];
    answer_line(item, " \xc2\xb1 ", text);
    fputs("<div><dt>", out);
    html_text(out, item->label);
    fputs(item->fact.warn ? "</dt><dd class=\"warn\">" : "</dt><dd>", out);
    html_text(out, text);
    fputs("</dd></div>\n", out);
}

/* Facts in a row share one <dl>, which may be open before and after. */
static bool print_items(const struct answer *answer, size_t from, size_t to, bool in_list,
                        FILE *out)
{
    for (size_t i = from; i < to; i = answer_after(answer, i)) {
        const struct answer_item *item = &answer->item[i];
        bool group = answer_is_group(item->kind), sentence = item->kind == ANSWER_SENTENCE;
        if (!item->label || answer_is_empty(answer, i))
            continue;
        if (group && !item->label[0] && item->kind != ANSWER_TABLE) {
            in_list = print_items(answer, i + 1, answer_after(answer, i), in_list, out);
            continue;
        }
        if (in_list != !(group || sentence))
            fputs(in_list ? "</dl>\n" : "<dl>\n", out);
        in_list = !(group || sentence);
        if (group && item->label[0]) {
            fputs("<h3>", out);
            html_text(out, item->label);
            fputs("</h3>\n", out);
        }
        if (sentence) {
            fputs("<p>", out);
            html_text(out, item->words ? item->words : "");
            fputs("</p>\n", out);
        } else if (group && item->kind == ANSWER_TABLE)
            print_table(answer, i, out);
        else if (group)
            in_list = print_items(answer, i + 1, answer_after(answer, i), false, out);
        else
            print_fact(item, out);
    }
    return in_list;
}

bool answer_html(const struct answer *answer, FILE *out)
{
    if (!answer || answer->failed)
        return false;
    if (print_items(answer, 0, answer->count, false, out))
        fputs("</dl>\n", out);
    return !ferror(out);
}
