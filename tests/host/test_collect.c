/* The collector against hand-made streams: what it keeps, merges, misses and refuses. */
#include "tests/host/session.h"

static const struct stream_truth gentle = {.v0_ft_s = 28.0, .a_ft_s2 = 8.0, .peak_in = 0.4};

static void one_landing(struct session *session, unsigned number)
{
    struct stream_truth truth = gentle;
    stream_hello(&session->stream, MR_LAYOUT);
    stream_configuration(&session->stream);
    stream_idle(&session->stream, 500);
    stream_landing(&session->stream, &truth, number);
    stream_idle(&session->stream, 400);
}

static struct store_landing landing_of(struct session *session, int64_t run)
{
    struct store_landing landing;
    assert_int_equal(store_landing_get(session->store, run, &landing, &session->error), MR_OK);
    return landing;
}

static size_t landing_count(struct session *session)
{
    struct store_landing *rows;
    size_t count;
    assert_int_equal(store_landings_get(session->store, &rows, &count, &session->error), MR_OK);
    free(rows);
    return count;
}

static struct store_link_counts counts_of(struct session *session, int link)
{
    struct store_link_counts counts;
    bool found;
    assert_int_equal(store_link_get(session->store, 1, link, &counts, &found, &session->error),
                     MR_OK);
    assert_true(found);
    return counts;
}

TEST(both_links_make_one_landing)
{
    struct session s;
    session_begin(&s, true, true);
    one_landing(&s, 7);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    struct store_landing landing = landing_of(&s, 1);
    assert_int_equal(landing.board_landing, 7);
    assert_int_equal(landing.armed_block, 500);
    assert_int_equal(landing.state, 4);
    assert_string_equal(landing.board_uid, "000000110000002200000033");
    assert_string_equal(landing.firmware, "9.8.7");
    assert_int_equal(landing.image_crc, 0xdeadbeef);
    assert_string_equal(landing.image_commit, "c7a3136ab3a3-dirty");
    assert_near(landing.touchdown_ft, 3.0, 0.0);

    struct mr_channel_config channels[MR_CHANNELS];
    struct store_switch *places;
    struct store_segment *segments;
    size_t count;
    assert_int_equal(store_channels_get(s.store, 1, channels, &count, &s.error), MR_OK);
    assert_int_equal(count, 24);
    assert_int_equal(channels[5].number, 6);
    assert_near(channels[5].station_ft, 90.0, 0.0);
    assert_int_equal(channels[8 + 13].band, 2);
    assert_int_equal(store_switches_get(s.store, 1, &places, &count, &s.error), MR_OK);
    assert_int_equal(count, 24);
    assert_near(places[23].station_ft, 117.5, 0.0);
    free(places);
    assert_int_equal(store_segments_get(s.store, 1, &segments, &count, &s.error), MR_OK);
    assert_int_equal(count, 42);
    assert_near(segments[41].slack_in, 0.2, 1e-6);
    free(segments);

    /* The gear stops at 3 + 28^2 / 16 = 52 ft: switches at 2.5 to 47.5 ft open, 10 of them. Both
     * links told each, and serial is the record. */
    struct store_edge *edges;
    assert_int_equal(store_edges_get(s.store, 1, &edges, &count, &s.error), MR_OK);
    assert_int_equal(count, 10);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(edges[i].position, i + 1);
        assert_int_equal(edges[i].links, 1 << LINK_SERIAL);
    }
    /* Switch 2, at 7.5 ft: 4.5 = 28 t - 4 t^2, t = 0.164609..., after touchdown at 1.5 s. */
    assert_near(edges[1].board_us, 1.5e6 + 1e6 * (28.0 - sqrt(28.0 * 28.0 - 16.0 * 4.5)) / 8.0,
                0.02);
    free(edges);

    struct store_result result;
    bool found;
    assert_int_equal(store_result_get(s.store, 1, &result, &found, &s.error), MR_OK);
    assert_true(found);
    assert_near(result.speed_ft_s, 28.0, 1e-6);
    assert_near(result.stop_station_ft, 52.0, 0.001);
    assert_int_equal(result.links, 1 << LINK_SERIAL);
    assert_int_equal(counts_of(&s, LINK_CAN).lost, 0);
    assert_int_equal(counts_of(&s, LINK_SERIAL).lost, 0);
    struct store_gap *gaps;
    assert_int_equal(store_gaps_get(s.store, 1, &gaps, &count, &s.error), MR_OK);
    assert_int_equal(count, 0);
    session_end(&s);
}

