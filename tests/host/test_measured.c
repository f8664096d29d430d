/* A landing read back: gear, displacements, tensions and zones against the closed form they were
 * made from. */
#include "host/analyse/measured_load.h"
#include "host/analyse/summary.h"
#include "tests/host/session.h"

/* Stops at 3 + 35^2 / 16 = 79.5625 ft after 4.375 s. */
static const struct stream_truth brisk = {
    .v0_ft_s = 35.0, .a_ft_s2 = 8.0, .peak_in = 0.8, .warn = true};

static void log_one(struct session *s, bool can, bool serial)
{
    struct stream_truth truth = brisk;
    session_begin(s, can, serial);
    stream_hello(&s->stream, MR_LAYOUT);
    stream_configuration(&s->stream);
    stream_idle(&s->stream, 300);
    stream_landing(&s->stream, &truth, 5);
    session_log(s, "measured.db");
    assert_no_error(&s->error);
}

/* Displacement moves with the wheel from 10 ft ahead until it passes (stream.h); the wheel stops at
 * 79.5625 ft. */
static double moved_in(unsigned index)
{
    double ahead_ft = 40.0 + 10.0 * index - 79.5625;
    double share = ahead_ft > 10.0 ? 0.0 : ahead_ft < 0.0 ? 1.0 : 1.0 - ahead_ft / 10.0;
    return share * 0.8 * (index + 1) / 8.0;
}

static void check_gear(const struct measured_landing *m)
{
    assert_int_equal(m->fit_status, MR_OK);
    assert_true(m->is_t0_touchdown);
    assert_int_equal(m->gate_count, 16); /* 2.5 to 77.5 ft */
    assert_int_equal(m->switch_count, 24);
    /* Within the 0.2 % that is promised: this brake comes at once, two standard errors before the
     * usual 25 ms. */
    assert_near(m->summary.touchdown_speed_ft_s.value, 35.0, 0.07);
    assert_near(m->summary.mean_deceleration_ft_s2.value, 8.0, 0.016);
    assert_near(m->summary.stop_station_ft.value, 79.5625, 0.005);
    assert_near(m->summary.stop_t_s.value, 4.375, 0.004);
    assert_near((double)m->t0_us, 1.3e6, 100.0);
    for (double t_s = 0.0; t_s <= 4.375; t_s += 0.125) {
        double error_ft_s;
        assert_near(measured_station_ft(m, t_s), 3.0 + 35.0 * t_s - 4.0 * t_s * t_s, 0.005);
        assert_near(measured_speed_ft_s(m, t_s, &error_ft_s), 35.0 - 8.0 * t_s, 0.07);
    }
    assert_near(measured_station_ft(m, 10.0), m->summary.stop_station_ft.value, 0.0);
    assert_true(isnan(measured_station_ft(m, -0.1)));
}

/* `digit_in`, `digit_lb`: what a reading may be off: half a code of a sum, or half a digit of the
 * wire more. */
static void check_channels(const struct measured_landing *m, double digit_in, double digit_lb)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *c = &m->channel[i];
        assert_near(c->peak, moved_in(i), digit_in);
        assert_near(c->end, moved_in(i), digit_in);
        assert_near(c->baseline, 0.01, digit_in);
        assert_int_equal(c->valid_samples, m->samples);
    }
    for (unsigned i = 0; i < MR_GAGES; i++) {
        const struct measured_channel *c = &m->channel[MR_TRANSDUCERS + i];
        bool slackened = (double)c->config.station_ft < 79.5625 + 10.0;
        assert_near(c->baseline, 101.0 + i, digit_lb);
        assert_near(c->low, 101.0 + i - (slackened ? 10.0 : 0.0), digit_lb);
        assert_near(c->high, 101.0 + i, digit_lb);
    }
}

TEST(from_block_records)
{
    struct session s;
    struct measured_landing m;
    log_one(&s, true, true);
    assert_int_equal(measured_load(s.store, 1, &m, &s.error), MR_OK);
    assert_int_equal(m.source, MEASURED_SERIAL);
    assert_int_equal(m.first_block, 300);
    check_gear(&m);
    /* codes are 0.0016 in; sums of 4 of each polarity resolve a quarter of it, 0.16 lb an eighth */
    check_channels(&m, 0.0004, 0.02);
    measured_free(&m);
    session_end(&s);
}

