#include "host/live/live.h"

static void message(void *context, const struct collector_event *event)
{
    struct live *live = context;
    live_hub_message(live->hub, event);
}

static void record(void *context, const struct mr_block *block, uint64_t host_us)
{
    struct live *live = context;
    live_hub_record(live->hub, block, (int64_t)host_us);
}

enum mr_status live_open(struct live *live, const char *where, const struct live_source *source,
                         struct error *error)
{
    live->source = *source;
    live->listener = (struct collector_listener){message, record, live};
    enum mr_status status = live_hub_open(&live->source, &live->hub, error);
    return status == MR_OK ? live_server_open(where, live->hub, &live->server, error) : status;
}

void live_close(struct live *live)
{
    live_server_close(live->server);
    live_hub_close(live->hub);
    live->server = NULL;
    live->hub = NULL;
}

void live_turn(struct live *live, const struct collector *collector)
{
    struct collector_progress progress;
    if (!live->hub)
        return;
    collector_progress(collector, &progress);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        live_hub_counts(live->hub, (enum link_kind)kind, &progress.counts[kind]);
    live_hub_strangers(live->hub, progress.strangers[LINK_CAN]);
    live_hub_turn(live->hub);
}

bool live_take_order(struct live *live, struct mr_command *command)
{
    return live->hub && live_hub_take_order(live->hub, command);
}
