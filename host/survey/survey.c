#include "host/survey/survey.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/base/csv.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"

/* ---- plan ---- */

const char *const survey_item_kind_text[SURVEY_ITEM_KIND_COUNT] = {"gap", "station", "across",
                                                                   "diagonal"};
const char *const survey_edges_text[SURVEY_EDGES_COUNT] = {"left", "both", "none", "diagonal"};

static void add_item(struct survey_plan *plan, enum survey_item_kind kind, unsigned line,
                     unsigned place)
{
    plan->item[plan->count++] = (struct survey_item){kind, line, place};
}

static void add_station_items(struct survey_plan *plan, enum survey_edges edges, unsigned line,
                              unsigned station)
{
    bool diagonal = edges == SURVEY_EDGE_DIAGONAL;
    if (diagonal || (line == 1 && edges != SURVEY_EDGE_NONE) ||
        (line == SURVEY_LINES && edges == SURVEY_EDGE_BOTH))
        add_item(plan, SURVEY_ITEM_STATION, line, station);
    if (diagonal)
        add_item(plan, SURVEY_ITEM_ACROSS, line, station);
}

/* Returns the station at which an item begins; NaN for a diagonal, which has no station. */
static double get_item_station_ft(const struct survey_item *item)
{
    return (item->kind == SURVEY_ITEM_GAP ? SURVEY_SPAN_LENGTH_FT : SURVEY_STATION_SPACING_FT) *
           item->index;
}

/* Adds the items of a line in the downfield direction. Each station is listed before the first span
 * that begins at or downfield of it. */
static void add_line_items(struct survey_plan *plan, enum survey_edges edges, unsigned line)
{
    unsigned station = 0;
    for (unsigned span = 0; span < SURVEY_SPANS; span++) {
        double begins_ft = get_item_station_ft(&(struct survey_item){SURVEY_ITEM_GAP, line, span});
        while (station < SURVEY_STATIONS && SURVEY_STATION_SPACING_FT * station <= begins_ft + 1e-6)
            add_station_items(plan, edges, line, station++);
        add_item(plan, SURVEY_ITEM_GAP, line, span);
    }
    while (station < SURVEY_STATIONS)
        add_station_items(plan, edges, line, station++);
}

void survey_plan_init(struct survey_plan *plan, enum survey_edges edges)
{
    plan->count = 0;
    for (unsigned line = 1; line <= SURVEY_LINES; line++) {
        size_t first = plan->count;
        add_line_items(plan, edges, line);
        /* reverse the order on even lines, which are read while walking back upfield */
        for (size_t i = first, j = plan->count; line % 2 == 0 && i + 1 < j; i++) {
            struct survey_item item = plan->item[i];
            plan->item[i] = plan->item[--j];
            plan->item[j] = item;
        }
    }
    for (unsigned line = 1; edges == SURVEY_EDGE_DIAGONAL && line <= SURVEY_DIAGONALS; line++) {
        for (unsigned i = 0; i < SURVEY_DIAGONAL_SPANS; i++)
            add_item(plan, SURVEY_ITEM_DIAGONAL, line,
                     line % 2 ? i : SURVEY_DIAGONAL_SPANS - 1u - i);
    }
}

int survey_plan_find(const struct survey_plan *plan, const struct survey_item *item)
{
    for (size_t i = 0; i < plan->count; i++) {
        const struct survey_item *p = &plan->item[i];
        if (p->kind == item->kind && p->line == item->line && p->index == item->index)
            return (int)i;
    }
    return -1;
}

static int find_word_index(const char *const *words, int count, const char *text)
{
    while (count-- > 0 && strcmp(words[count], text) != 0)
        ;
    return count;
}

static bool survey_item_kind_parse(const char *text, enum survey_item_kind *kind)
{
    int found = find_word_index(survey_item_kind_text, SURVEY_ITEM_KIND_COUNT, text);
    *kind = found < 0 ? SURVEY_ITEM_KIND_COUNT : (enum survey_item_kind)found;
    return found >= 0;
}

bool survey_edges_parse(const char *text, enum survey_edges *edges)
{
    int found = find_word_index(survey_edges_text, SURVEY_EDGES_COUNT, text);
    *edges = found < 0 ? SURVEY_EDGE_LEFT : (enum survey_edges)found;
    return found >= 0;
}

double survey_line_offset_in(unsigned line)
{
    static const double from_left_in[SURVEY_LINES] = {12.0, SURVEY_RUNWAY_WIDTH_IN / 2 - 36.0,
                                                      SURVEY_RUNWAY_WIDTH_IN / 2,
                                                      SURVEY_RUNWAY_WIDTH_IN - 12.0};
    return from_left_in[line - 1];
}

