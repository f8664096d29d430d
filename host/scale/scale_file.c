/* matrig scale: scene files and campaigns. */
#include "host/scale/scale.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/campaign/campaign.h"
#include "host/campaign/facts.h"
#include "host/base/output.h"
#include "host/sim/scene/scene.h"
#include "host/sim/scene/scene_keys.h"
#include "host/base/quantity.h"

/* What a value is multiplied by. */
double scale_factor(const struct scale_request *request, struct mr_dimension dimension)
{
    double ratio = mr_similitude_ratio(request->rule, request->n, dimension);
    return request->to_model ? 1.0 / ratio : ratio;
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

/* A scene key that changes with scale; the others are pure numbers or names. */
struct scaled_key {
    const char *name;
    struct mr_dimension dimension;
};

static const struct scaled_key scaled_keys[] = {
    {"L", {0, 1, 0}},
    {"W", {1, 0, 0}},
    {"g", {0, 1, -2}},
    {"I", {1, 1, 2}},
    {"KV", {1, -1, 0}},
    {"CV", {1, -1, 1}},
    {"KL", {1, -1, 0}},
    {"CL", {1, -1, 1}},
    {"KT", {1, 1, 0}},
    {"CT", {1, 1, 1}},
    {"slack", {0, 1, 0}},
    {"F", {1, 0, 0}},
    {"Vac", {0, 1, -1}},
    {"s0", {0, 1, 0}},
    {"F_tstop", {0, 0, 1}},
    {"wheel_load", {1, 0, 0}},
    {"veps", {0, 1, -1}},
    {"V", {1, 0, 0}},
    {"Q1", {1, 0, 0}},
    {"bump", {0, 1, 0}},
    {"v0", {0, 1, -1}},
    {"tend", {0, 0, 1}},
    {"t_out", {0, 0, 1}},
    {"gap0", {0, 1, 0}},
    {"grit", {1, 0, 0}},
    {"t_dwell", {0, 0, 1}},
    {"band_area", {0, 2, 0}},
    {"band_E", {1, -2, 0}},
    {"band_T0", {1, 0, 0}},
    {"band_K", {1, -1, 0}},
    {"band_grip", {1, 0, 0}},
    {"band_pull", {1, 0, 0}},
    {"band_wear", {0, 1, 0}},
    {"band_slipped", {0, 1, 0}},
    {"cleat_hold", {1, 0, 0}},
    {"cleat_travel", {0, 1, 0}},
    {"cleat_depth", {0, 1, 0}},
    {"stiff_K", {1, -1, 0}},
    {"stiff_grip", {1, 0, 0}},
    {"stiff_KT", {1, 1, 0}},
    {"stiff_yield", {1, 1, 0}},
    {"stiff_gap0", {0, 1, 0}},
    {"lay_slide", {1, 0, 0}},
    {"tear", {1, 0, 0}},
    {"unhinge_lap", {0, 1, 0}},
    {"ground", {0, 1, 0}},
    {"gear_lines_ft", {0, 1, 0}},
    {"gear_foot_ft", {0, 1, 0}},
};
static const struct mr_dimension path_columns[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
static const char *const path_units[] = {"s", "ft", "lb"};

/* `unit`: of a number; text has its own. What is neither stays for the reader to refuse. */
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

static json_t *scaled_path(const struct scale_request *request, const json_t *path)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < json_array_size(path); i++) {
        const json_t *row = json_array_get(path, i);
        json_t *scaled = json_array();
        for (size_t c = 0; c < 3; c++)
            json_array_append_new(scaled,
                                  times(json_array_get(row, c),
                                        scale_factor(request, path_columns[c]), path_units[c]));
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
        {"band_area", "bands", offsetof(struct sim_scene, mods.band[0].area_ft2)},
        {"band_E", "bands", offsetof(struct sim_scene, mods.band[0].e_lb_ft2)},
        {"band2_area", "bands2", offsetof(struct sim_scene, mods.band[1].area_ft2)},
        {"band2_E", "bands2", offsetof(struct sim_scene, mods.band[1].e_lb_ft2)},
        {"cleat_depth", "cleat_every", offsetof(struct sim_scene, mods.cleat_depth_ft)},
    };
    struct sim_scene plain;
    sim_scene_defaults(&plain);
    for (size_t i = 0; i < sizeof defaults / sizeof defaults[0]; i++) {
        double number;
        memcpy(&number, (const char *)&plain + defaults[i].offset, sizeof number);
        if (json_object_get(scene, defaults[i].with) &&
            !json_object_get(complete, defaults[i].name))
            json_object_set_new(complete, defaults[i].name, json_real(number));
    }
}