TEST(from_can_alone)
{
    struct session s;
    struct measured_landing m;
    log_one(&s, true, false);
    assert_int_equal(measured_load(s.store, 1, &m, &s.error), MR_OK);
    assert_int_equal(m.source, MEASURED_CAN);
    check_gear(&m);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_near(m.channel[i].peak, moved_in(i), 0.0005);
    for (unsigned i = 0; i < MR_GAGES; i++)
        assert_near(m.channel[MR_TRANSDUCERS + i].baseline, 101.0 + i, 0.03);
    measured_free(&m);
    session_end(&s);
}

static bool lose_a_second(const struct stream *stream, uint16_t type)
{
    return type == MR_ID_BLOCK && stream->block >= 2000 && stream->block < 3000;
}

TEST(lost_blocks_stay_missing)
{
    struct session s;
    struct measured_landing m;
    struct stream_truth truth = brisk;
    session_begin(&s, false, true);
    s.stream.drop_serial = lose_a_second;
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 300);
    stream_landing(&s.stream, &truth, 5);
    session_log(&s, "measured.db");
    assert_int_equal(measured_load(s.store, 1, &m, &s.error), MR_OK);
    size_t at = 2500 - (size_t)m.first_block;
    assert_int_equal(m.channel[0].validity[at], MEASURED_MISSING);
    assert_true(isnan(measured_value(&m.channel[0], at)));
    assert_int_equal(m.channel[0].valid_samples, m.samples - 1000);
    assert_true(isnan(measured_moving_mean(&m, &m.channel[0], at, 5)));
    measured_free(&m);
    session_end(&s);
}

/* A record without its beginning. At 2.6 s the wheel is at 41.7 ft: the mat has moved at 40 ft. */
static uint32_t lost_from;

static bool lose_the_beginning(const struct stream *stream, uint16_t type)
{
    return (type == MR_ID_BLOCK || type == MR_ID_EDGE) && stream->block >= lost_from &&
           stream->block < 2600;
}

static bool lose_edges(const struct stream *stream, uint16_t type)
{
    (void)stream;
    return type == MR_ID_EDGE;
}

static void log_lossy(struct session *s, bool (*drop)(const struct stream *, uint16_t),
                      struct measured_landing *m)
{
    struct stream_truth truth = brisk;
    session_begin(s, false, true);
    s->stream.drop_serial = drop;
    stream_hello(&s->stream, MR_LAYOUT);
    stream_configuration(&s->stream);
    stream_idle(&s->stream, 300);
    stream_landing(&s->stream, &truth, 5);
    session_log(s, "measured.db");
    assert_int_equal(measured_load(s->store, 1, m, &s->error), MR_OK);
}

/* The mean before the first edge that was received is no reading at rest: the transducer at 40 ft
 * was said to have moved by 0.000 in. */
TEST(torn_has_no_movements)
{
    struct session s;
    struct measured_landing m;
    char text[MEASURED_MISSING_START_SIZE];
    lost_from = 290;
    log_lossy(&s, lose_the_beginning, &m);
    assert_true(m.is_start_missing && m.has_no_baseline);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_true(isnan(m.channel[i].baseline) && isnan(m.channel[i].peak));
    for (unsigned i = 0; i < MR_GAGES; i++) {
        const struct measured_channel *c = &m.channel[MR_TRANSDUCERS + i];
        assert_true(isnan(c->baseline));
        assert_near(c->high, 101.0 + i, 0.02);
        assert_true(c->peak_error > 0.0);
    }
    measured_format_missing_start(&m, text);
    assert_string_equal(text,
                        "incomplete: the switch edges before edge 9 were not received; speeds "
                        "and movements are not known");
    measured_free(&m);
    session_end(&s);
}

