"""Conversion of formulas of law files to C++. A Formula is a value that records its computation as C++ code.

Needs Python's standard library only.
"""


def number(value):
    value = float(value)
    return repr(value) if value == value and abs(value) != float("inf") else "std::numeric_limits<double>::infinity()"


def literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


class Formula:
    """C++ code of a formula: an operation such as "({} + {})" and its operands, or a symbol. The order of operators and
    all brackets are kept, so that C++ rounds as Python.
    """

    def __init__(self, operation, *operands):
        self.operation, self.operands = operation, operands
        self.code = operation.format(*map(code, operands))

    def apply_function(self, name, arguments):
        return Formula(f"{name}({', '.join('{}' for _ in arguments)})", *arguments)

    @property
    def T(self):
        return Formula("transpose({})", self)

    def __pow__(self, exponent):
        if isinstance(exponent, Formula) or exponent != int(exponent) or exponent < 1:
            raise TypeError(
                f"the exponent {code(exponent)} is not a positive integer: write x**a as exp(a * ln(x)), and x**-1 as 1 / x"
            )
        return Formula(f"power<{int(exponent)}>({{}})", self)

    def __neg__(self):
        return Formula("(-{})", self)


def code(value):
    return value.code if isinstance(value, Formula) else number(value)


def _add_operator(name, symbol):
    setattr(Formula, f"__{name}__", lambda a, b: Formula(f"({{}} {symbol} {{}})", a, b))
    setattr(Formula, f"__r{name}__", lambda a, b: Formula(f"({{}} {symbol} {{}})", b, a))


for _name, _symbol in {"add": "+", "sub": "-", "mul": "*", "truediv": "/"}.items():
    _add_operator(_name, _symbol)
for _name, _symbol in {"lt": "<", "le": "<=", "gt": ">", "ge": ">="}.items():
    setattr(Formula, f"__{_name}__", lambda a, b, s=_symbol: Formula(f"({{}} {s} {{}})", a, b))
