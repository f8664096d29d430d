/* Chart and brake release on the board's application: what the commands give, what the output does,
 * and where it does nothing. */
#include "common/fault.h"
#include "common/risk.h"
#include "firmware/config.h"
#include "tests/firmware/play.h"

#define SURE  1000.0f /* cost ratio of a limit that any risk is beyond: 0.001 */
#define NEVER 0.01f   /* and of one that hardly any is */

static struct mr_config built_in;

static int start_wired(void **state)
{
    if (!built_in.site[0].mats)
        built_in = config;
    config = built_in;
    config.risk[0].release = 1;
    config.risk[0].release_cost_ratio = SURE;
    config.risk[0].coasting_ft_s2 = 6.0f;
    return start(state);
}

static int put_back(void **state)
{
    (void)state;
    config = built_in;
    return 0;
}

static void arm(void)
{
    play(10);
    command("arm 1");
    play(300);
}

static struct mr_release told(void)
{
    struct mr_release release = {0};
    GET_LAST(release, RELEASE, &release);
    return release;
}

static void a_square_wave_asks(void **state)
{
    (void)state;
    arm();
    assert_int_equal(fake.release_edges, 0);
    fly(2.0); /* the third switch beyond touchdown comes at 1.44 s */
    assert_int_equal(told().state, MR_RELEASE_ASKED);
    unsigned edges = fake.release_edges;
    assert_true(edges > 100);
    play(100);
    assert_int_equal(fake.release_edges, edges + 100); /* one in each block: 500 Hz */
    command("disarm");
    play(1);
    assert_false(fake.release);
    edges = fake.release_edges;
    play(1000);
    assert_int_equal(fake.release_edges, edges);
    assert_int_equal(told().state, MR_RELEASE_OVER);
}

static void it_ends_with_the_time_it_may_last(void **state)
{
    (void)state;
    config.risk[0].release_most_ms = 500;
    arm();
    fly(2.0);
    unsigned asked_at = told().block;
    fly(4.0);
    assert_int_equal(told().state, MR_RELEASE_OVER);
    assert_int_equal(told().reason, MR_RELEASE_TIME_UP);
    assert_int_equal(told().block, asked_at + 500);
    assert_true(isnan(told().ease_ft_s2));
    assert_true(fake.release_edges <= 501);
    assert_false(fake.release);
}

static void not_without_being_wired(void **state)
{
    (void)state;
    config.risk[0].release = 0;
    arm();
    fly(8.0);
    assert_int_equal(fake.release_edges, 0);
    assert_int_equal(count_frames(MR_ID_RELEASE), 0);
}

static void not_without_a_risk(void **state)
{
    (void)state;
    config.risk[0].release_cost_ratio = NEVER;
    arm();
    fly(8.0);
    assert_int_equal(fake.release_edges, 0);
}

static void not_without_runway(void **state)
{
    (void)state;
    config.risk[0].coasting_ft_s2 = 1.0f; /* 30 ft/s: 450 ft */
    arm();
    fly(2.5);
    assert_int_equal(fake.release_edges, 0);
    assert_int_equal(told().state, MR_RELEASE_REFUSED);
    assert_int_equal(told().reason, MR_RELEASE_NO_RUNWAY);
}

static void not_on_the_internal_clock(void **state)
{
    fake_reset();
    fake.clock_source = BOARD_CLOCK_INTERNAL;
    app_start(&app);
    index_now = 0;
    (void)state;
    arm();
    fly(4.0);
    assert_int_equal(fake.release_edges, 0);
}

static void not_disarmed(void **state)
{
    (void)state;
    play(10);
    fly(8.0);
    assert_int_equal(fake.release_edges, 0);
    assert_int_equal(count_frames(MR_ID_RELEASE), 0);
}

static void the_self_test_tries_the_pin(void **state)
{
    (void)state;
    struct mr_self_test result;
    play(10);
    command("self-test");
    play(150);
    assert_int_equal(fake.release_edges, 100);
    assert_false(fake.release);
    for (unsigned i = 0; i < 500; i++)
        app_supervise(&app);
    GET_LAST(self_test, SELF_TEST, &result);
    assert_true(result.done >> MR_SELF_TEST_RELEASE & 1u);
    assert_false(result.failed >> MR_SELF_TEST_RELEASE & 1u);
    fake.release_stuck = true;
    command("self-test");
    play(150);
    for (unsigned i = 0; i < 500; i++)
        app_supervise(&app);
    GET_LAST(self_test, SELF_TEST, &result);
    assert_true(result.failed >> MR_SELF_TEST_RELEASE & 1u);
    unsigned edges = fake.release_edges;
    command("arm 1");
    play(5);
    command("self-test"); /* not now */
    play(200);
    assert_int_equal(fake.release_edges, edges);
}

/* --- chart and plan --- */

