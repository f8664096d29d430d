/* matrig error --predictor: the onboard predictor's error against its cost. */
#include <stdio.h>

#include "host/study/error_predictor.h"
#include "host/base/output.h"
#include "host/base/progress.h"
#include "host/report/plot_predictor.h"
#include "host/sim/check/predictor_cost.h"

static json_t *error_json(const struct predictor_error *error)
{
    return json_pack("{s:o,s:o}", "rms_in", cli_json_number(error->rms_in, 4), "most_in",
                     cli_json_number(error->most_in, 4));
}

static json_t *variant_json(const struct predictor_variant *variant)
{
    json_t *runs = json_array();
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS && !variant->refused; k++) {
        const struct predictor_run *run = &variant->run[k];
        json_array_append_new(
            runs,
            json_pack("{s:i,s:o,s:o,s:I,s:I,s:I,s:I,s:o,s:o}", "landing", (int)k + 1, "own_runway",
                      error_json(&run->own), "other_runway", error_json(&run->other), "mat_updates",
                      (json_int_t)run->updates, "joints_looked_at", (json_int_t)run->visits,
                      "blocks", (json_int_t)run->blocks, "instructions",
                      (json_int_t)PREDICTOR_INSTRUCTIONS(run->updates, run->visits, run->blocks),
                      "cycles", cli_json_number(run->cycles, 6), "share_of_worst_second",
                      cli_json_number(run->share, 4)));
    }
    return json_pack("{s:s,s:o,s:b,s:o}", "variant", variant->name, "step_s",
                     cli_json_number(variant->step_s, 6), "refused", variant->refused, "landings",
                     runs);
}

static json_t *study_json(const struct predictor_study *study)
{
    json_t *variants = json_array(), *peaks = json_array();
    for (size_t i = 0; i < study->count; i++)
        json_array_append_new(variants, variant_json(&study->variant[i]));
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++)
        json_array_append_new(peaks, cli_json_number(study->peak_in[k], 4));
    return json_pack("{s:s,s:o,s:o,s:o,s:o,s:o}", "reference", "chain, double precision, 25 us",
                     "step_limit_s", cli_json_number(study->step_limit_s, 6),
                     "instructions_per_update", cli_json_number(PREDICTOR_PER_UPDATE, 6),
                     "limit_share", cli_json_number(PREDICTOR_STUDY_LIMIT, 3), "peak_in", peaks,
                     "variants", variants);
}

static void print_variant(const struct predictor_variant *variant)
{
    if (variant->refused) {
        printf("  %-15s refused: the step is beyond the stability limit\n", variant->name);
        return;
    }
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        const struct predictor_run *run = &variant->run[k];
        printf("  %-15s %7zu  %8.4f %8.3f  %8.3f %8.3f  %8.2f %8.1f %8.1f  %6.1f %%%s\n",
               k == 0 ? variant->name : "", k + 1, run->own.rms_in, run->own.most_in,
               run->other.rms_in, run->other.most_in, run->updates / 1e6,
               PREDICTOR_INSTRUCTIONS(run->updates, run->visits, run->blocks) / 1e6,
               run->cycles / 1e6, 100.0 * run->share,
               run->share > PREDICTOR_STUDY_LIMIT ? " over budget" : "");
    }
}

static void print_study(const struct predictor_study *study)
{
    puts("onboard predictor against the chain in double precision at 25 us, landings 1 to 5 of the "
         "standard series");
    printf("  largest movement, in: ");
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++)
        printf("%s%.2f", k ? ", " : "", study->peak_in[k]);
    printf("; stability limit of the step, with its margin: %.4f ms\n\n",
           1e3 * study->step_limit_s);
    printf("  %-15s %7s  %17s  %17s  %8s %8s %8s  %s\n", "", "", "own runway, u in",
           "another, u in", "million", "million", "million", "worst second");
    printf("  %-15s %7s  %8s %8s  %8s %8s  %8s %8s %8s  %s\n", "variant", "landing", "rms", "most",
           "rms", "most", "updates", "instr.", "cycles", "of 168 MHz");
    for (size_t i = 0; i < study->count; i++)
        print_variant(&study->variant[i]);
    printf("\n  own runway: the openings and resistances it assumes, no transducers; another: "
           "known by a survey before landing 1 and eight\n"
           "  transducers, its own state carried on. Instructions: %.0f a mat update, %.0f a joint "
           "looked at, %.0f a block (measured on the\n"
           "  emulated board); cycles: x 1.5, divisions and roots 14. On the board the budget of "
           "%.0f %% keeps a level from lasting beyond it\n",
           PREDICTOR_PER_UPDATE, PREDICTOR_PER_VISIT, PREDICTOR_PER_BLOCK,
           100.0 * PREDICTOR_STUDY_LIMIT);
}

int error_predictor(const char *plot, const struct cli *cli)
{
    static struct predictor_study study;
    struct error error = {0};
    struct progress underway;
    progress_begin(&underway, "error", "", cli->quiet);
    progress_at(&underway, "the predictor's variants on five landings");
    enum mr_status status = predictor_study_run(&study, &error);
    progress_end(&underway);
    if (status != MR_OK)
        return cli_fail(&error);
    if (plot) {
        struct output output;
        if (output_begin(&output, plot, &error) != MR_OK)
            return cli_fail(&error);
        plot_predictor_file(output.file, &study);
        if (output_end(&output, &error) != MR_OK)
            return cli_fail(&error);
    }
    if (cli->json)
        return cli_print_json(study_json(&study), 0);
    print_study(&study);
    return 0;
}
