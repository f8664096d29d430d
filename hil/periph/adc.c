#include "hil/periph/adc.h"

#include <math.h>

#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/periph/options.h"
#include "hil/periph/dma.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"

#define SR                 0x00u
#define CR2                0x08u
#define DR                 0x4cu
#define COMMON_CSR         0x300u
#define COMMON_CCR         0x304u
#define SR_EOC             2u
#define SR_STRT            16u
#define SR_OVR             32u
#define CR1_EOCIE          (1u << 5)
#define CR1_SCAN           (1u << 8)
#define CR1_OVRIE          (1u << 26)
#define CR2_ADON           1u
#define CR2_EXTEN_RISING   (1u << 28)
#define CR2_DMA            (1u << 8)
#define CR2_DDS            (1u << 9)
#define CR2_EOCS           (1u << 10)
#define CR2_SWSTART        (1u << 30)
#define CONVERSION_CLOCKS  12u
/* ADC clocks from the trigger to the first sampling window; data sheet: at most 3 */
#define LATENCY_CLOCKS     2u
#define ADC_CLOCK_LIMIT_HZ 36000000u
#define FIRST_CLOCK_BIT    8u /* APB2ENR.ADC1EN; ADC3EN is two bits higher */

static const uint32_t data_register[2] = {0x4001204cu, 0x4001224cu};
static const enum hil_event_slot event_slots[2] = {HIL_EVENT_ADC1, HIL_EVENT_ADC3};

/* Analogue inputs 0..15 of ADC1 and ADC3 (data sheet table 7): 16 times the port plus the pin. */
#define PIN_PORT(pin)   ((pin) / 16u)
#define PIN_NUMBER(pin) ((pin) % 16u)
static const uint8_t input_pins[2][16] = {
    {0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, /* inputs PA0 .. PA7 */
     0x10, 0x11, 0x20, 0x21, 0x22, 0x23, 0x24, 0x25 /* PB0, PB1, PC0 .. PC5 */},
    {0x00, 0x01, 0x02, 0x03, 0x56, 0x57, 0x58, 0x59, /* PA0 .. PA3, PF6 .. PF9 */
     0x5a, 0x53, 0x20, 0x21, 0x22, 0x23, 0x54, 0x55 /* PF10, PF3, PC0 .. PC3, PF4, PF5 */},
};

static void update_irq(struct hil_adc_device *dev)
{
    bool line = false;
    for (unsigned i = 0; i < 2; i++) {
        const struct hil_adc *a = &dev->state[i];
        line |= ((a->sr & SR_EOC) && (a->cr1 & CR1_EOCIE)) ||
                ((a->sr & SR_OVR) && (a->cr1 & CR1_OVRIE));
    }
    hil_irq_set_line(dev->core, HIL_IRQ_ADC, line);
}

void hil_adc_reset(void *device, unsigned unit)
{
    struct hil_adc_device *dev = device;
    (void)unit;
    for (unsigned i = 0; i < 2; i++) {
        uint64_t rng_state = dev->state[i].random_state;
        dev->state[i] = (struct hil_adc){.htr = 0xfff, .random_state = rng_state};
        hil_event_set_cycle(dev->core, event_slots[i], HIL_NEVER);
    }
    *dev->ccr = 0;
    update_irq(dev);
}

static unsigned count_ones(uint64_t z)
{
    z -= z >> 1 & 0x5555555555555555ull;
    z = (z & 0x3333333333333333ull) + (z >> 2 & 0x3333333333333333ull);
    z = (z + (z >> 4)) & 0x0f0f0f0f0f0f0f0full;
    return (unsigned)(z * 0x0101010101010101ull >> 56);
}

/* Noise of two LSB rms, cheap and identical on all computers: the number of ones among 64 random
 * bits (binomial, sigma 4) in half LSB, plus a uniform half LSB to fill the gaps. Variance 4 +
 * 1/48; tails beyond four sigma are slightly thinner than Gaussian. */
static double draw_noise_lsb(struct hil_adc *a)
{
    uint64_t z = mr_splitmix64(&a->random_state);
    uint64_t dither = z * 0xd6e8feb86659fd93ull >> 32;
    return 0.5 * ((double)count_ones(z) - 32.0) + 0.5 * ((double)dither / 4294967296.0 - 0.5);
}

