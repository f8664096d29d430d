/* Reading of study files. */
#include "host/landing_series/series.h"
#include "host/base/xmalloc.h"

#include <errno.h>
#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/quantity.h"
#include "host/sim/scene/scene.h"

/* ---- keys ---- */

/* Reader of keys. An error names the file, the object (`where`, "" at the top level) and the key.
 * After the first error all functions do nothing. An absent key does not change its value. */
struct key_reader {
    const char *path;
    struct error *error;
};

static bool has_key_error(const struct key_reader *keys)
{
    return keys->error->status != MR_OK;
}

static void refuse_key(const struct key_reader *keys, const char *where, const char *key,
                       const char *wanted)
{
    error_set(keys->error, MR_MALFORMED, "wrong value: %s: %s%s%s; give %s", keys->path, where,
              where[0] ? "." : "", key, wanted);
}

/* Reads a number in the unit with which the key's name ends. Returns false if the value is neither
 * a number nor text with a matching unit. */
static bool read_number(const char *key, const json_t *entry, double *value)
{
    struct quantity_error wrong;
    return quantity_read_json(entry, quantity_unit_from_name(key), value, &wrong);
}

static bool read_value(const struct series_key *key, const json_t *entry, void *field)
{
    bool pair = key->kind == SERIES_KEY_RANGE && json_array_size(entry) == 2;
    struct series_range range;
    switch (key->kind) {
    case SERIES_KEY_NUMBER:
    case SERIES_KEY_RANGE:
        if (!read_number(key->name, pair ? json_array_get(entry, 0) : entry, &range.low) ||
            !read_number(key->name, pair ? json_array_get(entry, 1) : entry, &range.high) ||
            !(range.low >= key->low && range.high <= key->high && range.low <= range.high))
            return false;
        memcpy(field, &range, key->kind == SERIES_KEY_RANGE ? sizeof range : sizeof range.low);
        return true;
    case SERIES_KEY_CHOICE:
        for (unsigned i = 0; key->choices[i]; i++) {
            if (json_is_string(entry) && strcmp(json_string_value(entry), key->choices[i]) == 0) {
                memcpy(field, &i, sizeof i);
                return true;
            }
        }
        return false;
    case SERIES_KEY_TEXT:
        return json_is_string(entry) &&
               snprintf(field, (size_t)key->high, "%s", json_string_value(entry)) < (int)key->high;
    case SERIES_KEY_FLAG: *(bool *)field = json_is_true(entry); return json_is_boolean(entry);
    }
    return false;
}

/* Describes the values that a key accepts: "a number from 0 to 10 ft, or as text with ...". */
static void format_expected(const struct series_key *key, char out[300])
{
    const char *unit = quantity_unit_from_name(key->name);
    const struct quantity_kind *kind = quantity_kind_find(unit);
    if (key->kind == SERIES_KEY_NUMBER || key->kind == SERIES_KEY_RANGE)
        snprintf(out, 300, "a number%s from %g to %g%s%s%s%s",
                 key->kind == SERIES_KEY_RANGE ? ", or a range [from, to] from which it is drawn,"
                                               : "",
                 key->low, key->high, kind ? " " : "", unit, kind ? ", or as text with " : "",
                 kind ? kind->units : "");
    else if (key->kind != SERIES_KEY_CHOICE)
        snprintf(out, 300, "%s", key->kind == SERIES_KEY_FLAG ? "true or false" : "a short text");
    else
        strcpy(out, "one of");
    for (unsigned i = 0; key->kind == SERIES_KEY_CHOICE && key->choices[i]; i++)
        strcat(strcat(out, i > 0 ? ", " : " "),
               key->choices[i]); /* no overflow check: the choices are short */
}

/* Reads an object with `count` known keys. Also accepts comments and the keys in `others`, which
 * another function reads. */
