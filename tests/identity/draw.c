/* draw: seeded landings to play to the emulated board, so that what it says can be held against
 * what the host computes.
 *
 *   draw FOLDER COUNT [SEED]   COUNT landings, from 1, of series drawn from the score's truth
 *                              (tests/score/truth.h): N.run, N.faults, and N.set where a series
 *                              begins: the configuration's fields that are others in it. A line
 *                              each on stdout: N, the landing's number in its series.
 *
 * Gear path, speed, braking, gaps, resistances, friction, stiffness and thrust are the truth's
 * draws; drawn here: what the board is told of them, its budget and level, which stations it sees,
 * whether it is surveyed again, and what fails. Exit: 0; 2 usage; 3 a file. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/risk.h"
#include "tests/board/truth_run.h"

#define FIRST_SERIES 7000u /* others than the score's */
#define ARM_S        0.6
#define REST_S       0.9 /* after the stop: the board waits 0.5 s */
#define STORE_S      1.2 /* then it keeps the runway */

static struct syn_run run;
static struct score_truth truth;

/* What the board has in a series. */
struct fitted {
    unsigned first; /* station of transducer 1, in tens of feet */
};

static double between(uint64_t *state, double low, double high)
{
    return low + (high - low) * score_uniform(state);
}

static FILE *create(const char *folder, unsigned number, const char *kind)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%u.%s", folder, number, kind);
    FILE *file = fopen(path, "w");
    if (!file)
        fprintf(stderr, "draw: %s: %s; name a folder that can be written\n", path, strerror(errno));
    return file;
}

static bool write_settings(const char *folder, unsigned number, struct fitted *fitted,
                           uint64_t *state)
{
    static const unsigned budget[] = {900, 900, 600, 300, 150};
    FILE *file = create(folder, number, "set");
    if (!file)
        return false;
    fitted->first = score_uniform(state) < 0.6 ? 4 : 1 + (unsigned)(3.0 * score_uniform(state));
    for (unsigned i = 0; i < TRUTH_TRANSDUCERS; i++)
        fprintf(file, "channel[%u].station_ft = %u\n", i + 1, 10 * (fitted->first + i));
    fprintf(file, "predict.friction = %.4f\n", truth.series.told_friction);
    fprintf(file, "predict.grit_lb = %.3f\n", 10.0 * exp(between(state, -0.5, 0.5)));
    fprintf(file, "predict.joint_stiffness_lb_ft = %.0f\n", 2.9e5 * exp(between(state, -0.4, 0.0)));
    fprintf(file, "predict.joint_damping_lb_s_ft = %.3f\n", between(state, 3.0, 5.0));
    fprintf(file, "predict.thrust_lb_per_g = %.2f\n", between(state, 90.0, 125.0));
    fprintf(file, "predict.deceleration_ft_s2 = %.2f\n", between(state, 3.0, 9.0));
    fprintf(file, "predict.bump_in = %.4f\n", between(state, 0.02, 0.08));
    fprintf(file, "predict.level = %u\n", (unsigned)fmax(0.0, between(state, -2.0, 3.0)));
    fprintf(file, "predict.updates_per_block = %u\n", budget[(unsigned)between(state, 0.0, 5.0)]);
    return fclose(file) == 0;
}

/* A third of the landings have nothing lost. */
static bool write_faults(const char *folder, unsigned number, double stop_s, uint64_t *state)
{
    static const char *const how[] = {"open", "high", "low"};
    FILE *file = create(folder, number, "faults");
    if (!file)
        return false;
    fputs("matrig-faults 1\n", file);
    double kind = score_uniform(state), at_s = TRUTH_BEGIN_S + between(state, 0.0, 0.8) * stop_s;
    unsigned lost = kind < 0.33 ? 0
                  : kind < 0.6  ? 1
                  : kind < 0.75 ? 3
                  : kind < 0.85 ? TRUTH_TRANSDUCERS
                                : 0;
    unsigned from = (unsigned)between(state, 0.0, TRUTH_TRANSDUCERS);
    for (unsigned i = 0; i < lost; i++)
        fprintf(file, "at %.3f transducer %u %s\n", at_s + 0.01 * i,
                (from + 3 * i) % TRUTH_TRANSDUCERS + 1, how[(from + i) % 3]);
    unsigned skipped = kind < 0.85 ? 0 : kind < 0.95 ? 2 : SCORE_SWITCHES;
    for (unsigned i = 0; i < skipped; i++)
        fprintf(file, "at 0.5 switch %u skip\n", skipped == SCORE_SWITCHES ? i + 1 : from + 5 + i);
    return fclose(file) == 0;
}

/* In two landings of three the board is given a plan, in most of these with a chart that may say
 * anything. As the board goes by the landings that it has seen a gear in, some charts are refused
 * as another runway's. */
