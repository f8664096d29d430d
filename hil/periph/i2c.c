#include "hil/periph/i2c.h"

#include "hil/core/core.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"

#define CR1                    0x00u
#define DR                     0x10u
#define SR1                    0x14u
#define SR2                    0x18u
#define CCR                    0x1cu
#define TRISE                  0x20u
#define CR1_PE                 (1u << 0)
#define CR1_START              (1u << 8)
#define CR1_STOP               (1u << 9)
#define CR1_ACK                (1u << 10)
#define CR1_POS                (1u << 11)
#define CR1_SWRST              (1u << 15)
#define CR1_CLEARED_BY_PE      (CR1_START | CR1_STOP | CR1_ACK | CR1_POS)
#define CR2_FREQ               0x3fu
#define SR1_SB                 (1u << 0)
#define SR1_ADDR               (1u << 1)
#define SR1_BTF                (1u << 2)
#define SR1_RXNE               (1u << 6)
#define SR1_TXE                (1u << 7)
#define SR1_BERR               (1u << 8)
#define SR1_ARLO               (1u << 9)
#define SR1_AF                 (1u << 10)
#define SR1_ERRORS             0xdf00u /* the error flags, which are cleared by writing 0 */
#define CCR_FS                 (1u << 15)
#define CCR_DUTY               (1u << 14)
#define TRISE_RESET            2u
#define PORT_B                 1u
#define SCL_PIN                6u
#define SDA_PIN                7u
#define SCL_PERIODS_PER_BYTE   9u
#define RESTART_ERRATUM_MIN_HZ 88e3 /* ES0182 */
#define RESTART_ERRATUM_MAX_HZ 100e3

static bool is_requested(const struct hil_i2c *i2c, uint32_t bit)
{
    return (i2c->cr1 & bit) != 0;
}

static uint64_t get_scl_period_cycles(const struct hil_i2c_device *dev)
{
    const struct hil_i2c *i2c = dev->state;
    uint32_t clocks = !(i2c->ccr & CCR_FS) ? 2u : i2c->ccr & CCR_DUTY ? 25u : 3u; /* 27.6.8 */
    return (uint64_t)clocks * (i2c->ccr & 0xfffu) * hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB1);
}

static bool are_pins_connected(const struct hil_i2c_device *dev)
{
    return hil_gpio_alternate_function(dev->gpio, PORT_B, SCL_PIN) == 4 &&
           hil_gpio_alternate_function(dev->gpio, PORT_B, SDA_PIN) == 4;
}

static bool is_holding_sda(const struct hil_i2c_device *dev)
{
    return dev->slave.bus_faults->is_sda_stuck || dev->slave.bus_faults->clocks_until_release;
}

static void set_phase(struct hil_i2c_device *dev, enum hil_i2c_phase phase, uint64_t at,
                      unsigned periods)
{
    struct hil_i2c *i2c = dev->state;
    i2c->phase = phase;
    i2c->phase_begin_cycle = at;
    i2c->phase_end_cycle = periods ? at + periods * get_scl_period_cycles(dev) : HIL_NEVER;
    /* the slave may hold the clock low at the end of a byte */
    if (periods == SCL_PERIODS_PER_BYTE) {
        double stretch_s = (double)dev->slave.bus_faults->stretch_ps * 1e-12;
        i2c->phase_end_cycle += (uint64_t)(stretch_s * (double)dev->core->state.clock.hclk_hz);
        dev->slave.bus_faults->stretch_ps = 0;
        i2c->sr1 |= dev->slave.bus_faults->has_false_error ? SR1_BERR : 0;
        dev->slave.bus_faults->has_false_error = false;
    }
}

static void leave_bus(struct hil_i2c_device *dev)
{
    struct hil_i2c *i2c = dev->state;
    i2c->is_master = i2c->is_transmitter = i2c->is_dr_full = false;
    i2c->sr1 &= SR1_ERRORS | SR1_RXNE;
    i2c->phase = HIL_I2C_IDLE;
    i2c->phase_end_cycle = HIL_NEVER;
}

