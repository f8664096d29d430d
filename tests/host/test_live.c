/* The live view without a browser: buckets of messages and records, the hub's ring, snapshot and
 * orders. What the page makes of the messages: tests/browser/live.py. */
#include "tests/cmocka_all.h"

#include <pthread.h>
#include <string.h>
#include <unistd.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/live/buckets.h"
#include "host/live/hub.h"
#include "host/live/server.h"
#include "tests/host/stream.h"

#define NOW_US 1700000000000000

/* ---- helpers ---- */

/* What the collector makes of a frame whose block, -1: not known, is this. */
static struct collector_event event_of(enum link_kind kind, struct mr_message *message,
                                       int64_t host_us, int64_t block)
{
    return (struct collector_event){.link = kind,
                                    .message = message,
                                    .host_us = (uint64_t)host_us,
                                    .board_us = block < 0 ? STORE_NONE : 1000 * block};
}

static void say(struct live_buckets *buckets, enum link_kind kind, uint16_t id,
                const uint8_t *payload, size_t length, int64_t block)
{
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, id, payload, length), MR_OK);
    live_buckets_advance(buckets, kind, block);
    live_buckets_add_message(buckets, &message, block);
}

static void say_to_hub(struct live_hub *hub, uint16_t id, const uint8_t *payload, size_t length,
                       int64_t block)
{
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, id, payload, length), MR_OK);
    const struct collector_event event = event_of(LINK_CAN, &message, NOW_US, block);
    live_hub_add_message(hub, &event);
}

#define MESSAGE(model, kind, name, NAME, block, ...)                                  \
    do {                                                                              \
        uint8_t payload_[MR_MESSAGE_BYTES_MAX];                                       \
        size_t length_ = mr_##name##_put(&(struct mr_##name){__VA_ARGS__}, payload_); \
        say(model, kind, MR_ID_##NAME, payload_, length_, block);                     \
    } while (0)

static struct live_buckets *model_made(void)
{
    struct live_buckets *model = malloc(sizeof *model);
    assert_non_null(model);
    live_buckets_init(model);
    MESSAGE(model, LINK_SERIAL, hello, HELLO, -1, .layout = MR_LAYOUT);
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++) {
        struct mr_channel_config c = stream_channel(i);
        MESSAGE(model, LINK_SERIAL, channel, CHANNEL, -1, .index = (uint8_t)i, .kind = c.kind,
                .station_ft = c.station_ft, .unit_per_code = c.unit_per_code);
        MESSAGE(model, LINK_SERIAL, channel_zero, CHANNEL_ZERO, -1, .index = (uint8_t)i,
                .number = c.number, .band = c.band, .zero_code = c.zero_code);
        for (unsigned item = 0; item < MR_CALIBRATION_FIRST_POINT_ITEM; item++)
            MESSAGE(model, LINK_SERIAL, calibration, CALIBRATION, -1, .index = (uint8_t)i,
                    .item = (uint8_t)item, .value = mr_channel_get_item(&c, item));
    }
    return model;
}

/* A record in which every transducer reads `inches` and every gage `pounds`. */
static void put_record(struct live_buckets *model, uint32_t index, double inches, double pounds)
{
    double d[MR_TRANSDUCERS], t[MR_GAGES];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        d[i] = inches;
    for (unsigned i = 0; i < MR_GAGES; i++)
        t[i] = pounds;
    struct mr_block block = stream_block(index, d, t);
    live_buckets_advance(model, LINK_SERIAL, index);
    live_buckets_add_record(model, &block);
}

static unsigned take_all(struct live_buckets *model, struct live_bucket *buckets, unsigned most)
{
    live_buckets_close_complete(model);
    return live_buckets_pop(model, buckets, most);
}

/* ---- readings ---- */

/* x(t) of the closed form: a ramp of a thousandth of an inch a block, and one block of it a
 * spike. */
static double inches_at(uint32_t block)
{
    return block == 517 ? 2.0 : 0.001 * (double)block;
}

