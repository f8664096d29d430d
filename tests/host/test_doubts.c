/* What is told of frames that are not the board's: each once, and obeyed only where a number may
 * rest on them. */
#include <jansson.h>
#include <string.h>

#include "host/analyse/doubts.h"
#include "tests/cmocka_all.h"

#define HELLO           0x1f0
#define CODE(cause, id) ((cause) + DOUBT_ID * (id))

/* The list of the JSON is `lines`, one "what|message|count|obeyed" each. */
static void told(const struct doubts *doubts, const char *const *lines)
{
    struct answer *answer = answer_new(false);
    doubts_answer(doubts, answer);
    json_t *object = answer_json(answer),
           *list = json_object_get(json_object_get(object, "doubts"), "strangers"), *entry;
    size_t i;
    json_array_foreach(list, i, entry)
    {
        char line[200];
        snprintf(line, sizeof line, "%s|%s|%d|%s",
                 json_string_value(json_object_get(entry, "what")),
                 json_string_value(json_object_get(entry, "message")),
                 (int)json_integer_value(json_object_get(entry, "count")),
                 json_is_true(json_object_get(entry, "obeyed")) ? "obeyed" : "not");
        assert_non_null(lines[i]);
        assert_string_equal(line, lines[i]);
    }
    assert_null(lines[i]);
    json_decref(object);
    answer_free(answer);
}

static void what_was_recognised_is_not_told_again(void **state)
{
    (void)state;
    struct store_trouble rows[] = {{.code = CODE(DOUBT_EXCESS, 0), .count = 2},
                                   {.code = CODE(DOUBT_UNSAID, HELLO), .count = 2},
                                   {.code = CODE(DOUBT_ALONE, 0), .count = 7}};
    struct doubts doubts = {.row = rows, .rows = 3, .on_can = true};
    told(&doubts, (const char *const[]){"that serial did not say|hello|2|not", NULL});
}

static void what_nobody_recognised_is_told(void **state)
{
    (void)state;
    struct store_trouble rows[] = {{.code = CODE(DOUBT_EXCESS, 0), .count = 5},
                                   {.code = CODE(DOUBT_BOARD, HELLO), .count = 2}};
    struct doubts doubts = {.row = rows, .rows = 2, .on_can = true, .excess = 3, .doubtful = true};
    told(&doubts,
         (const char *const[]){"more than the board sent, which of them nobody knows||3|obeyed",
                               "of another board|hello|2|not", NULL});
    doubts = (struct doubts){.row = rows, .rows = 2}; /* all came over serial */
    told(&doubts,
         (const char *const[]){"more than the board sent, which of them nobody knows||3|not",
                               "of another board|hello|2|not", NULL});
}

/* Those of another length are not among the frames that are counted as the board's. */
static void another_length_is_no_excess(void **state)
{
    (void)state;
    struct store_trouble rows[] = {{.code = CODE(DOUBT_LENGTH, HELLO), .count = 4},
                                   {.code = CODE(DOUBT_EXCESS, 0), .count = 1}};
    struct doubts doubts = {.row = rows, .rows = 2, .on_can = true, .excess = 1, .doubtful = true};
    told(&doubts,
         (const char *const[]){"more than the board sent, which of them nobody knows||1|obeyed",
                               "of another length|hello|4|not", NULL});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_recognised_is_not_told_again),
        cmocka_unit_test(what_nobody_recognised_is_told),
        cmocka_unit_test(another_length_is_no_excess),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
