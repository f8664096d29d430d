/* Registers of the STM32F407 that the firmware uses, from RM0090 (peripherals) and PM0214
 * (core). */
#ifndef MATRIG_FIRMWARE_F407_REGS_H
#define MATRIG_FIRMWARE_F407_REGS_H

#include <stdint.h>

typedef volatile uint32_t reg32;

/* RM0090 7.3: reset and clock control */
struct rcc_regs {
    reg32 CR, PLLCFGR, CFGR, CIR, AHB1RSTR, AHB2RSTR, AHB3RSTR, reserved0, APB1RSTR, APB2RSTR,
        reserved1[2];
    reg32 AHB1ENR, AHB2ENR, AHB3ENR, reserved2, APB1ENR, APB2ENR, reserved3[2];
    reg32 AHB1LPENR, AHB2LPENR, AHB3LPENR, reserved4, APB1LPENR, APB2LPENR, reserved5[2], BDCR, CSR;
};
#define RCC                  ((struct rcc_regs *)0x40023800u)
#define RCC_CR_HSION         (1u << 0)
#define RCC_CR_HSIRDY        (1u << 1)
#define RCC_CR_HSEON         (1u << 16)
#define RCC_CR_HSERDY        (1u << 17)
#define RCC_CR_HSEBYP        (1u << 18)
#define RCC_CR_CSSON         (1u << 19)
#define RCC_CR_PLLON         (1u << 24)
#define RCC_CR_PLLRDY        (1u << 25)
#define RCC_CIR_CSSF         (1u << 7)
#define RCC_PLLCFGR_SRC_HSE  (1u << 22)
#define RCC_PLLCFGR_RESERVED (2u << 28) /* reserved bits, which must keep their reset value */
#define RCC_CFGR_SW_MASK     3u
#define RCC_CFGR_SW_PLL      2u
#define RCC_CFGR_SWS_MASK    (3u << 2)
#define RCC_CFGR_SWS_PLL     (2u << 2)
#define RCC_CFGR_RTCPRE(by)  ((uint32_t)(by) << 16)
#define RCC_CFGR_PPRE1_DIV4  (5u << 10)
#define RCC_CFGR_PPRE2_DIV2  (4u << 13)
#define RCC_AHB1ENR_DMA1     (1u << 21)
#define RCC_AHB1ENR_DMA2     (1u << 22)
#define RCC_APB1ENR_TIM2     (1u << 0)
#define RCC_APB1ENR_TIM4     (1u << 2)
#define RCC_APB1ENR_SPI2     (1u << 14)
#define RCC_APB1ENR_I2C1     (1u << 21)
#define RCC_APB1ENR_CAN1     (1u << 25)
#define RCC_APB1ENR_PWR      (1u << 28)
#define RCC_APB2ENR_USART1   (1u << 4)
#define RCC_APB2ENR_USART6   (1u << 5)
#define RCC_APB2ENR_ADC1     (1u << 8)
#define RCC_APB2ENR_ADC3     (1u << 10)
#define RCC_APB2ENR_TIM11    (1u << 18)
#define RCC_APB2ENR_SYSCFG   (1u << 14)
#define RCC_CSR_RMVF         (1u << 24)
#define RCC_CSR_BORRSTF      (1u << 25)
#define RCC_CSR_PINRSTF      (1u << 26)
#define RCC_CSR_PORRSTF      (1u << 27)
#define RCC_CSR_SFTRSTF      (1u << 28)
#define RCC_CSR_IWDGRSTF     (1u << 29)
#define RCC_CSR_LPWRRSTF     (1u << 31)