/* Converts with the errors of a real converter; the code is not rounded yet. */
static double convert_with_errors(struct hil_adc_device *dev, unsigned unit, unsigned k,
                                  double volts)
{
    struct hil_adc *a = &dev->state[unit];
    const struct hil_adc_errors *errors = dev->errors;
    int source = a->source[k];
    /* the pin's protection clamps the voltage to the supply */
    double pin_v = fmin(fmax(volts, 0.0), dev->vdda_v);
    double sampled_v = pin_v + (a->sample_capacitor_v - pin_v) * a->remaining_share[k];
    double code = hil_adc_code_with_errors(errors, unit, sampled_v / dev->vdda_v * 4096.0) + 0.5;
    a->sample_capacitor_v = sampled_v;
    if (dev->options->has_adc_noise)
        code += draw_noise_lsb(a) * (source < 0 ? 1.0 : errors->noise_ratio[source]);
    return code;
}

static uint16_t round_code(double code)
{
    return code < 0.0 ? 0 : code >= 4095.0 ? 4095 : (uint16_t)code;
}

static uint16_t convert_codes(struct hil_adc_device *dev, unsigned unit, unsigned k, uint64_t at)
{
    struct hil_adc *a = &dev->state[unit];
    unsigned port = PIN_PORT(input_pins[unit][a->channel[k]]),
             pin = PIN_NUMBER(input_pins[unit][a->channel[k]]);
    double volts;
    if (dev->recorded.code)
        return dev->recorded.code(dev->recorded.context, port, pin, at);
    enum hil_pin_mode mode = hil_gpio_mode(dev->gpio, port, pin);
    /* the pin is used as an output, so the converter reads the level that it drives */
    if (mode == HIL_PIN_OUTPUT || mode == HIL_PIN_ALTERNATE)
        volts = hil_gpio_level(dev->gpio, port, pin) ? dev->vdda_v : 0.0;
    else
        volts = dev->analogue.volts(dev->analogue.context, a->source[k], at);
    if (dev->errors)
        return round_code(convert_with_errors(dev, unit, k, volts));
    double code = volts / dev->vdda_v * 4096.0 + 0.5;
    if (dev->options->has_adc_noise)
        code += draw_noise_lsb(a);
    return round_code(code);
}

static uint64_t get_conversion_end(const struct hil_adc *a, unsigned k)
{
    return a->start_cycle + (uint64_t)a->conversion_end_clock[k] * a->clock_cycles;
}

static void sample_until(struct hil_adc_device *dev, unsigned unit, uint64_t at)
{
    struct hil_adc *a = &dev->state[unit];
    while (a->is_sequence_running && a->sampled_count < a->sequence_length) {
        uint64_t instant = get_conversion_end(a, a->sampled_count) -
                           (uint64_t)CONVERSION_CLOCKS * a->clock_cycles;
        if (instant > at)
            break;
        a->code[a->sampled_count] = convert_codes(dev, unit, a->sampled_count, instant);
        a->sampled_count++;
    }
}

/* Returns the request for the DMA stream that is set up for this converter. Each converter can use
 * two streams (RM0090 table 43). */
static struct hil_dma_request get_dma_request(const struct hil_adc_device *dev, unsigned unit)
{
    static const uint8_t streams[2][2] = {{0, 4}, {0, 1}};
    unsigned channel = unit == HIL_ADC1 ? 0 : 2;
    unsigned chosen = streams[unit][1];
    const struct hil_dma_stream *first = &dev->dma->state[1].stream[streams[unit][0]];
    if ((first->cr & 1u) && (first->cr >> 25 & 7u) == channel)
        chosen = streams[unit][0];
    return (struct hil_dma_request){1, chosen, channel, data_register[unit], false};
}

static void stop_on_overrun(struct hil_adc_device *dev, unsigned unit)
{
    struct hil_adc *a = &dev->state[unit];
    a->sr |= SR_OVR;
    a->is_sequence_running =
        false; /* the sequence is lost, and no new one starts until OVR is cleared (13.8.1) */
    dev->core->state.counters.adc_overruns++;
    hil_trace(dev->core, "ADC%u overrun", unit == HIL_ADC1 ? 1 : 3);
}

