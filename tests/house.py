#!/usr/bin/env python3
"""Measures of the source tree, and the limits that they are held to.

    tests/house.py check    fails where a limit is passed, and names each place   (make check)
    tests/house.py size     lines of code in production, product and evidence      (make size)

What is measured:

* circles: files of one crate that import each other. A module and those below it are one idea and make none.
* functions: from the line of `fn` to its last brace, outside tests.
* names: types that share their name with another one, in other places than tests.
* columns: lines of Rust and Markdown over 120 columns; tables and lines with an address may be longer.
* sentences: words between full stops in Markdown and in comments of Rust; code and tables don't count.
* pages: bytes of Markdown, without pages and tables that a program writes.
* tiers: test programs that neither tier of the Makefile runs.
* size: lines of .rs that are neither blank, comment nor under `cfg(test)`, outside tests/, benches/, examples/, fuzz/.
"""

import pathlib
import re
import sys
from collections import defaultdict

ROOT = pathlib.Path(__file__).resolve().parent.parent

MOST_COLUMNS = 120
MOST_WORDS = 50

# What no change may raise.
LIMITS = {
    "circles": 5,
    "files in the largest circle": 3,
    "functions over 80 lines": 5,
    "types that share a name": 10,
    "lines over 120 columns": 0,
    "sentences over 50 words": 0,
    "bytes of Markdown": 350_000,
}

# Pages that came after the limit on Markdown was set; it rises for each.
LATER_PAGES = (
    "docs/real.md",
    "docs/guide/data-sheets.md",
    "docs/guide/older-datasets.md",
    "docs/guide/symptoms.md",
    "docs/guide/how-much-to-vary.md",
    "docs/guide/measure-wood.md",
    "docs/guide/tune.md",
)
LATER_PAGE_BYTES = 8_000
LIMITS["bytes of Markdown"] += LATER_PAGE_BYTES * len(LATER_PAGES)

# Reference models and studies: what shows that the product is right, and is none.
EVIDENCE = ("crates/evidence/",)

# Pages and folders that a program writes, or the heading below which it does.
GENERATED = {"output_schema/README.md": "", "recipes/README.md": "", "recipes/keys/": "", "docs/guide/faults.md": "## Faults"}


def files(*suffixes):
    """Paths of the tree's own files, relative, in order."""
    skipped = {"target", "out", ".git"}
    found = []
    for path in ROOT.rglob("*"):
        relative = path.relative_to(ROOT)
        if path.suffix in suffixes and not any(p in skipped or p.startswith(".venv") for p in relative.parts):
            found.append(relative.as_posix())
    return sorted(found)


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def is_production(name):
    parts = name.split("/")
    outside = {"tests", "benches", "examples", "fuzz"}
    return name.endswith(".rs") and not outside & set(parts) and parts[-1] not in ("tests.rs", "build.rs")


# What Rust's lexer sees as comments and literals; a quote may also begin a lifetime or a character.
TOKENS = re.compile(
    r"""(?P<comment>//[^\n]*)
    |(?P<block>/\*)
    |(?P<raw>\bb?r(?P<hashes>\#*)".*?"(?P=hashes))
    |(?P<text>"(?:\\.|[^"\\])*")
    |(?P<char>'(?:\\(?:x..|u\{[^}]*\}|.)|[^\\'\n])')""",
    re.VERBOSE | re.DOTALL,
)


def bare(text):
    """Rust without comments and without what stands in literals; lines keep their numbers.

    >>> bare('let a = "x // y"; // z\\nlet b: &\\'a str = r#"{"#;')
    'let a = ""; \\nlet b: &\\'a str = "";'
    """
    out, at = [], 0
    while match := TOKENS.search(text, at):
        out.append(text[at : match.start()])
        end = match.end()
        if match["block"]:
            depth = 1
            while depth and (step := re.compile(r"/\*|\*/").search(text, end)):
                depth += 1 if step[0] == "/*" else -1
                end = step.end()
            if depth:
                end = len(text)
        elif not match["comment"]:
            out.append("' '" if match["char"] else '""')
        out.append("\n" * text.count("\n", match.start(), end))
        at = end
    out.append(text[at:])
    return "".join(out)


def closing(code, start):
    """Index after the brace that closes the one at `start`."""
    depth = 0
    for match in re.compile(r"[{}]").finditer(code, start):
        depth += 1 if match[0] == "{" else -1
        if depth == 0:
            return match.end()
    return len(code)