static void give(const struct mr_risk_plan *plan, uint32_t crc)
{
    for (unsigned i = 0; i <= MR_RISK_ITEMS; i++) {
        float value = mr_risk_item(plan, i);
        struct mr_command message = {
            .code = (uint8_t)(i < MR_RISK_ITEMS ? MR_COMMAND_CHART_WORD : MR_COMMAND_CHART_TAKE),
            .index = (uint8_t)(i < MR_RISK_ITEMS ? i : 0)};
        memcpy(&message.argument, &value, sizeof value);
        if (i == MR_RISK_ITEMS)
            message.argument = (int32_t)crc;
        else if (isnan(value))
            continue;
        fake.received_taken = fake.received_count = 0;
        struct board_can_frame *frame = &fake.received[fake.received_count++];
        frame->id = MR_ID_COMMAND;
        frame->length = (uint8_t)mr_command_put(&message, frame->data);
        play(1);
    }
}

static int8_t last_status(void)
{
    struct mr_ack ack;
    GET_LAST(ack, ACK, &ack);
    return ack.status;
}

static struct mr_risk_plan charted(float landings)
{
    struct mr_risk_plan plan;
    mr_risk_plan_clear(&plan);
    plan.landings = landings;
    plan.speed_ft_s = 30.0f;
    plan.knot_s[0] = 0.0f;
    plan.knot_ft_s2[0] = 6.0f;
    plan.row_ft_s2[0] = 5.0f;
    plan.row_odds[0] = 1.0f;
    return plan;
}

static uint8_t last_basis(void)
{
    struct mr_risk risk;
    GET_LAST(risk, RISK, &risk);
    return risk.basis;
}

static void a_chart_counts_for_one_landing(void **state)
{
    (void)state;
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    give(&plan, mr_risk_plan_crc(&plan) ^ 1u);
    assert_int_equal(last_status(), MR_CRC);
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_OK);
    touchdown_s = 3.0;
    arm();
    /* all its numbers are told when armed, and the limits */
    struct mr_risk_item item;
    unsigned seen = 0;
    play(200);
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != MR_ID_RISK_ITEM ||
            mr_risk_item_get(&item, fake.sent[i].data, 8) != MR_OK)
            continue;
        float wanted = item.index < MR_RISK_ITEMS ? mr_risk_item(&plan, item.index)
                                                  : release_setting(&app.predict.release.settings,
                                                                    item.index - MR_RISK_ITEMS);
        assert_true(item.value == wanted);
        seen |= item.index == MR_RISK_ITEMS - 2u * MR_RISK_KNOTS ? 1u : 0u;
        seen |= item.index == 2 ? 2u : 0u;
        seen |= item.index == MR_RISK_ITEMS + 1u ? 4u : 0u;
    }
    assert_int_equal(seen, 7);
    fly(4.0);
    assert_int_equal(last_basis() & 15u, MR_RISK_OF_PLAN | MR_RISK_OF_CHART);
    give(&plan, mr_risk_plan_crc(&plan)); /* not now */
    assert_int_equal(last_status(), MR_NOT_NOW);
    fly(13.0); /* rest, and done */
    assert_int_equal(app.landing.state, LANDING_DONE);
    give(&plan, mr_risk_plan_crc(&plan)); /* one landing ago */
    assert_int_equal(last_status(), MR_VERSION);
    command("arm 2");
    play(400);
    assert_int_equal(last_basis() & 15u, 0); /* the first was used up */
}

static void a_chart_may_be_taken_back(void **state)
{
    (void)state;
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    give(&plan, mr_risk_plan_crc(&plan));
    command("chart-forget");
    play(10);
    arm();
    assert_int_equal(last_basis() & 15u, 0);
    command("disarm");
    play(10);
    plan.knot_ft_s2[0] = 0.0f; /* would never stop */
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_USAGE);
}

static void a_runway_that_is_forgotten_has_no_chart(void **state)
{
    (void)state;
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    app.predict.predictor.landings = 3;
    plan.landings = 3.0f;
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_OK);
    command("runway-forget");
    play(5);
    arm();
    assert_int_equal(last_basis() & 15u, MR_RISK_OF_PLAN | MR_RISK_CHART_OLD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_square_wave_asks, start_wired, put_back),
        cmocka_unit_test_setup_teardown(it_ends_with_the_time_it_may_last, start_wired, put_back),
        cmocka_unit_test_setup_teardown(not_without_being_wired, start_wired, put_back),
        cmocka_unit_test_setup_teardown(not_without_a_risk, start_wired, put_back),
        cmocka_unit_test_setup_teardown(not_without_runway, start_wired, put_back),
        cmocka_unit_test_setup_teardown(not_on_the_internal_clock, start_wired, put_back),
        cmocka_unit_test_setup_teardown(not_disarmed, start_wired, put_back),
        cmocka_unit_test_setup_teardown(the_self_test_tries_the_pin, start_wired, put_back),
        cmocka_unit_test_setup_teardown(a_chart_counts_for_one_landing, start_wired, put_back),
        cmocka_unit_test_setup_teardown(a_chart_may_be_taken_back, start_wired, put_back),
        cmocka_unit_test_setup_teardown(a_runway_that_is_forgotten_has_no_chart, start_wired,
                                        put_back),
    };
    return cmocka_run_group_tests_name("firmware/release", tests, NULL, NULL);
}
