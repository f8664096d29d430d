/* The predictor on the board: what it says, the runway that it keeps through landings and resets,
 * what stands in for what is missing. */
#include "common/fault.h"
#include "common/runway.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "tests/firmware/fake_nor.h"
#include "tests/firmware/play.h"

#include <stdio.h>

#define A_COPY (NOR_SECTOR_BYTES * RUNWAY_FIRST_SECTOR)
#define B_COPY (A_COPY + NOR_SECTOR_BYTES)

static struct mr_config built_in;

/* The supply comes back, or the board is reset: only the memory is what it was. */
static void boot(void)
{
    fake_nor_power();
    fake_reset();
    config = built_in;
    app_start(&app);
    index_now = 0;
    opened_codes = 0;
    touchdown_s = 1.0;
    memset(moved_in, 0, sizeof moved_in);
}

static int start_with_memory(void **state)
{
    (void)state;
    built_in = config;
    fake_nor_reset();
    boot();
    return 0;
}

static int put_back(void **state)
{
    (void)state;
    config = built_in;
    fake_nor.present = false;
    return 0;
}

/* A millisecond of the memory goes with each block. */
static void live(unsigned blocks)
{
    while (blocks--) {
        play_block();
        fake_nor.now_us += 1000;
        if (fake.received_taken == fake.received_count)
            fake.received_taken = fake.received_count = 0;
    }
}

static void survey_all(float slack_in)
{
    char words[64];
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        snprintf(words, sizeof words, "survey %u %.4f", s, (double)slack_in);
        command(words);
        live(1);
    }
}

/* The state, as the links tell it. */
static uint32_t told_crc(struct mr_predictor_state *state)
{
    struct mr_runway runway;
    struct mr_runway_joints joints;
    struct mr_runway_store stored;
    fake.sent_count = 0;
    command("runway-read");
    live(120);
    memset(state, 0, sizeof *state);
    GET_LAST(runway, RUNWAY, &runway);
    state->mats = runway.mats;
    state->landing_count = runway.landings;
    state->resistance_scale = runway.resistance;
    assert_int_equal(count_frames(MR_ID_RUNWAY_JOINTS), 141); /* 421 joints, three in each */
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id == MR_ID_RUNWAY_JOINTS &&
            mr_runway_joints_get(&joints, fake.sent[i].data, 8) == MR_OK)
            mr_runway_apply_message(state, &joints);
    }
    GET_LAST(runway_store, RUNWAY_STORE, &stored);
    assert_int_equal(mr_runway_crc(state), stored.crc);
    return stored.crc;
}

static struct mr_runway_store told_store(void)
{
    struct mr_runway_store stored;
    fake.sent_count = 0;
    live(1001);
    GET_LAST(runway_store, RUNWAY_STORE, &stored);
    return stored;
}

TEST_IN(a_new_board_knows_no_runway, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.state, 0);
    assert_int_equal(stored.source, MR_RUNWAY_UNKNOWN);
    assert_int_equal(stored.copy_a, RUNWAYSTORE_BLANK);
    assert_int_equal(stored.copy_b, RUNWAYSTORE_BLANK);
    told_crc(&told);
    assert_int_equal(told.landing_count, 0);
    assert_int_equal(told.mats, 420);
    assert_true(told.resistance_scale == 1.0f);
    assert_int_equal(fake_nor.erases + fake_nor.operations, 0); /* nothing to keep */
}

TEST_IN(the_parameters_are_told, start_with_memory, put_back)
{
    struct mr_predict_item item;
    fake.sent_count = 0;
    command("state");
    live(400);
    assert_int_equal(count_frames(MR_ID_PREDICT_ITEM), MR_PREDICT_ITEM_COUNT);
    GET_LAST(predict_item, PREDICT_ITEM, &item);
    assert_int_equal(item.index, MR_PREDICT_ITEM_COUNT - 1);
    assert_int_equal(item.items, MR_PREDICT_ITEM_COUNT);
    assert_true(item.value == 110.0f); /* station of the last transducer */
}

