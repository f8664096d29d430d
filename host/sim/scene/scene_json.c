/* Reading a scene file. */
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/sim/scene/scene.h"
#include "host/sim/scene/scene_keys.h"
#include "host/sim/scene/scene_units.h"

#define FILE_BYTES_MAX (64u << 20)

static enum mr_status read_file(const char *path, char **text, size_t *length, struct error *error)
{
    FILE *file = fopen(path, "rb");
    size_t size = 0, room = 0;
    *text = NULL;
    if (!file)
        return error_set(error, MR_IO, "cannot open scene: %s: %s; check the path", path,
                         strerror(errno));
    for (;;) {
        if (size == room) {
            room = room ? 2 * room : 65536;
            char *larger = room > FILE_BYTES_MAX ? NULL : realloc(*text, room);
            if (!larger) {
                error_set(error, MR_TOO_LONG, "scene too long: %s: beyond %u bytes; is it a scene?",
                          path, FILE_BYTES_MAX);
                break;
            }
            *text = larger;
        }
        size_t got = fread(*text + size, 1, room - size, file);
        if (got == 0) {
            if (ferror(file))
                error_set(error, MR_IO, "cannot read scene: %s: %s; check the path", path,
                          strerror(errno));
            break;
        }
        size += got;
    }
    fclose(file);
    *length = size;
    if (error->status != MR_OK) {
        free(*text);
        *text = NULL;
    }
    return error->status;
}

static const char *type_name(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "a list";
    case JSON_STRING: return "text";
    case JSON_INTEGER: return "a number";
    case JSON_REAL: return "a number with a point or exponent";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: break;
    }
    return "null";
}

static enum mr_status wrong_type(const char *path, const char *key, const json_t *value,
                                 const char *wanted, struct error *error)
{
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s is %s; give %s", path, key,
                     type_name(value), wanted);
}

/* Of a number that is none. `at`: in a list; -1: alone. */
static enum mr_status wrong_number(const char *path, const struct sim_key *key, const json_t *value,
                                   int at, const struct quantity_wrong *wrong, struct error *error)
{
    char place[60] = "";
    if (at >= 0)
        snprintf(place, sizeof place, "[%d]", at);
    if (json_is_string(value) && quantity_kind_of(key->unit))
        return error_set(error, MR_MALFORMED, "%s: %s: %s%s is \"%s\"; %s", wrong->what, path,
                         key->name, place, json_string_value(value), wrong->advice);
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s%s is %s; give a number%s%s", path,
                     key->name, place, type_name(value), *key->unit ? " in " : "", key->unit);
}

static enum mr_status read_choice(void *field, const struct sim_key *key, const char *path,
                                  const json_t *value, struct error *error)
{
    char names[160] = "";
    for (unsigned i = 0; key->choices[i]; i++) {
        if (json_is_string(value) && strcmp(json_string_value(value), key->choices[i]) == 0) {
            /* every choice is an enum, which is an unsigned int here */
            memcpy(field, &i, sizeof i);
            return MR_OK;
        }
        if (i > 0)
            strcat(names, ", "); /* the table's names are short: a few words each */
        strcat(names, key->choices[i]);
    }
    if (json_is_string(value))
        return error_set(error, MR_MALFORMED, "unknown choice: %s: %s is \"%s\"; give one of %s",
                         path, key->name, json_string_value(value), names);
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s; give one of %s, as text", path,
                     key->name, names);
}

static enum mr_status read_list(struct sim_list *list, const struct sim_key *key, const char *path,
                                const json_t *value, struct error *error)
{
    size_t count = json_array_size(value);
    double *values = calloc(count + 1, sizeof *values);
    struct quantity_wrong wrong;
    if (!values)
        return error_set(error, MR_FULL, "out of memory: %s: %s; use a smaller scene", path,
                         key->name);
    for (size_t i = 0; i < count; i++) {
        const json_t *entry = json_array_get(value, i);
        if (!sim_unit_read(key, entry, &values[i], &wrong)) {
            free(values);
            return wrong_number(path, key, entry, (int)i, &wrong, error);
        }
    }
    *list = (struct sim_list){values, count};
    return MR_OK;
}

