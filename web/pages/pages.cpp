#include <zlib.h>

#include <cstdint>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/pages/pages.hpp>

#include "embedded.hpp"

namespace phynness {
namespace {

/// @throws Error (failure) if there is not enough memory
std::string gzip(const std::string& text) {
  constexpr int of_gzip = 15 + 16, memory = 8;  // window of 2^15 bytes with the header of gzip; zlib's default
  z_stream stream{};
  std::string out;
  if (text.size() <= std::numeric_limits<uInt>::max() &&
      deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, of_gzip, memory, Z_DEFAULT_STRATEGY) == Z_OK) {
    out.resize(deflateBound(&stream, text.size()));
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    const bool whole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    out.resize(whole ? stream.total_out : 0);
    deflateEnd(&stream);
  }
  if (out.empty())
    throw failure("the data of the page cannot be compressed", std::to_string(text.size()) + " bytes",
                  "give a smaller model or body, at most 4 GB");
  return out;
}

/// RFC 4648.
std::string base64(const std::string& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace

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
  const std::string element = R"(<script type="text/plain" id="phynness-data">)";
  const auto at = page.find(element);
  if (at == std::string::npos)
    throw failure("the embedded page has no place for its data", "web/view/page.html", "this is a defect; report it");
  return page.substr(0, at + element.size()) + base64(gzip(json)) + page.substr(at + element.size());
}

}  // namespace phynness
