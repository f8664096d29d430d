/* The velocity rig on the emulated board: seeded landings, damaged switches, the model pushed
 * back. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/command.h"
#include "common/gates.h"
#include "common/switches.h"
#include "hil/board/board.h"
#include "hil/rig/faults.h"
#include "hil/rig/runfile.h"
#include "tests/cmocka_all.h"
#include "tests/hil/still_run.h"
#include "tests/common/seeded_landing.h"
#include "tests/long.h"

#define ELF       "build/firmware/matrig.elf"
#define RAM       0x20000000u
#define RAM_BYTES 0x20000u
#define EVENTS    64

struct rig {
    struct hil_run run;
    struct hil_board *board;
    struct mr_edge edge[256];
    unsigned edges;
    struct mr_switch_event event[EVENTS];
    unsigned events;
    struct mr_site site;
    struct mr_touchdown touchdown;
    struct mr_pushback pushback;
    struct mr_health health;
    unsigned touchdowns, pushbacks, warnings;
    bool landed;
};

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct rig *rig = ctx;
    struct mr_landing landing;
    struct mr_zone_lead lead;
    (void)t_ps;
    switch (frame->id) {
    case MR_ID_EDGE:
        assert_in_range(rig->edges, 0, 255);
        assert_int_equal(mr_edge_get(&rig->edge[rig->edges++], frame->data, frame->length), MR_OK);
        break;
    case MR_ID_SWITCH_EVENT:
        assert_in_range(rig->events, 0, EVENTS - 1);
        assert_int_equal(
            mr_switch_event_get(&rig->event[rig->events++], frame->data, frame->length), MR_OK);
        break;
    case MR_ID_SITE:
        assert_int_equal(mr_site_get(&rig->site, frame->data, frame->length), MR_OK);
        break;
    case MR_ID_HEALTH:
        assert_int_equal(mr_health_get(&rig->health, frame->data, frame->length), MR_OK);
        break;
    case MR_ID_TOUCHDOWN:
        assert_int_equal(mr_touchdown_get(&rig->touchdown, frame->data, frame->length), MR_OK);
        rig->touchdowns++;
        break;
    case MR_ID_PUSHBACK:
        assert_int_equal(mr_pushback_get(&rig->pushback, frame->data, frame->length), MR_OK);
        rig->pushbacks++;
        break;
    case MR_ID_ZONE_LEAD:
        assert_int_equal(mr_zone_lead_get(&lead, frame->data, frame->length), MR_OK);
        rig->warnings += lead.warning;
        break;
    case MR_ID_LANDING:
        assert_int_equal(mr_landing_get(&landing, frame->data, frame->length), MR_OK);
        rig->landed |= landing.state > 1;
        break;
    default: break;
    }
}

/* A board with rig->run on its pins. */
static void power_on(struct rig *rig, uint64_t seed)
{
    struct hil_options options;
    struct hil_callbacks callbacks = {.context = rig, .on_can_frame = on_can};
    hil_options_default(&options);
    options.noise_seed = seed;
    rig->board = hil_board_create(&options);
    hil_board_set_callbacks(rig->board, &callbacks);
    if (hil_board_load_elf(rig->board, ELF) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(rig->board));
    hil_board_attach_rig(rig->board, &rig->run);
}

static void run_until(struct rig *rig, double t_s)
{
    if (hil_board_run_until(rig->board, (uint64_t)(t_s * 1e12)) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(rig->board));
}

static void power_off(struct rig *rig)
{
    hil_board_destroy(rig->board);
    hil_run_free(&rig->run);
}

static void open_still(struct rig *rig, double duration_s)
{
    memset(rig, 0, sizeof *rig);
    still_run(&rig->run, duration_s);
    assert_null(rig->run.commands);
    rig->run.commands = calloc(1, sizeof *rig->run.commands);
    assert_non_null(rig->run.commands);
    rig->run.command_count = 1;
    rig->run.commands[0].t_ps = 100000000000u;
    assert_int_equal(mr_command_parse("arm 7", 1, &rig->run.commands[0].message), MR_OK);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        rig->run.switch_open_ps[i] = HIL_RUN_NEVER;
}

