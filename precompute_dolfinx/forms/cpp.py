"""Formulas of law files as C++: a value that remembers how it was computed. Python's standard library is enough."""


def number(value):
    value = float(value)
    return repr(value) if value == value and abs(value) != float("inf") else "std::numeric_limits<double>::infinity()"


def literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


class Formula:
    """Operators keep their order and every bracket, so that C++ rounds as Python would."""

    def __init__(self, code):
        self.code = code

    def apply_function(self, name, arguments):
        return Formula(f"{name}({', '.join(code(a) for a in arguments)})")

    @property
    def T(self):
        return Formula(f"transpose({self.code})")

    def __pow__(self, exponent):
        if exponent != int(exponent) or exponent < 1:
            raise TypeError(f"power {exponent}: only whole positive ones are written here; use exp and ln for others")
        return Formula(f"power<{int(exponent)}>({self.code})")

    def __neg__(self):
        return Formula(f"(-{self.code})")


def code(value):
    return value.code if isinstance(value, Formula) else number(value)


def _add_operator(name, symbol):
    setattr(Formula, f"__{name}__", lambda a, b: Formula(f"({code(a)} {symbol} {code(b)})"))
    setattr(Formula, f"__r{name}__", lambda a, b: Formula(f"({code(b)} {symbol} {code(a)})"))


for _name, _symbol in {"add": "+", "sub": "-", "mul": "*", "truediv": "/"}.items():
    _add_operator(_name, _symbol)
for _name, _symbol in {"lt": "<", "le": "<=", "gt": ">", "ge": ">="}.items():
    setattr(Formula, f"__{_name}__", lambda a, b, s=_symbol: Formula(f"({code(a)} {s} {code(b)})"))
