"""Claim: the grammar in formats/model.md is exactly that of the program.

The blocks of the page are converted to a program (model_grammar.py). It accepts every text of the writer. For these
texts damaged in several hundred ways, with a number at a bound or just outside of it, and with other spellings of
numbers, its result is that of both readers of the program. The checksum is
always right. Conditions that the page states in words are in beyond_words and scaled_centers_overflow below.

Usage: grammar_of_model_text.py MODEL_MD MODEL_TEXTS
"""
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

from model_grammar import Grammar, Reader, Refused

MUTATIONS_PER_MODEL = 22  # of each of two kinds
MUTATED = ("linear", "modal", "modal-bounds", "modal-covered", "modal-fields", "modal-fields-levels", "modal-forces-only",
           "modal-levels",
           "modal-linear-points", "rbfn", "rbfn-finer", "rbfn-levels", "rbfn-linear-points")
CHECKSUM_LINE = len("checksum 0123456789abcdef\n")


def fnv(data):
    state = 0xCBF29CE484222325
    for byte in data:
        state = ((state ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return "%016x" % state


def with_checksum(body):
    return body + "checksum " + fnv(body.encode()) + "\n"


def accepts(grammar, text):
    try:
        return Reader(grammar, text)
    except Refused:
        return None


def is_number(shape):
    return shape.split(":")[0] in ("int", "signed", "float")


def rearranged(text, rng):
    """A line dropped, doubled or replaced by another one, or with a field more, less or set apart otherwise."""
    lines = text[: -CHECKSUM_LINE - 1].split("\n")
    for _ in range(MUTATIONS_PER_MODEL):
        at = rng.randrange(len(lines))
        line = lines[at]
        put = rng.choice([[], [line, line], [rng.choice(lines)], [line + " 1"], [line + " 1p+0"], [line + "s"], [line.rpartition(" ")[0]],
                          [line + " "], [" " + line], [line + "\r"], [line + "\t"], [line + "\n"], [line.replace(" ", "  ", 1)]])
        yield "'%s' -> %r" % (line, put), with_checksum("".join(each + "\n" for each in lines[:at] + put + lines[at + 1 :]))


INTS = ("0", "1", "2", "3", "00", "-0", "-00", "-1", "7", "12", "0000000003", "00000000003", "2147483647", "2147483648",
        "9999999999", "+1", "1.0", "0x1", "-32767", "-32768", "32768", "1,0", "")
FLOATS = ("0p+0", "-0p+0", "1p+0", "-1p+0", "1.8p-7", "1p-1022", "1p-1023", "0.8p-1022", "0.0000000000001p-1022",
          "0.8p-1021", "0.0p+0", "0p-0", "0p+0000", "0p+1", "0.0p-1022", "1.p+0", "1.80p+1", "1.00000000000000p+0",
          "2p+0", "0x1p+0", "1P+0", "1.Ap+0", "1p0", "1p+", "1p+0001", "1p+00001", "1p+1024", "1,8p+0", "nan", "inf",
          "-inf", "+1p+0", "--1p+0", "", "1", "1.5")
WORDS = ("a", "a" * 40, "a" * 41, "\x7f", "\u00e9", "!~")


def changed(grammar, text, rng):
    """One field replaced by another; what comes of it the grammar has to say."""
    lines = text[: -CHECKSUM_LINE - 1].split("\n")
    shapes = Reader(grammar, text).shapes[:-1]
    for _ in range(MUTATIONS_PER_MODEL):
        fields = []
        while not fields:
            at = rng.randrange(len(lines))
            fields = [i for i, shape in enumerate(shapes[at]) if is_number(shape) or shape.startswith("word")]
        column, tokens = rng.choice(fields), lines[at].split(" ")
        kind = shapes[at][column].split(":")[0]
        tokens[column] = rng.choice({"float": FLOATS, "word": WORDS}.get(kind, INTS))
        yield "'%s' -> %r" % (lines[at], tokens[column]), with_checksum("".join(
            line + "\n" for line in lines[:at] + [" ".join(tokens)] + lines[at + 1 :]))


def at_bounds(grammar, text, seen):
    """The first value of each condition put at each of its bounds, and beside it. A count is refused there in any case.
    @param seen  conditions that another text had"""
    lines, reader = text[: -CHECKSUM_LINE - 1].split("\n"), Reader(grammar, text)
    for condition, (at, column, kind, limits) in reader.bounded.items():
        if condition in seen:
            continue
        seen.add(condition)
        for limit in set(limits):
            near = [math.nextafter(limit, -math.inf), float(limit), math.nextafter(limit, math.inf)] if kind == "float" else [
                limit - 1, limit, limit + 1]
            for value in near:
                tokens = lines[at].split(" ")
                tokens[column] = text_of(kind, value)
                yield "%s with %s" % (lines[at], condition.text), with_checksum("".join(
                    line + "\n" for line in lines[:at] + [" ".join(tokens)] + lines[at + 1 :]))


def text_of(kind, value):
    """As std::to_chars writes it."""
    return re.sub(r"\.?0*p", "p", value.hex().replace("0x", ""), count=1) if kind == "float" else str(value)


def block(text, keyword, end):
    return [[float.fromhex(field) for field in line.split(" ") if "p" in field] for line in
            text.split("\n%s " % keyword)[1].split("\n%s " % end)[0].split("\n")[1:]]


def scaled_centers_overflow(text):
    """In words: "scaled centers are finite". Numbers of size 1e-290 or 1e290 may break that."""
    sizes = [abs(float.fromhex(field)) for field in re.findall(r"-?[01](?:\.[0-9a-f]+)?p[+-]\d+", text)]
    return "\nfamily rbfn\n" in text and any(size > 1e290 or 0 < size < 1e-290 for size in sizes)


def shares_leave_nothing(text):
    """In words: the sum of the shares is below 1, for both readers."""
    rows = text.split("\nrelaxation ")[1:]
    if not rows:
        return False
    lines = rows[0].split("\n")
    return sum(float.fromhex(line.split(" ")[0]) for line in lines[2 : 2 + int(lines[0])]) >= 1


def beyond_words(text):
    """In words: what the C interface refuses besides."""
    if "\nfamily modal\n" not in text:
        return scaled_centers_overflow(text)
    reach = float.fromhex(text.split("\nmax_displacement_m ")[1].split("\n")[0])
    far = any(abs(x) > 1e3 * reach for row in block(text, "displacements", "fixed") for x in row)
    return far or not 1e-90 <= reach <= 1e90


def judge(program, texts):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "texts"
        file.write_bytes(b"".join(b"%d\n%s" % (len(text.encode()), text.encode()) for _, text in texts))
        judged = subprocess.run([program, "judge", file], check=True, capture_output=True, text=True)
    said = judged.stdout.split("\n")[:-1]
    if len(said) != len(texts):
        sys.exit("%d texts, %d verdicts" % (len(texts), len(said)))
    return [tuple(word == "yes" for word in line.split(" ")) for line in said]


def texts_of_writer(program):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "write", folder], check=True)
        return {file.name: file.read_bytes().decode() for file in sorted(pathlib.Path(folder).iterdir())}