/* Passes the codes from `delivered_count` to `ended` - 1 to DMA or to DR. */
static void deliver_codes(struct hil_adc_device *dev, unsigned unit, unsigned ended)
{
    struct hil_adc *a = &dev->state[unit];
    while (a->is_sequence_running && a->delivered_count < ended) {
        struct hil_dma_request request = get_dma_request(dev, unit);
        bool wants_dma = (a->cr2 & CR2_DMA) && !a->has_dma_ended;
        if (a->is_dr_full && (a->cr2 & (CR2_DMA | CR2_EOCS))) {
            stop_on_overrun(dev, unit);
            return;
        }
        uint32_t room = wants_dma ? hil_dma_items_until_flag(dev->dma, &request) : 0;
        if (room) {
            uint32_t n = ended - a->delivered_count < room ? ended - a->delivered_count : room;
            uint32_t before = dev->dma->state[1].stream[request.stream].ndtr;
            hil_dma_write_items(dev->dma, &request, &a->code[a->delivered_count], n);
            a->delivered_count = (uint8_t)(a->delivered_count + n);
            a->dr = a->code[a->delivered_count - 1];
            if (n == before && !(a->cr2 & CR2_DDS))
                /* this was the last item: no more requests until DMA is switched off and on
                 * again */
                a->has_dma_ended = true;
        } else {
            a->dr = a->code[a->delivered_count++];
            a->is_dr_full = true;
            if ((a->cr2 & CR2_EOCS) || a->delivered_count == a->sequence_length)
                a->sr |= SR_EOC;
        }
    }
}

static void advance_sequence(struct hil_adc_device *dev, unsigned unit, uint64_t at)
{
    struct hil_adc *a = &dev->state[unit];
    sample_until(dev, unit, at);
    unsigned ended = a->delivered_count;
    while (a->is_sequence_running && ended < a->sequence_length &&
           get_conversion_end(a, ended) <= at)
        ended++;
    if (ended > a->delivered_count)
        deliver_codes(dev, unit, ended);
    if (a->is_sequence_running && a->delivered_count == a->sequence_length) {
        a->is_sequence_running = false;
        dev->core->state.counters.adc_scans[unit]++;
    }
    update_irq(dev);
}

static void schedule_conversion(struct hil_adc_device *dev, unsigned unit)
{
    struct hil_adc *a = &dev->state[unit];
    uint64_t next = HIL_NEVER;
    if (a->is_sequence_running) {
        struct hil_dma_request request = get_dma_request(dev, unit);
        uint32_t room = (a->cr2 & CR2_DMA) && !a->has_dma_ended
                          ? hil_dma_items_until_flag(dev->dma, &request)
                          : 0;
        uint32_t left = (uint32_t)a->sequence_length - a->delivered_count;
        /* without DMA, deliver single codes, because each conversion may have an effect (EOCS,
         * overrun) */
        uint32_t n = room ? (room < left ? room : left) : 1;
        next = get_conversion_end(a, a->delivered_count + n - 1);
    }
    hil_event_set_cycle(dev->core, event_slots[unit], next);
}

static void handle_event(struct hil_adc_device *dev, unsigned unit, uint64_t at)
{
    advance_sequence(dev, unit, at);
    schedule_conversion(dev, unit);
}

void hil_adc_advance(void *device, uint64_t at)
{
    struct hil_adc_device *dev = device;
    for (unsigned unit = 0; unit < 2; unit++) {
        if (dev->state[unit].is_sequence_running)
            handle_event(dev, unit, at);
    }
}

void hil_adc1_event(void *device, uint64_t at)
{
    handle_event(device, HIL_ADC1, at);
}

void hil_adc3_event(void *device, uint64_t at)
{
    handle_event(device, HIL_ADC3, at);
}

static unsigned get_sequence_channel(const struct hil_adc *a, unsigned k)
{
    /* SQ1..6 in SQR3, 7..12 in SQR2, 13..16 in SQR1; five bits each. */
    return a->sqr[2u - k / 6u] >> (5u * (k % 6u)) & 31u;
}

/* Checks the rule SAMPLING for an input with this source resistance. */
static void check_sampling_time(struct hil_rules_device *rules, unsigned adc, unsigned input,
                                double ohm, unsigned sample_clocks, double clock_hz)
{
    double most_ohm = hil_adc_max_source_ohm(sample_clocks, clock_hz);
    if (ohm <= most_ohm)
        hil_rules_record_pass(rules, HIL_RULE_SAMPLING);
    else
        hil_rules_record_violation(rules, HIL_RULE_SAMPLING, 0,
                                   "the source at input %u of ADC%u has %.0f Ohm, but sampling for "
                                   "%u clocks of %.1f MHz allows only %.0f Ohm",
                                   input, adc, ohm, sample_clocks, clock_hz * 1e-6, most_ohm);
}