/* Detects lost arbitration: if SDA is held low, the first 1 that the master sends reads back as 0,
 * as if another master were sending (27.3.4). */
static bool check_arbitration_loss(struct hil_i2c_device *dev, uint8_t byte)
{
    if (byte == 0 || !is_holding_sda(dev))
        return false;
    leave_bus(dev);
    dev->state->sr1 |= SR1_ARLO;
    return true;
}

static double get_scl_hz(const struct hil_i2c_device *dev)
{
    return (double)dev->core->state.clock.hclk_hz / (double)get_scl_period_cycles(dev);
}

static void check_start_timing(struct hil_i2c_device *dev, bool repeated)
{
    double hz = get_scl_hz(dev);
    bool standard = !(dev->state->ccr & CCR_FS);
    hil_rules_check_time(dev->rules, HIL_RULE_SCL_PERIOD, 1e9 / hz, 0.0, 0);
    if (repeated && standard && hz >= RESTART_ERRATUM_MIN_HZ && hz <= RESTART_ERRATUM_MAX_HZ)
        hil_rules_record_violation(dev->rules, HIL_RULE_REPEATED_START, 0, "SCL of %.1f kHz",
                                   hz * 1e-3);
    else if (repeated)
        hil_rules_record_pass(dev->rules, HIL_RULE_REPEATED_START);
}

/* Generates the requested stop or repeated start after a byte. */
static bool try_stop_or_restart(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    if (!is_requested(i2c, CR1_STOP | CR1_START))
        return false;
    if (!is_requested(i2c, CR1_STOP))
        check_start_timing(dev, true);
    set_phase(dev, is_requested(i2c, CR1_STOP) ? HIL_I2C_STOPPING : HIL_I2C_STARTING, at, 1);
    return true;
}

/* Generates the requested stop or start at once in states that end only by such a request. */
static void handle_bus_request(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    if (!is_requested(i2c, CR1_PE))
        return;
    switch (i2c->phase) {
    case HIL_I2C_IDLE:
        i2c->cr1 &= ~CR1_STOP; /* there is no transfer that could be stopped */
        if (is_requested(i2c, CR1_START) && !i2c->is_busy && are_pins_connected(dev)) {
            check_start_timing(dev, false);
            set_phase(dev, HIL_I2C_STARTING, at, 1);
        }
        break;
    case HIL_I2C_STARTED:
        if (is_requested(i2c, CR1_STOP)) {
            i2c->sr1 &= ~SR1_SB;
            (void)try_stop_or_restart(dev, at);
        }
        break;
    case HIL_I2C_SENT:
    case HIL_I2C_RECEIVER_FULL:
    case HIL_I2C_NOT_ACKNOWLEDGED: (void)try_stop_or_restart(dev, at); break;
    default: break;
    }
}

static void begin_byte(struct hil_i2c_device *dev, enum hil_i2c_phase phase, uint64_t at)
{
    set_phase(dev, phase, at, SCL_PERIODS_PER_BYTE);
}

static void send_next_byte(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    i2c->shifted_byte = (uint8_t)i2c->dr;
    i2c->is_dr_full = false;
    i2c->sr1 |= SR1_TXE;
    begin_byte(dev, HIL_I2C_SENDING, at);
}

static void end_start(struct hil_i2c_device *dev)
{
    struct hil_i2c *i2c = dev->state;
    i2c->cr1 &= ~CR1_START;
    i2c->is_master = i2c->is_busy = true;
    i2c->is_transmitter = false;
    i2c->sr1 = (i2c->sr1 & ~(SR1_BTF | SR1_TXE)) | SR1_SB;
    set_phase(dev, HIL_I2C_STARTED, 0, 0);
}

static void end_address(struct hil_i2c_device *dev)
{
    struct hil_i2c *i2c = dev->state;
    if (check_arbitration_loss(dev, i2c->shifted_byte))
        return;
    bool acknowledged = dev->slave.address(dev->slave.context, i2c->shifted_byte);
    i2c->is_transmitter = !(i2c->shifted_byte & 1u);
    i2c->sr1 |= acknowledged ? SR1_ADDR : SR1_AF;
    set_phase(dev, acknowledged ? HIL_I2C_ADDRESSED : HIL_I2C_NOT_ACKNOWLEDGED, 0, 0);
}

