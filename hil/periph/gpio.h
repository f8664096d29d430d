/* GPIO ports A to I (RM0090 8): mode, output, input, alternate functions, and the level that a pin has in
 * the end.
 *
 * A pin's level: in output mode what ODR and OTYPER say; in alternate mode what the peripheral drives;
 * otherwise what is connected from outside; otherwise the pull. */
#ifndef MATRIG_HIL_GPIO_H
#define MATRIG_HIL_GPIO_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

#define HIL_GPIO_PORTS 9u
#define HIL_GPIO_BSRR 0x18u

struct hil_gpio_port {
    uint32_t moder, otyper, ospeedr, pupdr, odr, afr[2];
    uint16_t driven;  /* pins connected to a driver outside */
    uint16_t outside; /* its level */
};

struct hil_gpio {
    struct hil_gpio_port port[HIL_GPIO_PORTS];
};

enum hil_pin_mode { HIL_PIN_INPUT, HIL_PIN_OUTPUT, HIL_PIN_ALTERNATE, HIL_PIN_ANALOGUE };

void hil_gpio_reset_port(struct hil_board *board, unsigned port);
enum hil_pin_mode hil_gpio_mode(const struct hil_board *board, unsigned port, unsigned pin);
/* Alternate function number of a pin in alternate mode, -1 in any other. */
int hil_gpio_alternate(const struct hil_board *board, unsigned port, unsigned pin);
bool hil_gpio_level(const struct hil_board *board, unsigned port, unsigned pin);
/* A driver outside changes its level. */
void hil_gpio_drive(struct hil_board *board, unsigned port, unsigned pin, bool level, uint64_t at);
/* Something that pins depend on changed at cycle `at` (ODR, mode, a timer's output): tell those who watch. */
void hil_gpio_changed(struct hil_board *board, uint64_t at);
/* The same of the pins that TIM4 can drive, which are those of the excitation. */
void hil_gpio_excitation_changed(struct hil_board *board, uint64_t at);

uint32_t hil_gpio_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_gpio_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);

#endif
