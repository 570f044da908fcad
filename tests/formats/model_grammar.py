"""The grammar of formats/model.md as a program that reads a model.txt.

The notation is described there under "Grammar". `Grammar.walk` follows the grammar; with it a Reader checks a text. It
uses nothing but the blocks of the page.
"""
import re


class Refused(Exception):
    """The text is not as the grammar says."""


NORMAL, SUBNORMAL = r"1(?:\.[0-9a-f]{1,13})?p[+-][0-9]{1,4}", r"0\.(?=0*[1-9a-f])[0-9a-f]{1,13}p-1022"
ZERO = r"0(?:\.0{1,13})?p[+-]0{1,4}"
TOKENS = {
    "int": re.compile(r"[0-9]{1,10}"),
    "signed": re.compile(r"-?[0-9]{1,10}"),
    "float": re.compile("-?(?:%s|%s|%s)" % (NORMAL, SUBNORMAL, ZERO)),
    "word": re.compile(r"[!-~]{1,40}"),
    "16 hexadecimal digits": re.compile(r"[0-9a-f]{16}"),
}


def value_of(kind, token):
    if not TOKENS[kind].fullmatch(token):
        raise Refused("%r is not <%s>" % (token, kind))
    if kind in ("int", "signed"):
        return int(token)
    if kind != "float":
        return token
    digits, exponent = token.lstrip("-").split("p")
    if digits[0] == "1" and not -1022 <= int(exponent) <= 1023:
        raise Refused("%r is no finite double" % token)
    return float.fromhex(token)


class Names(dict):
    """Values by name. Those of a name with subscripts differ by the turns of `for` that it is named in."""

    def __init__(self):
        super().__init__()
        self.turn, self.all, self.frames = {}, {}, [{}]

    def key(self, name):
        if "_" not in name:
            return name
        return (name,) + tuple(self.turn[letter] for letter in name.rpartition("_")[2])

    def __getitem__(self, name):
        if name in self.turn:
            return self.turn[name]
        return super().__getitem__(self.key(name))

    def bind(self, name, value):
        self[self.key(name)] = value
        self.all.setdefault(name, set()).add(value)


FUNCTIONS = {"__builtins__": {}, "min": min, "abs": abs}


class Expression:
    def __init__(self, text):
        self.text = text
        python = re.sub(r"\|(\w+)\|", r"abs(\1)", text).replace(" mod ", " % ")
        self.code = compile(re.sub(r"(?<![<>=!])=(?!=)", "==", python), text, "eval")

    def __call__(self, names):
        return eval(self.code, FUNCTIONS, names)


class Condition:
    """On one value of a line, the subject. @param declared  names of the line"""

    def __init__(self, text, declared):
        self.text, self.bounds = text, []
        if text.endswith(" ascending"):
            self.kind, self.subject = "ascending", text.split(" ")[0]
        elif " in " in text:
            self.kind, self.subject = "in", text.split(" ")[0]
            self.sets = text.split(" in ")[1].split(", ")
        else:
            self.kind, self.holds = "compare", Expression(text)
            here = set(re.findall(r"[A-Za-z]\w*", text)) & declared
            if len(here) != 1:
                raise ValueError("condition %r is not on one value of its line" % text)
            self.subject = here.pop()
            self.find_bounds(re.split(r" (<=|>=|<|>) ", text))
        if self.subject not in declared:
            raise ValueError("condition %r is not on a value of its line" % text)

    def find_bounds(self, chain):
        """(sense, strict, size, bound): sense +1 is an upper bound; size: of |x|."""
        for at in range(1, len(chain), 2):
            left, operator, right = chain[at - 1 : at + 2]
            for side, other, sense in ((left, right, 1), (right, left, -1)):
                if side.strip("|") == self.subject:
                    sense *= 1 if operator[0] == "<" else -1
                    self.bounds.append((sense, len(operator) == 1, side[0] == "|", Expression(other)))

    def __call__(self, names, value):
        if self.kind == "ascending":
            return value > names.frames[-1].get(self.subject, -1)
        if self.kind == "in":
            return value in self.choices(names)
        try:
            return self.holds(names)
        except ZeroDivisionError:
            return False

    def choices(self, names):
        found = set()
        for each in self.sets:
            found |= {each.strip('"')} if each[0] == '"' else names.all.get(each, set())
        return sorted(found)


