#include "host/sim/scene/result.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

const char *sim_status_name(enum sim_status status)
{
    static const char *const names[] = {"ok",          "unstable",     "folded", "step_underflow",
                                        "interrupted", "unpredictable"};
    return names[status];
}

void sim_result_end(struct sim_result *result, enum sim_status status, int mat, double t_s)
{
    result->status = status;
    result->mat = mat;
    result->t_s = t_s;
}

void sim_result_leave_out(struct sim_result *result, const char *what)
{
    for (size_t i = 0; i + 1 < SIM_LEFT_OUT_MAX; i++) {
        if (result->left_out[i] == what) /* a second solver of the same scene */
            return;
        if (!result->left_out[i]) {
            result->left_out[i] = what;
            return;
        }
    }
}

void sim_result_note(struct sim_result *result, const char *format, ...)
{
    for (size_t i = 0; i + 1 < SIM_NOTES_MAX; i++) {
        if (result->notes[i][0] == '\0') {
            va_list arguments;
            va_start(arguments, format);
            vsnprintf(result->notes[i], sizeof result->notes[i], format, arguments);
            va_end(arguments);
            return;
        }
    }
}

void sim_result_free(struct sim_result *result)
{
    for (size_t i = 0; i < result->output_count; i++)
        free(result->outputs[i].u_ft);
    free(result->outputs);
    free(result->u_ft);
    free(result->gap_ft);
    free(result->push_lb);
    free(result->pull_lb);
    free(result->rise_ft);
    free(result->mods);
    free(result->sample_u_ft);
    free(result->sample_y_ft);
    *result = (struct sim_result){0};
}
