"""Path planning on costmaps for a robot at the centre of each cell, and path following."""

from mapper.planning.parameters import PlannerConfig, PursuitConfig
from mapper.planning.plan import GoalPlanner, Path, plan_path
from mapper.planning.pure_pursuit import Command, follow_path

__all__ = ["Command", "GoalPlanner", "Path", "PlannerConfig", "PursuitConfig", "follow_path", "plan_path"]
