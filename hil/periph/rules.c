#include "hil/periph/rules.h"

#include <stdarg.h>
#include <string.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/whatif.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"

#define NS_PS           1000.0
/* Rise time of a line with only a pull-up resistor: I2C-bus specification UM10204, table 10,
 * standard mode. */
#define PULL_UP_RISE_NS 1000.0

enum { PORT_A, PORT_B, PORT_C, PORT_D, PORT_E, PORT_F, PORT_G, PORT_H, PORT_I };
enum kind { MINIMUM, FAULT };

static const struct rule {
    const char *name;
    enum kind kind;
    double min_ns;
    const char *requirement, *source;
} rule_table[] = {
#define PIN(NAME, port, pin, words)
#define RULE(NAME, kind, least_ns, what, source) {#NAME, kind, least_ns, what, source},
#include "hil/periph/rules.def"
};

static const struct {
    uint8_t port, pin;
} pin_table[] = {
#define PIN(NAME, port, pin, words) {PORT_##port, pin},
#define RULE(NAME, kind, least_ns, what, source)
#include "hil/periph/rules.def"
};

/* Indexed by OSPEEDR: longest rise or fall, highest frequency, at 2.7 V or more and 50, 50, 40, 30
 * pF (STM32F407 data sheet DS8626, I/O AC characteristics). */
static const struct {
    double slew_ns, max_mhz;
} speed_limits[4] = {{100.0, 4.0}, {10.0, 25.0}, {6.0, 50.0}, {4.0, 100.0}};

bool hil_rules_are_checked(const struct hil_rules_device *dev)
{
    return dev->options->rules_mode != HIL_RULES_OFF;
}

static unsigned get_pin_speed(const struct hil_rules_device *dev, unsigned port, unsigned pin)
{
    return dev->gpio->state->port[port].ospeedr >> (2u * pin) & 3u;
}

double hil_rules_min_period_ns(const struct hil_rules_device *dev, unsigned port, unsigned pin)
{
    return 1e3 / speed_limits[get_pin_speed(dev, port, pin)].max_mhz;
}

/* Prints the function and address of the instruction that broke a rule. */
static void format_code_location(const struct hil_rules_device *dev, uint32_t pc, char *text,
                                 size_t size)
{
    const char *name = pc && dev->get_function_name ? dev->get_function_name(dev->context, pc)
                                                    : NULL;
    if (!pc)
        snprintf(text, size, "the hardware");
    else
        snprintf(text, size, "%s%s0x%08x", name ? name : "", name ? ", PC " : "PC ", (unsigned)pc);
}

static bool is_only_counted(const struct hil_rules_device *dev, enum hil_rule rule)
{
    return dev->options->rules_mode == HIL_RULES_COUNT ||
           (dev->options->counted_rules >> rule & 1u);
}

static void stop_on_violation(struct hil_rules_device *dev, enum hil_rule rule)
{
    const struct hil_rule_tally *tally = &dev->state->tally[rule];
    char from[80], to[80], slew[48] = "";
    if (is_only_counted(dev, rule))
        return;
    format_code_location(dev, tally->from_pc, from, sizeof from);
    format_code_location(dev, tally->to_pc, to, sizeof to);
    if (tally->slew_ns > 0.0)
        snprintf(slew, sizeof slew, " (%.0f ns of slew subtracted)", tally->slew_ns);
    hil_core_stop(dev->core, MR_HALTED,
                  "rule %s: %s: measured %.1f ns%s, required %.1f ns; from %s to %s; %s",
                  rule_table[rule].name, rule_table[rule].requirement, tally->worst_ns, slew,
                  tally->limit_ns, from, to, rule_table[rule].source);
}

static void record_measurement(struct hil_rules_device *dev, enum hil_rule rule, double ns,
                               double least_ns, struct hil_timestamp from, uint32_t to_pc)
{
    struct hil_rule_tally *tally = &dev->state->tally[rule];
    bool broken = ns < least_ns;
    tally->violation_count += broken;
    if (!tally->measurement_count++ || ns - least_ns < tally->worst_ns - tally->limit_ns) {
        tally->worst_ns = ns;
        tally->limit_ns = least_ns;
        tally->slew_ns = from.slew_ns;
        tally->from_pc = from.pc;
        tally->to_pc = to_pc;
    }
    if (broken)
        stop_on_violation(dev, rule);
}

