/* A recorded landing's predictor once more, as the board ran it: the firmware's own way from block
 * records and edges to the model (common/onboard/landing.h, common/onboard/predict_feed.h), armed
 * with the runway and the parameters that the board told. What comes out is held against what the
 * board said, field by field, as the wire has it: the same bits make the same digits. */
#ifndef MATRIG_HOST_ANALYSE_PREDICT_AGAIN_H
#define MATRIG_HOST_ANALYSE_PREDICT_AGAIN_H

#include "host/store/store_predict.h"

struct predict_again {
    bool possible;     /* the record holds all that is needed */
    const char *lacks; /* what it does not, when it is not possible */
    /* statements of the board, and of the host in the blocks that the record has */
    size_t said, made;
    size_t fields, differ;
    /* fields and statements that did not come, where the record says that frames were lost */
    size_t lost;
    /* the first that the record lacks: the comparison ends there; STORE_NONE: none */
    int64_t lacks_block;
    struct {
        int64_t block;
        char field[24];
        double said, made; /* NaN: none */
    } first;               /* difference */
    size_t backlogs;
    int64_t warned_block; /* that decided the first warning; STORE_NONE: none */
};

/* MR_OK also when it is not possible: `lacks` says why. */
enum mr_status predict_again(struct store *store, int64_t run, struct predict_again *again,
                             struct error *error);

#endif
