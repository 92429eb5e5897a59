"""Structure of the Rust sources: imports without circles, files of a readable size, names that stand once.

    python3 tests/structure.py            what `make check` requires
    python3 tests/structure.py --lines    lines of Rust outside tests, crate by crate

A module is a file. File A imports file B where a `use` or a path in A names an item that B defines; re-exports
(`pub use`) are followed to the file that defines the item. Code behind `#[cfg(test)]` does not count.
"""

import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGEST = 400
ITEM = re.compile(
    r"^\s*pub(?:\([^)]*\))?\s+(?:(?:unsafe|const|async|extern\s+\"C\")\s+)*"
    r"(?:fn|struct|enum|trait|type|static|const|union|mod)\s+(?:mut\s+)?([A-Za-z_][A-Za-z0-9_]*)",
    re.M,
)
PUBLIC = re.compile(
    r"^pub\s+(?:(?:unsafe|const|async)\s+)*(?:fn|struct|enum|trait|type|static|const|union)\s+([A-Za-z_][A-Za-z0-9_]*)",
    re.M,
)
WORD = r"[A-Za-z_][A-Za-z0-9_]*"


def sources(crate):
    """The crate's files that are no tests."""
    files = sorted((crate / "src").rglob("*.rs"))
    return [f for f in files if "tests" not in f.parts and f.name not in ("tests.rs", "test.rs")]


def without_tests(text):
    """The text without comments, strings and what stands behind #[cfg(test)]."""
    text = re.sub(r"//[^\n]*", "", text)
    text = re.sub(r'"(?:\\.|[^"\\])*"', '""', text)
    kept, at = [], 0
    for found in re.finditer(r"#\[cfg\((?:all\()?test[^\]]*\]\s*", text):
        if found.start() < at:
            continue
        kept.append(text[at : found.start()])
        depth, end = 0, found.end()
        while end < len(text):
            c = text[end]
            depth += (c == "{") - (c == "}")
            end += 1
            if depth == 0 and c in "};":
                break
        at = end
    return "".join(kept) + text[at:]


def split_braces(text):
    """The parts of a brace list, split at its own commas."""
    parts, depth, last = [], 0, 0
    for at, c in enumerate(text):
        depth += (c == "{") - (c == "}")
        if c == "," and depth == 0:
            parts.append(text[last:at])
            last = at + 1
    return [p.strip() for p in [*parts, text[last:]] if p.strip()]


def expand(path):
    """`a::{b, c::d as e}` as the list of (path, name it gets)."""
    path = path.strip()
    brace = path.find("{")
    if brace < 0:
        path, _, alias = path.partition(" as ")
        parts = tuple(p.strip() for p in path.split("::"))
        if parts == ("self",):
            return [((), alias.strip())]
        return [(parts, alias.strip() or parts[-1])]
    head = tuple(p.strip() for p in path[:brace].rstrip(": ").split("::") if p.strip())
    inner = split_braces(path[brace + 1 : path.rfind("}")])
    found = [(head + parts, alias) for part in inner for parts, alias in expand(part)]
    return [(parts, alias or parts[-1]) for parts, alias in found]


