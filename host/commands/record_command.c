/* The command matrig record: the crew's records of settings, inspections and notes.
 * host/store/records.def lists the kinds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/analyse/inspection.h"
#include "host/analyse/rig.h"
#include "host/base/assets.h"
#include "host/base/command.h"
#include "host/base/csv.h"
#include "host/base/html.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/xmalloc.h"
#include "host/commands/annotation.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/link/link.h"

#define WORDS_MAX (INSPECTION_FIELDS_MAX + 3)
#define CELLS_MAX 256 /* of a line of a sheet, with empty ones */

struct request {
    const char *words[WORDS_MAX]; /* DB [KIND] [PLACE] FIELD=VALUE... */
    const char *who, *reason, *csv, *path;
    int64_t correct, withdraw, compare, measure; /* 0: not given */
    bool kinds;
    /* the next fields are read from the words */
    const struct inspection_kind *kind; /* NULL: not given */
    const char *place; /* RUN, number of a mat or joint, or station; NULL: not given */
    const char *field[WORDS_MAX];
    size_t fields;
};

/* ---- kinds ---- */

static int list_kinds(const struct cli *cli)
{
    struct answer *answer = answer_new(false);
    char head[120], range[80];
    for (const struct inspection_kind *kind = inspection_kinds; kind->name; kind++) {
        const struct inspection_field *place = inspection_subject(kind);
        snprintf(head, sizeof head, "%s: %s%s%s (report %s)", kind->name, kind->description,
                 *place->name ? ", by " : "", *place->name ? place->description : "", kind->source);
        answer_open_group(answer, kind->name, head);
        for (const struct inspection_field *field = kind->field; field->name; field++) {
            const char *unit = inspection_get_unit(field, false);
            snprintf(range, sizeof range, "%g to %g%s%s", field->low, field->high, *unit ? " " : "",
                     unit);
            answer_add_text(answer, field->name, field->name, "%s: %s%s%s%s", field->description,
                            field->type == INSPECTION_NUMBER    ? range
                            : field->type == INSPECTION_CHOICE  ? field->choices
                            : field->type == INSPECTION_PICTURE ? "a file"
                            : field->type == INSPECTION_MARKS   ? "DISTANCE: X,Y X,Y X,Y [ERROR]"
                                                                : "a text",
                            field->is_copied_from_last ? ", kept" : "",
                            field->limit ? "; limit: " : "", field->limit ? field->limit : "");
        }
        answer_close_group(answer);
    }
    return answer_print(cli, answer, 0);
}

/* ---- adding ---- */

/* Sets what the record belongs to, according to its kind. */
static void read_place(const struct request *r, struct store *store, struct store_record *row,
                       struct error *error)
{
    const struct inspection_field *place = inspection_subject(r->kind);
    struct store_landing landing;
    struct estimate number;
    if (!*place->name != !r->place)
        error_set(error, MR_USAGE, "%s place: a record of %s needs %s; see matrig record --help",
                  r->place ? "unexpected" : "no", r->kind->name, place->description);
    else if (r->kind->place == INSPECTION_LANDING)
        (void)(parse_run(r->place, &row->run, error) ?: store_find_run(store, &row->run, error)
                   ?: store_landing_get(store, row->run, &landing, error));
    else if (r->place && inspection_parse_number(place, r->place, &number, error) == MR_OK &&
             number.error > 0.0)
        error_set(error, MR_USAGE, "a place has no standard error: '%s'; give only the number",
                  r->place);
    else if (r->place && error->status == MR_OK)
        row->place = number.value;
}

/* Clears a height that was measured in a picture which a correction replaces. */
static void clear_old_height(const struct inspection *old, json_t *values, struct answer *answer)
{
    const json_t *digest = json_object_get(values, "file_sha256");
    struct error none = {0};
    if (!json_is_string(digest) || json_object_get(values, "height_ft") ||
        !json_is_string(json_object_get(old->values, "height_ft_marks")) ||
        json_equal(digest, json_object_get(old->values, "file_sha256")))
        return;
    inspection_parse_field(old->kind, "height_ft=", values, &none);
    answer_add_sentence(answer, NULL,
                        "The height was measured in the old picture and is removed; measure it "
                        "again with --measure.");
}