static enum mr_status check_order(void *context, const uint8_t *record, size_t length, int link)
{
    (void)link;
    uint32_t *next = context;
    struct mr_block block;
    assert_int_equal(mr_block_decode(&block, record, length), MR_OK);
    assert_int_equal(block.index, (*next)++);
    return MR_OK;
}

TEST(every_block_and_frame_is_kept)
{
    struct session s;
    int64_t blocks, can;
    uint32_t next = 500;
    session_begin(&s, true, true);
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    /* Armed at 500, touchdown at 1.5 s, 3.5 s to the stop, 1 s more: blocks 500 to 5999. */
    assert_int_equal(store_blocks_count(s.store, 1, &blocks, &s.error), MR_OK);
    assert_int_equal(blocks, 5500);
    assert_int_equal(store_blocks_for_each(s.store, 1, check_order, &next, &s.error), MR_OK);
    assert_int_equal(counts_of(&s, LINK_CAN).received, s.stream.can_sent);
    assert_int_equal(counts_of(&s, LINK_SERIAL).received, s.stream.serial_sent);
    assert_int_equal(store_frames_count(s.store, 1, LINK_CAN, &can, &s.error), MR_OK);
    assert_true(can > 5500 / 2 * 3 && can < s.stream.can_sent);
    session_end(&s);
}

static enum mr_status check_times(void *context, const struct store_frame *frame)
{
    int64_t *last = context;
    if (frame->id == MR_ID_TENSION_1_3) {
        /* block16 at the end, little-endian, times 1000; this landing is before the first wrap */
        assert_int_equal(frame->board_us, 1000 * (frame->data[6] | frame->data[7] << 8));
    }
    assert_true(frame->board_us >= *last);
    *last = frame->board_us;
    return MR_OK;
}

TEST(frames_carry_board_time)
{
    struct session s;
    int64_t last = 0;
    session_begin(&s, true, false);
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    assert_int_equal(store_frames_for_each(s.store, 1, LINK_CAN, check_times, &last, &s.error),
                     MR_OK);
    assert_true(last > 5900000);
    session_end(&s);
}

TEST(time_goes_on_over_the_wrap)
{
    struct session s;
    struct stream_truth truth = gentle;
    session_begin(&s, true, true);
    s.stream.block = 63000; /* block16 wraps within the landing; TIM2 wraps at 51.1 s */
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 1000);
    stream_landing(&s.stream, &truth, 1);
    session_log(&s, "collect.db");
    struct store_edge *edges;
    struct store_zone *zones;
    size_t count;
    assert_int_equal(store_edges_get(s.store, 1, &edges, &count, &s.error), MR_OK);
    assert_int_equal(count, 10);
    for (size_t i = 0; i < count; i++)
        assert_near(edges[i].board_us, 1e6 * stream_time_s(&truth, 2.5 + 5.0 * (double)i), 0.02);
    free(edges);
    assert_int_equal(store_zones_get(s.store, 1, &zones, &count, &s.error), MR_OK);
    assert_int_equal(zones[0].block, 64049);
    assert_int_equal(zones[count - 1].block, 69499);
    free(zones);
    session_end(&s);
}

