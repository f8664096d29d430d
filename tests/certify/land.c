/* land: the landings of series.def as files for the emulated board.
 *
 *   land FOLDER   NAME-N.run, with lines "truth event_s S" and "truth most_mats N": when the wheel
 *                 first comes to a zone of 50 mats, in the run's time (-1: it does not), and the
 *                 longest zone that it comes to; NAME.set: the configuration's fields that are
 *                 others in it. A line each on stdout: NAME N event_s most_mats.
 *
 * No predictor of common/ is in it. Exit: 0; 2 usage; 3 a file; 5 a simulation that failed. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/sim.h"
#include "tests/board/truth_run.h"
#include "tests/score/score.h"

#define ARM_S         0.6
#define REST_S        0.9 /* after the stop: the board waits 0.5 s */
#define STORE_S       1.2 /* then it keeps the runway */
#define FIRST_STATION 4   /* transducer 1, in tens of feet */
#define LANDINGS_MOST 8

/* The rig of host/landing_series/series/rig.json; brake as in tests/runs: 50 ms to take hold. */
#define RIG                                                                                      \
    "\"model\": \"chain\", \"N\": 420, \"L\": 0.2857142857142857, \"W\": 0.466, \"KL\": 2.9e5, " \
    "\"CL\": 5, \"slack\": "                                                                     \
    "0.0025, \"left\": \"fixed\", \"right\": \"fixed\", \"friction\": \"stick\", \"v0\": 0"
#define G_FT_S2       32.174
#define THRUST_LB     (1300.0 / 12.0)
#define STEP_S        2.5e-5
#define NODE_S        1e-3
#define LEAD_S        0.4
#define TOUCHDOWN_FT  3.0
#define ONSET_S       0.05
#define GRIT_MOST_LB  20.0
#define GAP_MOST_IN   0.036
#define SLACK_IN      0.030
#define LOOK_MOST_FT  118.0
#define SWITCH_OFF_FT (0.02 / 12.0)

struct braked {
    double speed_ft_s, deceleration_ft_s2;
};

static struct syn_run run;
static struct score_truth truth;
static struct sim_path_row path[SCORE_ROWS_MAX];

/* ---- a landing of RIG.md's series ---- */

static size_t roll(const struct braked *braked, struct score_landing *landing, uint64_t *state)
{
    double at_ft = TOUCHDOWN_FT - LEAD_S * braked->speed_ft_s, v_ft_s = braked->speed_ft_s,
           switch_ft[SCORE_SWITCHES];
    size_t rows = 0;
    unsigned next = 0;
    for (unsigned i = 0; i < SCORE_SWITCHES; i++)
        switch_ft[i] = -2.5 + 5.0 * i + SWITCH_OFF_FT * (2.0 * score_uniform(state) - 1.0);
    landing->speed_ft_s = braked->speed_ft_s;
    landing->touchdown_s = LEAD_S;
    for (unsigned k = 0; v_ft_s > 0.0; k++) {
        double t_s = NODE_S * k, held = fmin(fmax((t_s - LEAD_S) / ONSET_S, 0.0), 1.0),
               a_ft_s2 = held * braked->deceleration_ft_s2;
        if (k % SCORE_LOOK_MS == 0 && landing->looks < SCORE_LOOKS_MAX && at_ft < LOOK_MOST_FT) {
            landing->wheel_ft[landing->looks] = (float)at_ft;
            landing->speed_at_ft_s[landing->looks++] = (float)v_ft_s;
        }
        /* from 0 on, or the run, and with it its samples, would begin where the runway does */
        if (k == 0 || (k % 5 == 0 && at_ft > 0.0 && at_ft < SCORE_MATS * SCORE_MAT_FT))
            path[rows++] = (struct sim_path_row){t_s, at_ft, THRUST_LB * a_ft_s2 / G_FT_S2};
        double to_ft = at_ft + v_ft_s * NODE_S - 0.5 * a_ft_s2 * NODE_S * NODE_S;
        for (; next < SCORE_SWITCHES && switch_ft[next] <= to_ft; next++) {
            if (switch_ft[next] < at_ft)
                continue;
            landing->edge_s[landing->edges] =
                (float)(t_s + NODE_S * (switch_ft[next] - at_ft) / (to_ft - at_ft));
            landing->edge_ft[landing->edges++] = (float)(-2.5 + 5.0 * next);
        }
        at_ft = to_ft;
        v_ft_s -= a_ft_s2 * NODE_S;
        landing->stop_s = t_s + NODE_S;
        landing->stop_ft = at_ft;
    }
    path[rows++] = (struct sim_path_row){landing->stop_s, at_ft, 0.0};
    return rows;
}