static void add_chart(const struct score_landing *landing)
{
    uint64_t state = 0xc4a70000u + 16u * truth.series.number + landing->number;
    double kind = score_uniform(&state), off = fmax(0.5, 1.0 + 0.15 * score_normal(&state));
    struct mr_risk_plan plan;
    unsigned words = 0;
    if (kind < 0.33)
        return;
    mr_risk_plan_clear(&plan);
    plan.speed_ft_s = (float)(landing->speed_ft_s * between(&state, 0.95, 1.05));
    for (unsigned k = 0; k < SCORE_KNOTS; k++) {
        plan.plan_time_s[k] = landing->plan_time_s[k];
        plan.plan_deceleration_ft_s2[k] = landing->plan_deceleration_ft_s2[k] * (float)off;
    }
    for (unsigned r = 0; kind > 0.5 && r < MR_RISK_CHART_ROWS; r++) {
        plan.landing_count = (float)(landing->number - 1u);
        plan.chart_deceleration_ft_s2[r] = 3.0f + 1.5f * (float)r;
        plan.chart_log_odds[r] = (float)between(&state, -4.0, 4.0);
    }
    for (unsigned i = 0; i < MR_RISK_PLAN_ITEM_COUNT; i++) {
        float value = mr_risk_plan_get_item(&plan, i);
        int32_t bits;
        memcpy(&bits, &value, sizeof bits);
        if (!isnan(value))
            syn_run_add(&run, "command %.3f serial chart-word %u %" PRId32 "\n",
                        0.400 + 0.002 * words++, i, bits);
    }
    syn_run_add(&run, "command %.3f serial chart-take %" PRId32 "\n", 0.400 + 0.002 * words,
                (int32_t)mr_risk_plan_crc(&plan));
}

static bool write_run(const char *folder, unsigned number, const struct score_landing *landing,
                      const struct fitted *fitted, bool surveyed, uint64_t *state)
{
    char path[512];
    double gap_in[SCORE_JOINTS], stop_s = TRUTH_BEGIN_S + landing->stop_s;
    for (unsigned j = 0; j < SCORE_JOINTS; j++)
        gap_in[j] = (double)landing->gap_in[j];
    syn_run_clear(&run);
    syn_run_add(&run,
                "matrig-run 1\nprovenance synthetic: series %u, landing %u, drawn by "
                "tests/identity/draw.c\n",
                truth.series.number, landing->number);
    syn_run_add(&run, "landing %u\nduration_s %.3f\n", landing->number, stop_s + REST_S + STORE_S);
    syn_run_add(&run, "touchdown %.6f %.9f\n", truth.series.touchdown_ft,
                TRUTH_BEGIN_S + landing->touchdown_s);
    truth_run_switches(&run, landing);
    for (unsigned i = 0; i < TRUTH_TRANSDUCERS; i++)
        syn_run_add(&run, "transducer %u %.1f\n", i + 1, 10.0 * (fitted->first + i));
    for (unsigned i = 0; i < SYN_SAMPLE_CHANNELS - TRUTH_TRANSDUCERS; i++)
        syn_run_add(&run, "gage %u %.1f %u\n", i + 1, 15.0 + 10.0 * (i % 7), i / 7 + 1);
    syn_run_numbers(&run, "gap_in", gap_in, SCORE_JOINTS);
    syn_run_numbers(&run, "gap_end_in", gap_in, SCORE_JOINTS);
    if (surveyed)
        truth_run_survey(&run, landing, state);
    add_chart(landing);
    syn_run_add(&run, "command %.3f can arm %u\n", ARM_S, landing->number);
    syn_run_add(&run, "command %.3f can disarm\n", stop_s + REST_S);
    truth_run_samples(&run, landing, fitted->first);
    snprintf(path, sizeof path, "%s/%u.run", folder, number);
    if (!syn_run_write(&run, path)) {
        fprintf(stderr, "draw: %s: %s\n", path, strerror(errno));
        return false;
    }
    return true;
}

/* As many landings of a series as are still wanted. */
static bool draw_series(const char *folder, unsigned *made, unsigned count, uint64_t *state)
{
    struct fitted fitted;
    if (!write_settings(folder, *made + 1, &fitted, state))
        return false;
    for (unsigned i = 0; i < truth.series.landings && *made < count; i++) {
        const struct score_landing *landing = &truth.landing[i];
        bool surveyed = score_uniform(state) < (i == 0 ? 0.8 : 0.4);
        ++*made;
        if (!write_faults(folder, *made, landing->stop_s, state) ||
            !write_run(folder, *made, landing, &fitted, surveyed, state))
            return false;
        printf("%u %u\n", *made, landing->number);
    }
    return true;
}

int main(int argc, char **argv)
{
    char *end = "";
    unsigned long count = argc >= 3 ? strtoul(argv[2], &end, 10) : 0;
    unsigned long seed = argc == 4 && *end == '\0' ? strtoul(argv[3], &end, 10) : 1;
    unsigned made = 0;
    if (argc < 3 || argc > 4 || *end != '\0' || count < 1 || count > 1000 || seed > 100000) {
        fprintf(stderr, "draw: usage: draw FOLDER COUNT [SEED], COUNT 1 to 1000\n");
        return 2;
    }
    uint64_t state = seed;
    for (uint32_t number = FIRST_SERIES + 1000u * (uint32_t)seed; made < count; number++) {
        if (!score_truth_get(&truth, number, false, argv[1]) ||
            !draw_series(argv[1], &made, (unsigned)count, &state))
            return 3;
    }
    return 0;
}