static void end_sent_byte(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    if (check_arbitration_loss(dev, i2c->shifted_byte))
        return;
    if (!dev->slave.write(dev->slave.context, i2c->shifted_byte)) {
        i2c->sr1 |= SR1_AF;
        set_phase(dev, HIL_I2C_NOT_ACKNOWLEDGED, 0, 0);
    } else if (!try_stop_or_restart(dev, at)) {
        if (i2c->is_dr_full) {
            send_next_byte(dev, at);
        } else {
            i2c->sr1 |= SR1_BTF;
            set_phase(dev, HIL_I2C_SENT, 0, 0);
        }
    }
}

static void end_received_byte(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    uint8_t byte = is_holding_sda(dev) ? 0 : dev->slave.read(dev->slave.context);
    bool acknowledges = is_requested(i2c, CR1_POS) ? i2c->acknowledges_next_byte
                                                   : is_requested(i2c, CR1_ACK);
    i2c->acknowledges_next_byte = is_requested(i2c, CR1_ACK);
    if (!acknowledges)
        /* the slave releases SDA; further bytes read as ones */
        dev->slave.stop(dev->slave.context);
    if (i2c->sr1 & SR1_RXNE) {
        i2c->shifted_byte = byte;
        i2c->sr1 |= SR1_BTF;
        if (!try_stop_or_restart(dev, at))
            set_phase(dev, HIL_I2C_RECEIVER_FULL, 0, 0);
        return;
    }
    i2c->dr = byte;
    i2c->sr1 |= SR1_RXNE;
    if (!try_stop_or_restart(dev, at))
        begin_byte(dev, HIL_I2C_RECEIVING, at);
}

static void end_stop(struct hil_i2c_device *dev, uint64_t at)
{
    struct hil_i2c *i2c = dev->state;
    if (is_holding_sda(dev)) { /* SDA does not rise, so STOP and BUSY stay set */
        i2c->phase_end_cycle = HIL_NEVER;
        return;
    }
    uint32_t full = i2c->sr1 & (SR1_BTF | SR1_RXNE);
    dev->slave.stop(dev->slave.context);
    leave_bus(dev);
    i2c->sr1 |= full == (SR1_BTF | SR1_RXNE) ? full : 0; /* both received bytes remain readable */
    i2c->is_busy = false;
    i2c->cr1 &= ~CR1_STOP;
    handle_bus_request(dev, at);
}

void hil_i2c_event(void *device, uint64_t at)
{
    struct hil_i2c_device *dev = device;
    switch (dev->state->phase) {
    case HIL_I2C_STARTING: end_start(dev); break;
    case HIL_I2C_ADDRESSING: end_address(dev); break;
    case HIL_I2C_SENDING: end_sent_byte(dev, at); break;
    case HIL_I2C_RECEIVING: end_received_byte(dev, at); break;
    case HIL_I2C_STOPPING: end_stop(dev, at); break;
    default: dev->state->phase_end_cycle = HIL_NEVER; break;
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_I2C, dev->state->phase_end_cycle);
}

