/* matrig bands: restraining bands by Appendix C of the report, checked in the chain model. */
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/banddesign.h"
#include "host/commands/commands.h"

#define WORDS_MAX 32
#define N_PER_LB 4.4482216152605
#define M_PER_FT 0.3048
#define DISAGREE 0.1 /* of T0: simple theory and model say different things */

enum dimension { NUMBER, FORCE, LENGTH, SPEED, ACCELERATION, STRESS, STIFFNESS, AREA };

struct unit_word {
    const char *text;
    enum dimension dimension;
    double factor; /* to lb, ft, s */
};

static const struct unit_word unit_words[] = {
    {"lb", FORCE, 1.0},
    {"kip", FORCE, 1e3},
    {"N", FORCE, 1.0 / N_PER_LB},
    {"kN", FORCE, 1e3 / N_PER_LB},
    {"ft", LENGTH, 1.0},
    {"in", LENGTH, 1.0 / 12.0},
    {"m", LENGTH, 1.0 / M_PER_FT},
    {"mm", LENGTH, 1e-3 / M_PER_FT},
    {"ft/s", SPEED, 1.0},
    {"mph", SPEED, 5280.0 / 3600.0},
    {"m/s", SPEED, 1.0 / M_PER_FT},
    {"ft/s2", ACCELERATION, 1.0},
    {"g", ACCELERATION, 32.174},
    {"m/s2", ACCELERATION, 1.0 / M_PER_FT},
    {"psi", STRESS, 144.0},
    {"ksi", STRESS, 144e3},
    {"MPa", STRESS, 1e6 / N_PER_LB * M_PER_FT * M_PER_FT},
    {"GPa", STRESS, 1e9 / N_PER_LB * M_PER_FT * M_PER_FT},
    {"lb/ft", STIFFNESS, 1.0},
    {"lb/in", STIFFNESS, 12.0},
    {"kip/in", STIFFNESS, 12e3},
    {"N/mm", STIFFNESS, 1e3 / N_PER_LB * M_PER_FT},
    {"in2", AREA, 1.0 / 144.0},
    {"ft2", AREA, 1.0},
    {"mm2", AREA, 1e-6 / (M_PER_FT * M_PER_FT)},
};

struct request {
    struct band_design design;
    double width_ft, thickness_ft; /* of a band; 0: the area is given */
    bool area_given, design_only, strict;
    int64_t passes;
};

struct input {
    const char *name;
    enum dimension dimension;
    const char *unit; /* of a bare number */
    double low, high; /* in the unit of the text */
    size_t offset;
};

#define IN_DESIGN(field) (offsetof(struct request, design) + offsetof(struct band_design, field))
static const struct input inputs[] = {
    {"weight", FORCE, "lb", 1e-3, 1e9, IN_DESIGN(weight_lb)},
    {"deceleration", ACCELERATION, "ft/s2", 1e-3, 1e3, IN_DESIGN(deceleration_ft_s2)},
    {"bands", NUMBER, "", 0.01, 1000, IN_DESIGN(bands)},
    {"width", LENGTH, "in", 1e-4, 1e4, offsetof(struct request, width_ft)},
    {"thickness", LENGTH, "in", 1e-4, 1e3, offsetof(struct request, thickness_ft)},
    {"area", AREA, "in2", 1e-8, 1e6, IN_DESIGN(area_ft2)},
    {"yield", STRESS, "psi", 1, 1e9, IN_DESIGN(yield_lb_ft2)},
    {"modulus", STRESS, "psi", 1, 1e12, IN_DESIGN(modulus_lb_ft2)},
    {"mat", FORCE, "lb", 1e-4, 1e6, IN_DESIGN(mat_lb)},
    {"friction", NUMBER, "", 0, 10, IN_DESIGN(friction)},
    {"held", NUMBER, "", 0, 1000, IN_DESIGN(held)},
    {"every", NUMBER, "", 1, 1000, IN_DESIGN(every)},
    {"row", LENGTH, "ft", 1e-3, 1000, IN_DESIGN(row_ft)},
    {"gear", LENGTH, "ft", 0, 1e4, IN_DESIGN(width_ft)},
    {"length", LENGTH, "ft", 0, 1e6, IN_DESIGN(length_ft)},
    {"spring", STIFFNESS, "lb/ft", 1e-6, 1e12, IN_DESIGN(spring_lb_ft)},
    {"at", NUMBER, "", 0, 1, IN_DESIGN(at)},
    {"tension", FORCE, "lb", 0, 1e9, IN_DESIGN(tension_lb)},
    {"grip", FORCE, "lb", 0, 1e9, IN_DESIGN(grip_lb)},
    {"speed", SPEED, "ft/s", 0.1, 1e4, IN_DESIGN(speed_ft_s)},
};

