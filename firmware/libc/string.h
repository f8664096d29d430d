/* The part of <string.h> that the image uses; the functions are in libc.c. */
#ifndef MATRIG_FIRMWARE_LIBC_STRING_H
#define MATRIG_FIRMWARE_LIBC_STRING_H

#include <stddef.h>

int memcmp(const void *a, const void *b, size_t length);
void *memcpy(void *restrict to, const void *restrict from, size_t length);
void *memmove(void *to, const void *from, size_t length);
void *memset(void *to, int byte, size_t length);
int strcmp(const char *a, const char *b);
char *strncpy(char *restrict to, const char *restrict from, size_t length);

#endif
