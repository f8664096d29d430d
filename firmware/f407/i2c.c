/* board.h's thermometer bus on I2C1, 80 kHz from PCLK1 of 42 MHz: PB6 SCL, PB7 SDA, both with a
 * pull-up on the board. RM0090 27.3.3 (master mode).
 *
 * Each poll, once a block, handles one event of the controller. Until then the controller holds SCL
 * low, which devices tolerate (the TMP112 times out after 30 ms). The rate is 80 kHz, because
 * between 88 and 100 kHz the chip's repeated start may be too early (errata ES0182). Two bytes are
 * read with POS, so that the timing of software does not matter. A stuck bus is freed with clocks
 * from the pins as outputs, one edge per poll. A bus error alone is ignored: a master may report
 * one without cause (ES0182), and the transfer continues. */
#include "firmware/f407/drivers.h"
#include "firmware/board.h"

#define CLOCK_MHZ     42u
#define CCR_80_KHZ    263u /* 42 MHz / (2 x 80 kHz) */
#define TRISE_1000_NS 43u  /* 1000 ns in periods of PCLK1, plus one */
#define EVENT_POLLS   20u  /* limit for an event, in polls; a byte lasts 0.1 ms */
/* nine clocks, within which a device ends its byte */
#define CLOCK_EDGES   18u

static enum phase {
    PHASE_OFF,
    PHASE_IDLE,
    PHASE_START,
    PHASE_ADDRESS,
    PHASE_SEND,
    PHASE_RESTART,
    PHASE_READ_ADDRESS,
    PHASE_RECEIVE,
    PHASE_STOP,
    PHASE_CLOCKING,
} phase;
static enum i2c_status transfer_status;
static uint8_t device_address;
static const uint8_t *out_bytes;
static size_t out_length, sent_length;
static uint8_t *in_bytes;
static size_t in_length;
static unsigned polls, clock_edge;

static void configure_bus(void)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = CLOCK_MHZ;
    I2C1->CCR = CCR_80_KHZ;
    I2C1->TRISE = TRISE_1000_NS;
    I2C1->CR1 = I2C_CR1_PE;
}

void i2c_start(void)
{
    RCC->APB1ENR |= RCC_APB1ENR_I2C1;
    (void)RCC->APB1ENR;
    pin_write(PIN_THERMOMETER_CLOCK, true);
    pin_write(PIN_THERMOMETER_DATA, true);
    pins_set_i2c_mode(PINS_I2C_BUS);
    configure_bus();
    transfer_status = I2C_IDLE;
    phase = PHASE_IDLE;
}

void i2c_stop(void)
{
    if (phase == PHASE_OFF)
        return;
    I2C1->CR1 = I2C_CR1_SWRST;
    pins_set_i2c_mode(PINS_I2C_NONE);
    RCC->APB1ENR &= ~RCC_APB1ENR_I2C1;
    phase = PHASE_OFF;
}

static void set_phase(enum phase next)
{
    phase = next;
    polls = 0;
}

static void begin_clocking(void)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    pin_write(PIN_THERMOMETER_CLOCK, true);
    pin_write(PIN_THERMOMETER_DATA, true);
    pins_set_i2c_mode(PINS_I2C_CLOCKED);
    clock_edge = 0;
    transfer_status = I2C_STUCK;
    set_phase(PHASE_CLOCKING);
}

/* Generates the next edge to free the bus: clocks until SDA is released, at most nine; then a stop
 * (SDA rises while SCL is high). */
static void toggle_clock(void)
{
    bool is_free = pin_read(PIN_THERMOMETER_DATA);
    if (clock_edge && clock_edge < CLOCK_EDGES && clock_edge % 2 == 0 && is_free)
        clock_edge = CLOCK_EDGES;
    unsigned now = clock_edge++;
    if (now < CLOCK_EDGES) {
        pin_write(PIN_THERMOMETER_CLOCK, now % 2);
        return;
    }
    switch (now - CLOCK_EDGES) {
    case 0: pin_write(PIN_THERMOMETER_CLOCK, false); break;
    case 1: pin_write(PIN_THERMOMETER_DATA, false); break;
    case 2: pin_write(PIN_THERMOMETER_CLOCK, true); break;
    case 3: pin_write(PIN_THERMOMETER_DATA, true); break;
    default:
        pins_set_i2c_mode(PINS_I2C_BUS);
        configure_bus();
        phase = PHASE_IDLE;
        break;
    }
}

