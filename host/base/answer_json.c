/* An answer for programs. */
#include "host/base/answer_items.h"

static void put(json_t *group, const char *name, json_t *value)
{
    if (json_is_array(group))
        json_array_append_new(group, value);
    else if (name)
        json_object_set_new(group, name, value);
    else
        json_decref(value);
}

/* NAME_suffix, NAME_error_suffix */
static void put_number(json_t *group, const struct answer_item *item, const char *what,
                       double value)
{
    char key[120];
    const char *suffix = item->json_unit->suffix;
    snprintf(key, sizeof key, "%s%s%s%s", item->name ? item->name : "", what, suffix[0] ? "_" : "",
             suffix);
    put(group, item->name ? key : NULL, cli_json_number(value, item->fact.digits));
}

static void put_items(const struct answer *answer, size_t from, size_t to, json_t *group);

static void put_group(const struct answer *answer, size_t i, json_t *group)
{
    const struct answer_item *item = &answer->item[i];
    if (!item->name && !json_is_array(group)) {
        /* a heading for people; programs find its facts among the others */
        put_items(answer, i + 1, answer_after(answer, i), group);
        return;
    }
    json_t *inner = item->kind == ANSWER_OPEN ? json_object() : json_array();
    put_items(answer, i + 1, answer_after(answer, i), inner);
    put(group, item->name, inner);
}

static void put_item(const struct answer_item *item, json_t *group)
{
    if (!item->name && !json_is_array(group))
        return;
    switch (item->kind) {
    case ANSWER_ESTIMATE:
        put_number(group, item, "", item->json_value);
        put_number(group, item, "_error", item->json_error);
        break;
    case ANSWER_VALUE: put_number(group, item, "", item->json_value); break;
    case ANSWER_COUNT:
        put(group, item->name,
            item->count == ANSWER_UNKNOWN ? json_null() : json_integer((json_int_t)item->count));
        break;
    case ANSWER_FLAG: put(group, item->name, json_boolean(item->count)); break;
    case ANSWER_WORDS:
    case ANSWER_SENTENCE: put(group, item->name, json_string(item->words)); break;
    case ANSWER_NONE: put(group, item->name, json_null()); break;
    case ANSWER_JSON: put(group, item->name, json_incref(item->json)); break;
    default: break;
    }
}

static void put_items(const struct answer *answer, size_t from, size_t to, json_t *group)
{
    for (size_t i = from; i < to; i = answer_after(answer, i)) {
        if (answer_is_group(answer->item[i].kind))
            put_group(answer, i, group);
        else if (answer->item[i].kind == ANSWER_CLOSE)
            break;
        else
            put_item(&answer->item[i], group);
    }
}

json_t *answer_json(const struct answer *answer)
{
    if (!answer || answer->failed)
        return NULL;
    json_t *object = json_object();
    put_items(answer, 0, answer->count, object);
    return object;
}
