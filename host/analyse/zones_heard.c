#include "host/analyse/zones_heard.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PAUSE_BLOCKS 100 /* two statements: a frame that is lost alone hides no warning for long */

struct zones_heard zones_heard(const struct measured *measured, const struct store_zone *row,
                               size_t count)
{
    const struct store_landing *landing = &measured->landing;
    struct zones_heard heard = {.any = count > 0,
                                .ended = landing->state == MR_LANDING_DONE ||
                                         landing->state == MR_LANDING_IDLE,
                                .pause_from_s = (double)NAN,
                                .pause_to_s = (double)NAN,
                                .since_touchdown = measured->t0_is_touchdown};
    int64_t longest = PAUSE_BLOCKS;
    if (count == 0)
        return heard;
    heard.first_s = measured_block_s(measured, row[0].block);
    heard.last_s = measured_block_s(measured, row[count - 1].block);
    heard.late = landing->armed_block == STORE_NONE ||
                 row[0].block - landing->armed_block > PAUSE_BLOCKS;
    for (size_t i = 1; i < count; i++) {
        if (row[i].block - row[i - 1].block <= longest)
            continue;
        longest = row[i].block - row[i - 1].block;
        heard.pause_from_s = measured_block_s(measured, row[i - 1].block);
        heard.pause_to_s = measured_block_s(measured, row[i].block);
    }
    return heard;
}

static void add(char out[ZONES_HEARD_TEXT], const char *text)
{
    size_t used = strlen(out);
    snprintf(out + used, ZONES_HEARD_TEXT - used, "%s%s", used ? "; " : "", text);
}

bool zones_heard_doubt(const struct zones_heard *heard, double before_s, char out[ZONES_HEARD_TEXT])
{
    const char *since = heard->since_touchdown ? "touchdown" : "the first switch or arming";
    char text[160];
    out[0] = '\0';
    if (!heard->any) {
        add(out, "the record has nothing that the board said of zones");
        return true;
    }
    if (heard->late) {
        snprintf(text, sizeof text, "nothing was heard of zones before %.3f s after %s",
                 heard->first_s, since);
        add(out, text);
    }
    if (heard->pause_from_s < before_s) {
        snprintf(text, sizeof text, "nothing was heard of zones from %.3f to %.3f s after %s",
                 heard->pause_from_s, heard->pause_to_s, since);
        add(out, text);
    }
    if (!heard->ended && isinf(before_s)) {
        snprintf(text, sizeof text,
                 "the record ends %.3f s after %s, before the board said that the landing is over",
                 heard->last_s, since);
        add(out, text);
    }
    return out[0] != '\0';
}