const char *survey_describe_line(unsigned line)
{
    static const char *const text[SURVEY_LINES] = {
        "12 in from the left edge", "36 in left of the centreline", "near the centreline",
        "12 in from the right edge"};
    return line >= 1 && line <= SURVEY_LINES ? text[line - 1] : "unknown";
}

void survey_item_format(const struct survey_item *item, bool si, char *out, size_t size)
{
    const struct unit *station = unit_get(UNIT_STATION, si);
    double at = get_item_station_ft(item) * station->factor;
    if (item->kind == SURVEY_ITEM_GAP)
        snprintf(out, size, "line %u (%s), mats %u to %u, station %.1f %s", item->line,
                 survey_describe_line(item->line), item->index * MR_MATS_PER_SEGMENT + 1,
                 (item->index + 1) * MR_MATS_PER_SEGMENT, at, station->text);
    else if (item->kind == SURVEY_ITEM_DIAGONAL)
        snprintf(out, size, "45 degree line %u, span %u of %u from the left", item->line,
                 item->index + 1, SURVEY_DIAGONAL_SPANS);
    else
        snprintf(out, size, "%s %.1f %s, line %u (%s)",
                 item->kind == SURVEY_ITEM_STATION ? "station" : "across at station", at,
                 station->text, item->line, survey_describe_line(item->line));
}

static bool is_span_item(const struct survey_item *item)
{
    return item->kind == SURVEY_ITEM_GAP || item->kind == SURVEY_ITEM_DIAGONAL;
}

/* Returns the expected value of the first reading of an item; NaN: none. */
static double get_item_nominal_in(const struct survey_item *item)
{
    return is_span_item(item) ? SURVEY_POINT_SPACING_IN : (double)NAN;
}

double survey_item_limit_in(const struct survey_item *item)
{
    return is_span_item(item) ? SURVEY_SPAN_CHANGE_MAX_IN : SURVEY_STATION_CHANGE_MAX_IN;
}

/* ---- a survey in progress ---- */

/* three reading errors; a second reading within this distance confirms a doubtful one */
#define CONFIRM_TOLERANCE_IN 0.015
#define READING_MAX_IN       2000.0 /* no caliper or runway gives a larger reading */

static const char *skip_space(const char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    return text;
}

static bool is_blank(const char *text)
{
    return *skip_space(text) == '\0';
}

static bool parse_number(const char *text, bool si, double *value_in, struct quantity_error *wrong)
{
    /* allow only digits, signs and separators: calipers do not write powers of ten */
    size_t digits = strspn(text, "+-.,0123456789");
    if (digits == 0 || toupper((unsigned char)text[digits]) == 'E')
        return false;
    return quantity_parse(text, "in", si ? "mm" : "in", value_in, wrong) &&
           fabs(*value_in) <= READING_MAX_IN;
}

void survey_entry_parse(const char *line, bool si, struct survey_entry *entry)
{
    static const struct {
        char letter;
        enum survey_entry_kind kind;
    } letters[] = {{'s', SURVEY_ENTRY_SKIP},
                   {'u', SURVEY_ENTRY_UNDO},
                   {'b', SURVEY_ENTRY_BACK},
                   {'q', SURVEY_ENTRY_QUIT},
                   {'?', SURVEY_ENTRY_HELP}};
    const char *text = skip_space(line);
    *entry = (struct survey_entry){.kind = SURVEY_ENTRY_INVALID, .value_in = (double)NAN};
    if (*text == '\0')
        entry->kind = SURVEY_ENTRY_EMPTY;
    else if (parse_number(text, si, &entry->value_in, &entry->error))
        entry->kind = SURVEY_ENTRY_NUMBER;
    else if (*text == 'n' && isspace((unsigned char)text[1]) && !is_blank(text + 1)) {
        entry->kind = SURVEY_ENTRY_NOTE;
        entry->note = skip_space(text + 1);
    }
    for (size_t i = 0; i < sizeof letters / sizeof letters[0]; i++) {
        if (*text == letters[i].letter && is_blank(text + 1))
            entry->kind = letters[i].kind;
    }
}

void survey_progress_init(struct survey_progress *progress, enum survey_edges edges)
{
    memset(progress, 0, sizeof *progress);
    survey_plan_init(&progress->plan, edges);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        progress->value_in[i] = progress->previous_in[i] = (double)NAN;
}

static void discard_reading(struct survey_progress *progress, size_t item)
{
    size_t kept = 0;
    for (size_t i = 0; i < progress->history_count; i++) {
        if (progress->history[i] != item)
            progress->history[kept++] = progress->history[i];
    }
    progress->history_count = kept;
}

/* Restores a stored reading when a survey resumes. NaN deletes the reading; `skipped` marks it as
 * skipped. Call survey_progress_move_to_next after the last one. */
