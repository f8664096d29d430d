#include "tests/firmware/fake_i2c.h"

#include <stdlib.h>
#include <string.h>

struct fake_i2c fake_i2c;

void fake_i2c_reset(void)
{
    memset(&fake_i2c, 0, sizeof fake_i2c);
    fake_i2c.temperature = 0x1400;
    fake_i2c.config = 0x60;
    fake_i2c.address = 0x48;
}

void i2c_start(void)
{
    fake_i2c.on = true;
    fake_i2c.starts++;
}

void i2c_stop(void)
{
    fake_i2c.on = false;
    fake_i2c.stops++;
}

static void write_bytes(const uint8_t *out, size_t length)
{
    fake_i2c.pointer = out[0] & 3u;
    if (length < 2 || fake_i2c.pointer != 1)
        return;
    if ((out[1] & 0x80u) && (fake_i2c.config & 1u)) { /* one-shot, from shut-down only */
        fake_i2c.conversions++;
        fake_i2c.converted = fake_i2c.temperature;
        fake_i2c.config = (uint8_t)((out[1] & 0x1fu) | 0x60u | (fake_i2c.never_ready ? 0u : 0x80u));
        fake_i2c.never_ready -= fake_i2c.never_ready != 0;
    } else {
        fake_i2c.config = (uint8_t)((out[1] & 0x1fu) | 0x60u);
    }
}

void i2c_begin(uint8_t address, const uint8_t *out, size_t out_length, uint8_t *in,
               size_t in_length)
{
    if (!fake_i2c.on || fake_i2c.left)
        abort(); /* one at a time */
    fake_i2c.transfers++;
    fake_i2c.left = 8;
    if (fake_i2c.fault == FAKE_I2C_STUCK) {
        fake_i2c.left = 45;
        fake_i2c.result = I2C_STUCK;
    } else if (fake_i2c.fault == FAKE_I2C_DEAD || address != fake_i2c.address) {
        fake_i2c.result = I2C_NO_ANSWER;
    } else {
        fake_i2c.result = I2C_IDLE;
        write_bytes(out, out_length);
        if (in_length == 2) {
            uint16_t value = fake_i2c.pointer ? (uint16_t)((unsigned)fake_i2c.config << 8 | 0xa0u)
                                              : fake_i2c.converted;
            in[0] = (uint8_t)(value >> 8);
            in[1] = (uint8_t)value;
        }
    }
}

enum i2c_status i2c_poll(void)
{
    if (fake_i2c.left)
        fake_i2c.left--;
    return fake_i2c.left ? I2C_BUSY : fake_i2c.result;
}
