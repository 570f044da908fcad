#include <phynness/formats/error.hpp>
#include <phynness/pages/pages.hpp>

#include "embedded.hpp"

namespace phynness {

std::optional<std::string> embedded_page(const std::string& name) {
  for (const EmbeddedFile* file = embedded_files; file->name != nullptr; ++file) {
    if (name != file->name) continue;
    std::string text;
    for (const char* const* chunk = file->chunks; *chunk != nullptr; ++chunk) text += *chunk;
    return text;
  }
  return {};
}

std::string missing_pages_remedy() {
  return "install Node, npm and clang for WebAssembly (tools/install-deps --pages), and build again; the first build "
         "needs the npm registry";
}

std::string json_for_html(const std::string& json) {
  std::string text;
  text.reserve(json.size() + json.size() / 64);
  for (const char c : json)
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  return text;
}

std::string page_with_data(const std::string& page, const std::string& json) {
  const std::string element = R"(<script type="application/json" id="phynness-data">)", empty = "{}</script>";
  const auto at = page.find(element + empty);
  if (at == std::string::npos)
    throw failure("the embedded page has no place for its data", "web/*/page.html", "this is a defect; report it");
  std::string text = page.substr(0, at + element.size());
  text += json_for_html(json);
  text += page.substr(at + element.size() + 2);
  return text;
}

}  // namespace phynness
