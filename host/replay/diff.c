#include "host/replay/diff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "common/fault.h"
#include "common/catalogue.h"
#include "host/base/units.h"

#define NUMBER_DIGITS 15 /* number of digits of numbers in reports: all that a double has */

/* A message without a block gets the newest block that its link had delivered. That block may be
 * wrong by this much, because frames can change order on the bus. */
#define RECEPTION_BLOCK_TOLERANCE 4
/* Messages that are sent in rotation, when the bus has room, are rarely delayed longer than
 * this. */
#define BUS_DELAY_MAX_BLOCKS      2000

static const char *const link_names[LINK_KINDS] = {"CAN", "serial"};

/* ---- how each field of the catalogue is compared ---- */

enum field_rule {
    FIELD_VALUE,   /* values must be equal, or within the tolerance of the unit */
    FIELD_BLOCK,   /* a block index, compared after the shift */
    FIELD_BLOCK16, /* the low 16 bits of a block index, compared after the shift */
    FIELD_TICK,    /* a tick of TIM2, compared after the shift */
    /* number of frames queued since reset, including dropped ones; compared as the increase since
     * the first frame of the landing */
    FIELD_QUEUED,
    /* a bit mask of faults, of which only those are compared that follow from the record */
    FIELD_FAULTS,
    FIELD_IMAGE,        /* identifies the image; compared only if the same image ran */
    FIELD_NOT_COMPARED, /* not determined by the record, so not compared */
};

/* faults that follow from blocks and edges */
#define REPRODUCIBLE_FAULTS        (1u << MR_FAULT_REFERENCE | 1u << MR_FAULT_NO_FIT)
#define FIELD_TOLERANCES_TEXT_SIZE 200

/* Rules for fields of the catalogue. A field without a rule has the rule of its name (times have
 * common names), otherwise FIELD_VALUE. */
static const struct {
    uint16_t id; /* message to which the rule applies; 0: every message */
    const char *field;
    enum field_rule rule;
} rules[] = {
#define REPLAY_RULE(name, NAME, field, rule) {MR_ID_##NAME, #field, FIELD_##rule},
#include "common/catalogue.def"
    {0, "block16", FIELD_BLOCK16},
    {0, "at_block16", FIELD_BLOCK16},
    {0, "block", FIELD_BLOCK},
    {0, "tick", FIELD_TICK},
};

/* A rule. Does not compile if it names a field that does not exist. */
#define REPLAY_RULE(name, NAME, field, rule) \
    _Static_assert(offsetof(struct mr_##name, field) < sizeof(struct mr_##name), #field);
#include "common/catalogue.def"

/* Tolerances for an image whose computations differ slightly: ten times the resolution of the
 * message, or more if the error of the estimate is larger. Counts, states, names of switches and
 * ticks must be equal for every image. */
static const struct {
    const char *unit;
    double tolerance;
} tolerances[] = {
    {"in", 0.002}, {"lb", 0.2},    {"ft", 0.05}, {"ft/s", 0.02}, {"ft/s2", 0.1},
    {"s", 0.05},   {"codes", 1.0}, {"ms", 5.0},  {"%", 5.0},
};

/* True if no field of the message is determined by the record. */
static bool is_excluded_message(uint16_t id)
{
#define NOT_COMPARED(name, NAME) || id == MR_ID_##NAME
    return false
#include "common/catalogue.def"
        ;
}

/* True if the message is sent in rotation, when the bus has room. */
static bool is_sent_in_rotation(uint16_t id)
{
#define SENT_IN_ROTATION(name, NAME) || id == MR_ID_##NAME
    return false
#include "common/catalogue.def"
        ;
}

static enum field_rule find_field_rule(const struct mr_message_info *info,
                                       const struct mr_field_info *field)
{
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if ((rules[i].id == 0 || rules[i].id == info->id) &&
            strcmp(rules[i].field, field->name) == 0)
            return rules[i].rule;
    }
    return FIELD_VALUE;
}

/* Returns the tolerance of a unit for another image; 0: values must be equal. */
static double get_field_tolerance(const char *unit)
{
    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++) {
        if (strcmp(tolerances[i].unit, unit) == 0)
            return tolerances[i].tolerance;
    }
    return 0.0;
}

