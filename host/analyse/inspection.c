#include "host/analyse/inspection.h"

#include <ctype.h>
#include <math.h>
#include <sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "common/decimal.h"
#include "host/analyse/rig.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/spell_suggest.h"
#include "host/base/xmalloc.h"

#define DEGREE "\xc2\xb0"
/* Head of a loop over all records. */
#define FOR_EACH(item, all)                       \
    const struct inspection *item = (all)->entry; \
    item < (all)->entry + (all)->count;           \
    item++

/* ---- the kinds ---- */

#define LAST     true
#define NEW      false
#define NO_LIMIT (double)NAN
/* clang-format off */
const struct inspection_kind inspection_kinds[] = {
#define KIND(kind, place, words, source) \
    {#kind, words, source, INSPECTION_##place, (const struct inspection_field[]){
#define FIELD(kind, field, value, last, text, ...) \
    {.name = #field, .description = text, .type = INSPECTION_##value, .is_copied_from_last = last, \
     __VA_ARGS__},
#define KIND_END(kind) {.name = NULL}}},
#include "host/store/records.def"
    {.name = NULL}};
/* clang-format on */

static enum mr_status set_unknown_name_error(const struct spell_suggest *near, const char *what,
                                             const char *where, const char *advice,
                                             struct error *error)
{
    char text[SPELL_SUGGEST_TEXT_SIZE];
    spell_suggest_text(near, text);
    return error_set(error, MR_UNKNOWN, "%s: '%s' for %s%s%s %s", what, near->word, where, text,
                     text[0] ? "" : ";", advice);
}

enum mr_status inspection_kind_find(const char *name, const struct inspection_kind **kind,
                                    struct error *error)
{
    struct spell_suggest near;
    spell_suggest_begin(&near, name);
    for (*kind = inspection_kinds; (*kind)->name; ++*kind)
        if (spell_suggest_add(&near, (*kind)->name))
            return MR_OK;
    return set_unknown_name_error(&near, "unknown kind", "a record",
                                  "matrig record --kinds lists the kinds", error);
}

const struct inspection_field *inspection_subject(const struct inspection_kind *kind)
{
    static const struct inspection_field places[] = {
        {.name = "", .description = "no place"},
        {.name = "run", .description = "RUN"},
        {"mat", "the number of the mat", .is_integer = true, .low = 1.0, .high = RIG_MATS},
        {"joint", "the number of the joint", .is_integer = true, .low = 1.0, .high = RIG_MATS},
        {"station_ft", "the station in ft", .high = RIG_RUNWAY_FT}};
    return &places[kind->place];
}

bool inspection_is_single(const struct inspection_kind *kind)
{
    return kind->place == INSPECTION_LANDING && kind->field[0].is_copied_from_last;
}

static bool is_temperature(const struct inspection_field *field)
{
    return strcmp(quantity_unit_from_name(field->name), "F") == 0;
}

const char *inspection_get_unit(const struct inspection_field *field, bool si)
{
    const char *unit = quantity_unit_from_name(field->name);
    const struct quantity_kind *kind = quantity_kind_find(unit);
    if (field->type != INSPECTION_NUMBER || !*unit)
        return "";
    if (is_temperature(field))
        return si ? DEGREE "C" : DEGREE "F";
    if (si && strcmp(unit, "in2") == 0)
        return "cm2";
    for (enum unit_kind of = 0; si && of < UNIT_KIND_COUNT; of++)
        if (strcmp(unit_get(of, false)->text, unit) == 0)
            return unit_get(of, true)->text;
    return si && kind && kind->si_unit && strcmp(unit, "deg") != 0 ? kind->si_unit : unit;
}

/* ---- values ---- */

struct estimate inspection_get_number(const json_t *values, const char *name)
{
    char key[80];
    const json_t *value = json_object_get(values, name);
    snprintf(key, sizeof key, "%s_error", name);
    return (struct estimate){json_is_number(value) ? json_number_value(value) : (double)NAN,
                             json_number_value(json_object_get(values, key))};
}

void inspection_format_value(const struct inspection_field *field, const json_t *values,
                             char out[INSPECTION_TEXT_SIZE])
{
    const char *text = json_string_value(json_object_get(values, field->name));
    struct estimate n = inspection_get_number(values, field->name);
    snprintf(out, INSPECTION_TEXT_SIZE, "%s", text ? text : "");
    text_blank_controls(out);
    if (!isnan(n.value))
        snprintf(out, INSPECTION_TEXT_SIZE, n.error > 0.0 ? "%.15g+-%.15g" : "%.15g", n.value,
                 n.error);
}

/* Reads a quantity. Temperatures are converted here, because their scales also differ in the zero.
 * `is_value`: the number is a temperature and not its standard error. A converted number is rounded
 * to 9 digits, for legibility. */
static enum mr_status read_quantity(const struct inspection_field *field, const char *text,
                                    bool is_value, double *value, struct error *error)
{
    const char *end;
    double number = mr_decimal_parse(text, &end);
    const char *unit = end + strspn(end, " deg" DEGREE);
    char rounded[40];
    if (!is_temperature(field)) {
        const char *own = quantity_unit_from_name(field->name);
        *value = number;
        enum mr_status status = quantity_read(text, field->name, own, NULL, value, error);
        snprintf(rounded, sizeof rounded, "%.9g", *value);
        if (status == MR_OK && fabs(*value - number) > 0.0)
            *value = mr_decimal_parse(rounded, &end);
        return status;
    }
    const int letter = toupper((unsigned char)unit[0]);
    if (end == text || (letter && (unit[1] || !strchr("FCK", letter))))
        return error_set(error, MR_USAGE,
                         "not a temperature: '%s' for %s; give a number with F, C or K", text,
                         field->name);
    const double zero_f = letter == 'C' ? 32.0 : -459.67;
    *value = letter == 'C' || letter == 'K' ? 1.8 * number + (is_value ? zero_f : 0.0) : number;
    return MR_OK;
}

/* Reads a number with its standard error, such as "12.3+-0.4 lb/in"; a unit after one number
 * applies to both. */
enum mr_status inspection_parse_number(const struct inspection_field *field, const char *text,
                                       struct estimate *number, struct error *error)
{
    char part[2][120];
    const char *unit[2], *own = quantity_unit_from_name(field->name);
    const char *sign = strstr(text, "+-") ?: strstr(text, "\xc2\xb1") ?: strstr(text, "+/-");
    if (strlen(text) >= 60)
        return error_set(error, MR_USAGE,
                         "the value of %s is too long: '%.40s...'; give a number and its unit",
                         field->name, text);
    snprintf(part[0], 60, "%.*s", sign ? (int)(sign - text) : 59, text);
    snprintf(part[1], 60, "%s", sign ? sign + 2 + (sign[1] == '/') : "0");
    for (int i = 0; i < 2; i++) {
        for (char *tab = part[i]; (tab = strchr(tab, '\t'));)
            *tab = ' ';
        for (size_t end = strlen(part[i]); end > 0 && part[i][end - 1] == ' ';)
            part[i][--end] = '\0';
        mr_decimal_parse(part[i], &unit[i]);
    }
    if (!strchr("0123456789.", part[1][strspn(part[1], " ")]) || !part[1][0] ||
        (strchr(unit[1], '%') && strcmp(own, "%") != 0))
        return error_set(error, MR_USAGE,
                         "not a standard error: '%s' for %s; give a number of 0 or more%s%s, such "
                         "as 12.5+-0.4",
                         part[1], field->name, *own ? " in " : "", own);
    for (int i = 0; i < 2; i++)
        if (!unit[i][strspn(unit[i], " ")])
            snprintf(strchr(part[i], '\0'), 60, "%s", unit[!i]);
    if (read_quantity(field, part[0], true, &number->value, error) != MR_OK ||
        read_quantity(field, part[1], false, &number->error, error) != MR_OK)
        return error->status;
    if (field->is_integer && (number->value != floor(number->value) || number->error > 0.0))
        return error_set(error, MR_USAGE, "not a whole number: %s for %s", text, field->name);
    if (!(number->value >= field->low && number->value <= field->high))
        return error_set(error, MR_USAGE, "out of range: %s for %s; allowed: %g to %g %s", text,
                         field->name, field->low, field->high, inspection_get_unit(field, false));
    return MR_OK;
}

static void set_number(const struct inspection_field *field, struct estimate number, json_t *values)
{
    char key[80];
    snprintf(key, sizeof key, "%s_error", field->name);
    json_object_set_new(values, field->name, json_real(number.value));
    json_object_set_new(values, key, number.error > 0.0 ? json_real(number.error) : json_null());
}

/* `field`: the field of the height, to which the marks belong. */
static enum mr_status read_marks(const struct inspection_field *field, const char *text,
                                 json_t *values, struct error *error)
{
    static const struct inspection_field distance_ft = {"distance_ft", .low = 1e-3, .high = 1e3};
    struct rig_marks m = {.error = 1.0};
    struct estimate distance, height;
    char length[60];
    int end = 0;
    if (sscanf(text, "%59[^:]: %lf,%lf %lf,%lf %lf,%lf %n%lf %n", length, &m.x[0], &m.y[0], &m.x[1],
               &m.y[1], &m.x[2], &m.y[2], &end, &m.error, &end) < 7 ||
        text[end])
        return error_set(error, MR_USAGE,
                         "not a list of marks: '%s' for %s; give DISTANCE: X,Y X,Y X,Y [ERROR]",
                         text, field->name);
    if (inspection_parse_number(&distance_ft, length, &distance, error) != MR_OK ||
        rig_measure_height(&m, distance, &height, error) != MR_OK)
        return error->status;
    set_number(field, height, values);
    json_object_set_new(values, field[1].name, json_string(text));
    return MR_OK;
}

const char *inspection_picture_format(const char *path)
{
    static const struct {
        const char *format;
        size_t at, length;
        const char *bytes;
    } formats[] = {{"png", 0, 8, "\x89PNG\r\n\x1a\n"},
                   {"jpeg", 0, 3, "\xff\xd8\xff"},
                   {"tiff", 0, 4, "II*"},
                   {"tiff", 0, 4, "MM\0*"},
                   {"gif", 0, 4, "GIF8"},
                   {"webp", 8, 4, "WEBP"},
                   {"heic", 4, 6, "ftyphe"},
                   {"heic", 4, 8, "ftypmif1"}};
    char bytes[16] = "";
    FILE *file = fopen(path, "rb");
    const size_t count = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file)
        fclose(file);
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (count >= formats[i].at + formats[i].length &&
            memcmp(bytes + formats[i].at, formats[i].bytes, formats[i].length) == 0)
            return formats[i].format;
    return NULL;
}