/* Adds kept values to the record: from the newest record of its kind, of landing `run` or the
 * nearest landing before it. Reports them. */
static void copy_values_from_last(const struct inspections *all, const struct inspection_kind *kind,
                                  int64_t run, json_t *values, struct answer *answer)
{
    const struct inspection *last = inspection_find_newest(all, kind, run);
    char text[INSPECTION_TEXT_SIZE];
    if (!last)
        return;
    char *list;
    size_t length;
    FILE *out = xopen_memstream(&list, &length);
    answer_open_table(answer, "kept", "");
    for (const struct inspection_field *field = kind->field; field->name; field++) {
        if (!field->is_copied_from_last || !inspection_copy_value(field, last->values, values))
            continue;
        inspection_format_value(field, values, text);
        answer_open_row(answer);
        answer_add_text(answer, "field", NULL, "%s", field->name);
        answer_add_text(answer, "value", NULL, "%s", text);
        answer_add_count(answer, "record", NULL, last->row.id);
        fprintf(out, "%s %s=%s", ftell(out) ? "," : "", field->name, text);
    }
    answer_close_group(answer);
    fclose(out);
    if (length)
        answer_add_sentence(answer, NULL, "Kept from record %lld:%s.", (long long)last->row.id,
                            list);
    free(list);
}

static const struct inspection *find_valid_record(const struct request *r,
                                                  const struct inspections *all, int64_t id)
{
    const struct inspection *entry = all->entry, *end = entry + all->count, *now;
    while (entry < end && entry->row.id != id)
        entry++;
    for (now = entry; now < end && now->replaced_by;)
        now = now->replaced_by;
    if (now < end && now == entry && now->values)
        return entry;
    if (now < end && now->values)
        error_set(fatal, MR_UNKNOWN, "no valid record %lld: record %lld corrects it; give %lld",
                  (long long)id, (long long)now->row.id, (long long)now->row.id);
    error_set(fatal, MR_UNKNOWN, "no valid record %lld: %s; matrig record DB lists them",
              (long long)id, now < end ? "it is withdrawn" : r->words[0]);
    return NULL;
}

static enum mr_status add_record(const struct request *r, struct store *store,
                                 struct inspections *all, struct answer *answer,
                                 struct error *error)
{
    struct store_record row = store_blank_record;
    const struct inspection_kind *kind = r->kind;
    const int64_t id = r->correct ? r->correct : r->withdraw;
    const struct inspection *old = id ? find_valid_record(r, all, id) : NULL;
    json_t *values = json_object();
    if (old) {
        kind = old->kind;
        row.run = old->row.run;
        row.place = old->row.place;
        row.corrects = old->row.id;
    } else
        read_place(r, store, &row, error);
    const char *place = inspection_subject(kind)->name;
    for (size_t i = 0; i < r->fields && error->status == MR_OK; i++) {
        if (old && *place && strcspn(r->field[i], "=") == strlen(place) &&
            strncasecmp(r->field[i], place, strlen(place)) == 0)
            error_set(
                error, MR_USAGE,
                "the %s of a record cannot be corrected; add a new record, then matrig record "
                "DB --withdraw %lld --reason TEXT",
                place, (long long)id);
        else
            inspection_parse_field(kind, r->field[i], values, error);
    }
    if (old)
        clear_old_height(old, values, answer);
    for (const struct inspection_field *field = kind->field; old && field->name; field++)
        inspection_copy_value(field, old->values, values);
    if (!old && !r->csv && error->status == MR_OK)
        copy_values_from_last(all, kind, row.run, values, answer);
    row.made_us = (int64_t)link_now_us();
    annotation_copy(row.kind, sizeof row.kind, kind->name);
    annotation_copy(row.who, sizeof row.who, annotation_author(r->who));
    annotation_copy(row.reason, sizeof row.reason, r->reason);
    if (error->status == MR_OK)
        inspection_add(store, all, &row, r->withdraw ? NULL : values, error);
    json_decref(values);
    return error->status;
}

/* ---- CSV: a line for each valid record, with fields as they are typed ---- */

