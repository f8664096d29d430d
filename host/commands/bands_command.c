/* The command matrig bands: design of restraining bands by Appendix C of the report. Units are lb,
 * ft and s. Two equations are misprinted: C.3 has N instead of W (R = (W a/g)(s/b)), and C.10 has n
 * instead of n F' (n F' = A fy - R). The worked example confirms both corrections. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "host/base/answer.h"
#include "host/base/quantity.h"
#include "host/commands/commands.h"
#include "host/base/units.h"

#define WORDS_MAX 32

struct band_design {
    /* the next fields are given by the user */
    double weight_lb, g_ft_s2, deceleration_ft_s2;
    double band_count; /* number of bands that share the load, N */
    double area_ft2, yield_lb_ft2, modulus_lb_ft2;
    double mat_weight_lb, friction;
    double mats_per_connection; /* number of mats that load one connection */
    double rows_per_connection; /* rows of mats from one connection to the next */
    double mat_length_ft;       /* length of a mat along the runway */
    double gear_width_ft;       /* influence width of the gear, b; 0: not given */
    /* length of a band between the springs at its ends; 0: the longest that C.10 allows */
    double band_length_ft;
    /* stiffness K of the spring at each end; 0: A E/L, with which the tension changes by R/2 */
    double spring_stiffness_lb_ft;
    /* a': position along the band at which R acts, as a fraction of its length */
    double force_position;
    double specified_t0_lb; /* initial tension T0; 0: the middle of the limits C.8 and C.9 */
    /* the next fields are computed by design_bands */
    double band_load_lb;           /* load R on a band, C.1 */
    double strength_lb;            /* force at which a band yields, A fy */
    double max_friction_lb;        /* largest n F' within C.8 and C.9, from C.10 */
    double connection_friction_lb; /* F', friction force at one connection */
    /* number n of connections: from the band length if that is given, otherwise the largest
     * possible */
    double connection_count;
    double max_connection_count;
    double max_band_length_ft;
    double t0_min_lb, t0_max_lb; /* limits of T0 for n connections, C.8 and C.9 */
    double t0_lb;                /* T0: given, or the middle of t0_min_lb and t0_max_lb */
    double spacing_ft;           /* spacing of the bands, C.2; 0: not known */
    double tension_change_ahead_lb,
        tension_change_behind_lb; /* changes of the tension ahead of R and behind R, C.6 and C.7 */
    double min_tension_lb,
        max_tension_lb; /* smallest and largest tension that result: T0 - n F' - R/2, T0 + R/2 */
};

#define IN2_PER_FT2 144.0
#define G_FT_S2     (9.80665 / 0.3048) /* gravity, for a deceleration given in g */

/* Sets the inputs of the worked example of Appendix C. */
static void set_defaults(struct band_design *design)
{
    *design = (struct band_design){
        .weight_lb = 480e3,
        .g_ft_s2 = G_FT_S2,
        .deceleration_ft_s2 = 0.5 * G_FT_S2,
        .band_count = 4.0,
        .area_ft2 = 6.0 * 0.375 / IN2_PER_FT2,
        .yield_lb_ft2 = 50e3 * IN2_PER_FT2,
        .modulus_lb_ft2 = 29e6 * IN2_PER_FT2,
        .mat_weight_lb = 160.0,
        .friction = 0.5,
        .mats_per_connection = 4.0,
        .rows_per_connection = 10.0,
        .mat_length_ft = 2.0,
        .spring_stiffness_lb_ft = 0.0,
        .force_position = 0.5,
    };
}

static enum mr_status set_strength_error(const struct band_design *d, struct error *error)
{
    return error_set(error, MR_USAGE,
                     "bands too weak: each band carries R = %.6g lb and yields at A fy = %.6g lb "
                     "(by C.10, n F' = %.6g lb); give more bands, or a larger area or yield",
                     d->band_load_lb, d->strength_lb, d->strength_lb - d->band_load_lb);
}

