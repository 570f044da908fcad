#include <fmt/core.h>

#include <phynness/drawing/html.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/pages/pages.hpp>

namespace phynness::report {
namespace {

constexpr const char* style = R"(
:root { color-scheme: light dark; --line: #8884; --soft: #8882; --model: #1565c0; --linear: #c05a00;
  --c3: #2e7d32; --c4: #7b1fa2; --c5: #c62828; --c6: #00838f; --c7: #888; }
@media (prefers-color-scheme: dark) { :root { --model: #6ab0ff; --linear: #ffab5e;
  --c3: #7fd68a; --c4: #d39be8; --c5: #ff8a80; --c6: #6fd8e0; --c7: #999; } }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 66rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .5rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .5rem 0; }
th, td { padding: .15rem .45rem; border-bottom: 1px solid var(--line); text-align: right; }
td { white-space: nowrap; } th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
figure { margin: .5rem 0; } figcaption { font-size: .85rem; opacity: .8; }
noscript .key { margin-top: 2rem; } .plots { display: flex; flex-wrap: wrap; gap: 1rem; }
.plots > figure { flex: 1 1 24rem; max-width: 31rem; min-width: 0; }
.words { font-size: .87rem; } .words td, .words th { white-space: normal; vertical-align: top; padding: .15rem .45rem; }
.words th:first-child, .words td:first-child { min-width: 7rem; } .one-line { white-space: nowrap; } .verdict { display: inline-block; white-space: normal; min-width: 10rem; text-align: left; } .wide { overflow-x: auto; } .key { opacity: .75; }
.warning { border-left: 4px solid var(--linear); padding: .3rem .8rem; background: var(--soft); }
html { background: Canvas; color: CanvasText; }
@media (max-width: 640px) { table { font-size: .8rem; } th, td { padding: .15rem .3rem; } .words td { overflow-wrap: anywhere; }
  th:first-child, td:first-child { position: sticky; left: 0; background: Canvas padding-box; } }
@media print { body { margin: 0; max-width: none; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; }
  .wide { overflow: visible; } table { font-size: .72rem; } td, th { white-space: normal; padding: .1rem .3rem; }
  .verdict { min-width: 6rem; } .warning { print-color-adjust: exact; } }
)";

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string table(const std::vector<std::vector<std::string>>& rows, CellKind kind) {
  std::string out = kind == CellKind::words ? "<div class=\"wide\" tabindex=\"0\"><table class=\"words\">\n"
                                            : "<div class=\"wide\" tabindex=\"0\"><table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    out += r == 0 ? "<thead><tr>" : "<tr>";
    for (const auto& cell : rows[r]) {
      // Lines must not be broken after the minus of a number.
      const bool number =
          kind == CellKind::words && cell.find(' ') == std::string::npos && cell.find_first_of("0123456789") == 0;
      out += (r == 0 ? "<th>" : number ? "<td class=\"one-line\">" : "<td>") + cell + (r == 0 ? "</th>" : "</td>");
    }
    out += r == 0 ? "</tr></thead>\n" : "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::string section(const std::string& title, const std::string& body) {
  return "<section>\n<h2>" + title + "</h2>\n" + body + "</section>\n";
}

std::string page(const std::string& title, const std::string& body, const std::string& data) {
  const auto script = embedded_page("report.js"), style_of_script = embedded_page("report.css");
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data: blob:\">\n<title>" +
      escaped(title) + "</title>\n<style>" + style_of_script.value_or("") + style + "</style>\n</head>\n<body>\n" +
      body;
  if (!script)
    out +=
        "<p class=\"key\">This page has no curves and pictures, because it was written by a build without its "
        "script. " +
        escaped("To get them, " + missing_pages_remedy()) + ".</p>\n";
  else
    out += "<noscript><p class=\"key\">Curves and pictures need scripts, which are turned off.</p></noscript>\n";
  if (script && !data.empty())
    out += "<script type=\"application/json\" id=\"phynness-data\">" + json_for_html(data) + "</script>\n";
  if (script) out += "<script type=\"module\">" + *script + "</script>\n";
  return out + "</body>\n</html>\n";
}

}  // namespace phynness::report
