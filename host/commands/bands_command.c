/* matrig bands: restraining bands by Appendix C of the report, checked in the chain model. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "host/analyse/banddesign.h"
#include "host/base/answer.h"
#include "host/base/quantity.h"
#include "host/commands/commands.h"
#include "host/base/units.h"

#define WORDS_MAX 32
#define DISAGREE  0.1 /* of T0: simple theory and model say different things */

struct request {
    struct band_design design;
    double width_ft, thickness_ft; /* of a band; 0: the area is given */
    bool area_given, design_only;
    int64_t passes;
};

struct input {
    const char *name;
    const char *own, *unit; /* of what is kept, and of a bare number */
    double low, high;       /* in the latter */
    size_t offset;
};

#define IN_DESIGN(field) (offsetof(struct request, design) + offsetof(struct band_design, field))
static const struct input inputs[] = {
    {"weight", "lb", "lb", 1e-3, 1e9, IN_DESIGN(weight_lb)},
    {"deceleration", "ft/s2", "ft/s2", 1e-3, 1e3, IN_DESIGN(deceleration_ft_s2)},
    {"bands", "", "", 0.01, 1000, IN_DESIGN(bands)},
    {"width", "ft", "in", 1e-4, 1e4, offsetof(struct request, width_ft)},
    {"thickness", "ft", "in", 1e-4, 1e3, offsetof(struct request, thickness_ft)},
    {"area", "ft2", "in2", 1e-8, 1e6, IN_DESIGN(area_ft2)},
    {"yield", "lb/ft2", "psi", 1, 1e9, IN_DESIGN(yield_lb_ft2)},
    {"modulus", "lb/ft2", "psi", 1, 1e12, IN_DESIGN(modulus_lb_ft2)},
    {"mat", "lb", "lb", 1e-4, 1e6, IN_DESIGN(mat_lb)},
    {"friction", "", "", 0, 10, IN_DESIGN(friction)},
    {"held", "", "", 0, 1000, IN_DESIGN(held)},
    {"every", "", "", 1, 1000, IN_DESIGN(every)},
    {"row", "ft", "ft", 1e-3, 1000, IN_DESIGN(row_ft)},
    {"gear", "ft", "ft", 0, 1e4, IN_DESIGN(width_ft)},
    {"length", "ft", "ft", 0, 1e6, IN_DESIGN(length_ft)},
    {"spring", "lb/ft", "lb/ft", 1e-6, 1e12, IN_DESIGN(spring_lb_ft)},
    {"at", "", "", 0, 1, IN_DESIGN(at)},
    {"tension", "lb", "lb", 0, 1e9, IN_DESIGN(tension_lb)},
    {"grip", "lb", "lb", 0, 1e9, IN_DESIGN(grip_lb)},
    {"speed", "ft/s", "ft/s", 0.1, 1e4, IN_DESIGN(speed_ft_s)},
};

static enum mr_status find_input(const char *word, const struct input **input, const char **value,
                                 struct error *error)
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
        return error_set(error, MR_USAGE,
                         "not an input: '%s'; give NAME=VALUE[UNIT], as in weight=480kip", word);
    return error_set(error, MR_USAGE, "unknown input: '%.*s'; matrig bands --help lists the names",
                     (int)length, word);
}

/* "480kip", "0.5 g", "6in", "4": a bare number is in the input's own unit. */
static enum mr_status read_value(const struct input *input, const char *text, double *value,
                                 struct error *error)
{
    if (quantity_read(text, input->name, input->own, input->unit, value, error) != MR_OK)
        return error->status;
    if (!(*value >= quantity_convert(input->low, input->unit, input->own) &&
          *value <= quantity_convert(input->high, input->unit, input->own)))
        return error_set(error, MR_USAGE, "value out of range: %s is %s; give %g to %g %s",
                         input->name, text, input->low, input->high, input->unit);
    return MR_OK;
}

static enum mr_status read_words(const char **words, struct request *request, struct error *error)
{
    bool given[sizeof inputs / sizeof inputs[0]] = {false};
    for (size_t i = 0; i < WORDS_MAX && words[i]; i++) {
        const struct input *input = NULL;
        const char *text;
        double value = 0.0;
        if (find_input(words[i], &input, &text, error) != MR_OK ||
            read_value(input, text, &value, error) != MR_OK)
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
                         request->area_given ? "area and width or thickness"
                                             : "width or thickness alone");
    if (drawn)
        d->area_ft2 = request->width_ft * request->thickness_ft;
    if (d->every != floor(d->every))
        return error_set(error, MR_USAGE, "rows are whole: every is %g; give a whole number",
                         d->every);
    return MR_OK;
}

