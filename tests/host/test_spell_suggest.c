/* What is taken for a mistyped word, and what is not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "host/base/spell_suggest.h"

static const char *nearest(const char *word, const char *const *candidates)
{
    struct spell_suggest near;
    spell_suggest_begin(&near, word);
    while (*candidates)
        spell_suggest_try(&near, *candidates++);
    return near.best ? near.best : "";
}

static void mistyped_words_find_theirs(void **state)
{
    (void)state;
    static const char *const commands[] = {"ready",  "log",     "live",   "survey", "report",
                                           "replay", "compare", "params", "sim",    NULL};
    static const struct {
        const char *typed, *meant;
    } cases[] = {
        {"lgo", "log"},
        {"LOG", "log"},
        {"reprot", "report"},
        {"repaly", "replay"},
        {"comapre", "compare"},
        {"surve", "survey"},
        {"surveys", "survey"},
        {"paramss", "params"},
        {"simulate", "sim"},
        {"rdy", ""},
        {"fly", ""},
        {"lot", "log"},
        {"x", ""},
        {"", ""},
        {"completely", ""},
        {"reportreportreportreportreportreport", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_string_equal(nearest(cases[i].typed, commands), cases[i].meant);
    }
}

static void dashes_do_not_count(void **state)
{
    (void)state;
    static const char *const options[] = {"--format", "--force", "-o", "--serial", NULL};
    assert_string_equal(nearest("--fromat", options), "--format");
    assert_string_equal(nearest("-serial", options), "--serial");
    assert_string_equal(nearest("--O", options), "-o");
}

static void it_is_said_as_a_question(void **state)
{
    (void)state;
    struct spell_suggest near;
    char text[SPELL_SUGGEST_TEXT];
    spell_suggest_begin(&near, "lgo");
    spell_suggest_text(&near, text);
    assert_string_equal(text, "");
    spell_suggest_try(&near, "log");
    spell_suggest_text(&near, text);
    assert_string_equal(text, "; did you mean log?");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mistyped_words_find_theirs),
        cmocka_unit_test(dashes_do_not_count),
        cmocka_unit_test(it_is_said_as_a_question),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