TEST(another_layout_is_refused_and_the_rest_kept)
{
    struct session s;
    int64_t frames;
    session_begin(&s, true, false);
    STREAM_CAN(&s.stream, clock, CLOCK, .block = 5, .tick = 84000 * 5);
    stream_hello(&s.stream, MR_LAYOUT + 1);
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    char wanted[80];
    snprintf(wanted, sizeof wanted, "layout %u, but this matrig uses layout %u: file:can",
             MR_LAYOUT + 1, MR_LAYOUT);
    assert_error(&s.error, MR_VERSION, wanted);
    s.error = (struct error){0};
    assert_int_equal(landing_count(&s), 0);
    assert_int_equal(store_frames_count(s.store, 1, LINK_CAN, &frames, &s.error), MR_OK);
    assert_int_equal(counts_of(&s, LINK_CAN).received, 2); /* the clock and the hello */
    session_end(&s);
}

/* Loses the 101st to 110th CAN frames of this kind. */
static bool lose_some_can(const struct stream *stream, uint16_t id)
{
    static unsigned seen;
    if (stream->block == 0)
        seen = 0;
    return id == MR_ID_DISPLACEMENT_4_6 && ++seen > 100 && seen <= 110;
}

static bool lose_some_blocks(const struct stream *stream, uint16_t type)
{
    return type == MR_ID_BLOCK && stream->block >= 2010 && stream->block < 2017;
}

TEST(losses_are_found_and_named)
{
    struct session s;
    struct store_gap *gaps;
    size_t count;
    session_begin(&s, true, true);
    s.stream.drop_can = lose_some_can;
    s.stream.drop_serial = lose_some_blocks;
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(counts_of(&s, LINK_CAN).lost, 10);
    assert_int_equal(counts_of(&s, LINK_SERIAL).lost, 7);
    assert_int_equal(store_gaps_get(s.store, 1, &gaps, &count, &s.error), MR_OK);
    assert_int_equal(count, 4);
    unsigned found = 0;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(gaps[i].message, "displacement_4_6") == 0) {
            /* recorded from block 500, every 2: the 101st is of block 700, the 110th of 718 */
            assert_int_equal(gaps[i].from_block, 700);
            assert_int_equal(gaps[i].to_block, 718);
            assert_int_equal(gaps[i].count, 10);
            found |= 1;
        }
        if (strcmp(gaps[i].message, "block") == 0) {
            assert_int_equal(gaps[i].from_block, 2010);
            assert_int_equal(gaps[i].to_block, 2016);
            assert_string_equal(gaps[i].cause, "link");
            found |= 2;
        }
        if (strcmp(gaps[i].message, "frame") == 0)
            found |= gaps[i].link == LINK_CAN ? 4 : 8;
    }
    assert_int_equal(found, 15);
    free(gaps);
    session_end(&s);
}

TEST(damaged_bytes_cost_one_frame)
{
    struct session s;
    session_begin(&s, false, true);
    one_landing(&s, 1);
    fflush(s.stream.serial);
    s.serial[s.serial_length / 2] ^= 0x55;
    session_log(&s, "collect.db");
    struct store_link_counts counts = counts_of(&s, LINK_SERIAL);
    /* a zero made or unmade splits or joins frames */
    assert_true(counts.bad >= 1 && counts.bad <= 2);
    assert_true(counts.lost >= 1 && counts.lost <= 2);
    assert_int_equal(counts.received + counts.lost, s.stream.serial_sent);
    session_end(&s);
}

TEST(truncated_serial_says_so)
{
    struct session s;
    session_begin(&s, false, true);
    one_landing(&s, 1);
    fflush(s.stream.serial);
    s.serial_length -= 3;
    size_t cut = s.serial_length;
    FILE *stream = s.stream.serial;
    s.stream.serial = NULL; /* closing it would restore the length */
    session_log(&s, "collect.db");
    assert_int_equal(s.serial_length, cut);
    assert_error(&s.error, MR_TRUNCATED, "inside a frame");
    s.error = (struct error){0};
    assert_int_equal(landing_of(&s, 1).state, 4);
    fclose(stream);
    session_end(&s);
}

