"""Generates texts from the grammar of formats/model.md with arbitrary numbers (model_grammar.py)."""
import math
import re

from model_grammar import Refused


def text_of(kind, value):
    """As std::to_chars writes it."""
    if kind != "float":
        return str(value)
    if value == 0:
        return "-0p+0" if math.copysign(1, value) < 0 else "0p+0"
    return re.sub(r"\.?0*p", "p", value.hex().replace("0x", ""), count=1)


class Maker:
    """Makes up a text. met: the conditions on its values.
    With a condition, the first value that it is on and for which `choose(kind, names)` finds a number gets that number,
    allowed or not; hit: whether there was one. Later values are as the conditions want, as far as that is possible."""

    def __init__(self, grammar, random, condition=None, choose=None):
        self.random, self.condition, self.choose, self.hit = random, condition, choose, False
        self.lines, self.counts, self.met = [], grammar.counts, set()
        try:
            grammar.walk(self)
        except Refused:
            if not self.hit:
                raise
        self.text = "\n".join(self.lines) + "\n"

    def begin(self):
        self.lines.append("")

    def word(self, word):
        self.lines[-1] += " " * bool(self.lines[-1]) + word

    def value(self, kind, name, conditions, names):
        if kind == "text":
            return self.word(self.random.choice(["some words", "x"]))
        value = None
        self.met.update(conditions)
        if self.condition in conditions and not self.hit:
            value = self.choose(kind, names)
            self.hit = value is not None
        if value is None:
            value = self.allowed(kind, name, conditions, names)
        if name:
            names.bind(name, value)
            names.frames[-1][name] = value
        self.word(text_of(kind, value))

    def candidates(self, kind, name, conditions, names):
        for condition in conditions:
            if condition.kind == "in":
                found = condition.choices(names)
                return self.random.sample(found, len(found))
            if condition.kind == "ascending":
                least = names.frames[-1].get(condition.subject, -1) + 1
                return [least + self.random.choice([0, 0, 1]), least]
        if kind in ("int", "signed"):
            first = self.random.choice([0, 1, 1, 2, 2, 3]) if name in self.counts else self.random.randrange(8, 40)
            return [first] + self.random.sample(range(7), 7)
        return [self.random.choice([1, 1, -1]) * self.random.uniform(0.01, 1), self.random.uniform(0.01, 1)]

    def allowed(self, kind, name, conditions, names):
        if kind == "16 hexadecimal digits":
            return "0" * 16
        if kind == "word":
            found = self.candidates(kind, name, conditions, names)
            return found[0] if isinstance(found[0], str) else "word"
        for value in self.candidates(kind, name, conditions, names):
            if not name:
                return value
            names[names.key(name)] = value
            if all(condition(names, value) for condition in conditions):
                return value
        if self.hit:  # and the number put in leaves no other
            return 1
        raise Refused("no value for " + name)

    def end(self):
        pass

    def follows(self, word):
        return self.random.random() < 0.7