/* RM0090 3.9: flash interface; 5.4: power control */
#define FLASH_ACR         (*(reg32 *)0x40023c00u)
/* 5 wait states, prefetch, both caches */
#define FLASH_ACR_168MHZ  (5u | 1u << 8 | 1u << 9 | 1u << 10)
#define FLASH_ACR_LATENCY 7u
#define FLASH_ACR_DCEN    (1u << 10)
#define FLASH_ACR_DCRST   (1u << 12)
#define FLASH_KEYR        (*(reg32 *)0x40023c04u)
#define FLASH_OPTKEYR     (*(reg32 *)0x40023c08u)
#define FLASH_SR          (*(reg32 *)0x40023c0cu)
#define FLASH_SR_ERRORS   0xf2u /* PGSERR, PGPERR, PGAERR, WRPERR, OPERR; a one clears it */
#define FLASH_SR_BSY      (1u << 16)
#define FLASH_CR          (*(reg32 *)0x40023c10u)
#define FLASH_CR_PG       (1u << 0)
#define FLASH_CR_SER      (1u << 1)
#define FLASH_CR_PSIZE_32 (2u << 8)
#define FLASH_CR_STRT     (1u << 16)
#define FLASH_CR_LOCK     (1u << 31)
#define FLASH_OPTCR       (*(reg32 *)0x40023c14u)
#define PWR_CR            (*(reg32 *)0x40007000u)
#define PWR_CR_VOS        (1u << 14)

/* RM0090 9.2.1: selects the memory at address 0 */
#define SYSCFG_MEMRMP            (*(reg32 *)0x40013800u)
#define SYSCFG_MEMRMP_MEM_MODE_0 1u

/* RM0090 8.4 */
struct gpio_regs {
    reg32 MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
};
#define GPIOA ((struct gpio_regs *)0x40020000u)
#define GPIOB ((struct gpio_regs *)0x40020400u)
#define GPIOC ((struct gpio_regs *)0x40020800u)
#define GPIOD ((struct gpio_regs *)0x40020c00u)
#define GPIOE ((struct gpio_regs *)0x40021000u)
#define GPIOF ((struct gpio_regs *)0x40021400u)
#define GPIOG ((struct gpio_regs *)0x40021800u)

/* RM0090 10.5 */
struct dma_stream_regs {
    reg32 CR, NDTR, PAR, M0AR, M1AR, FCR;
};
struct dma_regs {
    reg32 ISR[2], IFCR[2];
    struct dma_stream_regs stream[8];
};
#define DMA1                     ((struct dma_regs *)0x40026000u)
#define DMA2                     ((struct dma_regs *)0x40026400u)
#define DMA_CR_EN                (1u << 0)
#define DMA_CR_TEIE              (1u << 2)
#define DMA_CR_HTIE              (1u << 3)
#define DMA_CR_TCIE              (1u << 4)
#define DMA_CR_MEM_TO_PERIPHERAL (1u << 6)
#define DMA_CR_CIRC              (1u << 8)
#define DMA_CR_MINC              (1u << 10)
#define DMA_CR_PSIZE_16          (1u << 11)
#define DMA_CR_PSIZE_32          (2u << 11)
#define DMA_CR_MSIZE_16          (1u << 13)
#define DMA_CR_MSIZE_32          (2u << 13)
#define DMA_CR_PRIORITY(p)       ((uint32_t)(p) << 16)
#define DMA_CR_CHANNEL(c)        ((uint32_t)(c) << 25)
/* Flags of a stream: six bits at 0, 6, 16, 22 of ISR[stream / 4] */
#define DMA_FLAG_TEIF            0x08u
#define DMA_FLAG_HTIF            0x10u
#define DMA_FLAG_TCIF            0x20u
#define DMA_FLAGS_ALL            0x3du

