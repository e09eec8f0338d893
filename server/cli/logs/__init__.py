"""The contents and the quality of logs: ``info``, ``doctor``, ``check``, ``report`` and ``fleet``."""
