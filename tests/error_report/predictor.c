/* error-report FOLDER: the onboard predictor beside the solver that it is held against, error
 * against run time on the landings of the standard series, and what it costs on the board. Markdown
 * on stdout, FOLDER/predictor.svg.
 *
 * The onboard predictor (common/predictor.h) at several costs: error against the chain in double
 * precision at 25 us, and cycles on the board, over the five landings of the standard series (28
 * ft/s at 4, 4, 4.3, 4.6 ft/s2; 35.5 ft/s at 6.6 to 9.2).
 *
 * Two runways. `own`: openings and closing resistances are the ones that the predictor assumes,
 * each landing begins with the fine chain's openings, no transducers: what its step, its single
 * precision and its grouping do. `other`: a runway of other openings and resistances, of which it
 * knows a survey before the first landing and eight transducers at 40 to 110 ft; it carries its own
 * state: what a rig would see.
 *
 * A solver of the simulator (`staggered`, single passes in double precision) runs the same landings
 * on `own` at three steps: what the same time buys there.
 *
 * Cycles: what the predictor counts times the instructions measured on the emulated board
 * (predictor_cost.h). Units in, s. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/predictor.h"
#include "common/splitmix.h"
#include "host/base/monotonic_clock.h"
#include "host/base/plot.h"
#include "host/sim/sim.h"
#include "tests/error_report/predictor_cost.h"
#include "tests/host/predictor_case.h"

#define PREDICTOR_STUDY_LANDINGS 5
#define PREDICTOR_STUDY_VARIANTS 10
#define PREDICTOR_STUDY_SOLVERS  3

struct predictor_error {
    double rms_in, most_in; /* of u, over every tenth mat and all milliseconds */
};

struct predictor_run {
    struct predictor_error own, other;
    double updates, visits, blocks; /* of `other` */
    double cycles;                  /* of the landing */
    double ms;                      /* processor time of this computer, of `own` */
    double share;                   /* of 168 MHz over the worst second */
};

struct predictor_variant {
    const char *name;
    unsigned level; /* enum mr_predictor_level */
    double step_s;  /* of single mats */
    bool refused;   /* beyond the stability limit: no runs */
    struct predictor_run run[PREDICTOR_STUDY_LANDINGS];
};

/* Solver `staggered` on `own`. */
struct predictor_solver {
    double step_s;
    struct {
        struct predictor_error own;
        double ms; /* processor time of this computer */
    } run[PREDICTOR_STUDY_LANDINGS];
};

struct predictor_study {
    size_t count;
    struct predictor_variant variant[PREDICTOR_STUDY_VARIANTS];
    struct predictor_solver solver[PREDICTOR_STUDY_SOLVERS];
};

#define MATS            420
#define JOINTS          (MATS + 1)
#define MAT_FT          (2.0 / 7.0)
#define MAT_LB          0.466
#define G_FT_S2         32.174
#define THRUST_LB_PER_G (1300.0 / 12.0)
#define SLACK_FT        0.0025
#define TOUCHDOWN_FT    3.0
#define STATIONS        42 /* every tenth mat */
#define FINE_S          2.5e-5
#define NODE_S          1e-3
#define NODES_MAX       12000
#define AFTER_STOP_S    0.2
#define CLOCK_HZ        168e6
#define SEED            6u

static const struct {
    double speed_ft_s, from_ft_s2, to_ft_s2;
} landings[PREDICTOR_STUDY_LANDINGS] = {
    {28.0, 4.0, 4.0}, {28.0, 4.0, 4.0}, {28.0, 4.3, 4.3}, {28.0, 4.6, 4.6}, {35.5, 6.6, 9.2}};

static const struct {
    const char *name;
    enum mr_predictor_level level;
    double step_s;
} variants[] = {{"full, 0.05 ms", MR_PREDICTOR_FULL, 5e-5},
                {"full, 0.1 ms", MR_PREDICTOR_FULL, 1e-4},
                {"full, 0.125 ms", MR_PREDICTOR_FULL, 1.25e-4},
                {"full, 0.167 ms", MR_PREDICTOR_FULL, 1e-3 / 6.0},
                {"full, 0.185 ms", MR_PREDICTOR_FULL, 1.85e-4},
                {"full, 0.2 ms", MR_PREDICTOR_FULL, 2e-4},
                {"two in one", MR_PREDICTOR_TWO, 1e-3 / 6.0},
                {"four in one", MR_PREDICTOR_FOUR, 1e-3 / 6.0},
                {"plough", MR_PREDICTOR_PLOUGH, 1e-3 / 6.0}};

