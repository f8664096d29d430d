/* The application: processing of blocks, edges and commands on the board. The loop in main.c drives
 * it. */
#ifndef MATRIG_FIRMWARE_APP_H
#define MATRIG_FIRMWARE_APP_H

#include "common/framing.h"
#include "common/onboard/predict_feed.h"
#include "common/onboard/landing.h"
#include "firmware/bandwatch.h"
#include "firmware/boxlink.h"
#include "firmware/calibrate.h"
#include "firmware/braking.h"
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

/* number of blocks averaged in a message of displacements and in one of tensions */
#define APP_DISPLACEMENT_BLOCKS    2u
#define APP_TENSION_BLOCKS         4u
/* number of blocks in a record before arming; the first means include these blocks */
#define APP_BLOCKS_BEFORE_ARMING   APP_TENSION_BLOCKS
/* number of stored blocks: those before arming, and new ones */
#define APP_NEWEST_BLOCKS          8u
/* Input processed per block: two commands from each link. The limit prevents a flood of commands
 * from delaying blocks or filling the links with answers. The input queues are large enough for a
 * complete survey. */
#define APP_CAN_COMMANDS_PER_BLOCK 2u
#define APP_SERIAL_BYTES_PER_BLOCK 36u
/* 50 ms for sending the answer before the boot ROM starts */
#define APP_BOOTROM_DELAY_TICKS    5u

struct app {
    struct landing landing;
    struct telemetry telemetry;
    struct mr_deframer deframer;
    uint32_t next_index;      /* index of the next expected block */
    uint32_t fitted_channels; /* bit c: channel c is fitted */
    uint16_t can_base;        /* current base of the identifiers */
    bool is_sent_by_serial;   /* the command being executed was received by serial */
    bool is_replay;           /* the command replay was accepted */

    /* the block with index i is at i modulo APP_NEWEST_BLOCKS */
    struct mr_block recent_blocks[APP_NEWEST_BLOCKS];
    uint32_t consecutive_blocks; /* number of consecutive blocks up to the newest one */

    /* Readings of the newest block and of the three before it, NaN for a lost block. A message
     * contains the mean of the last 2 or 4. They are not updated while no means are sent. */
    float displacement_in[4][MR_TRANSDUCERS];
    float tension_lb[4][MR_GAGES];

    struct baseline baseline;

    struct channels channels;
    /* surveyed slack of each segment; NaN: not surveyed since the last landing */
    float slack_in[MR_SEGMENTS];
    struct predict predict;
    struct runwaystore runwaystore;
    struct keystore keystore;
    struct proof proof;
    unsigned ticks_without_block; /* number of supervision ticks (10 ms) without a block */
    /* number of supervision ticks until the boot ROM starts; 0: not requested */
    unsigned ticks_until_boot_rom;

    struct configstore configstore;
    struct bandwatch bandwatch;
    struct calibrate calibrate;
    struct timesync timesync;
    struct camera camera;
    struct braking braking;
    struct live live;
    struct boxlink boxlink;
    struct healthlink healthlink;
    struct blackbox box;
    struct thermometer thermometer;
    struct slowlog slowlog;
};

void app_start(struct app *app);
/* Call when the configuration is known or has changed: starts the scans of the fitted channels,
 * discards readings, and enables or disables the black box. Only while nothing is recorded. */
void app_apply_configuration(struct app *app);
/* Processes everything that is due: commands, then each block that is ready. Returns true if there
 * was a block. */
bool app_poll(struct app *app);
/* Supervision, every 10 ms: restarts stopped scans, and sends messages in place of the block
 * processing while there are no scans. */
void app_supervise(struct app *app);

#endif
