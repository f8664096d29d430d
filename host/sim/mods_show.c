#include "host/sim/mods_show.h"

#include <math.h>
#include <stdio.h>

#include "host/base/cli.h"

#define N_PER_LB 4.4482216152605
#define MM_PER_FT 304.8
#define DIGITS 9

static json_t *numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, cli_json_number(values[i], DIGITS));
    return list;
}

static json_t *flagged(const double *flags, const double *names, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++) {
        if (flags[i] != 0.0)
            json_array_append_new(list, json_integer(names ? (json_int_t)names[i] : (json_int_t)i));
    }
    return list;
}

/* One group of bands: its part of the arrays begins at `segment` and `connection`. */
static void group_json(json_t *object, int group, const struct mods_state *s, size_t segment, size_t connection, size_t count)
{
    const char *prefix = group == 0 ? "band" : "band2";
    const struct {
        const char *name;
        json_t *list;
    } lists[] = {
        {"T0", numbers(s->band_lb + segment, count + 1)},
        {"least_lb", numbers(s->band_least_lb + segment, count + 1)},
        {"most_lb", numbers(s->band_most_lb + segment, count + 1)},
        {"mats", numbers(s->band_mat + connection, count)},
        {"load_lb", numbers(s->band_load_lb + connection, count)},
        {"slipped", numbers(s->band_slip_ft + connection, count)},
        {"pulled", flagged(s->band_out + connection, s->band_mat + connection, count)},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        char name[24];
        snprintf(name, sizeof name, "%s_%s", prefix, lists[i].name);
        json_object_set_new(object, name, lists[i].list);
    }
}

json_t *sim_mods_json(const struct sim_scene *scene, const struct mods_state *s)
{
    if (!s)
        return NULL;
    json_t *object = json_object();
    size_t segment = 0, connection = 0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        size_t count = (size_t)mods_connections(scene, g);
        if (count == 0)
            continue;
        group_json(object, g, s, segment, connection, count);
        segment += count + 1;
        connection += count;
    }
    if (s->segments > 0)
        json_object_set_new(object, "band_error_lb", cli_json_number(s->error_lb, DIGITS));
    if (s->cleats > 0)
        json_object_set_new(object, "cleat_left", numbers(s->cleat_left, s->cleats));
    if (scene->mods.tear_lb < HUGE_VAL || scene->mods.torn.count > 0)
        json_object_set_new(object, "torn", flagged(s->torn, NULL, s->joints + 1));
    return object;
}

static size_t extreme(const double *values, size_t count, double sign)
{
    size_t at = 0;
    for (size_t i = 1; i < count; i++)
        at = sign * values[i] > sign * values[at] ? i : at;
    return at;
}

static void print_bands(const struct mods_state *s, double force, double length, const char *lb, const char *in)
{
    size_t least = extreme(s->band_least_lb, s->segments, -1.0), most = extreme(s->band_most_lb, s->segments, 1.0);
    size_t load = extreme(s->band_load_lb, s->connections, 1.0), slip = extreme(s->band_slip_ft, s->connections, 1.0);
    size_t slack = 0, out = 0;
    for (size_t i = 0; i < s->segments; i++)
        slack += s->band_least_lb[i] < 0.0;
    for (size_t i = 0; i < s->connections; i++)
        out += s->band_out[i] != 0.0;
    printf("  bands: tension %.4g to %.4g %s (segments %zu and %zu of %zu); %zu went slack; error estimate %.2g %s\n",
           force * fmax(0.0, s->band_least_lb[least]), force * s->band_most_lb[most], lb, least + 1, most + 1, s->segments,
           slack, force * s->error_lb, lb);
    printf("  connections: most carried %.4g %s (mat %.0f), most slip %.4g %s (mat %.0f), %zu of %zu pulled out\n",
           force * s->band_load_lb[load], lb, s->band_mat[load], length * s->band_slip_ft[slip], in, s->band_mat[slip],
           out, s->connections);
}

void sim_mods_print(const struct sim_scene *scene, const struct mods_state *s, bool si)
{
    if (!s)
        return;
    if (s->segments > 0)
        print_bands(s, si ? N_PER_LB : 1.0, si ? MM_PER_FT : 12.0, si ? "N" : "lb", si ? "mm" : "in");
    if (s->cleats > 0) {
        size_t worst = extreme(s->cleat_left, s->cleats, -1.0);
        double sum = 0.0;
        for (size_t i = 0; i < s->cleats; i++)
            sum += s->cleat_left[i];
        printf("  cleats: %.3g of their hold left on average, %.3g on mat %.0f\n", sum / (double)s->cleats,
               s->cleat_left[worst], s->cleat_mat[worst]);
    }
    size_t torn = 0;
    for (size_t j = 1; j <= s->joints; j++)
        torn += s->torn[j] != 0.0;
    if (torn > 0 || scene->mods.tear_lb < HUGE_VAL)
        printf("  joints torn in tension: %zu\n", torn);
}
