/* The stored configuration: changed over either link, refused with a reason, locked, and whole
 * whenever the power goes. */
#include "tests/firmware/play.h"

#include "common/framing.h"
#include "firmware/health.h"
#include "tests/firmware/fake_flash.h"

static struct mr_config built_in;
static bool built_in_known;
static uint8_t image[MR_CONFIG_IMAGE_BYTES];
static uint16_t transfer;

/* As at reset: what the compiler put into `config` is there again. */
static void reset_board(void)
{
    config = built_in;
    fake_reset();
    app_start(&app);
    index_now = 0;
}

static int fresh(void **state)
{
    if (!built_in_known)
        built_in = config;
    built_in_known = true;
    fake_flash_reset();
    config = built_in;
    transfer = 100;
    return start(state);
}

static uint8_t fault_detail(void)
{
    return health_get_counter(MR_FAULT_CONFIG).detail;
}

static unsigned fault_count(void)
{
    return health_get_counter(MR_FAULT_CONFIG).count;
}

static void receive(uint16_t id, const uint8_t *payload, size_t length, bool serial)
{
    if (serial) {
        fake.serial_in_count += mr_frame_encode(0, id, payload, length,
                                                fake.serial_in + fake.serial_in_count);
        return;
    }
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    frame->id = id;
    frame->length = (uint8_t)length;
    memcpy(frame->data, payload, length);
}

static void forget_input(void)
{
    fake.received_count = fake.received_taken = 0;
    fake.serial_in_count = fake.serial_in_taken = 0;
}

static void send_words(unsigned from, unsigned to, bool serial)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = from; i < to; i++) {
        uint32_t value = (uint32_t)image[4 * i] | (uint32_t)image[4 * i + 1] << 8 |
                         (uint32_t)image[4 * i + 2] << 16 | (uint32_t)image[4 * i + 3] << 24;
        struct mr_config_word word = {.offset = (uint16_t)i, .tag = transfer, .value = value};
        receive(MR_ID_CONFIG_WORD, payload, mr_config_word_put(&word, payload), serial);
        if (fake.received_count == 16 || fake.serial_in_count > 300 || i + 1 == to) {
            play(16);
            forget_input();
        }
    }
}

static struct mr_ack apply(uint32_t crc, bool serial)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    struct mr_command message = {
        .code = MR_COMMAND_CONFIG_APPLY, .tag = transfer, .argument = (int32_t)crc};
    struct mr_ack ack;
    receive(MR_ID_COMMAND, payload, mr_command_put(&message, payload), serial);
    play(1);
    forget_input();
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.code, MR_COMMAND_CONFIG_APPLY);
    assert_int_equal(ack.tag, transfer);
    return ack;
}

static enum mr_status change_to(const struct mr_config *wanted, bool serial)
{
    transfer++;
    uint32_t crc = mr_config_encode(wanted, image);
    send_words(0, MR_CONFIG_WORDS, serial);
    return (enum mr_status)apply(crc, serial).status;
}

/* Another, sound configuration, one revision on. */
static struct mr_config next_one(void)
{
    struct mr_config next = config;
    next.site[0].revision++;
    next.site[0].touchdown_ft = 4.0f + (float)next.site[0].revision;
    next.gate[23].station_ft += 0.25f;
    next.band[3].yield_lb = (float)next.site[0].revision;
    return next;
}

static void is_in_force(const struct mr_config *wanted)
{
    uint8_t actual[MR_CONFIG_IMAGE_BYTES], expected[MR_CONFIG_IMAGE_BYTES];
    mr_config_encode(&config, actual);
    mr_config_encode(wanted, expected);
    assert_memory_equal(actual, expected, sizeof actual);
}

TEST_IN(what_is_built_in_is_sound, fresh, NULL)
{
    struct mr_config_violation reason;
    struct mr_config_state stored;
    unsigned before = fault_count();
    assert_int_equal(mr_config_check(&config, &reason), MR_OK);
    GET_LAST(config_state, CONFIG_STATE, &stored);
    assert_int_equal(stored.source, 0);
    assert_int_equal(stored.copy_a, 255);
    assert_int_equal(stored.revision, 0);
    assert_int_equal(fault_count(), before);
}

