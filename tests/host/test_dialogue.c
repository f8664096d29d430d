/* The conversation with a board over a scripted link: what is lost, answered twice, late, by
 * somebody else, or not at all. */
#include "common/command.h"
#include "host/board/dialogue.h"
#include "tests/host/scripted_link.h"

#define ANSWER_S 2.0
#define SLACK_S  0.5 /* the looks of the scripted clock at a deadline */

static struct scripted board, can_end;
static struct dialogue dialogue;

static int begin(void **state)
{
    (void)state;
    scripted_now_s = 1000.0;
    dialogue_begin(&dialogue, NULL, scripted_open(&board, LINK_SERIAL));
    dialogue.now_s = scripted_clock;
    return 0;
}

static int begin_can(void **state)
{
    (void)state;
    scripted_now_s = 1000.0;
    dialogue_begin(&dialogue, scripted_open(&can_end, LINK_CAN), NULL);
    dialogue.now_s = scripted_clock;
    return 0;
}

static int begin_both(void **state)
{
    (void)state;
    scripted_now_s = 1000.0;
    dialogue_begin(&dialogue, scripted_open(&can_end, LINK_CAN),
                   scripted_open(&board, LINK_SERIAL));
    dialogue.now_s = scripted_clock;
    return 0;
}

static int end(void **state)
{
    (void)state;
    dialogue_close(&dialogue);
    return 0;
}

/* ---- boards ---- */

static void say_ack(struct scripted *s, unsigned code, unsigned tag, int status)
{
    SCRIPTED_SAY(s, ack, ACK, .code = (uint8_t)code, .tag = (uint16_t)tag,
                 .status = (int8_t)status);
}

static void say_hello(struct scripted *s, unsigned layout)
{
    SCRIPTED_SAY(s, hello, HELLO, .layout = (uint16_t)layout, .major = 1);
}

static void obedient(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command->code, command->tag, MR_OK);
}

/* The first order does not arrive, or its answer does not: the link cannot tell. */
static void loses_first(struct scripted *s, const struct mr_command *command)
{
    if (s->commands > 1)
        obedient(s, command);
}

/* Arms, and the answer is lost: its state alone tells. */
static void arms_unheard(struct scripted *s, const struct mr_command *command)
{
    (void)command;
    SCRIPTED_SAY(s, landing, LANDING, .state = 1, .landing = 7);
}

static void answers_twice(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command->code, command->tag, MR_OK);
    say_ack(s, command->code, command->tag, MR_NOT_NOW);
}

/* Each order is answered as the next one comes. */
static void answers_late(struct scripted *s, const struct mr_command *command)
{
    static struct mr_command before;
    if (s->commands > 1)
        say_ack(s, before.code, before.tag, MR_LIMIT);
    before = *command;
}

static void answers_another_tag(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command->code, command->tag + 1u, MR_OK);
    say_ack(s, command->code, command->tag - 1u, MR_OK);
}

static void answers_another_order(struct scripted *s, const struct mr_command *command)
{
    say_ack(s, command->code + 1u, command->tag, MR_OK);
}

/* ---- orders ---- */

static enum mr_status order(unsigned code, unsigned tries, struct mr_ack *answer,
                            struct error *error)
{
    *error = (struct error){0};
    return dialogue_send_command(
        &dialogue,
        &(struct dialogue_command){
            .code = (uint8_t)code, .argument = 5, .answer_timeout_s = ANSWER_S, .tries_max = tries},
        answer, error);
}

static void assert_took(double begun_s, double s)
{
    if (!(scripted_now_s >= begun_s + s) || scripted_now_s > begun_s + s + SLACK_S)
        fail_msg("it took %.3f s, not %.3f", scripted_now_s - begun_s, s);
}

TEST_IN(over_can_too, begin_can, end)
{
    struct mr_ack answer;
    struct error error;
    can_end.board = obedient;
    assert_int_equal(order(MR_COMMAND_ARM, 1, &answer, &error), MR_OK);
    assert_int_equal(can_end.newest.argument, 5);
}

static enum mr_status take_landing(void *context, const struct dialogue_message *message,
                                   struct error *error)
{
    struct mr_landing landing;
    (void)error;
    if (message->id == MR_ID_LANDING &&
        mr_landing_get(&landing, message->payload, message->length) == MR_OK)
        *(bool *)context = landing.state == 1;
    return MR_OK;
}