/* Computes the SHA-256 of a regular file; false: it cannot be read. */
static bool compute_digest(const char *path, char digest[SHA256_DIGEST_STRING_LENGTH])
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) && SHA256File(path, digest);
}

static enum mr_status read_picture(const struct inspection_field *field, const char *text,
                                   json_t *values, struct error *error)
{
    char digest[SHA256_DIGEST_STRING_LENGTH], *path = realpath(text, NULL);
    if (!path || !compute_digest(path, digest))
        error_set(error, MR_IO, "cannot read %s (given for %s); check the path", text, field->name);
    else if (!inspection_picture_format(path))
        error_set(
            error, MR_MALFORMED,
            "not a picture: %s (given for %s); give a PNG, JPEG, TIFF, GIF, WebP or HEIC file",
            text, field->name);
    else {
        json_object_set_new(values, field->name, json_string(path));
        json_object_set_new(values, field[1].name, json_string(digest));
    }
    free(path);
    return error->status;
}

static enum mr_status read_text(const struct inspection_field *field, const char *text,
                                json_t *values, struct error *error)
{
    char advice[240];
    struct spell_suggest near;
    const char *was = json_string_value(json_object_get(values, field->name));
    const bool is_other = !was || strcmp(was, text) != 0;
    if (strlen(text) >= INSPECTION_TEXT_SIZE - 40 || !text_is_plain(text))
        return error_set(error, MR_USAGE,
                         "the value of %s is not one line of text; give one line of at most %d "
                         "characters in UTF-8, not only blanks",
                         field->name, INSPECTION_TEXT_SIZE - 41);
    json_object_set_new(values, field->name, json_string(text));
    if (field->choices && !spell_suggest_add_choices(&near, text, field->choices)) {
        snprintf(advice, sizeof advice, "give one of %s", field->choices);
        return set_unknown_name_error(&near, "not a choice", field->name, advice, error);
    }
    if (field->type == INSPECTION_DIGEST && is_other)
        return error_set(error, MR_IO,
                         "the picture has changed: %s of the file differs from the recorded "
                         "%.12s...; restore the file",
                         field->name, text);
    return field->type == INSPECTION_PICTURE ? read_picture(field, text, values, error) : MR_OK;
}

