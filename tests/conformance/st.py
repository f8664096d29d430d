#!/usr/bin/env python3
"""ST's register header against the drivers' names: writes tests/conformance/st.txt, the values alone.

    tests/conformance/st.py STM32F407XX.H >tests/conformance/st.txt

The header is Include/stm32f407xx.h of github.com/STMicroelectronics/cmsis_device_f4; nothing of its text is kept. Names of the core (SCB, NVIC,
SysTick, DWT) are not in it. Where the drivers have another name, the second column of ALIAS says which of ST's it is."""
import os, re, subprocess, sys, tempfile

ALIAS = """
ADC_CCR &ADC123_COMMON->CCR|PWR_CR &PWR->CR|SYSCFG_MEMRMP &SYSCFG->MEMRMP|DBGMCU_APB1_FZ &DBGMCU->APB1FZ|DBGMCU_IDCODE &DBGMCU->IDCODE
FLASH_ACR &FLASH->ACR|FLASH_CR &FLASH->CR|FLASH_KEYR &FLASH->KEYR|FLASH_OPTCR &FLASH->OPTCR|FLASH_OPTKEYR &FLASH->OPTKEYR|FLASH_SR &FLASH->SR
ADC_CCR_PRESCALER_4 ADC_CCR_ADCPRE_0|ADC_CR2_EXTEN_RISING ADC_CR2_EXTEN_0|ADC_CR2_EXTSEL_TIM4_CC4 ADC_CR2_EXTSEL_0|ADC_CR2_EXTSEL_3
ADC_SMP_112 ADC_SMPR2_SMP0_0+ADC_SMPR2_SMP0_2|CAN_RF0R_FMP CAN_RF0R_FMP0|CAN_RF0R_FOVR CAN_RF0R_FOVR0|CAN_RF0R_RFOM CAN_RF0R_RFOM0
CAN_TIR_TXRQ CAN_TI0R_TXRQ|DMA_CR_MEM_TO_PERIPHERAL DMA_SxCR_DIR_0|DMA_CR_MSIZE_16 DMA_SxCR_MSIZE_0|DMA_CR_MSIZE_32 DMA_SxCR_MSIZE_1
DMA_CR_PSIZE_16 DMA_SxCR_PSIZE_0|DMA_CR_PSIZE_32 DMA_SxCR_PSIZE_1|DMA_FLAG_HTIF DMA_LISR_HTIF0|DMA_FLAG_TCIF DMA_LISR_TCIF0
DMA_FLAG_TEIF DMA_LISR_TEIF0|DMA_FLAGS_ALL DMA_LIFCR_CFEIF0+DMA_LIFCR_CDMEIF0+DMA_LIFCR_CTEIF0+DMA_LIFCR_CHTIF0+DMA_LIFCR_CTCIF0
FLASH_ACR_168MHZ FLASH_ACR_LATENCY_5WS+FLASH_ACR_PRFTEN+FLASH_ACR_ICEN+FLASH_ACR_DCEN|FLASH_CR_PSIZE_32 FLASH_CR_PSIZE_1
RCC_CFGR_SWS_MASK RCC_CFGR_SWS|RCC_CFGR_SW_MASK RCC_CFGR_SW|RCC_PLLCFGR_SRC_HSE RCC_PLLCFGR_PLLSRC_HSE|TIM11_OR_HSE_RTC TIM_OR_TI1_RMP_1
TIM_CCMR1_CC1_TI1 TIM_CCMR1_CC1S_0|TIM_CCMR1_IC1F_8 TIM_CCMR1_IC1F_0+TIM_CCMR1_IC1F_1
TIM_CCMR1_IC1PSC_8 TIM_CCMR1_IC1PSC|TIM_CCMR1_IC1F_256 TIM_CCMR1_IC1F|TIM_CR2_MMS_ENABLE TIM_CR2_MMS_0|TIM_SMCR_SMS_TRIGGER TIM_SMCR_SMS_1+TIM_SMCR_SMS_2
TIM_SMCR_TS_ITR3 TIM_SMCR_TS_0+TIM_SMCR_TS_1|TIM_OCM_FORCE_HIGH (TIM_CCMR1_OC1M_0+TIM_CCMR1_OC1M_2)>>4|TIM_OCM_FORCE_LOW TIM_CCMR1_OC1M_2>>4
TIM_OCM_PWM2 TIM_CCMR1_OC1M>>4|TIM_OCM_TOGGLE (TIM_CCMR1_OC1M_0+TIM_CCMR1_OC1M_1)>>4|UID UID_BASE
can_regs.RF0R RF0R|dma_regs.ISR LISR|dma_regs.IFCR LIFCR|tim_regs.CCR CCR1|adc_regs.JDR JDR1|adc_regs.JOFR JOFR1|can_regs.tx sTxMailBox|can_regs.rx sFIFOMailBox|can_regs.filter sFilterRegister
"""
alias = {}
for entry in re.split(r"\||\n", ALIAS.replace("ADC_CR2_EXTSEL_0|", "ADC_CR2_EXTSEL_0+")):
    if entry:
        name, what = entry.split(" ", 1)
        alias[name] = what
