/* A configuration read over a link that loses words of it, and boards that do not tell theirs. */
#include "common/command.h"
#include "common/wire.h"
#include "host/board/config_client.h"
#include "tests/host/scripted_link.h"

static struct scripted board;
static struct dialogue dialogue;
static struct config_client talk;
static uint8_t image[MR_CONFIG_IMAGE_BYTES];
static struct mr_config held, got;
static uint32_t crc, got_crc;
static unsigned lost; /* the word that the first telling loses; MR_CONFIG_WORDS: none */

static void tell(struct scripted *s, const struct mr_command *command)
{
    if (command->code != MR_COMMAND_CONFIG_READ)
        return;
    SCRIPTED_SAY(s, ack, ACK, .code = command->code, .tag = command->tag);
    for (unsigned i = (unsigned)command->argument; i < MR_CONFIG_WORDS; i++) {
        const uint8_t *p = image + 4u * i;
        if (i != lost || s->commands > 1)
            SCRIPTED_SAY(s, config_image, CONFIG_IMAGE, .offset = (uint16_t)i,
                         .words = MR_CONFIG_WORDS, .value = mr_get_u32(&p));
    }
}

/* The words come some looks after the answer, as those of a board do. */
static struct mr_command waiting;

static void tell_later(struct scripted *s, const struct mr_command *command)
{
    SCRIPTED_SAY(s, ack, ACK, .code = command->code, .tag = command->tag);
    waiting = *command;
}

static void tell_waiting(struct scripted *s)
{
    static unsigned looks;
    if (waiting.code && ++looks % 5 == 0) {
        tell(s, &waiting);
        waiting.code = 0;
    }
}

static void tell_nothing(struct scripted *s, const struct mr_command *command)
{
    SCRIPTED_SAY(s, ack, ACK, .code = command->code, .tag = command->tag, .status = MR_NOT_NOW);
}

static int begin(void **state)
{
    struct error error = {0};
    (void)state;
    scripted_now_s = 1000.0;
    held = (struct mr_config){0};
    held.site[0].revision = 7;
    crc = mr_config_encode(&held, image);
    lost = MR_CONFIG_WORDS;
    dialogue_begin(&dialogue, NULL, scripted_open(&board, LINK_SERIAL));
    dialogue.now_s = scripted_clock;
    board.board = tell;
    SCRIPTED_SAY(&board, hello, HELLO, .layout = MR_LAYOUT);
    SCRIPTED_SAY(&board, config_state, CONFIG_STATE, .source = 1);
    assert_int_equal(config_client_begin(&talk, &dialogue, &error), MR_OK);
    return 0;
}

static int end(void **state)
{
    (void)state;
    dialogue_close(&dialogue);
    return 0;
}

static void assert_got(unsigned commands)
{
    struct error error = {0};
    config_client_get(&talk, &got, &got_crc, &error);
    assert_no_error(&error);
    assert_int_equal(got_crc, crc);
    assert_int_equal(got.site[0].revision, 7);
    assert_int_equal(board.commands, commands);
}

TEST_IN(all_words_come, begin, end)
{
    assert_got(1);
}

TEST_IN(a_lost_word_is_asked_for_and_waited_for, begin, end)
{
    board.board = tell_later;
    board.idle = tell_waiting;
    lost = 5;
    assert_got(2);
    assert_int_equal(board.newest.argument, 5);
}

TEST_IN(a_lost_last_word_is_asked_for, begin, end)
{
    lost = MR_CONFIG_WORDS - 1;
    assert_got(2);
    assert_int_equal(board.newest.argument, MR_CONFIG_WORDS - 1);
}

TEST_IN(a_board_that_refuses_or_is_silent_is_told, begin, end)
{
    struct error error = {0};
    board.board = tell_nothing;
    assert_int_equal(config_client_get(&talk, &got, &got_crc, &error), MR_NOT_NOW);
    assert_error(&error, MR_NOT_NOW, "the configuration is locked");
    error = (struct error){0};
    board.board = NULL;
    assert_int_equal(config_client_get(&talk, &got, &got_crc, &error), MR_TIMEOUT);
    assert_error(&error, MR_TIMEOUT,
                 "the board did not answer `config-read`: scripted; check that the board is "
                 "running and connected");
}