TEST_IN(a_lost_answer_is_read_from_the_state, begin, end)
{
    struct mr_ack answer = {.status = MR_LIMIT};
    struct error error = {0};
    bool armed = false;
    struct dialogue_command arm = {.code = MR_COMMAND_ARM,
                                   .answer_timeout_s = ANSWER_S,
                                   .was_executed = dialogue_is_flag_set,
                                   .context = &armed};
    dialogue_subscribe(&dialogue, take_landing, &armed);
    /* silent: the order was lost */
    assert_int_equal(dialogue_send_command(&dialogue, &arm, &answer, &error), MR_TIMEOUT);
    board.board = arms_unheard;
    assert_int_equal(dialogue_send_command(&dialogue, &arm, &answer, &error), MR_OK);
    assert_int_equal(answer.status, MR_OK);
    assert_int_equal(board.commands, 2);
}

TEST_IN(a_silent_board_is_given_up_in_time, begin, end)
{
    struct error error = {0};
    double begun_s = scripted_now_s;
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT, "no hello from a board: scripted; no byte received");
    assert_took(begun_s, DIALOGUE_HELLO_TIMEOUT_S);
    error = (struct error){0};
    assert_int_equal(dialogue_set_no_answer_error(&dialogue, MR_COMMAND_STATE, &error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT, "the board did not answer `state`: scripted;");
}

TEST_IN(a_refusal_says_why, begin, end)
{
    struct mr_ack answer = {.code = MR_COMMAND_BOX_FREE, .status = MR_NOT_NOW};
    struct error error = {0};
    assert_int_equal(dialogue_set_refusal_error(&dialogue, &answer, "it is armed", &error),
                     MR_NOT_NOW);
    assert_error(&error, MR_NOT_NOW, "the board refused `box-free` now: scripted; it is armed");
    error = (struct error){0};
    answer.status = MR_IO;
    assert_int_equal(dialogue_set_refusal_error(&dialogue, &answer, "it is armed", &error), MR_IO);
    assert_error(&error, MR_IO, "the board refused `box-free`: scripted; ");
}

/* ---- whom it speaks with ---- */

TEST_IN(a_board_of_another_layout_is_refused, begin, end)
{
    struct error error = {0};
    say_hello(&board, MR_LAYOUT + 1u);
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_VERSION);
    assert_error(&error, MR_VERSION, "this matrig uses layout");
    say_hello(&board, MR_LAYOUT + 1u);
    error = (struct error){0};
    dialogue.accepts_any_layout = true; /* to be flashed */
    dialogue_reset(&dialogue);
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_OK);
    assert_int_equal(dialogue.identity.hello.layout, MR_LAYOUT + 1u);
}

TEST_IN(strangers_are_no_board, begin, end)
{
    struct error error = {0};
    for (unsigned i = 0; i < 3000; i++)
        board.bytes[board.end++] = (uint8_t)(i % 7);
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_IO);
    assert_error(&error, MR_IO, "no hello from a board: scripted; ");
}

TEST_IN(a_strangers_frames_on_can_are_no_board, begin_can, end)
{
    static bool heard;
    struct error error = {0};
    say_hello(&can_end, MR_LAYOUT);
    can_end.frames[0].id |= LINK_ID_EXTENDED; /* somebody else's, of the same lower bits */
    dialogue_subscribe(&dialogue, take_landing, &heard);
    SCRIPTED_SAY(&can_end, landing, LANDING, .state = 1);
    can_end.frames[1].id |= LINK_ID_ERROR;
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT, "no hello from a board: scripted can; ");
    assert_false(heard);
}

static void says_who_it_is(struct scripted *s)
{
    say_hello(s, MR_LAYOUT);
    SCRIPTED_SAY(s, board_uid, BOARD_UID, .uid0 = 0x11, .uid1 = 0x22);
    SCRIPTED_SAY(s, board_image, BOARD_IMAGE, .uid2 = 0x33, .image_crc = 0x44);
}

TEST_IN(who_speaks_is_known_until_forgotten, begin, end)
{
    struct error error = {0};
    char uid[IDENTITY_UID_SIZE];
    says_who_it_is(&board);
    assert_int_equal(dialogue_wait_for_hello(&dialogue, dialogue_is_flag_set,
                                             &dialogue.identity.image_known, &error),
                     MR_OK);
    identity_uid_text(&dialogue.identity, uid);
    assert_string_equal(uid, "000000110000002200000033");
    dialogue_reset(&dialogue);
    assert_int_equal(dialogue_wait_for_hello(&dialogue, NULL, NULL, &error), MR_TIMEOUT);
}