static void write_csv(const struct request *r, const struct inspections *all, int64_t run)
{
    const struct inspection_kind *kind = r->kind;
    const char *place = inspection_subject(kind)->name;
    struct output output;
    output_check(r->path, r->words[0], fatal);
    output_begin(&output, r->path, fatal);
    for (size_t i = 0; i <= all->count; i++) { /* line 0 has the names of the columns */
        const struct inspection *entry = i ? &all->entry[i - 1] : NULL;
        char text[INSPECTION_TEXT_SIZE];
        if (entry && !inspection_is_valid(entry, kind, run))
            continue;
        if (*place && entry)
            fprintf(output.file, "%.15g,",
                    kind->place == INSPECTION_LANDING ? (double)entry->row.run : entry->row.place);
        else if (*place)
            fprintf(output.file, "%s,", place);
        for (const struct inspection_field *field = kind->field; field->name; field++) {
            if (entry)
                inspection_format_value(field, entry->values, text);
            csv_write_cell(output.file, entry ? text : field->name);
            fputc(field[1].name ? ',' : '\n', output.file);
        }
    }
    output_end(&output, fatal);
}

/* Fails for a line with a NUL or a carriage return before its end, where text would be lost. */
static void check_line(const struct request *r, const char *line, size_t length, size_t number)
{
    const char *end = line + strcspn(line, "\r\n");
    if (strlen(line) != length || end[strspn(end, "\r\n")])
        error_set(
            fatal, MR_MALFORMED,
            "%s, line %zu: a NUL or carriage return inside the line; save the sheet as CSV in "
            "UTF-8, with a line feed after each line",
            r->csv, number);
}

/* Splits a line of a sheet. Spreadsheets may add empty cells, which are left out beyond `least`. */
static size_t split_line(char *line, char separator, char *cell[CELLS_MAX], size_t least)
{
    size_t cells = csv_split(line, separator, cell, CELLS_MAX);
    while (cells > least && !cell[cells - 1][0])
        cells--;
    return cells;
}

/* Reads a CSV file, whose first line has the names of the columns and the separator. Each other
 * line is a record to be added. */
static void read_csv(const struct request *r, struct store *store, struct inspections *all,
                     struct answer *answer)
{
    static char text[WORDS_MAX][4096];
    char *line = NULL, *header = NULL, *head[CELLS_MAX], *cell[CELLS_MAX], separator = ',';
    size_t room = 0, columns = 0;
    ssize_t length;
    bool has_place = !*inspection_subject(r->kind)->name;
    const char *place = inspection_subject(r->kind)->name;
    json_t *names = json_object();
    struct error error = {0};
    output_check_file_format(r->csv, "sheet of records", fatal);
    FILE *in = fopen(r->csv, "r");
    if (!in)
        error_set(fatal, MR_IO, "cannot open: %s; check the path", r->csv);
    if ((length = getline(&header, &room, in)) >= 0) {
        check_line(r, header, (size_t)length, 1);
        const char *first = strpbrk(header, ",;\t");
        separator = first ? *first : ',';
        columns = split_line(header + utf8_bom_length(header, strlen(header)), separator, head, 1);
    }
    for (size_t c = 0; c < columns; c++) {
        const bool is_place = strcasecmp(head[c], place) == 0;
        snprintf(text[0], sizeof text[0], "%.60s=", head[c]);
        if (!is_place && inspection_parse_field(r->kind, text[0], names, &error) != MR_OK)
            error_set(fatal, error.status, "%s, line 1: %s; the first line names the columns",
                      r->csv, error.text);
        has_place |= is_place;
        for (size_t other = 0; other < c; other++)
            if (strcasecmp(head[c], head[other]) == 0)
                error_set(fatal, MR_MALFORMED, "%s, line 1: two columns %s; give only one", r->csv,
                          head[c]);
    }
    if (columns && !has_place)
        error_set(fatal, MR_MALFORMED,
                  "%s, line 1: no column %s; add it, and write the place of each record in it",
                  r->csv, place);
    room = 0;
    for (size_t number = 2; (length = getline(&line, &room, in)) >= 0; number++) {
        struct request one = *r;
        check_line(r, line, (size_t)length, number);
        if (!line[strspn(line, ",;\t\r\n ")])
            continue;
        size_t cells = split_line(line, separator, cell, columns);
        if (cells == 0)
            error_set(&error, MR_MALFORMED, "a quote is not closed; write each record on one line");
        else if (cells != columns)
            error_set(&error, MR_MALFORMED,
                      "the header has %zu cells and this line %zu; quote a text that has '%c'",
                      columns, cells, separator);
        for (size_t c = 0; c < columns && error.status == MR_OK; c++) {
            if (strcasecmp(head[c], place) == 0)
                one.place = cell[c];
            else if (cell[c][0]) {
                const bool is_path = strcasecmp(head[c], "file") == 0 && cell[c][0] != '/';
                snprintf(text[c], sizeof text[c], "%.60s=%s%s", head[c], is_path ? all->folder : "",
                         cell[c]);
                one.field[one.fields++] = text[c];
            }
        }
        if (error.status == MR_OK)
            add_record(&one, store, all, answer, &error);
        if (error.status != MR_OK)
            error_set(fatal, error.status, "%s, line %zu: %s", r->csv, number, error.text);
    }
    fclose(in);
    json_decref(names);
    free(line);
    free(header);
}

