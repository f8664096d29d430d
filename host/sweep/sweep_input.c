/* What a study's case gives the simulation: values on the base's keys. */
#include "host/sweep/sweep_study.h"

#include "host/sweep/jsonpath.h"

/* The value of an axis in a case: the Cartesian part counts fastest in its last key, samples
 * fastest of all. */
static json_t *axis_value(const struct sweep_study *study, size_t axis, size_t index)
{
    const struct sweep_axis *a = &study->axis[axis];
    if (a->u)
        return design_at(&a->range, a->u[index % study->samples]);
    size_t place = index / study->samples;
    for (size_t k = study->axis_count; k-- > axis + 1;) {
        if (!study->axis[k].u)
            place /= design_levels(&study->axis[k].range);
    }
    return design_level(&a->range, place % design_levels(&a->range));
}

json_t *sweep_study_values(const struct sweep_study *study, size_t index)
{
    json_t *values = json_object();
    for (size_t i = 0; i < study->axis_count; i++)
        json_object_set_new(values, study->axis[i].name, axis_value(study, i, index));
    return values;
}

static json_t *times(const json_t *factor, double value)
{
    if (json_is_number(factor))
        return design_json(json_number_value(factor) * value);
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(factor); i++)
        json_array_append_new(list,
                              design_json(json_number_value(json_array_get(factor, i)) * value));
    return list;
}

static bool apply(const struct sweep_axis *axis, json_t *input, json_t *value)
{
    const char *key;
    json_t *factor;
    if (!axis->set)
        return jsonpath_set(input, axis->name, value);
    bool done = true;
    json_object_foreach(axis->set, key, factor)
    {
        json_t *product = times(factor, json_number_value(value));
        done &= jsonpath_set(input, key, product);
        json_decref(product);
    }
    return done;
}

json_t *sweep_study_input(const struct sweep_study *study, size_t index)
{
    json_t *input = json_copy(study->base);
    bool done = true;
    for (size_t i = 0; i < study->axis_count; i++) {
        json_t *value = axis_value(study, i, index);
        done &= apply(&study->axis[i], input, value);
        json_decref(value);
    }
    if (done)
        return input;
    json_decref(input);
    return NULL;
}

json_t *sweep_study_input_at(const struct sweep_study *study, const json_t *input, double value)
{
    json_t *at = json_copy((json_t *)(uintptr_t)input), *number = design_json(value);
    bool done = apply(&study->find.key, at, number);
    json_decref(number);
    if (done)
        return at;
    json_decref(at);
    return NULL;
}

const json_t *sweep_study_outputs(const struct sweep_study *study)
{
    return json_object_get(study->root, "outputs");
}
