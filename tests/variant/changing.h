/* Every 50 blocks another set of channels is fitted, bands or none: scans, transfers and the
 * converters' order have to follow without a sample in the wrong place. The loop of firmware/main.c
 * calls what stands here for app_poll. */
#include "firmware/app.h"
#include "firmware/config.h"

#define CHANGING_BLOCKS 50u
#define CHANGING_HASH   2654435761u /* 2^32 over the golden ratio: its bits are as good as drawn */

static void fit_others(struct app *app)
{
    static uint32_t done;
    if (app->next_index / CHANGING_BLOCKS == done)
        return;
    done = app->next_index / CHANGING_BLOCKS;
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++) {
        bool drawn = done * CHANGING_HASH >> (31 - c) & 1u;
        unsigned kind = c < MR_TRANSDUCERS ? MR_KIND_DISPLACEMENT
                      : done % 2           ? MR_KIND_TENSION
                                           : MR_KIND_NONE;
        config.channel[c].kind = (uint8_t)(drawn ? kind : MR_KIND_NONE);
    }
    app_apply_configuration(app);
}

static bool poll_and_fit_others(struct app *app)
{
    bool progress = app_poll(app);
    fit_others(app);
    return progress;
}

#define app_poll poll_and_fit_others
