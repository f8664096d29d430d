/* From the decisive sample to the warning output: 30 ms at most. Landings on the emulated board,
 * armed with a runway that one landing more would not bear; the blocks it recorded go through the
 * same application on the host, whose predictor is asked after every block, not every tenth, and by
 * a search of the whole runway at once, not one spread over blocks, whether a warning is due. The
 * pin is looked at each 0.1 ms. */
#include <math.h>

#include "firmware/app.h"
#include "firmware/config.h"
#include "hil/board/board.h"
#include "tests/firmware/fake_board.h"
#include "tests/firmware/fake_nor.h"
#include "tests/hil/ear.h"

#define BLOCKS_MAX  20000u
#define EDGES_MAX   64u
#define LAST_SCAN_S (7.0 * 125e-6)
#define LIMIT_S     0.030

static struct flight {
    struct ear *ear;
    struct mr_block block[BLOCKS_MAX];
    unsigned blocks;
    uint32_t edge_tick[EDGES_MAX];
    unsigned edges;
    uint32_t armed_block;
    bool armed;
    float slack_in[MR_SEGMENTS];
    struct mr_deframer deframer;
} flight;

static struct app app;

static void take(const struct mr_frame *frame)
{
    struct mr_edge edge;
    struct mr_slack slack;
    struct mr_ack ack;
    if (frame->type == MR_ID_BLOCK && flight.blocks < BLOCKS_MAX)
        flight.blocks += mr_block_decode(&flight.block[flight.blocks], frame->payload,
                                         frame->length) == MR_OK;
    else if (frame->type == MR_ID_EDGE && flight.edges < EDGES_MAX &&
             mr_edge_get(&edge, frame->payload, frame->length) == MR_OK)
        flight.edge_tick[flight.edges++] = edge.tick;
    else if (frame->type == MR_ID_SLACK &&
             mr_slack_get(&slack, frame->payload, frame->length) == MR_OK)
        flight.slack_in[slack.segment] = slack.slack_in;
    else if (frame->type == MR_ID_ACK && mr_ack_get(&ack, frame->payload, frame->length) == MR_OK &&
             ack.code == MR_COMMAND_ARM && ack.status == MR_OK) {
        flight.armed = true;
        flight.armed_block = ack.block;
    }
}

static void on_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct mr_frame frame;
    ear_serial(ctx, t_ps, bytes, n);
    for (size_t i = 0; i < n; i++) {
        if (mr_deframer_push(&flight.deframer, bytes[i], &frame) == MR_OK)
            take(&frame);
    }
}

/* Would the wheel, by this block's state of the runway, have a zone before it that is warned of? */
static bool is_due(const struct mr_block *block)
{
    const struct mr_predictor *p = &app.predict.predictor;
    const struct mr_chain *chain = &p->chain;
    struct mr_zonescan scan;
    float mat_ft = p->config.chain.mat_length_ft * (float)chain->mats_per_group,
          end_ft = mat_ft * (float)chain->group_count;
    if (!(p->speed_ft_s > 0.0f) || !(p->wheel_ft >= 0.0f && p->wheel_ft < end_ft) ||
        !landing_can_warn(&app.landing, block->index))
        return false;
    float braking_ft_s2 = p->is_braking_known ? p->deceleration_ft_s2
                                              : 2.0f * p->config.deceleration_ft_s2;
    float stop_ft = fminf(p->wheel_ft + 0.5f * p->speed_ft_s * p->speed_ft_s / braking_ft_s2,
                          end_ft - 0.01f);
    unsigned place = (unsigned)(p->wheel_ft / mat_ft) + 1;
    mr_zonescan_begin(&scan, chain,
                      &(struct mr_zonescan_range){
                          .search_start_joint = (uint16_t)(place + 1),
                          .position = (uint16_t)place,
                          .last_position = (uint16_t)((unsigned)(stop_ft / mat_ft) + 1),
                          .grit_lb = chain->mats_per_group > 1u ? p->closing_lb : chain->grit_lb,
                          .push_lb = p->config.thrust_lb_per_g * p->deceleration_ft_s2 / 32.174f});
    while (!mr_zonescan_continue(&scan, chain, 10000)) {
    }
    return scan.result.future_groups * chain->mats_per_group >= MR_PREDICTOR_WARNING_MATS;
}

