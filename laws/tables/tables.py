"""Generates source files from the law files and the table of elements. Needs Python's standard library only.

Usage: tables.py FOLDER

    FOLDER/tables.cpp           laws() and elements() of formats/include/phynness/formats/law.hpp
    FOLDER/compiled_forms.cpp   compiled_forms() of precompute_dolfinx/src/solve/form_set.hpp: the forms that ffcx compiles from the files below
    FOLDER/declared_laws.cpp    energies and examples with which tests compare the compiled forms
    FOLDER/body_laws.cpp        find_body_law() of runtime/include/phynness/schema/body_laws.hpp
    FOLDER/forms/*.py           a file for ffcx for each law, and one for each law of shells

Prints two lines with the names of these files, for solids and for shells, each as a CMake list. A file is only written
if its content changes.
"""

import sys
from pathlib import Path

from cpp import Formula, code, literal, number
from derivative import with_derivative
from element_table import ELEMENTS, FIELDS, JACOBIANS, SOLIDS
from law import LawError, call, every_law

NOTE = "// Made by laws/tables/tables.py; law files and element_table.py are what to edit.\n"
DOUBLE = "[[maybe_unused]] const double "


def _values(quantities, source):
    return [f"{DOUBLE}{q.symbol} = {source}[{i}];" for i, q in enumerate(quantities)]


def _formulas(quantities):
    return {q.symbol: Formula(q.symbol) for q in quantities}


def _array(kind, name, rows):
    """Code of a constant array and of a span over it. Without rows there is no array, because C++ has no empty arrays.
    """
    if not rows:
        return "", "{}"
    return f"constexpr {kind} {name}[] = {{\n  " + ",\n  ".join(rows) + "};\n", name


def _function(head, lines):
    return head + " {\n  " + "\n  ".join(lines) + "\n}\n"


def _conversion(law, accepted, name):
    """Code that computes parameters and moduli at rest from the given numbers, in the order of the law file."""
    lines = _values(accepted.given, "given")
    known = _formulas(accepted.given)
    for symbol, function in accepted.gives.items():
        lines.append(f"{DOUBLE}{symbol} = {code(call(function, **known))};")
        known[symbol] = Formula(symbol)
    for i, p in enumerate(law.parameters):
        lines.append(f"parameters[{i}] = {p.symbol};")
    # Symbols that neither the scene nor the set gives follow from the law's moduli at rest.
    for symbol, value in {"mu": lambda: call(law.shear_modulus, **known), "K": lambda: call(law.bulk_modulus, **known),
                          "lmbda": lambda: known["K"] - 2 * known["mu"] / 3}.items():  # fmt: skip
        if symbol not in known:
            lines.append(f"const double {symbol} = {code(value())};")
            known[symbol] = Formula(symbol)
    lines.append("moduli = {mu, lmbda, K};")
    return _function(f"void {name}([[maybe_unused]] const double* given, double* parameters, Moduli& moduli)", lines)


def _accepted(law):
    text, rows = "", []
    for i, accepted in enumerate(law.accepted):
        name = f"{law.identifier}_{i}"
        keys = [f"{{{literal(q.key)}, {number(q.low)}, {number(q.high)}, {str(q.low_open).lower()}, "
                f"{str(q.high_open).lower()}}}" for q in accepted.given]  # fmt: skip
        keys, keys_span = _array("LawKey", f"{name}_keys", keys)
        bounds = []
        symbols = [q.symbol for q in accepted.given]
        for j, bound in enumerate(accepted.bounds):
            before = {s: Formula(s) for s in symbols} | {"K": Formula("K")}
            lines = _values(accepted.given, "given")
            if "K" not in symbols and "K" in accepted.gives:
                lines.append(f"{DOUBLE}K = {code(call(accepted.gives['K'], **before))};")
            lines.append(f"return {code(call(bound.value, **before))};")
            text += _function(f"double {name}_bound_{j}([[maybe_unused]] const double* given)", lines)
            bounds.append(f"{{{symbols.index(bound.symbol)}, {str(bound.greater).lower()}, {name}_bound_{j}, "
                          f"{literal(bound.what)}, {literal(bound.remedy)}}}")  # fmt: skip
        bounds, bounds_span = _array("LawBound", f"{name}_bounds", bounds)
        text += keys + bounds + _conversion(law, accepted, f"{name}_convert")
        rows.append(f"{{{keys_span}, {bounds_span}, {name}_convert}}")
    sets, span = _array("LawSet", f"{law.identifier}_accepted", rows)
    return text + sets, span