static void survey_progress_restore(struct survey_progress *progress, size_t item, double value_in,
                                    bool skipped)
{
    discard_reading(progress, item);
    progress->value_in[item] = value_in;
    progress->is_skipped[item] = skipped;
    if (!isnan(value_in) || skipped)
        progress->history[progress->history_count++] = item;
}

void survey_progress_move_to_next(struct survey_progress *progress, size_t from)
{
    size_t count = progress->plan.count;
    progress->has_doubtful_value = false;
    for (size_t step = 0; step < count; step++) {
        size_t item = (from + step) % count;
        if (isnan(progress->value_in[item]) && !progress->is_skipped[item]) {
            progress->current_item = item;
            return;
        }
    }
    progress->current_item = count;
}

double survey_progress_expected_in(const struct survey_progress *progress, size_t item)
{
    return isnan(progress->previous_in[item]) ? get_item_nominal_in(&progress->plan.item[item])
                                              : progress->previous_in[item];
}

static enum survey_entry_outcome apply_number(struct survey_progress *progress, double value_in,
                                              size_t *item)
{
    size_t at = progress->current_item;
    if (at == progress->plan.count)
        return SURVEY_OUTCOME_REFUSED;
    double expected_in = survey_progress_expected_in(progress, at);
    /* false if there is no expected value (NaN) */
    bool beyond = fabs(value_in - expected_in) >
                  survey_item_limit_in(&progress->plan.item[at]) + 1e-9;
    bool again = progress->has_doubtful_value &&
                 fabs(value_in - progress->doubtful_value_in) <= CONFIRM_TOLERANCE_IN;
    *item = at;
    if (beyond && !again) {
        progress->has_doubtful_value = true;
        progress->doubtful_value_in = value_in;
        return SURVEY_OUTCOME_DOUBTFUL;
    }
    survey_progress_restore(progress, at, value_in, false);
    survey_progress_move_to_next(progress, at);
    return beyond ? SURVEY_OUTCOME_CONFIRMED : SURVEY_OUTCOME_STORED;
}

static enum survey_entry_outcome undo_last_reading(struct survey_progress *progress, size_t *item)
{
    if (progress
            /* undoing a doubtful reading, which is not stored yet, only discards it */
            ->has_doubtful_value) {
        progress->has_doubtful_value = false;
        return SURVEY_OUTCOME_ITEM_CHANGED;
    }
    if (progress->history_count == 0)
        return SURVEY_OUTCOME_REFUSED;
    *item = progress->history[progress->history_count - 1];
    survey_progress_restore(progress, *item, (double)NAN, false);
    progress->current_item = *item;
    return SURVEY_OUTCOME_UNDONE;
}

enum survey_entry_outcome survey_progress_apply(struct survey_progress *progress,
                                                const struct survey_entry *entry, size_t *item)
{
    *item = progress->current_item;
    switch (entry->kind) {
    case SURVEY_ENTRY_NUMBER: return apply_number(progress, entry->value_in, item);
    case SURVEY_ENTRY_SKIP:
        if (progress->current_item == progress->plan.count)
            return SURVEY_OUTCOME_REFUSED;
        survey_progress_restore(progress, progress->current_item, (double)NAN, true);
        survey_progress_move_to_next(progress, progress->current_item);
        return SURVEY_OUTCOME_SKIPPED;
    case SURVEY_ENTRY_UNDO: return undo_last_reading(progress, item);
    case SURVEY_ENTRY_BACK:
        if (progress->current_item == 0)
            return SURVEY_OUTCOME_REFUSED;
        progress->current_item--;
        progress->has_doubtful_value = false;
        return SURVEY_OUTCOME_ITEM_CHANGED;
    case SURVEY_ENTRY_NOTE:
        if (progress->history_count == 0)
            return SURVEY_OUTCOME_REFUSED;
        *item = progress->history[progress->history_count - 1];
        return SURVEY_OUTCOME_NOTED;
    default: return SURVEY_OUTCOME_REFUSED;
    }
}

size_t survey_progress_count_read(const struct survey_progress *progress)
{
    size_t read = 0;
    for (size_t i = 0; i < progress->plan.count; i++)
        read += isnan(progress->value_in[i]) ? 0u : 1u;
    return read;
}

/* ---- sheet ---- */

#define SHEET_LINE_BYTES_MAX 2000
#define SHEET_COLUMNS_MAX    32

enum column { COLUMN_KIND, COLUMN_LINE, COLUMN_PLACE, COLUMN_READING, COLUMN_NOTE, COLUMN_COUNT };