/* The byte behind the n-th frame. */
static size_t behind_frame(const struct session *session, unsigned n)
{
    size_t at = 0;
    while (n)
        n -= session->serial[at++] == 0;
    return at;
}

/* A port goes away inside frame 30 and comes back where frame 34 begins: three frames and the torn
 * one are lost, and the first that comes whole is not joined to it. */
TEST(a_port_that_comes_back_begins_anew)
{
    struct session s;
    struct link_counters counters = {.fault_total = 2};
    char path[200];
    session_begin(&s, false, true);
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 500);
    fclose(s.stream.serial);
    unsigned frames = 0;
    for (size_t i = 0; i < s.serial_length; i++)
        frames += s.serial[i] == 0;
    assert_true(frames > 40);
    size_t torn = behind_frame(&s, 29) + 5, anew = behind_frame(&s, 33);
    store_open(scratch_path(path, sizeof path, "collect.db"), STORE_CREATE, &s.store, &s.error);
    store_begin(s.store, &s.error);
    collector_open(s.store, NULL, 0, "file:serial", &s.collector, &s.error);
    collector_receive_bytes(s.collector, (const uint8_t *)s.serial, torn, 1700000000000000u,
                            &s.error);
    counters.fault_count[LINK_AWAY] = counters.fault_count[LINK_BACK] = 1;
    collector_count_link_faults(s.collector, LINK_SERIAL, &counters, &s.error);
    collector_receive_bytes(s.collector, (const uint8_t *)s.serial + anew, s.serial_length - anew,
                            1700000000000000u, &s.error);
    collector_end_link(s.collector, LINK_SERIAL, &s.error);
    collector_end(s.collector, "end", &s.error);
    store_commit(s.store, &s.error);
    assert_no_error(&s.error);
    struct store_link_counts counts = counts_of(&s, LINK_SERIAL);
    assert_int_equal(counts.received, frames - 4);
    assert_int_equal(counts.lost, 4);
    assert_int_equal(counts.bad, 1);
    session_end(&s);
}

TEST(joined_late)
{
    struct session s;
    struct stream_truth truth = gentle;
    session_begin(&s, true, false);
    /* The board has been landing for a while: what comes first is a hello and the state, once a
     * second. */
    s.stream.block = 2300;
    s.stream.can_sent = 5000;
    truth.touchdown_s = 1.5;
    stream_hello(&s.stream, MR_LAYOUT);
    stream_state(&s.stream, 2, 2, 9, 1480);
    for (int i = 0; i < 1000; i++)
        stream_millisecond(&s.stream, &truth, true);
    stream_state(&s.stream, 4, 4, 9, s.stream.block);
    session_log(&s, "collect.db");
    struct store_landing landing = landing_of(&s, 1);
    assert_true(landing.armed_block == STORE_NONE);
    assert_int_equal(landing.board_landing, 9);
    assert_int_equal(landing.state, 4);
    assert_int_equal(counts_of(&s, LINK_CAN).lost, 0);
    session_end(&s);
}

TEST(board_restarts_in_mid_landing)
{
    struct session s;
    struct stream_truth truth = gentle;
    session_begin(&s, true, true);
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 3000);
    stream_state(&s.stream, 1, 1, 4, s.stream.block);
    truth.touchdown_s = 1e9;
    for (int i = 0; i < 1500; i++)
        stream_millisecond(&s.stream, &truth, true);
    s.stream.block = 0; /* the watchdog bites */
    s.stream.seq = 0;
    s.stream.can_sent = 0;
    s.stream.serial_sent = 0;
    one_landing(&s, 4);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 2);
    assert_int_equal(landing_of(&s, 1).state, 1);
    assert_int_equal(landing_of(&s, 2).state, 4);
    assert_int_equal(landing_of(&s, 2).boot, 1);
    assert_int_equal(counts_of(&s, LINK_SERIAL).lost, 0);
    assert_int_equal(counts_of(&s, LINK_CAN).lost, 0);
    session_end(&s);
}

