/* The command matrig scale: converts quantities, scene files and study files between model and
 * prototype. Similitude is the conversion by powers of the length scale. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/commands/commands.h"
#include "host/landing_series/series.h"
#include "host/sim/scene/scene.h"

#define WORDS_MAX 32

struct request {
    /* keeps_modulus: the materials keep their stiffness; false: they keep their density */
    bool keeps_modulus, to_model, force;
    double length_scale;
    const char *to, *keep; /* as the user typed it; NULL: not given */
    const char *output_path;
    const char *words[WORDS_MAX];
    size_t count;
};

static void read_request(int argc, char **argv, const struct cli *cli, struct request *request)
{
    command_parse(&command_scale, argc, argv, cli, request, request->words, fatal);
    while (request->count < WORDS_MAX && request->words[request->count])
        request->count++;
    request->to_model = request->to && strcmp(request->to, "model") == 0;
    request->keeps_modulus = request->keep && strcmp(request->keep, "modulus") == 0;
}

/* Returns, for a value in this unit, the exponent of the length scale n in the ratio prototype /
 * model, multiplied by 2. Length scales with n and time with sqrt(n), as gravity is equal. Force
 * scales with n^3 if the density of the materials is kept (the 1/7 model: Table 2.2), with n^2 if
 * their stiffness is kept (the pilot model: Table B.2). All other exponents are computed from the
 * dimensions of the unit. */
static int compute_doubled_exponent(const struct request *request, const char *unit)
{
    int powers[3]; /* powers of force, length and time in the unit */
    quantity_find_dimension(unit, powers);
    return (request->keeps_modulus ? 4 : 6) * powers[0] + 2 * powers[1] + powers[2];
}

/* Returns the factor by which a value in this unit is multiplied. */
static double find_factor(const struct request *request, const char *unit)
{
    double ratio = pow(request->length_scale, 0.5 * compute_doubled_exponent(request, unit));
    return request->to_model ? 1.0 / ratio : ratio;
}

/* Makes an answer with the facts that all subcommands print. */
static struct answer *make_answer(const struct request *request)
{
    /* not in SI, because scene keys have fixed units */
    struct answer *answer = answer_new(false);
    answer_add_text(answer, "keep", NULL, request->keeps_modulus ? "modulus" : "density");
    answer_add_value(answer, "n", NULL, UNIT_NUMBER, request->length_scale, 0)->digits = 17;
    answer_add_text(answer, "to", NULL, request->to_model ? "model" : "prototype");
    return answer;
}

/* ---- quantities ---- */

static const struct quantity {
    const char *name, *symbol, *unit;
} quantities[] = {
    {"length", "l", "ft"},
    {"area", "A", "ft2"},
    {"time", "t", "s"},
    {"velocity", "v", "ft/s"},
    {"acceleration", "a", "ft/s2"},
    {"gravity", "g", "ft/s2"},
    {"angle", "theta", "deg"},
    {"friction", "f", ""},
    {"landings", "N", ""},
    {"weight", "W", "lb"},
    {"force", "F", "lb"},
    {"moment", "M", "ft lb"},
    {"mass", "m", "slug"},
    {"density", "rho", "slug/ft3"},
    {"modulus", "E", "lb/ft2"},
    {"pressure", "p", "lb/ft2"},
    {"soil_modulus", "k", "lb/ft3"},
    {"inertia", "I", "slug ft2"},
    {"stiffness", "KL", "lb/ft"},
    {"soil_stiffness", "KV", "lb/ft"},
    {"torsional_stiffness", "KT", "ft lb/rad"},
    {"damping", "CL", "lb s/ft"},
    {"soil_damping", "CV", "lb s/ft"},
    {"torsional_damping", "CT", "ft lb s/rad"},
    {"line_force", "q", "lb/ft"},
};
#define QUANTITY_COUNT (sizeof quantities / sizeof quantities[0])

static const struct quantity *find_quantity(const char *name,
                                            int (*compare)(const char *, const char *))
{
    for (size_t i = 0; i < QUANTITY_COUNT; i++) {
        if (compare(quantities[i].name, name) == 0 || compare(quantities[i].symbol, name) == 0)
            return &quantities[i];
    }
    return NULL;
}

/* Writes a power of n: "n^3", "n^2.5", "n", "1/n" or "1". */
static void format_power(int doubled_exponent, char text[16])
{
    int size = abs(doubled_exponent);
    char number[8] = "";
    if (size != 2)
        snprintf(number, sizeof number, size % 2 ? "^%d.5" : "^%d", size / 2);
    if (doubled_exponent == 0)
        snprintf(text, 16, "1");
    else
        snprintf(text, 16, "%sn%s", doubled_exponent < 0 ? "1/" : "", number);
}