TEST_IN(answers_count_on_the_link_of_the_orders, begin_both, end)
{
    bool armed = false;
    struct mr_ack answer;
    struct error error;
    dialogue_subscribe(&dialogue, take_landing, &armed);
    SCRIPTED_SAY(&can_end, landing, LANDING, .state = 1);
    say_ack(&can_end, MR_COMMAND_ARM, dialogue_tag(&dialogue) + 1u, MR_LIMIT);
    say_hello(&can_end, MR_LAYOUT + 1u);
    assert_int_equal(order(MR_COMMAND_ARM, 1, &answer, &error), MR_TIMEOUT);
    assert_int_equal(board.commands, 1);
    assert_int_equal(can_end.commands, 0);
    assert_true(armed); /* subscribers hear both */
    assert_false(dialogue.identity.hello_known);
}

/* ---- waiting ---- */

/* The computer stands still while it waits; the answer comes meanwhile. */
static void stands_still(struct scripted *s)
{
    if (s->commands && scripted_now_s < 1060.0)
        scripted_now_s += 60.0;
    else if (s->commands)
        say_ack(s, s->newest.code, s->newest.tag, MR_OK);
}

static void chatters(struct scripted *s)
{
    scripted_now_s += SCRIPTED_LOOK_S;
    SCRIPTED_SAY(s, clock, CLOCK, .block = 1);
}

/* What a board does with an order, and what comes of it. -1: it takes how long it takes. */
static const struct answering {
    void (*board)(struct scripted *s, const struct mr_command *command);
    void (*idle)(struct scripted *s);
    unsigned code, tries;
    enum mr_status status;
    int answer;
    size_t sent;
    double took_s;
} answering[] = {
    {obedient, NULL, MR_COMMAND_ARM, 1, MR_OK, MR_OK, 1, 0.0},
    /* one that repeats is sent again; one that does not, once */
    {loses_first, NULL, MR_COMMAND_STATE, 3, MR_OK, MR_OK, 2, ANSWER_S},
    {loses_first, NULL, MR_COMMAND_ARM, 3, MR_TIMEOUT, MR_OK, 1, ANSWER_S},
    {answers_twice, NULL, MR_COMMAND_ARM, 1, MR_OK, MR_OK, 1, 0.0}, /* the first counts */
    /* a late answer is that of the order sent again; another tag is another program's */
    {answers_late, NULL, MR_COMMAND_SURVEY, 3, MR_OK, MR_LIMIT, 2, ANSWER_S},
    {answers_another_tag, NULL, MR_COMMAND_ARM, 1, MR_TIMEOUT, MR_OK, 1, ANSWER_S},
    {answers_another_order, NULL, MR_COMMAND_ARM, 1, MR_TIMEOUT, MR_OK, 1, ANSWER_S},
    {NULL, NULL, MR_COMMAND_STATE, 3, MR_TIMEOUT, MR_OK, 3, 3 * ANSWER_S},
    {NULL, stands_still, MR_COMMAND_ARM, 1, MR_OK, MR_OK, 1, -1.0},
    {NULL, chatters, MR_COMMAND_ARM, 1, MR_TIMEOUT, MR_OK, 1, ANSWER_S},
};

TEST(each_answer_is_taken_for_what_it_is)
{
    for (size_t i = 0; i < sizeof answering / sizeof answering[0]; i++) {
        const struct answering *a = &answering[i];
        struct mr_ack answer = {.status = MR_OK};
        struct error error;
        begin(NULL);
        double begun_s = scripted_now_s;
        board.board = a->board;
        board.idle = a->idle;
        print_message("# row %zu\n", i);
        assert_int_equal(order(a->code, a->tries, &answer, &error), a->status);
        assert_int_equal(error.status, MR_OK); /* the caller's to say */
        assert_int_equal(board.commands, a->sent);
        assert_int_equal(board.newest.tag, board.first.tag);
        if (a->status == MR_OK)
            assert_int_equal(answer.status, a->answer);
        if (a->took_s >= 0.0)
            assert_took(begun_s, a->took_s);
        end(NULL);
    }
}

