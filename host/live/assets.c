#include "host/live/assets.h"

#include <string.h>

/* Each file between two names. uPlot comes from where module.mk fetches it to; it makes this file
 * anew when one changes. */
#define ASSET(name, file)                                       \
    __asm__(".section .rodata\n"                                \
            "live_asset_" #name ":\n.incbin \"" file "\"\n"     \
            "live_asset_" #name "_end:\n.byte 0\n.previous\n"); \
    extern const char live_asset_##name[], live_asset_##name##_end[]

ASSET(page, "host/live/page/live.html");
ASSET(script, "host/live/page/live.js");
ASSET(style, "host/live/page/live.css");
ASSET(day_page, "host/live/page/day.html");
ASSET(day_script, "host/live/page/day.js");
ASSET(plot_script, "node_modules/uplot/dist/uPlot.iife.min.js");
ASSET(plot_style, "node_modules/uplot/dist/uPlot.min.css");
ASSET(plot_licence, "node_modules/uplot/LICENSE");

#define ROW(path, type, name)                                  \
    {                                                          \
        path, type, live_asset_##name, live_asset_##name##_end \
    }

static const struct live_asset assets[] = {
    ROW("/", "text/html; charset=utf-8", page),
    ROW("/live.js", "text/javascript; charset=utf-8", script),
    ROW("/live.css", "text/css; charset=utf-8", style),
    ROW("/day", "text/html; charset=utf-8", day_page),
    ROW("/day.js", "text/javascript; charset=utf-8", day_script),
    ROW("/uPlot.js", "text/javascript; charset=utf-8", plot_script),
    ROW("/uPlot.css", "text/css; charset=utf-8", plot_style),
    ROW("/licences.txt", "text/plain; charset=utf-8", plot_licence),
};

const struct live_asset *live_asset_find(const char *path)
{
    for (size_t i = 0; i < sizeof assets / sizeof assets[0]; i++) {
        if (strcmp(path, assets[i].path) == 0)
            return &assets[i];
    }
    return NULL;
}
