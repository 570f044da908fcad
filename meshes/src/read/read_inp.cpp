// Decks of CalculiX and Abaqus: nodes, first-order solid elements, triangles and quadrilaterals, their sets as groups.
// Materials, steps and loads are skipped.
#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == text.npos ? std::string_view() : text.substr(begin, end - begin + 1);
}

std::vector<std::string_view> fields(std::string_view line) {
  std::vector<std::string_view> list;
  while (true) {
    const auto comma = line.find(',');
    list.push_back(trimmed(line.substr(0, comma)));
    if (comma == line.npos) break;
    line.remove_prefix(comma + 1);
  }
  if (list.back().empty()) list.pop_back();
  return list;
}

/// "*ELEMENT, TYPE=C3D4, ELSET=body"; names of cards and parameters are converted to capitals, values are not.
struct Card {
  std::string name;
  std::map<std::string, std::string> parameters;

  explicit Card(std::string_view line) {
    const auto parts = fields(line);
    if (!parts.empty()) name = upper(parts.front());
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const auto equals = parts[i].find('=');
      auto value = equals == parts[i].npos ? std::string_view() : trimmed(parts[i].substr(equals + 1));
      if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
      parameters[upper(trimmed(parts[i].substr(0, equals)))] = value;
    }
  }
  std::string value(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? "" : found->second;
  }
};

enum class Kind { solid, flat, line, other };

/// Kind and number of nodes, the first digit behind the letters, as in C3D8R and STRI3.
std::pair<Kind, std::size_t> kind_of(const std::string& type) {
  for (const auto prefix : {"T2D", "T3D", "B21", "B31", "MASS", "ROTARYI", "SPRING", "DASHPOT", "GAP", "CONN"})
    if (type.starts_with(prefix)) return {Kind::line, 0};
  for (const std::string prefix : {"C3D", "S", "STRI", "CPS", "CPE", "M3D", "SFM3D", "R3D"}) {
    const char n = type.starts_with(prefix) && type.size() > prefix.size() ? type[prefix.size()] : '0';
    if (prefix == "C3D" ? n == '4' || n == '5' || n == '6' || n == '8' : n == '3' || n == '4')
      return {prefix == "C3D" ? Kind::solid : Kind::flat, n - '0'};
  }
  return {Kind::other, 0};
}

class InpFile {
 public:
  InpFile(Scanner& scanner, const std::string& source) : _scanner(scanner), _here(scanner), _source(source) {}

  RawMesh read() {
    Card card("");
    while (next_line()) {
      if (_line.starts_with("**")) continue;
      if (_line.starts_with('*')) {
        require_no_rest();
        std::string whole(_line);
        while (whole.ends_with(',') && !data_follow() && next_line())
          if (!_line.starts_with("**")) whole += _line;
        card = Card(whole);
        begin(card);
      } else if (!_line.empty()) {
        if (card.name.empty() && !_line.starts_with(','))
          fail("not a deck of Abaqus or CalculiX: a line is before its first card", _line,
               "`meshio convert FILE mesh.vtu` reads the .inp of AVS");
        read_data(card);
      }
    }
    require_no_rest();
    finish_groups();
    if (_materials)
      _raw.notes.push_back("the deck's materials, sections, steps and loads are not used: the scene has its own");
    return std::move(_raw);
  }

 private:
  bool next_line() {
    if (_scanner.at_end()) return false;
    _here = _scanner;
    _line = trimmed(_scanner.line());
    return true;
  }

  /// Whether the next line begins with a number, so that a comma at the end of a card is one too many.
  bool data_follow() const {
    const std::string_view next = Scanner(_scanner).word_or_end();
    return !next.empty() && next.front() >= '0' && next.front() <= '9';
  }

  [[noreturn]] void fail(const std::string& what, std::string_view value, const std::string& remedy = again) const {
    _here.fail(what, value, remedy);
  }

  template <class Number>
  Number number(std::string_view text, const char* expected) const {
    std::string plain(text);  // may have a Fortran exponent
    std::replace(plain.begin(), plain.end(), 'D', 'E');
    std::replace(plain.begin(), plain.end(), 'd', 'e');
    return _here.parse<Number>(plain, expected);
  }

  void require_no_rest() const {
    if (!_pending.empty()) fail("an element has too few nodes", "element " + std::to_string(_pending.front()));
  }

