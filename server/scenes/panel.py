"""viser's panel: controls for the parameters and for the session's clock.

A change made here is posted to the session; a change made elsewhere moves the control. A control that a user has
changed ignores other values of the session until the session confirms it, or until :data:`PATIENCE_S` have passed:
a refused value is then reset.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import viser

from mapper.core.parameter import Parameter

PATIENCE_S = 1.5  #: seconds for which the session may disagree with what a person chose here
Post = Callable[[dict[str, Any]], None]


class ParameterControls:
    """One control for each row of a parameter table, in a folder for each group.

    ``command`` is the type of the session's command that takes ``values``: "parameters" or "sensor".
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        rows: Iterable[Parameter],
        values: Mapping[str, Any],
        post: Post,
        command: str,
        *,
        open_groups: tuple[str, ...] = (),
    ) -> None:
        self._post = post
        self._command = command
        self._handles: dict[str, Any] = {}
        self._rows: dict[str, Parameter] = {}
        self._chosen: dict[str, tuple[Any, float]] = {}  #: name → (what was chosen here, when it stops to count)
        groups: dict[str, list[Parameter]] = {}
        for row in rows:
            groups.setdefault(row.group, []).append(row)
        for group, members in groups.items():
            with gui.add_folder(group.capitalize(), expand_by_default=group in open_groups):
                for row in members:
                    self._rows[row.name] = row
                    self._handles[row.name] = self._control(gui, row, values[row.name])
        self._show_relevant(values)

    def _control(self, gui: viser.GuiApi, row: Parameter, value: float | str | bool) -> viser.GuiInputHandle[Any]:
        label = f"{row.label} ({row.unit})" if row.unit else row.label
        handle: viser.GuiInputHandle[Any]
        if row.kind == "number":
            handle = gui.add_slider(label, row.low, row.high, row.step, float(value), hint=row.sentence)
        elif row.kind == "choice":
            handle = gui.add_dropdown(label, row.choices, initial_value=str(value), hint=row.sentence)
        else:
            handle = gui.add_checkbox(label, bool(value), hint=row.sentence)

        async def chosen(event: viser.GuiEvent[Any]) -> None:
            if event.client is None:  # moved by show(), not by a person
                return
            self._chosen[row.name] = (handle.value, time.monotonic() + PATIENCE_S)
            self._post({"type": self._command, "values": {row.name: handle.value}})

        handle.on_update(chosen)
        return handle

    def show(self, values: Mapping[str, Any]) -> None:
        """Move the controls to the session's ``values``, except those that a user has just changed."""
        now = time.monotonic()
        for name, handle in self._handles.items():
            value = values[name]
            chosen = self._chosen.get(name)
            if chosen is not None:
                if value != chosen[0] and now < chosen[1]:
                    continue
                del self._chosen[name]
            if handle.value != value:
                handle.value = value
        self._show_relevant(values)

    @property
    def unsettled(self) -> bool:
        """Whether a change made here still waits for the session's confirmation."""
        return bool(self._chosen)

    def _show_relevant(self, values: Mapping[str, Any]) -> None:
        """Hide what does not concern the chosen model, or kind of sensor."""
        chosen = values.get("model", values.get("kind"))
        for name, row in self._rows.items():
            if row.only_for:
                self._handles[name].visible = chosen in row.only_for


class Clock:
    """Buttons for play, pause and restart, and for a log a slider over its scans."""

    def __init__(self, gui: viser.GuiApi, post: Post, *, count: int | None, playing: bool, index: int) -> None:
        self._post = post
        self._play = gui.add_button("Pause" if playing else "Play", color="teal")
        self._playing = playing
        self._scan: Any = None
        self._sought: tuple[int, float] | None = None

        async def toggled(_: viser.GuiEvent[Any]) -> None:
            post({"type": "pause" if self._playing else "play"})

        self._play.on_click(toggled)
        if count is not None:
            self._scan = gui.add_slider("Scans in the map", 0, max(count, 1), 1, min(index, max(count, 1)))

            async def sought(event: viser.GuiEvent[Any]) -> None:
                if event.client is not None:
                    self._sought = (self._scan.value, time.monotonic() + PATIENCE_S)
                    post({"type": "seek", "index": self._scan.value})

            self._scan.on_update(sought)

        async def restarted(_: viser.GuiEvent[Any]) -> None:
            post({"type": "restart"})

        gui.add_button("Start again", color="gray").on_click(restarted)

    def show(self, *, playing: bool, index: int) -> None:
        """Show the state of the session's clock."""
        if playing != self._playing:
            self._playing = playing
            self._play.label = "Pause" if playing else "Play"
        if self._scan is None or self._scan.value == index:
            self._sought = None
        elif self._sought is None or time.monotonic() > self._sought[1]:
            self._sought = None
            self._scan.value = min(index, int(self._scan.max))


class NamedChoice:
    """One of several names: the world, or the log's trajectory. A choice is posted as ``command`` with a ``name``."""

    def __init__(
        self, gui: viser.GuiApi, label: str, names: Sequence[str], current: str, post: Post, command: str
    ) -> None:
        self._handle: Any = gui.add_dropdown(label, names, initial_value=current)
        self._chosen: tuple[str, float] | None = None

        async def chosen(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:
                self._chosen = (self._handle.value, time.monotonic() + PATIENCE_S)
                post({"type": command, "name": self._handle.value})

        self._handle.on_update(chosen)

    def show(self, name: str) -> None:
        """Show the session's choice, unless a user has just made another."""
        if self._chosen is not None and name != self._chosen[0] and time.monotonic() < self._chosen[1]:
            return
        self._chosen = None
        self._handle.value = name


def add_layers(gui: viser.GuiApi, layers: Mapping[str, viser.SceneNodeHandle]) -> None:
    """Add a switch for each named layer of the scene (a scene node handle)."""
    with gui.add_folder("Show", expand_by_default=False):
        for title, node in layers.items():
            _add_switch(gui, title, node)


def _add_switch(gui: viser.GuiApi, title: str, node: viser.SceneNodeHandle) -> None:
    switch = gui.add_checkbox(title, True)

    async def switched(_: viser.GuiEvent[Any]) -> None:
        node.visible = switch.value

    switch.on_update(switched)
