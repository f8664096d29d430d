/* The crew's records of settings, inspections and notes, and a map of them over the runway. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/closure.h"
#include "host/analyse/inspection.h"
#include "host/analyse/rig.h"
#include "host/base/html.h"
#include "host/report/chart.h"
#include "host/report/report.h"

/* rows of the map, from the bottom up, by kind of record */
static const char *const map_row_names[] = {"subgrade", "mat", "damage"};
enum { MAP_ROW_SUBGRADE, MAP_ROW_MAT, MAP_ROW_DAMAGE, MAP_ROW_COUNT };

static const char *get_map_row_name(void *context, size_t i)
{
    (void)context;
    return map_row_names[i];
}

/* Draws a record on the map: damage over its length, a record of acceptance over one mat. */
static void draw_record(struct figure *figure, const struct inspection *entry, unsigned row)
{
    static const char *const verdicts[] = {NULL, "passed", "closed", "failed"};
    const char *repair = json_string_value(json_object_get(entry->values, "repair")),
               *shape = row == MAP_ROW_DAMAGE ? "damaged"
                                              : verdicts[inspection_check_limits(entry)];
    const double mat_ft = (double)MR_MAT_LENGTH_FT, y = row + 0.5;
    double from_ft = row == MAP_ROW_DAMAGE
                       ? inspection_get_number(entry->values, "station_ft").value
                   : row == MAP_ROW_MAT ? (entry->row.place - 1.0) * mat_ft
                                        : entry->row.place - 0.5 * mat_ft,
           to_ft = from_ft + fmax(mat_ft, inspection_get_number(entry->values, "length_ft").value);
    if (repair && strcmp(repair, "open") != 0)
        shape = "repaired";
    if (!shape || isnan(from_ft))
        return;
    const double tall = strcmp(shape, "passed") == 0 ? 0.2 : 0.4;
    figure_add_shape(figure, shape, from_ft, to_ft, y - tall, y + tall, NULL);
}

static void draw_map(const struct report *report, FILE *out)
{
    static const char *const keys[] = {
        "damaged", "damage", "repaired", "repaired",
        "failed",  "fail",   "closed",   "within its error of a limit",
        "passed",  "pass",   NULL};
    const struct inspections *all = &report->records;
    struct figure figure;
    bool has_begun = false;
    for (size_t i = 0; i < MAP_ROW_COUNT * all->count; i++) {
        const struct inspection *entry = &all->entry[i / MAP_ROW_COUNT];
        if (!inspection_is_valid(entry, NULL, 0) ||
            strcmp(entry->kind->name, map_row_names[i % MAP_ROW_COUNT]) != 0)
            continue;
        if (!has_begun) {
            figure = figure_begin(out, report->si, "damage and acceptance against station", 1,
                                  FIGURE_RANGE_PER_PLOT);
            figure_begin_plot(&figure, &(struct chart_axes){.x = "station",
                                                            .x_unit = UNIT_STATION,
                                                            .y_unit = UNIT_NUMBER,
                                                            .x_high = RIG_RUNWAY_FT,
                                                            .y_high = MAP_ROW_COUNT,
                                                            .height_px = 130,
                                                            .tick_name = get_map_row_name,
                                                            .tick_count = MAP_ROW_COUNT});
        }
        has_begun = true;
        draw_record(&figure, entry, (unsigned)(i % MAP_ROW_COUNT));
    }
    if (has_begun)
        figure_end(&figure, keys, "Valid records, by station.");
}

/* Writes tables of the kinds that belong to landing `run`; 0: to the runway. */
static void write_tables(const struct report *report, int64_t run, FILE *out)
{
    const struct inspections *all = &report->records;
    struct answer *answer = answer_new(report->si);
    for (const struct inspection_kind *kind = inspection_kinds; kind->name; kind++)
        if ((kind->place == INSPECTION_LANDING) == (run > 0))
            inspection_add_table(all, kind, run, 0, answer);
    if (all->count && run > 1)
        inspection_add_differences(report->store, all, true, run - 1, run, answer, report->error);
    report_write_answer(answer, out);
}

/* Shows the pictures of a landing. Large files would make the page slow; they are named. */
#define PICTURE_MB_MAX 2

static void write_pictures(const struct report *report, int64_t run, FILE *out)
{
    static unsigned char bytes[PICTURE_MB_MAX * 1000000 + 1];
    for (size_t i = 0; i < report->records.count; i++) {
        const struct inspection *entry = &report->records.entry[i];
        const char *name = json_string_value(json_object_get(entry->values, "file")),
                   *shows = json_string_value(json_object_get(entry->values, "shows"));
        struct error error = {0};
        if (!name || !inspection_is_valid(entry, NULL, run))
            continue;
        char *path = inspection_find_picture(&report->records, entry, &error);
        FILE *file = path ? fopen(path, "rb") : NULL;
        const size_t count = file ? fread(bytes, 1, sizeof bytes, file) : 0;
        if (count == sizeof bytes && fseek(file, 0, SEEK_END) == 0)
            error_set(&error, MR_LIMIT, "%s has %.1f MB, but the limit is %d MB", name,
                      1e-6 * (double)ftell(file), PICTURE_MB_MAX);
        fprintf(out, "<figure><figcaption>Record %lld: ", (long long)entry->row.id);
        html_write_text(out, shows ? shows : name);
        if (error.status != MR_OK) {
            fputs(" (not shown: ", out);
            html_write_text(out, error.text);
            fputs(")</figcaption></figure>\n", out);
        } else {
            fprintf(out,
                    "</figcaption><img alt=\"This browser cannot show the picture.\" "
                    "style=\"max-width:100%%\" src=\"data:image/%s;base64,",
                    inspection_picture_format(path) ?: "jpeg");
            html_write_base64(out, bytes, count);
            fputs("\"></figure>\n", out);
        }
        if (file)
            fclose(file);
        free(path);
    }
}

void report_write_records(const struct report *report, FILE *out)
{
    draw_map(report, out);
    write_tables(report, 0, out);
}

void report_write_landing_records(const struct report *report, const struct report_landing *landing,
                                  FILE *out)
{
    write_tables(report, landing->summary.measured.landing.id, out);
    write_pictures(report, landing->summary.measured.landing.id, out);
}
