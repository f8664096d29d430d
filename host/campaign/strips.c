#include "host/campaign/strips.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/scene/scene_keys.h"
#include "host/sim/scene/scene_units.h"

void strips_read(const struct keys *r, const json_t *section, int count, struct campaign *c)
{
    static const char *const known[] = {"count",       "width_ft", "offset_ft",
                                        "shear_lb_ft", "shear_lb", NULL};
    double said = 1.0;
    c->strips = count > 0 ? count : 1;
    c->shear_lb = (double)INFINITY;
    if (section) {
        keys_check(r, "strips", section, known);
        keys_number(r, "strips", section, "count", 1.0, 2.0, &said);
        keys_number(r, "strips", section, "width_ft", 1e-3, 1e4, &c->width_ft);
        keys_number(r, "strips", section, "offset_ft", -0.45 * c->width_ft, 0.45 * c->width_ft,
                    &c->offset_ft);
        keys_number(r, "strips", section, "shear_lb_ft", 0.0, 1e12, &c->shear_lb_ft);
        keys_number(r, "strips", section, "shear_lb", 0.0, 1e12, &c->shear_lb);
        if (said != floor(said))
            keys_wrong(r, "strips", "count", "1 or 2");
        if (!(c->width_ft > 0.0))
            keys_wrong(r, "strips", "width_ft", "the runway's width");
        c->strips = count > 0 ? count : (int)said;
    }
    if (!keys_failed(r) && c->strips == 2 && !section)
        error_set(r->error, MR_MALFORMED,
                  "no second strip: %s: two strips are asked for and nothing says how the runway "
                  "is divided; give strips, an object with width_ft",
                  r->path);
}

double strips_share(const struct campaign *c, int strip)
{
    double aside = 2.0 * c->offset_ft / c->width_ft;
    return c->strips < 2 ? 1.0 : strip == 0 ? 1.0 - aside : 1.0 + aside;
}

bool strips_refuse(const struct keys *r, const char *where, const char *key, const json_t *applied)
{
    static const char *const ties[] = {"beside", "shear_lb_ft", "shear_lb", "shear_ft"};
    for (size_t i = 0; i < sizeof ties / sizeof ties[0]; i++) {
        if (!json_object_get(applied, ties[i]))
            continue;
        keys_wrong(
            r, where, key,
            "scene keys without beside, shear_lb_ft, shear_lb and shear_ft; ties are those of "
            "strips, and what is of one strip alone is in apply_left and apply_right");
        return true;
    }
    return false;
}

void strips_modify(const struct keys *r, const char *where, const json_t *landing,
                   const struct strips_own *own)
{
    json_t *apply = json_object_get(landing, "apply"), *value;
    const char *name;
    size_t i;
    static const char *const keys[] = {"apply_left", "apply_right"};
    json_t *const owns[] = {own->left, own->right};
    for (size_t k = 0; k < 2; k++) {
        json_t *alone = json_object_get(landing, keys[k]);
        if (alone && !json_is_object(alone))
            keys_wrong(r, where, keys[k], "an object of scene keys");
        if (strips_refuse(r, where, keys[k], alone))
            return;
        json_array_foreach(json_object_get(landing, "remove"), i, value)
        {
            json_object_del(owns[k], json_string_value(value));
        }
        json_object_foreach(apply, name, value)
        {
            json_object_del(owns[k], name);
        }
        json_object_update(owns[k], alone);
    }
}

/* What goes with a strip's width. Those that a scene always has come first; the wheel's load and
 * the ground under it do not. */
#define ALWAYS 8
static const char *const by_width[] = {
    "W",          "I",        "KV",          "CV",        "KL",         "CL",
    "KT",         "CT",       "bands",       "bands2",    "cleat_hold", "stiff_K",
    "stiff_grip", "stiff_KT", "stiff_yield", "lay_slide", "tear",       "ground_damping"};

/* A key's number, as written or as it is without; NaN: it has none. */
static double number_of(const json_t *scene, const char *name, bool always)
{
    const struct sim_key *key = sim_key_find(name);
    const json_t *value = json_object_get(scene, name);
    double number = (double)NAN;
    struct quantity_wrong wrong;
    if (value && !json_is_array(value)) {
        if (!sim_unit_read(key, value, &number, &wrong))
            number = (double)NAN;
    } else if (!value && always) {
        struct sim_scene plain;
        sim_scene_defaults(&plain);
        memcpy(&number, (const char *)&plain + key->offset, sizeof number);
    }
    return number;
}

static json_t *of_width(const json_t *now, double share, const json_t *own)
{
    json_t *scene = json_copy((json_t *)now);
    for (size_t i = 0; i < sizeof by_width / sizeof by_width[0]; i++) {
        double number = number_of(now, by_width[i], i < ALWAYS);
        if (!isnan(number)) /* what is no number is refused when the scene is read */
            json_object_set_new(scene, by_width[i], json_real(share * number));
    }
    json_object_update(scene, (json_t *)own);
    return scene;
}

void strips_scene(const struct keys *r, const char *where, const struct campaign *c,
                  const json_t *now, const struct strips_own *own, struct sim_scene *scene)
{
    char strip[720];
    json_t *left = of_width(now, strips_share(c, 0), own->left),
           *right = of_width(now, strips_share(c, 1), own->right);
    struct sim_scene *beside = calloc(1, sizeof *beside);
    if (!beside || !left || !right)
        error_set(r->error, MR_FULL, "out of memory: %s", r->path);
    snprintf(strip, sizeof strip, "%s, left strip", where);
    if (!keys_failed(r))
        sim_scene_from_json(scene, strip, left, r->error);
    snprintf(strip, sizeof strip, "%s, right strip", where);
    if (!keys_failed(r))
        sim_scene_from_json(beside, strip, right, r->error);
    json_decref(left);
    json_decref(right);
    if (keys_failed(r)) {
        free(beside);
        return;
    }
    scene->beside = beside;
    scene->ties.k_lb_ft = c->shear_lb_ft;
    scene->ties.most_lb = c->shear_lb;
    sim_scene_check(scene, where, r->error);
}