static enum mr_status find_input(const char *word, const struct input **input, const char **value, struct error *error)
{
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : 0;
    *value = equals ? equals + 1 : NULL;
    for (size_t i = 0; equals && i < sizeof inputs / sizeof inputs[0]; i++) {
        *input = &inputs[i];
        if (strlen(inputs[i].name) == length && strncmp(inputs[i].name, word, length) == 0)
            return MR_OK;
    }
    if (!equals || length == 0)
        return error_set(error, MR_USAGE, "not an input: '%s'; give NAME=VALUE[UNIT], as in weight=480kip", word);
    return error_set(error, MR_USAGE, "unknown input: '%.*s'; matrig bands --help lists the names", (int)length, word);
}

/* "480kip", "0.5 g", "6in", "4": a bare number is in the input's own unit. */
static enum mr_status read_value(const struct input *input, const char *text, double *value, struct error *error)
{
    char *end;
    char names[160] = "";
    double number = strtod(text, &end);
    if (end == text || !isfinite(number))
        return error_set(error, MR_USAGE, "not a number: '%s' for %s; give a number and a unit", text, input->name);
    while (isspace((unsigned char)*end))
        end++;
    const char *unit = *end ? end : input->unit;
    double factor = 1.0;
    bool known = input->dimension == NUMBER && !*unit;
    for (size_t i = 0; i < sizeof unit_words / sizeof unit_words[0]; i++) {
        if (unit_words[i].dimension != input->dimension)
            continue;
        snprintf(names + strlen(names), sizeof names - strlen(names), " %s", unit_words[i].text);
        if (strcmp(unit_words[i].text, unit) == 0) {
            factor = unit_words[i].factor;
            known = true;
        }
    }
    if (!known)
        return error_set(error, MR_USAGE, "unknown unit: '%s' for %s; give one of%s", unit, input->name,
                         input->dimension == NUMBER ? " none: it is a plain number" : names);
    double own = 1.0; /* of the input's own unit: the range is in it */
    for (size_t i = 0; i < sizeof unit_words / sizeof unit_words[0]; i++) {
        if (strcmp(unit_words[i].text, input->unit) == 0)
            own = unit_words[i].factor;
    }
    *value = number * factor;
    if (!(*value >= input->low * own * (1.0 - 1e-12) && *value <= input->high * own * (1.0 + 1e-12)))
        return error_set(error, MR_USAGE, "value out of range: %s is %s; give %g to %g %s", input->name, text, input->low,
                         input->high, input->unit);
    return MR_OK;
}

static enum mr_status read_words(const char **words, struct request *request, struct error *error)
{
    bool given[sizeof inputs / sizeof inputs[0]] = {false};
    for (size_t i = 0; i < WORDS_MAX && words[i]; i++) {
        const struct input *input = NULL;
        const char *text;
        double value = 0.0;
        if (find_input(words[i], &input, &text, error) != MR_OK || read_value(input, text, &value, error) != MR_OK)
            return error->status;
        if (given[input - inputs])
            return error_set(error, MR_USAGE, "given twice: %s; leave one out", input->name);
        given[input - inputs] = true;
        memcpy((char *)request + input->offset, &value, sizeof value);
        request->area_given = request->area_given || strcmp(input->name, "area") == 0;
    }
    struct band_design *d = &request->design;
    bool drawn = request->width_ft > 0.0 || request->thickness_ft > 0.0;
    if (drawn && (request->area_given || !(request->width_ft > 0.0 && request->thickness_ft > 0.0)))
        return error_set(error, MR_USAGE, "band's section: %s; give width and thickness, or area",
                         request->area_given ? "area and width or thickness" : "width or thickness alone");
    if (drawn)
        d->area_ft2 = request->width_ft * request->thickness_ft;
    if (d->every != floor(d->every))
        return error_set(error, MR_USAGE, "rows are whole: every is %g; give a whole number", d->every);
    return MR_OK;
}

