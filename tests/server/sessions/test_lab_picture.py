"""The picture of the lab's map, to which each tick adds the cells that changed, is that of the whole map."""

from __future__ import annotations

from mapper.grid import OccupancyGrid
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.tick import TickResult
from server.stream.grid_layer import GridLayer
from tests.server.begin import new_simulation


async def test_the_picture_after_many_ticks_is_that_of_the_whole_map(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "office", 5, playing=False)
    async with session.locked():
        model = session.model
        layer = model.layers[0]
        assert isinstance(layer, GridLayer)
        listed = 0
        for tick in range(60):
            result = TickResult()
            if tick == 30:
                model.handle(command_of({"type": "teleport", "x": 6.2, "y": 7.0, "yaw": 0.0}), result)
            model.advance(0.25 if tick % 7 == 0 else 0.1, result)  # several scans in some of the ticks
            listed += bool(result.cells) and not result.new_grid
            model.draw(result)
            layer.publish()
            assert layer.picture is not None
            grid: OccupancyGrid = model.grid
            whole = GridLayer("map", "Map")
            whole.update(grid, model.config, None, whole=True)
            whole.publish()
            assert whole.picture is not None
            assert layer.picture.cells.tobytes() == whole.picture.cells.tobytes()
        assert listed > 30