TEST(one_block_of_a_thousand_is_not_lost)
{
    static struct live_bucket buckets[100];
    struct live_buckets *model = model_made();
    for (uint32_t block = 0; block < 1000; block++)
        put_record(model, block, inches_at(block), 100.0 - 0.01 * (double)block);
    MESSAGE(model, LINK_CAN, clock, CLOCK, 1100, .block = 1100);
    MESSAGE(model, LINK_SERIAL, clock, CLOCK, 1100, .block = 1100);
    assert_int_equal(take_all(model, buckets, 100), 50);
    for (int64_t b = 0; b < 50; b++) {
        double least = 1e9, most = -1e9;
        for (uint32_t block = 20 * (uint32_t)b; block < 20 * ((uint32_t)b + 1); block++) {
            least = fmin(least, inches_at(block));
            most = fmax(most, inches_at(block));
        }
        assert_int_equal(buckets[b].number, b);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            /* half a step of the converter's sums: 0.0002 in */
            assert_near(buckets[b].min[i], least, 0.00021);
            assert_near(buckets[b].max[i], most, 0.00021);
        }
        for (unsigned i = MR_TRANSDUCERS; i < LIVE_CHANNEL_COUNT; i++) {
            assert_near(buckets[b].max[i], 100.0 - 0.2 * (double)b, 0.011);
            assert_near(buckets[b].min[i], 100.0 - 0.2 * (double)b - 0.19, 0.011);
        }
    }
    assert_int_equal(model->late_reading_count, 0);
    assert_near(model->reading[3].max, 2.0, 0.00021);
    free(model);
}

TEST(can_fills_what_serial_does_not_bring)
{
    struct live_bucket buckets[200];
    struct live_buckets *model = model_made();
    for (uint32_t block = 0; block < 1000; block++) {
        if (block < 400)
            put_record(model, block, 0.5, 100.0);
        if (block % 2 == 0) /* while records come it says nothing, here what would be seen */
            MESSAGE(model, LINK_CAN, displacement_1_3, DISPLACEMENT_1_3, block, .d1_in = 1.0f,
                    .d2_in = 1.0f, .d3_in = (float)NAN, .block16 = (uint16_t)block);
    }
    MESSAGE(model, LINK_CAN, clock, CLOCK, 1200, .block = 1200);
    unsigned count = take_all(model, buckets, 200), serial = 0, can = 0, none = 0;
    for (unsigned i = 0; i < count; i++) {
        serial += buckets[i].max[0] < 0.6f;
        can += buckets[i].min[0] > 0.9f;
        none += isnan(buckets[i].max[2]) ? 1u : 0u;
    }
    assert_int_equal(serial, 20);
    assert_int_equal(can, 20); /* from RECORD_FRESH_BLOCKS after the last record on */
    assert_int_equal(none, 20);
    assert_true(isnan(model->reading[2].value));
    free(model);
}

TEST(links_out_of_step_lose_nothing)
{
    static struct live_bucket buckets[200];
    struct live_buckets *model = model_made();
    unsigned count = 0;
    for (uint32_t block = 0; block < 2000; block++) {
        MESSAGE(model, LINK_CAN, health, HEALTH, block, .load_permille = 1);
        if (block >= 300)
            put_record(model, block - 300, 0.1, 100.0);
        if (block % 50 == 0)
            count += take_all(model, buckets + count, 200 - count);
    }
    for (unsigned i = 0; i < count; i++)
        assert_int_equal(buckets[i].number, i);
    assert_in_range(count, 80, 85);
    assert_int_equal(model->late_reading_count, 0);
    free(model);
}

TEST(a_restart_begins_anew)
{
    struct live_buckets *model = model_made();
    for (uint32_t block = 0; block < 3000; block++)
        put_record(model, block, 0.5, 100.0);
    put_record(model, 5, 0.25, 90.0);
    assert_int_equal(model->restart_count, 1);
    assert_near(model->reading[0].value, 0.25, 0.00021);
    assert_near(model->reading[0].max, 0.25, 0.00021);
    free(model);
}

/* The board tells a channel in parts. Before the last of them its codes make no number, and why is
 * said. */
