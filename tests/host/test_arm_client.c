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

static const struct {
    unsigned state; /* before */
    scripted_board *board;
    enum mr_status status;
    const char *text;
} arming[] = {
    {0, arms, MR_OK, NULL},
    {0, arms_unheard, MR_OK, NULL}, /* a lost answer is seen in the state */
    /* it was armed before: its state does not tell that this order did it */
    {1, arms_unheard, MR_TIMEOUT,
     "the board did not answer `arm` within 3 s: scripted; before you try again, check the state "
     "of the board"},
    {0, stays, MR_TIMEOUT, "did not answer `arm`"},
    {0, takes_and_stays, MR_TIMEOUT,
     "the board accepted `arm` but did not report the state armed: scripted;"},
    {2, refuses, MR_NOT_NOW, "with landing 7: wait for the end"},
    {0, waits, MR_WAIT, "try again in about 13 s"},
};

TEST(what_comes_of_arming)
{
    for (size_t i = 0; i < sizeof arming / sizeof arming[0]; i++) {
        struct error error = {0};
        print_message("# row %zu\n", i);
        begin(arming[i].state, arming[i].board);
        assert_int_equal(arm_client_send(&talk, MR_COMMAND_ARM, 7, &error), arming[i].status);
        assert_int_equal(board.commands, 1);
        dialogue_close(&dialogue);
        if (arming[i].text)
            assert_error(&error, arming[i].status, arming[i].text);
        else
            assert_int_equal(talk.landing.landing, 7);
    }
}
