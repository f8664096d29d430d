#include "host/sim/mods_answer.h"

#include <math.h>
#include <stdio.h>

#include "host/base/cli.h"

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
static void add_group(struct answer *answer, int group, const struct mods_state *s, size_t segment,
                      size_t connection, size_t count)
{
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
        snprintf(name, sizeof name, "%s_%s", group == 0 ? "band" : "band2", lists[i].name);
        answer_json_value(answer, name, lists[i].list);
    }
}

static size_t extreme(const double *values, size_t count, double sign)
{
    size_t at = 0;
    for (size_t i = 1; i < count; i++)
        at = sign * values[i] > sign * values[at] ? i : at;
    return at;
}

static void add_bands(struct answer *answer, const struct mods_state *s)
{
    size_t least = extreme(s->band_least_lb, s->segments, -1.0),
           most = extreme(s->band_most_lb, s->segments, 1.0);
    size_t load = extreme(s->band_load_lb, s->connections, 1.0),
           slip = extreme(s->band_slip_ft, s->connections, 1.0);
    size_t slack = 0, out = 0;
    for (size_t i = 0; i < s->segments; i++)
        slack += s->band_least_lb[i] < 0.0;
    for (size_t i = 0; i < s->connections; i++)
        out += s->band_out[i] != 0.0;
    answer_value(answer, NULL, "least tension", UNIT_TENSION, fmax(0.0, s->band_least_lb[least]),
                 -4);
    answer_remark(answer, ", in segment %zu of %zu; %zu went slack", least + 1, s->segments, slack);
    answer_value(answer, NULL, "largest tension", UNIT_TENSION, s->band_most_lb[most], -4);
    answer_remark(answer, ", in segment %zu", most + 1);
    answer_value(answer, "band_error", "error of tension", UNIT_TENSION, s->error_lb, -2)->digits =
        DIGITS;
    answer_value(answer, NULL, "most carried", UNIT_TENSION, s->band_load_lb[load], -4);
    answer_remark(answer, ", by the connection at mat %.0f", s->band_mat[load]);
    answer_value(answer, NULL, "most slip", UNIT_MOVEMENT, s->band_slip_ft[slip], -4);
    answer_remark(answer, ", of the connection at mat %.0f; %zu of %zu pulled out",
                  s->band_mat[slip], out, s->connections);
}

static void add_cleats(struct answer *answer, const struct mods_state *s)
{
    size_t worst = extreme(s->cleat_left, s->cleats, -1.0);
    double sum = 0.0;
    for (size_t i = 0; i < s->cleats; i++)
        sum += s->cleat_left[i];
    answer_json_value(answer, "cleat_left", numbers(s->cleat_left, s->cleats));
    answer_value(answer, NULL, "hold of cleats", UNIT_NUMBER, sum / (double)s->cleats, -3);
    answer_remark(answer, " of it is left on average, %.3g on mat %.0f", s->cleat_left[worst],
                  s->cleat_mat[worst]);
}

void mods_answer(struct answer *answer, const struct sim_scene *scene, const struct mods_state *s)
{
    size_t segment = 0, connection = 0, torn = 0;
    if (!s)
        return;
    answer_open(answer, "mods", "");
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        size_t count = (size_t)mods_connections(scene, g);
        if (count == 0)
            continue;
        add_group(answer, g, s, segment, connection, count);
        segment += count + 1;
        connection += count;
    }
    if (s->segments > 0)
        add_bands(answer, s);
    if (s->cleats > 0)
        add_cleats(answer, s);
    for (size_t j = 1; j <= s->joints; j++)
        torn += s->torn[j] != 0.0;
    bool may_tear = scene->mods.tear_lb < HUGE_VAL || scene->mods.unhinge_deg < HUGE_VAL;
    if (may_tear || scene->mods.torn.count > 0)
        answer_json_value(answer, "torn", flagged(s->torn, NULL, s->joints + 1));
    if (may_tear || torn > 0)
        answer_count(answer, NULL, "joints torn", (int64_t)torn);
    answer_close(answer);
}
