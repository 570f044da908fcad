// Reading and writing of body.txt by its grammar (formats/body.md).
#include <phynness/formats/body.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/schema/body_grammar.hpp>

#include "text/text_lines_reader.hpp"
#include "text/text_lines_writer.hpp"

namespace phynness {

std::string read_body_file(const std::filesystem::path& file) {
  return read_input_file(file, {"the body", "give a body.txt of phynness reduce", 1ULL << 32});
}

std::string write_body_text(const ReducedBody& body) {
  TextLinesWriter writer(schema::body_first_line);
  schema::body(writer, body);
  return writer.finished();
}

ReducedBody read_body_text(const std::string& text, const std::string& source_name) {
  ReducedBody body;
  TextLinesReader reader(checked_lines(schema::body_first_line, text, source_name, "body"), source_name,
                         "make it again with `phynness reduce`; the format is described in formats/body.md");
  schema::body(reader, body);
  reader.require_end();
  return body;
}

}  // namespace phynness