/* A scene key's value on the other side. */
static json_t *scaled_entry(const struct scale_request *request, const char *key,
                            const json_t *value)
{
    double by = scale_lay_factor(key, request->lay_deg);
    char first[32] = ""; /* the second group of bands as the first */
    if (strncmp(key, "band2_", 6) == 0)
        snprintf(first, sizeof first, "band_%s", key + 6);
    if (strcmp(key, "path") == 0)
        return scaled_path(request, value);
    for (size_t i = 0; i < sizeof scaled_keys / sizeof scaled_keys[0]; i++) {
        if (strcmp(first[0] ? first : key, scaled_keys[i].name) == 0)
            by *= scale_factor(request, scaled_keys[i].dimension);
    }
    const struct sim_key *known = sim_key_find(key);
    if (known)
        by *= scale_factor(request, known->dimension);
    return by != 1.0 ? times(value, by, known ? known->unit : "") : json_deep_copy(value);
}

/* Keys as written, scaled; defaults that change with scale are written out, as the other side's
 * differ. */
static json_t *scaled_scene(const struct scale_request *request, const json_t *scene,
                            struct error *error)
{
    static const struct {
        const char *name;
        size_t offset;
    } defaults[] = {
        {"L", offsetof(struct sim_scene, length_ft)},
        {"W", offsetof(struct sim_scene, weight_lb)},
        {"I", offsetof(struct sim_scene, inertia_slug_ft2)},
        {"KV", offsetof(struct sim_scene, kv_lb_ft)},
        {"CV", offsetof(struct sim_scene, cv_lb_s_ft)},
        {"KL", offsetof(struct sim_scene, kl_lb_ft)},
        {"CL", offsetof(struct sim_scene, cl_lb_s_ft)},
        {"KT", offsetof(struct sim_scene, kt_lb_ft_rad)},
        {"CT", offsetof(struct sim_scene, ct_lb_ft_s_rad)},
        {"F", offsetof(struct sim_scene, force_lb)},
        {"Vac", offsetof(struct sim_scene, vac_ft_s)},
        {"veps", offsetof(struct sim_scene, veps_ft_s)},
        {"V", offsetof(struct sim_scene, shear_lb)},
        {"v0", offsetof(struct sim_scene, v0_ft_s)},
        {"TAD_deg", offsetof(struct sim_scene, tad_deg)},
    };
    struct sim_scene plain;
    json_t *complete = json_object(), *result = json_object(), *value;
    const char *key;
    sim_scene_defaults(&plain);
    json_object_update(complete, (json_t *)scene);
    for (size_t i = 0; i < sizeof defaults / sizeof defaults[0]; i++) {
        bool replaced = (strcmp(defaults[i].name, "F") == 0 ||
                         strcmp(defaults[i].name, "Vac") == 0) &&
                        json_object_get(scene, "path");
        bool stays = request->n == 1.0 &&
                     scale_lay_factor(defaults[i].name, request->lay_deg) == 1.0;
        if (!replaced && !stays && !json_object_get(complete, defaults[i].name)) {
            double number;
            memcpy(&number, (const char *)&plain + defaults[i].offset, sizeof number);
            json_object_set_new(complete, defaults[i].name, json_real(number));
        }
    }
    complete_mods(scene, complete);
    if (request->lay_deg > 0.0 && !json_object_get(complete, "N"))
        json_object_set_new(complete, "N", json_integer(plain.mats));
    if (request->lay_deg > 0.0)
        scale_lay_scene(complete, request->lay_deg, request->words[0], error);
    json_object_foreach(complete, key, value)
    {
        json_object_set_new(result, key, scaled_entry(request, key, value));
    }
    json_decref(complete);
    return result;
}

