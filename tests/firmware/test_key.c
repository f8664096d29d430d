/* The board's key: set and cleared, kept over starts and power cuts; nonces and proofs, and what a
 * stranger makes of those that he has overheard. Proofs are computed by Python in tests/cli/key.sh;
 * here it is which of them count. */
#include "tests/firmware/fake_nor.h"
#include "tests/firmware/play.h"

#include "common/crc32.h"
#include "common/splitmix.h"
#include "common/wire.h"
#include "firmware/health.h"

static uint8_t key[MR_KEY_BYTES];

/* The memory's clock goes with the blocks. */
static void pass(unsigned blocks)
{
    while (blocks--) {
        play_block();
        for (unsigned i = 0; i < 4; i++) {
            fake_nor.now_us += 250;
            app_poll(&app);
        }
    }
}

static void restart(void)
{
    fake_nor_power();
    start(NULL);
    fake.jumper = true;
    pass(600); /* and a nonce */
}

static int begin(void **state)
{
    (void)state;
    fake_nor_reset();
    for (unsigned i = 0; i < MR_KEY_BYTES; i++)
        key[i] = (uint8_t)(11 * i + 1);
    restart();
    return 0;
}

static void give(uint16_t id, const uint8_t *payload, size_t length, bool serial)
{
    struct board_can_frame *frame = &fake.received[fake.received_count];
    if (serial) {
        fake.serial_in_count += mr_frame_encode(0, id, payload, length,
                                                fake.serial_in + fake.serial_in_count);
        return;
    }
    fake.received_count++;
    frame->id = id;
    frame->length = (uint8_t)length;
    memcpy(frame->data, payload, length);
}

static void clear_inputs(void)
{
    fake.received_count = fake.received_taken = 0;
    fake.serial_in_count = fake.serial_in_taken = 0;
}

/* Its answer; 1: none within `blocks`. */
static int order(const struct mr_command *message, bool serial, unsigned blocks)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    struct mr_ack ack;
    size_t sent = fake.sent_count;
    give(MR_ID_COMMAND, payload, mr_command_put(message, payload), serial);
    for (unsigned n = 0; n < blocks; n++) {
        pass(1);
        if (last_frame(MR_ID_ACK) < fake.sent + sent || !last_frame(MR_ID_ACK))
            continue;
        GET_LAST(ack, ACK, &ack);
        clear_inputs();
        assert_int_equal(ack.code, message->code);
        return ack.status;
    }
    clear_inputs();
    return 1;
}

static int change(unsigned code, unsigned blocks)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = 0; code == MR_COMMAND_KEY_SET && i < MR_KEY_WORDS; i++) {
        struct mr_key_word word = {.index = (uint8_t)i, .tag = 5};
        const uint8_t *p = key + 4 * i;
        word.value = mr_get_u32(&p);
        give(MR_ID_KEY_WORD, payload, mr_key_word_put(&word, payload), true);
        pass(1);
    }
    return order(&(struct mr_command){.code = (uint8_t)code,
                                      .argument = (int32_t)mr_crc32(0, key, sizeof key)},
                 true, blocks);
}

static enum mr_key_state told(void)
{
    struct mr_bus_key message;
    pass(1000);
    GET_LAST(bus_key, BUS_KEY, &message);
    return (enum mr_key_state)message.state;
}

static const uint8_t *nonce(void)
{
    return last_frame(MR_ID_NONCE)->data;
}

static void prove(const struct mr_command *message, const uint8_t *by, const uint8_t *of,
                  const uint32_t uid[3], bool serial)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX], proof[MR_PROOF_BYTES];
    mr_command_put(message, payload);
    mr_proof_compute(proof, by, of, payload, uid);
    give(MR_ID_PROOF, proof, sizeof proof, serial);
}

static const struct mr_command survey = {.code = MR_COMMAND_SURVEY, .index = 3, .argument = 100};

static int order_proven(const struct mr_command *message, bool serial)
{
    prove(message, key, nonce(), app.telemetry.identity.uid, serial);
    return order(message, serial, 5);
}

/* ---- set, cleared, kept ---- */

TEST_IN(it_is_set_and_cleared_over_serial_with_the_jumper, begin, NULL)
{
    assert_int_equal(told(), MR_KEY_NONE);
    assert_int_equal(count_frames(MR_ID_NONCE), 0);
    assert_int_equal(order(&survey, false, 5), MR_OK);
    fake.jumper = false;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_JUMPER);
    fake.jumper = true;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_int_equal(told(), MR_KEY_SET);
    assert_int_equal(order(&survey, false, 5), MR_PROOF);
    assert_int_equal(order_proven(&survey, false), MR_OK);
    restart();
    assert_int_equal(told(), MR_KEY_SET);
    assert_int_equal(order(&survey, true, 5), MR_PROOF);
    assert_int_equal(order_proven(&survey, true), MR_OK);
    assert_int_equal(change(MR_COMMAND_KEY_CLEAR, 500), MR_OK);
    assert_int_equal(told(), MR_KEY_NONE);
    restart();
    assert_int_equal(told(), MR_KEY_NONE);
    assert_int_equal(order(&survey, false, 5), MR_OK);
}

