/* A landing as measured: time base, gear, displacements and tensions, read back from the campaign
 * database.
 *
 * Time t_s counts from touchdown (from the first edge when there is no fit, from arming without
 * edges). Samples are 1 ms blocks; a sample's time is the middle of its eight scans. Displacements
 * and tensions are computed here from the block records with the board's own calibration. Block
 * records come over serial or from the black box; a block that neither brought is filled from the
 * CAN messages, each over the 2 or 4 blocks it is the mean of, and so is a landing without any.
 * Each sample has its source. CAN does not fill a recalibrated landing: the board computed its
 * messages with the old calibration. Values of another instrument (matrig import) are those of its
 * file. A displacement is relative to its mean over the half second before the first edge; a
 * tension is absolute. What is missing or not valid is NaN. A stuck channel is not valid from the
 * time at which it stopped moving, which is before the fault could be detected.
 *
 * A peak is located in every second reading and its value taken from the others, both ways round:
 * the largest of many noisy means is above the truth, but the noise of the others is independent of
 * the choice. Standard errors are those of common/channels.h. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_H
#define MATRIG_HOST_ANALYSE_MEASURED_H

#include "common/gates.h"
#include "common/channels.h"
#include "host/base/cli.h"
#include "host/store/store.h"

#define MEASURED_BASELINE_BLOCKS 500
/* of a landing of more than twice that, before the first edge, or the end when there is none */
#define MEASURED_BEFORE_BLOCKS   60000
#define MEASURED_WINDOW          11  /* blocks of the moving mean in which peaks are looked for */
#define MEASURED_END_BLOCKS      200 /* mean over these is where a channel ended */
#define MEASURED_LOST            255 /* validity: the block is missing */
#define MEASURED_NOT_VALID       254 /* validity: not valid, without a reason from CAN */

enum measured_source {
    MEASURED_NOTHING,
    MEASURED_SERIAL,
    MEASURED_CAN,
    MEASURED_BOX,
    MEASURED_IMPORT
};
#define MEASURED_SOURCES 5u

/* Blocks in a row of one source: as of their records; CAN where it filled any channel. */
struct measured_stretch {
    enum measured_source source;
    int64_t from_block, to_block; /* both in it */
};

struct measured_channel {
    struct mr_channel_config config;
    float *raw;        /* per sample, in or lb, as read */
    uint8_t *validity; /* enum mr_validity or one of the two above */
    uint8_t *source;   /* enum measured_source: the source of each sample */
    size_t valid;      /* samples with MR_VALID */
    double baseline;   /* mean before the first edge; NaN: none */
    double noise;      /* standard deviation of one sample there */
    size_t rest;       /* samples in the baseline */
    /* samples that have one value: 1; as many as a CAN message is the mean of when any is from
     * CAN */
    size_t stride;
    size_t phase; /* a message begins at each sample i for which `stride` divides i + phase */
    /* Of the value (raw, less the baseline for displacements), from the first edge on: */
    double high, low; /* extremes of the moving mean */
    double peak;      /* high or low, whichever is larger in size */
    double end;
    double error; /* standard error of the peak */
    double high_error, low_error, end_error;
    /* The longest stretch without a valid sample in which a moving mean has none either: from this
     * sample, before that one. Equal: there is none. */
    size_t missing_from, missing_to;
};

/* Records set aside because their time is far from the landing's: a group of seconds, beyond a
 * pause of half a minute, that is small beside the largest. */
struct measured_aside {
    size_t blocks, messages, edges;
    int64_t block; /* of the first of them */
};

struct measured {
    struct store_landing landing;
    enum measured_source source;      /* of most block records; without any CAN */
    struct measured_stretch *stretch; /* in order, without a hole */
    size_t stretches;
    int64_t blocks_from[MEASURED_SOURCES]; /* how many of the samples */
    int64_t first_block;
    /* of a landing that was armed long before: earlier records are in the campaign alone */
    int64_t skipped_blocks;
    struct measured_aside aside;
    size_t samples;
    int64_t t0_us; /* board time of t_s = 0 */
    bool t0_is_touchdown;

    struct mr_gate gate[MR_GATES_MAX]; /* named edges in order; t_s as above */
    size_t gates;
    size_t edges;         /* captured, named or not */
    size_t switches;      /* in the board's table, and fitted */
    uint64_t fitted;      /* which: bit p-1: switch p */
    uint64_t seen;        /* bit p-1: switch p */
    double switch_ft[64]; /* station of switch p at p-1; of those fitted */
    /* named by the board and missing in the record, as far as the board's own result shows */
    size_t unheard_edges;
    bool edges_told; /* the board's result is there: none but those are unheard */
    /* without it: a switch that was due where nothing was recorded, and may have opened; 0: none */
    unsigned hidden_switch;
    /* several switches lie before where it seems to have stopped and never opened: the first; 0:
     * none */
    unsigned silent_switch;
    /* of the summary: MR_OK, or why there is none; MR_TRUNCATED: the record ends while the gear
     * moves, or lacks edges, so only the touchdown of the summary is known; MR_TOO_FEW also for a
     * torn landing: its first edges are missing */
    enum mr_status fit_status;
    /* times as t_s; errors include the clock's when it is not the crystal */
    struct mr_gates_summary summary;
    struct mr_gates_fit fit; /* the curve behind it */

