/* The live view without a browser: what the model makes of messages and records, the hub's ring and
 * commands, the terminal's lines. */
#include "tests/cmocka_all.h"

#include <pthread.h>
#include <string.h>
#include <unistd.h>

#include "common/command.h"
#include "host/live/hub.h"
#include "host/live/server.h"
#include "host/live/terminal.h"
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

static void say(struct live_model *model, enum link_kind kind, uint16_t id, const uint8_t *payload,
                size_t length, int64_t block)
{
    struct mr_message message;
    assert_int_equal(mr_message_read(&message, id, payload, length), MR_OK);
    const struct collector_event event = event_of(kind, &message, NOW_US + 1000 * block, block);
    live_model_message(model, &event);
}

static void say_to_hub(struct live_hub *hub, uint16_t id, const uint8_t *payload, size_t length,
                       int64_t block)
{
    struct mr_message message;
    assert_int_equal(mr_message_read(&message, id, payload, length), MR_OK);
    const struct collector_event event = event_of(LINK_CAN, &message, NOW_US, block);
    live_hub_message(hub, &event);
}

#define MESSAGE(model, kind, name, NAME, block, ...)                                  \
    do {                                                                              \
        uint8_t payload_[MR_MESSAGE_MAX];                                             \
        size_t length_ = mr_##name##_put(&(struct mr_##name){__VA_ARGS__}, payload_); \
        say(model, kind, MR_ID_##NAME, payload_, length_, block);                     \
    } while (0)

static struct live_model *model_made(void)
{
    struct live_model *model = malloc(sizeof *model);
    assert_non_null(model);
    live_model_start(model, true, true);
    MESSAGE(model, LINK_SERIAL, hello, HELLO, -1, .layout = MR_LAYOUT);
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        struct mr_channel_config c = stream_channel(i);
        MESSAGE(model, LINK_SERIAL, channel, CHANNEL, -1, .index = (uint8_t)i, .kind = c.kind,
                .station_ft = c.station_ft, .unit_per_code = c.unit_per_code);
        MESSAGE(model, LINK_SERIAL, channel_zero, CHANNEL_ZERO, -1, .index = (uint8_t)i,
                .number = c.number, .band = c.band, .zero_code = c.zero_code);
        for (unsigned item = 0; item < MR_CALIBRATION_TABLE; item++)
            MESSAGE(model, LINK_SERIAL, calibration, CALIBRATION, -1, .index = (uint8_t)i,
                    .item = (uint8_t)item, .value = mr_channel_item(&c, item));
    }
    return model;
}

/* A record in which every transducer reads `inches` and every gage `pounds`. */
static void put_record(struct live_model *model, uint32_t index, double inches, double pounds)
{
    double d[MR_TRANSDUCERS], t[MR_GAGES];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        d[i] = inches;
    for (unsigned i = 0; i < MR_GAGES; i++)
        t[i] = pounds;
    struct mr_block block = stream_block(index, d, t);
    live_model_record(model, &block, NOW_US + 1000 * (int64_t)index);
}

static void put_zone(struct live_model *model, enum link_kind kind, int64_t block, bool warning)
{
    MESSAGE(model, kind, zone, ZONE, block, .mats = warning ? 40 : 10, .start_ft = 60.0f,
            .end_ft = 71.4f, .block16 = (uint16_t)block);
    MESSAGE(model, kind, zone_lead, ZONE_LEAD, block, .lead_s = 1.5f, .wheel_ft = 30.0f,
            .warning = warning, .block16 = (uint16_t)block);
}

static unsigned take_all(struct live_model *model, struct live_bucket *buckets, unsigned most)
{
    live_model_settle(model);
    return live_model_take(model, buckets, most);
}

/* ---- readings ---- */

/* x(t) of the closed form: a ramp of a thousandth of an inch a block, and one block of it a
 * spike. */
static double inches_at(uint32_t block)
{
    return block == 517 ? 2.0 : 0.001 * (double)block;
}

static void one_block_of_a_thousand_is_not_lost(void **state)
{
    (void)state;
    static struct live_bucket buckets[100];
    struct live_model *model = model_made();
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
        assert_int_equal(buckets[b].bucket, b);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            /* half a step of the converter's sums: 0.0002 in */
            assert_near(buckets[b].least[i], least, 0.00021);
            assert_near(buckets[b].most[i], most, 0.00021);
        }
        for (unsigned i = MR_TRANSDUCERS; i < LIVE_CHANNELS; i++) {
            assert_near(buckets[b].most[i], 100.0 - 0.2 * (double)b, 0.011);
            assert_near(buckets[b].least[i], 100.0 - 0.2 * (double)b - 0.19, 0.011);
        }
    }
    assert_int_equal(model->late, 0);
    assert_near(model->reading[3].most, 2.0, 0.00021);
    free(model);
}