TEST_IN(a_change_holds, fresh, NULL)
{
    for (unsigned round = 0; round < 4; round++) {
        struct mr_config wanted = next_one();
        struct mr_board_config told;
        struct mr_config_state stored;
        struct mr_site site;
        assert_int_equal(change_to(&wanted, round % 2), MR_OK);
        is_in_force(&wanted);
        GET_LAST(board_config, BOARD_CONFIG, &told); /* told anew at once */
        GET_LAST(site, SITE, &site);
        assert_near(site.touchdown_ft, wanted.site[0].touchdown_ft, 0.0);
        assert_int_equal(told.config_crc, mr_config_encode(&wanted, image));
        assert_memory_equal(fake_flash.cell[round % 2], image, sizeof image);
        reset_board();
        is_in_force(&wanted);
        GET_LAST(board_config, BOARD_CONFIG, &told);
        assert_int_equal(told.config_crc, mr_config_encode(&wanted, image));
        GET_LAST(config_state, CONFIG_STATE, &stored);
        assert_int_equal(stored.source, 1 + round % 2);
        assert_int_equal(stored.revision, round + 1);
    }
    assert_int_equal(fake_flash.stray, 0);
    assert_int_equal(fake_flash.erases[0] + fake_flash.erases[1], 4);
}

TEST_IN(what_it_is_comes_back, fresh, NULL)
{
    struct mr_config wanted = next_one();
    uint8_t told[MR_CONFIG_IMAGE_BYTES] = {0};
    assert_int_equal(change_to(&wanted, false), MR_OK);
    uint32_t crc = mr_config_encode(&wanted, image);
    fake.sent_count = 0;
    command("config-read 5");
    play(1200);
    unsigned words = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_config_image word;
        if (fake.sent[i].id != MR_ID_CONFIG_IMAGE)
            continue;
        assert_int_equal(mr_config_image_get(&word, fake.sent[i].data, fake.sent[i].length), MR_OK);
        assert_int_equal(word.words, MR_CONFIG_WORDS);
        assert_int_equal(word.offset, 5 + words++);
        for (unsigned k = 0; k < 4; k++)
            told[4 * word.offset + k] = (uint8_t)(word.value >> 8 * k);
    }
    assert_int_equal(words, MR_CONFIG_WORDS - 5);
    assert_memory_equal(told + 20, image + 20, sizeof image - 20);
    assert_int_equal(app.configstore.crc, crc);
}

/* What follows from the configuration follows from the new one: the reading, the name of a
 * switch. */
TEST_IN(readings_are_by_the_new_one, fresh, NULL)
{
    struct mr_displacement_1_3 d;
    moved_in[0] = 0.5f;
    play(200);
    GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
    assert_near(d.d1_in, 0.5, 0.001);
    struct mr_config wanted = next_one();
    wanted.channel[0].unit_per_code *= 2.0f;
    assert_int_equal(change_to(&wanted, false), MR_OK);
    fake.sent_count = 0;
    play(200);
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != MR_ID_DISPLACEMENT_1_3)
            continue;
        assert_int_equal(mr_displacement_1_3_get(&d, fake.sent[i].data, 8), MR_OK);
        assert_true(isnan(d.d1_in) || fabsf(d.d1_in - 1.0f) < 0.002f); /* never a mean over both */
    }
    assert_near(d.d1_in, 1.0, 0.002);
}

static unsigned missing_told(unsigned position)
{
    unsigned count = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_switch_event event;
        if (fake.sent[i].id == MR_ID_SWITCH_EVENT &&
            mr_switch_event_get(&event, fake.sent[i].data, 8) == MR_OK)
            count += event.position == position && event.reason == MR_SWITCH_MISSING;
    }
    return count;
}

/* Switch 5 is not fitted, 7 is and does not open: only that one is missing. At 30 ft/s, a switch
 * each 5 ft from -2.5 ft on. */
TEST_IN(what_is_not_fitted_is_not_missing, fresh, NULL)
{
    struct mr_config wanted = next_one();
    wanted.gate[4].step_codes = 0;
    assert_int_equal(change_to(&wanted, false), MR_OK);
    play(300);
    command("arm 1");
    play(100);
    forget_input();
    double begin_s = (double)index_now * 1e-3 + 0.1;
    for (unsigned next = 1; next <= 10;) {
        double t_s = begin_s + 5.0 * (next - 1) / 30.0;
        if (next == 5 || next == 7) {
            next++;
        } else if (t_s < (double)index_now * 1e-3) {
            pass_switch(next++, t_s);
        }
        play_block();
    }
    play(100);
    assert_true(count_frames(MR_ID_MOTION) >= 5);
    assert_int_equal(missing_told(5), 0);
    assert_int_equal(missing_told(7), 1);
}

