#!/usr/bin/env bash
# make uncertainty: writes docs/measured/uncertainty.md, simulated calibrations against the uncertainty budget. usage: page.sh DRAWS
set -eu
cd "$(dirname "$0")/../.."
program=build/tests/uncertainty/study
draws=$1
# exit 1: an interval does not hold; the page shows it
of() { "$program" "$draws" "$@" || [ $? = 1 ]; }
whole=$(of)
more=$("$program" $((8 * draws)) || [ $? = 1 ])
rows() { sed -n "3,4s/^/| $1 /p"; } # BUDGET: its two rows of the table
cat >docs/measured/uncertainty.md <<P
# Measured: the uncertainty budget

\`make uncertainty\` wrote this page on $(date -u +%F) (commit $(git rev-parse --short HEAD)). All sensors and boards are simulated (\`tests/uncertainty\`).

| Budget $(sed -n 1p <<<"$whole")
|---$(sed -n 2p <<<"$whole")
$(rows complete <<<"$whole")
$(rows complete <<<"$more")
$(of --without certificate | rows 'without certificate')
$(of --without temperature | rows 'without temperature')

- Expanded holds: share of draws with an error inside the 95 % interval. Wilson: 95 % confidence interval of this share.
- Stated holds: share of draws with an error below 1.96 times the stated error, which does not include certificate and temperature.
- The rows \`without\` omit one contribution to the budget. For a gage, the stated drift already includes the temperature error.

## Method

Each draw is one transducer or one gage, with its board. Its errors are drawn from the tolerances of the reference circuits (\`hil/circuits/figures.def\`). The certificate states
an uncertainty of 0.8 % (transducer) and 0.4 % (gage) with k = 2. The nonlinearity is 0.002 in rms for a transducer and 0.1 lb rms for a
gage.

The calibration goes up and down through ten known values, and fits a straight line. The values are set to within 0.001 in for a transducer and 0.05 lb for a gage. Then the
temperature changes by up to 10 K, and one value is measured: a movement of 0.3 to 2.5 in or a tension of 50 to 350 lb. The [budget](../explanation/errors.md#two-numbers-for-one-reading) does not use the drawn values.

Not simulated: error of the station, aging of a sensor, temperature dependence of the gage factor, transverse load on a sensor.
P
