/* A landing as measured: time base, gear, displacements and tensions, read back from the campaign
 * database.
 *
 * Time t_s is counted from touchdown (without a fit, from the first edge; without edges, from
 * arming). Samples are 1 ms blocks; a sample's time is the middle of its eight scans. Displacements
 * and tensions are computed here from the block records with the board's own calibration. Block
 * records are received over serial or read from the black box. A block without a block record is
 * filled from CAN messages, each of which is the mean of 2 or 4 blocks; a landing without block
 * records has CAN messages only. The source of each sample is stored. In a recalibrated landing,
 * CAN messages are not used, because the board computed them with the old calibration. Values from
 * another instrument (matrig import) are used unchanged. A displacement is relative to its mean
 * over the half second before the first edge; a tension is absolute. Missing and invalid values are
 * NaN. A stuck channel is invalid from the time at which it stopped moving, which is before the
 * fault could be detected.
 *
 * The largest of many noisy means is above the true value. Therefore a peak is located with every
 * second reading, and its value is the mean of the other readings, whose noise is independent of
 * the choice; this is done with both halves of the readings. Standard errors are those of
 * common/channels.h. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_H
#define MATRIG_HOST_ANALYSE_MEASURED_H

#include "common/gates.h"
#include "common/channels.h"
#include "host/base/cli.h"
#include "host/store/store.h"

#define MEASURED_BASELINE_BLOCKS    500
/* For long landings: if a landing has more than twice this number of blocks, only this many blocks
 * before the first edge are loaded (without an edge, before the end of the record). */
#define MEASURED_BEFORE_EDGE_BLOCKS 60000
/* length, in blocks, of the moving mean in which peaks are located */
#define MEASURED_MEAN_BLOCKS        11
/* length, in blocks, of the mean that is the final value of a channel */
#define MEASURED_FINAL_MEAN_BLOCKS  200
#define MEASURED_MISSING            255 /* value of `validity`: the block is missing */
#define MEASURED_INVALID            254 /* value of `validity`: not valid, and CAN gave no reason */

enum measured_source {
    MEASURED_NO_SOURCE,
    MEASURED_SERIAL,
    MEASURED_CAN,
    MEASURED_BOX,
    MEASURED_IMPORT
};
#define MEASURED_SOURCE_COUNT 5u

/* Consecutive blocks with the same source. The source is that of their block records; CAN if CAN
 * messages filled any channel. */
struct measured_source_stretch {
    enum measured_source source;
    int64_t from_block, to_block; /* first and last block of the stretch */
};

struct measured_channel {
    struct mr_channel_config config;
    /* reading of each sample, in inches or pounds; the baseline is not subtracted */
    float *raw;
    uint8_t *validity;    /* enum mr_validity, MEASURED_MISSING or MEASURED_INVALID */
    uint8_t *source;      /* enum measured_source: the source of each sample */
    size_t valid_samples; /* number of samples with MR_VALID */
    double baseline;      /* mean at rest before the first edge; NaN: not known */
    double noise;         /* standard deviation of one sample before the first edge */
    size_t rest_samples;  /* number of samples in the baseline */
    /* Number of consecutive samples that share one value. 1 for block records; the number of blocks
     * in the mean of a CAN message, if any sample is from CAN; the stored number for an imported
     * file. */
    size_t stride;
    size_t phase; /* a CAN message begins at sample i if `stride` divides i + phase */
    /* The next fields describe the value from the first edge on (raw, for displacements minus the
     * baseline). */
    double high, low;  /* largest and smallest value of the moving mean */
    double peak;       /* high or low, whichever has the larger magnitude */
    double end;        /* final value: mean of the last MEASURED_FINAL_MEAN_BLOCKS blocks */
    double peak_error; /* standard error of the peak */
    double high_error, low_error, end_error;
    /* Longest stretch of invalid samples in which a moving mean has no valid sample either: samples
     * missing_start to missing_end - 1. If both are equal, there is no such stretch. */
    size_t missing_start, missing_end;
};

/* Records that were excluded because their time is far from that of the landing. Such records form
 * a group that is separated by a pause of at least half a minute and is small compared with the
 * largest group. */