/* What a survey says is kept half a second after its last segment, and is there after a reset. */
TEST_IN(the_runway_survives_a_reset, start_with_memory, put_back)
{
    struct mr_predictor_state before, after;
    live(200);
    survey_all(0.05f);
    uint32_t crc = told_crc(&before);
    live(1000);
    assert_int_equal(told_store().copy_a, 0);
    boot();
    live(200);
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.source, MR_RUNWAY_COPY_A);
    assert_int_equal(told_crc(&after), crc);
    assert_memory_equal(&after, &before, sizeof after);
    for (unsigned s = 0; s < MR_SEGMENTS; s++) { /* the survey's sums, by a sum of its own */
        unsigned sum = 0;
        for (unsigned j = 0; j < 10; j++)
            sum += after.gap_counts[10 * s + j];
        assert_in_range(sum, 4995, 5005);
    }
}

TEST_IN(a_landing_is_folded_and_kept, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    struct mr_slack slack;
    live(200);
    survey_all(0.20f);
    live(1000);
    command("arm 3");
    touchdown_s = 2.0 + 1e-3 * (double)index_now;
    fly(touchdown_s + 8.5);
    GET_LAST(slack, SLACK, &slack);
    for (unsigned i = 0; i < 60; i++)
        live(100);
    GET_LAST(slack, SLACK, &slack);
    assert_true(isnan(slack.slack_in)); /* a survey describes the runway until the next landing */
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.source, MR_RUNWAY_MEASURED);
    uint32_t crc = told_crc(&told);
    assert_int_equal(told.landing_count, 1);
    boot();
    live(300);
    stored = told_store();
    assert_int_equal(stored.source, MR_RUNWAY_COPY_B); /* the survey went to A */
    assert_int_equal(stored.crc, crc);
}

TEST_IN(armed_for_nothing_is_no_landing, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    command("arm 3");
    live(700);
    command("disarm");
    live(1200);
    told_crc(&told);
    assert_int_equal(told.landing_count, 0);
    assert_int_equal(told_store().copy_a, RUNWAYSTORE_BLANK);
}

/* The power goes in any operation of the memory, at its beginning, in its midst and at its end: the
 * runway is the old one or the new. */
TEST_IN(a_power_cut_leaves_the_old_or_the_new, start_with_memory, put_back)
{
    static uint8_t cells[2 * NOR_SECTOR_BYTES];
    struct mr_predictor_state told;
    unsigned old_ones = 0, new_ones = 0;
    live(200);
    survey_all(0.05f);
    live(1000);
    survey_all(0.06f); /* both copies hold one */
    live(1000);
    uint32_t old = told_crc(&told), new = 0;
    memcpy(cells, fake_nor.cell + A_COPY, sizeof cells);
    for (unsigned cut = 0; cut < 1 + 3 * 6; cut++) { /* an erase and five pages */
        memcpy(fake_nor.cell + A_COPY, cells, sizeof cells);
        fake_nor.cut_at = 0;
        boot();
        live(200);
        survey_all(0.07f);
        if (cut) {
            fake_nor.cut_at = fake_nor.operations + 1 + (cut - 1) / 3;
            fake_nor.cut_permille = (cut - 1) % 3 * 500;
        }
        live(1000);
        assert_int_equal(fake_nor.dark, cut > 0);
        boot();
        live(200);
        struct mr_runway_store stored = told_store();
        if (cut == 0)
            new = stored.crc;
        assert_true(stored.crc == old || stored.crc == new);
        assert_true(stored.source == MR_RUNWAY_COPY_A || stored.source == MR_RUNWAY_COPY_B);
        old_ones += stored.crc == old;
        new_ones += stored.crc == new;
    }
    assert_true(new != old &&old_ones >= 15 && new_ones >= 1);
    assert_false(health_get_faults() & 1u << MR_FAULT_NOR_FAILED);
}

