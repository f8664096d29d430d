/* Ready? What is known of a board, its campaign and this computer before a landing, and whether
 * that is go or no-go; and asking a board over serial for it.
 *
 * Facts in, checks out. Limits are stated with each check; what could not be found out is reported
 * as not done, which is no no-go, and is named in the verdict. */
#ifndef MATRIG_HOST_BOARD_READY_H
#define MATRIG_HOST_BOARD_READY_H

#include <jansson.h>
#include <stdio.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/config.h"
#include "common/fault.h"
#include "host/board/certificates.h"
#include "host/board/dialogue.h"
#include "host/board/gage_client.h"
#include "host/link/timemap.h"

#define READY_CHECKS          96u
#define READY_NOISE_CODES     3.0f /* of a block's mean: 2 LSB a conversion leave 0.71 */
/* a mat at rest so far from its zero was left where a landing put it */
#define READY_ZERO_IN         0.25f
#define READY_PRETENSION      0.10f /* relative, of a band's mean */
#define READY_GAGE_PRETENSION 0.25f /* and of each of its gages */
#define READY_SHUNT_DRIFT     0.01f /* relative, since the last one kept */
/* level of the staircase beyond its zero: less than any switch */
#define READY_LATCH_CODES     8.0f
#define READY_CLOCK_PPM       200.0 /* board's crystal and this computer's together */
#define READY_LANDING_BYTES   4.0e6 /* of a campaign without any: 10 s of both links */
#define READY_LANDINGS        10.0  /* there must be room for */
#define READY_BLOCKS          100u  /* readings a check of a channel rests on, when they come */
#define READY_BLOCKS_KEPT     256u

enum ready_verdict { READY_GO, READY_NO_GO, READY_NOT_DONE };

#define READY_VALUE 500u /* bytes: of several faults, all are listed */

struct ready_check {
    char name[20];
    enum ready_verdict verdict;
    char value[READY_VALUE];
    char limit[80];   /* empty: none */
    char advice[160]; /* empty unless no-go or not done */
};

struct ready_report {
    struct ready_check check[READY_CHECKS];
    unsigned count;
    bool uncalibrated; /* a sensor has no date of calibration: records are marked with it */
};

/* A channel at rest, by block records. */
struct ready_channel {
    unsigned blocks, invalid;
    uint8_t validity;  /* the last that was not valid */
    float mean;        /* in, lb; codes of staircase and reference. NaN: none valid */
    float noise_codes; /* standard deviation of a block; NaN: fewer than two */
};

struct ready_facts {
    /* what was asked for */
    uint32_t today_day;           /* from 1970-01-01 */
    int64_t now_s;                /* Unix time */
    const struct mr_image *image; /* NULL: compare with the campaign's last landing */
    const char *image_path;
    bool crc_expected;
    uint32_t expected_crc;
    /* of a file: but for its revision, which storing it has raised; NULL: the CRC counts */
    const struct mr_config *expected_config;
    bool can_used;
    bool si; /* quantities are printed in SI units */

    /* campaign and computer */
    bool before; /* the campaign has a landing of this board: the last one's */
    int64_t before_run, before_image, before_config; /* STORE_NONE: not known */
    float before_span_lb[MR_GAGES];                  /* last shunt calibration kept; NaN: none */
    struct certificates certificates;                /* of their sensors */
    char database[200];                              /* what is wrong with it; empty: nothing */
    bool database_checked;                           /* its pages, all in time */
    double free_bytes, landing_bytes;

    /* the board */
    struct identity identity;
    uint32_t config_crc;
    struct mr_config config;
    struct mr_config_state config_state;
    uint32_t zero_told, zero_measured; /* bit per channel: zero reported; measured since reset */
    unsigned blocks;                   /* records received; 0: no scans, or the board is not idle */
    unsigned blocks_lost;              /* by the board, meanwhile */
    struct ready_channel channel[MR_CHANNELS];
    struct timemap_fit time;

    bool shunt_done;
    enum mr_status shunt_status;
    struct shunts shunts;

    bool tested;
    struct mr_self_test test;
    bool box_known;
    struct mr_box_state box;
    struct mr_box_space space;
    bool temperature_known;
    struct mr_temperature temperature;
    bool alarm_known;
    struct mr_can_alarm alarm;
    bool restarts_known;
    struct mr_restarts restarts;
    int64_t can_frames, can_lost, can_dropped; /* of this board, or who is at its base */
    uint16_t can_base;
    struct identity on_can; /* the board there; uid 0: not identified */
    int64_t serial_frames, serial_lost, serial_dropped;
    struct mr_fault fault[MR_FAULT_COUNT]; /* count 0: none since reset */
    uint16_t fault_rise[MR_FAULT_COUNT];   /* while it was looked at */
};

/* Readings of channel `c` in `count` block records. */
void ready_measure(const struct mr_config *config, const struct mr_block *blocks, unsigned count,
                   unsigned c, struct ready_channel *channel);

void ready_judge(const struct ready_facts *facts, struct ready_report *report);
/* Only the certificates of the sensors, a part of it. */
void ready_judge_certificates(const struct ready_facts *facts, struct ready_report *report);
/* No-go when any check is. */
enum ready_verdict ready_verdict(const struct ready_report *report);
unsigned ready_count(const struct ready_report *report, enum ready_verdict verdict);
/* "GO", "NO-GO", "not done"; static storage. */
const char *ready_text(enum ready_verdict verdict);
/* Adds a check; the value is printf's. `limit` and `advice` may be NULL; a check that is go has no
 * advice. Beyond READY_CHECKS nothing is added. */
void ready_add(struct ready_report *report, enum ready_verdict verdict, const char *name,
               const char *limit, const char *advice, const char *format, ...)
    __attribute__((format(printf, 6, 7)));
/* Each check in lines of at most `columns` (60 at least), then the verdict. */
void ready_print(const struct ready_report *report, double took_s, unsigned columns, FILE *out);
/* An array of {name, verdict, value, limit, advice}; the caller owns it. */
json_t *ready_json(const struct ready_report *report);

/* Fills the board's part of `facts`: makes a board that is done with a landing idle, reads its
 * configuration, and asks for everything else, within `limit_s` (what does not come stays unknown).
 * Its CAN is listened to meanwhile, where the dialogue has it. Statuses as config_client_meet. */
enum mr_status ready_ask(struct dialogue *dialogue, double limit_s, struct ready_facts *facts,
                         struct error *error);

#endif
