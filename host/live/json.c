#include "host/live/json.h"

#include <math.h>
#include <stdlib.h>

#include "common/command.h"
#include "common/fault.h"
#include "common/quantity.h"
#include "common/risk.h"
#include "common/wire.h"
#include "host/base/cli.h"
#include "host/base/units.h"

#define DISPLACEMENT_PER_IN 10000.0
#define TENSION_PER_LB      100.0

/* Text from outside; what is no UTF-8 in it becomes question marks. NULL: null. */
static json_t *outside(const char *text)
{
    json_t *string = text ? json_string(text) : json_null();
    if (string)
        return string;
    char plain[300];
    size_t i = 0;
    for (; text[i] && i + 1 < sizeof plain; i++)
        plain[i] = (unsigned char)text[i] < 0x80 ? text[i] : '?';
    plain[i] = '\0';
    return json_string(plain);
}

static json_t *units_json(bool si)
{
    static const char *const names[UNIT_KINDS] = {"station", "displacement", "speed",
                                                  "deceleration", "tension"};
    json_t *units = json_object();
    for (int kind = 0; kind < UNIT_KINDS; kind++) {
        const struct unit *unit = unit_of((enum unit_kind)kind, si);
        json_object_set_new(units, names[kind],
                            json_pack("{sssf}", "text", unit->text, "factor", unit->factor));
    }
    return units;
}

static json_t *quantities_json(void)
{
    json_t *quantities = json_array();
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *q = mr_quantity_at(i);
        json_array_append_new(quantities, json_pack("{sssssssssi}", "key", q->key, "error_key",
                                                    q->error_key, "words", q->words, "unit",
                                                    q->unit, "decimals", q->decimals));
    }
    return quantities;
}

static json_t *texts_json(const char *(*text)(unsigned value), unsigned count)
{
    json_t *texts = json_array();
    for (unsigned i = 0; i < count; i++)
        json_array_append_new(texts, json_string(text(i)));
    return texts;
}

/* Of the status -n. */
static const char *status_text(unsigned n)
{
    return mr_status_text((enum mr_status) - (int)n);
}

json_t *live_json_configuration(const struct live_source *source)
{
    json_t *from = json_pack("{sosososbss?}", "db", outside(source->db), "can",
                             outside(source->can), "serial", outside(source->serial), "commands",
                             source->commands, "no_commands", source->no_commands);
    return json_pack("{sososisosososos[iii]sisisisisisfsi}", "units", units_json(source->si),
                     "source", from, "layout", (int)MR_LAYOUT, "quantities", quantities_json(),
                     "faults", texts_json(mr_fault_text, MR_FAULT_COUNT), "can_states",
                     texts_json(mr_can_state_text, MR_CAN_MISSING + 1), "statuses",
                     texts_json(status_text, 32), "box_good", MR_BOX_READY, MR_BOX_RECORDING,
                     MR_BOX_CLOSING, "lamp_limit_item", (int)MR_RISK_ITEMS, "risk_of_plan",
                     MR_RISK_OF_PLAN, "risk_of_chart", MR_RISK_OF_CHART, "arm", MR_COMMAND_ARM,
                     "disarm", MR_COMMAND_DISARM, "bucket_s", LIVE_BUCKET_BLOCKS / 1000.0,
                     "transducers", (int)MR_TRANSDUCERS);
}

static void put_number(FILE *out, const char *key, double value, int digits)
{
    if (isfinite(value))
        fprintf(out, ",\"%s\":%.*g", key, digits, value);
    else
        fprintf(out, ",\"%s\":null", key);
}

static void put_whole(FILE *out, const char *key, long long value)
{
    fprintf(out, ",\"%s\":%lld", key, value);
}

static void put_text(FILE *out, const char *key, const char *text)
{
    fprintf(out, ",\"%s\":\"%s\"", key, text);
}

/* clang-format off */
void live_json_message(FILE *out, const struct collector_event *event)
{
    const struct mr_message *message = event->message;
    char line[160];
    fprintf(out, "{\"m\":\"%s\"", message->info->name);
    put_whole(out, "t", (long long)event->host_us);
    put_whole(out, "l", event->link);
    if (event->board_us == STORE_NONE)
        fputs(",\"b\":null", out);
    else
        put_whole(out, "b", event->board_us / 1000);
    switch (message->place) {
#define MESSAGE(name, NAME, id, direction, text) \
    case MR_PLACE_##NAME: {                      \
        const struct mr_##name *m = &message->as.name;
#define INTEGER(name, type, field, unit, text) put_whole(out, #field, (long long)m->field);
#define CODE(name, type, field, values, text)   \
    put_whole(out, #field, (long long)m->field); \
    put_text(out, #field "_text", mr_##values##_text((unsigned)m->field));
#define REAL(name, type, field, per_unit, unit, text) put_number(out, #field, (double)m->field, 7);
#define FLOAT(name, field, unit, text) put_number(out, #field, (double)m->field, 7);
#define QUANTITY(name, NAME, kind, suffix, words, unit, decimals, of, its_error)   \
    put_text(out, "quantity", mr_quantity_at(MR_QUANTITY_##kind)->key);            \
    put_number(out, "value", (double)(of), 9);                                     \
    put_number(out, "error", (double)(its_error), 9);
#define NOTICE(name, NAME, severe, ...)          \
    snprintf(line, sizeof line, __VA_ARGS__);    \
    put_text(out, "severity", #severe);          \
    put_text(out, "notice", line);
#define END(name, NAME) \
    break;              \
    }
#include "common/catalogue.def"
    default: break;
    }
    fputc('}', out);
}
/* clang-format on */

static void put_values(FILE *out, const float values[LIVE_CHANNELS])
{
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        if (isfinite(values[i]))
            fprintf(out, ",%ld",
                    lround((double)values[i] *
                           (i < MR_TRANSDUCERS ? DISPLACEMENT_PER_IN : TENSION_PER_LB)));
        else
            fputs(",null", out);
    }
}

char *live_json_buckets(uint32_t run, uint64_t restarts, const struct live_bucket *buckets,
                        unsigned count)
{
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return NULL;
    fprintf(out, "{\"epoch\":\"%08x-%llu\",\"b\":[", (unsigned)run, (unsigned long long)restarts);
    for (unsigned i = 0; i < count; i++) {
        fprintf(out, "%s[%lld", i ? "," : "", (long long)buckets[i].bucket);
        put_values(out, buckets[i].least);
        put_values(out, buckets[i].most);
        fputc(']', out);
    }
    fputs("]}", out);
    return fclose(out) == 0 ? text : (free(text), NULL);
}

json_t *live_json_readings(const struct live_buckets *buckets)
{
    json_t *readings = json_array();
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        const struct live_reading *r = &buckets->reading[i];
        json_array_append_new(readings, json_pack("[ooos]", cli_json_number((double)r->value, 7),
                                                  cli_json_number((double)r->least, 7),
                                                  cli_json_number((double)r->most, 7),
                                                  live_buckets_why(buckets, i)));
    }
    return readings;
}