TEST_IN(damaged_copies_are_told_and_passed_over, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    survey_all(0.05f);
    live(1000);
    uint32_t older = told_crc(&told);
    survey_all(0.06f);
    live(1000);
    fake_nor.cell[B_COPY + 700] ^= 4;
    boot();
    live(200);
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.copy_b, -MR_CRC);
    assert_int_equal(stored.source, MR_RUNWAY_COPY_A);
    assert_int_equal(stored.crc, older);
    assert_false(health_get_faults() & 1u << MR_FAULT_NOR_FAILED);
    fake_nor.cell[A_COPY + 1] ^= 1; /* and the other: nothing is left */
    boot();
    live(200);
    stored = told_store();
    assert_int_equal(stored.copy_a, -MR_MALFORMED);
    assert_int_equal(stored.source, MR_RUNWAY_UNKNOWN);
    assert_true(health_get_faults() & 1u << MR_FAULT_NOR_FAILED);
    told_crc(&told);
    assert_int_equal(told.landing_count, 0);
    survey_all(0.05f); /* and it can be kept again */
    live(1200);
    assert_int_equal(told_store().copy_a, 0);
}

TEST_IN(a_sector_that_does_not_hold_is_told, start_with_memory, put_back)
{
    live(200);
    fake_nor.faults = FAKE_NOR_PROGRAM_SILENT;
    fake_nor.from = A_COPY;
    fake_nor.to = B_COPY;
    survey_all(0.05f);
    live(3000);
    assert_int_equal(told_store().copy_a, -MR_IO);
    assert_true(health_get_faults() & 1u << MR_FAULT_NOR_FAILED);
    assert_true(fake_nor.erases <= 3); /* it is not tried for ever */
    fake_nor.faults = 0;
}

/* Words and joints, then its CRC. */
static void give(const struct mr_predictor_state *state, uint32_t crc)
{
    char words[64];
    for (unsigned i = 0; i < MR_RUNWAY_WORD_COUNT; i++) {
        snprintf(words, sizeof words, "runway-word %u %ld", i,
                 (long)mr_runway_make_word_argument(state, i));
        command(words);
        live(1);
    }
    for (unsigned i = 0; i < 256; i++) {
        snprintf(words, sizeof words, "runway-joints %u %ld", i,
                 (long)mr_runway_make_joints_argument(state, i));
        command(words);
        live(1);
    }
    struct mr_command take = {.code = MR_COMMAND_RUNWAY_TAKE, .argument = (int32_t)crc};
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    frame->id = MR_ID_COMMAND;
    frame->length = (uint8_t)mr_command_put(&take, frame->data);
    live(1);
}

static int8_t last_status(void)
{
    struct mr_ack ack;
    GET_LAST(ack, ACK, &ack);
    return ack.status;
}

TEST_IN(the_host_gives_a_runway, start_with_memory, put_back)
{
    struct mr_predictor_state given = {.mats = 420, .landing_count = 7, .resistance_scale = 1.25f},
                              told;
    for (unsigned j = 0; j < 421; j++)
        given.gap_counts[j] = (uint16_t)(j * 7 % 3001);
    live(10); /* before the memory has been looked at */
    give(&given, mr_runway_crc(&given) ^ 1u);
    assert_int_equal(last_status(), MR_CRC);
    give(&given, mr_runway_crc(&given));
    assert_int_equal(last_status(), MR_OK);
    assert_int_equal(told_crc(&told), mr_runway_crc(&given));
    assert_memory_equal(&told, &given, sizeof told);
    assert_int_equal(told_store().source, MR_RUNWAY_HOST);
    given.gap_counts[5] = 3200; /* wider than any joint */
    give(&given, mr_runway_crc(&given));
    assert_int_equal(last_status(), MR_MALFORMED);
    command("runway-word 3 0");
    live(1);
    assert_int_equal(last_status(), MR_USAGE);
    command("runway-forget");
    live(1);
    told_crc(&told);
    assert_int_equal(told.landing_count, 0);
    command("arm 1");
    live(10);
    const char *const locked[] = {"runway-forget", "runway-read", "runway-word 0 0",
                                  "runway-joints 0 0"};
    for (size_t i = 0; i < sizeof locked / sizeof *locked; i++) {
        command(locked[i]);
        live(1);
        assert_int_equal(last_status(), MR_NOT_NOW);
    }
}

