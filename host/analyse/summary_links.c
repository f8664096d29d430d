#include "host/analyse/summary_links.h"

#include <stdlib.h>
#include <string.h>

const char *summary_link_name(int link)
{
    return link == LINK_CAN ? "CAN" : link == LINK_SERIAL ? "serial" : "file";
}

static enum mr_status load_troubles(struct store *store, int64_t run, int kind, struct summary_link *link,
                                    struct error *error)
{
    struct store_trouble *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_troubles(store, run, kind, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].code >= 0 && rows[i].code < LINK_TROUBLES)
            link->trouble[rows[i].code] = rows[i].count;
    }
    free(rows);
    return status;
}

enum mr_status summary_links_load(struct store *store, struct summary *summary, struct error *error)
{
    int64_t run = summary->measured.landing.id;
    enum mr_status status = store_gaps(store, run, &summary->gap, &summary->gaps, error);
    if (status == MR_OK)
        status = store_held_get(store, run, &summary->held, error);
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct summary_link *link = &summary->link[kind];
        const char *spec = kind == LINK_CAN ? summary->session.can_link : summary->session.serial_link;
        link->used = spec[0] != '\0';
        status = store_frames_count(store, run, kind, &link->received, error);
        int64_t blocks = 0;
        if (status == MR_OK && kind == LINK_SERIAL)
            status = store_blocks_count(store, run, &blocks, error);
        link->received += blocks;
        if (status == MR_OK)
            status = load_troubles(store, run, kind, link, error);
    }
    for (size_t i = 0; i < summary->gaps; i++) {
        const struct store_gap *gap = &summary->gap[i];
        if (gap->link < 0 || gap->link >= LINK_KINDS)
            continue;
        struct summary_link *link = &summary->link[gap->link];
        if (strcmp(gap->cause, "silence") == 0 || gap->count == STORE_NONE)
            link->silent = true;
        else if (strcmp(gap->message, "frame") == 0)
            *(strcmp(gap->cause, "board") == 0 ? &link->dropped : &link->lost) += gap->count;
    }
    return status;
}

void summary_troubles(const int64_t *trouble, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = 0; i < LINK_TROUBLES && used < size; i++) {
        if (trouble[i] > 0)
            used += (size_t)snprintf(out + used, size - used, "%s%s %lld", used ? ", " : "", link_trouble_text(i),
                                     (long long)trouble[i]);
    }
}

json_t *summary_troubles_json(const int64_t *trouble)
{
    json_t *object = json_object();
    for (unsigned i = 0; i < LINK_TROUBLES; i++) {
        if (trouble[i] > 0)
            json_object_set_new(object, link_trouble_text(i), json_integer((json_int_t)trouble[i]));
    }
    return object;
}

/* Why frames that a gap counts are not there. */
static const char *gap_reason(const char *cause)
{
    static const struct {
        const char *cause;
        const char *text;
    } reasons[] = {
        {"board", "not sent by the board"},
        {"queue", "lost in this computer's receive queue"},
        {"lock", "lost while another program held the campaign"},
        {"slow disk", "lost while the disk was slow"},
        {"full disk", "lost while the disk was full"},
        {"processor", "lost while this computer was too slow"},
        {"adapter", "lost in the adapter"},
        {"bus-off", "lost while the adapter was off the bus"},
        {"away", "lost while the link was away"},
        {"file", "not in the file"},
    };
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++) {
        if (strcmp(cause, reasons[i].cause) == 0)
            return reasons[i].text;
    }
    return "lost";
}

void summary_gap(const struct store_gap *gap, char *out, size_t size)
{
    char count[40] = "", range[60] = "";
    if (gap->count != STORE_NONE)
        snprintf(count, sizeof count, "%lld ", (long long)gap->count);
    if (gap->from_block != STORE_NONE && gap->to_block != STORE_NONE)
        snprintf(range, sizeof range, ", blocks %lld to %lld", (long long)gap->from_block,
                 (long long)gap->to_block);
    if (strcmp(gap->cause, "silence") == 0)
        snprintf(out, size, "%s silent%s", summary_link_name(gap->link), range);
    else
        snprintf(out, size, "%s %s%s %s (%s)%s", summary_link_name(gap->link), count, gap->message,
                 gap_reason(gap->cause), gap->channels, range);
}