def guard_of(text):
    if " in " in text:
        condition = Condition(text, {text.split(" ")[0]})
        return lambda names: names[condition.subject] in condition.choices(names)
    return Expression(text)


FIELD = re.compile(
    r"(?:\[(?P<guard>[^\]]*)\] )?(?:(?P<count>\w+|\([^)]*\)) \* )?"
    r"(?:<(?P<kind>[a-z0-9 ]+)(?:: (?P<name>\w+))?>|(?P<word>[a-z0-9][\w-]*))(?: |$)")


class Line:
    def __init__(self, pattern, remark):
        self.pattern, self.fields, at, absent = pattern, [], 0, set()
        while at < len(pattern):
            found = FIELD.match(pattern, at)
            if not found:
                raise ValueError("fields of the line are not in the notation: " + pattern[at:])
            at, guard, count = found.end(), found["guard"], found["count"]
            if guard and not re.search("[a-z]", guard) and not Expression(guard)({}):
                absent.add(found["name"])  # a parameter decides
                continue
            self.fields.append((guard and guard_of(guard), count and Expression(count), found["kind"], found["name"],
                                found["word"]))
        declared = {name for *_, name, _ in self.fields if name}
        pieces = [piece.strip() for piece in remark.split(";")]
        said = [bool(re.search(r"[<>=]| ascending$|^\w+ in (\"|[a-z](,|$))", piece)) for piece in pieces]
        if sorted(said, reverse=True) != said:
            raise ValueError("conditions come before words: " + remark)
        self.conditions = {name: [] for name in declared}
        for piece in pieces[: sum(said)]:
            condition = Condition(piece, declared | absent)
            if condition.subject not in absent:
                self.conditions[condition.subject].append(condition)
        self.first_word = self.fields[0][4]

    def walk(self, grammar, io, names):
        begun = False
        for guard, count, kind, name, word in self.fields:
            if guard and not guard(names):
                continue
            for _ in range(count(names) if count else 1):
                if not begun:
                    io.begin()
                    begun = True
                if word:
                    io.word(word)
                else:
                    io.value(kind, name, self.conditions.get(name, ()), names)
        if begun:
            io.end()


class Repeat:
    def __init__(self, count, turn, body):
        self.count, self.turn, self.body = Expression(count), turn, body

    def walk(self, grammar, io, names):
        names.frames.append({})
        for turn in range(1, self.count(names) + 1):
            if self.turn:
                names.turn[self.turn] = turn
            self.body.walk(grammar, io, names)
        names.turn.pop(self.turn, None)
        names.frames.pop()


class Call:
    def __init__(self, name, arguments):
        self.name, self.arguments, self.bodies = name, arguments, {}

    def find(self, grammar, names):
        for production in grammar.productions[self.name]:
            if production.guard is None or production.guard(names):
                if production not in self.bodies:
                    self.bodies[production] = production.body(self.arguments)
                return self.bodies[production]
        raise Refused("no production %s is for these values" % self.name)

    def walk(self, grammar, io, names):
        for part in self.find(grammar, names):
            part.walk(grammar, io, names)

    def every_part(self, grammar):
        for production in grammar.productions[self.name]:
            yield from self.bodies.setdefault(production, production.body(self.arguments))


class Guarded:
    def __init__(self, guard, optional, call, default):
        self.guard, self.optional, self.call, self.default = guard_of(guard), optional, call, default

    def walk(self, grammar, io, names):
        if self.guard(names) and (not self.optional or io.follows(self.call.find(grammar, names)[0].first_word)):
            return self.call.walk(grammar, io, names)
        if self.default:
            names.bind(self.default[0], int(self.default[1]))


def part_of(pattern, remark=""):
    found = re.fullmatch(r"(?:for (\w) = 1 \.\.\. (.+?)|(.+?) \*) \{ (.*) \}", pattern)
    if found:
        turn, last, count, body = found.groups()
        return Repeat(last or count, turn, part_of(body, remark))
    found = re.fullmatch(r"\[([^\]]*?)(, optional)?\] ([A-Z][A-Z_]+)", pattern)
    if found:
        default = re.match(r"without it (\w) = (\d+)", remark)
        return Guarded(found[1], found[2], Call(found[3], []), default and default.groups())
    found = re.fullmatch(r"([A-Z][A-Z_]+)(?: (.*))?", pattern)
    if found:
        return Call(found[1], re.split(r", | x ", found[2]) if found[2] else [])
    return Line(pattern, remark)