/* ---- heights in a picture ---- */

/* Writes a page that shows the picture of a record at full resolution. A script on the page makes a
 * command from the marks that the user sets. */
static void write_marks_page(const struct request *r, const struct inspections *all)
{
    const struct inspection *entry = find_valid_record(r, all, r->measure);
    const struct asset *page = asset_find("/picture.html");
    struct output output;
    char *path = inspection_find_picture(all, entry, fatal);
    output_check(r->path, path, fatal);
    output_begin(&output, r->path, fatal);
    fwrite(page->bytes, 1, (size_t)(page->end - page->bytes), output.file);
    fputs("<svg id=\"picture\" data-file=\"", output.file);
    html_write_text(output.file, path);
    fputs("\" data-campaign=\"", output.file);
    html_write_text(output.file, r->words[0]);
    fprintf(output.file, "\" data-record=\"%lld\"></svg>\n", (long long)r->measure);
    output_end(&output, fatal);
    free(path);
}

/* ---- the command ---- */

static void parse_words(struct request *r)
{
    for (size_t i = 1; i < WORDS_MAX && r->words[i]; i++) {
        const char *word = r->words[i];
        const bool is_kind = !r->kind && !strchr("0123456789.+", word[0]) &&
                             strncmp(word, "landing", 7) != 0;
        if (strchr(word, '='))
            r->field[r->fields++] = word;
        else if (is_kind)
            inspection_kind_find(word, &r->kind, fatal);
        else if (!r->place)
            r->place = word;
        else
            error_set(fatal, MR_USAGE,
                      "unexpected argument: '%s' of record; quote a FIELD=VALUE that has blanks",
                      word);
    }
}

static void check_request(const struct request *r)
{
    const int acts = (r->correct != 0) + (r->withdraw != 0) + (r->compare != 0) + (r->csv != NULL) +
                     (r->path || r->measure);
    const struct {
        bool is_wrong;
        const char *message;
    } checks[] = {
        {!r->words[0], "argument missing: matrig record needs DB"},
        {acts > 1 || (r->fields && acts && !r->correct),
         "more than one action: give fields, --correct, --withdraw, --measure, --compare, --csv or "
         "-o"},
        {r->measure && !r->path, "no file for the page: give --measure N -o F.html"},
        {(r->correct || r->withdraw) && !r->reason,
         "no reason: a correction or withdrawal needs --reason TEXT"},
        {r->reason && strlen(r->reason) >= STORE_JOURNAL_TEXT_SIZE,
         "reason too long: give fewer characters"},
        {r->reason && !text_is_plain(r->reason), "not a text: give one line of UTF-8 for --reason"},
        {!r->kind && !r->correct && !r->measure && (r->fields || r->csv || r->path),
         "no kind: give matrig record DB KIND; matrig record --kinds lists the kinds"},
        {r->compare && r->kind, "unexpected KIND: --compare compares the records of all kinds"},
        {r->compare && !r->place, "one landing only: give matrig record DB --compare RUN RUN"},
        {r->correct && !r->fields, "no field: --correct N needs FIELD=VALUE"},
        {(r->correct || r->withdraw) && (r->kind || r->place),
         "unexpected KIND or PLACE: --correct and --withdraw need the number of the record only, "
         "and "
         "a place cannot be corrected"},
        {r->kind && r->place && (r->csv || (r->path && r->kind->place != INSPECTION_LANDING)),
         "unexpected PLACE: a sheet names the place of each record"},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++)
        if (checks[i].is_wrong)
            error_set(fatal, MR_USAGE, "%s; see matrig record --help", checks[i].message);
}