/* Writes one line with all tolerances; `si`: lengths, speeds and forces in SI units. */
static void write_field_tolerances(bool si, char out[FIELD_TOLERANCES_TEXT_SIZE])
{
    size_t used = 0;
    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++) {
        double value = tolerances[i].tolerance;
        const char *unit = tolerances[i].unit;
        for (int kind = 0; si && kind < UNIT_MEASURED_KIND_COUNT; kind++) {
            const struct unit *shown = unit_get((enum unit_kind)kind, true);
            if (strcmp(unit_get_json((enum unit_kind)kind)->text, tolerances[i].unit) != 0)
                continue;
            value *= shown->factor;
            unit = shown->text;
        }
        used += (size_t)snprintf(out + used, FIELD_TOLERANCES_TEXT_SIZE - used, "%.2g %s, ", value,
                                 unit);
    }
    snprintf(out + used - 2, FIELD_TOLERANCES_TEXT_SIZE + 2 - used,
             "; counts, states, switches and ticks must be identical");
}

/* ---- two lists of messages ---- */

struct comparison {
    const struct board_messages *recorded, *replayed;
    const struct diff_options *options;
    struct diff *diff;
    struct diff_row *row;
    /* range of the record; messages outside this range have no counterpart */
    int64_t first_block, end_block;
    /* counts of queued frames at the first message; NaN: no message yet */
    double queued_frames_recorded, queued_frames_replayed;
    bool are_links_faultless;
    int64_t bus_delay_blocks; /* as bus_delay_blocks in struct diff */
    /* the record ends before its landing does; one of the links may have continued for longer */
    bool is_landing_incomplete;
};

static void add_difference(struct comparison *c, struct difference difference)
{
    struct diff_row *row = c->row;
    if (row->differing_fields + row->only_recorded_count + row->only_replayed_count == 0)
        row->first_difference = difference;
    if (!c->diff->has_difference || difference.block < c->diff->first_difference.block) {
        c->diff->first_difference = difference;
        c->diff->has_difference = true;
    }
}

static void add_value_difference(struct comparison *c, const char *field, int64_t block,
                                 double recorded, double replayed)
{
    add_difference(c, (struct difference){DIFF_VALUE, c->row->link, c->row->message, field, block,
                                          recorded, replayed});
    c->row->differing_fields++;
}

static double get_field_value(const struct board_message *answer, const char *name)
{
    for (unsigned i = 0; i < answer->info->field_count; i++) {
        if (strcmp(answer->info->fields[i].name, name) == 0)
            return mr_field_value(&answer->info->fields[i], answer->data);
    }
    return (double)NAN;
}

static bool is_within_tolerance(double a, double b, double tolerance)
{
    if (isnan(a) || isnan(b))
        return isnan(a) && isnan(b);
    return fabs(a - b) <= tolerance;
}

/* True for messages that do not follow from the record: rows of the slow log, which are sent at the
 * end of each minute, and nonces, which need a key that a replay does not have. */
static bool is_independent_of_record(uint16_t id)
{
    return id == MR_ID_SLOW_ROW || id == MR_ID_SLOW_TENSION || id == MR_ID_NONCE;
}

/* Returns the number of frames queued so far, including dropped ones, which the firmware made
 * too. */
static double count_queued_frames(const struct board_messages *answers, int link,
                                  const struct board_message *answer)
{
    double others = 0.0;
    for (const struct board_message *before = answers->message[link]; before < answer; before++)
        others += is_independent_of_record(before->info->id);
    return get_field_value(answer, "sent") + get_field_value(answer, "dropped") - others;
}

/* Converts the two values of a field to a common base. Returns false if the field is not
 * compared. */