TEST_IN(an_old_key_is_no_longer_in_the_memory, begin, NULL)
{
    const uint8_t *from = fake_nor.cell + KEY_FIRST_SECTOR * NOR_SECTOR_BYTES;
    uint8_t old[MR_KEY_BYTES];
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_non_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key));
    memcpy(old, key, sizeof key);
    key[0]++;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, old, sizeof old));
    assert_non_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key));
    assert_int_equal(change(MR_COMMAND_KEY_CLEAR, 500), MR_OK);
    assert_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key));
}

TEST_IN(a_key_that_did_not_come_whole_is_not_taken, begin, NULL)
{
    const struct mr_command set = {.code = MR_COMMAND_KEY_SET};
    assert_int_equal(order(&set, true, 5), MR_TOO_FEW);
    key[7]++;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_int_equal(order(&set, true, 5), MR_TOO_FEW); /* the words were used up */
}

/* Without a memory, or with one that stays busy: no key, and that is said. */
TEST_IN(without_a_memory_there_is_none, begin, NULL)
{
    for (unsigned stuck = 0; stuck < 2; stuck++) {
        fake_nor.present = stuck;
        fake_nor.stuck = stuck;
        start(NULL);
        fake.jumper = true;
        assert_int_equal(told(), MR_KEY_NO_MEMORY);
        assert_int_equal(app.box.state, stuck ? MR_BOX_FAILED : MR_BOX_MISSING);
        assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_IO);
        assert_int_equal(order(&survey, false, 5), MR_OK);
    }
}

/* What the black box had there in the time of an older image is no key; a key that does not hold
 * any more is one, and nobody orders. */
TEST_IN(what_is_no_key_is_told_from_one_that_is_damaged, begin, NULL)
{
    uint8_t *at = fake_nor.cell + KEY_FIRST_SECTOR * NOR_SECTOR_BYTES;
    memset(at, 0x42, KEY_COPIES * NOR_SECTOR_BYTES);
    restart();
    assert_int_equal(told(), MR_KEY_NONE);
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    uint8_t *found = memmem(at, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key);
    found[5] &= 0xf0;
    restart();
    assert_int_equal(told(), MR_KEY_DAMAGED);
    assert_int_equal(order(&survey, true, 5), MR_PROOF);
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_int_equal(order(&survey, true, 5), MR_PROOF);
    restart();
    assert_int_equal(order_proven(&survey, true), MR_OK);
}

/* Wherever a byte of it is lost, its mark included, nobody orders without a proof. */
TEST_IN(no_lost_byte_opens_the_bus, begin, NULL)
{
    uint8_t *at = fake_nor.cell + KEY_FIRST_SECTOR * NOR_SECTOR_BYTES;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    uint8_t *found = memmem(at, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key);
    at += (found - at) / NOR_SECTOR_BYTES * NOR_SECTOR_BYTES;
    for (unsigned i = 0; i < 60; i++) {
        uint8_t kept = at[i];
        at[i] = 0;
        restart();
        assert_int_not_equal(told(), MR_KEY_NONE);
        assert_int_equal(order(&survey, true, 5), MR_PROOF);
        at[i] = kept;
    }
}

TEST_IN(a_mistake_in_reading_opens_no_bus, begin, NULL)
{
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    fake_nor.faults = FAKE_NOR_READ_ERROR;
    fake_nor.from = KEY_FIRST_SECTOR * NOR_SECTOR_BYTES;
    fake_nor.to = fake_nor.from + NOR_PAGE_BYTES;
    for (unsigned i = 0; i < 20; i++) {
        restart();
        assert_int_not_equal(app.keystore.state, MR_KEY_NOT_READ);
        assert_int_not_equal(order(&survey, false, 5), MR_OK);
    }
}

/* The power goes in each operation of a change, at several times of it: the old key holds or the
 * new one, and none is open that was not. */