def item_end(code, start):
    """Index after the item, field or argument that begins at `start`."""
    depth = 0
    for match in re.compile(r"[()\[\]{;,}]").finditer(code, start):
        sign = match[0]
        if sign == "{" and depth == 0:
            return closing(code, match.start())
        if sign in ";,}" and depth == 0:
            return match.end() - (sign == "}")
        depth += (sign in "([") - (sign in ")]")
    return len(code)


def without_tests(code):
    """Bare Rust with each item under `cfg(test)` blanked.

    >>> without_tests('fn a() {}\\n#[cfg(test)]\\nmod tests {\\n fn b() {}\\n}\\nfn c() {}').split()
    ['fn', 'a()', '{}', 'fn', 'c()', '{}']
    >>> without_tests('A { b, #[cfg(test)] c: d(e, f), g }')
    'A { b,  g }'
    """
    while match := re.search(r"#\[cfg\((?:test\b|all\([^\]]*\btest\b)[^\]]*\]", code):
        end = item_end(code, match.end())
        code = code[: match.start()] + re.sub(r"[^\n]", "", code[match.start() : end]) + code[end:]
    return code


def production():
    """Name and bare code of each file that is built into the program."""
    return {name: without_tests(bare(read(name))) for name in files(".rs") if is_production(name)}


def size(sources):
    """Lines of code by crate: those of the product, those of evidence."""
    product, evidence = defaultdict(int), defaultdict(int)
    for name, code in sources.items():
        crate = re.sub(r"/?src/.*", "", name) or "src"
        lines = sum(1 for line in code.splitlines() if line.strip())
        (evidence if name.startswith(EVIDENCE) else product)[crate] += lines
    return product, evidence


def long_functions(sources, most=80):
    found = []
    for name, code in sources.items():
        for match in re.finditer(r"\bfn\s+(\w+)", code):
            first = re.compile(r"[{;]").search(code, match.end())
            # An array's length has a semicolon too: `fn f() -> [f64; 2] {`.
            while first and first[0] == ";" and code.count("[", match.end(), first.start()) > code.count(
                "]", match.end(), first.start()
            ):
                first = re.compile(r"[{;]").search(code, first.end())
            if not first or first[0] == ";":
                continue
            lines = code.count("\n", match.start(), closing(code, first.start())) + 1
            if lines > most:
                line = code.count("\n", 0, match.start()) + 1
                found.append(f"{name}:{line}: {match[1]} has {lines} lines")
    return found


def shared_names(sources):
    places = defaultdict(list)
    for name, code in sources.items():
        for match in re.finditer(r"^(?:pub(?:\([^)]*\))? )?(?:struct|enum|trait|union|type) (\w+)", code, re.MULTILINE):
            places[match[1]].append(f"{name}:{code.count(chr(10), 0, match.start()) + 1}")
    return [f"{place}: {name}" for name, all_ in sorted(places.items()) if len(all_) > 1 for place in all_]


def spread(tree, prefix=""):
    """`a::{b, c::{d, e}}` as its paths.

    >>> spread('a::{b, c::{self, d as e}}')
    ['a::b', 'a::c::self', 'a::c::d as e']
    """
    parts, depth, start = [], 0, 0
    for at, sign in enumerate(tree):
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            parts.append(tree[start:at])
            start = at + 1
    found = []
    for part in map(str.strip, [*parts, tree[start:]]):
        head, brace, tail = part.partition("{")
        if brace:
            found += spread(tail.rstrip()[:-1], prefix + head)
        elif part:
            found.append(prefix + part)
    return found


USE = re.compile(r"^\s*(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);", re.MULTILINE)


