#include "host/export/export_mdf4.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/measured_source.h"
#include "host/analyse/summary.h"
#include "host/export/dbc.h"
#include "host/export/mdf4.h"
#include "host/base/units.h"

/* time, since touchdown, gear, speed: of 8 bytes each; then readings of 4 */
#define COLUMNS_BEFORE 4u
#define FRAME_ROW      24u

struct place {
    const struct summary *summary;
    struct mdf4 *file;
    uint16_t base;   /* of the board on CAN */
    int64_t zero_us; /* board time of second 0 */
    long rows;
    long without_time;
};

static void put_real(uint8_t *at, double value)
{
    memcpy(at, &value, sizeof value); /* x86 and ARM: IEEE 754, least byte first */
}

static void put_single(uint8_t *at, float value)
{
    memcpy(at, &value, sizeof value);
}

/* ---- readings ---- */

static const struct unit *unit_of_channel(const struct measured_channel *channel, bool si)
{
    return unit_of(channel->config.kind == MR_KIND_DISPLACEMENT ? UNIT_DISPLACEMENT : UNIT_TENSION,
                   si);
}

static void describe_reading(struct place *place, const struct measured_channel *channel,
                             unsigned column, bool si)
{
    const struct measured *measured = &place->summary->measured;
    bool moves = channel->config.kind == MR_KIND_DISPLACEMENT;
    double factor = unit_of_channel(channel, si)->factor;
    double one = measured_error(measured, channel, channel->peak, 1.0);
    char name[32], comment[200];
    snprintf(name, sizeof name, "%s_%u", moves ? "displacement" : "tension",
             channel->config.number);
    int n =
        snprintf(comment, sizeof comment,
                 moves ? "station %.*f %s, downfield positive, since its mean before the first edge"
                       : "band tension",
                 3, (double)channel->config.station_ft * unit_of(UNIT_STATION, si)->factor,
                 unit_of(UNIT_STATION, si)->text);
    if (!isnan(one))
        snprintf(comment + n, sizeof comment - (size_t)n,
                 "; standard error of one reading at the peak %.4g %s", one * factor,
                 unit_of_channel(channel, si)->text);
    mdf4_channel(place->file,
                 &(struct mdf4_channel){.name = name,
                                        .unit = unit_of_channel(channel, si)->text,
                                        .comment = comment,
                                        .type = MDF4_REAL,
                                        .offset = 8 * COLUMNS_BEFORE + 4 * column,
                                        .bytes = 4,
                                        .invalid_bit = (int)(COLUMNS_BEFORE + column)});
}

static void describe_readings(struct place *place, const struct measured_channel **channels,
                              unsigned count, bool si)
{
    const struct measured *measured = &place->summary->measured;
    const char *since = measured->t0_is_touchdown ? "since_touchdown"
                      : measured->gates           ? "since_first_edge"
                                                  : "since_arming";
    const struct mdf4_channel before[COLUMNS_BEFORE] = {
        {.name = "time",
         .unit = "s",
         .comment = "middle of the 1 ms block",
         .type = MDF4_REAL,
         .is_time = true,
         .invalid_bit = -1},
        {.name = since, .unit = "s", .type = MDF4_REAL, .invalid_bit = -1},
        {.name = "gear_station",
         .unit = unit_of(UNIT_STATION, si)->text,
         .comment = "lead wheel of the main bogie, by the fit",
         .type = MDF4_REAL,
         .invalid_bit = 2},
        {.name = "gear_speed",
         .unit = unit_of(UNIT_SPEED, si)->text,
         .type = MDF4_REAL,
         .invalid_bit = 3}};
    char source[MEASURED_SOURCE_TEXT], doubt[DOUBTS_TEXT],
        comment[MEASURED_SOURCE_TEXT + DOUBTS_TEXT + 100];
    measured_source_text(measured, source);
    doubts_headline(&measured->doubts, doubt);
    snprintf(comment, sizeof comment,
             "readings of the landing, a row a millisecond, from %s; what is not valid is marked "
             "invalid%s%s",
             source, doubt[0] ? "; " : "", doubt);
    mdf4_table(place->file, "readings", comment, 8 * COLUMNS_BEFORE + 4 * count,
               (COLUMNS_BEFORE + count + 7) / 8, 0);
    for (unsigned i = 0; i < COLUMNS_BEFORE; i++) {
        struct mdf4_channel column = before[i];
        column.offset = 8 * i;
        column.bytes = 8;
        mdf4_channel(place->file, &column);
    }
    for (unsigned c = 0; c < count; c++)
        describe_reading(place, channels[c], c, si);
}