void hil_i2c_on_lines_changed(void *device, uint64_t at)
{
    struct hil_i2c_device *dev = device;
    struct hil_i2c *i2c = dev->state;
    bool scl = hil_gpio_level(dev->gpio, PORT_B, SCL_PIN);
    if (i2c->scl_level && !scl && dev->slave.bus_faults->clocks_until_release)
        dev->slave
            .bus_faults
            /* the clock completes one more bit of the byte in which the slave hangs */
            ->clocks_until_release--;
    hil_gpio_drive(dev->gpio, PORT_B, SDA_PIN, !is_holding_sda(dev), at);
    bool sda = hil_gpio_level(dev->gpio, PORT_B, SDA_PIN);
    bool condition = sda != i2c->sda_level && scl &&
                     i2c->scl_level; /* a start is a fall of SDA while SCL is high, a stop a rise */
    bool in_byte = i2c->phase == HIL_I2C_ADDRESSING || i2c->phase == HIL_I2C_SENDING ||
                   i2c->phase == HIL_I2C_RECEIVING;
    if (condition && sda && !in_byte)
        dev->slave.stop(dev->slave.context);
    if (are_pins_connected(dev)) {
        /* SCL is high only in the second half of each period */
        if (condition && in_byte &&
            (at - i2c->phase_begin_cycle) % get_scl_period_cycles(dev) >=
                get_scl_period_cycles(dev) / 2)
            i2c->sr1 |= SR1_BERR;
        if (!scl || !sda)
            i2c->is_busy = true;
        else if (condition)
            i2c->is_busy = i2c->is_master;
    }
    i2c->scl_level = scl;
    i2c->sda_level = sda;
    handle_bus_request(dev, at);
    hil_event_set_cycle(dev->core, HIL_EVENT_I2C, dev->state->phase_end_cycle);
}

/* Ends a transfer in the middle of a byte that is being read: the slave still drives its bit. */
static void abandon_transfer(struct hil_i2c_device *dev)
{
    struct hil_i2c *i2c = dev->state;
    if (i2c->phase == HIL_I2C_RECEIVING && dev->slave.is_driving(dev->slave.context)) {
        uint64_t bit = (hil_now_cycle(dev->core) - i2c->phase_begin_cycle) /
                       get_scl_period_cycles(dev);
        uint8_t byte = dev->slave.read(dev->slave.context);
        if (bit < 8 && !(byte >> (7u - bit) & 1u))
            dev->slave.bus_faults->clocks_until_release = 9u - (unsigned)bit;
    }
    dev->slave.stop(dev->slave.context);
}

void hil_i2c_reset(void *device, unsigned unit)
{
    struct hil_i2c_device *dev = device;
    struct hil_i2c *i2c = dev->state;
    bool scl = i2c->scl_level, sda = i2c->sda_level;
    (void)unit;
    abandon_transfer(dev);
    *i2c = (struct hil_i2c){
        .trise = TRISE_RESET, .phase_end_cycle = HIL_NEVER, .scl_level = scl, .sda_level = sda};
    hil_i2c_on_lines_changed(dev, hil_now_cycle(dev->core));
}

uint32_t hil_i2c_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_i2c_device *dev = device;
    struct hil_i2c *i2c = dev->state;
    uint64_t now = hil_now_cycle(dev->core);
    uint32_t value;
    (void)unit;
    switch (offset) {
    case DR:
        value = i2c->dr;
        if (i2c->sr1 & SR1_BTF && i2c->sr1 & SR1_RXNE) { /* the second byte moves to DR */
            i2c->dr = i2c->shifted_byte;
            i2c->sr1 &= ~SR1_BTF;
            if (i2c->phase == HIL_I2C_RECEIVER_FULL)
                begin_byte(dev, HIL_I2C_RECEIVING, now);
        } else {
            i2c->sr1 &= ~SR1_RXNE;
        }
        hil_event_set_cycle(dev->core, HIL_EVENT_I2C, dev->state->phase_end_cycle);
        return value;
    case SR1: i2c->is_sr1_read = true; return i2c->sr1;
    case SR2:
        value = (i2c->is_master ? 1u : 0u) | (i2c->is_busy ? 2u : 0u) |
                (i2c->is_transmitter ? 4u : 0u);
        if (i2c->phase == HIL_I2C_ADDRESSED && i2c->is_sr1_read) {
            i2c->sr1 &= ~SR1_ADDR;
            i2c->is_sr1_read = false;
            if (i2c->is_transmitter) {
                i2c->sr1 |= SR1_TXE;
                set_phase(dev, HIL_I2C_SENT, 0, 0);
                handle_bus_request(dev, now);
            } else {
                i2c->acknowledges_next_byte =
                    true; /* with POS, ACK applies to the byte after this one */
                begin_byte(dev, HIL_I2C_RECEIVING, now);
            }
            hil_event_set_cycle(dev->core, HIL_EVENT_I2C, dev->state->phase_end_cycle);
        }
        return value;
    default: return i2c->word[offset / 4u];
    }
}

