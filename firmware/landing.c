#include "firmware/landing.h"

#include <string.h>

#include "common/block.h"
#include "common/wire.h"

#define S_PER_TICK (1.0 / 84.0e6)

static void change(struct landing *landing, enum landing_state state, enum landing_cause cause, uint32_t block)
{
    landing->state = state;
    landing->cause = cause;
    landing->changed_block = block;
}

void landing_start(struct landing *landing)
{
    memset(landing, 0, sizeof *landing);
    mr_staircase_init(&landing->staircase);
}

enum mr_status landing_arm(struct landing *landing, uint16_t number, uint32_t block)
{
    if (landing->state != LANDING_IDLE && landing->state != LANDING_DONE)
        return MR_NOT_NOW;
    landing->number = number ? number : (uint16_t)(landing->number + 1);
    landing->edges = 0;
    landing->resolved = 0;
    landing->opened = 0;
    landing->gates = 0;
    landing->gates_on_track = 0;
    landing->motion_known = false;
    landing->summary_known = false;
    change(landing, LANDING_ARMED, LANDING_BY_COMMAND, block);
    return MR_OK;
}

void landing_disarm(struct landing *landing, uint32_t block)
{
    change(landing, LANDING_IDLE, LANDING_BY_COMMAND, block);
}

bool landing_recording(const struct landing *landing)
{
    return landing->state == LANDING_ARMED || landing->state == LANDING_LANDING ||
           landing->state == LANDING_SETTLING;
}

/* False: an edge too many or too late, ignored. */
static bool take_edge(struct landing *landing, uint32_t tick, uint32_t block)
{
    if (landing->edges == LANDING_EDGES ||
        (landing->edges && block - landing->first_block >= LANDING_LIMIT_BLOCKS))
        return false;
    landing->edge[landing->edges++] = (struct landing_edge){.tick = tick, .step_codes = MR_NAN};
    if (landing->edges == 1)
        landing->first_block = block;
    landing->last_edge_block = block;
    return true;
}

static void add_gate(struct landing *landing, const struct landing_edge *edge)
{
    uint32_t since_first = edge->tick - landing->edge[0].tick;
    landing->gate[landing->gates++] = (struct mr_gate){
        .t_s = (double)since_first * S_PER_TICK,
        .station_ft = (double)config.gate[edge->position - 1].station_ft,
    };
    /* Braking begins at touchdown: gates on the track would bend the parabola, so two beyond it replace them. */
    if (config.gate[edge->position - 1].station_ft < config.touchdown_ft)
        landing->gates_on_track = landing->gates;
    unsigned skip = landing->gates >= landing->gates_on_track + 2 ? landing->gates_on_track : 0;
    landing->motion_known = mr_gates_now(landing->gate + skip, landing->gates - skip,
                                         (double)config.switch_error_ft, &landing->motion) == MR_OK;
}

/* Names the edges whose levels on both sides are known by now. Returns how many were settled, named or not. */
static unsigned resolve_edges(struct landing *landing)
{
    uint16_t steps_codes[CONFIG_SWITCHES];
    unsigned before = landing->resolved;

    for (unsigned i = 0; i < CONFIG_SWITCHES; i++)
        steps_codes[i] = config.gate[i].step_codes;
    while (landing->resolved < landing->edges) {
        struct landing_edge *edge = &landing->edge[landing->resolved];
        enum mr_status status = mr_staircase_step(&landing->staircase, edge->tick, &edge->step_codes);
        if (status == MR_TOO_FEW)
            break;
        if (status == MR_OK)
            edge->position =
                (uint8_t)mr_staircase_name(edge->step_codes, steps_codes, CONFIG_SWITCHES, landing->opened);
        landing->resolved++;
        if (edge->position) {
            landing->opened |= 1u << (edge->position - 1);
            add_gate(landing, edge);
        }
    }
    return landing->resolved - before;
}

/* Blocks from the last edge until the gear is taken to be at rest. */
static uint32_t blocks_to_rest(const struct landing *landing)
{
    double deceleration_ft_s2 = landing->motion.deceleration_ft_s2.value;
    if (landing->motion_known && deceleration_ft_s2 > 0.5) {
        double stop_s = landing->motion.speed_ft_s.value / deceleration_ft_s2;
        if (stop_s >= 0.0 && stop_s < 2.5)
            return (uint32_t)(stop_s * 1000.0) + LANDING_REST_BLOCKS;
    }
    return LANDING_NO_EDGE_BLOCKS;
}

static enum mr_status summarise(struct landing *landing)
{
    enum mr_status status = mr_gates_summarise(landing->gate, landing->gates, (double)config.touchdown_ft,
                                               (double)config.switch_error_ft, &landing->summary);
    landing->summary_known = status == MR_OK;
    return status;
}

struct landing_news landing_block(struct landing *landing, uint32_t index, uint32_t tick, float staircase_code,
                                  const uint32_t *edge_ticks, unsigned edge_count)
{
    struct landing_news news = {0};
    enum landing_state before = landing->state;

    mr_staircase_add(&landing->staircase, tick, staircase_code);
    if (!landing_recording(landing))
        return news;

    for (unsigned i = 0; i < edge_count; i++) {
        if (take_edge(landing, edge_ticks[i], index) && landing->state != LANDING_LANDING)
            change(landing, LANDING_LANDING, LANDING_BY_EDGE, index);
    }
    unsigned gates_before = landing->gates;
    news.edges = resolve_edges(landing);
    news.motion = landing->gates > gates_before && landing->motion_known;

    if (landing->state == LANDING_LANDING) {
        if (index - landing->last_edge_block >= blocks_to_rest(landing))
            change(landing, LANDING_SETTLING, LANDING_BY_STOP, index);
        else if (index - landing->first_block >= LANDING_LIMIT_BLOCKS)
            change(landing, LANDING_SETTLING, LANDING_BY_LIMIT, index);
        if (landing->state == LANDING_SETTLING) {
            news.no_fit = summarise(landing);
            news.summary = landing->summary_known;
        }
    } else if (landing->state == LANDING_SETTLING && index - landing->changed_block >= LANDING_SETTLE_BLOCKS) {
        change(landing, LANDING_DONE, LANDING_BY_SETTLED, index);
    }
    news.state = landing->state != before;
    return news;
}

struct landing_wheel landing_wheel_at(const struct landing *landing, uint32_t tick)
{
    struct landing_wheel wheel = {MR_NAN, MR_NAN, MR_NAN};
    if (!landing->gates)
        return wheel;
    const struct mr_gate *last = &landing->gate[landing->gates - 1];
    wheel.station_ft = (float)last->station_ft;
    if (!landing->motion_known)
        return wheel;

    double since_s = (double)(uint32_t)(tick - landing->edge[0].tick) * S_PER_TICK - last->t_s;
    double speed_ft_s = landing->motion.speed_ft_s.value;
    double deceleration_ft_s2 = landing->motion.deceleration_ft_s2.value;
    if (__builtin_isnan(deceleration_ft_s2))
        deceleration_ft_s2 = 0.0;
    if (deceleration_ft_s2 > 0.0 && since_s > speed_ft_s / deceleration_ft_s2)
        since_s = speed_ft_s / deceleration_ft_s2;
    wheel.station_ft =
        (float)(landing->motion.position_ft.value + (speed_ft_s - 0.5 * deceleration_ft_s2 * since_s) * since_s);
    wheel.speed_ft_s = (float)(speed_ft_s - deceleration_ft_s2 * since_s);
    wheel.deceleration_ft_s2 = (float)deceleration_ft_s2;
    return wheel;
}