/* RM0090 18.4 */
struct tim_regs {
    reg32 CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, reserved0, CCR[4];
};
#define TIM2                 ((struct tim_regs *)0x40000000u)
#define TIM4                 ((struct tim_regs *)0x40000800u)
#define TIM_CR1_CEN          (1u << 0)
#define TIM_CR2_MMS_ENABLE   (1u << 4)
#define TIM_SMCR_TS_ITR3     (3u << 4)
#define TIM_SMCR_SMS_TRIGGER 6u
#define TIM_DIER_CC1DE       (1u << 9)
#define TIM_SR_CC1IF         (1u << 1)
#define TIM_SR_CC1OF         (1u << 9)
#define TIM_CCMR1_CC1_TI1    (1u << 0)
#define TIM_CCMR1_IC1F_8     (3u << 4) /* eight samples of 84 MHz */
#define TIM_CCMR1_IC1PSC_8   (3u << 2)
#define TIM_CCER_CC1E        (1u << 0)
#define TIM_CCMR1_IC1F_256   (15u << 4) /* eight samples of a clock of 84 MHz / 32 */
#define TIM_EGR_UG           1u
#define TIM_OCM_FORCE_LOW    4u
#define TIM_OCM_FORCE_HIGH   5u
#define TIM_OCM_TOGGLE       3u
#define TIM_OCM_PWM2         7u

/* RM0090 19.5: one channel; bits as for struct tim_regs */
struct tim11_regs {
    reg32 CR1, reserved0[3], SR, reserved1, CCMR1, reserved2, CCER, reserved3[4], CCR1,
        reserved4[6], OR;
};
#define TIM11            ((struct tim11_regs *)0x40014800u)
#define TIM11_OR_HSE_RTC 2u

/* RM0090 13.13 */
struct adc_regs {
    reg32 SR, CR1, CR2, SMPR1, SMPR2, JOFR[4], HTR, LTR, SQR1, SQR2, SQR3, JSQR, JDR[4], DR;
};
#define ADC1                    ((struct adc_regs *)0x40012000u)
#define ADC3                    ((struct adc_regs *)0x40012200u)
#define ADC_CCR                 (*(reg32 *)0x40012304u)
#define ADC_CCR_PRESCALER_4     (1u << 16)
#define ADC_SR_OVR              (1u << 5)
#define ADC_CR1_SCAN            (1u << 8)
#define ADC_CR1_OVRIE           (1u << 26)
#define ADC_CR2_ADON            (1u << 0)
#define ADC_CR2_DMA             (1u << 8)
#define ADC_CR2_DDS             (1u << 9)
#define ADC_CR2_EXTSEL_TIM4_CC4 (9u << 24)
#define ADC_CR2_EXTEN_RISING    (1u << 28)
#define ADC_SMP_112             5u

/* RM0090 32.9 */
struct can_regs {
    reg32 MCR, MSR, TSR, RF0R, RF1R, IER, ESR, BTR, reserved0[88];
    struct {
        reg32 TIR, TDTR, TDLR, TDHR;
    } tx[3];
    struct {
        reg32 RIR, RDTR, RDLR, RDHR;
    } rx[2];
    reg32 reserved1[12], FMR, FM1R, reserved2, FS1R, reserved3, FFA1R, reserved4, FA1R,
        reserved5[8];
    reg32 filter[28][2];
};
#define CAN1            ((struct can_regs *)0x40006400u)
#define CAN_MCR_INRQ    (1u << 0)
#define CAN_MCR_TXFP    (1u << 2)
#define CAN_MSR_INAK    (1u << 0)
#define CAN_TSR_RQCP(m) (1u << (8u * (m)))
#define CAN_TSR_TXOK(m) (2u << (8u * (m)))
#define CAN_TSR_ABRQ(m) (0x80u << (8u * (m)))
#define CAN_TSR_TME(m)  (1u << (26u + (m)))
#define CAN_RF0R_FMP    3u
#define CAN_RF0R_FOVR   (1u << 4)
#define CAN_RF0R_RFOM   (1u << 5)
#define CAN_IER_TMEIE   (1u << 0)
#define CAN_IER_FMPIE0  (1u << 1)
#define CAN_ESR_EPVF    (1u << 1)
#define CAN_ESR_BOFF    (1u << 2)
#define CAN_TIR_TXRQ    (1u << 0)
#define CAN_FMR_FINIT   (1u << 0)
#define CAN_BTR_LBKM    (1u << 30)
#define CAN_BTR_SILM    (1u << 31)

