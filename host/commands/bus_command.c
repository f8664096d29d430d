/* matrig bus: who is on a CAN bus, who is in whose way, and where one more board could go. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/answer.h"
#include "host/board/buslisten.h"
#include "host/commands/commands.h"
#include "host/link/rx_diagnostics.h"

#define CONFLICTS_MOST 100u /* each message of the catalogue */
#define FREE_MOST      8u

struct request {
    const char *link, *base_text;
    double for_s;
};

struct heard {
    struct busscan scan;
    struct busscan_found found;
    struct busscan_conflict conflict[CONFLICTS_MOST];
    double s;
};

static void rate(struct answer *answer, const struct heard *heard, double frames)
{
    answer_value(answer, "per_s", "per second", UNIT_NUMBER,
                 heard->s > 0.0 ? frames / heard->s : (double)NAN, 1);
}

static void boards_answer(const struct heard *heard, struct answer *answer)
{
    answer_table(answer, "boards", "boards");
    for (unsigned i = 0; i < heard->found.count; i++) {
        const struct busscan_board *board = &heard->found.board[i];
        for (unsigned k = 0; k < board->uids; k++) {
            char uid[IDENTITY_UID_TEXT];
            identity_uid_text(&board->who[k], uid);
            answer_row(answer);
            answer_count(answer, "base", NULL, board->base);
            answer_words(answer, NULL, "base", "0x%03x", board->base);
            answer_words(answer, "board", "board", "%s", uid);
            answer_words(answer, "firmware", "firmware", "%u.%u.%u", board->hello.major,
                         board->hello.minor, board->hello.patch);
            answer_count(answer, "layout", "layout", board->hello.layout);
            answer_flag(answer, "same_layout", NULL, board->hello.layout == MR_LAYOUT);
            answer_count(answer, "frames", "frames", (int64_t)board->frames);
            rate(answer, heard, (double)board->frames);
        }
    }
    answer_close(answer);
}

static void others_answer(const struct heard *heard, struct answer *answer)
{
    answer_table(answer, "others", "of no board");
    for (unsigned id = 0; id <= MR_CAN_ID_MOST; id++) {
        uint32_t frames = heard->found.stray[id];
        if (!frames)
            continue;
        answer_row(answer);
        answer_count(answer, "id", NULL, id);
        answer_words(answer, NULL, "identifier", "0x%03x", id);
        answer_count(answer, "frames", "frames", frames);
        rate(answer, heard, frames);
    }
    answer_close(answer);
}

static void add_collision(struct answer *answer, const char *kind, uint16_t base, size_t ids,
                          const char *text)
{
    answer_row(answer);
    answer_words(answer, "kind", NULL, "%s", kind);
    answer_count(answer, "base", NULL, base);
    answer_words(answer, NULL, "base", "0x%03x", base);
    answer_count(answer, "identifiers", NULL, (int64_t)ids);
    answer_words(answer, "text", "what", "%s", text);
}

static void base_text(const struct busscan_board *board, char *out, size_t size)
{
    if (board->more)
        snprintf(out, size,
                 "more boards have it than are told apart (%u): give all but one another, over "
                 "their serial ports",
                 board->uids);
    else if (board->uids > 2)
        snprintf(out, size, "%u boards have it: give all but one another, over their serial ports",
                 board->uids);
    else
        snprintf(out, size, "two boards have it: give one of them another, over its serial port");
}

/* How many. */
static unsigned collisions_answer(struct heard *heard, struct answer *answer)
{
    unsigned collisions = 0;
    char ids[320];
    answer_table(answer, "collisions", "collisions");
    for (unsigned i = 0; i < heard->found.count; i++) {
        const struct busscan_board *board = &heard->found.board[i];
        size_t there = busscan_conflicts_of(&heard->found, board, heard->conflict, CONFLICTS_MOST);
        if (busscan_is_shared(board)) {
            base_text(board, ids, sizeof ids);
            add_collision(answer, "base", board->base, 0, ids);
            collisions++;
        }
        if (there) {
            busscan_conflicts_text(heard->conflict, there, there, ids, sizeof ids);
            add_collision(answer, "identifiers", board->base, there, ids);
            collisions++;
        }
    }
    answer_close(answer);
    return collisions;
}

/* Whether a board may have this base. */
static bool base_answer(struct heard *heard, uint16_t base, struct answer *answer)
{
    char ids[320];
    size_t there = busscan_conflicts(&heard->found, base, heard->conflict, CONFLICTS_MOST);
    busscan_conflicts_text(heard->conflict, there, there, ids, sizeof ids);
    answer_open(answer, "asked", "");
    answer_count(answer, "base", NULL, base);
    answer_flag(answer, "free", NULL, there == 0);
    if (there)
        answer_words(answer, NULL, "base", "0x%03x is not free: %s", base, ids);
    else
        answer_words(answer, NULL, "base", "0x%03x is free: nothing heard has an identifier of it",
                     base);
    answer_list(answer, "taken", NULL);
    for (size_t i = 0; i < there && i < CONFLICTS_MOST; i++)
        answer_count(answer, NULL, NULL, heard->conflict[i].id);
    answer_close(answer);
    answer_close(answer);
    return there == 0;
}

static void free_answer(const struct heard *heard, struct answer *answer)
{
    uint16_t bases[FREE_MOST];
    char text[FREE_MOST * 7 + 1];
    size_t count = busscan_free(&heard->found, bases, FREE_MOST);
    busscan_free_text(&heard->found, text, sizeof text);
    answer_words(answer, NULL, "free bases", "%s", text);
    answer_list(answer, "free", NULL);
    for (size_t i = 0; i < count; i++)
        answer_count(answer, NULL, NULL, bases[i]);
    answer_close(answer);
}

