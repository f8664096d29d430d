/* What the predictor costs on the board, from what it counts. Instructions of the firmware's own
 * objects in the emulated board (tests/hil/test_predictor_cost.c holds them against it), x 1.5 for
 * cycles; divisions and roots 14. */
#ifndef MATRIG_TESTS_ERROR_REPORT_PREDICTOR_COST_H
#define MATRIG_TESTS_ERROR_REPORT_PREDICTOR_COST_H

#define PREDICTOR_PER_UPDATE        71.0
#define PREDICTOR_PER_VISIT         37.0
#define PREDICTOR_PER_BLOCK         1570.0
#define PREDICTOR_DIVIDES_PER_BLOCK 35.0
#define PREDICTOR_INSTRUCTIONS(updates, visits, blocks)                  \
    (PREDICTOR_PER_UPDATE * (updates) + PREDICTOR_PER_VISIT * (visits) + \
     PREDICTOR_PER_BLOCK * (blocks))
#define PREDICTOR_CYCLES(updates, visits, blocks)            \
    (1.5 * PREDICTOR_INSTRUCTIONS(updates, visits, blocks) + \
     12.5 * PREDICTOR_DIVIDES_PER_BLOCK * (blocks))

#endif