static bool parse(struct sim_scene *scene, const char *keys, struct error *error)
{
    char text[1000], *at;
    snprintf(text, sizeof text, "{" RIG "%s%s, \"f\": 0.5}", keys[0] ? ", " : "", keys);
    if (strstr(keys, "'f'")) /* its own */
        snprintf(text, sizeof text, "{" RIG ", %s}", keys);
    for (at = text; (at = strchr(at, '\'')); at++)
        *at = '"';
    return sim_scene_parse(scene, "series.def", text, strlen(text), error) == MR_OK;
}

/* What it left behind, into the landing; and its gaps into `gap_ft`, for the next one. */
static void take(const struct sim_result *result, struct score_landing *landing, double *gap_ft)
{
    landing->rows = result->sample_count < SCORE_ROWS_MAX ? (uint32_t)result->sample_count
                                                          : SCORE_ROWS_MAX;
    for (unsigned k = 0; k < landing->rows; k++) {
        for (unsigned i = 0; i < SCORE_STATIONS; i++)
            landing->u_in[k][i] = (float)(12.0 * result->sample_u_ft[k * SCORE_STATIONS + i]);
    }
    for (unsigned k = 0; k < landing->looks && k < result->output_count; k++) {
        const double *u_ft = result->outputs[k].u_ft;
        for (int j = 1; j <= SCORE_JOINTS; j++) {
            double opening_ft = gap_ft[j - 1] + (j <= SCORE_MATS ? u_ft[j] : 0.0) -
                                (j > 1 ? u_ft[j - 1] : 0.0);
            landing->gap_counts[k][j - 1] = (uint16_t)(fmax(0.0, opening_ft) * 12e5 + 0.5);
        }
    }
    for (int j = 1; j <= SCORE_JOINTS; j++)
        gap_ft[j - 1] = fmin(fmax(result->gap_ft[j], 0.0), SLACK_IN / 12.0);
}

static bool land(const char *name, const char *keys, const struct braked *braked,
                 const double *grit_lb, double *gap_ft, struct score_landing *landing,
                 uint64_t *state)
{
    static double stations_ft[SCORE_STATIONS], looks_s[SCORE_LOOKS_MAX];
    struct error error = {0};
    struct sim_scene scene;
    struct sim_result result;
    size_t rows = roll(braked, landing, state);
    for (unsigned i = 0; i < landing->looks; i++)
        looks_s[i] = 1e-3 * SCORE_LOOK_MS * i;
    for (int i = 0; i < SCORE_STATIONS; i++)
        stations_ft[i] = 10.0 * (i + 1);
    for (int j = 0; j < SCORE_JOINTS; j++)
        landing->gap_in[j] = (float)(12.0 * gap_ft[j]);
    const struct sim_options options = {.dt_s = STEP_S,
                                        .rtol = 0.0,
                                        .sample_dt_s = 1e-3 * SCORE_ROW_MS,
                                        .station_ft = stations_ft,
                                        .station_count = SCORE_STATIONS,
                                        .is_single_pass = true};
    bool good = parse(&scene, keys, &error);
    sim_scene_set_list(&scene.gap0_ft, gap_ft, SCORE_JOINTS);
    sim_scene_set_list(&scene.grit_lb, grit_lb, SCORE_JOINTS);
    sim_scene_set_list(&scene.t_out_s, looks_s, landing->looks);
    sim_scene_set_path(&scene, path, rows);
    scene.t_dwell_s = 0.3;
    good = good && sim_run(&scene, &options, &result, &error) == MR_OK;
    if (good && result.start_s != 0.0)
        good = error_set(&error, MR_NUMERICS, "its samples begin at %g s", result.start_s) == MR_OK;
    if (!good) {
        fprintf(stderr, "land: %s, landing %u: %s\n", name, landing->number, error.text);
        return false;
    }
    take(&result, landing, gap_ft);
    sim_result_free(&result);
    sim_scene_free(&scene);
    return true;
}

/* ---- files ---- */