static void order_fault(struct rig *rig, enum hil_fault_action action, unsigned position,
                        uint32_t count, double period_s)
{
    struct hil_fault fault = {.trigger = HIL_TRIGGER_TIME,
                              .trigger_ps = 50000000000u,
                              .action = action,
                              .target_index = position,
                              .count = count,
                              .duration_ps = (uint64_t)(period_s * 1e12)};
    if (hil_faults_add(&rig->board->faults, &fault) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(rig->board));
}

/* The board's results stand in its RAM exactly as the host computes them from the edges that the
 * board told. */
static void results_are_the_hosts(struct rig *rig)
{
    static uint8_t ram[RAM_BYTES];
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary summary;
    size_t count = 0;
    uint32_t first_tick = 0;
    for (unsigned i = 0; i < rig->edges; i++) {
        if (!rig->edge[i].position)
            continue;
        if (count == 0)
            first_tick = rig->edge[i].tick;
        gates[count++] = (struct mr_gate){
            .t_s = (double)(uint32_t)(rig->edge[i].tick - first_tick) * (1.0 / 84.0e6),
            .station_ft = -2.5 + 5.0 * (rig->edge[i].position - 1)};
    }
    assert_int_equal(mr_gates_summarise(gates, count, (double)rig->site.touchdown_ft,
                                        (double)rig->site.switch_error_ft, &summary),
                     MR_OK);
    assert_int_equal(hil_board_peek(rig->board, RAM, ram, sizeof ram), MR_OK);
    /* five values with their errors, one after the other */
    _Static_assert(offsetof(struct mr_gates_summary, gates_used_for_stop) == 80, "as on the board");
    assert_non_null(memmem(ram, sizeof ram, &summary, 80));
}

TEST(seeded_landings_are_the_hosts_bit_for_bit)
{
    unsigned done = 0, wanted = tests_take(3, 20);
    for (uint64_t seed = 0; done < wanted; seed++) {
        struct seeded_landing truth;
        struct rig rig;
        unsigned opened = 0, bounces = 0, beyond = 0;
        assert_in_range(seed, 0, 200);
        seeded_draw(&truth, seed, 0.02 / sqrt(3.0)); /* as the board's configuration has it */
        for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
            beyond += (unsigned)(i >= 2 && !isnan(truth.open_s[i]));
        if (truth.stop_s > 2.6 || beyond < 3) /* short ones, for the time it takes */
            continue;
        open_still(&rig, truth.stop_s + 1.0);
        for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
            if (isnan(truth.open_s[i]))
                continue;
            rig.run.switch_open_ps[i] = (uint64_t)(truth.open_s[i] * 1e12);
            opened++;
        }
        power_on(&rig, seed);
        for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
            if (isnan(truth.open_s[i]) || !truth.bounces[i])
                continue;
            order_fault(&rig, HIL_FAULT_SWITCH_BOUNCE, i, truth.bounces[i], truth.bounce_s[i]);
            bounces += truth.bounces[i];
        }
        run_until(&rig, truth.stop_s + 1.0);
        assert_int_equal(rig.edges, opened + bounces);
        assert_int_equal(rig.touchdowns, 1);
        assert_int_equal(rig.health.faults, 0);
        assert_near(rig.touchdown.speed_ft_s, truth.speed_ft_s, 0.01 * truth.speed_ft_s);
        results_are_the_hosts(&rig);
        power_off(&rig);
        done++;
    }
}

/* ---- damaged twins of landings 4 and 5 ---- */

