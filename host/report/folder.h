/* A report as a folder: index.html, the front, and runN.html for each landing. No page needs
 * anything outside the folder. A page is made anew when what it rests on changed (store_digest.h,
 * the film's pictures, the pages beside it, the options, the program); each appears whole. */
#ifndef MATRIG_HOST_REPORT_FOLDER_H
#define MATRIG_HOST_REPORT_FOLDER_H

#include "host/report/report.h"

/* How many pages of landings were made anew, were left, and were taken away because their landing
 * is no longer in the report. */
struct folder_made {
    size_t made, left, removed;
};

/* `path` is meant as a folder: it ends in / or is one. */
bool folder_meant(const char *path);
/* Of a report that report_begin has begun, with `folder` set. Makes the folder where there is none.
 * MR_USAGE before anything is written when a page would take the place of a file that matrig did
 * not write there, unless `force` is set. */
enum mr_status folder_write(struct report *report, const char *path, bool force,
                            struct folder_made *made, struct error *error);

#endif