class Modules:
    """The modules of one crate, and which of them each one names."""

    def __init__(self, sources):
        self.code, self.file = {}, {}
        for name, code in sources.items():
            path = name.split("src/", 1)[1][:-3].split("/")
            path = tuple(path[:-1] if path[-1] in ("mod", "lib", "main") else path)
            self.code[path], self.file[path] = code, name
        self.uses = {module: self.uses_of(code) for module, code in self.code.items()}

    @staticmethod
    def uses_of(code):
        """Names that a module imports: the path behind each, and whether it is passed on."""
        uses = {}
        for is_public, tree in USE.findall(code):
            for path in spread(tree):
                path, _, alias = path.partition(" as ")
                parts = path.strip().split("::")
                parts = parts[:-1] if parts[-1] == "self" else parts
                uses[alias.strip() or parts[-1]] = (parts, bool(is_public))
        return uses

    def names(self, module):
        """Paths that a module names, other than those that it only passes on."""
        yield from (parts for parts, is_public in self.uses[module].values() if not is_public)
        for path in re.findall(r"[A-Za-z_]\w*(?:::[A-Za-z_]\w*)+", USE.sub("", self.code[module])):
            yield path.split("::")

    def resolve(self, module, parts, depth=0):
        """The module in which the thing at a path is declared, if it is one of this crate."""
        if depth > 8 or not parts:
            return None
        parts, uses = list(parts), self.uses[module]
        if parts[0] in ("crate", "self", "super"):
            at = () if parts[0] == "crate" else module
            while parts and parts[0] in ("crate", "self", "super"):
                at = at[:-1] if parts.pop(0) == "super" else at
        elif module + (parts[0],) in self.code:
            at = module
        elif parts[0] in uses and uses[parts[0]][0] != parts:
            return self.resolve(module, uses[parts[0]][0] + parts[1:], depth + 1)
        else:
            return None
        while parts and at in self.code:
            if at + (parts[0],) in self.code:
                at += (parts.pop(0),)
            elif parts[0] in self.uses[at] and self.uses[at][parts[0]][1]:
                return self.resolve(at, self.uses[at][parts[0]][0] + parts[1:], depth + 1)
            else:
                break
        return at if at in self.code else None

    def imports(self, module):
        others = {self.resolve(module, parts) for parts in self.names(module)} - {None, module}
        related = {o for o in others if module[: len(o)] == o or o[: len(module)] == module}
        return others - related

    def circles(self):
        """Groups of modules that reach each other (Tarjan 1972)."""
        index, low, stack, found = {}, {}, [], []
        graph = {module: self.imports(module) for module in self.code}

        def visit(module):
            index[module] = low[module] = len(index)
            stack.append(module)
            for other in graph[module]:
                if other not in index:
                    visit(other)
                if other in stack:
                    low[module] = min(low[module], low[other])
            if low[module] == index[module]:
                group = stack[stack.index(module) :]
                del stack[stack.index(module) :]
                if len(group) > 1:
                    found.append(sorted(self.file[m] for m in group))

        for module in graph:
            if module not in index:
                visit(module)
        return found


def circles(sources):
    crates = defaultdict(dict)
    for name, code in sources.items():
        crates[name.split("src/", 1)[0]][name] = code
    return [circle for crate in crates.values() for circle in Modules(crate).circles()]


def is_generated(name, lines):
    """For each line of a page whether a program writes it: from a heading to the next, or all of the page."""
    heading = next((heading for place, heading in GENERATED.items() if name.startswith(place)), None)
    if heading is None:
        return [False] * len(lines)
    if heading == "":
        return [True] * len(lines)
    start = lines.index(heading)
    end = next((at for at in range(start + 1, len(lines)) if lines[at].startswith("## ")), len(lines))
    return [start < at < end for at in range(len(lines))]


def wide_lines():
    found = []
    for name in files(".rs", ".md"):
        lines = read(name).splitlines()
        for number, (line, generated) in enumerate(zip(lines, is_generated(name, lines)), 1):
            cells = line.strip().removeprefix("//").lstrip("/! ")
            is_table = cells.startswith("|") and cells.endswith("|")
            if len(line) > MOST_COLUMNS and "://" not in line and not is_table and not generated:
                found.append(f"{name}:{number}: {len(line)} columns")
    return found


def paragraphs(name, text):
    """Runs of prose with the line where each begins: of a page, or of the comments of a Rust file."""
    run, start, is_code = [], 0, False
    lines = text.splitlines()
    generated = is_generated(name, lines)
    for number, line in enumerate([*lines, ""], 1):
        if name.endswith(".md"):
            prose, starts = line, bool(re.match(r"\s*([-*] |\d+\. |#|>)", line))
        else:
            comment = re.match(r"\s*//[/!]?(?: (.*))?$", line)
            prose = (comment[1] or "") if comment else ""
            starts = bool(re.match(r"\s*([-*] |\d+\. |#)", prose))
        if prose.lstrip().startswith("```"):
            is_code, prose = not is_code, ""
        is_table = prose.lstrip().startswith("|") or prose.startswith("    ") or number <= len(lines) and generated[number - 1]
        if is_code or is_table or not prose.strip() or starts:
            if run:
                yield start, " ".join(run)
            run = []
        if not (is_code or is_table or not prose.strip()):
            start = start if run else number
            run.append(prose.strip())