void survey_sheet_write(FILE *out, const struct survey_progress *progress, bool si)
{
    const struct unit *unit = unit_get(UNIT_DISPLACEMENT, si);
    fprintf(out, "kind,line,place,reading_%s,previous_%s,where,note\n", unit->suffix, unit->suffix);
    for (size_t i = 0; i < progress->plan.count; i++) {
        const struct survey_item *item = &progress->plan.item[i];
        char text[120];
        survey_item_format(item, si, text, sizeof text);
        fprintf(out, "%s,%u,%u,", survey_item_kind_text[item->kind], item->line, item->index);
        if (!isnan(progress->value_in[i]))
            fprintf(out, "%.4f", progress->value_in[i] * unit->factor);
        fputc(',', out);
        if (!isnan(progress->previous_in[i]))
            fprintf(out, "%.4f", progress->previous_in[i] * unit->factor);
        fprintf(out, ",\"%s\",\n", text);
    }
}

static bool read_whole_number(const char *text, unsigned *value)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    *value = (unsigned)number;
    return text[0] >= '0' && text[0] <= '9' && *end == '\0' && number < 1000;
}

static enum mr_status find_columns(const char *path, char **cell, size_t cells,
                                   int column[COLUMN_COUNT], bool *mm, struct error *error)
{
    static const char *const names[COLUMN_COUNT] = {"kind", "line", "place", "reading_in", "note"};
    for (int i = 0; i < COLUMN_COUNT; i++)
        column[i] = -1;
    for (size_t c = 0; c < cells; c++) {
        for (int i = 0; i < COLUMN_COUNT; i++)
            column[i] = strcmp(cell[c], names[i]) == 0 ? (int)c : column[i];
        if (strcmp(cell[c], "reading_mm") == 0) {
            column[COLUMN_READING] = (int)c;
            *mm = true;
        }
    }
    const char *separator = strpbrk(cell[0], ";\t");
    if (column[COLUMN_KIND] < 0 && separator)
        return error_set(error, MR_MALFORMED,
                         "columns separated by %s: %s, line 1; save the file with commas between "
                         "columns and decimal points",
                         *separator == ';' ? "semicolons" : "tabs", path);
    for (int i = 0; i < COLUMN_NOTE; i++) {
        if (column[i] < 0)
            return error_set(error, MR_MALFORMED,
                             "no column %s: %s, line 1; matrig survey DB --sheet writes a sheet "
                             "with the right columns",
                             names[i], path);
    }
    return MR_OK;
}

static enum mr_status parse_row(const char *path, size_t line, char **cell, size_t cells,
                                size_t names, const int column[COLUMN_COUNT], bool mm,
                                const struct survey_plan *plan, struct survey_sheet *sheet,
                                struct error *error)
{
    struct survey_item item;
    const char *text[COLUMN_COUNT];
    for (int i = 0; i < COLUMN_COUNT; i++)
        text[i] = column[i] >= 0 && column[i] < (int)cells ? cell[column[i]] : "";
    /* ignore the empty columns of a spreadsheet */
    while (cells > names && cell[cells - 1][0] == '\0')
        cells--;
    if (cells == 0)
        return error_set(error, MR_MALFORMED,
                         "a quote is not closed: %s, line %zu; add the closing quote", path, line);
    if (cells > names)
        return error_set(error, MR_MALFORMED,
                         "the line has more cells than there are column names: %s, line %zu; write "
                         "numbers with a decimal point, and text that contains a comma in quotes",
                         path, line);
    if (text[COLUMN_READING][0] == '\0')
        return MR_OK;
    int at = survey_item_kind_parse(text[COLUMN_KIND], &item.kind) &&
                     read_whole_number(text[COLUMN_LINE], &item.line) &&
                     read_whole_number(text[COLUMN_PLACE], &item.index)
               ? survey_plan_find(plan, &item)
               : -1;
    if (at < 0)
        return error_set(
            error, MR_MALFORMED,
            "no gage point '%s' %s %s: %s, line %zu; matrig survey DB --sheet lists all points",
            text[COLUMN_KIND], text[COLUMN_LINE], text[COLUMN_PLACE], path, line);
    if (!isnan(sheet->value_in[at]))
        return error_set(error, MR_MALFORMED,
                         "gage point %s %s %s occurs twice: %s, line %zu; leave one out",
                         text[COLUMN_KIND], text[COLUMN_LINE], text[COLUMN_PLACE], path, line);
    double value;
    struct quantity_error wrong = {"", ""};
    if (!quantity_parse(text[COLUMN_READING], "in", mm ? "mm" : "in", &value, &wrong) ||
        !(fabs(value) <= READING_MAX_IN))
        return error_set(
            error, MR_MALFORMED,
            "not a reading: '%s' of %s, line %zu; write a number, or leave the cell empty%s%s",
            text[COLUMN_READING], path, line, wrong.what[0] ? ": this is " : "", wrong.what);
    bool distance = item.kind == SURVEY_ITEM_GAP || item.kind == SURVEY_ITEM_DIAGONAL;
    if (distance &&
        /* the log of the ratio is 3.2 if a value in mm is taken as inches */
        fabs(log(fabs(value) / SURVEY_POINT_SPACING_IN)) > 2.0)
        return error_set(
            error, MR_MALFORMED,
            "impossible distance between gage points: '%s' of %s, line %zu; about 33.5 in or 851 "
            "mm is expected, so if the unit is different, name the column reading_%s",
            text[COLUMN_READING], path, line, mm ? "in" : "mm");
    sheet->value_in[at] = value;
    snprintf(sheet->note[at], SURVEY_NOTE_SIZE, "%.*s", (int)SURVEY_NOTE_SIZE - 1,
             text[COLUMN_NOTE]);
    sheet->reading_count++;
    return MR_OK;
}