static enum mr_status read_request(int argc, char **argv, const struct cli *cli,
                                   struct request *request, struct error *error)
{
    const char *words[WORDS_MAX];
    band_design_defaults(&request->design);
    if (command_parse(&command_bands, argc, argv, cli, request, words, error) != MR_OK)
        return error->status;
    request->design.passes = (int)request->passes;
    return read_words(words, request, error);
}

/* --- what theory and model say --- */

#define FINDINGS_MAX 8
struct findings {
    char text[FINDINGS_MAX][200];
    size_t count;
    bool si;                        /* told in SI units */
    bool theory_fails, model_fails; /* the band goes slack, yields or slips */
};

enum weight { A_WARNING, THEORY_FAILS, MODEL_FAILS };

__attribute__((format(printf, 3, 4))) static void find(struct findings *findings,
                                                       enum weight weight, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    if (findings->count < FINDINGS_MAX)
        vsnprintf(findings->text[findings->count++], sizeof findings->text[0], format, list);
    va_end(list);
    findings->theory_fails = findings->theory_fails || weight == THEORY_FAILS;
    findings->model_fails = findings->model_fails || weight == MODEL_FAILS;
}

/* "55000 lb", "600 ft", "0.4 in" (of a movement in ft), or the same with --si. */
struct said {
    char text[UNIT_TEXT];
};
static struct said said(const struct findings *f, enum unit_kind kind, double value)
{
    struct said said;
    const struct unit *unit = unit_of(kind, f->si);
    snprintf(said.text, sizeof said.text, kind == UNIT_STATION ? "%.0f %s" : "%.6g %s",
             value * unit->factor, unit->text);
    return said;
}
static struct said force(const struct findings *f, double lb)
{
    return said(f, UNIT_TENSION, lb);
}

static void judge_theory(const struct band_design *d, struct findings *f)
{
    if (d->connections > d->most_connections)
        find(f, THEORY_FAILS,
             "theory: %.0f connections; C.10 allows %.0f: a shorter band, or more or stronger ones",
             d->connections, d->most_connections);
    if (d->t0_lb < d->least_t0_lb * (1.0 - 1e-9))
        find(f, THEORY_FAILS, "theory: T0 %s is below n F' + R/2 = %s (C.8): the band may go loose",
             force(f, d->t0_lb).text, force(f, d->least_t0_lb).text);
    if (d->t0_lb > d->most_t0_lb * (1.0 + 1e-9))
        find(f, THEORY_FAILS, "theory: T0 %s is above A fy - R/2 = %s (C.9): the band may yield",
             force(f, d->t0_lb).text, force(f, d->most_t0_lb).text);
}

static void judge_model(const struct band_design *d, const struct band_check *c, struct findings *f)
{
    double apart = DISAGREE * d->t0_lb;
    double least_lb = fmax(d->least_lb, 0.0); /* a slack band pulls 0 in theory */
    if (c->least_lb < 0.0 && d->least_lb >= -1e-9 * d->t0_lb)
        find(f, MODEL_FAILS,
             "disagree: the model's band goes loose at %s (pass %d), where theory leaves it "
             "%s",
             said(f, UNIT_STATION, c->least_ft).text, c->least_pass, force(f, least_lb).text);
    else if (c->least_lb < 0.0)
        find(f, MODEL_FAILS, "the model's band goes loose at %s (pass %d), as theory says",
             said(f, UNIT_STATION, c->least_ft).text, c->least_pass);
    else if (fabs(c->least_lb - least_lb) > apart)
        find(f, A_WARNING, "disagree: least tension %s in the model, %s by theory, which is %s",
             force(f, c->least_lb).text, force(f, least_lb).text,
             c->least_lb > least_lb ? "safe" : "NOT safe");
    if (c->most_lb > d->strength_lb)
        find(f, MODEL_FAILS, "%s: the model's band yields at %s (pass %d): %s, A fy is %s",
             d->most_lb > d->strength_lb ? "theory and model" : "disagree",
             said(f, UNIT_STATION, c->most_ft).text, c->most_pass, force(f, c->most_lb).text,
             force(f, d->strength_lb).text);
    else if (fabs(c->most_lb - d->most_lb) > apart)
        find(f, A_WARNING, "disagree: largest tension %s in the model, %s by theory, which is %s",
             force(f, c->most_lb).text, force(f, d->most_lb).text,
             c->most_lb < d->most_lb ? "safe" : "NOT safe");
    if (c->slip_ft > 0.0)
        find(f, MODEL_FAILS, "connections slip: up to %s; they hold %s",
             said(f, UNIT_MOVEMENT, c->slip_ft).text, force(f, d->grip_lb).text);
    if (c->load_lb > 2.0 * d->connection_lb)
        find(f, A_WARNING,
             "disagree: a connection carries up to %s (at %s); theory loads it with F' = "
             "%s only",
             force(f, c->load_lb).text, said(f, UNIT_STATION, c->load_ft).text,
             force(f, d->connection_lb).text);
}