TEST_IN(a_refusal_says_why_and_changes_nothing, fresh, NULL)
{
    struct mr_config first = next_one(), wanted;
    struct mr_config_refused refused;
    assert_int_equal(change_to(&first, false), MR_OK);
    uint64_t operations = fake_flash.operations;
    wanted = next_one();
    wanted.gate[7].station_ft = -50.0f;
    assert_int_equal(change_to(&wanted, false), MR_LIMIT);
    GET_LAST(config_refused, CONFIG_REFUSED, &refused);
    assert_int_equal(refused.group, MR_GROUP_gate);
    assert_int_equal(refused.index, 7);
    assert_int_equal(refused.field, MR_FIELD_gate_station_ft);
    assert_int_equal(refused.rule, MR_RULE_NOT_RISING);
    assert_int_equal(refused.other, 0);
    wanted = next_one(); /* millimetres for inches: no transducer of the rig has such a gain */
    wanted.channel[2].unit_per_code *= 25.4f;
    assert_int_equal(change_to(&wanted, true), MR_LIMIT);
    GET_LAST(config_refused, CONFIG_REFUSED, &refused);
    assert_int_equal(refused.group, MR_GROUP_channel);
    assert_int_equal(refused.index, 2);
    assert_int_equal(refused.field, MR_FIELD_channel_unit_per_code);
    assert_int_equal(refused.rule, MR_RULE_CODE_TOO_COARSE);
    static const uint32_t others[] = {0, 1, 3}; /* 1 is in force: these were not made from it */
    for (unsigned i = 0; i < COUNT_OF(others); i++) {
        wanted = next_one();
        wanted.site[0].revision = others[i];
        assert_int_equal(change_to(&wanted, true), MR_LIMIT);
        GET_LAST(config_refused, CONFIG_REFUSED, &refused);
        assert_int_equal(refused.rule, MR_RULE_REVISION);
        assert_int_equal(refused.field, MR_FIELD_site_revision);
    }
    is_in_force(&first);
    assert_int_equal(fake_flash.operations, operations);
    /* and what is right is still taken */
    wanted = next_one();
    assert_int_equal(change_to(&wanted, false), MR_OK);
    is_in_force(&wanted);
}

TEST_IN(what_did_not_come_whole_is_refused, fresh, NULL)
{
    struct mr_config wanted = next_one();
    struct mr_config_staged staged;
    uint32_t crc = mr_config_encode(&wanted, image);
    assert_int_equal(apply(crc, false).status, MR_TOO_FEW); /* nothing at all */
    send_words(0, 40, false);
    send_words(41, MR_CONFIG_WORDS, false);
    GET_LAST(config_staged, CONFIG_STAGED, &staged);
    assert_int_equal(staged.missing, 40);
    assert_int_equal(staged.words, MR_CONFIG_WORDS - 1);
    assert_int_equal(staged.tag, transfer);
    assert_int_equal(apply(crc, false).status, MR_TOO_FEW);
    transfer++; /* another change does not complete the first */
    send_words(40, 41, false);
    assert_int_equal(apply(crc, false).status, MR_TOO_FEW);
    send_words(0, MR_CONFIG_WORDS, false);
    GET_LAST(config_staged, CONFIG_STAGED, &staged);
    assert_int_equal(staged.missing, MR_CONFIG_WORDS);
    assert_int_equal(apply(crc ^ 1u, false).status, MR_CRC);
    image[300] ^= 4;
    send_words(75, 76, false);
    assert_int_equal(apply(crc, false).status, MR_CRC);
    image[300] ^= 4;
    send_words(75, 76, false);
    is_in_force(&built_in);
    assert_int_equal(fake_flash.operations, 0);
    assert_int_equal(apply(crc, false).status, MR_OK);
    assert_int_equal(apply(crc, false).status, MR_TOO_FEW); /* once */
}