static enum mr_status read_request(int argc, char **argv, const struct cli *cli, struct request *request, struct error *error)
{
    const char *words[WORDS_MAX];
    band_design_defaults(&request->design);
    if (command_parse(&command_bands, argc, argv, cli, request, words, error) != MR_OK)
        return error->status;
    request->design.passes = (int)request->passes;
    if (request->strict && request->design_only)
        return error_set(error, MR_USAGE, "at odds: --strict is about the model, which --design-only leaves out; give one");
    return read_words(words, request, error);
}

/* --- what theory and model say --- */

#define FINDINGS_MAX 8
struct findings {
    char text[FINDINGS_MAX][200];
    size_t count;
    bool theory_fails, model_fails; /* the band goes slack, yields or slips */
};

enum weight { A_WARNING, THEORY_FAILS, MODEL_FAILS };

__attribute__((format(printf, 3, 4))) static void find(struct findings *findings, enum weight weight, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    if (findings->count < FINDINGS_MAX)
        vsnprintf(findings->text[findings->count++], sizeof findings->text[0], format, list);
    va_end(list);
    findings->theory_fails = findings->theory_fails || weight == THEORY_FAILS;
    findings->model_fails = findings->model_fails || weight == MODEL_FAILS;
}

static void judge_theory(const struct band_design *d, struct findings *f)
{
    if (d->connections > d->most_connections)
        find(f, THEORY_FAILS, "theory: %.0f connections; C.10 allows %.0f: a shorter band, or more or stronger ones", d->connections,
             d->most_connections);
    if (d->t0_lb < d->least_t0_lb * (1.0 - 1e-9))
        find(f, THEORY_FAILS, "theory: T0 %.6g lb is below n F' + R/2 = %.6g lb (C.8): the band may go loose", d->t0_lb,
             d->least_t0_lb);
    if (d->t0_lb > d->most_t0_lb * (1.0 + 1e-9))
        find(f, THEORY_FAILS, "theory: T0 %.6g lb is above A fy - R/2 = %.6g lb (C.9): the band may yield", d->t0_lb, d->most_t0_lb);
}

static void judge_model(const struct band_design *d, const struct band_check *c, struct findings *f)
{
    double apart = DISAGREE * d->t0_lb;
    double least_lb = fmax(d->least_lb, 0.0); /* a slack band pulls 0 in theory */
    if (c->least_lb < 0.0 && d->least_lb >= -1e-9 * d->t0_lb)
        find(f, MODEL_FAILS, "disagree: the model's band goes loose at %.0f ft (pass %d), where theory leaves it %.6g lb", c->least_ft,
             c->least_pass, least_lb);
    else if (c->least_lb < 0.0)
        find(f, MODEL_FAILS, "the model's band goes loose at %.0f ft (pass %d), as theory says", c->least_ft, c->least_pass);
    else if (fabs(c->least_lb - least_lb) > apart)
        find(f, A_WARNING, "disagree: least tension %.6g lb in the model, %.6g by theory, which is %s", c->least_lb, least_lb,
             c->least_lb > least_lb ? "safe" : "NOT safe");
    if (c->most_lb > d->strength_lb)
        find(f, MODEL_FAILS, "%s: the model's band yields at %.0f ft (pass %d): %.6g lb, A fy is %.6g lb",
             d->most_lb > d->strength_lb ? "theory and model" : "disagree", c->most_ft, c->most_pass, c->most_lb,
             d->strength_lb);
    else if (fabs(c->most_lb - d->most_lb) > apart)
        find(f, A_WARNING, "disagree: largest tension %.6g lb in the model, %.6g by theory, which is %s", c->most_lb, d->most_lb,
             c->most_lb < d->most_lb ? "safe" : "NOT safe");
    if (c->slip_ft > 0.0)
        find(f, MODEL_FAILS, "connections slip: up to %.4g in; they hold %.6g lb", 12.0 * c->slip_ft, d->grip_lb);
    if (c->load_lb > 2.0 * d->connection_lb)
        find(f, A_WARNING, "disagree: a connection carries up to %.6g lb (at %.0f ft); theory loads it with F' = %.6g lb only",
             c->load_lb, c->load_ft, d->connection_lb);
}