/* Plans the sequence from the registers. Returns false if the sequence is not possible. */
static bool plan_sequence(struct hil_adc_device *dev, unsigned unit)
{
    static const uint16_t sample_clocks[8] = {3, 15, 28, 56, 84, 112, 144, 480};
    struct hil_adc *a = &dev->state[unit];
    uint32_t clocks = 0;
    a->sequence_length = (uint8_t)((a->cr1 & CR1_SCAN) ? (a->sqr[0] >> 20 & 15u) + 1u : 1u);
    for (unsigned k = 0; k < a->sequence_length; k++) {
        unsigned channel = get_sequence_channel(a, k);
        if (channel > 15) {
            hil_core_stop(dev->core, MR_UNMODELLED, "conversion of internal channel %u of ADC%u",
                          channel, unit == HIL_ADC1 ? 1 : 3);
            return false;
        }
        uint32_t smp = channel < 10 ? a->smpr[1] >> (3u * channel)
                                    : a->smpr[0] >> (3u * (channel - 10u));
        clocks += sample_clocks[smp & 7u] + CONVERSION_CLOCKS;
        a->channel[k] = (uint8_t)channel;
        unsigned port = PIN_PORT(input_pins[unit][channel]),
                 pin = PIN_NUMBER(input_pins[unit][channel]);
        if (!hil_board_type_has_pin(dev->options->type, port, pin)) {
            hil_core_stop(dev->core, MR_HALTED,
                          "conversion of P%c%u, a pin that this package does not have", 'A' + port,
                          pin);
            return false;
        }
        a->source[k] = (int8_t)dev->analogue.source(dev->analogue.context, port, pin);
        a->conversion_end_clock[k] = (uint16_t)clocks;
        if (a->source[k] >= 0 && dev->analogue.source_ohm)
            check_sampling_time(dev->rules, unit == HIL_ADC1 ? 1 : 3, channel,
                                dev->analogue.source_ohm(dev->analogue.context, a->source[k]),
                                sample_clocks[smp & 7u],
                                (double)dev->core->state.clock.hclk_hz / a->clock_cycles);
        if (dev->errors)
            a->remaining_share[k] = hil_adc_remaining_share(
                dev->errors, a->source[k],
                (double)sample_clocks[smp & 7u] * a->clock_cycles / dev->core->state.clock.hclk_hz);
    }
    a->is_sequence_planned = true;
    return true;
}

static void start_sequence(struct hil_adc_device *dev, unsigned unit, uint64_t at)
{
    struct hil_adc *a = &dev->state[unit];
    uint32_t prescaler = 2u * ((*dev->ccr >> 16 & 3u) + 1u);
    uint32_t clock_cycles = prescaler * hil_rcc_pclk_divider(dev->rcc, HIL_RCC_APB2);
    uint32_t hclk_hz = dev->core->state.clock.hclk_hz;
    if (hclk_hz / clock_cycles > ADC_CLOCK_LIMIT_HZ) {
        hil_core_stop(dev->core, MR_HALTED,
                      "the ADC clock is %u Hz, but the chip allows at most 36 MHz",
                      (unsigned)(hclk_hz / clock_cycles));
        return;
    }
    if (a->clock_cycles != clock_cycles || a->planned_hclk_hz != hclk_hz)
        a->is_sequence_planned = false;
    a->clock_cycles = clock_cycles;
    a->planned_hclk_hz = hclk_hz;
    a->start_cycle = at + (uint64_t)LATENCY_CLOCKS * clock_cycles;
    a->sampled_count = a->delivered_count = 0;
    if (!a->is_sequence_planned && !plan_sequence(dev, unit))
        return;
    hil_rules_check_interval(dev->rules, HIL_RULE_CONVERTER_ON, a->switch_on_time,
                             hil_timestamp_at_cycle(dev->core, at));
    a->switch_on_time = (struct hil_timestamp){0};
    a->is_sequence_running = true;
    a->sr |= SR_STRT;
    schedule_conversion(dev, unit);
}

static void try_start_sequence(struct hil_adc_device *dev, unsigned unit, uint64_t at)
{
    struct hil_adc *a = &dev->state[unit];
    if (!hil_rcc_is_clock_on(dev->rcc, HIL_RCC_APB2, FIRST_CLOCK_BIT + 2u * unit) ||
        !(a->cr2 & CR2_ADON))
        return;
    advance_sequence(dev, unit, at);
    if (a->is_sequence_running || (a->sr & SR_OVR)) {
        dev->core->state.counters.adc_triggers_ignored++;
        schedule_conversion(dev, unit);
        return;
    }
    start_sequence(dev, unit, at);
}

