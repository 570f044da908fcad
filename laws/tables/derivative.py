"""C++ code of a formula and of its derivative with respect to the tensor F, in reverse mode (Griewank and Walther 2008,
doi 10.1137/1.9780898717761): every operation, from the last to the first, adds to the derivatives with respect to its
operands. Needs Python's standard library only.
"""

from cpp import Formula, code

# What an operation t = f(a, b) with the derivative g with respect to t adds for its operands. With tensors: see _rules.
RULES = {
    "({} + {})": ("{g}", "{g}"),
    "({} - {})": ("{g}", "-{g}"),
    "({} * {})": ("{g} * {b}", "{g} * {a}"),
    "({} / {})": ("{g} / {b}", "-({g} * {t}) / {b}"),
    "(-{})": ("-{g}",),
    "exp({})": ("{g} * {t}",),
    "ln({})": ("{g} / {a}",),
    "sinh({})": ("{g} * (exp({a}) + exp(-{a})) / 2.0",),
    "sqrt({})": ("{g} / (2.0 * {t})",),
    "det({})": ("{g} * cofactors({a})",),
    "inner({}, {})": ("{g} * {b}", "{g} * {a}"),
    "tr({})": ("{g} * identity({a})",),
    "sym({})": ("sym({g})",),
    "transpose({})": ("transpose({g})",),
}


def _rules(operation, tensors):
    """@param tensors  of each operand, whether it is a tensor"""
    if operation == "({} * {})" and any(tensors):
        number = "inner({g}, {b})" if tensors[1] else "inner({g}, {a})"
        return {(True, True): ("{g} * transpose({b})", "transpose({a}) * {g}"), (False, True): (number, "{g} * {a}"),
                (True, False): ("{g} * {b}", number)}[tensors]  # fmt: skip
    if operation == "({} / {})" and tensors[0]:
        return "{g} / {b}", "-inner({g}, {t}) / {b}"
    if operation.startswith("power<"):
        n = int(operation[len("power<") : operation.index(">")])
        return ("{g}" if n == 1 else f"{{g}} * ({n}.0 * power<{n - 1}>({{a}}))",)
    return RULES[operation]


def with_derivative(formula):
    """Lines that compute a number and assign its derivative to the tensor `first`, and return the number."""
    names, tensors, moves, steps, lines = {"F": "F"}, {"F"}, {"F"}, [], []

    def visit(x):
        if not isinstance(x, Formula) or not x.operands:
            return code(x)
        if x.code not in names:
            operands = [visit(o) for o in x.operands]
            name = f"t{len(names)}"
            names[x.code] = name
            steps.append((name, x.operation, operands))
            if x.operation not in ("det({})", "tr({})", "inner({}, {})") and tensors.intersection(operands):
                tensors.add(name)
            if x.operation != "identity({})" and moves.intersection(operands):
                moves.add(name)
            lines.append(f"const auto {name} = {x.operation.format(*operands)};")
        return names[x.code]

    result = visit(formula)
    slopes = {result: ["1.0"]}
    for name, operation, operands in reversed(steps):
        if name not in moves:
            continue
        g = f"d{name}"
        lines.append(f"const auto {g} = {' + '.join(slopes[name])};")
        a, b = (*operands, "")[:2]
        for operand, rule in zip(operands, _rules(operation, tuple(o in tensors for o in operands))):
            if operand in moves:
                slopes.setdefault(operand, []).append(rule.format(g=g, t=name, a=a, b=b))
    return [*lines, f"first = {' + '.join(slopes['F'])};", f"return {result};"]