/* The report's own example has its bands at the limit of the theory, so that any knock in the model goes beyond it: what the
 * model says against the theory is a warning, unless --strict. */
static int exit_code(const struct request *request, const struct findings *f)
{
    return f->theory_fails || (request->strict && f->model_fails) ? 1 : 0;
}

static json_t *round9(double value)
{
    return cli_json_number(value, 9);
}

static json_t *design_json(const struct band_design *d)
{
    json_t *object = json_object();
    const struct {
        const char *name;
        double value;
    } values[] = {
        {"R_lb", d->r_lb},
        {"strength_lb", d->strength_lb},
        {"nF_lb", d->friction_lb},
        {"F_lb", d->connection_lb},
        {"n", d->connections},
        {"n_most", d->most_connections},
        {"longest_ft", d->longest_ft},
        {"T0_least_lb", d->least_t0_lb},
        {"T0_most_lb", d->most_t0_lb},
        {"T0_lb", d->t0_lb},
        {"spring_lb_ft", d->spring_lb_ft},
        {"ahead_lb", d->ahead_lb},
        {"behind_lb", d->behind_lb},
        {"least_lb", d->least_lb},
        {"most_lb", d->most_lb},
    };
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        json_object_set_new(object, values[i].name, round9(values[i].value));
    json_object_set_new(object, "spacing_ft", d->spacing_ft > 0.0 ? round9(d->spacing_ft) : json_null());
    return object;
}

static json_t *check_json(const struct band_check *c)
{
    return json_pack("{s:i,s:o,s:o,s:i,s:o,s:o,s:i,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "mats", c->mats, "least_lb",
                     round9(c->least_lb), "least_ft", round9(c->least_ft), "least_pass", c->least_pass, "most_lb",
                     round9(c->most_lb), "most_ft", round9(c->most_ft), "most_pass", c->most_pass, "slack_share",
                     round9(c->slack_share), "load_lb", round9(c->load_lb), "load_ft", round9(c->load_ft), "slip_ft",
                     round9(c->slip_ft), "moved_ft", round9(c->moved_ft), "residual_lb", round9(c->residual_lb), "error_lb",
                     round9(c->error_lb), "error_ft", round9(c->error_ft));
}

static int print_json(const struct request *request, const struct band_check *check, const struct findings *findings)
{
    json_t *list = json_array();
    for (size_t i = 0; i < findings->count; i++)
        json_array_append_new(list, json_string(findings->text[i]));
    json_t *object = json_pack("{s:o,s:o,s:o,s:b,s:o}", "design", design_json(&request->design), "model",
                               request->design_only ? json_null() : check_json(check), "findings", list, "holds_by_theory",
                               !findings->theory_fails, "holds_in_model",
                               request->design_only ? json_null() : json_boolean(!findings->model_fails));
    return cli_print_json(object, exit_code(request, findings));
}

static void print_design(const struct band_design *d, double lb, double ft, const char *force, const char *length)
{
    printf("design by Appendix C, per band\n");
    printf("  R       %14.8g %-3s braking force, (W/N) a/g (C.1)\n", lb * d->r_lb, force);
    printf("  A fy    %14.8g %-3s strength\n", lb * d->strength_lb, force);
    printf("  n F'    %14.8g %-3s friction that it has room for, A fy - R (C.10)\n", lb * d->friction_lb, force);
    printf("  F'      %14.8g %-3s friction on one connection: %g mats\n", lb * d->connection_lb, force, d->held);
    printf("  n       %14.0f     connections%s\n", d->connections, d->length_ft > 0.0 ? "" : ", at most");
    printf("  length  %14.8g %-3s between springs, at most\n", ft * d->longest_ft, length);
    printf("  T0      %14.8g %-3s pretension; %.8g (C.8) to %.8g (C.9)\n", lb * d->t0_lb, force, lb * d->least_t0_lb,
           lb * d->most_t0_lb);
    if (d->spacing_ft > 0.0)
        printf("  s       %14.8g %-3s from band to band (C.2)\n", ft * d->spacing_ft, length);
    printf("  K       %14.8g %s/%s springs at the ends\n", lb / ft * d->spring_lb_ft, force, length);
    printf("  dT      %14.8g %-3s ahead of the aircraft (C.6), %+.8g behind (C.7), at %g of the length\n", lb * d->ahead_lb,
           force, lb * d->behind_lb, d->at);
}

