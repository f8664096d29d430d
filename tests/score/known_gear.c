#include "tests/score/known_gear.h"

#include <math.h>

bool gear_take(struct known_gear *gear, const struct mr_gate *gate, size_t gates,
               double touchdown_ft, double switch_error_ft, double t_s)
{
    size_t before = gear->gates;
    while (gear->gates < gates && gate[gear->gates].t_s + GEAR_EDGE_NAMED_S <= t_s)
        gear->beyond += gate[gear->gates++].station_ft >= touchdown_ft;
    if (gear->gates == before)
        return false;
    /* Braking begins at touchdown: gates on the track would bend the parabola, so two beyond it
     * replace them. */
    size_t skip = gear->beyond >= 2 ? gear->gates - gear->beyond : 0;
    gear->known = mr_gates_now(gate + skip, gear->gates - skip, switch_error_ft, &gear->motion) ==
                  MR_OK;
    return true;
}

void gear_tell(const struct known_gear *gear, double touchdown_ft, double t_s,
               struct mr_predictor_input *input)
{
    input->wheel_ft = input->speed_ft_s = input->deceleration_ft_s2 = NAN;
    input->braking_known = input->on_runway = false;
    if (!gear->known)
        return;
    double v = gear->motion.speed_ft_s.value, a = gear->motion.deceleration_ft_s2.value;
    input->braking_known = gear->beyond >= 3 && !isnan(a);
    a = isnan(a) ? 0.0 : a;
    double since_s = t_s - gear->motion.t_s;
    if (a > 0.0 && since_s > v / a)
        since_s = v / a;
    input->wheel_ft = (float)(gear->motion.position_ft.value + (v - 0.5 * a * since_s) * since_s);
    input->speed_ft_s = (float)(v - a * since_s);
    input->deceleration_ft_s2 = (float)a;
    input->on_runway = (double)input->wheel_ft >= touchdown_ft;
}
