/* The built-in configuration, which a new board uses until it receives a different one. It has a
 * constant or a list for each property in which rigs differ. A list calls the macro X once for each
 * fitted sensor.
 *
 * Test images of other rigs redefine some of these: tests/variant. */
#ifndef MATRIG_FIRMWARE_BUILTIN_H
#define MATRIG_FIRMWARE_BUILTIN_H

/* Sensitivity of the transducers with full excitation and half-difference demodulation. */
#define BUILTIN_TRANSDUCER_V_PER_IN 0.5f

/* Transducers: X(number, station_ft) */
/* clang-format off */
#define BUILTIN_TRANSDUCERS(X)                          \
    X(1, 40.0f) X(2, 50.0f) X(3, 60.0f) X(4, 70.0f)     \
    X(5, 80.0f) X(6, 90.0f) X(7, 100.0f) X(8, 110.0f)

/* Gages: X(number, band, station_ft) */
#define BUILTIN_GAGES(X)                                                       \
    X(1, 1, 15.0f) X(2, 1, 30.0f) X(3, 1, 45.0f) X(4, 1, 55.0f)                \
    X(5, 1, 65.0f) X(6, 1, 75.0f) X(7, 1, 85.0f)                               \
    X(8, 2, 15.0f) X(9, 2, 30.0f) X(10, 2, 45.0f) X(11, 2, 55.0f)              \
    X(12, 2, 65.0f) X(13, 2, 75.0f) X(14, 2, 85.0f)
/* clang-format on */

#define BUILTIN_BLACK_BOX         1
#define BUILTIN_CAMERA            0
/* Pulses per revolution of the wheel; 0: neither pick-up nor brake signal is fitted. The rolling
 * radius of the 7 in wheel was chosen as 0.292 ft, within 0.5 %. */
#define BUILTIN_WHEEL_PULSES      0
#define BUILTIN_PREDICTOR         1
#define BUILTIN_UPDATES_PER_BLOCK MR_PREDICTOR_UPDATES_PER_BLOCK

#endif
