/* matrig scale: quantities, scene files and study files between model and prototype. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/commands/commands.h"
#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/units.h"
#include "host/landing_series/scale.h"

#define GRAVITY_FT_S2 32.174

static enum mr_status read_request(int argc, char **argv, const struct cli *cli,
                                   struct scale_request *request, struct error *error)
{
    if (command_parse(&command_scale, argc, argv, cli, request, request->words, error) != MR_OK)
        return error->status;
    while (request->count < SCALE_WORDS_MAX && request->words[request->count])
        request->count++;
    if (isnan(request->n))
        /* to lay joints anew does not scale */
        request->n = request->lay_deg > 0.0 && !request->to ? 1.0 : 7.0;
    request->to_model = request->to && strcmp(request->to, "model") == 0;
    request->rule = request->keep && strcmp(request->keep, "modulus") == 0 ? MR_KEEP_MODULUS
                                                                           : MR_KEEP_DENSITY;
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

/* Without words: every ratio. */
static int show_ratios(const struct scale_request *request, const struct cli *cli)
{
    struct answer *answer = scale_answer(request);
    answer_sentence(answer, NULL, "prototype / model at n = %g, %s kept", request->n,
                    request->rule == MR_KEEP_DENSITY ? "density" : "modulus");
    answer_table(answer, "ratios", "");
    for (size_t i = 0; i < mr_quantity_count; i++) {
        const struct mr_quantity *quantity = &mr_quantities[i];
        char power[16];
        power_text(mr_similitude_half_powers(request->rule, quantity->dimension), power);
        answer_row(answer);
        answer_words(answer, "name", "quantity", "%s", quantity->name);
        answer_words(answer, "symbol", "symbol", "%s", quantity->symbol);
        answer_words(answer, "power", "power", "%s", power);
        answer_value(answer, "ratio", "ratio", UNIT_NUMBER,
                     mr_similitude_ratio(request->rule, request->n, quantity->dimension), -6)
            ->digits = 12;
    }
    answer_close(answer);
    return answer_show(cli, answer, 0);
}

struct value {
    const struct mr_quantity *quantity;
    double from, to;
};

/* "108", or with a unit: "24.5kN", "24.5 kN"; in the quantity's own unit. */
static enum mr_status read_number(const char *text, const char *name, struct value *value,
                                  struct error *error)
{
    const char *own = value->quantity->unit;
    enum mr_status status = quantity_read(text, name, own, NULL, &value->from, error);
    if (status == MR_OK && fabs(value->from) > 1e30)
        status = error_set(error, MR_USAGE, "out of range: %s for %s; allowed is -1e30 to 1e30 %s",
                           text, name, own);
    return status;
}

static enum mr_status read_value(const char *word, struct value *value, struct error *error)
{
    const char *equals = strchr(word, '=');
    char name[40];
    if (!equals || equals == word || (size_t)(equals - word) >= sizeof name)
        return error_set(error, MR_USAGE,
                         "not a quantity: '%s'; give NAME=VALUE (matrig scale lists the names)",
                         word);
    memcpy(name, word, (size_t)(equals - word));
    name[equals - word] = '\0';
    value->quantity = mr_quantity_find(name);
    for (size_t i = 0; !value->quantity && i < mr_quantity_count; i++) {
        if (strcasecmp(name, mr_quantities[i].symbol) == 0 ||
            strcasecmp(name, mr_quantities[i].name) == 0)
            return error_set(error, MR_USAGE,
                             "unknown quantity: '%s'; '%s' is %s; matrig scale lists the names",
                             name, mr_quantities[i].symbol, mr_quantities[i].name);
    }
    if (!value->quantity)
        return error_set(error, MR_USAGE, "unknown quantity: '%s'; matrig scale lists the names",
                         name);
    return read_number(equals + 1, name, value, error);
}

/* The ten inputs of the pi terms, of either side; NaN where nothing was given. */
static void pi_inputs(const struct value *values, size_t count, bool scaled,
                      double inputs[MR_PI_INPUTS])
{
    for (int i = 0; i < MR_PI_INPUTS; i++) {
        inputs[i] = strcmp(mr_pi_inputs[i], "gravity") == 0 ? GRAVITY_FT_S2 : (double)NAN;
        for (size_t k = 0; k < count; k++) {
            if (strcmp(values[k].quantity->name, mr_pi_inputs[i]) == 0)
                inputs[i] = scaled ? values[k].to : values[k].from;
        }
    }
}

static void answer_both(struct answer *answer, double from, double to)
{
    answer_value(answer, "from", NULL, UNIT_NUMBER, from, 0)->digits = 12;
    answer_value(answer, "to", NULL, UNIT_NUMBER, to, 0)->digits = 12;
}

