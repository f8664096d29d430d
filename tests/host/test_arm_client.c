/* Arming over a link that loses the order or its answer: what the board says of its state decides,
 * and the order goes out once. */
#include "common/command.h"
#include "host/board/arm_client.h"
#include "tests/host/scripted_link.h"

static struct scripted board;
static struct dialogue dialogue;
static struct arm_client talk;

static void say_state(struct scripted *s, unsigned state)
{
    SCRIPTED_SAY(s, landing, LANDING, .state = (uint8_t)state, .landing = 7);
}

static void say_ack(struct scripted *s, const struct mr_command *command, int status)
{
    SCRIPTED_SAY(s, ack, ACK, .code = command->code, .tag = command->tag, .status = (int8_t)status);
}

static void begin(unsigned state, scripted_board *obeys)
{
    struct error error = {0};
    scripted_now_s = 1000.0;
    dialogue_begin(&dialogue, NULL, scripted_open(&board, LINK_SERIAL));
    dialogue.now_s = scripted_clock;
    SCRIPTED_SAY(&board, hello, HELLO, .layout = MR_LAYOUT);
    say_state(&board, state);
    assert_int_equal(arm_client_begin(&talk, &dialogue, &error), MR_OK);
    board.board = obeys;
}

static enum mr_status arm(struct error *error)
{
    *error = (struct error){0};
    enum mr_status status = arm_client_order(&talk, MR_COMMAND_ARM, 7, error);
    assert_int_equal(board.commands, 1);
    dialogue_close(&dialogue);
    return status;
}

static void arms(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command, MR_OK);
    say_state(s, 1);
}

static void arms_unheard(struct scripted *s, const struct mr_command *command)
{
    (void)command;
    say_state(s, 1);
}

static void stays(struct scripted *s, const struct mr_command *command)
{
    (void)command;
    say_state(s, 0);
}

static void takes_and_stays(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command, MR_OK);
    say_state(s, 0);
}

static void refuses(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command, MR_NOT_NOW);
}

static void waits(struct scripted *s, const struct mr_command *command)
{
    SCRIPTED_SAY(s, box_state, BOX_STATE, .state = 2, .wait_s = 12.4f);
    say_ack(s, command, MR_WAIT);
}

TEST(armed_is_said)
{
    struct error error;
    begin(0, arms);
    assert_int_equal(arm(&error), MR_OK);
    assert_int_equal(talk.landing.landing, 7);
}

TEST(a_lost_answer_is_seen_in_the_state)
{
    struct error error;
    begin(0, arms_unheard);
    assert_int_equal(arm(&error), MR_OK);
}

/* It was armed before: its state does not tell that this order did it. */
TEST(a_state_that_was_there_before_shows_nothing)
{
    struct error error;
    begin(1, arms_unheard);
    assert_int_equal(arm(&error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT,
                 "the board does not answer `arm` within 3 s: scripted; look what state it is in "
                 "before trying again");
}

TEST(a_lost_order_is_told)
{
    struct error error;
    begin(0, stays);
    assert_int_equal(arm(&error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT, "does not answer `arm`");
}

TEST(an_order_taken_and_not_followed_is_told)
{
    struct error error;
    begin(0, takes_and_stays);
    assert_int_equal(arm(&error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT,
                 "the board took `arm` and does not say it is armed: scripted;");
}

TEST(a_refusal_names_what_goes_on)
{
    struct error error;
    begin(2, refuses);
    assert_int_equal(arm(&error), MR_NOT_NOW);
    assert_error(&error, MR_NOT_NOW, "with landing 7: wait for its end");
    begin(0, waits);
    assert_int_equal(arm(&error), MR_WAIT);
    assert_error(&error, MR_WAIT, "its black box is ready in about 13 s");
}