/* The first block that calls for a warning; UINT32_MAX: none does. */
static uint32_t decisive_block(void)
{
    struct board_can_frame *frame = &fake.received[0];
    fake_reset();
    fake_nor_reset();
    fake_nor.present = false;
    app_start(&app);
    memcpy(app.slack_in, flight.slack_in, sizeof app.slack_in);
    predict_set_survey(&app.predict, app.slack_in, 0);
    memcpy(fake.edge_tick, flight.edge_tick, sizeof flight.edge_tick);
    fake.edges = flight.edges;
    for (unsigned i = 0; i < flight.blocks; i++) {
        const struct mr_block *block = &flight.block[i];
        if (block->index == flight.armed_block) {
            struct mr_command command = {.code = MR_COMMAND_ARM};
            frame->id = MR_ID_COMMAND;
            frame->length = (uint8_t)mr_command_put(&command, frame->data);
            fake.received_count = 1;
        }
        fake.block = *block;
        fake.block_ready = true;
        assert_true(app_poll(&app));
        if (landing_is_recording(&app.landing) && is_due(block))
            return block->index;
    }
    return UINT32_MAX;
}

/* Physical time of a block's last scan. */
static double sampled_s(const struct hil_board *board, uint32_t index)
{
    const struct hil_tim *tim2 = &board->state.mcu.tim[HIL_TIM2];
    double zero_s = (double)hil_clock_ps_at_cycle(&board->core.state.clock, tim2->base_cycle) *
                        1e-12 -
                    (double)tim2->base_count / 84e6;
    return zero_s + 2352.0 / 84e6 + (double)index * 1e-3 + LAST_SCAN_S;
}

/* How long after the decisive sample the output warned; NaN: it did not. */
static double fly(unsigned landing, uint64_t seed, bool noise)
{
    struct hil_options options = ear_options();
    options.has_adc_noise = noise;
    options.noise_seed = seed;
    memset(&flight, 0, sizeof flight);
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        flight.slack_in[i] = NAN;
    mr_deframer_init(&flight.deframer);
    flight.ear = ear_open(&options, landing);
    struct hil_board *board = flight.ear->board;
    hil_board_set_callbacks(board, &(struct hil_callbacks){flight.ear, ear_can, on_serial});
    double warned_s = (double)NAN;
    double t_s = 0.1;
    ear_until(flight.ear, t_s);
    for (; t_s < flight.ear->run.duration_s && isnan(warned_s); t_s += 1e-4) {
        ear_until(flight.ear, t_s);
        if (isnan(warned_s) && !hil_board_pin_level(board, 4, 0))
            warned_s = t_s;
    }
    assert_true(flight.armed);
    uint32_t decisive = decisive_block();
    assert_int_equal(decisive == UINT32_MAX, isnan(warned_s));
    double late_s = warned_s - sampled_s(board, decisive);
    if (isnan(warned_s))
        print_message("# landing %u: no warning, and none was due\n", landing);
    else
        print_message("# landing %u, seed %u%s: warned %.1f ms after the decisive sample\n",
                      landing, (unsigned)seed, noise ? ", noise" : "", 1e3 * late_s);
    ear_close(flight.ear);
    return late_s;
}

TEST(the_output_warns_in_time)
{
    double worst_s = 0.0;
    for (unsigned i = 0; i < 3; i++) {
        double late_s = fly(5, 1 + i, i != 1);
        assert_true(late_s >= 0.0);
        worst_s = late_s > worst_s ? late_s : worst_s;
    }
    assert_true(worst_s <= LIMIT_S);
}

TEST(no_zone_no_warning)
{
    assert_true(isnan(fly(1, 1, false)));
}
