#include "host/analyse/summary_links.h"

#include <stdlib.h>
#include <string.h>

const char *summary_link_name(int link)
{
    return link == LINK_CAN ? "CAN" : link == LINK_SERIAL ? "serial" : "file";
}

static enum mr_status load_troubles(struct store *store, int64_t run, int kind,
                                    struct summary_link *link, struct error *error)
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

void summary_count_gaps(const struct store_gap *gaps, size_t count,
                        struct summary_link link[LINK_KINDS])
{
    for (size_t i = 0; i < count; i++) {
        const struct store_gap *gap = &gaps[i];
        if (gap->link < 0 || gap->link >= LINK_KINDS)
            continue;
        struct summary_link *its = &link[gap->link];
        if (strcmp(gap->cause, "silence") == 0 || gap->count == STORE_NONE)
            its->silent = true;
        else if (strcmp(gap->message, "frame") == 0)
            *(strcmp(gap->cause, "board") == 0 ? &its->dropped : &its->lost) += gap->count;
    }
}

enum mr_status summary_links_load(struct store *store, struct summary *summary, struct error *error)
{
    int64_t run = summary->measured.landing.id;
    enum mr_status status = store_gaps(store, run, &summary->gap, &summary->gaps, error);
    if (status == MR_OK)
        status = store_held_get(store, run, &summary->held, error);
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct summary_link *link = &summary->link[kind];
        const char *spec = kind == LINK_CAN ? summary->session.can_link
                                            : summary->session.serial_link;
        link->used = spec[0] != '\0';
        status = store_frames_count(store, run, kind, &link->received, error);
        int64_t blocks = 0;
        if (status == MR_OK && kind == LINK_SERIAL)
            status = store_blocks_count(store, run, &blocks, error);
        link->received += blocks;
        if (status == MR_OK)
            status = load_troubles(store, run, kind, link, error);
    }
    summary_count_gaps(summary->gap, summary->gaps, summary->link);
    return status;
}

void summary_troubles(const int64_t *trouble, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = 0; i < LINK_TROUBLES && used < size; i++) {
        if (trouble[i] > 0)
            used += (size_t)snprintf(out + used, size - used, "%s%s %lld", used ? ", " : "",
                                     link_trouble_text(i), (long long)trouble[i]);
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
        {"silence", "the link was silent"},
    };
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++) {
        if (strcmp(cause, reasons[i].cause) == 0)
            return reasons[i].text;
    }
    return "lost";
}

static void gap_answer(const struct store_gap *gap, struct answer *answer)
{
    answer_row(answer);
    answer_words(answer, NULL, "link", "%s", summary_link_name(gap->link));
    answer_words(answer, "link", NULL, gap->link == LINK_CAN ? "can" : "serial");
    answer_count(answer, "count", "count", gap->count);
    answer_words(answer, "message", "what", "%s", gap->message);
    answer_words(answer, "channels", "channels", "%s", gap->channels);
    answer_words(answer, NULL, "why", "%s", gap_reason(gap->cause));
    answer_words(answer, "cause", NULL, "%s", gap->cause);
    answer_count(answer, "from_block", "from block", gap->from_block);
    answer_count(answer, "to_block", "to block", gap->to_block);
}

static void link_answer(const struct summary_link *link, int kind, struct answer *answer)
{
    char line[400], label[20];
    if (!link->used) {
        answer_words(answer, NULL, summary_link_name(kind), "not used");
        return;
    }
    answer_words(answer, NULL, summary_link_name(kind),
                 "%lld frames received, %lld lost, %lld not sent by the board%s",
                 (long long)link->received, (long long)link->lost, (long long)link->dropped,
                 link->silent ? "; silent in part: more may be lost" : "");
    summary_troubles(link->trouble, line, sizeof line);
    snprintf(label, sizeof label, "%s link", summary_link_name(kind));
    if (line[0])
        answer_words(answer, NULL, label, "%s", line);
    answer_open(answer, kind == LINK_CAN ? "can" : "serial", NULL);
    answer_count(answer, "received", NULL, link->received);
    answer_count(answer, "lost", NULL, link->lost);
    answer_count(answer, "dropped", NULL, link->dropped);
    answer_flag(answer, "silent", NULL, link->silent);
    answer_json_value(answer, "troubles", summary_troubles_json(link->trouble));
    answer_close(answer);
}

void summary_links_answer(const struct summary *summary, struct answer *answer)
{
    const struct measured_check *check = &summary->measured.check;
    answer_open(answer, "links", "");
    for (int kind = 0; kind < LINK_KINDS; kind++)
        link_answer(&summary->link[kind], kind, answer);
    answer_close(answer);
    if (check->compared)
        answer_words(
            answer, NULL, "cross-check",
            "%zu values of CAN against serial, %zu differ by more than a digit (worst %.2f)",
            check->compared, check->different, check->worst_digits);
    answer_open(answer, "cross_check", NULL);
    answer_count(answer, "compared", NULL, (int64_t)check->compared);
    answer_count(answer, "different", NULL, (int64_t)check->different);
    answer_close(answer);
    if (summary->gaps == 0)
        answer_words(answer, NULL, "gaps", "none");
    answer_table(answer, "gaps", "gaps");
    for (size_t i = 0; i < summary->gaps; i++)
        gap_answer(&summary->gap[i], answer);
    answer_close(answer);
}
