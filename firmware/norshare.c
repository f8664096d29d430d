#include "firmware/norshare.h"

void norshare_poll(struct norshare *share, uint32_t now_ms, bool quiet)
{
    share->log->left_out = share->box->left_out;
    runwaystore_follow(share->store, share->box->state != BLACKBOX_MISSING);
    if (!runwaystore_busy(share->store, share->predict, share->slack_in) &&
        !slowlog_busy(share->log)) {
        blackbox_poll(share->box, now_ms);
        if (blackbox_idle(share->box) &&
            !runwaystore_begin(share->store, share->predict, quiet, now_ms))
            slowlog_begin(share->log, quiet);
    }
    share->box->waits = slowlog_erasing(share->log) || runwaystore_erasing(share->store);
}
