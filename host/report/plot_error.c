#include "host/report/plot_error.h"

#include <math.h>
#include <string.h>

#include "host/base/svg.h"

#define WIDTH        860.0
#define HEIGHT       470.0
#define TOP          74.0
#define PANEL_HEIGHT 340.0
#define LEFT         64.0
#define BETWEEN      66.0
#define RIGHT        14.0
#define SOLVERS_MAX  8
#define RADIUS       3.7
#define LEAST_FT     1e-16 /* below every error that is not 0 */

/* Colours that stay apart for all kinds of sight (Okabe and Ito), each with a shape of its own. */
static const struct look {
    const char *solver, *class;
    unsigned shape;
} looks[] = {{"event", "ea", 0},   {"implicit", "eb", 1}, {"cvode", "ec", 2},    {"rkgs", "ed", 3},
             {"hamming", "ee", 4}, {"rk4", "ef", 5},      {"staggered", "ea", 0}};

static const char style[] =
    "<style>.ep{background:#fff;font:12px Helvetica,Arial,sans-serif}.ep "
    ".frame{fill:none;stroke:#444}"
    ".ep .grid{stroke:#d4d8dc;fill:none}.ep .minor{stroke:#eff1f3;fill:none}.ep .tick,.ep "
    ".label{fill:#222}"
    ".ep .head{fill:#111;font-weight:bold;font-size:13px}.ep .small{fill:#444;font-size:11px}"
    ".ep .line{fill:none;stroke-width:1.6;stroke-linejoin:round}.ep "
    ".floor{fill:#b8bec5;fill-opacity:.55}"
    ".ep .paper{fill:#fff}.ep .ea{stroke:#0072b2}.ep .eb{stroke:#d55e00}.ep .ec{stroke:#009e73}"
    ".ep .ed{stroke:#b8529a}.ep .ee{stroke:#a67c00}.ep .ef{stroke:#222}"
    ".ep .full.ea{fill:#0072b2}.ep .full.eb{fill:#d55e00}.ep .full.ec{fill:#009e73}"
    ".ep .full.ed{fill:#b8529a}.ep .full.ee{fill:#a67c00}.ep .full.ef{fill:#222}"
    ".ep .open{fill:#fff;stroke-width:1.4}</style>\n";

static const struct look *look_of(const char *solver)
{
    for (size_t i = 0; i + 1 < sizeof looks / sizeof looks[0]; i++) {
        if (strcmp(looks[i].solver, solver) == 0)
            return &looks[i];
    }
    return &looks[sizeof looks / sizeof looks[0] - 1];
}

enum quantity { LIFT, U, RMS };

static double error_ft(const struct error_run *run, enum quantity quantity)
{
    return quantity == LIFT ? run->lift_ft : quantity == U ? run->u_ft : run->rms_u_ft;
}

static double agreement_ft(const struct error_study *study, enum quantity quantity)
{
    return quantity == LIFT ? study->agreement_lift_ft
         : quantity == U    ? study->agreement_u_ft
                            : study->agreement_rms_u_ft;
}

static double down_to(double value, double digits)
{
    return pow(10.0, floor(log10(value) * digits) / digits);
}

static double up_to(double value, double digits)
{
    return pow(10.0, ceil(log10(value) * digits) / digits);
}

static void axes(struct svg_plot *plot, const struct error_study *study, enum quantity quantity)
{
    static const char *const labels[] = {"largest error of lift, ft", "largest error of u, ft",
                                         "rms error of u, ft"};
    double floor_ft = fmax(agreement_ft(study, quantity), LEAST_FT);
    double high = 10.0 * floor_ft, left = HUGE_VAL, right = 0.0;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if (run->status != SIM_OK)
            continue;
        high = fmax(high, error_ft(run, quantity));
        left = fmin(left, run->ms);
        right = fmax(right, run->ms);
    }
    if (!(right > 0.0))
        left = right = 1.0;
    left = fmax(left, 1e-6);
    right = fmax(right, left);
    plot->x = (struct svg_axis){down_to(0.85 * left, 2.0), up_to(1.15 * right, 2.0), "run time, ms",
                                true};
    plot->y = (struct svg_axis){down_to(0.3 * floor_ft, 1.0), up_to(1.5 * high, 2.0),
                                labels[quantity], true};
    plot->log_x = plot->log_y = true;
}