TEST_IN(a_power_cut_leaves_a_key, begin, NULL)
{
    unsigned old_ones = 0, new_ones = 0;
    for (unsigned cut = 1; cut <= 5; cut++) {
        for (unsigned permille = 0; permille <= 1000; permille += 100) {
            begin(NULL);
            assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
            uint8_t old[MR_KEY_BYTES];
            memcpy(old, key, sizeof key);
            key[1]++;
            fake_nor.cut_at = fake_nor.operations + cut;
            fake_nor.cut_permille = permille;
            (void)change(MR_COMMAND_KEY_SET, 300);
            restart();
            assert_int_equal(app.keystore.state, MR_KEY_SET);
            bool is_new = memcmp(app.keystore.key, key, sizeof key) == 0;
            assert_true(is_new || memcmp(app.keystore.key, old, sizeof old) == 0);
            old_ones += !is_new;
            new_ones += is_new;
        }
    }
    assert_true(old_ones > 10);
    assert_true(new_ones > 10);
}

/* The power goes before the old copy is erased, and the new one is damaged later: the old key is
 * not in force again. */
TEST_IN(an_old_key_does_not_come_back_after_a_power_cut, begin, NULL)
{
    const uint8_t *from = fake_nor.cell + KEY_FIRST_SECTOR * NOR_SECTOR_BYTES;
    uint8_t old[MR_KEY_BYTES];
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    memcpy(old, key, sizeof key);
    key[1]++;
    fake_nor.cut_at = fake_nor.operations + 3; /* erase, program, erase */
    fake_nor.cut_permille = 0;
    (void)change(MR_COMMAND_KEY_SET, 300);
    assert_non_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, old, sizeof old));
    restart();
    assert_int_equal(told(), MR_KEY_SET);
    assert_null(memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, old, sizeof old));
    assert_int_equal(order_proven(&survey, true), MR_OK);
    uint8_t *found = memmem(from, KEY_COPIES * NOR_SECTOR_BYTES, key, sizeof key);
    found[5] &= 0xf0;
    restart();
    assert_int_equal(told(), MR_KEY_DAMAGED);
}

/* ---- nonces ---- */

TEST_IN(no_nonce_comes_twice, begin, NULL)
{
    static uint64_t seen[2000];
    unsigned count = 0;
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    for (unsigned i = 0; i < 40; i++) {
        if (i % 10 == 5) { /* the same key again */
            assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
        }
        if (i % 10 == 7) {
            assert_int_equal(change(MR_COMMAND_KEY_CLEAR, 500), MR_OK);
            assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
        }
        pass(1000);
        for (unsigned k = 0; k < 5; k++)
            assert_int_equal(order_proven(&survey, k % 2), MR_OK);
        for (size_t f = 0; f < fake.sent_count; f++) {
            if (fake.sent[f].id != MR_ID_NONCE)
                continue;
            memcpy(&seen[count], fake.sent[f].data, sizeof seen[count]);
            for (unsigned other = 0; other < count; other++)
                assert_true(seen[other] != seen[count]);
            count++;
        }
        restart();
    }
    assert_true(count > 200);
}

TEST_IN(starts_that_can_no_longer_be_counted_close_the_bus, begin, NULL)
{
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    uint8_t *page = fake_nor.cell +
                    (KEY_FIRST_SECTOR + app.keystore.valid_copy) * NOR_SECTOR_BYTES +
                    NOR_PAGE_BYTES;
    memset(page, 0, 15 * NOR_PAGE_BYTES);
    page[15 * NOR_PAGE_BYTES - 1] = 0x80; /* one is left */
    restart();
    assert_int_equal(app.keystore.state, MR_KEY_SET);
    assert_int_equal(app.keystore.start_count, 30720);
    restart();
    assert_int_equal(app.keystore.state, MR_KEY_DAMAGED);
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    assert_int_equal(told(), MR_KEY_SET);
}

/* ---- a stranger's day ---- */

static int keyed(void **state)
{
    begin(state);
    assert_int_equal(change(MR_COMMAND_KEY_SET, 500), MR_OK);
    pass(1000);
    return 0;
}

TEST_IN(a_proof_is_for_one_order_once, keyed, NULL)
{
    const uint32_t *uid = app.telemetry.identity.uid;
    const uint32_t other_uid[3] = {uid[0], uid[1], uid[2] + 1};
    struct mr_command other = survey;
    uint8_t old[MR_PROOF_BYTES], other_key[MR_KEY_BYTES];
    memcpy(old, nonce(), sizeof old);
    memcpy(other_key, key, sizeof key);
    other_key[31] ^= 1;
    other.argument++;

    prove(&other, key, nonce(), uid, false); /* of another order */
    assert_int_equal(order(&survey, false, 5), MR_PROOF);
    prove(&survey, other_key, nonce(), uid, false);
    assert_int_equal(order(&survey, false, 5), MR_PROOF);
    assert_int_equal(order_proven(&survey, false), MR_OK);
    assert_int_equal(order(&survey, false, 5), MR_PROOF); /* with the same one */
    prove(&survey, key, old, uid, false);                 /* overheard, and said again */
    assert_int_equal(order(&survey, false, 5), MR_PROOF);
    prove(&survey, key, nonce(), other_uid, false);
    assert_int_equal(order(&survey, false, 5), MR_PROOF);
    assert_int_equal(order_proven(&survey, true), MR_OK);
    memcpy(old, nonce(), sizeof old);
    pass(1000); /* a second later */
    prove(&survey, key, old, uid, true);
    assert_int_equal(order(&survey, true, 5), MR_PROOF);
    prove(&survey, key, nonce(), uid, false); /* by the other link */
    assert_int_equal(order(&survey, true, 5), MR_PROOF);
    assert_int_equal(app.proof.refused_count, 6); /* the last one for the proof before */
}