struct measured_excluded {
    size_t blocks, messages, edges;
    int64_t first_block; /* block of the first excluded record */
};

struct measured_landing {
    struct store_landing landing;
    enum measured_source source; /* source of most block records; without block records, CAN */
    struct measured_source_stretch *stretch; /* stretches in order, without gaps */
    size_t stretch_count;
    int64_t blocks_by_source[MEASURED_SOURCE_COUNT]; /* number of samples from each source */
    int64_t first_block;
    /* number of earlier blocks that were not loaded (see MEASURED_BEFORE_EDGE_BLOCKS) */
    int64_t skipped_blocks;
    struct measured_excluded excluded;
    size_t samples;
    int64_t t0_us; /* board time of t_s = 0 */
    bool is_t0_touchdown;

    /* edges of known switches in order of time; times are t_s (see above) */
    struct mr_gate gate[MR_GATES_MAX];
    size_t gate_count;
    size_t edge_count;            /* number of captured edges, named or not */
    size_t switch_count;          /* number of fitted switches in the board's table */
    uint64_t fitted_switches;     /* bit p-1: switch p is fitted */
    uint64_t switches_with_edges; /* bit p-1: switch p has an edge */
    double switch_ft[64];         /* station of switch p at index p-1, for fitted switches */
    /* number of edges that the record lacks according to the board's own result */
    size_t missing_edges;
    /* the board's result was received, which shows that no other edges are missing */
    bool has_board_result;
    /* without the board's result: a switch that the gear should have passed during a gap in the
     * record; 0: none */
    unsigned switch_in_data_gap;
    /* first of several switches before the computed stop that never opened; 0: none */
    unsigned unopened_switch;
    /* Status of the summary. MR_OK: there is a summary. MR_TRUNCATED: the record ends while the
     * gear moves, or edges are missing, so only the touchdown of the summary is known. MR_TOO_FEW:
     * too few edges, or the first edges are missing. */
    enum mr_status fit_status;
    /* Times are t_s. Errors include the clock error if the board does not run from its crystal. */
    struct mr_gates_summary summary;
    struct track *track; /* the gear's position at any time (track.h); NULL: no summary */

    struct measured_channel channel[MR_CHANNELS];
    int64_t first_edge; /* number that the board gave the first received edge; 0: none */
    /* edges before first_edge are missing; results that need them are not given */
    bool is_start_missing;
    /* is_start_missing is true, and the record begins after arming: the mat may have moved before,
     * so there are no baselines */
    bool has_no_baseline;
    /* channels whose calibration was changed after the landing: bit mask by channel index */
    int64_t recalibrated_channels;
    bool has_calibration_dates; /* the configuration was read, so calibration dates are known */
    struct mr_site_config site; /* 0 in all fields if the configuration was not read */
    /* at least one channel that was not recalibrated has no calibration date; false if dates are
     * not known */
    bool is_uncalibrated;
};

void measured_free(struct measured_landing *measured);
/* Writes "incomplete: ...", to be printed above numbers; "" if the landing has its first edges. */
#define MEASURED_MISSING_START_SIZE 120u
void measured_format_missing_start(const struct measured_landing *measured,
                                   char out[MEASURED_MISSING_START_SIZE]);
/* Returns the origin of t_s as text: "touchdown", "the first switch edge" (with " received" if the
 * first edges are missing), "arming" or "the record's begin". Static storage. */
const char *measured_origin_text(const struct measured_landing *measured);
/* Returns true if the landing's board was emulated: its readings are synthetic
 * (common/emulated.h). */
bool measured_is_emulated(const struct store_landing *landing);
/* Returns the marks to print after any number of the landing: "", ", incomplete", ", UNCALIBRATED"
 * or ", calibration unknown" (the configuration was not read). ", incomplete" may be followed by
 * one of the other two. Static storage. */
const char *measured_quality_text(const struct measured_landing *measured);
/* Writes why the stop is not known, as part of a sentence. For fit_status MR_TRUNCATED. */
#define MEASURED_REASON_SIZE 100
void measured_format_unknown_stop(const struct measured_landing *measured,
                                  char out[MEASURED_REASON_SIZE]);

