/* What a fit gave, as an answer, as a scene, as a picture. */
#ifndef MATRIG_HOST_STUDY_FIT_PRINT_H
#define MATRIG_HOST_STUDY_FIT_PRINT_H

#include "host/base/answer.h"
#include "host/study/fit/misfit.h"

#define FIT_VERDICTS (2 * FIT_KEYS + 6)
/* Sentences of the verdict, one a line; NULL at the end. The caller frees each. Where the fit is
 * poor it says where: when the model cannot be the data's, or, unchecked, by the distance. */
size_t fit_verdicts(const struct fit_landings *list, const struct fit_answer *answer,
                    const struct misfit *misfit, char *text[FIT_VERDICTS]);

/* Whether the model can be the data's, in one line. */
void misfit_sentence(const struct fit_landings *list, const struct misfit *misfit, char *text,
                     size_t size);
/* That, and all figures for programs. */
void misfit_describe(struct answer *answer, const struct fit_landings *list,
                     const struct misfit *misfit);

/* All of it. A new answer, the caller's. */
struct answer *fit_described(const struct fit_landings *list, const struct fit_answer *fit,
                             const struct misfit *misfit, bool si);
/* The runway's scene with the fitted values, the first landing's way and thrust, and joints: of
 * many draws those that come nearest to what was measured (joints that are all alike would hardly
 * move: a landing moves what gives way first). */
enum mr_status fit_write_scene(const struct fit_landings *list, const struct fit_answer *answer,
                               const char *from, const char *path, struct error *error);
/* Residual plots, one picture: each statistic's measured less expected, in standard deviations,
 * over the transducers' stations, and measured against expected; and whether the model can be the
 * data's. */
enum mr_status fit_write_plot(const struct fit_landings *list, const struct fit_answer *answer,
                              const struct misfit *misfit, const char *path, struct error *error);

#endif