/* Computes the results from the inputs. MR_USAGE: no band meets these inputs; `error` has the
 * reason. */
static enum mr_status design_bands(struct band_design *d, struct error *error)
{
    d->band_load_lb = d->weight_lb * d->deceleration_ft_s2 / d->g_ft_s2 / d->band_count;
    d->strength_lb = d->area_ft2 * d->yield_lb_ft2;
    d->max_friction_lb = d->strength_lb - d->band_load_lb;
    if (!(d->max_friction_lb > 0.0))
        return set_strength_error(d, error);
    d->connection_friction_lb = d->mats_per_connection * d->friction * d->mat_weight_lb;
    d->max_connection_count =
        d->connection_friction_lb > 0.0
            ? floor(d->max_friction_lb / d->connection_friction_lb * (1.0 + 1e-12))
            : HUGE_VAL;
    double apart_ft = d->rows_per_connection * d->mat_length_ft;
    d->max_band_length_ft = d->max_connection_count * apart_ft;
    d->connection_count = d->band_length_ft > 0.0
                            ? floor(d->band_length_ft / apart_ft * (1.0 + 1e-12))
                            : d->max_connection_count;
    /* Without a band length, held_lb is the largest n F' that C.10 allows, even if n is then not a
     * whole number, as in the worked example: 52.5 kip, not 164 x 320 lb. */
    double held_lb = d->band_length_ft > 0.0 ? d->connection_count * d->connection_friction_lb
                                             : d->max_friction_lb;
    d->t0_min_lb = held_lb + 0.5 * d->band_load_lb;
    d->t0_max_lb = d->strength_lb - 0.5 * d->band_load_lb;
    d->t0_lb = d->specified_t0_lb > 0.0 ? d->specified_t0_lb : 0.5 * (d->t0_min_lb + d->t0_max_lb);
    d->spacing_ft = d->gear_width_ft > 0.0 ? d->gear_width_ft / d->band_count : 0.0;
    double length_ft = d->band_length_ft > 0.0 ? d->band_length_ft : d->max_band_length_ft;
    double band_lb_ft = d->area_ft2 * d->modulus_lb_ft2 / length_ft;
    if (!(d->spring_stiffness_lb_ft > 0.0))
        d->spring_stiffness_lb_ft = band_lb_ft;
    /* ratio of the stiffness of a spring to that of the band, K L/(A E) */
    double give = d->spring_stiffness_lb_ft / band_lb_ft;
    d->tension_change_ahead_lb = -d->band_load_lb * (d->force_position * give + 1.0) / (give + 2.0);
    d->tension_change_behind_lb = d->band_load_lb * ((1.0 - d->force_position) * give + 1.0) /
                                  (give + 2.0);
    d->min_tension_lb = d->t0_lb - held_lb - 0.5 * d->band_load_lb;
    d->max_tension_lb = d->t0_lb + 0.5 * d->band_load_lb;
    return MR_OK;
}

struct request {
    struct band_design design;
    /* width and thickness of one band; 0: the area is given instead */
    double width_ft, thickness_ft;
    bool has_area;
};

struct design_input {
    const char *name;
    const char *field_unit,
        *default_unit; /* unit of the field, and unit of an input without a unit */
    double low, high;  /* smallest and largest value, in `default_unit` */
    size_t offset;
};

#define DESIGN_OFFSET(field) \
    (offsetof(struct request, design) + offsetof(struct band_design, field))