/* Blocks that wait put it down one level at once, and once in a look; that is told, and comes
 * back. */
TEST_IN(a_backlog_is_an_input, start_with_memory, put_back)
{
    struct mr_backlog backlog;
    struct mr_verdict verdict;
    live(200);
    command("arm 1");
    touchdown_s = 1.0;
    fly(1.6);
    GET_LAST(verdict, VERDICT, &verdict);
    assert_int_equal(verdict.level, MR_PREDICTOR_FULL);
    fake.blocks_waiting = 9;
    live(10);
    fake.blocks_waiting = 0;
    live(10);
    assert_int_equal(count_frames(MR_ID_BACKLOG), 1);
    GET_LAST(backlog, BACKLOG, &backlog);
    assert_int_equal(backlog.waiting, 9);
    GET_LAST(verdict, VERDICT, &verdict);
    assert_int_equal(verdict.level, MR_PREDICTOR_TWO);
    assert_true(verdict.basis & MR_PREDICTOR_DEGRADED);
    live(100);
    unsigned answers = count_frames(MR_ID_ACK);
    app.is_replay = true;
    command("backlog 12"); /* as a replay gives it */
    live(20);
    assert_int_equal(count_frames(MR_ID_ACK), answers); /* the landing had none */
    GET_LAST(backlog, BACKLOG, &backlog);
    assert_int_equal(backlog.waiting, 12);
    GET_LAST(verdict, VERDICT, &verdict);
    assert_int_equal(verdict.level, MR_PREDICTOR_FOUR);
    live(3000);
    GET_LAST(verdict, VERDICT, &verdict);
    assert_int_equal(verdict.level, MR_PREDICTOR_FULL);
    assert_false(verdict.basis & MR_PREDICTOR_DEGRADED);
}

/* No switch tells of the gear: transducers 1 to 3 (40, 50 and 60 ft) approach each other by 0.35 in
 * each. What they have moved is no new zero, whatever time goes by; and the joints are others when
 * it is over. */
TEST_IN(without_switches_the_movement_stays, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    struct mr_slack slack;
    struct mr_zone zone;
    struct mr_zone_lead lead;
    struct mr_zone_error zone_error;
    live(200);
    survey_all(0.1f);
    command("arm 1");
    live(600);
    moved_in[0] = 0.72f;
    moved_in[1] = 0.37f;
    moved_in[2] = 0.02f;
    live(3000);
    assert_true(fake.warning);
    GET_LAST(zone, ZONE, &zone);
    assert_in_range(zone.mats, 60, 75);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_in_range(lead.inferred_percent, 0, 5); /* between transducers at 40 and 110 */
    GET_LAST(zone_error, ZONE_ERROR, &zone_error);
    /* the score has none to state */
    assert_true(isnan(zone_error.start_ft) && isnan(zone_error.end_ft));
    command("disarm");
    live(1200);
    assert_false(fake.warning);
    GET_LAST(slack, SLACK, &slack);
    assert_true(isnan(slack.slack_in));
    told_crc(&told);
    assert_int_equal(told.landing_count, 1);
    unsigned left = 0;
    for (unsigned j = 150; j < 200; j++)
        left += told.gap_counts[j];
    assert_in_range(left, 0, 5000); /* of 50,000 in these five segments */
}

/* Somebody touches one transducer: no gear, and the survey holds. */
TEST_IN(one_that_is_touched_is_no_landing, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    survey_all(0.1f);
    command("arm 1");
    live(600);
    moved_in[3] = 0.3f;
    live(600);
    command("disarm");
    live(100);
    told_crc(&told);
    assert_int_equal(told.landing_count, 0);
}

