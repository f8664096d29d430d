#include "host/day/walk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/channels.h"
#include "host/calibrate/jump.h"
#include "host/day/desk.h"

#define S_PER_DAY 86400
#define SENSORS   (MR_TRANSDUCERS + MR_GAGES)

bool day_walk_is_due(const struct mr_config *config, unsigned channel, uint32_t today)
{
    const struct mr_channel_config *c = &config->channel[channel];
    return mr_channel_measures(c) &&
           (!c->calibrated_day || (c->expires_day && c->expires_day <= today));
}

static const char *day_text(uint32_t day, char out[16])
{
    time_t s = (time_t)day * S_PER_DAY;
    struct tm at;
    gmtime_r(&s, &at);
    strftime(out, 16, "%Y-%m-%d", &at);
    return out;
}

static enum mr_status get(const struct day_walk *walk, const char *path, struct mr_config *config,
                          bool *got, struct error *error)
{
    struct desk_command command;
    desk_command_begin(&command, "board");
    desk_command_option(&command, "--serial", walk->serial);
    desk_command_add(&command, "config");
    desk_command_add(&command, "get");
    desk_command_option(&command, "-o", path);
    *got = desk_run(&command, error) == 0;
    return *got && error->status == MR_OK ? configtext_load(path, config, error) : error->status;
}

/* False: the board has not got it. */
static bool calibrate(const struct day_walk *walk, const char *name, struct error *error)
{
    struct desk_command command;
    char path[4200];
    snprintf(path, sizeof path, "%s/calibrated.cfg", walk->folder);
    remove(path);
    desk_command_begin(&command, "calibrate");
    desk_command_add(&command, name);
    desk_command_option(&command, "--serial", walk->serial);
    desk_command_option(&command, "-o", path);
    desk_command_option(&command, "--db", walk->db);
    if (desk_run(&command, error) != 0)
        return false;
    desk_command_begin(&command, "board");
    desk_command_option(&command, "--serial", walk->serial);
    desk_command_add(&command, "config");
    desk_command_add(&command, "set");
    desk_command_add(&command, path);
    desk_command_option(&command, "--db", walk->db);
    return desk_run(&command, error) == 0;
}

static void print_channel(const struct mr_channel_config *c, const char *name, bool due)
{
    char since[16], until[16];
    printf("%s %s: ", name, c->serial[0] ? c->serial : "(sensor without a number)");
    if (!c->calibrated_day)
        printf("never calibrated");
    else
        printf("calibrated %s", day_text(c->calibrated_day, since));
    if (c->expires_day)
        printf(", until %s", day_text(c->expires_day, until));
    printf("%s   q ends the walk > ",
           due ? "; due. Enter calibrates   s skip" : ". Enter leaves it   c calibrate");
    fflush(stdout);
}

/* One channel. False: the walk ends here. */
static bool visit(const struct day_walk *walk, const struct mr_config *config, unsigned channel,
                  bool due, unsigned *left, struct error *error)
{
    char name[8];
    jump_channel(channel, name);
    print_channel(&config->channel[channel], name, due);
    char key = desk_key(-1);
    printf("\n");
    if (key == DESK_END) {
        *left += due;
        return false;
    }
    if (key != 'c' && !(due && key == DESK_ENTER)) {
        *left += due;
        return true;
    }
    if (!calibrate(walk, name, error)) {
        printf("%s stays as it was\n", name);
        *left += due;
    }
    return error->status == MR_OK;
}

enum mr_status day_walk(struct day_walk *walk, struct error *error)
{
    struct mr_config *config = calloc(1, sizeof *config);
    uint32_t today = (uint32_t)(time(NULL) / S_PER_DAY);
    char path[4200];
    unsigned left = 0, due = 0;
    bool got = false, goes_on;
    if (!config)
        abort();
    snprintf(path, sizeof path, "%s/rig.cfg", walk->folder);
    remove(path);
    enum mr_status status = get(walk, path, config, &got, error);
    for (unsigned i = 0; i < SENSORS && got; i++)
        due += day_walk_is_due(config, i, today);
    goes_on = got && status == MR_OK;
    if (goes_on)
        printf("%u channels are due\n", due);
    for (int now = 1; now >= 0 && goes_on; now--) { /* those that are due first */
        for (unsigned i = 0; i < SENSORS && goes_on; i++) {
            if (mr_channel_measures(&config->channel[i]) &&
                day_walk_is_due(config, i, today) == (now == 1))
                goes_on = visit(walk, config, i, now == 1, &left, error);
        }
    }
    walk->ended = goes_on && left == 0;
    free(config);
    return error->status;
}