static void read_object(const struct key_reader *r, const char *where, const json_t *object,
                        const struct series_key *keys, size_t count, const char *const *others,
                        void *base)
{
    const char *name;
    json_t *value;
    char wanted[300];
    if (!json_is_object(object))
        refuse_key(r, where, "", "an object, {...}");
    json_object_foreach((json_t *)(uintptr_t)object, name, value)
    {
        size_t i = 0, k = 0;
        while (i < count && strcmp(keys[i].name, name) != 0)
            i++;
        while (others[k] && strcmp(others[k], name) != 0)
            k++;
        if (has_key_error(r))
            return;
        if (i < count && !read_value(&keys[i], value, (char *)base + keys[i].offset)) {
            format_expected(&keys[i], wanted);
            refuse_key(r, where, name, wanted);
        } else if (i == count && !others[k] && name[0] != '_') {
            error_set(r->error, MR_MALFORMED,
                      "unknown key: %s: %s%s\"%s\"; correct the key (host/landing_series/README.md "
                      "lists the keys), or write _%s for a comment",
                      r->path, where, where[0] ? "." : "", name, name);
        }
    }
}

/* ---- series ---- */

#define IN_PER_FT 12.0

static const char *const engine_names[] = {"auto", "chain", "planar", NULL};
static const char *const ground_names[] = {"weightless", "elastic", NULL};

#define SERIES_OFFSET(field) offsetof(struct landing_series, field)
#define NUMBER_KEY(section, name, field, low, high)                             \
    {                                                                           \
        section, name, SERIES_KEY_NUMBER, SERIES_OFFSET(field), low, high, NULL \
    }
#define RANGE_KEY(section, name, field, low, high)                             \
    {                                                                          \
        section, name, SERIES_KEY_RANGE, SERIES_OFFSET(field), low, high, NULL \
    }
#define TEXT_KEY(name, field)                                   \
    {                                                           \
        NULL, name, SERIES_KEY_TEXT, SERIES_OFFSET(field), 0.0, \
            sizeof((struct landing_series *)0)->field, NULL     \
    }
const struct series_key series_keys[] = {
    RANGE_KEY("runway", "gap_in", gap_in, 0.0, 1000.0),
    RANGE_KEY("runway", "closing_lb", closing_lb, 0.0, 1e9),
    RANGE_KEY("runway", "irregularity_in", irregularity_in, 0.0, 1000.0),
    NUMBER_KEY("runway", "joint_lb_in", strength_lb_in, 0.0, 1e9),
    NUMBER_KEY("runway", "strip_ft", strip_ft, 1e-3, 1e4),
    NUMBER_KEY("runway", "unhinge_deg", unhinge_deg, 0.0, 180.0),
    NUMBER_KEY("runway", "wave_in", wave_in, 1e-6, 1000.0),
    NUMBER_KEY("runway", "buckle_in", buckle_in, 1e-6, 1000.0),
    NUMBER_KEY("aircraft", "weight_lb", weight_lb, 0.0, 1e9),
    NUMBER_KEY("aircraft", "axles", axles, 1.0, 1e6),
    NUMBER_KEY("aircraft", "onset_s", onset_s, 0.0, 60.0),
    NUMBER_KEY("aircraft", "dwell_s", dwell_s, 0.0, 60.0),
    {"engine", "use", SERIES_KEY_CHOICE, SERIES_OFFSET(engine), 0.0, 0.0, engine_names},
    NUMBER_KEY("engine", "chain_dt_s", chain_dt_s, 0.0, 1.0),
    NUMBER_KEY("engine", "planar_dt_s", planar_dt_s, 0.0, 1.0),
    NUMBER_KEY("engine", "skip_share", planar_min_lift_share, -1.0, 1e3),
};
const size_t series_key_count = sizeof series_keys / sizeof series_keys[0];

static const struct series_key root_keys[] = {
    TEXT_KEY("name", name),
    TEXT_KEY("observed", observed),
    TEXT_KEY("basis", basis),
    TEXT_KEY("afterwards", changes_after_outcome),
    {NULL, "ground", SERIES_KEY_CHOICE, SERIES_OFFSET(has_elastic_ground), 0.0, 0.0, ground_names},
    {NULL, "press_flat", SERIES_KEY_FLAG, SERIES_OFFSET(flattens_waves), 0.0, 0.0, NULL},
};

#define LANDING_OFFSET(field) offsetof(struct series_landing, field)
static const struct series_key landing_keys[] = {
    {NULL, "touchdown_ft", SERIES_KEY_RANGE, LANDING_OFFSET(touchdown_ft), -1e6, 1e6, NULL},
    {NULL, "speed_ft_s", SERIES_KEY_RANGE, LANDING_OFFSET(speed_ft_s), 1e-3, 1e4, NULL},
    {NULL, "deceleration_ft_s2", SERIES_KEY_RANGE, LANDING_OFFSET(deceleration_ft_s2), 0.0, 1e4,
     NULL},
    {NULL, "tow_lb", SERIES_KEY_NUMBER, LANDING_OFFSET(tow_lb), 1e-6, 1e9, NULL},
    {NULL, "times", SERIES_KEY_NUMBER, LANDING_OFFSET(repeat_count), 1.0, SERIES_LANDINGS_MAX,
     NULL},
};
#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