void summary_doubts_print(const struct summary *summary, FILE *out)
{
    char line[DOUBTS_TEXT];
    const struct doubts *doubts = &summary->measured.doubts;
    for (size_t i = 0; doubts_line(doubts, i, line); i++)
        fprintf(out, "  %-13s %s\n", i > 0 ? "" : doubts->doubtful || doubts->torn ? "doubtful" : "strangers", line);
}

void summary_links_print(const struct summary *summary, FILE *out)
{
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct summary_link *link = &summary->link[kind];
        fprintf(out, "  %-13s ", summary_link_name(kind));
        if (!link->used)
            fprintf(out, "not used\n");
        else
            fprintf(out, "%lld frames received, %lld lost, %lld not sent by the board%s\n",
                    (long long)link->received, (long long)link->lost, (long long)link->dropped,
                    link->silent ? "; silent in part: more may be lost" : "");
        char line[400], label[20];
        summary_troubles(link->trouble, line, sizeof line);
        snprintf(label, sizeof label, "%s link", summary_link_name(kind));
        if (line[0])
            fprintf(out, "  %-13s %s\n", label, line);
    }
    const struct measured_check *check = &summary->measured.check;
    if (check->compared)
        fprintf(out,
                "  %-13s %zu values of CAN against serial, %zu differ by more than a digit (worst %.2f)\n",
                "cross-check", check->compared, check->different, check->worst_digits);
    for (size_t i = 0; i < summary->gaps; i++) {
        char line[160];
        summary_gap(&summary->gap[i], line, sizeof line);
        fprintf(out, "  %-13s %s\n", "gap", line);
    }
    if (summary->gaps == 0)
        fprintf(out, "  %-13s none\n", "gaps");
}

static json_t *integer_or_null(int64_t value)
{
    return value == STORE_NONE ? json_null() : json_integer(value);
}

static json_t *links_json(const struct summary *summary)
{
    json_t *links = json_object();
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct summary_link *link = &summary->link[kind];
        if (link->used)
            json_object_set_new(links, kind == LINK_CAN ? "can" : "serial",
                                json_pack("{sIsIsIsbso}", "received", (json_int_t)link->received, "lost",
                                          (json_int_t)link->lost, "dropped", (json_int_t)link->dropped,
                                          "silent", link->silent, "troubles",
                                          summary_troubles_json(link->trouble)));
    }
    return links;
}

static json_t *gaps_json(const struct summary *summary)
{
    json_t *gaps = json_array();
    for (size_t i = 0; i < summary->gaps; i++) {
        const struct store_gap *gap = &summary->gap[i];
        json_t *row = json_pack("{ssssssss}", "link", gap->link == LINK_CAN ? "can" : "serial", "message",
                                gap->message, "channels", gap->channels, "cause", gap->cause);
        json_object_set_new(row, "count", integer_or_null(gap->count));
        json_object_set_new(row, "from_block", integer_or_null(gap->from_block));
        json_object_set_new(row, "to_block", integer_or_null(gap->to_block));
        json_array_append_new(gaps, row);
    }
    return gaps;
}

void summary_links_json(const struct summary *summary, json_t *object)
{
    const struct measured_check *check = &summary->measured.check;
    json_object_set_new(object, "doubts", doubts_json(&summary->measured.doubts));
    json_object_set_new(object, "links", links_json(summary));
    json_object_set_new(object, "gaps", gaps_json(summary));
    json_object_set_new(object, "cross_check",
                        json_pack("{sIsI}", "compared", (json_int_t)check->compared, "different",
                                  (json_int_t)check->different));
}
