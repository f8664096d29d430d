/* matrig scale: scene files and studies. */
#include "host/landing_series/scale.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/landing_series/series.h"
#include "host/landing_series/summary.h"
#include "host/base/output.h"
#include "host/sim/scene/scene.h"
#include "host/base/quantity.h"

/* What a value is multiplied by. */
double scale_factor(const struct scale_request *request, struct mr_dimension dimension)
{
    double ratio = mr_similitude_ratio(request->rule, request->n, dimension);
    return request->to_model ? 1.0 / ratio : ratio;
}

/* ---- joints laid diagonally ----
 *
 * The joints of a standard pattern are turned. With c the cosine of the angle and b the width of
 * the strip:
 *
 * - Rows are L/c apart along the runway, so each weighs W/c, stands on 1/c of the soil (KV, CV),
 *   and has 1/c of the play.
 * - A joint is b/c long. A movement g along the runway opens it by g c; its force KL/c g c has the
 *   part c along the runway.
 * - Folding about the joint turns a row by t = slope/c across it, so energies KT/c t2/2 and I/c
 *   t'2/2 are 1/c3 of the slope's, and the dead angle is c of it. */
#define RADIANS (3.14159265358979323846 / 180.0)

/* What a scene key is multiplied by; 1: it stays. */
static double lay_factor(const char *key, double deg)
{
    static const struct {
        const char *name;
        int power;
    } keys[] = {
        {"L", -1},     {"W", -1},    {"KV", -1}, {"CV", -1}, {"KL", 1},  {"CL", 1},
        {"slack", -1}, {"gap0", -1}, {"I", -3},  {"KT", -3}, {"CT", -3}, {"TAD_deg", 1},
    };
    for (size_t i = 0; deg > 0.0 && i < sizeof keys / sizeof keys[0]; i++) {
        if (strcmp(keys[i].name, key) == 0)
            return pow(cos(deg * RADIANS), keys[i].power);
    }
    const struct sim_key *element = sim_key_find(key);
    return deg > 0.0 && element ? pow(cos(deg * RADIANS), element->lay) : 1.0;
}

/* The scene's lay_deg, and its N so that the runway stays as long. MR_USAGE when it lies so
 * already, or has a list by joint. */
static enum mr_status lay_scene(json_t *scene, double deg, const char *path, struct error *error)
{
    static const char *const by_joint[] = {"gap0", "grit", "ground", "stiff_gap0", "torn"};
    double mats = json_number_value(json_object_get(scene, "N"));
    if (json_number_value(json_object_get(scene, "lay_deg")) > 0.0)
        return error_set(error, MR_USAGE,
                         "laid already: %s: lay_deg is %g; give --lay a standard pattern", path,
                         json_number_value(json_object_get(scene, "lay_deg")));
    for (size_t i = 0; i < sizeof by_joint / sizeof by_joint[0]; i++) {
        if (json_is_array(json_object_get(scene, by_joint[i])))
            return error_set(error, MR_USAGE,
                             "joints that are no more: %s: %s is a list by joint, and --lay "
                             "changes how many there are; give one number, or leave "
                             "it out",
                             path, by_joint[i]);
    }
    json_object_set_new(scene, "N",
                        json_integer((json_int_t)fmax(1.0, round(mats * cos(deg * RADIANS)))));
    json_object_set_new(scene, "lay_deg", json_real(deg));
    return MR_OK;
}

struct answer *scale_answer(const struct scale_request *request)
{
    struct answer *answer = answer_new(false); /* scene keys have their units */
    answer_words(answer, "keep", NULL, request->rule == MR_KEEP_DENSITY ? "density" : "modulus");
    answer_value(answer, "n", NULL, UNIT_NUMBER, request->n, 0)->digits = 17;
    answer_words(answer, "to", NULL, request->to_model ? "model" : "prototype");
    if (request->lay_deg > 0.0)
        answer_value(answer, "lay_deg", NULL, UNIT_NUMBER, request->lay_deg, 0)->digits = 17;
    return answer;
}

/* What a value in this unit is multiplied by. */
static double factor_of(const struct scale_request *request, const char *unit)
{
    int powers[3];
    quantity_dimension(unit, powers);
    return scale_factor(request,
                        (struct mr_dimension){(signed char)powers[0], (signed char)powers[1],
                                              (signed char)powers[2]});
}

/* A number in `unit`, or text with its own, times `by`; what is neither stays for the reader to
 * refuse. */
