/* Scene files for the reference, and the initial state. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/sim_reference/model.h"

void ref_defaults(struct ref_scene *scene)
{
    *scene = (struct ref_scene){
        .mats = 53,
        .L = 2,
        .W = 160,
        .g = 32.174,
        .I = 2,
        .KV = 1e7,
        .CV = 2e4,
        .KL = 8e6,
        .CL = 50,
        .KT = 1e5,
        .CT = 1,
        .TAD = 10 * M_PI / 180,
        .right_fixed = true,
        .F = 12000,
        .Vac = 90,
        .F_tstop = (double)INFINITY,
        .f = 0.5,
        .veps = 1e-3,
        .V = 120,
        .shear = REF_RISING,
        .v0 = 2,
    };
}

static bool complain(const char *path, const char *key)
{
    fprintf(stderr, "reference: %s: key %s is unknown here or has a wrong value\n", path, key);
    return false;
}

static bool choose(const char *text, const char *const *names, int *choice)
{
    for (int i = 0; names[i]; i++) {
        if (text && strcmp(text, names[i]) == 0) {
            *choice = i;
            return true;
        }
    }
    return false;
}

static int choice_of(const char *key, const char *text)
{
    static const struct {
        const char *key;
        const char *names[5];
    } choices[] = {
        {"model", {"report", "consistent"}},
        {"tad_mode", {"deadband", "switched"}},
        {"profile", {"low", "full"}},
        {"left", {"free", "fixed"}},
        {"right", {"free", "fixed"}},
        {"left_torsion", {"free", "fixed"}},
        {"right_torsion", {"free", "fixed"}},
        {"thrust", {"jump", "linear"}},
        {"friction", {"stick", "tanh", "none"}},
        {"friction_normal", {"weight", "soil"}},
        {"lift_shear", {"none", "following", "rising", "both"}},
    };
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; i++) {
        int choice;
        if (strcmp(key, choices[i].key) == 0 && choose(text, choices[i].names, &choice))
            return choice;
    }
    return -1;
}

static bool take_choice(struct ref_scene *s, const char *key, const char *text)
{
    int c = choice_of(key, text);
    if (c < 0)
        return false;
    if (strcmp(key, "model") == 0)
        s->model = (enum ref_model)c;
    else if (strcmp(key, "friction") == 0)
        s->friction = (enum ref_friction)c;
    else if (strcmp(key, "lift_shear") == 0)
        s->shear = (enum ref_shear)c;
    else {
        struct {
            const char *key;
            bool *flag;
        } flags[] = {
            {"tad_mode", &s->switched},
            {"profile", &s->full},
            {"left", &s->left_fixed},
            {"right", &s->right_fixed},
            {"left_torsion", &s->left_torsion_fixed},
            {"right_torsion", &s->right_torsion_fixed},
            {"thrust", &s->linear},
            {"friction_normal", &s->soil_normal},
        };
        for (size_t i = 0; i < sizeof flags / sizeof flags[0]; i++) {
            if (strcmp(key, flags[i].key) == 0)
                *flags[i].flag = c == 1;
        }
    }
    return true;
}

static bool take_number(struct ref_scene *s, const char *key, double value)
{
    struct {
        const char *key;
        double *number;
    } numbers[] = {
        {"L", &s->L},
        {"W", &s->W},
        {"g", &s->g},
        {"I", &s->I},
        {"KV", &s->KV},
        {"CV", &s->CV},
        {"KL", &s->KL},
        {"CL", &s->CL},
        {"KT", &s->KT},
        {"CT", &s->CT},
        {"slack", &s->slack},
        {"F", &s->F},
        {"Vac", &s->Vac},
        {"s0", &s->s0},
        {"F_tstop", &s->F_tstop},
        {"wheel_load", &s->wheel_load},
        {"f", &s->f},
        {"veps", &s->veps},
        {"ground_damping", &s->c},
        {"V", &s->V},
        {"Q1", &s->Q1},
        {"v0", &s->v0},
        {"tend", &s->tend},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (strcmp(key, numbers[i].key) == 0) {
            *numbers[i].number = value;
            return true;
        }
    }
    if (strcmp(key, "TAD_deg") == 0) {
        s->TAD = value * M_PI / 180;
        return true;
    }
    if (strcmp(key, "v0_mat") == 0) {
        s->v0_mat = (int)value;
        return true;
    }
    return false;
}

bool ref_load(struct ref_scene *s, const char *path)
{
    json_error_t error;
    json_t *object = json_load_file(path, 0, &error), *value;
    const char *key;
    int bump_first = 5;
    double mats_crossed = 3;
    json_t *bump = NULL;
    bool good = true;
    ref_defaults(s);
    if (!object) {
        fprintf(stderr, "reference: %s: %s\n", path, error.text);
        return false;
    }
    json_object_foreach(object, key, value)
    {
        bool known = key[0] == '_' || strcmp(key, "u_mats") == 0;
        if (strcmp(key, "name") == 0) {
            snprintf(s->name, sizeof s->name, "%s", json_string_value(value));
            known = true;
        } else if (strcmp(key, "N") == 0) {
            s->mats = (int)json_integer_value(value);
            known = s->mats >= 1 && s->mats <= REF_MATS;
        } else if (strcmp(key, "bump_first") == 0) {
            bump_first = (int)json_integer_value(value);
            known = true;
        } else if (strcmp(key, "mats_crossed") == 0) {
            mats_crossed = json_number_value(value);
            known = true;
        } else if (strcmp(key, "bump") == 0) {
            bump = value;
            known = true;
        } else if (strcmp(key, "gap0") == 0) {
            for (int j = 0; j < REF_NODES; j++)
                s->gap0[j] = json_number_value(
                    json_is_array(value) ? json_array_get(value, (size_t)j) : value);
            known = true;
        } else if (strcmp(key, "t_out") == 0) {
            s->outputs = (int)json_array_size(value);
            known = s->outputs <= REF_OUTPUTS;
            for (int i = 0; known && i < s->outputs; i++)
                s->t_out[i] = json_number_value(json_array_get(value, (size_t)i));
        } else if (!known && json_is_string(value)) {
            known = take_choice(s, key, json_string_value(value));
        } else if (!known && json_is_number(value)) {
            known = take_number(s, key, json_number_value(value));
        }
        if (!known)
            good = complain(path, key);
    }
    for (size_t i = 0; bump && i < json_array_size(bump); i++) {
        int node = bump_first - 1 + (int)i;
        if (node <= s->mats)
            s->bump[node] = json_number_value(json_array_get(bump, i));
    }
    json_decref(object);
    if (s->tend == 0)
        s->tend = mats_crossed * s->L / s->Vac;
    if (s->outputs == 0) {
        s->outputs = 1;
        s->t_out[0] = s->tend;
    }
    return good;
}

int ref_u(const struct ref_scene *scene, int mat)
{
    return (scene->model == REF_REPORT ? 1 : scene->mats + 1) + mat;
}

void ref_start(const struct ref_scene *s, double *q, double *v)
{
    for (int i = 0; i < 2 * s->mats + 1; i++)
        q[i] = v[i] = 0;
    if (s->model == REF_REPORT) {
        for (int n = 0; n < s->mats; n++)
            q[s->mats + 1 + n] = asin((s->bump[n] - s->bump[n + 1]) / s->L);
        q[0] = -s->bump[0] + s->L / 2 * sin(q[s->mats + 1]);
    } else {
        for (int j = 0; j <= s->mats; j++)
            q[j] = s->W / (2 * s->KV) - s->bump[j];
    }
    int mat = s->v0_mat > 0 ? s->v0_mat - 1 : (int)floor(s->s0 / s->L + 1e-12);
    if (mat >= 0 && mat < s->mats)
        v[ref_u(s, mat)] = s->v0;
}