class Production:
    def __init__(self, parameters, guard, lines):
        self.parameters, self.guard, self.lines = parameters, guard and guard_of(guard), lines

    def body(self, arguments):
        if len(arguments) != len(self.parameters):
            raise ValueError("wrong number of values for %s" % self.parameters)
        put = dict(zip(self.parameters, arguments))
        word = re.compile(r"\b(%s)\b" % "|".join(put)) if put else re.compile(r"(?!)")
        return [part_of(*(word.sub(lambda found: put[found[1]], half) for half in line)) for line in self.lines]


class Grammar:
    def __init__(self, page):
        section = page.split("\n## Grammar\n")[1].split("\n## ")[0]
        self.productions, lines = {}, None
        for line in section.split("\n"):
            head = re.fullmatch(r"    ([A-Z][A-Z_]+)(?: ([a-z][\w, ]*))?(?: \[(.*)\])?:", line)
            body = re.fullmatch(r"    (?:  )?(\S.*?)(?:  +(\S.*))?", line)
            more = re.fullmatch(r" {20,}(\S.*)", line)
            if head:
                lines = []
                parameters = re.split(r", | x ", head[2]) if head[2] else []
                self.productions.setdefault(head[1], []).append(Production(parameters, head[3], lines))
            elif more:
                lines[-1] = (lines[-1][0], lines[-1][1] + " " + more[1])
            elif body:
                if lines is None:
                    lines = []
                    self.productions["MODEL"] = [Production([], None, lines)]
                lines.append((body[1], body[2] or ""))
        self.model = Call("MODEL", [])
        self.n_conditions = 0
        self.collect(self.model)

    def collect(self, part):
        """Counts the conditions."""
        if isinstance(part, Call):
            for each in part.every_part(self):
                self.collect(each)
        elif isinstance(part, Guarded):
            self.collect(part.call)
        elif isinstance(part, Repeat):
            self.collect(part.body)
        else:
            self.n_conditions += sum(len(found) for found in part.conditions.values())

    def walk(self, io):
        names = Names()
        self.model.walk(self, io, names)
        return names


class Reader:
    """Checks a text, the value of the checksum aside.
    shapes: of each line the fields, as 'word or kind or kind:name.
    bounded: of each condition the line, column and kind of the first value that it is on, and the bounds of it."""

    def __init__(self, grammar, text):
        self.bounded = {}
        self.lines, self.at, self.tokens, self.shapes = text.split("\n"), 0, [], []
        self.names = grammar.walk(self)
        if self.at != len(self.lines) - 1 or self.lines[-1]:
            raise Refused("text after the last line")

    def begin(self):
        if self.at >= len(self.lines) - 1:
            raise Refused("the text ends early")
        self.tokens, self.column = self.lines[self.at].split(" "), 0
        self.shapes.append([])

    def next(self, kind):
        if self.column >= len(self.tokens):
            raise Refused("line %d: value missing" % (self.at + 1))
        self.column += 1
        self.shapes[-1].append(kind)
        return self.tokens[self.column - 1]

    def word(self, word):
        found = self.next("'" + word)
        if found != word:
            raise Refused("line %d: expected %s, not %r" % (self.at + 1, word, found))

    def value(self, kind, name, conditions, names):
        if kind == "text":
            self.shapes[-1].append(kind)
            self.column = len(self.tokens)
            return
        value = value_of(kind, self.next(kind))
        if not name:
            return
        self.shapes[-1][-1] += ":" + name
        names.bind(name, value)
        for condition in conditions:
            if condition.bounds and condition not in self.bounded:
                limits = [sign * bound(names) for *_, size, bound in condition.bounds for sign in ((1, -1) if size else (1,))]
                self.bounded[condition] = (self.at, self.column - 1, kind, limits)
            if not condition(names, value):
                raise Refused("line %d: not %s" % (self.at + 1, condition.text))
        names.frames[-1][name] = value

    def end(self):
        if self.column < len(self.tokens):
            raise Refused("line %d holds more" % (self.at + 1))
        self.at += 1

    def follows(self, word):
        return self.lines[self.at].split(" ")[0] == word
