/* matrig scale --lay: a standard pattern's joints turned. With c the cosine of the angle, b the
 * strip's width:
 *
 * - Rows are L/c apart along the runway, so each weighs W/c, stands on 1/c of the soil (KV, CV),
 * and has 1/c of the play.
 * - A joint is b/c long. A movement g along the runway opens it by g c; its force KL/c g c has the
 * part c along the runway.
 * - Folding about the joint turns a row by t = slope/c across it, so energies KT/c t2/2 and I/c
 * t'2/2 are 1/c3 of the slope's, and
 *   the dead angle is c of it. */
#include <math.h>
#include <string.h>

#include "host/scale/scale.h"
#include "host/sim/scene/scene_keys.h"

#define RADIANS (3.14159265358979323846 / 180.0)

double scale_lay_factor(const char *key, double deg)
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

enum mr_status scale_lay_scene(json_t *scene, double deg, const char *path, struct error *error)
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