static const struct design_input inputs[] = {
    {"weight", "lb", "lb", 1e-3, 1e9, DESIGN_OFFSET(weight_lb)},
    {"deceleration", "ft/s2", "ft/s2", 1e-3, 1e3, DESIGN_OFFSET(deceleration_ft_s2)},
    {"bands", "", "", 0.01, 1000, DESIGN_OFFSET(band_count)},
    {"width", "ft", "in", 1e-4, 1e4, offsetof(struct request, width_ft)},
    {"thickness", "ft", "in", 1e-4, 1e3, offsetof(struct request, thickness_ft)},
    {"area", "ft2", "in2", 1e-8, 1e6, DESIGN_OFFSET(area_ft2)},
    {"yield", "lb/ft2", "psi", 1, 1e9, DESIGN_OFFSET(yield_lb_ft2)},
    {"modulus", "lb/ft2", "psi", 1, 1e12, DESIGN_OFFSET(modulus_lb_ft2)},
    {"mat", "lb", "lb", 1e-4, 1e6, DESIGN_OFFSET(mat_weight_lb)},
    {"friction", "", "", 0, 10, DESIGN_OFFSET(friction)},
    {"held", "", "", 0, 1000, DESIGN_OFFSET(mats_per_connection)},
    {"every", "", "", 1, 1000, DESIGN_OFFSET(rows_per_connection)},
    {"row", "ft", "ft", 1e-3, 1000, DESIGN_OFFSET(mat_length_ft)},
    {"gear", "ft", "ft", 0, 1e4, DESIGN_OFFSET(gear_width_ft)},
    {"length", "ft", "ft", 0, 1e6, DESIGN_OFFSET(band_length_ft)},
    {"spring", "lb/ft", "lb/ft", 1e-6, 1e12, DESIGN_OFFSET(spring_stiffness_lb_ft)},
    {"at", "", "", 0, 1, DESIGN_OFFSET(force_position)},
    {"tension", "lb", "lb", 0, 1e9, DESIGN_OFFSET(specified_t0_lb)},
};

static const struct design_input *find_input(const char *word, const char **value)
{
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : 0;
    *value = equals ? equals + 1 : NULL;
    for (size_t i = 0; equals && i < sizeof inputs / sizeof inputs[0]; i++) {
        if (strlen(inputs[i].name) == length && strncmp(inputs[i].name, word, length) == 0)
            return &inputs[i];
    }
    if (!equals || length == 0)
        error_set(fatal, MR_USAGE,
                  "not an input: '%s'; give NAME=VALUE[UNIT], such as weight=480kip", word);
    error_set(fatal, MR_USAGE, "unknown input: '%.*s'; matrig bands --help lists the names",
              (int)length, word);
    return NULL;
}

/* Reads "480kip", "0.5 g", "6in" or "4". A number without a unit is in `input->default_unit`. */
static double read_value(const struct design_input *input, const char *text)
{
    double value = 0.0;
    quantity_read(text, input->name, input->field_unit, input->default_unit, &value, fatal);
    if (!(value >= quantity_convert(input->low, input->default_unit, input->field_unit) &&
          value <= quantity_convert(input->high, input->default_unit, input->field_unit)))
        error_set(fatal, MR_USAGE, "value out of range: %s is %s; give %g to %g %s", input->name,
                  text, input->low, input->high, input->default_unit);
    return value;
}

static void read_words(const char **words, struct request *request)
{
    bool given[sizeof inputs / sizeof inputs[0]] = {false};
    for (size_t i = 0; i < WORDS_MAX && words[i]; i++) {
        const char *text;
        const struct design_input *input = find_input(words[i], &text);
        double value = read_value(input, text);
        if (given[input - inputs])
            error_set(fatal, MR_USAGE, "%s is given twice; leave one out", input->name);
        given[input - inputs] = true;
        memcpy((char *)request + input->offset, &value, sizeof value);
        request->has_area = request->has_area || strcmp(input->name, "area") == 0;
    }
    struct band_design *d = &request->design;
    bool drawn = request->width_ft > 0.0 || request->thickness_ft > 0.0;
    if (drawn && (request->has_area || !(request->width_ft > 0.0 && request->thickness_ft > 0.0)))
        error_set(fatal, MR_USAGE,
                  "the cross section of the band is not defined: %s; give either width and "
                  "thickness, or area",
                  request->has_area ? "area and width or thickness are given"
                                    : "only width or thickness is given");
    if (drawn)
        d->area_ft2 = request->width_ft * request->thickness_ft;
    if (d->rows_per_connection != floor(d->rows_per_connection))
        error_set(fatal, MR_USAGE, "not a whole number: every=%g; give a whole number of rows",
                  d->rows_per_connection);
}