static void can_fills_what_serial_does_not_bring(void **state)
{
    (void)state;
    struct live_bucket buckets[200];
    struct live_model *model = model_made();
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
        serial += buckets[i].most[0] < 0.6f;
        can += buckets[i].least[0] > 0.9f;
        none += isnan(buckets[i].most[2]) ? 1u : 0u;
    }
    assert_int_equal(serial, 20);
    assert_int_equal(can, 20); /* from RECORD_FRESH_BLOCKS after the last record on */
    assert_int_equal(none, 20);
    assert_true(isnan(model->reading[2].value));
    free(model);
}

static void links_out_of_step_lose_nothing(void **state)
{
    (void)state;
    static struct live_bucket buckets[200];
    struct live_model *model = model_made();
    unsigned count = 0;
    for (uint32_t block = 0; block < 2000; block++) {
        MESSAGE(model, LINK_CAN, health, HEALTH, block, .load_permille = 1);
        if (block >= 300)
            put_record(model, block - 300, 0.1, 100.0);
        if (block % 50 == 0)
            count += take_all(model, buckets + count, 200 - count);
    }
    for (unsigned i = 0; i < count; i++)
        assert_int_equal(buckets[i].bucket, i);
    assert_in_range(count, 80, 85);
    assert_int_equal(model->late, 0);
    free(model);
}

static void a_restart_begins_anew(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    for (uint32_t block = 0; block < 3000; block++)
        put_record(model, block, 0.5, 100.0);
    put_zone(model, LINK_SERIAL, 2999, true);
    assert_true(model->warning.on);
    put_record(model, 5, 0.25, 90.0);
    assert_int_equal(model->restarts, 1);
    assert_false(model->warning.on);
    assert_near(model->reading[0].value, 0.25, 0.00021);
    assert_near(model->reading[0].most, 0.25, 0.00021);
    free(model);
}

/* The board tells a channel in parts. Before the last of them its codes make no number, and why is
 * said. */
static void what_is_not_calibrated_is_not_read(void **state)
{
    (void)state;
    struct live_model *model = model_made(), *joined = malloc(sizeof *joined);
    struct mr_channel_config c = stream_channel(0);
    assert_non_null(joined);
    assert_false(live_model_lacks_calibration(model));
    live_model_start(joined, true, true);
    MESSAGE(joined, LINK_SERIAL, hello, HELLO, -1, .layout = MR_LAYOUT);
    assert_string_equal(live_model_reading_text(joined, 0), ""); /* nothing has come */
    put_record(joined, 1, 0.5, 100.0);
    assert_string_equal(live_model_reading_text(joined, 0), "calibration not told yet");
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
    assert_string_equal(live_model_reading_text(joined, 0), "");
    assert_true(live_model_lacks_calibration(joined)); /* the others */
    free(joined);
    free(model);
}

static void memory_is_bounded(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    for (uint32_t block = 0; block < 60000; block++)
        put_record(model, block, 0.5, 100.0); /* and nobody takes a bucket for a minute */
    assert_int_equal(model->closed_count, LIVE_CLOSED_BUCKETS);
    assert_true(model->forgotten > 2000);
    free(model);
}

/* ---- warnings ---- */

static void the_newer_statement_counts(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    put_zone(model, LINK_CAN, 1000, false);
    put_zone(model, LINK_SERIAL, 1050, true);
    assert_true(model->warning.on);
    assert_int_equal(model->warning.since_us, NOW_US + 1050000);
    put_zone(model, LINK_CAN, 1000, false); /* the other link is behind: it does not end it */
    assert_true(model->warning.on);
    assert_near(live_model_gear_ft(model), 30.0, 0.01);
    put_zone(model, LINK_CAN, 1100, false);
    assert_false(model->warning.on);
    assert_int_equal(model->warning.zone.mats, 40); /* what it was is kept until the next arming */
    MESSAGE(model, LINK_SERIAL, landing, LANDING, 1200, .state = 1, .cause = 1, .landing = 9,
            .block = 1200);
    assert_int_equal(model->warning.since_us, 0);
    assert_int_equal(model->landing, 9);
    free(model);
}

