/* A stranger on the CAN bus: orders of maintenance and inputs of replays as fast as the bus carries
 * them, through landing 5, to a board without its maintenance jumper; against the same landing
 * without him. */
#include "tests/hil/ear.h"

#define BEGIN_S   1.0 /* armed, at 0.8 s, over the CAN that he floods */
#define END_S     8.8
#define STRANGER  77 /* tag of his orders */
#define ORDERS    6u
#define FRAMES_MS 10u /* one is 0.13 ms on the bus */

static const uint8_t order[ORDERS] = {MR_COMMAND_BOOTROM,      MR_COMMAND_RESET,
                                      MR_COMMAND_CONFIG_APPLY, MR_COMMAND_BOX_FREE,
                                      MR_COMMAND_REPLAY,       MR_COMMAND_BACKLOG};

struct day {
    unsigned sent, answered, obeyed, unlike; /* his orders; answers with another reason */
    unsigned states, edges, backlogs, blocks, lost;
    double touchdown_ft_s;
    uint64_t cycles, resets; /* awake, from BEGIN_S on */
};

static struct ear *ear;
static struct day *today;

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct mr_ack ack;
    struct mr_touchdown touchdown;
    ear_can(ctx, t_ps, frame);
    if (frame->id == MR_ID_TOUCHDOWN) {
        mr_touchdown_get(&touchdown, frame->data, frame->length);
        today->touchdown_ft_s = (double)touchdown.speed_ft_s;
    }
    if (frame->id != MR_ID_ACK || mr_ack_get(&ack, frame->data, frame->length) != MR_OK ||
        ack.tag != STRANGER)
        return;
    today->answered++;
    today->obeyed += ack.status == MR_OK;
    today->unlike += ack.status != MR_NOT_NOW && ack.status != MR_CABLE &&
                     ack.status != MR_JUMPER && ack.status != MR_REPLAY;
}

static void flood(uint64_t to_ps)
{
    struct mr_command command = {.tag = STRANGER, .argument = 9};
    while (hil_board_now_ps(ear->board) < to_ps) {
        for (unsigned i = 0; i < FRAMES_MS; i++) {
            struct hil_can_frame frame = {.id = MR_ID_COMMAND};
            command.code = order[today->sent % ORDERS];
            frame.length = (uint8_t)mr_command_put(&command, frame.data);
            if (hil_can_inject(&ear->board->mcu.can, &frame) == MR_OK)
                today->sent++;
        }
        bench_run(ear->board, hil_board_now_ps(ear->board) + HIL_MS_PS);
    }
}

static void live(struct day *day, bool stranger)
{
    struct hil_options options = ear_options();
    struct mr_health health;
    options.jumper = false;
    *(today = day) = (struct day){0};
    ear = ear_open(&options, 5);
    hil_board_set_callbacks(ear->board, &(struct hil_callbacks){ear, on_can, ear_serial});
    ear_until(ear, BEGIN_S);
    uint64_t asleep = hil_board_counters(ear->board)->asleep_cycles;
    if (stranger)
        flood((uint64_t)(END_S * 1e12));
    ear_until(ear, END_S);
    day->cycles = (uint64_t)((END_S - BEGIN_S) * 168e6) -
                  (hil_board_counters(ear->board)->asleep_cycles - asleep);
    mr_health_get(&health, ear->last[EAR_SERIAL][MR_ID_HEALTH], MR_MESSAGE_MAX);
    day->lost = health.blocks_lost;
    day->states = ear->heard[EAR_SERIAL][MR_ID_LANDING];
    day->edges = ear->heard[EAR_SERIAL][MR_ID_EDGE];
    day->backlogs = ear->heard[EAR_SERIAL][MR_ID_BACKLOG];
    day->blocks = ear->blocks;
    day->resets = hil_board_counters(ear->board)->resets;
    ear_close(ear);
}

TEST(a_stranger_is_not_obeyed_and_costs_no_block)
{
    struct day quiet, loud;
    live(&quiet, false);
    live(&loud, true);
    unsigned each = (unsigned)((loud.cycles - quiet.cycles) / loud.answered);
    printf("%u orders, %u answers, %u obeyed; %u cycles an answer\n", loud.sent, loud.answered,
           loud.obeyed, each);
    assert_true(loud.answered > 1000);
    assert_int_equal(loud.obeyed, 0);
    assert_int_equal(loud.unlike, 0);
    assert_int_equal(loud.resets, 0);
    assert_int_equal(loud.lost, 0);
    assert_int_equal(loud.backlogs, quiet.backlogs);
    assert_int_equal(loud.states, quiet.states);
    assert_int_equal(loud.edges, quiet.edges);
    assert_int_equal(loud.blocks, quiet.blocks);
    assert_true(loud.touchdown_ft_s == quiet.touchdown_ft_s);
    assert_in_range(each, 500, 5000); /* two links, and the black box */
}
