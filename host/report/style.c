/* Looks of every page here, in light, dark and print. */
#include "host/base/html.h"
#include "host/report/page.h"

/* Colours: blue, orange, green and so on of equal weight, tellable apart without red against green; the dark
 * set is the same hues lighter. */
static const char style[] =
    ":root{--paper:#fff;--ink:#1b1f24;--soft:#59636e;--rule:#d5dae0;--grid:#e8ebef;--panel:#f6f8fa;"
    "--a:#0b62c4;--b:#c2570c;--c:#6a3fb5;--d:#0a7d5a;--e:#a8256f;--f:#7a6a00;--closed:#c9702c;--warn:#b3261e}"
    "@media screen and (prefers-color-scheme:dark){:root{--paper:#12161b;--ink:#e4e8ec;--soft:#9aa5b1;"
    "--rule:#39424d;--grid:#262d36;--panel:#1a2028;--a:#6cb2ff;--b:#ff9d57;--c:#bfa0ff;--d:#4fd0a4;"
    "--e:#f58cc6;--f:#d8c84a;--closed:#d58445;--warn:#ff7b72}}"
    "*{box-sizing:border-box}"
    "body{background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,sans-serif;"
    "max-width:1100px;margin:0 auto;padding:24px 20px 60px}h1{font-size:26px;margin:0 0 4px}"
    "h2{font-size:21px;margin:44px 0 6px;padding-top:14px;border-top:1px solid var(--rule)}"
    "h3{font-size:16px;margin:26px 0 6px}p{margin:6px 0;color:var(--soft);max-width:90ch}"
    "p.say{color:var(--ink)}.scroll{overflow-x:auto}nav ul{columns:3 200px;padding-left:18px;margin:12px 0}"
    "table{border-collapse:collapse;font-size:13.5px;font-variant-numeric:tabular-nums;width:100%}"
    "th{text-align:left;font-weight:600;color:var(--soft);border-bottom:1px solid var(--rule);"
    "padding:4px 10px 4px 0;vertical-align:bottom}"
    "td{border-bottom:1px solid var(--grid);padding:4px 10px 4px 0;vertical-align:top;overflow-wrap:break-word}td.hash{word-break:break-all;min-width:150px;font-size:11px}"
    "td.n{white-space:nowrap}"
    "dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(235px,1fr));gap:10px 18px;"
    "background:var(--panel);border:1px solid var(--rule);border-radius:6px;padding:14px 16px;"
    "margin:12px 0}dt{font-size:12px;color:var(--soft)}dd{margin:0;font-variant-numeric:tabular-nums;overflow-wrap:anywhere}"
    "figure{margin:14px 0}figcaption{color:var(--soft);font-size:13px}a{color:var(--a)}"
    ".film{display:grid;grid-template-columns:repeat(auto-fill,minmax(235px,1fr));gap:10px}.film figure{margin:0}"
    ".film img{width:100%;display:block}"
    ".warn{color:var(--warn);font-weight:600}"
    "svg{width:100%;height:auto;display:block;font:11px system-ui,sans-serif}svg.none{position:absolute;width:0;height:0}"
    ".grid{stroke:var(--grid);fill:none}.frame{fill:none;stroke:var(--rule)}.tick{fill:var(--soft)}"
    ".label{fill:var(--soft);font-size:12px}.name{fill:var(--ink);font-size:12px;font-weight:600}"
    ".line{fill:none;stroke-width:1.5;stroke-linejoin:round}.a{stroke:var(--a)}.b{stroke:var(--b)}"
    ".c{stroke:var(--c)}.sim{stroke:var(--b);stroke-dasharray:5 3}.faint{stroke:var(--rule);stroke-width:1}"
    ".dot{stroke:none}.dots{fill:none;stroke-width:4;stroke-linecap:round}.dots.given{stroke:var(--soft);stroke-width:5;stroke-linecap:square}.dot.a{fill:var(--a)}.dot.b{fill:var(--b)}.dot.c{fill:var(--c)}"
    ".dot.given{fill:var(--soft)}.open{fill:var(--paper);stroke:var(--ink);stroke-width:1.1}"
    ".band{fill:var(--a);opacity:.2;stroke:none}.band.sims{fill:var(--b)}"
    ".mark{stroke:var(--soft);stroke-dasharray:2 3;fill:none}.closed{fill:var(--closed);opacity:.75}"
    ".behind{fill:var(--closed);opacity:.25}.warned{fill:url(#hatch)}.edge{stroke:var(--warn);stroke-width:.8}"
    ".told{fill:var(--a);opacity:.3}.hatch{stroke:var(--warn);stroke-width:1.6}"
    ".sensor{fill:var(--d)}.key{stroke-width:9}.key.closed{stroke:var(--closed)}"
    ".key.behind{stroke:var(--closed)}.key.warned{stroke:var(--warn);stroke-dasharray:2 2;stroke-width:9}"
    ".key.told{stroke:var(--a);opacity:.3}"
    ".key.sensor{stroke:var(--d);opacity:1}.s0{stroke:var(--a)}.s1{stroke:var(--b);stroke-dasharray:7 3}"
    ".s2{stroke:var(--c);stroke-dasharray:2 2.5}.s3{stroke:var(--d);stroke-dasharray:9 3 2 3}"
    ".s4{stroke:var(--e);stroke-dasharray:14 4}.s5{stroke:var(--f);stroke-dasharray:5 2 1.5 2 1.5 2}"
    ".dot.s0{fill:var(--a)}.dot.s1{fill:var(--b)}.dot.s2{fill:var(--c)}.dot.s3{fill:var(--d)}"
    ".dot.s4{fill:var(--e)}.dot.s5{fill:var(--f)}"
    "@page{margin:14mm}@media print{:root{--ink:#000;--soft:#333;--rule:#999;--grid:#ddd;--panel:#fff}"
    "body{max-width:none;margin:0;padding:0;font-size:10pt}table{font-size:8pt}h2,h3{break-after:avoid}"
    ".landing,#provenance{break-before:page}h2{margin-top:18pt}figure,tr,dl div{break-inside:avoid}"
    "thead{display:table-header-group}.scroll{overflow:visible}td,th{padding-right:5px}td.n{white-space:normal}p{max-width:none;break-before:avoid}"
    "svg,img{print-color-adjust:exact;-webkit-print-color-adjust:exact}}";

void page_head(FILE *out, const char *title)
{
    fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<meta name=\"color-scheme\" content=\"light dark\"><title>",
          out);
    html_text(out, title);
    fputs("</title>\n<style>", out);
    fputs(style, out);
    fputs("</style></head>\n<body>", out);
}

