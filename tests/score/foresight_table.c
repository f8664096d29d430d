#include "tests/score/foresight.h"
bool foresight_recall(const struct foresight_list *list, const struct foresight_list *learned,
                      enum foresight_when when, struct foresight_moment *moment)
{ (void)list;(void)learned;(void)when;(void)moment; return true; }
void foresight_forget(struct foresight_moment *moment){(void)moment;}
void foresight_print_areas(const struct foresight_row *row, const struct foresight_moment *moment){(void)row;(void)moment;}
void foresight_print_held(const struct foresight_row *row, const struct foresight_moment *moment){(void)row;(void)moment;}
void foresight_print_missed(const struct foresight_row *row,                            const struct foresight_moment *moment){(void)row;(void)moment;}