enum mr_status inspection_parse_field(const struct inspection_kind *kind, const char *word,
                                      json_t *values, struct error *error)
{
    char name[80];
    const char *text = strchr(word, '=');
    const struct inspection_field *field = kind->field;
    struct estimate number = {(double)NAN, 0.0};
    struct spell_suggest near;
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    spell_suggest_begin(&near, name);
    while (field->name && !spell_suggest_add(&near, field->name))
        field++;
    if (!field->name || !text)
        return set_unknown_name_error(&near, "unknown field", kind->name,
                                      "matrig record --kinds lists the fields", error);
    const bool derived = field->type >= INSPECTION_DIGEST;
    if (json_object_get(values, field->name) && !derived)
        return error_set(error, MR_USAGE, "two values for %s; give only one", field->name);
    if (!derived) {
        set_number(field, number, values);
        json_object_set_new(values, field->name, json_null());
        if (field[1].type >= INSPECTION_DIGEST)
            json_object_set_new(values, field[1].name, json_null());
    }
    if (!*++text)
        return MR_OK;
    if (field->type == INSPECTION_MARKS || (field[1].type == INSPECTION_MARKS && strchr(text, ':')))
        return read_marks(field->type == INSPECTION_MARKS ? field - 1 : field, text, values, error);
    if (field->type != INSPECTION_NUMBER)
        return read_text(field, text, values, error);
    if (inspection_parse_number(field, text, &number, error) == MR_OK)
        set_number(field, number, values);
    return error->status;
}

