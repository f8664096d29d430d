/* What is taken for a mistyped word, and what is not. */
#include <string.h>

#include "host/base/spell_suggest.h"
#include "tests/cmocka_all.h"

static const char *nearest(const char *word, const char *const *candidates)
{
    struct spell_suggest near;
    spell_suggest_begin(&near, word);
    while (*candidates)
        spell_suggest_add(&near, *candidates++);
    return near.best ? near.best : "";
}

TEST(mistyped_words_find_theirs)
{
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

TEST(dashes_do_not_count)
{
    static const char *const options[] = {"--format", "--force", "-o", "--serial", NULL};
    assert_string_equal(nearest("--fromat", options), "--format");
    assert_string_equal(nearest("-serial", options), "--serial");
    assert_string_equal(nearest("--O", options), "-o");
}

TEST(it_is_said_as_a_question)
{
    struct spell_suggest near;
    char text[SPELL_SUGGEST_TEXT_SIZE];
    spell_suggest_begin(&near, "lgo");
    spell_suggest_text(&near, text);
    assert_string_equal(text, "");
    spell_suggest_add(&near, "log");
    spell_suggest_text(&near, text);
    assert_string_equal(text, "; did you mean log?");
}
