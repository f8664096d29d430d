/* Chain study: the errors that the chain states against its true errors. README.md, "The
 * chain". */
#ifndef MATRIG_TESTS_STABILITY_CHAIN_STUDY_H
#define MATRIG_TESTS_STABILITY_CHAIN_STUDY_H

#include <stddef.h>
#include <stdint.h>

#define CHAIN_SEED   4711u
#define CHAIN_SCENES 5000u

struct chain_plan {
    size_t scenes, from, every, only, jobs, minutes;
    uint64_t seed;
    const char *folder;
};

/* Run the study, write FOLDER/chain.csv, print the summary. Exit status: 0 when the chain keeps to
 * its word, 1 when not, 3 when the study itself failed. */
int chain_study(const struct chain_plan *plan);

#endif
