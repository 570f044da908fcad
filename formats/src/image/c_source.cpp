// C source of an image and of golden queries.
#include <phynness/formats/image.hpp>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

/// Text without sequences that end a comment or that begin another one, of which compilers warn.
std::string harmless(std::string text) {
  for (std::size_t i = 0; i + 1 < text.size(); ++i)
    if ((text[i] == '*' && text[i + 1] == '/') || (text[i] == '/' && text[i + 1] == '*')) text[i] = ' ';
  return text;
}

std::string define(const std::string& name, std::size_t value, const std::string& comment) {
  return "#define " + name + " " + std::to_string(value) + "  /* " + comment + " */\n";
}

std::string head(const Model& model, const std::string& name, const std::string& what) {
  return "/* " + name + ": " + what + " of model \"" + harmless(model.title) + "\"\n * (mesh " + model.mesh_hash +
         ", physics " + model.physics_hash + "). Written by phynness export; do not edit. */\n";
}

std::string guarded(const std::string& file, const std::string& text) {
  std::string guard = upper(file) + "_H";
  return "#ifndef " + guard + "\n#define " + guard + "\n\n" + text + "\n#endif\n";
}

constexpr const char* begin_c = "#ifdef __cplusplus\nextern \"C\" {\n#endif\n";
constexpr const char* end_c = "#ifdef __cplusplus\n}\n#endif\n";

/// Exact, and independent of the locale.
std::string number(double value) {
  const std::string text = number_text(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string vector(const Vec3& v) {
  std::string text = "{";
  for (std::size_t k = 0; k < 3; ++k) {
    if (k > 0) text += ", ";
    text += number(v[k]);
  }
  text += "}";
  return text;
}

}  // namespace

CSource c_source(const ModelImage& image, const Model& model, const std::string& name) {
  const bool floats = image.options.floats;
  const std::size_t word = image.real_bytes(), n_words = image.bytes.size() / word;
  const std::string type = floats ? "uint32_t" : "uint64_t", NAME = upper(name), real = floats ? "float" : "double";
  const std::string array = "const " + type + " " + name + "_image[" + std::to_string(n_words) + "]";
  std::string h =
      head(model, name, std::string("image for phn_image_open") + (floats ? " with PHYNNESS_IMAGE_FLOAT" : ""));
  h += "#include <stdint.h>\n\n";
  h += define(NAME + "_IMAGE_BYTES", image.bytes.size(), "flash: the array below");
  h += define(NAME + "_REAL_BYTES", word, "size of a number, a " + real);
  h += define(NAME + "_ACTIVE", image.n_active, "nodes that can be touched");
  h += define(NAME + "_OUTPUT", image.n_output, "nodes whose displacement is modelled; 0: forces only");
  h += define(NAME + "_TRIANGLES", image.n_triangles, "on which a tool can be between nodes; 0: at nodes only");
  h += define(NAME + "_SCRATCH", image.n_scratch, real + "s of scratch for a deformation");
  h += define(NAME + "_FIELD", 3 * image.n_output, real + "s of its result");
  h += define(NAME + "_RAM_BYTES", image.ram_bytes(), "scratch and result of a deformation; a force needs no memory");
  h += std::string("\n") + begin_c + "extern " + array + ";\n" + end_c;

  std::string c = head(model, name, "the image") + "#include \"" + name + ".h\"\n\n" + array + " = {";
  constexpr char digits[] = "0123456789abcdef";
  const std::size_t per_line = floats ? 8 : 4;
  for (std::size_t i = 0; i < n_words; ++i) {
    c += i % per_line == 0 ? "\n  0x" : " 0x";
    for (std::size_t b = word; b-- > 0;) {
      const auto byte = std::to_integer<unsigned>(image.bytes[i * word + b]);
      c += digits[byte >> 4];
      c += digits[byte & 15];
    }
    c += "u,";
  }
  c += "\n};\n";
  return {guarded(name, h), c};
}

CSource c_source(const GoldenQueries& queries, const Model& model, const std::string& name) {
  const std::string type = "struct " + name + "_query", n = std::to_string(queries.query.size());
  const std::string array = "const " + type + " " + name + "_golden[" + n + "]";
  std::string h = head(model, name, "responses of the runtime in double and of the image on the host");
  h += "#include <stdint.h>\n\n" + define(upper(name) + "_GOLDEN", queries.query.size(), "queries");
  h += std::string("\n") + begin_c + type +
       " {\n"
       "  int32_t node;                /* -1: the tool is at the place nearest to the point */\n"
       "  int32_t triangle;            /* of this place, as are the weights */\n"
       "  int32_t status;              /* of the image's force */\n"
       "  int32_t output;              /* position among the output nodes */\n"
       "  double point[3], weights[3];\n"
       "  double displacement[3];      /* [m] */\n"
       "  double force[3];             /* [N], by the runtime */\n"
       "  double image_force[3];       /* by the image; the same bits on a device, as below */\n"
       "  double bound, image_bound;   /* [N]; PHN_IMAGE_NO_BOUND: none */\n"
       "  double deformation[3];       /* of the output node [m], at nodes only */\n"
       "  double image_deformation[3];\n"
       "};\n"
       "extern " +
       array + ";\n" + end_c;
  std::string c = head(model, name, "golden queries") + "#include \"" + name + "_golden.h\"\n\n" + array + " = {\n";
  for (const auto& q : queries.query) {
    c += "  {";
    for (const std::int32_t value : {q.node, q.triangle, q.status, q.output}) c += std::to_string(value) + ", ";
    for (const auto* v : {&q.point_m, &q.weights, &q.displacement_m, &q.force_N, &q.image_force_N})
      c += vector(*v) + ", ";
    c += number(q.bound_N) + ", " + number(q.image_bound_N) + ", " + vector(q.deformation_m) + ", " +
         vector(q.image_deformation_m) + "},\n";
  }
  c += "};\n";
  return {guarded(name + "_golden", h), c};
}

}  // namespace phynness