static unsigned surveyed(void)
{
    unsigned count = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        count += isnan(app.predict.predictor.surveyed_sum_in[s]) ? 0u : 1u;
    return count;
}

static void rearm(void)
{
    command("disarm");
    live(1);
    command("arm 1");
    live(1);
}

/* A statement rests on a survey only where the joints have its sums: not on one that they cannot
 * have (ten have 0.3 in of slack), nor on one that the host's runway has taken the place of. */
TEST_IN(a_survey_counts_where_the_joints_have_it, start_with_memory, put_back)
{
    struct mr_predictor_state given = {.mats = 420, .landing_count = 7, .resistance_scale = 1.0f};
    live(200);
    survey_all(0.1f);
    rearm();
    assert_int_equal(surveyed(), MR_SEGMENTS);
    rearm(); /* for nothing: it still holds */
    assert_int_equal(surveyed(), MR_SEGMENTS);
    command("disarm");
    live(1);
    command("survey 4 1.0");
    live(1);
    rearm();
    assert_int_equal(surveyed(), MR_SEGMENTS - 1u);
    command("disarm");
    live(1);
    for (unsigned j = 0; j < 421; j++)
        given.gap_counts[j] = j < 100 ? 1000 : 0; /* the first ten segments as they were surveyed */
    give(&given, mr_runway_crc(&given));
    assert_int_equal(last_status(), MR_OK);
    rearm();
    assert_int_equal(surveyed(), 9); /* but the one that could not be */
}

/* Left out of the configuration and back, the runway is what it was. One of other mats is not, but
 * what was surveyed is. */
TEST_IN(a_configuration_leaves_the_runway, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    survey_all(0.05f);
    live(1200);
    uint32_t crc = told_crc(&told);
    config.predict[0].fitted = 0;
    app_apply_configuration(&app);
    live(100);
    config.predict[0].fitted = 1;
    app_apply_configuration(&app);
    live(100);
    assert_int_equal(told_crc(&told), crc);
    config.site[0].mats = 400;
    app_apply_configuration(&app);
    live(1);
    assert_int_equal(app.predict.predictor.config.chain.mats, 400);
    rearm();
    assert_int_equal(surveyed(), 40); /* and a joint more, which is a segment of its own */
}

/* Counted by 32 bits: after the highest comes 0, and that is the newer one. */
TEST_IN(the_newer_copy_is_found_beyond_the_wrap, start_with_memory, put_back)
{
    struct mr_predictor_state older = {.mats = 420, .landing_count = 1, .resistance_scale = 1.0f},
                              newer = {.mats = 420, .landing_count = 2, .resistance_scale = 1.0f};
    mr_runway_encode(&older, UINT32_MAX, fake_nor.cell + A_COPY);
    mr_runway_encode(&newer, 0, fake_nor.cell + B_COPY);
    boot();
    live(200);
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.source, MR_RUNWAY_COPY_B);
    assert_int_equal(stored.crc, mr_runway_crc(&newer));
}

/* Commands of the first millisecond, before the memory has been read: what is surveyed comes on top
 * of what is kept, what is to be forgotten stays so; and a landing waits for the runway. */
TEST_IN(commands_before_the_memory_is_read, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    survey_all(0.05f);
    live(1200);
    boot();
    command("survey 3 0.2");
    live(200);
    assert_int_equal(told_store().source, MR_RUNWAY_MEASURED);
    told_crc(&told);
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        int sum = 0;
        for (unsigned j = 0; j < 10; j++)
            sum += told.gap_counts[10 * s + j];
        assert_in_range(sum, s == 3 ? 19990 : 4990, s == 3 ? 20010 : 5010);
    }
    boot();
    command("runway-forget");
    live(200);
    assert_int_equal(told_store().source, MR_RUNWAY_UNKNOWN);
    boot();
    for (unsigned i = 0; i < 400 && app.landing.state != MR_LANDING_ARMED; i++) {
        command("arm 1");
        live(1);
    }
    assert_int_equal(app.landing.state, MR_LANDING_ARMED);
    assert_true(app.runwaystore.is_loaded);
}