static json_t *times(const json_t *value, double by, const char *unit)
{
    double number;
    struct quantity_wrong wrong;
    if (quantity_json(value, unit, &number, &wrong))
        return json_real(number * by);
    if (!json_is_array(value))
        return json_deep_copy(value);
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(value); i++)
        json_array_append_new(list, times(json_array_get(value, i), by, unit));
    return list;
}

static json_t *scaled(const struct scale_request *request, const json_t *value, const char *unit)
{
    return times(value, factor_of(request, unit), unit);
}

/* Rows whose columns have these units. */
static json_t *scaled_rows(const struct scale_request *request, const json_t *rows,
                           const char *const *units)
{
    json_t *result = json_array();
    for (size_t i = 0; i < json_array_size(rows); i++) {
        json_t *row = json_array();
        for (size_t c = 0; units[c]; c++)
            json_array_append_new(
                row, scaled(request, json_array_get(json_array_get(rows, i), c), units[c]));
        json_array_append_new(result, row);
    }
    return result;
}

/* A default that the other side has otherwise; 0: none. */
static double default_of(const struct scale_request *request, const struct sim_key *key)
{
    struct sim_scene plain;
    double value;
    sim_scene_defaults(&plain);
    if (key->kind != SIM_KEY_REAL ||
        (factor_of(request, key->unit) == 1.0 && lay_factor(key->name, request->lay_deg) == 1.0))
        return 0.0;
    memcpy(&value, (const char *)&plain + key->offset, sizeof value);
    return isfinite(value) && value > 0.0 ? value : 0.0;
}

/* Write out the defaults that change with scale, as the other side's differ. Those of modifications
 * only where `scene` has them, and those of `scene` itself where it is `whole`. */
