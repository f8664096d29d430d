#include "hil/rig.h"

#include <math.h>

#include "hil/machine.h"

#define STAIRCASE_ZERO_V 0.050
#define STAIRCASE_TAU_S 20e-6
#define GAGE_ZERO_V 0.400
#define GAGE_V_PER_LB 0.005
#define REFERENCE_V 2.500
#define TRANSDUCER_MID_V 1.65
#define TRANSDUCER_ZERO_V 0.050
#define TRANSDUCER_V_PER_IN 0.5
#define TRANSDUCER_TAU_S 4e-6
#define SETTLED_TAUS 40.0 /* exp(-40) of full scale is 1e-14 codes */

unsigned hil_rig_step_codes(unsigned position) { return 64u + 8u * (7u * (position - 1u) % 24u); }

static void schedule(struct hil_board *board)
{
    const struct hil_rig *rig = &board->state.rig;
    uint64_t next = rig->pulse_end_ps;
    if (board->run && rig->opened < rig->order_count) {
        uint64_t opens = board->run->switch_open_ps[rig->order[rig->opened]];
        if (opens < next)
            next = opens;
    }
    hil_event_set_ps(board, HIL_EVENT_RIG, next);
}

void hil_rig_start(struct hil_board *board)
{
    struct hil_rig *rig = &board->state.rig;
    *rig = (struct hil_rig){.pulse_end_ps = HIL_NEVER};
    for (unsigned i = 0; board->run && i < HIL_RUN_SWITCHES; i++) {
        uint64_t t_ps = board->run->switch_open_ps[i];
        if (t_ps == HIL_RUN_NEVER)
            continue;
        unsigned place = rig->order_count++;
        for (; place && board->run->switch_open_ps[rig->order[place - 1]] > t_ps; place--)
            rig->order[place] = rig->order[place - 1];
        rig->order[place] = (uint8_t)i;
    }
    schedule(board);
}

void hil_rig_event(struct hil_board *board, uint64_t at)
{
    struct hil_rig *rig = &board->state.rig;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    if (rig->pulse_end_ps <= now_ps) {
        rig->pulse_end_ps = HIL_NEVER;
        hil_gpio_drive(board, 0, 15, false, at);
    }
    while (board->run && rig->opened < rig->order_count
           && board->run->switch_open_ps[rig->order[rig->opened]] <= now_ps) {
        uint64_t opens = board->run->switch_open_ps[rig->order[rig->opened]];
        rig->opened++;
        rig->pulse_end_ps = opens + HIL_RIG_PULSE_PS;
        board->state.counters.switches_opened++;
        hil_trace(board, "switch %u opens", rig->order[rig->opened - 1] + 1u);
        hil_gpio_drive(board, 0, 15, true, at);
    }
    schedule(board);
}

/* Amplitude of the excitation at the transducers, -1 to 1. */
static double amplitude(const struct hil_board *board, uint64_t at)
{
    const struct hil_rig *rig = &board->state.rig;
    double taus = (double)(at - rig->since_cycle) / board->state.clock.hclk_hz / TRANSDUCER_TAU_S;
    if (at < rig->since_cycle || taus > SETTLED_TAUS)
        return rig->excitation;
    return rig->excitation + (rig->from - rig->excitation) * exp(-taus);
}

void hil_rig_count_excitation(struct hil_board *board, uint64_t at)
{
    struct hil_rig *rig = &board->state.rig;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    if (now_ps <= rig->since_ps)
        return;
    if (rig->excitation > 0)
        board->state.counters.excitation_plus_ps += now_ps - rig->since_ps;
    else if (rig->excitation < 0)
        board->state.counters.excitation_minus_ps += now_ps - rig->since_ps;
    rig->since_ps = now_ps;
}

void hil_rig_excitation(struct hil_board *board, bool pd12, bool pd13, uint64_t at)
{
    struct hil_rig *rig = &board->state.rig;
    int8_t wanted = (int8_t)(pd12 - pd13);
    if (wanted == rig->excitation)
        return;
    hil_adc_catch_up(board, at); /* what was sampled before saw the old polarity */
    hil_rig_count_excitation(board, at);
    rig->from = amplitude(board, at);
    rig->excitation = wanted;
    rig->since_cycle = at;
    rig->since_ps = hil_clock_ps(&board->state.clock, at);
}

static double staircase_volts(const struct hil_board *board, double t_s)
{
    const struct hil_rig *rig = &board->state.rig;
    double codes = 0.0;
    for (unsigned i = 0; i < rig->opened; i++) {
        double taus = (t_s - (double)board->run->switch_open_ps[rig->order[i]] * 1e-12) / STAIRCASE_TAU_S;
        double step = hil_rig_step_codes(rig->order[i] + 1u);
        if (taus > SETTLED_TAUS)
            codes += step;
        else if (taus > 0.0)
            codes += step * (1.0 - exp(-taus));
    }
    return STAIRCASE_ZERO_V + codes * HIL_VREF_V / 4096.0;
}

/* Number of the strain gage on a pin, 1..14, or 0. */
static unsigned gage_on(unsigned port, unsigned pin)
{
    if (port == 0 && pin < 8)
        return pin + 1;
    if (port == 1 && pin < 2)
        return pin + 9;
    return port == 2 && pin < 4 ? pin + 11 : 0;
}

double hil_rig_volts(const struct hil_board *board, unsigned port, unsigned pin, uint64_t at)
{
    double t_s = (double)hil_clock_ps(&board->state.clock, at) * 1e-12;
    unsigned gage = gage_on(port, pin);
    if (gage) {
        double tension_lb = board->run ? hil_run_truth(board->run, HIL_RUN_TRANSDUCERS + gage - 1, t_s) : 0.0;
        return GAGE_ZERO_V + GAGE_V_PER_LB * tension_lb;
    }
    if (port == 5 && pin >= 3 && pin <= 10) {
        double displacement_in = board->run ? hil_run_truth(board->run, pin - 3, t_s) : 0.0;
        return TRANSDUCER_MID_V
               + amplitude(board, at) * (TRANSDUCER_ZERO_V + TRANSDUCER_V_PER_IN * displacement_in);
    }
    if (port == 2 && pin == 4)
        return staircase_volts(board, t_s);
    if (port == 2 && pin == 5)
        return REFERENCE_V;
    return 0.0;
}