/* RM0090 30.6 */
struct usart_regs {
    reg32 SR, DR, BRR, CR1, CR2, CR3, GTPR;
};
#define USART1         ((struct usart_regs *)0x40011000u)
#define USART6         ((struct usart_regs *)0x40011400u)
#define USART_CR1_RE   (1u << 2)
#define USART_CR1_TE   (1u << 3)
#define USART_CR1_UE   (1u << 13)
#define USART_CR3_DMAR (1u << 6)
#define USART_CR3_DMAT (1u << 7)

/* RM0090 28.5 */
struct spi_regs {
    reg32 CR1, CR2, SR, DR;
};
#define SPI2            ((struct spi_regs *)0x40003800u)
#define SPI_CR1_MSTR    (1u << 2)
#define SPI_CR1_SPE     (1u << 6)
#define SPI_CR1_SSI     (1u << 8)
#define SPI_CR1_SSM     (1u << 9)
#define SPI_CR2_RXDMAEN (1u << 0)
#define SPI_CR2_TXDMAEN (1u << 1)
#define SPI_SR_RXNE     (1u << 0)
#define SPI_SR_BSY      (1u << 7)

/* RM0090 27.6 */
struct i2c_regs {
    reg32 CR1, CR2, OAR1, OAR2, DR, SR1, SR2, CCR, TRISE;
};
#define I2C1          ((struct i2c_regs *)0x40005400u)
#define I2C_CR1_PE    (1u << 0)
#define I2C_CR1_START (1u << 8)
#define I2C_CR1_STOP  (1u << 9)
#define I2C_CR1_ACK   (1u << 10)
#define I2C_CR1_POS   (1u << 11)
#define I2C_CR1_SWRST (1u << 15)
#define I2C_SR1_SB    (1u << 0)
#define I2C_SR1_ADDR  (1u << 1)
#define I2C_SR1_BTF   (1u << 2)
#define I2C_SR1_BERR  (1u << 8)
#define I2C_SR1_ARLO  (1u << 9)
#define I2C_SR1_AF    (1u << 10)
#define I2C_SR2_BUSY  (1u << 1)

/* RM0090 21.4 */
struct iwdg_regs {
    reg32 KR, PR, RLR, SR;
};
#define IWDG ((struct iwdg_regs *)0x40003000u)

/* unique identifier (RM0090 39.1) */
#define UID ((const volatile uint32_t *)0x1fff7a10u)

/* RM0090 38.6.1: device and revision */
#define DBGMCU_IDCODE                (*(reg32 *)0xe0042000u)
/* RM0090 38.16: clocks that stop while a debugger halts the core */
#define DBGMCU_APB1_FZ               (*(reg32 *)0xe0042008u)
#define DBGMCU_APB1_FZ_DBG_TIM2_STOP (1u << 0)
#define DBGMCU_APB1_FZ_DBG_TIM4_STOP (1u << 2)
#define DBGMCU_APB1_FZ_DBG_IWDG_STOP (1u << 12)

/* PM0214 4.3 to 4.5 */
#define SYST_CSR           (*(reg32 *)0xe000e010u)
#define SYST_RVR           (*(reg32 *)0xe000e014u)
#define SYST_CVR           (*(reg32 *)0xe000e018u)
#define NVIC_ISER          ((reg32 *)0xe000e100u)
#define NVIC_ICER          ((reg32 *)0xe000e180u)
#define NVIC_ICPR          ((reg32 *)0xe000e280u)
#define NVIC_IPR           ((volatile uint8_t *)0xe000e400u)
#define SCB_CPUID          (*(reg32 *)0xe000ed00u)
#define NVIC_WORDS         3u /* 82 interrupts */
#define SCB_ICSR           (*(reg32 *)0xe000ed04u)
#define SCB_ICSR_PENDSTCLR (1u << 25)
#define SCB_ICSR_PENDSVCLR (1u << 27)
#define SCB_VTOR           (*(reg32 *)0xe000ed08u)
#define SCB_AIRCR          (*(reg32 *)0xe000ed0cu)
#define SCB_SHPR           ((volatile uint8_t *)0xe000ed18u)
#define SCB_CFSR           (*(reg32 *)0xe000ed28u)
#define SCB_HFSR           (*(reg32 *)0xe000ed2cu)
#define SCB_MMFAR          (*(reg32 *)0xe000ed34u)
#define SCB_BFAR           (*(reg32 *)0xe000ed38u)
#define SCB_CPACR          (*(reg32 *)0xe000ed88u)