enum mr_status survey_sheet_read(const char *path, const struct survey_plan *plan,
                                 struct survey_sheet *sheet, struct error *error)
{
    char line[SHEET_LINE_BYTES_MAX], *cell[SHEET_COLUMNS_MAX];
    int column[COLUMN_COUNT] = {0};
    bool mm = false;
    size_t names = 0;
    enum mr_status status = MR_OK;
    memset(sheet, 0, sizeof *sheet);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        sheet->value_in[i] = (double)NAN;
    if (output_check_file_format(path, "survey sheet", error) != MR_OK)
        return error->status;
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check the path and the permissions",
                         strerror(errno), path);
    for (size_t number = 1; status == MR_OK && fgets(line, sizeof line, file); number++) {
        if (!strchr(line, '\n') && !feof(file))
            status = error_set(error, MR_MALFORMED,
                               "line too long: %s, line %zu; give a survey sheet", path, number);
        else if (number == 1)
            status = find_columns(path, cell,
                                  names = csv_split(line + utf8_bom_length(line, strlen(line)), ',',
                                                    cell, SHEET_COLUMNS_MAX),
                                  column, &mm, error);
        else if (line[strspn(line, " \t\r\n")] != '\0')
            status = parse_row(path, number, cell, csv_split(line, ',', cell, SHEET_COLUMNS_MAX),
                               names, column, mm, plan, sheet, error);
    }
    if (status == MR_OK && ferror(file))
        status = error_set(error, MR_IO, "cannot read: %s; give the name of a file", path);
    fclose(file);
    if (status == MR_OK && sheet->reading_count == 0)
        status = error_set(error, MR_TOO_FEW, "no readings: %s; fill in the column reading_in",
                           path);
    return status;
}

/* ---- result ---- */

void survey_readings_init(struct survey_readings *readings)
{
    double *value = (double *)(void *)readings;
    for (size_t i = 0; i < offsetof(struct survey_readings, error_in) / sizeof *value; i++)
        value[i] = (double)NAN;
    readings->error_in = SURVEY_READING_ERROR_IN;
}

static double *survey_get_reading(struct survey_readings *r, const struct survey_item *item)
{
    unsigned l = item->line - 1, p = item->index;
    switch (item->kind) {
    case SURVEY_ITEM_GAP: return &r->gap_in[l][p];
    case SURVEY_ITEM_STATION: return &r->station_in[l][p];
    case SURVEY_ITEM_ACROSS: return &r->across_in[l][p];
    default: return &r->diagonal_in[l][p];
    }
}

/* The normal equations of a line are tridiagonal: a span connects two neighbouring points, a
 * station the two points around it. */
struct normal_equations {
    double diagonal[SURVEY_POINTS], off_diagonal[SURVEY_POINTS - 1], right_side[SURVEY_POINTS];
};

/* Adds the observation a u(k) + b u(k+1) = value. */
static void add_observation(struct normal_equations *n, unsigned k, double a, double b,
                            double value, double error)
{
    double w = 1.0 / (error * error);
    n->diagonal[k] += w * a * a;
    n->right_side[k] += w * a * value;
    if (k + 1 < SURVEY_POINTS) {
        n->diagonal[k + 1] += w * b * b;
        n->off_diagonal[k] += w * a * b;
        n->right_side[k + 1] += w * b * value;
    }
}

/* Solves by elimination from both ends up to point k, for each k. What then remains of the diagonal
 * element is the reciprocal variance of point k. */
static void solve_normal_equations(const struct normal_equations *n,
                                   struct survey_estimate out[SURVEY_POINTS])
{
    double down[SURVEY_POINTS], up[SURVEY_POINTS], down_right[SURVEY_POINTS],
        up_right[SURVEY_POINTS];
    unsigned last = SURVEY_POINTS - 1;
    down[0] = n->diagonal[0];
    down_right[0] = n->right_side[0];
    for (unsigned k = 1; k <= last; k++) {
        double factor = n->off_diagonal[k - 1] / down[k - 1];
        down[k] = n->diagonal[k] - factor * n->off_diagonal[k - 1];
        down_right[k] = n->right_side[k] - factor * down_right[k - 1];
    }
    up[last] = n->diagonal[last];
    up_right[last] = n->right_side[last];
    for (unsigned k = last; k-- > 0;) {
        double factor = n->off_diagonal[k] / up[k + 1];
        up[k] = n->diagonal[k] - factor * n->off_diagonal[k];
        up_right[k] = n->right_side[k] - factor * up_right[k + 1];
    }
    for (unsigned k = 0; k <= last; k++) {
        double pivot = down[k] + up[k] - n->diagonal[k];
        out[k].value_in = (down_right[k] + up_right[k] - n->right_side[k]) / pivot;
        out[k].error_in = sqrt(1.0 / pivot);
    }
}