TEST(what_is_not_calibrated_is_not_read)
{
    struct live_buckets *joined = malloc(sizeof *joined);
    struct mr_channel_config c = stream_channel(0);
    assert_non_null(joined);
    live_buckets_init(joined);
    MESSAGE(joined, LINK_SERIAL, hello, HELLO, -1, .layout = MR_LAYOUT);
    assert_string_equal(live_buckets_missing_reason(joined, 0), ""); /* nothing has come */
    put_record(joined, 1, 0.5, 100.0);
    assert_string_equal(live_buckets_missing_reason(joined, 0), "calibration not received yet");
    MESSAGE(joined, LINK_SERIAL, channel, CHANNEL, -1, .index = 0, .kind = c.kind,
            .station_ft = c.station_ft, .unit_per_code = c.unit_per_code);
    MESSAGE(joined, LINK_SERIAL, channel_zero, CHANNEL_ZERO, -1, .index = 0, .number = c.number,
            .zero_code = c.zero_code);
    /* A table of two points that doubles, half of which has come. */
    const float items[] = {0, 0, 0, 0, -10, 10, 0, 2, 0, 0, 1};
    for (unsigned i = 0; i < COUNT_OF(items); i++)
        MESSAGE(joined, LINK_SERIAL, calibration, CALIBRATION, -1, .index = 0, .item = (uint8_t)i,
                .value = items[i]);
    put_record(joined, 2, 0.5, 100.0);
    assert_true(isnan(joined->reading[0].value));
    MESSAGE(joined, LINK_SERIAL, calibration, CALIBRATION, -1, .index = 0, .item = COUNT_OF(items),
            .value = 2);
    put_record(joined, 3, 0.5, 100.0);
    assert_near(joined->reading[0].value, 1.0, 0.00042);
    assert_string_equal(live_buckets_missing_reason(joined, 0), "");
    free(joined);
}

TEST(memory_is_bounded)
{
    struct live_buckets *model = model_made();
    for (uint32_t block = 0; block < 60000; block++)
        put_record(model, block, 0.5, 100.0); /* and nobody takes a bucket for a minute */
    assert_int_equal(model->closed_count, LIVE_CLOSED_BUCKETS_MAX);
    assert_true(model->late_reading_count > 2000);
    free(model);
}

/* ---- the hub ---- */

static const struct live_source source = {
    .db = "campaign.db", .can = "unix:can", .serial = "unix:serial", .accepts_commands = true};

static void hub_zone(struct live_hub *hub, int64_t block, bool warning)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    size_t length = mr_zone_put(
        &(struct mr_zone){
            .mats = 40, .start_ft = 60.0f, .end_ft = 71.4f, .block16 = (uint16_t)block},
        payload);
    say_to_hub(hub, MR_ID_ZONE, payload, length, block);
    length = mr_zone_lead_put(
        &(struct mr_zone_lead){.lead_s = 1.0f, .warning = warning, .block16 = (uint16_t)block},
        payload);
    say_to_hub(hub, MR_ID_ZONE_LEAD, payload, length, block);
}

/* The next event of a viewer that has this in it; NULL: none. To be freed. */
static char *next_with(struct live_hub *hub, struct live_viewer *viewer, const char *part)
{
    size_t length;
    char *text;
    while ((text = live_hub_wait_event(hub, viewer, 0, &length)) && !strstr(text, part))
        free(text);
    if (text)
        assert_int_equal(length, strlen(text));
    return text;
}

TEST(a_warning_is_an_event_at_once)
{
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer;
    size_t length;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    viewer = (struct live_viewer){.needs_snapshot = true};
    char *first = live_hub_wait_event(hub, &viewer, 0, &length);
    assert_non_null(first);
    assert_non_null(strstr(first, "event: configuration\n"));
    assert_null(strstr(first, "zone_lead"));
    free(first);
    assert_null(live_hub_wait_event(hub, &viewer, 0, &length));
    hub_zone(hub, 1000, true); /* no turn in between */
    char *text = next_with(hub, &viewer, "\"warning\":1");
    assert_non_null(text);
    assert_non_null(strstr(text,
                           "{\"m\":\"zone\",\"t\":1700000000000000,\"l\":0,\"b\":1000,\"mats\":40,"
                           "\"start_ft\":60,\"end_ft\":71.4,\"block16\":1000}"));
    free(text);
    live_hub_close(hub);
}

