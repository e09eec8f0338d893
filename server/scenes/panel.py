"""viser's panel: controls for the parameters and for the session's clock.

A change in the panel is posted to the session; a change made elsewhere updates the control. A control that a user has
changed ignores other values of the session until the session confirms the change or :data:`CONFIRM_TIMEOUT_S` have
passed, which resets a refused value.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import viser
from msgspec import Struct

from mapper.core.parameter import Parameter
from server.scenes.axes_and_grid import OFF_AT_FIRST
from server.sessions.scene_controls import Choice, ParameterTable, SceneControls
from server.stream.commands import PauseCommand, PlayCommand, RestartCommand, SeekCommand

CONFIRM_TIMEOUT_S = 1.5  #: longest time for which a control shows a value that the session has not confirmed
Post = Callable[[Struct], None]


class ParameterControls:
    """One control for each row of a parameter table, in a folder for each group."""

    def __init__(self, gui: viser.GuiApi, table: ParameterTable, post: Post) -> None:
        self._post = post
        self._command = table.command
        self._handles: dict[str, Any] = {}
        self._rows: dict[str, Parameter] = {}
        self._chosen: dict[str, tuple[Any, float]] = {}  #: name → (chosen value, time at which it expires)
        groups: dict[str, list[Parameter]] = {}
        for row in table.rows:
            groups.setdefault(row.group, []).append(row)
        for group, members in groups.items():
            with gui.add_folder(group.capitalize(), expand_by_default=group in table.open_groups):
                for row in members:
                    self._rows[row.name] = row
                    self._handles[row.name] = self._control(gui, row, table.values[row.name])
        self._show_relevant(table.values)

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
            if event.client is None:  # changed by show(), not by a user
                return
            self._chosen[row.name] = (handle.value, time.monotonic() + CONFIRM_TIMEOUT_S)
            self._post(self._command(values={row.name: handle.value}))

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
        """Whether a change in the panel still waits for the session's confirmation."""
        return bool(self._chosen)

    def _show_relevant(self, values: Mapping[str, Any]) -> None:
        """Hide parameters that do not apply to the chosen model or kind of sensor."""
        chosen = values.get("model", values.get("kind"))
        for name, row in self._rows.items():
            if row.only_for:
                self._handles[name].visible = chosen in row.only_for


class Clock:
    """Buttons for play, pause and restart, and a slider over scans if the session can seek."""

    def __init__(self, gui: viser.GuiApi, controls: SceneControls, post: Post) -> None:
        self._playing = controls.playing
        self._play = gui.add_button(self._label(), color="teal")
        self._scan: Any = None
        self._sought: tuple[int, float] | None = None

        async def toggled(_: viser.GuiEvent[Any]) -> None:
            post(PauseCommand() if self._playing else PlayCommand())

        self._play.on_click(toggled)
        if controls.count is not None:
            count = max(controls.count, 1)
            self._scan = gui.add_slider("Scans in the map", 0, count, 1, min(controls.index, count))

            async def sought(event: viser.GuiEvent[Any]) -> None:
                if event.client is not None:
                    self._sought = (self._scan.value, time.monotonic() + CONFIRM_TIMEOUT_S)
                    post(SeekCommand(self._scan.value))

            self._scan.on_update(sought)

        async def restarted(_: viser.GuiEvent[Any]) -> None:
            post(RestartCommand())

        if controls.can_restart:
            gui.add_button("Restart", color="gray").on_click(restarted)

    def show(self, controls: SceneControls) -> None:
        """Show the state of the session's clock."""
        if controls.playing != self._playing:
            self._playing = controls.playing
            self._play.label = self._label()
        if self._scan is None or self._scan.value == controls.index:
            self._sought = None
        elif self._sought is None or time.monotonic() > self._sought[1]:
            self._sought = None
            self._scan.value = min(controls.index, int(self._scan.max))

    def _label(self) -> str:
        return "Pause" if self._playing else "Play"