/* The board begins again in a landing: after `before` blocks, of which the landing had 500, by the
 * watchdog. The new start says other zeros at once, and its first clock 50 ms later; `torn`: on
 * serial its hello is lost in the frame that the reset tore. */
struct new_start {
    uint32_t can_of_landing, serial_of_landing; /* messages sent in it; 0: not on that link */
    uint32_t can, serial;                       /* frames sent in both starts */
};

static struct new_start begin_anew(struct session *s, uint32_t before, bool torn)
{
    struct stream *stream = &s->stream;
    struct stream_truth truth = gentle;
    struct new_start sent = {0};
    truth.touchdown_s = 1e9;
    stream_hello(stream, MR_LAYOUT);
    stream_configuration(stream);
    stream_idle(stream, before - 500);
    uint32_t can = stream->can_sent, serial = stream->serial_sent;
    stream_state(stream, 1, 1, 4, stream->block);
    for (int i = 0; i < 500; i++)
        stream_millisecond(stream, &truth, true);
    sent.can_of_landing = stream->can_sent - can;
    sent.serial_of_landing = stream->serial_sent - serial - 500; /* block records apart */
    sent.can = stream->can_sent;
    sent.serial = stream->serial_sent;
    stream->block = stream->can_sent = stream->serial_sent = 0;
    stream->seq = 0;
    stream->host_us += 50000;
    if (torn) {
        static const uint8_t half[] = {9, 8, 7, 6};
        fwrite(half, 1, sizeof half, stream->serial);
    }
    STREAM_BOTH(stream, hello, HELLO, .layout = MR_LAYOUT, .major = 9, .minor = 8, .patch = 7,
                .reset_cause = MR_RESET_PIN | MR_RESET_WATCHDOG);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        STREAM_BOTH(stream, channel_zero, CHANNEL_ZERO, .index = (uint8_t)i,
                    .number = (uint8_t)(i + 1), .zero_code = 999.0f);
    stream_idle(stream, 1500);
    sent.can += stream->can_sent;
    sent.serial += stream->serial_sent;
    return sent;
}

