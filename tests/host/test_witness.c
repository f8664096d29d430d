/* Serial as the witness of CAN: a copy goes on as the witness itself does, whatever the rings hold
 * and wherever they begin. */
#include <stdlib.h>
#include <string.h>

#include "host/collect/witness.h"
#include "tests/cmocka_all.h"

static uint32_t state;

static uint32_t draw(uint32_t below)
{
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % below;
}

struct walk {
    int64_t block;
    uint32_t turn;
};

/* One thing that happens to a witness, as the walk and `seed` have it; a number that says what the
 * witness answered. */
static uint32_t happen(struct witness *witness, const struct walk *walk, uint32_t seed)
{
    static const uint16_t ids[] = {MR_ID_LANDING, MR_ID_HELLO, MR_ID_CLOCK, 0x100};
    struct witness_message message = {.block = walk->block, .host_us = walk->turn};
    uint8_t payload[MR_MESSAGE_MAX] = {0};
    uint32_t answer = 0;
    state = seed;
    uint16_t id = ids[draw(4)];
    payload[0] = (uint8_t)draw(3);
    mr_message_read(&message.message, id, payload, mr_message_find(id)->length);
    switch (draw(8)) {
    case 0:
    case 1: witness_serial(witness, &message.message, walk->block); break;
    case 2:
    case 3:
    case 4: answer = witness_can(witness, &message); break;
    case 5: witness_lost(witness, walk->block - draw(300), walk->block); break;
    case 6:
        if (draw(4000) == 0)
            witness_restart(witness);
        break;
    default:
        for (enum witness_verdict verdict = WITNESS_SAME; verdict != WITNESS_WAIT;) {
            verdict = witness_take(witness, walk->block - 200, false, &message);
            answer = answer * 31u + (uint32_t)verdict * 7u + (uint32_t)message.block;
        }
    }
    return answer;
}

static void a_copy_goes_on_as_the_witness(void **unused)
{
    (void)unused;
    struct witness *witness = malloc(sizeof *witness), *copy = malloc(sizeof *copy);
    assert_true(witness && copy);
    witness_start(witness);
    struct walk walk = {.block = 1};
    uint32_t seed = 5, answered = 0;
    for (int round = 0; round < 60; round++) {
        for (int i = 0; i < 3000; i++, walk.turn++) {
            /* so the waiting ones go beyond the ring's end, and those said to its limit */
            walk.block += round % 2 ? 1 : walk.turn % 40 == 0;
            happen(witness, &walk, seed += 77u);
        }
        memset(copy, 0xa5 + round, sizeof *copy);
        witness_copy(copy, witness);
        for (int i = 0; i < 500; i++, walk.turn++) {
            walk.block += i % 3 == 0;
            uint32_t answer = happen(witness, &walk, seed += 77u);
            answered += answer > 1;
            assert_int_equal(happen(copy, &walk, seed), answer);
        }
    }
    assert_true(answered > 500); /* verdicts were compared, not only silence */
    free(witness);
    free(copy);
}

/* A computer that is slow with one link brings CAN long after serial: what serial has said
 * meanwhile is more than is remembered. */
static void can_far_behind_is_no_stranger(void **unused)
{
    (void)unused;
    const int64_t behind = 3 * WITNESS_SAID;
    struct witness *witness = malloc(sizeof *witness);
    unsigned verdicts[WITNESS_STRANGER + 1] = {0};
    assert_non_null(witness);
    witness_start(witness);
    for (int64_t said = 0; said < 40000; said++) {
        struct witness_message taken, message = {.block = (said - behind) * 20};
        uint8_t payload[MR_MESSAGE_MAX] = {(uint8_t)said, (uint8_t)(said >> 8)};
        mr_message_read(&message.message, MR_ID_LANDING, payload,
                        mr_message_find(MR_ID_LANDING)->length);
        witness_serial(witness, &message.message, said * 20);
        if (said < behind)
            continue;
        payload[0] = (uint8_t)(said - behind);
        payload[1] = (uint8_t)((said - behind) >> 8);
        mr_message_read(&message.message, MR_ID_LANDING, payload,
                        mr_message_find(MR_ID_LANDING)->length);
        assert_true(witness_can(witness, &message));
        verdicts[witness_take(witness, message.block, false, &taken)]++;
    }
    assert_int_equal(verdicts[WITNESS_STRANGER], 0);
    assert_int_equal(verdicts[WITNESS_UNHEARD], 40000 - behind);
    free(witness);
}

/* Serial began with the board and has forgotten nothing: what it did not say is a stranger's, also
 * in the board's first second. */
static void the_first_second_is_remembered(void **unused)
{
    (void)unused;
    struct witness *witness = malloc(sizeof *witness);
    struct witness_message taken, message = {.block = 5};
    const uint8_t payload[MR_MESSAGE_MAX] = {1};
    assert_non_null(witness);
    witness_start(witness);
    mr_message_read(&message.message, MR_ID_LANDING, payload,
                    mr_message_find(MR_ID_LANDING)->length);
    assert_true(witness_can(witness, &message));
    witness_block(witness, 5000);
    assert_int_equal(witness_take(witness, 5000, false, &taken), WITNESS_STRANGER);
    free(witness);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_goes_on_as_the_witness),
        cmocka_unit_test(can_far_behind_is_no_stranger),
        cmocka_unit_test(the_first_second_is_remembered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