/* ARMv7-M C1.6.5, C1.8: the core's cycle counter */
#define SCB_DEMCR          (*(reg32 *)0xe000edfcu)
#define SCB_DEMCR_TRCENA   (1u << 24)
#define DWT_CTRL           (*(reg32 *)0xe0001000u)
#define DWT_CTRL_CYCCNTENA (1u << 0)
#define DWT_CYCCNT         (*(reg32 *)0xe0001004u)

enum irq_number {
    IRQ_DMA1_STREAM3 = 14,
    IRQ_ADC = 18,
    IRQ_CAN1_TX = 19,
    IRQ_CAN1_RX0 = 20,
    IRQ_DMA2_STREAM1 = 57,
    IRQ_DMA2_STREAM4 = 60,
    IRQ_DMA2_STREAM7 = 70,
};

/* Priorities, 0 (most urgent) to 15. A scan block must be checked within 36 us (scan.c) and summed
 * before its half of the buffer is overwritten (1 ms). The CAN interrupt fills a mailbox with the
 * next frame; until then the mailbox is idle. */
enum irq_priority {
    PRIORITY_SCAN = 2,
    PRIORITY_CAN = 4,
    PRIORITY_SERIAL = 6,
    PRIORITY_SUPERVISION = 14
};

static inline void irq_enable(enum irq_number irq, enum irq_priority priority)
{
    NVIC_IPR[irq] = (uint8_t)(priority << 4);
    NVIC_ISER[irq / 32] = 1u << (irq % 32);
}

/* Masks all interrupts and returns the state for irq_restore. */
static inline uint32_t irq_mask(void)
{
    uint32_t primask;
    __asm volatile("mrs %0, primask\n\tcpsid i" : "=r"(primask)::"memory");
    return primask;
}

static inline void irq_restore(uint32_t primask)
{
    __asm volatile("msr primask, %0" ::"r"(primask) : "memory");
}

/* Call at the end of each interrupt handler. It waits until the peripheral has received the
 * clearing of its flag; otherwise the interrupt would occur again. */
static inline void irq_end(void)
{
    __asm volatile("dsb" ::: "memory");
}

/* Use between a store and the register write that hands the data to an interrupt or DMA: neither
 * the compiler nor the bus moves loads and stores past the fence. */
static inline void memory_fence(void)
{
    __asm volatile("dmb" ::: "memory");
}

/* Shift of a stream's flags in ISR[stream / 4] and IFCR[stream / 4]. */
static inline unsigned dma_flag_shift(unsigned stream)
{
    static const uint8_t shift[4] = {0, 6, 16, 22};
    return shift[stream % 4];
}

/* Starts a stream after the fence, so that the content of its buffer is in memory first. */
static inline void dma_stream_start(struct dma_stream_regs *stream, uint32_t settings)
{
    memory_fence();
    stream->CR = settings | DMA_CR_EN;
}

/* Stops a stream: waits for the transfer in progress and clears the flags (RM0090 10.3.17). */
static inline void dma_stream_stop(struct dma_regs *dma, unsigned number)
{
    dma->stream[number].CR = 0;
    for (unsigned polls = 0; (dma->stream[number].CR & DMA_CR_EN) && polls < 1000; polls++) {
    }
    dma->IFCR[number / 4] = DMA_FLAGS_ALL << dma_flag_shift(number);
}

#endif