static void new_start_is_apart(bool can, bool serial, uint32_t before, bool torn)
{
    struct session s;
    struct mr_channel_config channels[MR_CHANNELS];
    struct store_fault *restarts;
    size_t count;
    int64_t frames;
    session_begin(&s, can, serial);
    struct new_start sent = begin_anew(&s, before, torn);
    session_log(&s, "start.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    assert_int_equal(landing_of(&s, 1).state, 1);
    for (int link = 0; link < LINK_KINDS; link++) {
        bool used = link == LINK_CAN ? can : serial;
        assert_int_equal(store_frames_count(s.store, 1, link, &frames, &s.error), MR_OK);
        assert_int_equal(frames, !used              ? 0
                                 : link == LINK_CAN ? sent.can_of_landing
                                                    : sent.serial_of_landing);
        if (!used)
            continue;
        bool lost = torn && link == LINK_SERIAL;
        assert_int_equal(counts_of(&s, link).received,
                         (link == LINK_CAN ? sent.can : sent.serial) - lost);
        assert_int_equal(counts_of(&s, link).lost, lost);
        assert_int_equal(counts_of(&s, link).foreign, 0);
        assert_int_equal(counts_of(&s, link).dropped, 0);
    }
    /* one start of the board, whichever link brought it, and the landing that it ended */
    assert_int_equal(store_restarts_get(s.store, 1, &restarts, &count, &s.error), MR_OK);
    assert_int_equal(count, 1);
    assert_int_equal(restarts[0].detail, torn && !can ? 0 : MR_RESET_PIN | MR_RESET_WATCHDOG);
    free(restarts);
    /* the landing keeps the zeros that it was measured with */
    assert_int_equal(store_channels_get(s.store, 1, channels, &count, &s.error), MR_OK);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_near(channels[i].zero_code, STREAM_ZERO_CODE, 0.0);
    session_end(&s);
}

TEST(frames_of_a_new_start_are_not_of_the_landing_before)
{
    new_start_is_apart(true, true, 3500, false);
    new_start_is_apart(true, false, 3500, false);
    new_start_is_apart(false, true, 3500, false);
}

TEST(nor_when_the_first_hello_is_torn)
{
    new_start_is_apart(true, true, 3500, true);
    new_start_is_apart(false, true, 3500, true);
}

/* Less than a second after the last start: no clock goes back by much. */
TEST(nor_when_the_board_begins_again_at_once)
{
    new_start_is_apart(true, true, 800, false);
    new_start_is_apart(true, false, 800, false);
    new_start_is_apart(false, true, 800, true);
}

/* A hello of a stranger on CAN, and its clock, are no start of the board. */
TEST(hello_of_a_stranger_is_no_start)
{
    struct session s;
    struct stream_truth truth = gentle;
    struct store_fault *restarts;
    size_t count;
    int64_t frames;
    session_begin(&s, true, false);
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 3000);
    uint32_t before = s.stream.can_sent;
    stream_state(&s.stream, 1, 1, 4, s.stream.block);
    truth.touchdown_s = 1e9;
    for (int i = 0; i < 500; i++) {
        if (i % 150 == 40) {
            STREAM_CAN(&s.stream, hello, HELLO, .layout = MR_LAYOUT, .major = 9, .minor = 8,
                       .patch = 7);
            STREAM_CAN(&s.stream, clock, CLOCK, .block = (uint32_t)i, .tick = 12345);
        }
        stream_millisecond(&s.stream, &truth, true);
    }
    uint32_t sent = s.stream.can_sent - before;
    session_log(&s, "stranger.db");
    assert_no_error(&s.error);
    assert_int_equal(store_restarts_get(s.store, 1, &restarts, &count, &s.error), MR_OK);
    assert_int_equal(count, 0);
    free(restarts);
    assert_int_equal(store_frames_count(s.store, 1, LINK_CAN, &frames, &s.error), MR_OK);
    assert_int_equal(frames, sent);
    session_end(&s);
}

/* Scans that stand: the board goes round its regular messages with small block numbers and tick 0.
 * No new start of it. */
TEST(standing_scans_are_no_restart)
{
    struct session s;
    struct stream_truth truth = gentle;
    session_begin(&s, true, true);
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 3000);
    stream_state(&s.stream, 1, 1, 4, s.stream.block);
    truth.touchdown_s = 1e9;
    for (int i = 0; i < 500; i++)
        stream_millisecond(&s.stream, &truth, true);
    STREAM_BOTH(&s.stream, clock, CLOCK, .block = 3, .tick = 0);
    stream_state(&s.stream, 4, 4, 4, s.stream.block);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    assert_int_equal(landing_of(&s, 1).state, 4);
    session_end(&s);
}

TEST(one_link_silent)
{
    struct session s;
    struct store_gap *gaps;
    size_t count;
    session_begin(&s, true, true);
    one_landing(&s, 1);
    fflush(s.stream.can);
    s.can[0] = '\0'; /* nothing at all comes over CAN */
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(store_gaps_get(s.store, 1, &gaps, &count, &s.error), MR_OK);
    assert_int_equal(count, 1);
    assert_string_equal(gaps[0].cause, "silence");
    assert_int_equal(gaps[0].link, LINK_CAN);
    assert_int_equal(gaps[0].from_block, 500);
    free(gaps);
    session_end(&s);
}

static bool cut_after_2500(const struct stream *stream, uint16_t id)
{
    (void)id;
    return stream->block > 2500;
}