/* Prints every ratio; used without operands. */
static int show_ratios(const struct request *request, const struct cli *cli)
{
    struct answer *answer = make_answer(request);
    answer_add_sentence(answer, NULL, "prototype / model at n = %g, %s kept", request->length_scale,
                        request->keeps_modulus ? "modulus" : "density");
    answer_open_table(answer, "ratios", "");
    for (size_t i = 0; i < QUANTITY_COUNT; i++) {
        const struct quantity *quantity = &quantities[i];
        char power[16];
        int doubled_exponent = compute_doubled_exponent(request, quantity->unit);
        format_power(doubled_exponent, power);
        answer_open_row(answer);
        answer_add_text(answer, "name", "quantity", "%s", quantity->name);
        answer_add_text(answer, "symbol", "symbol", "%s", quantity->symbol);
        answer_add_text(answer, "power", "power", "%s", power);
        answer_add_value(answer, "ratio", "ratio", UNIT_NUMBER,
                         pow(request->length_scale, 0.5 * doubled_exponent), -6)
            ->digits = 12;
    }
    answer_close_group(answer);
    return answer_print(cli, answer, 0);
}

struct quantity_value {
    const struct quantity *quantity;
    double from, to;
};

static void read_value(const char *word, struct quantity_value *value)
{
    const char *equals = strchr(word, '=');
    char name[40];
    if (!equals || equals == word || (size_t)(equals - word) >= sizeof name)
        error_set(fatal, MR_USAGE,
                  "not a quantity: '%s'; give NAME=VALUE (matrig scale lists the names)", word);
    snprintf(name, sizeof name, "%.*s", (int)(equals - word), word);
    value->quantity = find_quantity(name, strcmp);
    const struct quantity *meant = find_quantity(name, strcasecmp);
    if (!value->quantity && meant)
        error_set(fatal, MR_USAGE,
                  "unknown quantity: '%s'; '%s' is for %s; matrig scale lists the names", name,
                  meant->symbol, meant->name);
    if (!value->quantity)
        error_set(fatal, MR_USAGE, "unknown quantity: '%s'; matrig scale lists the names", name);
    /* "24.5kN" and "24.5 kN" have their own unit; "108" is in the unit of the quantity */
    const char *own = value->quantity->unit;
    quantity_read(equals + 1, name, own, NULL, &value->from, fatal);
    if (fabs(value->from) > 1e30)
        error_set(fatal, MR_USAGE, "out of range: %s for %s; allowed: -1e30 to 1e30 %s", equals + 1,
                  name, own);
}

static int scale_values(const struct request *request, const struct cli *cli)
{
    struct quantity_value values[WORDS_MAX];
    for (size_t i = 0; i < request->count; i++) {
        read_value(request->words[i], &values[i]);
        for (size_t k = 0; k < i; k++) {
            if (values[k].quantity == values[i].quantity)
                error_set(fatal, MR_USAGE, "%s is given twice; leave one out",
                          values[i].quantity->name);
        }
        values[i].to = values[i].from * find_factor(request, values[i].quantity->unit);
    }
    struct answer *answer = make_answer(request);
    answer_open_group(answer, "values", "");
    for (size_t i = 0; i < request->count; i++) {
        const struct quantity *quantity = values[i].quantity;
        answer_add_text(answer, NULL, quantity->name, "%14.8g  ->  %14.8g %s", values[i].from,
                        values[i].to, quantity->unit);
        answer_open_group(answer, quantity->name, NULL);
        answer_add_value(answer, "from", NULL, UNIT_NUMBER, values[i].from, 0)->digits = 12;
        answer_add_value(answer, "to", NULL, UNIT_NUMBER, values[i].to, 0)->digits = 12;
        answer_add_text(answer, "unit", NULL, "%s", quantity->unit);
        answer_close_group(answer);
    }
    answer_close_group(answer);
    return answer_print(cli, answer, 0);
}

/* ---- scene and study files ---- */

/* Scales a number in `unit`, a text that has a unit, or a list of these. Other values are copied;
 * the loader refuses them. */
static json_t *scale_value(const struct request *request, const json_t *value, const char *unit)
{
    double number;
    struct quantity_error wrong;
    /* numbers without dimension, mat numbers and names are not scaled */
    if (!quantity_kind_find(unit))
        return json_deep_copy(value);
    if (quantity_read_json(value, unit, &number, &wrong))
        return json_real(number * find_factor(request, unit));
    if (!json_is_array(value))
        return json_deep_copy(value);
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(value); i++) {
        json_t *entry = json_array_get(value, i), *last = json_array_get(entry, 2);
        json_t *other = last ? json_deep_copy(entry) : scale_value(request, entry, unit);
        if (last) /* the value of a row [first, last, value] for a part of the runway */
            json_array_set_new(other, 2, scale_value(request, last, unit));
        json_array_append_new(list, other);
    }
    return list;
}

