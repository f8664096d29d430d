/* What happened to a board since it was created. The counts survive resets of the chip. */
#ifndef MATRIG_HIL_COUNTERS_H
#define MATRIG_HIL_COUNTERS_H

#include <stdint.h>

struct hil_counters {
    uint64_t instructions;
    uint64_t asleep_cycles; /* HCLK cycles spent in WFI or WFE */
    uint64_t exceptions;    /* entries, tail-chained ones included */
    uint64_t tail_chains;
    uint64_t faults; /* MemManage, BusFault, UsageFault, HardFault entries */
    uint64_t resets; /* all but power on */
    uint64_t watchdog_resets;
    uint64_t can_frames_out;
    uint64_t can_frames_in;
    uint64_t can_frames_filtered; /* of those in: no filter let them pass */
    uint64_t can_errors;          /* frames that were not acknowledged or were destroyed */
    uint64_t can_ends_unseen;     /* a mailbox filled again before its RQCP was cleared */
    uint64_t can_in_dropped;      /* injected while the queue of the other side was full */
    uint64_t serial_bytes_out;
    uint64_t serial_bytes_in;
    /* bytes sent at a rate or parity that is not the other end's: garbled */
    uint64_t serial_wrong_rate;
    uint64_t serial_in_dropped;    /* injected while the queue was full */
    uint64_t adc_scans[2];         /* sequences completed: ADC1, ADC3 */
    uint64_t adc_triggers_ignored; /* came while a sequence was running */
    uint64_t adc_overruns;
    uint64_t switches_opened;
    uint64_t edges_captured;  /* TIM2 channel 1 */
    uint64_t frames_captured; /* TIM2 channel 2 */
    uint64_t film_frames;     /* pulses the camera gave */
    /* time with PD12 high and PD13 low; no direct component: plus equals minus */
    uint64_t excitation_plus_ps;
    uint64_t excitation_minus_ps;
    uint64_t faults_injected;    /* lines told of hil/rig/faults.h */
    uint64_t flash_refused;      /* stores and operations that set an error flag, wrong keys */
    uint64_t flash_stall_cycles; /* HCLK cycles for which the core waited for flash */
    uint64_t power_cuts;
    uint32_t last_fault_pc;
};

#endif
