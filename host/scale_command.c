/* matrig scale: quantities, scene files and campaigns between model and prototype. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/similitude.h"
#include "host/campaign/campaign.h"
#include "host/cli.h"
#include "host/output.h"
#include "host/sim/scene.h"

#define VALUES_MAX 32
#define GRAVITY_FT_S2 32.174

struct request {
    enum mr_similitude_rule rule;
    bool to_model;
    double n;
    const char *output_path;
    const char *words[VALUES_MAX];
    size_t count;
};

/* A scene key that changes with scale; the others are pure numbers or names. */
struct scaled_key {
    const char *name;
    struct mr_dimension dimension;
};

static const struct scaled_key scaled_keys[] = {
    {"L", {0, 1, 0}},     {"W", {1, 0, 0}},       {"g", {0, 1, -2}},      {"I", {1, 1, 2}},
    {"KV", {1, -1, 0}},   {"CV", {1, -1, 1}},     {"KL", {1, -1, 0}},     {"CL", {1, -1, 1}},
    {"KT", {1, 1, 0}},    {"CT", {1, 1, 1}},      {"slack", {0, 1, 0}},   {"F", {1, 0, 0}},
    {"Vac", {0, 1, -1}},  {"s0", {0, 1, 0}},      {"F_tstop", {0, 0, 1}}, {"wheel_load", {1, 0, 0}},
    {"veps", {0, 1, -1}}, {"V", {1, 0, 0}},       {"Q1", {1, 0, 0}},      {"bump", {0, 1, 0}},
    {"v0", {0, 1, -1}},   {"tend", {0, 0, 1}},    {"t_out", {0, 0, 1}},   {"gap0", {0, 1, 0}},
    {"grit", {1, 0, 0}},  {"t_dwell", {0, 0, 1}},
    {"band_area", {0, 2, 0}}, {"band_E", {1, -2, 0}}, {"band_T0", {1, 0, 0}}, {"band_K", {1, -1, 0}},
    {"band_grip", {1, 0, 0}}, {"band_pull", {1, 0, 0}}, {"band_wear", {0, 1, 0}}, {"band_slipped", {0, 1, 0}},
    {"cleat_hold", {1, 0, 0}}, {"cleat_travel", {0, 1, 0}}, {"cleat_depth", {0, 1, 0}}, {"stiff_K", {1, -1, 0}},
    {"stiff_grip", {1, 0, 0}}, {"stiff_KT", {1, 1, 0}}, {"stiff_yield", {1, 1, 0}}, {"stiff_gap0", {0, 1, 0}},
    {"lay_slide", {1, 0, 0}}, {"tear", {1, 0, 0}},
    {"ground", {0, 1, 0}},
};
static const struct mr_dimension path_columns[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};

/* What a value is multiplied by. */
static double factor(const struct request *request, struct mr_dimension dimension)
{
    double ratio = mr_similitude_ratio(request->rule, request->n, dimension);
    return request->to_model ? 1.0 / ratio : ratio;
}

static enum mr_status read_request(int argc, char **argv, struct request *request, struct error *error)
{
    const char *to = NULL, *keep = NULL, *n = NULL;
    const struct cli_option options[] = {
        {"--to", &to, NULL}, {"--keep", &keep, NULL}, {"--n", &n, NULL}, {"-o", &request->output_path, NULL}};
    request->n = 7.0;
    if (cli_parse(argc, argv, options, sizeof options / sizeof options[0], request->words, 0, VALUES_MAX,
                  "NAME=VALUE... or SCENE", error) != MR_OK)
        return error->status;
    while (request->count < VALUES_MAX && request->words[request->count])
        request->count++;
    if (n && cli_number(n, "--n", 1e-3, 1e3, &request->n, error) != MR_OK)
        return error->status;
    if (to && strcmp(to, "model") != 0 && strcmp(to, "prototype") != 0)
        return error_set(error, MR_USAGE, "unknown side: '%s' for --to; give model or prototype", to);
    if (keep && strcmp(keep, "density") != 0 && strcmp(keep, "modulus") != 0)
        return error_set(error, MR_USAGE, "unknown rule: '%s' for --keep; give density or modulus", keep);
    request->to_model = to && strcmp(to, "model") == 0;
    request->rule = keep && strcmp(keep, "modulus") == 0 ? MR_KEEP_MODULUS : MR_KEEP_DENSITY;
    return MR_OK;
}