def sentences(prose):
    """Sentences of a paragraph; code in backticks and addresses are one word.

    >>> [len(s.split()) for s in sentences('One `a b. c` is 0.5 mm long. Two: three? Four')]
    [6, 2, 1]
    """
    prose = re.sub(r"`[^`]*`", "X", prose)
    prose = re.sub(r"\]\([^)]*\)", "]", prose)
    return [part for part in re.split(r"(?<=[.?!])[\"')\]]*\s+(?=[\"'(\[*_`A-Z0-9])", prose) if part.strip()]


def long_sentences():
    found = []
    for name in files(".rs", ".md"):
        for line, prose in paragraphs(name, read(name)):
            words = [(len(re.findall(r"\S*\w\S*", s)), s) for s in sentences(prose)]
            found += [f"{name}:{line}: {n} words: {s[:60]}..." for n, s in words if n > MOST_WORDS]
    return found


def page_bytes():
    total = 0
    for name in files(".md"):
        lines = read(name).splitlines(keepends=True)
        generated = is_generated(name, [line.rstrip("\n") for line in lines])
        total += sum(len(line.encode()) for line, by_program in zip(lines, generated) if not by_program)
    return total


def linked_tests():
    """Places where the program would take something out of tests/."""
    found = [
        f"{name}: {match[0]}"
        for name in files(".rs")
        if is_production(name)
        for match in re.finditer(r'#\[path = "[^"]*tests/[^"]*"\]|include\w*!\([^)]*tests/[^)]*\)', without_literal_tests(name))
    ]
    for name in files(".toml"):
        if name.endswith("Cargo.toml") and not name.startswith(("tests/", "fuzz/")):
            for section in re.split(r"^\[", read(name), flags=re.MULTILINE):
                if section.startswith("dependencies") and re.search(r'path = "[^"]*tests', section):
                    found.append(f"{name}: a dependency lies in tests/")
    return found


def without_literal_tests(name):
    """A file's text up to its tests, with its literals."""
    return re.split(r"#\[cfg\(test\)\]", read(name))[0]


def tests_in_no_tier():
    """Test programs that neither `make check` nor `make check-rest` runs."""
    makefile = read("Makefile")
    first = re.search(r"^FIRST = (.*)$", makefile, re.MULTILINE)[1].split()
    run = {*first, *re.findall(r"--test ([a-z_]+)", makefile)}
    found = [re.search(r"(?:^|/)tests/([a-z_]+)(?:/main)?\.rs$", name) for name in files(".rs")]
    return sorted({match[1] for match in found if match} - run - {"tests"})


def check():
    sources = production()
    loops = circles(sources)
    lists = {
        "circles": [" <-> ".join(loop) for loop in loops],
        "files in the largest circle": max(loops, key=len, default=[]),
        "functions over 80 lines": long_functions(sources),
        "types that share a name": shared_names(sources),
        "lines over 120 columns": wide_lines(),
        "sentences over 50 words": long_sentences(),
        "parts of tests/ in the program": linked_tests(),
        "tests in no tier": tests_in_no_tier(),
    }
    counts = {what: len(places) for what, places in lists.items()}
    counts["bytes of Markdown"] = page_bytes()
    failed = False
    for what, count in counts.items():
        limit = LIMITS.get(what, 0)
        print(f"{what}: {count} of at most {limit}")
        if count > limit:
            failed = True
            print("".join(f"    {place}\n" for place in lists.get(what, [])), end="", file=sys.stderr)
    if failed:
        sys.exit("the tree passes a limit above; tests/house.py says what is counted")


def print_size():
    product, evidence = size(production())
    for what, crates in (("product", product), ("evidence", evidence)):
        for crate, lines in sorted(crates.items(), key=lambda item: -item[1]):
            print(f"{lines:7,}  {crate}")
        print(f"{sum(crates.values()):7,}  {what}\n")
    print(f"{sum(product.values()) + sum(evidence.values()):7,}  together")


if __name__ == "__main__":
    commands = {"check": check, "size": print_size}
    if len(sys.argv) != 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]]()