json_t *series_key_to_json(const struct series_key *key, const struct landing_series *c)
{
    const void *field = (const char *)c + key->offset;
    const struct series_range *range = field;
    unsigned choice;
    if (key->kind == SERIES_KEY_NUMBER)
        return json_real(*(const double *)field);
    if (key->kind == SERIES_KEY_RANGE)
        return range->low == range->high ? json_real(range->low)
                                         : json_pack("[f,f]", range->low, range->high);
    memcpy(&choice, field, sizeof choice);
    return json_string(key->choices[choice]);
}

static void read_sections(const struct key_reader *r, const json_t *root, struct landing_series *c)
{
    static const char *const none[] = {NULL};
    for (size_t i = 0, count; i < series_key_count && !has_key_error(r); i += count) {
        const json_t *section = json_object_get(root, series_keys[i].section);
        for (count = 0; i + count < series_key_count &&
                        strcmp(series_keys[i + count].section, series_keys[i].section) == 0;)
            count++;
        if (section)
            read_object(r, series_keys[i].section, section, &series_keys[i], count, none, c);
    }
}

static void read_seeds(const struct key_reader *r, const json_t *root, struct landing_series *c)
{
    const json_t *seeds = json_object_get(root, "seeds");
    double first = 1.0, last = 16.0;
    if (json_is_integer(seeds)) {
        last = (double)json_integer_value(seeds);
    } else if (json_is_array(seeds) && json_array_size(seeds) == 2 &&
               json_is_integer(json_array_get(seeds, 0)) &&
               json_is_integer(json_array_get(seeds, 1))) {
        first = (double)json_integer_value(json_array_get(seeds, 0));
        last = (double)json_integer_value(json_array_get(seeds, 1));
    } else if (seeds) {
        refuse_key(r, "", "seeds", "give the number of seeds, or [first, last]");
    }
    if (!(first >= 0.0 && last >= first && last < 1e15 && last - first < SERIES_SEEDS_MAX)) {
        refuse_key(r, "", "seeds", "1 to 10000 seeds, as a number or [first, last]");
        return;
    }
    c->first_seed = (uint64_t)first;
    c->seed_count = (size_t)(last - first) + 1;
}

static void read_stations(const struct key_reader *r, const json_t *root, struct landing_series *c)
{
    const json_t *list = json_object_get(root, "stations_ft");
    struct quantity_error wrong;
    double runway_ft = c->landings[0].scene.mats * c->landings[0].scene.length_ft;
    if (!list) { /* default: eleven stations, one every 10 ft of the rig's 120 ft */
        for (c->station_count = 0; c->station_count < 11; c->station_count++)
            c->stations_ft[c->station_count] = runway_ft * (double)(c->station_count + 1) / 12.0;
        return;
    }
    c->station_count = json_array_size(list);
    if (!json_is_array(list) || c->station_count == 0 || c->station_count > SERIES_STATIONS_MAX)
        refuse_key(r, "", "stations_ft", "a list of 1 to 64 stations");
    for (size_t i = 0; i < c->station_count && !has_key_error(r); i++) {
        if (!quantity_read_json(json_array_get(list, i), "ft", &c->stations_ft[i], &wrong) ||
            !(c->stations_ft[i] >= 0.0 && c->stations_ft[i] <= runway_ft))
            refuse_key(r, "", "stations_ft", "stations on the runway");
    }
}