static bool get_comparable_values(struct comparison *c, const struct mr_field_info *field,
                                  const struct board_message *a, const struct board_message *b,
                                  double *recorded, double *replayed, double *tolerance)
{
    int64_t shift = c->options->shift_blocks;
    *recorded = mr_field_value(field, a->data);
    *replayed = mr_field_value(field, b->data);
    *tolerance = c->options->is_exact ? 0.0 : get_field_tolerance(field->unit);
    switch (find_field_rule(a->info, field)) {
    case FIELD_BLOCK: *replayed += (double)shift; return true;
    case FIELD_BLOCK16: *replayed = (uint16_t)((int64_t)*replayed + shift); return true;
    case FIELD_TICK:
        *replayed = (uint32_t)((uint32_t)*replayed + (uint32_t)shift * MR_TICKS_PER_BLOCK);
        *tolerance = 0.0;
        return true;
    case FIELD_QUEUED:
        if (isnan(c->queued_frames_recorded)) {
            c->queued_frames_recorded = count_queued_frames(c->recorded, c->row->link, a);
            c->queued_frames_replayed = count_queued_frames(c->replayed, c->row->link, b);
        }
        *recorded = count_queued_frames(c->recorded, c->row->link, a) - c->queued_frames_recorded;
        *replayed = count_queued_frames(c->replayed, c->row->link, b) - c->queued_frames_replayed;
        return c->options->is_exact && c->are_links_faultless && c->bus_delay_blocks == 0;
    case FIELD_FAULTS:
        *recorded = (uint32_t)*recorded & REPRODUCIBLE_FAULTS;
        *replayed = (uint32_t)*replayed & REPRODUCIBLE_FAULTS;
        return true;
    case FIELD_IMAGE:
        return c->options->is_exact &&
               c->recorded->landing.image_crc == c->replayed->landing.image_crc;
    case FIELD_NOT_COMPARED: return false;
    case FIELD_VALUE: break;
    }
    return true;
}

static void compare_pair(struct comparison *c, const struct board_message *a,
                         const struct board_message *b)
{
    c->row->pair_count++;
    for (unsigned i = 0; i < a->info->field_count; i++) {
        const struct mr_field_info *field = &a->info->fields[i];
        double recorded, replayed, tolerance;
        if (!get_comparable_values(c, field, a, b, &recorded, &replayed, &tolerance))
            continue;
        c->row->compared_fields++;
        if (!is_within_tolerance(recorded, replayed, tolerance))
            add_value_difference(c, field->name, a->block, recorded, replayed);
    }
}

/* Returns false for messages that the record does not determine: faults of links, clocks and
 * converters, and answers to commands before arming, which may still have been on their way. */
static bool is_determined_by_record(const struct board_message *answer, int64_t first_block)
{
    if (answer->info->id == MR_ID_ACK &&
        (get_field_value(answer, "code") == (double)MR_COMMAND_BACKLOG ||
         get_field_value(answer, "code") == (double)MR_COMMAND_INVALID ||
         mr_status_is_sender_refused((int)get_field_value(answer, "status"))))
        return false; /* the replay sends this command itself, or uses it in place of another */
    if (answer->info->id == MR_ID_ACK || answer->info->id == MR_ID_MARK)
        return get_field_value(answer, "block") >= (double)first_block;
    if (answer->info->id != MR_ID_FAULT)
        return true;
    double code = get_field_value(answer, "code");
    return code < MR_FAULT_COUNT && (REPRODUCIBLE_FAULTS >> (unsigned)code & 1u);
}

/* Returns the number of earlier blocks that a message averages. */
static int64_t count_averaged_blocks(uint16_t id)
{
    unsigned pack = mr_series_pack_find(id);
    return pack < MR_SERIES_PACK_COUNT
             ? mr_series_at(mr_series_pack_at(pack)->series)->averaged_blocks - 1
             : 0;
}

static bool has_block_field(const struct mr_message_info *info)
{
    return info->id == MR_ID_BLOCK ||
           strcmp(info->fields[info->field_count - 1].name, "block16") == 0;
}

/* An iterator over the messages of one kind in one list. */
struct message_iterator {
    const struct board_message *current, *end;
    int64_t shift;
    int64_t first_block; /* block in which the board was armed, counted as in this list */
};

static void begin_iterators(const struct comparison *c, int link, struct message_iterator *old,
                            struct message_iterator *new)
{
    const int64_t shift = c->options->shift_blocks, armed = c->recorded->landing.armed_block;
    const struct board_message *from = c->recorded->message[link],
                               *again = c->replayed->message[link];
    *old = (struct message_iterator){from, from + c->recorded->message_count[link], 0, armed};
    *new = (struct message_iterator){again, again + c->replayed->message_count[link], shift,
                                     armed - shift};
}