static const double solver_steps_s[PREDICTOR_STUDY_SOLVERS] = {5e-5, 1e-4, 1e-3 / 6.0};

/* The wheel by millisecond. */
struct gear {
    double x_ft[NODES_MAX], v_ft_s[NODES_MAX], a_ft_s2[NODES_MAX];
    size_t nodes; /* the stop is the last */
};

struct runway {
    double gap_ft[JOINTS], grit_lb[JOINTS];
    struct sim_result truth; /* of the landing under way; mat 10 k + 1 at station k */
};

/* What goes from landing to landing. */
struct bench {
    struct gear gear;
    struct runway own, other;
    double before_ft[JOINTS]; /* openings of `own` before the landing */
    struct mr_predictor_state kept[PREDICTOR_STUDY_VARIANTS];
    float survey_in[MR_SEGMENTS];
    struct mr_predictor predictor;
};

static void drive(struct gear *gear, size_t k)
{
    double x = TOUCHDOWN_FT, v = landings[k].speed_ft_s;
    for (gear->nodes = 0; gear->nodes < NODES_MAX; gear->nodes++) {
        double t_s = NODE_S * (double)gear->nodes;
        double a = landings[k].from_ft_s2 + (landings[k].to_ft_s2 - landings[k].from_ft_s2) *
                                                fmin(fmax((t_s - 1.2) / 2.4, 0.0), 1.0);
        gear->x_ft[gear->nodes] = x;
        gear->v_ft_s[gear->nodes] = v;
        gear->a_ft_s2[gear->nodes] = a;
        if (v <= 0.0) {
            gear->nodes++;
            return;
        }
        x += v * NODE_S - 0.5 * a * NODE_S * NODE_S;
        v = fmax(v - a * NODE_S, 0.0);
    }
}

/* The chain in double precision. `single`: one pass, as an answer that nothing checks. */
static enum mr_status run_chain(const struct runway *runway, const struct gear *gear, double dt_s,
                                bool single, struct sim_result *result, struct error *error)
{
    static struct sim_path_row rows[NODES_MAX / 5 + 2];
    static double stations_ft[STATIONS];
    struct sim_scene scene;
    size_t count = 0;
    for (size_t i = 0; i + 1 < gear->nodes; i += 5)
        rows[count++] = (struct sim_path_row){NODE_S * (double)i, gear->x_ft[i],
                                              THRUST_LB_PER_G * gear->a_ft_s2[i] / G_FT_S2};
    rows[count++] = (struct sim_path_row){NODE_S * (double)(gear->nodes - 1),
                                          gear->x_ft[gear->nodes - 1], 0.0};
    for (unsigned i = 0; i < STATIONS; i++)
        stations_ft[i] = 10.0 * i * MAT_FT;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = MATS;
    scene.length_ft = MAT_FT;
    scene.weight_lb = MAT_LB;
    scene.friction = 0.5;
    scene.kl_lb_ft = 2.9e5;
    scene.cl_lb_s_ft = 5.0;
    scene.slack_ft = SLACK_FT;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = AFTER_STOP_S;
    const struct sim_options options = {.dt_s = dt_s,
                                        .rtol = single ? 0.0 : 0.5,
                                        .is_single_pass = single,
                                        .sample_dt_s = NODE_S,
                                        .station_ft = stations_ft,
                                        .station_count = STATIONS};
    sim_scene_set_list(&scene.gap0_ft, runway->gap_ft, JOINTS);
    sim_scene_set_list(&scene.grit_lb, runway->grit_lb, JOINTS);
    sim_scene_set_path(&scene, rows, count);
    enum mr_status status = sim_run(&scene, &options, result, error);
    sim_scene_free(&scene);
    return status;
}

static enum mr_status find_truth(struct runway *runway, const struct gear *gear,
                                 struct error *error)
{
    if (run_chain(runway, gear, FINE_S, false, &runway->truth, error) != MR_OK)
        return error->status;
    for (int j = 0; j < JOINTS; j++)
        runway->gap_ft[j] = fmin(fmax(runway->truth.gap_ft[j + 1], 0.0), SLACK_FT);
    return MR_OK;
}