static void read_profile(const struct key_reader *r, const char *where, const json_t *list,
                         struct series_landing *landing)
{
    landing->profile_count = json_array_size(list);
    if (landing->profile_count > SERIES_PROFILE_MAX) {
        refuse_key(r, where, "profile", "at most 16 rows [station in ft, deceleration in ft/s2]");
        return;
    }
    for (size_t i = 0; i < landing->profile_count && !has_key_error(r); i++) {
        const json_t *row = json_array_get(list, i), *x = json_array_get(row, 0),
                     *a = json_array_get(row, 1);
        struct series_knot *knot = &landing->profile[i];
        struct quantity_error wrong;
        if (json_array_size(row) != 2 || !quantity_read_json(x, "ft", &knot->station_ft, &wrong) ||
            !quantity_read_json(a, "ft/s2", &knot->deceleration_ft_s2, &wrong) ||
            !(knot->deceleration_ft_s2 >= 0.0) || !(knot->deceleration_ft_s2 <= 1e4) ||
            !isfinite(knot->station_ft) || (i > 0 && knot->station_ft <= knot[-1].station_ft))
            refuse_key(r, where, "profile",
                       "rows [station in ft, deceleration in ft/s2] in order of station, "
                       "decelerations from 0 to 10000");
    }
}

/* Applies the changes of a landing to the keys of the scene. */
static bool apply_scene_changes(const struct key_reader *r, const char *where,
                                const json_t *landing, json_t *now)
{
    json_t *apply = json_object_get(landing, "apply");
    if (apply && !json_is_object(apply))
        refuse_key(r, where, "apply", "an object of scene keys");
    json_object_update(now, apply);
    return apply;
}

/* Reads the scene of the runway before a landing. */
static void read_scene(const struct key_reader *r, const char *where, const json_t *now,
                       struct sim_scene *scene)
{
    char scene_where[700];
    snprintf(scene_where, sizeof scene_where, "%s: %s", r->path, where);
    sim_scene_from_json(scene, scene_where, (json_t *)now, r->error);
}

static void read_landing(const struct key_reader *r, const char *where, const json_t *entry,
                         json_t *now, struct series_landing *landing)
{
    static const char *const others[] = {"profile", "apply", NULL};
    read_object(r, where, entry, landing_keys, COUNT_OF(landing_keys), others, landing);
    const json_t *deceleration = json_object_get(entry, "deceleration_ft_s2"),
                 *profile = json_object_get(entry, "profile");
    if (!has_key_error(r) && !!deceleration + !!profile + (landing->tow_lb > 0.0) != 1)
        refuse_key(r, where, "deceleration_ft_s2", "one of deceleration_ft_s2, profile and tow_lb");
    if (profile && !has_key_error(r))
        read_profile(r, where, profile, landing);
    if (has_key_error(r))
        return;
    landing->is_modified = apply_scene_changes(r, where, entry, now);
    if (!has_key_error(r))
        read_scene(r, where, now, &landing->scene);
    if (!has_key_error(r) &&
        landing->touchdown_ft.high >= landing->scene.mats * landing->scene.length_ft) {
        char expected[100];
        snprintf(expected, sizeof expected, "a station before the end of the runway, %.6g ft",
                 landing->scene.mats * landing->scene.length_ft);
        refuse_key(r, where, "touchdown_ft", expected);
    }
}

/* Refuses keys that the simulation sets for each landing. */
static void check_scene(const struct key_reader *r, const json_t *scene)
{
    static const char *const own[] = {"model", "path",    "gap0",    "grit",  "ground",
                                      "bump",  "t_dwell", "tend",    "t_out", "Vac",
                                      "s0",    "F",       "F_tstop", NULL};
    if (!json_is_object(scene))
        refuse_key(r, "", "scene", "an object of scene keys, or the name of a scene file");
    for (size_t i = 0; own[i] && !has_key_error(r); i++) {
        if (json_object_get(scene, own[i]))
            error_set(r->error, MR_MALFORMED,
                      "key not allowed here: %s: scene.%s; leave the key out, because the runway "
                      "and the landings determine its value",
                      r->path, own[i]);
    }
}