/* ---- theory ---- */

#define FINDINGS_MAX 4
struct findings {
    char text[FINDINGS_MAX][200];
    size_t count;
    bool si; /* print results in SI units */
};

__attribute__((format(printf, 2, 3))) static void add_finding(struct findings *findings,
                                                              const char *format, ...)
{
    va_list list;
    va_start(list, format);
    if (findings->count < FINDINGS_MAX)
        vsnprintf(findings->text[findings->count++], sizeof findings->text[0], format, list);
    va_end(list);
}

struct force_text {
    char text[UNIT_TEXT_SIZE];
};
static struct force_text format_force(const struct findings *f, double lb)
{
    struct force_text out;
    const struct unit *unit = unit_get(UNIT_TENSION, f->si);
    snprintf(out.text, sizeof out.text, "%.6g %s", lb * unit->factor, unit->text);
    return out;
}

static void check_design(const struct band_design *d, struct findings *f)
{
    if (d->connection_count > d->max_connection_count)
        add_finding(f,
                    "theory requires %.0f connections, but C.10 allows only %.0f; use more, "
                    "shorter or stronger bands",
                    d->connection_count, d->max_connection_count);
    if (d->t0_lb < d->t0_min_lb * (1.0 - 1e-9))
        add_finding(f, "theory: T0 %s is below n F' + R/2 = %s (C.8), so the band may become loose",
                    format_force(f, d->t0_lb).text, format_force(f, d->t0_min_lb).text);
    if (d->t0_lb > d->t0_max_lb * (1.0 + 1e-9))
        add_finding(f, "theory: T0 %s is above A fy - R/2 = %s (C.9), so the band may yield",
                    format_force(f, d->t0_lb).text, format_force(f, d->t0_max_lb).text);
}

struct result_field {
    const char *name, *label; /* name NULL: not in the JSON; label NULL: only in the JSON */
    enum unit_kind unit;
    int decimals;
    size_t offset;
    const char *note;
};

#define DESIGN_FIELD(field) offsetof(struct band_design, field)
static const struct result_field result_fields[] = {
    {"R", "R", UNIT_TENSION, 1, DESIGN_FIELD(band_load_lb), ", braking force, (W/N) a/g (C.1)"},
    {"strength", "A fy", UNIT_TENSION, 1, DESIGN_FIELD(strength_lb), ", strength"},
    {"nF", "n F'", UNIT_TENSION, 1, DESIGN_FIELD(max_friction_lb),
     ", available friction, A fy - R (C.10)"},
    {"F", "F'", UNIT_TENSION, 1, DESIGN_FIELD(connection_friction_lb),
     ", friction on one connection"},
    {NULL, "held", UNIT_NUMBER, 0, DESIGN_FIELD(mats_per_connection), " mats load one connection"},
    {"n", "n", UNIT_NUMBER, 0, DESIGN_FIELD(connection_count), " connections"},
    {"n_most", "largest n", UNIT_NUMBER, 0, DESIGN_FIELD(max_connection_count), " connections"},
    {"longest", "length", UNIT_STATION, 1, DESIGN_FIELD(max_band_length_ft),
     " between springs, at most"},
    {"T0", "T0", UNIT_TENSION, 1, DESIGN_FIELD(t0_lb), ", pretension"},
    {"T0_least", "at least", UNIT_TENSION, 1, DESIGN_FIELD(t0_min_lb), " (C.8)"},
    {"T0_most", "at most", UNIT_TENSION, 1, DESIGN_FIELD(t0_max_lb), " (C.9)"},
    {"ahead", "dT", UNIT_TENSION, 1, DESIGN_FIELD(tension_change_ahead_lb),
     " ahead of the aircraft (C.6)"},
    {"behind", "dT", UNIT_TENSION, 1, DESIGN_FIELD(tension_change_behind_lb), " behind it (C.7)"},
    {NULL, "at", UNIT_NUMBER, 2, DESIGN_FIELD(force_position),
     " of the length, where the braking force acts"},
    {"least", "least tension", UNIT_TENSION, 1, DESIGN_FIELD(min_tension_lb), " by theory"},
    {"most", "largest tension", UNIT_TENSION, 1, DESIGN_FIELD(max_tension_lb), " by theory"},
    {"spring", "K", UNIT_STIFFNESS, 1, DESIGN_FIELD(spring_stiffness_lb_ft),
     ", springs at the ends"},
};