static void mark_invalid(uint8_t *row, unsigned row_bytes, unsigned bit)
{
    row[row_bytes + bit / 8] |= (uint8_t)(1u << bit % 8);
}

static void put_reading_row(struct place *place, const struct measured_channel **channels,
                            unsigned count, size_t sample, bool si)
{
    const struct measured *measured = &place->summary->measured;
    uint8_t row[8 * COLUMNS_BEFORE + 4 * MR_CHANNELS + 8] = {0};
    unsigned row_bytes = 8 * COLUMNS_BEFORE + 4 * count;
    double t_s = measured_time_s(measured, sample), unused;
    double values[COLUMNS_BEFORE] = {
        t_s + (double)(measured->t0_us - place->zero_us) / 1e6, t_s,
        measured_station_ft(measured, t_s) * unit_of(UNIT_STATION, si)->factor,
        measured_speed_ft_s(measured, t_s, &unused) * unit_of(UNIT_SPEED, si)->factor};
    for (unsigned i = 0; i < COLUMNS_BEFORE; i++) {
        if (isnan(values[i]))
            mark_invalid(row, row_bytes, i);
        put_real(row + 8 * i, isnan(values[i]) ? 0.0 : values[i]);
    }
    for (unsigned c = 0; c < count; c++) {
        double value = measured_value(channels[c], sample) *
                       unit_of_channel(channels[c], si)->factor;
        if (isnan(value))
            mark_invalid(row, row_bytes, COLUMNS_BEFORE + c);
        put_single(row + 8 * COLUMNS_BEFORE + 4 * c, isnan(value) ? 0.0f : (float)value);
    }
    mdf4_row(place->file, row);
    place->rows++;
}

static void put_readings(struct place *place, bool si)
{
    const struct measured *measured = &place->summary->measured;
    const struct measured_channel *channels[MR_CHANNELS];
    unsigned count = (unsigned)measured_in_order(measured, channels);
    if (measured->source == MEASURED_NOTHING || measured->samples == 0)
        return;
    describe_readings(place, channels, count, si);
    for (size_t i = 0; i < measured->samples; i++)
        put_reading_row(place, channels, count, i, si);
    mdf4_table_end(place->file);
}

/* ---- frames ---- */

