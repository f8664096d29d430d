/* Text and tables of a page. */
#ifndef MATRIG_HOST_BASE_HTML_H
#define MATRIG_HOST_BASE_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Text with <, >, & and quotes escaped. */
void html_text(FILE *out, const char *text);
void html_bytes(FILE *out, const char *text, size_t length);
/* Bytes as base64. */
void html_base64(FILE *out, const unsigned char *bytes, size_t count);
/* A table cell: <td>, or <td class="n"> for numbers, with formatted and escaped text. */
void html_cell(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* A number with `decimals`, or an empty cell with a dash when it is not finite. */
void html_number(FILE *out, double value, int decimals);
/* value plus or minus error. */
void html_estimate(FILE *out, double value, double error, int decimals);
/* <table> with its head cells, NULL at the end of the list. */
void html_table(FILE *out, const char *const *heads);
/* A term and what it is, inside a <dl>. */
void html_fact(FILE *out, const char *term, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