/* With the blocks after arming, or all of them but no edge, the movements are known. */
TEST(torn_with_its_rest)
{
    struct session s;
    struct measured_landing m;
    for (int n = 0; n < 2; n++) {
        lost_from = 310;
        log_lossy(&s, n ? lose_edges : lose_the_beginning, &m);
        assert_true(m.is_start_missing && !m.has_no_baseline);
        assert_int_equal(m.gate_count > 0, !n);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            assert_near(m.channel[i].peak, moved_in(i), 0.001);
        measured_free(&m);
        session_end(&s);
    }
}

/* Armed for longer than is held in memory: the minute before the first edge is there, and what
 * comes of it is the same. */
TEST(armed_long_before)
{
    struct session s;
    struct measured_landing m;
    struct stream_truth truth = brisk;
    session_begin(&s, false, true);
    s.stream.armed_s = 130.0;
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 300);
    stream_landing(&s.stream, &truth, 5);
    session_log(&s, "measured.db");
    assert_int_equal(measured_load(s.store, 1, &m, &s.error), MR_OK);
    /* touchdown 130 s after arming at block 300; the first edge, half a foot before, at v0 */
    double first_edge_s = 130.3 - 0.5 / truth.v0_ft_s;
    assert_int_equal(m.first_block, (int64_t)(first_edge_s * 1000.0) - 60000);
    assert_int_equal(m.skipped_blocks, m.first_block - 300);
    assert_int_equal(m.stretch_count, 1);
    assert_near(m.summary.touchdown_speed_ft_s.value, 35.0, 0.07);
    assert_near(m.summary.stop_station_ft.value, 79.5625, 0.005);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_near(m.channel[i].peak, moved_in(i), 0.0005);
    measured_free(&m);
    session_end(&s);
}

TEST(warning_and_wheel)
{
    struct session s;
    struct summary summary;
    log_one(&s, true, true);
    assert_int_equal(summary_load(s.store, 1, &summary, &s.error), MR_OK);
    const struct zone_warning *w = &summary.zones.warning;
    assert_true(w->has_warning);
    assert_int_equal(w->mats, 35);
    assert_near(w->start_ft, 60.0, 1e-6);
    assert_near(w->predicted_lead_s, 0.75, 1e-6);
    assert_int_equal(w->inferred_percent, 20);
    /* said from 1 s after touchdown on, every 50 ms; the wheel is at 60 ft when 57 = 35 t - 4
     * t^2 */
    assert_true(w->t_s > 1.0 - 0.001 && w->t_s < 1.051);
    assert_near(w->predicted_lead_made_t_s, w->t_s, 0.0);
    assert_near(w->actual_lead_s, (35.0 - sqrt(35.0 * 35.0 - 16.0 * 57.0)) / 8.0 - w->t_s, 0.002);
    /* between the last switch, at 77.5 ft, and the stop; and beyond it: x = 3 + 35 t - 4 t^2 */
    assert_near(measured_arrival_time_s(&summary.measured, 79.0),
                (35.0 - sqrt(35.0 * 35.0 - 16.0 * 76.0)) / 8.0, 0.01);
    assert_true(isnan(measured_arrival_time_s(&summary.measured, 79.7)));
    assert_int_equal(summary.link[LINK_CAN].lost_frames, 0);
    assert_int_equal(summary.fault_count, 0);
    summary_free(&summary);
    session_end(&s);
}

TEST(units_of_json)
{
    struct session s;
    struct summary summary;
    log_one(&s, true, true);
    assert_int_equal(summary_load(s.store, 1, &summary, &s.error), MR_OK);
    json_t *report = summary_to_json(&summary, false);
    json_t *si = summary_to_json(&summary, true);
    double ft_s = json_real_value(json_object_get(report, "touchdown_speed_ft_s"));
    double m_s = json_real_value(json_object_get(si, "touchdown_speed_m_s"));
    assert_near(ft_s, 35.0, 0.07);
    assert_near(m_s, ft_s * 0.3048, 1e-6);
    json_t *first = json_array_get(json_object_get(si, "displacements"), 7);
    assert_near(json_real_value(json_object_get(first, "station_m")), 110.0 * 0.3048, 1e-6);
    assert_int_equal(json_array_size(json_object_get(si, "tensions")), 14);
    json_decref(report);
    json_decref(si);
    summary_free(&summary);
    session_end(&s);
}