static void read_landings(const struct key_reader *r, const json_t *root, const json_t *scene,
                          struct landing_series *c)
{
    const json_t *list = json_object_get(root, "landings"), *entry;
    json_t *now = json_deep_copy(scene);
    size_t i;
    c->landings = xcalloc(SERIES_LANDINGS_MAX, sizeof *c->landings);
    if (!json_is_array(list) || json_array_size(list) == 0)
        refuse_key(r, "", "landings", "a list of at least one landing");
    /* The simulation adds heights and paths later; these values only make the scene valid. */
    json_object_set_new(now, "model", json_string("consistent"));
    json_object_set_new(now, "t_dwell", json_real(c->dwell_s));
    json_array_foreach(list, i, entry)
    {
        char where[40];
        double times = 1.0;
        snprintf(where, sizeof where, "landings[%zu]", i);
        if (has_key_error(r))
            break;
        for (size_t k = 0; k < (size_t)times && !has_key_error(r); k++) {
            if (c->landing_count == SERIES_LANDINGS_MAX) {
                error_set(r->error, MR_MALFORMED, "too many landings: %s: more than %d; give fewer",
                          r->path, SERIES_LANDINGS_MAX);
                break;
            }
            struct series_landing *landing = &c->landings[c->landing_count++];
            sim_scene_set_defaults(&landing->scene);
            landing->touchdown_ft = (struct series_range){SERIES_DEFAULT_TOUCHDOWN_FT,
                                                          SERIES_DEFAULT_TOUCHDOWN_FT};
            landing->speed_ft_s = (struct series_range){SERIES_DEFAULT_SPEED_FT_S,
                                                        SERIES_DEFAULT_SPEED_FT_S};
            landing->repeat_count = 1.0;
            read_landing(r, where, entry, now, landing);
            times = landing->repeat_count;
            landing->is_modified = landing->is_modified && k == 0;
        }
    }
    json_decref(now);
}

static void check_same_runway(const struct key_reader *r, const struct landing_series *c)
{
    const struct sim_scene *first = &c->landings[0].scene;
    for (size_t i = 1; i < c->landing_count && !has_key_error(r); i++) {
        const struct sim_scene *scene = &c->landings[i].scene;
        if (scene->mats != first->mats || scene->length_ft != first->length_ft ||
            scene->slack_ft != first->slack_ft)
            error_set(r->error, MR_MALFORMED,
                      "runways differ: %s: N, L or slack of landing %zu differs from landing 1; "
                      "give these keys only in scene",
                      r->path, i + 1);
    }
}

void series_make_sibling_path(const char *file, const char *name, char path[PATH_MAX])
{
    const char *slash = file ? strrchr(file, '/') : NULL;
    int folder = slash && name[0] != '/' ? (int)(slash - file) + 1 : 0;
    snprintf(path, PATH_MAX, "%.*s%s", folder, file ? file : "", name);
}

json_t *series_read_json(const char *file, const char *name, const char *what, struct error *error)
{
    char path[PATH_MAX];
    json_error_t where;
    errno = 0;
    series_make_sibling_path(file, name, path);
    json_t *root = json_load_file(path, JSON_REJECT_DUPLICATES, &where);
    if (json_is_object(root))
        return root;
    if (root)
        error_set(error, MR_MALFORMED, "not a %s: %s: the file is not a JSON object; begin with {",
                  what, path);
    else if (json_error_code(&where) == json_error_cannot_open_file)
        error_set(error, MR_IO, "cannot open %s: %s: %s; check the path", what, path,
                  strerror(errno));
    else if (json_error_code(&where) == json_error_premature_end_of_input)
        error_set(error, MR_TRUNCATED,
                  "%s ends too early: %s line %d column %d: %s; correct that line", what, path,
                  where.line, where.column, where.text);
    else
        error_set(error, MR_MALFORMED,
                  "malformed JSON: %s line %d column %d: %s; correct that line", path, where.line,
                  where.column, where.text);
    json_decref(root);
    return NULL;
}

/* Returns the object of a key, or of the file that the key names. The caller owns the reference. */
static json_t *load_json_object(const char *file, const json_t *root, const char *key,
                                struct error *error)
{
    json_t *value = json_object_get(root, key);
    return json_is_string(value) ? series_read_json(file, json_string_value(value), key, error)
                                 : json_incref(value);
}

json_t *series_get_elastic_ground_json(const char *file, const json_t *root, struct error *error)
{
    const struct key_reader r = {file, error};
    json_t *elastic = load_json_object(file, root, "elastic", error);
    if (elastic && !has_key_error(&r) && !json_is_object(elastic))
        refuse_key(&r, "", "elastic", "an object of scene keys, or the name of a file of them");
    return elastic;
}

