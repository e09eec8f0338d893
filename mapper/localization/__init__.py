"""Monte Carlo localization: pose of a robot in a reference map from odometry and scans."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later
from mapper.localization.parameters import PARAMETERS, LocalizationConfig

if TYPE_CHECKING:
    from mapper.localization.amcl_parameters import amcl_yaml, parse_amcl_yaml, read_amcl_yaml
    from mapper.localization.estimate import Estimate
    from mapper.localization.localize import Localized, localize_log
    from mapper.localization.monte_carlo import MonteCarloLocalizer

__all__ = [
    "PARAMETERS",
    "Estimate",
    "LocalizationConfig",
    "Localized",
    "MonteCarloLocalizer",
    "amcl_yaml",
    "localize_log",
    "parse_amcl_yaml",
    "read_amcl_yaml",
]

# The command imports only the parameters, for its options.
__getattr__ = imported_later(__name__, __file__)
