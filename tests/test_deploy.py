"""The files of ``deploy/`` are read by the programs that they are for, and hold no secret and no registry."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.haproxy import CONFIGURATION, haproxy
from tests.programs import MissingProgramError

DEPLOY = Path(__file__).parents[1] / "deploy"


def test_haproxy_reads_its_configuration() -> None:
    try:
        program = haproxy()
    except MissingProgramError as missing:
        pytest.skip(str(missing))
    environment = os.environ | {"PORT": "8000", "REPLICAS": "localhost:8000"}
    done = subprocess.run(
        [program, "-c", "-f", CONFIGURATION], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr


def test_every_reference_of_the_manifest_leads_somewhere() -> None:
    found = [one for one in yaml.safe_load_all((DEPLOY / "kubernetes.yaml").read_text()) if one]
    pods = [one["spec"]["template"] for one in found if one["kind"] == "Deployment"]
    labels = [pod["metadata"]["labels"] for pod in pods]
    for one in found:
        if one["kind"] == "Service":
            assert one["spec"]["selector"] in labels
        if one["kind"] == "Deployment":
            assert one["spec"]["selector"]["matchLabels"] in labels
        if one["kind"] == "NetworkPolicy":
            assert one["spec"]["podSelector"]["matchLabels"] in labels
            assert all(peer["podSelector"]["matchLabels"] in labels for peer in one["spec"]["ingress"][0]["from"])
    names = [one["metadata"]["name"] for one in found if one["kind"] == "Service"]
    values = [pair["value"] for pod in pods for pair in pod["spec"]["containers"][0]["env"]]
    assert [value for value in values if value.endswith(":8000")] == [f"{names[0]}:8000"]
    for pod in pods:
        volumes = {one["name"] for one in pod["spec"]["volumes"]}
        assert {mount["name"] for mount in pod["spec"]["containers"][0]["volumeMounts"]} == volumes


def test_the_composition_has_all_that_it_names() -> None:
    found = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
    services = found["services"]
    for service in services.values():
        assert set(service.get("depends_on", ())) <= set(services)
        for volume in service.get("volumes", ()):
            source = volume.split(":")[0]
            assert (DEPLOY / source).exists() if source.startswith(".") else source in found["volumes"]
    assert services["proxy"]["environment"]["REPLICAS"] == "gridbloom:8000"
    assert (
        "postgresql://gridbloom:${POSTGRES_PASSWORD}@database/"
        in services["gridbloom"]["environment"]["GRIDBLOOM_DATABASE"]
    )


def test_nothing_is_fetched_from_a_stated_registry_and_no_secret_is_given() -> None:
    for file in DEPLOY.iterdir():
        text = file.read_text()
        for image in re.findall(r"image: (\S+)", text):
            assert "/" not in image, f"{file.name}: {image}"
        assert not re.search(r"(PASSWORD|TOKEN|SECRET_ACCESS_KEY): [^$\s]", text), file.name