static enum mr_status read_path(struct sim_scene *scene, const char *path, const json_t *value,
                                struct error *error)
{
    size_t count = json_array_size(value);
    scene->path = calloc(count + 1, sizeof *scene->path);
    if (!scene->path)
        return error_set(error, MR_FULL, "out of memory: %s: path; use a smaller scene", path);
    scene->path_count = count;
    for (size_t i = 0; i < count; i++) {
        const json_t *row = json_array_get(value, i);
        static const char *const units[] = {"s", "ft", "lb"};
        struct quantity_wrong wrong;
        double number[3];
        for (size_t k = 0; k < 3; k++) {
            const json_t *entry = json_array_get(row, k);
            if (json_array_size(row) == 3 && json_is_string(entry) &&
                !quantity_json(entry, units[k], &number[k], &wrong))
                return error_set(error, MR_MALFORMED, "%s: %s: path row %zu: \"%s\"; %s",
                                 wrong.what, path, i, json_string_value(entry), wrong.advice);
            if (json_array_size(row) != 3 || !quantity_json(entry, units[k], &number[k], &wrong))
                return error_set(error, MR_MALFORMED,
                                 "wrong type: %s: path row %zu; give three numbers, "
                                 "[t_s, x_ft, F_lb]",
                                 path, i);
        }
        scene->path[i] = (struct sim_path_row){number[0], number[1], number[2]};
    }
    if (count == 0)
        return error_set(error, MR_MALFORMED,
                         "list too short: %s: path has no rows; give at least two or leave it out",
                         path);
    return MR_OK;
}

/* A number, or text with a unit. */
static enum mr_status read_real(double *field, const struct sim_key *key, const char *path,
                                const json_t *value, struct error *error)
{
    double number;
    struct quantity_wrong wrong;
    if (!sim_unit_read(key, value, &number, &wrong))
        return wrong_number(path, key, value, -1, &wrong, error);
    if (key->offset == offsetof(struct sim_scene, t_dwell_s) && number < 0.0)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: t_dwell is %g; give 0 or more", path, number);
    *field = number;
    return MR_OK;
}

static enum mr_status read_key(struct sim_scene *scene, const struct sim_key *key, const char *path,
                               const json_t *value, struct error *error)
{
    void *field = (char *)scene + key->offset;
    switch (key->kind) {
    case SIM_KEY_TEXT:
        if (!json_is_string(value))
            return wrong_type(path, key->name, value, "text", error);
        snprintf(field, sizeof scene->name, "%s", json_string_value(value));
        return MR_OK;
    case SIM_KEY_REAL: return read_real(field, key, path, value, error);
    case SIM_KEY_INTEGER:
        if (!json_is_integer(value))
            return wrong_type(path, key->name, value, "a whole number", error);
        if (llabs(json_integer_value(value)) > 10ll * SIM_MATS_MAX)
            return error_set(error, MR_MALFORMED,
                             "value out of range: %s: %s is %lld; give %g to %g", path, key->name,
                             (long long)json_integer_value(value), key->low, key->high);
        *(int *)field = (int)json_integer_value(value);
        return MR_OK;
    case SIM_KEY_CHOICE: return read_choice(field, key, path, value, error);
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS:
        if (json_is_number(value) || json_is_string(value)) {
            double one;
            enum mr_status status = read_real(&one, key, path, value, error);
            return status == MR_OK ? sim_scene_set_list(field, &one, 1, error) : status;
        }
        if (!json_is_array(value))
            return wrong_type(path, key->name, value,
                              key->kind == SIM_KEY_JOINTS ? "a number, or a list with one per joint"
                                                          : "a number, or a list with one per part",
                              error);
        return read_list(field, key, path, value, error);
    case SIM_KEY_LIST:
    case SIM_KEY_MATS:
        if (!json_is_array(value))
            return wrong_type(path, key->name, value, "a list of numbers", error);
        return read_list(field, key, path, value, error);
    case SIM_KEY_PATH:
        if (!json_is_array(value))
            return wrong_type(path, key->name, value, "a list of rows [t_s, x_ft, F_lb]", error);
        return read_path(scene, path, value, error);
    }
    return MR_OK;
}