/* What the simulator's own solver does with coarser steps, from the openings of `before_ft`. */
static enum mr_status run_solver(struct predictor_solver *solver, const struct bench *bench,
                                 size_t landing, struct error *error)
{
    static struct runway runway;
    struct sim_result coarse = {0};
    const struct sim_result *truth = &bench->own.truth;
    struct predictor_error *off = &solver->run[landing].own;
    double sum = 0.0;
    memcpy(runway.gap_ft, bench->before_ft, sizeof runway.gap_ft);
    memcpy(runway.grit_lb, bench->own.grit_lb, sizeof runway.grit_lb);
    double begin_ms = processor_time_ms();
    if (run_chain(&runway, &bench->gear, solver->step_s, true, &coarse, error) == MR_OK) {
        solver->run[landing].ms = processor_time_ms() - begin_ms;
        size_t count = truth->sample_count * STATIONS;
        for (size_t i = 0; i < count; i++) {
            double off_in = 12.0 * (coarse.sample_u_ft[i] - truth->sample_u_ft[i]);
            sum += off_in * off_in;
            off->most_in = fmax(off->most_in, fabs(off_in));
        }
        off->rms_in = sqrt(sum / (double)count);
    }
    sim_result_free(&coarse);
    return error->status;
}

static struct mr_predictor_config rig(const struct predictor_variant *variant, bool transducers)
{
    struct mr_predictor_config config = case_rig();
    config.chain.step_s = (float)variant->step_s;
    config.updates_per_block = 1u << 20;
    config.level = (enum mr_predictor_level)variant->level;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = transducers ? 40.0f + 10.0f * (float)i : NAN;
    return config;
}

/* True displacement of a mat, inches, between the ones that are sampled. */
static double true_in(const struct sim_result *truth, size_t ms, double station_ft)
{
    double at = station_ft / (10.0 * MAT_FT);
    size_t k = (size_t)at, next = k + 1 < STATIONS ? k + 1 : k;
    const double *u_ft = truth->sample_u_ft + ms * STATIONS;
    return 12.0 * (u_ft[k] + (at - (double)k) * (u_ft[next] - u_ft[k]));
}

static void play(struct mr_predictor *p, const struct gear *gear, const struct sim_result *truth,
                 bool transducers, struct predictor_error *off, struct predictor_run *cost)
{
    static double cycles[NODES_MAX + 1000];
    double sum = 0.0;
    size_t blocks = truth->sample_count - 1;
    off->most_in = 0.0;
    cycles[0] = 0.0;
    double begin_ms = processor_time_ms();
    mr_predictor_arm(p);
    for (size_t ms = 0; ms < blocks; ms++) {
        size_t at = ms < gear->nodes ? ms : gear->nodes - 1;
        struct mr_predictor_input input = {.wheel_ft = (float)gear->x_ft[at],
                                           .speed_ft_s = (float)gear->v_ft_s[at],
                                           .deceleration_ft_s2 = (float)gear->a_ft_s2[at],
                                           .is_braking_known = true,
                                           .is_on_runway = true};
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            input.displacement_in[i] = transducers ? (float)true_in(truth, ms, 40.0 + 10.0 * i)
                                                   : NAN;
        mr_predictor_on_block(p, &input);
        cycles[ms + 1] = PREDICTOR_CYCLES((double)p->updates, (double)p->examined_joints,
                                          (double)(ms + 1));
        for (unsigned i = 0; i < STATIONS; i++) {
            double off_in = 12.0 * ((double)mr_chain_displacement_ft(&p->chain, 10u * i + 1u) -
                                    truth->sample_u_ft[(ms + 1) * STATIONS + i]);
            sum += off_in * off_in;
            off->most_in = fmax(off->most_in, fabs(off_in));
        }
    }
    cost->ms = processor_time_ms() - begin_ms; /* the comparison is a millisecond of it */
    off->rms_in = sqrt(sum / (double)(blocks * STATIONS));
    cost->updates = p->updates;
    cost->visits = p->examined_joints;
    cost->blocks = (double)blocks;
    cost->cycles = cycles[blocks];
    cost->share = 0.0;
    for (size_t ms = 1000; ms <= blocks; ms++)
        cost->share = fmax(cost->share, (cycles[ms] - cycles[ms - 1000]) / CLOCK_HZ);
}