/* Sends a whole configuration, word by word. */
static void hub_configuration(struct live_hub *hub, const struct mr_config *config)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    mr_config_encode(config, image);
    for (unsigned i = 0; i < MR_CONFIG_WORDS; i++) {
        const uint8_t *p = image + 4u * i;
        size_t length = mr_config_image_put(&(struct mr_config_image){.offset = (uint16_t)i,
                                                                      .words = MR_CONFIG_WORDS,
                                                                      .value = mr_get_u32(&p)},
                                            payload);
        say_to_hub(hub, MR_ID_CONFIG_IMAGE, payload, length, -1);
    }
}

static void snapshot_has(struct live_hub *hub, const char *part)
{
    char *text = live_hub_snapshot(hub);
    assert_non_null(text);
    assert_non_null(strstr(text, part));
    free(text);
}

TEST(sensors_without_a_date_of_calibration_are_reported)
{
    static struct mr_config config;
    struct live_hub *hub;
    struct error error = {0};
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    snapshot_has(hub, "\"uncalibrated\":false"); /* nothing is known */
    config.channel[0].kind = MR_KIND_DISPLACEMENT;
    hub_configuration(hub, &config);
    snapshot_has(hub, "\"uncalibrated\":true");
    config.channel[0].calibrated_day = 20000;
    hub_configuration(hub, &config);
    snapshot_has(hub, "\"uncalibrated\":false");
    live_hub_close(hub);
}

TEST(a_notice_of_the_log_is_a_message)
{
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer = {.needs_snapshot = true};
    size_t length;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    free(live_hub_wait_event(hub, &viewer, 0, &length));
    live_hub_add_notice(hub, "another program sent \"disarm\"; the board executed it");
    live_hub_add_outcome(hub, "RUN 1: hit");
    live_hub_end(hub, "over");
    char *text = next_with(hub, &viewer, "\"m\":\"notice\"");
    assert_non_null(text);
    assert_non_null(strstr(text, "event: messages\n"));
    assert_non_null(strstr(text, "another program sent \\\"disarm\\\"; the board executed it"));
    assert_non_null(strstr(text, "\"outcome\":true,\"notice\":\"RUN 1: hit\""));
    free(text);
    live_hub_close(hub);
}

/* The newest of each message, and with what the newest warning began; nothing of a landing before
 * the one that is armed, and nothing of a board with another layout. */
TEST(a_snapshot_is_for_who_joins_late)
{
    struct live_hub *hub;
    struct error error = {0};
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    for (uint8_t i = 1; i <= 3; i++) {
        size_t length = mr_switch_place_put(
            &(struct mr_switch_place){.position = i, .station_ft = 10.0f * i}, payload);
        say_to_hub(hub, MR_ID_SWITCH_PLACE, payload, length, 10);
    }
    hub_zone(hub, 1000, false);
    hub_zone(hub, 1050, true);
    hub_zone(hub, 1100, true);
    hub_zone(hub, 1150, false);
    char *text = live_hub_snapshot(hub);
    assert_non_null(strstr(text, "\"position\":3"));
    assert_null(strstr(text, "\"block16\":1000"));
    assert_non_null(strstr(text, "\"block16\":1050"));
    assert_null(strstr(text, "\"block16\":1100"));
    assert_non_null(strstr(text, "\"block16\":1150"));
    free(text);
    size_t length = mr_landing_put(
        &(struct mr_landing){.state = MR_LANDING_ARMED, .landing = 9, .block = 1200}, payload);
    say_to_hub(hub, MR_ID_LANDING, payload, length, 1200);
    text = live_hub_snapshot(hub);
    assert_null(strstr(text, "\"block16\":1050"));
    assert_non_null(strstr(text, "\"state_text\":\"armed\",\"cause\":0"));
    free(text);
    length = mr_hello_put(&(struct mr_hello){.layout = MR_LAYOUT + 1}, payload);
    say_to_hub(hub, MR_ID_HELLO, payload, length, 1300);
    hub_zone(hub, 1350, true);
    text = live_hub_snapshot(hub);
    assert_null(strstr(text, "\"block16\":1350"));
    free(text);
    live_hub_close(hub);
}