def _row(law):
    rows = [f"{{{literal(p.key)}, {literal(p.symbol)}, {str(p.is_modulus).lower()}}}" for p in law.parameters]
    parameters, parameters_span = _array("LawParameter", f"{law.identifier}_parameters", rows)
    text, rows = parameters, []
    for function in law.derived:
        name = function.__name__
        lines = _values(law.parameters, "parameters") + [f"return {code(call(function, **_formulas(law.parameters)))};"]
        text += _function(f"double {law.identifier}_{name}([[maybe_unused]] const double* parameters)", lines)
        rows.append(f"{{{literal(name)}, {law.identifier}_{name}}}")
    derived, derived_span = _array("LawConstant", f"{law.identifier}_derived", rows)
    accepted, accepted_span = _accepted(law)
    flags = ", ".join(str(f).lower() for f in (not law.finite, law.isochoric, law.plane_stress is not None))
    return text + derived + accepted, (
        f"{{{literal(law.name)}, {parameters_span}, {accepted_span}, {derived_span}, {flags}, "
        f"{number(law.shell_from)}}}"
    )


def _element_row(element):
    flags = (element.pressure_degree is not None, element.is_shell)
    rows = ["{" + ", ".join(number(float(x)) for x in row) + "}" for row in element.force_ratios]
    ratios, span = _array("ForceRatio", f"{element.identifier}_force_ratios", rows)
    return ratios, (f"{{{literal(element.name)}, {element.displacement_degree}, "
                    f"{', '.join(str(f).lower() for f in flags)}, {span}}}")  # fmt: skip


def tables(laws):
    texts, rows = zip(*(_row(law) for law in laws))
    element_texts, element_rows = zip(*(_element_row(e) for e in ELEMENTS))
    return (
        NOTE + "#include <limits>\n#include <phynness/formats/law.hpp>\n\nnamespace phynness {\nnamespace {\n\n"
        + "\n".join(texts)
        + _array("LawRow", "every_law", rows)[0]
        + "".join(element_texts)
        + _array("ElementRow", "every_element", element_rows)[0]
        + "\n}  // namespace\n\nstd::span<const LawRow> laws() { return every_law; }\n"
        "std::span<const ElementRow> elements() { return every_element; }\n\n}  // namespace phynness\n"
    )  # fmt: skip


def compiled_forms(laws):
    includes, cases = [], []
    for law in laws:
        includes.append(f"#include <{law.identifier}.h>")
        rows = []
        J = {key: f"expression_{law.identifier}_{i}" for i, key in enumerate(JACOBIANS)}
        for e in SOLIDS:
            form = f"form_{law.identifier}_{e.identifier}_"
            fields = ", ".join(form + name for name in FIELDS)
            edge = f"form_{law.identifier}_edge_"
            edges = f"{edge}energy, {edge}residual, {edge}tangent, {J['edge']}"
            rows.append(f"{{{form}energy, {form}residual, {form}tangent, {{{{{fields}}}}}, "
                        f"{J[e.displacement_degree, e.pressure_degree]}, nullptr, nullptr, nullptr, "
                        f"{{{edges if e.edge_smoothed else ''}}}}}")  # fmt: skip
        if law.plane_stress:
            includes.append(f"#include <shell_{law.identifier}.h>")
            form = f"form_shell_{law.identifier}_"
            rows.append(f"{{{form}energy, {form}residual, {form}tangent, {{}}, "
                        f"expression_shell_{law.identifier}_orientation, {form}gauge_energy, {form}gauge_residual, "
                        f"{form}gauge_tangent, {{}}}}")  # fmt: skip
        else:
            rows.append("{}")
        cases.append("{{\n    " + ",\n    ".join(rows) + "}}")
    return (
        NOTE + '#include "solve/form_set.hpp"\n\n#include <array>\n\n' + "\n".join(includes)
        + f"\n\nnamespace phynness {{\n\nstatic_assert(every_field.size() == {len(FIELDS)}, \"FIELDS of element_table.py lists "
        "other fields than formats/fields.hpp\");\n\nCompiledForms compiled_forms(Law law, Element element) {\n"
        f"  const std::array<CompiledForms, {len(ELEMENTS)}> forms[] = {{\n  " + ",\n  ".join(cases)
        + "};\n  return forms[law - laws().data()][static_cast<std::size_t>(element - elements().data())];\n}\n\n"
        "}  // namespace phynness\n"
    )  # fmt: skip