TEST_IN(it_is_locked_from_arm_to_done, fresh, NULL)
{
    struct mr_config wanted = next_one();
    struct mr_config_staged staged;
    struct mr_ack ack;
    uint32_t crc = mr_config_encode(&wanted, image);
    send_words(0, MR_CONFIG_WORDS, false); /* before, and applied after arming */
    command("arm 3");
    play(2);
    forget_input();
    assert_int_equal(apply(crc, false).status, MR_NOT_NOW);
    assert_int_equal(apply(crc, true).status, MR_NOT_NOW);
    send_words(16, 32, false);
    GET_LAST(config_staged, CONFIG_STAGED, &staged);
    assert_int_equal(staged.locked, 1);
    command("config-read");
    play(3);
    forget_input();
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    is_in_force(&built_in);
    assert_int_equal(fake_flash.operations, 0);
    command("disarm");
    play(2);
    forget_input();
    assert_int_equal(apply(crc, false).status, MR_OK);
    is_in_force(&wanted);
}

TEST_IN(a_landing_ends_the_reading_out, fresh, NULL)
{
    command("config-read");
    play(10);
    command("arm 3");
    play(2);
    fake.sent_count = 0;
    play(100);
    assert_int_equal(count_frames(MR_ID_CONFIG_IMAGE), 0);
}

TEST_IN(a_damaged_copy_falls_back_to_the_other, fresh, NULL)
{
    struct mr_config first = next_one();
    assert_int_equal(change_to(&first, false), MR_OK); /* A */
    struct mr_config second = next_one();
    assert_int_equal(change_to(&second, false), MR_OK); /* B */
    unsigned faults = fault_count();
    fake_flash.cell[1][1000] ^= 1;
    reset_board();
    is_in_force(&first);
    assert_int_equal(fault_count(), faults + 1);
    assert_int_equal(fault_detail(), 2);
    struct mr_config third = next_one();
    assert_int_equal(change_to(&third, false), MR_OK); /* over the damaged one */
    assert_memory_equal(fake_flash.cell[0] + 16, "\1\0\0\0", 4);
    fake_flash.cell[0][20] ^= 1;
    reset_board();
    is_in_force(&third);
    assert_int_equal(fault_detail(), 1);
    fake_flash.cell[1][20] ^= 1;
    reset_board();
    is_in_force(&built_in);
    assert_int_equal(fault_detail(), 3);
    assert_int_equal(fault_count(), faults + 3);
}

/* Whole and of this table, but what an older firmware took for sound: not taken. */
TEST_IN(an_unsound_copy_is_not_taken, fresh, NULL)
{
    struct mr_config wanted = next_one();
    struct mr_config_state stored;
    /* mm for in: once a limit of 1000 in per code let that pass */
    const float unsound[] = {0.0f, 25.4f * wanted.channel[0].unit_per_code};
    for (unsigned i = 0; i < COUNT_OF(unsound); i++) {
        wanted.channel[0].unit_per_code = unsound[i];
        mr_config_encode(&wanted, fake_flash.cell[0]);
        reset_board();
        struct mr_config expected = built_in;
        expected.site[0].revision = wanted.site[0].revision;
        is_in_force(&expected);
        assert_int_equal(fault_detail(), 3);
        GET_LAST(config_state, CONFIG_STATE, &stored);
        assert_int_equal(stored.copy_a, -MR_LIMIT);
    }
}

/* Of revision 41 and 57, whole, and not this firmware's: the next change is not older than what
 * another firmware would take again. A damaged one says nothing. */
TEST_IN(revisions_go_on_where_copies_were_refused, fresh, NULL)
{
    for (unsigned damaged = 0; damaged < 2; damaged++) {
        struct mr_config wanted = next_one();
        struct mr_config_state stored;
        wanted.channel[0].unit_per_code = 0.0f; /* unsound */
        wanted.site[0].revision = 41;
        mr_config_encode(&wanted, fake_flash.cell[0]);
        wanted.site[0].revision = 57;
        mr_config_encode(&wanted, fake_flash.cell[1]);
        fake_flash.cell[1][16] ^= damaged ? 0x80u : 0;
        reset_board();
        uint32_t last = damaged ? 41 : 57;
        assert_int_equal(fault_detail(), 3);
        GET_LAST(config_state, CONFIG_STATE, &stored);
        assert_int_equal(stored.revision, last);
        struct mr_config sound = next_one();
        assert_int_equal(change_to(&sound, false), MR_OK);
        assert_int_equal(config.site[0].revision, last + 1);
        reset_board();
        is_in_force(&sound);
    }
}