  void begin(const Card& card) {
    static const std::set<std::string> unsupported = {"*INCLUDE", "*NCOPY", "*NFILL",  "*NGEN",    "*NMAP",
                                                      "*ELCOPY",  "*ELGEN", "*SYSTEM", "*SUBMODEL"};
    if (unsupported.contains(card.name) || !card.value("INPUT").empty())
      fail("the deck has a card for its mesh that is not supported", _line,
           "write all nodes and elements into the deck itself, in Cartesian coordinates");
    if (card.name == "*NODE" && !card.value("SYSTEM").empty() && upper(card.value("SYSTEM")) != "R")
      fail("the nodes are not in Cartesian coordinates", _line, "export the mesh in Cartesian coordinates");
    if (card.name == "*ELEMENT") begin_elements(card);
    if (card.name == "*NODE") _set = named(_node_sets, card.value("NSET"));
    if (card.name == "*NSET") {
      _set = required(_node_sets, card, "NSET");
      if (const std::string of = card.value("ELSET"); !of.empty()) _set->of_elements.push_back(upper(of));
    }
    if (card.name == "*ELSET") _set = required(_element_sets, card, "ELSET");
    _materials |= card.name == "*MATERIAL" || card.name.ends_with("SECTION");
    _generate = card.parameters.contains("GENERATE");
  }

  void begin_elements(const Card& card) {
    const std::string type = upper(card.value("TYPE"));
    std::tie(_kind, _corners) = kind_of(type);
    if (_kind == Kind::other)
      fail("elements of a type that is not supported", type.empty() ? _line : type,
           "mesh the body with 4-node tetrahedra (C3D4) and export it again");
    _set = named(_element_sets, card.value("ELSET"));
  }

  struct Set {
    std::string name;
    std::vector<std::int64_t> numbers;
    std::vector<std::string> sets, of_elements;  ///< names in capitals; the nodes of these sets of elements
  };
  using Sets = std::map<std::string, Set>;

  static Set* named(Sets& sets, const std::string& name) {
    if (name.empty()) return nullptr;
    auto& set = sets[upper(name)];
    if (set.name.empty()) set.name = name;
    return &set;
  }
  Set* required(Sets& sets, const Card& card, const char* key) const {
    if (Set* set = named(sets, card.value(key))) return set;
    fail("a set has no name", _line, std::string("write ") + key + "=NAME");
  }

  void read_data(const Card& card) {
    if (card.name == "*NODE") read_node();
    if (card.name == "*ELEMENT" && _kind != Kind::line) read_element();
    if (card.name == "*NSET" || card.name == "*ELSET") read_set();
    if (card.name == "*INSTANCE")
      fail("an instance of a part is moved or turned", _line,
           "write only the part, with the final positions of its nodes");
  }

  void read_node() {
    const auto parts = fields(_line);
    if (parts.size() < 2 || parts.size() > 7)  // a normal may follow the coordinates
      fail("a node does not have a number and three coordinates", _line);
    const auto tag = number<std::int64_t>(parts[0], "a node's number");
    if (!_position.emplace(tag, static_cast<std::int32_t>(_raw.nodes.size())).second)
      fail("two nodes have the same number", std::to_string(tag), "write one part with its own numbers");
    auto& x = _raw.nodes.emplace_back(std::array<double, 3>{});
    for (std::size_t k = 1; k < std::min<std::size_t>(parts.size(), 4); ++k)
      if (!parts[k].empty()) x[k - 1] = number<double>(parts[k], "a node's coordinate");  // an empty field is 0
    if (_set) _set->numbers.push_back(tag);
  }

  void read_element() {
    for (const auto field : fields(_line))
      _pending.push_back(number<std::int64_t>(field, "an element's number or node"));
    const std::size_t size = 1 + _corners;
    if (_pending.size() > size) fail("an element has too many nodes", "element " + std::to_string(_pending.front()));
    if (_pending.size() < size) return;  // it continues in the next line
    const std::int64_t tag = _pending.front();
    std::vector<std::int32_t> nodes;
    for (std::size_t k = 1; k < size; ++k) nodes.push_back(position(_pending[k], "element " + std::to_string(tag)));
    if (!_elements.emplace(tag, nodes).second)
      fail("two elements have the same number", std::to_string(tag), "write one part with its own numbers");
    if (_kind == Kind::solid)
      _raw.add_cell(nodes);
    else
      _raw.add_polygon(nodes);
    if (_set) _set->numbers.push_back(tag);
    _pending.clear();
  }

