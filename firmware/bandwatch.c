#include "firmware/bandwatch.h"

#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/schedule.h"

#define S_PER_BLOCK 0.001f

void bandwatch_arm(struct bandwatch *watch)
{
    mr_bands_arm(&watch->bands, &config.channel[MR_TRANSDUCERS], config.band);
    watch->is_wheel_known = false;
}

static void report_findings(const struct mr_bands *bands, struct telemetry *telemetry)
{
    for (unsigned i = 0; i < bands->finding_count; i++) {
        const struct mr_band_finding *finding = &bands->finding[i];
        TELEMETRY_SEND(telemetry, TO_RECORD, band_event, BAND_EVENT, .band = finding->band,
                       .gage = finding->gage, .reason = finding->reason,
                       .other = finding->other_gage, .value_lb = finding->value_lb,
                       .at_block16 = (uint16_t)finding->block);
    }
}

static float get_wheel_ft(struct bandwatch *watch, const struct landing *landing,
                          const struct mr_block *block)
{
    if (!watch->is_wheel_known || block->index - watch->wheel_block >= BANDWATCH_WHEEL_BLOCKS) {
        watch->wheel = landing_wheel_at(landing, block->tick);
        watch->wheel_block = block->index;
        watch->is_wheel_known = true;
    }
    float since_s = (float)(block->index - watch->wheel_block) * S_PER_BLOCK;
    return __builtin_isnan(watch->wheel.speed_ft_s)
             ? watch->wheel.station_ft
             : watch->wheel.station_ft + watch->wheel.speed_ft_s * since_s;
}

static void report_state(struct telemetry *telemetry, const float tension_lb[MR_GAGES])
{
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++) {
        struct mr_band_state state = {.band = (uint8_t)(b + 1)};
        if (!(config.band[b].pretension_lb > 0.0f))
            continue;
        state.gages = (uint8_t)mr_bands_find_extremes(&config.channel[MR_TRANSDUCERS], tension_lb,
                                                      b, &state.least_lb, &state.mean_lb,
                                                      &state.most_lb);
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, band_state, BAND_STATE, &state);
    }
}

void bandwatch_on_tensions(struct bandwatch *watch, struct telemetry *telemetry,
                           const struct landing *landing, const float tension_lb[MR_GAGES],
                           const struct mr_block *block)
{
    bool recording = landing_is_recording(landing);
    if (recording ? DUE(BANDS, block->index) : DUE(BANDS_IDLE, block->index))
        report_state(telemetry, tension_lb);
    if (!recording || !watch->bands.is_active)
        return;
    bool quiet = landing_is_quiet(landing, block->index);
    float station_ft = quiet ? MR_NAN : get_wheel_ft(watch, landing, block);
    if (mr_bands_update(&watch->bands, tension_lb, quiet, station_ft, block->index))
        report_findings(&watch->bands, telemetry);
}

void bandwatch_end(struct bandwatch *watch, struct telemetry *telemetry)
{
    struct mr_band_summary f;
    if (!watch->bands.is_active)
        return;
    mr_bands_end(&watch->bands);
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++) {
        uint8_t band = (uint8_t)(b + 1);
        if (!watch->bands.band[b].gage_count)
            continue;
        mr_bands_get_summary(&watch->bands, b, &f);
        TELEMETRY_SEND(telemetry, TO_RECORD, band_before, BAND_BEFORE, .band = band,
                       .gages = (uint8_t)f.gage_count, .before_lb = f.before_lb,
                       .error_lb = f.before_error_lb, .spread_lb = f.spread_lb);
        TELEMETRY_SEND(telemetry, TO_RECORD, band_least, BAND_LEAST, .band = band,
                       .gage = f.min.gage, .tension_lb = f.min.tension_lb,
                       .error_lb = f.min_error_lb, .at_block16 = (uint16_t)f.min.block);
        TELEMETRY_SEND(telemetry, TO_RECORD, band_most, BAND_MOST, .band = band, .gage = f.max.gage,
                       .tension_lb = f.max.tension_lb, .error_lb = f.max_error_lb,
                       .at_block16 = (uint16_t)f.max.block);
        TELEMETRY_SEND(telemetry, TO_RECORD, band_after, BAND_AFTER, .band = band,
                       .gages = (uint8_t)f.gage_count, .after_lb = f.after_lb,
                       .change_lb = f.change_lb, .error_lb = f.change_error_lb);
    }
}