static const struct board_message *advance_message(struct message_iterator *walk,
                                                   const struct mr_message_info *info)
{
    for (; walk->current < walk->end; walk->current++) {
        if (walk->current->info == info &&
            is_determined_by_record(walk->current, walk->first_block))
            return walk->current;
    }
    return NULL;
}

static void add_unmatched_message(struct comparison *c, const struct board_message *answer,
                                  int64_t block, bool recorded)
{
    /* Skip: the record may end between two messages of its last block. */
    if ((has_block_field(answer->info) && block < c->first_block) ||
        (!recorded && block >= c->end_block))
        return;
    if (!recorded && c->is_landing_incomplete && block == c->end_block)
        /* not a difference: the record may have ended before messages about the last block were
         * sent */
        return;
    if (!c->options->is_exact && (double)(c->end_block - block) <= get_field_tolerance("ms"))
        return; /* not a difference: the time of the end itself may differ by this much */
    if (is_sent_in_rotation(answer->info->id) && c->bus_delay_blocks > c->end_block - block)
        /* not a difference: the counterpart would have been sent after the end of the record */
        return;
    if (!recorded && c->options->has_losses[c->row->link]) {
        c->diff->unrecorded_messages++;
        return;
    }
    add_difference(c, (struct difference){recorded ? DIFF_ONLY_RECORDED : DIFF_ONLY_REPLAYED,
                                          c->row->link, answer->info->name, "", block, (double)NAN,
                                          (double)NAN});
    if (recorded)
        c->row->only_recorded_count++;
    else
        c->row->only_replayed_count++;
}

/* True if two messages of one kind have the same subject: the number of a channel, switch, edge or
 * command, and the item if there is one. */
static bool has_same_subject(const struct board_message *a, const struct board_message *b)
{
    static const char *const subjects[] = {"index", "position", "segment", "count",
                                           "tag",   "code",     "band",    "gage"};
    const char *first = a->info->fields[0].name;
    for (size_t i = 0; i < sizeof subjects / sizeof subjects[0]; i++) {
        if (strcmp(first, subjects[i]) == 0)
            return get_field_value(a, first) == get_field_value(b, first) &&
                   (strcmp(a->info->fields[1].name, "item") != 0 ||
                    get_field_value(a, "item") == get_field_value(b, "item"));
    }
    return true;
}

static void compare_messages(struct comparison *c, int link, const struct mr_message_info *info)
{
    struct message_iterator old, new;
    begin_iterators(c, link, &old, &new);
    int64_t slack = has_block_field(info) && c->options->is_exact ? 0
                  : is_sent_in_rotation(info->id) && c->bus_delay_blocks
                      ? c->bus_delay_blocks
                      : RECEPTION_BLOCK_TOLERANCE;
    c->queued_frames_recorded = c->queued_frames_replayed = (double)NAN;
    for (;;) {
        const struct board_message *a = advance_message(&old, info),
                                   *b = advance_message(&new, info);
        if (!a && !b)
            return;
        int64_t at = a ? a->block : INT64_MAX / 2,
                replayed_at = b ? b->block + new.shift : INT64_MAX / 2;
        if (c->is_landing_incomplete && a && at > c->end_block) {
            c->diff->messages_after_record++;
            old.current++;
            continue;
        }
        bool paired = a && b && at - replayed_at <= slack && replayed_at - at <= slack;
        if (paired && c->options->has_losses[link] && !has_same_subject(a, b)) {
            add_unmatched_message(c, b, replayed_at, false);
            new.current++;
        } else if (paired) {
            /* a message on CAN may have arrived before the serial record of its block */
            if (has_block_field(info) && at > c->end_block)
                c->diff->messages_after_record++;
            else if (count_averaged_blocks(info->id) &&
                     at < c->first_block + count_averaged_blocks(info->id))
                c->diff->messages_before_record++;
            else
                compare_pair(c, a, b);
            old.current++;
            new.current++;
        } else if (at < replayed_at) {
            add_unmatched_message(c, a, at, true);
            old.current++;
        } else {
            add_unmatched_message(c, b, replayed_at, false);
            new.current++;
        }
    }
}

