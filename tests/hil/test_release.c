/* The brake release on the emulated board: the pin (PE7) of a rig whose brake can be released, of
 * one that has none, and whatever happens to the board meanwhile. Only a square wave asks; edges of
 * the pin are counted each 0.5 ms. */
#include "hil/core/elf.h"
#include "tests/hil/ear.h"

#define PORT_E     4
#define PIN        7
#define WIRED      "build/tests/variant/release.elf"
#define ROLLING    "build/tests/variant/rolling.elf"
#define STEP_S     0.0005
#define HANG       0xe7feu /* b . */
#define UNDEFINED  0xde00u
#define ENDS_S     7.0
#define HELD_EDGES 8u /* in so few a charge pump of 20 ms is not up */

struct watched {
    struct ear *ear;
    unsigned edges, longest; /* longest: edges in a row no further apart than 3 ms */
    double first_s, last_s;
};

static struct ear *open_with(const char *elf, unsigned landing)
{
    struct hil_options options = ear_options();
    options.seed = 1;
    struct ear *ear = ear_open(&options, landing);
    if (elf && hil_board_load_elf(ear->board, elf) != MR_OK)
        fail_msg("%s", hil_board_reason(ear->board));
    return ear;
}

static void watch(struct watched *w, double from_s, double to_s)
{
    static unsigned row;
    bool was = hil_board_pin(w->ear->board, PORT_E, PIN);
    for (double t_s = from_s; t_s < to_s; t_s += STEP_S) {
        ear_until(w->ear, t_s);
        bool is = hil_board_pin(w->ear->board, PORT_E, PIN);
        if (is == was)
            continue;
        was = is;
        row = t_s - w->last_s < 0.003 ? row + 1 : 1;
        w->longest = row > w->longest ? row : w->longest;
        w->first_s = w->edges++ ? w->first_s : t_s;
        w->last_s = t_s;
    }
}

static struct mr_release newest(const struct ear *ear)
{
    struct mr_release release = {0};
    if (ear->heard[EAR_SERIAL][MR_ID_RELEASE])
        assert_int_equal(
            mr_release_get(&release, ear->last[EAR_SERIAL][MR_ID_RELEASE], MR_MESSAGE_MAX), MR_OK);
    return release;
}

/* Landing 5, that warns: as test_warning has it. */
static void a_risky_landing_asks_for_it(void **state)
{
    (void)state;
    struct watched w = {.ear = open_with(WIRED, 5)};
    watch(&w, 0.1, ENDS_S + 3.0);
    print_message("# landing 5: %u edges of the pin, %.3f to %.3f s; told: %s (%s)\n", w.edges,
                  w.first_s, w.last_s, mr_release_state_text(newest(w.ear).state),
                  mr_release_reason_text(newest(w.ear).reason));
    assert_true(w.longest > 100);
    assert_true(w.ear->heard[EAR_SERIAL][MR_ID_RELEASE] >= 2);
    assert_true(w.ear->heard[EAR_CAN][MR_ID_RELEASE] >= 2);
    ear_close(w.ear);
}

static void none_where_none_is_wired(void **state)
{
    (void)state;
    struct watched w = {.ear = open_with(NULL, 5)};
    watch(&w, 0.1, ENDS_S + 3.0);
    assert_int_equal(w.edges, 0);
    assert_int_equal(w.ear->heard[EAR_SERIAL][MR_ID_RELEASE], 0);
    ear_close(w.ear);
}

static void none_without_runway(void **state)
{
    (void)state;
    struct watched w = {.ear = open_with(ROLLING, 5)};
    watch(&w, 0.1, 5.2); /* by then 10 ft/s are left: 100 ft at 0.5 ft/s2 */
    assert_int_equal(w.edges, 0);
    assert_int_equal(newest(w.ear).state, MR_RELEASE_REFUSED);
    assert_int_equal(newest(w.ear).reason, MR_RELEASE_NO_RUNWAY);
    ear_close(w.ear);
}

/* While it is asked for, something happens; from 3 ms later on the pin is still. */
static void still_after(const char *order, uint16_t code)
{
    struct watched w = {.ear = open_with(WIRED, 5)}, after;
    uint32_t place = 0;
    double t_s = 0.1;
    uint64_t resets = hil_board_counters(w.ear->board)->resets;
    while (w.longest < 50 && t_s < ENDS_S) {
        watch(&w, t_s, t_s + 0.01);
        t_s += 0.01;
    }
    assert_true(w.longest >= 50);
    assert_int_equal(newest(w.ear).state, MR_RELEASE_ASKED);
    if (order) {
        char line[80];
        snprintf(line, sizeof line, "at %.4f %s", t_s + 0.001, order);
        ear_order(w.ear, line);
        t_s += 0.001;
    } else {
        assert_int_equal(hil_elf_symbol(WIRED, "mr_risk_say", &place), MR_OK);
        assert_int_equal(hil_board_poke(w.ear->board, place, &code, sizeof code), MR_OK);
        t_s += 0.010; /* the next look */
    }
    after = (struct watched){.ear = w.ear};
    watch(&after, t_s + 0.003, t_s + 1.5);
    print_message("# %s: %u edges afterwards, %u resets\n",
                  order          ? order
                  : code == HANG ? "hangs"
                                 : "faults",
                  after.edges, (unsigned)(hil_board_counters(w.ear->board)->resets - resets));
    assert_true(after.edges <= HELD_EDGES);
    assert_true(after.longest <= 2);
    assert_true(hil_board_counters(w.ear->board)->resets > resets);
    ear_close(w.ear);
}

static void nothing_that_happens_releases(void **state)
{
    (void)state;
    still_after("power-cut 30", 0);
    still_after("crystal stop", 0);
    still_after(NULL, HANG);
    still_after(NULL, UNDEFINED);
}

/* Before the firmware has set its pins, in a reset and while it stands still unarmed. */
static void a_pin_that_floats_is_low(void **state)
{
    (void)state;
    struct watched w = {.ear = open_with(WIRED, 0)};
    watch(&w, 0.0, 0.6);
    assert_int_equal(w.edges, 0);
    assert_false(hil_board_pin(w.ear->board, PORT_E, PIN));
    ear_close(w.ear);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_risky_landing_asks_for_it),
        cmocka_unit_test(none_where_none_is_wired),
        cmocka_unit_test(none_without_runway),
        cmocka_unit_test(nothing_that_happens_releases),
        cmocka_unit_test(a_pin_that_floats_is_low),
    };
    return cmocka_run_group_tests_name("hil/release", tests, NULL, NULL);
}