static json_t *scaled_range(const struct scale_request *request, struct campaign_range range,
                            struct mr_dimension dimension)
{
    double by = scale_factor(request, dimension);
    return range.low == range.high ? json_real(range.low * by)
                                   : json_pack("[f,f]", range.low * by, range.high * by);
}

/* Runway, aircraft and engine, every key written out: the defaults are a model's. */
static void scaled_parts(const struct scale_request *request, const struct campaign *c,
                         json_t *result)
{
    static const struct mr_dimension inches = {0, 1, 0}, lb = {1, 0, 0}, s = {0, 0, 1},
                                     speed = {0, 1, -1}, drag = {0, 1, -2}, strength = {1, -1, 0};
    static const char *const engines[] = {"auto", "chain", "planar"};
    double opened = scale_lay_factor("gap0", request->lay_deg);
    const struct campaign_range laid_gap_in = {opened * c->gap_in.low, opened * c->gap_in.high};
    json_object_set_new(
        result, "runway",
        json_pack("{s:o,s:o,s:o,s:s,s:f,s:f,s:f,s:f,s:f}", "gap_in",
                  scaled_range(request, laid_gap_in, inches), "closing_lb",
                  scaled_range(request, c->closing_lb, lb), "irregularity_in",
                  scaled_range(request, c->irregularity_in, inches), "irregularity_along",
                  c->along == CAMPAIGN_GROUND ? "ground" : "mats", "joint_lb_in",
                  c->strength_lb_in * scale_factor(request, strength), "strip_ft",
                  c->strip_ft * scale_factor(request, inches), "unhinge_deg", c->unhinge_deg,
                  "wave_in", c->wave_in * scale_factor(request, inches), "buckle_in",
                  c->buckle_in * scale_factor(request, inches)));
    json_object_set_new(result, "aircraft",
                        json_pack("{s:f,s:f,s:f,s:f,s:f,s:f}", "weight_lb",
                                  c->weight_lb * scale_factor(request, lb), "axles", c->axles,
                                  "onset_s", c->onset_s * scale_factor(request, s), "dwell_s",
                                  c->dwell_s * scale_factor(request, s), "back_ft_s",
                                  c->back_ft_s * scale_factor(request, speed), "back_drag_ft_s2",
                                  c->back_drag_ft_s2 * scale_factor(request, drag)));
    json_object_set_new(result, "engine",
                        json_pack("{s:s,s:f,s:f,s:f}", "use", engines[c->engine], "chain_dt_s",
                                  c->chain_dt_s * scale_factor(request, s), "planar_dt_s",
                                  c->planar_dt_s * scale_factor(request, s), "skip_share",
                                  c->skip_share));
}