static void draw_solver(const struct svg_plot *plot, const struct error_study *study,
                        const char *solver, enum quantity quantity)
{
    const struct look *look = look_of(solver);
    double x[ERROR_RUNS_MAX], y[ERROR_RUNS_MAX];
    char line[20], full[20], open[20];
    size_t count = 0;
    snprintf(line, sizeof line, "line %s", look->class);
    snprintf(full, sizeof full, "full %s", look->class);
    snprintf(open, sizeof open, "open %s", look->class);
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if (strcmp(run->solver, solver) != 0 || run->beyond)
            continue;
        bool ok = run->status == SIM_OK; /* a failed run breaks the line */
        x[count] = ok ? fmax(run->ms, plot->x.low) : (double)NAN;
        y[count++] = ok ? fmax(error_ft(run, quantity), plot->y.low) : (double)NAN;
    }
    svg_line(plot, line, x, y, count);
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if (strcmp(run->solver, solver) != 0 || run->status != SIM_OK)
            continue;
        svg_mark(plot->out, run->beyond ? open : full, look->shape,
                 svg_x(plot, fmax(run->ms, plot->x.low)),
                 svg_y(plot, fmax(error_ft(run, quantity), plot->y.low)), RADIUS);
    }
}

static void draw_panel(FILE *out, const struct error_study *study, enum quantity quantity,
                       double left, double width)
{
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    struct svg_plot plot = {
        .out = out, .left = left, .top = TOP, .width = width, .height = PANEL_HEIGHT};
    double floor_ft = agreement_ft(study, quantity);
    axes(&plot, study, quantity);
    svg_rect(&plot, "paper", plot.x.low, plot.y.low, plot.x.high, plot.y.high);
    svg_axes(&plot);
    if (floor_ft > 0.0) {
        svg_rect(&plot, "floor", plot.x.low, plot.y.low, plot.x.high, floor_ft);
        svg_text(&plot, "small", "start", plot.x.low, floor_ft, 6.0, 13.0,
                 "the references' disagreement");
    }
    for (size_t k = 0; k < count; k++)
        draw_solver(&plot, study, names[k], quantity);
}

static void draw_legend(FILE *out, const struct error_study *study)
{
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX), beyond = 0;
    double x = LEFT, y = 44.0;
    char class[20];
    for (size_t k = 0; k < count; k++) {
        const struct look *look = look_of(names[k]);
        snprintf(class, sizeof class, "line %s", look->class);
        fprintf(out, "<path class=\"%s\" d=\"M%.1f %.1fh26\"/>", class, x, y);
        snprintf(class, sizeof class, "full %s", look->class);
        svg_mark(out, class, look->shape, x + 13.0, y, RADIUS);
        fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">%s</text>\n", x + 31.0, y + 4.0,
                names[k]);
        x += 48.0 + 7.0 * (double)strlen(names[k]);
    }
    for (size_t i = 0; i < study->run_count; i++)
        beyond += study->runs[i].beyond && study->runs[i].status == SIM_OK;
    if (beyond == 0)
        return;
    svg_mark(out, "open ef", look_of("rk4")->shape, x + 13.0, y, RADIUS);
    fprintf(out,
            "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">beyond the stability limit (refused by "
            "sim)</text>\n",
            x + 24.0, y + 4.0);
}

/* Runs that failed have no error to draw; they are named, by solver. */
static void draw_failed(FILE *out, const struct error_study *study)
{
    const char *last = "";
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if (run->status == SIM_OK)
            continue;
        if (!*last)
            fprintf(out, "<text class=\"small\" x=\"%.0f\" y=\"%.0f\">without an answer: ", LEFT,
                    HEIGHT - 8.0);
        if (strcmp(last, run->solver) != 0)
            fprintf(out, "%s%s %s", *last ? "; " : "", run->solver,
                    run->dt_s > 0.0 ? "dt" : "rtol");
        else
            fputc(',', out);
        fprintf(out, " %.3g", run->dt_s > 0.0 ? run->dt_s : run->rtol);
        last = run->solver;
    }
    if (*last)
        fputs("</text>\n", out);
}

static void draw(FILE *out, const char *name, const struct error_study *study)
{
    double width = (WIDTH - LEFT - RIGHT - BETWEEN) / 2.0;
    struct svg_plot all = {.out = out,
                           .left = LEFT,
                           .top = 20.0,
                           .width = 1.0,
                           .height = 1.0,
                           .x = {0, 1, NULL, false},
                           .y = {0, 1, NULL, false}};
    fprintf(out, "<g class=\"ep\">%s<rect class=\"paper\" width=\"%.0f\" height=\"%.0f\"/>\n",
            style, WIDTH, HEIGHT);
    svg_text(&all, "head", "start", 0.0, 1.0, 0.0, 0.0, name);
    draw_legend(out, study);
    draw_panel(out, study, study->lifts ? LIFT : U, LEFT, width);
    draw_panel(out, study, study->lifts ? U : RMS, LEFT + width + BETWEEN, width);
    draw_failed(out, study);
    fputs("</g>\n", out);
    svg_close(out);
}

void plot_error(FILE *out, const char *name, const struct error_study *study)
{
    svg_open(out, WIDTH, HEIGHT, name);
    draw(out, name, study);
}

void plot_error_file(FILE *out, const char *name, const struct error_study *study)
{
    svg_open_file(out, WIDTH, HEIGHT, name);
    draw(out, name, study);
}