TEST(one_link_cut_in_mid_landing)
{
    struct session s;
    struct store_gap *gaps;
    size_t count;
    session_begin(&s, true, true);
    s.stream.drop_can = cut_after_2500;
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_of(&s, 1).state, 4); /* the other link saw the end */
    assert_int_equal(store_gaps_get(s.store, 1, &gaps, &count, &s.error), MR_OK);
    assert_int_equal(count, 1);
    assert_string_equal(gaps[0].cause, "silence");
    assert_true(gaps[0].count == STORE_NONE); /* nobody can say how many */
    assert_int_equal(gaps[0].from_block, 2500);
    assert_int_equal(gaps[0].to_block, 5999);
    free(gaps);
    session_end(&s);
}

TEST(two_landings_in_turn)
{
    struct session s;
    session_begin(&s, true, true);
    one_landing(&s, 4);
    struct stream_truth truth = gentle;
    stream_state(&s.stream, 0, 1, 4, s.stream.block);
    stream_landing(&s.stream, &truth, 5);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 2);
    assert_int_equal(landing_of(&s, 1).state, 4);
    assert_int_equal(landing_of(&s, 2).board_landing, 5);
    assert_int_equal(collector_pop_finished_run(s.collector), 1);
    assert_int_equal(collector_pop_finished_run(s.collector), 2);
    assert_int_equal(collector_pop_finished_run(s.collector), 0);
    session_end(&s);
}

TEST(others_on_the_bus_are_kept_apart)
{
    struct session s;
    session_begin(&s, true, false);
    stream_hello(&s.stream, MR_LAYOUT);
    fputs(
        "(1.0) can0 7AA#0102\n(1.0) can0 1F0#01\n(1.0) can0 00000080#0000000000000000\n(1.0) can0 "
        "400#0200000005000000\n",
        s.stream.can);
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    struct store_link_counts counts = counts_of(&s, LINK_CAN);
    assert_int_equal(counts.foreign,
                     /* unknown, wrong length, extended; the command is somebody's to the board */
                     3);
    assert_int_equal(counts.lost, 0);
    assert_int_equal(counts.received, s.stream.can_sent);
    session_end(&s);
}

/* ---- serial is the record, CAN fills ---- */

static bool lose_edges_on_serial(const struct stream *stream, uint16_t type)
{
    return type == MR_ID_EDGE && stream->block < 2200;
}

TEST(can_fills_what_serial_lost)
{
    struct session s;
    struct store_edge *edges;
    size_t count;
    session_begin(&s, true, true);
    s.stream.drop_serial = lose_edges_on_serial;
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_in_range(counts_of(&s, LINK_SERIAL).lost, 1, 10);
    assert_int_equal(store_edges_get(s.store, 1, &edges, &count, &s.error), MR_OK);
    assert_int_equal(count, 10);
    assert_int_equal(edges[0].links, 1 << LINK_CAN);
    assert_true(edges[9].links & 1 << LINK_SERIAL);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(edges[i].position, i + 1);
    free(edges);
    session_end(&s);
}

static bool cut_serial_after_2500(const struct stream *stream, uint16_t type)
{
    (void)type;
    return stream->block > 2500;
}

TEST(can_is_the_record_when_serial_falls_silent)
{
    struct session s;
    struct store_edge *edges;
    struct store_result result;
    size_t count;
    bool found;
    session_begin(&s, true, true);
    s.stream.drop_serial = cut_serial_after_2500;
    one_landing(&s, 1);
    session_log(&s, "collect.db");
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    assert_int_equal(landing_of(&s, 1).state, 4);
    assert_int_equal(store_edges_get(s.store, 1, &edges, &count, &s.error), MR_OK);
    assert_int_equal(count, 10); /* also of the second in which CAN was not obeyed yet */
    free(edges);
    assert_int_equal(store_result_get(s.store, 1, &result, &found, &s.error), MR_OK);
    assert_true(found);
    session_end(&s);
}

/* ---- who speaks ---- */