/* Returns the largest difference in blocks between a message that is sent in rotation and its
 * counterpart, as long as the order is the same. */
static int64_t compute_largest_delay(const struct comparison *c, int link,
                                     const struct mr_message_info *info)
{
    int64_t most = 0;
    struct message_iterator old, new;
    const struct board_message *a, *b;
    begin_iterators(c, link, &old, &new);
    while ((a = advance_message(&old, info)) != NULL && (b = advance_message(&new, info)) != NULL &&
           has_same_subject(a, b)) {
        int64_t apart = llabs((long long)(a->block - (b->block + new.shift)));
        if (apart > BUS_DELAY_MAX_BLOCKS)
            break;
        most = apart > most ? apart : most;
        old.current++;
        new.current++;
    }
    return most;
}

/* Returns the delay caused by a full bus. It is large if other boards or instruments filled the bus
 * in one of the two landings. */
static int64_t compute_bus_delay(const struct comparison *c)
{
    size_t count;
    int64_t most = 0;
    const struct mr_message_info *info = mr_catalogue_messages(&count);
    for (size_t i = 0; i < count; i++) {
        for (int link = 0; link < LINK_KINDS && is_sent_in_rotation(info[i].id); link++) {
            int64_t late = c->options->has_losses[link] ? 0
                                                        : compute_largest_delay(c, link, &info[i]);
            most = late > most ? late : most;
        }
    }
    return most > RECEPTION_BLOCK_TOLERANCE ? most + RECEPTION_BLOCK_TOLERANCE : 0;
}

/* ---- block records: the input must be recorded again unchanged ---- */

static void compare_block_value(struct comparison *c, const char *field, int64_t block, double a,
                                double b)
{
    c->row->compared_fields++;
    if (a != b)
        add_value_difference(c, field, block, a, b);
}

static void compare_block(struct comparison *c, const struct mr_block *a, const struct mr_block *b)
{
    c->row->pair_count++;
    compare_block_value(c, "tick", a->index, a->tick,
                        b->tick + (uint32_t)c->options->shift_blocks * MR_TICKS_PER_BLOCK);
    compare_block_value(c, "absent", a->index, a->absent_channels, b->absent_channels);
#define COMPARE_BLOCK_FIELD(name, field)                              \
    for (size_t i = 0; i < sizeof a->field / sizeof a->field[0]; i++) \
        compare_block_value(c, name, a->index, a->field[i], b->field[i]);
    COMPARE_BLOCK_FIELD("plus", forward_sum)
    COMPARE_BLOCK_FIELD("minus", reversed_sum)
    COMPARE_BLOCK_FIELD("sum", sum)
    COMPARE_BLOCK_FIELD("low", low_count)
    COMPARE_BLOCK_FIELD("high", high_count)
#undef COMPARE_BLOCK_FIELD
}

static void compare_blocks(struct comparison *c)
{
    static const struct mr_message_info record = {.name = "block", .id = MR_ID_BLOCK};
    static const struct board_message any = {.info = &record};
    size_t i = 0, k = 0;
    while (i < c->recorded->block_count || k < c->replayed->block_count) {
        int64_t at = i < c->recorded->block_count ? (int64_t)c->recorded->block[i].index
                                                  : INT64_MAX;
        int64_t replayed_at = k < c->replayed->block_count
                                ? (int64_t)c->replayed->block[k].index + c->options->shift_blocks
                                : INT64_MAX;
        if (at == replayed_at)
            compare_block(c, &c->recorded->block[i++], &c->replayed->block[k++]);
        else if (at < replayed_at)
            add_unmatched_message(c, &any, c->recorded->block[i++].index, true);
        else
            add_unmatched_message(c, &any, c->replayed->block[k++].index + c->options->shift_blocks,
                                  false);
    }
}

/* ---- summary ---- */

static int64_t count_unreproducible_faults(const struct board_messages *answers, int link)
{
    int64_t count = 0;
    for (size_t i = 0; i < answers->message_count[link]; i++)
        count += answers->message[link][i].info->id == MR_ID_FAULT &&
                 !is_determined_by_record(&answers->message[link][i], 0);
    return count;
}