void i2c_begin(uint8_t address, const uint8_t *bytes, size_t length, uint8_t *answer,
               size_t answer_length)
{
    device_address = (uint8_t)(address << 1);
    out_bytes = bytes;
    out_length = length;
    in_bytes = answer;
    in_length = answer_length;
    sent_length = 0;
    transfer_status = I2C_IDLE;
    if (I2C1->SR2 & I2C_SR2_BUSY) {
        begin_clocking();
        return;
    }
    I2C1->CR1 = I2C_CR1_PE | I2C_CR1_START;
    set_phase(PHASE_START);
}

static void end_transfer(enum i2c_status status)
{
    transfer_status = status;
    I2C1->CR1 = I2C_CR1_PE | I2C_CR1_STOP;
    set_phase(PHASE_STOP);
}

/* Called when a byte was sent. Sends the next one. */
static void send_next(void)
{
    if (sent_length < out_length) {
        I2C1->DR = out_bytes[sent_length++];
        set_phase(PHASE_SEND);
    } else if (in_length) {
        I2C1->CR1 = I2C_CR1_PE | I2C_CR1_ACK | I2C_CR1_POS | I2C_CR1_START;
        set_phase(PHASE_RESTART);
    } else {
        end_transfer(I2C_IDLE);
    }
}

static void receive_last_two_bytes(void)
{
    I2C1->CR1 = I2C_CR1_PE | I2C_CR1_POS | I2C_CR1_STOP;
    in_bytes[0] = (uint8_t)I2C1->DR;
    in_bytes[1] = (uint8_t)I2C1->DR;
    set_phase(PHASE_STOP);
}

static void advance_transfer(uint32_t sr1)
{
    switch (phase) {
    case PHASE_START:
    case PHASE_RESTART:
        if (sr1 & I2C_SR1_SB) {
            I2C1->DR = device_address | (phase == PHASE_RESTART);
            set_phase(phase == PHASE_START ? PHASE_ADDRESS : PHASE_READ_ADDRESS);
        }
        break;
    case PHASE_ADDRESS:
        if (sr1 & I2C_SR1_ADDR) {
            (void)I2C1->SR2;
            send_next();
        }
        break;
    case PHASE_SEND:
        if (sr1 & I2C_SR1_BTF)
            send_next();
        break;
    case PHASE_READ_ADDRESS:
        if (sr1 & I2C_SR1_ADDR) {
            I2C1->CR1 = I2C_CR1_PE | I2C_CR1_POS; /* POS: the second byte is not acknowledged */
            (void)I2C1->SR2;
            set_phase(PHASE_RECEIVE);
        }
        break;
    case PHASE_RECEIVE:
        if (sr1 & I2C_SR1_BTF)
            receive_last_two_bytes();
        break;
    case PHASE_STOP:
        if (!(I2C1->CR1 & I2C_CR1_STOP)) {
            I2C1->CR1 = I2C_CR1_PE;
            phase = PHASE_IDLE;
        }
        break;
    default: break;
    }
}

enum i2c_status i2c_poll(void)
{
    if (phase == PHASE_IDLE || phase == PHASE_OFF)
        return transfer_status;
    if (phase == PHASE_CLOCKING) {
        toggle_clock();
        return phase == PHASE_IDLE ? transfer_status : I2C_BUSY;
    }
    uint32_t sr1 = I2C1->SR1;
    if (sr1 & I2C_SR1_BERR)
        I2C1->SR1 = ~I2C_SR1_BERR;
    if ((sr1 & I2C_SR1_ARLO) || ++polls > EVENT_POLLS) {
        begin_clocking();
    } else if (sr1 & I2C_SR1_AF) {
        I2C1->SR1 = ~I2C_SR1_AF;
        end_transfer(I2C_NO_ANSWER);
    } else {
        advance_transfer(sr1);
    }
    return phase == PHASE_IDLE ? transfer_status : I2C_BUSY;
}