/* Computes the movement of a line. `anchor`: u of the first point if the line has no stations.
 * Returns false if the line has no readings. */
static bool compute_line_movement(const struct survey_change *c, unsigned line,
                                  const struct survey_estimate *anchor,
                                  struct survey_estimate moved[SURVEY_POINTS])
{
    struct normal_equations n = {{0}, {0}, {0}};
    /* standard deviation of a uniform change within the range of the joints */
    const double unknown_in = SURVEY_SPAN_CHANGE_MAX_IN / sqrt(3.0);
    unsigned gaps = 0, stations = 0;
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double change_in = c->change.gap_in[line][k];
        gaps += isnan(change_in) ? 0u : 1u;
        add_observation(&n, k, -1.0, 1.0, isnan(change_in) ? 0.0 : change_in,
                        isnan(change_in) ? unknown_in : c->change.error_in);
    }
    for (unsigned s = 0; s < SURVEY_STATIONS; s++) {
        double change_in = c->change.station_in[line][s];
        double at = SURVEY_STATION_SPACING_FT * s / SURVEY_SPAN_LENGTH_FT;
        unsigned k = (unsigned)fmin(floor(at + 1e-6), SURVEY_POINTS - 1.0);
        if (isnan(change_in))
            continue;
        stations++;
        add_observation(&n, k, 1.0 - (at - k), at - k, change_in, c->station_error_in);
    }
    if (stations == 0)
        add_observation(&n, 0, 1.0, 0.0, anchor->value_in, fmax(anchor->error_in, 1e-6));
    solve_normal_equations(&n, moved);
    return gaps + stations > 0;
}

static struct survey_estimate compute_bow(const struct survey_change *c, unsigned point)
{
    struct survey_estimate bow = {(double)NAN, (double)NAN};
    const struct survey_estimate left = c->movement[0][point],
                                 right = c->movement[SURVEY_LINES - 1][point];
    for (unsigned line = 1; line + 1 < SURVEY_LINES; line++) {
        double part = (survey_line_offset_in(line + 1) - survey_line_offset_in(1)) /
                      (survey_line_offset_in(SURVEY_LINES) - survey_line_offset_in(1));
        const struct survey_estimate here = c->movement[line][point];
        double away_in = here.value_in - (1.0 - part) * left.value_in - part * right.value_in;
        /* the first value is always used: worst_bow is NaN at first */
        if (isnan(away_in) || fabs(away_in) <= fabs(bow.value_in))
            continue;
        bow.value_in = away_in;
        bow.error_in = sqrt(here.error_in * here.error_in + pow((1.0 - part) * left.error_in, 2) +
                            pow(part * right.error_in, 2));
    }
    return bow;
}

static void subtract_readings(const struct survey_readings *now,
                              const struct survey_readings *before, struct survey_change *c)
{
    const double *a = (const double *)(const void *)now, *b = (const double *)(const void *)before;
    double *d = (double *)(void *)&c->change;
    for (size_t i = 0; i < offsetof(struct survey_readings, error_in) / sizeof *d; i++) {
        d[i] = a[i] - b[i];
        c->compared_reading_count += isnan(d[i]) ? 0u : 1u;
    }
    c->change.error_in = sqrt(now->error_in * now->error_in + before->error_in * before->error_in);
    c->station_error_in = sqrt(2.0) * SURVEY_STATION_ERROR_IN;
}

void survey_compute_change(const struct survey_readings *now, const struct survey_readings *before,
                           struct survey_change *change)
{
    const struct survey_estimate held = {0.0, 0.0};
    memset(change, 0, sizeof *change);
    subtract_readings(now, before, change);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        const struct survey_estimate *anchor = line && !isnan(change->movement[0][0].value_in)
                                                 ? &change->movement[0][0]
                                                 : &held;
        if (compute_line_movement(change, line, anchor, change->movement[line]))
            continue;
        for (unsigned k = 0; k < SURVEY_POINTS; k++)
            change->movement[line][k] = (struct survey_estimate){(double)NAN, (double)NAN};
    }
    for (unsigned k = 0; k < SURVEY_POINTS; k++)
        change->bow[k] = compute_bow(change, k);
}