/* One entry of the file's landings; `scene` takes the defaults of what it applies. */
static json_t *scaled_landing(const struct scale_request *request, const json_t *entry,
                              const struct campaign_landing *landing, json_t *scene)
{
    static const struct mr_dimension ft = {0, 1, 0}, speed = {0, 1, -1}, drag = {0, 1, -2};
    json_t *result = json_deep_copy(entry), *value;
    json_t *apply = json_object_get(entry, "apply");
    json_t *drag_entry = json_object_get(entry, "deceleration_ft_s2"),
           *profile = json_object_get(entry, "profile");
    const char *key;
    size_t i;
    json_object_set_new(result, "touchdown_ft", scaled_range(request, landing->touchdown_ft, ft));
    json_object_set_new(result, "speed_ft_s", scaled_range(request, landing->speed_ft_s, speed));
    if (drag_entry)
        json_object_set_new(result, "deceleration_ft_s2",
                            times(drag_entry, scale_factor(request, drag), "ft/s2"));
    json_array_foreach(profile, i, value)
    {
        json_t *row = json_array();
        json_array_append_new(row,
                              times(json_array_get(value, 0), scale_factor(request, ft), "ft"));
        json_array_append_new(
            row, times(json_array_get(value, 1), scale_factor(request, drag), "ft/s2"));
        json_array_set_new(json_object_get(result, "profile"), i, row);
    }
    json_object_foreach(apply, key, value)
    {
        json_object_set_new(json_object_get(result, "apply"), key,
                            scaled_entry(request, key, value));
    }
    if (apply)
        complete_mods(apply, scene);
    return result;
}

/* Movements and their stations change; mats, landings and ratios do not. */
static json_t *scaled_fact(const struct scale_request *request, const json_t *entry,
                           const struct campaign_fact *fact)
{
    static const struct mr_dimension ft = {0, 1, 0};
    static const char *const lengths[] = {"at_least", "at_most", "station_ft"};
    json_t *result = json_deep_copy(entry);
    bool length = (fact->quantity <= CAMPAIGN_MEAN_IN || fact->quantity == CAMPAIGN_APART_FT) &&
                  fact->against_first == 0;
    for (size_t i = length ? 0 : 2; i < sizeof lengths / sizeof lengths[0]; i++) {
        if (json_object_get(entry, lengths[i]))
            json_object_set_new(result, lengths[i],
                                times(json_object_get(entry, lengths[i]), scale_factor(request, ft),
                                      quantity_unit_of_name(lengths[i])));
    }
    return result;
}

/* What elastic ground adds to the scene. */
static void scale_elastic(const struct scale_request *request, const char *path,
                          const json_t *source, json_t *result, struct error *error)
{
    json_t *elastic = campaign_elastic_json(path, source, error), *value;
    const char *key;
    if (!elastic)
        return;
    json_t *scaled = json_object();
    json_object_foreach(elastic, key, value)
    {
        json_object_set_new(scaled, key, scaled_entry(request, key, value));
    }
    json_object_set_new(result, "elastic", scaled);
    json_decref(elastic);
}

static json_t *scaled_campaign(const struct scale_request *request, const char *path,
                               const json_t *source, const struct campaign *c, struct error *error)
{
    static const struct mr_dimension ft = {0, 1, 0};
    json_t *held = campaign_scene_json(path, source, error), *scene = json_deep_copy(held);
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
    json_object_set_new(result, "_scaled", json_string(note));
    json_t *scaled = scaled_scene(request, scene, error);
    json_object_del(scaled, "F"); /* the landings give them */
    json_object_del(scaled, "Vac");
    json_object_set_new(result, "scene", scaled);
    scale_elastic(request, path, source, result, error);
    json_object_set_new(result, "landings", list);
    scaled_parts(request, c, result);
    if (json_object_get(source, "stations_ft"))
        json_object_set_new(
            result, "stations_ft",
            times(json_object_get(source, "stations_ft"), scale_factor(request, ft), "ft"));
    json_array_foreach(json_object_get(source, "facts"), i, entry)
    {
        json_array_set_new(json_object_get(result, "facts"), i,
                           scaled_fact(request, entry, &c->facts[i]));
    }
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
    if (output_begin(&output, request->output_path, request->force, error) != MR_OK)
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
    struct campaign campaign;
    json_t *scaled = NULL;
    if (is_campaign) {
        if (campaign_load(&campaign, path, error) != MR_OK)
            return NULL;
        scaled = scaled_campaign(request, path, source, &campaign, error);
        campaign_free(&campaign);
        if (error->status == MR_OK && campaign_from_json(&campaign, path, scaled, error) == MR_OK)
            campaign_free(&campaign);
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
