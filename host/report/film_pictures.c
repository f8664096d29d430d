#include "host/base/html.h"
#include "host/report/film_pictures.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/base/html.h"
#include "host/base/list.h"

static bool is_picture(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && (strcasecmp(dot, ".jpg") == 0 || strcasecmp(dot, ".jpeg") == 0 ||
                   strcasecmp(dot, ".png") == 0);
}

/* The last number before the extension; -1: there is none. */
static int64_t number_of(const char *name)
{
    const char *end = strrchr(name, '.');
    while (end > name && !isdigit((unsigned char)end[-1]))
        end--;
    const char *begin = end;
    while (begin > name && isdigit((unsigned char)begin[-1]) && end - begin < 15)
        begin--;
    return begin < end ? strtoll(begin, NULL, 10) : -1;
}

static int by_number(const void *a, const void *b)
{
    int64_t x = ((const struct film_picture *)a)->number,
            y = ((const struct film_picture *)b)->number;
    return (x > y) - (x < y);
}

static enum mr_status add(struct film_pictures *pictures, const char *folder, const char *name,
                          struct error *error)
{
    size_t length = strlen(folder) + strlen(name) + 2;
    char *path = malloc(length);
    if (!path || !list_grow(&pictures->picture, pictures->count, sizeof *pictures->picture)) {
        free(path);
        return error_set(error, MR_FULL, "no memory: pictures of %s; close other programs", folder);
    }
    snprintf(path, length, "%s/%s", folder, name);
    pictures->picture[pictures->count++] = (struct film_picture){number_of(name), path};
    return MR_OK;
}

enum mr_status film_pictures_list(const char *folder, int64_t run, bool alone,
                                  struct film_pictures *pictures, struct error *error)
{
    char path[1000];
    enum mr_status status = MR_OK;
    *pictures = (struct film_pictures){0};
    snprintf(path, sizeof path, "%s/%lld", folder, (long long)run);
    DIR *open = opendir(path);
    if (!open && errno == ENOENT) {
        snprintf(path, sizeof path, "%s", folder);
        open = opendir(path);
        if (open && !alone) { /* it is there, but not for this landing */
            closedir(open);
            return MR_OK;
        }
    }
    if (!open)
        return error_set(error, MR_IO,
                         "cannot read the film's folder: %s (%s); --film names a folder with a "
                         "folder of pictures for each RUN",
                         path, strerror(errno));
    for (struct dirent *entry; status == MR_OK && (entry = readdir(open)) != NULL;) {
        if (is_picture(entry->d_name) && number_of(entry->d_name) >= 0)
            status = add(pictures, path, entry->d_name, error);
    }
    closedir(open);
    if (pictures->count)
        qsort(pictures->picture, pictures->count, sizeof *pictures->picture, by_number);
    return status;
}

void film_pictures_free(struct film_pictures *pictures)
{
    for (size_t i = 0; i < pictures->count; i++)
        free(pictures->picture[i].path);
    free(pictures->picture);
    *pictures = (struct film_pictures){0};
}

const struct film_picture *film_pictures_find(const struct film_pictures *pictures, int64_t number)
{
    const struct film_picture key = {number, NULL};
    return pictures->count
             ? bsearch(&key, pictures->picture, pictures->count, sizeof key, by_number)
             : NULL;
}

/* By what is in the file, not by its name: nothing else may get into the page. "": neither. */
static const char *type_of(const unsigned char *bytes, size_t count)
{
    if (count > 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0)
        return "jpeg";
    return count > 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0 ? "png" : "";
}

enum mr_status film_picture_write(const struct film_picture *picture, FILE *out,
                                  struct error *error)
{
    FILE *file = fopen(picture->path, "rb");
    unsigned char *bytes = malloc(FILM_PICTURE_BYTES + 1);
    enum mr_status status = MR_OK;
    size_t count = file && bytes ? fread(bytes, 1, FILM_PICTURE_BYTES + 1, file) : 0;
    const char *type = bytes ? type_of(bytes, count) : "";
    if (!file || ferror(file))
        status = error_set(error, MR_IO, "cannot read a picture of the film: %s (%s)",
                           picture->path, strerror(errno));
    else if (!bytes)
        status = error_set(error, MR_FULL, "no memory: %s; close other programs", picture->path);
    else if (count > FILM_PICTURE_BYTES)
        status = error_set(error, MR_LIMIT, "the picture is larger than %u MB: %s; scale it down",
                           FILM_PICTURE_BYTES >> 20, picture->path);
    else if (!type[0])
        status = error_set(error, MR_MALFORMED, "no JPEG and no PNG: %s; save it as one of them",
                           picture->path);
    if (status == MR_OK) {
        fprintf(out, "<img alt=\"frame %lld\" src=\"data:image/%s;base64,",
                (long long)picture->number, type);
        html_base64(out, bytes, count);
        fputs("\">", out);
    }
    if (file)
        fclose(file);
    free(bytes);
    return status;
}