static void open_twin(struct rig *rig, unsigned landing)
{
    char path[64], error[256];
    memset(rig, 0, sizeof *rig);
    snprintf(path, sizeof path, "tests/runs/landing%u.run", landing);
    if (hil_run_read(path, &rig->run, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    power_on(rig, 1);
}

static unsigned count_events(const struct rig *rig, unsigned reason, unsigned position)
{
    unsigned count = 0;
    for (unsigned i = 0; i < rig->events; i++)
        count += (unsigned)(rig->event[i].reason == reason && rig->event[i].position == position);
    return count;
}

/* Speeds from tests/runs/README.md. */
static void check_twin(struct rig *rig, unsigned landing, double rest_s, unsigned reason,
                       unsigned position, unsigned times)
{
    double truth = landing == 5 ? 35.5 : 28.0;
    run_until(rig, rest_s + 1.2);
    printf("# landing %u, switch %u %s: speed %.3f +- %.3f (truth %.1f), %u events\n", landing,
           position, mr_switch_reason_text(reason), (double)rig->touchdown.speed_ft_s,
           (double)rig->touchdown.speed_error_ft_s, truth, rig->events);
    assert_int_equal(rig->touchdowns, 1);
    assert_near(rig->touchdown.speed_ft_s, truth, 0.01 * truth);
    assert_int_equal(count_events(rig, reason, position), times);
    assert_int_equal(rig->events, times); /* and nothing else is blamed */
    assert_int_equal(rig->health.faults, 0);
    power_off(rig);
}

TEST(a_missing_switch_is_named)
{
    const struct {
        unsigned landing, position;
        double rest_s;
    } twins[] = {{5, 1, 6.175}, {4, 7, 7.732}, {5, 7, 6.175}, {4, 2, 7.732}};
    for (unsigned i = 0; i < tests_take(1, COUNT_OF(twins)); i++) {
        struct rig rig;
        open_twin(&rig, twins[i].landing);
        order_fault(&rig, HIL_FAULT_SWITCH_SKIP, twins[i].position - 1, 0, 0.0);
        check_twin(&rig, twins[i].landing, twins[i].rest_s, MR_SWITCH_MISSING, twins[i].position,
                   1);
    }
}

TEST(a_bouncing_switch_is_named)
{
    const struct {
        unsigned landing, position, times;
        double rest_s, period_s;
    } twins[] = {{5, 2, 4, 6.175, 2.0e-3}, {5, 12, 6, 6.175, 0.3e-3}, {4, 9, 3, 7.732, 0.8e-3}};
    for (unsigned i = 0; i < tests_take(1, COUNT_OF(twins)); i++) {
        struct rig rig;
        open_twin(&rig, twins[i].landing);
        order_fault(&rig, HIL_FAULT_SWITCH_BOUNCE, twins[i].position - 1, twins[i].times,
                    twins[i].period_s);
        check_twin(&rig, twins[i].landing, twins[i].rest_s, MR_SWITCH_BOUNCE, twins[i].position,
                   twins[i].times);
    }
}

/* ---- the model pushed back ---- */

TEST(a_pushback_is_told_and_is_no_landing)
{
    for (unsigned n = 0; n < 5; n += tests_take(3, 1)) { /* one forward, one backward */
        struct rig rig;
        double speed_ft_s = 1.5 + n; /* the first two forward, slower than 2 ft/s */
        bool forward = n < 2;
        if (forward)
            speed_ft_s = 1.4 + 0.4 * n;
        open_still(&rig, 10.0);
        for (unsigned i = 0; i < 3; i++)
            rig.run.switch_open_ps[forward ? 4 + i : 12 - i] =
                (uint64_t)((0.5 + 5.0 / speed_ft_s * i) * 1e12);
        power_on(&rig, n);
        run_until(&rig, 0.5 + 10.0 / speed_ft_s + 0.2);
        assert_int_equal(rig.edges, 3);
        assert_int_equal(rig.pushbacks, 1);
        assert_int_equal(rig.pushback.count, 1);
        /* as sent, 1/500 ft/s */
        assert_near(rig.pushback.speed_ft_s, forward ? speed_ft_s : -speed_ft_s, 0.003);
        assert_false(rig.landed);
        assert_int_equal(rig.touchdowns, 0);
        assert_int_equal(rig.warnings, 0);
        power_off(&rig);
    }
}