static int scale_values(const struct scale_request *request, const struct cli *cli)
{
    struct value values[SCALE_WORDS_MAX];
    struct error error = {0};
    double from[MR_PI_INPUTS], to[MR_PI_INPUTS];
    for (size_t i = 0; i < request->count; i++) {
        if (read_value(request->words[i], &values[i], &error) != MR_OK)
            return cli_fail(&error);
        for (size_t k = 0; k < i; k++) {
            if (values[k].quantity == values[i].quantity)
                error_set(&error, MR_USAGE, "given twice: %s; leave one out",
                          values[i].quantity->name);
        }
        if (error.status != MR_OK)
            return cli_fail(&error);
        values[i].to = values[i].from * scale_factor(request, values[i].quantity->dimension);
    }
    pi_inputs(values, request->count, false, from);
    pi_inputs(values, request->count, true, to);
    struct answer *answer = scale_answer(request);
    answer_open(answer, "values", "");
    for (size_t i = 0; i < request->count; i++) {
        const struct mr_quantity *quantity = values[i].quantity;
        answer_words(answer, NULL, quantity->name, "%14.8g  ->  %14.8g %s", values[i].from,
                     values[i].to, quantity->unit);
        answer_open(answer, quantity->name, NULL);
        answer_both(answer, values[i].from, values[i].to);
        answer_words(answer, "unit", NULL, "%s", quantity->unit);
        answer_close(answer);
    }
    answer_close(answer);
    answer_open(answer, "pi", "");
    for (size_t i = 0; i < mr_pi_term_count; i++) {
        double before = mr_pi_value(&mr_pi_terms[i], from),
               after = mr_pi_value(&mr_pi_terms[i], to);
        char label[40];
        if (!isfinite(before) || !isfinite(after))
            continue;
        snprintf(label, sizeof label, "pi %s", mr_pi_terms[i].name);
        answer_words(answer, NULL, label, "%14.8g  =   %14.8g", before, after);
        answer_open(answer, mr_pi_terms[i].name, NULL);
        answer_both(answer, before, after);
        answer_close(answer);
    }
    answer_close(answer);
    return answer_show(cli, answer, 0);
}

static int scale_command(int argc, char **argv, const struct cli *cli)
{
    struct scale_request request = {0};
    struct error error = {0};
    if (read_request(argc, argv, cli, &request, &error) != MR_OK)
        return cli_fail(&error);
    bool file = request.count == 1 && !strchr(request.words[0], '=');
    if (request.lay_deg > 0.0 && !file)
        error_set(&error, MR_USAGE,
                  "nothing to lay: --lay is for a scene or a study; give its file");
    else if (request.output_path && request.count > 0 && !file)
        error_set(&error, MR_USAGE, "nothing to write: -o %s is for a scene; leave it out",
                  request.output_path);
    else if (output_check(request.output_path, file ? request.words[0] : NULL, &error) == MR_OK)
        output_keep(request.output_path, request.force, &error);
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (request.count == 0)
        return show_ratios(&request, cli);
    return file ? scale_file(&request, cli) : scale_values(&request, cli);
}

#define VALUES struct scale_request
static const struct command_part parts[] = {
    HELP_ITEM("NAME=VALUE", "a quantity, by name or symbol; without any, all ratios are listed. "
                            "Dimensionless terms that the\n"
                            "given quantities make up are shown for both sides"),
    HELP_ITEM("SCENE",
              "scene file, JSON: every key is scaled, defaults that scale are written out"),
    HELP_ITEM("STUDY", "study file (it has landings): runway, aircraft, landings and what they "
                       "apply, its scene inside"),
    OPTION_CHOICE("--to", "SIDE", to, "side", "model|prototype",
                  "prototype (the default: what is given is the model's) or model"),
    OPTION_NUMBER("--n", "N", n, NULL, 1e-3, 1e3, (double)NAN,
                  "prototype length / model length; else 7"),
    HELP_ITEM("--keep density", "the 1/7 model's rule: forces by n^3 (the default)"),
    HELP_ITEM("--keep modulus", "the pilot model's rule: forces by n^2"),
    OPTION_NUMBER("--lay", "DEG", lay_deg, "deg", 1.0, 80.0, 0.0,
                  "turn the joints of a standard pattern so far from straight across: the keys of "
                  "a strip along the runway,\n"
                  "N so that it stays as long; scales only with --to or --n. Sliding (lay_slide, "
                  "lay_mu) is yours to add"),
    OPTION_TEXT("-o", "F", output_path, "where to write the scene; else standard output"),
    OPTION_FORCE(force),
    HELP_NOTE("Units are those of the scene keys (ft, lb, slug, s), also with --si; a value may "
              "have another of its kind: F=480N."),
    HELP_EXAMPLE(
        "matrig scale F=108 v=35.5; matrig scale host/scenes/model_runway.json -o prototype.json\n"
        "  matrig scale host/landing_series/series/rig.json --lay 45 -o diagonal.json"),
    OPTION_CHOICE("--keep", "RULE", keep, "rule", "density|modulus", NULL),
};

const struct command command_scale = {
    "scale",
    scale_command,
    "[NAME=VALUE... | SCENE | STUDY] [--to model|prototype] [--n N] [--keep density|modulus] "
    "[--lay DEG] [-o F] [--force]",
    "quantities, scenes and study files between model and prototype",
    COMMAND_PARTS(parts),
    {0, SCALE_WORDS_MAX, "NAME=VALUE... or SCENE"},
};
