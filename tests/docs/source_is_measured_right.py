#!/usr/bin/env python3
"""Claim: tools/measure-source counts correctly. For a small artificial tree all figures are known. Text that resembles
code (comments, strings, raw strings, digit separators) or a function (initializing braces, classes, namespaces) does
not change them.

Usage: source_is_measured_right.py TOOL
"""
import json
import os
import subprocess
import sys
import tempfile

TREE = {
    # Functions of 1, 6, 9, 4, 3 and 5 lines; their names and lines are checked below.
    "core/a.cpp": r'''#include <x>
#define OPEN {            \
  never closed
namespace {
struct Pair { int a{1}, b = {2}; int sum() const { return a + b; } };
const std::vector<int> table = {1, 2, {3}};
const char* const text = "}{ \" Family:: { // no comment";
/* Family:: { { */
template <class T, class = std::enable_if_t<(sizeof(T) > 1)>>
T
larger(T a, T b) {
  // a brace in a comment {
  return a < b ? b : a;
}
}  // namespace

class Thing : public Base {
 public:
  Thing(int x)
      : _x{x}, _y(f({1, 2})),
        _z{} {
    const auto nested = [&](int i) {
      if (i == '{') return 1'000;
      return i;
    };
    nested(_x);
  }
 private:
  int _x{0};
};

std::string raw() {
  return R"(one } " { Family::rbfn
)" R"x(two )" } )x";
}
template <class T, int (*destroy)(T*)>
class Handle {
  ~Handle() {
    destroy(&_t);
  }
};
const auto named = [](int a) {
  return a;
};
bool operator==(const Thing& a,
                const Thing& b) {
  switch (a.x()) { default: break; }
  return true;
}
''',
    "core/b.cpp": 'int f(Family family) { return family == Family::rbfn; }\nauto k = "trained_depth";\n',
    "core/c.hpp": '// Family::rbfn, "trained_depth"\nconst char* other = "trained_depth_m";\n',
    "core/rbfn/d.cpp": "int g(Family f) { return f == Family::rbfn; }\n",
    "runtime/include/phynness/phynness.h": '''#ifdef __cplusplus
extern "C" {
#endif
typedef struct phn_model phn_model;
typedef void (*phn_callback)(int);
typedef struct phn_info { int n; } phn_info;
/* phn_commented(int); */
enum phn_status { PHN_OK = 0 };
size_t phn_size(const char* text,
                size_t n);
const char* phn_message(enum phn_status status);
#ifdef __cplusplus
}
#endif
''',
    "tool": '#!/usr/bin/env python3\ndef f():\n    def inner():\n        return "{"\n    return inner\n',
    "script": "#!/bin/sh\ntrue\n",
    "notes.md": "Family::rbfn\n" * 900,
    "tests/t.cpp": "int t() { return Family::rbfn; }\n" * 500,
    "docs/d.py": "x = 1\n" * 500,
}

EXPECTED_FUNCTIONS = [  # of several lines: lines, file, line, name
    (9, "core/a.cpp", 19, "Thing"),
    (6, "core/a.cpp", 9, "larger"),
    (5, "core/a.cpp", 45, "operator=="),
    (4, "core/a.cpp", 32, "raw"),
    (4, "tool", 2, "f"),
    (3, "core/a.cpp", 38, "~Handle"),
    (3, "core/a.cpp", 42, "lambda"),
]


def expect(what, found, wanted):
    if found != wanted:
        sys.exit(f"{what}: found {found}, expected {wanted}")


def main():
    with tempfile.TemporaryDirectory() as root:
        for path, text in TREE.items():
            file = os.path.join(root, path)
            os.makedirs(os.path.dirname(file), exist_ok=True)
            with open(file, "w", encoding="utf-8") as out:
                out.write(text)
        figures_file = os.path.join(root, "figures.json")
        run = subprocess.run([sys.argv[1], "--root", root, "--json", figures_file, "--over", "0"],
                             check=True, capture_output=True, text=True)
        with open(figures_file, encoding="utf-8") as file:
            figures = json.load(file)
    listed = [line.split() for line in run.stdout.splitlines() if line.startswith(" ")]
    functions = [(int(row[0]), *row[1].rsplit(":", 1), row[2]) for row in listed if len(row) == 3]
    expect("functions", [(n, file, int(line), name) for n, file, line, name in functions], EXPECTED_FUNCTIONS)
    expect("family files", figures["family_files_list"], ["core/b.cpp"])
    expect("grammars", figures["grammars_list"], ["core/b.cpp"])
    expect("core functions", figures["core_functions"], 2)
    expect("longest function", figures["longest_function"],
           {"lines": 9, "file": "core/a.cpp", "line": 19, "name": "Thing"})
    expect("longest file", figures["longest_file"], {"lines": TREE["core/a.cpp"].count("\n"), "file": "core/a.cpp"})
    sources = [path for path in TREE if path.startswith(("core/", "runtime/")) or path == "tool"]
    expect("lines", figures["lines"], sum(TREE[path].count("\n") for path in sources))
    expect("other lines", figures["lines_other"], 2)


if __name__ == "__main__":
    main()