void hil_rules_check_time(struct hil_rules_device *dev, enum hil_rule rule, double ns,
                          double least_ns, uint32_t pc)
{
    if (hil_rules_are_checked(dev))
        record_measurement(dev, rule, ns, least_ns > 0.0 ? least_ns : rule_table[rule].min_ns,
                           (struct hil_timestamp){.pc = pc}, pc);
}

void hil_rules_check_interval(struct hil_rules_device *dev, enum hil_rule rule,
                              struct hil_timestamp from, struct hil_timestamp to)
{
    if (!hil_rules_are_checked(dev) || !from.ps || !to.ps)
        return;
    double ns = to.ps >= from.ps ? (double)(to.ps - from.ps) : -(double)(from.ps - to.ps);
    record_measurement(dev, rule, ns / NS_PS - from.slew_ns, rule_table[rule].min_ns, from, to.pc);
}

void hil_rules_record_pass(struct hil_rules_device *dev, enum hil_rule rule)
{
    dev->state->tally[rule].measurement_count += hil_rules_are_checked(dev);
}

void hil_rules_record_violation(struct hil_rules_device *dev, enum hil_rule rule, uint32_t pc,
                                const char *format, ...)
{
    struct hil_rule_tally *tally = &dev->state->tally[rule];
    char words[160], place[80];
    va_list arguments;
    if (!hil_rules_are_checked(dev))
        return;
    tally->measurement_count++;
    if (!tally->violation_count++)
        tally->from_pc = tally->to_pc = pc;
    if (is_only_counted(dev, rule))
        return;
    va_start(arguments, format);
    vsnprintf(words, sizeof words, format, arguments);
    va_end(arguments);
    format_code_location(dev, pc, place, sizeof place);
    hil_core_stop(dev->core, MR_HALTED, "rule %s: %s: %s; %s; %s", rule_table[rule].name,
                  rule_table[rule].requirement, words, place, rule_table[rule].source);
}

/* --- pins --- */

/* Follows the thermometer's bus while software drives it. While SCL is high, a rise of SDA is a
 * stop and a fall a start. */
static void track_thermometer_bus(struct hil_rules_device *dev, bool high, struct hil_timestamp at)
{
    struct hil_rules *state = dev->state;
    if (!state->pin[HIL_RULES_THERMOMETER_CLOCK].is_high)
        return;
    if (!high)
        hil_rules_check_interval(dev, HIL_RULE_BUS_FREE, state->last_bus_stop, at);
    state->last_bus_stop = high ? at : (struct hil_timestamp){0};
}

static void track_edge(struct hil_rules_device *dev, enum hil_rules_pin pin, bool high,
                       struct hil_timestamp at)
{
    struct hil_rules_edges *edges = &dev->state->pin[pin];
    edges->is_high = high;
    *(high ? &edges->last_rise : &edges->last_fall) = at;
    switch (pin) {
    case HIL_RULES_THERMOMETER_CLOCK:
        hil_rules_check_interval(dev, high ? HIL_RULE_SCL_LOW : HIL_RULE_SCL_HIGH,
                                 high ? edges->last_fall : edges->last_rise, at);
        break;
    case HIL_RULES_THERMOMETER_DATA: track_thermometer_bus(dev, high, at); break;
    /* for these commands, the model of the chip checks the rule when it knows the command */
    default: break;
    }
}

static bool is_open_drain(const struct hil_rules_device *dev, unsigned port, unsigned pin)
{
    return dev->gpio->state->port[port].otyper >> pin & 1u;
}

/* True if rules.def has a pin on this port. */
static bool is_port_checked(unsigned port)
{
    bool kept = false;
    for (unsigned i = 0; i < HIL_RULES_PIN_COUNT; i++)
        kept |= pin_table[i].port == port;
    return kept;
}

void hil_rules_on_store(void *device, unsigned port)
{
    struct hil_rules_device *dev = device;
    if (!hil_rules_are_checked(dev) || !is_port_checked(port))
        return;
    struct hil_timestamp at = hil_access_timestamp(dev->core);
    for (unsigned i = 0; i < HIL_RULES_PIN_COUNT; i++) {
        bool high = pin_table[i].port == port && hil_gpio_level(dev->gpio, port, pin_table[i].pin);
        if (pin_table[i].port != port || high == dev->state->pin[i].is_high)
            continue;
        dev->state->unlocated_edge_count += !at.ps;
        at.slew_ns = high && is_open_drain(dev, port, pin_table[i].pin)
                       ? PULL_UP_RISE_NS
                       : speed_limits[get_pin_speed(dev, port, pin_table[i].pin)].slew_ns;
        track_edge(dev, (enum hil_rules_pin)i, high, at);
    }
}