static const char *check_settings(const struct hil_i2c_device *dev)
{
    const struct hil_i2c *i2c = dev->state;
    uint32_t pclk1_mhz = dev->core->state.clock.hclk_hz /
                         hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB1) / 1000000u;
    uint32_t least = i2c->ccr & CCR_FS && i2c->ccr & CCR_DUTY ? 1u : 4u;
    uint32_t rise_ns = i2c->ccr & CCR_FS ? 300u : 1000u;
    if ((i2c->cr2 & CR2_FREQ) != pclk1_mhz)
        return "PE is set, but CR2.FREQ is not PCLK1 in MHz";
    /* required value of TRISE (RM0090 27.6.9) */
    if (i2c->trise != rise_ns * pclk1_mhz / 1000u + 1u)
        return "PE is set, but TRISE does not give the maximum rise time of SCL";
    return (i2c->ccr & 0xfffu) < least ? "PE is set, but CCR is below its minimum" : NULL;
}

static void write_cr1(struct hil_i2c_device *dev, uint32_t value)
{
    struct hil_i2c *i2c = dev->state;
    if (value & CR1_SWRST) {
        hil_i2c_reset(dev, 0);
        i2c->cr1 = CR1_SWRST;
        return;
    }
    if (is_requested(i2c, CR1_START | CR1_STOP) && value != i2c->cr1)
        hil_bus_refuse(dev->core,
                       "CR1 is written while START or STOP waits for the hardware to clear it");
    if (!(value & CR1_PE) && i2c->is_master)
        hil_bus_refuse(dev->core, "PE is cleared before the end of the communication");
    const char *wrong = value & CR1_PE ? check_settings(dev) : NULL;
    if (wrong)
        hil_bus_refuse(dev->core, wrong);
    i2c->cr1 = value;
    if (!(value & CR1_PE)) {
        leave_bus(dev);
        i2c->sr1 = 0;
        i2c->cr1 &= ~CR1_CLEARED_BY_PE;
    }
    handle_bus_request(dev, hil_now_cycle(dev->core));
}

static void write_dr(struct hil_i2c_device *dev, uint32_t value)
{
    struct hil_i2c *i2c = dev->state;
    uint64_t now = hil_now_cycle(dev->core);
    i2c->dr = (uint8_t)value;
    if (i2c->phase == HIL_I2C_STARTED && i2c->is_sr1_read) {
        if ((value & 0xf8u) == 0xf0u)
            hil_bus_refuse(dev->core, "10-bit addresses");
        i2c->sr1 &= ~SR1_SB;
        i2c->shifted_byte = (uint8_t)value;
        begin_byte(dev, HIL_I2C_ADDRESSING, now);
    } else if (i2c->phase == HIL_I2C_SENT) {
        i2c->sr1 &= ~SR1_BTF;
        send_next_byte(dev, now);
    } else if (i2c->phase == HIL_I2C_SENDING) {
        i2c->is_dr_full = true;
        i2c->sr1 &= ~SR1_TXE;
    }
    i2c->is_sr1_read = false;
}

void hil_i2c_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_i2c_device *dev = device;
    struct hil_i2c *i2c = dev->state;
    (void)unit;
    if (is_requested(i2c, CR1_SWRST) && offset != CR1)
        return; /* the peripheral is held in reset */
    switch (offset) {
    case CR1: write_cr1(dev, value); break;
    case DR: write_dr(dev, value); break;
    case SR1: /* error flags are cleared by writing 0 */ i2c->sr1 &= value | ~SR1_ERRORS; break;
    default:
        if ((offset == CCR || offset == TRISE) && is_requested(i2c, CR1_PE))
            hil_bus_refuse(dev->core, "CCR and TRISE can be written only while PE is 0");
        i2c->word[offset / 4u] = value;
        break;
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_I2C, dev->state->phase_end_cycle);
}