class Crate:
    def __init__(self, folder):
        self.folder = folder
        self.modules = {}  # module path -> file
        self.text = {}
        for file in sources(folder):
            parts = file.relative_to(folder / "src").with_suffix("").parts
            if parts[-1] in ("lib", "main", "mod"):
                parts = parts[:-1]
            self.modules.setdefault(parts, file)
            self.text[parts] = without_tests(file.read_text())
        self.items = {m: set(ITEM.findall(t)) for m, t in self.text.items()}
        self.uses = {m: self._uses(m, t) for m, t in self.text.items()}
        self.exports = {
            m: {alias: path for path, alias, public in self.uses[m] if public} for m in self.modules
        }

    def _uses(self, module, text):
        found = []
        for public, path in re.findall(r"(?m)^\s*(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);", text):
            for parts, alias in expand(path):
                found.append((self._absolute(module, parts), alias, bool(public)))
        return [(p, a, public) for p, a, public in found if p is not None]

    def _absolute(self, module, parts):
        """A path from the crate's root, or none where it leads outside."""
        if parts[0] == "crate":
            return parts[1:]
        if parts[0] == "self":
            return module + parts[1:]
        if parts[0] == "super":
            up = 0
            while up < len(parts) and parts[up] == "super":
                up += 1
            return module[: len(module) - up] + parts[up:] if up <= len(module) else None
        if module + (parts[0],) in self.modules:
            return module + parts
        return None

    def home(self, path, seen=()):
        """The module that defines what a path names, re-exports followed."""
        if path in seen:
            return None
        for cut in range(len(path), -1, -1):
            module, rest = path[:cut], path[cut:]
            if module not in self.modules:
                continue
            if not rest:
                return module
            name = rest[0]
            if name in self.exports[module]:
                return self.home(self.exports[module][name] + rest[1:], (*seen, path))
            return module
        return None

    def arrows(self):
        """Module -> modules that it imports from."""
        arrows = collections.defaultdict(set)
        for module, text in self.text.items():
            paths = [p for p, _, public in self.uses[module] if not public]
            body = re.sub(r"(?m)^\s*(pub(?:\([^)]*\))?\s+)?use\s+[^;]+;", "", text)
            for found in re.findall(rf"\b({WORD}(?:::{WORD})+)", body):
                absolute = self._absolute(module, tuple(found.split("::")))
                if absolute is not None:
                    paths.append(absolute)
            for path in paths:
                home = self.home(path)
                if home is not None and home != module:
                    arrows[module].add(home)
        return arrows


def circles(arrows):
    """Strongly connected components of more than one module (Tarjan 1972)."""
    index, low, stack, found, on = {}, {}, [], [], set()

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        on.add(v)
        for w in sorted(arrows.get(v, ())):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in on:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            members = []
            while True:
                w = stack.pop()
                on.remove(w)
                members.append(w)
                if w == v:
                    break
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(10_000)
    for v in sorted(arrows):
        if v not in index:
            visit(v)
    return found


def crates():
    return [Crate(f.parent) for f in sorted(ROOT.glob("pipeline/*/Cargo.toml"))]


def name(module):
    return "::".join(module) or "lib"


def main():
    every = crates()
    if "--lines" in sys.argv:
        total = 0
        for crate in every:
            lines = sum(len(f.read_text().splitlines()) for f in sources(crate.folder))
            total += lines
            print(f"{lines:6} {crate.folder.name}")
        print(f"{total:6} in all")
        return 0
    faults = []
    for crate in every:
        arrows = crate.arrows()
        for members in circles(arrows):
            ties = [
                f"      {name(a)} -> {name(b)}" for a in members for b in sorted(arrows[a]) if b in members
            ]
            what = f"{crate.folder.name}: circle of {len(members)}: {', '.join(map(name, members))}"
            faults.append("\n".join([what, *ties]))
        for file in sources(crate.folder):
            lines = len(file.read_text().splitlines())
            if lines > LONGEST:
                faults.append(f"{file.relative_to(ROOT)}: {lines} lines, {LONGEST} at most")
    homes = collections.defaultdict(set)
    for crate in every:
        public = set()
        for module in crate.modules:
            for item in PUBLIC.findall(crate.text[module]):
                if crate_exports(crate, module, item):
                    public.add((item, f"{crate.folder.name}::{name(module)}"))
        for item, home in public:
            homes[item].add(home)
    for item, where in sorted(homes.items()):
        if len(where) > 1:
            faults.append(f"public name {item} stands in {', '.join(sorted(where))}")
    print("\n".join(faults))
    print(f"{len(every)} crates, {sum(len(c.modules) for c in every)} modules, {len(faults)} faults")
    return bool(faults)


def crate_exports(crate, module, item):
    """Whether an item can be named from outside of its crate: by public modules, or by a re-export."""
    private = [
        cut
        for cut in range(len(module))
        if not re.search(rf"^pub mod {module[cut]}\b", crate.text.get(module[:cut], ""), re.M)
    ]
    if not private:
        return True
    return any(
        path[-1] == item and crate.home(path) == module
        for cut in range(private[-1] + 1)
        for path in crate.exports.get(module[:cut], {}).values()
        if path
    )


if __name__ == "__main__":
    sys.exit(main())
