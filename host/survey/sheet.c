#include "host/survey/sheet.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/quantity.h"
#include "host/base/units.h"

#define LINE_MAX_BYTES  2000
#define COLUMNS_MAX     32
#define READING_MOST_IN 2000.0

enum column { KIND, LINE, PLACE, READING, NOTE, COLUMNS };

void survey_sheet_write(FILE *out, const struct survey_desk *desk, bool si)
{
    const struct unit *unit = unit_of(UNIT_DISPLACEMENT, si);
    fprintf(out, "kind,line,place,reading_%s,previous_%s,where,note\n", unit->suffix, unit->suffix);
    for (size_t i = 0; i < desk->plan.count; i++) {
        const struct survey_item *item = &desk->plan.item[i];
        char text[120];
        survey_item_text(item, si, text, sizeof text);
        fprintf(out, "%s,%u,%u,", survey_kind_text(item->kind), item->line, item->place);
        if (!isnan(desk->value_in[i]))
            fprintf(out, "%.4f", desk->value_in[i] * unit->factor);
        fputc(',', out);
        if (!isnan(desk->previous_in[i]))
            fprintf(out, "%.4f", desk->previous_in[i] * unit->factor);
        fprintf(out, ",\"%s\",\n", text);
    }
}

/* The cells of a line, in place; quoted ones lose their quotes. */
static size_t split(char *line, char *cell[COLUMNS_MAX])
{
    size_t count = 0;
    line[strcspn(line, "\r\n")] = '\0';
    for (char *p = line; count < COLUMNS_MAX;) {
        char *to = p;
        bool quoted = *p == '"';
        cell[count++] = p;
        for (p += quoted; *p && (quoted || *p != ','); p++) {
            if (quoted && *p == '"') {
                quoted = p[1] == '"';
                if (!quoted)
                    continue;
                p++;
            }
            *to++ = *p;
        }
        bool more = *p == ',';
        *to = '\0';
        if (!more)
            break;
        p++;
    }
    return count;
}

static bool whole(const char *text, unsigned *value)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    *value = (unsigned)number;
    return text[0] >= '0' && text[0] <= '9' && *end == '\0' && number < 1000;
}

static enum mr_status find_columns(const char *path, char **cell, size_t cells, int column[COLUMNS],
                                   bool *mm, struct error *error)
{
    static const char *const names[COLUMNS] = {"kind", "line", "place", "reading_in", "note"};
    for (int i = 0; i < COLUMNS; i++)
        column[i] = -1;
    for (size_t c = 0; c < cells; c++) {
        for (int i = 0; i < COLUMNS; i++)
            column[i] = strcmp(cell[c], names[i]) == 0 ? (int)c : column[i];
        if (strcmp(cell[c], "reading_mm") == 0) {
            column[READING] = (int)c;
            *mm = true;
        }
    }
    for (int i = 0; i < NOTE; i++) {
        if (column[i] < 0)
            return error_set(
                error, MR_MALFORMED,
                "no column %s: %s, line 1; matrig survey DB --sheet writes a sheet as it should be",
                names[i], path);
    }
    return MR_OK;
}

static enum mr_status take_row(const char *path, size_t line, char **cell, size_t cells,
                               const int column[COLUMNS], bool mm, const struct survey_plan *plan,
                               struct survey_sheet *sheet, struct error *error)
{
    struct survey_item item;
    const char *text[COLUMNS];
    for (int i = 0; i < COLUMNS; i++)
        text[i] = column[i] >= 0 && column[i] < (int)cells ? cell[column[i]] : "";
    if (text[READING][0] == '\0')
        return MR_OK;
    int at = survey_kind_parse(text[KIND], &item.kind) && whole(text[LINE], &item.line) &&
                     whole(text[PLACE], &item.place)
               ? survey_plan_find(plan, &item)
               : -1;
    if (at < 0)
        return error_set(
            error, MR_MALFORMED,
            "no such place, '%s' %s %s: %s, line %zu; matrig survey DB --sheet lists them",
            text[KIND], text[LINE], text[PLACE], path, line);
    if (!isnan(sheet->value_in[at]))
        return error_set(error, MR_MALFORMED, "%s %s %s stands twice: %s, line %zu; leave one out",
                         text[KIND], text[LINE], text[PLACE], path, line);
    double value;
    struct quantity_wrong wrong = {"", ""};
    if (!quantity_parse(text[READING], "in", mm ? "mm" : "in", &value, &wrong) ||
        !(fabs(value) <= READING_MOST_IN))
        return error_set(error, MR_MALFORMED,
                         "not a reading, '%s': %s, line %zu; write a number, or nothing%s%s",
                         text[READING], path, line, wrong.what[0] ? ": this is " : "", wrong.what);
    sheet->value_in[at] = value;
    snprintf(sheet->note[at], SURVEY_NOTE_MAX, "%.*s", (int)SURVEY_NOTE_MAX - 1, text[NOTE]);
    sheet->count++;
    return MR_OK;
}

enum mr_status survey_sheet_read(const char *path, const struct survey_plan *plan,
                                 struct survey_sheet *sheet, struct error *error)
{
    char line[LINE_MAX_BYTES], *cell[COLUMNS_MAX];
    int column[COLUMNS] = {0};
    bool mm = false;
    enum mr_status status = MR_OK;
    memset(sheet, 0, sizeof *sheet);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        sheet->value_in[i] = (double)NAN;
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check path and rights",
                         strerror(errno), path);
    for (size_t number = 1; status == MR_OK && fgets(line, sizeof line, file); number++) {
        if (!strchr(line, '\n') && !feof(file))
            status = error_set(error, MR_MALFORMED, "line too long: %s, line %zu; is it a sheet?",
                               path, number);
        else if (number == 1)
            status = find_columns(path, cell, split(line, cell), column, &mm, error);
        else if (line[strspn(line, " \t\r\n")] != '\0')
            status = take_row(path, number, cell, split(line, cell), column, mm, plan, sheet,
                              error);
    }
    if (status == MR_OK && ferror(file))
        status = error_set(error, MR_IO, "cannot read: %s; is it a file?", path);
    fclose(file);
    if (status == MR_OK && sheet->count == 0)
        status = error_set(error, MR_TOO_FEW, "no reading in it: %s; fill in the column reading_in",
                           path);
    return status;
}
