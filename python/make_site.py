"""The pages as one searchable site: `make site` runs it. Fails where a link leads nowhere.

Pages are written for readers of the repository, with links to sources and folders. A site has pages alone, so this
copies them to out/site-pages: links to other pages stay, and links to anything else go to the repository. README.md
becomes the first page; notebooks become pages, and every key of recipes is listed once. Zensical (or Material for MkDocs, which reads the same mkdocs.yml) then builds out/site.

    python python/make_site.py [--pages out/site-pages]
"""

import argparse
import json
import os
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("docs", "recipes", "output_schema")
PAGES = ("README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
CODE = re.compile(r"^```.*?^```$|`[^`\n]*`", re.S | re.M)
LIST = re.compile(r"(\s*)(?:[-*]|\d+\.) ")


def repository() -> str:
    """The address of the repository, as Cargo.toml has it."""
    return re.search(r'^repository = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1] + "/blob/main/"


def anchors(text: str) -> set[str]:
    """The anchors of a page's headings."""
    without_blocks = CODE.sub(lambda code: "" if "\n" in code[0] else code[0].strip("`"), text)
    heads = re.findall(r"^#+ (.*)$", without_blocks, re.M)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head).strip().lower() for head in heads)
    return {re.sub(r"[^\w\- ]", "", head).replace(" ", "-") for head in plain}


def place(page: str) -> str:
    """Where a page of the repository lies in the site."""
    if page == "README.md":
        return "index.md"
    folder, name = os.path.split(page.removeprefix("docs/"))
    return os.path.join(folder, "index.md" if name == "README.md" else name)


def blank_before_lists(text: str) -> str:
    """A list that follows a line of text at once, with the blank line between that Python-Markdown wants."""
    lines, fenced = [], False
    for line in text.split("\n"):
        fenced ^= line.startswith("```")
        before = lines[-1] if lines else ""
        if not fenced and LIST.match(line) and before.strip() and before[0] not in " |" and not LIST.match(before):
            lines.append("")
        lines.append(line)
    return "\n".join(lines)


def notebook(path: Path) -> str:
    """A notebook as a page: words as they are, code in blocks."""
    cells = json.loads(path.read_text())["cells"]
    texts = [("".join(cell["source"]).strip(), cell["cell_type"] == "code") for cell in cells]
    return "\n\n".join(f"```python\n{text}\n```" if is_code else text for text, is_code in texts if text) + "\n"


def key_index(pages: dict[str, str]) -> str:
    """Every key of a recipe by its path, in order, with its meaning and where it is explained."""
    keys = {}
    for page, text in pages.items():
        section = ""
        for line in text.splitlines():
            if head := re.match(r"#+ `([a-z_.]+)`(.*)", line):
                section, anchor = head[1], re.sub(r"[^\w\- ]", "", f"{head[1]}{head[2]}".lower()).replace(" ", "-")
            elif section and (row := re.match(r"\| `([a-z_0-9]+)` \| ([^|]*) \|", line)):
                keys[f"{section}.{row[1]}"] = (f"{os.path.basename(page)}#{anchor}", row[2])
    rows = [f"| [`{key}`]({link}) | {meaning} |" for key, (link, meaning) in sorted(keys.items())]
    head = "# Every key\n\nKeys of recipes in alphabetical order; the search above finds them too.\n\n| key | meaning |\n|---|---|\n"
    return head + "\n".join(rows) + "\n"


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--pages", type=Path, default=ROOT / "out" / "site-pages", help="where the pages go")
    target = arguments.parse_args().pages
    found = [path.relative_to(ROOT).as_posix() for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.md"))]
    texts = {page: (ROOT / page).read_text() for page in (*PAGES, *found)}
    for path in sorted((ROOT / "python" / "examples").glob("*.ipynb")):
        texts[f"docs/guide/notebook-{path.stem}.md"] = notebook(path)
    texts["recipes/keys/index.md"] = key_index({page: text for page, text in texts.items() if page.startswith("recipes/keys/")})
    heads = {page: anchors(text) for page, text in texts.items()}
    faults, links, outside = [], 0, repository()
    shutil.rmtree(target, ignore_errors=True)
    for page, text in texts.items():

        def turned(link: re.Match, page: str = page) -> str:
            nonlocal links
            path, sign, anchor = link[2].partition("#")
            if "://" in path:
                return link[0]
            links += 1
            to = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            if to in texts:
                if anchor and anchor not in heads[to]:
                    faults.append(f"{page}: {to} has no heading #{anchor}")
                to = os.path.relpath(place(to), os.path.dirname(place(page)))
            elif not (ROOT / to).exists():
                faults.append(f"{page}: nothing lies at {link[2]}")
            elif to.startswith("docs/pictures/"):
                to = os.path.relpath(to.removeprefix("docs/"), os.path.dirname(place(page)))
            else:
                to = outside + to
            return f"{link[1]}{to}{sign}{anchor}{link[3]}"

        path = target / place(page)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(blank_before_lists(LINK.sub(turned, text)))
    shutil.copytree(ROOT / "docs" / "pictures", target / "pictures")
    if faults:
        sys.exit("\n".join(faults))
    print(f"{len(texts)} pages, {links} links")


if __name__ == "__main__":
    main()
