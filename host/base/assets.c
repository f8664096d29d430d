#include "host/base/assets.h"

#include <string.h>

/* Embeds the bytes of a file between two symbols. The file of dygraphs is from a Debian package
 * (host/base/module.mk). */
#define ASSET(name, file)                                  \
    __asm__(".section .rodata\n"                           \
            "asset_" #name ":\n.incbin \"" file "\"\n"     \
            "asset_" #name "_end:\n.byte 0\n.previous\n"); \
    extern const char asset_##name[], asset_##name##_end[]

ASSET(page, "host/live/page/live.html");
ASSET(board_script, "host/live/page/board.js");
ASSET(script, "host/live/page/live.js");
ASSET(picture_page, "host/live/page/picture.html");
ASSET(style, "host/live/page/live.css");
ASSET(chart_script, "host/report/charts.js");
ASSET(report_style, "host/report/report.css");
ASSET(plot_script, "dygraph.min.js");
ASSET(plot_style, "dygraph.min.css");
ASSET(plot_licence, "copyright");

#define ASSET_ROW(path, type, name)                  \
    {                                                \
        path, type, asset_##name, asset_##name##_end \
    }

static const struct asset assets[] = {
    ASSET_ROW("/", "text/html; charset=utf-8", page),
    ASSET_ROW("/board.js", "text/javascript; charset=utf-8", board_script),
    ASSET_ROW("/live.js", "text/javascript; charset=utf-8", script),
    ASSET_ROW("/picture.html", "text/html; charset=utf-8", picture_page),
    ASSET_ROW("/live.css", "text/css; charset=utf-8", style),
    ASSET_ROW("/charts.js", "text/javascript; charset=utf-8", chart_script),
    ASSET_ROW("/report.css", "text/css; charset=utf-8", report_style),
    ASSET_ROW("/dygraph.js", "text/javascript; charset=utf-8", plot_script),
    ASSET_ROW("/dygraph.css", "text/css; charset=utf-8", plot_style),
    ASSET_ROW("/licences.txt", "text/plain; charset=utf-8", plot_licence),
};

const struct asset *asset_find(const char *path)
{
    for (size_t i = 0; i < sizeof assets / sizeof assets[0]; i++) {
        if (strcmp(path, assets[i].path) == 0)
            return &assets[i];
    }
    return NULL;
}