/* "n^3", "n^2.5", "n", "1/n", "1". */
static void power_text(int half_powers, char text[16])
{
    int size = abs(half_powers);
    char number[8] = "";
    if (size != 2)
        snprintf(number, sizeof number, size % 2 ? "^%d.5" : "^%d", size / 2);
    if (half_powers == 0)
        snprintf(text, 16, "1");
    else
        snprintf(text, 16, "%sn%s", half_powers < 0 ? "1/" : "", number);
}

static json_t *request_json(const struct request *request)
{
    return json_pack("{s:s,s:f,s:s}", "keep", request->rule == MR_KEEP_DENSITY ? "density" : "modulus", "n",
                     request->n, "to", request->to_model ? "model" : "prototype");
}

/* Without words: every ratio. */
static int print_ratios(const struct request *request, const struct cli *cli)
{
    json_t *list = json_array();
    if (!cli->json)
        printf("prototype / model at n = %g, %s kept\n", request->n,
               request->rule == MR_KEEP_DENSITY ? "density" : "modulus");
    for (size_t i = 0; i < mr_quantity_count; i++) {
        const struct mr_quantity *quantity = &mr_quantities[i];
        double ratio = mr_similitude_ratio(request->rule, request->n, quantity->dimension);
        char power[16];
        power_text(mr_similitude_half_powers(request->rule, quantity->dimension), power);
        if (cli->json)
            json_array_append_new(list, json_pack("{s:s,s:s,s:s,s:o}", "name", quantity->name, "symbol",
                                                  quantity->symbol, "power", power, "ratio",
                                                  cli_json_number(ratio, 12)));
        else
            printf("  %-20s %-6s %-7s %12.6g\n", quantity->name, quantity->symbol, power, ratio);
    }
    if (!cli->json) {
        json_decref(list);
        return 0;
    }
    json_t *object = request_json(request);
    json_object_set_new(object, "ratios", list);
    return cli_print_json(object, 0);
}

struct value {
    const struct mr_quantity *quantity;
    double from, to;
};

static enum mr_status read_value(const char *word, struct value *value, struct error *error)
{
    const char *equals = strchr(word, '=');
    char name[40];
    if (!equals || equals == word || (size_t)(equals - word) >= sizeof name)
        return error_set(error, MR_USAGE,
                         "not a quantity: '%s'; give NAME=VALUE (matrig scale lists the names)", word);
    memcpy(name, word, (size_t)(equals - word));
    name[equals - word] = '\0';
    value->quantity = mr_quantity_find(name);
    for (size_t i = 0; !value->quantity && i < mr_quantity_count; i++) {
        if (strcasecmp(name, mr_quantities[i].symbol) == 0 || strcasecmp(name, mr_quantities[i].name) == 0)
            return error_set(error, MR_USAGE, "unknown quantity: '%s'; '%s' is %s; matrig scale lists the names", name,
                             mr_quantities[i].symbol, mr_quantities[i].name);
    }
    if (!value->quantity)
        return error_set(error, MR_USAGE, "unknown quantity: '%s'; matrig scale lists the names", name);
    return cli_number(equals + 1, name, -1e30, 1e30, &value->from, error);
}

/* The ten inputs of the pi terms, of either side; NaN where nothing was given. */
static void pi_inputs(const struct value *values, size_t count, bool scaled, double inputs[MR_PI_INPUTS])
{
    for (int i = 0; i < MR_PI_INPUTS; i++) {
        inputs[i] = strcmp(mr_pi_inputs[i], "gravity") == 0 ? GRAVITY_FT_S2 : (double)NAN;
        for (size_t k = 0; k < count; k++) {
            if (strcmp(values[k].quantity->name, mr_pi_inputs[i]) == 0)
                inputs[i] = scaled ? values[k].to : values[k].from;
        }
    }
}