TITLES = ("title", "title ", "title  two spaces ", "title \u00e9", "titles x", " title x", "title\tx", "title ; 1p+0")


def titled(grammar, text):
    for title in TITLES:
        yield "title %r" % title, with_checksum(re.sub("\ntitle[^\n]*", "\n" + title, text[:-CHECKSUM_LINE], count=1))


def from_writer(grammar, program, failures):
    """The writer's texts changed, after the page has accepted them as they are."""
    seen = set()
    for name, text in texts_of_writer(program).items():
        try:
            Reader(grammar, text)
        except Refused as refusal:
            failures.append("the page refuses what the writer makes: %s: %s" % (name, refusal))
            continue
        if with_checksum(text[:-CHECKSUM_LINE]) != text:
            failures.append("checksum of " + name)
        if name not in MUTATED:
            continue
        rng = random.Random(name)
        for what, other in [*rearranged(text, rng), *changed(grammar, text, rng), *titled(grammar, text), *at_bounds(grammar, text, seen)]:
            yield "%s, %s" % (name, what), other


def main():
    grammar = Grammar(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    program, failures, accepted = sys.argv[2], [], 0
    texts = [*from_writer(grammar, program, failures)]
    for (what, text), (host, runtime) in zip(texts, judge(program, texts)):
        page = bool(accepts(grammar, text))
        accepted += page
        says = "accepts" if page else "refuses"
        for reader, said, in_words in (("host", host, scaled_centers_overflow), ("runtime", runtime, beyond_words)):
            if said != page and not (page and (in_words(text) or shares_leave_nothing(text))):
                failures.append("%s: the page %s it, the %s does not" % (what, says, reader))
    print("%d conditions, %d texts, %d of them models" % (grammar.n_conditions, len(texts), accepted))
    for failure in failures[:40]:
        print("FAILED: " + failure)
    sys.exit(bool(failures))


main()
