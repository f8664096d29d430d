/* Two tellings of one landing, field by field, by name. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/golden/golden.h"

/* a message without a block of its own is placed by the newest that its link had told of */
#define NEAR_BLOCKS 4
#define ROUNDING    1e-9

struct finding { /* of one field, or of a whole message (field "") */
    enum golden_link link;
    const char *message, *field, *unit;
    const char *what; /* instead of values; NULL: they differ */
    size_t count;
    long at; /* the first */
    double was, is;
};

struct findings {
    struct finding *all;
    size_t count;
};

static void find(struct findings *f, const struct golden_kind *kind, const char *field,
                 const char *unit, const char *what, long at, double was, double is)
{
    for (size_t i = 0; i < f->count; i++) {
        struct finding *old = &f->all[i];
        if (old->link == kind->link && strcmp(old->message, kind->name) == 0 &&
            strcmp(old->field, field) == 0) {
            old->count++;
            if (at < old->at) {
                old->at = at;
                old->what = what;
                old->was = was;
                old->is = is;
            }
            return;
        }
    }
    f->all = golden_grow(f->all, f->count, sizeof *f->all);
    f->all[f->count++] = (struct finding){kind->link, kind->name, field, unit, what,
                                          1,          at,         was,   is};
}

/* Two resolutions of one value are at most half a step of each apart. A field in single precision
 * has none. */
static bool same(double was, double is, double was_step, double is_step)
{
    if (isnan(was) || isnan(is))
        return isnan(was) && isnan(is);
    if (was_step == is_step)
        return was == is;
    return fabs(was - is) <= 0.5 * (was_step + is_step) + ROUNDING * fabs(was);
}

static int field_named(const struct golden_kind *kind, const char *name)
{
    for (unsigned i = 0; i < kind->fields; i++) {
        if (strcmp(kind->field[i].name, name) == 0)
            return (int)i;
    }
    return -1;
}

static void compare_fields(struct findings *f, const struct golden_kind *was,
                           const struct golden_kind *is)
{
    for (unsigned i = 0; i < was->fields; i++) {
        const struct golden_field *field = &was->field[i];
        int now = field_named(is, field->name);
        if (now < 0)
            find(f, was, field->name, field->unit, "was told, is not", 0, 0, 0);
        else if (strcmp(is->field[now].unit, field->unit) != 0)
            find(f, was, field->name, field->unit, "has another unit", 0, 0, 0);
    }
    for (unsigned i = 0; i < is->fields; i++) {
        if (field_named(was, is->field[i].name) < 0)
            find(f, is, is->field[i].name, is->field[i].unit, "is told, was not", 0, 0, 0);
    }
}

static void compare_rows(struct findings *f, const struct golden_kind *was,
                         const struct golden_row *a, const struct golden_kind *is,
                         const struct golden_row *b)
{
    for (unsigned i = 0; i < was->fields; i++) {
        const struct golden_field *field = &was->field[i];
        int now = field_named(is, field->name);
        if (now >= 0 && !same(a->value[i], b->value[now], field->step, is->field[now].step))
            find(f, was, field->name, field->unit, NULL, a->at, a->value[i], b->value[now]);
    }
}

static void compare_kinds(struct findings *f, const struct golden_kind *was,
                          const struct golden_kind *is)
{
    long slack = was->own_block ? 0 : NEAR_BLOCKS;
    size_t i = 0, k = 0;
    compare_fields(f, was, is);
    while (i < was->rows || k < is->rows) {
        long a = i < was->rows ? was->row[i].at : INT32_MAX,
             b = k < is->rows ? is->row[k].at : INT32_MAX;
        if (i < was->rows && k < is->rows && labs(a - b) <= slack)
            compare_rows(f, was, &was->row[i++], is, &is->row[k++]);
        else if (a <= b)
            find(f, was, "", "", "was told, is not", was->row[i++].at, 0, 0);
        else
            find(f, was, "", "", "is told, was not", is->row[k++].at, 0, 0);
    }
}

static const struct golden_kind *kind_named(const struct golden_said *said,
                                            const struct golden_kind *like)
{
    for (size_t i = 0; i < said->kinds; i++) {
        if (said->kind[i].link == like->link && strcmp(said->kind[i].name, like->name) == 0)
            return &said->kind[i];
    }
    return NULL;
}

static void compare_all(struct findings *f, const struct golden_said *was,
                        const struct golden_said *is)
{
    for (size_t i = 0; i < was->kinds; i++) {
        const struct golden_kind *now = kind_named(is, &was->kind[i]);
        if (golden_excluded(was->kind[i].name, NULL)) /* since it was recorded */
            continue;
        if (now)
            compare_kinds(f, &was->kind[i], now);
        else
            find(f, &was->kind[i], "", "", "was told, is not", was->kind[i].row[0].at, 0, 0);
    }
    for (size_t i = 0; i < is->kinds; i++) {
        if (!kind_named(was, &is->kind[i]))
            find(f, &is->kind[i], "", "", "is told, was not", is->kind[i].row[0].at, 0, 0);
    }
}

static int by_time(const void *a, const void *b)
{
    const struct finding *x = a, *y = b;
    if (x->at != y->at)
        return x->at < y->at ? -1 : 1;
    return strcmp(x->message, y->message) ? strcmp(x->message, y->message)
                                          : strcmp(x->field, y->field);
}

static void tell(const struct finding *f)
{
    printf("%s.%s on %s, block %ld (%.3f s)", f->message, f->field[0] ? f->field : "*",
           golden_link_text[f->link], f->at, (double)f->at / 1e3);
    if (f->what)
        printf(": %s", f->what);
    else
        printf(": was %.10g, is %.10g%s%s", f->was, f->is, f->unit[0] ? " " : "", f->unit);
    printf(f->count > 1 ? "; %zu times\n" : "\n", f->count);
}

unsigned said_compare(const struct golden_said *was, const struct golden_said *is, bool brief)
{
    struct findings f = {0};
    unsigned count = 0;
    compare_all(&f, was, is);
    qsort(f.all, f.count, sizeof *f.all, by_time);
    for (size_t i = 0; i < f.count; i++) {
        bool named = false; /* on the other link */
        for (size_t k = 0; k < i && !named; k++)
            named = strcmp(f.all[k].message, f.all[i].message) == 0 &&
                    strcmp(f.all[k].field, f.all[i].field) == 0;
        count += !named;
        if (!brief)
            tell(&f.all[i]);
        else if (!named)
            printf("%s.%s\n", f.all[i].message, f.all[i].field[0] ? f.all[i].field : "*");
    }
    free(f.all);
    return count;
}