/* `place`: of a mat, joint or station; NaN: all places. */
static void show_records(const struct cli *cli, const struct request *r,
                         const struct inspections *all, int64_t run, double place,
                         struct answer *answer)
{
    struct inspections shown = *all;
    shown.entry = xcalloc(all->count + 1, sizeof *all->entry);
    shown.count = 0;
    for (size_t i = 0; i < all->count; i++)
        if ((!r->kind || all->entry[i].kind == r->kind) && (!run || all->entry[i].row.run == run) &&
            !(fabs(all->entry[i].row.place - place) > 0.0))
            shown.entry[shown.count++] = all->entry[i];
    if (shown.count == 0)
        cli_note(cli,
                 all->count ? "no record matches: %s; matrig record DB lists all"
                            : "no records yet: %s; matrig record --kinds lists the kinds",
                 r->words[0]);
    inspection_add_json(&shown, r->kind, run, answer);
    for (const struct inspection_kind *kind = inspection_kinds; kind->name; kind++)
        inspection_add_table(&shown, kind, run, 0, answer);
    for (size_t i = 0; i < shown.count; i++) {
        const struct inspection *entry = &shown.entry[i];
        struct error error = {0};
        if (inspection_is_valid(entry, NULL, 0) && json_object_get(entry->values, "file")) {
            free(inspection_find_picture(all, entry, &error));
            if (error.status != MR_OK)
                answer_add_sentence(answer, NULL, "Record %lld: %s.", (long long)entry->row.id,
                                    error.text);
        }
    }
    free(shown.entry);
}

/* Names later records with the old value of a corrected field, which they may have kept. */
static void show_later_copies(const struct inspections *all, struct answer *answer)
{
    const struct inspection *now = &all->entry[all->count - 1];
    char *list;
    size_t length;
    FILE *out = xopen_memstream(&list, &length);
    for (const struct inspection *entry = all->entry; entry < now; entry++) {
        bool is_later = entry->row.run > now->row.run ||
                        (entry->row.run == now->row.run && entry->origin > now->origin);
        const struct inspection_field *field = now->kind->field;
        for (; is_later && inspection_is_valid(entry, now->kind, 0) && field->name; field++) {
            const json_t *old = json_object_get(now->corrected->values, field->name);
            if (field->is_copied_from_last &&
                json_equal(json_object_get(entry->values, field->name), old) &&
                !json_equal(json_object_get(now->values, field->name), old))
                fprintf(out, "%s %s in record %lld", ftell(out) ? "," : "", field->name,
                        (long long)entry->row.id);
        }
    }
    fclose(out);
    if (length)
        answer_add_sentence(answer, NULL, "Later records still have the old value:%s.", list);
    free(list);
}

static void show_added_records(const struct inspections *all, size_t before, struct answer *answer)
{
    const struct inspection *last = &all->entry[all->count - 1];
    enum inspection_verdict worst = INSPECTION_NO_LIMIT;
    for (size_t i = before; i < all->count; i++)
        if (inspection_check_limits(&all->entry[i]) > worst)
            worst = inspection_check_limits(&all->entry[i]);
    if (worst > INSPECTION_PASS)
        inspection_add_table(all, last->kind, 0, before, answer);
    answer_add_count(answer, "added", "records added", (int64_t)(all->count - before));
    answer_add_count(answer, "record", "record", last->row.id);
    if (worst != INSPECTION_NO_LIMIT)
        answer_add_text(answer, "result", all->count - before > 1 ? "worst result" : "result", "%s",
                        inspection_verdict_text(worst));
}

