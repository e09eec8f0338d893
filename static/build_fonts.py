"""Makes static/.fonts: the pages' fonts, cut down to what the pages can show.

The fonts come from npm packages that package.json names. Each face becomes one woff2 file with the characters below,
only the weights that the style uses, and a family name of its own: "Source" is a reserved name, which the SIL Open
Font License keeps for the unchanged fonts. The licences are written beside the files.
"""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path
from typing import NamedTuple

from fontTools import subset
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables._c_m_a_p import CmapSubtable
from fontTools.varLib import instancer

STATIC = Path(__file__).parent
PACKAGES = STATIC / "node_modules"
FONTS = STATIC / ".fonts"

#: ASCII, Latin-1, and the punctuation of typeset text
TEXT = frozenset([*range(0x20, 0x7F), *range(0xA0, 0x100), *map(ord, "‘’‚“”„–—…•−′″€ŒœŠšŽžŸŁł")])
GREEK = frozenset(map(ord, "ΔΓΘΛΞΠΣΦΨΩαβγδεζηθικλμνξοπρστυφχψω"))
#: what formulas in text have
SIGNS = frozenset(map(ord, "ℓ←↑→↓↔∂∏∑√∞∩∫≈≠≤≥×÷±¬ⁿ⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺₀₁₂₃₄₅₆₇₈₉₊₋ᵀ✓"))
#: what MathML has, and the signs that the text font lacks
MATH = frozenset(
    [
        *map(ord, " ()[]{}|+−=<>·,:;/¬"),
        *map(ord, "ℓ←→∇∂∈∏∑√∝∞∣∥∧∨∩∪∫≈≠≤≥⊕⋅∗∘±×⟨⟩⏞⏟⎴⎵"),
    ]
)
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
#: MathML shows a variable of one letter by a character of its own, U+1D434 …; the italic h has another place
ITALIC_OF = {0x210E if letter == "h" else 0x1D434 + i: ord(letter) for i, letter in enumerate(_LETTERS)}
#: OpenType features: kerning, ligatures, accents; figures of one width, which `tabular-nums` asks for
FEATURES = ("kern", "liga", "ccmp", "locl", "mark", "mkmk", "tnum")


class Face(NamedTuple):
    """One file: its name, its source below node_modules, what it holds, and the weights (None: the source has one)."""

    name: str
    source: str
    characters: frozenset[int]
    weights: tuple[int, int] | int | None = None
    #: characters that the glyphs of others show: these are the face's, if there are any
    shown_by: dict[int, int] | None = None

    @property
    def package(self) -> Path:
        """The npm package that the source is in."""
        parts = Path(self.source).parts
        return PACKAGES.joinpath(*parts[: 2 if parts[0].startswith("@") else 1])


_SERIF = "@fontsource-variable/source-serif-4/files/source-serif-4"
FACES = (
    Face("sans", "source-sans/VF/SourceSans3VF-Upright.ttf", TEXT | GREEK | SIGNS, (400, 700)),
    Face("serif", f"{_SERIF}-latin-wght-normal.woff2", TEXT, (400, 650)),
    Face("serif-greek", f"{_SERIF}-greek-wght-normal.woff2", GREEK, (400, 650)),
    Face("serif-italic", f"{_SERIF}-latin-wght-italic.woff2", TEXT, 400),
    Face("mono", "@fontsource/source-code-pro/files/source-code-pro-latin-400-normal.woff2", TEXT),
    Face("math-italic", f"{_SERIF}-latin-wght-italic.woff2", frozenset(ITALIC_OF.values()), 400, ITALIC_OF),
    Face("math", "@fontsource/noto-sans-math/files/noto-sans-math-latin-400-normal.woff2", MATH),
)


def make_face(face: Face, to: Path) -> None:
    """Write the woff2 file of a face into the folder ``to``."""
    options = subset.Options()
    options.layout_features = list(FEATURES)
    options.name_IDs = [0, 13, 14]  # copyright and licence
    options.hinting = False
    options.notdef_outline = True
    font = TTFont(PACKAGES / face.source)
    cutter = subset.Subsetter(options)
    cutter.populate(unicodes=face.characters)
    cutter.subset(font)
    if face.weights is not None:
        font = instancer.instantiateVariableFont(font, {"wght": face.weights})
    if face.shown_by:
        glyphs = font.getBestCmap()
        table = CmapSubtable.newSubtable(12)  # others have no characters beyond U+FFFF
        table.platformID, table.platEncID, table.language = 3, 10, 0
        table.cmap = {shown: glyphs[by] for shown, by in face.shown_by.items()}
        font["cmap"].tables = [table]
    for name_id in (1, 4, 6):
        font["name"].setName(f"Gridbloom{'' if name_id == 6 else ' '}{face.name}", name_id, 3, 1, 0x409)
    font.flavor = "woff2"
    font.save(to / f"{face.name}.woff2")


def digest_of_fonts() -> str:
    """Return a digest of what the fonts are made of: this program, and the packages' versions."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for package in sorted({face.package for face in FACES}):
        digest.update((package / "package.json").read_bytes())
    return digest.hexdigest()


def build_fonts(to: Path = FONTS) -> bool:
    """Bring the folder of fonts up to date; return whether anything had to be made. node_modules must be complete."""
    stamp, digest = to / ".digest", digest_of_fonts()
    if stamp.is_file() and stamp.read_text() == digest:
        return False
    shutil.rmtree(to, ignore_errors=True)
    to.mkdir(parents=True)
    for face in FACES:
        make_face(face, to)
    licences = [
        f"{package.relative_to(PACKAGES)}\n\n{licence.read_text()}"
        for package in sorted({face.package for face in FACES})
        for licence in sorted(package.glob("LICENSE*"))
    ]
    (to / "LICENSES.txt").write_text("\n\n\n".join(licences))
    stamp.write_text(digest)
    return True
