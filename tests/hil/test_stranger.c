/* A stranger on the CAN bus floods it through landing 5: orders of maintenance and inputs of
 * replays to a board without its maintenance jumper; then an operator's orders with guessed and
 * overheard proofs to a board with a key. Each against the same landing without him. */
#include "common/crc32.h"
#include "common/proof.h"
#include "common/splitmix.h"
#include "common/wire.h"
#include "tests/hil/ear.h"

#define BEGIN_S   1.0 /* armed, at 0.8 s, over the CAN that he floods */
#define END_S     8.8
#define STRANGER  77 /* tag of his orders */
#define ORDERS    6u
#define FRAMES_MS 10u /* one is 0.13 ms on the bus */

static const uint8_t order[ORDERS] = {MR_COMMAND_BOOTROM,      MR_COMMAND_RESET,
                                      MR_COMMAND_CONFIG_APPLY, MR_COMMAND_BOX_FREE,
                                      MR_COMMAND_REPLAY,       MR_COMMAND_BACKLOG};

/* What he may not order without the key; the landing is going on. */
static const uint8_t operators[ORDERS] = {MR_COMMAND_DISARM,        MR_COMMAND_ARM,
                                          MR_COMMAND_ZERO,          MR_COMMAND_SURVEY,
                                          MR_COMMAND_RUNWAY_FORGET, MR_COMMAND_CHART_FORGET};
static const uint8_t key[MR_KEY_BYTES] = "a key of the laboratory's own";
static uint8_t overheard[MR_PROOF_BYTES];

struct day {
    bool keyed;
    unsigned wrong;                          /* proofs that were looked at */
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
    if (today->keyed)
        today->unlike += ack.status != MR_PROOF && ack.status != MR_LOCKOUT;
    else
        today->unlike += ack.status != MR_NOT_NOW && ack.status != MR_CABLE &&
                         ack.status != MR_JUMPER && ack.status != MR_REPLAY;
}

static void put_frame(uint16_t id, const uint8_t *payload)
{
    struct hil_can_frame frame = {.id = id, .length = MR_MESSAGE_BYTES_MAX};
    memcpy(frame.data, payload, MR_MESSAGE_BYTES_MAX);
    if (hil_can_inject(&ear->board->mcu.can, &frame) == MR_OK)
        today->sent++;
}

/* A proof and its order, half of the bus each: drawn ones, and one that was overheard. */
static void flood_with_proofs(uint64_t to_ps)
{
    struct mr_command command = {.tag = STRANGER};
    uint64_t random = 1;
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    while (hil_board_now_ps(ear->board) < to_ps) {
        for (unsigned i = 0; i < FRAMES_MS / 2; i++) {
            uint64_t guess = mr_splitmix64(&random);
            put_frame(MR_ID_PROOF, i ? (const uint8_t *)&guess : overheard);
            command.code = operators[(today->sent + i) % ORDERS];
            mr_command_put(&command, payload);
            put_frame(MR_ID_COMMAND, payload);
        }
        bench_run(ear->board, hil_board_now_ps(ear->board) + HIL_PS_PER_MS);
    }
}

static void send(uint16_t id, const uint8_t *payload, size_t length)
{
    static uint16_t seq;
    uint8_t bytes[MR_FRAME_BYTES_MAX];
    assert_int_equal(hil_usart_inject(&ear->board->mcu.usart, bytes,
                                      mr_frame_encode(seq++, id, payload, length, bytes)),
                     MR_OK);
}