void survey_compute_slack(const struct survey_readings *now, double closed_in,
                          struct survey_slack *slack)
{
    memset(slack, 0, sizeof *slack);
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double sum = 0.0, squares = 0.0;
        unsigned lines = 0;
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            double value_in = fmax(now->gap_in[line][k] - closed_in, 0.0);
            if (isnan(now->gap_in[line][k]))
                continue;
            lines++;
            sum += value_in;
            squares += value_in * value_in;
        }
        double mean = lines ? sum / lines : (double)NAN;
        /* combines the errors of the readings with the differences between the lines */
        double scatter = lines > 1
                           ? fmax(squares - lines * mean * mean, 0.0) / (lines - 1.0) / lines
                           : 0.0;
        slack->line_count[k] = lines;
        slack->surveyed_segment_count += lines > 0;
        slack->segment[k].value_in = mean;
        slack->segment[k].error_in = lines ? fmax(sqrt(scatter), now->error_in / sqrt(lines))
                                           : (double)NAN;
    }
}

/* ---- campaign ---- */

/* Loads the readings of a survey by their place in the plan; NaN: not read, undone or skipped.
 * `survey` NULL: only the values are needed. */
static enum mr_status load_readings(struct store *store, int64_t id, const struct survey_plan *plan,
                                    double value_in[SURVEY_ITEMS_MAX], struct survey *survey,
                                    struct error *error)
{
    struct store_gage_reading *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_gage_readings_get(store, id, &rows, &count, error);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        value_in[i] = (double)NAN;
    for (size_t i = 0; i < count; i++) {
        struct survey_item item = {SURVEY_ITEM_KIND_COUNT, (unsigned)rows[i].line,
                                   (unsigned)rows[i].place};
        int at = survey_item_kind_parse(rows[i].kind, &item.kind) ? survey_plan_find(plan, &item)
                                                                  : -1;
        if (at < 0)
            continue; /* skip a reading that has no place in this plan */
        value_in[at] = rows[i].value_in;
        if (!survey)
            continue;
        survey_progress_restore(&survey->progress, (size_t)at, rows[i].value_in,
                                rows[i].skipped != 0);
        *survey_get_reading(&survey->readings, &item) = rows[i].value_in;
        survey->confirmed_readings += rows[i].confirmed != 0;
    }
    free(rows);
    return status;
}

/* Loads survey `i`, and the previous reading of each place. */
static enum mr_status load_survey_row(struct store *store, const struct store_gage_survey *rows,
                                      size_t i, struct survey *survey, struct error *error)
{
    const struct store_gage_survey *row = &rows[i];
    double value_in[SURVEY_ITEMS_MAX];
    enum survey_edges edges;
    enum mr_status status = MR_OK;
    if (!survey_edges_parse(row->edges, &edges))
        return error_set(error, MR_MALFORMED,
                         "survey %lld has unknown edges '%s': %s; the database is damaged, use a "
                         "different copy of the campaign",
                         (long long)row->id, row->edges, store_path(store));
    memset(survey, 0, sizeof *survey);
    survey->row = *row;
    survey_progress_init(&survey->progress, edges);
    survey_readings_init(&survey->readings);
    survey->readings.error_in = row->error_in;
    for (size_t k = 0; k < i && status == MR_OK; k++) {
        status = load_readings(store, rows[k].id, &survey->progress.plan, value_in, NULL, error);
        for (size_t at = 0; at < survey->progress.plan.count; at++)
            survey->progress.previous_in[at] = isnan(value_in[at])
                                                 ? survey->progress.previous_in[at]
                                                 : value_in[at];
    }
    if (status == MR_OK)
        status = load_readings(store, row->id, &survey->progress.plan, value_in, survey, error);
    size_t lasts = survey->progress.history_count; /* continue after the last reading */
    survey_progress_move_to_next(&survey->progress,
                                 lasts ? survey->progress.history[lasts - 1] : 0);
    return status;
}

/* Sets the error that no valid survey has this number; id 0: that there is no survey. */
static enum mr_status refuse_missing_survey(struct store *store, int64_t id,
                                            const struct store_gage_survey *rows, size_t count,
                                            struct error *error)
{
    struct store_withdrawal *withdrawn = NULL;
    size_t of = 0;
    bool is = false;
    enum mr_status status = store_withdrawals_get(store, &withdrawn, &of, error);
    for (size_t i = 0; i < of; i++)
        is = is || (strcmp(withdrawn[i].kind, "survey") == 0 && withdrawn[i].item == id);
    free(withdrawn);
    if (status != MR_OK)
        return status;
    const char *path = store_path(store);
    if (is)
        return error_set(error, MR_UNKNOWN,
                         "survey %lld was withdrawn: %s; matrig landing %s shows the reason",
                         (long long)id, path, path);
    if (count == 0)
        return error_set(error, MR_UNKNOWN, "no survey yet: %s; begin one with matrig survey %s",
                         path, path);
    return error_set(error, MR_UNKNOWN, "no survey %lld: %s; the campaign has surveys %lld to %lld",
                     (long long)id, path, (long long)rows[0].id, (long long)rows[count - 1].id);
}