static void total_answer(const struct heard *heard, const struct request *r, struct answer *answer)
{
    const struct busscan *scan = &heard->scan;
    answer_words(answer, "link", "link", "%s", r->link);
    answer_value(answer, "heard_s", NULL, UNIT_NUMBER, heard->s, 3);
    answer_words(answer, NULL, "heard", "%llu frames in %.1f s",
                 (unsigned long long)(scan->frames + scan->extended), heard->s);
    answer_count(answer, "frames", NULL, (int64_t)(scan->frames + scan->extended));
    answer_count(answer, "extended", scan->extended ? "extended" : NULL, (int64_t)scan->extended);
    answer_count(answer, "remote", scan->remote ? "remote" : NULL, (int64_t)scan->remote);
    answer_count(answer, "errors", scan->errors ? "error frames" : NULL, (int64_t)scan->errors);
}

/* Not a frame came: to who asks for a base that may be as it is. */
static void silence_answer(const struct heard *heard, struct answer *answer)
{
    if (heard->scan.frames + heard->scan.extended == 0)
        answer_sentence(answer, "note",
                        "nothing was heard in %.1f s: if the bus is in use, are rate and cable "
                        "right?",
                        heard->s);
    else if (heard->found.count == 0)
        answer_sentence(answer, "note", "no hello from a board");
    else
        answer_none(answer, "note", NULL, NULL);
}

static void layouts_answer(const struct heard *heard, struct answer *answer)
{
    for (unsigned i = 0; i < heard->found.count; i++) {
        const struct busscan_board *board = &heard->found.board[i];
        if (board->hello.layout != MR_LAYOUT)
            answer_sentence(answer, NULL,
                            "the board at 0x%03x speaks layout %u, this matrig layout %u: what is "
                            "said of its identifiers may not be so",
                            board->base, board->hello.layout, MR_LAYOUT);
    }
}

static int tell(const struct cli *cli, const struct request *r, struct heard *heard,
                const uint16_t *base)
{
    struct answer *answer = answer_new(cli->si);
    busscan_find(&heard->scan, &heard->found);
    total_answer(heard, r, answer);
    boards_answer(heard, answer);
    others_answer(heard, answer);
    bool good = collisions_answer(heard, answer) == 0;
    if (base)
        good &= base_answer(heard, *base, answer);
    else
        answer_none(answer, "asked", NULL, NULL);
    free_answer(heard, answer);
    answer_flag(answer, "good", NULL, good);
    silence_answer(heard, answer);
    layouts_answer(heard, answer);
    return answer_show(cli, answer, good ? 0 : mr_status_exit_code(MR_LIMIT));
}

/* With can:IFACE:board the kernel leaves out just what is looked for; LINK@BASE is one board's. */
static enum mr_status check_link(const char *spec, const struct link *link, struct error *error)
{
    size_t length = strlen(spec), filter = sizeof ":board" - 1;
    if (link_bases(link)->given)
        return error_set(error, MR_USAGE,
                         "one board's: %s; give the bus without @BASE, and --base B to ask for one",
                         spec);
    if (length > filter && strcmp(spec + length - filter, ":board") == 0)
        return error_set(error, MR_USAGE, "the board's messages alone: %s; give it without :board",
                         spec);
    return MR_OK;
}

static int bus_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    struct error error = {0};
    struct link *link = NULL;
    uint16_t base = 0;
    struct heard *heard = calloc(1, sizeof *heard);
    if (!heard)
        abort();
    enum mr_status status = command_parse(&command_bus, argc, argv, cli, &r, &r.link, &error);
    if (status == MR_OK && r.base_text)
        status = link_read_base(r.base_text, "--base", &base, &error);
    if (status == MR_OK)
        status = link_open(r.link, LINK_CAN, &link, &error);
    if (status == MR_OK)
        status = check_link(r.link, link, &error);
    if (status == MR_OK)
        status = buslisten(link, r.for_s, &heard->scan, &heard->s, &error);
    if (status == MR_OK && heard->scan.frames + heard->scan.extended == 0)
        status = r.base_text ? buslisten_silent(link, &error) : link_no_board(link, &error);
    int exit_code = status == MR_OK ? tell(cli, &r, heard, r.base_text ? &base : NULL)
                                    : cli_fail(&error);
    link_close(link);
    free(heard);
    return exit_code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("LINK", "the CAN bus: an interface, an adapter or a candump log (see matrig log "
                      "--help). Nothing is sent"),
    OPTION_NUMBER("--for", "S", for_s, "s", BUSSCAN_LEAST_S, 3600.0, 3.0,
                  "listen so long, {low} to {high} s; else {standard}. Of a log its first S "
                  "seconds"),
    OPTION_TEXT("--base", "B", base_text, "may a board have this base? 400 and 0x190 are the same"),
    HELP_NOTE("Tells the boards, each with its base, identifiers that belong to no board, and "
              "bases that are free. A board says\n"
              "who it is once a second. Exit 1: boards share a base, an identifier belongs to "
              "two, or the base B is not free."),
    HELP_EXAMPLE("matrig bus can:can0 --base 0x190"),
};

const struct command command_bus = {
    "bus",
    bus_command,
    "LINK [--for S] [--base B]",
    "the boards on a CAN bus, collisions, free bases",
    COMMAND_PARTS(parts),
    {1, 1, "LINK"},
};