static int record_command(int argc, char **argv, const struct cli *cli)
{
    static struct request r;
    struct inspections all;
    struct store_landing landing;
    struct store_record at = store_blank_record;
    int64_t run = 0;
    command_parse(&command_record, argc, argv, cli, &r, r.words, fatal);
    if (r.kinds)
        return list_kinds(cli);
    parse_words(&r);
    check_request(&r);
    const bool adds = r.fields || r.withdraw || r.csv, begins = adds && !r.correct && !r.withdraw;
    struct answer *answer = answer_new(cli->si);
    /* a campaign may be created here, because mats are accepted before the first landing */
    struct store *store = begins && r.kind->place != INSPECTION_LANDING
                            ? program_open_or_create_campaign(cli, r.words[0])
                            : program_open_campaign(r.words[0], adds ? STORE_OPEN : STORE_READ);
    if (r.place && !adds && r.kind && r.kind->place != INSPECTION_LANDING)
        read_place(&r, store, &at, fatal);
    else if (r.place && !adds)
        parse_run(r.place, &run, fatal);
    store_find_run(store, &run, fatal);
    store_find_run(store, &r.compare, fatal);
    if (run)
        store_landing_get(store, run, &landing, fatal);
    if (adds)
        store_begin(store, fatal);
    inspection_load(store, &all, fatal);
    const size_t before = all.count;
    if (r.csv)
        read_csv(&r, store, &all, answer);
    else if (adds)
        add_record(&r, store, &all, answer, fatal);
    else if (r.measure)
        write_marks_page(&r, &all);
    else if (r.path)
        write_csv(&r, &all, run);
    else if (!r.compare)
        show_records(cli, &r, &all, run, at.place, answer);
    else if (inspection_add_differences(store, &all, false, r.compare, run, answer, fatal) == 0)
        answer_add_sentence(answer, NULL,
                            inspection_has_valid_record(&all, NULL, run)
                                ? "The records of RUN %lld and RUN %lld do not differ."
                                : "Neither RUN %lld nor RUN %lld has a record.",
                            (long long)r.compare, (long long)run);
    if (adds) {
        store_commit(store, fatal);
        if (all.count == before)
            error_set(fatal, MR_MALFORMED, "no records: %s; its first line names the columns",
                      r.csv);
        show_added_records(&all, before, answer);
        if (r.correct)
            show_later_copies(&all, answer);
    }
    inspection_free(&all);
    return answer_print(cli, answer, 0);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB [KIND] [PLACE]",
              "campaign database; kind of record; place: depending on the kind a RUN, the number "
              "of a mat "
              "or joint, a station in ft, or none. Without fields, the records are listed"),
    HELP_ITEM("FIELD=VALUE",
              "add a record. A number may have a unit and a standard error: slack_in='0.9 mm +- "
              "0.1 mm'. A field marked kept (see --kinds) defaults to its last value, for a RUN to "
              "that of the nearest earlier one; FIELD= leaves it empty"),
    OPTION_FLAG("--kinds", kinds, "list kinds and fields, with units, ranges and limits"),
    OPTION_INTEGER("--correct", "N", correct, 1.0, 1e15, 0.0,
                   "change fields of record N; FIELD= removes one. Needs --reason"),
    OPTION_INTEGER("--withdraw", "N", withdraw, 1.0, 1e15, 0.0,
                   "withdraw record N; needs --reason. Old values stay in the campaign"),
    OPTION_RUN("--compare", "RUN", compare,
               "list the differences between the records of two landings"),
    OPTION_INTEGER("--measure", "N", measure, 1.0, 1e15, 0.0,
                   "write a web page with the picture of record N (-o F.html). There you mark two "
                   "points of known distance and a third point; the page prints the command that "
                   "records the height of the third point with its error"),
    OPTION_TEXT("--csv", "F.csv", csv,
                "add records from a file: its first line names place and fields, as "
                "in a file that -o wrote"),
    OPTION_TEXT("-o", "F.csv or .html", path,
                "file for the records of KIND, or for the page of --measure"),
    OPTION_TEXT("--who", "W", who, "author; default: the user"),
    HELP_EXAMPLE("matrig record campaign.db mat 12 joint_lb_in=12.5+-0.4 slack_in=0.031"),
    OPTION_TEXT("--reason", "T", reason, NULL),
};

const struct command command_record = {
    "record",
    record_command,
    "DB [KIND] [PLACE] [FIELD=VALUE ...] [--who W]\nDB --correct N FIELD=VALUE ... --reason T\nDB "
    "--withdraw N --reason T\nDB --measure N -o F.html\nDB --compare RUN RUN\nDB KIND --csv F | -o "
    "F\n--kinds",
    "record run conditions, tests of subgrade and mats, damage, launch and pictures",
    COMMAND_PARTS(parts),
    {0, WORDS_MAX, "DB"},
};
