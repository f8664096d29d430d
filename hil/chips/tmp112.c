#include "hil/chips/tmp112.h"

#include <math.h>

#include "hil/core/core.h"
#include "hil/periph/options.h"

#define CELSIUS_PER_CODE      0.0625
#define CONFIG_OS             0x80u /* bits of the first byte of the configuration */
#define CONFIG_RESOLUTION     0x60u /* read-only; both bits are set: 12 bits */
#define CONFIG_SD             0x01u
#define CONFIG_AL             0x20u /* bits of the second byte; AL is read-only */
#define CONFIG_EM             0x10u
#define TYPICAL_CONVERSION_PS (26u * HIL_PS_PER_MS)
#define MAX_CONVERSION_PS     (35u * HIL_PS_PER_MS)

static uint64_t draw_conversion_ps(struct hil_tmp112_device *dev)
{
    switch (dev->options->cell_times) {
    case HIL_TIMES_TYPICAL: return TYPICAL_CONVERSION_PS;
    case HIL_TIMES_MAXIMUM: return MAX_CONVERSION_PS;
    default:
        return TYPICAL_CONVERSION_PS + mr_splitmix64(&dev->state->random_state) %
                                           (MAX_CONVERSION_PS - TYPICAL_CONVERSION_PS);
    }
}

void hil_tmp112_power_on(struct hil_tmp112_device *dev)
{
    struct hil_tmp112 *chip = dev->state;
    *chip = (struct hil_tmp112){.config = {CONFIG_RESOLUTION, 0x80},
                                .conversion_begin_ps = hil_now_ps(dev->core),
                                .random_state = dev->options->noise_seed,
                                .limit = {{0x4b, 0x00}, {0x50, 0x00}},
                                .is_dead = chip->is_dead,
                                .bus_faults.is_sda_stuck = chip->bus_faults.is_sda_stuck};
    chip->conversion_ps = draw_conversion_ps(dev);
}

/* Returns the result of the conversion that ended at `t_ps`, in 0.0625 C. */
static int32_t convert_temperature(const struct hil_tmp112_device *dev, uint64_t t_ps)
{
    const struct hil_options *options = dev->options;
    double count =
        (options->temperature_c + options->temperature_c_per_h * (double)t_ps * 1e-12 / 3600.0) /
        CELSIUS_PER_CODE;
    double most = dev->state->config[1] & CONFIG_EM ? 4095.0 : 2047.0;
    return (int32_t)lround(fmax(-most - 1.0, fmin(most, count)));
}

static void advance_conversion(struct hil_tmp112_device *dev)
{
    static const uint64_t period_ms[4] = {4000, 1000, 250, 125};
    struct hil_tmp112 *chip = dev->state;
    uint64_t now_ps = hil_now_ps(dev->core);
    if (chip->is_one_shot_running) {
        if (now_ps < chip->conversion_begin_ps + chip->conversion_ps)
            return;
        chip->is_one_shot_running = false;
        chip->is_one_shot_done = true;
        chip->result_code = convert_temperature(dev,
                                                chip->conversion_begin_ps + chip->conversion_ps);
    } else if (!(chip->config[0] & CONFIG_SD) &&
               now_ps >= chip->conversion_begin_ps + chip->conversion_ps) {
        uint64_t period_ps = period_ms[chip->config[1] >> 6] * HIL_PS_PER_MS;
        uint64_t n = (now_ps - chip->conversion_begin_ps - chip->conversion_ps) / period_ps;
        chip->result_code = convert_temperature(dev, chip->conversion_begin_ps +
                                                         chip->conversion_ps + n * period_ps);
    }
}

static void write_config_byte(struct hil_tmp112_device *dev, unsigned i, uint8_t byte)
{
    struct hil_tmp112 *chip = dev->state;
    if (i == 1) {
        chip->config[1] = byte & 0xd0;
        return;
    }
    bool was_shut_down = chip->config[0] & CONFIG_SD;
    chip->config[0] = (uint8_t)((byte & 0x1fu) | CONFIG_RESOLUTION);
    bool single = was_shut_down && (byte & CONFIG_OS) && (byte & CONFIG_SD);
    if (single || (was_shut_down && !(byte & CONFIG_SD))) {
        chip->conversion_begin_ps = hil_now_ps(dev->core);
        chip->conversion_ps = draw_conversion_ps(dev);
        chip->is_one_shot_running = single;
        chip->is_one_shot_done = false;
    }
}

static bool receive_address(void *device, uint8_t byte)
{
    struct hil_tmp112_device *dev = device;
    struct hil_tmp112 *chip = dev->state;
    chip->is_addressed = !chip->is_dead && !isnan(dev->options->temperature_c) &&
                         byte >> 1 == HIL_TMP112_ADDRESS;
    chip->byte_count = 0;
    return chip->is_addressed;
}

static bool receive_byte(void *device, uint8_t byte)
{
    struct hil_tmp112_device *dev = device;
    struct hil_tmp112 *chip = dev->state;
    if (!chip->is_addressed || chip->is_dead)
        return false;
    advance_conversion(dev);
    unsigned n = chip->byte_count++;
    if (n == 0)
        chip->register_pointer = byte & 3u;
    else if (chip->register_pointer == 1)
        write_config_byte(dev, (n - 1) % 2, byte);
    else if (chip->register_pointer > 1)
        chip->limit[chip->register_pointer - 2][(n - 1) % 2] = byte;
    return true;
}

static uint8_t send_next_byte(void *device)
{
    struct hil_tmp112_device *dev = device;
    struct hil_tmp112 *chip = dev->state;
    if (!chip->is_addressed || chip->is_dead)
        return 0xff;
    advance_conversion(dev);
    unsigned i = chip->byte_count++ % 2;
    bool wide = chip->config[1] & CONFIG_EM;
    uint16_t value = (uint16_t)((uint32_t)chip->result_code << (wide ? 3 : 4) | wide);
    if (chip->register_pointer == 0)
        return (uint8_t)(i ? value : value >> 8);
    if (chip->register_pointer == 1)
        return (uint8_t)(i ? chip->config[1] | CONFIG_AL
                           : chip->config[0] | (chip->is_one_shot_done ? CONFIG_OS : 0u));
    return chip->limit[chip->register_pointer - 2][i];
}

static void end_transfer(void *device)
{
    struct hil_tmp112_device *dev = device;
    dev->state->is_addressed = false;
}

static bool is_driving_bus(const void *device)
{
    const struct hil_tmp112_device *dev = device;
    return dev->state->is_addressed && !dev->state->is_dead;
}

struct hil_i2c_slave hil_tmp112_slave(struct hil_tmp112_device *dev)
{
    return (struct hil_i2c_slave){
        .context = dev,
        .address = receive_address,
        .write = receive_byte,
        .read = send_next_byte,
        .stop = end_transfer,
        .is_driving = is_driving_bus,
        .bus_faults = &dev->state->bus_faults,
    };
}