    struct measured_channel channel[MR_CHANNELS];
    int64_t first_edge;   /* count of the first edge received; 0: none */
    bool torn;            /* those before it are missing; results that need them are not stated */
    int64_t recalibrated; /* channels with another calibration than in the landing: bit of index */
    bool dates_known;     /* of calibration: the configuration was read */
    bool uncalibrated;    /* another channel has none; false too where they are not known */
};

void measured_free(struct measured *measured);
/* "torn: ...", to be printed above numbers; "": the landing has its first edges. */
#define MEASURED_TORN_TEXT 100u
void measured_torn_text(const struct measured *measured, char out[MEASURED_TORN_TEXT]);
/* The landing's board was an emulated one, so its readings are synthetic (common/emulated.h). */
bool measured_is_emulated(const struct measured *measured);
/* What a reader must know of any number of it: "", ", torn", then ", UNCALIBRATED" or ",
 * calibration unknown" (its configuration was not read), or both. Static. */
const char *measured_marks(const struct measured *measured);
/* Of MR_TRUNCATED: why no stop is known, as part of a sentence. */
#define MEASURED_REASON 100
void measured_no_stop_text(const struct measured *measured, char out[MEASURED_REASON]);

/* The record ends while the gear moves, or may. */
bool measured_ends_early(const struct measured *measured);
/* Which of both: "moves", "may still move". Static storage. */
const char *measured_moves_text(const struct measured *measured);

double measured_time_s(const struct measured *measured, size_t sample);
/* Beginning of a block of the board, as t_s. */
double measured_block_s(const struct measured *measured, int64_t block);
/* Value of a channel in its unit: displacement since the baseline, tension absolute. NaN:
 * missing. */
double measured_value(const struct measured_channel *channel, size_t sample);
/* Mean of the valid values within `half` samples of `sample`; NaN when none is. */
double measured_smooth(const struct measured *measured, const struct measured_channel *channel,
                       size_t sample, size_t half);
/* Standard error (common/channels.h) of the mean of `samples` samples, `value`, as measured_value
 * has it. */
double measured_error(const struct measured *measured, const struct measured_channel *channel,
                      double value, double samples);
/* What that is computed from. */
struct mr_error_case measured_error_case(const struct measured *measured,
                                         const struct measured_channel *channel, double value,
                                         double samples);
/* t0_us, the gates' times since then, summary and fit, from gates and landing. */
void measured_fit_gear(struct measured *measured);
/* stretch, stretches and blocks_from from the channels' sources. */
void measured_find_stretches(struct measured *measured);
/* Baseline, noise, extremes and their errors of every channel, from the series and the first gate:
 * what measured_load does last. */
void measured_find_facts(struct measured *measured);
/* Station and speed of the lead wheel at a time; NaN before touchdown or without a fit, at rest
 * after the stop. */
double measured_station_ft(const struct measured *measured, double t_s);
double measured_speed_ft_s(const struct measured *measured, double t_s, double *error_ft_s);
/* Time at which the lead wheel reaches a station beyond touchdown; NaN: it stops before, or there
 * is no fit. */
double measured_reach_s(const struct measured *measured, double station_ft);
/* Channel index of transducer or gage `number`; -1: none. */
int measured_find(const struct measured *measured, enum mr_channel_kind kind, unsigned number);
/* The measuring channels as tables have them: displacements 1.., then tensions 1... `channels` has
 * room for MR_CHANNELS; how many. */
size_t measured_in_order(const struct measured *measured, const struct measured_channel **channels);

/* Where a channel's peaks are: the largest and the least mean of a few readings. */

/* The extremes of the moving mean from sample `from` on, of the value (measured_value): each looked
 * for in every second reading and taken from the others, both ways round. NaN: no mean has a valid
 * reading. */
void measured_peaks(const struct measured *measured, const struct measured_channel *channel,
                    size_t from, double *high, double *low);
/* How many samples one of these is the mean of, for measured_error. */
double measured_peak_samples(const struct measured_channel *channel);

/* Sources of the samples of a measured landing: serial, the black box, CAN, a file of another
 * instrument, or none. */

#define MEASURED_SOURCE_TEXT 600

/* "serial", "can", "blackbox", "import", "none". Static storage. */
const char *measured_source_name(enum measured_source source);
/* The same as one letter of a table: S, C, B, I, and - for none. */
char measured_source_letter(enum measured_source source);
/* In words: "serial block records, 1 kHz", and the parts filled from CAN and the black box, and
 * those missing. */
void measured_source_text(const struct measured *measured, char out[MEASURED_SOURCE_TEXT]);
/* What was set aside because of its time, a part of the text above, as a note where that text is
 * not shown. */
void measured_aside_note(const struct measured *measured, const struct cli *cli);
/* The same in numbers; null: nothing. */
json_t *measured_aside_json(const struct measured *measured);

#endif
