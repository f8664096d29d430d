/* What a fit gave, as an answer, as a scene, as a picture. */
#ifndef MATRIG_HOST_STUDY_FIT_PRINT_H
#define MATRIG_HOST_STUDY_FIT_PRINT_H

#include "host/base/answer.h"
#include "host/study/fit/landings.h"

#define FIT_VERDICTS (2 * FIT_KEYS + 6)
/* Sentences of the verdict, one a line; NULL at the end. The caller frees each. */
size_t fit_verdicts(const struct fit_landings *list, const struct fit_answer *answer,
                    char *text[FIT_VERDICTS]);

/* All of it. A new answer, the caller's. */
struct answer *fit_described(const struct fit_landings *list, const struct fit_answer *fit,
                             bool si);
/* The runway's scene with the fitted values, the first landing's way and thrust, and joints: of
 * many draws those that come nearest to what was measured (joints that are all alike would hardly
 * move: a landing moves what gives way first). */
enum mr_status fit_write_scene(const struct fit_landings *list, const struct fit_answer *answer,
                               const char *from, const char *path, bool force, struct error *error);
/* Residual plots, one picture: each statistic's measured less expected, in standard deviations,
 * over the transducers' stations, and measured against expected. */
enum mr_status fit_write_plot(const struct fit_landings *list, const struct fit_answer *answer,
                              const char *path, bool force, struct error *error);

#endif
