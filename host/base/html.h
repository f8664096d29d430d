/* Text output for HTML pages. */
#ifndef MATRIG_HOST_BASE_HTML_H
#define MATRIG_HOST_BASE_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Writes text with <, >, & and quotes escaped. */
void html_write_text(FILE *out, const char *text);
void html_write_bytes(FILE *out, const char *text, size_t length);
/* Writes bytes as base64. */
void html_write_base64(FILE *out, const unsigned char *bytes, size_t count);

#endif