void hil_adc_trigger(struct hil_adc_device *dev, unsigned extsel, bool rising, uint64_t at)
{
    for (unsigned unit = 0; unit < 2; unit++) {
        struct hil_adc *a = &dev->state[unit];
        a->trigger_levels = (uint16_t)((a->trigger_levels & ~(1u << extsel)) | (unsigned)rising
                                                                                   << extsel);
        uint32_t exten = a->cr2 >> 28 & 3u;
        if ((a->cr2 >> 24 & 15u) == extsel && (exten & (rising ? 1u : 2u)))
            try_start_sequence(dev, unit, at);
    }
}

/* Finds the converter to which a register belongs. Returns false if its clock is off. */
static bool find_unit(struct hil_adc_device *dev, uint32_t offset, unsigned *unit)
{
    *unit = offset < 0x100 ? HIL_ADC1 : HIL_ADC3;
    if (hil_rcc_is_clock_on(dev->rcc, HIL_RCC_APB2, FIRST_CLOCK_BIT + 2u * *unit))
        return true;
    hil_bus_refuse(dev->core, "the clock of this converter is off");
    return false;
}

uint32_t hil_adc_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_adc_device *dev = device;
    if (offset == COMMON_CSR)
        return (dev->state[HIL_ADC1].sr & 0x3fu) | (dev->state[HIL_ADC3].sr & 0x3fu) << 16;
    if (offset == COMMON_CCR)
        return *dev->ccr;
    if (!find_unit(dev, offset, &unit))
        return 0;
    struct hil_adc *a = &dev->state[unit];
    advance_sequence(dev, unit, hil_now_cycle(dev->core));
    schedule_conversion(dev, unit);
    if ((offset & 0xffu) == DR) {
        a->is_dr_full = false;
        a->sr &= ~SR_EOC;
        update_irq(dev);
    }
    return a->word[(offset & 0xffu) / 4u];
}

static void write_cr2(struct hil_adc_device *dev, unsigned unit, uint32_t value)
{
    struct hil_adc *a = &dev->state[unit];
    uint32_t before = a->cr2;
    uint32_t armed = value & ~before & CR2_EXTEN_RISING;
    if (armed && (a->trigger_levels >> (value >> 24 & 15u) & 1u))
        hil_bus_refuse(
            dev->core,
            "EXTEN is set while the trigger is high: the chip may detect this as an edge");
    a->cr2 = value & ~CR2_SWSTART;
    if (value & ~before & CR2_ADON)
        a->switch_on_time = hil_access_timestamp(dev->core);
    if ((value & CR2_DMA) && !(before & CR2_DMA)) {
        a->has_dma_ended = false;
        a->is_dr_full = false;
    }
    if (!(value & CR2_ADON))
        a->is_sequence_running = false;
    if ((value & CR2_SWSTART) && (before & CR2_ADON))
        try_start_sequence(dev, unit, hil_now_cycle(dev->core));
}

void hil_adc_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_adc_device *dev = device;
    if (offset == COMMON_CCR) {
        *dev->ccr = value;
        /* plan the sequences again, because the clock has changed */
        dev->state[HIL_ADC1].is_sequence_planned = dev->state[HIL_ADC3].is_sequence_planned = false;
        return;
    }
    if (!find_unit(dev, offset, &unit))
        return;
    struct hil_adc *a = &dev->state[unit];
    advance_sequence(dev, unit, hil_now_cycle(dev->core));
    /* only the next sequence uses the change; a running one continues */
    a->is_sequence_planned = false;
    switch (offset & 0xffu) {
    case SR:
        if ((a->sr & SR_OVR) && !(value & SR_OVR))
            a->is_dr_full = false;
        a->sr &= value;
        break;
    case CR2: write_cr2(dev, unit, value); break;
    default: a->word[(offset & 0xffu) / 4u] = value; break;
    }
    update_irq(dev);
    schedule_conversion(dev, unit);
}

/* ---- errors of a real converter ---- */

#define CONVERTER_BITS   12u
#define BITS_WITH_ERRORS 8u
#define LAST_CODE        (HIL_ADC_CODES - 1u)
#define PI               3.14159265358979323846

