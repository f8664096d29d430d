#include "hil/periph/gpio.h"

#include "hil/board/machine.h"

#define PORT_A 0u
#define PORT_B 1u
#define PORT_D 3u
#define PORT_E 4u

void hil_gpio_reset_port(struct hil_board *board, unsigned port)
{
    struct hil_gpio_port *p = &board->state.gpio.port[port];
    uint16_t driven = p->driven, outside = p->outside;
    *p = (struct hil_gpio_port){.driven = driven, .outside = outside};
    if (port == 0) { /* SWD and JTAG pins come up in alternate mode (8.4.1) */
        p->moder = 0xa8000000;
        p->ospeedr = 0x0c000000;
        p->pupdr = 0x64000000;
    } else if (port == 1) {
        p->moder = 0x00000280;
        p->ospeedr = 0x000000c0;
        p->pupdr = 0x00000100;
    }
    hil_gpio_changed(board, hil_now(board));
}

enum hil_pin_mode hil_gpio_mode(const struct hil_board *board, unsigned port, unsigned pin)
{
    return (enum hil_pin_mode)(board->state.gpio.port[port].moder >> (2u * pin) & 3u);
}

int hil_gpio_alternate(const struct hil_board *board, unsigned port, unsigned pin)
{
    if (hil_gpio_mode(board, port, pin) != HIL_PIN_ALTERNATE)
        return -1;
    return (int)(board->state.gpio.port[port].afr[pin / 8u] >> (4u * (pin % 8u)) & 15u);
}

/* What a peripheral puts on a pin that is given to it; *drives false: it only listens there. */
static bool alternate_output(const struct hil_board *board, unsigned port, unsigned pin, bool *drives)
{
    int function = hil_gpio_alternate(board, port, pin);
    *drives = true;
    if (port == PORT_D && (pin == 12 || pin == 13) && function == 2)
        return hil_tim4_output(board, pin - 12u, drives);
    if (port == PORT_A && pin == 9 && function == 7)
        return true; /* USART1_TX; between bytes it idles high, bytes are not modelled as edges */
    if (port == PORT_D && pin == 1 && function == 9)
        return true; /* CAN1_TX, recessive; likewise */
    *drives = false;
    return false;
}

bool hil_gpio_level(const struct hil_board *board, unsigned port, unsigned pin)
{
    const struct hil_gpio_port *p = &board->state.gpio.port[port];
    enum hil_pin_mode mode = hil_gpio_mode(board, port, pin);
    if (mode == HIL_PIN_OUTPUT) {
        bool high = (p->odr >> pin & 1u) != 0;
        if (!high || !(p->otyper >> pin & 1u))
            return high;
    } else if (mode == HIL_PIN_ALTERNATE) {
        bool drives;
        bool level = alternate_output(board, port, pin, &drives);
        if (drives)
            return level;
    }
    if (p->driven >> pin & 1u)
        return (p->outside >> pin & 1u) != 0;
    if (port == PORT_A && pin == 10)
        return hil_usart_line_in(board);
    if (port == PORT_E && pin == 3)
        return !hil_rig_lamp_draws(board);
    return (p->pupdr >> (2u * pin) & 3u) == 1u;
}

void hil_gpio_excitation_changed(struct hil_board *board, uint64_t at)
{
    hil_rig_excitation(board, hil_gpio_level(board, PORT_D, 12), hil_gpio_level(board, PORT_D, 13), at);
}

void hil_gpio_changed(struct hil_board *board, uint64_t at)
{
    hil_gpio_excitation_changed(board, at);
    hil_rig_shunt(board, hil_gpio_level(board, PORT_E, 1), at);
    hil_spi_pins_changed(board, at);
    hil_i2c_lines_changed(board, at);
    hil_camera_trigger(board, hil_gpio_level(board, PORT_E, 2), at);
}

void hil_gpio_drive(struct hil_board *board, unsigned port, unsigned pin, bool level, uint64_t at)
{
    struct hil_gpio_port *p = &board->state.gpio.port[port];
    uint16_t bit = (uint16_t)(1u << pin);
    bool before = hil_gpio_level(board, port, pin);
    p->driven |= bit;
    p->outside = (uint16_t)(level ? p->outside | bit : p->outside & ~bit);
    bool after = hil_gpio_level(board, port, pin);
    /* PA15 with function 1 is TIM2_CH1; without it no edge ever reaches the timer. */
    if (after != before && port == PORT_A && pin == 15 && hil_gpio_alternate(board, port, pin) == 1)
        hil_tim2_input_edge(board, 0, after, at);
    if (after != before && port == PORT_B && pin == 3 && hil_gpio_alternate(board, port, pin) == 1) /* TIM2_CH2 */
        hil_tim2_input_edge(board, 1, after, at);
}

uint32_t hil_gpio_read(struct hil_board *board, unsigned unit, uint32_t offset)
{
    const struct hil_gpio_port *p = &board->state.gpio.port[unit];
    uint32_t value = 0;
    switch (offset) {
    case 0x00:
        return p->moder;
    case 0x04:
        return p->otyper;
    case 0x08:
        return p->ospeedr;
    case 0x0c:
        return p->pupdr;
    case 0x10:
        for (unsigned pin = 0; pin < 16; pin++) {
            if (hil_gpio_mode(board, unit, pin) != HIL_PIN_ANALOGUE)
                value |= (uint32_t)hil_gpio_level(board, unit, pin) << pin;
        }
        return value;
    case 0x14:
        return p->odr;
    case HIL_GPIO_BSRR:
        return 0;
    case 0x20:
        return p->afr[0];
    case 0x24:
        return p->afr[1];
    default:
        return hil_bus_no_register(board);
    }
}

void hil_gpio_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_gpio_port *p = &board->state.gpio.port[unit];
    switch (offset) {
    case 0x00:
        p->moder = value;
        break;
    case 0x04:
        p->otyper = value & 0xffffu;
        break;
    case 0x08:
        p->ospeedr = value;
        break;
    case 0x0c:
        p->pupdr = value;
        break;
    case 0x14:
        p->odr = value & 0xffffu;
        break;
    case HIL_GPIO_BSRR: /* set wins over reset */
        p->odr = ((p->odr & ~(value >> 16)) | value) & 0xffffu;
        break;
    case 0x20:
        p->afr[0] = value;
        break;
    case 0x24:
        p->afr[1] = value;
        break;
    default:
        hil_bus_no_register(board);
        return;
    }
    if (board->pin_times)
        hil_pin_times_stored(board, unit);
    if (unit == PORT_D || unit == PORT_B || unit == PORT_E)
        hil_gpio_changed(board, hil_now(board));
}