struct figure {
    const char *name, *label; /* NULL: not for programs, not for people */
    enum unit_kind unit;
    int decimals;
    size_t offset;
    const char *says;
};

#define OF_DESIGN(field) offsetof(struct band_design, field)
static const struct figure design_figures[] = {
    {"R", "R", UNIT_TENSION, 1, OF_DESIGN(r_lb), ", braking force, (W/N) a/g (C.1)"},
    {"strength", "A fy", UNIT_TENSION, 1, OF_DESIGN(strength_lb), ", strength"},
    {"nF", "n F'", UNIT_TENSION, 1, OF_DESIGN(friction_lb),
     ", friction that it has room for, A fy - R (C.10)"},
    {"F", "F'", UNIT_TENSION, 1, OF_DESIGN(connection_lb), ", friction on one connection"},
    {NULL, "held", UNIT_NUMBER, 0, OF_DESIGN(held), " mats act against a connection"},
    {"n", "n", UNIT_NUMBER, 0, OF_DESIGN(connections), " connections"},
    {"n_most", "most of n", UNIT_NUMBER, 0, OF_DESIGN(most_connections), " connections"},
    {"longest", "length", UNIT_STATION, 1, OF_DESIGN(longest_ft), " between springs, at most"},
    {"T0", "T0", UNIT_TENSION, 1, OF_DESIGN(t0_lb), ", pretension"},
    {"T0_least", "at least", UNIT_TENSION, 1, OF_DESIGN(least_t0_lb), " (C.8)"},
    {"T0_most", "at most", UNIT_TENSION, 1, OF_DESIGN(most_t0_lb), " (C.9)"},
    {"ahead", "dT", UNIT_TENSION, 1, OF_DESIGN(ahead_lb), " ahead of the aircraft (C.6)"},
    {"behind", "dT", UNIT_TENSION, 1, OF_DESIGN(behind_lb), " behind it (C.7)"},
    {NULL, "at", UNIT_NUMBER, 2, OF_DESIGN(at), " of the length"},
    {"least", "least tension", UNIT_TENSION, 1, OF_DESIGN(least_lb), " by theory"},
    {"most", "largest", UNIT_TENSION, 1, OF_DESIGN(most_lb), " by theory"},
    {"spring", "K", UNIT_STIFFNESS, 1, OF_DESIGN(spring_lb_ft), ", springs at the ends"},
};

#define OF_CHECK(field) offsetof(struct band_check, field)
static const struct figure check_figures[] = {
    {"least", "least tension", UNIT_TENSION, 1, OF_CHECK(least_lb), NULL},
    {"least", "least at", UNIT_STATION, 1, OF_CHECK(least_ft), NULL},
    {"most", "largest", UNIT_TENSION, 1, OF_CHECK(most_lb), NULL},
    {"most", "largest at", UNIT_STATION, 1, OF_CHECK(most_ft), NULL},
    {"error", "error, tensions", UNIT_TENSION, 0, OF_CHECK(error_lb), ", the model's own estimate"},
    {"slack_share", "loose", UNIT_NUMBER, 3, OF_CHECK(slack_share), " of the segments at a time"},
    {"load", "most carried", UNIT_TENSION, 1, OF_CHECK(load_lb), " by a connection"},
    {"load", "carried at", UNIT_STATION, 1, OF_CHECK(load_ft), NULL},
    {"slip", "slip", UNIT_STATION, 4, OF_CHECK(slip_ft), " of a connection, at most"},
    {"residual", "left after it", UNIT_TENSION, 1, OF_CHECK(residual_lb),
     " less than T0, held by friction"},
    {"moved", "movement", UNIT_STATION, 4, OF_CHECK(moved_ft), " at most"},
    {"error", "error, movements", UNIT_STATION, 3, OF_CHECK(error_ft),
     ", the model's own estimate"},
};

static void figures_answer(const struct figure *figures, size_t count, const void *from,
                           struct answer *answer)
{
    for (size_t i = 0; i < count; i++) {
        const struct figure *f = &figures[i];
        double value;
        memcpy(&value, (const char *)from + f->offset, sizeof value);
        struct answer_fact *fact = answer_value(answer, f->name, f->label, f->unit, value,
                                                f->decimals);
        fact->digits = 9;
        fact->end = f->says;
    }
}