json_t *series_get_scene_json(const char *file, const json_t *root, struct error *error)
{
    const struct key_reader r = {file, error};
    const char *ground = json_string_value(json_object_get(root, "ground"));
    json_t *scene = load_json_object(file, root, "scene", error);
    if (!scene || !ground || strcmp(ground, "elastic") != 0)
        return scene;
    json_t *elastic = series_get_elastic_ground_json(file, root, error),
           *both = json_deep_copy(scene);
    if (!elastic && !has_key_error(&r))
        error_set(error, MR_MALFORMED,
                  "elastic ground without a stiffness: %s; give the key elastic, an object of "
                  "scene keys with gear_k_lb_ft",
                  file);
    if (elastic && !has_key_error(&r))
        json_object_update(both, elastic);
    json_decref(elastic);
    json_decref(scene);
    return both;
}

static void read_root(const struct key_reader *r, const json_t *root, struct landing_series *c)
{
    static const char *const others[] = {"scene", "runway",      "aircraft", "engine", "landings",
                                         "seeds", "stations_ft", "elastic",  NULL};
    read_object(r, "", root, root_keys, COUNT_OF(root_keys), others, c);
    if (has_key_error(r))
        return;
    read_sections(r, root, c);
    read_seeds(r, root, c);
    json_t *scene = has_key_error(r) ? NULL : series_get_scene_json(r->path, root, r->error);
    if (!has_key_error(r))
        check_scene(r, scene);
    if (!has_key_error(r))
        read_landings(r, root, scene, c);
    if (!has_key_error(r))
        check_same_runway(r, c);
    if (!has_key_error(r))
        read_stations(r, root, c);
    json_decref(scene);
}

enum mr_status series_from_json(struct landing_series *c, const char *where, const json_t *root,
                                struct error *error)
{
    const struct key_reader r = {where, error};
    /* defaults in model scale, from the standard series (README.md, "Calibration") */
    *c = (struct landing_series){
        .gap_in = {0.0, 0.036},
        .closing_lb = {0.0, 20.0},
        .irregularity_in = {0.0, 0.043},
        .strength_lb_in = 12.0,
        .strip_ft = 12.0 / 7.0,
        .unhinge_deg = 30.0,
        .wave_in = 0.05,
        .buckle_in = 24.0 / 7.0,
        .weight_lb = 1300.0,
        .axles = 12.0,
        .onset_s = 0.05,
        .dwell_s = 0.3,
        .planar_min_lift_share = 0.9,
    };
    read_root(&r, root, c);
    if (has_key_error(&r))
        series_free(c);
    if (!has_key_error(&r) && !c->name[0])
        snprintf(c->name, sizeof c->name, "%s", where);
    return error->status;
}

enum mr_status series_load(struct landing_series *c, const char *path, struct error *error)
{
    return series_load_on_ground(c, path, NULL, error);
}

enum mr_status series_load_on_ground(struct landing_series *c, const char *path, const char *ground,
                                     struct error *error)
{
    *c = (struct landing_series){0};
    json_t *root = series_read_json(NULL, path, "study", error);
    if (root && ground)
        json_object_set_new(root, "ground", json_string(ground));
    if (root)
        series_from_json(c, path, root, error);
    json_decref(root);
    return error->status;
}

void series_describe_ground(const struct landing_series *c, char *text, size_t size)
{
    const struct sim_scene *s = &c->landings[0].scene;
    const struct sim_key *key = sim_key_find("gear_k_lb_ft");
    double k = *(const double *)((const char *)s + key->offset), axles = 0.0;
    size_t lines = s->gear.line_setbacks_ft.count > 0 ? s->gear.line_setbacks_ft.count : 1;
    for (size_t i = 0; i < lines; i++)
        axles += s->gear.axle_counts.count > 0 ? s->gear.axle_counts.values[i] : 1.0;
    if (k > 0.0)
        snprintf(text, size,
                 "elastic ground under a gear with weight: %.6g lb/ft per mat and axle, %.6g lb "
                 "per axle, %g axles in %zu line%s",
                 k, s->wheel_load_lb, axles, lines, lines == 1 ? "" : "s");
    else if (s->wheel_load_lb > 0.0)
        snprintf(text, size, "Coulomb friction under one axle of %.6g lb", s->wheel_load_lb);
    else
        snprintf(text, size, "weightless gear: thrust of one axle on mats without load");
}

void series_free(struct landing_series *series)
{
    for (size_t i = 0; i < series->landing_count; i++)
        sim_scene_free(&series->landings[i].scene);
    free(series->landings);
    *series = (struct landing_series){0};
}
