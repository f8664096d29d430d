/* Tells of a fault that fired, or of a frame or byte that suffered one: a line with its virtual
 * time to hil_options.log and to the trace, and a count. */
#ifndef MATRIG_HIL_FAULT_LOG_H
#define MATRIG_HIL_FAULT_LOG_H

#include <stdio.h>

struct hil_core;

/* `log` NULL: nobody reads it. `file_line` of the fault file that ordered it; 0: none. */
__attribute__((format(printf, 4, 5))) void hil_fault_tell(struct hil_core *core, FILE *log,
                                                          unsigned file_line, const char *format,
                                                          ...);

#endif