enum mr_status survey_load(struct store *store, int64_t id, struct survey *survey,
                           struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0, i = 0;
    enum mr_status status = store_gage_surveys_get(store, &rows, &count, error);
    if (status == MR_OK && id == 0 && count)
        id = rows[count - 1].id;
    while (i < count && rows[i].id != id)
        i++;
    if (status == MR_OK && i == count)
        status = refuse_missing_survey(store, id, rows, count, error);
    if (status == MR_OK)
        status = load_survey_row(store, rows, i, survey, error);
    free(rows);
    return status;
}

enum mr_status survey_load_unfinished(struct store *store, struct survey *survey, bool *found,
                                      struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    *found = false;
    enum mr_status status = store_gage_surveys_get(store, &rows, &count, error);
    for (size_t i = count; i-- > 0 && status == MR_OK && !*found;) {
        if (rows[i].ended_us != STORE_NONE)
            continue;
        status = load_survey_row(store, rows, i, survey, error);
        *found = status == MR_OK;
    }
    free(rows);
    return status;
}

static void find_worst_bow(struct survey_results *found)
{
    found->worst_bow_in = found->worst_bow_error_in = found->worst_bow_station_ft = (double)NAN;
    for (unsigned k = 0; found->first_survey && k < SURVEY_POINTS; k++) {
        const struct survey_estimate *bow = &found->since_first.bow[k];
        if (isnan(bow->value_in) || fabs(bow->value_in) <= fabs(found->worst_bow_in))
            continue;
        found->worst_bow_in = bow->value_in;
        found->worst_bow_error_in = bow->error_in;
        found->worst_bow_station_ft = SURVEY_SPAN_LENGTH_FT * k;
    }
}

enum mr_status survey_evaluate(struct store *store, const struct survey *survey,
                               struct survey_results *found, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0, i = 0;
    memset(found, 0, sizeof *found);
    enum mr_status status = store_gage_surveys_get(store, &rows, &count, error);
    while (i < count && rows[i].id != survey->row.id)
        i++;
    if (status == MR_OK && i > 0 && i < count) {
        found->previous_survey = rows[i - 1].id;
        found->first_survey = rows[0].id;
    }
    free(rows);
    struct survey *other = xmalloc(sizeof *other);
    const int64_t against[2] = {found->previous_survey, found->first_survey};
    struct survey_change *const change[2] = {&found->since_previous, &found->since_first};
    for (int k = 0; k < 2 && status == MR_OK; k++) {
        if (against[k])
            status = survey_load(store, against[k], other, error);
        if (status == MR_OK && against[k])
            survey_compute_change(&survey->readings, &other->readings, change[k]);
    }
    free(other);
    survey_compute_slack(&survey->readings, survey->row.closed_in, &found->slack);
    find_worst_bow(found);
    return status;
}

enum mr_status survey_evaluate_between(struct store *store, int64_t from_us, int64_t to_us,
                                       struct survey_results *found, bool *exists,
                                       struct error *error)
{
    /* static instead of on the stack, because it takes tens of kilobytes */
    static struct survey survey;
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_gage_surveys_get(store, &rows, &count, error);
    *exists = false;
    for (size_t i = count; status == MR_OK && !*exists && i-- > 0;) {
        if (rows[i].made_us <= from_us || rows[i].made_us > to_us)
            continue;
        status = survey_load(store, rows[i].id, &survey, error)
                   ?: survey_evaluate(store, &survey, found, error);
        *exists = status == MR_OK && found->slack.surveyed_segment_count > 0;
    }
    free(rows);
    return status;
}

/* ---- text output ---- */

#define HALF_WIDTH_95_SIGMAS 1.96

void survey_format_time(int64_t host_us, char *out, size_t size)
{
    time_t seconds = (time_t)(host_us / 1000000);
    struct tm when;
    gmtime_r(&seconds, &when);
    if (host_us < SURVEY_EARLIEST_DATE_US)
        snprintf(out, size, "no date");
    else
        strftime(out, size, "%Y-%m-%d %H:%M UTC", &when);
}

const char *survey_describe_bow(const struct survey_results *found)
{
    double bow_in = fabs(found->worst_bow_in);
    if (isnan(bow_in))
        return "not known";
    if (bow_in > SURVEY_BOW_LIMIT_IN)
        return "beyond";
    return bow_in + HALF_WIDTH_95_SIGMAS * found->worst_bow_error_in > SURVEY_BOW_LIMIT_IN
             ? "perhaps beyond"
             : "within";
}
