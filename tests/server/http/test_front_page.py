"""The front page before its script runs, and what links to it show."""

from __future__ import annotations

import io
import re

import pytest
from PIL import Image

from tests.server.service import Service


@pytest.fixture
def html(service: Service) -> str:
    return service.http.get("/").text


def test_links_to_it_have_a_preview_with_an_absolute_address(service: Service, html: str) -> None:
    tags = dict(re.findall(r'<meta property="(og:[\w:]+)" content="([^"]+)">', html))
    assert tags["og:title"]
    assert tags["og:description"]
    assert tags["og:image"].startswith(f"http://127.0.0.1:{service.port}/")
    picture = Image.open(io.BytesIO(service.http.get(tags["og:image"]).content))
    assert picture.format == "PNG"
    assert picture.size == (int(tags["og:image:width"]), int(tags["og:image:height"]))
    assert len(picture.convert("RGB").getcolors(1 << 16) or []) > 10  # free, occupied and undecided cells


def test_its_first_pictures_are_in_its_html(service: Service, html: str) -> None:
    names = re.findall(r'(?:src|srcset)="(/assets/first-[\w.-]+)"', html)
    assert len(names) == 4  # world and map, in light and dark colours
    for name in names:
        answer = service.http.get(name)
        assert answer.status_code == 200
        if name.endswith(".png"):
            Image.open(io.BytesIO(answer.content)).verify()
        else:
            assert answer.text.startswith("<svg")


def test_an_unchanged_page_is_not_sent_again(service: Service) -> None:
    first = service.http.get("/")
    again = service.http.get("/", headers={"If-None-Match": first.headers["etag"]})
    assert again.status_code == 304
