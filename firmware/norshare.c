#include "firmware/norshare.h"

void norshare_poll(struct norshare *share, uint32_t now_ms, bool quiet)
{
    runwaystore_follow(share->store, share->box->state != BLACKBOX_MISSING);
    if (!runwaystore_busy(share->store, share->predict, share->slack_in)) {
        blackbox_poll(share->box, now_ms);
        if (blackbox_idle(share->box))
            (void)runwaystore_begin(share->store, share->predict, quiet, now_ms);
    }
    share->box->waits = runwaystore_erasing(share->store);
}
