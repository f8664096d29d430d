/* The unique identifier of the chip shows whether a record is from an emulated board or from
 * hardware. Bytes 1 to 7 of words 1 and 2 are the lot in ASCII (RM0090 39.1); the lot of an
 * emulated chip begins with "EMU". */
#ifndef MATRIG_COMMON_EMULATED_H
#define MATRIG_COMMON_EMULATED_H

#define MR_EMULATED_LOT      0x554d45u /* "EMU" in ASCII, in the upper 24 bits of word 1 */
/* this lot as digits 9 to 14 of the identifier's 24 hexadecimal digits */
#define MR_EMULATED_LOT_TEXT "554D45"

#endif