static void begin_row(struct comparison *c, const char *message, int link)
{
    c->row = &c->diff->row[c->diff->row_count];
    *c->row = (struct diff_row){.message = message, .link = link};
}

static void end_row(struct comparison *c)
{
    const struct diff_row *row = c->row;
    c->diff->compared_messages += row->pair_count;
    c->diff->compared_fields += row->compared_fields;
    c->diff->differing_fields += row->differing_fields + row->only_recorded_count +
                                 row->only_replayed_count;
    if ((row->pair_count || row->only_recorded_count || row->only_replayed_count) &&
        c->diff->row_count + 1 < DIFF_MESSAGES_MAX)
        c->diff->row_count++;
}

static int64_t count_messages(const struct board_messages *answers, int link,
                              const struct mr_message_info *info)
{
    int64_t count = 0;
    for (size_t i = 0; i < answers->message_count[link]; i++)
        count += answers->message[link][i].info == info;
    return count;
}

void diff_messages(const struct board_messages *recorded, const struct board_messages *replayed,
                   const struct diff_options *options, struct diff *diff)
{
    struct comparison c = {
        .recorded = recorded, .replayed = replayed, .options = options, .diff = diff};
    size_t count;
    const struct mr_message_info *info = mr_catalogue_messages(&count);
    *diff = (struct diff){.is_exact = options->is_exact};
    c.first_block = recorded->block[0].index;
    c.end_block = recorded->block[recorded->block_count - 1].index;
    c.is_landing_incomplete = recorded->landing.state != MR_LANDING_DONE;
    c.are_links_faultless = true;
    for (int link = 0; link < LINK_KINDS; link++)
        c.are_links_faultless &= count_unreproducible_faults(recorded, link) == 0 &&
                                 count_unreproducible_faults(replayed, link) == 0;
    c.bus_delay_blocks = compute_bus_delay(&c);
    diff->bus_delay_blocks = c.bus_delay_blocks;
    begin_row(&c, "block", LINK_SERIAL);
    compare_blocks(&c);
    end_row(&c);
    for (int link = LINK_KINDS - 1; link >= 0; link--) {
        for (size_t i = 0; recorded->message_count[link] && i < count; i++) {
            if (is_excluded_message(info[i].id) || is_independent_of_record(info[i].id)) {
                diff->excluded_messages += count_messages(recorded, link, &info[i]);
                continue;
            }
            if (info[i].id == MR_ID_FAULT)
                diff->excluded_messages += count_unreproducible_faults(recorded, link);
            begin_row(&c, info[i].name, link);
            compare_messages(&c, link, &info[i]);
            end_row(&c);
        }
    }
}

/* Writes a difference, for example "serial 2.345 s: motion.speed_ft_s recorded 35.5, replayed
 * 35.6". */
static void write_difference(const struct difference *d, char *out, size_t size)
{
    int length = snprintf(out, size, "%s %.3f s (block %lld): %s%s%s ", link_names[d->link],
                          (double)d->block / 1e3, (long long)d->block, d->message,
                          d->field[0] ? "." : "", d->field);
    if (length < 0 || (size_t)length >= size)
        return;
    out += length;
    size -= (size_t)length;
    if (d->kind == DIFF_VALUE)
        snprintf(out, size, "recorded %.10g, replayed %.10g", d->recorded, d->replayed);
    else
        snprintf(out, size, "%s",
                 d->kind == DIFF_ONLY_RECORDED ? "recorded, not replayed"
                                               : "replayed, not recorded");
}

static void add_difference_to_answer(const struct difference *d, struct answer *answer)
{
    static const char *const kinds[] = {"value", "only_recorded", "only_replayed"};
    if (!d) {
        answer_add_missing_value(answer, "first", NULL, NULL);
        return;
    }
    answer_open_group(answer, "first", NULL);
    answer_add_text(answer, "kind", NULL, "%s", kinds[d->kind]);
    answer_add_text(answer, "link", NULL, "%s", link_names[d->link]);
    answer_add_text(answer, "message", NULL, "%s", d->message);
    answer_add_text(answer, "field", NULL, "%s", d->field);
    answer_add_value(answer, "t", NULL, UNIT_TIME, (double)d->block / 1e3, 3)->digits =
        NUMBER_DIGITS;
    answer_add_count(answer, "block", NULL, d->block);
    answer_add_value(answer, "recorded", NULL, UNIT_NUMBER, d->recorded, 3)->digits = NUMBER_DIGITS;
    answer_add_value(answer, "replayed", NULL, UNIT_NUMBER, d->replayed, 3)->digits = NUMBER_DIGITS;
    answer_close_group(answer);
}