TEST(who_does_not_read_is_told_anew)
{
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer;
    size_t length, told = 0;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    viewer = (struct live_viewer){.needs_snapshot = true};
    free(live_hub_wait_event(hub, &viewer, 0, &length));
    for (int64_t i = 0; i < 6000; i++)
        hub_zone(hub, 1000 + 50 * i, i % 2 == 0);
    char *text = live_hub_wait_event(hub, &viewer, 0, &length);
    assert_non_null(strstr(text, "event: configuration\n")); /* where it was has been forgotten */
    free(text);
    while ((text = live_hub_wait_event(hub, &viewer, 0, &length)) != NULL) {
        told++;
        free(text);
    }
    assert_int_equal(told, 0);
    live_hub_close(hub);
}

struct asking {
    struct live_hub *hub;
    enum mr_status status, answer;
};

static void *ask(void *context)
{
    struct asking *asking = context;
    asking->status = live_hub_send_command(asking->hub, MR_COMMAND_ARM, 7, INT64_MAX,
                                           &asking->answer);
    return NULL;
}

TEST(an_order_waits_for_its_own_answer)
{
    struct asking asking = {0};
    struct error error = {0};
    struct mr_command command = {0};
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    pthread_t thread;
    assert_int_equal(live_hub_open(&source, &asking.hub, &error), MR_OK);
    assert_false(live_hub_pop_command(asking.hub, &command));
    assert_int_equal(pthread_create(&thread, NULL, ask, &asking), 0);
    for (int i = 0; i < 2000 && !live_hub_pop_command(asking.hub, &command); i++)
        usleep(1000);
    assert_int_equal(command.code, MR_COMMAND_ARM);
    assert_int_equal(command.argument, 7);
    assert_false(live_hub_pop_command(asking.hub, &command)); /* once */
    /* somebody else's */
    struct mr_ack ack = {
        .code = MR_COMMAND_ARM, .status = MR_OK, .tag = (uint16_t)(command.tag + 1)};
    say_to_hub(asking.hub, MR_ID_ACK, payload, mr_ack_put(&ack, payload), 1000);
    ack = (struct mr_ack){.code = MR_COMMAND_ARM, .status = MR_NOT_NOW, .tag = command.tag};
    say_to_hub(asking.hub, MR_ID_ACK, payload, mr_ack_put(&ack, payload), 1001);
    pthread_join(thread, NULL);
    assert_int_equal(asking.status, MR_OK);
    assert_int_equal(asking.answer, MR_NOT_NOW);
    live_hub_close(asking.hub);
}

TEST(who_only_watches_gives_no_order)
{
    const struct live_source watching = {.db = "campaign.db"};
    struct live_hub *hub;
    struct error error = {0};
    enum mr_status answer;
    assert_int_equal(live_hub_open(&watching, &hub, &error), MR_OK);
    assert_int_equal(live_hub_send_command(hub, MR_COMMAND_ARM, 1, INT64_MAX, &answer), MR_NOT_NOW);
    live_hub_close(hub);
}

TEST(an_order_that_is_too_old_is_refused)
{
    struct live_hub *hub;
    struct error error = {0};
    enum mr_status answer;
    struct mr_command command;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    assert_int_equal(
        live_hub_send_command(hub, MR_COMMAND_ARM, 1, (int64_t)link_now_us() - 1, &answer),
        MR_LIMIT);
    assert_false(live_hub_pop_command(hub, &command));
    live_hub_close(hub);
}

/* ---- where it is served ---- */

TEST(other_addresses_are_refused)
{
    const char *const refused[] = {"0.0.0.0:8473",
                                   "192.168.1.5:8473",
                                   "[::]:8473",
                                   "example.org:80",
                                   "127.0.0.1:70000",
                                   "x",
                                   "",
                                   "-1",
                                   "127.0.0.1:",
                                   "127.0.0.1.example.org:1",
                                   "127.0.0.2:0"};
    struct live_hub *hub;
    struct error error = {0};
    struct live_server *server = NULL;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        assert_int_equal(live_server_open(refused[i], hub, &server, &error), MR_USAGE);
        assert_null(server);
        error = (struct error){0};
    }
    live_hub_close(hub);
}