static void play_both(struct bench *bench, struct predictor_variant *variant,
                      struct mr_predictor_state *kept, size_t landing)
{
    struct mr_predictor *p = &bench->predictor;
    struct mr_predictor_config config = rig(variant, false);
    struct predictor_run *run = &variant->run[landing];
    static struct mr_predictor_state state;
    (void)mr_predictor_start(p, &config);
    mr_predictor_save(p, &state);
    for (int j = 0; j < JOINTS; j++)
        state.gap_counts[j] = (uint16_t)(bench->before_ft[j] * 1.2e6 + 0.5);
    (void)mr_predictor_load(p, &state);
    play(p, &bench->gear, &bench->own.truth, false, &run->own, run);
    double own_ms = run->ms;
    config = rig(variant, true);
    (void)mr_predictor_start(p, &config);
    if (landing == 0)
        mr_predictor_set_survey(p, bench->survey_in);
    else
        (void)mr_predictor_load(p, kept);
    play(p, &bench->gear, &bench->other.truth, true, &run->other, run);
    run->ms = own_ms;
    mr_predictor_end_landing(p);
    mr_predictor_save(p, kept);
}

/* Variants, and which of them the predictor refuses; the runways as laid. */
static void prepare(struct predictor_study *study, struct bench *bench)
{
    uint64_t state = SEED;
    struct mr_predictor_config config;
    *study = (struct predictor_study){.count = sizeof variants / sizeof variants[0]};
    for (size_t i = 0; i < study->count; i++) {
        struct predictor_variant *variant = &study->variant[i];
        *variant = (struct predictor_variant){
            .name = variants[i].name, .level = variants[i].level, .step_s = variants[i].step_s};
        config = rig(variant, false);
        variant->refused = mr_predictor_start(&bench->predictor, &config) != MR_OK;
    }
    config = rig(&study->variant[0], false);
    (void)mr_predictor_start(&bench->predictor, &config);
    for (int j = 0; j < JOINTS; j++) {
        bench->own.gap_ft[j] = (double)bench->predictor.gap_ft[j];
        bench->own.grit_lb[j] = (double)bench->predictor.chain.grit_lb[j + 1];
        bench->other.gap_ft[j] = fmin(0.036 / 12.0 * mr_splitmix64_uniform(&state), SLACK_FT);
        bench->other.grit_lb[j] = 20.0 * mr_splitmix64_uniform(&state);
    }
    for (unsigned j = 0; j < MR_SEGMENTS * MR_MATS_PER_SEGMENT; j++)
        bench->survey_in[j / MR_MATS_PER_SEGMENT] += (float)(12.0 * bench->other.gap_ft[j]);
}

/* MR_OK, or what the fine chain says. Takes some seconds. */
static enum mr_status predictor_study_run(struct predictor_study *study, struct error *error)
{
    struct bench *bench = calloc(1, sizeof *bench);
    enum mr_status status = MR_OK;
    if (!bench)
        return error_set(error, MR_IO, "out of memory");
    prepare(study, bench);
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS && status == MR_OK; k++) {
        drive(&bench->gear, k);
        memcpy(bench->before_ft, bench->own.gap_ft, sizeof bench->before_ft);
        status = find_truth(&bench->own, &bench->gear, error);
        if (status != MR_OK)
            break;
        status = find_truth(&bench->other, &bench->gear, error);
        for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS && status == MR_OK; i++) {
            study->solver[i].step_s = solver_steps_s[i];
            status = run_solver(&study->solver[i], bench, k, error);
        }
        for (size_t i = 0; i < study->count && status == MR_OK; i++) {
            if (!study->variant[i].refused)
                play_both(bench, &study->variant[i], &bench->kept[i], k);
        }
        sim_result_free(&bench->own.truth);
        if (status == MR_OK)
            sim_result_free(&bench->other.truth);
    }
    free(bench);
    return status;
}

/* --- the report --- */

#define CLOCK_KHZ 168e3

/* A model at one cost, over all landings. */
struct cost {
    double ms, board_ms, own_in, most_in, other_in, share_percent; /* NaN: it has none */
};