/* Adds a row to the answer if it has differences. */
static void add_row_to_answer(const struct diff_row *row, struct answer *answer)
{
    bool differs = row->differing_fields + row->only_recorded_count + row->only_replayed_count > 0;
    char text[300];
    answer_open_row(answer);
    answer_add_text(answer, "message", differs ? "message" : NULL, "%s", row->message);
    answer_add_text(answer, "link", differs ? "link" : NULL, "%s", link_names[row->link]);
    answer_add_count(answer, "compared", differs ? "compared" : NULL, row->pair_count);
    answer_add_count(answer, "fields", NULL, row->compared_fields);
    answer_add_count(answer, "differ", differs ? "fields|differ" : NULL, row->differing_fields);
    answer_add_count(answer, "only_recorded", differs ? "only|recorded" : NULL,
                     row->only_recorded_count);
    answer_add_count(answer, "only_replayed", differs ? "only|replayed" : NULL,
                     row->only_replayed_count);
    add_difference_to_answer(differs ? &row->first_difference : NULL, answer);
    if (differs) {
        write_difference(&row->first_difference, text, sizeof text);
        answer_add_text(answer, NULL, "first", "%s", text);
    }
}

static void add_uncompared_messages(struct answer *answer, const char *name, int64_t messages,
                                    const char *label, const char *end)
{
    answer_add_count(answer, name, messages ? label : NULL, messages)->suffix = end;
}

void diff_to_answer(const struct diff *diff, struct answer *answer)
{
    char text[300], within[FIELD_TOLERANCES_TEXT_SIZE];
    write_field_tolerances(answer_is_si(answer), within);
    answer_add_text(answer, "compared", "compared", "%s", diff->is_exact ? "exactly" : within);
    add_difference_to_answer(diff->has_difference ? &diff->first_difference : NULL, answer);
    if (diff->has_difference) {
        write_difference(&diff->first_difference, text, sizeof text);
        answer_add_text(answer, NULL, "first", "%s", text);
    }
    answer_open_table(answer, "by_message", "");
    for (size_t i = 0; i < diff->row_count; i++)
        add_row_to_answer(&diff->row[i], answer);
    answer_close_group(answer);
    add_uncompared_messages(answer, "after_record", diff->messages_after_record, "not compared",
                            " messages of blocks after the last record");
    add_uncompared_messages(answer, "before_record", diff->messages_before_record, "not compared",
                            " messages that depend on blocks before the record");
    add_uncompared_messages(
        answer, "circumstances", diff->excluded_messages, "not compared",
        " messages about links, clock and chip, which a replay cannot reproduce");
    add_uncompared_messages(
        answer, "not_recorded", diff->unrecorded_messages, "not recorded",
        " messages of the replay that the record lacks, because the log lost frames");
    answer_add_count(answer, "late_blocks", NULL, diff->bus_delay_blocks);
    if (diff->bus_delay_blocks)
        answer_add_sentence(
            answer, NULL,
            "messages sent in rotation (channels, joints and others) were up to %lld ms late, "
            "because the bus was full in the record or in the replay; their order is compared, but "
            "not their times and the frame counts",
            (long long)diff->bus_delay_blocks);
    answer_add_text(answer, NULL, "result", "%lld of %lld fields differ, in %lld messages",
                    (long long)diff->differing_fields, (long long)diff->compared_fields,
                    (long long)diff->compared_messages);
    answer_add_count(answer, "differ", NULL, diff->differing_fields);
    answer_add_count(answer, "fields", NULL, diff->compared_fields);
    answer_add_count(answer, "messages", NULL, diff->compared_messages);
}