/* The catalogue as a DBC file, in memory; the caller frees. */
static char *dbc_text(uint16_t base, size_t *length)
{
    char *text = NULL;
    FILE *stream = open_memstream(&text, length);
    if (!stream)
        return NULL;
    dbc_write(stream, base);
    if (fclose(stream) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static enum mr_status put_frame(void *context, const struct store_frame *frame)
{
    struct place *place = context;
    uint8_t row[FRAME_ROW] = {0};
    if (frame->board_us == STORE_NONE || frame->length > 8) {
        place->without_time++;
        return MR_OK;
    }
    put_real(row, (double)(frame->board_us - place->zero_us) / 1e6);
    row[8] = 1; /* the bus */
    uint32_t id = link_id_to_bus(frame->id, place->base);
    for (unsigned i = 0; i < 4; i++)
        row[9 + i] = (uint8_t)(id >> 8 * i);
    row[14] = row[15] = (uint8_t)frame->length;
    memcpy(row + 16, frame->data, frame->length);
    mdf4_row(place->file, row);
    place->rows++;
    return MR_OK;
}

static void describe_frames(struct mdf4 *file, uint64_t dbc)
{
    static const struct {
        const char *name;
        unsigned offset, bytes;
        enum mdf4_type type;
    } parts[] = {{"CAN_DataFrame.BusChannel", 8, 1, MDF4_UNSIGNED},
                 {"CAN_DataFrame.ID", 9, 4, MDF4_UNSIGNED},
                 {"CAN_DataFrame.IDE", 13, 1, MDF4_UNSIGNED},
                 {"CAN_DataFrame.DLC", 14, 1, MDF4_UNSIGNED},
                 {"CAN_DataFrame.DataLength", 15, 1, MDF4_UNSIGNED},
                 {"CAN_DataFrame.DataBytes", 16, 8, MDF4_BYTES}};
    mdf4_table(file, "CAN_DataFrame", "frames of the board's CAN bus as received", FRAME_ROW, 0, 1);
    mdf4_channel(file, &(struct mdf4_channel){.name = "Timestamp",
                                              .unit = "s",
                                              .type = MDF4_REAL,
                                              .bytes = 8,
                                              .is_time = true,
                                              .invalid_bit = -1});
    mdf4_channel(file, &(struct mdf4_channel){.name = "CAN_DataFrame",
                                              .type = MDF4_BYTES,
                                              .offset = 8,
                                              .bytes = FRAME_ROW - 8,
                                              .invalid_bit = -1,
                                              .has_parts = true,
                                              .attachment = dbc});
    for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; i++)
        mdf4_channel(file, &(struct mdf4_channel){.name = parts[i].name,
                                                  .type = parts[i].type,
                                                  .offset = parts[i].offset,
                                                  .bytes = parts[i].bytes,
                                                  .invalid_bit = -1});
    mdf4_parts_end(file);
}

static enum mr_status put_frames(struct place *place, struct store *store, int64_t run,
                                 struct error *error)
{
    size_t length = 0;
    char *dbc = dbc_text(place->base, &length);
    if (!dbc)
        return error_set(error, MR_FULL,
                         "out of memory: the DBC file that goes with the CAN frames");
    describe_frames(place->file,
                    mdf4_attach(place->file, "matrig.dbc", "application/x-dbc", dbc, length));
    free(dbc);
    enum mr_status status = store_frames_each(store, run, LINK_CAN, put_frame, place, error);
    mdf4_table_end(place->file);
    return status;
}

/* ---- file ---- */

static enum mr_status find_first(void *context, const struct store_frame *frame)
{
    int64_t *first_us = context;
    if (frame->board_us != STORE_NONE && (*first_us == STORE_NONE || frame->board_us < *first_us))
        *first_us = frame->board_us;
    return MR_OK;
}

/* Board time of the first thing there is; STORE_NONE: nothing. */
static enum mr_status find_zero(struct store *store, int64_t run, const struct measured *measured,
                                int64_t *zero_us, struct error *error)
{
    *zero_us = STORE_NONE;
    enum mr_status status = store_frames_each(store, run, LINK_CAN, find_first, zero_us, error);
    if (measured->source == MEASURED_NOTHING || measured->samples == 0)
        return status;
    int64_t first_us = measured->t0_us + (int64_t)floor(1e6 * measured_time_s(measured, 0));
    if (*zero_us == STORE_NONE || first_us < *zero_us)
        *zero_us = first_us;
    return status;
}

/* Unix time of second 0 as well as it is known. */
static uint64_t start_ns(const struct summary *summary, int64_t zero_us)
{
    const struct store_time_map *clock = &summary->clock;
    const struct store_landing *landing = &summary->measured.landing;
    int64_t us = landing->armed_us;
    if (summary->clock_known && clock->host_us != STORE_NONE)
        us = clock->host_us + zero_us - clock->board_us;
    return us > 0 ? (uint64_t)us * 1000u : 0;
}

static void begin_file(struct mdf4 *file, const struct summary *summary, int64_t zero_us)
{
    const struct store_landing *landing = &summary->measured.landing;
    char comment[256], version[32];
    snprintf(version, sizeof version, "database version %d", STORE_VERSION);
    snprintf(comment, sizeof comment,
             "matrig landing: RUN %lld, landing %lld of board %s; second 0 is board time %.6f s",
             (long long)landing->id, (long long)landing->board_landing, landing->board_uid,
             (double)zero_us / 1e6);
    mdf4_start(file, start_ns(summary, zero_us), comment, version);
}

enum mr_status export_mdf4(struct store *store, int64_t run, FILE *out, bool si, long *rows,
                           struct error *error)
{
    struct summary summary = {0};
    struct mdf4 file = {0};
    int64_t frames = 0;
    struct place place = {.summary = &summary, .file = &file};
    enum mr_status status = summary_load(store, run, &summary, error);
    if (status == MR_OK)
        status = store_frames_count(store, run, LINK_CAN, &frames, error);
    if (status == MR_OK)
        status = store_frames_base(store, run, &place.base, error);
    if (status == MR_OK)
        status = find_zero(store, run, &summary.measured, &place.zero_us, error);
    if (status == MR_OK && place.zero_us == STORE_NONE)
        status = error_set(
            error, MR_USAGE,
            "nothing to export: RUN %lld of %s has neither readings nor CAN frames with a time",
            (long long)run, store_path(store));
    if (status == MR_OK) {
        begin_file(&file, &summary, place.zero_us);
        put_readings(&place, si);
        if (frames)
            status = put_frames(&place, store, run, error);
        enum mr_status written = mdf4_write(&file, out, error);
        status = status != MR_OK ? status : written;
        *rows = place.rows;
    }
    summary_free(&summary);
    return status;
}
