/* Readiness check before a landing: collects facts about a board (requested over serial), its
 * campaign and this computer, and decides go or no-go for each.
 *
 * Each check states its limit. A fact that could not be determined gives a check "not done", which
 * is not a no-go; the verdict then mentions it. */
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

#define READY_CHECKS_MAX                96u
/* largest standard deviation of block means; converter noise of 2 LSB per conversion gives 0.71 */
#define READY_NOISE_MAX_CODES           3.0f
/* Largest distance of a mat at rest from its zero. A larger distance means that the mat was not
 * moved back after a landing. */
#define READY_REST_MAX_IN               0.25f
#define READY_PRETENSION_TOLERANCE      0.10f /* relative tolerance of the mean tension of a band */
#define READY_GAGE_PRETENSION_TOLERANCE 0.25f /* relative tolerance of the tension at each gage */
/* largest accepted relative change since the last stored shunt calibration */
#define READY_SHUNT_DRIFT_MAX           0.01f
/* Largest level of the staircase signal above its zero, less than the step of any switch. */
#define READY_STAIRCASE_MAX_CODES       8.0f
/* limit of the sum of the errors of the board's crystal and this computer's clock */
#define READY_CLOCK_ERROR_MAX_PPM       200.0
/* size assumed for a campaign without landings: 10 s of both links */
#define READY_DEFAULT_LANDING_BYTES     4.0e6
/* number of landings for which there must be room on the disk */
#define READY_FREE_LANDINGS_MIN         10.0
/* number of block records that are awaited for the check of a channel */
#define READY_BLOCKS_REQUESTED          100u
#define READY_BLOCKS_MAX                256u

enum ready_verdict { READY_GO, READY_NO_GO, READY_NOT_DONE };

#define READY_VALUE_SIZE 500u /* bytes; a check with several faults lists all of them */

struct ready_check {
    char name[20];
    enum ready_verdict verdict;
    char value[READY_VALUE_SIZE];
    char limit[80];   /* empty: no limit */
    char advice[160]; /* empty unless the verdict is no-go or not done */
};

struct ready_report {
    struct ready_check check[READY_CHECKS_MAX];
    unsigned count;
    bool is_uncalibrated; /* a sensor has no calibration date: records are marked as uncalibrated */
};

/* Readings of a channel at rest, from block records. */
struct ready_channel {
    unsigned block_count, invalid_count;
    uint8_t validity; /* the last validity that was not MR_VALID */
    float mean; /* mean in in or lb; in codes for staircase and reference. NaN: no valid block */
    float noise_codes; /* standard deviation within a block; NaN: fewer than two blocks */
};

struct ready_inputs {
    /* What is checked, and the values it is compared with. */
    uint32_t today_day; /* days since 1970-01-01 */
    int64_t now_s;      /* Unix time */
    /* image that the board should run; NULL: the image of the campaign's last landing */
    const struct mr_image *image;
    const char *image_path;
    bool has_expected_crc;
    uint32_t expected_crc;
    /* Expected configuration from a file, compared except for its revision, which increases at
     * every storing. NULL: only the CRC is compared. */
    const struct mr_config *expected_config;
    bool is_can_used;
    bool si; /* print quantities in SI units */

    /* Facts about the campaign and this computer. */
    /* the campaign has a landing of this board; the next fields are from the last one */
    bool has_previous_landing;
    /* RUN, image CRC and configuration CRC of that landing; STORE_NONE: not known */
    int64_t previous_run, previous_image_crc, previous_config_crc;
    float previous_span_lb[MR_GAGES]; /* last stored shunt calibration; NaN: none */
    struct certificates certificates; /* certificates of the board's sensors */
    char database_fault[200];         /* fault found in the database; "": none */
    bool database_checked;            /* all database pages were checked within the time limit */
    double free_bytes, bytes_per_landing;

    /* Facts about the board. */
    struct identity identity;
    uint32_t config_crc;
    struct mr_config config;
    struct mr_config_state config_state;
    /* bit masks of channels: zero received from the board; zero measured since its reset */
    uint32_t zero_received_bits, zero_measured_bits;
    /* number of received block records; 0: the board does not scan its channels or is not idle */
    unsigned block_count;
    unsigned lost_block_count; /* number of blocks that the board lost during the check */
    struct ready_channel channel[MR_CHANNELS];
    struct timemap_fit time_fit;

    bool shunt_done;
    enum mr_status shunt_status;
    struct shunts shunts;

    bool self_test_done;
    struct mr_self_test self_test;
    bool box_known;
    struct mr_box_state box_state;
    struct mr_box_space box_space;
    bool temperature_known;
    struct mr_temperature temperature;
    bool alarm_known;
    struct mr_can_alarm alarm;
    bool restarts_known;
    struct mr_restarts restarts;
    /* numbers of CAN frames of this board: received, lost, dropped; also of another board at its
     * CAN base */
    int64_t can_frame_count, can_lost_count, can_dropped_count;
    uint16_t can_base;
    struct identity board_on_can; /* identity of the board on CAN; uid 0: not identified */
    int64_t serial_frame_count, serial_lost_count, serial_dropped_count;
    struct mr_fault fault[MR_FAULT_COUNT];   /* faults of the board; count 0: none since reset */
    uint16_t fault_increase[MR_FAULT_COUNT]; /* increase of the counts during the check */
};

/* Computes the readings of channel `c` from `count` block records. */
void ready_summarize_channel(const struct mr_config *config, const struct mr_block *blocks,
                             unsigned count, unsigned c, struct ready_channel *channel);

void ready_check_all(const struct ready_inputs *facts, struct ready_report *report);
/* Makes the checks of the sensors' certificates, and no others. */
void ready_check_certificates(const struct ready_inputs *facts, struct ready_report *report);
/* Returns the overall verdict, which is no-go if any check is no-go. */
enum ready_verdict ready_verdict(const struct ready_report *report);
unsigned ready_count_checks(const struct ready_report *report, enum ready_verdict verdict);
/* Returns "GO", "NO-GO" or "not done". Static storage. */
const char *ready_verdict_text(enum ready_verdict verdict);
/* Adds a check; the value is formatted as by printf. `limit` and `advice` may be NULL; advice is
 * dropped if the check is go. More than READY_CHECKS_MAX checks are ignored. */
void ready_add_check(struct ready_report *report, enum ready_verdict verdict, const char *name,
                     const char *limit, const char *advice, const char *format, ...)
    __attribute__((format(printf, 6, 7)));
/* Prints each check, wrapped to `columns` characters (minimum 60), then the verdict. */
void ready_print(const struct ready_report *report, double duration_s, unsigned columns, FILE *out);
/* Returns the checks as a JSON array of {name, verdict, value, limit, advice}; the caller owns
 * it. */
json_t *ready_json(const struct ready_report *report);

/* Fills the board's part of `facts` within `limit_s`: sets a board that has finished a landing to
 * idle, reads its configuration and requests the other facts. Facts that do not arrive stay
 * unknown. CAN messages are read at the same time if the dialogue has a CAN link. Statuses as
 * config_client_begin_and_get. */
enum mr_status ready_query_inputs(struct dialogue *dialogue, double limit_s,
                                  struct ready_inputs *facts, struct error *error);

#endif