def declared_laws(laws):
    text, rows = "", []
    for law in laws:
        values, known, F = _values(law.parameters, "p"), _formulas(law.parameters), Formula("F")
        shape, volumetric = call(law.shape, F, **known), call(law.volumetric, F, **known)
        kappa = known[law.kappa]
        results = {"energy": shape + kappa / 2 * volumetric**2, "pressure": kappa * volumetric}
        if law.inside:
            results["inside"] = call(law.inside, F, **known)
        for name, result in results.items():
            text += _function(f"template <class T>\nT {name}_of_{law.identifier}(const Tensor<T>& F, const double* p)",
                              values + [f"return {code(result)};"])  # fmt: skip
        example = law.example(Formula("K"))
        text += _function(f"std::vector<double> example_of_{law.identifier}([[maybe_unused]] double K)",
                          ["return {" + ", ".join(code(example[p.symbol]) for p in law.parameters) + "};"])  # fmt: skip
        word = law.identifier
        rows.append(f"{{energy_of_{word}<double>, energy_of_{word}<std::complex<double>>, pressure_of_{word}<double>, "
                    f"{f'inside_of_{word}<double>' if law.inside else 'nullptr'}, example_of_{word}}}")  # fmt: skip
    return (
        NOTE + '#include "closed_forms.hpp"\n#include "tensor_functions.hpp"\n\nnamespace phynness::test {\nnamespace {\n\n'
        + text + "\n}  // namespace\n\nconst DeclaredLaw& declared(Law law) {\n  static const DeclaredLaw of_every_law[] = {\n    "
        + ",\n    ".join(rows) + "};\n  return of_every_law[law - laws().data()];\n}\n\n}  // namespace phynness::test\n"
    )  # fmt: skip


def body_laws(laws):
    text, rows = "", []
    for law in laws:
        word, values, known, F = law.identifier, _values(law.parameters, "p"), _formulas(law.parameters), Formula("F")
        for f in law.derived:
            values.append(f"{DOUBLE}{f.__name__} = {code(call(f, **known))};")
        known |= {f.__name__: Formula(f.__name__) for f in law.derived}
        for part, function in {"shape": law.shape, "volumetric": law.of_pressure or law.volumetric}.items():
            text += _function(f"template <class T>\nT {part}_of_{word}(const Tensor<T>& F, const double* p, Tensor<T>& first)",
                              values + with_derivative(call(function, F, **known)))  # fmt: skip
        inside = [f"return {code(call(law.inside, F, **known)) if law.inside else 1};"]
        text += _function(f"double inside_of_{word}([[maybe_unused]] const Tensor<double>& F, const double* p)",
                          values + ["if (!(det(F) > 0)) return 0;"] * law.finite + inside)  # fmt: skip
        parts = [f"derivatives<{part}_of_{word}, {part}_of_{word}, inside_of_{word}>" for part in ("shape", "volumetric")]
        rows.append(f"{{{literal(law.name)}, {len(law.parameters)}, {', '.join(parts)}}}")
    return (
        NOTE + '#include <phynness/schema/body_laws.hpp>\n#include <string.h>\n\n#include "body/dual.hpp"\n\nnamespace PHN_RUNTIME {\nnamespace {\n\n'
        + text + _array("BodyLaw", "every_law", rows)[0]
        + "\n}  // namespace\n\nconst BodyLaw* find_body_law(const char* name) {\n  for (const auto& law : every_law)\n"
        "    if (strcmp(law.name, name) == 0) return &law;\n  return nullptr;\n}\n\n}  // namespace PHN_RUNTIME\n"
    )  # fmt: skip


def _write(path, text):
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def main(folder):
    laws = every_law()
    shells = [law.identifier for law in laws if law.plane_stress]
    folder = Path(folder)
    (folder / "forms").mkdir(parents=True, exist_ok=True)
    for text in (tables, compiled_forms, declared_laws, body_laws):
        _write(folder / f"{text.__name__}.cpp", text(laws))
    for kind, prefix, chosen in (("solids", "", [law.identifier for law in laws]), ("shells", "shell_", shells)):
        for identifier in chosen:
            _write(folder / "forms" / f"{prefix}{identifier}.py",
                   f'from law_forms import {kind}\n\nglobals().update({kind}("{identifier}"))\n')  # fmt: skip
    print(";".join(law.identifier for law in laws))
    print(";".join(f"shell_{identifier}" for identifier in shells))


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except LawError as error:
        sys.exit(str(error))
