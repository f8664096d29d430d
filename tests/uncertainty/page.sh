#!/usr/bin/env bash
# make uncertainty: drawn calibrations and landings against the uncertainty budget, as docs/measured/uncertainty.md. usage: page.sh DRAWS
set -eu
cd "$(dirname "$0")/../.."
program=build/tests/uncertainty/study
draws=$1
# what the program says, whether the intervals hold or not: the page tells
of() { "$program" "$draws" "$@" || [ $? = 1 ]; }
whole=$(of)
more=$("$program" $((8 * draws)) || [ $? = 1 ])
table() { sed -n 1,4p; }
cat >docs/measured/uncertainty.md <<P
# Measured: does the uncertainty budget hold?

\`make uncertainty\` makes this page (\`tests/uncertainty\`), here on $(date -u +%F), at $(git rev-parse --short HEAD). No real sensor was calibrated: all of it is drawn.

One transducer and one gage, each on a board of its own, drawn from the figures of the reference circuits (\`hil/circuits/figures.def\`): reference, supply, amplifier, excitation, converter with its
curve and noise, drift. The sensor has a curve of what the built-in configuration states (0.002 in, 0.1 lb rms). A laboratory's standard is off, by 0.4 % (transducer) and 0.2 % (gage), one standard uncertainty;
so the certificate says 0.8 % and 0.4 % with k = 2. The calibration goes up and down through ten known values, each set by hand to 0.001 in or 0.05 lb, and is that of \`matrig calibrate\`: a straight line. Then
the temperature is another, by 10 K at most, and a landing is read once: a movement of 0.3 to 2.5 in, a tension of 50 to 350 lb. The error is the reading less the truth. The budget ([what it is](../explanation/errors.md#two-numbers-for-one-reading)) knows the calibration,
the certificate and the 10 K, not what was drawn; the program that draws does not contain it.

$(table <<<"$whole")

*Holds*: of how many draws the error is within the 95 % interval; then the interval within which the true share lies (Wilson). The stated error of a reading alone is no interval for the distance from the truth: it leaves
out certificate and temperature. The same with $((8 * draws)) draws:

$(table <<<"$more")

What the sum is made of, as root mean square of the $draws draws, beside the error as it was:

$(sed -n '6,$p' <<<"$whole")

The check can fail. Without the certificate in the sum:

$(of --without certificate | table)

and without the temperature (a gage's is in its stated drift):

$(of --without temperature | table)

A first version of the budget counted what a straight line leaves of the sensor's curve once, at the reading; of 4,000 drawn movements its interval held 94.0 % (93.3 to 94.7). A movement is a difference
of two readings, so it counts where the movement began, too.

What is not drawn: the station (its row is 0 here), a sensor that ages, gage factor against temperature, loads across a sensor's axis.
P
