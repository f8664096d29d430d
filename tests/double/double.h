/* The predictor once more with every float of it a double: the same sources (common/predictor.c and
 * what it calls), compiled with that one word changed. One runway at a time. All quantities as in
 * common/predictor.h. */
#ifndef MATRIG_TESTS_DOUBLE_H
#define MATRIG_TESTS_DOUBLE_H

#include <stdbool.h>

struct double_config {
    unsigned mats;
    double mat_length_ft, mass_slug, friction_lb, kl_lb_ft, cl_lb_s_ft, slack_ft, step_s;
    double grit_lb, thrust_lb_per_g, deceleration_ft_s2, bump_ft, mat_weight_lb;
    double station_ft[8];
};

/* Starts and arms. False: refused. */
bool double_start(const struct double_config *config);
void double_block(double wheel_ft, double speed_ft_s, double deceleration_ft_s2,
                  const double displacement_in[8]);
double double_displacement_ft(unsigned mat);
/* Bytes of a number in it: 8, or the test is none. */
unsigned double_size(void);

#endif