/* The key is set, and the board armed with it, both over serial. */
static void set_key_and_arm(void)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    const uint8_t *p = key, *uid = ear->last[EAR_SERIAL][MR_ID_BOARD_UID];
    const uint8_t *image = ear->last[EAR_SERIAL][MR_ID_BOARD_IMAGE];
    struct mr_command arm = {.code = MR_COMMAND_ARM, .tag = 1};
    ear_until(ear, 0.1);
    for (unsigned i = 0; i < MR_KEY_WORDS; i++) {
        const struct mr_key_word word = {.index = (uint8_t)i, .value = mr_get_u32(&p)};
        send(MR_ID_KEY_WORD, payload, mr_key_word_put(&word, payload));
    }
    ear_command(ear, EAR_SERIAL, MR_COMMAND_KEY_SET, (int32_t)mr_crc32(0, key, sizeof key), 2);
    ear_until(ear, 0.9);                                                     /* and a nonce */
    assert_int_equal((int8_t)ear->last[EAR_SERIAL][MR_ID_ACK][1], MR_PROOF); /* the run's own arm */
    const uint32_t words[3] = {mr_get_u32(&uid), mr_get_u32(&uid), mr_get_u32(&image)};
    mr_command_put(&arm, payload);
    mr_proof_compute(overheard, key, ear->last[EAR_SERIAL][MR_ID_NONCE], payload, words);
    send(MR_ID_PROOF, overheard, sizeof overheard);
    send(MR_ID_COMMAND, payload, MR_MESSAGE_BYTES_MAX);
    ear_until(ear, BEGIN_S);
    assert_int_equal(ear->last[EAR_SERIAL][MR_ID_ACK][1], MR_OK);
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
        bench_run(ear->board, hil_board_now_ps(ear->board) + HIL_PS_PER_MS);
    }
}

static void live(struct day *day, bool stranger, bool keyed)
{
    struct hil_options options = ear_options();
    struct mr_health health;
    struct mr_bus_key bus_key;
    options.is_jumper_fitted = keyed;
    *(today = day) = (struct day){.keyed = keyed};
    ear = ear_open(&options, 5);
    hil_board_set_callbacks(ear->board, &(struct hil_callbacks){ear, on_can, ear_serial});
    if (keyed)
        set_key_and_arm();
    ear_until(ear, BEGIN_S);
    uint64_t asleep = hil_board_counters(ear->board)->asleep_cycles;
    if (stranger && keyed)
        flood_with_proofs((uint64_t)(END_S * 1e12));
    else if (stranger)
        flood((uint64_t)(END_S * 1e12));
    ear_until(ear, END_S);
    day->cycles = (uint64_t)((END_S - BEGIN_S) * 168e6) -
                  (hil_board_counters(ear->board)->asleep_cycles - asleep);
    mr_health_get(&health, ear->last[EAR_SERIAL][MR_ID_HEALTH], MR_MESSAGE_BYTES_MAX);
    day->lost = health.blocks_lost;
    mr_bus_key_get(&bus_key, ear->last[EAR_SERIAL][MR_ID_BUS_KEY], MR_MESSAGE_BYTES_MAX);
    day->wrong = bus_key.refused;
    day->states = ear->heard[EAR_SERIAL][MR_ID_LANDING];
    day->edges = ear->heard[EAR_SERIAL][MR_ID_EDGE];
    day->backlogs = ear->heard[EAR_SERIAL][MR_ID_BACKLOG];
    day->blocks = ear->blocks;
    day->resets = hil_board_counters(ear->board)->resets;
    ear_close(ear);
}

static void assert_untouched(const struct day *quiet, const struct day *loud)
{
    unsigned each = (unsigned)((loud->cycles - quiet->cycles) / loud->answered);
    assert_true(quiet->edges > 0);
    printf("%u edges; %u frames, %u answers, %u obeyed, %u proofs looked at; %u cycles an answer\n",
           quiet->edges, loud->sent, loud->answered, loud->obeyed, loud->wrong, each);
    assert_true(loud->answered > 1000);
    assert_int_equal(loud->obeyed, 0);
    assert_int_equal(loud->unlike, 0);
    assert_int_equal(loud->resets, 0);
    assert_int_equal(loud->lost, 0);
    assert_int_equal(loud->backlogs, quiet->backlogs);
    assert_int_equal(loud->states, quiet->states);
    assert_int_equal(loud->edges, quiet->edges);
    assert_int_equal(loud->blocks, quiet->blocks);
    assert_true(loud->touchdown_ft_s == quiet->touchdown_ft_s);
    assert_in_range(each, 500, 5000); /* two links, and the black box */
}

TEST(a_stranger_is_not_obeyed_and_costs_no_block)
{
    struct day quiet, loud;
    live(&quiet, false, false);
    live(&loud, true, false);
    assert_untouched(&quiet, &loud);
}

/* Three proofs a second are looked at: what a guess costs beyond its answer is not seen. */
TEST(nor_with_proofs_that_he_guesses)
{
    struct day quiet, loud;
    live(&quiet, false, true);
    live(&loud, true, true);
    assert_int_equal(quiet.wrong, 0);
    assert_in_range(loud.wrong, 3, 3 * 8);
    assert_untouched(&quiet, &loud);
}
