/* A strain bridge on a band: from its physics to pounds per code, and to the tension that a shunt
 * resistor stands for.
 *
 * A band of cross section A and modulus E stretches by strain T / (E A). Each gage of resistance R
 * changes by dR / R = gage_factor * strain * its share; `arms` is the sum of the shares' sizes of
 * all four: 1 one gage along the band, 2 two along it in opposite arms, 2 (1 + nu) = 2.6 with two
 * more across it (steel, nu 0.3), which also cancels temperature. For small strain the output is V
 * / excitation = gage_factor * strain * arms / 4.
 *
 * The shunt is one resistor across one arm: V / excitation = R / (2 (2 shunt + R)), exactly,
 * whatever the strain nearly is. */
#ifndef MATRIG_COMMON_BRIDGE_H
#define MATRIG_COMMON_BRIDGE_H

#define MR_ADC_V     3.3 /* of 4096 codes, with the reference at its nominal 2.5 V */
#define MR_ADC_CODES 4096.0

struct mr_bridge {
    double excitation_v;
    double amplifier_gain;
    double gage_factor;
    double arms;
    double area_in2;
    double modulus_psi;
    double gage_ohm;  /* for the shunt */
    double shunt_ohm; /* 0: none */
};

/* What config.channel.unit_per_code should be. */
double mr_bridge_lb_per_code(const struct mr_bridge *bridge);
/* What config.channel.shunt_lb should be; NaN without a shunt. */
double mr_bridge_shunt_lb(const struct mr_bridge *bridge);

#endif
