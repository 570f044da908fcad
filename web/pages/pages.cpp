#include <phynness/formats/error.hpp>
#include <phynness/pages/pages.hpp>

#include "embedded.hpp"

namespace phynness {

std::string embedded_page() {
  std::string text;
  for (const char* const* chunk = embedded_page_chunks; *chunk != nullptr; ++chunk) text += *chunk;
  return text;
}

std::string missing_pages_remedy() {
  return "install Node, npm and clang for WebAssembly (tools/install-deps --pages), and build again; the first build "
         "needs the npm registry";
}

std::string page_with_data(const std::string& page, const std::string& json) {
  const std::string element = R"(<script type="application/json" id="phynness-data">)", empty = "{}</script>";
  const auto at = page.find(element + empty);
  if (at == std::string::npos)
    throw failure("the embedded page has no place for its data", "web/view/page.html", "this is a defect; report it");
  std::string text = page.substr(0, at + element.size());
  for (const char c : json)
    if (c == '<')
      text += "\\u003c";  // so that no text can end the element
    else
      text += c;
  text += page.substr(at + element.size() + 2);
  return text;
}

}  // namespace phynness