TEST_IN(flash_that_fails_leaves_the_old_one, fresh, NULL)
{
    struct mr_config first = next_one();
    assert_int_equal(change_to(&first, false), MR_OK);
    struct mr_config second = next_one();
    fake_flash.broken = true;
    assert_int_equal(change_to(&second, false), MR_IO);
    assert_int_equal(fault_detail(), 2);
    is_in_force(&first);
    fake_flash.broken = false;
    assert_int_equal(change_to(&second, false), MR_OK);
    is_in_force(&second);
}

/* --- the power goes --- */
static struct configstore store;
static struct telemetry telemetry;

static void restart(void)
{
    config = built_in;
    fake_flash.dark = false;
    fake_flash.cut_at = 0;
    configstore_start(&store);
}

static enum mr_status change_directly(const struct mr_config *wanted)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    uint32_t crc = mr_config_encode(wanted, image);
    transfer++;
    for (unsigned i = 0; i < MR_CONFIG_WORDS; i++) {
        struct mr_config_word word = {.offset = (uint16_t)i, .tag = transfer};
        word.value = (uint32_t)image[4 * i] | (uint32_t)image[4 * i + 1] << 8 |
                     (uint32_t)image[4 * i + 2] << 16 | (uint32_t)image[4 * i + 3] << 24;
        configstore_put_word(&store, &telemetry, payload, mr_config_word_put(&word, payload),
                             false);
    }
    fake.sent_count = fake.serial_count = 0;
    return configstore_apply(&store, &telemetry, crc);
}

/* Of each operation of a change, begun and 0, 30, 70, 99.9 % done. What is in force after it is the
 * old or the new one, whole, and the next change goes through. */
TEST_IN(the_power_goes_at_every_operation, fresh, NULL)
{
    static struct fake_flash kept;
    static const unsigned permille[] = {0, 300, 700, 999};
    unsigned olds = 0, news = 0;
    restart();
    struct mr_config old = next_one();
    assert_int_equal(change_directly(&old), MR_OK);
    old = next_one();
    assert_int_equal(change_directly(&old), MR_OK); /* both copies are in use */
    struct mr_config new = next_one();
    kept = fake_flash;
    assert_int_equal(change_directly(&new), MR_OK);
    uint64_t operations = fake_flash.operations - kept.operations;
    assert_int_equal(operations, 1 + MR_CONFIG_WORDS);
    for (uint64_t cut = 1; cut <= operations; cut++) {
        for (unsigned i = 0; i < COUNT_OF(permille); i++) {
            fake_flash = kept;
            restart();
            is_in_force(&old);
            fake_flash.cut_at = kept.operations + cut;
            fake_flash.cut_permille = permille[i];
            fake_flash.random = (uint32_t)(cut * 7919u + i);
            assert_int_not_equal(change_directly(&new), MR_OK);
            restart();
            bool is_new = config.site[0].revision == new.site[0].revision;
            is_in_force(is_new ? &new : &old);
            olds += !is_new;
            news += is_new;
            struct mr_config after = next_one();
            assert_int_equal(change_directly(&after), MR_OK);
            restart();
            is_in_force(&after);
        }
    }
    assert_int_equal(olds + news, 4 * operations);
    assert_true(olds > 3 * operations);
}

/* One change after another, the power going in most of them. */
TEST_IN(cuts_in_a_row_lose_nothing, fresh, NULL)
{
    uint32_t random = 5;
    unsigned done = 0;
    restart();
    struct mr_config now = config;
    for (unsigned round = 0; round < 500; round++) {
        struct mr_config wanted = next_one();
        random = random * 1664525u + 1013904223u;
        fake_flash.cut_at = fake_flash.operations + 1 + (random >> 8) % (MR_CONFIG_WORDS + 60);
        fake_flash.cut_permille = random >> 5 & 1023u;
        bool acknowledged = change_directly(&wanted) == MR_OK;
        restart();
        bool taken = config.site[0].revision == wanted.site[0].revision;
        assert_true(taken || !acknowledged);
        is_in_force(taken ? &wanted : &now);
        now = config;
        done += taken;
    }
    assert_true(done > 10);
}