/* Scales rows whose columns have the units `units`. */
static json_t *scale_rows(const struct request *request, const json_t *rows,
                          const char *const *units)
{
    json_t *result = json_array();
    for (size_t i = 0; i < json_array_size(rows); i++) {
        json_t *row = json_array();
        for (size_t c = 0; units[c]; c++)
            json_array_append_new(
                row, scale_value(request, json_array_get(json_array_get(rows, i), c), units[c]));
        json_array_append_new(result, row);
    }
    return result;
}

/* Scales the value of every key according to its unit: that of the scene key, or that at the end of
 * the name. Also scales nested objects and landings. */
static json_t *scale_object(const struct request *request, const json_t *object)
{
    static const char *const path[] = {"s", "ft", "lb", NULL}, *const profile[] = {"ft", "ft/s2",
                                                                                   NULL};
    json_t *result = json_object(), *value, *entry;
    const char *key;
    size_t i;
    json_object_foreach((json_t *)object, key, value)
    {
        const struct sim_key *known = sim_key_find(key);
        json_t *other;
        if (strcmp(key, "landings") == 0) {
            other = json_array();
            json_array_foreach(value, i, entry)
                json_array_append_new(other, scale_object(request, entry));
        } else if (json_is_object(value))
            other = scale_object(request, value);
        else if (known && known->kind == SIM_KEY_PATH)
            other = scale_rows(request, value, path);
        else if (strcmp(key, "profile") == 0 && json_is_array(value))
            other = scale_rows(request, value, profile);
        else if (key[0] == '_')
            other = json_deep_copy(value);
        else
            other = scale_value(request, value, known ? known->unit : quantity_unit_from_name(key));
        json_object_set_new(result, key, other);
    }
    return result;
}

/* Returns the default of a scene key if the default depends on the scale; 0: it does not. */
static double find_default(const struct request *request, const struct sim_key *key)
{
    struct sim_scene plain;
    double value;
    sim_scene_set_defaults(&plain);
    if (key->kind != SIM_KEY_REAL || find_factor(request, key->unit) == 1.0)
        return 0.0;
    memcpy(&value, (const char *)&plain + key->offset, sizeof value);
    return isfinite(value) && value > 0.0 ? value : 0.0;
}

/* Adds defaults that depend on the scale, because matrig's defaults are for the model. Defaults of
 * a modification are added only if `scene` has the modification, defaults of the scene itself only
 * if `whole`. */
static void add_changing_defaults(const struct request *request, const json_t *scene, bool whole,
                                  json_t *result)
{
    static const char *const gates[][2] = {
        {"band_", "bands"}, {"band2_", "bands2"}, {"cleat_", "cleat_every"}};
    const struct sim_key *key;
    bool follows_path = json_object_get(scene, "path") != NULL;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        double value = find_default(request, key);
        bool wanted = whole && !(follows_path &&
                                 (strcmp(key->name, "F") == 0 || strcmp(key->name, "Vac") == 0));
        for (size_t g = 0; g < sizeof gates / sizeof gates[0]; g++) {
            if (strncmp(key->name, gates[g][0], strlen(gates[g][0])) == 0)
                wanted = json_object_get(scene, gates[g][1]) != NULL;
        }
        if (value != 0.0 && wanted && !json_object_get(result, key->name))
            json_object_set_new(result, key->name, json_real(value));
    }
}

static void set_default(json_t *object, const char *key, json_t *value)
{
    if (json_object_get(object, key))
        json_decref(value);
    else
        json_object_set_new(object, key, value);
}

/* Writes all keys of scene, runway, aircraft and engine into the study, because the defaults are
 * for the model. */
static json_t *expand_study_defaults(const struct request *request, const json_t *source,
                                     const struct landing_series *c, struct error *error)
{
    const char *path = request->words[0];
    json_t *held = series_get_scene_json(path, source, error), *scene = json_deep_copy(held),
           *elastic = series_get_elastic_ground_json(path, source, error), *entry;
    json_t *study = json_deep_copy(source);
    size_t i;
    json_array_foreach(json_object_get(study, "landings"), i, entry)
    {
        set_default(entry, "touchdown_ft", json_real(SERIES_DEFAULT_TOUCHDOWN_FT));
        set_default(entry, "speed_ft_s", json_real(SERIES_DEFAULT_SPEED_FT_S));
        add_changing_defaults(request, json_object_get(entry, "apply"), false, scene);
    }
    add_changing_defaults(request, scene, true, scene);
    json_object_del(scene, "F"); /* remove F, which the landings define */
    json_object_del(scene, "Vac");
    json_object_set_new(study, "scene", scene);
    if (elastic)
        json_object_set_new(study, "elastic", elastic);
    for (i = 0; i < series_key_count; i++) {
        const struct series_key *key = &series_keys[i];
        set_default(study, key->section, json_object());
        set_default(json_object_get(study, key->section), key->name, series_key_to_json(key, c));
    }
    json_decref(held);
    return study;
}