  std::int32_t position(std::int64_t tag, const std::string& user) const {
    const auto found = _position.find(tag);
    if (found == _position.end())
      fail(user + " uses a node that is not in the file above it", "node " + std::to_string(tag));
    return found->second;
  }

  void read_set() {
    const auto parts = fields(_line);
    if (_generate) {
      std::array<std::int64_t, 3> range{0, 0, 1};
      if (parts.size() < 2 || parts.size() > 3) fail("a generated set needs first, last and step", _line);
      for (std::size_t k = 0; k < parts.size(); ++k) range[k] = number<std::int64_t>(parts[k], "a set's range");
      const std::size_t known = _raw.nodes.size() + _elements.size();
      if (range[2] < 1 || range[0] < 0 || range[1] < range[0] ||
          static_cast<std::uint64_t>((range[1] - range[0]) / range[2]) > known)
        fail("a generated set has an impossible range", _line);
      for (std::int64_t i = range[0]; i <= range[1]; i += range[2]) _set->numbers.push_back(i);
      return;
    }
    for (const auto field : parts) {
      if (field.empty()) continue;
      const bool is_number = field.find_first_not_of("0123456789") == field.npos;
      if (is_number)
        _set->numbers.push_back(number<std::int64_t>(field, "a set's number"));
      else
        _set->sets.push_back(upper(field));
    }
  }

  /// Calls visit with a set and the sets that it names, each once.
  template <class Visit>
  void for_each_of(const Sets& sets, const std::string& name, const Visit& visit) const {
    std::set<std::string> seen{name};
    std::vector<std::string> open{name};
    while (!open.empty()) {
      const auto found = sets.find(open.back());
      if (found == sets.end())
        throw input_error(_source + ": a set names another one that is not in the file", open.back(), again);
      open.pop_back();
      visit(found->second);
      for (const auto& other : found->second.sets)
        if (seen.insert(other).second) open.push_back(other);
    }
  }

  /// The corners of each element of a set.
  std::vector<std::vector<std::int32_t>> elements_of(const std::string& name) const {
    std::vector<std::vector<std::int32_t>> elements;
    for_each_of(_element_sets, name, [&](const Set& set) {
      for (const std::int64_t tag : set.numbers)
        if (const auto found = _elements.find(tag); found != _elements.end()) elements.push_back(found->second);
    });
    return elements;
  }
  std::set<std::int32_t> nodes_of_elements(const std::string& name) const {
    std::set<std::int32_t> nodes;
    for (const auto& element : elements_of(name)) nodes.insert(element.begin(), element.end());
    return nodes;
  }

  void add_group(const std::string& name, const std::set<std::int32_t>& nodes) {
    if (nodes.empty())
      _raw.notes.push_back("the set " + name + " holds nothing that is read");
    else
      _raw.groups[name].assign(nodes.begin(), nodes.end());
  }

  void finish_groups() {
    for (const auto& [key, set] : _node_sets) {
      std::set<std::int32_t> nodes;
      for_each_of(_node_sets, key, [&](const Set& part) {
        for (const std::int64_t tag : part.numbers)
          if (const auto found = _position.find(tag); found != _position.end()) nodes.insert(found->second);
        for (const auto& elements : part.of_elements) nodes.merge(nodes_of_elements(elements));
      });
      add_group(set.name, nodes);
    }
    for (const auto& [key, set] : _element_sets) {
      std::string name = set.name;
      if (_node_sets.contains(key)) {
        name = "elements " + set.name;
        _raw.notes.push_back("a set of nodes and one of elements are both called " + set.name + ": the group '" + name +
                             "' holds the nodes of the elements");
      }
      add_group(name, nodes_of_elements(key));
      _raw.cell_groups[name] = elements_of(key);
    }
  }

  Scanner& _scanner;
  Scanner _here;  ///< position at the beginning of the line
  const std::string& _source;
  std::string_view _line;
  RawMesh _raw;
  Kind _kind = Kind::other;
  Set* _set = nullptr;
  std::size_t _corners = 0;
  bool _generate = false, _materials = false;
  Sets _node_sets, _element_sets;
  std::vector<std::int64_t> _pending;  ///< number and nodes of an incomplete element
  std::unordered_map<std::int64_t, std::int32_t> _position;
  std::unordered_map<std::int64_t, std::vector<std::int32_t>> _elements;
};

}  // namespace

RawMesh read_inp(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  return InpFile(scanner, source).read();
}

}  // namespace phynness::meshes