static void put_verdict(struct live_model *model, int64_t block, uint8_t verdict, uint8_t reason)
{
    MESSAGE(model, LINK_CAN, zone_coming, ZONE_COMING, block, .mats = 34, .wheel_ft = 80.1f,
            .block16 = (uint16_t)block);
    MESSAGE(model, LINK_CAN, zone_press, ZONE_PRESS, block, .compression_lb = 210.0f,
            .critical_lb = 190.0f, .block16 = (uint16_t)block);
    MESSAGE(model, LINK_CAN, verdict, VERDICT, block, .verdict = verdict, .reason = reason,
            .block16 = (uint16_t)block);
}

static char *line_of(const struct live_model *model)
{
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    live_terminal_line(out, model, NOW_US, false);
    fclose(out);
    return text;
}

/* What the predictor advises is said as that, with its numbers, and is no warning. */
static void an_advisory_is_no_warning(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    MESSAGE(model, LINK_CAN, landing, LANDING, 900, .state = 2, .landing = 9, .block = 900);
    uint64_t notices = model->notices;
    put_verdict(model, 1000, 0, 0);
    assert_false(live_model_advised(model));
    put_verdict(model, 1050, 1, 2);
    assert_true(live_model_advised(model));
    assert_false(model->warning.on);
    assert_int_equal(model->verdict.since_us, NOW_US + 1050000);
    char *text = line_of(model);
    assert_non_null(strstr(text, "advisory: the model expects a closed zone ahead before the gear "
                                 "stops: 34 mats, the wheel then at 80.1 ft, zone "));
    assert_null(strstr(text, "WARNING"));
    free(text);
    put_verdict(model, 1100, 1, 3);
    text = line_of(model);
    assert_non_null(
        strstr(text, "advisory: the compression is beyond the critical one: 210 of 190 lb, zone "));
    free(text);
    /* it comes and goes: told once a reason */
    for (int64_t block = 1150; block < 3000; block += 50)
        put_verdict(model, block, block % 100 == 0, block % 100 == 0 ? 3 : 0);
    assert_int_equal(model->notices, notices + 2);
    assert_string_equal(model->notice[(model->notices - 1) % LIVE_NOTICES].text,
                        "advisory: the compression is beyond the critical one");
    put_verdict(model, 3000, 1, 3);
    put_verdict(model, 2900, 0, 0); /* the other link, behind */
    assert_true(live_model_advised(model));
    put_zone(model, LINK_CAN, 3050, true);
    text = line_of(model);
    assert_non_null(strstr(text, "WARNING"));
    assert_null(strstr(text, "advisory"));
    free(text);
    MESSAGE(model, LINK_CAN, landing, LANDING, 4000, .state = 4, .landing = 9, .block = 4000);
    assert_false(live_model_advised(model)); /* nobody predicts any more */
    MESSAGE(model, LINK_CAN, landing, LANDING, 5000, .state = 1, .landing = 10, .block = 5000);
    assert_int_equal(model->verdict.since_us, 0);
    free(model);
}

static void halves_of_two_statements_are_none(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    MESSAGE(model, LINK_CAN, zone, ZONE, 1000, .mats = 10, .start_ft = 1.0f, .end_ft = 2.0f,
            .block16 = 1000);
    MESSAGE(model, LINK_CAN, zone_lead, ZONE_LEAD, 1050, .warning = 1, .block16 = 1050);
    assert_false(model->warning.on);
    assert_int_equal(model->zone.block, -1);
    free(model);
}

static void another_layout_means_nothing(void **state)
{
    (void)state;
    struct live_model *model = malloc(sizeof *model);
    live_model_start(model, true, true);
    MESSAGE(model, LINK_CAN, hello, HELLO, 1, .layout = MR_LAYOUT + 1);
    put_zone(model, LINK_CAN, 1000, true);
    assert_false(model->hello);
    assert_false(model->warning.on);
    free(model);
}

/* ---- the hub ---- */

static const struct live_source source = {
    .db = "campaign.db", .can = "unix:can", .serial = "unix:serial", .commands = true};