static int scale_values(const struct request *request, const struct cli *cli)
{
    struct value values[VALUES_MAX];
    struct error error = {0};
    double from[MR_PI_INPUTS], to[MR_PI_INPUTS];
    for (size_t i = 0; i < request->count; i++) {
        if (read_value(request->words[i], &values[i], &error) != MR_OK)
            return cli_fail(&error);
        values[i].to = values[i].from * factor(request, values[i].quantity->dimension);
    }
    pi_inputs(values, request->count, false, from);
    pi_inputs(values, request->count, true, to);
    json_t *scaled = json_object(), *terms = json_object();
    for (size_t i = 0; i < request->count; i++) {
        const struct mr_quantity *quantity = values[i].quantity;
        json_object_set_new(scaled, quantity->name,
                            json_pack("{s:o,s:o,s:s}", "from", cli_json_number(values[i].from, 12), "to",
                                      cli_json_number(values[i].to, 12), "unit", quantity->unit));
        if (!cli->json)
            printf("%-20s %14.8g  ->  %14.8g %s\n", quantity->name, values[i].from, values[i].to,
                   quantity->unit);
    }
    for (size_t i = 0; i < mr_pi_term_count; i++) {
        double before = mr_pi_value(&mr_pi_terms[i], from), after = mr_pi_value(&mr_pi_terms[i], to);
        if (!isfinite(before) || !isfinite(after))
            continue;
        json_object_set_new(
            terms, mr_pi_terms[i].name,
            json_pack("{s:o,s:o}", "from", cli_json_number(before, 12), "to", cli_json_number(after, 12)));
        if (!cli->json)
            printf("pi %-17s %14.8g  =   %14.8g\n", mr_pi_terms[i].name, before, after);
    }
    json_t *object = request_json(request);
    json_object_set_new(object, "values", scaled);
    json_object_set_new(object, "pi", terms);
    if (cli->json)
        return cli_print_json(object, 0);
    json_decref(object);
    return 0;
}

static json_t *times(const json_t *value, double by)
{
    if (json_is_number(value))
        return json_real(json_number_value(value) * by);
    if (!json_is_array(value))
        return json_deep_copy(value);
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(value); i++)
        json_array_append_new(list, times(json_array_get(value, i), by));
    return list;
}

static json_t *scaled_path(const struct request *request, const json_t *path)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < json_array_size(path); i++) {
        const json_t *row = json_array_get(path, i);
        json_t *scaled = json_array();
        for (size_t c = 0; c < 3; c++)
            json_array_append_new(scaled, times(json_array_get(row, c), factor(request, path_columns[c])));
        json_array_append_new(rows, scaled);
    }
    return rows;
}

/* Defaults of the modifications that a scene has. */
static void complete_mods(const json_t *scene, json_t *complete)
{
    static const struct {
        const char *name, *with;
        size_t offset;
    } defaults[] = {
        {"band_area", "bands", offsetof(struct sim_scene, mods.band_area_ft2)},
        {"band_E", "bands", offsetof(struct sim_scene, mods.band_e_lb_ft2)},
        {"cleat_depth", "cleat_every", offsetof(struct sim_scene, mods.cleat_depth_ft)},
    };
    struct sim_scene plain;
    sim_scene_defaults(&plain);
    for (size_t i = 0; i < sizeof defaults / sizeof defaults[0]; i++) {
        double number;
        memcpy(&number, (const char *)&plain + defaults[i].offset, sizeof number);
        if (json_object_get(scene, defaults[i].with) && !json_object_get(complete, defaults[i].name))
            json_object_set_new(complete, defaults[i].name, json_real(number));
    }
}

