"""The log doctor: what is wrong with a log, where, how surely, and what to do about it."""

from mapper.diagnosis.drifting import drift_finding
from mapper.diagnosis.examination import CHECKS, examine
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.verdict import Limits, Reason, Verdict, judge, named_findings

__all__ = [
    "CHECKS",
    "Finding",
    "Limits",
    "Reason",
    "Verdict",
    "drift_finding",
    "examine",
    "judge",
    "named_findings",
]