/* --- floating inputs --- */

static bool have_bits_effect(struct hil_rules_device *dev, uint32_t value, uint32_t bits,
                             struct hil_whatif_difference *difference)
{
    struct hil_timestamp read = hil_rules_are_checked(dev) ? hil_access_timestamp(dev->core)
                                                           : (struct hil_timestamp){0};
    bits &= hil_bus_read_mask(dev->core);
    if (!read.ps || !bits)
        return false;
    if (hil_whatif_has_effect(dev->core, read.pc, value, bits, difference))
        return true;
    hil_rules_record_pass(dev, HIL_RULE_FLOATING);
    return false;
}

void hil_rules_check_floating(void *device, unsigned port, uint32_t value, uint32_t bits)
{
    struct hil_rules_device *dev = device;
    struct hil_whatif_difference difference;
    if (have_bits_effect(dev, value, bits, &difference))
        hil_rules_record_violation(dev, HIL_RULE_FLOATING, difference.pc,
                                   "P%c%u is an input, but nothing drives or pulls it",
                                   'A' + (int)port, difference.bit);
}

void hil_rules_check_unknown(struct hil_rules_device *dev, const char *pin, uint32_t value,
                             uint32_t bits)
{
    struct hil_whatif_difference difference;
    if (have_bits_effect(dev, value, bits, &difference))
        hil_rules_record_violation(dev, HIL_RULE_FLOATING, difference.pc,
                                   "%s was received while nothing drove or pulled it", pin);
}

void hil_rules_reset(struct hil_rules_device *dev)
{
    dev->state->last_bus_stop = (struct hil_timestamp){0};
    for (unsigned i = 0; i < HIL_RULES_PIN_COUNT; i++)
        dev->state->pin[i] = (struct hil_rules_edges){
            .is_high = hil_gpio_level(dev->gpio, pin_table[i].port, pin_table[i].pin)};
}

/* --- names --- */

enum hil_rule hil_rule_by_name(const char *name, size_t length)
{
    for (unsigned i = 0; i < HIL_RULE_COUNT; i++) {
        if (strlen(rule_table[i].name) == length && memcmp(rule_table[i].name, name, length) == 0)
            return (enum hil_rule)i;
    }
    return HIL_RULE_COUNT;
}

unsigned hil_rules_count_violated(const struct hil_rules_device *dev, uint64_t *times)
{
    unsigned rules_broken = 0;
    *times = 0;
    for (unsigned i = 0; i < HIL_RULE_COUNT; i++) {
        uint64_t broken = is_only_counted(dev, (enum hil_rule)i)
                            ? dev->state->tally[i].violation_count
                            : 0;
        rules_broken += broken != 0;
        *times += broken;
    }
    return rules_broken;
}

void hil_rules_print_tallies(const struct hil_rules_device *dev, FILE *out)
{
    fprintf(out, "%-18s %9s %8s %12s %12s %8s  %s\n", "rule", "judged", "broken", "wanted, ns",
            "nearest, ns", "slew, ns", "from, to; what; source");
    for (unsigned i = 0; i < HIL_RULE_COUNT; i++) {
        const struct hil_rule_tally *tally = &dev->state->tally[i];
        char from[80], to[80], times[40] = "";
        format_code_location(dev, tally->from_pc, from, sizeof from);
        format_code_location(dev, tally->to_pc, to, sizeof to);
        if (rule_table[i].kind == MINIMUM && tally->measurement_count)
            snprintf(times, sizeof times, "%12.1f %12.1f %8.0f", tally->limit_ns, tally->worst_ns,
                     tally->slew_ns);
        fprintf(out, "%-18s %9llu %8llu %34s  ", rule_table[i].name,
                (unsigned long long)tally->measurement_count,
                (unsigned long long)tally->violation_count, times);
        if (tally->measurement_count && (tally->from_pc || tally->to_pc))
            fprintf(out, "%s, %s; ", from, to);
        fprintf(out, "%s; %s\n", rule_table[i].requirement, rule_table[i].source);
    }
    fprintf(out,
            "edges that were not checked, because the instruction that wrote the pin was not "
            "found: %llu\n",
            (unsigned long long)dev->state->unlocated_edge_count);
}