static void design_answer(const struct band_design *d, struct answer *answer)
{
    bool placed = d->spacing_ft > 0.0;
    answer_open(answer, "design", "design by Appendix C, per band");
    figures_answer(design_figures, sizeof design_figures / sizeof *design_figures, d, answer);
    answer_value(answer, "spacing", placed ? "s" : NULL, UNIT_STATION,
                 placed ? d->spacing_ft : (double)NAN, 2)
        ->digits = 9;
    answer_remark(answer, " from band to band (C.2)");
    answer_close(answer);
}

static void check_answer(const struct band_design *d, const struct band_check *c,
                         struct answer *answer)
{
    answer_open(answer, "model", "in the model");
    answer_words(answer, NULL, "strip",
                 "%d mats, of one band; %g rows from rivet to rivet, R all along it, %d passes",
                 c->mats, d->every, d->passes);
    answer_count(answer, "mats", NULL, c->mats);
    answer_count(answer, "least_pass", NULL, c->least_pass);
    answer_count(answer, "most_pass", NULL, c->most_pass);
    figures_answer(check_figures, sizeof check_figures / sizeof *check_figures, c, answer);
    answer_close(answer);
}

static struct answer *answer_of(const struct request *request, const struct band_check *check,
                                const struct findings *f, bool si)
{
    struct answer *answer = answer_new(si);
    answer_as_given(answer);
    design_answer(&request->design, answer);
    if (request->design_only)
        answer_none(answer, "model", NULL, "");
    else
        check_answer(&request->design, check, answer);
    answer_list(answer, "findings", "");
    for (size_t i = 0; i < f->count; i++)
        answer_words(answer, NULL, "finding", "%s", f->text[i]);
    answer_close(answer);
    if (f->model_fails && !f->theory_fails)
        answer_sentence(answer, NULL,
                        "the theory allows this band, the model does not: leave it more room");
    answer_flag(answer, "holds_by_theory", NULL, !f->theory_fails);
    if (request->design_only)
        answer_none(answer, "holds_in_model", NULL, "");
    else
        answer_flag(answer, "holds_in_model", NULL, !f->model_fails);
    return answer;
}

/* The report's own example has its bands at the limit of the theory, so that any knock in the model
 * goes beyond it: what the model says against the theory is a warning. */
static int bands_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct band_check check = {0};
    struct findings findings = {.si = cli->si};
    struct error error = {0};
    struct band_design *d = &request.design;
    if (read_request(argc, argv, cli, &request, &error) != MR_OK ||
        band_design(d, &error) != MR_OK ||
        (!request.design_only && band_check(d, &check, &error) != MR_OK))
        return cli_fail(&error);
    judge_theory(d, &findings);
    if (!request.design_only)
        judge_model(d, &check, &findings);
    return answer_show(cli, answer_of(&request, &check, &findings, cli->si),
                       findings.theory_fails ? 1 : 0);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM(
        "NAME=VALUE",
        "what is not given is the report's example (a number alone is in the unit named here):\n"
        "weight (lb), deceleration (ft/s2), bands, width and thickness (in) or area (in2), yield, "
        "modulus\n"
        "(psi), mat (lb), friction, held (mats that act against a connection), every (rows from "
        "rivet to\n"
        "rivet), row (ft), gear (ft, width of influence), length (ft between springs; else the "
        "longest),\n"
        "spring (lb/ft), at (0 to 1, where dT is worked out), tension (lb, T0), grip (lb, of a "
        "connection),\n"
        "speed (ft/s, in the model)"),
    HELP_ITEM("UNIT",
              "any of the input's kind: lb kip N kN kgf kg (the weight of that mass), ft in m "
              "mm, ft/s mph m/s,\n"
              "ft/s2 g m/s2, psi ksi MPa GPa, lb/ft lb/in kip/in N/mm, in2 ft2 mm2"),
    OPTION_FLAG("--design-only", design_only, "leave the model out"),
    OPTION_WHOLE("--passes", "N", passes, 1.0, 100.0, 2.0,
                 "how often the aircraft passes in the model; else {standard}"),
    HELP_NOTE("Exit 1 when the band goes loose or yields by theory. What the model says otherwise "
              "is a warning: the report's own example has\n"
              "its bands at the theory's limit, and R goes from rivet to rivet in knocks. "),
    HELP_EXAMPLE("\n"
                 "  matrig bands weight=480kip deceleration=0.5g bands=4 width=6in "
                 "thickness=0.375in yield=50ksi"),
};

const struct command command_bands = {
    "bands",
    bands_command,
    "[NAME=VALUE[UNIT]...] [--design-only] [--passes N]",
    "design restraining bands by Appendix C, and check them in the model",
    COMMAND_PARTS(parts),
    {0, WORDS_MAX, "[NAME=VALUE[UNIT]...]"},
};
