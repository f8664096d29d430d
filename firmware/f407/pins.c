/* Pins: which does what. Port modes: 0 input, 1 output, 2 alternate function, 3 analogue. RM0090
 * 8.3. */
#include "firmware/f407/drivers.h"

static void set_mode(struct gpio_regs *port, unsigned pin, uint32_t mode)
{
    port->MODER = (port->MODER & ~(3u << (2 * pin))) | mode << (2 * pin);
}

/* 6 ns of slew into 40 pF; at speed 0 it may be 100. STM32F407 data sheet, I/O AC
 * characteristics. */
static void set_fast(struct gpio_regs *port, unsigned pin)
{
    port->OSPEEDR |= 2u << (2 * pin);
}

static void set_function(struct gpio_regs *port, unsigned pin, uint32_t function)
{
    unsigned shift = 4 * (pin % 8);
    port->AFR[pin / 8] = (port->AFR[pin / 8] & ~(15u << shift)) | function << shift;
    set_fast(port, pin);
    set_mode(port, pin, 2);
}

static void set_analogue(struct gpio_regs *port, unsigned first, unsigned last)
{
    for (unsigned pin = first; pin <= last; pin++)
        set_mode(port, pin, 3);
}

static void pull_up(struct gpio_regs *port, unsigned pin)
{
    port->PUPDR = (port->PUPDR & ~(3u << (2 * pin))) | 1u << (2 * pin);
}

void pins_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1ENR_GPIO_A_TO_F | RCC_AHB1ENR_DMA1 | RCC_AHB1ENR_DMA2;
    RCC->APB1ENR |= RCC_APB1ENR_TIM2 | RCC_APB1ENR_TIM4 | RCC_APB1ENR_SPI2 | RCC_APB1ENR_CAN1;
    RCC->APB2ENR |= RCC_APB2ENR_USART1 | RCC_APB2ENR_ADC1 | RCC_APB2ENR_ADC3;
    (void)RCC->APB2ENR;

    set_analogue(GPIOA, 0, 7);
    set_analogue(GPIOB, 0, 1);
    set_analogue(GPIOC, 0, 5);
    set_analogue(GPIOF, 3, 10);
    set_function(GPIOA, 9, 7);  /* USART1_TX */
    set_function(GPIOA, 10, 7); /* USART1_RX */
    pull_up(GPIOA, 10);
    set_function(GPIOA, 15, 1); /* TIM2_CH1, switch edges */
    GPIOB->BSRR = 1u << 12;     /* the memory is not selected */
    set_fast(GPIOB, 12);
    set_mode(GPIOB, 12, 1);
    set_function(GPIOB, 13, 5); /* SPI2_SCK */
    set_function(GPIOB, 14, 5); /* SPI2_MISO */
    pull_up(GPIOB, 14);         /* or a memory that is not there reads as anything */
    set_function(GPIOB, 15, 5); /* SPI2_MOSI */
    set_function(GPIOD, 0, 9);  /* CAN1_RX */
    set_function(GPIOD, 1, 9);  /* CAN1_TX */
    pull_up(GPIOD, 0);
    set_function(GPIOD, 12, 2); /* TIM4_CH1, excitation */
    set_function(GPIOD, 13, 2); /* TIM4_CH2, excitation in antiphase */
    set_function(GPIOB, 3, 1);  /* TIM2_CH2, frame pulses of the camera */
    set_mode(GPIOE, 0, 1);      /* warning output, low warns */
    set_mode(GPIOE, 1, 1);      /* relay of the bridges' shunts, high: on */
    set_mode(GPIOE, 2, 1);      /* camera trigger, high pulse */
    pull_up(GPIOE, 3);          /* lamp readback, low while it draws current */
}

void pins_i2c(enum pins_i2c way)
{
    for (unsigned pin = 6; pin <= 7; pin++) { /* I2C1_SCL, I2C1_SDA */
        GPIOB->OTYPER |= 1u << pin;
        if (way == PINS_I2C_BUS)
            set_function(GPIOB, pin, 4);
        else
            set_mode(GPIOB, pin, way == PINS_I2C_CLOCKED);
    }
}