/* What changes while a copy is being written is kept too. */
TEST_IN(a_change_while_it_is_written_is_kept, start_with_memory, put_back)
{
    struct mr_predictor_state told;
    live(200);
    survey_all(0.05f);
    for (unsigned i = 0; i < 2000 && app.runwaystore.copy_state[0] != RUNWAYSTORE_BLANK; i++)
        live(1);
    uint64_t before = fake_nor.operations;
    for (unsigned i = 0; i < 2000 && fake_nor.operations == before; i++)
        live(1);
    command("survey 3 0.2");
    live(3000);
    uint32_t crc = told_crc(&told);
    boot();
    live(200);
    assert_int_equal(told_store().crc, crc);
}

/* A wrong bit that comes and goes in reading is none in the memory. */
TEST_IN(a_mistake_in_reading_is_read_again, start_with_memory, put_back)
{
    live(200);
    survey_all(0.05f);
    live(1200);
    boot();
    fake_nor.faults = FAKE_NOR_READ_ERROR;
    fake_nor.from = A_COPY;
    fake_nor.to = B_COPY;
    for (unsigned i = 0; i < 400 && app.runwaystore.tries == 0; i++)
        live(1);
    assert_true(app.runwaystore.tries > 0);
    fake_nor.faults = 0;
    live(200);
    assert_int_equal(told_store().source, MR_RUNWAY_COPY_A);
}

/* The deceleration is taken from the third switch beyond touchdown on (17.5 ft, 0.509 s after
 * it). */
TEST_IN(braking_is_known_from_the_third_switch, start_with_memory, put_back)
{
    for (unsigned third = 0; third < 2; third++) {
        boot();
        live(200);
        command("arm 1");
        touchdown_s = 1.0;
        fly(third ? 1.53 : 1.50);
        assert_int_equal(app.predict.predictor.is_braking_known, third);
        assert_true(app.predict.predictor.speed_ft_s > 0.0f);
    }
}

/* With all joints closed anything that moves warns; not while the model is pushed over a switch. */
TEST_IN(a_model_that_is_pushed_is_not_warned_of, start_with_memory, put_back)
{
    live(200);
    survey_all(0.0f);
    command("arm 1");
    live(600);
    moved_in[0] = 0.2f;
    live(20);
    assert_true(fake.warning);
    pass_switch(9, (double)index_now * 1e-3);
    live(60);
    assert_false(fake.warning);
}

static int without_predictor(void **state)
{
    built_in = config;
    config.predict[0].fitted = 0;
    fake_nor_reset();
    fake_reset();
    app_start(&app);
    index_now = 0;
    (void)state;
    return 0;
}

TEST_IN(without_one_nothing_is_said_or_kept, without_predictor, put_back)
{
    survey_all(0.0f);
    live(2000);
    command("arm 1");
    touchdown_s = 3.0;
    fly(5.0);
    for (uint16_t id = MR_ID_ZONE; id <= MR_ID_PREDICT_ITEM; id++)
        assert_int_equal(count_frames(id), 0);
    assert_false(fake.warning);
    assert_int_equal(fake_nor.cell[A_COPY], 0xff);
    config = built_in;
}

static int with_a_refused_one(void **state)
{
    built_in = config;
    /* a firmware's own configuration is not checked: the predictor refuses it */
    config.predict[0].step_ms = 0.4f;
    fake_nor_reset();
    fake_reset();
    app_start(&app);
    index_now = 0;
    (void)state;
    return 0;
}

TEST_IN(a_refused_one_says_why, with_a_refused_one, put_back)
{
    struct mr_runway_store stored = told_store();
    assert_int_equal(stored.state, -MR_NUMERICS);
    command("arm 1");
    live(200);
    assert_int_equal(last_status(), MR_OK); /* the rest measures */
    assert_int_equal(count_frames(MR_ID_ZONE), 0);
    config = built_in;
}
