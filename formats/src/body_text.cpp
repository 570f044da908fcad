// Writing of body.txt by its grammar (formats/body.md).
#include <phynness/formats/body.hpp>
#include <phynness/schema/body_grammar.hpp>

#include "text_lines_writer.hpp"

namespace phynness {

std::string write_body_text(const ReducedBody& body) {
  TextLinesWriter writer(schema::body_first_line);
  schema::body(writer, body);
  return writer.finished();
}

}  // namespace phynness