TYPES = {"tim11": "TIM", "dma_stream": "DMA_Stream", "can_tx": "CAN_TxMailBox", "can_rx": "CAN_FIFOMailBox"}


def expression(kind, name, st):
    """What of ST's it is, with its kind in the table."""
    if kind == "FIELD":
        of, field = name.split(", ")
        of = re.sub("_regs$", "", of)
        return "offset", "%s.%s" % (of.upper(), field), "offsetof(%s_TypeDef, %s)" % (TYPES.get(of, of.upper()), alias.get("%s_regs.%s" % (of, field), field + "1" if of == "tim11" and field in ("CCMR", "CCR") else field))
    if kind == "IRQ":
        short = name[4:]
        return "irq", short, re.sub("STREAM", "Stream", short) + "_IRQn"
    if name in alias:
        return ("base" if alias[name][0] == "&" else "bits"), name, alias[name]
    if name + "_BASE" in st:
        return "base", name, name + "_BASE"
    for guess in (name, name + "EN", name.replace("DMA_CR_", "DMA_SxCR_")):
        if guess in st:
            return "bits", name, guess
    return None


def main():
    header = os.path.abspath(sys.argv[1])
    here = os.path.dirname(os.path.abspath(__file__))
    names = subprocess.run(["awk", "-f", here + "/registers.awk", here + "/../../firmware/f407/regs.h"], capture_output=True, text=True, check=True).stdout
    st = set(re.findall(r"^#define\s+(\w+)", open(header, errors="replace").read(), re.M))
    rows = []
    for kind, name in re.findall(r"(\w+)\((.*)\)", names):
        found = expression(kind, name, st) if kind != "MACRO" else None
        if found and found not in rows:
            rows.append(found)
    with tempfile.TemporaryDirectory() as folder:
        open(folder + "/core_cm4.h", "w").write("#define __IO volatile\n#define __I volatile const\n#define __O volatile\n")
        open(folder + "/system_stm32f4xx.h", "w").close()
        while True:
            with open(folder + "/st.c", "w") as c:
                c.write('#include <stdint.h>\n#include <stddef.h>\n#include <stdio.h>\n#include "%s"\nint main(void)\n{\n' % header)
                for i, (kind, name, what) in enumerate(rows):
                    c.write('#line %d "row"\nprintf("%s %s 0x%%x\\n", (unsigned)(uintptr_t)(%s));\n' % (i + 1, kind, name.replace(".", " "), what))
                c.write("return 0;\n}\n")
            done = subprocess.run(["gcc", "-w", "-I" + folder, folder + "/st.c", "-o", folder + "/st"], capture_output=True, text=True)
            wrong = sorted({int(n) for n in re.findall(r"^row:(\d+):\d+: error", done.stderr, re.M)}, reverse=True)
            if not wrong:
                break
            for n in wrong:  # ST has no such register
                print("not ST's: %s %s" % rows.pop(n - 1)[:2], file=sys.stderr)
        if done.returncode:
            sys.exit(done.stderr)
        print("# Values of ST's stm32f407xx.h by the drivers' names; made by tests/conformance/st.py.\n")
        sys.stdout.write(subprocess.run([folder + "/st"], capture_output=True, text=True, check=True).stdout)


main()
