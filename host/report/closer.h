/* The script of a page that looks closer at its plots (closer.js), and what a page may load. */
#ifndef MATRIG_HOST_REPORT_CLOSER_H
#define MATRIG_HOST_REPORT_CLOSER_H

#include <stdio.h>

/* <meta>, for <head>: nothing from elsewhere, no script but the one that closer_write writes. */
void closer_policy(FILE *out);

/* <script>, at the end of <body>. */
void closer_write(FILE *out);

#endif