static void hub_zone(struct live_hub *hub, int64_t block, bool warning)
{
    uint8_t payload[MR_MESSAGE_MAX];
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

static uint64_t id_of(const char *event)
{
    unsigned run;
    unsigned long long id;
    const char *at = strstr(event, "\nid: ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "\nid: %8x-%llu", &run, &id), 2);
    return id;
}

static void a_warning_is_an_event_at_once(void **state)
{
    (void)state;
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer;
    size_t length;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    live_hub_viewer(hub, NULL, &viewer);
    char *first = live_hub_next(hub, &viewer, 0, &length);
    assert_non_null(first);
    assert_non_null(strstr(first, "event: configuration\n"));
    assert_null(strstr(first, "\"on\":true"));
    free(first);
    assert_null(live_hub_next(hub, &viewer, 0, &length));
    hub_zone(hub, 1000, true); /* no turn in between */
    char *text = NULL;
    for (int i = 0; i < 3 && !(text && strstr(text, "\"on\":true")); i++) {
        free(text);
        text = live_hub_next(hub, &viewer, 0, &length);
        assert_non_null(text);
    }
    assert_non_null(strstr(text, "\"on\":true"));
    assert_int_equal(length, strlen(text));
    free(text);
    live_hub_close(hub);
}

static void who_comes_back_goes_on_where_it_was(void **state)
{
    (void)state;
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer, back;
    size_t length;
    char last[40];
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    for (int64_t i = 0; i < 100; i++)
        hub_zone(hub, 1000 + 50 * i, i % 2 == 0);
    live_hub_viewer(hub, NULL, &viewer);
    char *text = live_hub_next(hub, &viewer, 0, &length);
    uint64_t at = id_of(text);
    snprintf(last, sizeof last, "%.8s-%llu", strstr(text, "\nid: ") + 5,
             (unsigned long long)at - 50);
    live_hub_viewer(hub, last, &back);
    assert_false(back.fresh);
    for (uint64_t expected = at - 49; expected <= at; expected++) {
        char *event = live_hub_next(hub, &back, 0, &length);
        assert_non_null(event);
        assert_int_equal(id_of(event), expected);
        free(event);
    }
    assert_null(live_hub_next(hub, &back, 0, &length));
    /* Of another run, from the future, or no id at all: everything anew. */
    const char *const strange[] = {"00000000-5", "ffffffffffffffff", "", "x-y"};
    for (size_t i = 0; i < COUNT_OF(strange); i++) {
        live_hub_viewer(hub, strange[i], &back);
        assert_true(back.fresh);
    }
    free(text);
    live_hub_close(hub);
}

static void who_does_not_read_is_told_anew(void **state)
{
    (void)state;
    struct live_hub *hub;
    struct error error = {0};
    struct live_viewer viewer;
    size_t length, told = 0;
    assert_int_equal(live_hub_open(&source, &hub, &error), MR_OK);
    live_hub_viewer(hub, NULL, &viewer);
    free(live_hub_next(hub, &viewer, 0, &length));
    for (int64_t i = 0; i < 3000; i++)
        hub_zone(hub, 1000 + 50 * i, i % 2 == 0);
    char *text = live_hub_next(hub, &viewer, 0, &length);
    assert_non_null(strstr(text, "event: configuration\n")); /* where it was has been forgotten */
    free(text);
    while ((text = live_hub_next(hub, &viewer, 0, &length)) != NULL) {
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
    asking->status = live_hub_command(asking->hub, MR_COMMAND_ARM, 7, &asking->answer);
    return NULL;
}

static void a_command_waits_for_its_own_answer(void **state)
{
    (void)state;
    struct asking asking = {0};
    struct error error = {0};
    struct mr_command command = {0};
    uint8_t payload[MR_MESSAGE_MAX];
    pthread_t thread;
    assert_int_equal(live_hub_open(&source, &asking.hub, &error), MR_OK);
    assert_false(live_hub_take_command(asking.hub, &command));
    assert_int_equal(pthread_create(&thread, NULL, ask, &asking), 0);
    for (int i = 0; i < 2000 && !live_hub_take_command(asking.hub, &command); i++)
        usleep(1000);
    assert_int_equal(command.code, MR_COMMAND_ARM);
    assert_int_equal(command.argument, 7);
    assert_false(live_hub_take_command(asking.hub, &command)); /* once */
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

static void who_only_watches_gives_no_command(void **state)
{
    (void)state;
    const struct live_source watching = {.db = "campaign.db"};
    struct live_hub *hub;
    struct error error = {0};
    enum mr_status answer;
    assert_int_equal(live_hub_open(&watching, &hub, &error), MR_OK);
    assert_int_equal(live_hub_command(hub, MR_COMMAND_ARM, 1, &answer), MR_NOT_NOW);
    live_hub_close(hub);
}

/* ---- where it is served ---- */

static void other_addresses_are_refused(void **state)
{
    (void)state;
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
        assert_int_equal(live_server_open(refused[i], hub, NULL, &server, &error), MR_USAGE);
        assert_null(server);
        error = (struct error){0};
    }
    live_hub_close(hub);
}

/* ---- the terminal ---- */

static void draw(const struct live_model *model, unsigned columns, unsigned rows, bool colour,
                 char **text)
{
    size_t length;
    const struct live_screen screen = {.columns = columns, .rows = rows, .colour = colour};
    FILE *out = open_memstream(text, &length);
    live_terminal_draw(out, model, NOW_US + 1000 * live_model_block(model),
                       "a\033[2Jhostile\nname.db", &screen);
    fclose(out);
}

/* Longest line and number of lines, what an ANSI sequence takes not counted. */
static void measure_text(const char *text, unsigned *longest, unsigned *lines)
{
    unsigned width = 0;
    *longest = *lines = 0;
    for (const char *p = text; *p; p++) {
        if (*p == '\033') {
            assert_int_equal(p[1], '[');
            p += 2 + strcspn(p + 2, "HJKm");
        } else if (*p == '\n') {
            width = 0;
            ++*lines;
        } else if (++width > *longest) {
            *longest = width;
        }
    }
}

static void every_terminal_shows_the_warning(void **state)
{
    (void)state;
    struct live_model *model = model_made();
    unsigned longest, lines;
    char *text;
    for (uint32_t block = 0; block < 100; block++)
        put_record(model, block, 0.5, 100.0);
    put_zone(model, LINK_SERIAL, 99, true);
    const unsigned sizes[][2] = {{40, 24},  {64, 12},   {80, 24}, {131, 50},
                                 {132, 50}, {500, 100}, {1, 1},   {20, 5}};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        unsigned columns = sizes[i][0], rows = sizes[i][1];
        draw(model, columns, rows, false, &text);
        measure_text(text, &longest, &lines);
        assert_true(longest < (columns < 40 ? 40 : columns > 300 ? 300 : columns));
        assert_true(lines < (rows < 1 ? 1 : rows));
        if (rows > 5) {
            assert_non_null(strstr(text, "WARNING: JOINTS CLOSED AHEAD"));
            assert_non_null(strstr(text, "40 mats closed, 60.0 to 71.4 ft"));
            assert_non_null(strstr(text, "wheel there in 1.50 s"));
        }
        assert_null(strstr(text, "\033[2J")); /* of the name */
        assert_null(strstr(text, "\033[1"));  /* no colour asked for */
        free(text);
    }
    draw(model, 80, 24, true, &text);
    assert_non_null(strstr(text, "\033[1;30;43m"));
    assert_null(strstr(text, "advisory"));
    assert_non_null(strstr(text, "0.5000 in"));
    assert_non_null(strstr(text, "100.0 lb"));
    free(text);
    put_zone(model, LINK_SERIAL, 149, false);
    put_verdict(model, 200, 1, 3);
    draw(model, 80, 24, true, &text);
    assert_non_null(strstr(text, " advisory, no warning: 210 of 190 lb"));
    assert_non_null(strstr(text, "the compression is beyond the critical one"));
    assert_null(strstr(text, "\033[1;30;43m")); /* the warning's colours are the warning's */
    free(text);
    free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_block_of_a_thousand_is_not_lost),
        cmocka_unit_test(can_fills_what_serial_does_not_bring),
        cmocka_unit_test(links_out_of_step_lose_nothing),
        cmocka_unit_test(a_restart_begins_anew),
        cmocka_unit_test(what_is_not_calibrated_is_not_read),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(an_advisory_is_no_warning),
        cmocka_unit_test(the_newer_statement_counts),
        cmocka_unit_test(halves_of_two_statements_are_none),
        cmocka_unit_test(another_layout_means_nothing),
        cmocka_unit_test(a_warning_is_an_event_at_once),
        cmocka_unit_test(who_comes_back_goes_on_where_it_was),
        cmocka_unit_test(who_does_not_read_is_told_anew),
        cmocka_unit_test(a_command_waits_for_its_own_answer),
        cmocka_unit_test(who_only_watches_gives_no_command),
        cmocka_unit_test(other_addresses_are_refused),
        cmocka_unit_test(every_terminal_shows_the_warning),
    };
    return cmocka_run_group_tests_name("host/live", tests, NULL, NULL);
}
