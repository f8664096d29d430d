#include "hil/core/bootrom.h"

/* Built from hil/rom by the Makefile before this file is compiled. */
__asm__(".section .rodata\n"
        ".balign 4096\n"
        ".global hil_bootrom_image\n"
        "hil_bootrom_image:\n"
        ".incbin \"bootrom.bin\"\n"
        ".previous\n");