char *inspection_find_picture(const struct inspections *all, const struct inspection *entry,
                              struct error *error)
{
    const char *file = json_string_value(json_object_get(entry->values, "file")),
               *was = json_string_value(json_object_get(entry->values, "file_sha256"));
    char digest[SHA256_DIGEST_STRING_LENGTH];
    char *path = xasprintf("%s%s", file && file[0] == '/' ? "" : all->folder, file ? file : "-");
    const bool is_there = compute_digest(path, digest);
    if (is_there && was && strcmp(digest, was) == 0)
        return path;
    error_set(error, MR_IO,
              "the picture %s: %s; restore it, or give its path: matrig record DB --correct %lld "
              "file=PATH --reason TEXT",
              is_there ? "has changed" : "is missing", path, (long long)entry->row.id);
    free(path);
    return NULL;
}

bool inspection_copy_value(const struct inspection_field *field, const json_t *from, json_t *values)
{
    char key[80];
    snprintf(key, sizeof key, "%s_error", field->name);
    if (json_object_get(values, field->name) || !json_object_get(from, field->name))
        return false;
    json_object_set(values, field->name, json_object_get(from, field->name));
    json_object_set(values, key, json_object_get(from, key));
    return true;
}

/* ---- rows ---- */

static bool is_run(struct store *store, double number)
{
    struct store_landing landing;
    struct error none = {0};
    return store_landing_get(store, (int64_t)number, &landing, &none) == MR_OK;
}