/* In memory a list of one value stands for every joint; in a file it is a list of the wrong
 * length. */
static enum mr_status check_written_lengths(const struct sim_scene *scene, const char *path,
                                            json_t *root, struct error *error)
{
    size_t joints = (size_t)scene->mats + 1;
    static const char *const names[] = {"gap0", "grit", "stiff_gap0"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const json_t *value = json_object_get(root, names[i]);
        if (json_is_array(value) && json_array_size(value) != joints)
            return error_set(error, MR_MALFORMED,
                             "list of the wrong length: %s: %s has %zu values; give one number or "
                             "%zu, one per joint (N + 1)",
                             path, names[i], json_array_size(value), joints);
    }
    return MR_OK;
}

/* Keys are written as the report writes them, so capitals count: name the one that was meant. */
static enum mr_status unknown_key(const char *path, const char *name, struct error *error)
{
    for (size_t i = 0; sim_key_at(i); i++) {
        if (strcasecmp(name, sim_key_at(i)->name) == 0)
            return error_set(error, MR_MALFORMED,
                             "unknown key: %s: \"%s\"; write \"%s\", or _%s for a comment", path,
                             name, sim_key_at(i)->name, name);
    }
    return error_set(error, MR_MALFORMED,
                     "unknown key: %s: \"%s\"; correct it (matrig sim --keys lists the keys), or "
                     "write _%s for a comment",
                     path, name, name);
}

static enum mr_status read_object(struct sim_scene *scene, const char *path, json_t *root,
                                  struct error *error)
{
    const char *name;
    json_t *value;
    if (!json_is_object(root))
        return error_set(error, MR_MALFORMED,
                         "not a scene: %s: the file holds no JSON object; begin with {", path);
    json_object_foreach(root, name, value)
    {
        if (name[0] == '_')
            continue; /* a comment */
        const struct sim_key *key = sim_key_find(name);
        if (!key)
            return unknown_key(path, name, error);
        enum mr_status status = read_key(scene, key, path, value, error);
        if (status != MR_OK)
            return status;
    }
    if (check_written_lengths(scene, path, root, error) != MR_OK)
        return error->status;
    return sim_scene_check(scene, path, error);
}

enum mr_status sim_scene_parse(struct sim_scene *scene, const char *path, const char *text,
                               size_t length, struct error *error)
{
    json_error_t where;
    sim_scene_defaults(scene);
    json_t *root = json_loadb(text, length, JSON_REJECT_DUPLICATES, &where);
    if (!root) {
        bool cut = json_error_code(&where) == json_error_premature_end_of_input;
        return error_set(error, cut ? MR_TRUNCATED : MR_MALFORMED,
                         "%s: %s line %d column %d: %s; correct it there",
                         cut ? "scene ends too early" : "malformed JSON", path, where.line,
                         where.column, where.text);
    }
    enum mr_status status = sim_scene_from_json(scene, path, root, error);
    json_decref(root);
    return status;
}

enum mr_status sim_scene_from_json(struct sim_scene *scene, const char *where, json_t *root,
                                   struct error *error)
{
    sim_scene_defaults(scene);
    enum mr_status status = read_object(scene, where, root, error);
    if (status != MR_OK)
        sim_scene_free(scene);
    return status;
}

enum mr_status sim_scene_load(struct sim_scene *scene, const char *path, struct error *error)
{
    char *text = NULL;
    size_t length = 0;
    sim_scene_defaults(scene);
    if (read_file(path, &text, &length, error) != MR_OK)
        return error->status;
    enum mr_status status = sim_scene_parse(scene, path, text, length, error);
    free(text);
    return status;
}