/* Neither what is left of two answers nor a late one is the next order's. */
TEST_IN(an_answer_is_not_the_next_orders, begin, end)
{
    struct mr_ack answer;
    struct error error;
    board.board = answers_twice;
    assert_int_equal(order(MR_COMMAND_ARM, 1, &answer, &error), MR_OK);
    board.board = answers_late;
    assert_int_equal(order(MR_COMMAND_ARM, 1, &answer, &error), MR_TIMEOUT);
    assert_int_equal(order(MR_COMMAND_ARM, 1, &answer, &error), MR_TIMEOUT);
    assert_int_equal(board.commands, 3);
}

struct counted {
    size_t clocks;
    bool enough;
};

static enum mr_status count_clocks(void *context, const struct dialogue_message *message,
                                   struct error *error)
{
    struct counted *counted = context;
    (void)error;
    counted->clocks += message->id == MR_ID_CLOCK;
    counted->enough = counted->clocks == 5;
    return MR_OK;
}

/* A message each 0.9 s. */
static void tells_slowly(struct scripted *s)
{
    static double next_s;
    if (scripted_now_s < next_s)
        return;
    next_s = scripted_now_s + 0.9;
    SCRIPTED_SAY(s, clock, CLOCK, .block = 1);
}

TEST_IN(an_answer_of_many_messages_may_take_its_time, begin, end)
{
    struct counted counted = {0};
    struct error error = {0};
    double begun_s = scripted_now_s;
    dialogue_subscribe(&dialogue, count_clocks, &counted);
    board.idle = tells_slowly;
    assert_int_equal(
        dialogue_wait_until(&dialogue, dialogue_is_flag_set, &counted.enough, 1.0, &error),
        MR_TIMEOUT);
    assert_took(begun_s, 1.0);
    counted.clocks = 0;
    assert_int_equal(dialogue_wait_while_receiving(&dialogue, dialogue_is_flag_set, &counted.enough,
                                                   &counted.clocks, 1.0, &error),
                     MR_OK);
    board.idle = NULL;
    counted = (struct counted){0};
    begun_s = scripted_now_s;
    assert_int_equal(dialogue_wait_while_receiving(&dialogue, dialogue_is_flag_set, &counted.enough,
                                                   &counted.clocks, 1.0, &error),
                     MR_TIMEOUT);
    assert_took(begun_s, 1.0);
}

static enum mr_status refuse(void *context, const struct dialogue_message *message,
                             struct error *error)
{
    (void)context;
    return message->id == MR_ID_CLOCK
             ? error_set(error, MR_LIMIT, "a clock: scripted; none is wanted")
             : MR_OK;
}

TEST_IN(a_subscriber_ends_the_wait, begin, end)
{
    struct counted counted = {0};
    struct error error = {0};
    dialogue_subscribe(&dialogue, refuse, NULL);
    dialogue_subscribe(&dialogue, count_clocks, &counted);
    SCRIPTED_SAY(&board, clock, CLOCK, .block = 1);
    assert_int_equal(
        dialogue_wait_until(&dialogue, dialogue_is_flag_set, &counted.enough, 1.0, &error),
        MR_LIMIT);
    assert_int_equal(counted.clocks, 0); /* in the order in which they subscribed */
}

TEST_IN(the_end_of_the_link_is_an_error, begin, end)
{
    struct mr_ack answer;
    struct error error;
    board.closed = true;
    assert_int_equal(order(MR_COMMAND_STATE, 3, &answer, &error), MR_CLOSED);
    assert_error(&error, MR_CLOSED, "the board closed the link: scripted");
    assert_int_equal(board.commands, 1);
}

/* Of the firmware (firmware/app.c): what is begun by an order, counted, or taken away by one is not
 * the same done twice. */
TEST(what_repeats)
{
    static const unsigned once[] = {
        MR_COMMAND_ARM,          MR_COMMAND_DISARM,    MR_COMMAND_MARK,    MR_COMMAND_BOOTROM,
        MR_COMMAND_RESET,        MR_COMMAND_SELF_TEST, MR_COMMAND_ZERO,    MR_COMMAND_SHUNT,
        MR_COMMAND_CONFIG_APPLY, MR_COMMAND_CAMERA,    MR_COMMAND_BACKLOG, MR_COMMAND_BOX_FREE,
        MR_COMMAND_RUNWAY_TAKE};
    unsigned repeat = 0;
    for (size_t i = 0; i < sizeof once / sizeof once[0]; i++)
        assert_false(dialogue_is_repeatable_command(once[i]));
    for (unsigned code = 0; code < 256; code++)
        repeat += dialogue_is_repeatable_command(code);
    assert_int_equal(repeat, 23 - sizeof once / sizeof once[0]);
}
