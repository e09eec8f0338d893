"""Monte Carlo localization: where a robot is in a reference map, by its odometry and its scans."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import attributes_from
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
__getattr__ = attributes_from(
    __name__,
    {
        "Estimate": "mapper.localization.estimate",
        "Localized": "mapper.localization.localize",
        "MonteCarloLocalizer": "mapper.localization.monte_carlo",
        "amcl_yaml": "mapper.localization.amcl_parameters",
        "localize_log": "mapper.localization.localize",
        "parse_amcl_yaml": "mapper.localization.amcl_parameters",
        "read_amcl_yaml": "mapper.localization.amcl_parameters",
    },
)