static void print_check(const struct band_design *d, const struct band_check *c, double lb, double ft, const char *force,
                        const char *length)
{
    printf("in the model: %d mats of one band's strip, %g rows from rivet to rivet, R all along it, %d passes\n", c->mats,
           d->every, d->passes);
    printf("  least tension    %12.6g %-3s at %.6g %s (theory %.6g)\n", lb * c->least_lb, force, ft * c->least_ft, length,
           lb * d->least_lb);
    printf("  largest tension  %12.6g %-3s at %.6g %s (theory %.6g)\n", lb * c->most_lb, force, ft * c->most_ft, length,
           lb * d->most_lb);
    printf("  loose at a time  %12.3g %%   of the segments\n", 100.0 * c->slack_share);
    printf("  most carried     %12.6g %-3s by a connection\n", lb * c->load_lb, force);
    printf("  left after it    %12.6g %-3s less than T0, held by friction\n", lb * c->residual_lb, force);
    printf("  movement         %12.4g %-3s at most; error estimates %.2g %s, %.2g %s\n", ft * c->moved_ft, length,
           ft * c->error_ft, length, lb * c->error_lb, force);
}

static int bands_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct band_check check = {0};
    struct findings findings = {0};
    struct error error = {0};
    struct band_design *d = &request.design;
    if (read_request(argc, argv, cli, &request, &error) != MR_OK || band_design(d, &error) != MR_OK ||
        (!request.design_only && band_check(d, &check, &error) != MR_OK))
        return cli_fail(&error);
    judge_theory(d, &findings);
    if (!request.design_only)
        judge_model(d, &check, &findings);
    if (cli->json)
        return print_json(&request, &check, &findings);
    double lb = cli->si ? N_PER_LB : 1.0, ft = cli->si ? M_PER_FT : 1.0;
    const char *force = cli->si ? "N" : "lb", *length = cli->si ? "m" : "ft";
    print_design(d, lb, ft, force, length);
    if (!request.design_only)
        print_check(d, &check, lb, ft, force, length);
    for (size_t i = 0; i < findings.count; i++)
        printf("! %s\n", findings.text[i]);
    if (findings.model_fails && !findings.theory_fails)
        printf("the theory allows this band, the model does not: leave it more room%s\n",
               request.strict ? "" : " (a warning; --strict makes it the exit code)");
    return exit_code(&request, &findings);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("NAME=VALUE",
                "what is not given is the report's example (a number alone is in the unit named here):\n"
                "weight (lb), deceleration (ft/s2), bands, width and thickness (in) or area (in2), yield, modulus\n"
                "(psi), mat (lb), friction, held (mats that act against a connection), every (rows from rivet to\n"
                "rivet), row (ft), gear (ft, width of influence), length (ft between springs; else the longest),\n"
                "spring (lb/ft), at (0 to 1, where dT is worked out), tension (lb, T0), grip (lb, of a connection),\n"
                "speed (ft/s, in the model)"),
    HELP_ITEM("UNIT",
                "lb kip N kN, ft in m mm, ft/s mph m/s, ft/s2 g m/s2, psi ksi MPa GPa, lb/ft lb/in kip/in N/mm,\n"
                "in2 ft2 mm2"),
    OPTION_FLAG("--design-only", design_only, "leave the model out"),
    OPTION_WHOLE("--passes", "N", passes, 1.0, 100.0, 2.0, "how often the aircraft passes in the model; else {standard}"),
    OPTION_FLAG("--strict", strict, "exit 1 for what only the model finds, too"),
    HELP_NOTE("Exit 1 when the band goes loose or yields by theory. What the model says otherwise is a warning: the report's own example has\n"
              "its bands at the theory's limit, and R goes from rivet to rivet in knocks. "),
    HELP_EXAMPLE("\n"
                 "  matrig bands weight=480kip deceleration=0.5g bands=4 width=6in thickness=0.375in yield=50ksi"),
};

const struct command command_bands = {
    "bands", bands_command,
    "[NAME=VALUE[UNIT]...] [--design-only] [--passes N] [--strict]",
    "design restraining bands by Appendix C, and check them in the model", COMMAND_PARTS(parts), {0, WORDS_MAX, "[NAME=VALUE[UNIT]...]"},
};
