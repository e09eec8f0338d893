"""The log doctor: what is wrong with a log, where, how surely, and what to do about it."""

from mapper.doctor.drifting import drift_finding
from mapper.doctor.examination import CHECKS, examine
from mapper.doctor.finding import Finding

__all__ = ["CHECKS", "Finding", "drift_finding", "examine"]