/* The second board says hello by its own name, with the first one's firmware. */
static void swap_board(struct stream *stream)
{
    STREAM_BOTH(stream, hello, HELLO, .layout = MR_LAYOUT, .major = 9, .minor = 8, .patch = 7);
    STREAM_BOTH(stream, board_uid, BOARD_UID, .uid0 = 0x44, .uid1 = 0x22);
}

TEST(another_board_on_serial_asks_for_a_new_log)
{
    struct session s;
    session_begin(&s, false, true);
    one_landing(&s, 1);
    s.stream.seq = 0;
    s.stream.block = 0;
    swap_board(&s.stream);
    session_log(&s, "collect.db");
    assert_error(&s.error, MR_IO,
                 "the link now has a different board than at the start of this log");
    s.error = (struct error){0};
    assert_int_equal(landing_of(&s, 1).state, 4); /* what came before is kept */
    assert_string_equal(landing_of(&s, 1).board_uid, "000000110000002200000033");
    session_end(&s);
}

/* A landing in whose middle `intrude` writes on CAN what the board did not send. */
static void log_with(struct session *session, bool serial, void (*intrude)(struct stream *stream))
{
    struct stream_truth truth = gentle;
    struct stream *stream = &session->stream;
    session_begin(session, true, serial);
    stream_hello(stream, MR_LAYOUT);
    stream_configuration(stream);
    stream_idle(stream, 500);
    FILE *kept = stream->serial;
    stream_state(stream, 1, 1, 1, stream->block);
    truth.touchdown_s = 1e9;
    for (int i = 0; i < 1500; i++)
        stream_millisecond(stream, &truth, true);
    stream->serial = NULL;
    unsigned sent = stream->can_sent, seq = stream->seq, serial_sent = stream->serial_sent;
    intrude(stream);
    stream->serial = kept;
    stream->can_sent = sent;
    stream->seq = (uint16_t)seq;
    stream->serial_sent = serial_sent;
    for (int i = 0; i < 2500; i++) {
        stream_millisecond(stream, &truth, true);
        if (i % 1000 == 999) {
            STREAM_BOTH(stream, board_uid, BOARD_UID, .uid0 = 0x11, .uid1 = 0x22);
            stream_state(stream, 1, 1, 1, 500);
        }
    }
    stream_state(stream, 0, 1, 1, stream->block);
    stream_idle(stream, 400);
    session_log(session, "collect.db");
}

static void over(struct stream *stream)
{
    stream_state(stream, 0, 1, 1, stream->block);
}

TEST(serial_denies_the_end)
{
    struct session s;
    int64_t blocks;
    log_with(&s, true, over);
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    assert_int_equal(store_blocks_count(s.store, 1, &blocks, &s.error), MR_OK);
    assert_int_equal(blocks, 4000);
    session_end(&s);
}

static void another_uid(struct stream *stream)
{
    swap_board(stream);
}

TEST(another_board_on_can_is_a_stranger)
{
    for (int serial = 0; serial < 2; serial++) {
        struct session s;
        log_with(&s, serial, another_uid);
        assert_no_error(&s.error);
        assert_string_equal(landing_of(&s, 1).board_uid, "000000110000002200000033");
        session_end(&s);
    }
}

static void one_moment_of_another_time(struct stream *stream)
{
    STREAM_CAN(stream, clock, CLOCK, .block = 17, .tick = 12345);
    STREAM_CAN(stream, can_health, CAN_HEALTH, .sent = 3);
    STREAM_CAN(stream, displacement_1_3, DISPLACEMENT_1_3, 1.0f, 2.0f, 3.0f, 40000);
}

TEST(time_and_counts_of_nobody)
{
    struct session s;
    log_with(&s, false, one_moment_of_another_time);
    assert_no_error(&s.error);
    assert_int_equal(landing_count(&s), 1);
    assert_int_equal(landing_of(&s, 1).boot, 0);
    assert_int_equal(counts_of(&s, LINK_CAN).lost, 0);
    session_end(&s);
}