static void complete(const struct scale_request *request, const json_t *scene, bool whole,
                     json_t *result)
{
    static const char *const gates[][2] = {{"band_", "bands"},
                                           {"band2_", "bands2"},
                                           {"cleat_", "cleat_every"},
                                           {"unhinge_", "unhinge_deg"}};
    const struct sim_key *key;
    bool follows_path = json_object_get(scene, "path") != NULL;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        double value = default_of(request, key);
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

/* A scene key's value on the other side. */
static json_t *scaled_entry(const struct scale_request *request, const char *key,
                            const json_t *value)
{
    static const char *const path[] = {"s", "ft", "lb", NULL};
    const struct sim_key *known = sim_key_find(key);
    if (known && known->kind == SIM_KEY_PATH)
        return scaled_rows(request, value, path);
    double by = lay_factor(key, request->lay_deg) * (known ? factor_of(request, known->unit) : 1.0);
    return by != 1.0 ? times(value, by, known->unit) : json_deep_copy(value);
}

/* Keys as written, scaled, and the defaults that change. */
static json_t *scaled_scene(const struct scale_request *request, const json_t *scene,
                            struct error *error)
{
    json_t *both = json_object(), *result = json_object(), *value;
    struct sim_scene plain;
    const char *key;
    sim_scene_defaults(&plain);
    json_object_update(both, (json_t *)scene);
    complete(request, scene, true, both);
    if (request->lay_deg > 0.0 && !json_object_get(both, "N"))
        json_object_set_new(both, "N", json_integer(plain.mats));
    if (request->lay_deg > 0.0)
        lay_scene(both, request->lay_deg, request->words[0], error);
    json_object_foreach(both, key, value)
    {
        json_object_set_new(result, key, scaled_entry(request, key, value));
    }
    json_decref(both);
    return result;
}

static json_t *scaled_range(const struct scale_request *request, struct series_range range,
                            const char *unit)
{
    json_t *value = series_range_json(range), *result = scaled(request, value, unit);
    json_decref(value);
    return result;
}

/* Runway, aircraft and engine, every key written out: the defaults are a model's. */
static void scaled_parts(const struct scale_request *request, const struct landing_series *c,
                         json_t *result)
{
    for (size_t i = 0; i < series_key_count; i++) {
        const struct series_key *key = &series_keys[i];
        const char *unit = quantity_unit_of_name(key->name);
        json_t *section = json_object_get(result, key->section), *value = series_key_json(key, c);
        if (i == 0 || strcmp(key->section, series_keys[i - 1].section) != 0)
            json_object_set_new(result, key->section, section = json_object());
        json_t *laid = times(
            value, strcmp(key->name, "gap_in") == 0 ? lay_factor("gap0", request->lay_deg) : 1.0,
            unit);
        json_object_set_new(section, key->name, scaled(request, laid, unit));
        json_decref(laid);
        json_decref(value);
    }
}

/* One entry of the file's landings; `scene` takes the defaults of what it applies. */
static json_t *scaled_landing(const struct scale_request *request, const json_t *entry,
                              const struct series_landing *landing, json_t *scene)
{
    static const char *const profile[] = {"ft", "ft/s2", NULL};
    json_t *result = json_deep_copy(entry), *value, *apply = json_object_get(entry, "apply");
    const char *key;
    json_object_set_new(result, "touchdown_ft", scaled_range(request, landing->touchdown_ft, "ft"));
    json_object_set_new(result, "speed_ft_s", scaled_range(request, landing->speed_ft_s, "ft/s"));
    if (json_object_get(entry, "deceleration_ft_s2"))
        json_object_set_new(result, "deceleration_ft_s2",
                            scaled(request, json_object_get(entry, "deceleration_ft_s2"), "ft/s2"));
    if (json_object_get(entry, "profile"))
        json_object_set_new(result, "profile",
                            scaled_rows(request, json_object_get(entry, "profile"), profile));
    json_object_foreach(apply, key, value)
    {
        json_object_set_new(json_object_get(result, "apply"), key,
                            scaled_entry(request, key, value));
    }
    complete(request, apply, false, scene);
    return result;
}

/* What elastic ground adds to the scene. */
static void scale_elastic(const struct scale_request *request, const char *path,
                          const json_t *source, json_t *result, struct error *error)
{
    json_t *elastic = series_elastic_json(path, source, error), *value;
    const char *key;
    if (!elastic)
        return;
    json_t *other = json_object();
    json_object_foreach(elastic, key, value)
    {
        json_object_set_new(other, key, scaled_entry(request, key, value));
    }
    json_object_set_new(result, "elastic", other);
    json_decref(elastic);
}

static json_t *scaled_campaign(const struct scale_request *request, const char *path,
                               const json_t *source, const struct landing_series *c,
                               struct error *error)
{
    json_t *held = series_scene_json(path, source, error), *scene = json_deep_copy(held);
    json_t *result = json_deep_copy(source), *list = json_array(), *entry;
    char note[200];
    size_t i, at = 0;
    json_array_foreach(json_object_get(source, "landings"), i, entry)
    {
        json_array_append_new(list, scaled_landing(request, entry, &c->landings[at], scene));
        double number = json_object_get(entry, "times")
                          ? json_number_value(json_object_get(entry, "times"))
                          : 1.0;
        at += (size_t)number;
    }
    if (request->lay_deg > 0.0)
        snprintf(note, sizeof note, "Joints at %g degrees by matrig scale --lay.",
                 request->lay_deg);
    else
        snprintf(note, sizeof note, "To %s scale by matrig scale: n %g, %s kept.",
                 request->to_model ? "model" : "prototype", request->n,
                 request->rule == MR_KEEP_DENSITY ? "density" : "modulus");
    strcat(note, " Texts (name, observed) are the original's.");
    json_object_del(result, "facts"); /* observed at the other scale */
    json_object_set_new(result, "_scaled", json_string(note));
    json_t *other = scaled_scene(request, scene, error);
    json_object_del(other, "F"); /* the landings give them */
    json_object_del(other, "Vac");
    json_object_set_new(result, "scene", other);
    scale_elastic(request, path, source, result, error);
    json_object_set_new(result, "landings", list);
    scaled_parts(request, c, result);
    if (json_object_get(source, "stations_ft"))
        json_object_set_new(result, "stations_ft",
                            scaled(request, json_object_get(source, "stations_ft"), "ft"));
    json_decref(scene);
    json_decref(held);
    return result;
}

/* Pure numbers of a scene; the same on both sides. */
static json_t *scene_numbers(const struct sim_scene *s)
{
    double wl = s->weight_lb * s->length_ft, second = sqrt(s->length_ft / s->g_ft_s2);
    double strip = s->weight_lb / s->length_ft;
    const struct {
        const char *name;
        double value;
    } numbers[] = {
        {"F/W", s->force_lb / s->weight_lb},
        {"Vac^2/(g L)", s->vac_ft_s * s->vac_ft_s / (s->g_ft_s2 * s->length_ft)},
        {"I g/(W L^2)", s->inertia_slug_ft2 * s->g_ft_s2 / (wl * s->length_ft)},
        {"KL L/W", s->kl_lb_ft / strip},
        {"KV L/W", s->kv_lb_ft / strip},
        {"KT/(W L)", s->kt_lb_ft_rad / wl},
        {"CL sqrt(g L)/W", s->cl_lb_s_ft / (strip * second)},
        {"CV sqrt(g L)/W", s->cv_lb_s_ft / (strip * second)},
        {"CT/(W L sqrt(L/g))", s->ct_lb_ft_s_rad / (wl * second)},
        {"f", s->friction},
    };
    json_t *object = json_object();
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        json_object_set_new(object, numbers[i].name, cli_json_number(numbers[i].value, 12));
    return object;
}

static enum mr_status write_scene(const struct scale_request *request, const json_t *scene,
                                  struct error *error)
{
    struct output output;
    if (output_begin(&output, request->output_path, error) != MR_OK)
        return error->status;
    json_dumpf(scene, output.file, JSON_INDENT(2) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(17));
    fputc('\n', output.file);
    return output_end(&output, error);
}

/* The file on the other side, and for a scene the numbers that both share. What is no scene is
 * refused as `sim` does, what is no campaign as `campaign` does; so is what came out, as joints
 * laid anew may not fit what else the file says. */
static json_t *scaled_file(const struct scale_request *request, const json_t *source,
                           bool is_campaign, json_t **numbers, struct error *error)
{
    const char *path = request->words[0];
    struct sim_scene scene;
    struct landing_series series;
    json_t *scaled = NULL;
    if (is_campaign) {
        if (series_load(&series, path, error) != MR_OK)
            return NULL;
        scaled = scaled_campaign(request, path, source, &series, error);
        series_free(&series);
        if (error->status == MR_OK && series_from_json(&series, path, scaled, error) == MR_OK)
            series_free(&series);
    } else {
        if (sim_scene_load(&scene, path, error) != MR_OK)
            return NULL;
        *numbers = scene_numbers(&scene);
        scaled = scaled_scene(request, source, error);
        sim_scene_free(&scene);
        if (error->status == MR_OK && sim_scene_from_json(&scene, path, scaled, error) == MR_OK)
            sim_scene_free(&scene);
    }
    return scaled;
}

static void tell(const struct scale_request *request, const json_t *scaled, const json_t *numbers)
{
    const json_t *scene = numbers ? scaled : json_object_get(scaled, "scene");
    const char *name;
    json_t *number;
    printf("%s: ", request->output_path);
    if (request->lay_deg == 0.0 || request->n != 1.0)
        printf("%s at n = %g\n", request->to_model ? "model" : "prototype", request->n);
    if (request->lay_deg > 0.0)
        printf("joints at %g degrees: %lld mats of %.6g ft\nsliding along them is not in it: give "
               "lay_slide and lay_mu\n",
               request->lay_deg, (long long)json_integer_value(json_object_get(scene, "N")),
               json_number_value(json_object_get(scene, "L")));
    if (!numbers || request->lay_deg > 0.0)
        return;
    printf("numbers that both scenes share:\n");
    json_object_foreach((json_t *)numbers, name, number)
    {
        printf("  %-20s %14.8g\n", name, json_number_value(number));
    }
}

/* A campaign is told from a scene by its landings. */
int scale_file(const struct scale_request *request, const struct cli *cli)
{
    struct error error = {0};
    if (output_not_input(request->output_path, request->words[0], &error) != MR_OK)
        return cli_fail(&error);
    json_t *source = json_load_file(request->words[0], 0, NULL), *numbers = NULL;
    bool is_campaign = json_object_get(source, "landings") != NULL;
    json_t *scaled = scaled_file(request, source, is_campaign, &numbers, &error);
    int code = 0;
    if (error.status == MR_OK && (request->output_path || !cli->json))
        write_scene(request, scaled, &error);
    if (error.status != MR_OK) {
        code = cli_fail(&error);
    } else if (cli->json) {
        struct answer *answer = scale_answer(request);
        answer_json_value(answer, is_campaign ? "campaign" : "scene", json_incref(scaled));
        if (numbers && request->lay_deg == 0.0)
            answer_json_value(answer, "numbers", json_incref(numbers));
        code = answer_show(cli, answer, 0);
    } else if (request->output_path) {
        tell(request, scaled, numbers);
    }
    json_decref(numbers);
    json_decref(source);
    json_decref(scaled);
    return code;
}