/* Returns true if the record ends while the gear moves or may still move. */
bool measured_ends_while_moving(const struct measured_landing *measured);
/* Returns "moves" or "may still move", for a record that ends early. Static storage. */
const char *measured_motion_at_end_text(const struct measured_landing *measured);

double measured_time_s(const struct measured_landing *measured, size_t sample);
/* Converts the start of a block of the board to t_s. */
double measured_block_time_s(const struct measured_landing *measured, int64_t block);
/* Returns the value of a channel in its unit: displacement relative to the baseline, tension
 * absolute. NaN: missing. */
double measured_value(const struct measured_channel *channel, size_t sample);
/* Returns the mean of the valid values within `half` samples of `sample`; NaN if none is valid. */
double measured_moving_mean(const struct measured_landing *measured,
                            const struct measured_channel *channel, size_t sample, size_t half);
/* Returns the standard error (common/channels.h) of `value`, the mean of `samples` samples. `value`
 * is as returned by measured_value. */
double measured_standard_error(const struct measured_landing *measured,
                               const struct measured_channel *channel, double value,
                               double samples);
/* Returns the input from which measured_standard_error computes the standard error. */
struct mr_error_conditions measured_error_conditions(const struct measured_landing *measured,
                                                     const struct measured_channel *channel,
                                                     double value, double samples);
/* Computes t0_us, the gate times relative to t0_us, the summary and the fit from the gates and the
 * landing. */
void measured_fit_gear_motion(struct measured_landing *measured);
/* Computes stretch, stretch_count and blocks_by_source from the sources of the channels'
 * samples. */
void measured_find_source_stretches(struct measured_landing *measured);
/* Computes baseline, noise, extremes and their errors for every channel from the samples and the
 * first gate. The last step of measured_load. */
void measured_compute_results(struct measured_landing *measured);
/* Return the station and the speed of the lead wheel at a time. NaN before touchdown or without a
 * fit. After the stop the speed is 0. */
double measured_station_ft(const struct measured_landing *measured, double t_s);
double measured_speed_ft_s(const struct measured_landing *measured, double t_s, double *error_ft_s);
/* Returns the time at which the lead wheel reaches a station beyond touchdown. NaN: the wheel stops
 * before that station, or there is no fit. */
double measured_arrival_time_s(const struct measured_landing *measured, double station_ft);
/* Returns the index of the channel of transducer or gage `number`; -1: none. */
int measured_channel_index(const struct measured_landing *measured, enum mr_channel_kind kind,
                           unsigned number);
/* Lists the measuring channels in the order of tables: displacements from 1, then tensions from 1.
 * `channels` has room for MR_CHANNELS entries. Returns their number. */
size_t measured_list_channels(const struct measured_landing *measured,
                              const struct measured_channel **channels);

/* Finds the extremes of the moving mean of the value (measured_value) from sample `from` on. Each
 * extreme is located in every second reading, and its value is the mean of the other readings; both
 * halves are used (see the file comment). NaN: no mean has a valid reading. */
void measured_find_peaks(const struct measured_landing *measured,
                         const struct measured_channel *channel, size_t from, double *high,
                         double *low);
/* Returns the number of samples in the mean of a peak, for measured_standard_error. */
double measured_peak_sample_count(const struct measured_channel *channel);

#define MEASURED_SOURCE_SIZE 600

/* Name of a source: "serial", "can", "blackbox", "import", "none". Static storage. */
const char *measured_source_name(enum measured_source source);
/* Returns a source as one letter for tables: S, C, B, I, and - for none. */
char measured_source_letter(enum measured_source source);
/* Describes the sources of the samples: "serial block records, 1 kHz", the parts filled from CAN
 * and the black box, and the missing parts. */
void measured_format_source(const struct measured_landing *measured,
                            char out[MEASURED_SOURCE_SIZE]);
/* Prints a note about the excluded records. For output that does not contain the text of
 * measured_format_source, which mentions them too. */
void measured_print_excluded(const struct measured_landing *measured, const struct cli *cli);
/* Returns the numbers of excluded records as JSON; null if there are none. */
json_t *measured_excluded_json(const struct measured_landing *measured);

#endif