static struct cost of_variant(const struct predictor_variant *variant)
{
    struct cost cost = {0};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        const struct predictor_run *run = &variant->run[k];
        cost.ms += run->ms / PREDICTOR_STUDY_LANDINGS;
        cost.board_ms += run->cycles / CLOCK_KHZ / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += run->own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.other_in += run->other.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, run->own.most_in);
        cost.share_percent = fmax(cost.share_percent, 100.0 * run->share);
    }
    return cost;
}

static struct cost of_solver(const struct predictor_solver *solver)
{
    struct cost cost = {
        .board_ms = (double)NAN, .other_in = (double)NAN, .share_percent = (double)NAN};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        cost.ms += solver->run[k].ms / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += solver->run[k].own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, solver->run[k].own.most_in);
    }
    return cost;
}

static void row(const char *model, const char *name, const struct cost *cost)
{
    printf("| %s | %s | %.1f | %.0f | %.4f | %.3f | %.4f | %.1f |\n", model, name, cost->ms,
           cost->board_ms, cost->own_in, cost->most_in, cost->other_in, cost->share_percent);
}

static void draw_panel(struct plot *plot, const struct predictor_study *study, bool own)
{
    plot_begin_panel(
        plot, own ? "the runway it assumes" : "another runway: survey, eight transducers",
        (struct plot_axis){.label = "million cycles on the board", .is_logarithmic = true},
        (struct plot_axis){.label = "rms error of u (in)", .is_logarithmic = true});
    for (unsigned k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        double x[PREDICTOR_STUDY_VARIANTS], y[PREDICTOR_STUDY_VARIANTS];
        char key[24];
        size_t count = 0;
        for (size_t i = 0; i < study->count; i++) {
            const struct predictor_run *run = &study->variant[i].run[k];
            if (study->variant[i].refused)
                continue;
            x[count] = run->cycles / 1e6;
            y[count++] = own ? run->own.rms_in : run->other.rms_in;
        }
        snprintf(key, sizeof key, "landing %u", k + 1);
        plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE_POINTS,
                                                    .key = key,
                                                    .colour = k,
                                                    .shape = k,
                                                    .x = x,
                                                    .y = y,
                                                    .count = count});
    }
}

static enum mr_status write_predictor(const char *folder, struct error *error)
{
    static struct predictor_study study;
    char path[400];
    if (predictor_study_run(&study, error) != MR_OK)
        return error->status;
    printf("\n## The onboard predictor\n\nThe model that runs on the board while a landing is "
           "recorded (single precision, each millisecond as it comes), beside the chain's solver "
           "`staggered` (double precision, single passes): means of %d landings of the standard "
           "series, errors of the movement at every tenth mat and all milliseconds against the "
           "chain at 25 us. Both have the runway's true openings; \"another runway\" is one of "
           "which the predictor knows a survey and eight transducers. On the board: its cycles at "
           "168 MHz, and their share of the worst second of any landing.\n\n"
           "| model | step or level | ms a landing | ms on the board | rms error (in) | largest "
           "error (in) | rms, another runway (in) | of the worst second (%%) |\n"
           "|---|---|---|---|---|---|---|---|\n",
           PREDICTOR_STUDY_LANDINGS);
    for (size_t i = 0; i < study.count; i++) {
        struct cost cost = of_variant(&study.variant[i]);
        if (study.variant[i].refused)
            printf("| predictor | %s | refused: beyond the stability limit | | | | | |\n",
                   study.variant[i].name);
        else
            row("predictor", study.variant[i].name, &cost);
    }
    for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS; i++) {
        struct cost cost = of_solver(&study.solver[i]);
        char step[40];
        snprintf(step, sizeof step, "%.3g ms", 1e3 * study.solver[i].step_s);
        row("staggered", step, &cost);
    }
    struct plot *plot = plot_new("onboard predictor: error against the fine chain, by cost", 960,
                                 480, 2);
    draw_panel(plot, &study, true);
    draw_panel(plot, &study, false);
    snprintf(path, sizeof path, "%s/predictor.svg", folder);
    return plot_write(plot, path, error);
}

int main(int argc, char **argv)
{
    struct error error = {0};
    if (argc != 2) {
        fputs("usage: error-report FOLDER\n", stderr);
        return 2;
    }
    if (write_predictor(argv[1], &error) == MR_OK)
        return 0;
    fprintf(stderr, "error-report: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