/* A scene key's value on the other side. */
static json_t *scaled_entry(const struct request *request, const char *key, const json_t *value)
{
    if (strcmp(key, "path") == 0)
        return scaled_path(request, value);
    for (size_t i = 0; i < sizeof scaled_keys / sizeof scaled_keys[0]; i++) {
        if (strcmp(key, scaled_keys[i].name) == 0)
            return times(value, factor(request, scaled_keys[i].dimension));
    }
    return json_deep_copy(value);
}

/* Keys as written, scaled; defaults that change with scale are written out, as the other side's differ. */
static json_t *scaled_scene(const struct request *request, const json_t *scene)
{
    static const struct {
        const char *name;
        size_t offset;
    } defaults[] = {
        {"L", offsetof(struct sim_scene, length_ft)},        {"W", offsetof(struct sim_scene, weight_lb)},
        {"I", offsetof(struct sim_scene, inertia_slug_ft2)}, {"KV", offsetof(struct sim_scene, kv_lb_ft)},
        {"CV", offsetof(struct sim_scene, cv_lb_s_ft)},      {"KL", offsetof(struct sim_scene, kl_lb_ft)},
        {"CL", offsetof(struct sim_scene, cl_lb_s_ft)},      {"KT", offsetof(struct sim_scene, kt_lb_ft_rad)},
        {"CT", offsetof(struct sim_scene, ct_lb_ft_s_rad)},  {"F", offsetof(struct sim_scene, force_lb)},
        {"Vac", offsetof(struct sim_scene, vac_ft_s)},       {"veps", offsetof(struct sim_scene, veps_ft_s)},
        {"V", offsetof(struct sim_scene, shear_lb)},         {"v0", offsetof(struct sim_scene, v0_ft_s)},
    };
    struct sim_scene plain;
    json_t *complete = json_object(), *result = json_object(), *value;
    const char *key;
    sim_scene_defaults(&plain);
    json_object_update(complete, (json_t *)scene);
    for (size_t i = 0; i < sizeof defaults / sizeof defaults[0]; i++) {
        bool replaced = (strcmp(defaults[i].name, "F") == 0 || strcmp(defaults[i].name, "Vac") == 0) &&
                        json_object_get(scene, "path");
        if (!replaced && !json_object_get(complete, defaults[i].name)) {
            double number;
            memcpy(&number, (const char *)&plain + defaults[i].offset, sizeof number);
            json_object_set_new(complete, defaults[i].name, json_real(number));
        }
    }
    complete_mods(scene, complete);
    json_object_foreach(complete, key, value)
    {
        json_object_set_new(result, key, scaled_entry(request, key, value));
    }
    json_decref(complete);
    return result;
}

static json_t *scaled_range(const struct request *request, struct campaign_range range, struct mr_dimension dimension)
{
    double by = factor(request, dimension);
    return range.low == range.high ? json_real(range.low * by) : json_pack("[f,f]", range.low * by, range.high * by);
}

/* Runway, aircraft and engine, every key written out: the defaults are a model's. */
static void scaled_parts(const struct request *request, const struct campaign *c, json_t *result)
{
    static const struct mr_dimension inches = {0, 1, 0}, lb = {1, 0, 0}, s = {0, 0, 1}, speed = {0, 1, -1}, drag = {0, 1, -2},
                                     strength = {1, -1, 0};
    static const char *const engines[] = {"auto", "chain", "planar"};
    json_object_set_new(
        result, "runway",
        json_pack("{s:o,s:o,s:o,s:s,s:f,s:f,s:f,s:f,s:f}", "gap_in", scaled_range(request, c->gap_in, inches), "closing_lb",
                  scaled_range(request, c->closing_lb, lb), "irregularity_in", scaled_range(request, c->irregularity_in, inches),
                  "irregularity_along", c->along == CAMPAIGN_GROUND ? "ground" : "mats", "joint_lb_in",
                  c->strength_lb_in * factor(request, strength), "strip_ft", c->strip_ft * factor(request, inches), "unhinge_deg",
                  c->unhinge_deg, "wave_in", c->wave_in * factor(request, inches), "buckle_in",
                  c->buckle_in * factor(request, inches)));
    json_object_set_new(result, "aircraft",
                        json_pack("{s:f,s:f,s:f,s:f,s:f,s:f}", "weight_lb", c->weight_lb * factor(request, lb), "axles", c->axles,
                                  "onset_s", c->onset_s * factor(request, s), "dwell_s", c->dwell_s * factor(request, s),
                                  "back_ft_s", c->back_ft_s * factor(request, speed), "back_drag_ft_s2",
                                  c->back_drag_ft_s2 * factor(request, drag)));
    json_object_set_new(result, "engine",
                        json_pack("{s:s,s:f,s:f,s:f}", "use", engines[c->engine], "chain_dt_s",
                                  c->chain_dt_s * factor(request, s), "planar_dt_s", c->planar_dt_s * factor(request, s),
                                  "skip_share", c->skip_share));
}

