/* Chart and plan on the board's application: what the commands give. */
#include "common/fault.h"
#include "common/risk.h"
#include "firmware/config.h"
#include "tests/firmware/play.h"

static void arm(void)
{
    play(10);
    command("arm 1");
    play(300);
}

static void give(const struct mr_risk_plan *plan, uint32_t crc)
{
    for (unsigned i = 0; i <= MR_RISK_PLAN_ITEM_COUNT; i++) {
        float value = mr_risk_plan_get_item(plan, i);
        struct mr_command message = {.code = (uint8_t)(i < MR_RISK_PLAN_ITEM_COUNT
                                                           ? MR_COMMAND_CHART_WORD
                                                           : MR_COMMAND_CHART_TAKE),
                                     .index = (uint8_t)(i < MR_RISK_PLAN_ITEM_COUNT ? i : 0)};
        memcpy(&message.argument, &value, sizeof value);
        if (i == MR_RISK_PLAN_ITEM_COUNT)
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
    plan.landing_count = landings;
    plan.speed_ft_s = 30.0f;
    plan.plan_time_s[0] = 0.0f;
    plan.plan_deceleration_ft_s2[0] = 6.0f;
    plan.chart_deceleration_ft_s2[0] = 5.0f;
    plan.chart_log_odds[0] = 1.0f;
    return plan;
}

static uint8_t last_basis(void)
{
    struct mr_risk risk;
    GET_LAST(risk, RISK, &risk);
    return risk.basis;
}

TEST_IN(a_chart_counts_for_one_landing, start, NULL)
{
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    give(&plan, mr_risk_plan_crc(&plan) ^ 1u);
    assert_int_equal(last_status(), MR_CRC);
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_OK);
    touchdown_s = 3.0;
    config.risk[0].lamp_cost_ratio = 4.0f;
    arm();
    config.risk[0].lamp_cost_ratio = NAN;
    /* all its numbers are told when armed, and the limit */
    struct mr_risk_item item;
    unsigned seen = 0;
    play(200);
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != MR_ID_RISK_ITEM ||
            mr_risk_item_get(&item, fake.sent[i].data, 8) != MR_OK)
            continue;
        float wanted = item.index < MR_RISK_PLAN_ITEM_COUNT
                         ? mr_risk_plan_get_item(&plan, item.index)
                         : app.predict.lamp_limit;
        assert_true(item.value == wanted);
        seen |= item.index == MR_RISK_PLAN_ITEM_COUNT - 2u * MR_RISK_PLAN_KNOTS ? 1u : 0u;
        seen |= item.index == 2 ? 2u : 0u;
        seen |= item.index == MR_RISK_PLAN_ITEM_COUNT ? 4u : 0u;
    }
    assert_int_equal(seen, 7);
    fly(4.0);
    assert_int_equal(last_basis() & 15u, MR_RISK_PLAN_USED | MR_RISK_CHART_USED);
    give(&plan, mr_risk_plan_crc(&plan)); /* not now */
    assert_int_equal(last_status(), MR_NOT_NOW);
    fly(13.0); /* rest, and done */
    assert_int_equal(app.landing.state, MR_LANDING_DONE);
    give(&plan, mr_risk_plan_crc(&plan)); /* one landing ago */
    assert_int_equal(last_status(), MR_VERSION);
    command("arm 2");
    play(400);
    assert_int_equal(last_basis() & 15u, 0); /* the first was used up */
}

TEST_IN(a_chart_may_be_taken_back, start, NULL)
{
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    give(&plan, mr_risk_plan_crc(&plan));
    command("chart-forget");
    play(10);
    arm();
    assert_int_equal(last_basis() & 15u, 0);
    command("disarm");
    play(10);
    plan.plan_deceleration_ft_s2[0] = 0.0f; /* would never stop */
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_USAGE);
}

TEST_IN(a_runway_that_is_forgotten_has_no_chart, start, NULL)
{
    struct mr_risk_plan plan = charted(0.0f);
    play(10);
    app.predict.predictor.landing_count = 3;
    plan.landing_count = 3.0f;
    give(&plan, mr_risk_plan_crc(&plan));
    assert_int_equal(last_status(), MR_OK);
    command("runway-forget");
    play(5);
    arm();
    assert_int_equal(last_basis() & 15u, MR_RISK_PLAN_USED | MR_RISK_CHART_OUTDATED);
}
