/* The application: what the board does with blocks, edges and commands. See main.c for the loop
 * that drives it. */
#ifndef MATRIG_FIRMWARE_APP_H
#define MATRIG_FIRMWARE_APP_H

#include "common/framing.h"
#include "common/onboard/predict_feed.h"
#include "common/onboard/landing.h"
#include "firmware/bandwatch.h"
#include "firmware/boxlink.h"
#include "firmware/calibrate.h"
#include "firmware/camera.h"
#include "firmware/channels.h"
#include "firmware/configstore.h"
#include "firmware/healthlink.h"
#include "firmware/landinglink.h"
#include "firmware/configround.h"
#include "firmware/proof.h"
#include "firmware/runwaystore.h"
#include "firmware/predict.h"
#include "firmware/slowlog.h"
#include "firmware/telemetry.h"
#include "firmware/thermometer.h"

#define APP_DISPLACEMENT_BLOCKS 2u /* of the mean that is told */
#define APP_TENSION_BLOCKS      4u
/* a record begins so many blocks before arming: as far back as the first means reach */
#define APP_BLOCKS_BEFORE       APP_TENSION_BLOCKS
#define APP_NEWEST              8u /* blocks kept: those, and the one that comes */
/* Taken per block, so that no flood of commands keeps blocks waiting or fills the links with
 * answers: two commands from each link. The queues behind hold a whole survey. */
#define APP_CAN_COMMANDS        2u
#define APP_SERIAL_BYTES        36u
/* 50 ms for the answer to go out before the boot ROM takes over */
#define APP_ROM_TICKS           5u

struct app {
    struct landing landing;
    struct telemetry telemetry;
    struct mr_deframer deframer;
    uint32_t next_index; /* of the block expected next */
    uint32_t fitted;     /* bit c: channel c is */
    uint16_t can_base;   /* the one that messages have now */
    bool by_serial;      /* what is obeyed came so */
    bool replays;        /* inputs of a replay are taken */

    struct mr_block newest[APP_NEWEST]; /* by index modulo their number */
    uint32_t blocks_in_row;             /* up to the newest, without a gap */

    /* Readings of the newest block and of the three before it, NaN for one that was lost; a
     * decimated message is the mean of the last 2 or 4. Old ones where no mean is told. */
    float displacement_in[4][MR_TRANSDUCERS];
    float tension_lb[4][MR_GAGES];

    struct baseline baseline;

    struct channels channels;
    float slack_in[MR_SEGMENTS]; /* NaN: not surveyed since a landing */
    struct predict predict;
    struct runwaystore runwaystore;
    struct keystore keystore;
    struct proof proof;
    unsigned ticks_without_block; /* supervision ticks of 10 ms */
    unsigned ticks_to_rom;        /* likewise; 0: the boot ROM was not asked for */

    struct configstore configstore;
    struct bandwatch bandwatch;
    struct calibrate calibrate;
    struct timesync timesync;
    struct camera camera;
    struct live live;
    struct boxlink boxlink;
    struct healthlink healthlink;
    struct blackbox box;
    struct thermometer thermometer;
    struct slowlog slowlog;
};

void app_start(struct app *app);
/* The configuration is another one, or is known now: begins the scans of what is fitted, forgets
 * readings, uses the black box or not. Only while nothing is recorded. */
void app_configured(struct app *app);
/* Everything that is due: commands, then each block that is ready. Returns true when there was a
 * block. */
bool app_poll(struct app *app);
/* Supervision, every 10 ms: restarts scans that stopped, and keeps talking when there are none at
 * all. */
void app_supervise(struct app *app);

#endif