/* A proof with one wrong bit in any of its bytes is none; right ones in between avoid the
 * lockout. */
TEST_IN(each_byte_of_a_proof_counts, keyed, NULL)
{
    for (unsigned byte = 0; byte < MR_PROOF_BYTES; byte++) {
        uint8_t payload[MR_MESSAGE_BYTES_MAX], proof[MR_PROOF_BYTES];
        mr_command_put(&survey, payload);
        mr_proof_compute(proof, key, nonce(), payload, app.telemetry.identity.uid);
        proof[byte] ^= 1;
        give(MR_ID_PROOF, proof, sizeof proof, false);
        assert_int_equal(order(&survey, false, 5), MR_PROOF);
        assert_int_equal(order_proven(&survey, false), MR_OK);
    }
}

/* What was refused for the state is not obeyed later, when a stranger says it again. */
TEST_IN(a_proof_of_what_was_refused_is_used_up, keyed, NULL)
{
    struct mr_command arm = {.code = MR_COMMAND_ARM}, disarm = {.code = MR_COMMAND_DISARM};
    for (unsigned n = 0; n < 2000 && blackbox_check_ready(&app.box) != MR_OK; n++)
        pass(1);
    assert_int_equal(order_proven(&arm, true), MR_OK);
    prove(&arm, key, nonce(), app.telemetry.identity.uid, false);
    struct board_can_frame overheard = fake.received[0];
    assert_int_equal(order(&arm, false, 5), MR_NOT_NOW);
    assert_int_equal(order_proven(&disarm, true), MR_OK);
    give(MR_ID_PROOF, overheard.data, overheard.length, false);
    assert_int_equal(order(&arm, false, 5), MR_PROOF);
    assert_int_equal(app.landing.state, MR_LANDING_IDLE);
}

/* Three wrong ones cost the link a second, or what is left of the one begun too; not the other
 * link. */
TEST_IN(three_wrong_proofs_cost_a_second, keyed, NULL)
{
    const uint32_t *uid = app.telemetry.identity.uid;
    uint8_t other_key[MR_KEY_BYTES] = {0};
    for (unsigned i = 0; i < 3; i++) {
        prove(&survey, other_key, nonce(), uid, false);
        assert_int_equal(order(&survey, false, 5), MR_PROOF);
    }
    assert_int_equal(order_proven(&survey, false), MR_LOCKOUT);
    assert_int_equal(order_proven(&survey, true), MR_OK);
    pass(990);
    assert_int_equal(order_proven(&survey, false), MR_LOCKOUT);
    pass(1010);
    assert_int_equal(order_proven(&survey, false), MR_OK);
}

/* A stranger's order between a proof and its own takes it from nobody. */
TEST_IN(a_proof_waits_for_its_order, keyed, NULL)
{
    const struct mr_command disarm = {.code = MR_COMMAND_DISARM};
    prove(&survey, key, nonce(), app.telemetry.identity.uid, false);
    assert_int_equal(order(&disarm, false, 5), MR_PROOF);
    assert_int_equal(order(&survey, false, 5), MR_OK);
}

/* A day of guesses, as many as two a block from CAN: three a second are looked at. */
TEST_IN(guesses_are_looked_at_three_times_a_second, keyed, NULL)
{
    uint64_t random = 1;
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    unsigned obeyed = 0;
    for (unsigned n = 0; n < 20000; n++) {
        uint64_t guess = mr_splitmix64(&random);
        give(MR_ID_PROOF, (const uint8_t *)&guess, sizeof guess, false);
        give(MR_ID_COMMAND, payload, mr_command_put(&survey, payload), false);
        pass(1);
        clear_inputs();
    }
    for (size_t f = 0; f < fake.sent_count; f++)
        obeyed += fake.sent[f].id == MR_ID_ACK && (int8_t)fake.sent[f].data[1] == MR_OK;
    assert_int_equal(obeyed, 1); /* key-set */
    assert_in_range(app.proof.refused_count, 3, 3 * 21);
}
