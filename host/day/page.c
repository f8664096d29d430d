#include "host/day/page.h"

#include <fcntl.h>
#include <microhttpd.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/live/hub.h"
#include "host/live/server.h"

#define KEYS_MOST 16

struct day_page {
    struct live_source source;
    struct live_pages pages;
    struct live_hub *hub;
    struct live_server *server;
    char url[LIVE_URL_MAX + 8];
    int keys[2]; /* a pipe */
    pthread_mutex_t lock;
    json_t *state;
    char taken[KEYS_MOST + 1];
};

static char *get(void *context, const char *url)
{
    struct day_page *page = context;
    char *text = NULL;
    if (strcmp(url, "/day.json") != 0)
        return NULL;
    pthread_mutex_lock(&page->lock);
    if (page->state)
        text = json_dumps(page->state, JSON_COMPACT);
    pthread_mutex_unlock(&page->lock);
    return text;
}

static unsigned post(void *context, const char *url, const json_t *body, json_t *json)
{
    struct day_page *page = context;
    const char *keys = json_string_value(json_object_get(body, "keys"));
    if (strcmp(url, "/day") != 0 || !keys || !keys[0] || strlen(keys) > 2)
        return MHD_HTTP_BAD_REQUEST;
    pthread_mutex_lock(&page->lock);
    /* what is asked about is pressed with its answer: the person said it on the page */
    bool asked = keys[0] == 'a' || keys[0] == 's';
    bool taken = strchr(page->taken, keys[0]) && (asked ? strcmp(keys + 1, "y") == 0 : !keys[1]) &&
                 write(page->keys[1], keys, strlen(keys)) == (ssize_t)strlen(keys);
    if (taken)
        page->taken[0] = '\0'; /* one at a time: until the day says what is so */
    pthread_mutex_unlock(&page->lock);
    json_object_set_new(json, "done", json_boolean(taken));
    if (!taken)
        json_object_set_new(json, "error", json_string("not now: the day is at something else"));
    return taken ? MHD_HTTP_OK : MHD_HTTP_CONFLICT;
}

enum mr_status day_page_open(const char *where, const char *db, struct day_page **page,
                             struct error *error)
{
    struct day_page *made = calloc(1, sizeof *made);
    if (!made)
        abort();
    *page = made;
    made->keys[0] = made->keys[1] = -1;
    pthread_mutex_init(&made->lock, NULL);
    made->source = (struct live_source){.db = db, .no_commands = "this is the day's page"};
    made->pages = (struct live_pages){.context = made, .get = get, .post = post};
    if (pipe2(made->keys, O_CLOEXEC | O_NONBLOCK) != 0)
        return error_set(error, MR_IO, "no pipe for the keys of the page: %s; close other programs",
                         where);
    enum mr_status status = live_hub_open(&made->source, &made->hub, error);
    if (status == MR_OK)
        status = live_server_open(where, made->hub, &made->pages, &made->server, error);
    if (status != MR_OK)
        return status;
    const char *url = live_server_url(made->server), *token = strchr(url, '#');
    snprintf(made->url, sizeof made->url, "%.*sday%s", (int)(token - url), url, token);
    return MR_OK;
}

const char *day_page_url(const struct day_page *page)
{
    return page->url;
}

void day_page_tell(struct day_page *page, json_t *state, const char *keys)
{
    if (!page) {
        json_decref(state);
        return;
    }
    pthread_mutex_lock(&page->lock);
    json_decref(page->state);
    page->state = state;
    json_object_set_new(state, "keys", json_string(keys));
    snprintf(page->taken, sizeof page->taken, "%s", keys);
    pthread_mutex_unlock(&page->lock);
}

int day_page_keys(const struct day_page *page)
{
    return page ? page->keys[0] : -1;
}

void day_page_close(struct day_page *page)
{
    if (!page)
        return;
    live_server_close(page->server);
    live_hub_close(page->hub);
    for (int i = 0; i < 2; i++) {
        if (page->keys[i] >= 0)
            close(page->keys[i]);
    }
    json_decref(page->state);
    pthread_mutex_destroy(&page->lock);
    free(page);
}
