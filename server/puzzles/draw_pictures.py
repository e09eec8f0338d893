"""Draw the pictures of the puzzles of the program into their files: ``python -m server.puzzles.draw_pictures``.

Run it after a change of a puzzle, of the simulation or of the mapping; the test of ``codes_of`` fails until then.
"""

from __future__ import annotations

from mapper.puzzles import RECIPES
from server.library.packs.picture import write_codes
from server.puzzles.pictures import FOLDER, codes_of


def main() -> None:
    """Write a file for each puzzle, and remove the files of other puzzles."""
    FOLDER.mkdir(exist_ok=True)
    for file in FOLDER.glob("*.png"):
        if file.stem not in RECIPES:
            file.unlink()
    for name in RECIPES:
        write_codes(codes_of(name), FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