static void add_design_values(const struct band_design *d, struct answer *answer)
{
    for (size_t i = 0; i < sizeof result_fields / sizeof *result_fields; i++) {
        double value;
        memcpy(&value, (const char *)d + result_fields[i].offset, sizeof value);
        struct answer_style *fact = answer_add_value(answer, result_fields[i].name,
                                                     result_fields[i].label, result_fields[i].unit,
                                                     value, result_fields[i].decimals);
        fact->digits = 9;
        fact->suffix = result_fields[i].note;
    }
}

static struct answer *make_answer(const struct band_design *d, const struct findings *f)
{
    struct answer *answer = answer_new(f->si);
    bool placed = d->spacing_ft > 0.0;
    answer_keep_units(answer);
    answer_open_group(answer, "design", "design by Appendix C, per band");
    add_design_values(d, answer);
    answer_add_value(answer, "spacing", placed ? "s" : NULL, UNIT_STATION,
                     placed ? d->spacing_ft : (double)NAN, 2)
        ->digits = 9;
    answer_append_remark(answer, " from band to band (C.2)");
    answer_close_group(answer);
    answer_open_list(answer, "findings", "");
    for (size_t i = 0; i < f->count; i++)
        answer_add_text(answer, NULL, "finding", "%s", f->text[i]);
    answer_close_group(answer);
    answer_add_flag(answer, "holds_by_theory", NULL, f->count == 0);
    return answer;
}

static int bands_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct findings findings = {.si = cli->si};
    const char *words[WORDS_MAX];
    set_defaults(&request.design);
    command_parse(&command_bands, argc, argv, cli, &request, words, fatal);
    read_words(words, &request);
    design_bands(&request.design, fatal);
    check_design(&request.design, &findings);
    return answer_print(cli, make_answer(&request.design, &findings), findings.count ? 1 : 0);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("NAME=VALUE",
              "an input; default: the report's example. Inputs and their units: weight (lb), "
              "deceleration (ft/s2), bands, width and thickness (in) or area (in2), yield, modulus "
              "(psi), mat (lb), friction, held (mats that load one connection), every (rows "
              "from rivet to rivet), row (ft, length of a mat), gear (ft, width of influence of "
              "the gear), length (ft between springs; default: longest possible), spring (lb/ft), "
              "at (0 to 1, where the braking force acts along the length), tension (lb, T0)"),
    HELP_ITEM("UNIT",
              "a different unit: lb kip N kN kgf kg (the weight of that mass), ft in m mm, ft/s "
              "mph m/s, ft/s2 g m/s2, psi ksi MPa GPa, lb/ft lb/in kip/in N/mm, in2 ft2 mm2"),
    HELP_NOTE("Exit 1 when a band becomes loose or yields. The theory omits the impacts when the "
              "force passes from rivet to rivet, so simulate the band (matrig sim, "
              "host/scenes/model_runway_bands.json) before you build it."),
    HELP_EXAMPLE("\n"
                 "  matrig bands weight=480kip deceleration=0.5g bands=4 width=6in "
                 "thickness=0.375in yield=50ksi"),
};

const struct command command_bands = {
    "bands",
    bands_command,
    "[NAME=VALUE[UNIT]...]",
    "design restraining bands by Appendix C of the report",
    COMMAND_PARTS(parts),
    {0, WORDS_MAX, "[NAME=VALUE[UNIT]...]"},
};