/* Returns the scaled file. The source is loaded first, so that an invalid file is refused as in
 * `sim` or `study`. */
static json_t *scale_json(const struct request *request, const json_t *source, bool is_study)
{
    const char *path = request->words[0];
    struct sim_scene scene;
    struct landing_series series;
    json_t *whole;
    if (is_study) {
        series_load(&series, path, fatal);
        whole = expand_study_defaults(request, source, &series, fatal);
        series_free(&series);
    } else {
        sim_scene_load(&scene, path, fatal);
        whole = json_deep_copy(source);
        add_changing_defaults(request, source, true, whole);
        sim_scene_free(&scene);
    }
    json_t *other = scale_object(request, whole);
    if (is_study)
        json_object_set_new(other, "_scaled",
                            json_sprintf("Converted to %s scale by matrig scale with n = %g, %s "
                                         "kept. Texts (name, observed) are unchanged.",
                                         request->to_model ? "model" : "prototype",
                                         request->length_scale,
                                         request->keeps_modulus ? "modulus" : "density"));
    json_decref(whole);
    return other;
}

/* Scales a file: a scene, or a study if the file has landings. */
static int scale_file(const struct request *request, const struct cli *cli)
{
    output_check_not_input(request->output_path, request->words[0], fatal);
    json_t *source = json_load_file(request->words[0], 0, NULL);
    bool is_study = json_object_get(source, "landings") != NULL;
    json_t *other = scale_json(request, source, is_study);
    int code = 0;
    if (request->output_path || !cli->json)
        output_write_json(request->output_path, other, 17, fatal);
    if (cli->json) {
        struct answer *answer = make_answer(request);
        answer_add_json(answer, is_study ? "study" : "scene", json_incref(other));
        code = answer_print(cli, answer, 0);
    } else if (request->output_path) {
        printf("%s: %s at n = %g\n", request->output_path,
               request->to_model ? "model" : "prototype", request->length_scale);
    }
    json_decref(source);
    json_decref(other);
    return code;
}

static int scale_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    read_request(argc, argv, cli, &request);
    bool file = request.count == 1 && !strchr(request.words[0], '=');
    if (request.output_path && request.count > 0 && !file)
        error_set(fatal, MR_USAGE, "-o %s works only with a scene; leave -o out",
                  request.output_path);
    output_check(request.output_path, file ? request.words[0] : NULL, fatal);
    output_check_new(request.output_path, request.force, fatal);
    if (request.count == 0)
        return show_ratios(&request, cli);
    return file ? scale_file(&request, cli) : scale_values(&request, cli);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("NAME=VALUE",
              "a quantity, given by name or symbol; without any argument, all ratios are listed"),
    HELP_ITEM(
        "SCENE",
        "scene file, JSON: every key is scaled. Defaults that depend on the scale are included"),
    HELP_ITEM("STUDY",
              "study file, JSON: runway, aircraft, landings, modifications and scene are scaled"),
    OPTION_CHOICE("--to", "SIDE", to, "side", "model|prototype",
                  "convert to prototype (from model values) or to model; default: prototype"),
    OPTION_NUMBER("--n", "N", length_scale, NULL, 1e-3, 1e3, 7.0,
                  "prototype length / model length; default: {standard}"),
    HELP_ITEM("--keep density", "rule of the 1/7 model: forces scale by n^3 (default)"),
    HELP_ITEM("--keep modulus", "rule of the small model of the pilot study: forces scale by n^2"),
    OPTION_TEXT("-o", "F.json", output_path, "file for the scene; default: standard output"),
    OPTION_FORCE(force),
    HELP_NOTE("Units are those of the scene keys (ft, lb, slug, s), even with --si; a value may "
              "have its own unit: F=480N."),
    HELP_EXAMPLE(
        "matrig scale F=108 v=35.5; matrig scale host/scenes/model_runway.json -o prototype.json"),
    OPTION_CHOICE("--keep", "RULE", keep, "rule", "density|modulus", NULL),
};

const struct command command_scale = {
    "scale",
    scale_command,
    "[NAME=VALUE... | SCENE | STUDY] [--to model|prototype] [--n N] [--keep density|modulus] [-o "
    "F] [--force]",
    "convert quantities, scenes and study files between model and prototype",
    COMMAND_PARTS(parts),
    {0, WORDS_MAX, "NAME=VALUE... or SCENE"},
};
