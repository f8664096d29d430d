/* What a fit gave, as an answer, as a scene, as a picture. */
#ifndef MATRIG_HOST_STUDY_FIT_PRINT_H
#define MATRIG_HOST_STUDY_FIT_PRINT_H

#include "host/base/answer.h"
#include "host/study/fit/misfit.h"

/* All of it. A new answer, the caller's. */
struct answer *fit_described(const struct fit_landings *list, const struct fit_answer *fit,
                             const struct misfit *misfit, bool si);
/* The runway's scene with the fitted values, the first landing's way and thrust, and joints: of
 * many draws those that come nearest to what was measured (joints that are all alike would hardly
 * move: a landing moves what gives way first). */
enum mr_status fit_write_scene(const struct fit_landings *list, const struct fit_answer *answer,
                               const char *from, const char *path, struct error *error);
/* A plot of what each statistic leaves, in standard deviations, over the station. */
enum mr_status fit_write_plot(const struct fit_landings *list, const struct fit_answer *answer,
                              const struct misfit *misfit, const char *path, struct error *error);

#endif
