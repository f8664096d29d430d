/* Conversion of the predictor's runway state (struct mr_predictor_state) and parameters (struct
 * mr_predictor_config) to and from the stored form, messages and commands. Board and host agree on
 * every bit.
 *
 * Stored form, MR_RUNWAY_IMAGE_BYTES bytes, little-endian:
 *
 *      0  "MRRW"
 *      4  sequence u32: of two copies, the one with the higher number is newer
 *      8  mats u16 | landings u16 | scale IEEE 754 single | openings of joints 1..513 in 0.01 mil,
 *         u16 each, 0 beyond the last
 *     -4  CRC-32 of everything before it
 *
 * The CRC that identifies a state (message runway_store, command runway-take) covers the fields at
 * offset 8 only. Pure functions. */
#ifndef MATRIG_COMMON_RUNWAY_H
#define MATRIG_COMMON_RUNWAY_H

#include "common/catalogue.h"
#include "common/predictor.h"

#define MR_RUNWAY_JOINTS             (MR_CHAIN_MATS + 1u)
#define MR_RUNWAY_BODY_BYTES         (8u + 2u * MR_RUNWAY_JOINTS)
#define MR_RUNWAY_IMAGE_BYTES        (8u + MR_RUNWAY_BODY_BYTES + 4u)
#define MR_RUNWAY_JOINTS_PER_MESSAGE 3u

/* Writes the stored form of a state: MR_RUNWAY_IMAGE_BYTES bytes. */
void mr_runway_encode(const struct mr_predictor_state *state, uint32_t sequence, uint8_t *image);
/* Reads the stored form of a state. MR_OK; MR_MALFORMED: not a stored runway; MR_CRC: damaged.
 * mr_predictor_load checks whether the state fits the configured runway. */
enum mr_status mr_runway_decode(struct mr_predictor_state *state, uint32_t *sequence,
                                const uint8_t image[MR_RUNWAY_IMAGE_BYTES]);
uint32_t mr_runway_crc(const struct mr_predictor_state *state);
/* Number of messages that carry the joints of a state, and the n-th message, n from 0. */
unsigned mr_runway_message_count(const struct mr_predictor_state *state);
struct mr_runway_joints mr_runway_make_message(const struct mr_predictor_state *state, unsigned n);
/* Copies the joints of a message into the state; joints beyond the last are ignored. */
void mr_runway_apply_message(struct mr_predictor_state *state,
                             const struct mr_runway_joints *message);

/* Arguments of the commands that set a state: runway-joints (index 0..255) and runway-word.
 * mr_runway_make_word_argument returns false if there is no such word. */
int32_t mr_runway_make_joints_argument(const struct mr_predictor_state *state, unsigned index);
void mr_runway_apply_joints(struct mr_predictor_state *state, unsigned index, int32_t argument);
#define MR_RUNWAY_WORD_COUNT 3u
int32_t mr_runway_make_word_argument(const struct mr_predictor_state *state, unsigned index);
bool mr_runway_apply_word(struct mr_predictor_state *state, unsigned index, int32_t argument);

/* Parameters in the order of the message predict_item; a station for each transducer follows
 * them. */
/* clang-format off */
#define MR_PREDICT_ITEM_TABLE(X)                           \
    X(chain.mats, "mats", "mats")                          \
    X(chain.mat_length_ft, "mat length", "ft")             \
    X(chain.mass_slug, "mass of a mat", "slug")            \
    X(chain.friction_lb, "friction of a mat", "lb")        \
    X(chain.kl_lb_ft, "joint stiffness", "lb/ft")          \
    X(chain.cl_lb_s_ft, "joint damping", "lb s/ft")        \
    X(chain.slack_ft, "slack of a joint", "ft")            \
    X(chain.step_s, "step", "s")                           \
    X(grit_lb, "closing resistance", "lb")                 \
    X(thrust_lb_per_g, "thrust at 1 g", "lb")              \
    X(deceleration_ft_s2, "deceleration assumed", "ft/s2") \
    X(bump_ft, "irregularity assumed", "ft")               \
    X(mat_weight_lb, "weight of a mat", "lb")              \
    X(updates_per_block, "budget of a block", "mats")      \
    X(level, "best level", "")
/* clang-format on */

enum {
    MR_PREDICT_TABLE_ITEM_COUNT = 0
#define MR_PREDICT_COUNT(field, text, unit) +1
    MR_PREDICT_ITEM_TABLE(MR_PREDICT_COUNT),
    MR_PREDICT_ITEM_COUNT = MR_PREDICT_TABLE_ITEM_COUNT + (int)MR_TRANSDUCERS
};
#undef MR_PREDICT_COUNT

/* Returns the value of an item: first those of MR_PREDICT_ITEM_TABLE, then the stations; NaN for
 * other numbers. */
float mr_predict_get_item(const struct mr_predictor_config *config, unsigned item);
/* Sets an item; ignores items that do not exist. An invalid count becomes 0, which
 * mr_predictor_start refuses. */
void mr_predict_set_item(struct mr_predictor_config *config, unsigned item, float value);

#endif