static bool write_run(const char *folder, const char *name, const struct score_landing *landing,
                      double touchdown_ft, uint64_t *state)
{
    char file[512];
    int16_t most_mats;
    double gap_in[SCORE_JOINTS], stop_s = TRUTH_BEGIN_S + landing->stop_s,
                                 event_s = score_event_s(landing, &most_mats);
    event_s = isnan(event_s) ? -1.0 : TRUTH_BEGIN_S + event_s;
    for (unsigned j = 0; j < SCORE_JOINTS; j++)
        gap_in[j] = (double)landing->gap_in[j];
    syn_run_clear(&run);
    syn_run_add(&run, "matrig-run 1\nprovenance synthetic: series %s, by tests/certify/land.c\n",
                name);
    syn_run_add(&run, "landing %u\nduration_s %.3f\n", landing->number, stop_s + REST_S + STORE_S);
    syn_run_add(&run, "touchdown %.6f %.9f\n", touchdown_ft, TRUTH_BEGIN_S + landing->touchdown_s);
    syn_run_add(&run, "truth event_s %.3f\ntruth most_mats %d\n", event_s, most_mats);
    truth_run_switches(&run, landing);
    for (unsigned i = 0; i < TRUTH_TRANSDUCERS; i++)
        syn_run_add(&run, "transducer %u %.1f\n", i + 1, 10.0 * (FIRST_STATION + i));
    for (unsigned i = 0; i < SYN_SAMPLE_CHANNELS - TRUTH_TRANSDUCERS; i++)
        syn_run_add(&run, "gage %u %.1f %u\n", i + 1, 15.0 + 10.0 * (i % 7), i / 7 + 1);
    syn_run_numbers(&run, "gap_in", gap_in, SCORE_JOINTS);
    syn_run_numbers(&run, "gap_end_in", gap_in, SCORE_JOINTS);
    truth_run_survey(&run, landing, state);
    syn_run_add(&run, "command %.3f can arm %u\n", ARM_S, landing->number);
    syn_run_add(&run, "command %.3f can disarm\n", stop_s + REST_S);
    truth_run_samples(&run, landing, FIRST_STATION);
    snprintf(file, sizeof file, "%s/%s-%u.run", folder, name, landing->number);
    if (!syn_run_write(&run, file)) {
        fprintf(stderr, "land: %s: %s\n", file, strerror(errno));
        return false;
    }
    printf("%s %u %.3f %d\n", name, landing->number, event_s, most_mats);
    return true;
}

static bool write_settings(const char *folder, const char *name, double told_friction)
{
    char file[512];
    snprintf(file, sizeof file, "%s/%s.set", folder, name);
    FILE *out = fopen(file, "w");
    if (!out) {
        fprintf(stderr, "land: %s: %s; name a folder that can be written\n", file, strerror(errno));
        return false;
    }
    fprintf(out, "predict.friction = %.4f\n", told_friction);
    return fclose(out) == 0;
}

/* ---- a series ---- */

static int series(const char *folder, const char *name, const char *keys, double told_friction,
                  uint64_t seed, const struct braked *braked, size_t landings)
{
    static struct score_landing landing;
    static double gap_ft[SCORE_JOINTS], grit_lb[SCORE_JOINTS];
    uint64_t state = 0xce270000u + seed;
    for (int j = 0; j < SCORE_JOINTS; j++) {
        gap_ft[j] = fmin(GAP_MOST_IN * score_uniform(&state), SLACK_IN) / 12.0;
        grit_lb[j] = GRIT_MOST_LB * score_uniform(&state);
    }
    if (!write_settings(folder, name, told_friction))
        return 3;
    for (size_t i = 0; i < landings; i++) {
        memset(&landing, 0, sizeof landing);
        landing.number = (uint32_t)i + 1;
        landing.wave_s = NAN;
        if (!land(name, keys, &braked[i], grit_lb, gap_ft, &landing, &state))
            return 5;
        if (!write_run(folder, name, &landing, TOUCHDOWN_FT, &state))
            return 3;
    }
    return 0;
}

static int drawn(const char *folder, const char *name, enum score_kind kind, uint32_t number)
{
    uint64_t state = 0xce280000u + number;
    if (!score_truth_get(&truth, number, kind, folder))
        return 5;
    if (!write_settings(folder, name, truth.series.told_friction))
        return 3;
    for (uint32_t i = 0; i < truth.series.landings; i++) {
        if (!write_run(folder, name, &truth.landing[i], truth.series.touchdown_ft, &state))
            return 3;
    }
    return 0;
}

int main(int argc, char **argv)
{
    int status = 0;
    uint64_t seed = 0;
    if (argc != 2) {
        fprintf(stderr, "land: usage: land FOLDER\n");
        return 2;
    }
#define SERIES(name, keys, told_friction, ...)                             \
    seed++;                                                                \
    if (status == 0) {                                                     \
        const struct braked braked[] = {__VA_ARGS__};                      \
        status = series(argv[1], #name, keys, told_friction, seed, braked, \
                        sizeof braked / sizeof braked[0]);                 \
    }
#define DRAWN(name, kind, number) status = status ? status : drawn(argv[1], #name, kind, number);
#include "tests/certify/series.def"
    return status;
}