/* Returns a number that is uniform from -1 to 1. */
static double draw_uniform(uint64_t *random)
{
    return (double)(mr_splitmix64(random) >> 11) * 0x1p-52 - 1.0;
}

/* Draws random errors of the capacitors, proportional to the square root of their size. Where a bit
 * carries, its capacitor replaces those of all lower bits, so the error jumps. The errors are
 * scaled so that the largest jump is `jump_lsb`. */
static void draw_carry_steps(float curve_lsb[HIL_ADC_CODES], double jump_lsb, uint64_t *random)
{
    double off[BITS_WITH_ERRORS], all = 0.0, most = 0.0;
    for (unsigned b = 0; b < BITS_WITH_ERRORS; b++) {
        off[b] = draw_uniform(random) / sqrt((double)(1u << b));
        all += off[b];
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++) {
        double sum = -all * (double)code / LAST_CODE;
        for (unsigned b = 0; b < BITS_WITH_ERRORS; b++)
            sum += code >> (CONVERTER_BITS - 1u - b) & 1u ? off[b] : 0.0;
        curve_lsb[code] = (float)sum;
        if (code)
            most = fmax(most, fabs(sum - (double)curve_lsb[code - 1u]));
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++)
        curve_lsb[code] *= (float)(jump_lsb / most);
}

static double find_curve_peak(const float curve_lsb[HIL_ADC_CODES], const double bow[2], double by)
{
    double peak = 0.0;
    for (unsigned code = 0; code < HIL_ADC_CODES; code += 4u) {
        double x = (double)code / LAST_CODE;
        peak = fmax(peak, fabs((double)curve_lsb[code] +
                               by * (bow[0] * sin(PI * x) + bow[1] * sin(2.0 * PI * x))));
    }
    return peak;
}

void hil_adc_draw_inl(float curve_lsb[HIL_ADC_CODES], double peak_lsb, uint64_t *random)
{
    double jump_lsb = HIL_ADC_DNL_MAX_LSB * fabs(draw_uniform(random));
    const double bow[2] = {draw_uniform(random), draw_uniform(random)};
    double low = 0.0, high = 2.0 * peak_lsb / fmax(fabs(bow[0]) + fabs(bow[1]), 0.01) + 10.0;
    draw_carry_steps(curve_lsb, jump_lsb, random);
    double carries_lsb = find_curve_peak(curve_lsb, bow, 0.0);
    for (unsigned code = 0; carries_lsb > peak_lsb && code < HIL_ADC_CODES; code++)
        curve_lsb[code] *= (float)(peak_lsb / carries_lsb);
    for (unsigned halvings = 0; halvings < 30u; halvings++) {
        double by = 0.5 * (low + high);
        if (find_curve_peak(curve_lsb, bow, by) > peak_lsb)
            high = by;
        else
            low = by;
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++) {
        double x = (double)code / LAST_CODE;
        curve_lsb[code] += (float)(low * (bow[0] * sin(PI * x) + bow[1] * sin(2.0 * PI * x)));
    }
}

double hil_adc_code_with_errors(const struct hil_adc_errors *errors, unsigned unit,
                                double ideal_code)
{
    double within = fmin(fmax(ideal_code, 0.0), (double)(HIL_ADC_CODES - 1u));
    return ideal_code + errors->offset_lsb[unit] + errors->gain_lsb[unit] * within / HIL_ADC_CODES +
           (double)errors->inl_lsb[unit][(unsigned)within];
}

double hil_adc_remaining_share(const struct hil_adc_errors *errors, int source, double window_s)
{
    double ohm = HIL_ADC_SWITCH_MAX_OHM + (source < 0 ? 0.0 : errors->source_ohm[source]);
    double left = exp(-window_s / (ohm * HIL_ADC_CAPACITOR_MAX_F));
    return left + (source < 0 ? 0.0 : errors->kickback_share[source]);
}

/* ---- sampling time ---- */

/* C(ADC) typical and R(ADC) maximum, from the ADC characteristics of the data sheet. */
#define CAPACITOR_TYPICAL_F 4e-12
#define SWITCH_MAX_OHM      6000.0

double hil_adc_max_source_ohm(unsigned sample_clocks, double clock_hz)
{
    return ((double)sample_clocks - 0.5) /
               (clock_hz * CAPACITOR_TYPICAL_F * log(exp2((int)CONVERTER_BITS + 2))) -
           SWITCH_MAX_OHM;
}
