"""Paths on costmaps: the cheapest one for a robot that fits where a cell is free, and how to drive it."""

from mapper.planning.parameters import PlannerConfig, PursuitConfig
from mapper.planning.plan import GoalPlanner, Path, plan_path
from mapper.planning.pure_pursuit import Command, follow_path

__all__ = ["Command", "GoalPlanner", "Path", "PlannerConfig", "PursuitConfig", "follow_path", "plan_path"]