/* One entry of the file's landings; `scene` takes the defaults of what it applies. */
static json_t *scaled_landing(const struct request *request, const json_t *entry, const struct campaign_landing *landing,
                              json_t *scene)
{
    static const struct mr_dimension ft = {0, 1, 0}, speed = {0, 1, -1}, drag = {0, 1, -2};
    json_t *result = json_deep_copy(entry), *apply = json_object_get(entry, "apply"), *value;
    json_t *drag_entry = json_object_get(entry, "deceleration_ft_s2"), *profile = json_object_get(entry, "profile");
    const char *key;
    size_t i;
    json_object_set_new(result, "touchdown_ft", scaled_range(request, landing->touchdown_ft, ft));
    json_object_set_new(result, "speed_ft_s", scaled_range(request, landing->speed_ft_s, speed));
    if (drag_entry)
        json_object_set_new(result, "deceleration_ft_s2", times(drag_entry, factor(request, drag)));
    json_array_foreach(profile, i, value)
    {
        json_t *row = json_pack("[f,f]", json_number_value(json_array_get(value, 0)) * factor(request, ft),
                                json_number_value(json_array_get(value, 1)) * factor(request, drag));
        json_array_set_new(json_object_get(result, "profile"), i, row);
    }
    json_object_foreach(apply, key, value)
    {
        json_object_set_new(json_object_get(result, "apply"), key, scaled_entry(request, key, value));
    }
    if (apply)
        complete_mods(apply, scene);
    return result;
}