class NamedChoice:
    """A choice between names, posted as its command with a ``name``."""

    def __init__(self, gui: viser.GuiApi, choice: Choice, post: Post) -> None:
        self._handle: Any = gui.add_dropdown(choice.label, choice.names, initial_value=choice.current)
        self._chosen: tuple[str, float] | None = None

        async def chosen(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:
                self._chosen = (self._handle.value, time.monotonic() + CONFIRM_TIMEOUT_S)
                post(choice.command(name=self._handle.value))

        self._handle.on_update(chosen)

    def show(self, name: str) -> None:
        """Show the session's choice, unless a user has just changed it."""
        if self._chosen is not None and name != self._chosen[0] and time.monotonic() < self._chosen[1]:
            return
        self._chosen = None
        self._handle.value = name


class Panel:
    """The whole panel: hint, clock, choices, switches, and a tab for each parameter table."""

    def __init__(self, gui: viser.GuiApi, controls: SceneControls, post: Post, switched: Callable[[], None]) -> None:
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(47, 150, 130))
        gui.set_panel_label("Gridbloom")
        gui.main_panel.dock_right()  # next to the scene, not over it
        if controls.hint:
            gui.add_markdown(controls.hint)
        self._clock = Clock(gui, controls, post)
        self._choices = {choice.label: NamedChoice(gui, choice, post) for choice in controls.choices}
        self.switches = VisibilitySwitches(gui, switched)
        self._tables: dict[str, ParameterControls] = {}
        if controls.tables:
            # The parameters have a separate panel: on a phone it stays closed, so that the scene is visible.
            panel = gui.add_panel()
            for table in controls.tables:
                with panel.add_tab(table.title):
                    self._tables[table.title] = ParameterControls(gui, table, post)
            panel.dock_below(gui.main_panel)

    def show(self, controls: SceneControls) -> None:
        """Move the controls to the session's values."""
        self._clock.show(controls)
        for choice in controls.choices:
            self._choices[choice.label].show(choice.current)
        for table in controls.tables:
            self._tables[table.title].show(table.values)

    @property
    def unsettled(self) -> bool:
        """Whether a parameter changed in the panel still waits for the session's confirmation."""
        return any(table.unsettled for table in self._tables.values())


class VisibilitySwitches:
    """A folder "Show" with a switch for each label of the scene's nodes."""

    def __init__(self, gui: viser.GuiApi, switched: Callable[[], None]) -> None:
        """Create the switches. ``switched`` is called when a user has used a switch (viser's thread)."""
        self._gui = gui
        self._switched = switched
        self._folder = gui.add_folder("Show", expand_by_default=False)
        self._switches: dict[str, Any] = {}
        self._nodes: dict[str, list[viser.SceneNodeHandle]] = {}

    def set_nodes(self, nodes: Iterable[tuple[str, viser.SceneNodeHandle]]) -> None:
        """Set the nodes and their labels. New nodes of a label that is switched off are hidden."""
        by_label: dict[str, list[viser.SceneNodeHandle]] = {}
        for label, node in nodes:
            by_label.setdefault(label, []).append(node)
        self._nodes = by_label
        for label in [label for label in self._switches if label not in by_label]:
            self._switches.pop(label).remove()
        for label, members in by_label.items():
            if label not in self._switches:
                self._switches[label] = self._add(label)
            for node in members:
                node.visible = self._switches[label].value

    @property
    def visible(self) -> dict[str, bool]:
        """Whether the nodes of each label are shown."""
        return {label: bool(switch.value) for label, switch in list(self._switches.items())}

    def switch(self, label: str, *, visible: bool) -> None:
        """Show or hide the nodes of a label. An unknown label is ignored."""
        switch = self._switches.get(label)
        if switch is not None and switch.value != visible:
            switch.value = visible
            self._apply(label)

    def _apply(self, label: str) -> None:
        for node in self._nodes.get(label, ()):
            with contextlib.suppress(RuntimeError):  # the node was removed in the meantime
                node.visible = self._switches[label].value

    def _add(self, label: str) -> viser.GuiInputHandle[bool]:
        with self._folder:
            switch = self._gui.add_checkbox(label, label not in OFF_AT_FIRST)

        async def switched(_: viser.GuiEvent[Any]) -> None:
            self._apply(label)
            self._switched()

        switch.on_update(switched)
        return switch
