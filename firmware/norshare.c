#include "firmware/norshare.h"

void norshare_poll(struct blackbox *box, struct slowlog *log, uint32_t now_ms, bool quiet)
{
    log->left_out = box->left_out;
    if (!slowlog_busy(log)) {
        blackbox_poll(box, now_ms);
        if (blackbox_idle(box))
            slowlog_begin(log, quiet);
    }
    box->waits = slowlog_erasing(log);
}