/* Returns what is wrong with the values as a whole; NULL: nothing. */
static const char *find_broken_rule(struct store *store, const struct store_record *row,
                                    const json_t *values)
{
#define HAS(field)       (json_object_get(values, #field) != NULL)
#define NUMBER_OF(field) (inspection_get_number(values, #field).value)
#define IS(field, choice) \
    (HAS(field) && strcmp(json_string_value(json_object_get(values, #field)), choice) == 0)
#define RULE(of, is_broken, message)                \
    if (strcmp(row->kind, #of) == 0 && (is_broken)) \
        return message;
#include "host/store/records.def"
    return json_object_size(values) == 0 ? "no value given; give FIELD=VALUE" : NULL;
}

/* Returns true for two records of one subject: the same landing, mat, joint or station. Damage and
 * pictures of a landing are told apart by the first two fields of their kind. */
static bool is_same_subject(const struct inspection *entry, const struct store_record *row,
                            const json_t *values)
{
    const size_t fields =
        entry->kind->place == INSPECTION_LANDING && !inspection_is_single(entry->kind) ? 2 : 0;
    if (strcmp(entry->row.kind, row->kind) != 0 || entry->row.run != row->run ||
        fabs(entry->row.place - row->place) > 0.0)
        return false;
    for (size_t f = 0; f < fields; f++) {
        const json_t *is = json_object_get(entry->values, entry->kind->field[f].name),
                     *other = json_object_get(values, entry->kind->field[f].name);
        if (is != other && !json_equal(is, other))
            return false;
    }
    return true;
}

/* Returns the record that the new one repeats: the newest of its subject if it has or had the same
 * values, or if its kind has one record per landing. NULL: none. */
static const struct inspection *find_duplicate_record(const struct inspections *all,
                                                      const struct store_record *row,
                                                      const json_t *values)
{
    const struct inspection *newest = NULL;
    for (FOR_EACH(entry, all))
        if (inspection_is_valid(entry, NULL, 0) && is_same_subject(entry, row, values) &&
            (!newest || entry->origin > newest->origin))
            newest = entry;
    for (const struct inspection *same = newest; same; same = same->corrected)
        if (inspection_is_single(same->kind) || strcmp(same->row.fields, row->fields) == 0)
            return newest;
    return NULL;
}

static void append_record(struct inspections *all, const struct store_record *row)
{
    struct inspection *entry = &all->entry[all->count];
    struct error none = {0};
    *entry = (struct inspection){.row = *row, .origin = row->id};
    all->next_id = row->id + 1;
    if (inspection_kind_find(row->kind, &entry->kind, &none) != MR_OK)
        return;
    if (row->fields[0])
        entry->values = json_loads(row->fields, 0, NULL) ?: json_object();
    for (struct inspection *old = all->entry; row->corrects != STORE_NONE && old < entry; old++) {
        if (old->row.id != row->corrects)
            continue;
        entry->corrected = old;
        entry->origin = old->origin;
        old->replaced_by = entry;
    }
    all->count++;
}

enum mr_status inspection_add(struct store *store, struct inspections *all,
                              const struct store_record *row, json_t *values, struct error *error)
{
    struct store_record put = *row;
    const char *key;
    json_t *value;
    void *next;
    json_object_foreach_safe(values, next, key, value) if (json_is_null(value))
        json_object_del(values, key);
    const char *picture = json_string_value(json_object_get(values, "file"));
    const size_t folder = strlen(all->folder);
    if (picture && strncmp(picture, all->folder, folder) == 0)
        json_object_set_new(values, "file", json_string(picture + folder));
    char *text = values
                   ? json_dumps(values, JSON_SORT_KEYS | JSON_COMPACT | JSON_REAL_PRECISION(15))
                   : xstrdup("");
    bool fits = snprintf(put.fields, sizeof put.fields, "%s", text) < (int)sizeof put.fields;
    free(text);
    if (!fits)
        return error_set(
            error, MR_TOO_LONG,
            "the values of the record are too long: %s; give at most %zu characters in total",
            row->kind, sizeof put.fields - 1);
    const char *broken = values ? find_broken_rule(store, row, values) : NULL;
    if (broken)
        return error_set(error, MR_USAGE, "wrong record of %s: %s", row->kind, broken);
    const struct inspection *same = values && row->corrects == STORE_NONE
                                      ? find_duplicate_record(all, &put, values)
                                      : NULL;
    if (same)
        return error_set(error, MR_USAGE,
                         "recorded already: record %lld of %s; matrig record DB --correct %lld "
                         "FIELD=VALUE --reason TEXT changes it",
                         (long long)same->row.id, row->kind, (long long)same->row.id);
    for (FOR_EACH(entry, all))
        if (values && entry->row.id == row->corrects && strcmp(entry->row.fields, put.fields) == 0)
            return error_set(error, MR_USAGE,
                             "nothing changes: record %lld has these values already",
                             (long long)row->corrects);
    if (store_record_add(store, &put, error) != MR_OK)
        return error->status;
    if (all->count == all->room) {
        inspection_free(all);
        return inspection_load(store, all, error);
    }
    put.id = all->next_id;
    append_record(all, &put);
    return MR_OK;
}

enum mr_status inspection_load(struct store *store, struct inspections *all, struct error *error)
{
    struct store_record *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_records_get(store, &rows, &count, error);
    /* with as many free entries again, so that the time to add records is in proportion to their
     * number */
    *all = (struct inspections){.room = 2 * count + 16, .next_id = 1};
    all->entry = xcalloc(all->room, sizeof *all->entry);
    all->folder = realpath(store_path(store), NULL) ?: xstrdup("/");
    strrchr(all->folder, '/')[1] = '\0';
    for (size_t i = 0; i < count; i++)
        append_record(all, &rows[i]);
    free(rows);
    return status;
}

void inspection_free(struct inspections *all)
{
    for (size_t i = 0; i < all->count; i++)
        json_decref(all->entry[i].values);
    free(all->entry);
    free(all->folder);
}

bool inspection_is_valid(const struct inspection *entry, const struct inspection_kind *kind,
                         int64_t run)
{
    return entry->values && !entry->replaced_by && (!kind || entry->kind == kind) &&
           (!run || entry->row.run == run);
}

bool inspection_has_valid_record(const struct inspections *all, const struct inspection_kind *kind,
                                 int64_t run)
{
    for (FOR_EACH(entry, all))
        if (inspection_is_valid(entry, kind, run))
            return true;
    return false;
}

const struct inspection *inspection_find_newest(const struct inspections *all,
                                                const struct inspection_kind *kind, int64_t run)
{
    const struct inspection *newest = NULL;
    for (FOR_EACH(entry, all)) {
        if (inspection_is_valid(entry, kind, 0) && (!run || entry->row.run <= run) &&
            (!newest || entry->row.run > newest->row.run ||
             (entry->row.run == newest->row.run && entry->origin >= newest->origin)))
            newest = entry;
    }
    return newest;
}

/* ---- limits ---- */

static enum inspection_verdict check_field_limits(const struct inspection_field *field,
                                                  const json_t *values)
{
    struct estimate n = inspection_get_number(values, field->name);
    double above = n.value - field->pass_low, below = field->pass_high - n.value;
    if (isnan(n.value) || !field->limit)
        return INSPECTION_NO_LIMIT;
    if (n.error > 0.0 && (fabs(above) <= n.error || fabs(below) <= n.error))
        return INSPECTION_MARGINAL;
    return above < 0.0 || below < 0.0 ? INSPECTION_FAIL : INSPECTION_PASS;
}

enum inspection_verdict inspection_check_limits(const struct inspection *entry)
{
    enum inspection_verdict worst = INSPECTION_NO_LIMIT;
    for (const struct inspection_field *field = entry->kind->field; field->name; field++) {
        enum inspection_verdict verdict = check_field_limits(field, entry->values);
        worst = verdict > worst ? verdict : worst;
    }
    return worst;
}

const char *inspection_verdict_text(enum inspection_verdict verdict)
{
    static const char *const text[] = {"no limit", "pass", "within its error of the limit", "fail"};
    return text[verdict];
}

/* ---- answers ---- */

/* Formats a number with up to `digits` digits; a large number without exponent. */
static void format_number(double value, int digits, char out[40])
{
    snprintf(out, 40, fabs(value) < pow(10.0, digits) - 0.5 ? "%.*g" : "%.*f",
             fabs(value) < pow(10.0, digits) - 0.5 ? digits : 0, value);
}

/* Factor from the unit of a field to that of the answer; for temperatures that of a difference. */
static double unit_factor(const struct inspection_field *field, bool si)
{
    if (is_temperature(field))
        return si ? 1.0 / 1.8 : 1.0;
    return si ? quantity_convert(1.0, quantity_unit_from_name(field->name),
                                 inspection_get_unit(field, si))
              : 1.0;
}

/* As inspection_format_value, in the units of the answer. */
static void format_for_display(const struct inspection_field *field, const json_t *values, bool si,
                               char out[INSPECTION_TEXT_SIZE])
{
    const bool celsius = si && is_temperature(field);
    const struct estimate n = inspection_get_number(values, field->name);
    const char *digest = json_string_value(json_object_get(values, "file_sha256"));
    char value[40], error[40];
    const double factor = unit_factor(field, si);
    inspection_format_value(field, values, out);
    format_number(factor * (n.value - (celsius ? 32.0 : 0.0)), 6, value);
    format_number(factor * n.error, 2, error);
    if (!isnan(n.value))
        snprintf(out, INSPECTION_TEXT_SIZE, n.error > 0.0 ? "%s +- %s" : "%s", value, error);
    else if (field->type == INSPECTION_PICTURE && digest)
        snprintf(strchr(out, '\0'), 40, " (SHA-256 %.12s...)", digest);
    else if (field->type >= INSPECTION_DIGEST)
        out[0] = '\0';
}

static void format_label(const struct inspection_field *field, bool si, char label[80])
{
    const char *unit = inspection_get_unit(field, si);
    snprintf(label, 80, *unit ? "%s (%s)" : "%s", field->description, unit);
}

/* Adds a value, the previous value if it was corrected, and the limit that it does not pass. */
static void add_cell(const struct inspection *entry, const struct inspection_field *field,
                     struct answer *answer)
{
    char is[INSPECTION_TEXT_SIZE], was[INSPECTION_TEXT_SIZE], label[80], number[40], limit[80] = "";
    const bool si = answer_is_si(answer);
    const enum inspection_verdict verdict = check_field_limits(field, entry->values);
    const double value = inspection_get_number(entry->values, field->name).value;
    const bool is_low = isnan(field->pass_high) ||
                        fabs(value - field->pass_low) < fabs(value - field->pass_high);
    format_for_display(field, entry->values, si, is);
    format_for_display(field, entry->corrected ? entry->corrected->values : entry->values, si, was);
    format_label(field, si, label);
    if (verdict > INSPECTION_PASS) {
        format_number(unit_factor(field, si) * (is_low ? field->pass_low : field->pass_high), 4,
                      number);
        snprintf(limit, sizeof limit, " (%s %s)",
                 verdict == INSPECTION_MARGINAL ? "limit"
                 : is_low                       ? "below"
                                                : "above",
                 number);
    }
    struct answer_style *fact = answer_add_text(answer, NULL, label,
                                                strcmp(is, was) != 0 ? "%s%s (was %s)" : "%s%s",
                                                is[0] ? is : "-", limit, was[0] ? was : "-");
    fact->is_warning = verdict == INSPECTION_FAIL;
    fact->is_number = field->type == INSPECTION_NUMBER;
}

static void add_subject(const struct inspection *entry, const char *name, const char *label,
                        struct answer *answer)
{
    if (entry->kind->place == INSPECTION_STATION)
        answer_add_value(answer, name ? "station" : NULL, label ? "station" : NULL, UNIT_STATION,
                         entry->row.place, 1);
    else if (entry->kind->place != INSPECTION_CAMPAIGN)
        answer_add_count(answer, name, label,
                         entry->kind->place == INSPECTION_LANDING ? entry->row.run
                                                                  : (int64_t)entry->row.place);
}

/* Returns the reason in the row that withdraws this one; NULL: it is not withdrawn. */
static const char *get_withdrawal_reason(const struct inspection *entry)
{
    const struct inspection *by = entry->replaced_by;
    return by && !by->values ? by->row.reason : NULL;
}

/* Sorts rows by verdict and number, withdrawn rows last. */
static int compare_rows(const void *a, const void *b)
{
    const struct inspection *p = *(const struct inspection *const *)a,
                            *q = *(const struct inspection *const *)b;
    int later = !get_withdrawal_reason(q) - !get_withdrawal_reason(p),
        worse = (int)inspection_check_limits(q) - (int)inspection_check_limits(p);
    return later ?: worse ?: p->row.id < q->row.id ? -1 : 1;
}

void inspection_add_table(const struct inspections *all, const struct inspection_kind *kind,
                          int64_t run, size_t from, struct answer *answer)
{
    const struct inspection **rows = xcalloc(all->count + 1, sizeof(struct inspection *));
    size_t count = 0, verdicts[INSPECTION_FAIL + 1] = {0};
    bool used[INSPECTION_FIELDS_MAX] = {false};
    for (FOR_EACH(entry, all)) {
        if (entry < all->entry + from || entry->kind != kind || !entry->values ||
            (run && entry->row.run != run) || (entry->replaced_by && !get_withdrawal_reason(entry)))
            continue;
        rows[count++] = entry;
        verdicts[inspection_check_limits(entry)] += !entry->replaced_by;
        for (size_t f = 0; kind->field[f].name; f++)
            used[f] |= json_object_get(entry->values, kind->field[f].name) != NULL &&
                       kind->field[f].type < INSPECTION_DIGEST;
    }
    qsort(rows, count, sizeof(struct inspection *), compare_rows);
    const bool judged = verdicts[INSPECTION_PASS] + verdicts[INSPECTION_MARGINAL] +
                        verdicts[INSPECTION_FAIL];
    answer_open_table(answer, NULL, kind->description);
    for (size_t i = 0; i < count; i++) {
        enum inspection_verdict verdict = inspection_check_limits(rows[i]);
        answer_open_row(answer);
        answer_add_count(answer, NULL, "record", rows[i]->row.id);
        if (!run)
            add_subject(rows[i], NULL,
                        kind->place == INSPECTION_LANDING ? "RUN" : inspection_subject(kind)->name,
                        answer);
        if (get_withdrawal_reason(rows[i]))
            answer_add_text(answer, NULL, "withdrawn", "%s", get_withdrawal_reason(rows[i]));
        if (judged)
            answer_add_text(answer, NULL, "result", "%s", inspection_verdict_text(verdict))
                ->is_warning = verdict == INSPECTION_FAIL;
        for (size_t f = 0; kind->field[f].name; f++)
            if (used[f])
                add_cell(rows[i], &kind->field[f], answer);
        answer_add_text_or_missing(answer, NULL, "by", rows[i]->row.who, "-");
        if (rows[i]->row.reason[0])
            answer_add_text(answer, NULL, "reason", "%s", rows[i]->row.reason);
    }
    answer_close_group(answer);
    if (judged)
        answer_add_sentence(answer, NULL, "%zu pass, %zu fail, %zu within the error of a limit.",
                            verdicts[INSPECTION_PASS], verdicts[INSPECTION_FAIL],
                            verdicts[INSPECTION_MARGINAL]);
    for (const struct inspection_field *field = kind->field; field->name; field++) {
        size_t beyond = 0;
        for (size_t i = 0; i < count; i++)
            beyond += !rows[i]->replaced_by &&
                      check_field_limits(field, rows[i]->values) > INSPECTION_PASS;
        if (beyond)
            answer_add_sentence(answer, NULL, "Limit of %s: %s.", field->description, field->limit);
    }
    free(rows);
}

void inspection_add_json(const struct inspections *all, const struct inspection_kind *kind,
                         int64_t run, struct answer *answer)
{
    answer_open_table(answer, "records", "");
    for (FOR_EACH(entry, all)) {
        const struct store_record *row = &entry->row;
        if ((kind && entry->kind != kind) || (run && row->run != run))
            continue;
        answer_open_row(answer);
        answer_add_count(answer, "id", NULL, row->id);
        answer_add_text(answer, "kind", NULL, "%s", row->kind);
        add_subject(entry, inspection_subject(entry->kind)->name, NULL, answer);
        answer_add_json(answer, "fields",
                        entry->values ? json_deep_copy(entry->values) : json_null());
        answer_add_text_or_missing(
            answer, "result", NULL,
            entry->values ? inspection_verdict_text(inspection_check_limits(entry)) : NULL, NULL);
        answer_add_flag(answer, "valid", NULL, inspection_is_valid(entry, NULL, 0));
        answer_add_count(answer, entry->values ? "corrects" : "withdraws", NULL, row->corrects);
        answer_add_text_or_missing(answer, "who", NULL, row->who, NULL);
        answer_add_text_or_missing(answer, "reason", NULL, row->reason, NULL);
        answer_add_count(answer, "made_us", NULL, row->made_us);
    }
    answer_close_group(answer);
}

/* ---- two landings ---- */

struct difference {
    struct answer *answer;
    int64_t run[2];
    size_t count;
    const char *missing[2]; /* text for a landing without a value */
};

static void add_difference(struct difference *d, const char *kind, const char *field,
                           const char *label, const char *from, const char *to)
{
    if (strcmp(from, to) == 0)
        return;
    d->count++;
    answer_open_row(d->answer);
    answer_add_text(d->answer, "kind", NULL, "%s", kind);
    answer_add_text_or_missing(d->answer, "field", NULL, field, NULL);
    answer_add_text(d->answer, NULL, "difference", "%s", label);
    for (int i = 0; i < 2; i++) {
        char run[40];
        snprintf(run, sizeof run, "RUN %lld", (long long)d->run[i]);
        answer_add_text_or_missing(d->answer, i ? "to" : "from", run, i ? to : from, d->missing[i]);
    }
}

/* Adds the differences between the data entered with `matrig landing`. */
static void add_journal_differences(struct store *store, struct difference *d, struct error *error)
{
    struct store_series series[2];
    char weight[2][STORE_JOURNAL_TEXT_SIZE];
    for (int i = 0; i < 2; i++) {
        struct store_landing landing;
        if (store_landing_get(store, d->run[i], &landing, error) != MR_OK ||
            store_landing_series_get(store, &landing, &series[i], error) != MR_OK ||
            store_change_get(store, d->run[i], "weight_lb", weight[i], NULL, error) != MR_OK)
            return;
    }
    add_difference(d, "landing", "series", "series", series[0].name, series[1].name);
    add_difference(d, "landing", "pattern", "pattern", series[0].pattern, series[1].pattern);
    add_difference(d, "landing", "modification", "modification", series[0].modification,
                   series[1].modification);
    add_difference(d, "landing", "runway", "runway", series[0].runway, series[1].runway);
    add_difference(d, "landing", "weight_lb", "weight (lb)", weight[0], weight[1]);
}

/* Returns record number `n` among the records of a kind that landing `run` has and landing `other`
 * has not; NULL: there are fewer. */
static const struct inspection *find_unmatched_record(const struct inspections *all,
                                                      const struct inspection_kind *kind,
                                                      int64_t run, int64_t other, size_t n)
{
    for (FOR_EACH(entry, all)) {
        bool is_common = !inspection_is_valid(entry, kind, run);
        for (FOR_EACH(same, all))
            is_common |= inspection_is_valid(same, kind, other) &&
                         json_equal(entry->values, same->values);
        if (!is_common && n-- == 0)
            return entry;
    }
    return NULL;
}

size_t inspection_add_differences(struct store *store, const struct inspections *all,
                                  bool single_only, int64_t from, int64_t to, struct answer *answer,
                                  struct error *error)
{
    struct difference d = {answer, {from, to}, 0, {"-", "-"}};
    char is[2][INSPECTION_TEXT_SIZE], label[80], numbered[120];
    answer_open_table(answer, "differences", "");
    add_journal_differences(store, &d, error);
    for (const struct inspection_kind *kind = inspection_kinds; kind->name; kind++) {
        const struct inspection *entry[2] = {NULL, NULL};
        if (kind->place != INSPECTION_LANDING || (single_only && !inspection_is_single(kind)))
            continue;
        for (int i = 0; i < 2; i++)
            d.missing[i] = inspection_has_valid_record(all, kind, d.run[i]) ? "-" : "no record";
        for (size_t n = 0; n == 0 || entry[0] || entry[1]; n++) {
            for (int i = 0; i < 2; i++)
                entry[i] = find_unmatched_record(all, kind, d.run[i], d.run[!i], n);
            for (const struct inspection_field *field = kind->field; field->name; field++) {
                for (int i = 0; i < 2; i++)
                    format_for_display(field, entry[i] ? entry[i]->values : NULL,
                                       answer_is_si(answer), is[i]);
                format_label(field, answer_is_si(answer), label);
                snprintf(numbered, sizeof numbered, "%s %zu: %s", kind->name, n + 1, label);
                add_difference(&d, kind->name, field->name,
                               inspection_is_single(kind) ? label : numbered, is[0], is[1]);
            }
        }
    }
    answer_close_group(answer);
    return d.count;
}
