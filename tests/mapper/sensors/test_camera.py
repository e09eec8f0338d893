"""Where the image of a lens has a place, against closed forms of the distortion models."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.sensors.camera import Intrinsics, Lens

WIDTH, HEIGHT = 200, 100
K = Intrinsics(WIDTH, HEIGHT, fx=100.0, fy=80.0, cx=99.5, cy=49.5)  # the axis is in the middle of the image
STRAIGHT = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def imaged(
    model: str, coefficients: Sequence[float], place: Sequence[float], turn: Sequence[float] = STRAIGHT
) -> tuple[float, float] | None:
    """Return where a place (3,) is imaged at the distance 1 from the lens; None: nowhere."""
    found = Lens(K, tuple(turn), model, tuple(coefficients)).shares(np.array(place))
    return None if found is None else ((found[0] - 0.5) * WIDTH / 100.0, (found[1] - 0.5) * HEIGHT / 80.0)


@pytest.mark.parametrize("model", ["plumb_bob", "rational_polynomial", "equidistant", "none", ""])
@pytest.mark.parametrize("coefficients", [(), (0.0,) * 5, (0.0,) * 14])
def test_coefficients_of_zero_are_a_pinhole(model: str, coefficients: Sequence[float]) -> None:
    assert imaged(model, coefficients, (0.6, -0.4, 2.0)) == pytest.approx((0.3, -0.2))


@pytest.mark.parametrize(
    ("model", "coefficients", "place", "wanted"),
    [
        # r = 1/2: 1 − 0.2/4 + 0.04/16 + 0.032/64 = 0.953
        ("plumb_bob", (-0.2, 0.04, 0.0, 0.0, 0.032), (0.5, 0.0, 1.0), (0.4765, 0.0)),
        ("plumb_bob", (-0.2, 0.04, 0.0, 0.0), (0.0, 1.0, 2.0), (0.0, 0.47625)),
        # x y = 0.12, r² = 0.25: 2 p1 x y + p2 (r² + 2 x²) and p1 (r² + 2 y²) + 2 p2 x y
        ("plumb_bob", (0.0, 0.0, 0.1, 0.0), (0.3, 0.4, 1.0), (0.3 + 0.024, 0.4 + 0.057)),
        ("plumb_bob", (0.0, 0.0, 0.0, 0.1), (0.3, 0.4, 1.0), (0.3 + 0.043, 0.4 + 0.024)),
        # equal polynomials above and below the line cancel, and 1 / (1 + 4 r²) halves r = 1/2
        ("rational_polynomial", (0.3, 0.2, 0.0, 0.0, 0.1, 0.3, 0.2, 0.1), (0.3, 0.4, 1.0), (0.3, 0.4)),
        ("rational_polynomial", (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), (0.5, 0.0, 1.0), (0.4, 0.0)),
        # 45° and 30° from the axis; tan 30° = 1/√3
        ("equidistant", (1e-12,), (1.0, 0.0, 1.0), (math.pi / 4, 0.0)),
        ("equidistant", (0.1, 0.0, 0.0, 0.0), (0.0, 1.0, 1.0), (0.0, math.pi / 4 + 0.1 * (math.pi / 4) ** 3)),
        ("equidistant", (0.0, 0.0, 0.0, 0.2), (-1.0, 0.0, math.sqrt(3.0)),
         (-(math.pi / 6 + 0.2 * (math.pi / 6) ** 9), 0.0)),
        ("equidistant", (0.1,), (0.0, 0.0, 1.0), (0.0, 0.0)),
    ],
)  # fmt: skip
def test_a_model_images_a_place_as_its_formula_says(
    model: str, coefficients: Sequence[float], place: Sequence[float], wanted: tuple[float, float]
) -> None:
    assert imaged(model, coefficients, place) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    ("model", "coefficients", "last"),
    [
        ("plumb_bob", (-0.25,), math.sqrt(4.0 / 3.0)),  # r − r³ / 4 is greatest there
        ("rational_polynomial", (0.0, 0.0, 0.0, 0.0, 0.0, 1.0), 1.0),  # and r / (1 + r²) there
        ("equidistant", (-1.0 / 3.0,), math.tan(1.0)),  # and θ − θ³ / 3 at 1 rad
    ],
)
def test_a_place_beyond_the_field_of_view_is_not_imaged_a_second_time(
    model: str, coefficients: Sequence[float], last: float
) -> None:
    assert imaged(model, coefficients, (0.98 * last, 0.0, 1.0)) is not None
    assert imaged(model, coefficients, (1.02 * last, 0.0, 1.0)) is None
    assert imaged(model, coefficients, (0.0, -3.0 * last, 1.0)) is None


def test_the_rectification_is_taken_back() -> None:
    c, s = math.cos(0.3), math.sin(0.3)
    turn = (c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c)  # the rectified camera looks 0.3 rad to one side
    # A place on the axis of the rectified camera is 0.3 rad to the side of the raw one.
    x, y = imaged("plumb_bob", (0.1,), (0.0, 0.0, 2.0), turn) or (0.0, 0.0)
    assert (abs(x), y) == pytest.approx((math.tan(0.3) * (1.0 + 0.1 * math.tan(0.3) ** 2), 0.0))
    x, _ = imaged("plumb_bob", (0.1,), (-s, 0.0, c), turn) or (9.0, 9.0)
    assert x == pytest.approx(0.0, abs=1e-9)
    assert imaged("plumb_bob", (), (1.0, 0.0, 0.01), turn) is None  # which is behind the raw camera


@pytest.mark.parametrize(
    ("model", "coefficients"), [("fisheye", (0.1,)), ("plumb_bob", (0.1, 0.0, 0.0, 0.0, 0.0, 0.1))]
)
def test_a_model_that_is_not_known_is_named(model: str, coefficients: Sequence[float]) -> None:
    with pytest.raises(ConfigError, match=f"{model}' of {len(coefficients)} coefficients"):
        imaged(model, coefficients, (0.1, 0.0, 1.0))


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ConfigError):
        Lens(K, STRAIGHT, "plumb_bob", (math.nan,))
