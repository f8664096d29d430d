#include "host/sim/elements/element.h"

#include "host/base/elementary.h"

#define ELEMENT_NAME(name) extern const struct element element_##name;
ELEMENT_TABLE(ELEMENT_NAME)

#define ELEMENT_ADDRESS(name) &element_##name,
static const struct element *const element_table[] = {ELEMENT_TABLE(ELEMENT_ADDRESS)};

#define ELEMENT_KEY(name) &element_##name.key,
const struct sim_key *const sim_element_keys[] = {ELEMENT_TABLE(ELEMENT_KEY)};
const size_t sim_element_key_count = ELEMENT_COUNT;

struct element_set element_set_from_scene(const struct sim_scene *scene)
{
    struct element_set set = {0};
    for (int i = 0; i < ELEMENT_COUNT; i++) {
        if (scene->element_values[i] > 0.0 && !element_table[i]->has_memory) {
            set.element[set.count] = element_table[i];
            set.value[set.count++] = scene->element_values[i];
        }
    }
    return set;
}

double element_force_lb(const struct element_set *set, struct element_mat mat)
{
    double sum = 0.0;
    for (int i = 0; i < set->count; i++)
        sum += set->element[i]->force_lb(set->value[i], mat);
    return sum;
}

double element_slope_lb_s_ft(const struct element_set *set, struct element_mat mat)
{
    double sum = 0.0;
    for (int i = 0; i < set->count; i++)
        sum += set->element[i]->slope_lb_s_ft(set->value[i], mat);
    return sum;
}

struct law_rate_bound element_rate_bound(const struct element_set *set, double mass_slug)
{
    double sum = 0.0;
    for (int i = 0; i < set->count; i++)
        sum += set->element[i]->max_slope_lb_s_ft(set->value[i]);
    return (struct law_rate_bound){0.0, sum / mass_slug};
}

bool element_allows_rest(const struct element_set *set)
{
    for (int i = 0; i < set->count; i++) {
        if (set->element[i]->max_force_at_rest_lb(set->value[i]) > 0.0)
            return false;
    }
    return true;
}

void element_describe(const struct sim_scene *scene, struct sim_result *result)
{
    for (int i = 0; i < ELEMENT_COUNT; i++) {
        if (scene->element_values[i] > 0.0)
            element_table[i]->describe(scene->element_values[i], result);
    }
}

struct element_step element_make_step(const struct element_set *set, struct element_mat mat,
                                      double h_s, double mass_slug)
{
    double slope = element_slope_lb_s_ft(set, mat), k = -slope * h_s / mass_slug;
    double less = elementary_expm1(-k);
    return (struct element_step){
        .speed_factor = 1.0 + less,
        .equivalent_s = k > 0.0 ? h_s * (-less / k) : h_s,
        .push_lb = element_force_lb(set, mat) - slope * mat.v_ft_s,
    };
}
