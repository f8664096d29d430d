/* matrig campaign FILE: a series of landings on an ensemble of runways. */
#include <stdio.h>
#include <stdlib.h>
#include "host/campaign/play.h"
#include "host/cli.h"
int campaign_command(int argc, char **argv, const struct cli *cli)
{
    struct error error = {0};
    struct campaign c;
    const char *words[1];
    bool all = false;
    const struct cli_option options[] = {{"--no-prune", NULL, &all}};
    (void)cli;
    if (cli_parse(argc, argv, options, 1, words, 1, 1, "FILE", &error) != MR_OK || campaign_load(&c, words[0], &error) != MR_OK)
        return cli_fail(&error);
    struct campaign_run *runs = calloc(c.seeds, sizeof *runs);
    campaign_ensemble(&c, 2, all, NULL, NULL, runs, &error);
    for (size_t i = 0; i < c.seeds; i++) {
        printf("seed %d buckled %d at %.1f %s %.0f ms\n", (int)runs[i].seed, runs[i].buckled, runs[i].buckle_ft, runs[i].error.text, runs[i].ms);
        for (size_t k = 0; k < runs[i].played; k++) {
            struct campaign_outcome *o = &runs[i].outcomes[k];
            printf("  L%zu stop %.1f a %.2f ratio %.2f ms %.0f %.0f peak %.3f reach %.1f zone %d %.1f-%.1f push %.1f pull %.1f tears %d waves %d rise %.4f crest %.1f sag %.1f  at %.1f %.1f %.1f\n", k + 1, o->stop_ft, o->deceleration_ft_s2, o->skip_ratio, o->ms_chain, o->ms_planar, o->peak_in, o->reach_ft, o->zone_mats, o->zone_from_ft, o->zone_to_ft, o->push_lb, o->pull_lb, o->tears, o->waves, o->rise_in, o->crest_deg, o->sag_deg, o->wave_ft[0], o->wave_ft[1], o->wave_ft[2]);
        }
    }
    return 0;
}
