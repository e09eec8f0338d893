"""Log doctor: defects of a log, their location, confidence and remedies."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.diagnosis.diagnosis import Diagnosis, diagnose, events_of
    from mapper.diagnosis.drifting import drift_finding, first_cause
    from mapper.diagnosis.events import Event, find_events
    from mapper.diagnosis.examination import CHECKS, examine
    from mapper.diagnosis.figures import MapFigures, map_figures
    from mapper.diagnosis.finding import Finding
    from mapper.diagnosis.verdict import Limits, Reason, Verdict, judge, named_findings

__all__ = [
    "CHECKS",
    "Diagnosis",
    "Event",
    "Finding",
    "Limits",
    "MapFigures",
    "Reason",
    "Verdict",
    "diagnose",
    "drift_finding",
    "events_of",
    "examine",
    "find_events",
    "first_cause",
    "judge",
    "map_figures",
    "named_findings",
]

__getattr__ = imported_later(__name__, __file__)
