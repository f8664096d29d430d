/* error-report FOLDER [SCENE...]: error studies of the standard scenes, with campaigns' engines and
 * the onboard predictor; or of the scenes given. FOLDER/index.html. Exit 5 when the reference of a
 * scene fails. `predictor` in place of scenes: the section of the predictor alone. */
#include <stdio.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/output.h"
#include "host/base/html.h"
#include "host/report/plot_error.h"
#include "host/sim/solvers/pass.h"
#include "tests/error_report/report.h"

static const char *const standard[] = {
    "host/scenes/rstar_fig3_7_n30.json",   "host/scenes/rstar_fig3_7_n30_tanh.json",
    "host/scenes/rstar_fig3_6.json",       "host/scenes/full_width_144000.json",
    "host/scenes/rstar_fig3_12_tad1.json", "host/scenes/consistent_fig3_7.json",
    "host/scenes/model_runway.json",
};

static const char head[] =
    "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Error against run "
    "time</title><style>"
    "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 "
    "1em}table{border-collapse:collapse;"
    "font-size:13px;margin:8px 0}td,th{border:1px solid #ccc;padding:2px 8px;text-align:left}"
    ".scroll{overflow-x:auto}svg{width:100%;height:auto}h2{margin-top:2.5em}.small{color:#555;font-"
    "size:13px}"
    "</style></head><body>\n<h1>Error against run time</h1>\n"
    "<p>Each solver over tolerances or steps, single passes, against a reference that two "
    "different methods agree on. "
    "Errors are the largest over all mats at 64 even times and t_out, of lift also over the run. A "
    "run's time is "
    "processor time, the least of up to five. A fixed step is judged by the worst of itself and "
    "its two neighbours, a factor &radic;2 away. "
    "The second table of a scene has the slopes p that were observed, with the range and scatter "
    "of the runs they come from: "
    "error ~ rtol^p, dt^p, or rhs^-p (rhs: evaluations of the right-hand side).</p>\n";

static enum mr_status one_scene(FILE *out, const char *path, struct error *error)
{
    struct sim_scene scene;
    struct error_study study;
    double begin_s = monotonic_s();
    if (sim_scene_load(&scene, path, error) != MR_OK)
        return error->status;
    printf("%-40s", scene.name[0] ? scene.name : path);
    fflush(stdout);
    fputs("<h2>", out);
    html_text(out, scene.name[0] ? scene.name : path);
    fputs("</h2>\n", out);
    if (error_study_run(&study, &scene, NULL, NULL, error) == MR_OK) {
        fprintf(out, "<p class=\"small\">%s: model %s, %d mats, %.4g s. Reference: %s.</p>\n", path,
                sim_model_name(scene.model), scene.mats, study.end_s, study.method);
        write_conclusion(out, &study);
        plot_error(out, scene.name[0] ? scene.name : path, &study);
        write_tables(out, &study);
        for (size_t i = 0; study.notes[i][0]; i++)
            fprintf(out, "<p class=\"small\">%s</p>\n", study.notes[i]);
        const struct error_run *best = error_study_cheapest(&study, NULL, 5e-6);
        printf(" %5.1f s   reference to %.0e ft   cheapest at 5e-6 ft: %s\n",
               monotonic_s() - begin_s,
               study.lifts ? study.agreement_lift_ft : study.agreement_u_ft,
               best ? best->solver : "none");
    } else {
        putchar('\n');
    }
    sim_scene_free(&scene);
    return error->status;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    char path[400];
    if (argc < 2) {
        fputs("usage: error-report FOLDER [SCENE...]\n", stderr);
        return 2;
    }
    snprintf(path, sizeof path, "%s/index.html", argv[1]);
    struct output output;
    if (output_begin(&output, path, &error) == MR_OK) {
        FILE *out = output.file;
        const char *const *scenes = argc > 2 ? (const char *const *)argv + 2 : standard;
        size_t count = argc > 2 ? (size_t)argc - 2 : sizeof standard / sizeof standard[0];
        fputs(head, out);
        bool predictor = argc == 3 && strcmp(argv[2], "predictor") == 0;
        for (size_t i = 0; i < count && !predictor && error.status == MR_OK; i++)
            one_scene(out, scenes[i], &error);
        if (argc == 2 && error.status == MR_OK)
            write_engines(out, "host/landing_series/series/standard.json", &error);
        if ((argc == 2 || predictor) && error.status == MR_OK)
            write_predictor(out, &error);
        fputs("</body></html>\n", out);
        output_end(&output, &error);
    }
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "error-report: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
