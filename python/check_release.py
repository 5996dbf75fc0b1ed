"""What `make release` made: whether it runs where glibc is old, how large it is; sums and notes beside it.

    python python/check_release.py FOLDER [LIBC.deb]

Every ELF file in its wheels and archives is asked for the newest symbol of glibc that it needs. With the package of
an old libc (Debian's libc6_*.deb) the program itself runs against that. FOLDER gets SHA256SUMS and NOTES.md.
"""

import hashlib
import io
import re
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection

ROOT = Path(__file__).resolve().parents[1]
NEWEST_GLIBC = (2, 28)
"""RHEL 8, Debian 10 and Ubuntu 18.10 have it."""
MOST_BYTES = 25_000_000
WRITTEN = ("SHA256SUMS", "NOTES.md")


def newest_glibc(content):
    """The newest version of glibc that an ELF file asks for."""
    found = [(0, 0)]
    for section in ELFFile(io.BytesIO(content)).iter_sections():
        if isinstance(section, GNUVerNeedSection):
            names = (part.name for _, parts in section.iter_versions() for part in parts)
            found += [tuple(map(int, match.groups())) for match in map(re.compile(r"GLIBC_(\d+)\.(\d+)").match, names) if match]
    return max(found)


def binaries(path):
    """ELF files of a wheel or an archive with their names."""
    if path.suffix == ".whl":
        with zipfile.ZipFile(path) as wheel:
            parts = {f"{path.name}/{name}": wheel.read(name) for name in wheel.namelist()}
    else:
        with tarfile.open(path) as archive:
            parts = {f"{path.name}/{part.name}": archive.extractfile(part).read() for part in archive if part.isfile()}
    return {name: content for name, content in parts.items() if content[:4] == b"\x7fELF"}


def runs_with(content, package):
    """Runs a program with the loader and the libraries of a package of libc; what it says of itself, and a sample."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program"
        program.write_bytes(content)
        program.chmod(0o755)
        subprocess.run(["dpkg-deb", "-x", package, folder], check=True)
        libraries = next(Path(folder).rglob("libc.so.6")).parent
        (loader,) = (path for path in libraries.iterdir() if re.fullmatch(r"ld-linux.*|ld-2.*", path.name) and not path.is_symlink())
        for support in ("libgcc_s.so.1",):
            own = subprocess.run(["cc", f"-print-file-name={support}"], capture_output=True, text=True, check=True).stdout.strip()
            (libraries / support).write_bytes(Path(own).read_bytes())
        start = [str(loader), "--library-path", str(libraries), str(program)]
        out = Path(folder) / "one.png"
        subprocess.run([*start, "preview", "--recipe", "wood-small", "--set", "scan.profiles=16", "--out", str(out)], check=True)
        assert out.read_bytes()[:4] == b"\x89PNG", out
        return subprocess.run([*start, "--version"], check=True, capture_output=True, text=True).stdout.strip()


def notes(version):
    """The section of CHANGELOG.md about a version."""
    text = (ROOT / "CHANGELOG.md").read_text()
    return f"# Sheetlight {version}\n" + text.split(f"## [{version}]", 1)[1].split("\n", 1)[1].split("\n## [", 1)[0].rstrip() + "\n"


def main():
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    folder = Path(sys.argv[1])
    files = sorted(path for path in folder.iterdir() if path.is_file() and path.name not in WRITTEN)
    if not files:
        raise SystemExit(f"{folder}: there is nothing to release; run make release")
    for path in files:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise SystemExit(f"{path}: {size} bytes, more than {MOST_BYTES}")
        for name, content in binaries(path).items():
            needed = newest_glibc(content)
            if needed > NEWEST_GLIBC:
                raise SystemExit(f"{name}: needs glibc {'.'.join(map(str, needed))}, newer than {'.'.join(map(str, NEWEST_GLIBC))}")
            print(f"{name}: {size / 1e6:.1f} MB, glibc {'.'.join(map(str, needed))}")
            if len(sys.argv) == 3 and path.suffix != ".whl":
                print(f"{name}: {runs_with(content, sys.argv[2])} with {Path(sys.argv[2]).name}")
    sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (folder / "SHA256SUMS").write_text("".join(sums))
    version = re.search(r'^version = "(.*)"$', (ROOT / "Cargo.toml").read_text(), re.M).group(1)
    (folder / "NOTES.md").write_text(notes(version))


if __name__ == "__main__":
    main()