/* The scene of a campaign: inline, or the file it names beside itself. */
static json_t *campaign_scene(const char *path, const json_t *campaign)
{
    const json_t *scene = json_object_get(campaign, "scene");
    char name[1024];
    const char *slash = strrchr(path, '/');
    if (!json_is_string(scene))
        return json_deep_copy(scene);
    snprintf(name, sizeof name, "%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, json_string_value(scene));
    return json_load_file(name, 0, NULL);
}

static json_t *scaled_campaign(const struct request *request, const char *path, const json_t *source,
                               const struct campaign *c)
{
    static const struct mr_dimension ft = {0, 1, 0};
    json_t *result = json_deep_copy(source), *scene = campaign_scene(path, source), *list = json_array(), *entry;
    char note[200];
    size_t i, at = 0;
    json_array_foreach(json_object_get(source, "landings"), i, entry)
    {
        json_array_append_new(list, scaled_landing(request, entry, &c->landings[at], scene));
        double number = json_object_get(entry, "times") ? json_number_value(json_object_get(entry, "times")) : 1.0;
        at += (size_t)number;
    }
    snprintf(note, sizeof note, "To %s scale by matrig scale: n %g, %s kept. Texts (name, observed) are the original's.",
             request->to_model ? "model" : "prototype", request->n, request->rule == MR_KEEP_DENSITY ? "density" : "modulus");
    json_object_set_new(result, "_scaled", json_string(note));
    json_t *scaled = scaled_scene(request, scene);
    json_object_del(scaled, "F"); /* the landings give them */
    json_object_del(scaled, "Vac");
    json_object_set_new(result, "scene", scaled);
    json_object_set_new(result, "landings", list);
    scaled_parts(request, c, result);
    if (json_object_get(source, "stations_ft"))
        json_object_set_new(result, "stations_ft", times(json_object_get(source, "stations_ft"), factor(request, ft)));
    json_decref(scene);
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

static enum mr_status write_scene(const struct request *request, const json_t *scene, struct error *error)
{
    FILE *file = output_open(request->output_path, error);
    if (!file)
        return error->status;
    json_dumpf(scene, file, JSON_INDENT(2) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(17));
    fputc('\n', file);
    return output_close(file, request->output_path, error);
}

static int scale_scene(const struct request *request, const struct cli *cli)
{
    const char *path = request->words[0];
    struct error error = {0};
    struct sim_scene scene;
    int code = 0;
    if (sim_scene_load(&scene, path, &error) != MR_OK) /* what is no scene is refused as `sim` does */
        return cli_fail(&error);
    json_t *source = json_load_file(path, 0, NULL);
    json_t *scaled = source ? scaled_scene(request, source) : NULL;
    if (!scaled)
        error_set(&error, MR_IO, "cannot read scene again: %s; check the path", path);
    if (scaled && (request->output_path || !cli->json))
        write_scene(request, scaled, &error);
    if (error.status != MR_OK) {
        code = cli_fail(&error);
    } else if (cli->json) {
        json_t *object = request_json(request);
        json_object_set(object, "scene", scaled);
        json_object_set_new(object, "numbers", scene_numbers(&scene));
        code = cli_print_json(object, 0);
    } else if (request->output_path) {
        const char *name;
        json_t *numbers = scene_numbers(&scene), *number;
        printf("%s: %s at n = %g\nnumbers that both scenes share:\n", request->output_path,
               request->to_model ? "model" : "prototype", request->n);
        json_object_foreach(numbers, name, number)
            printf("  %-20s %14.8g\n", name, json_number_value(number));
        json_decref(numbers);
    }
    json_decref(source);
    json_decref(scaled);
    sim_scene_free(&scene);
    return code;
}

static int scale_campaign(const struct request *request, const struct cli *cli)
{
    const char *path = request->words[0];
    struct error error = {0};
    struct campaign campaign;
    int code = 0;
    if (campaign_load(&campaign, path, &error) != MR_OK) /* what is no campaign is refused as `campaign` does */
        return cli_fail(&error);
    json_t *source = json_load_file(path, 0, NULL), *scaled = NULL;
    if (source)
        scaled = scaled_campaign(request, path, source, &campaign);
    else
        error_set(&error, MR_IO, "cannot read campaign again: %s; check the path", path);
    if (scaled && (request->output_path || !cli->json))
        write_scene(request, scaled, &error);
    if (error.status != MR_OK) {
        code = cli_fail(&error);
    } else if (cli->json) {
        json_t *object = request_json(request);
        json_object_set(object, "campaign", scaled);
        code = cli_print_json(object, 0);
    } else if (request->output_path) {
        printf("%s: campaign \"%s\", %zu landings, to %s scale at n = %g\n", request->output_path, campaign.name,
               campaign.landing_count, request->to_model ? "model" : "prototype", request->n);
    }
    json_decref(source);
    json_decref(scaled);
    campaign_free(&campaign);
    return code;
}

/* A campaign is told from a scene by its landings. */
static bool is_campaign(const char *path)
{
    json_t *root = json_load_file(path, 0, NULL);
    bool campaign = json_object_get(root, "landings") != NULL;
    json_decref(root);
    return campaign;
}

int scale_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct error error = {0};
    if (read_request(argc, argv, &request, &error) != MR_OK)
        return cli_fail(&error);
    if (request.count == 0)
        return print_ratios(&request, cli);
    if (request.count == 1 && !strchr(request.words[0], '='))
        return is_campaign(request.words[0]) ? scale_campaign(&request, cli) : scale_scene(&request, cli);
    if (request.output_path) {
        error_set(&error, MR_USAGE, "nothing to write: -o %s is for a scene; leave it out", request.output_path);
        return cli_fail(&error);
    }
    return scale_values(&request, cli);
}
